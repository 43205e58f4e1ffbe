// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sums over the contact set, and the balance of the free motions.

use std::array::from_fn;

use super::Mode;
use super::sums::Spans;

/// Solves the small symmetric system `a x = b`; directions without stiffness get zero.
pub(super) fn solve_small(a: &[[f64; 3]; 3], b: [f64; 3], m: usize) -> [f64; 3] {
    let (mut a, mut b) = (*a, b);
    let mut used = [usize::MAX; 3];
    let mut free: Vec<usize> = (0..m).collect();
    let scale: [f64; 3] = std::array::from_fn(|k| a[k][k]);
    while let Some(&pivot) = free.iter().max_by(|i, j| {
        let relative = |k: usize| a[k][k] / scale[k].max(f64::MIN_POSITIVE);
        relative(**i).total_cmp(&relative(**j))
    }) {
        free.retain(|k| *k != pivot);
        if a[pivot][pivot] <= 1e-12 * scale[pivot] || a[pivot][pivot] <= 0.0 {
            continue;
        }
        used[pivot] = pivot;
        for k in 0..m {
            if k != pivot && (free.contains(&k) || used[k] == k) {
                let factor = a[k][pivot] / a[pivot][pivot];
                for j in 0..m {
                    a[k][j] -= factor * a[pivot][j];
                }
                b[k] -= factor * b[pivot];
            }
        }
    }
    std::array::from_fn(|k| {
        if k < m && used[k] == k {
            b[k] / a[k][k]
        } else {
            0.0
        }
    })
}

/// Largest share of the balance that may be missed.
const BALANCED: f64 = 1e-6;

/// Share of it that rounding leaves.
const EXACT: f64 = 1e-12;

/// The larger of two shares; one that is no number is the worst of all.
fn worse(worst: f64, share: f64) -> f64 {
    if share <= worst { worst } else { share }
}

/// Restores the balance `N^T p = f` by factors `1 + (1 - p / cap) N y` on the pressures, cutting off what turns
/// negative or passes the cap; false where no such factors are found. The pressures vanish outside of `set`, which
/// `spans` hold.
pub(super) fn balance(
    modes: &[Mode],
    p: &mut [f64],
    cap: f64,
    spans: &Spans,
    set: &[bool],
) -> bool {
    if modes.is_empty() {
        return true;
    }
    let mut worst = f64::INFINITY;
    for _ in 0..30 {
        // sums, the same without cancellation, and the stiffness against factors
        let (mut sum, mut size, mut gram) = ([0.0; 3], [0.0; 3], [[0.0; 3]; 3]);
        for (k, mode) in modes.iter().enumerate() {
            let moments = |[]: [f64; 0], [p, n]: [f64; 2], _: bool| {
                let part = p * n;
                ([], [part, part.abs(), part * n * (1.0 - p / cap)])
            };
            [sum[k], size[k], gram[k][k]] = spans.sum([], [p, &mode.shape], set, moments);
            for (l, other) in modes[..k].iter().enumerate() {
                let product = |[]: [f64; 0], [n, m, p]: [f64; 3], _: bool| {
                    ([], [n * m * p * (1.0 - p / cap)])
                };
                [gram[k][l]] = spans.sum([], [&mode.shape, &other.shape, p], set, product);
                gram[l][k] = gram[k][l];
            }
        }
        let mut missing = [0.0; 3];
        worst = 0.0_f64;
        for (k, mode) in modes.iter().enumerate() {
            missing[k] = mode.target - sum[k];
            let size = size[k] + mode.target.abs();
            if size > 0.0 {
                worst = worse(worst, missing[k].abs() / size);
            }
        }
        if worst <= 1e-14 {
            return true;
        }
        if worst.is_nan() {
            break;
        }
        let y = solve_small(&gram, missing, modes.len());
        if y.iter().all(|y| *y == 0.0) {
            break;
        }
        // a motion that is none leaves its share of the factors out
        let shapes = from_fn(|k| modes.get(k).unwrap_or(&modes[0]).shape.as_slice());
        let scale = |[p]: [f64; 1], [n, m, l]: [f64; 3], _: bool| {
            let factor = 1.0 + (1.0 - p / cap) * (y[0] * n + y[1] * m + y[2] * l);
            ([(p * factor.max(0.0)).min(cap)], [])
        };
        spans.sum([p], shapes, set, scale);
    }
    // tilts at the edge of what is possible: the last digits are left to the next step
    worst <= BALANCED
}

/// Directions in which a [`Projection`] looks for the shift, and lengths along each of them.
const SHIFTS: usize = 20;
const LENGTHS: usize = 24;

/// Directions where the corners of the bounds are rounded: the next rounding is near.
const SHIFTS_ROUNDED: usize = 5;

/// Share of the rounding that is left from one to the next, and of the cap at the last.
const SHARPER: f64 = 0.2;
const SHARP: f64 = 1e-8;

/// Shifts the pressures of `set`, which `spans` hold, by the motions and cuts them off at zero and at the cap, such that
/// they meet the balance, of which other points carry `held`: the nearest pressures that do. The shift by each of the
/// motions, `None` where none is found that does.
pub(super) fn project(
    modes: &[Mode],
    p: &mut [f64],
    cap: f64,
    held: [f64; 3],
    spans: &Spans,
    set: &[bool],
) -> Option<[f64; 3]> {
    // a motion that is none has no share of the shift
    let none = vec![0.0; if modes.is_empty() { p.len() } else { 0 }];
    let shapes: [&[f64]; 3] = from_fn(|k| match (modes.get(k), modes.first()) {
        (Some(mode), _) | (None, Some(mode)) => mode.shape.as_slice(),
        (None, None) => none.as_slice(),
    });
    let shape = |k: usize| modes.get(k).map(|mode| mode.shape.as_slice());
    let whole = from_fn(|k| {
        from_fn(|l| match (shape(k), shape(l)) {
            (Some(n), Some(m)) => spans.dot_in(n, m, set),
            _ => 0.0,
        })
    });
    let mut shift = [0.0; 3];
    // of pressures far beyond their bounds rounding leaves a part that a second time takes out
    for _ in 0..2 {
        let projection = Projection {
            modes,
            shapes,
            given: &*p,
            cap,
            held,
            spans,
            set,
            whole,
        };
        let (mut y, mut worst) = projection.shift([0.0; 3], 0.0);
        if worst > BALANCED {
            (y, worst) = projection.shift_by_and_by();
        }
        let cut = |[p]: [f64; 1], [n, m, l]: [f64; 3], is_in: bool| {
            let next = p + y[0] * n + y[1] * m + y[2] * l;
            ([if is_in { next.max(0.0).min(cap) } else { p }], [])
        };
        spans.sum([p], shapes, set, cut);
        shift = from_fn(|k| shift[k] + y[k]);
        if worst > BALANCED {
            return None;
        }
        if worst <= EXACT {
            break;
        }
    }
    Some(shift)
}

/// What [`project`] looks for: the least of a convex function of the shift, whose slope is what the balance misses.
struct Projection<'a> {
    modes: &'a [Mode],
    shapes: [&'a [f64]; 3],
    given: &'a [f64],
    cap: f64,
    held: [f64; 3],
    spans: &'a Spans,
    set: &'a [bool],
    /// Stiffness of the balance against shifts of all points, whether at their bounds or not.
    whole: [[f64; 3]; 3],
}

/// What the balance misses after a shift, its stiffness against further ones, and the largest share missed.
struct Missing {
    forces: [f64; 3],
    stiffness: [[f64; 3]; 3],
    worst: f64,
}

impl Projection<'_> {
    /// At a shift, with the corners of both bounds rounded over a pressure of `rounding`.
    fn at(&self, y: [f64; 3], rounding: f64) -> Missing {
        let (cap, [a, b, c]) = (self.cap, self.shapes);
        let (mut forces, mut stiffness, mut worst) = ([0.0; 3], [[0.0; 3]; 3], 0.0_f64);
        for (k, mode) in self.modes.iter().enumerate() {
            for (l, other) in self.modes[..=k].iter().enumerate() {
                let moments = |[]: [f64; 0], [p, a, b, c, n, m]: [f64; 6], is_in: bool| {
                    if !is_in {
                        return ([], [0.0; 3]);
                    }
                    let free = p + y[0] * a + y[1] * b + y[2] * c;
                    let (cut, slope) = if rounding > 0.0 {
                        let (low, high) = (free.hypot(rounding), (free - cap).hypot(rounding));
                        (
                            0.5 * (cap + low - high),
                            0.5 * (free / low - (free - cap) / high),
                        )
                    } else {
                        let is_free = free > 0.0 && free < cap;
                        (free.max(0.0).min(cap), f64::from(u8::from(is_free)))
                    };
                    let part = n * cut;
                    ([], [part, part.abs(), slope * n * m])
                };
                let fields = [self.given, a, b, c, &mode.shape, &other.shape];
                let [sum, size, stiff] = self.spans.sum([], fields, self.set, moments);
                (stiffness[k][l], stiffness[l][k]) = (stiff, stiff);
                forces[k] = mode.target - self.held[k] - sum;
                let size = size + self.held[k].abs() + mode.target.abs();
                if l == k && size > 0.0 {
                    worst = worse(worst, forces[k].abs() / size);
                }
            }
        }
        Missing {
            forces,
            stiffness,
            worst,
        }
    }

    /// Newton's steps from `y`, shortened where they pass the least along them, and lengthened where they end far before it;
    /// returns the shift and the largest share missed.
    fn shift(&self, mut y: [f64; 3], rounding: f64) -> ([f64; 3], f64) {
        let steps = if rounding > 0.0 {
            SHIFTS_ROUNDED
        } else {
            SHIFTS
        };
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let mut missing = self.at(y, rounding);
        for _ in 0..steps {
            if missing.worst <= 1e-14 {
                break;
            }
            let (forces, m) = (missing.forces, self.modes.len());
            let safe = solve_small(&self.whole, forces, m);
            let mut step = solve_small(&missing.stiffness, forces, m);
            // where points at their bounds leave a motion without stiffness, that of all points is safe
            if dot(forces, step) < dot(forces, safe) {
                step = safe;
            }
            let slope = dot(forces, step);
            let (mut length, mut bounds) = (1.0, [0.0, f64::INFINITY]);
            let (old, mut is_met) = (y, false);
            for _ in 0..LENGTHS {
                y = from_fn(|k| old[k] + length * step[k]);
                missing = self.at(y, rounding);
                let left = dot(missing.forces, step);
                is_met = left.abs() <= 0.5 * slope;
                if is_met {
                    break;
                }
                bounds[usize::from(left < 0.0)] = length;
                length = if bounds[1].is_finite() {
                    0.5 * (bounds[0] + bounds[1])
                } else {
                    4.0 * length
                };
            }
            // rounding, or a load that no pressures of these points carry
            if y == old || !is_met {
                break;
            }
        }
        (y, missing.worst)
    }

    /// The shift where it leaves so few points between their bounds that Newton's steps see no way: from bounds whose
    /// corners are rounded so far that all points give way, over ever sharper ones. [ChenMangasarian1996]
    fn shift_by_and_by(&self) -> ([f64; 3], f64) {
        let largest =
            |[]: [f64; 0], [p]: [f64; 1], is_in: bool| ([], [if is_in { p.abs() } else { 0.0 }]);
        let join = |[a]: [f64; 1], [b]: [f64; 1]| [a.max(b)];
        let (given, spans, set) = (self.given, self.spans, self.set);
        let [far] = spans.fold([], [given], set, largest, [self.cap], join);
        let (mut y, mut rounding) = ([0.0; 3], far);
        while rounding > SHARP * self.cap {
            (y, _) = self.shift(y, rounding);
            rounding *= SHARPER;
        }
        self.shift(y, 0.0)
    }
}

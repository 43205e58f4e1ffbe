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
    worst <= 1e-6
}

/// Directions in which [`project`] looks for the shift, and lengths along each of them.
const SHIFTS: usize = 100;
const LENGTHS: usize = 24;

/// Shifts the pressures of `set`, which `spans` hold, by the motions and cuts them off at zero and at the cap, such that
/// they meet the balance, of which other points carry `held`: the nearest pressures that do. False where no such shift
/// is found.
pub(super) fn project(
    modes: &[Mode],
    p: &mut [f64],
    cap: f64,
    held: [f64; 3],
    spans: &Spans,
    set: &[bool],
) -> bool {
    // a motion that is none has no share of the shift
    let none = vec![0.0; if modes.is_empty() { p.len() } else { 0 }];
    let shapes: [&[f64]; 3] = from_fn(|k| match (modes.get(k), modes.first()) {
        (Some(mode), _) | (None, Some(mode)) => mode.shape.as_slice(),
        (None, None) => none.as_slice(),
    });
    let [a, b, c] = shapes;
    // what the balance misses after a shift, its stiffness against further ones, and the largest share missed
    let given = &*p;
    let at = |y: [f64; 3]| {
        let shifted = |p: f64, [n, m, l]: [f64; 3]| p + y[0] * n + y[1] * m + y[2] * l;
        let (mut missing, mut gram, mut worst) = ([0.0; 3], [[0.0; 3]; 3], 0.0_f64);
        for (k, mode) in modes.iter().enumerate() {
            for l in 0..=k {
                let moments = |[]: [f64; 0], [p, a, b, c, n, m]: [f64; 6], is_in: bool| {
                    if !is_in {
                        return ([], [0.0; 3]);
                    }
                    let free = shifted(p, [a, b, c]);
                    let part = n * free.max(0.0).min(cap);
                    let stiffness = if free > 0.0 && free < cap { n * m } else { 0.0 };
                    ([], [part, part.abs(), stiffness])
                };
                let fields = [given, a, b, c, &mode.shape, &modes[l].shape];
                let [sum, size, stiffness] = spans.sum([], fields, set, moments);
                (gram[k][l], gram[l][k]) = (stiffness, stiffness);
                missing[k] = mode.target - held[k] - sum;
                let size = size + held[k].abs() + mode.target.abs();
                if l == k && size > 0.0 {
                    worst = worse(worst, missing[k].abs() / size);
                }
            }
        }
        (missing, gram, worst)
    };
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    // the least of a convex function, whose slope is what is missed: Newton's steps, shortened where they pass the least
    // along them, and lengthened where they end far before it
    let mut y = [0.0; 3];
    let (mut missing, mut gram, mut worst) = at(y);
    let shape = |k: usize| modes.get(k).map(|mode| mode.shape.as_slice());
    // that of all points, whether at their bounds or not
    let whole: [[f64; 3]; 3] = from_fn(|k| {
        from_fn(|l| match (shape(k), shape(l)) {
            (Some(n), Some(m)) => spans.dot_in(n, m, set),
            _ => 0.0,
        })
    });
    for _ in 0..SHIFTS {
        if worst <= 1e-14 {
            break;
        }
        let safe = solve_small(&whole, missing, modes.len());
        let mut step = solve_small(&gram, missing, modes.len());
        // where points at their bounds leave a motion without stiffness, that of all points is safe
        if dot(missing, step) < dot(missing, safe) {
            step = safe;
        }
        let slope = dot(missing, step);
        let (mut length, mut bounds) = (1.0, [0.0, f64::INFINITY]);
        let (old, mut is_met) = (y, false);
        for _ in 0..LENGTHS {
            y = from_fn(|k| old[k] + length * step[k]);
            (missing, gram, worst) = at(y);
            let left = dot(missing, step);
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
    let cut = |[p]: [f64; 1], [n, m, l]: [f64; 3], is_in: bool| {
        let next = p + y[0] * n + y[1] * m + y[2] * l;
        ([if is_in { next.max(0.0).min(cap) } else { p }], [])
    };
    spans.sum([p], shapes, set, cut);
    worst <= 1e-6
}

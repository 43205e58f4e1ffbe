// SPDX-License-Identifier: MIT OR Apache-2.0
//! Traction bounds by a layer that yields.
//!
//! The bound is the smaller one of friction, `mu p`, and of the yield stress of the layer, `tau_c0 + k_tau u`, with the
//! accumulated plastic slip `u` of the particles. Slip under a traction below the bound of friction is plastic shear of
//! the layer; once hardening has brought the yield stress to that bound, the rest is slip of the surfaces.

use mtb_complementarity::discs::DependentRadius;
use mtb_operator::LinearOperator;

use super::bound::{Sources, sources};
use super::given::carried;
use super::operators::{Motion, PatchOperators};
use super::problem::{PlasticSlip, Plasticity, TangentialProblem};
use crate::Error;
use crate::error::check_number;

/// Share of the first yield stress that softening leaves at least: a point whose bound is zero would take no part.
const LEAST_YIELD: f64 = 1e-9;
/// Products of the power iteration, at most, and the relative change of the eigenvalue at which it ends.
const MOST_PRODUCTS: usize = 200;
const SETTLED: f64 = 1e-4;

/// Traction bound for the disc solver.
pub(super) struct Yielding {
    /// Bound by friction [Pa], (n).
    friction: Vec<f64>,
    law: (f64, f64),
    history: History,
    /// Slip [m] of a unit of the image.
    length: f64,
}

/// Where the accumulated plastic slip of a point comes from.
enum History {
    /// That of the particles a step ago [m].
    Known(Vec<f64>),
    /// Steady rolling: from the points upstream, those first.
    Upstream {
        order: Vec<usize>,
        sources: Vec<Sources>,
    },
}

/// What a point does at a slip.
#[derive(Clone, Copy, Default)]
struct Point {
    /// Accumulated plastic slip [m].
    accumulated: f64,
    radius: f64,
    /// Share of the slip that is plastic.
    share: f64,
    /// Whether the layer yields at any further slip.
    yields: bool,
    /// Derivatives of the accumulated slip and of the share.
    by: [Slopes; 2],
    /// Derivatives of the radius by the accumulated slip and, at that slip, by what is given.
    slope: f64,
    direct: Slopes,
}

/// Derivatives by the accumulated slip of the particle before, by the slip that is wanted, by the bound of friction, by
/// the first yield stress and by the hardening.
#[derive(Clone, Copy, Default)]
struct Slopes {
    past: f64,
    wanted: f64,
    friction: f64,
    yield_stress: f64,
    hardening: f64,
}

/// Changes of what the bounds follow from; or the derivatives of a number by it.
#[derive(Clone)]
pub(super) struct YieldGiven {
    /// Bound by friction [Pa], (n).
    pub(super) friction: Vec<f64>,
    pub(super) yield_stress: f64,
    pub(super) hardening: f64,
    /// Accumulated plastic slip of the particles a step ago [m], (n); without meaning in steady rolling.
    pub(super) past: Vec<f64>,
    /// Magnitude of the slip, (n).
    pub(super) magnitude: Vec<f64>,
}

/// Changes of bounds, accumulated slip and shares, (n) each; or the weights of a number in them.
pub(super) struct YieldFound {
    pub(super) radius: Vec<f64>,
    pub(super) accumulated: Vec<f64>,
    pub(super) share: Vec<f64>,
}

impl YieldGiven {
    /// No change of `n` points.
    pub(super) fn none(n: usize) -> Self {
        Self {
            friction: vec![0.0; n],
            yield_stress: 0.0,
            hardening: 0.0,
            past: vec![0.0; n],
            magnitude: vec![0.0; n],
        }
    }
}

impl Yielding {
    /// On the grid number `level`, whose bound of friction is `friction`.
    pub(super) fn new(
        operators: &PatchOperators,
        problem: &TangentialProblem<'_>,
        plasticity: &Plasticity<'_>,
        level: usize,
        friction: Vec<f64>,
    ) -> Self {
        let here = &operators.levels[level];
        let law = (plasticity.yield_stress, plasticity.hardening);
        if let Motion::Steady { .. } = operators.motion {
            let (order, sources) = sources(&here.grid, here.step, |_| true);
            return Self {
                friction,
                law,
                history: History::Upstream { order, sources },
                length: here.step[0].hypot(here.step[1]),
            };
        }
        let step = operators.motion.step();
        let mut past = match problem.earlier {
            Some(_) => carried(&operators.grid(), step, plasticity.earlier, 0.0),
            None => vec![0.0; operators.grid().points()],
        };
        for coarsening in &operators.coarsenings[..level] {
            past = coarsening.weighted(&past, &vec![1.0; past.len()]);
        }
        Self {
            friction,
            law,
            history: History::Known(past),
            length: 1.0,
        }
    }

    /// Whether the bound does not depend on the slip.
    pub(super) fn is_fixed(&self) -> bool {
        self.law.1 == 0.0
    }

    pub(super) fn hardening(&self) -> f64 {
        self.law.1
    }

    pub(super) fn set_hardening(&mut self, hardening: f64) {
        self.law.1 = hardening;
    }

    /// The bounds without slip.
    pub(super) fn at_rest(&self) -> Vec<f64> {
        let mut radius = vec![0.0; self.friction.len()];
        self.radius(&vec![0.0; self.friction.len()], &mut radius);
        radius
    }

    /// The plastic part of the slip of the given magnitudes.
    pub(super) fn plastic_slip(&self, magnitude: &[f64]) -> PlasticSlip {
        let points = self.points(magnitude);
        PlasticSlip {
            share: points.iter().map(|p| p.share).collect(),
            accumulated: points.iter().map(|p| p.accumulated).collect(),
            yields: points.iter().map(|p| p.yields).collect(),
        }
    }

    fn yield_stress(&self, accumulated: f64) -> f64 {
        let (first, hardening) = self.law;
        (first + hardening * accumulated).max(LEAST_YIELD * first)
    }

    /// Points in the order in which the particles pass them.
    fn order(&self) -> Box<dyn DoubleEndedIterator<Item = usize> + '_> {
        match &self.history {
            History::Known(past) => Box::new(0..past.len()),
            History::Upstream { order, .. } => Box::new(order.iter().copied()),
        }
    }

    /// Sum of a field over the points from which those at point `i` come in steady rolling, and the share of them that
    /// has moved on.
    fn upstream(&self, i: usize, field: impl Fn(usize) -> f64) -> (f64, f64) {
        let (mut sum, mut share) = (0.0, 1.0);
        if let History::Upstream { sources, .. } = &self.history {
            for &(j, weight) in &sources[i] {
                if j == i {
                    share -= weight;
                } else {
                    sum += weight * field(j);
                }
            }
        }
        (sum, share)
    }

    fn points(&self, magnitude: &[f64]) -> Vec<Point> {
        let mut points = vec![Point::default(); magnitude.len()];
        let hardening = self.law.1;
        for i in self.order() {
            let (past, share) = match &self.history {
                History::Known(past) => (past[i], 1.0),
                History::Upstream { .. } => self.upstream(i, |j| points[j].accumulated),
            };
            let before = past / share;
            let wanted = self.length * magnitude[i] / share;
            let most = self.friction[i];
            let first = self.yield_stress(before);
            points[i] = if first >= most {
                // friction alone limits the traction
                let by_past = Slopes {
                    past: 1.0,
                    ..Slopes::default()
                };
                Point {
                    accumulated: before,
                    radius: most,
                    by: [by_past, Slopes::default()],
                    direct: Slopes::of_friction(),
                    ..Point::default()
                }
            } else if hardening > 0.0 && hardening * wanted >= most - first {
                let plastic = (most - first) / hardening;
                let whole = Slopes {
                    friction: 1.0 / hardening,
                    yield_stress: -1.0 / hardening,
                    hardening: -(before + plastic) / hardening,
                    ..Slopes::default()
                };
                let share = Slopes {
                    past: -1.0 / wanted,
                    wanted: -plastic / wanted.powi(2),
                    friction: whole.friction / wanted,
                    yield_stress: whole.yield_stress / wanted,
                    hardening: whole.hardening / wanted,
                };
                Point {
                    accumulated: before + plastic,
                    radius: most,
                    share: plastic / wanted,
                    by: [whole, share],
                    direct: Slopes::of_friction(),
                    ..Point::default()
                }
            } else {
                let accumulated = before + wanted;
                let radius = self.yield_stress(accumulated);
                let is_left = radius > LEAST_YIELD * self.law.0;
                let by_slip = Slopes {
                    past: 1.0,
                    wanted: 1.0,
                    ..Slopes::default()
                };
                Point {
                    accumulated,
                    radius,
                    share: 1.0,
                    yields: true,
                    by: [by_slip, Slopes::default()],
                    slope: if is_left { hardening } else { 0.0 },
                    direct: Slopes {
                        yield_stress: if is_left { 1.0 } else { LEAST_YIELD },
                        hardening: if is_left { accumulated } else { 0.0 },
                        ..Slopes::default()
                    },
                }
            };
        }
        points
    }
}

impl Yielding {
    /// What follows from changes of what is given.
    pub(super) fn follow(&self, magnitude: &[f64], given: &YieldGiven) -> YieldFound {
        let points = self.points(magnitude);
        let none = vec![0.0; points.len()];
        let mut found = YieldFound {
            radius: none.clone(),
            accumulated: none.clone(),
            share: none,
        };
        for i in self.order() {
            let point = &points[i];
            let (past, share) = match &self.history {
                History::Known(_) => (given.past[i], 1.0),
                History::Upstream { .. } => self.upstream(i, |j| found.accumulated[j]),
            };
            let change = Slopes {
                past: past / share,
                wanted: self.length * given.magnitude[i] / share,
                friction: given.friction[i],
                yield_stress: given.yield_stress,
                hardening: given.hardening,
            };
            found.accumulated[i] = point.by[0].along(&change);
            found.share[i] = point.by[1].along(&change);
            found.radius[i] = point.slope * found.accumulated[i] + point.direct.along(&change);
        }
        found
    }

    /// The transpose of [`Yielding::follow`].
    pub(super) fn weigh(&self, magnitude: &[f64], weights: &YieldFound) -> YieldGiven {
        let points = self.points(magnitude);
        let mut given = YieldGiven::none(points.len());
        let mut back = weights.accumulated.clone();
        for i in self.order().rev() {
            let point = &points[i];
            let (_, share) = self.upstream(i, |_| 0.0);
            let radius = weights.radius[i];
            let own = back[i] + point.slope * radius;
            let by = |of: fn(&Slopes) -> f64| {
                own * of(&point.by[0])
                    + weights.share[i] * of(&point.by[1])
                    + radius * of(&point.direct)
            };
            given.friction[i] = by(|s| s.friction);
            given.yield_stress += by(|s| s.yield_stress);
            given.hardening += by(|s| s.hardening);
            given.magnitude[i] = self.length * by(|s| s.wanted) / share;
            let past = by(|s| s.past) / share;
            match &self.history {
                History::Known(_) => given.past[i] = past,
                History::Upstream { sources, .. } => {
                    for &(j, part) in &sources[i] {
                        if j != i {
                            back[j] += part * past;
                        }
                    }
                }
            }
        }
        given
    }
}

impl Slopes {
    /// A bound that is that of friction.
    fn of_friction() -> Self {
        Self {
            friction: 1.0,
            ..Self::default()
        }
    }

    fn along(&self, change: &Self) -> f64 {
        self.past * change.past
            + self.wanted * change.wanted
            + self.friction * change.friction
            + self.yield_stress * change.yield_stress
            + self.hardening * change.hardening
    }
}

impl DependentRadius for Yielding {
    fn radius(&self, magnitude: &[f64], radius: &mut [f64]) {
        for (g, point) in radius.iter_mut().zip(self.points(magnitude)) {
            *g = point.radius;
        }
    }

    fn derivative(&self, magnitude: &[f64], change: &[f64], derivative: &mut [f64]) {
        let given = YieldGiven {
            magnitude: change.to_vec(),
            ..YieldGiven::none(change.len())
        };
        derivative.copy_from_slice(&self.follow(magnitude, &given).radius);
    }

    fn derivative_transposed(&self, magnitude: &[f64], weight: &[f64], derivative: &mut [f64]) {
        let none = vec![0.0; weight.len()];
        let weights = YieldFound {
            radius: weight.to_vec(),
            accumulated: none.clone(),
            share: none,
        };
        derivative.copy_from_slice(&self.weigh(magnitude, &weights).magnitude);
    }
}

/// Refuses softening by which more than one answer may meet the law.
///
/// Two answers of one step, of which `dq` is the difference of the tractions and `dm` that of the slips, have
/// `dq . C dq <= |k| dm . dm`, and `dm` is not larger than `C dq`: this leaves no difference if `|k|` times the largest
/// eigenvalue of `C` on the contact is below one.
///
/// # Errors
/// [`Error::Number`].
pub(super) fn check_softening(
    operators: &PatchOperators,
    pressure: &[f64],
    hardening: f64,
) -> Result<(), Error> {
    if hardening >= 0.0 {
        return Ok(());
    }
    let Some(largest) = largest_flexibility(operators, pressure) else {
        return check_number(
            "hardening",
            hardening,
            false,
            "softening in steady rolling needs operators with PatchOperators::with_flexibility",
        );
    };
    if -hardening * largest < 1.0 {
        Ok(())
    } else {
        Err(Error::Softening {
            hardening,
            least: -1.0 / largest,
        })
    }
}

/// The largest eigenvalue of the influence of traction on the displacement in the contact [m/Pa].
fn largest_flexibility(operators: &PatchOperators, pressure: &[f64]) -> Option<f64> {
    let n = pressure.len();
    let apply = |q: &[f64], u: &mut [f64]| -> Option<()> {
        if let Motion::Steady { .. } = operators.motion {
            u.fill(0.0);
            let kernels = operators.flexibility.as_ref()?;
            kernels.apply_add(operators.transform(), 1.0, q, u);
            for (u, q) in u.iter_mut().zip(q) {
                *u += operators.layer * q;
            }
        } else {
            operators.levels[0].slip.apply(q, u);
        }
        Some(())
    };
    let is_loaded = |k: usize| pressure[k % n] > 0.0;
    let mut traction: Vec<f64> = (0..2 * n)
        .map(|k| f64::from(u8::from(is_loaded(k))))
        .collect();
    let mut moved = vec![0.0; 2 * n];
    let mut largest = 0.0;
    for _ in 0..MOST_PRODUCTS {
        let size = traction.iter().map(|q| q * q).sum::<f64>().sqrt();
        for q in &mut traction {
            *q /= size;
        }
        apply(&traction, &mut moved)?;
        let quotient: f64 = traction.iter().zip(&moved).map(|(q, u)| q * u).sum();
        let is_settled = (quotient - largest).abs() <= SETTLED * quotient;
        largest = quotient;
        if is_settled {
            break;
        }
        for (k, (q, u)) in traction.iter_mut().zip(&moved).enumerate() {
            *q = if is_loaded(k) { *u } else { 0.0 };
        }
    }
    Some(largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(hardening: f64, history: History) -> Yielding {
        Yielding {
            friction: vec![630.0, 500.0, 150.0, 0.0],
            law: (200.0, hardening),
            history,
            length: 0.5,
        }
    }

    fn upstream() -> History {
        History::Upstream {
            order: vec![3, 2, 1, 0],
            sources: vec![
                [(1, 0.7), (0, 0.3), (0, 0.0), (0, 0.0)],
                [(2, 0.6), (3, 0.4), (1, 0.0), (1, 0.0)],
                [(3, 1.0), (2, 0.0), (2, 0.0), (2, 0.0)],
                [(3, 0.0); 4],
            ],
        }
    }

    #[test]
    fn derivatives_are_those_of_the_radii_and_transposed() {
        for hardening in [435.0, -300.0] {
            for history in [|| History::Known(vec![0.1, 0.0, 0.2, 0.0]), upstream] {
                let law = of(hardening, history());
                let at = [0.3, 0.2, 0.4, 0.0];
                let change = [0.7, -0.3, 0.5, 0.0];
                let h = 1e-6;
                let moved = |sign: f64| {
                    let m: Vec<f64> = (0..4).map(|i| at[i] + sign * h * change[i]).collect();
                    let mut g = vec![0.0; 4];
                    law.radius(&m, &mut g);
                    g
                };
                let (above, below) = (moved(1.0), moved(-1.0));
                let mut slope = [0.0; 4];
                law.derivative(&at, &change, &mut slope);
                for i in 0..4 {
                    assert!((slope[i] - (above[i] - below[i]) / (2.0 * h)).abs() < 1e-5);
                }
                let weight = [0.4, -1.0, 2.0, 0.3];
                let mut back = [0.0; 4];
                law.derivative_transposed(&at, &weight, &mut back);
                let one: f64 = slope.iter().zip(weight).map(|(s, w)| s * w).sum();
                let other: f64 = back.iter().zip(change).map(|(b, c)| b * c).sum();
                assert!((one - other).abs() < 1e-10 * one.abs().max(1.0));
            }
        }
    }

    #[test]
    fn what_hardens_up_to_friction_slips_with_the_rest() {
        let law = of(400.0, History::Known(vec![0.0, 0.5, 0.1, 0.7]));
        let found = law.plastic_slip(&[2.0, 2.0, 2.0, 0.0]);
        // yields by 1 of the slip of 2 x 0.5 and reaches 600; by 0.25 up to 500; not at all; out of contact
        assert_eq!(found.yields, [true, false, false, false]);
        assert_eq!(found.share, [1.0, 0.25, 0.0, 0.0]);
        assert_eq!(found.accumulated, [1.0, 0.75, 0.1, 0.7]);
    }
}

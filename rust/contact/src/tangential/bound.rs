// SPDX-License-Identifier: MIT OR Apache-2.0
//! Traction bounds by friction that depends on the slip.

use mtb_complementarity::discs::DependentRadius;
use mtb_operator::Grid;

use super::given::{carried, neighbour};
use super::operators::{Motion, PatchOperators};
use super::problem::TangentialProblem;
use super::table::upstream;
use crate::friction::{Past, SlipFriction, SlipLaw, Upstream};

/// Traction bound `mu(s) p` for the disc solver.
pub(super) struct SlipBound<'a> {
    pub(super) friction: SlipFriction<'a>,
    pub(super) pressure: &'a [f64],
    pub(super) speed: f64,
}

impl DependentRadius for SlipBound<'_> {
    fn radius(&self, magnitude: &[f64], radius: &mut [f64]) {
        let speed: Vec<f64> = magnitude.iter().map(|m| m * self.speed).collect();
        self.friction.coefficients(&speed, radius);
        for (g, p) in radius.iter_mut().zip(self.pressure) {
            *g *= p.max(0.0);
        }
    }

    fn derivative(&self, magnitude: &[f64], change: &[f64], derivative: &mut [f64]) {
        let speed: Vec<f64> = magnitude.iter().map(|m| m * self.speed).collect();
        let change: Vec<f64> = change.iter().map(|m| m * self.speed).collect();
        self.friction.derivative(&speed, &change, derivative);
        for (g, p) in derivative.iter_mut().zip(self.pressure) {
            *g *= p.max(0.0);
        }
    }

    fn derivative_transposed(&self, magnitude: &[f64], weight: &[f64], derivative: &mut [f64]) {
        let speed: Vec<f64> = magnitude.iter().map(|m| m * self.speed).collect();
        for ((d, w), p) in derivative.iter_mut().zip(weight).zip(self.pressure) {
            *d = w * p.max(0.0);
        }
        self.friction.derivative_transposed(&speed, derivative);
        for d in derivative.iter_mut() {
            *d *= self.speed;
        }
    }
}

/// Where the memory of friction of each cell on the grid number `level` comes from, at a slip `speed` per unit of the
/// image.
pub(super) fn past(
    operators: &PatchOperators,
    problem: &TangentialProblem<'_>,
    level: usize,
    pressure: &[f64],
    law: &SlipLaw,
    speed: f64,
) -> Past {
    let rest = law.evaluate(0.0).0;
    if let Motion::Steady { .. } = operators.motion {
        let upstream = upstream_of(operators, level, pressure, problem.speed);
        return Past::Upstream(upstream);
    }
    let mut coefficient = match problem.earlier {
        Some(earlier) => carried(
            &operators.grid(),
            operators.motion.step(),
            &earlier.coefficient,
            rest,
        ),
        None => vec![rest; operators.grid().points()],
    };
    for coarsening in &operators.coarsenings[..level] {
        let ones = vec![1.0; coefficient.len()];
        coefficient = coarsening.weighted(&coefficient, &ones);
    }
    Past::Known {
        coefficient,
        time: 1.0 / speed,
    }
}

/// Where the memory comes from in steady rolling at `rolling_speed` [m/s].
pub(super) fn upstream_of(
    operators: &PatchOperators,
    level: usize,
    pressure: &[f64],
    rolling_speed: f64,
) -> Upstream {
    let here = &operators.levels[level];
    let (order, sources) = sources(&here.grid, here.step, |k| pressure[k] > 0.0);
    Upstream {
        order,
        sources,
        time: here.step[0].hypot(here.step[1]) / rolling_speed,
    }
}

/// The points that a particle comes from, with their weights.
pub(super) type Sources = [(usize, f64); 4];

/// The points that take part, those upstream first, and for each point of the grid the points that its particles come
/// from in steady rolling; what is missing to a total of one comes from outside.
pub(super) fn sources(
    grid: &Grid,
    step: [f64; 2],
    takes_part: impl Fn(usize) -> bool,
) -> (Vec<usize>, Vec<Sources>) {
    let along = |k: usize| {
        (k % grid.nx) as f64 * grid.dx * step[0] + (k / grid.nx) as f64 * grid.dy * step[1]
    };
    let mut order: Vec<usize> = (0..grid.points()).filter(|k| takes_part(*k)).collect();
    order.sort_by(|a, b| along(*b).total_cmp(&along(*a)));
    let weights = upstream(grid, step);
    let sources = (0..grid.points())
        .map(|k| {
            weights.map(|(d, w)| match neighbour(grid, k, d) {
                Some(m) if takes_part(m) => (m, w),
                _ => (k, 0.0),
            })
        })
        .collect();
    (order, sources)
}

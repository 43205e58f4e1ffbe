// SPDX-License-Identifier: MIT OR Apache-2.0
//! Steady rolling whose friction follows the temperature of the surfaces.

use mtb_complementarity::discs::DiscState;
use mtb_heat::Warming;
use mtb_operator::Monitor;

use super::bound::upstream_of;
use super::dissipation::{Surroundings, dissipation};
use super::operators::{Motion, PatchOperators};
use super::problem::{Rounds, TangentialProblem, TangentialSolution};
use super::solve::solve;
use crate::Error;
use crate::anderson::Anderson;
use crate::friction::{Friction, Past};
use crate::temperature::TemperatureLaw;

/// Rounds of a solution at given coefficients and the coefficients by its temperatures.
const ROUNDS: usize = 60;
/// Earlier rounds out of which the next coefficients are combined.
const DEPTH: usize = 4;
/// Change of the coefficients, over the largest, at which the rounds end: over the tolerance, and at least.
const SETTLED_OVER_TOLERANCE: f64 = 10.0;
const SETTLED: f64 = 1e-11;
/// Creepage at which a surface stands still.
const LOCKED: f64 = 1.0;

/// Solutions at given coefficients, and coefficients by their temperatures, in turn until these stay.
///
/// Heat goes downstream only, and little of it comes from each cell. The next coefficients are those of the last
/// rounds, combined such that the changes, taken as linear, vanish [Walker2011].
pub(super) fn with_temperature(
    operators: &PatchOperators,
    problem: &TangentialProblem<'_>,
    law: &TemperatureLaw,
    monitor: Monitor<'_>,
) -> Result<TangentialSolution, Error> {
    let heated = Heated::new(operators, problem, law, None)?;
    let touching = &heated.touching;
    let settled = (SETTLED_OVER_TOLERANCE * problem.tolerance).max(SETTLED);
    let mut coefficient = vec![law.at_rest(); problem.pressure.len()];
    let mut memory = Anderson::new(DEPTH);
    let mut start = problem.start.map(<[f64]>::to_vec);
    let (mut products, mut preconditionings, mut count) = (0.0, 0.0, 0);
    loop {
        count += 1;
        let friction = Friction::Coulomb(coefficient.clone());
        let given = TangentialProblem {
            friction: &friction,
            start: start.as_deref(),
            ..*problem
        };
        let mut solution = solve(operators, &given, monitor)?;
        products += solution.products;
        preconditionings += solution.preconditionings;
        let wanted = heated.coefficients(&solution)?;
        let (mut largest, mut change) = (f64::MIN_POSITIVE, 0.0_f64);
        for &k in touching {
            largest = largest.max(wanted[k]);
            change = change.max((wanted[k] - coefficient[k]).abs());
        }
        let change = change / largest;
        if change <= settled || !solution.converged || count == ROUNDS {
            solution.converged &= change <= settled;
            solution.products = products;
            solution.preconditionings = preconditionings;
            solution.rounds = Some(Rounds { count, change });
            return Ok(solution);
        }
        let tried = touching.iter().map(|k| coefficient[*k]).collect();
        let step = touching.iter().map(|k| wanted[*k] - coefficient[*k]);
        for (k, value) in touching.iter().zip(memory.next(tried, step.collect())) {
            coefficient[*k] = value.max(0.0);
        }
        start = Some(solution.traction);
    }
}

/// How the heat of a steady state warms its own surfaces.
pub(super) struct Heated<'a> {
    operators: &'a PatchOperators,
    problem: &'a TangentialProblem<'a>,
    pub(super) law: &'a TemperatureLaw,
    pub(super) around: Surroundings,
    warming: Warming,
    /// Cells in contact, and where each of them is on the grid around.
    pub(super) touching: Vec<usize>,
    places: Vec<usize>,
}

impl<'a> Heated<'a> {
    /// Of a problem whose heat is told on the grid `around`, or on one around its patch.
    pub(super) fn new(
        operators: &'a PatchOperators,
        problem: &'a TangentialProblem<'a>,
        law: &'a TemperatureLaw,
        around: Option<Surroundings>,
    ) -> Result<Self, Error> {
        let Motion::Steady {
            step: [along, across],
        } = operators.motion
        else {
            return Err(Error::NoTemperature);
        };
        let grid = operators.grid();
        // a line of cells all around takes the heat behind the trailing edge
        let around = around.or(problem.around).unwrap_or(Surroundings {
            shape: [grid.nx + 2, grid.ny + 2],
            first: [1, 1],
        });
        let warming = Warming::new(
            around.shape,
            [grid.dx, grid.dy],
            across.atan2(along),
            problem.speed,
            law.bodies,
        )?;
        let touching: Vec<usize> = (0..problem.pressure.len())
            .filter(|k| problem.pressure[*k] > 0.0)
            .collect();
        let places = touching
            .iter()
            .map(|k| around.cell(&grid, *k, [0, 0]))
            .collect();
        Ok(Self {
            operators,
            problem,
            law,
            around,
            warming,
            touching,
            places,
        })
    }

    /// Rise [K] of each cell in contact over the temperature at which the surfaces meet.
    pub(super) fn rise(&self, dissipation: &[f64]) -> Vec<f64> {
        self.warming.rise(&self.power(dissipation), &self.places)
    }

    /// Derivative [K] of [`Heated::rise`] by the direction of rolling, with the heat held.
    pub(super) fn rise_by_angle(&self, dissipation: &[f64]) -> Vec<f64> {
        let power = self.power(dissipation);
        self.warming.rise_by_angle(&power, &self.places)
    }

    /// The transpose of [`Heated::rise`]: adds to the weights of the dissipation.
    pub(super) fn weigh(&self, rise: &[f64], dissipation: &mut [f64]) {
        let mut power = vec![0.0; dissipation.len()];
        self.warming.weigh(rise, &self.places, &mut power);
        for (to, power) in dissipation.iter_mut().zip(power) {
            *to += self.problem.speed * power;
        }
    }

    fn power(&self, dissipation: &[f64]) -> Vec<f64> {
        let speed = self.problem.speed;
        dissipation.iter().map(|heat| heat * speed).collect()
    }

    /// Coefficients (n) that particles follow where surfaces are warmer by `rise`; out of contact that at rest.
    pub(super) fn steady(&self, rise: &[f64]) -> Vec<f64> {
        let cold = self.law.cold();
        let mut steady = vec![self.law.at_rest(); self.problem.pressure.len()];
        for (k, rise) in self.touching.iter().zip(rise) {
            steady[*k] = self.law.at(cold + rise);
        }
        steady
    }

    /// Coefficients (n) by the temperatures of a solution.
    fn coefficients(&self, solution: &TangentialSolution) -> Result<Vec<f64>, Error> {
        let creepage = solution.drive[0].hypot(solution.drive[1]);
        if creepage >= LOCKED {
            return Err(Error::Locked { creepage });
        }
        let heat = dissipation(self.operators, self.problem, solution, self.around);
        let steady = self.steady(&self.rise(&heat));
        let Some(memory) = self.law.memory else {
            return Ok(steady);
        };
        let (n, speed) = (steady.len(), self.problem.speed);
        let slip_speed: Vec<f64> = (0..n)
            .map(|k| match solution.state[k] {
                DiscState::Rim => speed * solution.slip[k].hypot(solution.slip[n + k]),
                _ => 0.0,
            })
            .collect();
        let mut coefficient = steady;
        let (past, rest) = (self.past(), self.law.at_rest());
        memory.follow(&past, rest, &slip_speed, &mut coefficient);
        Ok(coefficient)
    }

    /// Where particles with a memory come from; they come into contact with the coefficient at rest.
    ///
    /// The scheme is that of friction that depends on the slip speed, implicit and of first order in the step.
    /// [Vollebregt2012, eq. 4]
    pub(super) fn past(&self) -> Past {
        upstream_of(self.operators, 0, self.problem.pressure, self.problem.speed)
    }
}

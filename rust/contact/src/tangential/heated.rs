// SPDX-License-Identifier: MIT OR Apache-2.0
//! Steady rolling whose friction follows the temperature of the surfaces.

use mtb_complementarity::discs::DiscState;
use mtb_heat::Warming;
use mtb_operator::Monitor;

use super::bound::upstream_of;
use super::dissipation::{Surroundings, slip_at_faces, works};
use super::operators::{Motion, PatchOperators};
use super::problem::{Rounds, TangentialProblem, TangentialSolution};
use super::solve::solve;
use crate::Error;
use crate::anderson::Anderson;
use crate::friction::{Friction, Upstream, passed_on};
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
        let wanted = heated.coefficients(&solution, &coefficient)?;
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

    /// Coefficients (n) by the temperatures of a solution that was found with other `used` ones.
    ///
    /// From cell to cell downstream, each with the heat that its own coefficient makes: what slips has the slip of the
    /// solution and the traction of the new coefficient. Where the coefficient falls steeply, the temperature by the
    /// old one would turn it from end to end of its table in every round.
    fn coefficients(&self, solution: &TangentialSolution, used: &[f64]) -> Result<Vec<f64>, Error> {
        let creepage = solution.drive[0].hypot(solution.drive[1]);
        if creepage >= LOCKED {
            return Err(Error::Locked { creepage });
        }
        let state = solution.state();
        let slip = slip_at_faces(self.operators, self.problem, &state);
        let works = works(self.operators, self.problem, &state, &slip);
        let mut power = self.power(&self.around.sum_of(self.operators, &works));
        let [now, behind] = works;
        let (n, speed, rest) = (used.len(), self.problem.speed, self.law.at_rest());
        let grid = self.operators.grid();
        let cells_behind = self.around.behind(self.operators);
        let mut coefficient = vec![rest; n];
        let Upstream {
            order,
            sources,
            time,
        } = self.upstream();
        for k in order {
            let cell = self.around.cell(&grid, k, [0, 0]);
            let slips = solution.state[k] == DiscState::Rim;
            // the heat of its traction, where it goes, over its coefficient
            let grows = slips && used[k] > 0.0;
            let over = if grows { speed / used[k] } else { 0.0 };
            let parts: Vec<(usize, f64)> = (cells_behind(k).into_iter())
                .map(|(to, weight)| (to, over * weight * behind[k]))
                .chain([(cell, over * now[k])])
                .collect();
            let (mut others, mut own) = (self.law.cold(), 0.0);
            for (from, by) in self.warming.by_heat(cell) {
                others += by * power[from];
                if from == cell {
                    own = by
                        * parts
                            .iter()
                            .filter(|p| p.0 == cell)
                            .map(|p| p.1)
                            .sum::<f64>();
                }
            }
            let own = own.max(0.0);
            let follows = match self.law.memory {
                None => (0.0, 1.0),
                Some(memory) => {
                    let slip = solution.slip[k].hypot(solution.slip[n + k]);
                    let c = memory.rate(if slips { speed * slip } else { 0.0 }, time).0;
                    passed_on(k, &sources[k], c, rest, &coefficient)
                }
            };
            coefficient[k] = self.law.with_own_heat(follows, others - own * used[k], own);
            for (to, by) in parts {
                power[to] += by * (coefficient[k] - used[k]);
            }
        }
        Ok(coefficient)
    }

    /// Where particles with a memory come from; they come into contact with the coefficient at rest.
    ///
    /// The scheme is that of friction that depends on the slip speed, implicit and of first order in the step.
    /// [Vollebregt2012, eq. 4]
    pub(super) fn upstream(&self) -> Upstream {
        upstream_of(self.operators, 0, self.problem.pressure, self.problem.speed)
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Steady rolling whose friction follows the temperature of the surfaces.

use mtb_complementarity::discs::DiscState;
use mtb_heat::{Passage, rolling};
use mtb_operator::Monitor;

use super::bound::remembered;
use super::dissipation::{Surroundings, dissipation};
use super::operators::{Motion, PatchOperators};
use super::problem::{Rounds, TangentialProblem, TangentialSolution};
use super::solve::solve;
use crate::Error;
use crate::anderson::Anderson;
use crate::friction::Friction;
use crate::temperature::TemperatureLaw;

/// Rounds of a solution at given coefficients and the coefficients by its temperatures.
const ROUNDS: usize = 60;
/// Earlier rounds out of which the next coefficients are combined.
const DEPTH: usize = 4;
/// Change of the coefficients, over the largest, at which the rounds end: over the tolerance, and at least.
const SETTLED_OVER_TOLERANCE: f64 = 10.0;
const SETTLED: f64 = 1e-9;
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
    let Motion::Steady { .. } = operators.motion else {
        return Err(Error::NoTemperature);
    };
    let touching: Vec<usize> = (0..problem.pressure.len())
        .filter(|k| problem.pressure[*k] > 0.0)
        .collect();
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
        let wanted = by_temperature(operators, &given, law, &solution)?;
        let (mut largest, mut change) = (f64::MIN_POSITIVE, 0.0_f64);
        for &k in &touching {
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

/// Coefficients (n) by the temperatures of a solution.
fn by_temperature(
    operators: &PatchOperators,
    problem: &TangentialProblem<'_>,
    law: &TemperatureLaw,
    solution: &TangentialSolution,
) -> Result<Vec<f64>, Error> {
    let creepage = solution.drive[0].hypot(solution.drive[1]);
    if creepage >= LOCKED {
        return Err(Error::Locked { creepage });
    }
    let grid = operators.grid();
    let [along, across] = operators.motion.step();
    // a line of cells all around takes the heat behind the trailing edge
    let around = problem.around.unwrap_or(Surroundings {
        shape: [grid.nx + 2, grid.ny + 2],
        first: [1, 1],
    });
    let inside = |k: usize| around.cell(&grid, k, [0, 0]);
    let mut power = dissipation(operators, problem, solution, around);
    for value in &mut power {
        *value *= problem.speed;
    }
    let mut touches = vec![false; power.len()];
    for (k, p) in problem.pressure.iter().enumerate() {
        touches[inside(k)] = *p > 0.0;
    }
    let found = rolling(&Passage {
        shape: around.shape,
        spacing: [grid.dx, grid.dy],
        angle: across.atan2(along),
        speed: problem.speed,
        power: &power,
        touches: &touches,
        bodies: law.bodies,
        bulk: law.bulk,
    })?;
    // in contact both surfaces have one temperature
    let [surface, _] = found.surface;
    let n = grid.points();
    let steady: Vec<f64> = (0..n).map(|k| law.at(surface[inside(k)])).collect();
    let Some(memory) = law.memory else {
        return Ok(steady);
    };
    let slip_speed: Vec<f64> = (0..n)
        .map(|k| match solution.state[k] {
            DiscState::Rim => problem.speed * solution.slip[k].hypot(solution.slip[n + k]),
            _ => 0.0,
        })
        .collect();
    let (pressure, speed) = (problem.pressure, problem.speed);
    let rest = law.at_rest();
    Ok(remembered(
        operators,
        pressure,
        speed,
        &steady,
        &slip_speed,
        rest,
        memory,
    ))
}

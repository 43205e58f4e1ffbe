// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whether a tangential problem makes sense.

use mtb_operator::Grid;

use super::given::neighbour;
use super::operators::{Motion, PatchOperators};
use super::plastic::{Yielding, check_softening};
use super::problem::{Drive, Plasticity, TangentialProblem};
use crate::Error;
use crate::error::{check, check_number, check_positive};
use crate::friction::{Friction, SlipLaw};

/// Share of the largest force that is left to rounding.
const ROUNDING: f64 = 1e-12;

/// # Errors
/// As [`solve`](super::solve).
pub(super) fn check_problem(
    operators: &PatchOperators,
    problem: &TangentialProblem<'_>,
) -> Result<(), Error> {
    let n = operators.grid().points();
    check("pressure", problem.pressure, n)?;
    check("origin", &problem.origin, 2)?;
    for drive in problem.drive {
        match drive {
            Drive::Slip(value) => check_number("slip", value, true, "a finite number is needed")?,
            Drive::Force(value) => check_number("force", value, true, "a finite number is needed")?,
        }
    }
    check_number("spin", problem.spin, true, "a finite number is needed")?;
    check_positive("speed", problem.speed)?;
    check_number(
        "tolerance",
        problem.tolerance,
        problem.tolerance > 0.0 && problem.tolerance < 1.0,
        "a number between 0 and 1 is needed",
    )?;
    if let Some(earlier) = problem.earlier {
        check("earlier traction", &earlier.traction, 2 * n)?;
        check("earlier pressure", &earlier.pressure, n)?;
        check("earlier coefficient", &earlier.coefficient, n)?;
    }
    if let Some(slip) = problem.rigid_slip {
        check("rigid slip", slip, 2 * n)?;
    }
    if let Some(start) = problem.start {
        check("start", start, 2 * n)?;
    }
    if !problem.pressure.iter().any(|p| *p > 0.0) {
        return Err(Error::NoContact);
    }
    if let Motion::Transient { step } = operators.motion {
        check_step(operators.grid(), problem, step)?;
    }
    let mut largest = check_friction(problem)?;
    if let Some(plasticity) = &problem.plasticity {
        largest = check_plasticity(operators, problem, plasticity)?;
    }
    let force = problem
        .drive
        .map(|d| if let Drive::Force(f) = d { f } else { 0.0 });
    let capacity = largest * operators.grid().cell_area();
    // a force at the limit itself leaves the creepage open, and a sum of many cells is rounded
    if force[0].hypot(force[1]) >= capacity * (1.0 - ROUNDING) && force != [0.0; 2] {
        return Err(Error::ForceTooLarge {
            force: force[0].hypot(force[1]),
            largest: capacity,
        });
    }
    Ok(())
}

/// Checks that a step goes no further than the contact is long, or that something of the state before is left.
fn check_step(grid: Grid, problem: &TangentialProblem<'_>, step: [f64; 2]) -> Result<(), Error> {
    let (pressure, length) = (problem.pressure, step[0].hypot(step[1]));
    if length == 0.0 {
        return Ok(());
    }
    // frames of patches that part or merge move further than their particles
    let from = [step[0] / grid.dx, step[1] / grid.dy].map(|cells| cells.round() as isize);
    let was_loaded = |k: usize| {
        let before = (problem.earlier).zip(neighbour(&grid, k, from));
        before.is_some_and(|(earlier, m)| earlier.pressure[m] > 0.0)
    };
    if (0..pressure.len()).any(|k| pressure[k] > 0.0 && was_loaded(k)) {
        return Ok(());
    }
    let along = step.map(|s| s / length);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for k in (0..pressure.len()).filter(|k| pressure[*k] > 0.0) {
        let place = [
            (k % grid.nx) as f64 * grid.dx,
            (k / grid.nx) as f64 * grid.dy,
        ];
        let at = place[0] * along[0] + place[1] * along[1];
        (low, high) = (low.min(at), high.max(at));
    }
    let cell = grid.dx * along[0].abs() + grid.dy * along[1].abs();
    let contact = high - low + cell;
    if length > contact * (1.0 + ROUNDING) {
        return Err(Error::TooFar {
            step: length,
            length: contact,
        });
    }
    Ok(())
}

/// Checks the yield of the layer; returns the sum of the largest traction bounds [Pa].
fn check_plasticity(
    operators: &PatchOperators,
    problem: &TangentialProblem<'_>,
    plasticity: &Plasticity<'_>,
) -> Result<f64, Error> {
    check_positive("yield stress", plasticity.yield_stress)?;
    let hardening = plasticity.hardening;
    check_number("hardening", hardening, true, "a finite number is needed")?;
    let n = problem.pressure.len();
    if problem.earlier.is_some() {
        check("earlier plastic slip", plasticity.earlier, n)?;
    }
    let Friction::Coulomb(coefficient) = problem.friction else {
        return Err(Error::YieldWithSlipLaw);
    };
    check_softening(operators, problem.pressure, hardening)?;
    let friction: Vec<f64> = coefficient
        .iter()
        .zip(problem.pressure)
        .map(|(mu, p)| mu * p.max(0.0))
        .collect();
    if hardening > 0.0 {
        return Ok(friction.iter().sum());
    }
    let yielding = Yielding::new(operators, problem, plasticity, 0, friction);
    Ok(yielding.at_rest().iter().sum())
}

/// Checks the law; returns the sum of the largest traction bounds [Pa].
fn check_friction(problem: &TangentialProblem<'_>) -> Result<f64, Error> {
    let wanted = "a coefficient of friction must not be negative";
    let total: f64 = problem.pressure.iter().map(|p| p.max(0.0)).sum();
    match problem.friction {
        Friction::Coulomb(coefficient) => {
            check("friction coefficient", coefficient, problem.pressure.len())?;
            for mu in coefficient {
                check_number("friction coefficient", *mu, *mu >= 0.0, wanted)?;
            }
            let bound = coefficient.iter().zip(problem.pressure);
            Ok(bound.map(|(mu, p)| mu * p.max(0.0)).sum())
        }
        Friction::StaticKinetic { at_rest, kinetic } => {
            check_number("kinetic coefficient", *kinetic, *kinetic >= 0.0, wanted)?;
            check_number(
                "static coefficient",
                *at_rest,
                at_rest >= kinetic,
                "it must not be below the kinetic one",
            )?;
            Ok(at_rest * total)
        }
        // its numbers are those of a law already
        Friction::TemperatureDependent(law) => Ok(law.largest() * total),
        Friction::SpeedDependent { law, memory } => {
            let most = match law {
                SlipLaw::Exponential {
                    at_rest,
                    kinetic,
                    half_slip,
                } => {
                    check_positive("half_slip", *half_slip)?;
                    check_number("static coefficient", *at_rest, *at_rest >= 0.0, wanted)?;
                    check_number("kinetic coefficient", *kinetic, *kinetic >= 0.0, wanted)?;
                    at_rest.max(*kinetic)
                }
                SlipLaw::Table {
                    slip_speed,
                    coefficient,
                } => {
                    check("slip speed", slip_speed, coefficient.len())?;
                    let rises = slip_speed.windows(2).all(|w| w[1] > w[0]);
                    let first = slip_speed.first().copied().unwrap_or(f64::NAN);
                    check_number(
                        "first slip speed",
                        first,
                        rises && first.abs() <= 0.0,
                        "slip speeds must rise strictly from 0",
                    )?;
                    for mu in coefficient {
                        check_number("friction coefficient", *mu, *mu >= 0.0, wanted)?;
                    }
                    coefficient.iter().copied().fold(0.0, f64::max)
                }
            };
            if let Some(memory) = memory {
                check_positive("memory distance", memory.distance)?;
                check_positive("memory slip speed", memory.min_slip)?;
            }
            Ok(most * total)
        }
    }
}

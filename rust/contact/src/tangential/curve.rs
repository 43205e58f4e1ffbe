use mtb_operator::Monitor;

use super::operators::PatchOperators;
use super::problem::{Drive, TangentialProblem};
use super::solve::solve;
use crate::Error;
use crate::friction::Friction;

/// Forces and moments `(F_x, F_y, M_z)` on the lower body over creepages `(xi, eta, phi)` in steady rolling,
/// and whether each solve converged.
///
/// # Errors
/// As [`solve`].
#[allow(
    clippy::too_many_arguments,
    reason = "the arguments of the problem, one by one"
)]
pub fn creep_curve(
    operators: &PatchOperators,
    pressure: &[f64],
    origin: [f64; 2],
    creepages: &[[f64; 3]],
    speed: f64,
    friction: &Friction,
    tolerance: f64,
    monitor: Monitor<'_>,
) -> Result<(Vec<[f64; 3]>, Vec<bool>), Error> {
    let mut forces = Vec::with_capacity(creepages.len());
    let mut converged = Vec::with_capacity(creepages.len());
    for creepage in creepages {
        let problem = TangentialProblem {
            pressure,
            origin,
            drive: [Drive::Slip(creepage[0]), Drive::Slip(creepage[1])],
            spin: creepage[2],
            speed,
            friction,
            earlier: None,
            start: None,
            tolerance,
        };
        let solution = solve(operators, &problem, monitor)?;
        forces.push([solution.force[0], solution.force[1], solution.spin_moment]);
        converged.push(solution.converged);
    }
    Ok((forces, converged))
}

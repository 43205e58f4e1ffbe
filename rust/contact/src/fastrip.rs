// SPDX-License-Identifier: MIT OR Apache-2.0
//! FaStrip: strip theory where the surfaces stick, the direction of FASTSIM where they slip.
//!
//! On each strip along the rolling direction, of half-length `a`, the traction is that of two semicircles, the
//! second of which touches the leading edge and is shorter by the distance `d`: strips do not feel one another. The
//! creepages are multiplied such that Kalker's linear forces come out. Where the surfaces slip, the traction has
//! the size of its bound and the direction that FASTSIM gives. [SichaniEnblomBerg2016], [Kalker1967]

use std::f64::consts::PI;

use crate::Error;
use crate::error::{check, check_number, check_positive};
use crate::fastsim::{FoundationProblem, FoundationSolution, solve as solve_foundation, totals};
use crate::friction::Friction;
use crate::kalker::CreepCoefficients;

/// The half-spaces and the ellipse that strip theory is adapted to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StripTheory {
    /// Shear modulus of both bodies [Pa].
    pub shear_modulus: f64,
    /// Poisson's ratio of both bodies.
    pub poisson_ratio: f64,
    /// Semi-axis of the ellipse along the rolling direction over the one across.
    pub ratio: f64,
    /// Kalker's coefficients of this ratio.
    pub coefficients: CreepCoefficients,
    /// Whether the traction at the edge of adhesion has the direction that CONTACT gives it; otherwise it has the one by
    /// which all that sticks has no slip.
    pub like_contact: bool,
}

/// Solves for one creepage `(xi, eta, phi)`, `phi` in [1/m], with the elliptic bound of `problem`.
///
/// # Errors
/// As [`crate::fastsim::solve`]; [`Error::Number`] for friction that depends on the slip.
pub fn solve(
    problem: &FoundationProblem<'_>,
    theory: &StripTheory,
    creepage: [f64; 3],
) -> Result<FoundationSolution, Error> {
    check_positive("shear modulus", theory.shear_modulus)?;
    check_positive("ratio", theory.ratio)?;
    let Friction::Coulomb(coefficient) = problem.friction else {
        return Err(Error::Number {
            name: "friction",
            value: f64::NAN,
            wanted: "FaStrip takes Coulomb's friction only",
        });
    };
    let mut solution = solve_foundation(problem, creepage)?;
    check("friction coefficient", coefficient, problem.bound.len())?;
    check_number(
        "poisson_ratio",
        theory.poisson_ratio,
        (0.0..=0.5).contains(&theory.poisson_ratio),
        "a number from 0 to 0.5 is needed",
    )?;
    let strips = problem.strips();
    let cells = problem.bound.iter().filter(|p| **p > 0.0).count();
    let area = cells as f64 * problem.cell[0] * problem.cell[1];
    let force: f64 = problem.bound.iter().sum::<f64>() * problem.cell[0] * problem.cell[1];
    if cells == 0 {
        return Ok(solution);
    }
    // peak over semi-axis, of the ellipse of this ratio that has the area and the force of the patch
    let steepness = 1.5 * force / area / (area / PI * theory.ratio).sqrt();
    let c = &theory.coefficients;
    let nu = theory.poisson_ratio;
    let linear = [
        4.0 * (1.0 - nu) / (PI * PI) * c.c11,
        4.0 / (PI * PI) * c.c22,
        3.0 / (PI * theory.ratio.sqrt()) * c.c23,
    ];
    let [xi, eta] = strips.turned([creepage[0], creepage[1]]);
    let spin = 0.5 * theory.shear_modulus * linear[2] * creepage[2];
    let n = problem.bound.len();
    for (k, strip) in strips.extents(coefficient).into_iter().enumerate() {
        let Some((extent, mu)) = strip else { continue };
        let place = strips.centre(k);
        let bound = coefficient[k] * problem.bound[k];
        // gradients of the traction: of what would stick from edge to edge, and the largest one
        let x = (0.5 * theory.shear_modulus * linear[0] * xi - spin * place[1]) / (1.0 - nu);
        let y = 0.5 * theory.shear_modulus * linear[1] * eta + spin * (place[0] - extent.ahead);
        let whole = mu * steepness;
        let foundation = [solution.traction[k], solution.traction[n + k]];
        let sticking = Strip {
            x,
            y,
            spin,
            whole,
            half: extent.half,
        }
        .sticking(extent.ahead, theory.like_contact.then_some(1.0 - nu));
        let (q, slips) = if let Some(q) = sticking {
            let size = q[0].hypot(q[1]);
            if size > bound && !theory.like_contact {
                // friction carries no more than its bound
                (strips.back(q.map(|v| v * bound / size)), false)
            } else {
                (strips.back(q), false)
            }
        } else {
            let size = foundation[0].hypot(foundation[1]);
            let scale = if size > 0.0 { bound / size } else { 0.0 };
            (foundation.map(|v| v * scale), true)
        };
        solution.traction[k] = q[0];
        solution.traction[n + k] = q[1];
        solution.is_slipping[k] = slips;
        if !slips {
            solution.slip[k] = 0.0;
            solution.slip[n + k] = 0.0;
        }
    }
    (solution.force, solution.spin_moment) = totals(problem, &solution.traction);
    Ok(solution)
}

/// One strip: gradients of the traction [Pa/m] by the creepages in its middle and by the spin, the largest one that
/// friction allows, and its half-length [m].
struct Strip {
    x: f64,
    y: f64,
    spin: f64,
    whole: f64,
    half: f64,
}

impl Strip {
    /// The traction `ahead` of the middle, where the surfaces stick there; `of_contact`: `1 - nu` for the direction that
    /// CONTACT gives to it.
    fn sticking(&self, ahead: f64, of_contact: Option<f64>) -> Option<[f64; 2]> {
        let Self {
            x,
            y,
            spin,
            whole,
            half,
        } = *self;
        let rest = whole * whole - spin * spin;
        if rest <= 0.0 {
            return None;
        }
        // |(x, y) / d + (0, spin)| is the largest gradient
        let d = (y * spin + (x * x * rest / (whole * whole) + y * y).sqrt() * whole) / rest;
        if d >= half || ahead <= 2.0 * d - half {
            return None;
        }
        let full = (half * half - ahead * ahead).max(0.0).sqrt();
        let inner = ((half - d).powi(2) - (ahead - d).powi(2)).max(0.0).sqrt();
        // the difference of both semicircles over d
        let rise = 2.0 * (half - ahead) / (full + inner);
        if let Some(softer) = of_contact {
            let direction = [softer * x, softer * y + spin * d];
            let size = direction[0].hypot(direction[1]);
            if size == 0.0 {
                return Some([0.0, spin * full]);
            }
            let [kx, ky] = direction.map(|v| v * whole / size);
            return Some([kx * d * rise, spin * full + (ky - spin) * d * rise]);
        }
        Some([x * rise, y * rise + spin * full])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_edge_of_adhesion_meets_the_bound() {
        // at x = 2 d - a the inner semicircle ends, and the traction is that of the outer one
        let strip = Strip {
            x: 2.0,
            y: -1.0,
            spin: 0.4,
            whole: 3.0,
            half: 5.0,
        };
        let rest = 9.0 - 0.16;
        let d = (-0.4 + (4.0 * rest / 9.0 + 1.0_f64).sqrt() * 3.0) / rest;
        let edge = 2.0 * d - 5.0;
        let full = (25.0 - edge * edge).sqrt();
        let q = strip.sticking(edge + 1e-9, None).unwrap();
        assert!(
            (q[0].hypot(q[1]) / (3.0 * full) - 1.0).abs() < 1e-4,
            "{q:?}"
        );
        assert!(strip.sticking(edge - 1e-9, None).is_none());
        // without spin both directions are the same
        let pure = Strip { spin: 0.0, ..strip };
        let (own, of_contact) = (pure.sticking(1.0, None), pure.sticking(1.0, Some(0.7)));
        for (u, v) in own.unwrap().iter().zip(of_contact.unwrap()) {
            assert!((u - v).abs() < 1e-12);
        }
    }
}

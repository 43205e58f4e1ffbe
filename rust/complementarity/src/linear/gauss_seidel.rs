// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::{Monitor, report};

use super::problem::{Problem, Solution, Status};
use crate::error::Error;

/// Projected Gauss-Seidel (relaxation `omega`), kept for comparison.
///
/// Converges for symmetric positive definite matrices; with friction it cycles although the matrix is
/// still positive definite. Motions must be prescribed (no border).
///
/// # Errors
/// As [`super::solve`].
pub fn gauss_seidel(
    problem: &Problem<'_>,
    omega: f64,
    tolerance: f64,
    max_sweeps: usize,
    monitor: Monitor<'_>,
) -> Result<Solution, Error> {
    problem.check()?;
    if problem.border.is_some() {
        return Err(Error::Shape {
            name: "border",
            expected: 0,
            found: problem.motions(),
        });
    }
    let n = problem.dim();
    let mut pressure = vec![0.0; n];
    let mut residual = f64::INFINITY;
    let mut sweeps = 0;
    while sweeps < max_sweeps && residual > tolerance {
        sweeps += 1;
        for i in 0..n {
            let row = &problem.matrix[i * n..(i + 1) * n];
            let w: f64 =
                problem.offset[i] + row.iter().zip(&pressure).map(|(a, p)| a * p).sum::<f64>();
            let limit = problem.limit.map_or(f64::INFINITY, |limit| limit[i]);
            pressure[i] = (pressure[i] - omega * w / row[i]).clamp(0.0, limit);
        }
        let slack = problem.slack(&pressure, &[]);
        residual = problem.residual(&pressure, &slack, &[]);
        if !residual.is_finite() {
            break;
        }
        report(monitor, sweeps, residual)?;
    }
    let slack = problem.slack(&pressure, &[]);
    let status = if residual <= tolerance {
        Status::Solved
    } else {
        Status::IterationLimit
    };
    Ok(Solution {
        status,
        pressure,
        slack,
        motion: Vec::new(),
        iterations: sweeps,
        residual,
        by_lemke: false,
        determinant_sign: 1.0,
    })
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! The slip that is known before the tractions: of the rigid motion, of the pressure, of the earlier state.

use mtb_operator::{Grid, LinearOperator};

use super::operators::PatchOperators;
use super::problem::{Drive, TangentialProblem};
use super::table::{Share, upstream};

/// The image of no traction, minus the rigid slip that is given: `F = A q + offset`, `S = -F`.
pub(super) fn offset(operators: &PatchOperators, problem: &TangentialProblem<'_>) -> Vec<f64> {
    let grid = operators.grid();
    let n = grid.points();
    let given = problem.drive.map(|d| match d {
        Drive::Slip(value) => value,
        Drive::Force(_) => 0.0,
    });
    let mut offset = rigid_slip(operators, problem, given, [0.0; 2]);
    for f in &mut offset {
        *f = -*f;
    }
    let transform = operators.transform();
    let (first, second) = offset.split_at_mut(n);
    if let Some([along, across]) = &operators.pressure_now {
        // the slip grows by the displacement that the pressure causes, the image falls
        transform.apply_add(along, -1.0, problem.pressure, first);
        transform.apply_add(across, -1.0, problem.pressure, second);
    }
    if operators.is_coupled() {
        let still = vec![0.0; 2 * n];
        let mut image = vec![0.0; 2 * n];
        let fine = &operators.levels[0].slip;
        fine.apply_to(&still, Some(problem.pressure), &mut image);
        offset.iter_mut().zip(image).for_each(|(f, i)| *f += i);
    }
    let (first, second) = offset.split_at_mut(n);
    let Some(earlier) = problem.earlier else {
        return offset;
    };
    if let Some([along, across]) = &operators.pressure_earlier {
        transform.apply_add(along, 1.0, &earlier.pressure, first);
        transform.apply_add(across, 1.0, &earlier.pressure, second);
    }
    if operators.earlier.is_some() {
        let image = ahead(operators, &earlier.traction, &earlier.pressure);
        offset.iter_mut().zip(image).for_each(|(f, i)| *f -= i);
        for c in 0..2 {
            let layer = operators.layer_ahead(&earlier.traction[c * n..(c + 1) * n]);
            for (f, q) in offset[c * n..(c + 1) * n].iter_mut().zip(layer) {
                *f -= operators.layer * q;
            }
        }
    }
    offset
}

/// Minus the slip (2n), at the leading faces of cells where it is of second order: drives are given.
pub(super) fn image_at_faces(
    operators: &PatchOperators,
    problem: &TangentialProblem<'_>,
    traction: &[f64],
) -> Vec<f64> {
    let mut image = vec![0.0; traction.len()];
    operators.levels[0].slip.apply(traction, &mut image);
    let given = offset(operators, problem);
    image.iter_mut().zip(given).for_each(|(f, o)| *f += o);
    image
}

/// What tractions (2n), and on rows that are not alike pressures (n), do one step ahead of them; nothing in steady rolling.
pub(super) fn ahead(operators: &PatchOperators, traction: &[f64], pressure: &[f64]) -> Vec<f64> {
    let mut image = vec![0.0; traction.len()];
    let Some(kernels) = &operators.earlier else {
        return image;
    };
    let transform = operators.transform();
    match &operators.turn {
        Some(turn) => kernels.apply_turned(transform, turn, traction, Some(pressure), &mut image),
        None => kernels.apply(transform, traction, &mut image),
    }
    if let Some(across) = &operators.across_ahead {
        let (along, aside) = traction.split_at(traction.len() / 2);
        across.add(1.0, [Some(along), Some(aside), Some(pressure)], &mut image);
    }
    image
}

/// Rigid slip (2n) at the places `away` [m] from the cells: [m] in a shift and over a transient step, relative in
/// steady rolling.
pub(super) fn rigid_slip(
    operators: &PatchOperators,
    problem: &TangentialProblem<'_>,
    drive: [f64; 2],
    away: [f64; 2],
) -> Vec<f64> {
    let grid = operators.grid();
    let n = grid.points();
    let ahead = operators.ahead();
    let length = operators.motion.length();
    let first = [0, 1].map(|c| problem.origin[c] + away[c] + ahead[c]);
    let mut slip = vec![0.0; 2 * n];
    for k in 0..n {
        let x = first[0] + (k % grid.nx) as f64 * grid.dx;
        let y = first[1] + (k / grid.nx) as f64 * grid.dy;
        slip[k] = length * (drive[0] - problem.spin * y);
        slip[n + k] = length * (drive[1] + problem.spin * x);
    }
    if let Some(given) = problem.rigid_slip {
        let places = upstream(&grid, away);
        let at = |k: usize, d: [isize; 2]| {
            let i = (k % grid.nx) as isize + d[0];
            let j = (k / grid.nx) as isize + d[1];
            let (i, j) = (
                i.clamp(0, grid.nx as isize - 1),
                j.clamp(0, grid.ny as isize - 1),
            );
            j as usize * grid.nx + i as usize
        };
        for (c, slip) in slip.chunks_exact_mut(n).enumerate() {
            for (k, slip) in slip.iter_mut().enumerate() {
                let value: f64 = places
                    .iter()
                    .map(|(d, w)| w * given[c * n + at(k, *d)])
                    .sum();
                *slip += length * value;
            }
        }
    }
    slip
}

/// Values of a field one step ahead, by bilinear interpolation; `outside` beyond the grid.
pub(super) fn carried(grid: &Grid, step: [f64; 2], field: &[f64], outside: f64) -> Vec<f64> {
    mixed(grid, &upstream(grid, step), field, outside)
}

/// Sums of the values of a field at places around each cell, times their shares; `outside` beyond the grid.
pub(super) fn mixed(grid: &Grid, shares: &[Share], field: &[f64], outside: f64) -> Vec<f64> {
    (0..grid.points())
        .map(|k| {
            shares
                .iter()
                .map(|(d, w)| neighbour(grid, k, *d).map_or(outside, |m| field[m]) * w)
                .sum()
        })
        .collect()
}

/// Point `d` cells away from point `k`, if it is on the grid.
pub(super) fn neighbour(grid: &Grid, k: usize, d: [isize; 2]) -> Option<usize> {
    let i = (k % grid.nx).checked_add_signed(d[0])?;
    let j = (k / grid.nx).checked_add_signed(d[1])?;
    (i < grid.nx && j < grid.ny).then_some(j * grid.nx + i)
}

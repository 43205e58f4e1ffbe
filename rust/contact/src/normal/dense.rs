// SPDX-License-Identifier: MIT OR Apache-2.0
//! Few cells: the dense matrix and the active-set method.

use mtb_complementarity::bounded::{Judgement, Status};
use mtb_complementarity::linear;
use mtb_operator::dense::Watch;
use mtb_operator::{Buffers, Component, Grid, Monitor, report, unmonitored};

use super::level::{Level, Region, half_sides};
use super::nested::{error_of, unpack_motion};
use super::product::{Influence, Product};
use super::{Load, Method, NormalContact, NormalSolution, Surface};
use crate::Error;

/// Residual that rounding may leave where none is asked for.
const ROUNDING: f64 = 1e-8;

/// Solves to rounding; the grid of half as many cells per side serves the error estimate.
pub(super) fn solve(
    contact: &NormalContact<'_>,
    tolerance: Option<f64>,
    monitor: Monitor<'_>,
) -> Result<NormalSolution, Error> {
    let levels = Level::pyramid(contact);
    let fine = &levels[0];
    let (solution, residual) = on_level(contact, fine, monitor)?;
    let mut discretisation_error = None;
    if let Some(coarse) = levels.get(1) {
        let (start, _) = on_level(contact, coarse, monitor)?;
        let difference =
            fine.difference(&solution.pressure, coarse, &start.pressure, f64::INFINITY);
        discretisation_error = error_of(difference, None);
    }
    let tolerance = tolerance.unwrap_or(ROUNDING);
    let half = half_sides(&contact.grid);
    let (approach, tilts) = unpack_motion(contact, &solution.motion, half);
    let status = match solution.status {
        linear::Status::Solved if residual <= tolerance => Status::Solved,
        linear::Status::Solved => Status::Stagnated,
        linear::Status::Unreachable | linear::Status::Overloaded | linear::Status::NoSolution => {
            Status::Unreachable
        }
        linear::Status::IterationLimit => Status::IterationLimit,
    };
    Ok(NormalSolution {
        status,
        method: Method::Dense,
        pressure: solution.pressure,
        gap: solution.slack,
        approach,
        tilts,
        iterations: solution.iterations,
        products: 0.0,
        preconditionings: 0.0,
        residual,
        tolerance,
        history: vec![residual],
        discretisation_error,
    })
}

/// The solution, and its residual.
fn on_level(
    contact: &NormalContact<'_>,
    level: &Level,
    monitor: Monitor<'_>,
) -> Result<(linear::Solution, f64), Error> {
    let region = Region::whole(&level.grid);
    let n = region.points();
    let offset = level.offset(&region, contact.load);
    let modes = level.modes(&region, contact);
    let shapes: Vec<f64> = modes.iter().flat_map(|m| m.shape.iter().copied()).collect();
    let target: Vec<f64> = modes.iter().map(|m| m.target).collect();
    // Over a period displacements are known up to their mean, so that with every cell in contact the matrix
    // is singular. A uniform displacement under every pressure heals that, and goes back into the approach.
    let is_loose =
        matches!(contact.surface, Surface::Periodic(_)) && matches!(contact.load, Load::Force(_));
    let (matrix, lift) = match contact.surface {
        Surface::Body(body) => {
            let mut matrix = vec![0.0; n * n];
            body.add_influence(Component::Normal, Component::Normal, 1.0, &mut matrix);
            report(monitor, 0, f64::NAN)?;
            (matrix, 0.0)
        }
        Surface::FreeSpace(influence) => {
            let table = table(influence, level);
            (matrix(level, &table, 0.0, monitor)?, 0.0)
        }
        Surface::Inclined(influence, _) => {
            let table = table(influence, level);
            let mut matrix = matrix(level, &table, 0.0, monitor)?;
            if let Some(turn) = level.turn(&region, contact.surface) {
                for (k, entry) in matrix.iter_mut().enumerate() {
                    *entry *= turn.cosine(k / n / region.nx, k % n / region.nx);
                }
            }
            (matrix, 0.0)
        }
        Surface::Rolling(influence) => (whole_matrix(influence, level, monitor)?, 0.0),
        Surface::Periodic(_) => {
            let table = column(contact.surface, level);
            let lift = if is_loose { table[0] } else { 0.0 };
            (matrix(level, &table, lift, monitor)?, lift)
        }
    };
    let border = linear::Border {
        motion: &shapes,
        balance: &shapes,
        target: &target,
    };
    let problem = linear::Problem {
        matrix: &matrix,
        offset: &offset,
        border: (!modes.is_empty()).then_some(border),
        symmetric: !matches!(contact.surface, Surface::Rolling(_)),
        limit: None,
    };
    debug_assert_eq!(offset.len(), n);
    let mut solution = linear::solve(&problem, &linear::Options::default(), monitor)?;
    let lifted = lift * solution.pressure.iter().sum::<f64>();
    // what is set to zero by the solver is not zero to the last digit
    let slack = problem.slack(&solution.pressure, &solution.motion);
    let mut judged = Judgement::default();
    for i in 0..n {
        let moved = (0..modes.len()).map(|k| shapes[k * n + i] * solution.motion[k]);
        let displacement = slack[i] - offset[i] + moved.sum::<f64>() - lifted;
        judged.take(solution.pressure[i], slack[i], displacement);
    }
    if let Some(approach) = solution.motion.first_mut() {
        *approach -= lifted;
    }
    Ok((solution, judged.residual()))
}

/// Influence at all offsets between cells in free space.
fn table(influence: Influence<'_>, level: &Level) -> Vec<f64> {
    let (nx, n) = (level.grid.nx, level.grid.points());
    let at = |k: usize| {
        [
            (k % nx) as f64 * level.grid.dx,
            (k / nx) as f64 * level.grid.dy,
        ]
    };
    let cell = [level.grid.dx, level.grid.dy];
    (0..n).map(|k| influence(at(k), cell)).collect()
}

/// The influence matrix of cells whose influence has no symmetry.
fn whole_matrix(
    influence: Influence<'_>,
    level: &Level,
    monitor: Monitor<'_>,
) -> Result<Vec<f64>, Error> {
    let Grid { nx, ny, dx, dy } = level.grid;
    let (width, n) = (2 * nx - 1, level.grid.points());
    let mut watch = Watch::new(monitor);
    let mut table = Vec::with_capacity(width * (2 * ny - 1));
    for j in 0..2 * ny - 1 {
        let y = (j as f64 - (ny - 1) as f64) * dy;
        table.extend((0..width).map(|i| {
            let x = (i as f64 - (nx - 1) as f64) * dx;
            influence([x, y], [dx, dy])
        }));
        watch.spend(1e5 * width as f64)?;
    }
    let mut matrix = Vec::with_capacity(n * n);
    for row in 0..n {
        let (i, j) = (row % nx, row / nx);
        for line in 0..ny {
            let from = &table[(j + ny - 1 - line) * width..][..width];
            matrix.extend((0..nx).map(|column| from[i + nx - 1 - column]));
        }
        watch.spend(4.0 * n as f64)?;
    }
    Ok(matrix)
}

/// Influence of a load on the first cell: over a period that is the influence at all offsets.
fn column(surface: Surface<'_>, level: &Level) -> Vec<f64> {
    let (shape, n) = ([level.grid.nx, level.grid.ny], level.grid.points());
    let product = Product::influence(
        surface,
        &level.grid,
        shape,
        &Buffers::default(),
        &unmonitored,
    );
    let mut unit = vec![0.0; n];
    unit[0] = 1.0;
    let mut column = vec![0.0; n];
    product.apply(&unit, &mut column, &unmonitored);
    column
}

/// The influence matrix, with `lift` added to every entry.
fn matrix(
    level: &Level,
    table: &[f64],
    lift: f64,
    monitor: Monitor<'_>,
) -> Result<Vec<f64>, Error> {
    let (nx, n) = (level.grid.nx, level.grid.points());
    let mut watch = Watch::new(monitor);
    let mut matrix = Vec::with_capacity(n * n);
    for row in 0..n {
        let (i, j) = (row % nx, row / nx);
        for line in 0..level.grid.ny {
            let from = &table[j.abs_diff(line) * nx..][..nx];
            matrix.extend((0..nx).map(|column| from[i.abs_diff(column)] + lift));
        }
        watch.spend(4.0 * n as f64)?;
    }
    Ok(matrix)
}

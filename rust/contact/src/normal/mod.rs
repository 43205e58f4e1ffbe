// SPDX-License-Identifier: MIT OR Apache-2.0
//! The normal problem on a regular grid: pressures that keep two surfaces from penetrating.
//!
//! Bodies of any kind are a [`Compliance`] on the cells. Half-spaces under uniformly loaded cells make the influence matrix a convolution. The solver
//! climbs from coarse grids to fine ones: each level starts from the pressure of the one before, works
//! on the rectangle around the contact only, and inverts roughly by the Fourier transform of the
//! same kernel, wrapped around, of displacements that are continued smoothly beyond the contact. Few cells are solved by the dense active-set method instead.

mod dense;
mod extension;
mod inverse;
mod level;
mod nested;
mod plane;
mod product;
mod tangent;

use mtb_complementarity::bounded::Status;
use mtb_operator::{Compliance, Grid, Monitor, check_factors};

use crate::error::{Error, check, check_number, check_positive};
use crate::inclination::Inclination;
use crate::interface::RoughLaw;

pub use tangent::{Derived, NormalChange, NormalResponse, adjoint, forward};

/// What surrounds the grid, and how a pressure on one cell moves the surface; both bodies together.
#[derive(Clone, Copy)]
pub enum Surface<'a> {
    /// Nothing loaded outside: closing of the gap [m/Pa] at `offset` [m] from the centre of a loaded cell
    /// with sides `cell` [m]; even along x and along y.
    FreeSpace(&'a (dyn Fn([f64; 2], [f64; 2]) -> f64 + Sync)),
    /// As `FreeSpace`, without any symmetry: bodies that creep while the contact rolls over them. A hardness is not
    /// known.
    Rolling(&'a (dyn Fn([f64; 2], [f64; 2]) -> f64 + Sync)),
    /// As `FreeSpace`, on a surface that turns across the rows of cells: with its inclination at the place y [m] from
    /// the middle of the grid.
    Inclined(
        &'a (dyn Fn([f64; 2], [f64; 2]) -> f64 + Sync),
        Inclination<'a>,
    ),
    /// The grid repeats itself: amplitude of the displacement [m/Pa] by a pressure wave with a wave
    /// number [1/m]. The mean of the displacement is left out: it is part of the approach.
    Periodic(&'a (dyn Fn(f64) -> f64 + Sync)),
    /// Any bodies, known on this grid alone: their normal displacement by a pressure on its cells, such as that of
    /// [`Relative`](mtb_operator::Relative). No coarser grid helps, and none tells the discretisation error.
    Body(&'a dyn Compliance),
}

/// What is known of the approach of the bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load {
    /// Normal force [N], positive; the approach is found.
    Force(f64),
    /// Approach [m], positive where the bodies moved together.
    Approach(f64),
}

/// Two surfaces pressed together.
#[derive(Clone, Copy)]
pub struct NormalContact<'a> {
    /// Undeformed gap (ny * nx) [m], x fastest, > 0 open.
    pub gap: &'a [f64],
    /// The cells.
    pub grid: Grid,
    /// The bodies.
    pub surface: Surface<'a>,
    /// Force or approach.
    pub load: Load,
    /// First moments of the pressure about the centre of the grid, along x and y [N m]; `None` locks the tilt.
    pub moments: [Option<f64>; 2],
    /// Pressure [Pa] at which the softer body flows; `None` for bodies that stay elastic.
    pub hardness: Option<f64>,
    /// Law of a rough layer between the bodies.
    pub rough: Option<&'a RoughLaw>,
    /// Pressure (ny * nx) [Pa] to start from, in place of coarser grids, which then tell no discretisation error; one
    /// of zero, and the dense method, go without.
    pub start: Option<&'a [f64]>,
}

/// Which algorithm solves, and how well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Relative complementarity residual to reach; `None`: well below the discretisation error.
    pub tolerance: Option<f64>,
    /// The algorithm.
    pub method: Method,
}

/// The algorithm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Dense for few cells that do not repeat themselves, otherwise by the Fourier transform.
    Auto,
    /// Active sets with a dense matrix.
    Dense,
    /// Conjugate gradients with convolutions, or with the products of a body.
    Fourier,
}

/// The solved contact, or where the search ended.
#[derive(Clone, Debug)]
pub struct NormalSolution {
    /// How it ended; only [`Status::Solved`] is a solution.
    pub status: Status,
    /// The algorithm taken.
    pub method: Method,
    /// Pressure (ny * nx) [Pa].
    pub pressure: Vec<f64>,
    /// Deformed gap (ny * nx) [m]; where the pressure is the hardness, minus the depth to which a body has flowed.
    pub gap: Vec<f64>,
    /// Approach [m].
    pub approach: f64,
    /// Closing tilts along x and y about the centre of the grid [-].
    pub tilts: [f64; 2],
    /// Iterations on the finest grid.
    pub iterations: usize,
    /// Products with the influence matrix on all grids, in equivalents of one on the whole finest grid.
    pub products: f64,
    /// Applications of the preconditioner, likewise.
    pub preconditionings: f64,
    /// Relative complementarity residual over the whole grid: the largest gap where there is pressure or penetration
    /// where there is none, over the root mean square of the elastic displacement where there is pressure, which
    /// contains the compression of a layer.
    pub residual: f64,
    /// Residual aimed at.
    pub tolerance: f64,
    /// Residuals on the finest grid, by iteration.
    pub history: Vec<f64>,
    /// Estimated relative error of the pressure by the size of the cells (L2 over the contact away from its
    /// border), from the coarser grids; `None` where there are none or no such points.
    pub discretisation_error: Option<f64>,
}

/// A solution as its derivatives see it.
#[derive(Clone, Copy, Debug)]
pub struct NormalState<'a> {
    /// Pressure (ny * nx) [Pa].
    pub pressure: &'a [f64],
    /// Deformed gap (ny * nx) [m].
    pub gap: &'a [f64],
    /// Approach [m].
    pub approach: f64,
    /// Closing tilts along x and y about the centre of the grid [-].
    pub tilts: [f64; 2],
}

impl NormalSolution {
    /// What derivatives need to know of it.
    pub fn state(&self) -> NormalState<'_> {
        NormalState {
            pressure: &self.pressure,
            gap: &self.gap,
            approach: self.approach,
            tilts: self.tilts,
        }
    }
}

/// Share of the force under which all of a grid flows that is left to rounding.
const FLOWING: f64 = 1e-9;

/// Cells up to which the dense method is the quicker one.
const DENSE_UP_TO: usize = 300;

/// Cells up to which it solves what the Fourier method does not: a matrix of 130 MB, and seconds.
const DENSE_INSTEAD: usize = 4000;

/// Cells that the dense method takes at most, for its time.
const DENSE_AT_MOST: usize = 10_000;

/// Bytes that the Fourier method takes at most: a cell, and besides for each cell of the longest row and column.
const CELL: f64 = 216.0;
const COLUMN: f64 = 550.0;
const ROW: f64 = 1800.0;

/// Cells that the Fourier method takes at most.
const CELLS_AT_MOST: usize = 100_000_000;

/// Memory [bytes] that a solve with a method takes on a grid of (nx, ny) cells, `Auto` as it would choose in free
/// space.
///
/// Measured: the matrix, its block in contact and Lemke's table; or fields, spectra and their turned copies
/// on all grids, with the whole grid in contact. A grid of few rows or columns has spectra of more numbers than cells,
/// and lines of a prime number of cells are transformed by longer ones.
pub fn memory([nx, ny]: [usize; 2], method: Method) -> f64 {
    let cells = nx.saturating_mul(ny);
    let n = cells as f64;
    let is_dense = method == Method::Dense || method == Method::Auto && cells <= DENSE_UP_TO;
    if is_dense {
        return 24.0 * n * n;
    }
    CELL * n + COLUMN * nx as f64 + ROW * ny as f64
}

/// Solves the frictionless contact problem.
///
/// # Errors
/// Arrays or a compliance of the wrong length, numbers that are not finite or out of range, too many cells for the
/// dense method, and interruption by the monitor.
///
/// [PolonskyKeer1999, Vollebregt2014, Love1929]
pub fn solve_normal(
    contact: &NormalContact<'_>,
    options: Options,
    monitor: Monitor<'_>,
) -> Result<NormalSolution, Error> {
    let points = contact.grid.points();
    check_number("cells", points as f64, points > 0, "at least one is needed")?;
    for (name, side) in [("dx", contact.grid.dx), ("dy", contact.grid.dy)] {
        check_number(name, side, side > 0.0, "a positive number is needed")?;
    }
    check("gap", contact.gap, points)?;
    if let Some(start) = contact.start {
        check("start", start, points)?;
    }
    match contact.load {
        Load::Force(force) => {
            check_number("force", force, force > 0.0, "a positive number is needed")?;
        }
        Load::Approach(approach) => {
            check_number("approach", approach, true, "a finite number is needed")?;
        }
    }
    if let Some(hardness) = contact.hardness {
        check_positive("hardness", hardness)?;
        let most = hardness * points as f64 * contact.grid.cell_area();
        if let Load::Force(force) = contact.load {
            let is_possible = force < most * (1.0 - FLOWING);
            check_number(
                "force",
                force,
                is_possible,
                "it must be below the hardness times the area of the grid",
            )?;
        }
        check_number(
            "hardness",
            hardness,
            options.method != Method::Dense,
            "the dense method does not take it",
        )?;
    }
    if contact.hardness.is_some() && matches!(contact.surface, Surface::Rolling(_)) {
        return Err(Error::NoCreep);
    }
    if contact.rough.is_some() && options.method == Method::Dense {
        return Err(Error::NoInterface);
    }
    if let Some(tolerance) = options.tolerance {
        let is_possible = (1e-14..1.0).contains(&tolerance);
        check_number(
            "tolerance",
            tolerance,
            is_possible,
            "a number from 1e-14 to 1 is needed",
        )?;
    }
    let is_periodic = matches!(contact.surface, Surface::Periodic(_));
    let mut of_bodies = 0.0;
    if let Surface::Body(body) = contact.surface {
        if body.points() != points {
            return Err(Error::Shape {
                name: "surface",
                expected: points,
                found: body.points(),
            });
        }
        of_bodies = body.influence_memory();
    }
    let method = if options.method == Method::Dense {
        Method::Dense
    } else {
        Method::Fourier
    };
    if let Some(found) = plane::solve(contact, method, options.tolerance) {
        return Ok(found);
    }
    match options.method {
        Method::Dense => {
            let is_possible = points <= DENSE_AT_MOST;
            check_number(
                "cells",
                points as f64,
                is_possible,
                "the dense method takes at most 10000",
            )?;
            let needed = memory([points, 1], Method::Dense) + of_bodies;
            check_factors(points, needed)?;
            dense::solve(contact, options.tolerance, monitor)
        }
        Method::Auto
            if !is_periodic
                && points <= DENSE_UP_TO
                && contact.hardness.is_none()
                && contact.rough.is_none() =>
        {
            dense::solve(contact, options.tolerance, monitor)
        }
        _ => {
            let found = nested::solve(contact, options.tolerance, monitor)?;
            // a strip of long cells under an eccentric load, about one in some thousand
            let can_be_dense = options.method == Method::Auto
                && points <= DENSE_INSTEAD
                && contact.hardness.is_none();
            if found.status == Status::Solved || !can_be_dense {
                return Ok(found);
            }
            let dense = dense::solve(contact, options.tolerance, monitor)?;
            let is_better = dense.status == Status::Solved;
            Ok(if is_better { dense } else { found })
        }
    }
}

#[cfg(test)]
mod tests;

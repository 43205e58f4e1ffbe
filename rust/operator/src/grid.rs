// SPDX-License-Identifier: MIT OR Apache-2.0
use crate::Error;

/// A regular, cell-centred grid: `nx * ny` points, x fastest, each the centre of a cell `dx` by `dy`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Points along x.
    pub nx: usize,
    /// Points along y.
    pub ny: usize,
    /// Spacing along x [m].
    pub dx: f64,
    /// Spacing along y [m].
    pub dy: f64,
}

impl Grid {
    /// A grid of `nx * ny` points with spacings `dx`, `dy` [m].
    ///
    /// # Errors
    /// [`Error::Grid`] if a count is zero or a spacing not positive and finite.
    pub fn new(nx: usize, ny: usize, dx: f64, dy: f64) -> Result<Self, Error> {
        let positive = |d: f64| d > 0.0 && d.is_finite();
        if nx == 0 || ny == 0 || !positive(dx) || !positive(dy) {
            return Err(Error::Grid { nx, ny, dx, dy });
        }
        Ok(Self { nx, ny, dx, dy })
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.nx * self.ny
    }

    /// Area of one cell [m2].
    pub fn cell_area(&self) -> f64 {
        self.dx * self.dy
    }
}

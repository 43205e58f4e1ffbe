// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two bodies of which one or both are prisms, under equal cells in rows along them.

use std::ops::Range;
use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef};
use mtb_operator::{Component, Grid, Monitor, dense};

use super::Prism;
use super::rows::{Basis, Beside, Rows, Spectrum, column, turned};
use crate::Error;
use crate::half_space::Patch;

const COMPONENTS: [Component; 3] = [Component::X, Component::Y, Component::Normal];

/// What rows of equal cells on a prism move each other by, beside what a half-space of its material does.
///
/// The cells follow the surface of the section, and each row has its own normal.
pub struct PrismRows {
    rows: usize,
    dx: f64,
    waves: Vec<Beside>,
    largest: f64,
    tail: f64,
}

impl PrismRows {
    /// Of the cells of a `grid`: `edges` of the section under each of its rows, one row after the other.
    ///
    /// # Errors
    /// [`Error::Section`] for rows that are not as wide as those of the grid, and where the prism is not held;
    /// [`Error::Shape`], [`Error::Interrupted`].
    pub fn new(
        prism: &Prism,
        edges: &[Vec<[usize; 3]>],
        grid: Grid,
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let patch = Patch {
            grid,
            x0: 0.0,
            y0: 0.0,
        };
        let rows = Rows::new(prism, &[edges.to_vec()], &[patch], Basis::Cells)?;
        let Spectrum {
            waves,
            largest,
            tail,
        } = rows.spectrum(prism, grid.nx as f64 * grid.dx, monitor)?;
        Ok(Self {
            rows: grid.ny,
            dx: grid.dx,
            waves,
            largest,
            tail,
        })
    }

    /// Number of waves, the largest wave number [1/m], and the share that the last of them add to the displacement of
    /// any row by its own load [-].
    pub fn waves(&self) -> (usize, f64, f64) {
        (self.waves.len(), self.largest, self.tail)
    }

    /// Adds `sign(observed, loaded)` times the displacements, in the body's own frame, to `sums`; see
    /// [`PrismPair::influence`].
    fn add(
        &self,
        offsets: &[f64],
        rows: Range<usize>,
        sign: impl Fn(Component, Component) -> f64,
        sums: &mut [f64],
    ) {
        let (m, kept) = (self.rows, rows.len());
        let amplitude = |wave: &Beside| {
            wave.weight * column(Basis::Cells, wave.number, self.dx).powi(2) / self.dx
        };
        let along = |of: fn(f64) -> f64| {
            Mat::from_fn(self.waves.len(), offsets.len(), |w, i| {
                let wave = &self.waves[w];
                amplitude(wave) * of(wave.number * offsets[i])
            })
        };
        let (even, odd) = (along(f64::cos), along(f64::sin));
        for (o, observed) in COMPONENTS.into_iter().enumerate() {
            for (l, loaded) in COMPONENTS.into_iter().enumerate() {
                let block = (3 * o + l) * m * m;
                let (along, scale) = match turned(observed, loaded) {
                    None => (&even, 1.0),
                    Some(turn) => (&odd, turn),
                };
                let across = Mat::from_fn(kept * kept, self.waves.len(), |k, w| {
                    let (i, j) = (rows.start + k / kept, rows.start + k % kept);
                    self.waves[w].difference[block + i * m + j]
                });
                let mut moved = Mat::<f64>::zeros(kept * kept, offsets.len());
                matmul(
                    moved.as_mut(),
                    Accum::Replace,
                    &across,
                    along,
                    scale * sign(observed, loaded),
                    dense::threads(kept * kept),
                );
                add_block(sums, moved.as_ref(), 3 * o + l);
            }
        }
    }
}

/// Adds (pairs of rows, offsets) to a block of `[offset][block][pair]`.
fn add_block(sums: &mut [f64], moved: MatRef<'_, f64>, block: usize) {
    let pairs = moved.nrows();
    for i in 0..moved.ncols() {
        let sums = &mut sums[(9 * i + block) * pairs..][..pairs];
        for (sum, value) in sums.iter_mut().zip(moved.col(i).iter()) {
            *sum += value;
        }
    }
}

/// Prisms in contact: what they do beside half-spaces of their materials, relative to each other.
#[derive(Clone)]
pub struct PrismPair {
    /// The lower body, if it is a prism.
    pub lower: Option<Arc<PrismRows>>,
    /// The upper body likewise, seen in the mirror z = 0: below its surface.
    pub upper: Option<Arc<PrismRows>>,
}

impl PrismPair {
    /// Number of rows of cells.
    pub fn rows(&self) -> usize {
        let one = self.lower.as_ref().or(self.upper.as_ref());
        one.map_or(0, |body| body.rows)
    }

    /// Displacements [m/Pa] of the lower body relative to the upper one, along x, along the rising rows and into the
    /// lower body, of `rows` by tractions on cells of these rows that lie `offsets` [m] behind them along x:
    /// `[offset][3 observed + loaded][observed row][loaded row]`.
    ///
    /// The tractions act on the lower body and turned round on the upper one, the pressure on both.
    pub fn influence(&self, offsets: &[f64], rows: Range<usize>) -> Vec<f64> {
        let mut sums = vec![0.0; 9 * offsets.len() * rows.len() * rows.len()];
        if let Some(lower) = &self.lower {
            lower.add(offsets, rows.clone(), |_, _| 1.0, &mut sums);
        }
        if let Some(upper) = &self.upper {
            let is_mixed =
                |o: Component, l: Component| (o == Component::Normal) != (l == Component::Normal);
            let sign = |o, l| if is_mixed(o, l) { -1.0 } else { 1.0 };
            upper.add(offsets, rows, sign, &mut sums);
        }
        sums
    }
}

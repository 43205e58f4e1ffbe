// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stress at any points, by a sum over the loaded cells.

use mtb_operator::{Monitor, report};
use rayon::prelude::*;

use super::rectangle::{Stress, stress_influence};
use crate::{Error, Material};

/// Share of a cell beside its border that counts as the border itself.
const BORDER: f64 = 1e-9;

/// Influences between two looks at the monitor: a tenth of a second on a slow core.
const UNWATCHED: usize = 200_000;

/// A rectangle of the surface with uniform tractions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadedCell {
    /// Its centre `[x, y]` [m].
    pub centre: [f64; 2],
    /// Its sides `[dx, dy]` [m].
    pub sides: [f64; 2],
    /// Tractions on the body along x and along y, and the pressure [Pa].
    pub traction: [f64; 3],
}

impl LoadedCell {
    fn has_on_border(&self, x: f64, y: f64) -> bool {
        let away = [x - self.centre[0], y - self.centre[1]];
        let beyond = [0, 1].map(|k| (away[k].abs() - 0.5 * self.sides[k]) / self.sides[k]);
        beyond[0].max(beyond[1]).abs() <= BORDER
    }
}

/// Stress [Pa] at points `[x, y, depth]` [m] of a half-space under uniform tractions on any rectangles of its surface,
/// in the body's own frame (tangential 1, tangential 2, into), tension positive.
///
/// # Errors
/// [`Error::Material`], [`Error::NotFinite`], [`Error::AboveSurface`], [`Error::CellSides`], [`Error::OnBorder`] for a
/// point on the surface at the border of a loaded cell, where the stress may be infinite, and [`Error::Interrupted`].
pub fn stress_at(
    material: &Material,
    cells: &[LoadedCell],
    points: &[[f64; 3]],
    monitor: Monitor<'_>,
) -> Result<Vec<Stress>, Error> {
    let material = Material::new(material.shear_modulus, material.poisson_ratio)?;
    for (index, point) in points.iter().enumerate() {
        if !point.iter().all(|v| v.is_finite()) {
            return Err(Error::NotFinite {
                name: "point",
                index,
            });
        }
        if point[2] < 0.0 {
            return Err(Error::AboveSurface {
                index,
                depth: point[2],
            });
        }
    }
    for (index, cell) in cells.iter().enumerate() {
        let numbers = cell.centre.iter().chain(&cell.sides);
        if !numbers.chain(&cell.traction).all(|v| v.is_finite()) {
            return Err(Error::NotFinite {
                name: "cell",
                index,
            });
        }
        if cell.sides.iter().any(|d| *d <= 0.0) {
            return Err(Error::CellSides(index));
        }
    }
    let loaded: Vec<&LoadedCell> = cells
        .iter()
        .filter(|cell| cell.traction.iter().any(|t| *t != 0.0))
        .collect();
    let on_border = points.iter().position(|[x, y, depth]| {
        *depth == 0.0 && loaded.iter().any(|cell| cell.has_on_border(*x, *y))
    });
    if let Some(index) = on_border {
        return Err(Error::OnBorder(index));
    }
    let at = |point: &[f64; 3]| {
        let mut sum = [0.0; 6];
        for cell in &loaded {
            let offset = [
                point[0] - cell.centre[0],
                point[1] - cell.centre[1],
                point[2],
            ];
            let found = stress_influence(material.poisson_ratio, offset, cell.sides);
            for (response, traction) in found.iter().zip(cell.traction) {
                for (sum, value) in sum.iter_mut().zip(response) {
                    *sum += traction * value;
                }
            }
        }
        sum
    };
    let round = (UNWATCHED / loaded.len().max(1)).max(1);
    let mut stress = Vec::with_capacity(points.len());
    for (number, part) in points.chunks(round).enumerate() {
        report(monitor, number, f64::NAN).map_err(|_| Error::Interrupted)?;
        stress.par_extend(part.par_iter().map(at));
    }
    Ok(stress)
}

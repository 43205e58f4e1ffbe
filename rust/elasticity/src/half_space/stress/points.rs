// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stress at any points, by a sum over the loaded cells.

use mtb_operator::{Monitor, report};
use rayon::prelude::*;

use super::super::Medium;
use super::inside::{Inside, check};
use super::rectangle::Stress;
use crate::Error;

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
/// [`Error::Material`], [`Error::NotFinite`], [`Error::AboveSurface`], [`Error::CellSides`], [`Error::InRigidBase`],
/// [`Error::CarriedAway`] for tractions along a layer that slides on its base, [`Error::OnBorder`] for a point on the surface at the border of a loaded cell, where the stress may be infinite, and [`Error::Interrupted`].
pub fn stress_at(
    medium: impl Into<Medium>,
    cells: &[LoadedCell],
    points: &[[f64; 3]],
    monitor: Monitor<'_>,
) -> Result<Vec<Stress>, Error> {
    let medium = medium.into();
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
    let is_sheared = loaded
        .iter()
        .any(|cell| cell.traction[..2].iter().any(|t| *t != 0.0));
    let depths: Vec<f64> = points.iter().map(|point| point[2]).collect();
    check(&medium, is_sheared, &depths)?;
    let at = |point: &[f64; 3], inside: &Inside<'_>| {
        let mut sum = [0.0; 6];
        for cell in &loaded {
            let offset = [point[0] - cell.centre[0], point[1] - cell.centre[1]];
            let found = inside.influence(offset, cell.sides);
            for (response, traction) in found.iter().zip(cell.traction) {
                for (sum, value) in sum.iter_mut().zip(response) {
                    *sum += traction * value;
                }
            }
        }
        sum
    };
    // points of one depth follow one another, as their tables are the same
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|a, b| depths[*a].total_cmp(&depths[*b]));
    let round = (UNWATCHED / loaded.len().max(1)).max(1);
    let mut stress = vec![[0.0; 6]; points.len()];
    for (number, part) in order.chunks(round).enumerate() {
        report(monitor, number, f64::NAN).map_err(|_| Error::Interrupted)?;
        let levels: Vec<&[usize]> = part.chunk_by(|a, b| depths[*a] == depths[*b]).collect();
        let found: Vec<Vec<Stress>> = levels
            .par_iter()
            .map(|same| {
                let inside = Inside::new(&medium, depths[same[0]]);
                same.par_iter().map(|k| at(&points[*k], &inside)).collect()
            })
            .collect();
        for (k, found) in part.iter().zip(found.iter().flatten()) {
            stress[*k] = *found;
        }
    }
    Ok(stress)
}

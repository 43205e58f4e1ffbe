// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rows of cells on a surface that turns across them: the first correction of the half-space for conformal contact.
//!
//! What acts on a cell is seen from another one turned by the difference of their inclinations, and moves it there
//! as on a half-space at the distance along the surface. [BlancoLorenzo2016, as the first variant of CONTACT]

/// Inclination [rad] of the surface of the lower body across the rows, at the place y [m], positive where it rises.
pub type Inclination<'a> = &'a (dyn Fn(f64) -> f64 + Sync);

/// Cosine and sine of the inclination of each row of cells.
#[derive(Clone, Debug)]
pub(crate) struct Turn {
    cos: Vec<f64>,
    sin: Vec<f64>,
}

impl Turn {
    /// Of `rows` at the distance `dy` [m], from the one at `first` [m].
    pub(crate) fn new(inclination: Inclination<'_>, first: f64, dy: f64, rows: usize) -> Self {
        let angles = (0..rows).map(|j| inclination(first + j as f64 * dy));
        let (sin, cos) = angles.map(f64::sin_cos).unzip();
        Self { cos, sin }
    }

    /// The rows in the other order.
    pub(crate) fn reversed(&self) -> Self {
        let turned = |values: &[f64]| values.iter().rev().copied().collect();
        Self {
            cos: turned(&self.cos),
            sin: turned(&self.sin),
        }
    }

    /// Cosine of the difference of the inclinations of two rows.
    pub(crate) fn cosine(&self, row: usize, other: usize) -> f64 {
        self.cos[row] * self.cos[other] + self.sin[row] * self.sin[other]
    }

    /// A field, each row times its cosine.
    pub(crate) fn by_cosine(&self, field: &[f64]) -> Vec<f64> {
        by_rows(&self.cos, field)
    }

    /// A field, each row times its sine.
    pub(crate) fn by_sine(&self, field: &[f64]) -> Vec<f64> {
        by_rows(&self.sin, field)
    }
}

fn by_rows(factors: &[f64], field: &[f64]) -> Vec<f64> {
    let width = field.len() / factors.len().max(1);
    let rows = field.chunks_exact(width.max(1)).zip(factors);
    rows.flat_map(|(row, factor)| row.iter().map(move |value| factor * value))
        .collect()
}

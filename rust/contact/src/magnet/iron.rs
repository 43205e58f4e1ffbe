// SPDX-License-Identifier: MIT OR Apache-2.0
//! How iron carries flux.

use crate::error::{Error, check};

/// Permeability of vacuum [H/m], and of iron for what exceeds its saturation.
pub const PERMEABILITY: f64 = 4e-7 * std::f64::consts::PI;

/// A curve of magnetisation: flux density over field, straight between its points, and with the slope
/// [`PERMEABILITY`] beyond the last one.
#[derive(Clone, Debug, PartialEq)]
pub struct Iron {
    field: Vec<f64>,
    flux_density: Vec<f64>,
}

impl Iron {
    /// A curve by its points, field [A/m] and flux density [T]; the origin is its first one.
    ///
    /// # Errors
    /// Unlike lengths, no point but the origin, numbers that are not finite, a field that does not rise, a flux density
    /// that rises less than in vacuum.
    pub fn new(field: &[f64], flux_density: &[f64]) -> Result<Self, Error> {
        check("flux_density", flux_density, field.len())?;
        check("field", field, field.len())?;
        let skipped = usize::from(field.first() == Some(&0.0) && flux_density[0] == 0.0);
        let with_origin = |values: &[f64]| [&[0.0], &values[skipped..]].concat();
        let iron = Self {
            field: with_origin(field),
            flux_density: with_origin(flux_density),
        };
        if iron.field.len() < 2 {
            return Err(Error::Shape {
                name: "field",
                expected: 2,
                found: field.len(),
            });
        }
        for k in 1..iron.field.len() {
            let rise = iron.field[k] - iron.field[k - 1];
            // tables of saturated iron are rounded
            let magnetised = iron.flux_density[k]
                - iron.flux_density[k - 1]
                - (1.0 - 1e-3) * PERMEABILITY * rise;
            for (name, value) in [
                ("step of field", rise),
                ("step of flux_density beyond that in vacuum", magnetised),
            ] {
                if value <= 0.0 {
                    return Err(Error::NotPositive {
                        name,
                        index: k - 1 + skipped,
                        value,
                    });
                }
            }
        }
        Ok(iron)
    }

    /// Field [A/m] and flux density [T] of its points, the origin first.
    pub fn points(&self) -> [&[f64]; 2] {
        [&self.field, &self.flux_density]
    }

    /// The field [A/m] at a flux density [T] of either sign.
    pub fn field(&self, flux_density: f64) -> f64 {
        let (size, from) = (flux_density.abs(), self.below(flux_density));
        (self.field[from] + (size - self.flux_density[from]) / self.permeability(from))
            .copysign(flux_density)
    }

    /// The slope [m/H] of the field at a flux density [T] of either sign.
    pub(super) fn field_slope(&self, flux_density: f64) -> f64 {
        1.0 / self.permeability(self.below(flux_density))
    }

    /// The point of the curve from which it is straight at a flux density [T] of either sign.
    fn below(&self, flux_density: f64) -> usize {
        let size = flux_density.abs();
        let k = self.flux_density.partition_point(|b| *b < size);
        k.clamp(1, self.field.len()) - 1
    }

    /// Polarisation [T] at which it is saturated: `B - mu0 H` of its last point.
    pub fn saturation(&self) -> f64 {
        let last = self.field.len() - 1;
        self.flux_density[last] - PERMEABILITY * self.field[last]
    }

    /// Flux density [T] that a magnetomotive force [A] >= 0 drives through a length [m] of iron and a gap [m] > 0 in
    /// series, and its derivative [T/A] by the force; that by the gap is `-B / mu0` times as large.
    pub(super) fn in_series(&self, force: f64, length: f64, gap: f64) -> (f64, f64) {
        let needed = |k: usize| self.field[k] * length + self.flux_density[k] * gap / PERMEABILITY;
        let (mut low, mut high) = (0, self.field.len());
        while high - low > 1 {
            let middle = usize::midpoint(low, high);
            if needed(middle) <= force {
                low = middle;
            } else {
                high = middle;
            }
        }
        let stiffness = length / self.permeability(low) + gap / PERMEABILITY;
        let density = self.flux_density[low] + (force - needed(low)) / stiffness;
        (density, 1.0 / stiffness)
    }

    /// Slope [H/m] of the curve from a point on.
    fn permeability(&self, from: usize) -> f64 {
        if from + 1 == self.field.len() {
            return PERMEABILITY;
        }
        (self.flux_density[from + 1] - self.flux_density[from])
            / (self.field[from + 1] - self.field[from])
    }
}

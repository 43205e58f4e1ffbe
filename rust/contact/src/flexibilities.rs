// SPDX-License-Identifier: MIT OR Apache-2.0
//! Flexibilities of the elastic foundation of the simplified theory: three, one, or blended, and softened.

use std::f64::consts::PI;

use crate::Error;
use crate::error::{check_number, check_positive};
use crate::kalker::CreepCoefficients;

/// Displacement per traction [m/Pa] of the foundation, one for each creepage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flexibilities {
    /// For longitudinal creepage.
    pub longitudinal: f64,
    /// For lateral creepage.
    pub lateral: f64,
    /// For spin.
    pub spin: f64,
}

impl Flexibilities {
    /// Those with which an ellipse of semi-axes `a` (rolling direction) and `b` [m] has Kalker's linear
    /// forces; `shear_modulus` [Pa] that of both bodies.
    pub fn of_ellipse(a: f64, b: f64, shear_modulus: f64, c: &CreepCoefficients) -> Self {
        Self {
            longitudinal: 8.0 * a / (3.0 * shear_modulus * c.c11),
            lateral: 8.0 * a / (3.0 * shear_modulus * c.c22),
            spin: PI * a * (a / b).sqrt() / (4.0 * shear_modulus * c.c23),
        }
    }

    fn all(one: f64) -> Self {
        Self {
            longitudinal: one,
            lateral: one,
            spin: one,
        }
    }

    /// One flexibility for all: the mean weighted by the squares of the creepages, spin times `radius`.
    ///
    /// The weights printed by Kalker (magnitudes over the root of the sum of squares) do not add up to one:
    /// they make an isotropic foundation 1.41 times as flexible under equal creepages.
    #[must_use]
    pub fn merged(&self, creepage: [f64; 3], radius: f64) -> Self {
        let weights = [creepage[0], creepage[1], creepage[2] * radius].map(|c| c * c);
        let total: f64 = weights.iter().sum();
        if total == 0.0 {
            return *self;
        }
        Self::all(
            (weights[0] * self.longitudinal + weights[1] * self.lateral + weights[2] * self.spin)
                / total,
        )
    }

    /// Three at small creepages and one at large ones, and that one.
    ///
    /// The one is the reciprocal of the mean stiffness, weighted by the squares of the displacements over the
    /// length that give the linear forces: the creepages, and `3 pi a / 32` times the spin. The share of it grows
    /// in proportion to the creepage up to one at the creepage `whole`.
    #[must_use]
    pub fn blended(&self, creepage: [f64; 3], a: f64, whole: f64) -> (Self, f64) {
        let [xi, eta, phi] = creepage;
        let squares = [xi, eta, 3.0 * PI / 32.0 * a * phi].map(|c| c * c);
        let three = [self.longitudinal, self.lateral, self.spin];
        let total: f64 = squares.iter().sum();
        if total == 0.0 {
            return (*self, self.longitudinal);
        }
        let one = total / squares.iter().zip(three).map(|(c, l)| c / l).sum::<f64>();
        let size = xi.hypot(eta);
        let share = if size < whole { size / whole } else { 1.0 };
        let [longitudinal, lateral, spin] = three.map(|l| (1.0 - share) * l + share * one);
        let blend = Self {
            longitudinal,
            lateral,
            spin,
        };
        (blend, one)
    }

    /// The creepage at which [`Self::blended`] has become one on an ellipse of the semi-axes `a` and `b` [m],
    /// under the friction force `limit` [N] of full sliding.
    ///
    /// It is the root of the sum of squares of the creepages, along and across, at which the linear forces are three
    /// times that limit: there the cubic law of creep forces slides.
    pub fn whole(&self, a: f64, b: f64, limit: f64) -> f64 {
        9.0 / 8.0 * limit / (a * a * b) * self.longitudinal.hypot(self.lateral)
    }

    /// Softer by the slope `k` of the creep curve over that of clean surfaces.
    #[must_use]
    pub fn softened(&self, k: f64) -> Self {
        Self {
            longitudinal: self.longitudinal / k,
            lateral: self.lateral / k,
            spin: self.spin / k,
        }
    }
}

/// Reduction of the slope of the creep curve, `k = k0 (alpha + (1 - alpha) / (1 + beta e))`, with a gradient `e` that
/// grows with the creepages: for wet and contaminated surfaces. [SpiryaginPolachCole2013]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopeReduction {
    /// The slope at small creepages over that of clean surfaces.
    pub initial: f64,
    /// Share of it that stays at large creepages.
    pub remaining: f64,
    /// How fast the other part falls.
    pub rate: f64,
}

impl SlopeReduction {
    /// Checks the three numbers.
    ///
    /// # Errors
    /// [`Error::Number`] or [`Error::NotFinite`] that names the number.
    pub fn checked(self) -> Result<Self, Error> {
        check_positive("slope_reduction[0]", self.initial)?;
        let within = self.remaining > 0.0 && self.remaining <= 1.0;
        check_number(
            "slope_reduction[1]",
            self.remaining,
            within,
            "a number above 0 and up to 1 is needed",
        )?;
        check_number(
            "slope_reduction[2]",
            self.rate,
            self.rate >= 0.0 && self.rate.is_finite(),
            "a number of at least 0 is needed",
        )?;
        Ok(self)
    }

    /// The slope at the gradient `e`.
    pub fn slope(&self, e: f64) -> f64 {
        self.initial * (self.remaining + (1.0 - self.remaining) / (1.0 + self.rate * e))
    }
}

/// The gradient of [`SlopeReduction`]: Polach's gradient of the traction under the bound of peak `peak` [Pa] at a
/// coefficient of friction of 1. `a` [m] is the semi-axis along the rolling direction; the lateral creepage is taken
/// where the spin makes it largest of its centre and its edge. [Polach1999]
pub fn gradient(creepage: [f64; 3], a: f64, shear_modulus: f64, c11: f64, peak: f64) -> f64 {
    let [xi, eta, phi] = creepage;
    let with_spin = eta + phi * a;
    let lateral = if with_spin.abs() > eta.abs() {
        with_spin
    } else {
        eta
    };
    0.5 * shear_modulus * c11 * xi.hypot(lateral) / peak
}

#[cfg(test)]
mod tests {
    use super::*;

    const THREE: Flexibilities = Flexibilities {
        longitudinal: 5e-14,
        lateral: 5.3e-14,
        spin: 4.1e-14,
    };

    #[test]
    fn a_blend_lies_between_the_three_and_the_one() {
        for creepage in [[1e-3, 0.0, 0.3], [0.0, -2e-3, 1.0], [1e-3, 5e-4, -0.2]] {
            let (none, one) = THREE.blended(creepage, 8e-3, f64::INFINITY);
            assert_eq!(none, THREE);
            assert!(one > 4.1e-14 && one < 5.3e-14);
            assert_eq!(
                THREE.blended(creepage, 8e-3, 0.0).0,
                Flexibilities::all(one)
            );
        }
        // one creepage alone has its own flexibility, whatever the share
        for whole in [1e-9, 1e-3] {
            let alone = THREE.blended([1e-3, 0.0, 0.0], 8e-3, whole).0.longitudinal;
            assert!((alone / 5e-14 - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_blend_is_whole_where_linear_forces_are_three_times_the_limit() {
        let c = CreepCoefficients {
            c11: 5.2,
            c22: 4.9,
            c23: 2.6,
            c33: 0.8,
        };
        let (a, b, modulus, limit) = (8e-3, 4e-3, 82e9, 24.6e3);
        let whole = Flexibilities::of_ellipse(a, b, modulus, &c).whole(a, b, limit);
        let each = [c.c11, c.c22].map(|c| 3.0 * limit / (modulus * a * b * c));
        assert!((whole / each[0].hypot(each[1]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_slope_falls_from_its_initial_value_to_what_remains() {
        let reduction = SlopeReduction {
            initial: 0.3,
            remaining: 0.5,
            rate: 0.2,
        };
        assert_eq!(reduction.slope(0.0), 0.3);
        assert!((reduction.slope(1e12) - 0.15).abs() < 1e-9);
        assert!(
            SlopeReduction {
                remaining: 1.2,
                ..reduction
            }
            .checked()
            .is_err()
        );
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use crate::Error;

/// Isotropic linear elastic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Shear modulus `G` [Pa].
    pub shear_modulus: f64,
    /// Poisson's ratio `nu` [-].
    pub poisson_ratio: f64,
}

impl Material {
    /// Material with shear modulus [Pa] and Poisson's ratio [-].
    ///
    /// # Errors
    /// [`Error::Material`] unless the modulus is positive and finite and the ratio in (-1, 0.5].
    pub fn new(shear_modulus: f64, poisson_ratio: f64) -> Result<Self, Error> {
        let is_stable = shear_modulus > 0.0
            && shear_modulus.is_finite()
            && poisson_ratio > -1.0
            && poisson_ratio <= 0.5;
        if is_stable {
            Ok(Self {
                shear_modulus,
                poisson_ratio,
            })
        } else {
            Err(Error::Material {
                shear_modulus,
                poisson_ratio,
            })
        }
    }

    /// A material whose half-space gives way to a pressure as much as the half-spaces of all `bodies`
    /// together: that with Poisson's ratio zero.
    ///
    /// # Errors
    /// [`Error::NoBody`] where all bodies are rigid, that is, none is given.
    pub fn joined(bodies: &[Self]) -> Result<Self, Error> {
        let compliance: f64 = bodies
            .iter()
            .map(|body| (1.0 - body.poisson_ratio) / body.shear_modulus)
            .sum();
        if bodies.is_empty() {
            return Err(Error::NoBody);
        }
        Self::new(1.0 / compliance, 0.0)
    }

    /// Young's modulus `E = 2 G (1 + nu)` [Pa].
    pub fn young_modulus(&self) -> f64 {
        2.0 * self.shear_modulus * (1.0 + self.poisson_ratio)
    }
}

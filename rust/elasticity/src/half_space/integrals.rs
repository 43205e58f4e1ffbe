// SPDX-License-Identifier: MIT OR Apache-2.0
//! Half-space compliance on scattered points, from five surface integrals that know no material.

use std::sync::Arc;

use mtb_operator::{Compliance, Component};
use rayon::prelude::*;

use crate::{Error, Material};

/// The five surface integrals behind all nine influence coefficients, for every pair of an observed
/// point and a loaded basis function: dense, row-major, row = observed point. Unit: m.
///
/// With `X, Y` = observed minus loaded point and `r` their distance; `Y^2/r^3` follows from the first
/// two. The material enters only as factors, so both bodies of a contact share one set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceIntegrals {
    /// Number of points, and of basis functions.
    pub points: usize,
    /// Integrals of `1/r`.
    pub inverse: Vec<f64>,
    /// Integrals of `X^2/r^3`.
    pub xx: Vec<f64>,
    /// Integrals of `XY/r^3`.
    pub xy: Vec<f64>,
    /// Integrals of `X/r^2`.
    pub x: Vec<f64>,
    /// Integrals of `Y/r^2`.
    pub y: Vec<f64>,
}

/// An elastic half-space whose tractions are sums of the functions of a [`super::GaussianBasis`].
///
/// Boussinesq and Cerruti's point loads integrated over the basis functions [Johnson1985, 3.2, 3.6].
#[derive(Clone, Debug)]
pub struct GaussianHalfSpace {
    integrals: Arc<SurfaceIntegrals>,
    material: Material,
}

impl GaussianHalfSpace {
    /// Half-space of a material on the points of `integrals`.
    ///
    /// # Errors
    /// [`Error::Material`].
    pub fn new(material: Material, integrals: Arc<SurfaceIntegrals>) -> Result<Self, Error> {
        let material = Material::new(material.shear_modulus, material.poisson_ratio)?;
        Ok(Self {
            integrals,
            material,
        })
    }

    /// The integrals that make up one block, with their factors [1/Pa].
    fn terms(&self, observed: Component, loaded: Component) -> [(f64, &[f64]); 2] {
        use Component::{Normal, X, Y};
        let i = &*self.integrals;
        let Material {
            shear_modulus,
            poisson_ratio: nu,
        } = self.material;
        let unit = 1.0 / (2.0 * std::f64::consts::PI * shear_modulus);
        let mixed = 0.5 * (1.0 - 2.0 * nu) * unit;
        let none: (f64, &[f64]) = (0.0, &[]);
        match (observed, loaded) {
            (Normal, Normal) => [((1.0 - nu) * unit, &i.inverse), none],
            (Normal, X) => [(mixed, &i.x), none],
            (Normal, Y) => [(mixed, &i.y), none],
            (X, Normal) => [(-mixed, &i.x), none],
            (Y, Normal) => [(-mixed, &i.y), none],
            (X, X) => [((1.0 - nu) * unit, &i.inverse), (nu * unit, &i.xx)],
            // Y^2/r^3 = 1/r - X^2/r^3
            (Y, Y) => [(unit, &i.inverse), (-nu * unit, &i.xx)],
            (X, Y) | (Y, X) => [(nu * unit, &i.xy), none],
        }
    }
}

impl Compliance for GaussianHalfSpace {
    fn points(&self) -> usize {
        self.integrals.points
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        let n = self.points();
        for (factor, matrix) in self.terms(observed, loaded) {
            if factor == 0.0 {
                continue;
            }
            displacement
                .par_iter_mut()
                .zip(matrix.par_chunks(n))
                .for_each(|(u, row)| {
                    let sum: f64 = row.iter().zip(traction).map(|(a, p)| a * p).sum();
                    *u += scale * factor * sum;
                });
        }
    }

    fn add_influence(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        matrix: &mut [f64],
    ) {
        for (factor, block) in self.terms(observed, loaded) {
            if factor == 0.0 {
                continue;
            }
            for (m, b) in matrix.iter_mut().zip(block) {
                *m += scale * factor * b;
            }
        }
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! How a pull moves the faces that it acts on, as a matrix.

use faer::linalg::matmul::matmul;
use faer::{Accum, ColMut, ColRef, Mat, MatRef, Par};
use mtb_operator::{Compliance, Component, Monitor, check_factors, report};

use crate::error::{Error, check};

/// Displacement of two bodies relative to each other by a load along the normal at the points, component by component.
///
/// It is the same matrix in every place that steps the contact, so that all of them find the same numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    observed: Vec<Component>,
    /// (n times as many as are observed, n) [m/Pa]
    matrix: Mat<f64>,
}

impl Face {
    /// The displacement along the normal.
    pub const NORMAL: [Component; 1] = [Component::Normal];
    /// That along both tangents.
    pub const ALONG: [Component; 2] = [Component::X, Component::Y];

    /// These components of the displacement of `bodies`.
    ///
    /// # Errors
    /// More points than the memory holds, an interruption.
    pub fn new(
        bodies: &dyn Compliance,
        observed: &[Component],
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let n = bodies.points();
        let entries = (n as f64).powi(2) * (observed.len() + 1) as f64;
        check_factors(n, 8.0 * entries + bodies.influence_memory())?;
        let mut matrix = Mat::zeros(observed.len() * n, n);
        let mut block = vec![0.0; n * n];
        for (k, &component) in observed.iter().enumerate() {
            block.fill(0.0);
            bodies.add_influence(component, Component::Normal, 1.0, &mut block);
            for (row, values) in block.chunks_exact(n.max(1)).enumerate() {
                for (column, value) in values.iter().enumerate() {
                    matrix[(k * n + row, column)] = *value;
                }
            }
            report(monitor, k, f64::NAN)?;
        }
        Ok(Self {
            observed: observed.to_vec(),
            matrix,
        })
    }

    /// What [`Face::columns`] gave.
    ///
    /// # Errors
    /// A wrong length, numbers that are not finite.
    pub fn from_columns(
        points: usize,
        observed: &[Component],
        columns: &[f64],
    ) -> Result<Self, Error> {
        let rows = observed.len() * points;
        check("displacement by a pull", columns, rows * points)?;
        Ok(Self {
            observed: observed.to_vec(),
            matrix: MatRef::from_column_major_slice(columns, rows, points).to_owned(),
        })
    }

    /// All entries, column by column [m/Pa].
    pub fn columns(&self) -> Vec<f64> {
        (0..self.matrix.ncols())
            .flat_map(|j| self.matrix.col_as_slice(j).iter().copied())
            .collect()
    }

    /// Adds `scale` times the displacement [m] by a load (n) [Pa], one component after the other.
    pub(crate) fn add(&self, scale: f64, load: &[f64], moved: &mut [f64]) {
        add_product(self.matrix.as_ref(), scale, load, moved);
    }

    /// Adds `scale` times the weights of loads (n) that do what weights of displacements do.
    pub(crate) fn add_weights(&self, scale: f64, moved: &[f64], load: &mut [f64]) {
        add_product(self.matrix.transpose(), scale, moved, load);
    }

    /// The rows of one component, if there are such.
    fn rows(&self, observed: Component, loaded: Component) -> Option<MatRef<'_, f64>> {
        let n = self.matrix.ncols();
        let at = (self.observed.iter()).position(|own| *own == observed)?;
        let rows = self.matrix.as_ref().subrows(at * n, n);
        (loaded == Component::Normal).then_some(rows)
    }
}

/// On one thread: the same sums everywhere.
fn add_product(matrix: MatRef<'_, f64>, scale: f64, vector: &[f64], to: &mut [f64]) {
    matmul(
        ColMut::from_slice_mut(to),
        Accum::Add,
        matrix,
        ColRef::from_slice(vector),
        scale,
        Par::Seq,
    );
}

impl Compliance for Face {
    fn points(&self) -> usize {
        self.matrix.ncols()
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        if let Some(rows) = self.rows(observed, loaded) {
            add_product(rows, scale, traction, displacement);
        }
    }

    fn add_transposed(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        weights: &[f64],
        sums: &mut [f64],
    ) {
        if let Some(rows) = self.rows(observed, loaded) {
            add_product(rows.transpose(), scale, weights, sums);
        }
    }
}

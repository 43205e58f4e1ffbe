// SPDX-License-Identifier: MIT OR Apache-2.0
//! Columns of numbers, one after the other: random ones, their products, and eigenvalues of small matrices.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par, Side};
use mtb_operator::reset_workers;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::assembly::Lower;
use crate::Error;

/// Signs that are the same in each run [SteeleLeaFlood2014].
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn sign(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        if (z ^ (z >> 31)) >> 63 == 0 {
            1.0
        } else {
            -1.0
        }
    }
}

pub(super) fn par() -> Par {
    Par::rayon(rayon::current_num_threads())
}

pub(super) fn columns_of(values: &[f64], rows: usize) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(values, rows, values.len() / rows)
}

/// `first^T second`.
pub(super) fn inner(first: MatRef<'_, f64>, second: MatRef<'_, f64>) -> Mat<f64> {
    let mut found = Mat::zeros(first.ncols(), second.ncols());
    matmul(
        found.as_mut(),
        Accum::Replace,
        first.transpose(),
        second,
        1.0,
        par(),
    );
    found
}

/// The product of a sparse matrix with each column.
pub(super) fn times(matrix: &Lower, values: &[f64], rows: usize) -> Vec<f64> {
    let parts: Vec<Vec<f64>> = values
        .par_chunks(rows)
        .map(|column| matrix.times(column))
        .collect();
    parts.concat()
}

/// Vectors and values, which rise, by division: vectors to 1e-6, values to 1e-8 of the largest.
pub(super) fn symmetric_eigen(matrix: &Mat<f64>) -> Result<(Mat<f64>, Vec<f64>), Error> {
    let n = matrix.nrows();
    let found = matrix
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| Error::OutOfMemory { unknowns: n })?;
    reset_workers();
    Ok((found.U().to_owned(), (0..n).map(|k| found.S()[k]).collect()))
}

/// The same to rounding of the largest value, by rotations; for some hundred rows.
pub(super) fn exact_eigen(matrix: &Mat<f64>) -> (Mat<f64>, Vec<f64>) {
    let n = matrix.nrows();
    let found = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)]).symmetric_eigen();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| found.eigenvalues[a].total_cmp(&found.eigenvalues[b]));
    let vectors = Mat::from_fn(n, n, |i, k| found.eigenvectors[(i, order[k])]);
    (
        vectors,
        order.iter().map(|&k| found.eigenvalues[k]).collect(),
    )
}

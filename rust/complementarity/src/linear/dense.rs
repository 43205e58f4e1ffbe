// SPDX-License-Identifier: MIT OR Apache-2.0
//! Factorised dense blocks.

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use faer::{Mat, MatRef, Par};
use mtb_operator::dense::{Cholesky, Lu, Watch, threads};
use mtb_operator::{Error, Interrupted, Monitor, reset_workers};

/// A factorised square matrix that solves and knows the sign of its determinant.
pub(super) enum Factor {
    Symmetric(Cholesky),
    General(Lu),
}

impl Factor {
    /// Factorises the rows and columns `set` of the row-major n x n `matrix`; by Cholesky where it is
    /// symmetric and positive definite, by Gauss otherwise.
    pub(super) fn of(
        matrix: &[f64],
        n: usize,
        set: &[usize],
        symmetric: bool,
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let par = threads(set.len());
        if symmetric {
            // rows read as columns: they are the same, and lie in the order of the memory
            let block = columns(set.len(), monitor, |j, column| {
                let row = &matrix[set[j] * n..(set[j] + 1) * n];
                for (a, &i) in column.iter_mut().zip(set) {
                    *a = row[i];
                }
            })?;
            if let Some(cholesky) = Cholesky::new(block, par, monitor)? {
                return Ok(Self::Symmetric(cholesky));
            }
        }
        let block = columns(set.len(), monitor, |j, column| {
            for (a, &i) in column.iter_mut().zip(set) {
                *a = matrix[i * n + set[j]];
            }
        })?;
        Ok(Self::General(Lu::new(block, par, monitor)?))
    }

    pub(super) fn solve(
        &self,
        rhs: MatRef<'_, f64>,
        monitor: Monitor<'_>,
    ) -> Result<Mat<f64>, Error> {
        let par = threads(rhs.nrows());
        let solved = match self {
            Self::Symmetric(cholesky) => cholesky.solve(rhs, par, monitor),
            Self::General(lu) => lu.solve(rhs, par, monitor),
        };
        if par != Par::Seq {
            reset_workers();
        }
        solved
    }

    pub(super) fn determinant_sign(&self) -> f64 {
        match self {
            Self::Symmetric(_) => 1.0,
            Self::General(lu) => lu.sign(),
        }
    }
}

/// Rows of the largest matrix whose factor is kept: a factor and a matrix of 8 MB each.
const LARGEST: usize = 1000;

/// The factor of the pressures that were positive last, kept for the next problem with the same matrix.
///
/// Steps of the time under slowly changing loads often have both in common.
#[derive(Default)]
pub struct KeptFactor(Mutex<Option<LastFactor>>);

struct LastFactor {
    matrix: Vec<f64>,
    symmetric: bool,
    set: Vec<usize>,
    factor: Arc<Factor>,
}

impl fmt::Debug for KeptFactor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("KeptFactor").finish_non_exhaustive()
    }
}

impl KeptFactor {
    /// As [`Factor::of`], or that of the last call where this had the same rows and columns of the same matrix.
    pub(super) fn of(
        &self,
        matrix: &[f64],
        n: usize,
        set: &[usize],
        symmetric: bool,
        monitor: Monitor<'_>,
    ) -> Result<Arc<Factor>, Error> {
        let mut last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(last) = &*last
            && last.set == set
            && last.symmetric == symmetric
            && last.matrix == matrix
        {
            return Ok(last.factor.clone());
        }
        *last = None;
        let factor = Arc::new(Factor::of(matrix, n, set, symmetric, monitor)?);
        if n <= LARGEST {
            *last = Some(LastFactor {
                matrix: matrix.to_vec(),
                symmetric,
                set: set.to_vec(),
                factor: factor.clone(),
            });
        }
        Ok(factor)
    }
}

/// Operations that filling an entry counts for: it waits for the memory.
const ENTRY: f64 = 20.0;

/// A square matrix filled column by column.
pub(super) fn columns(
    n: usize,
    monitor: Monitor<'_>,
    mut fill: impl FnMut(usize, &mut [f64]),
) -> Result<Mat<f64>, Interrupted> {
    let mut watch = Watch::new(monitor);
    let mut matrix = Mat::zeros(n, n);
    for j in 0..n {
        fill(j, matrix.col_as_slice_mut(j));
        watch.spend(ENTRY * n as f64)?;
    }
    Ok(matrix)
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use faer::{Mat, Par};
use mtb_operator::{Error, Monitor, dense};

use crate::columns::{self, largest};

/// Gauss' factors of a dense matrix, on one thread: small systems solved often, in even time.
pub(super) struct Lu(pub(super) dense::Lu);

impl Lu {
    pub(super) fn of(matrix: Mat<f64>, monitor: Monitor<'_>) -> Result<Self, Error> {
        Ok(Self(dense::Lu::new(matrix, Par::Seq, monitor)?))
    }

    /// Sign of the determinant.
    pub(super) fn sign(&self) -> f64 {
        self.0.sign()
    }

    /// The solutions for many right-hand sides at once.
    pub(super) fn solve_many(&self, rhs: &Mat<f64>) -> Mat<f64> {
        self.0.solve_few(rhs.as_ref(), Par::Seq)
    }

    /// The same with the transposed matrix.
    pub(super) fn solve_many_transposed(&self, rhs: &Mat<f64>) -> Mat<f64> {
        self.0.solve_few_transposed(rhs.as_ref(), Par::Seq)
    }

    /// Overwrites `x` with the solution; `work` has the same length.
    pub(super) fn solve(&self, x: &mut [f64], work: &mut Vec<f64>) {
        columns::solve(&self.0, x, work);
    }
}

/// A small system whose rows and columns have unlike units, scaled before it is factorised.
pub(super) struct Small {
    lu: Lu,
    rows: Vec<f64>,
    columns: Vec<f64>,
}

impl Small {
    pub(super) fn of(mut matrix: Mat<f64>, monitor: Monitor<'_>) -> Result<Self, Error> {
        let size = |v: f64| if v > 0.0 { v } else { 1.0 };
        let mut columns = Vec::with_capacity(matrix.ncols());
        let mut rows = vec![0.0_f64; matrix.nrows()];
        for j in 0..matrix.ncols() {
            let column = matrix.col_as_slice_mut(j);
            let most = size(largest(column));
            for (value, row) in column.iter_mut().zip(&mut rows) {
                *value /= most;
                *row = row.max(value.abs());
            }
            columns.push(most);
        }
        for row in &mut rows {
            *row = size(*row);
        }
        scale_rows(&mut matrix, &rows);
        Ok(Self {
            lu: Lu::of(matrix, monitor)?,
            rows,
            columns,
        })
    }

    pub(super) fn sign(&self) -> f64 {
        self.lu.sign()
    }

    pub(super) fn solve(&self, x: &mut [f64], work: &mut Vec<f64>) {
        for (x, r) in x.iter_mut().zip(&self.rows) {
            *x /= r;
        }
        self.lu.solve(x, work);
        for (x, c) in x.iter_mut().zip(&self.columns) {
            *x /= c;
        }
    }

    /// The solutions for many right-hand sides at once, with the matrix or, if `transposed`, with its transpose.
    pub(super) fn solve_many(&self, mut rhs: Mat<f64>, transposed: bool) -> Mat<f64> {
        let (before, after) = if transposed {
            (&self.columns, &self.rows)
        } else {
            (&self.rows, &self.columns)
        };
        scale_rows(&mut rhs, before);
        let mut x = if transposed {
            self.lu.solve_many_transposed(&rhs)
        } else {
            self.lu.solve_many(&rhs)
        };
        scale_rows(&mut x, after);
        x
    }
}

fn scale_rows(x: &mut Mat<f64>, by: &[f64]) {
    for j in 0..x.ncols() {
        let pairs = x.col_as_slice_mut(j).iter_mut().zip(by);
        pairs.for_each(|(x, by)| *x /= by);
    }
}

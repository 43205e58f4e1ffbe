// SPDX-License-Identifier: MIT OR Apache-2.0
use faer::{Mat, MatRef, Par};
use mtb_operator::dense::Lu;
use mtb_operator::{LinearOperator, Monitor, reset_workers};

use super::newton::solve_discs;
use super::problem::{DiscOptions, DiscProblem, DiscSolution, DiscStart, Radius, Resultant};
use crate::error::{Error, check};

/// A dense variational inequality on discs: see [`DiscProblem`].
pub struct DenseDiscProblem<'a> {
    /// `A`, row-major (2n, 2n), first components first.
    pub matrix: &'a [f64],
    /// `b`, (2n).
    pub offset: &'a [f64],
    /// `g`, (n).
    pub radius: &'a [f64],
    /// Conditions on `q` with their multipliers; may be empty.
    pub resultants: &'a [Resultant],
}

/// Solves a dense problem with the inverse of the whole matrix as preconditioner.
///
/// Points of radius zero take no part and need no sensible rows. Without a `start`, from the linear problem.
///
/// # Errors
/// As [`solve_discs`].
pub fn solve_discs_dense(
    problem: &DenseDiscProblem<'_>,
    start: Option<&DiscStart>,
    options: DiscOptions,
    monitor: Monitor<'_>,
) -> Result<DiscSolution, Error> {
    let n = problem.radius.len();
    check("matrix", problem.matrix, 4 * n * n)?;
    let matrix = MatRef::from_row_major_slice(problem.matrix, 2 * n, 2 * n);
    let diagonal = (0..2 * n).map(|i| matrix[(i, i)].abs()).sum::<f64>() / (2 * n).max(1) as f64;
    let free: Vec<usize> = (0..2 * n).filter(|i| problem.radius[i % n] > 0.0).collect();
    let block = Mat::from_fn(free.len(), free.len(), |i, j| matrix[(free[i], free[j])]);
    let inverse = Inverse {
        dim: 2 * n,
        free,
        lu: Lu::new(block, faer::get_global_parallelism(), monitor)?,
    };
    reset_workers();
    solve_discs(
        &DiscProblem {
            operator: &Dense(matrix),
            rough: &Dense(matrix),
            preconditioner: &inverse,
            offset: problem.offset,
            radius: Radius::Fixed(problem.radius),
            resultants: problem.resultants,
            diagonal,
        },
        start.unwrap_or(&DiscStart::Inside),
        options,
        monitor,
    )
}

struct Dense<'a>(MatRef<'a, f64>);

impl LinearOperator for Dense<'_> {
    fn dim(&self) -> usize {
        self.0.nrows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        faer::linalg::matmul::matmul(
            faer::MatMut::from_column_major_slice_mut(y, self.0.nrows(), 1),
            faer::Accum::Replace,
            self.0,
            MatRef::from_column_major_slice(x, self.0.ncols(), 1),
            1.0,
            Par::Seq,
        );
    }
}

/// The inverse of the block of the points that take part.
struct Inverse {
    dim: usize,
    free: Vec<usize>,
    lu: Lu,
}

impl LinearOperator for Inverse {
    fn dim(&self) -> usize {
        self.dim
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let rhs = Mat::from_fn(self.free.len(), 1, |i, _| x[self.free[i]]);
        let solution = self
            .lu
            .solve_few(rhs.as_ref(), faer::get_global_parallelism());
        y.fill(0.0);
        for (i, k) in self.free.iter().enumerate() {
            y[*k] = solution[(i, 0)];
        }
    }
}

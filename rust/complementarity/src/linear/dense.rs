//! Factorised dense blocks.

use faer::linalg::solvers::{Llt, PartialPivLu, Solve};
use faer::{Mat, MatRef, Side};

/// A factorised square matrix that solves and knows the sign of its determinant.
pub(super) enum Factor {
    Symmetric(Llt<f64>),
    General(PartialPivLu<f64>),
}

impl Factor {
    /// Factorises the rows and columns `set` of the row-major n x n `matrix`; by Cholesky where it is
    /// symmetric and positive definite, by Gauss otherwise.
    pub(super) fn of(matrix: &[f64], n: usize, set: &[usize], symmetric: bool) -> Self {
        let block = Mat::from_fn(set.len(), set.len(), |i, j| matrix[set[i] * n + set[j]]);
        if symmetric && let Ok(llt) = block.llt(Side::Lower) {
            return Self::Symmetric(llt);
        }
        Self::General(block.partial_piv_lu())
    }

    pub(super) fn solve(&self, rhs: MatRef<'_, f64>) -> Mat<f64> {
        match self {
            Self::Symmetric(llt) => llt.solve(rhs),
            Self::General(lu) => lu.solve(rhs),
        }
    }

    pub(super) fn determinant_sign(&self) -> f64 {
        match self {
            Self::Symmetric(_) => 1.0,
            Self::General(lu) => lu_sign(lu),
        }
    }
}

/// Sign of the determinant from the diagonal of U and the parity of the row permutation.
pub(super) fn lu_sign(lu: &PartialPivLu<f64>) -> f64 {
    let u = lu.U();
    let mut sign = 1.0;
    for i in 0..u.nrows() {
        sign *= u[(i, i)].signum();
    }
    let (forward, _) = lu.P().arrays();
    let mut seen = vec![false; forward.len()];
    for start in 0..forward.len() {
        let mut length = 0;
        let mut i = start;
        while !seen[i] {
            seen[i] = true;
            i = forward[i];
            length += 1;
        }
        if length > 0 && length % 2 == 0 {
            sign = -sign;
        }
    }
    sign
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Variational inequalities on discs, `|q_i| <= g_i`.

mod dense;
mod linear;
mod newton;
mod problem;
mod tangent;
#[cfg(test)]
mod tests;

pub use dense::{DenseDiscProblem, solve_discs_dense};
pub use newton::solve_discs;
pub use problem::{
    DependentRadius, DiscOptions, DiscProblem, DiscSolution, DiscStart, DiscState, Preconditioner,
    Radius, Resultant,
};
pub use tangent::{DiscChange, DiscResponse, DiscTangent, transposed};

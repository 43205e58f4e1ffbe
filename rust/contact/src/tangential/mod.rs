// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stick and slip: shifts, transient and steady rolling.
//!
//! With `C` the influence of the tangential traction `q` on the lower body on the displacement of the
//! lower body relative to the upper one, `w` the rigid slip of the upper body over the lower one, and
//! `d` a step along the rolling direction, the slip `S` of the upper body over the lower one is
//!
//! * shift: `S = w - C q - u_old`, with the relative displacement `u_old` of the earlier state;
//! * transient rolling: `S = w |d| - C q - u_old(x + d)`, particles running against the rolling direction;
//! * steady rolling: `S / |d| = w - [C q(x) - C q(x + d)] / |d|`, first order in `d`; second order in the cells with
//!   [`PatchOperators::of_second_order`].
//!
//! Sought is `|q| <= mu p` with `S = 0` where less, and `q = mu p S / |S|` where it slips. A layer adds
//! `h / G` to the diagonal of `C`; one that yields bounds `|q|` by `tau_c0 + k_tau u` as well. [Kalker1990, ch. 4], [Vollebregt2012]

mod bound;
mod change;
mod checks;
mod dissipation;
mod dissipation_tangent;
mod faces;
mod given;
mod heated;
mod heated_tangent;
mod inverse;
mod kernels;
mod level;
mod levels;
mod operators;
mod plastic;
mod problem;
mod slip;
mod solve;
mod table;
mod tangent;

pub use change::{PlasticityChange, TangentialChange, TangentialResponse, TangentialState};
pub use dissipation::{Surroundings, dissipation};
pub use operators::{Bodies, Motion, PatchOperators, SPIN_ADVANCE};
pub use problem::{
    Drive, Earlier, PlasticSlip, Plasticity, Rounds, TangentialProblem, TangentialSolution,
};
pub use solve::solve;
pub use tangent::TangentialTangent;

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Dense linear complementarity problems with free rigid motions.

mod active_set;
mod dense;
mod existence;
mod gauss_seidel;
mod lemke;
mod limited;
mod problem;
mod products;
mod springs;

pub use active_set::{Options, from_touching, solve};
pub use dense::KeptFactor;
pub use existence::{definiteness_limit, reachable, reachable_within};
pub use gauss_seidel::gauss_seidel;
pub use lemke::lemke;
pub use limited::{ROUNDING, Sides, carries};
pub use problem::{Border, Problem, Solution, Status};
pub use products::{ByProducts, solve_by_products};

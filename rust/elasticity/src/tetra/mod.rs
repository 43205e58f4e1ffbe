// SPDX-License-Identifier: MIT OR Apache-2.0
//! Finite-element bodies of 4-node (linear) or 10-node (quadratic) tetrahedra.
//!
//! **What.** A [`TetraMesh`] with an elastic [`Material`](crate::Material) and [`Support`]s is a
//! [`TetraBody`]. Condensed onto the contact points of a [`Sampling`] of its surface it becomes a
//! [`CondensedBody`]: its [`Flexibility`] is a [`Compliance`](mtb_operator::Compliance), beside it
//! stand the rigid motions that only contact can hold.
//!
//! **How.** Traction lives on contact points `i` with basis functions `phi_i`, known at quadrature
//! points `q` of the surface: `(B_c)_ai = sum_q w_q N_a(x_q) phi_i(x_q) e_c(x_q)` for the three
//! directions `c` of the local frame. With `K = L L^T` the flexibility is `S_cd = Y_c^T Y_d`,
//! `Y_c = L^-1 B_c`: forward substitutions only, and only through the part of `L` a contact point
//! reaches. The displacement is observed as the `phi`-weighted mean, so the compliance is
//! `C_cd = W^-1 S_cd` with `W_i = sum_q w_q phi_i`, symmetric in the `W`-weighted product.
//!
//! A [`ConductingBody`] is the same mesh with heat in place of displacements: implicit steps over the time, each of
//! them condensed onto the same contact points. In its [`ConductionModes`] steps of any duration are diagonal.
//! [`TetraBody::expansion`] is the displacement of the contact points by the temperatures of the nodes.
//!
//! [`TetraBody::vibration`] finds the lowest natural vibrations of the body on its supports.
//!
//! **References.** [GeorgeLiu1981] for the ordering and the elimination tree; [Hughes2000] for the elements.

mod assembly;
mod balance;
mod body;
mod columns;
mod condense;
mod condensed;
mod conduction;
mod conduction_basis;
mod conduction_modes;
mod conduction_step;
mod element;
mod expansion;
mod factor;
mod factorised;
mod inside;
mod layers;
mod locate;
mod mesh;
mod mirror;
mod numeric;
mod ordering;
mod recovery;
mod relief;
mod rigid;
mod sampling;
mod stress;
mod support;
mod vibration;

/// Changes with the code of this module: results kept under it are those of this very code.
pub const DIGEST: &str = env!("MTB_TETRA_DIGEST");

pub use body::TetraBody;
pub use condensed::{Balance, CondensedBody, Flexibility, SupportCase};
pub use conduction::{ConductingBody, Film};
pub use conduction_modes::ConductionModes;
pub use conduction_step::{ConductionStep, Seen};
pub use factorised::{Cost, Limits};
pub use mesh::{Order, TetraMesh};
pub use recovery::Reaction;
pub use rigid::RigidMode;
pub use sampling::{Averages, ContactGrid, Sampling, SurfacePoint};
pub use support::{Hold, Support};
pub use vibration::Vibration;

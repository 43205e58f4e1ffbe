// SPDX-License-Identifier: MIT OR Apache-2.0
//! A magnet whose pull follows the gap.
//!
//! A coil drives one flux through a yoke, through the poles in series, each with its column of iron, a layer that is
//! not magnetic and the gap, and through the body on the other side. At a point with the gap `g` of a pole with the
//! magnetomotive force `Theta` the flux density `B` satisfies `Theta = H(B) l + B (g + g_nm) / mu0`, and the pole
//! pulls with `p = B^2 / (2 mu0)` on its iron, in which `B` counts up to the saturation polarisation of the iron: what
//! goes beyond it is flux of the air. [`Circuit`] finds the forces `Theta` of the poles for gaps at the points;
//! [`settle`] finds the state of a contact in which gaps and pull fit each other.
//!
//! **Not here.** Eddy currents, which enter by a factor of the speed; hysteresis and remanence; flux beside the poles
//! but for one permeance of leakage; forces on flanks.
//!
//! **References.** [Roters1941], [TEAM13].

mod circuit;
mod face;
mod iron;
mod linear;
mod pulling;
mod settle;
#[cfg(test)]
mod tests;

pub use circuit::{Attraction, Circuit, Limb, Poles};
pub use face::Face;
pub use iron::{Iron, PERMEABILITY};
pub use linear::{PARAMETERS, Slopes};
pub use pulling::Pulling;
pub use settle::{Magnet, Settled, Settling, settle, snap_share};

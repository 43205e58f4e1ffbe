// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stress inside a half-space whose surface bears uniform tractions on rectangles.
//!
//! With the potentials of Boussinesq and Cerruti, `V` the integral of `1 / rho` over the rectangle, `L` that of
//! `ln(rho + z)` and `M` that of `z ln(rho + z) - rho`, all of them harmonic, `V = dL/dz` and `L = dM/dz`, a unit
//! pressure gives `2 pi` times
//!
//! ```text
//! xx   2 nu V_z - (1 - 2 nu) L_xx - z V_xx        yz   -z V_yz
//! yy   2 nu V_z - (1 - 2 nu) L_yy - z V_yy        xz   -z V_xz
//! zz   V_z - z V_zz                               xy   -(1 - 2 nu) L_xy - z V_xy
//! ```
//!
//! and a unit traction along x
//!
//! ```text
//! xx   2 (1 + nu) V_x + 2 nu M_xxx - z L_xxx      yz   -z V_xy
//! yy   2 nu V_x + 2 nu M_xyy - z L_xyy            xz   V_z - z V_xx
//! zz   -z V_xz                                    xy   V_y + 2 nu M_xxy - z L_xxy
//! ```
//!
//! in the body's own frame, z into it, tension positive. Only Poisson's ratio matters of the material. A layered body
//! adds what its interface sends back.
//! [Love1929; Johnson1985, ch. 3; AhmadiKeerMura1983]

mod field;
mod inside;
mod points;
mod rectangle;
mod waves;

pub use field::StressBelow;
pub use points::{LoadedCell, stress_at};
pub use rectangle::{Stress, stress_influence};
pub(super) use waves::HalfSpaceWaves;

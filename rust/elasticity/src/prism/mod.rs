// SPDX-License-Identifier: MIT OR Apache-2.0
//! Infinitely long prisms, such as rails: finite elements over the cross-section, waves along the axis.
//!
//! **What.** A [`Section`] of six-node triangles with an elastic [`Material`](crate::Material) on a [`Foot`] is a [`Prism`]. Under the
//! rows of contact grids it becomes a [`PrismCompliance`].
//!
//! **How.** Displacements are `U(y, z) exp(i k x)` for each wave number `k`. With `u_x = i a` the stiffness
//! `K(k) = K0 + k K1 + k^2 K2` of a section is real, symmetric and, for `k > 0` or on a foot, positive definite. The
//! compliance of the rows, `S(k) = F^T K(k)^-1 F` with the loads `F` of their hats (or uniform strips), is that of a
//! half-space where waves are short, so the difference is known from few wave numbers and is smooth. In space the
//! body is the half-space in closed form, plus the integral of that difference over `k >= 0` by Gauss' rule: no
//! period, and no neighbours.
//!
//! **References.** [Johnson1985] for lines on a half-space, [Hughes2000] for the elements.

mod compliance;
#[cfg(test)]
mod curved;
mod line;
mod pair;
mod rows;
mod stiffness;
#[cfg(test)]
mod tests;

pub use compliance::{PrismCompliance, Strip};
pub use pair::{PrismPair, PrismRows};
pub use stiffness::Prism;

/// Cross-section of a prism in (y, z).
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Nodes (y, z) [m].
    pub nodes: Vec<[f64; 2]>,
    /// Corners against the clock, then the middles of 01, 12, 20.
    pub triangles: Vec<[usize; 6]>,
    /// Edges of the base: both ends, then the middle.
    pub base: Vec<[usize; 3]>,
}

/// What the base of a prism stands on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Foot {
    /// The base does not move.
    Held,
    /// Springs spread evenly over the base.
    Pads {
        /// Vertical stiffness per length of the prism [N/m2].
        vertical: f64,
        /// Lateral and longitudinal stiffness per length [N/m2].
        lateral: f64,
    },
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Elastic bodies seen from their contact surface.
//!
//! **What.** [`half_space`]: the influence coefficients of rectangles, and half-spaces on regular grids of
//! rectangles or of bilinear hats and on scattered points, and the stress inside; [`dang_van`]: fatigue of what passes
//! through such a stress; [`tetra`]: finite-element bodies condensed onto their contact points; [`prism`]: infinitely
//! long bodies by waves along their axis. All end as a [`mtb_operator::Compliance`].
//!
//! **Not here.** No contact conditions, no friction, no geometry of profiles.
//!
//! **Conventions.** Every body lives in its own frame (tangential 1, tangential 2, into): a positive
//! normal traction is a pressure, a positive normal displacement an indentation. SI units.
//!
//! **References.** [Johnson1985], [Love1929], [AhmadiKeerMura1983], [Burmister1945], [Kalker1990], [Hughes2000], [GeorgeLiu1981],
//! [DangVanGriveauMessage1989],
//! [Gaertner1999], [Steininger2025] for the Gaussians.

mod error;
mod fatigue;
pub mod half_space;
mod lines;
mod material;
pub mod prism;
pub mod refined;
pub mod tetra;

pub use error::Error;
pub use fatigue::dang_van;
pub use half_space::HalfSpace;
pub use lines::Lines;
pub use material::Material;

/// The examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;

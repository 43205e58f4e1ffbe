// SPDX-License-Identifier: MIT OR Apache-2.0
//! Temperatures of bodies that rub on each other.
//!
//! **What.** [`rolling`]: surface temperatures of two bodies that pass through their contact at the same speed, as
//! a wheel and a rail do; [`Warming`]: the same as a linear map, where they touch. [`HalfSpace`]: the temperature of
//! a half-space under heat that moves over it, at any speed, as a rail under a sliding shoe.
//!
//! **How.** A body that passes quickly is heated at its skin alone: heat that a point got a time t ago, while it
//! passed through the contact, warms it by `1 / (beta sqrt(pi t))`, with the effusivity `beta` [Jaeger1942]. At any
//! speed V, a source of strength Q at rest on a moving half-space warms it at a distance r, x of it downstream, by
//! `Q exp(-V (r - x) / 2 kappa) / (2 pi K r)` [CarslawJaeger1959].
//!
//! **Conventions.** SI units; temperatures are differences to any common level [K]; a flux is positive into a body.
//! Fields over grids have x fastest.

mod conductor;
mod error;
mod half_space;
mod rolling;
mod trail;
mod warming;

pub use conductor::Conductor;
pub use error::Error;
pub use half_space::HalfSpace;
pub use rolling::{Passage, Temperatures, rolling};
pub use warming::Warming;

/// The examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;

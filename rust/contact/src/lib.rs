// SPDX-License-Identifier: MIT OR Apache-2.0
//! Frictional contact problems: stated, solved, reported.
//!
//! **What.** [`problem`]: two bodies that meet in points, with free motions and loads, and what can be asked of
//! them; [`coupled`]: stick and slip with a pressure that follows. [`normal`]: frictionless contact on regular grids. [`sliding`]: gross sliding of any pair of
//! compliances; [`staggered`], [`incremental`]: the thesis' loop around an elastic body and its load
//! increments, for comparison. [`tangential`]: stick and slip in shifts, transient and steady rolling, with
//! [`friction`] laws, such that follow the [`temperature`] among them, and a layer. [`kalker`], [`fastsim`], [`fastrip`], [`polach`]: the fast approximations.
//! [`interface`]: hardness and rough layers between the bodies.
//! [`stepping`], [`prepared`]: the sliding pair in a simulation, solved once a step; [`vibrating`]: with the
//! inertia of its bodies; [`record`]: the form in
//! which it is kept. [`wear`]: what sliding takes off, step by step;
//! [`steps`]: how long such a step may be. [`magnet`]: a pull that follows the gap.
//!
//! **Not here.** No body, no mesh, no file: bodies enter as compliances on contact points.
//!
//! **Conventions.** SI units. The gap is positive where open, pressure where it pushes apart;
//! tractions act on the lower body, the upper one feels their opposite; the sliding direction is the motion
//! of the upper body over the lower one, so friction on the lower body is `q = mu p d`.
//!
//! **References.** [Johnson1985], [Kalker1990], [Klarbring1990].

mod across;
mod anderson;
mod columns;
pub mod coupled;
mod error;
pub mod fastrip;
pub mod fastsim;
mod flexibilities;
pub mod friction;
mod inclination;
pub mod incremental;
pub mod interface;
pub mod kalker;
pub mod magnet;
pub mod normal;
pub mod polach;
pub mod prepared;
pub mod problem;
pub mod record;
pub mod sliding;
pub mod staggered;
pub mod stepping;
pub mod steps;
mod strips;
pub mod tangential;
pub mod temperature;
pub mod vibrating;
pub mod wear;

pub use across::{Across, Pressed, RowInfluence};
pub use error::Error;
pub use inclination::Inclination;

/// The examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;

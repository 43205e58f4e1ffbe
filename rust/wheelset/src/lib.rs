// SPDX-License-Identifier: MIT OR Apache-2.0
//! Wheels on rails in a simulation: pose and velocity of the wheelset in, forces and tractions out.
//!
//! **What.** A [`Wheelset`] says which profiles, bodies and friction; [`PreparedWheels`] solves it once a step:
//! it places the profiles, finds the contact planes and, where the height is left open, the height (and roll)
//! at which the wheels carry their force; then pressures, creepages and the tractions of steady rolling.
//!
//! **Not here.** No influence coefficient, no contact solver, no profile: those are in `mtb-elasticity`,
//! `mtb-contact` and `mtb-geometry`.
//!
//! **Conventions.** SI units. The track frame: x along the rails, the direction of travel, y to the left, z up;
//! its origin lies on the top of the rails in the middle of the track. Forces and tractions act on the rail.
//! A pose is a displacement x, y, z [m], roll, pitch, yaw [rad]: turned by the pitch about the fixed y axis through the
//! reference point, as far as the wheels have rolled, then by roll and yaw about the fixed x and z axes, then shifted.
//!
//! **References.** [Kalker1990], [Johnson1985].

mod balance;
mod bytes;
mod derivative;
mod equilibrium;
mod error;
mod friction;
mod linear;
mod memory;
mod moduli;
mod operators;
mod patch;
mod prepared;
mod rolling;
mod root;
mod rows;
mod state;
mod track;
mod transient;
mod way;
mod wheelset;

pub use derivative::{PatchChange, WheelChange, WheelInput, WheelMargin, WheelTangent};
pub use error::Error;
pub use friction::{RailFriction, WheelFriction};
pub use patch::{PatchRow, PointStatus, WheelPatch};
pub use prepared::{Accuracy, AxleLoad, PreparedWheels, StepInput, Velocity, WheelStep};
pub use state::{Found, PatchHistory, PatchRatio, WheelState};
pub use track::{Alignment, RailDeviation, RailSprings, WheelDeviation};
pub use wheelset::{Side, Sides, Wheelset};

/// The examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;

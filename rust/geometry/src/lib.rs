// SPDX-License-Identifier: MIT OR Apache-2.0
//! Profiles, surfaces, contact points and gaps.
//!
//! **What.** Cross-sections of rails and wheels ([`Profile`]), the pole shoe of a magnetic track
//! brake on a rail ([`PoleShoe`]) with the regular grids of contact points laid over it
//! ([`ContactGrid`]), a wheel on a rail ([`WheelOnRail`]) with its contact plane and gap, the same in any
//! pose of its wheelset ([`WheelOverRail`]), and the gap
//! between arbitrary surfaces ([`SurfacePair`]): analytic ones and triangle meshes ([`SurfaceMesh`]),
//! whose facets are taken for the curved surface they stand for. [`solid`]: blocks, pole shoes and rails filled
//! with tetrahedra that follow a contact grid.
//!
//! **Not here.** No material, no load, no compliance, no solver.
//!
//! **Conventions.** SI units. z points from the lower body to the upper one, x along the rail, y to
//! its left; gap > 0 is open. Vectors of many points are component-major: all x, all y, all z.
//! Contact points run x fastest.
//!
//! **References.** [EN13674-1] for the rail, [EN13715] for the wheel, [EN15302] for level
//! axles of wheelsets, [Steininger2025] for the shoe.

use std::ops::ControlFlow;

mod between;
mod columns;
mod contact_points;
mod error;
mod mesh;
mod profile;
mod root;
mod shoe;
pub mod solid;
mod surface;
mod wheel;

pub use between::{SurfaceGap, SurfacePair};
pub use columns::{Column, Columns, LENGTHS, read_columns};
pub use contact_points::{ContactGrid, ContactPoints, GridPatch, cells_over};
pub use error::Error;
pub use mesh::{Closure, SurfaceMesh};
pub use profile::{
    Interpolation, Profile, ProfileForm, ProfileTable, Sliced, Slices, Station, Vertical,
};
pub use shoe::PoleShoe;
pub use surface::{Found, HeightField, HeightSurface, Hit, Surface};
pub use wheel::{
    Axle, GapField, PlaneChange, PlaneGap, Rows, StandingWheelset, Touch, WheelOnRail,
    WheelOverRail, WheelPose, WheelRailContact, WheelRailLoad,
};

/// Asked now and then by what takes long; `Break` makes it stop with [`Error::Interrupted`].
pub type Look<'a> = &'a dyn Fn() -> ControlFlow<()>;

/// The look that never interrupts.
pub fn unwatched() -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// The examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;

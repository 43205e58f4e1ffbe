// SPDX-License-Identifier: MIT OR Apache-2.0
//! The half-space: influence coefficients of rectangles, the body on regular grids or scattered points, and the stress
//! inside.

mod body;
mod gaussian;
mod hats;
mod influence;
mod integrals;
mod layered;
mod pair;
mod quadrature;
mod radial;
mod stress;
mod viscoelastic;

pub use body::{HalfSpace, Medium, Neighbours, Patch, wave_compliance};
pub use gaussian::GaussianBasis;
pub use hats::{CutHats, HatHalfSpace, HatShare};
pub use influence::influence;
pub use integrals::{GaussianHalfSpace, SurfaceIntegrals};
pub use layered::{Bond, Layered, Waves};
pub use pair::{LinePair, NormalPair, Pair, TangentialPair};
pub use stress::{LoadedCell, Stress, StressBelow, stress_at, stress_influence};
pub use viscoelastic::Viscoelastic;

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Linear maps on contact points.
//!
//! **What.** [`LinearOperator`] (a square map on `f64` vectors), [`Compliance`] (traction in,
//! displacement out, component by component), and the ways to build them: dense matrices, Fourier
//! convolutions on regular grids, sums of bodies, two bodies as one ([`Relative`]); [`dense`] factors that can be interrupted.
//!
//! **Not here.** No mechanics, no geometry, no contact conditions.
//!
//! **Conventions.** A field over `n` contact points is one slice per component. On regular grids the
//! points run x fastest, then y. A compliance lives in the frame of its own body: components
//! `(tangential 1, tangential 2, into)`, where *into* points into the body, so a positive normal
//! traction is a pressure and a positive normal displacement is an indentation. With unequal
//! areas a compliance is symmetric in the area-weighted product only.
//!
//! **References.** [Johnson1985] for the sign pattern of the half-space, [SaadSchultz1986] for GMRES.

mod compliance;
mod convolution;
pub mod dense;
mod error;
mod fourier;
mod grid;
pub mod krylov;
mod linear;
mod memory;
mod monitor;
mod relative;
mod rows;
mod separate;
mod symmetric;
mod wide;
mod workers;

pub use compliance::{Block, Compliance, Component, Mirrored, Sum};
pub use convolution::Convolution;
pub use error::Error;
pub use fourier::{Buffers, Kernel, Precision, Spectra, Transform, fast_even_size};
pub use grid::Grid;
pub use linear::{LinearOperator, Map};
pub use memory::{
    MEMORY_LIMIT, available_address_space, available_memory, check_dense, check_factors,
    check_memory,
};
pub use monitor::{Interrupted, Monitor, Progress, report, unmonitored};
pub use relative::Relative;
pub use rows::RowConvolution;
pub use rustfft::num_complex::Complex;
pub use separate::{Reflected, Separate};
pub use symmetric::{SymmetricHalf, SymmetricWhole};
pub use wide::wide;
pub use workers::{on_workers, ready_products, ready_workers, reset_workers, side_by_side};

/// The examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;

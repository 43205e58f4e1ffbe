// SPDX-License-Identifier: MIT OR Apache-2.0
//! Complementarity problems and variational inequalities over simple sets.
//!
//! **What.** [`linear`]: dense linear complementarity problems, symmetric or not, with free rigid
//! motions and their balance equations; an active-set Newton method, Lemke's method as the
//! certificate that no solution exists, projected Gauss-Seidel for comparison. [`discs`]: variational
//! inequalities on discs, matrix-free, with fixed radii or radii that depend on the image, and with
//! prescribed resultants; a semismooth Newton method. [`bounded`]: symmetric linear problems of any
//! size, known by their products; preconditioned conjugate gradients.
//!
//! **Not here.** No mechanics: a pressure is a variable that must not be negative, a gap is its
//! complementary slack.
//!
//! **Conventions.** `w = A p + b - N c >= 0`, `p >= 0`, `w . p = 0`, `K^T p = f`. Matrices are row-major
//! slices. Tolerances are relative to the data.
//!
//! **References.** [Cottle2009] for the theory and Lemke's method, [Hintermueller2002] for the
//! active-set method as a semismooth Newton method, [QiSun1993] for such methods in general,
//! [PolonskyKeer1999] and [Vollebregt2014] for conjugate gradients with bounds.

pub mod bounded;
pub mod discs;
mod error;
pub mod linear;

pub use error::Error;

/// The examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;

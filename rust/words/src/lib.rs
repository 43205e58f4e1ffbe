// SPDX-License-Identifier: MIT OR Apache-2.0
//! Numbers as messages show them: one way for all crates.

mod memory;
mod short;

pub use memory::Memory;
pub use short::{Rough, Short};

/// The examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;

// SPDX-License-Identifier: MIT OR Apache-2.0
use thiserror::Error;

use crate::Interrupted;
use mtb_words::{Memory, Short};

/// What this crate refuses, or why its work was broken off.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A grid without points, or with a spacing that is not a positive number.
    #[error(
        "grid of {nx} x {ny} points with spacing {} x {} m: counts must be at least 1, spacings positive and finite",
        Short(*.dx), Short(*.dy)
    )]
    Grid {
        /// Points along x.
        nx: usize,
        /// Points along y.
        ny: usize,
        /// Spacing along x [m].
        dx: f64,
        /// Spacing along y [m].
        dy: f64,
    },
    /// More points than the memory holds.
    #[error(
        "{points} contact points take {}; the limit is {}, and the machine has {} free: take fewer, larger cells",
        Memory(*.gigabytes), Memory(*.limit), Memory(*.available)
    )]
    Memory {
        /// Points asked for.
        points: usize,
        /// Memory [GB] that they need.
        gigabytes: f64,
        /// Memory [GB] that is granted.
        limit: f64,
        /// Memory [GB] that the machine has free.
        available: f64,
    },
    /// No memory for the products of matrices.
    #[error(
        "the memory does not suffice: products of matrices take a buffer of {}, and {} are free: raise the limit of the address space (ulimit -v)",
        Memory(*.gigabytes), Memory(*.available)
    )]
    Buffer {
        /// Memory [GB] that one thread needs.
        gigabytes: f64,
        /// Memory [GB] that is free.
        available: f64,
    },
    /// Two bodies that do not meet in the same points.
    #[error("the lower body has {lower} contact points, the upper one {upper}")]
    Points {
        /// Points of the lower body.
        lower: usize,
        /// Points of the upper body.
        upper: usize,
    },
    /// Two bodies of which none gives way.
    #[error("both bodies are rigid: at least one that gives way is needed")]
    Rigid,
    /// A layer that is not given by a number of at least 0 for each point.
    #[error(
        "the layer has {found} flexibilities, for {points} contact points, one of them is {}: one of at least 0 m/Pa for each is needed",
        Short(*.value)
    )]
    Layer {
        /// Flexibilities given.
        found: usize,
        /// Contact points of the bodies.
        points: usize,
        /// The first one that is none, or 0 [m/Pa].
        value: f64,
    },
    /// The monitor asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl From<Interrupted> for Error {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}

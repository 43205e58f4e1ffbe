// SPDX-License-Identifier: MIT OR Apache-2.0
use thiserror::Error;

use crate::memory::amount;

/// What the constructors of this crate refuse.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A grid without points, or with a spacing that is not a positive number.
    #[error(
        "grid of {nx} x {ny} points with spacing {dx:e} x {dy:e} m: counts must be at least 1, spacings positive and finite"
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
        amount(*.gigabytes), amount(*.limit), amount(*.available)
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
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_words::Short;

/// What can be wrong with a contact, or keep it from being solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A geometry that makes no sense.
    #[error(transparent)]
    Geometry(#[from] mtb_geometry::Error),
    /// A body that makes no sense, or is too large.
    #[error(transparent)]
    Elasticity(#[from] mtb_elasticity::Error),
    /// Compliances that do not belong together.
    #[error(transparent)]
    Operator(#[from] mtb_operator::Error),
    /// A contact problem that makes no sense, or an interruption.
    #[error(transparent)]
    Contact(#[from] mtb_contact::Error),
    /// A body that its contact points miss.
    #[error(
        "the contact points of {body} meet only {share:.0} % of their area on it: its face leaves the surface below too steeply"
    )]
    Missed {
        /// Name of the body.
        body: String,
        /// Share of the area that is met, in percent.
        share: f64,
    },
    /// Bodies that no load brings together.
    #[error(
        "the bodies never touch: {loads} leaves a gap of {} m or more between them; a force [N] or a pull [Pa] that presses them together, or an approach [m] that closes the gap, is needed",
        Short(*.gap)
    )]
    Apart {
        /// The loads, in words.
        loads: String,
        /// Least gap between the bodies [m].
        gap: f64,
    },
    /// A velocity of sliding without a direction.
    #[error(
        "the sliding velocity is ({}, {}): two finite numbers, not both zero, are needed (without sliding the bodies are pressed)",
        Short(.along[0]), Short(.along[1])
    )]
    Still {
        /// The velocity, x and y.
        along: [f64; 2],
    },
    /// A state of contact that was not found.
    #[error("{0}")]
    Unsolved(String),
}

// SPDX-License-Identifier: MIT OR Apache-2.0
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
    /// An approach of a body that gives way to it.
    #[error(
        "an approach is given, but a body is free along z and nothing presses it: hold it along z, or give a force or a pull"
    )]
    Unpressed,
    /// A state of contact that was not found.
    #[error("{0}")]
    Unsolved(String),
}

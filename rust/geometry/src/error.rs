// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_words::{Rough, Short};

/// What can be wrong with a geometry.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A scalar is NaN or infinite.
    #[error("{name} is {}: a finite number is needed", Short(*.value))]
    NotFinite {
        /// Argument.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A scalar is finite but outside what makes sense.
    #[error("{name} is {}: {accepted}", Short(*.value))]
    OutOfRange {
        /// Argument.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What would be accepted, as a clause.
        accepted: String,
    },
    /// An element of an array is NaN or infinite.
    #[error("{name}[{index}] is {}: finite numbers are needed", Short(*.value))]
    ElementNotFinite {
        /// Array.
        name: &'static str,
        /// Position in the flat array.
        index: usize,
        /// The element.
        value: f64,
    },
    /// An array has the wrong length or too few elements.
    #[error("{name} has {found} elements: {accepted}")]
    Length {
        /// Array.
        name: &'static str,
        /// Elements found.
        found: usize,
        /// What would be accepted, as a clause.
        accepted: String,
    },
    /// A station lies outside a profile.
    #[error("{name}[{index}] is {} m: the profile reaches from {} m to {} m", Short(*.value), Short(*.start), Short(*.end))]
    OutsideProfile {
        /// Argument.
        name: &'static str,
        /// Position in the array.
        index: usize,
        /// Lateral position or arc length [m].
        value: f64,
        /// Beginning of the profile [m].
        start: f64,
        /// End of the profile [m].
        end: f64,
    },
    /// The lateral positions of a profile table are not strictly monotonic.
    #[error(
        "row {row} of the profile: y = {} m after {} m; y must rise (or fall) strictly from row to row (where a flank is undercut, cut the profile off at the point where y turns back)",
        Short(*.y), Short(*.previous)
    )]
    NotMonotonic {
        /// Row, counted from 1.
        row: usize,
        /// Its lateral position [m].
        y: f64,
        /// The one before [m].
        previous: f64,
    },
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {triangle} refers to vertex {vertex}: there are {count} vertices")]
    MissingVertex {
        /// Triangle, counted from 0.
        triangle: usize,
        /// Vertex it names.
        vertex: usize,
        /// Number of vertices.
        count: usize,
    },
    /// A triangle without area.
    #[error("triangle {triangle} is degenerate: its area is {} m2", Short(*.area))]
    DegenerateTriangle {
        /// Triangle, counted from 0.
        triangle: usize,
        /// Its area [m2].
        area: f64,
    },
    /// Two triangles run along an edge in the same direction.
    #[error(
        "two triangles use the edge from vertex {from} to vertex {to} in the same direction: their orientations contradict, or more than two meet there"
    )]
    Contradicting {
        /// First vertex.
        from: usize,
        /// Second vertex.
        to: usize,
    },
    /// A body with holes.
    #[error("the surface is not watertight: {open} edges belong to one triangle only")]
    NotWatertight {
        /// Number of open edges.
        open: usize,
    },
    /// Triangles that point inwards.
    #[error("the triangles point inwards (volume {} m3): reverse their order", Short(*.volume))]
    InsideOut {
        /// Signed volume [m3].
        volume: f64,
    },
    /// A body so small or so large that its unit must be wrong.
    #[error(
        "the largest extent of the mesh is {} m: state the unit of its coordinates (10 um to 20 m are accepted)",
        Short(*.size)
    )]
    ImplausibleSize {
        /// Largest extent [m].
        size: f64,
    },
    /// A place that no node of a body is near.
    #[error("the point {place:?} is {} m away from the nearest node", Short(*.distance))]
    FarNode {
        /// Where it should be [m].
        place: [f64; 3],
        /// Distance to the nearest node [m].
        distance: f64,
    },
    /// The search tree could not be built.
    #[error("the triangles cannot be searched: {reason}")]
    Tree {
        /// Why not.
        reason: String,
    },
    /// Facets too coarse for the contact.
    #[error(
        "the facets leave an error of {} m in the gap near ({}, {}) m, not small against the approach of {} m: refine the mesh there or use an analytic surface",
        Short(*.error), Short(*.x), Short(*.y), Short(*.approach)
    )]
    FacetsTooCoarse {
        /// Estimated error [m].
        error: f64,
        /// Expected approach [m].
        approach: f64,
        /// Place [m].
        x: f64,
        /// Place [m].
        y: f64,
    },
    /// The lower body is missing under a contact point.
    #[error("the lower body has no surface at ({}, {}) m, inside the area that was asked for", Short(*.x), Short(*.y))]
    NoSurface {
        /// Place [m].
        x: f64,
        /// Place [m].
        y: f64,
    },
    /// Two bodies cannot be brought together.
    #[error("the bodies never touch: {reason}")]
    NeverTouch {
        /// Why not.
        reason: String,
    },
    /// The contact would reach the end of a profile.
    #[error(
        "the contact reaches the end of the {profile} profile at y = {} m: a longer profile or a smaller load is needed",
        Short(*.end)
    )]
    ProfileEnds {
        /// "rail" or "wheel".
        profile: &'static str,
        /// End that is reached, in the profile's own frame [m].
        end: f64,
    },
    /// Rigid bodies that touch where a profile ends.
    #[error(
        "the bodies touch at the end of the {profile} profile, y = {} m: a longer profile or a smaller shift is needed",
        Short(*.end)
    )]
    TouchesEnd {
        /// "rail" or "wheel".
        profile: &'static str,
        /// The end, in the profile's own frame [m].
        end: f64,
    },
    /// A wheelset that cannot stand on the rails where it is shifted to.
    #[error("at a lateral shift of {} m: {reason}", Short(*.shift))]
    AtShift {
        /// The shift to the left [m].
        shift: f64,
        /// Why not.
        reason: String,
    },
    /// Coordinates of nodes that do not rise.
    #[error("{name}: at least two rising numbers [m] are needed")]
    NotRising {
        /// Argument.
        name: &'static str,
    },
    /// Nodes that do not span the conforming strip of a pole.
    #[error("y runs from {} to {} m: the conforming strip is {} to {} m", Short(*.start), Short(*.end), Short(*.inner), Short(*.outer))]
    OffStrip {
        /// First coordinate |y| [m].
        start: f64,
        /// Last one [m].
        end: f64,
        /// Where the strip begins [m].
        inner: f64,
        /// Where it ends [m].
        outer: f64,
    },
    /// A contact that does not fit on its rail.
    #[error("length is {} m: the contact from {} to {} m is longer", Short(*.length), Short(*.start), Short(*.end))]
    ShortRail {
        /// Length of the rail [m].
        length: f64,
        /// Beginning of the contact [m].
        start: f64,
        /// Its end [m].
        end: f64,
    },
    /// A solid that could not be factorised.
    #[error(
        "the mesh would have about {} tetrahedra with {} unknowns, more than {}: larger elements are needed (element_size, size or spacing)",
        Rough(*.tetrahedra), Rough(*.unknowns), Rough(*.most)
    )]
    TooManyTetrahedra {
        /// Tetrahedra expected.
        tetrahedra: f64,
        /// Unknown displacements expected.
        unknowns: f64,
        /// Most of them.
        most: f64,
    },
    /// A tetrahedron or a set names a node that does not exist.
    #[error("a tetrahedron or a set of nodes refers to node {node}: there are {count} nodes")]
    MissingNode {
        /// Node that is named.
        node: usize,
        /// Number of nodes.
        count: usize,
    },
    /// The look at a wish to stop found one.
    #[error("interrupted")]
    Interrupted,
    /// A contact too large for its spacing.
    #[error(
        "the contact takes {nx} x {ny} points at a spacing of {} x {} m: at most {most} are accepted, so a larger spacing is needed, or a smaller contact",
        Short(*.dx), Short(*.dy)
    )]
    TooManyPoints {
        /// Points along the rail.
        nx: f64,
        /// Points across.
        ny: f64,
        /// Spacing along the rail [m].
        dx: f64,
        /// Spacing across [m].
        dy: f64,
        /// Most points accepted.
        most: f64,
    },
    /// What is not there for wheels and rails with slices.
    #[error(
        "{what} for wheels of revolution on straight rails alone: this wheel or this rail has slices"
    )]
    Sliced {
        /// What, with its verb.
        what: &'static str,
    },
    /// A rail that varies along the track cannot be turned into a roller.
    #[error(
        "roller_radius and slices of the rail exclude each other: a roller has one profile all around, and slices along a \
         track do not close around it"
    )]
    UnevenRoller,
    /// Rows of cells along a rail that is none.
    #[error(
        "patches that follow the rail are known for wheels of revolution on straight rails alone: this wheel or this rail \
         has slices, or the rail is a roller"
    )]
    NotStraight,
    /// Points that are no outline of a section.
    #[error("the outline of the section {0}: a polygon that goes round once is needed")]
    Outline(&'static str),
    /// Sections that do not make slices.
    #[error("slices: {reason}")]
    NoSlices {
        /// Why not.
        reason: String,
    },
    /// Numbers that are no profile.
    #[error("the numbers given are no profile: {reason}")]
    NoProfile {
        /// Why not.
        reason: &'static str,
    },
    /// A line of a profile file cannot be read.
    #[error("line {line} of the file: {reason}")]
    Unreadable {
        /// Line, counted from 1.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
}

/// `value` if it is finite.
pub(crate) fn finite(name: &'static str, value: f64) -> Result<f64, Error> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(Error::NotFinite { name, value })
    }
}

/// `value` if it is finite and positive.
pub(crate) fn positive(name: &'static str, value: f64) -> Result<f64, Error> {
    if finite(name, value)? > 0.0 {
        Ok(value)
    } else {
        Err(out_of_range(name, value, "it must be positive"))
    }
}

/// Checks that every element is finite.
pub(crate) fn all_finite(name: &'static str, values: &[f64]) -> Result<(), Error> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(index) => Err(Error::ElementNotFinite {
            name,
            index,
            value: values[index],
        }),
    }
}

/// An [`Error::OutOfRange`].
pub(crate) fn out_of_range(name: &'static str, value: f64, accepted: impl Into<String>) -> Error {
    Error::OutOfRange {
        name,
        value,
        accepted: accepted.into(),
    }
}

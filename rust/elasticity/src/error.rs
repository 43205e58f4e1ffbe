// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_words::{Memory, Short};
use thiserror::Error;

/// What the bodies of this crate refuse.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// Elastic constants that no stable isotropic material has.
    #[error(
        "shear modulus {} Pa, Poisson's ratio {}: the modulus must be positive and finite, the ratio in (-1, 0.5]",
        Short(*.shear_modulus), Short(*.poisson_ratio)
    )]
    Material {
        /// Shear modulus [Pa].
        shear_modulus: f64,
        /// Poisson's ratio [-].
        poisson_ratio: f64,
    },
    /// A layer without thickness.
    #[error("the thickness of a layer is {} m: a positive, finite number is needed", Short(*.0))]
    Thickness(f64),
    /// Creep that is none.
    #[error(
        "creep adds {} times the compliance, over ways of {} and {} m: a number of at least 0, and finite ways are needed",
        Short(*.creep), Short(.way[0]), Short(.way[1])
    )]
    Creep {
        /// Compliance that creep adds, over that before [-].
        creep: f64,
        /// Velocity of the contact times the creep time [m].
        way: [f64; 2],
    },
    /// A contact of rigid bodies only.
    #[error("both bodies are rigid: one of them must be elastic")]
    NoBody,
    /// A contact patch that is no grid, or more than the memory holds.
    #[error(transparent)]
    Operator(mtb_operator::Error),
    /// Patches of one body whose spacings differ by more than a third.
    #[error(
        "patch {patch} has spacing {} x {} m, the first one {} x {} m: the spacings of the patches of a body may differ by a third",
        Short(*.dx), Short(*.dy), Short(*.first_dx), Short(*.first_dy)
    )]
    PatchSpacing {
        /// Index of the patch.
        patch: usize,
        /// Its spacing along x [m].
        dx: f64,
        /// Its spacing along y [m].
        dy: f64,
        /// Spacing of the first patch along x [m].
        first_dx: f64,
        /// Spacing of the first patch along y [m].
        first_dy: f64,
    },
    /// A body that is much stiffer than a half-space on its coarse grid.
    #[error(
        "the body is locally more than three times as stiff as a half-space, or free to move and thin: its compliance on a finer grid might not be positive definite"
    )]
    Stiff,
    /// Lines that are no part of those of a grid.
    #[error("lines of a grid must rise from 0 to its last one, number {}", .0.saturating_sub(1))]
    Lines(usize),
    /// A prism that cannot be solved.
    #[error("a prism cannot be solved: {0}")]
    Section(&'static str),
    /// A body without contact patches.
    #[error("a half-space needs at least one contact patch")]
    NoPatch,
    /// Poisson's ratio that finite elements cannot take.
    #[error("Poisson's ratio is {}: finite elements need less than 0.5", Short(*.0))]
    Incompressible(f64),
    /// An array of the wrong length.
    #[error("{name} has {found} entries, {expected} are needed")]
    Shape {
        /// Which array.
        name: &'static str,
        /// What was given.
        found: usize,
        /// What would do.
        expected: usize,
    },
    /// A number that is not finite.
    #[error("{name} {index} is not finite")]
    NotFinite {
        /// Which array.
        name: &'static str,
        /// Where in it.
        index: usize,
    },
    /// A place outside of the body whose inside is asked for.
    #[error(
        "depth {index} is {} m, above the surface of the body: depths of at least 0 are needed", Short(*.depth)
    )]
    AboveSurface {
        /// Which place.
        index: usize,
        /// Its depth below the surface [m].
        depth: f64,
    },
    /// A place below a layer, in a base that is rigid.
    #[error("depth {index} is {} m, in the rigid base below the layer, which has no stress", Short(*.depth))]
    InRigidBase {
        /// Which place.
        index: usize,
        /// Its depth below the surface [m].
        depth: f64,
    },
    /// Friction on a layer that slides freely.
    #[error(
        "the layer slides on its base without friction, and is carried away by tractions along its surface"
    )]
    CarriedAway,
    /// A place at which the stress of uniform tractions may be infinite.
    #[error(
        "point {0} lies on the surface at the border of a loaded cell, where the stress of uniform tractions may be infinite: the middle of a cell, or a depth above 0, is needed"
    )]
    OnBorder(usize),
    /// A place outside of a body of finite elements.
    #[error("point {0} is in no tetrahedron of the body")]
    NotInside(usize),
    /// A cell without extent.
    #[error("cell {0} has no extent: both sides must be positive")]
    CellSides(usize),
    /// An index out of range.
    #[error("{name} {index} refers to {what} {value}, but there are {count}")]
    Index {
        /// Which array.
        name: &'static str,
        /// Where in it.
        index: usize,
        /// What is referred to.
        what: &'static str,
        /// The index found.
        value: usize,
        /// How many there are.
        count: usize,
    },
    /// A tetrahedron turned inside out.
    #[error("tetrahedron {tet} is inverted: its volume is {} m3", Short(*.volume))]
    Inverted {
        /// Its number.
        tet: usize,
        /// Its smallest Jacobian over six [m3].
        volume: f64,
    },
    /// A tetrahedron without thickness.
    #[error(
        "tetrahedron {tet} is a sliver: its quality is {}, at least {} is needed (regular: 1)",
        Short(*.quality), Short(*.limit)
    )]
    Sliver {
        /// Its number.
        tet: usize,
        /// Volume over that of a regular tetrahedron with the same mean square edge.
        quality: f64,
        /// The smallest quality accepted.
        limit: f64,
    },
    /// A node that belongs to nothing.
    #[error("node {0} belongs to no tetrahedron")]
    LooseNode(usize),
    /// More than one body.
    #[error("the mesh has {0} separate pieces: one connected piece is needed")]
    Pieces(usize),
    /// A film that no heat can pass as it says.
    #[error(
        "a film has the coefficient {} W/(m2 K) and the ambient temperature {} K: the coefficient must not be negative, and both must be finite",
        Short(*.coefficient), Short(*.ambient)
    )]
    Film {
        /// Heat transfer coefficient [W/(m2 K)].
        coefficient: f64,
        /// Temperature outside [K].
        ambient: f64,
    },
    /// A step of no duration.
    #[error("the duration of a step is {} s: it must be positive and finite", Short(*.0))]
    Duration(f64),
    /// More vibrations than the body has.
    #[error(
        "{asked} vibrations are asked for: the body has {most}, as many as it has free displacements"
    )]
    Vibrations {
        /// How many are asked for.
        asked: usize,
        /// How many there are.
        most: usize,
    },
    /// A displacement component claimed twice.
    #[error(
        "supports \"{first}\" and \"{second}\" both hold {component} of node {node}: one of them may"
    )]
    Contradiction {
        /// The support that came first.
        first: String,
        /// The other.
        second: String,
        /// Which displacement.
        component: char,
        /// Of which node.
        node: usize,
    },
    /// Rigid motions that neither the supports nor the contact can hold.
    #[error("the supports leave the body free to move, and the contact cannot hold it: {0}")]
    Loose(String),
    /// Supports that hold all there is.
    #[error("the supports hold every node of the mesh: at least one free node is needed")]
    Held,
    /// A triangle that is not on the surface.
    #[error("triangle {0} is no face of the body's boundary")]
    NotOnBoundary(usize),
    /// A point away from the surface.
    #[error("point {point} is more than {} m away from the contact face", Short(*.reach))]
    OffSurface {
        /// Its index.
        point: usize,
        /// The distance allowed [m].
        reach: f64,
    },
    /// A contact point without area.
    #[error(
        "contact point {0} lies beside the contact face, so no area of the face belongs to it: lay the point on the face, or leave it out"
    )]
    NoArea(usize),
    /// A frame that is not orthonormal.
    #[error("the frame at quadrature point {0} is not orthonormal")]
    Frame(usize),
    /// A stiffness matrix that is not positive definite.
    #[error(
        "the stiffness matrix is not positive definite at node {node}: part of the body can move without strain"
    )]
    Singular {
        /// The node whose pivot vanished.
        node: usize,
    },
    /// A problem too large to start.
    #[error(
        "{unknowns} unknowns need {} and {} TFlop to factorise; the limits are {} and {} TFlop, and the machine has {} free: coarsen the mesh",
        Memory(*.gigabytes), Short(*.teraflop), Memory(*.gigabytes_limit), Short(*.teraflop_limit), Memory(*.available)
    )]
    TooLarge {
        /// Unknown displacements.
        unknowns: usize,
        /// Memory of the factor.
        gigabytes: f64,
        /// Its operations.
        teraflop: f64,
        /// Memory allowed.
        gigabytes_limit: f64,
        /// Operations allowed.
        teraflop_limit: f64,
        /// Memory that the machine has free.
        available: f64,
    },
    /// The system gave no memory.
    #[error(
        "the process ran out of memory while {unknowns} unknowns were factorised: coarsen the mesh, or leave the process more memory"
    )]
    OutOfMemory {
        /// Unknown displacements.
        unknowns: usize,
    },
    /// A number that must be positive is not.
    #[error("{name} is {}, a positive finite number is needed", Short(*.value))]
    NotPositive {
        /// Name of the number.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A patch of hats needs two nodes in each direction.
    #[error("patch {patch} has {nx} x {ny} nodes: at least 2 x 2 are needed")]
    NoCell {
        /// Index of the patch.
        patch: usize,
        /// Nodes along x.
        nx: usize,
        /// Nodes along y.
        ny: usize,
    },
    /// Basis functions leave a hole in the surface that they should cover.
    #[error(
        "no basis function covers the point ({}, {}) m: a larger standard deviation is needed",
        Short(*.x), Short(*.y)
    )]
    Uncovered {
        /// Where, x [m].
        x: f64,
        /// Where, y [m].
        y: f64,
    },
    /// A point lies outside the surface that carries the basis functions.
    #[error("point {index} at ({}, {}) m lies outside the domain", Short(*.x), Short(*.y))]
    Outside {
        /// Index of the point.
        index: usize,
        /// Its x [m].
        x: f64,
        /// Its y [m].
        y: f64,
    },
    /// The monitor asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl From<mtb_operator::Error> for Error {
    fn from(error: mtb_operator::Error) -> Self {
        match error {
            mtb_operator::Error::Interrupted => Self::Interrupted,
            refused => Self::Operator(refused),
        }
    }
}

impl From<mtb_operator::Interrupted> for Error {
    fn from(_: mtb_operator::Interrupted) -> Self {
        Self::Interrupted
    }
}

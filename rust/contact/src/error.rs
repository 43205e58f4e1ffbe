// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_complementarity::Error as Complementarity;
use mtb_operator::{Error as Operator, Interrupted};
use mtb_words::Short;
use thiserror::Error;

use crate::record::Damaged;

/// Why a contact problem could not be taken or its solution was broken off.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// An array has the wrong length.
    #[error("{name} has {found} entries, expected {expected}")]
    Shape {
        /// Name of the array.
        name: &'static str,
        /// Length that the other arrays ask for.
        expected: usize,
        /// Length found.
        found: usize,
    },
    /// An entry is not a finite number.
    #[error("{name}[{index}] is {}, a finite number is needed", Short(*.value))]
    NotFinite {
        /// Name of the array.
        name: &'static str,
        /// Position of the entry.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// An entry is larger than any that is meant.
    #[error("{name}[{index}] is {}, a number of at most {} is needed", Short(*.value), Short(*.largest))]
    TooLarge {
        /// Name of the array.
        name: &'static str,
        /// Position of the entry.
        index: usize,
        /// Its value.
        value: f64,
        /// Largest size accepted.
        largest: f64,
    },
    /// Derivatives of a step before any was solved.
    #[error(
        "there is no step whose derivatives these could be: the last one has to be solved, and to slide without a shift"
    )]
    NoStep,
    /// A result is not finite.
    #[error("the numbers given are too large: {name} is {}", Short(*.value))]
    Overflow {
        /// Name of the result.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A component of a pose at which small displacements are no approximation any more.
    #[error("{component} of the pose is {}: contacts take small displacements, up to {} here", Short(*.value), Short(*.largest))]
    NotSmall {
        /// Name of the component.
        component: &'static str,
        /// Its value [m] or [rad].
        value: f64,
        /// The largest size that is taken.
        largest: f64,
    },
    /// An entry is negative where it may not be.
    #[error("{name}[{index}] is {}, it must not be negative", Short(*.value))]
    Negative {
        /// Name of the array.
        name: &'static str,
        /// Position of the entry.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A diagonal compliance below zero closes a point faster than its pressure opens it.
    #[error(
        "diagonal[{index}] is {} m/Pa, but the bodies give way there by {} m/Pa to the pressure of the point, so that it would snap shut by itself: a number above {} m/Pa is needed",
        Short(*.diagonal), Short(*.compliance), Short(-.compliance)
    )]
    SnapsShut {
        /// The point.
        index: usize,
        /// The diagonal there [m/Pa].
        diagonal: f64,
        /// Compliance of the bodies to the pressure of the point, at the point [m/Pa].
        compliance: f64,
    },
    /// A step of wear whose error does not fall with its length.
    #[error(
        "no step of wear is short enough: at a sliding distance of {} m its error is still above the tolerance. The law of wear may jump from coefficient to coefficient",
        Short(*.length)
    )]
    WearsTooFast {
        /// The shortest step tried [m].
        length: f64,
    },
    /// A diagonal compliance where none is taken into account.
    #[error(
        "a diagonal compliance is given, but only sliding and its steps take one into account, each its own"
    )]
    NoDiagonal,
    /// A hardness or a rough layer where none is taken into account.
    #[error(
        "a hardness or a rough layer is given, but only sliding and its steps take one into account"
    )]
    NoInterface,
    /// A hardness, a rough layer or a layer that yields in a step with a shift.
    #[error(
        "a hardness, a rough layer or a layer that yields is given, but a step with a shift takes none into account: steps without a shift do"
    )]
    NoInterfaceInShift,
    /// A step with a shift of a contact from a file.
    #[error(
        "the compliance along the tangents is not known: the file was written for sliding alone; write it for steps with a shift (shift=True in Python)"
    )]
    NoTangents,
    /// A step of transient rolling over more than the length of the contact.
    #[error(
        "transient rolling goes {} m in one step, but the contact is {} m long that way: nothing is left of the state before, and one step cannot follow what is between; roll steadily, or by a shorter step (one of a cell ends in steady rolling on the same cells)",
        Short(*.step), Short(*.length)
    )]
    TooFar {
        /// Length of the step [m].
        step: f64,
        /// Length of the contact along it [m].
        length: f64,
    },
    /// Friction that follows the temperature where the temperature is not known.
    #[error(
        "friction follows the temperature, which is known in steady rolling alone: transient steps, shifts and the simplified theories take a law without temperature (Coulomb, FallingFriction or TabulatedFriction in Python)"
    )]
    NoTemperature,
    /// A surface that stands still under the contact, or runs backwards.
    #[error(
        "the creepage is {}: one of the surfaces stands still or runs backwards, and friction that follows the temperature needs both to pass through the contact at about the same speed",
        Short(*.creepage)
    )]
    Locked {
        /// Size of the creepage [-].
        creepage: f64,
    },
    /// What is made of heat was not taken.
    #[error(transparent)]
    Heat(#[from] mtb_heat::Error),
    /// Bodies that creep in a motion whose past is not known.
    #[error(
        "a body creeps: only steady rolling has a past that is known, a shift or a transient step has none"
    )]
    NoHistory,
    /// Bodies that creep where they are not known.
    #[error("a body creeps: contacts without a hardness take such bodies")]
    NoCreep,
    /// A surface that turns under bodies or motions that are not known there.
    #[error(
        "the surface is inclined across the rows of cells: like bodies that move along the rows are needed"
    )]
    InclinedUnlike,
    /// Rows of cells that are alike along x, under what is not known there.
    #[error("the bodies are prisms along x: elastic bodies that move along x are needed")]
    AcrossRows,
    /// A law whose numbers do not rise from zero.
    #[error("{name}[{index}] is {}: the numbers of a law must rise from zero", Short(*.value))]
    NotRising {
        /// Name of the array.
        name: &'static str,
        /// Position of the entry.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A pressure beyond the end of the law of a rough layer.
    #[error(
        "the pressure comes to {} Pa, but the table of the rough layer ends at {} Pa: a table to higher pressures is needed",
        Short(*.pressure), Short(*.largest)
    )]
    BeyondLaw {
        /// The pressure [Pa].
        pressure: f64,
        /// The end of the law [Pa].
        largest: f64,
    },
    /// An entry is not positive where it must be.
    #[error("{name}[{index}] is {}, it must be positive", Short(*.value))]
    NotPositive {
        /// Name of the array.
        name: &'static str,
        /// Position of the entry.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A number is not of the kind needed.
    #[error("{name} is {}, {wanted}", Short(*.value))]
    Number {
        /// Name of the number.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What would be accepted.
        wanted: &'static str,
    },
    /// A layer softens faster than the contact around it is stiff.
    #[error(
        "hardening is {} Pa/m: this contact is stiffer than a softening layer only above {} Pa/m, and below more than one answer may exist; a larger hardening is needed",
        Short(*.hardening), Short(*.least)
    )]
    Softening {
        /// Hardening of the layer [Pa/m].
        hardening: f64,
        /// The hardening above which the answer is the only one [Pa/m].
        least: f64,
    },
    /// A layer that yields with friction that depends on the slip.
    #[error(
        "a layer that yields is solved with fixed coefficients of friction, not with those that follow the slip"
    )]
    YieldWithSlipLaw,
    /// No point carries pressure.
    #[error("the pressure is zero everywhere: there is no contact to roll or to slide")]
    NoContact,
    /// A prescribed tangential force exceeds what friction can carry.
    #[error(
        "a tangential force of {} N is prescribed, friction carries less than {} N",
        Short(*.force), Short(*.largest)
    )]
    ForceTooLarge {
        /// Prescribed force [N].
        force: f64,
        /// Largest force [N].
        largest: f64,
    },
    /// A quantity is asked for at a speed that its table does not cover.
    #[error("velocity is {} m/s: the table of {name} covers {} to {} m/s", Short(*.speed), Short(*.first), Short(*.last))]
    OutsideTable {
        /// Name of the quantity.
        name: &'static str,
        /// Speed asked for [m/s].
        speed: f64,
        /// First speed of the table [m/s].
        first: f64,
        /// Last speed of the table [m/s].
        last: f64,
    },
    /// Friction at rest has no direction.
    #[error(
        "velocity is 0: at rest friction has no direction; prepare with a standstill speed [m/s] below which it falls to zero"
    )]
    Standstill,
    /// The sliding direction is normal to the surface.
    #[error("the sliding velocity is normal to the surface at point {index}")]
    Normal {
        /// The point.
        index: usize,
    },
    /// A force presses a body that is held.
    #[error("a force presses the upper body, but no free motion lets it come down")]
    Held,
    /// A moment turns a body that does not tilt.
    #[error(
        "a moment about {axis} acts on the upper body, but no free motion lets it tilt about {axis}"
    )]
    NotTilting {
        /// The axis.
        axis: &'static str,
    },
    /// An approach of a body that gives way to it.
    #[error(
        "approach is {} m, but a body is free along z and gives way to it: hold the body along z, or give a force [N] or a pull [Pa] and no approach",
        Short(*.approach)
    )]
    GivesWay {
        /// The approach [m].
        approach: f64,
    },
    /// A contact that the edge of its grid cuts off.
    #[error(
        "the contact reaches the edge of the grid of {nx} x {ny} points at x = {} m, y = {} m, but the bodies go on beyond it: about {} x {} points at this spacing would do, or a smaller load",
        Short(.place[0]), Short(.place[1]), 2 * .nx, 2 * .ny
    )]
    Edge {
        /// Points of the grid in a row.
        nx: usize,
        /// Rows of the grid.
        ny: usize,
        /// Where the contact reaches its edge, x and y [m].
        place: [f64; 2],
    },
    /// A uniform magnetic pressure is given where none acts.
    #[error("magnetic_pressure is given, but the scene was prepared without one")]
    NotMagnetic,
    /// Ampere-turns are given where no magnet follows the gap.
    #[error(
        "the scene was prepared without a magnet whose pull follows the gap, which alone has ampere_turns"
    )]
    NoMagnet,
    /// A magnet in a step of a contact from a file that was written without one.
    #[error(
        "a magnet whose pull follows the gap is given, but the file of this contact was written without one: it does not hold how a pull at each point moves the bodies"
    )]
    NoPull,
    /// Bytes that hold no prepared contact.
    #[error("not a prepared contact: {0}")]
    Stored(&'static str),
    /// The linear problem of a derivative has no one solution.
    #[error(
        "the derivative was not found: the points in contact hardly determine the pressure, the tractions or the motions here"
    )]
    Singular,
    /// The complementarity solver refused the problem.
    #[error(transparent)]
    Complementarity(Complementarity),
    /// An operator could not be built.
    #[error(transparent)]
    Operator(Operator),
    /// The monitor asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl From<Interrupted> for Error {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}

impl From<Operator> for Error {
    fn from(error: Operator) -> Self {
        match error {
            Operator::Interrupted => Self::Interrupted,
            refused => Self::Operator(refused),
        }
    }
}

impl From<Complementarity> for Error {
    fn from(error: Complementarity) -> Self {
        match error {
            Complementarity::Interrupted => Self::Interrupted,
            Complementarity::Operator(refused) => Self::Operator(refused),
            refused => Self::Complementarity(refused),
        }
    }
}

impl From<Damaged> for Error {
    fn from(damaged: Damaged) -> Self {
        Self::Stored(damaged.0)
    }
}

pub(crate) fn check_positive(name: &'static str, value: f64) -> Result<(), Error> {
    check_number(name, value, value > 0.0, "a positive number is needed")
}

pub(crate) fn check_number(
    name: &'static str,
    value: f64,
    is_accepted: bool,
    wanted: &'static str,
) -> Result<(), Error> {
    if value.is_finite() && is_accepted {
        Ok(())
    } else {
        Err(Error::Number {
            name,
            value,
            wanted,
        })
    }
}

pub(crate) fn check(name: &'static str, values: &[f64], expected: usize) -> Result<(), Error> {
    if values.len() != expected {
        return Err(Error::Shape {
            name,
            expected,
            found: values.len(),
        });
    }
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(Error::NotFinite {
            name,
            index,
            value: values[index],
        }),
        None => Ok(()),
    }
}

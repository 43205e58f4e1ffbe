// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_words::{Rough, Short};
use thiserror::Error;

use crate::Side;

/// Why a wheelset could not be prepared or a step was not solved.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// A number is not of the kind needed.
    #[error("{name} is {}: {wanted}", Short(*.value))]
    Number {
        /// Name of the number.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What would be accepted.
        wanted: &'static str,
    },
    /// An entry of a pose or velocity is not finite, or too large for any.
    #[error("{name}[{index}] is {}: a finite number of at most 1e+30 is needed", Short(*.value))]
    Entry {
        /// Name of the array.
        name: &'static str,
        /// Position of the entry.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// Components of the pose are left open that no balance finds.
    #[error(
        "pose is {pose:?}: z alone, or z and roll of both wheels, can be found from balance, and y with them from a \
         lateral force{}",
        if *.has_lateral_force { "; with one y and z must be NaN" } else { ", which is missing" }
    )]
    Open {
        /// The pose given.
        pose: [f64; 6],
        /// Whether there is a lateral force.
        has_lateral_force: bool,
    },
    /// The wheelset is too far away.
    #[error("pose, {name}, is {} m: at most {} m is needed", Short(*.value), Short(*.most))]
    Far {
        /// Name of the component.
        name: &'static str,
        /// Its value [m].
        value: f64,
        /// Largest size accepted [m].
        most: f64,
    },
    /// The wheelset is turned off its rails.
    #[error(
        "{name} is {} rad: at most {} rad is needed, or the wheelset does not roll along the rails",
        Short(*.value), Short(*.most)
    )]
    Turned {
        /// Name of the component.
        name: &'static str,
        /// Its value [rad].
        value: f64,
        /// Largest size accepted [rad].
        most: f64,
    },
    /// Friction has no direction.
    #[error(
        "the {side} wheel does not roll (velocity {velocity:?}): at rest friction has no direction; a standstill_speed [m/s] is needed"
    )]
    AtRest {
        /// The wheel.
        side: Side,
        /// Velocity of the wheelset [m/s], [rad/s].
        velocity: [f64; 6],
    },
    /// Friction that varies over the patch.
    #[error(
        "friction has {count} coefficients: patches move, so one is needed, or a map of friction over the rail"
    )]
    Varying {
        /// Number of coefficients.
        count: usize,
    },
    /// Patches that follow the rail, between bodies of different elasticity.
    #[error(
        "conformal patches are known between like bodies alone: pressure moves wheel and rail of different elasticity \
         along each other, which turned half-spaces do not tell; give both the same material, or leave conformal out"
    )]
    ConformalUnlike,
    /// A state of wheels whose patches lie on planes, for patches that follow the rail, or the reverse.
    #[error(
        "state: its {side} wheel has patches {}, and those of these wheels {}; the state of a step of the same wheelset \
         is needed",
        if *.conformal { "on planes" } else { "that follow the rail" },
        if *.conformal { "follow the rail" } else { "lie on planes" }
    )]
    OtherGround {
        /// The wheel.
        side: Side,
        /// Whether the patches of the wheelset follow the rail.
        conformal: bool,
    },
    /// A derivative by a modulus of one body, where patches follow the rail.
    #[error(
        "derivatives by the moduli of conformal patches are not known: they are known between like bodies, and a modulus \
         of one of them makes these unlike"
    )]
    ConformalModuli,
    /// Places of a friction map that are none.
    #[error(
        "{name} of a friction map: at least one place is needed, and places [m] that rise strictly"
    )]
    FrictionPlaces {
        /// Which places.
        name: &'static str,
    },
    /// A friction map of another size than its places.
    #[error(
        "a friction map has {count} coefficients: one for each of {} places along the track and {} across \
         the rail is needed",
        .wanted[0],
        .wanted[1]
    )]
    FrictionSize {
        /// Number of coefficients.
        count: usize,
        /// Places along the track and across the rail.
        wanted: [usize; 2],
    },
    /// A state that is none.
    #[error("state, {part}: {reason}")]
    State {
        /// Which part of it.
        part: &'static str,
        /// What is wrong.
        reason: &'static str,
    },
    /// A state without what a transient step rolls on from.
    #[error(
        "state has no pressures of the {side} wheel: a transient step rolls on from the tractions of the last step; \
         the state of a step of this version is needed"
    )]
    NoHistory {
        /// The wheel.
        side: Side,
    },
    /// Derivatives by the state of another step.
    #[error(
        "the step did not roll on from the state of the one before: all steps of a chain are needed, in their order"
    )]
    OtherState,
    /// A change of another step.
    #[error(
        "changes[{index}] has patches of {points:?} points: {wanted:?} are needed, those of the step before"
    )]
    OtherChange {
        /// Which change.
        index: usize,
        /// Points of its patches.
        points: Vec<usize>,
        /// Points of the patches of the step before.
        wanted: Vec<usize>,
    },
    /// A curve of the track, on rollers.
    #[error(
        "curvature is {} / m: wheels on rollers stay where they are, and a curve has no sense there; curvature = 0, or no \
         roller_radius, is needed",
        Short(*.curvature)
    )]
    CurvedRoller {
        /// The curvature [1/m].
        curvature: f64,
    },
    /// Friction that varies along the track, on rollers.
    #[error(
        "friction varies along the track: on a roller x is no way along a track, so a map with one x, which varies across \
         the rail only, is needed"
    )]
    FrictionAlongRoller,
    /// A right wheel that sits on no axle with the left one.
    #[error(
        "the right wheel does not sit on the axle of the left one: flange_back, tape_circle and roller_radius are the same \
         for both"
    )]
    TwoAxles,
    /// A normal contact was not solved.
    #[error("the normal contact of the {side} wheel: {status}, residual {}", Rough(*.residual))]
    Normal {
        /// The wheel.
        side: Side,
        /// How the solver ended.
        status: &'static str,
        /// Relative residual.
        residual: f64,
    },
    /// A tangential contact was not solved.
    #[error("stick and slip under the {side} wheel: residual {}", Rough(*.residual))]
    Tangential {
        /// The wheel.
        side: Side,
        /// Relative residual.
        residual: f64,
    },
    /// The edge of its grid cuts a contact off.
    #[error(
        "the contact of the {side} wheel goes on beyond the edge of its grid of {} mm x {} mm on the contact plane, \
         which is inclined by {} degrees: no plane holds all of it; a smaller force, another position of the \
         wheelset, or conformal patches, which follow the rail, are needed",
        Short(.size[0]), Short(.size[1]), Short(*.angle)
    )]
    CutOff {
        /// The wheel.
        side: Side,
        /// Size of the grid along the rail and across, in millimetres.
        size: [f64; 2],
        /// Slope angle of its plane, in degrees.
        angle: f64,
    },
    /// No height carries the force.
    #[error(
        "no height{} of the wheelset found at which {} {} N: the last carries {}{}{}{}",
        if *.is_each { " and roll" } else { "" },
        if *.is_each { "each wheel carries" } else { "its wheels carry" },
        Short(*.wanted),
        carried(.reached),
        if .reached.iter().any(|force| *force < 0.0) { LIFTS } else { "" },
        .jump.map(jumped).unwrap_or_default(),
        .end.as_ref().map(|end| format!("; further on, {end}")).unwrap_or_default()
    )]
    Balance {
        /// Whether each wheel is to carry the force by itself.
        is_each: bool,
        /// Force wanted [N].
        wanted: f64,
        /// Forces of the last trial [N].
        reached: Vec<f64>,
        /// Forces [N] on the two sides of the height where the force jumps over the wanted one, if it does.
        jump: Option<[f64; 2]>,
        /// What ended the last trial that could not be made, if one could not.
        end: Option<String>,
    },
    /// No pose, rotation and displacement of the rails give the forces.
    #[error("no equilibrium found: {}{}", asked(.wanted, .reached), .why)]
    Equilibrium {
        /// Names and units of the forces, and those wanted.
        wanted: Vec<(&'static str, f64)>,
        /// Those of the last trial; empty if there was none.
        reached: Vec<f64>,
        /// What stands in the way.
        why: String,
    },
    /// A position was found where a force jumps.
    #[error(
        "the position was found where a force jumps, as the contact plane turns there: a force departs from the one asked \
         for by {error:.1e} of the vertical force. At a jump the step has no derivatives; give z, or y in place of a \
         lateral force"
    )]
    AtJump {
        /// The departure, over the vertical force.
        error: f64,
    },
    /// A result is not finite.
    #[error("the numbers given are too large: {name} is {}", Short(*.value))]
    Overflow {
        /// Name of the result.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// Bytes that hold no prepared wheels.
    #[error("no prepared wheels: {0}")]
    Stored(&'static str),
    /// Where wheel and rail touch could not be found.
    #[error(transparent)]
    Geometry(#[from] mtb_geometry::Error),
    /// A body that makes no sense.
    #[error(transparent)]
    Elasticity(mtb_elasticity::Error),
    /// A grid that makes no sense.
    #[error(transparent)]
    Grid(mtb_operator::Error),
    /// A contact problem was refused or broken off.
    #[error(transparent)]
    Contact(mtb_contact::Error),
    /// The monitor asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// Whether all was well with what was given, but no solution was found.
    pub fn is_not_converged(&self) -> bool {
        matches!(
            self,
            Self::Normal { .. }
                | Self::Tangential { .. }
                | Self::Balance { .. }
                | Self::Equilibrium { .. }
                | Self::CutOff { .. }
        )
    }
}

impl From<mtb_contact::Error> for Error {
    fn from(error: mtb_contact::Error) -> Self {
        match error {
            mtb_contact::Error::Interrupted => Self::Interrupted,
            refused => Self::Contact(refused),
        }
    }
}

impl From<mtb_operator::Interrupted> for Error {
    fn from(_: mtb_operator::Interrupted) -> Self {
        Self::Interrupted
    }
}

impl From<mtb_operator::Error> for Error {
    fn from(error: mtb_operator::Error) -> Self {
        match error {
            mtb_operator::Error::Interrupted => Self::Interrupted,
            refused => Self::Grid(refused),
        }
    }
}

impl From<mtb_elasticity::Error> for Error {
    fn from(error: mtb_elasticity::Error) -> Self {
        match error {
            mtb_elasticity::Error::Interrupted => Self::Interrupted,
            refused => Self::Elasticity(refused),
        }
    }
}

impl From<mtb_contact::record::Damaged> for Error {
    fn from(damaged: mtb_contact::record::Damaged) -> Self {
        Self::Stored(damaged.0)
    }
}

/// Why a wheel carries less the lower it is.
const LIFTS: &str = "; friction lifts the rail there by more than the pressure presses it down, because the \
                     contact plane is steeper than the angle of friction: the wheel climbs or is dragged down, \
                     and no height holds it; give z, or another pose";

fn jumped([low, high]: [f64; 2]) -> String {
    format!(
        "; at one height the force jumps from {} N to {} N, because the contact plane turns where the contact \
         moves between tread and flange: shift the wheelset by some micrometres, ask for a force outside the \
         jump, or give z",
        Short(low),
        Short(high)
    )
}

fn asked(wanted: &[(&'static str, f64)], reached: &[f64]) -> String {
    let each: Vec<String> = (wanted.iter().enumerate())
        .map(|(k, (name, value))| {
            let last = reached
                .get(k)
                .map(|r| format!(", the last trial gives {}", Short(*r)));
            format!(
                "{name} of {} is asked for{}",
                Short(*value),
                last.unwrap_or_default()
            )
        })
        .collect();
    each.join("; ")
}

fn carried(forces: &[f64]) -> String {
    let each: Vec<String> = forces.iter().map(|f| format!("{} N", Short(*f))).collect();
    each.join(", ")
}

pub(crate) fn positive(name: &'static str, value: f64) -> Result<(), Error> {
    if value > 0.0 && value <= LARGEST {
        return Ok(());
    }
    Err(Error::Number {
        name,
        value,
        wanted: "a positive number of at most 1e+30 is needed",
    })
}

/// Largest number a step takes, in SI units; beyond it squares overflow.
const LARGEST: f64 = 1e30;

/// Checks that entries are finite and not too large.
pub(crate) fn check_entries(name: &'static str, values: &[f64]) -> Result<(), Error> {
    match values.iter().position(|v| v.is_nan() || v.abs() > LARGEST) {
        Some(index) => Err(Error::Entry {
            name,
            index,
            value: values[index],
        }),
        None => Ok(()),
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use std::fmt::{Display, Formatter};
use std::iter;

use mtb_contact::friction::Friction;
use mtb_elasticity::Material;
use mtb_elasticity::half_space::Pair;
use mtb_geometry::{WheelOnRail, WheelRailLoad};

use crate::error::{Error, check_entries, positive};
use crate::friction::WheelFriction;
use crate::track::RailSprings;

/// A wheel of the wheelset, seen in the direction of travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// At y > 0.
    Left,
    /// At y < 0.
    Right,
}

impl Side {
    /// What belongs to it, where the right one may have something of its own.
    pub(crate) fn of<'a, T>(self, both: &'a T, right: Option<&'a T>) -> &'a T {
        match self {
            Self::Left => both,
            Self::Right => right.unwrap_or(both),
        }
    }
}

impl Display for Side {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Left => "left",
            Self::Right => "right",
        })
    }
}

/// Which wheels of a wheelset are in contact problems.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// The left one.
    Left,
    /// The right one.
    Right,
    /// Both.
    Both,
}

impl Sides {
    /// The wheels, left first.
    pub fn each(self) -> &'static [Side] {
        match self {
            Self::Left => &[Side::Left],
            Self::Right => &[Side::Right],
            Self::Both => &[Side::Left, Side::Right],
        }
    }
}

/// One or both wheels of a wheelset on their rails, before any step.
#[derive(Clone, Debug, PartialEq)]
pub struct Wheelset {
    /// Profiles and track of the left wheel; the wheelset stands shifted by its `lateral` to the left.
    pub pair: WheelOnRail,
    /// The same of the right wheel, seen in a mirror, where they differ. The axle is one: the wheels sit at the same
    /// distance from its middle, on rails both or on rollers of one radius. Its `lateral` has no meaning.
    pub right: Option<WheelOnRail>,
    /// Which wheels.
    pub sides: Sides,
    /// Vertical force of each wheel [N], where the height is found from it.
    pub force: f64,
    /// Vertical overlap of the undeformed bodies that may carry the force [m]: where a search begins.
    pub approach: f64,
    /// Distance of the points along the rail and across [m].
    pub spacing: [f64; 2],
    /// Rail (lower) and wheel (upper).
    pub bodies: Pair,
    /// One law, or a coefficient that varies over the rail.
    pub friction: WheelFriction,
    /// The same of the right wheel on its rail, where it differs.
    pub right_friction: Option<WheelFriction>,
    /// Thickness over shear modulus of a layer between wheel and rail [m/Pa].
    pub layer: f64,
    /// The point of the wheelset that poses, velocities and moments are about, at the zero pose [m].
    pub reference_point: [f64; 3],
    /// Speed below which creepages fall to zero with the speed [m/s]; `None`: at rest there is no answer.
    pub standstill_speed: Option<f64>,
    /// Springs under the rails; `None`: they do not move.
    pub springs: Option<RailSprings>,
    /// Whether patches follow the surface of the rail, row by row, in place of a plane: for contacts that no plane holds,
    /// such as the root of a flange on a worn gauge corner. Like bodies on straight rails without slices.
    pub conformal: bool,
    /// Whether slip is of second order in the cells, [`mtb_contact::tangential::PatchOperators::of_second_order`]; otherwise
    /// it is of first order, as in CONTACT.
    pub second_order: bool,
}

impl Wheelset {
    /// A length [m] of the size that it has on wheels of 0.46 m: searches on a rig whose lengths are a fifth take the same
    /// steps.
    pub(crate) fn sized(&self, length: f64) -> f64 {
        length * self.pair.wheel_radius / 0.46
    }

    /// The left wheel under a vertical `force` [N], points 0.5 mm apart, a coefficient of friction of 0.3, the
    /// middle of the axle as reference point.
    ///
    /// # Errors
    /// A force or a pair that makes no sense, two rigid bodies.
    pub fn new(pair: WheelOnRail, bodies: Pair, force: f64) -> Result<Self, Error> {
        let elastic: Vec<Material> = bodies.lower.into_iter().chain(bodies.upper).collect();
        let joined = Material::joined(&elastic)?;
        let load = WheelRailLoad::Force {
            vertical: force,
            // of a material with Poisson's ratio zero
            contact_modulus: joined.young_modulus(),
        };
        let contact = pair.contact(load)?;
        Ok(Self {
            sides: Sides::Left,
            force,
            approach: contact.approach / contact.angle.cos(),
            spacing: [5e-4; 2],
            bodies,
            friction: Friction::Coulomb(vec![0.3]).into(),
            right_friction: None,
            layer: 0.0,
            reference_point: [
                0.0,
                pair.lateral,
                pair.wheel_radius + contact.undeformed_height,
            ],
            standstill_speed: None,
            springs: None,
            conformal: false,
            second_order: false,
            right: None,
            pair,
        })
    }

    /// Profiles and track of a wheel, of the right one in a mirror.
    pub fn pair_of(&self, side: Side) -> &WheelOnRail {
        side.of(&self.pair, self.right.as_ref())
    }

    /// Friction of a wheel on its rail.
    pub fn friction_of(&self, side: Side) -> &WheelFriction {
        side.of(&self.friction, self.right_friction.as_ref())
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        positive("force", self.force)?;
        positive("approach", self.approach)?;
        positive("spacing along the rail", self.spacing[0])?;
        positive("spacing across", self.spacing[1])?;
        if !(self.layer >= 0.0 && self.layer.is_finite()) {
            return Err(Error::Number {
                name: "layer",
                value: self.layer,
                wanted: "thickness over shear modulus must not be negative",
            });
        }
        check_entries("reference_point", &self.reference_point)?;
        if let Some(speed) = self.standstill_speed {
            positive("standstill_speed", speed)?;
        }
        if let Some(springs) = &self.springs {
            springs.check()?;
        }
        if self.conformal && self.bodies.is_coupled() {
            return Err(Error::ConformalUnlike);
        }
        for friction in iter::once(&self.friction).chain(&self.right_friction) {
            if let (Some(_), WheelFriction::OnRail(map)) = (self.pair.roller_radius, friction)
                && map.parts()[0].len() > 1
            {
                return Err(Error::FrictionAlongRoller);
            }
            friction.check()?;
        }
        for material in self.bodies.lower.iter().chain(&self.bodies.upper) {
            Material::new(material.shear_modulus, material.poisson_ratio)?;
        }
        if let Some(right) = &self.right {
            let one = |pair: &WheelOnRail| (pair.flange_back, pair.tape_circle, pair.roller_radius);
            if one(right) != one(&self.pair) {
                return Err(Error::TwoAxles);
            }
        }
        Ok(())
    }
}

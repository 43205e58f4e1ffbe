// SPDX-License-Identifier: MIT OR Apache-2.0
//! A wheel on a rail: where they touch, the contact plane, and the gap over it.

mod change;
mod gap;
mod middle;
mod over;
mod plane;
mod roller;
mod section;
mod touch;
mod uneven;

use std::f64::consts::PI;
use std::sync::Arc;

use mtb_words::Short;

use crate::error::{finite, out_of_range, positive};
use crate::{Error, Profile, Slices};
use roller::Roller;
use section::Section;

pub use change::PlaneChange;
pub use gap::GapField;
pub use over::{WheelOverRail, WheelPose};
pub use plane::{PlaneGap, Rows};
pub use touch::{Axle, StandingWheelset, Touch};

/// Largest load estimate that is looked for [m].
const MOST_APPROACH: f64 = 5e-3;
/// Widest profile whose contact is looked for [m].
const WIDEST: f64 = 10.0;
/// Largest width over the radius of the wheel; places on a profile are looked at a distance apart that goes as the radius.
const WIDEST_OF_RADIUS: f64 = 20.0;
/// Largest height of a wheel profile at the tape circle over the radius of the wheel.
const OFF_TAPE: f64 = 0.5;

/// A wheel of revolution on a straight rail or on a roller, without yaw or roll.
///
/// Track frame: x along the rail, y from the middle of the track to the left, z up from the highest
/// point of the rail. It is the left wheel: the field side is at larger y, the flange at smaller y.
///
/// The rail is turned by `rail_inclination` towards the middle of the track, then moved until its
/// gauge face, the innermost point not deeper than `gauge_depth` below the top, stands at
/// `gauge / 2`. The tape circle of the wheel stands at `flange_back / 2 + tape_circle + lateral`.
///
/// A roller is the rail so placed, turned about an axis that lies across the track, `roller_radius` below the top of
/// the rail; x = 0 is above the axis.
///
/// # Example
/// ```
/// use mtb_geometry::{Profile, WheelOnRail, WheelRailLoad};
/// let pair = WheelOnRail {
///     lateral: 6.2e-3,
///     ..WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1())
/// };
/// let load = WheelRailLoad::Force { vertical: 36e3, contact_modulus: 114e9 };
/// let contact = pair.contact(load).unwrap();
/// assert!((contact.angle.to_degrees() - 23.4).abs() < 0.3);
/// let field = pair.gap(&contact, [2e-4, 2e-4], 1.0, &mtb_geometry::unwatched).unwrap();
/// assert_eq!(field.gap.len(), field.nx * field.ny);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct WheelOnRail {
    /// Profile of the wheel, tape circle at y = 0, field side at y > 0.
    pub wheel: Profile,
    /// Profile of the rail; the gauge side is at y < 0.
    pub rail: Profile,
    /// Radius at z = 0 of the wheel profile [m], which is that of the tape circle of a new wheel.
    pub wheel_radius: f64,
    /// Of a roller in place of the rail: its radius at the top of the rail [m], about an axis across the track.
    pub roller_radius: Option<f64>,
    /// Track gauge [m].
    pub gauge: f64,
    /// Depth below the top of the rail down to which the gauge is measured [m].
    pub gauge_depth: f64,
    /// Rotation of the rail towards the middle of the track [rad]; 0 for a profile that has it in.
    pub rail_inclination: f64,
    /// Distance between the backs of the two flanges [m].
    pub flange_back: f64,
    /// Distance of the tape circle from the back of the flange [m].
    pub tape_circle: f64,
    /// Shift of the wheelset towards flange contact [m].
    pub lateral: f64,
    /// How the wheel departs from its profile around it, by the angle [rad] of [`WheelPose::turn`].
    pub wheel_slices: Option<Arc<Slices>>,
    /// How the rail departs from its profile along the track [m].
    pub rail_slices: Option<Arc<Slices>>,
}

/// What presses the wheel on the rail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WheelRailLoad {
    /// Approach along the normal of the contact plane [m].
    Approach(f64),
    /// Vertical force [N]; the approach is estimated from it.
    Force {
        /// Vertical force [N].
        vertical: f64,
        /// `1 / (1/E1' + 1/E2')` of the plane-strain moduli `E / (1 - nu^2)` [Pa].
        contact_modulus: f64,
    },
}

/// Where wheel and rail touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelRailContact {
    /// Slope angle of the contact plane against the horizontal [rad], > 0 where the plane rises to
    /// the field side (flange contact).
    pub angle: f64,
    /// Origin of the contact plane on the rail, (y, z) in the track frame [m].
    pub origin: [f64; 2],
    /// The same in the rail profile's own frame: its y [m].
    pub rail_position: f64,
    /// y of the wheel profile facing the origin [m].
    pub wheel_position: f64,
    /// First contact of the undeformed bodies: y of the rail profile [m].
    pub first_rail_position: f64,
    /// Height of the tape circle over the top of the rail at first contact [m].
    pub undeformed_height: f64,
    /// Estimated or given approach along the normal [m].
    pub approach: f64,
    /// Share of the estimated contact area inclined by more than 20 degrees to the plane, which one
    /// plane does not represent [-].
    pub neglected: f64,
    /// Region where the undeformed bodies overlap at that approach: half-length along x [m].
    pub half_length: f64,
    /// The same across: from, to in the contact plane [m].
    pub across: [f64; 2],
}

impl WheelOnRail {
    /// Standard track and wheelset: radius 460 mm, gauge 1435 mm at 14 mm depth, inclination 1/40,
    /// flange backs 1360 mm apart, tape circle 70 mm from them, centred.
    pub fn new(wheel: Profile, rail: Profile) -> Self {
        Self {
            wheel,
            rail,
            wheel_radius: 0.46,
            roller_radius: None,
            gauge: 1.435,
            gauge_depth: 14e-3,
            rail_inclination: 1.0 / 40.0,
            flange_back: 1.360,
            tape_circle: 70e-3,
            lateral: 0.0,
            wheel_slices: None,
            rail_slices: None,
        }
    }

    /// Whether a body varies along the track or around the wheel.
    pub fn has_slices(&self) -> bool {
        self.wheel_slices.is_some() || self.rail_slices.is_some()
    }

    /// First contact, contact plane and estimated size of the contact.
    ///
    /// The contact area is estimated as the overlap of the undeformed bodies at half the approach
    /// (exact for a circular Hertz contact). The plane goes through the middle of the overlap at the
    /// whole approach, weighted by the square of the overlap, with the rail's slope averaged alike. For a given force the approach follows from
    /// `F = 4/3 E* sqrt(A / pi) approach`, again Hertz for a circle [Johnson1985, 4.2].
    ///
    /// Slices are left out: it is the contact of the nominal profiles.
    ///
    /// # Errors
    /// Values that make no sense, profiles that never face each other or are too short.
    pub fn contact(&self, load: WheelRailLoad) -> Result<WheelRailContact, Error> {
        self.check()?;
        load.check()?;
        let section = Section::new(self)?;
        let approach = match load {
            WheelRailLoad::Approach(approach) => approach,
            WheelRailLoad::Force {
                vertical,
                contact_modulus,
            } => {
                let excess = |approach: f64| {
                    let area = section.area(approach);
                    let normal = 4.0 / 3.0 * contact_modulus * (area.size / PI).sqrt() * approach;
                    normal * area.angle.cos() - vertical
                };
                if excess(MOST_APPROACH) < 0.0 {
                    let accepted = format!(
                        "it would press the bodies more than {} mm together",
                        Short(1e3 * MOST_APPROACH)
                    );
                    return Err(out_of_range("force", vertical, accepted));
                }
                // in the logarithm, since forces span many decades
                let (mut low, mut high) = (1e-15_f64.ln(), MOST_APPROACH.ln());
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if excess(middle.exp()) > 0.0 {
                        high = middle;
                    } else {
                        low = middle;
                    }
                }
                (0.5 * (low + high)).exp()
            }
        };
        section.contact(approach)
    }

    fn roller(&self) -> Option<Roller> {
        self.roller_radius.map(|radius| Roller { radius })
    }

    /// Radius of a wheel on a straight rail that leaves the same distance along it [m].
    fn joined_radius(&self) -> f64 {
        joined_radius(self.wheel_radius, self.roller())
    }

    /// Height of the wheel profile at the tape circle [m]: what a wheel has worn off there.
    fn worn(&self) -> f64 {
        over::height_and_slope(&self.wheel, 0.0)[0]
    }

    /// Radius of the tape circle [m]: `wheel_radius` less what is worn off there; of wheels with slices that of their
    /// nominal profile.
    pub fn tape_radius(&self) -> f64 {
        self.wheel_radius - self.worn()
    }

    fn check(&self) -> Result<(), Error> {
        positive("wheel_radius", self.wheel_radius)?;
        if let Some(radius) = self.roller_radius {
            positive("roller_radius", radius)?;
            if self.rail_slices.is_some() {
                return Err(Error::UnevenRoller);
            }
        }
        positive("gauge", self.gauge)?;
        positive("gauge_depth", self.gauge_depth)?;
        positive("flange_back", self.flange_back)?;
        finite("tape_circle", self.tape_circle)?;
        finite("lateral", self.lateral)?;
        if finite("rail_inclination", self.rail_inclination)?.abs() > 0.5 {
            let accepted = "an inclination such as 1/40 is accepted, at most 0.5";
            return Err(out_of_range(
                "rail_inclination",
                self.rail_inclination,
                accepted,
            ));
        }
        for (name, profile) in [("wheel profile", &self.wheel), ("rail profile", &self.rail)] {
            let [start, end] = profile.range();
            if end - start > WIDEST {
                let accepted = format!("its width in m, at most {} m is accepted", Short(WIDEST));
                return Err(out_of_range(name, end - start, accepted));
            }
            if end - start > WIDEST_OF_RADIUS * self.wheel_radius {
                let least = Short((end - start) / WIDEST_OF_RADIUS);
                let accepted = format!("at least {least} m is accepted beside this {name}");
                return Err(out_of_range("wheel_radius", self.wheel_radius, accepted));
            }
        }
        let worn = self.worn();
        if worn.abs() > OFF_TAPE * self.wheel_radius {
            let accepted = "0 is that of a new one, and less than half of wheel_radius is accepted";
            return Err(out_of_range(
                "z of the wheel profile at y = 0",
                worn,
                accepted,
            ));
        }
        Ok(())
    }
}

/// Radius of a wheel on a straight rail that leaves the same distance along it as one on a roller [m].
fn joined_radius(wheel: f64, roller: Option<Roller>) -> f64 {
    roller.map_or(wheel, |roller| {
        wheel * roller.radius / (wheel + roller.radius)
    })
}

impl WheelRailLoad {
    fn check(self) -> Result<(), Error> {
        match self {
            Self::Approach(approach) => {
                if positive("approach", approach)? > MOST_APPROACH {
                    let accepted = format!("at most {} m is accepted", Short(MOST_APPROACH));
                    return Err(out_of_range("approach", approach, accepted));
                }
            }
            Self::Force {
                vertical,
                contact_modulus,
            } => {
                positive("force", vertical)?;
                positive("contact_modulus", contact_modulus)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;

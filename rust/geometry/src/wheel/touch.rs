// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where rigid wheels touch their rails.

use nalgebra::Vector3;

use super::WheelOnRail;
use super::over::{Station, WheelOverRail, WheelPose, height_and_slope};
use crate::error::finite;
use crate::{Error, Look, root};

/// Steps towards the roll of a wheelset, largest roll looked for [rad], and the difference [m] at which both
/// wheels count as touching.
const MOST_STEPS: usize = 100;
const MOST_ROLL: f64 = 0.05;
const CLOSE: f64 = 1e-12;
/// Steps of Newton's method to the rail below a place.
const STEPS_TO_RAIL: usize = 8;

/// Where a wheel of any pose is nearest to its rail, seen as the left one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Vertical distance of the undeformed bodies there [m], negative where they overlap.
    pub clearance: f64,
    /// The place on the rail, (y, z) in the track [m].
    pub position: [f64; 2],
    /// The same in the rail profile's own frame: its y [m].
    pub rail_position: f64,
    /// y of the wheel profile there [m].
    pub wheel_position: f64,
    /// Slope angle of the rail there [rad], > 0 where it rises to the field side.
    pub angle: f64,
    /// Radius of the wheel there [m].
    pub rolling_radius: f64,
}

/// How the axle of a wheelset stands that touches both rails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axle {
    /// Level: each wheel touches its rail as if it were alone, as the reference results of [EN15302] have it.
    Level,
    /// Rolled until both wheels touch.
    Free,
}

/// A wheelset that touches both rails, rigid and without yaw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandingWheelset {
    /// Height of the middle of the axle over the top of the rails [m]; of a level axle the mean of what the two
    /// wheels take.
    pub height: f64,
    /// Rotation about the track [rad], > 0 where the left wheel stands higher.
    pub roll: f64,
    /// The left wheel.
    pub left: Touch,
    /// The right wheel, seen in a mirror as a left one.
    pub right: Touch,
}

impl WheelOverRail {
    /// The place where the wheel is nearest to the rail; pose as for [`WheelOverRail::overlap`].
    ///
    /// The lowest of the stations of [`WheelOverRail::overlap`] and what lies between it and its neighbours.
    ///
    /// # Errors
    /// A wheel that is nowhere over the rail, a place at the end of a profile, a pose that is not finite, slices.
    pub fn touch(&self, centre: [f64; 3], axle: [f64; 3]) -> Result<Touch, Error> {
        if self.wheel_slices.is_some() || self.rail_slices.is_some() {
            return Err(Error::Sliced {
                what: "the place where rigid bodies touch is",
            });
        }
        let outline = self.outline(&WheelPose::new(centre, axle))?;
        let (centre, axle) = (Vector3::from(centre), Vector3::from(axle));
        let lowest = outline
            .clearance
            .iter()
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(b.1))
            .map_or(0, |(k, _)| k);
        let last = self.stations.len() - 1;
        let bracket =
            [lowest.saturating_sub(1), (lowest + 1).min(last)].map(|k| self.stations[k].position);
        let at = |position: f64| {
            let station = Station::of(&self.wheel, self.radius, position);
            let point = self.nearest_of(&station, centre, axle);
            (station, point, self.rail_at(point.y))
        };
        let clearance = |position: f64| {
            let (_, point, [up, ..]) = at(position);
            point.z - up
        };
        // a kink is met at its station, everything else between the stations
        let between = root::minimum(clearance, bracket);
        let own = self.stations[lowest].position;
        let position = if clearance(own) <= clearance(between) {
            own
        } else {
            between
        };
        let (station, point, [up, slope, rail_position]) = at(position);
        self.refuse_end(position, rail_position)?;
        Ok(Touch {
            clearance: point.z - up,
            position: [point.y, up],
            rail_position,
            wheel_position: position,
            angle: slope.atan(),
            rolling_radius: station.radius,
        })
    }

    /// Height and slope of the rail at a place across the track, and y of its profile.
    fn rail_at(&self, y: f64) -> [f64; 3] {
        let (sin, cos) = (self.placement.sin, self.placement.cos);
        let (_, mut position) = self.on_head(y);
        let mut slope = 0.0;
        let mut up = 0.0;
        for _ in 0..STEPS_TO_RAIL {
            let [height, rise] = height_and_slope(&self.rail, position);
            let [across, z] = self.placement.place(position, height);
            (up, slope) = (z, (sin + cos * rise) / (cos - sin * rise));
            let step = (y - across) / (cos - sin * rise);
            let [low, high] = self.rail.range();
            if step.abs() < 1e-15 || !(low..=high).contains(&(position + step)) {
                break;
            }
            position += step;
        }
        [up, slope, position]
    }

    fn refuse_end(&self, wheel_position: f64, rail_position: f64) -> Result<(), Error> {
        let head = [
            self.head[0].position,
            self.head[self.head.len() - 1].position,
        ];
        for (profile, at, ends) in [
            ("rail", rail_position, head),
            ("wheel", wheel_position, self.wheel.range()),
        ] {
            for end in ends {
                if (at - end).abs() < self.sampling {
                    return Err(Error::TouchesEnd { profile, end });
                }
            }
        }
        Ok(())
    }
}

impl StandingWheelset {
    /// The wheelset shifted by `lateral` [m] to the left, standing on both rails by its own weight alone.
    ///
    /// # Errors
    /// Those of [`WheelOverRail::touch`], a roll beyond 0.05 rad.
    pub fn new(
        left: &WheelOverRail,
        right: &WheelOverRail,
        axle: Axle,
        lateral: f64,
    ) -> Result<Self, Error> {
        finite("lateral", lateral)?;
        let height = 0.5 * (left.radius + right.radius);
        let touches = |roll: f64| -> Result<[Touch; 2], Error> {
            let (sin, cos) = roll.sin_cos();
            Ok([
                left.touch([0.0, lateral, height], [0.0, cos, sin])?,
                right.touch([0.0, -lateral, height], [0.0, cos, -sin])?,
            ])
        };
        // the left wheel rises with the roll over its rail and the right one sinks
        let mut bracket = [-MOST_ROLL, MOST_ROLL];
        let mut roll = 0.0;
        for _ in 0..MOST_STEPS {
            let [on_left, on_right] = touches(roll)?;
            let excess = on_left.clearance - on_right.clearance;
            if axle == Axle::Level || excess.abs() < CLOSE || bracket[1] - bracket[0] < 1e-15 {
                return Ok(Self {
                    // both sink by what is left below them
                    height: height - 0.5 * (on_left.clearance + on_right.clearance),
                    roll,
                    left: on_left,
                    right: on_right,
                });
            }
            bracket[usize::from(excess > 0.0)] = roll;
            let arm = |touch: &Touch, shift: f64| {
                let down = touch.position[1] - height;
                touch.position[0] - shift + touch.angle.tan() * down
            };
            let rate = arm(&on_left, lateral) + arm(&on_right, -lateral);
            let newton = roll - excess / rate;
            roll = if newton > bracket[0] && newton < bracket[1] {
                newton
            } else {
                0.5 * (bracket[0] + bracket[1])
            };
            if roll.abs() > MOST_ROLL - 1e-9 {
                break;
            }
        }
        Err(Error::NeverTouch {
            reason: format!(
                "the wheelset would roll by more than {MOST_ROLL} rad before both of its wheels stand on the rails"
            ),
        })
    }
    /// The wheelset of a left and a right wheel on their rails at each of `shifts` [m] to the left. The shift
    /// `lateral` of the pairs has no meaning here.
    ///
    /// # Errors
    /// Those of [`StandingWheelset::new`], with the shift; [`Error::Interrupted`] if `look` asks for it.
    pub fn over_shifts(
        pairs: &[WheelOnRail; 2],
        axle: Axle,
        shifts: &[f64],
        look: Look<'_>,
    ) -> Result<Vec<Self>, Error> {
        let [left, right] = [
            WheelOverRail::new(&pairs[0])?,
            WheelOverRail::new(&pairs[1])?,
        ];
        let mut found = Vec::with_capacity(shifts.len());
        for &shift in shifts {
            if look().is_break() {
                return Err(Error::Interrupted);
            }
            let standing =
                Self::new(&left, &right, axle, shift).map_err(|error| Error::AtShift {
                    shift,
                    reason: error.to_string(),
                })?;
            found.push(standing);
        }
        Ok(found)
    }
}

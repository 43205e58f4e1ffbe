// SPDX-License-Identifier: MIT OR Apache-2.0
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use mtb_words::Short;
use nalgebra::Vector3;

use super::plane::{Ground, PlaneGap, Rows, STEEPEST};
use super::roller::Roller;
use super::section::{Placement, Section, samples_along};
use super::uneven::Seen;
use super::{WheelOnRail, joined_radius, plane, uneven};
use crate::error::positive;
use crate::{Error, Profile, Sliced, Slices};

/// Distance along the profile of the stations at which contact is looked for [m], on wheels of this radius [m]; it goes as
/// the radius.
const SAMPLING: f64 = 5e-5;
/// With slices, where a station is looked at over a stretch of the track.
const SAMPLING_OF_SLICES: f64 = 2e-4;
const SAMPLED: f64 = 0.46;
/// Inclination against a contact plane beyond which that plane no longer serves [rad].
pub(super) const MOST_INCLINED: f64 = 20.0 * std::f64::consts::PI / 180.0;
/// Slope at which a profile counts as vertical.
const STEEP: f64 = 1e3;
/// Steepest slope of a wheel that meets a roller elsewhere than above its middle, and what of the slope counts that
/// turns a yawed wheel up; steeper places touch no roller.
const STEEPEST_MET: f64 = 10.0;
const UPRIGHT: f64 = 0.99;
/// Rows between two overlaps along a rail below which they have one patch.
const ROWS_APART: f64 = 4.0;
/// Farthest angle of a wheel from the top of its roller [rad].
const FARTHEST_AHEAD: f64 = 0.5;
/// Steps of Newton's method to the rail with slices below a place, and the last one [m], after which the distance left
/// is of its square.
const STEPS_BELOW: usize = 8;
const CLOSE: f64 = 1e-8;

/// A left wheel in any pose over its rail: of revolution about its axle and a prism, or with slices; or over a roller,
/// of revolution as well.
///
/// The track frame is that of [`WheelOnRail`], whose shift `lateral` has no meaning here: the pose says where
/// the wheel stands. A right wheel is this one seen in a mirror.
///
/// # Example
/// ```
/// use mtb_geometry::{Profile, WheelOnRail, WheelOverRail, WheelPose};
/// let pair = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
/// let wheel = WheelOverRail::new(&pair)?;
/// let centre = |z: f64| [0.0, 0.0, wheel.first_height() + pair.wheel_radius + z];
/// let axle = [0.0, 1.0, 0.0];
/// assert!(wheel.overlap(WheelPose::new(centre(0.0), axle))?.abs() < 1e-8);
/// // 50 um lower and yawed by 10 mrad
/// let yawed = [-0.01_f64.sin(), 0.01_f64.cos(), 0.0];
/// let patches = wheel.patches(WheelPose::new(centre(-50e-6), yawed), [5e-4, 5e-4])?;
/// assert_eq!(patches.len(), 1);
/// // the middle of the axle turns the wheel back
/// assert!(patches[0].position[0] < -5e-3);
/// # Ok::<(), mtb_geometry::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct WheelOverRail {
    pub(super) wheel: Profile,
    pub(super) rail: Profile,
    pub(super) wheel_slices: Option<Arc<Slices>>,
    pub(super) rail_slices: Option<Arc<Slices>>,
    pub(super) radius: f64,
    pub(super) roller: Option<Roller>,
    pub(super) tape: f64,
    pub(super) placement: Placement,
    first_height: f64,
    /// Distance of the stations [m].
    pub(super) sampling: f64,
    pub(super) stations: Vec<Station>,
    pub(super) head: Vec<HeadPoint>,
    outlines: Known<Outline>,
    seen: Known<Seen>,
}

/// A place on the wheel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Station {
    /// y of the wheel profile [m].
    pub(super) position: f64,
    pub(super) radius: f64,
    /// Change of the radius along y [-].
    pub(super) slope: f64,
}

impl Station {
    pub(super) fn of(wheel: &Profile, tape_radius: f64, position: f64) -> Self {
        let [height, slope] = height_and_slope(wheel, position);
        Self {
            position,
            radius: tape_radius - height,
            slope: -slope,
        }
    }
}

/// A place on the top side of the rail, in the track.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeadPoint {
    pub(super) y: f64,
    pub(super) z: f64,
    pub(super) angle: f64,
    /// y of the rail profile [m].
    pub(super) position: f64,
}

/// What was found last of bodies with slices: a search for a height asks for one pose several times.
#[derive(Debug)]
struct Known<T>(Mutex<VecDeque<Arc<T>>>);

/// How many: of both wheels, in two poses.
const KNOWN: usize = 4;

impl<T> Default for Known<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T> Clone for Known<T> {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl<T> Known<T> {
    fn of(&self, serves: impl Fn(&T) -> bool, find: impl FnOnce() -> T) -> Arc<T> {
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = lock().iter().find(|known| serves(known)) {
            return known.clone();
        }
        let found = Arc::new(find());
        let mut known = lock();
        known.truncate(KNOWN - 1);
        known.push_front(found.clone());
        found
    }
}

/// The rail below a place in the track.
#[derive(Clone, Copy, Debug)]
pub(super) struct Under {
    /// x and y of the place [m].
    pub(super) at: [f64; 2],
    /// y of the rail profile [m], and the rail in its own frame.
    pub(super) own: f64,
    pub(super) rail: Sliced,
}

/// The wheel as seen along the rail, and what lies below it.
#[derive(Debug)]
pub(super) struct Outline {
    pub(super) pose: WheelPose,
    /// Where the prism can touch the wheel (n); on a roller each as seen from its own angle, with its way around the
    /// roller, at its nominal radius, as x.
    pub(super) points: Vec<Vector3<f64>>,
    /// Vertical distance from the rail (n), infinite beside it.
    pub(super) clearance: Vec<f64>,
    /// Slope angle of the rail below (n).
    pub(super) angle: Vec<f64>,
    /// Of bodies with slices, whose footprints are not those of circles on straight rails (n).
    pub(super) footprints: Option<Vec<Footprint>>,
}

/// Where a station overlaps.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Footprint {
    /// Sum of the square of the overlap over it [m3].
    pub(super) squares: f64,
    /// x at both ends, as of [`Outline::points`] [m].
    pub(super) ends: [f64; 2],
}

/// Where a wheel is in the track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelPose {
    /// Middle of the axle [m].
    pub centre: [f64; 3],
    /// Unit vector along the axle, to the left.
    pub axle: [f64; 3],
    /// Angle [rad] on the wheel of what points down: it rises as the wheel rolls forwards. It counts for wheels with
    /// slices only.
    pub turn: f64,
}

impl WheelPose {
    /// A wheel of which the angle 0 points down.
    pub fn new(centre: [f64; 3], axle: [f64; 3]) -> Self {
        Self {
            centre,
            axle,
            turn: 0.0,
        }
    }
}

/// Directions about an axle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spokes {
    pub(super) axle: Vector3<f64>,
    /// Across the axle, forwards and downwards.
    pub(super) along: Vector3<f64>,
    pub(super) down: Vector3<f64>,
    turn: f64,
}

impl Spokes {
    pub(super) fn of(pose: &WheelPose) -> Self {
        let axle = Vector3::from(pose.axle);
        let length = (1.0 - axle.x * axle.x).sqrt();
        let along = (Vector3::x() - axle.x * axle) / length;
        Self {
            axle,
            along,
            down: axle.cross(&along),
            turn: pose.turn,
        }
    }

    /// Angle on the wheel [rad] of a direction across the axle.
    pub(super) fn angle(&self, out: &Vector3<f64>) -> f64 {
        out.dot(&self.along).atan2(out.dot(&self.down)) + self.turn
    }
}

impl WheelOverRail {
    /// The wheel and the rail of `pair`.
    ///
    /// # Errors
    /// Values that make no sense, profiles that never face each other.
    pub fn new(pair: &WheelOnRail) -> Result<Self, Error> {
        pair.check()?;
        let section = Section::new(pair)?;
        let sampling = if pair.has_slices() {
            SAMPLING_OF_SLICES
        } else {
            SAMPLING
        };
        let sampling = sampling * (pair.wheel_radius / SAMPLED);
        let stations = samples_along(&pair.wheel, sampling)?
            .into_iter()
            .map(|position| Station::of(&pair.wheel, pair.wheel_radius, position))
            .collect();
        let placement = section.rail;
        let (sin, cos) = (placement.sin, placement.cos);
        let mut head: Vec<HeadPoint> = Vec::new();
        for position in samples_along(&pair.rail, sampling)? {
            let [height, rise] = height_and_slope(&pair.rail, position);
            let [y, z] = placement.place(position, height);
            let (across, along) = (cos - sin * rise, sin + cos * rise);
            // the under side of a turned flank is never touched from above
            if across > 0.0 && head.last().is_none_or(|last| y > last.y) {
                head.push(HeadPoint {
                    y,
                    z,
                    angle: along.atan2(across),
                    position,
                });
            }
        }
        if head.is_empty() {
            return Err(Error::NeverTouch {
                reason: "the rail has no top side".into(),
            });
        }
        Ok(Self {
            wheel: pair.wheel.clone(),
            rail: pair.rail.clone(),
            wheel_slices: pair.wheel_slices.clone(),
            rail_slices: pair.rail_slices.clone(),
            radius: pair.wheel_radius,
            roller: pair.roller(),
            sampling,
            tape: 0.5 * pair.flange_back + pair.tape_circle,
            placement,
            first_height: section.height,
            stations,
            head,
            outlines: Known::default(),
            seen: Known::default(),
        })
    }

    /// Distance of the tape circle from the middle of the axle [m].
    pub fn tape(&self) -> f64 {
        self.tape
    }

    /// Origin (y, z) of the rail profile in the track [m].
    pub fn rail_origin(&self) -> [f64; 2] {
        self.placement.shift
    }

    /// Height of the tape circle over the top of the rail where the wheel of the pair, as its `lateral` shifts
    /// it, just touches [m].
    pub fn first_height(&self) -> f64 {
        self.first_height
    }

    /// Largest vertical overlap [m] of the undeformed bodies, negative if apart.
    ///
    /// # Errors
    /// A wheel that is nowhere over the rail; a pose that is not finite.
    pub fn overlap(&self, pose: WheelPose) -> Result<f64, Error> {
        let outline = self.outline(&pose)?;
        Ok(-outline
            .clearance
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min))
    }

    /// The gap over each contact plane where the undeformed bodies overlap; `spacing` of the points along the rail
    /// and across [m].
    ///
    /// Planes lie in the middle of the overlap over its area, weighted by the square of its depth, as CONTACT's do, with
    /// the rail's mean slope there, weighted likewise. Touching places more than 20 degrees apart, such as tread and flange, have planes of their own.
    /// Planes do not incline along the track, not even where slices rise or fall there: as in CONTACT. On a roller they
    /// stand upright as seen from their own angle about its axis.
    ///
    /// # Errors
    /// A wheel that is nowhere over the rail; an overlap that reaches the end of a profile or takes too many
    /// points; numbers that make no sense.
    pub fn patches(&self, pose: WheelPose, spacing: [f64; 2]) -> Result<Vec<PlaneGap>, Error> {
        self.patches_of(pose, spacing, |_| false, Ground::Plane)
    }

    /// As [`WheelOverRail::patches`], but places that overlap without a break between them have one plane, however
    /// far it is turned between them: for a contact that has grown together.
    ///
    /// # Errors
    /// As of [`WheelOverRail::patches`].
    pub fn patches_grown_together(
        &self,
        pose: WheelPose,
        spacing: [f64; 2],
    ) -> Result<Vec<PlaneGap>, Error> {
        self.patches_of(pose, spacing, |clearance| clearance < 0.0, Ground::Plane)
    }

    /// As [`WheelOverRail::patches_grown_together`], but on rows of cells that follow the running surface of the rail,
    /// each with the normal of the rail there: for contacts that no plane holds, such as the root of a flange on a worn
    /// gauge corner.
    ///
    /// Rows lie at whole multiples of the spacing across along the rail, so that they stay where they are as the wheel
    /// moves. Angle and positions are those of the plane that would be the contact's.
    ///
    /// # Errors
    /// As of [`WheelOverRail::patches`]; slices and rollers.
    pub fn patches_along_rail(
        &self,
        pose: WheelPose,
        spacing: [f64; 2],
    ) -> Result<Vec<PlaneGap>, Error> {
        if self.wheel_slices.is_some() || self.rail_slices.is_some() || self.roller.is_some() {
            return Err(Error::NotStraight);
        }
        self.patches_of(pose, spacing, |clearance| clearance < 0.0, Ground::Rail)
    }

    /// All rows of patches along the rail, `spacing` [m] apart, and the number of the first of them: those of
    /// [`WheelOverRail::patches_along_rail`] are some of these.
    ///
    /// # Errors
    /// A spacing that is not positive, or that takes too many rows.
    pub fn rows_of_rail(&self, spacing: f64) -> Result<(i64, Rows), Error> {
        positive("spacing across", spacing)?;
        plane::all_rows(self, spacing)
    }

    /// `is_one`: whether the contact goes on where its parts are cut, by the clearance there.
    fn patches_of(
        &self,
        pose: WheelPose,
        spacing: [f64; 2],
        is_one: fn(f64) -> bool,
        ground: Ground,
    ) -> Result<Vec<PlaneGap>, Error> {
        positive("spacing along x", spacing[0])?;
        positive("spacing across", spacing[1])?;
        let outline = self.outline(&pose)?;
        let mut parts = parts(&outline.clearance, &outline.angle, is_one);
        if ground == Ground::Rail {
            // rows beside one of them lie on the other
            let near = ROWS_APART * spacing[1];
            parts.dedup_by(|next, part| {
                let [from, to] = [part.end - 1, next.start].map(|k| outline.points[k]);
                let is_near = (to - from).yz().norm() < near;
                if is_near {
                    part.end = next.end;
                }
                is_near
            });
        }
        parts
            .into_iter()
            .map(|part| plane::over(self, &outline, part, &pose, (spacing, ground)))
            .collect()
    }

    /// Where a prism can touch the circle of the wheel at a station.
    pub(super) fn lowest_of(
        &self,
        station: &Station,
        centre: Vector3<f64>,
        axle: Vector3<f64>,
    ) -> Vector3<f64> {
        let length = (1.0 - axle.x * axle.x).sqrt();
        let along = (Vector3::x() - axle.x * axle) / length;
        let down = axle.cross(&along);
        let sin = (station.slope * axle.x / length).clamp(-1.0, 1.0);
        let cos = (1.0 - sin * sin).sqrt();
        centre + axle * (self.tape + station.position) + (down * cos + along * sin) * station.radius
    }

    /// Where the wheel at a station is nearest to the rail or the roller, as of [`Outline::points`].
    pub(super) fn nearest_of(
        &self,
        station: &Station,
        centre: Vector3<f64>,
        axle: Vector3<f64>,
    ) -> Vector3<f64> {
        let Some(roller) = self.roller else {
            return self.lowest_of(station, centre, axle);
        };
        let station = met(station, axle);
        let angle = roller.angle(self.on_axle(&station, centre, axle));
        let centre = roller.seen(angle, centre);
        let axle = super::roller::turn(-angle) * axle;
        let mut point = self.lowest_of(&station, centre, axle);
        point.x = roller.radius * angle;
        point
    }

    /// Where the normals of the wheel at a station meet the axle. Where bodies of revolution touch, the normal meets
    /// both axes.
    pub(super) fn on_axle(
        &self,
        station: &Station,
        centre: Vector3<f64>,
        axle: Vector3<f64>,
    ) -> Vector3<f64> {
        centre + axle * (self.tape + station.position + station.slope * station.radius)
    }

    /// Radius of a wheel on a straight rail that leaves the same distance along it [m].
    pub(super) fn joined_radius(&self) -> f64 {
        joined_radius(self.radius, self.roller)
    }

    /// The wheel as seen along the rail, and what lies below it.
    pub(super) fn outline(&self, pose: &WheelPose) -> Result<Arc<Outline>, Error> {
        let outline = self.nominal_outline(pose)?;
        let outline = if self.wheel_slices.is_some() || self.rail_slices.is_some() {
            let find = || uneven::outline(self, outline, pose);
            self.outlines.of(|known| known.pose == *pose, find)
        } else {
            Arc::new(outline)
        };
        if outline.clearance.iter().all(|c| *c == f64::INFINITY) {
            let [first, last] = [0, outline.points.len() - 1].map(|k| outline.points[k].y);
            return Err(Error::NeverTouch {
                reason: format!(
                    "the wheel, y = {first:.4} .. {last:.4} m, is nowhere above the head of the rail, y = {:.4} .. {:.4} m (the right wheel seen in a mirror)",
                    self.head[0].y,
                    self.head[self.head.len() - 1].y
                ),
            });
        }
        Ok(outline)
    }

    /// Places with slices that were looked at in a pose, or in one that has the same ones.
    pub(super) fn seen(&self, pose: &WheelPose) -> Arc<Seen> {
        let find = || Seen::new(self, pose);
        self.seen.of(|seen| seen.serves(self, pose), find)
    }

    /// Of the wheel and the rail without slices.
    pub(super) fn nominal_outline(&self, pose: &WheelPose) -> Result<Outline, Error> {
        let (centre, axle) = (Vector3::from(pose.centre), Vector3::from(pose.axle));
        let size = axle.norm();
        for (name, value) in [
            ("centre of the axle", centre.sum()),
            ("direction of the axle", size),
            ("turn of the wheel", pose.turn),
        ] {
            if !value.is_finite() {
                return Err(Error::NotFinite { name, value });
            }
        }
        if (size - 1.0).abs() > 1e-6 || axle.y < 0.1 {
            return Err(crate::error::out_of_range(
                "direction of the axle, y,",
                axle.y,
                "a unit vector that points to the left is needed",
            ));
        }
        if let Some(roller) = self.roller
            && roller.angle(centre).abs() > FARTHEST_AHEAD
        {
            return Err(Error::NeverTouch {
                reason: format!(
                    "the axle stands {} m ahead of that of the roller; on a roller x is a place above it, and not the way \
                     along a track",
                    Short(centre.x)
                ),
            });
        }
        let mut below = Below::new(&self.head);
        let n = self.stations.len();
        let mut outline = Outline {
            pose: *pose,
            points: Vec::with_capacity(n),
            clearance: Vec::with_capacity(n),
            angle: Vec::with_capacity(n),
            footprints: None,
        };
        for station in &self.stations {
            let point = self.nearest_of(station, centre, axle);
            let (from, share) = below.at(point.y);
            let [first, second] = [from, (from + 1).min(self.head.len() - 1)].map(|k| self.head[k]);
            let is_over = (self.head[0].y..=self.head[self.head.len() - 1].y).contains(&point.y);
            outline.clearance.push(if is_over {
                point.z - (first.z + share * (second.z - first.z))
            } else {
                f64::INFINITY
            });
            outline
                .angle
                .push(first.angle + share * (second.angle - first.angle));
            outline.points.push(point);
        }
        Ok(outline)
    }

    /// The wheel at an angle [rad] on it and y of its profile.
    pub(super) fn wheel_at(&self, angle: f64, y: f64) -> Sliced {
        surface(&self.wheel, self.wheel_slices.as_deref(), angle, y)
    }

    /// The rail at x in the track and y of its profile, in its own frame.
    pub(super) fn rail_at_own(&self, x: f64, y: f64) -> Sliced {
        surface(&self.rail, self.rail_slices.as_deref(), x, y)
    }

    /// y of the rail profile below a place in the track.
    pub(super) fn rail_below(&self, x: f64, y: f64) -> f64 {
        if self.rail_slices.is_some() {
            self.rail_under([x, y], None).own
        } else {
            self.on_head(y).1
        }
    }

    /// The rail below a place in the track; `near`: what was found near by.
    pub(super) fn rail_under(&self, at: [f64; 2], near: Option<Under>) -> Under {
        let [x, y] = at;
        let mut own = match near {
            Some(near) => {
                let [by_own, ..] = self.below_change(&near.rail, x - near.at[0], y - near.at[1]);
                near.own + by_own
            }
            None => self.on_head(y).1,
        };
        let mut rail = self.rail_at_own(x, own);
        if self.rail_slices.is_some() {
            let (sin, cos) = (self.placement.sin, self.placement.cos);
            for _ in 0..STEPS_BELOW {
                let [across, _] = self.placement.place(own, rail.height);
                let step = (across - y) / (cos - sin * rail.slope).max(STEEPEST);
                own -= step;
                if step.abs() < CLOSE {
                    // the tangent is the rail, to rounding
                    rail.height -= step * rail.slope;
                    break;
                }
                rail = self.rail_at_own(x, own);
            }
        }
        Under { at, own, rail }
    }

    /// How the place below changes with x and y in the track over a `rail` as it is there: y of the rail profile, then y
    /// and z of the rail there in the track.
    pub(super) fn below_change(&self, rail: &Sliced, by_x: f64, by_y: f64) -> [f64; 3] {
        let (sin, cos) = (self.placement.sin, self.placement.cos);
        let rate = (cos - sin * rail.slope).max(STEEPEST);
        let by_own = (by_y + sin * rail.rate * by_x) / rate;
        let by_height = rail.slope * by_own + rail.rate * by_x;
        [
            by_own,
            cos * by_own - sin * by_height,
            sin * by_own + cos * by_height,
        ]
    }

    /// Height of the head at `y` in the track, and the rail profile's y there.
    pub(super) fn on_head(&self, y: f64) -> (f64, f64) {
        let (from, share) = Below::new(&self.head).at(y);
        let [a, b] = [from, (from + 1).min(self.head.len() - 1)].map(|k| self.head[k]);
        (
            a.z + share * (b.z - a.z),
            a.position + share * (b.position - a.position),
        )
    }

    /// Rates along y of height, slope angle and the rail profile's y on the head; 0 beside it.
    pub(super) fn rates_on_head(&self, y: f64) -> [f64; 3] {
        let (from, _) = Below::new(&self.head).at(y);
        let Some(next) = self.head.get(from + 1).filter(|_| y >= self.head[0].y) else {
            return [0.0; 3];
        };
        let here = self.head[from];
        let width = next.y - here.y;
        [
            next.z - here.z,
            next.angle - here.angle,
            next.position - here.position,
        ]
        .map(|d| d / width)
    }
}

/// Where on the head a lateral position lies; positions asked for one after the other are near each other.
struct Below<'a> {
    head: &'a [HeadPoint],
    from: usize,
}

impl<'a> Below<'a> {
    fn new(head: &'a [HeadPoint]) -> Self {
        Self { head, from: 0 }
    }

    /// Point of the head before `y`, and the share of the way to the next; at the ends beside the head.
    fn at(&mut self, y: f64) -> (usize, f64) {
        let (head, last) = (self.head, self.head.len() - 1);
        if y <= head[0].y {
            return (0, 0.0);
        }
        if y >= head[last].y {
            return (last, 0.0);
        }
        let near = (self.from..last.min(self.from + 4))
            .find(|&k| head[k].y <= y && y < head[k + 1].y)
            .unwrap_or_else(|| head.partition_point(|p| p.y <= y) - 1);
        self.from = near;
        let share = (y - head[near].y) / (head[near + 1].y - head[near].y);
        (near, share)
    }
}

/// A station with the slope that counts where it meets a roller.
pub(super) fn met(station: &Station, axle: Vector3<f64>) -> Station {
    let upright = UPRIGHT * (1.0 - axle.x * axle.x).sqrt() / axle.x.abs();
    let most = STEEPEST_MET.min(upright);
    Station {
        slope: station.slope.clamp(-most, most),
        ..*station
    }
}

/// Height [m] and slope [-], which some profiles have infinite at their ends; the nearest place of the
/// profile for positions beyond it.
pub(super) fn height_and_slope(profile: &Profile, y: f64) -> [f64; 2] {
    let [start, end] = profile.range();
    let station = profile.at(y.max(start).min(end));
    station.map_or([f64::NAN; 2], |s| [s.height, s.slope.clamp(-STEEP, STEEP)])
}

/// A surface at a place along it and y of its profile.
fn surface(profile: &Profile, slices: Option<&Slices>, along: f64, y: f64) -> Sliced {
    if let Some(slices) = slices {
        return slices.at(profile, along, y);
    }
    let [height, slope] = height_and_slope(profile, y);
    let [low, high] = profile.range();
    Sliced {
        height,
        slope,
        rate: 0.0,
        nominal: y,
        is_there: (low..=high).contains(&y),
    }
}

/// Stations that overlap, parted between lowest points that lie on different planes where the contact is not one.
fn parts(clearance: &[f64], angle: &[f64], is_one: fn(f64) -> bool) -> Vec<std::ops::Range<usize>> {
    let n = clearance.len();
    let at = |k: usize| clearance.get(k).copied().unwrap_or(f64::INFINITY);
    let is_lowest = |k: usize| {
        clearance[k] < 0.0 && clearance[k] <= at(k.wrapping_sub(1)) && clearance[k] < at(k + 1)
    };
    let mut cuts = vec![0];
    let mut kept: Option<usize> = None;
    for low in (0..n).filter(|&k| is_lowest(k)) {
        match kept {
            Some(before) if (angle[low] - angle[before]).abs() > MOST_INCLINED => {
                // the highest place between them, the first of equals
                let cut = (before..=low)
                    .rev()
                    .max_by(|&a, &b| clearance[a].total_cmp(&clearance[b]))
                    .unwrap_or(low);
                if !is_one(clearance[cut]) {
                    cuts.push(cut);
                }
                kept = Some(low);
            }
            Some(before) if clearance[low] >= clearance[before] => {}
            _ => kept = Some(low),
        }
    }
    cuts.push(n);
    let overlapping = |ends: &[usize]| {
        let is_in = |k: &usize| clearance[*k] < 0.0;
        let first = (ends[0]..ends[1]).find(is_in)?;
        let last = (ends[0]..ends[1]).rfind(is_in)?;
        Some(first..last + 1)
    };
    cuts.windows(2).filter_map(overlapping).collect()
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where wheels and rails are at an instant: the pose of the wheelset, curvature of the track, rails and wheels that
//! are not where they nominally are, and how fast they go there.

use mtb_geometry::PlaneGap;
use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::error::{Error, check_entries, positive};
use crate::wheelset::Side;

/// Farthest deviation [m], [rad]; larger ones are mistakes.
const MOST: f64 = 0.1;

/// A rail beside its nominal place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RailDeviation {
    /// Displacement along y and z [m], then the rotation about the origin of its profile [rad], about x.
    pub place: [f64; 3],
    /// Their rates [m/s], [rad/s].
    pub rate: [f64; 3],
}

/// A wheel beside its place on a rigid wheelset, along and about the axes of the wheelset, which roll and yaw lead and
/// which do not roll with its wheels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelDeviation {
    /// Displacement of the middle of its tape circle x, y, z [m], then its rotation about x, y, z [rad].
    pub place: [f64; 6],
    /// Velocity [m/s] and rotation [rad/s] of the wheel beside those that the rigid wheelset, as it turns, gives it
    /// there. One that turns about its own axle, bent by x, z, roll and yaw that stay, has -omega z and omega x along x
    /// and z, -omega yaw and omega roll about them; omega is the rotation about the axle [rad/s].
    pub rate: [f64; 6],
}

/// What a step is given of the track and of wheels that a wheelset bends, beside pose and velocity; left, then right.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Alignment {
    /// Curvature of the track [1/m], > 0 in a curve to the left. The frame of the track goes along it at the velocity
    /// along x, so that it turns by their product; the velocity of the wheelset is relative to the frame.
    pub curvature: f64,
    /// Rails.
    pub rails: [RailDeviation; 2],
    /// Wheels.
    pub wheels: [WheelDeviation; 2],
}

/// Springs without mass between each rail and the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RailSprings {
    /// Lateral and vertical stiffness [N/m]; infinite where the rail does not move.
    pub stiffness: [f64; 2],
    /// What acts on each rail beside its wheel, outwards and upwards [N].
    pub force: [f64; 2],
}

impl RailSprings {
    pub(crate) fn check(&self) -> Result<(), Error> {
        for stiffness in self.stiffness {
            if stiffness != f64::INFINITY {
                positive("stiffness of the rails", stiffness)?;
            }
        }
        check_entries("force on the rails", &self.force)
    }

    /// Displacement (y, z) [m] of a rail under the force (y, z) of its wheel [N].
    pub(crate) fn displacement(&self, side: Side, force: [f64; 2]) -> [f64; 2] {
        let outwards = if side == Side::Left { 1.0 } else { -1.0 };
        [
            (force[0] + outwards * self.force[0]) / self.stiffness[0],
            (force[1] + self.force[1]) / self.stiffness[1],
        ]
    }
}

impl Alignment {
    /// How many numbers it has.
    pub(crate) const NUMBERS: usize = 37;

    /// One of its numbers: the curvature, then place and rate of each rail, then those of each wheel.
    pub(crate) fn number(&mut self, index: usize) -> &mut f64 {
        if index == 0 {
            return &mut self.curvature;
        }
        let index = index - 1;
        if index < 12 {
            let rail = &mut self.rails[index / 6];
            let part = if index % 6 < 3 {
                &mut rail.place
            } else {
                &mut rail.rate
            };
            return &mut part[index % 3];
        }
        let index = index - 12;
        let wheel = &mut self.wheels[index / 12];
        let part = if index % 12 < 6 {
            &mut wheel.place
        } else {
            &mut wheel.rate
        };
        &mut part[index % 6]
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        check_entries("curvature", &[self.curvature])?;
        if self.curvature.abs() > MOST {
            return Err(Error::Number {
                name: "curvature",
                value: self.curvature,
                wanted: "a curve of the track of at least 10 m radius is needed, at most 0.1 / m",
            });
        }
        let rails = self.rails.iter().map(|rail| {
            let wanted = "a rail beside its place by at most 0.1 m and 0.1 rad is needed";
            ("rail deviation", &rail.place[..], &rail.rate[..], wanted)
        });
        let wheels = self.wheels.iter().map(|wheel| {
            let wanted = "a wheel beside its place by at most 0.1 m and 0.1 rad is needed";
            ("wheel deviation", &wheel.place[..], &wheel.rate[..], wanted)
        });
        for (name, place, rate, wanted) in rails.chain(wheels) {
            check_entries(name, rate)?;
            if let Some(&value) = place
                .iter()
                .find(|value| value.is_nan() || value.abs() > MOST)
            {
                return Err(Error::Number {
                    name,
                    value,
                    wanted,
                });
            }
        }
        Ok(())
    }
}

/// Where a wheelset and what is around it are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Place {
    /// Displacement x, y, z [m], roll, pitch, yaw [rad].
    pub(crate) pose: [f64; 6],
    pub(crate) alignment: Alignment,
}

impl Alignment {
    /// Whether neither rails nor wheels move beside their places.
    pub(crate) fn is_still(&self) -> bool {
        let rails = self.rails.iter().flat_map(|rail| &rail.rate);
        let wheels = self.wheels.iter().flat_map(|wheel| &wheel.rate);
        rails.chain(wheels).all(|rate| *rate == 0.0)
    }
}

impl Place {
    /// The rail of a side, seen in a mirror if it is the right one.
    pub(crate) fn rail(&self, side: Side) -> RailDeviation {
        let own = self.alignment.rails[index(side)];
        let across = sign(side);
        let seen = |[y, z, roll]: [f64; 3]| [across * y, z, across * roll];
        RailDeviation {
            place: seen(own.place),
            rate: seen(own.rate),
        }
    }

    /// Whether a wheel is elsewhere on its rail after a change by this.
    pub(crate) fn moves(&self, side: Side) -> bool {
        let rail = self.alignment.rails[index(side)].place;
        let wheel = self.wheel(side).place;
        let mut all = self.pose.iter().chain(&rail).chain(&wheel);
        all.any(|by| *by != 0.0)
    }

    /// Place of the wheel of a side in the axes of the wheelset, with the pitch of both.
    pub(crate) fn turned_wheel(&self, side: Side) -> [f64; 6] {
        let mut place = self.wheel(side).place;
        place[4] += self.pose[4];
        place
    }

    /// The wheel of a side, in its own directions.
    pub(crate) fn wheel(&self, side: Side) -> &WheelDeviation {
        &self.alignment.wheels[index(side)]
    }
}

/// A rail that was moved rigidly in the vertical plane across the track, as of a left rail.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moved {
    pub(crate) turn: Matrix3<f64>,
    /// Angle of it about x [rad].
    pub(crate) angle: f64,
    /// The point that it was turned about, then shifted [m].
    about: Vector3<f64>,
    shift: Vector3<f64>,
}

impl Moved {
    /// A rail whose profile has its origin at `about`.
    pub(crate) fn of(rail: &RailDeviation, about: [f64; 2]) -> Self {
        let [y, z, angle] = rail.place;
        Self {
            turn: Rotation3::from_axis_angle(&Vector3::x_axis(), angle).into_inner(),
            angle,
            about: Vector3::new(0.0, about[0], about[1]),
            shift: Vector3::new(0.0, y, z),
        }
    }

    /// The directions along, across and normal to a plane on it, which was found as the rail sees it.
    pub(crate) fn frame(&self, plane: &PlaneGap) -> Matrix3<f64> {
        if plane.roller_angle == 0.0 {
            return about(0, plane.angle);
        }
        self.turn * about(1, plane.roller_angle) * about(0, plane.angle - self.angle)
    }

    /// Change of [`Moved::frame`] with that of the rail, of the angle about a roller and of the slope on the rail.
    pub(crate) fn frame_change(
        &self,
        plane: &PlaneGap,
        by: &RailDeviation,
        (by_roller, by_angle): (f64, f64),
    ) -> Matrix3<f64> {
        let [ahead, slope] = [
            about(1, plane.roller_angle),
            about(0, plane.angle - self.angle),
        ];
        let x = Vector3::x().cross_matrix();
        let y = Vector3::y().cross_matrix();
        self.turn_change(by.place[2]) * ahead * slope
            + self.turn * (y * by_roller * ahead * slope + ahead * (x * by_angle) * slope)
    }

    /// A patch found as the rail sees it, in the track.
    pub(crate) fn put(&self, mut plane: PlaneGap) -> PlaneGap {
        plane.position = self.point(plane.position.into()).into();
        plane.angle += self.angle;
        Self::each_row(&mut plane, |at| self.point(at), self.angle);
        plane
    }

    /// A patch in the track, as the rail sees it.
    pub(crate) fn seen_from(&self, plane: &PlaneGap) -> PlaneGap {
        let mut plane = plane.clone();
        plane.position = self.seen(plane.position.into()).into();
        plane.angle -= self.angle;
        Self::each_row(&mut plane, |at| self.seen(at), -self.angle);
        plane
    }

    fn each_row(plane: &mut PlaneGap, moved: impl Fn(Vector3<f64>) -> Vector3<f64>, turned: f64) {
        let Some(rows) = &mut plane.rows else {
            return;
        };
        for place in &mut rows.places {
            let at = moved(Vector3::new(0.0, place[0], place[1]));
            *place = [at.y, at.z];
        }
        for angle in rows.angles.iter_mut().chain(&mut rows.between) {
            *angle += turned;
        }
    }

    /// Where a point of the rail has gone.
    pub(crate) fn point(&self, at: Vector3<f64>) -> Vector3<f64> {
        self.about + self.shift + self.turn * (at - self.about)
    }

    /// A point as the rail sees it that stays where it nominally is.
    pub(crate) fn seen(&self, at: Vector3<f64>) -> Vector3<f64> {
        self.about + self.turn.transpose() * (at - self.about - self.shift)
    }

    /// Change of [`Moved::point`] with that of the rail and of the point.
    pub(crate) fn point_change(
        &self,
        by: &RailDeviation,
        at: Vector3<f64>,
        by_at: Vector3<f64>,
    ) -> Vector3<f64> {
        let [y, z, angle] = by.place;
        Vector3::new(0.0, y, z) + self.turn_change(angle) * (at - self.about) + self.turn * by_at
    }

    /// Change of [`Moved::seen`] with that of the rail and of the point.
    pub(crate) fn seen_change(
        &self,
        by: &RailDeviation,
        at: Vector3<f64>,
        by_at: Vector3<f64>,
    ) -> Vector3<f64> {
        let [y, z, angle] = by.place;
        self.turn_change(angle).transpose() * (at - self.about - self.shift)
            + self.turn.transpose() * (by_at - Vector3::new(0.0, y, z))
    }

    /// Change of the turn with its angle.
    pub(crate) fn turn_change(&self, by_angle: f64) -> Matrix3<f64> {
        (Vector3::x() * by_angle).cross_matrix() * self.turn
    }

    /// Where the origin of the profile has gone.
    pub(crate) fn origin(&self) -> Vector3<f64> {
        self.about + self.shift
    }
}

/// The turn by an angle about x (0) or y (1).
pub(crate) fn about(axis: usize, angle: f64) -> Matrix3<f64> {
    Rotation3::from_axis_angle(&Vector3::ith_axis(axis), angle).into_inner()
}

pub(crate) fn index(side: Side) -> usize {
    usize::from(side == Side::Right)
}

/// 1 for the left wheel, -1 for the right one, which is seen in a mirror.
pub(crate) fn sign(side: Side) -> f64 {
    if side == Side::Right { -1.0 } else { 1.0 }
}

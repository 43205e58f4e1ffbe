// SPDX-License-Identifier: MIT OR Apache-2.0
//! A roller in place of a rail: the profile of the rail turned about an axis.
//!
//! A roller looks alike from every angle about its axis. Each place is therefore seen from its own angle, where the
//! roller stands under it as a rail does, but for its roundness along the track.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::over::{Spokes, WheelPose};

/// A body of revolution about an axis parallel to y, below the top of the rail at x = 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Roller {
    /// Radius at the top of the rail [m].
    pub(super) radius: f64,
}

/// The turn about y that takes the top of the roller to an angle ahead of it.
pub(super) fn turn(angle: f64) -> Matrix3<f64> {
    Rotation3::from_axis_angle(&Vector3::y_axis(), angle).into_inner()
}

impl Roller {
    /// The middle of the roller.
    pub(super) fn centre(self) -> Vector3<f64> {
        Vector3::new(0.0, 0.0, -self.radius)
    }

    /// Angle of a place about the axis [rad], > 0 ahead of the top.
    pub(super) fn angle(self, at: Vector3<f64>) -> f64 {
        at.x.atan2(self.radius + at.z)
    }

    /// Rate of [`Roller::angle`] as the place moves.
    pub(super) fn angle_change(self, at: Vector3<f64>, by: Vector3<f64>) -> f64 {
        let up = self.radius + at.z;
        (up * by.x - at.x * by.z) / (at.x * at.x + up * up)
    }

    /// A place as seen from its own angle, with its way around the roller, at its nominal radius, as x.
    pub(super) fn own(self, at: Vector3<f64>) -> Vector3<f64> {
        let [raised, _] = self.raised(at.x, at.z);
        Vector3::new(self.radius * self.angle(at), at.y, raised)
    }

    /// Change of [`Roller::own`] as the place moves.
    pub(super) fn own_change(self, at: Vector3<f64>, by: Vector3<f64>) -> Vector3<f64> {
        let up = self.radius + at.z;
        let raised = (at.x * by.x + up * by.z) / at.x.hypot(up);
        Vector3::new(self.radius * self.angle_change(at, by), by.y, raised)
    }

    /// A place as seen from an angle.
    pub(super) fn seen(self, angle: f64, at: Vector3<f64>) -> Vector3<f64> {
        // what the middle of a large roller is turned by, without its radius
        let (whole, half) = (angle.sin(), (0.5 * angle).sin());
        let by = Vector3::new(whole, 0.0, 2.0 * half * half) * self.radius;
        turn(-angle) * at - by
    }

    /// Where a place is that is seen from an angle.
    pub(super) fn place(self, angle: f64, at: Vector3<f64>) -> Vector3<f64> {
        self.seen(-angle, at)
    }

    /// Change of [`Roller::seen`] as place and angle change.
    pub(super) fn seen_change(
        self,
        (angle, by_angle): (f64, f64),
        (at, by_at): (Vector3<f64>, Vector3<f64>),
    ) -> Vector3<f64> {
        let turned = turn(-angle) * (at - self.centre());
        turn(-angle) * by_at - by_angle * Vector3::y().cross(&turned)
    }

    /// A pose as seen from an angle.
    pub(super) fn pose(self, angle: f64, pose: &WheelPose) -> WheelPose {
        let mut seen = WheelPose::new(
            self.seen(angle, Vector3::from(pose.centre)).into(),
            (turn(-angle) * Vector3::from(pose.axle)).into(),
        );
        // what points down from there
        let down = turn(angle) * Spokes::of(&seen).down;
        seen.turn = Spokes::of(pose).angle(&down);
        seen
    }

    /// Height of a place over the top of the rail as seen from its own angle, and its rate along z; `x` and `z` as seen
    /// from any angle.
    pub(super) fn raised(self, x: f64, z: f64) -> [f64; 2] {
        let up = self.radius + z;
        let distance = x.hypot(up);
        // small against the radius, and not taken off it
        [z + x * x / (distance + up), up / distance]
    }
}

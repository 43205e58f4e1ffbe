// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::Grid;
use nalgebra::{Matrix3, Vector3};

use crate::Side;
use crate::track::about;

/// What a point of a patch does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum PointStatus {
    /// No contact.
    Open = 0,
    /// The surfaces stick.
    Stick = 1,
    /// The surfaces slip.
    Slip = 2,
}

/// A row of a patch that follows the rail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchRow {
    /// Place of its points at the x of the origin, in the track [m].
    pub position: [f64; 3],
    /// Slope across the track [rad], > 0 where it rises to y > 0, of the surface between rail and wheel, the mean of both:
    /// what acts on the row is across it and normal to it.
    pub inclination: f64,
    /// How deep below it the undeformed surface of the wheel lies at the x of the origin [m], < 0 above it: its velocity
    /// counts for the slip, and the load acts there for the moment.
    pub depth: f64,
    /// Rigid slip of the wheel over the rail at the x of the origin, along and across the row, over the rolling speed, and
    /// spin about its normal: xi, eta [-], phi [1/m].
    pub creepage: [f64; 3],
}

/// A contact patch of a step; fields (ny * nx, x fastest) in its own frame: x along the rail, y across, normal. Where it
/// follows the rail, y is the way along its surface, and each row has a frame of its own.
#[derive(Clone, Debug)]
pub struct WheelPatch {
    /// The wheel.
    pub side: Side,
    /// Origin of the frame, in the track [m].
    pub position: [f64; 3],
    /// Rows of the rotation whose columns are x, y and normal of the frame in the track; the normal points from
    /// the rail to the wheel.
    pub rotation: [[f64; 3]; 3],
    /// Slope of the contact plane [rad], > 0 where it rises to the field side (flange contact).
    pub contact_angle: f64,
    /// y of the origin in the rail profile's own frame [m].
    pub rail_position: f64,
    /// y of the origin in the wheel profile's own frame [m].
    pub wheel_position: f64,
    /// First point along x and y, in spacings from the origin; across that of [`WheelPatch::first_across`].
    pub first: [i64; 2],
    /// Distance of the first row from the origin [m].
    pub first_across: f64,
    /// Its rows (ny), where it follows the rail; otherwise none, and it lies on a plane.
    pub rows: Vec<PatchRow>,
    /// The points.
    pub grid: Grid,
    /// Pressure (n) [Pa].
    pub pressure: Vec<f64>,
    /// Traction on the rail (2n) [Pa], along x first.
    pub traction: Vec<f64>,
    /// Slip velocity of the wheel over the rail (2n) [m/s]; zero where they stick.
    pub slip_velocity: Vec<f64>,
    /// Work of friction that turns into heat (n) [W/m2], see [`mtb_contact::tangential::dissipation`]. Its sum is
    /// the friction power, but for spin: the solver takes the rigid slip off the centres of the cells, by an
    /// error of the first order in their size.
    pub dissipation: Vec<f64>,
    /// Status (n).
    pub status: Vec<PointStatus>,
    /// Largest overlap of the undeformed bodies along the normal [m].
    pub approach: f64,
    /// Rigid slip of the wheel over the rail, over the rolling speed: xi, eta [-], phi [1/m].
    ///
    /// At the origin, where the undeformed surface of the wheel lies deeper than that of the rail by the approach.
    pub creepage: [f64; 3],
    /// Mean of the speeds at which the patch runs over rail and wheel [m/s]; > 0 along x.
    pub rolling_speed: f64,
    /// Heat of sliding [W], >= 0: what the tractions work on the rigid slip and, between unlike bodies, on the
    /// slip that the pressure causes.
    ///
    /// In steady rolling the elastic energy stays, so all of it turns into heat; between like bodies it is what
    /// an energy balance of the wheelset asks for. On cells, traction times slip velocity is less, by an error of
    /// the first order in their size.
    pub friction_power: f64,
    /// Sum of pressure times area [N].
    pub normal_force: f64,
    /// Share of the estimated contact area inclined too much against the plane to be represented by it [-].
    pub neglected: f64,
}

impl WheelPatch {
    /// Place of a point in the frame of the patch [m].
    pub fn place(&self, point: usize) -> [f64; 2] {
        let (column, row) = (point % self.grid.nx, point / self.grid.nx);
        [
            self.grid.dx * (self.first[0] + column as i64) as f64,
            self.across(row),
        ]
    }

    /// y of a row in the frame [m].
    fn across(&self, row: usize) -> f64 {
        if self.rows.is_empty() {
            return self.grid.dy * (self.first[1] + row as i64) as f64;
        }
        self.first_across + self.grid.dy * row as f64
    }

    /// Place of a row at the x of the origin [m], and the rotation whose columns are its x, y and normal, in the track.
    pub fn row(&self, row: usize) -> ([f64; 3], [[f64; 3]; 3]) {
        if let Some(PatchRow {
            position,
            inclination,
            ..
        }) = self.rows.get(row)
        {
            let turn = about(0, *inclination);
            return (
                *position,
                [0, 1, 2].map(|i| [0, 1, 2].map(|j| turn[(i, j)])),
            );
        }
        let across = self.across(row);
        let position = [0, 1, 2].map(|c| self.position[c] + self.rotation[c][1] * across);
        (position, self.rotation)
    }

    /// Force on the rail [N] and its moment about `point` [N m], in the track.
    ///
    /// For the moment it acts on the undeformed surface of the wheel, deeper than the plane by the approach: where
    /// the wheel's velocity is taken, so that the work of the load on the wheelset is the heat;
    /// rows that are turned against each other leave a part of it open.
    pub fn load(&self, point: [f64; 3]) -> [[f64; 3]; 2] {
        if !self.rows.is_empty() {
            return self.load_of_rows(point);
        }
        let n = self.pressure.len();
        // about the origin of the frame, in the frame
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for k in 0..n {
            let [x, y] = self.place(k);
            let load = Vector3::new(self.traction[k], self.traction[n + k], -self.pressure[k]);
            force += load;
            moment += Vector3::new(x, y, 0.0).cross(&load);
        }
        let turn = Matrix3::from_fn(|i, j| self.rotation[i][j]) * self.grid.cell_area();
        let (force, moment) = (turn * force, turn * moment);
        let normal = Vector3::from(self.rotation.map(|row| row[2]));
        let arm = Vector3::from(self.position) - normal * self.approach - Vector3::from(point);
        [force.into(), (moment + arm.cross(&force)).into()]
    }

    /// [`WheelPatch::load`] where each row has its own normal.
    fn load_of_rows(&self, point: [f64; 3]) -> [[f64; 3]; 2] {
        let (n, nx) = (self.pressure.len(), self.grid.nx);
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for (j, row) in self.rows.iter().enumerate() {
            let (mut own, mut turning) = (Vector3::zeros(), Vector3::zeros());
            for i in 0..nx {
                let k = j * nx + i;
                let load = Vector3::new(self.traction[k], self.traction[n + k], -self.pressure[k]);
                own += load;
                turning += Vector3::x().cross(&load) * self.place(k)[0];
            }
            let turn = about(0, row.inclination) * self.grid.cell_area();
            let (own, turning) = (turn * own, turn * turning);
            let normal = about(0, row.inclination).column(2).into_owned();
            let arm = Vector3::from(row.position) - normal * row.depth - Vector3::from(point);
            force += own;
            moment += turning + arm.cross(&own);
        }
        [force.into(), moment.into()]
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Patches that follow the rail: each row of cells has a place, a normal and a slip of its own.
//!
//! Rows lie at whole multiples of their distance along the rail, so that neither pressures nor tractions move over them
//! as the contact does. What acts on a row is seen from another one turned by the difference of their slopes.
//! [BlancoLorenzo2016, as the first variant of CONTACT]

use std::sync::Arc;

use mtb_geometry::{PlaneChange, PlaneGap, Rows, WheelOverRail};
use nalgebra::{Matrix3, Vector3};

use crate::error::Error;
use crate::linear::KinematicsChange;
use crate::rolling::{Flow, Kinematics};
use crate::track::{Moved, RailDeviation, about};

/// Slope angles of a rail at all of its rows.
#[derive(Debug)]
pub(crate) struct Slopes {
    /// The first row, in spacings.
    first: i64,
    /// [rad]
    angles: Vec<f64>,
    /// Distance of the rows [m].
    spacing: f64,
}

impl Slopes {
    pub(crate) fn of(over: &WheelOverRail, spacing: f64) -> Result<Arc<Self>, Error> {
        let (first, Rows { angles, .. }) = over.rows_of_rail(spacing)?;
        Ok(Arc::new(Self {
            first,
            angles,
            spacing,
        }))
    }

    /// At a row, or between two.
    fn at(&self, line: f64) -> f64 {
        let last = (self.angles.len() - 1) as f64;
        let at = (line - self.first as f64).clamp(0.0, last);
        let from = at.floor().min((last - 1.0).max(0.0));
        let [a, b] = [from, (from + 1.0).min(last)].map(|k| self.angles[k as usize]);
        a + (at - from) * (b - a)
    }
}

/// The slopes of a grid of cells, as seen from its first row.
#[derive(Clone, Debug)]
pub(crate) struct Incline {
    slopes: Arc<Slopes>,
    /// The first row, and whether rows are seen from the other side.
    first: i64,
    is_backwards: bool,
}

impl Incline {
    pub(crate) fn new(slopes: &Arc<Slopes>, first: i64, is_backwards: bool) -> Self {
        Self {
            slopes: slopes.clone(),
            first,
            is_backwards,
        }
    }

    /// What tells it from others of the same wheelset: the rail by where its slopes are kept, which outlive what is made
    /// of them.
    pub(crate) fn key(&self) -> (usize, i64, bool) {
        let rail = Arc::as_ptr(&self.slopes) as usize;
        (rail, self.first, self.is_backwards)
    }

    /// Slope [rad] so far [m] from the first row.
    pub(crate) fn at(&self, y: f64) -> f64 {
        let sense = if self.is_backwards { -1.0 } else { 1.0 };
        sense * (self.slopes).at(self.first as f64 + sense * y / self.slopes.spacing)
    }
}

/// A row of a patch: its place at the x of the origin [m], the directions along, across and normal to the surface between
/// rail and wheel, and how deep below it the undeformed surface of the wheel lies, whose velocity counts [m].
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowFrame {
    pub(crate) place: Vector3<f64>,
    pub(crate) turn: Matrix3<f64>,
    pub(crate) depth: f64,
}

impl RowFrame {
    /// The place on the wheel whose velocity counts.
    pub(crate) fn on_wheel(&self) -> Vector3<f64> {
        self.place - self.turn.column(2) * self.depth
    }

    /// Change of [`RowFrame::on_wheel`].
    pub(crate) fn on_wheel_change(&self, by: &Self) -> Vector3<f64> {
        by.place - by.turn.column(2) * self.depth - self.turn.column(2) * by.depth
    }
}

/// The rows of a patch that has any, in the track, as of a left wheel.
pub(crate) fn frames(plane: &PlaneGap) -> Option<Vec<RowFrame>> {
    let rows = plane.rows.as_ref()?;
    let approach = plane.approach();
    let each = rows.places.iter().zip(&rows.between).enumerate();
    let frame = |(row, ([y, z], angle)): (usize, (&[f64; 2], &f64))| RowFrame {
        place: Vector3::new(plane.position[0], *y, *z),
        turn: about(0, *angle),
        depth: plane.gap_of_row(row).map_or(approach, |gap| -gap),
    };
    Some(each.map(frame).collect())
}

/// Changes of [`frames`] with the place of the rail, and with that of the patch along it [m] and of its gap.
pub(crate) fn frame_changes(
    (plane, frames): (&PlaneGap, &[RowFrame]),
    (rail, by): (&Moved, &RailDeviation),
    (by_along, moved): (f64, Option<&PlaneChange>),
) -> Vec<RowFrame> {
    let turned = rail.turn_change(by.place[2]) * rail.turn.transpose();
    let column = -plane.first[0];
    let bent = Vector3::x().cross_matrix();
    let changed = |(row, frame): (usize, &RowFrame)| RowFrame {
        place: rail.point_change(by, rail.seen(frame.place), Vector3::zeros())
            + Vector3::x() * by_along,
        turn: (turned + bent * moved.map_or(0.0, |moved| moved.between[row])) * frame.turn,
        depth: (plane.gap_of_row(row).zip(moved)).map_or(0.0, |(_, moved)| {
            -moved.gap[row * plane.nx + column as usize]
        }),
    };
    frames.iter().enumerate().map(changed).collect()
}

/// The row nearest to the origin of a patch, in spacings: that about which its spin counts.
pub(crate) fn middle(rows: &Rows, dy: f64) -> i64 {
    (rows.arc / dy).round() as i64
}

/// Velocity along and across a row and spin [m/s], [rad/s], less those of the plane of its patch.
pub(crate) type RowSlip = [f64; 3];

impl Kinematics {
    /// What each row of a patch slips beside the plane.
    pub(crate) fn row_slips(&self, plane: &PlaneGap, dy: f64) -> Option<Vec<RowSlip>> {
        let rows = plane.rows.as_ref()?;
        let first = plane.first[1] - middle(rows, dy);
        let [along, across, spin] = self.creepage.map(|c| c * self.speed);
        let slips = frames(plane)?.into_iter().enumerate().map(|(row, frame)| {
            let (rigid, turning) = self.flow.at(frame.on_wheel(), frame.place);
            let own = frame.turn.transpose() * rigid;
            let y = (first + row as i64) as f64 * dy;
            [
                own.x - (along - spin * y),
                own.y - across,
                frame.turn.column(2).dot(&turning) - spin,
            ]
        });
        Some(slips.collect())
    }

    /// Change of [`Kinematics::row_slips`].
    pub(crate) fn row_slips_change(
        &self,
        (plane, dy): (&PlaneGap, f64),
        (frames, by_frames): (&[RowFrame], &[RowFrame]),
        (by_flow, by): (&Flow, &KinematicsChange),
    ) -> Vec<RowSlip> {
        let middle = plane.rows.as_ref().map_or(0, |rows| middle(rows, dy));
        let each = frames.iter().zip(by_frames).zip(plane.first[1] - middle..);
        each.map(|((frame, by_frame), line)| {
            let [normal, by_normal] = [frame, by_frame].map(|f| f.turn.column(2).into_owned());
            let (on_wheel, by_on_wheel) = (frame.on_wheel(), frame.on_wheel_change(by_frame));
            let (rigid, turning) = self.flow.at(on_wheel, frame.place);
            let (by_rigid, by_turning) = self.flow.change_at(
                by_flow,
                [on_wheel, by_on_wheel],
                [frame.place, by_frame.place],
            );
            let own = by_frame.turn.transpose() * rigid + frame.turn.transpose() * by_rigid;
            let y = line as f64 * dy;
            [
                own.x - (by.by_slip[0] - by.by_spin * y),
                own.y - by.by_slip[1],
                by_normal.dot(&turning) + normal.dot(&by_turning) - by.by_spin,
            ]
        })
        .collect()
    }
}

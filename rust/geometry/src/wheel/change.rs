// SPDX-License-Identifier: MIT OR Apache-2.0
//! How a contact plane and the gap over it change with the pose of the wheel.

use std::ops::Range;

use nalgebra::{Vector2, Vector3};
use rayon::prelude::*;

use super::middle::Middle;
use super::over::{Outline, Spokes, Station, WheelOverRail, WheelPose, met};
use super::plane::{PlaneGap, RailCut, Row, STEEPEST, WheelCut};
use super::roller::Roller;
use super::uneven;
use crate::Error;

/// Change of a [`PlaneGap`] by a change of the pose.
///
/// The points of the grid go with the origin of the plane and turn with it; rows that follow the rail go along it with
/// the origin, and stay where they are across. The stations of the wheel that overlap, and
/// the lines of the grid, stay the same.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneChange {
    /// Of the origin [m].
    pub position: [f64; 3],
    /// Of the angle about the axis of the roller [rad].
    pub roller_angle: f64,
    /// Of the slope angle [rad].
    pub angle: f64,
    /// Of the origin on the rail profile [m].
    pub rail_position: f64,
    /// Of the origin on the wheel profile [m].
    pub wheel_position: f64,
    /// Of the gap (ny * nx) [m]; 0 where a body is missing.
    pub gap: Vec<f64>,
    /// Of the rail profile's y of each row (ny) [m].
    pub rail_positions: Vec<f64>,
    /// Of the slope angles between rail and wheel (ny) [rad], where the patch has rows; otherwise empty.
    pub between: Vec<f64>,
}

/// Change of the outline at the stations of a part.
pub(super) struct OutlineChange {
    pub(super) points: Vec<Vector3<f64>>,
    pub(super) clearance: Vec<f64>,
    pub(super) angle: Vec<f64>,
}

/// The directions about an axle, and the changes of these, of the middle of the axle and of the turn about it.
pub(super) struct AxleChange {
    axle: Vector3<f64>,
    pub(super) along: Vector3<f64>,
    pub(super) down: Vector3<f64>,
    length: f64,
    pub(super) by_centre: Vector3<f64>,
    pub(super) by_axle: Vector3<f64>,
    pub(super) by_along: Vector3<f64>,
    pub(super) by_down: Vector3<f64>,
    pub(super) by_turn: f64,
    by_length: f64,
}

impl AxleChange {
    fn new(axle: Vector3<f64>, by: &WheelPose) -> Self {
        let (by_centre, by_axle) = (Vector3::from(by.centre), Vector3::from(by.axle));
        let length = (1.0 - axle.x * axle.x).sqrt();
        let by_length = -axle.x * by_axle.x / length;
        let along = (Vector3::x() - axle.x * axle) / length;
        let by_along = -(by_axle.x * axle + axle.x * by_axle + along * by_length) / length;
        Self {
            axle,
            along,
            down: axle.cross(&along),
            length,
            by_centre,
            by_axle,
            by_along,
            by_down: by_axle.cross(&along) + axle.cross(&by_along),
            by_turn: by.turn,
            by_length,
        }
    }

    /// Change of the angle [rad] about the axle, > 0 forwards from down, of a direction `out` across it that changes.
    pub(super) fn angle_of(&self, out: &Vector3<f64>, by_out: &Vector3<f64>) -> f64 {
        let [ahead, down] = [self.along, self.down].map(|direction| out.dot(&direction));
        let [by_ahead, by_down] = [(self.along, self.by_along), (self.down, self.by_down)]
            .map(|(direction, by)| by_out.dot(&direction) + out.dot(&by));
        (down * by_ahead - ahead * by_down) / (ahead * ahead + down * down)
    }

    /// Change of [`WheelOverRail::lowest_of`] at a station so far `out` on the axle.
    fn lowest_of(&self, station: &Station, out: f64) -> Vector3<f64> {
        let turned = station.slope * self.axle.x / self.length;
        let sin = turned.clamp(-1.0, 1.0);
        let cos = (1.0 - sin * sin).sqrt();
        let by_sin = station.slope * (self.by_axle.x - self.axle.x * self.by_length / self.length)
            / self.length;
        // where the wheel is vertical, its edge counts
        let [by_sin, by_cos] = if turned.abs() < 1.0 {
            [by_sin, -sin * by_sin / cos]
        } else {
            [0.0; 2]
        };
        self.by_centre
            + self.by_axle * out
            + (self.by_down * cos + self.down * by_cos + self.by_along * sin + self.along * by_sin)
                * station.radius
    }
}

impl WheelOverRail {
    /// Change of a plane by a change of the pose that it was found at, exactly.
    ///
    /// `pose` as for [`WheelOverRail::patches`], `spacing` that of the plane, `by` the change of centre [m], direction of
    /// the axle [-] and turn [rad]. With slices, footprints are sums over places along the track, and their change is that
    /// of the sums over the same places, to their accuracy.
    ///
    /// # Errors
    /// As of [`WheelOverRail::overlap`].
    ///
    /// # Example
    /// ```
    /// use mtb_geometry::{Profile, WheelOnRail, WheelOverRail, WheelPose};
    /// let pair = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    /// let wheel = WheelOverRail::new(&pair)?;
    /// let height = wheel.first_height() + pair.wheel_radius - 50e-6;
    /// let pose = WheelPose::new([0.0, 0.0, height], [0.0, 1.0, 0.0]);
    /// let [plane] = &wheel.patches(pose, [1e-3; 2])?[..] else { panic!() };
    /// // a millimetre along the rail takes all of it along
    /// let ahead = wheel.change(plane, pose, [1e-3; 2], WheelPose::new([1e-3, 0.0, 0.0], [0.0; 3]))?;
    /// assert!((ahead.position[0] - 1e-3).abs() < 1e-12 && ahead.angle.abs() < 1e-12);
    /// // a lowered wheel closes the gap by as much, but for the inclination of the plane
    /// let down = wheel.change(plane, pose, [1e-3; 2], WheelPose::new([0.0, 0.0, -1e-6], [0.0; 3]))?;
    /// assert!(down.gap.iter().any(|g| (g + 1e-6 * plane.angle.cos()).abs() < 1e-8));
    /// # Ok::<(), mtb_geometry::Error>(())
    /// ```
    pub fn change(
        &self,
        plane: &PlaneGap,
        pose: WheelPose,
        spacing: [f64; 2],
        by: WheelPose,
    ) -> Result<PlaneChange, Error> {
        let outline = self.outline(&pose)?;
        let part = plane.part.clone();
        let points = &outline.points[part.clone()];
        let slope = &outline.angle[part.clone()];
        let stations = &self.stations[part.clone()];
        let overlap: Vec<f64> = outline.clearance[part.clone()].iter().map(|c| -c).collect();
        let across: Vec<f64> = points.iter().map(|p| p.y).collect();
        let squares: Option<Vec<f64>> = (outline.footprints.as_ref())
            .map(|all| all[part.clone()].iter().map(|one| one.squares).collect());
        let (moved, by_squares) = self.stations_change(&outline, part, &pose, &by)?;
        let by_overlap: Vec<f64> = moved.clearance.iter().map(|c| -c).collect();
        let by_across: Vec<f64> = moved.points.iter().map(|p| p.y).collect();

        let middle = Middle::new(&overlap, &across, slope, squares.as_deref());
        let mean = middle.mean_change(
            [&overlap, &across, slope],
            [&by_overlap, &by_across, &moved.angle],
            squares.as_deref().map(|squares| [squares, &by_squares]),
        );
        let angle = mean(&|k| slope[k], &|k| moved.angle[k]);
        let by_across = mean(&|k| across[k], &|k| by_across[k]);
        let along = mean(&|k| points[k].x, &|k| moved.points[k].x);
        let wheel_position = mean(&|k| stations[k].position, &|_| 0.0);
        let rail = self.rail_at_own(plane.position[0], plane.rail_position);
        let [rail_position, by_y, by_z] = if self.rail_slices.is_some() {
            self.below_change(&rail, along, by_across)
        } else {
            let (sin, cos) = (self.placement.sin, self.placement.cos);
            let at = middle.mean(&|k| across[k]);
            let by_own = self.rates_on_head(at)[2] * by_across;
            let rise = rail.slope;
            [
                by_own,
                (cos - sin * rise) * by_own,
                (sin + cos * rise) * by_own,
            ]
        };
        let (mut position, mut roller_angle) = (Vector3::new(along, by_y, by_z), 0.0);
        let (gap, rail_positions) = if let Some(roller) = self.roller {
            // as seen from the angle of the plane, which changes
            roller_angle = along / roller.radius;
            let at = plane.roller_angle;
            let mut seen = plane.clone();
            let origin = roller.seen(at, plane.position.into());
            seen.position = origin.into();
            position.x = 0.0;
            let by = Self::seen_change(roller, (at, roller_angle), &pose, &by);
            let pose = roller.pose(at, &pose);
            let found = self.gap_change(&seen, &pose, spacing, &by, (position, angle));
            position = roller.seen_change((-at, -roller_angle), (origin, position));
            found
        } else {
            self.gap_change(plane, &pose, spacing, &by, (position, angle))
        };
        Ok(PlaneChange {
            between: self.between_change(plane, &pose, &by, along),
            position: position.into(),
            roller_angle,
            angle,
            rail_position,
            wheel_position,
            gap,
            rail_positions: rail_positions
                .into_iter()
                .map(|of_row| of_row.unwrap_or(rail_position))
                .collect(),
        })
    }

    /// Change [m] of [`WheelOverRail::overlap`] by each of several changes of the pose, as of
    /// [`WheelOverRail::change`], where one place stays the lowest.
    ///
    /// # Errors
    /// As of [`WheelOverRail::overlap`].
    ///
    /// # Example
    /// ```
    /// use mtb_geometry::{Profile, WheelOnRail, WheelOverRail, WheelPose};
    /// let pair = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    /// let wheel = WheelOverRail::new(&pair)?;
    /// let pose = WheelPose::new([0.0, 0.0, pair.wheel_radius], [0.0, 1.0, 0.0]);
    /// let down = WheelPose::new([0.0, 0.0, -1e-3], [0.0; 3]);
    /// assert!((wheel.overlap_change(pose, &[down])?[0] - 1e-3).abs() < 1e-15);
    /// # Ok::<(), mtb_geometry::Error>(())
    /// ```
    pub fn overlap_change(&self, pose: WheelPose, by: &[WheelPose]) -> Result<Vec<f64>, Error> {
        let outline = self.outline(&pose)?;
        let clearance = |k: &usize| outline.clearance[*k];
        let lowest = (0..self.stations.len())
            .min_by(|a, b| clearance(a).total_cmp(&clearance(b)))
            .unwrap_or(0);
        let part = lowest..lowest + 1;
        let changes = by.iter().map(|by| {
            let moved = self.stations_change(&outline, part.clone(), &pose, by)?.0;
            Ok(-moved.clearance[0])
        });
        changes.collect()
    }

    /// Change of the outline at the stations of a part, and, with slices, what the squares of the overlap over the
    /// footprints change by.
    fn stations_change(
        &self,
        outline: &Outline,
        part: Range<usize>,
        pose: &WheelPose,
        by: &WheelPose,
    ) -> Result<(OutlineChange, Vec<f64>), Error> {
        if outline.footprints.is_none() {
            let points = &outline.points[part.clone()];
            return Ok((self.outline_change(part, points, pose, by), Vec::new()));
        }
        let nominal = self.nominal_outline(pose)?;
        let own = &nominal.points[part.clone()];
        let by_nominal = self.outline_change(part.clone(), own, pose, by);
        let by = AxleChange::new(pose.axle.into(), by);
        Ok(uneven::change(
            self,
            (&nominal, &by_nominal),
            part,
            pose,
            &by,
        ))
    }

    /// Change of centre and axle as seen from an angle about the roller.
    fn seen_change(
        roller: Roller,
        (angle, by_angle): (f64, f64),
        pose: &WheelPose,
        by: &WheelPose,
    ) -> WheelPose {
        let of_axle = |by: Vector3<f64>| {
            let axle = Vector3::from(pose.axle);
            // a direction, which has no place
            let [from, by_from] = [roller.centre(), Vector3::zeros()];
            let end = roller.seen_change((angle, by_angle), (from + axle, by_from + by));
            end - roller.seen_change((angle, by_angle), (from, by_from))
        };
        let by_centre = (pose.centre.into(), by.centre.into());
        let mut change = WheelPose {
            centre: roller.seen_change((angle, by_angle), by_centre).into(),
            axle: of_axle(by.axle.into()).into(),
            turn: by.turn,
        };
        // and by how much what points down from there turns about the axle
        let own = AxleChange::new(pose.axle.into(), by);
        let seen = AxleChange::new(roller.pose(angle, pose).axle.into(), &change);
        let back = super::roller::turn(angle);
        let down = back * seen.down;
        let by_down = back * seen.by_down + by_angle * Vector3::y().cross(&down);
        change.turn += own.angle_of(&down, &by_down);
        change
    }

    /// Of the points where the prism can touch the wheel, and of what lies below them.
    fn outline_change(
        &self,
        part: Range<usize>,
        points: &[Vector3<f64>],
        pose: &WheelPose,
        by: &WheelPose,
    ) -> OutlineChange {
        let (centre, axle) = (Vector3::from(pose.centre), Vector3::from(pose.axle));
        let n = part.len();
        let mut change = OutlineChange {
            points: Vec::with_capacity(n),
            clearance: Vec::with_capacity(n),
            angle: Vec::with_capacity(n),
        };
        let on_rail = AxleChange::new(axle, by);
        for (station, point) in self.stations[part].iter().zip(points) {
            let by_point = if let Some(roller) = self.roller {
                let station = met(station, axle);
                let out = self.tape + station.position;
                let arm = out + station.slope * station.radius;
                let on_axle = self.on_axle(&station, centre, axle);
                let [by_centre, by_axle] = [by.centre, by.axle].map(Vector3::from);
                let by_angle = roller.angle_change(on_axle, by_centre + by_axle * arm);
                let angle = point.x / roller.radius;
                let by = Self::seen_change(roller, (angle, by_angle), pose, by);
                let mut by_point = AxleChange::new(super::roller::turn(-angle) * axle, &by)
                    .lowest_of(&station, out);
                by_point.x = roller.radius * by_angle;
                by_point
            } else {
                on_rail.lowest_of(station, self.tape + station.position)
            };
            let [rise, bend, _] = self.rates_on_head(point.y);
            change.clearance.push(by_point.z - rise * by_point.y);
            change.angle.push(bend * by_point.y);
            change.points.push(by_point);
        }
        change
    }

    /// Of the slope angles between rail and wheel at the rows of a patch whose origin moves along the rail.
    fn between_change(
        &self,
        plane: &PlaneGap,
        pose: &WheelPose,
        by: &WheelPose,
        along: f64,
    ) -> Vec<f64> {
        let Some(rows) = &plane.rows else {
            return Vec::new();
        };
        let (centre, spokes) = (Vector3::from(pose.centre), Spokes::of(pose));
        let by = AxleChange::new(pose.axle.into(), by);
        let of_row = |(row, [y, z]): (usize, &[f64; 2])| {
            let angle = rows.angles[row];
            let wheel = WheelCut::new(
                self,
                spokes,
                Row {
                    foot: Vector2::new(*y, *z),
                    angle,
                }
                .normal(),
            );
            let base = Vector3::new(plane.position[0], *y, *z) - centre;
            let by_base = Vector3::x() * along - by.by_centre;
            let Some(distance) = wheel.distance(base, 0.0) else {
                return 0.0;
            };
            let place = base + wheel.normal * distance;
            let by_place = by_base + wheel.normal * wheel.distance_change(place, by_base, &by);
            0.5 * wheel.slope_angle_change(place, by_place, by.by_axle)
        };
        rows.places.iter().enumerate().map(of_row).collect()
    }

    /// Of the gap at the points of a plane whose origin and angle change, and of the rail of each row.
    fn gap_change(
        &self,
        plane: &PlaneGap,
        pose: &WheelPose,
        spacing: [f64; 2],
        by: &WheelPose,
        (by_position, by_angle): (Vector3<f64>, f64),
    ) -> (Vec<f64>, Vec<Option<f64>>) {
        let centre = Vector3::from(pose.centre);
        let position = Vector3::from(plane.position);
        let spokes = Spokes::of(pose);
        let by = AxleChange::new(pose.axle.into(), by);
        let mut gap = vec![0.0; plane.gap.len()];
        let mut rail_positions = vec![None; plane.ny];
        gap.par_chunks_mut(plane.nx)
            .zip(plane.gap.par_chunks(plane.nx))
            .zip(&mut rail_positions)
            .enumerate()
            .for_each(|(row, ((change, gap), of_row))| {
                let at = plane.row(row, spacing[1]);
                let (foot, normal) = (at.foot, at.normal());
                // rows that follow the rail stay where they are
                let (by_foot, by_normal) = if plane.rows.is_some() {
                    (Vector2::zeros(), Vector3::zeros())
                } else {
                    let away = foot - position.yz();
                    let turned = Vector2::new(-away.y, away.x) * by_angle;
                    (
                        by_position.yz() + turned,
                        Vector3::new(0.0, -normal.z, normal.y) * by_angle,
                    )
                };
                let rail = RailCut::new(self, normal);
                let wheel = WheelCut::new(self, spokes, normal);
                let met = |x: f64| {
                    let below = rail.below(x, foot)?;
                    let there = self.rail_at_own(x, below.rail_position);
                    let rise = there.slope;
                    let up = foot.y + normal.z * below.distance;
                    let by_z = (self.roller).map_or(1.0, |roller| roller.raised(x, up)[1]);
                    let seen = |v: Vector2<f64>| rail.own(Vector2::new(v.x, v.y * by_z));
                    let (drift, ahead) = (
                        seen(by_foot + by_normal.yz() * below.distance),
                        seen(normal.yz()),
                    );
                    let rate = (ahead.y - rise * ahead.x).max(STEEPEST);
                    let missed = drift.y - rise * drift.x - there.rate * by_position.x;
                    let by_below = -missed / rate;
                    Some((below.distance, by_below, drift.x + ahead.x * by_below))
                };
                // a straight rail is a prism, so that one place is enough for a row
                let Some((own_below, own_by_below, by_rail_position)) = met(position.x) else {
                    return;
                };
                *of_row = Some(by_rail_position);
                for (i, (change, gap)) in change.iter_mut().zip(gap).enumerate() {
                    let x = (plane.first[0] + i as i64) as f64 * spacing[0];
                    let (mut below, mut by_below) = (own_below, own_by_below);
                    if self.roller.is_some() || self.rail_slices.is_some() {
                        let Some((here, by_here, _)) = met(position.x + x) else {
                            continue;
                        };
                        (below, by_below) = (here, by_here);
                    }
                    let base = Vector3::new(position.x + x, foot.x, foot.y) - centre;
                    let by_base = Vector3::new(by_position.x, by_foot.x, by_foot.y) - by.by_centre;
                    // the wheel is met again where it was found
                    let Some(above) = wheel.distance(base, gap + below) else {
                        continue;
                    };
                    let reach = base + normal * above;
                    let by_reach = by_base + by_normal * above;
                    *change = wheel.distance_change(reach, by_reach, &by) - by_below;
                }
            });
        (gap, rail_positions)
    }
}

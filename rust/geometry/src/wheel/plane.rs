// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contact plane of a posed wheel, and the gap over it; or over rows of cells that follow the rail.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{Vector2, Vector3};
use rayon::prelude::*;

use super::change::AxleChange;
use super::middle::Middle;
use super::over::{Outline, Spokes, WheelOverRail, WheelPose, height_and_slope};
use super::roller::Roller;
use super::section::touching;
use crate::{Error, Profile, Slices};

/// Gap [m] where there is no body.
const NOTHING: f64 = 1e-2;
/// Points of a patch from which on the spacing is taken for a mistake.
const MOST_POINTS: f64 = 1e6;
/// Points that a thread of its own is worth.
const POINTS_A_THREAD: usize = 10_000;
/// Steps of Newton's method towards a surface, the distance [m] at which they end, the longest of them [m],
/// the least cosine between surface and plane, and the distance at which a surface counts as found.
const MOST_STEPS: usize = 15;
const CLOSE: f64 = 1e-13;
const LONGEST: f64 = 2e-3;
pub(super) const STEEPEST: f64 = 0.05;
const FOUND: f64 = 1e-9;

/// Rows of cells that follow the running surface of a straight rail, which they do not leave as the wheel moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    /// Arc length on the rail, as of [`Profile::arc_length`], of the origin of the patch [m].
    pub arc: f64,
    /// y, z in the track of each row (ny) [m].
    pub places: Vec<[f64; 2]>,
    /// Slope angle of the rail there (ny) [rad], along whose normal the gap is told.
    pub angles: Vec<f64>,
    /// Mean of the slope angles of rail and wheel (ny) [rad]: that of the surface between them when they are pressed
    /// together, if they are alike. That of the rail where the wheel is not.
    pub between: Vec<f64>,
}

/// Whether a patch lies on a plane, or follows the rail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ground {
    Plane,
    Rail,
}

/// The gap over a contact plane of a wheel in a given pose, or over rows that follow the rail beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneGap {
    /// Origin of the plane, on the rail, in the track [m].
    pub position: [f64; 3],
    /// Angle about the axis of the roller at which the plane lies and stands upright [rad], > 0 ahead of its top; 0 on a
    /// rail.
    pub roller_angle: f64,
    /// Slope angle of the plane [rad], > 0 where it rises to the field side (flange contact).
    pub angle: f64,
    /// y of the origin in the rail profile's own frame [m].
    pub rail_position: f64,
    /// y of the origin in the wheel profile's own frame [m].
    pub wheel_position: f64,
    /// First point along x and across, in spacings from the origin; with `rows`, across from the origin of the arc
    /// length on the rail.
    pub first: [i64; 2],
    /// Points along x.
    pub nx: usize,
    /// Points across.
    pub ny: usize,
    /// Where the patch follows the rail: its rows.
    pub rows: Option<Rows>,
    /// Distance along the normal of the plane or of the row (ny * nx) [m], x fastest, negative where the undeformed
    /// bodies overlap; 10 mm where a body is missing.
    pub gap: Vec<f64>,
    /// y of the rail profile along the normal of each row (ny) [m]; that of the origin where there is no rail.
    pub rail_positions: Vec<f64>,
    /// Share of the estimated contact area inclined by more than 20 degrees to the plane, which it does not
    /// represent [-]; 0 with `rows`.
    pub neglected: f64,
    /// The stations of the wheel that overlap.
    pub(super) part: Range<usize>,
}

impl PlaneGap {
    /// Largest overlap of the undeformed bodies along the normal of the plane [m]: their approach; negative
    /// where they are apart.
    pub fn approach(&self) -> f64 {
        -self.gap.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Distance of the first row from the origin across the patch [m], along the rail where it has `rows` of the
    /// distance `dy` [m].
    pub fn first_across(&self, dy: f64) -> f64 {
        self.first[1] as f64 * dy - self.rows.as_ref().map_or(0.0, |rows| rows.arc)
    }

    /// Distance of the wheel along the normal of a row at the x of the origin [m]; `None` where the wheel is not there, or
    /// the row ends before.
    pub fn gap_of_row(&self, row: usize) -> Option<f64> {
        let column = usize::try_from(-self.first[0]).ok()?;
        let gap = self.gap[row * self.nx..(row + 1) * self.nx].get(column)?;
        (*gap < NOTHING).then_some(*gap)
    }

    /// Place (y, z) in the track and slope angle of a row, `dy` [m] apart.
    pub(super) fn row(&self, row: usize, dy: f64) -> Row {
        if let Some(rows) = &self.rows {
            let [y, z] = rows.places[row];
            return Row {
                foot: Vector2::new(y, z),
                angle: rows.angles[row],
            };
        }
        let [_, y, z] = self.position;
        Row::on_plane(
            Vector2::new(y, z),
            self.angle,
            (self.first[1] + row as i64) as f64 * dy,
        )
    }
}

/// Where a row of points is seen from, and along which normal.
#[derive(Clone, Copy)]
pub(super) struct Row {
    /// y, z in the track [m].
    pub(super) foot: Vector2<f64>,
    /// Slope angle [rad].
    pub(super) angle: f64,
}

impl Row {
    /// So far [m] from the origin of a plane.
    fn on_plane(origin: Vector2<f64>, angle: f64, across: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self {
            foot: origin + Vector2::new(cos, sin) * across,
            angle,
        }
    }

    pub(super) fn normal(&self) -> Vector3<f64> {
        let (sin, cos) = self.angle.sin_cos();
        Vector3::new(0.0, -sin, cos)
    }
}

/// The plane for the `part` of the outline's stations that overlap; the pose is the centre and the direction
/// of the axle.
pub(super) fn over(
    pair: &WheelOverRail,
    outline: &Outline,
    part: Range<usize>,
    pose: &WheelPose,
    (spacing, ground): ([f64; 2], Ground),
) -> Result<PlaneGap, Error> {
    let points = &outline.points[part.clone()];
    let slope = &outline.angle[part.clone()];
    let stations = &pair.stations[part.clone()];
    let overlap: Vec<f64> = outline.clearance[part.clone()].iter().map(|c| -c).collect();
    let n = points.len();
    let footprints = outline.footprints.as_ref().map(|all| &all[part.clone()]);
    if footprints.is_none() {
        refuse_ends(pair, points, stations[0].position, stations[n - 1].position)?;
    } else {
        for k in [0, n - 1] {
            let seen = pair.roller.map(|roller| {
                let angle = points[k].x / roller.radius;
                let at = Vector3::new(0.0, points[k].y, points[k].z);
                (at, roller.pose(angle, pose))
            });
            let (point, pose) = match &seen {
                Some((point, pose)) => (point, pose),
                None => (&points[k], pose),
            };
            refuse_sliced_end(pair, point, stations[k].position, pose)?;
        }
    }

    let aside: Vec<f64> = points.iter().map(|p| p.y).collect();
    let squares: Option<Vec<f64>> =
        footprints.map(|all| all.iter().map(|footprint| footprint.squares).collect());
    let middle = Middle::new(&overlap, &aside, slope, squares.as_deref());
    let is_near = &middle.is_near;
    let mean = |value: &dyn Fn(usize) -> f64| middle.mean(value);
    let angle = mean(&|k| slope[k]);
    let along = mean(&|k| points[k].x);
    // as seen from the angle about the roller where the plane stands upright
    let roller_angle = pair.roller.map_or(0.0, |roller| along / roller.radius);
    let (pose, along) = match pair.roller {
        Some(roller) => (&roller.pose(roller_angle, pose), 0.0),
        None => (pose, along),
    };
    let way = |k: usize, x: f64| {
        pair.roller.map_or(x, |roller| {
            (1.0 + points[k].z / roller.radius) * (x - roller.radius * roller_angle)
        })
    };
    let rail_position = pair.rail_below(along, mean(&|k| points[k].y));
    let height = pair.rail_at_own(along, rail_position).height;
    let [across, up] = pair.placement.place(rail_position, height);
    let position = Vector3::new(along, across, up);
    let wheel_position = mean(&|k| stations[k].position);
    let follows = ground == Ground::Rail;
    let neglected = if follows {
        0.0
    } else {
        middle.neglected(&overlap, &aside, slope)
    };
    let arc_of = |position: f64| -> Result<f64, Error> {
        let [low, high] = pair.rail.range();
        Ok(pair.rail.arc_length(&[position.clamp(low, high)])?[0])
    };

    // no pressure lies beyond the overlap of the undeformed bodies
    let (sin, cos) = angle.sin_cos();
    let mut reach = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for k in touching(n, |k| overlap[k] > 0.0, |k| follows || is_near[k]) {
        let [first, last] = footprints.map_or_else(
            || {
                let half = (2.0 * pair.joined_radius() * overlap[k]).sqrt();
                [points[k].x - half, points[k].x + half]
            },
            |all| all[k].ends,
        );
        let [first, last] = [first, last].map(|x| way(k, x));
        let below = if footprints.is_some() {
            let own = pair.rail_below(points[k].x, points[k].y);
            let height = pair.rail_at_own(points[k].x, own).height;
            pair.placement.place(own, height)[1]
        } else {
            pair.on_head(points[k].y).0
        };
        let t = if follows {
            arc_of(pair.rail_below(points[k].x, points[k].y))?
        } else {
            cos * (points[k].y - across) + sin * (below - up)
        };
        reach[0] = [
            reach[0][0].min(first - position.x),
            reach[0][1].max(last - position.x),
        ];
        reach[1] = [reach[1][0].min(t), reach[1][1].max(t)];
    }
    let lines = [0, 1].map(|c| {
        let [low, high] = reach[c].map(|r| r / spacing[c]);
        (low.floor() - 1.0, high.ceil() - low.floor() + 3.0)
    });
    let size = lines.map(|(_, count)| count);
    let is_accepted = size[0] * size[1] <= MOST_POINTS;
    if !is_accepted {
        return Err(Error::TooManyPoints {
            nx: size[0],
            ny: size[1],
            dx: spacing[0],
            dy: spacing[1],
            most: MOST_POINTS,
        });
    }
    let [x, y] = [0, 1].map(|c| -> Vec<f64> {
        let (first, count) = lines[c];
        (0..count as usize)
            .map(|k| (first + k as f64) * spacing[c])
            .collect()
    });
    let (rows, lines_across) = if follows {
        let (rows, feet) = on_rail(pair, &y, arc_of(rail_position)?)?;
        (Some(rows), feet)
    } else {
        let origin = position.yz();
        let feet = y.iter().map(|y| Row::on_plane(origin, angle, *y));
        (None, feet.collect())
    };
    let (gap, rail) = gap(pair, position, &x, &lines_across, pose);
    let rows = rows.map(|rows| {
        let above = lines_across.iter().map(|row| {
            let wheel = WheelCut::new(pair, Spokes::of(pose), row.normal());
            let base =
                Vector3::new(position.x, row.foot.x, row.foot.y) - Vector3::from(pose.centre);
            let distance = wheel.distance(base, 0.0)?;
            Some(wheel.slope_angle(base + wheel.normal * distance))
        });
        let between = (above.zip(&rows.angles))
            .map(|(above, rail)| above.map_or(*rail, |above| 0.5 * (above + rail)))
            .collect();
        Rows { between, ..rows }
    });
    let of_row = |rail: Option<Below>| rail.map_or(rail_position, |below| below.rail_position);
    let position = (pair.roller).map_or(position, |roller| roller.place(roller_angle, position));
    Ok(PlaneGap {
        position: position.into(),
        roller_angle,
        angle,
        rail_position,
        wheel_position,
        first: lines.map(|(first, _)| first as i64),
        nx: x.len(),
        ny: y.len(),
        rows,
        gap,
        rail_positions: rail.into_iter().map(of_row).collect(),
        neglected,
        part,
    })
}

/// All rows of a rail, `spacing` [m] apart, and the number of the first.
pub(super) fn all_rows(pair: &WheelOverRail, spacing: f64) -> Result<(i64, Rows), Error> {
    let [low, high] = pair.rail.arc_range();
    let [first, last] = [(low / spacing).ceil(), (high / spacing).floor()];
    let count = last - first + 1.0;
    let is_accepted = (1.0..=MOST_POINTS).contains(&count);
    if !is_accepted {
        return Err(Error::TooManyPoints {
            nx: 1.0,
            ny: count,
            dx: spacing,
            dy: spacing,
            most: MOST_POINTS,
        });
    }
    let lengths: Vec<f64> = (0..count as usize)
        .map(|k| (first + k as f64) * spacing)
        .collect();
    let (rows, _) = on_rail(pair, &lengths, 0.0)?;
    Ok((first as i64, rows))
}

/// Rows at arc lengths on the rail [m]; the nearest place of the rail beyond its ends. `arc`: that of the origin.
fn on_rail(pair: &WheelOverRail, lengths: &[f64], arc: f64) -> Result<(Rows, Vec<Row>), Error> {
    let [low, high] = pair.rail.arc_range();
    let lengths: Vec<f64> = lengths.iter().map(|s| s.clamp(low, high)).collect();
    let feet: Vec<Row> = (pair.rail.position(&lengths)?.into_iter())
        .map(|position| {
            let [height, slope] = height_and_slope(&pair.rail, position);
            let (sin, cos) = (pair.placement.sin, pair.placement.cos);
            Row {
                foot: pair.placement.place(position, height).into(),
                angle: (sin + cos * slope).atan2(cos - sin * slope),
            }
        })
        .collect();
    let rows = Rows {
        arc,
        places: feet.iter().map(|row| row.foot.into()).collect(),
        angles: feet.iter().map(|row| row.angle).collect(),
        between: Vec::new(),
    };
    Ok((rows, feet))
}

/// An overlap that includes the last stations of a profile goes on beyond it.
fn refuse_ends(
    pair: &WheelOverRail,
    points: &[Vector3<f64>],
    first: f64,
    last: f64,
) -> Result<(), Error> {
    let ends = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
            [low.min(v), high.max(v)]
        })
    };
    let head = [pair.head[0], pair.head[pair.head.len() - 1]];
    let rail = (
        "rail",
        ends(&mut points.iter().map(|p| p.y)),
        head.map(|p| p.y),
        head.map(|p| p.position),
    );
    let range = pair.wheel.range();
    for (profile, at, limits, own) in [rail, ("wheel", [first, last], range, range)] {
        for side in 0..2 {
            if (at[side] - limits[side]).abs() < 2.0 * pair.sampling {
                return Err(Error::ProfileEnds {
                    profile,
                    end: own[side],
                });
            }
        }
    }
    Ok(())
}

/// The same of bodies with slices, which end where the first of the sections does.
fn refuse_sliced_end(
    pair: &WheelOverRail,
    point: &Vector3<f64>,
    position: f64,
    pose: &WheelPose,
) -> Result<(), Error> {
    let out = point - Vector3::from(pose.centre);
    let on_wheel = pair
        .wheel_at(Spokes::of(pose).angle(&out), position)
        .nominal;
    let own = pair.rail_below(point.x, point.y);
    let on_rail = pair.rail_at_own(point.x, own).nominal;
    let range = |slices: &Option<Arc<Slices>>, profile: &Profile| {
        (slices.as_ref()).map_or_else(|| profile.range(), |slices| slices.range())
    };
    for (profile, at, ends) in [
        ("rail", on_rail, range(&pair.rail_slices, &pair.rail)),
        ("wheel", on_wheel, range(&pair.wheel_slices, &pair.wheel)),
    ] {
        // along the profile, as its stations lie
        let nominal = if profile == "rail" {
            &pair.rail
        } else {
            &pair.wheel
        };
        let [low, high] = nominal.range();
        let length = |y: f64| {
            nominal
                .arc_length(&[y.clamp(low, high)])
                .map(|found| found[0])
        };
        let here = length(at)?;
        let mut near = None;
        for end in ends {
            if (here - length(end)?).abs() < 2.0 * pair.sampling {
                near = Some(end);
            }
        }
        if let Some(end) = near {
            return Err(Error::ProfileEnds { profile, end });
        }
    }
    Ok(())
}

/// Distance (ny * nx) [m] from the rail to the wheel along the normals of `rows`, and the rail of each row.
fn gap(
    pair: &WheelOverRail,
    position: Vector3<f64>,
    x: &[f64],
    rows: &[Row],
    pose: &WheelPose,
) -> (Vec<f64>, Vec<Option<Below>>) {
    let axle = Spokes::of(pose);
    let centre = Vector3::from(pose.centre);
    let mut gap = vec![NOTHING; x.len() * rows.len()];
    let few = POINTS_A_THREAD.div_ceil(x.len());
    let mut rail_of_row = vec![None; rows.len()];
    gap.par_chunks_mut(x.len())
        .with_min_len(few)
        .zip(rows)
        .zip(&mut rail_of_row)
        .for_each(|((points, row), rail_of_row)| {
            let (foot, normal) = (row.foot, row.normal());
            let rail = RailCut::new(pair, normal);
            let wheel = WheelCut::new(pair, axle, normal);
            // a straight rail is a prism, so that one place is enough for a row
            *rail_of_row = rail.below(position.x, foot);
            let mut near = None;
            for (gap, x) in points.iter_mut().zip(x) {
                let below = if pair.rail_slices.is_some() || pair.roller.is_some() {
                    rail.below(position.x + x, foot)
                } else {
                    *rail_of_row
                };
                let Some(Below {
                    distance: below, ..
                }) = below
                else {
                    continue;
                };
                let base = Vector3::new(position.x + x, foot.x, foot.y) - centre;
                near = wheel.distance(base, near.unwrap_or(below));
                if let Some(above) = near {
                    *gap = above - below;
                }
            }
        });
    (gap, rail_of_row)
}

/// The rail along the normal from a place.
#[derive(Clone, Copy)]
pub(super) struct Below {
    pub(super) distance: f64,
    /// y of the rail profile [m].
    pub(super) rail_position: f64,
}

/// The rail cut along a normal of the plane.
pub(super) struct RailCut<'a> {
    pair: &'a WheelOverRail,
    /// The normal in the rail's own frame.
    pub(super) ahead: Vector2<f64>,
}

impl<'a> RailCut<'a> {
    pub(super) fn new(pair: &'a WheelOverRail, normal: Vector3<f64>) -> Self {
        let turned = Self {
            pair,
            ahead: Vector2::zeros(),
        };
        Self {
            ahead: turned.own(normal.yz()),
            ..turned
        }
    }

    /// A direction (y, z) in the rail's own frame.
    pub(super) fn own(&self, direction: Vector2<f64>) -> Vector2<f64> {
        let (sin, cos) = (self.pair.placement.sin, self.pair.placement.cos);
        Vector2::new(
            cos * direction.x + sin * direction.y,
            cos * direction.y - sin * direction.x,
        )
    }

    /// The rail from a place (y, z) at `x` in the track, if it is there.
    pub(super) fn below(&self, x: f64, foot: Vector2<f64>) -> Option<Below> {
        if let Some(roller) = self.pair.roller {
            return self.roller_below(roller, x, foot);
        }
        let own = self.own(foot - Vector2::from(self.pair.placement.shift));
        let mut distance = 0.0;
        let found = newton(&mut distance, |distance| {
            let at = own + self.ahead * distance;
            let rail = self.pair.rail_at_own(x, at.x);
            let rate = (self.ahead.y - rail.slope * self.ahead.x).max(STEEPEST);
            ((at.y - rail.height) / rate, rail.is_there)
        });
        found.then(|| Below {
            distance,
            rail_position: own.x + self.ahead.x * distance,
        })
    }
}

impl RailCut<'_> {
    /// The roller from a place (y, z) at `x`, as seen from the angle of the plane.
    fn roller_below(&self, roller: Roller, x: f64, foot: Vector2<f64>) -> Option<Below> {
        let placement = &self.pair.placement;
        // the normal, in the track
        let (sin, cos) = (placement.sin, placement.cos);
        let ahead = Vector2::new(
            cos * self.ahead.x - sin * self.ahead.y,
            sin * self.ahead.x + cos * self.ahead.y,
        );
        let own = |at: Vector2<f64>| self.own(at - Vector2::from(placement.shift));
        let mut distance = 0.0;
        let mut position = f64::NAN;
        let found = newton(&mut distance, |distance| {
            let at = foot + ahead * distance;
            let [up, by_z] = roller.raised(x, at.y);
            let at = own(Vector2::new(at.x, up));
            let by = self.own(Vector2::new(ahead.x, ahead.y * by_z));
            let [height, slope] = height_and_slope(&self.pair.rail, at.x);
            let [low, high] = self.pair.rail.range();
            position = at.x;
            let rate = (by.y - slope * by.x).max(STEEPEST);
            ((at.y - height) / rate, (low..=high).contains(&at.x))
        });
        found.then_some(Below {
            distance,
            rail_position: position,
        })
    }
}

/// The wheel cut along a normal of the plane.
pub(super) struct WheelCut<'a> {
    pair: &'a WheelOverRail,
    axle: Spokes,
    pub(super) normal: Vector3<f64>,
    across: f64,
}

impl<'a> WheelCut<'a> {
    pub(super) fn new(pair: &'a WheelOverRail, axle: Spokes, normal: Vector3<f64>) -> Self {
        Self {
            pair,
            axle,
            normal,
            across: axle.axle.dot(&normal),
        }
    }

    /// Slope angle across the track of the wheel at a place on it, relative to the middle of the axle [rad].
    fn slope_angle(&self, place: Vector3<f64>) -> f64 {
        let [y, z] = self.inwards(place, Vector3::zeros(), Vector3::zeros())[0];
        (-y).atan2(z)
    }

    /// Change of [`WheelCut::slope_angle`] with that of the place and of the axle.
    pub(super) fn slope_angle_change(
        &self,
        place: Vector3<f64>,
        by_place: Vector3<f64>,
        by_axle: Vector3<f64>,
    ) -> f64 {
        let [[y, z], [by_y, by_z]] = self.inwards(place, by_place, by_axle);
        (y * by_z - z * by_y) / (y * y + z * z)
    }

    /// Change of [`WheelCut::distance`] that ends at a place, with that of the axle and of where the place would be moved
    /// without it.
    pub(super) fn distance_change(
        &self,
        place: Vector3<f64>,
        by_place: Vector3<f64>,
        by: &AxleChange,
    ) -> f64 {
        let (axle, by_axle) = (self.axle.axle, by.by_axle);
        let station = axle.dot(&place);
        let out = place - axle * station;
        let radius = out.norm();
        let wheel = (self.pair).wheel_at(self.axle.angle(&out), station - self.pair.tape);
        let by_station = by_axle.dot(&place) + axle.dot(&by_place);
        let by_radius = (out.dot(&by_place) - station * out.dot(&by_axle)) / radius;
        let by_angle = by.angle_of(&out, &(by_place - by_axle * station)) + by.by_turn;
        // how the angle on the wheel goes along the normal
        let [ahead, down] = [by.along, by.down];
        let turns = (out.dot(&down) * self.normal.dot(&ahead)
            - out.dot(&ahead) * self.normal.dot(&down))
            / (radius * radius);
        let rate = self.normal.dot(&out) / radius + wheel.slope * self.across + wheel.rate * turns;
        let missed = by_radius + wheel.slope * by_station + wheel.rate * by_angle;
        -missed / rate.min(-STEEPEST)
    }

    /// y and z of the normal into the wheel at a place on it, of a length that does not matter, and their change.
    fn inwards(
        &self,
        place: Vector3<f64>,
        by_place: Vector3<f64>,
        by_axle: Vector3<f64>,
    ) -> [[f64; 2]; 2] {
        let axle = self.axle.axle;
        let station = axle.dot(&place);
        let by_station = by_axle.dot(&place) + axle.dot(&by_place);
        let out = place - axle * station;
        let by_out = by_place - by_axle * station - axle * by_station;
        let radius = out.norm();
        let position = station - self.pair.tape;
        let [_, slope] = height_and_slope(&self.pair.wheel, position);
        let bend = self.pair.wheel.at(position).map_or(0.0, |there| there.bend);
        let ahead = out / radius;
        let by_ahead = (by_out - ahead * ahead.dot(&by_out)) / radius;
        let normal = -(ahead + axle * slope);
        let by_normal = -(by_ahead + by_axle * slope + axle * (bend * by_station));
        [[normal.y, normal.z], [by_normal.y, by_normal.z]]
    }

    /// Distance from a place relative to the middle of the axle, if the wheel is there.
    pub(super) fn distance(&self, base: Vector3<f64>, guess: f64) -> Option<f64> {
        let mut distance = guess;
        let found = newton(&mut distance, |distance| {
            let reach = base + self.normal * distance;
            let along = self.axle.axle.dot(&reach);
            let out = reach - self.axle.axle * along;
            // the distance from the axle counts; what slices add to its rate by the angle is small
            let radius = out.norm();
            let wheel = (self.pair).wheel_at(self.axle.angle(&out), along - self.pair.tape);
            let rate = self.normal.dot(&out) / radius + wheel.slope * self.across;
            let error = radius - (self.pair.radius - wheel.height);
            (error / rate.min(-STEEPEST), wheel.is_there)
        });
        found.then_some(distance)
    }
}

/// Newton's method for a distance; `step` gives how much is too far, and whether the body is there. Whether it
/// ended on the body.
fn newton(distance: &mut f64, mut step: impl FnMut(f64) -> (f64, bool)) -> bool {
    let (mut change, mut is_there) = (f64::NAN, false);
    for _ in 0..MOST_STEPS {
        (change, is_there) = step(*distance);
        change = change.clamp(-LONGEST, LONGEST);
        *distance -= change;
        if change.abs() < CLOSE {
            break;
        }
    }
    is_there && change.abs() < FOUND
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contact plane of a posed wheel, and the gap over it.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{Vector2, Vector3};
use rayon::prelude::*;

use super::middle::Middle;
use super::over::{Outline, SAMPLING, Spokes, WheelOverRail, WheelPose, height_and_slope};
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

/// The gap over a contact plane of a wheel in a given pose.
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
    /// First point along x and across, in spacings from the origin.
    pub first: [i64; 2],
    /// Points along x.
    pub nx: usize,
    /// Points across.
    pub ny: usize,
    /// Distance along the normal of the plane (ny * nx) [m], x fastest, negative where the undeformed bodies
    /// overlap; 10 mm where a body is missing.
    pub gap: Vec<f64>,
    /// y of the rail profile along the normal of each row (ny) [m]; that of the origin where there is no rail.
    pub rail_positions: Vec<f64>,
    /// Share of the estimated contact area inclined by more than 20 degrees to the plane, which it does not
    /// represent [-].
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
}

/// The plane for the `part` of the outline's stations that overlap; the pose is the centre and the direction
/// of the axle.
pub(super) fn over(
    pair: &WheelOverRail,
    outline: &Outline,
    part: Range<usize>,
    pose: &WheelPose,
    spacing: [f64; 2],
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
    let neglected = middle.neglected(&overlap, &aside, slope);

    // no pressure lies beyond the overlap of the undeformed bodies
    let (sin, cos) = angle.sin_cos();
    let mut reach = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for k in touching(n, |k| overlap[k] > 0.0, |k| is_near[k]) {
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
        let t = cos * (points[k].y - across) + sin * (below - up);
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
    let (gap, rail) = gap(pair, position, angle, [&x, &y], pose);
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
        gap,
        rail_positions: rail.into_iter().map(of_row).collect(),
        neglected,
        part,
    })
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
            if (at[side] - limits[side]).abs() < 2.0 * SAMPLING {
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
        if let Some(end) = ends
            .into_iter()
            .find(|end| (at - end).abs() < 2.0 * SAMPLING)
        {
            return Err(Error::ProfileEnds { profile, end });
        }
    }
    Ok(())
}

/// Distance (ny * nx) [m] from the rail to the wheel along the normal of the plane, and the rail of each row.
fn gap(
    pair: &WheelOverRail,
    position: Vector3<f64>,
    angle: f64,
    [x, y]: [&[f64]; 2],
    pose: &WheelPose,
) -> (Vec<f64>, Vec<Option<Below>>) {
    let (sin, cos) = angle.sin_cos();
    let normal = Vector3::new(0.0, -sin, cos);
    let rail = RailCut::new(pair, normal);
    let axle = Spokes::of(pose);
    let centre = Vector3::from(pose.centre);
    let wheel = WheelCut {
        pair,
        axle,
        normal,
        across: axle.axle.dot(&normal),
    };
    let mut gap = vec![NOTHING; x.len() * y.len()];
    let rows = POINTS_A_THREAD.div_ceil(x.len());
    let mut rail_of_row = vec![None; y.len()];
    gap.par_chunks_mut(x.len())
        .with_min_len(rows)
        .zip(y)
        .zip(&mut rail_of_row)
        .for_each(|((row, y), rail_of_row)| {
            let foot = Vector2::new(position.y + cos * y, position.z + sin * y);
            // a straight rail is a prism, so that one place is enough for a row
            *rail_of_row = rail.below(position.x, foot);
            let mut near = None;
            for (gap, x) in row.iter_mut().zip(x) {
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
    pub(super) pair: &'a WheelOverRail,
    pub(super) axle: Spokes,
    pub(super) normal: Vector3<f64>,
    pub(super) across: f64,
}

impl WheelCut<'_> {
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

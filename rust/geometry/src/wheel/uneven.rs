// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a wheel with slices, or one on a rail with slices, overlaps its rail.
//!
//! A circle on a straight rail touches it at its lowest place; an uneven one may touch at several, so that each
//! station is looked at over a stretch of the track.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use nalgebra::Vector3;
use rayon::prelude::*;

use super::change::{AxleChange, OutlineChange};
use super::over::{Footprint, Outline, Spokes, Station, Under, WheelOverRail, WheelPose};
use crate::Sliced;

/// Steps along the track over the radius of the wheel: the longest and the shortest, a millimetre and a tenth of it
/// for a usual wheel; and the parts of a step where bodies overlap.
const LONGEST: f64 = 1.0 / 460.0;
const SHORTEST: f64 = 0.1 / 460.0;
const PARTS: i32 = 4;
/// Every so many steps are looked at first, at most, and this often between two sections at least.
const STRIDE: usize = 4;
const IN_SECTION: f64 = 4.0;
/// Farthest place that is looked at, over the radius, and trials of it.
const FARTHEST: f64 = 0.3;
const TRIALS: usize = 60;
/// Stations looked at first: every so many.
const EVERY: usize = 3;
/// What the clearance may change by between the places looked at first [m].
const SLACK: f64 = 5e-5;
/// Distance to both sides over which a rail's slope is seen to change [m].
const BENT: f64 = 1e-5;

/// A place on a station against the rail.
#[derive(Clone, Copy, Debug)]
struct Place {
    point: Vector3<f64>,
    clearance: f64,
    /// Angle from down, forwards [rad], radius of the wheel there [m], and its change with the angle on the wheel [m].
    angle: f64,
    radius: f64,
    rate: f64,
    /// y of the rail profile [m], and the rail in its own frame.
    own: f64,
    rail: Sliced,
}

/// Change of a place.
#[derive(Clone, Copy, Default)]
struct PlaceChange {
    point: Vector3<f64>,
    clearance: f64,
    /// Of the slope angle of the rail.
    slope: f64,
}

/// What has been found at a station.
struct Scanned {
    point: Vector3<f64>,
    clearance: f64,
    angle: f64,
    footprint: Footprint,
}

/// Places that were looked at in a pose, by their number of parts of a step from the lowest one (n). A wheel that is only
/// higher or lower over a straight track has the same ones.
#[derive(Debug)]
pub(super) struct Seen {
    pose: WheelPose,
    stations: Vec<Mutex<Looked>>,
}

/// Places of a station that were looked at.
#[derive(Debug, Default)]
struct Looked {
    /// Which of `places` it is, counted from 1, by the number of parts of a step ahead of the first one; 0: not looked at.
    at: VecDeque<u16>,
    first: i32,
    places: Vec<Option<Place>>,
}

impl Looked {
    /// Where it is kept which place it is.
    fn slot(&mut self, parts: i32) -> &mut u16 {
        if self.at.is_empty() {
            self.first = parts;
        }
        while parts < self.first {
            self.at.push_front(0);
            self.first -= 1;
        }
        let ahead = (parts - self.first) as usize;
        if ahead >= self.at.len() {
            self.at.resize(ahead + 1, 0);
        }
        &mut self.at[ahead]
    }
}

impl Seen {
    pub(super) fn new(pair: &WheelOverRail, pose: &WheelPose) -> Self {
        Self {
            pose: *pose,
            stations: pair.stations.iter().map(|_| Mutex::default()).collect(),
        }
    }

    fn looked(&self, k: usize) -> MutexGuard<'_, Looked> {
        (self.stations[k].lock()).unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a pose has the same places.
    pub(super) fn serves(&self, pair: &WheelOverRail, pose: &WheelPose) -> bool {
        let [x, y, z] = pose.centre;
        let own = self.pose.centre[2];
        let height = if pair.roller.is_some() { z } else { own };
        let as_high = WheelPose {
            centre: [x, y, height],
            ..*pose
        };
        as_high == self.pose
    }
}

struct Scan<'a> {
    pair: &'a WheelOverRail,
    centre: Vector3<f64>,
    spokes: Spokes,
    /// Distance of the places along the track, over the radius, how many there are on either side, and which of them are
    /// looked at first.
    step: f64,
    count: i32,
    stride: usize,
    seen: Arc<Seen>,
}

/// The outline of bodies with slices from that of their nominal profiles.
pub(super) fn outline(pair: &WheelOverRail, mut nominal: Outline, pose: &WheelPose) -> Outline {
    let n = pair.stations.len();
    let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    let lowest = least(&nominal.clearance);
    let (scan, departure) = Scan::new(pair, pose, lowest);

    // the departures bound how far the nominal profiles are off
    let bound = (lowest + departure).max(0.0) + SLACK;
    let is_possible: Vec<bool> = (nominal.clearance.iter())
        .map(|clearance| *clearance - departure <= bound)
        .collect();
    let tried: Vec<usize> = (0..n)
        .filter(|&k| {
            let is_end = |other: Option<&bool>| other != Some(&true);
            is_possible[k]
                && (k % EVERY == 0
                    || is_end(is_possible.get(k + 1))
                    || is_end(k.checked_sub(1).and_then(|before| is_possible.get(before))))
        })
        .collect();
    let found: Vec<f64> = tried.par_iter().map(|&k| scan.least(&nominal, k)).collect();
    let near = least(&found).max(0.0) + SLACK;
    let mut is_near = vec![false; n];
    let mut clearance = vec![f64::INFINITY; n];
    for (&k, found) in tried.iter().zip(&found) {
        let around = k.saturating_sub(EVERY)..(k + EVERY + 1).min(n);
        for other in around {
            clearance[other] = clearance[other].min(found.max(near));
            is_near[other] |= *found < near;
        }
    }
    let scanned: Vec<Option<Scanned>> = (0..n)
        .into_par_iter()
        .with_min_len(16)
        .map(|k| (is_near[k] && is_possible[k]).then(|| scan.scanned(&nominal, k)))
        .collect();
    let mut footprints = vec![Footprint::default(); n];
    for (k, scanned) in scanned.into_iter().enumerate() {
        let far = nominal.clearance[k] - departure;
        nominal.clearance[k] = clearance[k].min(far.max(near));
        if let Some(scanned) = scanned {
            nominal.points[k] = scanned.point;
            nominal.clearance[k] = scanned.clearance;
            nominal.angle[k] = scanned.angle;
            footprints[k] = scanned.footprint;
        }
    }
    nominal.footprints = Some(footprints);
    nominal
}

/// Change of the outline at the stations of a part, which overlap, by a change `by` of the pose; and what the squares of
/// the overlap over the footprints change by. `nominal`: the outline without slices, and its change.
///
/// The places along the track that stand for a footprint stay as far as they are from the lowest one without slices.
pub(super) fn change(
    pair: &WheelOverRail,
    (nominal, by_nominal): (&Outline, &OutlineChange),
    part: Range<usize>,
    pose: &WheelPose,
    by: &AxleChange,
) -> (OutlineChange, Vec<f64>) {
    let lowest = (nominal.clearance.iter().copied()).fold(f64::INFINITY, f64::min);
    let (scan, _) = Scan::new(pair, pose, lowest);
    let start = part.start;
    let of_station = |k: usize| {
        let station = &pair.stations[k];
        let places = scan.places(nominal, k);
        let by_point = by_nominal.points[k - start];
        let turned = scan.lowest_change(station, nominal.points[k], by_point, by);
        let changes: Vec<PlaceChange> = (places.iter())
            .map(|place| scan.place_change(station, place, turned, by))
            .collect();
        scan.change(&places, &changes)
    };
    let stations: Vec<(PlaceChange, f64)> = part.into_par_iter().map(of_station).collect();
    let places = || stations.iter().map(|(place, _)| place);
    let outline = OutlineChange {
        points: places().map(|place| place.point).collect(),
        clearance: places().map(|place| place.clearance).collect(),
        angle: places().map(|place| place.slope).collect(),
    };
    (
        outline,
        stations.iter().map(|(_, squares)| *squares).collect(),
    )
}

/// How far ahead and behind, over the radius, a place may be the lowest one, or overlap; and the largest departure
/// from the nominal profiles there [m].
fn reach(pair: &WheelOverRail, pose: &WheelPose, overlap: f64) -> (f64, f64) {
    let unevenness = |reach: f64| {
        let wheel = pair.wheel_slices.as_ref();
        let rail = pair.rail_slices.as_ref();
        let wheel = wheel.map_or([0.0; 2], |slices| slices.unevenness(pose.turn, reach));
        let rail = rail.map_or([0.0; 2], |slices| {
            slices.unevenness(pose.centre[0], reach * pair.radius)
        });
        [wheel[0] + rail[0], wheel[1] + rail[1]]
    };
    let mut reach = 0.0;
    for k in 1..=TRIALS {
        let tried = FARTHEST * k as f64 / TRIALS as f64;
        // a circle is that much higher there
        if 0.5 * tried * tried * pair.radius <= unevenness(tried)[1] {
            reach = tried;
        }
    }
    let [departure, _] = unevenness(reach);
    let contact = (2.0 * (overlap + departure) / pair.radius).sqrt();
    let reach = (reach + contact + 2.0 * LONGEST).min(FARTHEST);
    let [departure, _] = unevenness(reach);
    (reach, departure)
}

impl<'a> Scan<'a> {
    /// Of a pose whose wheel without slices is `lowest` [m] above its rail, and the largest departure of the slices there.
    fn new(pair: &'a WheelOverRail, pose: &WheelPose, lowest: f64) -> (Self, f64) {
        let (reach, departure) = reach(pair, pose, (-lowest).max(0.0));
        let finest = pair
            .wheel_slices
            .as_ref()
            .map_or(f64::INFINITY, |slices| slices.finest())
            .min(
                (pair.rail_slices.as_ref())
                    .map_or(f64::INFINITY, |slices| slices.finest() / pair.radius),
            );
        let step = finest.clamp(SHORTEST, LONGEST);
        let stride = ((finest / (IN_SECTION * step)) as usize).clamp(1, STRIDE);
        let scan = Self {
            pair,
            centre: Vector3::from(pose.centre),
            spokes: Spokes::of(pose),
            step,
            // the same places, however far it is
            count: (reach / (step * stride as f64)).ceil() as i32 * stride as i32,
            stride,
            seen: pair.seen(pose),
        };
        (scan, departure)
    }

    /// Where a station stands, so many parts of a step from its lowest place as a circle. `near`: the rail near by, and then
    /// there.
    fn place(
        &self,
        k: usize,
        from: f64,
        parts: i32,
        (looked, near): (&mut Looked, &mut Option<Under>),
    ) -> Option<Place> {
        let raised = self.centre.z - self.seen.pose.centre[2];
        let slot = *looked.slot(parts);
        if slot > 0 {
            return looked.places[usize::from(slot) - 1].map(|mut place| {
                *near = Some(Under {
                    at: [place.point.x, place.point.y],
                    own: place.own,
                    rail: place.rail,
                });
                place.point.z += raised;
                place.clearance += raised;
                place
            });
        }
        let angle = from + f64::from(parts) * self.step / f64::from(PARTS);
        let place = self.place_at(&self.pair.stations[k], angle, near);
        let lowered = place.map(|mut place| {
            place.point.z -= raised;
            place.clearance -= raised;
            place
        });
        looked.places.push(lowered);
        *looked.slot(parts) = looked.places.len() as u16;
        place
    }

    /// Where a station stands at an angle from down.
    fn place_at(&self, station: &Station, angle: f64, near: &mut Option<Under>) -> Option<Place> {
        let pair = self.pair;
        let (sin, cos) = angle.sin_cos();
        let out = self.spokes.down * cos + self.spokes.along * sin;
        let (radius, rate, is_there) = if pair.wheel_slices.is_some() {
            let wheel = pair.wheel_at(self.spokes.angle(&out), station.position);
            (pair.radius - wheel.height, -wheel.rate, wheel.is_there)
        } else {
            (station.radius, 0.0, true)
        };
        let point = self.centre + self.spokes.axle * (pair.tape + station.position) + out * radius;
        let head = [pair.head[0].y, pair.head[pair.head.len() - 1].y];
        if !is_there || (pair.rail_slices.is_none() && !(head[0]..=head[1]).contains(&point.y)) {
            return None;
        }
        let point = pair.roller.map_or(point, |roller| roller.own(point));
        let near_by = near.filter(|_| pair.rail_slices.is_some());
        let under = pair.rail_under([point.x, point.y], near_by);
        *near = Some(under);
        let Under { own, rail, .. } = under;
        let [_, up] = pair.placement.place(own, rail.height);
        rail.is_there.then(|| Place {
            point,
            clearance: point.z - up,
            angle,
            radius,
            rate,
            own,
            rail,
        })
    }

    /// How a place changes with the pose, whose angle changes by `turned` [rad].
    fn place_change(
        &self,
        station: &Station,
        place: &Place,
        turned: f64,
        by: &AxleChange,
    ) -> PlaceChange {
        let pair = self.pair;
        let (sin, cos) = place.angle.sin_cos();
        let out = by.down * cos + by.along * sin;
        let ahead = by.along * cos - by.down * sin;
        let by_out = by.by_down * cos + by.by_along * sin + ahead * turned;
        let on_axle = pair.tape + station.position;
        let mut point = by.by_centre
            + by.by_axle * on_axle
            + by_out * place.radius
            + out * (place.rate * (by.by_turn + turned));
        if let Some(roller) = pair.roller {
            let at = self.centre + self.spokes.axle * on_axle + out * place.radius;
            point = roller.own_change(at, point);
        }
        let [by_own, _, by_up] = pair.below_change(&place.rail, point.x, point.y);
        // how the slope bends: of both sides of the place
        let size = point.x.abs().max(by_own.abs());
        let slope = if size > 0.0 {
            let share = BENT / size;
            let [behind, ahead] = [-share, share].map(|share| {
                let x = place.point.x + share * point.x;
                let rail = pair.rail_at_own(x, place.own + share * by_own);
                rail.slope.atan()
            });
            0.5 * (ahead - behind) / share
        } else {
            0.0
        };
        PlaceChange {
            point,
            clearance: point.z - by_up,
            slope,
        }
    }

    /// Change of what is told of a station that overlaps, and of the square of the overlap over its footprint.
    fn change(&self, places: &[Place], changes: &[PlaceChange]) -> (PlaceChange, f64) {
        let Some(least) = lowest_of(places) else {
            return (PlaceChange::default(), 0.0);
        };
        // at the lowest place, which may lie beside the one that is told
        let off = bottom(places, least).1;
        let other = if off > 0.0 {
            least + 1
        } else {
            least.wrapping_sub(1)
        };
        let clearance = match places.get(other).filter(|_| off != 0.0) {
            Some(place) => {
                let share = off / (place.point.x - places[least].point.x);
                let [here, there] = [least, other].map(|k| changes[k].clearance);
                here + share * (there - here)
            }
            None => changes[least].clearance,
        };
        let (mut sum, mut by_sum) = (0.0, 0.0);
        let (mut mean, mut by_mean) = (PlaceChange::default(), PlaceChange::default());
        for k in 1..places.len() {
            let along = places[k].point.x - places[k - 1].point.x;
            let width = 0.5 * along.abs();
            let by_along = changes[k].point.x - changes[k - 1].point.x;
            let by_width = 0.5 * along.signum() * by_along;
            for end in [k - 1, k] {
                let (place, change) = (&places[end], &changes[end]);
                let depth = place.clearance.min(0.0);
                let weight = width * depth * depth;
                let by_weight = by_width * depth * depth + 2.0 * width * depth * change.clearance;
                let slope = self.slope_angle(place);
                sum += weight;
                by_sum += by_weight;
                mean.point += place.point * weight;
                mean.slope += slope * weight;
                by_mean.point += place.point * by_weight + change.point * weight;
                by_mean.slope += slope * by_weight + change.slope * weight;
            }
        }
        if sum == 0.0 {
            return (
                PlaceChange {
                    clearance,
                    ..changes[least]
                },
                0.0,
            );
        }
        let change = PlaceChange {
            point: (by_mean.point - mean.point * (by_sum / sum)) / sum,
            clearance,
            slope: (by_mean.slope - mean.slope * (by_sum / sum)) / sum,
        };
        (change, by_sum)
    }

    /// Slope angle of the rail at a place.
    fn slope_angle(&self, place: &Place) -> f64 {
        let (sin, cos) = (self.pair.placement.sin, self.pair.placement.cos);
        (sin + cos * place.rail.slope).atan2(cos - sin * place.rail.slope)
    }

    /// Angle of the lowest place of a station as a circle.
    fn lowest(&self, nominal: &Outline, k: usize) -> f64 {
        let position = self.pair.stations[k].position;
        let middle = self.centre + self.spokes.axle * (self.pair.tape + position);
        let point = nominal.points[k];
        let point = self.pair.roller.map_or(point, |roller| {
            let seen = Vector3::new(0.0, point.y, point.z);
            roller.place(point.x / roller.radius, seen)
        });
        let out = point - middle;
        out.dot(&self.spokes.along)
            .atan2(out.dot(&self.spokes.down))
    }

    /// Change of [`Scan::lowest`] as the nominal `point` moves.
    fn lowest_change(
        &self,
        station: &Station,
        point: Vector3<f64>,
        by_point: Vector3<f64>,
        by: &AxleChange,
    ) -> f64 {
        let on_axle = self.pair.tape + station.position;
        let middle = self.centre + self.spokes.axle * on_axle;
        let by_middle = by.by_centre + by.by_axle * on_axle;
        let (point, by_point) = self.pair.roller.map_or((point, by_point), |roller| {
            let angle = point.x / roller.radius;
            let seen = Vector3::new(0.0, point.y, point.z);
            let by_seen = Vector3::new(0.0, by_point.y, by_point.z);
            let by_angle = by_point.x / roller.radius;
            let moved = roller.seen_change((-angle, -by_angle), (seen, by_seen));
            (roller.place(angle, seen), moved)
        });
        by.angle_of(&(point - middle), &(by_point - by_middle))
    }

    /// Parts of a step from the lowest place of a station.
    fn parts(&self, i: usize) -> i32 {
        (i as i32 - self.count) * PARTS
    }

    /// The places of a station that may be its lowest ones, or overlap, by their number; `None` in place of others.
    fn looked_at(
        &self,
        k: usize,
        from: f64,
        (looked, near): (&mut Looked, &mut Option<Under>),
    ) -> Vec<Option<Place>> {
        let n = 2 * self.count as usize + 1;
        let mut seen = vec![None; n];
        let mut look = |i: usize| {
            let place = self.place(k, from, self.parts(i), (looked, near));
            seen[i] = place;
            place.map_or(f64::INFINITY, |place| place.clearance)
        };
        let first: Vec<usize> = (0..n - 1).step_by(self.stride).chain([n - 1]).collect();
        let heights: Vec<f64> = first.iter().map(|i| look(*i)).collect();
        if self.stride == 1 {
            return seen;
        }
        let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
        // twice what a curve bent as there leaves between two places
        let bend = |k: usize| match heights.get(k.saturating_sub(1)..k + 2) {
            Some([before, here, after]) => 0.25 * (before - 2.0 * here + after).abs(),
            _ => 0.0,
        };
        let sag = 0.5 * self.pair.radius * (self.stride as f64 * self.step).powi(2);
        for (k, pair) in first.windows(2).enumerate() {
            let [here, next] = [heights[k], heights[k + 1]];
            let may = here.min(next) - bend(k).max(bend(k + 1));
            // where a profile ends the bend is none
            let ends = here.is_finite() != next.is_finite();
            if ends || may <= lowest.max(sag) {
                (pair[0] + 1..pair[1]).for_each(|i| {
                    look(i);
                });
            }
        }
        seen
    }

    /// Least clearance of a station at the places looked at.
    fn least(&self, nominal: &Outline, k: usize) -> f64 {
        let from = self.lowest(nominal, k);
        let places = self.looked_at(k, from, (&mut self.seen.looked(k), &mut None));
        (places.iter().flatten())
            .map(|place| place.clearance)
            .fold(f64::INFINITY, f64::min)
    }

    /// The places of a station by which it is told.
    fn places(&self, nominal: &Outline, k: usize) -> Vec<Place> {
        let from = self.lowest(nominal, k);
        let clearance = |place: &Option<Place>| place.map_or(f64::INFINITY, |p| p.clearance);
        let (mut looked, mut near) = (self.seen.looked(k), None);
        let coarse = self.looked_at(k, from, (&mut looked, &mut near));
        let of_lowest = (0..coarse.len())
            .min_by(|a, b| clearance(&coarse[*a]).total_cmp(&clearance(&coarse[*b])))
            .unwrap_or(0);
        // finer where an overlap begins and ends, or nearly does, and around the lowest place
        let is_met = |i: usize| {
            let near = i.abs_diff(of_lowest) <= 1 || (i + 1).abs_diff(of_lowest) <= 1;
            let sag = 0.5 * self.pair.radius * self.step * self.step;
            let ends = [clearance(&coarse[i]), clearance(&coarse[i + 1])];
            // further in, the overlap is smooth between sections that are far apart
            let is_smooth = self.stride > 1 && ends[0].max(ends[1]) <= -sag;
            near || (ends[0].min(ends[1]) < sag && !is_smooth)
        };
        let mut fine: Vec<Option<Place>> = Vec::new();
        for i in 0..coarse.len() - 1 {
            fine.push(coarse[i]);
            if is_met(i) {
                for part in 1..PARTS {
                    fine.push(self.place(k, from, self.parts(i) + part, (&mut looked, &mut near)));
                }
            }
        }
        fine.push(coarse[coarse.len() - 1]);
        fine.into_iter().flatten().collect()
    }

    /// A station with what it overlaps: the mean place, weighted by the square of the overlap, or the lowest one.
    fn scanned(&self, nominal: &Outline, k: usize) -> Scanned {
        let places = self.places(nominal, k);
        let Some(least) = lowest_of(&places) else {
            return Scanned {
                point: nominal.points[k],
                clearance: f64::INFINITY,
                angle: nominal.angle[k],
                footprint: Footprint::default(),
            };
        };
        let mut scanned = Scanned {
            point: places[least].point,
            clearance: bottom(&places, least).0,
            angle: self.slope_angle(&places[least]),
            footprint: Footprint::default(),
        };
        if scanned.clearance >= 0.0 {
            return scanned;
        }
        let (mut sum, mut point, mut angle) = (0.0, Vector3::zeros(), 0.0);
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        for pair in places.windows(2) {
            let width = 0.5 * (pair[1].point.x - pair[0].point.x).abs();
            for place in pair {
                let weight = width * place.clearance.min(0.0).powi(2);
                sum += weight;
                point += place.point * weight;
                if weight > 0.0 {
                    angle += self.slope_angle(place) * weight;
                }
            }
            let [a, b] = [pair[0].clearance, pair[1].clearance];
            if a < 0.0 || b < 0.0 {
                // where it begins and ends
                let share = |from: f64, to: f64| if from > 0.0 { from / (from - to) } else { 0.0 };
                let [first, last] = [pair[0].point.x, pair[1].point.x];
                let from = first + share(a, b) * (last - first);
                let to = last + share(b, a) * (first - last);
                ends = [ends[0].min(from).min(to), ends[1].max(from).max(to)];
            }
        }
        if sum > 0.0 {
            scanned.point = point / sum;
            scanned.angle = angle / sum;
            scanned.footprint = Footprint { squares: sum, ends };
        } else {
            let x = scanned.point.x;
            scanned.footprint = Footprint {
                squares: 0.0,
                ends: [x, x],
            };
        }
        scanned
    }
}

/// The lowest of some places.
fn lowest_of(places: &[Place]) -> Option<usize> {
    (0..places.len()).min_by(|a, b| places[*a].clearance.total_cmp(&places[*b].clearance))
}

/// Clearance at the lowest place, by the parabola through the lowest one told and its neighbours, and how far it is ahead
/// of that [m].
fn bottom(places: &[Place], least: usize) -> (f64, f64) {
    let here = places[least].clearance;
    let (Some(before), Some(after)) = (
        least.checked_sub(1).and_then(|k| places.get(k)),
        places.get(least + 1),
    ) else {
        return (here, 0.0);
    };
    let at = |place: &Place| {
        (
            place.point.x - places[least].point.x,
            place.clearance - here,
        )
    };
    let ((x0, z0), (x1, z1)) = (at(before), at(after));
    let bend = (z1 / x1 - z0 / x0) / (x1 - x0);
    let slope = z1 / x1 - bend * x1;
    if bend > 0.0 && (x1 - x0).is_normal() {
        (here - 0.25 * slope * slope / bend, -0.5 * slope / bend)
    } else {
        (here, 0.0)
    }
}

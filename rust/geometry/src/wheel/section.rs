// SPDX-License-Identifier: MIT OR Apache-2.0
//! Wheel and rail in the vertical plane through the axle: placement and overlap.

use std::ops::Range;

use super::middle::share;
use super::{WheelOnRail, WheelRailContact};
use crate::error::out_of_range;
use crate::root;
use crate::{Error, Profile};
use mtb_words::Short;

/// Distance of the samples over the rail head [m]: fine against any contact, cheap to look through.
const SAMPLING: f64 = 1e-5;
/// Inclination against the first contact beyond which one plane no longer serves [rad].
const MOST_INCLINED: f64 = 20.0 * std::f64::consts::PI / 180.0;

/// A rail turned and moved into the track frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    pub(super) sin: f64,
    pub(super) cos: f64,
    pub(super) shift: [f64; 2],
}

impl Placement {
    /// Position of a profile point (y, z) in the track frame.
    pub(super) fn place(&self, y: f64, z: f64) -> [f64; 2] {
        [
            self.cos * y - self.sin * z + self.shift[0],
            self.sin * y + self.cos * z + self.shift[1],
        ]
    }

    /// Position and derivative with respect to the profile's y.
    pub(super) fn point(&self, profile: &Profile, y: f64) -> Option<([f64; 2], [f64; 2])> {
        let s = profile.at(y)?;
        let direction = [self.cos - self.sin * s.slope, self.sin + self.cos * s.slope];
        Some((self.place(y, s.height), direction))
    }

    /// Turned by the inclination, the top at z = 0 and the gauge face at half the gauge.
    fn of_rail(pair: &WheelOnRail) -> Result<Self, Error> {
        let (sin, cos) = pair.rail_inclination.sin_cos();
        let turned = Self {
            sin,
            cos,
            shift: [0.0; 2],
        };
        let points: Vec<[f64; 2]> = samples(&pair.rail, SAMPLING)
            .iter()
            .filter_map(|&y| turned.point(&pair.rail, y).map(|p| p.0))
            .collect();
        let (peak, top) = points
            .iter()
            .map(|p| p[1])
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((0, 0.0));
        let level = top - pair.gauge_depth;
        let inner = &points[..=peak];
        let Some(first) = inner.iter().rposition(|p| p[1] < level) else {
            let depth = top - inner[0][1];
            let accepted = format!(
                "the rail profile ends {} m below its top on the gauge side; the gauge is measured there",
                Short(depth)
            );
            return Err(out_of_range("gauge_depth", pair.gauge_depth, accepted));
        };
        // the face crosses the level between two samples 10 um apart
        let [below, above] = [inner[first], inner[first + 1]];
        let share = (level - below[1]) / (above[1] - below[1]);
        let face = inner[first + 1..]
            .iter()
            .map(|p| p[0])
            .fold(below[0] + share * (above[0] - below[0]), f64::min);
        Ok(Self {
            shift: [0.5 * pair.gauge - face, -top],
            ..turned
        })
    }
}

/// Lateral positions over a profile, both ends and all breaks included, at most `distance` [m] apart.
pub(super) fn samples(profile: &Profile, distance: f64) -> Vec<f64> {
    let mut y = Vec::new();
    for ends in profile.breaks().windows(2) {
        let n = ((ends[1] - ends[0]) / distance).ceil().max(1.0);
        y.extend((0..n as usize).map(|i| ends[0] + (ends[1] - ends[0]) * i as f64 / n));
    }
    y.push(profile.range()[1]);
    y
}

/// As [`samples`], at most `distance` [m] apart along the profile, so that steep places have as many.
pub(super) fn samples_along(profile: &Profile, distance: f64) -> Result<Vec<f64>, Error> {
    let breaks = profile.breaks();
    let mut lengths = Vec::new();
    let at_breaks = profile.arc_length(&breaks)?;
    for ends in at_breaks.windows(2) {
        let n = ((ends[1] - ends[0]) / distance).ceil().max(1.0);
        lengths.extend((0..n as usize).map(|i| ends[0] + (ends[1] - ends[0]) * i as f64 / n));
    }
    lengths.extend(at_breaks.last());
    let mut found = profile.position(&lengths)?;
    // breaks themselves, and no place twice where rounding would have it so
    for (place, at) in breaks.iter().zip(&at_breaks) {
        let k = lengths.partition_point(|length| length < at);
        found[k.min(lengths.len() - 1)] = *place;
    }
    found.dedup_by(|next, last| *next <= *last);
    Ok(found)
}

/// Of `n` places side by side those of each run of overlapping ones that has one near the plane.
///
/// Pressure ends where the overlap does. A run may go on over places too inclined for the plane, from which it
/// is not cut off; a run of such places alone is a contact of its own.
pub(super) fn touching(
    n: usize,
    is_overlapping: impl Fn(usize) -> bool,
    is_near: impl Fn(usize) -> bool,
) -> impl Iterator<Item = usize> {
    let mut runs: Vec<(Range<usize>, bool)> = Vec::new();
    for k in (0..n).filter(|&k| is_overlapping(k)) {
        match runs.last_mut() {
            Some((run, near)) if run.end == k => {
                run.end += 1;
                *near |= is_near(k);
            }
            _ => runs.push((k..k + 1, is_near(k))),
        }
    }
    runs.into_iter()
        .filter(|(_, near)| *near)
        .flat_map(|(run, _)| run)
}

/// Estimated contact area.
pub(super) struct Area {
    /// [m2]
    pub(super) size: f64,
    /// Mean slope angle [rad].
    pub(super) angle: f64,
    /// Mean y of the rail profile [m].
    rail_position: f64,
    /// Share left out because it is inclined too much.
    neglected: f64,
}

/// A point of the rail under the wheel.
struct Sample {
    rail_position: f64,
    /// Weight of the sample: track-frame y it stands for [m].
    width: f64,
    angle: f64,
    /// Vertical distance to the wheel that just touches [m].
    clearance: f64,
}

/// Wheel and rail in the vertical plane through the axle, just touching.
pub(super) struct Section<'a> {
    pub(super) pair: &'a WheelOnRail,
    pub(super) rail: Placement,
    /// Track-frame y of the tape circle.
    pub(super) tape: f64,
    /// z of the tape circle at first contact.
    pub(super) height: f64,
    first: f64,
    first_angle: f64,
    samples: Vec<Sample>,
}

impl<'a> Section<'a> {
    pub(super) fn new(pair: &'a WheelOnRail) -> Result<Self, Error> {
        let rail = Placement::of_rail(pair)?;
        let tape = 0.5 * pair.flange_back + pair.tape_circle + pair.lateral;
        let clearance = |y: f64| -> Option<f64> {
            let ([across, up], _) = rail.point(&pair.rail, y)?;
            Some(pair.wheel.at(across - tape)?.height - up)
        };
        let positions = samples(&pair.rail, SAMPLING);
        let mut found = Vec::with_capacity(positions.len());
        for (i, &y) in positions.iter().enumerate() {
            let Some((_, direction)) = rail.point(&pair.rail, y) else {
                continue;
            };
            // the under side of a turned flank is never touched from above
            if direction[0] <= 0.0 {
                continue;
            }
            if let Some(clearance) = clearance(y) {
                let before = positions[i.saturating_sub(1)];
                let after = positions[(i + 1).min(positions.len() - 1)];
                found.push(Sample {
                    rail_position: y,
                    width: 0.5 * (after - before) * direction[0],
                    angle: direction[1].atan2(direction[0]),
                    clearance,
                });
            }
        }
        let lowest = found
            .iter()
            .enumerate()
            .min_by(|a, b| a.1.clearance.total_cmp(&b.1.clearance))
            .map(|(i, _)| i);
        let Some(lowest) = lowest else {
            let [inner, outer] = pair.rail.range().map(|y| {
                let place = rail.point(&pair.rail, y);
                place.map_or(f64::NAN, |(p, _)| p[0])
            });
            return Err(Error::NeverTouch {
                reason: format!(
                    "the wheel is nowhere above the head of the rail. Its tape circle stands at y = {} m from the \
                     middle of the track (half of flange_back = {} m, tape_circle = {} m and lateral = {} m), and \
                     the rail lies at y = {} .. {} m (gauge = {} m). Lengths are in metres",
                    Short(tape),
                    Short(pair.flange_back),
                    Short(pair.tape_circle),
                    Short(pair.lateral),
                    Short(inner),
                    Short(outer),
                    Short(pair.gauge)
                ),
            });
        };
        let bracket = [
            found[lowest.saturating_sub(1)].rail_position,
            found[(lowest + 1).min(found.len() - 1)].rail_position,
        ];
        let first = root::minimum(|y| clearance(y).unwrap_or(f64::INFINITY), bracket);
        let least = clearance(first)
            .unwrap_or(f64::INFINITY)
            .min(found[lowest].clearance);
        for sample in &mut found {
            sample.clearance -= least;
        }
        Ok(Self {
            pair,
            rail,
            tape,
            height: -least,
            first,
            first_angle: found[lowest].angle,
            samples: found,
        })
    }

    /// Contact plane at an `approach` along the normal, and area of half the overlap there, which a Hertzian contact
    /// covers.
    pub(super) fn area(&self, approach: f64) -> Area {
        let vertical = approach / self.first_angle.cos();
        let radius = self.pair.joined_radius();
        let mut area = Area {
            size: 0.0,
            angle: self.first_angle,
            rail_position: self.first,
            neglected: 0.0,
        };
        let (mut weight, mut angle, mut rail_position) = (0.0, 0.0, 0.0);
        for sample in &self.samples {
            let overlap = vertical - sample.clearance;
            if overlap <= 0.0 {
                continue;
            }
            let half = (overlap - 0.5 * vertical).max(0.0);
            let footprint = 2.0 * (2.0 * radius * half).sqrt() * sample.width;
            if (sample.angle - self.first_angle).abs() > MOST_INCLINED {
                area.neglected += footprint / sample.angle.cos();
                continue;
            }
            area.size += footprint / sample.angle.cos();
            let share = share(overlap, vertical) * sample.width;
            weight += share;
            angle += share * sample.angle;
            rail_position += share * sample.rail_position;
        }
        // an overlap thinner than the samples keeps the first contact
        if weight > 0.0 {
            area.angle = angle / weight;
            area.rail_position = rail_position / weight;
        }
        if area.size > 0.0 {
            area.neglected /= area.size + area.neglected;
        }
        area
    }

    /// Contact plane and size at an approach along the normal.
    pub(super) fn contact(&self, approach: f64) -> Result<WheelRailContact, Error> {
        let area = self.area(approach);
        let pair = self.pair;
        let Some((origin, _)) = self.rail.point(&pair.rail, area.rail_position) else {
            return Err(Error::NeverTouch {
                reason: "the estimated contact lies beside the rail".into(),
            });
        };
        let vertical = approach / self.first_angle.cos();
        let (sin, cos) = area.angle.sin_cos();
        let mut across = [0.0_f64; 2];
        let is_near = |k: usize| (self.samples[k].angle - self.first_angle).abs() <= MOST_INCLINED;
        let overlapping = |k: usize| self.samples[k].clearance < vertical;
        for k in touching(self.samples.len(), overlapping, is_near) {
            let sample = &self.samples[k];
            if let Some((p, _)) = self.rail.point(&pair.rail, sample.rail_position) {
                let s = cos * (p[0] - origin[0]) + sin * (p[1] - origin[1]);
                across = [across[0].min(s), across[1].max(s)];
                self.refuse_ends(sample.rail_position, p[0] - self.tape)?;
            }
        }
        let wheel_position = origin[0] - self.tape;
        Ok(WheelRailContact {
            angle: area.angle,
            origin,
            rail_position: area.rail_position,
            wheel_position,
            first_rail_position: self.first,
            undeformed_height: self.height,
            approach,
            neglected: area.neglected,
            half_length: (2.0 * pair.joined_radius() * vertical).sqrt(),
            across,
        })
    }

    /// An overlap that includes the last samples of a profile goes on beyond it.
    fn refuse_ends(&self, rail_position: f64, wheel_position: f64) -> Result<(), Error> {
        for (profile, position, name) in [
            (&self.pair.rail, rail_position, "rail"),
            (&self.pair.wheel, wheel_position, "wheel"),
        ] {
            for end in profile.range() {
                if (position - end).abs() < 2.0 * SAMPLING {
                    return Err(Error::ProfileEnds { profile: name, end });
                }
            }
        }
        Ok(())
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Profiles that vary along the track or around the wheel.

use std::f64::consts::TAU;

use mtb_words::Short;

use super::{Profile, spline};
use crate::Error;
use crate::error::{all_finite, out_of_range};

/// Distance of the places across at which sections are compared with the nominal profile [m].
const ACROSS: f64 = 1e-4;
/// Most places of all sections together: a gigabyte.
const MOST_PLACES: usize = 30_000_000;
/// Fewest sections around a wheel.
const FEWEST_AROUND: usize = 4;
/// Gaps around a wheel longer than so many of the other steps are not closed by the spline.
const WIDE: f64 = 2.0;
/// Angle [rad] within which a last section is the first one again.
const SAME: f64 = 1e-9;
/// Slope at which a profile counts as vertical.
const STEEP: f64 = 1e3;

/// How a profile departs from its nominal shape along the track or around the wheel, through sections.
///
/// The surface is `z = nominal(v) + departure(s, v)`, with s [m] along the track, or the angle [rad] around the
/// wheel, and v the place on the nominal profile. The departure is a spline through the sections in s, twice
/// continuously differentiable, and one across. Without features v is y. Features, such as a gauge corner or a nose,
/// are lines `y(s)` through places of the sections that belong together: v is linear in y between two of them and
/// shifted beside them.
///
/// Before the first and after the last section a rail goes on as they are. Around the wheel the spline closes; if the
/// sections leave out more than twice their widest step, the departure is linear there.
#[derive(Clone, Debug, PartialEq)]
pub struct Slices {
    positions: Vec<f64>,
    around: bool,
    /// Ends of v [m], and places between them, one if the departure is the same everywhere across.
    ends: [f64; 2],
    across: usize,
    /// Departure, and its changes along v, s and both, of each section, v fastest.
    nodes: Vec<[f64; 4]>,
    lines: Vec<Line>,
    /// Largest change of the departure from each section to the next [m], largest size at each section, and what the spline
    /// may go beyond both until the next one.
    steps: Vec<f64>,
    sizes: Vec<f64>,
    bulges: Vec<f64>,
}

/// Where a feature lies.
#[derive(Clone, Debug, PartialEq)]
struct Line {
    /// On the nominal profile [m].
    nominal: f64,
    /// y at each section [m], and its change along s.
    places: Vec<[f64; 2]>,
}

/// The surface at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sliced {
    /// z [m].
    pub height: f64,
    /// Its change across [-].
    pub slope: f64,
    /// Its change along the track [-], or by the angle around the wheel [m].
    pub rate: f64,
    /// The place on the nominal profile [m].
    pub nominal: f64,
    /// Whether all sections reach that far.
    pub is_there: bool,
}

/// Two sections and the weights of value and change at each, for a value and for its change along s.
struct Between {
    ends: [usize; 2],
    value: [[f64; 2]; 2],
    rate: [[f64; 2]; 2],
}

impl Slices {
    /// Through `sections` at `positions`, along the track [m] or `around` the wheel [rad], rising. `features`: y [m] of
    /// each feature, on the nominal profile first, then at each section.
    ///
    /// # Errors
    /// Positions that do not rise, go around more than once, or are too few; features that do not rise, sections that
    /// have nothing in common.
    pub fn new(
        nominal: &Profile,
        positions: &[f64],
        sections: &[Profile],
        features: &[Vec<f64>],
        around: bool,
    ) -> Result<Self, Error> {
        let n = positions.len();
        if sections.len() != n {
            return Err(none(format!(
                "{n} positions and {} sections: one for each is needed",
                sections.len()
            )));
        }
        for feature in features {
            all_finite("features", feature)?;
            if feature.len() != n + 1 {
                return Err(none(format!(
                    "a feature has {} places: one on the nominal profile and one on each of the {n} sections are needed",
                    feature.len()
                )));
            }
        }
        for k in 0..=n {
            if features.windows(2).any(|pair| pair[0][k] >= pair[1][k]) {
                return Err(none("the features of each section must rise in y".into()));
            }
        }
        // where all of them are
        let mut ends = nominal.range();
        for (k, section) in sections.iter().enumerate() {
            let range = section.range();
            for side in 0..2 {
                let outer = if side == 0 {
                    features.first()
                } else {
                    features.last()
                };
                let shift = outer.map_or(0.0, |feature| feature[k + 1] - feature[0]);
                let own = range[side] - shift;
                ends[side] = if side == 0 {
                    ends[0].max(own)
                } else {
                    ends[1].min(own)
                };
            }
        }
        if ends[1] - ends[0] <= 2.0 * ACROSS {
            let moved = if features.is_empty() {
                ""
            } else {
                ", moved such that their features meet,"
            };
            return Err(none(format!(
                "the sections{moved} have nothing in common across: the last begins at {} m and the first ends at {} m",
                Short(ends[0]),
                Short(ends[1])
            )));
        }
        let across = ((ends[1] - ends[0]) / ACROSS).ceil() as usize + 1;
        if across * n > MOST_PLACES {
            return Err(none(format!(
                "{n} sections of {across} places are more than {MOST_PLACES} places"
            )));
        }
        let mut departure = Vec::with_capacity(n * across);
        for (k, section) in sections.iter().enumerate() {
            let [low, high] = section.range();
            for j in 0..across {
                let v = place(ends, across, j);
                let own = features_at(features, k, v).clamp(low, high);
                let height =
                    |profile: &Profile, y: f64| profile.at(y).map_or(f64::NAN, |s| s.height);
                departure.push(height(section, own) - height(nominal, v));
            }
        }
        Self::from_parts(positions, around, ends, &departure, features)
    }

    /// The nominal profile raised by `heights` [m] all across, which of a wheel are taken off its radius.
    ///
    /// # Errors
    /// As of [`Slices::new`].
    pub fn raised(
        nominal: &Profile,
        positions: &[f64],
        heights: &[f64],
        around: bool,
    ) -> Result<Self, Error> {
        if heights.len() != positions.len() {
            return Err(none(format!(
                "{} positions and {} departures: one for each is needed",
                positions.len(),
                heights.len()
            )));
        }
        Self::from_parts(positions, around, nominal.range(), heights, &[])
    }

    fn from_parts(
        positions: &[f64],
        around: bool,
        ends: [f64; 2],
        departure: &[f64],
        features: &[Vec<f64>],
    ) -> Result<Self, Error> {
        all_finite("position", positions)?;
        all_finite("departure", departure)?;
        let mut n = positions.len();
        let fewest = if around { FEWEST_AROUND } else { 2 };
        if n < fewest {
            return Err(none(format!(
                "{n} sections are given: at least {fewest} are needed"
            )));
        }
        if let Some(pair) = positions.windows(2).find(|pair| pair[1] <= pair[0]) {
            return Err(none(format!(
                "position {} follows {}: they must rise",
                Short(pair[1]),
                Short(pair[0])
            )));
        }
        let across = departure.len() / n;
        let turn = positions[n - 1] - positions[0];
        if around && turn > TAU + SAME {
            return Err(out_of_range(
                "angle of the last section, from the first one,",
                turn,
                "sections go around the wheel once, by 2 pi rad at most",
            ));
        }
        let is_again = around && turn > TAU - SAME;
        if is_again {
            let (first, last) = (&departure[..across], &departure[(n - 1) * across..]);
            if first.iter().zip(last).any(|(a, b)| (a - b).abs() > 1e-9) {
                return Err(none(
                    "the last section is at the place of the first one, and is another".into(),
                ));
            }
            n -= 1;
        }
        let positions = positions[..n].to_vec();
        let h = distances(&positions, around);
        let field = |column: &dyn Fn(usize) -> f64| {
            along(&h, &(0..n).map(column).collect::<Vec<_>>(), around)
        };
        let mut nodes = vec![[0.0; 4]; n * across];
        for (node, departure) in nodes.iter_mut().zip(departure) {
            node[0] = *departure;
        }
        if across > 1 {
            let step = vec![(ends[1] - ends[0]) / (across - 1) as f64; across - 1];
            for row in nodes.chunks_exact_mut(across) {
                let values: Vec<f64> = row.iter().map(|node| node[0]).collect();
                for (node, slope) in row.iter_mut().zip(along(&step, &values, false)) {
                    node[1] = slope;
                }
            }
        }
        for j in 0..across {
            for part in 0..2 {
                let slopes = field(&|k| nodes[k * across + j][part]);
                for (k, slope) in slopes.into_iter().enumerate() {
                    nodes[k * across + j][part + 2] = slope;
                }
            }
        }
        let lines: Vec<Line> = features
            .iter()
            .map(|feature| {
                let slopes = field(&|k| feature[k + 1]);
                Line {
                    nominal: feature[0],
                    places: (0..n).map(|k| [feature[k + 1], slopes[k]]).collect(),
                }
            })
            .collect();
        // features carry the shape aside, and what that does counts as well
        let aside = |k: usize, l: usize| {
            let moved = lines
                .iter()
                .map(|line| (line.places[k][0] - line.places[l][0]).abs());
            moved.fold(0.0, f64::max)
        };
        let row = |k: usize| &nodes[k * across..(k + 1) * across];
        let steps = (0..n)
            .map(|k| {
                let next = (k + 1) % n;
                let pairs = row(k).iter().zip(row(next));
                pairs.map(|(a, b)| (b[0] - a[0]).abs()).fold(0.0, f64::max) + aside(k, next)
            })
            .collect();
        let sizes = (0..n)
            .map(|k| {
                let moved = lines
                    .iter()
                    .map(|line| (line.places[k][0] - line.nominal).abs());
                row(k).iter().map(|node| node[0].abs()).fold(0.0, f64::max)
                    + moved.fold(0.0, f64::max)
            })
            .collect();
        let bulges = (0..n)
            .map(|k| {
                // where it is not a spline it is a line
                let Some(&width) = h.get(k) else {
                    return 0.0;
                };
                let next = (k + 1) % n;
                let of_row = row(k)
                    .iter()
                    .zip(row(next))
                    .map(|(a, b)| bulge([a[0], b[0]], [a[2], b[2]], width));
                let of_lines = lines.iter().map(|line| {
                    let [a, b] = [k, next].map(|k| line.places[k]);
                    bulge([a[0], b[0]], [a[1], b[1]], width)
                });
                of_row.fold(0.0, f64::max) + of_lines.fold(0.0, f64::max)
            })
            .collect();
        Ok(Self {
            positions,
            around,
            ends,
            across,
            nodes,
            lines,
            steps,
            sizes,
            bulges,
        })
    }

    /// Places of the sections, along the track [m] or around the wheel [rad].
    pub fn positions(&self) -> &[f64] {
        &self.positions
    }

    /// Ends [m] on the nominal profile between which all sections are.
    pub fn range(&self) -> [f64; 2] {
        self.ends
    }

    /// The surface at a place along the track [m] or around the wheel [rad] and y [m] across.
    pub fn at(&self, nominal: &Profile, position: f64, y: f64) -> Sliced {
        let between = self.between(position);
        let (v, by_y, by_s) = self.nominal_place(&between, y);
        let is_there = (self.ends[0]..=self.ends[1]).contains(&v);
        let v = v.clamp(self.ends[0], self.ends[1]);
        let [height, slope] = nominal.at(v).map_or([f64::NAN; 2], |station| {
            [station.height, station.slope.clamp(-STEEP, STEEP)]
        });
        let [departure, by_v, rate] = self.departure(&between, v);
        Sliced {
            height: height + departure,
            slope: (slope + by_v) * by_y,
            rate: rate + (slope + by_v) * by_s,
            nominal: v,
            is_there,
        }
    }

    /// Departure, its change along v and along s.
    fn departure(&self, between: &Between, v: f64) -> [f64; 3] {
        let (first, share, width) = if self.across == 1 {
            (0, 0.0, 1.0)
        } else {
            let width = (self.ends[1] - self.ends[0]) / (self.across - 1) as f64;
            let at = (v - self.ends[0]) / width;
            let first = (at.max(0.0) as usize).min(self.across - 2);
            (first, at - first as f64, width)
        };
        let count = self.across.min(2);
        let (value, change) = hermite(share, width);
        let mut out = [0.0; 3];
        for (end, k) in between.ends.into_iter().enumerate() {
            for side in 0..count {
                let node = self.nodes[k * self.across + first + side];
                // a single place has no change across
                let (value, change) = if count == 1 {
                    ([1.0, 0.0], [0.0; 2])
                } else {
                    (value[side], change[side])
                };
                let here = value[0] * node[0] + value[1] * node[1];
                let ahead = value[0] * node[2] + value[1] * node[3];
                let across = change[0] * node[0] + change[1] * node[1];
                let both = change[0] * node[2] + change[1] * node[3];
                let [of_value, of_change] = between.value[end];
                let [rate_of_value, rate_of_change] = between.rate[end];
                out[0] += of_value * here + of_change * ahead;
                out[1] += of_value * across + of_change * both;
                out[2] += rate_of_value * here + rate_of_change * ahead;
            }
        }
        out
    }

    /// Place on the nominal profile, with its changes by y and along s.
    fn nominal_place(&self, between: &Between, y: f64) -> (f64, f64, f64) {
        let at = |line: &Line| {
            let mut out = [0.0; 2];
            for (end, k) in between.ends.into_iter().enumerate() {
                let [place, slope] = line.places[k];
                out[0] += between.value[end][0] * place + between.value[end][1] * slope;
                out[1] += between.rate[end][0] * place + between.rate[end][1] * slope;
            }
            out
        };
        let mut before: Option<(f64, [f64; 2])> = None;
        for line in &self.lines {
            let [here, rate] = at(line);
            if y < here {
                let Some((nominal, [start, start_rate])) = before else {
                    return (y - here + line.nominal, 1.0, -rate);
                };
                let stretch = (line.nominal - nominal) / (here - start);
                let by_s =
                    -stretch * (start_rate + (y - start) * (rate - start_rate) / (here - start));
                return (nominal + (y - start) * stretch, stretch, by_s);
            }
            before = Some((line.nominal, [here, rate]));
        }
        match before {
            Some((nominal, [here, rate])) => (y - here + nominal, 1.0, -rate),
            None => (y, 1.0, 0.0),
        }
    }

    fn between(&self, position: f64) -> Between {
        let n = self.positions.len();
        let (first, last) = (self.positions[0], self.positions[n - 1]);
        let s = if self.around {
            first + (position - first).rem_euclid(TAU)
        } else {
            position
        };
        let as_is = |k: usize| Between {
            ends: [k, k],
            value: [[1.0, 0.0], [0.0; 2]],
            rate: [[0.0; 2]; 2],
        };
        if !self.around && s <= first {
            return as_is(0);
        }
        if !self.around && s >= last {
            return as_is(n - 1);
        }
        let k = self.positions.partition_point(|p| *p <= s).clamp(1, n) - 1;
        let width = self.width(k);
        let share = (s - self.positions[k]) / width;
        let ends = [k, (k + 1) % n];
        if k == n - 1 && !is_closed(&self.positions) {
            return Between {
                ends,
                value: [[1.0 - share, 0.0], [share, 0.0]],
                rate: [[-1.0 / width, 0.0], [1.0 / width, 0.0]],
            };
        }
        let (value, rate) = hermite(share, width);
        Between { ends, value, rate }
    }

    /// From a section to the next one.
    fn width(&self, k: usize) -> f64 {
        let n = self.positions.len();
        if k + 1 < n {
            self.positions[k + 1] - self.positions[k]
        } else {
            self.positions[0] + TAU - self.positions[k]
        }
    }

    /// Least distance of two sections.
    pub(crate) fn finest(&self) -> f64 {
        let steps = self.positions.windows(2).map(|pair| pair[1] - pair[0]);
        steps.fold(f64::INFINITY, f64::min)
    }

    /// Bounds of the departure from the nominal profile, and of the sum of its changes, within `reach` of a position, up to
    /// the neighbours.
    pub(crate) fn unevenness(&self, position: f64, reach: f64) -> [f64; 2] {
        let n = self.positions.len();
        let away = |k: usize| {
            let off = self.positions[k] - position;
            if self.around {
                (off + 0.5 * TAU).rem_euclid(TAU) - 0.5 * TAU
            } else {
                off
            }
        };
        let mut out = [0.0_f64; 2];
        let count = if self.around { n } else { n - 1 };
        for k in 0..count {
            let start = away(k);
            let end = start + self.width(k);
            if start <= reach && end >= -reach {
                let size = self.sizes[k].max(self.sizes[(k + 1) % n]);
                out[0] = out[0].max(size + self.bulges[k]);
                out[1] += self.steps[k] + 2.0 * self.bulges[k];
            }
        }
        if !self.around {
            // beyond its ends a rail goes on as there
            for k in [0, n - 1] {
                let is_beyond = if k == 0 {
                    away(0) > -reach
                } else {
                    away(k) < reach
                };
                if is_beyond {
                    out[0] = out[0].max(self.sizes[k]);
                }
            }
        }
        out
    }

    /// The slices as numbers, for a file.
    pub fn to_numbers(&self) -> Vec<f64> {
        let n = self.positions.len();
        let mut numbers = vec![
            f64::from(u8::from(self.around)),
            n as f64,
            self.across as f64,
            self.lines.len() as f64,
            self.ends[0],
            self.ends[1],
        ];
        numbers.extend(&self.positions);
        numbers.extend(self.nodes.iter().map(|node| node[0]));
        for line in &self.lines {
            numbers.push(line.nominal);
            numbers.extend(line.places.iter().map(|place| place[0]));
        }
        numbers
    }

    /// The slices that [`Slices::to_numbers`] made the numbers of.
    ///
    /// # Errors
    /// Numbers that are none.
    pub fn from_numbers(numbers: &[f64]) -> Result<Self, Error> {
        let no = || none("the numbers given are none".into());
        let &[around, n, across, lines, low, high, ref rest @ ..] = numbers else {
            return Err(no());
        };
        let is_count = |v: &f64| v.fract() == 0.0 && (0.0..=MOST_PLACES as f64).contains(v);
        if ![n, across, lines].iter().all(is_count) || across < 1.0 || low >= high {
            return Err(no());
        }
        let [n, across, lines] = [n, across, lines].map(|v| v as usize);
        let places = n.checked_mul(across).filter(|p| *p <= MOST_PLACES);
        let needed = places.and_then(|p| (n + 1).checked_mul(lines)?.checked_add(n + p));
        if needed != Some(rest.len()) || !high.is_finite() || !low.is_finite() {
            return Err(no());
        }
        let (positions, rest) = rest.split_at(n);
        let (departure, rest) = rest.split_at(n * across);
        all_finite("features", rest)?;
        let features: Vec<Vec<f64>> = rest.chunks(n + 1).map(<[f64]>::to_vec).collect();
        Self::from_parts(positions, around == 1.0, [low, high], departure, &features)
    }
}

fn none(reason: String) -> Error {
    Error::NoSlices { reason }
}

/// Whether the sections go around without a wide gap.
fn is_closed(positions: &[f64]) -> bool {
    let widest = positions
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .fold(0.0, f64::max);
    TAU - (positions[positions.len() - 1] - positions[0]) <= WIDE * widest
}

/// Distances between sections, back to the first one if they close.
fn distances(positions: &[f64], around: bool) -> Vec<f64> {
    let mut h: Vec<f64> = positions.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if around && is_closed(positions) {
        h.push(positions[0] + TAU - positions[positions.len() - 1]);
    }
    h
}

/// Changes of values along their spline, closed if there is a distance for each of them.
fn along(h: &[f64], values: &[f64], around: bool) -> Vec<f64> {
    let n = values.len();
    let secant: Vec<f64> = h
        .iter()
        .enumerate()
        .map(|(k, h)| (values[(k + 1) % n] - values[k]) / h)
        .collect();
    if around && h.len() == n {
        spline::cyclic_slopes(h, &secant)
    } else {
        spline::slopes(h, &secant)
    }
}

/// Place across of an index.
fn place(ends: [f64; 2], count: usize, j: usize) -> f64 {
    ends[0] + (ends[1] - ends[0]) * j as f64 / (count - 1) as f64
}

/// y of the section `k` at a place on the nominal profile.
fn features_at(features: &[Vec<f64>], k: usize, v: f64) -> f64 {
    let (Some(first), Some(last)) = (features.first(), features.last()) else {
        return v;
    };
    if v <= first[0] {
        return v - first[0] + first[k + 1];
    }
    for pair in features.windows(2) {
        if v <= pair[1][0] {
            let share = (v - pair[0][0]) / (pair[1][0] - pair[0][0]);
            return pair[0][k + 1] + share * (pair[1][k + 1] - pair[0][k + 1]);
        }
    }
    v - last[0] + last[k + 1]
}

/// Bound of what a cubic goes beyond its values at the ends of an interval, with its changes there: 0 where these make it
/// monotonic [FritschCarlson1980].
fn bulge(values: [f64; 2], changes: [f64; 2], width: f64) -> f64 {
    let rise = values[1] - values[0];
    let is_monotonic = (changes.iter())
        .all(|change| (0.0..=3.0 * rise.abs()).contains(&(change * width * rise.signum())));
    if is_monotonic {
        return 0.0;
    }
    // the largest weight of a change
    4.0 / 27.0 * width * (changes[0].abs() + changes[1].abs())
}

/// Weights of value and change at both ends of an interval, for a value between them and for its change.
fn hermite(t: f64, width: f64) -> ([[f64; 2]; 2], [[f64; 2]; 2]) {
    let (t2, t3) = (t * t, t * t * t);
    let value = [
        [2.0 * t3 - 3.0 * t2 + 1.0, (t3 - 2.0 * t2 + t) * width],
        [3.0 * t2 - 2.0 * t3, (t3 - t2) * width],
    ];
    let slope = 6.0 * (t2 - t) / width;
    let change = [
        [slope, 3.0 * t2 - 4.0 * t + 1.0],
        [-slope, 3.0 * t2 - 2.0 * t],
    ];
    (value, change)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Interpolation;

    #[test]
    fn the_bound_holds_between_sections() {
        let positions = [-1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0];
        let heights = [0.0, 0.0, 0.0, -3e-4, 0.0, 1e-4, 0.0];
        let nominal = flat(0.03);
        let slices = Slices::raised(&nominal, &positions, &heights, false).unwrap();
        for k in -100..100 {
            let at = 0.01 * f64::from(k);
            let reach = 0.03;
            let [size, way] = slices.unevenness(at, reach);
            let there: Vec<f64> = (-30..=30)
                .map(|i| at + 1e-3 * f64::from(i))
                .map(|s| slices.at(&nominal, s, 0.0).height)
                .collect();
            assert!(there.iter().all(|z| z.abs() <= size + 1e-15), "{at}");
            let own: f64 = there.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
            assert!(own <= way + 1e-15, "{at}");
            assert!(size < 6e-4, "{size} at {at}");
        }
    }

    fn flat(width: f64) -> Profile {
        Profile::from_points(&[-width, width], &[0.0, 0.0], Interpolation::Linear).unwrap()
    }

    #[test]
    fn a_wave_around_is_met_to_the_fourth_order() {
        let nominal = flat(0.03);
        let error = |n: u32| {
            let angles: Vec<f64> = (0..n).map(|k| f64::from(k) * TAU / f64::from(n)).collect();
            let heights: Vec<f64> = angles.iter().map(|a| 1e-3 * (3.0 * a).sin()).collect();
            let slices = Slices::raised(&nominal, &angles, &heights, true).unwrap();
            let places = (0..997).map(|k| -7.0 + 0.02 * f64::from(k));
            let off = |a: f64| {
                let found = slices.at(&nominal, a, 0.01);
                let rate = (found.rate - 3e-3 * (3.0 * a).cos()).abs() / f64::from(n);
                (found.height - 1e-3 * (3.0 * a).sin()).abs().max(rate)
            };
            places.map(off).fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(40), error(80));
        assert!(coarse / fine > 14.0, "{coarse} {fine}");
    }

    #[test]
    fn sections_are_met_and_go_on_before_and_after() {
        let nominal = Profile::rail_60e1();
        let y: Vec<f64> = (0..=700).map(|k| -0.035 + 1e-4 * f64::from(k)).collect();
        let worn = |by: f64| {
            let z: Vec<f64> = y
                .iter()
                .map(|y| nominal.at(*y).unwrap().height - by * (1.0 - (y / 0.04).powi(2)))
                .collect();
            Profile::from_points(&y, &z, Interpolation::Smooth).unwrap()
        };
        let sections: Vec<Profile> = [0.0, 1e-3, 2e-3, 0.5e-3].map(worn).into();
        let positions = [0.0, 0.1, 0.25, 0.3];
        let slices = Slices::new(&nominal, &positions, &sections, &[], false).unwrap();
        for (s, k) in [(0.0, 0), (0.1, 1), (0.25, 2), (0.3, 3), (-1.0, 0), (2.0, 3)] {
            for y in [-0.02, 0.0, 0.0123, 0.03] {
                let found = slices.at(&nominal, s, y);
                let exact = sections[k].at(y).unwrap();
                assert!((found.height - exact.height).abs() < 2e-8, "{s} {y}");
                assert!((found.slope - exact.slope).abs() < 1e-4, "{s} {y}");
            }
        }
        let again = Slices::from_numbers(&slices.to_numbers()).unwrap();
        assert_eq!(again, slices);
        let numbers = slices.to_numbers();
        assert!(Slices::from_numbers(&numbers[..numbers.len() - 1]).is_err());
    }

    #[test]
    fn a_feature_takes_its_shape_along() {
        // a corner that moves aside by 4 mm: without features it would be blurred
        let corner = |at: f64| {
            let y = [-0.03, at, 0.03];
            let z = y.map(|y| -0.5 * (y - at).max(0.0));
            Profile::from_points(&y, &z, Interpolation::Linear).unwrap()
        };
        let positions = [0.0, 0.1, 0.2, 0.3, 0.4];
        let at = |s: f64| 0.01 * s;
        let sections: Vec<Profile> = positions.iter().map(|s| corner(at(*s))).collect();
        let mut feature = vec![0.0];
        feature.extend(positions.iter().map(|s| at(*s)));
        let nominal = corner(0.0);
        let slices = Slices::new(&nominal, &positions, &sections, &[feature], false).unwrap();
        for s in [0.05, 0.13, 0.37] {
            for y in [-0.01, at(s) - 1e-4, at(s) + 1e-4, 0.02] {
                let found = slices.at(&nominal, s, y);
                let exact = -0.5 * (y - at(s)).max(0.0);
                assert!((found.height - exact).abs() < 1e-12, "{s} {y}");
                let rate = if y > at(s) { 0.5 * 0.01 } else { 0.0 };
                assert!((found.rate - rate).abs() < 1e-9, "{s} {y} {}", found.rate);
            }
        }
    }

    #[test]
    fn what_makes_no_slices_is_refused() {
        let nominal = flat(0.03);
        let raised = |positions: &[f64], around| {
            Slices::raised(&nominal, positions, &vec![0.0; positions.len()], around)
                .map_err(|e| e.to_string())
        };
        assert!(raised(&[0.0], false).is_err());
        assert!(raised(&[0.0, 0.0], false).is_err());
        assert!(raised(&[0.0, 1.0, 2.0], true).is_err());
        assert!(raised(&[0.0, 2.0, 4.0, 6.3], true).is_err());
        // once around and back
        let whole = raised(&[0.0, 2.0, 4.0, 5.0, TAU], true).unwrap();
        assert_eq!(whole.positions().len(), 4);
        let narrow = [flat(0.03), flat(5e-5)];
        assert!(Slices::new(&nominal, &[0.0, 1.0], &narrow, &[], false).is_err());
    }

    #[test]
    fn a_part_of_a_wheel_leaves_the_rest_linear() {
        let nominal = flat(0.03);
        let angles: Vec<f64> = (0..=20).map(|k| 0.01 * f64::from(k)).collect();
        let heights: Vec<f64> = angles.iter().map(|a| 1e-4 * (a / 0.2)).collect();
        let slices = Slices::raised(&nominal, &angles, &heights, true).unwrap();
        let back = slices.at(&nominal, 0.2 + 0.5 * (TAU - 0.2), 0.0);
        assert!((back.height - 0.5e-4).abs() < 1e-12);
        assert!((back.rate + 1e-4 / (TAU - 0.2)).abs() < 1e-12);
    }
}

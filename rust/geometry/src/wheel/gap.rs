// SPDX-License-Identifier: MIT OR Apache-2.0
//! The gap over the contact plane.

use mtb_words::Short;
use rayon::prelude::*;

use super::section::Section;
use super::{WheelOnRail, WheelRailContact};
use crate::error::{out_of_range, positive};
use crate::root;
use crate::{Error, Look};

/// More points than this are taken for a mistake in the spacing.
const MOST_POINTS: f64 = 1e7;
/// Points between two looks at a wish to stop, and of a row at once: about a tenth of a second.
const POINTS_UNWATCHED: usize = 100_000;
const OF_A_ROW: usize = 5_000;
/// Cells kept free around the overlap, so that a contact estimated a little small still fits.
const MARGIN: f64 = 2.0;
/// Half of the longest grid, over the radius of the wheel or of the roller.
const LONGEST: f64 = 0.9;

/// The gap on a regular grid in the contact plane.
#[derive(Clone, Debug, PartialEq)]
pub struct GapField {
    /// Distance between the undeformed bodies along the normal of the plane [m], (ny, nx) with x
    /// fastest; the least distance, on or between the points, is zero.
    pub gap: Vec<f64>,
    /// Points along x.
    pub nx: usize,
    /// Points across.
    pub ny: usize,
    /// Distance of the points along x and across [m].
    pub spacing: [f64; 2],
    /// First point in the contact plane [m]; the origin is itself a point.
    pub start: [f64; 2],
}

/// The line `origin + s t + h n` of a cut across the contact plane, and a curve over it.
struct Cut<F> {
    curve: F,
    bracket: [f64; 2],
}

impl<F: Fn(f64) -> ([f64; 2], [f64; 2])> Cut<F> {
    /// Height over the plane at `s`, and the parameter of the curve there.
    fn height(&self, s: f64, guess: f64) -> (f64, f64) {
        let along = |v: f64| {
            let (p, d) = (self.curve)(v);
            (p[0], d[0])
        };
        let v = root::increasing(along, s, self.bracket, guess);
        ((self.curve)(v).0[1], v)
    }
}

impl WheelOnRail {
    /// The grid must be shorter than the wheel and the roller.
    fn check_length(&self, half_length: f64, scale: f64, dx: f64) -> Result<(), Error> {
        let (name, radius) = match self.roller_radius {
            Some(radius) if radius < self.wheel_radius => ("roller_radius", radius),
            _ => ("wheel_radius", self.wheel_radius),
        };
        let half = scale * half_length + MARGIN * dx;
        let most = LONGEST * radius;
        if half < most {
            return Ok(());
        }
        let largest = (most - MARGIN * dx) / half_length;
        if largest > 1.0 {
            let accepted = format!(
                "the grid would be as long as the wheel or the roller; less than {} is needed",
                Short(largest)
            );
            return Err(out_of_range("scale", scale, accepted));
        }
        let accepted = format!(
            "the contact and {MARGIN} cells beyond it reach {} m ahead, so a radius above {} m is needed",
            Short(half),
            Short(half / LONGEST)
        );
        Err(out_of_range(name, radius, accepted))
    }

    /// The undeformed gap around a contact, `scale` times as large as the overlap of the bodies.
    ///
    /// Wheel as a surface of revolution, rail as a prism or one too (a roller), all exact. The wheel is lowered vertically
    /// by the approach before distances are measured, since in a curved, nearly conforming contact
    /// lowering and moving along the normal differ.
    ///
    /// # Errors
    /// A spacing that is not positive, leaves fewer than 3 points or takes more than ten millions, a scale
    /// below 0.1, profiles that end inside the overlap, slices; an interruption by `look`.
    pub fn gap(
        &self,
        contact: &WheelRailContact,
        spacing: [f64; 2],
        scale: f64,
        look: Look<'_>,
    ) -> Result<GapField, Error> {
        self.check()?;
        if self.has_slices() {
            return Err(Error::Sliced {
                what: "this gap is",
            });
        }
        let dx = positive("spacing along x", spacing[0])?;
        let dy = positive("spacing across", spacing[1])?;
        if positive("scale", scale)? < 0.1 {
            return Err(out_of_range("scale", scale, "at least 0.1 is needed"));
        }
        let section = Section::new(self)?;
        let (sin, cos) = contact.angle.sin_cos();
        let origin = contact.origin;
        let into_plane = move |p: [f64; 2], d: [f64; 2]| {
            let p = [p[0] - origin[0], p[1] - origin[1]];
            (
                [cos * p[0] + sin * p[1], cos * p[1] - sin * p[0]],
                [cos * d[0] + sin * d[1], cos * d[1] - sin * d[0]],
            )
        };
        let nan = ([f64::NAN; 2], [f64::NAN; 2]);
        let roller = self.roller();
        let rail = |x: f64, v: f64| {
            let Some((mut p, mut d)) = section.rail.point(&self.rail, v) else {
                return nan;
            };
            if let Some(roller) = roller {
                let radius = roller.radius + p[1];
                let root = ((radius - x) * (radius + x)).sqrt();
                p[1] -= x * x / (radius + root);
                d[1] *= radius / root;
            }
            into_plane(p, d)
        };
        let axle = section.height - contact.approach / cos + self.wheel_radius;
        let wheel = |x: f64, v: f64| {
            let Some(station) = self.wheel.at(v) else {
                return nan;
            };
            let radius = self.wheel_radius - station.height;
            let root = ((radius - x) * (radius + x)).sqrt();
            let p = [section.tape + v, axle - root];
            into_plane(p, [1.0, radius / root * station.slope])
        };
        if dx > contact.half_length {
            let accepted = format!(
                "the contact is only about {} m long",
                Short(2.0 * contact.half_length)
            );
            return Err(out_of_range("spacing along x", dx, accepted));
        }
        let half = scale * contact.half_length + MARGIN * dx;
        self.check_length(contact.half_length, scale, dx)?;
        let rail_bracket = rising(
            |v| rail(if roller.is_some() { half } else { 0.0 }, v),
            self.rail.range(),
            contact.rail_position,
        );
        let wheel_bracket = rising(
            |v| wheel(half, v),
            self.wheel.range(),
            contact.wheel_position,
        );

        // points are whole multiples of the spacing from the origin, inside both profiles
        let reach = |end: usize| {
            [
                rail(0.0, rail_bracket[end]).0[0],
                rail(half, rail_bracket[end]).0[0],
                wheel(0.0, wheel_bracket[end]).0[0],
                wheel(half, wheel_bracket[end]).0[0],
            ]
        };
        let ends = [
            reach(0).into_iter().fold(f64::NEG_INFINITY, f64::max),
            reach(1).into_iter().fold(f64::INFINITY, f64::min),
        ];
        let last_x = (half / dx).floor();
        let low = ((scale * contact.across[0] - MARGIN * dy).max(ends[0]) / dy).ceil();
        let high = ((scale * contact.across[1] + MARGIN * dy).min(ends[1]) / dy).floor();
        let size = (2.0 * last_x + 1.0, high - low + 1.0);
        if size.0 < 3.0 || size.1 < 3.0 {
            let accepted = format!(
                "it leaves {} x {} points, at least 3 x 3 are needed",
                size.0, size.1
            );
            return Err(out_of_range("spacing", dx.max(dy), accepted));
        }
        if size.0 * size.1 > MOST_POINTS {
            return Err(Error::TooManyPoints {
                nx: size.0,
                ny: size.1,
                dx,
                dy,
                most: MOST_POINTS,
            });
        }
        let (nx, ny) = (size.0 as usize, size.1 as usize);
        let middle = last_x as usize;

        let rail_cut = |x: f64| Cut {
            bracket: rail_bracket,
            curve: move |v| rail(x, v),
        };
        let wheel_cut = |x: f64| Cut {
            bracket: wheel_bracket,
            curve: move |v| wheel(x, v),
        };
        let guess = [contact.rail_position, contact.wheel_position];
        let mut gap = vec![0.0; nx * ny];
        let columns: Vec<usize> = (0..=middle).collect();
        for part in columns.chunks(OF_A_ROW) {
            let rows = POINTS_UNWATCHED.div_ceil(part.len());
            for (round, lines) in gap.chunks_mut(rows * nx).enumerate() {
                lines
                    .par_chunks_mut(nx)
                    .enumerate()
                    .for_each(|(row, line)| {
                        let s = (low + (round * rows + row) as f64) * dy;
                        // a straight rail is a prism, so that one place is enough for a row
                        let (mut below, mut rail_v) = rail_cut(0.0).height(s, guess[0] + cos * s);
                        let mut wheel_v = guess[1] + cos * s;
                        for &i in part {
                            if roller.is_some() {
                                (below, rail_v) = rail_cut(i as f64 * dx).height(s, rail_v);
                            }
                            let (above, v) = wheel_cut(i as f64 * dx).height(s, wheel_v);
                            wheel_v = v;
                            line[middle + i] = above - below;
                            line[middle - i] = above - below;
                        }
                    });
                if look().is_break() {
                    return Err(Error::Interrupted);
                }
            }
        }
        let lowest = (0..ny)
            .min_by(|&a, &b| gap[a * nx + middle].total_cmp(&gap[b * nx + middle]))
            .unwrap_or(0);
        let bracket = [lowest.max(1) - 1, (lowest + 1).min(ny - 1)].map(|i| (low + i as f64) * dy);
        let profile_gap =
            |s: f64| wheel_cut(0.0).height(s, guess[1]).0 - rail_cut(0.0).height(s, guess[0]).0;
        let touch = root::minimum(profile_gap, bracket);
        let least = profile_gap(touch).min(gap[lowest * nx + middle]);
        for value in &mut gap {
            *value -= least;
        }
        Ok(GapField {
            gap,
            nx,
            ny,
            spacing: [dx, dy],
            start: [-last_x * dx, low * dy],
        })
    }
}

/// The part of `range` around `position` where a curve moves forward along the plane.
fn rising(curve: impl Fn(f64) -> ([f64; 2], [f64; 2]), range: [f64; 2], position: f64) -> [f64; 2] {
    let step = 2e-5;
    let forward = |v: f64| {
        let direction = curve(v).1;
        direction[0] > 0.1 * direction[1].abs()
    };
    let walk = |end: f64, sign: f64| {
        let mut v = position.clamp(range[0], range[1]);
        while (end - v) * sign > step && forward(v + sign * step) {
            v += sign * step;
        }
        if (end - v) * sign <= step && forward(end) {
            end
        } else {
            v
        }
    };
    [walk(range[0], -1.0), walk(range[1], 1.0)]
}

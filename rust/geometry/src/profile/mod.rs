// SPDX-License-Identifier: MIT OR Apache-2.0
//! Profiles: heights z(y) in the cross-section of a rail or a wheel.

mod file;
mod numbers;
mod piece;
mod slices;
mod spline;
mod standard;

use mtb_words::Short;

use crate::Error;
use crate::error::{all_finite, out_of_range};
use piece::{Curve, Piece};

pub use file::{ProfileForm, ProfileTable, Vertical};
pub use piece::Station;
pub use slices::{Sliced, Slices};

/// Coordinates beyond this [m], and steps along y below it, are refused: slopes and curvatures would overflow.
const FARTHEST: f64 = 1e9;
const CLOSEST: f64 = 1e-12;

/// How a profile runs between tabulated points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Twice continuously differentiable cubic spline (not-a-knot ends).
    Smooth,
    /// Straight lines: a profile with kinks, which keeps every irregularity of the table.
    Linear,
}

/// A height z(y) [m], z up, made of polynomials and circular arcs between lateral positions [m].
///
/// # Example
/// ```
/// let rail = mtb_geometry::Profile::rail_60e1();
/// assert!((rail.range()[1] - 36.000e-3).abs() < 1e-6);
/// assert!((rail.arc_length(&[0.02]).unwrap()[0] - 0.020_053).abs() < 1e-6);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    pieces: Vec<Piece>,
    /// Arc length from the start of the profile to its origin.
    origin: f64,
}

impl Profile {
    /// A profile through points `(y, z)` [m]; y strictly rising or strictly falling.
    ///
    /// # Errors
    /// Fewer than two points, lengths that differ, values that are not finite, y not monotonic.
    pub fn from_points(y: &[f64], z: &[f64], interpolation: Interpolation) -> Result<Self, Error> {
        if y.len() < 2 {
            return Err(Error::Length {
                name: "profile",
                found: y.len(),
                accepted: "at least 2 points are needed".into(),
            });
        }
        if z.len() != y.len() {
            return Err(Error::Length {
                name: "z",
                found: z.len(),
                accepted: format!("{} are needed, one for each y", y.len()),
            });
        }
        all_finite("y", y)?;
        all_finite("z", z)?;
        let falling = y[1] < y[0];
        for (row, pair) in y.windows(2).enumerate() {
            let (before, after) = if falling {
                (pair[1], pair[0])
            } else {
                (pair[0], pair[1])
            };
            if before >= after {
                return Err(Error::NotMonotonic {
                    row: row + 2,
                    y: pair[1],
                    previous: pair[0],
                });
            }
        }
        for (name, values) in [("y", y), ("z", z)] {
            if let Some(value) = values.iter().find(|v| v.abs() > FARTHEST) {
                let accepted = format!("at most {} m is accepted", Short(FARTHEST));
                return Err(out_of_range(name, *value, accepted));
            }
        }
        for pair in y.windows(2) {
            if (pair[1] - pair[0]).abs() < CLOSEST {
                let accepted = format!(
                    "points of a profile lie at least {} m apart",
                    Short(CLOSEST)
                );
                return Err(out_of_range("y", pair[1], accepted));
            }
        }
        let (mut y, mut z) = (y.to_vec(), z.to_vec());
        if falling {
            y.reverse();
            z.reverse();
        }
        Ok(Self::from_pieces(match interpolation {
            Interpolation::Smooth => spline::not_a_knot(&y, &z),
            Interpolation::Linear => (1..y.len())
                .map(|i| {
                    let slope = (z[i] - z[i - 1]) / (y[i] - y[i - 1]);
                    let curve = Curve::Polynomial {
                        origin: y[i - 1],
                        coefficients: vec![z[i - 1], slope],
                    };
                    Piece::new(y[i - 1], y[i], curve)
                })
                .collect(),
        }))
    }

    /// Profile of adjacent pieces in rising order.
    fn from_pieces(mut pieces: Vec<Piece>) -> Self {
        let mut length = 0.0;
        for piece in &mut pieces {
            piece.length_before = length;
            length += piece.length_to(piece.end);
        }
        let mut profile = Self {
            pieces,
            origin: 0.0,
        };
        let [start, end] = profile.range();
        if start <= 0.0 && end >= 0.0 {
            profile.origin = profile.length_from_start(0.0);
        }
        profile
    }

    /// First and last lateral position [m].
    pub fn range(&self) -> [f64; 2] {
        [self.pieces[0].start, self.pieces[self.pieces.len() - 1].end]
    }

    /// Arc lengths [m] at the two ends of [`Profile::range`].
    pub fn arc_range(&self) -> [f64; 2] {
        let last = &self.pieces[self.pieces.len() - 1];
        let total = last.length_before + last.length_to(last.end);
        [-self.origin, total - self.origin]
    }

    /// Height and derivatives at the lateral position `y` [m], `None` outside the profile.
    pub fn at(&self, y: f64) -> Option<Station> {
        let [start, end] = self.range();
        (y >= start && y <= end).then(|| self.piece(y).at(y))
    }

    /// Heights and derivatives at the lateral positions `y` [m].
    ///
    /// # Errors
    /// A position outside the profile or not finite.
    pub fn stations(&self, y: &[f64]) -> Result<Vec<Station>, Error> {
        all_finite("y", y)?;
        y.iter()
            .enumerate()
            .map(|(index, &y)| self.at(y).ok_or_else(|| self.outside("y", index, y)))
            .collect()
    }

    /// Arc lengths [m] at the lateral positions `y` [m], counted from y = 0 (from the start of a
    /// profile that does not contain it), rising with y.
    ///
    /// # Errors
    /// A position outside the profile or not finite.
    pub fn arc_length(&self, y: &[f64]) -> Result<Vec<f64>, Error> {
        all_finite("y", y)?;
        let [start, end] = self.range();
        y.iter()
            .enumerate()
            .map(|(index, &y)| {
                if y >= start && y <= end {
                    Ok(self.length_from_start(y) - self.origin)
                } else {
                    Err(self.outside("y", index, y))
                }
            })
            .collect()
    }

    /// Lateral positions [m] at the arc lengths `s` [m]: the inverse of [`Profile::arc_length`].
    ///
    /// # Errors
    /// An arc length outside the profile or not finite.
    pub fn position(&self, s: &[f64]) -> Result<Vec<f64>, Error> {
        all_finite("s", s)?;
        let [start, end] = self.arc_range();
        let slack = 1e-12 * (end - start);
        s.iter()
            .enumerate()
            .map(|(index, &s)| {
                if s < start - slack || s > end + slack {
                    return Err(Error::OutsideProfile {
                        name: "s",
                        index,
                        value: s,
                        start,
                        end,
                    });
                }
                let length = s + self.origin;
                let after = self.pieces.partition_point(|p| p.length_before <= length);
                let piece = &self.pieces[after.saturating_sub(1)];
                let y = piece.position_at(length - piece.length_before);
                Ok(y.clamp(piece.start, piece.end))
            })
            .collect()
    }

    /// Lateral positions [m] where one piece ends and the next begins, ends of the profile included.
    pub fn breaks(&self) -> Vec<f64> {
        let ends = self.pieces.iter().map(|p| p.end);
        std::iter::once(self.pieces[0].start).chain(ends).collect()
    }

    fn piece(&self, y: f64) -> &Piece {
        let after = self.pieces.partition_point(|p| p.start <= y);
        &self.pieces[after.saturating_sub(1)]
    }

    fn length_from_start(&self, y: f64) -> f64 {
        let piece = self.piece(y);
        piece.length_before + piece.length_to(y)
    }

    fn outside(&self, name: &'static str, index: usize, value: f64) -> Error {
        let [start, end] = self.range();
        Error::OutsideProfile {
            name,
            index,
            value,
            start,
            end,
        }
    }
}

#[cfg(test)]
mod tests;

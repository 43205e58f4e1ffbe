// SPDX-License-Identifier: MIT OR Apache-2.0
use super::piece::{Curve, Piece};
use super::{FARTHEST, Profile};
use crate::Error;

/// Largest power of a polynomial piece.
const HIGHEST_POWER: usize = 32;

impl Profile {
    /// The profile as numbers, for a file: each piece with its ends, its kind (0: polynomial, 1: arc), and the
    /// origin, count and coefficients of the polynomial, or centre (y, z), radius and side of the arc.
    pub fn to_numbers(&self) -> Vec<f64> {
        let mut numbers = Vec::new();
        for piece in &self.pieces {
            numbers.extend([piece.start, piece.end]);
            match &piece.curve {
                Curve::Polynomial {
                    origin,
                    coefficients,
                } => {
                    numbers.extend([0.0, *origin, coefficients.len() as f64]);
                    numbers.extend(coefficients);
                }
                Curve::Arc {
                    center,
                    radius,
                    side,
                } => numbers.extend([1.0, center[0], center[1], *radius, *side]),
            }
        }
        numbers
    }

    /// The profile that [`Profile::to_numbers`] made the numbers of.
    ///
    /// # Errors
    /// Numbers that are none: not finite, too large, cut short, pieces that do not follow each other.
    pub fn from_numbers(numbers: &[f64]) -> Result<Self, Error> {
        let no = |reason| Error::NoProfile { reason };
        if numbers.iter().any(|v| !v.is_finite()) {
            return Err(no("one of them is not finite"));
        }
        let mut rest = numbers;
        let mut take = |count: usize| {
            let (head, tail) = rest.split_at_checked(count).ok_or(no("some are missing"))?;
            rest = tail;
            Ok(head)
        };
        let mut pieces: Vec<Piece> = Vec::new();
        let mut left = numbers.len();
        while left > 0 {
            let &[start, end, kind] = take(3)? else {
                return Err(no("some are missing"));
            };
            left -= 3;
            let follows = pieces.last().is_none_or(|last| last.end == start);
            if !(follows && start < end && start.abs().max(end.abs()) <= FARTHEST) {
                return Err(no("its pieces do not follow each other"));
            }
            let curve = if kind == 0.0 {
                let &[origin, count] = take(2)? else {
                    return Err(no("some are missing"));
                };
                if !(1..=HIGHEST_POWER).contains(&(count as usize)) || count.fract() != 0.0 {
                    return Err(no("a polynomial has no such number of coefficients"));
                }
                let coefficients = take(count as usize)?.to_vec();
                left -= 2 + coefficients.len();
                let reach = (start - origin).abs().max((end - origin).abs());
                // largest size of the height and of its derivatives
                let bound = coefficients
                    .iter()
                    .rev()
                    .fold(0.0, |b, c| b * reach + c.abs());
                if !bound.is_finite() || bound > FARTHEST {
                    return Err(no("a polynomial is too large"));
                }
                Curve::Polynomial {
                    origin,
                    coefficients,
                }
            } else if kind == 1.0 {
                let &[y, z, radius, side] = take(4)? else {
                    return Err(no("some are missing"));
                };
                left -= 4;
                let reach = (start - y).abs().max((end - y).abs());
                let is_arc = reach <= radius * (1.0 + 1e-9) && radius <= FARTHEST;
                if !is_arc || z.abs() > FARTHEST || side.abs() != 1.0 {
                    return Err(no("an arc does not reach its ends"));
                }
                Curve::Arc {
                    center: [y, z],
                    radius,
                    side,
                }
            } else {
                return Err(no("a piece is neither polynomial nor arc"));
            };
            pieces.push(Piece::new(start, end, curve));
        }
        if pieces.is_empty() {
            return Err(no("there are none"));
        }
        Ok(Self::from_pieces(pieces))
    }
}

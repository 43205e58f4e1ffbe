// SPDX-License-Identifier: MIT OR Apache-2.0
//! Symmetric complementarity problems of any size, known only by their products.
//!
//! Find `p >= 0` and `c` with `w = A p + b - N c >= 0`, `w . p = 0` and `N^T p = f`, where `A` is symmetric
//! positive definite on what the balance allows and comes as a closure, with a second closure that
//! roughly inverts it.
//!
//! The method is a conjugate gradient on the set of points that carry or would carry pressure
//! [PolonskyKeer1999, Vollebregt2014], preconditioned on that set, with two economies. A step that
//! would make pressures negative is cut off first, with the length of the step before, and only then
//! multiplied, so it costs one product instead of two and its exact minimiser along the cut
//! direction is known as well. And the image of the free motions under the preconditioner, needed to
//! keep the balance, is renewed only once the set has changed by a fifth.

mod held;
mod solver;
mod state;
mod sums;
mod unsymmetric;

use crate::error::{Error, check};

pub use held::{Held, HeldSolution};
pub use solver::{solve, solve_capped};
pub use unsymmetric::solve_unsymmetric;

/// The data of the problem.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// `b`, n.
    pub offset: &'a [f64],
    /// The free motions, at most three; none where all motion is prescribed and part of `b`.
    pub modes: &'a [Mode],
}

impl Problem<'_> {
    /// Wrong lengths, and numbers that are not finite, in the problem or in a `start` (n).
    fn check(&self, start: &[f64]) -> Result<(), Error> {
        let n = self.offset.len();
        check("offset", self.offset, n)?;
        check("start", start, n)?;
        for mode in self.modes {
            check("mode", &mode.shape, n)?;
            check("target", &[mode.target], 1)?;
        }
        Ok(())
    }
}

/// A free motion and the balance that determines it.
#[derive(Clone, Debug)]
pub struct Mode {
    /// A column of `N`, n: how far a unit of the motion closes each gap.
    pub shape: Vec<f64>,
    /// The entry of `f`.
    pub target: f64,
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Relative residual that counts as solved; see [`Solution::residual`].
    pub tolerance: f64,
    /// Most iterations.
    pub max_iterations: usize,
}

/// How the search for a solution ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The residual fell to the tolerance.
    Solved,
    /// The residual stopped falling above the tolerance: rounding, or a matrix that is not positive definite.
    Stagnated,
    /// The iterations are used up.
    IterationLimit,
    /// No `p >= 0` was found that meets the balance.
    Unreachable,
}

/// The point where the search ended.
#[derive(Clone, Debug)]
pub struct Solution {
    /// How it ended; only [`Status::Solved`] is a solution.
    pub status: Status,
    /// `p`, n.
    pub pressure: Vec<f64>,
    /// `w`, n.
    pub slack: Vec<f64>,
    /// `c`, one per mode.
    pub motion: Vec<f64>,
    /// Steps taken.
    pub iterations: usize,
    /// Products with `A`.
    pub products: usize,
    /// Applications of the preconditioner.
    pub preconditionings: usize,
    /// How far the conditions are from being met; see [`Judgement`].
    pub residual: f64,
    /// The residual before each step, and the last one.
    pub history: Vec<f64>,
}

/// The relative complementarity residual of a point, whoever found it: the largest `|w|` where `p > 0` and the
/// largest `-w` elsewhere, over the root mean square of `A p` where `p > 0`.
///
/// ```
/// let mut judged = mtb_complementarity::bounded::Judgement::default();
/// for (pressure, slack, image) in [(1.0, 1e-9, 2.0), (3.0, 0.0, 2.0), (0.0, 5.0, 0.1)] {
///     judged.take(pressure, slack, image);
/// }
/// assert_eq!(judged.residual(), 0.5e-9);
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Judgement {
    wrong: f64,
    squares: f64,
    count: usize,
}

impl Judgement {
    /// Takes one of the points in: its `p`, its `w` and its entry of `A p`.
    pub fn take(&mut self, pressure: f64, slack: f64, image: f64) {
        let is_loaded = pressure > 0.0;
        let wrong = if is_loaded { slack.abs() } else { -slack };
        // a number that is none must not pass for a good one
        if wrong > self.wrong || wrong.is_nan() {
            self.wrong = wrong;
        }
        if is_loaded {
            self.squares += image * image;
            self.count += 1;
        }
    }

    /// The residual of all points taken in; 1 where something is wrong and nothing moves.
    pub fn residual(&self) -> f64 {
        if self.wrong == 0.0 {
            return 0.0;
        }
        if self.squares == 0.0 {
            return 1.0;
        }
        self.wrong / (self.squares / self.count as f64).sqrt()
    }
}

#[cfg(test)]
mod tests;

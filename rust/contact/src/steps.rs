// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lengths of implicit steps, over a distance or over the time, by an estimate of their error.
//!
//! A step of the implicit rule ends with the rate at its end. It errs by half of its length times the change of the
//! rate, which is known without a further solve.

/// Error of a step, in parts of what is aimed at, above which it is taken again.
const ACCEPTED: f64 = 1.5;
/// Share of the length that the estimate promises which is taken, and the most that a step may grow and shrink.
const CAUTION: f64 = 0.8;
const GROWTH: f64 = 5.0;
const SHRINKAGE: f64 = 0.1;
/// Share of all that has come together which counts beside what a step adds: where a process ends, steps still grow.
const OF_ALL: f64 = 0.1;
/// Lengths that are tried for a step.
const TRIALS: usize = 30;
/// The first step, in parts of the way that it may take at most.
const FIRST: f64 = 1e-3;

/// Chooses the lengths of steps.
#[derive(Clone, Debug)]
pub struct StepControl {
    tolerance: f64,
    next: Option<f64>,
    rejected: usize,
}

impl StepControl {
    /// For steps with about an error of `tolerance`.
    pub fn new(tolerance: f64) -> Self {
        Self {
            tolerance,
            next: None,
            rejected: 0,
        }
    }

    /// The length that the last step promises for the next one.
    pub fn next(&self) -> Option<f64> {
        self.next
    }

    /// Begins with a step of at most this length, as one that ended before has promised it.
    pub fn begin_with(&mut self, next: Option<f64>) {
        self.next = next;
    }

    /// The length to try first, where `most` is left.
    pub fn length(&self, most: f64) -> f64 {
        self.next.unwrap_or(FIRST * most).min(most)
    }

    /// Judges a step of a `length` by its `error`, where `most` was left: `None` if it is taken, otherwise the shorter
    /// length to try. An error that is no number is that of a step without a state.
    pub fn judge(&mut self, length: f64, most: f64, error: f64) -> Option<f64> {
        let share = if error.is_nan() {
            0.0
        } else {
            self.tolerance / error.max(f64::MIN_POSITIVE)
        };
        if error <= ACCEPTED * self.tolerance {
            let further = length * (CAUTION * share).clamp(SHRINKAGE, GROWTH);
            // a last step that is cut short promises no less than before
            let before = if length < most {
                0.0
            } else {
                self.next.unwrap_or(0.0)
            };
            self.next = Some(further.max(before));
            self.rejected = 0;
            return None;
        }
        self.rejected += 1;
        Some(length * (CAUTION * share).clamp(SHRINKAGE, CAUTION))
    }

    /// Whether so many lengths were tried in vain that no step is short enough.
    pub fn is_stuck(&self) -> bool {
        self.rejected >= TRIALS
    }
}

/// What has come together at each point before a step, and what the step adds, with the areas (n) [m2] of the points.
#[derive(Clone, Copy, Debug)]
pub struct Gathered<'a> {
    /// Areas (n) [m2].
    pub area: &'a [f64],
    /// Before the step (n).
    pub before: &'a [f64],
    /// By the step (n).
    pub step: &'a [f64],
}

impl Gathered<'_> {
    /// An error (n), in parts of the step and a tenth of all; root mean squares over the area.
    pub fn relative(&self, error: impl Fn(usize) -> f64) -> f64 {
        let size = |field: &dyn Fn(usize) -> f64| {
            let squares = self
                .area
                .iter()
                .enumerate()
                .map(|(i, a)| a * field(i).powi(2));
            squares.sum::<f64>().sqrt()
        };
        let all = size(&|i| self.step[i]) + OF_ALL * size(&|i| self.before[i] + self.step[i]);
        if all > 0.0 { size(&error) / all } else { 0.0 }
    }

    /// The error of a step of a `length`, `rate` (n) before and `wanted` (n) by the rate after it.
    pub fn of_length(&self, length: f64, rate: &[f64], wanted: &[f64]) -> f64 {
        self.relative(|i| 0.5 * (wanted[i] - length * rate[i]))
    }
}

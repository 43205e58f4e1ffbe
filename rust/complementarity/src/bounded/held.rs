// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::krylov::{dot, gmres};
use mtb_operator::{Monitor, report};

use super::Mode;
use super::solver::{Inverse, Product};
use super::state::solve_small;
use super::sums::Spans;
use crate::error::{Error, check};

/// Energy of the error, over that of the solution, at which a solve ends: what rounding leaves of a sum of a
/// million terms.
const ENOUGH: f64 = 1e-28;
/// The same that a solution must reach at least, once rounding stands against more.
const NEEDED: f64 = 1e-18;

/// Part of the largest target that rounding may leave missing.
const BALANCED: f64 = 1e-9;

const MAX_ITERATIONS: usize = 1000;

/// Residual, over what is asked for, at which a solve without symmetry ends, and the one it must reach at least.
const SMALL: f64 = 1e-13;
/// Part of all that is asked for that rounding leaves where it presses against the motions only.
const ROUNDING: f64 = 1e-14;
const LEAST_WITHOUT_SYMMETRY: f64 = 1e-10;

/// Basis vectors between two restarts of a solve without symmetry, and most restarts.
const BASIS: usize = 80;
const RESTARTS: usize = 10;

/// The linear problem that is left of a complementarity problem once its contact set is held: `A x - N c = b` on
/// the set, `x = 0` elsewhere, `N^T x = f`.
///
/// It is what differentiates a solution. A conjugate gradient with the product and the rough inverse of
/// [`solve`](super::solve), among the fields that keep the balance; the motions are taken off the residual
/// as they are found, so that they need not cancel in it. [Gould2001]
pub struct Held<'a> {
    apply: Product<'a>,
    precondition: Inverse<'a>,
    modes: &'a [Mode],
    set: &'a [bool],
    spans: Spans,
    /// The motions under the rough inverse, and their products with the motions on the set.
    images: Vec<Vec<f64>>,
    image_gram: [[f64; 3]; 3],
    /// Products with `A` so far.
    pub products: usize,
    /// Applications of the rough inverse so far.
    pub preconditionings: usize,
}

/// A solution of a [`Held`] problem.
#[derive(Clone, Debug)]
pub struct HeldSolution {
    /// `x`, n.
    pub pressure: Vec<f64>,
    /// `A x`, n.
    pub image: Vec<f64>,
    /// `c`, one per mode.
    pub motion: Vec<f64>,
    /// Whether the energy of the error fell far enough below that of the solution.
    pub converged: bool,
}

impl<'a> Held<'a> {
    /// The problem on `set` (n); `apply` and `precondition` as of [`solve`](super::solve).
    pub fn new(
        apply: Product<'a>,
        precondition: Inverse<'a>,
        modes: &'a [Mode],
        set: &'a [bool],
    ) -> Self {
        let mut held = Self {
            apply,
            precondition,
            modes,
            set,
            spans: Spans::of(set),
            images: Vec::new(),
            image_gram: [[0.0; 3]; 3],
            products: 0,
            preconditionings: 0,
        };
        for mode in modes {
            let shape = held.on_set(&mode.shape);
            let image = held.preconditioned(&shape);
            held.images.push(image);
        }
        for (k, mode) in modes.iter().enumerate() {
            for (l, image) in held.images.iter().enumerate() {
                held.image_gram[k][l] = held.spans.dot(&mode.shape, image, set);
            }
        }
        held
    }

    /// Solves for `right` (n; what it holds off the set is of no account) and `target` (one per mode).
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, [`Error::Interrupted`] by the monitor.
    pub fn solve(
        &mut self,
        right: &[f64],
        target: &[f64],
        monitor: Monitor<'_>,
    ) -> Result<HeldSolution, Error> {
        let n = self.set.len();
        let mut solution = self.balanced(right, target)?;
        if !solution.converged {
            return Ok(solution);
        }
        let mut r = self.on_set(right);
        let image = self.on_set(&solution.image);
        add(&mut r, -1.0, &image);
        let (mut z, size) = self.projected(&mut r, &mut solution.motion);
        let mut direction = z.clone();
        let mut image = vec![0.0; n];
        let mut slope = self.spans.dot(&r, &z, self.set);
        let mut error = f64::INFINITY;
        for iteration in 0..MAX_ITERATIONS {
            let energy = self
                .spans
                .dot_in(&solution.pressure, &solution.image, self.set);
            error = slope / energy.max(slope).max(f64::MIN_POSITIVE);
            // what presses against the motions only leaves nothing but rounding
            if slope <= ENOUGH * size || error <= ENOUGH {
                error = 0.0;
                break;
            }
            report(monitor, iteration, error.sqrt())?;
            self.multiply(&direction, &mut image);
            let curvature = self.spans.dot_in(&direction, &image, self.set);
            if curvature.is_nan() || curvature <= 0.0 {
                break;
            }
            let length = slope / curvature;
            add(&mut solution.pressure, length, &direction);
            add(&mut solution.image, length, &image);
            for ((r, image), is_in) in r.iter_mut().zip(&image).zip(self.set) {
                *r -= if *is_in { length * image } else { 0.0 };
            }
            let (next_z, _) = self.projected(&mut r, &mut solution.motion);
            let old = std::mem::replace(&mut z, next_z);
            let next = self.spans.dot(&r, &z, self.set);
            // the rough inverse is symmetric to rounding only
            let beta = ((next - self.spans.dot(&r, &old, self.set)) / slope).max(0.0);
            slope = next;
            for (d, z) in direction.iter_mut().zip(&z) {
                *d = z + beta * *d;
            }
        }
        solution.converged = error <= NEEDED;
        Ok(solution)
    }

    /// [`Held::solve`] for a matrix that need not be symmetric, as that of
    /// [`solve_unsymmetric`](super::solve_unsymmetric); for that of its transpose `apply` takes the transposed product.
    ///
    /// # Errors
    /// As [`Held::solve`].
    pub fn solve_unsymmetric(
        &mut self,
        right: &[f64],
        target: &[f64],
        monitor: Monitor<'_>,
    ) -> Result<HeldSolution, Error> {
        let m = self.modes.len();
        let mut solution = self.balanced(right, target)?;
        if !solution.converged {
            return Ok(solution);
        }
        let shapes: Vec<Vec<f64>> = (self.modes.iter())
            .map(|mode| self.on_set(&mode.shape))
            .collect();
        let mut plain = [[0.0; 3]; 3];
        for (k, shape) in shapes.iter().enumerate() {
            for (l, other) in shapes.iter().enumerate() {
                plain[k][l] = dot(shape, other);
            }
        }
        // the motions that a field on the set is nearest to
        let fitted = |field: &[f64]| {
            let mut sum = [0.0; 3];
            for (sum, shape) in sum.iter_mut().zip(&shapes) {
                *sum = dot(shape, field);
            }
            solve_small(&plain, sum, m)
        };
        let left = |image: &[f64]| -> Vec<f64> {
            let pairs = right.iter().zip(image).zip(self.set);
            pairs
                .map(|((b, a), is_in)| if *is_in { b - a } else { 0.0 })
                .collect()
        };
        let without_motions = |field: &mut [f64]| {
            for (shape, c) in shapes.iter().zip(fitted(field)) {
                add(field, -c, shape);
            }
        };
        let mut residual = left(&solution.image);
        let nothing = ROUNDING * dot(&residual, &residual).sqrt();
        without_motions(&mut residual);
        let size = dot(&residual, &residual).sqrt();
        let mut reached = size;
        let (mut products, mut preconditionings) = (0, 0);
        for round in 0..RESTARTS {
            if reached <= (SMALL * size).max(nothing) {
                break;
            }
            report(monitor, round, reached / size)?;
            let found = gmres(
                |x: &[f64], y: &mut [f64]| {
                    (self.apply)(x, y);
                    for (y, is_in) in y.iter_mut().zip(self.set) {
                        *y = if *is_in { *y } else { 0.0 };
                    }
                    without_motions(y);
                },
                |x: &[f64], y: &mut [f64]| {
                    (self.precondition)(self.set, x, y);
                    for (y, is_in) in y.iter_mut().zip(self.set) {
                        *y = if *is_in { *y } else { 0.0 };
                    }
                    // the second time takes out what rounding leaves of the balance
                    for _ in 0..2 {
                        let mut sum = [0.0; 3];
                        for (sum, shape) in sum.iter_mut().zip(&shapes) {
                            *sum = dot(shape, y);
                        }
                        let by = solve_small(&self.image_gram, sum, m);
                        for (image, c) in self.images.iter().zip(by) {
                            add(y, -c, image);
                        }
                    }
                },
                &mut solution.pressure,
                &mut residual,
                SMALL * size,
                BASIS,
            );
            products += found.steps + 1;
            preconditionings += found.steps + 1;
            (self.apply)(&solution.pressure, &mut solution.image);
            residual = left(&solution.image);
            without_motions(&mut residual);
            let before = reached;
            reached = dot(&residual, &residual).sqrt();
            // what rounding leaves falls no further
            if reached > 0.5 * before {
                break;
            }
        }
        self.products += products;
        self.preconditionings += preconditionings;
        let motion = fitted(&left(&solution.image));
        solution.motion = motion[..m].iter().map(|c| -c).collect();
        solution.converged = reached <= (LEAST_WITHOUT_SYMMETRY * size).max(nothing);
        Ok(solution)
    }

    /// A field that has the targets, and its image, to begin a solution with; not converged where the set gives a motion no
    /// hold.
    fn balanced(&mut self, right: &[f64], target: &[f64]) -> Result<HeldSolution, Error> {
        let (n, m) = (self.set.len(), self.modes.len());
        check("right side", right, n)?;
        check("target", target, m)?;
        let mut solution = HeldSolution {
            pressure: vec![0.0; n],
            image: vec![0.0; n],
            motion: vec![0.0; m],
            converged: true,
        };
        if target.iter().any(|f| *f != 0.0) {
            let mut wanted = [0.0; 3];
            wanted[..m].copy_from_slice(target);
            let y = solve_small(&self.image_gram, wanted, m);
            for (image, y) in self.images.iter().zip(y) {
                add(&mut solution.pressure, y, image);
            }
            if self.is_balanced(&solution.pressure, target) {
                self.multiply(&solution.pressure, &mut solution.image);
            } else {
                solution.converged = false;
            }
        }
        Ok(solution)
    }

    /// The preconditioned part of a residual that keeps the balance. What presses against the motions is taken off
    /// the residual, and put into the motions `c`. With it the energy of the residual given.
    fn projected(&mut self, residual: &mut [f64], motion: &mut [f64]) -> (Vec<f64>, f64) {
        let mut z = self.preconditioned(residual);
        let size = self.spans.dot(residual, &z, self.set);
        let mut sum = [0.0; 3];
        for (k, mode) in self.modes.iter().enumerate() {
            sum[k] = self.spans.dot(&mode.shape, &z, self.set);
        }
        let y = solve_small(&self.image_gram, sum, self.modes.len());
        for (k, mode) in self.modes.iter().enumerate() {
            motion[k] -= y[k];
            add(&mut z, -y[k], &self.images[k]);
            for ((r, shape), is_in) in residual.iter_mut().zip(&mode.shape).zip(self.set) {
                *r -= if *is_in { y[k] * shape } else { 0.0 };
            }
        }
        (z, size)
    }

    /// Whether a field has the targets; it has not where the set gives a motion no hold.
    fn is_balanced(&self, field: &[f64], target: &[f64]) -> bool {
        let largest = target.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        let missing = |(mode, target): (&Mode, &f64)| {
            (self.spans.dot(&mode.shape, field, self.set) - target).abs()
        };
        let mut pairs = self.modes.iter().zip(target);
        pairs.all(|pair| missing(pair) <= BALANCED * largest)
    }

    fn on_set(&self, field: &[f64]) -> Vec<f64> {
        let pairs = field.iter().zip(self.set);
        pairs
            .map(|(v, is_in)| if *is_in { *v } else { 0.0 })
            .collect()
    }

    fn multiply(&mut self, x: &[f64], y: &mut [f64]) {
        (self.apply)(x, y);
        self.products += 1;
    }

    fn preconditioned(&mut self, field: &[f64]) -> Vec<f64> {
        let mut image = vec![0.0; field.len()];
        (self.precondition)(self.set, field, &mut image);
        self.preconditionings += 1;
        self.on_set(&image)
    }
}

fn add(to: &mut [f64], scale: f64, field: &[f64]) {
    for (to, v) in to.iter_mut().zip(field) {
        *to += scale * v;
    }
}

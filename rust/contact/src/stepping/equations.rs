// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::krylov::gmres;

use super::bordered::Bordered;
use super::influence::{Influence, Sum, Terms, largest};
use super::{Effort, PRODUCTS};
use crate::sliding::SlidingContact;

/// Relative residual at which the equations on an active set count as solved ...
pub(super) const TOLERANCE: f64 = 1e-13;
/// ... and which must be reached.
pub(super) const ACCEPTED: f64 = 1e-11;
/// Residual that is enough to see which points have the wrong sign, while sets still change.
pub(super) const ROUGH: f64 = 1e-4;
/// Share of the work of the largest pressure below which the parts of a balance are not its scale any more.
const LEAST: f64 = 1e-5;

#[derive(Default)]
pub(super) struct Scratch {
    pub(super) gap: Vec<f64>,
    pub(super) pressure: Vec<f64>,
    /// Pressures of this step whose gaps by the pressure are known, without the motions; empty before there are any.
    pub(super) known: Vec<f64>,
    pub(super) pressed: Vec<f64>,
    pub(super) sum: Sum,
}

/// The equations of one step on one set of points.
pub(super) struct Equations<'a> {
    pub(super) influence: &'a Influence,
    pub(super) contact: &'a SlidingContact<'a>,
    pub(super) terms: &'a Terms,
    pub(super) points: &'a [usize],
}

impl Equations<'_> {
    /// Improves `x` (pressures of the set, then motions) until the equations hold to `tolerance`, and to rounding
    /// if it starts near; the relative residual reached, if they do.
    ///
    /// Leaves the gaps of all points in the scratch.
    pub(super) fn solve(
        &self,
        factors: &mut Bordered,
        x: &mut [f64],
        tolerance: f64,
        scratch: &mut Scratch,
        effort: &mut Effort,
    ) -> Option<f64> {
        let mut r = vec![0.0; x.len()];
        let mut scale = vec![1.0; x.len()];
        let mut step = vec![0.0; x.len()];
        let mut error = self.residual(x, &mut r, &mut scale, scratch, effort);
        // so near, the set will hold
        let tolerance = if error <= ROUGH { TOLERANCE } else { tolerance };
        let exact = factors.is_exact(self.terms);
        // as dear as a factorisation, at two products a step
        let most_steps = 3 + self.points.len() / (2 * PRODUCTS);
        let mut before = error;
        for sweep in 0..6 {
            if error <= tolerance {
                return Some(error);
            }
            let contraction = error / before;
            if sweep == 1 && !exact {
                let steps = (error / tolerance).ln() / -contraction.ln();
                if contraction >= 1.0 || steps > 2.0 * most_steps as f64 {
                    return None;
                }
            }
            if sweep > 1 && contraction >= 0.1 {
                break;
            }
            before = error;
            if exact || sweep == 0 {
                step.copy_from_slice(&r);
                factors.solve(&mut step, self.points);
                effort.products += 1;
            } else {
                // rows scaled to like units; the factors are the preconditioner
                r.iter_mut().zip(&scale).for_each(|(r, s)| *r /= s);
                step.fill(0.0);
                let report = gmres(
                    |v, out| {
                        self.product(v, out, scratch);
                        out.iter_mut().zip(&scale).for_each(|(o, s)| *o /= s);
                    },
                    |v, out| {
                        out.iter_mut()
                            .zip(v)
                            .zip(&scale)
                            .for_each(|((o, v), s)| *o = v * s);
                        factors.solve(out, self.points);
                    },
                    &mut step,
                    &mut r,
                    0.3 * tolerance * (x.len() as f64).sqrt(),
                    most_steps,
                );
                effort.products += 2 * report.steps + 1;
            }
            x.iter_mut().zip(&step).for_each(|(x, s)| *x += s);
            error = self.residual(x, &mut r, &mut scale, scratch, effort);
        }
        (error <= ACCEPTED.max(tolerance)).then_some(error)
    }

    /// What is left of the equations at `x`, its size relative to `scale`, which is set to that of the data.
    ///
    /// Leaves the gaps of all points in the scratch.
    fn residual(
        &self,
        x: &[f64],
        r: &mut [f64],
        scale: &mut [f64],
        scratch: &mut Scratch,
        effort: &mut Effort,
    ) -> f64 {
        let (k, m) = (self.points.len(), self.contact.motions.len());
        self.press(x, scratch, effort);
        scratch.gap.clear();
        let opened = self.contact.gap.iter().zip(&scratch.pressed);
        scratch.gap.extend(opened.map(|(g, u)| g + u));
        self.add_motions(x, &mut scratch.gap);
        let mut size = largest(self.contact.gap);
        for (motion, c) in self.contact.motions.iter().zip(&x[k..]) {
            size = size.max(largest(&motion.opening) * c.abs());
        }
        scale[..k].fill(if size > 0.0 { size } else { 1.0 });
        for (r, &point) in r.iter_mut().zip(self.points) {
            *r = -scratch.gap[point];
        }
        let highest = largest(&x[..k]);
        for (j, motion) in self.contact.motions.iter().enumerate() {
            let (mut sum, mut size, mut most) = (0.0, motion.work.abs(), 0.0_f64);
            for (p, &point) in x.iter().zip(self.points) {
                let unit = self.contact.work_of_pressure(motion, point);
                sum += unit * p;
                size += (unit * p).abs();
                most = most.max(unit.abs());
            }
            // of a body that carries next to nothing beside another, so many digits fewer are known
            let size = size.max(LEAST * most * highest);
            r[k + j] = motion.work + sum;
            scale[k + j] = if size > 0.0 { size } else { 1.0 };
        }
        let sum: f64 = r.iter().zip(&*scale).map(|(r, s)| (r / s).powi(2)).sum();
        (sum / (k + m).max(1) as f64).sqrt()
    }

    /// The homogeneous left-hand side at `x`.
    fn product(&self, x: &[f64], out: &mut [f64], scratch: &mut Scratch) {
        let k = self.points.len();
        self.spread(x, &mut scratch.pressure);
        scratch.gap.clear();
        scratch.gap.resize(self.contact.gap.len(), 0.0);
        (scratch.sum).add_product(
            self.influence,
            &scratch.pressure,
            self.terms,
            &mut scratch.gap,
        );
        self.add_motions(x, &mut scratch.gap);
        for (out, &point) in out.iter_mut().zip(self.points) {
            *out = scratch.gap[point];
        }
        for (out, motion) in out[k..].iter_mut().zip(self.contact.motions) {
            let work =
                |(p, &point): (&f64, &usize)| -p * self.contact.work_of_pressure(motion, point);
            *out = x.iter().zip(self.points).map(work).sum();
        }
    }

    /// Puts what the pressures of `x` do to the gaps into the scratch; from the last pressures there, where few
    /// points differ.
    fn press(&self, x: &[f64], scratch: &mut Scratch, effort: &mut Effort) {
        self.spread(x, &mut scratch.pressure);
        let changed = scratch.pressure.iter().zip(&scratch.known);
        let changed = changed.filter(|(p, known)| p != known).count();
        if scratch.known.is_empty() || 4 * changed > self.points.len() {
            scratch.pressed.clear();
            scratch.pressed.resize(scratch.pressure.len(), 0.0);
            (scratch.sum).add_product(
                self.influence,
                &scratch.pressure,
                self.terms,
                &mut scratch.pressed,
            );
            effort.products += 1;
        } else if changed > 0 {
            for (known, p) in scratch.known.iter_mut().zip(&scratch.pressure) {
                *known = p - *known;
            }
            self.influence
                .add_product(&scratch.known, self.terms, &mut scratch.pressed);
        }
        scratch.known.clone_from(&scratch.pressure);
    }

    /// Pressures of all points.
    fn spread(&self, x: &[f64], pressure: &mut Vec<f64>) {
        pressure.clear();
        pressure.resize(self.contact.gap.len(), 0.0);
        for (p, &point) in x.iter().zip(self.points) {
            pressure[point] = *p;
        }
    }

    /// Adds what the motions of `x` do to the gaps.
    fn add_motions(&self, x: &[f64], gap: &mut [f64]) {
        for (motion, c) in self.contact.motions.iter().zip(&x[self.points.len()..]) {
            for (g, o) in gap.iter_mut().zip(&motion.opening) {
                *g += o * c;
            }
        }
    }
}

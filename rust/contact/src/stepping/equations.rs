// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::krylov::{Krylov, dot};

use super::bordered::Bordered;
use super::influence::{Influence, Sum, Terms};
use super::opened::Opened;
use super::{Effort, PRODUCTS};
use crate::columns::largest;
use crate::sliding::SlidingContact;

/// Relative residual at which the equations on an active set count as solved ...
pub(super) const TOLERANCE: f64 = 1e-13;
/// ... and which must be reached.
const ACCEPTED: f64 = 1e-11;
/// Residual that is enough to see which points have the wrong sign, while sets still change.
pub(super) const ROUGH: f64 = 1e-4;
/// Share of the work of the largest pressure below which the parts of a balance are not its scale any more.
const LEAST: f64 = 1e-5;

#[derive(Default)]
pub(super) struct Scratch {
    pub(super) gap: Vec<f64>,
    pressure: Vec<f64>,
    /// Pressures whose gaps are known, and whether by a product of this step.
    pub(super) opened: Opened,
    pub(super) is_fresh: bool,
    pub(super) sum: Sum,
}

impl Scratch {
    /// Begins a step with a friction, of which it is known what some pressures open.
    pub(super) fn begin(&mut self, drag: &[f64], known: Option<Opened>) {
        self.sum.turn_to(drag);
        self.is_fresh = false;
        self.opened = known.unwrap_or_default();
    }
}

/// The equations of one step on one set of points.
pub(super) struct Equations<'a> {
    influence: &'a Influence,
    contact: &'a SlidingContact<'a>,
    terms: &'a Terms,
    points: &'a [usize],
    /// Of each motion, the work of a unit of pressure at each point of the set, and the largest of it.
    works: Vec<(Vec<f64>, f64)>,
    /// Largest gap of the unloaded pair and largest opening of each motion, on the set: open points may be far apart.
    largest_gap: f64,
    largest_openings: Vec<f64>,
}

impl<'a> Equations<'a> {
    pub(super) fn new(
        influence: &'a Influence,
        contact: &'a SlidingContact<'a>,
        terms: &'a Terms,
        points: &'a [usize],
    ) -> Self {
        let works = contact.motions.iter().map(|motion| {
            let work = points.iter().map(|&i| contact.work_of_pressure(motion, i));
            let work: Vec<f64> = work.collect();
            let most = largest(&work);
            (work, most)
        });
        let on_set = |field: &[f64]| points.iter().fold(0.0_f64, |m, &i| m.max(field[i].abs()));
        let openings = contact.motions.iter().map(|motion| on_set(&motion.opening));
        Self {
            influence,
            contact,
            terms,
            points,
            works: works.collect(),
            largest_gap: on_set(contact.gap),
            largest_openings: openings.collect(),
        }
    }

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
        if error <= tolerance && tolerance == TOLERANCE && !scratch.is_fresh {
            // what is handed on and on gathers rounding
            scratch.opened.pressure.clear();
            error = self.residual(x, &mut r, &mut scale, scratch, effort);
        }
        let is_exact = factors.serves(self.terms);
        // as dear as a factorisation, at two products a step
        let most_steps = 3 + self.points.len() / (2 * PRODUCTS);
        let norm_of_all = (x.len() as f64).sqrt();
        let mut before = error;
        for sweep in 0..6 {
            if error <= tolerance {
                return Some(error);
            }
            if sweep > 1 && error >= 0.1 * before {
                break;
            }
            before = error;
            step.copy_from_slice(&r);
            factors.solve(&mut step, self.points);
            effort.products += 1;
            if !is_exact {
                // what this leaves, in rows scaled to like units
                self.lack(&step, factors.terms(), &mut r, scratch);
                r.iter_mut().zip(&scale).for_each(|(r, s)| *r /= s);
                effort.products += 1;
                let aim = 0.3 * tolerance * norm_of_all;
                let left = dot(&r, &r).sqrt();
                if sweep == 0 && left > aim {
                    let contraction = left / (norm_of_all * error);
                    let steps = (error / tolerance).ln() / -contraction.ln();
                    if contraction >= 1.0 || steps > 2.0 * most_steps as f64 {
                        return None;
                    }
                }
                let mut solved: Vec<Vec<f64>> = Vec::new();
                let product = |v: &[f64], out: &mut [f64]| {
                    // the equations on what the factors make of `v` are `v`, but for what these lack
                    let mut of: Vec<f64> = v.iter().zip(&scale).map(|(v, s)| v * s).collect();
                    factors.solve(&mut of, self.points);
                    self.lack(&of, factors.terms(), out, scratch);
                    let rows = out.iter_mut().zip(v).zip(&scale);
                    rows.for_each(|((out, v), s)| *out = v - *out / s);
                    solved.push(of);
                };
                let (report, weights) = Krylov::default().weights(product, &r, aim, most_steps);
                effort.products += 2 * report.steps;
                for (solved, w) in solved.iter().zip(&weights) {
                    step.iter_mut().zip(solved).for_each(|(x, s)| *x += w * s);
                }
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
        let opened = self.contact.gap.iter().zip(scratch.opened.gap());
        scratch.gap.extend(opened.map(|(g, u)| g + u));
        self.terms.add_own(&scratch.pressure, &mut scratch.gap);
        self.add_motions(x, &mut scratch.gap);
        let mut size = self.largest_gap;
        for (opening, c) in self.largest_openings.iter().zip(&x[k..]) {
            size = size.max(opening * c.abs());
        }
        scale[..k].fill(if size > 0.0 { size } else { 1.0 });
        for (r, &point) in r.iter_mut().zip(self.points) {
            *r = -scratch.gap[point];
        }
        let highest = largest(&x[..k]);
        let each = self.contact.motions.iter().zip(&self.works);
        for (j, (motion, (works, most))) in each.enumerate() {
            let (mut sum, mut size) = (0.0, motion.work.abs());
            for (p, unit) in x.iter().zip(works) {
                sum += unit * p;
                size += (unit * p).abs();
            }
            // of a body that carries next to nothing beside another, so many digits fewer are known
            let size = size.max(LEAST * most * highest);
            r[k + j] = motion.work + sum;
            scale[k + j] = if size > 0.0 { size } else { 1.0 };
        }
        let sum: f64 = r.iter().zip(&*scale).map(|(r, s)| (r / s).powi(2)).sum();
        (sum / (k + m).max(1) as f64).sqrt()
    }

    /// What the left-hand side at `x` has less than that with the friction and the diagonal of the factors.
    fn lack(&self, x: &[f64], terms: &Terms, out: &mut [f64], scratch: &mut Scratch) {
        let k = self.points.len();
        self.spread(x, &mut scratch.pressure);
        scratch.gap.clear();
        scratch.gap.resize(self.contact.gap.len(), 0.0);
        let pairs = terms.drag.iter().zip(&self.terms.drag);
        let drag: Vec<f64> = pairs.map(|(then, now)| then - now).collect();
        let pressure = &scratch.pressure;
        (self.influence).add_friction(&drag, pressure, &mut scratch.gap);
        for (out, &point) in out.iter_mut().zip(self.points) {
            let own = terms.own(point) - self.terms.own(point);
            *out = scratch.gap[point] + own * pressure[point];
        }
        // motions and balances are those of now in the factors, too
        out[k..].fill(0.0);
    }

    /// Finds what the pressures of `x` open; from what is known, where few points differ.
    fn press(&self, x: &[f64], scratch: &mut Scratch, effort: &mut Effort) {
        self.spread(x, &mut scratch.pressure);
        let (pressure, opened) = (&scratch.pressure, &mut scratch.opened);
        let changed = pressure.iter().zip(&opened.pressure);
        let changed = changed.filter(|(p, known)| p != known).count();
        if opened.pressure.is_empty() || 4 * changed > self.points.len() {
            scratch.sum.open(self.influence, pressure, opened);
            scratch.is_fresh = true;
            effort.products += 1;
        } else if changed > 0 {
            opened.move_to(pressure, self.influence);
        }
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

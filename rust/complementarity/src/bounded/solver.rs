// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::{Monitor, report};

use super::state::{balance, solve_small};
use super::sums::{Spans, judge};
use super::{Judgement, Mode, Options, Problem, Solution, Status};
use crate::error::{Error, check};

/// Share of the contact set that may change before the preconditioned motions are renewed.
const STALE: f64 = 0.2;

/// Steps without a new best residual after which the search is given up.
const PATIENCE: usize = 60;

/// A product: overwrites its second argument with the image of the first.
type Product<'a> = &'a dyn Fn(&[f64], &mut [f64]);

/// A rough inverse: overwrites its third argument with the image of the second.
type Inverse<'a> = &'a dyn Fn(&[bool], &[f64], &mut [f64]);

/// Solves the problem from `start` (n, negative entries count as zero).
///
/// `apply(x, y)` overwrites `y` with `A x`, `precondition(set, x, y)` with something like the inverse on a set (n)
/// of the block of `A` there, symmetric and positive definite, applied to `x`, which vanishes outside of the set.
/// What it writes outside of the set is of no account.
///
/// # Errors
/// Wrong lengths, numbers that are not finite, [`Error::Interrupted`] by the monitor.
pub fn solve(
    apply: Product<'_>,
    precondition: Inverse<'_>,
    problem: &Problem<'_>,
    start: Vec<f64>,
    options: Options,
    monitor: Monitor<'_>,
) -> Result<Solution, Error> {
    let n = problem.offset.len();
    check("offset", problem.offset, n)?;
    check("start", &start, n)?;
    for mode in problem.modes {
        check("mode", &mode.shape, n)?;
        check("target", &[mode.target], 1)?;
    }
    let mut search = Search::new(apply, precondition, problem, start, options.tolerance);
    let mut best = (f64::INFINITY, 0);
    let status = loop {
        if !search.is_balanced {
            break Status::Unreachable;
        }
        let residual = search.judge();
        search.history.push(residual);
        if residual <= options.tolerance {
            break Status::Solved;
        }
        if residual < 0.99 * best.0 {
            best = (residual, search.iterations);
        }
        if search.iterations >= best.1 + PATIENCE {
            break Status::Stagnated;
        }
        if search.iterations >= options.max_iterations {
            break Status::IterationLimit;
        }
        report(monitor, search.iterations, residual)?;
        search.iterations += 1;
        if !search.step() {
            break Status::Stagnated;
        }
    };
    Ok(search.finish(status))
}

struct Search<'a> {
    apply: Product<'a>,
    precondition: Inverse<'a>,
    offset: &'a [f64],
    modes: &'a [Mode],
    tolerance: f64,
    /// Pressure, and gap before the free motions: `g = A p + b`.
    p: Vec<f64>,
    g: Vec<f64>,
    /// The contact set, stretches of points that hold all of it, and whether it changed in this step. The
    /// pressure, the direction and the next pressure vanish outside of the stretches.
    contact: Vec<bool>,
    spans: Spans,
    has_changed: bool,
    motion: [f64; 3],
    /// `N c`, and `N^T N` over the contact set.
    shift: Vec<f64>,
    gram: [[f64; 3]; 3],
    /// Root mean square of `A p` over the contact set.
    scale: f64,
    /// Gap on the contact set and the same one step earlier, its preconditioned image, the direction.
    r: Vec<f64>,
    r_old: Vec<f64>,
    z: Vec<f64>,
    t: Vec<f64>,
    q: Vec<f64>,
    /// The pressure after a cut step.
    next: Vec<f64>,
    /// Preconditioned motions, and the set for which they were made.
    images: Vec<Vec<f64>>,
    images_for: Vec<bool>,
    /// Products of the motions with them over the contact set.
    image_gram: [[f64; 3]; 3],
    rz: f64,
    /// Length of the last step.
    tau: f64,
    restart: bool,
    is_balanced: bool,
    iterations: usize,
    products: usize,
    preconditionings: usize,
    history: Vec<f64>,
}

impl<'a> Search<'a> {
    fn new(
        apply: Product<'a>,
        precondition: Inverse<'a>,
        problem: &Problem<'a>,
        start: Vec<f64>,
        tolerance: f64,
    ) -> Self {
        let n = start.len();
        let mut p = start;
        for p in &mut p {
            *p = p.max(0.0);
        }
        let is_balanced = balance(problem.modes, &mut p, &Spans::whole(n));
        let contact: Vec<bool> = p.iter().map(|p| *p > 0.0).collect();
        let zeros = || vec![0.0; n];
        let mut search = Self {
            apply,
            precondition,
            offset: problem.offset,
            modes: problem.modes,
            tolerance,
            spans: Spans::of(&contact),
            contact,
            has_changed: true,
            g: problem.offset.to_vec(),
            p,
            motion: [0.0; 3],
            shift: zeros(),
            gram: [[0.0; 3]; 3],
            scale: 0.0,
            r: zeros(),
            r_old: zeros(),
            z: zeros(),
            t: zeros(),
            q: zeros(),
            next: zeros(),
            images: Vec::new(),
            images_for: Vec::new(),
            image_gram: [[0.0; 3]; 3],
            rz: 1.0,
            tau: 1.0,
            restart: true,
            is_balanced,
            iterations: 0,
            products: 0,
            preconditionings: 0,
            history: Vec::new(),
        };
        if search.p.iter().any(|p| *p > 0.0) {
            search.q.copy_from_slice(&search.p);
            search.add_image(1.0);
        }
        search
    }

    /// Adds `scale` times the image of the field in `q` to the gap; leaves the image in `q`.
    fn add_image(&mut self, scale: f64) {
        let field = std::mem::take(&mut self.q);
        let mut image = std::mem::replace(&mut self.r_old, field);
        (self.apply)(&self.r_old, &mut image);
        self.products += 1;
        for (g, image) in self.g.iter_mut().zip(&image) {
            *g += scale * image;
        }
        self.q = image;
    }

    /// Fits the motions, lets penetrating points in, returns the relative residual.
    fn judge(&mut self) -> f64 {
        std::mem::swap(&mut self.r, &mut self.r_old);
        self.fit_motion();
        // a point that penetrates by far less than the tolerance need not disturb the search
        let threshold = -1e-2 * self.tolerance * self.scale;
        let mut has_grown = false;
        for ((c, g), shift) in self.contact.iter_mut().zip(&self.g).zip(&self.shift) {
            let is_closed = g - shift < threshold;
            has_grown |= is_closed && !*c;
            *c |= is_closed;
        }
        self.has_changed |= has_grown;
        if self.has_changed {
            self.settle();
        }
        if has_grown {
            self.fit_motion();
        }
        let (wrong, size) = judge(
            &self.g,
            &self.shift,
            self.offset,
            &self.contact,
            &mut self.r,
        );
        let count = self.spans.count(&self.contact);
        self.scale = (size / count.max(1) as f64).sqrt();
        if wrong == 0.0 || count == 0 {
            return 0.0;
        }
        if size == 0.0 {
            return 1.0;
        }
        wrong / self.scale
    }

    /// Follows a change of the contact set.
    fn settle(&mut self) {
        for span in self.spans.iter() {
            let state = self.t[span.clone()]
                .iter_mut()
                .zip(&mut self.next[span.clone()]);
            for ((t, next), c) in state.zip(&self.contact[span]) {
                if !c {
                    *t = 0.0;
                    *next = 0.0;
                }
            }
        }
        self.spans = Spans::of(&self.contact);
    }

    /// Motions that leave the smallest gap on the contact set.
    fn fit_motion(&mut self) {
        let mut sum = [0.0; 3];
        for (k, mode) in self.modes.iter().enumerate() {
            sum[k] = self.spans.dot_in(&mode.shape, &self.g, &self.contact);
            for (l, other) in self.modes[..=k].iter().enumerate() {
                if self.has_changed {
                    self.gram[k][l] = self.spans.dot_in(&mode.shape, &other.shape, &self.contact);
                    self.gram[l][k] = self.gram[k][l];
                }
            }
        }
        self.motion = solve_small(&self.gram, sum, self.modes.len());
        for (k, (mode, c)) in self.modes.iter().zip(self.motion).enumerate() {
            if k == 0 {
                self.shift.fill(0.0);
            }
            for (shift, n) in self.shift.iter_mut().zip(&mode.shape) {
                *shift += c * n;
            }
        }
    }

    /// One step of the search; false where the matrix shows no positive curvature.
    fn step(&mut self) -> bool {
        self.find_direction();
        self.has_changed = false;
        let is_cut = self.spans.iter().any(|span| {
            let state = self.p[span.clone()].iter().zip(&self.t[span]);
            state.into_iter().any(|(p, t)| p - self.tau * t < 0.0)
        });
        if is_cut && self.cut_step() {
            return true;
        }
        self.free_step()
    }

    /// The next conjugate direction on the contact set that keeps the balance.
    fn find_direction(&mut self) {
        (self.precondition)(&self.contact, &self.r, &mut self.z);
        self.preconditionings += 1;
        self.mask_z();
        self.project_z();
        let (rz, old) = (
            self.spans.dot(&self.r, &self.z),
            self.spans.dot(&self.r_old, &self.z),
        );
        let beta = if self.restart {
            0.0
        } else {
            ((rz - old) / self.rz).max(0.0)
        };
        self.rz = rz;
        if beta > 0.0 {
            for span in self.spans.iter() {
                let state = self.t[span.clone()].iter_mut().zip(&self.z[span.clone()]);
                for ((t, z), c) in state.zip(&self.contact[span]) {
                    *t = if *c { z + beta * *t } else { 0.0 };
                }
            }
            self.project_t();
        }
        if beta <= 0.0 || self.spans.dot(&self.r, &self.t) <= 0.0 {
            for span in self.spans.iter() {
                self.t[span.clone()].copy_from_slice(&self.z[span]);
            }
        }
        self.restart = false;
    }

    fn mask_z(&mut self) {
        for span in self.spans.iter() {
            for (z, c) in self.z[span.clone()].iter_mut().zip(&self.contact[span]) {
                *z = if *c { *z } else { 0.0 };
            }
        }
    }

    /// Takes the part that breaks the balance out of the preconditioned gap.
    fn project_z(&mut self) {
        if self.modes.is_empty() {
            return;
        }
        if self.has_changed {
            self.renew_images();
        }
        let mut sum = [0.0; 3];
        for (k, mode) in self.modes.iter().enumerate() {
            sum[k] = self.spans.dot(&mode.shape, &self.z);
        }
        let y = solve_small(&self.image_gram, sum, self.modes.len());
        for (image, y) in self.images.iter().zip(y) {
            for span in self.spans.iter() {
                let state = self.z[span.clone()].iter_mut().zip(&image[span.clone()]);
                for ((z, w), c) in state.zip(&self.contact[span]) {
                    *z -= if *c { y * w } else { 0.0 };
                }
            }
        }
    }

    /// Preconditions the motions anew where the contact set is no longer much the same.
    fn renew_images(&mut self) {
        let changed = self
            .images_for
            .iter()
            .zip(&self.contact)
            .filter(|(a, b)| a != b)
            .count();
        let count = self.spans.count(&self.contact);
        if self.images.is_empty() || changed as f64 > STALE * count as f64 {
            let mut masked = vec![0.0; self.p.len()];
            self.images.clear();
            for mode in self.modes {
                for ((m, n), c) in masked.iter_mut().zip(&mode.shape).zip(&self.contact) {
                    *m = if *c { *n } else { 0.0 };
                }
                let mut image = vec![0.0; self.p.len()];
                (self.precondition)(&self.contact, &masked, &mut image);
                self.preconditionings += 1;
                self.images.push(image);
            }
            self.images_for.clone_from(&self.contact);
        }
        for (k, mode) in self.modes.iter().enumerate() {
            for (l, image) in self.images.iter().enumerate() {
                self.image_gram[k][l] = self.spans.dot_in(&mode.shape, image, &self.contact);
            }
        }
    }

    /// Takes the part that breaks the balance out of the direction.
    fn project_t(&mut self) {
        let mut sum = [0.0; 3];
        for (k, mode) in self.modes.iter().enumerate() {
            sum[k] = self.spans.dot(&mode.shape, &self.t);
        }
        let y = solve_small(&self.gram, sum, self.modes.len());
        for (mode, y) in self.modes.iter().zip(y) {
            for span in self.spans.iter() {
                let state = self.t[span.clone()]
                    .iter_mut()
                    .zip(&mode.shape[span.clone()]);
                for ((t, n), c) in state.zip(&self.contact[span]) {
                    *t -= if *c { y * n } else { 0.0 };
                }
            }
        }
    }

    /// Steps as far as the last time, cuts off what turns negative, and multiplies only then.
    ///
    /// False, with nothing done, where the cut direction leads uphill.
    fn cut_step(&mut self) -> bool {
        for span in self.spans.iter() {
            let state = self.next[span.clone()]
                .iter_mut()
                .zip(&self.p[span.clone()]);
            for ((next, p), t) in state.zip(&self.t[span]) {
                *next = (p - self.tau * t).max(0.0);
            }
        }
        if !balance(self.modes, &mut self.next, &self.spans) {
            return false;
        }
        self.put_difference();
        let slope = -self.spans.dot(&self.r, &self.q);
        if slope <= 0.0 {
            return false;
        }
        // the direction itself rests in `r_old` while its image is made; the caller's r stays
        let kept = std::mem::take(&mut self.r_old);
        let direction = std::mem::replace(&mut self.q, kept);
        (self.apply)(&direction, &mut self.q);
        self.products += 1;
        let curvature = self.spans.dot(&direction, &self.q);
        let optimum = if curvature > 0.0 {
            slope / curvature
        } else {
            1.0
        };
        // beyond half of the way the cut step itself lowers the energy, and it frees points
        let length = if optimum < 0.5 { optimum } else { 1.0 };
        if optimum < 0.5 {
            self.tau *= optimum.max(0.1);
            for (p, d) in self.p.iter_mut().zip(&direction) {
                *p += length * d;
            }
        } else {
            self.tau *= optimum.min(2.0);
            std::mem::swap(&mut self.p, &mut self.next);
        }
        for (g, q) in self.g.iter_mut().zip(&self.q) {
            *g += length * q;
        }
        for span in self.spans.iter() {
            for (c, p) in self.contact[span.clone()].iter_mut().zip(&self.p[span]) {
                *c = *p > 0.0;
            }
        }
        self.has_changed = true;
        self.r_old = direction;
        true
    }

    /// Puts the way from the pressure to the next one into `q`.
    fn put_difference(&mut self) {
        self.q.fill(0.0);
        for span in self.spans.iter() {
            let state = self.q[span.clone()]
                .iter_mut()
                .zip(&self.next[span.clone()]);
            for ((q, next), p) in state.zip(&self.p[span]) {
                *q = next - p;
            }
        }
    }

    /// The exact conjugate gradient step, with a second product where it has to be cut after all.
    fn free_step(&mut self) -> bool {
        (self.apply)(&self.t, &mut self.q);
        self.products += 1;
        let curvature = self.spans.dot(&self.t, &self.q);
        if curvature.is_nan() || curvature <= 0.0 {
            return false;
        }
        self.tau = self.spans.dot(&self.r, &self.t) / curvature;
        // the longest step without a negative pressure
        let mut longest = f64::INFINITY;
        for span in self.spans.iter() {
            let state = self.next[span.clone()]
                .iter_mut()
                .zip(&self.p[span.clone()]);
            for ((next, p), t) in state.zip(&self.t[span]) {
                *next = (p - self.tau * t).max(0.0);
                if p - self.tau * t < 0.0 {
                    longest = longest.min(p / t);
                }
            }
        }
        let is_cut = longest.is_finite();
        // where what is left cannot be balanced, the step ends at the first bound
        let is_balanced = !is_cut || balance(self.modes, &mut self.next, &self.spans);
        let length = if is_balanced { self.tau } else { longest };
        for (g, q) in self.g.iter_mut().zip(&self.q) {
            *g -= length * q;
        }
        for span in self.spans.iter() {
            let state = self.p[span.clone()].iter_mut().zip(&self.t[span.clone()]);
            for ((p, t), c) in state.zip(&mut self.contact[span]) {
                let is_at_bound = !is_balanced && *t > 0.0 && *p <= longest * t;
                *p = if is_at_bound { 0.0 } else { *p - length * t };
                *c &= *p >= 0.0 && !is_at_bound;
            }
        }
        if is_cut {
            if is_balanced {
                self.put_difference();
                self.add_image(1.0);
                std::mem::swap(&mut self.p, &mut self.next);
            } else {
                self.restart = true;
            }
            self.has_changed = true;
        }
        true
    }

    fn finish(mut self, status: Status) -> Solution {
        let mut judged = Judgement::default();
        for i in 0..self.p.len() {
            let displacement = self.g[i] - self.offset[i];
            self.g[i] -= self.shift[i];
            judged.take(self.p[i], self.g[i], displacement);
        }
        Solution {
            status,
            pressure: self.p,
            slack: self.g,
            motion: self.motion[..self.modes.len()].to_vec(),
            iterations: self.iterations,
            products: self.products,
            preconditionings: self.preconditionings,
            residual: judged.residual(),
            history: self.history,
        }
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::{Monitor, report};

use super::state::{balance, project, solve_small};
use super::sums::{Spans, judge};
use super::{Judgement, Mode, Options, Problem, Solution, Status};
use crate::error::{Error, check};

/// Share of the contact set that may change before the preconditioned motions are renewed.
const STALE: f64 = 0.2;

/// Part of the cap that no pressure must move beyond for a step to be one that leads nowhere.
const NOWHERE: f64 = 1e-9;

/// Steps without a new best residual after which the search is given up.
const PATIENCE: usize = 60;

/// A product: overwrites its second argument with the image of the first.
pub(super) type Product<'a> = &'a dyn Fn(&[f64], &mut [f64]);

/// A rough inverse: overwrites its third argument with the image of the second.
pub(super) type Inverse<'a> = &'a dyn Fn(&[bool], &[f64], &mut [f64]);

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
    search(
        apply,
        precondition,
        problem,
        f64::INFINITY,
        start,
        options,
        monitor,
    )
}

/// Solves a problem in which `p <= cap` holds as well: `w` is zero where `0 < p < cap`, not negative where `p = 0` and
/// not positive where `p = cap`.
///
/// Points at the cap are held like open ones: the conjugate gradient goes on with the others, and they come back once
/// their gap is positive. The slack of a point at the cap tells how far it gave way beyond `A p`.
///
/// # Errors
/// As [`solve`].
pub fn solve_capped(
    apply: Product<'_>,
    precondition: Inverse<'_>,
    problem: &Problem<'_>,
    cap: f64,
    start: Vec<f64>,
    options: Options,
    monitor: Monitor<'_>,
) -> Result<Solution, Error> {
    check("cap", &[cap], 1)?;
    search(apply, precondition, problem, cap, start, options, monitor)
}

fn search(
    apply: Product<'_>,
    precondition: Inverse<'_>,
    problem: &Problem<'_>,
    cap: f64,
    start: Vec<f64>,
    options: Options,
    monitor: Monitor<'_>,
) -> Result<Solution, Error> {
    problem.check(&start)?;
    let (mut search, is_balanced) =
        Search::new(apply, precondition, problem, cap, start, options.tolerance);
    let mut best = (f64::INFINITY, 0);
    let status = loop {
        if !is_balanced {
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
    /// Most that a pressure may be, and what the points held there carry of each balance.
    cap: f64,
    held: [f64; 3],
    /// Pressure, and gap before the free motions: `g = A p + b`.
    p: Vec<f64>,
    g: Vec<f64>,
    /// The contact set without what is held at the cap, stretches of points that hold all of it, and whether it
    /// changed in this step. The direction vanishes outside of the set; the pressure is zero or the cap there.
    contact: Vec<bool>,
    spans: Spans,
    whole: Spans,
    has_changed: bool,
    motion: [f64; 3],
    /// `N c`, and `N^T N` over the contact set.
    shift: Vec<f64>,
    gram: [[f64; 3]; 3],
    /// Root mean square of `A p` where there is pressure.
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
    /// Whether the contact set has too few points between their bounds to tell the motions, which the nearest balanced
    /// pressures downhill tell then; and those pressures (n) are the next ones.
    is_lost: bool,
    iterations: usize,
    products: usize,
    preconditionings: usize,
    history: Vec<f64>,
}

impl<'a> Search<'a> {
    /// The search, and whether the pressures that it starts from meet the balance.
    fn new(
        apply: Product<'a>,
        precondition: Inverse<'a>,
        problem: &Problem<'a>,
        cap: f64,
        start: Vec<f64>,
        tolerance: f64,
    ) -> (Self, bool) {
        let n = start.len();
        let (whole, all) = (Spans::whole(n), vec![true; n]);
        let mut p = start;
        for p in &mut p {
            *p = p.max(0.0).min(cap);
        }
        let next = p.clone();
        let mut is_balanced = balance(problem.modes, &mut p, cap, &whole, &all);
        if !is_balanced {
            // factors do not help where too few points have room, and leave pressures that are none
            p.copy_from_slice(&next);
            is_balanced = project(problem.modes, &mut p, cap, [0.0; 3], &whole, &all).is_some();
        }
        let contact: Vec<bool> = p.iter().map(|p| *p > 0.0 && *p < cap).collect();
        let zeros = || vec![0.0; n];
        let mut search = Self {
            apply,
            precondition,
            offset: problem.offset,
            modes: problem.modes,
            tolerance,
            cap,
            held: [0.0; 3],
            spans: Spans::of(&contact),
            whole: Spans::whole(n),
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
            next,
            images: Vec::new(),
            images_for: Vec::new(),
            image_gram: [[0.0; 3]; 3],
            rz: 1.0,
            tau: 1.0,
            restart: true,
            is_lost: false,
            iterations: 0,
            products: 0,
            preconditionings: 0,
            history: Vec::new(),
        };
        if search.p.iter().any(|p| *p > 0.0) {
            search.q.copy_from_slice(&search.p);
            search.add_image(1.0);
        }
        (search, is_balanced)
    }

    /// Adds `scale` times the image of the field in `q` to the gap; leaves the image in `q`.
    fn add_image(&mut self, scale: f64) {
        let field = std::mem::take(&mut self.q);
        let mut image = std::mem::replace(&mut self.r_old, field);
        (self.apply)(&self.r_old, &mut image);
        self.products += 1;
        self.q = image;
        self.add_to_gap(scale);
    }

    /// Adds `scale` times the image in `q` to the gap.
    fn add_to_gap(&mut self, scale: f64) {
        let add = |[g]: [f64; 1], [q]: [f64; 1], _: bool| ([g + scale * q], []);
        let Self {
            g,
            q,
            contact,
            whole,
            ..
        } = self;
        whole.sum([g], [q], contact, add);
    }

    /// Fits the motions, lets penetrating points in, returns the relative residual.
    fn judge(&mut self) -> f64 {
        std::mem::swap(&mut self.r, &mut self.r_old);
        self.fit_size();
        self.fit();
        if !self.is_lost {
            self.let_in();
        }
        let [wrong, size, count] = judge(
            &self.g,
            &self.shift,
            self.offset,
            (&self.p, self.cap),
            &self.contact,
            &mut self.r,
        );
        if wrong == 0.0 || (!self.is_lost && self.spans.count(&self.contact) == 0) {
            return 0.0;
        }
        if size == 0.0 {
            self.scale = 0.0;
            return 1.0;
        }
        self.scale = (size / count).sqrt();
        wrong / self.scale
    }

    /// Lets points in whose gap is wrong at their bound.
    fn let_in(&mut self) {
        // a point that penetrates by far less than the tolerance need not disturb the search, nor one at the cap that
        // opens by as little
        let threshold = -1e-2 * self.tolerance * self.scale;
        let cap = self.cap;
        let is_closed = |p: f64, gap: f64| (if p < cap { gap } else { -gap }) < threshold;
        let fields = [self.g.as_slice(), &self.shift, &self.p];
        let [closed] = self
            .whole
            .sum([], fields, &self.contact, |[], [g, shift, p], c| {
                let is_new = !c && is_closed(p, g - shift);
                ([], [f64::from(u8::from(is_new))])
            });
        let has_grown = closed > 0.0;
        if has_grown {
            let state = self.g.iter().zip(&self.shift).zip(&self.p);
            for (c, ((g, shift), p)) in self.contact.iter_mut().zip(state) {
                *c |= is_closed(*p, g - shift);
            }
        }
        self.has_changed |= has_grown;
        if self.has_changed {
            self.settle();
        }
        if has_grown {
            self.fit_motion();
        }
    }

    /// Follows a change of the contact set.
    fn settle(&mut self) {
        for span in self.spans.iter() {
            for (t, c) in self.t[span.clone()].iter_mut().zip(&self.contact[span]) {
                if !c {
                    *t = 0.0;
                }
            }
        }
        self.spans = Spans::of(&self.contact);
        if self.cap.is_finite() {
            let cap = self.cap;
            for (held, mode) in self.held.iter_mut().zip(self.modes) {
                let part = |[]: [f64; 0], [p, n]: [f64; 2], c: bool| {
                    ([], [if !c && p >= cap { p * n } else { 0.0 }])
                };
                [*held] = self
                    .whole
                    .sum([], [&self.p, &mode.shape], &self.contact, part);
            }
        }
    }

    /// Work of the pressure, and of a direction on the contact set, on the image of the pressure.
    fn works(&self, direction: &[f64]) -> [f64; 2] {
        let fields = [self.g.as_slice(), self.offset, &self.p, direction];
        let work = |[]: [f64; 0], [g, b, p, t]: [f64; 4], c: bool| {
            ([], [p * (g - b), if c { t * (g - b) } else { 0.0 }])
        };
        self.spans.sum([], fields, &self.contact, work)
    }

    /// Whether neither a balance nor a cap tells how large the pressure is.
    fn is_of_any_size(&self) -> bool {
        self.modes.is_empty() && self.cap.is_infinite()
    }

    /// The multiple of the pressure that a direction has in terms of energy, where no balance tells how large the
    /// pressure is.
    fn share(&self, direction: &[f64]) -> f64 {
        let [work, other] = self.works(direction);
        let share = other / work;
        if self.is_of_any_size() && work > 0.0 && share.is_finite() {
            share
        } else {
            0.0
        }
    }

    /// Where no balance tells how large the pressure is: the multiple of it that has the least energy, whose image is
    /// known without a product.
    fn fit_size(&mut self) {
        if !self.is_of_any_size() {
            return;
        }
        let mut pull = -self.spans.dot(&self.p, self.offset, &self.contact);
        if pull <= 0.0 && self.p.iter().any(|p| *p > 0.0) {
            self.drop_open();
            pull = -self.spans.dot(&self.p, self.offset, &self.contact);
        }
        let [work, _] = self.works(&self.p);
        let size = pull / work;
        if !size.is_finite() || size <= 0.0 || (size - 1.0).abs() <= 1e-2 * self.tolerance {
            return;
        }
        self.p.iter_mut().for_each(|p| *p *= size);
        for (g, b) in self.g.iter_mut().zip(self.offset) {
            *g = b + size * (*g - b);
        }
    }

    /// Begins again without the pressure on points that are open where nothing moves: with it no multiple of the
    /// pressure has less energy than none, and no direction changes how large the pressure is.
    fn drop_open(&mut self) {
        for (p, b) in self.p.iter_mut().zip(self.offset) {
            if *b >= 0.0 {
                *p = 0.0;
            }
        }
        self.g.copy_from_slice(self.offset);
        if self.p.iter().any(|p| *p > 0.0) {
            self.q.copy_from_slice(&self.p);
            self.add_image(1.0);
        }
        for (c, p) in self.contact.iter_mut().zip(&self.p) {
            *c = *p > 0.0;
        }
        // what moved under the pressure that is gone measures nothing
        self.scale = 0.0;
        (self.has_changed, self.restart) = (true, true);
    }

    /// Fits the motions to the state.
    fn fit(&mut self) {
        if self.is_lost {
            self.keep_between();
        }
        let is_bare =
            self.cap.is_finite() && !self.modes.is_empty() && self.spans.count(&self.contact) == 0;
        // a motion that closes all gaps by as much
        let is_even =
            matches!(self.modes, [mode] if mode.shape.iter().all(|n| *n == mode.shape[0]));
        if is_bare && is_even {
            self.is_lost = false;
            self.fit_between();
        } else {
            self.is_lost = (is_bare || self.is_lost) && self.fit_downhill();
            if !self.is_lost {
                self.fit_motion();
            }
        }
    }

    /// Leaves in the contact set what is between its bounds.
    fn keep_between(&mut self) {
        for (c, p) in self.contact.iter_mut().zip(&self.p) {
            *c = *p > 0.0 && *p < self.cap;
        }
        self.has_changed = true;
        self.settle();
    }

    /// Motions by the balance of the pressures downhill from those that are: where these meet all conditions, the shift
    /// that brings those back to them is the motion, however few points lie between their bounds. False where no pressures
    /// are found. [MoreToraldo1991]
    fn fit_downhill(&mut self) -> bool {
        let fields = [self.p.as_slice(), &self.g, self.offset];
        let work = |[]: [f64; 0], [p, g, b]: [f64; 3], _: bool| ([], [p * p, p * (g - b)]);
        let [square, work] = self.whole.sum([], fields, &self.contact, work);
        let length = square / work;
        if !length.is_finite() || length <= 0.0 {
            return false;
        }
        let downhill =
            |_: [f64; 1], [p, g, shift]: [f64; 3], _: bool| ([p - length * (g - shift)], []);
        let all = vec![true; self.p.len()];
        let mut next = std::mem::take(&mut self.next);
        let fields = [self.p.as_slice(), &self.g, &self.shift];
        self.whole.sum([&mut next], fields, &all, downhill);
        let found = project(self.modes, &mut next, self.cap, [0.0; 3], &self.whole, &all);
        self.next = next;
        let Some(by) = found else {
            return false;
        };
        let mut by = by.into_iter();
        self.move_by(|_| by.next().unwrap_or(0.0) / length);
        true
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
            let kept = if k == 0 { 0.0 } else { 1.0 };
            let add = |[shift]: [f64; 1], [n]: [f64; 1], _: bool| ([kept * shift + c * n], []);
            let Self {
                shift,
                contact,
                whole,
                ..
            } = &mut *self;
            whole.sum([shift], [&mode.shape], contact, add);
        }
    }

    /// Where all points are held at a bound and one motion closes all gaps by as much: between what is open and what is at
    /// the cap.
    fn fit_between(&mut self) {
        let (mut capped, mut open) = (f64::NEG_INFINITY, f64::INFINITY);
        for ((g, shift), p) in self.g.iter().zip(&self.shift).zip(&self.p) {
            let gap = g - shift;
            if *p >= self.cap {
                capped = capped.max(gap);
            } else {
                open = open.min(gap);
            }
        }
        let by = match (capped.is_finite(), open.is_finite()) {
            (true, true) if capped > open => 0.5 * (capped + open),
            // the least motion that will do: what gave way once does so no further under the same load
            (true, _) => capped,
            _ => open,
        };
        self.move_by(|mode| by / mode.shape[0]);
    }

    /// Adds to the free motions.
    fn move_by(&mut self, mut by: impl FnMut(&Mode) -> f64) {
        for (mode, c) in self.modes.iter().zip(&mut self.motion) {
            let by = by(mode);
            *c += by;
            for (shift, n) in self.shift.iter_mut().zip(&mode.shape) {
                *shift += by * n;
            }
        }
    }

    /// One step of the search; false where the matrix shows no positive curvature.
    fn step(&mut self) -> bool {
        if self.is_lost {
            self.step_downhill();
            return true;
        }
        self.find_direction();
        self.has_changed = false;
        let (tau, cap) = (self.tau, self.cap);
        let fields = [self.p.as_slice(), &self.t];
        let [cut] = self.spans.sum([], fields, &self.contact, |[], [p, t], _| {
            let next = p - tau * t;
            ([], [f64::from(u8::from(next < 0.0 || next > cap))])
        });
        if cut > 0.0 && self.cut_step() {
            return true;
        }
        self.free_step()
    }

    /// Steps toward the pressures downhill, as far as the energy falls.
    fn step_downhill(&mut self) {
        let difference = |_: [f64; 1], [next, p, g, shift]: [f64; 4], _: bool| {
            let d = next - p;
            ([d], [(shift - g) * d])
        };
        let Self {
            q,
            next,
            p,
            g,
            shift,
            contact,
            whole,
            ..
        } = &mut *self;
        let [slope] = whole.sum([q], [next, p, g, shift], contact, difference);
        let kept = std::mem::take(&mut self.r_old);
        let direction = std::mem::replace(&mut self.q, kept);
        (self.apply)(&direction, &mut self.q);
        self.products += 1;
        let curvature = self.whole.dot(&direction, &self.q, &self.contact);
        // pressures that have lost their balance may find it uphill only
        if slope > 0.0 && slope < curvature {
            let length = slope / curvature;
            let add = |[p]: [f64; 1], [d]: [f64; 1], _: bool| ([p + length * d], []);
            self.whole
                .sum([&mut self.p], [&direction], &self.contact, add);
            self.add_to_gap(length);
        } else {
            self.p.copy_from_slice(&self.next);
            self.add_to_gap(1.0);
        }
        self.r_old = direction;
        self.is_lost = false;
        self.restart = true;
        self.keep_between();
    }

    /// Whether the next pressures under a cap are the same as those that are.
    fn leads_nowhere(&self) -> bool {
        let far = |[]: [f64; 0], [next, p]: [f64; 2], c: bool| {
            ([], [if c { (next - p).abs() } else { 0.0 }])
        };
        let join = |[a]: [f64; 1], [b]: [f64; 1]| [a.max(b)];
        let fields = [self.next.as_slice(), &self.p];
        let [far] = self.spans.fold([], fields, &self.contact, far, [0.0], join);
        self.cap.is_finite() && far <= NOWHERE * self.cap
    }

    /// The next conjugate direction on the contact set that keeps the balance.
    fn find_direction(&mut self) {
        (self.precondition)(&self.contact, &self.r, &mut self.z);
        self.preconditionings += 1;
        let [rz, old] = self.project_z();
        // directions are conjugate on one set only: after a change a look back leads astray
        let beta = if self.restart || self.has_changed {
            0.0
        } else {
            ((rz - old) / self.rz).max(0.0)
        };
        self.rz = rz;
        let is_downhill = beta > 0.0 && self.conjugate(beta) > 0.0;
        if !is_downhill {
            for span in self.spans.iter() {
                self.t[span.clone()].copy_from_slice(&self.z[span]);
            }
        }
        self.restart = false;
    }

    /// Takes the part that breaks the balance out of the preconditioned gap, and what is outside of the contact
    /// set; returns its products with the gap and with that of one step earlier.
    fn project_z(&mut self) -> [f64; 2] {
        if self.has_changed && !self.modes.is_empty() {
            self.renew_images();
        }
        let mut sum = [0.0; 3];
        for (k, mode) in self.modes.iter().enumerate() {
            sum[k] = self.spans.dot_in(&mode.shape, &self.z, &self.contact);
        }
        let y = solve_small(&self.image_gram, sum, self.modes.len());
        let share = self.share(&self.z);
        let Self {
            p,
            z,
            r,
            r_old,
            images,
            contact,
            spans,
            ..
        } = self;
        // the last motion together with the rest; without motions it is the size of the pressure
        let (mut last, mut factor) = (&*p, share);
        for (k, (image, y)) in images.iter().zip(y).enumerate() {
            if k + 1 < images.len() {
                let take_off = |[z]: [f64; 1], [w]: [f64; 1], _: bool| ([z - y * w], []);
                spans.sum([z], [image], contact, take_off);
            } else {
                (last, factor) = (image, y);
            }
        }
        let project = |[z]: [f64; 1], [w, r, old]: [f64; 3], c: bool| {
            let z = if c { z - factor * w } else { 0.0 };
            ([z], [r * z, old * z])
        };
        spans.sum([z], [last, r, r_old], contact, project)
    }

    /// Makes the direction conjugate to the last one and balanced; returns its product with the gap.
    fn conjugate(&mut self, beta: f64) -> f64 {
        let Self {
            t,
            z,
            contact,
            spans,
            ..
        } = &mut *self;
        let conjugate = |[t]: [f64; 1], [z]: [f64; 1], c: bool| {
            let t = if c { z + beta * t } else { 0.0 };
            ([t], [])
        };
        spans.sum([t], [z], contact, conjugate);
        let mut sum = [0.0; 3];
        for (k, mode) in self.modes.iter().enumerate() {
            sum[k] = self.spans.dot(&mode.shape, &self.t, &self.contact);
        }
        let y = solve_small(&self.gram, sum, self.modes.len());
        let share = self.share(&self.t);
        let Self {
            p,
            t,
            r,
            contact,
            modes,
            spans,
            ..
        } = &mut *self;
        let (mut last, mut factor) = (&*p, share);
        for (k, (mode, y)) in modes.iter().zip(y).enumerate() {
            if k + 1 < modes.len() {
                let take_off = |[t]: [f64; 1], [n]: [f64; 1], _: bool| ([t - y * n], []);
                spans.sum([t], [&mode.shape], contact, take_off);
            } else {
                (last, factor) = (&mode.shape, y);
            }
        }
        let project = |[t]: [f64; 1], [n, r]: [f64; 2], c: bool| {
            let t = if c { t - factor * n } else { 0.0 };
            ([t], [r * t])
        };
        let [slope] = spans.sum([t], [last, r], contact, project);
        slope
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

    /// Steps as far as the last time, cuts off what turns negative or passes the cap, and multiplies only then.
    ///
    /// False, with nothing done, where the cut direction leads uphill.
    fn cut_step(&mut self) -> bool {
        let (tau, cap, least) = (self.tau, self.cap, self.least());
        let Self {
            next,
            p,
            t,
            contact,
            spans,
            ..
        } = &mut *self;
        let cut = |_: [f64; 1], [p, t]: [f64; 2], _: bool| ([(p - tau * t).max(least)], []);
        spans.sum([next], [p, t], contact, cut);
        if !self.balance_next() {
            return false;
        }
        if self.leads_nowhere() {
            self.is_lost = true;
            return true;
        }
        let slope = -self.put_difference();
        if slope <= 0.0 {
            return false;
        }
        // the direction itself rests in `r_old` while its image is made; the caller's r stays
        let kept = std::mem::take(&mut self.r_old);
        let direction = std::mem::replace(&mut self.q, kept);
        (self.apply)(&direction, &mut self.q);
        self.products += 1;
        let curvature = self.spans.dot(&direction, &self.q, &self.contact);
        let optimum = if curvature > 0.0 {
            slope / curvature
        } else {
            1.0
        };
        // beyond half of the way the cut step itself lowers the energy, and it frees points
        let length = if optimum < 0.5 { optimum } else { 1.0 };
        if optimum < 0.5 {
            self.tau *= optimum.max(0.1);
            let add = |[p]: [f64; 1], [d]: [f64; 1], _: bool| ([p + length * d], []);
            self.spans
                .sum([&mut self.p], [&direction], &self.contact, add);
        } else {
            self.tau *= optimum.min(2.0);
            self.take_next();
        }
        self.add_to_gap(length);
        for span in self.spans.iter() {
            for (c, p) in self.contact[span.clone()].iter_mut().zip(&self.p[span]) {
                *c = *p > 0.0 && *p < cap;
            }
        }
        self.has_changed = true;
        self.r_old = direction;
        true
    }

    /// Cuts the next pressure off at its bounds and restores its balance on the contact set; false where that fails.
    fn balance_next(&mut self) -> bool {
        let (spans, contact, next) = (&self.spans, &self.contact, &mut self.next);
        if self.cap.is_finite() {
            return project(self.modes, next, self.cap, self.held, spans, contact).is_some();
        }
        balance(self.modes, next, self.cap, spans, contact)
    }

    /// Where a step is cut off before its balance is restored: under a cap both are one.
    fn least(&self) -> f64 {
        if self.cap.is_finite() {
            f64::NEG_INFINITY
        } else {
            0.0
        }
    }

    /// Makes the next pressure the pressure.
    fn take_next(&mut self) {
        for span in self.spans.iter() {
            self.p[span.clone()].copy_from_slice(&self.next[span]);
        }
    }

    /// Puts the way from the pressure to the next one into `q`, returns its product with the gap.
    fn put_difference(&mut self) -> f64 {
        self.q.fill(0.0);
        let Self {
            q,
            next,
            p,
            r,
            contact,
            spans,
            ..
        } = &mut *self;
        let difference = |_: [f64; 1], [next, p, r]: [f64; 3], _: bool| {
            let d = next - p;
            ([d], [r * d])
        };
        let [slope] = spans.sum([q], [next, p, r], contact, difference);
        slope
    }

    /// The exact conjugate gradient step, with a second product where it has to be cut after all.
    fn free_step(&mut self) -> bool {
        (self.apply)(&self.t, &mut self.q);
        self.products += 1;
        let fields = [self.t.as_slice(), &self.q, &self.r];
        let [curvature, slope] = self
            .spans
            .sum([], fields, &self.contact, |[], [t, q, r], _| {
                ([], [t * q, t * r])
            });
        if curvature.is_nan() || curvature <= 0.0 {
            return false;
        }
        self.tau = slope / curvature;
        let (tau, cap, least) = (self.tau, self.cap, self.least());
        // the longest step that passes no bound
        let Self {
            next,
            p,
            t,
            contact,
            spans,
            ..
        } = &mut *self;
        let cut = |_: [f64; 1], [p, t]: [f64; 2], _: bool| {
            let next = p - tau * t;
            let longest = if next < 0.0 {
                p / t
            } else if next > cap {
                (p - cap) / t
            } else {
                f64::INFINITY
            };
            ([next.max(least)], [longest])
        };
        let shorter = |[a]: [f64; 1], [b]: [f64; 1]| [if b < a { b } else { a }];
        let [longest] = spans.fold([next], [p, t], contact, cut, [f64::INFINITY], shorter);
        let is_cut = longest.is_finite();
        // where what is left cannot be balanced, the step ends at the first bound
        let is_balanced = !is_cut || self.balance_next();
        if is_cut && self.cap.is_finite() && (!is_balanced || self.leads_nowhere()) {
            self.is_lost = true;
            return true;
        }
        let length = if is_balanced { self.tau } else { longest };
        self.add_to_gap(-length);
        let Self {
            p,
            t,
            next,
            contact,
            spans,
            ..
        } = &mut *self;
        // the bound at which the step ends
        let bound = |p: f64, t: f64| match t {
            _ if is_balanced => None,
            t if t > 0.0 && p <= longest * t => Some(0.0),
            _ => None,
        };
        if is_cut && is_balanced && cap.is_finite() {
            // what was cut off may have come back as the balance was restored
            for (c, next) in contact.iter_mut().zip(&*next) {
                *c &= *next > 0.0 && *next < cap;
            }
        } else if is_cut {
            for span in spans.iter() {
                let state = p[span.clone()].iter().zip(&t[span.clone()]);
                for ((p, t), c) in state.zip(&mut contact[span]) {
                    *c &= (0.0..=cap).contains(&(p - length * t)) && bound(*p, *t).is_none();
                }
            }
        }
        let step =
            |[p]: [f64; 1], [t]: [f64; 1], _: bool| ([bound(p, t).unwrap_or(p - length * t)], []);
        spans.sum([p], [t], contact, step);
        if is_cut {
            if is_balanced {
                self.put_difference();
                self.add_image(1.0);
                self.take_next();
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
            // what is at the cap may give way further
            let is_held = self.p[i] >= self.cap;
            let slack = if is_held {
                self.g[i].max(0.0)
            } else {
                self.g[i]
            };
            judged.take(self.p[i], slack, displacement);
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

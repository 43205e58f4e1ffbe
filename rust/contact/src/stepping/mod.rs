// SPDX-License-Identifier: MIT OR Apache-2.0
//! The sliding pair in time: one solve a step, each from what the last one knew.

mod bordered;
mod factor;
mod influence;

use std::collections::HashSet;
use std::sync::Arc;

use mtb_complementarity::linear::{Border, Problem, Status};
use mtb_operator::krylov::gmres;
use mtb_operator::{Monitor, report};

use crate::error::{Error, check};
use crate::sliding::{SlidingContact, SlidingSolution};
use bordered::{Bordered, Making, PARTS};
pub use influence::Influence;
use influence::{Sum, largest};

/// Relative residual of the equations on an active set at which they count as solved ...
const TOLERANCE: f64 = 1e-13;
/// ... and which must be reached.
const ACCEPTED: f64 = 1e-11;
/// Residual that is enough to see which points have the wrong sign, while sets still change.
const ROUGH: f64 = 1e-4;
/// Relative residual of a solution; each balance is relative to its own parts.
const SOLVED: f64 = 1e-9;
/// Share of the work of the largest pressure below which the parts of a balance are not its scale any more.
const LEAST: f64 = 1e-5;
/// Relative size below which a negative pressure or gap counts as rounding.
const ROUNDING: f64 = 1e-12;
/// Active sets tried before the general solver takes over.
const SETS: usize = 60;
/// A factorisation of k points is as dear as about k over this many products.
const PRODUCTS: usize = 20;

/// Solves a sliding pair again and again while loads, gap, friction and direction change.
///
/// Equal to [`SlidingMatrix::solve`](crate::sliding::SlidingMatrix::solve) wherever the solution is unique.
/// It keeps the points last in contact, and LU factors of all points (of those in contact, where these are less
/// than half). A step costs few solves with these factors: points that are not in contact are borders of them,
/// and with another friction they are the preconditioner of GMRES [SaadSchultz1986]. When a step has come to
/// cost more than the average since they were made, new ones are made, over some steps, so that no step pays for
/// all of them. Forwards and backwards are remembered apart, since factors for the one are no preconditioner
/// for the other. Sets that go round in circles change one point at a time until fewer signs are wrong
/// [JudicePires1994]. Where the active sets do not settle at all, the general solver decides, so that wedging
/// is found and named as without memory.
pub struct SlidingStepper {
    influence: Arc<Influence>,
    memory: Memory,
    /// Of friction in about the opposite direction.
    opposite: Memory,
    /// To be taken for the last step's.
    resumed: Option<Point>,
    scratch: Scratch,
}

/// What steps of friction in about one direction leave behind.
#[derive(Default)]
struct Memory {
    /// Friction of the last of them.
    drag: Vec<f64>,
    factors: Option<Bordered>,
    /// The next factors, on their way.
    making: Option<Making>,
    /// Products since the factors were made, the factorisation counted as so many, and steps that shared them.
    spent: (usize, usize),
    /// Products of a step, those of the last steps counting most.
    recent: f64,
    last: Option<Point>,
    before: Option<Point>,
}

/// What one step took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Active sets.
    pub sets: usize,
    /// Factorisations.
    pub factorisations: usize,
    /// Products with the influence matrix, and solves with the factors: each about as dear as the other. What few
    /// points add to a product that is known does not count.
    pub products: usize,
    /// Whether the general solver had to take over.
    pub fell_back: bool,
}

#[derive(Clone)]
struct Point {
    pressure: Vec<f64>,
    motion: Vec<f64>,
}

#[derive(Default)]
struct Scratch {
    gap: Vec<f64>,
    pressure: Vec<f64>,
    /// Pressures of this step whose gaps by the pressure are known, without the motions; empty before there are any.
    known: Vec<f64>,
    pressed: Vec<f64>,
    sum: Sum,
}

/// The equations solved on a set of points.
struct OnSet {
    point: Point,
    /// Of the determinant.
    sign: f64,
    /// Relative residual.
    error: f64,
}

/// The equations of one step on one set of points.
struct Equations<'a> {
    influence: &'a Influence,
    contact: &'a SlidingContact<'a>,
    drag: &'a [f64],
    points: &'a [usize],
}

impl SlidingStepper {
    /// A stepper that knows nothing yet; several may share the matrices.
    pub fn new(influence: Arc<Influence>) -> Self {
        Self {
            influence,
            memory: Memory::default(),
            opposite: Memory::default(),
            resumed: None,
            scratch: Scratch::default(),
        }
    }

    /// The influence matrices.
    pub fn influence(&self) -> &Arc<Influence> {
        &self.influence
    }

    /// Takes `pressure` (n) and `motion` for the last step's, in place of what it remembers.
    ///
    /// # Errors
    /// A wrong length, numbers that are not finite.
    pub fn resume(&mut self, pressure: &[f64], motion: &[f64]) -> Result<(), Error> {
        check("pressure", pressure, self.influence.points())?;
        check("motion", motion, motion.len())?;
        self.resumed = Some(Point {
            pressure: pressure.to_vec(),
            motion: motion.to_vec(),
        });
        Ok(())
    }

    /// Solves one step.
    ///
    /// # Errors
    /// As [`SlidingMatrix::solve`](crate::sliding::SlidingMatrix::solve); that no sliding state exists is a
    /// [`Status`].
    pub fn solve(
        &mut self,
        contact: &SlidingContact<'_>,
        monitor: Monitor<'_>,
    ) -> Result<(SlidingSolution, Effort), Error> {
        let n = self.influence.points();
        contact.check(n)?;
        let drag: Vec<f64> = contact
            .direction
            .iter()
            .enumerate()
            .map(|(i, d)| d * contact.friction[i % n.max(1)])
            .collect();
        let mut effort = Effort::default();
        self.recall(&drag);
        let found = self.by_sets(contact, &drag, &mut effort, monitor)?;
        let solution = if let Some(solution) = found {
            solution
        } else {
            effort.fell_back = true;
            let (matrix, symmetric) = self.influence.rows(&drag);
            contact.solve_with(matrix, symmetric, None, monitor)?
        };
        if !effort.fell_back {
            self.account(&mut effort, &drag, &solution.pressure, monitor)?;
        }
        if solution.status == Status::Solved {
            let now = Point {
                pressure: solution.pressure.clone(),
                motion: solution.motion.clone(),
            };
            self.memory.before = self.memory.last.replace(now);
        }
        Ok((solution, effort))
    }

    /// Turns to the memory of friction in the direction of `drag`.
    fn recall(&mut self, drag: &[f64]) {
        if self.memory.is_against(drag) {
            std::mem::swap(&mut self.memory, &mut self.opposite);
            if self.memory.is_against(drag) {
                self.memory = Memory::default();
            }
            self.memory.before = None;
        }
        self.memory.drag.clear();
        self.memory.drag.extend_from_slice(drag);
        if let Some(point) = self.resumed.take() {
            self.memory.before = None;
            self.memory.last = Some(point);
        }
    }

    /// Active sets from the last one on; `None` where they do not settle.
    fn by_sets(
        &mut self,
        contact: &SlidingContact<'_>,
        drag: &[f64],
        effort: &mut Effort,
        monitor: Monitor<'_>,
    ) -> Result<Option<SlidingSolution>, Error> {
        let n = self.influence.points();
        let m = contact.motions.len();
        let mut active: Vec<bool> = match &self.memory.last {
            Some(last) => last.pressure.iter().map(|p| *p > 0.0).collect(),
            None => vec![true; n],
        };
        if active.iter().filter(|a| **a).count() <= m {
            active.fill(true);
        }
        self.scratch.known.clear();
        let mut visited = HashSet::new();
        let mut guess = self.promise(m);
        let mut tolerance = ROUGH;
        let mut is_rough = true;
        let mut is_single = false;
        let mut fewest = usize::MAX;
        for iteration in 1..=SETS {
            effort.sets = iteration;
            // roughly, until the set holds or comes again
            let (mut next, changes, OnSet { point, sign, .. }) = loop {
                let found =
                    self.on_set(contact, drag, &active, &guess, tolerance, effort, monitor)?;
                let Some(mut found) = found else {
                    return Ok(None);
                };
                let unclipped = found.point.clone();
                let mut next = active.clone();
                let changes = flip(&mut next, &mut found.point.pressure, &mut self.scratch.gap);
                if found.error <= ACCEPTED || (changes > 0 && !visited.contains(&next)) {
                    break (next, changes, found);
                }
                tolerance = TOLERANCE;
                guess = unclipped;
            };
            if changes == 0 {
                let solution = finished(contact, point, &self.scratch.gap, sign, iteration);
                // a body that carries next to nothing has its own scale: to this of all bodies its pressures
                // may be rounding
                return Ok(Some(solution).filter(|s| s.residual <= SOLVED));
            }
            report(monitor, iteration, changes as f64 / n as f64)?;
            if changes < fewest {
                fewest = changes;
                if is_single {
                    is_single = false;
                    visited.clear();
                }
            }
            if is_single {
                keep_last_change(&active, &mut next);
            }
            if m > 0 && next.iter().all(|a| !a) {
                return Ok(None);
            }
            if visited.insert(next.clone()) {
                active = next;
            } else if is_rough {
                // what was nearly solved may have come back by its errors
                is_rough = false;
                tolerance = TOLERANCE;
                fewest = usize::MAX;
                visited.clear();
                active = next;
            } else if !is_single {
                is_single = true;
                visited.clear();
                keep_last_change(&active, &mut next);
                active = next;
            } else {
                return Ok(None);
            }
            guess = point;
        }
        Ok(None)
    }

    #[allow(
        clippy::too_many_arguments,
        reason = "a state of the search, and what it reports to"
    )]
    /// Pressures and motions that close the gaps of `active` to `tolerance`; the gaps of all points go to the scratch.
    fn on_set(
        &mut self,
        contact: &SlidingContact<'_>,
        drag: &[f64],
        active: &[bool],
        guess: &Point,
        tolerance: f64,
        effort: &mut Effort,
        monitor: Monitor<'_>,
    ) -> Result<Option<OnSet>, Error> {
        let points: Vec<usize> = (0..active.len()).filter(|&i| active[i]).collect();
        if points.len() < contact.motions.len() {
            return Ok(None);
        }
        let is_far = |f: &Bordered| f.is_far_from(active);
        if self.memory.factors.as_ref().is_none_or(is_far) {
            let set = factorisable(&points, active.len());
            self.factorise(drag, &set, effort, monitor)?;
        }
        let start: Vec<f64> = points
            .iter()
            .map(|&i| guess.pressure[i])
            .chain(guess.motion.iter().copied())
            .collect();
        // with the factors that are there, with new ones, and with those of the set itself
        for _ in 0..3 {
            let Some(factors) = self.memory.factors.as_mut() else {
                return Ok(None);
            };
            effort.products += factors.turn_to(&self.influence, contact, &points, monitor)?;
            let equations = Equations {
                influence: &self.influence,
                contact,
                drag,
                points: &points,
            };
            let mut x = start.clone();
            let solved = equations.solve(factors, &mut x, tolerance, &mut self.scratch, effort);
            if let Some(error) = solved {
                let mut pressure = vec![0.0; active.len()];
                for (p, &point) in x.iter().zip(&points) {
                    pressure[point] = *p;
                }
                for &point in &points {
                    self.scratch.gap[point] = 0.0;
                }
                let motion = x.split_off(points.len());
                return Ok(Some(OnSet {
                    point: Point { pressure, motion },
                    sign: factors.sign(),
                    error,
                }));
            }
            let is_exact = factors.is_exact(drag);
            if is_exact && factors.holds(active) {
                return Ok(None);
            }
            let set = if is_exact {
                points.clone()
            } else {
                factorisable(&points, active.len())
            };
            self.factorise(drag, &set, effort, monitor)?;
        }
        Ok(None)
    }

    fn factorise(
        &mut self,
        drag: &[f64],
        points: &[usize],
        effort: &mut Effort,
        monitor: Monitor<'_>,
    ) -> Result<(), Error> {
        self.memory.factors = Some(Bordered::new(&self.influence, drag, points, monitor)?);
        self.memory.making = None;
        self.memory.spent = (points.len() / PRODUCTS, 0);
        self.memory.recent = 0.0;
        effort.factorisations += 1;
        Ok(())
    }

    /// Counts what a step took. Once steps take more than those since the factors were made took on average, new
    /// ones are made, a part with each step, so that no step pays for all of them.
    fn account(
        &mut self,
        effort: &mut Effort,
        drag: &[f64],
        pressure: &[f64],
        monitor: Monitor<'_>,
    ) -> Result<(), Error> {
        let memory = &mut self.memory;
        let (products, steps) = memory.spent;
        let now = effort.products as f64;
        memory.recent = if steps == 0 {
            now
        } else {
            0.75 * memory.recent + 0.25 * now
        };
        memory.spent = (products + effort.products, steps + 1);
        if let Some(making) = memory.making.take() {
            match making.advance(&self.influence, monitor)? {
                Ok(factors) => {
                    memory.factors = Some(factors);
                    memory.spent = (pressure.len() / PRODUCTS, 0);
                    effort.factorisations += 1;
                }
                Err(making) => memory.making = Some(making),
            }
        } else if steps > 0
            && memory.recent * steps as f64 > products as f64
            && let Some(factors) = memory.factors.as_ref().filter(|f| !f.is_exact(drag))
        {
            let points: Vec<usize> = (0..pressure.len()).filter(|&i| pressure[i] > 0.0).collect();
            let set = factorisable(&points, pressure.len());
            // friction as it will be when they are ready, if it goes on like this
            let ahead = (PARTS as f64 / steps as f64).min(1.0);
            let there: Vec<f64> = (drag.iter().zip(factors.drag()))
                .map(|(now, then)| now + ahead * (now - then))
                .collect();
            memory.making = Some(Making::new(&there, set));
        }
        Ok(())
    }

    /// What the last two steps promise for this one, with `m` motions.
    fn promise(&self, m: usize) -> Point {
        let fits = |p: &&Point| p.motion.len() == m;
        let Some(last) = self.memory.last.as_ref().filter(fits) else {
            let n = self.influence.points();
            return Point {
                pressure: self
                    .memory
                    .last
                    .as_ref()
                    .map_or_else(|| vec![0.0; n], |p| p.pressure.clone()),
                motion: vec![0.0; m],
            };
        };
        let before = self.memory.before.as_ref().filter(fits).unwrap_or(last);
        let ahead = |now: &[f64], before: &[f64]| {
            now.iter()
                .zip(before)
                .map(|(now, before)| 2.0 * now - before)
                .collect()
        };
        Point {
            pressure: ahead(&last.pressure, &before.pressure),
            motion: ahead(&last.motion, &before.motion),
        }
    }
}

impl Memory {
    /// Whether it is of friction in about the opposite direction.
    fn is_against(&self, drag: &[f64]) -> bool {
        let along: f64 = self.drag.iter().zip(drag).map(|(a, b)| a * b).sum();
        along < 0.0
    }
}

impl Equations<'_> {
    /// Improves `x` (pressures of the set, then motions) until the equations hold to `tolerance`, and to rounding
    /// if it starts near; the relative residual reached, if they do.
    ///
    /// Leaves the gaps of all points in the scratch.
    fn solve(
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
        let exact = factors.is_exact(self.drag);
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
            self.drag,
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
                self.drag,
                &mut scratch.pressed,
            );
            effort.products += 1;
        } else if changed > 0 {
            for (known, p) in scratch.known.iter_mut().zip(&scratch.pressure) {
                *known = p - *known;
            }
            self.influence
                .add_product(&scratch.known, self.drag, &mut scratch.pressed);
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

/// Takes all changes from `active` to `next` back but the last one.
///
/// Changes of all wrong signs at once may go round in circles. One at a time, always the last one, they end for
/// every P-matrix [Murty1974], so both together do [JudicePires1994].
fn keep_last_change(active: &[bool], next: &mut [bool]) {
    let last = (0..active.len()).rev().find(|&i| active[i] != next[i]);
    for (i, (next, active)) in next.iter_mut().zip(active).enumerate() {
        if Some(i) != last {
            *next = *active;
        }
    }
}

/// The set whose factors serve `points` best: all points, of which any set of more than half is bordered by what
/// left, or the points themselves.
fn factorisable(points: &[usize], n: usize) -> Vec<usize> {
    if 2 * points.len() >= n {
        (0..n).collect()
    } else {
        points.to_vec()
    }
}

/// Moves what has the wrong sign to the other side; returns how much that was, and clips what is rounding.
fn flip(active: &mut [bool], pressure: &mut [f64], gap: &mut [f64]) -> usize {
    let (p_eps, g_eps) = (ROUNDING * largest(pressure), ROUNDING * largest(gap));
    let mut changes = 0;
    for ((active, p), g) in active.iter_mut().zip(pressure).zip(gap) {
        if if *active { *p < -p_eps } else { *g < -g_eps } {
            *active = !*active;
            changes += 1;
        }
        // a point that carries rounding only does not touch
        *p = if *p > p_eps { *p } else { 0.0 };
        *g = g.max(0.0);
    }
    changes
}

fn finished(
    contact: &SlidingContact<'_>,
    point: Point,
    gap: &[f64],
    sign: f64,
    iterations: usize,
) -> SlidingSolution {
    let n = gap.len();
    let work = |motion| (0..n).map(move |i| -contact.work_of_pressure(motion, i));
    let closing: Vec<f64> = contact
        .motions
        .iter()
        .flat_map(|m| m.opening.iter().map(|o| -o))
        .collect();
    let balance: Vec<f64> = contact.motions.iter().flat_map(work).collect();
    let target: Vec<f64> = contact.motions.iter().map(|m| m.work).collect();
    let problem = Problem {
        matrix: &[],
        offset: contact.gap,
        border: (!target.is_empty()).then_some(Border {
            motion: &closing,
            balance: &balance,
            target: &target,
        }),
        symmetric: false,
    };
    SlidingSolution {
        status: Status::Solved,
        residual: problem.residual(&point.pressure, gap, &point.motion),
        pressure: point.pressure,
        gap: gap.to_vec(),
        motion: point.motion,
        iterations,
        by_lemke: false,
        unstable: sign < 0.0,
    }
}

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
use bordered::Bordered;
pub use influence::Influence;
use influence::largest;

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
const SETS: usize = 30;
/// A factorisation of k points is as dear as about k over this many products.
const PRODUCTS: usize = 20;

/// Solves a sliding pair again and again while loads, gap, friction and direction change.
///
/// Equal to [`SlidingMatrix::solve`](crate::sliding::SlidingMatrix::solve) wherever the solution is unique.
/// It keeps the points last in contact and their LU factors. While the set holds, a step costs a solve with
/// these factors; a few points that came or left are borders of it; with another friction the factors are
/// the preconditioner of GMRES [SaadSchultz1986]. They are made anew when a step has come to cost
/// more than the average since they were made. Forwards and backwards are remembered apart, since factors
/// for the one are no preconditioner for the other. Where the active sets do not settle, the general
/// solver decides, so that wedging is found and named as without memory.
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
    /// Products with the influence matrix, and solves with the factors: each about as dear as the other.
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
        self.account(effort);
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
        let mut visited = HashSet::new();
        let mut guess = self.promise(m);
        let mut tolerance = ROUGH;
        for iteration in 1..=SETS {
            effort.sets = iteration;
            // roughly, until the set holds or comes again
            let (changes, OnSet { point, sign, .. }) = loop {
                let found =
                    self.on_set(contact, drag, &active, &guess, tolerance, effort, monitor)?;
                let Some(mut found) = found else {
                    return Ok(None);
                };
                let unclipped = found.point.clone();
                let mut next = active.clone();
                let changes = flip(&mut next, &mut found.point.pressure, &mut self.scratch.gap);
                if found.error <= ACCEPTED || (changes > 0 && !visited.contains(&next)) {
                    active = next;
                    break (changes, found);
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
            let empty = m > 0 && active.iter().all(|a| !a);
            if empty || !visited.insert(active.clone()) {
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
        if self
            .memory
            .factors
            .as_ref()
            .is_none_or(|f| f.is_far_from(active))
        {
            self.factorise(drag, &points, effort, monitor)?;
        }
        let start: Vec<f64> = points
            .iter()
            .map(|&i| guess.pressure[i])
            .chain(guess.motion.iter().copied())
            .collect();
        for _ in 0..2 {
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
            if factors.is_exact(drag) && factors.holds(active) {
                return Ok(None);
            }
            self.factorise(drag, &points, effort, monitor)?;
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
        self.memory.spent = (points.len() / PRODUCTS, 0);
        self.memory.recent = 0.0;
        effort.factorisations += 1;
        Ok(())
    }

    /// Gives the factors up once steps take more than those since they were made took on average.
    fn account(&mut self, effort: Effort) {
        let memory = &mut self.memory;
        let (products, steps) = memory.spent;
        let now = effort.products as f64;
        memory.recent = if steps == 0 {
            now
        } else {
            0.75 * memory.recent + 0.25 * now
        };
        if steps > 0 && memory.recent * steps as f64 > products as f64 {
            memory.factors = None;
        }
        memory.spent = (products + effort.products, steps + 1);
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
        let mut error = self.residual(x, &mut r, &mut scale, scratch);
        effort.products += 1;
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
            error = self.residual(x, &mut r, &mut scale, scratch);
            effort.products += 1;
        }
        (error <= ACCEPTED.max(tolerance)).then_some(error)
    }

    /// What is left of the equations at `x`, its size relative to `scale`, which is set to that of the data.
    fn residual(&self, x: &[f64], r: &mut [f64], scale: &mut [f64], scratch: &mut Scratch) -> f64 {
        let (k, m) = (self.points.len(), self.contact.motions.len());
        scratch.gap.clear();
        scratch.gap.extend_from_slice(self.contact.gap);
        self.add_gap(x, scratch);
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
        scratch.gap.clear();
        scratch.gap.resize(self.contact.gap.len(), 0.0);
        self.add_gap(x, scratch);
        for (out, &point) in out.iter_mut().zip(self.points) {
            *out = scratch.gap[point];
        }
        for (out, motion) in out[k..].iter_mut().zip(self.contact.motions) {
            let work =
                |(p, &point): (&f64, &usize)| -p * self.contact.work_of_pressure(motion, point);
            *out = x.iter().zip(self.points).map(work).sum();
        }
    }

    /// Adds what the pressures and motions of `x` do to the gaps.
    fn add_gap(&self, x: &[f64], scratch: &mut Scratch) {
        let k = self.points.len();
        scratch.pressure.clear();
        scratch.pressure.resize(self.contact.gap.len(), 0.0);
        for (p, &point) in x.iter().zip(self.points) {
            scratch.pressure[point] = *p;
        }
        self.influence
            .add_product(&scratch.pressure, self.drag, &mut scratch.gap);
        for (motion, c) in self.contact.motions.iter().zip(&x[k..]) {
            for (g, o) in scratch.gap.iter_mut().zip(&motion.opening) {
                *g += o * c;
            }
        }
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

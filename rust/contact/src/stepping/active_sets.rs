// SPDX-License-Identifier: MIT OR Apache-2.0
use std::collections::HashSet;

use mtb_complementarity::linear::{Border, Problem, ROUNDING, Sides, Status};
use mtb_operator::{Monitor, report};

use super::equations::{Equations, ROUGH, TOLERANCE};
use super::influence::Terms;
use super::{Effort, Point, SlidingStepper};
use crate::columns::largest;
use crate::error::Error;
use crate::sliding::{RigidMotion, SlidingContact, SlidingSolution};

/// Relative residual of a solution; each balance is relative to its own parts.
const SOLVED: f64 = 1e-9;
/// Active sets tried before the general solver takes over.
const SETS: usize = 60;

/// The equations solved on a set of points.
struct OnSet {
    point: Point,
    /// Of the determinant.
    sign: f64,
    /// Relative residual.
    error: f64,
}

/// Gap and motions of the points that are not held at the limit, under the pressures `load` of those that are.
struct Held {
    gap: Vec<f64>,
    motions: Vec<RigidMotion>,
    load: Vec<f64>,
}

impl SlidingStepper {
    /// Active sets from the last one on; `None` where they do not settle.
    pub(super) fn by_sets(
        &mut self,
        contact: &SlidingContact<'_>,
        terms: &Terms,
        effort: &mut Effort,
        monitor: Monitor<'_>,
    ) -> Result<Option<SlidingSolution>, Error> {
        let n = self.influence.points();
        let m = contact.motions.len();
        let limit = contact.limit();
        let start = self.memory.landmarks.start(contact);
        let mut active = match start.as_ref().or(self.memory.last.as_ref()) {
            Some(point) => Sides::of_pressure(&point.pressure, limit),
            None => Sides::of(vec![true; n]),
        };
        if active.count() <= m {
            active = Sides::of(vec![true; n]);
        }
        let mut visited = HashSet::new();
        let mut guess = start.unwrap_or_else(|| self.promise(m, &terms.drag));
        self.scratch.begin(&terms.drag, guess.opened.take());
        let mut tolerance = ROUGH;
        let mut is_rough = true;
        let mut is_single = false;
        let mut fewest = usize::MAX;
        for iteration in 1..=SETS {
            effort.sets = iteration;
            let held = self.held(contact, terms, &active);
            let others = held.as_ref().map_or(*contact, |held| SlidingContact {
                gap: &held.gap,
                motions: &held.motions,
                ..*contact
            });
            // roughly, until the set holds or comes again
            let (mut next, changes, OnSet { point, sign, error }) = loop {
                let closed = &active.closed;
                let found =
                    self.on_set(&others, terms, closed, &guess, tolerance, effort, monitor)?;
                let Some(mut found) = found else {
                    return Ok(None);
                };
                if let Some(held) = &held {
                    let pairs = found.point.pressure.iter_mut().zip(&held.load);
                    pairs.for_each(|(p, load)| *p += load);
                }
                let unclipped = found.point.clone();
                let mut next = active.clone();
                let pressure = &mut found.point.pressure;
                let changes = flip(&mut next, pressure, &mut self.scratch.gap, limit, m.max(1));
                let is_exact = tolerance <= TOLERANCE || found.error <= TOLERANCE;
                if is_exact || (changes > 0 && !visited.contains(&next)) {
                    break (next, changes, found);
                }
                tolerance = TOLERANCE;
                guess = unclipped;
            };
            if changes == 0 {
                let gap = &self.scratch.gap;
                let mut solution = finished(contact, point, gap, sign, iteration);
                // gaps of the set are zero now, and what they were is not seen there
                solution.residual = solution.residual.max(error);
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
            if m > 0 && next.is_open() {
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

    /// What the points held at the limit leave for the others; `None` where none is.
    fn held(&self, contact: &SlidingContact<'_>, terms: &Terms, sides: &Sides) -> Option<Held> {
        if !sides.is_held() {
            return None;
        }
        let load = sides.load(contact.limit());
        let mut gap = contact.gap.to_vec();
        self.influence.add_product(&load, terms, &mut gap);
        let motions = contact.motions.iter().map(|motion| {
            let carried = |(i, p): (usize, &f64)| contact.work_of_pressure(motion, i) * p;
            let carried: f64 = load.iter().enumerate().map(carried).sum();
            RigidMotion {
                work: motion.work + carried,
                ..motion.clone()
            }
        });
        Some(Held {
            motions: motions.collect(),
            gap,
            load,
        })
    }

    #[allow(
        clippy::too_many_arguments,
        reason = "a state of the search, and what it reports to"
    )]
    /// Pressures and motions that close the gaps of `active` to `tolerance`; the gaps of all points go to the scratch.
    fn on_set(
        &mut self,
        contact: &SlidingContact<'_>,
        terms: &Terms,
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
        if !self.memory.serves(active, points.len()) {
            self.factorise(terms, &points, effort, monitor)?;
        }
        let start: Vec<f64> = points
            .iter()
            .map(|&i| guess.pressure[i])
            .chain(guess.motion.iter().copied())
            .collect();
        // with the factors that are there, and with those of the set itself
        for _ in 0..2 {
            let Some(factors) = self.memory.serving().factors.as_mut() else {
                return Ok(None);
            };
            effort.products += factors.turn_to(&self.influence, contact, &points, monitor)?;
            let equations = Equations::new(&self.influence, contact, terms, &points);
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
                    point: Point {
                        pressure,
                        motion,
                        opened: None,
                    },
                    sign: factors.sign(),
                    error,
                }));
            }
            if factors.is_exact(terms) && factors.holds(active) {
                return Ok(None);
            }
            self.factorise(terms, &points, effort, monitor)?;
        }
        Ok(None)
    }
}

/// Takes all changes from `active` to `next` back but the last one.
///
/// Changes of all wrong signs at once may go round in circles. One at a time, always the last one, they end for
/// every P-matrix [Murty1974], so both together do [JudicePires1994].
fn keep_last_change(active: &Sides, next: &mut Sides) {
    if let Some(last) = next.changed(active).pop() {
        let all = std::mem::replace(next, active.clone());
        next.take(&all, last);
    }
}

/// Moves what has the wrong sign to the other side; returns how much that was, and clips what is rounding.
fn flip(
    active: &mut Sides,
    pressure: &mut [f64],
    gap: &mut [f64],
    limit: Option<&[f64]>,
    needed: usize,
) -> usize {
    let least = [ROUNDING * largest(pressure), ROUNDING * largest(gap)];
    let changes = active.turn(pressure, gap, limit, least, needed);
    for (i, (p, g)) in pressure.iter_mut().zip(gap).enumerate() {
        // a point that carries rounding only does not touch
        *p = if *p > least[0] { *p } else { 0.0 };
        let most = limit.map_or(f64::INFINITY, |limit| limit[i]);
        *g = if *p >= most { g.min(0.0) } else { g.max(0.0) };
        *p = p.min(most);
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
        limit: contact.limit(),
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

// SPDX-License-Identifier: MIT OR Apache-2.0
//! The sliding pair in time: one solve a step, each from what the last one knew.

mod active_sets;
mod adjoint;
mod bordered;
mod equations;
mod factor;
mod factored;
mod influence;
mod landmarks;
mod opened;
mod products;
mod tangent;

use std::sync::Arc;

use mtb_complementarity::linear::{Status, from_touching};
use mtb_operator::Monitor;

use crate::error::{Error, check};
use crate::interface::{Linearisation, ROUNDS, SETTLED, Yielding};
use crate::sliding::{SlidingContact, SlidingSolution, check_own};
pub use adjoint::{ByLoads, Weights};
use bordered::{Bordered, Making, PARTS, factorisation, reach, solving};
use equations::Scratch;
pub use influence::Influence;
use influence::Terms;
use landmarks::Landmarks;
use opened::Opened;
pub use tangent::{Found, Given, Linearised, SlidingState, Tangent};

/// A factorisation of k points is as dear as about k over this many products.
const PRODUCTS: usize = 20;

/// Solves a sliding pair again and again while loads, gap, friction, direction and diagonal compliance change.
///
/// Equal to [`SlidingMatrix::solve`](crate::sliding::SlidingMatrix::solve) wherever the solution is unique.
/// It keeps states of the past, and starts from the one whose gap and loads are most like those of the step: the last
/// one, unless another is much nearer. What the pressures of the last two have opened tells, without a product, how the
/// gaps begin that they promise. It keeps LU factors of all points and of a set of them, and takes those that need
/// the least operations, or new ones of the set itself where these need less. Points in which a set differs from the
/// one of the factors are borders of them, and with another friction or diagonal the factors are the preconditioner of
/// GMRES [SaadSchultz1986]. When a step has come to cost more than the average since they were made, new ones are made,
/// over some steps, so that no step pays for all of them. Where those of all points serve and the set lasts, some of
/// this set are made in the same way. Forwards and backwards are remembered apart, since factors for the one are no
/// preconditioner for the other. Sets that go round in circles change one point at a time until
/// fewer signs are wrong [JudicePires1994]. Where the active sets do not settle at all, the general solver decides, so
/// that wedging is found and named as without memory.
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
    /// Factors of all points, and of a set: loads that jump come back to both.
    of_all: Kept,
    of_set: Kept,
    /// Whether those of all points served last.
    is_of_all: bool,
    last: Option<Point>,
    before: Option<Point>,
    landmarks: Landmarks,
}

/// Factors that steps share.
#[derive(Default)]
struct Kept {
    factors: Option<Bordered>,
    /// The next factors, on their way.
    making: Option<Making>,
    /// Products since the factors were made, the factorisation counted as so many, and steps that shared them.
    spent: (usize, usize),
    /// Products of a step, those of the last steps counting most.
    recent: f64,
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

impl Effort {
    fn add(&mut self, other: Self) {
        self.sets += other.sets;
        self.factorisations += other.factorisations;
        self.products += other.products;
        self.fell_back |= other.fell_back;
    }
}

#[derive(Clone)]
struct Point {
    pressure: Vec<f64>,
    motion: Vec<f64>,
    /// What the pressures open, or most of them, where it is known.
    opened: Option<Opened>,
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
            opened: None,
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
        contact.check(self.influence.points())?;
        let Some(shear) = contact.interface.and_then(|i| i.shear.as_ref()) else {
            return self.solve_layered(contact, monitor);
        };
        let last = self.resumed.as_ref().or(self.memory.last.as_ref());
        let at = last.map(|point| point.pressure.clone());
        let mut yielding = Yielding::new(shear, contact.friction, at.as_deref());
        let mut all = Effort::default();
        let mut failed: Option<SlidingSolution> = None;
        for round in 1.. {
            let (friction, given) = (yielding.coefficients(), yielding.given());
            let motions = yielding.motions(contact);
            let mut gap = contact.gap.to_vec();
            self.influence
                .add_friction(contact.direction, &given, &mut gap);
            let held = SlidingContact {
                gap: &gap,
                friction: &friction,
                motions: &motions,
                ..*contact
            };
            if round > 1 {
                // not a further step: nothing is ahead
                self.memory.before = None;
            }
            let (mut found, effort) = self.solve_layered(&held, monitor)?;
            all.add(effort);
            found.iterations = all.sets;
            if found.status != Status::Solved {
                let goes_on = yielding.retreat();
                let first = failed.get_or_insert(found);
                if !goes_on {
                    return Ok((first.clone(), all));
                }
                found = first.clone();
            } else if yielding.turn(&found.pressure) {
                return Ok((found, all));
            }
            if round >= ROUNDS {
                found.status = Status::IterationLimit;
                return Ok((found, all));
            }
        }
        unreachable!("the rounds end")
    }

    /// The same with a shear limit left out.
    fn solve_layered(
        &mut self,
        contact: &SlidingContact<'_>,
        monitor: Monitor<'_>,
    ) -> Result<(SlidingSolution, Effort), Error> {
        let Some(law) = contact.interface.and_then(|i| i.rough.as_ref()) else {
            return self.solve_linear(contact, monitor);
        };
        let influence = Arc::clone(&self.influence);
        let normal = influence.normal();
        let own = |i: usize| normal[i * (contact.gap.len() + 1)];
        let last = self.resumed.as_ref().or(self.memory.last.as_ref());
        let mut at = last.map(|point| point.pressure.clone());
        let begin = |at: Option<&Vec<f64>>| {
            let at = at.map_or_else(|| contact.mean_pressure(), Clone::clone);
            Linearisation::new(law, contact.gap, own, Some(at))
        };
        let mut rough = begin(at.as_ref());
        let mut all = Effort::default();
        for round in 1.. {
            let (gap, diagonal) = rough.linear(contact.gap, contact.diagonal);
            let linear = SlidingContact {
                gap: &gap,
                diagonal: Some(&diagonal),
                ..*contact
            };
            if round > 1 {
                // not a further step: nothing is ahead
                self.memory.before = None;
            }
            let (mut found, effort) = self.solve_linear(&linear, monitor)?;
            all.add(effort);
            found.iterations = all.sets;
            if found.status != Status::Solved {
                if at.take().is_none() {
                    return Ok((found, all));
                }
                // the law about the last state may have no solution: as without a memory
                rough = begin(None);
                continue;
            }
            if rough.turn(&found.pressure, &mut found.gap) <= SETTLED {
                rough.check_end(&found.pressure)?;
                return Ok((found, all));
            }
            if round >= ROUNDS {
                found.status = Status::IterationLimit;
                return Ok((found, all));
            }
        }
        unreachable!("the rounds end")
    }

    /// The same with a law of a rough layer left out.
    fn solve_linear(
        &mut self,
        contact: &SlidingContact<'_>,
        monitor: Monitor<'_>,
    ) -> Result<(SlidingSolution, Effort), Error> {
        let n = self.influence.points();
        let terms = Terms {
            drag: (contact.direction.iter())
                .zip(contact.friction.iter().chain(contact.friction))
                .map(|(d, mu)| d * mu)
                .collect(),
            diagonal: contact.diagonal.unwrap_or(&[]).to_vec(),
        };
        for (i, own) in terms.diagonal.iter().enumerate() {
            check_own(i, self.influence.normal()[i * (n + 1)], *own)?;
        }
        let mut effort = Effort::default();
        self.recall(&terms.drag);
        let closing: Vec<f64> = (contact.motions.iter())
            .flat_map(|motion| motion.opening.iter().map(|o| -o))
            .collect();
        let shifted = from_touching(contact.gap, &closing);
        let near = shifted
            .as_ref()
            .map_or(*contact, |(_, gap)| SlidingContact { gap, ..*contact });
        let found = self.by_sets(&near, &terms, &mut effort, monitor)?;
        let solution = if let Some(mut solution) = found {
            if let Some((moved, _)) = &shifted {
                let motions = solution.motion.iter_mut().zip(moved);
                motions.for_each(|(c, m)| *c += m);
            }
            solution
        } else {
            effort.fell_back = true;
            let (matrix, symmetric) = self.influence.rows(&terms);
            contact.solve_with(matrix, symmetric, None, None, monitor)?
        };
        if !effort.fell_back {
            self.account(&mut effort, &terms, &solution.pressure, monitor)?;
        }
        if solution.status == Status::Solved {
            // what no product of this step has told is not handed on: rounding would grow from step to step
            let is_known = self.scratch.is_fresh && !effort.fell_back;
            let now = Point {
                pressure: solution.pressure.clone(),
                motion: solution.motion.clone(),
                opened: is_known.then(|| std::mem::take(&mut self.scratch.opened)),
            };
            let gap = &solution.gap;
            (self.memory.landmarks).keep(contact, &now, gap, effort.sets);
            self.memory.before = self.memory.last.replace(now);
        }
        Ok((solution, effort))
    }

    /// The equations linearised about the `state` of the last step, with the factors that it left.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, an interruption.
    pub fn tangent<'a>(
        &'a mut self,
        state: &'a SlidingState,
        monitor: Monitor<'_>,
    ) -> Result<Tangent<'a>, Error> {
        let kept = self.memory.serving();
        let factors = match kept.factors.take() {
            Some(factors) => factors,
            None => tangent::factors_of(&self.influence, state, monitor)?,
        };
        let factors = kept.factors.insert(factors);
        Tangent::new(&self.influence, state, factors)
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
            // what is asked for is to start there
            self.memory.landmarks.stay();
        }
    }

    fn factorise(
        &mut self,
        terms: &Terms,
        points: &[usize],
        effort: &mut Effort,
        monitor: Monitor<'_>,
    ) -> Result<(), Error> {
        self.memory.is_of_all = points.len() == self.influence.points();
        *self.memory.serving() = Kept::of(Bordered::new(&self.influence, terms, points, monitor)?);
        effort.factorisations += 1;
        Ok(())
    }

    /// Counts what a step took. Once steps take more than those since the factors were made took on average, new
    /// ones are made, a part with each step, so that no step pays for all of them; and so are those of a set that
    /// lasts.
    fn account(
        &mut self,
        effort: &mut Effort,
        terms: &Terms,
        pressure: &[f64],
        monitor: Monitor<'_>,
    ) -> Result<(), Error> {
        let is_of_all = self.memory.is_of_all;
        let kept = self.memory.serving();
        let (products, steps) = kept.spent;
        let now = effort.products as f64;
        kept.recent = if steps == 0 {
            now
        } else {
            0.75 * kept.recent + 0.25 * now
        };
        kept.spent = (products + effort.products, steps + 1);
        let recent = kept.recent;
        if let Some(is_ready) = self.memory.advance(&self.influence, monitor)? {
            effort.factorisations += usize::from(is_ready);
        } else if let Some(set) = self.memory.set_to_make(pressure) {
            self.memory.of_set.making = Some(Making::new(terms.clone(), set));
        } else if steps > 0
            && let kept = self.memory.serving()
            && recent * steps as f64 > products as f64
            && let Some(factors) = kept.factors.as_ref().filter(|f| !f.is_exact(terms))
        {
            let closed = |i: &usize| is_of_all || pressure[*i] > 0.0;
            let set = (0..pressure.len()).filter(closed).collect();
            // friction as it will be when they are ready, if it goes on like this
            let ahead = (PARTS as f64 / steps as f64).min(1.0);
            let there = (terms.drag.iter().zip(&factors.terms().drag))
                .map(|(now, then)| now + ahead * (now - then))
                .collect();
            let there = Terms {
                drag: there,
                diagonal: terms.diagonal.clone(),
            };
            kept.making = Some(Making::new(there, set));
        }
        Ok(())
    }

    /// What the last two steps promise for this one, with `m` motions and the friction `drag`.
    fn promise(&self, m: usize, drag: &[f64]) -> Point {
        let fits = |p: &&Point| p.motion.len() == m;
        let under = |p: &Point| p.opened.as_ref()?.under(drag);
        let Some(last) = self.memory.last.as_ref().filter(fits) else {
            let last = self.memory.last.as_ref();
            let nothing = || vec![0.0; self.influence.points()];
            return Point {
                pressure: last.map_or_else(nothing, |p| p.pressure.clone()),
                motion: vec![0.0; m],
                opened: last.and_then(under),
            };
        };
        let Some(before) = self.memory.before.as_ref().filter(fits) else {
            return Point {
                pressure: last.pressure.clone(),
                motion: last.motion.clone(),
                opened: under(last),
            };
        };
        let ahead = |now: &[f64], before: &[f64]| {
            now.iter()
                .zip(before)
                .map(|(now, before)| 2.0 * now - before)
                .collect()
        };
        let opened = under(last).zip(under(before));
        Point {
            pressure: ahead(&last.pressure, &before.pressure),
            motion: ahead(&last.motion, &before.motion),
            opened: opened.and_then(|(last, before)| last.ahead(&before)),
        }
    }
}

impl Kept {
    /// Factors that are new.
    fn of(factors: Bordered) -> Self {
        Self {
            spent: (factors.rows() / PRODUCTS, 0),
            factors: Some(factors),
            ..Self::default()
        }
    }
}

impl Memory {
    /// The factors that served last.
    fn serving(&mut self) -> &mut Kept {
        if self.is_of_all {
            &mut self.of_all
        } else {
            &mut self.of_set
        }
    }

    /// Turns to the factors with which the equations on the set `active`, of so many points, take the least
    /// operations; `false` where new ones of the set itself would.
    fn serves(&mut self, active: &[bool], points: usize) -> bool {
        let taking =
            |factors: Option<&Bordered>| factors.map_or(f64::INFINITY, |f| f.taking(active));
        let of_all = taking(self.of_all.factors.as_ref());
        let of_set = self.of_set.factors.as_ref();
        let of_set = taking(of_set.filter(|factors| !factors.is_far_from(active)));
        self.is_of_all = of_all <= of_set;
        of_all.min(of_set) <= factorisation(points) + solving(points, 0)
    }

    /// The points under `pressure`, if those of all points serve but factors of this set would save their making: it
    /// changes so little from step to step that they would serve for longer than they take to make.
    fn set_to_make(&self, pressure: &[f64]) -> Option<Vec<usize>> {
        let last = self.last.as_ref().filter(|_| self.is_of_all)?;
        let (n, steps) = (pressure.len(), 2 * PARTS);
        let set: Vec<usize> = (0..n).filter(|&i| pressure[i] > 0.0).collect();
        let pairs = pressure.iter().zip(&last.pressure);
        let changes = pairs.filter(|(p, q)| (**p > 0.0) != (**q > 0.0)).count();
        let saved = solving(n, n - set.len()) - solving(set.len(), 0);
        (changes * steps <= reach(set.len()) && saved * steps as f64 > factorisation(set.len()))
            .then_some(set)
    }

    /// Makes the next part of factors that are on their way; `None` where none are, else whether they are ready.
    fn advance(
        &mut self,
        influence: &Influence,
        monitor: Monitor<'_>,
    ) -> Result<Option<bool>, Error> {
        for kept in [&mut self.of_set, &mut self.of_all] {
            let Some(making) = kept.making.take() else {
                continue;
            };
            match making.advance(influence, monitor)? {
                Ok(factors) => {
                    *kept = Kept::of(factors);
                    return Ok(Some(true));
                }
                Err(making) => {
                    kept.making = Some(making);
                    return Ok(Some(false));
                }
            }
        }
        Ok(None)
    }

    /// Whether it is of friction in about the opposite direction.
    fn is_against(&self, drag: &[f64]) -> bool {
        let along: f64 = self.drag.iter().zip(drag).map(|(a, b)| a * b).sum();
        along < 0.0
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Steps in which points stick or slip, with the tractions of the last step as their memory.
//!
//! A step displaces the upper body over the lower one by a shift, and by the change of its pose. With `v` the tangential
//! displacement `u_lower - u_upper` at a contact point, by the tractions, by rigid motions and by the loads on the bodies,
//! the point slips by
//!
//! ```text
//! s = shift - (v - v_old),
//! ```
//!
//! where `v_old` is that of the last step. Contact points are those of the upper body, and so is what they
//! remember. The strain of the lower body below moves on with it: that a shift brings other points of the lower body there
//! is left out, an error of the order of the shift times the strain.
//!
//! Where all points slip, [`SlidingStepper`] solves the step in the direction of the shift. It is taken if the slip turns
//! out to go that way at each point; otherwise the direction follows the slip until it does. All else is solved by
//! [`CoupledContact`].

use std::sync::Arc;

use mtb_complementarity::linear::Status;
use mtb_operator::Monitor;

use super::{Prepared, PreparedContact, Pull, STEEPEST, Table, check_size};
use crate::coupled::{
    CoupledContact, CoupledLoad, CoupledMatrix, CoupledState, OnDemand, PointState,
};
use crate::error::{Error, check};
use crate::magnet::Face;
use crate::problem::{Loading, Outcome, Slipped};

/// Residual over the norm of the pressure.
pub(super) const TOLERANCE: f64 = 1e-11;

/// Share of the largest displacement below which a slip is rounding: the point stands at the edge of its friction.
const ROUNDING: f64 = 1e-12;

/// Rounds in which the direction of sliding must have followed the slip.
const ROUNDS: usize = 8;

/// How far from it, over the tolerance, rounds that are foretold badly may end.
const DOUBT: f64 = 100.0;

/// Both bodies, and how what presses them moves them along their faces: what steps need in which points stick.
#[derive(Clone, Debug, PartialEq)]
pub struct Bodies {
    /// Compliance of the pair.
    pub pair: OnDemand<CoupledMatrix>,
    /// Displacement `u_lower - u_upper` along both tangents (2n) [m] by the loads, over the sliding speed.
    pub loads: Table,
    /// The same without a magnetic pressure, and its change by a uniform magnetic pressure of 1 Pa.
    pub magnetic: Option<[Vec<f64>; 2]>,
    /// Displacement along both tangents by a pull at the points, where a [`Pulled`](super::Pulled) has a face.
    pub pulled: Option<OnDemand<Face>>,
}

impl Bodies {
    /// Checks the lengths for so many points.
    pub(super) fn check(&self, n: usize) -> Result<(), Error> {
        self.loads.check("displacement along the tangents", 2 * n)?;
        for part in self.magnetic.iter().flatten() {
            check("displacement along the tangents", part, 2 * n)?;
        }
        Ok(())
    }
}

/// What a step leaves behind for the next one with a shift.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Past {
    /// Tractions along both tangents on the lower body, then pressures (3n) [Pa].
    pub(super) traction: Vec<f64>,
    /// Displacement of the bodies by them (3n) [m], where it is known.
    elastic: Option<Vec<f64>>,
    motion: Vec<f64>,
    /// Tangential displacement `u_lower - u_upper` by rigid motions, pose and loads (2n) [m].
    pub(super) rigid: Vec<f64>,
    /// Whether no point in contact stuck.
    all_slipped: bool,
}

/// What a step with a shift starts from, and how far it goes.
pub(super) struct Way {
    pub(super) matrix: Arc<CoupledMatrix>,
    /// Friction coefficient at each point (n).
    pub(super) friction: Vec<f64>,
    /// Displacement of the upper body over the lower one along both tangents (2n) [m].
    shift: Vec<f64>,
    /// Displacement `u_lower - u_upper` along both tangents by the pose (2n) [m].
    placed: Vec<f64>,
    before: Option<Before>,
}

/// The last step, as a step with a shift starts from it.
struct Before {
    traction: Vec<f64>,
    motion: Vec<f64>,
    /// Displacement of the bodies (3n) [m].
    elastic: Vec<f64>,
    /// Tangential displacement (2n) [m], elastic and rigid.
    all: Vec<f64>,
    all_slipped: bool,
}

impl Way {
    /// Whether nothing rubs, so that no point can stick.
    fn is_frictionless(&self) -> bool {
        self.friction.iter().all(|friction| *friction == 0.0)
    }

    /// Whether rounds may bring the direction of sliding from the shift to the slip, as far as the last step tells: its
    /// tractions are about as far from the shift, and each round leaves of that what the tractions move the bodies over
    /// what these slide.
    fn may_follow(&self, before: &Before) -> bool {
        let n = self.friction.len();
        let Some(direction) = directions(&self.shift, |_| true) else {
            return false;
        };
        let size = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
        let (mut turned, mut all) = (0.0, 0.0);
        for i in 0..n {
            let q = [i, n + i].map(|k| before.traction[k]);
            let length = q[0].hypot(q[1]);
            let [x, y] = [0, 1].map(|c| q[c] - length * direction[c * n + i]);
            turned += x * x + y * y;
            all += length * length;
        }
        let left = (size(&before.elastic[..2 * n]) / size(&self.shift)).min(1.0);
        let foretold = turned.sqrt() * left.powi(ROUNDS as i32 - 1);
        foretold <= DOUBT * TOLERANCE * f64::sqrt(all)
    }
}

impl Past {
    pub(super) fn of(outcome: &mut Outcome, rigid: Vec<f64>) -> Self {
        let solution = &outcome.solution;
        Self {
            traction: [&*outcome.traction, &solution.pressure].concat(),
            elastic: outcome.elastic.take(),
            motion: solution.motion.clone(),
            rigid,
            all_slipped: !outcome.points.contains(&PointState::Stick),
        }
    }
}

impl Prepared {
    /// Components of vectors (3n) along both tangents (2n), times `sign`.
    pub(super) fn tangential(&self, vectors: &[f64], sign: f64) -> Vec<f64> {
        let g = &self.geometry;
        [&g.tangent_x, &g.tangent_y]
            .map(|axes| g.along(axes, vectors, sign))
            .concat()
    }

    /// Displacement `u_lower - u_upper` along both tangents (2n) [m] by that of the upper body (3n).
    pub(super) fn placed(&self, moved: Option<&[f64]>) -> Vec<f64> {
        moved.map_or_else(
            || vec![0.0; 2 * self.geometry.points()],
            |moved| self.tangential(moved, -1.0),
        )
    }

    /// Displacement `u_lower - u_upper` along both tangents (2n) [m] by what presses at a velocity; of a magnet whose pull
    /// follows the gap by all else. Zeros where the bodies are not known.
    pub(super) fn along(&self, pull: &Pull<'_>, [x, y]: [f64; 2]) -> Result<Vec<f64>, Error> {
        let n = self.geometry.points();
        if let Pull::Given(given) = pull {
            check("displacement along the tangents", &given.along, 2 * n)?;
            return Ok(given.along.clone());
        }
        let Some(bodies) = &self.bodies else {
            return Ok(vec![0.0; 2 * n]);
        };
        match (pull, &bodies.magnetic) {
            (Pull::Uniform(pressure), Some([base, unit])) => {
                let moved = base.iter().zip(unit);
                Ok(moved.map(|(b, u)| b + pressure * u).collect())
            }
            (Pull::Following(_) | Pull::AmpereTurns(_), Some([base, _])) => Ok(base.clone()),
            (Pull::Following(_) | Pull::AmpereTurns(_), None) => {
                bodies.loads.at("magnetic_pressure", 0.0)
            }
            _ => bodies.loads.at("magnetic_pressure", x.hypot(y)),
        }
    }

    /// The same by the free motions as well, those `balanced` with these amplitudes.
    pub(super) fn rigid(
        &self,
        mut placed: Vec<f64>,
        balanced: &[usize],
        amplitudes: &[f64],
    ) -> Vec<f64> {
        for (&k, amplitude) in balanced.iter().zip(amplitudes) {
            let motion = &self.motions[k].motion;
            let by = motion.tangential_x.iter().chain(&motion.tangential_y);
            for (placed, by) in placed.iter_mut().zip(by) {
                *placed += amplitude * by;
            }
        }
        placed
    }

    /// Displacement `u_lower - u_upper` along both tangents (2n) [m] of the bodies by tractions along these and pressures
    /// (3n) [Pa] and, of a magnet that follows the gap, by its pull (n) [Pa].
    ///
    /// # Errors
    /// Wrong lengths; [`Error::NoTangents`] of a contact whose file had none; more points than the memory holds;
    /// [`Error::Interrupted`].
    pub fn slid_by(
        &self,
        traction: &[f64],
        pull: Option<&[f64]>,
        monitor: Monitor<'_>,
    ) -> Result<Vec<f64>, Error> {
        let n = self.geometry.points();
        check("traction", traction, 3 * n)?;
        let bodies = self.bodies.as_ref().ok_or(Error::NoTangents)?;
        let mut moved = bodies.pair.get(monitor)?.displacement(traction);
        moved.truncate(2 * n);
        if let Some(pull) = pull {
            check("pull", pull, n)?;
            if let Some(face) = &bodies.pulled {
                face.get(monitor)?.add(-1.0, pull, &mut moved);
            }
        }
        Ok(moved)
    }

    /// How many numbers [`PreparedContact::memory`] has.
    pub fn memory_size(&self) -> usize {
        let fields = if self.magnet.is_some() { 6 } else { 5 };
        fields * self.geometry.points() + self.motions.len()
    }

    /// Displacement along both tangents (2n) [m] by a shift along x and y.
    pub(super) fn shifted(&self, [x, y]: [f64; 2]) -> Vec<f64> {
        self.tangential(&self.geometry.uniform([x, y, 0.0]), 1.0)
    }
}

impl PreparedContact {
    /// Takes tractions along both tangents and pressures (3n) [Pa], the amplitudes of motions, and the displacement `rigid`
    /// (2n) [m] of [`Outcome::rigid`] for those of the last step, where a step with a shift starts from.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite.
    pub fn remember(
        &mut self,
        traction: &[f64],
        motion: &[f64],
        rigid: &[f64],
    ) -> Result<(), Error> {
        let n = self.prepared.geometry.points();
        check("state", traction, 3 * n)?;
        check("state", rigid, 2 * n)?;
        for values in [traction, motion, rigid] {
            check_size("state", values)?;
        }
        self.past = Some(Past {
            traction: traction.to_vec(),
            elastic: None,
            motion: motion.to_vec(),
            rigid: rigid.to_vec(),
            all_slipped: true,
        });
        Ok(())
    }

    /// What the next step with a shift starts from, as numbers for [`PreparedContact::recall`]: five for each point, six
    /// under a magnet whose pull follows the gap, and one for each motion. `None` before a step was solved, and of a contact
    /// whose tangents are not known.
    pub fn memory(&self) -> Option<Vec<f64>> {
        let past = self.past.as_ref()?;
        let mut memory = [&*past.traction, &past.rigid].concat();
        if self.prepared.magnet.is_some() {
            let unknown = vec![f64::NAN; self.prepared.geometry.points()];
            memory.extend(self.pull.as_ref().unwrap_or(&unknown));
        }
        memory.extend(&past.motion);
        // motions that the pose took the place of
        memory.resize(self.prepared.memory_size(), f64::NAN);
        Some(memory)
    }

    /// Takes a memory for what the last step left behind, pressures and motions too.
    ///
    /// # Errors
    /// A wrong length, numbers that are not finite, pressures below 0.
    pub fn recall(&mut self, memory: &[f64]) -> Result<(), Error> {
        let expected = self.prepared.memory_size();
        if memory.len() != expected {
            return Err(Error::Shape {
                name: "memory",
                expected,
                found: memory.len(),
            });
        }
        let n = self.prepared.geometry.points();
        let (traction, rest) = memory.split_at(3 * n);
        let (rigid, rest) = rest.split_at(2 * n);
        let (pull, motion) = rest.split_at(if self.prepared.magnet.is_some() { n } else { 0 });
        let motion: Vec<f64> = (motion.iter().copied()).filter(|a| !a.is_nan()).collect();
        let is_known = pull.iter().any(|p| !p.is_nan());
        self.resume(&traction[2 * n..], &motion, is_known.then_some(pull))?;
        self.remember(traction, &motion, rigid)
    }

    /// From where a shift leads, and how far.
    pub(super) fn way(
        &self,
        shift: [f64; 2],
        friction: &[f64],
        placed: &[f64],
        monitor: Monitor<'_>,
    ) -> Result<Way, Error> {
        let prepared = &*self.prepared;
        if !prepared.interface.is_empty() {
            return Err(Error::NoInterfaceInShift);
        }
        let bodies = prepared.bodies.as_ref().ok_or(Error::NoTangents)?;
        let matrix = bodies.pair.get(monitor)?;
        let before = self.past.clone().map(|past| {
            let known = past.elastic;
            let elastic = known.unwrap_or_else(|| matrix.displacement(&past.traction));
            let all = elastic.iter().zip(&past.rigid).map(|(e, r)| e + r);
            Before {
                all: all.collect(),
                traction: past.traction,
                motion: past.motion,
                elastic,
                all_slipped: past.all_slipped,
            }
        });
        Ok(Way {
            matrix,
            friction: friction.to_vec(),
            shift: prepared.shifted(shift),
            placed: placed.to_vec(),
            before,
        })
    }

    /// The state at the end of a way under a loading, with some of the motions found from balance.
    pub(super) fn stick_or_slip(
        &mut self,
        loading: &Loading,
        balanced: &[usize],
        way: &Way,
        monitor: Monitor<'_>,
    ) -> Result<Outcome, Error> {
        let prepared = self.prepared.clone();
        let n = prepared.geometry.points();
        let motions = prepared.balanced(balanced, &loading.work);
        let placed: Vec<f64> = (way.placed.iter().zip(&loading.along))
            .map(|(placed, along)| placed + along)
            .collect();
        let load = CoupledLoad {
            area: &prepared.geometry.area,
            friction: &way.friction,
            gap: &loading.gap,
            motions: &motions,
            diagonal: loading.diagonal.as_deref(),
        };
        if let Some(before) = &way.before
            && (way.is_frictionless() || before.all_slipped && way.may_follow(before))
            && let Some(found) =
                self.all_slip(loading, balanced, way, &placed, &before.all, monitor)?
        {
            return Ok(found);
        }
        let kept = &mut self.inverse;
        let contact = CoupledContact::again(way.matrix.clone(), &load, TOLERANCE, kept)?;
        let (mut state, old) = if let Some(before) = &way.before {
            let known = contact.state_before(&before.traction, &before.elastic, &before.motion);
            (known, before.all.clone())
        } else {
            let smooth = (vec![0.0; n], vec![0.0; 2 * n]);
            let pressed = self.solve(loading, balanced, &smooth, monitor)?;
            if pressed.solution.status != Status::Solved {
                return Ok(pressed);
            }
            let solution = &pressed.solution;
            let rest = contact.at_rest(&solution.pressure, &solution.motion)?;
            let moved = rest.displacement.iter().zip(&placed);
            let old: Vec<f64> = moved.map(|(v, placed)| v + placed).collect();
            if let Some(found) = self.all_slip(loading, balanced, way, &placed, &old, monitor)? {
                return Ok(found);
            }
            (rest, old)
        };
        // from where slip counts, less what pose and loads do: the same at the end of the step
        let remember = |state: &mut CoupledState| {
            for ((v, old), placed) in state.displacement.iter_mut().zip(&old).zip(&placed) {
                *v = old - placed;
            }
        };
        remember(&mut state);
        let push = [&*way.shift, &vec![0.0; n]].concat();
        let mut found = contact.at_once(&state, &push, &mut self.inverse, monitor)?;
        let mut status = Status::Solved;
        if found.is_none() {
            // far from the last step: from states that all points slide to, along the shift or the slip without friction, or
            // over the states between; then from this one, also as friction grows. Where nothing presses no traction is
            // left to be found
            let smooth = (vec![0.0; n], vec![0.0; 2 * n]);
            let mut pressed = self.solve(loading, balanced, &smooth, monitor)?;
            let solution = &pressed.solution;
            if solution.status != Status::Solved {
                return Ok(pressed);
            }
            if solution.pressure.iter().all(|p| *p == 0.0) {
                pressed.elastic = Some(vec![0.0; 3 * n]);
                prepared.slipped(vec![0.0; 2 * n], 0.0, &mut pressed);
                return Ok(pressed);
            }
            let mut rest = contact.at_rest(&solution.pressure, &solution.motion)?;
            let there = rest.displacement.clone();
            remember(&mut rest);
            let slip: Vec<f64> = (0..2 * n)
                .map(|k| way.shift[k] - (there[k] - rest.displacement[k]))
                .collect();
            let mut starts = Vec::new();
            for way_there in [&way.shift, &slip] {
                let Some(direction) = directions(way_there, |_| true) else {
                    continue;
                };
                let rubbing = (way.friction.clone(), direction);
                let sliding = self.solve(loading, balanced, &rubbing, monitor)?;
                let solution = &sliding.solution;
                status = solution.status;
                if status == Status::Solved {
                    let traction = [&*sliding.traction, &solution.pressure].concat();
                    let elastic = self.inverse.displacement(&way.matrix, &traction);
                    let mut start = contact.state_before(&traction, &elastic, &solution.motion);
                    remember(&mut start);
                    found = contact.at_once(&start, &push, &mut self.inverse, monitor)?;
                    starts.push(start);
                }
                if found.is_some() {
                    break;
                }
            }
            for start in [&state].into_iter().chain(&starts) {
                if found.is_none() {
                    found = contact.reach(start, &push, &mut self.inverse, monitor)?;
                }
            }
            if found.is_none() {
                found = contact.rub(&rest, &push, &mut self.inverse, monitor)?;
            }
            if found.is_none() {
                found = contact.step(&rest, &push, &mut self.inverse, monitor)?;
            }
        }
        let turns = |found: &CoupledState| {
            let amplitudes = contact.amplitudes(found);
            balanced.iter().zip(amplitudes).any(|(&k, amplitude)| {
                let component = prepared.motions[k].component;
                component.is_some_and(|c| c > 2) && amplitude.abs() > STEEPEST
            })
        };
        let (status, found) = match found {
            // it rolls over an edge that sticks
            Some(found) if turns(&found) => (Status::Unreachable, found),
            Some(found) => (Status::Solved, found),
            // sliding tells why
            None if status != Status::Solved => (status, state),
            None => (Status::IterationLimit, state),
        };
        let g = &prepared.geometry;
        let about = prepared.reference_point;
        let mut outcome = Outcome::coupled(g, about, status, &contact, &found, &way.friction);
        outcome.elastic = Some(contact.elastic(&found));
        let slip = (0..2 * n)
            .map(|k| way.shift[k] - (found.displacement[k] + placed[k] - old[k]))
            .collect();
        let size = old
            .iter()
            .chain(&way.shift)
            .fold(0.0_f64, |m, v| m.max(v.abs()));
        prepared.slipped(slip, ROUNDING * size, &mut outcome);
        // sliding steps start from here
        self.stepper
            .resume(&outcome.solution.pressure, &outcome.solution.motion)?;
        Ok(outcome)
    }

    /// The state in which all points slip; `None` if some do not, or none is found.
    fn all_slip(
        &mut self,
        loading: &Loading,
        balanced: &[usize],
        way: &Way,
        placed: &[f64],
        old: &[f64],
        monitor: Monitor<'_>,
    ) -> Result<Option<Outcome>, Error> {
        let prepared = self.prepared.clone();
        let n = prepared.geometry.points();
        let direction = if way.is_frictionless() {
            vec![0.0; 2 * n]
        } else {
            let Some(direction) = directions(&way.shift, |_| true) else {
                return Ok(None);
            };
            direction
        };
        let mut rubbing = (way.friction.clone(), direction);
        let mut before = f64::INFINITY;
        for round in 1..=ROUNDS {
            let mut outcome = self.solve(loading, balanced, &rubbing, monitor)?;
            if outcome.solution.status != Status::Solved {
                return Ok(None);
            }
            let pressure = &outcome.solution.pressure;
            let traction = [&*outcome.traction, pressure].concat();
            let rigid = prepared.rigid(placed.to_vec(), balanced, &outcome.solution.motion);
            let elastic = self.inverse.displacement(&way.matrix, &traction);
            let slip: Vec<f64> = (0..2 * n)
                .map(|k| way.shift[k] - (elastic[k] + rigid[k] - old[k]))
                .collect();
            let rubs = |i: usize| pressure[i] * way.friction[i] > 0.0;
            let Some(mut new) = directions(&slip, rubs) else {
                return Ok(None);
            };
            let (mut turned, mut size) = (0.0, 0.0);
            for i in 0..n {
                size += pressure[i] * pressure[i];
                if rubs(i) {
                    let [x, y] = [i, n + i].map(|k| new[k] - rubbing.1[k]);
                    if x.hypot(y) > 1.0 {
                        return Ok(None);
                    }
                    turned += (pressure[i] * way.friction[i]).powi(2) * (x * x + y * y);
                } else {
                    for k in [i, n + i] {
                        new[k] = rubbing.1[k];
                    }
                }
            }
            if turned <= TOLERANCE * TOLERANCE * size {
                outcome.elastic = Some(elastic);
                prepared.slipped(slip, 0.0, &mut outcome);
                return Ok(Some(outcome));
            }
            let left: f64 = turned / before;
            if round > 1
                && turned * left.powi((ROUNDS - round) as i32) > (TOLERANCE * DOUBT).powi(2) * size
            {
                return Ok(None);
            }
            before = turned;
            rubbing.1 = new;
        }
        Ok(None)
    }
}

impl Prepared {
    /// Adds how points slip that are displaced so far over the lower body (2n) [m]. Those that go no further than `least`
    /// stick.
    fn slipped(&self, mut slip: Vec<f64>, least: f64, outcome: &mut Outcome) {
        let n = self.geometry.points();
        let mut work = 0.0;
        for (i, area) in self.geometry.area.iter().enumerate() {
            let [x, y] = [slip[i], slip[n + i]];
            let point = &mut outcome.points[i];
            if *point == PointState::Slip && x.hypot(y) <= least {
                *point = PointState::Stick;
            }
            match point {
                PointState::Stick => {
                    slip[i] = 0.0;
                    slip[n + i] = 0.0;
                }
                PointState::Open => {}
                PointState::Slip => {
                    work += area * (outcome.traction[i] * x + outcome.traction[n + i] * y);
                }
            }
        }
        outcome.slipped = Some(Slipped { slip, work });
    }
}

/// Unit vectors (2n) along `vectors` (2n), zeros where they do not count; `None` if one that counts is zero.
fn directions(vectors: &[f64], counts: impl Fn(usize) -> bool) -> Option<Vec<f64>> {
    let n = vectors.len() / 2;
    let mut units = vec![0.0; 2 * n];
    for i in (0..n).filter(|&i| counts(i)) {
        let [x, y] = [vectors[i], vectors[n + i]];
        let length = x.hypot(y);
        if length == 0.0 {
            return None;
        }
        units[i] = x / length;
        units[n + i] = y / length;
    }
    Some(units)
}

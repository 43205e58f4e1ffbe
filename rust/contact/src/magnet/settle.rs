// SPDX-License-Identifier: MIT OR Apache-2.0
//! States in which gaps and pull fit each other.

use std::collections::VecDeque;

use mtb_complementarity::linear::Status;

use super::Circuit;
use crate::columns::largest;
use crate::error::Error;
use crate::problem::{Attracted, Heated, Loading, Outcome};

/// Change of the pull, in parts of the largest, that counts as none.
const SETTLED: f64 = 1e-10;
/// Solves after which a pull must have settled.
const SOLVES: usize = 400;
/// Last changes that a secant is laid through.
const SECANTS: usize = 6;
/// Share of a change that is not one of the others, below which it tells nothing new.
const INDEPENDENT: f64 = 1e-8;
/// Largest step in parts of the change that the gaps ask for.
const LONGEST: f64 = 100.0;
/// Change of the pull by which it is told how much the gaps answer, in parts of it, and to which share that is known.
const PROBE: f64 = 1e-5;
const KNOWN: f64 = 1e-3;
const PROBES: usize = 12;

/// A magnet on bodies of a problem, at a speed.
#[derive(Clone, Copy, Debug)]
pub struct Magnet<'a> {
    /// Coil, poles and iron.
    pub circuit: &'a Circuit,
    /// The bodies that it pulls.
    pub bodies: &'a [Attracted],
    /// Factor of the speed on its pressure.
    pub factor: f64,
}

impl Circuit {
    /// The pull (n) [Pa] from which a state is looked for: `from`, or that at the gap of the loading.
    pub(crate) fn first_pull(
        &self,
        factor: f64,
        loading: &Loading,
        from: Option<Vec<f64>>,
    ) -> Result<Vec<f64>, Error> {
        match from {
            Some(pull) => Ok(pull),
            None => Ok(self.attract(&loading.gap, factor)?.pressure),
        }
    }
}

/// The pull of a state, and how it was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Settled {
    /// Pressure of the magnet at the points (n) [Pa].
    pub pull: Vec<f64>,
    /// Flux through the poles [Wb].
    pub flux: f64,
    /// Magnetomotive force of each pole [A].
    pub forces: Vec<f64>,
    /// States that were solved.
    pub solves: usize,
    /// What the pull at the gaps of the state differs by from the pull in it, in parts of the largest.
    pub residual: f64,
    /// How much of a small change of the pull comes back by the gaps that it changes, where that was asked for:
    /// [`snap_share`].
    pub share: Option<f64>,
}

/// What holds the state of a contact under a pull.
pub trait Settling {
    /// The state.
    fn outcome(&mut self) -> &mut Outcome;
}

impl Settling for Outcome {
    fn outcome(&mut self) -> &mut Outcome {
        self
    }
}

impl Settling for Heated {
    fn outcome(&mut self) -> &mut Outcome {
        &mut self.outcome
    }
}

/// Finds a state whose gaps give the pull of a magnet that it is under, at a `factor` of the speed; `solve` gives the state
/// under a pull (n) [Pa].
///
/// From `start` each pull is that at the gaps of the state before, with Newton's step along the last changes, whose
/// secants stand for the derivative. More pull closes gaps, and smaller gaps raise the pull. So from the pull of bodies
/// that are apart it rises to the first state there is, that of bodies which have not snapped together, and from that of
/// bodies which touch it falls to the last one.
///
/// # Errors
/// As `solve`. A state that was not found is a status of its outcome.
pub fn settle<S: Settling>(
    circuit: &Circuit,
    factor: f64,
    start: Vec<f64>,
    mut solve: impl FnMut(&[f64]) -> Result<S, Error>,
) -> Result<S, Error> {
    let most = circuit.limit() * factor;
    let mut pull = start;
    let mut secants = Secants::default();
    let mut plain: Option<Vec<f64>> = None;
    for solves in 1.. {
        let mut state = solve(&pull)?;
        let outcome = state.outcome();
        let is_solved = outcome.solution.status == Status::Solved;
        if !is_solved && let Some(plain) = plain.take() {
            // the step was too long
            secants = Secants::default();
            pull = plain;
            continue;
        }
        let found = circuit.attract(&outcome.solution.gap, factor)?;
        let change: Vec<f64> = (found.pressure.iter().zip(&pull))
            .map(|(f, p)| f - p)
            .collect();
        let size = largest(&found.pressure).max(largest(&pull));
        let residual = if size > 0.0 {
            largest(&change) / size
        } else {
            0.0
        };
        if !is_solved || residual <= SETTLED || solves == SOLVES {
            if is_solved && residual > SETTLED {
                outcome.solution.status = Status::IterationLimit;
                outcome.solution.residual = residual;
            }
            outcome.settled = Some(Settled {
                pull,
                flux: found.flux,
                forces: found.forces,
                solves,
                residual,
                share: None,
            });
            return Ok(state);
        }
        let step = secants.step(&pull, &change);
        plain = step.is_some().then(|| found.pressure.clone());
        pull = match step {
            Some(step) => (pull.iter().zip(step))
                .map(|(p, s)| (p + s).clamp(0.0, most))
                .collect(),
            None => found.pressure,
        };
    }
    unreachable!("the solves end")
}

/// How much of a small change of the pull of a settled state comes back by the gaps that it changes: the stiffness of
/// the magnet in parts of that of what holds the bodies. From 1 on the state is not stable. Not a number where no state
/// is next to it.
///
/// # Errors
/// As `solve`.
pub fn snap_share<S: Settling>(
    magnet: &Magnet<'_>,
    state: &mut S,
    mut solve: impl FnMut(&[f64]) -> Result<S, Error>,
) -> Result<f64, Error> {
    let attract = |gap: &[f64]| magnet.circuit.attract(gap, magnet.factor);
    let outcome = state.outcome();
    let Some(settled) = &outcome.settled else {
        return Ok(f64::NAN);
    };
    let (pull, here) = (
        settled.pull.clone(),
        attract(&outcome.solution.gap)?.pressure,
    );
    let size = largest(&pull);
    if size == 0.0 {
        return Ok(0.0);
    }
    let step = PROBE * size;
    let mut share = 0.0;
    let mut way: Vec<f64> = pull.iter().map(|p| p / norm(&pull)).collect();
    for _ in 0..PROBES {
        let most = largest(&way);
        let probed: Vec<f64> = (pull.iter().zip(&way))
            .map(|(p, w)| p + step * w / most)
            .collect();
        let mut there = solve(&probed)?;
        let outcome = there.outcome();
        if outcome.solution.status != Status::Solved {
            return Ok(f64::NAN);
        }
        let answer = attract(&outcome.solution.gap)?.pressure;
        way = (answer.iter().zip(&here))
            .map(|(a, h)| (a - h) * most / step)
            .collect();
        let (before, now) = (share, norm(&way));
        share = now;
        if now == 0.0 || (now - before).abs() <= KNOWN * now {
            break;
        }
        for w in &mut way {
            *w /= now;
        }
    }
    Ok(share)
}

/// Changes of a pull, and of what its gaps ask for, from step to step.
#[derive(Default)]
struct Secants {
    last: Option<(Vec<f64>, Vec<f64>)>,
    kept: VecDeque<(Vec<f64>, Vec<f64>)>,
}

impl Secants {
    /// The step to where the secants through the last states ask for no change; none where they do not tell.
    fn step(&mut self, pull: &[f64], change: &[f64]) -> Option<Vec<f64>> {
        let minus =
            |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
        if let Some((before, asked)) = &self.last {
            if norm(change) > 2.0 * norm(asked) {
                self.kept.clear();
            } else {
                self.kept
                    .push_front((minus(change, asked), minus(pull, before)));
                self.kept.truncate(SECANTS);
            }
        }
        self.last = Some((pull.to_vec(), change.to_vec()));
        let mut bases: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
        for (answer, moved) in &self.kept {
            let (mut answer, mut moved, size) = (answer.clone(), moved.clone(), norm(answer));
            for (base, by) in &bases {
                let share = dot(base, &answer);
                subtract(&mut answer, share, base);
                subtract(&mut moved, share, by);
            }
            let rest = norm(&answer);
            if rest > INDEPENDENT * size {
                answer.iter_mut().chain(&mut moved).for_each(|v| *v /= rest);
                bases.push((answer, moved));
            }
        }
        if bases.is_empty() {
            return None;
        }
        let mut step = change.to_vec();
        for (base, by) in &bases {
            let share = dot(base, change);
            subtract(&mut step, share, base);
            subtract(&mut step, share, by);
        }
        let is_taken = dot(&step, change) > 0.0 && norm(&step) <= LONGEST * norm(change);
        if !is_taken {
            self.kept.clear();
        }
        is_taken.then_some(step)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

fn subtract(a: &mut [f64], share: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a -= share * b);
}

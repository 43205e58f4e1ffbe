// SPDX-License-Identifier: MIT OR Apache-2.0
//! The way to a state that Newton's method does not find at once.
//!
//! Any state solves a problem of its own: the gaps that it closes, the work that its tractions balance, the friction
//! coefficients that hold them, and no slip since. From there gaps, work, coefficients and slip go to those of the problem
//! in question in proportion, in shares that are as short as Newton's method needs. What is remembered stays that of the
//! state, so that the end of the way meets the very conditions that one step would have met.

use mtb_operator::Monitor;

use super::inverse::{KeptInverse, Quick};
use super::newton::{HIGHER, solve};
use super::{CoupledContact, CoupledState};
use crate::error::Error;

/// Shortest share of the way.
const SHORTEST: f64 = 1.0 / 1024.0;
/// Newton steps up to which the next share is twice as long.
const QUICK: usize = 8;

/// The problem that a state solves, at which a way begins.
struct Beginning {
    gap: Vec<f64>,
    work: Vec<f64>,
    friction: Vec<f64>,
    /// Displacement (2n) [m] along both tangents from which slip counts.
    slipped: Vec<f64>,
}

impl CoupledContact {
    /// The state at `push` (3n) [m] after `state`, reached over the states between; `None` where these end on the way.
    ///
    /// # Errors
    /// As [`CoupledContact::advance`].
    pub(crate) fn reach(
        &self,
        state: &CoupledState,
        push: &[f64],
        kept: &mut KeptInverse,
        monitor: Monitor<'_>,
    ) -> Result<Option<CoupledState>, Error> {
        let from = Beginning::of(self, state, push);
        let inverse = kept.for_contact(self, state.pressure(), monitor)?;
        self.along(&from, state, push, inverse, monitor)
    }

    /// The state at `push` (3n) [m] that friction leads to as it grows, from `rest`, the bodies pressed together without it;
    /// `None` if these states end before it has grown up.
    ///
    /// # Errors
    /// As [`CoupledContact::advance`].
    pub(crate) fn rub(
        &self,
        rest: &CoupledState,
        push: &[f64],
        kept: &mut KeptInverse,
        monitor: Monitor<'_>,
    ) -> Result<Option<CoupledState>, Error> {
        let n = self.points();
        let from = Beginning {
            gap: self.pushed(push),
            work: self.work.clone(),
            friction: vec![0.0; n],
            slipped: remembered(rest, push),
        };
        let inverse = kept.for_contact(self, rest.pressure(), monitor)?;
        self.along(&from, rest, push, inverse, monitor)
    }

    /// The state at the end of a way `from` another problem, which `state` solves.
    fn along(
        &self,
        from: &Beginning,
        state: &CoupledState,
        push: &[f64],
        mut inverse: Option<Quick<'_>>,
        monitor: Monitor<'_>,
    ) -> Result<Option<CoupledState>, Error> {
        let mut at = CoupledState {
            own: None,
            ..state.clone()
        };
        let (mut done, mut share, mut iterations) = (0.0, 0.5, 0);
        while done < 1.0 {
            let next = f64::min(done + share, 1.0);
            let quick = inverse.as_mut().map(Quick::again);
            let found = if next < 1.0 {
                let (contact, displacement) = self.between(from, state, push, next);
                let way = CoupledState {
                    displacement,
                    push: vec![0.0; push.len()],
                    ..at.clone()
                };
                solve(
                    &contact,
                    &way,
                    &vec![0.0; push.len()],
                    quick,
                    HIGHER,
                    monitor,
                )?
            } else {
                solve(self, &at, push, quick, HIGHER, monitor)?
            };
            if let Some((found, _)) = found {
                iterations += found.iterations;
                if found.iterations <= QUICK {
                    share *= 2.0;
                }
                if next == 1.0 {
                    return Ok(Some(CoupledState {
                        iterations,
                        ..found
                    }));
                }
                done = next;
                at.traction = found.traction;
                at.motion = found.motion;
                at.points = found.points;
            } else {
                share = 0.5 * share.min(1.0 - done);
                if share < SHORTEST {
                    break;
                }
            }
        }
        Ok(None)
    }

    /// The problem so far on the way to this one, and the displacement (3n) [m] from which slip counts there.
    fn between(
        &self,
        from: &Beginning,
        state: &CoupledState,
        push: &[f64],
        share: f64,
    ) -> (Self, Vec<f64>) {
        let n = self.points();
        let blend = |a: &[f64], b: &[f64]| -> Vec<f64> {
            let pairs = a.iter().zip(b);
            pairs.map(|(a, b)| a + share * (b - a)).collect()
        };
        let contact = Self {
            matrix: self.matrix.clone(),
            diagonal: self.diagonal.clone(),
            motions: self.motions.clone(),
            work: blend(&from.work, &self.work),
            reach: self.reach.clone(),
            units: self.units.clone(),
            shares: self.shares.clone(),
            area: self.area.clone(),
            friction: blend(&from.friction, &self.friction),
            gap: blend(&from.gap, &self.pushed(push)),
            tolerance: self.tolerance,
        };
        let mut displacement = blend(&from.slipped, &remembered(state, push));
        displacement.resize(3 * n, 0.0);
        (contact, displacement)
    }

    /// Gap (n) [m] by a push (3n) [m].
    fn pushed(&self, push: &[f64]) -> Vec<f64> {
        let normal = &push[2 * self.points()..];
        self.gap.iter().zip(normal).map(|(g, p)| g + p).collect()
    }
}

/// Displacement (2n) [m] along both tangents from which slip counts at `push` (3n) [m] after `state`.
fn remembered(state: &CoupledState, push: &[f64]) -> Vec<f64> {
    (0..push.len() / 3 * 2)
        .map(|i| state.displacement[i] + push[i] - state.push[i])
        .collect()
}

impl Beginning {
    /// What `state` solves; open points stay open.
    fn of(contact: &CoupledContact, state: &CoupledState, push: &[f64]) -> Self {
        let n = contact.points();
        let (traction, pressure) = state.traction.split_at(2 * n);
        let mut own = match &state.own {
            Some(own) => own.clone(),
            None => contact.displacement(&state.traction, &state.motion),
        };
        let gap = (0..n)
            .map(|i| {
                let closed = -own[2 * n + i];
                if pressure[i] > 0.0 {
                    closed
                } else {
                    closed.max(contact.gap[i] + push[2 * n + i])
                }
            })
            .collect();
        own.truncate(2 * n);
        let work = (0..contact.work.len())
            .map(|k| {
                let shape = contact.motions.col_as_slice(k).iter().zip(&state.traction);
                let parts = shape.enumerate();
                -parts
                    .map(|(i, (m, t))| m * contact.area[i % n] * t)
                    .sum::<f64>()
            })
            .collect();
        let friction = (0..n)
            .map(|i| {
                let given = contact.friction[i];
                if pressure[i] > 0.0 {
                    given.max(traction[i].hypot(traction[n + i]) / pressure[i])
                } else {
                    given
                }
            })
            .collect();
        Self {
            gap,
            work,
            friction,
            slipped: own,
        }
    }
}

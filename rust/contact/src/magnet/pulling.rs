// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a change of the pull of a magnet does to a contact, and what the contact does to the pull.

use std::fmt;
use std::sync::Arc;

use mtb_operator::krylov::{dot, gmres};
use mtb_operator::{Compliance, Component, Monitor, report};

use super::face::Face;
use super::linear::Slopes;
use super::settle::Magnet;
use crate::error::{Error, check};
use crate::problem::Problem;

/// Part of the right-hand side to which changes of the pull are found, and the part at which they count as found.
const SOLVED: f64 = 1e-13;
const ENOUGH: f64 = 1e-9;
/// Answers of the contact that one solve takes at most.
const ANSWERS: usize = 300;

/// A magnet on a contact, linearised about a state.
///
/// A change `dm` of the pull changes gaps before contact and work on the free motions; the contact answers with a
/// change of its gaps, and the magnet to these with `S dg`. So `(1 - S H) dm` is what the magnet changes by itself.
#[derive(Clone)]
pub struct Pulling {
    slopes: Slopes,
    /// The bodies whose surface the pull moves.
    faces: Vec<Arc<dyn Compliance>>,
    /// Work [J/Pa] on each motion (m) of a unit of pull at each point (n).
    works: Vec<Vec<f64>>,
}

impl fmt::Debug for Pulling {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pulling").finish_non_exhaustive()
    }
}

impl Pulling {
    /// A `magnet` on the bodies of a problem over gaps (n) [m]; of the motions those count that are `free`.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite.
    pub fn new(
        problem: &Problem,
        magnet: &Magnet<'_>,
        gap: &[f64],
        free: &[usize],
    ) -> Result<Self, Error> {
        check("gap", gap, problem.points())?;
        let slopes = magnet.circuit.slopes(gap, magnet.factor)?;
        let faces = magnet.bodies.iter().filter(|pulled| pulled.at_face);
        let works = problem.works_of_pull(magnet.bodies);
        Ok(Self {
            slopes,
            faces: faces
                .filter_map(|pulled| problem.body(pulled.body).cloned())
                .collect(),
            works: free.iter().map(|&k| works[k].clone()).collect(),
        })
    }

    /// A magnet linearised by `slopes` whose pull moves a face, and works (m) [J/Pa] on each motion by a unit at each point.
    pub(crate) fn of(slopes: Slopes, face: Option<Arc<Face>>, works: Vec<Vec<f64>>) -> Self {
        let faces = face.into_iter().map(|face| face as Arc<dyn Compliance>);
        Self {
            slopes,
            faces: faces.collect(),
            works,
        }
    }

    /// How the pull changes with gaps and with the magnet.
    pub fn slopes(&self) -> &Slopes {
        &self.slopes
    }

    /// Gap before contact (n) and work on each motion (m) by a pull (n).
    pub(crate) fn loads(&self, pull: &[f64]) -> [Vec<f64>; 2] {
        let mut gap = vec![0.0; pull.len()];
        for face in &self.faces {
            face.add_displacement(Component::Normal, Component::Normal, -1.0, pull, &mut gap);
        }
        [gap, self.works.iter().map(|work| dot(work, pull)).collect()]
    }

    /// The transposed map: weights (n) of the pull that do what weights of gap (n) and work (m) do.
    pub(crate) fn weights(&self, gap: &[f64], work: &[f64]) -> Vec<f64> {
        let mut pull = vec![0.0; gap.len()];
        for face in &self.faces {
            face.add_transposed(Component::Normal, Component::Normal, -1.0, gap, &mut pull);
        }
        for (own, work) in self.works.iter().zip(work) {
            for (pull, own) in pull.iter_mut().zip(own) {
                *pull += work * own;
            }
        }
        pull
    }

    /// The pull (n) that is `given` and what comes back of it: `x = given + answer(x)`.
    ///
    /// # Errors
    /// Those of `answer`, an interruption; [`Error::Singular`] where nothing is next to the state, as where it snaps.
    pub(crate) fn returned(
        given: &[f64],
        mut answer: impl FnMut(&[f64]) -> Result<Vec<f64>, Error>,
        monitor: Monitor<'_>,
    ) -> Result<Vec<f64>, Error> {
        let size = dot(given, given).sqrt();
        if size == 0.0 {
            return Ok(given.to_vec());
        }
        let mut x = given.to_vec();
        let mut failed = None;
        let mut left = f64::INFINITY;
        // the second solve takes what rounding has left of the first one
        for round in 0..=2 {
            let back = answer(&x)?;
            let mut residual: Vec<f64> = (given.iter().zip(&back).zip(&x))
                .map(|((g, b), x)| g + b - x)
                .collect();
            left = dot(&residual, &residual).sqrt();
            if left <= SOLVED * size || round == 2 {
                break;
            }
            gmres(
                |v, out| {
                    let back = if failed.is_some() {
                        Err(Error::Interrupted)
                    } else {
                        let told = report(monitor, round, left / size);
                        told.map_err(Error::from).and_then(|()| answer(v))
                    };
                    match back {
                        Ok(back) => {
                            for ((out, v), back) in out.iter_mut().zip(v).zip(back) {
                                *out = v - back;
                            }
                        }
                        Err(error) => {
                            failed.get_or_insert(error);
                            out.fill(0.0);
                        }
                    }
                },
                |v, out| out.copy_from_slice(v),
                &mut x,
                &mut residual,
                SOLVED * size,
                ANSWERS,
            );
            if let Some(error) = failed.take() {
                return Err(error);
            }
        }
        if left.is_nan() || left > ENOUGH * size {
            return Err(Error::Singular);
        }
        Ok(x)
    }
}

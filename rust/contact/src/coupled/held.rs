// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stick and slip under a pressure that is held: the tractions alone are unknown.

use mtb_complementarity::discs::{DenseDiscProblem, DiscOptions, DiscState, solve_discs_dense};
use mtb_operator::{Compliance, Component, Monitor, check_factors};

use super::{PATH_TOLERANCE, PointState, refined};
use crate::error::{Error, check};

/// Newton steps for a part of a push.
const STEPS: usize = 200;

/// Matrices (n, n) that a solve holds: of both tangents, of the points in contact, and its factors.
const MATRICES: f64 = 13.0;

/// Two bodies whose pressure does not follow the tractions.
pub struct Held<'a> {
    /// Both bodies together; see [`Coupled`](super::Coupled).
    pub compliance: &'a dyn Compliance,
    /// Tangential displacement by a unit traction [m/Pa] of a layer between the bodies; 0: none.
    pub layer: f64,
    /// Area that belongs to each point (n) [m2].
    pub area: &'a [f64],
    /// Friction coefficient at each point (n).
    pub friction: &'a [f64],
    /// Pressure at each point (n) [Pa].
    pub pressure: &'a [f64],
}

/// A state under a pressure that is held.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldState {
    /// Tractions along both tangents on the lower body (2n) [Pa].
    pub traction: Vec<f64>,
    /// What each point does (n).
    pub points: Vec<PointState>,
    /// Newton steps of all parts of the push.
    pub iterations: usize,
    /// As [`CoupledState::path_error`](super::CoupledState::path_error).
    pub path_error: f64,
}

impl Held<'_> {
    /// The states after the upper body was pushed from rest along the tangents to each of `pushes` [m] in turn. They
    /// end where no state was found.
    ///
    /// Each push is reached in parts, so many of them that it adds an error of at most [`PATH_TOLERANCE`], as in
    /// [`CoupledContact::follow`](super::CoupledContact::follow). A state is solved to the relative `tolerance`.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, negative friction or pressure, more points than the memory holds,
    /// [`Error::Interrupted`].
    pub fn follow(
        &self,
        pushes: &[[f64; 2]],
        tolerance: f64,
        monitor: Monitor<'_>,
    ) -> Result<Vec<HeldState>, Error> {
        let n = self.compliance.points();
        for (name, values) in [
            ("area", self.area),
            ("friction", self.friction),
            ("pressure", self.pressure),
        ] {
            check(name, values, n)?;
        }
        check("push", &pushes.concat(), 2 * pushes.len())?;
        let matrix = self.matrix(n)?;
        let radius: Vec<f64> = self
            .friction
            .iter()
            .zip(self.pressure)
            .map(|(m, p)| m * p)
            .collect();
        let bound: f64 = radius.iter().zip(self.area).map(|(r, a)| r * a).sum();
        let change = |one: &HeldState, other: &HeldState| {
            let moved = self.area.iter().enumerate().map(|(i, area)| {
                let [x, y] = [i, n + i].map(|k| one.traction[k] - other.traction[k]);
                area * x.hypot(y)
            });
            if bound > 0.0 {
                moved.sum::<f64>() / bound
            } else {
                0.0
            }
        };
        let mut path: Vec<HeldState> = Vec::new();
        let mut place = [0.0; 2];
        for push in pushes {
            let rest = vec![0.0; 2 * n];
            let (from, carried) = path
                .last()
                .map_or((&rest, 0.0), |s| (&s.traction, s.path_error));
            let way = [push[0] - place[0], push[1] - place[1]];
            let advance = |parts: usize| {
                self.in_parts(&matrix, &radius, from, way, parts, tolerance, monitor)
            };
            let Some((mut found, error)) = refined(PATH_TOLERANCE, advance, change)? else {
                break;
            };
            found.path_error = carried + error;
            path.push(found);
            place = *push;
        }
        Ok(path)
    }

    /// Displacement by tractions along both tangents, row-major (2n, 2n), first components first.
    fn matrix(&self, n: usize) -> Result<Vec<f64>, Error> {
        const AXES: [Component; 2] = [Component::X, Component::Y];
        let memory = 8.0 * MATRICES * (n as f64).powi(2);
        check_factors(n, memory + self.compliance.influence_memory())?;
        let mut matrix = vec![0.0; 4 * n * n];
        let mut block = vec![0.0; n * n];
        for (i, observed) in AXES.into_iter().enumerate() {
            for (j, loaded) in AXES.into_iter().enumerate() {
                block.fill(0.0);
                self.compliance
                    .add_influence(observed, loaded, 1.0, &mut block);
                for (row, values) in block.chunks_exact(n.max(1)).enumerate() {
                    let first = (i * n + row) * 2 * n + j * n;
                    matrix[first..first + n].copy_from_slice(values);
                }
            }
        }
        for own in matrix.iter_mut().step_by(2 * n + 1) {
            *own += self.layer;
        }
        Ok(matrix)
    }

    /// The state after a push by `way` from the tractions `from`, in so many equal parts; `None` if there is none.
    #[allow(clippy::too_many_arguments, reason = "what is the same for all parts")]
    fn in_parts(
        &self,
        matrix: &[f64],
        radius: &[f64],
        from: &[f64],
        way: [f64; 2],
        parts: usize,
        tolerance: f64,
        monitor: Monitor<'_>,
    ) -> Result<Option<HeldState>, Error> {
        let n = radius.len();
        let (mut traction, mut iterations) = (from.to_vec(), 0);
        let mut points = Vec::new();
        for _ in 0..parts {
            let rows = matrix.chunks_exact((2 * n).max(1)).enumerate();
            let offset: Vec<f64> = rows
                .map(|(k, row)| {
                    let before: f64 = row.iter().zip(&traction).map(|(a, q)| a * q).sum();
                    -way[k / n] / parts as f64 - before
                })
                .collect();
            let problem = DenseDiscProblem {
                matrix,
                offset: &offset,
                radius,
                resultants: &[],
            };
            let options = DiscOptions {
                tolerance,
                max_iterations: STEPS,
            };
            let found = solve_discs_dense(&problem, None, options, monitor)?;
            if !found.converged {
                return Ok(None);
            }
            iterations += found.iterations;
            let states = found.state.iter().enumerate();
            points = states
                .map(|(i, state)| match state {
                    DiscState::Inside => PointState::Stick,
                    DiscState::Excluded if self.pressure[i] <= 0.0 => PointState::Open,
                    // without friction there is no disc: the point slips if anything moves it
                    DiscState::Excluded if found.image[i] == 0.0 && found.image[n + i] == 0.0 => {
                        PointState::Stick
                    }
                    DiscState::Excluded | DiscState::Rim => PointState::Slip,
                })
                .collect();
            traction = found.field;
        }
        Ok(Some(HeldState {
            traction,
            points,
            iterations,
            path_error: f64::INFINITY,
        }))
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_complementarity::linear::Status;
use mtb_words::{Rough, Short};

use super::Geometry;
use crate::coupled::{CoupledContact, CoupledState, PointState};
use crate::error::Error;
use crate::magnet::Settled;
use crate::sliding::SlidingSolution;
use crate::stepping::Effort;

/// A state of two bodies in contact, and what it took to find it.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Pressure, gap, motions, and how the search ended; only [`Status::Solved`] is a solution.
    pub solution: SlidingSolution,
    /// Friction coefficient at each point (n).
    pub friction: Vec<f64>,
    /// Tractions along both tangents on the lower body (2n) [Pa].
    pub traction: Vec<f64>,
    /// What each point does (n).
    pub points: Vec<PointState>,
    /// Force on the lower body [N].
    pub force: [f64; 3],
    /// Moment of it about the reference point [N m].
    pub moment: [f64; 3],
    /// Heat of sliding [W]: the friction times the sliding velocity, where one is given; the work of the
    /// pressures is not in it.
    pub friction_power: f64,
    /// Estimated error of the tractions by the finite steps of the way here, as
    /// [`CoupledState::path_error`]; 0 for a state without a past.
    pub path_error: f64,
    /// Of a step with a shift, how it stuck and slipped.
    pub slipped: Option<Slipped>,
    /// Tangential displacement `u_lower - u_upper` by rigid motions, pose and loads (2n) [m], which the next step with a shift
    /// starts from; of a step alone.
    pub rigid: Option<Vec<f64>>,
    /// Displacement of the bodies by their tractions (3n) [m], where it is known.
    pub(crate) elastic: Option<Vec<f64>>,
    /// The magnetic pressure [Pa] that a step was given in place of the scene's.
    pub magnetic_pressure: Option<f64>,
    /// The pull of a magnet that follows the gap, where one acts.
    pub settled: Option<Settled>,
    /// What it took.
    pub effort: Effort,
}

/// How far points slipped in a step.
#[derive(Clone, Debug, PartialEq)]
pub struct Slipped {
    /// Slip of the upper body over the lower one along both tangents (2n) [m]; zero where points stick, and at open points
    /// how far they went past each other.
    pub slip: Vec<f64>,
    /// Work of the friction on it [J].
    pub work: f64,
}

impl Outcome {
    /// A solution in which every point in contact slides in `direction` (2n), with friction coefficients that the shear
    /// limit of a layer has lowered; moments about `about` [m].
    pub(crate) fn sliding(
        geometry: &Geometry,
        about: [f64; 3],
        solution: SlidingSolution,
        friction: Vec<f64>,
        direction: &[f64],
    ) -> Self {
        let n = geometry.points();
        let traction: Vec<f64> = direction
            .iter()
            .enumerate()
            .map(|(i, d)| friction[i % n] * solution.pressure[i % n] * d)
            .collect();
        let points = (0..n)
            .map(|i| match solution.pressure[i] > 0.0 {
                false => PointState::Open,
                // without friction nothing tells that a point slides
                true if traction[i] == 0.0 && traction[n + i] == 0.0 => PointState::Stick,
                true => PointState::Slip,
            })
            .collect();
        let effort = Effort {
            sets: solution.iterations,
            fell_back: solution.by_lemke,
            ..Effort::default()
        };
        Self::of(
            geometry, about, solution, friction, traction, points, effort,
        )
    }

    /// A state of stick and slip, or the last one before none was found; moments about `about` [m].
    pub(crate) fn coupled(
        geometry: &Geometry,
        about: [f64; 3],
        status: Status,
        contact: &CoupledContact,
        state: &CoupledState,
        friction: &[f64],
    ) -> Self {
        let n = geometry.points();
        let solution = SlidingSolution {
            status,
            pressure: state.pressure().to_vec(),
            gap: contact.gap(state),
            motion: contact.amplitudes(state),
            iterations: state.iterations,
            residual: state.residual,
            by_lemke: false,
            unstable: false,
        };
        let effort = Effort {
            sets: state.iterations,
            factorisations: state.iterations,
            ..Effort::default()
        };
        let outcome = Self::of(
            geometry,
            about,
            solution,
            friction.to_vec(),
            state.traction[..2 * n].to_vec(),
            state.points.clone(),
            effort,
        );
        Self {
            path_error: state.path_error,
            ..outcome
        }
    }

    fn of(
        geometry: &Geometry,
        about: [f64; 3],
        solution: SlidingSolution,
        friction: Vec<f64>,
        traction: Vec<f64>,
        points: Vec<PointState>,
        effort: Effort,
    ) -> Self {
        let (force, moment) = geometry.resultants(&traction, &solution.pressure, about);
        Self {
            solution,
            friction,
            traction,
            points,
            force,
            moment,
            friction_power: 0.0,
            path_error: 0.0,
            slipped: None,
            rigid: None,
            elastic: None,
            magnetic_pressure: None,
            settled: None,
            effort,
        }
    }

    /// The points in contact, from which a further load may start.
    pub fn in_contact(&self) -> Vec<bool> {
        self.solution.pressure.iter().map(|p| *p > 0.0).collect()
    }

    /// Mean tractions (3n) [Pa] over each point: along both tangents on the lower body, and pressure.
    pub fn mean_tractions(&self, geometry: &Geometry) -> Vec<f64> {
        geometry.mean_tractions(&[&*self.traction, &self.solution.pressure].concat())
    }

    /// Why this is no solution, if it is none.
    pub fn unsolved(&self) -> Option<String> {
        match self.solution.status {
            Status::Solved => None,
            Status::NoSolution => Some("no sliding equilibrium: the body wedges".to_owned()),
            Status::Unreachable => {
                let outside = "the resultant of the load lies outside what the contact can carry";
                let negative = self.magnetic_pressure.filter(|p| *p < 0.0).map(|p| {
                    format!(
                        ": magnetic_pressure is {} Pa, and a negative one pushes the bodies apart",
                        Short(p)
                    )
                });
                Some(format!("{outside}{}", negative.unwrap_or_default()))
            }
            Status::Overloaded => Some(
                "the load is more than the contact bears at its hardness where it acts".to_owned(),
            ),
            Status::IterationLimit => Some(format!(
                "not converged (residual {})",
                Rough(self.solution.residual)
            )),
        }
    }

    /// Whether all numbers are finite.
    pub(crate) fn check(&self) -> Result<(), Error> {
        for (name, values) in [
            ("pressure", self.solution.pressure.as_slice()),
            ("gap", &self.solution.gap),
            ("motion", &self.solution.motion),
            ("force", &self.force),
            ("moment", &self.moment),
            ("friction power", &[self.friction_power]),
        ] {
            if let Some(&value) = values.iter().find(|v| !v.is_finite()) {
                return Err(Error::Overflow { name, value });
            }
        }
        Ok(())
    }
}

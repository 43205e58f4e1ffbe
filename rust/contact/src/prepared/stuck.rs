// SPDX-License-Identifier: MIT OR Apache-2.0
//! Steps in which points stick or slip, as their derivatives need them.

use std::sync::Arc;

use super::sticking::{TOLERANCE, Way};
use super::{OUTPUTS, Prepared, PreparedContact, Pull, Step};
use crate::coupled::{CoupledContact, CoupledLoad, StickGiven, StickPulling, StickSlip};
use crate::error::Error;
use crate::problem::{Loading, Outcome};

/// A step with a shift that was taken from a step before it.
pub struct StuckStep {
    prepared: Arc<Prepared>,
    equations: StickSlip,
    pose: [f64; 6],
    velocity: [f64; 2],
    /// Whether the loads are those of the scene, at the speed of the step, and whether they are given as a whole.
    is_scene: bool,
    is_given: bool,
    /// Change of the factor of a magnet with the speed [s/m].
    by_speed: f64,
    /// Whether friction is that of the tables.
    is_tabulated: bool,
    balanced: Vec<usize>,
    before: [Vec<f64>; 2],
    /// Tractions and slips along both tangents (2n) [Pa], [m].
    traction: Vec<f64>,
    slip: Vec<f64>,
}

/// Derivatives of the load, the work of friction [J], the largest mean pressure and the force of a magnet [N] (rows) by the
/// [inputs](StuckStep::inputs) (columns).
pub type StuckJacobian = [[f64; StuckStep::INPUTS]; OUTPUTS.len()];

impl StuckStep {
    /// What the [inputs](StuckStep::inputs) are, in their order: pose [m], [rad], shift [m], the velocity of the tables
    /// [m/s], uniform magnetic pressure [Pa], ampere-turns [A] of a magnet.
    pub const INPUTS: usize = 12;

    /// The equations linearised about the step.
    pub fn equations(&self) -> &StickSlip {
        &self.equations
    }

    /// Which of the prepared motions were found from balance.
    pub fn balanced(&self) -> &[usize] {
        &self.balanced
    }

    /// Tractions along both tangents and pressures (3n) [Pa] that the step started from, and the displacement along both
    /// tangents by rigid motions, pose and loads then (2n) [m].
    pub fn before(&self) -> &[Vec<f64>; 2] {
        &self.before
    }

    /// What a unit of pose (6), shift (2), velocity (2), uniform magnetic pressure (1) and ampere-turns (1) changes in what
    /// the step was given.
    pub fn inputs(&self) -> Vec<StickGiven> {
        let prepared = &*self.prepared;
        let (n, m) = (prepared.geometry.points(), self.balanced.len());
        let mut inputs = vec![StickGiven::nothing(n, m); Self::INPUTS];
        for (c, input) in inputs[..6].iter_mut().enumerate() {
            if let Some(moved) = prepared.moved_by(&self.pose, &self.balanced, c) {
                prepared.open(&moved, &mut input.gap);
                place(input, &prepared.tangential(&moved, -1.0), 1.0);
            }
        }
        for (input, along) in inputs[6..8].iter_mut().zip([[1.0, 0.0], [0.0, 1.0]]) {
            input.wanted = prepared.shifted(along);
        }
        let [x, y] = self.velocity;
        let speed = x.hypot(y);
        let slopes = self
            .equations
            .pulling()
            .map(|pulling| pulling.slopes().of_parameters());
        if let Some([by_ampere_turns, .., by_factor]) = slopes {
            inputs[11].pull.clone_from(by_ampere_turns);
            if speed > 0.0 {
                for (input, component) in inputs[8..10].iter_mut().zip([x / speed, y / speed]) {
                    let share = component * self.by_speed;
                    input.pull = by_factor.iter().map(|p| share * p).collect();
                }
            }
        }
        if speed > 0.0 {
            for (input, component) in inputs[8..10].iter_mut().zip([x / speed, y / speed]) {
                if self.is_tabulated {
                    let slope = prepared.friction.slope(speed);
                    input.friction = slope.iter().map(|mu| component * mu).collect();
                }
                if self.is_scene
                    && let Some(bodies) = &prepared.bodies
                {
                    self.load(input, &prepared.loads.slope(speed), component);
                    place(input, &bodies.loads.slope(speed), component);
                }
            }
        }
        let along = prepared.bodies.as_ref().and_then(|b| b.magnetic.as_ref());
        if let (false, None, Some([_, unit]), Some([_, along])) =
            (self.is_given, slopes, &prepared.magnetic, along)
        {
            self.load(&mut inputs[10], unit, 1.0);
            place(&mut inputs[10], along, 1.0);
        }
        inputs
    }

    /// Derivatives of force and moment on the lower body, of the work of friction on the slip, of the largest mean pressure,
    /// at the point where it is now, and of the force of a magnet.
    ///
    /// # Errors
    /// [`Error::Singular`].
    pub fn jacobian(&self) -> Result<StuckJacobian, Error> {
        let g = &self.prepared.geometry;
        let resultants = g.weights_of_resultants(self.prepared.reference_point);
        let peak = self.prepared.weights_of_peak(self.equations.pressure());
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let rubbed = |field: &[f64], change: &[f64]| {
            let products = field.iter().zip(change).zip(g.area.iter().cycle());
            products.map(|((a, b), area)| area * a * b).sum::<f64>()
        };
        let mut rows = [[0.0; Self::INPUTS]; OUTPUTS.len()];
        for (column, change) in self.equations.forward(&self.inputs())?.iter().enumerate() {
            let (along, pressed) = change.traction.split_at(2 * g.points());
            for (row, weights) in rows.iter_mut().zip(&resultants) {
                row[column] = dot(weights, &change.traction);
            }
            rows[6][column] = rubbed(&self.slip, along) + rubbed(&self.traction, &change.slip);
            rows[7][column] = dot(&peak, pressed);
            rows[8][column] = dot(&g.area, &change.pull);
        }
        Ok(rows)
    }

    /// Adds `share` of a row of loads: gap, then work on each motion.
    fn load(&self, input: &mut StickGiven, row: &[f64], share: f64) {
        let (gap, work) = row.split_at(self.prepared.geometry.points());
        for (to, gap) in input.gap.iter_mut().zip(gap) {
            *to += share * gap;
        }
        for (to, &k) in input.work.iter_mut().zip(&self.balanced) {
            *to += share * work[k];
        }
    }
}

/// Adds `share` of a displacement `u_lower - u_upper` along both tangents (2n): points slip by so much less.
fn place(input: &mut StickGiven, along: &[f64], share: f64) {
    for ((placed, wanted), along) in input.placed.iter_mut().zip(&mut input.wanted).zip(along) {
        *placed += share * along;
        *wanted -= share * along;
    }
}

impl PreparedContact {
    /// The last step, if it had a [shift](Step::shift), was solved, and was taken from a step before it.
    pub fn stuck(&self) -> Option<&Arc<StuckStep>> {
        self.stuck.as_ref()
    }

    /// A step with a shift from the last one, as its derivatives need it.
    pub(super) fn stuck_step(
        &mut self,
        step: &Step<'_>,
        loading: &Loading,
        balanced: &[usize],
        way: &Way,
        outcome: &Outcome,
        magnet: Option<(StickPulling, f64)>,
    ) -> Result<Option<Arc<StuckStep>>, Error> {
        let (Some(past), Some(slipped)) = (&self.past, &outcome.slipped) else {
            return Ok(None);
        };
        let before = [past.traction.clone(), past.rigid.clone()];
        let prepared = self.prepared.clone();
        let load = CoupledLoad {
            area: &prepared.geometry.area,
            friction: &way.friction,
            gap: &loading.gap,
            motions: &prepared.balanced(balanced, &loading.work),
            diagonal: loading.diagonal.as_deref(),
        };
        let contact =
            CoupledContact::again(way.matrix.clone(), &load, TOLERANCE, &mut self.inverse)?;
        let pressure = &outcome.solution.pressure;
        let (pulling, by_speed) = magnet.unzip();
        let equations = StickSlip::new(contact, pressure, &slipped.slip, &outcome.points);
        Ok(Some(Arc::new(StuckStep {
            equations: equations.with_magnet(pulling),
            by_speed: by_speed.unwrap_or(0.0),
            pose: step.pose,
            velocity: step.velocity,
            is_scene: matches!(step.pull, Pull::Scene),
            is_given: matches!(step.pull, Pull::Given(_)),
            is_tabulated: step.friction.is_none(),
            balanced: balanced.to_vec(),
            before,
            traction: outcome.traction.clone(),
            slip: slipped.slip.clone(),
            prepared: prepared.clone(),
        })))
    }
}

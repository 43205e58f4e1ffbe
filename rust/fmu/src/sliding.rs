// SPDX-License-Identifier: MIT OR Apache-2.0
use std::sync::Arc;

use mtb_contact::prepared::{
    INPUTS, OUTPUTS, Prepared, PreparedContact, Pull, Step, StuckJacobian,
};
use mtb_operator::unmonitored;

use crate::contact::Contact;
use crate::words;

/// A sliding contact; inputs and outputs are those of its derivatives, [`INPUTS`] and [`OUTPUTS`].
///
/// One whose file holds the compliance along the tangents sticks and slips: its steps displace the upper body by the
/// velocity times their duration.
pub(crate) struct Sliding {
    contact: PreparedContact,
    /// Of a contact that slides the pressures of the last step, then what the motions found from balance did; else
    /// [`PreparedContact::memory`].
    memory: Vec<f64>,
    /// Of the last step [s].
    duration: f64,
}

impl Sliding {
    pub(crate) fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let prepared = Prepared::from_bytes(bytes).map_err(words)?;
        Ok(Self {
            contact: PreparedContact::new(Arc::new(prepared)),
            memory: Vec::new(),
            duration: 0.0,
        })
    }

    fn sticks(&self) -> bool {
        self.contact.prepared().bodies.is_some()
    }
}

impl Contact for Sliding {
    fn inputs(&self) -> usize {
        INPUTS.len()
    }

    fn outputs(&self) -> usize {
        OUTPUTS.len()
    }

    fn default(&self, input: usize) -> f64 {
        if INPUTS[input].starts_with("velocity") {
            0.0
        } else {
            f64::NAN
        }
    }

    fn solve(&mut self, inputs: &[f64], duration: f64) -> Result<Vec<f64>, String> {
        let shift = [inputs[6] * duration, inputs[7] * duration];
        let step = Step {
            pose: std::array::from_fn(|k| inputs[k]),
            velocity: [inputs[6], inputs[7]],
            pull: match inputs[8] {
                p if p.is_nan() => Pull::Scene,
                p => Pull::Uniform(p),
            },
            gap: None,
            friction: None,
            diagonal: None,
            shift: self.sticks().then_some(shift),
        };
        let out = self.contact.step(&step, &unmonitored).map_err(words)?;
        if let Some(why) = out.unsolved() {
            return Err(why);
        }
        let geometry = &self.contact.prepared().geometry;
        let mean = geometry.mean_tractions(&out.solution.pressure);
        let peak = mean.iter().copied().fold(0.0, f64::max);
        let power = match &out.slipped {
            None => out.friction_power,
            Some(slipped) if duration > 0.0 => slipped.work / duration,
            Some(_) => 0.0,
        };
        let outputs = [out.force.as_slice(), &out.moment, &[power, peak]];
        self.memory = match self.contact.memory() {
            Some(memory) => memory,
            None => [out.solution.pressure, out.solution.motion].concat(),
        };
        self.duration = duration;
        Ok(outputs.concat())
    }

    fn follows_memory(&self) -> bool {
        self.sticks()
    }

    fn has_step(&self) -> bool {
        self.contact.taken().is_some() || self.contact.stuck().is_some()
    }

    fn derivatives(&mut self) -> Result<Vec<Vec<f64>>, String> {
        if let Some(stuck) = self.contact.stuck() {
            return Ok(by_velocity(
                &stuck.jacobian().map_err(words)?,
                self.duration,
            ));
        }
        let rows = self.contact.jacobian(&unmonitored).map_err(words)?;
        Ok(rows.map(|row| row.to_vec()).to_vec())
    }

    fn memory(&self) -> Vec<f64> {
        self.memory.clone()
    }

    fn resume(&mut self, memory: &[f64]) -> Result<(), String> {
        let prepared = self.contact.prepared().clone();
        let mut contact = PreparedContact::new(prepared.clone());
        if !memory.is_empty() {
            if self.sticks() {
                contact.recall(memory).map_err(words)?;
            } else {
                let (pressure, motion) = memory
                    .split_at_checked(prepared.geometry.points())
                    .ok_or("the memory has fewer numbers than the contact has points")?;
                contact.resume(pressure, motion, None).map_err(words)?;
            }
        }
        self.contact = contact;
        self.memory = memory.to_vec();
        Ok(())
    }

    fn forget(&mut self) {
        self.contact = PreparedContact::new(self.contact.prepared().clone());
        self.memory = Vec::new();
    }
}

/// Derivatives of the [`OUTPUTS`] by the [`INPUTS`] of a step in which the velocity displaces the body for a `duration` [s].
fn by_velocity(stuck: &StuckJacobian, duration: f64) -> Vec<Vec<f64>> {
    let rows = stuck.iter().enumerate().map(|(k, row)| {
        // of the work, where the output is a power
        let share = match OUTPUTS[k] {
            "friction_power" if duration > 0.0 => 1.0 / duration,
            "friction_power" => 0.0,
            _ => 1.0,
        };
        let velocity = [6, 7].map(|c| duration * row[c] + row[c + 2]);
        let whole = [&row[..6], &velocity, &row[10..]].concat();
        whole.iter().map(|d| share * d).collect()
    });
    rows.collect()
}

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
    /// Of a contact that slides the pressures of the last step, then the pull of a magnet that follows the gap, where there
    /// is one, then what the motions found from balance did; else
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

    /// How many numbers of the memory are the pull of a magnet that follows the gap.
    fn pulls(&self) -> usize {
        let prepared = self.contact.prepared();
        match prepared.magnet {
            Some(_) => prepared.geometry.points(),
            None => 0,
        }
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
            pull: match (inputs[8], inputs[9]) {
                (pressure, _) if !pressure.is_nan() => Pull::Uniform(pressure),
                (_, ampere_turns) if !ampere_turns.is_nan() => Pull::AmpereTurns(ampere_turns),
                _ => Pull::Scene,
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
        let attraction = match &out.settled {
            None => 0.0,
            Some(settled) => (settled.pull.iter().zip(&geometry.area))
                .map(|(p, area)| p * area)
                .sum(),
        };
        let outputs = [
            out.force.as_slice(),
            &out.moment,
            &[power, peak, attraction],
        ];
        self.memory = if let Some(memory) = self.contact.memory() {
            memory
        } else {
            let pull = self.contact.pull().unwrap_or_default();
            let unknown = vec![f64::NAN; self.pulls() - pull.len()];
            let solution = out.solution;
            [&*solution.pressure, pull, &unknown, &solution.motion].concat()
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
                let short = "the memory has fewer numbers than the contact has points";
                let (pressure, rest) =
                    (memory.split_at_checked(prepared.geometry.points())).ok_or(short)?;
                let (pull, motion) = rest.split_at_checked(self.pulls()).ok_or(short)?;
                let is_known = pull.iter().any(|p| !p.is_nan());
                let pull = is_known.then_some(pull);
                contact.resume(pressure, motion, pull).map_err(words)?;
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

// SPDX-License-Identifier: MIT OR Apache-2.0
use std::sync::Arc;

use mtb_contact::prepared::{INPUTS, OUTPUTS, Prepared, PreparedContact, Pull, Step};
use mtb_operator::unmonitored;

use crate::contact::Contact;
use crate::words;

/// A sliding contact; inputs and outputs are those of its derivatives, [`INPUTS`] and [`OUTPUTS`].
pub(crate) struct Sliding {
    contact: PreparedContact,
    /// Pressures of the last step, then what the motions found from balance did.
    memory: Vec<f64>,
}

impl Sliding {
    pub(crate) fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let prepared = Prepared::from_bytes(bytes).map_err(words)?;
        Ok(Self {
            contact: PreparedContact::new(Arc::new(prepared)),
            memory: Vec::new(),
        })
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

    fn solve(&mut self, inputs: &[f64]) -> Result<Vec<f64>, String> {
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
            shift: None,
        };
        let out = self.contact.step(&step, &unmonitored).map_err(words)?;
        if let Some(why) = out.unsolved() {
            return Err(why);
        }
        let geometry = &self.contact.prepared().geometry;
        let mean = geometry.mean_tractions(&out.solution.pressure);
        let peak = mean.iter().copied().fold(0.0, f64::max);
        let outputs = [
            out.force.as_slice(),
            &out.moment,
            &[out.friction_power, peak],
        ];
        self.memory = out.solution.pressure;
        self.memory.extend(out.solution.motion);
        Ok(outputs.concat())
    }

    fn has_step(&self) -> bool {
        self.contact.taken().is_some()
    }

    fn derivatives(&mut self) -> Result<Vec<Vec<f64>>, String> {
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
            let (pressure, motion) = memory
                .split_at_checked(prepared.geometry.points())
                .ok_or("the memory has fewer numbers than the contact has points")?;
            contact.resume(pressure, motion, None).map_err(words)?;
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

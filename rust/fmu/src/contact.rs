// SPDX-License-Identifier: MIT OR Apache-2.0
use crate::sliding::Sliding;
use crate::wheels::Wheels;

/// A prepared contact as a unit asks it: numbers in, numbers out.
pub(crate) trait Contact {
    /// How many numbers go in.
    fn inputs(&self) -> usize;

    /// How many come out.
    fn outputs(&self) -> usize;

    /// The input where the description has none: NaN leaves it to balance, or to what was prepared.
    fn default(&self, input: usize) -> f64;

    /// Solves a step of a `duration` [s] from the memory of the last one; of 0 at the beginning.
    ///
    /// # Errors
    /// In words; the memory is then that of the last step that was solved.
    fn solve(&mut self, inputs: &[f64], duration: f64) -> Result<Vec<f64>, String>;

    /// Whether what comes out follows from the memory, so that a step solved again goes on from itself.
    fn follows_memory(&self) -> bool;

    /// Whether the last step was solved, and not resumed, so that it has derivatives.
    fn has_step(&self) -> bool;

    /// Derivatives of the outputs (rows) of the last step by the inputs (columns).
    ///
    /// # Errors
    /// In words.
    fn derivatives(&mut self) -> Result<Vec<Vec<f64>>, String>;

    /// What the next step starts from; nothing before the first one.
    fn memory(&self) -> Vec<f64>;

    /// Takes a memory for that of the last step.
    ///
    /// # Errors
    /// In words; nothing has changed then.
    fn resume(&mut self, memory: &[f64]) -> Result<(), String>;

    /// Forgets all steps.
    fn forget(&mut self);
}

/// Reads a contact.
type Read = fn(&[u8]) -> Result<Box<dyn Contact>, String>;

/// The files that a unit may hold one of.
pub(crate) const FILES: [(&str, Read); 3] = [
    ("contact.mtbc", |bytes| {
        Ok(Box::new(Sliding::from_bytes(bytes)?))
    }),
    ("wheels.mtbw", |bytes| {
        Ok(Box::new(Wheels::from_bytes(bytes, false)?))
    }),
    ("transient_wheels.mtbw", |bytes| {
        Ok(Box::new(Wheels::from_bytes(bytes, true)?))
    }),
];

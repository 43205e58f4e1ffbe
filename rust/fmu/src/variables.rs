// SPDX-License-Identifier: MIT OR Apache-2.0
use std::ops::Range;

/// Value references: pose x, y, z, roll, pitch, yaw; velocity x, y; magnetic pressure ...
pub(crate) const INPUTS: Range<usize> = 0..9;
/// ... force x, y, z; moment x, y, z; friction power; peak pressure.
pub(crate) const OUTPUTS: Range<usize> = 9..17;

/// Inputs and outputs by value reference.
#[derive(Clone)]
pub(crate) struct Values {
    numbers: [f64; OUTPUTS.end],
    /// Which inputs the description of the unit has.
    declared: [bool; INPUTS.end],
}

impl Default for Values {
    fn default() -> Self {
        let mut numbers = [f64::NAN; OUTPUTS.end];
        numbers[6..8].fill(0.0);
        Self {
            numbers,
            declared: [false; INPUTS.end],
        }
    }
}

impl Values {
    /// Inputs by lines of value reference and number; `None` where one is none.
    pub(crate) fn starting(lines: &str) -> Option<Self> {
        let mut values = Self::default();
        for line in lines.lines() {
            let (reference, value) = line.split_once(' ')?;
            let reference = reference.parse().ok().filter(|r| INPUTS.contains(r))?;
            values.declared[reference] = true;
            values.set(
                reference,
                value.parse().ok().filter(|v: &f64| v.is_finite())?,
            );
        }
        Some(values)
    }

    /// Whether the description of the unit has such an input.
    pub(crate) fn is_input(&self, reference: usize) -> bool {
        self.declared.get(reference).copied().unwrap_or(false)
    }

    /// An input or output that the description has.
    pub(crate) fn get(&self, reference: usize) -> Option<f64> {
        let is_known = self.is_input(reference) || OUTPUTS.contains(&reference);
        is_known.then(|| self.numbers[reference])
    }

    /// Sets an input.
    pub(crate) fn set(&mut self, reference: usize, value: f64) {
        self.numbers[reference] = value;
    }

    pub(crate) fn pose(&self) -> [f64; 6] {
        std::array::from_fn(|k| self.numbers[k])
    }

    pub(crate) fn velocity(&self) -> [f64; 2] {
        [self.numbers[6], self.numbers[7]]
    }

    pub(crate) fn magnetic_pressure(&self) -> f64 {
        self.numbers[8]
    }

    /// Sets all outputs.
    pub(crate) fn keep(&mut self, force: [f64; 3], moment: [f64; 3], power: f64, peak: f64) {
        self.numbers[9..12].copy_from_slice(&force);
        self.numbers[12..15].copy_from_slice(&moment);
        self.numbers[15] = power;
        self.numbers[16] = peak;
    }
}

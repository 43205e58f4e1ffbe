use std::ops::Range;

/// Value references: pose x, y, z, roll, pitch, yaw; velocity x, y; magnetic pressure ...
pub(crate) const INPUTS: Range<usize> = 0..9;
/// ... force x, y, z; moment x, y, z; friction power; peak pressure.
pub(crate) const OUTPUTS: Range<usize> = 9..17;

/// Inputs and outputs by value reference.
#[derive(Clone)]
pub(crate) struct Values([f64; OUTPUTS.end]);

impl Default for Values {
    fn default() -> Self {
        let mut values = [f64::NAN; OUTPUTS.end];
        values[6..8].fill(0.0);
        Self(values)
    }
}

impl Values {
    /// Inputs by lines of value reference and number; `None` where one is none.
    pub(crate) fn starting(lines: &str) -> Option<Self> {
        let mut values = Self::default();
        for line in lines.lines() {
            let (reference, value) = line.split_once(' ')?;
            let reference = reference.parse().ok().filter(|r| INPUTS.contains(r))?;
            values.set(reference, value.parse().ok()?);
        }
        Some(values)
    }

    pub(crate) fn get(&self, reference: usize) -> Option<f64> {
        self.0.get(reference).copied()
    }

    /// Sets an input.
    pub(crate) fn set(&mut self, reference: usize, value: f64) {
        self.0[reference] = value;
    }

    pub(crate) fn pose(&self) -> [f64; 6] {
        std::array::from_fn(|k| self.0[k])
    }

    pub(crate) fn velocity(&self) -> [f64; 2] {
        [self.0[6], self.0[7]]
    }

    pub(crate) fn magnetic_pressure(&self) -> f64 {
        self.0[8]
    }

    /// Sets all outputs.
    pub(crate) fn keep(&mut self, force: [f64; 3], moment: [f64; 3], power: f64, peak: f64) {
        self.0[9..12].copy_from_slice(&force);
        self.0[12..15].copy_from_slice(&moment);
        self.0[15] = power;
        self.0[16] = peak;
    }
}

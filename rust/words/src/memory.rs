// SPDX-License-Identifier: MIT OR Apache-2.0
use std::fmt::{Display, Formatter};

/// Memory [GB] with one digit behind the point of the unit that leaves a tenth or more in front of it.
#[derive(Clone, Copy, Debug)]
pub struct Memory(pub f64);

impl Display for Memory {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let (value, unit) = match self.0 {
            g if g >= 0.1 => (g, "GB"),
            g if g >= 1e-4 => (1e3 * g, "MB"),
            g => (1e6 * g, "kB"),
        };
        let text = format!("{value:.1}");
        write!(f, "{} {unit}", text.strip_suffix(".0").unwrap_or(&text))
    }
}

#[cfg(test)]
mod tests {
    use super::Memory;

    #[test]
    fn small_amounts_are_said_in_small_units() {
        let said =
            [51.25, 8.0, 0.9, 0.1, 0.0432, 1.5e-4, 9.6e-5, 0.0].map(|g| Memory(g).to_string());
        let meant = [
            "51.2 GB", "8 GB", "0.9 GB", "0.1 GB", "43.2 MB", "0.1 MB", "96 kB", "0 kB",
        ];
        assert_eq!(said, meant);
    }
}

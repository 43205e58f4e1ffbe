// SPDX-License-Identifier: MIT OR Apache-2.0
use std::fmt::{Display, Formatter};

/// A number with six digits, with an exponent where it is large or small.
///
/// What messages show: `0.30000000000000004` is 0.3, `1e-7` is 1e-07.
#[derive(Clone, Copy, Debug)]
pub struct Short(pub f64);

/// A number with two digits and an exponent, such as 4e+06: sizes and residuals of which no more is known.
#[derive(Clone, Copy, Debug)]
pub struct Rough(pub f64);

impl Display for Short {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let scientific = format!("{:.5e}", self.0);
        // infinite, or no number
        let Some(power) = power(&scientific) else {
            return write!(f, "{}", self.0);
        };
        if !(-4..6).contains(&power) {
            return with_exponent(f, &scientific);
        }
        let decimals = (5 - power) as usize;
        let fixed = format!("{:.decimals$}", self.0);
        f.write_str(if decimals > 0 {
            trimmed(&fixed)
        } else {
            &fixed
        })
    }
}

impl Display for Rough {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        with_exponent(f, &format!("{:.1e}", self.0))
    }
}

/// The power of ten of `1.5e-7`.
fn power(scientific: &str) -> Option<i32> {
    scientific.split_once('e')?.1.parse().ok()
}

/// `1.50e-7` as 1.5e-07.
fn with_exponent(f: &mut Formatter<'_>, scientific: &str) -> std::fmt::Result {
    match (scientific.split_once('e'), power(scientific)) {
        (Some((mantissa, _)), Some(power)) => write!(f, "{}e{power:+03}", trimmed(mantissa)),
        _ => f.write_str(scientific),
    }
}

/// Digits without the zeros that end them.
fn trimmed(digits: &str) -> &str {
    digits.trim_end_matches('0').trim_end_matches('.')
}

#[cfg(test)]
mod tests {
    use super::{Rough, Short};

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (-1e300, "-1e+300"),
            (1.234_567_8, "1.23457"),
            (0.1 + 0.2, "0.3"),
            (60e3, "60000"),
            (123_456.7, "123457"),
            (999_999.7, "1e+06"),
            (1_234_567.0, "1.23457e+06"),
            (2.5e-5, "2.5e-05"),
            (f64::INFINITY, "inf"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(Short(value).to_string(), text);
        }
    }

    #[test]
    fn rough_numbers_have_two_digits() {
        for (value, text) in [
            (4e6, "4e+06"),
            (1.26e-5, "1.3e-05"),
            (0.0, "0e+00"),
            (f64::INFINITY, "inf"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(Rough(value).to_string(), text);
        }
    }
}

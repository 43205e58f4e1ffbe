// SPDX-License-Identifier: MIT OR Apache-2.0
use std::fmt::{Display, Formatter};

/// A number with six digits, with an exponent where it is large or small.
///
/// What messages show: `0.30000000000000004` is 0.3, `1e-7` is 1e-07.
#[derive(Clone, Copy, Debug)]
pub struct Short(pub f64);

impl Display for Short {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let scientific = format!("{:.5e}", self.0);
        let Some((mantissa, exponent)) = scientific.split_once('e') else {
            return write!(f, "{}", self.0);
        };
        let power: i32 = exponent.parse().unwrap_or(0);
        let trimmed = |digits: &str| {
            let short = digits.trim_end_matches('0').trim_end_matches('.');
            short.to_owned()
        };
        if (-4..6).contains(&power) {
            let decimals = (5 - power) as usize;
            let fixed = format!("{:.decimals$}", self.0);
            let text = if decimals > 0 { trimmed(&fixed) } else { fixed };
            f.write_str(&text)
        } else {
            let sign = if power < 0 { '-' } else { '+' };
            let mantissa = trimmed(mantissa);
            write!(f, "{mantissa}e{sign}{:02}", power.abs())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Short;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (-1e300, "-1e+300"),
            (1.234_567_8, "1.23457"),
            (60e3, "60000"),
            (123_456.7, "123457"),
            (1_234_567.0, "1.23457e+06"),
            (2.5e-5, "2.5e-05"),
            (f64::INFINITY, "inf"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(Short(value).to_string(), text);
        }
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_words::Short;
use thiserror::Error;

/// Input that was not taken.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// An array has the wrong length.
    #[error("{name} has {found} entries, expected {expected}")]
    Shape {
        /// Name of the array.
        name: &'static str,
        /// Length found.
        found: usize,
        /// Length needed.
        expected: usize,
    },
    /// An entry is not a finite number.
    #[error("{name}[{index}] is {}, a finite number is needed", Short(*.value))]
    NotFinite {
        /// Name of the array.
        name: &'static str,
        /// Position of the entry.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A number that must be positive is not.
    #[error("{name} is {}: it must be positive and finite", Short(*.value))]
    NotPositive {
        /// Name of the number.
        name: &'static str,
        /// Its value.
        value: f64,
    },
}

pub(crate) fn positive(name: &'static str, value: f64) -> Result<f64, Error> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(Error::NotPositive { name, value })
    }
}

pub(crate) fn check(name: &'static str, values: &[f64], expected: usize) -> Result<(), Error> {
    if values.len() != expected {
        return Err(Error::Shape {
            name,
            found: values.len(),
            expected,
        });
    }
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(Error::NotFinite {
            name,
            index,
            value: values[index],
        }),
        None => Ok(()),
    }
}

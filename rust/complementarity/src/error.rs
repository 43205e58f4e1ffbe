// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::{Error as Operator, Interrupted};
use mtb_words::Short;
use thiserror::Error;

/// Why a problem could not be taken or its solution was broken off.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// An array has the wrong length.
    #[error("{name} has {found} entries, expected {expected}")]
    Shape {
        /// Name of the array.
        name: &'static str,
        /// Length that the other arrays ask for.
        expected: usize,
        /// Length found.
        found: usize,
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
    /// No memory for dense factors.
    #[error(transparent)]
    Operator(Operator),
    /// The monitor asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl From<Interrupted> for Error {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}

impl From<Operator> for Error {
    fn from(error: Operator) -> Self {
        match error {
            Operator::Interrupted => Self::Interrupted,
            refused => Self::Operator(refused),
        }
    }
}

pub(crate) fn check(name: &'static str, values: &[f64], expected: usize) -> Result<(), Error> {
    if values.len() != expected {
        return Err(Error::Shape {
            name,
            expected,
            found: values.len(),
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

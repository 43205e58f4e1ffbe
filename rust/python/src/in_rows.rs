// SPDX-License-Identifier: MIT OR Apache-2.0
//! Arrays row by row.

use std::fmt;

use numpy::ndarray::Dimension;
use numpy::{Element, PyReadonlyArray, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// What is said of an array that does not lie row by row.
#[derive(Debug)]
pub(crate) struct NotInRows;

impl fmt::Display for NotInRows {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array is not contiguous, row by row")
    }
}

impl From<NotInRows> for PyErr {
    fn from(error: NotInRows) -> Self {
        PyValueError::new_err(error.to_string())
    }
}

/// The numbers of an array, row by row.
pub(crate) trait InRows<T> {
    /// `as_slice` of the array takes one that lies column by column as it lies, and so for another.
    fn in_rows(&self) -> Result<&[T], NotInRows>;
}

impl<T: Element, D: Dimension> InRows<T> for PyReadonlyArray<'_, T, D> {
    fn in_rows(&self) -> Result<&[T], NotInRows> {
        if !self.is_c_contiguous() {
            return Err(NotInRows);
        }
        self.as_slice().map_err(|_| NotInRows)
    }
}

//! The edge: errors of the crates become Python exceptions here, and here only.

use std::cell::RefCell;
use std::fmt::Display;
use std::ops::ControlFlow;

use mtb_operator::{Monitor, Progress};
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;

/// Bad input: the message of the crate is the message of the `ValueError`.
pub(crate) fn bad_input(error: &impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Runs `work` without the interpreter lock; Ctrl-C is looked for whenever the work reports progress.
pub(crate) fn enter<T: Send, E: Display + Send>(
    py: Python<'_>,
    work: impl FnOnce(Monitor<'_>) -> Result<T, E> + Send,
) -> PyResult<T> {
    let (result, signal) = py.detach(move || {
        let signal: RefCell<Option<PyErr>> = RefCell::new(None);
        let monitor =
            |_: Progress| match Python::attach(|py| -> PyResult<()> { py.check_signals() }) {
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => {
                    *signal.borrow_mut() = Some(error);
                    ControlFlow::Break(())
                }
            };
        let result = work(&monitor).map_err(|error| error.to_string());
        (result, signal.into_inner())
    });
    match (result, signal) {
        (_, Some(signal)) => Err(signal),
        (Ok(value), None) => Ok(value),
        (Err(message), None) if message == INTERRUPTED => Err(PyKeyboardInterrupt::new_err(())),
        (Err(message), None) => Err(PyValueError::new_err(message)),
    }
}

/// The message every crate uses for its `Interrupted` error.
const INTERRUPTED: &str = "interrupted";

// SPDX-License-Identifier: MIT OR Apache-2.0
//! The edge: errors of the crates become Python exceptions here, and here only.

use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::fmt::Display;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use mtb_operator::{Monitor, Progress, ready_workers};
use pyo3::create_exception;
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;

create_exception!(
    mtb_rs,
    TooLargeError,
    PyValueError,
    "A mesh of finite elements needs more memory or operations than the limits, or than the machine has free."
);

/// Bad input: the message of the crate is the message of the `ValueError`.
pub(crate) fn bad_input(error: &impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Why work ended without a result.
pub(crate) enum Failure {
    /// The monitor asked to stop.
    Interrupted,
    /// What was asked cannot be; the message says why.
    Refused(String),
    /// A mesh that needs too much memory or too many operations; the message says how much.
    TooLarge(String),
}

macro_rules! failures {
    ($($error:path),*) => {$(
        impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                match error {
                    <$error>::Interrupted => Self::Interrupted,
                    refused => Self::Refused(refused.to_string()),
                }
            }
        }
    )*};
}

failures!(
    mtb_complementarity::Error,
    mtb_contact::Error,
    mtb_operator::Error,
    mtb_wheelset::Error
);

impl From<mtb_elasticity::Error> for Failure {
    fn from(error: mtb_elasticity::Error) -> Self {
        use mtb_elasticity::Error;
        match error {
            Error::Interrupted => Self::Interrupted,
            Error::TooLarge { .. }
            | Error::OutOfMemory { .. }
            | Error::Operator(mtb_operator::Error::Memory { .. }) => {
                Self::TooLarge(error.to_string())
            }
            refused => Self::Refused(refused.to_string()),
        }
    }
}

impl From<mtb_geometry::Error> for Failure {
    fn from(error: mtb_geometry::Error) -> Self {
        match error {
            mtb_geometry::Error::TooManyTetrahedra { .. } => Self::TooLarge(error.to_string()),
            refused => Self::Refused(refused.to_string()),
        }
    }
}

impl From<mtb_heat::Error> for Failure {
    fn from(error: mtb_heat::Error) -> Self {
        Self::Refused(error.to_string())
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Interrupted => PyKeyboardInterrupt::new_err(()),
            Failure::Refused(message) => PyValueError::new_err(message),
            Failure::TooLarge(message) => TooLargeError::new_err(message),
        }
    }
}

impl From<Infallible> for Failure {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

/// Runs `work` without the interpreter lock, with workers that live in this process.
pub(crate) fn apart<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> T {
    #[allow(clippy::disallowed_methods, reason = "the one door")]
    py.detach(|| {
        ready_workers();
        work()
    })
}

/// Time between two looks for a signal: what the eye takes for at once, and far more than a look costs.
const LOOK: Duration = Duration::from_millis(20);

/// Runs `work` as [`apart`] does; Ctrl-C is looked for when the work reports progress.
pub(crate) fn enter<T: Send, E: Into<Failure>>(
    py: Python<'_>,
    work: impl FnOnce(Monitor<'_>) -> Result<T, E> + Send,
) -> PyResult<T> {
    let (result, signal) = apart(py, move || {
        let signal: RefCell<Option<PyErr>> = RefCell::new(None);
        let looked = Cell::new(Instant::now());
        let monitor = |_: Progress| {
            // the lock of the interpreter may be another thread's for milliseconds
            if looked.get().elapsed() < LOOK {
                return ControlFlow::Continue(());
            }
            #[allow(
                clippy::redundant_closure_for_method_calls,
                reason = "the method itself is not general in the lifetime"
            )]
            let found = Python::attach(|py| py.check_signals());
            looked.set(Instant::now());
            match found {
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => {
                    *signal.borrow_mut() = Some(error);
                    ControlFlow::Break(())
                }
            }
        };
        let result = work(&monitor).map_err(E::into);
        (result, signal.into_inner())
    });
    match (result, signal) {
        // the work may have ended before it heard of the signal
        (_, Some(signal)) => Err(signal),
        (Ok(value), None) => Ok(value),
        (Err(failure), None) => Err(failure.into()),
    }
}

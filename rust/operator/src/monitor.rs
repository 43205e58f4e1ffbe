// SPDX-License-Identifier: MIT OR Apache-2.0
use std::ops::ControlFlow;

use thiserror::Error;

/// How far an iteration has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Iterations done.
    pub iteration: usize,
    /// Relative residual of the algorithm that reports, in its own measure.
    pub residual: f64,
}

/// Called by every long-running algorithm on the calling thread, about once an iteration;
/// `Break` asks it to stop with [`Interrupted`], which is a variant of every crate's own error.
pub type Monitor<'a> = &'a dyn Fn(Progress) -> ControlFlow<()>;

/// The monitor asked to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("interrupted")]
pub struct Interrupted;

/// The monitor that never interrupts.
pub fn unmonitored(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Reports to the monitor.
///
/// # Errors
/// [`Interrupted`] if it asks to stop.
pub fn report(monitor: Monitor<'_>, iteration: usize, residual: f64) -> Result<(), Interrupted> {
    match monitor(Progress {
        iteration,
        residual,
    }) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Interrupted),
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use std::ops::ControlFlow;

/// How far an iteration has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Iterations done.
    pub iteration: usize,
    /// Relative residual of the algorithm that reports, in its own measure.
    pub residual: f64,
}

/// Called by every long-running algorithm on the calling thread, about once an iteration;
/// `Break` asks it to stop with its `Interrupted` error.
pub type Monitor<'a> = &'a dyn Fn(Progress) -> ControlFlow<()>;

/// The monitor that never interrupts.
pub fn unmonitored(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

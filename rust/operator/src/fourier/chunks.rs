// SPDX-License-Identifier: MIT OR Apache-2.0
//! Parts of a transform on all threads, with looks at a monitor.

use rayon::prelude::*;

use crate::monitor::{Monitor, report};

/// Operations between two looks at the monitor: a tenth of a second on a slow core.
pub(super) const WORK_UNWATCHED: f64 = 2e8;

/// Operations of a transform of this length.
pub(super) fn transform_work(length: usize) -> f64 {
    5.0 * length as f64 * (length.max(2) as f64).log2()
}

/// Works on the chunks of `data`, on all threads if `parallel`, with scratch space per thread. The monitor is
/// asked about as often as [`WORK_UNWATCHED`] says, for chunks of `cost` operations each; what is left when it
/// asks to stop is not done.
pub(super) fn each_chunk<T: Send, S>(
    monitor: Monitor<'_>,
    cost: f64,
    parallel: bool,
    data: &mut [T],
    size: usize,
    scratch: impl Fn() -> S + Sync + Send,
    work: impl Fn(&mut S, usize, &mut [T]) + Sync + Send,
) {
    let round = ((WORK_UNWATCHED / cost) as usize).max(1);
    for (number, part) in data.chunks_mut(size.saturating_mul(round)).enumerate() {
        if number > 0 && report(monitor, number, f64::NAN).is_err() {
            return;
        }
        let first = number * round;
        if parallel {
            part.par_chunks_mut(size)
                .enumerate()
                .for_each_init(&scratch, |s, (k, chunk)| work(s, first + k, chunk));
        } else {
            let mut s = scratch();
            for (k, chunk) in part.chunks_mut(size).enumerate() {
                work(&mut s, first + k, chunk);
            }
        }
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use std::cell::Cell;
use std::sync::OnceLock;

use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};

/// Ends a state of the vector registers in which worker threads run scalar code many times slower.
///
/// Parallel dense kernels may leave the upper halves of the vector registers in use when they return; on
/// some processors every scalar operation then waits for them (an exponential took 48 times as long
/// after a factorisation of 300 rows). A short norm on every worker ends with the instruction that
/// resets them. To be called after dense factorisations and solves that ran in parallel; costs some
/// microseconds.
pub fn reset_workers() {
    rayon::broadcast(|_| {
        let values = std::hint::black_box([1.0; 64]);
        std::hint::black_box(faer::ColRef::from_slice(&values).norm_l2());
    });
}

/// Process that the pool of worker threads belongs to.
static HOME: OnceLock<u32> = OnceLock::new();

thread_local! {
    static IS_ALONE: Cell<bool> = const { Cell::new(false) };
}

/// Makes sure that the parallel code of these crates ends on the calling thread; to be called at every
/// door by which another program comes in.
///
/// A process made by `fork` has the memory of its parent, but none of its threads: work given to the
/// parent's pool would wait for ever. There each calling thread does all work itself. The first call starts
/// the pool, with at most one thread for each processor, or works alone as well where the system gives no
/// threads. A call costs less than a microsecond.
pub fn ready_workers() {
    let process = std::process::id();
    let home = *HOME.get_or_init(|| {
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        let asked = std::env::var("RAYON_NUM_THREADS").map_or(0, |n| n.parse().unwrap_or(0));
        let threads = if asked == 0 {
            processors
        } else {
            asked.min(processors)
        };
        let started = ThreadPoolBuilder::new().num_threads(threads).build_global();
        // a pool that is there already serves as well
        match started {
            Err(error) if is_refused_by_system(&error) => 0,
            _ => process,
        }
    });
    if home != process && !IS_ALONE.replace(true) {
        work_alone();
    }
}

/// Makes the calling thread a pool of its own, for good.
fn work_alone() {
    let alone = ThreadPoolBuilder::new()
        .num_threads(1)
        .use_current_thread()
        .build();
    // it fails on a thread that is in a pool already; dropped, the pool would end
    std::mem::forget(alone);
}

fn is_refused_by_system(error: &ThreadPoolBuildError) -> bool {
    use std::error::Error;
    error
        .source()
        .is_some_and(<dyn Error>::is::<std::io::Error>)
}

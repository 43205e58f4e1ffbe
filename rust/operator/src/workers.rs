// SPDX-License-Identifier: MIT OR Apache-2.0
use std::cell::Cell;
use std::collections::BTreeSet;
use std::fs::{read_dir, read_to_string};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};

use crate::{Error, Interrupted, Monitor, available_memory};

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

/// Does `work` on a worker thread, while the calling thread asks the monitor whatever the work asks.
///
/// Many short steps that each use all threads are quicker so: begun from outside the pool, every one of them wakes
/// the workers and waits until it is woken itself. The work hears of a wish to stop when it asks the next time. A
/// calling thread that is a worker itself does the work where it is.
///
/// # Errors
/// Those of the work; [`Interrupted`] if the monitor asked to stop.
pub fn on_workers<T: Send, E: Send + From<Interrupted>>(
    monitor: Monitor<'_>,
    work: impl FnOnce(Monitor<'_>) -> Result<T, E> + Send,
) -> Result<T, E> {
    if rayon::current_thread_index().is_some() {
        return work(monitor);
    }
    let ((), done) = with_worker(monitor, |_| Ok(()), work)?;
    Ok(done)
}

/// Does `here` on the calling thread and `there` on a worker thread at the same time, one after the other where there is
/// one thread, or where the calling thread is a worker itself. The calling thread asks the monitor for both.
///
/// # Errors
/// Those of `here`, which ends `there` as a wish to stop does; those of `there`; [`Interrupted`] if the monitor asked to
/// stop.
pub fn side_by_side<A, B: Send, E: Send + From<Interrupted>>(
    monitor: Monitor<'_>,
    here: impl FnOnce(Monitor<'_>) -> Result<A, E>,
    there: impl FnOnce(Monitor<'_>) -> Result<B, E> + Send,
) -> Result<(A, B), E> {
    if rayon::current_thread_index().is_some() || rayon::current_num_threads() == 1 {
        return Ok((here(monitor)?, there(monitor)?));
    }
    with_worker(monitor, here, there)
}

/// `here` on the calling thread, which answers the questions of `there` on a worker when it is done.
fn with_worker<A, B: Send, E: Send + From<Interrupted>>(
    monitor: Monitor<'_>,
    here: impl FnOnce(Monitor<'_>) -> Result<A, E>,
    there: impl FnOnce(Monitor<'_>) -> Result<B, E> + Send,
) -> Result<(A, B), E> {
    let is_stopped = AtomicBool::new(false);
    let ask = |progress| {
        if is_stopped.load(Ordering::Relaxed) {
            return ControlFlow::Break(());
        }
        let answer = monitor(progress);
        is_stopped.store(answer.is_break(), Ordering::Relaxed);
        answer
    };
    let (sender, questions) = channel();
    let mut done = Err(Interrupted.into());
    let own = rayon::in_place_scope(|scope| {
        let (done, is_stopped) = (&mut done, &is_stopped);
        scope.spawn(move |_| {
            // the questions end with the sender
            let ask = |progress| {
                if is_stopped.load(Ordering::Relaxed) || sender.send(progress).is_err() {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            };
            *done = there(&ask);
        });
        let own = here(&ask);
        if own.is_err() {
            is_stopped.store(true, Ordering::Relaxed);
        }
        for progress in questions {
            let _ = ask(progress);
        }
        own
    })?;
    if is_stopped.into_inner() {
        return Err(Interrupted.into());
    }
    Ok((own, done?))
}

/// Process that the pool of worker threads belongs to.
static HOME: OnceLock<u32> = OnceLock::new();

thread_local! {
    static IS_ALONE: Cell<bool> = const { Cell::new(false) };
    static HAS_BUFFER: Cell<bool> = const { Cell::new(false) };
}

/// Makes sure that the parallel code of these crates ends on the calling thread; to be called at every
/// door by which another program comes in.
///
/// A process made by `fork` has the memory of its parent, but none of its threads: work given to the
/// parent's pool would wait for ever. There each calling thread does all work itself. The first call starts
/// the pool, with at most one thread for each processor, on as many as leave half of the address space free
/// when all have the buffers of [`ready_products`]. It works alone where there are none, or where the system
/// gives no threads. A call costs less than a microsecond.
pub fn ready_workers() {
    let process = std::process::id();
    let home = *HOME.get_or_init(|| if starts() { process } else { 0 });
    if home != process && !IS_ALONE.replace(true) {
        work_alone();
    }
}

/// Makes sure that products of matrices find their buffer on the calling thread.
///
/// They keep one of twice the outermost cache in every thread, and end the process where they do not get
/// it: near a limit of the address space. Costs less than a microsecond, but for the first call of a thread.
///
/// # Errors
/// [`Error::Buffer`] if there is none to be had.
pub fn ready_products() -> Result<(), Error> {
    if HAS_BUFFER.get() {
        return Ok(());
    }
    let bytes = buffer();
    if fits(1, bytes) {
        take_buffer();
        return Ok(());
    }
    Err(Error::Buffer {
        gigabytes: 1e-9 * bytes as f64,
        available: 1e-9 * available_memory().unwrap_or(0.0).max(0.0),
    })
}

/// Starts the pool, with buffers; whether there is one.
fn starts() -> bool {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let asked = std::env::var("RAYON_NUM_THREADS").map_or(0, |n| n.parse().unwrap_or(0));
    let most = if asked == 0 {
        processors
    } else {
        asked.min(processors)
    };
    let bytes = buffer();
    // those of the workers and of the calling thread, and as much for the work
    let Some(threads) = (1..=most).rev().find(|n| fits(2 * (n + 1), bytes)) else {
        return false;
    };
    let started = ThreadPoolBuilder::new().num_threads(threads).build_global();
    // a pool that is there already serves as well
    if started.is_err_and(|error| is_refused_by_system(&error)) {
        return false;
    }
    rayon::broadcast(|_| take_buffer());
    true
}

/// Whether the process gets so many buffers at once. None of their memory is touched.
fn fits(count: usize, bytes: usize) -> bool {
    let mut kept = Vec::new();
    (0..count).all(|_| {
        let mut one: Vec<u8> = Vec::new();
        let has = one.try_reserve_exact(bytes).is_ok();
        kept.push(std::hint::black_box(one));
        has
    })
}

/// Lets the calling thread have its buffer, by a product just too large to go without.
fn take_buffer() {
    let one = Mat::<f64>::ones(64, 64);
    let mut product = Mat::<f64>::zeros(64, 64);
    matmul(
        product.as_mut(),
        Accum::Replace,
        one.as_ref(),
        one.as_ref(),
        1.0,
        Par::Seq,
    );
    std::hint::black_box(product);
    HAS_BUFFER.set(true);
}

/// Memory [bytes] that products of matrices keep in every thread.
fn buffer() -> usize {
    if cfg!(target_arch = "x86_64") {
        2 * outer_cache(Path::new("/sys/devices/system/cpu")).unwrap_or(0)
    } else {
        0
    }
}

/// Size [bytes] of the outermost cache as `private-gemm-x86` 0.1 counts it: the share of one processor, times
/// the processors of a core, times the cores. `None` where the system does not tell.
fn outer_cache(processors: &Path) -> Option<usize> {
    let (mut share, mut of_a_core, mut cores) = (0, 1, BTreeSet::new());
    for processor in read_dir(processors).ok()?.flatten() {
        let Ok(caches) = read_dir(processor.path().join("cache")) else {
            continue;
        };
        for cache in caches.flatten() {
            let entry = |name: &str| -> Option<String> {
                let text = read_to_string(cache.path().join(name)).ok()?;
                Some(text.trim().to_owned())
            };
            let (Some(level), Some(kind), Some(list)) =
                (entry("level"), entry("type"), entry("shared_cpu_list"))
            else {
                continue;
            };
            if level == "1" && kind == "Data" {
                of_a_core = shared_by(&list).max(of_a_core);
                cores.insert(list);
            } else if level == "3" {
                let size = entry("size").and_then(|text| bytes_of(&text))?;
                share = share.max(size / shared_by(&list).max(1));
            }
        }
    }
    Some(share * of_a_core * cores.len())
}

/// Processors in a list such as "0-3,8".
fn shared_by(list: &str) -> usize {
    let number = |text: &str| text.parse::<usize>().unwrap_or(0);
    list.split(',')
        .map(|part| match part.split_once('-') {
            Some((first, last)) => (number(last) + 1).saturating_sub(number(first)),
            None => 1,
        })
        .sum()
}

/// A size such as "32768K".
fn bytes_of(text: &str) -> Option<usize> {
    let digits = text.trim_end_matches(['K', 'M', 'G']);
    let unit = match text[digits.len()..].chars().next() {
        Some('K') => 1 << 10,
        Some('M') => 1 << 20,
        Some('G') => 1 << 30,
        _ => 1,
    };
    Some(digits.parse::<usize>().ok()? * unit)
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

#[cfg(test)]
mod tests {
    use std::fs::{create_dir_all, write};

    use super::*;
    use crate::Progress;

    /// Writes the caches of a processor: level, kind, size, list of those that share it.
    fn describe(root: &Path, processor: usize, caches: &[(&str, &str, &str, &str)]) {
        for (k, (level, kind, size, list)) in caches.iter().enumerate() {
            let place = root.join(format!("cpu{processor}/cache/index{k}"));
            create_dir_all(&place).expect("a folder");
            for (name, text) in [
                ("level", level),
                ("type", kind),
                ("size", size),
                ("shared_cpu_list", list),
            ] {
                write(place.join(name), format!("{text}\n")).expect("a file");
            }
        }
    }

    #[test]
    fn work_is_done_by_a_worker_while_the_calling_thread_answers() {
        let caller = std::thread::current().id();
        let looks = Cell::new(0);
        let count = |progress: Progress| {
            assert_eq!(std::thread::current().id(), caller);
            looks.set(looks.get() + 1);
            if progress.iteration == 3 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let ask = |monitor: Monitor<'_>, times: usize| {
            assert!(rayon::current_thread_index().is_some());
            (1..=times).try_for_each(|k| crate::report(monitor, k, f64::NAN))?;
            Ok::<_, Interrupted>(times)
        };
        assert_eq!(on_workers(&count, |monitor| ask(monitor, 2)), Ok(2));
        assert_eq!(looks.replace(0), 2);
        // a wish to stop is kept, though the work may be done before it hears of it
        let stopped = on_workers(&count, |monitor| ask(monitor, 5));
        assert_eq!((stopped, looks.replace(0)), (Err(Interrupted), 3));
        // and for ever asking it ends
        let forever = on_workers(&count, |monitor| ask(monitor, usize::MAX));
        assert_eq!(forever, Err(Interrupted));
    }

    #[test]
    fn two_works_are_done_at_once() {
        ready_workers();
        let caller = std::thread::current().id();
        let looks = Cell::new(0);
        let count = |_: Progress| {
            assert_eq!(std::thread::current().id(), caller);
            looks.set(looks.get() + 1);
            if looks.get() == 7 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let ask = |monitor: Monitor<'_>, times: usize| {
            (1..=times).try_for_each(|k| crate::report(monitor, k, f64::NAN))?;
            Ok::<_, Error>(times)
        };
        let both = |here, there| side_by_side(&count, |m| ask(m, here), |m| ask(m, there));
        assert_eq!(both(2, 3).ok(), Some((2, 3)));
        assert_eq!(looks.get(), 5);
        // a wish to stop ends both, whichever asked
        assert!(matches!(both(usize::MAX, 1), Err(Error::Interrupted)));
        looks.set(0);
        assert!(matches!(both(1, usize::MAX), Err(Error::Interrupted)));
        // an error on the calling thread ends the other work, and is the one that is told
        let failed = |_: Monitor<'_>| Err::<usize, _>(Error::Rigid);
        looks.set(-1000);
        let found = side_by_side(&count, failed, |m| ask(m, usize::MAX));
        assert!(matches!(found, Err(Error::Rigid)));
        let found = side_by_side(&count, |m| ask(m, 2), failed);
        assert!(matches!(found, Err(Error::Rigid)));
    }

    #[test]
    fn the_outermost_cache_is_counted_over_all_cores() {
        let root = std::env::temp_dir().join(format!("mtb-caches-{}", std::process::id()));
        for processor in 0..4 {
            let core = ["0,2", "1,3"][processor % 2];
            describe(
                &root,
                processor,
                &[
                    ("1", "Data", "32K", core),
                    ("1", "Instruction", "64K", core),
                    ("2", "Unified", "1M", core),
                    ("3", "Unified", "24M", "0-3"),
                ],
            );
        }
        let found = outer_cache(&root);
        std::fs::remove_dir_all(&root).expect("it was made");
        assert_eq!(found, Some(24 << 20));
        assert_eq!(outer_cache(&root), None);
    }

    #[test]
    fn what_cannot_be_had_does_not_fit() {
        assert!(fits(3, 1 << 20));
        assert!(!fits(1, usize::MAX / 4));
        assert!(!fits(1 << 20, 1 << 45));
    }
}

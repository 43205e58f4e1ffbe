// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the machine has, and what may be asked of it.

use std::fs::read_to_string;

use crate::{Error, ready_products};

/// Memory [bytes] that dense matrices and factors may take where the machine has as much.
pub const MEMORY_LIMIT: f64 = 8e9;

/// Memory [bytes] that this process can still have: what the machine has free, less where a group of processes
/// or the shell limits it. `None` where the system does not tell.
pub fn available_memory() -> Option<f64> {
    let bounds = [machine(), group(), available_address_space()];
    bounds.into_iter().flatten().reduce(f64::min)
}

/// The number after `name` in lines of `name number unit`, times the unit.
fn entry(text: &str, name: &str) -> Option<f64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let mut words = line.split_whitespace();
    let number: f64 = words.next()?.parse().ok()?;
    Some(if words.next() == Some("kB") {
        1024.0 * number
    } else {
        number
    })
}

fn machine() -> Option<f64> {
    entry(&read_to_string("/proc/meminfo").ok()?, "MemAvailable:")
}

/// The limit of a container, less what it uses; its page cache can be had back.
fn group() -> Option<f64> {
    let number = |name: &str| -> Option<f64> {
        let text = read_to_string(format!("/sys/fs/cgroup/{name}")).ok()?;
        text.trim().parse().ok()
    };
    let cache = read_to_string("/sys/fs/cgroup/memory.stat")
        .ok()
        .and_then(|text| entry(&text, "inactive_file "));
    Some(number("memory.max")? - number("memory.current")? + cache.unwrap_or(0.0))
}

/// What a limit of the address space (`ulimit -v`) leaves [bytes]; `None` where there is none.
pub fn available_address_space() -> Option<f64> {
    let limits = read_to_string("/proc/self/limits").ok()?;
    let limit = entry(&limits, "Max address space")?;
    let used = entry(&read_to_string("/proc/self/status").ok()?, "VmSize:")?;
    Some(limit - used)
}

/// Refuses what would not fit into the memory, before any of it is asked for.
///
/// # Errors
/// [`Error::Memory`] if `bytes` are more than `limit`, or more than the machine has.
pub fn check_memory(points: usize, bytes: f64, limit: f64) -> Result<(), Error> {
    let available = available_memory().unwrap_or(f64::INFINITY);
    if bytes <= limit.min(available) {
        return Ok(());
    }
    Err(Error::Memory {
        points,
        gigabytes: 1e-9 * bytes,
        limit: 1e-9 * limit,
        available: 1e-9 * available.max(0.0),
    })
}

/// [`check_memory`] for matrices that are to be factorised, against [`MEMORY_LIMIT`], beside what their
/// products take.
///
/// # Errors
/// [`Error::Memory`], [`Error::Buffer`].
pub fn check_factors(points: usize, bytes: f64) -> Result<(), Error> {
    check_memory(points, bytes, MEMORY_LIMIT)?;
    ready_products()?;
    check_memory(points, bytes, MEMORY_LIMIT)
}

/// [`check_factors`] for dense square matrices over `points`.
///
/// # Errors
/// [`Error::Memory`], [`Error::Buffer`].
pub fn check_dense(points: usize, matrices: usize) -> Result<(), Error> {
    check_factors(points, 8.0 * matrices as f64 * (points as f64).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_memory_does_not_hold_is_refused() {
        assert!(check_dense(1000, 4).is_ok());
        assert_eq!(check_dense(0, 4), Ok(()));
        let error = check_dense(40_000, 4).expect_err("51 GB");
        let message = error.to_string();
        assert!(
            message.contains("40000 contact points take 51.2 GB"),
            "{message}"
        );
        assert!(check_dense(usize::MAX, 1).is_err());
        // within the limit, but more than any machine has
        assert!(check_memory(1, 1e18, f64::INFINITY).is_err() || available_memory().is_none());
    }

    #[test]
    fn the_limit_is_said() {
        let refused = check_memory(10, 1e6, 2.5e5).expect_err("more than the limit");
        assert!(
            refused
                .to_string()
                .contains("take 1 MB; the limit is 0.2 MB"),
            "{refused}"
        );
    }

    #[test]
    fn entries_are_read_with_their_unit() {
        assert_eq!(entry("A: 1 kB\nMem: 3 kB\n", "Mem:"), Some(3072.0));
        assert_eq!(
            entry("Max address space   unlimited bytes", "Max address space"),
            None
        );
        assert_eq!(
            entry("Max address space   4000 5000 bytes", "Max address space"),
            Some(4000.0)
        );
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_machine_tells_what_it_has() {
        let available = available_memory().expect("Linux tells");
        assert!((1e6..1e15).contains(&available), "{available:e}");
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! The edge to importing programs that both versions of the standard share: pointers, panics, messages.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

use mtb_operator::ready_workers;

use crate::unit::{Kept, Unit};

// statuses have the same numbers in both versions
pub(crate) const OK: c_int = 0;
pub(crate) const DISCARD: c_int = 2;
pub(crate) const ERROR: c_int = 3;

/// Where messages go, with their status.
pub(crate) type Log = Box<dyn Fn(c_int, &str)>;

/// One instance of a unit.
pub(crate) struct Instance {
    log: Log,
    unit: Unit,
}

/// Why a call did not do what it should.
pub(crate) struct Failure(pub(crate) c_int, pub(crate) String);

impl From<String> for Failure {
    fn from(message: String) -> Self {
        Self(ERROR, message)
    }
}

/// The category of a status in the log.
pub(crate) fn category(status: c_int) -> &'static CStr {
    if status == DISCARD {
        c"logStatusDiscard"
    } else {
        c"logStatusError"
    }
}

/// An instance of the unit that is made, or null, with a message to the log, where it cannot be.
pub(crate) fn instantiate(log: Log, make: impl FnOnce() -> Result<Unit, String>) -> *mut c_void {
    let made = catch_unwind(AssertUnwindSafe(make));
    match made.unwrap_or_else(|_| Err("internal fault".to_owned())) {
        Ok(unit) => Box::into_raw(Box::new(Instance { log, unit })).cast(),
        Err(message) => {
            log(ERROR, &message);
            std::ptr::null_mut()
        }
    }
}

/// Gives an instance back.
///
/// # Safety
/// It must be one of [`instantiate`], not used again, or null.
pub(crate) unsafe fn free(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: as the caller says
        drop(unsafe { Box::from_raw(instance.cast::<Instance>()) });
    }
}

/// Runs the work of a call on a unit: no panic leaves, and what went wrong goes to its log.
///
/// # Safety
/// The instance must be one of [`instantiate`], used by one thread at a time, or null.
pub(crate) unsafe fn call(
    instance: *mut c_void,
    work: impl FnOnce(&mut Unit) -> Result<(), Failure>,
) -> c_int {
    // SAFETY: as the caller says
    let Some(Instance { log, unit }) = (unsafe { instance.cast::<Instance>().as_mut() }) else {
        return ERROR;
    };
    let done = catch_unwind(AssertUnwindSafe(|| {
        ready_workers();
        work(unit)
    }))
    .unwrap_or_else(|_| {
        unit.forget();
        Err("internal fault; the contact forgets its last step"
            .to_owned()
            .into())
    });
    match done {
        Ok(()) => OK,
        Err(Failure(status, message)) => {
            log(status, &message);
            status
        }
    }
}

/// The caller's array of `length` values.
///
/// # Safety
/// Null, or as many readable values, which stay as they are during the call.
pub(crate) unsafe fn take<'a, T>(
    name: &str,
    from: *const T,
    length: usize,
) -> Result<&'a [T], String> {
    if length == 0 {
        return Ok(&[]);
    }
    if from.is_null() {
        return Err(format!("{name} is null"));
    }
    // SAFETY: not null; the rest as the caller says
    Ok(unsafe { std::slice::from_raw_parts(from, length) })
}

/// Writes `values` to the array of the caller, which has room for `length` of them.
///
/// # Safety
/// Null, or as much writable room.
pub(crate) unsafe fn give<T: Copy>(
    name: &str,
    to: *mut T,
    length: usize,
    values: &[T],
) -> Result<(), String> {
    if values.len() != length {
        return Err(format!(
            "{name} has room for {length} numbers: these variables have {}",
            values.len()
        ));
    }
    if values.is_empty() {
        return Ok(());
    }
    if to.is_null() {
        return Err(format!("{name} is null"));
    }
    // SAFETY: not null; the rest as the caller says
    unsafe { std::ptr::copy_nonoverlapping(values.as_ptr(), to, length) };
    Ok(())
}

/// The caller's text, lossily; empty for null.
///
/// # Safety
/// Null, or a text that ends in a zero.
pub(crate) unsafe fn text(from: *const c_char) -> String {
    if from.is_null() {
        return String::new();
    }
    // SAFETY: not null; the rest as the caller says
    unsafe { CStr::from_ptr(from) }
        .to_string_lossy()
        .into_owned()
}

/// The numbers of some variables.
///
/// # Safety
/// As of [`call`], [`take`] and [`give`].
pub(crate) unsafe fn get(
    instance: *mut c_void,
    (references, count): (*const u32, usize),
    (values, length): (*mut f64, usize),
) -> c_int {
    let work = |unit: &mut Unit| {
        // SAFETY: as the caller says
        let references = unsafe { take("references", references, count) }?;
        let found = unit.get(references)?;
        // SAFETY: as the caller says
        Ok(unsafe { give("values", values, length, &found) }?)
    };
    // SAFETY: as the caller says
    unsafe { call(instance, work) }
}

/// Sets some inputs.
///
/// # Safety
/// As of [`call`] and [`take`].
pub(crate) unsafe fn set(
    instance: *mut c_void,
    (references, count): (*const u32, usize),
    (values, length): (*const f64, usize),
) -> c_int {
    let work = |unit: &mut Unit| {
        // SAFETY: as the caller says
        let references = unsafe { take("references", references, count) }?;
        // SAFETY: as the caller says
        let values = unsafe { take("values", values, length) }?;
        Ok(unit.set(references, values)?)
    };
    // SAFETY: as the caller says
    unsafe { call(instance, work) }
}

/// Derivatives of outputs by inputs along a seed, or back from one.
pub(crate) type Derive = fn(&mut Unit, &[u32], &[u32], &[f64]) -> Result<Vec<f64>, String>;

/// Derivatives of some outputs by some inputs.
///
/// # Safety
/// As of [`call`], [`take`] and [`give`].
pub(crate) unsafe fn derive(
    instance: *mut c_void,
    derive: Derive,
    (unknowns, n): (*const u32, usize),
    (knowns, m): (*const u32, usize),
    (seed, seeds): (*const f64, usize),
    (out, length): (*mut f64, usize),
) -> c_int {
    let work = |unit: &mut Unit| {
        // SAFETY: as the caller says
        let unknowns = unsafe { take("unknowns", unknowns, n) }?;
        // SAFETY: as the caller says
        let knowns = unsafe { take("knowns", knowns, m) }?;
        // SAFETY: as the caller says
        let seed = unsafe { take("seed", seed, seeds) }?;
        let found = derive(unit, unknowns, knowns, seed)?;
        // SAFETY: as the caller says
        Ok(unsafe { give("sensitivity", out, length, &found) }?)
    };
    // SAFETY: as the caller says
    unsafe { call(instance, work) }
}

/// Writes a number to a place of the caller.
///
/// # Safety
/// As of [`give`].
pub(crate) unsafe fn put<T: Copy>(name: &str, to: *mut T, value: T) -> Result<(), String> {
    // SAFETY: as the caller says
    unsafe { give(name, to, 1, &[value]) }
}

/// Keeps inputs, outputs and the memory of the last step, in `state` or in a new one.
///
/// # Safety
/// As of [`call`]; `state` must be null, or point to null or to a state of this function.
pub(crate) unsafe fn keep(instance: *mut c_void, state: *mut *mut c_void) -> c_int {
    let work = |unit: &mut Unit| {
        // SAFETY: as the caller says
        unsafe { put_state(state, unit.keep()) }
    };
    // SAFETY: as the caller says
    unsafe { call(instance, work) }
}

/// Goes back to a state.
///
/// # Safety
/// As of [`call`]; `state` must be null, or of [`keep`].
pub(crate) unsafe fn go_back(instance: *mut c_void, state: *mut c_void) -> c_int {
    let work = |unit: &mut Unit| {
        // SAFETY: as the caller says
        let kept = unsafe { kept(state) }?;
        Ok(unit.go_back(kept)?)
    };
    // SAFETY: as the caller says
    unsafe { call(instance, work) }
}

/// Gives a state back.
///
/// # Safety
/// As of [`call`]; `state` must be null, or point to null or to a state of [`keep`], which is not used again.
pub(crate) unsafe fn free_state(instance: *mut c_void, state: *mut *mut c_void) -> c_int {
    let work = |_: &mut Unit| {
        // SAFETY: as the caller says
        if let Some(state) = unsafe { state.as_mut() }
            && !state.is_null()
        {
            // SAFETY: as the caller says
            drop(unsafe { Box::from_raw(state.cast::<Kept>()) });
            *state = std::ptr::null_mut();
        }
        Ok(())
    };
    // SAFETY: as the caller says
    unsafe { call(instance, work) }
}

/// How many bytes a state has.
///
/// # Safety
/// As of [`go_back`] and [`give`].
pub(crate) unsafe fn state_size(
    instance: *mut c_void,
    state: *mut c_void,
    size: *mut usize,
) -> c_int {
    let work = |unit: &mut Unit| {
        // SAFETY: as the caller says
        let kept = unsafe { kept(state) }?;
        // SAFETY: as the caller says
        Ok(unsafe { put("size", size, unit.write(kept).len()) }?)
    };
    // SAFETY: as the caller says
    unsafe { call(instance, work) }
}

/// A state as bytes.
///
/// # Safety
/// As of [`go_back`] and [`give`].
pub(crate) unsafe fn state_bytes(
    instance: *mut c_void,
    state: *mut c_void,
    (bytes, size): (*mut u8, usize),
) -> c_int {
    let work = |unit: &mut Unit| {
        // SAFETY: as the caller says
        let found = unit.write(unsafe { kept(state) }?);
        if found.len() > size {
            let wanted = found.len();
            return Err(format!("there is room for {size} bytes: the state has {wanted}").into());
        }
        // SAFETY: there is at least so much room
        Ok(unsafe { give("the room for bytes", bytes, found.len(), &found) }?)
    };
    // SAFETY: as the caller says
    unsafe { call(instance, work) }
}

/// The state that [`state_bytes`] made bytes of.
///
/// # Safety
/// As of [`take`] and [`keep`].
pub(crate) unsafe fn state_of(
    instance: *mut c_void,
    (bytes, size): (*const u8, usize),
    state: *mut *mut c_void,
) -> c_int {
    let work = |unit: &mut Unit| {
        // SAFETY: as the caller says
        let kept = unit.read(unsafe { take("the bytes", bytes, size) }?)?;
        // SAFETY: as the caller says
        unsafe { put_state(state, kept) }
    };
    // SAFETY: as the caller says
    unsafe { call(instance, work) }
}

/// # Safety
/// As of [`keep`].
unsafe fn put_state(state: *mut *mut c_void, kept: Kept) -> Result<(), Failure> {
    // SAFETY: as the caller says
    let Some(state) = (unsafe { state.as_mut() }) else {
        return Err("state is null".to_owned().into());
    };
    // SAFETY: as the caller says; a state is written anew
    match unsafe { state.cast::<Kept>().as_mut() } {
        Some(old) => *old = kept,
        None => *state = Box::into_raw(Box::new(kept)).cast(),
    }
    Ok(())
}

/// # Safety
/// As of [`go_back`].
unsafe fn kept<'a>(state: *mut c_void) -> Result<&'a Kept, String> {
    // SAFETY: as the caller says
    unsafe { state.cast::<Kept>().as_ref() }.ok_or_else(|| "state is null".to_owned())
}

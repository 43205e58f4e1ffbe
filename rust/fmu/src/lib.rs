// SPDX-License-Identifier: MIT OR Apache-2.0
//! Prepared sliding contacts as functional mock-up units: FMI 2.0, co-simulation [Blochwitz2012].
//!
//! **What.** The functions of the FMI standard over one contact that Python prepared. The unit holds it as
//! `resources/contact.mtbc`; `PreparedContact.save_fmu` packs it with this library and the
//! description of the variables.
//!
//! **Not here.** No mechanics: a step reads the inputs, calls [`mtb_contact::prepared`] and keeps the outputs.
//!
//! **Conventions.** SI units; forces on the lower body. Inputs start as the description says, from
//! `resources/starts.txt`; what is no input there is left to balance (pose) or to the scene (magnetic pressure). Messages go to the logger of the importing program.
//!
//! Unsafe code is allowed in this crate for two things: names that a loader finds, and the pointers of the
//! importing program, which are checked against null here and must otherwise be as the standard says.

#![allow(
    unsafe_code,
    reason = "exported names and the pointers of the importing program; nothing else"
)]
#![allow(non_snake_case, reason = "the names are the standard's")]

mod variables;

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;

use mtb_contact::prepared::{Prepared, PreparedContact, Pull, Step};
use mtb_operator::{ready_workers, unmonitored};
use percent_encoding::percent_decode_str;

use mtb_words::Short;
use variables::{INPUTS, OUTPUTS, Values};

const OK: c_int = 0;
const DISCARD: c_int = 2;
const ERROR: c_int = 3;
const CO_SIMULATION: c_int = 1;
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;
/// What the identifier of a unit begins with whose description fits this library.
const FITTING: &str = concat!("mtb-fmu-", env!("CARGO_PKG_VERSION"), "-");

type Logger =
    unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions`.
#[repr(C)]
pub struct Callbacks {
    logger: Option<Logger>,
    allocate: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    free: Option<unsafe extern "C" fn(*mut c_void)>,
    step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    environment: *mut c_void,
}

/// Where messages go.
struct Log {
    logger: Option<Logger>,
    environment: *mut c_void,
    name: CString,
}

/// One instance of a unit.
struct Unit {
    log: Log,
    contact: PreparedContact,
    /// Inputs as the description has them.
    starts: Values,
    values: Values,
    /// Pressures of the last step, from which the next one starts.
    last: Option<Vec<f64>>,
    is_initialising: bool,
    time: f64,
}

/// What `fmi2GetFMUstate` keeps.
struct Kept {
    values: Values,
    last: Option<Vec<f64>>,
    is_initialising: bool,
    time: f64,
}

/// Why a call did not do what it should.
struct Failure(c_int, String);

impl Failure {
    fn error(message: impl Into<String>) -> Self {
        Self(ERROR, message.into())
    }
}

impl Log {
    fn write(&self, status: c_int, message: &str) {
        let Some(logger) = self.logger else {
            return;
        };
        // the message itself is the format: not every importing program formats what follows it
        let text = message.replace('\0', " ").replace('%', "%%");
        let text = CString::new(text).unwrap_or_default();
        let category = if status == DISCARD {
            c"logStatusDiscard"
        } else {
            c"logStatusError"
        };
        // SAFETY: the logger of the importing program; the format takes no arguments
        unsafe {
            logger(
                self.environment,
                self.name.as_ptr(),
                status,
                category.as_ptr(),
                text.as_ptr(),
            );
        }
    }
}

impl Unit {
    /// Solves the contact at the inputs.
    fn solve(&mut self) -> Result<(), Failure> {
        let pull = match self.values.magnetic_pressure() {
            p if p.is_nan() => Pull::Scene,
            p => Pull::Uniform(p),
        };
        let step = Step {
            pose: self.values.pose(),
            velocity: self.values.velocity(),
            pull,
            gap: None,
            friction: None,
            diagonal: None,
        };
        let out = self
            .contact
            .step(&step, &unmonitored)
            .map_err(|error| Failure::error(error.to_string()))?;
        if let Some(why) = out.unsolved() {
            return Err(Failure::error(why));
        }
        let prepared = self.contact.prepared();
        let mean = prepared.geometry.mean_tractions(&out.solution.pressure);
        let peak = mean.iter().copied().fold(0.0, f64::max);
        self.values
            .keep(out.force, out.moment, out.friction_power, peak);
        self.last = Some(out.solution.pressure);
        Ok(())
    }

    /// Forgets all steps.
    fn forget(&mut self) {
        self.contact = PreparedContact::new(self.contact.prepared().clone());
        self.last = None;
    }
}

/// Runs the work of a call on a unit: no panic leaves, and what went wrong goes to its logger.
fn call(unit: *mut Unit, work: impl FnOnce(&mut Unit) -> Result<(), Failure>) -> c_int {
    // SAFETY: null is no unit; else it came from `fmi2Instantiate`, and one thread at a time uses it
    let Some(unit) = (unsafe { unit.as_mut() }) else {
        return ERROR;
    };
    let done = catch_unwind(AssertUnwindSafe(|| {
        ready_workers();
        work(unit)
    }))
    .unwrap_or_else(|_| {
        unit.forget();
        Err(Failure::error(
            "internal fault; the contact forgets its last step",
        ))
    });
    match done {
        Ok(()) => OK,
        Err(Failure(status, message)) => {
            unit.log.write(status, &message);
            status
        }
    }
}

fn refused(unit: *mut Unit, what: &str) -> c_int {
    call(unit, |_| {
        Err(Failure::error(format!("{what}: a contact has none")))
    })
}

/// The caller's array of `length` values.
fn take<'a, T>(name: &str, from: *const T, length: usize) -> Result<&'a [T], Failure> {
    if length == 0 {
        return Ok(&[]);
    }
    if from.is_null() {
        return Err(Failure::error(format!("{name} is null")));
    }
    // SAFETY: not null, and the caller vouches for `length` readable values during the call
    Ok(unsafe { std::slice::from_raw_parts(from, length) })
}

/// Writes `value` to the `index`th place of the caller.
fn put<T>(name: &str, to: *mut T, index: usize, value: T) -> Result<(), Failure> {
    if to.is_null() {
        return Err(Failure::error(format!("{name} is null")));
    }
    // SAFETY: not null, and the caller vouches for as many writable values as it asked for
    unsafe { to.add(index).write(value) };
    Ok(())
}

/// The caller's text, lossily; empty for null.
fn text(from: *const c_char) -> String {
    if from.is_null() {
        return String::new();
    }
    // SAFETY: not null, and the caller vouches for the zero at its end
    unsafe { CStr::from_ptr(from) }
        .to_string_lossy()
        .into_owned()
}

/// The contact, and the first inputs, in the folder of resources that a `file:` address names.
fn resource(address: &str) -> Result<(Prepared, Values), Failure> {
    let bad = |why: &dyn std::fmt::Display| {
        Failure::error(format!(
            "contact.mtbc and starts.txt in resources {address:?}: {why}"
        ))
    };
    let path = address
        .strip_prefix("file://")
        .or_else(|| address.strip_prefix("file:"))
        .ok_or_else(|| bad(&"a file: address is needed"))?;
    let path = percent_decode_str(path)
        .decode_utf8()
        .map_err(|error| bad(&error))?;
    let path = if cfg!(windows) {
        path.trim_start_matches('/')
    } else {
        path.strip_prefix("localhost").unwrap_or(&path)
    };
    let folder = PathBuf::from(path);
    let bytes = std::fs::read(folder.join("contact.mtbc")).map_err(|error| bad(&error))?;
    let prepared = Prepared::from_bytes(&bytes).map_err(|error| bad(&error))?;
    let starts = std::fs::read_to_string(folder.join("starts.txt")).map_err(|error| bad(&error))?;
    let starts = Values::starting(&starts)
        .ok_or_else(|| bad(&"lines of a value reference and a number are needed"))?;
    Ok((prepared, starts))
}

/// `fmi2GetTypesPlatform`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

/// `fmi2GetVersion`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// `fmi2Instantiate`: null, with a message to the logger, where the unit cannot be.
///
/// # Safety
/// The arguments must be as the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    name: *const c_char,
    kind: c_int,
    identifier: *const c_char,
    resources: *const c_char,
    callbacks: *const Callbacks,
    _visible: c_int,
    _logging: c_int,
) -> *mut c_void {
    // SAFETY: null, or as the standard says
    let callbacks = unsafe { callbacks.as_ref() };
    let log = Log {
        logger: callbacks.and_then(|c| c.logger),
        environment: callbacks.map_or(std::ptr::null_mut(), |c| c.environment),
        name: CString::new(text(name)).unwrap_or_default(),
    };
    let (identifier, resources) = (text(identifier), text(resources));
    let made = catch_unwind(|| {
        if kind != CO_SIMULATION {
            return Err(Failure::error(
                "asked for model exchange: a contact has no state to integrate, co-simulation is needed",
            ));
        }
        if !identifier.starts_with(FITTING) {
            return Err(Failure::error(format!(
                "the description's guid is {identifier:?}: {FITTING}... is needed, as the version of mtb_rs \
                 that built this library writes it"
            )));
        }
        resource(&resources)
    })
    .unwrap_or_else(|_| Err(Failure::error("internal fault")));
    match made {
        Ok((prepared, starts)) => {
            let unit = Unit {
                log,
                contact: PreparedContact::new(Arc::new(prepared)),
                values: starts.clone(),
                starts,
                last: None,
                is_initialising: true,
                time: 0.0,
            };
            Box::into_raw(Box::new(unit)).cast()
        }
        Err(Failure(status, message)) => {
            log.write(status, &message);
            std::ptr::null_mut()
        }
    }
}

/// `fmi2FreeInstance`.
///
/// # Safety
/// The unit must be one that `fmi2Instantiate` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(unit: *mut c_void) {
    if !unit.is_null() {
        // SAFETY: made by `fmi2Instantiate`, and not used again
        drop(unsafe { Box::from_raw(unit.cast::<Unit>()) });
    }
}

/// `fmi2SetDebugLogging`: errors are always logged, nothing else is.
///
/// # Safety
/// The unit must be one that `fmi2Instantiate` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    unit: *mut c_void,
    _on: c_int,
    _count: usize,
    _categories: *const *const c_char,
) -> c_int {
    call(unit.cast(), |_| Ok(()))
}

/// `fmi2SetupExperiment`: a contact knows no tolerance and no end.
///
/// # Safety
/// The unit must be one that `fmi2Instantiate` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    unit: *mut c_void,
    _tolerance_defined: c_int,
    _tolerance: f64,
    start: f64,
    _stop_defined: c_int,
    _stop: f64,
) -> c_int {
    call(unit.cast(), |unit| {
        if !start.is_finite() {
            return Err(Failure::error(format!(
                "the start time is {}: a finite number is needed",
                Short(start)
            )));
        }
        unit.time = start;
        Ok(())
    })
}

/// `fmi2EnterInitializationMode`.
///
/// # Safety
/// The unit must be one that `fmi2Instantiate` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(unit: *mut c_void) -> c_int {
    call(unit.cast(), |_| Ok(()))
}

/// `fmi2ExitInitializationMode`: solves the contact at the first inputs.
///
/// # Safety
/// The unit must be one that `fmi2Instantiate` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(unit: *mut c_void) -> c_int {
    call(unit.cast(), |unit| {
        unit.solve()?;
        unit.is_initialising = false;
        Ok(())
    })
}

/// `fmi2Terminate`.
///
/// # Safety
/// The unit must be one that `fmi2Instantiate` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(unit: *mut c_void) -> c_int {
    call(unit.cast(), |_| Ok(()))
}

/// `fmi2Reset`: as just instantiated.
///
/// # Safety
/// The unit must be one that `fmi2Instantiate` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(unit: *mut c_void) -> c_int {
    call(unit.cast(), |unit| {
        unit.forget();
        unit.values = unit.starts.clone();
        unit.is_initialising = true;
        unit.time = 0.0;
        Ok(())
    })
}

/// `fmi2GetReal`; before the end of the initialisation outputs are those of the inputs set so far.
///
/// # Safety
/// The arrays must have `count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    unit: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut f64,
) -> c_int {
    call(unit.cast(), |unit| {
        for (k, &reference) in take("references", references, count)?.iter().enumerate() {
            let index = reference as usize;
            if unit.is_initialising && OUTPUTS.contains(&index) {
                unit.solve()?;
            }
            let value = unit.values.get(index).ok_or_else(|| unknown(reference))?;
            put("values", values, k, value)?;
        }
        Ok(())
    })
}

/// `fmi2SetReal`, of inputs that the description has, to finite numbers.
///
/// # Safety
/// The arrays must have `count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    unit: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const f64,
) -> c_int {
    call(unit.cast(), |unit| {
        let references = take("references", references, count)?;
        let values = take("values", values, count)?;
        if let Some(&reference) = references
            .iter()
            .find(|r| !unit.values.is_input(**r as usize))
        {
            return Err(unknown(reference));
        }
        if let Some((&reference, &value)) =
            (references.iter().zip(values)).find(|(_, value)| !value.is_finite())
        {
            return Err(Failure::error(format!(
                "value reference {reference} is {}: a finite number is needed",
                Short(value)
            )));
        }
        for (&reference, &value) in references.iter().zip(values) {
            unit.values.set(reference as usize, value);
        }
        Ok(())
    })
}

fn unknown(reference: u32) -> Failure {
    if INPUTS.contains(&(reference as usize)) {
        return Failure::error(format!(
            "value reference {reference} is no input of this unit: its description has no such variable"
        ));
    }
    Failure::error(format!(
        "value reference {reference}: inputs are {} to {}, outputs {} to {}",
        INPUTS.start,
        INPUTS.end - 1,
        OUTPUTS.start,
        OUTPUTS.end - 1
    ))
}

/// `fmi2DoStep`: solves the contact at the inputs, which hold over the step.
///
/// A step without a solution (wedging) is an error; outputs stay those of the last one. It is not discarded:
/// inputs hold over a step, so a shorter one has no solution either, and an importing program that takes a
/// discarded step again would do so for ever.
///
/// # Safety
/// The unit must be one that `fmi2Instantiate` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    unit: *mut c_void,
    time: f64,
    step: f64,
    _no_set_back: c_int,
) -> c_int {
    call(unit.cast(), |unit| {
        if !time.is_finite() || !step.is_finite() || step < 0.0 {
            return Err(Failure::error(format!(
                "a step of {} s from {} s: finite numbers are needed, the step not below 0",
                Short(step),
                Short(time)
            )));
        }
        unit.solve()?;
        unit.time = time + step;
        Ok(())
    })
}

/// `fmi2CancelStep`: steps end before they return.
///
/// # Safety
/// The unit must be one that `fmi2Instantiate` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(unit: *mut c_void) -> c_int {
    refused(unit.cast(), "fmi2CancelStep, steps that go on")
}

/// `fmi2GetFMUstate`: inputs, outputs and the memory of the last step.
///
/// # Safety
/// `state` must point to a state of this function, or to null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(unit: *mut c_void, state: *mut *mut c_void) -> c_int {
    call(unit.cast(), |unit| {
        // SAFETY: as the standard says
        let Some(state) = (unsafe { state.as_mut() }) else {
            return Err(Failure::error("state is null"));
        };
        let kept = Kept {
            values: unit.values.clone(),
            last: unit.last.clone(),
            is_initialising: unit.is_initialising,
            time: unit.time,
        };
        // SAFETY: null, or a state of this function that is written anew
        match unsafe { state.cast::<Kept>().as_mut() } {
            Some(old) => *old = kept,
            None => *state = Box::into_raw(Box::new(kept)).cast(),
        }
        Ok(())
    })
}

/// `fmi2SetFMUstate`.
///
/// # Safety
/// `state` must be of `fmi2GetFMUstate`, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(unit: *mut c_void, state: *mut c_void) -> c_int {
    call(unit.cast(), |unit| {
        // SAFETY: null, or a state of `fmi2GetFMUstate`
        let Some(kept) = (unsafe { state.cast::<Kept>().as_ref() }) else {
            return Err(Failure::error("state is null"));
        };
        unit.forget();
        unit.values = kept.values.clone();
        unit.is_initialising = kept.is_initialising;
        unit.time = kept.time;
        if let Some(pressure) = &kept.last {
            unit.contact
                .resume(pressure, &[], None)
                .map_err(|error| Failure::error(error.to_string()))?;
        }
        unit.last.clone_from(&kept.last);
        Ok(())
    })
}

/// `fmi2FreeFMUstate`.
///
/// # Safety
/// `state` must point to a state of `fmi2GetFMUstate`, or to null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(unit: *mut c_void, state: *mut *mut c_void) -> c_int {
    call(unit.cast(), |_| {
        // SAFETY: as the standard says
        if let Some(state) = unsafe { state.as_mut() }
            && !state.is_null()
        {
            // SAFETY: made by `fmi2GetFMUstate`, and not used again
            drop(unsafe { Box::from_raw(state.cast::<Kept>()) });
            *state = std::ptr::null_mut();
        }
        Ok(())
    })
}

/// `fmi2GetRealStatus`: the time up to which steps were solved.
///
/// # Safety
/// `value` must point to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(
    unit: *mut c_void,
    kind: c_int,
    value: *mut f64,
) -> c_int {
    call(unit.cast(), |unit| {
        if kind != LAST_SUCCESSFUL_TIME {
            return Err(Failure(
                DISCARD,
                format!("status kind {kind} is no real number"),
            ));
        }
        put("value", value, 0, unit.time)
    })
}

/// `fmi2GetBooleanStatus`: a contact never ends a simulation by itself.
///
/// # Safety
/// `value` must point to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    unit: *mut c_void,
    kind: c_int,
    value: *mut c_int,
) -> c_int {
    call(unit.cast(), |_| {
        if kind != TERMINATED {
            return Err(Failure(
                DISCARD,
                format!("status kind {kind} is no truth value"),
            ));
        }
        put("value", value, 0, 0)
    })
}

/// `fmi2GetDirectionalDerivative`: exact derivatives of outputs by inputs at the last step.
///
/// The points in contact stay the same. Before the end of the initialisation, and after a state was set, they are
/// those at the inputs.
///
/// # Safety
/// The arrays must have as many entries as the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    unit: *mut c_void,
    unknowns: *const u32,
    n: usize,
    knowns: *const u32,
    m: usize,
    seed: *const f64,
    out: *mut f64,
) -> c_int {
    call(unit.cast(), |unit| {
        let unknowns = take("unknowns", unknowns, n)?;
        let knowns = take("knowns", knowns, m)?;
        let seed = take("seed", seed, m)?;
        if let Some(&reference) = unknowns.iter().find(|r| !OUTPUTS.contains(&(**r as usize))) {
            return Err(unknown(reference));
        }
        if let Some(&reference) = knowns.iter().find(|r| !unit.values.is_input(**r as usize)) {
            return Err(unknown(reference));
        }
        if unit.is_initialising || unit.contact.taken().is_none() {
            unit.solve()?;
        }
        let jacobian = (unit.contact.jacobian(&unmonitored))
            .map_err(|error| Failure::error(error.to_string()))?;
        for (k, &reference) in unknowns.iter().enumerate() {
            let row = &jacobian[reference as usize - OUTPUTS.start];
            let along = knowns.iter().zip(seed);
            let sum = along.map(|(&known, seed)| row[known as usize] * seed).sum();
            put("out", out, k, sum)?;
        }
        Ok(())
    })
}

/// Functions of the standard for what a contact has not; all of them refuse.
macro_rules! refuse {
    ($($name:ident($($argument:ident: $type:ty),*): $what:literal;)*) => {$(
        #[doc = concat!("`", stringify!($name), "`: ", $what, ", refused.")]
        ///
        /// # Safety
        /// The unit must be one that `fmi2Instantiate` made, or null.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(unit: *mut c_void $(, $argument: $type)*) -> c_int {
            $(let _ = $argument;)*
            refused(unit.cast(), concat!(stringify!($name), ", ", $what))
        }
    )*};
}

refuse! {
    fmi2SetRealInputDerivatives(references: *const u32, count: usize, order: *const c_int, values: *const f64):
        "derivatives of inputs";
    fmi2GetRealOutputDerivatives(references: *const u32, count: usize, order: *const c_int, values: *mut f64):
        "derivatives of outputs";
    fmi2SerializedFMUstateSize(state: *mut c_void, size: *mut usize): "states as bytes";
    fmi2SerializeFMUstate(state: *mut c_void, bytes: *mut c_char, size: usize): "states as bytes";
    fmi2DeSerializeFMUstate(bytes: *const c_char, size: usize, state: *mut *mut c_void): "states as bytes";
    fmi2GetStatus(kind: c_int, value: *mut c_int): "steps that go on";
    fmi2GetIntegerStatus(kind: c_int, value: *mut c_int): "steps that go on";
    fmi2GetStringStatus(kind: c_int, value: *mut *const c_char): "steps that go on";
}

/// Functions of the standard for variables of kinds that a contact has none of.
macro_rules! none_of {
    ($($name:ident: $type:ty;)*) => {$(
        #[doc = concat!("`", stringify!($name), "`, of no variables.")]
        ///
        /// # Safety
        /// The unit must be one that `fmi2Instantiate` made, or null.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            unit: *mut c_void,
            _references: *const u32,
            count: usize,
            _values: $type,
        ) -> c_int {
            call(unit.cast(), |_| match count {
                0 => Ok(()),
                _ => Err(Failure::error(concat!(
                    stringify!($name), ": all variables are real"
                ))),
            })
        }
    )*};
}

none_of! {
    fmi2GetInteger: *mut c_int;
    fmi2GetBoolean: *mut c_int;
    fmi2GetString: *mut *const c_char;
    fmi2SetInteger: *const c_int;
    fmi2SetBoolean: *const c_int;
    fmi2SetString: *const *const c_char;
}

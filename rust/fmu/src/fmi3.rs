// SPDX-License-Identifier: MIT OR Apache-2.0
//! The functions of FMI 3.0 [ModelicaAssociation2022]. Variables may be arrays.
//!
//! A truth value of the caller is taken as a byte, of which anything but 0 is true.

use std::ffi::{CString, c_char, c_int, c_void};
use std::path::Path;

use crate::instance::{
    self, Log, call, category, derive, free, go_back, instantiate, put, state_bytes, state_of,
    state_size, text,
};
use crate::resources::unit_in;
use crate::unit::Unit;

type LogMessage = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

fn log_to(logger: Option<LogMessage>, environment: *mut c_void) -> Log {
    Box::new(move |status, message| {
        let Some(logger) = logger else {
            return;
        };
        let text = CString::new(message.replace('\0', " ")).unwrap_or_default();
        // SAFETY: the logger of the importing program
        unsafe {
            logger(
                environment,
                status,
                category(status).as_ptr(),
                text.as_ptr(),
            );
        }
    })
}

/// `fmi3GetVersion`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// `fmi3InstantiateCoSimulation`: null, with a message to the logger, where the unit cannot be.
///
/// # Safety
/// The arguments must be as the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: u8,
    _logging: u8,
    event_mode_used: u8,
    _early_return_allowed: u8,
    _intermediate: *const u32,
    intermediate_count: usize,
    environment: *mut c_void,
    logger: Option<LogMessage>,
    _intermediate_update: *const c_void,
) -> *mut c_void {
    // SAFETY: null, or as the standard says
    let (token, resources) = unsafe { (text(token), text(resources)) };
    instantiate(log_to(logger, environment), || {
        if event_mode_used != 0 {
            return Err("asked for an event mode: a contact has no events".to_owned());
        }
        if intermediate_count != 0 {
            return Err(
                "asked for variables within a step: a contact is solved once a step".to_owned(),
            );
        }
        unit_in(Path::new(&resources), "instantiationToken", &token)
    })
}

/// `fmi3InstantiateModelExchange`: null, with a message to the logger.
///
/// # Safety
/// The arguments must be as the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    _name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: u8,
    _logging: u8,
    environment: *mut c_void,
    logger: Option<LogMessage>,
) -> *mut c_void {
    instantiate(log_to(logger, environment), || {
        Err(
            "asked for model exchange: a contact has no state to integrate, co-simulation is needed"
                .to_owned(),
        )
    })
}

/// `fmi3InstantiateScheduledExecution`: null, with a message to the logger.
///
/// # Safety
/// The arguments must be as the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: u8,
    _logging: u8,
    environment: *mut c_void,
    logger: Option<LogMessage>,
    _clock_update: *const c_void,
    _lock: *const c_void,
    _unlock: *const c_void,
) -> *mut c_void {
    instantiate(log_to(logger, environment), || {
        Err(
            "asked for scheduled execution: a contact has no clocks, co-simulation is needed"
                .to_owned(),
        )
    })
}

/// `fmi3FreeInstance`.
///
/// # Safety
/// The unit must be one that `fmi3InstantiateCoSimulation` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(unit: *mut c_void) {
    // SAFETY: as the caller says
    unsafe { free(unit) };
}

/// `fmi3SetDebugLogging`: errors are always logged, nothing else is.
///
/// # Safety
/// The unit must be one that `fmi3InstantiateCoSimulation` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    unit: *mut c_void,
    _on: u8,
    _count: usize,
    _categories: *const *const c_char,
) -> c_int {
    // SAFETY: as the caller says
    unsafe { call(unit, |_| Ok(())) }
}

/// `fmi3EnterInitializationMode`: a contact knows no tolerance and no end.
///
/// # Safety
/// The unit must be one that `fmi3InstantiateCoSimulation` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    unit: *mut c_void,
    _tolerance_defined: u8,
    _tolerance: f64,
    start: f64,
    _stop_defined: u8,
    _stop: f64,
) -> c_int {
    // SAFETY: as the caller says
    unsafe { call(unit, |unit| Ok(unit.start_at(start)?)) }
}

/// `fmi3ExitInitializationMode`: solves the contact at the first inputs.
///
/// # Safety
/// The unit must be one that `fmi3InstantiateCoSimulation` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(unit: *mut c_void) -> c_int {
    // SAFETY: as the caller says
    unsafe { call(unit, |unit| Ok(unit.end_initialisation()?)) }
}

/// `fmi3Terminate`.
///
/// # Safety
/// The unit must be one that `fmi3InstantiateCoSimulation` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(unit: *mut c_void) -> c_int {
    // SAFETY: as the caller says
    unsafe { call(unit, |_| Ok(())) }
}

/// `fmi3Reset`: as just instantiated.
///
/// # Safety
/// The unit must be one that `fmi3InstantiateCoSimulation` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(unit: *mut c_void) -> c_int {
    let work = |unit: &mut Unit| {
        unit.reset();
        Ok(())
    };
    // SAFETY: as the caller says
    unsafe { call(unit, work) }
}

/// `fmi3GetFloat64`; before the end of the initialisation outputs are those of the inputs set so far.
///
/// # Safety
/// The arrays must have `count` and `length` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    unit: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut f64,
    length: usize,
) -> c_int {
    // SAFETY: as the caller says
    unsafe { instance::get(unit, (references, count), (values, length)) }
}

/// `fmi3SetFloat64`, of inputs that the description has, to finite numbers.
///
/// # Safety
/// The arrays must have `count` and `length` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    unit: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const f64,
    length: usize,
) -> c_int {
    // SAFETY: as the caller says
    unsafe { instance::set(unit, (references, count), (values, length)) }
}

/// `fmi3DoStep`: solves the contact at the inputs, which hold over the step.
///
/// A step without a solution (wedging) is an error; outputs stay those of the last one.
///
/// # Safety
/// The last four arguments must point to values that can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    unit: *mut c_void,
    time: f64,
    step: f64,
    _no_set_back: u8,
    event_needed: *mut bool,
    terminate: *mut bool,
    early_return: *mut bool,
    last_successful_time: *mut f64,
) -> c_int {
    let work = |unit: &mut Unit| {
        let solved = unit.advance(time, step);
        // SAFETY: as the caller says
        unsafe {
            put("eventHandlingNeeded", event_needed, false)?;
            put("terminateSimulation", terminate, false)?;
            put("earlyReturn", early_return, false)?;
            put("lastSuccessfulTime", last_successful_time, unit.time())?;
        }
        Ok(solved?)
    };
    // SAFETY: as the caller says
    unsafe { call(unit, work) }
}

/// `fmi3GetFMUState`: inputs, outputs and the memory of the last step.
///
/// # Safety
/// `state` must point to a state of this function, or to null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(unit: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: as the caller says
    unsafe { instance::keep(unit, state) }
}

/// `fmi3SetFMUState`.
///
/// # Safety
/// `state` must be of `fmi3GetFMUState`, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(unit: *mut c_void, state: *mut c_void) -> c_int {
    // SAFETY: as the caller says
    unsafe { go_back(unit, state) }
}

/// `fmi3FreeFMUState`.
///
/// # Safety
/// `state` must point to a state of `fmi3GetFMUState`, or to null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(unit: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: as the caller says
    unsafe { instance::free_state(unit, state) }
}

/// `fmi3SerializedFMUStateSize`.
///
/// # Safety
/// `state` must be of `fmi3GetFMUState`, or null, `size` must point to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(
    unit: *mut c_void,
    state: *mut c_void,
    size: *mut usize,
) -> c_int {
    // SAFETY: as the caller says
    unsafe { state_size(unit, state, size) }
}

/// `fmi3SerializeFMUState`.
///
/// # Safety
/// `state` must be of `fmi3GetFMUState`, or null, and there must be room for `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializeFMUState(
    unit: *mut c_void,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> c_int {
    // SAFETY: as the caller says
    unsafe { state_bytes(unit, state, (bytes, size)) }
}

/// `fmi3DeserializeFMUState`.
///
/// # Safety
/// There must be `size` bytes, and `state` must point to a state of `fmi3GetFMUState`, or to null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    unit: *mut c_void,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> c_int {
    // SAFETY: as the caller says
    unsafe { state_of(unit, (bytes, size), state) }
}

/// `fmi3GetDirectionalDerivative`: exact derivatives of outputs by inputs at the last step.
///
/// The points in contact stay the same. Before the end of the initialisation they are those at the inputs.
///
/// # Safety
/// The arrays must have as many entries as the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetDirectionalDerivative(
    unit: *mut c_void,
    unknowns: *const u32,
    n: usize,
    knowns: *const u32,
    m: usize,
    seed: *const f64,
    seeds: usize,
    out: *mut f64,
    length: usize,
) -> c_int {
    // SAFETY: as the caller says
    unsafe {
        derive(
            unit,
            Unit::along,
            (unknowns, n),
            (knowns, m),
            (seed, seeds),
            (out, length),
        )
    }
}

/// `fmi3GetAdjointDerivative`: as `fmi3GetDirectionalDerivative`, from weights of outputs back to inputs.
///
/// # Safety
/// The arrays must have as many entries as the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetAdjointDerivative(
    unit: *mut c_void,
    unknowns: *const u32,
    n: usize,
    knowns: *const u32,
    m: usize,
    seed: *const f64,
    seeds: usize,
    out: *mut f64,
    length: usize,
) -> c_int {
    // SAFETY: as the caller says
    unsafe {
        derive(
            unit,
            Unit::gradient,
            (unknowns, n),
            (knowns, m),
            (seed, seeds),
            (out, length),
        )
    }
}

/// Functions of the standard for what a contact has not; all of them refuse.
macro_rules! refuse {
    ($what:literal: $($name:ident($($argument:ident: $type:ty),*);)*) => {$(
        #[doc = concat!("`", stringify!($name), "`: ", $what, ", refused.")]
        ///
        /// # Safety
        /// The unit must be one that `fmi3InstantiateCoSimulation` made, or null.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(unit: *mut c_void $(, $argument: $type)*) -> c_int {
            $(let _ = $argument;)*
            let why = concat!(stringify!($name), ", ", $what, ": a contact has none");
            // SAFETY: as the caller says
            unsafe { call(unit, |_| Err(why.to_owned().into())) }
        }
    )*};
}

refuse! {
    "an event mode":
    fmi3EnterEventMode();
    fmi3EnterStepMode();
    fmi3EvaluateDiscreteStates();
    fmi3UpdateDiscreteStates(needed: *mut bool, terminate: *mut bool, nominals: *mut bool, values: *mut bool,
        is_defined: *mut bool, time: *mut f64);
}

refuse! {
    "structural parameters":
    fmi3EnterConfigurationMode();
    fmi3ExitConfigurationMode();
}

refuse! {
    "dependencies of single elements":
    fmi3GetNumberOfVariableDependencies(reference: u32, count: *mut usize);
    fmi3GetVariableDependencies(dependent: u32, elements: *mut usize, independents: *mut u32,
        others: *mut usize, kinds: *mut c_int, count: usize);
}

refuse! {
    "derivatives of outputs by time":
    fmi3GetOutputDerivatives(references: *const u32, count: usize, orders: *const i32, values: *mut f64,
        length: usize);
}

refuse! {
    "states to integrate":
    fmi3EnterContinuousTimeMode();
    fmi3CompletedIntegratorStep(no_set_back: u8, event: *mut bool, terminate: *mut bool);
    fmi3SetTime(time: f64);
    fmi3SetContinuousStates(states: *const f64, count: usize);
    fmi3GetContinuousStateDerivatives(derivatives: *mut f64, count: usize);
    fmi3GetEventIndicators(indicators: *mut f64, count: usize);
    fmi3GetContinuousStates(states: *mut f64, count: usize);
    fmi3GetNominalsOfContinuousStates(nominals: *mut f64, count: usize);
    fmi3GetNumberOfEventIndicators(count: *mut usize);
    fmi3GetNumberOfContinuousStates(count: *mut usize);
}

refuse! {
    "clocks":
    fmi3GetClock(references: *const u32, count: usize, values: *mut bool);
    fmi3SetClock(references: *const u32, count: usize, values: *const u8);
    fmi3GetIntervalDecimal(references: *const u32, count: usize, intervals: *mut f64, kinds: *mut c_int);
    fmi3GetIntervalFraction(references: *const u32, count: usize, counters: *mut u64, resolutions: *mut u64,
        kinds: *mut c_int);
    fmi3GetShiftDecimal(references: *const u32, count: usize, shifts: *mut f64);
    fmi3GetShiftFraction(references: *const u32, count: usize, counters: *mut u64, resolutions: *mut u64);
    fmi3SetIntervalDecimal(references: *const u32, count: usize, intervals: *const f64);
    fmi3SetIntervalFraction(references: *const u32, count: usize, counters: *const u64,
        resolutions: *const u64);
    fmi3SetShiftDecimal(references: *const u32, count: usize, shifts: *const f64);
    fmi3SetShiftFraction(references: *const u32, count: usize, counters: *const u64, resolutions: *const u64);
    fmi3ActivateModelPartition(reference: u32, time: f64);
}

refuse! {
    "binary variables":
    fmi3GetBinary(references: *const u32, count: usize, sizes: *mut usize, values: *mut *const u8,
        length: usize);
    fmi3SetBinary(references: *const u32, count: usize, sizes: *const usize, values: *const *const u8,
        length: usize);
}

/// Functions of the standard for variables of kinds that a contact has none of.
macro_rules! none_of {
    ($($name:ident: $type:ty;)*) => {$(
        #[doc = concat!("`", stringify!($name), "`, of no variables.")]
        ///
        /// # Safety
        /// The unit must be one that `fmi3InstantiateCoSimulation` made, or null.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            unit: *mut c_void,
            _references: *const u32,
            count: usize,
            _values: $type,
            _length: usize,
        ) -> c_int {
            let work = |_: &mut Unit| match count {
                0 => Ok(()),
                _ => Err(concat!(stringify!($name), ": all variables are of type Float64").to_owned().into()),
            };
            // SAFETY: as the caller says
            unsafe { call(unit, work) }
        }
    )*};
}

none_of! {
    fmi3GetFloat32: *mut f32;
    fmi3GetInt8: *mut i8;
    fmi3GetUInt8: *mut u8;
    fmi3GetInt16: *mut i16;
    fmi3GetUInt16: *mut u16;
    fmi3GetInt32: *mut i32;
    fmi3GetUInt32: *mut u32;
    fmi3GetInt64: *mut i64;
    fmi3GetUInt64: *mut u64;
    fmi3GetBoolean: *mut bool;
    fmi3GetString: *mut *const c_char;
    fmi3SetFloat32: *const f32;
    fmi3SetInt8: *const i8;
    fmi3SetUInt8: *const u8;
    fmi3SetInt16: *const i16;
    fmi3SetUInt16: *const u16;
    fmi3SetInt32: *const i32;
    fmi3SetUInt32: *const u32;
    fmi3SetInt64: *const i64;
    fmi3SetUInt64: *const u64;
    fmi3SetBoolean: *const u8;
    fmi3SetString: *const *const c_char;
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! The functions of FMI 2.0 [Blochwitz2012]. Variables are single numbers.

use std::ffi::{CString, c_char, c_int, c_void};

use crate::instance::{
    self, DISCARD, Failure, Log, call, category, derive, free, go_back, instantiate, put,
    state_bytes, state_of, state_size, text,
};
use crate::resources::{folder_of, unit_in};
use crate::unit::Unit;

const CO_SIMULATION: c_int = 1;
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

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

fn log_to(callbacks: Option<&Callbacks>, name: String) -> Log {
    let logger = callbacks.and_then(|c| c.logger);
    let environment = callbacks.map_or(std::ptr::null_mut(), |c| c.environment);
    let name = CString::new(name).unwrap_or_default();
    Box::new(move |status, message| {
        let Some(logger) = logger else {
            return;
        };
        // the message itself is the format: not every importing program formats what follows it
        let text = message.replace('\0', " ").replace('%', "%%");
        let text = CString::new(text).unwrap_or_default();
        let category = category(status).as_ptr();
        // SAFETY: the logger of the importing program; the format takes no arguments
        unsafe { logger(environment, name.as_ptr(), status, category, text.as_ptr()) };
    })
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
    let (callbacks, name) = unsafe { (callbacks.as_ref(), text(name)) };
    // SAFETY: null, or as the standard says
    let (identifier, resources) = unsafe { (text(identifier), text(resources)) };
    instantiate(log_to(callbacks, name), || {
        if kind != CO_SIMULATION {
            return Err(
                "asked for model exchange: a contact has no state to integrate, co-simulation is needed"
                    .to_owned(),
            );
        }
        let unit = unit_in(&folder_of(&resources)?, "guid", &identifier)?;
        if unit.variables().are_scalar() {
            Ok(unit)
        } else {
            Err("variables of this unit are arrays: its description is of FMI 3".to_owned())
        }
    })
}

/// `fmi2FreeInstance`.
///
/// # Safety
/// The unit must be one that `fmi2Instantiate` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(unit: *mut c_void) {
    // SAFETY: as the caller says
    unsafe { free(unit) };
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
    // SAFETY: as the caller says
    unsafe { call(unit, |_| Ok(())) }
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
    // SAFETY: as the caller says
    unsafe { call(unit, |unit| Ok(unit.start_at(start)?)) }
}

/// `fmi2EnterInitializationMode`.
///
/// # Safety
/// The unit must be one that `fmi2Instantiate` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(unit: *mut c_void) -> c_int {
    // SAFETY: as the caller says
    unsafe { call(unit, |_| Ok(())) }
}

/// `fmi2ExitInitializationMode`: solves the contact at the first inputs.
///
/// # Safety
/// The unit must be one that `fmi2Instantiate` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(unit: *mut c_void) -> c_int {
    // SAFETY: as the caller says
    unsafe { call(unit, |unit| Ok(unit.end_initialisation()?)) }
}

/// `fmi2Terminate`.
///
/// # Safety
/// The unit must be one that `fmi2Instantiate` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(unit: *mut c_void) -> c_int {
    // SAFETY: as the caller says
    unsafe { call(unit, |_| Ok(())) }
}

/// `fmi2Reset`: as just instantiated.
///
/// # Safety
/// The unit must be one that `fmi2Instantiate` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(unit: *mut c_void) -> c_int {
    let work = |unit: &mut Unit| {
        unit.reset();
        Ok(())
    };
    // SAFETY: as the caller says
    unsafe { call(unit, work) }
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
    // SAFETY: as the caller says
    unsafe { instance::get(unit, (references, count), (values, count)) }
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
    // SAFETY: as the caller says
    unsafe { instance::set(unit, (references, count), (values, count)) }
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
    // SAFETY: as the caller says
    unsafe { call(unit, |unit| Ok(unit.advance(time, step)?)) }
}

/// `fmi2CancelStep`: steps end before they return.
///
/// # Safety
/// The unit must be one that `fmi2Instantiate` made, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(unit: *mut c_void) -> c_int {
    // SAFETY: as the caller says
    unsafe { refused(unit, "fmi2CancelStep, steps that go on") }
}

/// `fmi2GetFMUstate`: inputs, outputs and the memory of the last step.
///
/// # Safety
/// `state` must point to a state of this function, or to null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(unit: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: as the caller says
    unsafe { instance::keep(unit, state) }
}

/// `fmi2SetFMUstate`.
///
/// # Safety
/// `state` must be of `fmi2GetFMUstate`, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(unit: *mut c_void, state: *mut c_void) -> c_int {
    // SAFETY: as the caller says
    unsafe { go_back(unit, state) }
}

/// `fmi2FreeFMUstate`.
///
/// # Safety
/// `state` must point to a state of `fmi2GetFMUstate`, or to null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(unit: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: as the caller says
    unsafe { instance::free_state(unit, state) }
}

/// `fmi2SerializedFMUstateSize`.
///
/// # Safety
/// `state` must be of `fmi2GetFMUstate`, or null, `size` must point to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    unit: *mut c_void,
    state: *mut c_void,
    size: *mut usize,
) -> c_int {
    // SAFETY: as the caller says
    unsafe { state_size(unit, state, size) }
}

/// `fmi2SerializeFMUstate`.
///
/// # Safety
/// `state` must be of `fmi2GetFMUstate`, or null, and there must be room for `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    unit: *mut c_void,
    state: *mut c_void,
    bytes: *mut c_char,
    size: usize,
) -> c_int {
    // SAFETY: as the caller says
    unsafe { state_bytes(unit, state, (bytes.cast(), size)) }
}

/// `fmi2DeSerializeFMUstate`.
///
/// # Safety
/// There must be `size` bytes, and `state` must point to a state of `fmi2GetFMUstate`, or to null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    unit: *mut c_void,
    bytes: *const c_char,
    size: usize,
    state: *mut *mut c_void,
) -> c_int {
    // SAFETY: as the caller says
    unsafe { state_of(unit, (bytes.cast(), size), state) }
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
    let work = |unit: &mut Unit| {
        if kind != LAST_SUCCESSFUL_TIME {
            return Err(Failure(
                DISCARD,
                format!("status kind {kind} is no real number"),
            ));
        }
        // SAFETY: as the caller says
        Ok(unsafe { put("value", value, unit.time()) }?)
    };
    // SAFETY: as the caller says
    unsafe { call(unit, work) }
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
    let work = |_: &mut Unit| {
        if kind != TERMINATED {
            return Err(Failure(
                DISCARD,
                format!("status kind {kind} is no truth value"),
            ));
        }
        // SAFETY: as the caller says
        Ok(unsafe { put("value", value, 0) }?)
    };
    // SAFETY: as the caller says
    unsafe { call(unit, work) }
}

/// `fmi2GetDirectionalDerivative`: exact derivatives of outputs by inputs at the last step.
///
/// The points in contact stay the same. Before the end of the initialisation they are those at the inputs.
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
    // SAFETY: as the caller says
    unsafe {
        derive(
            unit,
            Unit::along,
            (unknowns, n),
            (knowns, m),
            (seed, m),
            (out, n),
        )
    }
}

/// # Safety
/// The unit must be one that `fmi2Instantiate` made, or null.
unsafe fn refused(unit: *mut c_void, what: &str) -> c_int {
    // SAFETY: as the caller says
    unsafe { call(unit, |_| Err(format!("{what}: a contact has none").into())) }
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
            // SAFETY: as the caller says
            unsafe { refused(unit, concat!(stringify!($name), ", ", $what)) }
        }
    )*};
}

refuse! {
    fmi2SetRealInputDerivatives(references: *const u32, count: usize, order: *const c_int, values: *const f64):
        "derivatives of inputs";
    fmi2GetRealOutputDerivatives(references: *const u32, count: usize, order: *const c_int, values: *mut f64):
        "derivatives of outputs";
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
            let work = |_: &mut Unit| match count {
                0 => Ok(()),
                _ => Err(concat!(stringify!($name), ": all variables are real").to_owned().into()),
            };
            // SAFETY: as the caller says
            unsafe { call(unit, work) }
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

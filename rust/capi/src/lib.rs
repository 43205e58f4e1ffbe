// SPDX-License-Identifier: MIT OR Apache-2.0
//! The C interface of prepared sliding contacts and of wheels on rails.
//!
//! **What.** Handles of contacts and wheels that Python prepared and wrote to a file: load, step, read fields,
//! free. The header `include/mtb.h` is generated from this crate.
//!
//! **Not here.** No mechanics: a function checks its pointers, calls [`mtb_contact::prepared`] or
//! [`mtb_wheelset`], copies out.
//!
//! **Conventions.** SI units; forces on the lower body. Every function returns an [`MtbStatus`] and leaves a
//! message on the calling thread. Arrays are the caller's, of the length stated; matrices are
//! component by component, as in Python: `(3, n)`.
//!
//! Unsafe code is allowed in this crate alone, for two things: names that a linker finds, and the
//! caller's pointers, which are checked against null here and must otherwise be as documented.

#![allow(
    unsafe_code,
    reason = "exported names and the pointers of C callers; nothing else"
)]

mod registry;
#[cfg(test)]
mod tests;
pub mod wheels;

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use mtb_complementarity::linear::Status;
use mtb_contact::coupled::PointState;
use mtb_contact::prepared::{Prepared, Pull, Step};
use mtb_operator::{ready_workers, unmonitored};

use registry::{CONTACTS, Contact, Last, Registry, Stepped, lock, no_step};

/// How a call ended.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MtbStatus {
    /// All is well.
    Ok = 0,
    /// An argument cannot be: the message says which.
    BadArgument = 1,
    /// The file cannot be read, or does not hold what is to be loaded.
    BadFile = 2,
    /// No sliding state exists: the body wedges.
    NoSolution = 3,
    /// The resultant of the load lies outside the contact, no height carries the force of the wheels, or no
    /// solution was found.
    NotConverged = 4,
    /// A fault of this library.
    Internal = 5,
}

/// What a step took.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct MtbEffort {
    /// Active sets.
    pub sets: u64,
    /// Factorisations.
    pub factorisations: u64,
    /// Products with the influence matrix, and solves with its factors.
    pub products: u64,
    /// Relative complementarity residual.
    pub residual: f64,
}

pub(crate) struct Failure(MtbStatus, String);

impl Failure {
    fn argument(message: impl Into<String>) -> Self {
        Self(MtbStatus::BadArgument, message.into())
    }
}

impl From<mtb_contact::Error> for Failure {
    fn from(error: mtb_contact::Error) -> Self {
        Self::argument(error.to_string())
    }
}

thread_local! {
    static MESSAGE: RefCell<CString> = RefCell::default();
}

/// Runs the work of a call: no panic leaves, and the message is kept for this thread.
fn call(work: impl FnOnce() -> Result<(), Failure>) -> MtbStatus {
    let done = catch_unwind(AssertUnwindSafe(|| {
        ready_workers();
        work()
    }))
    .unwrap_or_else(|_| {
        Err(Failure(
            MtbStatus::Internal,
            "internal fault; the last step is forgotten".to_owned(),
        ))
    });
    let (status, message) = match done {
        Ok(()) => (MtbStatus::Ok, String::new()),
        Err(Failure(status, message)) => (status, message),
    };
    // a thread that ends has lost its message before the last of its own calls: the status stands alone
    let _ = MESSAGE.try_with(|kept| *kept.borrow_mut() = CString::new(message).unwrap_or_default());
    status
}

/// Whether the caller's array takes `count` entries. Looked at before anything is written, so that a call
/// that fails leaves arrays as they were.
fn check_room<T>(name: &str, count: usize, to: *const T, length: usize) -> Result<(), Failure> {
    if length != count {
        return Err(Failure::argument(format!(
            "{name} has room for {length} numbers, there are {count}"
        )));
    }
    if to.is_null() {
        return Err(Failure::argument(format!("{name} is null")));
    }
    Ok(())
}

/// [`check_room`] for an array that a null pointer leaves out.
fn check_room_if_wanted<T>(
    name: &str,
    count: usize,
    to: *const T,
    length: usize,
) -> Result<(), Failure> {
    if to.is_null() {
        return Ok(());
    }
    check_room(name, count, to, length)
}

/// [`copy_out`] to an array that a null pointer leaves out.
fn copy_out_if_wanted<T: Copy>(
    name: &str,
    values: &[T],
    to: *mut T,
    length: usize,
) -> Result<(), Failure> {
    if to.is_null() {
        return Ok(());
    }
    copy_out(name, values, to, length)
}

/// [`put`] through a pointer that leaves the number out where it is null.
fn put_if_wanted<T>(value: T, to: *mut T) {
    if !to.is_null() {
        // SAFETY: not null, and the caller vouches that it points to such a number
        unsafe { to.write(value) };
    }
}

/// Copies `values` to the caller's array of `length` numbers.
fn copy_out<T: Copy>(name: &str, values: &[T], to: *mut T, length: usize) -> Result<(), Failure> {
    check_room(name, values.len(), to, length)?;
    // SAFETY: not null, and the caller vouches for `length` writable numbers
    unsafe { std::slice::from_raw_parts_mut(to, length) }.copy_from_slice(values);
    Ok(())
}

/// The caller's array of `length` numbers.
fn take<'a>(name: &str, from: *const f64, length: usize) -> Result<&'a [f64], Failure> {
    if length == 0 {
        return Ok(&[]);
    }
    if from.is_null() {
        return Err(Failure::argument(format!("{name} is null")));
    }
    // a negative length, read without its sign
    if length > isize::MAX as usize / size_of::<f64>() {
        return Err(Failure::argument(format!(
            "{name} cannot hold {length} numbers"
        )));
    }
    // SAFETY: not null, and the caller vouches for `length` readable numbers during the call
    Ok(unsafe { std::slice::from_raw_parts(from, length) })
}

/// Writes a number through the caller's pointer.
fn put<T>(name: &str, value: T, to: *mut T) -> Result<(), Failure> {
    if to.is_null() {
        return Err(Failure::argument(format!("{name} is null")));
    }
    // SAFETY: not null, and the caller vouches that it points to such a number
    unsafe { to.write(value) };
    Ok(())
}

/// The path and what the file there holds.
fn read<'a>(path: *const c_char) -> Result<(&'a str, Vec<u8>), Failure> {
    if path.is_null() {
        return Err(Failure::argument("path is null"));
    }
    // SAFETY: not null, and the caller vouches for the zero at its end during the call
    let path = unsafe { CStr::from_ptr(path) }
        .to_str()
        .map_err(|_| Failure::argument("path is not UTF-8"))?;
    let bytes = std::fs::read(path).map_err(|error| unreadable(path, &error))?;
    Ok((path, bytes))
}

fn unreadable(path: &str, error: &dyn std::fmt::Display) -> Failure {
    Failure(MtbStatus::BadFile, format!("{path}: {error}"))
}

/// Registers a thing and writes its handle through the caller's pointer.
fn keep<T: Stepped>(
    name: &str,
    registry: &Registry<T>,
    thing: T,
    to: *mut u64,
) -> Result<(), Failure> {
    if to.is_null() {
        return Err(Failure::argument(format!("{name} is null")));
    }
    put(name, registry.insert(thing), to)
}

/// Version of the library, for example "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn mtb_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// Why the last call on this thread failed; empty if it did not. Valid until the next call on this thread.
#[unsafe(no_mangle)]
pub extern "C" fn mtb_last_error_message() -> *const c_char {
    MESSAGE
        .try_with(|kept| kept.borrow().as_ptr())
        .unwrap_or_else(|_| c"the thread has ended: its message is gone".as_ptr())
}

/// Reads a contact that Python's `PreparedContact.save` wrote.
///
/// `path`: text in UTF-8, ended by a zero. `contact`: gets the handle, which `mtb_contact_free` gives back.
///
/// # Safety
/// `path` must be such a text, `contact` must point to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_load(path: *const c_char, contact: *mut u64) -> MtbStatus {
    call(|| {
        let (path, bytes) = read(path)?;
        let prepared = Prepared::from_bytes(&bytes).map_err(|error| unreadable(path, &error))?;
        keep(
            "contact",
            &CONTACTS,
            Contact::new(Arc::new(prepared)),
            contact,
        )
    })
}

/// Another contact without memory that shares the matrices of this one, for a second shoe or thread.
///
/// # Safety
/// `copy` must point to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_copy(contact: u64, copy: *mut u64) -> MtbStatus {
    call(|| {
        let prepared = lock(&*CONTACTS.get(contact)?).prepared().clone();
        keep("copy", &CONTACTS, Contact::new(prepared), copy)
    })
}

/// Gives a contact back.
#[unsafe(no_mangle)]
pub extern "C" fn mtb_contact_free(contact: u64) -> MtbStatus {
    call(|| CONTACTS.remove(contact))
}

/// Numbers of contact points and of motions found from balance. A null pointer leaves one out.
///
/// # Safety
/// `points` and `motions` must point to numbers or be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_size(
    contact: u64,
    points: *mut u64,
    motions: *mut u64,
) -> MtbStatus {
    call(|| {
        let prepared = lock(&*CONTACTS.get(contact)?).prepared().clone();
        put_if_wanted(prepared.geometry.points() as u64, points);
        put_if_wanted(prepared.motions.len() as u64, motions);
        Ok(())
    })
}

/// Name of a motion found from balance, counted from 0, for example "left z", and what it is of the pose.
///
/// `name`: room for `length` bytes, the zero at its end included; a name takes at most 64 as a rule, and a room
/// that is too small is refused with the length needed. `component`: 0 to 5, the component of the pose (x, y, z,
/// roll, pitch, yaw) that takes its place when it is prescribed, or -1 where none does. A null pointer leaves one
/// out.
///
/// # Safety
/// `name` must have this room or be null, `component` must point to a number or be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_motion(
    contact: u64,
    index: u64,
    length: u64,
    name: *mut c_char,
    component: *mut i32,
) -> MtbStatus {
    call(|| {
        let prepared = lock(&*CONTACTS.get(contact)?).prepared().clone();
        let count = prepared.motions.len();
        let motion = usize::try_from(index)
            .ok()
            .and_then(|k| prepared.motions.get(k))
            .ok_or_else(|| {
                Failure::argument(format!(
                    "there is no motion {index}: the contact has {count}"
                ))
            })?;
        if !name.is_null() {
            // a text of C ends at its first zero
            let text = CString::new(motion.name.replace('\0', " ")).unwrap_or_default();
            let bytes = text.as_bytes_with_nul();
            if length < bytes.len() as u64 {
                return Err(Failure::argument(format!(
                    "name has room for {length} bytes, {:?} needs {}",
                    motion.name,
                    bytes.len()
                )));
            }
            // SAFETY: not null, and the caller vouches for `length` writable bytes, of which these are the first
            unsafe { std::slice::from_raw_parts_mut(name.cast::<u8>(), bytes.len()) }
                .copy_from_slice(bytes);
        }
        put_if_wanted(motion.component.map_or(-1, |c| c as i32), component);
        Ok(())
    })
}

/// Contact points and normals of the lower body (3 n each: all x, all y, all z) [m], areas (n) [m2].
///
/// `n`: the number of points, as `mtb_contact_size` tells. A null pointer leaves a field out.
///
/// # Safety
/// The arrays must be of these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_points(
    contact: u64,
    n: u64,
    points: *mut f64,
    normals: *mut f64,
    areas: *mut f64,
) -> MtbStatus {
    call(|| {
        let prepared = lock(&*CONTACTS.get(contact)?).prepared().clone();
        let (g, n) = (&prepared.geometry, n as usize);
        let triple = n.saturating_mul(3);
        check_room_if_wanted("areas", g.area.len(), areas, n)?;
        check_room_if_wanted("points", g.points.len(), points, triple)?;
        check_room_if_wanted("normals", g.normal.len(), normals, triple)?;
        copy_out_if_wanted("areas", &g.area, areas, n)?;
        copy_out_if_wanted("points", &g.points, points, triple)?;
        copy_out_if_wanted("normals", &g.normal, normals, triple)
    })
}

/// The point that moments and rotations are about [m]. It was chosen when the contact was prepared and stays
/// where it is, whatever the pose; that of wheels moves with them.
///
/// # Safety
/// `point` must have room for 3 numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_reference_point(contact: u64, point: *mut f64) -> MtbStatus {
    call(|| {
        let prepared = lock(&*CONTACTS.get(contact)?).prepared().clone();
        copy_out("point", &prepared.reference_point, point, 3)
    })
}

/// Solves the contact at one instant, from the memory of the last step.
///
/// `pose` (6): displacement of the upper body from its reference, x, y, z [m], roll, pitch, yaw [rad]: turned about
/// the fixed x, then y, then z axis through the reference point, then shifted. NaN, or a null pointer for all: found
/// from balance where free, else zero. The contact points stay on the lower body and the gap over them changes by
/// the displacement along their normals: x changes nothing where no normal leans along x, as on a straight rail, and
/// a displacement must stay small against the radii of the surfaces. `velocity` (2): of the upper body over the lower
/// one, x and y [m/s]; only its direction counts unless friction or pull are tables over the speed.
/// `magnetic_pressure` [Pa]: uniform, in place of the scene's; NaN: the scene's, also that of a magnet whose pull follows
/// the gap, with the ampere-turns of `mtb_contact_set_ampere_turns`. No number may be larger than 1e30.
/// Out, each left out by a null pointer: `force` (3) [N] on the lower body, `moment` (3) [N m] of it about the
/// reference point, `effort`. A contact that the edge of its grid would cut off, while the bodies go on, is a bad
/// argument.
///
/// # Safety
/// The arrays must be of these lengths or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_step(
    contact: u64,
    pose: *const f64,
    velocity: *const f64,
    magnetic_pressure: f64,
    force: *mut f64,
    moment: *mut f64,
    effort: *mut MtbEffort,
) -> MtbStatus {
    call(|| {
        let asked = Asked {
            pose,
            velocity,
            shift: None,
            magnetic_pressure,
        };
        step_and_tell(contact, &asked, force, moment, effort)
    })
}

/// Solves the contact at the end of a displacement of the upper body over the lower one, from the last step on: points
/// stick or slip, and keep their tractions from step to step.
///
/// As `mtb_contact_step`, for a contact that Python's `PreparedContact.save` wrote with `shift=True`. `shift` (2):
/// displacement since the last step, x and y [m], besides the change of `pose`, which displaces points as well. `velocity`
/// (2): only its size counts, as the speed of tables. The first step starts from the bodies pressed together without
/// friction, and so does one after `mtb_contact_resume`; after a step that was not solved the one before it counts. Here
/// the memory decides what comes out: to take a step again, keep what `mtb_contact_memory` gives before it.
///
/// # Safety
/// The arrays must be of these lengths or null; `shift` must not be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_step_shifted(
    contact: u64,
    pose: *const f64,
    velocity: *const f64,
    shift: *const f64,
    magnetic_pressure: f64,
    force: *mut f64,
    moment: *mut f64,
    effort: *mut MtbEffort,
) -> MtbStatus {
    call(|| {
        let along = take("shift", shift, 2)?;
        let asked = Asked {
            pose,
            velocity,
            shift: Some([along[0], along[1]]),
            magnetic_pressure,
        };
        step_and_tell(contact, &asked, force, moment, effort)
    })
}

/// Ampere-turns [A] of the magnet, whose pull follows the gap, in all steps from here on; 0: switched off, NaN: those with
/// which it was prepared.
///
/// A contact without such a magnet is a bad argument. A copy of a contact begins with those with which it was prepared.
#[unsafe(no_mangle)]
pub extern "C" fn mtb_contact_set_ampere_turns(contact: u64, ampere_turns: f64) -> MtbStatus {
    call(|| {
        let handle = CONTACTS.get(contact)?;
        let mut kept = lock(&handle);
        let magnet = (kept.prepared().magnet.as_ref()).ok_or(mtb_contact::Error::NoMagnet)?;
        if !ampere_turns.is_nan() {
            magnet.circuit.with_ampere_turns(ampere_turns)?;
        }
        kept.ampere_turns = (!ampere_turns.is_nan()).then_some(ampere_turns);
        Ok(())
    })
}

/// How the magnet, whose pull follows the gap, pulled in the last step that was solved.
///
/// `pull` (n): pressure at each point [Pa], also for `mtb_contact_resume_attraction`. `attraction`: their sum times the
/// areas [N]. A null pointer leaves one out. A step under anything else is a bad argument.
///
/// # Safety
/// `pull` must have room for `n` numbers or be null, `attraction` must point to a number or be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_attraction(
    contact: u64,
    n: u64,
    pull: *mut f64,
    attraction: *mut f64,
) -> MtbStatus {
    call(|| {
        let handle = CONTACTS.get(contact)?;
        let kept = lock(&handle);
        let settled = kept.last()?.out.settled.as_ref().ok_or_else(no_magnet)?;
        copy_out_if_wanted("pull", &settled.pull, pull, n as usize)?;
        let area = &kept.prepared().geometry.area;
        let sum = settled.pull.iter().zip(area).map(|(p, a)| p * a).sum();
        put_if_wanted(sum, attraction);
        Ok(())
    })
}

fn no_magnet() -> Failure {
    Failure::argument("the last step was under no magnet whose pull follows the gap")
}

/// Derivatives of the last step that was solved by the ampere-turns of its magnet, and of the force of this.
///
/// `by_ampere_turns` (9): of force x, y, z [N], moment x, y, z [N m], heat of sliding [W] (of a step with a shift the work
/// of the friction [J]), largest mean pressure [Pa] and attraction [N], by the ampere-turns [A]. `of_attraction`: of the
/// attraction by the columns of `mtb_contact_derivatives` (`columns` is 9), after a step with a shift by those of
/// `mtb_contact_shift_derivatives` (11). A null pointer leaves one out.
///
/// # Safety
/// The arrays must be of these lengths or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_magnet_derivatives(
    contact: u64,
    columns: u64,
    by_ampere_turns: *mut f64,
    of_attraction: *mut f64,
) -> MtbStatus {
    call(|| {
        let handle = CONTACTS.get(contact)?;
        let mut kept = lock(&handle);
        kept.last()?.out.settled.as_ref().ok_or_else(no_magnet)?;
        let rows: Vec<Vec<f64>> = match kept.stepped.stuck().cloned() {
            Some(stuck) => stuck.jacobian()?.map(|row| row.to_vec()).into(),
            None if kept.last()?.out.slipped.is_some() => return Err(no_step_before()),
            None => (kept.stepped.jacobian(&unmonitored)?)
                .map(|row| row.to_vec())
                .into(),
        };
        // ampere-turns are the last column, the attraction is the last row
        let parts = rows.last().and_then(|row| row.split_last());
        let (_, attraction) = parts.unwrap_or((&0.0, &[]));
        let by: Vec<f64> = (rows.iter().filter_map(|row| row.last()).copied()).collect();
        check_room_if_wanted(
            "of_attraction",
            attraction.len(),
            of_attraction,
            columns as usize,
        )?;
        copy_out_if_wanted("by_ampere_turns", &by, by_ampere_turns, by.len())?;
        copy_out_if_wanted("of_attraction", attraction, of_attraction, columns as usize)
    })
}

/// What a caller asks a step for.
struct Asked {
    pose: *const f64,
    velocity: *const f64,
    shift: Option<[f64; 2]>,
    magnetic_pressure: f64,
}

/// Takes a step, writes what it found through the caller's pointers and keeps its fields.
fn step_and_tell(
    contact: u64,
    asked: &Asked,
    force: *mut f64,
    moment: *mut f64,
    effort: *mut MtbEffort,
) -> Result<(), Failure> {
    let mut place = [f64::NAN; 6];
    if !asked.pose.is_null() {
        place.copy_from_slice(take("pose", asked.pose, 6)?);
    }
    let velocity = take("velocity", asked.velocity, 2)?;
    let handle = CONTACTS.get(contact)?;
    let mut kept = lock(&handle);
    let step = Step {
        pose: place,
        velocity: [velocity[0], velocity[1]],
        pull: match (asked.magnetic_pressure, kept.ampere_turns) {
            (pressure, _) if !pressure.is_nan() => Pull::Uniform(pressure),
            (_, Some(ampere_turns)) => Pull::AmpereTurns(ampere_turns),
            (_, None) => Pull::Scene,
        },
        gap: None,
        friction: None,
        diagonal: None,
        shift: asked.shift,
    };
    let out = kept.stepped.step(&step, &unmonitored)?;
    if let Some(why) = out.unsolved() {
        let status = match out.solution.status {
            Status::NoSolution => MtbStatus::NoSolution,
            _ => MtbStatus::NotConverged,
        };
        return Err(Failure(status, why));
    }
    copy_out_if_wanted("force", &out.force, force, 3)?;
    copy_out_if_wanted("moment", &out.moment, moment, 3)?;
    let taken = MtbEffort {
        sets: out.effort.sets as u64,
        factorisations: out.effort.factorisations as u64,
        products: out.effort.products as u64,
        residual: out.solution.residual,
    };
    put_if_wanted(taken, effort);
    // of the motions that were free in this step
    let mut found = out.solution.motion.iter().copied();
    let amplitudes = (kept.prepared().motions.iter())
        .map(|free| match free.component {
            Some(c) if !place[c].is_nan() => f64::NAN,
            _ => found.next().unwrap_or(f64::NAN),
        })
        .collect();
    kept.last = Some(Last { out, amplitudes });
    Ok(())
}

/// Mean pressure over each of the `n` points [Pa] in the last step that was solved.
///
/// # Safety
/// `pressure` must have room for `n` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_pressure(
    contact: u64,
    n: u64,
    pressure: *mut f64,
) -> MtbStatus {
    call(|| {
        let handle = CONTACTS.get(contact)?;
        let kept = lock(&handle);
        let mean = kept
            .prepared()
            .geometry
            .mean_tractions(&kept.last()?.out.solution.pressure);
        copy_out("pressure", &mean, pressure, n as usize)
    })
}

/// Heat of sliding [W] and the largest mean pressure over a point [Pa] in the last step that was solved. A null
/// pointer leaves one out.
///
/// `friction_power`: friction times the velocity, without the power of the pressures; of a step with a shift NaN, whose
/// friction does the work that `mtb_contact_friction` tells.
///
/// # Safety
/// `friction_power` and `peak_pressure` must point to numbers or be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_summary(
    contact: u64,
    friction_power: *mut f64,
    peak_pressure: *mut f64,
) -> MtbStatus {
    call(|| {
        let handle = CONTACTS.get(contact)?;
        let kept = lock(&handle);
        let out = &kept.last()?.out;
        let mean = (kept.prepared().geometry).mean_tractions(&out.solution.pressure);
        let power = if out.slipped.is_some() {
            f64::NAN
        } else {
            out.friction_power
        };
        put_if_wanted(power, friction_power);
        put_if_wanted(mean.iter().copied().fold(0.0, f64::max), peak_pressure);
        Ok(())
    })
}

/// Derivatives of the last step that was solved, 8 x 9, row by row.
///
/// The rows are force x, y, z [N] and moment x, y, z [N m] on the lower body, heat of sliding [W] and largest mean
/// pressure [Pa]; the columns are what they are derived by: pose x, y, z [m], roll, pitch, yaw [rad], velocity x, y
/// [m/s], and a uniform magnetic pressure [Pa], 0 for a contact that knows of none. Components of the pose that
/// are found from balance have columns of 0. The points in contact stay the same.
///
/// # Safety
/// `derivatives` must have room for 72 numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_derivatives(contact: u64, derivatives: *mut f64) -> MtbStatus {
    call(|| {
        let handle = CONTACTS.get(contact)?;
        let mut kept = lock(&handle);
        kept.last()?;
        let jacobian = kept.stepped.jacobian(&unmonitored)?;
        let flat = without_magnet(&jacobian);
        copy_out("derivatives", &flat, derivatives, flat.len())
    })
}

/// What the motions found from balance did in the last step that was solved, [m] or [rad], in the order of
/// `mtb_contact_motion`; NaN for one in whose place a component of the pose was prescribed.
///
/// # Safety
/// `amplitudes` must have room for `m` numbers, as many as `mtb_contact_size` tells.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_amplitudes(
    contact: u64,
    m: u64,
    amplitudes: *mut f64,
) -> MtbStatus {
    call(|| {
        let handle = CONTACTS.get(contact)?;
        let kept = lock(&handle);
        copy_out(
            "amplitudes",
            &kept.last()?.amplitudes,
            amplitudes,
            m as usize,
        )
    })
}

/// Friction at each of the `n` points in the last step that was solved.
///
/// `tractions` (2 n): mean traction on the lower body along the first tangent of each point, then along the second one
/// [Pa]; the first tangent lies along x. `slip` (2 n): how far the upper body slipped over the lower one in a step with a
/// shift, along both tangents [m], where points slip; zeros where they stick. `states` (n): 0 open, 1 stick, 2 slip.
/// `work`: of the friction on the slip [J]. Of a step without a shift `slip` and `work` are NaN. A null pointer leaves one
/// out.
///
/// # Safety
/// The arrays must be of these lengths or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_friction(
    contact: u64,
    n: u64,
    tractions: *mut f64,
    slip: *mut f64,
    states: *mut i32,
    work: *mut f64,
) -> MtbStatus {
    call(|| {
        let handle = CONTACTS.get(contact)?;
        let kept = lock(&handle);
        let (out, g, n) = (&kept.last()?.out, &kept.prepared().geometry, n as usize);
        let count = g.points();
        let twice = n.saturating_mul(2);
        check_room_if_wanted("tractions", 2 * count, tractions, twice)?;
        check_room_if_wanted("slip", 2 * count, slip, twice)?;
        check_room_if_wanted("states", count, states, n)?;
        let mean = out.mean_tractions(g);
        copy_out_if_wanted("tractions", &mean[..2 * count], tractions, twice)?;
        let (unknown, slipped) = (vec![f64::NAN; 2 * count], out.slipped.as_ref());
        let found = slipped.map_or(&unknown, |slipped| &slipped.slip);
        copy_out_if_wanted("slip", found, slip, twice)?;
        let doing: Vec<i32> = (out.points.iter())
            .map(|point| match point {
                PointState::Open => 0,
                PointState::Stick => 1,
                PointState::Slip => 2,
            })
            .collect();
        copy_out_if_wanted("states", &doing, states, n)?;
        put_if_wanted(slipped.map_or(f64::NAN, |slipped| slipped.work), work);
        Ok(())
    })
}

/// How many numbers the memory of steps with a shift has.
///
/// # Safety
/// `size` must point to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_memory_size(contact: u64, size: *mut u64) -> MtbStatus {
    call(|| {
        let prepared = lock(&*CONTACTS.get(contact)?).prepared().clone();
        put("size", prepared.memory_size() as u64, size)
    })
}

/// What the next step with a shift starts from, after the last step that was solved: `size` numbers for
/// `mtb_contact_remember`.
///
/// # Safety
/// `memory` must have room for `size` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_memory(
    contact: u64,
    size: u64,
    memory: *mut f64,
) -> MtbStatus {
    call(|| {
        let handle = CONTACTS.get(contact)?;
        let kept = lock(&handle);
        kept.last()?;
        let whole = (kept.stepped.memory()).ok_or_else(|| match kept.prepared().bodies {
            None => mtb_contact::Error::NoTangents.into(),
            Some(_) => no_step(),
        })?;
        copy_out("memory", &whole, memory, size as usize)
    })
}

/// Starts the next step from a memory of `mtb_contact_memory`, of this contact or a copy of it.
///
/// # Safety
/// `memory` must hold `size` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_remember(
    contact: u64,
    size: u64,
    memory: *const f64,
) -> MtbStatus {
    call(|| {
        let memory = take("memory", memory, size as usize)?;
        let handle = CONTACTS.get(contact)?;
        let mut kept = lock(&handle);
        let wanted = kept.prepared().memory_size();
        if memory.len() != wanted {
            return Err(Failure::argument(format!(
                "memory has {} numbers, that of this contact has {wanted}",
                memory.len()
            )));
        }
        Ok(kept.stepped.recall(memory)?)
    })
}

/// Derivatives of the last step, which had a shift and started from another step, 8 x 11, row by row.
///
/// The rows are force x, y, z [N] and moment x, y, z [N m] on the lower body, work of the friction on the slip [J] and
/// largest mean pressure [Pa]; the columns are pose x, y, z [m], roll, pitch, yaw [rad], shift x, y [m], velocity x, y [m/s]
/// of the tables, and a uniform magnetic pressure [Pa]. What sticks, slips and is in contact stays the same.
///
/// # Safety
/// `derivatives` must have room for 88 numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_shift_derivatives(
    contact: u64,
    derivatives: *mut f64,
) -> MtbStatus {
    call(|| {
        let handle = CONTACTS.get(contact)?;
        let kept = lock(&handle);
        kept.last()?;
        let stuck = kept.stepped.stuck().ok_or_else(no_step_before)?;
        let flat = without_magnet(&stuck.jacobian()?);
        copy_out("derivatives", &flat, derivatives, flat.len())
    })
}

/// Derivatives row by row, without the last row and column, which are those of magnets.
fn without_magnet<const C: usize, const R: usize>(rows: &[[f64; C]; R]) -> Vec<f64> {
    (rows[..R - 1].iter())
        .flat_map(|row| row[..C - 1].iter().copied())
        .collect()
}

fn no_step_before() -> Failure {
    Failure::argument(
        "the last step had no shift, or started from no step before it: a step with a shift from another one is needed",
    )
}

/// Gap at each of the `n` points [m] in the last step that was solved.
///
/// # Safety
/// `gap` must have room for `n` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_gap(contact: u64, n: u64, gap: *mut f64) -> MtbStatus {
    call(|| {
        let handle = CONTACTS.get(contact)?;
        let kept = lock(&handle);
        copy_out("gap", &kept.last()?.out.solution.gap, gap, n as usize)
    })
}

/// The state after the last step that was solved, `n` numbers for `mtb_contact_resume`.
///
/// # Safety
/// `state` must have room for `n` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_state(contact: u64, n: u64, state: *mut f64) -> MtbStatus {
    call(|| {
        let handle = CONTACTS.get(contact)?;
        let kept = lock(&handle);
        let pressure = &kept.last()?.out.solution.pressure;
        copy_out("state", pressure, state, n as usize)
    })
}

/// Starts the next step from a state of `mtb_contact_state` in place of the memory, for steps taken again. A
/// step taken again gives the same to rounding, not bit by bit. Where friction allows two states, the one on
/// whose way the last step lay comes out. Tractions are forgotten: steps with a shift go on from
/// `mtb_contact_remember`. The pull of a magnet that follows the gap is forgotten as well, and
/// `mtb_contact_resume_attraction` gives it after this call.
///
/// # Safety
/// `state` must hold `n` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_resume(contact: u64, n: u64, state: *const f64) -> MtbStatus {
    call(|| {
        let state = take("state", state, n as usize)?;
        let handle = CONTACTS.get(contact)?;
        Ok(lock(&handle).stepped.resume(state, &[], None)?)
    })
}

/// Starts the next step under a magnet that follows the gap from a pull of `mtb_contact_attraction`, in place of that of
/// the last step: after `mtb_contact_resume`. Where two states exist, of bodies apart and of bodies that touch, the pull
/// tells which of them comes out.
///
/// # Safety
/// `pull` must hold `n` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_contact_resume_attraction(
    contact: u64,
    n: u64,
    pull: *const f64,
) -> MtbStatus {
    call(|| {
        let pull = take("pull", pull, n as usize)?;
        let handle = CONTACTS.get(contact)?;
        Ok(lock(&handle).stepped.resume_pull(pull)?)
    })
}

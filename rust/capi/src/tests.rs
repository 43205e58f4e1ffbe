// SPDX-License-Identifier: MIT OR Apache-2.0
//! The door as callers misuse it: any bytes for a file, any handle, null and wrong lengths, many threads.

use std::ffi::{CStr, CString};
use std::path::PathBuf;
use std::ptr::{null, null_mut};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, LazyLock};

use mtb_contact::interface::Interface;
use mtb_contact::prepared::{NamedMotion, Prepared, Table};
use mtb_contact::problem::Geometry;
use mtb_contact::sliding::RigidMotion;
use mtb_contact::stepping::Influence;
use proptest::prelude::*;

use super::*;

mod wheels;

const N: usize = 3;
/// What stands in arrays that nothing was written to.
const UNTOUCHED: f64 = -7.25;

/// Three points in a row, 1 apart, on springs of stiffness 1, free to move along z.
fn springs() -> Prepared {
    let unit = |axis: usize| -> Vec<f64> {
        (0..3 * N)
            .map(|k| if k / N == axis { 1.0 } else { 0.0 })
            .collect()
    };
    let diagonal = (0..N * N)
        .map(|k| if k % (N + 1) == 0 { 1.0 } else { 0.0 })
        .collect();
    let loads = |work: f64| [vec![0.0; N], vec![work]].concat();
    Prepared {
        bodies: None,
        influence: Arc::new(Influence::from_columns(N, diagonal, [None, None]).unwrap()),
        geometry: Geometry {
            points: vec![-1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            normal: unit(2),
            tangent_x: unit(0),
            tangent_y: unit(1),
            area: vec![1.0; N],
            mean_frame: [unit(0), unit(1), unit(2)],
            means: None,
            windows: Vec::new(),
        },
        motions: vec![NamedMotion {
            name: "z".to_owned(),
            motion: RigidMotion {
                tangential_x: vec![0.0; N],
                tangential_y: vec![0.0; N],
                opening: vec![1.0; N],
                work: 0.0,
            },
            component: Some(2),
        }],
        friction: Table::new(vec![0.0, 10.0], vec![vec![0.5; N], vec![0.1; N]]).unwrap(),
        loads: Table::constant(loads(-3.0)),
        magnetic: Some([loads(0.0), loads(-1.5)]),
        magnet: None,
        pulled: None,
        sliding_direction: [1.0, 0.0],
        reference_point: [0.0, 0.0, 2.0],
        standstill_speed: None,
        velocity: None,
        interface: Interface::default(),
    }
}

static BYTES: LazyLock<Vec<u8>> = LazyLock::new(|| springs().to_bytes(&unmonitored).unwrap());
/// The sound file, for all tests of this process.
static SOUND: LazyLock<CString> = LazyLock::new(|| file(&BYTES).1);

/// A new file of these bytes, and its path as C has it.
fn file(bytes: &[u8]) -> (PathBuf, CString) {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    let name = format!(
        "mtb-capi-{}-{}.mtbc",
        std::process::id(),
        NEXT.fetch_add(1, Ordering::Relaxed)
    );
    let path = std::env::temp_dir().join(name);
    std::fs::write(&path, bytes).unwrap();
    let text = CString::new(path.to_str().unwrap()).unwrap();
    (path, text)
}

fn message() -> String {
    // SAFETY: valid until the next call on this thread, and copied at once
    unsafe { CStr::from_ptr(mtb_last_error_message()) }
        .to_str()
        .unwrap()
        .to_owned()
}

fn loaded() -> u64 {
    let mut handle = 0;
    // SAFETY: a text and a number
    assert_eq!(
        unsafe { mtb_contact_load(SOUND.as_ptr(), &raw mut handle) },
        MtbStatus::Ok
    );
    handle
}

#[test]
fn a_contact_without_a_magnet_refuses_its_calls() {
    let handle = loaded();
    let velocity = [1.0, 0.0];
    let mut numbers = [UNTOUCHED; 9];
    let to = numbers.as_mut_ptr();
    // SAFETY: arrays of these lengths
    unsafe {
        assert_eq!(
            mtb_contact_set_ampere_turns(handle, 100.0),
            MtbStatus::BadArgument
        );
        assert!(message().contains("which alone has ampere_turns"));
        assert_eq!(
            mtb_contact_attraction(handle, 3, to, null_mut()),
            MtbStatus::BadArgument
        );
        assert_eq!(message(), "no step was solved yet");
        let status = mtb_contact_step(
            handle,
            null(),
            velocity.as_ptr(),
            f64::NAN,
            null_mut(),
            null_mut(),
            null_mut(),
        );
        assert_eq!(status, MtbStatus::Ok);
        for status in [
            mtb_contact_attraction(handle, 3, to, null_mut()),
            mtb_contact_magnet_derivatives(handle, 9, to, null_mut()),
        ] {
            assert_eq!(status, MtbStatus::BadArgument);
            assert!(message().contains("under no magnet"));
        }
        assert_eq!(
            mtb_contact_resume_attraction(handle, 3, [1.0; 3].as_ptr()),
            MtbStatus::BadArgument
        );
        assert_eq!(mtb_contact_free(handle), MtbStatus::Ok);
    }
    assert_eq!(numbers, [UNTOUCHED; 9]);
}

/// A call, with what may be wrong in it; `null` counts pointers that are null, bit by bit.
#[derive(Clone, Debug)]
struct Call {
    what: usize,
    handle: Handle,
    null: u8,
    length: u64,
    pose: Option<[f64; 6]>,
    velocity: [f64; 2],
    magnetic_pressure: f64,
    state: [f64; N],
}

#[derive(Clone, Debug)]
enum Handle {
    Live(usize),
    Freed(usize),
    Any(u64),
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -2.0..2.0_f64,
        1 => prop::sample::select(vec![0.0, -0.0, 1e30, -1e30, 1e300, 5e-324, f64::INFINITY]),
        1 => Just(f64::NAN),
        1 => any::<f64>(),
    ]
}

fn call_of_any_kind() -> impl Strategy<Value = Call> {
    let handle = prop_oneof![
        6 => any::<usize>().prop_map(Handle::Live),
        1 => any::<usize>().prop_map(Handle::Freed),
        1 => any::<u64>().prop_map(Handle::Any),
    ];
    let null = prop_oneof![3 => Just(0_u8), 1 => any::<u8>()];
    let length = prop_oneof![
        3 => Just(N as u64),
        1 => 0..9_u64,
        1 => prop::sample::select(vec![u64::MAX, u64::MAX / 3 + 2, 1 << 61, 1 << 32])
    ];
    (
        (0..15_usize, handle, null, length),
        prop::option::of(prop::array::uniform6(number())),
        [number(), number()],
        number(),
        prop::array::uniform3(number()),
    )
        .prop_map(|(kind, pose, velocity, magnetic_pressure, state)| Call {
            what: kind.0,
            handle: kind.1,
            null: kind.2,
            length: kind.3,
            pose,
            velocity,
            magnetic_pressure,
            state,
        })
}

/// An array of the caller's with room for `N` vectors, and some more that nobody may write to.
struct Room([f64; 4 * N]);

impl Room {
    fn new() -> Self {
        Self([UNTOUCHED; 4 * N])
    }

    fn at(&mut self, is_null: bool) -> *mut f64 {
        if is_null {
            null_mut()
        } else {
            self.0.as_mut_ptr()
        }
    }

    /// The first `written` numbers if a call went well, else none.
    fn check(&self, status: MtbStatus, written: usize) {
        let written = if status == MtbStatus::Ok { written } else { 0 };
        let (of_call, rest) = self.0.split_at(written);
        assert!(of_call.iter().all(|v| v.is_finite()), "{of_call:?}");
        assert!(rest.iter().all(|v| *v == UNTOUCHED), "{rest:?}");
    }
}

/// The contacts a caller holds, and those it gave back.
#[derive(Default)]
struct Caller {
    live: Vec<u64>,
    freed: Vec<u64>,
}

impl Caller {
    fn handle(&self, meant: &Handle) -> u64 {
        let of = |list: &[u64], k: usize| list.get(k % list.len().max(1)).copied().unwrap_or(0);
        match meant {
            Handle::Live(k) => of(&self.live, *k),
            Handle::Freed(k) => of(&self.freed, *k),
            Handle::Any(handle) => *handle,
        }
    }

    /// Makes the call and checks what it left; every array has room for what the call may write.
    fn make(&mut self, call: &Call) -> MtbStatus {
        let handle = self.handle(&call.handle);
        let is_null = |k: u8| call.null >> k & 1 == 1;
        let (mut a, mut b, mut c) = (Room::new(), Room::new(), Room::new());
        // SAFETY: pointers are null or to arrays longer than what is written to them
        unsafe {
            match call.what {
                0 | 1 => {
                    let (mut new, path) = (0, SOUND.as_ptr());
                    let out = if is_null(0) { null_mut() } else { &raw mut new };
                    let status = if call.what == 0 {
                        mtb_contact_load(if is_null(1) { null() } else { path }, out)
                    } else {
                        mtb_contact_copy(handle, out)
                    };
                    assert_eq!(new != 0, status == MtbStatus::Ok);
                    self.live.extend((new != 0).then_some(new));
                    status
                }
                2 => {
                    let status = mtb_contact_free(handle);
                    let is_live = self.live.contains(&handle);
                    // another test's, where it was drawn by chance
                    assert!(!is_live || status == MtbStatus::Ok);
                    if is_live {
                        self.live.retain(|h| *h != handle);
                        self.freed.push(handle);
                    }
                    status
                }
                3 => {
                    let (mut n, mut m) = (0, 0);
                    let points = if is_null(0) { null_mut() } else { &raw mut n };
                    let motions = if is_null(1) { null_mut() } else { &raw mut m };
                    let status = mtb_contact_size(handle, points, motions);
                    let told = |is_null, count| if is_null { 0 } else { count };
                    let wanted = (told(is_null(0), N as u64), told(is_null(1), 1));
                    let done = status == MtbStatus::Ok;
                    assert_eq!((n, m), if done { wanted } else { (0, 0) });
                    status
                }
                4 => {
                    let out = [a.at(is_null(0)), b.at(is_null(1)), c.at(is_null(2))];
                    let status = mtb_contact_points(handle, call.length, out[0], out[1], out[2]);
                    let written = |k, count| if is_null(k) { 0 } else { count };
                    a.check(status, written(0, 3 * N));
                    b.check(status, written(1, 3 * N));
                    c.check(status, written(2, N));
                    status
                }
                5 => {
                    let status = mtb_contact_reference_point(handle, a.at(is_null(0)));
                    a.check(status, 3);
                    status
                }
                6 => {
                    let pose = call.pose.as_ref().map_or(null(), |p| p.as_ptr());
                    let velocity = if is_null(0) {
                        null()
                    } else {
                        call.velocity.as_ptr()
                    };
                    let mut effort = MtbEffort {
                        sets: 0,
                        factorisations: 0,
                        products: 0,
                        residual: UNTOUCHED,
                    };
                    let status = mtb_contact_step(
                        handle,
                        pose,
                        velocity,
                        call.magnetic_pressure,
                        a.at(is_null(1)),
                        b.at(is_null(2)),
                        if is_null(3) {
                            null_mut()
                        } else {
                            &raw mut effort
                        },
                    );
                    a.check(status, if is_null(1) { 0 } else { 3 });
                    b.check(status, if is_null(2) { 0 } else { 3 });
                    let is_told = status == MtbStatus::Ok && !is_null(3);
                    assert!(effort.residual.is_finite());
                    assert_eq!(effort.residual != UNTOUCHED, is_told, "{effort:?}");
                    status
                }
                7..=9 => {
                    let fields = [mtb_contact_pressure, mtb_contact_gap, mtb_contact_state];
                    let status = fields[call.what - 7](handle, call.length, a.at(is_null(0)));
                    a.check(status, N);
                    status
                }
                10 => {
                    let (mut power, mut peak) = (UNTOUCHED, UNTOUCHED);
                    let powers = if is_null(0) {
                        null_mut()
                    } else {
                        &raw mut power
                    };
                    let peaks = if is_null(1) {
                        null_mut()
                    } else {
                        &raw mut peak
                    };
                    let status = mtb_contact_summary(handle, powers, peaks);
                    let is_told = |k| status == MtbStatus::Ok && !is_null(k);
                    assert_eq!(power >= 0.0, is_told(0), "{power}");
                    assert_eq!(peak >= 0.0, is_told(1), "{peak}");
                    status
                }
                11 => {
                    let mut amplitude = [UNTOUCHED; 2];
                    let to = if is_null(0) {
                        null_mut()
                    } else {
                        amplitude.as_mut_ptr()
                    };
                    let status = mtb_contact_amplitudes(handle, call.length, to);
                    assert_eq!(amplitude[0] != UNTOUCHED, status == MtbStatus::Ok);
                    assert_eq!(amplitude[1], UNTOUCHED);
                    status
                }
                12 => {
                    let (mut name, mut component) = ([7_u8; 4], -7);
                    let room = call.length.min(name.len() as u64);
                    let to = if is_null(0) {
                        null_mut()
                    } else {
                        name.as_mut_ptr().cast()
                    };
                    let number = if is_null(1) {
                        null_mut()
                    } else {
                        &raw mut component
                    };
                    let index = u64::from(call.null >> 4);
                    let status = mtb_contact_motion(handle, index, room, to, number);
                    let done = status == MtbStatus::Ok;
                    assert!(!done || index == 0);
                    let wanted = if done && !is_null(0) {
                        *b"z\0\x07\x07"
                    } else {
                        [7; 4]
                    };
                    assert_eq!(name, wanted);
                    assert_eq!(component, if done && !is_null(1) { 2 } else { -7 });
                    status
                }
                13 => {
                    let mut derivatives = [UNTOUCHED; 73];
                    let to = if is_null(0) {
                        null_mut()
                    } else {
                        derivatives.as_mut_ptr()
                    };
                    let status = mtb_contact_derivatives(handle, to);
                    let is_told = status == MtbStatus::Ok;
                    assert!(
                        derivatives[..72]
                            .iter()
                            .all(|d| (*d != UNTOUCHED) == is_told)
                    );
                    assert_eq!(derivatives[72], UNTOUCHED);
                    status
                }
                _ => {
                    // the length of what the caller holds is the caller's word
                    let length = call.length.min(N as u64);
                    let state = if is_null(0) {
                        null()
                    } else {
                        call.state.as_ptr()
                    };
                    mtb_contact_resume(handle, length, state)
                }
            }
        }
    }
}

proptest! {
    #[test]
    fn any_calls_end_with_a_status_and_a_message(calls in prop::collection::vec(call_of_any_kind(), 1..24)) {
        let mut caller = Caller { live: vec![loaded()], freed: Vec::new() };
        for call in &calls {
            let status = caller.make(call);
            prop_assert_ne!(status, MtbStatus::Internal, "{:?}: {}", call, message());
            prop_assert_eq!(status == MtbStatus::Ok, message().is_empty(), "{:?}: {}", call, message());
        }
        for handle in caller.live {
            prop_assert_eq!(mtb_contact_free(handle), MtbStatus::Ok);
            prop_assert_eq!(mtb_contact_free(handle), MtbStatus::BadArgument);
        }
    }

    #[test]
    fn any_bytes_of_a_file_are_the_contact_or_refused(
        bytes in prop::collection::vec(any::<u8>(), 0..200),
        changes in prop::collection::vec((any::<usize>(), any::<u8>()), 0..4),
        cut in 0..40_usize,
        is_made_up in any::<bool>(),
    ) {
        let data = if is_made_up { bytes } else {
            let mut data = BYTES.clone();
            for (place, byte) in changes {
                let at = place % data.len();
                data[at] = byte;
            }
            data.truncate(data.len() - if cut < 20 { 0 } else { cut });
            data
        };
        let (path, text) = file(&data);
        let mut handle = 0;
        // SAFETY: a text and a number
        let status = unsafe { mtb_contact_load(text.as_ptr(), &raw mut handle) };
        std::fs::remove_file(path).unwrap();
        if data == *BYTES {
            prop_assert_eq!(status, MtbStatus::Ok);
            prop_assert_eq!(mtb_contact_free(handle), MtbStatus::Ok);
        } else {
            prop_assert_eq!(status, MtbStatus::BadFile);
            prop_assert!(message().contains("not a prepared contact"), "{}", message());
            prop_assert_eq!(handle, 0);
        }
    }
}

#[test]
fn a_step_tells_heat_peak_and_what_its_motions_did() {
    let handle = loaded();
    let velocity = [-5.0, 0.0];
    let (mut power, mut peak, mut amplitude) = (UNTOUCHED, UNTOUCHED, UNTOUCHED);
    for (z, wanted) in [(f64::NAN, 1.0), (-0.5, 0.5)] {
        let pose = [f64::NAN, f64::NAN, z, f64::NAN, f64::NAN, f64::NAN];
        // SAFETY: arrays of the lengths meant, or none
        unsafe {
            let step = |force| {
                let (pose, velocity) = (pose.as_ptr(), velocity.as_ptr());
                mtb_contact_step(
                    handle,
                    pose,
                    velocity,
                    f64::NAN,
                    force,
                    null_mut(),
                    null_mut(),
                )
            };
            assert_eq!(step(null_mut()), MtbStatus::Ok);
            assert_eq!(
                mtb_contact_summary(handle, &raw mut power, &raw mut peak),
                MtbStatus::Ok
            );
            assert_eq!(
                mtb_contact_amplitudes(handle, 1, &raw mut amplitude),
                MtbStatus::Ok
            );
        }
        // springs of stiffness 1 under a coefficient of 0.3 at 5 m/s
        assert!((peak - wanted).abs() < 1e-12, "{peak}");
        assert!((power - 3.0 * wanted * 0.3 * 5.0).abs() < 1e-12, "{power}");
        let is_expected = if z.is_nan() {
            (amplitude + 1.0).abs() < 1e-12
        } else {
            amplitude.is_nan()
        };
        assert!(is_expected, "{amplitude}");
    }
    assert_eq!(mtb_contact_free(handle), MtbStatus::Ok);
}

#[test]
fn a_contact_without_its_tangents_takes_no_shift() {
    let handle = loaded();
    let (shift, velocity) = ([1e-6, 0.0], [5.0, 0.0]);
    let mut force = [UNTOUCHED; 3];
    let mut size = 0;
    let mut memory = [UNTOUCHED; 16];
    // SAFETY: arrays of the lengths meant, or none
    unsafe {
        let mut push = |shift| {
            let (velocity, force) = (velocity.as_ptr(), force.as_mut_ptr());
            let none = (null_mut(), null_mut());
            mtb_contact_step_shifted(
                handle,
                null(),
                velocity,
                shift,
                f64::NAN,
                force,
                none.0,
                none.1,
            )
        };
        assert_eq!(push(null()), MtbStatus::BadArgument);
        assert_eq!(message(), "shift is null");
        assert_eq!(push(shift.as_ptr()), MtbStatus::BadArgument);
        assert!(message().contains("for sliding alone"), "{}", message());
        assert_eq!(
            mtb_contact_memory_size(handle, &raw mut size),
            MtbStatus::Ok
        );
        assert_eq!(size, 5 * N as u64 + 1);
        // of a step that slides there is nothing to go on from either
        let pose = null();
        let sliding = mtb_contact_step(
            handle,
            pose,
            velocity.as_ptr(),
            f64::NAN,
            null_mut(),
            null_mut(),
            null_mut(),
        );
        assert_eq!(sliding, MtbStatus::Ok);
        assert_eq!(
            mtb_contact_memory(handle, size, memory.as_mut_ptr()),
            MtbStatus::BadArgument
        );
        assert_eq!(
            mtb_contact_remember(handle, 2, memory.as_ptr()),
            MtbStatus::BadArgument
        );
        assert_eq!(
            message(),
            "memory has 2 numbers, that of this contact has 16"
        );
        let mut work = UNTOUCHED;
        let mut states = [7; N];
        let told = mtb_contact_friction(
            handle,
            N as u64,
            null_mut(),
            null_mut(),
            states.as_mut_ptr(),
            &raw mut work,
        );
        assert_eq!((told, states), (MtbStatus::Ok, [2; N]));
        assert!(work.is_nan());
    }
    assert_eq!((force, memory), ([UNTOUCHED; 3], [UNTOUCHED; 16]));
    assert_eq!(mtb_contact_free(handle), MtbStatus::Ok);
}

#[test]
fn a_name_that_finds_no_room_is_told_its_length() {
    let handle = loaded();
    let mut name = [7_u8];
    // SAFETY: a byte, and no number
    let status = unsafe { mtb_contact_motion(handle, 0, 1, name.as_mut_ptr().cast(), null_mut()) };
    assert_eq!((status, name), (MtbStatus::BadArgument, [7]));
    assert_eq!(message(), "name has room for 1 bytes, \"z\" needs 2");
    assert_eq!(mtb_contact_free(handle), MtbStatus::Ok);
}

#[test]
fn threads_on_one_handle_wait_for_each_other_and_see_it_freed() {
    let handle = loaded();
    let step = move |speed: f64| {
        let (mut force, mut moment) = ([UNTOUCHED; 3], [UNTOUCHED; 3]);
        // SAFETY: arrays of the lengths meant
        let status = unsafe {
            mtb_contact_step(
                handle,
                null(),
                [speed, 0.0].as_ptr(),
                f64::NAN,
                force.as_mut_ptr(),
                moment.as_mut_ptr(),
                null_mut(),
            )
        };
        (status, force)
    };
    std::thread::scope(|scope| {
        for thread in 0..4 {
            scope.spawn(move || {
                for k in 0..500 {
                    let speed = f64::from(1 + (k + thread) % 9);
                    match step(speed) {
                        (MtbStatus::Ok, force) => {
                            let wanted = 3.0 * (0.5 - 0.04 * speed);
                            assert!((force[0] - wanted).abs() < 1e-9, "{force:?}");
                        }
                        (status, force) => {
                            assert_eq!(status, MtbStatus::BadArgument);
                            assert!(message().contains("or one that was freed"));
                            assert_eq!(force, [UNTOUCHED; 3]);
                        }
                    }
                    if thread == 0 && k == 400 {
                        assert_eq!(mtb_contact_free(handle), MtbStatus::Ok);
                    }
                }
            });
        }
    });
    assert_eq!(step(1.0).0, MtbStatus::BadArgument);
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! The door of wheels as callers misuse it: any wheels, any bytes, any order of calls with any numbers.

use mtb_contact::friction::{Friction, Memory, SlipLaw};
use mtb_elasticity::Material;
use mtb_elasticity::half_space::Pair;
use mtb_geometry::{Profile, WheelOnRail};
use mtb_wheelset::{RailFriction, Sides, WheelFriction, Wheelset};

use super::*;
use crate::wheels::*;

/// Room of the caller's for each field; what a call writes beyond the length that it was told is found.
const ROOM: usize = 4096;
const UNTOUCHED_STATUS: i32 = -7;

/// Wheels on a grid that is coarse, for the sake of time.
fn wheelset(sides: Sides, friction: WheelFriction, standstill_speed: Option<f64>) -> Wheelset {
    let steel = Some(Material::new(80e9, 0.3).unwrap());
    let track = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    let bodies = Pair {
        lower: steel,
        upper: steel,
    };
    Wheelset {
        sides,
        friction,
        standstill_speed,
        spacing: [3e-3; 2],
        ..Wheelset::new(track, bodies, 60e3).unwrap()
    }
}

fn laws() -> Vec<WheelFriction> {
    let law = SlipLaw::Exponential {
        at_rest: 0.4,
        kinetic: 0.2,
        half_slip: 0.5,
    };
    let memory = Some(Memory {
        distance: 1e-3,
        min_slip: 1e-3,
    });
    let map = RailFriction::new(vec![0.0, 1e-3], vec![-1e-2, 1e-2], vec![0.1, 0.2, 0.3, 0.4]);
    vec![
        Friction::Coulomb(vec![0.3]).into(),
        Friction::SpeedDependent { law, memory }.into(),
        WheelFriction::OnRail(map.unwrap()),
    ]
}

fn any_wheelset() -> impl Strategy<Value = Wheelset> {
    (
        prop::sample::select(vec![Sides::Left, Sides::Right, Sides::Both]),
        prop::sample::select(laws()),
        prop::option::of(Just(0.1)),
    )
        .prop_map(|(sides, friction, speed)| wheelset(sides, friction, speed))
}

/// A call, with what may be wrong in it; `null` counts pointers that are null, bit by bit.
#[derive(Clone, Debug)]
struct Call {
    what: usize,
    handle: Handle,
    null: u8,
    index: u64,
    length: u64,
    pose: [f64; 6],
    velocity: [f64; 6],
    /// Place and value of a number of the state that is changed before it is given back.
    changed: Option<(usize, f64)>,
}

fn small() -> impl Strategy<Value = f64> {
    prop_oneof![4 => Just(0.0), 4 => -2e-3..2e-3, 1 => Just(f64::NAN), 1 => number()]
}

fn any_call() -> impl Strategy<Value = Call> {
    let handle = prop_oneof![
        8 => any::<usize>().prop_map(Handle::Live),
        1 => any::<usize>().prop_map(Handle::Freed),
        1 => any::<u64>().prop_map(Handle::Any),
    ];
    let null = prop_oneof![3 => Just(0_u8), 1 => any::<u8>()];
    let length = prop_oneof![
        3 => Just(ROOM as u64), // taken for the length that is right
        1 => 0..9_u64,
        1 => prop::sample::select(vec![u64::MAX, u64::MAX / 2 + 2, 1 << 61, 1 << 32])
    ];
    let index = prop_oneof![4 => 0..2_u64, 1 => any::<u64>()];
    // rolling, with the wheel's rotation near what it rolls with
    let velocity =
        (number(), prop::array::uniform3(small()), any::<bool>()).prop_map(|(v, w, rolls)| {
            let v = if rolls { 20.0 } else { v };
            [v, w[0], 0.0, w[1], v / 0.46, w[2]]
        });
    (
        (0..15_usize, handle, null, index, length),
        prop::array::uniform6(small()),
        velocity,
        prop::option::of((any::<usize>(), number())),
    )
        .prop_map(|(kind, pose, velocity, changed)| Call {
            what: kind.0,
            handle: kind.1,
            null: kind.2,
            index: kind.3,
            length: kind.4,
            pose,
            velocity,
            changed,
        })
}

/// The points of the patch that a call is about, if there is one.
fn points(handle: u64, index: u64) -> Option<usize> {
    patch(handle, index).map(|patch| (patch.nx * patch.ny) as usize)
}

/// Its rows likewise.
fn rows_of(handle: u64, index: u64) -> Option<usize> {
    patch(handle, index).map(|patch| patch.ny as usize)
}

fn patch(handle: u64, index: u64) -> Option<MtbWheelPatch> {
    let mut patch = std::mem::MaybeUninit::<MtbWheelPatch>::uninit();
    // SAFETY: room for a patch, read only where it was written
    unsafe {
        let status = mtb_wheels_patch(handle, index, patch.as_mut_ptr());
        (status == MtbStatus::Ok).then(|| patch.assume_init())
    }
}

fn state_of(handle: u64) -> Vec<f64> {
    let mut n = 0;
    // SAFETY: a number, then room for that many
    unsafe {
        if mtb_wheels_state_size(handle, &raw mut n) != MtbStatus::Ok {
            return Vec::new();
        }
        let mut state = vec![0.0; n as usize];
        assert_eq!(
            mtb_wheels_state(handle, n, state.as_mut_ptr()),
            MtbStatus::Ok
        );
        state
    }
}

/// `written` numbers were, and nothing behind them.
fn check_written(numbers: &[f64], written: usize) {
    let (of_call, rest) = numbers.split_at(written);
    assert!(of_call.iter().all(|v| v.is_finite()));
    assert!(rest.iter().all(|v| *v == UNTOUCHED));
}

fn check_step(step: &MtbWheelStep, is_steady: bool) {
    let vectors = step.force.iter().chain(&step.moment).chain(&step.pose);
    let rest = step.vertical_force.iter().chain(&step.reference_point);
    let all_finite = vectors
        .chain(rest)
        .chain([&step.friction_power])
        .all(|v| v.is_finite());
    // that of the balance is NaN where the height was given
    assert!(all_finite && !step.balance_error.is_infinite(), "{step:?}");
    // transient tractions give back what they have moved the surfaces by
    assert!(step.friction_power >= 0.0 || !is_steady, "{step:?}");
}

impl Caller {
    fn make_with_wheels(&mut self, call: &Call, path: &CString) -> MtbStatus {
        let handle = self.handle(&call.handle);
        let is_null = |k: u8| call.null >> k & 1 == 1;
        let mut room = [(); 3].map(|()| vec![UNTOUCHED; 2 * ROOM]);
        let mut at = |k: usize| {
            if is_null(k as u8) {
                null_mut()
            } else {
                room[k].as_mut_ptr()
            }
        };
        // SAFETY: pointers are null or to arrays longer than what is written to them
        unsafe {
            match call.what {
                0 | 1 => {
                    let mut new = 0;
                    let out = if is_null(0) { null_mut() } else { &raw mut new };
                    let status = if call.what == 0 {
                        mtb_wheels_load(if is_null(1) { null() } else { path.as_ptr() }, out)
                    } else {
                        mtb_wheels_copy(handle, out)
                    };
                    assert_eq!(new != 0, status == MtbStatus::Ok);
                    self.live.extend((new != 0).then_some(new));
                    status
                }
                2 => {
                    let is_live = self.live.contains(&handle);
                    let status = mtb_wheels_free(handle);
                    assert!(!is_live || status == MtbStatus::Ok);
                    if is_live {
                        self.live.retain(|h| *h != handle);
                        self.freed.push(handle);
                    }
                    status
                }
                3 => {
                    let status = mtb_wheels_reference_point(handle, at(0));
                    check_written(&room[0], if status == MtbStatus::Ok { 3 } else { 0 });
                    status
                }
                kind @ 4..=6 => {
                    let mut step = std::mem::MaybeUninit::<MtbWheelStep>::uninit();
                    let pose = if is_null(0) {
                        null()
                    } else {
                        call.pose.as_ptr()
                    };
                    let velocity = if is_null(1) {
                        null()
                    } else {
                        call.velocity.as_ptr()
                    };
                    let out = if is_null(2) {
                        null_mut()
                    } else {
                        step.as_mut_ptr()
                    };
                    let status = if kind == 6 {
                        // times of any size, and none
                        let duration = 2e-6 * call.velocity[0];
                        mtb_wheels_step_transient(handle, pose, velocity, duration, null_mut(), out)
                    } else {
                        mtb_wheels_step(handle, pose, velocity, out)
                    };
                    if status == MtbStatus::Ok {
                        check_step(&step.assume_init(), kind != 6);
                    }
                    status
                }
                7 => {
                    let mut patch = std::mem::MaybeUninit::<MtbWheelPatch>::uninit();
                    let out = if is_null(0) {
                        null_mut()
                    } else {
                        patch.as_mut_ptr()
                    };
                    let status = mtb_wheels_patch(handle, call.index, out);
                    if status == MtbStatus::Ok {
                        let patch = patch.assume_init();
                        assert!(patch.normal_force.is_finite() && patch.side.abs() == 1);
                    }
                    status
                }
                8 => {
                    let right = points(handle, call.index);
                    let n = match right {
                        Some(n) if call.length == ROOM as u64 => n as u64,
                        _ => call.length,
                    };
                    let mut status_of = vec![UNTOUCHED_STATUS; ROOM];
                    let [p, t, s] = [at(0), at(1), at(2)];
                    let codes = if is_null(3) {
                        null_mut()
                    } else {
                        status_of.as_mut_ptr()
                    };
                    let status = mtb_wheels_fields(handle, call.index, n, p, t, s, codes);
                    let is_good = status == MtbStatus::Ok;
                    for (k, numbers) in room.iter().enumerate() {
                        let each = if k == 0 { n } else { 2 * n };
                        let written = if is_good && !is_null(k as u8) {
                            each
                        } else {
                            0
                        };
                        // lengths are judged field by field: one that fits is written before one that does not
                        if is_good {
                            check_written(numbers, written as usize);
                        }
                    }
                    if is_good && !is_null(3) {
                        let (own, rest) = status_of.split_at(n as usize);
                        assert!(own.iter().all(|c| (0..=2).contains(c)));
                        assert!(rest.iter().all(|c| *c == UNTOUCHED_STATUS));
                    }
                    status
                }
                9 => {
                    let mut n = 0;
                    mtb_wheels_state_size(handle, if is_null(0) { null_mut() } else { &raw mut n })
                }
                10 => {
                    let right = state_of(handle).len();
                    let n = if call.length == ROOM as u64 {
                        right as u64
                    } else {
                        call.length
                    };
                    let mut state = vec![UNTOUCHED; right + 1];
                    let out = if is_null(0) {
                        null_mut()
                    } else {
                        state.as_mut_ptr()
                    };
                    let status = mtb_wheels_state(handle, n, out);
                    let written = if status == MtbStatus::Ok { right } else { 0 };
                    check_written(&state, written);
                    status
                }
                11 => {
                    let status = mtb_wheels_derivatives(handle, at(0));
                    check_written(&room[0], if status == MtbStatus::Ok { 108 } else { 0 });
                    status
                }
                12 => {
                    let status = mtb_wheels_derivatives_under(handle, at(0));
                    check_written(&room[0], if status == MtbStatus::Ok { 1300 } else { 0 });
                    status
                }
                13 => {
                    let right = rows_of(handle, call.index);
                    let n = match right {
                        Some(n) if call.length == ROOM as u64 => n as u64,
                        _ => call.length,
                    };
                    let [p, d] = [at(0), at(1)];
                    let status = mtb_wheels_rows(handle, call.index, n, p, d);
                    if status == MtbStatus::Ok {
                        for (k, each) in [3, 9].into_iter().enumerate() {
                            let written = if is_null(k as u8) { 0 } else { each * n };
                            check_written(&room[k], written as usize);
                        }
                    }
                    status
                }
                _ => {
                    let mut state = state_of(handle);
                    if let (Some((place, value)), false) = (call.changed, state.is_empty()) {
                        let k = place % state.len();
                        state[k] = value;
                    }
                    // the length of what the caller holds is the caller's word
                    let n = call.length.min(state.len() as u64);
                    let from = if is_null(0) { null() } else { state.as_ptr() };
                    mtb_wheels_resume(handle, n, from)
                }
            }
        }
    }
}

proptest! {
    // a step takes milliseconds
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases / 8))]

    #[test]
    fn any_calls_with_wheels_end_with_a_status_and_a_message(
        wheels in any_wheelset(),
        calls in prop::collection::vec(any_call(), 1..24),
    ) {
        let (path, text) = file(&wheels.to_bytes());
        let mut first = 0;
        // SAFETY: a text and a number
        prop_assert_eq!(unsafe { mtb_wheels_load(text.as_ptr(), &raw mut first) }, MtbStatus::Ok);
        let mut caller = Caller { live: vec![first], freed: Vec::new() };
        for call in &calls {
            let status = caller.make_with_wheels(call, &text);
            prop_assert_ne!(status, MtbStatus::Internal, "{:?}: {}", call, message());
            prop_assert_eq!(status == MtbStatus::Ok, message().is_empty(), "{:?}: {}", call, message());
        }
        std::fs::remove_file(path).unwrap();
        for handle in caller.live {
            prop_assert_eq!(mtb_wheels_free(handle), MtbStatus::Ok);
            prop_assert_eq!(mtb_wheels_free(handle), MtbStatus::BadArgument);
        }
    }

    #[test]
    fn any_bytes_of_a_file_are_the_wheels_or_refused(
        made_up in prop::collection::vec(any::<u8>(), 0..200),
        changes in prop::collection::vec((any::<usize>(), any::<u8>()), 0..4),
        cut in 0..40_usize,
        kind in 0..3_usize,
    ) {
        let sound = wheelset(Sides::Left, laws().remove(0), None).to_bytes();
        let data = match kind {
            0 => made_up,
            // a file of the other kind
            1 => BYTES.clone(),
            _ => {
                let mut data = sound.clone();
                for (place, byte) in changes {
                    let at = place % data.len();
                    data[at] = byte;
                }
                data.truncate(data.len() - cut.saturating_sub(20));
                data
            }
        };
        let (path, text) = file(&data);
        let mut handle = 0;
        // SAFETY: a text and a number
        let status = unsafe { mtb_wheels_load(text.as_ptr(), &raw mut handle) };
        std::fs::remove_file(path).unwrap();
        if data == sound {
            prop_assert_eq!(status, MtbStatus::Ok);
            prop_assert_eq!(mtb_wheels_free(handle), MtbStatus::Ok);
        } else {
            prop_assert_eq!(status, MtbStatus::BadFile);
            prop_assert!(!message().is_empty());
            prop_assert_eq!(handle, 0);
        }
    }
}

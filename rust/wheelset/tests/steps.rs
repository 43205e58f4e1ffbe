// SPDX-License-Identifier: MIT OR Apache-2.0
//! Steps of a wheelset: balance, mirrors, memory, bytes; what cannot be is an error, never a panic.

use std::cell::Cell;
use std::ops::ControlFlow;

use mtb_contact::friction::{Friction, Memory, SlipLaw};
use mtb_elasticity::Material;
use mtb_elasticity::half_space::Pair;
use mtb_geometry::{Interpolation, Profile, WheelOnRail};
use mtb_operator::{Progress, unmonitored};
use mtb_wheelset::{
    Error, Found, PatchRatio, PreparedWheels, RailFriction, Side, Sides, Velocity, WheelFriction,
    WheelPatch, WheelState, WheelStep, Wheelset,
};
use proptest::prelude::*;

const FORCE: f64 = 60e3;
const SPEED: f64 = 20.0;
const FREE: f64 = f64::NAN;
/// Looks at the monitor after which a step is broken off.
const LOOKS: usize = 5000;

fn steel() -> Pair {
    let steel = Some(Material::new(80e9, 0.3).unwrap());
    Pair {
        lower: steel,
        upper: steel,
    }
}

fn wheelset(sides: Sides) -> Wheelset {
    let track = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    Wheelset {
        sides,
        spacing: [1.5e-3; 2],
        ..Wheelset::new(track, steel(), FORCE).unwrap()
    }
}

fn prepared(sides: Sides) -> PreparedWheels {
    PreparedWheels::new(wheelset(sides)).unwrap()
}

fn solve(wheels: &mut PreparedWheels, pose: [f64; 6]) -> Result<WheelStep, Error> {
    wheels.step(pose, Velocity::Rolling(SPEED), &unmonitored)
}

/// The same with an end to its work, for wheels that nobody has thought about.
fn bounded(wheels: &mut PreparedWheels, pose: [f64; 6]) -> Result<WheelStep, Error> {
    let looks = Cell::new(0);
    let monitor = |_: Progress| {
        looks.set(looks.get() + 1);
        if looks.get() < LOOKS {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    };
    wheels.step(pose, Velocity::Rolling(SPEED), &monitor)
}

/// What the fields of a wheel carry, pressures and tractions.
fn vertical(step: &WheelStep, side: Side) -> f64 {
    let of = step.patches.iter().filter(|p| p.side == side);
    let carried = |p: &WheelPatch| {
        let n = p.pressure.len();
        let share = |k: usize| {
            let local = [p.traction[k], p.traction[n + k], -p.pressure[k]];
            -(0..3).map(|j| p.rotation[2][j] * local[j]).sum::<f64>()
        };
        p.grid.cell_area() * (0..n).map(share).sum::<f64>()
    };
    of.map(carried).sum()
}

#[test]
fn each_wheel_carries_its_force() {
    let mut wheels = prepared(Sides::Both);
    for y in [0.0, 3e-3, -6.4e-3] {
        let step = solve(&mut wheels, [0.0, y, FREE, FREE, 0.0, 1e-3]).unwrap();
        for side in [Side::Left, Side::Right] {
            assert!((vertical(&step, side) / FORCE - 1.0).abs() < 1e-8, "{y}");
        }
    }
    let level = solve(&mut wheels, [0.0, 3e-3, FREE, 0.0, 0.0, 0.0]).unwrap();
    let both = vertical(&level, Side::Left) + vertical(&level, Side::Right);
    assert!((both / (2.0 * FORCE) - 1.0).abs() < 1e-8);
    let lifted = solve(&mut wheels, [0.0, 0.0, 1e-3, 0.0, 0.0, 0.0]).unwrap();
    assert!(lifted.patches.is_empty() && lifted.force == [0.0; 3]);
}

#[test]
fn force_and_heat_are_those_of_the_fields() {
    let step = prepared(Sides::Both)
        .step(
            [0.0, 5.5e-3, FREE, FREE, 0.0, 2e-3],
            Velocity::Rigid([SPEED, 0.1, 0.0, 0.02, 1.003 * SPEED / 0.46, 0.05]),
            &unmonitored,
        )
        .unwrap();
    let (mut force, mut by_cells) = ([0.0; 3], 0.0);
    for patch in &step.patches {
        let n = patch.pressure.len();
        for k in 0..n {
            let area = patch.grid.cell_area();
            let local = [patch.traction[k], patch.traction[n + k], -patch.pressure[k]];
            for i in 0..3 {
                force[i] += area * (0..3).map(|j| patch.rotation[i][j] * local[j]).sum::<f64>();
            }
            let slip = [patch.slip_velocity[k], patch.slip_velocity[n + k]];
            by_cells += area * (local[0] * slip[0] + local[1] * slip[1]);
            let bound = 0.3 * patch.pressure[k] * (1.0 + 1e-6) + 1.0;
            assert!(local[0].hypot(local[1]) <= bound);
        }
    }
    for i in 0..3 {
        assert!((force[i] - step.force[i]).abs() < 1e-6);
    }
    assert!(by_cells > 0.0 && by_cells < step.friction_power);
}

#[test]
fn right_is_the_mirror_image_of_left() {
    let pose = [0.0, 2e-3, -1.5e-4, 2e-5, 0.0, 4e-3];
    let velocity = [SPEED, 0.05, 0.0, 0.0, SPEED / 0.46, 0.2];
    let flip = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0];
    let mirrored = |v: [f64; 6]| std::array::from_fn(|k| flip[k] * v[k]);
    let mut wheels = prepared(Sides::Both);
    let here = wheels
        .step(pose, Velocity::Rigid(velocity), &unmonitored)
        .unwrap();
    let there = wheels
        .without_memory()
        .step(
            mirrored(pose),
            Velocity::Rigid(mirrored(velocity)),
            &unmonitored,
        )
        .unwrap();
    for c in 0..3 {
        let size = here.force[2].abs();
        assert!((there.force[c] - flip[c] * here.force[c]).abs() < 1e-9 * size);
        assert!((there.moment[c] + flip[c] * here.moment[c]).abs() < 1e-9 * size);
    }
}

#[test]
fn memory_changes_nothing_but_time() {
    let mut wheels = prepared(Sides::Left);
    let (mut warm_steps, mut cold_steps) = (0, 0);
    for k in 0..5 {
        let along = f64::from(k) / 3.0;
        let pose = [0.0, 1e-3 * along.sin(), FREE, 0.0, 0.0, 1e-3 * along.cos()];
        let mut cold = wheels.without_memory();
        let warm = solve(&mut wheels, pose).unwrap();
        let cold = solve(&mut cold, pose).unwrap();
        for c in 0..3 {
            assert!((warm.force[c] - cold.force[c]).abs() < 1e-5 * FORCE);
        }
        warm_steps += warm.iterations;
        cold_steps += cold.iterations;
        // through numbers, as the C interface has it
        let state = WheelState::from_numbers(&wheels.state().to_numbers()).unwrap();
        assert_eq!(&state, wheels.state());
        wheels.resume(state).unwrap();
    }
    assert!(warm_steps < cold_steps);
}

#[test]
fn what_cannot_be_asked_is_named() {
    let mut wheels = prepared(Sides::Left);
    let rolling = Velocity::Rolling(SPEED);
    let still = [0.0, 0.0, FREE, 0.0, 0.0, 0.0];
    let with = |k: usize, value: f64| {
        let mut pose = still;
        pose[k] = value;
        pose
    };
    for (pose, velocity, wanted) in [
        (with(0, FREE), rolling, "pose is [NaN"),
        (with(3, FREE), rolling, "pose is [0.0, 0.0, NaN, NaN"),
        (with(1, f64::INFINITY), rolling, "pose[1] is inf"),
        (
            with(0, 1e7),
            rolling,
            "pose, x, is 1e+07 m: at most 1e+06 m",
        ),
        (with(5, 1.0), rolling, "yaw is 1 rad: at most 0.5 rad"),
        (with(3, -0.6), rolling, "roll is -0.6 rad"),
        (with(1, 0.5), rolling, "the bodies never touch: the wheel"),
        (with(2, -2e-2), rolling, "the contact"),
        (still, Velocity::Rolling(FREE), "velocity[0] is NaN"),
        (
            still,
            Velocity::Rigid([1.0, 2.0, 3.0, 4.0, 1e31, 0.0]),
            "velocity[4] is 1e+31",
        ),
        (
            still,
            Velocity::Rolling(0.0),
            "the left wheel does not roll",
        ),
    ] {
        let error = wheels.step(pose, velocity, &unmonitored).unwrap_err();
        assert!(error.to_string().starts_with(wanted), "{error}");
        assert!(!error.is_not_converged());
    }
    let change = |change: &dyn Fn(&mut Wheelset)| {
        let mut given = wheelset(Sides::Left);
        change(&mut given);
        PreparedWheels::new(given)
            .map(|_| ())
            .unwrap_err()
            .to_string()
    };
    for (message, wanted) in [
        (change(&|w| w.force = -1.0), "force is -1: a positive"),
        (change(&|w| w.spacing[1] = FREE), "spacing across is NaN"),
        (change(&|w| w.layer = -1.0), "layer is -1"),
        (
            change(&|w| w.standstill_speed = Some(0.0)),
            "standstill_speed is 0",
        ),
        (
            change(&|w| w.reference_point[2] = FREE),
            "reference_point[2] is NaN",
        ),
        (
            change(&|w| w.friction = Friction::Coulomb(vec![0.1, 0.2]).into()),
            "friction has 2 coefficients",
        ),
        (change(&|w| w.pair.gauge = 0.0), "gauge is 0"),
    ] {
        assert!(message.starts_with(wanted), "{message}");
    }
    let rigid = Pair {
        lower: None,
        upper: None,
    };
    let track = || WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    assert!(matches!(
        Wheelset::new(track(), rigid, FORCE),
        Err(Error::Elasticity(_))
    ));
}

#[test]
fn a_step_is_interrupted_and_the_memory_stays() {
    for sides in [Sides::Left, Sides::Both] {
        let mut wheels = prepared(sides);
        let pose = [0.0, 0.0, FREE, 0.0, 0.0, 0.0];
        solve(&mut wheels, pose).unwrap();
        let kept = wheels.state().clone();
        let caller = std::thread::current().id();
        let calls = Cell::new(0);
        let stop = |_: Progress| {
            assert_eq!(std::thread::current().id(), caller);
            calls.set(calls.get() + 1);
            if calls.get() > 2 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let error = wheels
            .step(pose, Velocity::Rolling(-SPEED), &stop)
            .unwrap_err();
        assert_eq!(error, Error::Interrupted);
        assert_eq!(wheels.state(), &kept);
    }
}

/// Both wheels are solved at once, and on a thread of a pool one after the other.
#[test]
fn steps_do_not_depend_on_the_number_of_threads() {
    let ride = || {
        let mut wheels = prepared(Sides::Both);
        let poses = [-2e-3, 1e-3, 4e-3].map(|y| [0.0, y, FREE, FREE, 0.0, 2e-3]);
        poses.map(|pose| {
            let step = solve(&mut wheels, pose).unwrap();
            let counts = (step.normal_solves, step.iterations);
            (step.pose, step.force, step.moment, counts)
        })
    };
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    assert_eq!(ride(), one.unwrap().install(ride));
}

fn laws() -> Vec<WheelFriction> {
    let memory = Some(Memory {
        distance: 1e-3,
        min_slip: 1e-3,
    });
    let exponential = SlipLaw::Exponential {
        at_rest: 0.4,
        kinetic: 0.2,
        half_slip: 0.5,
    };
    let table = SlipLaw::Table {
        slip_speed: vec![0.0, 1.0],
        coefficient: vec![0.4, 0.2],
    };
    let map = RailFriction::new(vec![0.0, 1e-3], vec![-1e-2, 1e-2], vec![0.1, 0.2, 0.3, 0.4]);
    vec![
        Friction::Coulomb(vec![0.3]).into(),
        Friction::StaticKinetic {
            at_rest: 0.4,
            kinetic: 0.3,
        }
        .into(),
        Friction::SpeedDependent {
            law: exponential,
            memory,
        }
        .into(),
        Friction::SpeedDependent {
            law: table,
            memory: None,
        }
        .into(),
        WheelFriction::OnRail(map.unwrap()),
    ]
}

#[test]
fn bytes_come_back_and_changes_are_found() {
    for (k, friction) in laws().into_iter().enumerate() {
        let given = Wheelset {
            friction,
            standstill_speed: (k == 1).then_some(0.1),
            bodies: Pair {
                upper: if k == 2 { None } else { steel().upper },
                ..steel()
            },
            right: (k > 0).then(|| WheelOnRail {
                wheel_radius: 0.45,
                ..wheelset(Sides::Left).pair
            }),
            ..wheelset([Sides::Left, Sides::Right, Sides::Both][k % 3])
        };
        let bytes = given.to_bytes();
        assert_eq!(Wheelset::from_bytes(&bytes).unwrap(), given);
        let step = prepared(Sides::Left);
        assert!(step.wheelset() != &given || k == 0);
        for cut in 0..bytes.len() {
            assert!(Wheelset::from_bytes(&bytes[..cut]).is_err());
            let mut changed = bytes.clone();
            changed[cut] ^= 0x10;
            assert!(Wheelset::from_bytes(&changed).is_err(), "at {cut}");
        }
    }
}

#[test]
fn wheels_of_one_axle_sit_on_it_alike() {
    let given = wheelset(Sides::Both);
    let right = WheelOnRail {
        tape_circle: 0.08,
        ..given.pair.clone()
    };
    let apart = Wheelset {
        right: Some(right),
        ..given
    };
    assert!(matches!(PreparedWheels::new(apart), Err(Error::TwoAxles)));
}

/// With the checksum that the header of the file has.
fn with_checksum(mut bytes: Vec<u8>) -> Vec<u8> {
    let sum = u64::from(crc32fast::hash(&bytes[24..]));
    bytes[16..24].copy_from_slice(&sum.to_le_bytes());
    bytes
}

fn numbers() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -1e-2..1e-2,
        2 => -100.0..100.0,
        1 => any::<f64>(),
        1 => prop::sample::select(vec![
            0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e30, -1e300, f64::MIN_POSITIVE
        ]),
    ]
}

/// A step that was solved has no number that is not finite.
fn is_finite(step: &WheelStep) -> bool {
    let totals = step.force.iter().chain(&step.moment).chain(&step.pose);
    totals.chain([&step.friction_power]).all(|v| v.is_finite())
        && step.patches.iter().all(|p| {
            let fields = p.pressure.iter().chain(&p.traction).chain(&p.slip_velocity);
            fields.chain(&p.creepage).all(|v| v.is_finite())
        })
}

proptest! {
    // a step takes milliseconds
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases / 6))]

    #[test]
    fn any_pose_and_velocity_are_solved_or_an_error(
        pose in prop::array::uniform6(prop_oneof![3 => numbers(), 1 => Just(0.0)]),
        is_free in any::<[bool; 2]>(),
        velocity in prop::array::uniform6(numbers()),
    ) {
        let mut pose = pose;
        for (k, is_free) in is_free.into_iter().enumerate() {
            if is_free {
                pose[2 + k] = FREE;
            }
        }
        let mut wheels = PreparedWheels::new(Wheelset {
            spacing: [3e-3; 2],
            ..wheelset(Sides::Both)
        })
        .unwrap();
        for velocity in [Velocity::Rigid(velocity), Velocity::Rolling(velocity[0])] {
            if let Ok(step) = wheels.step(pose, velocity, &unmonitored) {
                prop_assert!(is_finite(&step));
            }
        }
    }

    #[test]
    fn any_state_is_taken_or_an_error(
        depth in prop::collection::vec(numbers().prop_map(f64::abs), 0..3),
        first in any::<[i64; 2]>(),
        near in prop::array::uniform2(-6_i64..6),
        is_near in any::<bool>(),
        found in prop::option::of((prop::array::uniform6(numbers()), prop::collection::vec(numbers(), 0..5))),
        ratio in prop::collection::vec(numbers(), 24),
    ) {
        let mut wheels = prepared(Sides::Left);
        let state = WheelState {
            depth,
            found: found.map(|([lateral, creepage, a, b, c, d], slope)| Found {
                lateral,
                creepage,
                rails: [[a, b], [c, d]],
                slope,
            }),
            patches: vec![PatchRatio {
                history: None,
                side: Side::Left,
                first: if is_near { near } else { first },
                nx: 4,
                ny: 3,
                ratio,
            }],
        };
        if wheels.resume(state).is_ok() {
            let pose = [0.0, 0.0, FREE, 0.0, 0.0, 0.0];
            if let Ok(step) = solve(&mut wheels, pose) {
                prop_assert!(is_finite(&step));
                prop_assert!((vertical(&step, Side::Left) / FORCE - 1.0).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn no_bytes_make_it_panic(
        at in any::<prop::sample::Index>(),
        value in prop_oneof![numbers().prop_map(f64::to_bits), 0_u64..100, any::<u64>()],
        friction in prop::sample::select(laws()),
    ) {
        let short = Profile::from_points(
            &[-0.04, 0.0, 0.05],
            &[-1e-3, 0.0, 1e-3],
            Interpolation::Smooth,
        );
        let given = wheelset(Sides::Both);
        let bytes = Wheelset {
            pair: WheelOnRail { wheel: short.unwrap(), ..given.pair },
            friction,
            ..given
        }
        .to_bytes();
        let place = 24 + 8 * at.index((bytes.len() - 24) / 8);
        let mut changed = bytes;
        changed[place..place + 8].copy_from_slice(&value.to_le_bytes());
        if let Ok(mut wheels) =
            Wheelset::from_bytes(&with_checksum(changed)).and_then(PreparedWheels::new)
            && let Ok(step) = bounded(&mut wheels, [0.0, 0.0, FREE, 0.0, 0.0, 0.0])
        {
            prop_assert!(is_finite(&step));
        }
    }

    #[test]
    fn no_short_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(Wheelset::from_bytes(&bytes).is_err());
    }
}

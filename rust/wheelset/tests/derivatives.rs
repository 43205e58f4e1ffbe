// SPDX-License-Identifier: MIT OR Apache-2.0
//! All derivatives of steps of wheels against central differences of the very same steps.

use std::collections::BTreeMap;

use mtb_contact::friction::{Friction, Memory, SlipLaw};
use mtb_elasticity::Material;
use mtb_elasticity::half_space::Pair;
use mtb_geometry::{Profile, WheelOnRail};
use mtb_operator::unmonitored;
use proptest::prelude::*;

use mtb_wheelset::{
    Accuracy, Alignment, AxleLoad, Error, PreparedWheels, RailFriction, RailSprings, Sides,
    StepInput, Velocity, WheelChange, WheelFriction, WheelInput, WheelPatch, WheelState, WheelStep,
    Wheelset,
};

/// Differences need solutions far better than their own errors.
const EXACT: Accuracy = Accuracy {
    normal: 1e-14,
    tangential: 1e-12,
    force: 1e-12,
};

/// A wheel alone has slip of second order, both have it of first order.
fn wheelset(sides: Sides, friction: impl Into<WheelFriction>) -> Wheelset {
    let steel = |nu| Some(Material::new(80e9, nu).unwrap());
    let bodies = Pair {
        lower: steel(0.3),
        upper: steel(0.25),
    };
    let pair = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    Wheelset {
        sides,
        spacing: [1e-3; 2],
        friction: friction.into(),
        layer: 2e-15,
        second_order: sides == Sides::Left,
        ..Wheelset::new(pair, bodies, 60e3).unwrap()
    }
}

/// The same on patches that follow the rail.
fn conformal(sides: Sides, friction: impl Into<WheelFriction>) -> Wheelset {
    let plain = wheelset(sides, friction);
    Wheelset {
        bodies: Pair {
            upper: plain.bodies.lower,
            ..plain.bodies
        },
        conformal: true,
        ..plain
    }
}

/// Error of a solved number over the largest of its kind: some times those of the force that a height is found for and
/// of the tractions, most at the edge of a contact (1.1e-11 is the largest seen).
const NOISE: f64 = 20.0;

/// Of equilibria, whose forces across and along are made of tractions of that accuracy.
const SETTLED: Accuracy = Accuracy {
    normal: 1e-14,
    tangential: 1e-11,
    force: 1e-10,
};

/// All numbers of a step, or of its change, with the size of their kind.
fn numbers(step: &WheelStep) -> Vec<(&'static str, f64)> {
    let mut all = Vec::new();
    let mut put = |name, values: &[f64]| all.extend(values.iter().map(|v| (name, *v)));
    put("force", &step.force);
    put("moment", &step.moment);
    put("vertical force", &step.vertical_force);
    put("pose", &step.pose);
    put("velocity", &step.velocity);
    put(
        "displacement of rails",
        step.rail_displacement.as_flattened(),
    );
    put("friction power", &[step.friction_power]);
    for patch in &step.patches {
        put("position", &patch.position);
        put("contact angle", &[patch.contact_angle]);
        put("rail position", &[patch.rail_position]);
        put("wheel position", &[patch.wheel_position]);
        put("approach", &[patch.approach]);
        put("creepage", &patch.creepage);
        put("rolling speed", &[patch.rolling_speed]);
        put("friction power of a patch", &[patch.friction_power]);
        put("force of a patch", &patch.load(step.reference_point)[0]);
        put("pressure", &patch.pressure);
        put("traction", &patch.traction);
        put("slip velocity", &patch.slip_velocity);
    }
    all
}

fn changes(change: &WheelChange) -> Vec<f64> {
    let mut all = Vec::new();
    all.extend(change.force);
    all.extend(change.moment);
    all.extend(change.vertical_force);
    all.extend(change.pose);
    all.extend(change.velocity);
    all.extend(change.rail_displacement.as_flattened());
    all.push(change.friction_power);
    for patch in &change.patches {
        all.extend(patch.position);
        all.push(patch.contact_angle);
        all.push(patch.rail_position);
        all.push(patch.wheel_position);
        all.push(patch.approach);
        all.extend(patch.creepage);
        all.push(patch.rolling_speed);
        all.push(patch.friction_power);
        all.extend(patch.force);
        all.extend(&patch.pressure);
        all.extend(&patch.traction);
        all.extend(&patch.slip_velocity);
    }
    all
}

/// How many parameters a law has, and the law with one of them changed.
type Law<'a> = (usize, &'a dyn Fn(usize, f64) -> WheelFriction);

/// A step without memory, so that differences have no memory; `None` where it is not found to such an accuracy.
fn found(wheels: &PreparedWheels, pose: [f64; 6], velocity: Velocity) -> Option<WheelStep> {
    let mut wheels = wheels.without_memory();
    wheels.step(pose, velocity, &unmonitored).ok()
}

fn solved(wheels: &PreparedWheels, pose: [f64; 6], velocity: Velocity) -> WheelStep {
    found(wheels, pose, velocity).unwrap()
}

/// Which points are in contact, stick and slip, patch by patch.
fn states(step: &WheelStep) -> Vec<Vec<u8>> {
    let of_patch = |patch: &WheelPatch| patch.status.iter().map(|s| *s as u8).collect();
    step.patches.iter().map(of_patch).collect()
}

/// Whether a derivative was compared with central differences of steps whose number is `share` times `small` further:
/// not where a point changes its state on the way, or the differences themselves depend on their width.
fn check(
    what: &str,
    found: &WheelChange,
    small: f64,
    accuracy: Accuracy,
    at: &dyn Fn(f64) -> Option<WheelStep>,
) -> bool {
    let solved = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|share: f64| at(share * small));
    let [Some(a), Some(b), Some(c), Some(d), Some(e)] = solved else {
        return false;
    };
    let solved = [a, b, c, d, e];
    if solved.iter().any(|step| states(step) != states(&solved[0])) {
        return false;
    }
    let steps = solved.map(|step| numbers(&step));
    let found = changes(found);
    let slopes = |i: usize| {
        let [a, b, _, c, d] = [0, 1, 2, 3, 4].map(|j| steps[j][i].1);
        [(d - a) / (2.0 * small), (c - b) / small]
    };
    // the largest of a kind, and an error of one of its numbers over the width
    let (mut size, mut noise) = (BTreeMap::new(), BTreeMap::new());
    for (i, (name, value)) in steps[0].iter().enumerate() {
        let size: &mut f64 = size.entry(*name).or_default();
        *size = size.max(slopes(i)[0].abs());
        let noise: &mut f64 = noise.entry(*name).or_default();
        *noise = noise.max(NOISE * accuracy.force * value.abs() / small);
    }
    let is_smooth = |i: usize| {
        let (name, [wide, near]) = (steps[0][i].0, slopes(i));
        // of a kink the second difference goes with the width, otherwise with its square; noise makes 8 of it at most
        // (16 errors, each of them at most half of it), and a kink beside the middle spoils the slope by half of itself
        let [a, b, at, c, d] = [0, 1, 2, 3, 4].map(|j| steps[j][i].1);
        let kink = (a - 2.0 * at + d - 4.0 * (b - 2.0 * at + c)) / small;
        let accepted = |share: f64, errors: f64| share * 1e-6 * size[name] + errors * noise[name];
        (wide - near).abs() <= accepted(1.0, 3.0) && kink.abs() <= accepted(2.0, 8.0)
    };
    if !(0..found.len()).all(is_smooth) {
        return false;
    }
    for (i, found) in found.iter().enumerate() {
        let (name, [wide, near]) = (steps[0][i].0, slopes(i));
        let truth = (4.0 * near - wide) / 3.0;
        let accepted = 1e-6 * size[name] + 6.0 * noise[name];
        assert!(
            (found - truth).abs() <= accepted,
            "{what}, {name}: {found:e} is not {truth:e}, by more than {accepted:e}"
        );
    }
    true
}

/// How many derivatives were compared, and how many there are.
fn check_pose_and_velocity(
    wheels: &PreparedWheels,
    pose: [f64; 6],
    velocity: Velocity,
) -> [usize; 2] {
    let mut counts = [0; 2];
    let step = solved(wheels, pose, velocity);
    let by_pose = step
        .tangent
        .derivatives(WheelInput::Pose, &unmonitored)
        .unwrap();
    for (k, found) in by_pose
        .iter()
        .enumerate()
        .filter(|(k, _)| pose[*k].is_finite())
    {
        let small = [5e-9, 5e-9, 5e-9, 5e-9, 1e-5, 1e-6][k];
        let what = format!("pose {k} at {pose:?}");
        counts[0] += usize::from(check(&what, found, small, EXACT, &|change| {
            let mut moved = pose;
            moved[k] += change;
            self::found(wheels, moved, velocity)
        }));
        counts[1] += 1;
    }
    let by_velocity = step
        .tangent
        .derivatives(WheelInput::Velocity, &unmonitored)
        .unwrap();
    for (k, found) in by_velocity.iter().enumerate() {
        let what = format!("velocity {k} at {pose:?}");
        counts[0] += usize::from(check(&what, found, 1e-5, EXACT, &|change| {
            let moved = match velocity {
                Velocity::Rolling(speed) => Velocity::Rolling(speed + change),
                Velocity::Rigid(mut rigid) => {
                    rigid[k] += change;
                    Velocity::Rigid(rigid)
                }
            };
            self::found(wheels, pose, moved)
        }));
        counts[1] += 1;
    }
    counts
}

/// A number of an alignment, in the order of their derivatives.
fn number(alignment: &mut Alignment, k: usize) -> &mut f64 {
    match k {
        0 => &mut alignment.curvature,
        1..13 => {
            let (rail, k) = (&mut alignment.rails[(k - 1) / 6], (k - 1) % 6);
            if k < 3 {
                &mut rail.place[k]
            } else {
                &mut rail.rate[k - 3]
            }
        }
        _ => {
            let (wheel, k) = (&mut alignment.wheels[(k - 13) / 12], (k - 13) % 12);
            if k < 6 {
                &mut wheel.place[k]
            } else {
                &mut wheel.rate[k - 6]
            }
        }
    }
}

/// How many derivatives of a step under forces, on springs or with an alignment were compared, and how many there are.
fn check_input(
    wheelset: &Wheelset,
    input: &StepInput,
    accuracy: Accuracy,
    of_alignment: &[usize],
    past: Option<&WheelState>,
) -> [usize; 2] {
    let on = |mut wheels: PreparedWheels, state: Option<&WheelState>, input: &StepInput| {
        if let Some(state) = state {
            wheels.resume(state.clone()).unwrap();
        }
        wheels.step_of(input, &unmonitored)
    };
    let at =
        |wheelset: &Wheelset, input: &StepInput| on(settled(wheelset, accuracy), past, input).ok();
    let wheels = settled(wheelset, accuracy);
    let step = on(wheels.without_memory(), past, input).unwrap();
    // from where it was found, so that differences are of the same equilibrium; a transient one from what it rolls on
    let start = if input.duration.is_some() {
        past
    } else {
        Some(&step.state)
    };
    let from = |input: &StepInput| on(wheels.without_memory(), start, input).ok();
    let mut counts = [0; 2];
    let mut compare =
        |what: &str, found: &WheelChange, small: f64, moved: &dyn Fn(f64) -> Option<WheelStep>| {
            counts[0] += usize::from(check(what, found, small, accuracy, moved));
            counts[1] += 1;
        };
    let by = |by| step.tangent.derivatives(by, &unmonitored).unwrap();
    for (k, found) in by(WheelInput::Pose).iter().enumerate() {
        if input.pose[k].is_finite() {
            let small = [2e-8, 2e-8, 2e-8, 2e-8, 1e-5, 1e-6][k];
            compare(&format!("pose {k}"), found, small, &|change| {
                let mut moved = *input;
                moved.pose[k] += change;
                from(&moved)
            });
        }
    }
    for (k, found) in by(WheelInput::Velocity).iter().enumerate() {
        compare(&format!("velocity {k}"), found, 1e-5, &|change| {
            let mut moved = *input;
            moved.velocity = match moved.velocity {
                Velocity::Rolling(speed) => Velocity::Rolling(speed + change),
                Velocity::Rigid(mut rigid) => {
                    rigid[k] += change;
                    Velocity::Rigid(rigid)
                }
            };
            from(&moved)
        });
    }
    for found in by(WheelInput::Duration) {
        compare("duration", &found, 1e-9, &|change| {
            from(&StepInput {
                duration: input.duration.map(|duration| duration + change),
                ..*input
            })
        });
    }
    for found in by(WheelInput::LateralForce) {
        compare("lateral force", &found, 1.0, &|change| {
            from(&StepInput {
                lateral_force: input.lateral_force.map(|force| force + change),
                ..*input
            })
        });
    }
    for found in by(WheelInput::AxleLoad) {
        compare("load of the axle", &found, 1.0, &|change| {
            from(&StepInput {
                axle_load: input.axle_load.map(|load| match load {
                    AxleLoad::Moment(moment) => AxleLoad::Moment(moment + change),
                    AxleLoad::LongitudinalForce(force) => {
                        AxleLoad::LongitudinalForce(force + change)
                    }
                }),
                ..*input
            })
        });
    }
    let by_alignment = by(WheelInput::Alignment);
    for &k in of_alignment {
        let found = &by_alignment[k];
        let small = match k {
            0 => 1e-6,
            1..13 if (k - 1) % 6 < 3 => 2e-8,
            13.. if (k - 13) % 12 < 6 => 2e-8,
            _ => 1e-5,
        };
        compare(&format!("alignment {k}"), found, small, &|change| {
            let mut moved = *input;
            *number(&mut moved.alignment, k) += change;
            from(&moved)
        });
    }
    for (k, found) in by(WheelInput::Springs).iter().enumerate() {
        let springs = wheelset.springs.unwrap();
        let small = if k < 2 {
            1e-6 * springs.stiffness[k]
        } else {
            1.0
        };
        if small.is_finite() {
            compare(&format!("springs {k}"), found, small, &|change| {
                let mut moved = springs;
                let numbers = [&mut moved.stiffness, &mut moved.force];
                numbers[k / 2][k % 2] += change;
                let other = Wheelset {
                    springs: Some(moved),
                    ..wheelset.clone()
                };
                at(&other, input)
            });
        }
    }
    counts
}

#[test]
fn derivatives_on_springs_and_in_curves_are_differences() {
    let free = f64::NAN;
    let both = Wheelset {
        spacing: [2e-3; 2],
        ..wheelset(Sides::Both, Friction::Coulomb(vec![0.3]))
    };
    let sprung = Wheelset {
        springs: Some(RailSprings {
            stiffness: [2e7, 6e7],
            force: [1e3, -2e3],
        }),
        ..both.clone()
    };
    let left = Wheelset {
        sides: Sides::Left,
        springs: Some(RailSprings {
            stiffness: [f64::INFINITY, 6e7],
            force: [0.0; 2],
        }),
        ..both.clone()
    };
    let mut bent = Alignment {
        curvature: 2e-3,
        ..Alignment::default()
    };
    for k in 1..37 {
        *number(&mut bent, k) = 1e-4 * (1.0 + 0.1 * k as f64);
    }
    let rolling = StepInput::new(
        [0.0, 1.1e-3, free, free, 0.0, 2e-3],
        Velocity::Rolling(20.0),
    );
    let slow = 20.0 / 0.46;
    let rigid = Velocity::Rigid([20.0, 0.02, 1e-3, 0.01, 1.001 * slow, 0.03]);
    // each number of a rail, and of a wheel that of one side; fewer where something is found
    let each: Vec<usize> = (0..19).chain(31..37).collect();
    let some = [0, 1, 3, 4, 8, 13, 17, 20, 26, 35];
    let cases = [
        (
            &both,
            EXACT,
            &each[..],
            StepInput {
                alignment: bent,
                velocity: rigid,
                ..rolling
            },
        ),
        (&sprung, SETTLED, &some, rolling),
        (
            &left,
            SETTLED,
            &some,
            StepInput {
                pose: [0.0, 1.1e-3, free, 1e-4, 0.01, 2e-3],
                axle_load: Some(AxleLoad::Moment(500.0)),
                ..rolling
            },
        ),
    ];
    let mut share = [0; 2];
    for (wheelset, accuracy, of_alignment, input) in cases {
        let [compared, all] = check_input(wheelset, &input, accuracy, of_alignment, None);
        assert!(2 * compared > all, "{input:?}: {compared} of {all}");
        share[0] += compared;
        share[1] += all;
    }
    assert!(10 * share[0] > 9 * share[1], "{share:?}");
}

#[test]
fn derivatives_on_rollers_are_differences() {
    let free = f64::NAN;
    let mut both = Wheelset {
        spacing: [2e-3; 2],
        ..wheelset(Sides::Both, Friction::Coulomb(vec![0.3]))
    };
    both.pair.roller_radius = Some(0.35);
    let sprung = Wheelset {
        springs: Some(RailSprings {
            stiffness: [2e7, 6e7],
            force: [1e3, -2e3],
        }),
        ..both.clone()
    };
    let mut bent = Alignment::default();
    for k in 1..37 {
        *number(&mut bent, k) = 1e-4 * (1.0 + 0.1 * k as f64);
    }
    let rolling = StepInput::new(
        [3e-3, 1.1e-3, free, free, 0.0, 4e-3],
        Velocity::Rolling(20.0),
    );
    let rigid = Velocity::Rigid([20.0, 0.02, 1e-3, 0.01, 1.001 * 20.0 / 0.46, 0.03]);
    let left = Wheelset {
        sides: Sides::Left,
        ..both.clone()
    };
    let of_left: Vec<usize> = (1..7).chain(13..19).collect();
    let mut share = [0; 2];
    for (wheelset, accuracy, of_alignment, input) in [
        (
            &left,
            EXACT,
            &of_left[..],
            StepInput {
                pose: [3e-3, 1.1e-3, free, 1e-4, 0.0, 4e-3],
                alignment: bent,
                velocity: rigid,
                ..rolling
            },
        ),
        (
            &both,
            EXACT,
            &[],
            StepInput {
                pose: [-2e-3, -6.43e-3, free, free, 0.0, -9e-3],
                ..rolling
            },
        ),
        (
            &sprung,
            SETTLED,
            &[1, 20],
            StepInput {
                axle_load: Some(AxleLoad::Moment(500.0)),
                ..rolling
            },
        ),
    ] {
        let [compared, all] = check_input(wheelset, &input, accuracy, of_alignment, None);
        assert!(2 * compared > all, "{input:?}: {compared} of {all}");
        share[0] += compared;
        share[1] += all;
    }
    assert!(10 * share[0] > 8 * share[1], "{share:?}");
    // a curve is refused there
    let mut curved = rolling;
    curved.alignment.curvature = 1e-3;
    let refused = settled(&both, EXACT).step_of(&curved, &unmonitored);
    assert!(matches!(refused, Err(Error::CurvedRoller { .. })));
}

fn settled(wheelset: &Wheelset, accuracy: Accuracy) -> PreparedWheels {
    let wheels = PreparedWheels::new(wheelset.clone()).unwrap();
    wheels.to_accuracy(accuracy).unwrap()
}

fn prepared(wheelset: Wheelset) -> PreparedWheels {
    PreparedWheels::new(wheelset)
        .unwrap()
        .to_accuracy(EXACT)
        .unwrap()
}

#[test]
fn derivatives_by_pose_and_velocity_are_differences() {
    let wheels = prepared(wheelset(Sides::Both, Friction::Coulomb(vec![0.3])));
    let free = f64::NAN;
    let level = |pose: [f64; 6]| solved(&wheels, pose, Velocity::Rolling(20.0)).pose;
    // tread, flange, backwards, one wheel lifted; the last two with the height and roll that are found
    let tread = level([0.0, 2.3e-3, free, free, 0.001, 3e-3]);
    let flange = level([0.1, -6.43e-3, free, free, 0.0, -4e-3]);
    let mut lifted = tread;
    lifted[3] += 2e-3;
    let slow = 17.0 / 0.46;
    for (pose, velocity) in [
        (tread, Velocity::Rolling(20.0)),
        (
            tread,
            Velocity::Rigid([17.0, 0.02, 1e-3, 0.01, 1.002 * slow, 0.03]),
        ),
        (flange, Velocity::Rolling(-20.0)),
        (lifted, Velocity::Rolling(20.0)),
        (
            [0.0, 1.7e-3, free, free, 0.0, 3e-3],
            Velocity::Rolling(20.0),
        ),
        (
            [0.0, 1.7e-3, free, 1e-4, 0.0, 3e-3],
            Velocity::Rolling(20.0),
        ),
    ] {
        let [compared, all] = check_pose_and_velocity(&wheels, pose, velocity);
        assert!(2 * compared > all, "{pose:?}: {compared} of {all}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases / 32))]

    #[test]
    fn derivatives_of_any_steps_are_differences(
        y in -7e-3..7e-3_f64,
        turned in prop::array::uniform3(-1.0..1.0_f64),
        sides in prop::sample::select(vec![Sides::Left, Sides::Right, Sides::Both]),
        found in 0..3_usize,
        law in prop::sample::select(vec![
            Friction::Coulomb(vec![0.3]),
            Friction::SpeedDependent {
                law: SlipLaw::Exponential { at_rest: 0.35, kinetic: 0.2, half_slip: 0.3 },
                memory: None,
            },
        ]),
        slips in prop::array::uniform3(-1.0..1.0_f64),
        speed in prop::sample::select(vec![-30.0, 2.0, 20.0]),
        is_rigid in any::<bool>(),
        follows in any::<bool>(),
    ) {
        let wheels = prepared(if follows { conformal(sides, law) } else { wheelset(sides, law) });
        let is_each = sides == Sides::Both && found == 2;
        let roll = if is_each { f64::NAN } else { 1e-4 * turned[0] };
        let mut pose = [0.0, y, f64::NAN, roll, 1e-3 * turned[1], 5e-3 * turned[2]];
        let spin = speed / 0.46;
        let velocity = if is_rigid {
            let [a, b, c] = slips;
            Velocity::Rigid([speed, 0.03 * a, 0.0, 0.01 * b, spin * (1.0 + 2e-3 * c), 0.05 * a])
        } else {
            Velocity::Rolling(speed)
        };
        // a force that no height carries has no step
        let Ok(step) = wheels.without_memory().step(pose, velocity, &unmonitored) else {
            return Err(TestCaseError::reject("not solved"));
        };
        if found == 0 {
            pose = step.pose;
        }
        check_pose_and_velocity(&wheels, pose, velocity);
    }
}

#[test]
fn derivatives_by_friction_force_and_layer_are_differences() {
    let pose = [0.05, -2.3e-3, f64::NAN, 0.0, 0.0, 2e-3];
    let velocity = Velocity::Rolling(20.0);
    let table = |k: usize, by: f64| {
        let (mut coefficient, mut slip_speed) = (vec![0.3, 0.25, 0.2], vec![0.0, 0.033, 0.3]);
        match k {
            0..3 => coefficient[k] += by,
            _ => slip_speed[k - 3] += by,
        }
        Friction::SpeedDependent {
            law: SlipLaw::Table {
                slip_speed,
                coefficient,
            },
            memory: None,
        }
    };
    let map = |k: usize, by: f64| {
        let mut coefficient = vec![0.3, 0.25, 0.2, 0.28];
        coefficient[k] += by;
        RailFriction::new(vec![-1.03e-2, 0.4], vec![-5.1e-2, 1.7e-2], coefficient).unwrap()
    };
    let laws: [Law<'_>; 5] = [
        (1, &|_, by| Friction::Coulomb(vec![0.3 + by]).into()),
        (2, &|k, by| {
            let values = [0.3, 0.25].map(|mu| mu + if k == 1 { by } else { 0.0 });
            let [at_rest, kinetic] = [0.3, values[1]];
            Friction::StaticKinetic { at_rest, kinetic }.into()
        }),
        (5, &|k, by| exponential(k, by).into()),
        (6, &|k, by| table(k, by).into()),
        (4, &|k, by| WheelFriction::OnRail(map(k, by))),
    ];
    for (count, law) in laws {
        let made = |k, by| prepared(wheelset(Sides::Right, law(k, by)));
        let wheels = made(0, 0.0);
        let step = solved(&wheels, pose, velocity);
        check_pose_and_velocity(&wheels, pose, velocity);
        let by_friction = step
            .tangent
            .derivatives(WheelInput::Friction, &unmonitored)
            .unwrap();
        assert_eq!(by_friction.len(), count);
        for (k, found) in by_friction.iter().enumerate() {
            // a table that begins later is constant before: a kink for all that sticks
            if (count, k) == (6, 3) {
                continue;
            }
            let at = |by: f64| self::found(&made(k, by), pose, velocity);
            assert!(
                check(&format!("friction {k} of {count}"), found, 1e-7, EXACT, &at),
                "{k} of {count}"
            );
        }
        let [by_force] = &step
            .tangent
            .derivatives(WheelInput::Force, &unmonitored)
            .unwrap()[..]
        else {
            panic!("one force");
        };
        assert!(check("force", by_force, 0.3, EXACT, &|by| {
            let mut wheelset = wheelset(Sides::Right, law(0, 0.0));
            wheelset.force += by;
            found(&prepared(wheelset), pose, velocity)
        }));
        let [by_layer] = &step
            .tangent
            .derivatives(WheelInput::Layer, &unmonitored)
            .unwrap()[..]
        else {
            panic!("one layer");
        };
        assert!(check("layer", by_layer, 1e-20, EXACT, &|by| {
            let mut wheelset = wheelset(Sides::Right, law(0, 0.0));
            wheelset.layer += by;
            found(&prepared(wheelset), pose, velocity)
        }));
    }
}

#[test]
fn derivatives_by_moduli_are_differences() {
    let free = f64::NAN;
    let slow = 17.0 / 0.46;
    let steel = |shear_modulus, nu| Some(Material::new(shear_modulus, nu).unwrap());
    // unlike and like bodies, a rigid wheel and a rigid rail; given and found heights, two wheels, backwards
    let unlike = [steel(80e9, 0.3), steel(60e9, 0.1)];
    let like = [steel(80e9, 0.3); 2];
    let law = Friction::SpeedDependent {
        law: SlipLaw::Exponential {
            at_rest: 0.35,
            kinetic: 0.2,
            half_slip: 0.3,
        },
        memory: None,
    };
    let coulomb = Friction::Coulomb(vec![0.3]);
    let rolling = Velocity::Rolling(20.0);
    let six = Velocity::Rigid([17.0, 0.02, 1e-3, 0.01, 1.002 * slow, 0.03]);
    for (bodies, law, pose, velocity) in [
        (
            unlike,
            &coulomb,
            [0.0, 2.3e-3, free, free, 0.0, 3e-3],
            rolling,
        ),
        (unlike, &law, [0.0, 1.15e-3, free, 1e-4, 0.0, 2e-3], six),
        (
            unlike,
            &coulomb,
            [0.0, 1.1e-3, -6e-5, 1e-4, 0.0, 1e-3],
            Velocity::Rolling(-20.0),
        ),
        (like, &coulomb, [0.0, 1.7e-3, free, 0.0, 0.0, 3e-3], six),
        (
            [None, unlike[1]],
            &coulomb,
            [0.0, 1.1e-3, free, 0.0, 0.0, 2e-3],
            rolling,
        ),
        (
            [unlike[0], None],
            &law,
            [0.0, -6.43e-3, free, free, 0.0, -4e-3],
            Velocity::Rolling(-20.0),
        ),
    ] {
        let made = |k: usize, by: f64| {
            let mut own = wheelset(Sides::Both, law.clone());
            own.second_order = pose[3].is_nan() || pose[3] == 0.0;
            let mut count = 0;
            let [lower, upper] = bodies.map(|body| {
                body.map(|mut body| {
                    if count == k / 2 && k.is_multiple_of(2) {
                        body.shear_modulus += by;
                    } else if count == k / 2 {
                        body.poisson_ratio += by;
                    }
                    count += 1;
                    body
                })
            });
            own.bodies = Pair { lower, upper };
            prepared(own)
        };
        let wheels = made(0, 0.0);
        let step = solved(&wheels, pose, velocity);
        let derived = |by| step.tangent.derivatives(by, &unmonitored).unwrap();
        let by_moduli = derived(WheelInput::Moduli);
        let elastic: Vec<Material> = bodies.into_iter().flatten().collect();
        assert_eq!(by_moduli.len(), 2 * elastic.len());
        for (k, found) in by_moduli.iter().enumerate() {
            let small = if k.is_multiple_of(2) { 1e5 } else { 1e-6 };
            let what = format!("modulus {k} of {bodies:?} at {pose:?}");
            let at = |by: f64| self::found(&made(k, by), pose, velocity);
            assert!(check(&what, found, small, EXACT, &at), "{what}");
        }
        if pose[2].is_nan() {
            continue;
        }
        // at a given height all forces go with the moduli, and with the inverse of the layer
        let [by_layer] = &derived(WheelInput::Layer)[..] else {
            panic!("one layer");
        };
        for c in 0..3 {
            let by_all = (elastic.iter().zip(by_moduli.chunks_exact(2)))
                .map(|(body, by)| body.shear_modulus * by[0].force[c])
                .sum::<f64>()
                - wheels.wheelset().layer * by_layer.force[c];
            assert!((by_all / step.force[c] - 1.0).abs() < 1e-8, "{c}: {by_all}");
        }
    }
}

/// Friction with a memory, one of whose parameters is changed.
fn exponential(k: usize, by: f64) -> Friction {
    let mut values = [0.35, 0.2, 0.3, 1e-4, 1e-3];
    values[k] += by;
    let [at_rest, kinetic, half_slip, distance, min_slip] = values;
    Friction::SpeedDependent {
        law: SlipLaw::Exponential {
            at_rest,
            kinetic,
            half_slip,
        },
        memory: Some(Memory { distance, min_slip }),
    }
}

/// How many derivatives by what wheels are prepared with were compared, and how many there are.
fn check_prepared(
    wheelset: &Wheelset,
    (input, accuracy): (&StepInput, Accuracy),
    past: Option<&WheelState>,
    (count, law): Law<'_>,
) -> [usize; 2] {
    let at = |wheelset: &Wheelset| {
        let mut wheels = settled(wheelset, accuracy);
        if let Some(state) = past {
            wheels.resume(state.clone()).unwrap();
        }
        wheels.step_of(input, &unmonitored).ok()
    };
    let step = at(wheelset).unwrap();
    let by = |by| step.tangent.derivatives(by, &unmonitored).unwrap();
    let mut counts = [0; 2];
    let mut compare =
        |what: &str, found: &WheelChange, small: f64, moved: &dyn Fn(f64) -> Option<WheelStep>| {
            counts[0] += usize::from(check(what, found, small, accuracy, moved));
            counts[1] += 1;
        };
    let by_friction = by(WheelInput::Friction);
    assert_eq!(by_friction.len(), count);
    for (k, found) in by_friction.iter().enumerate() {
        compare(
            &format!("friction {k} of {count}"),
            found,
            1e-7,
            &|change| {
                at(&Wheelset {
                    friction: law(k, change),
                    ..wheelset.clone()
                })
            },
        );
    }
    compare("layer", &by(WheelInput::Layer)[0], 1e-20, &|change| {
        at(&Wheelset {
            layer: wheelset.layer + change,
            ..wheelset.clone()
        })
    });
    for found in by(WheelInput::Force) {
        compare("force", &found, 0.3, &|change| {
            at(&Wheelset {
                force: wheelset.force + change,
                ..wheelset.clone()
            })
        });
    }
    let by_moduli = step.tangent.derivatives(WheelInput::Moduli, &unmonitored);
    if wheelset.conformal {
        assert_eq!(by_moduli, Err(Error::ConformalModuli));
        return counts;
    }
    for (k, found) in by_moduli.unwrap().iter().enumerate() {
        let small = if k % 2 == 0 { 1e5 } else { 1e-6 };
        compare(&format!("modulus {k}"), found, small, &|change| {
            let mut bodies = wheelset.bodies;
            let body = if k < 2 {
                &mut bodies.lower
            } else {
                &mut bodies.upper
            };
            let Material {
                shear_modulus,
                poisson_ratio,
            } = body.unwrap();
            let [more, ratio] = if k % 2 == 0 {
                [change, 0.0]
            } else {
                [0.0, change]
            };
            *body = Some(Material::new(shear_modulus + more, poisson_ratio + ratio).unwrap());
            at(&Wheelset {
                bodies,
                ..wheelset.clone()
            })
        });
    }
    counts
}

#[test]
fn derivatives_of_transient_steps_are_differences() {
    let free = f64::NAN;
    let coulomb = |_: usize, by: f64| -> WheelFriction { Friction::Coulomb(vec![0.3 + by]).into() };
    let remembering = |k: usize, by: f64| -> WheelFriction { exponential(k, by).into() };
    let on_rail = |k: usize, by: f64| -> WheelFriction {
        let mut coefficient = vec![0.3, 0.25, 0.2, 0.28];
        coefficient[k] += by;
        let x = vec![-1.03e-2, 0.4];
        WheelFriction::OnRail(RailFriction::new(x, vec![-5.1e-2, 1.7e-2], coefficient).unwrap())
    };
    let of = |sides, law: &dyn Fn(usize, f64) -> WheelFriction| Wheelset {
        spacing: [2e-3; 2],
        ..wheelset(sides, law(0, 0.0))
    };
    let pose = [0.0, 1.1e-3, free, 1e-4, 0.0, 2e-3];
    let spin = 20.0 / 0.46;
    let rigid = Velocity::Rigid([20.0, 0.02, 1e-3, 0.01, 1.001 * spin, 0.03]);
    let rolling = Velocity::Rolling(20.0);
    let beside = [0, 1, 3, 4, 13, 17, 20];
    let laws: [Law<'_>; 3] = [(1, &coulomb), (5, &remembering), (4, &on_rail)];
    let [plain, memory, map] = laws;
    // wheels, where they were, how they move on, the time in cells of 2 mm, and whether there was a step before
    let cases = [
        (Sides::Left, plain, pose, rigid, 0.83, true),
        (
            Sides::Both,
            plain,
            [0.0, 1.1e-3, free, free, 0.0, 2e-3],
            rolling,
            0.37,
            true,
        ),
        (
            Sides::Right,
            memory,
            [0.0, -2.3e-3, free, 0.0, 0.0, 2e-3],
            rigid,
            1.31,
            true,
        ),
        (Sides::Left, map, pose, Velocity::Rolling(-20.0), 1.31, true),
        (
            Sides::Right,
            plain,
            [0.0, 6.3e-3, free, 0.0, 0.0, 2e-3],
            rolling,
            0.83,
            true,
        ),
        (Sides::Left, memory, pose, rigid, 0.83, false),
    ];
    let mut share = [0; 2];
    for (sides, law, pose, velocity, cells, has_past) in cases {
        let wheelset = of(sides, law.1);
        let duration = cells * 2e-3 / 20.0;
        let mut wheels = prepared(wheelset.clone());
        let steady = wheels.step(pose, velocity, &unmonitored).unwrap();
        let mut on = pose;
        for (k, by) in [-20.0 * duration, 2.3e-4, 0.0, 1e-5, 0.0, 1e-4]
            .into_iter()
            .enumerate()
        {
            on[k] += by;
        }
        let input = StepInput {
            duration: Some(duration),
            ..StepInput::new(on, velocity)
        };
        let past = has_past.then_some(&steady.state);
        for [compared, all] in [
            check_input(&wheelset, &input, EXACT, &beside, past),
            check_prepared(&wheelset, (&input, EXACT), past, law),
        ] {
            share[0] += compared;
            share[1] += all;
        }
    }
    assert!(10 * share[0] > 9 * share[1], "{share:?}");
}

/// The steps of a chain, where each of them has patches with the same points in contact, stick and slip as `like`.
fn chained(
    wheels: &PreparedWheels,
    inputs: &[StepInput],
    like: Option<&[WheelStep]>,
) -> Option<Vec<WheelStep>> {
    let mut wheels = wheels.without_memory();
    let steps: Result<Vec<WheelStep>, Error> = (inputs.iter())
        .map(|input| wheels.step_of(input, &unmonitored))
        .collect();
    let steps = steps.ok()?;
    let is_same = |like: &[WheelStep]| {
        let mut pairs = steps.iter().zip(like);
        pairs.all(|(step, like)| states(step) == states(like))
    };
    like.is_none_or(is_same).then_some(steps)
}

/// Changes of the last step by `changes` of one of a chain.
fn handed_on(steps: &[WheelStep], at: usize, mut changes: Vec<WheelChange>) -> Vec<WheelChange> {
    for pair in steps[at..].windows(2) {
        let [before, after] = pair else { continue };
        changes = (after.tangent)
            .after(&before.tangent, &changes, &unmonitored)
            .unwrap();
    }
    changes
}

/// How many derivatives of the last step of a chain by what was given in each step, and in all of them, were compared,
/// and how many there are.
fn check_chain(
    wheelset: &Wheelset,
    inputs: &[StepInput],
    accuracy: Accuracy,
    (count, law): Law<'_>,
) -> [usize; 2] {
    let wheels = settled(wheelset, accuracy);
    let steps = chained(&wheels, inputs, None).unwrap();
    let mut counts = [0; 2];
    let mut compare =
        |what: &str,
         found: &WheelChange,
         small: f64,
         moved: &dyn Fn(f64) -> (Option<Wheelset>, Vec<StepInput>)| {
            let at = |change: f64| {
                let (other, inputs) = moved(change);
                let other = other.map(|other| settled(&other, accuracy));
                chained(other.as_ref().unwrap_or(&wheels), &inputs, Some(&steps))?.pop()
            };
            counts[0] += usize::from(check(what, found, small, accuracy, &at));
            counts[1] += 1;
        };
    for k in 0..inputs.len() - 1 {
        let by = |by| {
            handed_on(
                &steps,
                k,
                steps[k].tangent.derivatives(by, &unmonitored).unwrap(),
            )
        };
        let with = |change: &dyn Fn(&mut StepInput)| {
            let mut moved = inputs.to_vec();
            change(&mut moved[k]);
            (None, moved)
        };
        for (c, found) in by(WheelInput::Pose).iter().enumerate() {
            if inputs[k].pose[c].is_finite() {
                let small = [2e-8, 2e-8, 2e-8, 2e-8, 1e-5, 1e-6][c];
                compare(&format!("pose {c} of {k}"), found, small, &|change| {
                    with(&|input| input.pose[c] += change)
                });
            }
        }
        for (c, found) in by(WheelInput::Velocity).iter().enumerate() {
            compare(&format!("velocity {c} of {k}"), found, 1e-5, &|change| {
                with(&|input| match &mut input.velocity {
                    Velocity::Rolling(speed) => *speed += change,
                    Velocity::Rigid(rigid) => rigid[c] += change,
                })
            });
        }
        for found in by(WheelInput::Duration) {
            compare(&format!("duration of {k}"), &found, 1e-9, &|change| {
                with(&|input| input.duration = input.duration.map(|duration| duration + change))
            });
        }
    }
    // what all steps have alike
    let of_all = |by| -> Vec<Vec<WheelChange>> {
        (0..steps.len())
            .map(|k| {
                handed_on(
                    &steps,
                    k,
                    steps[k].tangent.derivatives(by, &unmonitored).unwrap(),
                )
            })
            .collect()
    };
    let sum = |of_all: &[Vec<WheelChange>], k: usize| {
        let mut sum = of_all[0][k].clone();
        for other in &of_all[1..] {
            sum.add(1.0, &other[k]);
        }
        sum
    };
    let with = |other: Wheelset| (Some(other), inputs.to_vec());
    let by_friction = of_all(WheelInput::Friction);
    for k in 0..count {
        let found = sum(&by_friction, k);
        compare(&format!("friction {k}"), &found, 1e-7, &|change| {
            with(Wheelset {
                friction: law(k, change),
                ..wheelset.clone()
            })
        });
    }
    let found = sum(&of_all(WheelInput::Layer), 0);
    compare("layer", &found, 1e-20, &|change| {
        with(Wheelset {
            layer: wheelset.layer + change,
            ..wheelset.clone()
        })
    });
    let found = sum(&of_all(WheelInput::Force), 0);
    compare("force", &found, 0.3, &|change| {
        with(Wheelset {
            force: wheelset.force + change,
            ..wheelset.clone()
        })
    });
    let found = sum(&of_all(WheelInput::Moduli), 2);
    compare("modulus of the wheel", &found, 1e5, &|change| {
        let mut bodies = wheelset.bodies;
        let Material {
            shear_modulus,
            poisson_ratio,
        } = bodies.upper.unwrap();
        bodies.upper = Some(Material::new(shear_modulus + change, poisson_ratio).unwrap());
        with(Wheelset {
            bodies,
            ..wheelset.clone()
        })
    });
    counts
}

#[test]
fn derivatives_through_chains_of_steps_are_differences() {
    let free = f64::NAN;
    let coulomb = |_: usize, by: f64| -> WheelFriction { Friction::Coulomb(vec![0.3 + by]).into() };
    let remembering = |k: usize, by: f64| -> WheelFriction { exponential(k, by).into() };
    let (plain, memory): (Law<'_>, Law<'_>) = ((1, &coulomb), (5, &remembering));
    let spin = 20.0 / 0.46;
    let rigid = Velocity::Rigid([20.0, 0.02, 1e-3, 0.01, 1.001 * spin, 0.03]);
    let rolling = Velocity::Rolling(20.0);
    let springs = RailSprings {
        stiffness: [2e7, 6e7],
        force: [1e3, -2e3],
    };
    let rails =
        |springs: Option<RailSprings>| (springs, if springs.is_some() { SETTLED } else { EXACT });
    // wheels, law, springs, the first pose and motion, cells of 2 mm rolled in each later step, from a steady one or rest
    let cases = [
        (
            Sides::Left,
            plain,
            None,
            [0.0, 1.1e-3, free, 1e-4, 0.0, 2e-3],
            rigid,
            &[0.83, 0.37][..],
            true,
        ),
        (
            Sides::Right,
            memory,
            None,
            [0.0, -2.3e-3, free, 0.0, 0.0, 2e-3],
            rigid,
            &[1.31, 2.6],
            true,
        ),
        (
            Sides::Both,
            plain,
            Some(springs),
            [0.0, 1.1e-3, free, free, 0.0, 2e-3],
            rolling,
            &[0.37],
            true,
        ),
        (
            Sides::Left,
            memory,
            None,
            [0.0, 1.1e-3, -6e-5, 1e-4, 0.0, 2e-3],
            rigid,
            &[0.83, 0.6, 0.83],
            false,
        ),
    ];
    let mut share = [0; 2];
    for (sides, law, springs, mut pose, velocity, cells, is_steady) in cases {
        let (springs, accuracy) = rails(springs);
        let wheelset = Wheelset {
            spacing: [2e-3; 2],
            springs,
            ..wheelset(sides, law.1(0, 0.0))
        };
        let mut inputs = Vec::new();
        if is_steady {
            inputs.push(StepInput::new(pose, velocity));
        }
        for cells in cells {
            let duration = cells * 2e-3 / 20.0;
            for (k, by) in [20.0 * duration, 2.3e-4, 0.0, 1e-5, 0.0, 1e-4]
                .into_iter()
                .enumerate()
            {
                pose[k] += by;
            }
            inputs.push(StepInput {
                duration: Some(duration),
                ..StepInput::new(pose, velocity)
            });
        }
        let [compared, all] = check_chain(&wheelset, &inputs, accuracy, law);
        assert!(2 * compared > all, "{sides:?}: {compared} of {all}");
        share[0] += compared;
        share[1] += all;
    }
    assert!(5 * share[0] > 4 * share[1], "{share:?}");
}

#[test]
fn derivatives_of_patches_that_follow_the_rail_are_differences() {
    let free = f64::NAN;
    let coulomb = |_: usize, by: f64| -> WheelFriction { Friction::Coulomb(vec![0.3 + by]).into() };
    let remembering = |k: usize, by: f64| -> WheelFriction { exponential(k, by).into() };
    let (plain, memory): (Law<'_>, Law<'_>) = ((1, &coulomb), (5, &remembering));
    let springs = Some(RailSprings {
        stiffness: [2e7, 6e7],
        force: [1e3, -2e3],
    });
    let slow = 20.0 / 0.46;
    let rigid = Velocity::Rigid([20.0, 0.02, 1e-3, 0.01, 1.001 * slow, 0.03]);
    let rolling = Velocity::Rolling(20.0);
    let flange = [0.0, -6.43e-3, free, 0.0, 0.0, -4e-3];
    let tread = [0.0, 1.1e-3, free, 1e-4, 0.0, 2e-3];
    let each = [0.0, 1.1e-3, free, free, 0.0, 2e-3];
    // wheels, law, springs, pose and motion, and the cells of 1 mm rolled after a step before
    let cases = [
        (Sides::Right, plain, None, flange, rolling, None),
        (
            Sides::Right,
            memory,
            None,
            flange,
            Velocity::Rolling(-20.0),
            None,
        ),
        (Sides::Left, plain, None, tread, rigid, None),
        (Sides::Both, plain, springs, each, rolling, None),
        (Sides::Right, plain, None, flange, rigid, Some(0.83)),
        (Sides::Left, memory, None, tread, rigid, Some(1.31)),
        (Sides::Both, plain, springs, each, rolling, Some(0.37)),
    ];
    let mut bent = Alignment {
        curvature: 2e-3,
        ..Alignment::default()
    };
    for k in 1..37 {
        *number(&mut bent, k) = 1e-5 * (1.0 + 0.1 * k as f64);
    }
    let mut share = [0; 2];
    for (sides, law, springs, pose, velocity, cells) in cases {
        let wheelset = Wheelset {
            springs,
            spacing: [if springs.is_some() { 2e-3 } else { 1e-3 }; 2],
            ..conformal(sides, law.1(0, 0.0))
        };
        // on the flange rounding is more of the force than elsewhere
        let accuracy = SETTLED;
        let mut input = StepInput {
            alignment: bent,
            ..StepInput::new(pose, velocity)
        };
        let mut past = None;
        if let Some(cells) = cells {
            let steady = settled(&wheelset, accuracy).step_of(&input, &unmonitored);
            past = Some(steady.unwrap().state);
            let duration = cells * 1e-3 / 20.0;
            input.duration = Some(duration);
            for (k, by) in [20.0 * duration, 1.3e-4, 0.0, 1e-5, 0.0, 1e-4]
                .into_iter()
                .enumerate()
            {
                input.pose[k] += by;
            }
        }
        let mut counts = check_input(
            &wheelset,
            &input,
            accuracy,
            &[0, 1, 3, 4, 13, 17, 20],
            past.as_ref(),
        );
        if springs.is_none() {
            let others = check_prepared(&wheelset, (&input, accuracy), past.as_ref(), law);
            counts = [0, 1].map(|c| counts[c] + others[c]);
        }
        let [compared, all] = counts;
        assert!(2 * compared > all, "{input:?}: {compared} of {all}");
        share = [0, 1].map(|c| share[c] + counts[c]);
    }
    assert!(10 * share[0] > 9 * share[1], "{share:?}");
}

#[test]
fn a_change_of_another_step_is_refused() {
    let mut wheels = settled(&wheelset(Sides::Left, Friction::Coulomb(vec![0.3])), EXACT);
    let mut pose = [0.0, 1.1e-3, f64::NAN, 0.0, 0.0, 2e-3];
    let rolling = Velocity::Rolling(20.0);
    let first = wheels.step(pose, rolling, &unmonitored).unwrap();
    let mut on = |wheels: &mut PreparedWheels| {
        pose[0] += 1e-3;
        wheels
            .step_transient(pose, rolling, 5e-5, &unmonitored)
            .unwrap()
    };
    let [second, third] = [0, 1].map(|_| on(&mut wheels));
    let by = |step: &WheelStep| {
        step.tangent
            .derivatives(WheelInput::Velocity, &unmonitored)
            .unwrap()
    };
    let after = |step: &WheelStep, before: &WheelStep, changes: &[WheelChange]| {
        step.tangent.after(&before.tangent, changes, &unmonitored)
    };
    assert!(matches!(
        after(&third, &first, &by(&first)),
        Err(Error::OtherState)
    ));
    let foreign = [WheelChange::default()];
    let refused = after(&third, &second, &foreign).unwrap_err().to_string();
    assert!(
        refused.starts_with("changes[0] has patches of [] points: ["),
        "{refused}"
    );
    // a steady step follows from nothing
    let steady = wheels.step(pose, rolling, &unmonitored).unwrap();
    let changed = after(&steady, &third, &by(&third)).unwrap();
    assert!(changes(&changed[0]).iter().all(|v| *v == 0.0));
}

#[test]
fn the_margin_says_how_near_a_point_is_to_another_state() {
    let wheels = prepared(wheelset(Sides::Left, Friction::Coulomb(vec![0.3])));
    let pose = [0.0, 1e-3, f64::NAN, 0.0, 0.0, 2e-3];
    let margin = solved(&wheels, pose, Velocity::Rolling(20.0))
        .tangent
        .margin();
    for share in [
        margin.parting,
        margin.touching,
        margin.slipping,
        margin.sticking,
    ] {
        assert!(share > 0.0 && share < 1.0, "{margin:?}");
    }
    // a lifted wheel has that to the rail
    let lifted = solved(
        &wheels,
        [0.0, 0.0, 2e-5, 0.0, 0.0, 0.0],
        Velocity::Rolling(20.0),
    );
    assert!(lifted.patches.is_empty());
    let wanted = 2e-5 / wheels.wheelset().approach;
    assert!((lifted.tangent.margin().touching / wanted - 1.0).abs() < 1e-3);
}

#[test]
fn a_height_that_follows_a_jump_has_no_derivatives() {
    let at = |force: f64| {
        let mut own = wheelset(Sides::Left, Friction::Coulomb(vec![0.3]));
        own.pair.rail_inclination = 0.05;
        own.pair.wheel_radius = 0.541_540_999_053_307_3;
        own.spacing = [8.924_038_515_783_139e-4; 2];
        own.force = force;
        let pose = [0.0, 6.155_456_496_316_805e-3, f64::NAN, 0.0, 0.0, 0.0];
        let mut wheels = PreparedWheels::new(own).unwrap();
        wheels.step(pose, Velocity::Rolling(20.0), &unmonitored)
    };
    let mut jumps = (0..80).filter_map(|k| match at(4e3 + 10.0 * f64::from(k)) {
        Err(Error::Balance {
            jump: Some(ends), ..
        }) => Some(ends),
        _ => None,
    });
    let [low, _] = jumps.next().unwrap();
    let step = at(low * (1.0 + 5e-4)).unwrap();
    let refused = step
        .tangent
        .derivatives(WheelInput::Pose, &unmonitored)
        .unwrap_err();
    assert!(refused.to_string().contains("give z"), "{refused}");
    // friction is in the balance, so that the velocity would move it as well
    let refused = step.tangent.derivatives(WheelInput::Velocity, &unmonitored);
    assert!(refused.is_err());
}

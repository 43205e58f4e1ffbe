// SPDX-License-Identifier: MIT OR Apache-2.0
//! All derivatives of steps of wheels against central differences of the very same steps.

use std::collections::BTreeMap;

use mtb_contact::friction::{Friction, Memory, SlipLaw};
use mtb_elasticity::Material;
use mtb_elasticity::half_space::Pair;
use mtb_geometry::{Profile, WheelOnRail};
use mtb_operator::unmonitored;

use crate::prepared::Accuracy;
use crate::{
    PreparedWheels, RailFriction, Sides, Velocity, WheelChange, WheelFriction, WheelInput,
    WheelStep, Wheelset,
};

/// Differences need solutions far better than their own errors.
const EXACT: Accuracy = Accuracy {
    normal: 1e-14,
    tangential: 1e-12,
    force: 1e-12,
};

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
        ..Wheelset::new(pair, bodies, 60e3).unwrap()
    }
}

/// What is left in differences of solutions, over their size.
const NOISE: f64 = 5e-11;

/// All numbers of a step, or of its change, with the size of their kind.
fn numbers(step: &WheelStep) -> Vec<(&'static str, f64)> {
    let mut all = Vec::new();
    let mut put = |name, values: &[f64]| all.extend(values.iter().map(|v| (name, *v)));
    put("force", &step.force);
    put("moment", &step.moment);
    put("vertical force", &step.vertical_force);
    put("pose", &step.pose);
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

/// A step without memory, so that differences have no memory.
fn solved(wheels: &PreparedWheels, pose: [f64; 6], velocity: Velocity) -> WheelStep {
    let mut wheels = wheels.without_memory();
    wheels.step(pose, velocity, &unmonitored).unwrap()
}

/// Checks a derivative against central differences of steps whose number is `share` times `small` further.
fn check(what: &str, found: &WheelChange, small: f64, at: &dyn Fn(f64) -> WheelStep) {
    let steps = [-1.0, -0.5, 0.5, 1.0].map(|share: f64| numbers(&at(share * small)));
    let found = changes(found);
    assert!(
        steps.iter().all(|step| step.len() == found.len()),
        "{what}: another grid"
    );
    let truth: Vec<f64> = (0..found.len())
        .map(|i| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|j| steps[j][i].1);
            (8.0 * (c - b) - (d - a)) / (6.0 * small)
        })
        .collect();
    // the largest of a kind, and what is left of it in differences
    let (mut size, mut noise) = (BTreeMap::new(), BTreeMap::new());
    for ((name, value), truth) in steps[0].iter().zip(&truth) {
        let size: &mut f64 = size.entry(*name).or_default();
        *size = size.max(truth.abs());
        let noise: &mut f64 = noise.entry(*name).or_default();
        *noise = noise.max(NOISE * value.abs() / small);
    }
    for (((name, _), truth), found) in steps[0].iter().zip(&truth).zip(&found) {
        let accepted = 1e-6 * size[name] + noise[name];
        assert!(
            (found - truth).abs() <= accepted,
            "{what}, {name}: {found:e} is not {truth:e}, by more than {accepted:e}"
        );
    }
}

fn check_pose_and_velocity(wheels: &PreparedWheels, pose: [f64; 6], velocity: Velocity) {
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
        let small = [5e-9, 5e-9, 5e-9, 5e-9, 1e-6, 1e-6][k];
        check(&format!("pose {k} at {pose:?}"), found, small, &|change| {
            let mut moved = pose;
            moved[k] += change;
            solved(wheels, moved, velocity)
        });
    }
    let by_velocity = step
        .tangent
        .derivatives(WheelInput::Velocity, &unmonitored)
        .unwrap();
    for (k, found) in by_velocity.iter().enumerate() {
        check(
            &format!("velocity {k} at {pose:?}"),
            found,
            1e-5,
            &|change| {
                let moved = match velocity {
                    Velocity::Rolling(speed) => Velocity::Rolling(speed + change),
                    Velocity::Rigid(mut rigid) => {
                        rigid[k] += change;
                        Velocity::Rigid(rigid)
                    }
                };
                solved(wheels, pose, moved)
            },
        );
    }
}

fn prepared(wheelset: Wheelset) -> PreparedWheels {
    PreparedWheels::to_accuracy(wheelset, EXACT).unwrap()
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
        check_pose_and_velocity(&wheels, pose, velocity);
    }
}

#[test]
fn derivatives_by_friction_force_and_layer_are_differences() {
    let pose = [0.05, -2.3e-3, f64::NAN, 0.0, 0.0, 2e-3];
    let velocity = Velocity::Rolling(20.0);
    let exponential = |k: usize, by: f64| {
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
    };
    let table = |k: usize, by: f64| {
        let mut coefficient = vec![0.3, 0.25, 0.2];
        coefficient[k] += by;
        Friction::SpeedDependent {
            law: SlipLaw::Table {
                slip_speed: vec![0.0, 0.033, 0.3],
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
        (3, &|k, by| table(k, by).into()),
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
            check(&format!("friction {k} of {count}"), found, 1e-7, &|by| {
                solved(&made(k, by), pose, velocity)
            });
        }
        let [by_force] = &step
            .tangent
            .derivatives(WheelInput::Force, &unmonitored)
            .unwrap()[..]
        else {
            panic!("one force");
        };
        check("force", by_force, 0.3, &|by| {
            let mut wheelset = wheelset(Sides::Right, law(0, 0.0));
            wheelset.force += by;
            solved(&prepared(wheelset), pose, velocity)
        });
        let [by_layer] = &step
            .tangent
            .derivatives(WheelInput::Layer, &unmonitored)
            .unwrap()[..]
        else {
            panic!("one layer");
        };
        check("layer", by_layer, 1e-20, &|by| {
            let mut wheelset = wheelset(Sides::Right, law(0, 0.0));
            wheelset.layer += by;
            solved(&prepared(wheelset), pose, velocity)
        });
    }
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

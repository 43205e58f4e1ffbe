// SPDX-License-Identifier: MIT OR Apache-2.0
//! Derivatives of steps against differences of steps.

use std::sync::Arc;

use mtb_complementarity::linear::Status;
use mtb_contact::Error;
use mtb_contact::interface::Interface;
use mtb_contact::prepared::{
    INPUTS, NamedMotion, OUTPUTS, Prepared, PreparedContact, Pull, Step, Table,
};
use mtb_contact::problem::{Geometry, Means, Outcome};
use mtb_contact::sliding::RigidMotion;
use mtb_contact::stepping::{Found, Given, Influence, Linearised, SlidingState};
use mtb_operator::unmonitored;
use proptest::prelude::*;
use proptest::test_runner::TestRng;

const N: usize = 14;
const M: usize = 2;
const FREE: [f64; 6] = [f64::NAN; 6];

/// Points on a bumpy surface, a pair whose friction opens gaps, two free motions (along z and about y), tables over
/// the speed, a magnetic pressure.
fn bumpy(random: &mut TestRng, standstill_speed: Option<f64>) -> Prepared {
    let mut next = move || 2.0 * random.random::<f64>() - 1.0;
    let mut block = |size: f64| -> Vec<f64> { (0..N * N).map(|_| size * next()).collect() };
    let half = block(0.15);
    let mut normal = vec![0.0; N * N];
    for i in 0..N {
        for j in 0..N {
            normal[j * N + i] = (0..N).map(|k| half[k * N + i] * half[k * N + j]).sum();
        }
        normal[i * N + i] += 1.0;
    }
    let along = [Some(block(0.1)), Some(block(0.1))];
    let mut vector =
        |size: f64, length: usize| -> Vec<f64> { (0..length).map(|_| size * next()).collect() };
    let (tilt_x, tilt_y, height) = (vector(0.2, N), vector(0.2, N), vector(0.3, N));
    let mut frame: [Vec<f64>; 3] = [vec![0.0; 3 * N], vec![0.0; 3 * N], vec![0.0; 3 * N]];
    for i in 0..N {
        let unit = |v: [f64; 3]| {
            let size = v.iter().map(|c| c * c).sum::<f64>().sqrt();
            v.map(|c| c / size)
        };
        let x = unit([1.0, 0.0, tilt_x[i]]);
        let raw = [-tilt_x[i], tilt_y[i], 1.0];
        let dot: f64 = raw.iter().zip(x).map(|(a, b)| a * b).sum();
        let z = unit([
            raw[0] - dot * x[0],
            raw[1] - dot * x[1],
            raw[2] - dot * x[2],
        ]);
        let y = [
            z[1] * x[2] - z[2] * x[1],
            z[2] * x[0] - z[0] * x[2],
            z[0] * x[1] - z[1] * x[0],
        ];
        for (axis, v) in [x, y, z].into_iter().enumerate() {
            for c in 0..3 {
                frame[axis][c * N + i] = v[c];
            }
        }
    }
    let place = |i: usize| [(i % 7) as f64 - 3.0, (i / 7) as f64 - 0.5, height[i]];
    let motion = |moved: &dyn Fn([f64; 3]) -> [f64; 3]| {
        let along = |axis: usize, sign: f64| -> Vec<f64> {
            (0..N)
                .map(|i| {
                    let u = moved(place(i));
                    (0..3).map(|c| sign * frame[axis][c * N + i] * u[c]).sum()
                })
                .collect()
        };
        RigidMotion {
            tangential_x: along(0, -1.0),
            tangential_y: along(1, -1.0),
            opening: along(2, 1.0),
            work: 0.0,
        }
    };
    let free = [
        ("z", motion(&|_| [0.0, 0.0, 1.0]), 2),
        ("pitch", motion(&|x| [x[2], 0.0, -x[0]]), 4),
    ];
    let motions = free.map(|(name, motion, component)| NamedMotion {
        name: name.to_owned(),
        motion,
        component: Some(component),
    });
    let mut row = |gap: f64, size: f64, work: [f64; M]| {
        let mut row: Vec<f64> = vector(size, N);
        for g in &mut row {
            *g += gap;
        }
        row.extend(work);
        row
    };
    let loads = vec![row(0.5, 0.5, [-9.0, 1.0]), row(0.5, 0.5, [-12.0, -2.0])];
    let magnetic = [row(0.5, 0.5, [-3.0, 0.5]), row(0.0, 0.02, [-6.0, 1.0])];
    let friction = [0.25, 0.1].map(|mu| vector(0.05, N).into_iter().map(|v| mu + v).collect());
    Prepared {
        bodies: None,
        influence: Arc::new(Influence::from_columns(N, normal, along).unwrap()),
        geometry: Geometry {
            points: (0..3 * N).map(|k| place(k % N)[k / N]).collect(),
            normal: frame[2].clone(),
            tangent_x: frame[0].clone(),
            tangent_y: frame[1].clone(),
            area: vector(0.2, N).into_iter().map(|v| 1.0 + v).collect(),
            mean_frame: frame,
            means: Some(Means {
                start: (0..=N).map(|i| 2 * i).collect(),
                column: (0..N).flat_map(|i| [i, (i + 1) % N]).collect(),
                share: [0.8, 0.2].repeat(N),
            }),
            windows: Vec::new(),
        },
        motions: motions.to_vec(),
        friction: Table::new(vec![0.0, 10.0], friction.to_vec()).unwrap(),
        loads: Table::new(vec![0.0, 10.0], loads).unwrap(),
        magnetic: Some(magnetic),
        magnet: None,
        pulled: None,
        sliding_direction: [1.0, 0.0],
        reference_point: [0.1, -0.2, 1.5],
        standstill_speed,
        velocity: None,
        interface: Interface::default(),
    }
}

/// Pose, velocity and magnetic pressure as one vector, in the order of the inputs.
fn taken(contact: &mut PreparedContact, given: &[f64; 9], uniform: bool) -> Option<Outcome> {
    softened(contact, given, uniform, 0.1)
}

/// The same, with up to three parts `share` of the own compliance of each point as diagonal.
fn softened(
    contact: &mut PreparedContact,
    given: &[f64; 9],
    uniform: bool,
    share: f64,
) -> Option<Outcome> {
    let own = contact.prepared().influence.normal().iter().step_by(N + 1);
    let diagonal: Vec<f64> = own
        .enumerate()
        .map(|(i, own)| own * share * ((i % 5) as f64 - 1.0))
        .collect();
    let mut pose = [0.0; 6];
    pose.copy_from_slice(&given[..6]);
    let step = Step {
        pose,
        velocity: [given[6], given[7]],
        pull: if uniform {
            Pull::Uniform(given[8])
        } else {
            Pull::Scene
        },
        gap: None,
        friction: None,
        diagonal: uniform.then_some(&diagonal),
        shift: None,
    };
    let out = contact.step(&step, &unmonitored).unwrap();
    (out.solution.status == Status::Solved).then_some(out)
}

fn outputs(contact: &PreparedContact, out: &Outcome) -> Vec<f64> {
    let mean = out.mean_tractions(&contact.prepared().geometry);
    let peak = mean[2 * N..].iter().copied().fold(0.0, f64::max);
    let mut all = [out.force, out.moment].concat();
    all.extend([out.friction_power, peak]);
    all
}

/// The points in contact, and the place of the peak.
fn in_contact(contact: &PreparedContact, out: &Outcome) -> (Vec<bool>, Option<usize>) {
    let p = &out.solution.pressure;
    let mean = out.mean_tractions(&contact.prepared().geometry);
    let peak = (0..N).max_by(|a, b| mean[2 * N + a].total_cmp(&mean[2 * N + b]));
    (p.iter().map(|p| *p > 0.0).collect(), peak)
}

/// Central difference with Richardson's extrapolation; `None` where the points in contact change on the way.
fn difference(
    contact: &mut PreparedContact,
    given: &[f64; 9],
    at: usize,
    uniform: bool,
) -> Option<Vec<f64>> {
    let out = taken(contact, given, uniform)?;
    let here = in_contact(contact, &out);
    let mut by = |h: f64| -> Option<Vec<f64>> {
        let mut side = |h: f64| {
            let mut moved = *given;
            moved[at] += h;
            let out = taken(contact, &moved, uniform)?;
            (in_contact(contact, &out) == here).then(|| outputs(contact, &out))
        };
        let (ahead, behind) = (side(h)?, side(-h)?);
        let pairs = ahead.iter().zip(&behind);
        Some(pairs.map(|(a, b)| (a - b) / (2.0 * h)).collect())
    };
    let (wide, narrow) = (by(2e-3)?, by(1e-3)?);
    let pairs = wide.iter().zip(&narrow);
    Some(pairs.map(|(w, n)| (4.0 * n - w) / 3.0).collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn jacobians_are_differences(
        mut random in any::<u64>().prop_perturb(|_, rng| rng),
        posed in any::<[bool; 6]>(),
        uniform in any::<bool>(),
        slow in any::<bool>(),
        speed in 0.5_f64..4.0,
        angle in -3.0_f64..3.0,
    ) {
        let prepared = Arc::new(bumpy(&mut random, slow.then_some(5.0)));
        let mut contact = PreparedContact::new(prepared);
        let mut given = [0.0; 9];
        for (c, is_posed) in posed.into_iter().enumerate() {
            let value = 0.1 * (2.0 * random.random::<f64>() - 1.0);
            given[c] = if is_posed { value } else { f64::NAN };
        }
        given[6..].copy_from_slice(&[speed * angle.cos(), speed * angle.sin(), 1.5]);
        // a step before, so that its factors are those of another friction
        let mut before = given;
        before[6] *= 0.9;
        let _ = softened(&mut contact, &before, uniform, 0.08);
        let Some(out) = taken(&mut contact, &given, uniform) else { return Ok(()) };
        if out.in_contact().iter().filter(|c| **c).count() <= M {
            return Ok(());
        }
        let jacobian = contact.jacobian(&unmonitored).unwrap();
        // the same with factors of its own
        let step = contact.taken().unwrap().clone();
        let influence = contact.prepared().influence.clone();
        let mut own = Linearised::new(influence, step.state().clone(), &unmonitored).unwrap();
        let of = contact.prepared().outputs(&step);
        let by_own = own.tangent().unwrap().adjoint(&of, &unmonitored).unwrap();
        let by_step = contact.gradients(&step, &of, &unmonitored).unwrap();
        for (own, step) in by_own.iter().zip(&by_step) {
            // what balance determines does not depend on the gap
            let size = own.gap.iter().fold(1.0_f64, |s, v| s.max(v.abs()));
            for (a, b) in own.gap.iter().zip(&step.gap) {
                prop_assert!((a - b).abs() <= 1e-10 * size, "{} {} {}", a, b, size);
            }
        }
        for (at, name) in INPUTS[..9].iter().enumerate() {
            if at == 8 && !uniform {
                continue;
            }
            let mut from = given;
            if at < 6 && given[at].is_nan() {
                if contact.prepared().motions.iter().any(|m| m.component == Some(at)) {
                    for row in &jacobian {
                        prop_assert_eq!(row[at], 0.0);
                    }
                    continue;
                }
                from[at] = 0.0;
            }
            let Some(wanted) = difference(&mut contact, &from, at, uniform) else { continue };
            for ((row, wanted), of) in jacobian.iter().zip(&wanted).zip(OUTPUTS) {
                let size = wanted.abs().max(1.0);
                prop_assert!(
                    (row[at] - wanted).abs() <= 2e-8 * size,
                    "{} by {}: {} instead of {}", of, name, row[at], wanted
                );
            }
        }
    }

    #[test]
    fn forward_and_adjoint_are_transposed(mut random in any::<u64>().prop_perturb(|_, rng| rng)) {
        let prepared = Arc::new(bumpy(&mut random, None));
        let mut contact = PreparedContact::new(prepared.clone());
        let given = [FREE.to_vec(), vec![2.0, 1.0, 1.0]].concat();
        if taken(&mut contact, &given.try_into().unwrap(), false).is_none() {
            return Ok(());
        }
        let step = contact.taken().unwrap().clone();
        // twice the friction is twice as near to wedging
        let limit = |state: SlidingState| {
            let mut own = Linearised::new(prepared.influence.clone(), state, &unmonitored).unwrap();
            own.tangent().unwrap().wedging_factor(&unmonitored).unwrap()
        };
        let once = limit(step.state().clone());
        let twice = step.state().friction.iter().map(|mu| 2.0 * mu).collect();
        let twice = limit(SlidingState { friction: twice, ..step.state().clone() });
        prop_assert!(once > 0.0 && (2.0 * twice / once - 1.0).abs() < 1e-6, "{} {}", once, twice);
        // a friction that follows the pressure, and a hardness at which the largest ones are held
        let slope = step.state().friction.iter().map(|mu| 0.7 * mu).collect();
        let pressure = &step.state().pressure;
        let largest = pressure.iter().fold(0.0, |m: f64, p| m.max(*p));
        let held = |p: &f64| if *p > 0.8 * largest { *p } else { 2.0 * largest };
        let limit = Some(pressure.iter().map(held).collect());
        let state = SlidingState { slope, limit, ..step.state().clone() };
        let mut own = Linearised::new(prepared.influence.clone(), state, &unmonitored).unwrap();
        let mut tangent = own.tangent().unwrap();
        let mut vector = |length: usize| -> Vec<f64> {
            (0..length).map(|_| 2.0 * random.random::<f64>() - 1.0).collect()
        };
        let change = Given {
            gap: vector(N), work: vector(M), drag: vector(2 * N), pull: Vec::new(), hardness: vector(N),
        };
        let weights = Found {
            pressure: vector(N), traction: vector(2 * N), gap: vector(N), motion: vector(M),
            pull: Vec::new(),
        };
        let found = tangent.forward(std::slice::from_ref(&change), &unmonitored).unwrap().remove(0);
        let gradient = tangent.adjoint(std::slice::from_ref(&weights), &unmonitored).unwrap().remove(0);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let forward = [
            dot(&weights.pressure, &found.pressure), dot(&weights.traction, &found.traction),
            dot(&weights.gap, &found.gap), dot(&weights.motion, &found.motion),
        ];
        let adjoint = [
            dot(&gradient.gap, &change.gap), dot(&gradient.work, &change.work),
            dot(&gradient.drag, &change.drag), dot(&gradient.hardness, &change.hardness),
        ];
        prop_assert!(gradient.hardness.iter().any(|by| *by != 0.0));
        let (forward, adjoint) = (forward.iter().sum::<f64>(), adjoint.iter().sum::<f64>());
        prop_assert!((forward - adjoint).abs() <= 1e-11 * (1.0 + forward.abs()));
    }
}

#[test]
fn there_are_none_before_a_step() {
    let mut random = TestRng::deterministic_rng(proptest::test_runner::RngAlgorithm::ChaCha);
    let mut contact = PreparedContact::new(Arc::new(bumpy(&mut random, None)));
    assert_eq!(contact.jacobian(&unmonitored), Err(Error::NoStep));
}

#[test]
fn a_lifted_body_has_a_load_that_does_not_change() {
    let mut random = TestRng::deterministic_rng(proptest::test_runner::RngAlgorithm::ChaCha);
    let mut contact = PreparedContact::new(Arc::new(bumpy(&mut random, None)));
    let given = [0.0, 0.0, 9.0, 0.0, 0.0, 0.0, 2.0, 1.0, 1.5];
    assert!(taken(&mut contact, &given, true).is_some());
    assert_eq!(
        contact.jacobian(&unmonitored),
        Ok([[0.0; INPUTS.len()]; OUTPUTS.len()])
    );
}

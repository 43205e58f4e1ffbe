// SPDX-License-Identifier: MIT OR Apache-2.0
//! Prepared contacts: balance, poses, and bytes that are what they say.

use std::sync::Arc;

use mtb_complementarity::linear::Status;
use mtb_contact::coupled::{CoupledMatrix, PointState};
use mtb_contact::interface::{Interface, RoughLaw};
use mtb_contact::prepared::{
    Magnetic, NamedMotion, Prepared, PreparedContact, Pull, Sliding, Source, Step, Table,
};
use mtb_contact::problem::{
    self, Attracted, Body, Friction, Geometry, Loading, Means, Problem, Window,
};
use mtb_contact::sliding::RigidMotion;
use mtb_contact::stepping::Influence;
use mtb_elasticity::Material;
use mtb_elasticity::half_space::HalfSpace;
use mtb_operator::{Grid, Relative, unmonitored};
use proptest::prelude::*;

const N: usize = 3;

/// Three points in a row, 1 apart, on springs of stiffness 1, free to move along z.
fn springs() -> Prepared {
    let normal: Vec<f64> = (0..N * N)
        .map(|k| if k % (N + 1) == 0 { 1.0 } else { 0.0 })
        .collect();
    let unit = |axis: usize| -> Vec<f64> {
        (0..3 * N)
            .map(|k| if k / N == axis { 1.0 } else { 0.0 })
            .collect()
    };
    let loads = |gap: f64, work: f64| [vec![gap; N], vec![work]].concat();
    Prepared {
        bodies: None,
        influence: Arc::new(Influence::from_columns(N, normal, [None, None]).unwrap()),
        geometry: Geometry {
            points: vec![-1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            normal: unit(2),
            tangent_x: unit(0),
            tangent_y: unit(1),
            area: vec![1.0; N],
            mean_frame: [unit(0), unit(1), unit(2)],
            means: Some(Means {
                start: vec![0, 2, 4, 5],
                column: vec![0, 1, 1, 2, 2],
                share: vec![0.75, 0.25, 0.5, 0.5, 1.0],
            }),
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
        loads: Table::constant(loads(0.0, -3.0)),
        magnetic: Some([loads(0.0, 0.0), loads(0.0, -1.5)]),
        magnet: None,
        pulled: None,
        sliding_direction: [1.0, 0.0],
        reference_point: [0.0, 0.0, 2.0],
        standstill_speed: None,
        velocity: Some(12.5),
        interface: Interface::default(),
    }
}

fn step(pose: [f64; 6], velocity: [f64; 2], pull: Pull<'_>) -> Step<'_> {
    Step {
        pose,
        velocity,
        pull,
        gap: None,
        friction: None,
        diagonal: None,
        shift: None,
    }
}

const FREE: [f64; 6] = [f64::NAN; 6];

#[test]
fn force_and_moment_are_those_of_the_pressures() {
    let mut contact = PreparedContact::new(Arc::new(springs()));
    let out = contact
        .step(&step(FREE, [5.0, 0.0], Pull::Scene), &unmonitored)
        .unwrap();
    assert_eq!(out.solution.status, Status::Solved);
    for (found, wanted) in out.force.iter().zip([0.9, 0.0, -3.0]) {
        assert!((found - wanted).abs() < 1e-12, "{:?}", out.force);
    }
    assert!((out.friction_power - 4.5).abs() < 1e-12);
    // friction 2 below the reference point
    assert!((out.moment[1] + 1.8).abs() < 1e-12, "{:?}", out.moment);
    let back = contact
        .step(&step(FREE, [-5.0, 0.0], Pull::Uniform(4.0)), &unmonitored)
        .unwrap();
    assert!((back.friction_power - 9.0).abs() < 1e-12);
    assert!((back.force[0] + 1.8).abs() < 1e-12 && (back.force[2] + 6.0).abs() < 1e-12);
}

/// A plate over a body that is pulled, on a grid of half-space cells: what the problem says of it at once and
/// what it says step by step come from two solvers.
#[test]
fn steps_are_what_the_problem_solves() {
    const SIDE: usize = 8;
    const M: usize = SIDE * SIDE;
    let at = |i: usize| [i % SIDE, i / SIDE].map(|k| (k as f64 - 3.5) * 1e-3);
    let unit = |axis: usize| -> Vec<f64> {
        (0..3 * M)
            .map(|k| f64::from(u8::from(k / M == axis)))
            .collect()
    };
    let frame = [unit(0), unit(1), unit(2)];
    let geometry = Arc::new(Geometry {
        points: (0..3 * M)
            .map(|k| if k < 2 * M { at(k % M)[k / M] } else { 0.0 })
            .collect(),
        tangent_x: frame[0].clone(),
        tangent_y: frame[1].clone(),
        normal: frame[2].clone(),
        area: vec![1e-6; M],
        mean_frame: frame,
        means: None,
        windows: Vec::new(),
    });
    let grid = Grid::new(SIDE, SIDE, 1e-3, 1e-3).unwrap();
    let soft = HalfSpace::new(Material::new(80e9, 0.1).unwrap(), grid).unwrap();
    let hard = HalfSpace::new(Material::new(120e9, 0.3).unwrap(), grid).unwrap();
    let pair = Relative::new(Some(Arc::new(soft)), Some(Arc::new(hard))).unwrap();
    let lift = problem::FreeMotion::of(&geometry, Body::Upper, &unit(2)).unwrap();
    let problem = Problem::new(pair, geometry, vec![lift]).unwrap();
    let gap: Vec<f64> = (0..M)
        .map(|i| at(i).map(|v| v * v / 20.0).iter().sum())
        .collect();
    let mut loading = problem.unloaded(gap);
    loading.work[0] = -20.0;
    let pulls = [0.5e6, 2e6]
        .map(|peak| -> Vec<f64> { (0..M).map(|i| peak * (1.0 + at(i)[0] / 5e-3)).collect() });
    let bodies = [
        Attracted {
            body: Body::Upper,
            at_face: false,
        },
        Attracted {
            body: Body::Lower,
            at_face: true,
        },
    ];
    let magnetic = Magnetic {
        bodies: &bodies,
        source: Source::Pressure(Table::new(vec![1.0, 3.0], pulls.to_vec()).unwrap()),
    };
    let sliding = Sliding {
        friction: Table::constant(vec![0.3; M]),
        direction: [1.0, 0.0],
        standstill_speed: None,
        velocity: None,
        layer: 0.0,
    };
    let named = |count: usize| vec![("z".to_owned(), Some(2)); count];
    let prepare = |count: usize| {
        let sliding = sliding.clone();
        let magnetic = Some(&magnetic);
        Prepared::new(
            &problem,
            &loading,
            magnetic,
            named(count),
            sliding,
            [0.0; 3],
            &unmonitored,
        )
    };
    assert!(prepare(2).is_err());
    let mut contact = PreparedContact::new(Arc::new(prepare(1).unwrap()));
    shifts_out_of_bytes_are_those_of_the_contact(contact.prepared());
    let halfway: Vec<f64> = (0..M).map(|i| 0.5 * (pulls[0][i] + pulls[1][i])).collect();
    let uniform = vec![3e6; M];
    for (pull, pressure, speed) in [
        (Pull::Scene, &pulls[0], 1.0),
        (Pull::Scene, &halfway, -2.0),
        (Pull::Uniform(3e6), &uniform, 1.0),
    ] {
        let mut loading = loading.clone();
        for pulled in bodies {
            problem.load(&mut loading, pulled.by(pressure)).unwrap();
        }
        let direction = problem.geometry().sliding_direction([speed, 0.0]).unwrap();
        let friction = Friction::Field(&[0.3; M]);
        let whole = problem
            .slide(&loading, &direction, friction, None, &unmonitored)
            .unwrap();
        let stepped = contact
            .step(&step(FREE, [speed, 0.0], pull), &unmonitored)
            .unwrap();
        assert_eq!(stepped.solution.status, Status::Solved);
        let largest = whole.solution.pressure.iter().copied().fold(0.0, f64::max);
        for (a, b) in stepped
            .solution
            .pressure
            .iter()
            .zip(&whole.solution.pressure)
        {
            assert!((a - b).abs() < 1e-9 * largest, "{a} {b}");
        }
        // what pulls the body below moves its surface and adds nothing to the force
        let pulled: f64 = pressure.iter().sum::<f64>() * 1e-6;
        assert!((stepped.force[2] / (20.0 + pulled) + 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_prescribed_component_takes_the_place_of_its_motion() {
    let mut contact = PreparedContact::new(Arc::new(springs()));
    let mut pose = FREE;
    pose[2] = -0.5;
    let out = contact
        .step(&step(pose, [1.0, 0.0], Pull::Scene), &unmonitored)
        .unwrap();
    assert!((out.force[2] + 1.5).abs() < 1e-12);
    pose[4] = 0.1;
    let out = contact
        .step(&step(pose, [1.0, 0.0], Pull::Scene), &unmonitored)
        .unwrap();
    // nose (x > 0) down by a positive pitch, about a point 2 above
    let by_angle: Vec<f64> = [-1.0, 0.0, 1.0]
        .iter()
        .map(|x| 0.5 + x * 0.1_f64.sin() + 2.0 * (0.1_f64.cos() - 1.0))
        .collect();
    for (p, wanted) in out.solution.pressure.iter().zip(by_angle) {
        assert!((p - wanted).abs() < 1e-12, "{p} {wanted}");
    }
}

#[test]
fn mean_pressures_keep_the_force() {
    let prepared = springs();
    let mean = prepared.geometry.mean_tractions(&[4.0, 0.0, 2.0]);
    assert_eq!(mean, [3.0, 0.0, 3.0]);
    assert_eq!(
        prepared.geometry.mean_tractions(&[4.0, 2.0, 2.0]),
        [3.5, 2.0, 2.0]
    );
}

#[test]
fn what_cannot_be_asked_is_named() {
    let mut contact = PreparedContact::new(Arc::new(springs()));
    let mut ask = |pose, velocity, pull| {
        contact
            .step(&step(pose, velocity, pull), &unmonitored)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        ask(FREE, [11.0, 0.0], Pull::Scene),
        "velocity is 11 m/s: the table of friction covers 0 to 10 m/s"
    );
    assert!(ask(FREE, [0.0, 0.0], Pull::Scene).starts_with("velocity is 0: at rest"));
    assert_eq!(
        ask(
            [f64::INFINITY, 0.0, 0.0, 0.0, 0.0, 0.0],
            [1.0, 0.0],
            Pull::Scene
        ),
        "pose[0] is inf, a finite number is needed"
    );
    let (fast, nan) = ([1.0, 0.0], f64::NAN);
    let deep = Loading {
        gap: vec![-1e308; N],
        work: vec![0.0],
        along: vec![0.0; 2 * N],
        diagonal: None,
    };
    for (pose, velocity, pull, wanted) in [
        (
            [nan, nan, -1e300, nan, nan, nan],
            fast,
            Pull::Scene,
            "pose[2] is -1e+300",
        ),
        (FREE, [0.0, 1e31], Pull::Scene, "velocity[1] is 1e+31"),
        (FREE, [nan, 0.0], Pull::Scene, "velocity[0] is NaN"),
        (
            FREE,
            fast,
            Pull::Uniform(1e300),
            "magnetic_pressure[0] is 1e+300",
        ),
        (
            [nan, nan, -1.0, nan, nan, nan],
            fast,
            Pull::Given(&deep),
            "the numbers given are too large",
        ),
    ] {
        let message = ask(pose, velocity, pull);
        assert!(message.starts_with(wanted), "{message}");
    }
    let mut slow = springs();
    slow.standstill_speed = Some(0.1);
    let out = PreparedContact::new(Arc::new(slow))
        .step(&step(FREE, [0.0, 0.0], Pull::Scene), &unmonitored)
        .unwrap();
    assert!(out.force[0] == 0.0 && (out.force[2] + 3.0).abs() < 1e-12);
}

#[test]
fn bytes_come_back_and_changes_are_found() {
    let prepared = springs();
    let bytes = prepared.to_bytes(&unmonitored).unwrap();
    assert_eq!(Prepared::from_bytes(&bytes).unwrap(), prepared);
    for cut in 0..bytes.len() {
        assert!(Prepared::from_bytes(&bytes[..cut]).is_err());
        let mut changed = bytes.clone();
        changed[cut] ^= 0x10;
        assert!(
            Prepared::from_bytes(&changed).is_err(),
            "a change at {cut} went unnoticed"
        );
    }
    // the signs of two numbers: a sum that only carries upwards takes them for the same
    let mut changed = bytes.clone();
    // behind the reference point come whether there are a standstill speed, grids, a hardness, a layer that yields, a
    // rough layer, both bodies and a magnet
    for at in [bytes.len() - 49, bytes.len() - 57] {
        changed[at] ^= 0x80;
    }
    assert!(Prepared::from_bytes(&changed).is_err());
}

#[test]
fn what_a_grid_cuts_off_is_refused_wherever_the_bytes_have_been() {
    let inside = Window {
        start: 1,
        nx: 1,
        ny: 1,
    };
    let all = Window {
        start: 0,
        nx: 3,
        ny: 1,
    };
    for windows in [vec![inside], vec![all], vec![]] {
        let mut prepared = springs();
        prepared.geometry.windows = windows;
        let read = Prepared::from_bytes(&prepared.to_bytes(&unmonitored).unwrap()).unwrap();
        assert_eq!(read, prepared);
        for prepared in [prepared, read] {
            let is_free = prepared.geometry.windows.is_empty();
            let grid = prepared.geometry.windows.first().copied();
            let mut contact = PreparedContact::new(Arc::new(prepared));
            let mut ask = |z: f64| {
                contact.step(
                    &step([f64::NAN, 0.0, z, 0.0, 0.0, 0.0], [1.0, 0.0], Pull::Scene),
                    &unmonitored,
                )
            };
            // lifted off nothing reaches the edge, before and after a refusal
            assert!(ask(1.0).is_ok());
            assert_eq!(ask(-0.5).is_ok(), is_free);
            if let Some(grid) = grid {
                let message = ask(-0.5).unwrap_err().to_string();
                let wanted = format!(
                    "the contact reaches the edge of the grid of {} x {} points",
                    grid.nx, grid.ny
                );
                assert!(message.starts_with(&wanted), "{message}");
            }
            assert!(ask(1.0).is_ok());
        }
    }
    let mut partial = springs();
    partial.geometry.windows = vec![Window {
        start: 1,
        nx: 3,
        ny: 1,
    }];
    assert!(partial.check().is_err());
    partial.geometry.windows = vec![Window {
        start: 1,
        nx: usize::MAX,
        ny: 3,
    }];
    assert!(partial.check().is_err());
    assert!(Prepared::from_bytes(&partial.to_bytes(&unmonitored).unwrap()).is_err());
}

#[test]
fn files_of_earlier_versions_are_read() {
    let prepared = Prepared {
        velocity: None,
        ..springs()
    };
    let bytes = prepared.to_bytes(&unmonitored).unwrap();
    let mut old = Vec::new();
    // without the flags of a velocity, of a magnet, of both bodies, of a layer that yields, of a hardness and of a rough
    // layer, and of the count of grids; there are none
    for (version, without) in [(7_u32, 8), (6, 16), (5, 24), (4, 32), (3, 48), (2, 56)] {
        let body = &bytes[24..bytes.len() - without];
        old = Vec::from(b"MTBC".as_slice());
        old.extend(version.to_le_bytes());
        old.extend((body.len() as u64).to_le_bytes());
        old.extend(u64::from(crc32fast::hash(body)).to_le_bytes());
        old.extend(body);
        assert_eq!(Prepared::from_bytes(&old).unwrap(), prepared);
    }
    for unknown in [1_u8, 9] {
        old[4] = unknown;
        let message = Prepared::from_bytes(&old).unwrap_err().to_string();
        assert!(message.ends_with("it is of another version"), "{message}");
    }
}

/// Springs of stiffness 1 under 3 N, of which one bears 0.5 Pa at most, on a layer that gives way by ln(1 + p).
#[test]
fn hardness_and_rough_layer_are_kept() {
    let law = RoughLaw::exponential(1.0, 1.0).unwrap();
    let prepared = Prepared {
        interface: Interface {
            limit: Some(vec![0.5, 2.0, 2.0]),
            shear: Some(vec![0.3, 0.4, 0.5]),
            rough: Some(law.clone()),
        },
        ..springs()
    };
    let read = Prepared::from_bytes(&prepared.to_bytes(&unmonitored).unwrap()).unwrap();
    assert_eq!(read, prepared);
    let mut contact = PreparedContact::new(Arc::new(read));
    let step = step(FREE, [5.0, 0.0], Pull::Scene);
    let found = contact.step(&step, &unmonitored).unwrap().solution;
    assert_eq!(found.status, Status::Solved);
    // the rest of the load divides evenly, as nothing couples the points
    assert_eq!(found.pressure[0], 0.5);
    assert!((found.pressure[1] - 1.25).abs() < 1e-9 && (found.pressure[2] - 1.25).abs() < 1e-9);
    let down = 1.25 + law.opening(1.25);
    assert!((found.gap[0] - (0.5 + law.opening(0.5) - down)).abs() < 1e-9);
}

proptest! {
    #[test]
    fn no_bytes_make_it_panic(body in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(Prepared::from_bytes(&body).is_err());
    }
}

/// A contact out of bytes that were written for it sticks and slips as the first one, and one out of others refuses.
fn shifts_out_of_bytes_are_those_of_the_contact(prepared: &Arc<Prepared>) {
    let bytes = prepared.to_bytes_for_shifts(&unmonitored).unwrap();
    let read = Arc::new(Prepared::from_bytes(&bytes).unwrap());
    assert_eq!(read.to_bytes_for_shifts(&unmonitored).unwrap(), bytes);
    let [mut first, mut second] =
        [prepared, &read].map(|prepared| PreparedContact::new(prepared.clone()));
    let mut stuck = Vec::new();
    for (along, pull) in [
        (0.0, Pull::Scene),
        (2e-7, Pull::Scene),
        (1e-7, Pull::Uniform(1e6)),
        (-4e-7, Pull::Scene),
        (0.0, Pull::Scene),
        (2e-6, Pull::Scene),
    ] {
        let pushed = Step {
            shift: Some([along, 0.5 * along]),
            ..step(FREE, [1.5, 0.0], pull)
        };
        let [one, other] =
            [&mut first, &mut second].map(|c| c.step(&pushed, &unmonitored).unwrap());
        for k in 0..3 {
            assert!((one.force[k] - other.force[k]).abs() < 1e-12 * one.force[2].abs());
        }
        assert_eq!(one.points, other.points);
        let sticks = |point: &&PointState| **point == PointState::Stick;
        stuck.push(one.points.iter().filter(sticks).count());
    }
    assert!(
        stuck.contains(&0) && stuck.iter().any(|s| *s > 0),
        "{stuck:?}"
    );
    let sliding = Prepared::from_bytes(&prepared.to_bytes(&unmonitored).unwrap()).unwrap();
    assert!(sliding.to_bytes_for_shifts(&unmonitored).is_err());
    let pushed = Step {
        shift: Some([1e-7, 0.0]),
        ..step(FREE, [1.5, 0.0], Pull::Scene)
    };
    let refused = PreparedContact::new(Arc::new(sliding)).step(&pushed, &unmonitored);
    assert!(
        refused
            .unwrap_err()
            .to_string()
            .contains("for sliding alone")
    );
    let none = CoupledMatrix::from_columns(1, &[0.0; 9]);
    assert!(none.is_err());
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use std::cell::Cell;
use std::ops::ControlFlow;
use std::sync::Arc;

use mtb_complementarity::linear::Status;
use mtb_elasticity::Material;
use mtb_elasticity::half_space::HalfSpace;
use mtb_operator::{Component, Grid, Progress, Relative, unmonitored};

use super::*;
use crate::sliding::{SlidingContact, SlidingMatrix};

const SIDE: usize = 18;
const N: usize = SIDE * SIDE;
const CELL: f64 = 1e-4;
const MU: f64 = 0.3;

/// A ball of 50 mm on a plane.
fn gap() -> Vec<f64> {
    let place = |i: usize| (i as f64 - 0.5 * (SIDE - 1) as f64) * CELL;
    (0..N)
        .map(|k| (place(k % SIDE).powi(2) + place(k / SIDE).powi(2)) / 0.1)
        .collect()
}

fn half_space(poisson_ratio: f64) -> Arc<dyn Compliance> {
    let material = Material::new(80e9, poisson_ratio).unwrap();
    Arc::new(HalfSpace::new(material, Grid::new(SIDE, SIDE, CELL, CELL).unwrap()).unwrap())
}

/// Free along the normal, pressed by a force [N].
fn pressed(force: f64) -> RigidMotion {
    RigidMotion {
        tangential_x: vec![0.0; N],
        tangential_y: vec![0.0; N],
        opening: vec![1.0; N],
        work: -force,
    }
}

/// Pressure and approach without friction, by the complementarity solver.
fn frictionless(pair: &Relative, force: f64) -> (Vec<f64>, Vec<f64>) {
    let direction = vec![0.0; 2 * N];
    let matrix = SlidingMatrix::new(pair, &direction, false, &unmonitored).unwrap();
    let contact = SlidingContact {
        gap: &gap(),
        area: &[CELL * CELL; N],
        friction: &[0.0; N],
        direction: &direction,
        motions: &[pressed(force)],
        diagonal: None,
        interface: None,
    };
    let found = matrix.solve(&contact, None, &unmonitored).unwrap();
    assert_eq!(found.status, Status::Solved);
    (found.pressure, found.motion)
}

fn coupled(pair: &Relative, motions: &[RigidMotion]) -> CoupledContact {
    let contact = Coupled {
        compliance: pair,
        layer: 0.0,
        area: &[CELL * CELL; N],
        friction: &[MU; N],
        gap: &gap(),
        motions,
    };
    CoupledContact::new(&contact, 1e-11, &unmonitored).unwrap()
}

fn along_x(displacement: f64) -> Vec<f64> {
    let mut push = vec![0.0; 3 * N];
    push[..N].fill(displacement);
    push
}

fn force(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() * CELL * CELL
}

/// As Ciavarella and Jaeger found, the traction of like bodies is the friction of the pressure, less that of
/// the pressure under a smaller force. With Poisson's ratio 0 this holds cell by cell, since the kernels are one.
#[test]
fn like_bodies_follow_ciavarella_and_jaeger() {
    let pair = Relative::new(Some(half_space(0.0)), Some(half_space(0.0))).unwrap();
    let load = 1000.0;
    let (pressure, motion) = frictionless(&pair, load);
    let contact = coupled(&pair, &[pressed(load)]);
    let rest = contact.at_rest(&pressure, &motion).unwrap();
    let found = contact
        .advance(&rest, &along_x(2e-6), 1, &unmonitored)
        .unwrap()
        .unwrap();
    let tangential = force(&found.traction[..N]);
    assert!((0.3..0.8).contains(&(tangential / (MU * load))));
    let (inner, _) = frictionless(&pair, load - tangential / MU);
    let largest = pressure.iter().fold(0.0_f64, |m, p| m.max(*p));
    for i in 0..N {
        let wanted = MU * (pressure[i] - inner[i]);
        assert!((found.traction[i] - wanted).abs() < 1e-7 * largest, "{i}");
        assert!(found.traction[N + i].abs() < 1e-9 * largest);
        assert!((found.pressure()[i] - pressure[i]).abs() < 1e-9 * largest);
        let stick = inner[i] > 1e-6 * largest;
        assert_eq!(stick, found.points[i] == PointState::Stick, "{i}");
    }
}

/// The error by finite pushes is of first order; following the path keeps it below the tolerance.
#[test]
fn a_path_is_followed_to_the_tolerance_and_converges_with_first_order() {
    // unlike bodies: the slip turns on the way, and the pressure follows
    let pair = Relative::new(Some(half_space(0.0)), None).unwrap();
    let load = 1000.0;
    let (pressure, motion) = frictionless(&pair, load);
    let contact = coupled(&pair, &[pressed(load)]);
    let rest = contact.at_rest(&pressure, &motion).unwrap();
    let aim = along_x(2e-6);
    let reached = |parts| {
        contact
            .in_parts(&rest, &aim, parts, &unmonitored)
            .unwrap()
            .unwrap()
    };
    let states: Vec<CoupledState> = [16, 32, 64, 128].map(reached).to_vec();
    let pairs = states.windows(2);
    let changes: Vec<f64> = pairs.map(|s| contact.change(&s[0], &s[1])).collect();
    let points = &states[3].points;
    assert!(points.contains(&PointState::Slip) && points.contains(&PointState::Stick));
    for (coarse, fine) in changes.iter().zip(&changes[1..]) {
        assert!((0.8..1.2).contains(&(coarse / fine).log2()), "{changes:?}");
    }
    // however many pushes lead there, against parts far finer
    let tolerance = 1e-3;
    assert!(contact.change(&reached(1), &states[3]) > tolerance);
    for pushes in [1, 3, 10] {
        let steps = (1..=pushes).map(|k| f64::from(k) / f64::from(pushes));
        let path: Vec<Vec<f64>> = steps.map(|share| along_x(2e-6 * share)).collect();
        let found = contact
            .follow(&rest, &path, tolerance, &unmonitored)
            .unwrap();
        assert!(found[0].path_error <= tolerance);
        let last = found.last().unwrap();
        assert!(contact.change(last, &states[3]) <= tolerance, "{pushes}");
    }
}

/// [Johnson1985, eq. 7.41]: `d = 3 mu F (2 - nu) / (8 G a) (1 - (1 - Q / (mu F))^(2/3))` for equal bodies.
#[test]
fn equal_spheres_follow_cattaneo_and_mindlin() {
    let nu = 0.3;
    let pair = Relative::new(Some(half_space(nu)), Some(half_space(nu))).unwrap();
    let load = 1000.0;
    let (pressure, motion) = frictionless(&pair, load);
    let contact = coupled(&pair, &[pressed(load)]);
    let modulus = 80e9 / (1.0 - nu);
    let radius = (0.75 * load * 0.05 / modulus).cbrt();
    let rest = contact.at_rest(&pressure, &motion).unwrap();
    let limit = 3.0 * MU * load * (2.0 - nu) / (8.0 * 80e9 * radius);
    let mut state = rest;
    for share in [0.25, 0.5, 0.75] {
        state = contact
            .advance(&state, &along_x(share * limit), 1, &unmonitored)
            .unwrap()
            .unwrap();
        let found = force(&state.traction[..N]) / (MU * load);
        let exact = 1.0 - (1.0_f64 - share).powf(1.5);
        // 13 cells over the contact
        assert!((found - exact).abs() < 0.02, "{share}: {found} {exact}");
    }
    let slid = contact
        .advance(&state, &along_x(1.3 * limit), 1, &unmonitored)
        .unwrap()
        .unwrap();
    // a little of it turns aside, which the closed form neglects
    assert!((force(&slid.traction[..N]) / (MU * load) - 1.0).abs() < 2e-3);
    for i in 0..N {
        let q = slid.traction[i].hypot(slid.traction[N + i]);
        assert!((q - MU * slid.pressure()[i]).abs() < 1e-9 * MU * load / (CELL * CELL));
    }
    assert!(slid.points.iter().all(|p| *p != PointState::Stick));
    assert!(2.0 * radius > 13.0 * CELL);
}

/// Springs of their own under each point, tilted: the state is known point by point.
#[test]
fn tilted_springs_are_solved_point_by_point() {
    struct Springs;
    const COUNT: usize = 4;
    impl Compliance for Springs {
        fn points(&self) -> usize {
            COUNT
        }
        fn add_displacement(
            &self,
            observed: Component,
            loaded: Component,
            scale: f64,
            traction: &[f64],
            displacement: &mut [f64],
        ) {
            let entry = match (observed, loaded) {
                (Component::Normal, Component::Normal) => 1.0,
                (Component::X, Component::X) => 2.0,
                (Component::Y, Component::Y) => 4.0,
                // a traction along x opens the gap
                (Component::Normal, Component::X) | (Component::X, Component::Normal) => 0.5,
                _ => 0.0,
            };
            for (u, t) in displacement.iter_mut().zip(traction) {
                *u += scale * entry * t;
            }
        }
    }
    let gap = [-2.0, -1.0, -0.1, 0.5];
    let contact = Coupled {
        compliance: &Springs,
        layer: 0.5,
        area: &[1.0; COUNT],
        friction: &[0.4; COUNT],
        gap: &gap,
        motions: &[],
    };
    let contact = CoupledContact::new(&contact, 1e-13, &unmonitored).unwrap();
    let pressure: Vec<f64> = gap.iter().map(|g| f64::max(-g, 0.0)).collect();
    let rest = contact.at_rest(&pressure, &[]).unwrap();
    for displacement in [0.3, 5.0] {
        let mut push = vec![0.0; 3 * COUNT];
        push[..COUNT].fill(displacement);
        let found = contact
            .advance(&rest, &push, 1, &unmonitored)
            .unwrap()
            .unwrap();
        for i in 0..COUNT {
            // p + q / 2 = -g and (2 + 1/2) q + p / 2 = d - g / 2 where it sticks, q = mu p where it slips
            let stick = displacement / (2.5 - 0.25);
            let slip = -0.4 * gap[i] / 1.2;
            let q = stick.min(slip).max(0.0);
            let p = (-gap[i] - 0.5 * q).max(0.0);
            assert!((found.traction[i] - q).abs() < 1e-10, "{i}");
            assert!((found.pressure()[i] - p).abs() < 1e-10, "{i}");
            let state = match () {
                () if gap[i] >= 0.0 => PointState::Open,
                () if stick < slip => PointState::Stick,
                () => PointState::Slip,
            };
            assert_eq!(found.points[i], state, "{i}");
        }
    }
}

#[test]
fn motions_that_move_both_bodies_alike_count_once() {
    let pair = Relative::new(Some(half_space(0.2)), None).unwrap();
    let load = 40.0;
    let (pressure, motion) = frictionless(&pair, load);
    let push = along_x(0.4e-6);
    let found = |motions: &[RigidMotion], motion: &[f64]| {
        let contact = coupled(&pair, motions);
        let rest = contact.at_rest(&pressure, motion).unwrap();
        contact
            .advance(&rest, &push, 1, &unmonitored)
            .unwrap()
            .unwrap()
    };
    let once = found(&[pressed(load)], &motion);
    // both bodies guided and pressed together: the one goes down by half, the other comes up by half
    let half = 0.5 * motion[0];
    let twice = found(&[pressed(load), pressed(load)], &[half, half]);
    assert_eq!((once.motion.len(), twice.motion.len()), (1, 1));
    let largest = pressure.iter().fold(0.0_f64, |m, p| m.max(*p));
    for (a, b) in once.traction.iter().zip(&twice.traction) {
        assert!((a - b).abs() < 1e-8 * largest);
    }
    // unlike bodies: friction changes the pressure, and the force stays
    assert!((force(once.pressure()) / load - 1.0).abs() < 1e-10);
    let change = once
        .pressure()
        .iter()
        .zip(&pressure)
        .map(|(a, b)| (a - b).abs());
    assert!(change.fold(0.0_f64, f64::max) > 1e-3 * largest);
}

#[test]
fn a_push_is_broken_off_at_any_look() {
    let pair = Relative::new(Some(half_space(0.2)), None).unwrap();
    let (pressure, motion) = frictionless(&pair, 40.0);
    let contact = coupled(&pair, &[pressed(40.0)]);
    let rest = contact.at_rest(&pressure, &motion).unwrap();
    let looks = Cell::new(0);
    let count = |_: Progress| {
        looks.set(looks.get() + 1);
        ControlFlow::Continue(())
    };
    let push = along_x(0.4e-6);
    let reached = contact.advance(&rest, &push, 1, &count).unwrap().unwrap();
    assert!(looks.get() >= reached.iterations && reached.iterations > 1);
    for last in 0..looks.get() {
        let left = Cell::new(last);
        let stop = |_: Progress| match left.get() {
            0 => ControlFlow::Break(()),
            more => {
                left.set(more - 1);
                ControlFlow::Continue(())
            }
        };
        assert_eq!(
            contact.advance(&rest, &push, 1, &stop),
            Err(Error::Interrupted)
        );
    }
    let stop = |_: Progress| ControlFlow::Break(());
    let all = Coupled {
        compliance: &pair,
        layer: 0.0,
        area: &[1.0; N],
        friction: &[MU; N],
        gap: &[0.0; N],
        motions: &[],
    };
    let made = CoupledContact::new(&all, 1e-8, &stop);
    assert_eq!(made.err(), Some(Error::Interrupted));
}

#[test]
fn bad_input_is_named() {
    let pair = Relative::new(Some(half_space(0.2)), None).unwrap();
    let (area, friction, gap) = ([1.0; N], [MU; N], [0.0; N]);
    let good = Coupled {
        compliance: &pair,
        layer: 0.0,
        area: &area,
        friction: &friction,
        gap: &gap,
        motions: &[],
    };
    let made = |contact: &Coupled<'_>| {
        CoupledContact::new(contact, 1e-8, &unmonitored)
            .err()
            .map(|e| e.to_string())
    };
    let short = made(&Coupled {
        area: &area[1..],
        ..good
    });
    assert_eq!(short.unwrap(), "area has 323 entries, expected 324");
    let negative = made(&Coupled {
        layer: -1.0,
        ..good
    });
    assert_eq!(negative.unwrap(), "layer[0] is -1, it must not be negative");
    let none = made(&Coupled {
        area: &[0.0; N],
        ..good
    });
    assert_eq!(none.unwrap(), "area[0] is 0, it must be positive");
    let tolerance = CoupledContact::new(&good, 0.0, &unmonitored).err().unwrap();
    assert!(tolerance.to_string().starts_with("tolerance is 0"));
    let contact = CoupledContact::new(&good, 1e-8, &unmonitored).unwrap();
    let rest = contact.at_rest(&[0.0; N], &[]).unwrap();
    let mut push = vec![0.0; 3 * N];
    push[7] = f64::NAN;
    let refused = contact.advance(&rest, &push, 1, &unmonitored).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "push[7] is NaN, a finite number is needed"
    );
}

/// Springs without influence on each other [m/Pa].
struct Springs(f64);

impl Compliance for Springs {
    fn points(&self) -> usize {
        3
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        if observed == loaded {
            for (u, q) in displacement.iter_mut().zip(traction) {
                *u += scale * self.0 * q;
            }
        }
    }
}

#[test]
fn springs_under_a_held_pressure_stick_until_friction_gives_way() {
    // a layer softens them; the first point bears 2 Pa, the second one is out of contact, the third has no friction
    let held = Held {
        compliance: &Springs(1.5e-6),
        layer: 0.5e-6,
        area: &[1.0; 3],
        friction: &[0.2, 0.2, 0.0],
        pressure: &[10.0, 0.0, 10.0],
    };
    let pushes = [[2e-6, 0.0], [5e-6, 0.0], [4e-6, 0.0]];
    let states = held.follow(&pushes, 1e-10, &unmonitored).unwrap();
    assert_eq!(states.len(), 3);
    for (state, (traction, first)) in states.iter().zip([
        (1.0, PointState::Stick),
        (2.0, PointState::Slip),
        // turned back by 1e-6 m
        (1.5, PointState::Stick),
    ]) {
        assert!((state.traction[0] - traction).abs() < 1e-9, "{state:?}");
        assert_eq!(state.traction[1..], [0.0; 5]);
        assert_eq!(state.points, [first, PointState::Open, PointState::Slip]);
        assert!(state.path_error <= 3.0 * PATH_TOLERANCE);
    }
}

/// Steps by an inverse that is kept are those of the whole system, to the tolerance, also where points come into contact
/// that it does not know; to and fro, and round a circle that turns the slip of so many points that they share factors.
/// In mirrors as well, which the first contact is its own image in and the second one is not.
#[test]
fn steps_by_an_inverse_are_those_of_the_whole_system() {
    let place = |i: usize| (i as f64 - 0.5 * (SIDE - 1) as f64) * CELL;
    let mut points: Vec<f64> = (0..N).map(|k| place(k % SIDE)).collect();
    points.extend((0..N).map(|k| place(k / SIDE)));
    points.resize(3 * N, 0.0);
    let kinds: [&dyn Fn() -> KeptInverse; 2] =
        [&KeptInverse::default, &|| KeptInverse::at(&points)];
    for kept in kinds {
        let to_and_fro = |k: f64| [1e-6 * (0.7 * k).sin(), 0.0];
        assert!(most_that_slip(0.0, 0.0, kept(), to_and_fro) > 0);
        let round = |k: f64| [2e-6 * (0.5 * k).sin(), 2e-6 * (1.0 - (0.5 * k).cos())];
        assert!(2 * most_that_slip(0.3, 0.0, kept(), round) > 100);
        assert!(2 * most_that_slip(0.3, 3e-4, kept(), round) > 100);
    }
}

/// How many points slip in any step whose points neither all slip nor all stick, after each of them was compared; of a
/// ball whose middle is `aside` [m] along x.
fn most_that_slip(
    poisson_ratio: f64,
    aside: f64,
    mut kept: KeptInverse,
    aim: impl Fn(f64) -> [f64; 2],
) -> usize {
    let pair = Relative::new(Some(half_space(poisson_ratio)), None).unwrap();
    let mut most = 0;
    let matrix = Arc::new(CoupledMatrix::new(&pair, 0.0, &unmonitored).unwrap());
    let (pressure, motion) = frictionless(&pair, 1000.0);
    let mut by_inverse: Option<CoupledState> = None;
    for k in 0..12 {
        // more load from step to step, and less again
        let load = 1000.0 + 100.0 * f64::from(4 - (k - 6_i32).abs());
        let mut gap = gap();
        for (i, gap) in gap.iter_mut().enumerate() {
            *gap -= 2.0 * aside * (i % SIDE) as f64 * CELL / 0.1;
        }
        let motions = [pressed(load)];
        let load = CoupledLoad {
            area: &[CELL * CELL; N],
            friction: &[MU; N],
            gap: &gap,
            motions: &motions,
            diagonal: None,
        };
        let contact = CoupledContact::of(matrix.clone(), &load, 1e-11).unwrap();
        let from = by_inverse.unwrap_or_else(|| contact.at_rest(&pressure, &motion).unwrap());
        let [x, y] = aim(f64::from(k));
        let mut aim = along_x(x);
        aim[N..2 * N].fill(y);
        let whole = contact
            .advance(&from, &aim, 1, &unmonitored)
            .unwrap()
            .unwrap();
        let found = contact
            .step(&from, &aim, &mut kept, &unmonitored)
            .unwrap()
            .unwrap();
        let largest = whole.pressure().iter().fold(0.0_f64, |m, p| m.max(*p));
        for (a, b) in found.traction.iter().zip(&whole.traction) {
            assert!((a - b).abs() < 1e-9 * largest, "step {k}");
        }
        assert_eq!(found.points, whole.points);
        if found.points.contains(&PointState::Stick) {
            let slips = |point: &&PointState| **point == PointState::Slip;
            most = most.max(found.points.iter().filter(slips).count());
        }
        by_inverse = Some(found);
    }
    most
}

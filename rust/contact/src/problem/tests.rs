// SPDX-License-Identifier: MIT OR Apache-2.0
use std::f64::consts::PI;

use mtb_elasticity::Material;
use mtb_elasticity::half_space::HalfSpace;
use mtb_operator::{Component, Grid, unmonitored};

use super::*;
use crate::coupled::PointState;

const SIDE: usize = 16;
const N: usize = SIDE * SIDE;
const CELL: f64 = 1e-4;
const RADIUS: f64 = 0.05;

fn place(i: usize) -> [f64; 2] {
    [i % SIDE, i / SIDE].map(|k| (k as f64 - 0.5 * (SIDE - 1) as f64) * CELL)
}

/// A ball above a plane that is turned about y by an angle: nothing but the frames knows.
fn geometry(turn: f64) -> Geometry {
    let (s, c) = turn.sin_cos();
    let unit = |v: [f64; 3]| -> Vec<f64> { (0..3 * N).map(|k| v[k / N]).collect() };
    let (x, y, z) = (unit([c, 0.0, -s]), unit([0.0, 1.0, 0.0]), unit([s, 0.0, c]));
    let points = (0..3 * N)
        .map(|k| {
            let [u, v] = place(k % N);
            [c * u, v, -s * u][k / N]
        })
        .collect();
    Geometry {
        points,
        normal: z.clone(),
        tangent_x: x.clone(),
        tangent_y: y.clone(),
        area: vec![CELL * CELL; N],
        mean_frame: [x, y, z],
        means: None,
        windows: Vec::new(),
    }
}

fn gap() -> Vec<f64> {
    (0..N)
        .map(|i| place(i).map(|v| v * v / (2.0 * RADIUS)).iter().sum())
        .collect()
}

fn half_space(poisson_ratio: f64) -> Arc<dyn Compliance> {
    let material = Material::new(80e9, poisson_ratio).unwrap();
    Arc::new(HalfSpace::new(material, Grid::new(SIDE, SIDE, CELL, CELL).unwrap()).unwrap())
}

/// A unit along the common z, of all points.
fn rise() -> Vec<f64> {
    (0..3 * N)
        .map(|k| f64::from(u8::from(k >= 2 * N)))
        .collect()
}

/// The upper body free along the common z.
fn problem(turn: f64, upper: Option<Arc<dyn Compliance>>) -> Problem {
    let g = geometry(turn);
    let descent = FreeMotion::of(&g, Body::Upper, &rise()).unwrap();
    let pair = Relative::new(Some(half_space(0.3)), upper).unwrap();
    Problem::new(pair, Arc::new(g), vec![descent]).unwrap()
}

fn pressed_by(problem: &Problem, load: Load<'_>) -> Loading {
    let mut loading = problem.unloaded(gap());
    problem.load(&mut loading, load).unwrap();
    loading
}

#[test]
fn a_force_follows_hertz_and_its_approach_asks_it_back() {
    let problem = problem(0.0, Some(half_space(0.3)));
    let load = 600.0;
    let found = problem
        .press(&pressed_by(&problem, Load::Force(load)), &unmonitored)
        .unwrap();
    assert_eq!(found.unsolved(), None);
    // [Johnson1985, section 4.2]
    let modulus = 80e9 / (1.0 - 0.3);
    let radius = (0.75 * load * RADIUS / modulus).cbrt();
    let approach = -found.solution.motion[0];
    assert!((approach / (radius * radius / RADIUS) - 1.0).abs() < 0.02);
    let peak = found
        .solution
        .pressure
        .iter()
        .fold(0.0_f64, |m, p| m.max(*p));
    assert!((peak / (1.5 * load / (PI * radius * radius)) - 1.0).abs() < 0.05);
    assert!((found.force[2] / load + 1.0).abs() < 1e-12);
    assert!(found.moment.iter().all(|m| m.abs() < 1e-9 * load * CELL));

    // held at this height the bodies carry the same force
    let held = Problem::new(
        problem.pair().clone(),
        problem.geometry().clone(),
        Vec::new(),
    )
    .unwrap();
    let loading = pressed_by(&held, Load::Approach(approach));
    let back = held.press(&loading, &unmonitored).unwrap();
    assert!((back.force[2] / load + 1.0).abs() < 1e-10);
    let mut nothing = held.unloaded(gap());
    assert_eq!(held.load(&mut nothing, Load::Force(load)), Err(Error::Held));
}

#[test]
fn a_turned_contact_slides_with_the_friction_that_its_force_asks_for() {
    let (turn, mu, load) = (0.3, 0.2, 600.0);
    let problem = problem(turn, None);
    let loading = pressed_by(&problem, Load::Force(load));
    let direction = problem.geometry().sliding_direction([2.0, 0.0]).unwrap();
    let friction = vec![mu; N];
    let found = problem
        .slide(
            &loading,
            &direction,
            Friction::Field(&friction),
            None,
            &unmonitored,
        )
        .unwrap();
    assert_eq!(found.unsolved(), None);
    // P along the normal and mu P along the tangent together carry the force along z
    let pressure: f64 = found.solution.pressure.iter().sum::<f64>() * CELL * CELL;
    assert!((pressure * (turn.cos() + mu * turn.sin()) / load - 1.0).abs() < 1e-10);
    assert!((found.force[2] / load + 1.0).abs() < 1e-10);
    let along = found.force[0] * turn.cos() - found.force[2] * turn.sin();
    assert!((along / (mu * pressure) - 1.0).abs() < 1e-10);
    // a law that gives the same coefficient at every pressure changes nothing, one that falls does
    let same = |pressure: &[f64]| Ok(vec![mu; pressure.len()]);
    let by_law = problem
        .slide(
            &loading,
            &direction,
            Friction::OfPressure(&same),
            None,
            &unmonitored,
        )
        .unwrap();
    assert_eq!(by_law.solution.pressure, found.solution.pressure);
    let law = |pressure: &[f64]| Ok(pressure.iter().map(|p| mu / (1.0 + p / 1e9)).collect());
    let fallen = problem
        .slide(
            &loading,
            &direction,
            Friction::OfPressure(&law),
            Some(found.in_contact()),
            &unmonitored,
        )
        .unwrap();
    for (i, p) in fallen.solution.pressure.iter().enumerate() {
        assert!((fallen.friction[i] - mu / (1.0 + p / 1e9)).abs() < 1e-9);
        assert!((fallen.traction[i] - fallen.friction[i] * p).abs() <= 1e-9 * p);
    }
    assert!((fallen.force[2] / load + 1.0).abs() < 1e-9);
}

/// A pull on a body is a pressure of the opposite sign: what it takes from the contact, it gives to the work.
#[test]
fn a_pull_presses_as_the_force_it_adds_up_to() {
    let problem = problem(0.0, None);
    let pull: Vec<f64> = (0..N).map(|i| 1e6 * (10.0 + place(i)[0] / CELL)).collect();
    let total: f64 = pull.iter().sum::<f64>() * CELL * CELL;
    let by_force = pressed_by(&problem, Load::Force(total));
    let by_upper = pressed_by(&problem, Load::Pull(&pull, Body::Upper));
    // the upper body is rigid: its surface stays
    assert_eq!(by_upper.gap, by_force.gap);
    assert!((by_upper.work[0] / by_force.work[0] - 1.0).abs() < 1e-12);
    // the lower one rises under what pulls it, and no motion of it is free
    let by_lower = pressed_by(&problem, Load::Pull(&pull, Body::Lower));
    assert_eq!(by_lower.work, [0.0]);
    let mut risen = gap();
    problem.pair().add_displacement(
        Component::Normal,
        Component::Normal,
        -1.0,
        &pull,
        &mut risen,
    );
    assert_eq!(by_lower.gap, risen);
    assert!(risen.iter().zip(gap()).all(|(a, b)| *a < b));
    let nan = vec![f64::NAN; N];
    let mut loading = problem.unloaded(gap());
    let refused = problem.load(&mut loading, Load::Pull(&nan, Body::Lower));
    assert!(
        refused
            .unwrap_err()
            .to_string()
            .starts_with("pull[0] is NaN")
    );
}

#[test]
fn a_pull_that_counts_as_a_whole_moves_no_surface() {
    let mut tilt = FreeMotion::of(&geometry(0.0), Body::Upper, &rise()).unwrap();
    for i in 0..N {
        tilt.motion.opening[i] = place(i)[0];
    }
    tilt.is_pulled = false;
    let both = problem(0.0, Some(half_space(0.3)));
    let motions = [both.motions(), &[tilt]].concat();
    let both = Problem::new(both.pair().clone(), both.geometry().clone(), motions).unwrap();
    let pull: Vec<f64> = (0..N).map(|i| 1e6 * (10.0 + place(i)[0] / CELL)).collect();
    let total: f64 = pull.iter().sum::<f64>() * CELL * CELL;
    for at_face in [true, false] {
        let attracted = Attracted {
            body: Body::Upper,
            at_face,
        };
        let loading = pressed_by(&both, attracted.by(&pull));
        assert!((loading.work[0] / total + 1.0).abs() < 1e-12);
        // the moment on the tilt is given as a whole
        assert_eq!(loading.work[1], 0.0);
        assert_eq!(loading.gap != gap(), at_face);
    }
}

#[test]
fn a_displacement_of_the_upper_body_is_an_approach() {
    let turned = problem(0.3, Some(half_space(0.2)));
    let held = Problem::new(turned.pair().clone(), turned.geometry().clone(), Vec::new()).unwrap();
    let down: Vec<f64> = rise().iter().map(|u| -2e-7 * u).collect();
    let up: Vec<f64> = rise().iter().map(|u| 2e-7 * u).collect();
    let approached = pressed_by(&held, Load::Approach(2e-7)).gap;
    for (displacement, body) in [(&down, Body::Upper), (&up, Body::Lower)] {
        let moved = pressed_by(&held, Load::Displacement(displacement, body)).gap;
        for (a, b) in moved.iter().zip(&approached) {
            assert!((a - b).abs() < 1e-12 * 2e-7, "{a} {b}");
        }
    }
}

/// The surfaces meet where they press on each other, and friction works on both of them.
#[test]
fn displacements_of_both_bodies_close_the_gap() {
    let turned = problem(0.3, Some(half_space(0.1)));
    let mut loading = pressed_by(&turned, Load::Force(600.0));
    let pull: Vec<f64> = (0..N).map(|i| 1e6 * (4.0 + place(i)[0] / CELL)).collect();
    turned
        .load(&mut loading, Load::Pull(&pull, Body::Lower))
        .unwrap();
    let direction = turned.geometry().sliding_direction([1.0, 0.5]).unwrap();
    let friction = Friction::Field(&[0.3; N]);
    let found = turned
        .slide(&loading, &direction, friction, None, &unmonitored)
        .unwrap();
    let traction = [&*found.traction, &found.solution.pressure].concat();
    let upper = turned.displacement(Body::Upper, &traction, None).unwrap();
    let lower = turned
        .displacement(Body::Lower, &traction, Some(&pull))
        .unwrap();
    let g = turned.geometry();
    let lift = found.solution.motion[0];
    let size = lift.abs();
    for (i, gap) in gap().iter().enumerate() {
        let [u, v, normal] = [&upper, &lower, &g.normal].map(|field| Geometry::vector(field, i));
        let apart: f64 = (0..3).map(|c| (u[c] - v[c]) * normal[c]).sum();
        let left = gap + apart + lift * normal[2];
        assert!((left - found.solution.gap[i]).abs() < 1e-9 * size, "{left}");
    }
    // friction alone does work on both: what it drags follows it
    let alone = [&*found.traction, &vec![0.0; N]].concat();
    for (body, sign) in [(Body::Lower, 1.0), (Body::Upper, -1.0)] {
        let moved = turned.displacement(body, &alone, None).unwrap();
        let work: f64 = (0..N)
            .map(|i| {
                let u = Geometry::vector(&moved, i);
                let [x, y] = [&g.tangent_x, &g.tangent_y].map(|t| {
                    let t = Geometry::vector(t, i);
                    u[0] * t[0] + u[1] * t[1] + u[2] * t[2]
                });
                sign * (found.traction[i] * x + found.traction[N + i] * y)
            })
            .sum();
        assert!(work > 0.0);
    }
}

#[test]
fn a_push_ends_in_the_sliding_that_is_asked_for_at_once() {
    let problem = problem(0.1, None);
    let (mu, load) = (0.2, 600.0);
    let loading = pressed_by(&problem, Load::Force(load));
    let friction = vec![mu; N];
    let steps = [2e-7, 6e-7, 3e-6].map(|x| problem.geometry().uniform([x, 0.0, 0.0]));
    let found = problem
        .stick_or_slip(&loading, &friction, 0.0, &steps, 1e-10, &unmonitored)
        .unwrap();
    assert_eq!(found.len(), 3);
    assert!(found.iter().all(|o| o.unsolved().is_none()));
    let stick = |o: &Outcome| o.points.iter().filter(|p| **p == PointState::Stick).count();
    assert!(stick(&found[0]) > stick(&found[1]) && stick(&found[1]) > 0);
    assert_eq!(stick(&found[2]), 0);
    assert!(found[0].force[0] < found[1].force[0] && found[1].force[0] < found[2].force[0]);
    let direction = problem.geometry().sliding_direction([1.0, 0.0]).unwrap();
    let slid = problem
        .slide(
            &loading,
            &direction,
            Friction::Field(&friction),
            None,
            &unmonitored,
        )
        .unwrap();
    let last = &found[2];
    let largest = slid
        .solution
        .pressure
        .iter()
        .fold(0.0_f64, |m, p| m.max(*p));
    for i in 0..N {
        // with unlike bodies tractions turn a little while they slip
        let difference = last.solution.pressure[i] - slid.solution.pressure[i];
        assert!(difference.abs() < 2e-2 * largest, "{i}");
    }
    for c in 0..3 {
        assert!((last.force[c] - slid.force[c]).abs() < 1e-3 * load, "{c}");
        // no gap where there is pressure, and none negative
        let gaps = &last.solution.gap;
        assert!(gaps.iter().all(|g| *g > -1e-12));
    }
}

#[test]
fn means_keep_the_force_of_each_component() {
    let mut g = geometry(0.0);
    // each cell shares a fifth with its neighbour, in pairs
    let (mut start, mut column, mut share) = (vec![0], Vec::new(), Vec::new());
    for i in 0..N {
        let next = i ^ 1;
        column.extend([i, next]);
        share.extend([0.8, 0.2]);
        start.push(column.len());
    }
    g.means = Some(Means {
        start,
        column,
        share,
    });
    g.check().unwrap();
    let closed = |i: usize| !i.is_multiple_of(3);
    let field = |scale: f64| {
        (0..N).map(move |i| {
            if closed(i) {
                scale * (1.0 + i as f64)
            } else {
                0.0
            }
        })
    };
    let unknowns: Vec<f64> = field(0.3).chain(field(-0.1)).chain(field(1.0)).collect();
    let mean = g.mean_tractions(&unknowns);
    for c in 0..3 {
        let sum = |values: &[f64]| values[c * N..(c + 1) * N].iter().sum::<f64>();
        assert!((sum(&mean) / sum(&unknowns) - 1.0).abs() < 1e-12);
        assert!((0..N).all(|i| closed(i) || mean[c * N + i] == 0.0));
    }
    assert_eq!(g.mean_tractions(&unknowns[2 * N..]), mean[2 * N..]);
    g.means.as_mut().unwrap().column[0] = N;
    assert!(g.check().is_err());
}

#[test]
fn parts_must_belong_together() {
    let fit = problem(0.0, None);
    let mut short = geometry(0.0);
    short.normal.pop();
    let pair = || Relative::new(Some(half_space(0.3)), None).unwrap();
    assert!(matches!(
        Problem::new(pair(), Arc::new(short), Vec::new()).err(),
        Some(Error::Shape { name: "normal", .. })
    ));
    let loading = Loading {
        gap: gap(),
        work: Vec::new(),
        along: vec![0.0; 2 * N],
        diagonal: None,
    };
    assert!(matches!(
        fit.press(&loading, &unmonitored).err(),
        Some(Error::Shape { name: "work", .. })
    ));
    let still = geometry(0.0).sliding_direction([0.0, 0.0]).unwrap();
    assert_eq!(still, [0.0; 2 * N]);
    let wall = geometry(0.5 * PI).sliding_direction([1.0, 0.0]);
    assert_eq!(wall.err(), Some(Error::Normal { index: 0 }));
}

/// Responses and openings that a body with a smooth memory of heat may have, row-major.
fn spread(scale: f64, width: f64) -> Vec<f64> {
    (0..N * N)
        .map(|k| {
            let ([x, y], [u, v]) = (place(k / N), place(k % N));
            scale * (-(x - u).hypot(y - v) / (width * CELL)).exp()
        })
        .collect()
}

#[test]
fn a_heated_state_slides_on_the_gap_that_its_own_heat_opens() {
    let problem = problem(0.0, Some(half_space(0.2)));
    let loading = pressed_by(&problem, Load::Force(600.0));
    let direction = problem.geometry().sliding_direction([1.0, 0.0]).unwrap();
    let friction = vec![0.2; N];
    let (lower, upper) = (spread(1e-6, 1.0), spread(4e-6, 2.0));
    let (falls, rises) = (spread(-2e-15, 2.0), spread(-1.2e-14, 3.0));
    let (cold, warm) = (vec![20.0; N], vec![35.0; N]);
    let heating = Heating {
        response: [&lower, &upper],
        opening: Some([&falls, &rises]),
        before: [&cold, &warm],
        speed: &[2.0; N],
        resistance: 3e-7,
        share: 0.4,
    };
    let slide = |heating: &Heating<'_>| {
        problem
            .slide_heated(&loading, &direction, &friction, heating, None, &unmonitored)
            .unwrap()
    };
    let found = slide(&heating);
    assert_eq!(found.outcome.unsolved(), None);
    let pressure = &found.outcome.solution.pressure;
    // the same heat, known beforehand
    let mut opened = loading.clone();
    for (k, opening) in [&falls, &rises].into_iter().enumerate() {
        for (gap, row) in opened.gap.iter_mut().zip(opening.chunks_exact(N)) {
            *gap += row
                .iter()
                .zip(&found.flux[k])
                .map(|(o, q)| o * q)
                .sum::<f64>();
        }
    }
    let again = problem
        .slide(
            &opened,
            &direction,
            Friction::Field(&friction),
            None,
            &unmonitored,
        )
        .unwrap();
    let peak = pressure.iter().copied().fold(0.0, f64::max);
    for (a, b) in pressure.iter().zip(&again.solution.pressure) {
        assert!((a - b).abs() < 1e-8 * peak, "{a} {b}");
    }
    // heat is that of friction, and passes the resistance by the difference of temperatures
    for i in 0..N {
        let [below, above] = [found.flux[0][i], found.flux[1][i]];
        let power = 0.2 * pressure[i] * 2.0;
        assert!((below + above - power).abs() < 1e-9 * peak);
        if pressure[i] > 0.0 {
            let jump = found.temperature[1][i] - found.temperature[0][i];
            assert!((jump - 3e-7 * (0.4 * power - above)).abs() < 1e-8 * (1.0 + jump.abs()));
        }
    }
    // it matters, and without openings pressures are those of cold bodies
    let unheated = problem
        .slide(
            &loading,
            &direction,
            Friction::Field(&friction),
            None,
            &unmonitored,
        )
        .unwrap();
    let differs = |a: &[f64], b: &[f64]| {
        a.iter()
            .zip(b)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max)
            / peak
    };
    assert!(differs(pressure, &unheated.solution.pressure) > 1e-2);
    let apart = slide(&Heating {
        opening: None,
        ..heating
    });
    assert!(
        differs(
            &apart.outcome.solution.pressure,
            &unheated.solution.pressure
        ) < 1e-10
    );
    // bad input
    let bad = Heating {
        share: 2.0,
        ..heating
    };
    assert!(
        problem
            .slide_heated(&loading, &direction, &friction, &bad, None, &unmonitored)
            .is_err()
    );
}

#[test]
fn what_a_step_keeps_of_its_exchange_of_heat_is_no_other_ones() {
    let (lower, upper) = (spread(1e-6, 1.0), spread(4e-6, 2.0));
    let (falls, rises) = (spread(-2e-15, 2.0), spread(-1.2e-14, 3.0));
    let (other, stronger) = (spread(2e-6, 1.5), spread(-1.5e-14, 3.0));
    let (cold, warm, warmer) = (vec![20.0; N], vec![35.0; N], vec![50.0; N]);
    let first = Heating {
        response: [&lower, &upper],
        opening: Some([&falls, &rises]),
        before: [&cold, &warm],
        speed: &[2.0; N],
        resistance: 3e-7,
        share: 0.4,
    };
    let each = [
        first,
        first,
        Heating {
            before: [&cold, &warmer],
            ..first
        },
        Heating {
            response: [&other, &upper],
            ..first
        },
        Heating {
            response: [&lower, &other],
            ..first
        },
        Heating {
            opening: Some([&falls, &stronger]),
            ..first
        },
        Heating {
            opening: Some([&stronger, &rises]),
            ..first
        },
        Heating {
            opening: None,
            ..first
        },
        Heating {
            resistance: 1e-6,
            ..first
        },
        Heating {
            share: 0.9,
            ..first
        },
        first,
    ];
    let direction = problem(0.0, None)
        .geometry()
        .sliding_direction([1.0, 0.0])
        .unwrap();
    let slide = |problem: &Problem, heating: &Heating<'_>| {
        let loading = pressed_by(problem, Load::Force(600.0));
        problem
            .slide_heated(&loading, &direction, &[0.2; N], heating, None, &unmonitored)
            .unwrap()
    };
    let kept = problem(0.0, Some(half_space(0.2)));
    let mut last: Option<Vec<f64>> = None;
    for (k, heating) in each.iter().enumerate() {
        let found = slide(&kept, heating);
        let known = slide(&problem(0.0, Some(half_space(0.2))), heating);
        let pressure = &found.outcome.solution.pressure;
        assert_eq!(pressure, &known.outcome.solution.pressure, "{k}");
        assert_eq!(found.flux, known.flux, "{k}");
        assert_eq!(found.temperature, known.temperature, "{k}");
        if let Some(last) = last.replace(found.flux[1].clone()) {
            assert_eq!(last == found.flux[1], k == 1, "{k}");
        }
    }
}

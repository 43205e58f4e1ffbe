// SPDX-License-Identifier: MIT OR Apache-2.0
//! Steps from memory equal solves without one.

use std::sync::Arc;

use mtb_complementarity::linear::Status;
use mtb_contact::Error;
use mtb_contact::sliding::{RigidMotion, SlidingContact, SlidingMatrix, SlidingSolution};
use mtb_contact::stepping::{Effort, Influence, SlidingStepper};
use mtb_operator::{Compliance, Component, unmonitored};
use proptest::prelude::*;

const SIDE: usize = 7;
const N: usize = SIDE * SIDE;

/// A smooth compliance on a grid whose tangential tractions tilt the gap along them.
struct Plate {
    coupling: f64,
}

fn place(i: usize) -> (f64, f64) {
    ((i % SIDE) as f64, (i / SIDE) as f64)
}

impl Compliance for Plate {
    fn points(&self) -> usize {
        N
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        assert_eq!(observed, Component::Normal, "only the gap is asked for");
        for i in 0..N {
            let (xi, yi) = place(i);
            for j in 0..N {
                let (xj, yj) = place(j);
                let r = (xi - xj).hypot(yi - yj) + 0.3;
                displacement[i] += scale
                    * traction[j]
                    * match loaded {
                        Component::Normal => 1.0 / r,
                        Component::X => self.coupling * (xi - xj) / (r * r),
                        Component::Y => self.coupling * (yi - yj) / (r * r),
                    };
            }
        }
    }
}

/// Approach and two tilts about the middle.
fn motions(work: [f64; 3]) -> Vec<RigidMotion> {
    let middle = 0.5 * (SIDE - 1) as f64;
    let column = |f: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        (0..N)
            .map(|i| f(place(i).0 - middle, place(i).1 - middle))
            .collect()
    };
    [
        (column(&|_, _| 0.0), column(&|_, _| 1.0)),
        (column(&|_, _| 0.4), column(&|x, _| x)),
        (column(&|_, _| 0.0), column(&|_, y| y)),
    ]
    .into_iter()
    .zip(work)
    .map(|((tangential_x, opening), work)| RigidMotion {
        tangential_x,
        tangential_y: vec![0.0; N],
        opening,
        work,
    })
    .collect()
}

fn crowned(height: f64, slope: f64) -> Vec<f64> {
    let middle = 0.5 * (SIDE - 1) as f64;
    (0..N)
        .map(|i| {
            let (x, y) = place(i);
            height * ((x - middle).powi(2) + 0.3 * (y - middle).powi(2)) + slope * (x - middle)
        })
        .collect()
}

fn compare(step: &SlidingSolution, cold: &SlidingSolution) -> Result<(), TestCaseError> {
    prop_assert_eq!(step.status, cold.status);
    if cold.status != Status::Solved {
        return Ok(());
    }
    prop_assert!(step.residual < 1e-11, "{}", step.residual);
    let largest = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    for (name, a, b) in [
        ("pressure", &step.pressure, &cold.pressure),
        ("gap", &step.gap, &cold.gap),
        ("motion", &step.motion, &cold.motion),
    ] {
        let size = largest(b);
        for (i, (a, b)) in a.iter().zip(b).enumerate() {
            prop_assert!((a - b).abs() <= 1e-9 * size, "{name} {i}: {a} {b}");
        }
    }
    Ok(())
}

struct Walk {
    friction: f64,
    reversed: bool,
    uneven: bool,
    crown: f64,
    slope: f64,
    work: [f64; 3],
    free: usize,
    diagonal: f64,
}

fn run(plate: &Plate, walk: &[Walk]) -> Result<Vec<Effort>, TestCaseError> {
    let mut stepper = SlidingStepper::new(Arc::new(Influence::of(plate, &unmonitored).unwrap()));
    let area: Vec<f64> = (0..N).map(|i| 1.0 + 0.1 * (i % 3) as f64).collect();
    let mut efforts = Vec::new();
    for w in walk {
        let gap = crowned(w.crown, w.slope);
        let gap: Vec<f64> = gap
            .iter()
            .map(|g| g - if w.free == 0 { 1.0 } else { 0.0 })
            .collect();
        let sign = if w.reversed { -1.0 } else { 1.0 };
        let (c, s) = (0.8 * sign, 0.6 * sign);
        let direction: Vec<f64> = [vec![c; N], vec![s; N]].concat();
        let friction: Vec<f64> = (0..N)
            .map(|i| {
                w.friction
                    * if w.uneven {
                        1.0 + 0.2 * (i as f64).sin()
                    } else {
                        1.0
                    }
            })
            .collect();
        let motions = motions(w.work);
        let diagonal: Vec<f64> = (0..N)
            .map(|i| w.diagonal * (1.0 + 0.3 * (i as f64).cos()))
            .collect();
        let contact = SlidingContact {
            gap: &gap,
            area: &area,
            friction: &friction,
            direction: &direction,
            motions: &motions[..w.free],
            diagonal: (w.diagonal != 0.0).then_some(&diagonal),
            interface: None,
        };
        let cold = SlidingMatrix::new(plate, &direction, true, &unmonitored)
            .unwrap()
            .solve(&contact, None, &unmonitored)
            .unwrap();
        let (step, effort) = stepper.solve(&contact, &unmonitored).unwrap();
        compare(&step, &cold)?;
        efforts.push(effort);
    }
    Ok(efforts)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn any_sequence_equals_solves_without_memory(
        coupling in 0.0..0.3_f64,
        walk in prop::collection::vec(
            (0.0..0.5_f64, any::<bool>(), any::<bool>(), 0.0..0.2_f64, -0.1..0.1_f64,
             (-60.0..-5.0_f64, -0.8..0.8_f64, -0.8..0.8_f64), 0_usize..4,
             prop_oneof![Just(0.0), -0.1..0.0_f64, 0.0..5.0_f64]),
            1..12,
        ),
    ) {
        let walk: Vec<Walk> = walk
            .into_iter()
            .map(|(friction, reversed, uneven, crown, slope, (force, mx, my), free, diagonal)| Walk {
                friction, reversed, uneven, crown, slope, work: [force, force * mx, force * my], free,
                diagonal,
            })
            .collect();
        run(&Plate { coupling }, &walk)?;
    }
}

/// A slow walk: friction and load change a little every step.
fn slow(steps: usize) -> Vec<Walk> {
    (0..steps)
        .map(|k| {
            let t = k as f64 / steps as f64;
            Walk {
                friction: 0.1 + 0.3 * t,
                reversed: false,
                uneven: true,
                crown: 0.05,
                slope: 0.02 * t,
                work: [-40.0 - 5.0 * t, 2.0 * t, 0.0],
                free: 3,
                diagonal: 0.0,
            }
        })
        .collect()
}

#[test]
fn a_slow_change_hardly_factorises() {
    let efforts = run(&Plate { coupling: 0.2 }, &slow(200)).unwrap();
    let factorisations: usize = efforts.iter().map(|e| e.factorisations).sum();
    assert!(
        factorisations < 40,
        "{factorisations} factorisations in 200 steps"
    );
    assert!(efforts[1..].iter().all(|e| e.sets <= 4 && !e.fell_back));
}

#[test]
fn the_same_step_again_costs_a_product() {
    let walk: Vec<Walk> = (0..3).flat_map(|_| slow(1)).collect();
    let efforts = run(&Plate { coupling: 0.2 }, &walk).unwrap();
    assert_eq!(
        efforts[2],
        Effort {
            sets: 1,
            factorisations: 0,
            products: 1,
            fell_back: false
        }
    );
}

#[test]
fn far_open_points_cost_no_digits() {
    // a joint under a few points: what is far away is no scale of what touches
    let plate = Plate { coupling: 0.2 };
    let influence = Arc::new(Influence::of(&plate, &unmonitored).unwrap());
    let (area, direction) = (vec![1.0; N], [vec![1.0; N], vec![0.0; N]].concat());
    for joint in [1.0, 1e4, 1e8] {
        let mut gap = crowned(0.05, 0.0);
        for (i, gap) in gap.iter_mut().enumerate() {
            *gap += if place(i).0 > 4.5 { joint } else { 0.0 };
        }
        let motions = motions([-40.0, 0.0, 0.0]);
        let mut warm = SlidingStepper::new(Arc::clone(&influence));
        let step = |stepper: &mut SlidingStepper, friction: f64| {
            let contact = SlidingContact {
                gap: &gap,
                area: &area,
                friction: &[friction; N],
                direction: &direction,
                motions: &motions,
                diagonal: None,
                interface: None,
            };
            stepper.solve(&contact, &unmonitored).unwrap().0
        };
        step(&mut warm, 0.2);
        let found = step(&mut warm, 0.2003);
        let cold = step(&mut SlidingStepper::new(Arc::clone(&influence)), 0.2003);
        let most = cold.pressure.iter().fold(0.0_f64, |m, p| m.max(*p));
        let apart = found.pressure.iter().zip(&cold.pressure);
        let apart = apart.fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        assert!(apart < 1e-11 * most, "{joint}: {:.1e}", apart / most);
    }
}

#[test]
fn a_step_that_goes_on_begins_without_a_product() {
    // on one set: a solve, and the product with what it gave; before it a solve and a product for each step of GMRES,
    // and one of both where friction is not that of the factors
    let products = |friction_grows: f64| -> Vec<usize> {
        let mut walk = slow(60);
        for (k, step) in walk.iter_mut().enumerate() {
            step.friction = 0.2 + friction_grows * k as f64;
            // what grows evenly is foreseen
            step.work[0] -= 1e-3 * (k as f64).powi(2);
        }
        let efforts = run(&Plate { coupling: 0.2 }, &walk).unwrap();
        let on_one_set = efforts[4..].iter().filter(|e| e.sets == 1);
        on_one_set.map(|e| e.products).collect()
    };
    let constant = products(0.0);
    assert!(
        constant.len() > 20 && constant.iter().all(|p| *p == 2),
        "{constant:?}"
    );
    // new factors, and columns of points that come and go, are few
    let growing = products(1e-3);
    let even = growing.iter().filter(|p| *p % 2 == 0).count();
    assert!(
        growing.len() > 20 && 10 * even <= growing.len(),
        "{growing:?}"
    );
}

#[test]
fn reversals_hardly_factorise() {
    let mut walk = slow(200);
    for step in walk.iter_mut().skip(1).step_by(2) {
        step.reversed = true;
    }
    let efforts = run(&Plate { coupling: 0.2 }, &walk).unwrap();
    let factorisations: usize = efforts.iter().map(|e| e.factorisations).sum();
    assert!(
        factorisations < 40,
        "{factorisations} factorisations in 200 steps"
    );
}

#[test]
fn sets_that_go_round_in_circles_end_one_point_at_a_time() {
    // a P-matrix whose wrong signs, moved all at once, come back
    let rows = [[2.0, -1.0, 1.0], [-1.0, 1.0, 2.0], [3.0, -3.0, 2.0]];
    let gap = [3.0, -4.0, 3.0];
    let columns = (0..9).map(|k| rows[k % 3][k / 3]).collect();
    let influence = Influence::from_columns(3, columns, [None, None]).unwrap();
    let mut stepper = SlidingStepper::new(Arc::new(influence));
    let contact = SlidingContact {
        gap: &gap,
        area: &[1.0; 3],
        friction: &[0.0; 3],
        direction: &[0.0; 6],
        motions: &[],
        diagonal: None,
        interface: None,
    };
    let (found, effort) = stepper.solve(&contact, &unmonitored).unwrap();
    assert_eq!(found.status, Status::Solved);
    assert!(!effort.fell_back, "{effort:?}");
    for (row, initial) in rows.iter().zip(gap) {
        let gap: f64 = initial
            + row
                .iter()
                .zip(&found.pressure)
                .map(|(a, p)| a * p)
                .sum::<f64>();
        assert!(gap > -1e-12, "{found:?}");
    }
    for (p, g) in found.pressure.iter().zip(&found.gap) {
        assert!(*p >= 0.0 && *g >= 0.0 && p.min(*g) < 1e-12, "{found:?}");
    }
}

#[test]
fn sets_that_jump_need_no_new_factors() {
    let walk: Vec<Walk> = slow(60)
        .into_iter()
        .enumerate()
        .map(|(k, walk)| Walk {
            friction: 0.3,
            crown: [0.05, 1.0, 0.7][k % 3],
            slope: [0.0, 0.3, -0.3, 0.1][k % 4],
            ..walk
        })
        .collect();
    let efforts = run(&Plate { coupling: 0.2 }, &walk).unwrap();
    assert!(efforts.iter().any(|e| e.sets > 1), "no jumps");
    let factorisations: usize = efforts.iter().map(|e| e.factorisations).sum();
    assert!(factorisations <= 2, "{factorisations} factorisations");
}

/// Loads come again in another order, larger, and with a gap that free motions undo: their sets are known.
#[test]
fn loads_that_jump_start_from_a_step_like_them() {
    let load = |kind: usize, factor: f64| {
        let t = kind as f64;
        Walk {
            friction: 0.3,
            reversed: false,
            uneven: true,
            crown: factor * (4.0 + 3.5 * (3.0 * t).sin()),
            slope: 0.3 * (5.0 * t + 20.0 * factor).cos(),
            work: [-40.0, 60.0 * (7.0 * t).sin(), 50.0 * (11.0 * t).cos()].map(|w| factor * w),
            free: 3,
            diagonal: 0.0,
        }
    };
    let first = (0..12).map(|kind| load(kind, 1.0));
    let again = (0..36).map(|k| load(5 * k % 12, 1.0 + 0.01 * k as f64));
    let efforts = run(
        &Plate { coupling: 0.2 },
        &first.chain(again).collect::<Vec<_>>(),
    )
    .unwrap();
    let sets: Vec<usize> = efforts.iter().map(|e| e.sets).collect();
    let mean = |sets: &[usize]| sets.iter().sum::<usize>() as f64 / sets.len() as f64;
    assert!(mean(&sets[..12]) >= 3.0, "no jumps: {sets:?}");
    assert!(mean(&sets[12..]) <= 1.5, "{sets:?}");
}

#[test]
fn a_state_that_is_given_is_where_the_step_starts() {
    let plate = Plate { coupling: 0.2 };
    let mut stepper = SlidingStepper::new(Arc::new(Influence::of(&plate, &unmonitored).unwrap()));
    let motions = motions([-40.0, 0.0, 0.0]);
    let mut press = |slope: f64, from: Option<&SlidingSolution>| {
        let gap: Vec<f64> = (0..N)
            .map(|i| 4.0 * crowned(1.0, 0.0)[i] + slope * (place(i).0 - place(i).1))
            .collect();
        let contact = SlidingContact {
            gap: &gap,
            area: &[1.0; N],
            friction: &[0.2; N],
            direction: &[[1.0; N], [0.0; N]].concat(),
            motions: &motions[..1],
            diagonal: None,
            interface: None,
        };
        if let Some(state) = from {
            stepper.resume(&state.pressure, &state.motion).unwrap();
        }
        stepper.solve(&contact, &unmonitored).unwrap()
    };
    let slopes: Vec<f64> = (0..20)
        .map(|k| 2.0 * f64::from(7 * k % 20) / 20.0)
        .collect();
    let states: Vec<_> = slopes.iter().map(|s| press(*s, None).0).collect();
    for (slope, state) in slopes.iter().zip(&states) {
        press(2.0 - slope, None);
        let (_, effort) = press(*slope, Some(state));
        assert_eq!(effort.sets, 1);
    }
}

#[test]
fn a_diagonal_that_grows_hardly_factorises() {
    let walk: Vec<Walk> = slow(100)
        .into_iter()
        .enumerate()
        .map(|(k, walk)| Walk {
            friction: 0.3,
            diagonal: 1e-3 * k as f64,
            ..walk
        })
        .collect();
    let efforts = run(&Plate { coupling: 0.2 }, &walk).unwrap();
    let factorisations: usize = efforts.iter().map(|e| e.factorisations).sum();
    assert!(
        factorisations < 40,
        "{factorisations} factorisations in 100 steps"
    );
}

/// A spring with a pull that follows the gap: stiffer than the spring, it lets no point stay open.
#[test]
fn a_point_that_snaps_shut_is_refused() {
    let influence = Influence::from_columns(2, vec![2.0, 0.5, 0.5, 2.0], [None, None]).unwrap();
    let mut stepper = SlidingStepper::new(Arc::new(influence));
    let mut ask = |diagonal: [f64; 2]| {
        let contact = SlidingContact {
            gap: &[-1.0, -1.0],
            area: &[1.0; 2],
            friction: &[0.0; 2],
            direction: &[0.0; 4],
            motions: &[],
            diagonal: Some(&diagonal),
            interface: None,
        };
        stepper.solve(&contact, &unmonitored)
    };
    let (found, _) = ask([-1.0, -1.0]).unwrap();
    for p in found.pressure {
        assert!((p - 1.0 / 1.5).abs() < 1e-12, "{p}");
    }
    let refused = ask([0.0, -2.0]).unwrap_err();
    assert_eq!(
        refused,
        Error::SnapsShut {
            index: 1,
            diagonal: -2.0,
            compliance: 2.0
        }
    );
}

#[test]
fn a_set_that_lasts_gets_factors_of_its_own_between_steps() {
    // all points once, and then always the same few of them open
    let walk: Vec<Walk> = slow(20)
        .into_iter()
        .enumerate()
        .map(|(k, walk)| Walk {
            friction: 0.3,
            crown: if k == 0 { 0.5 } else { 0.84 },
            slope: 0.0,
            work: [-40.0, 0.0, 0.0],
            ..walk
        })
        .collect();
    let efforts = run(&Plate { coupling: 0.2 }, &walk).unwrap();
    let factorisations: Vec<usize> = efforts.iter().map(|e| e.factorisations).collect();
    assert_eq!(factorisations[..2], [1, 0], "those of all points serve");
    assert_eq!(factorisations[2..].iter().sum::<usize>(), 1);
}

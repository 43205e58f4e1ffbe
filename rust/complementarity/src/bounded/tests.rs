// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::unmonitored;
use proptest::prelude::*;

use super::*;
use crate::linear;

/// A positive definite matrix that falls off with the distance, as a compliance does.
fn matrix(n: usize) -> Vec<f64> {
    (0..n * n)
        .map(|k| 1.0 / (0.5 + (k / n).abs_diff(k % n) as f64))
        .collect()
}

fn multiply(a: &[f64], x: &[f64], y: &mut [f64]) {
    for (row, y) in a.chunks_exact(x.len()).zip(y) {
        *y = row.iter().zip(x).map(|(a, x)| a * x).sum();
    }
}

fn run(
    a: &[f64],
    offset: &[f64],
    modes: &[Mode],
    start: Vec<f64>,
) -> Result<Solution, crate::Error> {
    let apply = |x: &[f64], y: &mut [f64]| multiply(a, x, y);
    let precondition = |_: &[bool], x: &[f64], y: &mut [f64]| y.copy_from_slice(x);
    let options = Options {
        tolerance: 1e-11,
        max_iterations: 500,
    };
    solve(
        &apply,
        &precondition,
        &Problem { offset, modes },
        start,
        options,
        &unmonitored,
    )
}

fn line(n: usize) -> Vec<f64> {
    (0..n)
        .map(|i| 2.0 * (i as f64 + 0.5) / n as f64 - 1.0)
        .collect()
}

/// The same problem by the dense active-set method.
fn reference(a: &[f64], offset: &[f64], modes: &[Mode]) -> Result<linear::Solution, crate::Error> {
    let shapes: Vec<f64> = modes.iter().flat_map(|m| m.shape.clone()).collect();
    let target: Vec<f64> = modes.iter().map(|m| m.target).collect();
    let border = linear::Border {
        motion: &shapes,
        balance: &shapes,
        target: &target,
    };
    let problem = linear::Problem {
        matrix: a,
        offset,
        border: (!modes.is_empty()).then_some(border),
        symmetric: true,
        limit: None,
    };
    linear::solve(&problem, &linear::Options::default(), &unmonitored)
}

fn assert_same(found: &Solution, exact: &linear::Solution) {
    assert_eq!(found.status, Status::Solved, "{:?}", found.history);
    let scale = exact.pressure.iter().fold(0.0_f64, |m, p| m.max(*p));
    for (p, q) in found.pressure.iter().zip(&exact.pressure) {
        assert!((p - q).abs() <= 1e-8 * scale, "{p} {q}");
    }
    for (c, d) in found.motion.iter().zip(&exact.motion) {
        assert!((c - d).abs() < 1e-8 * (1.0 + d.abs()), "{c} {d}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn agrees_with_the_active_set_method(
        gaps in proptest::collection::vec(0.0..6.0_f64, 12),
        force in 0.05..20.0_f64,
        tilt in -0.5..0.5_f64,
        kind in 0..3,
    ) {
        let n = gaps.len();
        let a = matrix(n);
        let force_mode = Mode { shape: vec![1.0; n], target: force };
        let tilt_mode = Mode { shape: line(n), target: tilt * force };
        let (modes, offset) = match kind {
            0 => (vec![], gaps.iter().map(|g| g - 3.0).collect()),
            1 => (vec![force_mode], gaps),
            _ => (vec![force_mode, tilt_mode], gaps),
        };
        let start = vec![if kind == 0 { 0.0 } else { 1.0 }; n];
        let found = run(&a, &offset, &modes, start).map_err(|e| TestCaseError::fail(e.to_string()))?;
        let exact = reference(&a, &offset, &modes).map_err(|e| TestCaseError::fail(e.to_string()))?;
        assert_same(&found, &exact);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_start_of_any_size_on_open_points_is_forgotten(
        gaps in proptest::collection::vec(prop_oneof![Just(0.0), 0.0..6.0_f64], 12),
        start in proptest::collection::vec(prop_oneof![Just(0.0), -3.0..9.0_f64], 12),
        approach in -12.0..1.0_f64,
    ) {
        let a = matrix(gaps.len());
        let approach = 10_f64.powf(approach);
        let offset: Vec<f64> = gaps.iter().map(|g| g - approach).collect();
        let start = start.iter().map(|s| if *s == 0.0 { 0.0 } else { 10_f64.powf(*s) }).collect();
        let found = run(&a, &offset, &[], start).map_err(|e| TestCaseError::fail(e.to_string()))?;
        let exact = reference(&a, &offset, &[]).map_err(|e| TestCaseError::fail(e.to_string()))?;
        assert_same(&found, &exact);
    }
}

#[test]
fn one_point_carries_a_small_force() -> Result<(), crate::Error> {
    let mut offset = vec![5.0; 9];
    offset[4] = 0.0;
    let modes = [Mode {
        shape: vec![1.0; 9],
        target: 0.5,
    }];
    let found = run(&matrix(9), &offset, &modes, vec![1.0; 9])?;
    assert_eq!(found.status, Status::Solved);
    assert!((found.pressure[4] - 0.5).abs() < 1e-14);
    assert_eq!(found.pressure.iter().filter(|p| **p > 0.0).count(), 1);
    assert!((found.motion[0] - 1.0).abs() < 1e-12);
    Ok(())
}

#[test]
fn no_contact_is_a_solution() -> Result<(), crate::Error> {
    let found = run(&matrix(4), &[1.0; 4], &[], vec![0.0; 4])?;
    assert_eq!((found.status, found.products), (Status::Solved, 0));
    assert!(found.pressure.iter().all(|p| *p == 0.0));
    Ok(())
}

#[test]
fn a_resultant_outside_of_the_points_is_not_reached() -> Result<(), crate::Error> {
    let n = 8;
    let modes = [
        Mode {
            shape: vec![1.0; n],
            target: 1.0,
        },
        Mode {
            shape: line(n),
            target: 1.2,
        },
    ];
    let found = run(&matrix(n), &vec![0.0; n], &modes, vec![1.0; n])?;
    assert_eq!(found.status, Status::Unreachable);
    Ok(())
}

#[test]
fn stops_when_asked() {
    let a = matrix(4);
    let apply = |x: &[f64], y: &mut [f64]| multiply(&a, x, y);
    let offset = [0.0, 0.1, 0.4, 0.2];
    let modes = [Mode {
        shape: vec![1.0; 4],
        target: 1.0,
    }];
    let stop = |_| std::ops::ControlFlow::Break(());
    let problem = Problem {
        offset: &offset,
        modes: &modes,
    };
    let options = Options {
        tolerance: 1e-10,
        max_iterations: 9,
    };
    let copy = |_: &[bool], x: &[f64], y: &mut [f64]| y.copy_from_slice(x);
    let outcome = solve(&apply, &copy, &problem, vec![1.0; 4], options, &stop);
    assert!(matches!(outcome, Err(crate::Error::Interrupted)));
}

proptest! {
    #[test]
    fn pressures_under_a_cap_meet_their_conditions(
        offsets in proptest::collection::vec(0.0..2.0, 4..30),
        share in 0.05..0.95,
        force in 0.1..0.98,
        is_held in any::<bool>(),
    ) {
        let n = offsets.len();
        let a = matrix(n);
        let one = Mode { shape: vec![1.0; n], target: force * n as f64 };
        let (offset, modes) = if is_held {
            (offsets.iter().map(|b| b - 2.5 * force).collect::<Vec<f64>>(), vec![])
        } else {
            (offsets, vec![one])
        };
        let bare = run(&a, &offset, &modes, vec![1.0; n]).unwrap();
        let largest = bare.pressure.iter().copied().fold(0.0, f64::max);
        prop_assume!(bare.status == Status::Solved && largest > 0.0);
        // above the mean, which is the least that can carry the force
        let least = if is_held { 0.0 } else { force };
        let cap = least + share * (largest - least);
        let apply = |x: &[f64], y: &mut [f64]| multiply(&a, x, y);
        let same = |_: &[bool], x: &[f64], y: &mut [f64]| y.copy_from_slice(x);
        let options = Options { tolerance: 1e-10, max_iterations: 500 };
        let problem = Problem { offset: &offset, modes: &modes };
        let found =
            solve_capped(&apply, &same, &problem, cap, bare.pressure, options, &unmonitored).unwrap();
        prop_assert_eq!(found.status, Status::Solved);
        // the search ends by the measure that its result is judged by
        let last = found.history[found.history.len() - 1];
        prop_assert!((last - found.residual).abs() <= 1e-4 * options.tolerance);
        let mut w = vec![0.0; n];
        multiply(&a, &found.pressure, &mut w);
        for i in 0..n {
            w[i] += offset[i] - if is_held { 0.0 } else { found.motion[0] };
            prop_assert!((w[i] - found.slack[i]).abs() < 1e-9);
            let p = found.pressure[i];
            prop_assert!(p >= 0.0 && p <= cap * (1.0 + 1e-9));
            prop_assert!(w[i] > -1e-7 || p >= cap);
            prop_assert!(w[i] < 1e-7 || p <= 0.0);
        }
        if !is_held {
            let sum: f64 = found.pressure.iter().sum();
            prop_assert!((sum - force * n as f64).abs() < 1e-9 * n as f64);
        }
    }
}

proptest! {
    /// Pressures far from a balance that others between the bounds meet are brought to it.
    #[test]
    fn pressures_between_bounds_are_brought_to_any_balance_that_others_meet(
        other in prop::collection::vec(-0.5..1.5_f64, 12..60),
        share in 0.0..1.0_f64,
        size in 0.0..7.0_f64,
        tilts in 0..3_usize,
    ) {
        let n = other.len();
        let place = |i: usize, turn: f64| (turn * i as f64).sin();
        let shapes = [vec![1.0; n], (0..n).map(|i| place(i, 1.0)).collect(), (0..n).map(|i| place(i, 2.3)).collect()];
        let modes: Vec<Mode> = shapes
            .into_iter()
            .take(1 + tilts)
            .map(|shape| {
                let target = shape.iter().zip(&other).map(|(n, p)| n * p.clamp(0.0, 1.0)).sum();
                Mode { shape, target }
            })
            .collect();
        // all at a bound or near one of them, or so far beyond that the balance leaves few between
        let far = 10_f64.powf(size);
        let mut p: Vec<f64> = (0..n)
            .map(|i| match i % 3 {
                0 => share,
                1 => 0.0,
                _ => far * (place(i, 0.7) + share),
            })
            .collect();
        let (spans, all) = (super::sums::Spans::whole(n), vec![true; n]);
        prop_assert!(super::state::project(&modes, &mut p, 1.0, [0.0; 3], &spans, &all).is_some());
        prop_assert!(p.iter().all(|p| (0.0..=1.0).contains(p)));
        for mode in &modes {
            let sum: f64 = mode.shape.iter().zip(&p).map(|(n, p)| n * p).sum();
            prop_assert!((sum - mode.target).abs() <= 1e-6 * n as f64, "{sum} is not {}", mode.target);
        }
    }
}

/// Of pressures up to 1: none opens with a pressure or penetrates below the cap, and they meet the balance.
fn meets_its_conditions(
    a: &[f64],
    problem: &Problem<'_>,
    found: &Solution,
) -> Result<(), TestCaseError> {
    let n = problem.offset.len();
    let mut w = vec![0.0; n];
    multiply(a, &found.pressure, &mut w);
    for i in 0..n {
        w[i] += problem.offset[i];
        for (mode, c) in problem.modes.iter().zip(&found.motion) {
            w[i] -= c * mode.shape[i];
        }
        let p = found.pressure[i];
        prop_assert!((0.0..=1.0).contains(&p));
        prop_assert!(w[i] > -1e-6 || p >= 1.0, "{} at {p}", w[i]);
        prop_assert!(w[i] < 1e-6 || p <= 0.0, "{} at {p}", w[i]);
    }
    for mode in problem.modes {
        let sum: f64 = mode
            .shape
            .iter()
            .zip(&found.pressure)
            .map(|(n, p)| n * p)
            .sum();
        prop_assert!((sum - mode.target).abs() < 1e-9 * n as f64);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Bodies so soft that nearly all points are open or at the cap, all of them where the force is that of a number of
    /// caps.
    #[test]
    fn points_that_are_all_at_a_bound_meet_their_conditions(
        offsets in proptest::collection::vec(0.0..2000.0_f64, 12..40),
        share in 0.1..0.9_f64,
        is_whole in any::<bool>(),
        seed in 0..7_usize,
    ) {
        let n = offsets.len();
        let a = matrix(n);
        let caps = share * n as f64;
        let force = if is_whole { caps.round() } else { caps };
        let modes = [Mode { shape: vec![1.0; n], target: force }];
        let apply = |x: &[f64], y: &mut [f64]| multiply(&a, x, y);
        let same = |_: &[bool], x: &[f64], y: &mut [f64]| y.copy_from_slice(x);
        let options = Options { tolerance: 1e-10, max_iterations: 500 };
        let problem = Problem { offset: &offsets, modes: &modes };
        // some points at the cap, others open, few between: not those of the answer
        let start = (0..n).map(|i| [0.0, 1.0, 0.5][(i * (seed + 1)) % 3]).collect();
        let found = solve_capped(&apply, &same, &problem, 1.0, start, options, &unmonitored).unwrap();
        prop_assert_eq!(found.status, Status::Solved);
        meets_its_conditions(&a, &problem, &found)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Bodies that tilt as well, from stiff ones to those so soft that the tilts leave few points between the bounds.
    #[test]
    fn points_at_their_bounds_meet_their_conditions_in_bodies_that_tilt(
        gaps in proptest::collection::vec(0.0..1.0_f64, 12..60),
        other in proptest::collection::vec(-1.0..2.0_f64, 60),
        size in 0.0..5.0_f64,
        is_flat in any::<bool>(),
        tilts in 1..3_usize,
    ) {
        let n = gaps.len();
        let a = matrix(n);
        let far = 10_f64.powf(size);
        let offset: Vec<f64> = gaps
            .iter()
            .map(|gap| far * if is_flat { (gap - 0.6).max(0.0) } else { *gap })
            .collect();
        let shapes = [vec![1.0; n], line(n), line(n).iter().map(|x| x * x - 0.3).collect()];
        let modes: Vec<Mode> = shapes
            .into_iter()
            .take(1 + tilts)
            .map(|shape| {
                let target = shape.iter().zip(&other).map(|(n, p)| n * p.clamp(0.0, 1.0)).sum();
                Mode { shape, target }
            })
            .collect();
        let apply = |x: &[f64], y: &mut [f64]| multiply(&a, x, y);
        let same = |_: &[bool], x: &[f64], y: &mut [f64]| y.copy_from_slice(x);
        let options = Options { tolerance: 1e-9, max_iterations: 500 };
        let problem = Problem { offset: &offset, modes: &modes };
        let found =
            solve_capped(&apply, &same, &problem, 1.0, vec![0.5; n], options, &unmonitored).unwrap();
        prop_assert_eq!(found.status, Status::Solved, "{:?}", found.history);
        meets_its_conditions(&a, &problem, &found)?;
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pressures with a limit, checked by their conditions and against projected Gauss-Seidel.

use mtb_complementarity::linear::{
    Border, ByProducts, Options, Problem, Status, gauss_seidel, reachable_within, solve,
    solve_by_products,
};
use mtb_operator::unmonitored;
use proptest::prelude::*;

/// A symmetric positive definite matrix plus `skew` times a skew one, from entries in [-1, 1].
fn matrix(n: usize, entries: &[f64], skew: f64) -> Vec<f64> {
    let mut a = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                a[i * n + j] += entries[i * n + k] * entries[j * n + k];
            }
            a[i * n + j] += skew * (entries[i * n + j] - entries[j * n + i]);
        }
        a[i * n + i] += 0.3;
    }
    a
}

/// The conditions, each by itself: open, closed, or at the limit.
fn assert_holds(problem: &Problem<'_>, limit: &[f64], p: &[f64], c: &[f64]) {
    let w = problem.slack(p, c);
    let scale = w.iter().fold(1.0_f64, |s, b| s.max(b.abs()));
    for i in 0..p.len() {
        assert!(p[i] >= 0.0 && p[i] <= limit[i], "pressure {i} is {}", p[i]);
        if p[i] == 0.0 {
            assert!(w[i] > -1e-8 * scale, "open {i} has {}", w[i]);
        } else if p[i] == limit[i] {
            assert!(w[i] < 1e-8 * scale, "held {i} has {}", w[i]);
        } else {
            assert!(w[i].abs() < 1e-8 * scale, "closed {i} has {}", w[i]);
        }
    }
}

proptest! {
    #[test]
    fn all_methods_meet_the_conditions(
        n in 1_usize..12,
        entries in prop::collection::vec(-1.0..1.0_f64, 144),
        offset in prop::collection::vec(-1.0..0.5_f64, 12),
        limit in prop::collection::vec(0.05..1.0_f64, 12),
        skew in prop::sample::select(vec![0.0, 0.3, 1.0]),
        exponent in -12..6_i32,
    ) {
        // bodies as soft as one likes
        let scale = 10.0_f64.powi(exponent);
        let a: Vec<f64> = matrix(n, &entries, skew).iter().map(|v| v * scale).collect();
        let (offset, limit) = (&offset[..n], &limit[..n]);
        let limit: Vec<f64> = limit.iter().map(|l| l / scale).collect();
        let problem = Problem {
            matrix: &a,
            offset,
            border: None,
            symmetric: skew == 0.0,
            limit: Some(&limit),
        };
        let found = solve(&problem, &Options::default(), &unmonitored).unwrap();
        prop_assert_eq!(found.status, Status::Solved);
        assert_holds(&problem, &limit, &found.pressure, &[]);
        prop_assert!(found.residual < 1e-9);
        let multiply = |x: &[f64], out: &mut [f64]| {
            for (out, row) in out.iter_mut().zip(a.chunks_exact(n)) {
                *out = row.iter().zip(x).map(|(a, x)| a * x).sum();
            }
        };
        let diagonal: Vec<f64> = a.iter().step_by(n + 1).copied().collect();
        let products = ByProducts {
            multiply: &multiply,
            diagonal: &diagonal,
            near_inverse: None,
            offset,
            border: None,
            limit: Some(&limit),
        };
        let other = solve_by_products(&products, None, &unmonitored).unwrap();
        prop_assert_eq!(other.status, Status::Solved);
        if skew == 0.0 {
            let swept = gauss_seidel(&problem, 1.0, 1e-11, 100_000, &unmonitored).unwrap();
            prop_assert_eq!(swept.status, Status::Solved);
            for i in 0..n {
                prop_assert!((swept.pressure[i] - found.pressure[i]).abs() * scale < 1e-6);
                prop_assert!((other.pressure[i] - found.pressure[i]).abs() * scale < 1e-6);
            }
        }
    }

    #[test]
    fn the_balance_holds_up_to_the_load_that_all_bear(
        entries in prop::collection::vec(-1.0..1.0_f64, 64),
        gap in prop::collection::vec(0.0..1.0_f64, 8),
        share in 0.01..0.999_f64,
        tilt in -0.05..0.05_f64,
    ) {
        let n = 8;
        let a = matrix(n, &entries, 0.2);
        let limit = [0.5; 8];
        let x: Vec<f64> = (0..n).map(|i| -1.0 + 2.0 * i as f64 / (n - 1) as f64).collect();
        let columns = [vec![1.0; n], x.clone()].concat();
        let force = share * 4.0;
        // near the limit of all no lever is left
        let moment = tilt * force.min(4.0 - force);
        let border = Border { motion: &columns, balance: &columns, target: &[force, moment] };
        let problem = Problem {
            matrix: &a,
            offset: &gap,
            border: Some(border),
            symmetric: false,
            limit: Some(&limit),
        };
        let found = solve(&problem, &Options::default(), &unmonitored).unwrap();
        prop_assert_eq!(found.status, Status::Solved);
        assert_holds(&problem, &limit, &found.pressure, &found.motion);
        let sum: f64 = found.pressure.iter().sum();
        let turned: f64 = found.pressure.iter().zip(&x).map(|(p, x)| p * x).sum();
        prop_assert!((sum - force).abs() < 1e-9 && (turned - moment).abs() < 1e-9);
        let beyond = Border { target: &[4.001, 0.0], ..border };
        let beyond = Problem { border: Some(beyond), ..problem };
        let refused = solve(&beyond, &Options::default(), &unmonitored).unwrap();
        prop_assert_eq!(refused.status, Status::Overloaded);
    }
}

/// Weights on springs along a line: some pressures within their limits carry a force and a moment, or none do.
#[test]
fn pressures_within_limits_carry_what_lies_in_the_hull_of_their_sums() {
    // points at -1, 0 and 1, which bear 1, 2 and 3
    let (balance, limit) = ([1.0, 1.0, 1.0, -1.0, 0.0, 1.0], [1.0, 2.0, 3.0]);
    for (target, is_borne) in [
        ([6.0, 2.0], true),
        ([6.0, 1.9], false),
        ([5.0, 3.0], true),
        ([5.0, 3.001], false),
        ([3.0, 3.0], true),
        ([2.0, -1.0], true),
        ([2.0, -1.001], false),
        ([0.0, 0.0], true),
        ([-1e-3, 0.0], false),
    ] {
        assert_eq!(
            reachable_within(&balance, &target, &limit),
            is_borne,
            "{target:?}"
        );
    }
}

proptest! {
    #[test]
    fn what_pressures_within_their_limits_carry_is_borne(
        points in prop::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64, 0.1..3.0_f64, 0.0..1.0_f64), 3..40),
    ) {
        let ones = vec![1.0; points.len()];
        let column = |f: fn(&(f64, f64, f64, f64)) -> f64| points.iter().map(f).collect::<Vec<f64>>();
        let balance = [ones, column(|p| p.0), column(|p| p.1)].concat();
        let limit = column(|p| p.2);
        let n = points.len();
        let target: Vec<f64> = (0..3)
            .map(|k| (0..n).map(|i| balance[k * n + i] * limit[i] * points[i].3).sum())
            .collect();
        prop_assert!(reachable_within(&balance, &target, &limit));
        // more than all of them together
        let all: f64 = limit.iter().sum();
        prop_assert!(!reachable_within(&balance, &[1.001 * all, target[1], target[2]], &limit));
    }

    #[test]
    fn bodies_far_apart_are_solved_as_those_that_touch(far in 1.0..1e9_f64) {
        let matrix = [4.0, 1.0, 0.5, 1.0, 4.0, 1.0, 0.5, 1.0, 4.0];
        let gap = [0.3, 0.1, 0.2];
        let border = Border { motion: &[1.0, 1.0, 1.0], balance: &[1.0, 1.0, 1.0], target: &[1.0] };
        let of = |offset: &[f64]| {
            let problem = Problem { matrix: &matrix, offset, border: Some(border), symmetric: true, limit: None };
            solve(&problem, &Options::default(), &unmonitored).unwrap()
        };
        let (near, away) = (of(&gap), of(&gap.map(|g| g + far)));
        prop_assert_eq!(away.status, Status::Solved);
        for (a, b) in near.pressure.iter().zip(&away.pressure) {
            // the gaps themselves have lost digits
            prop_assert!((a - b).abs() < 1e-15 * far + 1e-12);
        }
        prop_assert!((away.motion[0] - near.motion[0] - far).abs() < 1e-14 * far + 1e-12);
    }
}

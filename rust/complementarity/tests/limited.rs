// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pressures with a limit, checked by their conditions and against projected Gauss-Seidel.

use mtb_complementarity::linear::{
    Border, ByProducts, Options, Problem, Status, gauss_seidel, solve, solve_by_products,
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
        prop_assert_eq!(refused.status, Status::Unreachable);
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Complementarity conditions, checked independently of the solvers.

use mtb_complementarity::linear::{
    Border, ByProducts, Options, Problem, Status, definiteness_limit, gauss_seidel, lemke,
    reachable, solve, solve_by_products,
};
use mtb_operator::{Map, unmonitored};
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
        a[i * n + i] += 0.1;
    }
    a
}

fn assert_solves(problem: &Problem<'_>, p: &[f64], c: &[f64]) {
    let w = problem.slack(p, c);
    let scale = problem
        .offset
        .iter()
        .fold(1e-300_f64, |s, b| s.max(b.abs()));
    for i in 0..p.len() {
        assert!(p[i] >= 0.0, "pressure {i} is {}", p[i]);
        assert!(w[i] > -1e-8 * scale, "slack {i} is {}", w[i]);
        assert!(
            p[i] == 0.0 || w[i].abs() < 1e-8 * scale,
            "both at {i}: {} {}",
            p[i],
            w[i]
        );
    }
}

proptest! {
    #[test]
    fn active_sets_and_lemke_agree_on_p_matrices(
        n in 1_usize..12,
        entries in prop::collection::vec(-1.0..1.0_f64, 144),
        offset in prop::collection::vec(-1.0..1.0_f64, 12),
        skew in 0.0..2.0_f64,
        exponent in -12..6_i32,
    ) {
        let scale = 10.0_f64.powi(exponent);
        let a: Vec<f64> = matrix(n, &entries, skew).iter().map(|v| v * scale).collect();
        let problem =
            Problem { matrix: &a, offset: &offset[..n], border: None, symmetric: skew == 0.0, limit: None };
        let by_sets = solve(&problem, &Options::default(), &unmonitored).unwrap();
        let by_pivots = lemke(&problem, &unmonitored).unwrap();
        prop_assert_eq!(by_sets.status, Status::Solved);
        prop_assert_eq!(by_pivots.status, Status::Solved);
        assert_solves(&problem, &by_sets.pressure, &[]);
        let size = by_sets.pressure.iter().fold(1e-300_f64, |s, p| s.max(*p));
        for i in 0..n {
            prop_assert!((by_sets.pressure[i] - by_pivots.pressure[i]).abs() < 1e-7 * size);
        }
    }

    #[test]
    fn force_and_tilt_are_met_whenever_the_resultant_lies_inside(
        entries in prop::collection::vec(-1.0..1.0_f64, 64),
        gap in prop::collection::vec(0.0..1.0_f64, 8),
        at in -0.9..0.9_f64,
    ) {
        let n = 8;
        let a = matrix(n, &entries, 0.3);
        let x: Vec<f64> = (0..n).map(|i| -1.0 + 2.0 * i as f64 / (n - 1) as f64).collect();
        let mut columns = vec![1.0; n];
        columns.extend(&x);
        let border =
            Border { motion: &columns, balance: &columns, target: &[10.0, 10.0 * at] };
        let problem = Problem { matrix: &a, offset: &gap, border: Some(border), symmetric: false, limit: None };
        let s = solve(&problem, &Options::default(), &unmonitored).unwrap();
        prop_assert_eq!(s.status, Status::Solved);
        assert_solves(&problem, &s.pressure, &s.motion);
        let force: f64 = s.pressure.iter().sum();
        let moment: f64 = s.pressure.iter().zip(&x).map(|(p, x)| p * x).sum();
        prop_assert!((force - 10.0).abs() < 1e-9);
        prop_assert!((moment - 10.0 * at).abs() < 1e-9);
        let outside = Border { target: &[10.0, 10.01], ..border };
        let outside = Problem { border: Some(outside), ..problem };
        let s = solve(&outside, &Options::default(), &unmonitored).unwrap();
        prop_assert_eq!(s.status, Status::Unreachable);
    }
}

#[test]
fn a_problem_without_solution_is_named() {
    // w = -p - 1 can not be made non-negative
    let problem = Problem {
        matrix: &[-1.0],
        offset: &[-1.0],
        border: None,
        symmetric: false,
        limit: None,
    };
    let s = solve(&problem, &Options::default(), &unmonitored).unwrap();
    assert_eq!(s.status, Status::NoSolution);
}

#[test]
fn gauss_seidel_agrees_on_a_symmetric_problem() {
    let problem = Problem {
        matrix: &[2.0, 1.0, 1.0, 2.0],
        offset: &[-2.0, 1.0],
        border: None,
        symmetric: true,
        limit: None,
    };
    let s = gauss_seidel(&problem, 1.0, 1e-12, 1000, &unmonitored).unwrap();
    assert_eq!(s.status, Status::Solved);
    assert!((s.pressure[0] - 1.0).abs() < 1e-11 && s.pressure[1] == 0.0);
}

#[test]
fn definiteness_limit_of_a_known_pair() {
    // A = I, sym(A_t) = diag(-2, 1): definite for mu < 1/2
    let limit = definiteness_limit(
        &[1.0, 0.0, 0.0, 1.0],
        &[-2.0, 0.0, 0.0, 1.0],
        &[1.0, 1.0],
        None,
        &unmonitored,
    )
    .unwrap();
    assert!((limit - 0.5).abs() < 1e-12, "{limit}");
    let none = definiteness_limit(
        &[1.0, 0.0, 0.0, 1.0],
        &[0.0, 1.0, -1.0, 0.0],
        &[1.0, 1.0],
        None,
        &unmonitored,
    )
    .unwrap();
    assert!(none > 1e12);
    let held = definiteness_limit(
        &[1.0, 0.0, 0.0, 1.0],
        &[-2.0, 0.0, 0.0, 1.0],
        &[1.0, 1.0],
        Some(&[1.0, 0.0]),
        &unmonitored,
    )
    .unwrap();
    assert!(held > 1e12, "the only dangerous direction is held: {held}");
}

#[test]
fn a_resultant_is_reachable_inside_the_hull_only() {
    let balance = [1.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    assert!(reachable(&balance, &[3.0, 1.0, 1.0]));
    assert!(reachable(&balance, &[3.0, 3.0, 0.0]));
    assert!(!reachable(&balance, &[3.0, 3.01, 0.0]));
    assert!(!reachable(&balance, &[-1.0, 0.0, 0.0]));
}

#[test]
fn bad_data_is_named() {
    let problem = Problem {
        matrix: &[1.0, f64::NAN],
        offset: &[1.0],
        border: None,
        symmetric: true,
        limit: None,
    };
    let error = solve(&problem, &Options::default(), &unmonitored).unwrap_err();
    assert_eq!(error.to_string(), "matrix has 2 entries, expected 1");
    let problem = Problem {
        matrix: &[f64::NAN],
        offset: &[1.0],
        border: None,
        symmetric: true,
        limit: None,
    };
    let error = solve(&problem, &Options::default(), &unmonitored).unwrap_err();
    assert_eq!(
        error.to_string(),
        "matrix[0] is NaN, a finite number is needed"
    );
}

/// Three rows of points that approach, pitch and roll under a load on the middle one, alone nearest to the ground.
///
/// The axis of the roll lies on the middle row, but for `off`.
fn ridge(n: usize, load: [f64; 3], off: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>, Vec<f64>) {
    let mut matrix = vec![0.0; 9 * n * n];
    let (mut offset, mut closing) = (vec![0.0; 3 * n], vec![0.0; 9 * n]);
    for row in 0..3 {
        for k in 0..n {
            let i = row * n + k;
            matrix[i * 3 * n + i] = 1.0;
            offset[i] = if row == 1 { 0.0 } else { 5.0 };
            closing[i] = 1.0;
            closing[3 * n + i] = k as f64 - 0.5 * (n as f64 - 1.0);
            closing[6 * n + i] = row as f64 - 1.0 + off * (k as f64 - 1.0);
        }
    }
    (matrix, offset, closing, load.to_vec())
}

#[test]
fn a_body_on_one_row_of_points_stands() {
    // levers that are rounding, of few digits and of many
    for off in [0.0, 1e-17, 1e-13] {
        let (matrix, offset, closing, target) = ridge(5, [10.0, 0.0, 0.0], off);
        let problem = Problem {
            matrix: &matrix,
            offset: &offset,
            border: Some(Border {
                motion: &closing,
                balance: &closing,
                target: &target,
            }),
            symmetric: true,
            limit: None,
        };
        let solution = solve(&problem, &Options::default(), &unmonitored).unwrap();
        assert_eq!(solution.status, Status::Solved);
        for (i, p) in solution.pressure.iter().enumerate() {
            let expected = if (5..10).contains(&i) { 2.0 } else { 0.0 };
            assert!((p - expected).abs() < 1e-9, "{i}: {p}");
        }
        // any roll between those that close one of the other rows would do
        assert!((solution.motion[0] - 2.0).abs() < 1e-9 && solution.motion[2].abs() < 3.0);
    }
}

#[test]
fn a_body_on_one_row_of_points_rolls_until_another_holds_it() {
    // a moment of the whole load on a quarter of the distance to the next row
    let (matrix, offset, closing, target) = ridge(5, [10.0, 0.0, 2.5], 1e-17);
    let problem = Problem {
        matrix: &matrix,
        offset: &offset,
        border: Some(Border {
            motion: &closing,
            balance: &closing,
            target: &target,
        }),
        symmetric: true,
        limit: None,
    };
    let solution = solve(&problem, &Options::default(), &unmonitored).unwrap();
    assert_eq!(solution.status, Status::Solved);
    for (i, p) in solution.pressure.iter().enumerate() {
        let expected = [0.0, 1.5, 0.5][i / 5];
        assert!((p - expected).abs() < 1e-9, "{i}: {p}");
    }
}

proptest! {
    #[test]
    fn products_find_what_the_matrix_does(
        n in 3_usize..12,
        entries in prop::collection::vec(-1.0..1.0_f64, 144),
        offset in prop::collection::vec(-1.0..1.0_f64, 12),
        skew in 0.0..1.0_f64,
        exponent in -12..6_i32,
        is_free in any::<bool>(),
    ) {
        let scale = 10.0_f64.powi(exponent);
        let a: Vec<f64> = matrix(n, &entries, skew).iter().map(|v| v * scale).collect();
        let (motion, target) = (vec![3.0; n], [2.0]);
        let border = is_free.then_some(Border { motion: &motion, balance: &motion, target: &target });
        let problem = Problem { matrix: &a, offset: &offset[..n], border, symmetric: false, limit: None };
        let multiply = |x: &[f64], out: &mut [f64]| {
            for (out, row) in out.iter_mut().zip(a.chunks_exact(n)) {
                *out = row.iter().zip(x).map(|(a, x)| a * x).sum();
            }
        };
        let diagonal: Vec<f64> = (0..n).map(|i| a[i * n + i]).collect();
        let by_products =
            ByProducts { multiply: &multiply, diagonal: &diagonal, near_inverse: None, offset: problem.offset, border, limit: None };
        let expected = solve(&problem, &Options::default(), &unmonitored).unwrap();
        let found = solve_by_products(&by_products, None, &unmonitored).unwrap();
        prop_assert_eq!(found.status, Status::Solved);
        let left = problem.residual(&found.pressure, &problem.slack(&found.pressure, &found.motion), &found.motion);
        prop_assert!(left < 1e-8, "{left}");
        // elimination loses more digits on bodies that hardly deform
        if expected.status == Status::Solved {
            let size = expected.pressure.iter().fold(0.0_f64, |m, p| m.max(*p));
            for (a, b) in found.pressure.iter().zip(&expected.pressure) {
                prop_assert!((a - b).abs() <= 1e-5 * size, "{a} {b}");
            }
        }
    }
}

/// `A_ij = min(i, j)`, whose inverse is tridiagonal: as good as the inverse, the solution of the matrix in a few
/// products a set, whatever the factor before it.
#[test]
fn a_near_inverse_saves_products_and_keeps_the_solution() {
    let n = 120;
    let a: Vec<f64> = (0..n * n)
        .map(|k| 1.0 + (k / n).min(k % n) as f64)
        .collect();
    let offset: Vec<f64> = (0..n)
        .map(|i| -40.0 * (0.05 * i as f64).sin() - 10.0)
        .collect();
    let (motion, target) = (vec![1.0; n], [3.0]);
    let border = Some(Border {
        motion: &motion,
        balance: &motion,
        target: &target,
    });
    let problem = Problem {
        matrix: &a,
        offset: &offset,
        border,
        symmetric: true,
        limit: None,
    };
    let expected = solve(&problem, &Options::default(), &unmonitored).unwrap();
    assert_eq!(expected.status, Status::Solved);
    let multiply = |x: &[f64], out: &mut [f64]| {
        for (out, row) in out.iter_mut().zip(a.chunks_exact(n)) {
            *out = row.iter().zip(x).map(|(a, x)| a * x).sum();
        }
    };
    let invert: Map = Box::new(move |x: &[f64], out: &mut [f64]| {
        for i in 0..n {
            let own = if i + 1 == n { 1.0 } else { 2.0 };
            let beside = [i.checked_sub(1), Some(i + 1)];
            let sides = beside.into_iter().flatten().filter_map(|j| x.get(j));
            out[i] = 7.0 * (own * x[i] - sides.sum::<f64>());
        }
    });
    let diagonal: Vec<f64> = a.iter().step_by(n + 1).copied().collect();
    let mut by_products = ByProducts {
        multiply: &multiply,
        diagonal: &diagonal,
        near_inverse: None,
        offset: &offset,
        border,
        limit: None,
    };
    let slow = solve_by_products(&by_products, None, &unmonitored).unwrap();
    by_products.near_inverse = Some(&invert);
    let fast = solve_by_products(&by_products, None, &unmonitored).unwrap();
    let size = expected.pressure.iter().fold(0.0_f64, |m, p| m.max(*p));
    for found in [&slow, &fast] {
        assert_eq!(found.status, Status::Solved);
        for (p, e) in found.pressure.iter().zip(&expected.pressure) {
            assert!((p - e).abs() < 1e-7 * size, "{p} {e}");
        }
    }
    assert!(
        2 * fast.iterations < slow.iterations,
        "{} {}",
        fast.iterations,
        slow.iterations
    );
}

/// Murty's example, in which block changes go round for ever: P-matrix, two sets that return.
#[test]
fn sets_that_return_end_with_single_changes() {
    let a = [1.0, 2.0, 0.0, 0.0, 1.0, 2.0, 2.0, 0.0, 1.0];
    let offset = [-1.0; 3];
    let multiply = |x: &[f64], out: &mut [f64]| {
        for (out, row) in out.iter_mut().zip(a.chunks_exact(3)) {
            *out = row.iter().zip(x).map(|(a, x)| a * x).sum();
        }
    };
    let problem = ByProducts {
        multiply: &multiply,
        diagonal: &[1.0; 3],
        near_inverse: None,
        offset: &offset,
        border: None,
        limit: None,
    };
    for start in 0..8 {
        let start: Vec<bool> = (0..3).map(|i| start >> i & 1 == 1).collect();
        let found = solve_by_products(&problem, Some(&start), &unmonitored).unwrap();
        assert_eq!(found.status, Status::Solved, "{start:?}");
        for p in found.pressure {
            assert!((p - 1.0 / 3.0).abs() < 1e-8, "{p}");
        }
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::{LinearOperator, unmonitored};
use proptest::prelude::*;

use super::{
    DependentRadius, DiscOptions, DiscProblem, DiscSolution, DiscStart, DiscState, Radius,
    Resultant, solve_discs,
};

struct Dense {
    n: usize,
    entries: Vec<f64>,
}

impl LinearOperator for Dense {
    fn dim(&self) -> usize {
        self.n
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        for (row, out) in self.entries.chunks(self.n).zip(y) {
            *out = row.iter().zip(x).map(|(a, b)| a * b).sum();
        }
    }
}

/// A diagonally dominant, non-symmetric matrix from a seed.
fn dominant(dim: usize, seed: u64) -> Dense {
    let mut state = seed.wrapping_mul(2).wrapping_add(1);
    let mut entries: Vec<f64> = (0..dim * dim)
        .map(|_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
        })
        .collect();
    for i in 0..dim {
        entries[i * dim + i] = 1.0 + 0.6 * dim as f64;
    }
    Dense { n: dim, entries }
}

fn jacobi(matrix: &Dense) -> Dense {
    let n = matrix.n;
    let mut entries = vec![0.0; n * n];
    for i in 0..n {
        entries[i * n + i] = 1.0 / matrix.entries[i * n + i];
    }
    Dense { n, entries }
}

const TIGHT: DiscOptions = DiscOptions {
    tolerance: 1e-11,
    max_iterations: 60,
};

fn start(n: usize, m: usize) -> DiscStart {
    DiscStart::At {
        field: vec![0.0; 2 * n],
        multipliers: vec![0.0; m],
    }
}

/// Largest violation of the conditions of the problem, in units of the diagonal and the radius.
fn violation(matrix: &Dense, solution: &DiscSolution) -> f64 {
    let n = matrix.n / 2;
    let mut worst: f64 = 0.0;
    for i in 0..n {
        let q = [solution.field[i], solution.field[n + i]];
        let f = [solution.image[i], solution.image[n + i]];
        let g = solution.radius[i];
        let size = q[0].hypot(q[1]);
        worst = worst.max(size - g);
        match solution.state[i] {
            DiscState::Excluded => assert!(g == 0.0 && size == 0.0),
            DiscState::Inside => worst = worst.max(f[0].hypot(f[1])),
            DiscState::Rim => {
                // the image opposes the field
                worst = worst.max((q[0] * f[1] - q[1] * f[0]).abs() / g);
                worst = worst.max((q[0] * f[0] + q[1] * f[1]) / g);
            }
        }
    }
    worst
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn meets_the_conditions_of_any_dominant_problem(
        seed in 0_u64..1_000_000,
        n in 1_usize..12,
        load in -3.0_f64..3.0,
        excluded in 0_usize..4,
    ) {
        let matrix = dominant(2 * n, seed);
        let inverse = jacobi(&matrix);
        let offset: Vec<f64> = (0..2 * n).map(|i| 10_f64.powf(load) * (1.3 * i as f64).cos()).collect();
        let radius: Vec<f64> = (0..n)
            .map(|i| if n > 4 && i < excluded { 0.0 } else { 0.2 + (i % 3) as f64 })
            .collect();
        let problem = DiscProblem {
            operator: &matrix,
            rough: &matrix,
            preconditioner: &inverse,
            offset: &offset,
            radius: Radius::Fixed(&radius),
            resultants: &[],
            diagonal: matrix.entries[0],
        };
        let solution = solve_discs(&problem, &start(n, 0), TIGHT, &unmonitored).unwrap();
        prop_assert!(solution.converged, "{:?}", solution.history);
        prop_assert!(violation(&matrix, &solution) < 1e-8 * 10_f64.powf(load).max(1.0));
    }

    #[test]
    fn finds_the_multiplier_of_a_reachable_resultant(
        seed in 0_u64..1_000_000,
        n in 2_usize..10,
        share in -0.95_f64..0.95,
    ) {
        let matrix = dominant(2 * n, seed);
        let inverse = jacobi(&matrix);
        let offset: Vec<f64> = (0..2 * n).map(|i| (0.7 * i as f64).sin()).collect();
        let radius: Vec<f64> = (0..n).map(|i| 1.0 + (i % 2) as f64).collect();
        let mut ones = vec![0.0; 2 * n];
        ones[..n].fill(1.0);
        let value = share * radius.iter().sum::<f64>();
        let resultants = [Resultant { direction: ones.clone(), weight: ones, value, softness: 0.0 }];
        let problem = DiscProblem {
            operator: &matrix,
            rough: &matrix,
            preconditioner: &inverse,
            offset: &offset,
            radius: Radius::Fixed(&radius),
            resultants: &resultants,
            diagonal: matrix.entries[0],
        };
        let solution = solve_discs(&problem, &start(n, 1), TIGHT, &unmonitored).unwrap();
        prop_assert!(solution.converged, "{:?}", solution.history);
        let sum: f64 = solution.field[..n].iter().sum();
        prop_assert!((sum - value).abs() < 1e-9 * n as f64);
        prop_assert!(violation(&matrix, &solution) < 1e-7);
    }
}

#[test]
fn what_is_far_below_its_bounds_is_solved_as_well() {
    let n = 8;
    let matrix = dominant(2 * n, 3);
    let inverse = jacobi(&matrix);
    let radius = vec![1.0; n];
    let solve = |scale: f64, by_sum: bool| {
        let offset: Vec<f64> = (0..2 * n)
            .map(|i| {
                if by_sum {
                    0.0
                } else {
                    scale * (i as f64).sin()
                }
            })
            .collect();
        let ones = [vec![1.0; n], vec![0.0; n]].concat();
        let resultants = Vec::from_iter(by_sum.then(|| Resultant {
            direction: ones.clone(),
            weight: ones,
            value: scale,
            softness: 0.0,
        }));
        let problem = DiscProblem {
            operator: &matrix,
            rough: &matrix,
            preconditioner: &inverse,
            offset: &offset,
            radius: Radius::Fixed(&radius),
            resultants: &resultants,
            diagonal: matrix.entries[0],
        };
        let solution = solve_discs(&problem, &start(n, resultants.len()), TIGHT, &unmonitored);
        let solution = solution.unwrap();
        assert!(solution.converged);
        solution.field
    };
    for by_sum in [false, true] {
        let large = solve(1e-3, by_sum);
        for scale in [1e-9, 1e-14, 1e-40] {
            for (small, large) in solve(scale, by_sum).iter().zip(&large) {
                assert!((small / scale - large / 1e-3).abs() < 1e-6);
            }
        }
    }
}

/// Radius that falls with the magnitude of the image at the same point.
struct Falling(f64);

impl DependentRadius for Falling {
    fn radius(&self, magnitude: &[f64], radius: &mut [f64]) {
        for (g, m) in radius.iter_mut().zip(magnitude) {
            *g = 0.5 + self.0 * (-m).exp();
        }
    }

    fn derivative(&self, magnitude: &[f64], change: &[f64], derivative: &mut [f64]) {
        for ((d, m), c) in derivative.iter_mut().zip(magnitude).zip(change) {
            *d = -self.0 * (-m).exp() * c;
        }
    }

    fn derivative_transposed(&self, magnitude: &[f64], weight: &[f64], derivative: &mut [f64]) {
        self.derivative(magnitude, weight, derivative);
    }
}

#[test]
fn a_falling_radius_converges_quadratically() {
    let n = 8;
    let matrix = dominant(2 * n, 7);
    let inverse = jacobi(&matrix);
    let offset: Vec<f64> = (0..2 * n).map(|i| 8.0 * (0.4 * i as f64).cos()).collect();
    let law = Falling(0.3);
    let problem = DiscProblem {
        operator: &matrix,
        rough: &matrix,
        preconditioner: &inverse,
        offset: &offset,
        radius: Radius::Dependent(&law),
        resultants: &[],
        diagonal: matrix.entries[0],
    };
    let solution = solve_discs(&problem, &start(n, 0), TIGHT, &unmonitored).unwrap();
    assert!(
        solution.converged && solution.iterations < 12,
        "{:?}",
        solution.history
    );
    assert!(violation(&matrix, &solution) < 1e-8);
    assert!(solution.state.contains(&DiscState::Rim));
}

#[test]
fn refuses_bad_shapes_and_bad_numbers() {
    let matrix = dominant(4, 3);
    let mut problem = DiscProblem {
        operator: &matrix,
        rough: &matrix,
        preconditioner: &matrix,
        offset: &[0.0; 3],
        radius: Radius::Fixed(&[1.0, 1.0]),
        resultants: &[],
        diagonal: 1.0,
    };
    let message = |p: &DiscProblem<'_>| {
        solve_discs(p, &start(2, 0), TIGHT, &unmonitored)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(message(&problem), "offset has 3 entries, expected 4");
    problem.offset = &[0.0, f64::NAN, 0.0, 0.0];
    assert_eq!(
        message(&problem),
        "offset[1] is NaN, a finite number is needed"
    );
}

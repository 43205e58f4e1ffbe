// SPDX-License-Identifier: MIT OR Apache-2.0
//! A string pulled down onto a round obstacle, solved twice: by active sets with the matrix, and by bounded
//! conjugate gradients that know only products.

use mtb_complementarity::{bounded, linear};
use mtb_operator::unmonitored;

/// Inner nodes.
const N: usize = 99;

fn main() -> Result<(), mtb_complementarity::Error> {
    let h = 1.0 / (N + 1) as f64;
    // sagging of a string under a unit load at node j, held at both ends: Green's function
    let green = |i: usize, j: usize| {
        let (x, y) = ((i + 1) as f64 * h, (j + 1) as f64 * h);
        x.min(y) * (1.0 - x.max(y)) * h
    };
    let matrix: Vec<f64> = (0..N * N).map(|k| green(k / N, k % N)).collect();
    // the string, pulled down by its weight, above the obstacle; contact pushes it back up
    let gap: Vec<f64> = (0..N)
        .map(|i| {
            let x = (i + 1) as f64 * h;
            let (weight, obstacle) = (4.0, -0.2 - 2.0 * (x - 0.5).powi(2));
            -0.5 * weight * x * (1.0 - x) - obstacle
        })
        .collect();

    let problem = linear::Problem {
        matrix: &matrix,
        offset: &gap,
        border: None,
        symmetric: true,
        limit: None,
    };
    let by_sets = linear::solve(&problem, &linear::Options::default(), &unmonitored)?;
    assert_eq!(by_sets.status, linear::Status::Solved);

    let product = |p: &[f64], w: &mut [f64]| {
        for (row, w) in matrix.chunks_exact(N).zip(w) {
            *w = row.iter().zip(p).map(|(a, p)| a * p).sum();
        }
    };
    // the inverse of the matrix is the stiffness of the string
    let stiffness = |_: &[bool], w: &[f64], p: &mut [f64]| {
        for i in 0..N {
            let left = if i > 0 { w[i - 1] } else { 0.0 };
            let right = if i + 1 < N { w[i + 1] } else { 0.0 };
            p[i] = (2.0 * w[i] - left - right) / (h * h);
        }
    };
    let by_gradients = bounded::solve(
        &product,
        &stiffness,
        &bounded::Problem {
            offset: &gap,
            modes: &[],
        },
        vec![1.0; N],
        bounded::Options {
            tolerance: 1e-10,
            max_iterations: 500,
        },
        &unmonitored,
    )?;
    assert_eq!(by_gradients.status, bounded::Status::Solved);

    let touching = by_sets.pressure.iter().filter(|p| **p > 0.0).count();
    println!(
        "{touching} of {N} nodes touch; {} active sets, {} steps of conjugate gradients",
        by_sets.iterations, by_gradients.iterations
    );
    let apart = by_sets
        .pressure
        .iter()
        .zip(&by_gradients.pressure)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    println!("largest difference of the pressures {apart:e}");
    assert!(apart < 1e-6);
    Ok(())
}

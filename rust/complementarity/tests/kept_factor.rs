// SPDX-License-Identifier: MIT OR Apache-2.0
//! A factor that is kept serves the same matrix, and no other one.

use std::sync::Arc;

use mtb_complementarity::linear::{KeptFactor, Options, Problem, Solution, Status, solve};
use mtb_operator::unmonitored;

const N: usize = 12;

/// Springs that couple by the inverse of their distance, `stiffer` ones on their own.
fn matrix(stiffer: f64, skew: f64) -> Vec<f64> {
    (0..N * N)
        .map(|k| {
            let (i, j) = ((k / N) as f64, (k % N) as f64);
            let own = if k % (N + 1) == 0 { 3.0 + stiffer } else { 0.0 };
            own + 1.0 / (1.0 + (i - j).abs()) + if i > j { skew } else { 0.0 }
        })
        .collect()
}

fn solved(
    matrix: &[f64],
    symmetric: bool,
    pushed: f64,
    kept: Option<&Arc<KeptFactor>>,
) -> Solution {
    let offset: Vec<f64> = (0..N).map(|i| 0.4 * i as f64 - pushed).collect();
    let problem = Problem {
        matrix,
        offset: &offset,
        border: None,
        symmetric,
        limit: None,
    };
    let options = Options {
        start: Some((0..N).map(|i| i < 4).collect()),
        kept: kept.cloned(),
    };
    let found = solve(&problem, &options, &unmonitored).unwrap();
    assert_eq!(found.status, Status::Solved);
    found
}

#[test]
fn it_changes_nothing() {
    let kept = Arc::new(KeptFactor::default());
    for (stiffer, skew, symmetric, pushed) in [
        (0.0, 0.0, true, 1.5),
        (0.0, 0.0, true, 1.6),
        (0.0, 0.0, false, 1.6),
        (1.0, 0.0, true, 1.6),
        (1.0, 0.1, false, 1.6),
        (1.0, 0.1, false, 3.5),
        (0.0, 0.0, true, 1.5),
    ] {
        let matrix = matrix(stiffer, skew);
        let [with, without] =
            [Some(&kept), None].map(|kept| solved(&matrix, symmetric, pushed, kept));
        assert_eq!(with.pressure, without.pressure);
        assert_eq!(with.slack, without.slack);
        // what is solved satisfies its own conditions
        for i in 0..N {
            let row = &matrix[i * N..(i + 1) * N];
            let pressed: f64 = row.iter().zip(&with.pressure).map(|(a, p)| a * p).sum();
            let slack = pressed + 0.4 * i as f64 - pushed;
            assert!(with.pressure[i] >= 0.0 && slack > -1e-12);
            assert!(with.pressure[i] * slack < 1e-12);
        }
    }
}

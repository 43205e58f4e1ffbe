// SPDX-License-Identifier: MIT OR Apache-2.0
//! The staggered scheme: where it converges it solves the doubly counted problem, and its limit is the predicted one.

use mtb_complementarity::linear::{Options, Problem, solve};
use mtb_contact::staggered::{
    Staggered, StaggeredOptions, StaggeredStatus, best_factor, staggered,
};
use mtb_operator::unmonitored;

const N: usize = 12;

/// A smooth positive definite matrix with decay length `l`.
fn smooth(scale: f64, l: f64) -> Vec<f64> {
    (0..N * N)
        .map(|k| scale * (-(((k / N) as f64) - (k % N) as f64).abs() / l).exp())
        .collect()
}

fn problem<'a>(s: &'a [f64], t: &'a [f64], gap: &'a [f64]) -> Staggered<'a> {
    Staggered {
        half_spaces: s,
        structure: t,
        gap,
        area: &[1.0; N],
        motion: &[],
        balance: &[],
        target: &[],
    }
}

fn options(factor: Option<f64>, anderson_depth: usize) -> StaggeredOptions {
    StaggeredOptions {
        factor,
        max_iterations: 3000,
        tolerance: 1e-12,
        anderson_depth,
    }
}

#[test]
fn the_fixed_point_counts_both_compliances() {
    let (s, t) = (smooth(1.0, 0.5), smooth(3.0, 6.0));
    let gap: Vec<f64> = (0..N)
        .map(|i| -1.0 + 0.25 * ((i as f64 - 4.0) / 4.0).powi(2))
        .collect();
    let problem = problem(&s, &t, &gap);
    let both: Vec<f64> = s.iter().zip(&t).map(|(s, t)| s + t).collect();
    let direct = Problem {
        matrix: &both,
        offset: &gap,
        border: None,
        symmetric: true,
        limit: None,
    };
    let direct = solve(&direct, &Options::default(), &unmonitored).unwrap();
    for options in [options(None, 0), options(None, 5), options(Some(1.0), 8)] {
        let s = staggered(&problem, &options, &unmonitored).unwrap();
        assert_eq!(s.status, StaggeredStatus::Converged, "{options:?}");
        for (a, b) in s.contact.pressure.iter().zip(&direct.pressure) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
}

#[test]
fn below_the_predicted_factor_it_never_settles() {
    let (s, t) = (smooth(1.0, 0.5), smooth(3.0, 6.0));
    // full contact, so that the set does not change and the prediction is exact
    let gap = vec![-1.0; N];
    let problem = problem(&s, &t, &gap);
    let (best, limit) = best_factor(&problem, &[1.0; N], &unmonitored).unwrap();
    assert!(limit < best);
    let run = |factor| staggered(&problem, &options(Some(factor), 0), &unmonitored).unwrap();
    let above = run(1.05 * limit);
    assert_eq!(above.status, StaggeredStatus::Converged);
    assert_ne!(run(0.9 * limit).status, StaggeredStatus::Converged);
    assert!(run(best).history.len() <= above.history.len());
}

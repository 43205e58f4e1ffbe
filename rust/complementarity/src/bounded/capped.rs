// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pressures with a bound from above as well.

use mtb_operator::Monitor;

use super::solver::{Inverse, Product, solve};
use super::{Mode, Options, Problem, Solution, Status};
use crate::error::{Error, check};

/// Rounds of active sets at most.
const ROUNDS: usize = 100;

/// Residual to which a problem is solved while the set at the cap still changes.
const ROUGH: f64 = 1e-3;

/// Share of the cap by which rounding may take a pressure beyond it.
const ROUNDING: f64 = 1e-10;

/// How much wider than all others the gap of a point at the cap counts, so that it takes no part.
const FAR: f64 = 1e6;

/// Solves a problem in which `p <= cap` holds as well: `w` is zero where `0 < p < cap`, not negative where `p = 0` and
/// not positive where `p = cap`.
///
/// The points at the cap are an active set: the others are solved for with these held, points that pass the cap come
/// to them, and points that open there leave them. The slack of a point at the cap tells how far it gave way
/// beyond `A p`.
///
/// # Errors
/// As [`solve`].
pub fn solve_capped(
    apply: Product<'_>,
    precondition: Inverse<'_>,
    problem: &Problem<'_>,
    cap: f64,
    start: Vec<f64>,
    options: Options,
    monitor: Monitor<'_>,
) -> Result<Solution, Error> {
    let n = problem.offset.len();
    check("cap", &[cap], 1)?;
    problem.check(&start)?;
    let mut capped: Vec<bool> = start.iter().map(|p| *p >= cap).collect();
    if !leaves_a_load(problem, &capped, cap) {
        capped.fill(false);
    }
    let mut pressure = start;
    let (mut iterations, mut products, mut preconditionings) = (0, 0, 0);
    let mut history = Vec::new();
    let mut tolerance = options.tolerance.max(ROUGH);
    let mut round = 0;
    loop {
        round += 1;
        let (offset, modes) = without(apply, problem, &capped, cap);
        let masked = |x: &[f64], y: &mut [f64]| {
            apply(x, y);
            for (y, c) in y.iter_mut().zip(&capped) {
                if *c {
                    *y = 0.0;
                }
            }
        };
        let first: Vec<f64> = (0..n)
            .map(|i| if capped[i] { 0.0 } else { pressure[i].min(cap) })
            .collect();
        let inner = Problem {
            offset: &offset,
            modes: &modes,
        };
        let rough = Options {
            tolerance,
            ..options
        };
        let mut found = solve(&masked, precondition, &inner, first, rough, monitor)?;
        if found.status == Status::Unreachable {
            // balance is restored by factors: where none helps, what is left to carry goes to all others
            let even = capped.iter().map(|c| f64::from(u8::from(!c))).collect();
            found = solve(&masked, precondition, &inner, even, rough, monitor)?;
        }
        iterations += found.iterations;
        products += found.products + 2;
        preconditionings += found.preconditionings;
        history.extend(&found.history);
        pressure = found.pressure;
        for (p, c) in pressure.iter_mut().zip(&capped) {
            if *c {
                *p = cap;
            }
        }
        let (slack, size) = slack(apply, problem, &pressure, &found.motion);
        let next: Vec<bool> = (0..n)
            .map(|i| {
                if capped[i] {
                    slack[i] <= tolerance * size
                } else {
                    pressure[i] > cap * (1.0 + ROUNDING)
                }
            })
            .collect();
        let is_solved = found.status == Status::Solved;
        let has_changed = next != capped;
        if is_solved && has_changed && round < ROUNDS && leaves_a_load(problem, &next, cap) {
            capped = next;
        } else if is_solved && !has_changed && tolerance > options.tolerance {
            tolerance = options.tolerance;
        } else {
            let status = match found.status {
                Status::Solved if has_changed => Status::Unreachable,
                status => status,
            };
            return Ok(Solution {
                status,
                pressure,
                slack,
                motion: found.motion,
                iterations,
                products,
                preconditionings,
                residual: found.residual,
                history,
            });
        }
    }
}

/// Whether the points at the cap leave something of the first balance, that of the force, for the others.
fn leaves_a_load(problem: &Problem<'_>, capped: &[bool], cap: f64) -> bool {
    problem
        .modes
        .first()
        .is_none_or(|mode| mode.target - held(&mode.shape, capped, cap) > 0.0)
}

/// What the points at the cap carry of a balance.
fn held(shape: &[f64], capped: &[bool], cap: f64) -> f64 {
    let own = shape.iter().zip(capped).filter(|(_, c)| **c);
    own.map(|(n, _)| cap * n).sum()
}

/// Offset and motions of the points below the cap.
fn without(
    apply: Product<'_>,
    problem: &Problem<'_>,
    capped: &[bool],
    cap: f64,
) -> (Vec<f64>, Vec<Mode>) {
    let load: Vec<f64> = capped.iter().map(|c| if *c { cap } else { 0.0 }).collect();
    let mut offset = vec![0.0; load.len()];
    apply(&load, &mut offset);
    for (own, b) in offset.iter_mut().zip(problem.offset) {
        *own += b;
    }
    let largest = offset.iter().fold(0.0_f64, |m, b| m.max(b.abs()));
    for (own, c) in offset.iter_mut().zip(capped) {
        if *c {
            *own = FAR * largest;
        }
    }
    let modes = problem.modes.iter().map(|mode| Mode {
        target: mode.target - held(&mode.shape, capped, cap),
        shape: mode
            .shape
            .iter()
            .zip(capped)
            .map(|(n, c)| if *c { 0.0 } else { *n })
            .collect(),
    });
    (offset, modes.collect())
}

/// The slack of all points, and the root mean square of `A p` where there is pressure.
fn slack(
    apply: Product<'_>,
    problem: &Problem<'_>,
    pressure: &[f64],
    motion: &[f64],
) -> (Vec<f64>, f64) {
    let mut slack = vec![0.0; pressure.len()];
    apply(pressure, &mut slack);
    let loaded = slack.iter().zip(pressure).filter(|(_, p)| **p > 0.0);
    let (squares, count) = loaded.fold((0.0, 0_usize), |(s, n), (u, _)| (s + u * u, n + 1));
    for (w, b) in slack.iter_mut().zip(problem.offset) {
        *w += b;
    }
    for (mode, c) in problem.modes.iter().zip(motion) {
        for (w, n) in slack.iter_mut().zip(&mode.shape) {
            *w -= c * n;
        }
    }
    (slack, (squares / count.max(1) as f64).sqrt())
}

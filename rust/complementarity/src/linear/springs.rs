// SPDX-License-Identifier: MIT OR Apache-2.0
//! Problems in which contact holds some of the free motions weakly or not at all.

use faer::Mat;
use mtb_operator::Monitor;

use super::active_set::{Options, SINGULAR, balanced, closed, flip, settled, solve};
use super::dense::Factor;
use super::limited::Sides;
use super::problem::{Border, Problem, Solution, Status};
use crate::error::Error;

/// Stiffness of the springs, relative to the stiffest point on each motion ...
const STIFFNESS: f64 = 1e-5;
/// ... which falls so much from solve to solve ...
const SOFTER: f64 = 0.1;
/// ... in so many solves, each from where the last one let the motions.
const SOLVES: usize = 8;

/// Holds each free motion by a soft spring whose relaxed length follows the motion: the proximal point method
/// [Rockafellar1976].
///
/// With springs the motions can be eliminated, and what is left has a solution on every set of points, the empty
/// one included. The springs find the points in contact; without springs these points then give the pressures. A
/// motion on which nothing works stays as near to zero as the gaps let it. `None` where no solution was found.
///
/// # Errors
/// As [`solve`].
pub(super) fn by_springs(
    problem: &Problem<'_>,
    border: Border<'_>,
    monitor: Monitor<'_>,
) -> Result<Option<Solution>, Error> {
    let (n, m) = (problem.dim(), problem.motions());
    let stiffest = |j: usize| {
        let each = (0..n).map(|i| {
            let product = border.motion[j * n + i] * border.balance[j * n + i];
            (product / problem.matrix[i * n + i]).abs()
        });
        each.fold(0.0, f64::max)
    };
    let stiffness: Vec<f64> = (0..m).map(stiffest).collect();
    if stiffness.contains(&0.0) {
        return Ok(None);
    }
    let mut motion = vec![0.0; m];
    let mut start = None;
    let mut soft = STIFFNESS;
    for _ in 0..SOLVES {
        let mut matrix = problem.matrix.to_vec();
        let mut offset = problem.offset.to_vec();
        for j in 0..m {
            let spring = soft * stiffness[j];
            let moved = motion[j] + border.target[j] / spring;
            let balance = &border.balance[j * n..(j + 1) * n];
            let shapes = border.motion[j * n..(j + 1) * n].iter();
            for ((row, offset), shape) in matrix.chunks_exact_mut(n).zip(&mut offset).zip(shapes) {
                *offset -= shape * moved;
                if *shape != 0.0 {
                    for (a, k) in row.iter_mut().zip(balance) {
                        *a += shape / spring * k;
                    }
                }
            }
        }
        let held = Problem {
            matrix: &matrix,
            offset: &offset,
            border: None,
            symmetric: false,
            limit: None,
        };
        let found = solve(&held, &Options { start, kept: None }, monitor)?;
        if found.status != Status::Solved {
            return Ok(None);
        }
        for j in 0..m {
            let balance = &border.balance[j * n..(j + 1) * n];
            let sum: f64 = balance
                .iter()
                .zip(&found.pressure)
                .map(|(k, p)| k * p)
                .sum();
            motion[j] += (border.target[j] - sum) / (soft * stiffness[j]);
        }
        let mut active = Sides::of_pressure(&found.pressure, None);
        let released = released(problem, border, &active.closed, &motion, monitor)?;
        if let Some(mut point) = released
            && flip(&mut active, &point, None, 0) == 0
        {
            point = settled(problem, point);
            point.by_lemke = found.by_lemke;
            if point.residual <= SINGULAR {
                return Ok(Some(point));
            }
        }
        start = Some(active.closed);
        soft *= SOFTER;
    }
    Ok(None)
}

/// Pressures on a set without springs, and the motions nearest to `motion` that close its gaps.
fn released(
    problem: &Problem<'_>,
    border: Border<'_>,
    active: &[bool],
    motion: &[f64],
    monitor: Monitor<'_>,
) -> Result<Option<Solution>, Error> {
    let (n, m) = (problem.dim(), problem.motions());
    let set: Vec<usize> = (0..n).filter(|&i| active[i]).collect();
    let k = set.len();
    let mut pressure = vec![0.0; n];
    if k == 0 {
        return Ok(Some(closed(problem, &set, pressure, motion.to_vec(), 1.0)));
    }
    // on top of the motions so far
    let gap = problem.slack(&pressure, motion);
    let factor = Factor::of(problem.matrix, n, &set, problem.symmetric, monitor)?;
    let rhs = Mat::from_fn(k, 1 + m, |i, j| match j {
        0 => -gap[set[i]],
        j => border.motion[(j - 1) * n + set[i]],
    });
    let solved = factor.solve(rhs.as_ref(), monitor)?;
    let works = |row: usize, column: usize| {
        let each = (0..k).map(|i| border.balance[row * n + set[i]] * solved[(i, column)]);
        each.sum::<f64>()
    };
    let small = Mat::from_fn(m, m, |i, j| works(i, j + 1));
    let target: Vec<f64> = (0..m).map(|i| border.target[i] - works(i, 0)).collect();
    let (step, sign) = balanced(&small, &target, border, n, monitor)?;
    let motion: Vec<f64> = motion.iter().zip(&step).map(|(c, s)| c + s).collect();
    for (i, &point) in set.iter().enumerate() {
        let moved = (0..m).map(|j| solved[(i, j + 1)] * step[j]);
        pressure[point] = solved[(i, 0)] + moved.sum::<f64>();
    }
    if pressure.iter().chain(&motion).any(|v| !v.is_finite()) {
        return Ok(None);
    }
    Ok(Some(closed(
        problem,
        &set,
        pressure,
        motion,
        sign * factor.determinant_sign(),
    )))
}

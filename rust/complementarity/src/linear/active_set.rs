// SPDX-License-Identifier: MIT OR Apache-2.0
use std::collections::HashSet;
use std::sync::Arc;

use faer::{Mat, Par};
use mtb_operator::dense::Lu;
use mtb_operator::{Monitor, report};

use super::dense::{Factor, KeptFactor};
use super::existence::{reachable, reachable_within};
use super::lemke::lemke;
use super::limited::{ROUNDING, Sides, carries, lemke_limited, rest};
use super::problem::{Border, Problem, Solution, Status};
use super::springs::by_springs;
use crate::error::Error;

/// What the active-set method starts from and when it gives up.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Pressures that are positive at the start (n); all of them where `None`.
    pub start: Option<Vec<bool>>,
    /// The factor of the last problem, which serves if it is of the same matrix and the same pressures.
    pub kept: Option<Arc<KeptFactor>>,
}

/// Residual above which a set was singular: its signs mean nothing.
pub(super) const SINGULAR: f64 = 1e-9;
/// Stiffness of a motion, in parts of that of the stiffest, below which a set does not hold it at all: two rows
/// of points a millionth of the body apart still have as much.
const LOOSE: f64 = 1e-12;
/// Smallest gap in parts of the largest above which bodies stand far apart.
const FAR: f64 = 0.5;
/// Sets the active-set method may visit; it needs about ten where a solution exists.
const SETS: usize = 200;

/// Solves a linear complementarity problem by active sets, and by Lemke's method where those cycle.
///
/// The active-set method solves with the pressures believed positive, then moves every pressure and
/// every slack with the wrong sign to the other side, which is Newton's method on
/// `min(p, w) = 0` [Hintermueller2002]. Pressures beyond their limit are held there, until their slack is above zero. A set that returns means that it will not end; Lemke's method
/// [Cottle2009, section 4.4] then decides whether a solution exists.
///
/// # Errors
/// Wrong lengths, numbers that are not finite, an interruption by the monitor. That no solution exists is
/// a [`Status`], not an error.
///
/// # Example
/// ```
/// use mtb_complementarity::linear::{Options, Problem, Status, solve};
/// let problem = Problem {
///     matrix: &[2.0, 1.0, 1.0, 2.0],
///     offset: &[-2.0, 1.0],
///     border: None,
///     symmetric: true,
///     limit: None,
/// };
/// let solution = solve(&problem, &Options::default(), &mtb_operator::unmonitored)?;
/// assert_eq!(solution.status, Status::Solved);
/// assert!((solution.pressure[0] - 1.0).abs() < 1e-12 && solution.pressure[1] == 0.0);
/// assert!(solution.slack[0] == 0.0 && (solution.slack[1] - 2.0).abs() < 1e-12);
/// # Ok::<(), mtb_complementarity::Error>(())
/// ```
pub fn solve(
    problem: &Problem<'_>,
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<Solution, Error> {
    problem.check()?;
    if let Some(border) = problem.border {
        if !reachable(border.balance, border.target) {
            return Ok(nothing(problem, Status::Unreachable));
        }
        if !problem.limit.is_none_or(|limit| carries(border, limit)) {
            return Ok(nothing(problem, Status::Overloaded));
        }
    }
    let shifted = problem
        .border
        .and_then(|border| from_touching(problem.offset, border.motion));
    let mut found = match &shifted {
        None => searched(problem, options, monitor)?,
        Some((_, offset)) => searched(&Problem { offset, ..*problem }, options, monitor)?,
    };
    if let Some((moved, _)) = shifted {
        found
            .motion
            .iter_mut()
            .zip(moved)
            .for_each(|(c, m)| *c += m);
    }
    found.status = told(found.status, problem.border, problem.limit);
    Ok(found)
}

/// How a search ended, where pressures within their limit may not carry the load.
pub(super) fn told(status: Status, border: Option<Border<'_>>, limit: Option<&[f64]>) -> Status {
    match (border, limit) {
        (Some(border), Some(limit))
            if status != Status::Solved
                && !reachable_within(border.balance, border.target, limit) =>
        {
            Status::Overloaded
        }
        _ => status,
    }
}

/// Motions that bring bodies which stand far apart together, and the offset from there on: so far away the
/// displacements by the load would be lost in the rounding of the gaps. `None` where they do not stand so.
///
/// `motion` are the columns of a [`Border`].
pub fn from_touching(offset: &[f64], motion: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
    let n = offset.len();
    let m = motion.len() / n.max(1);
    // each row in its own unit: rows carry weights
    let unit = |i: usize| (0..m).fold(0.0_f64, |most, j| most.max(motion[j * n + i].abs()));
    let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
    for (i, offset) in offset.iter().enumerate() {
        let unit = unit(i);
        let height = if unit > 0.0 { offset / unit } else { 0.0 };
        (low, high) = (low.min(height), high.max(height));
    }
    if m == 0 || low <= FAR * high {
        return None;
    }
    let weight: Vec<f64> = (0..n).map(|i| 1.0 / unit(i)).collect();
    let columns = Mat::from_fn(n, m, |i, j| weight[i] * motion[j * n + i]);
    let svd = columns.thin_svd().ok()?;
    let moved = svd.pseudoinverse() * Mat::from_fn(n, 1, |i, _| weight[i] * offset[i]);
    let moved: Vec<f64> = (0..m).map(|j| moved[(j, 0)]).collect();
    let mut rest = offset.to_vec();
    for (column, by) in motion.chunks_exact(n).zip(&moved) {
        rest.iter_mut().zip(column).for_each(|(o, c)| *o -= c * by);
    }
    Some((moved, rest))
}

fn searched(
    problem: &Problem<'_>,
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<Solution, Error> {
    let n = problem.dim();
    let active = match &options.start {
        Some(start) if start.len() != n => {
            return Err(Error::Shape {
                name: "start",
                expected: n,
                found: start.len(),
            });
        }
        Some(start) if start.iter().filter(|&&a| a).count() > problem.motions() => start.clone(),
        _ => vec![true; n],
    };
    let mut sides = Sides::of(active);
    let mut visited = HashSet::new();
    for iteration in 1..=SETS {
        let Some(mut point) = on_sides(problem, &sides, options.kept.as_deref(), monitor)? else {
            break;
        };
        let needed = problem.motions().max(1);
        let changes = flip(&mut sides, &point, problem.limit, needed);
        if changes == 0 {
            point = settled(problem, point);
            point.iterations = iteration;
            // no wrong sign is left, but the equations of a singular set may not hold
            if point.residual <= SINGULAR {
                return Ok(point);
            }
            break;
        }
        report(monitor, iteration, changes as f64 / n as f64)?;
        if !visited.insert(sides.clone()) || sides.is_open() && problem.motions() > 0 {
            break;
        }
    }
    if let Some(limit) = problem.limit {
        return lemke_limited(problem, limit, monitor);
    }
    let found = lemke(problem, monitor)?;
    if found.status == Status::IterationLimit
        && let Some(border) = problem.border
        && let Some(held) = by_springs(problem, border, monitor)?
    {
        return Ok(held);
    }
    Ok(found)
}

fn nothing(problem: &Problem<'_>, status: Status) -> Solution {
    Solution {
        status,
        pressure: vec![0.0; problem.dim()],
        slack: problem.offset.to_vec(),
        motion: vec![0.0; problem.motions()],
        iterations: 0,
        residual: f64::INFINITY,
        by_lemke: false,
        determinant_sign: 1.0,
    }
}

/// Pressures that close every gap that is closed and meet the balance, while others are held at the limit; `None`
/// where they do not exist.
fn on_sides(
    problem: &Problem<'_>,
    sides: &Sides,
    kept: Option<&KeptFactor>,
    monitor: Monitor<'_>,
) -> Result<Option<Solution>, Error> {
    if !sides.is_held() {
        return stationary(problem, &sides.closed, kept, monitor);
    }
    let load = sides.load(problem.limit);
    let (offset, target) = rest(problem, &load);
    let others = Problem {
        offset: &offset,
        border: problem.border.map(|border| Border {
            target: &target,
            ..border
        }),
        ..*problem
    };
    let mut found = stationary(&others, &sides.closed, kept, monitor)?;
    if let Some(point) = &mut found {
        point
            .pressure
            .iter_mut()
            .zip(&load)
            .for_each(|(p, l)| *p += l);
    }
    Ok(found)
}

/// Pressures that close every gap of the active set and meet the balance; `None` where they do not exist.
pub(super) fn stationary(
    problem: &Problem<'_>,
    active: &[bool],
    kept: Option<&KeptFactor>,
    monitor: Monitor<'_>,
) -> Result<Option<Solution>, Error> {
    let n = problem.dim();
    let m = problem.motions();
    let set: Vec<usize> = (0..n).filter(|&i| active[i]).collect();
    let k = set.len();
    if k < m {
        return Ok(None);
    }
    let (matrix, symmetric) = (problem.matrix, problem.symmetric);
    let factor = match kept {
        Some(kept) => kept.of(matrix, n, &set, symmetric, monitor)?,
        None => Arc::new(Factor::of(matrix, n, &set, symmetric, monitor)?),
    };
    let rhs = Mat::from_fn(k, 1 + m, |i, j| match (j, problem.border) {
        (0, _) | (_, None) => -problem.offset[set[i]],
        (j, Some(border)) => border.motion[(j - 1) * n + set[i]],
    });
    let solved = factor.solve(rhs.as_ref(), monitor)?;
    let mut motion = vec![0.0; m];
    let mut sign = factor.determinant_sign();
    if let Some(border) = problem.border {
        // K^T A^-1 N c = f + K^T A^-1 b
        let weigh = |row: usize, column: usize| -> f64 {
            (0..k)
                .map(|i| border.balance[row * n + set[i]] * solved[(i, column)])
                .sum()
        };
        let small = Mat::from_fn(m, m, |i, j| weigh(i, j + 1));
        let target: Vec<f64> = (0..m).map(|i| border.target[i] - weigh(i, 0)).collect();
        let (balanced, of_border) = balanced(&small, &target, border, n, monitor)?;
        motion = balanced;
        sign *= of_border;
    }
    let mut pressure = vec![0.0; n];
    for (i, &point) in set.iter().enumerate() {
        pressure[point] =
            solved[(i, 0)] + (0..m).map(|j| solved[(i, j + 1)] * motion[j]).sum::<f64>();
    }
    if pressure.iter().chain(&motion).any(|v| !v.is_finite()) {
        return Ok(None);
    }
    Ok(Some(closed(problem, &set, pressure, motion, sign)))
}

/// The point at which the gaps of `set` are closed, with the relative gap that is left there.
pub(super) fn closed(
    problem: &Problem<'_>,
    set: &[usize],
    pressure: Vec<f64>,
    motion: Vec<f64>,
    determinant_sign: f64,
) -> Solution {
    let mut slack = problem.slack(&pressure, &motion);
    let left = set
        .iter()
        .fold(0.0_f64, |most, &i| most.max(slack[i].abs()));
    let scale = problem.slack_scale(&slack, &motion);
    for &point in set {
        slack[point] = 0.0;
    }
    Solution {
        status: Status::Solved,
        pressure,
        slack,
        motion,
        iterations: 0,
        residual: if scale > 0.0 { left / scale } else { left },
        by_lemke: false,
        determinant_sign,
    }
}

/// Motions (m) that meet the balances `small . motion = target`, and the sign of the determinant.
///
/// A set may leave a motion free: a body on one row of points can roll about it. Then many motions meet the
/// same balance, or none does; of the former the shortest is taken, and of the latter the nearest, which
/// does not meet it and so has a residual.
pub(super) fn balanced(
    small: &Mat<f64>,
    target: &[f64],
    border: Border<'_>,
    n: usize,
    monitor: Monitor<'_>,
) -> Result<(Vec<f64>, f64), Error> {
    let m = target.len();
    // the scales of all points, not of the set: what is rounding beside them is no hold
    let scales = |columns: &[f64]| -> Vec<f64> {
        columns
            .chunks_exact(n.max(1))
            .map(|c| {
                let largest = c.iter().fold(0.0_f64, |s, x| s.max(x.abs()));
                if largest > 0.0 { largest } else { 1.0 }
            })
            .collect()
    };
    let (rows, columns) = (scales(border.balance), scales(border.motion));
    let scaled = Mat::from_fn(m, m, |i, j| small[(i, j)] / (rows[i] * columns[j]));
    let right = Mat::from_fn(m, 1, |i, _| target[i] / rows[i]);
    let Ok(svd) = scaled.svd() else {
        return Ok((vec![f64::NAN; m], 1.0));
    };
    let held = |value: f64| value > LOOSE * svd.S()[0];
    let (found, sign) = if (0..m).all(|i| held(svd.S()[i])) {
        let lu = Lu::new(scaled.clone(), Par::Seq, monitor)?;
        (lu.solve_few(right.as_ref(), Par::Seq), lu.sign())
    } else {
        let along = svd.U().transpose() * &right;
        let kept = Mat::from_fn(m, 1, |i, _| {
            let value = svd.S()[i];
            if held(value) {
                along[(i, 0)] / value
            } else {
                0.0
            }
        });
        (svd.V() * kept, 1.0)
    };
    let motion = (0..m).map(|j| found[(j, 0)] / columns[j]).collect();
    Ok((motion, sign))
}

/// Moves what is beyond its bounds to the other side; returns how much that was.
pub(super) fn flip(
    sides: &mut Sides,
    point: &Solution,
    limit: Option<&[f64]>,
    needed: usize,
) -> usize {
    let largest = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let least = [
        ROUNDING * largest(&point.pressure),
        ROUNDING * largest(&point.slack),
    ];
    sides.turn(&point.pressure, &point.slack, limit, least, needed)
}

/// The point without what is rounding: with what is negative, and pressures that are nothing else, set to zero. Its
/// residual is the largest of what is left of the gaps, and of the conditions before and after.
pub(super) fn settled(problem: &Problem<'_>, mut point: Solution) -> Solution {
    let of = |s: &Solution| problem.residual(&s.pressure, &s.slack, &s.motion);
    let before = of(&point);
    let least = ROUNDING * point.pressure.iter().copied().fold(0.0, f64::max);
    for p in &mut point.pressure {
        *p = if *p > least { *p } else { 0.0 };
    }
    if let Some(limit) = problem.limit {
        for (p, limit) in point.pressure.iter_mut().zip(limit) {
            *p = p.min(*limit);
        }
    }
    for (i, w) in point.slack.iter_mut().enumerate() {
        let is_held = problem.limit.is_some_and(|l| point.pressure[i] >= l[i]);
        *w = if is_held { w.min(0.0) } else { w.max(0.0) };
    }
    point.residual = point.residual.max(before).max(of(&point));
    point
}

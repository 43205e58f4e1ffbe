// SPDX-License-Identifier: MIT OR Apache-2.0
//! Active sets without a matrix: each set is solved by products, in Krylov spaces.

use std::collections::HashSet;

use faer::Mat;
use mtb_operator::{Map, Monitor, krylov::gmres, report};

use super::active_set::{balanced, told};
use super::existence::reachable;
use super::limited::{Sides, carries, targets};
use super::problem::{Border, Problem, Solution, Status};
use crate::error::{Error, check};

/// A problem as [`Problem`] has it, of which only products with its matrix are known.
pub struct ByProducts<'a> {
    /// Overwrites its second argument with `A` times the first one (n each).
    pub multiply: &'a (dyn Fn(&[f64], &mut [f64]) + Sync),
    /// About the diagonal of `A`, positive (n).
    pub diagonal: &'a [f64],
    /// Overwrites its second argument with about the inverse of `A` times the first one (n each), up to a factor; the
    /// diagonal stands for it where there is none.
    pub near_inverse: Option<&'a Map>,
    /// `b`, n.
    pub offset: &'a [f64],
    /// The free motions.
    pub border: Option<Border<'a>>,
    /// Largest pressures, as in [`Problem`] (n).
    pub limit: Option<&'a [f64]>,
}

/// Residual of a set, in parts of its right-hand side: while many points change sides, while some do, and in the
/// end.
const TOLERANCES: [f64; 3] = [1e-4, 1e-6, 1e-10];
/// Parts of the largest pressure and of the largest slack that count as nothing, for each part of the residual.
const SIGN: f64 = 30.0;
/// Sets that may be visited, and products for each.
const SETS: usize = 300;
const PRODUCTS: usize = 500;
/// Sets with no fewer wrong signs than the best one, after which points change sides one by one.
const PATIENCE: usize = 8;

/// The unknowns of a set: its pressures, then the motions, all in units of pressure. The motions are counted from
/// those that close the gaps of the set best without any pressure, so that digits are not lost on bodies that
/// move much farther than they deform.
struct Unknowns<'a> {
    problem: &'a ByProducts<'a>,
    set: Vec<usize>,
    /// Units of the balances and of the motions over that of the pressures.
    rows: Vec<f64>,
    columns: Vec<f64>,
    /// Mean of the diagonal.
    mean: f64,
    /// The motions that the unknown ones are counted from, scaled.
    shift: Vec<f64>,
}

impl<'a> Unknowns<'a> {
    fn new(
        problem: &'a ByProducts<'a>,
        active: &[bool],
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let n = problem.offset.len();
        let mean = problem.diagonal.iter().sum::<f64>() / n as f64;
        let largest = |column: &[f64]| column.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let scales = |columns: &[f64], by: f64| -> Vec<f64> {
            let sizes = columns.chunks_exact(n.max(1)).map(largest);
            sizes.map(|s| if s > 0.0 { by / s } else { by }).collect()
        };
        let (rows, columns) = problem.border.map_or_else(Default::default, |b| {
            (scales(b.balance, 1.0), scales(b.motion, mean))
        });
        let m = rows.len();
        let mut found = Self {
            problem,
            set: (0..n).filter(|&i| active[i]).collect(),
            rows,
            columns,
            mean,
            shift: vec![0.0; m],
        };
        if m > 0 {
            let gap = found.right();
            let k = found.set.len();
            let small = Mat::from_fn(m, m, |a, b| {
                (0..k)
                    .map(|i| found.motion(a, i) * found.motion(b, i))
                    .sum()
            });
            let rest: Vec<f64> = (0..m)
                .map(|j| -(0..k).map(|i| found.motion(j, i) * gap[i]).sum::<f64>())
                .collect();
            found.shift = scaled_motion(&small, &rest, monitor)?;
        }
        Ok(found)
    }

    fn motions(&self) -> usize {
        self.rows.len()
    }

    /// Closing of the gap of a point of the set by a motion, and its share in a balance, both scaled.
    fn border(&self, of: impl Fn(&Border<'a>) -> &'a [f64], j: usize, i: usize) -> f64 {
        let n = self.problem.offset.len();
        self.problem
            .border
            .as_ref()
            .map_or(0.0, |b| of(b)[j * n + self.set[i]])
    }

    fn motion(&self, j: usize, i: usize) -> f64 {
        self.border(|b| b.motion, j, i) * self.columns[j] / self.mean
    }

    fn balance(&self, j: usize, i: usize) -> f64 {
        // a mean over the set, as pressures are
        self.border(|b| b.balance, j, i) * self.rows[j]
    }

    /// A field (n) with the values of the points of the set, zero elsewhere.
    fn spread(&self, x: &[f64]) -> Vec<f64> {
        let mut field = vec![0.0; self.problem.offset.len()];
        for (&point, x) in self.set.iter().zip(x) {
            field[point] = *x;
        }
        field
    }

    /// Pressures (n) and motions (m) of scaled unknowns.
    fn open(&self, x: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let pressure = self.spread(x);
        let parts = x[self.set.len()..].iter().zip(&self.shift);
        let motion = parts.zip(&self.columns).map(|((x, s), c)| (x + s) * c);
        (pressure, motion.collect())
    }

    /// The unknowns of these pressures (n) and motions (m).
    fn close(&self, pressure: &[f64], motion: &[f64]) -> Vec<f64> {
        let own = self.set.iter().map(|&i| pressure[i]);
        let parts = motion.iter().zip(&self.columns).zip(&self.shift);
        own.chain(parts.map(|((c, s), shift)| c / s - shift))
            .collect()
    }

    fn apply(&self, x: &[f64], out: &mut [f64]) {
        let k = self.set.len();
        let pressure = self.spread(x);
        let mut moved = vec![0.0; pressure.len()];
        (self.problem.multiply)(&pressure, &mut moved);
        for (i, out) in out[..k].iter_mut().enumerate() {
            let by_motion: f64 = (0..self.motions())
                .map(|j| self.motion(j, i) * x[k + j])
                .sum();
            *out = moved[self.set[i]] / self.mean - by_motion;
        }
        for j in 0..self.motions() {
            out[k + j] = (0..k).map(|i| self.balance(j, i) * x[i]).sum();
        }
    }

    fn right(&self) -> Vec<f64> {
        let gaps = self.set.iter().enumerate().map(|(k, &i)| {
            let moved = self.shift.iter().enumerate();
            let by_shift: f64 = moved.map(|(j, s)| self.motion(j, k) * s).sum();
            by_shift - self.problem.offset[i] / self.mean
        });
        let target = self.problem.border.map_or(&[][..], |b| b.target);
        gaps.chain(target.iter().zip(&self.rows).map(|(f, r)| f * r))
            .collect()
    }
}

/// The shortest motions (m) with `small . motion = rest`, all of them scaled.
fn scaled_motion(small: &Mat<f64>, rest: &[f64], monitor: Monitor<'_>) -> Result<Vec<f64>, Error> {
    let one = vec![1.0; rest.len()];
    let unit = Border {
        motion: &one,
        balance: &one,
        target: rest,
    };
    Ok(balanced(small, rest, unit, 1, monitor)?.0)
}

/// About the inverse of the matrix of a set, or of its diagonal, with its border.
struct NearInverse<'a, 'b> {
    unknowns: &'b Unknowns<'a>,
    /// Of each motion what it does to the pressures.
    by_motion: Vec<Vec<f64>>,
    small: Mat<f64>,
}

impl<'a, 'b> NearInverse<'a, 'b> {
    fn new(unknowns: &'b Unknowns<'a>) -> Self {
        let (k, m) = (unknowns.set.len(), unknowns.motions());
        let mut found = Self {
            unknowns,
            by_motion: Vec::with_capacity(m),
            small: Mat::zeros(m, m),
        };
        for j in 0..m {
            let column: Vec<f64> = (0..k).map(|i| unknowns.motion(j, i)).collect();
            let pressures = found.pressures(&column);
            found.by_motion.push(pressures);
        }
        found.small = Mat::from_fn(m, m, |a, b| {
            let parts = found.by_motion[b].iter().enumerate();
            parts.map(|(i, p)| unknowns.balance(a, i) * p).sum::<f64>()
        });
        found
    }

    /// The pressures that give slacks (k) without a border.
    fn pressures(&self, slack: &[f64]) -> Vec<f64> {
        let (u, mean) = (self.unknowns, self.unknowns.mean);
        if let Some(invert) = u.problem.near_inverse {
            let mut found = vec![0.0; u.problem.offset.len()];
            invert(&u.spread(slack), &mut found);
            u.set.iter().map(|&i| mean * found[i]).collect()
        } else {
            let own = u.set.iter().map(|&i| mean / u.problem.diagonal[i]);
            own.zip(slack).map(|(d, s)| d * s).collect()
        }
    }

    fn apply(&self, x: &[f64], out: &mut [f64], monitor: Monitor<'_>) -> Result<(), Error> {
        let (u, k, m) = (self.unknowns, self.unknowns.set.len(), self.small.nrows());
        out[..k].copy_from_slice(&self.pressures(&x[..k]));
        if m > 0 {
            let rest: Vec<f64> = (0..m)
                .map(|j| x[k + j] - (0..k).map(|i| u.balance(j, i) * out[i]).sum::<f64>())
                .collect();
            let motion = scaled_motion(&self.small, &rest, monitor)?;
            for (column, amount) in self.by_motion.iter().zip(&motion) {
                for (out, p) in out.iter_mut().zip(column) {
                    *out += amount * p;
                }
            }
            out[k..].copy_from_slice(&motion);
        }
        Ok(())
    }
}

/// Solves as [`solve`](super::solve) does, by products with the matrix alone.
///
/// The sets are those of the method of active sets; each is solved by GMRES from the pressures of the last one,
/// roughly while the sets change. Where the number of wrong signs does not fall any more, the last wrong point alone
/// changes sides until it has fallen, which ends with a solution where every principal minor of the matrix is
/// positive [JudicePires1994]. The conditions hold to about 1e-8 of the largest pressure and gap. A problem that
/// visits too many sets, or one of fewer points than motions, ends with [`Status::IterationLimit`]: there is no
/// other method without the matrix. The sign of the determinant is not known, and given as 1. Products are counted
/// as iterations.
///
/// # Errors
/// Wrong lengths, numbers that are not finite, an interruption by the monitor.
pub fn solve_by_products(
    problem: &ByProducts<'_>,
    start: Option<&[bool]>,
    monitor: Monitor<'_>,
) -> Result<Solution, Error> {
    let n = problem.offset.len();
    check("offset", problem.offset, n)?;
    check("diagonal", problem.diagonal, n)?;
    if let Some(limit) = problem.limit {
        check("limit", limit, n)?;
    }
    let m = problem.border.map_or(0, |b| b.target.len());
    // the residual of a solution asks for no matrix
    let conditions = Problem {
        matrix: &[],
        offset: problem.offset,
        border: problem.border,
        symmetric: false,
        limit: problem.limit,
    };
    let mut point = Solution {
        status: Status::IterationLimit,
        pressure: vec![0.0; n],
        slack: problem.offset.to_vec(),
        motion: vec![0.0; m],
        iterations: 0,
        residual: f64::INFINITY,
        by_lemke: false,
        determinant_sign: 1.0,
    };
    if let Some(border) = problem.border {
        check("target", border.target, m)?;
        check("motion", border.motion, n * m)?;
        check("balance", border.balance, n * m)?;
        if !reachable(border.balance, border.target) {
            point.status = Status::Unreachable;
            return Ok(point);
        }
        if !problem.limit.is_none_or(|limit| carries(border, limit)) {
            point.status = Status::Overloaded;
            return Ok(point);
        }
    }
    let active = match start {
        Some(start) if start.len() != n => {
            return Err(Error::Shape {
                name: "start",
                expected: n,
                found: start.len(),
            });
        }
        Some(start) if start.iter().filter(|a| **a).count() > m => start.to_vec(),
        _ => vec![true; n],
    };
    let mut sides = Sides::of(active);
    let mut visited = HashSet::new();
    let mut stage = 0;
    let (mut fewest, mut patience) = (usize::MAX, PATIENCE);
    // of the slacks: on stiff bodies much smaller than their parts
    let mut scale = f64::INFINITY;
    for round in 1..=SETS {
        let (tolerance, is_last) = (TOLERANCES[stage], stage + 1 == TOLERANCES.len());
        let load = sides.load(problem.limit);
        let mut offset = vec![0.0; n];
        if sides.is_held() {
            (problem.multiply)(&load, &mut offset);
            point.iterations += 1;
        }
        offset
            .iter_mut()
            .zip(problem.offset)
            .for_each(|(o, b)| *o += b);
        let target = targets(problem.border, &load);
        let others = ByProducts {
            offset: &offset,
            border: problem.border.map(|border| Border {
                target: &target,
                ..border
            }),
            ..*problem
        };
        let unknowns = Unknowns::new(&others, &sides.closed, monitor)?;
        let k = unknowns.set.len();
        if k < m || k == 0 && m > 0 {
            break;
        }
        let near = NearInverse::new(&unknowns);
        let mut x = unknowns.close(&point.pressure, &point.motion);
        let right = unknowns.right();
        let mut residual = vec![0.0; k + m];
        unknowns.apply(&x, &mut residual);
        residual
            .iter_mut()
            .zip(&right)
            .for_each(|(r, b)| *r = b - *r);
        let size = right.iter().map(|b| b * b).sum::<f64>().sqrt();
        let mut failure = None;
        let mut interrupted = None;
        let report_of = gmres(
            |v, out| unknowns.apply(v, out),
            |v, out| {
                if let Err(error) = near.apply(v, out, monitor) {
                    failure = Some(error);
                }
                if let Err(error) = report(monitor, round, f64::NAN) {
                    interrupted = Some(error);
                }
            },
            &mut x,
            &mut residual,
            tolerance * size.min(scale / unknowns.mean),
            PRODUCTS,
        );
        if let Some(error) = interrupted {
            return Err(error.into());
        }
        if let Some(error) = failure {
            return Err(error);
        }
        let (mut pressure, motion) = unknowns.open(&x);
        pressure.iter_mut().zip(&load).for_each(|(p, l)| *p += l);
        if pressure.iter().chain(&motion).any(|v| !v.is_finite()) {
            break;
        }
        let mut slack = vec![0.0; n];
        (problem.multiply)(&pressure, &mut slack);
        for (w, b) in slack.iter_mut().zip(problem.offset) {
            *w += b;
        }
        if let Some(border) = problem.border {
            for (column, c) in border.motion.chunks_exact(n.max(1)).zip(&motion) {
                slack.iter_mut().zip(column).for_each(|(w, s)| *w -= s * c);
            }
        }
        let largest = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let least_pressure = SIGN * tolerance * largest(&pressure);
        scale = conditions.slack_scale(&slack, &motion);
        let least_slack = SIGN * tolerance * scale;
        let left = unknowns
            .set
            .iter()
            .fold(0.0_f64, |m, &i| m.max(slack[i].abs()));
        point.iterations += report_of.steps + 2;
        point.pressure = pressure;
        point.motion = motion;
        point.slack = slack;
        point.residual = if scale > 0.0 { left / scale } else { left };
        let mut turned = sides.clone();
        let least = [least_pressure, least_slack];
        let changes = turned.turn(
            &point.pressure,
            &point.slack,
            problem.limit,
            least,
            m.max(1),
        );
        report(monitor, round, changes as f64 / n as f64)?;
        if changes == 0 && is_last {
            for i in 0..n {
                if sides.closed[i] {
                    point.slack[i] = 0.0;
                    point.pressure[i] = point.pressure[i].max(0.0);
                    if let Some(limit) = problem.limit {
                        point.pressure[i] = point.pressure[i].min(limit[i]);
                    }
                } else if sides.held[i] {
                    point.slack[i] = point.slack[i].min(0.0);
                } else {
                    point.slack[i] = point.slack[i].max(0.0);
                }
            }
            let rest = conditions.residual(&point.pressure, &point.slack, &point.motion);
            point.residual = point.residual.max(rest);
            if point.residual <= SIGN * tolerance {
                point.status = Status::Solved;
            }
            break;
        }
        let mut next = turned.clone();
        let is_new = visited.insert((stage, next.clone()));
        if is_last {
            if changes < fewest {
                (fewest, patience) = (changes, PATIENCE);
            } else {
                patience = patience.saturating_sub(1);
            }
        }
        let holds = |set: &Sides| set.count() >= m.max(1);
        if is_last && patience == 0 || m > 0 && !holds(&next) {
            // one at a time, and never fewer points than hold the body
            next.clone_from(&sides);
            for i in turned.changed(&sides).into_iter().rev() {
                next.take(&turned, i);
                if m == 0 || holds(&next) {
                    break;
                }
                next.take(&sides, i);
            }
        }
        sides = next;
        // few changes: the set is worth more digits; a set that returns, or none: all of them
        if changes == 0 || !is_new || stage == 0 && 50 * changes <= n {
            stage = (stage + 1).min(TOLERANCES.len() - 1);
        }
        point.pressure.iter_mut().for_each(|p| *p = p.max(0.0));
        if let Some(limit) = problem.limit {
            for (p, limit) in point.pressure.iter_mut().zip(limit) {
                *p = p.min(*limit);
            }
        }
    }
    point.status = told(point.status, problem.border, problem.limit);
    Ok(point)
}

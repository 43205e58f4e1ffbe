// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pressures that a limit bounds from above as well.

use mtb_operator::Monitor;

use super::active_set::settled;
use super::lemke::lemke;
use super::problem::{Border, Problem, Solution, Status};
use crate::error::Error;

/// Relative size below which a pressure or slack beyond its bound counts as rounding.
pub const ROUNDING: f64 = 1e-12;

/// Which bound each point is on: with a pressure between its bounds its gap is closed, at the limit the pressure is
/// held, and without a pressure the point is open.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Sides {
    /// Points whose gaps are closed (n).
    pub closed: Vec<bool>,
    /// Points whose pressures are held at the limit (n).
    pub held: Vec<bool>,
}

impl Sides {
    /// All points closed or open.
    pub fn of(closed: Vec<bool>) -> Self {
        Self {
            held: vec![false; closed.len()],
            closed,
        }
    }

    /// The sides of pressures (n) between zero and the `limit` (n).
    pub fn of_pressure(pressure: &[f64], limit: Option<&[f64]>) -> Self {
        let held: Vec<bool> = match limit {
            Some(limit) => pressure.iter().zip(limit).map(|(p, l)| p >= l).collect(),
            None => vec![false; pressure.len()],
        };
        let closed = pressure
            .iter()
            .zip(&held)
            .map(|(p, held)| *p > 0.0 && !held);
        Self {
            closed: closed.collect(),
            held,
        }
    }

    /// Number of closed points.
    pub fn count(&self) -> usize {
        self.closed.iter().filter(|c| **c).count()
    }

    /// The closed points.
    pub fn points(&self) -> Vec<usize> {
        (0..self.closed.len()).filter(|&i| self.closed[i]).collect()
    }

    /// Whether no point is in contact.
    pub fn is_open(&self) -> bool {
        !self.closed.iter().chain(&self.held).any(|c| *c)
    }

    /// Whether a pressure is held.
    pub fn is_held(&self) -> bool {
        self.held.iter().any(|h| *h)
    }

    /// The pressures (n) of the points that are held, zero elsewhere.
    pub fn load(&self, limit: Option<&[f64]>) -> Vec<f64> {
        let limit = limit.unwrap_or(&[]).iter().zip(&self.held);
        let mut load: Vec<f64> = limit
            .map(|(l, held)| if *held { *l } else { 0.0 })
            .collect();
        load.resize(self.held.len(), 0.0);
        load
    }

    /// Closed and held as point `i` belongs that has the pressure `p` and the slack `w`; `None` where neither is beyond
    /// its bound by more than `least`.
    fn wrong(
        &self,
        i: usize,
        p: f64,
        w: f64,
        limit: Option<f64>,
        least: [f64; 2],
    ) -> Option<[bool; 2]> {
        let [p_least, w_least] = least;
        let (open, closed, held) = ([false, false], [true, false], [false, true]);
        if self.held[i] {
            (w > w_least).then_some(closed)
        } else if !self.closed[i] {
            (w < -w_least).then_some(closed)
        } else if p < -p_least {
            Some(open)
        } else {
            limit.filter(|limit| p > limit + p_least).map(|_| held)
        }
    }

    /// Moves the points beyond their bounds by more than `least` (pressure, slack) to where they belong; returns how
    /// many these are.
    ///
    /// A set with pressures below zero says little of how large the others are: such pressures go first, and none is
    /// held while there are some. At least `needed` points stay closed that were, those with the least pressures.
    pub fn turn(
        &mut self,
        pressure: &[f64],
        slack: &[f64],
        limit: Option<&[f64]>,
        least: [f64; 2],
        needed: usize,
    ) -> usize {
        let n = pressure.len();
        let limit = limit.filter(|_| !(0..n).any(|i| self.closed[i] && pressure[i] < -least[0]));
        let mut changes = 0;
        let mut caught = Vec::new();
        for i in 0..n {
            let own = limit.map(|limit| limit[i]);
            if let Some([closed, held]) = self.wrong(i, pressure[i], slack[i], own, least) {
                if held {
                    caught.push(i);
                }
                (self.closed[i], self.held[i]) = (closed, held);
                changes += 1;
            }
        }
        let missing = needed.saturating_sub(self.count());
        if missing > 0 && missing < caught.len() {
            let over = |&i: &usize| limit.map_or(0.0, |limit| pressure[i] / limit[i]);
            caught.sort_by(|a, b| over(a).total_cmp(&over(b)));
            for &i in &caught[..missing] {
                // still a change: the set is not the last one
                (self.closed[i], self.held[i]) = (true, false);
            }
        }
        changes
    }

    /// Takes the change of point `i` from those of `other`.
    pub fn take(&mut self, other: &Self, i: usize) {
        (self.closed[i], self.held[i]) = (other.closed[i], other.held[i]);
    }

    /// The points on another side than in `other`.
    pub fn changed(&self, other: &Self) -> Vec<usize> {
        let own = self.closed.iter().zip(&self.held);
        let pairs = own.zip(other.closed.iter().zip(&other.held));
        let differing = pairs.enumerate().filter(|(_, (a, b))| a != b);
        differing.map(|(i, _)| i).collect()
    }
}

/// What is left for the other points while the pressures `load` (n) are held: offset and targets.
pub(super) fn rest(problem: &Problem<'_>, load: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let moved = problem.moved(load);
    let offset = problem.offset.iter().zip(moved).map(|(b, u)| b + u);
    (offset.collect(), targets(problem.border, load))
}

/// What the pressures `load` (n) leave of the balances.
pub(super) fn targets(border: Option<Border<'_>>, load: &[f64]) -> Vec<f64> {
    let Some(border) = border else {
        return Vec::new();
    };
    let columns = border.balance.chunks_exact(load.len().max(1));
    let left = columns.zip(border.target).map(|(column, target)| {
        let carried: f64 = column.iter().zip(load).map(|(k, p)| k * p).sum();
        target - carried
    });
    left.collect()
}

/// Whether pressures at their limits (n) carry each balance by itself: necessary for a solution.
pub fn carries(border: Border<'_>, limit: &[f64]) -> bool {
    let columns = border.balance.chunks_exact(limit.len().max(1));
    columns.zip(border.target).all(|(column, target)| {
        let most: f64 = column
            .iter()
            .zip(limit)
            .map(|(k, p)| (k * target.signum()).max(0.0) * p)
            .sum();
        target.abs() < most || *target == 0.0
    })
}

/// Lemke's method with a limit: `s = limit - p` and its multiplier are further unknowns, so that it is a problem of
/// twice the size without a limit.
pub(super) fn lemke_limited(
    problem: &Problem<'_>,
    limit: &[f64],
    monitor: Monitor<'_>,
) -> Result<Solution, Error> {
    let n = problem.dim();
    // pressures in the unit of gaps, so that all rows are alike
    let unit = problem.matrix.iter().step_by(n + 1).sum::<f64>() / n.max(1) as f64;
    let mut matrix = vec![0.0; 4 * n * n];
    for (i, (row, own)) in matrix
        .chunks_exact_mut(2 * n)
        .zip(problem.matrix.chunks_exact(n.max(1)))
        .enumerate()
    {
        row[..n].copy_from_slice(own);
        row[n + i] = unit;
    }
    for i in 0..n {
        matrix[(n + i) * 2 * n + i] = -unit;
    }
    let wide = |columns: &[f64]| -> Vec<f64> {
        let columns = columns.chunks_exact(n.max(1));
        let widened = columns.flat_map(|c| c.iter().copied().chain(std::iter::repeat_n(0.0, n)));
        widened.collect()
    };
    let (motion, balance) = problem
        .border
        .map_or_else(Default::default, |b| (wide(b.motion), wide(b.balance)));
    let border = problem.border.map(|b| Border {
        motion: &motion,
        balance: &balance,
        target: b.target,
    });
    let bound = limit.iter().map(|l| unit * l);
    let offset: Vec<f64> = problem.offset.iter().copied().chain(bound).collect();
    let doubled = Problem {
        matrix: &matrix,
        offset: &offset,
        border,
        symmetric: false,
        limit: None,
    };
    let found = lemke(&doubled, monitor)?;
    let (pressure, dent) = found.pressure.split_at(n);
    let slack = found
        .slack
        .iter()
        .zip(dent)
        .map(|(w, v)| w - unit * v)
        .collect();
    // one of both is zero: what flows is at the limit to the last digit
    let bounded = pressure.iter().zip(dent).zip(limit);
    let point = Solution {
        pressure: bounded
            .map(|((p, v), l)| if *v > 0.0 { *l } else { p.min(*l) })
            .collect(),
        slack,
        ..found.clone()
    };
    Ok(match point.status {
        Status::Solved => settled(problem, point),
        _ => point,
    })
}

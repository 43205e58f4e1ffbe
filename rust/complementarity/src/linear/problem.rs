// SPDX-License-Identifier: MIT OR Apache-2.0
use crate::error::{Error, check};

/// Share of the work of the largest pressure below which the parts of a balance are not its scale any more: what a
/// pressure so much smaller than the largest works is known to so many digits fewer.
const LEAST: f64 = 1e-5;
/// Lever of all that a body carries, in parts of its longest one, below which the same holds: points on the axis of a
/// tilt have no lever but rounding.
const LEVER: f64 = 1e-3;

/// Find `p >= 0` and `c` with `w = A p + b - N c >= 0`, `w . p = 0` and `K^T p = f`.
///
/// With a limit, `p` is also at most as large: where it is, `w` may be below zero, and is not above it.
///
/// In a contact, `p` are pressures, `w` gaps, `c` free rigid motions (approach, tilts) that close the
/// gap by `N c`, and `K^T p = f` the balance of forces and moments on them.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// `A`, n x n, row-major; need not be symmetric.
    pub matrix: &'a [f64],
    /// `b`, n.
    pub offset: &'a [f64],
    /// The free motions; `None` where all motion is prescribed and part of `b`.
    pub border: Option<Border<'a>>,
    /// Whether `A` is symmetric (its factorisation then costs half).
    pub symmetric: bool,
    /// Largest values that `p` may have, positive (n); `None` where there is no limit.
    pub limit: Option<&'a [f64]>,
}

/// Free rigid motions and the balance that determines them.
#[derive(Clone, Copy, Debug)]
pub struct Border<'a> {
    /// `N`, m columns of length n, column-major: how far a unit of each motion closes each gap.
    pub motion: &'a [f64],
    /// `K`, m columns of length n, column-major: what a unit pressure adds to each balance.
    pub balance: &'a [f64],
    /// `f`, m.
    pub target: &'a [f64],
}

/// How the search for a solution ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// All conditions hold to rounding.
    Solved,
    /// Lemke's method ended on a ray: no solution exists (certain for copositive-plus matrices, and
    /// never seen to be wrong for the matrices of sliding contact).
    NoSolution,
    /// The target of the balance cannot be reached by any `p >= 0`.
    Unreachable,
    /// The target of the balance can be reached, but by no `p` within its limit.
    Overloaded,
    /// Neither the active-set method nor Lemke's came to an end.
    IterationLimit,
}

/// The point where the search ended.
#[derive(Clone, Debug)]
pub struct Solution {
    /// How it ended; only [`Status::Solved`] is a solution.
    pub status: Status,
    /// `p`, n.
    pub pressure: Vec<f64>,
    /// `w`, n; exactly zero where `p > 0`, and zero or less where `p` is at its limit.
    pub slack: Vec<f64>,
    /// `c`, m.
    pub motion: Vec<f64>,
    /// Changes of the active set, or pivots of Lemke's method, or sweeps.
    pub iterations: usize,
    /// Largest violation of the conditions, relative to the largest pressure and slack.
    pub residual: f64,
    /// Whether Lemke's method had to take over from the active-set method.
    pub by_lemke: bool,
    /// Sign of the determinant of the active block (of the bordered matrix where motions are free):
    /// negative on an unstable branch of a sliding contact.
    pub determinant_sign: f64,
}

impl Problem<'_> {
    /// Number of pressures.
    pub fn dim(&self) -> usize {
        self.offset.len()
    }

    /// Number of free motions.
    pub fn motions(&self) -> usize {
        self.border.map_or(0, |b| b.target.len())
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        let n = self.dim();
        check("offset", self.offset, n)?;
        check("matrix", self.matrix, n * n)?;
        if let Some(border) = self.border {
            let m = border.target.len();
            check("target", border.target, m)?;
            check("motion", border.motion, n * m)?;
            check("balance", border.balance, n * m)?;
        }
        if let Some(limit) = self.limit {
            check("limit", limit, n)?;
        }
        Ok(())
    }

    /// `A p`: how far pressures open the gaps.
    pub(super) fn moved(&self, pressure: &[f64]) -> Vec<f64> {
        let n = self.dim();
        let active: Vec<usize> = (0..n).filter(|&j| pressure[j] != 0.0).collect();
        let rows = self.matrix.chunks_exact(n.max(1));
        rows.map(|row| active.iter().map(|&j| row[j] * pressure[j]).sum())
            .collect()
    }

    /// `w = A p + b - N c`.
    pub fn slack(&self, pressure: &[f64], motion: &[f64]) -> Vec<f64> {
        let n = self.dim();
        let moved = self.moved(pressure);
        let mut w: Vec<f64> = self.offset.iter().zip(moved).map(|(b, u)| b + u).collect();
        if let Some(border) = self.border {
            for (column, c) in border.motion.chunks_exact(n.max(1)).zip(motion) {
                for (w, motion) in w.iter_mut().zip(column) {
                    *w -= motion * c;
                }
            }
        }
        w
    }

    /// The largest part that a slack is made of.
    pub(super) fn slack_scale(&self, slack: &[f64], motion: &[f64]) -> f64 {
        let n = self.dim();
        let largest = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let mut scale = largest(self.offset).max(largest(slack));
        if let Some(border) = self.border {
            for (column, c) in border.motion.chunks_exact(n.max(1)).zip(motion) {
                scale = scale.max(largest(column) * c.abs());
            }
        }
        scale
    }

    /// Largest violation of `w >= 0`, `p >= 0`, `w . p = 0` and of the balance, relative to the data; each balance
    /// relative to its own parts.
    pub fn residual(&self, pressure: &[f64], slack: &[f64], motion: &[f64]) -> f64 {
        let n = self.dim();
        let largest = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let p_scale = largest(pressure);
        let w_scale = self.slack_scale(slack, motion);
        let relative = |x: f64, scale: f64| if scale > 0.0 { x / scale } else { x };
        let mut worst = 0.0_f64;
        for (i, (p, w)) in pressure.iter().zip(slack).enumerate() {
            let mut rest = relative(*p, p_scale).min(relative(*w, w_scale));
            if let Some(limit) = self.limit {
                // where the limit is reached the slack may be below zero
                rest = rest.max(relative(*p - limit[i], p_scale));
            }
            worst = worst.max(rest.abs());
        }
        if let Some(border) = self.border {
            for (column, f) in border.balance.chunks_exact(n.max(1)).zip(border.target) {
                let sum: f64 = column.iter().zip(pressure).map(|(k, p)| k * p).sum();
                let scale: f64 = column
                    .iter()
                    .zip(pressure)
                    .map(|(k, p)| (k * p).abs())
                    .sum();
                let own = column.iter().zip(pressure).filter(|(k, _)| **k != 0.0);
                let carried: f64 = own.map(|(_, p)| p.abs()).sum();
                let unit = (LEAST * p_scale).max(LEVER * carried);
                let scale = scale.max(f.abs()).max(unit * largest(column));
                worst = worst.max(relative((sum - f).abs(), scale));
            }
        }
        worst
    }
}

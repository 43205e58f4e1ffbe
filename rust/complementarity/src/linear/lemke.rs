// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::{Monitor, report};

use super::active_set::{SINGULAR, closed, settled, stationary};
use super::problem::{Problem, Solution, Status};
use crate::error::Error;

/// Share of the gaps that the displacements by the pressures must have for the pivots to tell points apart.
const DIGITS: f64 = 1e-10;

/// Ratios closer than this count as ties.
const TIE: f64 = 1e-11;

/// Solves a linear complementarity problem by Lemke's complementary pivoting [Cottle2009, section 4.4].
///
/// Ends with a solution or on a ray; the ray tells that none exists. The free motions enter as differences
/// of two non-negative variables, their balance as two opposite inequalities.
///
/// # Errors
/// As [`super::solve`].
pub fn lemke(problem: &Problem<'_>, monitor: Monitor<'_>) -> Result<Solution, Error> {
    problem.check()?;
    let mut tableau = Tableau::new(problem);
    let (status, pivots) = tableau.run(monitor)?;
    let (pressure, motion) = tableau.point();
    let solved = status == Status::Solved;
    let active: Vec<bool> = pressure.iter().map(|&p| solved && p > 0.0).collect();
    let polished = if solved {
        // the last active set, solved anew, is free of the rounding of many pivots
        stationary(problem, &active, None, monitor)?.map(|point| settled(problem, point))
    } else {
        None
    };
    let mut point = match polished {
        Some(point) if point.residual <= SINGULAR => point,
        // a set that leaves a motion free does not know how far it goes: the pivots do
        _ => {
            let set: Vec<usize> = (0..problem.dim()).filter(|&i| active[i]).collect();
            let point = closed(problem, &set, pressure, motion, 1.0);
            if solved {
                let lost = lost(problem, &point);
                let point = settled(problem, point);
                let residual = point.residual.max(lost);
                Solution { residual, ..point }
            } else {
                let residual = problem.residual(&point.pressure, &point.slack, &point.motion);
                Solution { residual, ..point }
            }
        }
    };
    point.status = if solved && point.residual > SINGULAR {
        Status::IterationLimit
    } else {
        status
    };
    point.iterations = pivots;
    point.by_lemke = true;
    Ok(point)
}

/// Relative error of displacements that are lost in the rounding of the gaps; zero where they are not.
fn lost(problem: &Problem<'_>, point: &Solution) -> f64 {
    let moved = problem.moved(&point.pressure);
    let moved = moved.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
    let scale = problem.slack_scale(&point.slack, &point.motion);
    if moved == 0.0 || moved > DIGITS * scale {
        return 0.0;
    }
    f64::EPSILON * scale / moved
}

/// A variable of the pivoting: the slack or the variable of a row, or the artificial one.
#[derive(Clone, Copy, PartialEq)]
enum Variable {
    Slack(usize),
    Level(usize),
    Artificial,
}

impl Variable {
    fn complement(self) -> Self {
        match self {
            Self::Slack(i) => Self::Level(i),
            Self::Level(i) => Self::Slack(i),
            Self::Artificial => Self::Artificial,
        }
    }
}

/// `basic = constant + table . nonbasic`, condensed: one column for each variable outside the basis.
struct Tableau {
    rows: usize,
    table: Vec<f64>,
    constant: Vec<f64>,
    basic: Vec<Variable>,
    outside: Vec<Variable>,
    n: usize,
    m: usize,
    pressure_scale: f64,
    motion_scale: Vec<f64>,
}

impl Tableau {
    fn new(problem: &Problem<'_>) -> Self {
        let n = problem.dim();
        let m = problem.motions();
        let rows = n + 2 * m;
        let columns = rows + 1;
        let largest = |v: &[f64]| v.iter().fold(0.0_f64, |s, x| s.max(x.abs()));
        let positive = |v: f64| if v > 0.0 { v } else { 1.0 };
        let a_scale = positive((0..n).fold(0.0_f64, |s, i| s.max(problem.matrix[i * n + i].abs())));
        let mut b_scale = largest(problem.offset);
        if let Some(border) = problem.border {
            for j in 0..m {
                let k = largest(&border.balance[j * n..(j + 1) * n]);
                b_scale = b_scale.max(border.target[j].abs() / positive(k) * a_scale);
            }
        }
        let b_scale = positive(b_scale);
        let pressure_scale = b_scale / a_scale;
        let mut table = vec![0.0; rows * columns];
        let mut constant = vec![0.0; rows];
        let mut motion_scale = vec![1.0; m];
        for i in 0..n {
            constant[i] = problem.offset[i] / b_scale;
            for j in 0..n {
                table[i * columns + j] = problem.matrix[i * n + j] / a_scale;
            }
        }
        if let Some(border) = problem.border {
            for j in 0..m {
                let motion = &border.motion[j * n..(j + 1) * n];
                let balance = &border.balance[j * n..(j + 1) * n];
                let (ms, ks) = (positive(largest(motion)), positive(largest(balance)));
                motion_scale[j] = b_scale / ms;
                for i in 0..n {
                    table[i * columns + n + j] = -motion[i] / ms;
                    table[i * columns + n + m + j] = motion[i] / ms;
                    table[(n + j) * columns + i] = balance[i] / ks;
                    table[(n + m + j) * columns + i] = -balance[i] / ks;
                }
                constant[n + j] = -border.target[j] / (ks * pressure_scale);
                constant[n + m + j] = -constant[n + j];
            }
        }
        for i in 0..rows {
            table[i * columns + rows] = 1.0;
        }
        let mut outside: Vec<Variable> = (0..rows).map(Variable::Level).collect();
        outside.push(Variable::Artificial);
        Self {
            rows,
            table,
            constant,
            basic: (0..rows).map(Variable::Slack).collect(),
            outside,
            n,
            m,
            pressure_scale,
            motion_scale,
        }
    }

    fn run(&mut self, monitor: Monitor<'_>) -> Result<(Status, usize), Error> {
        let Some(first) = (0..self.rows)
            .filter(|&i| self.constant[i] < 0.0)
            .min_by(|&i, &j| self.constant[i].total_cmp(&self.constant[j]))
        else {
            return Ok((Status::Solved, 0));
        };
        let mut entering = self.pivot(first, self.rows).complement();
        let limit = 50 * self.rows + 100;
        for pivots in 1..limit {
            let column = self
                .outside
                .iter()
                .position(|&v| v == entering)
                .unwrap_or(self.rows);
            let Some(row) = self.leaving(column) else {
                return Ok((Status::NoSolution, pivots));
            };
            let left = self.pivot(row, column);
            if left == Variable::Artificial {
                return Ok((Status::Solved, pivots + 1));
            }
            entering = left.complement();
            report(monitor, pivots, f64::NAN)?;
        }
        Ok((Status::IterationLimit, limit))
    }

    /// Row with the smallest ratio; among ties the artificial variable, then the largest pivot.
    fn leaving(&self, column: usize) -> Option<usize> {
        let columns = self.rows + 1;
        let mut best: Option<(usize, f64, f64)> = None;
        for i in 0..self.rows {
            let slope = self.table[i * columns + column];
            if slope >= -TIE {
                continue;
            }
            let ratio = self.constant[i].max(0.0) / -slope;
            let better = match best {
                None => true,
                Some((row, least, pivot)) => {
                    if (ratio - least).abs() <= TIE * (1.0 + least) {
                        self.basic[row] != Variable::Artificial
                            && (self.basic[i] == Variable::Artificial || -slope > pivot)
                    } else {
                        ratio < least
                    }
                }
            };
            if better {
                best = Some((i, ratio, -slope));
            }
        }
        best.map(|b| b.0)
    }

    /// Exchanges the basic variable of `row` with the outside variable of `column`; returns the one that left.
    fn pivot(&mut self, row: usize, column: usize) -> Variable {
        let columns = self.rows + 1;
        let pivot = self.table[row * columns + column];
        // basic = c + sum_j t_j x_j  =>  x_col = (basic - c - sum_{j != col} t_j x_j) / pivot
        let mut solved: Vec<f64> = self.table[row * columns..(row + 1) * columns]
            .iter()
            .map(|t| -t / pivot)
            .collect();
        solved[column] = 1.0 / pivot;
        let constant = -self.constant[row] / pivot;
        for i in 0..self.rows {
            if i == row {
                continue;
            }
            let line = &mut self.table[i * columns..(i + 1) * columns];
            let factor = line[column];
            if factor == 0.0 {
                continue;
            }
            line[column] = 0.0;
            for (t, s) in line.iter_mut().zip(&solved) {
                *t += factor * s;
            }
            self.constant[i] += factor * constant;
        }
        self.table[row * columns..(row + 1) * columns].copy_from_slice(&solved);
        self.constant[row] = constant;
        std::mem::swap(&mut self.basic[row], &mut self.outside[column]);
        self.outside[column]
    }

    fn point(&self) -> (Vec<f64>, Vec<f64>) {
        let mut pressure = vec![0.0; self.n];
        let mut motion = vec![0.0; self.m];
        for (variable, value) in self.basic.iter().zip(&self.constant) {
            let value = value.max(0.0);
            match *variable {
                Variable::Level(i) if i < self.n => pressure[i] = value * self.pressure_scale,
                Variable::Level(i) if i < self.n + self.m => {
                    motion[i - self.n] += value * self.motion_scale[i - self.n];
                }
                Variable::Level(i) => {
                    let j = i - self.n - self.m;
                    motion[j] -= value * self.motion_scale[j];
                }
                _ => {}
            }
        }
        (pressure, motion)
    }
}

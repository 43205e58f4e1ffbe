// SPDX-License-Identifier: MIT OR Apache-2.0
//! The same problem with a matrix that is not symmetric: active sets, each solved by GMRES.

use mtb_operator::krylov::gmres;
use mtb_operator::{Monitor, report};

use super::solver::{Inverse, Product};
use super::state::{balance, solve_small};
use super::sums::Spans;
use super::{Judgement, Options, Problem, Solution, Status};
use crate::error::Error;

/// Part of the residual that a set may leave, before it is changed.
const PART: f64 = 0.03;

/// Part of the tolerance to which the last set is solved.
const ROOM: f64 = 0.3;

/// Steps of GMRES on one set.
const STEPS: usize = 80;

/// Sets without a new best residual after which the search is given up.
const PATIENCE: usize = 15;

/// Solves the problem from `start` (n, negative entries count as zero) for a matrix that need not be symmetric.
///
/// Arguments are those of [`solve`](super::solve), the rough inverse of any symmetry. On the set of points that carry
/// or would carry pressure, the equations are solved with the balance held, then points that pull leave the set and
/// points that penetrate enter it. With matrices close to those of elastic contact few sets are needed; there is no
/// proof that they end, and a search that does not is [`Status::Stagnated`].
///
/// # Errors
/// As [`solve`](super::solve).
pub fn solve_unsymmetric(
    apply: Product<'_>,
    precondition: Inverse<'_>,
    problem: &Problem<'_>,
    start: Vec<f64>,
    options: Options,
    monitor: Monitor<'_>,
) -> Result<Solution, Error> {
    let n = problem.offset.len();
    problem.check(&start)?;
    let mut search = Search {
        problem,
        image: vec![0.0; n],
        motion: [0.0; 3],
        contact: start.iter().map(|p| *p > 0.0).collect(),
        p: start,
    };
    let (mut products, mut preconditionings, mut iterations) = (0, 0, 0);
    let mut history = Vec::new();
    let mut best = (f64::INFINITY, 0);
    let status = loop {
        if !search.settle() {
            break Status::Unreachable;
        }
        apply(&search.p, &mut search.image);
        products += 1;
        let (residual, scale) = search.judge(options.tolerance);
        history.push(residual);
        if residual <= options.tolerance {
            break Status::Solved;
        }
        if residual < 0.99 * best.0 {
            best = (residual, history.len());
        }
        if history.len() > best.1 + PATIENCE || scale == 0.0 && history.len() > 1 {
            break Status::Stagnated;
        }
        if iterations >= options.max_iterations {
            break Status::IterationLimit;
        }
        report(monitor, iterations, residual)?;
        // without pressure there is no size yet
        let size = if scale > 0.0 { scale } else { search.size() };
        let aim = (PART * residual).min(1.0).max(ROOM * options.tolerance) * size;
        let steps = search.on_set(apply, precondition, aim);
        products += steps;
        preconditionings += steps + 1 + problem.modes.len();
        iterations += steps.max(1);
    };
    let slack = (0..n).map(|i| search.slack(i)).collect();
    Ok(Solution {
        status,
        pressure: search.p,
        slack,
        motion: search.motion[..problem.modes.len()].to_vec(),
        iterations,
        products,
        preconditionings,
        residual: history.last().copied().unwrap_or(0.0),
        history,
    })
}

struct Search<'a> {
    problem: &'a Problem<'a>,
    p: Vec<f64>,
    /// `A p`.
    image: Vec<f64>,
    motion: [f64; 3],
    contact: Vec<bool>,
}

impl Search<'_> {
    /// Cuts off what pulls, and restores the balance; false where that is not possible.
    fn settle(&mut self) -> bool {
        for (p, c) in self.p.iter_mut().zip(&mut self.contact) {
            *c &= *p > 0.0;
            *p = p.max(0.0);
        }
        let whole = Spans::whole(self.p.len());
        let all = vec![true; self.p.len()];
        balance(self.problem.modes, &mut self.p, f64::INFINITY, &whole, &all)
    }

    /// Gap before the free motions.
    fn opened(&self, i: usize) -> f64 {
        self.image[i] + self.problem.offset[i]
    }

    fn slack(&self, i: usize) -> f64 {
        let modes = self.problem.modes.iter().zip(self.motion);
        self.opened(i) - modes.map(|(m, c)| c * m.shape[i]).sum::<f64>()
    }

    /// Least squares of a field on the set by the motions.
    fn fitted(&self, field: impl Fn(usize) -> f64) -> [f64; 3] {
        let modes = self.problem.modes;
        let (mut gram, mut sum) = ([[0.0; 3]; 3], [0.0; 3]);
        for i in (0..self.p.len()).filter(|i| self.contact[*i]) {
            for (k, mode) in modes.iter().enumerate() {
                sum[k] += mode.shape[i] * field(i);
                for (l, other) in modes.iter().enumerate() {
                    gram[k][l] += mode.shape[i] * other.shape[i];
                }
            }
        }
        solve_small(&gram, sum, modes.len())
    }

    /// Fits the motions, judges the point, and lets what penetrates into the set: the residual, and the root mean
    /// square of the image on the set.
    fn judge(&mut self, tolerance: f64) -> (f64, f64) {
        let n = self.p.len();
        self.motion = self.fitted(|i| self.opened(i));
        let mut judged = Judgement::default();
        let (mut squares, mut count) = (0.0, 0_usize);
        for i in 0..n {
            judged.take(self.p[i], self.slack(i), self.image[i]);
            if self.contact[i] {
                squares += self.image[i].powi(2);
                count += 1;
            }
        }
        let scale = (squares / count.max(1) as f64).sqrt();
        // a point that penetrates by far less than the tolerance need not disturb the search
        let threshold = -1e-2 * tolerance * scale;
        for i in 0..n {
            self.contact[i] |= self.slack(i) < threshold;
        }
        (judged.residual(), scale)
    }

    /// Root mean square of the gap that the set is to close.
    fn size(&self) -> f64 {
        let set = (0..self.p.len()).filter(|i| self.contact[*i]);
        let (squares, count) = set.fold((0.0, 0_usize), |(sum, count), i| {
            (sum + self.slack(i).powi(2), count + 1)
        });
        (squares / count.max(1) as f64).sqrt()
    }

    /// Solves the equations on the set, with the balance held, to a norm of the gap per root of a point; the steps.
    fn on_set(&mut self, apply: Product<'_>, precondition: Inverse<'_>, aim: f64) -> usize {
        let n = self.p.len();
        let modes = self.problem.modes;
        let set = self.contact.clone();
        let only = |field: &mut [f64]| {
            for (v, c) in field.iter_mut().zip(&set) {
                if !c {
                    *v = 0.0;
                }
            }
        };
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        // pressures that the motions ask for, and what balances them
        let shapes: Vec<Vec<f64>> = modes
            .iter()
            .map(|mode| {
                let mut shape = mode.shape.clone();
                only(&mut shape);
                shape
            })
            .collect();
        let images: Vec<Vec<f64>> = shapes
            .iter()
            .map(|shape| {
                let mut image = vec![0.0; n];
                precondition(&set, shape, &mut image);
                only(&mut image);
                image
            })
            .collect();
        let mut gram = [[0.0; 3]; 3];
        let mut plain = [[0.0; 3]; 3];
        for (k, shape) in shapes.iter().enumerate() {
            for (l, image) in images.iter().enumerate() {
                gram[k][l] = 0.5 * (dot(shape, image) + dot(&shapes[l], &images[k]));
                plain[k][l] = dot(shape, &shapes[l]);
            }
        }
        // the part of a gap that no motion closes
        let projected = |field: &mut [f64]| {
            only(field);
            let mut sum = [0.0; 3];
            for (sum, shape) in sum.iter_mut().zip(&shapes) {
                *sum = dot(shape, field);
            }
            let by = solve_small(&plain, sum, modes.len());
            for (shape, c) in shapes.iter().zip(by) {
                field.iter_mut().zip(shape).for_each(|(f, s)| *f -= c * s);
            }
        };
        let inverted = |x: &[f64], y: &mut [f64]| {
            precondition(&set, x, y);
            only(y);
            // twice: the second time takes out what rounding, and an inverse without symmetry, leave
            for _ in 0..2 {
                let mut sum = [0.0; 3];
                for (sum, shape) in sum.iter_mut().zip(&shapes) {
                    *sum = dot(shape, y);
                }
                let by = solve_small(&gram, sum, modes.len());
                for (image, c) in images.iter().zip(by) {
                    y.iter_mut().zip(image).for_each(|(y, v)| *y -= c * v);
                }
            }
        };
        let multiplied = |x: &[f64], y: &mut [f64]| {
            apply(x, y);
            projected(y);
        };
        let mut residual: Vec<f64> = (0..n).map(|i| -self.opened(i)).collect();
        projected(&mut residual);
        let found = gmres(multiplied, inverted, &mut self.p, &mut residual, aim, STEPS);
        found.steps
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Anderson's acceleration.

use faer::Mat;
use faer::linalg::solvers::SolveLstsq;

/// Anderson's acceleration of a fixed point iteration `x <- x + f(x)` [Walker2011].
pub(crate) struct Anderson {
    depth: usize,
    points: Vec<Vec<f64>>,
    steps: Vec<Vec<f64>>,
}

impl Anderson {
    /// That combines the step with `depth` earlier ones; 0 for none.
    pub(crate) fn new(depth: usize) -> Self {
        Self {
            depth,
            points: Vec::new(),
            steps: Vec::new(),
        }
    }

    /// The point after a `point` and the step from there.
    pub(crate) fn next(&mut self, point: Vec<f64>, step: Vec<f64>) -> Vec<f64> {
        let plain: Vec<f64> = point.iter().zip(&step).map(|(x, f)| x + f).collect();
        if self.depth == 0 {
            return plain;
        }
        self.points.push(point);
        self.steps.push(step);
        // no more shares than equations for them
        if self.points.len() > self.depth.min(plain.len()) + 1 {
            self.points.remove(0);
            self.steps.remove(0);
        }
        let last = self.steps.len() - 1;
        if last == 0 {
            return plain;
        }
        let n = plain.len();
        let difference = |v: &[Vec<f64>], i: usize, j: usize| v[j + 1][i] - v[j][i];
        let matrix = Mat::from_fn(n, last, |i, j| difference(&self.steps, i, j));
        let rhs = Mat::from_fn(n, 1, |i, _| self.steps[last][i]);
        let gamma = matrix.col_piv_qr().solve_lstsq(&rhs);
        let mixed: Vec<f64> = (0..n)
            .map(|i| {
                let correction: f64 = (0..last)
                    .map(|j| {
                        let both = difference(&self.points, i, j) + difference(&self.steps, i, j);
                        gamma[(j, 0)] * both
                    })
                    .sum();
                plain[i] - correction
            })
            .collect();
        if mixed.iter().all(|v| v.is_finite()) {
            mixed
        } else {
            plain
        }
    }
}

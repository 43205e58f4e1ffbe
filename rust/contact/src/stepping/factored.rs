// SPDX-License-Identifier: MIT OR Apache-2.0
//! Linearised equations, solved with the factors that a state left.

use faer::Mat;
use mtb_operator::Monitor;

use super::bordered::Bordered;
use super::influence::Influence;
use super::tangent::Linear;
use crate::error::Error;

/// Relative size of the last correction at which the linear equations count as solved ...
const SOLVED: f64 = 1e-11;
/// ... and corrections that may reach it before factors of the equations themselves are made.
const CORRECTIONS: usize = 12;

/// The influence of a pair, with factors of about the equations, which are made new where they do not serve.
pub(super) struct Factored<'a> {
    pub(super) influence: &'a Influence,
    factors: &'a mut Bordered,
    /// Whether the factors are those of the state's points: not everything that is asked for needs them.
    is_turned: bool,
}

impl<'a> Factored<'a> {
    pub(super) fn new(influence: &'a Influence, factors: &'a mut Bordered) -> Self {
        Self {
            influence,
            factors,
            is_turned: false,
        }
    }

    /// The solution of the equations, or of the transposed ones, for the columns of `rhs`.
    pub(super) fn solved(
        &mut self,
        of: &Linear<'_>,
        rhs: &Mat<f64>,
        transposed: bool,
        monitor: Monitor<'_>,
    ) -> Result<Mat<f64>, Error> {
        if !self.is_turned {
            let active = of.state.sides().closed;
            if self.factors.is_far_from(&active) {
                self.refactorise(of, monitor)?;
            } else {
                self.turn(of, monitor)?;
            }
        }
        let is_exact = self.factors.serves(of.terms);
        let motions = &of.state.motions;
        if transposed
            && is_exact
            && let Some(known) = self.factors.kept.solution(rhs, of.points, motions)
        {
            return Ok(known);
        }
        let mut x = self.factors.solve_many(rhs, of.points, transposed);
        if !is_exact && !self.corrected(of, &mut x, transposed) {
            self.refactorise(of, monitor)?;
            x = self.factors.solve_many(rhs, of.points, transposed);
        }
        if transposed && self.factors.serves(of.terms) {
            self.factors.kept.keep(rhs, of.points, motions, &x);
        }
        Ok(x)
    }

    /// `C_nx^T gap` or `C_ny^T gap` for a column each; `None` where it does nothing.
    pub(super) fn transposed_along(&mut self, axis: usize, gap: &Mat<f64>) -> Option<Mat<f64>> {
        let influence = self.influence;
        let kept = &mut self.factors.kept;
        kept.along(axis, gap, || influence.transposed_along(axis, gap))
    }

    fn turn(&mut self, of: &Linear<'_>, monitor: Monitor<'_>) -> Result<(), Error> {
        self.factors
            .turn_to(self.influence, &of.contact(), of.points, monitor)?;
        self.is_turned = true;
        Ok(())
    }

    fn refactorise(&mut self, of: &Linear<'_>, monitor: Monitor<'_>) -> Result<(), Error> {
        *self.factors = Bordered::new(self.influence, of.terms, of.points, monitor)?;
        self.turn(of, monitor)
    }

    /// Improves `x` by the factors of a friction and a diagonal nearby; whether the equations hold then.
    fn corrected(&mut self, of: &Linear<'_>, x: &mut Mat<f64>, transposed: bool) -> bool {
        let mut before = 1.0;
        let mut change = x.clone();
        for _ in 0..CORRECTIONS {
            let left = self.left_over(of, &change, transposed);
            change = self.factors.solve_many(&left, of.points, transposed);
            *x += &change;
            // of each column by its own size, since rows have unlike units
            let worst = (0..x.ncols()).fold(0.0_f64, |worst, j| {
                let (change, size) = (change.col(j).norm_l2(), x.col(j).norm_l2());
                if size > 0.0 {
                    worst.max(change / size)
                } else {
                    worst
                }
            });
            // what the next one would be
            if worst * worst / before <= SOLVED {
                return true;
            }
            // it would take longer than new factors
            if worst.is_nan() || worst > 0.3 * before {
                return false;
            }
            before = worst;
        }
        false
    }

    /// What the factors' own equations leave of the right-hand sides whose solutions they say `x` to be: they differ
    /// from these by the influence of a change of the friction, and of the diagonal.
    fn left_over(&self, of: &Linear<'_>, x: &Mat<f64>, transposed: bool) -> Mat<f64> {
        let (n, cases) = (of.state.pressure.len(), x.ncols());
        let then = self.factors.terms();
        let drags = of.terms.drag.iter().zip(&then.drag);
        let change: Vec<f64> = drags.map(|(now, then)| now - then).collect();
        let own: Vec<f64> = (of.points.iter())
            .map(|&point| of.terms.own(point) - then.own(point))
            .collect();
        let mut left = Mat::zeros(x.nrows(), cases);
        let mut spread = Mat::zeros(n, cases);
        for j in 0..cases {
            let x = x.col_as_slice(j);
            for ((left, own), x) in left.col_as_slice_mut(j).iter_mut().zip(&own).zip(x) {
                *left = -own * x;
            }
            let spread = spread.col_as_slice_mut(j);
            for (&point, x) in of.points.iter().zip(x) {
                spread[point] = *x;
            }
        }
        if transposed {
            for axis in [0, 1] {
                let change = &change[axis * n..(axis + 1) * n];
                if change.iter().all(|c| *c == 0.0) {
                    continue;
                }
                let Some(product) = self.influence.transposed_along(axis, &spread) else {
                    continue;
                };
                for j in 0..cases {
                    let product = product.col_as_slice(j);
                    let left = left.col_as_slice_mut(j).iter_mut();
                    for (left, &point) in left.zip(of.points) {
                        *left -= change[point] * product[point];
                    }
                }
            }
        } else {
            let [along, across] = [0, 1].map(|axis| {
                let mut along = spread.clone();
                for j in 0..cases {
                    let change = &change[axis * n..(axis + 1) * n];
                    for (to, change) in along.col_as_slice_mut(j).iter_mut().zip(change) {
                        *to *= change;
                    }
                }
                along
            });
            let none = Mat::zeros(n, cases);
            let opened = self.influence.products(&none, [&along, &across]);
            for j in 0..cases {
                let opened = opened.col_as_slice(j);
                let left = left.col_as_slice_mut(j).iter_mut();
                for (left, &point) in left.zip(of.points) {
                    *left -= opened[point];
                }
            }
        }
        left
    }
}

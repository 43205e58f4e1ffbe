// SPDX-License-Identifier: MIT OR Apache-2.0
//! Linearised equations of a pair of which products alone are taken.

use std::cell::Cell;

use faer::Mat;
use faer::linalg::solvers::Solve;
use mtb_operator::krylov::{dot, gmres};
use mtb_operator::{Compliance, Component, Map, Monitor, Relative, report};

use super::tangent::Linear;
use crate::columns::largest;
use crate::error::Error;
use crate::sliding::even_softness;

/// Part of the right-hand side that a solve leaves, and the part at which it still counts as solved where rounding
/// stands against more.
const SOLVED: f64 = 1e-12;
const ENOUGH: f64 = 1e-9;
/// Products of one solve, and solves that each take what the last one left.
const PRODUCTS: usize = 500;
const ROUNDS: usize = 4;
/// Part of the influence of pressures below which that of tractions is rounding.
const NOISE: f64 = 1e-13;

/// A pair by its products.
pub(super) struct Products {
    pair: Relative,
    /// Whether tractions along each tangent open the gap.
    along: [bool; 2],
    /// About the displacement of a point by a unit of its own pressure [m/Pa].
    diagonal: f64,
}

const TANGENTS: [Component; 2] = [Component::X, Component::Y];

impl Products {
    pub(super) fn new(pair: Relative, is_coupled: bool) -> Self {
        let n = pair.points();
        // any pressure that has no symmetry tells whether tractions open the gap
        let probe: Vec<f64> = (0..n).map(|i| 1.0 + ((i * i) % 7) as f64).collect();
        let size = |component: Component| {
            let mut moved = vec![0.0; n];
            pair.add_displacement(Component::Normal, component, 1.0, &probe, &mut moved);
            largest(&moved)
        };
        let normal = size(Component::Normal);
        let along = TANGENTS.map(|tangent| is_coupled && size(tangent) > NOISE * normal);
        let (mut unit, mut own) = (vec![0.0; n], vec![0.0; n]);
        let diagonal = if n == 0 {
            1.0
        } else {
            unit[n / 2] = 1.0;
            pair.add_displacement(Component::Normal, Component::Normal, 1.0, &unit, &mut own);
            own[n / 2]
        };
        Self {
            pair,
            along,
            diagonal,
        }
    }

    pub(super) fn points(&self) -> usize {
        self.pair.points()
    }

    /// Whether friction opens or closes the gap.
    pub(super) fn is_coupled(&self) -> bool {
        self.along.iter().any(|along| *along)
    }

    /// Gaps (n) that pressures, and tractions along both tangents, open: a column each.
    pub(super) fn products(&self, pressure: &Mat<f64>, traction: [&Mat<f64>; 2]) -> Mat<f64> {
        let mut gap = Mat::zeros(self.points(), pressure.ncols());
        for j in 0..gap.ncols() {
            let to = gap.col_as_slice_mut(j);
            self.add(Component::Normal, pressure.col_as_slice(j), to);
            for (axis, tangent) in TANGENTS.into_iter().enumerate() {
                if self.along[axis] {
                    self.add(tangent, traction[axis].col_as_slice(j), to);
                }
            }
        }
        gap
    }

    /// `C_nn^T gap` for a column each.
    pub(super) fn transposed_normal(&self, gap: &Mat<f64>) -> Mat<f64> {
        self.transposed(Component::Normal, gap)
    }

    /// `C_nx^T gap` or `C_ny^T gap` for a column each; `None` where it does nothing.
    pub(super) fn transposed_along(&self, axis: usize, gap: &Mat<f64>) -> Option<Mat<f64>> {
        self.along[axis].then(|| self.transposed(TANGENTS[axis], gap))
    }

    fn transposed(&self, loaded: Component, gap: &Mat<f64>) -> Mat<f64> {
        let mut sums = Mat::zeros(gap.nrows(), gap.ncols());
        for j in 0..gap.ncols() {
            let to = sums.col_as_slice_mut(j);
            self.add_transposed(loaded, gap.col_as_slice(j), to);
        }
        sums
    }

    fn add(&self, loaded: Component, traction: &[f64], gap: &mut [f64]) {
        // most changes leave most of them as they are
        if traction.iter().any(|t| *t != 0.0) {
            let pair = &self.pair;
            pair.add_displacement(Component::Normal, loaded, 1.0, traction, gap);
        }
    }

    fn add_transposed(&self, loaded: Component, gap: &[f64], sums: &mut [f64]) {
        if gap.iter().any(|g| *g != 0.0) {
            let pair = &self.pair;
            pair.add_transposed(Component::Normal, loaded, 1.0, gap, sums);
        }
    }

    /// The influence on all gaps of pressures with their friction and their own compliance; or its transpose.
    fn multiply(&self, of: &Linear<'_>, x: &[f64], transposed: bool) -> Vec<f64> {
        let n = self.points();
        let mut out = vec![0.0; n];
        if transposed {
            self.add_transposed(Component::Normal, x, &mut out);
        } else {
            self.add(Component::Normal, x, &mut out);
        }
        for (axis, tangent) in TANGENTS.into_iter().enumerate() {
            let drag = &of.terms.drag[axis * n..(axis + 1) * n];
            if !self.along[axis] || drag.iter().all(|d| *d == 0.0) {
                continue;
            }
            if transposed {
                let mut sums = vec![0.0; n];
                self.add_transposed(tangent, x, &mut sums);
                for ((out, sum), drag) in out.iter_mut().zip(sums).zip(drag) {
                    *out += drag * sum;
                }
            } else {
                let traction: Vec<f64> = x.iter().zip(drag).map(|(p, d)| p * d).collect();
                self.add(tangent, &traction, &mut out);
            }
        }
        for (i, (out, x)) in out.iter_mut().zip(x).enumerate() {
            *out += of.terms.own(i) * x;
        }
        out
    }

    /// The solution of the equations, or of the transposed ones, for the columns of `rhs`.
    ///
    /// GMRES, preconditioned by the near inverse of the pair or by the diagonal, with its borders, of unknowns and equations in units of pressure.
    pub(super) fn solved(
        &self,
        of: &Linear<'_>,
        rhs: &Mat<f64>,
        transposed: bool,
        monitor: Monitor<'_>,
    ) -> Result<Mat<f64>, Error> {
        let scaled = Scaled::new(self, of, transposed);
        let mut found = Mat::zeros(rhs.nrows(), rhs.ncols());
        for j in 0..rhs.ncols() {
            let x = scaled.solved(rhs.col_as_slice(j), monitor)?;
            found.col_as_slice_mut(j).copy_from_slice(&x);
        }
        Ok(found)
    }
}

/// The equations in units of pressure: those of the gaps over the compliance of a point, the others over their
/// largest number.
struct Scaled<'a> {
    products: &'a Products,
    of: &'a Linear<'a>,
    transposed: bool,
    /// About the inverse of the pair, where one is known.
    near_inverse: Option<Map>,
    /// Inverse of the diagonal of each point of the set, over its mean.
    inverse: Vec<f64>,
    /// What motions do to the equations of the set, and the equations of the motions (m x k), scaled.
    columns: Vec<Vec<f64>>,
    rows: Vec<Vec<f64>>,
    /// Units of motions and of their equations.
    units: [Vec<f64>; 2],
    /// What the inverse of the gaps makes of the `columns`.
    by_motion: Vec<Vec<f64>>,
    /// `rows by_motion`.
    small: Mat<f64>,
}

impl<'a> Scaled<'a> {
    fn new(products: &'a Products, of: &'a Linear<'a>, transposed: bool) -> Self {
        let contact = of.contact();
        let unit = products.diagonal;
        let own = |&i: &usize| 1.0 / (1.0 + of.terms.own(i) / unit);
        let inverse: Vec<f64> = of.points.iter().map(own).collect();
        let opening = |m: usize| -> Vec<f64> {
            let opening = &of.state.motions[m].opening;
            of.points.iter().map(|&i| opening[i]).collect()
        };
        let work = |m: usize| -> Vec<f64> {
            let motion = &of.state.motions[m];
            (of.points.iter())
                .map(|&i| -contact.work_of_pressure(motion, i))
                .collect()
        };
        let all = 0..of.state.motions.len();
        let (mut columns, mut rows): (Vec<_>, Vec<_>) = (
            all.clone().map(opening).collect(),
            all.clone().map(work).collect(),
        );
        if transposed {
            std::mem::swap(&mut columns, &mut rows);
        }
        let largest = |v: &Vec<f64>| v.iter().fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs()));
        let units = [
            columns
                .iter()
                .map(|c| unit / largest(c))
                .collect::<Vec<f64>>(),
            rows.iter().map(|r| 1.0 / largest(r)).collect(),
        ];
        for (column, size) in columns.iter_mut().zip(&units[0]) {
            for v in column.iter_mut() {
                *v *= size / unit;
            }
        }
        for (row, size) in rows.iter_mut().zip(&units[1]) {
            for v in row.iter_mut() {
                *v *= size;
            }
        }
        let softer = of.points.iter().map(|&i| of.terms.own(i));
        let near_inverse =
            even_softness(softer, unit).and_then(|softer| products.pair.near_inverse(softer));
        let m = rows.len();
        let mut found = Self {
            products,
            of,
            transposed,
            near_inverse,
            inverse,
            columns,
            rows,
            units,
            by_motion: Vec::with_capacity(m),
            small: Mat::zeros(m, m),
        };
        found.by_motion = found.columns.iter().map(|c| found.inverted(c)).collect();
        found.small = Mat::from_fn(m, m, |a, b| dot(&found.rows[a], &found.by_motion[b]));
        found
    }

    /// A field with the values of the points of the set, zero elsewhere.
    fn spread(&self, x: &[f64]) -> Vec<f64> {
        let mut field = vec![0.0; self.products.points()];
        for (&point, x) in self.of.points.iter().zip(x) {
            field[point] = *x;
        }
        field
    }

    /// About the pressures (k) that open the gaps of the set so far, without the motions.
    fn inverted(&self, gap: &[f64]) -> Vec<f64> {
        match &self.near_inverse {
            Some(invert) => {
                let mut found = vec![0.0; self.products.points()];
                invert(&self.spread(gap), &mut found);
                let unit = self.products.diagonal;
                self.of.points.iter().map(|&i| unit * found[i]).collect()
            }
            None => (gap.iter().zip(&self.inverse))
                .map(|(g, inverse)| g * inverse)
                .collect(),
        }
    }

    fn solved(&self, rhs: &[f64], monitor: Monitor<'_>) -> Result<Vec<f64>, Error> {
        let k = self.of.points.len();
        let mut right = rhs.to_vec();
        right[..k]
            .iter_mut()
            .for_each(|b| *b /= self.products.diagonal);
        for (b, unit) in right[k..].iter_mut().zip(&self.units[1]) {
            *b *= unit;
        }
        let size = dot(&right, &right).sqrt();
        let mut x = vec![0.0; rhs.len()];
        let mut left = size;
        let factors = self.small.partial_piv_lu();
        for round in 0..ROUNDS {
            if left <= SOLVED * size {
                break;
            }
            let mut residual = vec![0.0; rhs.len()];
            self.apply(&x, &mut residual);
            residual
                .iter_mut()
                .zip(&right)
                .for_each(|(r, b)| *r = b - *r);
            let before = left;
            left = dot(&residual, &residual).sqrt();
            // rounding stands against more
            if left <= SOLVED * size || round > 0 && left > 0.5 * before {
                break;
            }
            let is_stopped = Cell::new(false);
            gmres(
                |v, out| {
                    is_stopped.set(is_stopped.get() || report(monitor, round, f64::NAN).is_err());
                    if is_stopped.get() {
                        out.fill(0.0);
                    } else {
                        self.apply(v, out);
                    }
                },
                |v, out| {
                    out[..k].copy_from_slice(&self.inverted(&v[..k]));
                    let rest = Mat::from_fn(self.rows.len(), 1, |m, _| {
                        dot(&self.rows[m], &out[..k]) - v[k + m]
                    });
                    let motion = factors.solve(&rest);
                    for (m, column) in self.by_motion.iter().enumerate() {
                        let c = motion[(m, 0)];
                        for (out, p) in out.iter_mut().zip(column) {
                            *out -= p * c;
                        }
                        out[k + m] = c;
                    }
                },
                &mut x,
                &mut residual,
                0.1 * SOLVED * size,
                PRODUCTS,
            );
            if is_stopped.get() {
                return Err(Error::Interrupted);
            }
        }
        if left.is_nan() || left > ENOUGH * size {
            return Err(Error::Singular);
        }
        for (c, unit) in x[k..].iter_mut().zip(&self.units[0]) {
            *c *= unit;
        }
        Ok(x)
    }

    fn apply(&self, x: &[f64], out: &mut [f64]) {
        let k = self.of.points.len();
        let moved = self
            .products
            .multiply(self.of, &self.spread(x), self.transposed);
        for (out, &point) in out.iter_mut().zip(self.of.points) {
            *out = moved[point] / self.products.diagonal;
        }
        for (m, column) in self.columns.iter().enumerate() {
            for (out, n) in out.iter_mut().zip(column) {
                *out += n * x[k + m];
            }
            out[k + m] = dot(&self.rows[m], &x[..k]);
        }
    }
}

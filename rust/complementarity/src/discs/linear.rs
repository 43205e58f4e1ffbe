// SPDX-License-Identifier: MIT OR Apache-2.0
use faer::{Mat, Par};
use mtb_operator::krylov::{Krylov, add_scaled};
use mtb_operator::{LinearOperator, dense, unmonitored, wide};

use super::newton::{Iterate, dot, law, norm};
use super::problem::{DiscProblem, DiscState};

/// Basis vectors GMRES may build.
const LONGEST_BASIS: usize = 150;

/// Unknowns up to which a system that GMRES does not solve is solved by its matrix.
const MOST_DENSE: usize = 1600;

/// Share of its start below which a linear residual is never pushed.
const LEAST_REDUCTION: f64 = 1e-2;

/// The least that it fades to, whose reciprocal is still a number.
const FADED: f64 = 1e-60;
/// Stiffness that the operator adds to the curvature where that rules, in diagonals: 2 to 5 serve alike.
const STIFFENING: f64 = 3.0;

/// The linear system of one Newton step, reduced to what is free.
///
/// Unknowns: the field (both components inside a disc; along the tangent on the rim; along the
/// normal as well if the radii depend on the image) and the multipliers of the resultants.
pub(super) struct LinearStep<'a> {
    problem: &'a DiscProblem<'a>,
    iterate: &'a Iterate,
    /// One at points that take part, zero elsewhere.
    part: Vec<f64>,
    /// Curvature in diagonals; infinite at points that take no part.
    curvature: Vec<f64>,
    /// Weight of the preconditioner given, `S = fading(1 + curvature / diagonal)`.
    share: Vec<f64>,
    /// What stands in for it over that weight, `(1 / S - S) / (STIFFENING diagonal + curvature)`.
    local: Vec<f64>,
    /// Scale of the rows of the resultants.
    row_scale: f64,
    /// Preconditioned columns of the multipliers.
    columns: Vec<Vec<f64>>,
    /// Inverse of the multipliers' own small matrix, row-major.
    schur: Vec<f64>,
    stiffness: Vec<f64>,
}

/// The full Newton step.
pub(super) struct Outcome {
    pub(super) field: Vec<f64>,
    pub(super) multipliers: Vec<f64>,
    /// Radii predicted by the linearised law.
    pub(super) radius: Vec<f64>,
    pub(super) products: usize,
    pub(super) preconditionings: usize,
}

impl<'a> LinearStep<'a> {
    pub(super) fn new(problem: &'a DiscProblem<'a>, iterate: &'a Iterate) -> Self {
        let curvature: Vec<f64> = (iterate.curvature.iter().zip(&iterate.state))
            .map(|(d, state)| match state {
                DiscState::Excluded => f64::INFINITY,
                _ => d / problem.diagonal,
            })
            .collect();
        let part = iterate
            .state
            .iter()
            .map(|state| f64::from(u8::from(*state != DiscState::Excluded)))
            .collect();
        let share: Vec<f64> = curvature.iter().map(|c| fading(1.0 + c)).collect();
        let local = share
            .iter()
            .zip(&iterate.curvature)
            .map(|(s, d)| (1.0 / s - s) / (STIFFENING * problem.diagonal + d))
            .collect();
        let free = iterate
            .state
            .iter()
            .filter(|s| **s != DiscState::Excluded)
            .count();
        let mut step = Self {
            problem,
            iterate,
            part,
            curvature,
            share,
            local,
            row_scale: 1.0,
            columns: Vec::new(),
            schur: Vec::new(),
            stiffness: Vec::new(),
        };
        let Some(first) = problem.resultants.first() else {
            return step;
        };
        step.row_scale = problem.diagonal * (free.max(1) as f64).sqrt()
            / norm(&first.weight).max(f64::MIN_POSITIVE);
        let mut free = vec![0.0; first.direction.len()];
        step.columns = problem
            .resultants
            .iter()
            .map(|r| {
                let mut column = vec![0.0; r.direction.len()];
                step.precondition_field(&r.direction, &mut column, &mut free);
                column
            })
            .collect();
        let m = problem.resultants.len();
        let mut schur = vec![0.0; m * m];
        for (k, resultant) in problem.resultants.iter().enumerate() {
            for (l, column) in step.columns.iter().enumerate() {
                schur[k * m + l] = step.row_scale * dot(&resultant.weight, column);
            }
        }
        step.stiffness = (0..m).map(|k| schur[k * m + k] / step.row_scale).collect();
        for (k, resultant) in problem.resultants.iter().enumerate() {
            schur[k * m + k] += step.row_scale * resultant.softness;
        }
        step.schur = invert_small(&schur, m);
        step
    }

    /// What each resultant gains per unit of its multiplier, as the preconditioner sees it.
    pub(super) fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }

    /// Scale of the rows of the resultants.
    pub(super) fn row_scale(&self) -> f64 {
        self.row_scale
    }

    /// Solves to an absolute residual `target` in the memory of `krylov`.
    pub(super) fn solve(&self, target: f64, krylov: &mut Krylov) -> Outcome {
        let n = self.iterate.radius.len();
        let m = self.problem.resultants.len();
        // the part of the new field that is known: on the rim the radius, elsewhere nothing
        let mut base = self.iterate.field.clone();
        self.reduce(&mut base, false);
        for i in 0..n {
            if self.iterate.state[i] == DiscState::Rim {
                for c in [i, n + i] {
                    base[c] += self.iterate.radius[i] * self.iterate.normal[c];
                }
            }
        }
        // the image of the field is known: the rough product errs by digits of what differs from it alone
        let mut image = vec![0.0; 2 * n];
        let mut difference = base.clone();
        add_scaled(&mut difference, -1.0, &self.iterate.field);
        self.problem.rough.apply(&difference, &mut image);
        add_scaled(&mut image, 1.0, &self.iterate.image);
        let change = self.magnitude_change(&image, Some(&self.iterate.magnitude));
        let mut residual = vec![0.0; 2 * n + m];
        self.assemble_rows(&image, &base, None, change.as_deref(), &mut residual);
        for (k, resultant) in self.problem.resultants.iter().enumerate() {
            let yielded = resultant.softness * self.iterate.multipliers[k];
            residual[2 * n + k] =
                self.row_scale * (dot(&resultant.weight, &base) + yielded - resultant.value);
        }
        for v in &mut residual {
            *v = -*v;
        }
        let start = norm(&residual);
        let mut step = vec![0.0; 2 * n + m];
        // fresh memory costs as much as a product
        let (mut field, mut work) = (difference, image);
        let mut free = vec![0.0; 2 * n];
        let target = target.max(LEAST_REDUCTION * start);
        let rows = residual.clone();
        let krylov = krylov.gmres(
            |x, y| self.apply(self.problem.rough, x, y, &mut field, &mut work),
            |y, x| self.precondition(y, x, &mut free),
            &mut step,
            &mut residual,
            target,
            LONGEST_BASIS,
        );
        let mut products = krylov.steps + 1;
        let is_solved = krylov.residual <= target;
        if !is_solved && let Some((exact, more)) = self.solve_dense(&rows) {
            step = exact;
            products += more;
        }
        let mut field = base;
        for (f, s) in field.iter_mut().zip(&step) {
            *f += s;
        }
        let multipliers = self
            .iterate
            .multipliers
            .iter()
            .zip(&step[2 * n..])
            .map(|(a, b)| a + b)
            .collect();
        let mut radius = self.iterate.radius.clone();
        if law(self.problem).is_some() {
            for i in 0..n {
                if self.iterate.state[i] == DiscState::Rim {
                    let normal = &self.iterate.normal;
                    radius[i] = (field[i] * normal[i] + field[n + i] * normal[n + i]).max(0.0);
                }
            }
        }
        Outcome {
            field,
            multipliers,
            radius,
            products,
            preconditionings: krylov.steps + 1 + m,
        }
    }

    /// The solution for `rows` by the matrix of the system, and the products that it took; `None` of too many
    /// unknowns, or where there is none.
    ///
    /// In line contacts whose two directions both slip no preconditioner that is known serves: their operator couples
    /// all points of a long row, and slip turns from one point to the next.
    fn solve_dense(&self, rows: &[f64]) -> Option<(Vec<f64>, usize)> {
        let n = self.iterate.radius.len();
        let taking = |c: &usize| *c >= 2 * n || self.iterate.state[c % n] != DiscState::Excluded;
        let free: Vec<usize> = (0..rows.len()).filter(taking).collect();
        if free.len() > MOST_DENSE {
            return None;
        }
        let mut matrix = Mat::zeros(free.len(), free.len());
        let mut unit = vec![0.0; rows.len()];
        let (mut column, mut field, mut image) =
            (vec![0.0; rows.len()], vec![0.0; 2 * n], vec![0.0; 2 * n]);
        let is_fixed = law(self.problem).is_none();
        for (j, &c) in free.iter().enumerate() {
            unit[c] = 1.0;
            let operator = self.problem.operator;
            self.apply(operator, &unit, &mut column, &mut field, &mut image);
            unit[c] = 0.0;
            let i = c % n;
            if is_fixed && c < 2 * n && self.iterate.state[i] == DiscState::Rim {
                // nothing moves along the normal
                let normal = &self.iterate.normal;
                for d in [i, n + i] {
                    column[d] += self.problem.diagonal * normal[c] * normal[d];
                }
            }
            for (i, &r) in free.iter().enumerate() {
                matrix[(i, j)] = column[r];
            }
        }
        let lu = dense::Lu::new(matrix, Par::Seq, &unmonitored).ok()?;
        let rhs = Mat::from_fn(free.len(), 1, |i, _| rows[free[i]]);
        let solved = lu.solve_few(rhs.as_ref(), Par::Seq);
        let mut step = vec![0.0; rows.len()];
        for (i, &c) in free.iter().enumerate() {
            step[c] = solved[(i, 0)];
        }
        step.iter()
            .all(|v| v.is_finite())
            .then_some((step, free.len()))
    }

    /// Keeps the free part of a field: everything inside, along the tangent on the rim (and along
    /// the normal if asked), nothing where excluded.
    pub(super) fn reduce(&self, field: &mut [f64], keep_normal: bool) {
        let (first, second) = field.split_at_mut(self.part.len());
        if keep_normal {
            wide(
                #[inline(always)]
                || {
                    for ((x, y), part) in first.iter_mut().zip(second).zip(&self.part) {
                        *x *= part;
                        *y *= part;
                    }
                },
            );
            return;
        }
        let (nx, ny) = self.iterate.normal.split_at(self.part.len());
        wide(
            #[inline(always)]
            || {
                let fields = first.iter_mut().zip(second).zip(&self.part);
                for (((x, y), part), (nx, ny)) in fields.zip(nx.iter().zip(ny)) {
                    let along = *x * nx + *y * ny;
                    *x = part * (*x - along * nx);
                    *y = part * (*y - along * ny);
                }
            },
        );
    }

    /// Change of the radii that follows a change of the image: `image` is the new image (with the
    /// old magnitudes given) or a change of it (without). `None` for fixed radii.
    pub(super) fn magnitude_change(&self, image: &[f64], old: Option<&[f64]>) -> Option<Vec<f64>> {
        let law = law(self.problem)?;
        let n = self.iterate.radius.len();
        let normal = &self.iterate.normal;
        let change: Vec<f64> = (0..n)
            .map(|i| {
                if self.iterate.state[i] == DiscState::Rim {
                    let new = -(normal[i] * image[i] + normal[n + i] * image[n + i]);
                    new - old.map_or(0.0, |old| old[i])
                } else {
                    0.0
                }
            })
            .collect();
        let mut derivative = vec![0.0; n];
        law.derivative(&self.iterate.magnitude, &change, &mut derivative);
        Some(derivative)
    }

    /// Rows of the field: `image` inside; on the rim along the tangent `image + curvature field`,
    /// along the normal `diagonal (normal_part - radius_change)` where radii depend on the image.
    pub(super) fn assemble_rows(
        &self,
        image: &[f64],
        field: &[f64],
        normal_part: Option<&[f64]>,
        radius_change: Option<&[f64]>,
        rows: &mut [f64],
    ) {
        let n = self.part.len();
        let (nx, ny) = self.iterate.normal.split_at(n);
        let (ux, uy) = image.split_at(n);
        let (fx, fy) = field.split_at(n);
        let (rows_x, rows_y) = rows[..2 * n].split_at_mut(n);
        let known = nx
            .iter()
            .zip(ny)
            .zip(&self.part)
            .zip(&self.iterate.curvature);
        wide(
            #[inline(always)]
            || {
                let fields = ux.iter().zip(uy).zip(fx.iter().zip(fy));
                let rows = rows_x.iter_mut().zip(rows_y.iter_mut());
                // normals and curvatures vanish inside
                for (((((nx, ny), part), curvature), ((ux, uy), (fx, fy))), (x, y)) in
                    known.zip(fields).zip(rows)
                {
                    let (u, v) = (ux + curvature * fx, uy + curvature * fy);
                    let along = u * nx + v * ny;
                    *x = part * (u - along * nx);
                    *y = part * (v - along * ny);
                }
            },
        );
        let Some(change) = radius_change else {
            return;
        };
        for i in 0..n {
            let own = normal_part.map_or(0.0, |x| nx[i] * x[i] + ny[i] * x[n + i]);
            let along = self.part[i] * self.problem.diagonal * (own - change[i]);
            rows[i] += along * nx[i];
            rows[n + i] += along * ny[i];
        }
    }

    /// Overwrites `y` with the left-hand side at `x` by an `operator`, that of the problem or the rough one; `field` and
    /// `image` (2n) are work space.
    pub(super) fn apply(
        &self,
        operator: &dyn LinearOperator,
        x: &[f64],
        y: &mut [f64],
        field: &mut [f64],
        image: &mut [f64],
    ) {
        let n = self.iterate.radius.len();
        field.copy_from_slice(&x[..2 * n]);
        self.reduce(field, law(self.problem).is_some());
        operator.apply(field, image);
        for (c, resultant) in x[2 * n..].iter().zip(self.problem.resultants) {
            for (f, e) in image.iter_mut().zip(&resultant.direction) {
                *f -= c * e;
            }
        }
        let change = self.magnitude_change(image, None);
        self.assemble_rows(image, field, Some(field), change.as_deref(), y);
        for (k, resultant) in self.problem.resultants.iter().enumerate() {
            let yielded = resultant.softness * x[2 * n + k];
            y[2 * n + k] = self.row_scale * (dot(&resultant.weight, field) + yielded);
        }
    }

    /// `S P M P S + (1 - S^2) / (STIFFENING diagonal + curvature)` on the free part, `1 / diagonal` along normals
    /// that may move.
    ///
    /// Where the curvature outweighs the operator its inverse is nearly the curvature's, whatever the wave
    /// length. `M` knows little of curvature and is largest for the waves that the operator hardly sees
    /// (in rolling those across the rolling direction, the more so the finer the grid), so it must fade
    /// there.
    ///
    /// `free` (2n) is work space.
    fn precondition_field(&self, y: &[f64], x: &mut [f64], free: &mut [f64]) {
        let n = self.iterate.radius.len();
        free.copy_from_slice(&y[..2 * n]);
        self.reduce(free, false);
        let (first, second) = free.split_at_mut(n);
        wide(
            #[inline(always)]
            || {
                for ((x, y), share) in first.iter_mut().zip(second).zip(&self.share) {
                    *x *= share;
                    *y *= share;
                }
            },
        );
        let preconditioner = self.problem.preconditioner;
        preconditioner.invert(&self.curvature, free, x);
        self.reduce(x, false);
        let (first, second) = x.split_at_mut(n);
        for (x, free) in [(first, &free[..n]), (second, &free[n..])] {
            wide(
                #[inline(always)]
                || {
                    let known = self.share.iter().zip(&self.local);
                    for ((x, f), (share, local)) in x.iter_mut().zip(free).zip(known) {
                        *x = share * *x + local * f;
                    }
                },
            );
        }
        if law(self.problem).is_some() {
            for i in 0..n {
                if self.iterate.state[i] == DiscState::Rim {
                    let (nx, ny) = (self.iterate.normal[i], self.iterate.normal[n + i]);
                    let along = (nx * y[i] + ny * y[n + i]) / self.problem.diagonal;
                    x[i] += along * nx;
                    x[n + i] += along * ny;
                }
            }
        }
    }

    pub(super) fn precondition(&self, y: &[f64], x: &mut [f64], free: &mut [f64]) {
        let n2 = 2 * self.iterate.radius.len();
        let m = self.problem.resultants.len();
        let (x, multipliers) = x.split_at_mut(n2);
        self.precondition_field(y, x, free);
        let missing: Vec<f64> = (0..m)
            .map(|k| y[n2 + k] - self.row_scale * dot(&self.problem.resultants[k].weight, x))
            .collect();
        for k in 0..m {
            let c = dot(&self.schur[k * m..(k + 1) * m], &missing);
            multipliers[k] = c;
            for (a, b) in x.iter_mut().zip(&self.columns[k]) {
                *a += c * b;
            }
        }
    }
}

/// How the preconditioner given fades with the curvature: `c^(-5/4)` (powers from 1 to 2 serve alike).
fn fading(c: f64) -> f64 {
    (1.0 / (c * c.sqrt().sqrt())).max(FADED)
}

/// Inverse of a small row-major matrix by Gauss-Jordan elimination with row exchanges; directions
/// without a pivot are left out.
fn invert_small(matrix: &[f64], m: usize) -> Vec<f64> {
    let mut a = matrix.to_vec();
    let mut inverse = vec![0.0; m * m];
    for k in 0..m {
        inverse[k * m + k] = 1.0;
    }
    let size = norm(matrix);
    for k in 0..m {
        let pivot = (k..m).max_by(|i, j| a[i * m + k].abs().total_cmp(&a[j * m + k].abs()));
        let Some(p) = pivot.filter(|p| a[p * m + k].abs() > 1e-14 * size) else {
            continue;
        };
        for c in 0..m {
            a.swap(k * m + c, p * m + c);
            inverse.swap(k * m + c, p * m + c);
        }
        let scale = 1.0 / a[k * m + k];
        for c in 0..m {
            a[k * m + c] *= scale;
            inverse[k * m + c] *= scale;
        }
        for r in (0..m).filter(|r| *r != k) {
            let factor = a[r * m + k];
            for c in 0..m {
                a[r * m + c] -= factor * a[k * m + c];
                inverse[r * m + c] -= factor * inverse[k * m + c];
            }
        }
    }
    inverse
}

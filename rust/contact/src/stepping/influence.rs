// SPDX-License-Identifier: MIT OR Apache-2.0
use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use mtb_operator::{Compliance, Component, Monitor, check_factors, report};

use super::opened::Opened;
use crate::columns::{self, largest};
use crate::error::{Error, check};

/// What a sliding pair does to its own gap, each component of the traction apart.
///
/// Kept column by column, so that points without pressure cost nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Influence {
    points: usize,
    normal: Vec<f64>,
    along: [Option<Vec<f64>>; 2],
}

/// What the parts of an influence besides `C_nn` are multiplied with.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Terms {
    /// Friction coefficient times direction of sliding (2n).
    pub(super) drag: Vec<f64>,
    /// Diagonal compliance (n) [m/Pa]; empty where there is none.
    pub(super) diagonal: Vec<f64>,
}

impl Terms {
    /// Diagonal compliance of a point [m/Pa].
    pub(super) fn own(&self, point: usize) -> f64 {
        self.diagonal.get(point).copied().unwrap_or(0.0)
    }

    /// Adds what the diagonal opens under pressures.
    pub(super) fn add_own(&self, pressure: &[f64], gap: &mut [f64]) {
        for ((gap, p), d) in gap.iter_mut().zip(pressure).zip(&self.diagonal) {
            *gap += d * p;
        }
    }
}

impl Influence {
    /// Influence of tractions on the lower body on the gap: `C_nn`, `C_nx` and `C_ny`.
    ///
    /// A tangential influence that is nothing but rounding (like half-spaces) is left out.
    ///
    /// # Errors
    /// More points than the memory holds; an interruption by the monitor.
    pub fn of(compliance: &dyn Compliance, monitor: Monitor<'_>) -> Result<Self, Error> {
        let made = Self::uncoupled(compliance, monitor)?;
        let n = made.points;
        // three blocks, the one being turned, and the factors
        let needed = 48.0 * (n as f64).powi(2) + 3.0 * compliance.influence_memory();
        check_factors(n, needed)?;
        let noise = 1e-14 * largest(&made.normal);
        let coupled = |axis| {
            let block = columns_of(compliance, axis, monitor);
            block.map(|b| Some(b).filter(|b| largest(b) > noise))
        };
        let along = [coupled(Component::X)?, coupled(Component::Y)?];
        Ok(Self { along, ..made })
    }

    /// The same of pressures alone: friction opens and closes no gap.
    ///
    /// # Errors
    /// As [`Influence::of`].
    pub fn uncoupled(compliance: &dyn Compliance, monitor: Monitor<'_>) -> Result<Self, Error> {
        let n = compliance.points();
        let needed = 24.0 * (n as f64).powi(2) + compliance.influence_memory();
        check_factors(n, needed)?;
        Ok(Self {
            points: n,
            normal: columns_of(compliance, Component::Normal, monitor)?,
            along: [None, None],
        })
    }

    /// The same from stored matrices (n x n, column-major) [m/Pa].
    ///
    /// # Errors
    /// Matrices of other lengths or with numbers that are not finite.
    pub fn from_columns(
        points: usize,
        normal: Vec<f64>,
        along: [Option<Vec<f64>>; 2],
    ) -> Result<Self, Error> {
        check("normal", &normal, points * points)?;
        for (name, block) in ["along_x", "along_y"].into_iter().zip(&along) {
            if let Some(block) = block {
                check(name, block, points * points)?;
            }
        }
        Ok(Self {
            points,
            normal,
            along,
        })
    }

    /// Number of contact points.
    pub fn points(&self) -> usize {
        self.points
    }

    /// `C_nn` (n x n, column-major) [m/Pa].
    pub fn normal(&self) -> &[f64] {
        &self.normal
    }

    /// `C_nx` and `C_ny` (n x n, column-major) [m/Pa]; `None` where they do nothing.
    pub fn along(&self) -> [Option<&[f64]>; 2] {
        [self.along[0].as_deref(), self.along[1].as_deref()]
    }

    /// Puts column `j` of `C_nn + C_nx drag_x + C_ny drag_y + diagonal`, the rows in `runs`, to `column`.
    pub(super) fn put_column(
        &self,
        j: usize,
        terms: &Terms,
        runs: &[Range<usize>],
        column: &mut [f64],
    ) {
        let n = self.points;
        let normal = &self.normal[j * n..(j + 1) * n];
        let along = self.along.iter().enumerate().filter_map(|(axis, block)| {
            let factor = terms.drag[axis * n + j];
            let block = block.as_ref().filter(|_| factor != 0.0)?;
            Some((factor, &block[j * n..(j + 1) * n]))
        });
        let along: Vec<_> = along.collect();
        let mut rest = column;
        for run in runs {
            let (here, after) = rest.split_at_mut(run.len());
            here.copy_from_slice(&normal[run.clone()]);
            for (factor, block) in &along {
                let pairs = here.iter_mut().zip(&block[run.clone()]);
                pairs.for_each(|(to, a)| *to += factor * a);
            }
            if run.contains(&j) {
                here[j - run.start] += terms.own(j);
            }
            rest = after;
        }
    }

    /// Entry (i, j) of the same matrix.
    pub(super) fn entry(&self, i: usize, j: usize, terms: &Terms) -> f64 {
        let n = self.points;
        let mut a = self.normal[j * n + i];
        for (axis, block) in self.along.iter().enumerate() {
            if let Some(block) = block {
                a += terms.drag[axis * n + j] * block[j * n + i];
            }
        }
        if i == j { a + terms.own(j) } else { a }
    }

    /// Adds `(C_nn + C_nx drag_x + C_ny drag_y + diagonal) p` to `gap`.
    pub(super) fn add_product(&self, pressure: &[f64], terms: &Terms, gap: &mut [f64]) {
        terms.add_own(pressure, gap);
        self.add_pressed(pressure, gap);
        self.add_friction(&terms.drag, pressure, gap);
    }

    /// Adds `C_nn p` to `gap`.
    pub(super) fn add_pressed(&self, pressure: &[f64], gap: &mut [f64]) {
        add_columns(&self.normal, self.points, |j| pressure[j], gap);
    }

    /// Adds what a friction (n) [Pa] in `direction` (2n) opens to `gap`.
    pub(super) fn add_friction(&self, direction: &[f64], friction: &[f64], gap: &mut [f64]) {
        let n = self.points;
        for (axis, block) in self.along.iter().enumerate() {
            if let Some(block) = block {
                let along = &direction[axis * n..(axis + 1) * n];
                add_columns(block, n, |j| friction[j] * along[j], gap);
            }
        }
    }

    /// Gaps (n) that pressures, and tractions along both tangents, open: a column each.
    pub(super) fn products(&self, pressure: &Mat<f64>, traction: [&Mat<f64>; 2]) -> Mat<f64> {
        let mut gap = Mat::zeros(self.points, pressure.ncols());
        let along = self.along.iter().zip(traction);
        let along = along.filter_map(|(block, given)| Some((block.as_ref()?, given)));
        for (block, given) in [(&self.normal, pressure)].into_iter().chain(along) {
            // most changes leave most of them as they are
            if given.norm_max() > 0.0 {
                let (block, seq) = (self.matrix(block), Par::Seq);
                matmul(gap.as_mut(), Accum::Add, block, given, 1.0, seq);
            }
        }
        gap
    }

    /// `C_nn^T gap` for a column each.
    pub(super) fn transposed_normal(&self, gap: &Mat<f64>) -> Mat<f64> {
        self.transposed(&self.normal, gap)
    }

    /// `C_nx^T gap` or `C_ny^T gap` for a column each; `None` where it does nothing.
    pub(super) fn transposed_along(&self, axis: usize, gap: &Mat<f64>) -> Option<Mat<f64>> {
        Some(self.transposed(self.along[axis].as_ref()?, gap))
    }

    fn transposed(&self, block: &[f64], gap: &Mat<f64>) -> Mat<f64> {
        // `gap^T block`: the product with the transposed block would pack the whole of it
        let (n, cases) = (self.points, gap.ncols());
        let (left, block, seq) = (gap.transpose(), self.matrix(block), Par::Seq);
        let mut columns = Mat::zeros(n, cases);
        if cases == 1 {
            let out = columns.as_mut().transpose_mut();
            matmul(out, Accum::Replace, left, block, 1.0, seq);
            return columns;
        }
        let mut out = Mat::zeros(cases, n);
        matmul(out.as_mut(), Accum::Replace, left, block, 1.0, seq);
        for j in 0..cases {
            for (i, to) in columns.col_as_slice_mut(j).iter_mut().enumerate() {
                *to = out[(j, i)];
            }
        }
        columns
    }

    fn matrix<'a>(&self, block: &'a [f64]) -> MatRef<'a, f64> {
        MatRef::from_column_major_slice(block, self.points, self.points)
    }

    /// The matrix for `terms` in rows, as the general solver takes it; `true` where it is symmetric.
    pub(super) fn rows(&self, terms: &Terms) -> (Vec<f64>, bool) {
        let n = self.points;
        let mut rows = transposed(&self.normal, n);
        for (own, diagonal) in rows.iter_mut().step_by(n + 1).zip(&terms.diagonal) {
            *own += diagonal;
        }
        let mut symmetric = true;
        for (axis, block) in self.along.iter().enumerate() {
            let drag = &terms.drag[axis * n..(axis + 1) * n];
            if let Some(block) = block
                && drag.iter().any(|d| *d != 0.0)
            {
                symmetric = false;
                for (i, row) in rows.chunks_exact_mut(n).enumerate() {
                    for (j, a) in row.iter_mut().enumerate() {
                        *a += drag[j] * block[j * n + i];
                    }
                }
            }
        }
        (rows, symmetric)
    }
}

/// The influence of a component of the traction on the gap, column by column.
fn columns_of(
    compliance: &dyn Compliance,
    component: Component,
    monitor: Monitor<'_>,
) -> Result<Vec<f64>, Error> {
    let n = compliance.points();
    let mut rows = vec![0.0; n * n];
    compliance.add_influence(Component::Normal, component, 1.0, &mut rows);
    report(monitor, 0, f64::NAN)?;
    let columns = transposed(&rows, n);
    report(monitor, 0, f64::NAN)?;
    Ok(columns)
}

/// Products of steps with the same friction: the sum of the dense parts is formed once it has lasted for some steps.
#[derive(Default)]
pub(super) struct Sum {
    drag: Vec<f64>,
    steps: usize,
    columns: Vec<f64>,
}

/// Steps whose products with the parts cost about as much more as forming their sum.
const WORTH: usize = 2;

impl Sum {
    /// Begins a step with the friction `drag`.
    pub(super) fn turn_to(&mut self, drag: &[f64]) {
        if self.drag == drag {
            self.steps += 1;
        } else {
            self.drag.clear();
            self.drag.extend_from_slice(drag);
            self.steps = 0;
            self.columns.clear();
        }
    }

    /// What `pressure` opens in this step.
    pub(super) fn open(&mut self, influence: &Influence, pressure: &[f64], opened: &mut Opened) {
        let n = influence.points;
        opened.drag.clone_from(&self.drag);
        opened.pressure.clear();
        opened.pressure.extend_from_slice(pressure);
        opened.normal.clear();
        opened.normal.resize(n, 0.0);
        if self.steps < WORTH || influence.along.iter().all(Option::is_none) {
            influence.add_pressed(pressure, &mut opened.normal);
            let friction = opened.friction.get_or_insert_default();
            friction.clear();
            friction.resize(n, 0.0);
            return influence.add_friction(&self.drag, pressure, friction);
        }
        if self.columns.is_empty() {
            self.columns.extend_from_slice(&influence.normal);
            for (axis, block) in influence.along.iter().enumerate() {
                let Some(block) = block else { continue };
                let factors = &self.drag[axis * n..(axis + 1) * n];
                let pairs = self.columns.chunks_exact_mut(n).zip(block.chunks_exact(n));
                for ((sum, part), factor) in pairs.zip(factors).filter(|(_, f)| **f != 0.0) {
                    for (s, a) in sum.iter_mut().zip(part) {
                        *s += factor * a;
                    }
                }
            }
        }
        opened.friction = None;
        add_columns(&self.columns, n, |j| pressure[j], &mut opened.normal);
    }
}

/// `out += sum_j factor(j) column_j`, zero factors skipped.
fn add_columns(matrix: &[f64], n: usize, factor: impl Fn(usize) -> f64, out: &mut [f64]) {
    let column = |j: usize| &matrix[j * n..(j + 1) * n];
    let used = (0..n).filter_map(|j| Some((column(j), factor(j))).filter(|(_, f)| *f != 0.0));
    columns::add_columns(&used.collect::<Vec<_>>(), out);
}

fn transposed(a: &[f64], n: usize) -> Vec<f64> {
    let mut t = vec![0.0; n * n];
    for (i, row) in a.chunks_exact(n.max(1)).enumerate() {
        for (j, v) in row.iter().enumerate() {
            t[j * n + i] = *v;
        }
    }
    t
}

/// Ascending points as runs of neighbours.
pub(super) fn runs(points: &[usize]) -> Vec<Range<usize>> {
    let neighbours = points.chunk_by(|a, b| a + 1 == *b);
    neighbours.map(|run| run[0]..run[0] + run.len()).collect()
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! A space of temperatures that holds the answers of a conducting body to fluxes through its contact points.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut};
use mtb_operator::{MEMORY_LIMIT, Monitor, check_memory, reset_workers};
use rayon::prelude::*;

use super::assembly::Lower;
use super::columns::{Random, columns_of, inner, par, symmetric_eigen, times};
use super::conduction::ConductingBody;
use super::factor::{Factor, Failure, SparseColumn};
use super::factorised::poll;
use crate::Error;

/// Ratio of two neighbouring durations at first; it is halved in logarithms wherever the modes do not serve between.
const RATIO: f64 = 10.0;
/// Halvings at most: durations that are closer give nothing new.
const HALVINGS: usize = 4;
/// Part of a field of temperatures that the modes may leave out, in the norm of heat.
const TOLERANCE: f64 = 1e-5;
/// Part of the largest square above which what is left of a column is orthogonal to the modes to 13 digits.
const SURE: f64 = 1e-6;
/// Fluxes that are answered together.
const BATCH: usize = 64;
/// Fluxes beyond the rank of what is new that show it is all there is [HalkoMartinssonTropp2011].
const SPARE: usize = 6;
/// Answers of films to films before them.
const FILMS: usize = 4;
/// Columns that one thread takes through the factor.
const COLUMNS: usize = 16;

/// Modes on their way: orthonormal in the norm of heat.
pub(super) struct Basis<'a> {
    body: &'a ConductingBody,
    pub(super) trace: &'a [SparseColumn],
    /// Columns (ranks, r), one after the other.
    pub(super) columns: Vec<f64>,
    random: Random,
}

impl<'a> Basis<'a> {
    /// The uniform temperature, and the answers to fluxes through the contact points.
    pub(super) fn spanning(
        body: &'a ConductingBody,
        trace: &'a [SparseColumn],
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let mut columns = vec![1.0; body.mesh().nodes().len()];
        let capacity: f64 = body.capacity().times(&columns).iter().sum();
        columns.fill(1.0 / capacity.sqrt());
        let mut basis = Self {
            body,
            trace,
            columns,
            random: Random(0),
        };
        let (shortest, longest) = basis.durations();
        let parts = ((longest / shortest).ln() / RATIO.ln()).ceil().max(1.0);
        let at = |k: f64| shortest * (longest / shortest).powf(k / parts);
        for k in 0..=parts as usize {
            let factor = body.factor(at(k as f64), monitor)?;
            basis.serve(&factor, BATCH, monitor)?;
        }
        let mut open: Vec<f64> = (0..parts as usize).map(|k| k as f64 + 0.5).collect();
        for halving in 1..=HALVINGS {
            let apart = 0.5_f64.powi(halving as i32 + 1);
            let mut next = Vec::new();
            for middle in open {
                let factor = body.factor(at(middle), monitor)?;
                if basis.serve(&factor, 2 * SPARE, monitor)? > TOLERANCE {
                    next.extend([middle - apart, middle + apart]);
                }
            }
            open = next;
        }
        Ok(basis)
    }

    /// Durations in which the finest elements under the contact, and in which the whole body become uniform [s].
    fn durations(&self) -> (f64, f64) {
        let (capacity, conduction) = (self.body.capacity(), self.body.conduction());
        let own = |matrix: &Lower, k: usize| matrix.value[matrix.start[k]];
        let fastest = self
            .trace
            .iter()
            .flatten()
            .map(|&(k, _)| own(conduction, k) / own(capacity, k))
            .fold(0.0, f64::max);
        let size: f64 = (0..3)
            .map(|c| {
                let along = self.body.mesh().nodes().iter().map(|x| x[c]);
                let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
                    (l.min(x), h.max(x))
                });
                (high - low).powi(2)
            })
            .sum();
        // of the slowest mode of a length
        let slowest = self.body.conductor().diffusivity() * std::f64::consts::PI.powi(2) / size;
        // the fastest modes are some times faster than single nodes
        (1.0 / (RATIO * fastest), RATIO / slowest.min(fastest))
    }

    pub(super) fn rows(&self) -> usize {
        self.body.mesh().nodes().len()
    }

    fn len(&self) -> usize {
        self.columns.len() / self.rows()
    }

    /// `count` fluxes through the contact points: in the first batch a uniform one, then random ones.
    fn fluxes(&mut self, count: usize, is_first: bool) -> Vec<f64> {
        let (rows, trace) = (self.rows(), self.trace);
        let mut values = vec![0.0; rows * count];
        for (k, column) in values.chunks_mut(rows).enumerate() {
            add_fluxes(column, trace, || {
                if is_first && k == 0 {
                    1.0
                } else {
                    self.random.sign()
                }
            });
        }
        values
    }

    /// What the films do in a step, and what they do to that: with these the modes serve other conductivities, beside
    /// which the films are others.
    fn answers_of_films(&self, factor: &Factor) -> Result<Vec<f64>, Failure> {
        let area: f64 = self.trace.iter().flatten().map(|(_, b)| b).sum();
        let mut found = Vec::new();
        let mut column = vec![1.0; self.rows()];
        for _ in 0..FILMS {
            column = self.body.films().times(&column);
            let total: f64 = column.iter().sum();
            if total <= 0.0 {
                break;
            }
            // as much heat as through the contact points
            for f in &mut column {
                *f *= area / total;
            }
            factor.solve(&mut column)?;
            found.extend_from_slice(&column);
        }
        Ok(found)
    }

    /// Adds what the modes leave out of the answers at the end of a step; the largest part of one that they left out
    /// before, of `first` fluxes.
    fn serve(&mut self, factor: &Factor, first: usize, monitor: Monitor<'_>) -> Result<f64, Error> {
        let rows = self.rows();
        let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
        let (mut is_first, mut count) = (true, first);
        loop {
            let mut values = self.fluxes(count, is_first);
            values
                .par_chunks_mut(rows * COLUMNS)
                .try_for_each(|part| factor.solve(part))
                .map_err(|_| Error::OutOfMemory { unknowns: rows })?;
            if is_first {
                let films = self.answers_of_films(factor);
                values.extend(films.map_err(|_| Error::OutOfMemory { unknowns: rows })?);
            }
            poll(monitor, 4)?;
            let (shares, left, squares) = self.left(&values);
            if is_first {
                let parts = (0..count).map(|k| (left[(k, k)].max(0.0) / squares[k]).sqrt());
                worst = parts.fold(worst, f64::max);
            }
            largest = squares.into_iter().fold(largest, f64::max);
            let kept = self.append(&values, &shares, &left, largest)?;
            poll(monitor, 4)?;
            if kept + SPARE <= values.len() / rows {
                return Ok(worst);
            }
            (is_first, count) = (false, BATCH);
        }
    }

    /// Shares of the modes in columns, the products of what is left of them, and the squares of them all.
    fn left(&self, values: &[f64]) -> (Mat<f64>, Mat<f64>, Vec<f64>) {
        let rows = self.rows();
        let held = times(self.body.capacity(), values, rows);
        let held = columns_of(&held, rows);
        let shares = inner(columns_of(&self.columns, rows), held);
        let mut left = inner(columns_of(values, rows), held);
        let squares = (0..left.nrows()).map(|k| left[(k, k)]).collect();
        let of_modes = inner(shares.as_ref(), shares.as_ref());
        left -= of_modes;
        (shares, left, squares)
    }

    /// Adds directions of what the modes leave of columns, where they count beside the `largest` square;
    /// how many.
    fn append(
        &mut self,
        values: &[f64],
        shares: &Mat<f64>,
        left: &Mat<f64>,
        largest: f64,
    ) -> Result<usize, Error> {
        let rows = self.rows();
        let (vectors, squares) = symmetric_eigen(left)?;
        let kept: Vec<usize> = (0..squares.len())
            .filter(|&k| squares[k] > TOLERANCE.powi(2) * largest)
            .collect();
        let count = kept.len();
        if count == 0 {
            return Ok(0);
        }
        check_memory(
            self.trace.len(),
            (16 * (self.columns.len() + rows * count)) as f64,
            MEMORY_LIMIT,
        )?;
        let turn = Mat::from_fn(squares.len(), count, |i, k| {
            vectors[(i, kept[k])] / squares[kept[k]].sqrt()
        });
        let mut found = self.cleared(values, shares, &turn);
        if squares[kept[0]] < SURE * largest {
            // once more: what is small has lost digits
            let (shares, left, _) = self.left(&found);
            let (vectors, squares) = symmetric_eigen(&left)?;
            let turn = Mat::from_fn(count, count, |i, k| vectors[(i, k)] / squares[k].sqrt());
            found = self.cleared(&found, &shares, &turn);
        }
        reset_workers();
        self.columns.extend_from_slice(&found);
        Ok(count)
    }

    /// Sums of columns without the modes.
    fn cleared(&self, values: &[f64], shares: &Mat<f64>, turn: &Mat<f64>) -> Vec<f64> {
        let rows = self.rows();
        let shares = shares * turn;
        let mut found = vec![0.0; rows * turn.ncols()];
        let mut into = MatMut::from_column_major_slice_mut(&mut found, rows, turn.ncols());
        let values = columns_of(values, rows);
        matmul(
            into.as_mut(),
            Accum::Replace,
            values,
            turn.as_ref(),
            1.0,
            par(),
        );
        let modes = columns_of(&self.columns, rows);
        matmul(into, Accum::Add, modes, shares.as_ref(), -1.0, par());
        found
    }

    /// What a matrix does between the modes.
    pub(super) fn reduced(&self, matrix: &Lower) -> Mat<f64> {
        let (rows, count) = (self.rows(), self.len());
        let modes = columns_of(&self.columns, rows);
        let mut found = Mat::zeros(count, count);
        for start in (0..count).step_by(BATCH) {
            let end = (start + BATCH).min(count);
            let moved = times(matrix, &self.columns[start * rows..end * rows], rows);
            let part = inner(
                modes.subcols(start, count - start),
                columns_of(&moved, rows),
            );
            for j in 0..end - start {
                for i in j..count - start {
                    found[(start + i, start + j)] = part[(i, j)];
                    found[(start + j, start + i)] = part[(i, j)];
                }
            }
        }
        found
    }
}

fn add_fluxes(column: &mut [f64], trace: &[SparseColumn], mut flux: impl FnMut() -> f64) {
    for point in trace {
        let q = flux();
        for (k, b) in point {
            column[*k] += b * q;
        }
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! The tractions that keep points where they are: what makes many steps with the same points quick.
//!
//! At base points, which include all that are in contact, `C t + M a = v - o` and `W' t = -w` with the displacement `v`
//! and the offset `o`. The inverse gives `t` and `a` by `v`, which is zero where a point sticks. Unknown are then only
//! the slips and the gaps of those base points that do not stick, a much smaller system than that of all tractions.

use faer::Mat;
use mtb_operator::dense::Lu;
use mtb_operator::{Monitor, reset_workers};

use super::matrix::{product, threads};
use super::newton::{Iterate, Unknowns, even_rows};
use super::{CoupledContact, PointState, independent};
use crate::error::Error;

/// Share of the unknowns of all base points from which on the smaller system saves nothing.
const WORTH: f64 = 0.8;

/// Steps without an inverse after which one is made: it costs about as much as these.
const MISSES: usize = 3;

/// Base points, over those in contact, from which on a new base leaves out those that are not.
const WIDEST: f64 = 1.3;

/// The inverse for some base points and free motions.
#[derive(Debug)]
pub struct Inverse {
    base: Vec<usize>,
    outside: Vec<usize>,
    /// (3n, m)
    motions: Mat<f64>,
    /// Tractions of the base points and amplitudes, then displacements of the points outside, by displacements of the base
    /// points and work (3n + m, 3k + m).
    response: Mat<f64>,
}

/// An inverse from step to step, made when it is worth its cost.
#[derive(Debug, Default)]
pub struct KeptInverse {
    inverse: Option<Inverse>,
    misses: usize,
    /// Points (n) in contact in steps without an inverse since the last one was made.
    seen: Vec<bool>,
    /// Motions that were given, and their independent combinations.
    shares: Option<(Mat<f64>, Mat<f64>)>,
}

/// What an inverse says under an offset.
pub(super) struct About<'a> {
    inverse: &'a Inverse,
    offset: &'a [f64],
    /// Where all base points stick (3n + m).
    stuck: Vec<f64>,
}

impl KeptInverse {
    /// Independent combinations of the motions `given`.
    pub(super) fn shares(&mut self, given: &Mat<f64>) -> Result<Mat<f64>, Error> {
        if let Some((known, shares)) = &self.shares
            && are_same(known, given)
        {
            return Ok(shares.clone());
        }
        let shares = independent(given)?;
        self.shares = Some((given.clone(), shares.clone()));
        Ok(shares)
    }

    /// The inverse for a contact; `None` if there is none yet, or the contact has a diagonal compliance, which may
    /// differ from step to step.
    pub(super) fn for_contact(
        &mut self,
        contact: &CoupledContact,
        monitor: Monitor<'_>,
    ) -> Result<Option<&Inverse>, Error> {
        if !contact.diagonal.is_empty() {
            return Ok(None);
        }
        if (self.inverse.as_ref())
            .is_some_and(|inverse| !are_same(&inverse.motions, &contact.motions))
        {
            (self.inverse, self.misses) = (None, 0);
        }
        if self.misses >= MISSES {
            let closed = self.seen.iter().filter(|seen| **seen).count();
            if let Some(old) = self.inverse.take()
                && (old.base.len() as f64) < WIDEST * closed as f64
            {
                for &i in &old.base {
                    self.seen[i] = true;
                }
            }
            let base = (0..self.seen.len()).filter(|&i| self.seen[i]).collect();
            self.inverse = Inverse::new(contact, base, monitor)?;
            self.misses = 0;
            self.seen.clear();
        }
        Ok(self.inverse.as_ref())
    }

    /// Counts a step that was not served.
    pub(super) fn miss(&mut self, points: &[PointState]) {
        self.misses += 1;
        self.seen.resize(points.len(), false);
        for (seen, point) in self.seen.iter_mut().zip(points) {
            *seen |= *point != PointState::Open;
        }
    }
}

/// Matrices of different shapes cannot be compared.
fn are_same(one: &Mat<f64>, other: &Mat<f64>) -> bool {
    one.ncols() == other.ncols() && one.nrows() == other.nrows() && one == other
}

impl Inverse {
    /// For the points `base`; `None` if there is none.
    fn new(
        contact: &CoupledContact,
        base: Vec<usize>,
        monitor: Monitor<'_>,
    ) -> Result<Option<Self>, Error> {
        let (n, m, k) = (contact.points(), contact.work.len(), base.len());
        let mut is_base = vec![false; n];
        for &i in &base {
            is_base[i] = true;
        }
        let outside: Vec<usize> = (0..n).filter(|&i| !is_base[i]).collect();
        let places = |points: &[usize]| -> Vec<usize> {
            (0..3)
                .flat_map(|c| points.iter().map(move |i| c * n + i))
                .collect()
        };
        let (inner, outer) = (places(&base), places(&outside));
        let size = 3 * k + m;
        let influence = |rows: &[usize], row: usize, column: usize| {
            if column < 3 * k {
                contact.matrix.compliance[(rows[row], inner[column])]
            } else {
                contact.motions[(rows[row], column - 3 * k)]
            }
        };
        let mut matrix = Mat::from_fn(size, size, |row, column| {
            if row < 3 * k {
                influence(&inner, row, column)
            } else if column < 3 * k {
                contact.motions[(inner[column], row - 3 * k)] * contact.area[inner[column] % n]
            } else {
                0.0
            }
        });
        let Some(scales) = even_rows(&mut matrix) else {
            return Ok(None);
        };
        let mut unit = Mat::zeros(size, size);
        for (i, scale) in scales.iter().enumerate() {
            unit[(i, i)] = scale.recip();
        }
        let par = faer::get_global_parallelism();
        let found = Lu::new(matrix, par, monitor)?.solve(unit.as_ref(), par, monitor)?;
        let beyond = Mat::from_fn(outer.len(), size, |row, column| {
            influence(&outer, row, column)
        }) * &found;
        reset_workers();
        if !(found.is_all_finite() && beyond.is_all_finite()) {
            return Ok(None);
        }
        let response = Mat::from_fn(size + outer.len(), size, |row, column| {
            if row < size {
                found[(row, column)]
            } else {
                beyond[(row - size, column)]
            }
        });
        Ok(Some(Self {
            base,
            outside,
            motions: contact.motions.clone(),
            response,
        }))
    }

    /// What it says under an offset (3n) [m].
    pub(super) fn about<'a>(&'a self, contact: &CoupledContact, offset: &'a [f64]) -> About<'a> {
        let n = contact.points();
        let held = (0..3).flat_map(|c| self.base.iter().map(move |i| -offset[c * n + i]));
        let given: Vec<f64> = held.chain(contact.work.iter().map(|work| -work)).collect();
        About {
            inverse: self,
            offset,
            stuck: product(self.response.as_ref(), &given),
        }
    }
}

impl About<'_> {
    /// Takes the rounding of the inverse off, as iterative refinement does: displacements (3n) [m] that it promised,
    /// and what the compliance says.
    pub(super) fn correct(&mut self, contact: &CoupledContact, promised: &[f64], exact: &Unknowns) {
        let n = contact.points();
        let base = &self.inverse.base;
        let places = (0..3).flat_map(|c| base.iter().map(move |i| c * n + i));
        let missed = places.map(|place| promised[place] - exact.displacement[place]);
        let unbalanced = contact.work.iter().enumerate().map(|(k, work)| {
            let shape = contact.motions.col_as_slice(k).iter().zip(&exact.traction);
            let by_contact = shape.enumerate();
            -by_contact
                .map(|(i, (m, t))| m * contact.area[i % n] * t)
                .sum::<f64>()
                - work
        });
        let given: Vec<f64> = missed.chain(unbalanced).collect();
        let more = product(self.inverse.response.as_ref(), &given);
        for (stuck, more) in self.stuck.iter_mut().zip(more) {
            *stuck += more;
        }
    }

    /// As [`Iterate::linear_step`]; `None` if a point outside the base is in contact, too few points stick, or the
    /// matrix is singular.
    pub(super) fn linear_step(
        &self,
        contact: &CoupledContact,
        iterate: &Iterate,
        monitor: Monitor<'_>,
    ) -> Result<Option<Unknowns>, Error> {
        let (n, m) = (contact.points(), contact.work.len());
        let Inverse {
            base,
            outside,
            response,
            ..
        } = self.inverse;
        let (k, size) = (base.len(), 3 * base.len() + m);
        let state = |i: usize| iterate.points[i];
        if outside.iter().any(|&i| state(i) != PointState::Open) {
            return Ok(None);
        }
        // displacements that are not zero: two of a point that slips, three of an open one
        let mut moved: Vec<usize> = Vec::new();
        for (b, &point) in base.iter().enumerate() {
            match state(point) {
                PointState::Stick => {}
                PointState::Slip => moved.extend([b, k + b]),
                PointState::Open => moved.extend([b, k + b, 2 * k + b]),
            }
        }
        let r = moved.len();
        if r as f64 > WORTH * (3 * k) as f64 {
            return Ok(None);
        }
        // each row: a point, and the coefficients of its tractions
        let mut rows: Vec<(usize, [f64; 3])> = Vec::with_capacity(r);
        for (b, &point) in base.iter().enumerate() {
            match state(point) {
                PointState::Stick => {}
                PointState::Slip => {
                    // the traction follows the pressure along the slip, and turns with it
                    let ([c, s], turn) = (iterate.slip[point], iterate.curvature[point]);
                    rows.push((b, [c, s, -contact.friction[point]]));
                    rows.push((b, [-turn * s, turn * c, 0.0]));
                }
                PointState::Open => {
                    rows.extend(
                        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|f| (b, f)),
                    );
                }
            }
        }
        let coefficient = |(b, [x, y, p]): &(usize, [f64; 3]), values: &[f64]| {
            x * values[*b] + y * values[k + b] + p * values[2 * k + b]
        };
        let mut matrix = Mat::zeros(r, r);
        for (column, &place) in moved.iter().enumerate() {
            let values = response.col_as_slice(place);
            for (a, row) in matrix.col_as_slice_mut(column).iter_mut().zip(&rows) {
                *a = coefficient(row, values);
            }
        }
        let mut right = Mat::from_fn(r, 1, |row, _| -coefficient(&rows[row], &self.stuck));
        let mut row = 0;
        for &point in base {
            match state(point) {
                PointState::Stick => {}
                PointState::Slip => {
                    // the slip keeps its direction
                    let [c, s] = iterate.slip[point];
                    matrix[(row + 1, row)] -= s;
                    matrix[(row + 1, row + 1)] += c;
                    row += 2;
                }
                PointState::Open => row += 3,
            }
        }
        let mut all = self.stuck.clone();
        let mut displacement = vec![0.0; 3 * n];
        if r > 0 {
            let Some(scales) = even_rows(&mut matrix) else {
                return Ok(None);
            };
            for (row, scale) in scales.iter().enumerate() {
                right[(row, 0)] /= scale;
            }
            let par = threads(4 * r * r);
            let found = Lu::new(matrix, par, monitor)?.solve(right.as_ref(), par, monitor)?;
            reset_workers();
            if !found.is_all_finite() {
                return Ok(None);
            }
            for (row, &place) in moved.iter().enumerate() {
                let amount = found[(row, 0)];
                displacement[place / k * n + base[place % k]] = amount;
                for (sum, a) in all.iter_mut().zip(response.col(place).iter()) {
                    *sum += amount * a;
                }
            }
        }
        let mut traction = vec![0.0; 3 * n];
        for c in 0..3 {
            for (b, &point) in base.iter().enumerate() {
                if state(point) != PointState::Open {
                    traction[c * n + point] = all[c * k + b];
                }
            }
            for (row, &point) in outside.iter().enumerate() {
                let place = c * n + point;
                displacement[place] = all[size + c * outside.len() + row] + self.offset[place];
            }
        }
        Ok(Some(Unknowns {
            traction,
            motion: all[3 * k..size].to_vec(),
            displacement,
        }))
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Factors by which Krylov steps solve the linear system of points that slip or are open.
//!
//! Along and across the slip the system falls into two parts that hardly know of each other. Without the friction that
//! follows the pressure, and with rows times the areas of the points, each of them is symmetric and positive definite by
//! the energy of the bodies. Cholesky's factors of them cost a third of Gauss' factors.

use faer::Mat;
use mtb_operator::dense::Cholesky;
use mtb_operator::{Monitor, wide};

use super::PointState;
use super::inverse::System;
use super::matrix::{reset_after, threads};
use crate::columns::Bands;
use crate::error::Error;

/// Least slip over the friction that it turns, as a share of the compliance: with less, a point keeps the direction of its
/// slip as far as the factors tell.
const LEAST_TURN: f64 = 1e-6;

/// Cholesky's factors of the two parts of a system.
#[derive(Debug)]
pub(super) struct Factor {
    parts: [Bands<f32>; 2],
    /// For each base point, what it did, and where its unknowns begin.
    places: Vec<(PointState, usize)>,
    /// For each unknown, its part and its place there, and the factors of its row and of its column.
    within: Vec<Within>,
    /// Krylov steps for each decade of the residual when they were new; infinite before.
    pub(super) steps: f64,
    /// Krylov steps that new factors would have saved since then.
    pub(super) lost: f64,
    /// Krylov steps for each decade of the residual in the last solve.
    pub(super) pace: f64,
}

#[derive(Clone, Copy, Debug)]
struct Within {
    part: usize,
    row: usize,
    given: f64,
    found: f64,
}

impl System<'_> {
    /// The factors of its parts; `None` where rounding has taken their definiteness.
    pub(super) fn factor(&self, monitor: Monitor<'_>) -> Result<Option<Factor>, Error> {
        let k = self.inverse.base.len();
        let mut sizes = [0, 0];
        let mut within = Vec::with_capacity(self.size);
        let mut places = vec![(PointState::Stick, 0); k];
        for (at, point) in self.numbered() {
            places[point.base] = (point.state, at);
            for axis in 0..point.count() {
                let part = axis % 2;
                let area = point.area;
                let (given, found) = if point.state == PointState::Slip && part == 1 {
                    // its row, turn K x + soft x over their sum, made symmetric
                    let turn = point.turn.max(LEAST_TURN);
                    let root = turn.sqrt();
                    (area * (1.0 + turn) / root, root)
                } else {
                    (area, 1.0)
                };
                within.push(Within {
                    part,
                    row: sizes[part],
                    given,
                    found,
                });
                sizes[part] += 1;
            }
        }
        let [left, right] = self.parts(&within, sizes);
        let factor = |part: Mat<f32>| {
            let par = threads(part.nrows() * part.nrows());
            let factor = Cholesky::new(part, par, monitor);
            reset_after(par);
            factor
        };
        let (left, right) = (factor(left)?, factor(right)?);
        let (Some(left), Some(right)) = (left, right) else {
            return Ok(None);
        };
        Ok(Some(Factor {
            parts: [left, right].map(Bands::new),
            places,
            within,
            steps: f64::INFINITY,
            lost: 0.0,
            pace: 0.0,
        }))
    }

    /// The lower triangles of its parts, scaled as `within` says.
    fn parts(&self, within: &[Within], sizes: [usize; 2]) -> [Mat<f32>; 2] {
        let k = self.inverse.base.len();
        let mut parts = sizes.map(|size| Mat::zeros(size, size));
        // for each base point the direction of its slip, along and across the shares of x and y in its rows
        let mut along = [vec![0.0; k], vec![0.0; k]];
        let mut across = [vec![0.0; k], vec![0.0; k]];
        let mut area = vec![0.0; k];
        // the rows of each part, by the entries of one field along all of their points
        let mut rows = [Vec::new(), Vec::new()];
        // of these, along the normal of open points
        let mut normals = Vec::new();
        for (at, point) in self.numbered() {
            let b = point.base;
            area[b] = point.area;
            if point.state == PointState::Slip {
                let [c, s] = point.slip;
                let root = within[at + 1].found;
                (along[0][b], along[1][b]) = (point.area * c, point.area * s);
                (across[0][b], across[1][b]) = (-point.area * root * s, point.area * root * c);
                rows[0].push(b);
                rows[1].push(b);
            } else {
                (along[0][b], across[1][b]) = (point.area, point.area);
                normals.push((rows[0].len() + 1, b));
                rows[0].extend([b, b]);
                rows[1].push(b);
            }
        }
        let response = |place: usize| -> [&[f64]; 3] {
            let column = self.inverse.response.col_as_slice(place);
            [0, 1, 2].map(|axis| &column[axis * k..(axis + 1) * k])
        };
        let mut field = vec![0.0_f32; k];
        for (at, point) in self.numbered() {
            let b = point.base;
            let columns = [b, k + b].map(response);
            let directions = if point.state == PointState::Slip {
                let [c, s] = point.slip;
                let root = within[at + 1].found;
                [[c, s], [-root * s, root * c]]
            } else {
                [[1.0, 0.0], [0.0, 1.0]]
            };
            for (own, x) in within[at..].iter().zip(directions) {
                let shares = [&along, &across][own.part];
                combine(
                    x,
                    columns,
                    shares.each_ref().map(|share| &share[b..]),
                    &mut field[b..],
                );
                let out = &mut parts[own.part].col_as_slice_mut(own.row)[own.row..];
                for (out, &from) in out.iter_mut().zip(&rows[own.part][own.row..]) {
                    *out = field[from];
                }
            }
        }
        // by columns, whose entries lie side by side, also where they stand in rows
        for &(row, b) in &normals {
            let column = response(2 * k + b);
            combine(
                [1.0, 0.0],
                [column, column],
                along.each_ref().map(|share| &share[..]),
                &mut field,
            );
            for (other, &from) in rows[0].iter().enumerate() {
                parts[0][(row.max(other), row.min(other))] = field[from];
            }
            for &(other, from) in &normals {
                parts[0][(row.max(other), row.min(other))] = (area[from] * column[2][from]) as f32;
            }
        }
        for (at, point) in self.numbered() {
            if point.state == PointState::Slip {
                let row = within[at + 1].row;
                parts[1][(row, row)] += (point.area * self.stiff) as f32;
            }
        }
        parts
    }

    /// Unknowns for rows, by the factors of a system that is near this one, and point by point where it had others.
    pub(super) fn near(&self, factor: &Factor, rows: &[f64], x: &mut [f64]) {
        let k = self.inverse.base.len();
        let mut known = (factor.parts.each_ref()).map(|part| vec![0.0; part.size()]);
        for (at, point) in self.numbered() {
            let (was, first) = factor.places[point.base];
            if was == point.state {
                for axis in 0..point.count() {
                    let own = factor.within[first + axis];
                    known[own.part][own.row] = (own.given * rows[at + axis]) as f32;
                }
            }
        }
        for (part, known) in factor.parts.iter().zip(&mut known) {
            part.solve(known);
        }
        for (at, point) in self.numbered() {
            let (was, first) = factor.places[point.base];
            let own = |axis: usize| {
                let place = axis * k + point.base;
                self.inverse.response[(place, place)]
            };
            if was == point.state {
                for axis in 0..point.count() {
                    let own = factor.within[first + axis];
                    x[at + axis] = own.found * f64::from(known[own.part][own.row]);
                }
            } else if point.state == PointState::Slip {
                let [c, s] = point.slip;
                let along = c * c * own(0) + s * s * own(1);
                let across = s * s * own(0) + c * c * own(1);
                x[at] = rows[at] / along;
                x[at + 1] = rows[at + 1] / (point.across[0] * across + point.across[1]);
            } else {
                for axis in 0..3 {
                    x[at + axis] = rows[at + axis] / own(axis);
                }
            }
        }
    }
}

/// Of the sum of two columns, each times its entry of `x`, the `shares` of both components along the tangents, for the last
/// of the base points.
fn combine(x: [f64; 2], columns: [[&[f64]; 3]; 2], shares: [&[f64]; 2], out: &mut [f32]) {
    wide(
        #[inline(always)]
        || {
            let count = out.len();
            let [left, right] = shares.map(|share| &share[..count]);
            let [[ax, ay, _], [bx, by, _]] =
                columns.map(|column| column.map(|part| &part[part.len() - count..][..count]));
            for i in 0..count {
                let along = left[i] * (x[0] * ax[i] + x[1] * bx[i]);
                let across = right[i] * (x[0] * ay[i] + x[1] * by[i]);
                out[i] = (along + across) as f32;
            }
        },
    );
}

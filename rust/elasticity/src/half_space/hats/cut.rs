// SPDX-License-Identifier: MIT OR Apache-2.0
//! Hats of which only a part lies on the contact face.

use std::sync::OnceLock;

use mtb_operator::{Compliance, Component, Grid};
use rayon::prelude::*;

use super::super::body::{index, is_coupled};
use super::super::influence::{influence, point_load};
use super::{HatHalfSpace, add_product, add_scaled, dot};
use crate::Error;
use crate::tetra::Sampling;

/// Rectangles of a cell along each side: as many as a sampling has quadrature points there.
const FINE: i64 = 6;

/// Nodes from a cut hat up to which others are taken rectangle by rectangle. Beyond, both are points
/// with the same centre and spread: the error falls with the fourth power of the distance, 1e-4 here.
const NEAR: i64 = 5;

/// An elastic half-space under a face that covers some cells of a grid of nodes in part: round, with holes,
/// or at an angle to the grid.
///
/// As [`HatHalfSpace`], but each hat ends where the face does, and at kinks of the face: one side of a kink is
/// a face of its own. A contact point has the hat of its node, or several: those of nodes beside the face are
/// given to points on it. Between whole hats the coefficients are its own. Where a cut hat takes part, it is summed over rectangles, `1 / FINE` of a cell wide, those of a
/// sampling on the face: to some 5e-3 of the largest coefficient, 2e-3 of what a uniform traction moves. The
/// compliance is symmetric in the product weighted with the areas of the cut hats.
pub struct CutHats {
    whole: HatHalfSpace,
    hats: Vec<Hat>,
    shares: Vec<Owned>,
    weights: Vec<f64>,
    cell: [f64; 2],
    blocks: [[OnceLock<Vec<f64>>; 3]; 3],
}

/// A part of a hat in the basis of a contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HatShare {
    /// Which face.
    pub face: usize,
    /// Which node of the grid.
    pub node: usize,
    /// Which contact point.
    pub point: usize,
    /// How much of the hat.
    pub factor: f64,
}

/// The same with the number of the hat.
struct Owned {
    hat: usize,
    point: usize,
    factor: f64,
}

/// A hat as area-weighted values on the rectangles of the four cells about its node [m2].
struct Hat {
    /// Its number among all nodes of the grid.
    number: usize,
    node: [i64; 2],
    is_cut: bool,
    parts: Vec<f64>,
    weight: f64,
    /// Centre [m], and variance about it along x and y [m2].
    centre: [f64; 2],
    variance: [f64; 2],
}

/// Rectangles along a hat.
const SPAN: i64 = 2 * FINE;

impl CutHats {
    /// The hats of a half-space with one patch, on the parts of a face that `faces` cover: each is the basis
    /// of all nodes. `shares` make the bases of the `points` contact points of them.
    ///
    /// # Errors
    /// [`Error::Shape`] if a sampling has another number of nodes, [`Error::Index`] on a hat or point that is
    /// none.
    pub fn new(
        whole: HatHalfSpace,
        faces: &[&Sampling],
        shares: &[HatShare],
        points: usize,
    ) -> Result<Self, Error> {
        let n = whole.points();
        for sampling in faces {
            if sampling.n_points() != n || whole.patches.len() != 1 {
                return Err(Error::Shape {
                    name: "sampling",
                    found: sampling.n_points(),
                    expected: n,
                });
            }
        }
        let Grid { nx, dx, dy, .. } = whole.patches[0].grid;
        let mut parts: Vec<Vec<Vec<f64>>> = faces.iter().map(|face| hat_parts(face, nx)).collect();
        let full = whole.weights();
        let mut number = vec![vec![None; n]; faces.len()];
        let mut hats: Vec<Hat> = Vec::new();
        let mut owned = Vec::with_capacity(shares.len());
        let mut weights = vec![0.0; points];
        for (index, share) in shares.iter().enumerate() {
            for (what, value, count) in [
                ("face", share.face, faces.len()),
                ("node", share.node, n),
                ("contact point", share.point, points),
            ] {
                if value >= count {
                    return Err(Error::Index {
                        name: "shares",
                        index,
                        what,
                        value,
                        count,
                    });
                }
            }
            let hat = *number[share.face][share.node].get_or_insert_with(|| {
                let node = [(share.node % nx) as i64, (share.node / nx) as i64];
                let own = std::mem::take(&mut parts[share.face][share.node]);
                let is_cut = (own.iter().sum::<f64>() - full[share.node]).abs() > 1e-6 * dx * dy;
                hats.push(Hat::new(share.node, node, is_cut, own, [dx, dy]));
                hats.len() - 1
            });
            // a hat without any area does nothing
            if hats[hat].weight > 0.0 {
                weights[share.point] += share.factor * hats[hat].weight;
                owned.push(Owned {
                    hat,
                    point: share.point,
                    factor: share.factor,
                });
            }
        }
        Ok(Self {
            whole,
            hats,
            shares: owned,
            weights,
            cell: [dx, dy],
            blocks: Default::default(),
        })
    }

    pub(super) fn block(&self, observed: Component, loaded: Component) -> &[f64] {
        self.blocks[index(observed)][index(loaded)].get_or_init(|| {
            let points = self.weights.len();
            let mut compliance = vec![0.0; points * points];
            if !is_coupled(&self.whole.material, observed, loaded) {
                return compliance;
            }
            let n = self.hats.len();
            let mut matrix = vec![0.0; n * n];
            let all = self.whole.points();
            let whole = self.whole.block(observed, loaded);
            for (row, hat) in matrix.chunks_exact_mut(n).zip(&self.hats) {
                for (a, other) in row.iter_mut().zip(&self.hats) {
                    *a = hat.weight * whole[hat.number * all + other.number];
                }
            }
            let cut: Vec<usize> = (0..n).filter(|&i| self.hats[i].is_cut).collect();
            let rows = self.rows(&cut, observed, loaded);
            for (&i, row) in cut.iter().zip(&rows) {
                matrix[i * n..(i + 1) * n].copy_from_slice(row);
            }
            // reciprocity: a column is a row with both directions exchanged
            let columns = if observed == loaded {
                rows
            } else {
                self.rows(&cut, loaded, observed)
            };
            for (&j, column) in cut.iter().zip(&columns) {
                for i in 0..n {
                    matrix[i * n + j] = column[i];
                }
            }
            let mut rows = vec![0.0; points * n];
            for share in &self.shares {
                let from = &matrix[share.hat * n..(share.hat + 1) * n];
                let row = &mut rows[share.point * n..(share.point + 1) * n];
                for (sum, a) in row.iter_mut().zip(from) {
                    *sum += share.factor / self.weights[share.point] * a;
                }
            }
            for (row, out) in rows
                .chunks_exact(n)
                .zip(compliance.chunks_exact_mut(points))
            {
                for share in &self.shares {
                    out[share.point] += share.factor * row[share.hat];
                }
            }
            compliance
        })
    }

    /// `int phi_i u[phi_j] dA` for the hats `cut` and all others.
    fn rows(&self, cut: &[usize], observed: Component, loaded: Component) -> Vec<Vec<f64>> {
        const REACH: i64 = (NEAR + 1) * FINE;
        const WIDTH: usize = (2 * REACH) as usize;
        let table = Table::new(&self.whole.material, observed, loaded, self.cell);
        cut.par_iter()
            .map(|&i| {
                let hat = &self.hats[i];
                // the field of this hat on the rectangles about it
                let mut field = vec![0.0; WIDTH * WIDTH];
                for (part, &load) in hat.parts.iter().enumerate() {
                    if load == 0.0 {
                        continue;
                    }
                    let (part, span) = (part as i64, SPAN);
                    let at = [part % span - FINE, part / span - FINE];
                    for y in 0..2 * REACH {
                        let from = y as usize * WIDTH;
                        let values = table.line(at[0] + REACH, at[1] - (y - REACH), WIDTH);
                        for (u, k) in field[from..from + WIDTH].iter_mut().zip(values.rev()) {
                            *u += load * k;
                        }
                    }
                }
                let near = |node: [i64; 2]| (0..2).all(|c| (node[c] - hat.node[c]).abs() <= NEAR);
                self.hats
                    .iter()
                    .map(|other| {
                        if !near(other.node) {
                            return self.apart(hat, other, observed, loaded);
                        }
                        let start = [0, 1].map(|c| {
                            ((other.node[c] - hat.node[c]) * FINE - FINE + REACH) as usize
                        });
                        let span = SPAN as usize;
                        (0..span)
                            .map(|y| {
                                let from = (start[1] + y) * WIDTH + start[0];
                                let own = &other.parts[y * span..(y + 1) * span];
                                dot(&field[from..from + span], own)
                            })
                            .sum()
                    })
                    .collect()
            })
            .collect()
    }

    /// The same of two hats far apart: four point loads with the spread of both.
    fn apart(&self, hat: &Hat, other: &Hat, observed: Component, loaded: Component) -> f64 {
        let offset = [0, 1].map(|c| hat.centre[c] - other.centre[c]);
        let aside = [0, 1].map(|c| (2.0 * (hat.variance[c] + other.variance[c])).sqrt());
        let at = |x: f64, y: f64| {
            let place = [offset[0] + x, offset[1] + y];
            point_load(&self.whole.material, observed, loaded, place)
        };
        let sum = at(aside[0], 0.0) + at(-aside[0], 0.0) + at(0.0, aside[1]) + at(0.0, -aside[1]);
        0.25 * sum * hat.weight * other.weight
    }
}

/// The hats of a sampling of all nodes on the rectangles about each of them.
fn hat_parts(sampling: &Sampling, nx: usize) -> Vec<Vec<f64>> {
    let mut parts = vec![vec![0.0; (SPAN * SPAN) as usize]; sampling.n_points()];
    for (q, point) in sampling.quadrature().iter().enumerate() {
        let basis = sampling.basis(q);
        // where in its cell the point lies, by the hats there
        let first = basis.iter().map(|&(i, _)| i).min().unwrap_or(0);
        let share = |high: &dyn Fn(usize) -> bool| -> f64 {
            let there = basis.iter().filter(|&&(i, _)| high(i));
            there.map(|&(_, value)| value).sum()
        };
        let fine = [
            (share(&|i| i % nx != first % nx) * FINE as f64) as i64,
            (share(&|i| i / nx != first / nx) * FINE as f64) as i64,
        ];
        for &(i, value) in basis {
            let side = [
                i64::from(i % nx == first % nx),
                i64::from(i / nx == first / nx),
            ];
            let at = [0, 1].map(|c| (fine[c] + side[c] * FINE) as usize);
            parts[i][at[1] * SPAN as usize + at[0]] += point.weight * value;
        }
    }
    parts
}

impl Hat {
    fn new(number: usize, node: [i64; 2], is_cut: bool, parts: Vec<f64>, cell: [f64; 2]) -> Self {
        let weight: f64 = parts.iter().sum();
        let place = |part: usize| {
            [part as i64 % SPAN, part as i64 / SPAN]
                .map(|k| ((k - FINE) as f64 + 0.5) / FINE as f64)
        };
        let mean = |of: &dyn Fn([f64; 2]) -> f64| {
            let moment: f64 = (0..parts.len()).map(|k| parts[k] * of(place(k))).sum();
            moment / weight
        };
        let middle = [0, 1].map(|c| mean(&|x| x[c]));
        let variance = [0, 1].map(|c| mean(&|x| (x[c] - middle[c]).powi(2)).max(0.0));
        Self {
            number,
            node,
            is_cut,
            weight,
            centre: [0, 1].map(|c| (node[c] as f64 + middle[c]) * cell[c]),
            variance: [0, 1].map(|c| variance[c] * cell[c] * cell[c]),
            parts,
        }
    }
}

/// Mean displacement of a rectangle by a unit force on another, for all offsets of near hats.
struct Table(Vec<f64>);

impl Table {
    const REACH: i64 = (NEAR + 2) * FINE;
    const WIDTH: usize = (2 * Self::REACH + 1) as usize;

    fn new(
        material: &crate::Material,
        observed: Component,
        loaded: Component,
        cell: [f64; 2],
    ) -> Self {
        let part = cell.map(|side| side / FINE as f64);
        let gauss = [(-0.6f64.sqrt(), 5.0), (0.0, 8.0), (0.6f64.sqrt(), 5.0)];
        let table = (0..Self::WIDTH * Self::WIDTH)
            .into_par_iter()
            .map(|k| {
                let at = [k % Self::WIDTH, k / Self::WIDTH].map(|c| c as i64 - Self::REACH);
                let mut mean = 0.0;
                for (a, weight_x) in gauss {
                    for (b, weight_y) in gauss {
                        let offset = [
                            (at[0] as f64 + 0.5 * a) * part[0],
                            (at[1] as f64 + 0.5 * b) * part[1],
                        ];
                        let value = influence(material, observed, loaded, offset, part);
                        mean += weight_x * weight_y / 324.0 * value;
                    }
                }
                mean / (part[0] * part[1])
            })
            .collect();
        Self(table)
    }

    /// Values at the offsets `(x - width + 1 ..= x, y)` along x.
    fn line(&self, x: i64, y: i64, width: usize) -> std::slice::Iter<'_, f64> {
        let end = (y + Self::REACH) as usize * Self::WIDTH + (x + Self::REACH) as usize + 1;
        self.0[end - width..end].iter()
    }
}

impl Compliance for CutHats {
    fn points(&self) -> usize {
        self.weights.len()
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        add_product(self.block(observed, loaded), scale, traction, displacement);
    }

    fn influence_memory(&self) -> f64 {
        let square = |n: usize| 8.0 * (n as f64).powi(2);
        // the block, that of the whole, and meanwhile those of the hats and half of the way to the points
        let meanwhile = 2.0 * square(self.hats.len()) + square(self.weights.len());
        square(self.weights.len()) + self.whole.influence_memory() + meanwhile
    }

    fn add_influence(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        matrix: &mut [f64],
    ) {
        add_scaled(self.block(observed, loaded), scale, matrix);
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! The half-space under hats between some of the lines of its grids.

use mtb_operator::{Compliance, Component};
use rayon::prelude::*;

use super::correlation::{VARIANTS, side, variant};
use super::{HatHalfSpace, Table};
use crate::half_space::body::is_coupled;
use crate::lines::Lines;

impl HatHalfSpace {
    /// `int phi_i u[phi_j] dA` [m3/Pa], row = observed, for the hats between `lines` along x and y of each patch.
    pub(crate) fn on_lines(
        &self,
        observed: Component,
        loaded: Component,
        lines: &[[Lines; 2]],
    ) -> Vec<f64> {
        let starts: Vec<usize> = lines
            .iter()
            .scan(0, |start, [x, y]| {
                let own = *start;
                *start += x.len() * y.len();
                Some(own)
            })
            .collect();
        let n: usize = lines.iter().map(|[x, y]| x.len() * y.len()).sum();
        let mut matrix = vec![0.0; n * n];
        if !is_coupled(&self.material, observed, loaded) {
            return matrix;
        }
        let hats: Vec<_> = lines.iter().map(|[x, y]| [x.hats(), y.hats()]).collect();
        for target in 0..lines.len() {
            for source in (0..lines.len()).filter(|source| self.acts(target, *source)) {
                let table = self.table(observed, loaded, [target, source]);
                let [tx, ty] = &hats[target];
                let [sx, sy] = &hats[source];
                // a row of hats at a time
                matrix[starts[target] * n..(starts[target] + tx.len() * ty.len()) * n]
                    .par_chunks_exact_mut(tx.len() * n)
                    .zip(ty)
                    .for_each(|(rows, to)| {
                        for (row, from) in sy.iter().enumerate() {
                            let along = table.summed(to, from);
                            let first = starts[source] + row * sx.len();
                            for (out, to) in rows.chunks_exact_mut(n).zip(tx) {
                                for (a, from) in out[first..first + sx.len()].iter_mut().zip(sx) {
                                    *a = table.along(&along, to, from);
                                }
                            }
                        }
                    });
            }
        }
        debug_assert_eq!(
            self.points(),
            lines.iter().map(|[x, y]| x.nodes() * y.nodes()).sum()
        );
        matrix
    }
}

impl Table {
    /// `[x variant][x offset]` for sums of rows of hats.
    fn summed(&self, to: &[(usize, f64)], from: &[(usize, f64)]) -> Vec<f64> {
        let width = VARIANTS * self.nodes[0];
        let mut sum = vec![0.0; width];
        for (t, a) in to {
            for (s, b) in from {
                let vy = variant(side(*t, self.target[1]), side(*s, self.source[1]));
                let row = vy * self.nodes[1] + t + self.source[1] - 1 - s;
                let values = &self.values[row * width..(row + 1) * width];
                for (sum, value) in sum.iter_mut().zip(values) {
                    *sum += a * b * value;
                }
            }
        }
        sum
    }

    /// Of [`Table::summed`] for sums of hats in these rows.
    fn along(&self, summed: &[f64], to: &[(usize, f64)], from: &[(usize, f64)]) -> f64 {
        let mut sum = 0.0;
        for (t, a) in to {
            for (s, b) in from {
                let vx = variant(side(*t, self.target[0]), side(*s, self.source[0]));
                sum += a * b * summed[vx * self.nodes[0] + t + self.source[0] - 1 - s];
            }
        }
        sum
    }
}

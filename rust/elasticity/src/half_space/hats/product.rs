// SPDX-License-Identifier: MIT OR Apache-2.0
//! Products with the hats of one patch, without their matrix.

use mtb_operator::RowConvolution;
use mtb_operator::krylov::dot;

use super::Table;
use super::correlation::{side, variant};

/// What one patch does to another: a convolution along x of whole hats, and what the halves of hats in the first
/// and the last column do otherwise. Halves in the first and the last row are part of the convolution.
pub(super) struct Product {
    target: [usize; 2],
    source: [usize; 2],
    whole: RowConvolution,
    /// More than the convolution, by each node in the columns at the edges of the source: a field of the target.
    of_source: Vec<f64>,
    /// The same on each node in the columns at the edges of the target, by all other nodes of the source.
    on_target: Vec<f64>,
}

/// Columns at the edges.
fn edges(nx: usize) -> [usize; 2] {
    [0, nx - 1]
}

impl Product {
    pub(super) fn new(table: &Table) -> Self {
        let (target, source) = (table.target, table.source);
        let inside = variant(side(1, 3), side(1, 3));
        let first = source[0] as isize - 1;
        let whole = RowConvolution::new(source, target, |t, s, offset| {
            table.value(inside, (offset + first) as usize, t, s)
        });
        let more = |to: [usize; 2], from: [usize; 2]| {
            let offset = to[0] + source[0] - 1 - from[0];
            table.at(to, from) - table.value(inside, offset, to[1], from[1])
        };
        let is_edge = |x: usize| edges(source[0]).contains(&x);
        let mut of_source = Vec::with_capacity(2 * source[1] * target[0] * target[1]);
        for x in edges(source[0]) {
            for s in 0..source[1] {
                for t in 0..target[1] {
                    of_source.extend((0..target[0]).map(|column| more([column, t], [x, s])));
                }
            }
        }
        let mut on_target = Vec::with_capacity(2 * target[1] * source[0] * source[1]);
        for x in edges(target[0]) {
            for t in 0..target[1] {
                for s in 0..source[1] {
                    on_target.extend((0..source[0]).map(|column| {
                        // these are in the columns of the source already
                        if is_edge(column) {
                            0.0
                        } else {
                            more([x, t], [column, s])
                        }
                    }));
                }
            }
        }
        Self {
            target,
            source,
            whole,
            of_source,
            on_target,
        }
    }

    /// Adds the integrals over the hats of the target of the displacement by `traction` on the source.
    pub(super) fn add(&self, traction: &[f64], moved: &mut [f64]) {
        self.whole.apply_add(1.0, traction, moved);
        let edge = |nx: usize, ny: usize| {
            edges(nx)
                .into_iter()
                .flat_map(move |x| (0..ny).map(move |row| row * nx + x))
        };
        let (from, to) = (
            self.source[0] * self.source[1],
            self.target[0] * self.target[1],
        );
        for (field, node) in self
            .of_source
            .chunks_exact(to)
            .zip(edge(self.source[0], self.source[1]))
        {
            let load = traction[node];
            if load != 0.0 {
                for (u, a) in moved.iter_mut().zip(field) {
                    *u += load * a;
                }
            }
        }
        for (row, node) in self
            .on_target
            .chunks_exact(from)
            .zip(edge(self.target[0], self.target[1]))
        {
            moved[node] += dot(row, traction);
        }
    }
}

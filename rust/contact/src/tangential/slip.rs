// SPDX-License-Identifier: MIT OR Apache-2.0
//! The slip by a traction.

use mtb_operator::{Buffers, Grid, LinearOperator, Precision, Transform};

use super::kernels::BlockKernels;
use super::operators::Motion;
use super::table::{LayerStencil, Table};
use crate::across::Across;
use crate::inclination::Turn;

/// The slip operator of a grid.
///
/// In steady rolling over a whole number of cells the slip is a convolution of what the traction differs by from
/// the one a step ahead, with the influence itself: even or odd kernels, an eighth of those of the difference of
/// influences.
pub(super) struct SlipOperator {
    shape: [usize; 2],
    transform: Transform,
    single: Transform<f32>,
    kernels: BlockKernels,
    ahead: Option<[isize; 2]>,
    /// How the rows are inclined, if they are.
    turn: Option<Turn>,
    /// What the rows move each other by besides.
    across: Option<Across>,
    buffers: Buffers,
}

impl SlipOperator {
    /// The transform of products on a grid of `shape`; with a step `ahead`, of the cells and of those a step behind
    /// them, wrapped around with room for all offsets between them.
    pub(super) fn transform(
        shape: [usize; 2],
        ahead: Option<[isize; 2]>,
        buffers: &Buffers,
    ) -> Transform {
        let Some(ahead) = ahead else {
            return Transform::new(shape, shape).sharing(buffers);
        };
        let cells = [0, 1].map(|k| shape[k] + ahead[k].unsigned_abs());
        // half a period away only the offsets ahead may be, see `SlipOperator::new`
        let room = [0, 1].map(|k| 2 * (cells[k] - 1) + usize::from(ahead[k] <= 0));
        Transform::wrapped_with_room(cells, room).sharing(buffers)
    }

    pub(super) fn new(
        transform: Transform,
        grid: &Grid,
        table: &Table<'_>,
        layer: f64,
        motion: Motion,
        ahead: Option<[isize; 2]>,
        buffers: &Buffers,
    ) -> Self {
        let shape = [grid.nx, grid.ny];
        let length = motion.step_length();
        let kernels = match (motion, ahead) {
            (Motion::Steady { .. }, None) => {
                let behind = LayerStencil::new(grid, motion.step());
                let kernel = |c: usize| {
                    transform.kernel(|i, j| {
                        let mut value = table.here(i, j)[c] - table.ahead(i, j)[c];
                        if c != 1 {
                            value += layer * behind.difference(i, j);
                        }
                        value / length
                    })
                };
                BlockKernels {
                    xx: kernel(0),
                    xy: kernel(1),
                    yy: kernel(2),
                }
            }
            (Motion::Steady { .. }, Some(ahead)) => {
                let mut kernels = if table.is_mirrored() {
                    BlockKernels::influence(&transform, table, layer, 1.0 / length)
                } else {
                    BlockKernels::whole_influence(&transform, table, layer, 1.0 / length)
                };
                let padded = transform.padded();
                if (0..2).any(|k| padded[k] == 2 * (shape[k] - 1 + ahead[k].unsigned_abs())) {
                    // an odd kernel vanishes half a period away, where the offsets ahead do not
                    kernels.xy = transform.kernel(|i, j| table.here(i, j)[1] / length);
                }
                kernels
            }
            // steady rolling alone is without symmetry
            _ => BlockKernels::influence(&transform, table, layer, 1.0),
        };
        Self {
            shape,
            single: transform.single(),
            transform,
            kernels,
            ahead,
            turn: None,
            across: None,
            buffers: buffers.clone(),
        }
    }

    /// The same on rows that are inclined.
    pub(super) fn with_turn(self, turn: Option<Turn>) -> Self {
        Self { turn, ..self }
    }

    /// The same with what rows move each other by besides.
    pub(super) fn with_across(self, across: Across) -> Self {
        let across = Some(across);
        Self { across, ..self }
    }

    pub(super) fn turn(&self) -> Option<&Turn> {
        self.turn.as_ref()
    }

    /// The same in single precision.
    pub(super) fn single(&self) -> SingleSlip<'_> {
        SingleSlip(self)
    }

    /// The slip by a traction (2n) and, where rows are inclined or move each other in their own way, by a pressure (n),
    /// with the sign of the operator.
    pub(super) fn apply_to(&self, x: &[f64], pressure: Option<&[f64]>, y: &mut [f64]) {
        self.apply_seen(&self.transform, self.turn.as_ref(), x, pressure, y);
        self.add_across(x, pressure, y);
    }

    fn add_across(&self, x: &[f64], pressure: Option<&[f64]>, y: &mut [f64]) {
        if let Some(across) = &self.across {
            let (along, aside) = x.split_at(x.len() / 2);
            across.add(1.0, [Some(along), Some(aside), pressure], y);
        }
    }

    /// [`SlipOperator::apply_to`] on fields with their rows and columns in the other order, as far as rows are alike.
    pub(super) fn apply_reversed(&self, x: &[f64], pressure: Option<&[f64]>, y: &mut [f64]) {
        let turn = self.turn.as_ref().map(Turn::reversed);
        self.apply_seen(&self.transform, turn.as_ref(), x, pressure, y);
    }

    /// The transpose of [`SlipOperator::apply_to`]: what weights (2n) of the slip are of the traction, and of the pressure
    /// (n) where rows are inclined or move each other in their own way.
    pub(super) fn apply_transposed(&self, x: &[f64], y: &mut [f64], pressure: &mut [f64]) {
        let turn = self.turn.as_ref().map(Turn::reversed);
        let mut sums = vec![0.0; 3 * pressure.len()];
        self.weigh_seen(turn.as_ref(), &super::tangent::turned(x), &mut sums);
        let (traction, there) = sums.split_at(x.len());
        y.copy_from_slice(&super::tangent::turned(traction));
        for (p, v) in pressure.iter_mut().zip(there.iter().rev()) {
            *p = *v;
        }
        if let Some(across) = &self.across {
            let (along, aside) = y.split_at_mut(x.len() / 2);
            across.add_transposed(1.0, x, [Some(along), Some(aside), Some(pressure)]);
        }
    }

    /// The transpose of [`SlipOperator::apply_reversed`] between fields in their own order: all three components (3n),
    /// the pressure last.
    pub(super) fn weigh_reversed(&self, x: &[f64], sums: &mut [f64]) {
        self.weigh_seen(self.turn.as_ref(), x, sums);
    }

    fn weigh_seen(&self, turn: Option<&Turn>, x: &[f64], sums: &mut [f64]) {
        self.on_cells(&[x], sums, |parts, sums| {
            let (y, pressure) = sums.split_at_mut(parts[0].len());
            if let Some(turn) = turn {
                let kernels = &self.kernels;
                kernels.apply_turned_transposed(&self.transform, turn, parts[0], y, pressure);
            } else {
                self.kernels.apply(&self.transform, parts[0], y);
                pressure.fill(0.0);
            }
        });
    }

    fn apply_seen<T: Precision>(
        &self,
        transform: &Transform<T>,
        turn: Option<&Turn>,
        x: &[f64],
        pressure: Option<&[f64]>,
        y: &mut [f64],
    ) {
        match (turn, pressure) {
            (Some(turn), Some(pressure)) => self.on_cells(&[x, pressure], y, |parts, y| {
                let (x, pressure) = (parts[0], Some(parts[1]));
                (self.kernels).apply_turned(transform, turn, x, pressure, y);
            }),
            (Some(turn), None) => self.on_cells(&[x], y, |parts, y| {
                (self.kernels).apply_turned(transform, turn, parts[0], None, y);
            }),
            (None, _) => self.on_cells(&[x], y, |parts, y| {
                self.kernels.apply(transform, parts[0], y);
            }),
        }
    }

    /// Takes fields of cells, of one component or two each, to what a `product` makes of them; in steady rolling over
    /// whole cells of what they differ by from those a step ahead.
    fn on_cells(
        &self,
        fields: &[&[f64]],
        y: &mut [f64],
        product: impl FnOnce(&[&[f64]], &mut [f64]),
    ) {
        let Some(ahead) = self.ahead else {
            product(fields, y);
            return;
        };
        let [nx, ny] = self.shape;
        let [mx, my] = self.transform.source();
        // places of the cells and of those a step behind them
        let own = ahead.map(|s| s.max(0) as usize);
        let behind = ahead.map(|s| (-s).max(0) as usize);
        let row = |c: usize, j: usize, from: [usize; 2]| {
            let first = (c * my + j + from[1]) * mx + from[0];
            first..first + nx
        };
        let components: usize = fields.iter().map(|field| field.len() / (nx * ny)).sum();
        let (mut difference, mut slip) = (self.buffers.reals(), self.buffers.reals());
        difference.clear();
        difference.resize(components * mx * my, 0.0);
        slip.resize(y.len() / (nx * ny) * mx * my, 0.0);
        let rows = fields.iter().flat_map(|field| field.chunks_exact(nx));
        for (k, values) in rows.enumerate() {
            let (c, j) = (k / ny, k % ny);
            for (d, v) in difference[row(c, j, own)].iter_mut().zip(values) {
                *d += v;
            }
            for (d, v) in difference[row(c, j, behind)].iter_mut().zip(values) {
                *d -= v;
            }
        }
        let mut parts: Vec<&[f64]> = Vec::new();
        let mut left = difference.as_slice();
        for field in fields {
            let (part, rest) = left.split_at(field.len() / (nx * ny) * mx * my);
            parts.push(part);
            left = rest;
        }
        product(&parts, &mut slip);
        for (k, values) in y.chunks_exact_mut(nx).enumerate() {
            values.copy_from_slice(&slip[row(k / ny, k % ny, own)]);
        }
    }
}

impl LinearOperator for SlipOperator {
    fn dim(&self) -> usize {
        2 * self.shape[0] * self.shape[1]
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.apply_to(x, None, y);
    }
}

/// A slip operator in single precision.
pub(super) struct SingleSlip<'a>(&'a SlipOperator);

impl LinearOperator for SingleSlip<'_> {
    fn dim(&self) -> usize {
        self.0.dim()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let turn = self.0.turn.as_ref();
        self.0.apply_seen(&self.0.single, turn, x, None, y);
        self.0.add_across(x, None, y);
    }
}

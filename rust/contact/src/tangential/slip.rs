// SPDX-License-Identifier: MIT OR Apache-2.0
//! The slip by a traction.

use mtb_operator::{Buffers, Grid, LinearOperator, Transform};

use super::kernels::BlockKernels;
use super::operators::Motion;
use super::table::{LayerStencil, Table};
use crate::inclination::Turn;

/// The slip operator of a grid.
///
/// In steady rolling over a whole number of cells the slip is a convolution of what the traction differs by from
/// the one a step ahead, with the influence itself: even or odd kernels, an eighth of those of the difference of
/// influences.
pub(super) struct SlipOperator {
    shape: [usize; 2],
    transform: Transform,
    kernels: BlockKernels,
    ahead: Option<[isize; 2]>,
    /// How the rows are inclined, if they are.
    turn: Option<Turn>,
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
            transform,
            kernels,
            ahead,
            turn: None,
            buffers: buffers.clone(),
        }
    }

    /// The same on rows that are inclined.
    pub(super) fn with_turn(self, turn: Option<Turn>) -> Self {
        Self { turn, ..self }
    }

    pub(super) fn turn(&self) -> Option<&Turn> {
        self.turn.as_ref()
    }

    /// The slip by a traction (2n) and, where rows are inclined, by a pressure (n), with the sign of the operator.
    pub(super) fn apply_to(&self, x: &[f64], pressure: Option<&[f64]>, y: &mut [f64]) {
        self.apply_seen(self.turn.as_ref(), x, pressure, y);
    }

    /// [`SlipOperator::apply_to`] on fields with their rows and columns in the other order.
    pub(super) fn apply_reversed(&self, x: &[f64], pressure: Option<&[f64]>, y: &mut [f64]) {
        let turn = self.turn.as_ref().map(Turn::reversed);
        self.apply_seen(turn.as_ref(), x, pressure, y);
    }

    fn apply_seen(&self, turn: Option<&Turn>, x: &[f64], pressure: Option<&[f64]>, y: &mut [f64]) {
        let product = |x: &[f64], pressure: Option<&[f64]>, y: &mut [f64]| match turn {
            Some(turn) => (self.kernels).apply_turned(&self.transform, turn, x, pressure, y),
            None => self.kernels.apply(&self.transform, x, y),
        };
        let Some(ahead) = self.ahead else {
            product(x, pressure, y);
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
        let (mut difference, mut slip) = (self.buffers.reals(), self.buffers.reals());
        difference.clear();
        difference.resize(2 * mx * my, 0.0);
        slip.resize(2 * mx * my, 0.0);
        let spread = |x: &[f64], difference: &mut [f64]| {
            for (k, values) in x.chunks_exact(nx).enumerate() {
                let (c, j) = (k / ny, k % ny);
                for (d, v) in difference[row(c, j, own)].iter_mut().zip(values) {
                    *d += v;
                }
                for (d, v) in difference[row(c, j, behind)].iter_mut().zip(values) {
                    *d -= v;
                }
            }
        };
        spread(x, &mut difference);
        let pressures = pressure.map(|pressure| {
            let mut pressures = vec![0.0; mx * my];
            spread(pressure, &mut pressures);
            pressures
        });
        product(&difference, pressures.as_deref(), &mut slip);
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

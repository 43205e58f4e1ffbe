// SPDX-License-Identifier: MIT OR Apache-2.0
//! One grid of a patch.

use mtb_operator::{Buffers, Grid, Transform};

use super::inverse::RoughInverse;
use super::operators::{Bodies, Motion};
use super::slip::SlipOperator;
use super::table::{LayerStencil, Table, whole};
use crate::inclination::Turn;

/// One grid with its slip operator and its preconditioner.
pub(super) struct Level {
    pub(super) grid: Grid,
    pub(super) transform: Transform,
    pub(super) slip: SlipOperator,
    pub(super) inverse: RoughInverse,
    pub(super) diagonal: f64,
    pub(super) step: [f64; 2],
}

impl Level {
    /// `finest`: distance [m] of the rows of the finest grid.
    pub(super) fn new(
        bodies: &Bodies<'_>,
        grid: Grid,
        motion: Motion,
        finest: f64,
        buffers: &Buffers,
    ) -> Self {
        let shape = [grid.nx, grid.ny];
        let (step, length) = (motion.step(), motion.step_length());
        let is_steady = matches!(motion, Motion::Steady { .. });
        let ahead = whole(&grid, step).filter(|_| is_steady);
        let products = SlipOperator::transform(shape, ahead, buffers);
        let cells = products.padded().map(|m| m / 2 + 1);
        let table = Table::new(bodies, &grid, cells, step);
        let own = table.here(0, 0);
        let mean = 0.5 * (own[0] + own[2]);
        let diagonal = if is_steady {
            let ahead = table.ahead(0, 0);
            let behind = LayerStencil::new(&grid, step).difference(0, 0);
            (mean - 0.5 * (ahead[0] + ahead[2]) + bodies.layer * behind) / length
        } else {
            mean + bodies.layer
        };
        let turn = (bodies.inclination)
            .map(|angle| Turn::new(angle, 0.5 * (grid.dy - finest), grid.dy, grid.ny));
        Self {
            grid,
            transform: Transform::new(shape, shape).sharing(buffers),
            inverse: RoughInverse::new(&grid, &table, bodies.layer, motion, buffers),
            slip: SlipOperator::new(
                products,
                &grid,
                &table,
                bodies.layer,
                motion,
                ahead,
                buffers,
            )
            .with_turn(turn),
            diagonal,
            step,
        }
    }
}

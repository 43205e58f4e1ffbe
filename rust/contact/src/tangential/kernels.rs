// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::{Grid, Kernel, Precision, Transform};

use super::table::Table;
use crate::inclination::Turn;

/// A 2 by 2 block of kernels, the mixed ones equal.
pub(super) struct BlockKernels {
    pub(super) xx: Kernel,
    pub(super) xy: Kernel,
    pub(super) yy: Kernel,
}

impl BlockKernels {
    /// `scale` times the influence of cells and of a `layer` between the bodies, as far as it is even or odd.
    pub(super) fn influence(
        transform: &Transform,
        table: &Table<'_>,
        layer: f64,
        scale: f64,
    ) -> Self {
        let at = |i: usize, j: usize| table.mirrored(i, j);
        let own = |i: usize, j: usize| if i == 0 && j == 0 { layer } else { 0.0 };
        Self {
            xx: transform.even_kernel(|i, j| scale * (at(i, j)[0] + own(i, j))),
            xy: transform.odd_kernel(|i, j| scale * at(i, j)[1]),
            yy: transform.even_kernel(|i, j| scale * (at(i, j)[2] + own(i, j))),
        }
    }

    /// The influence of the cells of a grid one step ahead of them.
    pub(super) fn ahead(transform: &Transform, table: &Table<'_>, grid: &Grid) -> Self {
        // each is evaluated once for its three components
        let middle = [grid.nx as isize - 1, grid.ny as isize - 1];
        let width = 2 * grid.nx - 1;
        let values: Vec<[f64; 3]> = (0..width * (2 * grid.ny - 1))
            .map(|k| {
                let (i, j) = ((k % width) as isize, (k / width) as isize);
                table.ahead(i - middle[0], j - middle[1])
            })
            .collect();
        let kernel = |c: usize| {
            transform.kernel(|i, j| {
                let (column, row) = ((i + middle[0]) as usize, (j + middle[1]) as usize);
                values[row * width + column][c]
            })
        };
        Self {
            xx: kernel(0),
            xy: kernel(1),
            yy: kernel(2),
        }
    }

    /// [`BlockKernels::influence`] without symmetry.
    pub(super) fn whole_influence(
        transform: &Transform,
        table: &Table<'_>,
        layer: f64,
        scale: f64,
    ) -> Self {
        let kernel = |c: usize| {
            transform.kernel(|i, j| {
                let own = if c != 1 && i == 0 && j == 0 {
                    layer
                } else {
                    0.0
                };
                scale * (table.here(i, j)[c] + own)
            })
        };
        Self {
            xx: kernel(0),
            xy: kernel(1),
            yy: kernel(2),
        }
    }

    /// Overwrites `y` with the product with the two-component field `x`.
    pub(super) fn apply<T: Precision>(&self, transform: &Transform<T>, x: &[f64], y: &mut [f64]) {
        let (x0, x1) = x.split_at(x.len() / 2);
        let (y0, y1) = y.split_at_mut(y.len() / 2);
        transform.apply_block(
            &[
                &[Some(&self.xx), Some(&self.xy)],
                &[Some(&self.xy), Some(&self.yy)],
            ],
            1.0,
            &[x0, x1],
            &mut [y0, y1],
        );
    }

    /// [`BlockKernels::apply`] on rows that are inclined, with the pressure on them: what acts on a cell is turned
    /// into the frame of the cell that it moves.
    pub(super) fn apply_turned<T: Precision>(
        &self,
        transform: &Transform<T>,
        turn: &Turn,
        x: &[f64],
        pressure: Option<&[f64]>,
        y: &mut [f64],
    ) {
        let n = x.len() / 2;
        let (along, across) = x.split_at(n);
        // components in the common frame of all rows
        let (mut level, mut upright) = (turn.by_cosine(across), turn.by_sine(across));
        if let Some(pressure) = pressure {
            let add = |to: &mut [f64], sign: f64, part: Vec<f64>| {
                to.iter_mut().zip(part).for_each(|(t, p)| *t += sign * p);
            };
            add(&mut level, 1.0, turn.by_sine(pressure));
            add(&mut upright, -1.0, turn.by_cosine(pressure));
        }
        let mut parts = vec![vec![0.0; n]; 6];
        let [a, b, c, d, e, f] = parts.as_mut_slice() else {
            return;
        };
        let (xx, xy, yy) = (Some(&self.xx), Some(&self.xy), Some(&self.yy));
        transform.apply_block(
            &[
                &[xx, None, None],
                &[None, xy, None],
                &[None, None, xy],
                &[xy, None, None],
                &[None, yy, None],
                &[None, None, yy],
            ],
            1.0,
            &[along, &level, &upright],
            &mut [a, b, c, d, e, f],
        );
        for (k, y) in y.chunks_exact_mut(n).enumerate() {
            let (level, upright) = (
                turn.by_cosine(&parts[3 * k + 1]),
                turn.by_sine(&parts[3 * k + 2]),
            );
            for (i, y) in y.iter_mut().enumerate() {
                *y = parts[3 * k][i] + level[i] + upright[i];
            }
        }
    }

    /// The transpose of what [`BlockKernels::apply_turned`] does in each pair of rows, by the kernels as they are: the
    /// product (2n) by the tractions and that (n) by the pressure.
    pub(super) fn apply_turned_transposed(
        &self,
        transform: &Transform,
        turn: &Turn,
        x: &[f64],
        y: &mut [f64],
        pressure: &mut [f64],
    ) {
        let n = x.len() / 2;
        let (along, across) = x.split_at(n);
        let parts = [
            turn.by_cosine(along),
            turn.by_cosine(across),
            turn.by_sine(along),
            turn.by_sine(across),
        ];
        let (mut level, mut upright) = (vec![0.0; n], vec![0.0; n]);
        let (y0, y1) = y.split_at_mut(n);
        let (xx, xy, yy) = (Some(&self.xx), Some(&self.xy), Some(&self.yy));
        transform.apply_block(
            &[
                &[xx, xy, None, None, None, None],
                &[None, None, xy, yy, None, None],
                &[None, None, None, None, xy, yy],
            ],
            1.0,
            &[along, across, &parts[0], &parts[1], &parts[2], &parts[3]],
            &mut [y0, &mut level, &mut upright],
        );
        let sum = |a: Vec<f64>, sign: f64, b: Vec<f64>, to: &mut [f64]| {
            for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
                *to = a + sign * b;
            }
        };
        sum(turn.by_cosine(&level), 1.0, turn.by_sine(&upright), y1);
        sum(
            turn.by_sine(&level),
            -1.0,
            turn.by_cosine(&upright),
            pressure,
        );
    }

    /// Adds `scale` times the product with the two-component field `x` to `y`.
    pub(super) fn apply_add(&self, transform: &Transform, scale: f64, x: &[f64], y: &mut [f64]) {
        let mut product = vec![0.0; y.len()];
        self.apply(transform, x, &mut product);
        y.iter_mut().zip(product).for_each(|(y, p)| *y += scale * p);
    }
}

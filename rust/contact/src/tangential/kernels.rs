// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::{Kernel, Transform};

use super::table::Table;

/// A 2 by 2 block of kernels, the mixed ones equal.
pub(super) struct BlockKernels {
    pub(super) xx: Kernel,
    pub(super) xy: Kernel,
    pub(super) yy: Kernel,
}

impl BlockKernels {
    /// `scale` times the influence of cells and of a `layer` between the bodies.
    pub(super) fn influence(
        transform: &Transform,
        table: &Table<'_>,
        layer: f64,
        scale: f64,
    ) -> Self {
        let at = |i: usize, j: usize| table.here(i as isize, j as isize);
        let own = |i: usize, j: usize| if i == 0 && j == 0 { layer } else { 0.0 };
        Self {
            xx: transform.even_kernel(|i, j| scale * (at(i, j)[0] + own(i, j))),
            xy: transform.odd_kernel(|i, j| scale * at(i, j)[1]),
            yy: transform.even_kernel(|i, j| scale * (at(i, j)[2] + own(i, j))),
        }
    }

    /// Overwrites `y` with the product with the two-component field `x`.
    pub(super) fn apply(&self, transform: &Transform, x: &[f64], y: &mut [f64]) {
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

    /// Adds `scale` times the product with the two-component field `x` to `y`.
    pub(super) fn apply_add(&self, transform: &Transform, scale: f64, x: &[f64], y: &mut [f64]) {
        let mut product = vec![0.0; y.len()];
        self.apply(transform, x, &mut product);
        y.iter_mut().zip(product).for_each(|(y, p)| *y += scale * p);
    }
}

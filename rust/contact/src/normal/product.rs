// SPDX-License-Identifier: MIT OR Apache-2.0
//! The influence matrix of a rectangle of cells, and its rough inverse.

use std::f64::consts::PI;

use mtb_operator::{Grid, Kernel, Transform};

use super::Surface;

/// A convolution on a rectangle of cells.
pub(super) struct Product {
    transform: Transform,
    kernel: Kernel,
}

impl Product {
    /// Pressure [Pa] to closing of the gap [m].
    pub(super) fn influence(surface: Surface<'_>, grid: &Grid, shape: [usize; 2]) -> Self {
        match surface {
            Surface::FreeSpace(influence) => {
                let transform = Transform::new(shape, shape);
                let kernel = transform.even_kernel(|i, j| at_offset(influence, grid, i, j));
                Self { transform, kernel }
            }
            Surface::Periodic(wave) => {
                let transform = Transform::periodic(shape);
                let kernel = transform
                    .even_kernel_from_spectrum(|kx, ky| wave(wave_number(grid, shape, kx, ky)));
                Self { transform, kernel }
            }
        }
    }

    /// Roughly the inverse: that of the same cells wrapped around.
    pub(super) fn inverse(surface: Surface<'_>, grid: &Grid, shape: [usize; 2]) -> Self {
        match surface {
            Surface::FreeSpace(influence) => {
                let transform = Transform::wrapped(shape);
                let wrapped = transform.even_kernel(|i, j| at_offset(influence, grid, i, j));
                let kernel = transform.even_kernel_from_spectrum(|kx, ky| {
                    1.0 / transform
                        .spectrum(&wrapped, kx, ky)
                        .re
                        .abs()
                        .max(f64::MIN_POSITIVE)
                });
                Self { transform, kernel }
            }
            Surface::Periodic(wave) => {
                let transform = Transform::periodic(shape);
                // the mean has no displacement of its own; any positive number of the right size will do
                let longest = f64::min(
                    wave_number(grid, shape, 1, 0),
                    wave_number(grid, shape, 0, 1),
                );
                let kernel = transform.even_kernel_from_spectrum(|kx, ky| {
                    if kx + ky == 0 {
                        0.5 / wave(longest)
                    } else {
                        1.0 / wave(wave_number(grid, shape, kx, ky))
                    }
                });
                Self { transform, kernel }
            }
        }
    }

    /// Overwrites `y` with the image of `x`.
    pub(super) fn apply(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        self.transform.apply_add(&self.kernel, 1.0, x, y);
    }

    /// Points of the transform: what a product costs.
    pub(super) fn size(&self) -> f64 {
        let [mx, my] = self.transform.padded();
        (mx * my) as f64
    }
}

/// Points of the transforms of a product and of a rough inverse, without making them.
pub(super) fn sizes(surface: Surface<'_>, shape: [usize; 2]) -> (f64, f64) {
    let size = |transform: Transform| {
        let [mx, my] = transform.padded();
        (mx * my) as f64
    };
    match surface {
        Surface::FreeSpace(_) => (
            size(Transform::new(shape, shape)),
            size(Transform::wrapped(shape)),
        ),
        Surface::Periodic(_) => {
            let points = (shape[0] * shape[1]) as f64;
            (points, points)
        }
    }
}

fn at_offset(
    influence: &(dyn Fn([f64; 2], [f64; 2]) -> f64 + Sync),
    grid: &Grid,
    i: usize,
    j: usize,
) -> f64 {
    influence([i as f64 * grid.dx, j as f64 * grid.dy], [grid.dx, grid.dy])
}

fn wave_number(grid: &Grid, shape: [usize; 2], kx: usize, ky: usize) -> f64 {
    let [nx, ny] = shape.map(|n| n as f64);
    2.0 * PI * (kx as f64 / (nx * grid.dx)).hypot(ky as f64 / (ny * grid.dy))
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a pressure on a rectangle of cells does, and its rough inverse.

use std::f64::consts::PI;

use mtb_operator::{Buffers, Compliance, Component, Grid, Kernel, Monitor, Transform};

use super::Surface;
use crate::inclination::Turn;

/// Share of the largest response to a wave of pressure below which none is believed.
const LEAST_WAVE: f64 = 1e-6;

/// Closing of the gap [m/Pa] at an offset from a loaded cell with these sides [m].
pub(super) type Influence<'a> = &'a (dyn Fn([f64; 2], [f64; 2]) -> f64 + Sync);

/// A map from pressures to displacements, or back.
///
/// Its work looks at a monitor that, once it has asked to stop, goes on to do so.
pub(super) enum Product<'a> {
    /// A convolution.
    Convolution {
        transform: Box<Transform>,
        kernel: Kernel,
    },
    /// The normal displacement of bodies.
    Body(&'a dyn Compliance),
}

impl<'a> Product<'a> {
    fn of(transform: Transform, kernel: Kernel) -> Self {
        let transform = Box::new(transform);
        Self::Convolution { transform, kernel }
    }

    /// Pressure [Pa] to closing of the gap [m], with memory that products of other shapes use as well.
    pub(super) fn influence(
        surface: Surface<'a>,
        grid: &Grid,
        shape: [usize; 2],
        buffers: &Buffers,
        monitor: Monitor<'_>,
    ) -> Self {
        match surface {
            Surface::FreeSpace(influence) | Surface::Inclined(influence, _) => {
                let transform = Transform::new(shape, shape).sharing(buffers);
                let kernel =
                    transform.even_kernel_watched(|i, j| at_offset(influence, grid, i, j), monitor);
                Self::of(transform, kernel)
            }
            Surface::Rolling(influence) => {
                let transform = Transform::new(shape, shape).sharing(buffers);
                let cell = [grid.dx, grid.dy];
                let kernel = transform
                    .kernel(|i, j| influence([i as f64 * cell[0], j as f64 * cell[1]], cell));
                Self::of(transform, kernel)
            }
            Surface::Periodic(wave) => {
                let transform = Transform::periodic(shape).sharing(buffers);
                let kernel = transform
                    .even_kernel_from_spectrum(|kx, ky| wave(wave_number(grid, shape, kx, ky)));
                Self::of(transform, kernel)
            }
            Surface::Body(body) => Self::Body(body),
        }
    }

    /// Roughly the inverse: that of the same cells wrapped around.
    pub(super) fn inverse(
        surface: Surface<'_>,
        grid: &Grid,
        shape: [usize; 2],
        buffers: &Buffers,
        monitor: Monitor<'_>,
    ) -> Self {
        match surface {
            Surface::FreeSpace(influence) | Surface::Inclined(influence, _) => wrapped(
                shape,
                |i, j| at_offset(influence, grid, i, j),
                f64::MIN_POSITIVE,
                buffers,
                monitor,
            ),
            // what is left of it with all symmetry
            Surface::Rolling(influence) => wrapped(
                shape,
                |i, j| {
                    let [x, y] = [i as f64 * grid.dx, j as f64 * grid.dy];
                    let ends = [[x, y], [-x, y], [x, -y], [-x, -y]];
                    let at = |offset: [f64; 2]| influence(offset, [grid.dx, grid.dy]);
                    0.25 * ends.map(at).iter().sum::<f64>()
                },
                f64::MIN_POSITIVE,
                buffers,
                monitor,
            ),
            Surface::Periodic(wave) => {
                let transform = Transform::periodic(shape).sharing(buffers);
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
                Self::of(transform, kernel)
            }
            Surface::Body(body) => {
                let response = response(body, shape);
                let total: f64 = response.iter().map(|u| u.abs()).sum();
                // the body may be another one elsewhere: it counts as one that is all as in its middle
                wrapped(
                    shape,
                    |i, j| from_middle(&response, shape, i, j),
                    (LEAST_WAVE * total).max(f64::MIN_POSITIVE),
                    buffers,
                    monitor,
                )
            }
        }
    }

    /// Overwrites `y` with the image of `x`; with nothing of use once the monitor has asked to stop.
    pub(super) fn apply(&self, x: &[f64], y: &mut [f64], monitor: Monitor<'_>) {
        match self {
            Self::Convolution { transform, kernel } => {
                transform.apply_watched(kernel, x, y, monitor);
            }
            Self::Body(body) => {
                y.fill(0.0);
                body.add_displacement(Component::Normal, Component::Normal, 1.0, x, y);
            }
        }
    }

    /// [`Product::apply`] on rows that are inclined: pressures act, and displacements are seen, along the normals of
    /// their own rows.
    pub(super) fn apply_turned(
        &self,
        turn: Option<&Turn>,
        x: &[f64],
        y: &mut [f64],
        monitor: Monitor<'_>,
    ) {
        let Some(turn) = turn else {
            return self.apply(x, y, monitor);
        };
        self.apply(&turn.by_cosine(x), y, monitor);
        let along = turn.by_cosine(y);
        self.apply(&turn.by_sine(x), y, monitor);
        let across = turn.by_sine(y);
        for (y, (a, b)) in y.iter_mut().zip(along.iter().zip(across)) {
            *y = a + b;
        }
    }

    /// Points of the transform: what a product costs.
    pub(super) fn size(&self) -> f64 {
        match self {
            Self::Convolution { transform, .. } => padded(transform),
            Self::Body(body) => body.points() as f64,
        }
    }
}

/// The inverse of an even convolution whose grid is wrapped around; no wave responds by less than `least`.
fn wrapped<'a>(
    shape: [usize; 2],
    value: impl Fn(usize, usize) -> f64 + Sync,
    least: f64,
    buffers: &Buffers,
    monitor: Monitor<'_>,
) -> Product<'a> {
    let transform = Transform::wrapped(shape).sharing(buffers);
    let kernel = transform.even_kernel_watched(value, monitor);
    let kernel = transform.even_kernel_from_spectrum(|kx, ky| {
        1.0 / transform.spectrum(&kernel, kx, ky).re.abs().max(least)
    });
    Product::of(transform, kernel)
}

/// The cell in the middle.
fn middle([nx, ny]: [usize; 2]) -> [usize; 2] {
    [nx / 2, ny / 2]
}

/// Displacement of bodies by a pressure of 1 Pa on the cell in the middle.
fn response(body: &dyn Compliance, shape: [usize; 2]) -> Vec<f64> {
    let [i, j] = middle(shape);
    let mut unit = vec![0.0; body.points()];
    unit[j * shape[0] + i] = 1.0;
    let mut response = vec![0.0; body.points()];
    body.add_displacement(
        Component::Normal,
        Component::Normal,
        1.0,
        &unit,
        &mut response,
    );
    response
}

/// Mean response at offsets `i`, `j` to all sides of the middle, at the border where there is no such cell.
fn from_middle(response: &[f64], shape: [usize; 2], i: usize, j: usize) -> f64 {
    let [x, y] = middle(shape);
    let ends =
        |at: usize, offset: usize, n: usize| [at.saturating_sub(offset), (at + offset).min(n - 1)];
    let (columns, rows) = (ends(x, i, shape[0]), ends(y, j, shape[1]));
    let corners = rows
        .iter()
        .flat_map(|row| columns.map(|column| row * shape[0] + column));
    corners.map(|k| 0.25 * response[k]).sum()
}

fn padded(transform: &Transform) -> f64 {
    let [mx, my] = transform.padded();
    (mx * my) as f64
}

/// Points of the transforms of a product and of a rough inverse, without making them.
pub(super) fn sizes(surface: Surface<'_>, shape: [usize; 2]) -> (f64, f64) {
    let points = (shape[0] * shape[1]) as f64;
    let wrapped = || padded(&Transform::wrapped(shape));
    match surface {
        Surface::FreeSpace(_) | Surface::Rolling(_) | Surface::Inclined(..) => {
            (padded(&Transform::new(shape, shape)), wrapped())
        }
        Surface::Periodic(_) => (points, points),
        Surface::Body(_) => (points, wrapped()),
    }
}

fn at_offset(influence: Influence<'_>, grid: &Grid, i: usize, j: usize) -> f64 {
    influence([i as f64 * grid.dx, j as f64 * grid.dy], [grid.dx, grid.dy])
}

fn wave_number(grid: &Grid, shape: [usize; 2], kx: usize, ky: usize) -> f64 {
    let [nx, ny] = shape.map(|n| n as f64);
    2.0 * PI * (kx as f64 / (nx * grid.dx)).hypot(ky as f64 / (ny * grid.dy))
}

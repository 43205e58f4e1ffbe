// SPDX-License-Identifier: MIT OR Apache-2.0
//! A rough inverse of the slip operator.

use mtb_complementarity::discs::Preconditioner;
use mtb_operator::{Buffers, Complex, Grid, Precision, Transform};

use super::kernels::BlockKernels;
use super::operators::Motion;
use super::table::{Places, Table, upstream};

/// Room of the torus over the patch: 1.25 to 2 serve alike, 1 does not.
const ROOM: f64 = 1.25;

/// Curvatures that make particles forget what slipped upstream, in diagonals, as a share: 0.1 to 0.2 serve alike.
const FORGETTING: f64 = 0.15;

/// A rough inverse of the slip operator of a grid.
///
/// In steady rolling the slip is the gradient, along the way of the particles, of the displacement by the tractions:
/// from the slip the displacement is summed up along that way, from the leading edge on, and the tractions
/// are those that cause it on a torus. Under a curvature `k` the slip wanted is `r - k q`, and `q` grows with the
/// displacement, which is therefore forgotten the faster the larger the curvature.
pub(super) struct RoughInverse {
    grid: Grid,
    torus: Transform,
    single: Transform<f32>,
    kernels: BlockKernels,
    /// In steady rolling: places a step ahead in cells with their weights, and the length of the step.
    way: Option<(Places, f64)>,
    buffers: Buffers,
}

impl RoughInverse {
    pub(super) fn new(
        grid: &Grid,
        table: &Table<'_>,
        layer: f64,
        motion: Motion,
        buffers: &Buffers,
    ) -> Self {
        let shape = [grid.nx, grid.ny];
        // no larger than free space, of which the influence is known
        let free = Transform::new(shape, shape).padded();
        let room = [0, 1].map(|k| free[k].min((ROOM * shape[k] as f64).ceil() as usize));
        let torus = Transform::wrapped_with_room(shape, room).sharing(buffers);
        let compliance = BlockKernels::influence(&torus, table, layer, 1.0);
        let at = |kernel, kx, ky| torus.spectrum(kernel, kx, ky).re;
        let largest = at(&compliance.xx, 0, 0).abs() + at(&compliance.yy, 0, 0).abs();
        // the compliance of waves
        let lifted = |kx: usize, ky: usize| -> [f64; 3] {
            let (xx, xy, yy) = (
                at(&compliance.xx, kx, ky),
                at(&compliance.xy, kx, ky),
                at(&compliance.yy, kx, ky),
            );
            // the symbol of a truncated kernel may touch zero: keep it positive definite
            let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
            let lift = (1e-9 * largest - (mean - half.hypot(xy))).max(0.0);
            [xx + lift, xy, yy + lift]
        };
        let symbol = |kx: usize, ky: usize| -> [f64; 3] {
            let [xx, xy, yy] = lifted(kx, ky);
            let determinant = xx * yy - xy * xy;
            [yy / determinant, -xy / determinant, xx / determinant]
        };
        let is_steady = matches!(motion, Motion::Steady { .. });
        let kernels = if is_steady && table.whole.is_none() {
            off_the_cells(&torus, grid, table, layer, motion, lifted)
        } else {
            BlockKernels {
                xx: torus.even_kernel_from_spectrum(|kx, ky| symbol(kx, ky)[0]),
                xy: torus.odd_kernel_from_spectrum(|kx, ky| symbol(kx, ky)[1]),
                yy: torus.even_kernel_from_spectrum(|kx, ky| symbol(kx, ky)[2]),
            }
        };
        Self {
            way: is_steady.then(|| (upstream(grid, motion.step()), motion.step_length())),
            grid: *grid,
            single: torus.single(),
            torus,
            kernels,
            buffers: buffers.clone(),
        }
    }

    /// The same in single precision, which is as good where nothing follows to more digits.
    pub(super) fn single(&self) -> SingleInverse<'_> {
        SingleInverse(self)
    }

    /// [`Preconditioner::invert`] by a transform of any precision.
    fn invert_by<T: Precision>(
        &self,
        torus: &Transform<T>,
        curvature: &[f64],
        y: &[f64],
        x: &mut [f64],
    ) {
        if let Some((way, length)) = &self.way {
            let mut displacement = self.buffers.reals();
            displacement.resize(y.len(), 0.0);
            self.sum_up(way, *length, curvature, y, &mut displacement);
            self.kernels.apply(torus, &displacement, x);
        } else {
            self.kernels.apply(torus, y, x);
        }
    }

    /// Sums slip up to displacements along the way of the particles, those upstream first.
    fn sum_up(&self, way: &Places, length: f64, curvature: &[f64], slip: &[f64], sum: &mut [f64]) {
        let Grid { nx, ny, .. } = self.grid;
        let own: f64 = way.iter().filter(|w| w.0 == [0; 2]).map(|w| w.1).sum();
        let others: Vec<_> = (way.iter().filter(|w| w.0 != [0; 2] && w.1 != 0.0)).collect();
        let is_ahead = |axis: usize| others.iter().any(|w| w.0[axis] > 0);
        let place = |k: usize, n: usize, axis: usize| if is_ahead(axis) { n - 1 - k } else { k };
        let n = nx * ny;
        let (sum_x, sum_y) = sum.split_at_mut(n);
        for j in (0..ny).map(|j| place(j, ny, 1)) {
            for i in (0..nx).map(|i| place(i, nx, 0)) {
                let k = j * nx + i;
                let (mut x, mut y) = (length * slip[k], length * slip[n + k]);
                for ([di, dj], weight) in &others {
                    let (i, j) = (i.wrapping_add_signed(*di), j.wrapping_add_signed(*dj));
                    if i < nx && j < ny {
                        x += weight * sum_x[j * nx + i];
                        y += weight * sum_y[j * nx + i];
                    }
                }
                // none is left where the curvature is infinite
                let share = 1.0 / (1.0 - own + FORGETTING * curvature[k]);
                sum_x[k] = share * x;
                sum_y[k] = share * y;
            }
        }
    }
}

/// Decay of the memory of waves over the patch, where places a step ahead lie between the cells.
const DECAY: f64 = 12.0;

/// The inverse influence on a torus for slip summed up to places that lie between cells.
///
/// Displacements there are those by tractions, with a spectrum of its own, and not what the sum interpolates:
/// `(1 - s) (C - A)^-1`, with the symbols `C` of the compliance, `A` of that a step ahead and `s` of the
/// interpolation. Both differences vanish for waves across the way, unless the memory of them decays.
fn off_the_cells(
    torus: &Transform,
    grid: &Grid,
    table: &Table<'_>,
    layer: f64,
    motion: Motion,
    lifted: impl Fn(usize, usize) -> [f64; 3] + Sync,
) -> BlockKernels {
    let (step, length) = (motion.step(), motion.step_length());
    let places = upstream(grid, step);
    let [mx, my] = torus.padded().map(|m| m as f64);
    let ahead = [0, 1, 2].map(|c| torus.kernel(|i, j| table.ahead(i, j)[c]));
    let extent = (grid.nx as f64 * grid.dx * step[0].abs() / length)
        .hypot(grid.ny as f64 * grid.dy * step[1].abs() / length);
    let decay = (-DECAY * length / extent).exp();
    let symbol = |kx: usize, ky: usize| -> [Complex<f64>; 3] {
        let interpolated: Complex<f64> = (places.iter())
            .map(|([di, dj], weight)| {
                let turns = (kx as f64 * *di as f64) / mx + (ky as f64 * *dj as f64) / my;
                Complex::from_polar(*weight, std::f64::consts::TAU * turns)
            })
            .sum();
        let [xx, xy, yy] = [0, 1, 2].map(|c| {
            let own = if c == 1 {
                Complex::default()
            } else {
                layer * interpolated
            };
            lifted(kx, ky)[c] - decay * (torus.spectrum(&ahead[c], kx, ky) + own)
        });
        let share = (1.0 - decay * interpolated) / (xx * yy - xy * xy);
        [share * yy, -share * xy, share * xx]
    };
    BlockKernels {
        xx: torus.kernel_from_spectrum(|kx, ky| symbol(kx, ky)[0]),
        xy: torus.kernel_from_spectrum(|kx, ky| symbol(kx, ky)[1]),
        yy: torus.kernel_from_spectrum(|kx, ky| symbol(kx, ky)[2]),
    }
}

impl Preconditioner for RoughInverse {
    fn dim(&self) -> usize {
        2 * self.grid.points()
    }

    fn invert(&self, curvature: &[f64], y: &[f64], x: &mut [f64]) {
        self.invert_by(&self.torus, curvature, y, x);
    }
}

/// A rough inverse in single precision.
pub(super) struct SingleInverse<'a>(&'a RoughInverse);

impl Preconditioner for SingleInverse<'_> {
    fn dim(&self) -> usize {
        self.0.dim()
    }

    fn invert(&self, curvature: &[f64], y: &[f64], x: &mut [f64]) {
        self.0.invert_by(&self.0.single, curvature, y, x);
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Products with convolution kernels on regular grids by the real fast Fourier transform.

use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use crate::monitor::{Monitor, unmonitored};
use crate::wide::wide;
use buffers::room;
use passes::Layout;

pub use buffers::Buffers;
pub use kernel::Kernel;
pub use precision::Precision;

mod buffers;
mod chunks;
mod kernel;
mod passes;
mod precision;

/// Padded points from which a second thread pays.
const PARALLEL_FROM: usize = 1 << 16;

/// The Fourier transforms of one pair of grid shapes: plans, padding and buffers.
///
/// A field on the source grid (`ny` rows of `nx`, x fastest) is convolved with kernels given by
/// the integer offset *target index minus source index*, and lands on the target grid. In free space the
/// fields are padded with zeros to sizes that transform fast, so the product equals the dense one to
/// rounding; [`Transform::periodic`] wraps around instead. Rows of zeros at the top and bottom of an
/// input are not transformed, and of the padding no row ever is.
///
/// Memory: a product on `n` by `n` points keeps `16 n^2` bytes per field, an even kernel takes `8 n^2` bytes, any
/// other one `32 n^2`; 4096 by 4096 points need 0.4 GB.
pub struct Transform<T = f64> {
    source: [usize; 2],
    target: [usize; 2],
    padded: [usize; 2],
    periodic: bool,
    rows: Arc<dyn RealToComplex<T>>,
    rows_back: Arc<dyn ComplexToReal<T>>,
    columns: Arc<dyn Fft<T>>,
    columns_back: Arc<dyn Fft<T>>,
    buffers: Buffers,
}

/// Fields on the source grid of one [`Transform`], transformed once for any number of products.
pub struct Spectra {
    inputs: usize,
    /// `[input][wave along x][wave along y]`.
    values: Vec<Complex<f64>>,
}

impl Transform {
    /// Free space: from `source` to `target`, both `[nx, ny]`.
    pub fn new(source: [usize; 2], target: [usize; 2]) -> Self {
        let size = |k: usize| fast_even_size(source[k] + target[k] - 1);
        Self::planned(source, target, [size(0), size(1)], false)
    }

    /// Periodic in both directions with the period of the grid `[nx, ny]`.
    pub fn periodic(shape: [usize; 2]) -> Self {
        Self::planned(shape, shape, shape, true)
    }

    /// Periodic with periods that transform fast, just large enough to hold the grid `[nx, ny]`: the cheap neighbour
    /// of free space, good as a preconditioner.
    pub fn wrapped(shape: [usize; 2]) -> Self {
        Self::planned(shape, shape, shape.map(fast_even_size), true)
    }

    /// [`Transform::wrapped`] with periods of at least `room`, `[x, y]`, points.
    pub fn wrapped_with_room(shape: [usize; 2], room: [usize; 2]) -> Self {
        let periods = [0, 1].map(|k| fast_even_size(shape[k].max(room[k])));
        Self::planned(shape, shape, periods, true)
    }

    /// The same in single precision, which takes half of the time and errs by 10⁻⁷ and more of the largest value. Its
    /// products take the kernels of this transform and round them as they are read.
    pub fn single(&self) -> Transform<f32> {
        let buffers = self.buffers.clone();
        Transform {
            buffers,
            ..Transform::planned(self.source, self.target, self.padded, self.periodic)
        }
    }
}

impl<T: Precision> Transform<T> {
    fn planned(source: [usize; 2], target: [usize; 2], padded: [usize; 2], periodic: bool) -> Self {
        let mut real = RealFftPlanner::new();
        let mut complex = FftPlanner::new();
        Self {
            source,
            target,
            padded,
            periodic,
            rows: real.plan_fft_forward(padded[0]),
            rows_back: real.plan_fft_inverse(padded[0]),
            columns: complex.plan_fft_forward(padded[1]),
            columns_back: complex.plan_fft_inverse(padded[1]),
            buffers: Buffers::default(),
        }
    }

    /// The same with memory that other transforms use as well.
    #[must_use]
    pub fn sharing(self, buffers: &Buffers) -> Self {
        Self {
            buffers: buffers.clone(),
            ..self
        }
    }

    /// Source shape `[nx, ny]`.
    pub fn source(&self) -> [usize; 2] {
        self.source
    }

    /// Target shape `[nx, ny]`.
    pub fn target(&self) -> [usize; 2] {
        self.target
    }

    /// Padded sizes `[mx, my]`: a wave of index `k` along x has `k / mx` periods per cell, and
    /// indices above `m / 2` stand for `k - m`.
    pub fn padded(&self) -> [usize; 2] {
        self.padded
    }

    /// Number of wave indices kept along x, `mx / 2 + 1`; along y all `my` are.
    pub fn waves_x(&self) -> usize {
        self.padded[0] / 2 + 1
    }

    fn is_parallel(&self) -> bool {
        self.padded[0] * self.padded[1] >= PARALLEL_FROM && rayon::current_num_threads() > 1
    }

    fn normalisation(&self) -> f64 {
        1.0 / (self.padded[0] * self.padded[1]) as f64
    }

    /// Adds `scale` times the convolution of `x` with `kernel` to `y`.
    pub fn apply_add(&self, kernel: &Kernel, scale: f64, x: &[f64], y: &mut [f64]) {
        self.apply_add_watched(kernel, scale, x, y, &unmonitored);
    }

    /// [`Transform::apply_add`] with looks at a monitor; `y` is of no use once that has asked to stop.
    pub fn apply_add_watched(
        &self,
        kernel: &Kernel,
        scale: f64,
        x: &[f64],
        y: &mut [f64],
        monitor: Monitor<'_>,
    ) {
        self.block(&[&[Some(kernel)]], scale, true, &[x], &mut [y], monitor);
    }

    /// Overwrites `y` with the convolution of `x` with `kernel`, with looks at a monitor; `y` is of no use once
    /// that has asked to stop.
    pub fn apply_watched(&self, kernel: &Kernel, x: &[f64], y: &mut [f64], monitor: Monitor<'_>) {
        self.block(&[&[Some(kernel)]], 1.0, false, &[x], &mut [y], monitor);
    }

    /// Adds `scale` times a block of convolutions: `outputs[a] += scale * sum_b kernels[a][b] * inputs[b]`.
    ///
    /// One forward transform per input and one inverse per output, whatever the number of kernels;
    /// `None` stands for no coupling.
    pub fn apply_block_add(
        &self,
        kernels: &[&[Option<&Kernel>]],
        scale: f64,
        inputs: &[&[f64]],
        outputs: &mut [&mut [f64]],
    ) {
        self.block(kernels, scale, true, inputs, outputs, &unmonitored);
    }

    /// [`Transform::apply_block_add`] that overwrites the outputs.
    pub fn apply_block(
        &self,
        kernels: &[&[Option<&Kernel>]],
        scale: f64,
        inputs: &[&[f64]],
        outputs: &mut [&mut [f64]],
    ) {
        self.block(kernels, scale, false, inputs, outputs, &unmonitored);
    }

    fn block(
        &self,
        kernels: &[&[Option<&Kernel>]],
        scale: f64,
        adds: bool,
        inputs: &[&[f64]],
        outputs: &mut [&mut [f64]],
        monitor: Monitor<'_>,
    ) {
        let [nx, ny] = self.source;
        debug_assert!(inputs.iter().all(|x| x.len() == nx * ny));
        let points = self.target[0] * self.target[1];
        debug_assert!(outputs.iter().all(|y| y.len() == points));
        debug_assert!(kernels.len() == outputs.len());
        let (first, end) = self.loaded_rows(inputs);
        if first == end {
            for y in outputs.iter_mut().filter(|_| !adds) {
                y.fill(0.0);
            }
            return;
        }
        let layout = Layout {
            columns: self.waves_x(),
            inputs: inputs.len(),
            outputs: outputs.len(),
            rows_in: end - first,
            rows_out: self.target[1],
        };
        let mut buffer = T::pools(&self.buffers).field();
        let spectra = room(&mut buffer, layout.len());
        let factors = (T::factor_of(inputs), kernel_factor::<T>(kernels));
        self.forward_of(inputs, factors.0, first, layout, spectra, monitor);
        self.multiply_columns((kernels, factors.1), layout, spectra, first, monitor);
        let scale = scale / factors.0 / factors.1;
        self.inverse_rows(layout, spectra, (scale, adds), outputs, monitor);
    }

    /// Transforms the rows of `inputs`, times `factor`, from row `first` on.
    fn forward_of(
        &self,
        inputs: &[&[f64]],
        factor: f64,
        first: usize,
        layout: Layout,
        spectra: &mut [Complex<T>],
        monitor: Monitor<'_>,
    ) {
        let nx = self.source[0];
        let fill = |row: &mut [T], field: usize, j: usize| {
            let from = (first + j) * nx;
            let (values, padding) = row.split_at_mut(nx);
            wide(
                #[inline(always)]
                || {
                    for (v, x) in values.iter_mut().zip(&inputs[field][from..from + nx]) {
                        *v = T::of(*x, factor);
                    }
                },
            );
            padding.fill(T::zero());
        };
        self.forward_rows(layout, spectra, fill, |_| {}, 0.0, monitor);
    }

    /// Range of rows outside of which every input is zero.
    fn loaded_rows(&self, inputs: &[&[f64]]) -> (usize, usize) {
        let [nx, ny] = self.source;
        let is_loaded = |j: usize| {
            inputs
                .iter()
                .any(|x| x[j * nx..(j + 1) * nx].iter().any(|v| *v != 0.0))
        };
        let first = (0..ny).find(|j| is_loaded(*j)).unwrap_or(ny);
        let last = (first..ny)
            .rev()
            .find(|j| is_loaded(*j))
            .map_or(first, |j| j + 1);
        (first, last)
    }

    /// Offsets that occur along an axis, first and last.
    fn offsets(&self, axis: usize) -> (isize, isize) {
        if self.periodic {
            let m = self.padded[axis] as isize;
            (-((m - 1) / 2), m / 2)
        } else {
            (
                -(self.source[axis] as isize - 1),
                self.target[axis] as isize - 1,
            )
        }
    }
}

impl Transform {
    /// The spectra of `inputs`, for [`Transform::products`].
    pub fn spectra(&self, inputs: &[&[f64]]) -> Spectra {
        let (first, end) = self.loaded_rows(inputs);
        if first == end {
            let values = vec![Complex::default(); inputs.len() * self.waves_x() * self.padded[1]];
            return Spectra {
                inputs: inputs.len(),
                values,
            };
        }
        let layout = Layout {
            columns: self.waves_x(),
            inputs: inputs.len(),
            outputs: 0,
            rows_in: end - first,
            rows_out: 0,
        };
        let mut buffer = self.buffers.double.field();
        let spectra = room(&mut buffer, layout.len());
        self.forward_of(inputs, 1.0, first, layout, spectra, &unmonitored);
        Spectra {
            inputs: inputs.len(),
            values: self.transformed_columns(layout, spectra, first),
        }
    }

    /// Overwrites each of `outputs` with `sum_b kernels[a][b] * inputs[b]` for inputs that are transformed already:
    /// one inverse transform per output and nothing else.
    pub fn products(
        &self,
        kernels: &[&[Option<&Kernel>]],
        inputs: &Spectra,
        outputs: &mut [&mut [f64]],
    ) {
        debug_assert!(kernels.len() == outputs.len());
        debug_assert!(kernels.iter().all(|row| row.len() == inputs.inputs));
        let layout = Layout {
            columns: self.waves_x(),
            inputs: 0,
            outputs: outputs.len(),
            rows_in: 0,
            rows_out: self.target[1],
        };
        let mut buffer = self.buffers.double.field();
        let spectra = room(&mut buffer, layout.len());
        self.multiply_transformed((kernels, 1.0), layout, &inputs.values, spectra);
        self.inverse_rows(layout, spectra, (1.0, false), outputs, &unmonitored);
    }
}

/// Factor by which the kernels of a block are multiplied, so that numbers of a precision hold them.
fn kernel_factor<T: Precision>(kernels: &[&[Option<&Kernel>]]) -> f64 {
    let all = kernels.iter().flat_map(|row| row.iter().flatten());
    T::factor(all.fold(0.0, |most, kernel| kernel.size.max(most)))
}

/// Smallest even number at least `n` that is a power of two times 1, 3, 5, 7 or 9.
///
/// More factors leave fewer zeros to be transformed but less regular work: 1500 points take twice the time of 1536.
pub fn fast_even_size(n: usize) -> usize {
    let sizes = [1, 3, 5, 7, 9].map(|odd: usize| odd * n.div_ceil(odd).max(2).next_power_of_two());
    sizes.into_iter().fold(usize::MAX, usize::min)
}

#[cfg(test)]
mod tests;

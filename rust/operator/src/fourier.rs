// SPDX-License-Identifier: MIT OR Apache-2.0
//! Products with convolution kernels on regular grids by the real fast Fourier transform.

use std::sync::{Arc, Mutex};

use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner, num_complex::Complex};

use crate::monitor::{Monitor, report, unmonitored};

/// Columns of the spectrum that are gathered, transformed and scattered together.
const BLOCK: usize = 8;

/// Padded points from which a second thread pays.
const PARALLEL_FROM: usize = 1 << 16;

/// Operations between two looks at the monitor: a tenth of a second on a slow core.
const WORK_UNWATCHED: f64 = 2e8;

/// Operations that a value of a kernel counts for: logarithms and roots.
const VALUE: f64 = 200.0;

/// The Fourier transforms of one pair of grid shapes: plans, padding and buffers.
///
/// A field on the source grid (`ny` rows of `nx`, x fastest) is convolved with kernels given by
/// the integer offset *target index minus source index*, and lands on the target grid. In free space the
/// fields are padded with zeros to sizes 2^a 3^b 5^c, so the product equals the dense one to
/// rounding; [`Transform::periodic`] wraps around instead. Rows of zeros at the top and bottom of an
/// input are not transformed, and of the padding no row ever is.
///
/// Memory: a product on `n` by `n` points keeps two buffers of `16 n^2` bytes each per field, an even
/// kernel takes `8 n^2` bytes, any other one `32 n^2`; 4096 by 4096 points need 0.7 GB.
pub struct Transform {
    source: [usize; 2],
    target: [usize; 2],
    padded: [usize; 2],
    periodic: bool,
    rows: Arc<dyn RealToComplex<f64>>,
    rows_back: Arc<dyn ComplexToReal<f64>>,
    columns: Arc<dyn Fft<f64>>,
    columns_back: Arc<dyn Fft<f64>>,
    buffers: Mutex<Vec<Vec<Complex<f64>>>>,
}

/// The spectrum of a convolution kernel, made by and for one [`Transform`].
///
/// Kept transposed (y fastest) and scaled by the reciprocal of the number of padded points.
pub struct Kernel {
    values: Values,
}

enum Values {
    /// Even in both directions: the spectrum is real and even, a quarter is kept.
    Even(Vec<f64>),
    General(Vec<Complex<f64>>),
}

impl Transform {
    /// Free space: from `source` to `target`, both `[nx, ny]`.
    pub fn new(source: [usize; 2], target: [usize; 2]) -> Self {
        let size = |k: usize| smooth_even_size(source[k] + target[k] - 1);
        Self::planned(source, target, [size(0), size(1)], false)
    }

    /// Periodic in both directions with the period of the grid `[nx, ny]`.
    pub fn periodic(shape: [usize; 2]) -> Self {
        Self::planned(shape, shape, shape, true)
    }

    /// Periodic with periods 2^a 3^b 5^c just large enough to hold the grid `[nx, ny]`: the cheap neighbour
    /// of free space, good as a preconditioner.
    pub fn wrapped(shape: [usize; 2]) -> Self {
        Self::planned(shape, shape, shape.map(smooth_even_size), true)
    }

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
            buffers: Mutex::new(Vec::new()),
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

    /// Kernel from its values at the offsets `(i, j)`, target index minus source index.
    ///
    /// Called for `-(nx_source - 1) ..= nx_target - 1` along x and likewise along y (periodic: for the
    /// offsets nearest to zero).
    pub fn kernel(&self, value: impl Fn(isize, isize) -> f64 + Sync) -> Kernel {
        let [mx, my] = self.padded;
        let (nkx, parallel) = (self.waves_x(), self.is_parallel());
        let (left, right) = self.offsets(0);
        let (down, up) = self.offsets(1);
        let filled = (up - down + 1) as usize;
        let mut spectrum = self.take(filled * nkx);
        let scratch = || (vec![0.0; mx], self.rows.make_scratch_vec());
        each_chunk(
            &unmonitored,
            1.0,
            parallel,
            &mut spectrum,
            nkx,
            scratch,
            |(row, work), k, out| {
                row.fill(0.0);
                let j = down + k as isize;
                for i in left..=right {
                    row[i.rem_euclid(mx as isize) as usize] = value(i, j);
                }
                let done = self.rows.process_with_scratch(row, out, work);
                debug_assert!(done.is_ok());
            },
        );
        let normalisation = self.normalisation();
        let mut values = vec![Complex::default(); nkx * my];
        let scratch = || vec![Complex::default(); self.columns.get_inplace_scratch_len()];
        each_chunk(
            &unmonitored,
            1.0,
            parallel,
            &mut values,
            my,
            scratch,
            |work, kx, column| {
                for k in 0..filled {
                    let j = (down + k as isize).rem_euclid(my as isize) as usize;
                    column[j] = spectrum[k * nkx + kx] * normalisation;
                }
                self.columns.process_with_scratch(column, work);
            },
        );
        self.give_back(spectrum);
        Kernel {
            values: Values::General(values),
        }
    }

    /// Kernel that is even along x and along y, from its values at the offsets `i, j >= 0`.
    ///
    /// A quarter of the evaluations and an eighth of the memory of [`Transform::kernel`].
    pub fn even_kernel(&self, value: impl Fn(usize, usize) -> f64 + Sync) -> Kernel {
        self.even_kernel_watched(value, &unmonitored)
    }

    /// [`Transform::even_kernel`] with looks at a monitor; of no use once that has asked to stop.
    pub fn even_kernel_watched(
        &self,
        value: impl Fn(usize, usize) -> f64 + Sync,
        monitor: Monitor<'_>,
    ) -> Kernel {
        let [mx, my] = self.padded;
        let (nkx, parallel) = (self.waves_x(), self.is_parallel());
        let reach = |(first, last): (isize, isize)| last.max(-first) as usize;
        let (reach_x, reach_y) = (reach(self.offsets(0)), reach(self.offsets(1)));
        let mut real = vec![0.0; (reach_y + 1) * nkx];
        let scratch = || {
            let spectrum = self.rows.make_output_vec();
            (vec![0.0; mx], spectrum, self.rows.make_scratch_vec())
        };
        each_chunk(
            monitor,
            VALUE * (reach_x + 1) as f64 + transform_work(mx),
            parallel,
            &mut real,
            nkx,
            scratch,
            |(row, spectrum, work), j, out| {
                row.fill(0.0);
                for i in 0..=reach_x {
                    let v = value(i, j);
                    row[i] = v;
                    row[(mx - i) % mx] = v;
                }
                let done = self.rows.process_with_scratch(row, spectrum, work);
                debug_assert!(done.is_ok());
                for (o, s) in out.iter_mut().zip(spectrum.iter()) {
                    *o = s.re;
                }
            },
        );
        let normalisation = self.normalisation();
        let nky = my / 2 + 1;
        let mut values = vec![0.0; nkx * nky];
        // two real even columns ride in one complex transform
        let scratch = || {
            let work = vec![Complex::default(); self.columns.get_inplace_scratch_len()];
            (vec![Complex::default(); my], work)
        };
        each_chunk(
            monitor,
            transform_work(my),
            parallel,
            &mut values,
            2 * nky,
            scratch,
            |(column, work), pair, out| {
                let kx = 2 * pair;
                let second = kx + 1 < nkx;
                column.fill(Complex::default());
                for j in 0..=reach_y {
                    let re = real[j * nkx + kx];
                    let im = if second { real[j * nkx + kx + 1] } else { 0.0 };
                    let v = Complex::new(re, im) * normalisation;
                    column[j] = v;
                    column[(my - j) % my] = v;
                }
                self.columns.process_with_scratch(column, work);
                for (ky, c) in column[..nky].iter().enumerate() {
                    out[ky] = c.re;
                    if second {
                        out[nky + ky] = c.im;
                    }
                }
            },
        );
        Kernel {
            values: Values::Even(values),
        }
    }

    /// Kernel from its spectrum at the wave indices `(kx, ky)`, `kx < mx / 2 + 1`, `ky < my`.
    pub fn kernel_from_spectrum(
        &self,
        value: impl Fn(usize, usize) -> Complex<f64> + Sync,
    ) -> Kernel {
        let (my, normalisation) = (self.padded[1], self.normalisation());
        let mut values = vec![Complex::default(); self.waves_x() * my];
        each_chunk(
            &unmonitored,
            1.0,
            self.is_parallel(),
            &mut values,
            my,
            || (),
            |(), kx, column| {
                for (ky, v) in column.iter_mut().enumerate() {
                    *v = value(kx, ky) * normalisation;
                }
            },
        );
        Kernel {
            values: Values::General(values),
        }
    }

    /// Even kernel from its real spectrum at the wave indices `kx <= mx / 2`, `ky <= my / 2`.
    pub fn even_kernel_from_spectrum(&self, value: impl Fn(usize, usize) -> f64 + Sync) -> Kernel {
        let (nky, normalisation) = (self.padded[1] / 2 + 1, self.normalisation());
        let mut values = vec![0.0; self.waves_x() * nky];
        each_chunk(
            &unmonitored,
            1.0,
            self.is_parallel(),
            &mut values,
            nky,
            || (),
            |(), kx, column| {
                for (ky, v) in column.iter_mut().enumerate() {
                    *v = value(kx, ky) * normalisation;
                }
            },
        );
        Kernel {
            values: Values::Even(values),
        }
    }

    /// Value of the spectrum of `kernel` at the wave indices `(kx, ky)`.
    pub fn spectrum(&self, kernel: &Kernel, kx: usize, ky: usize) -> Complex<f64> {
        let my = self.padded[1];
        let scale = (self.padded[0] * my) as f64;
        match &kernel.values {
            Values::Even(v) => Complex::new(v[kx * (my / 2 + 1) + ky.min(my - ky)] * scale, 0.0),
            Values::General(v) => v[kx * my + ky] * scale,
        }
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
        self.block(&[&[Some(kernel)]], scale, &[x], &mut [y], monitor);
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
        self.block(kernels, scale, inputs, outputs, &unmonitored);
    }

    fn block(
        &self,
        kernels: &[&[Option<&Kernel>]],
        scale: f64,
        inputs: &[&[f64]],
        outputs: &mut [&mut [f64]],
        monitor: Monitor<'_>,
    ) {
        debug_assert!(
            inputs
                .iter()
                .all(|x| x.len() == self.source[0] * self.source[1])
        );
        debug_assert!(
            outputs
                .iter()
                .all(|y| y.len() == self.target[0] * self.target[1])
        );
        debug_assert!(kernels.len() == outputs.len());
        let loaded = self.loaded_rows(inputs);
        if loaded.0 == loaded.1 {
            return;
        }
        let forward = self.forward_rows(inputs, loaded, monitor);
        let back = self.multiply_columns(kernels, &forward, inputs.len(), loaded, monitor);
        self.give_back(forward);
        self.inverse_rows(scale, &back, outputs, monitor);
        self.give_back(back);
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

    /// Spectra of the loaded rows: `[input][row][kx]`.
    fn forward_rows(
        &self,
        inputs: &[&[f64]],
        loaded: (usize, usize),
        monitor: Monitor<'_>,
    ) -> Vec<Complex<f64>> {
        let nx = self.source[0];
        let (nkx, n_rows) = (self.waves_x(), loaded.1 - loaded.0);
        let mut spectrum = self.take(inputs.len() * n_rows * nkx);
        let scratch = || (vec![0.0; self.padded[0]], self.rows.make_scratch_vec());
        each_chunk(
            monitor,
            transform_work(self.padded[0]),
            self.is_parallel(),
            &mut spectrum,
            nkx,
            scratch,
            |(row, work), k, out| {
                let j = loaded.0 + k % n_rows;
                row[..nx].copy_from_slice(&inputs[k / n_rows][j * nx..(j + 1) * nx]);
                row[nx..].fill(0.0);
                let done = self.rows.process_with_scratch(row, out, work);
                debug_assert!(done.is_ok());
            },
        );
        spectrum
    }

    /// Column transforms, product with the kernels and back: `[block of kx][output][row][kx in block]`.
    fn multiply_columns(
        &self,
        kernels: &[&[Option<&Kernel>]],
        spectrum: &[Complex<f64>],
        n_inputs: usize,
        loaded: (usize, usize),
        monitor: Monitor<'_>,
    ) -> Vec<Complex<f64>> {
        let (my, nkx) = (self.padded[1], self.waves_x());
        let ny = self.target[1];
        let n_rows = loaded.1 - loaded.0;
        let n_outputs = kernels.len();
        let mut result = self.take(nkx.div_ceil(BLOCK) * n_outputs * ny * BLOCK);
        // a stride that is no power of two keeps the columns of a block out of each other's cache lines
        let stride = my + BLOCK;
        let scratch = || {
            let work = self
                .columns
                .get_inplace_scratch_len()
                .max(self.columns_back.get_inplace_scratch_len());
            (
                vec![Complex::default(); n_inputs * BLOCK * stride],
                vec![Complex::default(); BLOCK * stride],
                vec![Complex::default(); work],
            )
        };
        let size = n_outputs * ny * BLOCK;
        each_chunk(
            monitor,
            (BLOCK * (n_inputs + n_outputs)) as f64 * transform_work(my),
            self.is_parallel(),
            &mut result,
            size,
            scratch,
            |(columns, product, work), block, out| {
                let first = block * BLOCK;
                let width = BLOCK.min(nkx - first);
                for input in 0..n_inputs {
                    let columns =
                        &mut columns[input * BLOCK * stride..(input + 1) * BLOCK * stride];
                    for c in 0..width {
                        let column = &mut columns[c * stride..c * stride + my];
                        column[..loaded.0].fill(Complex::default());
                        column[loaded.1..].fill(Complex::default());
                    }
                    for k in 0..n_rows {
                        let from = (input * n_rows + k) * nkx + first;
                        for (c, v) in spectrum[from..from + width].iter().enumerate() {
                            columns[c * stride + loaded.0 + k] = *v;
                        }
                    }
                    for c in 0..width {
                        self.columns
                            .process_with_scratch(&mut columns[c * stride..c * stride + my], work);
                    }
                }
                for (output, row_of_kernels) in kernels.iter().enumerate() {
                    for c in 0..width {
                        let target = &mut product[c * stride..c * stride + my];
                        let mut empty = true;
                        for (input, kernel) in row_of_kernels.iter().enumerate() {
                            if let Some(kernel) = kernel {
                                let from = (input * BLOCK + c) * stride;
                                kernel.multiply(
                                    first + c,
                                    &columns[from..from + my],
                                    target,
                                    empty,
                                );
                                empty = false;
                            }
                        }
                        if empty {
                            target.fill(Complex::default());
                        } else {
                            self.columns_back.process_with_scratch(target, work);
                        }
                    }
                    let out = &mut out[output * ny * BLOCK..(output + 1) * ny * BLOCK];
                    for (j, row) in out.chunks_exact_mut(BLOCK).enumerate() {
                        for (c, v) in row[..width].iter_mut().enumerate() {
                            *v = product[c * stride + j];
                        }
                    }
                }
            },
        );
        result
    }

    fn inverse_rows(
        &self,
        scale: f64,
        blocks: &[Complex<f64>],
        outputs: &mut [&mut [f64]],
        monitor: Monitor<'_>,
    ) {
        let [nx, ny] = self.target;
        let nkx = self.waves_x();
        let n_outputs = outputs.len();
        let even = self.padded[0].is_multiple_of(2);
        let scratch = || {
            let row = vec![Complex::default(); nkx.div_ceil(BLOCK) * BLOCK];
            (
                row,
                vec![0.0; self.padded[0]],
                self.rows_back.make_scratch_vec(),
            )
        };
        for (output, y) in outputs.iter_mut().enumerate() {
            each_chunk(
                monitor,
                transform_work(self.padded[0]),
                self.is_parallel(),
                y,
                nx,
                scratch,
                |(spectrum, row, work), j, y| {
                    for (block, part) in spectrum.chunks_exact_mut(BLOCK).enumerate() {
                        let from = ((block * n_outputs + output) * ny + j) * BLOCK;
                        part.copy_from_slice(&blocks[from..from + BLOCK]);
                    }
                    // rounding leaves an imaginary part where a real field has none
                    spectrum[0].im = 0.0;
                    if even {
                        spectrum[nkx - 1].im = 0.0;
                    }
                    let done = self
                        .rows_back
                        .process_with_scratch(&mut spectrum[..nkx], row, work);
                    debug_assert!(done.is_ok());
                    for (y, v) in y.iter_mut().zip(row.iter()) {
                        *y += scale * v;
                    }
                },
            );
        }
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

    fn take(&self, len: usize) -> Vec<Complex<f64>> {
        let pooled = self.buffers.lock().ok().and_then(|mut pool| pool.pop());
        let mut buffer = pooled.unwrap_or_default();
        buffer.resize(len, Complex::default());
        buffer
    }

    fn give_back(&self, buffer: Vec<Complex<f64>>) {
        if let Ok(mut pool) = self.buffers.lock() {
            pool.push(buffer);
        }
    }
}

impl Kernel {
    /// Writes (`first`) or adds the product with one column of a spectrum.
    fn multiply(&self, kx: usize, x: &[Complex<f64>], y: &mut [Complex<f64>], first: bool) {
        let my = x.len();
        if first {
            y.fill(Complex::default());
        }
        match &self.values {
            Values::Even(values) => {
                let nky = my / 2 + 1;
                let values = &values[kx * nky..(kx + 1) * nky];
                for ((y, x), v) in y.iter_mut().zip(x).zip(values) {
                    *y += x * v;
                }
                // the upper half runs backwards through the same values
                let upper = values[1..=my - nky].iter().rev();
                for ((y, x), v) in y[nky..].iter_mut().zip(&x[nky..]).zip(upper) {
                    *y += x * v;
                }
            }
            Values::General(values) => {
                let values = &values[kx * my..(kx + 1) * my];
                for ((y, x), v) in y.iter_mut().zip(x).zip(values) {
                    *y += x * v;
                }
            }
        }
    }
}

/// Smallest even number 2^a 3^b 5^c that is at least `n`.
fn smooth_even_size(n: usize) -> usize {
    let is_smooth = |mut m: usize| {
        for p in [2, 3, 5] {
            while m.is_multiple_of(p) {
                m /= p;
            }
        }
        m == 1
    };
    let mut size = n.max(2).next_multiple_of(2);
    while !is_smooth(size) {
        size += 2;
    }
    size
}

/// Operations of a transform of this length.
fn transform_work(length: usize) -> f64 {
    5.0 * length as f64 * (length.max(2) as f64).log2()
}

/// Works on the chunks of `data`, on all threads if `parallel`, with scratch space per thread. The monitor is
/// asked about as often as [`WORK_UNWATCHED`] says, for chunks of `cost` operations each; what is left when it
/// asks to stop is not done.
fn each_chunk<T: Send, S>(
    monitor: Monitor<'_>,
    cost: f64,
    parallel: bool,
    data: &mut [T],
    size: usize,
    scratch: impl Fn() -> S + Sync + Send,
    work: impl Fn(&mut S, usize, &mut [T]) + Sync + Send,
) {
    let round = ((WORK_UNWATCHED / cost) as usize).max(1);
    for (number, part) in data.chunks_mut(size.saturating_mul(round)).enumerate() {
        if number > 0 && report(monitor, number, f64::NAN).is_err() {
            return;
        }
        let first = number * round;
        if parallel {
            part.par_chunks_mut(size)
                .enumerate()
                .for_each_init(&scratch, |s, (k, chunk)| work(s, first + k, chunk));
        } else {
            let mut s = scratch();
            for (k, chunk) in part.chunks_mut(size).enumerate() {
                work(&mut s, first + k, chunk);
            }
        }
    }
}

#[cfg(test)]
mod tests;

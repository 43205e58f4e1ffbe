// SPDX-License-Identifier: MIT OR Apache-2.0
//! Convolution kernels and how they are made.

use std::ops::Mul;

use rustfft::num_complex::Complex;

use super::buffers::room;
use super::chunks::each_chunk;
use super::passes::Layout;
use super::{Precision, Transform};
use crate::monitor::{Monitor, unmonitored};
use crate::wide::wide;

/// Operations that a value of a kernel counts for: logarithms and roots.
pub(super) const VALUE: f64 = 200.0;

/// The spectrum of a convolution kernel, made by and for one [`Transform`].
///
/// Kept transposed (y fastest) and scaled by the reciprocal of the number of padded points.
pub struct Kernel {
    values: Values,
    /// The largest of them.
    pub(super) size: f64,
}

enum Values {
    /// Even or odd along x and along y: a quarter of the spectrum is kept, which is real, or `i` times real where the
    /// kernel is odd along one of the two only.
    Mirrored {
        quarter: Vec<f64>,
        odd: [bool; 2],
    },
    General(Vec<Complex<f64>>),
}

impl Kernel {
    fn of(values: Values) -> Self {
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let size = match &values {
            Values::Mirrored { quarter, .. } => largest(quarter),
            Values::General(values) => {
                (values.iter()).fold(0.0_f64, |most, v| most.max(v.re.abs()).max(v.im.abs()))
            }
        };
        Self { values, size }
    }

    /// Writes (`is_first`) or adds the product with one column of a spectrum, times `factor`.
    pub(super) fn multiply<T: Precision>(
        &self,
        kx: usize,
        x: &[Complex<T>],
        y: &mut [Complex<T>],
        (is_first, factor): (bool, f64),
    ) {
        wide(
            #[inline(always)]
            || self.multiply_plainly(kx, x, y, (is_first, factor)),
        );
    }

    #[expect(
        clippy::inline_always,
        reason = "what is not inlined keeps its narrow instructions"
    )]
    #[inline(always)]
    pub(super) fn multiply_plainly<T: Precision>(
        &self,
        kx: usize,
        x: &[Complex<T>],
        y: &mut [Complex<T>],
        (is_first, factor): (bool, f64),
    ) {
        let my = x.len();
        let nky = my / 2 + 1;
        match &self.values {
            Values::Mirrored { quarter, odd } => {
                let values = &quarter[kx * nky..(kx + 1) * nky];
                // the upper half runs backwards through the same values
                let upper = values[1..=my - nky].iter().rev();
                let sign = if odd[1] { -1.0 } else { 1.0 };
                let (x_upper, x) = (&x[nky..], &x[..nky]);
                let (y, y_upper) = y.split_at_mut(nky);
                if odd[0] == odd[1] {
                    let real = |v: f64| T::of(v, factor);
                    multiply(values.iter().map(|v| real(*v)), x, y, is_first);
                    multiply(upper.map(|v| real(sign * v)), x_upper, y_upper, is_first);
                } else {
                    let turned = |v: f64| Complex::new(T::zero(), T::of(v, factor));
                    multiply(values.iter().map(|v| turned(*v)), x, y, is_first);
                    let upper = upper.map(|v| turned(sign * v));
                    multiply(upper, x_upper, y_upper, is_first);
                }
            }
            Values::General(values) => {
                let values = &values[kx * my..(kx + 1) * my];
                let both =
                    |v: &Complex<f64>| Complex::new(T::of(v.re, factor), T::of(v.im, factor));
                multiply(values.iter().map(both), x, y, is_first);
            }
        }
    }
}

/// Writes (`is_first`) or adds the products of numbers.
#[expect(
    clippy::inline_always,
    reason = "what is not inlined keeps its narrow instructions"
)]
#[inline(always)]
fn multiply<T: Precision, V>(
    values: impl Iterator<Item = V>,
    x: &[Complex<T>],
    y: &mut [Complex<T>],
    is_first: bool,
) where
    Complex<T>: Mul<V, Output = Complex<T>>,
{
    let terms = x.iter().zip(values).map(|(x, v)| *x * v);
    if is_first {
        for (y, term) in y.iter_mut().zip(terms) {
            *y = term;
        }
    } else {
        for (y, term) in y.iter_mut().zip(terms) {
            *y = *y + term;
        }
    }
}

impl Transform {
    /// Kernel from its values at the offsets `(i, j)`, target index minus source index.
    ///
    /// Called for `-(nx_source - 1) ..= nx_target - 1` along x and likewise along y (periodic: for the
    /// offsets nearest to zero).
    pub fn kernel(&self, value: impl Fn(isize, isize) -> f64 + Sync) -> Kernel {
        let [mx, my] = self.padded;
        let (left, right) = self.offsets(0);
        let (down, up) = self.offsets(1);
        let layout = Layout {
            columns: self.waves_x(),
            inputs: 1,
            outputs: 0,
            rows_in: (up - down + 1) as usize,
            rows_out: 0,
        };
        let mut buffer = self.buffers.double.field();
        let spectra = room(&mut buffer, layout.len());
        let fill = |row: &mut [f64], _: usize, j: usize| {
            row.fill(0.0);
            for i in left..=right {
                row[i.rem_euclid(mx as isize) as usize] = value(i, down + j as isize);
            }
        };
        self.forward_rows(layout, spectra, fill, |_| {}, 1.0, &unmonitored);
        let normalisation = self.normalisation();
        let mut values = vec![Complex::default(); self.waves_x() * my];
        self.kernel_columns(
            layout,
            spectra,
            |j| (down + j as isize).rem_euclid(my as isize) as usize,
            |_| {},
            &mut values,
            my,
            |column, values| {
                for (value, wave) in values.iter_mut().zip(column) {
                    *value = wave * normalisation;
                }
            },
            &unmonitored,
        );
        Kernel::of(Values::General(values))
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
        self.mirrored(value, [false, false], monitor)
    }

    /// Kernel that is odd along x and along y, from its values at the offsets `i, j >= 0`; as cheap as an even one.
    ///
    /// Half a period away it is both its values and what they are mirrored to: none is taken there.
    pub fn odd_kernel(&self, value: impl Fn(usize, usize) -> f64 + Sync) -> Kernel {
        self.mirrored(value, [true, true], &unmonitored)
    }

    /// Kernel that is even or `odd` along x and along y, from its values at the offsets `i, j >= 0`; as cheap as an
    /// even one. Along an axis in which it is odd no value is taken half a period away.
    pub fn mirrored_kernel(
        &self,
        odd: [bool; 2],
        value: impl Fn(usize, usize) -> f64 + Sync,
    ) -> Kernel {
        self.mirrored(value, odd, &unmonitored)
    }

    /// A kernel from a quarter of its values.
    fn mirrored(
        &self,
        value: impl Fn(usize, usize) -> f64 + Sync,
        odd: [bool; 2],
        monitor: Monitor<'_>,
    ) -> Kernel {
        let [odd_x, odd_y] = odd;
        let [mx, my] = self.padded;
        let (nkx, nky) = (self.waves_x(), my / 2 + 1);
        let reach = |(first, last): (isize, isize)| last.max(-first) as usize;
        let (reach_x, reach_y) = (reach(self.offsets(0)), reach(self.offsets(1)));
        // two real even columns ride in one complex transform
        let layout = Layout {
            columns: nkx.div_ceil(2),
            inputs: 1,
            outputs: 0,
            rows_in: reach_y + 1,
            rows_out: 0,
        };
        let mut buffer = self.buffers.double.field();
        let spectra = room(&mut buffer, layout.len());
        let fill = |row: &mut [f64], _: usize, j: usize| {
            row.fill(0.0);
            for i in 0..=reach_x {
                let v = value(i, j);
                row[i] = v;
                row[(mx - i) % mx] = if odd_x { -v } else { v };
                if odd_x && 2 * i % mx == 0 {
                    row[i] = 0.0;
                }
            }
        };
        let part = |wave: &Complex<f64>| if odd_x { wave.im } else { wave.re };
        let pair = |waves: &mut [Complex<f64>]| {
            for k in 0..nkx.div_ceil(2) {
                let second = waves.get(2 * k + 1).map_or(0.0, part);
                waves[k] = Complex::new(part(&waves[2 * k]), second);
            }
        };
        let cost = VALUE * (reach_x + 1) as f64;
        self.forward_rows(layout, spectra, fill, pair, cost, monitor);
        let normalisation = self.normalisation();
        let mut values = vec![0.0; nkx * nky];
        self.kernel_columns(
            layout,
            spectra,
            |j| j,
            |column| {
                for j in 1..=reach_y {
                    column[my - j] = if odd_y { -column[j] } else { column[j] };
                }
                for j in (0..=reach_y).filter(|j| odd_y && (2 * j) % my == 0) {
                    column[j] = Complex::default();
                }
            },
            &mut values,
            2 * nky,
            |column, values| {
                let (first, second) = values.split_at_mut(nky);
                // odd columns have i times a real spectrum, and with an odd row before them i times i times
                let sign = normalisation * if odd_x && odd_y { -1.0 } else { 1.0 };
                for (value, wave) in first.iter_mut().zip(column) {
                    *value = sign * if odd_y { wave.im } else { wave.re };
                }
                for (value, wave) in second.iter_mut().zip(column) {
                    *value = sign * if odd_y { -wave.re } else { wave.im };
                }
            },
            monitor,
        );
        Kernel::of(Values::Mirrored {
            quarter: values,
            odd,
        })
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
        Kernel::of(Values::General(values))
    }

    /// Even kernel from its real spectrum at the wave indices `kx <= mx / 2`, `ky <= my / 2`.
    pub fn even_kernel_from_spectrum(&self, value: impl Fn(usize, usize) -> f64 + Sync) -> Kernel {
        Kernel::of(Values::Mirrored {
            quarter: self.quarter(value),
            odd: [false, false],
        })
    }

    /// Kernel that is odd along x and along y from its real spectrum at the wave indices `kx <= mx / 2`,
    /// `ky <= my / 2`.
    pub fn odd_kernel_from_spectrum(&self, value: impl Fn(usize, usize) -> f64 + Sync) -> Kernel {
        Kernel::of(Values::Mirrored {
            quarter: self.quarter(value),
            odd: [true, true],
        })
    }

    /// A quarter of a spectrum, scaled.
    fn quarter(&self, value: impl Fn(usize, usize) -> f64 + Sync) -> Vec<f64> {
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
        values
    }

    /// Value of the spectrum of `kernel` at the wave indices `(kx, ky)`.
    pub fn spectrum(&self, kernel: &Kernel, kx: usize, ky: usize) -> Complex<f64> {
        let my = self.padded[1];
        let scale = (self.padded[0] * my) as f64;
        match &kernel.values {
            Values::Mirrored { quarter, odd } => {
                let value = quarter[kx * (my / 2 + 1) + ky.min(my - ky)] * scale;
                let value = if odd[1] && 2 * ky > my { -value } else { value };
                if odd[0] == odd[1] {
                    Complex::new(value, 0.0)
                } else {
                    Complex::new(0.0, value)
                }
            }
            Values::General(v) => v[kx * my + ky] * scale,
        }
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Products on grids whose rows are alike along x only.

use std::sync::Arc;

use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex;

use crate::fourier::fast_even_size;

/// Operations of a product from which a second thread pays.
const PARALLEL_FROM: f64 = 2e5;

/// From the number of a wave and the real and imaginary parts of all rows there, to those of the rows of the image.
type Wave<'a> = &'a (dyn Fn(usize, &[f64], &[f64], &mut [[f64; 2]]) + Sync);

/// A linear map between grids that depends on the offset along x, and on both rows in any way.
///
/// Equals the dense matrix `A[(i, t), (j, s)] = value(t, s, i - j)` to rounding: by the Fourier transform
/// along x, and by a dense matrix over the rows for each wave. So what differs from row to row, such as hats
/// that end at the first and the last one, costs nothing more. A product takes about
/// `4 nx ny_target ny_source` operations, twice as many where the kernel is neither even nor odd along x, and
/// the map as many numbers as half of that.
pub struct RowConvolution {
    source: [usize; 2],
    target: [usize; 2],
    forward: Arc<dyn RealToComplex<f64>>,
    back: Arc<dyn ComplexToReal<f64>>,
    /// Real and imaginary parts of the spectra, `[wave][source row][target row]`; `None` where they vanish.
    parts: [Option<Vec<f64>>; 2],
}

impl RowConvolution {
    /// From `source` to `target`, both `[nx, ny]`; `value(target row, source row, offset)` is asked for the
    /// offsets `-(nx_source - 1) ..= nx_target - 1`, target minus source.
    pub fn new(
        source: [usize; 2],
        target: [usize; 2],
        value: impl Fn(usize, usize, isize) -> f64 + Sync,
    ) -> Self {
        let length = fast_even_size(source[0] + target[0] - 1);
        let mut planner = RealFftPlanner::new();
        let (forward, back) = (
            planner.plan_fft_forward(length),
            planner.plan_fft_inverse(length),
        );
        let waves = length / 2 + 1;
        let (from, to) = (source[1], target[1]);
        let mut spectra = vec![Complex::default(); from * to * waves];
        spectra
            .par_chunks_exact_mut(waves.max(1))
            .enumerate()
            .for_each(|(pair, spectrum)| {
                let (s, t) = (pair / to, pair % to);
                let mut row = vec![0.0; length];
                for offset in 1 - source[0] as isize..target[0] as isize {
                    row[offset.rem_euclid(length as isize) as usize] =
                        value(t, s, offset) / length as f64;
                }
                let done = forward.process(&mut row, spectrum);
                debug_assert!(done.is_ok());
            });
        let part = |of: fn(&Complex<f64>) -> f64| -> Vec<f64> {
            let mut values = vec![0.0; spectra.len()];
            for (pair, spectrum) in spectra.chunks_exact(waves).enumerate() {
                for (k, value) in spectrum.iter().enumerate() {
                    values[k * from * to + pair] = of(value);
                }
            }
            values
        };
        let (re, im) = (part(|z| z.re), part(|z| z.im));
        let largest = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let least = 1e-15 * largest(&re).max(largest(&im)) * (length as f64).sqrt();
        let kept = |v: Vec<f64>| (largest(&v) > least).then_some(v);
        Self {
            source,
            target,
            forward,
            back,
            parts: [kept(re), kept(im)],
        }
    }

    /// Memory [bytes] of the map between grids of such sides, where the kernel is even or odd along x.
    pub fn memory(source: [usize; 2], target: [usize; 2]) -> f64 {
        8.0 * (source[0] + target[0]) as f64 / 2.0 * (source[1] * target[1]) as f64
    }

    /// Adds `scale` times the image of `x` to `y`; both x fastest.
    pub fn apply_add(&self, scale: f64, x: &[f64], y: &mut [f64]) {
        let [nx, from] = self.source;
        let [mx, to] = self.target;
        self.product([nx, mx], [from, to], scale, x, y, &|k, re, im, moved| {
            let (mut a, mut b) = (vec![0.0; to], vec![0.0; to]);
            if let Some(part) = self.block(0, k) {
                for (s, column) in part.chunks_exact(to).enumerate() {
                    add_two(&mut a, &mut b, re[s], im[s], column);
                }
            }
            if let Some(part) = self.block(1, k) {
                for (s, column) in part.chunks_exact(to).enumerate() {
                    add_two(&mut a, &mut b, -im[s], re[s], column);
                }
            }
            for ((moved, a), b) in moved.iter_mut().zip(a).zip(b) {
                *moved = [a, b];
            }
        });
    }

    /// Adds `scale` times the product of the transposed map with `x`, on the target, to `y`, on the source.
    pub fn apply_transposed_add(&self, scale: f64, x: &[f64], y: &mut [f64]) {
        let [nx, to] = self.source;
        let [mx, from] = self.target;
        self.product([mx, nx], [from, to], scale, x, y, &|k, re, im, moved| {
            if let Some(part) = self.block(0, k) {
                for (moved, column) in moved.iter_mut().zip(part.chunks_exact(from)) {
                    *moved = two_products(re, im, column);
                }
            }
            // seen from the other end a wave has the other phase
            if let Some(part) = self.block(1, k) {
                for (moved, column) in moved.iter_mut().zip(part.chunks_exact(from)) {
                    let [a, b] = two_products(re, im, column);
                    *moved = [moved[0] + b, moved[1] - a];
                }
            }
        });
    }

    /// Real (0) or imaginary (1) parts of the wave `k`, `[source row][target row]`.
    fn block(&self, part: usize, k: usize) -> Option<&[f64]> {
        let pairs = self.source[1] * self.target[1];
        let part = self.parts[part].as_ref()?;
        Some(&part[k * pairs..(k + 1) * pairs])
    }

    /// Adds `scale` times what `wave` makes of the waves of the rows of `x` to the rows of `y`.
    fn product(
        &self,
        [nx, mx]: [usize; 2],
        [from, to]: [usize; 2],
        scale: f64,
        x: &[f64],
        y: &mut [f64],
        wave: Wave<'_>,
    ) {
        let length = self.forward.len();
        let waves = length / 2 + 1;
        // [real, imaginary][wave][row]
        let mut loaded = vec![0.0; 2 * waves * from];
        let mut row = vec![0.0; length];
        let mut spectrum = vec![Complex::default(); waves];
        let mut scratch = self.forward.make_scratch_vec();
        for (s, x) in x.chunks_exact(nx).enumerate() {
            row[..nx].copy_from_slice(x);
            row[nx..].fill(0.0);
            let done = self
                .forward
                .process_with_scratch(&mut row, &mut spectrum, &mut scratch);
            debug_assert!(done.is_ok());
            for (k, z) in spectrum.iter().enumerate() {
                loaded[k * from + s] = z.re;
                loaded[(waves + k) * from + s] = z.im;
            }
        }
        let (re, im) = loaded.split_at(waves * from);
        let mut moved = vec![[0.0; 2]; waves * to];
        let each = |(k, moved): (usize, &mut [[f64; 2]])| {
            let rows = k * from..(k + 1) * from;
            wave(k, &re[rows.clone()], &im[rows], moved);
        };
        if 4.0 * (waves * from * to) as f64 >= PARALLEL_FROM && rayon::current_num_threads() > 1 {
            moved.par_chunks_exact_mut(to).enumerate().for_each(each);
        } else {
            moved.chunks_exact_mut(to).enumerate().for_each(each);
        }
        let mut scratch = self.back.make_scratch_vec();
        for (t, y) in y.chunks_exact_mut(mx).enumerate() {
            for (k, z) in spectrum.iter_mut().enumerate() {
                let [re, im] = moved[k * to + t];
                *z = Complex::new(re, im);
            }
            // rounding, which the inverse does not take
            spectrum[0].im = 0.0;
            spectrum[waves - 1].im = 0.0;
            let done = self
                .back
                .process_with_scratch(&mut spectrum, &mut row, &mut scratch);
            debug_assert!(done.is_ok());
            for (y, moved) in y.iter_mut().zip(&row) {
                *y += scale * moved;
            }
        }
    }
}

/// The products of two rows with a third.
fn two_products(a: &[f64], b: &[f64], column: &[f64]) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for ((a, b), c) in a.iter().zip(b).zip(column) {
        sums[0] += a * c;
        sums[1] += b * c;
    }
    sums
}

/// Adds the two multiples of a column.
fn add_two(a: &mut [f64], b: &mut [f64], by_a: f64, by_b: f64, column: &[f64]) {
    for ((a, b), c) in a.iter_mut().zip(b).zip(column) {
        *a += by_a * c;
        *b += by_b * c;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equals_the_dense_matrix() {
        type Value = fn(usize, usize, isize) -> f64;
        let any: Value =
            |t, s, o| (1.0 + t as f64 + 0.3 * s as f64) / (2.0 + (o as f64 - 0.4).abs());
        let even: Value = |t, s, o| (1.0 + t as f64 * s as f64) / (1.0 + o.unsigned_abs() as f64);
        let odd: Value = |t, s, o| (t as f64 - s as f64 + 0.5) * o as f64 / (3.0 + (o * o) as f64);
        for (value, source, target) in [
            (any, [5, 3], [8, 2]),
            (even, [7, 4], [7, 4]),
            (odd, [6, 3], [6, 3]),
            (odd, [1, 2], [4, 1]),
        ] {
            let map = RowConvolution::new(source, target, value);
            let x: Vec<f64> = (0..source[0] * source[1])
                .map(|i| ((7 * i) % 5) as f64 - 1.5)
                .collect();
            let mut y = vec![1.0; target[0] * target[1]];
            map.apply_add(-2.0, &x, &mut y);
            for (k, y) in y.iter().enumerate() {
                let (i, t) = (k % target[0], k / target[0]);
                let sum: f64 = x
                    .iter()
                    .enumerate()
                    .map(|(l, x)| {
                        let (j, s) = (l % source[0], l / source[0]);
                        x * value(t, s, i as isize - j as isize)
                    })
                    .sum();
                assert!((y - (1.0 - 2.0 * sum)).abs() < 1e-12, "{y} {sum}");
            }
            let weights: Vec<f64> = (0..y.len()).map(|k| ((5 * k) % 7) as f64 - 2.5).collect();
            let mut back = vec![1.0; x.len()];
            map.apply_transposed_add(-2.0, &weights, &mut back);
            for (l, back) in back.iter().enumerate() {
                let (j, s) = (l % source[0], l / source[0]);
                let sum: f64 = weights
                    .iter()
                    .enumerate()
                    .map(|(k, w)| {
                        let (i, t) = (k % target[0], k / target[0]);
                        w * value(t, s, i as isize - j as isize)
                    })
                    .sum();
                assert!((back - (1.0 - 2.0 * sum)).abs() < 1e-12, "{back} {sum}");
            }
        }
    }

    #[test]
    fn what_is_even_or_odd_takes_half_the_memory() {
        let even = RowConvolution::new([9, 2], [9, 2], |_, _, o| 1.0 / (1.0 + (o * o) as f64));
        let odd = RowConvolution::new([9, 2], [9, 2], |_, _, o| o as f64);
        assert!(even.parts[1].is_none() && odd.parts[0].is_none());
    }
}

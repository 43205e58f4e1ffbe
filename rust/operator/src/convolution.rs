// SPDX-License-Identifier: MIT OR Apache-2.0
use crate::{Kernel, LinearOperator, Transform};

/// The convolution of one grid with one kernel, as a linear map: free space or periodic.
///
/// Equals the dense matrix `A[(i, j), (k, l)] = kernel(i - k, j - l)` to rounding.
pub struct Convolution {
    transform: Transform,
    kernel: Kernel,
}

impl Convolution {
    /// Free space on `[nx, ny]` points with a kernel given at the offsets `-(n - 1) ..= n - 1`.
    pub fn new(shape: [usize; 2], kernel: impl Fn(isize, isize) -> f64 + Sync) -> Self {
        let transform = Transform::new(shape, shape);
        let kernel = transform.kernel(kernel);
        Self { transform, kernel }
    }

    /// Free space with a kernel even along x and along y, given at the offsets `0 ..= n - 1`.
    pub fn even(shape: [usize; 2], kernel: impl Fn(usize, usize) -> f64 + Sync) -> Self {
        let transform = Transform::new(shape, shape);
        let kernel = transform.even_kernel(kernel);
        Self { transform, kernel }
    }

    /// Periodic on `[nx, ny]` points, given by its real even spectrum at the wave indices
    /// `kx <= nx / 2`, `ky <= ny / 2`.
    pub fn periodic(shape: [usize; 2], spectrum: impl Fn(usize, usize) -> f64 + Sync) -> Self {
        let transform = Transform::periodic(shape);
        let kernel = transform.even_kernel_from_spectrum(spectrum);
        Self { transform, kernel }
    }

    /// Adds `scale` times the image of `x` to `y`.
    pub fn apply_add(&self, scale: f64, x: &[f64], y: &mut [f64]) {
        self.transform.apply_add(&self.kernel, scale, x, y);
    }
}

impl LinearOperator for Convolution {
    fn dim(&self) -> usize {
        let [nx, ny] = self.transform.source();
        nx * ny
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        self.apply_add(1.0, x, y);
    }
}

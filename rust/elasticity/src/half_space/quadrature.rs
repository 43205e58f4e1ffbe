// SPDX-License-Identifier: MIT OR Apache-2.0
//! Quadrature and interpolation points on [-1, 1].

/// Gauss-Legendre rule of six points: (node, weight), exact to degree 11.
pub(super) const GAUSS_6: [(f64, f64); 6] = [
    (-0.932_469_514_203_152, 0.171_324_492_379_170_36),
    (-0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (-0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (0.932_469_514_203_152, 0.171_324_492_379_170_36),
];

/// Chebyshev points of the first kind.
pub(super) fn chebyshev(order: usize) -> Vec<f64> {
    (0..order)
        .map(|k| (std::f64::consts::PI * (k as f64 + 0.5) / order as f64).cos())
        .collect()
}

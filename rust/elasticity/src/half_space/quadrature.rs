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

/// The same of two points.
pub(super) const GAUSS_2: [(f64, f64); 2] = [
    (-0.577_350_269_189_625_8, 1.0),
    (0.577_350_269_189_625_8, 1.0),
];

/// The same of three points.
pub(super) const GAUSS_3: [(f64, f64); 3] = [
    (-0.774_596_669_241_483_4, 5.0 / 9.0),
    (0.0, 8.0 / 9.0),
    (0.774_596_669_241_483_4, 5.0 / 9.0),
];

/// The same of four points.
pub(super) const GAUSS_4: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
    (-0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
    (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
];

/// Chebyshev points of the first kind.
pub(super) fn chebyshev(order: usize) -> Vec<f64> {
    (0..order)
        .map(|k| (std::f64::consts::PI * (k as f64 + 0.5) / order as f64).cos())
        .collect()
}

/// Gauss-Legendre rule: (node, weight), by Newton's steps on the recurrence of the polynomials.
pub(super) fn gauss_legendre(order: usize) -> Vec<(f64, f64)> {
    let n = order as f64;
    let value_and_slope = |x: f64| {
        let (mut before, mut now) = (1.0, x);
        for k in 2..=order {
            let k = k as f64;
            (before, now) = (now, ((2.0 * k - 1.0) * x * now - (k - 1.0) * before) / k);
        }
        (now, n * (x * now - before) / (x * x - 1.0))
    };
    (0..order)
        .map(|k| {
            let mut x = -(std::f64::consts::PI * (k as f64 + 0.75) / (n + 0.5)).cos();
            for _ in 0..6 {
                let (value, slope) = value_and_slope(x);
                x -= value / slope;
            }
            let (_, slope) = value_and_slope(x);
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

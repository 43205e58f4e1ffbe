// SPDX-License-Identifier: MIT OR Apache-2.0
use super::piece::{Curve, Piece};

/// Cubic spline with not-a-knot ends through at least two points; fewer than four give the
/// polynomial through them. y rises strictly.
pub(super) fn not_a_knot(y: &[f64], z: &[f64]) -> Vec<Piece> {
    let n = y.len();
    let h: Vec<f64> = y.windows(2).map(|w| w[1] - w[0]).collect();
    let secant: Vec<f64> = (0..n - 1).map(|i| (z[i + 1] - z[i]) / h[i]).collect();
    let slopes = match n {
        2 => vec![secant[0]; 2],
        3 => {
            let bend = (secant[1] - secant[0]) / (h[0] + h[1]);
            vec![
                secant[0] - bend * h[0],
                secant[0] + bend * h[0],
                secant[1] + bend * h[1],
            ]
        }
        _ => knot_slopes(&h, &secant),
    };
    (0..n - 1)
        .map(|i| {
            let (d0, d1) = (slopes[i], slopes[i + 1]);
            let coefficients = vec![
                z[i],
                d0,
                (3.0 * secant[i] - 2.0 * d0 - d1) / h[i],
                (d0 + d1 - 2.0 * secant[i]) / (h[i] * h[i]),
            ];
            let curve = Curve::Polynomial {
                origin: y[i],
                coefficients,
            };
            Piece::new(y[i], y[i + 1], curve)
        })
        .collect()
}

/// Slopes at the knots: second derivatives continuous inside, third ones at the second and the last
/// but one knot; a tridiagonal system.
fn knot_slopes(h: &[f64], secant: &[f64]) -> Vec<f64> {
    let n = h.len() + 1;
    let (mut lower, mut diagonal) = (vec![0.0; n], vec![0.0; n]);
    let (mut upper, mut slope) = (vec![0.0; n], vec![0.0; n]);
    let end = |near: f64, next: f64, s_near: f64, s_next: f64| {
        let both = near + next;
        ((near + 2.0 * both) * next * s_near + near * near * s_next) / both
    };
    diagonal[0] = h[1];
    upper[0] = h[0] + h[1];
    slope[0] = end(h[0], h[1], secant[0], secant[1]);
    for i in 1..n - 1 {
        lower[i] = h[i];
        diagonal[i] = 2.0 * (h[i - 1] + h[i]);
        upper[i] = h[i - 1];
        slope[i] = 3.0 * (h[i] * secant[i - 1] + h[i - 1] * secant[i]);
    }
    lower[n - 1] = h[n - 2] + h[n - 3];
    diagonal[n - 1] = h[n - 3];
    slope[n - 1] = end(h[n - 2], h[n - 3], secant[n - 2], secant[n - 3]);
    for i in 1..n {
        let factor = lower[i] / diagonal[i - 1];
        diagonal[i] -= factor * upper[i - 1];
        slope[i] -= factor * slope[i - 1];
    }
    slope[n - 1] /= diagonal[n - 1];
    for i in (0..n - 1).rev() {
        slope[i] = (slope[i] - upper[i] * slope[i + 1]) / diagonal[i];
    }
    slope
}

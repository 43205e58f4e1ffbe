// SPDX-License-Identifier: MIT OR Apache-2.0
use super::piece::{Curve, Piece};

/// Cubic spline with not-a-knot ends through at least two points; fewer than four give the
/// polynomial through them. y rises strictly.
pub(super) fn not_a_knot(y: &[f64], z: &[f64]) -> Vec<Piece> {
    let n = y.len();
    let h: Vec<f64> = y.windows(2).map(|w| w[1] - w[0]).collect();
    let secant: Vec<f64> = (0..n - 1).map(|i| (z[i + 1] - z[i]) / h[i]).collect();
    let slopes = slopes(&h, &secant);
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

/// Slopes at the knots of the spline, from the distances between them and the secants.
pub(super) fn slopes(h: &[f64], secant: &[f64]) -> Vec<f64> {
    match h.len() {
        1 => vec![secant[0]; 2],
        2 => {
            let bend = (secant[1] - secant[0]) / (h[0] + h[1]);
            vec![
                secant[0] - bend * h[0],
                secant[0] + bend * h[0],
                secant[1] + bend * h[1],
            ]
        }
        _ => knot_slopes(h, secant),
    }
}

/// The same for a closed curve of at least three knots, which the last secant brings back to the first one.
pub(super) fn cyclic_slopes(h: &[f64], secant: &[f64]) -> Vec<f64> {
    let n = h.len();
    let before = |i: usize| (i + n - 1) % n;
    let lower: Vec<f64> = h.to_vec();
    let upper: Vec<f64> = (0..n).map(|i| h[before(i)]).collect();
    let mut diagonal: Vec<f64> = (0..n).map(|i| 2.0 * (h[before(i)] + h[i])).collect();
    let right: Vec<f64> = (0..n)
        .map(|i| 3.0 * (h[i] * secant[before(i)] + h[before(i)] * secant[i]))
        .collect();
    // the two corners are taken out as a product of two vectors [Sherman & Morrison]
    let (corner, last) = (-diagonal[0], n - 1);
    diagonal[0] -= corner;
    diagonal[last] -= upper[last] * lower[0] / corner;
    let mut beside = vec![0.0; n];
    (beside[0], beside[last]) = (corner, upper[last]);
    let solved = |mut x: Vec<f64>| {
        let mut pivot = diagonal.clone();
        for i in 1..n {
            let factor = lower[i] / pivot[i - 1];
            pivot[i] -= factor * upper[i - 1];
            x[i] -= factor * x[i - 1];
        }
        x[last] /= pivot[last];
        for i in (0..last).rev() {
            x[i] = (x[i] - upper[i] * x[i + 1]) / pivot[i];
        }
        x
    };
    let (mut slope, beside) = (solved(right), solved(beside));
    let share = lower[0] / corner;
    let factor = (slope[0] + share * slope[last]) / (1.0 + beside[0] + share * beside[last]);
    for (slope, beside) in slope.iter_mut().zip(&beside) {
        *slope -= factor * beside;
    }
    slope
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

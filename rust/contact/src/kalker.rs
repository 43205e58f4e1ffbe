// SPDX-License-Identifier: MIT OR Apache-2.0
//! Kalker's linear creep coefficients.

use crate::Error;
use crate::error::check_number;

/// Linear creep coefficients of an elliptic contact.
///
/// For small creepages, full adhesion, and both bodies of the same material
/// `F_x = a b G c11 xi`, `F_y = a b G (c22 eta + sqrt(a b) c23 phi)`,
/// `M_z = a b G (-sqrt(a b) c23 eta + a b c33 phi)`; forces on the lower body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CreepCoefficients {
    /// Longitudinal.
    pub c11: f64,
    /// Lateral.
    pub c22: f64,
    /// Lateral force by spin, and minus the moment by lateral creepage.
    pub c23: f64,
    /// Moment by spin.
    pub c33: f64,
}

/// Semi-axis ratios `a / b` of the table, `a` along the rolling direction.
const RATIOS: [f64; 19] = [
    0.1,
    0.2,
    0.3,
    0.4,
    0.5,
    0.6,
    0.7,
    0.8,
    0.9,
    1.0,
    1.0 / 0.9,
    1.0 / 0.8,
    1.0 / 0.7,
    1.0 / 0.6,
    2.0,
    2.5,
    1.0 / 0.3,
    5.0,
    10.0,
];

/// One row per ratio: c11, c22, c23, c33, each for Poisson's ratios 0, 1/4, 1/2. [Kalker1990, app. E]
#[rustfmt::skip]
#[allow(clippy::approx_constant, reason = "3.14 is an entry of the table")]
const TABLE: [[[f64; 3]; 4]; 19] = [
    [[2.51, 3.31, 4.85], [2.51, 2.52, 2.53], [0.334, 0.473, 0.731], [6.42, 8.28, 11.7]],
    [[2.59, 3.37, 4.81], [2.59, 2.63, 2.66], [0.483, 0.603, 0.809], [3.46, 4.27, 5.66]],
    [[2.68, 3.44, 4.80], [2.68, 2.75, 2.81], [0.607, 0.715, 0.889], [2.49, 2.96, 3.72]],
    [[2.78, 3.53, 4.82], [2.78, 2.88, 2.98], [0.720, 0.823, 0.977], [2.02, 2.32, 2.77]],
    [[2.88, 3.62, 4.83], [2.88, 3.01, 3.14], [0.827, 0.929, 1.07], [1.74, 1.93, 2.22]],
    [[2.98, 3.72, 4.91], [2.98, 3.14, 3.31], [0.930, 1.03, 1.18], [1.56, 1.68, 1.86]],
    [[3.09, 3.81, 4.97], [3.09, 3.28, 3.48], [1.03, 1.14, 1.29], [1.43, 1.50, 1.60]],
    [[3.19, 3.91, 5.05], [3.19, 3.41, 3.65], [1.13, 1.25, 1.40], [1.34, 1.37, 1.42]],
    [[3.29, 4.01, 5.12], [3.29, 3.54, 3.82], [1.23, 1.36, 1.51], [1.27, 1.27, 1.27]],
    [[3.40, 4.12, 5.20], [3.40, 3.67, 3.98], [1.33, 1.47, 1.63], [1.21, 1.19, 1.16]],
    [[3.51, 4.22, 5.30], [3.51, 3.81, 4.16], [1.44, 1.59, 1.77], [1.16, 1.11, 1.06]],
    [[3.65, 4.36, 5.42], [3.65, 3.99, 4.39], [1.58, 1.75, 1.94], [1.10, 1.04, 0.954]],
    [[3.82, 4.54, 5.58], [3.82, 4.21, 4.67], [1.76, 1.95, 2.18], [1.05, 0.965, 0.852]],
    [[4.06, 4.78, 5.80], [4.06, 4.50, 5.04], [2.01, 2.23, 2.50], [1.01, 0.892, 0.751]],
    [[4.37, 5.10, 6.11], [4.37, 4.90, 5.56], [2.35, 2.62, 2.96], [0.958, 0.819, 0.650]],
    [[4.84, 5.57, 6.57], [4.84, 5.48, 6.31], [2.88, 3.24, 3.70], [0.912, 0.747, 0.549]],
    [[5.57, 6.34, 7.34], [5.57, 6.40, 7.51], [3.79, 4.32, 5.01], [0.868, 0.674, 0.446]],
    [[6.96, 7.78, 8.82], [6.96, 8.14, 9.79], [5.72, 6.63, 7.89], [0.828, 0.601, 0.341]],
    [[10.7, 11.7, 12.9], [10.7, 12.8, 16.0], [12.2, 14.6, 18.0], [0.795, 0.526, 0.228]],
];

/// Relative departure from the ends of the table that is rounding.
const ROUNDED: f64 = 1e-6;

/// Linear creep coefficients for the semi-axis ratio `a / b` and Poisson's ratio.
///
/// Interpolated in the published table: the reciprocals quadratically in Poisson's ratio (they
/// are flexibilities), the logarithms by cubics in the logarithm of the ratio.
///
/// # Errors
/// [`Error::Number`] for a ratio outside 0.1 to 10 or a Poisson's ratio outside 0 to 0.5.
pub fn creep_coefficients(ratio: f64, poisson_ratio: f64) -> Result<CreepCoefficients, Error> {
    // axes found from a pressure may lie on the ends but for rounding
    let within = 0.1 * (1.0 - ROUNDED)..=10.0 * (1.0 + ROUNDED);
    check_number(
        "ratio a / b of the semi-axes",
        ratio,
        within.contains(&ratio),
        "0.1 to 10 is needed",
    )?;
    check_number(
        "poisson_ratio",
        poisson_ratio,
        (0.0..=0.5).contains(&poisson_ratio),
        "a number from 0 to 0.5 is needed",
    )?;
    let x = ratio.ln();
    let above = RATIOS
        .partition_point(|r| *r <= ratio)
        .clamp(1, RATIOS.len() - 1);
    let first = above.saturating_sub(2).min(RATIOS.len() - 4);
    let nodes = [0, 1, 2, 3].map(|k| RATIOS[first + k].ln());
    let weights = lagrange(&nodes, x);
    let of_nu = lagrange(&[0.0, 0.25, 0.5], poisson_ratio);
    let coefficient = |which: usize| -> f64 {
        let logarithm: f64 = (0..4)
            .map(|k| {
                let row = &TABLE[first + k][which];
                let flexibility: f64 = (0..3).map(|m| of_nu[m] / row[m]).sum();
                -weights[k] * flexibility.ln()
            })
            .sum();
        logarithm.exp()
    };
    Ok(CreepCoefficients {
        c11: coefficient(0),
        c22: coefficient(1),
        c23: coefficient(2),
        c33: coefficient(3),
    })
}

/// Weights of the nodes in the interpolating polynomial at `x`.
fn lagrange<const N: usize>(nodes: &[f64; N], x: f64) -> [f64; N] {
    std::array::from_fn(|i| {
        (0..N)
            .filter(|j| *j != i)
            .map(|j| (x - nodes[j]) / (nodes[i] - nodes[j]))
            .product()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meets_the_table_at_its_nodes() {
        for (ratio, rows) in RATIOS.iter().zip(&TABLE) {
            for (m, nu) in [0.0, 0.25, 0.5].into_iter().enumerate() {
                let c = creep_coefficients(*ratio, nu).unwrap();
                for (found, row) in [c.c11, c.c22, c.c23, c.c33].iter().zip(rows) {
                    assert!((found / row[m] - 1.0).abs() < 1e-12, "{ratio} {nu}");
                }
            }
        }
    }

    #[test]
    fn is_smooth_between_the_nodes() {
        // each node left out is predicted by its neighbours within the rounding of the table
        let mut last = creep_coefficients(0.1, 0.3).unwrap();
        for k in 1..=200 {
            let c =
                creep_coefficients(10_f64.powf(-1.0 + 0.01 * f64::from(k)).min(10.0), 0.3).unwrap();
            for (new, old) in [(c.c22, last.c22), (c.c23, last.c23), (last.c33, c.c33)] {
                assert!(new > old && new < 1.06 * old);
            }
            last = c;
        }
    }

    #[test]
    fn refuses_what_the_table_does_not_hold() {
        let error = creep_coefficients(0.05, 0.3).unwrap_err();
        assert_eq!(
            error.to_string(),
            "ratio a / b of the semi-axes is 0.05, 0.1 to 10 is needed"
        );
    }
}

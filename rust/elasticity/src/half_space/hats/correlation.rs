// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the hats of two nodes weigh at each offset between them.

use super::moments::POWERS;

/// Powers of all four intervals that the correlation of two hats spans.
const SPAN: usize = 4 * POWERS;

/// Sides a hat may have in one direction: both, the right only, the left only.
const SIDES: usize = 3;
pub(super) const VARIANTS: usize = SIDES * SIDES;

pub(super) fn side(node: usize, nodes: usize) -> usize {
    if node == 0 {
        1
    } else if node == nodes - 1 {
        2
    } else {
        0
    }
}

pub(super) fn variant(observed: usize, loaded: usize) -> usize {
    observed * SIDES + loaded
}

/// Correlations `C(x) = int a(x + s) b(s) ds` of every pair of hats with sides 1, cubic on each of the
/// intervals from -2 to 2: coefficients of 1, t, t^2, t^3 with t from 0 to 1 across the interval.
pub(super) fn correlations() -> [[f64; SPAN]; VARIANTS] {
    // right half 1 - s with itself: t^2/2 - t^3/6, t = 1 - |x|
    let like = [
        [0.0; POWERS],
        [0.0, 0.0, 0.5, -1.0 / 6.0],
        [1.0 / 3.0, -0.5, 0.0, 1.0 / 6.0],
        [0.0; POWERS],
    ];
    // right half over left half: x - x^2 + x^3/6, then (2 - x)^3/6
    let right_left = [
        [0.0; POWERS],
        [0.0; POWERS],
        [0.0, 1.0, -1.0, 1.0 / 6.0],
        [1.0 / 6.0, -0.5, 0.5, -1.0 / 6.0],
    ];
    let left_right = [
        [0.0, 0.0, 0.0, 1.0 / 6.0],
        [1.0 / 6.0, 0.5, -0.5, -1.0 / 6.0],
        [0.0; POWERS],
        [0.0; POWERS],
    ];
    let mut correlations = [[0.0; SPAN]; VARIANTS];
    for observed in 0..SIDES {
        for loaded in 0..SIDES {
            let sum = &mut correlations[variant(observed, loaded)];
            let has = |side: usize, cut: usize| side != cut;
            for (left, right, piece) in [
                (has(observed, 2), has(loaded, 2), &like),
                (has(observed, 1), has(loaded, 1), &like),
                (has(observed, 2), has(loaded, 1), &right_left),
                (has(observed, 1), has(loaded, 2), &left_right),
            ] {
                if left && right {
                    for (sum, c) in sum.iter_mut().zip(piece.as_flattened()) {
                        *sum += c;
                    }
                }
            }
        }
    }
    correlations
}

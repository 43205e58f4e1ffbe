// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sums over the contact set, and the balance of the free motions.

use std::array::from_fn;

use super::Mode;
use super::sums::Spans;

/// Solves the small symmetric system `a x = b`; directions without stiffness get zero.
pub(super) fn solve_small(a: &[[f64; 3]; 3], b: [f64; 3], m: usize) -> [f64; 3] {
    let (mut a, mut b) = (*a, b);
    let mut used = [usize::MAX; 3];
    let mut free: Vec<usize> = (0..m).collect();
    let scale: [f64; 3] = std::array::from_fn(|k| a[k][k]);
    while let Some(&pivot) = free.iter().max_by(|i, j| {
        let relative = |k: usize| a[k][k] / scale[k].max(f64::MIN_POSITIVE);
        relative(**i).total_cmp(&relative(**j))
    }) {
        free.retain(|k| *k != pivot);
        if a[pivot][pivot] <= 1e-12 * scale[pivot] || a[pivot][pivot] <= 0.0 {
            continue;
        }
        used[pivot] = pivot;
        for k in 0..m {
            if k != pivot && (free.contains(&k) || used[k] == k) {
                let factor = a[k][pivot] / a[pivot][pivot];
                for j in 0..m {
                    a[k][j] -= factor * a[pivot][j];
                }
                b[k] -= factor * b[pivot];
            }
        }
    }
    std::array::from_fn(|k| {
        if k < m && used[k] == k {
            b[k] / a[k][k]
        } else {
            0.0
        }
    })
}

/// Restores the balance `N^T p = f` by factors `1 + N y` on the pressures, cutting off what turns
/// negative; false where no such factors are found. The pressures vanish outside of `set`, which `spans` hold.
pub(super) fn balance(modes: &[Mode], p: &mut [f64], spans: &Spans, set: &[bool]) -> bool {
    if modes.is_empty() {
        return true;
    }
    let mut worst = f64::INFINITY;
    for _ in 0..30 {
        // sums, the same without cancellation, and the stiffness against factors
        let (mut sum, mut size, mut gram) = ([0.0; 3], [0.0; 3], [[0.0; 3]; 3]);
        for (k, mode) in modes.iter().enumerate() {
            let moments = |[]: [f64; 0], [p, n]: [f64; 2], _: bool| {
                let part = p * n;
                ([], [part, part.abs(), part * n])
            };
            [sum[k], size[k], gram[k][k]] = spans.sum([], [p, &mode.shape], set, moments);
            for (l, other) in modes[..k].iter().enumerate() {
                let product = |[]: [f64; 0], [n, m, p]: [f64; 3], _: bool| ([], [n * m * p]);
                [gram[k][l]] = spans.sum([], [&mode.shape, &other.shape, p], set, product);
                gram[l][k] = gram[k][l];
            }
        }
        let mut missing = [0.0; 3];
        worst = 0.0_f64;
        for (k, mode) in modes.iter().enumerate() {
            missing[k] = mode.target - sum[k];
            let size = size[k] + mode.target.abs();
            if size > 0.0 {
                worst = worst.max(missing[k].abs() / size);
            }
        }
        if worst <= 1e-14 {
            return true;
        }
        let y = solve_small(&gram, missing, modes.len());
        if y.iter().all(|y| *y == 0.0) {
            break;
        }
        // a motion that is none leaves its share of the factors out
        let shapes = from_fn(|k| modes.get(k).unwrap_or(&modes[0]).shape.as_slice());
        let scale = |[p]: [f64; 1], [n, m, l]: [f64; 3], _: bool| {
            ([p * (1.0 + y[0] * n + y[1] * m + y[2] * l).max(0.0)], [])
        };
        spans.sum([p], shapes, set, scale);
    }
    // tilts at the edge of what is possible: the last digits are left to the next step
    worst <= 1e-6
}

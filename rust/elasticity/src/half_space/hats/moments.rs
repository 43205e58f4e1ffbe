// SPDX-License-Identifier: MIT OR Apache-2.0
//! Integrals of a singular kernel times polynomials.

use super::super::quadrature::GAUSS_6;

/// Coefficients of a cubic.
pub(super) const POWERS: usize = 4;

/// Integrals over a cell of the kernel times `s^a t^b`, with `s, t` from 0 to 1 across the cell:
/// `[b][a]`. `start`: lower corner of the cell; the kernel is singular at the origin.
pub(super) fn moments(
    kernel: &impl Fn(f64, f64) -> f64,
    start: [f64; 2],
    cell: [f64; 2],
) -> [[f64; POWERS]; POWERS] {
    let mut sum = [[0.0; POWERS]; POWERS];
    let mut add = |x: f64, y: f64, weight: f64| {
        let (s, t) = ((x - start[0]) / cell[0], (y - start[1]) / cell[1]);
        let mut row = weight * kernel(x, y);
        for sum in &mut sum {
            let mut term = row;
            for sum in sum {
                *sum += term;
                term *= s;
            }
            row *= t;
        }
    };
    // cut at the singular point
    let pieces = |k: usize| {
        let end = start[k] + cell[k];
        if start[k] < 0.0 && end > 0.0 {
            vec![(start[k], -start[k]), (0.0, end)]
        } else {
            vec![(start[k], cell[k])]
        }
    };
    for (x, width) in pieces(0) {
        for (y, height) in pieces(1) {
            integrate([x, y], [width, height], 0, &mut add);
        }
    }
    sum
}

/// Levels of halving towards a singular point beside a cell.
const LEVELS: usize = 24;

/// Hands quadrature points and weights of a rectangle to `add`, dense enough for a kernel that is
/// singular at the origin, which is not inside.
fn integrate(start: [f64; 2], size: [f64; 2], level: usize, add: &mut impl FnMut(f64, f64, f64)) {
    let end = [start[0] + size[0], start[1] + size[1]];
    let nearest = [0, 1].map(|k| start[k].abs().min(end[k].abs()));
    let distance = nearest[0].hypot(nearest[1]);
    let longest = size[0].max(size[1]);
    if distance < 1e-12 * longest {
        corner(start, size, add);
    } else if distance < (1.0 - 1e-9) * longest && level < LEVELS {
        // the longer side, or both
        let halves = size.map(|s| if s > 0.6 * longest { 2u32 } else { 1 });
        let part = [0, 1].map(|k| size[k] / f64::from(halves[k]));
        for j in 0..halves[1] {
            for i in 0..halves[0] {
                let start = [
                    start[0] + f64::from(i) * part[0],
                    start[1] + f64::from(j) * part[1],
                ];
                integrate(start, part, level + 1, add);
            }
        }
    } else {
        let half = size.map(|s| 0.5 * s);
        for (v, weight_y) in GAUSS_6 {
            for (u, weight_x) in GAUSS_6 {
                let x = start[0] + half[0] * (1.0 + u);
                let y = start[1] + half[1] * (1.0 + v);
                add(x, y, weight_x * half[0] * weight_y * half[1]);
            }
        }
    }
}

/// A rectangle with the singular point at one of its corners: two triangles, each in coordinates
/// whose area element vanishes there.
fn corner(start: [f64; 2], size: [f64; 2], add: &mut impl FnMut(f64, f64, f64)) {
    let far = [0, 1].map(|k| {
        if start[k] < 0.0 {
            start[k]
        } else {
            start[k] + size[k]
        }
    });
    let area = size[0] * size[1];
    for k in 0..2 {
        // along the triangle's outer side, in panels that grow with the distance to the singular point
        let ratio = size[k] / size[1 - k];
        let mut panel = (0.0, ratio.min(1.0));
        while panel.0 < 1.0 {
            let half = 0.5 * (panel.1 - panel.0);
            for (v, weight_v) in GAUSS_6 {
                let across = panel.0 + half * (1.0 + v);
                for (u, weight_u) in GAUSS_6 {
                    let along = 0.5 * (1.0 + u);
                    let mut point = [0.0; 2];
                    point[k] = along * far[k];
                    point[1 - k] = along * across * far[1 - k];
                    let weight = 0.5 * weight_u * weight_v * half * along * area;
                    add(point[0], point[1], weight);
                }
            }
            panel = (panel.1, (2.0 * panel.1).min(1.0));
        }
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which points are near.

/// Points in square bins as wide as the functions reach.
#[derive(Clone, Debug)]
pub(super) struct Bins {
    origin: [f64; 2],
    width: f64,
    nx: usize,
    ny: usize,
    /// For every bin the points of its own and the eight bins around it.
    members: Vec<Vec<usize>>,
}

impl Bins {
    pub(super) fn new(x: &[f64], y: &[f64], reach: f64) -> Self {
        let range = |v: &[f64]| {
            v.iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &c| {
                    (a.min(c), b.max(c))
                })
        };
        let ((x0, x1), (y0, y1)) = (range(x), range(y));
        // a bin more on every side, for what lies outside the points; never many more bins than points
        let width = reach.max(((x1 - x0) * (y1 - y0) / x.len() as f64).sqrt());
        let width = width.max((x1 - x0).max(y1 - y0) / x.len() as f64);
        let origin = [x0 - width, y0 - width];
        let nx = ((x1 - x0) / width) as usize + 3;
        let ny = ((y1 - y0) / width) as usize + 3;
        let mut members = vec![Vec::new(); nx * ny];
        for j in 0..x.len() {
            let bx = ((x[j] - origin[0]) / width) as usize;
            let by = ((y[j] - origin[1]) / width) as usize;
            for cy in by.saturating_sub(1)..=(by + 1).min(ny - 1) {
                for cx in bx.saturating_sub(1)..=(bx + 1).min(nx - 1) {
                    members[cy * nx + cx].push(j);
                }
            }
        }
        Self {
            origin,
            width,
            nx,
            ny,
            members,
        }
    }

    /// Points that may lie within reach of `(x, y)`.
    pub(super) fn about(&self, x: f64, y: f64) -> &[usize] {
        let bx = (x - self.origin[0]) / self.width;
        let by = (y - self.origin[1]) / self.width;
        if bx < 0.0 || by < 0.0 || bx >= self.nx as f64 || by >= self.ny as f64 {
            return &[];
        }
        &self.members[by as usize * self.nx + bx as usize]
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Basis functions seen from afar.

use super::super::quadrature::chebyshev;

/// Interpolation points per direction for sources at a middle distance and for far ones.
const MID_ORDER: usize = 9;
const FAR_ORDER: usize = 5;
/// Half-width of the square of interpolation points, in radii of the support: the load is narrower than it.
const CLUSTER: f64 = 0.5;

/// All basis functions as sources at a distance.
pub(super) struct Moments {
    /// Integral of each function.
    pub(super) total: Vec<f64>,
    pub(super) mid: Moment,
    pub(super) far: Moment,
}

impl Moments {
    pub(super) fn new(n: usize, reach: f64) -> Self {
        Self {
            total: vec![0.0; n],
            mid: Moment::new(MID_ORDER, n, reach),
            far: Moment::new(FAR_ORDER, n, reach),
        }
    }

    /// Adds a point mass of function `j` at `(dx, dy)` from its point.
    pub(super) fn add(&mut self, dx: f64, dy: f64, j: usize, mass: f64) {
        self.total[j] += mass;
        self.mid.add(dx, dy, j, mass);
        self.far.add(dx, dy, j, mass);
    }
}

/// Mass of each basis function spread over the Chebyshev points of a square about its point, such
/// that every polynomial of that order is integrated exactly.
pub(super) struct Moment {
    order: usize,
    points: Vec<f64>,
    /// One over the product of the distances of each point to the others.
    scale: Vec<f64>,
    mass: Vec<f64>,
}

impl Moment {
    fn new(order: usize, n: usize, reach: f64) -> Self {
        let points: Vec<f64> = chebyshev(order)
            .iter()
            .map(|c| c * CLUSTER * reach)
            .collect();
        let others = |a: usize| (0..order).filter(move |&b| b != a);
        let scale = (0..order)
            .map(|a| 1.0 / others(a).map(|b| points[a] - points[b]).product::<f64>())
            .collect();
        Self {
            order,
            scale,
            points,
            mass: vec![0.0; order * order * n],
        }
    }

    /// Values of all interpolation polynomials at `s`.
    fn lagrange(&self, s: f64) -> [f64; MID_ORDER] {
        let mut values = [0.0; MID_ORDER];
        values[..self.order].copy_from_slice(&self.scale);
        // products of the distances to all points before, then to all points after
        let (mut before, mut after) = (1.0, 1.0);
        for a in 0..self.order {
            let b = self.order - 1 - a;
            values[a] *= before;
            before *= s - self.points[a];
            values[b] *= after;
            after *= s - self.points[b];
        }
        values
    }

    fn add(&mut self, dx: f64, dy: f64, j: usize, mass: f64) {
        let (lx, ly) = (self.lagrange(dx), self.lagrange(dy));
        let order = self.order;
        let block = &mut self.mass[j * order * order..(j + 1) * order * order];
        for (b, row) in block.chunks_mut(order).enumerate() {
            for (a, m) in row.iter_mut().enumerate() {
                *m += mass * lx[a] * ly[b];
            }
        }
    }

    /// The five integrals over source `j` seen from `(dx, dy)` relative to its point.
    pub(super) fn seen_from(&self, dx: f64, dy: f64, j: usize) -> [f64; 5] {
        let order = self.order;
        let block = &self.mass[j * order * order..(j + 1) * order * order];
        let mut sum = [0.0; 5];
        for (b, row) in block.chunks(order).enumerate() {
            let y = dy - self.points[b];
            for (a, m) in row.iter().enumerate() {
                let x = dx - self.points[a];
                let inverse2 = 1.0 / (x * x + y * y);
                let inverse = inverse2.sqrt();
                sum[0] += m * inverse;
                sum[1] += m * x * x * inverse2 * inverse;
                sum[2] += m * x * y * inverse2 * inverse;
                sum[3] += m * x * inverse2;
                sum[4] += m * y * inverse2;
            }
        }
        sum
    }
}

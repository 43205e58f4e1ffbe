// SPDX-License-Identifier: MIT OR Apache-2.0
//! The curved surface near a vertex: a polynomial height over its tangent plane.

use nalgebra::{DMatrix, DVector, Matrix2, SymmetricEigen, Vector3};

/// Powers of u and v of the terms, by degree; the polynomial goes through the vertex, so there is no
/// constant.
const POWERS: [(i32, i32); 9] = [
    (1, 0),
    (0, 1),
    (2, 0),
    (1, 1),
    (0, 2),
    (3, 0),
    (2, 1),
    (1, 2),
    (0, 3),
];
/// Singular values below this share of the largest carry no information (extrusions, flat strips).
const RANK: f64 = 1e-9;

/// A polynomial of a given number of terms.
#[derive(Clone, Debug)]
struct Polynomial(Vec<f64>);

impl Polynomial {
    /// Least squares through `(u, v, w)`, of the smallest norm where points do not decide.
    fn fitted(points: &[[f64; 3]], terms: usize) -> Self {
        // nearer points count more: the polynomial serves the facets at the vertex
        let weights: Vec<f64> = points
            .iter()
            .map(|p| 1.0 / (0.1 + p[0] * p[0] + p[1] * p[1]))
            .collect();
        let matrix = DMatrix::from_fn(points.len(), terms, |row, term| {
            let (i, j) = POWERS[term];
            weights[row] * points[row][0].powi(i) * points[row][1].powi(j)
        });
        let right = DVector::from_fn(points.len(), |row, _| weights[row] * points[row][2]);
        let svd = matrix.svd(true, true);
        let cut = RANK * svd.singular_values.max();
        let solution = svd.solve(&right, cut);
        Self(solution.map_or_else(|_| vec![0.0; terms], |s| s.as_slice().to_vec()))
    }

    /// Value and derivatives with respect to u and v.
    fn at(&self, u: f64, v: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (c, (i, j)) in self.0.iter().zip(POWERS) {
            sum[0] += c * u.powi(i) * v.powi(j);
            if i > 0 {
                sum[1] += c * f64::from(i) * u.powi(i - 1) * v.powi(j);
            }
            if j > 0 {
                sum[2] += c * f64::from(j) * u.powi(i) * v.powi(j - 1);
            }
        }
        sum
    }
}

/// The surface near a vertex, and a simpler one to judge it by.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    origin: Vector3<f64>,
    /// Rows: two tangents and the normal.
    axes: [Vector3<f64>; 3],
    /// Length that the tangential coordinates are divided by.
    scale: [f64; 2],
    fine: Polynomial,
    coarse: Polynomial,
    /// A quarter of the largest miss of the points [m]: the facets at the vertex are in their middle.
    miss: f64,
}

impl Fit {
    /// Points around a vertex that are enough for a cubic with some to spare.
    pub(super) const WANTED: usize = 14;
    /// The same for a quadratic.
    const WANTED_QUADRATIC: usize = 6;

    /// `points` relative to `origin`.
    pub(super) fn new(origin: Vector3<f64>, normal: Vector3<f64>, points: &[Vector3<f64>]) -> Self {
        let axes = frame(normal, points);
        let coordinate = |p: &Vector3<f64>| [axes[0].dot(p), axes[1].dot(p), axes[2].dot(p)];
        let mut scale = [0.0_f64; 2];
        for p in points {
            let c = coordinate(p);
            scale = [scale[0].max(c[0].abs()), scale[1].max(c[1].abs())];
        }
        let largest = scale[0].max(scale[1]);
        scale = scale.map(|s| s.max(1e-6 * largest));
        let local: Vec<[f64; 3]> = points
            .iter()
            .map(|p| {
                let c = coordinate(p);
                [c[0] / scale[0], c[1] / scale[1], c[2]]
            })
            .collect();
        let terms = match local.len() {
            n if n >= Self::WANTED => [9, 5],
            n if n >= Self::WANTED_QUADRATIC => [5, 2],
            _ => [2, 2],
        };
        let [fine, coarse] = terms.map(|terms| Polynomial::fitted(&local, terms));
        let miss = local
            .iter()
            .map(|p| (fine.at(p[0], p[1])[0] - p[2]).abs())
            .fold(0.0, f64::max)
            / 4.0;
        Self {
            origin,
            axes,
            scale,
            fine,
            coarse,
            miss,
        }
    }

    /// Height of `point` over the surface, its gradient, and the estimated error of the height.
    pub(super) fn above(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>, f64) {
        let d = point - self.origin;
        let (u, v) = (
            self.axes[0].dot(&d) / self.scale[0],
            self.axes[1].dot(&d) / self.scale[1],
        );
        let [w, wu, wv] = self.fine.at(u, v);
        let gradient = self.axes[2]
            - self.axes[0] * (wu / self.scale[0])
            - self.axes[1] * (wv / self.scale[1]);
        let error = self.miss + (w - self.coarse.at(u, v)[0]).abs();
        (self.axes[2].dot(&d) - w, gradient, error)
    }
}

/// Orthonormal axes, the third along `normal`, the first where `points` spread most.
fn frame(normal: Vector3<f64>, points: &[Vector3<f64>]) -> [Vector3<f64>; 3] {
    let least = normal.iamin();
    let first = Vector3::ith(least, 1.0).cross(&normal).normalize();
    let second = normal.cross(&first);
    let mut spread = Matrix2::zeros();
    for p in points {
        let c = nalgebra::Vector2::new(first.dot(p), second.dot(p));
        spread += c * c.transpose();
    }
    let eigen = SymmetricEigen::new(spread);
    let along = eigen.eigenvectors.column(eigen.eigenvalues.imax());
    let axis = first * along[0] + second * along[1];
    [axis, normal.cross(&axis), normal]
}

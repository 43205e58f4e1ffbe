// SPDX-License-Identifier: MIT OR Apache-2.0
use std::collections::HashMap;

use nalgebra::Vector3;

use super::mesh::TetraMesh;
use crate::Error;

/// The nearest place on a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    pub(super) face: usize,
    pub(super) barycentric: [f64; 3],
    pub(super) position: [f64; 3],
}

/// Finds the nearest of some boundary triangles of a mesh, taken flat between their corners.
pub(super) struct FaceFinder<'a> {
    mesh: &'a TetraMesh,
    bin: f64,
    reach: f64,
    bins: HashMap<[i64; 3], Vec<usize>>,
}

impl<'a> FaceFinder<'a> {
    /// Finder among `faces`, for places not farther than `reach` [m] from them.
    pub(super) fn new(mesh: &'a TetraMesh, faces: &[usize], reach: f64) -> Result<Self, Error> {
        let bin = 4.0 * reach;
        let mut bins: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
        for &face in faces {
            if face >= mesh.n_faces() {
                return Err(Error::NotOnBoundary(face));
            }
            let corners = &mesh.face(face)[..3];
            let range = |c: usize| {
                let x = corners.iter().map(|&a| mesh.nodes()[a][c]);
                let low = x.clone().fold(f64::INFINITY, f64::min) - reach;
                let high = x.fold(f64::NEG_INFINITY, f64::max) + reach;
                (low / bin).floor() as i64..=(high / bin).floor() as i64
            };
            for i in range(0) {
                for j in range(1) {
                    for k in range(2) {
                        bins.entry([i, j, k]).or_default().push(face);
                    }
                }
            }
        }
        Ok(FaceFinder {
            mesh,
            bin,
            reach,
            bins,
        })
    }

    /// The nearest place within reach.
    pub(super) fn nearest(&self, x: [f64; 3]) -> Option<Hit> {
        let key = x.map(|c| (c / self.bin).floor() as i64);
        let p = Vector3::from(x);
        let mut best: Option<(f64, Hit)> = None;
        for &face in self.bins.get(&key)? {
            let corners = self.mesh.face(face);
            let [a, b, c] = [0, 1, 2].map(|i| Vector3::from(self.mesh.nodes()[corners[i]]));
            let barycentric = closest(p, a, b, c);
            let position = a * barycentric[0] + b * barycentric[1] + c * barycentric[2];
            let distance = (position - p).norm();
            if distance <= self.reach && best.is_none_or(|(d, _)| distance < d) {
                let position = position.into();
                best = Some((
                    distance,
                    Hit {
                        face,
                        barycentric,
                        position,
                    },
                ));
            }
        }
        best.map(|(_, hit)| hit)
    }
}

/// Finds what some boundary triangles of a mesh show to one who looks into the body.
pub(super) struct FaceView<'a> {
    mesh: &'a TetraMesh,
    axes: [Vector3<f64>; 3],
    bin: f64,
    bins: HashMap<[i64; 2], Vec<usize>>,
}

/// Cosine between a triangle's normal and the view below which it is a wall, seen edge on.
const WALL: f64 = 1e-3;

impl<'a> FaceView<'a> {
    /// View of `faces` along the third of the `axes`, which points into the body; `bin` [m] is about the
    /// size of what is looked for.
    pub(super) fn new(
        mesh: &'a TetraMesh,
        faces: &[usize],
        axes: [[f64; 3]; 3],
        bin: f64,
    ) -> Result<Self, Error> {
        let mut view = FaceView {
            mesh,
            axes: axes.map(Vector3::from),
            bin,
            bins: HashMap::new(),
        };
        for &face in faces {
            if face >= mesh.n_faces() {
                return Err(Error::NotOnBoundary(face));
            }
            let [a, b, c] = view.corners(face);
            let normal = (b - a).cross(&(c - a));
            if -normal.dot(&view.axes[2]) < WALL * normal.norm() {
                continue;
            }
            let range = |axis: &Vector3<f64>| {
                let x = [a, b, c].map(|p| p.dot(axis));
                let low = x.iter().copied().fold(f64::INFINITY, f64::min);
                let high = x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                (low / bin).floor() as i64..=(high / bin).floor() as i64
            };
            for i in range(&view.axes[0]) {
                for j in range(&view.axes[1]) {
                    view.bins.entry([i, j]).or_default().push(face);
                }
            }
        }
        Ok(view)
    }

    fn corners(&self, face: usize) -> [Vector3<f64>; 3] {
        let corners = self.mesh.face(face);
        [0, 1, 2].map(|i| Vector3::from(self.mesh.nodes()[corners[i]]))
    }

    /// The first place on the line through `x` along the view.
    pub(super) fn through(&self, x: [f64; 3]) -> Option<Hit> {
        let p = Vector3::from(x);
        let key = [0, 1].map(|k| (p.dot(&self.axes[k]) / self.bin).floor() as i64);
        let mut best: Option<(f64, Hit)> = None;
        for &face in self.bins.get(&key)? {
            let [a, b, c] = self.corners(face);
            let [u, v, w] = [b - a, c - a, p - a].map(|e| [0, 1].map(|k| e.dot(&self.axes[k])));
            let double = u[0] * v[1] - u[1] * v[0];
            let second = (w[0] * v[1] - w[1] * v[0]) / double;
            let third = (u[0] * w[1] - u[1] * w[0]) / double;
            let barycentric = [1.0 - second - third, second, third];
            // a point on an edge must not fall between two triangles
            if barycentric.iter().any(|l| *l < -1e-9) {
                continue;
            }
            let position = a * barycentric[0] + b * barycentric[1] + c * barycentric[2];
            let depth = (position - p).dot(&self.axes[2]);
            if best.is_none_or(|(d, _)| depth < d) {
                let position = position.into();
                best = Some((
                    depth,
                    Hit {
                        face,
                        barycentric,
                        position,
                    },
                ));
            }
        }
        best.map(|(_, hit)| hit)
    }
}

/// Barycentric coordinates of the point of a triangle nearest to `p` [Ericson2005, 5.1.5].
fn closest(p: Vector3<f64>, a: Vector3<f64>, b: Vector3<f64>, c: Vector3<f64>) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}

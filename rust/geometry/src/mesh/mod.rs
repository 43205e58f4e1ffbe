// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies given by triangles, with the curved surface behind the facets.

mod cast;
mod fit;
mod topology;

use std::sync::OnceLock;

use nalgebra::Vector3;
use parry3d_f64::math::Vector;
use parry3d_f64::shape::TriMesh;

use crate::Error;
use crate::error::all_finite;
use fit::Fit;
use topology::Topology;

/// parry works in millimetres: its tolerances are absolute.
const MILLIMETRES: f64 = 1e3;
/// Facets that meet at a larger angle meet at an edge of the body, smaller angles are a curved surface.
const CREASE: f64 = 30.0 * std::f64::consts::PI / 180.0;
/// Smallest accepted ratio of area to longest edge squared.
const THINNEST: f64 = 1e-7;
/// Extents beyond which a length unit must be wrong [m].
const SIZES: std::ops::RangeInclusive<f64> = 1e-5..=20.0;

/// Whether triangles must close a volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closure {
    /// A body: every edge belongs to two triangles, which point outwards.
    Closed,
    /// A piece of a surface.
    Open,
}

/// A triangulated surface.
///
/// Between its vertices the surface is curved: near each vertex a cubic through it is fitted to the
/// vertices around, and blended over the facets. Edges sharper than 30 degrees stay edges. The
/// distance to a smooth body sampled every h is so found to O(h^4) instead of the facets' own O(h^2).
///
/// # Example
/// ```
/// use mtb_geometry::{Closure, Surface, SurfaceMesh};
/// let corners = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]];
/// let faces = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
/// let body = SurfaceMesh::new(corners.to_vec(), faces, Closure::Closed).unwrap();
/// let hit = body.cast([0.01, 0.02, -0.005], [0.0, 0.0, 1.0], 0.05).unwrap();
/// assert!((hit.distance - 0.005).abs() < 1e-15);
/// ```
pub struct SurfaceMesh {
    vertices: Vec<Vector3<f64>>,
    triangles: Vec<[usize; 3]>,
    /// Unit normals of the facets.
    normals: Vec<Vector3<f64>>,
    topology: Topology,
    fits: Vec<OnceLock<Fit>>,
    tree: TriMesh,
    size: f64,
}

impl SurfaceMesh {
    /// A surface of triangles, counter-clockwise seen from outside.
    ///
    /// # Errors
    /// Vertices not finite, indices out of range, degenerate triangles, triangles that contradict
    /// each other's orientation; for closed surfaces also open edges and a negative volume; sizes
    /// that can only mean a wrong unit.
    pub fn new(
        vertices: Vec<[f64; 3]>,
        triangles: Vec<[usize; 3]>,
        closure: Closure,
    ) -> Result<Self, Error> {
        let flat: Vec<f64> = vertices.iter().flatten().copied().collect();
        all_finite("vertices", &flat)?;
        if triangles.is_empty() {
            return Err(Error::Length {
                name: "triangles",
                found: 0,
                accepted: "at least one is needed".into(),
            });
        }
        let vertices: Vec<Vector3<f64>> = vertices.into_iter().map(Vector3::from).collect();
        let mut normals = Vec::with_capacity(triangles.len());
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&v| v >= vertices.len()) {
                return Err(Error::MissingVertex {
                    triangle,
                    vertex,
                    count: vertices.len(),
                });
            }
            let [a, b, c] = corners.map(|v| vertices[v]);
            let cross = (b - a).cross(&(c - a));
            let longest = (b - a)
                .norm_squared()
                .max((c - b).norm_squared())
                .max((a - c).norm_squared());
            let area = 0.5 * cross.norm();
            // written so that zero over zero is caught
            if area.is_nan() || area <= THINNEST * longest {
                return Err(Error::DegenerateTriangle { triangle, area });
            }
            normals.push(cross / (2.0 * area));
        }
        let extent = |i: usize| {
            let used = triangles.iter().flatten().map(|&v| vertices[v][i]);
            let (low, high) = used.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (l.min(v), h.max(v))
            });
            high - low
        };
        let size = extent(0).max(extent(1)).max(extent(2));
        if !SIZES.contains(&size) {
            return Err(Error::ImplausibleSize { size });
        }
        let topology = Topology::new(&triangles, &normals, CREASE, closure)?;
        if closure == Closure::Closed {
            let volume: f64 = triangles
                .iter()
                .map(|t| {
                    let [a, b, c] = t.map(|v| vertices[v]);
                    a.cross(&b).dot(&c) / 6.0
                })
                .sum();
            if volume < 0.0 {
                return Err(Error::InsideOut { volume });
            }
        }
        let points = vertices
            .iter()
            .map(|v| Vector::new(v.x, v.y, v.z) * MILLIMETRES)
            .collect();
        let faces = triangles.iter().map(|t| t.map(|v| v as u32)).collect();
        let tree = TriMesh::new(points, faces).map_err(|error| Error::Tree {
            reason: error.to_string(),
        })?;
        Ok(Self {
            fits: (0..topology.fans()).map(|_| OnceLock::new()).collect(),
            vertices,
            triangles,
            normals,
            topology,
            tree,
            size,
        })
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether there are none; never, since empty meshes are refused.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Cubic behind the facets near a corner of a triangle, fitted when first asked for.
    fn fit(&self, triangle: usize, corner: usize) -> &Fit {
        let fan = self.topology.fan(triangle, corner);
        self.fits[fan].get_or_init(|| {
            let vertex = self.triangles[triangle][corner];
            let around = self
                .topology
                .vertices_around(&self.triangles, fan, Fit::WANTED);
            let mut normal = Vector3::zeros();
            for &(t, corner) in self.topology.corners(fan) {
                let at = |k: usize| self.vertices[self.triangles[t][(corner + k) % 3]];
                normal += self.normals[t] * (at(1) - at(0)).angle(&(at(2) - at(0)));
            }
            let points: Vec<Vector3<f64>> = around
                .iter()
                .filter(|&&v| v != vertex)
                .map(|&v| self.vertices[v] - self.vertices[vertex])
                .collect();
            Fit::new(self.vertices[vertex], normal.normalize(), &points)
        })
    }
}

#[cfg(test)]
mod tests;

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which triangles continue each other smoothly.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::Closure;
use crate::Error;

/// Triangles around a vertex that belong to one smooth sheet form a fan.
pub(super) struct Topology {
    fan_of_corner: Vec<[usize; 3]>,
    /// Corners `(triangle, corner)` of each fan.
    corners: Vec<Vec<(usize, usize)>>,
}

impl Topology {
    pub(super) fn new(
        triangles: &[[usize; 3]],
        normals: &[Vector3<f64>],
        crease: f64,
        closure: Closure,
    ) -> Result<Self, Error> {
        // half-edge from vertex to vertex -> triangle
        let mut edges: HashMap<(usize, usize), usize> = HashMap::new();
        for (triangle, t) in triangles.iter().enumerate() {
            for k in 0..3 {
                let edge = (t[k], t[(k + 1) % 3]);
                if edges.insert(edge, triangle).is_some() {
                    return Err(Error::Contradicting {
                        from: edge.0,
                        to: edge.1,
                    });
                }
            }
        }
        if closure == Closure::Closed {
            let open = edges
                .keys()
                .filter(|(a, b)| !edges.contains_key(&(*b, *a)))
                .count();
            if open > 0 {
                return Err(Error::NotWatertight { open });
            }
        }
        let smooth =
            |triangle: usize, other: usize| normals[triangle].dot(&normals[other]) > crease.cos();
        // corners of the same vertex in triangles that share a smooth edge there join
        let mut parent: Vec<usize> = (0..3 * triangles.len()).collect();
        for (triangle, t) in triangles.iter().enumerate() {
            for k in 0..3 {
                let (from, to) = (t[k], t[(k + 1) % 3]);
                let Some(&other) = edges.get(&(to, from)) else {
                    continue;
                };
                if !smooth(triangle, other) {
                    continue;
                }
                for (vertex, corner) in [(from, k), (to, (k + 1) % 3)] {
                    if let Some(c) = triangles[other].iter().position(|&v| v == vertex) {
                        let (a, b) = (
                            root(&mut parent, 3 * triangle + corner),
                            root(&mut parent, 3 * other + c),
                        );
                        parent[a.max(b)] = a.min(b);
                    }
                }
            }
        }
        let mut fan_of_corner = vec![[0; 3]; triangles.len()];
        let mut corners: Vec<Vec<(usize, usize)>> = Vec::new();
        let mut fan_of_root = HashMap::new();
        for triangle in 0..triangles.len() {
            for corner in 0..3 {
                let root = root(&mut parent, 3 * triangle + corner);
                let fan = *fan_of_root.entry(root).or_insert_with(|| {
                    corners.push(Vec::new());
                    corners.len() - 1
                });
                corners[fan].push((triangle, corner));
                fan_of_corner[triangle][corner] = fan;
            }
        }
        Ok(Self {
            fan_of_corner,
            corners,
        })
    }

    pub(super) fn fans(&self) -> usize {
        self.corners.len()
    }

    pub(super) fn fan(&self, triangle: usize, corner: usize) -> usize {
        self.fan_of_corner[triangle][corner]
    }

    pub(super) fn corners(&self, fan: usize) -> &[(usize, usize)] {
        &self.corners[fan]
    }

    /// Vertices of the sheet around a fan, ring by ring (two at least, four at most) until there are
    /// `wanted`.
    pub(super) fn vertices_around(
        &self,
        triangles: &[[usize; 3]],
        fan: usize,
        wanted: usize,
    ) -> Vec<usize> {
        let mut fans = vec![fan];
        let mut vertices = Vec::new();
        for ring in 0..4 {
            if ring >= 2 && vertices.len() > wanted {
                break;
            }
            let mut around: Vec<usize> = fans
                .iter()
                .flat_map(|&f| &self.corners[f])
                .map(|c| c.0)
                .collect();
            around.sort_unstable();
            around.dedup();
            fans = around.iter().flat_map(|&t| self.fan_of_corner[t]).collect();
            fans.sort_unstable();
            fans.dedup();
            vertices = around.iter().flat_map(|&t| triangles[t]).collect();
            vertices.sort_unstable();
            vertices.dedup();
        }
        vertices
    }
}

/// Representative of a set of joined corners.
fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use std::collections::HashMap;

use super::element::{LINEAR, QUADRATIC, jacobian_range};
use crate::Error;

/// Polynomial order of the displacement in a tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Order {
    /// 4 nodes.
    Linear,
    /// 10 nodes: corners 0..4, then the middles of edges 01, 12, 02, 03, 13, 23.
    Quadratic,
}

impl Order {
    /// Nodes per tetrahedron.
    pub fn nodes_per_tet(self) -> usize {
        match self {
            Order::Linear => LINEAR,
            Order::Quadratic => QUADRATIC,
        }
    }

    /// Nodes per face.
    pub fn nodes_per_face(self) -> usize {
        match self {
            Order::Linear => 3,
            Order::Quadratic => 6,
        }
    }
}

/// Ends of the edges that carry the mid-side nodes 4..10.
pub(super) const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// Corners of the faces, counter-clockwise seen from outside, each followed by the mid-side nodes of
/// its edges 01, 12, 20.
const FACES: [[usize; 6]; 4] = [
    [0, 2, 1, 6, 5, 4],
    [0, 1, 3, 4, 8, 7],
    [1, 2, 3, 5, 9, 8],
    [0, 3, 2, 7, 9, 6],
];

/// Smallest quality of a tetrahedron that is accepted: a flat cell of aspect ratio 1000 has 1e-3.
const SLIVER: f64 = 1e-4;

/// A checked mesh of tetrahedra in metres: no cell inverted or flat, no node loose, one piece.
#[derive(Clone, Debug)]
pub struct TetraMesh {
    nodes: Vec<[f64; 3]>,
    cells: Vec<usize>,
    order: Order,
    faces: Vec<usize>,
}

impl TetraMesh {
    /// Mesh from `nodes` [m] and `cells`, node numbers of one tetrahedron after the other.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`], [`Error::Index`] on malformed arrays,
    /// [`Error::Inverted`], [`Error::Sliver`], [`Error::LooseNode`], [`Error::Pieces`] on bad meshes.
    pub fn new(nodes: Vec<[f64; 3]>, cells: Vec<usize>, order: Order) -> Result<Self, Error> {
        let per_tet = order.nodes_per_tet();
        if cells.is_empty() || !cells.len().is_multiple_of(per_tet) {
            return Err(Error::Shape {
                name: "cells",
                found: cells.len(),
                expected: per_tet * (cells.len() / per_tet).max(1),
            });
        }
        if let Some(index) = nodes.iter().position(|x| x.iter().any(|c| !c.is_finite())) {
            return Err(Error::NotFinite {
                name: "node",
                index,
            });
        }
        if let Some(index) = cells.iter().position(|&a| a >= nodes.len()) {
            return Err(Error::Index {
                name: "tetrahedron",
                index: index / per_tet,
                what: "node",
                value: cells[index],
                count: nodes.len(),
            });
        }
        let mut used = vec![false; nodes.len()];
        for &a in &cells {
            used[a] = true;
        }
        if let Some(loose) = used.iter().position(|u| !u) {
            return Err(Error::LooseNode(loose));
        }
        for (tet, cell) in cells.chunks_exact(per_tet).enumerate() {
            check_shape(tet, cell, &nodes)?;
        }
        let pieces = count_pieces(nodes.len(), &cells, per_tet);
        if pieces > 1 {
            return Err(Error::Pieces(pieces));
        }
        let faces = boundary(&cells, order);
        Ok(TetraMesh {
            nodes,
            cells,
            order,
            faces,
        })
    }

    /// Node coordinates [m].
    pub fn nodes(&self) -> &[[f64; 3]] {
        &self.nodes
    }

    /// Polynomial order.
    pub fn order(&self) -> Order {
        self.order
    }

    /// Number of tetrahedra.
    pub fn n_tets(&self) -> usize {
        self.cells.len() / self.order.nodes_per_tet()
    }

    /// Nodes of one tetrahedron.
    pub fn cell(&self, tet: usize) -> &[usize] {
        let n = self.order.nodes_per_tet();
        &self.cells[tet * n..(tet + 1) * n]
    }

    /// Nodes of all tetrahedra, one after the other.
    pub fn cells(&self) -> &[usize] {
        &self.cells
    }

    /// Number of triangles of the boundary.
    pub fn n_faces(&self) -> usize {
        self.faces.len() / self.order.nodes_per_face()
    }

    /// Nodes of one triangle of the boundary, corners first and counter-clockwise seen from outside.
    pub fn face(&self, face: usize) -> &[usize] {
        let n = self.order.nodes_per_face();
        &self.faces[face * n..(face + 1) * n]
    }

    /// Nodes of all boundary triangles, one after the other.
    pub fn faces(&self) -> &[usize] {
        &self.faces
    }

    /// Largest extent along an axis [m].
    pub fn size(&self) -> f64 {
        (0..3)
            .map(|c| {
                let (low, high) = self
                    .nodes
                    .iter()
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
                        (l.min(x[c]), h.max(x[c]))
                    });
                high - low
            })
            .fold(0.0, f64::max)
    }
}

fn check_shape(tet: usize, cell: &[usize], nodes: &[[f64; 3]]) -> Result<(), Error> {
    let (least, mean) = jacobian_range(cell, nodes);
    if least <= 0.0 {
        return Err(Error::Inverted {
            tet,
            volume: least / 6.0,
        });
    }
    let square: f64 = EDGES
        .iter()
        .map(|[i, j]| {
            let (a, b) = (nodes[cell[*i]], nodes[cell[*j]]);
            (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>()
        })
        .sum();
    let edge = (square / 6.0).sqrt();
    // a regular tetrahedron of edge a has the volume a^3 / (6 sqrt 2), six of which are its Jacobian
    let quality = least.min(mean) * 2f64.sqrt() / edge.powi(3);
    if quality < SLIVER {
        return Err(Error::Sliver {
            tet,
            quality,
            limit: SLIVER,
        });
    }
    Ok(())
}

fn count_pieces(n_nodes: usize, cells: &[usize], per_tet: usize) -> usize {
    let mut parent: Vec<usize> = (0..n_nodes).collect();
    let mut pieces = n_nodes;
    for cell in cells.chunks_exact(per_tet) {
        for &a in &cell[1..] {
            let (i, j) = (root(&mut parent, cell[0]), root(&mut parent, a));
            if i != j {
                parent[i] = j;
                pieces -= 1;
            }
        }
    }
    pieces
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

/// The faces that belong to one tetrahedron only.
fn boundary(cells: &[usize], order: Order) -> Vec<usize> {
    let (per_tet, per_face) = (order.nodes_per_tet(), order.nodes_per_face());
    let key = |cell: &[usize], face: &[usize; 6]| {
        let mut corners = [cell[face[0]], cell[face[1]], cell[face[2]]];
        corners.sort_unstable();
        corners
    };
    let mut count: HashMap<[usize; 3], u32> = HashMap::with_capacity(cells.len() / per_tet * 3);
    for cell in cells.chunks_exact(per_tet) {
        for face in &FACES {
            *count.entry(key(cell, face)).or_insert(0) += 1;
        }
    }
    let mut faces = Vec::new();
    for cell in cells.chunks_exact(per_tet) {
        for face in &FACES {
            if count.get(&key(cell, face)) == Some(&1) {
                faces.extend(face[..per_face].iter().map(|&i| cell[i]));
            }
        }
    }
    faces
}

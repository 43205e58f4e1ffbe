// SPDX-License-Identifier: MIT OR Apache-2.0
use std::collections::{BTreeMap, BTreeSet};

use super::{EDGES, SolidMesh};
use crate::Error;

/// Corners of the faces of a tetrahedron.
const FACES: [[usize; 3]; 4] = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];

impl SolidMesh {
    /// Tetrahedra of four nodes with nodes in the middle of their straight edges, numbered behind the others.
    ///
    /// A set of nodes gets those between two of its own, on the boundary or in a tetrahedron that is all in
    /// it.
    ///
    /// # Errors
    /// [`Error::Length`] unless the tetrahedra have four nodes, [`Error::MissingNode`].
    pub fn quadratic(&self) -> Result<Self, Error> {
        if self.nodes_per_cell != 4 || !self.cells.len().is_multiple_of(4) {
            return Err(Error::Length {
                name: "cells",
                found: self.nodes_per_cell,
                accepted: "tetrahedra of four nodes are needed".to_owned(),
            });
        }
        let n = self.nodes.len();
        let numbers = self.sets.iter().flat_map(|(_, nodes)| nodes);
        if let Some(&node) = self.cells.iter().chain(numbers).find(|node| **node >= n) {
            return Err(Error::MissingNode { node, count: n });
        }
        let mut edges: Vec<[usize; 2]> = self
            .cells
            .chunks_exact(4)
            .flat_map(|cell| EDGES.map(|[a, b]| pair(cell[a], cell[b])))
            .collect();
        edges.sort_unstable();
        edges.dedup();
        // every edge was put there
        let number = |edge: [usize; 2]| edges.partition_point(|e| *e < edge);
        let mut sides: BTreeMap<[usize; 3], bool> = BTreeMap::new();
        for cell in self.cells.chunks_exact(4) {
            for face in FACES {
                let mut corners = face.map(|k| cell[k]);
                corners.sort_unstable();
                let once = !sides.contains_key(&corners);
                sides.insert(corners, once);
            }
        }
        let outside: BTreeSet<[usize; 2]> = sides
            .iter()
            .filter(|(_, once)| **once)
            .flat_map(|([a, b, c], _)| [[*a, *b], [*a, *c], [*b, *c]])
            .collect();
        let is_outside: Vec<bool> = edges.iter().map(|e| outside.contains(e)).collect();

        let mut nodes = self.nodes.clone();
        nodes.extend(edges.iter().map(|[a, b]| -> [f64; 3] {
            std::array::from_fn(|c| 0.5 * (self.nodes[*a][c] + self.nodes[*b][c]))
        }));
        let mut cells = Vec::with_capacity(self.cells.len() / 4 * 10);
        for cell in self.cells.chunks_exact(4) {
            cells.extend(cell);
            cells.extend(EDGES.map(|[a, b]| n + number(pair(cell[a], cell[b]))));
        }
        let sets = self.sets.iter().map(|(name, own)| {
            let mut inside = vec![false; n];
            for node in own {
                inside[*node] = true;
            }
            let mut is_solid = vec![false; edges.len()];
            for cell in cells.chunks_exact(10) {
                if cell[..4].iter().all(|node| inside[*node]) {
                    for edge in &cell[4..] {
                        is_solid[edge - n] = true;
                    }
                }
            }
            let between = edges
                .iter()
                .enumerate()
                .filter(|(k, [a, b])| inside[*a] && inside[*b] && (is_outside[*k] || is_solid[*k]));
            let mut all = own.clone();
            all.extend(between.map(|(k, _)| n + k));
            (name.clone(), all)
        });
        let sets = sets.collect();
        Ok(Self {
            nodes,
            cells,
            nodes_per_cell: 10,
            sets,
        })
    }
}

fn pair(a: usize, b: usize) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

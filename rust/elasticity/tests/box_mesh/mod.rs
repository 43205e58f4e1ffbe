// SPDX-License-Identifier: MIT OR Apache-2.0
//! Boxes of tetrahedra for tests and benches.

use std::collections::HashMap;

use mtb_elasticity::tetra::{ContactGrid, Order, Sampling, TetraMesh};

/// `n + 1` places from `a` to `b`, equally far apart.
pub(crate) fn even(a: f64, b: f64, n: usize) -> Vec<f64> {
    (0..=n).map(|i| a + (b - a) * i as f64 / n as f64).collect()
}

/// Nodes and cells of a box cut at the given coordinates, six tetrahedra per cell; nodes of the
/// corners run x fastest, then y, then z.
pub(crate) fn box_arrays(
    x: &[f64],
    y: &[f64],
    z: &[f64],
    order: Order,
) -> (Vec<[f64; 3]>, Vec<usize>) {
    let (nx, ny) = (x.len(), y.len());
    let mut nodes: Vec<[f64; 3]> = Vec::new();
    for &z in z {
        for &y in y {
            nodes.extend(x.iter().map(|&x| [x, y, z]));
        }
    }
    let at = |i: usize, j: usize, k: usize| i + nx * (j + ny * k);
    let mut cells = Vec::new();
    let mut middles: HashMap<(usize, usize), usize> = HashMap::new();
    for k in 0..z.len() - 1 {
        for j in 0..ny - 1 {
            for i in 0..nx - 1 {
                for (p, q, even) in [
                    (0, 1, true),
                    (1, 2, true),
                    (2, 0, true),
                    (1, 0, false),
                    (2, 1, false),
                    (0, 2, false),
                ] {
                    let mut step = [[i, j, k]; 4];
                    step[1][p] += 1;
                    step[2][p] += 1;
                    step[2][q] += 1;
                    step[3] = [i + 1, j + 1, k + 1];
                    let mut tet = step.map(|[i, j, k]| at(i, j, k));
                    if !even {
                        tet.swap(1, 2);
                    }
                    cells.extend(tet);
                    if order == Order::Linear {
                        continue;
                    }
                    for [a, b] in [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]] {
                        let (a, b) = (tet[a].min(tet[b]), tet[a].max(tet[b]));
                        let middle = *middles.entry((a, b)).or_insert_with(|| {
                            let (p, q) = (nodes[a], nodes[b]);
                            nodes.push([0, 1, 2].map(|c| 0.5 * (p[c] + q[c])));
                            nodes.len() - 1
                        });
                        cells.push(middle);
                    }
                }
            }
        }
    }
    (nodes, cells)
}

/// The box as a mesh.
pub(crate) fn box_mesh(x: &[f64], y: &[f64], z: &[f64], order: Order) -> TetraMesh {
    let (nodes, cells) = box_arrays(x, y, z, order);
    TetraMesh::new(nodes, cells, order).expect("boxes are good meshes")
}

/// Boundary faces all of whose corners satisfy a condition.
pub(crate) fn faces_where(mesh: &TetraMesh, inside: impl Fn([f64; 3]) -> bool) -> Vec<usize> {
    (0..mesh.n_faces())
        .filter(|&f| mesh.face(f)[..3].iter().all(|&a| inside(mesh.nodes()[a])))
        .collect()
}

/// Nodes that satisfy a condition.
pub(crate) fn nodes_where(mesh: &TetraMesh, inside: impl Fn([f64; 3]) -> bool) -> Vec<usize> {
    (0..mesh.nodes().len())
        .filter(|&a| inside(mesh.nodes()[a]))
        .collect()
}

/// Contact points on the face z = 0 at all crossings of two lines of places.
pub(crate) fn grid_on_bottom(mesh: &TetraMesh, x: &[f64], y: &[f64]) -> Sampling {
    let grid = ContactGrid {
        nx: x.len(),
        ny: y.len(),
        spacing: [x[1] - x[0], y[1] - y[0]],
        points: y
            .iter()
            .flat_map(|&y| x.iter().map(move |&x| [x, y, 0.0]))
            .collect(),
        frames: vec![[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]; x.len() * y.len()],
    };
    grid.sampling(mesh, &faces_where(mesh, |x| x[2] < 1e-9))
        .unwrap()
}

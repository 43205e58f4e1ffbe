// SPDX-License-Identifier: MIT OR Apache-2.0
use rayon::prelude::*;

use super::element;
use super::mesh::{EDGES, TetraMesh};
use crate::Material;

/// Stress (xx, yy, zz, yz, xz, xy) [Pa] at the nodes, component by component, `6 N`: the mean of the
/// values of the tetrahedra around each node, weighted by nothing.
pub(super) fn at_nodes(mesh: &TetraMesh, material: Material, displacement: &[f64]) -> Vec<f64> {
    let n = mesh.nodes().len();
    let per_tet: Vec<Vec<[f64; 6]>> = (0..mesh.n_tets())
        .into_par_iter()
        .map(|tet| {
            let cell = mesh.cell(tet);
            (0..cell.len())
                .map(|a| {
                    let mut l = [0.0; 4];
                    if a < 4 {
                        l[a] = 1.0;
                    } else {
                        let [i, j] = EDGES[a - 4];
                        (l[i], l[j]) = (0.5, 0.5);
                    }
                    element::stress(l, cell, mesh.nodes(), material, |node| {
                        [0, 1, 2].map(|c| displacement[c * n + node])
                    })
                })
                .collect()
        })
        .collect();
    let mut sum = vec![0.0; 6 * n];
    let mut count = vec![0.0; n];
    for (tet, values) in per_tet.iter().enumerate() {
        for (&node, value) in mesh.cell(tet).iter().zip(values) {
            count[node] += 1.0;
            for c in 0..6 {
                sum[c * n + node] += value[c];
            }
        }
    }
    for c in 0..6 {
        for node in 0..n {
            sum[c * n + node] /= count[node];
        }
    }
    sum
}

/// Von Mises' equivalent stress [Pa] of stresses laid out as by [`at_nodes`].
pub(super) fn von_mises(stress: &[f64]) -> Vec<f64> {
    let n = stress.len() / 6;
    (0..n)
        .map(|i| {
            let [xx, yy, zz, yz, xz, xy] = [0, 1, 2, 3, 4, 5].map(|c| stress[c * n + i]);
            let normal = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
            (0.5 * normal + 3.0 * (yz * yz + xz * xz + xy * xy)).sqrt()
        })
        .collect()
}

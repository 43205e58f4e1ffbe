// SPDX-License-Identifier: MIT OR Apache-2.0
//! Loads spread over a body, and what its supports exert on it, as linear maps of the loads.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::body::TetraBody;
use super::element;
use super::factor::SparseColumn;
use super::mesh::{Order, TetraMesh};
use super::support::{Source, Unknowns};

/// Force along and moment about x, y and z, of or on a body.
pub(super) const WRENCH: usize = 6;

/// Force and moment about the origin of a unit force at `x` along `component`.
pub(super) fn lever(x: [f64; 3], component: usize) -> [f64; WRENCH] {
    let mut wrench = [0.0; WRENCH];
    wrench[component] = 1.0;
    let (next, last) = ((component + 1) % 3, (component + 2) % 3);
    // x cross e_component
    wrench[3 + next] = x[last];
    wrench[3 + last] = -x[next];
    wrench
}

/// Volume that belongs to each node: its shape function's integral over straight tetrahedra.
fn node_volumes(mesh: &TetraMesh) -> Vec<f64> {
    let mut volumes = vec![0.0; mesh.nodes().len()];
    for tet in 0..mesh.n_tets() {
        let cell = mesh.cell(tet);
        let corner: [Vector3<f64>; 4] =
            std::array::from_fn(|k| Vector3::from(mesh.nodes()[cell[k]]));
        let [a, b, c] = [1, 2, 3].map(|k| corner[k] - corner[0]);
        let volume = a.cross(&b).dot(&c) / 6.0;
        for (k, &node) in cell.iter().enumerate() {
            volumes[node] += volume
                * match mesh.order() {
                    Order::Linear => 0.25,
                    Order::Quadratic if k < 4 => -0.05,
                    Order::Quadratic => 0.2,
                };
        }
    }
    volumes
}

impl TetraBody {
    /// Centre of volume [m].
    pub fn centre(&self) -> [f64; 3] {
        let mut sum = Vector3::zeros();
        let mut total = 0.0;
        for (&x, volume) in self.mesh.nodes().iter().zip(node_volumes(&self.mesh)) {
            sum += Vector3::from(x) * volume;
            total += volume;
        }
        (sum / total).into()
    }

    /// Centre of volume, volume, and inertia about the centre at a density of 1.
    pub(super) fn inertia(&self) -> ([f64; 3], f64, Matrix3<f64>) {
        let volumes = node_volumes(&self.mesh);
        let centre = Vector3::from(self.centre());
        let mut inertia = Matrix3::zeros();
        for (&x, volume) in self.mesh.nodes().iter().zip(&volumes) {
            let arm = Vector3::from(x) - centre;
            inertia += (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()) * *volume;
        }
        (centre.into(), volumes.iter().sum(), inertia)
    }

    /// Forces on the nodes [N], `3 N` component by component, of a force [N] and a moment about the
    /// centre of volume [N m], spread over the body as weight and inertia are.
    pub fn spread_force(&self, wrench: [f64; WRENCH]) -> Vec<f64> {
        let nodes = self.mesh.nodes();
        let n = nodes.len();
        let volumes = node_volumes(&self.mesh);
        let (centre, total, inertia) = self.inertia();
        let centre = Vector3::from(centre);
        let [fx, fy, fz, mx, my, mz] = wrench;
        let push = Vector3::new(fx, fy, fz) / total;
        // a body has extent in three directions: its inertia is positive definite
        let turn = inertia.cholesky().map_or_else(Vector3::zeros, |factor| {
            factor.solve(&Vector3::new(mx, my, mz))
        });
        let mut force = vec![0.0; 3 * n];
        for (node, (&x, volume)) in nodes.iter().zip(&volumes).enumerate() {
            let f = (push + turn.cross(&(Vector3::from(x) - centre))) * *volume;
            (0..3).for_each(|c| force[c * n + node] = f[c]);
        }
        force
    }

    /// The support that holds a component of a node.
    pub(super) fn holder(&self, node: usize, component: usize) -> Option<usize> {
        self.claims.claim[node][component].map(|case| self.claims.cases[case].support)
    }

    /// Rows that give, times the displacement, the stiffness forces on the nodes of each support,
    /// summed to force and moment about the origin: of the unknowns, and of a unit of each case.
    pub(super) fn reaction_rows(&self, unknowns: &Unknowns) -> ReactionRows {
        let n_supports = self.supports().len();
        let mut own = vec![vec![[0.0; WRENCH]; unknowns.n]; n_supports];
        let mut case = vec![vec![[0.0; WRENCH]; unknowns.cases.len()]; n_supports];
        let claimed = |tet: usize| {
            let cell = self.mesh.cell(tet).iter();
            cell.copied()
                .any(|node| self.claims.claim[node].iter().any(Option::is_some))
        };
        let touched: Vec<usize> = (0..self.mesh.n_tets()).filter(|&t| claimed(t)).collect();
        for batch in touched.chunks(4096) {
            let stiffness: Vec<Vec<f64>> = batch
                .par_iter()
                .map(|&t| element::stiffness(self.mesh.cell(t), self.mesh.nodes(), self.material))
                .collect();
            for (&tet, stiffness) in batch.iter().zip(&stiffness) {
                let cell = self.mesh.cell(tet);
                let rows = stiffness.chunks_exact(3 * cell.len());
                for (row, stiffness) in rows.enumerate() {
                    let (node, component) = (cell[row / 3], row % 3);
                    let Some(support) = self.holder(node, component) else {
                        continue;
                    };
                    let lever = lever(self.mesh.nodes()[node], component);
                    for (column, k) in stiffness.iter().enumerate() {
                        let sum = match unknowns.source[cell[column / 3]][column % 3] {
                            Source::Unknown(i) => &mut own[support][i],
                            Source::Prescribed(i) => &mut case[support][i],
                            Source::Pinned => continue,
                        };
                        sum.iter_mut().zip(lever).for_each(|(s, l)| *s += k * l);
                    }
                }
            }
        }
        ReactionRows { own, case }
    }
}

/// See [`TetraBody::reaction_rows`].
pub(super) struct ReactionRows {
    own: Vec<Vec<[f64; WRENCH]>>,
    /// For each support and case.
    pub(super) case: Vec<Vec<[f64; WRENCH]>>,
}

impl ReactionRows {
    /// The rows of the unknowns, six for each support, as right-hand sides.
    pub(super) fn columns(&self) -> Vec<SparseColumn> {
        let columns = self.own.iter().flat_map(|rows| {
            (0..WRENCH).map(move |k| {
                let entries = rows.iter().enumerate().map(|(i, row)| (i, row[k]));
                entries.filter(|(_, value)| *value != 0.0).collect()
            })
        });
        columns.collect()
    }
}

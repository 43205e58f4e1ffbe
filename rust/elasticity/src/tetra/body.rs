// SPDX-License-Identifier: MIT OR Apache-2.0
use std::sync::{Arc, Mutex};

use super::condensed::SupportCase;
use super::factorised::Factored;
use super::mesh::TetraMesh;
use super::rigid::{FreeMotions, RigidMode};
use super::support::{Claims, Support};
use crate::{Error, Material};

/// An elastic body of tetrahedra on its supports.
pub struct TetraBody {
    pub(super) mesh: TetraMesh,
    pub(super) material: Material,
    pub(super) supports: Vec<Support>,
    pub(super) claims: Claims,
    pub(super) free: FreeMotions,
    pub(super) factored: Mutex<Option<Arc<Factored>>>,
}

impl TetraBody {
    /// Body of a mesh, a material and supports.
    ///
    /// # Errors
    /// [`Error::Incompressible`]; [`Error::Index`], [`Error::Contradiction`] on bad supports;
    /// [`Error::Held`] if the supports leave nothing to deform.
    pub fn new(mesh: TetraMesh, material: Material, supports: Vec<Support>) -> Result<Self, Error> {
        if material.poisson_ratio >= 0.5 {
            return Err(Error::Incompressible(material.poisson_ratio));
        }
        let claims = Claims::new(&mesh, &supports)?;
        if !claims.active().contains(&true) {
            return Err(Error::Held);
        }
        let free = FreeMotions::of_supports(&mesh, &claims);
        Ok(TetraBody {
            mesh,
            material,
            supports,
            claims,
            free,
            factored: Mutex::new(None),
        })
    }

    /// The mesh.
    pub fn mesh(&self) -> &TetraMesh {
        &self.mesh
    }

    /// The supports.
    pub fn supports(&self) -> &[Support] {
        &self.supports
    }

    /// Components of the supports that can be given a displacement or a force.
    pub fn cases(&self) -> Vec<SupportCase> {
        self.claims
            .cases
            .iter()
            .map(|case| SupportCase {
                support: case.support,
                component: case.component,
                guided: case.unknown.is_some(),
            })
            .collect()
    }

    /// Rigid motions that the supports leave free, as motions about `point` [m].
    pub fn modes(&self, point: [f64; 3]) -> Vec<RigidMode> {
        self.free.modes(point)
    }

    /// Displacement of the nodes by one rigid motion, `3 N` component by component.
    pub fn mode_displacement(&self, mode: &RigidMode) -> Vec<f64> {
        let n = self.mesh.nodes().len();
        let mut u = vec![0.0; 3 * n];
        for (node, &x) in self.mesh.nodes().iter().enumerate() {
            let moved = mode.displacement(x);
            (0..3).for_each(|c| u[c * n + node] = moved[c]);
        }
        u
    }
}

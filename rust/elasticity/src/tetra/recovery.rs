// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::Monitor;
use rayon::prelude::*;

use super::body::TetraBody;
use super::factorised::{Factored, Limits};
use super::locate::FaceFinder;
use super::relief::Relief;
use super::rigid::RigidMode;
use super::sampling::{SurfacePoint, face_shape};
use super::support::{Case, Source};
use super::{element, stress};
use crate::Error;

/// Force and moment that a support exerts on a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reaction {
    /// [N].
    pub force: [f64; 3],
    /// About the point asked for [N m].
    pub moment: [f64; 3],
}

impl TetraBody {
    /// Forces on the nodes [N], `3 N` component by component, of tractions [Pa] on the surface, one
    /// vector per surface point.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotOnBoundary`].
    pub fn surface_force(
        &self,
        points: &[SurfacePoint],
        traction: &[[f64; 3]],
    ) -> Result<Vec<f64>, Error> {
        if traction.len() != points.len() {
            return Err(Error::Shape {
                name: "traction",
                found: traction.len(),
                expected: points.len(),
            });
        }
        let n = self.mesh.nodes().len();
        let mut force = vec![0.0; 3 * n];
        for (point, t) in points.iter().zip(traction) {
            if point.face >= self.mesh.n_faces() {
                return Err(Error::NotOnBoundary(point.face));
            }
            let shape = face_shape(point.barycentric, self.mesh.order());
            for (&node, value) in self.mesh.face(point.face).iter().zip(shape) {
                for c in 0..3 {
                    force[c * n + node] += point.weight * value * t[c];
                }
            }
        }
        Ok(force)
    }

    /// Displacement of all nodes [m], `3 N` component by component, under forces on the nodes
    /// (`3 N`, [N]), a value for each case (displacement [m], or force on a guide [N]) and amplitudes
    /// of the rigid `modes`.
    ///
    /// With free rigid motions the amplitudes are the mean motion of the body, weighted with its volume, besides that by
    /// which displaced supports move it along. Inertia balances what the loads do on these motions; loads whose amplitudes come from their equilibrium equations are
    /// in equilibrium.
    ///
    /// # Errors
    /// [`Error::Shape`], and those of the factorisation.
    pub fn solve(
        &self,
        force: &[f64],
        case_value: &[f64],
        modes: &[(RigidMode, f64)],
        limits: Limits,
        monitor: Monitor<'_>,
    ) -> Result<Vec<f64>, Error> {
        let n = self.mesh.nodes().len();
        for (name, found, expected) in [
            ("force", force.len(), 3 * n),
            ("case values", case_value.len(), self.claims.cases.len()),
        ] {
            if found != expected {
                return Err(Error::Shape {
                    name,
                    found,
                    expected,
                });
            }
        }
        let factored = self.factored(limits, &|_, _, _, _| Ok(()), monitor)?;
        let relief = Relief::new(self, &self.modes(self.centre()));
        let [loaded, displaced] = [true, false].map(|guided| {
            let cases = self.claims.cases.iter().zip(case_value);
            let of_kind = |(case, value): (&Case, &f64)| {
                if case.unknown.is_some() == guided {
                    *value
                } else {
                    0.0
                }
            };
            cases.map(of_kind).collect::<Vec<f64>>()
        });
        let mut u = if self.free.is_empty() || displaced.iter().all(|&value| value == 0.0) {
            self.respond(&factored, force, case_value, &relief)?
        } else {
            // how far displaced supports take the body along is told otherwise than what loads do
            let mut u = self.respond(&factored, force, &loaded, &relief)?;
            let along = Relief::of_displaced(self);
            let moved = self.respond(&factored, &vec![0.0; 3 * n], &displaced, &along)?;
            u.iter_mut().zip(moved).for_each(|(u, m)| *u += m);
            u
        };
        for (mode, amplitude) in modes {
            for (u, m) in u.iter_mut().zip(self.mode_displacement(mode)) {
                *u += amplitude * m;
            }
        }
        Ok(u)
    }

    /// Displacement of all nodes under forces on them and values of the cases, with what is left of the forces carried by
    /// the inertia of the free motions, and without the mean motion.
    fn respond(
        &self,
        factored: &Factored,
        force: &[f64],
        case_value: &[f64],
        relief: &Relief,
    ) -> Result<Vec<f64>, Error> {
        let n = self.mesh.nodes().len();
        let unknowns = &factored.unknowns;
        let (inertia, motions) = relief.fields(self);
        let case_work = self.case_work(&motions);
        let mut balanced = force.to_vec();
        for (k, (held, motion)) in inertia.iter().zip(&motions).enumerate() {
            let guided = case_value
                .iter()
                .zip(case_work.iter().skip(k).step_by(motions.len()));
            let work = dot(force, motion) + guided.map(|(v, w)| v * w).sum::<f64>();
            balanced
                .iter_mut()
                .zip(held)
                .for_each(|(b, h)| *b -= work * h);
        }
        let mut x = vec![0.0; unknowns.n];
        for (node, sources) in unknowns.source.iter().enumerate() {
            for (c, source) in sources.iter().enumerate() {
                if let Source::Unknown(i) = source {
                    x[*i] += balanced[c * n + node];
                }
            }
        }
        for (load, value) in factored.case_load.iter().zip(case_value) {
            x.iter_mut().zip(load).for_each(|(x, l)| *x += value * l);
        }
        factored
            .factor
            .solve(&mut x)
            .map_err(|_| Error::OutOfMemory {
                unknowns: unknowns.n,
            })?;
        let mut u = vec![0.0; 3 * n];
        for (node, sources) in unknowns.source.iter().enumerate() {
            for (c, source) in sources.iter().enumerate() {
                u[c * n + node] = match source {
                    Source::Unknown(i) => x[*i],
                    Source::Prescribed(case) => case_value[*case],
                    Source::Pinned => 0.0,
                };
            }
        }
        for (held, motion) in inertia.iter().zip(&motions) {
            let mean = dot(held, &u);
            u.iter_mut().zip(motion).for_each(|(u, m)| *u -= mean * m);
        }
        Ok(u)
    }

    /// Displacement at `points` of the surface (`3 n`) under that of the nodes (`3 N`), each point
    /// taken to the nearest of the boundary triangles `faces`.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotOnBoundary`]; [`Error::OffSurface`] if a point is farther than
    /// `reach` [m] from them.
    pub fn displacement_at(
        &self,
        displacement: &[f64],
        points: &[[f64; 3]],
        faces: &[usize],
        reach: f64,
    ) -> Result<Vec<f64>, Error> {
        let (n, n_nodes) = (points.len(), self.mesh.nodes().len());
        if displacement.len() != 3 * n_nodes {
            return Err(Error::Shape {
                name: "displacement",
                found: displacement.len(),
                expected: 3 * n_nodes,
            });
        }
        let finder = FaceFinder::new(&self.mesh, faces, reach)?;
        let mut moved = vec![0.0; 3 * n];
        for (i, &point) in points.iter().enumerate() {
            let hit = finder
                .nearest(point)
                .ok_or(Error::OffSurface { point: i, reach })?;
            let shape = face_shape(hit.barycentric, self.mesh.order());
            for (&node, value) in self.mesh.face(hit.face).iter().zip(shape) {
                for c in 0..3 {
                    moved[c * n + i] += value * displacement[c * n_nodes + node];
                }
            }
        }
        Ok(moved)
    }

    /// What each support exerts on the body, moments about `point`, and the largest force [N] left
    /// over on a node that nothing holds: the error of the solution.
    ///
    /// # Errors
    /// [`Error::Shape`].
    pub fn reactions(
        &self,
        displacement: &[f64],
        force: &[f64],
        point: [f64; 3],
    ) -> Result<(Vec<Reaction>, f64), Error> {
        let n = self.mesh.nodes().len();
        for (name, found) in [("displacement", displacement.len()), ("force", force.len())] {
            if found != 3 * n {
                return Err(Error::Shape {
                    name,
                    found,
                    expected: 3 * n,
                });
            }
        }
        let residual = self.internal_force(displacement);
        let mut reactions = vec![Reaction::default(); self.supports.len()];
        let mut left_over: f64 = 0.0;
        for (node, claims) in self.claims.claim.iter().enumerate() {
            let x = self.mesh.nodes()[node];
            let arm = [0, 1, 2].map(|c| x[c] - point[c]);
            for (c, claim) in claims.iter().enumerate() {
                let r = residual[c * n + node] - force[c * n + node];
                let Some(case) = *claim else {
                    left_over = left_over.max(r.abs());
                    continue;
                };
                let reaction = &mut reactions[self.claims.cases[case].support];
                let (next, last) = ((c + 1) % 3, (c + 2) % 3);
                reaction.force[c] += r;
                // arm x (r e_c)
                reaction.moment[next] += arm[last] * r;
                reaction.moment[last] -= arm[next] * r;
            }
        }
        Ok((reactions, left_over))
    }

    /// Forces [N] that hold a displacement field in place, stiffness times displacement, `3 N`.
    fn internal_force(&self, displacement: &[f64]) -> Vec<f64> {
        let n = self.mesh.nodes().len();
        let tets: Vec<usize> = (0..self.mesh.n_tets()).collect();
        let mut force = vec![0.0; 3 * n];
        for batch in tets.chunks(4096) {
            let parts: Vec<Vec<f64>> = batch
                .par_iter()
                .map(|&tet| {
                    let cell = self.mesh.cell(tet);
                    let u: Vec<f64> = cell
                        .iter()
                        .flat_map(|&a| [0, 1, 2].map(|c| displacement[c * n + a]))
                        .collect();
                    element::stiffness(cell, self.mesh.nodes(), self.material)
                        .chunks_exact(u.len())
                        .map(|row| row.iter().zip(&u).map(|(k, u)| k * u).sum())
                        .collect()
                })
                .collect();
            for (&tet, part) in batch.iter().zip(&parts) {
                for (&node, f) in self.mesh.cell(tet).iter().zip(part.chunks_exact(3)) {
                    (0..3).for_each(|c| force[c * n + node] += f[c]);
                }
            }
        }
        force
    }

    /// Stress (xx, yy, zz, yz, xz, xy) [Pa] at the nodes, `6 N` component by component, averaged over
    /// the tetrahedra around a node; and von Mises' equivalent stress, `N`.
    ///
    /// # Errors
    /// [`Error::Shape`].
    pub fn stress(&self, displacement: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Error> {
        let expected = 3 * self.mesh.nodes().len();
        if displacement.len() != expected {
            return Err(Error::Shape {
                name: "displacement",
                found: displacement.len(),
                expected,
            });
        }
        let stress = stress::at_nodes(&self.mesh, self.material, displacement);
        let von_mises = stress::von_mises(&stress);
        Ok((stress, von_mises))
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

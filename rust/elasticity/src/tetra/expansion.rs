// SPDX-License-Identifier: MIT OR Apache-2.0
//! Thermal expansion, seen from the contact points.

use mtb_operator::{Monitor, check_memory};
use rayon::prelude::*;

use super::body::TetraBody;
use super::condense::Trace;
use super::element;
use super::factorised::{Limits, poll};
use super::relief::Relief;
use super::sampling::Sampling;
use super::support::Source;
use crate::Error;

/// Contact points that are solved for between two looks at the monitor.
const ROUND: usize = 32;

impl TetraBody {
    /// Displacement (n, nodes) [m/K] of the contact points into the body by the temperatures of the nodes, row-major,
    /// for a coefficient of linear `expansion` [1/K]: without the mean of rigid motions that supports leave free, like
    /// the compliance.
    ///
    /// By the reciprocal theorem it is the expansion times three times the bulk modulus times the divergence of the
    /// displacement by a unit load on the contact point, weighted with the shape functions.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::NotOnBoundary`], [`Error::NoArea`], and those of the factorisation.
    pub fn expansion(
        &self,
        sampling: &Sampling,
        expansion: f64,
        limits: Limits,
        monitor: Monitor<'_>,
    ) -> Result<Vec<f64>, Error> {
        if !expansion.is_finite() {
            return Err(Error::NotFinite {
                name: "expansion",
                index: 0,
            });
        }
        let mesh = self.mesh();
        let (n, nodes) = (sampling.n_points(), mesh.nodes().len());
        check_memory(n, (8 * n * nodes) as f64, limits.bytes)?;
        let trace = Trace::new(mesh, sampling)?;
        let factored = self.factored(limits, &|_, _, _, _| Ok(()), monitor)?;
        let unknowns = &factored.unknowns;
        let (shear, nu) = (self.material.shear_modulus, self.material.poisson_ratio);
        // alpha E / (1 - 2 nu)
        let stress = expansion * 2.0 * shear * (1.0 + nu) / (1.0 - 2.0 * nu);
        let divergence: Vec<Vec<f64>> = (0..mesh.n_tets())
            .into_par_iter()
            .map(|tet| element::divergence(mesh.cell(tet), mesh.nodes()))
            .collect();
        poll(monitor, 4)?;
        let (inertia, motions) = Relief::new(self, &self.modes(self.centre())).fields(self);
        let moved: Vec<Vec<f64>> = motions.iter().map(|m| trace.observe(m)).collect();
        let mut found = vec![0.0; n * nodes];
        let mut points: Vec<(usize, &mut [f64])> =
            found.chunks_mut(nodes.max(1)).enumerate().collect();
        for round in points.chunks_mut(ROUND) {
            round.par_iter_mut().try_for_each(|(i, row)| {
                let mut x = vec![0.0; unknowns.n];
                for (unknown, load) in trace.column(*i, 2, &unknowns.source) {
                    x[unknown] += load;
                }
                for (held, moved) in inertia.iter().zip(&moved) {
                    let work = trace.weight(*i) * moved[2 * n + *i];
                    for (node, sources) in unknowns.source.iter().enumerate() {
                        for (c, source) in sources.iter().enumerate() {
                            if let Source::Unknown(k) = source {
                                x[*k] -= work * held[c * nodes + node];
                            }
                        }
                    }
                }
                factored
                    .factor
                    .solve(&mut x)
                    .map_err(|_| Error::OutOfMemory {
                        unknowns: unknowns.n,
                    })?;
                let at = |node: usize, c: usize| match unknowns.source[node][c] {
                    Source::Unknown(k) => x[k],
                    _ => 0.0,
                };
                let scale = stress / trace.weight(*i);
                for (tet, matrix) in divergence.iter().enumerate() {
                    let cell = mesh.cell(tet);
                    let k = cell.len();
                    for (a, &node) in cell.iter().enumerate() {
                        let mut sum = 0.0;
                        for (b, &other) in cell.iter().enumerate() {
                            for c in 0..3 {
                                sum += matrix[a * 3 * k + 3 * b + c] * at(other, c);
                            }
                        }
                        row[node] += scale * sum;
                    }
                }
                Ok::<(), Error>(())
            })?;
            poll(monitor, 4)?;
        }
        Ok(found)
    }
}

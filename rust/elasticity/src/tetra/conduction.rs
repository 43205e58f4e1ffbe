// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies that conduct and store heat, in implicit steps over the time, condensed onto contact points.

use std::sync::Arc;

use mtb_heat::Conductor;
use mtb_operator::{Monitor, check_memory};
use rayon::prelude::*;

use super::assembly::Lower;
use super::element;
use super::factor::{Factor, Failure, Reached, SparseColumn, Symbolic};
use super::factorised::poll;
use super::layers;
use super::mesh::TetraMesh;
use super::numeric;
use super::ordering::{Graph, postordered};
use super::sampling::{Sampling, face_shape};
use crate::Error;

/// Heat that leaves through a part of the surface, in proportion to its temperature: convection, radiation
/// linearised, or another body that is kept at one temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Triangles of the boundary.
    pub faces: Vec<usize>,
    /// Heat transfer coefficient [W/(m2 K)], not negative.
    pub coefficient: f64,
    /// Temperature outside [K].
    pub ambient: f64,
}

/// A mesh of tetrahedra that conducts heat; where nothing is said, no heat passes through its surface.
pub struct ConductingBody {
    mesh: Arc<TetraMesh>,
    conductor: Conductor,
    /// Rank of each node in the order of elimination.
    rank: Vec<usize>,
    /// Of the ranks: heat [J/K], and heat flow [W/K] of conduction and films.
    capacity: Lower,
    conduction: Lower,
    /// Heat flow [W] into the nodes (ranks) from outside, by films.
    inflow: Vec<f64>,
    /// Heat flow through films [W/K] of the nodes (ranks).
    films: Lower,
}

/// An implicit step of a conducting body over a duration, condensed onto contact points.
///
/// Temperatures of nodes are in the order of the mesh. A flux is a sum of the basis functions of the contact points,
/// as pressures are; the temperature of a contact point is the mean weighted by its basis function.
pub struct ConductionStep {
    body: Arc<ConductingBody>,
    duration: f64,
    factor: Factor,
    /// For each contact point the ranks below it, each with the integral of both functions [m2].
    trace: Vec<SparseColumn>,
    weights: Vec<f64>,
    response: Vec<f64>,
}

/// Contact points whose columns go through the factor together.
const GROUP: usize = 64;

/// Rule of degree 4 with 6 points on a triangle: barycentric coordinates and weights that add up to one.
fn triangle_rule() -> [([f64; 3], f64); 6] {
    let mut rule = [([0.0; 3], 0.0); 6];
    let orbits = [
        (0.445_948_490_915_965, 0.223_381_589_678_011),
        (0.091_576_213_509_771, 0.109_951_743_655_322),
    ];
    for (k, (b, weight)) in orbits.into_iter().enumerate() {
        for i in 0..3 {
            let mut l = [b; 3];
            l[i] = 1.0 - 2.0 * b;
            rule[3 * k + i] = (l, weight);
        }
    }
    rule
}

impl ConductingBody {
    /// Of a `mesh` of one `conductor`, with `films` on its surface.
    ///
    /// # Errors
    /// [`Error::NotOnBoundary`]; [`Error::Film`] for a coefficient that is negative or a number that is not finite;
    /// [`Error::Interrupted`].
    pub fn new(
        mesh: Arc<TetraMesh>,
        conductor: Conductor,
        films: &[Film],
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let n = mesh.nodes().len();
        let graph = Graph::of_groups(n, mesh.cells().chunks_exact(mesh.order().nodes_per_tet()));
        poll(monitor, 0)?;
        let dissected = layers::elimination(&graph, &vec![true; n], mesh.nodes());
        poll(monitor, 0)?;
        let order = postordered(&graph, &dissected);
        poll(monitor, 0)?;
        let mut rank = vec![0; n];
        for (k, &node) in order.iter().enumerate() {
            rank[node] = k;
        }
        let empty = pattern(&graph, &order, &rank);
        let mut capacity = empty.clone();
        let mut conduction = empty.clone();
        let tets: Vec<usize> = (0..mesh.n_tets()).collect();
        for batch in tets.chunks(1024) {
            let matrices: Vec<_> = batch
                .par_iter()
                .map(|&tet| element::conduction(mesh.cell(tet), mesh.nodes()))
                .collect();
            for (&tet, (c, k)) in batch.iter().zip(&matrices) {
                add(
                    &mut capacity,
                    mesh.cell(tet),
                    &rank,
                    c,
                    conductor.capacity(),
                );
                add(
                    &mut conduction,
                    mesh.cell(tet),
                    &rank,
                    k,
                    conductor.conductivity(),
                );
            }
            poll(monitor, 1)?;
        }
        let mut inflow = vec![0.0; n];
        let mut through = empty;
        for film in films {
            if !(film.coefficient >= 0.0
                && film.coefficient.is_finite()
                && film.ambient.is_finite())
            {
                return Err(Error::Film {
                    coefficient: film.coefficient,
                    ambient: film.ambient,
                });
            }
            for &face in &film.faces {
                if face >= mesh.n_faces() {
                    return Err(Error::NotOnBoundary(face));
                }
                let nodes = mesh.face(face);
                let k = nodes.len();
                let (mut matrix, mut load) = (vec![0.0; k * k], vec![0.0; k]);
                for (l, weight) in triangle_rule() {
                    let shape = face_shape(l, mesh.order());
                    let weight = weight * area_at(&mesh, face, l);
                    for a in 0..k {
                        load[a] += weight * shape[a];
                        for b in 0..k {
                            matrix[a * k + b] += weight * shape[a] * shape[b];
                        }
                    }
                }
                add(&mut through, nodes, &rank, &matrix, film.coefficient);
                add(&mut conduction, nodes, &rank, &matrix, film.coefficient);
                for (&node, load) in nodes.iter().zip(load) {
                    inflow[rank[node]] += film.coefficient * film.ambient * load;
                }
            }
        }
        Ok(Self {
            mesh,
            conductor,
            rank,
            capacity,
            conduction,
            inflow,
            films: through,
        })
    }

    /// The mesh.
    pub fn mesh(&self) -> &TetraMesh {
        &self.mesh
    }

    /// The conductor.
    pub fn conductor(&self) -> Conductor {
        self.conductor
    }

    pub(super) fn capacity(&self) -> &Lower {
        &self.capacity
    }

    /// Of conduction and films.
    pub(super) fn conduction(&self) -> &Lower {
        &self.conduction
    }

    pub(super) fn films(&self) -> &Lower {
        &self.films
    }

    pub(super) fn inflow_by_rank(&self) -> &[f64] {
        &self.inflow
    }

    /// Values of nodes by their ranks.
    pub(super) fn by_rank(&self, values: &[f64]) -> Vec<f64> {
        let mut ranked = vec![0.0; values.len()];
        for (value, &k) in values.iter().zip(&self.rank) {
            ranked[k] = *value;
        }
        ranked
    }

    /// Values of ranks by their nodes.
    pub(super) fn by_node(&self, ranked: &[f64]) -> Vec<f64> {
        self.rank.iter().map(|&k| ranked[k]).collect()
    }

    /// Heat [J] that the body holds at temperatures `temperature` (nodes) [K], above that at zero.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`].
    pub fn heat(&self, temperature: &[f64]) -> Result<f64, Error> {
        let ranked = self.ranked(temperature)?;
        Ok(self.capacity.times(&ranked).iter().sum())
    }

    /// Heat flow [W] that leaves through films at temperatures `temperature` (nodes) [K].
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`].
    pub fn loss(&self, temperature: &[f64]) -> Result<f64, Error> {
        let ranked = self.ranked(temperature)?;
        let out: f64 = self.films.times(&ranked).iter().sum();
        Ok(out - self.inflow.iter().sum::<f64>())
    }

    fn ranked(&self, temperature: &[f64]) -> Result<Vec<f64>, Error> {
        refuse("temperature", temperature, self.rank.len())?;
        Ok(self.by_rank(temperature))
    }

    /// An implicit step over `duration` [s] with heat through the contact points of `sampling`.
    ///
    /// The step is of first order in the duration and stable for any (backward Euler).
    ///
    /// # Errors
    /// [`Error::Duration`]; [`Error::NotOnBoundary`], [`Error::NoArea`]; [`Error::OutOfMemory`];
    /// [`Error::Interrupted`].
    pub fn step(
        self: &Arc<Self>,
        duration: f64,
        sampling: &Sampling,
        monitor: Monitor<'_>,
    ) -> Result<ConductionStep, Error> {
        let factor = self.factor(duration, monitor)?;
        let (trace, weights) = self.traced(sampling)?;
        let groups: Vec<Vec<SparseColumn>> = trace.chunks(GROUP).map(<[_]>::to_vec).collect();
        let reached: Vec<Reached> = factor.forward_all(&groups);
        poll(monitor, 3)?;
        let n = trace.len();
        let mut response = vec![0.0; n * n];
        let pairs: Vec<(usize, usize)> = (0..groups.len())
            .flat_map(|i| (i..groups.len()).map(move |j| (i, j)))
            .collect();
        for batch in pairs.chunks(64) {
            let products: Vec<_> = batch
                .par_iter()
                .map(|&(i, j)| factor.product(&reached[i], &reached[j]).each_other)
                .collect();
            for (&(i, j), product) in batch.iter().zip(&products) {
                for a in 0..product.nrows() {
                    for b in 0..product.ncols() {
                        let (row, column) = (i * GROUP + a, j * GROUP + b);
                        response[row * n + column] = product[(a, b)] / weights[row];
                        response[column * n + row] = product[(a, b)] / weights[column];
                    }
                }
            }
            poll(monitor, 4)?;
        }
        Ok(ConductionStep {
            body: self.clone(),
            duration,
            factor,
            trace,
            weights,
            response,
        })
    }

    /// The factor of a step over `duration` [s].
    pub(super) fn factor(&self, duration: f64, monitor: Monitor<'_>) -> Result<Factor, Error> {
        check_duration(duration)?;
        let mut matrix = self.conduction.clone();
        for (value, c) in matrix.value.iter_mut().zip(&self.capacity.value) {
            *value += c / duration;
        }
        let unknowns = self.rank.len();
        let describe = |failure: Failure| match failure {
            Failure::Pivot(_) | Failure::Memory => Error::OutOfMemory { unknowns },
            Failure::Interrupted => Error::Interrupted,
        };
        let symbolic = Symbolic::new(&matrix, None, monitor).map_err(describe)?;
        let mut values = numeric::reserved(symbolic.entries()).map_err(describe)?;
        values.resize(symbolic.entries(), 0.0);
        let factor = symbolic
            .numeric(&matrix, values, monitor)
            .map_err(describe)?;
        poll(monitor, 2)?;
        Ok(factor)
    }

    /// For each contact point the ranks below it, each with the integral of both functions [m2], and its area.
    pub(super) fn traced(
        &self,
        sampling: &Sampling,
    ) -> Result<(Vec<SparseColumn>, Vec<f64>), Error> {
        let trace = self.trace(sampling)?;
        let weights = sampling.weights();
        let most = weights.iter().copied().fold(0.0, f64::max);
        match weights.iter().position(|&w| w.is_nan() || w <= 1e-9 * most) {
            Some(i) => Err(Error::NoArea(i)),
            None => Ok((trace, weights)),
        }
    }

    fn trace(&self, sampling: &Sampling) -> Result<Vec<SparseColumn>, Error> {
        let mut trace: Vec<SparseColumn> = vec![Vec::new(); sampling.n_points()];
        for (q, point) in sampling.quadrature().iter().enumerate() {
            if point.face >= self.mesh.n_faces() {
                return Err(Error::NotOnBoundary(point.face));
            }
            let shape = face_shape(point.barycentric, self.mesh.order());
            for &(i, phi) in sampling.basis(q) {
                for (&node, n) in self.mesh.face(point.face).iter().zip(shape) {
                    trace[i].push((self.rank[node], point.weight * phi * n));
                }
            }
        }
        for column in &mut trace {
            column.sort_by_key(|&(rank, _)| rank);
            column.dedup_by(|next, kept| {
                let is_same = next.0 == kept.0;
                if is_same {
                    kept.1 += next.1;
                }
                is_same
            });
        }
        Ok(trace)
    }
}

impl ConductionStep {
    /// Temperatures (n, n) [K m2/W] of the contact points at the end of the step by a unit flux into each, row-major.
    pub fn response(&self) -> &[f64] {
        &self.response
    }

    /// Areas (n) [m2] of the contact points.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The duration [s].
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Temperatures (n, nodes) [K m2/W] of the nodes at the end of the step by a unit flux into each contact point,
    /// row-major.
    ///
    /// # Errors
    /// [`Error::Operator`] and [`Error::OutOfMemory`] for more than the memory holds; [`Error::Interrupted`].
    pub fn nodes(&self, monitor: Monitor<'_>) -> Result<Vec<f64>, Error> {
        let (n, width) = (self.trace.len(), self.body.rank.len());
        check_memory(n, (8 * n * width) as f64, f64::INFINITY)?;
        let mut found = vec![0.0; n * width];
        let mut rows: Vec<(&SparseColumn, &mut [f64])> = self
            .trace
            .iter()
            .zip(found.chunks_mut(width.max(1)))
            .collect();
        for batch in rows.chunks_mut(GROUP) {
            batch.par_iter_mut().try_for_each(|(column, row)| {
                let mut x = vec![0.0; width];
                for (k, b) in *column {
                    x[*k] = *b;
                }
                self.factor
                    .solve(&mut x)
                    .map_err(|_| Error::OutOfMemory { unknowns: width })?;
                for (value, k) in row.iter_mut().zip(&self.body.rank) {
                    *value = x[*k];
                }
                Ok::<(), Error>(())
            })?;
            poll(monitor, 4)?;
        }
        Ok(found)
    }

    /// Temperatures of the contact points (n) [K] under those of the nodes.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`].
    pub fn observe(&self, temperature: &[f64]) -> Result<Vec<f64>, Error> {
        let ranked = self.body.ranked(temperature)?;
        let columns = self.trace.iter().zip(&self.weights);
        Ok(columns
            .map(|(column, w)| column.iter().map(|(k, b)| b * ranked[*k]).sum::<f64>() / w)
            .collect())
    }

    /// Temperatures of the nodes [K] at the end of a step that begins at `temperature` (nodes), with `flux` (n)
    /// [W/m2] through the contact points.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`], [`Error::OutOfMemory`].
    pub fn advance(&self, temperature: &[f64], flux: &[f64]) -> Result<Vec<f64>, Error> {
        let ranked = self.body.ranked(temperature)?;
        let mut x = self.body.capacity.times(&ranked);
        x.iter_mut()
            .zip(&self.body.inflow)
            .for_each(|(x, inflow)| *x = *x / self.duration + inflow);
        refuse("flux", flux, self.trace.len())?;
        for (column, q) in self.trace.iter().zip(flux) {
            for (k, b) in column {
                x[*k] += b * q;
            }
        }
        self.factor.solve(&mut x).map_err(|_| Error::OutOfMemory {
            unknowns: self.body.rank.len(),
        })?;
        Ok(self.body.rank.iter().map(|&k| x[k]).collect())
    }
}

/// Refuses numbers that are not as many as expected, or not finite.
pub(super) fn refuse(name: &'static str, values: &[f64], expected: usize) -> Result<(), Error> {
    if values.len() != expected {
        return Err(Error::Shape {
            name,
            found: values.len(),
            expected,
        });
    }
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(Error::NotFinite { name, index }),
        None => Ok(()),
    }
}

pub(super) fn check_duration(duration: f64) -> Result<(), Error> {
    if duration > 0.0 && duration.is_finite() {
        return Ok(());
    }
    Err(Error::Duration(duration))
}

/// Area [m2] of a boundary triangle over that of barycentric coordinates, at `l`: of its curved surface.
fn area_at(mesh: &TetraMesh, face: usize, l: [f64; 3]) -> f64 {
    let nodes = mesh.face(face);
    let order = mesh.order();
    // derivatives along the second and the third coordinate, by differences that are exact for quadratics
    let step = 1e-4;
    let along = |k: usize| {
        let moved = |sign: f64| {
            let mut at = l;
            at[0] -= sign * step;
            at[k] += sign * step;
            face_shape(at, order)
        };
        let (plus, minus) = (moved(1.0), moved(-1.0));
        std::array::from_fn::<f64, 3, _>(|c| {
            nodes
                .iter()
                .enumerate()
                .map(|(a, &node)| (plus[a] - minus[a]) / (2.0 * step) * mesh.nodes()[node][c])
                .sum()
        })
    };
    let (u, v) = (along(1), along(2));
    let cross = [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ];
    0.5 * cross.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// Sparsity, with zeros, of a matrix of one value a node.
pub(super) fn pattern(graph: &Graph, order: &[usize], rank: &[usize]) -> Lower {
    let mut start = vec![0];
    let mut row = Vec::with_capacity(graph.neighbours.len() / 2 + order.len());
    for (k, &node) in order.iter().enumerate() {
        let first = row.len();
        row.push(k);
        row.extend(graph.of(node).iter().map(|&w| rank[w]).filter(|&i| i > k));
        row[first..].sort_unstable();
        start.push(row.len());
    }
    let value = vec![0.0; row.len()];
    Lower { start, row, value }
}

pub(super) fn add(lower: &mut Lower, nodes: &[usize], rank: &[usize], matrix: &[f64], factor: f64) {
    let n = nodes.len();
    for (b, &node) in nodes.iter().enumerate() {
        let column = rank[node];
        let range = lower.start[column]..lower.start[column + 1];
        for (a, &other) in nodes.iter().enumerate() {
            let row = rank[other];
            if row >= column
                && let Ok(at) = lower.row[range.clone()].binary_search(&row)
            {
                lower.value[range.start + at] += factor * matrix[a * n + b];
            }
        }
    }
}

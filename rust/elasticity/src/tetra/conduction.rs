// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies that conduct and store heat, in implicit steps over the time, condensed onto contact points.

use std::sync::{Arc, Mutex};

use mtb_heat::Conductor;
use mtb_operator::Monitor;
use rayon::prelude::*;

use super::assembly::Lower;
use super::conduction_step::Halved;
use super::element;
use super::factor::{Factor, Failure, SparseColumn, Symbolic};
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
    /// Heat [J/K], and heat flow through films [W/K], by a kelvin at each node.
    heat_at: Vec<f64>,
    loss_at: Vec<f64>,
    /// How it was taken apart for its last step.
    pub(super) halved: Mutex<Option<Arc<Halved>>>,
}

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
        let ones = vec![1.0; n];
        let [heat_at, loss_at] = [&capacity, &through].map(|matrix| {
            let ranked = matrix.times(&ones);
            rank.iter().map(|&k| ranked[k]).collect()
        });
        Ok(Self {
            mesh,
            conductor,
            rank,
            capacity,
            conduction,
            inflow,
            films: through,
            heat_at,
            loss_at,
            halved: Mutex::new(None),
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

    /// Rank of each node.
    pub(super) fn ranks(&self) -> &[usize] {
        &self.rank
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
        refuse("temperature", temperature, self.rank.len())?;
        Ok(dot(&self.heat_at, temperature))
    }

    /// Heat flow [W] that leaves through films at temperatures `temperature` (nodes) [K].
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`].
    pub fn loss(&self, temperature: &[f64]) -> Result<f64, Error> {
        refuse("temperature", temperature, self.rank.len())?;
        Ok(dot(&self.loss_at, temperature) - self.inflow.iter().sum::<f64>())
    }

    pub(super) fn ranked(&self, temperature: &[f64]) -> Result<Vec<f64>, Error> {
        refuse("temperature", temperature, self.rank.len())?;
        Ok(self.by_rank(temperature))
    }

    /// The factor of a step over `duration` [s].
    pub(super) fn factor(&self, duration: f64, monitor: Monitor<'_>) -> Result<Factor, Error> {
        factor_of_step(&self.conduction, &self.capacity, duration, monitor)
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

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(super) fn check_duration(duration: f64) -> Result<(), Error> {
    if duration > 0.0 && duration.is_finite() {
        return Ok(());
    }
    Err(Error::Duration(duration))
}

/// The factor of `conduction + capacity / duration`.
pub(super) fn factor_of_step(
    conduction: &Lower,
    capacity: &Lower,
    duration: f64,
    monitor: Monitor<'_>,
) -> Result<Factor, Error> {
    check_duration(duration)?;
    let mut matrix = conduction.clone();
    for (value, c) in matrix.value.iter_mut().zip(&capacity.value) {
        *value += c / duration;
    }
    let unknowns = matrix.start.len() - 1;
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

/// Sparsity, with zeros, of a matrix of one value for each node of an `order`; others have no rank below its length.
pub(super) fn pattern(graph: &Graph, order: &[usize], rank: &[usize]) -> Lower {
    let mut start = vec![0];
    let mut row = Vec::with_capacity(graph.neighbours.len() / 2 + order.len());
    for (k, &node) in order.iter().enumerate() {
        let first = row.len();
        row.push(k);
        row.extend(
            graph
                .of(node)
                .iter()
                .map(|&w| rank[w])
                .filter(|&i| i > k && i < order.len()),
        );
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

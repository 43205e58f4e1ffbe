// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::Monitor;
use mtb_operator::dense::Watch;
use rayon::prelude::*;

use super::element;
use super::factorised::poll;
use super::mesh::TetraMesh;
use super::ordering::Graph;
use super::support::{Source, Unknowns};
use crate::{Error, Material};

/// Lower triangle of a symmetric matrix by columns, rows sorted.
#[derive(Clone)]
pub(super) struct Lower {
    pub(super) start: Vec<usize>,
    pub(super) row: Vec<usize>,
    pub(super) value: Vec<f64>,
}

impl Lower {
    /// The product of the whole matrix with a vector.
    pub(super) fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for column in 0..x.len() {
            for k in self.start[column]..self.start[column + 1] {
                let (row, value) = (self.row[k], self.value[k]);
                y[row] += value * x[column];
                if row != column {
                    y[column] += value * x[row];
                }
            }
        }
        y
    }

    /// The same with several vectors, one after the other.
    pub(super) fn times_each<const K: usize>(&self, x: [&[f64]; K]) -> [Vec<f64>; K] {
        let n = self.start.len() - 1;
        let mut y: [Vec<f64>; K] = std::array::from_fn(|_| vec![0.0; n]);
        for column in 0..n {
            let own: [f64; K] = std::array::from_fn(|c| x[c][column]);
            let mut sum = [0.0; K];
            for k in self.start[column]..self.start[column + 1] {
                let (row, value) = (self.row[k], self.value[k]);
                for c in 0..K {
                    y[c][row] += value * own[c];
                    sum[c] += value * x[c][row];
                }
            }
            // the diagonal has been counted twice
            let diagonal = self.value[self.start[column]];
            for c in 0..K {
                y[c][column] += sum[c] - diagonal * own[c];
            }
        }
        y
    }

    /// One entry of the whole matrix; zero where it has none.
    pub(super) fn at(&self, i: usize, j: usize) -> f64 {
        let (row, column) = (i.max(j), i.min(j));
        let range = self.start[column]..self.start[column + 1];
        let found = self.row[range.clone()].binary_search(&row);
        found.map_or(0.0, |k| self.value[range.start + k])
    }
}

/// Elements whose matrices are formed at once: bounds the memory, keeps the threads busy.
const BATCH: usize = 512;

/// Operations that an entry of an element's matrix counts for: quadrature, and a search for its place.
const ENTRY: f64 = 100.0;

/// Assembles the stiffness [N/m] of `unknowns` in its [`pattern`], of the elements `tets`.
///
/// # Errors
/// [`Error::Interrupted`].
pub(super) fn assemble(
    mesh: &TetraMesh,
    material: Material,
    tets: &[usize],
    unknowns: &Unknowns,
    mut stiffness: Lower,
    monitor: Monitor<'_>,
) -> Result<Lower, Error> {
    visit(
        mesh,
        material,
        tets,
        unknowns,
        monitor,
        |sources, matrix| {
            let n = sources.len();
            for (j, &column) in sources.iter().enumerate() {
                let Source::Unknown(column) = column else {
                    continue;
                };
                let range = stiffness.start[column]..stiffness.start[column + 1];
                let rows = &stiffness.row[range.clone()];
                let values = &mut stiffness.value[range];
                for (i, &row) in sources.iter().enumerate() {
                    let Source::Unknown(row) = row else { continue };
                    if row < column {
                        continue;
                    }
                    if let Ok(at) = rows.binary_search(&row) {
                        values[at] += matrix[i * n + j];
                    }
                }
            }
        },
    )?;
    Ok(stiffness)
}

/// Loads [N] on the unknowns by a unit displacement of each prescribed case; empty for guided ones.
///
/// # Errors
/// [`Error::Interrupted`].
pub(super) fn pulls(
    mesh: &TetraMesh,
    material: Material,
    unknowns: &Unknowns,
    monitor: Monitor<'_>,
) -> Result<Vec<Vec<f64>>, Error> {
    let cases = unknowns.cases.iter();
    let rows = cases.map(|case| {
        if case.unknown.is_some() {
            0
        } else {
            unknowns.n
        }
    });
    let mut pull: Vec<Vec<f64>> = rows.map(|rows| vec![0.0; rows]).collect();
    let is_pulled = |&tet: &usize| {
        let sources = mesh
            .cell(tet)
            .iter()
            .flat_map(|&node| unknowns.source[node]);
        sources
            .into_iter()
            .any(|s| matches!(s, Source::Prescribed(_)))
    };
    let tets: Vec<usize> = (0..mesh.n_tets()).filter(is_pulled).collect();
    visit(
        mesh,
        material,
        &tets,
        unknowns,
        monitor,
        |sources, matrix| {
            let n = sources.len();
            for (j, &column) in sources.iter().enumerate() {
                let Source::Prescribed(case) = column else {
                    continue;
                };
                for (i, &row) in sources.iter().enumerate() {
                    if let Source::Unknown(row) = row {
                        pull[case][row] -= matrix[i * n + j];
                    }
                }
            }
        },
    )?;
    Ok(pull)
}

/// Shows the stiffness of each of the elements `tets`, with what its displacements come from.
fn visit(
    mesh: &TetraMesh,
    material: Material,
    tets: &[usize],
    unknowns: &Unknowns,
    monitor: Monitor<'_>,
    mut show: impl FnMut(&[Source], &[f64]),
) -> Result<(), Error> {
    poll(monitor, 1)?;
    let mut watch = Watch::new(monitor);
    let entries = (3 * mesh.order().nodes_per_tet()).pow(2) as f64;
    for batch in tets.chunks(BATCH) {
        let matrices: Vec<Vec<f64>> = batch
            .par_iter()
            .map(|&tet| element::stiffness(mesh.cell(tet), mesh.nodes(), material))
            .collect();
        for (&tet, matrix) in batch.iter().zip(&matrices) {
            let sources: Vec<Source> = mesh
                .cell(tet)
                .iter()
                .flat_map(|&node| unknowns.source[node])
                .collect();
            show(&sources, matrix);
        }
        watch
            .spend(ENTRY * entries * batch.len() as f64)
            .map_err(|_| Error::Interrupted)?;
    }
    Ok(())
}

/// Memory [bytes] of the stiffness of `unknowns` and of its transposed structure, at most: what it takes from
/// here until its factor is known.
pub(super) fn memory(graph: &Graph, unknowns: &Unknowns) -> f64 {
    (3 * size_of::<usize>() * most_entries(graph, unknowns)) as f64
}

/// Entries of the lower triangle, at most: where supports hold unknowns, there are less.
fn most_entries(graph: &Graph, unknowns: &Unknowns) -> usize {
    let pairs = graph.neighbours.len() / 2;
    9 * pairs + 6 * graph.len() + unknowns.n_guided * unknowns.n
}

/// Sparsity, with zeros: all unknowns of adjacent nodes; guided unknowns are coupled to everything. Own unknowns
/// are numbered node by node along `order`.
pub(super) fn pattern(graph: &Graph, order: &[usize], unknowns: &Unknowns) -> Lower {
    let own = |node: usize| {
        unknowns.source[node].into_iter().filter_map(|s| match s {
            Source::Unknown(i) if i < unknowns.n - unknowns.n_guided => Some(i),
            _ => None,
        })
    };
    let guided = unknowns.n - unknowns.n_guided..unknowns.n;
    let mut start = vec![0];
    let mut row = Vec::with_capacity(most_entries(graph, unknowns));
    let mut rows: Vec<usize> = Vec::new();
    for &node in order {
        rows.clear();
        rows.extend(own(node));
        let Some(&first) = rows.first() else { continue };
        let columns = rows.len();
        for &other in graph.of(node) {
            rows.extend(own(other).filter(|&i| i > first));
        }
        rows[columns..].sort_unstable();
        rows.extend(guided.clone());
        for column in 0..columns {
            row.extend_from_slice(&rows[column..]);
            start.push(row.len());
        }
    }
    for column in guided.clone() {
        row.extend(column..unknowns.n);
        start.push(row.len());
    }
    row.shrink_to_fit();
    let value = vec![0.0; row.len()];
    Lower { start, row, value }
}

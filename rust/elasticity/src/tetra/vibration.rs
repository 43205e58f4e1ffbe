// SPDX-License-Identifier: MIT OR Apache-2.0
//! Natural vibrations of a body of tetrahedra on its supports.

use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut};
use mtb_operator::{MEMORY_LIMIT, Monitor, check_memory, ready_products, reset_workers};
use rayon::prelude::*;

use super::assembly::Lower;
use super::body::TetraBody;
use super::columns::{Random, columns_of, exact_eigen, inner, par, times};
use super::conduction::{add, pattern};
use super::element;
use super::factorised::{Factored, Limits, poll};
use super::ordering::Graph;
use super::support::Source;
use crate::Error;

/// Natural vibrations of a body whose supports are at rest and whose guides carry no load.
///
/// Fields of nodes are `3 N` values, component by component. All modes together are orthonormal in the product of the
/// mass [kg], so that amplitudes of them have the dimension m kg^1/2.
pub struct Vibration {
    /// Squares of the angular frequencies [1/s2], rising.
    pub squares: Vec<f64>,
    /// Displacement [kg^-1/2] of the nodes, one vibration after the other.
    pub shapes: Vec<f64>,
    /// Rigid motions that the supports leave free [kg^-1/2], one after the other.
    pub rigid: Vec<f64>,
    /// Mass times the shapes [kg^1/2]: of the rigid motions, then of the vibrations.
    pub inertia: Vec<f64>,
    /// Mass [kg].
    pub mass: f64,
    /// Solves with the factor of the stiffness.
    pub solves: usize,
}

/// Columns that go through the factor together. A body whose mesh is symmetric has vibrations of one frequency, by at
/// most five as no point group in space has larger irreducible representations; a block of this size finds them all.
const BLOCK: usize = 6;
/// What the operator leaves of a vibration, over its eigenvalue, when it is found; its square is the error of the
/// eigenvalue, in the order of magnitude.
const TOLERANCE: f64 = 1e-10;
/// The same over the largest eigenvalue: rounding.
const ROUNDING: f64 = 1e-13;
/// Square of what is left of a direction, over that before, from which it counts as new.
const NEW: f64 = 1e-20;
/// The same over the largest of its block, whose products hold no more digits.
const RELATIVE: f64 = 1e-12;
/// Square of a direction that was of size 1: below, it was rounding.
const SOUND: f64 = 0.1;

impl TetraBody {
    /// The lowest `count` vibrations of the body at a `density` [kg/m3], besides its free rigid motions, by block
    /// Krylov spaces of the inverse stiffness [GrimesLewisSimon1994].
    ///
    /// The rigid motions are known, so that no shift is needed: the factor of the stiffness, pinned where a rigid
    /// motion is free, is applied to loads in equilibrium, and what it gives is freed of rigid motion. The mass is the
    /// consistent one. The monitor is asked between the blocks.
    ///
    /// # Errors
    /// [`Error::NotPositive`], [`Error::Vibrations`]; [`Error::Operator`] and [`Error::OutOfMemory`] for more than the
    /// memory holds; those of the factorisation; [`Error::Interrupted`].
    pub fn vibration(
        &self,
        density: f64,
        count: usize,
        limits: Limits,
        monitor: Monitor<'_>,
    ) -> Result<Vibration, Error> {
        if !(density > 0.0 && density.is_finite()) {
            return Err(Error::NotPositive {
                name: "density",
                value: density,
            });
        }
        let factored = self.factored(limits, &|_, _, _, _| Ok(()), monitor)?;
        let most = factored.unknowns.n;
        if count == 0 || count > most {
            return Err(Error::Vibrations { asked: count, most });
        }
        ready_products()?;
        let mass = self.nodal_mass(density, monitor)?;
        let mut space = Space {
            nodes: self.mesh.nodes().len(),
            rigid: Vec::new(),
            inertia: Vec::new(),
            columns: Vec::new(),
            random: Random(0),
            solves: 0,
            mass,
            factored,
        };
        space.set_rigid(self);
        let (squares, shapes) = space.lowest(count, monitor)?;
        let mut inertia = space.inertia.clone();
        inertia.extend(space.times_mass(&shapes));
        let ones = vec![1.0; space.nodes];
        Ok(Vibration {
            squares,
            inertia,
            mass: space.mass.times(&ones).iter().sum(),
            solves: space.solves,
            rigid: space.rigid,
            shapes,
        })
    }

    /// Consistent mass [kg] between nodes, which is the same for each component.
    fn nodal_mass(&self, density: f64, monitor: Monitor<'_>) -> Result<Lower, Error> {
        let mesh = &self.mesh;
        let n = mesh.nodes().len();
        let graph = Graph::of_groups(n, mesh.cells().chunks_exact(mesh.order().nodes_per_tet()));
        let order: Vec<usize> = (0..n).collect();
        let mut mass = pattern(&graph, &order, &order);
        let tets: Vec<usize> = (0..mesh.n_tets()).collect();
        for batch in tets.chunks(1024) {
            let matrices: Vec<Vec<f64>> = batch
                .par_iter()
                .map(|&tet| element::products(mesh.cell(tet), mesh.nodes()))
                .collect();
            for (&tet, matrix) in batch.iter().zip(&matrices) {
                add(&mut mass, mesh.cell(tet), &order, matrix, density);
            }
            poll(monitor, 3)?;
        }
        Ok(mass)
    }
}

/// A growing space of displacements of the nodes, orthonormal in the product of the mass, without rigid motions.
struct Space {
    nodes: usize,
    mass: Lower,
    factored: Arc<Factored>,
    rigid: Vec<f64>,
    /// Mass times rigid motions.
    inertia: Vec<f64>,
    columns: Vec<f64>,
    random: Random,
    solves: usize,
}

impl Space {
    fn rows(&self) -> usize {
        3 * self.nodes
    }

    fn len(&self) -> usize {
        self.columns.len() / self.rows()
    }

    fn times_mass(&self, values: &[f64]) -> Vec<f64> {
        // the same matrix for each component
        times(&self.mass, values, self.nodes)
    }

    /// Rigid motions that the supports leave, orthonormal in the product of the mass.
    fn set_rigid(&mut self, body: &TetraBody) {
        let rows = self.rows();
        for mode in body.modes(body.centre()) {
            let mut u = body.mode_displacement(&mode);
            // twice is enough
            for _ in 0..2 {
                let (rigid, inertia) = (&self.rigid, &self.inertia);
                clear(&mut u, rigid, inertia, rows);
                let held = self.times_mass(&u);
                let size = dot(&u, &held).sqrt();
                for u in &mut u {
                    *u /= size;
                }
            }
            self.inertia.extend(self.times_mass(&u));
            self.rigid.extend(u);
        }
    }

    /// What the unknowns move: the pinned ones rest.
    fn spread(&self, x: &[f64]) -> Vec<f64> {
        let mut u = vec![0.0; self.rows()];
        for (node, sources) in self.factored.unknowns.source.iter().enumerate() {
            for (c, source) in sources.iter().enumerate() {
                if let Source::Unknown(i) = source {
                    u[c * self.nodes + node] = x[*i];
                }
            }
        }
        u
    }

    /// Displacements (3 N each) without rigid motion under the inertia of others.
    fn apply(&mut self, values: &[f64]) -> Result<Vec<f64>, Error> {
        let (rows, n) = (self.rows(), self.factored.unknowns.n);
        let mut force = self.times_mass(values);
        // what is orthogonal to the rigid motions loads them by rounding alone
        clear(&mut force, &self.inertia, &self.rigid, rows);
        let count = values.len() / rows;
        self.solves += count;
        let space = &*self;
        let moved: Vec<Vec<f64>> = force
            .par_chunks(rows)
            .map(|force| {
                let mut x = vec![0.0; n];
                for (node, sources) in space.factored.unknowns.source.iter().enumerate() {
                    for (c, source) in sources.iter().enumerate() {
                        if let Source::Unknown(i) = source {
                            x[*i] += force[c * space.nodes + node];
                        }
                    }
                }
                let solved = space.factored.factor.solve(&mut x);
                solved.map_err(|_| Error::OutOfMemory { unknowns: n })?;
                Ok(space.spread(&x))
            })
            .collect::<Result<_, Error>>()?;
        let mut moved = moved.concat();
        clear(&mut moved, &self.rigid, &self.inertia, rows);
        reset_workers();
        Ok(moved)
    }

    /// A block of random displacements that the supports allow.
    fn random_block(&mut self) -> Vec<f64> {
        let n = self.factored.unknowns.n;
        let mut block = Vec::with_capacity(BLOCK * self.rows());
        for _ in 0..BLOCK {
            let x: Vec<f64> = (0..n).map(|_| self.random.sign()).collect();
            block.extend(self.spread(&x));
        }
        clear(&mut block, &self.rigid, &self.inertia, 3 * self.nodes);
        block
    }

    /// Adds the directions of a block that the space does not have; how many.
    fn append(&mut self, mut block: Vec<f64>) -> Result<usize, Error> {
        let rows = self.rows();
        let held = self.times_mass(&block);
        let before = inner(columns_of(&block, rows), columns_of(&held, rows));
        for _ in 0..2 {
            let held = self.times_mass(&block);
            let shares = inner(columns_of(&self.columns, rows), columns_of(&held, rows));
            let count = block.len() / rows;
            matmul(
                MatMut::from_column_major_slice_mut(&mut block, rows, count),
                Accum::Add,
                columns_of(&self.columns, rows),
                shares.as_ref(),
                -1.0,
                par(),
            );
        }
        let held = self.times_mass(&block);
        let left = inner(columns_of(&block, rows), columns_of(&held, rows));
        let largest = (0..before.ncols())
            .map(|k| before[(k, k)])
            .fold(0.0, f64::max);
        let room = self.factored.unknowns.n - self.len();
        let widest = (0..left.ncols()).map(|k| left[(k, k)]).fold(0.0, f64::max);
        let least = (NEW * largest).max(RELATIVE * widest);
        let mut found = normed(&block, &left, rows, least, room);
        if !found.is_empty() {
            // what was small has lost digits: once more, against the space and within
            let held = self.times_mass(&found);
            clear_columns(&mut found, &self.columns, &held, rows);
            let held = self.times_mass(&found);
            let again = inner(columns_of(&found, rows), columns_of(&held, rows));
            found = normed(&found, &again, rows, SOUND, room);
        }
        check_memory(
            self.nodes,
            (16 * (self.columns.len() + found.len())) as f64,
            MEMORY_LIMIT,
        )?;
        let count = found.len() / rows;
        self.columns.extend(found);
        Ok(count)
    }

    /// Squares of the lowest angular frequencies and their shapes.
    fn lowest(
        &mut self,
        count: usize,
        monitor: Monitor<'_>,
    ) -> Result<(Vec<f64>, Vec<f64>), Error> {
        let (rows, most) = (self.rows(), self.factored.unknowns.n);
        let start = self.random_block();
        // high frequencies are not looked for
        let mut block = self.apply(&start)?;
        // what the operator makes of the space, in the space
        let mut between = Mat::<f64>::zeros(0, 0);
        loop {
            let first = self.len();
            let mut added = self.append(block)?;
            if added == 0 {
                // the space is invariant: what else there is, is orthogonal to it
                let others = self.random_block();
                added = self.append(others)?;
            }
            poll(monitor, 4)?;
            let last = self.columns[first * rows..].to_vec();
            let moved = self.apply(&last)?;
            poll(monitor, 4)?;
            let held = self.times_mass(&moved);
            let part = inner(columns_of(&self.columns, rows), columns_of(&held, rows));
            let size = self.len();
            between = Mat::from_fn(size, size, |i, j| {
                if i < first && j < first {
                    between[(i, j)]
                } else if j >= first && i <= j {
                    part[(i, j - first)]
                } else {
                    part[(j, i - first)]
                }
            });
            let (vectors, values) = exact_eigen(&between);
            let mut rest = moved.clone();
            clear_columns(&mut rest, &self.columns, &held, rows);
            let rest_held = self.times_mass(&rest);
            let left = inner(columns_of(&rest, rows), columns_of(&rest_held, rows));
            let largest = values[size - 1];
            let residual = |k: usize| {
                let tail = |i: usize| vectors[(first + i, size - 1 - k)];
                let sum: f64 = (0..added)
                    .flat_map(|i| (0..added).map(move |j| (i, j)))
                    .map(|(i, j)| tail(i) * left[(i, j)] * tail(j))
                    .sum();
                sum.max(0.0).sqrt()
            };
            let is_found = |k: usize| {
                residual(k) <= (TOLERANCE * values[size - 1 - k]).max(ROUNDING * largest)
            };
            if size == most || (size >= count + BLOCK && (0..count).all(is_found)) {
                let turn = Mat::from_fn(size, count, |i, k| vectors[(i, size - 1 - k)]);
                let mut shapes = vec![0.0; rows * count];
                matmul(
                    MatMut::from_column_major_slice_mut(&mut shapes, rows, count),
                    Accum::Replace,
                    columns_of(&self.columns, rows),
                    turn.as_ref(),
                    1.0,
                    par(),
                );
                reset_workers();
                for shape in shapes.chunks_mut(rows) {
                    turned(shape);
                }
                let squares = (0..count).map(|k| 1.0 / values[size - 1 - k]).collect();
                return Ok((squares, shapes));
            }
            block = moved;
        }
    }
}

/// A shape with its largest component positive.
fn turned(shape: &mut [f64]) {
    let largest = shape.iter().copied().fold(0.0_f64, |most, u| {
        // a hair's breadth larger is not larger: keeps the choice independent of rounding
        if u.abs() > most.abs() * (1.0 + 1e-6) {
            u
        } else {
            most
        }
    });
    if largest < 0.0 {
        for u in shape.iter_mut() {
            *u = -*u;
        }
    }
}

/// Sums of the columns of a block whose products are `left`, orthonormal; of squares above `least`, `most` at most.
fn normed(block: &[f64], left: &Mat<f64>, rows: usize, least: f64, most: usize) -> Vec<f64> {
    let (vectors, squares) = exact_eigen(left);
    let kept: Vec<usize> = (0..squares.len())
        .rev()
        .filter(|&k| squares[k] > least)
        .take(most)
        .collect();
    let turn = Mat::from_fn(squares.len(), kept.len(), |i, k| {
        vectors[(i, kept[k])] / squares[kept[k]].sqrt()
    });
    let mut found = vec![0.0; rows * kept.len()];
    matmul(
        MatMut::from_column_major_slice_mut(&mut found, rows, kept.len()),
        Accum::Replace,
        columns_of(block, rows),
        turn.as_ref(),
        1.0,
        par(),
    );
    found
}

/// Takes what columns hold of orthonormal ones off them; `held` is their mass.
fn clear_columns(values: &mut [f64], columns: &[f64], held: &[f64], rows: usize) {
    let shares = inner(columns_of(columns, rows), columns_of(held, rows));
    let count = values.len() / rows;
    matmul(
        MatMut::from_column_major_slice_mut(values, rows, count),
        Accum::Add,
        columns_of(columns, rows),
        shares.as_ref(),
        -1.0,
        par(),
    );
}

/// Takes sums of a few `directions` off each of the columns, as large as their products with `duals`.
fn clear(values: &mut [f64], directions: &[f64], duals: &[f64], rows: usize) {
    values.par_chunks_mut(rows).for_each(|column| {
        for (direction, dual) in directions.chunks(rows).zip(duals.chunks(rows)) {
            let share = dot(column, dual);
            for (u, d) in column.iter_mut().zip(direction) {
                *u -= share * d;
            }
        }
    });
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

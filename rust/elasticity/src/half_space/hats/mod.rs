// SPDX-License-Identifier: MIT OR Apache-2.0
//! The half-space under bilinear pressures, in the weak form that fits finite elements.

mod correlation;
mod cut;
mod inverse;
mod lines;
mod moments;
mod product;

use std::sync::OnceLock;

use mtb_operator::{Compliance, Component, Grid, Map};
use rayon::prelude::*;

use super::body::{Placement, index, is_coupled};
use super::influence::point_load;
use super::{Neighbours, Patch};
use crate::{Error, Material};
pub use cut::{CutHats, HatShare};

use correlation::{VARIANTS, correlations, side, variant};
use moments::{POWERS, moments};
use product::Product;

/// An elastic half-space under tractions that are bilinear between the nodes of regular grids.
///
/// The traction is `sum_j p_j phi_j` with a hat `phi_j` about each node, cut at the edge of its patch;
/// the displacement of a node is the mean over the surface weighted with its own hat,
/// `u_i = int phi_i u dA / W_i`, `W_i = int phi_i dA`. So the compliance is symmetric in the product
/// weighted with `W`, as that of finite elements condensed on the same nodes is.
///
/// An entry is the integral of the point load's kernel against the correlation of two hats, a bicubic
/// polynomial on each of 4 x 4 cells of offsets, and is taken by quadrature that is right at the
/// singular point, to a relative accuracy of 1e-9. The matrices are made when
/// first needed, each from one table per pair of patches. From `DENSE_POINTS` points on a product goes by the
/// Fourier transform along x instead, and a matrix that is asked for is not kept. Points of several patches
/// follow one another.
pub struct HatHalfSpace {
    material: Material,
    patches: Vec<Patch>,
    starts: Vec<usize>,
    neighbours: Neighbours,
    blocks: [[OnceLock<Vec<f64>>; 3]; 3],
    products: [[OnceLock<Vec<Option<Product>>>; 3]; 3],
}

/// Points up to which dense matrices are kept, and multiply.
const DENSE_POINTS: usize = 2000;

impl HatHalfSpace {
    /// Half-space with patches of nodes; `Patch::x0`, `y0` are the first node, the grid counts nodes.
    ///
    /// # Errors
    /// [`Error::Material`], [`Error::Operator`], [`Error::NoPatch`], [`Error::PatchSpacing`],
    /// [`Error::NoCell`].
    pub fn new(
        material: Material,
        patches: Vec<Patch>,
        neighbours: Neighbours,
    ) -> Result<Self, Error> {
        let material = Material::new(material.shear_modulus, material.poisson_ratio)?;
        let starts = super::body::starts(&patches)?;
        for (patch, Patch { grid, .. }) in patches.iter().enumerate() {
            let Grid { nx, ny, .. } = *grid;
            if nx < 2 || ny < 2 {
                return Err(Error::NoCell { patch, nx, ny });
            }
        }
        Ok(Self {
            material,
            patches,
            starts,
            neighbours,
            blocks: Default::default(),
            products: Default::default(),
        })
    }

    /// Integral of every hat [m2]: a cell, half a cell at an edge of the patch, a quarter at a corner.
    pub fn weights(&self) -> Vec<f64> {
        let mut weights = Vec::with_capacity(self.points());
        for Patch { grid, .. } in &self.patches {
            for j in 0..grid.ny {
                for i in 0..grid.nx {
                    let half = |k: usize, n: usize| if k == 0 || k == n - 1 { 0.5 } else { 1.0 };
                    weights.push(half(i, grid.nx) * half(j, grid.ny) * grid.cell_area());
                }
            }
        }
        weights
    }

    /// The influence matrix [m/Pa], row = observed node, column = loaded node.
    fn block(&self, observed: Component, loaded: Component) -> &[f64] {
        self.blocks[index(observed)][index(loaded)].get_or_init(|| self.matrix(observed, loaded))
    }

    fn matrix(&self, observed: Component, loaded: Component) -> Vec<f64> {
        let n = self.points();
        let mut matrix = vec![0.0; n * n];
        if !is_coupled(&self.material, observed, loaded) {
            return matrix;
        }
        for target in 0..self.patches.len() {
            for source in 0..self.patches.len() {
                if self.acts(target, source) {
                    let pair = [target, source];
                    self.fill(&self.table(observed, loaded, pair), pair, &mut matrix);
                }
            }
        }
        for (row, w) in matrix.chunks_exact_mut(n).zip(self.weights()) {
            for a in row {
                *a /= w;
            }
        }
        matrix
    }

    /// Whether loads on one patch move another.
    fn acts(&self, target: usize, source: usize) -> bool {
        source == target || self.neighbours == Neighbours::Interact
    }

    /// The maps from patch to patch, the target's first.
    fn products(&self, observed: Component, loaded: Component) -> &[Option<Product>] {
        self.products[index(observed)][index(loaded)].get_or_init(|| {
            let k = self.patches.len();
            let is_coupled = is_coupled(&self.material, observed, loaded);
            let product = |pair: usize| {
                let [target, source] = [pair / k, pair % k];
                (is_coupled && self.acts(target, source))
                    .then(|| Product::new(&self.table(observed, loaded, [target, source])))
            };
            (0..k * k).map(product).collect()
        })
    }

    /// All values of `int phi_i u[phi_j] dA` for the nodes of one patch under loads on another.
    ///
    /// With the same spacing on both (their mean, see [`super::HalfSpace::with_patches`]) an entry depends on the offset of the two nodes and on which
    /// hats (whole, cut on the left, cut on the right) they carry along x and along y. So the moments of
    /// the kernel over all cells of offsets are summed first along x, then along y.
    fn table(&self, observed: Component, loaded: Component, [target, source]: [usize; 2]) -> Table {
        let (t, s) = (&self.patches[target], &self.patches[source]);
        let place = Placement::new(t, s);
        let cell = place.cell;
        let kernel = |x: f64, y: f64| point_load(&self.material, observed, loaded, [x, y]);
        let x = Offsets::new(place.shift[0], t.grid.nx, s.grid.nx, cell[0]);
        let y = Offsets::new(place.shift[1], t.grid.ny, s.grid.ny, cell[1]);

        // [y cell][power of y][x cell][power of x]
        let width = x.cells * POWERS;
        let mut table = vec![0.0; width * y.cells * POWERS];
        table
            .par_chunks_exact_mut(width * POWERS)
            .enumerate()
            .for_each(|(cy, rows)| {
                for cx in 0..x.cells {
                    let moments = moments(&kernel, [x.start(cx), y.start(cy)], cell);
                    for (row, moments) in rows.chunks_exact_mut(width).zip(moments) {
                        row[cx * POWERS..(cx + 1) * POWERS].copy_from_slice(&moments);
                    }
                }
            });
        // [y cell][power of y][x variant][x offset]
        let correlations = correlations();
        let along_x: Vec<f64> = table
            .par_chunks_exact(width)
            .flat_map_iter(|row| {
                correlations.iter().flat_map(move |weights| {
                    (0..x.nodes).map(move |node| dot(weights, &row[node * POWERS..]))
                })
            })
            .collect();
        // [y variant][y offset][x variant][x offset]
        let width = VARIANTS * x.nodes;
        // hats of mean size stand for hats of the target's and of the source's own
        let area = s.grid.cell_area() * t.grid.cell_area() / (cell[0] * cell[1]);
        let along_y: Vec<f64> = (0..VARIANTS * y.nodes)
            .into_par_iter()
            .flat_map_iter(|k| {
                let (variant, node) = (k / y.nodes, k % y.nodes);
                let mut sum = vec![0.0; width];
                for (row, weight) in along_x[node * POWERS * width..]
                    .chunks_exact(width)
                    .zip(&correlations[variant])
                {
                    if *weight != 0.0 {
                        for (sum, a) in sum.iter_mut().zip(row) {
                            *sum += area * weight * a;
                        }
                    }
                }
                sum
            })
            .collect();
        Table {
            target: [t.grid.nx, t.grid.ny],
            source: [s.grid.nx, s.grid.ny],
            nodes: [x.nodes, y.nodes],
            values: along_y,
        }
    }

    /// Fills a matrix over all points with the values of a [`HatHalfSpace::table`].
    fn fill(&self, table: &Table, [target, source]: [usize; 2], matrix: &mut [f64]) {
        let n = self.points();
        let (start_t, start_s) = (self.starts[target], self.starts[source]);
        let [nx, ny] = table.source;
        matrix[start_t * n..(start_t + table.target[0] * table.target[1]) * n]
            .par_chunks_exact_mut(n)
            .enumerate()
            .for_each(|(node, row)| {
                let to = [node % table.target[0], node / table.target[0]];
                let row = &mut row[start_s..start_s + nx * ny];
                for (sy, row) in row.chunks_exact_mut(nx).enumerate() {
                    for (sx, a) in row.iter_mut().enumerate() {
                        *a = table.at(to, [sx, sy]);
                    }
                }
            });
    }
}

/// What the hats of one patch do to those of another, for all offsets and all hats that end at an edge.
struct Table {
    /// Nodes `[nx, ny]` of the patch that is observed.
    target: [usize; 2],
    /// Nodes of the one that is loaded.
    source: [usize; 2],
    /// Offsets between them.
    nodes: [usize; 2],
    /// `[y variant][y offset][x variant][x offset]`.
    values: Vec<f64>,
}

impl Table {
    /// For the nodes `to` and `from`, each (column, row).
    fn at(&self, to: [usize; 2], from: [usize; 2]) -> f64 {
        let vx = variant(side(to[0], self.target[0]), side(from[0], self.source[0]));
        self.value(vx, to[0] + self.source[0] - 1 - from[0], to[1], from[1])
    }

    /// For the rows `to` and `from`, a variant of hats along x, and an offset counted from the first one.
    fn value(&self, vx: usize, offset: usize, to: usize, from: usize) -> f64 {
        let vy = variant(side(to, self.target[1]), side(from, self.source[1]));
        let row = vy * self.nodes[1] + to + self.source[1] - 1 - from;
        self.values[(row * VARIANTS + vx) * self.nodes[0] + offset]
    }
}

/// Offsets along one direction between two rows of nodes.
#[derive(Clone, Copy)]
struct Offsets {
    /// Number of node offsets, `-(source - 1) ..= target - 1`.
    nodes: usize,
    /// Number of cells that the correlations about these reach.
    cells: usize,
    first: f64,
    step: f64,
}

impl Offsets {
    fn new(shift: f64, target: usize, source: usize, step: f64) -> Self {
        let nodes = target + source - 1;
        Self {
            nodes,
            cells: nodes + 3,
            first: shift - (source + 1) as f64 * step,
            step,
        }
    }

    /// Offset at which a cell starts.
    fn start(&self, cell: usize) -> f64 {
        let start = self.first + cell as f64 * self.step;
        // the singular point lies at a corner, not a rounding error beside it
        if start.abs() < 1e-9 * self.step {
            0.0
        } else {
            start
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Adds `scale` times a block to `matrix`.
fn add_scaled(block: &[f64], scale: f64, matrix: &mut [f64]) {
    for (a, b) in matrix.iter_mut().zip(block) {
        *a += scale * b;
    }
}

/// Adds `scale` times the product of a block, kept row by row, with `traction`.
fn add_product(block: &[f64], scale: f64, traction: &[f64], displacement: &mut [f64]) {
    for (u, row) in displacement
        .iter_mut()
        .zip(block.chunks_exact(traction.len()))
    {
        *u += scale * dot(row, traction);
    }
}

impl Compliance for HatHalfSpace {
    fn points(&self) -> usize {
        self.starts[self.patches.len()]
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        if self.points() <= DENSE_POINTS {
            add_product(self.block(observed, loaded), scale, traction, displacement);
            return;
        }
        let k = self.patches.len();
        let mut moved = vec![0.0; self.points()];
        for (pair, product) in self.products(observed, loaded).iter().enumerate() {
            let part = |patch: usize| self.starts[patch]..self.starts[patch + 1];
            if let Some(product) = product {
                product.add(&traction[part(pair % k)], &mut moved[part(pair / k)]);
            }
        }
        for ((u, moved), w) in displacement.iter_mut().zip(moved).zip(self.weights()) {
            *u += scale * moved / w;
        }
    }

    fn reciprocity(&self) -> Option<Vec<f64>> {
        Some(self.weights())
    }

    fn near_inverse(&self, softer: f64) -> Option<Map> {
        let maps: Vec<Map> = self
            .patches
            .iter()
            .map(|patch| inverse::near_inverse(&self.material, patch.grid, softer))
            .collect();
        let starts = self.starts.clone();
        Some(Box::new(move |x: &[f64], y: &mut [f64]| {
            for (map, ends) in maps.iter().zip(starts.windows(2)) {
                map(&x[ends[0]..ends[1]], &mut y[ends[0]..ends[1]]);
            }
        }))
    }

    fn influence_memory(&self) -> f64 {
        8.0 * (self.points() as f64).powi(2)
    }

    fn add_influence(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        matrix: &mut [f64],
    ) {
        if self.points() <= DENSE_POINTS {
            add_scaled(self.block(observed, loaded), scale, matrix);
        } else {
            add_scaled(&self.matrix(observed, loaded), scale, matrix);
        }
    }
}

#[cfg(test)]
mod tests;

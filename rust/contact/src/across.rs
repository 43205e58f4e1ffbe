// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rows of cells that move each other in another way than on half-spaces: on bodies that are alike along the rows
//! only, such as rails.

use mtb_operator::{Compliance, Component, Convolution, Grid, RowConvolution};

/// Displacements [m/Pa] of the lower body relative to the upper one, beside those of half-spaces, by tractions on cells
/// that lie `offsets` [m] behind them along x: `[offset][3 observed + loaded][observed row][loaded row]`, components x,
/// y and into the lower body. The tractions act on the lower body and turned round on the upper one, the pressure on
/// both.
pub type RowInfluence<'a> = &'a (dyn Fn(&[f64]) -> Vec<f64> + Sync);

/// Products with a [`RowInfluence`] on the cells of a grid: by the Fourier transform along the rows, dense across them.
pub struct Across {
    points: usize,
    /// Of each observed component, by x, y and pressure.
    maps: Vec<[RowConvolution; 3]>,
}

impl Across {
    /// Of the `observed` components (0, 1, 2: x, y, into the lower body), as a sum of `terms`: a factor, and the distance
    /// [m] by which displacements are seen ahead of the cells.
    pub fn new(
        grid: Grid,
        influence: RowInfluence<'_>,
        terms: &[(f64, f64)],
        observed: &[usize],
    ) -> Self {
        let (nx, ny) = (grid.nx, grid.ny);
        let first = 1 - nx as isize;
        let mut sums: Vec<f64> = Vec::new();
        for (factor, ahead) in terms {
            let offsets: Vec<f64> = (first..nx as isize)
                .map(|i| i as f64 * grid.dx + ahead)
                .collect();
            let values = influence(&offsets);
            sums.resize(values.len(), 0.0);
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += factor * value;
            }
        }
        let map = |o: usize, l: usize| {
            RowConvolution::new([nx, ny], [nx, ny], |t, s, offset| {
                sums[(((offset - first) as usize * 9 + 3 * o + l) * ny + t) * ny + s]
            })
        };
        Self {
            points: grid.points(),
            maps: observed
                .iter()
                .map(|o| [0, 1, 2].map(|l| map(*o, l)))
                .collect(),
        }
    }

    /// Adds `scale` times the weights of tractions along x and y and of the pressure, as far as they are wanted, that
    /// weights of the observed displacements, one component after the other, are: the transpose of [`Across::add`].
    pub fn add_transposed(&self, scale: f64, weights: &[f64], loads: [Option<&mut [f64]>; 3]) {
        for (l, load) in loads.into_iter().enumerate() {
            let Some(load) = load else { continue };
            for (maps, weights) in self.maps.iter().zip(weights.chunks_exact(self.points)) {
                maps[l].apply_transposed_add(scale, weights, load);
            }
        }
    }

    /// Adds `scale` times the observed displacements, one component after the other, by tractions along x and y and a
    /// pressure (n each), as far as they are given.
    pub fn add(&self, scale: f64, loads: [Option<&[f64]>; 3], moved: &mut [f64]) {
        for (maps, moved) in self.maps.iter().zip(moved.chunks_exact_mut(self.points)) {
            for (map, load) in maps.iter().zip(loads) {
                if let Some(load) = load {
                    map.apply_add(scale, load, moved);
                }
            }
        }
    }
}

/// The normal displacement of two bodies by a pressure: that of half-spaces, and what rows do besides.
pub struct Pressed<'a> {
    half_spaces: Convolution,
    across: &'a Across,
}

impl<'a> Pressed<'a> {
    /// On the cells of a grid: `rectangle` as of [`Surface::FreeSpace`](crate::normal::Surface::FreeSpace), and the
    /// displacements `across` into the lower body.
    pub fn new(
        grid: Grid,
        rectangle: impl Fn([f64; 2], [f64; 2]) -> f64 + Sync,
        across: &'a Across,
    ) -> Self {
        let half_spaces = Convolution::even([grid.nx, grid.ny], |i, j| {
            let offset = [i as f64 * grid.dx, j as f64 * grid.dy];
            rectangle(offset, [grid.dx, grid.dy])
        });
        Self {
            half_spaces,
            across,
        }
    }
}

impl Compliance for Pressed<'_> {
    fn points(&self) -> usize {
        self.across.points
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        if (observed, loaded) == (Component::Normal, Component::Normal) {
            self.half_spaces.apply_add(scale, traction, displacement);
            self.across
                .add(scale, [None, None, Some(traction)], displacement);
        }
    }

    fn prefers_products(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn adds_what_each_cell_does_to_each_other() {
        let grid = Grid::new(5, 3, 2e-3, 1e-3).unwrap();
        let value = |along: f64, o: usize, l: usize, i: usize, j: usize| {
            let rows = 1.0 + i as f64 - 0.3 * j as f64 + 0.1 * (3 * o + l) as f64;
            rows / (1.0 + (along / 1e-3 - 0.4).powi(2))
        };
        let influence = |offsets: &[f64]| -> Vec<f64> {
            let mut all = Vec::new();
            for along in offsets {
                for k in 0..81 {
                    let (block, pair) = (k / 9, k % 9);
                    all.push(value(*along, block / 3, block % 3, pair / 3, pair % 3));
                }
            }
            all
        };
        let terms = [(2.0, 0.0), (-0.5, 1e-3)];
        let across = Across::new(grid, &influence, &terms, &[0, 2]);
        let load: Vec<f64> = (0..15).map(|k| f64::from((7 * k) % 5) - 1.5).collect();
        let pressure: Vec<f64> = load.iter().map(|v| v * v).collect();
        let mut moved = vec![1.0; 30];
        across.add(3.0, [Some(&load), None, Some(&pressure)], &mut moved);
        for (k, moved) in moved.iter().enumerate() {
            let (o, i) = ([0, 2][k / 15], k % 15);
            let mut expected = 1.0;
            for j in 0..15 {
                let along = ((i % 5) as f64 - (j % 5) as f64) * 2e-3;
                for (factor, ahead) in terms {
                    for (l, load) in [(0, &load), (2, &pressure)] {
                        let each = value(along + ahead, o, l, i / 5, j / 5);
                        expected += 3.0 * factor * each * load[j];
                    }
                }
            }
            assert!((moved - expected).abs() < 1e-12 * expected.abs().max(1.0));
        }
        // <w, A q> = <A^T w, q>
        let weights: Vec<f64> = (0..30).map(|k| f64::from((5 * k) % 7) - 2.0).collect();
        let (mut along, mut normal) = (vec![0.0; 15], vec![0.0; 15]);
        across.add_transposed(3.0, &weights, [Some(&mut along), None, Some(&mut normal)]);
        let product = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let there = product(&weights, &moved) - weights.iter().sum::<f64>();
        let back = product(&along, &load) + product(&normal, &pressure);
        assert!((there - back).abs() < 1e-12 * there.abs());
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use std::sync::Arc;

use mtb_operator::{Compliance, Component, Grid, Monitor};
use rayon::prelude::*;

use super::Prism;
use super::line::{gauss, index};
use super::rows::{Basis, Beside, Rows, Spectrum, edges_between, turned};
use crate::Error;
use crate::half_space::{HalfSpace, HatHalfSpace, Neighbours, Patch};

/// A contact grid on the surface of a prism, its columns along the axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// Nodes under hats, or cells.
    pub patch: Patch,
    /// y [m] in the section of its rows of nodes, or of the borders of its rows of cells.
    pub lines: Vec<f64>,
}

/// One wave number, with all rows.
struct Wave {
    beside: Beside,
    /// Integrals of the functions of x times cos and sin, one list for each strip.
    along: Vec<[Vec<f64>; 2]>,
}

/// A prism under contact grids: a half-space in closed form, and the smooth rest as waves.
///
/// Products take as many operations as grid points times wave numbers, and no Fourier transform: there are fewer waves
/// than points along the contact.
pub struct PrismCompliance {
    half_space: Arc<dyn Compliance>,
    patches: Vec<Patch>,
    areas: Vec<f64>,
    /// First row and first point of each strip, and the numbers of all.
    starts: Vec<[usize; 2]>,
    /// Integrals of the functions of x of each strip [m].
    widths: Vec<Vec<f64>>,
    waves: Vec<Wave>,
    tail: f64,
    largest: f64,
}

impl PrismCompliance {
    /// Under tractions that are bilinear between the nodes of the strips, on edges `surface` of the section.
    ///
    /// # Errors
    /// [`Error::Section`] where the lines of a strip are no nodes of these edges, or the prism is not held; those of
    /// half-spaces; [`Error::Interrupted`].
    pub fn under_hats(
        prism: &Prism,
        surface: &[[usize; 3]],
        strips: &[Strip],
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let patches = strips.iter().map(|s| s.patch).collect();
        let half_space = HatHalfSpace::new(prism.material(), patches, Neighbours::Interact)?;
        let areas = half_space.weights();
        Self::new(
            prism,
            surface,
            strips,
            Basis::Hats,
            Arc::new(half_space),
            areas,
            monitor,
        )
    }

    /// Under uniform tractions on the cells of the strips; displacements are those of their middles.
    ///
    /// # Errors
    /// As of [`PrismCompliance::under_hats`].
    pub fn under_cells(
        prism: &Prism,
        surface: &[[usize; 3]],
        strips: &[Strip],
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let patches: Vec<Patch> = strips.iter().map(|s| s.patch).collect();
        let areas = patches
            .iter()
            .flat_map(|p| std::iter::repeat_n(p.grid.cell_area(), p.grid.points()))
            .collect();
        let half_space = HalfSpace::with_patches(prism.material(), patches, Neighbours::Interact)?;
        Self::new(
            prism,
            surface,
            strips,
            Basis::Cells,
            Arc::new(half_space),
            areas,
            monitor,
        )
    }

    fn new(
        prism: &Prism,
        surface: &[[usize; 3]],
        strips: &[Strip],
        basis: Basis,
        half_space: Arc<dyn Compliance>,
        areas: Vec<f64>,
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let patches: Vec<Patch> = strips.iter().map(|s| s.patch).collect();
        let edges: Result<Vec<_>, Error> = strips
            .iter()
            .map(|strip| edges_between(prism, surface, &strip.lines))
            .collect();
        let rows = Rows::new(prism, &edges?, &patches, basis)?;
        let mut starts = vec![[0, 0]];
        for Patch { grid, .. } in &patches {
            let [row, point] = starts[starts.len() - 1];
            starts.push([row + grid.ny, point + grid.points()]);
        }
        let ends = patches
            .iter()
            .map(|p| [p.x0, p.x0 + p.grid.dx * p.grid.nx as f64]);
        let span = ends.clone().map(|e| e[1]).fold(f64::MIN, f64::max)
            - ends.map(|e| e[0]).fold(f64::MAX, f64::min);
        let Spectrum {
            waves,
            largest,
            tail,
        } = rows.spectrum(prism, span, monitor)?;
        let waves = waves
            .into_par_iter()
            .map(|beside| Wave {
                along: patches
                    .iter()
                    .map(|p| moments(p, beside.number, basis))
                    .collect(),
                beside,
            })
            .collect();
        Ok(Self {
            half_space,
            widths: patches.iter().map(|p| widths(p.grid, basis)).collect(),
            patches,
            areas,
            starts,
            waves,
            tail,
            largest,
        })
    }

    /// Number of waves, the largest wave number [1/m], and the share that the last of them add to the displacement of
    /// any row of points by its own load [-].
    pub fn waves(&self) -> (usize, f64, f64) {
        (self.waves.len(), self.largest, self.tail)
    }

    fn rows(&self) -> usize {
        self.starts[self.patches.len()][0]
    }

    /// Numbers of points and of rows of a strip.
    fn shape(&self, strip: usize) -> [usize; 2] {
        let grid = self.patches[strip].grid;
        [grid.nx, grid.ny]
    }
}

impl Compliance for PrismCompliance {
    fn points(&self) -> usize {
        self.areas.len()
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        self.half_space
            .add_displacement(observed, loaded, scale, traction, displacement);
        let m = self.rows();
        let block = (3 * index(observed) + index(loaded)) * m * m;
        for wave in &self.waves {
            let mut amounts = [vec![0.0; m], vec![0.0; m]];
            for (s, along) in wave.along.iter().enumerate() {
                let ([nx, ny], [row, point]) = (self.shape(s), self.starts[s]);
                for j in 0..ny {
                    let load = &traction[point + j * nx..][..nx];
                    for (amount, along) in amounts.iter_mut().zip(along) {
                        amount[row + j] = load.iter().zip(along).map(|(p, a)| p * a).sum();
                    }
                }
            }
            let matrix = &wave.beside.difference[block..block + m * m];
            let weight = scale * wave.beside.weight;
            let answers = amounts.map(|amount| -> Vec<f64> {
                let rows = matrix.chunks_exact(m);
                rows.map(|row| weight * row.iter().zip(&amount).map(|(d, a)| d * a).sum::<f64>())
                    .collect()
            });
            let [c, s] = answers;
            let (of_cos, of_sin): (Vec<f64>, Vec<f64>) = match turned(observed, loaded) {
                None => (c, s),
                Some(sign) => (
                    s.iter().map(|v| -sign * v).collect(),
                    c.iter().map(|v| sign * v).collect(),
                ),
            };
            for (t, [cos, sin]) in wave.along.iter().enumerate() {
                let ([nx, ny], [row, point]) = (self.shape(t), self.starts[t]);
                for j in 0..ny {
                    let (c, s) = (of_cos[row + j], of_sin[row + j]);
                    let moved = &mut displacement[point + j * nx..][..nx];
                    for ((u, cos), (sin, width)) in moved
                        .iter_mut()
                        .zip(cos)
                        .zip(sin.iter().zip(&self.widths[t]))
                    {
                        *u += (c * cos + s * sin) / width;
                    }
                }
            }
        }
    }

    fn reciprocity(&self) -> Option<Vec<f64>> {
        Some(self.areas.clone())
    }

    fn add_influence(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        matrix: &mut [f64],
    ) {
        self.half_space
            .add_influence(observed, loaded, scale, matrix);
        let (m, n) = (self.rows(), self.points());
        let block = (3 * index(observed) + index(loaded)) * m * m;
        for t in 0..self.patches.len() {
            let ([nx, ny], [row, point]) = (self.shape(t), self.starts[t]);
            let widths = &self.widths[t];
            let own = &mut matrix[point * n..(point + nx * ny) * n];
            own.par_chunks_exact_mut(n)
                .enumerate()
                .for_each(|(k, out)| {
                    let (i, j) = (k % nx, row + k / nx);
                    for wave in &self.waves {
                        let [cos, sin] = [wave.along[t][0][i], wave.along[t][1][i]];
                        let (of_cos, of_sin) = match turned(observed, loaded) {
                            None => (cos, sin),
                            Some(sign) => (sign * sin, -sign * cos),
                        };
                        let weight = scale * wave.beside.weight / widths[i];
                        for (s, along) in wave.along.iter().enumerate() {
                            let ([sx, sy], [first, start]) = (self.shape(s), self.starts[s]);
                            for from in 0..sy {
                                let d =
                                    weight * wave.beside.difference[block + j * m + first + from];
                                let (c, s) = (d * of_cos, d * of_sin);
                                let out = &mut out[start + from * sx..][..sx];
                                for ((a, cos), sin) in out.iter_mut().zip(&along[0]).zip(&along[1])
                                {
                                    *a += c * cos + s * sin;
                                }
                            }
                        }
                    }
                });
        }
    }
}

/// Integrals of the functions of x of a grid [m].
fn widths(grid: Grid, basis: Basis) -> Vec<f64> {
    let is_end = |i: usize| basis == Basis::Hats && (i == 0 || i + 1 == grid.nx);
    let share = |i: usize| if is_end(i) { 0.5 } else { 1.0 };
    (0..grid.nx).map(|i| share(i) * grid.dx).collect()
}

/// Integrals of the functions of x of a grid times cos(k x) and sin(k x).
fn moments(patch: &Patch, wave_number: f64, basis: Basis) -> [Vec<f64>; 2] {
    let (nx, dx) = (patch.grid.nx, patch.grid.dx);
    let mut out = [vec![0.0; nx], vec![0.0; nx]];
    let [cos, sin] = &mut out;
    for i in 0..nx {
        let x = patch.x0 + i as f64 * dx;
        let mut add = |from: f64, to: f64, value: &dyn Fn(f64) -> f64| {
            for (at, weight) in gauss(from, to) {
                cos[i] += weight * value(at) * (wave_number * at).cos();
                sin[i] += weight * value(at) * (wave_number * at).sin();
            }
        };
        match basis {
            Basis::Cells => add(x - 0.5 * dx, x + 0.5 * dx, &|_| 1.0),
            Basis::Hats => {
                if i > 0 {
                    add(x - dx, x, &|at| (at - x) / dx + 1.0);
                }
                if i + 1 < nx {
                    add(x, x + dx, &|at| 1.0 - (at - x) / dx);
                }
            }
        }
    }
    out
}

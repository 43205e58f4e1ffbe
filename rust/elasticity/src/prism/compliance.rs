// SPDX-License-Identifier: MIT OR Apache-2.0
use std::collections::HashMap;
use std::sync::Arc;

use mtb_operator::{Compliance, Component, Grid, Monitor, report};
use rayon::prelude::*;

use super::Prism;
use super::line::{Shape, distances, gauss, hat, index, pair, strip};
use super::stiffness::Sparse;
use crate::half_space::{HalfSpace, HatHalfSpace, Neighbours, Patch};
use crate::{Error, Material};

/// Growth of the ranges of wave numbers, while waves are long against the contact.
const GROWTH: f64 = 6.0;
/// Largest turn of a wave over the length of the contacts within a range: its eight points resolve it to 1e-6.
const TURN: f64 = 8.0;
/// Share of the own displacement of any row below which a range of waves ends the sum.
const NEGLIGIBLE: f64 = 1e-3;
/// Share of a line spacing by which the lines of a strip may miss the nodes of the section.
const MISSED: f64 = 1e-3;

/// A contact grid on the surface of a prism, its columns along the axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// Nodes under hats, or cells.
    pub patch: Patch,
    /// y [m] in the section of its rows of nodes, or of the borders of its rows of cells.
    pub lines: Vec<f64>,
}

/// Functions of y that the rows carry.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Basis {
    Hats,
    Cells,
}

/// One wave number, with all rows.
struct Wave {
    /// Weight of the integral over it, over pi.
    weight: f64,
    /// `S(k)` less that of a half-space over the areas per length of the observed rows: `[3 observed + loaded][observed row][loaded row]`.
    difference: Vec<f64>,
    /// Integrals of the functions of x times cos and sin, one list for each strip.
    along: Vec<[Vec<f64>; 2]>,
}

/// `[S, S - S_h]` of each row on itself, component by component.
type Shares = Vec<[f64; 2]>;

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
        let rows = Rows::new(prism, surface, strips, basis)?;
        let patches: Vec<Patch> = strips.iter().map(|s| s.patch).collect();
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
        let finest = patches.iter().map(|p| p.grid.dx).fold(f64::MAX, f64::min);
        let last = 2.0 * std::f64::consts::PI / finest;
        let (mut from, mut to) = (0.0, prism.slowest().min(last));
        let mut waves: Vec<Wave> = Vec::new();
        let mut own = vec![0.0; 3 * rows.shapes.len()];
        let mut tail = 1.0;
        let mut step = 0;
        loop {
            report(monitor, step, tail).map_err(|_| Error::Interrupted)?;
            let points: Vec<(f64, f64)> = gauss(from, to).collect();
            let solved: Result<Vec<(Wave, Shares)>, Error> = points
                .par_iter()
                .map(|(k, weight)| {
                    let (difference, diagonal) = rows.difference(prism, *k)?;
                    let along = patches.iter().map(|p| moments(p, *k, basis)).collect();
                    let weight = weight / std::f64::consts::PI;
                    Ok((
                        Wave {
                            weight,
                            difference,
                            along,
                        },
                        diagonal,
                    ))
                })
                .collect();
            tail = 0.0;
            let mut added = vec![0.0; own.len()];
            for (wave, diagonal) in solved? {
                for (k, [whole, part]) in diagonal.iter().enumerate() {
                    let strip = rows.strip[k % rows.shapes.len()];
                    // of a column in the middle of the strip, on itself
                    let [c, s] = &wave.along[strip];
                    let middle = c.len() / 2;
                    let shape = c[middle].powi(2) + s[middle].powi(2);
                    own[k] += wave.weight * shape * whole;
                    added[k] += wave.weight * shape * part;
                }
                waves.push(wave);
            }
            for (added, own) in added.iter().zip(&own) {
                tail = f64::max(tail, (added / own).abs());
            }
            step += 1;
            if to >= last || (tail < NEGLIGIBLE && step > 2) {
                break;
            }
            let wide = to + TURN / span;
            let next = if from == 0.0 {
                GROWTH * to
            } else {
                to * to / from
            };
            (from, to) = (to, next.min(wide).max(to * 1.01).min(last));
        }
        Ok(Self {
            half_space,
            widths: patches.iter().map(|p| widths(p.grid, basis)).collect(),
            patches,
            areas,
            starts,
            waves,
            tail,
            largest: to,
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

/// Whether the amplitude of the displacement goes with that of the traction, or a quarter of a wave beside it: the
/// signs of sin and cos in the product.
fn turned(observed: Component, loaded: Component) -> Option<f64> {
    match (observed == Component::X, loaded == Component::X) {
        (true, false) => Some(-1.0),
        (false, true) => Some(1.0),
        _ => None,
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
            let matrix = &wave.difference[block..block + m * m];
            let weight = scale * wave.weight;
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
                        let weight = scale * wave.weight / widths[i];
                        for (s, along) in wave.along.iter().enumerate() {
                            let ([sx, sy], [first, start]) = (self.shape(s), self.starts[s]);
                            for from in 0..sy {
                                let d = weight * wave.difference[block + j * m + first + from];
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

/// Rows of all strips, one after the other.
struct Rows {
    material: Material,
    /// Functions of the place in the plane of the half-space.
    shapes: Vec<Shape>,
    /// Integrals of these [m].
    widths: Vec<f64>,
    strip: Vec<usize>,
    /// Loads along x, across and into the body on the unknowns, component by component.
    loads: Vec<Sparse>,
    /// Quadrature of each pair, found once where rows lie alike.
    quadratures: Vec<Vec<(f64, f64)>>,
    /// The quadrature of each pair of rows.
    of_pair: Vec<usize>,
}

impl Rows {
    fn new(
        prism: &Prism,
        surface: &[[usize; 3]],
        strips: &[Strip],
        basis: Basis,
    ) -> Result<Self, Error> {
        let (mut shapes, mut widths, mut strip_of) = (Vec::new(), Vec::new(), Vec::new());
        let mut kinds = Vec::new();
        let mut loads: [Vec<Sparse>; 3] = Default::default();
        for (number, Strip { patch, lines }) in strips.iter().enumerate() {
            let ny = patch.grid.ny;
            let expected = if basis == Basis::Hats { ny } else { ny + 1 };
            if lines.len() != expected {
                return Err(Error::Shape {
                    name: "lines of a strip",
                    found: lines.len(),
                    expected,
                });
            }
            let place = |row: usize| patch.y0 + row as f64 * patch.grid.dy;
            for row in 0..ny {
                let own = place(row);
                let (shape, kind) = match basis {
                    Basis::Cells => {
                        let half = 0.5 * patch.grid.dy;
                        (strip(own - half, own + half), 0)
                    }
                    Basis::Hats => {
                        let before = (row > 0).then(|| place(row - 1));
                        let after = (row + 1 < ny).then(|| place(row + 1));
                        let kind = usize::from(before.is_none()) + 2 * usize::from(after.is_none());
                        (hat(before, own, after), kind)
                    }
                };
                let half = if basis == Basis::Hats && (row == 0 || row + 1 == ny) {
                    0.5
                } else {
                    1.0
                };
                widths.push(half * patch.grid.dy);
                shapes.push(shape);
                strip_of.push(number);
                kinds.push((number, kind, own));
            }
            let own = strip_loads(prism, surface, lines, basis, patch.grid.dy)?;
            for (all, own) in loads.iter_mut().zip(own) {
                all.extend(own);
            }
        }
        let m = shapes.len();
        let mut known: HashMap<(usize, usize, usize, usize, i64), usize> = HashMap::new();
        let (mut quadratures, mut of_pair) = (Vec::new(), Vec::with_capacity(m * m));
        let finest = strips
            .iter()
            .map(|s| s.patch.grid.dy)
            .fold(f64::MAX, f64::min);
        for i in 0..m {
            for j in 0..m {
                let ((s, a, y), (t, b, z)) = (kinds[i], kinds[j]);
                let apart = ((y - z) / (1e-6 * finest)).round() as i64;
                let at = *known.entry((s, a, t, b, apart)).or_insert_with(|| {
                    quadratures.push(distances(&shapes[i], &shapes[j]));
                    quadratures.len() - 1
                });
                of_pair.push(at);
            }
        }
        Ok(Self {
            material: prism.material(),
            shapes,
            widths,
            strip: strip_of,
            loads: loads.concat(),
            quadratures,
            of_pair,
        })
    }

    /// The blocks of `S(k) - S_h(k)` over the widths of the observed rows, and `[S, S - S_h]` of each row on itself,
    /// component by component.
    fn difference(&self, prism: &Prism, wave_number: f64) -> Result<(Vec<f64>, Shares), Error> {
        let m = self.shapes.len();
        let body = prism.compliance(wave_number, &self.loads)?;
        let pairs: Vec<[[f64; 3]; 3]> = self
            .quadratures
            .iter()
            .map(|points| pair(&self.material, wave_number, points))
            .collect();
        let mut blocks = vec![0.0; 9 * m * m];
        let mut diagonal = vec![[0.0; 2]; 3 * m];
        for o in 0..3 {
            for l in 0..3 {
                for i in 0..m {
                    for j in 0..m {
                        let whole = body[(o * m + i, l * m + j)];
                        let part = whole - pairs[self.of_pair[i * m + j]][o][l];
                        if o == l && i == j {
                            diagonal[o * m + i] = [whole, part];
                        }
                        blocks[((3 * o + l) * m + i) * m + j] = part / self.widths[i];
                    }
                }
            }
        }
        Ok((blocks, diagonal))
    }
}

/// Loads of the rows of one strip by unit tractions along x, across, and into the body.
pub(super) fn strip_loads(
    prism: &Prism,
    surface: &[[usize; 3]],
    lines: &[f64],
    basis: Basis,
    dy: f64,
) -> Result<[Vec<Sparse>; 3], Error> {
    let rows = if basis == Basis::Hats {
        lines.len()
    } else {
        lines.len() - 1
    };
    let mut loads: [Vec<Sparse>; 3] = [0, 1, 2].map(|_| vec![Sparse::new(); rows]);
    for interval in 0..lines.len() - 1 {
        let (from, to) = (lines[interval], lines[interval + 1]);
        let near = MISSED * (to - from);
        let mut edges = Vec::new();
        for edge in surface {
            let [a, b] = [prism.place(edge[0])?[0], prism.place(edge[1])?[0]];
            if a > from - near && b < to + near {
                edges.push((*edge, prism.edge_points(edge)?));
            }
        }
        let missed = "the lines of a contact strip are no nodes of its surface";
        let (Some((first, _)), Some((last, _))) = (edges.first(), edges.last()) else {
            return Err(Error::Section(missed));
        };
        let ends = [
            prism.place(first[0])?[0] - from,
            prism.place(last[1])?[0] - to,
        ];
        if ends.iter().any(|e| e.abs() > near) {
            return Err(Error::Section(missed));
        }
        let lengths: Vec<f64> = edges
            .iter()
            .map(|(_, p)| p.iter().map(|p| p.length).sum())
            .collect();
        let total: f64 = lengths.iter().sum();
        if (total - dy).abs() > 0.05 * dy {
            return Err(Error::Section(
                "the rows of a contact strip are not evenly spaced along its surface",
            ));
        }
        let mut before = 0.0;
        for ((edge, points), length) in edges.iter().zip(&lengths) {
            for point in points {
                let share = (before + point.share * length) / total;
                let weight = point.length * dy / total;
                let rows: [(usize, f64); 2] = match basis {
                    Basis::Hats => [(interval, 1.0 - share), (interval + 1, share)],
                    Basis::Cells => [(interval, 1.0), (interval, 0.0)],
                };
                let [y, z] = point.tangent;
                for (row, value) in rows {
                    for (node, shape) in edge.iter().zip(point.value) {
                        let amount = weight * value * shape;
                        let own = [0, 1, 2].map(|c| prism.unknown(*node, c));
                        let mut put = |load: usize, unknown: usize, factor: f64| {
                            if let Some(at) = own[unknown] {
                                loads[load][row].push((at, factor * amount));
                            }
                        };
                        put(0, 0, 1.0);
                        put(1, 1, y);
                        put(1, 2, z);
                        put(2, 1, z);
                        put(2, 2, -y);
                    }
                }
            }
            before += length;
        }
    }
    for load in loads.iter_mut().flatten() {
        load.sort_by_key(|(unknown, _)| *unknown);
        let mut summed = Sparse::new();
        for (unknown, value) in load.iter() {
            match summed.last_mut() {
                Some((last, sum)) if last == unknown => *sum += value,
                _ => summed.push((*unknown, *value)),
            }
        }
        *load = summed;
    }
    Ok(loads)
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

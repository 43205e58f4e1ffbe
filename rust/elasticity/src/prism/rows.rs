// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rows of points along a prism, wave by wave: what they move beside a half-space.

use std::collections::HashMap;

use mtb_operator::{Component, Monitor, report};
use rayon::prelude::*;

use super::Prism;
use super::line::{Shape, distances, gauss, hat, pair, strip};
use super::stiffness::Sparse;
use crate::half_space::Patch;
use crate::{Error, Material};

/// Growth of the ranges of wave numbers, while waves are long against the contact.
const GROWTH: f64 = 6.0;
/// Largest turn of a wave over the length of the contacts within a range: its eight points resolve it to 1e-6.
const TURN: f64 = 11.0;
/// Share of the own displacement of any row below which a range of waves ends the sum.
const NEGLIGIBLE: f64 = 1e-3;
/// Share of a line spacing by which the lines of a strip may miss the nodes of the section.
const MISSED: f64 = 1e-3;

/// Functions of y that the rows carry.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Basis {
    Hats,
    Cells,
}

/// Edges of the section in each interval between two lines of a strip.
pub(super) type Intervals = Vec<Vec<[usize; 3]>>;

/// What rows move each other by beside a half-space, at one wave number.
pub(super) struct Beside {
    /// Wave number [1/m].
    pub(super) number: f64,
    /// Weight of the integral over it, over pi.
    pub(super) weight: f64,
    /// `S(k)` less that of a half-space over the areas per length of the observed rows:
    /// `[3 observed + loaded][observed row][loaded row]`.
    pub(super) difference: Vec<f64>,
}

/// All wave numbers that count.
pub(super) struct Spectrum {
    pub(super) waves: Vec<Beside>,
    /// The largest wave number [1/m].
    pub(super) largest: f64,
    /// Share of the own displacement of any row that the last range of waves adds, or that shorter waves might.
    pub(super) tail: f64,
}

/// `[S, S - S_h]` of each row on itself, component by component.
type Shares = Vec<[f64; 2]>;

/// Whether the amplitude of the displacement goes with that of the traction, or a quarter of a wave beside it: the
/// signs of sin and cos in the product.
pub(super) fn turned(observed: Component, loaded: Component) -> Option<f64> {
    match (observed == Component::X, loaded == Component::X) {
        (true, false) => Some(-1.0),
        (false, true) => Some(1.0),
        _ => None,
    }
}

/// Rows of all strips, one after the other.
pub(super) struct Rows {
    material: Material,
    basis: Basis,
    /// Distances [m] of the columns of each strip.
    columns: Vec<f64>,
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
    pub(super) fn new(
        prism: &Prism,
        edges: &[Intervals],
        patches: &[Patch],
        basis: Basis,
    ) -> Result<Self, Error> {
        let (mut shapes, mut widths, mut strip_of) = (Vec::new(), Vec::new(), Vec::new());
        let mut kinds = Vec::new();
        let mut loads: [Vec<Sparse>; 3] = Default::default();
        for (number, (patch, intervals)) in patches.iter().zip(edges).enumerate() {
            let ny = patch.grid.ny;
            let lines = |intervals: usize| intervals + 1;
            let expected = if basis == Basis::Hats { ny } else { ny + 1 };
            if lines(intervals.len()) != expected {
                return Err(Error::Shape {
                    name: "lines of a strip",
                    found: lines(intervals.len()),
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
            let own = strip_loads(prism, intervals, basis, patch.grid.dy)?;
            for (all, own) in loads.iter_mut().zip(own) {
                all.extend(own);
            }
        }
        let m = shapes.len();
        let mut known: HashMap<(usize, usize, usize, usize, i64), usize> = HashMap::new();
        let (mut quadratures, mut of_pair) = (Vec::new(), Vec::with_capacity(m * m));
        let finest = patches.iter().map(|p| p.grid.dy).fold(f64::MAX, f64::min);
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
            basis,
            columns: patches.iter().map(|p| p.grid.dx).collect(),
            shapes,
            widths,
            strip: strip_of,
            loads: loads.concat(),
            quadratures,
            of_pair,
        })
    }

    /// The waves that count under contacts over a `span` [m] along the axis.
    ///
    /// # Errors
    /// [`Error::Section`] where the prism is not held, [`Error::Interrupted`].
    pub(super) fn spectrum(
        &self,
        prism: &Prism,
        span: f64,
        monitor: Monitor<'_>,
    ) -> Result<Spectrum, Error> {
        let finest = self.columns.iter().copied().fold(f64::MAX, f64::min);
        let last = 2.0 * std::f64::consts::PI / finest;
        let (mut from, mut to) = (0.0, prism.slowest().min(last));
        let mut waves: Vec<Beside> = Vec::new();
        let mut own = vec![0.0; 3 * self.shapes.len()];
        let mut tail = f64::NAN;
        let mut step = 0;
        loop {
            report(monitor, step, tail).map_err(|_| Error::Interrupted)?;
            let points: Vec<(f64, f64)> = gauss(from, to).collect();
            let solved: Result<Vec<(Beside, Shares)>, Error> = points
                .par_iter()
                .map(|(k, weight)| {
                    let (difference, diagonal) = self.difference(prism, *k)?;
                    let beside = Beside {
                        number: *k,
                        weight: weight / std::f64::consts::PI,
                        difference,
                    };
                    Ok((beside, diagonal))
                })
                .collect();
            let mut added = vec![0.0; own.len()];
            let mut beyond = vec![0.0; own.len()];
            for (wave, diagonal) in solved? {
                for (k, [whole, part]) in diagonal.iter().enumerate() {
                    let dx = self.columns[self.strip[k % self.shapes.len()]];
                    // of a column in the middle of the strip, on itself
                    let shape = column(self.basis, wave.number, dx).powi(2);
                    own[k] += wave.weight * shape * whole;
                    added[k] += wave.weight * shape * part;
                    // shorter waves, if the section went on to be no half-space
                    let left = beyond_of(self.basis, wave.number, dx) / std::f64::consts::PI;
                    beyond[k] = left * part;
                }
                waves.push(wave);
            }
            let share = |parts: &[f64]| {
                let shares = parts.iter().zip(&own).map(|(part, own)| (part / own).abs());
                shares.fold(0.0, f64::max)
            };
            tail = share(&added);
            step += 1;
            if to >= last {
                tail = tail.max(share(&beyond));
                break;
            }
            if tail < NEGLIGIBLE && step > 2 {
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
        Ok(Spectrum {
            waves,
            largest: to,
            tail,
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

/// Integral [m] of the function of x of a column inside a strip, times a wave about its middle.
pub(super) fn column(basis: Basis, wave_number: f64, dx: f64) -> f64 {
    let half = 0.5 * wave_number * dx;
    let sinc = if half == 0.0 { 1.0 } else { half.sin() / half };
    dx * if basis == Basis::Hats {
        sinc.powi(2)
    } else {
        sinc
    }
}

/// Integral [m] of the square of [`column`] over all wave numbers from one on that is large against `1 / dx`.
fn beyond_of(basis: Basis, wave_number: f64, dx: f64) -> f64 {
    let from = match basis {
        Basis::Cells => 1.0,
        Basis::Hats => (wave_number * dx).powi(-2),
    };
    2.0 * from / wave_number
}

/// The edges of the surface between each two `lines` (y) [m] of a strip.
///
/// # Errors
/// [`Error::Section`] where a line is no node of these edges.
pub(super) fn edges_between(
    prism: &Prism,
    surface: &[[usize; 3]],
    lines: &[f64],
) -> Result<Intervals, Error> {
    let mut intervals = Intervals::new();
    for pair in lines.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        let near = MISSED * (to - from);
        let mut edges = Vec::new();
        for edge in surface {
            let [a, b] = [prism.place(edge[0])?[0], prism.place(edge[1])?[0]];
            if a > from - near && b < to + near {
                edges.push(*edge);
            }
        }
        let missed = "the lines of a contact strip are no nodes of its surface";
        let (Some(first), Some(last)) = (edges.first(), edges.last()) else {
            return Err(Error::Section(missed));
        };
        let ends = [
            prism.place(first[0])?[0] - from,
            prism.place(last[1])?[0] - to,
        ];
        if ends.iter().any(|e| e.abs() > near) {
            return Err(Error::Section(missed));
        }
        intervals.push(edges);
    }
    Ok(intervals)
}

/// Loads of the rows of one strip by unit tractions along x, across, and into the body.
pub(super) fn strip_loads(
    prism: &Prism,
    intervals: &Intervals,
    basis: Basis,
    dy: f64,
) -> Result<[Vec<Sparse>; 3], Error> {
    let rows = if basis == Basis::Hats {
        intervals.len() + 1
    } else {
        intervals.len()
    };
    let mut loads: [Vec<Sparse>; 3] = [0, 1, 2].map(|_| vec![Sparse::new(); rows]);
    for (interval, edges) in intervals.iter().enumerate() {
        let edges: Result<Vec<_>, Error> = edges
            .iter()
            .map(|edge| Ok((*edge, prism.edge_points(edge)?)))
            .collect();
        let edges = edges?;
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

// SPDX-License-Identifier: MIT OR Apache-2.0
use super::layers::{ACROSS_RAIL, layers};
use super::{rising, steps};
use crate::Error;
use crate::error::{out_of_range, positive};
use mtb_words::Short;

/// Triangles of six nodes over the cross-section of a prism, in (y, z).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SectionMesh {
    /// Nodes (y, z) [m].
    pub nodes: Vec<[f64; 2]>,
    /// Node numbers of each triangle, against the clock: corners, then the middles of 01, 12, 20.
    pub triangles: Vec<[usize; 6]>,
    /// Edges of the running surface with y rising: both ends, then the middle.
    pub surface: Vec<[usize; 3]>,
    /// Edges of the base, likewise.
    pub base: Vec<[usize; 3]>,
}

/// A grid of quadrilaterals, columns with y rising and layers with z rising.
pub(super) struct Quads {
    /// Corners, layers fastest.
    pub(super) plane: Vec<[f64; 2]>,
    /// Numbers of columns and of layers of corners.
    pub(super) shape: [usize; 2],
    /// Which quadrilaterals exist, layers fastest.
    pub(super) keep: Vec<bool>,
    /// Columns of quadrilaterals before this one are cut as seen in a mirror.
    pub(super) flipped: usize,
    /// First column of the doubled grid, and true places of its uppermost layer from there on.
    pub(super) top: (usize, Vec<[f64; 2]>),
}

impl Quads {
    /// Two triangles for each quadrilateral.
    pub(super) fn triangles(&self) -> SectionMesh {
        let [columns, layers] = self.shape;
        let fine = [2 * columns - 1, 2 * layers - 1];
        let flat = |[i, j]: [usize; 2]| i * fine[1] + j;
        let corner = |i: usize, j: usize| self.plane[i * layers + j];
        let place = |[i, j]: [usize; 2]| -> [f64; 2] {
            let (first, rows) = (self.top.0, &self.top.1);
            if j + 1 == fine[1] && i >= first && i - first < rows.len() {
                return rows[i - first];
            }
            let (mut a, mut b) = ([i / 2, j / 2], [i.div_ceil(2), j.div_ceil(2)]);
            if i % 2 == 1 && j % 2 == 1 && i / 2 < self.flipped {
                std::mem::swap(&mut a[0], &mut b[0]);
            }
            let (a, b) = (corner(a[0], a[1]), corner(b[0], b[1]));
            [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
        };
        let mut cells: Vec<[[usize; 2]; 6]> = Vec::new();
        for (k, _) in self.keep.iter().enumerate().filter(|(_, kept)| **kept) {
            let (i, j) = (2 * (k / (layers - 1)), 2 * (k % (layers - 1)));
            let [a, b, c, d] = [[i, j], [i + 2, j], [i + 2, j + 2], [i, j + 2]];
            let corners = if k / (layers - 1) < self.flipped {
                [[a, b, d], [b, c, d]]
            } else {
                [[a, b, c], [a, c, d]]
            };
            let middle = |p: [usize; 2], q: [usize; 2]| [p[0].midpoint(q[0]), p[1].midpoint(q[1])];
            cells.extend(
                corners.map(|[p, q, r]| [p, q, r, middle(p, q), middle(q, r), middle(r, p)]),
            );
        }
        let mut number = vec![usize::MAX; fine[0] * fine[1]];
        for at in cells.iter().flatten() {
            number[flat(*at)] = 0;
        }
        let mut nodes = Vec::new();
        for (k, number) in number.iter_mut().enumerate().filter(|(_, n)| **n == 0) {
            *number = nodes.len();
            nodes.push(place([k / fine[1], k % fine[1]]));
        }
        let side = |layer: usize| -> Vec<[usize; 3]> {
            let row = |i: usize| number[flat([i, layer])];
            let edges = (0..columns - 1).map(|i| [row(2 * i), row(2 * i + 2), row(2 * i + 1)]);
            edges
                .filter(|edge| edge.iter().all(|n| *n != usize::MAX))
                .collect()
        };
        SectionMesh {
            triangles: cells
                .iter()
                .map(|cell| cell.map(|at| number[flat(at)]))
                .collect(),
            surface: side(fine[1] - 1),
            base: side(0),
            nodes,
        }
    }
}

/// Rising lines (y) [m] on which a surface is divided: those of all strips, with `parts` elements between two lines
/// of a strip, and steps about as long as those beside them between strips.
pub(super) fn divided(strips: &[&[f64]], parts: usize) -> Result<Vec<f64>, Error> {
    let mut lines: Vec<f64> = Vec::new();
    for strip in strips {
        rising("lines", strip)?;
        for pair in strip.windows(2) {
            let step = (pair[1] - pair[0]) / parts as f64;
            lines.extend((0..parts).map(|k| pair[0] + k as f64 * step));
        }
        lines.extend(strip.last());
    }
    lines.sort_by(f64::total_cmp);
    let (Some(&first), Some(&last)) = (lines.first(), lines.last()) else {
        return Err(Error::NotRising { name: "lines" });
    };
    lines.dedup_by(|a, b| (*a - *b).abs() <= 1e-9 * (last - first));
    let least = steps(&lines).fold(f64::INFINITY, f64::min);
    let mut filled: Vec<f64> = Vec::with_capacity(lines.len());
    for pair in lines.windows(2) {
        let between = strips.iter().all(|s| {
            0.5 * (pair[0] + pair[1]) < s[0] || 0.5 * (pair[0] + pair[1]) > s[s.len() - 1]
        });
        let count = if between {
            1.0_f64.max(((pair[1] - pair[0]) / (2.0 * least)).ceil()) as usize
        } else {
            1
        };
        let step = (pair[1] - pair[0]) / count as f64;
        filled.extend((0..count).map(|k| pair[0] + k as f64 * step));
    }
    filled.push(last);
    Ok(filled)
}

/// Section of a prism with a rectangular section, symmetric about y = 0, its top at z = 0.
///
/// `strips` are the rising y [m] of the rows of each contact grid, with `parts` elements between two of them.
///
/// # Errors
/// [`Error::NotRising`], sizes that are not positive, strips that leave the top.
pub fn rectangle_section(
    width: f64,
    height: f64,
    strips: &[&[f64]],
    parts: usize,
) -> Result<SectionMesh, Error> {
    let (width, height) = (positive("width", width)?, positive("height", height)?);
    let lines = divided(strips, parts)?;
    let (first, last) = (lines[0], lines[lines.len() - 1]);
    let half = 0.5 * width;
    if first < -half * (1.0 + 1e-9) || last > half * (1.0 + 1e-9) {
        let accepted = format!(
            "the contact strip lies within {} m of the middle",
            Short(half)
        );
        let worst = if -first > last { first } else { last };
        return Err(out_of_range("y", worst, accepted));
    }
    let step = steps(&lines).fold(f64::INFINITY, f64::min);
    let aside = |from: f64, step: f64| -> Result<Vec<f64>, Error> {
        if half - from <= 1e-9 * width {
            return Ok(Vec::new());
        }
        Ok(layers(step, half - from, width, ACROSS_RAIL, 1)?[1..].to_vec())
    };
    let mut y: Vec<f64> = aside(-first, lines[1] - first)?
        .iter()
        .rev()
        .map(|d| first - d)
        .collect();
    y.extend(&lines);
    let beyond = aside(last, last - lines[lines.len() - 2])?;
    y.extend(beyond.iter().map(|d| last + d));
    let mut z = layers(step, height, width, ACROSS_RAIL, 2)?;
    z.reverse();
    let plane = y
        .iter()
        .flat_map(|y| z.iter().map(move |z| [*y, -*z]))
        .collect();
    let quads = Quads {
        plane,
        shape: [y.len(), z.len()],
        keep: vec![true; (y.len() - 1) * (z.len() - 1)],
        flipped: y.windows(2).filter(|w| w[0] + w[1] < 0.0).count(),
        top: (0, Vec::new()),
    };
    Ok(quads.triangles())
}

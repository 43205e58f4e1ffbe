// SPDX-License-Identifier: MIT OR Apache-2.0
//! Influence coefficients on the offsets of a grid.

use mtb_operator::Grid;

use super::operators::Bodies;

/// Influence coefficients at the offsets of a grid, and one step ahead of them.
pub(super) struct Table<'a> {
    bodies: &'a Bodies<'a>,
    cell: [f64; 2],
    step: [f64; 2],
    /// The step in cells where it is a whole number of them.
    pub(super) whole: Option<[isize; 2]>,
    width: usize,
    /// Places of no offset in the values: none on the negative side of bodies with symmetry.
    middle: [usize; 2],
    values: Vec<[f64; 3]>,
}

impl<'a> Table<'a> {
    /// For the offsets of up to `cells` (exclusive) to either side.
    pub(super) fn new(
        bodies: &'a Bodies<'a>,
        grid: &Grid,
        cells: [usize; 2],
        step: [f64; 2],
    ) -> Self {
        let cell = [grid.dx, grid.dy];
        let whole = whole(grid, step);
        let margin = if let Some(whole) = whole {
            whole.map(isize::unsigned_abs)
        } else {
            [0; 2]
        };
        let ahead = [0, 1].map(|k| cells[k] + margin[k]);
        let middle = ahead.map(|n| if bodies.is_mirrored { 0 } else { n - 1 });
        let [width, height] = [0, 1].map(|k| ahead[k] + middle[k]);
        let values = (0..width * height)
            .map(|k| {
                let place = [k % width, k / width];
                let offset = [0, 1].map(|c| (place[c] as f64 - middle[c] as f64) * cell[c]);
                (bodies.tangential)(cell, offset)
            })
            .collect();
        Self {
            bodies,
            cell,
            step,
            whole,
            width,
            middle,
            values,
        }
    }

    /// At the offset of `(i, j)` cells.
    pub(super) fn here(&self, i: isize, j: isize) -> [f64; 3] {
        if !self.bodies.is_mirrored {
            let [column, row] =
                [(i, 0), (j, 1)].map(|(d, k)| (self.middle[k] as isize + d) as usize);
            return self.values[row * self.width + column];
        }
        let [xx, xy, yy] = self.values[j.unsigned_abs() * self.width + i.unsigned_abs()];
        if (i < 0) == (j < 0) {
            [xx, xy, yy]
        } else {
            [xx, -xy, yy]
        }
    }

    /// At the offset of `(i, j)` cells and one step.
    pub(super) fn ahead(&self, i: isize, j: isize) -> [f64; 3] {
        if let Some([di, dj]) = self.whole {
            return self.here(i + di, j + dj);
        }
        self.displaced(i, j, 1.0)
    }

    /// At the offset of `(i, j)` cells, less one step.
    pub(super) fn behind(&self, i: isize, j: isize) -> [f64; 3] {
        if let Some([di, dj]) = self.whole {
            return self.here(i - di, j - dj);
        }
        self.displaced(i, j, -1.0)
    }

    fn displaced(&self, i: isize, j: isize, steps: f64) -> [f64; 3] {
        let x = i as f64 * self.cell[0] + steps * self.step[0];
        let y = j as f64 * self.cell[1] + steps * self.step[1];
        (self.bodies.tangential)(self.cell, [x, y])
    }

    /// Whether tractions do the same at opposite offsets.
    pub(super) fn is_mirrored(&self) -> bool {
        self.bodies.is_mirrored
    }

    /// The part of it that is even along both axes, and of the mixed component odd, at offsets `i, j >= 0`.
    pub(super) fn mirrored(&self, i: usize, j: usize) -> [f64; 3] {
        let (i, j) = (i as isize, j as isize);
        if self.is_mirrored() {
            return self.here(i, j);
        }
        let ends = [(i, j, 1.0), (-i, j, -1.0), (i, -j, -1.0), (-i, -j, 1.0)];
        let mut mean = [0.0; 3];
        for (i, j, sign) in ends {
            let [xx, xy, yy] = self.here(i, j);
            mean[0] += 0.25 * xx;
            mean[1] += 0.25 * sign * xy;
            mean[2] += 0.25 * yy;
        }
        mean
    }
}

/// The step in cells where it is a whole number of them, and not too many.
pub(super) fn whole(grid: &Grid, step: [f64; 2]) -> Option<[isize; 2]> {
    let along = [step[0] / grid.dx, step[1] / grid.dy];
    let is_whole = |v: f64| (v - v.round()).abs() < 1e-9 && v.abs() < 9.0;
    (along.into_iter().all(is_whole)).then(|| along.map(|v| v.round() as isize))
}

/// Places in cells, and their weights.
pub(super) type Places = [([isize; 2], f64); 4];

/// Bilinear weights of the four points around the one a step away, in cells.
pub(super) fn upstream(grid: &Grid, step: [f64; 2]) -> Places {
    let along = [step[0] / grid.dx, step[1] / grid.dy];
    let base = along.map(|v| {
        let nearest = v.round();
        if (v - nearest).abs() < 1e-9 {
            (nearest, 0.0)
        } else {
            (v.floor(), v - v.floor())
        }
    });
    let corner = |a: usize, b: usize| {
        let pick = |k: usize, upper: usize| {
            let (floor, part) = base[k];
            let weight = if upper == 1 { part } else { 1.0 - part };
            (floor as isize + upper as isize, weight)
        };
        let ((i, wx), (j, wy)) = (pick(0, a), pick(1, b));
        ([i, j], wx * wy)
    };
    [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)]
}

/// The layer's own displacement here minus one step ahead, as a kernel.
pub(super) struct LayerStencil(Places);

impl LayerStencil {
    pub(super) fn new(grid: &Grid, step: [f64; 2]) -> Self {
        Self(upstream(grid, step))
    }

    pub(super) fn difference(&self, i: isize, j: isize) -> f64 {
        let here = if i == 0 && j == 0 { 1.0 } else { 0.0 };
        here - self.ahead(i, j)
    }

    fn ahead(&self, i: isize, j: isize) -> f64 {
        self.0
            .iter()
            .filter(|([di, dj], _)| *di == -i && *dj == -j)
            .map(|(_, w)| w)
            .sum()
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Influence coefficients on the offsets of a grid.

use std::sync::Arc;

use mtb_operator::Grid;

use super::operators::{Bodies, Influence};

/// Influence coefficients at the offsets of a grid.
pub(super) struct Influences {
    is_mirrored: bool,
    /// Offsets are known up to so many cells (exclusive) to either side.
    reach: [usize; 2],
    width: usize,
    /// Places of no offset in the values: none on the negative side of bodies with symmetry.
    middle: [usize; 2],
    values: Vec<[f64; 3]>,
}

impl Influences {
    fn new(bodies: &Bodies<'_>, grid: &Grid, reach: [usize; 2]) -> Self {
        let cell = [grid.dx, grid.dy];
        let middle = reach.map(|n| if bodies.is_mirrored { 0 } else { n - 1 });
        let [width, height] = [0, 1].map(|k| reach[k] + middle[k]);
        let values = (0..width * height)
            .map(|k| {
                let place = [k % width, k / width];
                let offset = [0, 1].map(|c| (place[c] as f64 - middle[c] as f64) * cell[c]);
                (bodies.tangential)(cell, offset)
            })
            .collect();
        Self {
            is_mirrored: bodies.is_mirrored,
            reach,
            width,
            middle,
            values,
        }
    }

    /// At the offset of `(i, j)` cells.
    fn at(&self, i: isize, j: isize) -> [f64; 3] {
        if !self.is_mirrored {
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
}

/// Influence coefficients at the offsets of a grid, and one step ahead of them.
pub(super) struct Table<'a> {
    bodies: &'a Bodies<'a>,
    cell: [f64; 2],
    step: [f64; 2],
    /// The step in cells where it is a whole number of them.
    pub(super) whole: Option<[isize; 2]>,
    /// Where the step leads between cells, if it is taken so.
    between: Option<Vec<Share>>,
    influences: Arc<Influences>,
}

impl<'a> Table<'a> {
    /// For the offsets of up to `cells` (exclusive) to either side.
    pub(super) fn new(
        bodies: &'a Bodies<'a>,
        grid: &Grid,
        cells: [usize; 2],
        step: [f64; 2],
    ) -> Self {
        let whole = whole(grid, step);
        let margin = whole.unwrap_or_default().map(isize::unsigned_abs);
        let reach = [0, 1].map(|k| cells[k] + margin[k]);
        let influences = Arc::new(Influences::new(bodies, grid, reach));
        Self {
            bodies,
            cell: [grid.dx, grid.dy],
            step,
            whole,
            between: None,
            influences,
        }
    }

    /// The same with a step that leads between cells; of the influences that are `known` where they reach as far.
    pub(super) fn between_cells(
        bodies: &'a Bodies<'a>,
        grid: &Grid,
        step: [f64; 2],
        known: Option<&Arc<Influences>>,
    ) -> Self {
        let between = between(grid, step);
        let cells = [grid.nx, grid.ny];
        let reach = [0, 1].map(|k| {
            let margin = between.iter().map(|(by, _)| by[k].unsigned_abs()).max();
            cells[k] + margin.unwrap_or(0)
        });
        let known = known.filter(|known| (0..2).all(|k| known.reach[k] >= reach[k]));
        let made = || Arc::new(Influences::new(bodies, grid, reach));
        Self {
            bodies,
            cell: [grid.dx, grid.dy],
            step,
            whole: None,
            between: Some(between),
            influences: known.cloned().unwrap_or_else(made),
        }
    }

    /// Where the step leads between cells, if it is taken so.
    pub(super) fn between(&self) -> Option<&[Share]> {
        self.between.as_deref()
    }

    /// The influences, for other steps.
    pub(super) fn influences(&self) -> &Arc<Influences> {
        &self.influences
    }

    /// At the offset of `(i, j)` cells.
    pub(super) fn here(&self, i: isize, j: isize) -> [f64; 3] {
        self.influences.at(i, j)
    }

    /// At the offset of `(i, j)` cells and one step.
    pub(super) fn ahead(&self, i: isize, j: isize) -> [f64; 3] {
        if let Some(between) = &self.between {
            let mut sum = [0.0; 3];
            for ([di, dj], share) in between {
                let there = self.here(i + di, j + dj);
                sum.iter_mut().zip(there).for_each(|(s, v)| *s += share * v);
            }
            return sum;
        }
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

/// Displacement (x, y) by a unit pressure at the offsets of a grid and where a step leads between them.
pub(super) struct Pressed {
    width: usize,
    middle: [usize; 2],
    values: Vec<[f64; 2]>,
}

impl Pressed {
    pub(super) fn new(by_pressure: Influence<'_, 2>, grid: &Grid, between: &[Share]) -> Self {
        let middle = [(0, grid.nx), (1, grid.ny)].map(|(k, n)| {
            let margin = between.iter().map(|(by, _)| by[k].unsigned_abs()).max();
            n - 1 + margin.unwrap_or(0)
        });
        let [width, height] = middle.map(|m| 2 * m + 1);
        let cell = [grid.dx, grid.dy];
        let values = (0..width * height)
            .map(|k| {
                let place = [k % width, k / width];
                by_pressure(
                    cell,
                    [0, 1].map(|c| (place[c] as f64 - middle[c] as f64) * cell[c]),
                )
            })
            .collect();
        Self {
            width,
            middle,
            values,
        }
    }

    /// At the offset of `(i, j)` cells.
    pub(super) fn at(&self, i: isize, j: isize) -> [f64; 2] {
        let [column, row] = [(i, 0), (j, 1)].map(|(d, k)| (self.middle[k] as isize + d) as usize);
        self.values[row * self.width + column]
    }
}

/// A place in cells, and its weight.
pub(super) type Share = ([isize; 2], f64);

/// Part of a cell by which a step may be longer than whole ones and count as they: steps of just one cell have no kink.
const LONGER: f64 = 0.05;

/// Where a step leads, between cells: linear along x, as a traction that has not changed then moves the surface over a
/// step by so many times what it moves it by over a cell, and cubic with an even slope across.
pub(super) fn between(grid: &Grid, step: [f64; 2]) -> Vec<Share> {
    let v = step[0] / grid.dx;
    let base = (v.abs() - 1.0 - LONGER).ceil().max(0.0);
    let part = v.abs() - base;
    let sense = if v < 0.0 { -1 } else { 1 };
    let along = [(0, 1.0 - part), (1, part)].map(|(k, w)| (sense * (base as isize + k), w));
    let u = step[1] / grid.dy;
    let t = u - u.floor();
    // [Keys1981]
    let across = [
        (-1, -0.5 * t + t * t - 0.5 * t.powi(3)),
        (0, 1.0 - 2.5 * t * t + 1.5 * t.powi(3)),
        (1, 0.5 * t + 2.0 * t * t - 1.5 * t.powi(3)),
        (2, -0.5 * t * t + 0.5 * t.powi(3)),
    ]
    .map(|(k, w)| (u.floor() as isize + k, w));
    (along.iter())
        .flat_map(|(i, a)| across.iter().map(move |(j, b)| ([*i, *j], a * b)))
        .filter(|(_, weight)| *weight != 0.0)
        .collect()
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

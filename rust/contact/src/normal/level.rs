// SPDX-License-Identifier: MIT OR Apache-2.0
//! Grids of a nested solve: coarsening, passing pressures on, rectangles of cells.

use std::f64::consts::FRAC_PI_2;

use mtb_complementarity::bounded::Mode;
use mtb_operator::{Grid, fast_even_size};

use super::{Load, NormalContact, Surface};
use crate::inclination::Turn;

/// Cells per side from which a coarser grid helps.
const COARSEN_FROM: usize = 32;

/// Products that a solve on a rectangle takes at least.
const PRODUCTS: f64 = 3.0;

/// Continuation of the function that is interpolated beyond cells at the cap, over its value there: what keeps the load
/// about.
const STEEP: f64 = 0.3;

/// Steepness of that function across a rim of one cell, which is cut where its load ends.
const SHARP: f64 = 1.5;

/// The problem on one grid.
pub(super) struct Level {
    pub(super) grid: Grid,
    pub(super) gap: Vec<f64>,
    /// First cell centre, from the centre of the finest grid [m].
    origin: [f64; 2],
    is_periodic: bool,
}

impl Level {
    /// The grid of the contact.
    pub(super) fn finest(contact: &NormalContact<'_>) -> Self {
        let grid = contact.grid;
        Self {
            grid,
            gap: contact.gap.to_vec(),
            origin: [
                -0.5 * (grid.nx - 1) as f64 * grid.dx,
                -0.5 * (grid.ny - 1) as f64 * grid.dy,
            ],
            is_periodic: matches!(contact.surface, Surface::Periodic(_)),
        }
    }

    /// The finest grid first, then each with half the cells per side.
    pub(super) fn pyramid(contact: &NormalContact<'_>) -> Vec<Self> {
        let mut levels = vec![Self::finest(contact)];
        if matches!(contact.surface, Surface::Body(_)) {
            return levels;
        }
        while let Some(coarser) = levels.last().and_then(Self::coarsened) {
            levels.push(coarser);
        }
        levels
    }

    /// The grid with cells twice as large; `None` where it would be too coarse to help.
    fn coarsened(&self) -> Option<Self> {
        let Grid { nx, ny, dx, dy } = self.grid;
        let is_even = nx.is_multiple_of(2) && ny.is_multiple_of(2);
        if nx.min(ny) < COARSEN_FROM || (self.is_periodic && !is_even) {
            return None;
        }
        let grid = Grid {
            nx: nx.div_ceil(2),
            ny: ny.div_ceil(2),
            dx: 2.0 * dx,
            dy: 2.0 * dy,
        };
        // half of a last cell may hang out: the gap is continued linearly there
        let at = |i: usize, j: usize| self.gap[j * nx + i];
        let row = |i: usize, j: usize| {
            if i < nx {
                at(i, j)
            } else {
                2.0 * at(nx - 1, j) - at(nx - 2, j)
            }
        };
        let value = |i: usize, j: usize| {
            if j < ny {
                row(i, j)
            } else {
                2.0 * row(i, ny - 1) - row(i, ny - 2)
            }
        };
        let mut gap = Vec::with_capacity(grid.points());
        for j in 0..grid.ny {
            for i in 0..grid.nx {
                let (i, j) = (2 * i, 2 * j);
                let sum = value(i, j) + value(i + 1, j) + value(i, j + 1) + value(i + 1, j + 1);
                gap.push(0.25 * sum);
            }
        }
        let origin = [self.origin[0] + 0.5 * dx, self.origin[1] + 0.5 * dy];
        Some(Self {
            grid,
            gap,
            origin,
            is_periodic: self.is_periodic,
        })
    }

    /// How the rows of a rectangle are inclined, if they are.
    pub(super) fn turn(&self, region: &Region, surface: Surface<'_>) -> Option<Turn> {
        let Surface::Inclined(_, inclination) = surface else {
            return None;
        };
        let dy = self.grid.dy;
        let first = self.origin[1] + region.y as f64 * dy;
        Some(Turn::new(inclination, first, dy, region.ny))
    }

    /// Offset of the complementarity problem on a rectangle: the gap, less the prescribed approach.
    pub(super) fn offset(&self, region: &Region, load: Load) -> Vec<f64> {
        let mut offset = region.cut(&self.gap, self.grid.nx);
        if let Load::Approach(approach) = load {
            for g in &mut offset {
                *g -= approach;
            }
        }
        offset
    }

    /// Free motions on a rectangle: the approach under a force, then the free tilts.
    ///
    /// Tilts are scaled to one at half the sides of the grid; see [`Level::half_sides`].
    pub(super) fn modes(&self, region: &Region, contact: &NormalContact<'_>) -> Vec<Mode> {
        let area = self.grid.cell_area();
        let mut modes = Vec::new();
        if let Load::Force(force) = contact.load {
            modes.push(Mode {
                shape: vec![1.0; region.points()],
                target: force / area,
            });
        }
        let half = half_sides(&contact.grid);
        let spacing = [self.grid.dx, self.grid.dy];
        for axis in 0..2 {
            if let Some(moment) = contact.moments[axis] {
                let coordinate = |k: usize| {
                    let cell = [region.x + k % region.nx, region.y + k / region.nx][axis];
                    (self.origin[axis] + cell as f64 * spacing[axis]) / half[axis]
                };
                let shape = (0..region.points()).map(coordinate).collect();
                modes.push(Mode {
                    shape,
                    target: moment / (area * half[axis]),
                });
            }
        }
        modes
    }

    /// Pressure of the coarser grid `coarse` as a start on this one.
    ///
    /// Where a smooth contact ends, the square of the pressure falls linearly to zero, and so does that of what is left
    /// to a `cap` where it begins to flow. So a function of it is interpolated that is linear in both, and continued
    /// over both borders to find where it reaches its bounds. What flows as far as the border ends within about a cell.
    pub(super) fn start_from(&self, coarse: &Self, pressure: &[f64], cap: f64) -> Vec<f64> {
        let Grid { nx, ny, .. } = coarse.grid;
        let (width, height) = (nx as isize, ny as isize);
        let index = |i: isize, j: isize| -> Option<usize> {
            if self.is_periodic {
                return Some((j.rem_euclid(height) * width + i.rem_euclid(width)) as usize);
            }
            let is_inside = (0..width).contains(&i) && (0..height).contains(&j);
            is_inside.then_some((j * width + i) as usize)
        };
        let form = Form { cap };
        let is_open = |k: usize| pressure[k] <= 0.0;
        let is_capped = |k: usize| pressure[k] >= cap;
        // a rim of one cell between what flows and what is open is cut where its load ends
        let is_thin = |i: isize, j: isize| {
            [(1, 0), (0, 1)].iter().any(|(di, dj)| {
                match (index(i - di, j - dj), index(i + di, j + dj)) {
                    (Some(a), Some(b)) => is_open(a) && is_capped(b) || is_open(b) && is_capped(a),
                    _ => false,
                }
            })
        };
        let cut = |k: usize, away: f64| 0.5 + SHARP * (pressure[k] / cap - 0.5 - away);
        let values: Vec<f64> = pressure.iter().map(|p| form.of(*p)).collect();
        let largest = values.iter().copied().fold(0.0, f64::max);
        let mut field = values.clone();
        for j in 0..height {
            for i in 0..width {
                let here = (j * width + i) as usize;
                if !is_open(here) && !is_capped(here) {
                    if cap.is_finite() && is_thin(i, j) {
                        field[here] = cut(here, 0.0);
                    }
                    continue;
                }
                let (mut sum, mut weights) = (0.0, 0.0);
                for (di, dj) in [
                    (1, 0),
                    (-1, 0),
                    (0, 1),
                    (0, -1),
                    (1, 1),
                    (1, -1),
                    (-1, 1),
                    (-1, -1),
                ] {
                    let (near, far) = (index(i + di, j + dj), index(i + 2 * di, j + 2 * dj));
                    let (Some(near), Some(far)) = (near, far) else {
                        continue;
                    };
                    if is_open(near) || (is_capped(near) && is_capped(here)) {
                        continue;
                    }
                    let linear = 2.0 * values[near] - values[far];
                    let continued = match (is_capped(here), is_capped(near), is_capped(far)) {
                        (true, _, _) if is_open(far) => cut(near, -1.0),
                        (true, _, true) => continue,
                        (true, _, _) => linear,
                        (false, true, true) => -STEEP * values[near],
                        (false, false, true) => cut(near, 1.0),
                        _ if is_open(far) => continue,
                        _ => linear,
                    };
                    let weight = if di * dj == 0 { 1.0 } else { 0.5 };
                    sum += weight * continued;
                    weights += weight;
                }
                field[here] = match (weights > 0.0, is_capped(here)) {
                    (true, true) => (sum / weights).max(values[here]),
                    (true, false) => (sum / weights).min(0.0),
                    (false, true) => values[here],
                    (false, false) => -0.01 * largest,
                };
            }
        }
        self.refined(&field, [nx, ny], form)
    }

    /// Pressure by the linear interpolant of a coarser field of `shape` [nx, ny] at the cells of this grid.
    fn refined(&self, coarse: &[f64], shape: [usize; 2], form: Form) -> Vec<f64> {
        let [nx, ny] = shape;
        let fine = self.grid.nx;
        let columns: Vec<_> = (0..fine)
            .map(|i| neighbours(i, nx, self.is_periodic))
            .collect();
        let mut wide = Vec::with_capacity(fine * ny);
        for row in coarse.chunks_exact(nx) {
            wide.extend(
                columns
                    .iter()
                    .map(|near| near.iter().map(|(k, w)| w * row[*k]).sum::<f64>()),
            );
        }
        let mut refined = Vec::with_capacity(self.grid.points());
        for j in 0..self.grid.ny {
            let [a, b] = neighbours(j, ny, self.is_periodic).map(|(k, weight)| {
                let row = &wide[k * fine..(k + 1) * fine];
                (row, weight)
            });
            for i in 0..fine {
                let value = a.1 * a.0[i] + b.1 * b.0[i];
                refined.push(form.pressure(value));
            }
        }
        refined
    }

    /// Relative difference (L2) of a pressure on this grid and one on the coarser grid, over the contact
    /// without a rim as wide as a twentieth of it (one cell where that leaves nothing) and what is at a `cap`; `None`
    /// where no such cell has all its neighbours in contact.
    pub(super) fn difference(
        &self,
        pressure: &[f64],
        coarse: &Self,
        other: &[f64],
        cap: f64,
    ) -> Option<f64> {
        let (nx, ny) = (coarse.grid.nx, coarse.grid.ny);
        let rim = Region::bounds(other, nx).map_or(1, |b| 1 + b.nx.min(b.ny) / 20);
        let mut inside = away_from_border(other, [nx, ny], rim);
        if !inside.contains(&true) {
            inside = away_from_border(other, [nx, ny], 1);
        }
        let (mut wrong, mut size) = (0.0, 0.0);
        for (k, is_inside) in inside.iter().enumerate() {
            let (fine_i, fine_j) = (2 * (k % nx), 2 * (k / nx));
            if !is_inside
                || other[k] >= cap
                || fine_i + 1 >= self.grid.nx
                || fine_j + 1 >= self.grid.ny
            {
                continue;
            }
            let from = fine_j * self.grid.nx + fine_i;
            let up = from + self.grid.nx;
            let mean =
                0.25 * (pressure[from] + pressure[from + 1] + pressure[up] + pressure[up + 1]);
            wrong += (mean - other[k]).powi(2);
            size += mean * mean;
        }
        (size > 0.0).then(|| (wrong / size).sqrt())
    }
}

/// The function of the pressure that is interpolated: its square, under a cap that of the sine whose quarter ends there.
#[derive(Clone, Copy)]
struct Form {
    cap: f64,
}

impl Form {
    fn of(self, pressure: f64) -> f64 {
        if self.cap.is_finite() {
            (FRAC_PI_2 * pressure / self.cap).sin().powi(2)
        } else {
            pressure.powi(2)
        }
    }

    /// Pressure between the bounds at a value of the function, or beyond those.
    fn pressure(self, value: f64) -> f64 {
        let root = value.max(0.0).sqrt();
        if root >= 1.0 && self.cap.is_finite() {
            self.cap
        } else if self.cap.is_finite() {
            root.asin() / FRAC_PI_2 * self.cap
        } else {
            root
        }
    }
}

/// Points with nothing but pressure within `rim` cells along x, along y and across.
fn away_from_border(pressure: &[f64], shape: [usize; 2], rim: usize) -> Vec<bool> {
    let [nx, ny] = shape;
    let mut inside: Vec<bool> = pressure.iter().map(|p| *p > 0.0).collect();
    // first along the rows, then along the columns: the length of the loaded run on either side
    for (count, length, stride, step) in [(ny, nx, nx, 1), (nx, ny, 1, nx)] {
        for line in 0..count {
            let at = |k: usize| line * stride + k * step;
            let mut allowed = vec![0; length];
            let mut run = 0;
            for (k, allowed) in allowed.iter_mut().enumerate() {
                run = if inside[at(k)] { run + 1 } else { 0 };
                *allowed = run;
            }
            run = 0;
            for k in (0..length).rev() {
                run = if inside[at(k)] { run + 1 } else { 0 };
                inside[at(k)] = allowed[k].min(run) > rim;
            }
        }
    }
    inside
}

/// Half of the sides of a grid [m].
pub(super) fn half_sides(grid: &Grid) -> [f64; 2] {
    [
        0.5 * grid.nx as f64 * grid.dx,
        0.5 * grid.ny as f64 * grid.dy,
    ]
}

/// Coarse cells out of `n` and their weights in the linear interpolant at the fine cell `k`, wrapped around or
/// continued over the ends.
fn neighbours(k: usize, n: usize, is_periodic: bool) -> [(usize, f64); 2] {
    let near = k / 2;
    let other = if k.is_multiple_of(2) {
        near.checked_sub(1)
    } else {
        Some(near + 1)
    };
    match other {
        Some(other) if other < n => [(near, 0.75), (other, 0.25)],
        _ if n == 1 => [(near, 1.0), (near, 0.0)],
        _ if is_periodic => [(near, 0.75), (n - 1 - near, 0.25)],
        Some(_) => [(near, 0.75 + 0.5), (near - 1, -0.25)],
        None => [(near, 0.75 + 0.5), (near + 1, -0.25)],
    }
}

/// Points to which a product pads a side of `cells`.
fn padded(cells: usize) -> usize {
    fast_even_size(2 * cells - 1)
}

/// The largest margin from `least` to `most` on both sides of `length` cells whose transforms are no larger than those
/// with the least one.
fn fitting(length: usize, least: usize, most: usize) -> usize {
    let size = |margin: usize| padded(length + 2 * margin);
    (least..=most)
        .take_while(|margin| size(*margin) == size(least))
        .last()
        .unwrap_or(least)
}

/// A rectangle of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Region {
    pub(super) x: usize,
    pub(super) y: usize,
    pub(super) nx: usize,
    pub(super) ny: usize,
}

impl Region {
    pub(super) fn whole(grid: &Grid) -> Self {
        Self {
            x: 0,
            y: 0,
            nx: grid.nx,
            ny: grid.ny,
        }
    }

    /// The rectangle around all positive entries of a field with rows of `width`.
    fn bounds(field: &[f64], width: usize) -> Option<Self> {
        let (mut left, mut right, mut rows) = (width, 0, None);
        for (j, row) in field.chunks_exact(width).enumerate() {
            if let Some(first) = row.iter().position(|p| *p > 0.0) {
                let last = row.iter().rposition(|p| *p > 0.0).unwrap_or(first);
                left = left.min(first);
                right = right.max(last);
                rows = Some((rows.map_or(j, |(down, _)| down), j));
            }
        }
        let (down, up) = rows?;
        Some(Self {
            x: left,
            y: down,
            nx: right - left + 1,
            ny: up - down + 1,
        })
    }

    /// The rectangle around all positive entries, with a margin; the whole grid where that costs no more, with the gap
    /// outside of the rectangle where that `is_asked` for.
    pub(super) fn around(pressure: &[f64], grid: &Grid, is_asked: bool) -> Self {
        let Some(bounds) = Self::bounds(pressure, grid.nx) else {
            return Self::whole(grid);
        };
        let spread = |first: usize, length: usize, n: usize| {
            let margin = fitting(length, 3, 3 + length / 30);
            let from = first.saturating_sub(margin);
            (from, (first + length + margin).min(n) - from)
        };
        let (x, nx) = spread(bounds.x, bounds.nx, grid.nx);
        let (y, ny) = spread(bounds.y, bounds.ny, grid.ny);
        let cost = |nx: usize, ny: usize| (padded(nx) * padded(ny)) as f64;
        // a product on the whole grid tells the gap outside of the rectangle
        let part = if is_asked { 1.0 - 1.0 / PRODUCTS } else { 1.0 };
        if cost(nx, ny) >= part * cost(grid.nx, grid.ny) {
            return Self::whole(grid);
        }
        Self { x, y, nx, ny }
    }

    /// The rectangle around this one and another one.
    pub(super) fn joined(&self, other: &Self) -> Self {
        let join = |a: usize, long: usize, b: usize, wide: usize| {
            let first = a.min(b);
            (first, (a + long).max(b + wide) - first)
        };
        let (x, nx) = join(self.x, self.nx, other.x, other.nx);
        let (y, ny) = join(self.y, self.ny, other.y, other.ny);
        Self { x, y, nx, ny }
    }

    pub(super) fn points(&self) -> usize {
        self.nx * self.ny
    }

    /// The part of a field on a grid with rows of `width`.
    pub(super) fn cut(&self, field: &[f64], width: usize) -> Vec<f64> {
        let mut part = Vec::with_capacity(self.points());
        for j in self.y..self.y + self.ny {
            part.extend_from_slice(&field[j * width + self.x..j * width + self.x + self.nx]);
        }
        part
    }

    /// A field on `grid` that is zero outside.
    pub(super) fn paste(&self, part: &[f64], grid: &Grid) -> Vec<f64> {
        let mut field = vec![0.0; grid.points()];
        for (row, part) in part.chunks_exact(self.nx).enumerate() {
            let from = (self.y + row) * grid.nx + self.x;
            field[from..from + self.nx].copy_from_slice(part);
        }
        field
    }

    /// Whether pressure reaches a side of the rectangle that is not a side of the grid.
    pub(super) fn is_too_small(&self, part: &[f64], grid: &Grid) -> bool {
        let loaded = |i: usize, j: usize| part[j * self.nx + i] > 0.0;
        let row = |j: usize| (0..self.nx).any(|i| loaded(i, j));
        let column = |i: usize| (0..self.ny).any(|j| loaded(i, j));
        (self.x > 0 && column(0))
            || (self.y > 0 && row(0))
            || (self.x + self.nx < grid.nx && column(self.nx - 1))
            || (self.y + self.ny < grid.ny && row(self.ny - 1))
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cells that a particle has crossed on its way to the centre of one.

/// Shortest stretch of a path, over its cell, that is no corner of cells but for rounding.
const CORNER: f64 = 1e-9;
/// Sine or cosine below which a direction is along the cells but for rounding.
const ALONG: f64 = 1e-12;

/// A part of the way that ends at the centre of a cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossed {
    /// How many cells along x and y its cell is away.
    pub(crate) away: [isize; 2],
    /// Distance upstream [m] of its downstream end and of its upstream end.
    pub(crate) near: f64,
    pub(crate) far: f64,
    /// Derivatives of both by the direction [m].
    pub(crate) turned: [f64; 2],
}

impl Crossed {
    /// The number of its cell if the way ends at the centre of `cell` of a grid of a `shape`; `None` beside the grid.
    pub(crate) fn seen_from(&self, cell: [usize; 2], shape: [usize; 2]) -> Option<usize> {
        let place = |k: usize| {
            let there = cell[k].checked_add_signed(self.away[k])?;
            (there < shape[k]).then_some(there)
        };
        Some(place(1)? * shape[0] + place(0)?)
    }
}

/// The ways to all cells of a grid of a `shape`, of cells of the sizes `spacing` [m], where the contact moves along
/// `angle` [rad]: the same one for all, its own cell first. At a corner of cells stands a stretch without a length in
/// the cell that a larger angle crosses.
pub(crate) fn trail(shape: [usize; 2], spacing: [f64; 2], angle: f64) -> Vec<Crossed> {
    let (sin, cos) = angle.sin_cos();
    // a direction along the cells is meant where it is one but for rounding
    let along = [cos, sin].map(|c| if c.abs() < ALONG { 0.0 } else { c });
    // distance upstream to the next border along x and y, and from border to border
    let each: [f64; 2] = std::array::from_fn(|k| spacing[k] / along[k].abs());
    // how these distances change with the angle, over themselves
    let by_angle = [sin / cos, -cos / sin];
    let first_at_corner = usize::from(by_angle[1] < by_angle[0]);
    let mut next = each.map(|d| 0.5 * d);
    let mut away = [0_isize; 2];
    let (mut near, mut turned) = (0.0, 0.0);
    let mut found = Vec::new();
    while (0..2).all(|k| away[k].unsigned_abs() < shape[k]) {
        let is_corner = (next[0] - next[1]).abs() <= CORNER * each[0].min(each[1]);
        let axis = if is_corner {
            first_at_corner
        } else {
            usize::from(next[1] < next[0])
        };
        let far = if next[axis] - near > CORNER * each[axis] {
            next[axis]
        } else {
            near
        };
        let by_far = next[axis] * by_angle[axis];
        found.push(Crossed {
            away,
            near,
            far,
            turned: [turned, by_far],
        });
        (near, turned) = (far, by_far);
        next[axis] += each[axis];
        away[axis] += if along[axis] > 0.0 { 1 } else { -1 };
    }
    found
}

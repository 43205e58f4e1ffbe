// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_words::{Rough, Short};

use crate::Error;
use crate::error::{out_of_range, positive};

/// Points on the lower body with the undeformed gap above them; vectors are `(3, n)`,
/// component-major.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactPoints {
    /// Positions on the lower body [m].
    pub positions: Vec<f64>,
    /// Unit normals of the lower body, pointing up.
    pub normals: Vec<f64>,
    /// Unit tangents along the grid, whose rows run along x or along a turned body.
    pub tangents_x: Vec<f64>,
    /// Unit tangents across: normal times first tangent, rising with y.
    pub tangents_y: Vec<f64>,
    /// Arc length over the lower body from its crown, rising with y [m]; y itself where the lower body
    /// is no rail; n values.
    pub arc_lengths: Vec<f64>,
    /// Distance to the upper body along the normal [m], > 0 open; n values.
    pub gap: Vec<f64>,
}

impl ContactPoints {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.gap.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.gap.is_empty()
    }

    /// Component-major arrays of single points, with the tangents.
    pub(crate) fn new(points: &[ContactPoint]) -> Self {
        let vectors = |f: fn(&ContactPoint) -> [f64; 3]| -> Vec<f64> {
            (0..3)
                .flat_map(|i| points.iter().map(move |p| f(p)[i]))
                .collect()
        };
        Self {
            positions: vectors(|p| p.position),
            normals: vectors(|p| p.normal),
            tangents_x: vectors(|p| p.tangents()[0]),
            tangents_y: vectors(|p| p.tangents()[1]),
            arc_lengths: points.iter().map(|p| p.arc_length).collect(),
            gap: points.iter().map(|p| p.gap).collect(),
        }
    }
}

/// A contact point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactPoint {
    pub(crate) position: [f64; 3],
    pub(crate) normal: [f64; 3],
    /// Direction (x, y) of the grid's rows, of unit length.
    pub(crate) along: [f64; 2],
    pub(crate) arc_length: f64,
    pub(crate) gap: f64,
}

impl ContactPoint {
    /// The tangent above `along`, and the normal times it.
    fn tangents(&self) -> [[f64; 3]; 2] {
        let n = self.normal;
        let [x, y] = self.along;
        // n . t = 0 with t = (x n_z, y n_z, -(x n_x + y n_y)): exact for rows along x
        let t = [x * n[2], y * n[2], -(x * n[0] + y * n[1])];
        let r = t[0].hypot(t[1]).hypot(t[2]);
        let t = t.map(|c| c / r);
        let across = [
            n[1] * t[2] - n[2] * t[1],
            n[2] * t[0] - n[0] * t[2],
            n[0] * t[1] - n[1] * t[0],
        ];
        [t, across]
    }
}

/// One regular grid inside the flat arrays of a [`ContactGrid`]: `nx * ny` cells from `start` on, x fastest,
/// and `(nx + 1) * (ny + 1)` nodes from `node_start` on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridPatch {
    /// Cells along x.
    pub nx: usize,
    /// Cells across.
    pub ny: usize,
    /// First cell.
    pub start: usize,
    /// First node.
    pub node_start: usize,
    /// Cell size along the rows and across [m].
    pub spacing: [f64; 2],
    /// Its first node in the plane into which the surface is unrolled: along the rows and across (arc
    /// length) [m]. All patches of a contact share that plane.
    pub origin: [f64; 2],
}

/// A potential contact: regular grids of equal cells over the surface of the lower body.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactGrid {
    /// Cell centres.
    pub cells: ContactPoints,
    /// Corners of the cells.
    pub nodes: ContactPoints,
    /// Cell areas [m2].
    pub areas: Vec<f64>,
    /// The patches, left (y > 0) first.
    pub patches: Vec<GridPatch>,
}

/// More cells than this are taken for a mistake in the spacing.
pub(crate) const MOST_CELLS: f64 = 5e6;

/// Numbers of equal cells of about `spacing` [m] that fill a contact of `size` [m] exactly.
///
/// # Errors
/// Sizes and spacings that are not positive, cells that are wider than the contact or too many.
pub fn cells_over(size: [f64; 2], spacing: [f64; 2]) -> Result<[usize; 2], Error> {
    for (axis, [name, size_name]) in [
        ["spacing along x", "size along x"],
        ["spacing across", "size across"],
    ]
    .into_iter()
    .enumerate()
    {
        let (length, step) = (
            positive(size_name, size[axis])?,
            positive(name, spacing[axis])?,
        );
        if step > length * (1.0 + 1e-9) {
            let only = format!("the contact measures only {} m there", Short(length));
            return Err(out_of_range(name, step, only));
        }
    }
    if size[0] / spacing[0] * (size[1] / spacing[1]) > MOST_CELLS {
        return Err(out_of_range(
            "spacing",
            spacing[0].min(spacing[1]),
            format!("it would take more than {} cells", Rough(MOST_CELLS)),
        ));
    }
    Ok([0, 1].map(|axis| cell_count(size[axis], spacing[axis])))
}

/// Number of equal cells of about `spacing` that fill `length`, at least one.
pub(crate) fn cell_count(length: f64, spacing: f64) -> usize {
    ((length / spacing).round() as usize).max(1)
}

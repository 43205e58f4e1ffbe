// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ready scenes: which bodies stand where, and how they are held.

use std::sync::Arc;

use mtb_contact::problem::{FreeMotion, Problem};
use mtb_elasticity::Material;
use mtb_elasticity::half_space::{HalfSpace, HatHalfSpace, Neighbours, Patch};
use mtb_geometry::solid::block;
use mtb_geometry::{ContactPoints, GridPatch, PoleShoe, Profile};
use mtb_operator::{Compliance, Grid, Monitor, Relative};

use crate::standing::{Standing, at, beside};
use crate::{Contact, Error, Held};

/// The steel of the ready scenes: G = 80 GPa, Poisson's ratio 0.3.
pub const STEEL: Material = Material {
    shear_modulus: 80e9,
    poisson_ratio: 0.3,
};

/// Two half-spaces on the cells of a grid in a plane; `None` is a rigid body. See [`Contact::on_plane`].
///
/// # Errors
/// Materials that no body has, two rigid bodies, numbers that are not finite.
pub fn half_spaces(
    lower: Option<Material>,
    upper: Option<Material>,
    grid: Grid,
    gap: impl Fn(f64, f64) -> f64,
    motions: Vec<FreeMotion>,
) -> Result<Contact, Error> {
    let body = |material: Option<Material>| -> Result<Option<Arc<dyn Compliance>>, Error> {
        let Some(material) = material else {
            return Ok(None);
        };
        Ok(Some(Arc::new(HalfSpace::new(material, grid)?)))
    };
    let pair = Relative::new(body(lower)?, body(upper)?)?;
    Contact::on_plane(pair, grid, gap, motions)
}

/// The elastic pole shoe of a magnetic track brake on a rail, which is a half-space or rigid [Steininger2025].
#[derive(Clone, Debug)]
pub struct PoleShoeOnRail {
    /// The shoe and the rail that it stands on.
    pub shoe: PoleShoe,
    /// Flat top above the crown of the rail [m].
    pub height: f64,
    /// Spacing of the contact points along the shoe and across [m], met as well as whole numbers allow.
    pub spacing: [f64; 2],
    /// How the top of each pole is held.
    pub held: Held,
    /// Material of the shoe.
    pub upper: Material,
    /// Material of the rail; `None` is rigid.
    pub lower: Option<Material>,
}

impl Default for PoleShoeOnRail {
    /// Two poles of steel, 90 mm long, on a rail 60E1.
    fn default() -> Self {
        Self {
            shoe: PoleShoe {
                rail: Profile::rail_60e1(),
                length: 90e-3,
                inner_edge: 6e-3,
                conforming_to: 21.6e-3,
                outer_edge: 36e-3,
                relief_slope: 0.02,
                poles: 2,
                lateral: 0.0,
                yaw: 0.0,
            },
            height: 28.2e-3,
            spacing: [3e-3; 2],
            held: Held::default(),
            upper: STEEL,
            lower: Some(STEEL),
        }
    }
}

impl PoleShoeOnRail {
    /// Meshes the poles, holds them, and condenses them onto their contact points.
    ///
    /// # Errors
    /// A shoe that makes no sense, meshes too large to factorise, poles that miss the rail, an interruption.
    pub fn stand(&self, monitor: Monitor<'_>) -> Result<Contact, Error> {
        let grid = self.shoe.grid(self.spacing)?;
        let mut poles = Vec::new();
        for (patch, side) in grid.patches.iter().zip([1.0, -1.0]) {
            poles.push(self.pole(side, patch, &grid.nodes, monitor)?);
        }
        contact(&poles, self.lower, &grid.patches, &grid.nodes)
    }

    fn pole(
        &self,
        side: f64,
        grid: &GridPatch,
        nodes: &ContactPoints,
        monitor: Monitor<'_>,
    ) -> Result<Standing, Error> {
        let shoe = &self.shoe;
        // the strip in the shoe's own frame: evenly spaced along the arc of its sole
        let edges = [side * shoe.inner_edge, side * shoe.conforming_to];
        let ends = shoe.rail.arc_length(&edges)?;
        let arc: Vec<f64> = (0..=grid.ny)
            .map(|k| ends[0] + (ends[1] - ends[0]) * k as f64 / grid.ny as f64)
            .collect();
        let mut y = shoe.rail.position(&arc)?;
        for y in &mut y {
            *y = y.abs();
        }
        (y[0], y[grid.ny]) = (shoe.inner_edge, shoe.conforming_to);
        let x = spread(shoe.length, grid.nx);
        let (sin, cos) = shoe.yaw.sin_cos();
        let turn = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
        let aside = [0.0, shoe.lateral, self.lift(side, grid, nodes)];
        let mesh = shoe
            .solid(side, self.height, &x, &y, self.held.filling())?
            .moved(turn, aside);
        let across = 0.5 * (shoe.inner_edge + shoe.outer_edge) * side;
        let middle = [
            turn[0][1] * across + aside[0],
            turn[1][1] * across + aside[1],
            aside[2],
        ];
        let size = [shoe.length, shoe.outer_edge - shoe.inner_edge];
        let supports = self.held.supports(&mesh, middle, size, self.height, turn)?;
        let name = if side > 0.0 {
            "left pole"
        } else {
            "right pole"
        };
        Standing::new(name, mesh, self.upper, supports, grid, nodes, monitor)
    }

    /// How far a pole off its place was raised [m] until it just touches, as the gaps at the contact points have it.
    fn lift(&self, side: f64, grid: &GridPatch, nodes: &ContactPoints) -> f64 {
        let shoe = &self.shoe;
        if shoe.lateral == 0.0 && shoe.yaw == 0.0 {
            return 0.0;
        }
        let (sin, cos) = shoe.yaw.sin_cos();
        let count = (grid.nx + 1) * (grid.ny + 1);
        let heights = (grid.node_start..grid.node_start + count).filter_map(|i| {
            let (place, normal) = (at(&nodes.positions, i), at(&nodes.normals, i));
            let [x, y, z] = [0, 1, 2].map(|c| place[c] + nodes.gap[i] * normal[c]);
            let (sole, _) = shoe.sole(side, cos * (y - shoe.lateral) - sin * x)?;
            Some(z - sole)
        });
        heights.sum::<f64>() / count as f64
    }
}

/// An elastic block on a plane, which is a half-space or rigid.
#[derive(Clone, Debug)]
pub struct BlockOnPlane {
    /// Extents along x, y and z [m].
    pub size: [f64; 3],
    /// Spacing of the contact points along x and y [m], met as well as whole numbers allow.
    pub spacing: [f64; 2],
    /// How its top is held.
    pub held: Held,
    /// Material of the block.
    pub upper: Material,
    /// Material of the half-space; `None` is rigid.
    pub lower: Option<Material>,
}

impl BlockOnPlane {
    /// Meshes the block, holds it, and condenses it onto its contact points.
    ///
    /// # Errors
    /// Sizes that make no sense, a mesh too large to factorise, an interruption.
    pub fn stand(&self, monitor: Monitor<'_>) -> Result<Contact, Error> {
        let [length, width, height] = self.size;
        let cells = |extent: f64, step: f64| ((extent / step).round() as usize).max(1);
        let (nx, ny) = (
            cells(length, self.spacing[0]),
            cells(width, self.spacing[1]),
        );
        let (x, y) = (spread(length, nx), spread(width, ny));
        let mesh = block(&x, &y, height, self.held.filling())?;
        let n = x.len() * y.len();
        let axis = |c: usize| -> Vec<f64> {
            (0..3 * n)
                .map(|k| f64::from(u8::from(k / n == c)))
                .collect()
        };
        let mut positions = x.repeat(y.len());
        positions.extend(y.iter().flat_map(|y| vec![*y; x.len()]));
        let arc_lengths = positions[n..].to_vec();
        positions.resize(3 * n, 0.0);
        let nodes = ContactPoints {
            positions,
            normals: axis(2),
            tangents_x: axis(0),
            tangents_y: axis(1),
            arc_lengths,
            gap: vec![0.0; n],
        };
        let grid = GridPatch {
            nx,
            ny,
            start: 0,
            node_start: 0,
            spacing: [length / nx as f64, width / ny as f64],
            origin: [x[0], y[0]],
        };
        let unturned = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let supports = self
            .held
            .supports(&mesh, [0.0; 3], [length, width], height, unturned)?;
        let body = Standing::new("block", mesh, self.upper, supports, &grid, &nodes, monitor)?;
        contact(&[body], self.lower, &[grid], &nodes)
    }
}

/// Evenly spaced stations about the middle of an extent [m].
fn spread(extent: f64, cells: usize) -> Vec<f64> {
    (0..=cells)
        .map(|k| (k as f64 / cells as f64 - 0.5) * extent)
        .collect()
}

/// Elastic bodies side by side on the nodes of grids, above a half-space or a rigid body.
fn contact(
    bodies: &[Standing],
    lower: Option<Material>,
    grids: &[GridPatch],
    nodes: &ContactPoints,
) -> Result<Contact, Error> {
    let (upper, geometry, motions) = beside(bodies, nodes);
    let below: Option<Arc<dyn Compliance>> = match lower {
        None => None,
        Some(material) => {
            let patches = grids.iter().map(|g| {
                Ok(Patch {
                    x0: g.origin[0],
                    y0: g.origin[1],
                    grid: Grid::new(g.nx + 1, g.ny + 1, g.spacing[0], g.spacing[1])?,
                })
            });
            let patches = patches.collect::<Result<Vec<_>, Error>>()?;
            Some(Arc::new(HatHalfSpace::new(
                material,
                patches,
                Neighbours::Interact,
            )?))
        }
    };
    let pair = Relative::new(below, Some(upper))?;
    Ok(Contact {
        problem: Problem::new(pair, Arc::new(geometry), motions)?,
        gap: nodes.gap.clone(),
    })
}

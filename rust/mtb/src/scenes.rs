// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ready scenes: which bodies stand where, and how they are held.

use std::sync::Arc;

use mtb_contact::problem::{Body, FreeMotion, Problem, Window};
use mtb_elasticity::Material;
use mtb_elasticity::half_space::{HalfSpace, HatHalfSpace, Neighbours, Patch};
use mtb_elasticity::tetra::{Hold, Support};
use mtb_geometry::solid::{self, RailSection, SolidMesh, block};
use mtb_geometry::{ContactPoints, GridPatch, PoleShoe, Profile, cells_over};
use mtb_operator::{Compliance, Grid, Monitor, Relative};

use crate::standing::{Standing, at, beside, condense};
use crate::{Contact, Error, Held};

/// The steel of the ready scenes: G = 80 GPa, Poisson's ratio 0.3.
pub const STEEL: Material = Material {
    shear_modulus: 80e9,
    poisson_ratio: 0.3,
};

/// Two half-spaces on the cells of a grid in a plane; `None` is a rigid body. See [`Contact::on_plane`].
///
/// They go on beyond the grid, so a contact that reaches its edge is refused, by what is prepared from it as well.
/// Bodies that end at the edge are made by [`Contact::on_plane`].
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
    let window = Window {
        start: 0,
        nx: grid.nx,
        ny: grid.ny,
    };
    Contact::on_cells(pair, grid, gap, motions, vec![window])
}

/// The body that a rail is taken for.
#[derive(Clone, Copy, Debug)]
pub enum Rail {
    /// One that does not deform.
    Rigid,
    /// A half-space: right while the contact is small beside the head.
    HalfSpace(Material),
    /// Finite elements of head, web and foot, held at the base.
    Elastic {
        /// Material of the rail.
        material: Material,
        /// Its section below the running surface.
        section: RailSection,
        /// Its length [m], centred below the shoe.
        length: f64,
    },
}

/// The elastic pole shoe of a magnetic track brake on a rail [Steininger2025].
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
    /// What the rail is taken for.
    pub lower: Rail,
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
            lower: Rail::HalfSpace(STEEL),
        }
    }
}

impl PoleShoeOnRail {
    /// Meshes the poles, and the rail if it is elastic, holds them, and condenses them onto their contact points.
    ///
    /// # Errors
    /// A shoe that makes no sense, meshes too large to factorise, poles that miss the rail or are longer than it,
    /// an interruption.
    pub fn stand(&self, monitor: Monitor<'_>) -> Result<Contact, Error> {
        let grid = self.shoe.grid(self.spacing)?;
        for patch in &grid.patches {
            let filled = |n: usize, axis: usize| n as f64 * patch.spacing[axis];
            cells_over([filled(patch.nx, 0), filled(patch.ny, 1)], self.spacing)?;
        }
        let mut poles = Vec::new();
        for (patch, side) in grid.patches.iter().zip([1.0, -1.0]) {
            poles.push(self.pole(side, patch, &grid.nodes, monitor)?);
        }
        let below = match self.lower {
            Rail::Rigid => None,
            Rail::HalfSpace(material) => Some(foundation(material, &grid.patches)?),
            Rail::Elastic {
                material,
                section,
                length,
            } => {
                let (patches, nodes) = (&grid.patches, &grid.nodes);
                let (x, rows) = lines_below(patches, nodes);
                let (left, right) = (&rows[0], &rows[rows.len() - 1]);
                let mesh = section.solid(&self.shoe.rail, &x, left, Some(right), length, true)?;
                let base = Support {
                    name: "base".to_owned(),
                    nodes: mesh.set("base").unwrap_or_default().to_vec(),
                    hold: [Hold::Prescribed; 3],
                };
                let on = (&patches[..], nodes);
                let (_, _, rail) = condense(
                    (mesh, "head"),
                    material,
                    vec![base],
                    on,
                    Body::Lower,
                    monitor,
                )?;
                let rail: Arc<dyn Compliance> = Arc::new(rail.flexibility);
                Some(rail)
            }
        };
        contact(&poles, below, &grid.nodes)
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

/// Lines along x for the mesh of a rail below patches, and |y| of their rows, patch by patch, both rising.
fn lines_below(patches: &[GridPatch], nodes: &ContactPoints) -> (Vec<f64>, Vec<Vec<f64>>) {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let n = nodes.len();
    let (mut along, mut rows) = (Vec::new(), Vec::new());
    for patch in patches {
        let (nx, ny) = (patch.nx + 1, patch.ny + 1);
        let own = patch.node_start..patch.node_start + nx * ny;
        let (x, y) = (
            &nodes.positions[..n][own.clone()],
            &nodes.positions[n..2 * n][own],
        );
        let column = |i: usize| mean(&(0..ny).map(|j| x[j * nx + i]).collect::<Vec<_>>());
        along.push((0..nx).map(column).collect::<Vec<_>>());
        let mut row: Vec<f64> = y.chunks_exact(nx).map(|row| mean(row).abs()).collect();
        row.sort_by(f64::total_cmp);
        rows.push(row);
    }
    (solid::rail_lines(&along), rows)
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
        let cells = cells_over([length, width], self.spacing)?;
        let (x, y) = (spread(length, cells[0]), spread(width, cells[1]));
        let mesh = block(&x, &y, height, self.held.filling())?;
        let unturned = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let supports = self
            .held
            .supports(&mesh, [0.0; 3], [length, width], height, unturned)?;
        BodyOnPlane {
            mesh,
            material: self.upper,
            supports,
            face: [length, width],
            spacing: self.spacing,
            lower: self.lower,
        }
        .stand(monitor)
    }
}

/// An elastic body of your own, as a mesh with its supports, on the plane z = 0, which is a half-space or rigid.
#[derive(Clone, Debug)]
pub struct BodyOnPlane {
    /// Tetrahedra above the plane; the nodes of its set "contact" span the face that touches it.
    pub mesh: SolidMesh,
    /// Material of the body.
    pub material: Material,
    /// How it is held: nodes, and which of their displacements keep their place.
    pub supports: Vec<Support>,
    /// Extents [m] along x and y of the face, a rectangle about the origin.
    pub face: [f64; 2],
    /// Spacing of the contact points along x and y [m], met as well as whole numbers allow.
    pub spacing: [f64; 2],
    /// Material of the half-space; `None` is rigid.
    pub lower: Option<Material>,
}

impl BodyOnPlane {
    /// Condenses the body onto its contact points.
    ///
    /// # Errors
    /// A mesh that is no body or is too large to factorise, supports that contradict each other, a face that is not
    /// the rectangle that was stated, an interruption.
    pub fn stand(self, monitor: Monitor<'_>) -> Result<Contact, Error> {
        let [length, width] = self.face;
        let [nx, ny] = cells_over(self.face, self.spacing)?;
        let (x, y) = (spread(length, nx), spread(width, ny));
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
        let patch = GridPatch {
            nx,
            ny,
            start: 0,
            node_start: 0,
            spacing: [length / nx as f64, width / ny as f64],
            origin: [x[0], y[0]],
        };
        let (mesh, supports) = (self.mesh, self.supports);
        let body = Standing::new(
            "body",
            mesh,
            self.material,
            supports,
            &patch,
            &nodes,
            monitor,
        )?;
        let below = self.lower.map(|material| foundation(material, &[patch]));
        contact(&[body], below.transpose()?, &nodes)
    }
}

/// Evenly spaced stations about the middle of an extent [m].
fn spread(extent: f64, cells: usize) -> Vec<f64> {
    (0..=cells)
        .map(|k| (k as f64 / cells as f64 - 0.5) * extent)
        .collect()
}

/// A half-space below the nodes of patches.
fn foundation(material: Material, patches: &[GridPatch]) -> Result<Arc<dyn Compliance>, Error> {
    let patches = patches.iter().map(|p| {
        Ok(Patch {
            x0: p.origin[0],
            y0: p.origin[1],
            grid: Grid::new(p.nx + 1, p.ny + 1, p.spacing[0], p.spacing[1])?,
        })
    });
    let patches = patches.collect::<Result<Vec<_>, Error>>()?;
    Ok(Arc::new(HatHalfSpace::new(
        material,
        patches,
        Neighbours::Interact,
    )?))
}

/// Elastic bodies side by side on contact points, above a body or a rigid one.
fn contact(
    bodies: &[Standing],
    below: Option<Arc<dyn Compliance>>,
    nodes: &ContactPoints,
) -> Result<Contact, Error> {
    let above = beside(bodies, nodes);
    let pair = Relative::new(below, Some(above.compliance))?;
    Ok(Contact {
        problem: Problem::new(pair, Arc::new(above.geometry), above.motions)?,
        gap: nodes.gap.clone(),
        spread: above.spread,
    })
}

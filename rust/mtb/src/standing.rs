// SPDX-License-Identifier: MIT OR Apache-2.0
//! Elastic bodies where they stand on contact points.

use std::collections::BTreeMap;
use std::sync::Arc;

use mtb_contact::problem::{Body, FreeMotion, Geometry, Loading, Means};
use mtb_contact::sliding::RigidMotion;
use mtb_elasticity::Material;
use mtb_elasticity::tetra::{
    Averages, CondensedBody, ContactGrid, Limits, Order, Sampling, Support, TetraBody, TetraMesh,
};
use mtb_geometry::solid::SolidMesh;
use mtb_geometry::{ContactPoints, GridPatch};
use mtb_operator::{Compliance, Monitor, Separate};

use crate::Error;

/// Share of its area by which a grid may miss the face of its elastic body.
const COVERAGE: f64 = 0.01;

/// An elastic body above a grid of contact points, condensed onto them.
pub(crate) struct Standing {
    compliance: Arc<dyn Compliance>,
    weights: Vec<f64>,
    /// Of each free motion: of the points along both tangents and into the body (3n).
    modes: Vec<Vec<f64>>,
    /// Means of tangents and normal over each point.
    frames: Vec<[[f64; 3]; 3]>,
    /// Mean places [m] of the points on the face below.
    places: Vec<[f64; 3]>,
    /// Share of the basis function of other points in the area of each.
    shares: Vec<BTreeMap<usize, f64>>,
    /// Of a unit force [N] along and moment [N m] about x, y and z through the centre of the body, spread over
    /// it: displacement (3n) [m] of its points, as in `modes`.
    spread_displacement: Vec<Vec<f64>>,
    /// The generalised loads of the same on the free motions.
    spread_loads: Vec<[f64; 6]>,
    /// From the centre of the body to the middle of its contact points [m].
    arm: [f64; 3],
}

/// What a force and moments do that act on one of several elastic bodies, spread over it as weight is.
pub(crate) struct Spread {
    /// What opens at each point (n) [m] by a unit force along and moment about x, y and z.
    opening: Vec<Vec<f64>>,
    /// The first free motion of the body, and the generalised loads of the same on it and on those that follow.
    loads: (usize, Vec<[f64; 6]>),
    arm: [f64; 3],
}

impl Spread {
    /// Adds a force [N] down through the middle of the contact points, and moments [N m] about x and y.
    pub(crate) fn load(&self, loading: &mut Loading, force: f64, moments: [f64; 2]) {
        let wrench = [
            0.0,
            0.0,
            -force,
            moments[0] - self.arm[1] * force,
            moments[1] + self.arm[0] * force,
            0.0,
        ];
        for (opening, amount) in self.opening.iter().zip(wrench) {
            for (gap, opening) in loading.gap.iter_mut().zip(opening) {
                *gap += amount * opening;
            }
        }
        let (first, loads) = &self.loads;
        for (work, unit) in loading.work[*first..].iter_mut().zip(loads) {
            *work += unit.iter().zip(wrench).map(|(u, w)| u * w).sum::<f64>();
        }
    }
}

/// Condenses a mesh, whose set `face` carries the contact, onto the nodes of patches.
pub(crate) fn condense(
    (mesh, face): (SolidMesh, &str),
    material: Material,
    supports: Vec<Support>,
    (patches, nodes): (&[GridPatch], &ContactPoints),
    body: Body,
    monitor: Monitor<'_>,
) -> Result<(TetraBody, Sampling, CondensedBody), Error> {
    let mut is_contact = vec![false; mesh.nodes.len()];
    for &node in mesh.set(face).unwrap_or_default() {
        is_contact[node] = true;
    }
    let order = match mesh.nodes_per_cell {
        4 => Order::Linear,
        _ => Order::Quadratic,
    };
    let core = TetraMesh::new(mesh.nodes, mesh.cells, order)?;
    let is_face = |face: &usize| core.face(*face)[..3].iter().all(|node| is_contact[*node]);
    let faces: Vec<usize> = (0..core.n_faces()).filter(is_face).collect();
    // the points lie on the lower body, the upper one a gap away from them
    let (lift, into) = match body {
        Body::Upper => (1.0, 1.0),
        Body::Lower => (0.0, -1.0),
    };
    let raised = |i: usize| -> [f64; 3] {
        let (place, normal) = (at(&nodes.positions, i), at(&nodes.normals, i));
        std::array::from_fn(|c| place[c] + lift * nodes.gap[i] * normal[c])
    };
    let frame = |i: usize| {
        [
            at(&nodes.tangents_x, i),
            at(&nodes.tangents_y, i),
            at(&nodes.normals, i).map(|c| into * c),
        ]
    };
    let samplings = patches.iter().map(|patch| {
        let (nx, ny) = (patch.nx + 1, patch.ny + 1);
        let own = patch.node_start..patch.node_start + nx * ny;
        let grid = ContactGrid {
            nx,
            ny,
            spacing: patch.spacing,
            points: own.clone().map(raised).collect(),
            frames: own.map(frame).collect(),
        };
        grid.sampling(&core, &faces)
    });
    let sampling = Sampling::joined(&samplings.collect::<Result<Vec<_>, _>>()?);
    let body = TetraBody::new(core, material, supports)?;
    let condensed = body.condense(&sampling, Limits::default(), monitor)?;
    Ok((body, sampling, condensed))
}

/// A vector of a point.
pub(crate) fn at(field: &[f64], point: usize) -> [f64; 3] {
    let n = field.len() / 3;
    [0, 1, 2].map(|c| field[c * n + point])
}

impl Standing {
    /// Condenses a mesh, whose set "contact" is the face, onto the nodes of a grid.
    pub(crate) fn new(
        name: &str,
        mesh: SolidMesh,
        material: Material,
        supports: Vec<Support>,
        grid: &GridPatch,
        nodes: &ContactPoints,
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let own = grid.node_start..grid.node_start + (grid.nx + 1) * (grid.ny + 1);
        let (body, sampling, condensed) = condense(
            (mesh, "contact"),
            material,
            supports,
            (&[*grid], nodes),
            Body::Upper,
            monitor,
        )?;
        let weights = sampling.weights();
        let whole = grid.spacing[0] * grid.spacing[1] * (grid.nx * grid.ny) as f64;
        let share = weights.iter().sum::<f64>() / whole;
        if (share - 1.0).abs() > COVERAGE {
            return Err(Error::Missed {
                body: name.to_owned(),
                share: 100.0 * share,
            });
        }
        let Averages {
            frames,
            mut places,
            shares,
        } = sampling.averages(body.mesh())?;
        let mut arm = condensed.centre.map(|c| -c);
        for (place, i) in places.iter_mut().zip(own.clone()) {
            let normal = at(&nodes.normals, i);
            for c in 0..3 {
                place[c] -= nodes.gap[i] * normal[c];
                arm[c] += at(&nodes.positions, i)[c] / own.len() as f64;
            }
        }
        let spread_loads = condensed.modes.iter().map(|mode| {
            let moved = mode.displacement(condensed.centre);
            let [wx, wy, wz] = mode.rotation;
            [moved[0], moved[1], moved[2], wx, wy, wz]
        });
        Ok(Self {
            spread_loads: spread_loads.collect(),
            spread_displacement: condensed.spread_displacement,
            arm,
            compliance: Arc::new(condensed.flexibility),
            weights,
            modes: condensed.mode_displacement,
            frames,
            places,
            shares,
        })
    }
}

/// Elastic bodies side by side.
pub(crate) struct Beside {
    pub(crate) compliance: Arc<dyn Compliance>,
    pub(crate) geometry: Geometry,
    pub(crate) motions: Vec<FreeMotion>,
    pub(crate) spread: Vec<Spread>,
}

/// The contact of elastic bodies side by side.
pub(crate) fn beside(bodies: &[Standing], nodes: &ContactPoints) -> Beside {
    let n = nodes.len();
    let mut means = Means {
        start: vec![0],
        column: Vec::new(),
        share: Vec::new(),
    };
    let mut mean_frame = [vec![0.0; 3 * n], vec![0.0; 3 * n], vec![0.0; 3 * n]];
    let mut points = vec![0.0; 3 * n];
    let mut area = Vec::with_capacity(n);
    let mut motions = Vec::new();
    let mut spread = Vec::new();
    for body in bodies {
        let first = area.len();
        let own = body.weights.len();
        for i in 0..own {
            for c in 0..3 {
                points[c * n + first + i] = body.places[i][c];
                for axis in 0..3 {
                    mean_frame[axis][c * n + first + i] = body.frames[i][axis][c];
                }
            }
            means
                .column
                .extend(body.shares[i].keys().map(|j| first + j));
            means.share.extend(body.shares[i].values());
            means.start.push(means.column.len());
        }
        area.extend(&body.weights);
        let openings = body.spread_displacement.iter().map(|displacement| {
            let mut opening = vec![0.0; n];
            opening[first..first + own].copy_from_slice(&displacement[2 * own..]);
            opening
        });
        spread.push(Spread {
            opening: openings.collect(),
            loads: (motions.len(), body.spread_loads.clone()),
            arm: body.arm,
        });
        for mode in &body.modes {
            // tractions act on the lower body, and the normal points into the upper one
            let spread = |component: usize, sign: f64| {
                let mut field = vec![0.0; n];
                for i in 0..own {
                    field[first + i] = sign * mode[component * own + i];
                }
                field
            };
            motions.push(FreeMotion {
                body: Body::Upper,
                motion: RigidMotion {
                    tangential_x: spread(0, -1.0),
                    tangential_y: spread(1, -1.0),
                    opening: spread(2, 1.0),
                    work: 0.0,
                },
                is_pulled: true,
            });
        }
    }
    let parts: Vec<_> = bodies.iter().map(|body| body.compliance.clone()).collect();
    let geometry = Geometry {
        points,
        normal: nodes.normals.clone(),
        tangent_x: nodes.tangents_x.clone(),
        tangent_y: nodes.tangents_y.clone(),
        area,
        mean_frame,
        means: Some(means),
        windows: Vec::new(),
    };
    Beside {
        compliance: Arc::new(Separate(parts)),
        geometry,
        motions,
        spread,
    }
}

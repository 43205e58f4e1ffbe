// SPDX-License-Identifier: MIT OR Apache-2.0
//! Elastic bodies where they stand on contact points.

use std::collections::BTreeMap;
use std::sync::Arc;

use mtb_contact::problem::{Body, FreeMotion, Geometry, Means};
use mtb_contact::sliding::RigidMotion;
use mtb_elasticity::Material;
use mtb_elasticity::tetra::{ContactGrid, Limits, Order, Sampling, Support, TetraBody, TetraMesh};
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
        let mut is_contact = vec![false; mesh.nodes.len()];
        for &node in mesh.set("contact").unwrap_or_default() {
            is_contact[node] = true;
        }
        let order = match mesh.nodes_per_cell {
            4 => Order::Linear,
            _ => Order::Quadratic,
        };
        let core = TetraMesh::new(mesh.nodes, mesh.cells, order)?;
        let is_face = |face: &usize| core.face(*face)[..3].iter().all(|node| is_contact[*node]);
        let faces: Vec<usize> = (0..core.n_faces()).filter(is_face).collect();
        let (nx, ny) = (grid.nx + 1, grid.ny + 1);
        let own = grid.node_start..grid.node_start + nx * ny;
        // the contact points lie on the lower body, the upper one a gap away from it
        let raised = |i: usize| -> [f64; 3] {
            let (place, normal) = (at(&nodes.positions, i), at(&nodes.normals, i));
            std::array::from_fn(|c| place[c] + nodes.gap[i] * normal[c])
        };
        let frame = |i: usize| {
            [&nodes.tangents_x, &nodes.tangents_y, &nodes.normals].map(|field| at(field, i))
        };
        let sampling = ContactGrid {
            nx,
            ny,
            spacing: grid.spacing,
            points: own.clone().map(raised).collect(),
            frames: own.clone().map(frame).collect(),
        }
        .sampling(&core, &faces)?;
        let weights = sampling.weights();
        let whole = grid.spacing[0] * grid.spacing[1] * (grid.nx * grid.ny) as f64;
        let share = weights.iter().sum::<f64>() / whole;
        if (share - 1.0).abs() > COVERAGE {
            return Err(Error::Missed {
                body: name.to_owned(),
                share: 100.0 * share,
            });
        }
        let (frames, mut places, shares) = averages(&sampling, &core, &weights);
        for (place, i) in places.iter_mut().zip(own) {
            let normal = at(&nodes.normals, i);
            for c in 0..3 {
                place[c] -= nodes.gap[i] * normal[c];
            }
        }
        let condensed = TetraBody::new(core, material, supports)?.condense(
            &sampling,
            Limits::default(),
            monitor,
        )?;
        Ok(Self {
            compliance: Arc::new(condensed.flexibility),
            weights,
            modes: condensed.mode_displacement,
            frames,
            places,
            shares,
        })
    }
}

type Averages = (Vec<[[f64; 3]; 3]>, Vec<[f64; 3]>, Vec<BTreeMap<usize, f64>>);

/// Means of the frames and places over each point, and the overlaps of the basis functions.
fn averages(sampling: &Sampling, mesh: &TetraMesh, weights: &[f64]) -> Averages {
    let n = sampling.n_points();
    let mut frames = vec![[[0.0; 3]; 3]; n];
    let mut places = vec![[0.0; 3]; n];
    let mut shares = vec![BTreeMap::new(); n];
    for (q, point) in sampling.quadrature().iter().enumerate() {
        let corners = mesh.face(point.face);
        let place: [f64; 3] = std::array::from_fn(|c| {
            let parts = corners.iter().zip(point.barycentric);
            parts.map(|(node, b)| b * mesh.nodes()[*node][c]).sum()
        });
        for &(i, phi) in sampling.basis(q) {
            let part = point.weight * phi / weights[i];
            for c in 0..3 {
                places[i][c] += part * place[c];
                for axis in 0..3 {
                    frames[i][axis][c] += part * point.frame[axis][c];
                }
            }
            for &(j, other) in sampling.basis(q) {
                *shares[i].entry(j).or_insert(0.0) += part * other;
            }
        }
    }
    (frames, places, shares)
}

/// The contact of elastic bodies side by side: their compliance, the points, and the motions that are free.
pub(crate) fn beside(
    bodies: &[Standing],
    nodes: &ContactPoints,
) -> (Arc<dyn Compliance>, Geometry, Vec<FreeMotion>) {
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
    };
    (Arc::new(Separate(parts)), geometry, motions)
}

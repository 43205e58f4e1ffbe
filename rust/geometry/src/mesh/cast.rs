// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lines against the curved surface of a mesh.

use nalgebra::Vector3;
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQueryWithLocation;

use super::{MILLIMETRES, SurfaceMesh};
use crate::{Found, Hit, Surface};

/// Slack of the barycentric coordinates, so that no line slips between two facets.
const SLACK: f64 = 1e-9;

/// A point of a facet.
pub(super) struct Facet {
    pub(super) triangle: usize,
    weights: [f64; 3],
    pub(super) distance: f64,
}

impl SurfaceMesh {
    /// Facets that face the direction and meet the line `point + t direction` for `t` in `from..=to`.
    pub(super) fn facets(
        &self,
        point: &Vector3<f64>,
        direction: &Vector3<f64>,
        range: [f64; 2],
    ) -> Vec<Facet> {
        let (p, d) = (point * MILLIMETRES, direction);
        let pad = 1e-9 * self.size * MILLIMETRES;
        let [from, to] = range.map(|t| t * MILLIMETRES);
        let leaves = self.tree.bvh().leaves(|node| {
            let (low, high) = (node.mins().to_array(), node.maxs().to_array());
            let (mut first, mut last) = (from, to);
            for i in 0..3 {
                let (a, b) = (low[i] - pad - p[i], high[i] + pad - p[i]);
                if d[i] == 0.0 {
                    if a > 0.0 || b < 0.0 {
                        return false;
                    }
                } else {
                    let (a, b) = (a / d[i], b / d[i]);
                    first = first.max(a.min(b));
                    last = last.min(a.max(b));
                }
            }
            first <= last
        });
        leaves
            .filter_map(|leaf| self.crossing(leaf as usize, point, direction))
            .filter(|f| f.distance >= range[0] && f.distance <= range[1])
            .collect()
    }

    /// Where a line crosses a facet that faces it [Möller and Trumbore].
    pub(super) fn crossing(
        &self,
        triangle: usize,
        point: &Vector3<f64>,
        direction: &Vector3<f64>,
    ) -> Option<Facet> {
        if self.normals[triangle].dot(direction) >= 0.0 {
            return None;
        }
        let [a, b, c] = self.triangles[triangle].map(|v| self.vertices[v]);
        let (ab, ac, ap) = (b - a, c - a, point - a);
        let cross = direction.cross(&ac);
        let det = ab.dot(&cross);
        let v = ap.dot(&cross) / det;
        let other = ap.cross(&ab);
        let w = direction.dot(&other) / det;
        let inside = v >= -SLACK && w >= -SLACK && v + w <= 1.0 + SLACK;
        inside.then(|| Facet {
            triangle,
            weights: [1.0 - v - w, v, w],
            distance: ac.dot(&other) / det,
        })
    }

    /// From a facet to the curved surface behind it, along the line.
    fn curved(&self, point: &Vector3<f64>, direction: &Vector3<f64>, facet: &Facet) -> Hit {
        let mut t = facet.distance;
        let mut normal = self.normals[facet.triangle];
        let mut error = 0.0;
        // the blended height is nearly linear along the line: few steps to rounding
        for _ in 0..8 {
            let at = point + direction * t;
            let mut height = 0.0;
            let mut gradient = Vector3::zeros();
            error = 0.0;
            for corner in 0..3 {
                let (h, g, e) = self.fit(facet.triangle, corner).above(&at);
                height += facet.weights[corner] * h;
                gradient += g * facet.weights[corner];
                error += facet.weights[corner] * e;
            }
            let closing = gradient.dot(direction);
            let step = -height / closing;
            t += step;
            error /= closing.abs();
            normal = gradient.normalize();
            if step.abs() <= 1e-16 + 4.0 * f64::EPSILON * t.abs() {
                break;
            }
        }
        Hit {
            distance: t,
            normal: normal.into(),
            facet_error: error,
            found: Found::OnLine,
        }
    }

    /// The nearest point not farther than `reach`; its distance is negative inside the body.
    pub(super) fn nearest(&self, point: &Vector3<f64>, reach: f64) -> Option<Hit> {
        let p = Vector::new(point.x, point.y, point.z) * MILLIMETRES;
        let (projection, (triangle, _)) = self
            .tree
            .project_local_point_and_get_location_with_max_dist(p, false, reach * MILLIMETRES)?;
        let towards = Vector3::from((projection.point - p).to_array()) / MILLIMETRES;
        let mut normal = self.normals[triangle as usize];
        let side = if towards.dot(&normal) > 0.0 {
            -1.0
        } else {
            1.0
        };
        let mut nearest = Hit {
            distance: side * towards.norm(),
            normal: normal.into(),
            facet_error: 0.0,
            found: Found::Nearest,
        };
        // from the facets to the curved surface: follow its normal; edges of the body stay as they are
        for _ in 0..6 {
            let line = -normal;
            let facets = self.facets(point, &line, [-2.0 * reach, 2.0 * reach]);
            let closest = facets
                .iter()
                .min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()));
            let Some(hit) = closest.map(|facet| self.curved(point, &line, facet)) else {
                break;
            };
            if (hit.distance.abs() - nearest.distance.abs()).abs() > towards.norm() {
                break;
            }
            nearest = Hit {
                found: Found::Nearest,
                ..hit
            };
            normal = Vector3::from(hit.normal);
        }
        (nearest.distance.abs() <= reach).then_some(nearest)
    }
}

impl Surface for SurfaceMesh {
    fn top(&self, x: f64, y: f64) -> Option<Hit> {
        let above = self.tree.local_aabb().maxs.z / MILLIMETRES + self.size;
        let (point, down) = (Vector3::new(x, y, above), Vector3::new(0.0, 0.0, -1.0));
        let facets = self.facets(&point, &down, [0.0, 4.0 * self.size]);
        let first = facets
            .iter()
            .min_by(|a, b| a.distance.total_cmp(&b.distance))?;
        let hit = self.curved(&point, &down, first);
        Some(Hit {
            distance: above - hit.distance,
            ..hit
        })
    }

    fn cast(&self, point: [f64; 3], direction: [f64; 3], reach: f64) -> Option<Hit> {
        let (point, direction) = (Vector3::from(point), Vector3::from(direction));
        let facets = self.facets(&point, &direction, [-reach, reach]);
        let closest = facets
            .iter()
            .min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()));
        match closest {
            Some(facet) => Some(self.curved(&point, &direction, facet)),
            None => self.nearest(&point, reach),
        }
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use nalgebra::{DMatrix, MatrixXx6, RowVector6, Vector3, Vector6};

use super::mesh::TetraMesh;
use super::support::{AXES, Claims};

/// A small rigid motion that the supports of a body leave free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMode {
    /// Displacement at `point`, per unit amplitude.
    pub translation: [f64; 3],
    /// Rotation vector per unit amplitude [1/m or rad].
    pub rotation: [f64; 3],
    /// Reference point [m].
    pub point: [f64; 3],
}

impl RigidMode {
    /// Displacement at `x` per unit amplitude.
    pub fn displacement(&self, x: [f64; 3]) -> [f64; 3] {
        let arm = Vector3::from(x) - Vector3::from(self.point);
        let u = Vector3::from(self.translation) + Vector3::from(self.rotation).cross(&arm);
        [u.x, u.y, u.z]
    }

    /// Displacement at `point` along x, y and z, and rotation about them.
    pub(super) fn coordinates(&self) -> [f64; 6] {
        let ([x, y, z], [roll, pitch, yaw]) = (self.translation, self.rotation);
        [x, y, z, roll, pitch, yaw]
    }

    /// The coordinate that it is named by: the largest one, of rotation where it turns.
    pub(super) fn component(&self) -> usize {
        let all = self.coordinates();
        let range = if self.rotation == [0.0; 3] {
            0..3
        } else {
            3..6
        };
        let first = range.start;
        range.fold(first, |best, k| {
            // a hair's breadth larger is not larger: keeps the choice independent of rounding
            if all[k].abs() > all[best].abs() * (1.0 + 1e-9) {
                k
            } else {
                best
            }
        })
    }

    /// The motion in words, such as "rotation about y".
    pub fn name(&self) -> String {
        let rotation = Vector3::from(self.rotation);
        let (what, axis) = if rotation.norm() > 0.0 {
            ("rotation about", rotation)
        } else {
            ("translation along", Vector3::from(self.translation))
        };
        let axis = axis / axis.norm();
        match (0..3).find(|&c| axis[c].abs() > 1.0 - 1e-9) {
            Some(c) => format!("{what} {}", AXES[c]),
            None => format!("{what} ({:.3}, {:.3}, {:.3})", axis.x, axis.y, axis.z),
        }
    }
}

/// Relative size below which an eigenvalue of a Gram matrix of motions counts as zero: motions of
/// 3e-6 of the size of the body.
const NEGLIGIBLE: f64 = 1e-11;

/// How far a motion must move supports, over the size of the body, to be held by them. Against one that moves them less,
/// supports would yield 1e8 times as much as the body does, and no contact is found on that; the contact holds it.
const HELD: f64 = 1e-4;

/// Share of a motion that is rounding: some 1e-16 over what is hardly negligible.
const ROUNDING: f64 = 1e-9;

/// Coordinates in which motions are told apart: along z, about x and y, along x and y, about z.
const PREFERENCE: [usize; 6] = [2, 3, 4, 0, 1, 5];

/// The space of rigid motions that a set of conditions leaves free.
#[derive(Clone, Debug)]
pub(super) struct FreeMotions {
    point: Vector3<f64>,
    scale: f64,
    /// Orthonormal, rotations times `scale`.
    basis: Vec<Vector6<f64>>,
}

impl FreeMotions {
    /// Motions under which prescribed components rest and guided ones stay common.
    pub(super) fn of_supports(mesh: &TetraMesh, claims: &Claims) -> Self {
        let nodes = mesh.nodes();
        let centre = nodes
            .iter()
            .fold(Vector3::zeros(), |sum, &x| sum + Vector3::from(x))
            / nodes.len() as f64;
        let scale = mesh.size();
        let mut sums = vec![(Vector6::zeros(), 0usize); claims.cases.len()];
        let mut rows = Vec::new();
        for pass in 0..2 {
            for (node, claim) in claims.claim.iter().enumerate() {
                for component in 0..3 {
                    let Some(case) = claim[component] else {
                        continue;
                    };
                    let mut row = displacement_row(nodes[node], component, centre, scale);
                    let guided = claims.cases[case].unknown.is_some();
                    if pass == 0 && guided {
                        sums[case].0 += row;
                        sums[case].1 += 1;
                    } else if pass == 1 {
                        if guided {
                            row -= sums[case].0 / sums[case].1 as f64;
                        }
                        rows.push(row.transpose());
                    }
                }
            }
        }
        // singular values of the rows themselves: of their squares, a motion that is hardly held would lose its direction
        rows.resize(rows.len().max(6), RowVector6::zeros());
        let triangle = MatrixXx6::from_rows(&rows).qr().r();
        let held = triangle.svd(false, true);
        let limit = HELD * held.singular_values.max();
        let basis = (held.v_t.iter())
            .flat_map(|directions| directions.row_iter())
            .zip(&held.singular_values)
            .filter(|(_, value)| **value <= limit)
            .map(|(direction, _)| Vector6::from_iterator(direction.iter().copied()))
            .collect();
        FreeMotions {
            point: centre,
            scale,
            basis,
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.basis.is_empty()
    }

    pub(super) fn len(&self) -> usize {
        self.basis.len()
    }

    /// The motions as displacements and rotations about `point`, each with a unit of the coordinate that it is named by:
    /// an amplitude is that rotation [rad], or displacement [m].
    pub(super) fn modes(&self, point: [f64; 3]) -> Vec<RigidMode> {
        let point = Vector3::from(point);
        let mut rows: Vec<Vector6<f64>> = self
            .basis
            .iter()
            .map(|b| {
                let rotation = b.fixed_rows::<3>(3) / self.scale;
                let moved = b.fixed_rows::<3>(0) + rotation.cross(&(point - self.point));
                let mut row = Vector6::zeros();
                row.fixed_rows_mut::<3>(0).copy_from(&moved);
                row.fixed_rows_mut::<3>(3)
                    .copy_from(&(rotation * self.scale));
                row
            })
            .collect();
        let mut modes = Vec::new();
        for coordinate in PREFERENCE {
            let Some(best) = (0..rows.len()).max_by(|&i, &j| {
                rows[i][coordinate]
                    .abs()
                    .total_cmp(&rows[j][coordinate].abs())
            }) else {
                break;
            };
            if rows[best][coordinate].abs() < 1e-6 {
                continue;
            }
            let lead = rows.swap_remove(best);
            let lead = lead / lead[coordinate];
            for row in rows.iter_mut().chain(&mut modes) {
                let factor = row[coordinate];
                *row -= lead * factor;
            }
            modes.push(lead);
        }
        modes
            .into_iter()
            .map(|mut mode| {
                // what is left of the elimination's rounding is not a motion
                let largest = mode.amax();
                mode.apply(|c| {
                    if c.abs() < ROUNDING * largest {
                        *c = 0.0;
                    }
                });
                let mut mode = RigidMode {
                    translation: [0, 1, 2].map(|c| mode[c]),
                    rotation: [3, 4, 5].map(|c| mode[c] / self.scale),
                    point: [point.x, point.y, point.z],
                };
                let unit = mode.coordinates()[mode.component()];
                let parts = mode.translation.iter_mut().chain(&mut mode.rotation);
                parts.for_each(|c| *c /= unit);
                mode
            })
            .collect()
    }

    /// The part of these motions that moves no contact point along its normal, `normal[i]` being the
    /// displacement of point `i` by each coordinate of a motion.
    pub(super) fn unheld(&self, points: impl Iterator<Item = ([f64; 3], [f64; 3])>) -> Self {
        let m = self.basis.len();
        let mut gram = DMatrix::<f64>::zeros(m, m);
        let mut count = 0.0;
        for (x, normal) in points {
            let row = (0..3).fold(Vector6::zeros(), |sum, c| {
                sum + displacement_row(x, c, self.point, self.scale) * normal[c]
            });
            let moved = nalgebra::DVector::from_fn(m, |k, _| self.basis[k].dot(&row));
            gram += &moved * moved.transpose();
            count += 1.0;
        }
        let basis = if m == 0 {
            Vec::new()
        } else {
            let eigen = gram.symmetric_eigen();
            (0..m)
                .filter(|&k| eigen.eigenvalues[k] <= NEGLIGIBLE * count)
                .map(|k| {
                    (0..m).fold(Vector6::zeros(), |sum, i| {
                        sum + self.basis[i] * eigen.eigenvectors[(i, k)]
                    })
                })
                .collect()
        };
        FreeMotions {
            point: self.point,
            scale: self.scale,
            basis,
        }
    }

    /// As many free components of nodes that `may_pin` as there are motions, chosen so that holding them leaves none;
    /// fewer if these nodes do not hold all.
    pub(super) fn pins(
        &self,
        mesh: &TetraMesh,
        claims: &Claims,
        may_pin: impl Fn(usize) -> bool,
    ) -> Vec<(usize, usize)> {
        let mut directions = self.basis.clone();
        let mut pins = Vec::with_capacity(directions.len());
        while !directions.is_empty() {
            let mut best = (0.0, (0, 0), Vector6::zeros());
            let nodes = mesh.nodes().iter().enumerate();
            for (node, &x) in nodes.filter(|&(node, _)| may_pin(node)) {
                for component in 0..3 {
                    if claims.claim[node][component].is_some() {
                        continue;
                    }
                    let row = displacement_row(x, component, self.point, self.scale);
                    let moved =
                        Vector6::from_fn(|k, _| directions.get(k).map_or(0.0, |d| d.dot(&row)));
                    let size = moved.norm_squared();
                    // a hair's breadth better is not better: keeps the choice independent of rounding
                    if size > best.0 * (1.0 + 1e-9) {
                        best = (size, (node, component), moved);
                    }
                }
            }
            if best.0 <= NEGLIGIBLE {
                break;
            }
            pins.push(best.1);
            directions = without(&directions, &best.2);
        }
        pins
    }
}

/// An orthonormal basis of the combinations of `directions` whose coefficients are orthogonal to
/// `moved`.
fn without(directions: &[Vector6<f64>], moved: &Vector6<f64>) -> Vec<Vector6<f64>> {
    let m = directions.len();
    let mut kept: Vec<Vector6<f64>> = vec![moved.normalize()];
    for k in 0..m {
        let mut candidate = Vector6::ith(k, 1.0);
        for _ in 0..2 {
            for other in &kept {
                candidate -= other * other.dot(&candidate);
            }
        }
        if candidate.norm() > 1e-6 && kept.len() < m {
            kept.push(candidate.normalize());
        }
    }
    kept[1..]
        .iter()
        .map(|c| (0..m).fold(Vector6::zeros(), |sum, k| sum + directions[k] * c[k]))
        .collect()
}

/// Displacement component of a point by each coordinate of a motion, rotations times `scale`.
fn displacement_row(
    x: [f64; 3],
    component: usize,
    point: Vector3<f64>,
    scale: f64,
) -> Vector6<f64> {
    let arm = (Vector3::from(x) - point) / scale;
    let mut row = Vector6::zeros();
    row[component] = 1.0;
    // (r x arm)_c = e_c . (r x arm) = r . (arm x e_c)
    let mut e = Vector3::zeros();
    e[component] = 1.0;
    row.fixed_rows_mut::<3>(3).copy_from(&arm.cross(&e));
    row
}

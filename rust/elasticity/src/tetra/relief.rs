// SPDX-License-Identifier: MIT OR Apache-2.0
//! What balances loads on a body that its supports leave free, and how far such a body has moved.
//!
//! The stiffness of a free body is factorised with a component pinned for each rigid motion. Pins would carry what
//! loads leave unbalanced, at single nodes, and finer elements yield more and more there. So what is left is carried
//! by inertia, whose forces are spread over the body as those of an acceleration are, and the body rests where its
//! mean motion, weighted with its volume, is zero.

use nalgebra::{DMatrix, Vector3};

use super::balance::WRENCH;
use super::body::TetraBody;
use super::rigid::RigidMode;

/// Inertia of the rigid motions that supports leave free.
pub(super) struct Relief {
    motions: Vec<RigidMode>,
    /// For each motion force and moment about the centre of volume of the inertia that does the work 1 on it and
    /// none on the others. Times a displacement it is the mean motion of the body.
    wrenches: Vec<[f64; WRENCH]>,
}

impl Relief {
    pub(super) fn new(body: &TetraBody, motions: &[RigidMode]) -> Self {
        let (centre, total, inertia) = body.inertia();
        let own: Vec<[f64; WRENCH]> = motions
            .iter()
            .map(|mode| {
                let moved = mode.displacement(centre).map(|u| total * u);
                let turned = inertia * Vector3::from(mode.rotation);
                [moved[0], moved[1], moved[2], turned.x, turned.y, turned.z]
            })
            .collect();
        let m = motions.len();
        let gram = DMatrix::from_fn(m, m, |k, l| {
            work(&own[l], &motions[k], Vector3::from(centre))
        });
        // motions that differ move the body differently
        let inverse = gram
            .cholesky()
            .map_or_else(|| DMatrix::zeros(m, m), |factor| factor.inverse());
        let wrenches = (0..m)
            .map(|k| {
                std::array::from_fn(|c| (0..m).map(|l| inverse[(k, l)] * own[l][c]).sum::<f64>())
            })
            .collect();
        Relief {
            motions: motions.to_vec(),
            wrenches,
        }
    }

    /// What tells how far supports that are displaced take the body along: its mean motion in the component that each
    /// motion is named by. A body that is moved along as a whole has not turned, though a turn about its supports is
    /// such a motion too, in the product of its inertia.
    pub(super) fn of_displaced(body: &TetraBody) -> Self {
        let motions = body.modes(body.centre());
        let m = motions.len();
        let named: Vec<usize> = motions.iter().map(RigidMode::component).collect();
        let parts = DMatrix::from_fn(m, m, |k, l| motions[l].coordinates()[named[k]]);
        let Some(inverse) = parts.try_inverse() else {
            // two skew motions of one name
            return Self::new(body, &motions);
        };
        let wrenches = (0..m).map(|k| {
            let mut wrench = [0.0; WRENCH];
            (0..m).for_each(|l| wrench[named[l]] += inverse[(k, l)]);
            wrench
        });
        Relief {
            wrenches: wrenches.collect(),
            motions,
        }
    }

    pub(super) fn wrenches(&self) -> &[[f64; WRENCH]] {
        &self.wrenches
    }

    /// Work of each spread force and moment about the centre of volume on each motion, `(6, motions)` row-major.
    pub(super) fn spread_work(&self, centre: [f64; 3]) -> Vec<f64> {
        (0..WRENCH)
            .flat_map(|load| {
                let mut wrench = [0.0; WRENCH];
                wrench[load] = 1.0;
                (self.motions.iter()).map(move |mode| work(&wrench, mode, Vector3::from(centre)))
            })
            .collect()
    }

    /// Forces on the nodes [N] of the inertia of each motion, and its displacements, `3 N` each.
    pub(super) fn fields(&self, body: &TetraBody) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
        let forces = self
            .wrenches
            .iter()
            .map(|&wrench| body.spread_force(wrench));
        let motions = self.motions.iter().map(|mode| body.mode_displacement(mode));
        (forces.collect(), motions.collect())
    }
}

/// Work of a force and a moment about `centre` on a motion.
fn work(wrench: &[f64; WRENCH], mode: &RigidMode, centre: Vector3<f64>) -> f64 {
    let moved = mode.displacement(centre.into());
    let force: f64 = wrench[..3].iter().zip(moved).map(|(f, u)| f * u).sum();
    let moment = wrench[3..].iter().zip(mode.rotation);
    force + moment.map(|(m, w)| m * w).sum::<f64>()
}

/// Responses of a pinned body to the inertia of its motions, by which all others are freed of the pins.
pub(super) struct Freed {
    /// Work of a unit traction of each contact point on each motion, `3 n` each [m2].
    pub(super) on_motions: Vec<Vec<f64>>,
    /// The same on the displacement by the inertia of each motion.
    pub(super) on_inertia: Vec<Vec<f64>>,
    /// Work of the inertia of each motion on the displacement by that of each other, row-major.
    pub(super) between: Vec<f64>,
}

impl Freed {
    /// Frees the blocks of a flexibility `(n, n)`, of these components.
    pub(super) fn free(&self, blocks: &mut [f64], n: usize, components: &[(usize, usize)]) {
        let m = self.on_motions.len();
        if m == 0 {
            return;
        }
        // what the pins carry, and half of where they rest, as both sides have it
        let pinned: Vec<Vec<f64>> = (0..m)
            .map(|k| {
                let mut own = self.on_inertia[k].clone();
                for (l, moved) in self.on_motions.iter().enumerate() {
                    let half = 0.5 * self.between[k * m + l];
                    own.iter_mut().zip(moved).for_each(|(o, r)| *o -= half * r);
                }
                own
            })
            .collect();
        for (block, &(c, d)) in blocks.chunks_exact_mut(n * n).zip(components) {
            let (first, second) = (c * n, d * n);
            for (pins, motion) in pinned.iter().zip(&self.on_motions) {
                for (i, row) in block.chunks_exact_mut(n).enumerate() {
                    let (p, r) = (pins[first + i], motion[first + i]);
                    let across = pins[second..second + n]
                        .iter()
                        .zip(&motion[second..second + n]);
                    for (entry, (q, s)) in row.iter_mut().zip(across) {
                        *entry -= p * s + r * q;
                    }
                }
            }
        }
    }

    /// Frees the displacement (times the areas, `3 n`) by a load that does `work` on the motions, and whose
    /// displacement the inertia does `mean` on.
    pub(super) fn free_response(&self, response: &mut [f64], work: &[f64], mean: &[f64]) {
        let m = self.on_motions.len();
        for k in 0..m {
            let moved = mean[k]
                - (0..m)
                    .map(|l| work[l] * self.between[l * m + k])
                    .sum::<f64>();
            let fields = self.on_inertia[k].iter().zip(&self.on_motions[k]);
            for (entry, (u, r)) in response.iter_mut().zip(fields) {
                *entry -= work[k] * u + moved * r;
            }
        }
    }
}

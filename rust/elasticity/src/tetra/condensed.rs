// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::{Compliance, Component};

use super::factorised::Cost;
use super::rigid::RigidMode;
use crate::Error;

/// One component of one support, which can be given a displacement or, if guided, a force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SupportCase {
    /// Number of the support.
    pub support: usize,
    /// 0, 1, 2 for x, y, z.
    pub component: usize,
    /// Guided: the case is a unit force [N] on the guide; otherwise a unit displacement [m].
    pub guided: bool,
}

/// A body condensed onto its contact points.
///
/// Fields at contact points are `3 n` values: tangential 1, tangential 2, into, each over all points.
///
/// Displacements are those under loads that the inertia of the free rigid motions balances, without the mean motion of
/// the body, weighted with its volume: the amplitudes of the motions are that mean. Loads that balance need no inertia.
/// Where supports are displaced, the mean is that of the coordinate by which each motion is named: a body that is moved
/// along as a whole does not turn.
#[derive(Clone, Debug)]
pub struct CondensedBody {
    /// Traction in, displacement out.
    pub flexibility: Flexibility,
    /// Rigid motions that the supports leave free and contact must hold.
    pub modes: Vec<RigidMode>,
    /// Mean displacement of the contact points by each mode, `3 n` per mode. A traction `t` does the
    /// work `sum weights * displacement * t` on it.
    pub mode_displacement: Vec<Vec<f64>>,
    /// Support components.
    pub cases: Vec<SupportCase>,
    /// Displacement of the contact points by a unit of each case, `3 n` per case [m/m or m/N].
    pub case_displacement: Vec<Vec<f64>>,
    /// Work of a unit of each case on each mode, `(cases, modes)` row-major; zero unless guided.
    pub case_work: Vec<f64>,
    /// Displacement of the contact points, `3 n` each, by a unit force [N] along and moment [N m] about
    /// x, y and z through [`CondensedBody::centre`], see [`TetraBody::spread_force`](super::TetraBody::spread_force).
    pub spread_displacement: Vec<Vec<f64>>,
    /// Centre of volume [m].
    pub centre: [f64; 3],
    /// How the loads arrive at the supports.
    pub balance: Balance,
    /// What the condensation cost.
    pub cost: Cost,
}

/// Forces [N] along and moments [N m] about x, y, z through the origin: what loads amount to, and what
/// the supports answer, stiffness times displacement less load on the nodes they hold.
///
/// Of a solution in equilibrium, loads and reactions add up to nothing.
#[derive(Clone, Debug)]
pub struct Balance {
    /// Of a unit traction of each contact point, `(6, 3 n)` row-major.
    pub contact: Vec<f64>,
    /// Of each support on the body by a unit traction of each contact point, `(supports, 6, 3 n)`.
    pub reaction: Vec<f64>,
    /// The same by a unit of each case, `(supports, 6, cases)`.
    pub case_reaction: Vec<f64>,
    /// The same by a unit of each spread load, `(supports, 6, 6)`.
    pub spread_reaction: Vec<f64>,
}

/// Symmetric flexibility of contact points, and the compliance it amounts to.
#[derive(Clone, Debug, PartialEq)]
pub struct Flexibility {
    weights: Vec<f64>,
    /// One after the other.
    blocks: Vec<f64>,
}

impl Flexibility {
    /// Flexibility of `n` points: `weights`, the integrals of the basis functions [m2], and the blocks
    /// `S_cd = B_c^T K^-1 B_d` [m3/Pa], `(6, n, n)` row-major, for `cd` = 11, 22, nn, 12, 1n, 2n.
    ///
    /// # Errors
    /// [`Error::Shape`]; [`Error::NoArea`] on a weight that is not positive.
    pub fn new(weights: Vec<f64>, blocks: Vec<f64>) -> Result<Self, Error> {
        let expected = 6 * weights.len() * weights.len();
        if blocks.len() != expected {
            return Err(Error::Shape {
                name: "flexibility",
                found: blocks.len(),
                expected,
            });
        }
        if let Some(point) = weights.iter().position(|&w| w.is_nan() || w <= 0.0) {
            return Err(Error::NoArea(point));
        }
        Ok(Flexibility { weights, blocks })
    }

    /// Memory [bytes] of the blocks of so many points.
    pub fn memory(points: usize) -> f64 {
        8.0 * 6.0 * (points as f64).powi(2)
    }

    /// Area of each contact point [m2].
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Weights and blocks, as [`Flexibility::new`] took them.
    pub fn into_parts(self) -> (Vec<f64>, Vec<f64>) {
        (self.weights, self.blocks)
    }

    /// The block of the two components and whether it has to be transposed.
    fn block(&self, observed: Component, loaded: Component) -> (&[f64], bool) {
        use Component::{Normal, X, Y};
        let (k, transposed) = match (observed, loaded) {
            (X, X) => (0, false),
            (Y, Y) => (1, false),
            (Normal, Normal) => (2, false),
            (X, Y) => (3, false),
            (Y, X) => (3, true),
            (X, Normal) => (4, false),
            (Normal, X) => (4, true),
            (Y, Normal) => (5, false),
            (Normal, Y) => (5, true),
        };
        let size = self.weights.len().pow(2);
        (&self.blocks[k * size..(k + 1) * size], transposed)
    }
}

impl Compliance for Flexibility {
    fn points(&self) -> usize {
        self.weights.len()
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        let n = self.weights.len();
        let (block, transposed) = self.block(observed, loaded);
        if transposed {
            let mut sum = vec![0.0; n];
            for (row, &t) in block.chunks_exact(n).zip(traction) {
                for (s, &b) in sum.iter_mut().zip(row) {
                    *s += b * t;
                }
            }
            for i in 0..n {
                displacement[i] += scale * sum[i] / self.weights[i];
            }
        } else {
            for (i, row) in block.chunks_exact(n).enumerate() {
                let sum: f64 = row.iter().zip(traction).map(|(b, t)| b * t).sum();
                displacement[i] += scale * sum / self.weights[i];
            }
        }
    }

    fn add_influence(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        matrix: &mut [f64],
    ) {
        let n = self.weights.len();
        let (block, transposed) = self.block(observed, loaded);
        for (i, row) in matrix.chunks_exact_mut(n).enumerate() {
            let factor = scale / self.weights[i];
            for (j, entry) in row.iter_mut().enumerate() {
                let value = if transposed {
                    block[j * n + i]
                } else {
                    block[i * n + j]
                };
                *entry += factor * value;
            }
        }
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_complementarity::discs::DiscState;

use crate::friction::Friction;

/// What moves the upper body over the lower one along one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Creepage [-] in rolling, displacement [m] in a shift.
    Slip(f64),
    /// Total tangential force on the lower body [N]; the creepage or displacement is sought.
    Force(f64),
}

/// The state from which a shift or a step of transient rolling starts.
#[derive(Clone, Debug, PartialEq)]
pub struct Earlier {
    /// Traction on the lower body [Pa], (2n), x components first.
    pub traction: Vec<f64>,
    /// Pressure [Pa], (n).
    pub pressure: Vec<f64>,
    /// Coefficient of friction of the particles [-], (n).
    pub coefficient: Vec<f64>,
}

/// A tangential problem on the cells of a [`super::PatchOperators`].
#[derive(Clone, Debug)]
pub struct TangentialProblem<'a> {
    /// Pressure [Pa], (n); contact is where it is positive.
    pub pressure: &'a [f64],
    /// Centre of the first cell (x, y) [m], from the point about which spin turns.
    pub origin: [f64; 2],
    /// Drive along x and y.
    pub drive: [Drive; 2],
    /// Spin creepage [1/m] in rolling, rotation [rad] in a shift.
    pub spin: f64,
    /// Rolling speed [m/s]; in a shift the reciprocal of its duration [1/s].
    pub speed: f64,
    /// The friction law.
    pub friction: &'a Friction,
    /// The earlier state of a shift or a transient step; `None` for none (no traction).
    pub earlier: Option<&'a Earlier>,
    /// Traction on the lower body [Pa], (2n), that may be near the solution: tried before the coarser grids.
    /// Without meaning where a force is prescribed.
    pub start: Option<&'a [f64]>,
    /// Relative residual aimed at.
    pub tolerance: f64,
}

/// The solution, or the last iterate if `converged` is false.
#[derive(Clone, Debug)]
pub struct TangentialSolution {
    /// Traction on the lower body [Pa], (2n), x components first.
    pub traction: Vec<f64>,
    /// Slip of the upper body over the lower one, (2n): relative [-] in rolling, [m] in a shift.
    pub slip: Vec<f64>,
    /// State by point, (n).
    pub state: Vec<DiscState>,
    /// Coefficient of friction in force [-], (n); the one at rest outside of contact.
    pub coefficient: Vec<f64>,
    /// Creepage (x, y) [-] or displacement [m], given or found.
    pub drive: [f64; 2],
    /// Total force (x, y) on the lower body [N].
    pub force: [f64; 2],
    /// Moment about z through the spin centre on the lower body [N m].
    pub spin_moment: f64,
    /// Whether the residual met the tolerance.
    pub converged: bool,
    /// Newton steps on the finest grid.
    pub iterations: usize,
    /// Newton steps on the coarser grids.
    pub coarse_iterations: usize,
    /// Products with the slip operator, in equivalents of the finest grid.
    pub products: f64,
    /// Applications of the preconditioner, in equivalents of the finest grid.
    pub preconditionings: f64,
    /// Residual by Newton step on the finest grid.
    pub history: Vec<f64>,
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_complementarity::discs::DiscState;

use super::dissipation::Surroundings;
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

/// Yield of the layer between the bodies: the traction stays below `yield_stress + hardening u` as well, with the
/// accumulated plastic slip `u` of the particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plasticity<'a> {
    /// Yield stress in shear before any plastic slip, `tau_c0` [Pa].
    pub yield_stress: f64,
    /// Growth of the yield stress with the accumulated plastic slip, `k_tau` [Pa/m]; negative for softening.
    pub hardening: f64,
    /// Accumulated plastic slip of the particles in the earlier state [m], (n); without meaning where there is none.
    pub earlier: &'a [f64],
}

/// The plastic part of the slip.
#[derive(Clone, Debug, PartialEq)]
pub struct PlasticSlip {
    /// Share of the slip at each point that is plastic shear of the layer [-], (n).
    pub share: Vec<f64>,
    /// Accumulated plastic slip of the particles [m], (n).
    pub accumulated: Vec<f64>,
    /// Whether the yield of the layer, not friction, limits the traction of a point on its bound, (n).
    pub yields: Vec<bool>,
}

/// A tangential problem on the cells of a [`super::PatchOperators`].
#[derive(Clone, Debug)]
pub struct TangentialProblem<'a> {
    /// Cells on which heat counts where friction follows the temperature; `None`: one cell more all around.
    pub around: Option<Surroundings>,
    /// Pressure [Pa], (n); contact is where it is positive.
    pub pressure: &'a [f64],
    /// Centre of the first cell (x, y) [m], from the point about which spin turns.
    pub origin: [f64; 2],
    /// Drive along x and y.
    pub drive: [Drive; 2],
    /// Spin creepage [1/m] in rolling, rotation [rad] in a shift.
    pub spin: f64,
    /// Rigid slip (2n) at the cells besides drive and spin, in the unit of the slip.
    pub rigid_slip: Option<&'a [f64]>,
    /// Rolling speed [m/s]; in a shift the reciprocal of its duration [1/s].
    pub speed: f64,
    /// The friction law.
    pub friction: &'a Friction,
    /// Yield of the layer; `None` for an elastic one.
    pub plasticity: Option<Plasticity<'a>>,
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
    /// Slip of the upper body over the lower one, (2n), plastic shear of a layer with it: relative [-] in rolling,
    /// [m] in a shift.
    pub slip: Vec<f64>,
    /// The plastic part of the slip, of a layer that yields.
    pub plastic: Option<PlasticSlip>,
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
    /// Where friction follows the temperature: how traction and temperature were found in turn.
    pub rounds: Option<Rounds>,
}

/// Rounds of a solution at given coefficients of friction and the coefficients by its temperatures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounds {
    /// How many.
    pub count: usize,
    /// Change of the coefficients in the last one, over the largest.
    pub change: f64,
}

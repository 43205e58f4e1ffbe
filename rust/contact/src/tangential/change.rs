// SPDX-License-Identifier: MIT OR Apache-2.0
//! What derivatives of a tangential problem are by, and of.

use super::problem::{Earlier, TangentialSolution};

/// A change of what is given; or the derivatives of a number by it. The set of cells in contact does not change.
#[derive(Clone, Debug, PartialEq)]
pub struct TangentialChange {
    /// Of the pressure in contact [Pa], (n).
    pub pressure: Vec<f64>,
    /// Of the creepage [-], the displacement [m] or the force [N] along x and y, whichever is given.
    pub drive: [f64; 2],
    /// Of the spin creepage [1/m] or rotation [rad].
    pub spin: f64,
    /// Of the rigid slip at each point, (2n), in the unit of the slip.
    pub rigid_slip: Vec<f64>,
    /// Of the rigid slip one step behind each point, (2n), which only turns into heat.
    pub rigid_slip_behind: Vec<f64>,
    /// Of the coefficient of friction at each point where it does not follow the slip [-], (n). Where it follows the
    /// temperature, of the coefficient that it follows, besides what the heat does.
    pub coefficient: Vec<f64>,
    /// Of the parameters of a law that follows slip or temperature: those of [`SlipLaw::parameters`] or
    /// [`TemperatureLaw::parameters`], then distance [m] and slip speed [m/s] of its memory if it has one, then the
    /// speed of the problem over itself [-]. Empty for other friction.
    ///
    /// [`SlipLaw::parameters`]: crate::friction::SlipLaw::parameters
    /// [`TemperatureLaw::parameters`]: crate::temperature::TemperatureLaw::parameters
    pub law: Vec<f64>,
    /// Of the dissipation on the grid around, besides that by all else; empty for none.
    pub heat: Vec<f64>,
    /// Of thickness over shear modulus of the layer [m/Pa].
    pub layer: f64,
    /// Of the stiffness by which first cells are tied to those behind them, over itself [-], where slip is of second order:
    /// it goes with the bodies, [`TangentialTangent::stiffness_of`].
    ///
    /// [`TangentialTangent::stiffness_of`]: super::TangentialTangent::stiffness_of
    pub stiffness: f64,
    /// Of the length of a transient step over itself [-], as far as ties go with it.
    pub length: f64,
    /// Of the earlier state; without meaning in steady rolling and where there was none.
    pub earlier: Earlier,
    /// Of the coefficients of friction that particles with a memory bring along, beside those of the earlier state: by
    /// how far a step carries them [-], (n) or empty for none.
    pub brought: Vec<f64>,
    /// Of a layer that yields; without meaning where none does.
    pub plasticity: PlasticityChange,
}

/// A change of how a layer yields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlasticityChange {
    /// Of the first yield stress [Pa].
    pub yield_stress: f64,
    /// Of the hardening [Pa/m].
    pub hardening: f64,
    /// Of the accumulated plastic slip of the particles in the earlier state [m], (n) or empty for none.
    pub earlier: Vec<f64>,
}

/// A change of what is found; or the weights of a number in it.
#[derive(Clone, Debug, PartialEq)]
pub struct TangentialResponse {
    /// Of the traction [Pa], (2n).
    pub traction: Vec<f64>,
    /// Of the slip, (2n): relative [-] in rolling, [m] in a shift.
    pub slip: Vec<f64>,
    /// Of the coefficient of friction in force [-], (n).
    pub coefficient: Vec<f64>,
    /// Of creepage or displacement along x and y, given or found.
    pub drive: [f64; 2],
    /// Of the [`dissipation`](super::dissipation()) on the grid around; empty where none was named.
    pub dissipation: Vec<f64>,
    /// Of the share of the slip that is plastic [-], (n); empty where no layer yields.
    pub plastic_share: Vec<f64>,
    /// Of the accumulated plastic slip [m], (n); empty where no layer yields.
    pub accumulated: Vec<f64>,
}

/// A solution as its derivatives see it.
#[derive(Clone, Copy, Debug)]
pub struct TangentialState<'a> {
    /// Traction [Pa], (2n).
    pub traction: &'a [f64],
    /// Slip, (2n).
    pub slip: &'a [f64],
    /// Coefficient of friction in force [-], (n).
    pub coefficient: &'a [f64],
    /// Creepage or displacement, given or found.
    pub drive: [f64; 2],
}

impl TangentialSolution {
    /// What derivatives need to know of it.
    pub fn state(&self) -> TangentialState<'_> {
        TangentialState {
            traction: &self.traction,
            slip: &self.slip,
            coefficient: &self.coefficient,
            drive: self.drive,
        }
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the moduli of rail and wheel change in a patch.
//!
//! All displacements of a half-space are inverse to its shear modulus and linear in its Poisson's ratio. They are
//! therefore sums of those of two half-spaces with a shear modulus of 1 Pa, one with a Poisson's ratio of 0 and one with
//! 0.5, which a pressure does not move sideways.

use mtb_contact::tangential::{Bodies, Motion, PatchOperators, TangentialTangent};
use mtb_elasticity::Material;
use mtb_elasticity::half_space::Pair;

use crate::derivative::WheelTangent;
use crate::error::Error;
use crate::linear::{PatchLinear, RollingLinear};

/// What a unit of a modulus does to a patch whose pressure and traction are held.
#[derive(Clone, Debug)]
pub(crate) struct ByModulus {
    /// Of the normal compliance of both bodies, over it.
    pub(crate) compliance: f64,
    /// Part by part of the way; none where there is no pressure.
    pub(crate) slips: Vec<BodySlip>,
}

/// Slip (2n) on the loaded part, by the displacements of bodies.
#[derive(Clone, Debug, Default)]
pub(crate) struct BodySlip {
    /// By tractions and pressures.
    pub(crate) whole: Vec<f64>,
    /// By pressures alone, of a steady step.
    pub(crate) by_pressure: Vec<f64>,
    /// One step behind.
    pub(crate) behind: Vec<f64>,
    /// Stiffness of ties, over that of the step.
    pub(crate) stiffness: f64,
}

impl BodySlip {
    /// Sums of two with factors.
    fn sums(a: f64, first: &[Self], b: f64, second: &[Self]) -> Vec<Self> {
        let pairs = first.iter().zip(second);
        pairs.map(|(v, w)| Self::sum(a, v, b, w)).collect()
    }

    fn sum(a: f64, first: &Self, b: f64, second: &Self) -> Self {
        let add = |first: &[f64], second: &[f64]| {
            let pairs = first.iter().zip(second);
            pairs.map(|(v, w)| a * v + b * w).collect()
        };
        Self {
            whole: add(&first.whole, &second.whole),
            by_pressure: add(&first.by_pressure, &second.by_pressure),
            behind: add(&first.behind, &second.behind),
            stiffness: a * first.stiffness + b * second.stiffness,
        }
    }
}

impl PatchLinear {
    /// By shear modulus and, at that shear modulus, by Poisson's ratio of the rail, then of the wheel, of those that
    /// give way.
    pub(crate) fn by_moduli(&self, linear: &WheelTangent) -> Result<Vec<ByModulus>, Error> {
        if self.plane.rows.is_some() {
            return Err(Error::ConformalModuli);
        }
        let Pair { lower, upper } = linear.ready.wheelset.bodies;
        let stiffness = linear.ready.joined()?.shear_modulus;
        let unit = |poisson_ratio| Some(Material::new(1.0, poisson_ratio)).transpose();
        let alone = |lower, upper| {
            let slip = |rolling: &RollingLinear| rolling.slips_of(linear, Pair { lower, upper });
            self.rolling.as_ref().map_or(Ok(Vec::new()), slip)
        };
        let (loose, firm) = (unit(0.0)?, unit(0.5)?);
        // tractions move the upper body as they move the lower one, backwards
        let firm = alone(firm, None)?;
        let mut changes = Vec::new();
        for (material, loose) in [(lower, [loose, None]), (upper, [None, loose])] {
            let Some(Material {
                shear_modulus,
                poisson_ratio,
            }) = material
            else {
                continue;
            };
            let [lower, upper] = loose;
            let loose = alone(lower, upper)?;
            let share = -1.0 / shear_modulus.powi(2);
            changes.push(ByModulus {
                compliance: share * (1.0 - poisson_ratio) * stiffness,
                slips: BodySlip::sums(
                    share * (1.0 - 2.0 * poisson_ratio),
                    &loose,
                    share * 2.0 * poisson_ratio,
                    &firm,
                ),
            });
            let twice = 2.0 / shear_modulus;
            changes.push(ByModulus {
                compliance: -stiffness / shear_modulus,
                slips: BodySlip::sums(-twice, &loose, twice, &firm),
            });
        }
        Ok(changes)
    }
}

impl RollingLinear {
    /// What other bodies would do to the slip under these tractions and pressures.
    fn slips_of(&self, linear: &WheelTangent, pair: Pair) -> Result<Vec<BodySlip>, Error> {
        let grid = self.operators.grid();
        let tangential = |cell, offset| pair.tangential(cell, offset);
        let by_pressure = |cell, offset| pair.by_pressure(cell, offset);
        let bodies = Bodies {
            tangential: &tangential,
            by_pressure: pair.is_coupled().then_some(&by_pressure),
            layer: 0.0,
            is_mirrored: true,
            inclination: None,
            across: None,
        };
        let operators = match self.motion {
            Motion::Transient { step } => {
                PatchOperators::new(&bodies, grid, Motion::Shift)?.rolling_by(&bodies, step)?
            }
            other => PatchOperators::new(&bodies, grid, other)?,
        };
        let parts = self.parts.iter().enumerate();
        parts
            .map(|(number, part)| {
                let earlier = self.earlier(number);
                let (problem, state) = self.solved(part, earlier.as_deref(), linear);
                let tangent = TangentialTangent::new(&self.operators, &problem, state, None)?;
                let is_steady = matches!(self.motion, Motion::Steady { .. });
                let by_pressure = is_steady.then(|| operators.slip_by_pressure(&part.pressure));
                Ok(BodySlip {
                    whole: tangent.slip_by_bodies(&operators),
                    by_pressure: by_pressure.unwrap_or_default(),
                    behind: tangent.slip_behind_by_bodies(&operators),
                    stiffness: tangent.stiffness_of(&operators),
                })
            })
            .collect()
    }
}

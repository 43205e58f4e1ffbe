// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a half-space is made of at a depth.

use super::super::layered::inside::Inside as Remainder;
use super::super::{Bond, Medium};
use super::rectangle::{Responses, stress_influence};
use super::waves::HalfSpaceWaves;
use crate::{Error, Material};

/// The inside of a half-space at one depth.
pub(super) struct Inside<'a> {
    /// Of the material there.
    pub(super) poisson_ratio: f64,
    depth: f64,
    remainder: Option<Remainder<'a>>,
}

impl<'a> Inside<'a> {
    /// At a depth [m].
    pub(super) fn new(medium: &'a Medium, depth: f64) -> Self {
        let material = match medium {
            Medium::Layered(body) => body.material_at(depth),
            _ => medium.material(),
        };
        let remainder = match medium {
            Medium::Layered(body) => Some(Remainder::new(body, depth)),
            _ => None,
        };
        Self {
            poisson_ratio: material.poisson_ratio,
            depth,
            remainder,
        }
    }

    /// As [`stress_influence`].
    pub(super) fn influence(&self, offset: [f64; 2], cell: [f64; 2]) -> Responses {
        let place = [offset[0], offset[1], self.depth];
        let mut found = stress_influence(self.poisson_ratio, place, cell);
        self.add_remainder(&mut found, offset, cell);
        found
    }

    /// Adds what is not that of the half-space of the material there.
    pub(super) fn add_remainder(&self, found: &mut Responses, offset: [f64; 2], cell: [f64; 2]) {
        if let Some(remainder) = &self.remainder {
            let more = remainder.remainder(offset, cell);
            for (found, more) in found.as_flattened_mut().iter_mut().zip(more.as_flattened()) {
                *found += more;
            }
        }
    }

    /// Stress by waves with a wave number [1/m].
    pub(super) fn waves(&self, wave_number: f64) -> HalfSpaceWaves {
        match &self.remainder {
            Some(remainder) => remainder.waves(wave_number),
            None => HalfSpaceWaves::new(self.poisson_ratio, wave_number * self.depth),
        }
    }
}

/// Refuses materials that are none, tractions that carry a layer away, and depths outside of a body.
pub(super) fn check(medium: &Medium, is_sheared: bool, depths: &[f64]) -> Result<(), Error> {
    let material = medium.material();
    Material::new(material.shear_modulus, material.poisson_ratio)?;
    let Medium::Layered(body) = medium else {
        return Ok(());
    };
    if is_sheared && body.bond() == Bond::Frictionless {
        return Err(Error::CarriedAway);
    }
    match depths.iter().position(|depth| !body.holds(*depth)) {
        Some(index) => Err(Error::InRigidBase {
            index,
            depth: depths[index],
        }),
        None => Ok(()),
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use std::f64::consts::PI;

use mtb_operator::Component;

use super::influence::tangential;
use super::{Medium, influence, wave_compliance};
use crate::{Error, Material};

/// Two bodies pressed together, each a half-space or rigid, as tangential contact sees them.
///
/// Relative displacements by tractions on the lower body (the upper one feels their opposite).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Material of the lower body; `None` for a rigid one.
    pub lower: Option<Material>,
    /// Material of the upper body; `None` for a rigid one.
    pub upper: Option<Material>,
}

impl Pair {
    /// Displacement [m/Pa] of the lower body relative to the upper one at `offset` [m] from the centre
    /// of a loaded `cell` [m]: xx, xy = yx, yy.
    pub fn tangential(&self, cell: [f64; 2], offset: [f64; 2]) -> [f64; 3] {
        tangential(self.bodies(), offset, cell)
    }

    /// Displacement (x, y) [m/Pa] of the upper body relative to the lower one by a unit pressure.
    pub fn by_pressure(&self, cell: [f64; 2], offset: [f64; 2]) -> [f64; 2] {
        [Component::X, Component::Y].map(|c| {
            let of = |body: &Option<Material>| {
                body.as_ref()
                    .map_or(0.0, |m| influence(m, c, Component::Normal, offset, cell))
            };
            of(&self.upper) - of(&self.lower)
        })
    }

    /// Whether a pressure moves the surfaces tangentially against each other: Dundurs' second constant is
    /// not zero.
    pub fn is_coupled(&self) -> bool {
        let weight = |body: &Option<Material>| {
            body.as_ref()
                .map_or(0.0, |m| (1.0 - 2.0 * m.poisson_ratio) / m.shear_modulus)
        };
        let (upper, lower) = (weight(&self.upper), weight(&self.lower));
        (upper - lower).abs() > 1e-12 * (upper.abs() + lower.abs())
    }

    fn bodies(&self) -> impl Iterator<Item = &Material> {
        self.lower.iter().chain(&self.upper)
    }
}

/// Two long bodies in line contact: plane strain in the rolling plane, antiplane shear across it.
///
/// The displacement of a half-plane is known up to a constant: here it vanishes at the distance
/// `reference` from a load. In rolling, or at a given force, the choice does not matter.
/// [Johnson1985, ch. 2]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinePair {
    /// The bodies.
    pub pair: Pair,
    /// Distance at which displacements vanish [m].
    pub reference: f64,
}

impl LinePair {
    /// As [`Pair::tangential`]; only the first sizes of `cell` and `offset` count.
    pub fn tangential(&self, cell: [f64; 2], offset: [f64; 2]) -> [f64; 3] {
        let primitive = |x: f64| {
            let x: f64 = x / self.reference;
            if x == 0.0 {
                0.0
            } else {
                self.reference * (x - x * x.abs().ln())
            }
        };
        // the integral of -ln(|x| / reference) over the strip
        let integral = primitive(offset[0] + 0.5 * cell[0]) - primitive(offset[0] - 0.5 * cell[0]);
        let (mut along, mut across) = (0.0, 0.0);
        for m in self.pair.bodies() {
            along += (1.0 - m.poisson_ratio) / (PI * m.shear_modulus) * integral;
            across += integral / (PI * m.shear_modulus);
        }
        [along, 0.0, across]
    }

    /// As [`Pair::by_pressure`].
    pub fn by_pressure(&self, cell: [f64; 2], offset: [f64; 2]) -> [f64; 2] {
        let half = 0.5 * cell[0];
        let signed = 2.0 * offset[0].clamp(-half, half);
        let of = |body: &Option<Material>| {
            body.as_ref().map_or(0.0, |m| {
                -(1.0 - 2.0 * m.poisson_ratio) / (4.0 * m.shear_modulus) * signed
            })
        };
        [of(&self.pair.upper) - of(&self.pair.lower), 0.0]
    }
}

/// Bodies pressed together without friction, each a half-space of any medium.
pub struct NormalPair {
    /// The half-spaces of the materials at the surfaces, as one.
    surfaces: Material,
    /// Those bodies that are uniform, as one.
    uniform: Option<Material>,
    /// All others.
    compound: Vec<Medium>,
}

impl NormalPair {
    /// One or both of the bodies; a rigid one is left out.
    ///
    /// # Errors
    /// [`Error::NoBody`] if none is given, [`Error::Material`].
    pub fn new(bodies: &[Medium]) -> Result<Self, Error> {
        let surfaces: Vec<Material> = bodies.iter().map(Medium::material).collect();
        let mut uniform = Vec::new();
        let mut compound = Vec::new();
        for body in bodies {
            match body {
                Medium::Uniform(material) => uniform.push(*material),
                body => compound.push(body.clone()),
            }
        }
        Ok(Self {
            surfaces: Material::joined(&surfaces)?,
            uniform: match uniform[..] {
                [] => None,
                _ => Some(Material::joined(&uniform)?),
            },
            compound,
        })
    }

    /// Closing of the gap [m/Pa] at `offset` [m] from the centre of a `cell` [m] under a unit pressure.
    pub fn rectangle(&self, offset: [f64; 2], cell: [f64; 2]) -> f64 {
        let n = Component::Normal;
        let remainders = self.compound.iter();
        influence(&self.surfaces, n, n, offset, cell)
            + remainders
                .map(|body| body.remainder(n, n, offset, cell))
                .sum::<f64>()
    }

    /// Whether a pressure does the same at opposite offsets: no body creeps.
    pub fn is_mirrored(&self) -> bool {
        self.compound.iter().all(Medium::is_mirrored)
    }

    /// Closing of the gap [m/Pa] by a pressure wave with a wave number [1/m]; for no wave number that of the layers
    /// on rigid bases alone. Waves on bodies that creep are not known, and these are left out.
    pub fn wave(&self, wave_number: f64) -> f64 {
        let uniform = self.uniform.as_ref();
        let of = |body: &Medium| match body {
            Medium::Layered(body) => body.waves(wave_number).normal,
            Medium::Uniform(_) | Medium::Viscoelastic(_) => 0.0,
        };
        uniform.map_or(0.0, |material| wave_compliance(material, wave_number))
            + self.compound.iter().map(of).sum::<f64>()
    }
}

/// Two bodies as tangential contact sees them, each a half-space of any medium or rigid; see [`Pair`].
pub struct TangentialPair {
    surfaces: Pair,
    lower: Option<Medium>,
    upper: Option<Medium>,
}

impl TangentialPair {
    /// The lower and the upper body; `None` for a rigid one.
    pub fn new(lower: Option<&Medium>, upper: Option<&Medium>) -> Self {
        let compound = |body: Option<&Medium>| match body {
            Some(Medium::Uniform(_)) | None => None,
            Some(body) => Some(body.clone()),
        };
        Self {
            surfaces: Pair {
                lower: lower.map(Medium::material),
                upper: upper.map(Medium::material),
            },
            lower: compound(lower),
            upper: compound(upper),
        }
    }

    /// The half-spaces of the materials at the surfaces.
    pub fn surfaces(&self) -> Pair {
        self.surfaces
    }

    /// As [`Pair::tangential`].
    pub fn tangential(&self, cell: [f64; 2], offset: [f64; 2]) -> [f64; 3] {
        let mut sum = self.surfaces.tangential(cell, offset);
        for body in self.lower.iter().chain(&self.upper) {
            let at = |a, b| body.remainder(a, b, offset, cell);
            sum[0] += at(Component::X, Component::X);
            sum[1] += at(Component::X, Component::Y);
            sum[2] += at(Component::Y, Component::Y);
        }
        sum
    }

    /// As [`Pair::by_pressure`].
    pub fn by_pressure(&self, cell: [f64; 2], offset: [f64; 2]) -> [f64; 2] {
        let own = self.surfaces.by_pressure(cell, offset);
        std::array::from_fn(|axis| {
            let component = [Component::X, Component::Y][axis];
            let of = |body: &Option<Medium>| {
                body.as_ref().map_or(0.0, |b| {
                    b.remainder(component, Component::Normal, offset, cell)
                })
            };
            own[axis] + of(&self.upper) - of(&self.lower)
        })
    }

    /// As [`Pair::is_coupled`]; bodies with layers always are, and those that creep unless they are alike.
    pub fn is_coupled(&self) -> bool {
        match (&self.lower, &self.upper) {
            (None, None) => self.surfaces.is_coupled(),
            (Some(Medium::Viscoelastic(one)), Some(Medium::Viscoelastic(other))) => one != other,
            _ => true,
        }
    }

    /// Whether a traction does the same at opposite offsets: no body creeps.
    pub fn is_mirrored(&self) -> bool {
        let mut bodies = self.lower.iter().chain(&self.upper);
        bodies.all(Medium::is_mirrored)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_row_of_rectangles_is_a_line() {
        let steel = Material {
            shear_modulus: 80e9,
            poisson_ratio: 0.3,
        };
        let pair = Pair {
            lower: Some(steel),
            upper: None,
        };
        let line = LinePair {
            pair,
            reference: 1.0,
        };
        // differences between two places are free of the constant
        let cell = [1e-3, 400.0];
        let rectangles = |x: f64| pair.tangential(cell, [x, 0.0]);
        let strips = |x: f64| line.tangential(cell, [x, 0.0]);
        for c in [0, 2] {
            let far = rectangles(0.0)[c] - rectangles(4e-3)[c];
            let flat = strips(0.0)[c] - strips(4e-3)[c];
            assert!((far / flat - 1.0).abs() < 1e-6, "{far} {flat}");
        }
        let push = pair.by_pressure(cell, [2.3e-3, 0.0])[0];
        let flat = line.by_pressure(cell, [2.3e-3, 0.0])[0];
        assert!((push / flat - 1.0).abs() < 1e-3, "{push} {flat}");
        assert!(
            pair.is_coupled()
                && !Pair {
                    upper: Some(steel),
                    ..pair
                }
                .is_coupled()
        );
    }
}

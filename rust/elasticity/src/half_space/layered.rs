// SPDX-License-Identifier: MIT OR Apache-2.0
//! An elastic layer on an elastic half-space or on a rigid base.

use std::f64::consts::PI;

use mtb_operator::Component;

use super::influence;
use super::quadrature::{GAUSS_2, GAUSS_3, GAUSS_4, GAUSS_6};
use super::radial::{Radials, Spectra};
use crate::{Error, Material};

/// Radial functions of the displacement.
#[derive(Clone, Copy)]
enum Radial {
    /// Transform by `J_1` of the normal spectrum: the flux of a point load through a circle, over its radius.
    Normal,
    /// The same of the spectrum across the wave vector.
    Across,
    /// The same of the difference of those along and across.
    Difference,
    /// Transform by `J_0` of the mixed spectrum, up to a constant.
    Mixed,
}

/// How a layer lies on its base.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bond {
    /// Both move as one at their interface.
    Bonded,
    /// The layer slides on its base without friction, and does not leave it.
    Frictionless,
}

/// What waves of traction with one wave number do to a surface [m/Pa].
///
/// Tractions and displacements run along the wave vector (`along`), across it in the surface (`across`) and into the
/// body (`normal`). A pressure `cos k x` moves the surface by `normal cos k x` into the body and by `mixed sin k x`
/// along x; a traction `sin k x` along x by `along sin k x` and `mixed cos k x`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waves {
    /// Normal by normal.
    pub normal: f64,
    /// Along the wave vector by a traction along it.
    pub along: f64,
    /// Across the wave vector by a traction across it.
    pub across: f64,
    /// Along by normal, and normal by along.
    pub mixed: f64,
}

impl Waves {
    /// Those of the half-space of a material with shear modulus 1 at the wave number 1.
    fn of_half_space(poisson_ratio: f64) -> Self {
        Self {
            normal: 1.0 - poisson_ratio,
            along: 1.0 - poisson_ratio,
            across: 1.0,
            mixed: poisson_ratio - 0.5,
        }
    }

    fn scaled(self, factor: f64) -> Self {
        Self {
            normal: factor * self.normal,
            along: factor * self.along,
            across: factor * self.across,
            mixed: factor * self.mixed,
        }
    }
}

/// Wave numbers times thickness from which the base is not felt: `exp(-2 x 25)` is 2e-22.
const DEEP: f64 = 25.0;

/// Wave number times thickness that stands for none.
const FLAT: f64 = 1e-14;

/// Longest piece of an edge, as the logarithm of a distance, that six Gauss points integrate to rounding.
const PIECE: f64 = 0.5;

/// Distance in cells from which so many Gauss points on an edge, as it is, leave 1e-11 of its integral: `n` of them
/// leave about `(4 distance)^(-2 n)`.
const FAR: [(f64, &[(f64, f64)]); 3] = [(200.0, &GAUSS_2), (20.0, &GAUSS_3), (6.0, &GAUSS_4)];

/// Share of a cell by which a field point on the line of an edge is taken beside it.
const BESIDE: f64 = 1e-9;

/// An elastic layer of constant thickness on an elastic half-space, or on a rigid base.
///
/// Its surface answers a traction like the half-space of the layer's material, and by a remainder that is a
/// smooth function of the place over the thickness. The Fourier transform of the remainder is known in closed form:
/// the state of plane strain at the interface goes to the surface by the exponential of a matrix
/// of 4 by 4, scaled so that it does not overflow, and the shear wave by hyperbolic tangents. Its
/// Hankel transform is tabulated when first needed. By the divergence theorem the integral over a rectangle
/// is one along its edges, so that cells may be much smaller or much larger than the layer is thick.
///
/// Safe to share between threads. [Burmister1945], [Johnson1985, ch. 5.8]
pub struct Layered {
    layer: Material,
    thickness: f64,
    base: Option<Material>,
    bond: Bond,
    /// What the base changes of the normalised mixed wave at no wave number.
    far_mixed: f64,
    radials: Radials<4>,
}

impl Layered {
    /// A layer of `thickness` [m]; `base` is `None` for a rigid one.
    ///
    /// # Errors
    /// [`Error::Material`], and [`Error::Thickness`] unless the thickness is positive and finite.
    pub fn new(
        layer: Material,
        thickness: f64,
        base: Option<Material>,
        bond: Bond,
    ) -> Result<Self, Error> {
        let checked = |m: Material| Material::new(m.shear_modulus, m.poisson_ratio);
        if !(thickness > 0.0 && thickness.is_finite()) {
            return Err(Error::Thickness(thickness));
        }
        let mut body = Self {
            layer: checked(layer)?,
            thickness,
            base: base.map(checked).transpose()?,
            bond,
            far_mixed: 0.0,
            radials: Radials::default(),
        };
        let own = Waves::of_half_space(layer.poisson_ratio);
        body.far_mixed = body.normalised(FLAT).mixed - own.mixed;
        Ok(body)
    }

    /// Material of the layer.
    pub fn layer(&self) -> Material {
        self.layer
    }

    /// How the layer lies on its base.
    pub fn bond(&self) -> Bond {
        self.bond
    }

    /// Whether a depth [m] is inside of what is elastic.
    pub(super) fn holds(&self, depth: f64) -> bool {
        self.base.is_some() || inside::is_in_layer(depth, self.thickness)
    }

    /// Material at a depth [m]; that of the layer at the interface.
    pub(super) fn material_at(&self, depth: f64) -> Material {
        match self.base {
            Some(base) if !inside::is_in_layer(depth, self.thickness) => base,
            _ => self.layer,
        }
    }

    /// Displacements [m/Pa] by waves with a wave number [1/m]. For no wave number they are the limit on a rigid base,
    /// and zero on an elastic one, whose mean displacement is not finite.
    pub fn waves(&self, wave_number: f64) -> Waves {
        let g = self.layer.shear_modulus;
        if wave_number == 0.0 {
            let waves = Waves::of_half_space(self.layer.poisson_ratio).scaled(0.0);
            return match self.base {
                Some(_) => waves,
                None => Waves {
                    normal: self.compression(),
                    ..waves
                },
            };
        }
        self.normalised(wave_number * self.thickness)
            .scaled(1.0 / (g * wave_number))
    }

    /// Limit of the displacement [m/Pa] by a pressure of long waves, on a rigid base.
    fn compression(&self) -> f64 {
        let (g, nu) = (self.layer.shear_modulus, self.layer.poisson_ratio);
        let share = match self.bond {
            Bond::Bonded => (1.0 - 2.0 * nu) / (1.0 - nu),
            Bond::Frictionless => 1.0 - nu,
        };
        0.5 * self.thickness / g * share
    }

    /// The waves times shear modulus of the layer and wave number, over the wave number times the thickness.
    fn normalised(&self, q: f64) -> Waves {
        if q > DEEP {
            return Waves::of_half_space(self.layer.poisson_ratio);
        }
        let below = self.below();
        let Solved {
            surface: [u, w, ..],
            by_shear,
            by_pressure,
            ..
        } = self.solved(q);
        let of = |row: [f64; 2], by: [f64; 2]| row[0] * by[0] + row[1] * by[1];
        let tanh = q.tanh();
        let across = match self.bond {
            Bond::Bonded => (below.across + tanh) / (1.0 + below.across * tanh),
            Bond::Frictionless => 1.0 / tanh,
        };
        Waves {
            normal: of(w, by_pressure),
            along: of(u, by_shear),
            across,
            mixed: of(u, by_pressure),
        }
    }

    /// Displacements of the interface by tractions of one shear modulus of the layer.
    fn below(&self) -> Waves {
        self.base.map_or_else(
            || Waves::of_half_space(0.0).scaled(0.0),
            |base| {
                let ratio = self.layer.shear_modulus / base.shear_modulus;
                Waves::of_half_space(base.poisson_ratio).scaled(ratio)
            },
        )
    }

    /// The state of plane strain by waves of traction, over the wave number times the thickness.
    fn solved(&self, q: f64) -> Solved {
        let below = self.below();
        let interface = match self.bond {
            Bond::Bonded => [
                [below.along, below.mixed],
                [below.mixed, below.normal],
                [-0.5, 0.0],
                [0.0, -0.5],
            ],
            Bond::Frictionless => [[1.0, 0.0], [0.0, below.normal], [0.0, 0.0], [0.0, -0.5]],
        };
        let surface = raised(self.layer.poisson_ratio, q, interface);
        let [_, _, t, s] = surface;
        // tractions on the surface are minus two stresses
        let half = -0.5 / (t[0] * s[1] - t[1] * s[0]);
        Solved {
            interface,
            surface,
            by_shear: [half * s[1], -half * s[0]],
            by_pressure: [-half * t[1], half * t[0]],
        }
    }

    /// Displacement [m/Pa] at a point by a unit traction on a rectangle, as [`influence`](super::influence).
    ///
    /// A layer that slides on its base without friction is carried away by any tangential traction: tangential
    /// displacements by tangential tractions are then infinite.
    pub fn influence(
        &self,
        observed: Component,
        loaded: Component,
        offset: [f64; 2],
        cell: [f64; 2],
    ) -> f64 {
        influence(&self.layer, observed, loaded, offset, cell)
            + self.remainder(observed, loaded, offset, cell)
    }

    /// What the base adds to the displacement of the half-space of the layer [m/Pa].
    pub fn remainder(
        &self,
        observed: Component,
        loaded: Component,
        offset: [f64; 2],
        cell: [f64; 2],
    ) -> f64 {
        let flipped = [offset[1], offset[0]];
        let turned = [cell[1], cell[0]];
        let edges = |radial, weight| self.edges(radial, weight, offset, cell);
        let across = |radial, weight| self.edges(radial, weight, flipped, turned);
        let is_tangential = |c| c != Component::Normal;
        if self.bond == Bond::Frictionless && is_tangential(observed) && is_tangential(loaded) {
            return f64::INFINITY;
        }
        match (observed, loaded) {
            (Component::Normal, Component::Normal) => {
                edges(Radial::Normal, Weight::Out) + across(Radial::Normal, Weight::Out)
            }
            (Component::X, Component::X) => {
                edges(Radial::Across, Weight::Out)
                    + across(Radial::Across, Weight::Out)
                    + edges(Radial::Difference, Weight::Out)
            }
            (Component::Y, Component::Y) => {
                edges(Radial::Across, Weight::Out)
                    + across(Radial::Across, Weight::Out)
                    + across(Radial::Difference, Weight::Out)
            }
            (Component::X, Component::Y) | (Component::Y, Component::X) => {
                edges(Radial::Difference, Weight::Along)
            }
            (Component::Normal, Component::X) => edges(Radial::Mixed, Weight::One),
            (Component::X, Component::Normal) => -edges(Radial::Mixed, Weight::One),
            (Component::Normal, Component::Y) => across(Radial::Mixed, Weight::One),
            (Component::Y, Component::Normal) => -across(Radial::Mixed, Weight::One),
        }
    }

    /// Difference of the integrals of a radial function along the two edges of a rectangle that are parallel to y.
    fn edges(&self, radial: Radial, weight: Weight, offset: [f64; 2], cell: [f64; 2]) -> f64 {
        let mut sum = 0.0;
        on_edges(self.thickness, offset, cell, |share, r, [cosine, sine]| {
            let factor = match weight {
                Weight::Out => cosine,
                Weight::Along => sine,
                Weight::One => 1.0,
            };
            sum += share * factor * self.radial(radial, r);
        });
        self.thickness / self.layer.shear_modulus * sum
    }

    fn radial(&self, radial: Radial, r: f64) -> f64 {
        self.radials.at(radial as usize, r, self)
    }
}

impl Spectra<4> for Layered {
    const ORDERS: [usize; 4] = [1, 1, 1, 0];
    const LAST_WAVE: usize = 25;

    /// What the base changes of the normalised waves, over the wave number times the thickness: of the functions of
    /// [`Radial`] in their order.
    fn at(&self, q: f64) -> [f64; 4] {
        if q > DEEP {
            return [0.0; 4];
        }
        let own = Waves::of_half_space(self.layer.poisson_ratio);
        let waves = self.normalised(q);
        let normal = (waves.normal - own.normal) / q;
        // what is left of the mixed one is finite for long waves
        let mixed = (waves.mixed - own.mixed - self.far_mixed * (-q).exp()) / q;
        match self.bond {
            Bond::Frictionless => [normal, 0.0, 0.0, mixed],
            Bond::Bonded => {
                let across = (waves.across - own.across) / q;
                let along = (waves.along - own.along) / q;
                [normal, across, along - across, mixed]
            }
        }
    }

    /// The integral of `exp(-q) (J_0(q r) - 1) / q`.
    fn known(&self, r: f64) -> [f64; 4] {
        let log = (0.5 * (1.0 + r.hypot(1.0))).ln();
        [0.0, 0.0, 0.0, -self.far_mixed * log]
    }
}

/// Quadrature along the two edges of a rectangle that are parallel to y, lengths over `h`: for each of its points the
/// share over two pi, the distance, and cosine and sine of its direction. The far edge counts with the other sign.
fn on_edges(h: f64, offset: [f64; 2], cell: [f64; 2], mut each: impl FnMut(f64, f64, [f64; 2])) {
    let away = offset[0].hypot(offset[1]) / cell[0].max(cell[1]);
    let far = FAR.iter().find(|(from, _)| away > *from);
    for sign in [1.0, -1.0] {
        let x = (offset[0] + 0.5 * sign * cell[0]) / h;
        if let Some((_, rule)) = far {
            let half = 0.5 * cell[1] / h;
            for (node, share) in *rule {
                let y = offset[1] / h + node * half;
                let r = (x * x + y * y).sqrt();
                each(sign * half * share / (2.0 * PI), r, [x / r, y / r]);
            }
            continue;
        }
        let least = BESIDE * cell[0] / h;
        let (distance, sense) = (x.abs().max(least), if x < 0.0 { -1.0 } else { 1.0 });
        let place = |y: f64| (y / h / distance).asinh();
        let ends = [
            place(offset[1] - 0.5 * cell[1]),
            place(offset[1] + 0.5 * cell[1]),
        ];
        let pieces = ((ends[1] - ends[0]) / PIECE).ceil().max(1.0);
        let half = 0.5 * (ends[1] - ends[0]) / pieces;
        for piece in 0..pieces as usize {
            let middle = ends[0] + half * (2.0 * piece as f64 + 1.0);
            for (node, share) in GAUSS_6 {
                // y = distance sinh(t) leaves an integrand without a peak near the corner
                let t = middle + half * node;
                let (sinh, cosh) = (t.sinh(), t.cosh());
                let share = sign * half * distance * cosh * share / (2.0 * PI);
                each(share, distance * cosh, [sense / cosh, sinh / cosh]);
            }
        }
    }
}

/// Component of the unit vector from the field point that weights an integral along an edge.
#[derive(Clone, Copy)]
enum Weight {
    Out,
    Along,
    One,
}

/// Waves of traction on a layer: what its interface feels, and what reaches its surface.
struct Solved {
    /// `u, w, t, s` at the interface by its two unknowns: the tractions on the base, of which on a base without
    /// friction that along is zero, and the first unknown is the displacement along.
    interface: [[f64; 2]; 4],
    /// The same at the surface, times `exp(-q)`.
    surface: [[f64; 2]; 4],
    /// The unknowns, times `exp(q)`, by a traction along the wave vector.
    by_shear: [f64; 2],
    /// By a pressure.
    by_pressure: [f64; 2],
}

/// A state at the depth `q` taken to the surface, times `exp(-q)`.
fn raised(nu: f64, q: f64, state: [[f64; 2]; 4]) -> [[f64; 2]; 4] {
    let up = upwards(nu, q);
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|l| up[i][l] * state[l][j]).sum()))
}

/// `exp(-q) exp(-A q)` of the system of plane strain `d/dz (u, w, t, s) = A (u, w, t, s)` over the wave number, which
/// takes the state at the depth `q` to the surface. `u sin`, `w cos`: displacements along and into the body; `t sin`,
/// `s cos`: shear and normal stress over twice the shear modulus. `(A^2 - 1)^2 = 0`.
fn upwards(nu: f64, q: f64) -> [[f64; 4]; 4] {
    let a = 1.0 / (1.0 - nu);
    let system = [
        [0.0, 1.0, 2.0, 0.0],
        [-nu * a, 0.0, 0.0, (1.0 - 2.0 * nu) * a],
        [a, 0.0, 0.0, nu * a],
        [0.0, 0.0, -1.0, 0.0],
    ];
    let product = |x: &[[f64; 4]; 4], y: &[[f64; 4]; 4]| -> [[f64; 4]; 4] {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..4).map(|l| x[i][l] * y[l][j]).sum::<f64>())
        })
    };
    let mut excess = product(&system, &system);
    for (i, row) in excess.iter_mut().enumerate() {
        row[i] -= 1.0;
    }
    let turned = product(&system, &excess);
    let decay = (-2.0 * q).exp();
    let (cosh, sinh) = (0.5 * (1.0 + decay), -0.5 * (-2.0 * q).exp_m1());
    let bent = (-q).exp() * bend(q);
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let own = if i == j { cosh } else { 0.0 };
            own + 0.5 * q * sinh * excess[i][j] - sinh * system[i][j] - 0.5 * bent * turned[i][j]
        })
    })
}

/// `q cosh q - sinh q` without cancellation.
fn bend(q: f64) -> f64 {
    if q > 1.0 {
        return q * q.cosh() - q.sinh();
    }
    // the sum of 2 n q^(2 n + 1) / (2 n + 1)!
    let (mut power, mut sum) = (q, 0.0);
    for n in 1..12 {
        let n = f64::from(n);
        power *= q * q / (2.0 * n * (2.0 * n + 1.0));
        sum += 2.0 * n * power;
    }
    sum
}

pub(super) mod inside;
#[cfg(test)]
mod tests;

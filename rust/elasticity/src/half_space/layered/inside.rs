// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stress inside a layer and its base.
//!
//! At a depth in the layer the stress is that of the half-space of the layer's material and a remainder; at a depth in
//! the base, that of the half-space of the base's. The Fourier transforms of both are those of waves. Their Hankel
//! transforms are smooth over the thickness or the depth, and integrals over a rectangle go along its edges.

use super::super::radial::{Radials, Spectra};
use super::super::stress::{HalfSpaceWaves, Stress};
use super::{Bond, Layered, on_edges, raised};

/// Share of the thickness by which a depth may be beyond the interface and still count as of the layer.
const ON_INTERFACE: f64 = 1e-12;

/// Radial functions of the stress: transforms of the components by waves, `l` along the wave vector, `t` across it and
/// `z` into the body, under a pressure (`P`) and under tractions along it or across it (`T`).
const ZZ_P: usize = 0;
const TT_P: usize = 1;
const LL_TT_P: usize = 2;
const LZ_P: usize = 3;
const ZZ_T: usize = 4;
const TZ_T: usize = 5;
const LZ_TZ_T: usize = 6;
const LL_T: usize = 7;
const TT_T: usize = 8;
const LT_T: usize = 9;
/// Of `tt + 2 lt - ll` under tractions, of second order.
const BENT_T: usize = 10;
const FUNCTIONS: usize = 11;

/// Whether a depth is in a layer or at its interface.
pub(in super::super) fn is_in_layer(depth: f64, thickness: f64) -> bool {
    depth <= thickness * (1.0 + ON_INTERFACE)
}

/// The stress at one depth of a layered body, less that of a half-space there.
pub(in super::super) struct Inside<'a> {
    body: &'a Layered,
    /// Depth over the thickness.
    depth: f64,
    radials: Radials<FUNCTIONS>,
}

impl<'a> Inside<'a> {
    /// At a depth [m].
    pub(in super::super) fn new(body: &'a Layered, depth: f64) -> Self {
        Self {
            body,
            depth: depth / body.thickness,
            radials: Radials::default(),
        }
    }

    /// Stress by unit waves of traction with a wave number [1/m].
    pub(in super::super) fn waves(&self, wave_number: f64) -> HalfSpaceWaves {
        self.normalised(wave_number * self.body.thickness)
    }

    /// The same over the wave number times the thickness.
    fn normalised(&self, q: f64) -> HalfSpaceWaves {
        let body = self.body;
        let nu = body.layer.poisson_ratio;
        let b = body.below().across;
        let solved = body.solved(q);
        // of a wave across, whose displacement is b times its traction at the interface
        let decay = (-2.0 * q).exp();
        let all = 0.5 * (b * (1.0 - decay) + 1.0 + decay);
        if is_in_layer(self.depth, 1.0) {
            let left = q * (1.0 - self.depth).max(0.0);
            let fall = (-q * self.depth).exp();
            let state = raised(nu, left, solved.interface);
            let a = 1.0 / (1.0 - nu);
            // the stresses are two shear moduli times what is kept of them
            let plane = |by: [f64; 2]| -> [f64; 4] {
                let [u, _, t, s] = state.map(|row| 2.0 * fall * (row[0] * by[0] + row[1] * by[1]));
                let ll = a * u + nu * a * s;
                [s, ll, nu * (ll + s), t]
            };
            let rest = (-2.0 * left).exp();
            let (cosh, sinh) = (0.5 * (1.0 + rest), 0.5 * (1.0 - rest));
            return HalfSpaceWaves {
                pressure: turned(plane(solved.by_pressure)),
                along: plane(solved.by_shear),
                across: [
                    -fall * (b * sinh + cosh) / all,
                    fall * (b * cosh + sinh) / all,
                ],
            };
        }
        let beyond = q * (self.depth - 1.0);
        let base = body.base.map_or(0.0, |base| base.poisson_ratio);
        let own = HalfSpaceWaves::new(base, beyond);
        let fall = (-q).exp();
        let plane = |by: [f64; 2]| -> [f64; 4] {
            let shear = if body.bond == Bond::Bonded {
                fall * by[0]
            } else {
                0.0
            };
            let pressed = turned(own.pressure);
            std::array::from_fn(|k| shear * own.along[k] + fall * by[1] * pressed[k])
        };
        HalfSpaceWaves {
            pressure: turned(plane(solved.by_pressure)),
            along: plane(solved.by_shear),
            across: own.across.map(|stress| fall * stress / all),
        }
    }

    /// Stress by unit tractions along x, along y and a unit pressure on a rectangle, as
    /// [`stress_influence`](super::super::stress_influence), less that of the half-space.
    pub(in super::super) fn remainder(&self, offset: [f64; 2], cell: [f64; 2]) -> [Stress; 3] {
        let x = self.edges(offset, cell);
        let y = self.edges([offset[1], offset[0]], [cell[1], cell[0]]);
        let along_x = [
            x.one[LL_T] + x.bent,
            x.one[TT_T] - x.bent,
            x.one[ZZ_T],
            x.beside[LZ_TZ_T],
            x.out[TZ_T] + x.out[LZ_TZ_T] + y.out[TZ_T],
            y.one[LT_T] - y.bent,
        ];
        let along_y = [
            y.one[TT_T] - y.bent,
            y.one[LL_T] + y.bent,
            y.one[ZZ_T],
            y.out[TZ_T] + y.out[LZ_TZ_T] + x.out[TZ_T],
            x.beside[LZ_TZ_T],
            x.one[LT_T] - x.bent,
        ];
        let pressure = [
            x.out[TT_P] + x.out[LL_TT_P] + y.out[TT_P],
            x.out[TT_P] + y.out[TT_P] + y.out[LL_TT_P],
            x.out[ZZ_P] + y.out[ZZ_P],
            y.one[LZ_P],
            x.one[LZ_P],
            x.beside[LL_TT_P],
        ];
        [along_x, along_y, pressure]
    }

    /// Differences of integrals along the two edges of a rectangle that are parallel to y.
    fn edges(&self, offset: [f64; 2], cell: [f64; 2]) -> Edges {
        let mut sum = Edges::default();
        on_edges(self.body.thickness, offset, cell, |share, r, direction| {
            sum.add(share, direction, &self.radials.all(r, self));
        });
        sum
    }
}

impl Spectra<FUNCTIONS> for Inside<'_> {
    const ORDERS: [usize; FUNCTIONS] = [1, 1, 1, 0, 0, 1, 1, 0, 0, 0, 2];
    /// In the layer and in the base the remainder falls at least with `exp(-q)`.
    const LAST_WAVE: usize = 40;

    fn at(&self, q: f64) -> [f64; FUNCTIONS] {
        if q > Self::LAST_WAVE as f64 {
            return [0.0; FUNCTIONS];
        }
        let material = self.body.material_at(self.depth * self.body.thickness);
        let own = HalfSpaceWaves::new(material.poisson_ratio, q * self.depth);
        let all = self.normalised(q);
        let [p, l] = [(all.pressure, own.pressure), (all.along, own.along)]
            .map(|(all, own)| -> [f64; 4] { std::array::from_fn(|k| all[k] - own[k]) });
        let [tz, lt] = [0, 1].map(|k| match self.body.bond {
            Bond::Bonded => all.across[k] - own.across[k],
            Bond::Frictionless => 0.0,
        });
        let [p_zz, p_ll, p_tt, p_lz] = p;
        let [zz, ll, tt, lz] = l;
        let bent = tt + 2.0 * lt - ll;
        [
            p_zz,
            p_tt,
            p_ll - p_tt,
            p_lz,
            zz,
            tz,
            lz - tz,
            ll,
            tt,
            lt,
            bent,
        ]
    }
}

/// Integrals of the radial functions along edges, differences of two edges.
#[derive(Default)]
struct Edges {
    /// As they are.
    one: [f64; FUNCTIONS],
    /// Times the cosine of the angle from the normal of the edge.
    out: [f64; FUNCTIONS],
    /// Times its sine.
    beside: [f64; FUNCTIONS],
    /// What the square of the cosine of a wave's direction leaves of [`BENT_T`].
    bent: f64,
}

impl Edges {
    fn add(&mut self, share: f64, [cosine, sine]: [f64; 2], radial: &[f64; FUNCTIONS]) {
        let weighted = radial.map(|value| share * value);
        for (k, value) in weighted.iter().enumerate() {
            self.one[k] += value;
            self.out[k] += cosine * value;
            self.beside[k] += sine * value;
        }
        let even = weighted[TT_T] + 2.0 * weighted[LT_T] - weighted[LL_T];
        self.bent += 0.5 * (even + (cosine * cosine - sine * sine) * weighted[BENT_T]);
    }
}

/// From cosines and a sine of a pressure `cos k x` to its complex wave, and back.
fn turned([zz, ll, tt, lz]: [f64; 4]) -> [f64; 4] {
    [zz, ll, tt, -lz]
}

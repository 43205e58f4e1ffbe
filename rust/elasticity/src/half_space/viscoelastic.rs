// SPDX-License-Identifier: MIT OR Apache-2.0
//! A half-space that creeps, under a contact that rolls over it steadily.

use std::sync::LazyLock;

use mtb_operator::Component;

use super::influence;
use super::quadrature::gauss_legendre;
use crate::{Error, Material};

/// Creep times after which nothing is left: `exp(-45)` is 3e-20.
const FORGOTTEN: f64 = 45.0;

/// Times [creep times] at which the exponential asks for a new piece of the way.
const PIECES: [f64; 3] = [1.0, 4.0, 12.0];

/// Share of a time within which a kink counts as one there.
const BESIDE: f64 = 0.25;

/// Power by which the points of a rule gather where the influence has a kink: its `x ln x` there becomes smooth.
const GATHERING: i32 = 5;

static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| {
    let rule = gauss_legendre(28);
    rule.into_iter()
        .map(|(x, w)| (0.5 * (1.0 + x), 0.5 * w))
        .collect()
});

/// A half-space of a standard linear solid in steady rolling.
///
/// Under a stress that is held it gives way by `(1 + c (1 - exp(-t / T))) / G` in the course of time, with one Poisson's
/// ratio. Where a contact passes with the velocity `V`, a particle at `x` was at `x + V s` a time `s` ago, so
/// that its displacement is that of the elastic half-space and `c` times the mean of that on the way ahead, with the
/// weight `exp(-s / T) / T`. For no creep time, or no velocity, this is the half-space with the modulus
/// `G / (1 + c)`; for an endless one that with `G`. The influence has no symmetry along the way.
///
/// [Kalker1990, ch. 3], [Hunter1961]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viscoelastic {
    material: Material,
    creep: f64,
    way: [f64; 2],
}

impl Viscoelastic {
    /// `material`: its constants before it creeps; `creep`: compliance that creep adds, over that before; `way`:
    /// velocity of the contact times the creep time, along x and y [m].
    ///
    /// # Errors
    /// [`Error::Material`], and [`Error::Creep`] for a number that is negative or not finite.
    pub fn new(material: Material, creep: f64, way: [f64; 2]) -> Result<Self, Error> {
        let material = Material::new(material.shear_modulus, material.poisson_ratio)?;
        let is_way = way.iter().all(|w| w.is_finite());
        if !(creep >= 0.0 && creep.is_finite() && is_way) {
            return Err(Error::Creep { creep, way });
        }
        Ok(Self {
            material,
            creep,
            way,
        })
    }

    /// Its constants before it creeps.
    pub fn material(&self) -> Material {
        self.material
    }

    /// What creep adds to the influence of the elastic half-space.
    pub fn remainder(
        &self,
        observed: Component,
        loaded: Component,
        offset: [f64; 2],
        cell: [f64; 2],
    ) -> f64 {
        if self.creep == 0.0 {
            return 0.0;
        }
        let at = |offset: [f64; 2]| influence(&self.material, observed, loaded, offset, cell);
        self.creep * self.faded(at, offset, cell)
    }

    /// Integral of `exp(-t) at(offset + t way)` over all `t >= 0`, where `at` has kinks on the edges of a `cell`.
    fn faded(&self, at: impl Fn([f64; 2]) -> f64, offset: [f64; 2], cell: [f64; 2]) -> f64 {
        if self.way == [0.0; 2] {
            return at(offset);
        }
        let value = |t: f64| (-t).exp() * at([0, 1].map(|k| offset[k] + t * self.way[k]));
        // where the way crosses the lines along the edges, and where it begins
        let mut kinks = vec![0.0];
        for k in 0..2 {
            for edge in [-0.5, 0.5] {
                let t = (edge * cell[k] - offset[k]) / self.way[k];
                if t > 0.0 && t < FORGOTTEN {
                    kinks.push(t);
                }
            }
        }
        // beside a kink that is not its own end a piece has points as close as at a kink
        let is_kink = |t: f64| kinks.iter().any(|kink| (kink - t).abs() <= BESIDE * t);
        let mut ends: Vec<f64> = kinks.iter().chain(&PIECES).copied().collect();
        ends.push(FORGOTTEN);
        ends.sort_by(f64::total_cmp);
        let mut sum = 0.0;
        for pair in ends.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            if from == to {
                continue;
            }
            sum += match (is_kink(from), is_kink(to)) {
                (true, true) => {
                    let middle = 0.5 * (from + to);
                    gathered(value, from, middle) + gathered(value, to, middle)
                }
                (true, false) => gathered(value, from, to),
                (false, true) => gathered(value, to, from),
                (false, false) => {
                    let points = RULE.iter();
                    let part = |(u, w): &(f64, f64)| w * value(from + u * (to - from));
                    (to - from) * points.map(part).sum::<f64>()
                }
            };
        }
        sum
    }
}

/// Integral between a kink and another place, whichever comes first.
fn gathered(value: impl Fn(f64) -> f64, kink: f64, end: f64) -> f64 {
    let length = end - kink;
    let part = |(u, w): &(f64, f64)| {
        let slope = f64::from(GATHERING) * u.powi(GATHERING - 1);
        w * slope * value(kink + u.powi(GATHERING) * length)
    };
    length.abs() * RULE.iter().map(part).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::half_space::Medium;
    use Component::{Normal, X, Y};

    const RUBBER: Material = Material {
        shear_modulus: 1.143e9,
        poisson_ratio: 0.4,
    };
    const PAIRS: [[Component; 2]; 6] = [
        [Normal, Normal],
        [X, X],
        [X, Y],
        [Y, Y],
        [X, Normal],
        [Y, Normal],
    ];

    fn body(creep: f64, way: [f64; 2]) -> Viscoelastic {
        Viscoelastic {
            material: RUBBER,
            creep,
            way,
        }
    }

    /// Integral by the substitution of hyperbolic tangents, which no singularity at an end disturbs.
    fn slowly(f: &dyn Fn(f64) -> f64, a: f64, b: f64) -> f64 {
        let step = 1.0 / 32.0;
        let point = |k: i32| {
            let t = step * f64::from(k);
            let inner = 0.5 * std::f64::consts::PI * t.sinh();
            let weight = 0.5 * std::f64::consts::PI * t.cosh() / inner.cosh().powi(2);
            0.5 * (b - a) * step * weight * f(0.5 * (a + b) + 0.5 * (b - a) * inner.tanh())
        };
        (-100..=100).map(point).sum()
    }

    #[test]
    fn the_way_ahead_is_summed_up() {
        let places = [
            [0.0, 0.0],
            [-1.0, 0.0],
            [-7.0, 1.0],
            [1.0, -1.0],
            [5.0, 9.0],
            [0.3, 0.2],
        ];
        for (cell, lengths) in [
            ([1.0, 1.0], [0.1, 1.0, 30.0]),
            ([1.0, 2000.0], [0.3, 50.0, 280.0]),
        ] {
            for length in lengths {
                for angle in [0.0_f64, 2.5] {
                    let way = [length * angle.cos(), length * angle.sin()];
                    let body = body(0.7, way);
                    for [observed, loaded] in PAIRS {
                        let at = |o: [f64; 2]| influence(&RUBBER, observed, loaded, o, cell);
                        let most = at([0.3 * cell[0], 0.2 * cell[1]]).abs();
                        // edges are crossed just before and just after a new piece of the way
                        let beside = [0.99, 1.0 - 1e-4, 1.0 + 1e-4, 4.0 - 1e-3, 12.0 - 1e-2];
                        let crossed = beside.map(|t| [0.5 * cell[0] - t * way[0], 0.2]);
                        for place in places.into_iter().chain(crossed) {
                            let value = |t: f64| {
                                (-t).exp() * at([place[0] + t * way[0], place[1] + t * way[1]])
                            };
                            let crossing = |k: usize, e: f64| (e * cell[k] - place[k]) / way[k];
                            let mut ends: Vec<f64> = (0..40).map(f64::from).collect();
                            ends.extend([0, 1].map(|k| crossing(k, 0.5)));
                            ends.extend([0, 1].map(|k| crossing(k, -0.5)));
                            ends.retain(|t| (0.0..40.0).contains(t));
                            ends.sort_by(f64::total_cmp);
                            let pieces = ends.windows(2);
                            let sum: f64 = pieces.map(|e| slowly(&value, e[0], e[1])).sum();
                            let found = body.remainder(observed, loaded, place, cell) / 0.7;
                            assert!(
                                (found - sum).abs() < 1e-8 * most,
                                "{observed:?} {loaded:?} {place:?} {way:?}: {found} {sum}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn limits_are_elastic() {
        let cell = [1.0, 1.0];
        for [observed, loaded] in PAIRS {
            for offset in [[0.0, 0.0], [1.0, 0.0], [-3.0, 2.0]] {
                let at = |creep, length| {
                    let medium = Medium::Viscoelastic(body(creep, [length, 0.0]));
                    medium.influence(observed, loaded, offset, cell)
                };
                let elastic = influence(&RUBBER, observed, loaded, offset, cell);
                let size = influence(&RUBBER, observed, loaded, [0.2, 0.3], cell).abs();
                for (found, expected) in [
                    (at(0.0, 1.0), elastic),
                    (at(0.5, 0.0), 1.5 * elastic),
                    (at(0.5, 1e-9), 1.5 * elastic),
                    (at(0.5, 1e12), elastic),
                ] {
                    assert!((found - expected).abs() < 3e-9 * size, "{found} {expected}");
                }
            }
        }
    }
}

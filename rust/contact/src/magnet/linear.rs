// SPDX-License-Identifier: MIT OR Apache-2.0
//! The pull of a magnet, linearised: how it follows gaps and everything that the magnet is.
//!
//! With the force of its pole held, each point answers to its own gap. The forces follow all gaps through the one flux:
//! those of a pole change its flux by `e`, and forces and flux then settle so that all poles carry the same flux again
//! and the coil gives what the poles, yoke and rail take. All of this is linear and solved in closed form.

use std::ops::Range;

use super::circuit::Circuit;
use super::iron::PERMEABILITY;
use crate::error::{Error, check};

/// What a magnet is, by which its pull is derived, in the order of [`Slopes::of_parameters`]: ampere-turns [A], gap that
/// is not magnetic [m], share of iron, length of the poles [m], leakage [H], length [m] and section [m2] of the yoke
/// and of the rail, and the factor of the speed.
pub const PARAMETERS: [&str; 10] = [
    "ampere_turns",
    "non_magnetic_gap",
    "iron_share",
    "pole_length",
    "leakage",
    "yoke.length",
    "yoke.area",
    "rail.length",
    "rail.area",
    "factor",
];

/// Changes of what settles the forces of the poles: flux of each pole at a held force [Wb], ampere-turns less those that
/// yoke and rail take beyond their own slopes.
struct Unsettled {
    flux: Vec<f64>,
    /// Force [A] that the coil gives more, or the yoke takes less.
    coil: f64,
    /// Force [A] that the rail takes more.
    rail: f64,
}

/// Derivatives of the pull about some gaps.
#[derive(Clone, Debug)]
pub struct Slopes {
    poles: Vec<Range<usize>>,
    /// Pressure (n) by the force of the pole [Pa/A]; nothing where iron is saturated.
    by_force: Vec<f64>,
    /// Pressure (n) by the own gap [Pa/m] and flux of the pole by it [Wb/m], at a held force of the pole; nothing of a
    /// gap below 0.
    own: Vec<f64>,
    flux_by_gap: Vec<f64>,
    /// Flux of each pole by its force [Wb/A].
    permeance: Vec<f64>,
    /// `1 + dY/dU L`, and what all takes by the flux: `(1 + dY/dU L) (sum 1 / permeance + dR/dU) + dY/dU` [A/Wb].
    by_outer: f64,
    reluctance: f64,
    /// Pressure (n) by a unit of each parameter.
    parameters: Vec<Vec<f64>>,
}

impl Circuit {
    /// How the pull over gaps (n) [m] changes with them and with the magnet, at a `factor` of the speed.
    ///
    /// Where the curve of the iron has a corner, the slopes are those of one of its sides.
    ///
    /// # Errors
    /// As [`Circuit::attract`].
    pub fn slopes(&self, gap: &[f64], factor: f64) -> Result<Slopes, Error> {
        let found = self.attract(gap, factor)?;
        let (n, given) = (gap.len(), &self.poles);
        let (iron_share, length) = (given.iron_share, given.length);
        let share = factor * iron_share;
        let saturation = self.iron.saturation();
        let mut first = 0;
        let ranges = given.points.iter().map(|count| {
            first += count;
            first - count..first
        });
        let poles: Vec<Range<usize>> = ranges.collect();
        let mut by_force = vec![0.0; n];
        let (mut by_distance, mut flux_by_distance) = (vec![0.0; n], vec![0.0; n]);
        let (mut by_length, mut flux_by_length) = (vec![0.0; n], vec![0.0; poles.len()]);
        let mut permeance = vec![0.0; poles.len()];
        for (k, range) in poles.iter().enumerate() {
            for i in range.clone() {
                let distance = gap[i].max(0.0) + given.non_magnetic_gap;
                let (density, slope) = self.iron.in_series(found.forces[k], length, distance);
                let area = iron_share * given.area[i];
                let (by_own, field) = (-density / PERMEABILITY * slope, self.iron.field(density));
                permeance[k] += area * slope;
                flux_by_distance[i] = area * by_own;
                flux_by_length[k] -= area * field * slope;
                if density < saturation {
                    let by_density = share * density / PERMEABILITY;
                    by_force[i] = by_density * slope;
                    by_distance[i] = by_density * by_own;
                    by_length[i] = -by_density * field * slope;
                }
            }
        }
        let flux = found.flux;
        // force that a limb takes by its flux, by its length and by its section
        let limb = |limb: &Option<super::Limb>, flux: f64| match limb {
            None => [0.0; 3],
            Some(limb) => {
                let density = flux / limb.area;
                let by_flux = self.iron.field_slope(density) * limb.length / limb.area;
                [by_flux, self.iron.field(density), -by_flux * density]
            }
        };
        let rail = limb(&self.rail, flux);
        let taken = (self.rail).map_or(0.0, |r| self.iron.field(flux / r.area) * r.length);
        let outer = found.forces.iter().sum::<f64>() + taken;
        let yoke = limb(&self.yoke, flux + self.leakage * outer);
        let by_outer = 1.0 + yoke[0] * self.leakage;
        let series: f64 = permeance.iter().map(|f| 1.0 / f).sum::<f64>() + rail[0];
        let is_open = |i: &usize| gap[*i] >= 0.0;
        let of_gap = |slopes: &[f64]| -> Vec<f64> {
            let own = |i: usize| if is_open(&i) { slopes[i] } else { 0.0 };
            (0..n).map(own).collect()
        };
        let mut slopes = Slopes {
            by_force,
            own: of_gap(&by_distance),
            flux_by_gap: of_gap(&flux_by_distance),
            permeance,
            by_outer,
            reluctance: by_outer * series + yoke[0],
            parameters: Vec::new(),
            poles,
        };
        let nothing = || Unsettled {
            flux: vec![0.0; slopes.poles.len()],
            coil: 0.0,
            rail: 0.0,
        };
        let by_coil = |coil: f64| Unsettled { coil, ..nothing() };
        let by_rail = |rail: f64| Unsettled { rail, ..nothing() };
        let sums = |of: &[f64]| -> Vec<f64> {
            (slopes.poles.iter())
                .map(|range| of[range.clone()].iter().sum())
                .collect()
        };
        let by_flux = |flux: Vec<f64>| Unsettled { flux, ..nothing() };
        let scaled = |by: f64| -> Vec<f64> {
            let of = |p: &f64| if by == 0.0 { 0.0 } else { p / by };
            found.pressure.iter().map(of).collect()
        };
        let by_factor: Vec<f64> = if factor > 0.0 {
            scaled(factor)
        } else {
            self.attract(gap, 1.0)?.pressure
        };
        let zero = vec![0.0; n];
        let parameters = [
            (zero.clone(), by_coil(1.0)),
            (by_distance.clone(), by_flux(sums(&flux_by_distance))),
            (
                scaled(iron_share),
                by_flux(vec![flux / iron_share; slopes.poles.len()]),
            ),
            (by_length, by_flux(flux_by_length)),
            (zero.clone(), by_coil(-yoke[0] * outer)),
            (zero.clone(), by_coil(-yoke[1])),
            (zero.clone(), by_coil(-yoke[2])),
            (zero.clone(), by_rail(rail[1])),
            (zero.clone(), by_rail(rail[2])),
        ];
        let mut fields: Vec<Vec<f64>> = (parameters.into_iter())
            .map(|(own, unsettled)| slopes.settled(own, &unsettled))
            .collect();
        // the flux is what it is at any speed
        fields.push(by_factor);
        slopes.parameters = fields;
        Ok(slopes)
    }
}

impl Slopes {
    /// Number of points.
    pub fn points(&self) -> usize {
        self.own.len()
    }

    /// Pressure (n) by a unit of each of the [`PARAMETERS`], with all gaps held.
    pub fn of_parameters(&self) -> &[Vec<f64>] {
        &self.parameters
    }

    /// The change of the pressure (n) [Pa] that follows one of the gaps (n) [m].
    ///
    /// # Errors
    /// A wrong length, numbers that are not finite.
    pub fn times(&self, gap: &[f64]) -> Result<Vec<f64>, Error> {
        check("gap", gap, self.points())?;
        let product = |slopes: &[f64]| slopes.iter().zip(gap).map(|(s, g)| s * g).collect();
        let (own, moved): (Vec<f64>, Vec<f64>) = (product(&self.own), product(&self.flux_by_gap));
        let unsettled = Unsettled {
            flux: (self.poles.iter())
                .map(|range| moved[range.clone()].iter().sum())
                .collect(),
            coil: 0.0,
            rail: 0.0,
        };
        Ok(self.settled(own, &unsettled))
    }

    /// The transposed map: weights (n) of gaps that do what weights (n) of pressures do.
    ///
    /// # Errors
    /// A wrong length, numbers that are not finite.
    pub fn transposed(&self, weights: &[f64]) -> Result<Vec<f64>, Error> {
        check("weights", weights, self.points())?;
        let by_force: Vec<f64> = (self.poles.iter())
            .map(|range| range.clone().map(|i| weights[i] * self.by_force[i]).sum())
            .collect();
        let forces = by_force.iter().zip(&self.permeance);
        let all: f64 = forces.clone().map(|(t, f)| t / f).sum();
        let mut sums: Vec<f64> = (self.own.iter().zip(weights)).map(|(o, w)| o * w).collect();
        for (range, (by_force, permeance)) in self.poles.iter().zip(forces) {
            let by_flux = (all * self.by_outer / self.reluctance - by_force) / permeance;
            for i in range.clone() {
                sums[i] += by_flux * self.flux_by_gap[i];
            }
        }
        Ok(sums)
    }

    /// `own` (n) changes of the pressure at held forces, with those that follow as the forces settle.
    fn settled(&self, mut own: Vec<f64>, unsettled: &Unsettled) -> Vec<f64> {
        let missing = unsettled.flux.iter().zip(&self.permeance);
        let series: f64 = missing.clone().map(|(e, f)| e / f).sum();
        let flux = (unsettled.coil + self.by_outer * (series - unsettled.rail)) / self.reluctance;
        for (range, (e, permeance)) in self.poles.iter().zip(missing) {
            let force = (flux - e) / permeance;
            for i in range.clone() {
                own[i] += self.by_force[i] * force;
            }
        }
        own
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! One flux through a coil, poles in series, and what closes its way.

use super::iron::{Iron, PERMEABILITY};
use crate::error::{Error, check, check_number, check_positive};

/// Share of the forces of a pole or of the coil to which they are found.
const TOLERANCE: f64 = 1e-13;
/// Steps after which a monotone equation is solved to rounding, by bisections alone.
const STEPS: usize = 200;

/// A piece of iron that carries the whole flux.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limb {
    /// Length along the flux [m].
    pub length: f64,
    /// Section [m2].
    pub area: f64,
}

/// The faces of the poles.
#[derive(Clone, Debug, PartialEq)]
pub struct Poles {
    /// Area of each point of the contact (n) [m2].
    pub area: Vec<f64>,
    /// Points of each pole, one after the other.
    pub points: Vec<usize>,
    /// Area of iron in parts of the area of the contact.
    pub iron_share: f64,
    /// Length of the column of iron above each point [m].
    pub length: f64,
    /// Thickness of what is not magnetic between the iron and the contact [m].
    pub non_magnetic_gap: f64,
}

/// A coil, its poles and the iron that closes the way of the flux.
#[derive(Clone, Debug, PartialEq)]
pub struct Circuit {
    pub(super) iron: Iron,
    ampere_turns: f64,
    pub(super) poles: Poles,
    pub(super) yoke: Option<Limb>,
    pub(super) rail: Option<Limb>,
    pub(super) leakage: f64,
}

/// How a magnet pulls.
#[derive(Clone, Debug, PartialEq)]
pub struct Attraction {
    /// Pressure at the points (n) [Pa], on the area of the contact.
    pub pressure: Vec<f64>,
    /// Derivative (n) [Pa/m] of the pressure by the gap of the point, with the force of its pole held.
    pub slope: Vec<f64>,
    /// Flux density at the points (n) [T].
    pub flux_density: Vec<f64>,
    /// Flux through the poles [Wb].
    pub flux: f64,
    /// Magnetomotive force of each pole [A].
    pub forces: Vec<f64>,
}

impl Circuit {
    /// A circuit with a coil of so many ampere-turns [A]; `yoke` and `rail` of the same iron close it, and a `leakage`
    /// [H] leads past poles and rail.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, negative or zero where they may not be.
    pub fn new(
        iron: Iron,
        ampere_turns: f64,
        poles: Poles,
        [yoke, rail]: [Option<Limb>; 2],
        leakage: f64,
    ) -> Result<Self, Error> {
        check("area", &poles.area, poles.points.iter().sum())?;
        check_positive("ampere_turns", ampere_turns)?;
        check_positive("non_magnetic_gap", poles.non_magnetic_gap)?;
        check_positive("iron_share", poles.iron_share)?;
        let wanted = "a number from 0 on is needed";
        check_number("pole_length", poles.length, poles.length >= 0.0, wanted)?;
        check_number("leakage", leakage, leakage >= 0.0, wanted)?;
        for limb in [yoke, rail].iter().flatten() {
            check_positive("length of a limb", limb.length)?;
            check_positive("area of a limb", limb.area)?;
        }
        Ok(Self {
            iron,
            ampere_turns,
            poles,
            yoke,
            rail,
            leakage,
        })
    }

    /// The same magnet with other ampere-turns [A], which may be 0: switched off.
    ///
    /// # Errors
    /// A number that is not finite, or negative.
    pub fn with_ampere_turns(&self, ampere_turns: f64) -> Result<Self, Error> {
        check_number(
            "ampere_turns",
            ampere_turns,
            ampere_turns >= 0.0,
            "a number from 0 on is needed",
        )?;
        Ok(Self {
            ampere_turns,
            ..self.clone()
        })
    }

    /// Ampere-turns [A] of the coil.
    pub fn ampere_turns(&self) -> f64 {
        self.ampere_turns
    }

    /// Its iron.
    pub fn iron(&self) -> &Iron {
        &self.iron
    }

    /// The faces of its poles.
    pub fn poles(&self) -> &Poles {
        &self.poles
    }

    /// Yoke and rail.
    pub fn limbs(&self) -> [Option<Limb>; 2] {
        [self.yoke, self.rail]
    }

    /// Permeance [H] past poles and rail.
    pub fn leakage(&self) -> f64 {
        self.leakage
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.poles.area.len()
    }

    /// The largest pressure [Pa] that saturated iron gives, on the area of the contact.
    pub fn limit(&self) -> f64 {
        self.poles.iron_share * pressure_of(self.iron.saturation())
    }

    /// How it pulls over gaps (n) [m], which count from zero on, times a `factor` of the speed.
    ///
    /// # Errors
    /// A wrong length, numbers that are not finite, a negative factor.
    pub fn attract(&self, gap: &[f64], factor: f64) -> Result<Attraction, Error> {
        let n = self.points();
        check("gap", gap, n)?;
        check_number(
            "factor",
            factor,
            factor >= 0.0,
            "a number from 0 on is needed",
        )?;
        let distance: Vec<f64> = (gap.iter())
            .map(|g| g.max(0.0) + self.poles.non_magnetic_gap)
            .collect();
        let (flux, forces) = self.balance(&distance);
        let mut found = Attraction {
            pressure: Vec::with_capacity(n),
            slope: Vec::with_capacity(n),
            flux_density: Vec::with_capacity(n),
            flux,
            forces,
        };
        let saturation = self.iron.saturation();
        let share = factor * self.poles.iron_share;
        let mut first = 0;
        for (&count, &force) in self.poles.points.iter().zip(&found.forces) {
            for (&gap, &distance) in (gap.iter().zip(&distance)).skip(first).take(count) {
                let (density, by_force) = self.iron.in_series(force, self.poles.length, distance);
                let is_moved = gap >= 0.0 && density < saturation;
                found
                    .pressure
                    .push(share * pressure_of(density.min(saturation)));
                found.slope.push(if is_moved {
                    -share * density.powi(2) * by_force / PERMEABILITY.powi(2)
                } else {
                    0.0
                });
                found.flux_density.push(density);
            }
            first += count;
        }
        Ok(found)
    }

    /// The flux, and the force of each pole, at distances (n) [m] between the irons.
    fn balance(&self, distance: &[f64]) -> (f64, Vec<f64>) {
        let ranges: Vec<_> = (self.poles.points.iter())
            .scan(0, |first, count| {
                *first += count;
                Some(*first - count..*first)
            })
            .collect();
        // no pole takes more than the coil gives
        let most = ranges
            .iter()
            .map(|range| self.flux_of(range.clone(), distance, self.ampere_turns).0)
            .fold(f64::INFINITY, f64::min);
        let mut forces = vec![self.ampere_turns / ranges.len() as f64; ranges.len()];
        let flux = increasing(most, 0.5 * most, TOLERANCE * most, |flux| {
            let mut taken = 0.0;
            let mut resistance = 0.0;
            for (range, force) in ranges.iter().zip(&mut forces) {
                let enough = TOLERANCE * self.ampere_turns;
                *force = increasing(self.ampere_turns, *force, enough, |force| {
                    let (driven, slope) = self.flux_of(range.clone(), distance, force);
                    (driven - flux, slope)
                });
                taken += *force;
                resistance += 1.0 / self.flux_of(range.clone(), distance, *force).1;
            }
            let through = |limb: &Option<Limb>, flux: f64| match limb {
                None => (0.0, 0.0),
                Some(limb) => {
                    let density = flux / limb.area;
                    let slope = self.iron.field_slope(density) / limb.area;
                    (self.iron.field(density) * limb.length, slope * limb.length)
                }
            };
            let (rail, by_rail) = through(&self.rail, flux);
            let (outer, by_outer) = (taken + rail, resistance + by_rail);
            let (yoke, by_yoke) = through(&self.yoke, flux + self.leakage * outer);
            (
                outer + yoke - self.ampere_turns,
                by_outer + by_yoke * (1.0 + self.leakage * by_outer),
            )
        });
        (flux, forces)
    }

    /// Flux [Wb] through a pole by its force [A], and its derivative [Wb/A].
    fn flux_of(&self, range: std::ops::Range<usize>, distance: &[f64], force: f64) -> (f64, f64) {
        let (mut flux, mut slope) = (0.0, 0.0);
        for i in range {
            let (density, by_force) = self.iron.in_series(force, self.poles.length, distance[i]);
            let area = self.poles.iron_share * self.poles.area[i];
            flux += area * density;
            slope += area * by_force;
        }
        (flux, slope)
    }
}

/// Pressure [Pa] on iron by a flux density [T] in the gap.
fn pressure_of(flux_density: f64) -> f64 {
    flux_density.powi(2) / (2.0 * PERMEABILITY)
}

/// Where a rising function is zero between 0 and `highest`, to `tolerance`, from `start`; `value` gives it and its
/// slope. An end where it is not zero inside.
fn increasing(
    highest: f64,
    start: f64,
    tolerance: f64,
    mut value: impl FnMut(f64) -> (f64, f64),
) -> f64 {
    let (mut low, mut high) = (0.0, highest);
    let mut at = start.clamp(low, high);
    for _ in 0..STEPS {
        let (found, slope) = value(at);
        if found > 0.0 {
            high = at;
        } else {
            low = at;
        }
        let newton = at - found / slope;
        let next = if newton >= low && newton <= high {
            newton
        } else {
            0.5 * (low + high)
        };
        let is_found = found == 0.0 || (next - at).abs() <= tolerance || high - low <= tolerance;
        at = next;
        if is_found {
            break;
        }
    }
    at
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Friction laws: the coefficient of friction as a function of the slip speed, of the temperature and of its past.

use crate::temperature::TemperatureLaw;

/// Steady coefficient of friction as a function of the slip speed.
#[derive(Clone, Debug, PartialEq)]
pub enum SlipLaw {
    /// `kinetic + (static - kinetic) exp(-ln 2 s / half_slip)`. [Vollebregt2012, eq. 3]
    Exponential {
        /// Coefficient at rest [-].
        at_rest: f64,
        /// Coefficient at high slip speed [-].
        kinetic: f64,
        /// Slip speed at which half of the difference is gone [m/s].
        half_slip: f64,
    },
    /// Piecewise linear between points, constant beyond the last one.
    Table {
        /// Slip speeds [m/s], rising from 0.
        slip_speed: Vec<f64>,
        /// Coefficient of friction [-] at each of them.
        coefficient: Vec<f64>,
    },
}

impl SlipLaw {
    /// Coefficient [-] and its derivative [s/m] at the slip speed `s` [m/s].
    pub fn evaluate(&self, s: f64) -> (f64, f64) {
        match self {
            Self::Exponential {
                at_rest,
                kinetic,
                half_slip,
            } => {
                let rate = std::f64::consts::LN_2 / half_slip;
                let excess = (at_rest - kinetic) * (-rate * s).exp();
                (kinetic + excess, -rate * excess)
            }
            Self::Table {
                slip_speed,
                coefficient,
            } => interpolated(slip_speed, coefficient, s),
        }
    }
}

/// Value and slope at `x` of what is linear between `places`, which rise, and constant beyond the first and last one.
pub(crate) fn interpolated(places: &[f64], values: &[f64], x: f64) -> (f64, f64) {
    let above = places.partition_point(|place| *place <= x);
    if above == 0 || above == places.len() {
        let end = above.saturating_sub(1);
        return (values.get(end).copied().unwrap_or(0.0), 0.0);
    }
    let slope = (values[above] - values[above - 1]) / (places[above] - places[above - 1]);
    (values[above - 1] + slope * (x - places[above - 1]), slope)
}

/// Adds the shares of the values at `places` in what is [`interpolated`] at `x`.
fn shares_at(places: &[f64], x: f64, shares: &mut [f64]) {
    let above = places.partition_point(|place| *place <= x);
    if above == 0 || above == places.len() {
        shares[above.saturating_sub(1)] += 1.0;
    } else {
        let share = (x - places[above - 1]) / (places[above] - places[above - 1]);
        shares[above] += share;
        shares[above - 1] += 1.0 - share;
    }
}

impl SlipLaw {
    /// Derivatives of the coefficient at the slip speed `s` [m/s] by the parameters of the law: the two coefficients
    /// and the slip speed of an exponential law, the coefficients of a table, then its slip speeds.
    pub fn parameters(&self, s: f64) -> Vec<f64> {
        match self {
            Self::Exponential {
                at_rest,
                kinetic,
                half_slip,
            } => {
                let rate = std::f64::consts::LN_2 / half_slip;
                let left = (-rate * s).exp();
                let by_half = (at_rest - kinetic) * left * rate * s / half_slip;
                vec![left, 1.0 - left, by_half]
            }
            Self::Table {
                slip_speed,
                coefficient,
            } => parameters_at(slip_speed, coefficient, s),
        }
    }
}

/// Derivatives of what is [`interpolated`] at `x`, first by the values, then by the places: a place that moves takes the
/// line along.
pub(crate) fn parameters_at(places: &[f64], values: &[f64], x: f64) -> Vec<f64> {
    let (_, slope) = interpolated(places, values, x);
    let mut found = vec![0.0; 2 * places.len()];
    let (by_values, by_places) = found.split_at_mut(places.len());
    shares_at(places, x, by_values);
    for (by_place, share) in by_places.iter_mut().zip(&*by_values) {
        *by_place = -slope * share;
    }
    found
}

/// Memory of the coefficient of friction: it follows the steady law over a slip distance.
///
/// `d mu / dt = -max(s, min_slip) / distance (mu - mu_s(s))` for a particle. [Vollebregt2012, eq. 4]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Memory {
    /// Characteristic slip distance [m].
    pub distance: f64,
    /// Slip speed [m/s] below which the coefficient still adapts at this one.
    pub min_slip: f64,
}

/// The friction between the surfaces.
#[derive(Clone, Debug, PartialEq)]
pub enum Friction {
    /// A fixed coefficient at each point [-], (n).
    Coulomb(Vec<f64>),
    /// One coefficient until a point slips, another from then on.
    StaticKinetic {
        /// Coefficient of a point that sticks [-].
        at_rest: f64,
        /// Coefficient of a point that slips [-].
        kinetic: f64,
    },
    /// A coefficient that follows the slip speed, at once or with a memory.
    SpeedDependent {
        /// The steady law.
        law: SlipLaw,
        /// How the coefficient follows it; `None` for at once.
        memory: Option<Memory>,
    },
    /// A coefficient that follows the temperature of the surfaces, in steady rolling.
    TemperatureDependent(TemperatureLaw),
}

/// Coefficients of friction over a patch, given the slip speeds: the law, its memory, and where the
/// particles come from.
#[derive(Clone, Debug)]
pub(crate) struct SlipFriction<'a> {
    law: &'a SlipLaw,
    memory: Option<(Memory, Past)>,
}

/// Where the memory of a point comes from.
#[derive(Clone, Debug)]
pub(crate) enum Past {
    /// Coefficients that the particles carried at the previous time, (n).
    Known {
        /// Coefficient of each particle a step ago.
        coefficient: Vec<f64>,
        /// Time since then [s].
        time: f64,
    },
    /// Steady rolling: the particles come from the points upstream.
    Upstream(Upstream),
}

/// Points from which particles come in steady rolling.
#[derive(Clone, Debug)]
pub(crate) struct Upstream {
    /// Points, those upstream first.
    pub(crate) order: Vec<usize>,
    /// For each point the points it comes from, with their weights; what is missing to a total of one comes from
    /// outside at rest.
    pub(crate) sources: Vec<[(usize, f64); 4]>,
    /// Time between two points [s].
    pub(crate) time: f64,
}

impl<'a> SlipFriction<'a> {
    pub(crate) fn new(law: &'a SlipLaw, memory: Option<(Memory, Past)>) -> Self {
        Self { law, memory }
    }

    /// Coefficients at the slip speeds `speed` [m/s].
    pub(crate) fn coefficients(&self, speed: &[f64], coefficient: &mut [f64]) {
        for (mu, s) in coefficient.iter_mut().zip(speed) {
            *mu = self.law.evaluate(*s).0;
        }
        if let Some((memory, past)) = &self.memory {
            memory.follow(past, self.law.evaluate(0.0).0, speed, coefficient);
        }
    }

    /// Derivative of the coefficients at `speed` along `change`.
    pub(crate) fn derivative(&self, speed: &[f64], change: &[f64], derivative: &mut [f64]) {
        derivative.copy_from_slice(&self.gains(speed));
        for (d, c) in derivative.iter_mut().zip(change) {
            *d *= c;
        }
        self.pass_on(speed, derivative);
    }

    /// Derivative by `speed` of the sum of the coefficients with the weights in `derivative`, which it overwrites: the
    /// transpose of [`SlipFriction::derivative`].
    pub(crate) fn derivative_transposed(&self, speed: &[f64], derivative: &mut [f64]) {
        self.pass_back(speed, derivative);
        for (d, gain) in derivative.iter_mut().zip(self.gains(speed)) {
            *d *= gain;
        }
    }

    /// What a unit of speed adds at its own point to the right side of the equation of the coefficient: with a memory
    /// `(1 + c) mu = mu_past + c mu_s`, so that `(1 + c) dmu = dmu_past + c dmu_s + (mu_s - mu) dc`.
    fn gains(&self, speed: &[f64]) -> Vec<f64> {
        let laws = speed.iter().map(|s| self.law.evaluate(*s));
        let Some((memory, past)) = &self.memory else {
            return laws.map(|(_, slope)| slope).collect();
        };
        let mut coefficient = vec![0.0; speed.len()];
        self.coefficients(speed, &mut coefficient);
        laws.zip(speed)
            .zip(&coefficient)
            .map(|(((steady, follow), s), mu)| {
                let (c, slope) = memory.rate(*s, past.time());
                c * follow + (steady - mu) * slope
            })
            .collect()
    }

    /// Changes of the coefficients from those of the right sides of their equations, in place.
    pub(crate) fn pass_on(&self, speed: &[f64], change: &mut [f64]) {
        if let Some((memory, past)) = &self.memory {
            memory.pass_on(past, speed, change);
        }
    }

    /// The transpose of [`SlipFriction::pass_on`].
    pub(crate) fn pass_back(&self, speed: &[f64], weight: &mut [f64]) {
        if let Some((memory, past)) = &self.memory {
            memory.pass_back(past, speed, weight);
        }
    }

    /// What the right side of the equation of each coefficient gains by the parameters of the law, then of the memory
    /// (distance and slip speed) if there is one, then by the relative change of all speeds: (n) each.
    ///
    /// What particles bring along from an earlier state is left to the caller.
    pub(crate) fn by_parameters(&self, speed: &[f64]) -> Vec<Vec<f64>> {
        let n = speed.len();
        let count = self.law.parameters(0.0).len();
        let mut columns = vec![vec![0.0; n]; count];
        for (i, s) in speed.iter().enumerate() {
            for (column, slope) in columns.iter_mut().zip(self.law.parameters(*s)) {
                column[i] = slope;
            }
        }
        let mut by_speed: Vec<f64> = speed.iter().map(|s| s * self.law.evaluate(*s).1).collect();
        let Some((memory, past)) = &self.memory else {
            columns.push(by_speed);
            return columns;
        };
        let mut coefficient = vec![0.0; n];
        self.coefficients(speed, &mut coefficient);
        let rest = self.law.parameters(0.0);
        let (mut by_distance, mut by_least) = (vec![0.0; n], vec![0.0; n]);
        for i in 0..n {
            let (c, _) = memory.rate(speed[i], past.time());
            let lag = self.law.evaluate(speed[i]).0 - coefficient[i];
            let from_outside = past.share_of_rest(i);
            for (column, rest) in columns.iter_mut().zip(&rest) {
                column[i] = c * column[i] + from_outside * rest;
            }
            by_distance[i] = -lag * c / memory.distance;
            by_speed[i] *= c;
            if speed[i] <= memory.min_slip {
                by_least[i] = lag * c / memory.min_slip;
                // faster, a step takes less time
                by_speed[i] -= lag * c;
            }
        }
        columns.extend([by_distance, by_least, by_speed]);
        columns
    }
}

impl Past {
    /// Time between two states of a particle [s].
    pub(crate) fn time(&self) -> f64 {
        match self {
            Self::Known { time, .. } | Self::Upstream(Upstream { time, .. }) => *time,
        }
    }

    /// Part of a particle that comes from outside at rest, where that is known here.
    pub(crate) fn share_of_rest(&self, i: usize) -> f64 {
        match self {
            Self::Known { .. } => 0.0,
            Self::Upstream(upstream) => 1.0 - upstream.sources[i].iter().map(|s| s.1).sum::<f64>(),
        }
    }
}

impl Memory {
    /// Coefficients of particles that follow those in `coefficient` at the slip speeds `speed` [m/s], in place;
    /// particles enter with the coefficient `at_rest`.
    pub(crate) fn follow(&self, past: &Past, at_rest: f64, speed: &[f64], coefficient: &mut [f64]) {
        match past {
            Past::Known {
                coefficient: old,
                time,
            } => {
                for i in 0..speed.len() {
                    let (c, _) = self.rate(speed[i], *time);
                    coefficient[i] = (old[i] + c * coefficient[i]) / (1.0 + c);
                }
            }
            Past::Upstream(Upstream {
                order,
                sources,
                time,
            }) => {
                for &i in order {
                    let c = self.rate(speed[i], *time).0;
                    let (kept, share) = passed_on(i, &sources[i], c, at_rest, coefficient);
                    coefficient[i] = kept + share * coefficient[i];
                }
            }
        }
    }

    /// Changes of the coefficients from those of the right sides of their equations, in place.
    pub(crate) fn pass_on(&self, past: &Past, speed: &[f64], change: &mut [f64]) {
        match past {
            Past::Known { time, .. } => {
                for (d, s) in change.iter_mut().zip(speed) {
                    *d /= 1.0 + self.rate(*s, *time).0;
                }
            }
            Past::Upstream(Upstream {
                order,
                sources,
                time,
            }) => {
                for &i in order {
                    let mut share = 1.0 + self.rate(speed[i], *time).0;
                    let mut own = change[i];
                    for &(j, weight) in &sources[i] {
                        if j == i {
                            share -= weight;
                        } else {
                            own += weight * change[j];
                        }
                    }
                    change[i] = own / share;
                }
            }
        }
    }

    /// The transpose of [`Memory::pass_on`].
    pub(crate) fn pass_back(&self, past: &Past, speed: &[f64], weight: &mut [f64]) {
        let Past::Upstream(Upstream {
            order,
            sources,
            time,
        }) = past
        else {
            // point by point it is its own transpose
            return self.pass_on(past, speed, weight);
        };
        for &i in order.iter().rev() {
            let mut share = 1.0 + self.rate(speed[i], *time).0;
            for &(j, part) in &sources[i] {
                if j == i {
                    share -= part;
                }
            }
            weight[i] /= share;
            for &(j, part) in &sources[i] {
                if j != i {
                    weight[j] += part * weight[i];
                }
            }
        }
    }

    /// Adaptation over `time` [s] at the slip speed `s` [m/s], and its derivative.
    pub(crate) fn rate(&self, s: f64, time: f64) -> (f64, f64) {
        let scale = time / self.distance;
        if s > self.min_slip {
            (s * scale, scale)
        } else {
            (self.min_slip * scale, 0.0)
        }
    }
}

/// What the coefficient of the point `i` keeps of those at its `sources`, and the share in it of the one that it follows
/// at the rate `c`.
pub(crate) fn passed_on(
    i: usize,
    sources: &[(usize, f64)],
    c: f64,
    at_rest: f64,
    coefficient: &[f64],
) -> (f64, f64) {
    let (mut over, mut known, mut weights) = (1.0 + c, 0.0, 0.0);
    for &(j, weight) in sources {
        weights += weight;
        if j == i {
            over -= weight;
        } else {
            known += weight * coefficient[j];
        }
    }
    ((known + (1.0 - weights) * at_rest) / over, c / over)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law() -> SlipLaw {
        SlipLaw::Exponential {
            at_rest: 0.33,
            kinetic: 0.14,
            half_slip: 1.25,
        }
    }

    #[test]
    fn exponential_law_halves_its_excess() {
        let (mu, slope) = law().evaluate(1.25);
        assert!((mu - (0.14 + 0.095)).abs() < 1e-15);
        assert!((slope + 0.095 * std::f64::consts::LN_2 / 1.25).abs() < 1e-15);
    }

    #[test]
    fn table_is_linear_between_points_and_constant_beyond() {
        let table = SlipLaw::Table {
            slip_speed: vec![0.0, 1.0, 3.0],
            coefficient: vec![0.4, 0.3, 0.2],
        };
        assert_eq!(table.evaluate(0.5), (0.35, -0.1 * 1.000_000_000_000_000_2));
        assert_eq!(table.evaluate(9.0), (0.2, 0.0));
    }

    #[test]
    fn derivative_with_memory_matches_differences() {
        let law = law();
        let memory = Memory {
            distance: 3e-6,
            min_slip: 1e-3,
        };
        // three points in a row, particles come from the higher index, half of one from itself
        let past = Past::Upstream(Upstream {
            order: vec![2, 1, 0],
            sources: vec![
                [(1, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)],
                [(2, 0.5), (1, 0.5), (0, 0.0), (0, 0.0)],
                [(0, 0.0); 4],
            ],
            time: 5e-6,
        });
        let friction = SlipFriction::new(&law, Some((memory, past)));
        let speed = [0.4, 0.3, 0.9];
        let change = [0.2, -0.7, 0.5];
        let mut slope = [0.0; 3];
        friction.derivative(&speed, &change, &mut slope);
        let h = 1e-6;
        let at = |sign: f64| {
            let moved: Vec<f64> = (0..3).map(|i| speed[i] + sign * h * change[i]).collect();
            let mut mu = [0.0; 3];
            friction.coefficients(&moved, &mut mu);
            mu
        };
        let (above, below) = (at(1.0), at(-1.0));
        for i in 0..3 {
            assert!((slope[i] - (above[i] - below[i]) / (2.0 * h)).abs() < 1e-9);
        }
    }
}

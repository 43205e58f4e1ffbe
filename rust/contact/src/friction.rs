// SPDX-License-Identifier: MIT OR Apache-2.0
//! Friction laws: the coefficient of friction as a function of the slip speed and of its past.

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
            } => {
                let above = slip_speed.partition_point(|v| *v <= s);
                if above == 0 || above == slip_speed.len() {
                    let end = above.saturating_sub(1);
                    return (coefficient.get(end).copied().unwrap_or(0.0), 0.0);
                }
                let (s0, s1) = (slip_speed[above - 1], slip_speed[above]);
                let slope = (coefficient[above] - coefficient[above - 1]) / (s1 - s0);
                (coefficient[above - 1] + slope * (s - s0), slope)
            }
        }
    }
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
    Upstream {
        /// Points, those upstream first.
        order: Vec<usize>,
        /// For each point the points it comes from, with their weights; what is missing to a total of
        /// one comes from outside at rest.
        sources: Vec<[(usize, f64); 4]>,
        /// Time between two points [s].
        time: f64,
    },
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
        let Some((memory, past)) = &self.memory else {
            return;
        };
        match past {
            Past::Known {
                coefficient: old,
                time,
            } => {
                for i in 0..speed.len() {
                    let (c, _) = memory.rate(speed[i], *time);
                    coefficient[i] = (old[i] + c * coefficient[i]) / (1.0 + c);
                }
            }
            Past::Upstream {
                order,
                sources,
                time,
            } => {
                let rest = self.law.evaluate(0.0).0;
                for &i in order {
                    let (c, _) = memory.rate(speed[i], *time);
                    let mut share = 1.0 + c;
                    let mut known = c * coefficient[i];
                    let mut weights = 0.0;
                    for &(j, weight) in &sources[i] {
                        weights += weight;
                        if j == i {
                            share -= weight;
                        } else {
                            known += weight * coefficient[j];
                        }
                    }
                    coefficient[i] = (known + (1.0 - weights) * rest) / share;
                }
            }
        }
    }

    /// Derivative of the coefficients at `speed` along `change`.
    pub(crate) fn derivative(&self, speed: &[f64], change: &[f64], derivative: &mut [f64]) {
        for ((d, s), c) in derivative.iter_mut().zip(speed).zip(change) {
            *d = self.law.evaluate(*s).1 * c;
        }
        let Some((memory, past)) = &self.memory else {
            return;
        };
        let mut coefficient = vec![0.0; speed.len()];
        self.coefficients(speed, &mut coefficient);
        // of (1 + c) mu = mu_past + c mu_s: (1 + c) dmu = dmu_past + c dmu_s + (mu_s - mu) dc
        let local = |i: usize, time: f64, follow: f64| {
            let (c, slope) = memory.rate(speed[i], time);
            let steady = self.law.evaluate(speed[i]).0;
            (
                c,
                c * follow + (steady - coefficient[i]) * slope * change[i],
            )
        };
        match past {
            Past::Known { time, .. } => {
                for i in 0..speed.len() {
                    let (c, own) = local(i, *time, derivative[i]);
                    derivative[i] = own / (1.0 + c);
                }
            }
            Past::Upstream {
                order,
                sources,
                time,
            } => {
                for &i in order {
                    let (c, mut own) = local(i, *time, derivative[i]);
                    let mut share = 1.0 + c;
                    for &(j, weight) in &sources[i] {
                        if j == i {
                            share -= weight;
                        } else {
                            own += weight * derivative[j];
                        }
                    }
                    derivative[i] = own / share;
                }
            }
        }
    }
}

impl Memory {
    /// Adaptation over `time` [s] at the slip speed `s` [m/s], and its derivative.
    fn rate(&self, s: f64, time: f64) -> (f64, f64) {
        let scale = time / self.distance;
        if s > self.min_slip {
            (s * scale, scale)
        } else {
            (self.min_slip * scale, 0.0)
        }
    }
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
        let past = Past::Upstream {
            order: vec![2, 1, 0],
            sources: vec![
                [(1, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)],
                [(2, 0.5), (1, 0.5), (0, 0.0), (0, 0.0)],
                [(0, 0.0); 4],
            ],
            time: 5e-6,
        };
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

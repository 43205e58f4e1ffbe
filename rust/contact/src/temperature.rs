// SPDX-License-Identifier: MIT OR Apache-2.0
//! Friction that follows the temperature of the surfaces in steady rolling.

use mtb_heat::Conductor;

use crate::Error;
use crate::error::{check, check_number, check_positive};
use crate::friction::{Memory, interpolated, parameters_at};

/// A coefficient of friction that follows the temperature of the surfaces in contact, which is that of the heat of
/// the same contact: piecewise linear between points, constant beyond the first and the last one.
///
/// ```
/// use mtb_contact::friction::Friction;
/// use mtb_contact::temperature::TemperatureLaw;
/// use mtb_heat::Conductor;
///
/// let steel = Conductor::new(50.0, 7850.0, 490.0)?;
/// let table = (vec![0.0, 400.0], vec![0.33, 0.14]);
/// let law = TemperatureLaw::new(table.0, table.1, [steel, steel], [0.0, 80.0], None)?;
/// assert!((law.at(200.0) - 0.235).abs() < 1e-12);
/// // like bodies meet half-way between their temperatures
/// assert!((law.at_rest() - law.at(40.0)).abs() < 1e-12);
/// let friction = Friction::TemperatureDependent(law);
/// # Ok::<(), mtb_contact::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TemperatureLaw {
    temperature: Vec<f64>,
    coefficient: Vec<f64>,
    /// What the lower and the upper body are made of.
    pub bodies: [Conductor; 2],
    /// Temperatures [K] with which the lower and the upper body come.
    pub bulk: [f64; 2],
    /// How the coefficient follows the temperature; `None` for at once.
    pub memory: Option<Memory>,
}

impl TemperatureLaw {
    /// Coefficients [-] at rising temperatures [K] of the surfaces.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`], [`Error::Number`].
    pub fn new(
        temperature: Vec<f64>,
        coefficient: Vec<f64>,
        bodies: [Conductor; 2],
        bulk: [f64; 2],
        memory: Option<Memory>,
    ) -> Result<Self, Error> {
        check("temperature", &temperature, coefficient.len())?;
        check("friction coefficient", &coefficient, temperature.len())?;
        check("bulk temperature", &bulk, 2)?;
        let first = temperature.first().copied().unwrap_or(f64::NAN);
        check_number("temperature", first, first.is_finite(), "a table is needed")?;
        for pair in temperature.windows(2) {
            let wanted = "the temperatures of a table must rise";
            check_number("temperature", pair[1], pair[1] > pair[0], wanted)?;
        }
        for mu in &coefficient {
            let wanted = "a coefficient of friction must not be negative";
            check_number("friction coefficient", *mu, *mu >= 0.0, wanted)?;
        }
        if let Some(memory) = memory {
            check_positive("memory distance", memory.distance)?;
            check_positive("memory slip speed", memory.min_slip)?;
        }
        Ok(Self {
            temperature,
            coefficient,
            bodies,
            bulk,
            memory,
        })
    }

    /// Temperatures [K] and coefficients [-] of the table.
    pub fn table(&self) -> [&[f64]; 2] {
        [&self.temperature, &self.coefficient]
    }

    /// The coefficient [-] at a temperature [K] of the surfaces.
    pub fn at(&self, temperature: f64) -> f64 {
        interpolated(&self.temperature, &self.coefficient, temperature).0
    }

    /// Change of the coefficient with the temperature [1/K] at a temperature [K] of the surfaces; at a point of the
    /// table that above it.
    pub fn slope(&self, temperature: f64) -> f64 {
        interpolated(&self.temperature, &self.coefficient, temperature).1
    }

    /// The temperature [K] where the surfaces meet, before friction has heated them.
    pub fn cold(&self) -> f64 {
        let beta = self.bodies.map(|body| body.effusivity());
        (beta[0] * self.bulk[0] + beta[1] * self.bulk[1]) / (beta[0] + beta[1])
    }

    /// The coefficient [-] where the surfaces meet, before friction has heated them.
    pub fn at_rest(&self) -> f64 {
        self.at(self.cold())
    }

    /// Derivatives of the coefficient where friction's heat makes the surfaces warmer by `rise` [K]: by the coefficients
    /// and the temperatures of the table, the bulk temperatures of both bodies and their effusivities; the memory aside.
    pub fn parameters(&self, rise: f64) -> Vec<f64> {
        let cold = self.cold();
        let slope = self.slope(cold + rise);
        let mut found = parameters_at(&self.temperature, &self.coefficient, cold + rise);
        let beta = self.bodies.map(|body| body.effusivity());
        let both = beta[0] + beta[1];
        found.extend(beta.map(|beta| slope * beta / both));
        // a rise goes with the inverse of the sum of both
        found.extend(self.bulk.map(|bulk| slope * (bulk - cold - rise) / both));
        found
    }

    /// The coefficient mu [-] that is `kept + share * law(others + own * mu)`: of a cell that the heat of others brings
    /// to a temperature [K], and its own warms by `own` [K] over its coefficient.
    ///
    /// Between the points of the table both sides are linear. Where several coefficients are possible, as under one that
    /// grows with the temperature, it is the smallest: that of a cell that came cold.
    pub(crate) fn with_own_heat(&self, (kept, share): (f64, f64), others: f64, own: f64) -> f64 {
        let found = |mu: f64| kept + share * self.at(others + own * mu);
        if own <= 0.0 {
            return found(0.0);
        }
        let last = kept + share * self.largest();
        let points = self.temperature.iter().map(|t| (t - others) / own);
        let first = kept
            + share
                * self
                    .coefficient
                    .iter()
                    .copied()
                    .fold(f64::INFINITY, f64::min);
        let mut below = (first, found(first) - first);
        for mu in points.filter(|mu| *mu > first && *mu < last).chain([last]) {
            let missed = found(mu) - mu;
            if missed <= 0.0 {
                let (start, before) = below;
                // at the very start nothing is missed
                let part = if before > 0.0 {
                    before / (before - missed)
                } else {
                    0.0
                };
                return start + part * (mu - start);
            }
            below = (mu, missed);
        }
        last
    }

    /// The largest coefficient [-].
    pub fn largest(&self) -> f64 {
        self.coefficient.iter().copied().fold(0.0, f64::max)
    }
}

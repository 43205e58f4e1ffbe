// SPDX-License-Identifier: MIT OR Apache-2.0
use crate::error::{Error, positive};

/// A material that conducts and stores heat, at constant properties.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    conductivity: f64,
    density: f64,
    specific_heat: f64,
}

impl Conductor {
    /// Of a `conductivity` [W/(m K)], a `density` [kg/m3] and a `specific_heat` [J/(kg K)].
    ///
    /// # Errors
    /// [`Error::NotPositive`].
    pub fn new(conductivity: f64, density: f64, specific_heat: f64) -> Result<Self, Error> {
        Ok(Self {
            conductivity: positive("conductivity", conductivity)?,
            density: positive("density", density)?,
            specific_heat: positive("specific_heat", specific_heat)?,
        })
    }

    /// K [W/(m K)].
    pub fn conductivity(&self) -> f64 {
        self.conductivity
    }

    /// rho [kg/m3].
    pub fn density(&self) -> f64 {
        self.density
    }

    /// c [J/(kg K)].
    pub fn specific_heat(&self) -> f64 {
        self.specific_heat
    }

    /// Heat capacity of a volume, rho c [J/(m3 K)].
    pub fn capacity(&self) -> f64 {
        self.density * self.specific_heat
    }

    /// K / (rho c) [m2/s].
    pub fn diffusivity(&self) -> f64 {
        self.conductivity / self.capacity()
    }

    /// sqrt(K rho c) [W s^1/2 / (m2 K)]: in a short time t, a flux q heats the surface by 2 q sqrt(t / pi) over it.
    pub fn effusivity(&self) -> f64 {
        (self.conductivity * self.capacity()).sqrt()
    }
}

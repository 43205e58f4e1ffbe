// SPDX-License-Identifier: MIT OR Apache-2.0
//! What heat does to the temperature of surfaces that touch, as a linear map and its transpose.

use std::f64::consts::PI;

use crate::Conductor;
use crate::error::{Error, check, positive};
use crate::trail::{Crossed, trail};

/// How the heat of cells warms the cells downstream of two bodies that pass through their contact.
///
/// Where surfaces touch they have the mean of the bulk temperatures, weighted by the effusivities, and this rise; it is
/// what [`rolling`](crate::rolling()) finds there, without what flows where they do not touch.
///
/// ```
/// use mtb_heat::{Conductor, Warming};
///
/// let steel = Conductor::new(50.0, 7850.0, 490.0)?;
/// let warming = Warming::new([3, 1], [1e-3, 1e-3], 0.0, 30.0, [steel; 2])?;
/// // the contact moves along +x: the last cell is the first to be heated
/// let rise = warming.rise(&[0.0, 0.0, 1e9], &[0, 1, 2]);
/// assert!(rise[2] > rise[1] && rise[1] > rise[0] && rise[0] > 0.0);
/// # Ok::<(), mtb_heat::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Warming {
    shape: [usize; 2],
    trail: Vec<Crossed>,
    /// Rise over heat and the root of the distance [K m^1.5 / W].
    scale: f64,
}

impl Warming {
    /// On a grid of a `shape` along x and y, of cells of the sizes `spacing` [m], where the contact moves along `angle`
    /// [rad] over the `bodies`, both of which pass through it at `speed` [m/s].
    ///
    /// # Errors
    /// [`Error::NotPositive`], [`Error::NotFinite`].
    pub fn new(
        shape: [usize; 2],
        spacing: [f64; 2],
        angle: f64,
        speed: f64,
        bodies: [Conductor; 2],
    ) -> Result<Self, Error> {
        positive("spacing[0]", spacing[0])?;
        positive("spacing[1]", spacing[1])?;
        positive("speed", speed)?;
        check("angle", &[angle], 1)?;
        let [lower, upper] = bodies.map(|body| body.effusivity());
        Ok(Self {
            shape,
            trail: trail(shape, spacing, angle),
            scale: 2.0 / ((lower + upper) * (PI * speed).sqrt()),
        })
    }

    /// Rise [K] at the cells number `at`, by the heat `power` [W/m2] of all cells.
    pub fn rise(&self, power: &[f64], at: &[usize]) -> Vec<f64> {
        let rise = |cell: &usize| self.by_heat(*cell).map(|(k, by)| power[k] * by).sum();
        at.iter().map(rise).collect()
    }

    /// What the heat of a cell and of those upstream of it does to its temperature: their numbers and the rises over
    /// the heat [K m2 / W], its own first.
    pub fn by_heat(&self, cell: usize) -> impl Iterator<Item = (usize, f64)> {
        self.upstream(cell)
            .map(|(k, crossed)| (k, self.scale * (crossed.far.sqrt() - crossed.near.sqrt())))
    }

    /// Derivative of [`Warming::rise`] by the angle [K]: where a path goes through corners of cells, that by a larger
    /// one.
    pub fn rise_by_angle(&self, power: &[f64], at: &[usize]) -> Vec<f64> {
        let root = |place: f64, by: f64| {
            if place > 0.0 {
                0.5 * by / place.sqrt()
            } else {
                0.0
            }
        };
        let rise = |cell: &usize| {
            let parts = self.upstream(*cell).map(|(k, crossed)| {
                let [near, far] = crossed.turned;
                power[k] * (root(crossed.far, far) - root(crossed.near, near))
            });
            self.scale * parts.sum::<f64>()
        };
        at.iter().map(rise).collect()
    }

    /// The transpose of [`Warming::rise`]: adds to `power` what weights of the rises at the cells number `at` are of the
    /// heat of all cells.
    pub fn weigh(&self, weights: &[f64], at: &[usize], power: &mut [f64]) {
        for (weight, cell) in weights.iter().zip(at) {
            for (k, by) in self.by_heat(*cell) {
                power[k] += weight * by;
            }
        }
    }

    /// The cells on the way to one, each with the part of the way in it.
    fn upstream(&self, cell: usize) -> impl Iterator<Item = (usize, &Crossed)> {
        let here = [cell % self.shape[0], cell / self.shape[0]];
        self.trail
            .iter()
            .map_while(move |crossed| Some((crossed.seen_from(here, self.shape)?, crossed)))
    }
}

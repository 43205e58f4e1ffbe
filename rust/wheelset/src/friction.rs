// SPDX-License-Identifier: MIT OR Apache-2.0
//! Friction between wheels and rails.

use std::borrow::Cow;

use mtb_contact::friction::Friction;

use crate::error::{Error, check_entries};

/// Friction between wheels and rails.
#[derive(Clone, Debug, PartialEq)]
pub enum WheelFriction {
    /// One law everywhere; a Coulomb law has one coefficient.
    Everywhere(Friction),
    /// A coefficient that the rails have, place by place.
    OnRail(RailFriction),
}

impl From<Friction> for WheelFriction {
    fn from(law: Friction) -> Self {
        Self::Everywhere(law)
    }
}

impl WheelFriction {
    pub(crate) fn check(&self) -> Result<(), Error> {
        match self {
            Self::Everywhere(Friction::Coulomb(coefficient)) if coefficient.len() != 1 => {
                Err(Error::Varying {
                    count: coefficient.len(),
                })
            }
            _ => Ok(()),
        }
    }

    /// The coefficient [-] of a particle that has not slipped; without meaning where friction varies over the rail.
    pub(crate) fn at_rest(&self) -> f64 {
        match self {
            Self::Everywhere(Friction::Coulomb(coefficient)) => coefficient[0],
            Self::Everywhere(Friction::StaticKinetic { at_rest, .. }) => *at_rest,
            Self::Everywhere(Friction::SpeedDependent { law, .. }) => law.evaluate(0.0).0,
            Self::Everywhere(Friction::TemperatureDependent(law)) => law.at_rest(),
            Self::OnRail(_) => 0.0,
        }
    }

    /// The law at `cells` points; `place` gives x in the track and y of the rail profile of each [m].
    pub(crate) fn at(&self, cells: usize, place: impl Fn(usize) -> [f64; 2]) -> Cow<'_, Friction> {
        match self {
            Self::Everywhere(Friction::Coulomb(coefficient)) => {
                Cow::Owned(Friction::Coulomb(vec![coefficient[0]; cells]))
            }
            Self::Everywhere(law) => Cow::Borrowed(law),
            Self::OnRail(map) => {
                let each = (0..cells).map(|k| {
                    let [x, y] = place(k);
                    map.coefficient(x, y)
                });
                Cow::Owned(Friction::Coulomb(each.collect()))
            }
        }
    }
}

/// A coefficient of friction [-] over the rail: linear between the places where it is given, constant beyond
/// the first and the last.
#[derive(Clone, Debug, PartialEq)]
pub struct RailFriction {
    x: Vec<f64>,
    rail_position: Vec<f64>,
    coefficient: Vec<f64>,
}

/// Two places next to another one, and their weights.
type Weights = [(usize, f64); 2];

impl RailFriction {
    /// `x` (m): along the track [m], one place for friction that does not vary along it; `rail_position` (n): y of
    /// the rail profile [m], the same of the right rail seen in a mirror; `coefficient` (m * n), that of the first
    /// x first.
    ///
    /// # Errors
    /// No places, places that do not rise, a coefficient below 0 or above 1e30, another number of them.
    pub fn new(x: Vec<f64>, rail_position: Vec<f64>, coefficient: Vec<f64>) -> Result<Self, Error> {
        for (name, places) in [("x", &x), ("rail position", &rail_position)] {
            check_entries(name, places)?;
            if places.is_empty() || places.windows(2).any(|pair| pair[1] <= pair[0]) {
                return Err(Error::FrictionPlaces { name });
            }
        }
        if Some(coefficient.len()) != x.len().checked_mul(rail_position.len()) {
            return Err(Error::FrictionSize {
                count: coefficient.len(),
                wanted: [x.len(), rail_position.len()],
            });
        }
        check_entries("coefficient", &coefficient)?;
        if let Some(&value) = coefficient.iter().find(|value| **value < 0.0) {
            return Err(Error::Number {
                name: "coefficient",
                value,
                wanted: "a coefficient of friction must not be negative",
            });
        }
        Ok(Self {
            x,
            rail_position,
            coefficient,
        })
    }

    /// Places along the track [m], places across the rail [m], and the coefficients.
    pub fn parts(&self) -> [&[f64]; 3] {
        [&self.x, &self.rail_position, &self.coefficient]
    }

    /// The coefficient [-] at `x` in the track and at `rail_position` [m].
    pub fn coefficient(&self, x: f64, rail_position: f64) -> f64 {
        let (along, across) = self.weights(x, rail_position);
        self.sum(along, across)
    }

    /// Its rates along the track and across the rail [1/m].
    pub(crate) fn slopes(&self, x: f64, rail_position: f64) -> [f64; 2] {
        let (along, across) = self.weights(x, rail_position);
        [
            self.sum(rates(&self.x, x), across),
            self.sum(along, rates(&self.rail_position, rail_position)),
        ]
    }

    /// Share [-] of the coefficient with an index in that at a place.
    pub(crate) fn share(&self, x: f64, rail_position: f64, index: usize) -> f64 {
        let (along, across) = self.weights(x, rail_position);
        let width = self.rail_position.len();
        let of = |weights: Weights, k: usize| -> f64 {
            weights
                .iter()
                .filter(|(i, _)| *i == k)
                .map(|(_, w)| w)
                .sum()
        };
        of(along, index / width) * of(across, index % width)
    }

    fn weights(&self, x: f64, rail_position: f64) -> (Weights, Weights) {
        (
            between(&self.x, x),
            between(&self.rail_position, rail_position),
        )
    }

    fn sum(&self, along: Weights, across: Weights) -> f64 {
        let width = self.rail_position.len();
        along
            .iter()
            .flat_map(|(i, a)| across.iter().map(move |(j, b)| (i * width + j, a * b)))
            .map(|(k, weight)| weight * self.coefficient[k])
            .sum()
    }
}

/// Rates of the weights of [`between`], in their order [1/m]; 0 beyond the first and the last place.
fn rates(places: &[f64], at: f64) -> Weights {
    let [(first, _), (second, _)] = between(places, at);
    if first >= second {
        return [(first, 0.0); 2];
    }
    let rate = 1.0 / (places[second] - places[first]);
    [(first, -rate), (second, rate)]
}

/// The places next to `at` and their weights.
fn between(places: &[f64], at: f64) -> Weights {
    let above = places.partition_point(|place| *place <= at);
    if above == 0 || above == places.len() {
        let end = above.saturating_sub(1);
        return [(end, 1.0), (end, 0.0)];
    }
    let share = (at - places[above - 1]) / (places[above] - places[above - 1]);
    [(above - 1, 1.0 - share), (above, share)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_is_linear_between_its_places_and_constant_beyond() {
        let map = RailFriction::new(
            vec![0.0, 2.0],
            vec![-1.0, 0.0, 4.0],
            vec![0.1, 0.2, 0.4, 0.3, 0.2, 0.0],
        )
        .unwrap();
        for (x, y, wanted) in [
            (0.0, -1.0, 0.1),
            (2.0, 4.0, 0.0),
            (0.0, 1.0, 0.25),
            (1.0, 0.0, 0.2),
            (0.5, -0.5, 0.75 * 0.15 + 0.25 * 0.25),
            (-9.0, 9.0, 0.4),
            (9.0, -9.0, 0.3),
        ] {
            assert!((map.coefficient(x, y) - wanted).abs() < 1e-15, "{x} {y}");
        }
        let one = RailFriction::new(vec![0.0], vec![0.0], vec![0.3]).unwrap();
        assert!((one.coefficient(-3.0, 7.0) - 0.3).abs() < 1e-15);
    }

    #[test]
    fn what_is_no_map_is_named() {
        let message = |x: &[f64], y: &[f64], mu: &[f64]| {
            let made = RailFriction::new(x.to_vec(), y.to_vec(), mu.to_vec());
            made.unwrap_err().to_string()
        };
        assert!(message(&[], &[0.0], &[]).contains("x of a friction map"));
        assert!(message(&[0.0], &[0.0, 0.0], &[0.1, 0.1]).contains("rail position of a"));
        assert!(message(&[0.0], &[f64::NAN], &[0.1]).contains("rail position"));
        assert!(message(&[0.0], &[0.0], &[0.1, 0.2]).contains("2 coefficients"));
        assert!(message(&[0.0], &[0.0], &[-0.1]).contains("coefficient"));
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two bodies that pass through their contact at the same speed.
//!
//! At each place both have had the same time for what they took up, so that friction's heat is shared in the ratio
//! of the effusivities wherever the surfaces have the same temperature. Where the bodies come with different
//! temperatures, an exchange adds to it: from the first touch at a distance s0 along the path it is
//! `c / sqrt(s - s0)` with a constant c in one stretch of contact, and this is the shape of it in each cell.

use std::f64::consts::PI;

use rayon::prelude::*;

use crate::Conductor;
use crate::error::{Error, check, positive};
use crate::trail::{Crossed, trail};

/// A contact on a grid through which two bodies pass.
#[derive(Clone, Copy, Debug)]
pub struct Passage<'a> {
    /// Cells along x and y.
    pub shape: [usize; 2],
    /// Sizes of a cell along x and y [m].
    pub spacing: [f64; 2],
    /// Direction in which the contact moves over the bodies, from +x towards +y [rad].
    pub angle: f64,
    /// Speed of both bodies through the contact [m/s].
    pub speed: f64,
    /// Heat of friction (n) [W/m2].
    pub power: &'a [f64],
    /// Where the surfaces touch (n).
    pub touches: &'a [bool],
    /// Lower and upper body.
    pub bodies: [Conductor; 2],
    /// Temperatures with which they come [K].
    pub bulk: [f64; 2],
}

/// Of the lower and the upper body, at the centres of the cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Temperatures {
    /// Surface temperature (n) [K].
    pub surface: [Vec<f64>; 2],
    /// Heat that enters (n) [W/m2]; the sum of both is the power.
    pub flux: [Vec<f64>; 2],
}

/// A part of the path of a particle through one cell, `from` upstream `to` downstream [m].
#[derive(Clone, Copy)]
struct Stretch {
    from: f64,
    to: f64,
    power: f64,
    touches: bool,
}

impl Stretch {
    fn middle(&self) -> f64 {
        0.5 * (self.from + self.to)
    }
}

/// Of the exchange in one stretch of a path: `strength / sqrt(s - entry)`.
struct Exchange {
    from: f64,
    to: f64,
    entry: f64,
    strength: f64,
}

impl Exchange {
    /// What a unit of strength does at `s`, downstream of its beginning: the integral of
    /// `1 / sqrt((t - entry) (s - t))` over t.
    fn weight(&self, s: f64) -> f64 {
        let angle = |t: f64| {
            ((t - self.entry) / (s - self.entry))
                .clamp(0.0, 1.0)
                .sqrt()
                .asin()
        };
        2.0 * (angle(self.to.min(s)) - angle(self.from))
    }

    fn at(&self, s: f64) -> f64 {
        self.strength / (s - self.entry).sqrt()
    }
}

impl Passage<'_> {
    fn check(&self) -> Result<(), Error> {
        let n = self.shape[0] * self.shape[1];
        check("power", self.power, n)?;
        check("bulk", &self.bulk, 2)?;
        if self.touches.len() != n {
            return Err(Error::Shape {
                name: "touches",
                found: self.touches.len(),
                expected: n,
            });
        }
        positive("spacing[0]", self.spacing[0])?;
        positive("spacing[1]", self.spacing[1])?;
        positive("speed", self.speed)?;
        check("angle", &[self.angle], 1)
    }

    /// The path of the particle that is now at the centre of `cell`, from where it came onto the grid.
    fn path(&self, trail: &[Crossed], cell: [usize; 2]) -> Vec<Stretch> {
        let there = trail.iter().map_while(|crossed| {
            let k = crossed.seen_from(cell, self.shape)?;
            Some((crossed, k))
        });
        let mut path: Vec<Stretch> = there
            // across a corner of cells goes a stretch without a length
            .filter(|(crossed, _)| crossed.far > crossed.near)
            .map(|(crossed, k)| Stretch {
                from: -crossed.far,
                // all of its own cell, of which the centre is the middle
                to: if crossed.away == [0; 2] {
                    crossed.far
                } else {
                    -crossed.near
                },
                power: self.power[k],
                touches: self.touches[k],
            })
            .collect();
        path.reverse();
        path
    }

    /// Lines of cells along which particles move from cell to cell, upstream first, if the direction is along them.
    fn lines(&self) -> Option<Vec<Vec<[usize; 2]>>> {
        let (sin, cos) = self.angle.sin_cos();
        let axis = match (cos.abs() < 1e-12, sin.abs() < 1e-12) {
            (false, true) => 0,
            (true, false) => 1,
            _ => return None,
        };
        let is_reversed = [cos, sin][axis] > 0.0;
        let line = |across: usize| {
            let mut cells: Vec<[usize; 2]> = (0..self.shape[axis])
                .map(|k| if axis == 0 { [k, across] } else { [across, k] })
                .collect();
            if is_reversed {
                cells.reverse();
            }
            cells
        };
        Some((0..self.shape[1 - axis]).map(line).collect())
    }

    /// Exchange between the bodies along a path, for a difference of one kelvin between lower and upper body and a
    /// sum of the inverse effusivities of one.
    fn exchange(path: &[Stretch], root: f64) -> Vec<Exchange> {
        let mut found: Vec<Exchange> = Vec::new();
        let mut entry = None;
        for stretch in path {
            if !stretch.touches {
                entry = None;
                continue;
            }
            let entry = *entry.get_or_insert(stretch.from);
            let mut own = Exchange {
                from: stretch.from,
                to: stretch.to,
                entry,
                strength: 0.0,
            };
            // heat flows until both surfaces have one temperature in the middle of the stretch
            let middle = stretch.middle();
            let before: f64 = found.iter().map(|e| e.strength * e.weight(middle)).sum();
            own.strength = (1.0 - root * before) / (root * own.weight(middle));
            found.push(own);
        }
        found
    }
}

/// Surface temperatures of two bodies in rolling contact.
///
/// Heat flows into the depth alone, which takes a speed with `V a / (2 kappa)` far above one for a contact of
/// half-length a. Each cell has a constant power; for it the temperatures at the centres are exact.
/// Two bodies of different bulk temperature have exactly their common temperature in contact; where a particle
/// comes into contact a second time, the heat that they exchange there is exact to the order of the cells.
///
/// # Errors
/// [`Error::Shape`], [`Error::NotFinite`], [`Error::NotPositive`].
pub fn rolling(passage: &Passage<'_>) -> Result<Temperatures, Error> {
    passage.check()?;
    let [nx, ny] = passage.shape;
    let beta = passage.bodies.map(|b| b.effusivity());
    let share = beta.map(|b| b / (beta[0] + beta[1]));
    // of the temperature, over the effusivity and the integral of flux over the root of the distance
    let root = 1.0 / (PI * passage.speed).sqrt();
    let difference = passage.bulk[0] - passage.bulk[1];
    let inverse = 1.0 / beta[0] + 1.0 / beta[1];
    let at = |path: &[Stretch], exchange: &[Exchange], s: f64| {
        let own = path.partition_point(|stretch| stretch.from < s);
        let heated: f64 = path[..own]
            .iter()
            .filter(|stretch| stretch.power != 0.0)
            .map(|stretch| {
                let end = (s - stretch.to).max(0.0);
                2.0 * stretch.power * ((s - stretch.from).sqrt() - end.sqrt())
            })
            .sum();
        let until = exchange.partition_point(|e| e.from < s);
        let exchanged: f64 = exchange[..until]
            .iter()
            .map(|e| e.strength * e.weight(s))
            .sum();
        let now = exchange[..until]
            .last()
            .filter(|e| s <= e.to)
            .map_or(0.0, |e| e.at(s));
        let power = path[..own].last().map_or(0.0, |stretch| stretch.power);
        // the warmer body gives, the colder one takes
        let (given, flows) = (difference / inverse * exchanged, difference / inverse * now);
        let rise = |k: usize, sign: f64| {
            passage.bulk[k] + root * (share[k] * heated + sign * given) / beta[k]
        };
        let flux = |k: usize, sign: f64| share[k] * power + sign * flows;
        [rise(0, -1.0), rise(1, 1.0), flux(0, -1.0), flux(1, 1.0)]
    };
    let exchanged = |path: &[Stretch]| {
        if difference == 0.0 {
            Vec::new()
        } else {
            Passage::exchange(path, root)
        }
    };
    let trail = trail(passage.shape, passage.spacing, passage.angle);
    let mut found = vec![[0.0; 4]; nx * ny];
    if let Some(lines) = passage.lines() {
        let solved: Vec<Vec<[f64; 4]>> = lines
            .par_iter()
            .map(|line| {
                let Some(last) = line.last() else {
                    return Vec::new();
                };
                // the path of the last particle goes through all the others
                let path = passage.path(&trail, *last);
                let exchange = exchanged(&path);
                path.iter()
                    .map(|stretch| at(&path, &exchange, stretch.middle()))
                    .collect()
            })
            .collect();
        for (line, values) in lines.iter().zip(solved) {
            for (cell, value) in line.iter().zip(values) {
                found[cell[1] * nx + cell[0]] = value;
            }
        }
    } else {
        found = (0..nx * ny)
            .into_par_iter()
            .map(|k| {
                let path = passage.path(&trail, [k % nx, k / nx]);
                at(&path, &exchanged(&path), 0.0)
            })
            .collect();
    }
    let part = |k: usize| found.iter().map(|values| values[k]).collect();
    Ok(Temperatures {
        surface: [part(0), part(1)],
        flux: [part(2), part(3)],
    })
}

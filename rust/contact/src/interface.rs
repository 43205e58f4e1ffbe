// SPDX-License-Identifier: MIT OR Apache-2.0
//! What lies between the bodies beyond springs: a hardness that bounds the pressure, a layer that bounds the friction,
//! a rough layer that gives way by a law.

use std::collections::HashSet;

use crate::columns::largest;
use crate::error::{Error, check, check_number};
use crate::sliding::{RigidMotion, SlidingContact};

/// Part of the largest opening by which openings may miss the law in a solution.
pub(crate) const SETTLED: f64 = 1e-10;
/// Linearisations after which the law must be met.
pub(crate) const ROUNDS: usize = 60;
/// Part by which a pressure may be beyond the end of a law: rounding.
const BEYOND: f64 = 1e-9;
/// Part by which the friction of a point must be beyond the shear limit to change sides: rounding.
const EDGE: f64 = 1e-12;

/// Hardness, shear limit and rough layer between two bodies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Interface {
    /// Largest pressure that each point bears (n) [Pa]; where it is reached, one body flows, and the gap that the
    /// surfaces would have is below zero by the depth to which it has flowed.
    pub limit: Option<Vec<f64>>,
    /// Largest friction that a layer transmits at each point (n) [Pa]: of points that slide, the friction is that of
    /// Coulomb or this, whichever is less.
    pub shear: Option<Vec<f64>>,
    /// Law of a rough layer.
    pub rough: Option<RoughLaw>,
}

/// How far a rough layer opens the gap under a pressure, counted from the first touch of its tips: piecewise linear in
/// `s = ln(1 + p / floor)`, which one piece makes the exponential law `p = floor (exp(u / length) - 1)`.
#[derive(Clone, Debug, PartialEq)]
pub struct RoughLaw {
    floor: f64,
    /// `s` at the nodes, the first one 0.
    level: Vec<f64>,
    /// Opening there [m], the first one 0.
    opening: Vec<f64>,
    /// Largest pressure that the law knows [Pa]; infinite where it goes on.
    last: f64,
}

impl RoughLaw {
    /// The exponential law with the pressure `floor` [Pa], by which a gap opens by `length` [m] for each factor e of
    /// a pressure far above it.
    ///
    /// # Errors
    /// Numbers that are not positive.
    pub fn exponential(length: f64, floor: f64) -> Result<Self, Error> {
        const POSITIVE: &str = "a positive number is needed";
        check_number("length", length, length > 0.0, POSITIVE)?;
        check_number("floor", floor, floor > 0.0, POSITIVE)?;
        Ok(Self {
            floor,
            level: vec![0.0, 1.0],
            opening: vec![0.0, length],
            last: f64::INFINITY,
        })
    }

    /// The law through openings [m] and pressures [Pa] that both rise from zero.
    ///
    /// # Errors
    /// Fewer than two of them, numbers that are not finite, that do not begin at zero or do not rise.
    pub fn table(opening: Vec<f64>, pressure: &[f64]) -> Result<Self, Error> {
        check("pressure", pressure, opening.len().max(2))?;
        check("opening", &opening, pressure.len())?;
        for (name, values) in [("opening", opening.as_slice()), ("pressure", pressure)] {
            if values[0] != 0.0 {
                return Err(Error::NotRising {
                    name,
                    index: 0,
                    value: values[0],
                });
            }
            if let Some(index) = (1..values.len()).find(|&i| values[i] <= values[i - 1]) {
                return Err(Error::NotRising {
                    name,
                    index,
                    value: values[index],
                });
            }
        }
        let floor = pressure[1];
        Ok(Self {
            floor,
            level: pressure.iter().map(|p| (p / floor).ln_1p()).collect(),
            opening,
            last: pressure[pressure.len() - 1],
        })
    }

    /// Its floor [Pa], nodes in `s` and openings there [m], and largest pressure [Pa].
    pub(crate) fn parts(&self) -> (f64, &[f64], &[f64], f64) {
        (self.floor, &self.level, &self.opening, self.last)
    }

    /// The law of such parts.
    pub(crate) fn of_parts(
        floor: f64,
        level: Vec<f64>,
        opening: Vec<f64>,
        last: f64,
    ) -> Result<Self, Error> {
        check("floor", &[floor], 1)?;
        check("level", &level, opening.len().max(2))?;
        check("opening", &opening, level.len())?;
        Ok(Self {
            floor,
            level,
            opening,
            last,
        })
    }

    /// The piece in which one of `nodes` is reached.
    fn piece(nodes: &[f64], at: f64) -> usize {
        nodes
            .partition_point(|v| *v <= at)
            .clamp(1, nodes.len() - 1)
            - 1
    }

    fn rate(&self, piece: usize) -> f64 {
        (self.opening[piece + 1] - self.opening[piece])
            / (self.level[piece + 1] - self.level[piece])
    }

    /// Opening [m] under a pressure [Pa].
    pub fn opening(&self, pressure: f64) -> f64 {
        let s = (pressure.max(0.0) / self.floor).ln_1p();
        let k = Self::piece(&self.level, s);
        self.opening[k] + self.rate(k) * (s - self.level[k])
    }

    /// Its derivative by the pressure [m/Pa].
    pub fn slope(&self, pressure: f64) -> f64 {
        let p = pressure.max(0.0);
        let k = Self::piece(&self.level, (p / self.floor).ln_1p());
        self.rate(k) / (p + self.floor)
    }

    /// Pressure [Pa] under which it opens so far [m].
    pub fn pressure(&self, opening: f64) -> f64 {
        let k = Self::piece(&self.opening, opening);
        let s = self.level[k] + (opening - self.opening[k]) / self.rate(k);
        self.floor * s.max(0.0).exp_m1()
    }

    /// The pressure [Pa] from which on it is as stiff as `compliance` [m/Pa].
    fn stiff_from(&self, compliance: f64) -> f64 {
        for piece in 0..self.level.len() - 1 {
            let here = self.rate(piece) / compliance - self.floor;
            let end = self.floor * self.level[piece + 1].exp_m1();
            if here <= end {
                return here.max(self.floor * self.level[piece].exp_m1());
            }
        }
        self.rate(self.level.len() - 2) / compliance - self.floor
    }
}

impl Interface {
    /// Whether it does nothing.
    pub fn is_empty(&self) -> bool {
        self.limit.is_none() && self.shear.is_none() && self.rough.is_none()
    }

    /// Checks it for `n` points.
    ///
    /// # Errors
    /// A limit of the wrong length, that is not finite or not positive.
    pub fn check(&self, n: usize) -> Result<(), Error> {
        let limits = [("hardness", &self.limit), ("yield stress", &self.shear)];
        for (name, limit) in limits {
            let Some(limit) = limit else { continue };
            check(name, limit, n)?;
            if let Some(index) = limit.iter().position(|v| *v <= 0.0) {
                return Err(Error::NotPositive {
                    name,
                    index,
                    value: limit[index],
                });
            }
        }
        Ok(())
    }

    /// Friction over pressure (n) of points that slide: the coefficients (n), or less where the layer yields.
    pub(crate) fn coefficients(&self, friction: Vec<f64>, pressure: &[f64]) -> Vec<f64> {
        let Some(shear) = &self.shear else {
            return friction;
        };
        let points = friction.iter().zip(pressure).zip(shear);
        points
            .map(|((mu, p), most)| if mu * p > *most { most / p } else { *mu })
            .collect()
    }

    /// The points (n) whose layer yields at the friction that it transmits, and the derivative of friction by the pressure
    /// (n), which is `slope` elsewhere; no points where there is no such layer.
    pub(crate) fn yields(
        &self,
        friction: &[f64],
        pressure: &[f64],
        slope: &[f64],
    ) -> (Vec<bool>, Vec<f64>) {
        let Some(shear) = &self.shear else {
            return (Vec::new(), slope.to_vec());
        };
        let points = friction.iter().zip(pressure).zip(shear);
        let yields: Vec<bool> = points
            .map(|((mu, p), most)| mu * p >= most * (1.0 - BEYOND))
            .collect();
        let slope = slope.iter().zip(&yields);
        let slope = slope.map(|(slope, yields)| if *yields { 0.0 } else { *slope });
        let slope = slope.collect();
        (yields, slope)
    }

    /// A diagonal compliance (n) [m/Pa], if there is one, and the slope of the rough layer under pressures (n).
    pub fn softened(&self, diagonal: Option<&[f64]>, pressure: &[f64]) -> Option<Vec<f64>> {
        let Some(law) = &self.rough else {
            return diagonal.map(<[f64]>::to_vec);
        };
        let own = |i: usize| diagonal.map_or(0.0, |d| d[i]);
        let slopes = pressure
            .iter()
            .enumerate()
            .map(|(i, p)| own(i) + law.slope(*p));
        Some(slopes.collect())
    }
}

/// Newton's method for a contact whose layer gives way by a law: solves of the contact with the law linearised, each
/// at a pressure that the last one leads to.
///
/// The next pressure follows from the opening where the layer is softer than the bodies, and from the pressure where
/// it is stiffer, as circuits with diodes are solved: an exponential would run away otherwise.
pub(crate) struct Linearisation<'a> {
    law: &'a RoughLaw,
    stiff_from: Vec<f64>,
    at: Vec<f64>,
    next: Vec<f64>,
    /// Part of the largest opening by which the law was missed at least.
    least: f64,
}

impl<'a> Linearisation<'a> {
    /// About the pressures `at` (n), or where all of these are zero about those of the closed gaps (n) [m]; `own`:
    /// compliance of the bodies at a point to the pressure there [m/Pa].
    pub(crate) fn new(
        law: &'a RoughLaw,
        gap: &[f64],
        own: impl Fn(usize) -> f64,
        at: Option<Vec<f64>>,
    ) -> Self {
        let stiff_from: Vec<f64> = (0..gap.len())
            .map(|i| law.stiff_from(own(i).abs()).max(0.0))
            .collect();
        let at = at
            .filter(|at| at.iter().any(|p| *p > 0.0))
            .unwrap_or_else(|| {
                let closed = gap.iter().zip(&stiff_from);
                closed
                    .map(|(g, most)| law.pressure(-g).min(*most))
                    .collect()
            });
        Self {
            law,
            stiff_from,
            next: at.clone(),
            at,
            least: f64::INFINITY,
        }
    }

    /// The gap (n) [m] and the diagonal (n) [m/Pa] of the contact with the linearised law.
    pub(crate) fn linear(&self, gap: &[f64], diagonal: Option<&[f64]>) -> (Vec<f64>, Vec<f64>) {
        let parts = gap.iter().zip(&self.at);
        let gap = parts.map(|(g, p)| g + self.law.opening(*p) - self.law.slope(*p) * p);
        let own = |i: usize| diagonal.map_or(0.0, |d| d[i]);
        let diagonal = self
            .at
            .iter()
            .enumerate()
            .map(|(i, p)| own(i) + self.law.slope(*p));
        (gap.collect(), diagonal.collect())
    }

    /// Turns to the pressures (n) that were found, and puts the gaps (n) [m] of open points where the law has them; the
    /// part of the largest opening by which the law is missed.
    ///
    /// An open point is free of the opening about which the law was linearised, as far as its gap is wider than that.
    /// Where the law was missed by less before, it turns half of the way.
    pub(crate) fn turn(&mut self, pressure: &[f64], gap: &mut [f64]) -> f64 {
        let law = self.law;
        let (mut most, mut missed) = (0.0_f64, 0.0_f64);
        let points = self.at.iter().zip(&mut self.next).zip(pressure).zip(gap);
        for ((((at, next), p), gap), stiff) in points.zip(&self.stiff_from) {
            let p = p.max(0.0);
            let mut opened = law.opening(*at) + law.slope(*at) * (p - *at);
            if p == 0.0 {
                let free = gap.clamp(0.0, opened.max(0.0));
                *gap -= opened;
                opened -= free;
            }
            let opening = law.opening(p);
            most = most.max(opening);
            missed = missed.max((opening - opened).abs());
            *next = if p < *at {
                law.pressure(opened)
            } else {
                p.max(law.pressure(opened).min(*stiff))
            };
        }
        let missed = if missed > 0.0 { missed / most } else { 0.0 };
        if missed < self.least {
            self.least = missed;
            std::mem::swap(&mut self.at, &mut self.next);
        } else {
            // half of the way, where the whole one does not help
            for (at, next) in self.at.iter_mut().zip(&self.next) {
                *at = law.pressure(0.5 * (law.opening(*at) + law.opening(*next)));
            }
        }
        missed
    }

    /// Checks the pressures (n) that meet the law.
    ///
    /// # Errors
    /// [`Error::BeyondLaw`] where they meet it beyond its end.
    pub(crate) fn check_end(&self, pressure: &[f64]) -> Result<(), Error> {
        let peak = pressure.iter().copied().fold(0.0, f64::max);
        if peak > self.law.last * (1.0 + BEYOND) {
            return Err(Error::BeyondLaw {
                pressure: peak,
                largest: self.law.last,
            });
        }
        Ok(())
    }
}

/// The points of a sliding contact whose layer yields: there the friction is given, and no more follows the pressure.
///
/// They are one more set of active points, beside those that touch and those that flow: of each round the contact is
/// solved with this set held, and what has gone beyond the limit joins it, until it stays as it is.
///
/// A guess of the set may have no solution where the contact has one: friction at its limit under pressures that are
/// none, or friction without its limit. Then all friction follows the pressure, with coefficients that give no more
/// than the limit at the last pressures, from none on, until these tell the set.
pub(crate) struct Yielding<'a> {
    shear: &'a [f64],
    friction: &'a [f64],
    yields: Vec<bool>,
    visited: HashSet<Vec<bool>>,
    softened: Option<Softened>,
    retreats: usize,
}

/// Coefficients of a friction that follows the pressure at all points, and the last ones that had a solution.
struct Softened {
    now: Vec<f64>,
    solved: Vec<f64>,
}

/// Part of the largest coefficient by which they may change at the end, in the first and in the second retreat.
const TOLD: [f64; 2] = [1e-2, 1e-6];
/// Part of the largest coefficient that is no step any more.
const SHORTEST: f64 = 1e-3;

impl<'a> Yielding<'a> {
    /// From pressures (n) [Pa] at which the set is guessed; `None`: nothing yields yet.
    pub(crate) fn new(shear: &'a [f64], friction: &'a [f64], at: Option<&[f64]>) -> Self {
        let over = |at: &[f64]| {
            (0..shear.len())
                .map(|i| friction[i] * at[i] > shear[i])
                .collect()
        };
        Self {
            shear,
            friction,
            yields: at.map_or_else(|| vec![false; shear.len()], over),
            visited: HashSet::new(),
            softened: None,
            retreats: 0,
        }
    }

    /// After a round without a solution: whether there is another one to try.
    pub(crate) fn retreat(&mut self) -> bool {
        let Some(softened) = &mut self.softened else {
            self.retreats += 1;
            self.softened = Some(Softened {
                now: vec![0.0; self.friction.len()],
                solved: vec![0.0; self.friction.len()],
            });
            return self.retreats <= TOLD.len();
        };
        let shortest = SHORTEST * largest(self.friction);
        let mut is_far = false;
        for (now, solved) in softened.now.iter_mut().zip(&softened.solved) {
            is_far |= (*now - solved).abs() > shortest;
            *now = 0.5 * (*now + solved);
        }
        is_far
    }

    /// Coefficients (n) of the friction that follows the pressure.
    pub(crate) fn coefficients(&self) -> Vec<f64> {
        if let Some(softened) = &self.softened {
            return softened.now.clone();
        }
        let points = self.friction.iter().zip(&self.yields);
        points
            .map(|(mu, yields)| if *yields { 0.0 } else { *mu })
            .collect()
    }

    /// Friction (n) [Pa] that does not.
    pub(crate) fn given(&self) -> Vec<f64> {
        if self.softened.is_some() {
            return vec![0.0; self.shear.len()];
        }
        let points = self.shear.iter().zip(&self.yields);
        points
            .map(|(most, yields)| if *yields { *most } else { 0.0 })
            .collect()
    }

    /// The motions under the work of the friction that is given, in `direction` (2n).
    pub(crate) fn motions(&self, contact: &SlidingContact<'_>) -> Vec<RigidMotion> {
        let (n, given) = (self.shear.len(), self.given());
        let motions = contact.motions.iter().map(|motion| {
            let work: f64 = (0..n)
                .map(|i| {
                    let along = contact.direction[i] * motion.tangential_x[i]
                        + contact.direction[n + i] * motion.tangential_y[i];
                    contact.area[i] * given[i] * along
                })
                .sum();
            RigidMotion {
                work: motion.work + work,
                ..motion.clone()
            }
        });
        motions.collect()
    }

    /// Turns to the set at the pressures (n) that were found; whether it stays as it is.
    ///
    /// A set that comes again changes by its last point alone.
    pub(crate) fn turn(&mut self, pressure: &[f64]) -> bool {
        if let Some(softened) = &mut self.softened {
            let mut moved = 0.0_f64;
            for i in 0..pressure.len() {
                let most = self.friction[i];
                let next = if most * pressure[i] > self.shear[i] {
                    self.shear[i] / pressure[i]
                } else {
                    most
                };
                moved = moved.max((next - softened.now[i]).abs());
                softened.solved[i] = std::mem::replace(&mut softened.now[i], next);
            }
            if moved <= TOLD[self.retreats - 1] * largest(self.friction) {
                *self = Self {
                    retreats: self.retreats,
                    ..Self::new(self.shear, self.friction, Some(pressure))
                };
            }
            return false;
        }
        let next: Vec<bool> = (0..pressure.len())
            .map(|i| {
                // rounding does not move a point that is at the border
                let margin = if self.yields[i] {
                    1.0 - EDGE
                } else {
                    1.0 + EDGE
                };
                self.friction[i] * pressure[i] > self.shear[i] * margin
            })
            .collect();
        if next == self.yields {
            return true;
        }
        if self.visited.insert(next.clone()) {
            self.yields = next;
        } else if let Some(last) = (0..next.len()).rev().find(|&i| next[i] != self.yields[i]) {
            self.yields[last] = next[last];
        }
        false
    }
}

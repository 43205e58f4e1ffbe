// SPDX-License-Identifier: MIT OR Apache-2.0
//! States of the past from which steps start that the last one tells little about.

use std::collections::VecDeque;

use mtb_operator::krylov::dot;

use super::Point;
use crate::columns::largest;
use crate::sliding::{RigidMotion, SlidingContact};

/// States that are kept; a step of random jumps takes 7.5 active sets from the last one, 3.2 from the nearest of 16 and
/// 2.2 from that of 64.
const MOST: usize = 64;
/// Active sets of a step whose state is worth keeping: none that is there was near.
const FAR: usize = 3;
/// Part of the distance to the last state at which another one is the better start.
const NEARER: f64 = 0.5;

/// Points of a shape that are compared at once.
const AT_ONCE: usize = 64;

/// States of steps with the same motions, told apart by gap and loads.
///
/// What free motions can undo is no difference, and neither is a common factor on gap and loads, by which the state
/// scales. The rest of the difference of gaps counts in units of what the bodies give way.
#[derive(Default)]
pub(super) struct Landmarks {
    motions: Vec<Vec<f64>>,
    /// Orthonormal openings, and the factors (upper triangle) of which they are the motions' with.
    basis: Vec<Vec<f64>>,
    factors: Vec<Vec<f64>>,
    last: Option<Landmark>,
    others: VecDeque<Landmark>,
}

#[derive(Clone)]
struct Landmark {
    /// Gap of the unloaded pair without what motions can undo (n).
    shape: Vec<f64>,
    /// Work of the loads by motions of a unit at most (m).
    loads: Vec<f64>,
    /// How far the bodies give way, motions apart.
    size: f64,
    pressure: Vec<f64>,
    /// Place of the deformed gap among the motions (m).
    place: Vec<f64>,
}

impl Landmarks {
    /// Where a step should start in place of the last one's state; `None` where that is near enough.
    pub(super) fn start(&mut self, contact: &SlidingContact<'_>) -> Option<Point> {
        self.turn_to(contact.motions);
        let last = self.last.as_ref()?;
        if self.others.is_empty() {
            return None;
        }
        let (shape, place) = self.split(contact.gap);
        let loads = loads(contact.motions);
        // a last state of other loads altogether is nearer than none
        let last = last.distance(&shape, &loads, f64::INFINITY);
        let mut most = last.map_or(f64::INFINITY, |(distance, _)| NEARER * distance);
        let mut nearest = None;
        for one in &self.others {
            if let Some((distance, factor)) = one.distance(&shape, &loads, most) {
                most = distance;
                nearest = Some((factor, one));
            }
        }
        let (factor, one) = nearest?;
        let left = one
            .place
            .iter()
            .zip(&place)
            .map(|(then, now)| factor * then - now);
        Some(Point {
            pressure: one.pressure.iter().map(|p| factor * p).collect(),
            motion: self.amplitudes(left.collect()),
            opened: None,
        })
    }

    /// Lets the next step start from the last state, wherever it is.
    pub(super) fn stay(&mut self) {
        self.last = None;
    }

    /// Remembers the state that a step of so many active sets has found.
    pub(super) fn keep(
        &mut self,
        contact: &SlidingContact<'_>,
        point: &Point,
        gap: &[f64],
        sets: usize,
    ) {
        self.turn_to(contact.motions);
        let (shape, _) = self.split(contact.gap);
        let (deformed, place) = self.split(gap);
        let moved = deformed
            .iter()
            .zip(&shape)
            .map(|(then, now)| (then - now).powi(2));
        let found = Landmark {
            size: moved.sum::<f64>().sqrt(),
            shape,
            loads: loads(contact.motions),
            pressure: point.pressure.clone(),
            place,
        };
        if sets >= FAR {
            if self.others.len() == MOST {
                self.others.pop_front();
            }
            self.others.push_back(found.clone());
        }
        self.last = Some(found);
    }

    /// Forgets the states of other motions.
    fn turn_to(&mut self, motions: &[RigidMotion]) {
        let same = motions
            .iter()
            .map(|motion| &motion.opening)
            .eq(&self.motions);
        if same {
            return;
        }
        *self = Self::default();
        for motion in motions {
            let mut rest = motion.opening.clone();
            let mut factors = Vec::new();
            for unit in &self.basis {
                let along = dot(unit, &rest);
                rest.iter_mut().zip(unit).for_each(|(r, u)| *r -= along * u);
                factors.push(along);
            }
            let norm = dot(&rest, &rest).sqrt();
            let scale = if norm > 0.0 { 1.0 / norm } else { 0.0 };
            factors.push(norm);
            self.basis.push(rest.iter().map(|r| r * scale).collect());
            self.factors.push(factors);
            self.motions.push(motion.opening.clone());
        }
    }

    /// A gap without what motions can undo, and this as a sum of the basis.
    fn split(&self, gap: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut rest = gap.to_vec();
        let mut place = Vec::new();
        for unit in &self.basis {
            let along = dot(unit, &rest);
            rest.iter_mut().zip(unit).for_each(|(r, u)| *r -= along * u);
            place.push(along);
        }
        (rest, place)
    }

    /// Amplitudes of the motions, from a sum of the basis.
    fn amplitudes(&self, mut place: Vec<f64>) -> Vec<f64> {
        for k in (0..place.len()).rev() {
            let (above, own) = self.factors[k].split_at(k);
            place[k] = if own[0] > 0.0 { place[k] / own[0] } else { 0.0 };
            let c = place[k];
            for (p, factor) in place.iter_mut().zip(above) {
                *p -= factor * c;
            }
        }
        place
    }
}

impl Landmark {
    /// How far it is from a gap and loads, and the factor on the state there that comes nearest to their own; `None`
    /// from the distance `most` on.
    fn distance(&self, shape: &[f64], loads: &[f64], most: f64) -> Option<(f64, f64)> {
        let own = dot(&self.loads, &self.loads);
        let factor = if own > 0.0 {
            dot(loads, &self.loads) / own
        } else {
            1.0
        };
        if factor <= 0.0 || self.size == 0.0 {
            return None;
        }
        let apart = |a: &[f64], b: &[f64]| -> f64 {
            let squares = a.iter().zip(b).map(|(a, b)| (a - factor * b).powi(2));
            squares.sum()
        };
        let size = dot(loads, loads).sqrt();
        let carried = if size > 0.0 {
            apart(loads, &self.loads).sqrt() / size
        } else {
            0.0
        };
        // what is far tells so early
        let most_apart = (most - carried) * factor * self.size;
        let mut sum = 0.0;
        for (a, b) in shape.chunks(AT_ONCE).zip(self.shape.chunks(AT_ONCE)) {
            if most_apart <= 0.0 || sum >= most_apart.powi(2) {
                return None;
            }
            sum += apart(a, b);
        }
        let distance = sum.sqrt() / (factor * self.size) + carried;
        (distance < most).then_some((distance, factor))
    }
}

fn loads(motions: &[RigidMotion]) -> Vec<f64> {
    let each = motions.iter().map(|motion| {
        let most = largest(&motion.opening);
        if most > 0.0 { motion.work / most } else { 0.0 }
    });
    each.collect()
}

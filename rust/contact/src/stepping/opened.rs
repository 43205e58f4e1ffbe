// SPDX-License-Identifier: MIT OR Apache-2.0
//! What pressures open, kept from one step for the next.

use mtb_operator::krylov::dot;

use super::influence::Influence;
use crate::columns::largest;

/// Differences of frictions, over the largest, that are rounding.
const ROUNDING: f64 = 1e-14;

/// Pressures and the gaps that they and their friction open, without the diagonal.
#[derive(Clone, Default)]
pub(super) struct Opened {
    /// Empty where none are known.
    pub(super) pressure: Vec<f64>,
    /// Friction coefficient times direction of sliding (2n).
    pub(super) drag: Vec<f64>,
    /// Gaps by the pressures, and by their friction; all in the first where only their sum is known.
    pub(super) normal: Vec<f64>,
    pub(super) friction: Option<Vec<f64>>,
}

impl Opened {
    /// Of all points [m].
    pub(super) fn gap(&self) -> impl Iterator<Item = f64> {
        let friction = self.friction.iter().flatten().copied();
        let rest = std::iter::repeat(0.0);
        let pairs = self.normal.iter().zip(friction.chain(rest));
        pairs.map(|(normal, friction)| normal + friction)
    }

    /// What the same pressures open under another friction; `None` where that takes a product.
    pub(super) fn under(&self, drag: &[f64]) -> Option<Self> {
        if self.drag == drag {
            return Some(self.clone());
        }
        let friction = self.friction.as_ref()?;
        let factor = dot(drag, &self.drag) / dot(&self.drag, &self.drag);
        let most = ROUNDING * largest(drag);
        let pairs = drag.iter().zip(&self.drag);
        // a friction of zero gives no number, which is in no range
        let is_multiple = pairs
            .into_iter()
            .all(|(new, old)| (new - factor * old).abs() <= most);
        is_multiple.then(|| Self {
            pressure: self.pressure.clone(),
            drag: drag.to_vec(),
            normal: self.normal.clone(),
            friction: Some(friction.iter().map(|f| factor * f).collect()),
        })
    }

    /// Where pressures go that were `before` and go on to change as they did, both under the same friction.
    pub(super) fn ahead(mut self, before: &Self) -> Option<Self> {
        let go_on = |now: &mut [f64], before: &[f64]| {
            let pairs = now.iter_mut().zip(before);
            pairs.for_each(|(now, before)| *now = 2.0 * *now - before);
        };
        go_on(&mut self.pressure, &before.pressure);
        go_on(&mut self.normal, &before.normal);
        match (&mut self.friction, &before.friction) {
            (Some(now), Some(before)) => go_on(now, before),
            (None, None) => {}
            _ => return None,
        }
        Some(self)
    }

    /// Turns to pressures of which few differ, by the columns of these.
    pub(super) fn move_to(&mut self, pressure: &[f64], influence: &Influence) {
        for (known, p) in self.pressure.iter_mut().zip(pressure) {
            *known = p - *known;
        }
        influence.add_pressed(&self.pressure, &mut self.normal);
        let gap = self.friction.as_mut().unwrap_or(&mut self.normal);
        influence.add_friction(&self.drag, &self.pressure, gap);
        self.pressure.copy_from_slice(pressure);
    }
}

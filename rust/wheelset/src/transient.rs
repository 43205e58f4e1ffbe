// SPDX-License-Identifier: MIT OR Apache-2.0
//! Derivatives of a transient step by how far it rolls.
//!
//! What a patch has taken over stays in its cells. The step of the particles follows pose, velocity and duration, and
//! with it the places where the earlier tractions act. The operators are derived by it by differences.

use std::sync::OnceLock;

use mtb_contact::tangential::{
    Bodies, Earlier, Motion, PatchOperators, TangentialChange, TangentialTangent,
};

use crate::error::Error;
use crate::linear::RollingLinear;
use crate::memory::Gathered;
use crate::prepared::Ready;
use crate::rows::Incline;

/// Small changes of a step, in cells ...
const SMALL: f64 = 1e-3;
/// ... and the most of the way to where it ends on a border of a cell, or on the middle of one: there the slope of the
/// influence is that of a logarithm, or what is carried along has a kink. Nearer than so many cells it ends on it.
const OF_WAY: f64 = 1e-2;
const ON_IT: f64 = 1e-6;
/// One-sided differences of fourth order.
const AHEAD: [f64; 5] = [-25.0 / 12.0, 4.0, -3.0, 4.0 / 3.0, -0.25];

/// How a patch has rolled in a transient step.
pub(crate) struct TransientLinear {
    /// The time [s].
    pub(crate) duration: f64,
    /// How far it has rolled over the particles, along x and across [m].
    pub(crate) step: [f64; 2],
    /// Images [m] of a unit of slip.
    pub(crate) length: f64,
    /// Rolling speed [m/s], with its sign.
    pub(crate) rolling: f64,
    /// Heat of sliding [W].
    pub(crate) friction_power: f64,
    /// What the first part of a way has taken over.
    pub(crate) before: Option<Brought>,
    rolls_on: bool,
    by_step: OnceLock<[ByStep; 2]>,
}

/// What a patch has taken over, on the cells of its operators.
pub(crate) struct Brought {
    pub(crate) earlier: Earlier,
    /// Share of the coefficients that is of particles at rest [-].
    pub(crate) resting: Vec<f64>,
    /// What it was gathered from, by cell.
    pub(crate) gathered: Gathered<usize>,
}

/// By a metre of the step along an axis, with the tractions held.
#[derive(Default)]
struct ByStep {
    /// Of the slip by displacements of the bodies (2n), here and one step behind.
    slip: Vec<f64>,
    behind: Vec<f64>,
    /// Of the coefficients that particles bring along (n), or empty.
    brought: Vec<f64>,
}

impl TransientLinear {
    pub(crate) fn new(
        duration: f64,
        motion: Motion,
        rolling: f64,
        friction_power: f64,
        before: Option<Brought>,
        rolls_on: bool,
    ) -> Self {
        let (step, length) = match motion {
            Motion::Shift => ([0.0; 2], 1.0),
            Motion::Transient { step } | Motion::Steady { step } => (step, step[0].hypot(step[1])),
        };
        Self {
            duration,
            step,
            length,
            rolling,
            friction_power,
            before,
            rolls_on,
            by_step: OnceLock::new(),
        }
    }

    /// What changes for the tractions with the `rigid` velocity of the part, with the way of the frame over the
    /// particles, `moved` [m], with the rolling speed, and with the duration.
    pub(crate) fn change(
        &self,
        rolling: &RollingLinear,
        tangent: &TangentialTangent<'_>,
        ready: &Ready,
        (rigid, by_rigid): ([f64; 3], [f64; 3]),
        (moved, by_rolling, duration): ([f64; 2], f64, f64),
        by: &mut TangentialChange,
    ) -> Result<(), Error> {
        // slips are ways over the length that the operators are made for
        let share = self.duration / self.length;
        let [along, across, spin] =
            [0, 1, 2].map(|c| share * by_rigid[c] + rigid[c] * duration / self.length);
        by.drive = [along, across];
        by.spin = spin;
        let ahead = self.duration * by_rolling + self.rolling * duration;
        let step = [moved[0] + ahead, moved[1]];
        // spin counts where it did, and behind at places that move with the step
        let turned = share * rigid[2];
        let (along, across) = by.rigid_slip_behind.split_at_mut(by.pressure.len());
        for (x, y) in along.iter_mut().zip(across) {
            *x += turned * step[1];
            // of second order, it is at faces along the way
            if !rolling.operators.is_second_order() {
                *y -= turned * step[0];
            }
        }
        if let Some(of_speed) = by.law.last_mut() {
            *of_speed = -duration / self.duration;
        }
        let longer: f64 = (0..2).map(|c| self.step[c] * step[c]).sum();
        by.length = longer / self.length.powi(2);
        if !self.rolls_on || step == [0.0; 2] {
            return Ok(());
        }
        for (by_step, along) in self.by_step(tangent, rolling, ready)?.iter().zip(step) {
            add(&mut by.rigid_slip, along, &by_step.slip);
            add(&mut by.rigid_slip_behind, along, &by_step.behind);
            add(&mut by.brought, along, &by_step.brought);
        }
        Ok(())
    }

    /// What a metre of the step along x and across changes, found once.
    fn by_step(
        &self,
        tangent: &TangentialTangent<'_>,
        rolling: &RollingLinear,
        ready: &Ready,
    ) -> Result<&[ByStep; 2], Error> {
        if let Some(known) = self.by_step.get() {
            return Ok(known);
        }
        let rolled = (&*rolling.operators, rolling.incline.as_ref());
        let along = self.along(tangent, rolled, ready, 0)?;
        // rows that follow the rail do not move across it
        let across = match rolling.incline {
            Some(_) => ByStep::default(),
            None => self.along(tangent, rolled, ready, 1)?,
        };
        Ok(self.by_step.get_or_init(|| [along, across]))
    }

    /// By a metre of the step along an axis, on the side of a longer one.
    fn along(
        &self,
        tangent: &TangentialTangent<'_>,
        (operators, incline): (&PatchOperators, Option<&Incline>),
        ready: &Ready,
        axis: usize,
    ) -> Result<ByStep, Error> {
        let wheelset = &ready.wheelset;
        let pair = &wheelset.bodies;
        let inclination = incline.map(|incline| |y| incline.at(y));
        let tangential = |cell, offset| pair.tangential(cell, offset);
        let by_pressure = |cell, offset| pair.by_pressure(cell, offset);
        let bodies = Bodies {
            tangential: &tangential,
            by_pressure: pair.is_coupled().then_some(&by_pressure),
            layer: wheelset.layer,
            is_mirrored: true,
            inclination: inclination.as_ref().map(|at| at as _),
            across: None,
        };
        let cell = wheelset.spacing[axis];
        let half_cells = 2.0 * self.step[axis] / cell;
        let away = 0.5 * (half_cells - half_cells.round()).abs();
        let mut small = SMALL * cell;
        if away > ON_IT {
            small = small.min(OF_WAY * away * cell);
        }
        let small = small.copysign(self.step[axis]);
        let mut all = ByStep {
            slip: Vec::new(),
            behind: Vec::new(),
            brought: Vec::new(),
        };
        for (k, weight) in AHEAD.iter().enumerate() {
            let mut step = self.step;
            step[axis] += k as f64 * small;
            let (made, length);
            let moved = if k == 0 {
                length = self.length;
                operators
            } else {
                made = operators.rolling_by(&bodies, step)?;
                length = step[0].hypot(step[1]);
                &made
            };
            let share = weight / small;
            add(&mut all.slip, share, &tangent.slip_by_bodies(moved));
            // that is relative to its own step
            let behind = tangent.slip_behind_by_bodies(moved);
            add(&mut all.behind, share * length / self.length, &behind);
            add(&mut all.brought, share, &tangent.brought_by(moved));
        }
        Ok(all)
    }
}

/// Adds to a field, which is 0 where it is empty.
fn add(to: &mut Vec<f64>, share: f64, from: &[f64]) {
    to.resize(to.len().max(from.len()), 0.0);
    for (to, v) in to.iter_mut().zip(from) {
        *to += share * v;
    }
}

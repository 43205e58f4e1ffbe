// SPDX-License-Identifier: MIT OR Apache-2.0
//! The way of a step: how far a patch rolls, and its tractions part by part.
//!
//! Slip is measured over a part of the way, so that parts of many cells drift away from what parts of one cell end at,
//! steady rolling. A longer step is therefore divided. Pressure and creepages change evenly from part to part, those of
//! the step before to those of its end; a patch that knows none of before has the creepages of the end all the way.

use std::collections::HashSet;

use mtb_complementarity::discs::DiscState;
use mtb_contact::friction::Friction;
use mtb_contact::tangential::{
    Drive, Earlier, Motion, PatchOperators, SPIN_ADVANCE, Surroundings, TangentialProblem,
    dissipation, solve,
};
use mtb_operator::{Grid, Monitor};

use crate::error::Error;
use crate::linear::KinematicsChange;
use crate::memory::Before;
use crate::rolling::Kinematics;
use crate::state::Lines;
use crate::transient::{Brought, TransientLinear};
use crate::wheelset::Side;

/// Below this share of a cell a step of transient rolling is a shift.
const NO_STEP: f64 = 1e-6;
/// Below this share of a cell a patch has not moved.
const ROUNDED: f64 = 1e-9;
/// The longest part, in cells. Its count must not change while a height is looked for in steps of just one cell.
const LONGEST: f64 = 1.05;
/// The way after which rolling is steady, in lengths of the contact: of a traction that is off by the friction bound
/// everywhere, 2e-3 is left.
const SETTLED: f64 = 4.0;

/// How a patch has rolled until now.
pub(crate) enum Course {
    /// As it does now, for long.
    Steady,
    /// For so many seconds, on from an earlier state, or from rest.
    Transient {
        /// The time [s].
        duration: f64,
        /// What the patch takes over.
        before: Option<Box<Before>>,
    },
}

impl Course {
    /// The same, but steady where nothing is left of what was before. `columns`: columns of cells in contact, `dx` [m]
    /// wide.
    pub(crate) fn or_steady(self, rolling: f64, columns: usize, dx: f64) -> Self {
        match &self {
            Self::Transient { duration, before } => {
                // what was longer before has to leave it, too
                let columns = before.as_ref().map_or(columns, |b| columns.max(b.lines.nx));
                let is_settled = (rolling * duration).abs() > SETTLED * columns as f64 * dx;
                if is_settled { Self::Steady } else { self }
            }
            Self::Steady => self,
        }
    }

    /// The same, but from rest where the patch has moved so far that nothing is left of what was: across, so that no row of
    /// cells in contact was in contact before, or in a part of its way, so that no cell was. `pressure` on `lines`, cells
    /// of the size `cell` [m].
    pub(crate) fn or_from_rest(
        self,
        rolling: f64,
        lines: Lines,
        pressure: &[f64],
        cell: [f64; 2],
    ) -> Self {
        let Self::Transient { duration, before } = self else {
            return self;
        };
        let cells = |lines: Lines, pressure: &[f64]| -> HashSet<[i64; 2]> {
            let touches = (0..pressure.len()).filter(|k| pressure[*k] > 0.0);
            let [x, y] = lines.first;
            touches
                .map(|k| [x + (k % lines.nx) as i64, y + (k / lines.nx) as i64])
                .collect()
        };
        let now = cells(lines, pressure);
        let before = before.filter(|before| {
            let then = cells(before.lines, &before.earlier.pressure);
            let [along, across] = before.moved;
            let aside = (across / cell[1]).round() as i64;
            let rows: HashSet<i64> = then.iter().map(|[_, y]| *y).collect();
            let parts = parts_of(rolling * duration, cell[0]);
            let step = [along + rolling * duration, across];
            let [by_x, by_y] = [0, 1].map(|c| (step[c] / (parts * cell[c])).round() as i64);
            now.iter().any(|[_, y]| rows.contains(&(y + aside)))
                && now
                    .iter()
                    .any(|[x, y]| then.contains(&[x + by_x, y + by_y]))
        });
        Self::Transient { duration, before }
    }
}

/// How many parts a way [m] over cells of a width [m] has.
fn parts_of(way: f64, width: f64) -> f64 {
    ((way / width).abs() - LONGEST + 1.0).ceil().max(1.0)
}

/// How far a patch rolls in a part of a step.
pub(crate) struct Pace {
    pub(crate) motion: Motion,
    /// What the slip of the problem is over a creepage: 1 in steady rolling.
    pub(crate) of_creepage: f64,
    /// Slip velocity [m/s] over a slip of the problem.
    pub(crate) speed: f64,
    /// The time [s]; `None` in steady rolling.
    duration: Option<f64>,
    /// How many such parts the step has.
    parts: usize,
}

impl Pace {
    /// Of a course, with what the patch takes over.
    pub(crate) fn of(
        course: Course,
        kinematics: &Kinematics,
        [dx, dy]: [f64; 2],
    ) -> (Self, Option<Box<Before>>) {
        let Course::Transient { duration, before } = course else {
            let steady = Self {
                motion: Motion::Steady { step: [dx, 0.0] },
                of_creepage: 1.0,
                speed: kinematics.speed,
                duration: None,
                parts: 1,
            };
            return (steady, None);
        };
        let parts = parts_of(kinematics.rolling * duration, dx);
        let duration = duration / parts;
        // rounding of places is no motion, and operators of the same step are kept
        let still = |by: f64, cell: f64| if by.abs() < ROUNDED * cell { 0.0 } else { by };
        let moved = before.as_ref().map_or([0.0; 2], |before| before.moved);
        let moved = [still(moved[0] / parts, dx), still(moved[1] / parts, dy)];
        let step = [moved[0] + kinematics.rolling * duration, moved[1]];
        let length = step[0].hypot(step[1]);
        let rigid = kinematics.speed * duration;
        let (motion, of_creepage, speed) = if length > NO_STEP * dx.min(dy) {
            let motion = Motion::Transient { step };
            (motion, rigid / length, length / duration)
        } else {
            // a shift takes spin where it is
            (Motion::Shift, rigid, 1.0 / duration)
        };
        let pace = Self {
            motion,
            of_creepage,
            speed,
            duration: Some(duration),
            parts: parts as usize,
        };
        (pace, before)
    }
}

/// A part of the way of a step, solved at its end; fields on the grid of the operators.
pub(crate) struct Part {
    /// Share of the change of the pressure that has happened until then.
    pub(crate) share: f64,
    /// How far it is to the end of the step, over the rail [m].
    pub(crate) behind: f64,
    /// Creepages along x and across, as of forward rolling [-], and spin [1/m]; how much of those of the end they are.
    pub(crate) creepage: [f64; 3],
    pub(crate) creepage_share: f64,
    pub(crate) friction: Friction,
    pub(crate) transient: Option<TransientLinear>,
    pub(crate) pressure: Vec<f64>,
    pub(crate) traction: Vec<f64>,
    pub(crate) slip: Vec<f64>,
    pub(crate) coefficient: Vec<f64>,
    pub(crate) state: Vec<DiscState>,
}

impl Part {
    /// What the next part rolls on from; particles beside the contact have the coefficient of `rest`.
    pub(crate) fn as_earlier(&self, rest: f64) -> Earlier {
        let particles = self.coefficient.iter().zip(&self.pressure);
        Earlier {
            traction: self.traction.clone(),
            pressure: self.pressure.clone(),
            coefficient: particles
                .map(|(mu, p)| if *p > 0.0 { *mu } else { rest })
                .collect(),
        }
    }

    pub(crate) fn slips(&self, k: usize) -> bool {
        self.state[k] == DiscState::Rim
    }

    /// Velocity along x and across [m/s] and spin [rad/s] of a part of a transient step, and their change with the motion
    /// and with the creepages of the step before.
    pub(crate) fn rigid(
        &self,
        kinematics: &Kinematics,
        by: &KinematicsChange,
        by_last: [f64; 3],
    ) -> ([f64; 3], [f64; 3]) {
        let share = self.creepage_share;
        let by_end = [by.by_slip[0], by.by_slip[1], by.by_spin];
        let change = [0, 1, 2].map(|c| {
            // the creepages of the last step are its own, not the velocities
            let last = self.creepage[c] - share * kinematics.creepage[c];
            share * by_end[c] + last * by.speed + (1.0 - share) * by_last[c] * kinematics.speed
        });
        (self.creepage.map(|c| c * kinematics.speed), change)
    }
}

/// The loaded part of a patch, as its tractions see it.
pub(crate) struct Loaded<'a> {
    pub(crate) side: Side,
    pub(crate) operators: &'a PatchOperators,
    /// Pressure (n) [Pa] at the end.
    pub(crate) pressure: &'a [f64],
    /// On the cells (n) so far [m] behind the end.
    pub(crate) friction: &'a dyn Fn(f64) -> Friction,
    /// The coefficient of particles at rest [-].
    pub(crate) rest: f64,
    /// Centre of the first cell [m].
    pub(crate) place: [f64; 2],
    /// Along x and across, as of forward rolling, and spin [1/m]: of the end, and of the step before.
    pub(crate) creepage: [f64; 3],
    pub(crate) last_creepage: Option<[f64; 3]>,
    /// What each row of a patch that follows the rail slips besides, likewise.
    pub(crate) rows: Option<Vec<[f64; 3]>>,
    /// Rolling speed [m/s], with its sign.
    pub(crate) rolling: f64,
    pub(crate) tolerance: f64,
}

/// x of the first cell where its rigid slip is taken [m].
pub(crate) fn slip_place(origin: [f64; 2], operators: &PatchOperators) -> f64 {
    origin[0] + operators.ahead()[0]
}

/// Slip (2n) on cells from `x` [m] on, of rows that slip along and across and turn.
pub(crate) fn slip_of_rows(grid: &Grid, x: f64, rows: impl Iterator<Item = [f64; 3]>) -> Vec<f64> {
    let n = grid.points();
    let mut slip = vec![0.0; 2 * n];
    for (row, [along, across, spin]) in rows.enumerate() {
        for i in 0..grid.nx {
            let k = row * grid.nx + i;
            slip[k] = along;
            slip[n + k] = across + spin * (x + i as f64 * grid.dx);
        }
    }
    slip
}

/// The tractions of all parts of a way.
pub(crate) struct Way {
    /// In order; there is at least one.
    pub(crate) parts: Vec<Part>,
    /// Centre of the first cell [m], where spin counts.
    pub(crate) origin: [f64; 2],
    /// What rows that follow the rail slip besides (2n), in the unit of the problem.
    pub(crate) rigid_slip: Option<Vec<f64>>,
    /// Mean heat of sliding [W/m2] on the grid `around` that of the operators.
    pub(crate) heat: Vec<f64>,
    pub(crate) around: Surroundings,
    pub(crate) iterations: usize,
}

impl Loaded<'_> {
    /// Centre of the first cell [m] as the problem is told it, which takes spin ahead of it by a part of its step: here that
    /// is the part of a cell, as in steady rolling, whatever the step.
    fn origin(&self, motion: Motion, dx: f64) -> [f64; 2] {
        let [x, y] = self.place;
        match motion {
            Motion::Transient { step } if !self.operators.is_second_order() => [
                x + SPIN_ADVANCE * (dx.copysign(self.rolling) - step[0]),
                y - SPIN_ADVANCE * step[1],
            ],
            _ => [x, y],
        }
    }

    /// Solves part by part. `brought`: what the first one rolls on from; `start`: traction (2n) [Pa] to try first.
    pub(crate) fn along(
        &self,
        pace: &Pace,
        mut brought: Option<Brought>,
        start: Option<&[f64]>,
        monitor: Monitor<'_>,
    ) -> Result<Way, Error> {
        let grid = self.operators.grid();
        let around = Surroundings {
            shape: [grid.nx + 2, grid.ny + 2],
            first: [1, 1],
        };
        let mut way = Way {
            parts: Vec::with_capacity(pace.parts),
            origin: self.origin(pace.motion, grid.dx),
            rigid_slip: None,
            heat: vec![0.0; around.shape[0] * around.shape[1]],
            around,
            iterations: 0,
        };
        way.rigid_slip = self.rows.as_ref().map(|rows| {
            let x = slip_place(way.origin, self.operators);
            let rows = rows
                .iter()
                .map(|row| row.map(|slip| slip * pace.of_creepage));
            slip_of_rows(&grid, x, rows)
        });
        let before = (brought.as_ref()).map(|brought| brought.earlier.pressure.clone());
        for number in 1..=pace.parts {
            // from rest the contact is pressed before it rolls
            let share = match &before {
                Some(_) => number as f64 / pace.parts as f64,
                None => 1.0,
            };
            let creepage_share = self.last_creepage.map_or(1.0, |_| share);
            let mut creepage = self.creepage;
            for (new, old) in creepage.iter_mut().zip(self.last_creepage.iter().flatten()) {
                *new = share * *new + (1.0 - share) * old;
            }
            let [along, across, spin] = creepage.map(|c| c * pace.of_creepage);
            let mut pressure = self.pressure.to_vec();
            for (new, old) in pressure.iter_mut().zip(before.iter().flatten()) {
                *new = share * *new + (1.0 - share) * old;
            }
            let left = (pace.parts - number) as f64;
            let behind = left * self.rolling * pace.duration.unwrap_or(0.0);
            let friction = (self.friction)(behind);
            let last = way.parts.last();
            let rolls_on = last.map(|last| last.as_earlier(self.rest));
            let problem = TangentialProblem {
                around: Some(around),
                pressure: &pressure,
                origin: way.origin,
                drive: [along, across].map(Drive::Slip),
                rigid_slip: way.rigid_slip.as_deref(),
                spin,
                speed: pace.speed,
                friction: &friction,
                plasticity: None,
                earlier: (rolls_on.as_ref()).or(brought.as_ref().map(|brought| &brought.earlier)),
                start: last.map_or(start, |last| Some(&last.traction)),
                tolerance: self.tolerance,
            };
            let solution = solve(self.operators, &problem, monitor)?;
            if !solution.converged {
                return Err(Error::Tangential {
                    side: self.side,
                    residual: solution.history.last().copied().unwrap_or(f64::NAN),
                });
            }
            way.iterations += solution.iterations + solution.coarse_iterations;
            let heat = dissipation(self.operators, &problem, &solution, around);
            let share_of_all = pace.speed / pace.parts as f64;
            for (all, own) in way.heat.iter_mut().zip(&heat) {
                *all += share_of_all * own;
            }
            let rolls_on = problem.earlier.is_some();
            let transient = pace.duration.map(|duration| {
                let power = pace.speed * heat.iter().sum::<f64>() * grid.cell_area();
                let before = brought.take();
                TransientLinear::new(duration, pace.motion, self.rolling, power, before, rolls_on)
            });
            way.parts.push(Part {
                share,
                behind,
                creepage,
                creepage_share,
                friction,
                transient,
                pressure,
                traction: solution.traction,
                slip: solution.slip,
                coefficient: solution.coefficient,
                state: solution.state,
            });
        }
        Ok(way)
    }
}

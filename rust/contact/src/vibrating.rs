// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies that vibrate on their contact: inertia away from the contact points, which have none.
//!
//! Coordinates `x`, amplitudes of vibrations and rigid motions, move the contact points by `G x`, and forces on these move
//! the coordinates. With the unknowns `u = (q_x, q_y, p)` [Pa] of [`coupled`](crate::coupled), the areas `A` and the
//! compliance `C` of all that has no inertia,
//!
//! ```text
//! M a + D r + K x = f + G^T A u,        v = C u + G x,
//! ```
//!
//! with the rates `r` and accelerations `a`. There `v` is the tangential displacement `u_lower - u_upper`, and along the normal what is added to the gap. The
//! contact is static at each instant, so that nothing chatters.
//!
//! Steps are those of the trapezoidal rule in `x`, `r` and `u`, with the conditions of contact and friction at the end of
//! the step. As `x` at the end is linear in `u` there, each step is a static contact of the compliance
//! `C + (h^2 / 4) G H^-1 G^T A` with `H = M + (h / 2) D + (h^2 / 4) K`. The energy
//! `E = (r^T M r + x^T K x + u^T A C u) / 2` then changes by
//!
//! ```text
//! dE = work of drive and loads - damping - friction + closing,
//! ```
//!
//! exactly, where friction is the mean traction times the slip, and `closing` is the mean pressure times the change of the
//! gap. Both the pressure and the gap of a point change in the same step only where it opens or closes, so that `closing`
//! falls with the square of the step; all else conserves the energy to rounding.
//!
//! Friction over the speed is, at each point, that of the speed at which it slides at the end of the step: with the rates
//! there, and with what gives way at the mean rate of the step. As the speeds follow from the friction, the step is solved
//! until they agree: by Newton's method where friction rises with the speed, by parts of the change where it falls. A point
//! that turns its slip within the step was at rest in it; where friction rises, its speed is at most twice its mean one.

use std::sync::Arc;

use faer::{ColRef, Mat, Par};
use mtb_operator::dense::Lu;
use mtb_operator::{Monitor, reset_workers};

use crate::coupled::{
    CoupledContact, CoupledLoad, CoupledMatrix, CoupledState, KeptInverse, PointState,
};
use crate::error::{Error, check, check_positive};
use crate::prepared::Table;

/// Residual over the norm of the pressure.
const TOLERANCE: f64 = 1e-11;

/// Change of a friction coefficient by the speeds of the step that it gives, below which it is that of these speeds.
const COEFFICIENT_TOLERANCE: f64 = 1e-11;

/// The same where steep friction does not get nearer, as speeds are differences of displacements over a short step.
const KNOWN_SPEED: f64 = 1e-8;

/// Most that the friction goes on by in parts of what the speeds of a step ask for.
const LONGEST_PART: f64 = 8.0;

/// Least part of a step of Newton's method for the friction.
const SHORTEST_PART: f64 = 1e-3;

/// Solutions of a step before its friction counts as not found.
const PASSES: usize = 60;

/// How points slide, and the friction that this gives them.
struct SlidingPoints {
    /// (n) [m/s].
    speed: Vec<f64>,
    /// (n).
    friction: Vec<f64>,
    /// Change of the friction with the speed (n) [s/m].
    rise: Vec<f64>,
    /// 1 where the speed is that of the end of the step, 0 where it is twice the mean one.
    mean: Vec<f64>,
    /// Direction (2n) of sliding, of points that stick that of their traction.
    way: Vec<f64>,
}

/// Linear equations of motion of what has inertia, and how it moves the contact points.
pub struct Movement {
    /// Number k of coordinates.
    pub coordinates: usize,
    /// (k, k) row by row, as all others; symmetric, positive.
    pub mass: Vec<f64>,
    /// (k, k).
    pub damping: Vec<f64>,
    /// (k, k).
    pub stiffness: Vec<f64>,
    /// Displacement (3n, k) of the contact points by a unit of each coordinate: that of the lower body less that of the
    /// upper one along both tangents, then the opening.
    pub shapes: Vec<f64>,
}

/// The same as matrices.
struct Matrices {
    mass: Mat<f64>,
    damping: Mat<f64>,
    stiffness: Mat<f64>,
    shapes: Mat<f64>,
}

/// What touches, as [`VibratingContact::new`] takes it.
pub struct Touching {
    /// Compliance (3n, 3n) [m/Pa] of what has no inertia: that of both bodies without what their vibrations carry,
    /// row by row.
    pub compliance: Vec<f64>,
    /// Area of each point (n) [m2].
    pub area: Vec<f64>,
    /// Friction coefficients (n) over the sliding speed.
    pub friction: Table,
    /// Tractions on the lower body along both tangents, then pressures (3n) [Pa], at the beginning.
    pub traction: Vec<f64>,
    /// Gap (n) [m] at the beginning.
    pub gap: Vec<f64>,
}

/// Bodies that vibrate on their contact, in steps of one length; see the [module](self).
pub struct VibratingContact {
    compliance: CoupledMatrix,
    moving: Arc<CoupledMatrix>,
    movement: Matrices,
    /// Of the mass.
    mass: Lu,
    /// `H`.
    advance: Lu,
    /// Loads (k) that balance the tractions of the beginning.
    rest: Vec<f64>,
    area: Vec<f64>,
    /// Gap (n) [m] without tractions.
    gap: Vec<f64>,
    friction: Table,
    start: VibratingState,
    step: f64,
}

/// Where vibrating bodies are.
#[derive(Clone, Debug, PartialEq)]
pub struct VibratingState {
    /// Tractions along both tangents on the lower body, then pressures (3n) [Pa].
    pub traction: Vec<f64>,
    /// Coordinates (k), from where the bodies were at the beginning.
    pub amplitude: Vec<f64>,
    /// Their rates (k).
    pub rate: Vec<f64>,
    /// Loads on them (k) besides those that keep the balance of the beginning.
    pub load: Vec<f64>,
}

/// A step of vibrating bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct Vibrated {
    /// At the end of the step.
    pub state: VibratingState,
    /// What each point does (n).
    pub points: Vec<PointState>,
    /// Slip (2n) [m] of the upper body over the lower one.
    pub slip: Vec<f64>,
    /// Gap (n) [m].
    pub gap: Vec<f64>,
    /// Friction coefficients (n) of the step.
    pub friction: Vec<f64>,
    /// What the step did to the energy.
    pub work: Work,
    /// Newton steps.
    pub iterations: usize,
    /// Residual over the norm of the pressure.
    pub residual: f64,
}

/// Works [J] in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Work {
    /// Of friction, mean traction times slip: turned into heat.
    pub friction: f64,
    /// Of what drives the bodies along.
    pub drive: f64,
    /// Of the loads on the coordinates, those that keep the balance of the beginning included.
    pub load: f64,
    /// Of the dampers: taken off the bodies.
    pub damping: f64,
    /// Of the pressures of points that open or close: of second order in the length of the step.
    pub closing: f64,
}

/// Energies [J].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// Of the motion.
    pub kinetic: f64,
    /// Of the stiffness of the coordinates.
    pub potential: f64,
    /// Of what gives way at the contact points.
    pub contact: f64,
}

/// A step under some friction.
struct Advanced {
    found: CoupledState,
    /// Mean rates (k) of the coordinates.
    mean_rate: Vec<f64>,
    /// Those at the end (k).
    rate: Vec<f64>,
}

impl VibratingContact {
    /// Bodies at the balance of the tractions that are given, for steps of the length `step` [s].
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, areas that are not positive, no coordinate, [`Error::Interrupted`].
    pub fn new(
        touching: Touching,
        movement: &Movement,
        step: f64,
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let (n, k) = (touching.area.len(), movement.coordinates);
        check_positive("step", step)?;
        check_positive("number of coordinates", k as f64)?;
        check("area", &touching.area, n)?;
        let compliance = matrix("compliance", &touching.compliance, 3 * n, 3 * n)?;
        let movement = Matrices {
            mass: matrix("mass", &movement.mass, k, k)?,
            damping: matrix("damping", &movement.damping, k, k)?,
            stiffness: matrix("stiffness", &movement.stiffness, k, k)?,
            shapes: matrix("shapes", &movement.shapes, 3 * n, k)?,
        };
        touching.friction.check("friction", n)?;
        check("traction", &touching.traction, 3 * n)?;
        check("gap", &touching.gap, n)?;
        let par = faer::Par::Seq;
        let half = 0.5 * step;
        let h = Mat::from_fn(k, k, |i, j| {
            movement.mass[(i, j)]
                + half * movement.damping[(i, j)]
                + half * half * movement.stiffness[(i, j)]
        });
        let advance = Lu::new(h, par, monitor)?;
        let forces = Mat::from_fn(k, 3 * n, |i, j| {
            half * half * movement.shapes[(j, i)] * touching.area[j % n]
        });
        let answer = advance.solve(forces.as_ref(), par, monitor)?;
        reset_workers();
        let compliance = CoupledMatrix::of(compliance);
        let moving = compliance.softer(movement.shapes.as_ref(), answer.as_ref());
        let strained = compliance.displacement(&touching.traction);
        let gaps = touching.gap.iter().zip(&strained[2 * n..]);
        let gap = gaps.map(|(gap, v)| gap - v).collect();
        let mut contact = Self {
            compliance,
            moving: Arc::new(moving),
            mass: Lu::new(movement.mass.clone(), par, monitor)?,
            advance,
            rest: vec![0.0; k],
            movement,
            area: touching.area,
            gap,
            friction: touching.friction,
            start: VibratingState {
                traction: touching.traction,
                amplitude: vec![0.0; k],
                rate: vec![0.0; k],
                load: vec![0.0; k],
            },
            step,
        };
        let pushed = contact.pushed(&contact.start.traction);
        contact.rest = pushed.iter().map(|push| -push).collect();
        contact.contact(&contact.friction.rows()[0])?;
        Ok(contact)
    }

    /// The balance at the beginning.
    pub fn start(&self) -> &VibratingState {
        &self.start
    }

    /// Number of contact points.
    pub fn points(&self) -> usize {
        self.area.len()
    }

    /// Energies in a state.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite.
    pub fn energy(&self, state: &VibratingState) -> Result<Energy, Error> {
        self.check(state)?;
        let strained = self.compliance.displacement(&state.traction);
        let quadratic = |matrix: &Mat<f64>, x: &[f64]| 0.5 * dot(x, &times(matrix, x));
        Ok(Energy {
            kinetic: quadratic(&self.movement.mass, &state.rate),
            potential: quadratic(&self.movement.stiffness, &state.amplitude),
            contact: 0.5 * self.over_area(&state.traction, &strained),
        })
    }

    /// The step after `state` while the upper body is driven over the lower one along both tangents by `drive` (2n) [m],
    /// with other loads (k) on the coordinates at its end than those that keep the balance of the beginning, and friction
    /// coefficients (n) in place of those at the speeds of the points; `None` if none was found.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, a speed outside the table of friction, [`Error::Interrupted`].
    pub fn step(
        &self,
        state: &VibratingState,
        drive: &[f64],
        load: &[f64],
        friction: Option<&[f64]>,
        kept: &mut KeptInverse,
        monitor: Monitor<'_>,
    ) -> Result<Option<Vibrated>, Error> {
        let (n, k, h) = (self.points(), self.rest.len(), self.step);
        self.check(state)?;
        check("drive", drive, 2 * n)?;
        check("load", load, k)?;
        let loads = state.load.iter().zip(load).zip(&self.rest);
        let given: Vec<f64> = loads.map(|((a, b), rest)| rest + 0.5 * (a + b)).collect();
        // where the coordinates would go without the tractions at the end
        let held = times(&self.movement.stiffness, &state.amplitude);
        let carried = times(&self.movement.mass, &state.rate);
        let pushed = self.pushed(&state.traction);
        let right: Vec<f64> = (0..k)
            .map(|i| carried[i] + 0.5 * h * (given[i] - held[i] + 0.5 * pushed[i]))
            .collect();
        let mean_rate = solve(&self.advance, &right);
        let ahead: Vec<f64> = state
            .amplitude
            .iter()
            .zip(&mean_rate)
            .map(|(x, v)| x + h * v)
            .collect();
        let placed = times(&self.movement.shapes, &ahead);
        let before = self.displacement(&state.traction, &state.amplitude);
        let (along, opened) = placed.split_at(2 * n);
        let mut from = vec![0.0; 3 * n];
        for ((from, before), along) in from.iter_mut().zip(&before).zip(along) {
            *from = before - along;
        }
        let from = CoupledState::before(&state.traction, from, n);
        let push = [drive, opened].concat();
        let mut solved = |friction: &[f64]| -> Result<Option<Advanced>, Error> {
            let contact = self.contact(friction)?;
            let Some(found) = contact.step(&from, &push, kept, monitor)? else {
                return Ok(None);
            };
            // and where they go with them
            let pulled = self.pushed(&found.traction);
            let more: Vec<f64> = pulled.iter().map(|f| 0.25 * h * f).collect();
            let more = solve(&self.advance, &more);
            let mean_rate = more.iter().zip(&mean_rate).map(|(more, v)| v + more);
            let mean_rate: Vec<f64> = mean_rate.collect();
            let rate = mean_rate.iter().zip(&state.rate);
            let rate = rate.map(|(mean, before)| 2.0 * mean - before).collect();
            Ok(Some(Advanced {
                found,
                mean_rate,
                rate,
            }))
        };
        let (friction, advanced) = match friction {
            Some(given) => (given.to_vec(), solved(given)?),
            None if self.friction.rows().len() == 1 => {
                let friction = self.friction.rows()[0].clone();
                let advanced = solved(&friction)?;
                (friction, advanced)
            }
            None => self.at_its_speeds(state, drive, &mut solved, monitor)?,
        };
        let Some(Advanced {
            found,
            mean_rate,
            rate,
        }) = advanced
        else {
            return Ok(None);
        };
        let amplitude = state.amplitude.iter().zip(&mean_rate);
        let amplitude = amplitude.map(|(x, v)| x + h * v).collect();
        let next = VibratingState {
            traction: found.traction,
            amplitude,
            rate,
            load: load.to_vec(),
        };
        let after = self.displacement(&next.traction, &next.amplitude);
        let mean: Vec<f64> = next
            .traction
            .iter()
            .zip(&state.traction)
            .map(|(a, b)| 0.5 * (a + b))
            .collect();
        let changed: Vec<f64> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
        let slip: Vec<f64> = drive.iter().zip(&changed).map(|(d, v)| d - v).collect();
        let way: Vec<f64> = mean_rate.iter().map(|v| h * v).collect();
        let work = Work {
            friction: self.over_area(&mean[..2 * n], &slip),
            drive: self.over_area(&mean[..2 * n], drive),
            load: dot(&given, &way),
            damping: dot(&way, &times(&self.movement.damping, &mean_rate)),
            closing: self.over_area(&mean[2 * n..], &changed[2 * n..]),
        };
        let gaps = self.gap.iter().zip(&after[2 * n..]);
        Ok(Some(Vibrated {
            state: next,
            points: found.points,
            gap: gaps.map(|(gap, v)| gap + v).collect(),
            slip,
            friction,
            work,
            iterations: found.iterations,
            residual: found.residual,
        }))
    }

    /// The step whose friction is that of the speeds at which it ends, and this friction; nothing in place of the step
    /// if none was found.
    ///
    /// Of several, as where falling friction lets a point stick or slip, it is one near the speeds foretold.
    fn at_its_speeds(
        &self,
        state: &VibratingState,
        drive: &[f64],
        solved: &mut impl FnMut(&[f64]) -> Result<Option<Advanced>, Error>,
        monitor: Monitor<'_>,
    ) -> Result<(Vec<f64>, Option<Advanced>), Error> {
        let foretold = self.foretold(state, drive);
        let mut friction = self
            .friction
            .at_each("friction", &self.in_table(foretold))?;
        let (mut part, mut last) = (1.0, vec![0.0; self.points()]);
        // where it was before, with the change there and its size, while Newton's method is on its way
        let mut before: Option<(Vec<f64>, f64)> = None;
        for _ in 0..PASSES {
            let Some(advanced) = solved(&friction)? else {
                break;
            };
            let sliding = self.sliding(state, drive, &advanced)?;
            let rising = self.rising(&advanced, &sliding, &mut friction);
            let change: Vec<f64> = sliding
                .friction
                .iter()
                .zip(&friction)
                .map(|(a, b)| a - b)
                .collect();
            let size = dot(&change, &change);
            // Newton's method comes no nearer than the speeds of a step are known
            let stays = (before.as_ref()).is_some_and(|(_, least)| 2.0 * size > *least);
            let tolerance = if stays {
                KNOWN_SPEED
            } else {
                COEFFICIENT_TOLERANCE
            };
            if change.iter().all(|c| c.abs() <= tolerance) {
                // no friction where nothing presses
                let mut speeds = sliding.speed;
                let inside = self.in_table(speeds.clone());
                for (i, point) in advanced.found.points.iter().enumerate() {
                    if *point == PointState::Open {
                        speeds[i] = inside[i];
                    }
                }
                self.friction.at_each("friction", &speeds)?;
                return Ok((friction, Some(advanced)));
            }
            if rising.is_empty() {
                // as the change by the last part of one tells
                let ratio = dot(&change, &last) / dot(&last, &last).max(f64::MIN_POSITIVE);
                if ratio < 1.0 {
                    part = (part / (1.0 - ratio)).min(LONGEST_PART);
                }
                last = change;
                before = None;
            } else if let Some((start, _)) = before.as_ref().filter(|(_, least)| size > *least)
                && part > SHORTEST_PART
            {
                // over a kink of the table, or onto the other side of stick
                part *= 0.5;
                friction.clone_from(start);
            } else {
                part = 1.0;
                last = self.slowed(&advanced, &sliding, &rising, change, monitor)?;
                before = Some((friction.clone(), size));
            }
            for (f, c) in friction.iter_mut().zip(&last) {
                *f = (*f + part * c).max(0.0);
            }
        }
        Ok((friction, None))
    }

    /// The points whose friction rises with their speed and so slows them down.
    ///
    /// A point sticks alike under any friction above its traction: this, or that of rest, becomes its friction.
    fn rising(
        &self,
        advanced: &Advanced,
        sliding: &SlidingPoints,
        friction: &mut [f64],
    ) -> Vec<usize> {
        let (n, found) = (self.points(), &advanced.found);
        let pressure = &found.traction[2 * n..];
        let mut rising: Vec<usize> = (0..n)
            .filter(|&i| sliding.rise[i] > 0.0 && pressure[i] > 0.0)
            .collect();
        for &i in &rising {
            if found.points[i] == PointState::Stick {
                let carried = found.traction[i].hypot(found.traction[n + i]) / pressure[i];
                friction[i] = friction[i].min(carried).max(sliding.friction[i]);
            }
        }
        rising.retain(|&i| friction[i] != sliding.friction[i]);
        rising
    }

    /// The change (n) of the friction towards that of the speeds at which the points slide, by Newton's method at the
    /// `rising` ones.
    fn slowed(
        &self,
        advanced: &Advanced,
        sliding: &SlidingPoints,
        rising: &[usize],
        mut change: Vec<f64>,
        monitor: Monitor<'_>,
    ) -> Result<Vec<f64>, Error> {
        let (n, found) = (self.points(), &advanced.found);
        let (still, all) = (&self.compliance.compliance, &self.moving.compliance);
        let matrix = Mat::from_fn(rising.len(), rising.len(), |i, j| {
            let (row, column) = (rising[i], rising[j]);
            let unit = if i == j { 1.0 } else { 0.0 };
            // a point that slides against the slip of the step at its end
            if sliding.speed[row] == 0.0 && found.points[row] == PointState::Slip {
                return unit;
            }
            let slid: f64 = [0, n]
                .iter()
                .flat_map(|a| [0, n].map(|b| (*a, b)))
                .map(|(a, b)| {
                    let at = (a + row, b + column);
                    let along = sliding.way[at.0] * sliding.way[at.1];
                    // what has inertia changes its rate at the end by twice its mean
                    along * (2.0 * all[at] - sliding.mean[row] * still[at])
                })
                .sum();
            unit + sliding.rise[row] * slid * found.traction[2 * n + column] / self.step
        });
        let right: Vec<f64> = rising.iter().map(|&i| change[i]).collect();
        let slowed = solve(&Lu::new(matrix, Par::Seq, monitor)?, &right);
        for (&i, c) in rising.iter().zip(slowed) {
            change[i] = c;
        }
        Ok(change)
    }

    /// Speeds (n) [m/s] at which the points slide at the end of a step, with the accelerations of its beginning.
    fn foretold(&self, state: &VibratingState, drive: &[f64]) -> Vec<f64> {
        let n = self.points();
        let pushed = self.pushed(&state.traction);
        let held = times(&self.movement.stiffness, &state.amplitude);
        let damped = times(&self.movement.damping, &state.rate);
        let right: Vec<f64> = (0..self.rest.len())
            .map(|i| self.rest[i] + state.load[i] + pushed[i] - held[i] - damped[i])
            .collect();
        let rate: Vec<f64> = solve(&self.mass, &right)
            .iter()
            .zip(&state.rate)
            .map(|(a, v)| v + self.step * a)
            .collect();
        let moved = times(&self.movement.shapes, &rate);
        let slides = |i: usize| drive[i] / self.step - moved[i];
        (0..n).map(|i| slides(i).hypot(slides(n + i))).collect()
    }

    /// How points slide at the end of a step, along the slip of the step; those that stick are at rest, and are no part
    /// of a rate that swings about rest from step to step.
    fn sliding(
        &self,
        state: &VibratingState,
        drive: &[f64],
        advanced: &Advanced,
    ) -> Result<SlidingPoints, Error> {
        let n = self.points();
        let (h, after) = (self.step, &advanced.found.traction);
        let changed: Vec<f64> = after
            .iter()
            .zip(&state.traction)
            .map(|(a, b)| a - b)
            .collect();
        let strained = self.compliance.displacement(&changed);
        let moved = times(&self.movement.shapes, &advanced.rate);
        let mean = times(&self.movement.shapes, &advanced.mean_rate);
        let own = |of: &[f64], k: usize| (drive[k] - strained[k]) / h - of[k];
        let mut found = SlidingPoints {
            speed: vec![0.0; n],
            friction: Vec::new(),
            rise: Vec::new(),
            mean: vec![1.0; n],
            way: vec![0.0; 2 * n],
        };
        let mut length = vec![f64::INFINITY; n];
        for i in 0..n {
            let end = [own(&moved, i), own(&moved, n + i)];
            let state = advanced.found.points[i];
            let mut way = [own(&mean, i), own(&mean, n + i)];
            if state == PointState::Stick {
                way = [after[i], after[n + i]];
            }
            let size = way[0].hypot(way[1]).max(f64::MIN_POSITIVE);
            (found.way[i], found.way[n + i]) = (way[0] / size, way[1] / size);
            match state {
                PointState::Stick => length[i] = 0.0,
                PointState::Open => found.speed[i] = end[0].hypot(end[1]),
                PointState::Slip => {
                    let ahead = end[0] * found.way[i] + end[1] * found.way[n + i];
                    (found.speed[i], length[i]) = (ahead.max(0.0), size);
                }
            }
        }
        let of_end = self.in_table(found.speed.clone());
        found.friction = self.friction.at_each("friction", &of_end)?;
        found.rise = self.friction.slopes(&of_end);
        // a point that turns within the step was at rest in it, and is as quick at the end as from there on: else
        // friction that rises would jump to that of rest where the slip of the step is none
        let turned = length.iter().zip(&of_end).map(|(l, v)| (2.0 * l).min(*v));
        let of_turned = self.in_table(turned.collect());
        let less = self.friction.at_each("friction", &of_turned)?;
        let rise = self.friction.slopes(&of_turned);
        for i in 0..n {
            if less[i] < found.friction[i] {
                (found.friction[i], found.rise[i]) = (less[i], rise[i]);
                (found.mean[i], found.speed[i]) = (0.0, of_turned[i]);
            }
        }
        Ok(found)
    }

    /// Speeds, or the first or the last one of the table in place of those outside.
    fn in_table(&self, mut speeds: Vec<f64>) -> Vec<f64> {
        let known = self.friction.speed();
        let (first, last) = (known[0], known[known.len() - 1]);
        for speed in &mut speeds {
            *speed = speed.clamp(first, last);
        }
        speeds
    }

    /// The static contact of a step.
    fn contact(&self, friction: &[f64]) -> Result<CoupledContact, Error> {
        let load = CoupledLoad {
            area: &self.area,
            friction,
            gap: &self.gap,
            motions: &[],
            diagonal: None,
        };
        CoupledContact::of(self.moving.clone(), &load, TOLERANCE)
    }

    fn check(&self, state: &VibratingState) -> Result<(), Error> {
        let k = self.rest.len();
        check("traction of the state", &state.traction, 3 * self.points())?;
        check("amplitude of the state", &state.amplitude, k)?;
        check("rate of the state", &state.rate, k)?;
        check("load of the state", &state.load, k)
    }

    /// What tractions (3n) [Pa] do to the coordinates (k).
    fn pushed(&self, traction: &[f64]) -> Vec<f64> {
        let n = self.points();
        let forces: Vec<f64> = (0..3 * n).map(|i| self.area[i % n] * traction[i]).collect();
        let pushed = self.movement.shapes.transpose() * ColRef::from_slice(&forces);
        pushed.iter().copied().collect()
    }

    /// Displacement (3n) [m] by tractions and coordinates.
    fn displacement(&self, traction: &[f64], amplitude: &[f64]) -> Vec<f64> {
        let mut moved = self.compliance.displacement(traction);
        for (v, placed) in moved
            .iter_mut()
            .zip(times(&self.movement.shapes, amplitude))
        {
            *v += placed;
        }
        moved
    }

    /// Sum of the products of two fields over the area.
    fn over_area(&self, one: &[f64], other: &[f64]) -> f64 {
        let n = self.points();
        let products = one.iter().zip(other).enumerate();
        products.map(|(i, (a, b))| self.area[i % n] * a * b).sum()
    }
}

/// A matrix by its rows.
fn matrix(
    name: &'static str,
    values: &[f64],
    rows: usize,
    columns: usize,
) -> Result<Mat<f64>, Error> {
    check(name, values, rows * columns)?;
    Ok(Mat::from_fn(rows, columns, |i, j| values[i * columns + j]))
}

fn times(matrix: &Mat<f64>, vector: &[f64]) -> Vec<f64> {
    let product = matrix * ColRef::from_slice(vector);
    product.iter().copied().collect()
}

fn solve(factors: &Lu, right: &[f64]) -> Vec<f64> {
    let column = Mat::from_fn(right.len(), 1, |i, _| right[i]);
    let found = factors.solve_few(column.as_ref(), faer::Par::Seq);
    found.col(0).iter().copied().collect()
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| a * b).sum()
}

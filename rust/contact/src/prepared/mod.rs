// SPDX-License-Identifier: MIT OR Apache-2.0
//! A sliding contact ready for a simulation: pose and velocity in, force and moment out.

mod bytes;
mod table;

use std::sync::Arc;

use mtb_complementarity::linear::Status;
use mtb_operator::Monitor;

use crate::error::{Error, check};
use crate::sliding::{RigidMotion, SlidingContact, SlidingSolution};
use crate::stepping::{Effort, Influence, SlidingStepper};
pub use table::Table;

/// Largest number a step takes, in SI units; beyond it squares overflow.
const LARGEST: f64 = 1e30;

/// Contact points in the common frame: three components (3n) each, x of all points first.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// Positions [m].
    pub points: Vec<f64>,
    /// Unit normals of the lower body, pointing to the upper one.
    pub normal: Vec<f64>,
    /// Unit tangents along x.
    pub tangent_x: Vec<f64>,
    /// Unit tangents across, normal x `tangent_x`.
    pub tangent_y: Vec<f64>,
    /// Area of each point (n) [m2].
    pub area: Vec<f64>,
    /// Means of `tangent_x`, `tangent_y` and `normal` over the area of each point: what resultants and poses
    /// see. The same as these for small cells.
    pub mean_frame: [Vec<f64>; 3],
    /// What turns the unknowns into mean pressures, where they are not these themselves.
    pub means: Option<Means>,
}

/// Shares of basis functions in the area of each point, row by row; the rows add up to one.
#[derive(Clone, Debug, PartialEq)]
pub struct Means {
    /// First entry of each row, and one past the last (n + 1).
    pub start: Vec<usize>,
    /// Basis function of each entry.
    pub column: Vec<usize>,
    /// Its share.
    pub share: Vec<f64>,
}

/// A rigid motion that the supports leave free.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeMotion {
    /// Its name, for example `left z`.
    pub name: String,
    /// What it does to the contact; its `work` is part of the loads.
    pub motion: RigidMotion,
    /// The component of the pose (x, y, z, roll, pitch, yaw) that takes its place when prescribed.
    pub component: Option<usize>,
}

/// Everything a sliding contact needs to know beforehand.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// Influence matrices of the pair.
    pub influence: Arc<Influence>,
    /// The contact points.
    pub geometry: Geometry,
    /// Motions found from balance.
    pub motions: Vec<FreeMotion>,
    /// Friction coefficient at the points (n) over the sliding speed.
    pub friction: Table,
    /// Gap before contact (n) [m], then work of the loads on each motion (m) [J], over the sliding speed.
    pub loads: Table,
    /// The same without a magnetic pressure, and their change by a uniform magnetic pressure of 1 Pa.
    pub magnetic: Option<[Vec<f64>; 2]>,
    /// The scene's own sliding direction of the upper body, x and y; zeros where nothing slides.
    pub sliding_direction: [f64; 2],
    /// Point the moments and rotations are about [m].
    pub reference_point: [f64; 3],
    /// Speed below which friction falls to zero with the speed [m/s]; `None`: at rest there is no answer.
    pub standstill_speed: Option<f64>,
}

/// What presses the bodies together in a step.
#[derive(Clone, Copy, Debug)]
pub enum Pull<'a> {
    /// The scene's own loads, at the step's speed.
    Scene,
    /// A uniform magnetic pressure [Pa] in place of the scene's.
    Uniform(f64),
    /// Gap before contact (n) [m] and work on each motion (m) [J].
    Given {
        /// Gap before contact (n) [m].
        gap: &'a [f64],
        /// Work of the loads on each motion (m) [J].
        work: &'a [f64],
    },
}

/// The state of motion of the upper body relative to the lower one.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// Displacement from the reference position: x, y, z [m], then roll, pitch, yaw [rad], turned in this order
    /// about the fixed axes through the reference point; NaN: left to balance, or zero where nothing is free.
    pub pose: [f64; 6],
    /// Sliding velocity of the upper body over the lower one, x and y [m/s].
    pub velocity: [f64; 2],
    /// What presses.
    pub pull: Pull<'a>,
}

/// Contact load of a step.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The solution; pressure, gap, and how the search ended.
    pub solution: SlidingSolution,
    /// Friction coefficient at each point (n).
    pub friction: Vec<f64>,
    /// Sliding direction in the tangent plane (2n).
    pub direction: Vec<f64>,
    /// Force on the lower body [N].
    pub force: [f64; 3],
    /// Moment of it about the reference point [N m].
    pub moment: [f64; 3],
    /// Heat of sliding [W]: the friction times the sliding velocity; the work of the pressures is not in it.
    pub friction_power: f64,
    /// What it took.
    pub effort: Effort,
}

/// A prepared contact with the memory of its last step.
pub struct PreparedContact {
    prepared: Arc<Prepared>,
    stepper: SlidingStepper,
}

impl Geometry {
    /// Number of points.
    pub fn points(&self) -> usize {
        self.area.len()
    }

    fn vector(field: &[f64], point: usize) -> [f64; 3] {
        let n = field.len() / 3;
        [0, 1, 2].map(|c| field[c * n + point])
    }
}

impl Means {
    fn check(&self, n: usize) -> Result<(), Error> {
        check("share", &self.share, self.column.len())?;
        let rising = self.start.is_sorted() && self.start.first() == Some(&0);
        if self.start.len() != n + 1 || !rising || self.start[n] != self.column.len() {
            return Err(Error::Stored("its means have no such rows"));
        }
        if self.column.iter().any(|c| *c >= n) {
            return Err(Error::Stored("its means name points that are none"));
        }
        Ok(())
    }
}

impl Prepared {
    /// Mean pressure over each point (n) [Pa] from the unknowns of a solution.
    ///
    /// What a point in contact would give to an open one it keeps, so the force stays and open points carry
    /// nothing.
    pub fn mean_pressure(&self, pressure: &[f64]) -> Vec<f64> {
        let Some(means) = &self.geometry.means else {
            return pressure.to_vec();
        };
        let area = &self.geometry.area;
        let mut out = vec![0.0; pressure.len()];
        for i in 0..pressure.len() {
            for k in means.start[i]..means.start[i + 1] {
                let j = means.column[k];
                let part = means.share[k] * pressure[j];
                if pressure[i] > 0.0 {
                    out[i] += part;
                } else {
                    out[j] += part * area[i] / area[j];
                }
            }
        }
        out
    }

    /// Checks that all parts belong together.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite.
    pub fn check(&self) -> Result<(), Error> {
        let n = self.influence.points();
        let g = &self.geometry;
        check("area", &g.area, n)?;
        for (name, field) in [
            ("points", &g.points),
            ("normal", &g.normal),
            ("tangent_x", &g.tangent_x),
            ("tangent_y", &g.tangent_y),
            ("mean_frame", &g.mean_frame[0]),
            ("mean_frame", &g.mean_frame[1]),
            ("mean_frame", &g.mean_frame[2]),
        ] {
            check(name, field, 3 * n)?;
        }
        if let Some(means) = &g.means {
            means.check(n)?;
        }
        for free in &self.motions {
            check("opening", &free.motion.opening, n)?;
            check("tangential_x", &free.motion.tangential_x, n)?;
            check("tangential_y", &free.motion.tangential_y, n)?;
        }
        self.friction.check("friction", n)?;
        self.loads.check("loads", n + self.motions.len())?;
        for part in self.magnetic.iter().flatten() {
            check("magnetic", part, n + self.motions.len())?;
        }
        check("sliding_direction", &self.sliding_direction, 2)?;
        check("reference_point", &self.reference_point, 3)
    }

    /// Friction coefficients and sliding directions (2n) at a velocity.
    fn sliding(&self, velocity: [f64; 2]) -> Result<(Vec<f64>, Vec<f64>), Error> {
        let n = self.influence.points();
        let speed = velocity[0].hypot(velocity[1]);
        let mut friction = self.friction.at("friction", speed)?;
        if let Some(slow) = self.standstill_speed {
            let share = (speed / slow).min(1.0);
            for mu in &mut friction {
                *mu *= share;
            }
        }
        let mut direction = vec![0.0; 2 * n];
        if speed == 0.0 {
            if friction.iter().any(|mu| *mu != 0.0) {
                return Err(Error::Standstill);
            }
            return Ok((friction, direction));
        }
        for i in 0..n {
            let along = |field: &[f64]| {
                let t = Geometry::vector(field, i);
                velocity[0] * t[0] + velocity[1] * t[1]
            };
            let (x, y) = (
                along(&self.geometry.tangent_x),
                along(&self.geometry.tangent_y),
            );
            let length = x.hypot(y);
            if length < 1e-6 * speed {
                return Err(Error::Normal { index: i });
            }
            direction[i] = x / length;
            direction[n + i] = y / length;
        }
        Ok((friction, direction))
    }

    /// Opening of each gap by the prescribed components of a pose.
    fn add_pose(&self, pose: &[f64; 6], gap: &mut [f64]) {
        let known = pose.map(|v| if v.is_nan() { 0.0 } else { v });
        if known == [0.0; 6] {
            return;
        }
        let turn = rotation(known[3], known[4], known[5]);
        for (i, gap) in gap.iter_mut().enumerate() {
            let x = Geometry::vector(&self.geometry.points, i);
            let normal = Geometry::vector(&self.geometry.mean_frame[2], i);
            for c in 0..3 {
                let mut u = known[c];
                for k in 0..3 {
                    let unit = if c == k { 1.0 } else { 0.0 };
                    u += (turn[c][k] - unit) * (x[k] - self.reference_point[k]);
                }
                *gap += normal[c] * u;
            }
        }
    }
}

impl PreparedContact {
    /// A contact that has taken no step yet; several may share what is prepared.
    pub fn new(prepared: Arc<Prepared>) -> Self {
        let stepper = SlidingStepper::new(prepared.influence.clone());
        Self { prepared, stepper }
    }

    /// What is prepared.
    pub fn prepared(&self) -> &Arc<Prepared> {
        &self.prepared
    }

    /// Takes `pressure` (n) and `motion` for the last step's, in place of what it remembers.
    ///
    /// # Errors
    /// A wrong length, numbers that are not finite.
    pub fn resume(&mut self, pressure: &[f64], motion: &[f64]) -> Result<(), Error> {
        self.stepper.resume(pressure, motion)
    }

    /// Solves one step.
    ///
    /// # Errors
    /// Numbers that are not finite, or too large for a finite result; a speed outside the tables; friction at rest without a standstill speed;
    /// an interruption. That no sliding state exists (wedging) is a status of the solution.
    pub fn step(&mut self, step: &Step<'_>, monitor: Monitor<'_>) -> Result<Outcome, Error> {
        let prepared = self.prepared.clone();
        let (n, m) = (prepared.influence.points(), prepared.motions.len());
        let pose = step.pose.map(|v| if v.is_nan() { 0.0 } else { v });
        check_size("pose", &pose)?;
        check_size("velocity", &step.velocity)?;
        if let Pull::Uniform(pressure) = step.pull {
            check_size("magnetic_pressure", &[pressure])?;
        }
        let (friction, direction) = prepared.sliding(step.velocity)?;
        let mut gap = match step.pull {
            Pull::Scene => {
                let [x, y] = step.velocity;
                prepared.loads.at("magnetic_pressure", x.hypot(y))?
            }
            Pull::Uniform(pressure) => {
                let [base, unit] = prepared.magnetic.as_ref().ok_or(Error::NotMagnetic)?;
                base.iter()
                    .zip(unit)
                    .map(|(b, u)| b + pressure * u)
                    .collect()
            }
            Pull::Given { gap, work } => {
                check("gap", gap, n)?;
                check("work", work, m)?;
                [gap, work].concat()
            }
        };
        let work = gap.split_off(n);
        prepared.add_pose(&step.pose, &mut gap);
        let motions: Vec<RigidMotion> = prepared
            .motions
            .iter()
            .zip(work)
            .filter(|(free, _)| free.component.is_none_or(|c| step.pose[c].is_nan()))
            .map(|(free, work)| RigidMotion {
                work,
                ..free.motion.clone()
            })
            .collect();
        let area = &prepared.geometry.area;
        let contact = SlidingContact {
            gap: &gap,
            area,
            friction: &friction,
            direction: &direction,
            motions: &motions,
        };
        let (solution, effort) = self.stepper.solve(&contact, monitor)?;
        let outcome = outcome(
            &prepared,
            solution,
            friction,
            direction,
            step.velocity,
            effort,
        );
        if let Err(error) = outcome.check() {
            // what is not finite must not start the next step
            self.stepper = SlidingStepper::new(prepared.influence.clone());
            return Err(error);
        }
        Ok(outcome)
    }
}

fn outcome(
    prepared: &Prepared,
    solution: SlidingSolution,
    friction: Vec<f64>,
    direction: Vec<f64>,
    velocity: [f64; 2],
    effort: Effort,
) -> Outcome {
    let g = &prepared.geometry;
    let n = g.points();
    let (mut force, mut moment, mut friction_power) = ([0.0; 3], [0.0; 3], 0.0);
    for i in 0..n {
        let p = solution.pressure[i];
        if p == 0.0 {
            continue;
        }
        let at = Geometry::vector(&g.points, i);
        let [tx, ty, normal] = [0, 1, 2].map(|axis| Geometry::vector(&g.mean_frame[axis], i));
        let (qx, qy) = (
            friction[i] * p * direction[i],
            friction[i] * p * direction[n + i],
        );
        let along = |t: [f64; 3]| velocity[0] * t[0] + velocity[1] * t[1];
        friction_power += g.area[i] * (qx * along(tx) + qy * along(ty));
        let load: [f64; 3] =
            std::array::from_fn(|c| g.area[i] * (qx * tx[c] + qy * ty[c] - p * normal[c]));
        let arm: [f64; 3] = std::array::from_fn(|c| at[c] - prepared.reference_point[c]);
        for c in 0..3 {
            let (a, b) = ((c + 1) % 3, (c + 2) % 3);
            force[c] += load[c];
            moment[c] += arm[a] * load[b] - arm[b] * load[a];
        }
    }
    Outcome {
        solution,
        friction,
        direction,
        force,
        moment,
        friction_power,
        effort,
    }
}

impl Outcome {
    /// Why this is no solution, if it is none.
    pub fn unsolved(&self) -> Option<String> {
        match self.solution.status {
            Status::Solved => None,
            Status::NoSolution => Some("no sliding equilibrium: the body wedges".to_owned()),
            Status::Unreachable => {
                Some("the resultant of the load lies outside what the contact can carry".to_owned())
            }
            Status::IterationLimit => Some(format!(
                "not converged (residual {:.1e})",
                self.solution.residual
            )),
        }
    }

    /// Whether all numbers are finite.
    fn check(&self) -> Result<(), Error> {
        for (name, values) in [
            ("pressure", self.solution.pressure.as_slice()),
            ("gap", &self.solution.gap),
            ("motion", &self.solution.motion),
            ("force", &self.force),
            ("moment", &self.moment),
            ("friction power", &[self.friction_power]),
        ] {
            if let Some(&value) = values.iter().find(|v| !v.is_finite()) {
                return Err(Error::Overflow { name, value });
            }
        }
        Ok(())
    }
}

/// Finite numbers of a size that is meant.
fn check_size(name: &'static str, values: &[f64]) -> Result<(), Error> {
    check(name, values, values.len())?;
    match values.iter().position(|v| v.abs() > LARGEST) {
        Some(index) => Err(Error::TooLarge {
            name,
            index,
            value: values[index],
            largest: LARGEST,
        }),
        None => Ok(()),
    }
}

/// Rotation by roll about x, then pitch about y, then yaw about z, all fixed axes.
fn rotation(roll: f64, pitch: f64, yaw: f64) -> [[f64; 3]; 3] {
    let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
    [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
}

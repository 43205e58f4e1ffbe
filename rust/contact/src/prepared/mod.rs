// SPDX-License-Identifier: MIT OR Apache-2.0
//! A sliding contact ready for a simulation: pose and velocity in, force and moment out.

mod bytes;
mod derivative;
mod pulled;
mod sticking;
mod stuck;
mod table;

use std::sync::Arc;

use mtb_complementarity::linear::Status;
use mtb_operator::Monitor;

use crate::coupled::{KeptInverse, OnDemand};
use crate::error::{Error, check};
use crate::interface::Interface;
use crate::magnet::{Circuit, settle};
use crate::problem::{Attracted, Geometry, Loading, Outcome, Problem};
use crate::sliding::{RigidMotion, SlidingContact};
use crate::stepping::{Influence, SlidingStepper};
pub use derivative::{Gradient, INPUTS, Jacobian, OUTPUTS, Taken};
pub use pulled::{MagnetOverSpeed, Pulled};
pub use sticking::Bodies;
use sticking::Past;
pub use stuck::{StuckJacobian, StuckStep};
pub use table::Table;

/// The components of a pose.
const POSE: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];
/// Largest rotation [rad] of a pose: what is linear in it is wrong by about an eighth there.
const STEEPEST: f64 = 0.5;
/// Largest component of a normal along a face that counts as plane.
const PLANE: f64 = 1e-9;
/// Largest number a step takes, in SI units; beyond it squares overflow.
const LARGEST: f64 = 1e30;

/// A rigid motion that the supports leave free, with the words by which a simulation knows it.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedMotion {
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
    /// Both bodies, for steps that stick; `None` of a contact from a file that holds what sliding needs.
    pub bodies: Option<Bodies>,
    /// The contact points.
    pub geometry: Geometry,
    /// Motions found from balance.
    pub motions: Vec<NamedMotion>,
    /// Friction coefficient at the points (n) over the sliding speed.
    pub friction: Table,
    /// Gap before contact (n) [m], then work of the loads on each motion (m) [J], over the sliding speed.
    pub loads: Table,
    /// The same without a magnetic pressure, and their change by a uniform magnetic pressure of 1 Pa.
    pub magnetic: Option<[Vec<f64>; 2]>,
    /// The scene's own magnet whose pull follows the gap, besides the loads.
    pub magnet: Option<MagnetOverSpeed>,
    /// What a pull at the points does, for magnets; `None` of a contact from a file that was written without one.
    pub pulled: Option<Pulled>,
    /// The scene's own sliding direction of the upper body, x and y; zeros where nothing slides.
    pub sliding_direction: [f64; 2],
    /// Point the moments and rotations are about [m].
    pub reference_point: [f64; 3],
    /// Speed below which friction falls to zero with the speed [m/s]; `None`: at rest there is no answer.
    pub standstill_speed: Option<f64>,
    /// The scene's own velocity along its sliding direction [m/s], where it states one.
    pub velocity: Option<f64>,
    /// Hardness, shear limit of a layer, and rough layer.
    pub interface: Interface,
}

/// What pulls the bodies of a problem together.
#[derive(Clone, Debug)]
pub struct Magnetic<'a> {
    /// The bodies that it pulls.
    pub bodies: &'a [Attracted],
    /// How it pulls in the scene's own loads.
    pub source: Source,
}

/// How something pulls.
#[derive(Clone, Debug)]
pub enum Source {
    /// Not at all: magnets may be given to steps.
    Steps,
    /// With a pressure at the points (n) [Pa] over the sliding speed.
    Pressure(Table),
    /// As a magnet does, whose pull follows the gap.
    Magnet(MagnetOverSpeed),
}

/// How a contact slides.
#[derive(Clone, Debug)]
pub struct Sliding {
    /// Friction coefficient at the points (n) over the sliding speed.
    pub friction: Table,
    /// The scene's own sliding direction of the upper body, x and y; zeros where nothing slides.
    pub direction: [f64; 2],
    /// Speed below which friction falls to zero with the speed [m/s]; `None`: at rest there is no answer.
    pub standstill_speed: Option<f64>,
    /// The scene's own velocity along its sliding direction [m/s], where it states one.
    pub velocity: Option<f64>,
    /// Tangential displacement by a unit traction [m/Pa] of a layer between the bodies, where points stick; 0: none.
    pub layer: f64,
}

/// What presses the bodies together in a step.
#[derive(Clone, Copy, Debug)]
pub enum Pull<'a> {
    /// The scene's own loads, at the step's speed.
    Scene,
    /// A uniform magnetic pressure [Pa] in place of the scene's.
    Uniform(f64),
    /// The scene's own magnet with other ampere-turns [A] in its coil.
    AmpereTurns(f64),
    /// Gap before contact (n) [m], work on each motion (m) [J], and displacement along both tangents (2n) [m].
    Given(&'a Loading),
    /// A magnet whose pull follows the gap, in place of the scene's own pull.
    Following(Following<'a>),
}

/// A magnet in a step.
#[derive(Clone, Copy, Debug)]
pub struct Following<'a> {
    /// Coil, poles and iron.
    pub circuit: &'a Circuit,
    /// Factor of the speed on its pressure.
    pub factor: f64,
    /// Change of the factor with the speed [s/m], for derivatives by the velocity.
    pub by_speed: f64,
}

/// The state of motion of the upper body relative to the lower one.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// Displacement from the reference position: x, y, z [m], then roll, pitch, yaw [rad], turned in this order
    /// about the fixed axes through the reference point; NaN: left to balance, or zero where nothing is free.
    pub pose: [f64; 6],
    /// Sliding velocity of the upper body over the lower one, x and y [m/s]; where a shift is given, the speed of the
    /// tables.
    pub velocity: [f64; 2],
    /// Displacement of the upper body over the lower one since the last step, x and y [m], besides the change of the
    /// pose: points then stick or slip. `None`: all slide.
    pub shift: Option<[f64; 2]>,
    /// What presses.
    pub pull: Pull<'a>,
    /// Gap (n) [m] that is added at this step: joints, wear.
    pub gap: Option<&'a [f64]>,
    /// Friction coefficients (n) in place of the prepared ones; below the standstill speed they fade as these do.
    pub friction: Option<&'a [f64]>,
    /// Diagonal compliance (n) [m/Pa] at this step, as
    /// [`SlidingContact::diagonal`](crate::sliding::SlidingContact::diagonal).
    pub diagonal: Option<&'a [f64]>,
}

/// A prepared contact with the memory of its last step.
pub struct PreparedContact {
    prepared: Arc<Prepared>,
    stepper: SlidingStepper,
    pull: Option<Vec<f64>>,
    taken: Option<Arc<Taken>>,
    stuck: Option<Arc<StuckStep>>,
    jacobian: Option<Jacobian>,
    past: Option<Past>,
    inverse: KeptInverse,
}

impl Prepared {
    /// The contact of a problem.
    ///
    /// `loading` is what presses the bodies besides the magnetic pressure; `named` gives each free motion of the
    /// problem its name and the component of the pose (0 to 5) that takes its place when prescribed.
    ///
    /// # Errors
    /// Parts that do not belong together, numbers that are not finite, more points than the memory holds, an
    /// interruption.
    pub fn new(
        problem: &Problem,
        loading: &Loading,
        magnetic: Option<&Magnetic<'_>>,
        named: Vec<(String, Option<usize>)>,
        sliding: Sliding,
        reference_point: [f64; 3],
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let (n, motions) = (problem.points(), problem.motions());
        if named.len() != motions.len() {
            return Err(Error::Shape {
                name: "names of motions",
                expected: motions.len(),
                found: named.len(),
            });
        }
        if loading.diagonal.is_some() {
            return Err(Error::NoDiagonal);
        }
        let row = |loading: Loading| ([loading.gap, loading.work].concat(), loading.along);
        let (base, base_along) = row(loading.clone());
        let mut loads = Table::constant(base.clone());
        let mut bodies = Bodies {
            pair: OnDemand::of_pair(problem.pair().clone(), sliding.layer),
            loads: Table::constant(base_along.clone()),
            magnetic: None,
            pulled: None,
        };
        let (mut parts, mut magnet, mut pull) = (None, None, None);
        if let Some(Magnetic {
            bodies: pulled,
            source,
        }) = magnetic
        {
            let (own, along) = Pulled::of(problem, pulled)?;
            (pull, bodies.pulled) = (Some(own), along);
            let nothing = Table::constant(vec![0.0; n]);
            let pressure = match source {
                Source::Pressure(pressure) => Some(pressure),
                Source::Magnet(own) => {
                    magnet = Some(own.clone());
                    Some(&nothing)
                }
                Source::Steps => None,
            };
            if let Some(pressure) = pressure {
                let speed = pressure.speed();
                let rows = pressure.rows().iter();
                let rows: Result<Vec<_>, Error> = rows
                    .map(|p| Ok(row(problem.pulled(loading, pulled, p)?)))
                    .collect();
                let (rows, along): (Vec<_>, Vec<_>) = rows?.into_iter().unzip();
                loads = Table::new(speed.to_vec(), rows)?;
                bodies.loads = Table::new(speed.to_vec(), along)?;
                let nothing = problem.unloaded(vec![0.0; n]);
                let (unit, unit_along) = row(problem.pulled(&nothing, pulled, &vec![1.0; n])?);
                parts = Some([base, unit]);
                bodies.magnetic = Some([base_along, unit_along]);
            }
        }
        let motions = motions.iter().zip(named);
        let prepared = Self {
            influence: Arc::new(Influence::of(problem.pair(), monitor)?),
            bodies: Some(bodies),
            geometry: (**problem.geometry()).clone(),
            motions: motions
                .map(|(free, (name, component))| NamedMotion {
                    name,
                    motion: free.motion.clone(),
                    component,
                })
                .collect(),
            friction: sliding.friction,
            loads,
            magnetic: parts,
            magnet,
            pulled: pull,
            sliding_direction: sliding.direction,
            reference_point,
            standstill_speed: sliding.standstill_speed,
            velocity: sliding.velocity,
            interface: problem.interface().clone(),
        };
        prepared.check()?;
        Ok(prepared)
    }

    /// Checks that all parts belong together.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite.
    pub fn check(&self) -> Result<(), Error> {
        let n = self.influence.points();
        let g = &self.geometry;
        check("area", &g.area, n)?;
        g.check()?;
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
        if let Some(magnet) = &self.magnet {
            magnet.check(n)?;
        }
        if let Some(pulled) = &self.pulled {
            pulled.check(n, self.motions.len())?;
        }
        if let Some(bodies) = &self.bodies {
            bodies.check(n)?;
        }
        self.interface.check(n)?;
        check("sliding_direction", &self.sliding_direction, 2)?;
        check("reference_point", &self.reference_point, 3)
    }

    /// Friction coefficients and sliding directions (2n) at a velocity.
    fn sliding(
        &self,
        velocity: [f64; 2],
        given: Option<&[f64]>,
    ) -> Result<(Vec<f64>, Vec<f64>), Error> {
        let n = self.influence.points();
        let speed = velocity[0].hypot(velocity[1]);
        let mut friction = self.coefficients(speed, given)?;
        let share = self.share(velocity);
        for mu in &mut friction {
            *mu *= share;
        }
        if speed == 0.0 {
            if friction.iter().any(|mu| *mu != 0.0) {
                return Err(Error::Standstill);
            }
            return Ok((friction, vec![0.0; 2 * n]));
        }
        Ok((friction, self.geometry.sliding_direction(velocity)?))
    }

    /// Friction coefficients (n) at a speed, or those `given`.
    fn coefficients(&self, speed: f64, given: Option<&[f64]>) -> Result<Vec<f64>, Error> {
        match given {
            Some(given) => Ok(given.to_vec()),
            None => self.friction.at("friction", speed),
        }
    }

    /// Share of the friction coefficients that acts at a velocity: less than 1 below the standstill speed.
    pub fn share(&self, velocity: [f64; 2]) -> f64 {
        let speed = velocity[0].hypot(velocity[1]);
        self.standstill_speed
            .map_or(1.0, |slow| (speed / slow).min(1.0))
    }

    /// Displacement (3n) [m] of the points of the upper body by the prescribed components of a pose; `None` if there is none.
    fn moved(&self, pose: &[f64; 6]) -> Result<Option<Vec<f64>>, Error> {
        let known = pose.map(|v| if v.is_nan() { 0.0 } else { v });
        if known == [0.0; 6] {
            return Ok(None);
        }
        let far = |component: usize, largest: f64| Error::NotSmall {
            component: POSE[component],
            value: known[component],
            largest,
        };
        if let Some(component) = (3..6).find(|&k| known[k].abs() > STEEPEST) {
            return Err(far(component, STEEPEST));
        }
        let extent = self.extent();
        if known[2] < -extent {
            return Err(far(2, extent));
        }
        // along a face that turns, gaps are those of small displacements; along a plane one nothing changes
        for component in 0..2 {
            let largest = 0.5 * self.edge(component);
            if known[component].abs() > largest && self.turns(component) {
                return Err(far(component, largest));
            }
        }
        let turn = rotation(known[3], known[4], known[5]);
        let n = self.geometry.points();
        let mut moved = vec![0.0; 3 * n];
        for i in 0..n {
            let x = Geometry::vector(&self.geometry.points, i);
            for c in 0..3 {
                let mut u = known[c];
                for k in 0..3 {
                    let unit = if c == k { 1.0 } else { 0.0 };
                    u += (turn[c][k] - unit) * (x[k] - self.reference_point[k]);
                }
                moved[c * n + i] = u;
            }
        }
        Ok(Some(moved))
    }

    /// Adds the opening of each gap by a displacement (3n) [m] of the upper body.
    fn open(&self, moved: &[f64], gap: &mut [f64]) {
        for (i, gap) in gap.iter_mut().enumerate() {
            let normal = Geometry::vector(&self.geometry.mean_frame[2], i);
            let u = Geometry::vector(moved, i);
            for c in 0..3 {
                *gap += normal[c] * u[c];
            }
        }
    }

    /// The motions with these numbers, under their work out of that of all (m) [J].
    fn balanced(&self, numbers: &[usize], work: &[f64]) -> Vec<RigidMotion> {
        let motion = |&k: &usize| RigidMotion {
            work: work[k],
            ..self.motions[k].motion.clone()
        };
        numbers.iter().map(motion).collect()
    }

    /// Longest edge [m] of the box round the contact points, and of the largest of them.
    fn extent(&self) -> f64 {
        (0..3).map(|axis| self.edge(axis)).fold(0.0, f64::max)
    }

    /// Edge [m] of that box along an axis.
    fn edge(&self, axis: usize) -> f64 {
        let g = &self.geometry;
        let n = g.points();
        let cell = g.area.iter().copied().fold(0.0, f64::max).sqrt();
        let along = &g.points[axis * n..(axis + 1) * n];
        let high = along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let low = along.iter().copied().fold(f64::INFINITY, f64::min);
        cell.max(high - low)
    }

    /// Whether a displacement along an axis opens or closes a gap.
    fn turns(&self, axis: usize) -> bool {
        let n = self.geometry.points();
        let normals = &self.geometry.mean_frame[2][axis * n..(axis + 1) * n];
        normals.iter().any(|normal| normal.abs() > PLANE)
    }
}

impl PreparedContact {
    /// A contact that has taken no step yet; several may share what is prepared.
    pub fn new(prepared: Arc<Prepared>) -> Self {
        let stepper = SlidingStepper::new(prepared.influence.clone());
        let inverse = KeptInverse::at(&prepared.geometry.points);
        Self {
            prepared,
            stepper,
            pull: None,
            taken: None,
            stuck: None,
            jacobian: None,
            past: None,
            inverse,
        }
    }

    /// What is prepared.
    pub fn prepared(&self) -> &Arc<Prepared> {
        &self.prepared
    }

    /// Takes `pressure` (n), `motion` and the `pull` (n) [Pa] of a magnet for the last step's, in place of what it
    /// remembers; without a pull a magnet starts from the gaps of the step. Tractions are forgotten, unless
    /// [`PreparedContact::remember`] follows.
    ///
    /// # Errors
    /// A wrong length, numbers that are not finite, pressures below 0.
    pub fn resume(
        &mut self,
        pressure: &[f64],
        motion: &[f64],
        pull: Option<&[f64]>,
    ) -> Result<(), Error> {
        if let Some(pull) = pull {
            self.check_pull(pull)?;
        }
        check_size("state", pressure)?;
        check_size("state", motion)?;
        if let Some(index) = pressure.iter().position(|p| *p < 0.0) {
            return Err(Error::Negative {
                name: "state",
                index,
                value: pressure[index],
            });
        }
        self.stepper.resume(pressure, motion)?;
        self.pull = pull.map(<[f64]>::to_vec);
        self.past = None;
        Ok(())
    }

    /// Takes a `pull` (n) [Pa] for that of the last step under a magnet whose pull follows the gap.
    ///
    /// # Errors
    /// A wrong length, numbers that are not finite or below 0; [`Error::NoMagnet`].
    pub fn resume_pull(&mut self, pull: &[f64]) -> Result<(), Error> {
        if self.prepared.magnet.is_none() {
            return Err(Error::NoMagnet);
        }
        self.check_pull(pull)?;
        self.pull = Some(pull.to_vec());
        Ok(())
    }

    /// The pull (n) [Pa] of the last step that was solved under a magnet whose pull follows the gap.
    pub fn pull(&self) -> Option<&[f64]> {
        self.pull.as_deref()
    }

    fn check_pull(&self, pull: &[f64]) -> Result<(), Error> {
        check("pull", pull, self.prepared.influence.points())?;
        check_size("pull", pull)?;
        match pull.iter().position(|p| *p < 0.0) {
            None => Ok(()),
            Some(index) => Err(Error::Negative {
                name: "pull",
                index,
                value: pull[index],
            }),
        }
    }

    /// Solves one step: all points slide, or with a [shift](Step::shift) stick or slip.
    ///
    /// # Errors
    /// Numbers that are not finite, or too large for a finite result; [`Error::SnapsShut`]; a pose that is not small: a rotation above
    /// 0.5 rad, a z deeper than the contact is long; a speed outside the tables; friction at rest without a standstill speed;
    /// pressure at the edge of a grid beyond which the bodies go on; an interruption. That no sliding state exists (wedging) is a status of the solution.
    pub fn step(&mut self, step: &Step<'_>, monitor: Monitor<'_>) -> Result<Outcome, Error> {
        let prepared = self.prepared.clone();
        let (n, m) = (prepared.influence.points(), prepared.motions.len());
        let pose = step.pose.map(|v| if v.is_nan() { 0.0 } else { v });
        check_size("pose", &pose)?;
        check_size("velocity", &step.velocity)?;
        if let Pull::Uniform(pressure) = step.pull {
            check_size("magnetic_pressure", &[pressure])?;
        }
        let circuit;
        let following = match (step.pull, &prepared.magnet) {
            (Pull::Following(following), _) => Some(following),
            (Pull::Scene, Some(own)) => Some(own.at(&own.circuit, step.velocity)?),
            (Pull::AmpereTurns(ampere_turns), Some(own)) => {
                check_size("ampere_turns", &[ampere_turns])?;
                circuit = own.circuit.with_ampere_turns(ampere_turns)?;
                Some(own.at(&circuit, step.velocity)?)
            }
            (Pull::AmpereTurns(_), None) => return Err(Error::NoMagnet),
            _ => None,
        };
        let following = match following {
            None => None,
            Some(following) => Some((following, prepared.faces(monitor)?)),
        };
        if let Some(friction) = step.friction {
            check("friction", friction, n)?;
        }
        let rubbing = match step.shift {
            None => prepared.sliding(step.velocity, step.friction)?,
            Some(shift) => {
                check_size("shift", &shift)?;
                let [x, y] = step.velocity;
                let friction = prepared.coefficients(x.hypot(y), step.friction)?;
                (friction, Vec::new())
            }
        };
        let mut gap = match step.pull {
            Pull::Scene => {
                let [x, y] = step.velocity;
                prepared.loads.at("magnetic_pressure", x.hypot(y))?
            }
            // in place of the scene's own pull
            Pull::Following(_) | Pull::AmpereTurns(_) => match &prepared.magnetic {
                Some([base, _]) => base.clone(),
                None => prepared.loads.at("magnetic_pressure", 0.0)?,
            },
            Pull::Uniform(pressure) => {
                let [base, unit] = prepared.magnetic.as_ref().ok_or(Error::NotMagnetic)?;
                base.iter()
                    .zip(unit)
                    .map(|(b, u)| b + pressure * u)
                    .collect()
            }
            Pull::Given(given) => {
                check("gap", &given.gap, n)?;
                check("work", &given.work, m)?;
                [&*given.gap, &*given.work].concat()
            }
        };
        let work = gap.split_off(n);
        let along = prepared.along(&step.pull, step.velocity)?;
        let moved = prepared.moved(&step.pose)?;
        if let Some(moved) = &moved {
            prepared.open(moved, &mut gap);
        }
        if let Some(added) = step.gap {
            check("gap", added, n)?;
            gap.iter_mut()
                .zip(added)
                .for_each(|(gap, added)| *gap += added);
        }
        let balanced: Vec<usize> = (0..m)
            .filter(|&k| {
                let component = prepared.motions[k].component;
                component.is_none_or(|c| step.pose[c].is_nan())
            })
            .collect();
        // of a step that was not solved nothing is kept
        let from = following.as_ref().and(self.pull.clone());
        let loading = Loading {
            gap,
            work,
            along,
            diagonal: step.diagonal.map(<[f64]>::to_vec),
        };
        let mut placed = prepared.placed(moved.as_deref());
        let way = match step.shift {
            None => None,
            Some(shift) => Some(self.way(shift, &rubbing.0, &placed, monitor)?),
        };
        let mut along = Vec::new();
        let mut solve = |loading: &Loading| {
            along.clone_from(&loading.along);
            match &way {
                None => self.solve(loading, &balanced, &rubbing, monitor),
                Some(way) => self.stick_or_slip(loading, &balanced, way, monitor),
            }
        };
        let mut outcome = match &following {
            Some((
                Following {
                    circuit, factor, ..
                },
                faces,
            )) => {
                let from = circuit.first_pull(*factor, &loading, from)?;
                settle(circuit, *factor, from, |pull| {
                    solve(&faces.pulled(&loading, pull))
                })?
            }
            None => solve(&loading)?,
        };
        let by_velocity = prepared.power_by_velocity(&outcome.traction);
        if step.shift.is_none() {
            outcome.friction_power =
                by_velocity[0] * step.velocity[0] + by_velocity[1] * step.velocity[1];
        }
        if let Pull::Uniform(pressure) = step.pull {
            outcome.magnetic_pressure = Some(pressure);
        }
        if let Err(error) = outcome.check() {
            // what is not finite must not start the next step
            self.stepper = SlidingStepper::new(prepared.influence.clone());
            self.pull = None;
            return Err(error);
        }
        (self.taken, self.stuck, self.jacobian) = (None, None, None);
        if outcome.solution.status == Status::Solved {
            (prepared.geometry).check_edge(&outcome.solution.pressure)?;
            let linearised = |gap: &[f64]| match &following {
                Some((following, faces)) => {
                    let pulling = following.pulling(faces, gap, &balanced)?;
                    Ok::<_, Error>(Some((pulling, following.by_speed, faces)))
                }
                None => Ok(None),
            };
            if let Some(way) = &way {
                let magnet = linearised(&outcome.solution.gap)?
                    .map(|(pulling, by_speed, faces)| (faces.sticking(pulling), by_speed));
                self.stuck = self.stuck_step(step, &loading, &balanced, way, &outcome, magnet)?;
            }
            if prepared.bodies.is_some() {
                for (placed, along) in placed.iter_mut().zip(&along) {
                    *placed += along;
                }
                let rigid = prepared.rigid(placed, &balanced, &outcome.solution.motion);
                self.past = Some(Past::of(&mut outcome, rigid.clone()));
                outcome.rigid = Some(rigid);
            }
            if let Some(settled) = &outcome.settled {
                self.pull = Some(settled.pull.clone());
            }
            if step.shift.is_none() {
                let motions = prepared.balanced(&balanced, &loading.work);
                let magnet = linearised(&outcome.solution.gap)?
                    .map(|(pulling, by_speed, _)| (pulling, by_speed));
                self.taken = Some(Arc::new(Taken::new(
                    &prepared, step, &outcome, rubbing.1, motions, balanced, magnet,
                )));
            }
        }
        Ok(outcome)
    }

    /// The sliding state under a loading, with some of the motions found from balance and with `friction` (n) in
    /// a `direction` (2n).
    fn solve(
        &mut self,
        loading: &Loading,
        balanced: &[usize],
        (friction, direction): &(Vec<f64>, Vec<f64>),
        monitor: Monitor<'_>,
    ) -> Result<Outcome, Error> {
        let prepared = &*self.prepared;
        let contact = SlidingContact {
            gap: &loading.gap,
            area: &prepared.geometry.area,
            friction,
            direction,
            motions: &prepared.balanced(balanced, &loading.work),
            diagonal: loading.diagonal.as_deref(),
            interface: Some(&prepared.interface),
        };
        let (solution, effort) = self.stepper.solve(&contact, monitor)?;
        let about = prepared.reference_point;
        let friction = prepared
            .interface
            .coefficients(friction.clone(), &solution.pressure);
        let mut outcome =
            Outcome::sliding(&prepared.geometry, about, solution, friction, direction);
        outcome.effort = effort;
        Ok(outcome)
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

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Derivatives of a step by what was given.
//!
//! Pressures follow from the gap, tractions from pressures and creepages, by the equations of the solved problems
//! with their cells in contact, in stick and in slip held. The gap, the contact plane and the creepages follow from
//! the pose, and are derived as they were computed: the grid goes with its plane. What was found from balance follows
//! all that was given, so that the wheels carry the same force.
//!
//! What a transient step has taken over stays as it is in the patches of the step before; where those lie now follows
//! the pose. A change of the step before is handed on from step to step: derivatives of a chain go forward, as those
//! of one step do, because wheels are given few numbers and have many cells.

use std::fmt::{Debug, Formatter};
use std::sync::{Arc, OnceLock};

use mtb_contact::friction::Friction;
use mtb_elasticity::half_space::Pair;
use mtb_operator::Monitor;
use nalgebra::{DMatrix, DVector, Vector3};

use crate::equilibrium::Unknown;
use crate::error::Error;
use crate::friction::WheelFriction;
use crate::linear::{Given, PatchLinear, WheelMotion};
use crate::memory::Frame;
use crate::moduli::ByModulus;
use crate::prepared::{AxleLoad, Ready, Velocity, rotation, turning};
use crate::rolling::out_of_mirror;
use crate::track::{Alignment, Place, index, sign};
use crate::wheelset::Side;

/// What the derivatives of a step are by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WheelInput {
    /// x, y, z [m], roll, pitch, yaw [rad]; 0 for components that were found from balance.
    Pose,
    /// The speed [m/s], or the six components [m/s], [rad/s], as it was given.
    Velocity,
    /// The coefficient of a Coulomb law, those of a friction map, or the parameters of another law: the coefficients
    /// at rest and of sliding, or those of [`SlipLaw::parameters`] or [`TemperatureLaw::parameters`], then distance [m] and slip
    /// speed [m/s] of a memory.
    ///
    /// [`SlipLaw::parameters`]: mtb_contact::friction::SlipLaw::parameters
    /// [`TemperatureLaw::parameters`]: mtb_contact::temperature::TemperatureLaw::parameters
    ///
    /// That of the left wheel alone where the right one has its own.
    Friction,
    /// The same of the friction that the right wheel has of its own; none where it has not.
    RightFriction,
    /// The vertical force of each wheel [N], friction included; 0 where the height was given.
    Force,
    /// The lateral force of all wheels that y was found for [N]; none where y was given.
    LateralForce,
    /// The force along x [N], or the moment [N m], that the rotation about the axle was found from; none where it was
    /// given.
    AxleLoad,
    /// Curvature of the track [1/m]; then y, z [m] and rotation [rad] of the left rail and their rates, those of the
    /// right one; x, y, z [m], rotation about x, y, z [rad] of the left wheel and their rates, and those of the right
    /// one: the numbers of an [`Alignment`], 37 of them. Those of a side without a wheel change nothing, nor does the
    /// curvature on rollers.
    Alignment,
    /// Time since the last step of a transient one [s]; none of a steady one.
    Duration,
    /// Lateral and vertical stiffness of the springs of the rails [N/m], then the force on them outwards and upwards
    /// [N]; none where rails have no springs.
    Springs,
    /// Thickness over shear modulus of the layer [m/Pa].
    Layer,
    /// Shear modulus [Pa], and Poisson's ratio at that shear modulus, of the rail, then of the wheel; a rigid body has
    /// none.
    Moduli,
}

/// Change of a step by a unit of one of the numbers that were given.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WheelChange {
    /// Of [`WheelStep::force`](crate::WheelStep::force) [N].
    pub force: [f64; 3],
    /// Of [`WheelStep::moment`](crate::WheelStep::moment), about the reference point, which moves with the pose [N m].
    pub moment: [f64; 3],
    /// Of [`WheelStep::vertical_force`](crate::WheelStep::vertical_force) [N].
    pub vertical_force: [f64; 2],
    /// Of the pose, with what is found from balance [m], [rad].
    pub pose: [f64; 6],
    /// Of the velocity [m/s] and the rotation [rad/s], with what is found from the load of the axle.
    pub velocity: [f64; 6],
    /// Of the displacement along y and z of the left and of the right rail, with what their springs give [m].
    pub rail_displacement: [[f64; 2]; 2],
    /// Of the heat of sliding [W].
    pub friction_power: f64,
    /// Of the patches, in their order.
    pub patches: Vec<PatchChange>,
}

/// Change of a [`WheelPatch`](crate::WheelPatch); fields on its grid, which goes with the plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchChange {
    /// Of the origin of the frame [m].
    pub position: [f64; 3],
    /// Of the slope of the contact plane [rad].
    pub contact_angle: f64,
    /// Of the origin on the rail profile [m].
    pub rail_position: f64,
    /// Of the origin on the wheel profile [m].
    pub wheel_position: f64,
    /// Of the approach [m].
    pub approach: f64,
    /// Of the creepages [-], [-], [1/m].
    pub creepage: [f64; 3],
    /// Of the rolling speed [m/s].
    pub rolling_speed: f64,
    /// Of the force on the rail, in the track [N].
    pub force: [f64; 3],
    /// Of the pressure (n) [Pa].
    pub pressure: Vec<f64>,
    /// Of the traction (2n) [Pa].
    pub traction: Vec<f64>,
    /// Of the slip velocity (2n) [m/s].
    pub slip_velocity: Vec<f64>,
    /// Of the coefficient of friction in contact (n) [-].
    pub coefficient: Vec<f64>,
    /// Of [`PatchHistory::position`](crate::PatchHistory::position), as of a left wheel [m].
    pub origin: [f64; 3],
    /// Of the heat of sliding [W].
    pub friction_power: f64,
}

/// How far the points of a step are from another state, beyond which derivatives are others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelMargin {
    /// Smallest pressure in contact, over the largest one.
    pub parting: f64,
    /// Smallest gap beside the contact, over the approach; of a lifted wheel over the one that may carry its force.
    pub touching: f64,
    /// Smallest distance of the traction from its bound where points stick, over the largest bound; 1 where none does.
    pub slipping: f64,
    /// Smallest slip where points slip, over the largest one; 1 where none does.
    pub sticking: f64,
}

/// The equations of a solved step, linearised about it. Copies share what they hold.
#[derive(Clone)]
pub struct WheelTangent {
    pub(crate) ready: Arc<Ready>,
    /// The place with what was found, and what that is.
    pub(crate) place: Place,
    pub(crate) found: Vec<Unknown>,
    /// Displacements of the rails by their springs.
    pub(crate) on_springs: [[f64; 2]; 2],
    pub(crate) axle_load: Option<AxleLoad>,
    /// The velocity as it was given, and with what was found.
    pub(crate) velocity: Velocity,
    pub(crate) rigid: [f64; 6],
    /// Force on the rails and moment about the reference point.
    pub(crate) load: [Vector3<f64>; 2],
    /// Of a transient step [s].
    pub(crate) duration: Option<f64>,
    /// As of the step.
    pub(crate) balance_error: Option<f64>,
    pub(crate) patches: Vec<Arc<PatchLinear>>,
    /// Marks of the state that a transient step has rolled on from, and of the one that is left.
    pub(crate) began: Option<u64>,
    pub(crate) left: u64,
    /// Changes by a unit of each number that was found, once they are known.
    pub(crate) free: OnceLock<Arc<Vec<WheelChange>>>,
}

impl Debug for WheelTangent {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("WheelTangent").finish_non_exhaustive()
    }
}

impl WheelTangent {
    /// Derivatives of the step by each number of an input: one linear solve of the pressures and one of the tractions
    /// a patch for each of them.
    ///
    /// # Errors
    /// Points whose state does not determine pressure or traction; a height that was found at a jump
    /// of the force; an interruption.
    ///
    /// # Example
    /// ```
    /// use mtb_elasticity::{Material, half_space::Pair};
    /// use mtb_geometry::{Profile, WheelOnRail};
    /// use mtb_operator::unmonitored;
    /// use mtb_wheelset::{PreparedWheels, Velocity, WheelInput, Wheelset};
    ///
    /// let pair = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    /// let steel = Some(Material::new(82e9, 0.28)?);
    /// let bodies = Pair { lower: steel, upper: steel };
    /// let wheelset = Wheelset { spacing: [2e-3; 2], ..Wheelset::new(pair, bodies, 60e3)? };
    /// let mut wheels = PreparedWheels::new(wheelset)?;
    /// let pose = [0.0, 1e-3, f64::NAN, 0.0, 0.0, 2e-3];
    /// let step = wheels.step(pose, Velocity::Rolling(20.0), &unmonitored)?;
    /// let by_pose = step.tangent.derivatives(WheelInput::Pose, &unmonitored)?;
    /// println!("{} N a millimetre to the side", 1e-3 * by_pose[1].force[1]);
    /// // the height follows, so that the wheel carries the same force
    /// assert!(by_pose[1].pose[2] != 0.0 && by_pose[2].pose[2] == 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn derivatives(
        &self,
        by: WheelInput,
        monitor: Monitor<'_>,
    ) -> Result<Vec<WheelChange>, Error> {
        self.refuse_jump()?;
        let changes = match by {
            WheelInput::Pose => (0..6)
                .map(|k| {
                    if self.is_found(k) {
                        return Ok(self.nothing());
                    }
                    self.by_pose(k, monitor)
                })
                .collect::<Result<Vec<_>, _>>()?,
            WheelInput::Velocity => self.by_velocity(monitor)?,
            WheelInput::Friction => {
                self.by_friction(Some(&self.ready.wheelset.friction), monitor)?
            }
            WheelInput::RightFriction => {
                self.by_friction(self.ready.wheelset.right_friction.as_ref(), monitor)?
            }
            WheelInput::LateralForce if !self.found.contains(&Unknown::Lateral) => Vec::new(),
            WheelInput::AxleLoad if self.axle_load.is_none() => Vec::new(),
            WheelInput::Springs if self.ready.wheelset.springs.is_none() => Vec::new(),
            WheelInput::Force | WheelInput::LateralForce | WheelInput::AxleLoad => {
                vec![self.nothing()]
            }
            WheelInput::Springs => vec![self.nothing(); 4],
            WheelInput::Alignment => self.by_alignment(monitor)?,
            WheelInput::Duration if self.duration.is_none() => Vec::new(),
            WheelInput::Duration => {
                let given = |_| Given {
                    duration: 1.0,
                    ..Given::default()
                };
                vec![self.changed(&given, monitor)?]
            }
            WheelInput::Layer => {
                let given = |_| Given {
                    layer: 1.0,
                    ..Given::default()
                };
                vec![self.changed(&given, monitor)?]
            }
            WheelInput::Moduli => self.by_moduli(monitor)?,
        };
        self.balanced(changes, &|unknown, k| self.wanted(unknown, by, k), monitor)
    }

    /// Changes of the step by `changes` of the step before, from whose state it has rolled on: what was given in this
    /// one stays. One linear solve of the tractions a patch and part of the way for each of them, and those of what was
    /// found. Nothing changes in a steady step, nor in patches that are new.
    ///
    /// Changes of a chain of steps by what was given in one of them follow one from the other.
    ///
    /// # Errors
    /// [`Error::OtherState`] if the step has rolled on from another state, [`Error::OtherChange`] for a change that is
    /// none of the step before; those of [`WheelTangent::derivatives`].
    ///
    /// # Example
    /// ```
    /// use mtb_elasticity::{Material, half_space::Pair};
    /// use mtb_geometry::{Profile, WheelOnRail};
    /// use mtb_operator::unmonitored;
    /// use mtb_wheelset::{PreparedWheels, StepInput, Velocity, WheelInput, Wheelset};
    ///
    /// let pair = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    /// let steel = Some(Material::new(82e9, 0.28)?);
    /// let bodies = Pair { lower: steel, upper: steel };
    /// let wheelset = Wheelset { spacing: [2e-3; 2], ..Wheelset::new(pair, bodies, 60e3)? };
    /// let mut wheels = PreparedWheels::new(wheelset)?;
    /// let mut pose = [0.0, 1e-3, f64::NAN, 0.0, 0.0, 2e-3];
    /// let first = wheels.step(pose, Velocity::Rolling(20.0), &unmonitored)?;
    /// pose[0] += 1e-3;
    /// let input = StepInput { duration: Some(5e-5), ..StepInput::new(pose, Velocity::Rolling(20.0)) };
    /// let second = wheels.step_of(&input, &unmonitored)?;
    /// let by_yaw = first.tangent.derivatives(WheelInput::Pose, &unmonitored)?.split_off(5);
    /// let later = second.tangent.after(&first.tangent, &by_yaw, &unmonitored)?;
    /// println!("{} N a milliradian of the yaw before", 1e-3 * later[0].force[1]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn after(
        &self,
        before: &Self,
        changes: &[WheelChange],
        monitor: Monitor<'_>,
    ) -> Result<Vec<WheelChange>, Error> {
        self.refuse_jump()?;
        if !self.follows(before) {
            return Err(Error::OtherState);
        }
        for (index, change) in changes.iter().enumerate() {
            before.check_change(index, change)?;
        }
        let columns = changes
            .iter()
            .map(|change| {
                let as_left = |(patch, by): (&Arc<PatchLinear>, &PatchChange)| match patch.side {
                    Side::Left => by.clone(),
                    Side::Right => by.clone().mirrored(patch.plane.nx),
                };
                let patches = before.patches.iter().zip(&change.patches);
                let as_left: Vec<PatchChange> = patches.map(as_left).collect();
                let given = |patch: usize| Given {
                    before: self.patches[patch].brought().map(|_| as_left.as_slice()),
                    ..Given::default()
                };
                self.changed(&given, monitor)
            })
            .collect::<Result<_, _>>()?;
        self.balanced(columns, &|_, _| 0.0, monitor)
    }

    /// Whether the step has rolled on from the state that another one has left, or is steady and rolls on from none.
    pub fn follows(&self, before: &Self) -> bool {
        self.began.is_none_or(|began| began == before.left)
    }

    /// The changes with what was found, such that its load is what is `wanted` of each of them.
    fn balanced(
        &self,
        mut changes: Vec<WheelChange>,
        wanted: &dyn Fn(Unknown, usize) -> f64,
        monitor: Monitor<'_>,
    ) -> Result<Vec<WheelChange>, Error> {
        if self.found.is_empty() || changes.is_empty() {
            return finite(changes);
        }
        let free = self.free(monitor)?;
        let mut matrix = DMatrix::from_columns(
            &(free.iter())
                .map(|change| self.carried(change))
                .collect::<Vec<_>>(),
        );
        for (k, unknown) in self.found.iter().enumerate() {
            matrix[(k, k)] -= self.stiffness(*unknown);
        }
        let matrix = matrix.lu();
        for (k, change) in changes.iter_mut().enumerate() {
            let wanted = (self.found.iter()).map(|unknown| wanted(*unknown, k));
            let wanted = DVector::from_iterator(self.found.len(), wanted);
            let moved = matrix
                .solve(&(wanted - self.carried(change)))
                .ok_or(mtb_contact::Error::Singular)?;
            for (share, free) in moved.iter().zip(free) {
                change.add(*share, free);
            }
        }
        finite(changes)
    }

    /// By a unit of each number that was found.
    fn free(&self, monitor: Monitor<'_>) -> Result<&[WheelChange], Error> {
        if let Some(known) = self.free.get() {
            return Ok(known);
        }
        let found = self.found.iter();
        let free = found.map(|unknown| self.by_unknown(*unknown, monitor));
        let free: Vec<WheelChange> = free.collect::<Result<_, _>>()?;
        Ok(self.free.get_or_init(|| Arc::new(free)))
    }

    fn check_change(&self, index: usize, change: &WheelChange) -> Result<(), Error> {
        let fits = |(patch, by): (&Arc<PatchLinear>, &PatchChange)| {
            let n = patch.pressure.len();
            let single = [&by.pressure, &by.coefficient];
            single.iter().all(|field| field.len() == n) && by.traction.len() == 2 * n
        };
        let mut patches = self.patches.iter().zip(&change.patches);
        if self.patches.len() == change.patches.len() && patches.all(fits) {
            return Ok(());
        }
        Err(Error::OtherChange {
            index,
            points: change.patches.iter().map(|by| by.pressure.len()).collect(),
            wanted: self.patches.iter().map(|p| p.pressure.len()).collect(),
        })
    }

    /// The load that the rotation about the axle was found from.
    pub fn axle_load(&self) -> Option<AxleLoad> {
        self.axle_load
    }

    /// How far the points of the step are from another state.
    pub fn margin(&self) -> WheelMargin {
        let mut margin = WheelMargin {
            parting: 1.0,
            touching: f64::INFINITY,
            slipping: 1.0,
            sticking: 1.0,
        };
        for patch in &self.patches {
            patch.narrow(&mut margin);
        }
        let wheelset = &self.ready.wheelset;
        for side in wheelset.sides.each() {
            if self.patches.iter().any(|patch| patch.side == *side) {
                continue;
            }
            // a wheel beside its rail is far from it
            if let Ok(overlap) = self
                .ready
                .over(*side)
                .overlap(self.ready.axle(*side, &self.place))
            {
                margin.touching = margin.touching.min(-overlap / wheelset.approach);
            }
        }
        margin
    }
}

/// Departure of the carried force from the one asked for, over the error accepted, that tells of a jump.
const OF_JUMP: f64 = 100.0;

impl WheelTangent {
    fn nothing(&self) -> WheelChange {
        let patches = self
            .patches
            .iter()
            .map(|patch| PatchChange::none(patch))
            .collect();
        WheelChange {
            patches,
            ..WheelChange::default()
        }
    }

    /// At a jump the position follows the jump, and not the force.
    fn refuse_jump(&self) -> Result<(), Error> {
        let Some(error) = self.balance_error else {
            return Ok(());
        };
        if error.abs() <= OF_JUMP * self.ready.accuracy.force {
            return Ok(());
        }
        Err(Error::AtJump { error })
    }

    /// Whether a component of the pose was found.
    fn is_found(&self, component: usize) -> bool {
        let mut found = self.found.iter();
        found.any(|unknown| unknown.component() == Some(component))
    }

    /// Change of the load that an unknown is found from, with all forces of the springs held.
    fn carried(&self, change: &WheelChange) -> DVector<f64> {
        let [left, right] = change.vertical_force;
        let is_each = self.found.contains(&Unknown::Roll);
        let loads = self.found.iter().map(|unknown| match *unknown {
            Unknown::Height if is_each => left,
            Unknown::Height => left + right,
            Unknown::Roll => right,
            Unknown::Lateral => change.force[1],
            Unknown::Rotation => match self.axle_load {
                Some(AxleLoad::Moment(_)) => self.axle_moment(change),
                _ => change.force[0],
            },
            Unknown::Rail(side, c) => {
                let patches = self.patches.iter().zip(&change.patches);
                let own = patches.filter(|(patch, _)| patch.side == side);
                own.map(|(_, change)| change.force[1 + c]).sum()
            }
        });
        DVector::from_iterator(self.found.len(), loads)
    }

    /// What a unit of a rail takes of its load.
    fn stiffness(&self, unknown: Unknown) -> f64 {
        match (unknown, &self.ready.wheelset.springs) {
            (Unknown::Rail(_, c), Some(springs)) => springs.stiffness[c],
            _ => 0.0,
        }
    }

    /// Change of the load that an unknown is found from by a unit of what was given.
    fn wanted(&self, unknown: Unknown, by: WheelInput, k: usize) -> f64 {
        let sides = self.ready.wheelset.sides.each().len() as f64;
        match (unknown, by) {
            (Unknown::Height | Unknown::Roll, WheelInput::Force)
                if self.found.contains(&Unknown::Roll) =>
            {
                1.0
            }
            (Unknown::Height, WheelInput::Force) => sides,
            (Unknown::Lateral, WheelInput::LateralForce)
            | (Unknown::Rotation, WheelInput::AxleLoad) => 1.0,
            (Unknown::Rail(side, c), WheelInput::Springs) if k == c => {
                self.on_springs[index(side)][c]
            }
            (Unknown::Rail(side, 0), WheelInput::Springs) if k == 2 => -sign(side),
            (Unknown::Rail(_, 1), WheelInput::Springs) if k == 3 => -1.0,
            _ => 0.0,
        }
    }

    /// Change of the moment of the forces on the rails about the axle.
    fn axle_moment(&self, change: &WheelChange) -> f64 {
        let [force, moment] = self.load;
        let (by_force, by_moment) = (Vector3::from(change.force), Vector3::from(change.moment));
        let turn = rotation(&self.place.pose);
        let by_turn = turning(&self.place.pose, &change.pose);
        let (arm, by_arm) = (turn * self.ready.arm(), by_turn * self.ready.arm());
        let about = moment - arm.cross(&force);
        let by_about = by_moment - by_arm.cross(&force) - arm.cross(&by_force);
        by_turn.column(1).dot(&about) + turn.column(1).dot(&by_about)
    }

    /// By one component of the pose, all others held.
    fn by_pose(&self, k: usize, monitor: Monitor<'_>) -> Result<WheelChange, Error> {
        let mut motion = WheelMotion::default();
        motion.place.pose[k] = 1.0;
        // what is about the axle turns with it
        let axle = rotation(&self.place.pose).column(1).into_owned();
        let spin = |rigid: &[f64; 6]| Vector3::new(rigid[3], rigid[4], rigid[5]);
        let given = match &self.velocity {
            Velocity::Rolling(_) => Vector3::zeros(),
            Velocity::Rigid(rigid) => spin(rigid),
        };
        let rate = axle.dot(&(spin(&self.rigid) - given));
        let by_axle = turning(&self.place.pose, &motion.place.pose).column(1) * rate;
        motion.rigid[3..].copy_from_slice(by_axle.as_slice());
        self.moved(&motion, monitor)
    }

    fn by_velocity(&self, monitor: Monitor<'_>) -> Result<Vec<WheelChange>, Error> {
        let directions: Vec<[f64; 6]> = match self.velocity {
            Velocity::Rolling(_) => {
                let axle = rotation(&self.place.pose).column(1) / self.ready.rolling_radius;
                vec![[1.0, 0.0, 0.0, axle[0], axle[1], axle[2]]]
            }
            Velocity::Rigid(_) => (0..6)
                .map(|k| {
                    let mut rigid = [0.0; 6];
                    rigid[k] = 1.0;
                    rigid
                })
                .collect(),
        };
        let column = |rigid: [f64; 6]| {
            let motion = WheelMotion {
                rigid,
                ..WheelMotion::default()
            };
            self.moved(&motion, monitor)
        };
        directions.into_iter().map(column).collect()
    }

    /// By the numbers of an alignment, in the order of [`WheelInput::Alignment`].
    fn by_alignment(&self, monitor: Monitor<'_>) -> Result<Vec<WheelChange>, Error> {
        (0..Alignment::NUMBERS)
            .map(|k| {
                if k == 0 && self.ready.wheelset.pair.roller_radius.is_some() {
                    // refused on rollers
                    return Ok(self.nothing());
                }
                let mut motion = WheelMotion::default();
                *motion.place.alignment.number(k) = 1.0;
                self.moved(&motion, monitor)
            })
            .collect()
    }

    /// By a unit of what was found.
    fn by_unknown(&self, unknown: Unknown, monitor: Monitor<'_>) -> Result<WheelChange, Error> {
        let mut motion = WheelMotion::default();
        match unknown {
            Unknown::Rotation => {
                let axle = rotation(&self.place.pose).column(1).into_owned();
                motion.rigid[3..].copy_from_slice(axle.as_slice());
            }
            Unknown::Rail(side, c) => {
                motion.place.alignment.rails[index(side)].place[c] = 1.0;
            }
            Unknown::Height => return self.by_pose(2, monitor),
            Unknown::Roll => return self.by_pose(3, monitor),
            Unknown::Lateral => return self.by_pose(1, monitor),
        }
        self.moved(&motion, monitor)
    }

    /// By a change of place and motion, with nothing found.
    fn moved(&self, motion: &WheelMotion, monitor: Monitor<'_>) -> Result<WheelChange, Error> {
        let given = |patch: usize| Given {
            motion: motion.of_side(self.patches[patch].side),
            ..Given::default()
        };
        let mut column = self.changed(&given, monitor)?;
        column.pose = motion.place.pose;
        column.velocity = motion.rigid;
        let rails = motion.place.alignment.rails;
        column.rail_displacement = rails.map(|rail| [rail.place[0], rail.place[1]]);
        Ok(column)
    }

    /// By the parameters of a friction, which those wheels notice that have it.
    fn by_friction(
        &self,
        friction: Option<&WheelFriction>,
        monitor: Monitor<'_>,
    ) -> Result<Vec<WheelChange>, Error> {
        let wheelset = &self.ready.wheelset;
        (0..friction.map_or(0, friction_parameters))
            .map(|k| {
                let given = |patch: usize| {
                    let own = wheelset.friction_of(self.patches[patch].side);
                    Given {
                        friction: friction.filter(|f| std::ptr::eq(*f, own)).map(|_| k),
                        ..Given::default()
                    }
                };
                self.changed(&given, monitor)
            })
            .collect()
    }

    fn by_moduli(&self, monitor: Monitor<'_>) -> Result<Vec<WheelChange>, Error> {
        let Pair { lower, upper } = self.ready.wheelset.bodies;
        let of_patches = self.patches.iter().map(|patch| patch.by_moduli(self));
        let of_patches: Vec<Vec<ByModulus>> = of_patches.collect::<Result<_, _>>()?;
        (0..2 * lower.iter().chain(&upper).count())
            .map(|k| {
                let given = |patch: usize| Given {
                    modulus: Some(&of_patches[patch][k]),
                    ..Given::default()
                };
                self.changed(&given, monitor)
            })
            .collect()
    }

    /// By one change of what each patch is given, with the height held.
    fn changed<'a>(
        &self,
        given: &dyn Fn(usize) -> Given<'a>,
        monitor: Monitor<'_>,
    ) -> Result<WheelChange, Error> {
        let mut whole = self.nothing();
        for (k, patch) in self.patches.iter().enumerate() {
            let given = given(k);
            if given.is_nothing() {
                continue;
            }
            let found = patch.changed(self, &given, monitor)?;
            let side = usize::from(patch.side == Side::Right);
            for c in 0..3 {
                whole.force[c] += found.change.force[c];
                whole.moment[c] += found.moment[c];
            }
            whole.vertical_force[side] -= found.change.force[2];
            whole.friction_power += found.change.friction_power;
            whole.patches[k] = found.change;
        }
        Ok(whole)
    }
}

/// The changes, whose numbers are finite.
fn finite(columns: Vec<WheelChange>) -> Result<Vec<WheelChange>, Error> {
    for change in &columns {
        let of_patches = change.patches.iter().flat_map(|p| [&p.force, &p.creepage]);
        let vectors = of_patches.chain([&change.force, &change.moment]).flatten();
        let mut all = vectors.chain([&change.friction_power]);
        if let Some(&value) = all.find(|v| !v.is_finite()) {
            let name = "derivative";
            return Err(Error::Overflow { name, value });
        }
    }
    Ok(columns)
}

/// How many parameters friction has.
fn friction_parameters(friction: &WheelFriction) -> usize {
    match friction {
        WheelFriction::OnRail(map) => map.parts()[2].len(),
        WheelFriction::Everywhere(Friction::TemperatureDependent(law)) => {
            law.parameters(0.0).len() + law.memory.map_or(0, |_| 2)
        }
        WheelFriction::Everywhere(Friction::Coulomb(_)) => 1,
        WheelFriction::Everywhere(Friction::StaticKinetic { .. }) => 2,
        WheelFriction::Everywhere(Friction::SpeedDependent { law, memory }) => {
            law.parameters(0.0).len() + memory.map_or(0, |_| 2)
        }
    }
}

impl PatchChange {
    fn none(patch: &PatchLinear) -> Self {
        let n = patch.pressure.len();
        Self {
            pressure: vec![0.0; n],
            traction: vec![0.0; 2 * n],
            slip_velocity: vec![0.0; 2 * n],
            coefficient: vec![0.0; n],
            ..Self::default()
        }
    }

    /// Where the frame of the patch is.
    pub(crate) fn frame(&self) -> Frame {
        (self.origin, self.contact_angle)
    }

    /// With creepages and fields, `nx` points along x, of a left wheel as those of a right one, or back.
    pub(crate) fn mirrored(mut self, nx: usize) -> Self {
        let [along, across, spin] = self.creepage;
        self.creepage = [along, -across, -spin];
        out_of_mirror(
            nx,
            &mut [&mut self.pressure, &mut self.coefficient],
            &mut [&mut self.traction, &mut self.slip_velocity],
        );
        self
    }

    fn add(&mut self, share: f64, other: &Self) {
        let parts = [
            (self.position.as_mut_slice(), other.position.as_slice()),
            (&mut self.creepage, &other.creepage),
            (&mut self.force, &other.force),
            (&mut self.pressure, &other.pressure),
            (&mut self.traction, &other.traction),
            (&mut self.slip_velocity, &other.slip_velocity),
            (&mut self.coefficient, &other.coefficient),
            (&mut self.origin, &other.origin),
        ];
        for (to, from) in parts {
            add(to, share, from);
        }
        self.contact_angle += share * other.contact_angle;
        self.rail_position += share * other.rail_position;
        self.wheel_position += share * other.wheel_position;
        self.approach += share * other.approach;
        self.rolling_speed += share * other.rolling_speed;
        self.friction_power += share * other.friction_power;
    }
}

impl WheelChange {
    /// Adds a share of another change of the same step.
    pub fn add(&mut self, share: f64, other: &Self) {
        add(&mut self.force, share, &other.force);
        add(&mut self.moment, share, &other.moment);
        add(&mut self.vertical_force, share, &other.vertical_force);
        add(&mut self.pose, share, &other.pose);
        add(&mut self.velocity, share, &other.velocity);
        let rails = other.rail_displacement.as_flattened();
        add(self.rail_displacement.as_flattened_mut(), share, rails);
        self.friction_power += share * other.friction_power;
        for (patch, other) in self.patches.iter_mut().zip(&other.patches) {
            patch.add(share, other);
        }
    }
}

fn add(to: &mut [f64], share: f64, from: &[f64]) {
    for (to, v) in to.iter_mut().zip(from) {
        *to += share * v;
    }
}

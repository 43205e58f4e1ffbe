// SPDX-License-Identifier: MIT OR Apache-2.0
//! A wheelset ready for a simulation, and its steps.

use std::sync::{Arc, OnceLock};

use mtb_elasticity::Material;
use mtb_geometry::{PlaneGap, WheelOverRail, WheelPose};
use mtb_operator::Monitor;
use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::balance::{Effort, Instant, each_wheel, in_balance, loaded};
use crate::derivative::WheelTangent;
use crate::equilibrium::{Open, Unknown, in_equilibrium};
use crate::error::{Error, check_entries, positive};
use crate::memory::{Frame, Past};
use crate::operators::{Closing, Operators};
use crate::patch::WheelPatch;
use crate::rows::{Incline, Slopes};
use crate::state::{Found, WheelState, mark};
use crate::track::{Alignment, Moved, Place, sign};
use crate::wheelset::{Side, Sides, Wheelset};

/// Largest displacement [m]; beyond it cells drown in rounding.
const FARTHEST: f64 = 1e6;
/// Roll and yaw [rad] beyond which a wheelset is not on its rails.
const MOST_TURNED: f64 = 0.5;

/// Components of a pose, in order.
const POSE: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];

/// Velocity of a wheelset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Velocity {
    /// So fast along x [m/s], and rolling on the tape circle, about the axle as posed.
    Rolling(f64),
    /// Of the reference point (x, y, z) [m/s], and the rotation about x, y, z [rad/s], that about the axle
    /// included: forwards it is positive about y; a yawed or rolled axle has parts of it along x and z, a roll that is
    /// found too: 1 mrad of it is 1 mrad of the rotation along z, by which wheels 1.5 m apart differ by 3e-3 in creepage.
    Rigid([f64; 6]),
}

/// What the rotation of a wheelset about its axle is found from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AxleLoad {
    /// Force of all wheels on the rails along x [N]: braking is positive.
    LongitudinalForce(f64),
    /// Moment of this force about the axle [N m]; 0 where the wheelset rolls freely.
    Moment(f64),
}

/// What a step is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepInput {
    /// Displacement of the wheelset from where it stands in the [`Wheelset`], just touching the left rail:
    /// x, y, z [m], roll, pitch, yaw [rad]; NaN where it is found, see [`PreparedWheels::step`].
    pub pose: [f64; 6],
    /// Velocity; its part about the axle is where a search begins if there is an `axle_load`.
    pub velocity: Velocity,
    /// Force of all wheels on the rails along y [N], with y NaN.
    pub lateral_force: Option<f64>,
    /// What the rotation about the axle is found from.
    pub axle_load: Option<AxleLoad>,
    /// Curvature of the track, rails and wheels beside their places.
    pub alignment: Alignment,
    /// Of a transient step, as of [`PreparedWheels::step_transient`] [s].
    pub duration: Option<f64>,
}

impl StepInput {
    /// A steady step on a straight track.
    pub fn new(pose: [f64; 6], velocity: Velocity) -> Self {
        Self {
            pose,
            velocity,
            lateral_force: None,
            axle_load: None,
            alignment: Alignment::default(),
            duration: None,
        }
    }
}

/// Contact load of a step.
#[derive(Clone, Debug)]
pub struct WheelStep {
    /// Force of all patches on the rails, in the track [N]; the wheelset feels the opposite.
    pub force: [f64; 3],
    /// Moment of it about the reference point [N m], see [`WheelPatch::load`].
    pub moment: [f64; 3],
    /// Vertical force that the wheels press on the left and on the right rail with, friction included [N].
    pub vertical_force: [f64; 2],
    /// What the forces depart by from those that pose and rotation were to be found for, over the vertical one: the
    /// largest departure, with its sign; `None` where the height was given.
    ///
    /// Below 1e-8, but for a height, or a place across the track, at a small jump of the force (up to 1e-3), where the
    /// plane of a contact turns.
    pub balance_error: Option<f64>,
    /// The reference point, where the pose has put it [m].
    pub reference_point: [f64; 3],
    /// The pose, with what was found from balance [m], [rad].
    pub pose: [f64; 6],
    /// Velocity of the reference point [m/s] and rotation [rad/s], with what was found; relative to the frame of a
    /// curved track.
    pub velocity: [f64; 6],
    /// Displacement along y and z of the left and of the right rail on its springs and by its deviation [m].
    pub rail_displacement: [[f64; 2]; 2],
    /// The patches, those of the left wheel first; none where a wheel is lifted.
    pub patches: Vec<WheelPatch>,
    /// Heat of sliding of all patches [W], >= 0.
    pub friction_power: f64,
    /// For the next step.
    pub state: WheelState,
    /// Normal problems, of all patches and trials of the height.
    pub normal_solves: usize,
    /// Newton steps of the tangential problems, of all patches and trials of the height.
    pub iterations: usize,
    /// Its derivatives.
    pub tangent: WheelTangent,
}

/// One or both wheels of a wheelset with the memory of their last step.
#[derive(Clone)]
pub struct PreparedWheels {
    pub(crate) ready: Arc<Ready>,
    state: WheelState,
}

/// What all copies of a prepared wheelset share.
pub(crate) struct Ready {
    pub(crate) wheelset: Wheelset,
    /// The left wheel, and the right one where it differs.
    left: Facing,
    right: Option<Facing>,
    /// Of the tape circles of the wheels in contact problems, or the mean of both [m]: over it, a speed of rolling is that
    /// of the rotation.
    pub(crate) rolling_radius: f64,
    pub(crate) operators: Operators,
    pub(crate) closing: Closing,
    pub(crate) accuracy: Accuracy,
}

/// A wheel over its rail, the right one in a mirror.
struct Facing {
    over: WheelOverRail,
    /// Of the rail, where patches follow it.
    slopes: Option<Arc<Slopes>>,
}

impl Facing {
    fn of(wheelset: &Wheelset, side: Side) -> Result<Self, Error> {
        let pair = wheelset.pair_of(side);
        let over = WheelOverRail::new(pair)?;
        let slopes = if wheelset.conformal {
            if pair.has_slices() || pair.roller_radius.is_some() {
                return Err(mtb_geometry::Error::NotStraight.into());
            }
            Some(Slopes::of(&over, wheelset.spacing[1])?)
        } else {
            None
        };
        Ok(Self { over, slopes })
    }
}

/// How well the problems of a step are solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Relative residual of the pressures.
    pub normal: f64,
    /// Relative residual of the tractions.
    pub tangential: f64,
    /// Relative error of a vertical force that the height is found for.
    pub force: f64,
}

/// Below what the cells make.
const ACCURACY: Accuracy = Accuracy {
    normal: 1e-10,
    tangential: 1e-7,
    force: 5e-9,
};

/// Height of the reference point over the rail, in wheel radii, below which its velocity tells nothing of a rotation.
const LEVER: f64 = 0.01;

impl PreparedWheels {
    /// Places the profiles of a wheelset.
    ///
    /// # Errors
    /// Numbers that make no sense, profiles that never face each other, several coefficients of a Coulomb law.
    pub fn new(wheelset: Wheelset) -> Result<Self, Error> {
        wheelset.check()?;
        Self::solved_to(wheelset, ACCURACY)
    }

    /// The same wheels without memory, solved to another accuracy: differences of steps need more than what the
    /// cells make.
    ///
    /// # Errors
    /// As of [`PreparedWheels::new`].
    pub fn to_accuracy(&self, accuracy: Accuracy) -> Result<Self, Error> {
        Self::solved_to(self.ready.wheelset.clone(), accuracy)
    }

    fn solved_to(wheelset: Wheelset, accuracy: Accuracy) -> Result<Self, Error> {
        let right = wheelset.right.as_ref();
        let right = right.map(|_| Facing::of(&wheelset, Side::Right));
        let sides = wheelset.sides.each();
        let radii = sides
            .iter()
            .map(|side| wheelset.pair_of(*side).tape_radius());
        let ready = Ready {
            rolling_radius: radii.sum::<f64>() / sides.len() as f64,
            closing: Closing::new(wheelset.spacing),
            left: Facing::of(&wheelset, Side::Left)?,
            right: right.transpose()?,
            operators: Operators::new(wheelset.second_order),
            wheelset,
            accuracy,
        };
        Ok(Self {
            ready: Arc::new(ready),
            state: WheelState::default(),
        })
    }

    /// The wheelset.
    pub fn wheelset(&self) -> &Wheelset {
        &self.ready.wheelset
    }

    /// What the last step that was solved has left.
    pub fn state(&self) -> &WheelState {
        &self.state
    }

    /// The same wheels without memory; what is made from their size is shared.
    #[must_use]
    pub fn without_memory(&self) -> Self {
        Self {
            ready: self.ready.clone(),
            state: WheelState::default(),
        }
    }

    /// Takes a state for that of the last step.
    ///
    /// # Errors
    /// A state that is none.
    pub fn resume(&mut self, state: WheelState) -> Result<(), Error> {
        state.check()?;
        state.check_ground(self.ready.wheelset.conformal)?;
        self.state = state;
        Ok(())
    }

    /// Solves the contacts at one instant, as if the wheels had rolled so for long.
    ///
    /// `pose`: displacement of the wheelset from where it stands in the [`Wheelset`], just touching the left
    /// rail: x, y, z [m], roll, pitch, yaw [rad], turned by pitch, then roll, then yaw. z NaN: found so that pressures and friction carry the vertical
    /// force (on both wheels twice that); z and roll NaN, both wheels: so that each carries it.
    ///
    /// # Errors
    /// Numbers that make no sense; a contact that reaches the end of a profile or the edge of its grid; friction at rest without a
    /// standstill speed; problems that were not solved ([`Error::is_not_converged`]); an interruption. The
    /// memory then stays that of the step before.
    pub fn step(
        &mut self,
        pose: [f64; 6],
        velocity: Velocity,
        monitor: Monitor<'_>,
    ) -> Result<WheelStep, Error> {
        self.step_of(&StepInput::new(pose, velocity), monitor)
    }

    /// Rolls on from the last step, or from rest without one, for a `duration` [s]: each patch remembers its tractions.
    ///
    /// Particles have been moved by the rolling speed times the duration, and by what the patch has moved over the rail;
    /// their tractions before act where they are now. A patch takes over those of the earlier patches of its wheel that
    /// it overlaps across the rail. They stay in the cells they were in, but where patches merge: those of the less
    /// loaded are interpolated on the cells of the other. A patch that parts gives each of its cells to the nearest.
    ///
    /// A step over several cells is divided into parts of a cell at most, in which pressure and creepages change
    /// evenly from those of the state. One over more than four lengths of a patch is steady there.
    ///
    /// # Errors
    /// As of [`PreparedWheels::step`]; a duration that is not positive; a state without history.
    pub fn step_transient(
        &mut self,
        pose: [f64; 6],
        velocity: Velocity,
        duration: f64,
        monitor: Monitor<'_>,
    ) -> Result<WheelStep, Error> {
        let input = StepInput {
            duration: Some(duration),
            ..StepInput::new(pose, velocity)
        };
        self.step_of(&input, monitor)
    }

    /// What of a step is refused by its numbers alone, before anything is solved.
    ///
    /// # Errors
    /// Values that make no sense, a curve on rollers, a load of the axle at no speed along the track, steady rolling of
    /// wheels that neither move nor turn.
    pub fn check(&self, input: &StepInput) -> Result<(), Error> {
        let wheelset = &self.ready.wheelset;
        input.check(wheelset.sides)?;
        if wheelset.pair.roller_radius.is_some() && input.alignment.curvature != 0.0 {
            return Err(Error::CurvedRoller {
                curvature: input.alignment.curvature,
            });
        }
        let (along, rests) = match input.velocity {
            Velocity::Rolling(speed) => (speed, speed == 0.0),
            Velocity::Rigid(velocity) => (velocity[0], velocity == [0.0; 6]),
        };
        if input.axle_load.is_some() && along == 0.0 {
            return Err(Error::Number {
                name: "velocity along x",
                value: along,
                wanted: "a speed other than 0 is needed where the rotation is found from the load of the axle",
            });
        }
        let lever = wheelset.pair.wheel_radius - self.ready.arm().z;
        if input.axle_load.is_some()
            && wheelset.pair.roller_radius.is_none()
            && lever.abs() < LEVER * wheelset.pair.wheel_radius
        {
            return Err(Error::Number {
                name: "height of reference_point above the rail",
                value: lever,
                wanted: "a hundredth of the wheel radius at least is needed where the rotation is found from the load of \
                         the axle, as the velocity at the rail is that of the slip and tells nothing of the rotation",
            });
        }
        let is_steady = input.duration.is_none() && wheelset.standstill_speed.is_none();
        if is_steady && rests && input.alignment.is_still() {
            return Err(Error::AtRest {
                side: wheelset.sides.each()[0],
                velocity: [0.0; 6],
            });
        }
        Ok(())
    }

    /// Solves the contacts at one instant, with all that a step may be given.
    ///
    /// y NaN: found so that the wheels press the rails sideways by the `lateral_force`. On a flange two positions may
    /// do so, below and above its steepest place: the one that is reached first on the way from the last step is taken, or from
    /// y = 0 where there is none or no way leads from there. With an `axle_load` the rotation about the axle is found, on [`RailSprings`](crate::RailSprings) the displacement
    /// of the rails.
    ///
    /// # Errors
    /// As of [`PreparedWheels::step`]; forces that no pose or rotation gives.
    pub fn step_of(&mut self, input: &StepInput, monitor: Monitor<'_>) -> Result<WheelStep, Error> {
        let ready = self.ready.clone();
        let wheelset = &ready.wheelset;
        let StepInput {
            pose,
            mut velocity,
            duration,
            ..
        } = *input;
        self.check(input)?;
        let mut place = Place {
            pose,
            alignment: input.alignment,
        };
        let mut effort = Effort::default();
        let open = Open::of(wheelset, input);
        // where the next search for y begins
        let mut found = Found {
            lateral: pose[1],
            ..Found::default()
        };
        let mut balance_error = None;
        let (wheels, depth) = if open.is_any() {
            let out = in_equilibrium(&ready, input, open, &self.state, &mut effort, monitor)?;
            (place, velocity) = (out.place, out.velocity);
            balance_error = Some(out.error);
            found = out.found;
            (out.loaded, out.depth)
        } else if pose[2].is_nan() {
            let out = in_balance(
                &ready,
                &mut place,
                velocity,
                &self.state,
                duration,
                &mut effort,
                monitor,
            )?;
            found.slope = out.slope;
            (out.loaded, out.depth)
        } else {
            let known = &self.state.patches;
            let instant = Instant {
                place: &place,
                velocity,
                tangential: ready.accuracy.tangential,
                past: duration.map(|duration| Past::new(duration, &self.state)),
            };
            let wheels = each_wheel(
                wheelset.sides,
                [(); 2],
                &|side, (), effort, monitor| loaded(&ready, side, instant, known, effort, monitor),
                &mut effort,
                monitor,
            )?;
            (wheels, self.state.depth.clone())
        };
        let (centre, rigid) = ready.motion(&place, velocity);
        let on_springs = found.rails;
        let mut out = WheelStep {
            force: [0.0; 3],
            moment: [0.0; 3],
            vertical_force: [0.0; 2],
            balance_error: None,
            reference_point: centre.into(),
            pose: place.pose,
            velocity: rigid,
            rail_displacement: place
                .alignment
                .rails
                .map(|rail| [rail.place[0], rail.place[1]]),
            patches: Vec::new(),
            friction_power: 0.0,
            state: WheelState {
                depth,
                found: Some(found),
                patches: Vec::new(),
            },
            normal_solves: effort.normal_solves,
            iterations: effort.iterations,
            tangent: WheelTangent {
                ready: ready.clone(),
                place,
                found: Unknown::all_of(wheelset, input),
                on_springs,
                axle_load: input.axle_load,
                velocity: input.velocity,
                rigid,
                load: [Vector3::zeros(); 2],
                duration,
                balance_error: None,
                patches: Vec::new(),
                began: duration.map(|_| mark(&self.state.patches)),
                left: 0,
                free: OnceLock::new(),
            },
        };
        for (side, wheel) in wheelset.sides.each().iter().zip(wheels) {
            for rolled in wheel.patches {
                let [force, moment] = rolled.patch.load(out.reference_point);
                for c in 0..3 {
                    out.force[c] += force[c];
                    out.moment[c] += moment[c];
                }
                out.vertical_force[usize::from(*side == Side::Right)] -= force[2];
                out.friction_power += rolled.patch.friction_power;
                out.state.patches.push(rolled.ratio);
                out.patches.push(rolled.patch);
                out.tangent.patches.push(Arc::new(rolled.linear));
            }
        }
        if pose[2].is_nan() && balance_error.is_none() {
            balance_error = Some(departure(wheelset, &out.vertical_force, pose[3].is_nan()));
        }
        out.balance_error = balance_error;
        out.tangent.balance_error = balance_error;
        out.tangent.left = mark(&out.state.patches);
        out.tangent.load = [out.force.into(), out.moment.into()];
        out.check()?;
        self.state = out.state.clone();
        Ok(out)
    }
}

impl StepInput {
    fn check(&self, sides: Sides) -> Result<(), Error> {
        check_pose(&self.pose, sides, self.lateral_force.is_some())?;
        match self.velocity {
            Velocity::Rolling(speed) => check_entries("velocity", &[speed])?,
            Velocity::Rigid(velocity) => check_entries("velocity", &velocity)?,
        }
        check_entries("lateral_force", self.lateral_force.as_slice())?;
        match self.axle_load {
            Some(AxleLoad::LongitudinalForce(force)) => {
                check_entries("longitudinal_force", &[force])?;
            }
            Some(AxleLoad::Moment(moment)) => check_entries("axle_moment", &[moment])?,
            None => {}
        }
        if let Some(duration) = self.duration {
            positive("duration", duration)?;
        }
        self.alignment.check()
    }
}

impl WheelStep {
    /// Whether all numbers are finite.
    fn check(&self) -> Result<(), Error> {
        let totals: [(&'static str, &[f64]); 4] = [
            ("force", &self.force),
            ("moment", &self.moment),
            ("pose", &self.pose),
            ("friction power", &[self.friction_power]),
        ];
        let fields = self.patches.iter().flat_map(|patch| {
            [
                ("pressure", patch.pressure.as_slice()),
                ("traction", &patch.traction),
                ("slip velocity", &patch.slip_velocity),
                ("creepage", &patch.creepage),
            ]
        });
        for (name, values) in totals.into_iter().chain(fields) {
            if let Some(&value) = values.iter().find(|v| !v.is_finite()) {
                return Err(Error::Overflow { name, value });
            }
        }
        self.state.check()
    }
}

impl Ready {
    fn facing(&self, side: Side) -> &Facing {
        side.of(&self.left, self.right.as_ref())
    }

    /// A wheel over its rail, the right one in a mirror.
    pub(crate) fn over(&self, side: Side) -> &WheelOverRail {
        &self.facing(side).over
    }

    /// Distance of the tape circles from the middle of the axle [m].
    pub(crate) fn tape(&self) -> f64 {
        self.left.over.tape()
    }

    /// Reference point [m], and the velocity [m/s] there with the rotation [rad/s].
    pub(crate) fn motion(&self, place: &Place, velocity: Velocity) -> (Vector3<f64>, [f64; 6]) {
        let wheelset = &self.wheelset;
        let [x, y, z, ..] = place.pose;
        let centre = Vector3::from(wheelset.reference_point) + Vector3::new(x, y, z);
        let rigid = match velocity {
            Velocity::Rigid(rigid) => rigid,
            Velocity::Rolling(speed) => {
                let axle = rotation(&place.pose).column(1) * (speed / self.rolling_radius);
                [speed, 0.0, 0.0, axle[0], axle[1], axle[2]]
            }
        };
        (centre, rigid)
    }

    /// Where the wheel is as its rail sees it, the right one in a mirror.
    pub(crate) fn axle(&self, side: Side, place: &Place) -> WheelPose {
        let turn = rotation(&led(&place.pose)) * rotation(&place.turned_wheel(side));
        // the middle of an axle that this wheel would stand on
        let out = sign(side) * self.tape();
        let mut centre = self.hub(side, place) - turn.column(1) * out;
        let mut axle = turn.column(1).into_owned();
        let mut spoke = -turn.column(2);
        if side == Side::Right {
            centre.y = -centre.y;
            axle.x = -axle.x;
            axle.z = -axle.z;
            spoke.y = -spoke.y;
        }
        let rail = self.rail(side, place);
        let (centre, axle) = (rail.seen(centre), rail.turn.transpose() * axle);
        let spoke = rail.turn.transpose() * spoke;
        // where the spoke that points down at the zero pose has gone
        let along = Vector3::x() - axle * axle.x;
        let down = axle.cross(&along);
        WheelPose {
            centre: centre.into(),
            axle: axle.into(),
            turn: -spoke.dot(&along).atan2(spoke.dot(&down)),
        }
    }
}

impl Ready {
    /// Middle of the tape circle of a wheel [m], in the track.
    pub(crate) fn hub(&self, side: Side, place: &Place) -> Vector3<f64> {
        let [x, y, z, ..] = place.pose;
        let [dx, dy, dz, ..] = place.wheel(side).place;
        let out = Vector3::y() * (sign(side) * self.tape());
        let beside = out + Vector3::new(dx, dy, dz);
        let centre = Vector3::from(self.wheelset.reference_point) + Vector3::new(x, y, z);
        centre + rotation(&place.pose) * self.arm() + rotation(&led(&place.pose)) * beside
    }

    /// How the rail of a side has moved, the right one in a mirror.
    pub(crate) fn rail(&self, side: Side, place: &Place) -> Moved {
        Moved::of(&place.rail(side), self.over(side).rail_origin())
    }

    /// How the rows of a patch are inclined, if they follow the rail: the slope [rad] so far [m] from the middle one.
    pub(crate) fn slope(
        &self,
        side: Side,
        plane: &PlaneGap,
    ) -> Option<impl Fn(f64) -> f64 + Sync + use<>> {
        let incline = self.incline(side, plane.first[1], false)?;
        let middle = 0.5 * (plane.ny - 1) as f64 * self.wheelset.spacing[1];
        Some(move |y| incline.at(middle + y))
    }

    /// How rows from one on are inclined, or from there backwards, if they follow the rail.
    pub(crate) fn incline(&self, side: Side, line: i64, is_backwards: bool) -> Option<Incline> {
        let slopes = self.facing(side).slopes.as_ref()?;
        Some(Incline::new(slopes, line, is_backwards))
    }

    /// Where a plane lies, as of [`PatchHistory`](crate::PatchHistory), and its slope there [rad]. Rows that follow the
    /// rail are told by their places along it, which do not move.
    pub(crate) fn in_history(&self, side: Side, place: &Place, plane: &PlaneGap) -> Frame {
        if plane.rows.is_some() {
            let along = plane.position[0] - self.middle(place).x;
            return ([along, 0.0, 0.0], 0.0);
        }
        (self.plane_in_history(side, place, plane), plane.angle)
    }

    fn plane_in_history(&self, side: Side, place: &Place, plane: &PlaneGap) -> [f64; 3] {
        let [x, y, z] = plane.position;
        let Some(radius) = self.wheelset.pair.roller_radius else {
            return [x - self.middle(place).x, y, z];
        };
        let rail = self.rail(side, place);
        let seen = rail.seen(plane.position.into());
        let own = seen.x.hypot(radius + seen.z);
        // small against the radius, and not taken off it
        let up = seen.z + seen.x * seen.x / (own + radius + seen.z);
        let [_, y, z] = rail.point(Vector3::new(0.0, seen.y, up)).into();
        [own * plane.roller_angle, y, z]
    }

    /// Change of [`Ready::in_history`] with that of the place, and of the plane, as of a left wheel.
    pub(crate) fn in_history_change(
        &self,
        side: Side,
        place: &Place,
        plane: &PlaneGap,
        by: &Place,
        (by_position, by_roller): (Vector3<f64>, f64),
    ) -> [f64; 3] {
        let Some(radius) = self.wheelset.pair.roller_radius else {
            let by_middle = by.pose[0] + (turning(&place.pose, &by.pose) * self.arm()).x;
            let along = by_position.x - by_middle;
            if plane.rows.is_some() {
                return [along, 0.0, 0.0];
            }
            return [along, by_position.y, by_position.z];
        };
        let (rail, by_rail) = (self.rail(side, place), by.rail(side));
        let seen = rail.seen(plane.position.into());
        let by_seen = rail.seen_change(&by_rail, plane.position.into(), by_position);
        let own = seen.x.hypot(radius + seen.z);
        let by_own = (seen.x * by_seen.x + (radius + seen.z) * by_seen.z) / own;
        let up = seen.z + seen.x * seen.x / (own + radius + seen.z);
        let top = Vector3::new(0.0, seen.y, up);
        let by_top = Vector3::new(0.0, by_seen.y, by_own);
        let [_, y, z] = rail.point_change(&by_rail, top, by_top).into();
        [by_own * plane.roller_angle + own * by_roller, y, z]
    }

    /// Both bodies as one half-space.
    pub(crate) fn joined(&self) -> Result<Material, Error> {
        let bodies = &self.wheelset.bodies;
        let elastic: Vec<Material> = bodies.lower.into_iter().chain(bodies.upper).collect();
        Ok(Material::joined(&elastic)?)
    }

    /// Change of [`Ready::axle`] with that of the place.
    pub(crate) fn axle_change(&self, side: Side, place: &Place, by: &Place) -> WheelPose {
        let (bend, by_bend) = (place.turned_wheel(side), by.turned_wheel(side));
        let (axes, bent) = (led(&place.pose), rotation(&bend));
        let turn = rotation(&axes) * bent;
        let by_turn =
            turning(&axes, &led(&by.pose)) * bent + rotation(&axes) * turning(&bend, &by_bend);
        let out = sign(side) * self.tape();
        let mut centre = self.hub(side, place) - turn.column(1) * out;
        let mut by_centre = self.hub_change(side, place, by) - by_turn.column(1) * out;
        let mut by_axle = by_turn.column(1).into_owned();
        let mut axle = turn.column(1).into_owned();
        let (mut spoke, mut by_spoke) = (-turn.column(2), -by_turn.column(2));
        if side == Side::Right {
            centre.y = -centre.y;
            by_centre.y = -by_centre.y;
            spoke.y = -spoke.y;
            by_spoke.y = -by_spoke.y;
            for direction in [&mut axle, &mut by_axle] {
                direction.x = -direction.x;
                direction.z = -direction.z;
            }
        }
        let (rail, by_rail) = (self.rail(side, place), by.rail(side));
        let by_centre = rail.seen_change(&by_rail, centre, by_centre);
        let by_frame = rail.turn_change(by_rail.place[2]).transpose();
        let frame = rail.turn.transpose();
        let [(axle, by_axle), (spoke, by_spoke)] = [(axle, by_axle), (spoke, by_spoke)]
            .map(|(direction, by)| (frame * direction, by_frame * direction + frame * by));
        let along = Vector3::x() - axle * axle.x;
        let by_along = -(by_axle * axle.x + axle * by_axle.x);
        let [ahead, down] = [along, axle.cross(&along)];
        let by_down = by_axle.cross(&along) + axle.cross(&by_along);
        let [x, y] = [ahead, down].map(|direction| spoke.dot(&direction));
        let [by_x, by_y] = [(ahead, by_along), (down, by_down)]
            .map(|(direction, by)| by_spoke.dot(&direction) + spoke.dot(&by));
        WheelPose {
            centre: by_centre.into(),
            axle: by_axle.into(),
            turn: -(y * by_x - x * by_y) / (x * x + y * y),
        }
    }

    /// Change of [`Ready::hub`] with that of the place.
    pub(crate) fn hub_change(&self, side: Side, place: &Place, by: &Place) -> Vector3<f64> {
        let [x, y, z, ..] = by.pose;
        let offset = |place: &Place| {
            let [dx, dy, dz, ..] = place.wheel(side).place;
            Vector3::new(dx, dy, dz)
        };
        let out = Vector3::y() * (sign(side) * self.tape());
        let axes = led(&place.pose);
        Vector3::new(x, y, z)
            + turning(&place.pose, &by.pose) * self.arm()
            + turning(&axes, &led(&by.pose)) * (out + offset(place))
            + rotation(&axes) * offset(by)
    }

    /// Middle of the axle [m], in the track.
    pub(crate) fn middle(&self, place: &Place) -> Vector3<f64> {
        let [x, y, z, ..] = place.pose;
        let centre = Vector3::from(self.wheelset.reference_point) + Vector3::new(x, y, z);
        centre + rotation(&place.pose) * self.arm()
    }

    /// Middle of the axle from the reference point [m], at the zero pose.
    pub(crate) fn arm(&self) -> Vector3<f64> {
        let pair = &self.wheelset.pair;
        let height = pair.wheel_radius + self.left.over.first_height();
        Vector3::new(0.0, pair.lateral, height) - Vector3::from(self.wheelset.reference_point)
    }
}

/// Change of [`rotation`] with that of the pose.
pub(crate) fn turning(place: &[f64; 6], by: &[f64; 6]) -> Matrix3<f64> {
    let (mut about, mut after) = (Vector3::zeros(), Matrix3::identity());
    for axis in TURNS.into_iter().rev() {
        // each turn is about a fixed axis, and those that come after it turn with them what it does
        about += after.column(axis) * by[3 + axis];
        after *= turn_about(axis, place[3 + axis]);
    }
    about.cross_matrix() * after
}

/// Rotation about one fixed axis.
fn turn_about(axis: usize, angle: f64) -> Matrix3<f64> {
    let axis = Vector3::ith_axis(axis);
    Rotation3::from_axis_angle(&axis, angle).into_inner()
}

/// The fixed axes that a wheelset turns about, one after the other: the way that its wheels have rolled comes first, about
/// the axle, and roll and yaw lead the axle elsewhere.
const TURNS: [usize; 3] = [1, 0, 2];

/// Rotation by pitch about y, then roll about x, then yaw about z, all fixed axes.
pub(crate) fn rotation(place: &[f64; 6]) -> Matrix3<f64> {
    let turned = |turn, axis: usize| turn_about(axis, place[3 + axis]) * turn;
    TURNS.into_iter().fold(Matrix3::identity(), turned)
}

/// The axes of a wheelset, which roll and yaw lead, and which do not roll with its wheels; likewise their change.
pub(crate) fn led(pose: &[f64; 6]) -> [f64; 6] {
    let [x, y, z, roll, _, yaw] = *pose;
    [x, y, z, roll, 0.0, yaw]
}

/// Largest departure of the vertical force from the one asked, over that: of each wheel, or of all together.
fn departure(wheelset: &Wheelset, vertical_force: &[f64; 2], is_each: bool) -> f64 {
    let off = |carried: f64, asked: f64| carried / asked - 1.0;
    if is_each {
        let [left, right] = vertical_force.map(|carried| off(carried, wheelset.force));
        if right.abs() > left.abs() {
            right
        } else {
            left
        }
    } else {
        let asked = wheelset.force * wheelset.sides.each().len() as f64;
        off(vertical_force.iter().sum(), asked)
    }
}

fn check_pose(pose: &[f64; 6], sides: Sides, has_lateral_force: bool) -> Result<(), Error> {
    for (k, name) in POSE.iter().enumerate() {
        let value = pose[k];
        if value.is_nan() {
            continue;
        }
        check_entries("pose", &[value]).map_err(|_| Error::Entry {
            name: "pose",
            index: k,
            value,
        })?;
        if k < 3 && value.abs() > FARTHEST {
            return Err(Error::Far {
                name,
                value,
                most: FARTHEST,
            });
        }
        if (k == 3 || k == 5) && value.abs() > MOST_TURNED {
            return Err(Error::Turned {
                name,
                value,
                most: MOST_TURNED,
            });
        }
    }
    let is_open = pose.map(f64::is_nan);
    let is_each = is_open[3] && is_open[2] && sides == Sides::Both;
    let is_found = is_open[1] && is_open[2];
    if [0, 4, 5].iter().any(|k| is_open[*k])
        || (is_open[3] && !is_each)
        || (is_open[1] && !is_found)
        || is_open[1] != has_lateral_force
    {
        return Err(Error::Open {
            pose: *pose,
            has_lateral_force,
        });
    }
    Ok(())
}

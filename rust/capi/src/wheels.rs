// SPDX-License-Identifier: MIT OR Apache-2.0
//! Wheels on rails.

use std::ffi::c_char;
use std::ops::Range;

use mtb_operator::unmonitored;
use mtb_wheelset::{
    Alignment, AxleLoad, PreparedWheels, RailDeviation, Side, Sides, StepInput, Velocity,
    WheelChange, WheelDeviation, WheelInput, WheelPatch, WheelState, WheelStep, WheelTangent,
    Wheelset,
};

use crate::registry::{WHEELS, Wheels, lock};
use crate::{Failure, MtbStatus, call, copy_out, keep, put, read, take, unreadable};

impl From<mtb_wheelset::Error> for Failure {
    fn from(error: mtb_wheelset::Error) -> Self {
        let status = if error.is_not_converged() {
            MtbStatus::NotConverged
        } else {
            MtbStatus::BadArgument
        };
        Self(status, error.to_string())
    }
}

/// Contact load of a step of wheels.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct MtbWheelStep {
    /// Force of all patches on the rails [N].
    pub force: [f64; 3],
    /// Moment of it about the reference point [N m].
    pub moment: [f64; 3],
    /// Vertical force that the wheels press on the left and on the right rail with, friction included [N].
    pub vertical_force: [f64; 2],
    /// What the vertical force departs by from the one that the height was to be found for, over that: the largest
    /// departure, with its sign, below 1e-8 but at a small jump of the force. NaN where the height was given.
    pub balance_error: f64,
    /// The reference point, where the pose has put it [m].
    pub reference_point: [f64; 3],
    /// The pose, with what was found from balance: x, y, z [m], roll, pitch, yaw [rad].
    pub pose: [f64; 6],
    /// Heat of sliding [W].
    pub friction_power: f64,
    /// Number of patches; none where the wheels are lifted.
    pub patches: u64,
    /// Normal problems, of all patches and trials of the height.
    pub normal_solves: u64,
    /// Newton steps of the tangential problems.
    pub iterations: u64,
}

/// What else a step of wheels may be given, and what it found of it. Left first, then right.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct MtbWheelConditions {
    /// Force of all wheels on the rails along y [N], for which y of the pose, NaN, is found with the height; NaN: y is
    /// given.
    pub lateral_force: f64,
    /// Force of all wheels on the rails along x [N], for which the rotation about the axle is found; NaN: none.
    pub longitudinal_force: f64,
    /// Moment of the forces on the rails about the axle [N m] in place of it, 0 for free rolling; NaN: none.
    pub axle_moment: f64,
    /// Curvature of the track [1/m], > 0 in a curve to the left; the velocity is then relative to a frame that goes
    /// along the track.
    pub curvature: f64,
    /// Rails beside their places: y, z [m], rotation about x [rad].
    pub rails: [[f64; 3]; 2],
    /// Their rates [m/s], [rad/s].
    pub rail_rates: [[f64; 3]; 2],
    /// Wheels beside their places on the wheelset: x, y, z [m], rotation about x, y, z [rad], in axes that roll and yaw
    /// turn and the pitch does not.
    pub wheels: [[f64; 6]; 2],
    /// Their rates [m/s], [rad/s].
    pub wheel_rates: [[f64; 6]; 2],
    /// Out: velocity [m/s] and rotation [rad/s] of the wheelset, with what was found.
    pub velocity: [f64; 6],
    /// Out: displacement of the rails along y and z [m], that of their springs included.
    pub rail_displacement: [[f64; 2]; 2],
}

impl MtbWheelConditions {
    /// Nothing but pose and velocity.
    const NONE: Self = Self {
        lateral_force: f64::NAN,
        longitudinal_force: f64::NAN,
        axle_moment: f64::NAN,
        curvature: 0.0,
        rails: [[0.0; 3]; 2],
        rail_rates: [[0.0; 3]; 2],
        wheels: [[0.0; 6]; 2],
        wheel_rates: [[0.0; 6]; 2],
        velocity: [0.0; 6],
        rail_displacement: [[0.0; 2]; 2],
    };

    fn input(&self, pose: [f64; 6], velocity: Velocity) -> Result<StepInput, Failure> {
        let given = |value: f64| (!value.is_nan()).then_some(value);
        let axle_load = match (given(self.longitudinal_force), given(self.axle_moment)) {
            (Some(force), None) => Some(AxleLoad::LongitudinalForce(force)),
            (None, Some(moment)) => Some(AxleLoad::Moment(moment)),
            (None, None) => None,
            (Some(_), Some(_)) => {
                return Err(Failure::argument(
                    "longitudinal_force and axle_moment are both given: one of them must be NaN",
                ));
            }
        };
        let rail = |k: usize| RailDeviation {
            place: self.rails[k],
            rate: self.rail_rates[k],
        };
        let wheel = |k: usize| WheelDeviation {
            place: self.wheels[k],
            rate: self.wheel_rates[k],
        };
        Ok(StepInput {
            lateral_force: given(self.lateral_force),
            axle_load,
            alignment: Alignment {
                curvature: self.curvature,
                rails: [rail(0), rail(1)],
                wheels: [wheel(0), wheel(1)],
            },
            ..StepInput::new(pose, velocity)
        })
    }
}

/// A contact patch, in its own frame: x along the rail, y across, normal from the rail to the wheel.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct MtbWheelPatch {
    /// 1 for the left wheel, -1 for the right one.
    pub side: i64,
    /// Points along x.
    pub nx: u64,
    /// Points along y.
    pub ny: u64,
    /// First point, x and y [m].
    pub start: [f64; 2],
    /// Distance of the points along x and y [m].
    pub spacing: [f64; 2],
    /// Origin of the frame, in the track [m].
    pub position: [f64; 3],
    /// Directions of x, y and normal in the track, three numbers each.
    pub directions: [[f64; 3]; 3],
    /// Slope of the contact plane [rad], > 0 where it rises to the field side (flange contact).
    pub contact_angle: f64,
    /// y of the origin in the rail profile's own frame [m].
    pub rail_position: f64,
    /// y of the origin in the wheel profile's own frame [m].
    pub wheel_position: f64,
    /// Largest overlap of the undeformed bodies along the normal [m].
    pub approach: f64,
    /// Rigid slip of the wheel over the rail at the origin, over the rolling speed: xi, eta [-], phi [1/m].
    pub creepage: [f64; 3],
    /// Mean of the speeds at which the patch runs over rail and wheel [m/s]; > 0 along x.
    pub rolling_speed: f64,
    /// Sum of pressure times area [N].
    pub normal_force: f64,
    /// Share of the estimated contact area inclined too much against the plane to be represented by it [-].
    pub neglected: f64,
    /// Heat of sliding [W].
    pub friction_power: f64,
}

impl From<&WheelPatch> for MtbWheelPatch {
    fn from(patch: &WheelPatch) -> Self {
        Self {
            side: if patch.side == Side::Left { 1 } else { -1 },
            nx: patch.grid.nx as u64,
            ny: patch.grid.ny as u64,
            start: patch.place(0),
            spacing: [patch.grid.dx, patch.grid.dy],
            position: patch.position,
            directions: columns(patch.rotation),
            contact_angle: patch.contact_angle,
            rail_position: patch.rail_position,
            wheel_position: patch.wheel_position,
            approach: patch.approach,
            creepage: patch.creepage,
            rolling_speed: patch.rolling_speed,
            normal_force: patch.normal_force,
            neglected: patch.neglected,
            friction_power: patch.friction_power,
        }
    }
}

impl From<&WheelStep> for MtbWheelStep {
    fn from(out: &WheelStep) -> Self {
        Self {
            force: out.force,
            moment: out.moment,
            vertical_force: out.vertical_force,
            balance_error: out.balance_error.unwrap_or(f64::NAN),
            reference_point: out.reference_point,
            pose: out.pose,
            friction_power: out.friction_power,
            patches: out.patches.len() as u64,
            normal_solves: out.normal_solves as u64,
            iterations: out.iterations as u64,
        }
    }
}

/// Reads wheels that Python's `PreparedWheels.save` wrote.
///
/// `path`: text in UTF-8, ended by a zero. `wheels`: gets the handle, which `mtb_wheels_free` gives back.
///
/// # Safety
/// `path` must be such a text, `wheels` must point to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_wheels_load(path: *const c_char, wheels: *mut u64) -> MtbStatus {
    call(|| {
        let (path, bytes) = read(path)?;
        let prepared = Wheelset::from_bytes(&bytes)
            .and_then(PreparedWheels::new)
            .map_err(|error| unreadable(path, &error))?;
        keep("wheels", &WHEELS, Wheels::new(prepared), wheels)
    })
}

/// The same wheels without memory, for a second wheelset or thread.
///
/// # Safety
/// `copy` must point to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_wheels_copy(wheels: u64, copy: *mut u64) -> MtbStatus {
    call(|| {
        let other = lock(&*WHEELS.get(wheels)?).wheels.without_memory();
        keep("copy", &WHEELS, Wheels::new(other), copy)
    })
}

/// Gives wheels back.
#[unsafe(no_mangle)]
pub extern "C" fn mtb_wheels_free(wheels: u64) -> MtbStatus {
    call(|| WHEELS.remove(wheels))
}

/// The point of the wheelset that poses, velocities and moments are about, at the zero pose [m]. It moves with the
/// wheelset: `mtb_wheel_step` tells where a step has put it.
///
/// # Safety
/// `point` must have room for 3 numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_wheels_reference_point(wheels: u64, point: *mut f64) -> MtbStatus {
    call(|| {
        let handle = WHEELS.get(wheels)?;
        let kept = lock(&handle);
        copy_out("point", &kept.wheels.wheelset().reference_point, point, 3)
    })
}

/// Solves the contacts of the wheels at one instant, from the memory of the last step.
///
/// `pose` (6): displacement of the wheelset from where it was prepared, x, y, z [m], roll, pitch, yaw [rad]: turned
/// by the pitch about the fixed y axis through the reference point, as far as the wheels have rolled, then by roll and yaw
/// about the fixed x and z axes, then shifted; z NaN: found so that the wheels
/// carry their vertical force, friction included; z and roll NaN, both wheels: so that each carries it. A null pointer: z NaN,
/// roll likewise for both wheels, all else zero. Wheels and rails are bodies of revolution and straight: x and pitch move places alone, unless friction
/// changes along the rail. A pose whose contact reaches the end of a profile, and numbers larger than 1e30, are bad
/// arguments. `velocity` (6): of the reference point along x, y, z [m/s], then
/// rotation about x, y, z [rad/s], that about the axle included, which has parts along x and z by yaw and roll, found ones
/// too. Track frame: x along the rails, y to the
/// left, z up. Out: `step`.
///
/// # Safety
/// The arrays must be of these lengths, `step` must point to such a structure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_wheels_step(
    wheels: u64,
    pose: *const f64,
    velocity: *const f64,
    step: *mut MtbWheelStep,
) -> MtbStatus {
    call(|| {
        let mut motion = [0.0; 6];
        motion.copy_from_slice(take("velocity", velocity, 6)?);
        if step.is_null() {
            return Err(Failure::argument("step is null"));
        }
        let handle = WHEELS.get(wheels)?;
        let mut kept = lock(&handle);
        let place = place_of(&kept.wheels, pose, 0.0)?;
        let out = kept
            .wheels
            .step(place, Velocity::Rigid(motion), &unmonitored)?;
        let load = MtbWheelStep::from(&out);
        kept.last = Some(out);
        put("step", load, step)
    })
}

/// As `mtb_wheels_step`, with what else a step may be given: forces for which y and the rotation are found, a curve of
/// the track, rails and wheels beside their places. `conditions` also gets what was found.
///
/// # Safety
/// As of `mtb_wheels_step`; `conditions` must point to such a structure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_wheels_step_under(
    wheels: u64,
    pose: *const f64,
    velocity: *const f64,
    conditions: *mut MtbWheelConditions,
    step: *mut MtbWheelStep,
) -> MtbStatus {
    call(|| {
        if conditions.is_null() || step.is_null() {
            return Err(Failure::argument("conditions or step is null"));
        }
        step_and_tell(wheels, pose, velocity, None, conditions, step)
    })
}

/// Rolls on from the last step, or from rest without one, for a `duration` [s] > 0: each patch remembers its tractions.
///
/// As `mtb_wheels_step_under`, with pose and velocity at the end of the step. `conditions` may be null: then there are
/// none. Nothing is special about the last step: a steady one is rolled on from as well. A step over several cells is
/// divided into parts of a cell at most, in which pressure and creepages change evenly; one over more than four lengths
/// of a patch is steady there. A wheel may stand still: then it is shifted by its slip velocity times the duration. The
/// heat of sliding is the mean of the step. After a step that was not solved the one before it counts. Here the memory
/// decides what comes out: to take a step again, keep what `mtb_wheels_state` gives before it, and for a start from rest
/// take a copy.
///
/// # Safety
/// As of `mtb_wheels_step_under`; `conditions` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_wheels_step_transient(
    wheels: u64,
    pose: *const f64,
    velocity: *const f64,
    duration: f64,
    conditions: *mut MtbWheelConditions,
    step: *mut MtbWheelStep,
) -> MtbStatus {
    call(|| {
        if step.is_null() {
            return Err(Failure::argument("step is null"));
        }
        step_and_tell(wheels, pose, velocity, Some(duration), conditions, step)
    })
}

/// The pose (6) that is given, or without one that at y [m] whose height, and roll of both wheels, are found.
fn place_of(wheels: &PreparedWheels, pose: *const f64, y: f64) -> Result<[f64; 6], Failure> {
    let roll = match wheels.wheelset().sides {
        Sides::Both => f64::NAN,
        Sides::Left | Sides::Right => 0.0,
    };
    let mut place = [0.0, y, f64::NAN, roll, 0.0, 0.0];
    if !pose.is_null() {
        place.copy_from_slice(take("pose", pose, 6)?);
    }
    Ok(place)
}

/// Solves a step, steady or of a duration [s], and writes what it found. `conditions` may be null.
fn step_and_tell(
    wheels: u64,
    pose: *const f64,
    velocity: *const f64,
    duration: Option<f64>,
    conditions: *mut MtbWheelConditions,
    step: *mut MtbWheelStep,
) -> Result<(), Failure> {
    let mut given = if conditions.is_null() {
        MtbWheelConditions::NONE
    } else {
        // SAFETY: it points to such a structure
        unsafe { conditions.read() }
    };
    let y = if given.lateral_force.is_nan() {
        0.0
    } else {
        f64::NAN
    };
    let mut motion = [0.0; 6];
    motion.copy_from_slice(take("velocity", velocity, 6)?);
    let handle = WHEELS.get(wheels)?;
    let mut kept = lock(&handle);
    let place = place_of(&kept.wheels, pose, y)?;
    let input = StepInput {
        duration,
        ..given.input(place, Velocity::Rigid(motion))?
    };
    let out = kept.wheels.step_of(&input, &unmonitored)?;
    given.velocity = out.velocity;
    given.rail_displacement = out.rail_displacement;
    let load = MtbWheelStep::from(&out);
    kept.last = Some(out);
    if !conditions.is_null() {
        put("conditions", given, conditions)?;
    }
    put("step", load, step)
}

/// A patch of the last step that was solved, counted from 0, those of the left wheel first.
///
/// # Safety
/// `patch` must point to such a structure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_wheels_patch(
    wheels: u64,
    index: u64,
    patch: *mut MtbWheelPatch,
) -> MtbStatus {
    call(|| {
        let handle = WHEELS.get(wheels)?;
        let kept = lock(&handle);
        put("patch", patch_at(&kept, index)?.into(), patch)
    })
}

/// Fields of a patch of the last step that was solved, `n` = nx ny points, x fastest.
///
/// `pressure` (n) [Pa]; `traction` on the rail (2 n: along x, along y) [Pa]; `slip_velocity` of the wheel over
/// the rail (2 n) [m/s]; `status` (n): 0 open, 1 stick, 2 slip. A null pointer leaves a field out.
///
/// # Safety
/// The arrays must be of these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_wheels_fields(
    wheels: u64,
    index: u64,
    n: u64,
    pressure: *mut f64,
    traction: *mut f64,
    slip_velocity: *mut f64,
    status: *mut i32,
) -> MtbStatus {
    call(|| {
        let handle = WHEELS.get(wheels)?;
        let kept = lock(&handle);
        let patch = patch_at(&kept, index)?;
        let n = n as usize;
        for (name, values, to, length) in [
            ("pressure", &patch.pressure, pressure, n),
            ("traction", &patch.traction, traction, n.saturating_mul(2)),
            (
                "slip_velocity",
                &patch.slip_velocity,
                slip_velocity,
                n.saturating_mul(2),
            ),
        ] {
            if !to.is_null() {
                copy_out(name, values, to, length)?;
            }
        }
        if status.is_null() {
            return Ok(());
        }
        let codes: Vec<i32> = patch.status.iter().map(|s| *s as i32).collect();
        copy_out("status", &codes, status, n)
    })
}

/// Where the rows of a patch of the last step that was solved lie in the track, the number `rows` of them, its ny.
///
/// `position` (3 for each row): the place at the x of the origin [m]; `directions` (9 for each row): those of x, y and
/// normal, three numbers each, along which its tractions and pressures act. On a plane all rows have those of the patch.
/// A null pointer leaves either out.
///
/// # Safety
/// The arrays must be of these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_wheels_rows(
    wheels: u64,
    index: u64,
    rows: u64,
    position: *mut f64,
    directions: *mut f64,
) -> MtbStatus {
    call(|| {
        let handle = WHEELS.get(wheels)?;
        let kept = lock(&handle);
        let patch = patch_at(&kept, index)?;
        let (places, turns): (Vec<_>, Vec<_>) = (0..patch.grid.ny)
            .map(|row| patch.row(row))
            .map(|(place, turn)| (place, columns(turn)))
            .unzip();
        let rows = rows as usize;
        if !position.is_null() {
            copy_out(
                "position",
                places.as_flattened(),
                position,
                rows.saturating_mul(3),
            )?;
        }
        if directions.is_null() {
            return Ok(());
        }
        let turns = turns.as_flattened().as_flattened();
        copy_out("directions", turns, directions, rows.saturating_mul(9))
    })
}

/// Columns of a matrix given by its rows.
fn columns(rows: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|j| rows.map(|row| row[j]))
}

/// Derivatives of the last step that was solved, 9 x 12, row by row.
///
/// The rows are force x, y, z [N] and moment x, y, z [N m] on the rails, vertical force of the left and of the right
/// wheel [N], and heat of sliding [W]; the columns are what they are derived by: pose x, y, z [m], roll, pitch, yaw
/// [rad], then velocity x, y, z [m/s] and rotation about x, y, z [rad/s]. Height and roll that were found from balance
/// follow the rest, and have columns of 0. Contact planes, the gap over them and creepages change with the
/// pose; points stay in contact, in stick and in slip as they are. The moment is about the reference point, which moves.
///
/// # Safety
/// `derivatives` must have room for 108 numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_wheels_derivatives(wheels: u64, derivatives: *mut f64) -> MtbStatus {
    call(|| {
        let tangent = last_tangent(wheels)?;
        let mut columns = tangent.derivatives(WheelInput::Pose, &unmonitored)?;
        columns.extend(tangent.derivatives(WheelInput::Velocity, &unmonitored)?);
        let rows: Vec<Vec<f64>> = columns.iter().map(load_of).collect();
        let flat: Vec<f64> = (0..9)
            .flat_map(|row| rows.iter().map(move |column| column[row]))
            .collect();
        copy_out("derivatives", &flat, derivatives, flat.len())
    })
}

/// Derivatives of the last step that was solved by all that `mtb_wheels_step_under` takes, 25 x 52, row by row.
///
/// The rows are those of `mtb_wheels_derivatives`, then the pose x, y, z [m], roll, pitch, yaw [rad], the velocity
/// x, y, z [m/s] and the rotation about x, y, z [rad/s], and the displacement of the left rail along y and z and of
/// the right one [m], with what was found of them. The columns are pose and velocity as there, then the numbers of
/// `mtb_wheel_conditions` from `lateral_force` to `wheel_rates` in their order. What was found follows the rest; by
/// components of the pose that were found, and by forces that were not given, derivatives are 0.
///
/// # Safety
/// `derivatives` must have room for 1300 numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_wheels_derivatives_under(
    wheels: u64,
    derivatives: *mut f64,
) -> MtbStatus {
    call(|| {
        let tangent = last_tangent(wheels)?;
        let by = |input| tangent.derivatives(input, &unmonitored);
        let (lateral, axle) = (by(WheelInput::LateralForce)?, by(WheelInput::AxleLoad)?);
        let alignment = by(WheelInput::Alignment)?;
        let mut columns = by(WheelInput::Pose)?;
        columns.extend(by(WheelInput::Velocity)?);
        // by forces that were not given nothing changes
        let nothing = WheelChange::default();
        let is_force = matches!(tangent.axle_load(), Some(AxleLoad::LongitudinalForce(_)));
        let mut all: Vec<&WheelChange> = columns.iter().collect();
        all.push(lateral.first().unwrap_or(&nothing));
        let axle = axle.first().unwrap_or(&nothing);
        all.extend(if is_force {
            [axle, &nothing]
        } else {
            [&nothing, axle]
        });
        all.extend(IN_ORDER.into_iter().flatten().map(|k| &alignment[k]));
        let columns: Vec<Vec<f64>> = all.into_iter().map(all_of).collect();
        let flat: Vec<f64> = (0..25)
            .flat_map(|row| columns.iter().map(move |column| column[row]))
            .collect();
        copy_out("derivatives", &flat, derivatives, flat.len())
    })
}

/// The wheels, linearised about their last step.
fn last_tangent(wheels: u64) -> Result<WheelTangent, Failure> {
    let handle = WHEELS.get(wheels)?;
    let kept = lock(&handle);
    Ok(kept.last()?.tangent.clone())
}

/// Derivatives of the last step, which `mtb_wheels_step_transient` took, by its duration: 25 numbers, of the rows of
/// `mtb_wheels_derivatives_under`. Pose and velocity are held, and what the step before has left.
///
/// # Safety
/// `derivatives` must have room for 25 numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_wheels_duration_derivatives(
    wheels: u64,
    derivatives: *mut f64,
) -> MtbStatus {
    call(|| {
        let tangent = last_tangent(wheels)?;
        let columns = tangent.derivatives(WheelInput::Duration, &unmonitored)?;
        let column = columns.first().ok_or_else(|| {
            Failure::argument(
                "the last step was steady: one of mtb_wheels_step_transient is needed",
            )
        })?;
        let found = all_of(column);
        copy_out("derivatives", &found, derivatives, found.len())
    })
}

/// Numbers of an alignment (curvature; place and rate of each rail, then of each wheel) in the order of
/// `mtb_wheel_conditions`: places of both, then their rates.
const IN_ORDER: [Range<usize>; 9] = [
    0..1,
    1..4,
    7..10,
    4..7,
    10..13,
    13..19,
    25..31,
    19..25,
    31..37,
];

/// The numbers of a step in the order of `mtb_wheels_derivatives_under`.
fn all_of(change: &WheelChange) -> Vec<f64> {
    let mut all = load_of(change);
    all.extend(change.pose);
    all.extend(change.velocity);
    all.extend(change.rail_displacement.as_flattened());
    all
}

/// The numbers of a load in the order of `mtb_wheels_derivatives`.
fn load_of(change: &WheelChange) -> Vec<f64> {
    let parts = [
        change.force.as_slice(),
        &change.moment,
        &change.vertical_force,
    ];
    let mut load = parts.concat();
    load.push(change.friction_power);
    load
}

/// How many numbers the state after the last step that was solved has.
///
/// # Safety
/// `n` must point to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_wheels_state_size(wheels: u64, n: *mut u64) -> MtbStatus {
    call(|| {
        let handle = WHEELS.get(wheels)?;
        let size = lock(&handle).wheels.state().to_numbers().len();
        put("n", size as u64, n)
    })
}

/// The state after the last step that was solved, `n` numbers for `mtb_wheels_resume`.
///
/// # Safety
/// `state` must have room for `n` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_wheels_state(wheels: u64, n: u64, state: *mut f64) -> MtbStatus {
    call(|| {
        let handle = WHEELS.get(wheels)?;
        let numbers = lock(&handle).wheels.state().to_numbers();
        copy_out("state", &numbers, state, n as usize)
    })
}

/// Starts the next step from a state of `mtb_wheels_state` in place of the memory, for steps taken again. The memory
/// decides how long a steady step takes, not what comes out, and what a transient step rolls on from.
///
/// # Safety
/// `state` must hold `n` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mtb_wheels_resume(wheels: u64, n: u64, state: *const f64) -> MtbStatus {
    call(|| {
        let state = WheelState::from_numbers(take("state", state, n as usize)?)?;
        let handle = WHEELS.get(wheels)?;
        Ok(lock(&handle).wheels.resume(state)?)
    })
}

fn patch_at(wheels: &Wheels, index: u64) -> Result<&WheelPatch, Failure> {
    let patches = &wheels.last()?.patches;
    usize::try_from(index)
        .ok()
        .and_then(|k| patches.get(k))
        .ok_or_else(|| {
            Failure::argument(format!(
                "there is no patch {index}: the last step has {}",
                patches.len()
            ))
        })
}

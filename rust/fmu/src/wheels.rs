// SPDX-License-Identifier: MIT OR Apache-2.0
use std::ops::Range;

use mtb_operator::unmonitored;
use mtb_wheelset::{
    Alignment, AxleLoad, Error, PreparedWheels, RailDeviation, Sides, StepInput, Velocity,
    WheelChange, WheelDeviation, WheelInput, WheelState, WheelStep, WheelTangent, Wheelset,
};

use crate::contact::Contact;
use crate::words;

/// Inputs: pose x, y, z, roll, pitch, yaw; the speed of a rolling wheelset; velocity x, y, z and rotation about
/// x, y, z of one that moves as it likes; lateral force, longitudinal force, moment about the axle; curvature; for the
/// left and the right rail y, z, roll and their rates; for the left and the right wheel x, y, z, roll, pitch, yaw and
/// their rates.
const SPEED: usize = 6;
const RIGID: Range<usize> = 7..13;
const LATERAL_FORCE: usize = 13;
const LONGITUDINAL_FORCE: usize = 14;
const AXLE_MOMENT: usize = 15;
const CURVATURE: usize = 16;
const RAILS: [usize; 2] = [17, 23];
const WHEELS: [usize; 2] = [29, 41];
const INPUTS: usize = 53;
/// Outputs: force x, y, z; moment x, y, z; vertical force left, right; friction power; peak pressure; pose z, roll, y;
/// rotation x, y, z with that found about the axle; displacement of the left rail y, z, and of the right one.
const OUTPUTS: usize = 20;
const HEAT: usize = 8;
/// A time [s] in which nothing rolls on: of steps that importing programs take without time.
const AT_ONCE: f64 = 1e-12;

/// One or both wheels of a wheelset on their rails.
pub(crate) struct Wheels {
    prepared: PreparedWheels,
    last: Option<Last>,
    /// Whether a step was solved or resumed.
    has_memory: bool,
    /// Whether steps roll on from the last one; the first one is steady.
    is_transient: bool,
}

/// What the derivatives of a step need.
struct Last {
    tangent: WheelTangent,
    /// Patch and point of the largest pressure; nothing where the wheels are lifted.
    peak: Option<(usize, usize)>,
    /// Whether it rolled on without time: there is no heat.
    is_at_once: bool,
    /// Whether a curve, or rails or wheels beside their places, are inputs.
    has_alignment: bool,
    rows: Option<Vec<Vec<f64>>>,
}

impl Wheels {
    pub(crate) fn from_bytes(bytes: &[u8], is_transient: bool) -> Result<Self, String> {
        let wheelset = Wheelset::from_bytes(bytes).map_err(words)?;
        Ok(Self {
            prepared: PreparedWheels::new(wheelset).map_err(words)?,
            last: None,
            has_memory: false,
            is_transient,
        })
    }

    /// A step of a duration [s] where steps roll on, else a steady one; and whether it rolled on without time, where
    /// there is no heat.
    ///
    /// Before the first step wheels have rolled steadily, and at rest they are pressed together.
    fn solved(&mut self, input: &StepInput, duration: f64) -> Result<(WheelStep, bool), Error> {
        let rolls_on = StepInput {
            duration: Some(duration.max(AT_ONCE)),
            ..*input
        };
        if !(self.is_transient && self.has_memory) {
            match self.prepared.step_of(input, &unmonitored) {
                Err(Error::AtRest { .. }) if self.is_transient => {}
                step => return Ok((step?, false)),
            }
        }
        let mut step = self.prepared.step_of(&rolls_on, &unmonitored)?;
        let is_at_once = duration == 0.0;
        if is_at_once {
            step.friction_power = 0.0;
        }
        Ok((step, is_at_once))
    }
}

impl Contact for Wheels {
    fn inputs(&self) -> usize {
        INPUTS
    }

    fn outputs(&self) -> usize {
        OUTPUTS
    }

    fn default(&self, input: usize) -> f64 {
        match input {
            0 | 1 | 4 | 5 => 0.0,
            _ => f64::NAN,
        }
    }

    fn solve(&mut self, inputs: &[f64], duration: f64) -> Result<Vec<f64>, String> {
        let mut pose: [f64; 6] = std::array::from_fn(|k| inputs[k]);
        let has_both = self.prepared.wheelset().sides == Sides::Both;
        // the roll is found together with the height, where there are forces for both
        if pose[3].is_nan() && !(pose[2].is_nan() && has_both) {
            pose[3] = 0.0;
        }
        let velocity = match inputs[SPEED] {
            speed if speed.is_nan() => Velocity::Rigid(numbers(inputs, RIGID.start)),
            speed => Velocity::Rolling(speed),
        };
        let lateral_force = given(inputs[LATERAL_FORCE]);
        if lateral_force.is_some() {
            pose[1] = f64::NAN;
        }
        let force = given(inputs[LONGITUDINAL_FORCE]).map(AxleLoad::LongitudinalForce);
        let moment = given(inputs[AXLE_MOMENT]).map(AxleLoad::Moment);
        let input = StepInput {
            lateral_force,
            axle_load: force.or(moment),
            alignment: Alignment {
                curvature: given(inputs[CURVATURE]).unwrap_or_default(),
                rails: RAILS.map(|first| RailDeviation {
                    place: placed(inputs, first),
                    rate: placed(inputs, first + 3),
                }),
                wheels: WHEELS.map(|first| WheelDeviation {
                    place: placed(inputs, first),
                    rate: placed(inputs, first + 6),
                }),
            },
            ..StepInput::new(pose, velocity)
        };
        let (out, is_at_once) = self.solved(&input, duration).map_err(words)?;
        let mut peak = None;
        let mut highest = 0.0;
        for (patch, of) in out.patches.iter().enumerate() {
            for (point, &pressure) in of.pressure.iter().enumerate() {
                if pressure > highest {
                    (highest, peak) = (pressure, Some((patch, point)));
                }
            }
        }
        self.last = Some(Last {
            tangent: out.tangent,
            is_at_once,
            peak,
            has_alignment: inputs[CURVATURE..].iter().any(|value| !value.is_nan()),
            rows: None,
        });
        self.has_memory = true;
        let outputs = [
            out.force.as_slice(),
            &out.moment,
            &out.vertical_force,
            &[
                out.friction_power,
                highest,
                out.pose[2],
                out.pose[3],
                out.pose[1],
            ],
            &out.velocity[3..],
            out.rail_displacement.as_flattened(),
        ];
        Ok(outputs.concat())
    }

    fn follows_memory(&self) -> bool {
        self.is_transient
    }

    fn has_step(&self) -> bool {
        self.last.is_some()
    }

    fn derivatives(&mut self) -> Result<Vec<Vec<f64>>, String> {
        let last = self.last.as_mut().ok_or("no step was solved")?;
        if last.rows.is_none() {
            let by = |input| {
                let found = last.tangent.derivatives(input, &unmonitored);
                found.map_err(words)
            };
            let velocity = by(WheelInput::Velocity)?;
            let first = if velocity.len() == 1 {
                SPEED
            } else {
                RIGID.start
            };
            let mut groups = vec![
                (0, by(WheelInput::Pose)?),
                (first, velocity),
                (LATERAL_FORCE, by(WheelInput::LateralForce)?),
            ];
            if let Some(load) = last.tangent.axle_load() {
                let column = match load {
                    AxleLoad::LongitudinalForce(_) => LONGITUDINAL_FORCE,
                    AxleLoad::Moment(_) => AXLE_MOMENT,
                };
                groups.push((column, by(WheelInput::AxleLoad)?));
            }
            if last.has_alignment {
                // in the order of the inputs
                groups.push((CURVATURE, by(WheelInput::Alignment)?));
            }
            let mut rows = vec![vec![0.0; INPUTS]; OUTPUTS];
            for (first, changes) in groups {
                for (k, change) in changes.iter().enumerate() {
                    for (row, value) in rows.iter_mut().zip(outputs_of(change, last.peak)) {
                        row[first + k] = value;
                    }
                }
            }
            if last.is_at_once {
                rows[HEAT].fill(0.0);
            }
            last.rows = Some(rows);
        }
        Ok(last.rows.clone().unwrap_or_default())
    }

    fn memory(&self) -> Vec<f64> {
        if self.has_memory {
            self.prepared.state().to_numbers()
        } else {
            Vec::new()
        }
    }

    fn resume(&mut self, memory: &[f64]) -> Result<(), String> {
        let mut wheels = self.prepared.without_memory();
        if !memory.is_empty() {
            let state = WheelState::from_numbers(memory).map_err(words)?;
            wheels.resume(state).map_err(words)?;
        }
        self.prepared = wheels;
        self.last = None;
        self.has_memory = !memory.is_empty();
        Ok(())
    }

    fn forget(&mut self) {
        self.prepared = self.prepared.without_memory();
        self.last = None;
        self.has_memory = false;
    }
}

/// A number that the description has as an input.
fn given(value: f64) -> Option<f64> {
    (!value.is_nan()).then_some(value)
}

/// Numbers of a rail or a wheel beside its place, which are zero where the description does not have them.
fn placed<const N: usize>(inputs: &[f64], first: usize) -> [f64; N] {
    std::array::from_fn(|k| given(inputs[first + k]).unwrap_or_default())
}

fn numbers<const N: usize>(inputs: &[f64], first: usize) -> [f64; N] {
    std::array::from_fn(|k| inputs[first + k])
}

/// The changes of the outputs.
fn outputs_of(change: &WheelChange, peak: Option<(usize, usize)>) -> [f64; OUTPUTS] {
    let [fx, fy, fz] = change.force;
    let [mx, my, mz] = change.moment;
    let [left, right] = change.vertical_force;
    let highest = peak.map_or(0.0, |(patch, point)| change.patches[patch].pressure[point]);
    let [_, y, z, roll, ..] = change.pose;
    let power = change.friction_power;
    let [.., wx, wy, wz] = change.velocity;
    let [[left_y, left_z], [right_y, right_z]] = change.rail_displacement;
    [
        fx, fy, fz, mx, my, mz, left, right, power, highest, z, roll, y, wx, wy, wz, left_y,
        left_z, right_y, right_z,
    ]
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Derivatives of a step: of its load, power, peak pressure or any sum of its fields, by all that it was given.

use std::sync::Arc;

use mtb_operator::Monitor;

use super::{Prepared, PreparedContact, Pull, Step, rotation};
use crate::error::Error;
use crate::problem::{Geometry, Outcome};
use crate::sliding::RigidMotion;
use crate::stepping::{Found, SlidingState};

/// The numbers of a step whose derivatives a [`Jacobian`] holds, in its order: force [N] and moment [N m] on the lower
/// body, heat of sliding [W], largest mean pressure [Pa].
pub const OUTPUTS: [&str; 8] = [
    "force.x",
    "force.y",
    "force.z",
    "moment.x",
    "moment.y",
    "moment.z",
    "friction_power",
    "peak_pressure",
];
/// What they are derived by: pose [m], [rad], velocity [m/s], uniform magnetic pressure [Pa].
pub const INPUTS: [&str; 9] = [
    "pose.x",
    "pose.y",
    "pose.z",
    "pose.roll",
    "pose.pitch",
    "pose.yaw",
    "velocity.x",
    "velocity.y",
    "magnetic_pressure",
];

/// Derivatives of the [`OUTPUTS`] of a step (rows) by its [`INPUTS`] (columns).
pub type Jacobian = [[f64; INPUTS.len()]; OUTPUTS.len()];

/// A step that was taken, as its derivatives need it.
#[derive(Clone, Debug)]
pub struct Taken {
    pose: [f64; 6],
    velocity: [f64; 2],
    /// Whether the loads are those of the scene, at the speed of the step.
    is_scene: bool,
    state: SlidingState,
    /// Which of the prepared motions were found from balance.
    balanced: Vec<usize>,
}

/// The gradient of a number by all that a step is given.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient {
    /// By the gap (n) [1/m].
    pub gap: Vec<f64>,
    /// By the friction coefficients (n).
    pub friction: Vec<f64>,
    /// By the work of the loads on each motion (m) [1/J]; 0 for motions that the pose prescribes.
    pub work: Vec<f64>,
    /// By the pose [1/m], [1/rad]; 0 for components found from balance.
    pub pose: [f64; 6],
    /// By the velocity [1/(m/s)], tables over the speed included.
    pub velocity: [f64; 2],
    /// By a uniform magnetic pressure [1/Pa]; 0 where the contact knows of none.
    pub magnetic_pressure: f64,
}

impl Taken {
    pub(super) fn new(
        prepared: &Prepared,
        step: &Step<'_>,
        outcome: &Outcome,
        direction: Vec<f64>,
        motions: Vec<RigidMotion>,
        balanced: Vec<usize>,
    ) -> Self {
        Self {
            pose: step.pose,
            velocity: step.velocity,
            is_scene: matches!(step.pull, Pull::Scene),
            state: SlidingState {
                area: prepared.geometry.area.clone(),
                pressure: outcome.solution.pressure.clone(),
                friction: outcome.friction.clone(),
                slope: outcome.friction.clone(),
                direction,
                motions,
            },
            balanced,
        }
    }

    /// Which of the prepared motions were found from balance, in the order of the motions of the step.
    pub fn balanced(&self) -> &[usize] {
        &self.balanced
    }

    /// The state of the contact.
    pub fn state(&self) -> &SlidingState {
        &self.state
    }

    /// Traction along both tangents (2n) [Pa].
    fn traction(&self) -> Vec<f64> {
        let n = self.state.pressure.len();
        let along = self.state.direction.iter().enumerate();
        along
            .map(|(i, d)| d * self.state.friction[i % n] * self.state.pressure[i % n])
            .collect()
    }
}

impl PreparedContact {
    /// The last step, if it was solved.
    pub fn taken(&self) -> Option<&Arc<Taken>> {
        self.taken.as_ref()
    }

    /// The gradients of sums of what a step found with the weights `of`, one for each.
    ///
    /// They cost about a solve with the factors of the step each, where it is the last step; of an earlier one
    /// factors may have to be made. They hold as long as no point comes into contact or leaves it, and as the
    /// speed stays between two of a table. At rest the derivatives by the velocity are those of setting off.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, [`Error::Singular`], an interruption.
    pub fn gradients(
        &mut self,
        taken: &Taken,
        of: &[Found],
        monitor: Monitor<'_>,
    ) -> Result<Vec<Gradient>, Error> {
        let prepared = self.prepared.clone();
        let mut tangent = self.stepper.tangent(&taken.state, monitor)?;
        let given = tangent.adjoint(of, monitor)?;
        let path = Path::of(&prepared, taken)?;
        Ok(given
            .into_iter()
            .map(|given| {
                let mut work = vec![0.0; prepared.motions.len()];
                for (&k, w) in taken.balanced.iter().zip(&given.work) {
                    work[k] = *w;
                }
                let along = |row: &[f64]| {
                    dot(&row[..given.gap.len()], &given.gap) + dot(&row[given.gap.len()..], &work)
                };
                let magnetic_pressure = prepared
                    .magnetic
                    .as_ref()
                    .map_or(0.0, |[_, unit]| along(unit));
                let mut velocity = [0, 1].map(|c| dot(&path.drag[c], &given.drag));
                if let Some((loads, share)) = &path.loads {
                    for (v, share) in velocity.iter_mut().zip(share) {
                        *v += share * along(loads);
                    }
                }
                Gradient {
                    friction: tangent.by_friction(&given),
                    pose: std::array::from_fn(|c| dot(&path.gap[c], &given.gap)),
                    velocity,
                    magnetic_pressure,
                    gap: given.gap,
                    work,
                }
            })
            .collect())
    }

    /// Derivatives of the load, the heat of sliding and the peak pressure of the last step by its pose, velocity
    /// and magnetic pressure.
    ///
    /// The peak is that at the point where it is now.
    ///
    /// # Errors
    /// [`Error::NoStep`]; as [`PreparedContact::gradients`].
    pub fn jacobian(&mut self, monitor: Monitor<'_>) -> Result<Jacobian, Error> {
        let taken = self.taken.clone().ok_or(Error::NoStep)?;
        let of = self.prepared.outputs(&taken);
        let gradients = self.gradients(&taken, &of, monitor)?;
        let mut jacobian = [[0.0; INPUTS.len()]; OUTPUTS.len()];
        for (row, gradient) in jacobian.iter_mut().zip(&gradients) {
            row[..6].copy_from_slice(&gradient.pose);
            row[6..8].copy_from_slice(&gradient.velocity);
            row[8] = gradient.magnetic_pressure;
        }
        // the power is a product with the velocity itself
        let unit = self.prepared.power_by_velocity(&taken.traction());
        for (d, unit) in jacobian[6][6..8].iter_mut().zip(unit) {
            *d += unit;
        }
        Ok(jacobian)
    }
}

impl Prepared {
    /// The [`OUTPUTS`] as sums of what a step found.
    pub fn outputs(&self, taken: &Taken) -> Vec<Found> {
        let g = &self.geometry;
        let (n, m) = (g.points(), taken.balanced.len());
        let mut outputs = vec![Found::nothing(n, m); OUTPUTS.len()];
        let [along_x, along_y, normal] = &g.mean_frame;
        for i in 0..n {
            let axes = [along_x, along_y, normal].map(|field| Geometry::vector(field, i));
            let at = Geometry::vector(&g.points, i);
            let arm: [f64; 3] = std::array::from_fn(|c| at[c] - self.reference_point[c]);
            for (axis, vector) in axes.into_iter().enumerate() {
                let turned: [f64; 3] = std::array::from_fn(|c| {
                    let (a, b) = ((c + 1) % 3, (c + 2) % 3);
                    arm[a] * vector[b] - arm[b] * vector[a]
                });
                for (output, load) in outputs.iter_mut().zip(vector.into_iter().chain(turned)) {
                    match axis {
                        2 => output.pressure[i] = -g.area[i] * load,
                        _ => output.traction[axis * n + i] = g.area[i] * load,
                    }
                }
                if axis < 2 {
                    let speed = taken.velocity[0] * vector[0] + taken.velocity[1] * vector[1];
                    outputs[6].traction[axis * n + i] = g.area[i] * speed;
                }
            }
        }
        let pressure = &taken.state.pressure;
        let mean = g.mean_tractions(pressure);
        let mut peak = vec![0.0; n];
        if let Some(at) = (0..n).max_by(|a, b| mean[*a].total_cmp(&mean[*b])) {
            peak[at] = 1.0;
        }
        outputs[7].pressure = g.weights_of_means(&peak, pressure);
        outputs
    }

    /// Heat of sliding [W] of tractions (2n) by a velocity of 1 m/s along x, and along y.
    pub fn power_by_velocity(&self, traction: &[f64]) -> [f64; 2] {
        let g = &self.geometry;
        let n = g.points();
        [0, 1].map(|c| {
            (0..2 * n)
                .map(|k| g.area[k % n] * traction[k] * g.mean_frame[k / n][c * n + k % n])
                .sum()
        })
    }
}

/// What a small change of the pose or of the velocity changes in the contact.
struct Path {
    /// Gap (n) by each component of the pose.
    gap: Vec<Vec<f64>>,
    /// Friction times direction (2n) by each component of the velocity.
    drag: [Vec<f64>; 2],
    /// Loads (n + m) by the speed, and the speed by each component of the velocity; of the scene's own loads.
    loads: Option<(Vec<f64>, [f64; 2])>,
}

impl Path {
    fn of(prepared: &Prepared, taken: &Taken) -> Result<Self, Error> {
        let g = &prepared.geometry;
        let n = g.points();
        let known = taken.pose.map(|v| if v.is_nan() { 0.0 } else { v });
        let turned = rotation_slopes(known[3], known[4], known[5]);
        let mut gap = vec![vec![0.0; n]; 6];
        let is_free = |c: usize| {
            let mut motions = taken.balanced.iter().map(|&k| &prepared.motions[k]);
            motions.any(|motion| motion.component == Some(c))
        };
        for (c, gap) in gap.iter_mut().enumerate().filter(|(c, _)| !is_free(*c)) {
            for (i, gap) in gap.iter_mut().enumerate() {
                let normal = Geometry::vector(&g.mean_frame[2], i);
                if c < 3 {
                    *gap = normal[c];
                    continue;
                }
                let at = Geometry::vector(&g.points, i);
                for row in 0..3 {
                    for column in 0..3 {
                        let arm = at[column] - prepared.reference_point[column];
                        *gap += normal[row] * turned[c - 3][row][column] * arm;
                    }
                }
            }
        }
        let [x, y] = taken.velocity;
        let speed = x.hypot(y);
        let table = prepared.friction.at("friction", speed)?;
        let slope = prepared.friction.slope(speed);
        // friction is `table` times a share that falls to nothing with the speed
        let (share, fall) = match prepared.standstill_speed {
            Some(slow) if speed < slow => (speed / slow, 1.0 / slow),
            _ => (1.0, 0.0),
        };
        let axes = [[1.0, 0.0], [0.0, 1.0]];
        if speed == 0.0 {
            // setting off: friction grows with the speed
            let drag = axes.map(|along| -> Result<Vec<f64>, Error> {
                let direction = g.sliding_direction(along)?;
                let along = direction.iter().enumerate();
                Ok(along.map(|(i, d)| d * fall * table[i % n]).collect())
            });
            let [x, y] = drag;
            return Ok(Self {
                gap,
                drag: [x?, y?],
                loads: None,
            });
        }
        let by_component = [x / speed, y / speed];
        let d = &taken.state.direction;
        let mut drag = [vec![0.0; 2 * n], vec![0.0; 2 * n]];
        for i in 0..n {
            let tangents = [&g.tangent_x, &g.tangent_y].map(|field| Geometry::vector(field, i));
            let length = tangents
                .map(|t| x * t[0] + y * t[1])
                .into_iter()
                .fold(0.0, f64::hypot);
            let by_speed = share * slope[i] + fall * table[i];
            for (c, drag) in drag.iter_mut().enumerate() {
                let along = tangents.map(|t| t[c]);
                let radial = along[0] * d[i] + along[1] * d[n + i];
                for axis in 0..2 {
                    let at = axis * n + i;
                    let turned = (along[axis] - radial * d[at]) / length;
                    drag[at] =
                        by_component[c] * by_speed * d[at] + taken.state.friction[i] * turned;
                }
            }
        }
        let loads = taken
            .is_scene
            .then(|| (prepared.loads.slope(speed), by_component));
        Ok(Self { gap, drag, loads })
    }
}

/// Derivatives of [`rotation`] by roll, pitch and yaw.
fn rotation_slopes(roll: f64, pitch: f64, yaw: f64) -> [[[f64; 3]; 3]; 3] {
    use std::f64::consts::FRAC_PI_2;
    // the derivative of a turn about an axis is the turn by a right angle more, without what stays on the axis
    let all = [0, 1, 2].map(|k| {
        let mut angles = [roll, pitch, yaw];
        angles[k] += FRAC_PI_2;
        rotation(angles[0], angles[1], angles[2])
    });
    let half_turned = [0, 1, 2].map(|k| {
        let mut angles = [roll, pitch, yaw];
        angles[k] += 2.0 * FRAC_PI_2;
        rotation(angles[0], angles[1], angles[2])
    });
    let here = rotation(roll, pitch, yaw);
    // R(a) = c + u cos a + v sin a in each angle: c is the mean of here and half a turn further
    std::array::from_fn(|k| {
        std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                all[k][row][column] - 0.5 * (here[row][column] + half_turned[k][row][column])
            })
        })
    })
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    mtb_operator::krylov::dot(a, b)
}

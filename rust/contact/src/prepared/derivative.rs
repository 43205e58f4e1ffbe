// SPDX-License-Identifier: MIT OR Apache-2.0
//! Derivatives of a step: of its load, power, peak pressure or any sum of its fields, by all that it was given.

use std::sync::Arc;

use mtb_operator::Monitor;

use super::{Prepared, PreparedContact, Pull, Step, rotation};
use crate::error::Error;
use crate::magnet::Pulling;
use crate::problem::{Geometry, Outcome};
use crate::sliding::RigidMotion;
use crate::stepping::{Found, Given, SlidingState, Tangent};

/// The numbers of a step whose derivatives a [`Jacobian`] holds, in its order: force [N] and moment [N m] on the lower
/// body, heat of sliding [W], largest mean pressure [Pa], and the force [N] of a magnet whose pull follows the gap, 0
/// without one.
pub const OUTPUTS: [&str; 9] = [
    "force.x",
    "force.y",
    "force.z",
    "moment.x",
    "moment.y",
    "moment.z",
    "friction_power",
    "peak_pressure",
    "attraction",
];
/// What they are derived by: pose [m], [rad], velocity [m/s], uniform magnetic pressure [Pa], ampere-turns [A] of a magnet.
pub const INPUTS: [&str; 10] = [
    "pose.x",
    "pose.y",
    "pose.z",
    "pose.roll",
    "pose.pitch",
    "pose.yaw",
    "velocity.x",
    "velocity.y",
    "magnetic_pressure",
    "ampere_turns",
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
    /// Friction coefficients (n) that were given.
    friction: Option<Vec<f64>>,
    state: SlidingState,
    /// Which of the prepared motions were found from balance.
    balanced: Vec<usize>,
    /// A magnet whose pull follows the gap, with the change of its factor with the speed.
    magnet: Option<(Pulling, f64)>,
}

/// The gradient of a number by all that a step is given.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient {
    /// By the gap (n) [1/m].
    pub gap: Vec<f64>,
    /// By the friction coefficients (n) that are given: below the standstill speed a share of them acts.
    pub friction: Vec<f64>,
    /// By the work of the loads on each motion (m) [1/J]; 0 for motions that the pose prescribes.
    pub work: Vec<f64>,
    /// By the pose [1/m], [1/rad]; 0 for components found from balance.
    pub pose: [f64; 6],
    /// By the velocity [1/(m/s)], tables over the speed included.
    pub velocity: [f64; 2],
    /// By a uniform magnetic pressure [1/Pa]; 0 where the contact knows of none, and where a magnet follows the gap.
    pub magnetic_pressure: f64,
    /// By the ampere-turns [1/A] of such a magnet; 0 without one.
    pub ampere_turns: f64,
    /// By the pull of a magnet that follows the gap, with all gaps held (n) [1/Pa]; empty without one.
    pub pull: Vec<f64>,
    /// By the hardness (n) [1/Pa]; 0 where the pressure is below it, empty without one.
    pub hardness: Vec<f64>,
}

impl Taken {
    pub(super) fn new(
        prepared: &Prepared,
        step: &Step<'_>,
        outcome: &Outcome,
        direction: Vec<f64>,
        motions: Vec<RigidMotion>,
        balanced: Vec<usize>,
        magnet: Option<(Pulling, f64)>,
    ) -> Self {
        let (friction, pressure) = (&outcome.friction, &outcome.solution.pressure);
        let (yields, slope) = prepared.interface.yields(friction, pressure, friction);
        Self {
            pose: step.pose,
            velocity: step.velocity,
            is_scene: matches!(step.pull, Pull::Scene),
            friction: step.friction.map(<[f64]>::to_vec),
            state: SlidingState {
                area: prepared.geometry.area.clone(),
                pressure: pressure.clone(),
                friction: friction.clone(),
                slope,
                direction,
                motions,
                diagonal: (prepared.interface).softened(step.diagonal, pressure),
                limit: prepared.interface.limit.clone(),
                yields,
            },
            balanced,
            magnet,
        }
    }

    /// The magnet whose pull follows the gap, linearised.
    pub fn pulling(&self) -> Option<&Pulling> {
        self.magnet.as_ref().map(|(pulling, _)| pulling)
    }

    /// Which of the prepared motions were found from balance, in the order of the motions of the step.
    pub fn balanced(&self) -> &[usize] {
        &self.balanced
    }

    /// The velocity [m/s].
    pub fn velocity(&self) -> [f64; 2] {
        self.velocity
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
        let inputs = prepared.inputs(taken)?;
        let share = prepared.share(taken.velocity);
        let mut tangent = self.tangent(taken, monitor)?;
        let given = tangent.adjoint(of, monitor)?;
        let gradients = given.into_iter().map(|given| {
            let mut work = vec![0.0; prepared.motions.len()];
            for (&k, w) in taken.balanced.iter().zip(&given.work) {
                work[k] = *w;
            }
            let by = |k: usize| inputs[k].dot(&given);
            let mut friction = tangent.by_friction(&given);
            for by in &mut friction {
                *by *= share;
            }
            Gradient {
                friction,
                pose: std::array::from_fn(by),
                velocity: [by(6), by(7)],
                magnetic_pressure: by(8),
                ampere_turns: by(9),
                gap: given.gap,
                work,
                pull: given.pull,
                hardness: given.hardness,
            }
        });
        Ok(gradients.collect())
    }

    /// The equations linearised about a step: with the factors that are there, if it is the last one.
    ///
    /// # Errors
    /// An interruption.
    pub fn tangent<'a>(
        &'a mut self,
        taken: &'a Taken,
        monitor: Monitor<'_>,
    ) -> Result<Tangent<'a>, Error> {
        let tangent = self.stepper.tangent(&taken.state, monitor)?;
        Ok(tangent.with_magnet(taken.pulling()))
    }

    /// Derivatives of the load, the heat of sliding and the peak pressure of the last step by its pose, velocity
    /// and magnetic pressure.
    ///
    /// The peak is that at the point where it is now.
    ///
    /// # Errors
    /// [`Error::NoStep`]; as [`PreparedContact::gradients`].
    pub fn jacobian(&mut self, monitor: Monitor<'_>) -> Result<Jacobian, Error> {
        if let Some(jacobian) = self.jacobian {
            return Ok(jacobian);
        }
        let taken = self.taken.clone().ok_or(Error::NoStep)?;
        let of = self.prepared.outputs(&taken);
        let gradients = self.gradients(&taken, &of, monitor)?;
        let mut jacobian = [[0.0; INPUTS.len()]; OUTPUTS.len()];
        for (row, gradient) in jacobian.iter_mut().zip(&gradients) {
            row[..6].copy_from_slice(&gradient.pose);
            row[6..8].copy_from_slice(&gradient.velocity);
            row[8] = gradient.magnetic_pressure;
            row[9] = gradient.ampere_turns;
        }
        // the power is a product with the velocity itself
        let unit = self.prepared.power_by_velocity(&taken.traction());
        for (d, unit) in jacobian[6][6..8].iter_mut().zip(unit) {
            *d += unit;
        }
        self.jacobian = Some(jacobian);
        Ok(jacobian)
    }
}

impl Prepared {
    /// The [`OUTPUTS`] as sums of what a step found; without a magnet all but the last one.
    pub fn outputs(&self, taken: &Taken) -> Vec<Found> {
        let g = &self.geometry;
        let (n, m) = (g.points(), taken.balanced.len());
        // without a magnet nothing else attracts
        let count = OUTPUTS.len() - usize::from(taken.magnet.is_none());
        let mut outputs = vec![Found::nothing(n, m); count];
        let resultants = g.weights_of_resultants(self.reference_point);
        for (output, weights) in outputs.iter_mut().zip(&resultants) {
            output.traction.copy_from_slice(&weights[..2 * n]);
            output.pressure.copy_from_slice(&weights[2 * n..]);
        }
        // heat is what friction does along the velocity
        for (weights, v) in resultants.iter().zip(taken.velocity) {
            for (power, weight) in outputs[6].traction.iter_mut().zip(weights) {
                *power += v * weight;
            }
        }
        outputs[7].pressure = self.weights_of_peak(&taken.state.pressure);
        if let Some(attraction) = outputs.get_mut(8) {
            attraction.pull.clone_from(&g.area);
        }
        outputs
    }

    /// The largest mean pressure over a point as a sum over pressures (n).
    pub(super) fn weights_of_peak(&self, pressure: &[f64]) -> Vec<f64> {
        let g = &self.geometry;
        let mean = g.mean_tractions(pressure);
        let mut peak = vec![0.0; mean.len()];
        if let Some(at) = (0..mean.len()).max_by(|a, b| mean[*a].total_cmp(&mean[*b])) {
            peak[at] = 1.0;
        }
        g.weights_of_means(&peak, pressure)
    }

    /// What a unit of each of the [`INPUTS`] of a step changes in what its contact is given.
    ///
    /// # Errors
    /// A speed outside the tables.
    pub fn inputs(&self, taken: &Taken) -> Result<[Given; INPUTS.len()], Error> {
        let g = &self.geometry;
        let (n, m) = (g.points(), taken.balanced.len());
        let mut inputs: [Given; INPUTS.len()] = std::array::from_fn(|_| Given::nothing(n, m));
        self.add_pose_slopes(taken, &mut inputs[..6]);
        if let (Some([_, unit]), None) = (&self.magnetic, &taken.magnet) {
            self.add_loads(taken, unit, 1.0, &mut inputs[8]);
        }
        if let Some(pulling) = taken.pulling() {
            inputs[9]
                .pull
                .clone_from(&pulling.slopes().of_parameters()[0]);
        }
        let [x, y] = taken.velocity;
        let speed = x.hypot(y);
        let (table, slope) = match &taken.friction {
            Some(given) => (given.clone(), vec![0.0; n]),
            None => (
                self.friction.at("friction", speed)?,
                self.friction.slope(speed),
            ),
        };
        // friction is `table` times a share that falls to nothing with the speed
        let (share, fall) = match self.standstill_speed {
            Some(slow) if speed < slow => (speed / slow, 1.0 / slow),
            _ => (1.0, 0.0),
        };
        if speed == 0.0 {
            // setting off: friction grows with the speed
            for (input, along) in inputs[6..8].iter_mut().zip([[1.0, 0.0], [0.0, 1.0]]) {
                input.drag = g.sliding_direction(along)?;
                for (k, drag) in input.drag.iter_mut().enumerate() {
                    *drag *= fall * table[k % n];
                }
            }
            return Ok(inputs);
        }
        let by_component = [x / speed, y / speed];
        if let Some((pulling, by_speed)) = &taken.magnet
            && let [.., by_factor] = pulling.slopes().of_parameters()
        {
            for (input, share) in inputs[6..8].iter_mut().zip(by_component) {
                input.pull = by_factor.iter().map(|p| share * by_speed * p).collect();
            }
        }
        let d = &taken.state.direction;
        for i in 0..n {
            let tangents = [&g.tangent_x, &g.tangent_y].map(|field| Geometry::vector(field, i));
            let [along, across] = tangents.map(|t| x * t[0] + y * t[1]);
            let length = along.hypot(across);
            let by_speed = share * slope[i] + fall * table[i];
            for c in 0..2 {
                let along = tangents.map(|t| t[c]);
                let radial = along[0] * d[i] + along[1] * d[n + i];
                for axis in 0..2 {
                    let at = axis * n + i;
                    let turned = (along[axis] - radial * d[at]) / length;
                    inputs[6 + c].drag[at] =
                        by_component[c] * by_speed * d[at] + taken.state.friction[i] * turned;
                }
            }
        }
        if taken.is_scene {
            let loads = self.loads.slope(speed);
            for (input, share) in inputs[6..8].iter_mut().zip(by_component) {
                self.add_loads(taken, &loads, share, input);
            }
        }
        Ok(inputs)
    }

    /// Adds `share` of a row of loads: gap, then work on each motion.
    fn add_loads(&self, taken: &Taken, row: &[f64], share: f64, to: &mut Given) {
        let (gap, work) = row.split_at(self.geometry.points());
        for (to, gap) in to.gap.iter_mut().zip(gap) {
            *to += share * gap;
        }
        for (to, &k) in to.work.iter_mut().zip(&taken.balanced) {
            *to += share * work[k];
        }
    }

    /// Gaps by each component of the pose; none by those found from balance.
    fn add_pose_slopes(&self, taken: &Taken, inputs: &mut [Given]) {
        for (c, input) in inputs.iter_mut().enumerate() {
            if let Some(moved) = self.moved_by(&taken.pose, &taken.balanced, c) {
                self.open(&moved, &mut input.gap);
            }
        }
    }

    /// Displacement (3n) of the points of the upper body by a component of the pose; `None` of those that are found from
    /// balance.
    pub(super) fn moved_by(
        &self,
        pose: &[f64; 6],
        balanced: &[usize],
        component: usize,
    ) -> Option<Vec<f64>> {
        let mut balanced = balanced.iter().map(|&k| &self.motions[k]);
        if balanced.any(|motion| motion.component == Some(component)) {
            return None;
        }
        let (g, n) = (&self.geometry, self.geometry.points());
        if component < 3 {
            return Some(
                (0..3 * n)
                    .map(|k| f64::from(u8::from(k / n == component)))
                    .collect(),
            );
        }
        let known = pose.map(|v| if v.is_nan() { 0.0 } else { v });
        let turned = rotation_slopes(known[3], known[4], known[5])[component - 3];
        let mut moved = vec![0.0; 3 * n];
        for i in 0..n {
            let at = Geometry::vector(&g.points, i);
            for (row, turned) in turned.iter().enumerate() {
                let arms = turned.iter().zip(at).zip(self.reference_point);
                moved[row * n + i] = arms.map(|((t, x), about)| t * (x - about)).sum();
            }
        }
        Some(moved)
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

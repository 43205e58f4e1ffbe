// SPDX-License-Identifier: MIT OR Apache-2.0
//! Derivatives of the heat of friction: of a sum of products of tractions and slips.

use mtb_operator::Kernel;
use mtb_operator::krylov::dot;

use super::change::{TangentialChange, TangentialResponse};
use super::dissipation::{Surroundings, slip_behind};
use super::given::rigid_slip;
use super::operators::Motion;
use super::problem::{Drive, TangentialProblem};
use super::tangent::{TangentialTangent, add, turned};

impl<'a> TangentialTangent<'a> {
    /// Change of the dissipation by a change of what is given and what follows from it; `slip` (2n): that of the slip over
    /// the steps that end at the cells.
    pub(super) fn dissipated(
        &self,
        around: Surroundings,
        change: &TangentialChange,
        response: &TangentialResponse,
        slip: &[f64],
    ) -> Vec<f64> {
        let (operators, problem, state) = (self.operators, self.problem, self.state);
        let grid = operators.grid();
        let n = grid.points();
        let work = |traction: &[f64], slip: &[f64], k: usize| {
            0.5 * (traction[k] * slip[k] + traction[n + k] * slip[n + k])
        };
        let mut heat = vec![0.0; around.shape[0] * around.shape[1]];
        for k in 0..n {
            heat[around.cell(&grid, k, [0, 0])] +=
                work(state.traction, slip, k) + work(&response.traction, &self.slip_at_faces, k);
        }
        let Some(before) = self.before() else {
            return heat;
        };
        let changed_before = match operators.motion {
            Motion::Steady { .. } => &response.traction,
            _ => &change.earlier.traction,
        };
        let behind = slip_behind(operators, problem, state.traction, state.drive);
        let pressure = self.in_contact(&change.pressure);
        let moved = TangentialProblem {
            pressure: &pressure,
            drive: response.drive.map(Drive::Slip),
            spin: change.spin,
            earlier: problem.earlier.map(|_| &change.earlier),
            rigid_slip: None,
            ..problem.clone()
        };
        // it is linear in all of these
        let mut changed_behind = slip_behind(operators, &moved, &response.traction, response.drive);
        add(&mut changed_behind, 1.0, &change.rigid_slip_behind);
        add(&mut changed_behind, change.layer, &self.behind_by_layer());
        around.add_behind(operators, &mut heat, |k| {
            work(before, &changed_behind, k) + work(changed_before, &behind, k)
        });
        heat
    }

    /// Puts the weights of the dissipation onto what it is made of: onto what is found, and onto what is given; returns those
    /// of the slip (2n) over the steps that end at the cells.
    pub(super) fn weigh_dissipation(
        &self,
        around: Surroundings,
        weights: &mut TangentialResponse,
        change: &mut TangentialChange,
    ) -> Vec<f64> {
        let (operators, problem, state) = (self.operators, self.problem, self.state);
        let grid = operators.grid();
        let n = grid.points();
        let mut slip = vec![0.0; 2 * n];
        for c in [0, n] {
            for k in 0..n {
                let weight = 0.5 * weights.dissipation[around.cell(&grid, k, [0, 0])];
                weights.traction[c + k] += weight * self.slip_at_faces[c + k];
                slip[c + k] = weight * state.traction[c + k];
            }
        }
        let Some(before) = self.before() else {
            return slip;
        };
        let mean = around.mean_behind(operators, &weights.dissipation);
        let weighted = |field: &[f64]| -> Vec<f64> {
            (0..2 * n).map(|k| 0.5 * mean[k % n] * field[k]).collect()
        };
        let behind = slip_behind(operators, problem, state.traction, state.drive);
        let of_before = match operators.motion {
            Motion::Steady { .. } => &mut weights.traction,
            _ => &mut change.earlier.traction,
        };
        add(of_before, 1.0, &weighted(&behind));
        // what is left are weights of the slip behind
        let of_slip = weighted(before);
        let length = self.length();
        add(&mut change.rigid_slip_behind, 1.0, &of_slip);
        for c in 0..2 {
            weights.drive[c] += of_slip[c * n..(c + 1) * n].iter().sum::<f64>();
        }
        let turning = TangentialProblem {
            spin: 1.0,
            rigid_slip: None,
            ..problem.clone()
        };
        let back = operators.behind();
        change.spin += dot(&rigid_slip(operators, &turning, [0.0; 2], back), &of_slip) / length;
        change.layer += dot(&self.behind_by_layer(), &of_slip);
        self.weigh_slip_behind(&of_slip, weights, change);
        slip
    }

    /// The transpose of the displacements in the slip behind.
    fn weigh_slip_behind(
        &self,
        of_slip: &[f64],
        weights: &mut TangentialResponse,
        change: &mut TangentialChange,
    ) {
        let operators = self.operators;
        let n = operators.grid().points();
        let transform = operators.transform();
        let scale = 1.0 / self.length();
        let fine = &operators.levels[0].slip;
        if let Some(across) = &operators.across_behind {
            let (along, aside) = weights.traction.split_at_mut(n);
            let loads = [Some(along), Some(aside), Some(&mut change.pressure[..])];
            across.add_transposed(-scale, of_slip, loads);
        }
        let sum_of = |kernels: &Option<[Kernel; 2]>, scale: f64, field: &[f64]| {
            let mut sum = vec![0.0; n];
            if let Some([along, across]) = kernels {
                transform.apply_add(along, scale, &field[..n], &mut sum);
                transform.apply_add(across, scale, &field[n..], &mut sum);
            }
            sum
        };
        if let Some(behind) = &operators.behind {
            // without symmetry, from the other end
            let seen = turned(of_slip);
            let mut image = vec![0.0; 2 * n];
            behind.apply_add(transform, -1.0, &seen, &mut image);
            add(&mut weights.traction, scale, &turned(&image));
            let by_pressure = sum_of(&operators.pressure_behind, scale, &seen);
            let pairs = change.pressure.iter_mut().zip(by_pressure.iter().rev());
            pairs.for_each(|(to, v)| *to += v);
            return;
        }
        if matches!(operators.motion, Motion::Steady { .. }) {
            let mut sums = vec![0.0; 3 * n];
            fine.weigh_reversed(of_slip, &mut sums);
            add(&mut weights.traction, scale, &sums[..2 * n]);
            add(&mut change.pressure, scale, &sums[2 * n..]);
            let by_pressure = sum_of(&operators.pressure_now, scale, of_slip);
            add(&mut change.pressure, 1.0, &by_pressure);
            return;
        }
        if let Some(kernels) = &operators.earlier {
            let (mut traction, mut pressure) = (vec![0.0; 2 * n], vec![0.0; n]);
            match &operators.turn {
                Some(turn) => kernels.apply_turned_transposed(
                    transform,
                    turn,
                    of_slip,
                    &mut traction,
                    &mut pressure,
                ),
                None => kernels.apply(transform, of_slip, &mut traction),
            }
            add(&mut weights.traction, -scale, &traction);
            add(&mut change.pressure, -scale, &pressure);
        }
        for c in 0..2 {
            let part = c * n..(c + 1) * n;
            let ahead = operators.layer_ahead(&of_slip[part.clone()]);
            add(
                &mut weights.traction[part],
                -scale * operators.layer,
                &ahead,
            );
        }
        let by_pressure = sum_of(&operators.pressure_earlier, -scale, of_slip);
        add(&mut change.pressure, 1.0, &by_pressure);
        let turned_slip = turned(of_slip);
        let (mut image, mut pressure) = (vec![0.0; 2 * n], vec![0.0; n]);
        fine.apply_transposed(of_slip, &mut image, &mut pressure);
        add(&mut change.earlier.traction, scale, &image);
        add(&mut change.earlier.pressure, scale, &pressure);
        let by_pressure = sum_of(&operators.pressure_now, -scale, &turned_slip);
        for (to, v) in change
            .earlier
            .pressure
            .iter_mut()
            .zip(by_pressure.iter().rev())
        {
            *to += v;
        }
    }

    /// Tractions of the particles one step earlier, where they are now one step behind.
    fn before(&self) -> Option<&'a [f64]> {
        match (self.operators.motion, self.problem.earlier) {
            (Motion::Steady { .. }, _) => Some(self.state.traction),
            (_, Some(earlier)) => Some(&earlier.traction),
            _ => None,
        }
    }

    /// Slip one step behind by a unit of the layer, in the unit of the slip.
    fn behind_by_layer(&self) -> Vec<f64> {
        let operators = self.operators;
        let n = operators.grid().points();
        let is_steady = matches!(operators.motion, Motion::Steady { .. });
        let length = if is_steady {
            operators.motion.step_length()
        } else {
            self.length()
        };
        // in a steady state the particles there carry what those here do now
        let mut slip = self
            .before()
            .map_or_else(|| vec![0.0; 2 * n], <[f64]>::to_vec);
        for c in 0..2 {
            let part = c * n..(c + 1) * n;
            let behind = operators.layer_behind(&self.state.traction[part.clone()]);
            add(&mut slip[part], -1.0, &behind);
        }
        slip.iter().map(|s| s / length).collect()
    }

    /// The rigid slip (2n) one step behind that does the same as the bodies of `other` operators; see
    /// [`TangentialTangent::slip_by_bodies`].
    pub fn slip_behind_by_bodies(&self, other: &super::PatchOperators) -> Vec<f64> {
        let still = TangentialProblem {
            drive: [Drive::Slip(0.0); 2],
            spin: 0.0,
            rigid_slip: None,
            ..self.problem.clone()
        };
        slip_behind(other, &still, self.state.traction, [0.0; 2])
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use std::borrow::Cow;

use mtb_operator::Grid;

use super::change::TangentialState;
use super::given::{image_at_faces, rigid_slip};
use super::operators::{Motion, PatchOperators};
use super::problem::{Drive, TangentialProblem, TangentialSolution};
use super::table::upstream;
use crate::inclination::Turn;

/// A grid that holds the cells of a patch, and cells around them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surroundings {
    /// Cells along x and y.
    pub shape: [usize; 2],
    /// Column and row of the first cell of the patch, which may lie outside.
    pub first: [isize; 2],
}

/// Work of friction that turns into heat, on the cells of `around`: in rolling [Pa], work per area and distance
/// rolled; in a shift [J/m2].
///
/// A particle feels the mean of its tractions before and after a step: half of the traction of every cell works
/// on the slip where the particle is now, half of its earlier one on the slip one step behind. As the influence
/// of the cells is symmetric, the elastic parts cancel in the sum, which is the work of the mean traction on the
/// rigid slip (between unlike bodies, also on the slip by pressure) less the growth of the elastic energy, which
/// is zero in steady rolling. Traction times slip cell by cell misses a tenth on coarse grids.
///
/// Behind the trailing edge a column without traction takes part; what lies beyond `around` goes to its border.
pub fn dissipation(
    operators: &PatchOperators,
    problem: &TangentialProblem<'_>,
    solution: &TangentialSolution,
    around: Surroundings,
) -> Vec<f64> {
    let state = solution.state();
    let slip = slip_at_faces(operators, problem, &state);
    heat_of(operators, problem, &state, &slip, around)
}

/// [`dissipation()`] of a state with the slip (2n) over the steps that end at the cells.
pub(super) fn heat_of(
    operators: &PatchOperators,
    problem: &TangentialProblem<'_>,
    solution: &TangentialState<'_>,
    slip: &[f64],
    around: Surroundings,
) -> Vec<f64> {
    around.sum_of(operators, &works(operators, problem, solution, slip))
}

/// Work of half of the traction of every cell, over a step: where the particle is now (n), and of half of its earlier
/// one a step behind (n), or empty where there was none.
pub(super) fn works(
    operators: &PatchOperators,
    problem: &TangentialProblem<'_>,
    solution: &TangentialState<'_>,
    slip: &[f64],
) -> [Vec<f64>; 2] {
    let n = operators.grid().points();
    let work = |traction: &[f64], slip: &[f64]| -> Vec<f64> {
        let of = |k: usize| 0.5 * (traction[k] * slip[k] + traction[n + k] * slip[n + k]);
        (0..n).map(of).collect()
    };
    let before = match (operators.motion, problem.earlier) {
        (Motion::Steady { .. }, _) => Some(solution.traction),
        (_, earlier) => earlier.map(|earlier| earlier.traction.as_slice()),
    };
    let behind = before.map(|before| {
        let slip = slip_behind(operators, problem, solution.traction, solution.drive);
        work(before, &slip)
    });
    [work(solution.traction, slip), behind.unwrap_or_default()]
}

/// Slip (2n) over a step that ends at every cell: that of the cells, or of second order, at their leading faces.
pub(super) fn slip_at_faces<'a>(
    operators: &PatchOperators,
    problem: &TangentialProblem<'_>,
    solution: &TangentialState<'a>,
) -> Cow<'a, [f64]> {
    if !operators.has_faces() {
        return Cow::Borrowed(solution.slip);
    }
    let mut given = problem.clone();
    given.drive = solution.drive.map(Drive::Slip);
    let image = image_at_faces(operators, &given, solution.traction);
    let length = operators.motion.length();
    image.iter().map(|f| -f / length).collect()
}

impl Surroundings {
    /// Heat on these cells by the [`works`].
    pub(super) fn sum_of(
        &self,
        operators: &PatchOperators,
        [now, behind]: &[Vec<f64>; 2],
    ) -> Vec<f64> {
        let grid = operators.grid();
        let mut heat = vec![0.0; self.shape[0] * self.shape[1]];
        for (k, work) in now.iter().enumerate() {
            heat[self.cell(&grid, k, [0, 0])] += work;
        }
        if !behind.is_empty() {
            self.add_behind(operators, &mut heat, |k| behind[k]);
        }
        heat
    }

    /// Adds what every cell of the patch gives to those one step behind it.
    pub(super) fn add_behind(
        &self,
        operators: &PatchOperators,
        heat: &mut [f64],
        given: impl Fn(usize) -> f64,
    ) {
        let behind = self.behind(operators);
        for k in 0..operators.grid().points() {
            for (cell, weight) in behind(k) {
                heat[cell] += weight * given(k);
            }
        }
    }

    /// The cells one step behind each cell of the patch, with their weights.
    pub(super) fn behind(self, operators: &PatchOperators) -> impl Fn(usize) -> [(usize, f64); 4] {
        let grid = operators.grid();
        let places = upstream(&grid, operators.motion.step().map(|d| -d));
        move |k| places.map(|(to, weight)| (self.cell(&grid, k, to), weight))
    }

    /// For every cell of the patch the mean of a field over those one step behind it: the transpose of
    /// [`Surroundings::add_behind`].
    pub(super) fn mean_behind(&self, operators: &PatchOperators, field: &[f64]) -> Vec<f64> {
        let behind = self.behind(operators);
        let mean = |k: usize| {
            behind(k)
                .map(|(cell, weight)| weight * field[cell])
                .iter()
                .sum()
        };
        (0..operators.grid().points()).map(mean).collect()
    }

    /// The cell that is `away` from the cell `k` of the patch, or next to it on the border.
    pub(super) fn cell(&self, patch: &Grid, k: usize, away: [isize; 2]) -> usize {
        let place = |c: usize, at: usize| {
            let there = self.first[c] + at as isize + away[c];
            there.clamp(0, self.shape[c] as isize - 1) as usize
        };
        place(1, k / patch.nx) * self.shape[0] + place(0, k % patch.nx)
    }
}

/// Slip (2n) one step behind every cell, in the unit of [`TangentialSolution::slip`].
///
/// Seen from there, all offsets have the other sign: what the tractions do is symmetric, what the pressure does
/// antisymmetric, so no further kernels are needed but for bodies that creep.
pub(super) fn slip_behind(
    operators: &PatchOperators,
    problem: &TangentialProblem<'_>,
    traction: &[f64],
    drive: [f64; 2],
) -> Vec<f64> {
    let grid = operators.grid();
    let n = grid.points();
    let transform = operators.transform();
    let mut slip = rigid_slip(operators, problem, drive, operators.behind());
    let turned = |field: &[f64]| -> Vec<f64> {
        field
            .chunks_exact(n)
            .flat_map(|part| part.iter().rev().copied())
            .collect()
    };
    // products with transposed kernels, on fields seen from the other end
    let mut reversed = vec![0.0; 2 * n];
    let pressure = turned(problem.pressure);
    let add_pressure = |kernels: &Option<[_; 2]>, scale: f64, pressure: &[f64], to: &mut [f64]| {
        if let Some([along, across]) = kernels {
            let (first, second) = to.split_at_mut(n);
            transform.apply_add(along, scale, pressure, first);
            transform.apply_add(across, scale, pressure, second);
        }
    };
    if let Some(behind) = &operators.behind {
        behind.apply_add(transform, -1.0, traction, &mut slip);
        add_pressure(&operators.pressure_behind, 1.0, problem.pressure, &mut slip);
    } else if matches!(operators.motion, Motion::Steady { .. }) {
        let fine = &operators.levels[0].slip;
        fine.apply_reversed(&turned(traction), Some(&pressure), &mut reversed);
        add_pressure(&operators.pressure_now, 1.0, &pressure, &mut reversed);
    } else {
        if let Some(kernels) = &operators.earlier {
            let traction = turned(traction);
            match operators.turn.as_ref().map(Turn::reversed) {
                Some(turn) => {
                    let there = Some(pressure.as_slice());
                    kernels.apply_turned(transform, &turn, &traction, there, &mut reversed);
                }
                None => kernels.apply(transform, &traction, &mut reversed),
            }
            for r in &mut reversed {
                *r = -*r;
            }
        }
        add_pressure(&operators.pressure_earlier, -1.0, &pressure, &mut reversed);
        for c in 0..2 {
            let part = c * n..(c + 1) * n;
            let back = operators.layer_behind(&traction[part.clone()]);
            for (s, q) in slip[part].iter_mut().zip(back) {
                *s -= operators.layer * q;
            }
        }
        if let Some(earlier) = problem.earlier {
            let mut back = vec![0.0; 2 * n];
            let fine = &operators.levels[0].slip;
            fine.apply_to(&earlier.traction, Some(&earlier.pressure), &mut back);
            slip.iter_mut().zip(back).for_each(|(s, b)| *s += b);
            add_pressure(&operators.pressure_now, -1.0, &earlier.pressure, &mut slip);
        }
    }
    if let Some(across) = &operators.across_behind {
        let (along, aside) = traction.split_at(n);
        let loads = [Some(along), Some(aside), Some(problem.pressure)];
        across.add(-1.0, loads, &mut slip);
    }
    let length = operators.motion.length();
    for (s, r) in slip.iter_mut().zip(turned(&reversed)) {
        *s = (*s + r) / length;
    }
    slip
}

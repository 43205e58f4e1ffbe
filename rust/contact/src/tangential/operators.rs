// SPDX-License-Identifier: MIT OR Apache-2.0
use std::sync::Arc;

use mtb_operator::{Buffers, Grid, Kernel, Transform};

use super::faces::{Faces, LayerShare};
use super::given::mixed;
use super::kernels::BlockKernels;
use super::level::Level;
use super::levels::Coarsening;
use super::table::{Influences, LayerStencil, Pressed, Share, Table, upstream};
use crate::Error;
use crate::across::{Across, RowInfluence};
use crate::error::check_number;
use crate::inclination::{Inclination, Turn};

/// Displacement [m/Pa] at an offset from the centre of a loaded cell: `(cell, offset)`, both [m].
pub(super) type Influence<'a, const N: usize> = &'a (dyn Fn([f64; 2], [f64; 2]) -> [f64; N] + Sync);

/// What the tangential problem needs to know of the two bodies on a regular grid.
#[derive(Clone, Copy)]
pub struct Bodies<'a> {
    /// Displacement of the lower body relative to the upper one by a unit traction on the lower body:
    /// components xx, xy = yx, yy; where it `is_mirrored` xx and yy even, xy odd in both offsets.
    pub tangential: Influence<'a, 3>,
    /// Displacement (x, y) of the upper body relative to the lower one by a unit pressure; `None`
    /// where it cancels (like materials).
    pub by_pressure: Option<Influence<'a, 2>>,
    /// Thickness over shear modulus of a layer between the bodies [m/Pa].
    pub layer: f64,
    /// Whether tractions do the same at opposite offsets. Bodies that creep do not, and only roll steadily.
    pub is_mirrored: bool,
    /// How the surface is inclined across the rows of cells, at the place y [m] from the first row: like bodies, whose
    /// steps are along the rows.
    pub inclination: Option<Inclination<'a>>,
    /// What the rows of cells of the finest grid move each other by besides: elastic bodies whose steps are along the
    /// rows.
    pub across: Option<RowInfluence<'a>>,
}

/// What kind of motion operators are made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// One finite displacement.
    Shift,
    /// Rolling by one step from an earlier state.
    Transient {
        /// The step (x, y) [m].
        step: [f64; 2],
    },
    /// Steady rolling.
    Steady {
        /// The step (x, y) [m] over which slip is measured.
        step: [f64; 2],
    },
}

impl Motion {
    /// The step (x, y) [m]; none of a shift.
    pub fn step(self) -> [f64; 2] {
        match self {
            Self::Shift => [0.0; 2],
            Self::Transient { step } | Self::Steady { step } => step,
        }
    }

    pub(super) fn step_length(self) -> f64 {
        let [x, y] = self.step();
        x.hypot(y)
    }

    /// Images [m] of a unit of slip.
    pub(super) fn length(self) -> f64 {
        match self {
            Self::Transient { .. } => self.step_length(),
            _ => 1.0,
        }
    }
}

/// The operators of one patch of cells, on its own grid and on coarser ones, for one kind of motion.
///
/// Independent of pressure, friction and creepage, so one set serves a whole creep curve or all
/// steps of a transient.
pub struct PatchOperators {
    pub(super) motion: Motion,
    pub(super) layer: f64,
    /// From the finest to the coarsest.
    pub(super) levels: Arc<Vec<Level>>,
    pub(super) coarsenings: Arc<Vec<Coarsening>>,
    /// Influence of the earlier tractions one step ahead, for transient rolling and shifts.
    pub(super) earlier: Option<BlockKernels>,
    /// Influence of the tractions without a layer, in steady rolling: [`PatchOperators::with_flexibility`].
    pub(super) flexibility: Option<BlockKernels>,
    /// Slip by the pressure now, and displacement by the earlier pressure one step ahead.
    pub(super) pressure_now: Option<[Kernel; 2]>,
    pub(super) pressure_earlier: Option<[Kernel; 2]>,
    /// Slip one step behind by the tractions and the pressure, in steady rolling of bodies without symmetry.
    pub(super) behind: Option<BlockKernels>,
    pub(super) pressure_behind: Option<[Kernel; 2]>,
    /// How the rows are inclined, if they are.
    pub(super) turn: Option<Turn>,
    /// What the rows move each other by one step ahead, and one step behind less what they do here in steady rolling.
    pub(super) across_ahead: Option<Across>,
    pub(super) across_behind: Option<Across>,
    /// Where the step leads, between cells, as a layer sees it.
    between: Vec<Share>,
    /// Of the tractions, for other steps of transient rolling.
    influences: Option<Arc<Influences>>,
    /// Whether slip is that of the cells, not of their leading faces.
    is_second_order: bool,
    /// What ties cells of slip of second order to those behind them: what a traction slips at its own leading face, in the
    /// unit of the image over [`Motion::length`], without a layer.
    pub(super) stiffness: f64,
}

/// Share of the step by which the place is ahead where the rigid slip is taken. [Vollebregt2012]
pub const SPIN_ADVANCE: f64 = 1.0 / 6.0;

/// Cells beyond the grid up to which influences are kept: steps of a cell, and half of one across.
const MARGIN: usize = 3;

impl PatchOperators {
    /// Prepares the operators of a patch of cells.
    ///
    /// # Errors
    /// [`Error::Number`] for a step or a layer that makes no sense.
    pub fn new(bodies: &Bodies<'_>, grid: Grid, motion: Motion) -> Result<Self, Error> {
        check_number(
            "layer",
            bodies.layer,
            bodies.layer >= 0.0,
            "thickness over shear modulus must not be negative",
        )?;
        let length = motion.step_length();
        check_number(
            "step",
            length,
            motion == Motion::Shift || length > 0.0,
            "a positive step is needed",
        )?;
        if !bodies.is_mirrored && !matches!(motion, Motion::Steady { .. }) {
            return Err(Error::NoHistory);
        }
        if bodies.inclination.is_some() {
            let is_alike = bodies.by_pressure.is_none() && bodies.is_mirrored;
            if !is_alike || motion.step()[1].abs() > 1e-9 * length {
                return Err(Error::InclinedUnlike);
            }
        }
        if bodies.across.is_some() {
            let is_along = motion.step()[1].abs() <= 1e-9 * length;
            if !is_along || !bodies.is_mirrored || bodies.inclination.is_some() {
                return Err(Error::AcrossRows);
            }
        }
        let buffers = Buffers::default();
        let finest = grid.dy;
        let mut first = Level::new(bodies, grid, motion, finest, &buffers);
        if let Some(influence) = bodies.across {
            let terms: &[(f64, f64)] = match motion {
                Motion::Steady { step } => &[(1.0 / length, 0.0), (-1.0 / length, step[0])],
                _ => &[(1.0, 0.0)],
            };
            let across = Across::new(grid, influence, terms, &[0, 1]);
            first.slip = first.slip.with_across(across);
        }
        let mut levels = vec![first];
        let mut coarsenings = Vec::new();
        while let Some(next) = Coarsening::of(levels[levels.len() - 1].grid) {
            let grid = next.coarse;
            let motion = match motion {
                Motion::Steady { step } => {
                    let scale = f64::powi(2.0, coarsenings.len() as i32 + 1);
                    Motion::Steady {
                        step: step.map(|d| d * scale),
                    }
                }
                other => other,
            };
            coarsenings.push(next);
            levels.push(Level::new(bodies, grid, motion, finest, &buffers));
        }
        let margin = if motion == Motion::Shift { MARGIN } else { 0 };
        let cells = [grid.nx, grid.ny].map(|n| n + margin);
        let table = Table::new(bodies, &grid, cells, motion.step());
        let (levels, coarsenings) = (Arc::new(levels), Arc::new(coarsenings));
        Ok(Self::on(bodies, levels, coarsenings, motion, &table))
    }

    /// Those of the same bodies on the same cells for transient rolling along x by a `step` (x, y) [m] of any
    /// part of a cell.
    ///
    /// The displacement by earlier tractions is linear along x between the cells, and cubic across [Keys1981]: upwind
    /// differences, with which steps of any part of a cell end at the steady rolling of whole ones. (Evaluated where the
    /// particles come from, as of [`PatchOperators::new`], steps of a fifth of a cell and less end at forces that are up
    /// to 3 % of the friction bound away.) No influence is found anew.
    ///
    /// # Errors
    /// [`Error::Number`] for a step of no length.
    pub fn rolling_by(&self, bodies: &Bodies<'_>, step: [f64; 2]) -> Result<Self, Error> {
        if matches!(self.motion, Motion::Steady { .. }) {
            return Self::new(bodies, self.grid(), Motion::Shift)?.rolling_by(bodies, step);
        }
        let motion = Motion::Transient { step };
        let length = motion.step_length();
        check_number("step", length, length > 0.0, "a positive step is needed")?;
        let known = self.influences.as_ref();
        let table = Table::between_cells(bodies, &self.grid(), step, known);
        // what the tractions of now do knows no step
        let (levels, coarsenings) = (self.levels.clone(), self.coarsenings.clone());
        let made = Self::on(bodies, levels, coarsenings, motion, &table);
        Ok(Self {
            is_second_order: self.is_second_order,
            ..made
        })
    }

    /// The operators of bodies and a motion for which grids are ready.
    fn on(
        bodies: &Bodies<'_>,
        levels: Arc<Vec<Level>>,
        coarsenings: Arc<Vec<Coarsening>>,
        motion: Motion,
        table: &Table<'_>,
    ) -> Self {
        let length = motion.step_length();
        let Level {
            transform, grid, ..
        } = &levels[0];
        let earlier = match motion {
            Motion::Steady { .. } => None,
            _ => Some(BlockKernels::ahead(transform, table, grid)),
        };
        let behind = (!bodies.is_mirrored).then(|| {
            let layer = LayerStencil::new(grid, motion.step().map(|d| -d));
            let value = |i: isize, j: isize, c: usize| {
                let own = if c == 1 {
                    0.0
                } else {
                    bodies.layer * layer.difference(i, j)
                };
                (table.behind(i, j)[c] - table.here(i, j)[c] - own) / length
            };
            BlockKernels {
                xx: transform.kernel(|i, j| value(i, j, 0)),
                xy: transform.kernel(|i, j| value(i, j, 1)),
                yy: transform.kernel(|i, j| value(i, j, 2)),
            }
        });
        let mut pressure_now = None;
        let mut pressure_behind = None;
        let mut pressure_earlier = None;
        if let Some(by_pressure) = bodies.by_pressure {
            let cell = [grid.dx, grid.dy];
            let step = motion.step();
            let at = |i: isize, j: isize, ahead: f64| {
                let x = i as f64 * cell[0] + ahead * step[0];
                let y = j as f64 * cell[1] + ahead * step[1];
                by_pressure(cell, [x, y])
            };
            let pair = |f: &(dyn Fn(isize, isize, usize) -> f64 + Sync)| {
                [0, 1].map(|c| transform.kernel(|i, j| f(i, j, c)))
            };
            if matches!(motion, Motion::Steady { .. }) {
                // slip by pressure: minus the derivative of the displacement along the step
                pressure_now = Some(pair(&|i, j, c| {
                    (at(i, j, 0.0)[c] - at(i, j, 1.0)[c]) / length
                }));
                if !bodies.is_mirrored {
                    pressure_behind = Some(pair(&|i, j, c| {
                        (at(i, j, -1.0)[c] - at(i, j, 0.0)[c]) / length
                    }));
                }
            } else {
                pressure_now = Some(pair(&|i, j, c| at(i, j, 0.0)[c]));
                pressure_earlier = Some(match table.between() {
                    None => pair(&|i, j, c| at(i, j, 1.0)[c]),
                    Some(between) => {
                        let here = Pressed::new(by_pressure, grid, between);
                        pair(&|i, j, c| {
                            let each = between.iter();
                            each.map(|([a, b], w)| w * here.at(i + a, j + b)[c]).sum()
                        })
                    }
                });
            }
        }
        let turn = levels[0].slip.turn().cloned();
        let exact = || upstream(grid, motion.step()).to_vec();
        let between = table.between().map_or_else(exact, <[Share]>::to_vec);
        let [along, _] = motion.step();
        let across = |terms: &[(f64, f64)]| {
            let influence = bodies.across?;
            Some(Across::new(*grid, influence, terms, &[0, 1]))
        };
        let (across_ahead, across_behind) = if let Motion::Steady { .. } = motion {
            let terms = [(1.0 / length, -along), (-1.0 / length, 0.0)];
            (None, across(&terms))
        } else {
            // rows move each other along x alone
            let there: Vec<(f64, f64)> = match table.between() {
                None => vec![(1.0, along)],
                Some(between) => (between.iter())
                    .map(|([i, _], share)| (*share, *i as f64 * grid.dx))
                    .collect(),
            };
            let back: Vec<(f64, f64)> = there.iter().map(|(w, x)| (*w, -x)).collect();
            (across(&there), across(&back))
        };
        let stiffness = {
            let [x, y] = motion.step();
            let next = if x.abs() >= y.abs() { [1, 0] } else { [0, 1] };
            let size = [grid.nx, grid.ny];
            let mean = |[xx, _, yy]: [f64; 3]| 0.5 * (xx + yy);
            // rows of one cell have no ties
            let beside = (0..2).all(|k| size[k] as isize > next[k]);
            let beside = if beside {
                mean(table.here(next[0], next[1]))
            } else {
                0.0
            };
            let cell = if next[0] == 1 { grid.dx } else { grid.dy };
            (mean(table.here(0, 0)) - beside) / cell
        };
        Self {
            motion,
            layer: bodies.layer,
            levels,
            coarsenings,
            earlier,
            flexibility: None,
            pressure_now,
            pressure_earlier,
            behind,
            pressure_behind,
            turn,
            across_ahead,
            across_behind,
            between,
            influences: (!matches!(motion, Motion::Steady { .. }))
                .then(|| table.influences().clone()),
            is_second_order: false,
            stiffness,
        }
    }

    /// The same operators with the influence of tractions on the displacement, where steady rolling does without it:
    /// a layer that softens is checked by it.
    #[must_use]
    pub fn with_flexibility(self, bodies: &Bodies<'_>) -> Self {
        let grid = self.grid();
        let table = Table::new(bodies, &grid, [grid.nx, grid.ny], [0.0; 2]);
        let transform = self.transform();
        let flexibility = Some(BlockKernels {
            xx: transform.kernel(|i, j| table.here(i, j)[0]),
            xy: transform.kernel(|i, j| table.here(i, j)[1]),
            yy: transform.kernel(|i, j| table.here(i, j)[2]),
        });
        Self {
            flexibility,
            ..self
        }
    }

    /// The same operators with slip of second order in the cells, for steps along x or y in which differences are over one
    /// cell: steady rolling by one cell, and [`PatchOperators::rolling_by`].
    ///
    /// The slip of a cell is continued to its middle from the faces ahead of it, and the first cell of each row carries a
    /// traction that is to that of the next one as their pressures are. Rigid slip is then taken half a cell ahead. Between
    /// unlike bodies, and under layers that yield, the traction there does not go with the pressure, and errors are of
    /// first order.
    #[must_use]
    pub fn of_second_order(self) -> Self {
        Self {
            is_second_order: true,
            ..self
        }
    }

    /// Whether slip is of second order in the cells.
    pub fn is_second_order(&self) -> bool {
        self.is_second_order
    }

    /// Where the rigid slip of a cell is taken, from its centre [m]: a sixth of the step ahead, as in CONTACT
    /// [Vollebregt2012], and halfway to the next cell where slip is of second order.
    pub fn ahead(&self) -> [f64; 2] {
        let (step, grid) = (self.along(), self.grid());
        if self.is_second_order {
            let [x, y] = [0, 1].map(|k| 0.5 * [grid.dx, grid.dy][k].copysign(step[k]));
            return match step {
                [0.0, 0.0] => [0.0; 2],
                [along, across] if along.abs() >= across.abs() => [x, 0.0],
                _ => [0.0, y],
            };
        }
        self.motion.step().map(|step| step * SPIN_ADVANCE)
    }

    /// Where the rigid slip counts one step behind a cell, from where it counts at the cell [m]: a step, but along the way a
    /// cell where slip is of second order, as it is at the faces.
    pub fn behind(&self) -> [f64; 2] {
        let ahead = self.ahead();
        let step = self.motion.step();
        [0, 1].map(|k| match ahead[k] {
            half if self.is_second_order && half != 0.0 => -2.0 * half,
            _ => -step[k],
        })
    }

    /// The step as far as it is rolling.
    fn along(&self) -> [f64; 2] {
        match self.motion {
            // a patch that moves across as well rolls along x
            Motion::Transient { step: [x, _] } if self.is_second_order => [x, 0.0],
            other => other.step(),
        }
    }

    /// Whether the solver finds slip at the faces of the cells: it is of second order, and the patch rolls.
    pub(super) fn has_faces(&self) -> bool {
        self.is_second_order && self.along() != [0.0; 2]
    }

    /// What makes slip at faces that of the cells under a pressure (n), if it is of second order.
    pub(super) fn faces(&self, pressure: &[f64]) -> Option<Faces> {
        let stiffness = self.stiffness * self.motion.length();
        let layer = self.layer_share();
        self.has_faces()
            .then(|| Faces::new(&self.grid(), self.along(), pressure, stiffness, layer))
    }

    /// How much of what a traction slips at its own leading face is that of the layer.
    fn layer_share(&self) -> LayerShare {
        let (grid, [x, y]) = (self.grid(), self.along());
        let cell = if x.abs() >= y.abs() { grid.dx } else { grid.dy };
        let (bodies, layer) = (self.stiffness, self.layer / cell);
        let both = bodies + layer;
        LayerShare {
            value: layer / both,
            by_stiffness: -bodies * layer / both.powi(2),
            by_layer: bodies / both.powi(2) / cell,
        }
    }

    /// The grid of the patch.
    pub fn grid(&self) -> Grid {
        self.levels[0].grid
    }

    /// What the pressure (n) [Pa] of unlike bodies adds to the slip (2n), relative in rolling, [m] in a shift;
    /// nothing between like ones whose surface is plane.
    pub fn slip_by_pressure(&self, pressure: &[f64]) -> Vec<f64> {
        let n = self.grid().points();
        let mut slip = vec![0.0; 2 * n];
        if self.is_coupled() {
            self.levels[0]
                .slip
                .apply_to(&slip.clone(), Some(pressure), &mut slip);
            for s in &mut slip {
                *s = -*s;
            }
        }
        if let Some([along, across]) = &self.pressure_now {
            let (first, second) = slip.split_at_mut(n);
            self.transform().apply_add(along, 1.0, pressure, first);
            self.transform().apply_add(across, 1.0, pressure, second);
        }
        slip
    }

    /// What a layer has of a component of tractions (n) one step ahead of them.
    pub(super) fn layer_ahead(&self, traction: &[f64]) -> Vec<f64> {
        mixed(&self.grid(), &self.between, traction, 0.0)
    }

    /// The same one step behind.
    pub(super) fn layer_behind(&self, traction: &[f64]) -> Vec<f64> {
        let behind: Vec<Share> = (self.between.iter())
            .map(|(place, share)| (place.map(|d| -d), *share))
            .collect();
        mixed(&self.grid(), &behind, traction, 0.0)
    }

    /// Whether a pressure moves the surfaces by more than `pressure_now`.
    pub(super) fn is_coupled(&self) -> bool {
        self.turn.is_some() || self.across_behind.is_some()
    }

    pub(super) fn transform(&self) -> &Transform {
        &self.levels[0].transform
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::{Complex, Grid, Kernel, LinearOperator, Transform};

use super::levels::Coarsening;
use crate::Error;
use crate::error::check_number;

/// Displacement [m/Pa] at an offset from the centre of a loaded cell: `(cell, offset)`, both [m].
type Influence<'a, const N: usize> = &'a (dyn Fn([f64; 2], [f64; 2]) -> [f64; N] + Sync);

/// What the tangential problem needs to know of the two bodies on a regular grid.
#[derive(Clone, Copy)]
pub struct Bodies<'a> {
    /// Displacement of the lower body relative to the upper one by a unit traction on the lower body:
    /// components xx, xy = yx, yy; xx and yy even, xy odd in both offsets.
    pub tangential: Influence<'a, 3>,
    /// Displacement (x, y) of the upper body relative to the lower one by a unit pressure; `None`
    /// where it cancels (like materials).
    pub by_pressure: Option<Influence<'a, 2>>,
    /// Thickness over shear modulus of a layer between the bodies [m/Pa].
    pub layer: f64,
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
    pub(super) fn step(self) -> [f64; 2] {
        match self {
            Self::Shift => [0.0; 2],
            Self::Transient { step } | Self::Steady { step } => step,
        }
    }

    pub(super) fn step_length(self) -> f64 {
        let [x, y] = self.step();
        x.hypot(y)
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
    pub(super) levels: Vec<Level>,
    pub(super) coarsenings: Vec<Coarsening>,
    /// Influence of the earlier tractions one step ahead, for transient rolling and shifts.
    pub(super) earlier: Option<BlockKernels>,
    /// Slip by the pressure now, and displacement by the earlier pressure one step ahead.
    pub(super) pressure_now: Option<[Kernel; 2]>,
    pub(super) pressure_earlier: Option<[Kernel; 2]>,
}

/// One grid with its slip operator and its preconditioner.
pub(super) struct Level {
    pub(super) grid: Grid,
    pub(super) transform: Transform,
    pub(super) slip: BlockKernels,
    /// Where the preconditioner works.
    torus: Transform,
    inverse: BlockKernels,
    pub(super) diagonal: f64,
    pub(super) step: [f64; 2],
}

/// A 2 by 2 block of kernels, the mixed ones equal.
pub(super) struct BlockKernels {
    xx: Kernel,
    xy: Option<Kernel>,
    yy: Kernel,
}

impl BlockKernels {
    /// Adds `scale` times the product with the two-component field `x` to `y`.
    pub(super) fn apply_add(&self, transform: &Transform, scale: f64, x: &[f64], y: &mut [f64]) {
        let n = x.len() / 2;
        let (y0, y1) = y.split_at_mut(n);
        let xy = self.xy.as_ref();
        transform.apply_block_add(
            &[&[Some(&self.xx), xy], &[xy, Some(&self.yy)]],
            scale,
            &[&x[..n], &x[n..]],
            &mut [y0, y1],
        );
    }
}

/// The slip operator `A` of a level.
pub(super) struct SlipOperator<'a>(pub(super) &'a Level);

impl LinearOperator for SlipOperator<'_> {
    fn dim(&self) -> usize {
        2 * self.0.grid.points()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        self.0.slip.apply_add(&self.0.transform, 1.0, x, y);
    }
}

/// The inverse symbol of the slip operator of a level.
pub(super) struct InverseSymbol<'a>(pub(super) &'a Level);

impl LinearOperator for InverseSymbol<'_> {
    fn dim(&self) -> usize {
        2 * self.0.grid.points()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        self.0.inverse.apply_add(&self.0.torus, 1.0, x, y);
    }
}

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
        let mut levels = vec![Level::new(bodies, grid, motion)];
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
            levels.push(Level::new(bodies, grid, motion));
        }
        let Level {
            transform, grid, ..
        } = &levels[0];
        let table = Table::new(bodies, grid, [grid.nx, grid.ny], motion.step());
        let earlier = match motion {
            Motion::Steady { .. } => None,
            _ => Some(BlockKernels {
                xx: transform.kernel(|i, j| table.ahead(i, j)[0]),
                xy: Some(transform.kernel(|i, j| table.ahead(i, j)[1])),
                yy: transform.kernel(|i, j| table.ahead(i, j)[2]),
            }),
        };
        let mut pressure_now = None;
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
            } else {
                pressure_now = Some(pair(&|i, j, c| at(i, j, 0.0)[c]));
                pressure_earlier = Some(pair(&|i, j, c| at(i, j, 1.0)[c]));
            }
        }
        Ok(Self {
            motion,
            layer: bodies.layer,
            levels,
            coarsenings,
            earlier,
            pressure_now,
            pressure_earlier,
        })
    }

    /// The grid of the patch.
    pub fn grid(&self) -> Grid {
        self.levels[0].grid
    }

    /// What the pressure (n) [Pa] of unlike bodies adds to the slip (2n), relative in rolling, [m] in a shift;
    /// nothing between like ones.
    pub fn slip_by_pressure(&self, pressure: &[f64]) -> Vec<f64> {
        let n = self.grid().points();
        let mut slip = vec![0.0; 2 * n];
        if let Some([along, across]) = &self.pressure_now {
            let (first, second) = slip.split_at_mut(n);
            self.transform().apply_add(along, 1.0, pressure, first);
            self.transform().apply_add(across, 1.0, pressure, second);
        }
        slip
    }

    pub(super) fn transform(&self) -> &Transform {
        &self.levels[0].transform
    }
}

impl Level {
    fn new(bodies: &Bodies<'_>, grid: Grid, motion: Motion) -> Self {
        let shape = [grid.nx, grid.ny];
        let transform = Transform::new(shape, shape);
        let step = motion.step();
        let padded = transform.padded();
        let table = Table::new(bodies, &grid, padded.map(|m| m / 2 + 1), step);
        let torus = Transform::wrapped_with_room(shape, room(&grid, motion, padded));
        let inverse = inverse_symbol(&torus, &grid, &table, bodies.layer, motion);
        let length = motion.step_length();
        let slip = if let Motion::Steady { .. } = motion {
            let behind = LayerStencil::new(&grid, step);
            let kernel = |c: usize| {
                transform.kernel(|i, j| {
                    let mut value = table.here(i, j)[c] - table.ahead(i, j)[c];
                    if c != 1 {
                        value += bodies.layer * behind.difference(i, j);
                    }
                    value / length
                })
            };
            BlockKernels {
                xx: kernel(0),
                xy: Some(kernel(1)),
                yy: kernel(2),
            }
        } else {
            let add = |c: usize| {
                transform.even_kernel(|i, j| {
                    let own = if i == 0 && j == 0 { bodies.layer } else { 0.0 };
                    table.here(i as isize, j as isize)[c] + own
                })
            };
            BlockKernels {
                xx: add(0),
                xy: Some(transform.kernel(|i, j| table.here(i, j)[1])),
                yy: add(2),
            }
        };
        let own = table.here(0, 0);
        let mean = 0.5 * (own[0] + own[2]);
        let diagonal = if let Motion::Steady { .. } = motion {
            let ahead = table.ahead(0, 0);
            let behind = LayerStencil::new(&grid, step).difference(0, 0);
            (mean - 0.5 * (ahead[0] + ahead[2]) + bodies.layer * behind) / length
        } else {
            mean + bodies.layer
        };
        Self {
            grid,
            transform,
            slip,
            torus,
            inverse,
            diagonal,
            step,
        }
    }
}

/// Influence coefficients at the offsets of a grid, and one step ahead of them.
struct Table<'a> {
    bodies: &'a Bodies<'a>,
    cell: [f64; 2],
    step: [f64; 2],
    /// The step in cells where it is a whole number of them.
    whole: Option<[isize; 2]>,
    width: usize,
    values: Vec<[f64; 3]>,
}

impl<'a> Table<'a> {
    /// For the offsets of up to `cells` (exclusive) to either side.
    fn new(bodies: &'a Bodies<'a>, grid: &Grid, cells: [usize; 2], step: [f64; 2]) -> Self {
        let cell = [grid.dx, grid.dy];
        let along = [step[0] / cell[0], step[1] / cell[1]];
        let is_whole = |v: f64| (v - v.round()).abs() < 1e-9;
        let reach = |v: f64| v.abs().round() as usize;
        let whole = (along.into_iter().all(is_whole) && along.into_iter().all(|v| v.abs() < 9.0))
            .then(|| along.map(|v| v.round() as isize));
        let margin = if whole.is_some() {
            along.map(reach)
        } else {
            [0; 2]
        };
        let width = cells[0] + margin[0];
        let height = cells[1] + margin[1];
        let values = (0..width * height)
            .map(|k| {
                let offset = [(k % width) as f64 * cell[0], (k / width) as f64 * cell[1]];
                (bodies.tangential)(cell, offset)
            })
            .collect();
        Self {
            bodies,
            cell,
            step,
            whole,
            width,
            values,
        }
    }

    /// At the offset of `(i, j)` cells.
    fn here(&self, i: isize, j: isize) -> [f64; 3] {
        let [xx, xy, yy] = self.values[j.unsigned_abs() * self.width + i.unsigned_abs()];
        if (i < 0) == (j < 0) {
            [xx, xy, yy]
        } else {
            [xx, -xy, yy]
        }
    }

    /// At the offset of `(i, j)` cells and one step.
    fn ahead(&self, i: isize, j: isize) -> [f64; 3] {
        if let Some([di, dj]) = self.whole {
            return self.here(i + di, j + dj);
        }
        let x = i as f64 * self.cell[0] + self.step[0];
        let y = j as f64 * self.cell[1] + self.step[1];
        (self.bodies.tangential)(self.cell, [x, y])
    }
}

/// Bilinear weights of the four points around the one a step away, in cells.
pub(super) fn upstream(grid: &Grid, step: [f64; 2]) -> [([isize; 2], f64); 4] {
    let along = [step[0] / grid.dx, step[1] / grid.dy];
    let base = along.map(|v| {
        let nearest = v.round();
        if (v - nearest).abs() < 1e-9 {
            (nearest, 0.0)
        } else {
            (v.floor(), v - v.floor())
        }
    });
    let corner = |a: usize, b: usize| {
        let pick = |k: usize, upper: usize| {
            let (floor, part) = base[k];
            let weight = if upper == 1 { part } else { 1.0 - part };
            (floor as isize + upper as isize, weight)
        };
        let ((i, wx), (j, wy)) = (pick(0, a), pick(1, b));
        ([i, j], wx * wy)
    };
    [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)]
}

/// The layer's own displacement here minus one step ahead, as a kernel.
struct LayerStencil([([isize; 2], f64); 4]);

impl LayerStencil {
    fn new(grid: &Grid, step: [f64; 2]) -> Self {
        Self(upstream(grid, step))
    }

    fn difference(&self, i: isize, j: isize) -> f64 {
        let here = if i == 0 && j == 0 { 1.0 } else { 0.0 };
        here - self.ahead(i, j)
    }

    fn ahead(&self, i: isize, j: isize) -> f64 {
        self.0
            .iter()
            .filter(|([di, dj], _)| *di == -i && *dj == -j)
            .map(|(_, w)| w)
            .sum()
    }
}

/// Room of the preconditioner's torus over the patch, where nothing travels: 1.25 to 2 serve alike, 1 does not.
const ROOM: f64 = 1.25;

/// Cells of the torus of the preconditioner: less than the `padded` grid of products, but along steady rolling,
/// where tractions act all the way behind themselves.
fn room(grid: &Grid, motion: Motion, padded: [usize; 2]) -> [usize; 2] {
    let is_steady = matches!(motion, Motion::Steady { .. });
    let (step, cells) = (motion.step(), [grid.nx, grid.ny]);
    [0, 1].map(|axis| {
        if is_steady && step[axis].abs() > 1e-9 * motion.step_length() {
            padded[axis]
        } else {
            padded[axis].min((ROOM * cells[axis] as f64).ceil() as usize)
        }
    })
}

/// Decay of the memory of the preconditioner over the patch: `exp(-8)` to `exp(-16)` serve alike.
const DECAY: f64 = 12.0;

/// Kernels of the inverse of the symbol of the slip operator.
///
/// In steady rolling the symbol has a line of zeros, as `C^ (1 - e^(i k d)) / |d|`, which is removed by
/// letting the memory along the rolling direction decay over the patch. The symbol is that of a torus
/// without a gap between the furthest offsets; what lies a fraction of a
/// cell ahead has its own spectrum, since no phase turns the short waves of the one into the other's.
fn inverse_symbol(
    torus: &Transform,
    grid: &Grid,
    table: &Table<'_>,
    layer: f64,
    motion: Motion,
) -> BlockKernels {
    let padded = torus.padded();
    let compliance = [
        torus.even_kernel(|i, j| table.here(i as isize, j as isize)[0]),
        torus.kernel(|i, j| table.here(i, j)[1]),
        torus.even_kernel(|i, j| table.here(i as isize, j as isize)[2]),
    ];
    let step = motion.step();
    let length = motion.step_length();
    let is_steady = matches!(motion, Motion::Steady { .. });
    let turns = [
        step[0] / grid.dx / padded[0] as f64,
        step[1] / grid.dy / padded[1] as f64,
    ];
    let ahead = (is_steady && table.whole.is_none()).then(|| {
        let stencil = LayerStencil::new(grid, step);
        [0, 1, 2].map(|c| {
            torus.kernel(|i, j| {
                let own = if c == 1 {
                    0.0
                } else {
                    layer * stencil.ahead(i, j)
                };
                table.ahead(i, j)[c] + own
            })
        })
    });
    let extent = (grid.nx as f64 * grid.dx * step[0].abs() / length)
        .hypot(grid.ny as f64 * grid.dy * step[1].abs() / length);
    let decay = (-DECAY * length / extent).exp();
    let largest = torus.spectrum(&compliance[0], 0, 0).re.abs()
        + torus.spectrum(&compliance[2], 0, 0).re.abs();
    let symbol = |kx: usize, ky: usize| -> [Complex<f64>; 3] {
        let at = |c: usize| torus.spectrum(&compliance[c], kx, ky).re;
        let (xx, xy, yy) = (at(0) + layer, at(1), at(2) + layer);
        // the symbol of a truncated kernel may touch zero: keep it positive definite
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let spread = half.hypot(xy);
        let lift = (1e-9 * largest - (mean - spread)).max(0.0);
        let (xx, yy) = (xx + lift, yy + lift);
        let angle = std::f64::consts::TAU * (kx as f64 * turns[0] + ky as f64 * turns[1]);
        let phase = Complex::new(angle.cos(), angle.sin());
        let entry = |c: usize, here: f64| match &ahead {
            Some(ahead) => (here - decay * torus.spectrum(&ahead[c], kx, ky)) / length,
            None if is_steady => here * (1.0 - decay * phase) / length,
            None => Complex::new(here, 0.0),
        };
        let (xx, xy, yy) = (entry(0, xx), entry(1, xy), entry(2, yy));
        let determinant = xx * yy - xy * xy;
        [yy / determinant, -xy / determinant, xx / determinant]
    };
    BlockKernels {
        xx: torus.kernel_from_spectrum(|kx, ky| symbol(kx, ky)[0]),
        xy: Some(torus.kernel_from_spectrum(|kx, ky| symbol(kx, ky)[1])),
        yy: torus.kernel_from_spectrum(|kx, ky| symbol(kx, ky)[2]),
    }
}

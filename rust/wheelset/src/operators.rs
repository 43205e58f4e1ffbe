// SPDX-License-Identifier: MIT OR Apache-2.0
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use mtb_contact::tangential::{Bodies, Motion, PatchOperators};
use mtb_elasticity::Material;
use mtb_elasticity::half_space::{Pair, influence};
use mtb_operator::{Component, Grid};

use crate::Error;
use crate::rows::Incline;

/// Operators are made for multiples of so many cells, so that few serve all patches ...
const CELLS: usize = 8;
/// ... and so many of them are kept, of so many cells together.
const KEPT: usize = 24;
const CELLS_KEPT: usize = 1 << 18;
/// Parts of a cell that are rounding of a multiple of it.
const ROUNDED: f64 = 1e-9;

/// Operators by motion and size of the patch, those used last at the end.
#[derive(Default)]
pub(crate) struct Operators {
    kept: Mutex<Vec<Kept>>,
    is_second_order: bool,
}

/// Of a motion, on rows of a rail.
type Kept = ((Motion, Option<(usize, i64, bool)>), Arc<PatchOperators>);

impl Operators {
    /// None yet; those to come have slip of first or second order.
    pub(crate) fn new(is_second_order: bool) -> Self {
        Self {
            is_second_order,
            ..Self::default()
        }
    }

    /// Operators for a patch of at least `nx` by `ny` cells; the ones used longest ago are dropped.
    pub(crate) fn at_least(
        &self,
        [nx, ny]: [usize; 2],
        spacing: [f64; 2],
        pair: &Pair,
        layer: f64,
        motion: Motion,
        incline: Option<&Incline>,
    ) -> Result<Arc<PatchOperators>, Error> {
        let key = (motion, incline.map(Incline::key));
        let [nx, ny] = [nx, ny].map(|n| n.next_multiple_of(CELLS));
        let grid = Grid::new(nx, ny, spacing[0], spacing[1])?;
        let known = {
            let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
            let place = (kept.iter()).position(|(of, made)| *of == key && made.grid() == grid);
            place.map(|k| {
                let last = kept.remove(k);
                kept.push(last.clone());
                last.1
            })
        };
        if let Some(made) = known {
            return Ok(made);
        }
        let tangential = |cell, offset| pair.tangential(cell, offset);
        let by_pressure = |cell, offset| pair.by_pressure(cell, offset);
        let inclination = incline.map(|incline| |y| incline.at(y));
        let bodies = Bodies {
            tangential: &tangential,
            by_pressure: pair.is_coupled().then_some(&by_pressure),
            layer,
            is_mirrored: true,
            inclination: inclination.as_ref().map(|at| at as _),
            across: None,
        };
        let made = match motion {
            // a patch that moves rolls by another step each time
            Motion::Transient { step } => {
                let still =
                    self.at_least([nx, ny], spacing, pair, layer, Motion::Shift, incline)?;
                still.rolling_by(&bodies, step)?
            }
            _ => PatchOperators::new(&bodies, grid, motion)?,
        };
        let made = if self.is_second_order {
            made.of_second_order()
        } else {
            made
        };
        let made = Arc::new(made);
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let mut cells: usize = kept.iter().map(|(_, made)| made.grid().points()).sum();
        while !kept.is_empty() && (kept.len() >= KEPT || cells + grid.points() > CELLS_KEPT) {
            cells -= kept.remove(0).1.grid().points();
        }
        kept.push((key, made.clone()));
        Ok(made)
    }
}

/// How the bodies close under the pressure of a cell, known once it was asked for: the normal problems of a search all
/// stand on the same cells.
pub(crate) struct Closing {
    cell: [f64; 2],
    /// By cells along x and y, the bits of the number; those of NaN where it is not known yet.
    known: Vec<AtomicU64>,
}

/// Cells along x and along y up to which it is kept.
const CLOSING_KEPT: usize = 256;

impl Closing {
    pub(crate) fn new(cell: [f64; 2]) -> Self {
        let unknown = || AtomicU64::new(f64::NAN.to_bits());
        Self {
            cell,
            known: (0..CLOSING_KEPT * CLOSING_KEPT)
                .map(|_| unknown())
                .collect(),
        }
    }

    /// Displacement of a point under a unit of the pressure of a cell [m/Pa].
    pub(crate) fn at(&self, joined: &Material, offset: [f64; 2], cell: [f64; 2]) -> f64 {
        let found = || influence(joined, Component::Normal, Component::Normal, offset, cell);
        let cells = [0, 1].map(|c| (offset[c] / self.cell[c]).abs());
        let [i, j] = cells.map(f64::round);
        let is_on_grid = (cells[0] - i).abs() < ROUNDED && (cells[1] - j).abs() < ROUNDED;
        let end = CLOSING_KEPT as f64;
        if cell != self.cell || !is_on_grid || i >= end || j >= end {
            return found();
        }
        let place = &self.known[j as usize * CLOSING_KEPT + i as usize];
        let known = f64::from_bits(place.load(Ordering::Relaxed));
        if !known.is_nan() {
            return known;
        }
        let made = found();
        place.store(made.to_bits(), Ordering::Relaxed);
        made
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_cell_closes_is_known_on_its_own_cells_alone() {
        let steel = Material::new(80e9, 0.3).unwrap();
        let cell = [1e-3, 0.5e-3];
        let closing = Closing::new(cell);
        let far = CLOSING_KEPT as f64 * cell[0];
        let offsets = [
            [0.0, 0.0],
            [3e-3, -2e-3],
            [-3e-3, 2e-3],
            [0.4e-3, 0.5e-3],
            [far, 0.0],
        ];
        for cell in [cell, [2e-3, 1e-3]] {
            for offset in offsets.iter().chain(&offsets) {
                let truth = influence(&steel, Component::Normal, Component::Normal, *offset, cell);
                let found = closing.at(&steel, *offset, cell);
                assert!((found / truth - 1.0).abs() < 1e-12, "{offset:?}");
            }
        }
    }

    #[test]
    fn few_are_kept() {
        let steel = Material::new(80e9, 0.3).unwrap();
        let pair = Pair {
            lower: Some(steel),
            upper: Some(steel),
        };
        let operators = Operators::default();
        let motion = Motion::Steady { step: [1e-3, 0.0] };
        let of = |nx, ny| {
            let made = operators.at_least([nx, ny], [1e-3; 2], &pair, 0.0, motion, None);
            made.unwrap()
        };
        let first = of(3, 5);
        assert_eq!((first.grid().nx, first.grid().ny), (8, 8));
        assert!(Arc::ptr_eq(&first, &of(8, 8)));
        for k in 2..KEPT + 5 {
            of(8 * k, 1);
            assert!(operators.kept.lock().unwrap().len() <= KEPT);
            // what is in use stays
            assert!(Arc::ptr_eq(&first, &of(8, 8)));
        }
        assert!(operators.kept.lock().unwrap().len() == KEPT);
    }
}

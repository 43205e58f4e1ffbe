// SPDX-License-Identifier: MIT OR Apache-2.0
use std::sync::{Arc, Mutex, PoisonError};

use mtb_contact::tangential::{Bodies, Motion, PatchOperators};
use mtb_elasticity::half_space::Pair;
use mtb_operator::Grid;

use crate::Error;

/// Operators are made for multiples of so many cells, so that few serve all patches ...
const CELLS: usize = 8;
/// ... and so many of them are kept, of so many cells together.
const KEPT: usize = 24;
const CELLS_KEPT: usize = 1 << 18;

/// Operators by motion and size of the patch, those used last at the end.
#[derive(Default)]
pub(crate) struct Operators(Mutex<Vec<Kept>>);

type Kept = (Motion, Arc<PatchOperators>);

impl Operators {
    /// Operators for a patch of at least `nx` by `ny` cells; the ones used longest ago are dropped.
    pub(crate) fn at_least(
        &self,
        [nx, ny]: [usize; 2],
        spacing: [f64; 2],
        pair: &Pair,
        layer: f64,
        motion: Motion,
    ) -> Result<Arc<PatchOperators>, Error> {
        let [nx, ny] = [nx, ny].map(|n| n.next_multiple_of(CELLS));
        let grid = Grid::new(nx, ny, spacing[0], spacing[1])?;
        let known = {
            let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let place = (kept.iter()).position(|(of, made)| *of == motion && made.grid() == grid);
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
        let bodies = Bodies {
            tangential: &tangential,
            by_pressure: pair.is_coupled().then_some(&by_pressure),
            layer,
            is_mirrored: true,
            inclination: None,
        };
        let made = match motion {
            // a patch that moves rolls by another step each time
            Motion::Transient { step } => {
                let still = self.at_least([nx, ny], spacing, pair, layer, Motion::Shift)?;
                still.rolling_by(&bodies, step)?
            }
            _ => PatchOperators::new(&bodies, grid, motion)?,
        };
        let made = Arc::new(made);
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut cells: usize = kept.iter().map(|(_, made)| made.grid().points()).sum();
        while !kept.is_empty() && (kept.len() >= KEPT || cells + grid.points() > CELLS_KEPT) {
            cells -= kept.remove(0).1.grid().points();
        }
        kept.push((motion, made.clone()));
        Ok(made)
    }
}

#[cfg(test)]
mod tests {
    use mtb_elasticity::Material;

    use super::*;

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
            let made = operators.at_least([nx, ny], [1e-3; 2], &pair, 0.0, motion);
            made.unwrap()
        };
        let first = of(3, 5);
        assert_eq!((first.grid().nx, first.grid().ny), (8, 8));
        assert!(Arc::ptr_eq(&first, &of(8, 8)));
        for k in 2..KEPT + 5 {
            of(8 * k, 1);
            assert!(operators.0.lock().unwrap().len() <= KEPT);
            // what is in use stays
            assert!(Arc::ptr_eq(&first, &of(8, 8)));
        }
        assert!(operators.0.lock().unwrap().len() == KEPT);
    }
}

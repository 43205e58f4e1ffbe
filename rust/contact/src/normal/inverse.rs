// SPDX-License-Identifier: MIT OR Apache-2.0
//! The rough inverse of a compliance on the contact set.

use std::cell::RefCell;

use mtb_operator::{Buffers, Grid, Monitor};

use super::Surface;
use super::extension::Extension;
use super::product::{Product, sizes};

/// Cells of the grid on which half-spaces are inverted, for each of the contact along a side. That grid is wrapped
/// around: with room between the contact and its images, these do not matter.
const ROOM: f64 = 1.3;

/// Roughly the inverse of a compliance on a set of cells: that on the whole grid, wrapped around, of the displacement
/// continued beyond the set.
pub(super) struct Inverse<'a> {
    product: Product<'a>,
    /// The grid, and the one that holds it with some room.
    inner: [usize; 2],
    outer: [usize; 2],
    work: RefCell<Work>,
}

struct Work {
    extension: Extension,
    set: Vec<bool>,
    displacement: Vec<f64>,
    pressure: Vec<f64>,
}

impl<'a> Inverse<'a> {
    /// On the grid `inner` [nx, ny]; a contact that `is_full`, of all its cells, has no border beyond which to go on.
    pub(super) fn new(
        surface: Surface<'a>,
        grid: &Grid,
        inner: [usize; 2],
        is_full: bool,
        buffers: &Buffers,
        monitor: Monitor<'_>,
    ) -> Self {
        let outer = if is_full {
            inner
        } else {
            outer(surface, inner)
        };
        let points = outer[0] * outer[1];
        let is_wrapped = !matches!(surface, Surface::Body(_));
        Self {
            product: Product::inverse(surface, grid, outer, buffers, monitor),
            inner,
            outer,
            work: RefCell::new(Work {
                extension: Extension::new(outer, is_wrapped),
                set: vec![false; points],
                displacement: vec![0.0; points],
                pressure: vec![0.0; points],
            }),
        }
    }

    /// Overwrites the pressure on the set by its rough inverse of a displacement that vanishes elsewhere.
    pub(super) fn apply(
        &self,
        set: &[bool],
        displacement: &[f64],
        pressure: &mut [f64],
        monitor: Monitor<'_>,
    ) {
        let mut work = self.work.borrow_mut();
        let work = &mut *work;
        let ([nx, _], [mx, _]) = (self.inner, self.outer);
        let rows = work.set.chunks_exact_mut(mx).zip(set.chunks_exact(nx));
        rows.for_each(|(out, row)| out[..nx].copy_from_slice(row));
        work.displacement.fill(0.0);
        let rows = work.displacement.chunks_exact_mut(mx);
        let rows = rows.zip(displacement.chunks_exact(nx));
        rows.for_each(|(out, row)| out[..nx].copy_from_slice(row));
        work.extension.follow(&work.set, &mut work.pressure);
        work.extension.extend(&mut work.displacement);
        self.product
            .apply(&work.displacement, &mut work.pressure, monitor);
        work.extension.gather(&mut work.pressure);
        let rows = pressure.chunks_exact_mut(nx);
        let rows = rows.zip(work.pressure.chunks_exact(mx));
        rows.for_each(|(out, row)| out.copy_from_slice(&row[..nx]));
    }

    /// Points of the transform: what an application costs.
    pub(super) fn size(&self) -> f64 {
        self.product.size()
    }
}

/// The grid on which a grid is inverted.
fn outer(surface: Surface<'_>, inner: [usize; 2]) -> [usize; 2] {
    match surface {
        Surface::FreeSpace(_) | Surface::Rolling(_) | Surface::Inclined(..) => {
            inner.map(|n| (ROOM * n as f64).ceil() as usize)
        }
        Surface::Periodic(_) | Surface::Body(_) => inner,
    }
}

/// Points of the transforms of a product and of a rough inverse, without making them.
pub(super) fn costs(surface: Surface<'_>, shape: [usize; 2]) -> (f64, f64) {
    let (product, _) = sizes(surface, shape);
    let (_, inverse) = sizes(surface, outer(surface, shape));
    (product, inverse)
}

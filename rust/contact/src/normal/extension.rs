// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fields on a contact set of any shape, continued over the grid around it.

use mtb_operator::wide;

/// A continuation of fields from a set of cells to all cells of their grid, and its transpose.
///
/// The inverse of a compliance on a set is that on the whole grid, applied to the displacement that the pressure on
/// the set makes everywhere. To continue it by zeros, as restricting the inverse on the whole grid does, tears it
/// at the border of the set: the shorter the cells, the larger the pressure that this costs. So
/// the displacement is continued smoothly, by means over ever larger neighbourhoods: with the mean `s` of the field
/// over the set on a grid (zeros counted outside), the share `w` of the set and the next coarser grid's
/// continuation, the continuation is `s + (1 - w) * coarser`.
pub(super) struct Extension {
    set: Vec<bool>,
    layers: Vec<Layer>,
}

/// A grid of the pyramid.
struct Layer {
    shape: [usize; 2],
    /// Whether the next coarser grid is wrapped around along x and along y.
    wraps: [bool; 2],
    /// Share of each cell that is outside of the set.
    open: Vec<f32>,
    /// Room for a field.
    field: Vec<f64>,
}

impl Extension {
    /// Of no set yet, on a grid of `shape` [nx, ny].
    pub(super) fn new(shape: [usize; 2], is_periodic: bool) -> Self {
        let mut layers = Vec::new();
        let (mut shape, mut is_finest) = (shape, true);
        loop {
            let [nx, ny] = shape;
            let wraps = shape.map(|n| is_periodic && n.is_multiple_of(2));
            // the fields on the finest grid are the caller's
            let room = if is_finest { 0 } else { nx * ny };
            layers.push(Layer {
                shape,
                wraps,
                open: vec![0.0; nx * ny],
                field: vec![0.0; room],
            });
            if nx.min(ny) < 2 {
                break;
            }
            shape = shape.map(|n| n.div_ceil(2));
            is_finest = false;
        }
        Self {
            set: Vec::new(),
            layers,
        }
    }

    /// Takes another set. `room` for a field is overwritten: fresh memory costs as much as a pass.
    pub(super) fn follow(&mut self, set: &[bool], room: &mut [f64]) {
        if self.set == set {
            return;
        }
        self.set.clear();
        self.set.extend_from_slice(set);
        for ((open, share), c) in self.layers[0].open.iter_mut().zip(&mut *room).zip(set) {
            *open = f32::from(u8::from(!c));
            *share = f64::from(u8::from(*c));
        }
        self.means(room);
        for layer in &mut self.layers[1..] {
            for (open, share) in layer.open.iter_mut().zip(&layer.field) {
                *open = (1.0 - share) as f32;
            }
        }
    }

    /// Means of a field on all coarser grids.
    fn means(&mut self, field: &[f64]) {
        for k in 1..self.layers.len() {
            let (finer, coarser) = self.layers.split_at_mut(k);
            let (finer, coarser) = (&finer[k - 1], &mut coarser[0]);
            let fine = if k == 1 { field } else { &finer.field };
            collect(finer, fine, None, 0.25, &mut coarser.field);
        }
    }

    /// Continues a field that is zero outside of the set over the grid.
    pub(super) fn extend(&mut self, field: &mut [f64]) {
        self.means(field);
        for k in (1..self.layers.len()).rev() {
            let (finer, coarser) = self.layers.split_at_mut(k);
            let (finer, coarser) = (&mut finer[k - 1], &coarser[0].field);
            let mut own = std::mem::take(&mut finer.field);
            let fine = if k == 1 { &mut *field } else { &mut own };
            spread(finer, coarser, Some(&finer.open), fine);
            finer.field = own;
        }
    }

    /// The transpose of [`Extension::extend`]; zero outside of the set.
    pub(super) fn gather(&mut self, field: &mut [f64]) {
        for k in 1..self.layers.len() {
            let (finer, coarser) = self.layers.split_at_mut(k);
            let (finer, coarser) = (&finer[k - 1], &mut coarser[0]);
            let fine = if k == 1 { &*field } else { &finer.field };
            collect(finer, fine, Some(&finer.open), 1.0, &mut coarser.field);
        }
        for k in (1..self.layers.len()).rev() {
            let (finer, coarser) = self.layers.split_at_mut(k);
            let (finer, coarser) = (&mut finer[k - 1], &coarser[0].field);
            let mut own = std::mem::take(&mut finer.field);
            let fine = if k == 1 { &mut *field } else { &mut own };
            spread(finer, coarser, None, fine);
            finer.field = own;
        }
        for (value, c) in field.iter_mut().zip(&self.set) {
            *value = if *c { *value } else { 0.0 };
        }
    }
}

/// The coarse neighbour, out of `n`, that gives a quarter to the fine cell `k`; `k / 2` gives the rest.
fn neighbour(k: usize, n: usize, wraps: bool) -> usize {
    let near = k / 2;
    if k.is_multiple_of(2) {
        near.checked_sub(1).unwrap_or(if wraps { n - 1 } else { 0 })
    } else if near + 1 < n {
        near + 1
    } else if wraps {
        0
    } else {
        near
    }
}

/// Adds `weight`, or a quarter, times the linear interpolant of a coarser field.
fn spread(layer: &Layer, coarse: &[f64], weight: Option<&[f32]>, fine: &mut [f64]) {
    let [nx, ny] = layer.shape;
    let [cx, cy] = layer.shape.map(|n| n.div_ceil(2));
    let ends = [0, nx - 1].map(|i| neighbour(i, cx, layer.wraps[0]));
    let quarters = vec![0.25; if weight.is_some() { 0 } else { nx }];
    // a coarse row between the neighbours of its ends
    let mut row = vec![0.0; cx + 2];
    for (j, fine) in fine.chunks_exact_mut(nx).enumerate() {
        let (near, other) = (j / 2, neighbour(j, cy, layer.wraps[1]));
        let (near, other) = (&coarse[near * cx..][..cx], &coarse[other * cx..][..cx]);
        let weight = weight.map_or(&*quarters, |weight| &weight[j * nx..][..nx]);
        wide(
            #[inline(always)]
            || {
                for ((row, a), b) in row[1..].iter_mut().zip(near).zip(other) {
                    *row = 0.75 * a + 0.25 * b;
                }
                (row[0], row[cx + 1]) = (row[1 + ends[0]], row[1 + ends[1]]);
                let (pairs, last) = fine.as_chunks_mut::<2>();
                let (weights, last_weight) = weight.as_chunks::<2>();
                let around = row.iter().zip(&row[1..]).zip(&row[2..]);
                for (([a, b], [v, w]), ((before, own), after)) in
                    pairs.iter_mut().zip(weights).zip(around)
                {
                    *a += f64::from(*v) * (0.75 * own + 0.25 * before);
                    *b += f64::from(*w) * (0.75 * own + 0.25 * after);
                }
                if let ([a], [w]) = (last, last_weight) {
                    *a += f64::from(*w) * (0.75 * row[cx] + 0.25 * row[cx - 1]);
                }
            },
        );
    }
    debug_assert_eq!(ny * nx, fine.len());
}

/// The transpose of [`spread`], with a weight of `scale` where none is given: overwrites the coarser field.
fn collect(layer: &Layer, fine: &[f64], weight: Option<&[f32]>, scale: f64, coarse: &mut [f64]) {
    let [nx, ny] = layer.shape;
    let cx = nx.div_ceil(2);
    let row = |j: usize| &fine[j * nx..][..nx];
    let nothing = vec![0.0; nx];
    // a row between the cells that give to its ends; an odd one ends in nothing twice
    let mut line = vec![0.0; 2 * cx + 2];
    let last = if layer.wraps[0] {
        [nx - 1, 0]
    } else {
        [0, nx - 1]
    };
    for (k, coarse) in coarse.chunks_exact_mut(cx).enumerate() {
        let (first, second) = (2 * k, 2 * k + 1);
        // the rows that give a quarter, see `neighbour`
        let before = match k {
            0 if layer.wraps[1] => ny - 1,
            0 => 0,
            _ => first - 1,
        };
        let after = match second + 1 {
            j if j < ny => Some(j),
            _ if second == ny => None,
            _ if layer.wraps[1] => Some(0),
            _ => Some(ny - 1),
        };
        let rows = [
            Some(first),
            (second < ny).then_some(second),
            Some(before),
            after,
        ];
        let fields = rows.map(|j| j.map_or(&*nothing, row));
        let inner = &mut line[1..=nx];
        if let Some(weight) = weight {
            let weights = rows.map(|j| &weight[j.unwrap_or(0) * nx..][..nx]);
            wide(
                #[inline(always)]
                || add_up(fields, weights, inner),
            );
        } else {
            wide(
                #[inline(always)]
                || {
                    let [a, b, c, d] = fields;
                    for ((((line, a), b), c), d) in inner.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                        *line = scale * (0.75 * (a + b) + 0.25 * (c + d));
                    }
                },
            );
        }
        if nx.is_multiple_of(2) {
            line[nx + 1] = line[1 + last[1]];
        }
        line[0] = line[1 + last[0]];
        wide(
            #[inline(always)]
            || {
                let (pairs, _) = line.as_chunks::<2>();
                for ((c, [a, b]), [d, e]) in coarse.iter_mut().zip(pairs).zip(&pairs[1..]) {
                    *c = 0.75 * (b + d) + 0.25 * (a + e);
                }
            },
        );
    }
}

#[expect(
    clippy::inline_always,
    reason = "what is not inlined keeps its narrow instructions"
)]
#[inline(always)]
fn add_up(rows: [&[f64]; 4], weights: [&[f32]; 4], sum: &mut [f64]) {
    let [a, b, c, d] = rows;
    let [u, v, w, z] = weights;
    let near = a.iter().zip(u).zip(b.iter().zip(v));
    let far = c.iter().zip(w).zip(d.iter().zip(z));
    for ((sum, ((a, u), (b, v))), ((c, w), (d, z))) in sum.iter_mut().zip(near).zip(far) {
        let near = a * f64::from(*u) + b * f64::from(*v);
        let far = c * f64::from(*w) + d * f64::from(*z);
        *sum = 0.75 * near + 0.25 * far;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{Extension, Layer, collect, neighbour, spread};

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

        #[test]
        fn passes_between_grids_give_three_quarters_to_the_near_cell(
            (nx, ny) in (2..12_usize, 2..12_usize),
            is_periodic in any::<bool>(),
            is_weighted in any::<bool>(),
            cells in prop::collection::vec((-1.0..1.0_f64, 0.0..1.0_f32), 12 * 12),
        ) {
            let shape = [nx, ny];
            let wraps = shape.map(|n| is_periodic && n.is_multiple_of(2));
            let weight: Vec<f32> = cells[..nx * ny].iter().map(|c| c.1).collect();
            let layer = Layer { shape, wraps, open: weight.clone(), field: Vec::new() };
            let given = is_weighted.then_some(&*weight);
            let of = |k: usize, other: f64| if is_weighted { f64::from(weight[k]) } else { other };
            let fine: Vec<f64> = cells[..nx * ny].iter().map(|c| c.0).collect();
            let [cx, cy] = shape.map(|n| n.div_ceil(2));
            let coarse: Vec<f64> = cells[..cx * cy].iter().map(|c| 1.0 - c.0).collect();
            let (mut spread_out, mut collected) = (fine.clone(), vec![7.0; cx * cy]);
            spread(&layer, &coarse, given, &mut spread_out);
            collect(&layer, &fine, given, 0.25, &mut collected);
            // cell by cell
            let (mut slowly, mut sums) = (fine.clone(), vec![0.0; cx * cy]);
            for k in 0..nx * ny {
                let (i, j) = (k % nx, k / nx);
                for (ci, a) in [(i / 2, 0.75), (neighbour(i, cx, wraps[0]), 0.25)] {
                    for (cj, b) in [(j / 2, 0.75), (neighbour(j, cy, wraps[1]), 0.25)] {
                        slowly[k] += of(k, 0.25) * a * b * coarse[cj * cx + ci];
                        sums[cj * cx + ci] += of(k, 0.25) * a * b * fine[k];
                    }
                }
            }
            let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-14);
            prop_assert!(near(&spread_out, &slowly));
            prop_assert!(near(&collected, &sums));
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

        #[test]
        fn gathering_is_the_transpose_of_extending(
            (nx, ny) in (1..14_usize, 1..14_usize),
            is_periodic in any::<bool>(),
            cells in prop::collection::vec((any::<bool>(), -1.0..1.0_f64, -1.0..1.0_f64), 14 * 14),
        ) {
            let cells = &cells[..nx * ny];
            let set: Vec<bool> = cells.iter().map(|c| c.0).collect();
            let inside: Vec<f64> = cells.iter().map(|c| if c.0 { c.1 } else { 0.0 }).collect();
            let all: Vec<f64> = cells.iter().map(|c| c.2).collect();
            let mut extension = Extension::new([nx, ny], is_periodic);
            extension.follow(&set, &mut vec![0.0; set.len()]);
            let (mut extended, mut gathered) = (inside.clone(), all.clone());
            extension.extend(&mut extended);
            extension.gather(&mut gathered);
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            prop_assert!((dot(&extended, &all) - dot(&inside, &gathered)).abs() < 1e-12 * (nx * ny) as f64);
            for i in 0..cells.len() {
                if set[i] {
                    // what is known stays, and means invent nothing larger
                    prop_assert_eq!(extended[i], inside[i]);
                } else {
                    prop_assert_eq!(gathered[i], 0.0);
                    prop_assert!(extended[i].abs() <= 1.0 + 1e-12);
                }
            }
        }
    }

    #[test]
    fn a_constant_on_most_of_the_grid_is_continued_as_nearly_one() {
        let (nx, ny) = (40, 33);
        let set: Vec<bool> = (0..nx * ny).map(|k| (k % nx) % 5 != 2).collect();
        for is_periodic in [false, true] {
            let mut extension = Extension::new([nx, ny], is_periodic);
            extension.follow(&set, &mut vec![0.0; set.len()]);
            let mut field: Vec<f64> = set.iter().map(|c| f64::from(u8::from(*c))).collect();
            extension.extend(&mut field);
            assert!(field.iter().all(|v| (v - 1.0).abs() < 0.15));
        }
    }
}

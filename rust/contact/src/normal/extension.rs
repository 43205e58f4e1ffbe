// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fields on a contact set of any shape, continued over the grid around it.

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

    /// Takes another set.
    pub(super) fn follow(&mut self, set: &[bool]) {
        if self.set == set {
            return;
        }
        self.set.clear();
        self.set.extend_from_slice(set);
        let share: Vec<f64> = set.iter().map(|c| f64::from(u8::from(*c))).collect();
        for (open, share) in self.layers[0].open.iter_mut().zip(&share) {
            *open = 1.0 - *share as f32;
        }
        self.means(&share);
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
            collect(finer, fine, None, &mut coarser.field);
            coarser.field.iter_mut().for_each(|v| *v *= 0.25);
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
            spread(finer, coarser, |i| f64::from(finer.open[i]), fine);
            finer.field = own;
        }
    }

    /// The transpose of [`Extension::extend`]; zero outside of the set.
    pub(super) fn gather(&mut self, field: &mut [f64]) {
        for k in 1..self.layers.len() {
            let (finer, coarser) = self.layers.split_at_mut(k);
            let (finer, coarser) = (&finer[k - 1], &mut coarser[0]);
            let fine = if k == 1 { &*field } else { &finer.field };
            collect(finer, fine, Some(&finer.open), &mut coarser.field);
        }
        for k in (1..self.layers.len()).rev() {
            let (finer, coarser) = self.layers.split_at_mut(k);
            let (finer, coarser) = (&mut finer[k - 1], &coarser[0].field);
            let mut own = std::mem::take(&mut finer.field);
            let fine = if k == 1 { &mut *field } else { &mut own };
            spread(finer, coarser, |_| 0.25, fine);
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

/// Adds `weight` times the linear interpolant of a coarser field.
fn spread(layer: &Layer, coarse: &[f64], weight: impl Fn(usize) -> f64, fine: &mut [f64]) {
    let [nx, ny] = layer.shape;
    let [cx, cy] = layer.shape.map(|n| n.div_ceil(2));
    let mut row = vec![0.0; cx];
    for (j, fine) in fine.chunks_exact_mut(nx).enumerate() {
        let (near, other) = (j / 2, neighbour(j, cy, layer.wraps[1]));
        let (near, other) = (&coarse[near * cx..][..cx], &coarse[other * cx..][..cx]);
        for ((row, a), b) in row.iter_mut().zip(near).zip(other) {
            *row = 0.75 * a + 0.25 * b;
        }
        let mut add = |i: usize, other: usize| {
            fine[i] += weight(j * nx + i) * (0.75 * row[i / 2] + 0.25 * row[other]);
        };
        add(0, neighbour(0, cx, layer.wraps[0]));
        for i in 1..nx - 1 {
            add(i, i / 2 + (i & 1) - (1 - (i & 1)));
        }
        if nx > 1 {
            add(nx - 1, neighbour(nx - 1, cx, layer.wraps[0]));
        }
    }
    debug_assert_eq!(ny * nx, fine.len());
}

/// The transpose of [`spread`]: overwrites the coarser field.
fn collect(layer: &Layer, fine: &[f64], weight: Option<&[f32]>, coarse: &mut [f64]) {
    let [nx, _] = layer.shape;
    let [cx, cy] = layer.shape.map(|n| n.div_ceil(2));
    coarse.fill(0.0);
    let mut line = vec![0.0; nx];
    let mut row = vec![0.0; cx];
    for (j, fine) in fine.chunks_exact(nx).enumerate() {
        match weight {
            Some(weight) => {
                let weighted = fine.iter().zip(&weight[j * nx..]);
                for (line, (v, w)) in line.iter_mut().zip(weighted) {
                    *line = v * f64::from(*w);
                }
            }
            None => line.copy_from_slice(fine),
        }
        for (row, pair) in row.iter_mut().zip(line.chunks(2)) {
            *row = 0.75 * pair.iter().sum::<f64>();
        }
        for (row, pair) in row.iter_mut().zip(line[1..].chunks(2)) {
            *row += if pair.len() == 2 { 0.25 * pair[1] } else { 0.0 };
        }
        for (row, pair) in row[1..].iter_mut().zip(line.chunks_exact(2)) {
            *row += 0.25 * pair[1];
        }
        row[neighbour(0, cx, layer.wraps[0])] += 0.25 * line[0];
        if nx.is_multiple_of(2) {
            row[neighbour(nx - 1, cx, layer.wraps[0])] += 0.25 * line[nx - 1];
        }
        let (near, other) = (j / 2, neighbour(j, cy, layer.wraps[1]));
        for (c, v) in coarse[near * cx..][..cx].iter_mut().zip(&row) {
            *c += 0.75 * v;
        }
        for (c, v) in coarse[other * cx..][..cx].iter_mut().zip(&row) {
            *c += 0.25 * v;
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::Extension;

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
            extension.follow(&set);
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
            extension.follow(&set);
            let mut field: Vec<f64> = set.iter().map(|c| f64::from(u8::from(*c))).collect();
            extension.extend(&mut field);
            assert!(field.iter().all(|v| (v - 1.0).abs() < 0.15));
        }
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Numbers of the sparse Cholesky factor, supernode by supernode, with a look at the monitor between.

use std::ops::Range;

use faer::{Accum, MatMut, MatRef, Par};
use mtb_operator::dense::{Unfactored, WORK_UNWATCHED, Watch, cholesky_columns, lower_product};
use mtb_operator::unmonitored;
use rayon::prelude::*;

use super::assembly::Lower;
use super::factor::{Failure, Symbolic};

/// Columns of an update that are formed before they are subtracted: bounds its memory. Of many strips, the last to be
/// made leaves other threads without work for a short while only.
const COLUMNS: usize = 1024;

/// Columns of them that a thread forms at once.
const STRIP: usize = 128;

/// Columns of the factor that are multiplied at once: a longer product leaves the caches.
const DEPTH: usize = 256;

/// Operations from which on threads share an update.
const SHARED: f64 = 2e6;

/// Operations of a part of the elimination tree that one thread takes, at most.
const TASK: f64 = 0.125 * WORK_UNWATCHED;

/// Share of the memory of the factor that the updates of the parts of one round may take.
const UPDATES: f64 = 0.03;

/// A part of the elimination tree that depends on no other: supernodes, the last of them its root.
#[derive(Clone)]
struct Subtree {
    supernodes: Range<usize>,
    flops: f64,
}

impl Subtree {
    fn root(&self) -> usize {
        self.supernodes.end - 1
    }

    /// Entries of its update, and of the products that it takes.
    fn scratch(&self, symbolic: &Symbolic) -> (usize, usize) {
        let height = |s: usize| symbolic.structure.supernode(s).pattern().len();
        let tallest = self.supernodes.clone().map(height).max().unwrap_or(0);
        (height(self.root()).pow(2), tallest * STRIP)
    }
}

/// Who does what: parts of the elimination tree, one thread for each, in rounds; then what is left, all threads
/// at every supernode.
///
/// It does not depend on the number of threads, nor do the numbers.
struct Plan {
    rounds: Vec<Vec<Subtree>>,
    top: Vec<usize>,
}

impl Plan {
    fn new(symbolic: &Symbolic) -> Self {
        let n_supernodes = symbolic.structure.n_supernodes();
        let mut flops: Vec<f64> = (0..n_supernodes).map(|s| symbolic.flops_of(s)).collect();
        let mut first: Vec<usize> = (0..n_supernodes).collect();
        let mut count = vec![1; n_supernodes];
        for s in 0..n_supernodes {
            if let Some(parent) = symbolic.parent(s) {
                flops[parent] += flops[s];
                first[parent] = first[parent].min(first[s]);
                count[parent] += count[s];
            }
        }
        // one range of supernodes each: what is not in postorder is left to the end
        let is_part = |s: usize| flops[s] <= TASK && count[s] == s + 1 - first[s];
        let most = UPDATES * symbolic.entries() as f64;
        let (mut rounds, mut top) = (vec![Vec::new()], Vec::new());
        let (mut work, mut entries) = (0.0, 0.0);
        let mut s = 0;
        while s < n_supernodes {
            let mut root = s;
            while let Some(parent) = symbolic.parent(root).filter(|&p| is_part(p)) {
                if first[parent] != s {
                    break;
                }
                root = parent;
            }
            if !is_part(root) || first[root] != s {
                top.push(s);
                s += 1;
                continue;
            }
            let update = symbolic.structure.supernode(root).pattern().len();
            let update = (update * update) as f64;
            if work + flops[root] > WORK_UNWATCHED || entries + update > most {
                rounds.push(Vec::new());
                (work, entries) = (0.0, 0.0);
            }
            work += flops[root];
            entries += update;
            rounds.last_mut().expect("one at least").push(Subtree {
                supernodes: s..root + 1,
                flops: flops[root],
            });
            s = root + 1;
        }
        rounds.retain(|round| !round.is_empty());
        Plan { rounds, top }
    }

    /// Entries of all updates that are there at once: of the parts of a round, and of a supernode that is left.
    fn scratch(&self, symbolic: &Symbolic) -> (usize, usize) {
        let of_part = |part: &Subtree| {
            let (update, product) = part.scratch(symbolic);
            update + product
        };
        let rounds = self.rounds.iter();
        let at_once = rounds.map(|round| round.iter().map(of_part).sum());
        let height = |&s: &usize| symbolic.structure.supernode(s).pattern().len();
        let tallest = self.top.iter().map(height).max();
        (at_once.max().unwrap_or(0), tallest.unwrap_or(0) * COLUMNS)
    }
}

/// Memory [bytes] that [`factorise`] takes: the values and the updates that are there at once.
pub(super) fn memory(symbolic: &Symbolic) -> f64 {
    let (of_parts, of_top) = Plan::new(symbolic).scratch(symbolic);
    8.0 * (symbolic.entries() + of_parts.max(of_top)) as f64
}

/// Values of the factor in faer's layout: supernodes one after the other, each by columns, its square first.
///
/// Right-looking: a supernode is factorised in its place, and its product subtracted from all columns that it
/// reaches. A part of the elimination tree that one thread takes keeps for itself what reaches beyond it, as the
/// update of a front in the multifrontal method, until its round is over.
///
/// `values` are as many zeros as the factor has entries, and become the factor.
pub(super) fn factorise(
    symbolic: &Symbolic,
    matrix: &Lower,
    values: &mut [f64],
    watch: &mut Watch<'_>,
) -> Result<(), Failure> {
    let plan = Plan::new(symbolic);
    let panels = Panels { symbolic, matrix };
    let (of_parts, of_top) = plan.scratch(symbolic);
    let mut scratch = zeros(of_parts)?;
    for round in &plan.rounds {
        let mut rest = &mut *values;
        let mut start = 0;
        let mut free = &mut *scratch;
        let mut tasks = Vec::with_capacity(round.len());
        for part in round {
            let (update, product) = part.scratch(symbolic);
            let (update, behind) = free.split_at_mut(update);
            let (product, behind) = behind.split_at_mut(product);
            free = behind;
            let range = panels.values(part.supernodes.clone());
            let (_, from) = rest.split_at_mut(range.start - start);
            let (own, behind) = from.split_at_mut(range.len());
            (rest, start) = (behind, range.end);
            tasks.push((part, own, update, product));
        }
        let updates: Vec<Result<&[f64], Failure>> = tasks
            .into_par_iter()
            .with_max_len(1)
            .map(|(part, own, update, product)| {
                panels.part(part, own, update, product)?;
                Ok(&*update)
            })
            .collect();
        for (part, update) in round.iter().zip(updates) {
            let rows = panels.pattern(part.root());
            let start = panels.values(part.supernodes.clone()).end;
            panels.subtract_all(rows, update?, &mut values[start..], start);
            watch.spend(part.flops)?;
        }
    }
    // one after the other: their memory is not there at once
    drop(scratch);
    let mut product = zeros(of_top)?;
    for &s in &plan.top {
        let range = panels.values(s..s + 1);
        let (own, later) = values[range.start..].split_at_mut(range.len());
        panels.eliminate(s, own, Par::rayon(rayon::current_num_threads()), watch)?;
        panels.update(s, own, later, range.end, &mut product, watch)?;
    }
    Ok(())
}

/// The supernodes of a factor that is being made.
#[derive(Clone, Copy)]
struct Panels<'a> {
    symbolic: &'a Symbolic,
    matrix: &'a Lower,
}

/// Columns of an update: rows and columns of a pattern from `first` on, as many columns as `width`, in `values`
/// by columns of `height`.
#[derive(Clone, Copy)]
struct Columns<'a> {
    rows: &'a [usize],
    first: usize,
    width: usize,
    values: &'a [f64],
    height: usize,
}

impl<'a> Panels<'a> {
    fn begin(&self, s: usize) -> usize {
        self.symbolic.structure.supernode_begin()[s]
    }

    fn end(&self, s: usize) -> usize {
        self.symbolic.structure.supernode_end()[s]
    }

    /// Rows below the square of a supernode.
    fn pattern(&self, s: usize) -> &'a [usize] {
        self.symbolic.structure.supernode(s).pattern()
    }

    fn n_rows(&self, s: usize) -> usize {
        self.end(s) - self.begin(s) + self.pattern(s).len()
    }

    /// Where the values of some supernodes stand.
    fn values(&self, supernodes: Range<usize>) -> Range<usize> {
        let first = self.symbolic.structure.col_ptr_for_val();
        first[supernodes.start]..first[supernodes.end]
    }

    /// Where the values of a column begin.
    fn column(&self, column: usize) -> usize {
        let s = self.symbolic.supernode_of[column];
        self.values(s..s + 1).start + (column - self.begin(s)) * self.n_rows(s)
    }

    /// Adds the columns of the matrix, and factorises them.
    fn eliminate(
        &self,
        s: usize,
        own: &mut [f64],
        par: Par,
        watch: &mut Watch<'_>,
    ) -> Result<(), Failure> {
        let (begin, end, n_rows) = (self.begin(s), self.end(s), self.n_rows(s));
        let pattern = self.pattern(s);
        let mut at = Vec::new();
        for (column, own) in (begin..end).zip(own.chunks_exact_mut(n_rows)) {
            let range = self.matrix.start[column]..self.matrix.start[column + 1];
            let rows = &self.matrix.row[range.clone()];
            places(rows, begin, end, pattern, &mut at);
            for (&at, value) in at.iter().zip(&self.matrix.value[range]) {
                own[at] += value;
            }
        }
        let size = end - begin;
        let work = (n_rows * size * size) as f64;
        let mut own = MatMut::from_column_major_slice_mut(own, n_rows, size);
        let par = if work < SHARED { Par::Seq } else { par };
        let failed = |first: usize| {
            move |unfactored| match unfactored {
                Unfactored::Pivot(column) => Failure::Pivot(begin + first + column),
                Unfactored::Interrupted => Failure::Interrupted,
            }
        };
        let off_plane = self.symbolic.off_plane();
        if end <= off_plane {
            return cholesky_columns(own, par, watch).map_err(failed(0));
        }
        // on the plane of a mirror: what lies off it first, then even and odd unknowns apart
        let inner = off_plane.saturating_sub(begin);
        let left = own.as_mut().subcols_mut(0, inner);
        cholesky_columns(left, par, watch).map_err(failed(0))?;
        let (left, right) = own.split_at_col_mut(inner);
        let mut rest = right.subrows_mut(inner, n_rows - inner);
        let lower = left.as_ref().subrows(inner, n_rows - inner);
        lower_product(rest.as_mut(), Accum::Add, lower, -1.0, par);
        self.part_even_and_odd(s, inner, rest.as_mut());
        cholesky_columns(rest, par, watch).map_err(failed(inner))
    }

    /// Leaves out what couples even and odd unknowns in the columns of a supernode on the plane of the mirror, from
    /// its row and column `inner` on.
    fn part_even_and_odd(&self, s: usize, inner: usize, columns: MatMut<'_, f64>) {
        let Some(halves) = &self.symbolic.halves else {
            return;
        };
        let own = self.begin(s) + inner..self.end(s);
        let rows = own.clone().chain(self.pattern(s).iter().copied());
        let is_odd: Vec<bool> = rows.map(|row| halves.is_odd(row)).collect();
        for (j, column) in columns.col_iter_mut().enumerate() {
            for (value, &odd) in column.iter_mut().zip(&is_odd) {
                if odd != is_odd[j] {
                    *value = 0.0;
                }
            }
        }
    }

    /// Factorises a part of the elimination tree; `update` is then what it subtracts from the rows of its root's
    /// pattern.
    fn part(
        &self,
        part: &Subtree,
        own: &mut [f64],
        update: &mut [f64],
        product: &mut [f64],
    ) -> Result<(), Failure> {
        let outside = self.pattern(part.root());
        update.fill(0.0);
        let end = self.end(part.root());
        let start = self.values(part.supernodes.clone()).start;
        let mut watch = Watch::new(&unmonitored);
        let mut at = Vec::new();
        for s in part.supernodes.clone() {
            let range = self.values(s..s + 1);
            let (own, later) = own[range.start - start..].split_at_mut(range.len());
            self.eliminate(s, own, Par::Seq, &mut watch)?;
            let rows = self.pattern(s);
            let size = self.end(s) - self.begin(s);
            let factor = MatRef::from_column_major_slice(own, self.n_rows(s), size);
            let factor = factor.subrows(size, rows.len());
            let inside = rows.partition_point(|&row| row < end);
            let mut first = 0;
            while first < rows.len() {
                let is_inside = first < inside;
                let end = if is_inside { inside } else { rows.len() };
                let (width, height) = (STRIP.min(end - first), rows.len() - first);
                let values = &mut product[..height * width];
                // what leaves is kept with its sign, to be subtracted once more
                let sign = if is_inside { 1.0 } else { -1.0 };
                let factor = factor.subrows(first, height);
                multiply(values, factor, width, Accum::Replace, sign);
                let strip = Columns {
                    rows,
                    first,
                    width,
                    values,
                    height,
                };
                if is_inside {
                    self.subtract(strip, later, range.end);
                } else {
                    places(&rows[first..], 0, 0, outside, &mut at);
                    strip.subtract(width, &at, update, outside.len(), 0);
                }
                first += width;
            }
        }
        Ok(())
    }

    /// Subtracts the product of a supernode from all columns that it reaches, `later` from `start` on.
    fn update(
        &self,
        s: usize,
        own: &[f64],
        mut later: &mut [f64],
        mut start: usize,
        product: &mut [f64],
        watch: &mut Watch<'_>,
    ) -> Result<(), Failure> {
        let rows = self.pattern(s);
        let size = self.end(s) - self.begin(s);
        let factor = MatRef::from_column_major_slice(own, self.n_rows(s), size);
        let factor = factor.subrows(size, rows.len());
        for group in (0..rows.len()).step_by(COLUMNS) {
            let count = COLUMNS.min(rows.len() - group);
            let mut strips = Vec::new();
            let mut free = &mut *product;
            for first in (group..group + count).step_by(STRIP) {
                let width = STRIP.min(group + count - first);
                let (values, rest) = free.split_at_mut((rows.len() - first) * width);
                let last = rows[first + width - 1];
                let end = self.column(last) + self.n_rows(self.symbolic.supernode_of[last]);
                let (target, behind) = later.split_at_mut(end - start);
                strips.push((first, width, values, target, start));
                (free, later, start) = (rest, behind, end);
            }
            let area = ((rows.len() - group) * count) as f64;
            let depth = ((0.5 * WORK_UNWATCHED / area) as usize).clamp(16, DEPTH);
            // as many for each: a few that are left would take far longer than their share
            let depth = size.div_ceil(size.div_ceil(depth));
            for k in (0..size).step_by(depth) {
                let depth = depth.min(size - k);
                let accum = if k == 0 { Accum::Replace } else { Accum::Add };
                let is_last = k + depth == size;
                let work = |(first, width, values, target, start): &mut (
                    usize,
                    usize,
                    &mut [f64],
                    &mut [f64],
                    usize,
                )| {
                    let height = rows.len() - *first;
                    let factor = factor.submatrix(*first, k, height, depth);
                    multiply(values, factor, *width, accum, 1.0);
                    if is_last {
                        let strip = Columns {
                            rows,
                            first: *first,
                            width: *width,
                            values,
                            height,
                        };
                        self.subtract(strip, target, *start);
                    }
                };
                let operations = 2.0 * area * depth as f64;
                if operations < SHARED {
                    strips.iter_mut().for_each(work);
                } else {
                    strips.par_iter_mut().with_max_len(1).for_each(work);
                }
                watch.spend(operations)?;
            }
        }
        Ok(())
    }

    /// Subtracts a whole square update from the columns of its `rows`, which stand in `later` from `start` on.
    fn subtract_all(
        &self,
        rows: &[usize],
        update: &[f64],
        mut later: &mut [f64],
        mut start: usize,
    ) {
        let height = rows.len();
        let mut strips = Vec::new();
        for first in (0..height).step_by(STRIP) {
            let width = STRIP.min(height - first);
            let last = rows[first + width - 1];
            let end = self.column(last) + self.n_rows(self.symbolic.supernode_of[last]);
            let (target, behind) = later.split_at_mut(end - start);
            let strip = Columns {
                rows,
                first,
                width,
                values: &update[first * height + first..],
                height,
            };
            strips.push((strip, target, start));
            (later, start) = (behind, end);
        }
        strips
            .into_par_iter()
            .with_max_len(1)
            .for_each(|(strip, target, start)| self.subtract(strip, target, start));
    }

    /// Subtracts columns of an update from supernodes that stand in `target` from `start` on.
    fn subtract(&self, mut strip: Columns<'_>, target: &mut [f64], start: usize) {
        let mut at = Vec::new();
        while strip.width > 0 {
            let rows = &strip.rows[strip.first..];
            let s = self.symbolic.supernode_of[rows[0]];
            let (begin, end) = (self.begin(s), self.end(s));
            let here = rows[..strip.width].partition_point(|&row| row < end);
            places(rows, begin, end, self.pattern(s), &mut at);
            let base = self.column(rows[0]) - start;
            let n_rows = self.n_rows(s);
            strip.subtract(here, &at, &mut target[base..], n_rows, at[0]);
            strip = strip.after(here);
        }
    }
}

impl Columns<'_> {
    /// Subtracts the first `width` of them from columns of `n_rows`, the first of which is that of place `base`:
    /// row and column `i` stand at place `at[i]`.
    fn subtract(&self, width: usize, at: &[usize], own: &mut [f64], n_rows: usize, base: usize) {
        for (j, values) in self.values.chunks(self.height).take(width).enumerate() {
            let own = &mut own[(at[j] - base) * n_rows..][..n_rows];
            for (&at, value) in at[j..].iter().zip(&values[j..]) {
                own[at] -= value;
            }
        }
    }

    /// Those after the first `count`.
    fn after(self, count: usize) -> Self {
        let skipped = (count * (self.height + 1)).min(self.values.len());
        Self {
            first: self.first + count,
            width: self.width - count,
            values: &self.values[skipped..],
            ..self
        }
    }
}

/// The first `width` columns of `sign rows rows^T`, on and below the diagonal.
fn multiply(product: &mut [f64], rows: MatRef<'_, f64>, width: usize, accum: Accum, sign: f64) {
    let product = MatMut::from_column_major_slice_mut(product, rows.nrows(), width);
    lower_product(product, accum, rows, sign, Par::Seq);
}

/// Places of ascending `rows` among the columns `begin..end` of a supernode and the rows of its `pattern`.
fn places(rows: &[usize], begin: usize, end: usize, pattern: &[usize], at: &mut Vec<usize>) {
    at.clear();
    let mut place = 0;
    at.extend(rows.iter().map(|&row| {
        if row < end {
            return row - begin;
        }
        while pattern[place] < row {
            place += 1;
        }
        end - begin + place
    }));
}

/// Numbers that are made one after the other, in memory that is asked for first.
pub(super) fn reserved(length: usize) -> Result<Vec<f64>, Failure> {
    let mut values = Vec::new();
    match values.try_reserve_exact(length) {
        Ok(()) => Ok(values),
        Err(_) => Err(Failure::Memory),
    }
}

fn zeros(length: usize) -> Result<Vec<f64>, Failure> {
    let mut values = reserved(length)?;
    values.resize(length, 0.0);
    Ok(values)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::ops::ControlFlow;

    use faer::Spec;
    use faer::dyn_stack::{MemBuffer, MemStack};
    use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
    use faer::sparse::linalg::cholesky::supernodal::{
        factorize_supernodal_numeric_llt, factorize_supernodal_numeric_llt_scratch,
    };
    use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
    use mtb_operator::{Progress, unmonitored};
    use proptest::prelude::*;

    use super::*;
    use crate::tetra::ordering::{Graph, nested_dissection, postordered};

    /// Numbers in [-1, 1] without structure, the same on every run.
    fn numbers(mut seed: u64) -> impl FnMut() -> f64 {
        move || {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            2.0 * (seed as f64 / u64::MAX as f64) - 1.0
        }
    }

    /// Sum of positive definite matrices of elements that have these nodes, three unknowns each, in the order of
    /// elimination of a body.
    fn assembled(n_nodes: usize, elements: &[Vec<usize>], seed: u64) -> Lower {
        let graph = Graph::of_groups(n_nodes, elements.iter().map(Vec::as_slice));
        let order = postordered(&graph, &nested_dissection(&graph, &vec![true; n_nodes]));
        let mut place = vec![0; n_nodes];
        for (at, &node) in order.iter().enumerate() {
            place[node] = at;
        }
        let mut random = numbers(seed);
        let mut columns = vec![std::collections::BTreeMap::new(); 3 * n_nodes];
        for node in 0..3 * n_nodes {
            columns[node].insert(node, 0.1);
        }
        for element in elements {
            let places = element.iter().map(|&node| place[node]);
            let unknowns: Vec<usize> = places
                .flat_map(|place| (0..3).map(move |c| 3 * place + c))
                .collect();
            let size = unknowns.len();
            let root: Vec<f64> = (0..size * size).map(|_| random()).collect();
            for i in 0..size {
                for j in 0..size {
                    if unknowns[i] >= unknowns[j] {
                        let entry = (0..size).map(|k| root[i * size + k] * root[j * size + k]);
                        *columns[unknowns[j]].entry(unknowns[i]).or_insert(0.0) +=
                            entry.sum::<f64>();
                    }
                }
            }
        }
        let mut matrix = Lower {
            start: vec![0],
            row: Vec::new(),
            value: Vec::new(),
        };
        for column in columns {
            matrix.row.extend(column.keys());
            matrix.value.extend(column.values());
            matrix.start.push(matrix.row.len());
        }
        matrix
    }

    /// A block of bricks.
    fn bricks(nx: usize, ny: usize, nz: usize) -> Lower {
        let at = |i, j, k| i + (nx + 1) * (j + (ny + 1) * k);
        let mut elements = Vec::new();
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    let corner = |c: usize| at(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
                    elements.push((0..8).map(corner).collect());
                }
            }
        }
        assembled((nx + 1) * (ny + 1) * (nz + 1), &elements, 7)
    }

    fn ours(matrix: &Lower, watch: &mut Watch<'_>) -> Result<Vec<f64>, Failure> {
        let Ok(symbolic) = Symbolic::new(matrix, None, &unmonitored) else {
            panic!("too little memory")
        };
        let mut values = vec![0.0; symbolic.entries()];
        factorise(&symbolic, matrix, &mut values, watch)?;
        Ok(values)
    }

    /// The factor by faer's own loop.
    fn theirs(matrix: &Lower) -> Result<Vec<f64>, LltError> {
        let Ok(symbolic) = Symbolic::new(matrix, None, &unmonitored) else {
            panic!("too little memory")
        };
        let n = symbolic.structure.nrows();
        let mut values = vec![0.0; symbolic.structure.len_val()];
        let par = Par::rayon(rayon::current_num_threads());
        let spec = Spec::default();
        let request =
            factorize_supernodal_numeric_llt_scratch::<usize, f64>(&symbolic.structure, par, spec);
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &matrix.start, None, &matrix.row);
        factorize_supernodal_numeric_llt(
            &mut values,
            SparseColMatRef::new(pattern, matrix.value.as_slice()),
            LltRegularization::default(),
            &symbolic.structure,
            par,
            MemStack::new(&mut MemBuffer::new(request)),
            spec,
        )?;
        Ok(values)
    }

    /// Entries of a factor that count, each with its column.
    fn lower(matrix: &Lower, values: &[f64]) -> Vec<(usize, f64)> {
        let Ok(Symbolic { structure, .. }) = Symbolic::new(matrix, None, &unmonitored) else {
            panic!("too little memory")
        };
        let mut entries = Vec::new();
        for s in 0..structure.n_supernodes() {
            let (first, size) = (
                structure.supernode_begin()[s],
                structure.supernode_end()[s] - structure.supernode_begin()[s],
            );
            let range = structure.col_ptr_for_val()[s]..structure.col_ptr_for_val()[s + 1];
            let rows = range.len() / size;
            for (j, column) in values[range].chunks_exact(rows).enumerate() {
                entries.extend(column[j..].iter().map(|&value| (first + j, value)));
            }
        }
        entries
    }

    /// Distance of our factor from faer's, over the largest entry.
    fn difference(matrix: &Lower) -> f64 {
        let Ok(found) = ours(matrix, &mut Watch::new(&unmonitored)) else {
            panic!("our loop finds no factor")
        };
        let expected = theirs(matrix).expect("a factor");
        let expected = lower(matrix, &expected);
        let most = expected
            .iter()
            .fold(0.0, |most: f64, e| most.max(e.1.abs()));
        let found = lower(matrix, &found);
        assert_eq!(found.len(), expected.len());
        let pairs = found.iter().zip(&expected);
        pairs.fold(0.0, |worst: f64, (f, e)| {
            worst.max((f.1 - e.1).abs() / most)
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        #[test]
        fn random_matrices_have_the_factor_that_faer_finds(
            elements in prop::collection::vec(prop::collection::vec(0_usize..60, 1..5), 1..120),
            seed in 1_u64..,
        ) {
            let elements: Vec<Vec<usize>> = elements
                .into_iter()
                .map(|mut element| {
                    element.sort_unstable();
                    element.dedup();
                    element
                })
                .collect();
            let mut matrix = assembled(60, &elements, seed);
            prop_assert!(difference(&matrix) < 1e-11);
            // one pivot spoilt: the same one is named
            let column = seed as usize % 180;
            matrix.value[matrix.start[column]] = -1.0;
            let Err(LltError::NonPositivePivot { index }) = theirs(&matrix) else {
                panic!("faer finds a factor")
            };
            let found = ours(&matrix, &mut Watch::new(&unmonitored));
            prop_assert!(matches!(found, Err(Failure::Pivot(unknown)) if unknown == index));
        }
    }

    #[test]
    fn a_mesh_has_the_factor_that_faer_finds_with_a_look_at_the_monitor_in_bounded_work() {
        let matrix = bricks(20, 20, 8);
        let Ok(symbolic) = Symbolic::new(&matrix, None, &unmonitored) else {
            panic!("too little memory")
        };
        let ends = symbolic.structure.supernode_end();
        let widths = ends.iter().zip(symbolic.structure.supernode_begin());
        let widest = widths.map(|(end, begin)| end - begin).max().unwrap_or(0);
        assert!(widest > 256, "{widest} columns: one panel holds them");
        assert!(difference(&matrix) < 1e-11);

        let looks = Cell::new(0_u32);
        let count = |_: Progress| {
            looks.set(looks.get() + 1);
            ControlFlow::Continue(())
        };
        assert!(ours(&matrix, &mut Watch::new(&count)).is_ok());
        let watched = f64::from(looks.get()) * 2.0 * WORK_UNWATCHED;
        let work = symbolic.flops();
        assert!(work > 2.0 * WORK_UNWATCHED, "{work:e} operations");
        assert!(
            watched >= work - 2.0 * WORK_UNWATCHED && looks.get() > 0,
            "{} looks in {work:e} operations",
            looks.get()
        );
        let all = looks.get();
        for last in 1..=all {
            let stop = |progress: Progress| {
                if progress.iteration as u32 == last {
                    return ControlFlow::Break(());
                }
                ControlFlow::Continue(())
            };
            let found = ours(&matrix, &mut Watch::new(&stop));
            assert!(matches!(found, Err(Failure::Interrupted)), "look {last}");
        }
    }
}

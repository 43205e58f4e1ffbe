// SPDX-License-Identifier: MIT OR Apache-2.0
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::sparse::SymbolicSparseColMat;
use faer::sparse::linalg::SymbolicSupernodalParams;
use faer::sparse::linalg::cholesky::simplicial::{
    prefactorize_symbolic_cholesky, prefactorize_symbolic_cholesky_scratch,
};
use faer::sparse::linalg::cholesky::supernodal::{
    SupernodalLltRef, SymbolicSupernodalCholesky, factorize_supernodal_symbolic_cholesky,
    factorize_supernodal_symbolic_cholesky_scratch,
};
use faer::{Accum, Col, Conj, Mat, MatMut, MatRef, Par};
use mtb_operator::dense::{Unfactored, Watch};
use mtb_operator::{Interrupted, Monitor, on_workers, reset_workers};
use rayon::prelude::*;

use super::assembly::Lower;
use super::factorised::poll;
use super::mirror::{Folded, Halves};
use super::numeric::factorise;

/// Why a factorisation stopped.
pub(super) enum Failure {
    /// Too little memory.
    Memory,
    /// This unknown's pivot was not positive.
    Pivot(usize),
    /// The monitor asked to stop.
    Interrupted,
}

impl From<Interrupted> for Failure {
    fn from(Interrupted: Interrupted) -> Self {
        Failure::Interrupted
    }
}

impl From<Unfactored> for Failure {
    fn from(unfactored: Unfactored) -> Self {
        match unfactored {
            Unfactored::Pivot(unknown) => Failure::Pivot(unknown),
            Unfactored::Interrupted => Failure::Interrupted,
        }
    }
}

/// Structure of the Cholesky factor of a matrix that is already in its order of elimination.
pub(super) struct Symbolic {
    pub(super) structure: SymbolicSupernodalCholesky<usize>,
    /// Supernode of each unknown.
    pub(super) supernode_of: Vec<usize>,
    /// Parent supernode, `usize::MAX` at roots.
    parent: Vec<usize>,
    /// Where the matrix is that of one half of a body, how the whole is made of it.
    pub(super) halves: Option<Halves>,
}

impl Symbolic {
    /// Of a matrix, that of a half with its `halves`. The monitor is asked between the stages.
    pub(super) fn new(
        matrix: &Lower,
        halves: Option<Halves>,
        monitor: Monitor<'_>,
    ) -> Result<Self, Failure> {
        let look = || poll(monitor, 2).map_err(|_| Failure::Interrupted);
        let n = matrix.start.len() - 1;
        let nnz = matrix.row.len();
        let upper = transposed_pattern(matrix);
        look()?;
        let request = prefactorize_symbolic_cholesky_scratch::<usize>(n, nnz)
            .or(factorize_supernodal_symbolic_cholesky_scratch::<usize>(n));
        let mut memory = MemBuffer::try_new(request).map_err(|_| Failure::Memory)?;
        let stack = MemStack::new(&mut memory);
        let mut tree = vec![0; n];
        let mut counts = vec![0; n];
        let tree = prefactorize_symbolic_cholesky(&mut tree, &mut counts, upper.as_ref(), stack);
        look()?;
        factorize_supernodal_symbolic_cholesky(
            upper.as_ref(),
            tree,
            &counts,
            stack,
            SymbolicSupernodalParams::default(),
        )
        .map(|structure| Symbolic::of(structure, halves))
        .map_err(|_| Failure::Memory)
    }

    fn of(structure: SymbolicSupernodalCholesky<usize>, halves: Option<Halves>) -> Self {
        let mut supernode_of = vec![0; structure.nrows()];
        let range = structure.supernode_begin().iter();
        for (k, (&begin, &end)) in range.zip(structure.supernode_end()).enumerate() {
            supernode_of[begin..end].fill(k);
        }
        let parent = (0..structure.n_supernodes())
            .map(|k| {
                let first = structure.supernode(k).pattern().first();
                first.map_or(usize::MAX, |&row| supernode_of[row])
            })
            .collect();
        Symbolic {
            structure,
            supernode_of,
            parent,
            halves,
        }
    }

    /// Unknowns off the plane of the mirror; all where there is none.
    pub(super) fn off_plane(&self) -> usize {
        let halves = self.halves.as_ref();
        halves.map_or(self.structure.nrows(), Halves::plane)
    }

    /// Entries of the factor, the zeros inside supernodes included.
    pub(super) fn entries(&self) -> usize {
        self.structure.len_val()
    }

    /// Multiplications and additions of the numeric factorisation.
    pub(super) fn flops(&self) -> f64 {
        let supernodes = 0..self.structure.n_supernodes();
        supernodes.map(|s| self.flops_of(s)).sum()
    }

    /// Those of one supernode, its products for all that it reaches among them.
    pub(super) fn flops_of(&self, supernode: usize) -> f64 {
        let s = &self.structure;
        let below = s.supernode(supernode).pattern().len();
        let columns = s.supernode_end()[supernode] - s.supernode_begin()[supernode];
        let heights = (0..columns).map(|column| (columns - column + below) as f64);
        heights.map(|height| height * height).sum()
    }

    /// Parent of a supernode in the elimination tree.
    pub(super) fn parent(&self, supernode: usize) -> Option<usize> {
        let parent = self.parent[supernode];
        (parent != usize::MAX).then_some(parent)
    }

    /// Rows below the square of the tallest supernode.
    pub(super) fn longest(&self) -> usize {
        let supernodes = 0..self.structure.n_supernodes();
        let heights = supernodes.map(|s| self.structure.supernode(s).pattern().len());
        heights.max().unwrap_or(0)
    }

    /// Rows of right-hand sides in `unknowns` that differ from zero after forward substitution.
    pub(super) fn rows_reached(&self, unknowns: &[usize]) -> usize {
        let s = &self.structure;
        let mut is_reached = vec![false; s.n_supernodes()];
        let mut rows = 0;
        for &unknown in unknowns {
            let halves = self.halves.as_ref();
            let number = halves.map_or(unknown, |halves| halves.number(unknown));
            let mut k = self.supernode_of[number];
            while k != usize::MAX && !is_reached[k] {
                is_reached[k] = true;
                rows += s.supernode_end()[k] - s.supernode_begin()[k];
                k = self.parent[k];
            }
        }
        rows
    }

    /// The factor itself, in `values`: as many zeros as it has entries.
    pub(super) fn numeric(
        self,
        matrix: &Lower,
        mut values: Vec<f64>,
        monitor: Monitor<'_>,
    ) -> Result<Factor, Failure> {
        on_workers(monitor, |monitor| {
            factorise(&self, matrix, &mut values, &mut Watch::new(monitor))
        })?;
        reset_workers();
        Ok(Factor {
            symbolic: self,
            values,
        })
    }
}

fn transposed_pattern(matrix: &Lower) -> SymbolicSparseColMat<usize> {
    let n = matrix.start.len() - 1;
    let mut start = vec![0; n + 1];
    for &row in &matrix.row {
        start[row + 1] += 1;
    }
    for i in 0..n {
        start[i + 1] += start[i];
    }
    let mut cursor = start.clone();
    let mut column_of = vec![0; matrix.row.len()];
    for column in 0..n {
        for &row in &matrix.row[matrix.start[column]..matrix.start[column + 1]] {
            column_of[cursor[row]] = column;
            cursor[row] += 1;
        }
    }
    SymbolicSparseColMat::new_checked(n, n, start, None, column_of)
}

/// A sparse right-hand side: unknown and value.
pub(super) type SparseColumn = Vec<(usize, f64)>;

/// Sparse Cholesky factor, K = L L^T, in the order of elimination.
pub(super) struct Factor {
    pub(super) symbolic: Symbolic,
    values: Vec<f64>,
}

/// Forward-substituted right-hand sides, `Y = L^-1 B`, in the rows that can differ from zero.
///
/// Of a half, the rows on the plane stand apart, the even and the odd ones.
pub(super) struct Reached {
    /// Supernodes, ascending, the first row of each in `rows`, and how many of them are its own.
    supernodes: Vec<(usize, usize, usize)>,
    rows: Mat<f64>,
    on_plane: [Mat<f64>; 2],
    /// For each column the right-hand side that it belongs to, and its shares in the even and the odd load.
    shares: Vec<(usize, [f64; 2])>,
    /// Right-hand sides.
    count: usize,
    /// Operations spent.
    pub(super) flops: f64,
}

/// Products of right-hand sides after forward substitution.
pub(super) struct Products {
    pub(super) each_other: Mat<f64>,
    /// Those with the mirror images of the second ones, where a half is factorised.
    pub(super) with_images: Option<Mat<f64>>,
    /// Operations spent.
    pub(super) flops: f64,
}

impl Factor {
    /// Smallest over largest squared pivot, and the unknown of the smallest.
    pub(super) fn pivot_ratio(&self) -> (f64, usize) {
        let l = self.supernodal();
        let (mut least, mut most, mut at) = (f64::INFINITY, 0.0_f64, 0);
        for k in 0..l.symbolic().n_supernodes() {
            let s = l.supernode(k);
            for column in 0..s.val().ncols() {
                let pivot = s.val()[(column, column)];
                most = most.max(pivot);
                if pivot < least {
                    (least, at) = (pivot, s.start() + column);
                }
            }
        }
        ((least / most).powi(2), at)
    }

    fn supernodal(&self) -> SupernodalLltRef<'_, usize, f64> {
        SupernodalLltRef::new(&self.symbolic.structure, &self.values)
    }

    /// Solves `K x = b` in place, for one column or several ones, one after the other.
    pub(super) fn solve(&self, x: &mut [f64]) -> Result<(), Failure> {
        let Some(halves) = &self.symbolic.halves else {
            return self.solve_own(x);
        };
        let n = halves.len();
        for column in x.chunks_exact_mut(n) {
            let loads = column.iter().copied().enumerate();
            let folded = halves.fold_both(&loads.filter(|(_, v)| *v != 0.0).collect());
            column.fill(0.0);
            for Folded {
                column: load,
                shares,
            } in folded
            {
                let reached = self.substituted(&[load], vec![(0, shares)], 1);
                halves.unfold(&self.backward(halves, &reached, shares), shares, column);
            }
        }
        Ok(())
    }

    /// The same where the whole is factorised.
    fn solve_own(&self, x: &mut [f64]) -> Result<(), Failure> {
        let n = self.symbolic.structure.nrows();
        let count = x.len() / n;
        let request = self
            .symbolic
            .structure
            .solve_in_place_scratch::<f64>(count, Par::Seq);
        let mut memory = MemBuffer::try_new(request).map_err(|_| Failure::Memory)?;
        self.supernodal().solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(x, n, count),
            Par::Seq,
            MemStack::new(&mut memory),
        );
        Ok(())
    }

    /// Forward substitution `L^-1 x` in place of columns, one after the other, that are zero above row `from`, of the
    /// matrix that is factorised.
    pub(super) fn forward_in_place(&self, x: &mut [f64], from: usize) {
        let n = self.symbolic.structure.nrows();
        for two in x.chunks_mut(2 * n) {
            if two.len() == n {
                self.forward_few([two], from);
            } else {
                let (first, second) = two.split_at_mut(n);
                self.forward_few([first, second], from);
            }
        }
    }

    /// Backward substitution `L^-T x` in place of columns, one after the other, of the matrix that is factorised.
    pub(super) fn backward_in_place(&self, x: &mut [f64]) {
        let n = self.symbolic.structure.nrows();
        for two in x.chunks_mut(2 * n) {
            if two.len() == n {
                self.backward_few([two]);
            } else {
                let (first, second) = two.split_at_mut(n);
                self.backward_few([first, second]);
            }
        }
    }

    /// The forward substitution of so few columns that calls of dense products, one for each supernode, would take
    /// longer than what they do.
    fn forward_few<const K: usize>(&self, mut x: [&mut [f64]; K], from: usize) {
        let l = self.supernodal();
        let mut below: [Vec<f64>; K] = std::array::from_fn(|_| vec![0.0; self.symbolic.longest()]);
        for s in self.symbolic.supernode_of[from]..l.symbolic().n_supernodes() {
            let s = l.supernode(s);
            let (values, pattern) = (s.val(), s.pattern());
            let (start, size) = (s.start(), values.ncols());
            let columns = |j: usize| column(values, j);
            for x in &mut x {
                let own = &mut x[start..start + size];
                for j in 0..size {
                    let l = columns(j);
                    own[j] /= l[j];
                    let value = own[j];
                    subtract(&mut own[j + 1..], value, &l[j + 1..size]);
                }
            }
            for below in &mut below {
                below[..pattern.len()].fill(0.0);
            }
            let mut j = 0;
            while j + 4 <= size {
                let l: [&[f64]; 4] = std::array::from_fn(|k| &columns(j + k)[size..]);
                for (below, x) in below.iter_mut().zip(&x) {
                    let own = &x[start + j..start + j + 4];
                    let each = below.iter_mut().zip(l[0]).zip(l[1]).zip(l[2]).zip(l[3]);
                    for ((((sum, a), b), c), d) in each {
                        *sum += (a * own[0] + b * own[1]) + (c * own[2] + d * own[3]);
                    }
                }
                j += 4;
            }
            for j in j..size {
                let l = &columns(j)[size..];
                for (below, x) in below.iter_mut().zip(&x) {
                    subtract(below, -x[start + j], l);
                }
            }
            for (below, x) in below.iter().zip(&mut x) {
                for (&row, value) in pattern.iter().zip(below) {
                    x[row] -= value;
                }
            }
        }
    }

    /// The backward substitution of as few columns.
    fn backward_few<const K: usize>(&self, mut x: [&mut [f64]; K]) {
        let l = self.supernodal();
        let mut beyond: [Vec<f64>; K] = std::array::from_fn(|_| vec![0.0; self.symbolic.longest()]);
        for s in (0..l.symbolic().n_supernodes()).rev() {
            let s = l.supernode(s);
            let (values, pattern) = (s.val(), s.pattern());
            let (start, size) = (s.start(), values.ncols());
            for (beyond, x) in beyond.iter_mut().zip(&x) {
                for (value, &row) in beyond.iter_mut().zip(pattern) {
                    *value = x[row];
                }
            }
            // what the rows below the square leave, four columns at a time
            let mut j = 0;
            while j + 4 <= size {
                let l: [&[f64]; 4] = std::array::from_fn(|k| &column(values, j + k)[size..]);
                for (beyond, x) in beyond.iter().zip(&mut x) {
                    let sums = products(l, &beyond[..pattern.len()]);
                    let own = &mut x[start + j..start + j + 4];
                    own.iter_mut().zip(sums).for_each(|(x, sum)| *x -= sum);
                }
                j += 4;
            }
            for j in j..size {
                let l = &column(values, j)[size..];
                for (beyond, x) in beyond.iter().zip(&mut x) {
                    x[start + j] -= product(l, beyond);
                }
            }
            for j in (0..size).rev() {
                let own = &column(values, j)[..size];
                for x in &mut x {
                    let x = &mut x[start..start + size];
                    x[j] = (x[j] - product(&own[j + 1..], &x[j + 1..])) / own[j];
                }
            }
        }
    }

    /// Forward substitution of a few sparse columns through the supernodes they reach.
    pub(super) fn forward(&self, columns: &[SparseColumn]) -> Reached {
        let Some(halves) = &self.symbolic.halves else {
            let shares = (0..columns.len()).map(|k| (k, [1.0; 2])).collect();
            return self.substituted(columns, shares, columns.len());
        };
        let (mut loads, mut shares) = (Vec::new(), Vec::new());
        for (k, column) in columns.iter().enumerate() {
            for folded in halves.fold(column) {
                loads.push(folded.column);
                shares.push((k, folded.shares));
            }
        }
        self.substituted(&loads, shares, columns.len())
    }

    /// Backward substitution of the first right-hand side, even or odd by its `shares`.
    fn backward(&self, halves: &Halves, reached: &Reached, shares: [f64; 2]) -> Vec<f64> {
        let l = self.supernodal();
        let mut x = vec![0.0; halves.n()];
        for &(s, first, own) in &reached.supernodes {
            let begin = l.symbolic().supernode_begin()[s];
            x[begin..begin + own]
                .copy_from_slice(&reached.rows.col_as_slice(0)[first..first + own]);
        }
        let parity = usize::from(shares[0] == 0.0);
        let on_plane = reached.on_plane[parity].col_as_slice(0);
        for (&number, &value) in halves.on_plane(parity).iter().zip(on_plane) {
            x[number] = value;
        }
        for s in (0..l.symbolic().n_supernodes()).rev() {
            let s = l.supernode(s);
            let size = s.val().ncols();
            let (top, below) = s.val().split_at_row(size);
            let beyond = Col::from_fn(below.nrows(), |i| x[s.pattern()[i]]);
            let own = &mut x[s.start()..s.start() + size];
            let mut own = MatMut::from_column_major_slice_mut(own, size, 1);
            matmul(
                own.as_mut(),
                Accum::Add,
                below.transpose(),
                beyond.as_mat(),
                -1.0,
                Par::Seq,
            );
            solve_upper_triangular_in_place(top.transpose(), own, Par::Seq);
        }
        x
    }

    /// Forward substitution of columns of the matrix that is factorised, with their `shares` in as many right-hand
    /// sides as `count`.
    fn substituted(
        &self,
        columns: &[SparseColumn],
        shares: Vec<(usize, [f64; 2])>,
        count: usize,
    ) -> Reached {
        let l = self.supernodal();
        let n_supernodes = l.symbolic().n_supernodes();
        let begin = l.symbolic().supernode_begin();
        let end = l.symbolic().supernode_end();
        let off_plane = self.symbolic.off_plane();
        let mut local = vec![usize::MAX; n_supernodes];
        for &(row, _) in columns.iter().flatten() {
            let mut s = self.symbolic.supernode_of[row];
            while s != usize::MAX && local[s] == usize::MAX {
                local[s] = 0;
                s = self.symbolic.parent[s];
            }
        }
        let mut supernodes = Vec::new();
        let mut n_rows = 0;
        for s in 0..n_supernodes {
            if local[s] == 0 {
                local[s] = n_rows;
                supernodes.push((s, n_rows, end[s].min(off_plane).saturating_sub(begin[s])));
                n_rows += end[s] - begin[s];
            }
        }
        let local_row = |row: usize| {
            let s = self.symbolic.supernode_of[row];
            local[s] + row - begin[s]
        };
        let width = columns.len();
        let mut rows = Mat::<f64>::zeros(n_rows, width);
        for (j, column) in columns.iter().enumerate() {
            for &(row, value) in column {
                rows[(local_row(row), j)] += value;
            }
        }
        let mut flops = 0.0;
        let longest = supernodes
            .iter()
            .map(|&(s, ..)| l.supernode(s).pattern().len())
            .max();
        let mut product = Mat::<f64>::zeros(longest.unwrap_or(0), width);
        let mut targets = Vec::new();
        for &(s, first, _) in &supernodes {
            let s = l.supernode(s);
            let size = s.val().ncols();
            let (top, below) = s.val().split_at_row(size);
            let mut x = rows.as_mut().subrows_mut(first, size);
            solve_lower_triangular_in_place(top, x.as_mut(), Par::Seq);
            let m = below.nrows();
            let mut product = product.as_mut().subrows_mut(0, m);
            matmul(
                product.as_mut(),
                Accum::Replace,
                below,
                x.as_ref(),
                1.0,
                Par::Seq,
            );
            flops += (size * (size + 2 * m) * width) as f64;
            targets.clear();
            targets.extend(s.pattern().iter().map(|&row| local_row(row)));
            for j in 0..width {
                for (i, &target) in targets.iter().enumerate() {
                    rows[(target, j)] -= product[(i, j)];
                }
            }
        }
        let mut on_plane = [Mat::zeros(0, width), Mat::zeros(0, width)];
        if let Some(halves) = &self.symbolic.halves {
            on_plane = [0, 1].map(|parity| {
                let numbers = halves.on_plane(parity);
                Mat::from_fn(numbers.len(), width, |i, j| {
                    let number = numbers[i];
                    let is_reached = local[self.symbolic.supernode_of[number]] != usize::MAX;
                    if is_reached {
                        rows[(local_row(number), j)]
                    } else {
                        0.0
                    }
                })
            });
            let inner = supernodes.iter().map(|&(.., own)| own).sum();
            rows = rows.subrows(0, inner).to_owned();
        }
        Reached {
            supernodes,
            rows,
            on_plane,
            shares,
            count,
            flops,
        }
    }

    /// Products `first^T second` of two forward-substituted blocks.
    pub(super) fn product(&self, first: &Reached, second: &Reached) -> Products {
        let mut inner = Mat::<f64>::zeros(first.rows.ncols(), second.rows.ncols());
        let columns = (first.rows.ncols() * second.rows.ncols()) as f64;
        let mut flops = 0.0;
        let mut run: Option<(usize, usize, usize)> = None;
        let mut add = |(i, j, length): (usize, usize, usize)| {
            matmul(
                inner.as_mut(),
                Accum::Add,
                first.rows.as_ref().subrows(i, length).transpose(),
                second.rows.as_ref().subrows(j, length),
                1.0,
                Par::Seq,
            );
            flops += 2.0 * length as f64 * columns;
        };
        let mut others = second.supernodes.iter().peekable();
        for &(s, i, own) in &first.supernodes {
            while others.next_if(|other| other.0 < s).is_some() {}
            let Some(&(_, j, _)) = others.next_if(|other| other.0 == s) else {
                continue;
            };
            run = match run {
                Some((i0, j0, length)) if i0 + length == i && j0 + length == j => {
                    Some((i0, j0, length + own))
                }
                other => {
                    other.into_iter().for_each(&mut add);
                    Some((i, j, own))
                }
            };
        }
        run.into_iter().for_each(&mut add);
        if self.symbolic.halves.is_none() {
            return Products {
                each_other: inner,
                with_images: None,
                flops,
            };
        }
        let on_plane: [Mat<f64>; 2] = [0, 1].map(|parity| {
            let (first, second) = (&first.on_plane[parity], &second.on_plane[parity]);
            let mut product = inner.clone();
            matmul(
                product.as_mut(),
                Accum::Add,
                first.as_ref().transpose(),
                second.as_ref(),
                1.0,
                Par::Seq,
            );
            flops += 2.0 * first.nrows() as f64 * columns;
            product
        });
        let mut each_other = Mat::zeros(first.count, second.count);
        let mut with_images = Mat::zeros(first.count, second.count);
        for (q, (j, of_second)) in second.shares.iter().enumerate() {
            for (p, (i, of_first)) in first.shares.iter().enumerate() {
                let [even, odd] =
                    [0, 1].map(|k| 0.5 * of_first[k] * of_second[k] * on_plane[k][(p, q)]);
                each_other[(*i, *j)] += even + odd;
                with_images[(*i, *j)] += even - odd;
            }
        }
        Products {
            each_other,
            with_images: Some(with_images),
            flops,
        }
    }

    /// [`Factor::forward`] of several groups of columns at once.
    pub(super) fn forward_all(&self, groups: &[Vec<SparseColumn>]) -> Vec<Reached> {
        let reached = groups.par_iter().map(|group| self.forward(group)).collect();
        reset_workers();
        reached
    }
}

fn column(values: MatRef<'_, f64>, j: usize) -> &[f64] {
    let column = values.col(j).try_as_col_major();
    column
        .expect("a factor has its columns one after the other")
        .as_slice()
}

/// `y -= value x`, as far as `x` goes.
fn subtract(y: &mut [f64], value: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y -= value * x;
    }
}

/// The sums of `a b` of four columns, each in two parts that do not wait for each other.
fn products(a: [&[f64]; 4], b: &[f64]) -> [f64; 4] {
    let mut parts = [[0.0; 2]; 4];
    let pairs = b.len() / 2 * 2;
    let [first, second, third, fourth] = a.map(|a| a[..pairs].chunks_exact(2));
    let each = first.zip(second).zip(third).zip(fourth);
    for ((((a, b), c), d), by) in each.zip(b.chunks_exact(2)) {
        for (part, a) in parts.iter_mut().zip([a, b, c, d]) {
            part[0] += a[0] * by[0];
            part[1] += a[1] * by[1];
        }
    }
    std::array::from_fn(|k| {
        let last = if pairs < b.len() {
            a[k][pairs] * b[pairs]
        } else {
            0.0
        };
        parts[k][0] + parts[k][1] + last
    })
}

/// The sum of `a b`, as far as the shorter one goes.
fn product(a: &[f64], b: &[f64]) -> f64 {
    let length = a.len().min(b.len());
    let (a, b) = (a[..length].chunks_exact(8), b[..length].chunks_exact(8));
    let left = a.remainder().iter().zip(b.remainder());
    let mut sum: f64 = left.map(|(a, b)| a * b).sum();
    // in parts that do not wait for each other
    let mut parts = [0.0; 8];
    for (a, b) in a.zip(b) {
        for k in 0..8 {
            parts[k] += a[k] * b[k];
        }
    }
    for part in parts {
        sum += part;
    }
    sum
}

impl Reached {
    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        let on_plane = self.on_plane.iter().map(Mat::nrows).sum::<usize>();
        (self.rows.nrows() + on_plane) * self.rows.ncols() * 8
    }
}

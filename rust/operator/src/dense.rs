// SPDX-License-Identifier: MIT OR Apache-2.0
//! Factors of dense matrices, made in place and in pieces, with a look at the monitor between them.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{
    LltError, LltRegularization, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place,
    solve_unit_upper_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::prelude::{IntoConst, Reborrow, ReborrowMut};
use faer::traits::RealField;
use faer::{Accum, Mat, MatMut, MatRef, Par, Spec};
use rayon::prelude::*;

use crate::monitor::{Interrupted, Monitor, report};
use crate::{Error, ready_products};

/// Operations after which the monitor is asked: at most half a second on a slow core.
pub const WORK_UNWATCHED: f64 = 1e9;

/// Columns of a panel: from here on products run at their full speed.
const PANEL: usize = 256;

/// Columns of factors that a transposed solve takes at once.
const NARROW: usize = 16;

/// Rows of a square matrix from which on threads share its factorisation.
const SHARED: usize = 128;

/// The threads that factorise a square matrix of so many rows, or solve by its factors. Small ones stay on the thread
/// that asks: to hand them over takes longer than they do, by far where other programs keep the processors busy.
pub fn threads(rows: usize) -> Par {
    if rows < SHARED {
        Par::Seq
    } else {
        faer::get_global_parallelism()
    }
}

/// Counts operations, and asks the monitor whenever there were enough of them.
///
/// Code whose pieces are each below [`WORK_UNWATCHED`] is never unwatched for more than twice that.
pub struct Watch<'a> {
    monitor: Monitor<'a>,
    since: f64,
    looks: usize,
}

impl<'a> Watch<'a> {
    /// Starts to count.
    pub fn new(monitor: Monitor<'a>) -> Self {
        Self {
            monitor,
            since: 0.0,
            looks: 0,
        }
    }

    /// Counts operations that were made.
    ///
    /// # Errors
    /// [`Interrupted`] if the monitor was asked and wants to stop.
    pub fn spend(&mut self, operations: f64) -> Result<(), Interrupted> {
        self.since += operations;
        if self.since < WORK_UNWATCHED {
            return Ok(());
        }
        self.since = 0.0;
        self.looks += 1;
        report(self.monitor, self.looks, f64::NAN)
    }
}

/// How many of `count` parts of `operations` each are one piece.
fn piece(operations: f64, count: usize) -> usize {
    ((WORK_UNWATCHED / operations.max(1.0)) as usize).clamp(1, count.max(1))
}

/// Columns of the panels of a matrix of this size: few enough that one panel is one piece.
fn panel(n: usize) -> usize {
    let most = (WORK_UNWATCHED / n.max(1) as f64).sqrt() as usize;
    most.clamp(8, PANEL)
}

/// Numbers of double or single precision.
pub trait Real: RealField + Copy + From<i8> + Into<f64> {}

impl Real for f32 {}
impl Real for f64 {}

/// Gauss' factors of a square matrix, with partial pivoting.
#[derive(Clone, Debug)]
pub struct Lu<T = f64> {
    factors: Mat<T>,
    order: Vec<usize>,
    sign: f64,
}

/// Gauss' factors on their way: panel after panel, so that the work may be spread over other work.
#[derive(Clone, Debug)]
pub struct LuInParts<T = f64> {
    matrix: Mat<T>,
    order: Vec<usize>,
    is_odd: bool,
    start: usize,
    width: usize,
}

impl<T: Real> LuInParts<T> {
    /// Begins with `matrix`, in panels of `width` columns.
    pub fn new(matrix: Mat<T>, width: usize) -> Self {
        let n = matrix.nrows();
        Self {
            order: (0..n).collect(),
            is_odd: false,
            start: 0,
            width: width.clamp(1, panel(n)),
            matrix,
        }
    }

    /// Factorises the next panel; whether it was the last one.
    ///
    /// # Errors
    /// [`Error::Interrupted`], [`Error::Buffer`]; what is there then is of no use.
    pub fn advance(&mut self, par: Par, watch: &mut Watch<'_>) -> Result<bool, Error> {
        ready_products()?;
        let (n, start) = (self.matrix.nrows(), self.start);
        if start == n {
            return Ok(true);
        }
        let (size, rows) = (self.width.min(n - start), n - start);
        let mut memory = MemBuffer::new(lu_in_place_scratch::<usize, T>(
            rows,
            size,
            par,
            Spec::default(),
        ));
        let (mut forward, mut backward) = (vec![0_usize; rows], vec![0_usize; rows]);
        let (info, _) = lu_in_place(
            self.matrix.as_mut().submatrix_mut(start, start, rows, size),
            &mut forward,
            &mut backward,
            par,
            MemStack::new(&mut memory),
            Spec::default(),
        );
        self.is_odd ^= info.transposition_count % 2 == 1;
        watch.spend((rows * size * size) as f64)?;
        // the few rows that the panel exchanged, in all other columns
        let moved: Vec<(usize, usize)> = forward
            .iter()
            .enumerate()
            .filter(|&(to, &from)| to != from)
            .map(|(to, &from)| (start + to, start + from))
            .collect();
        exchange(&mut self.order, &moved);
        for column in (0..start).chain(start + size..n) {
            exchange(self.matrix.col_as_slice_mut(column), &moved);
        }
        watch.spend((moved.len() * (n - size)) as f64)?;
        let (left, mut right) = self.matrix.as_mut().split_at_col_mut(start + size);
        let left = left.rb();
        let upper = left.submatrix(start, start, size, size);
        let lower = left.submatrix(start + size, start, rows - size, size);
        let each = (size * size + 2 * size * (rows - size)) as f64;
        let columns = right.ncols();
        let step = piece(each, columns);
        for first in (0..columns).step_by(step) {
            let count = step.min(columns - first);
            let below = right.rb_mut().submatrix_mut(start, first, rows, count);
            let (mut x, y) = below.split_at_row_mut(size);
            solve_unit_lower_triangular_in_place(upper, x.rb_mut(), par);
            matmul(y, Accum::Add, lower, x.rb(), T::from(-1), par);
            watch.spend(each * count as f64)?;
        }
        self.start += size;
        Ok(self.start == n)
    }

    /// The factors, once all panels are.
    pub fn finish(self) -> Lu<T> {
        let mut sign = if self.is_odd { -1.0 } else { 1.0 };
        for i in 0..self.matrix.nrows() {
            let pivot: f64 = self.matrix[(i, i)].into();
            sign *= pivot.signum();
        }
        Lu {
            factors: self.matrix,
            order: self.order,
            sign,
        }
    }
}

impl<T: Real> Lu<T> {
    /// Factorises `matrix` in its own memory, on the threads of `par`.
    ///
    /// # Errors
    /// [`Error::Interrupted`], [`Error::Buffer`].
    pub fn new(matrix: Mat<T>, par: Par, monitor: Monitor<'_>) -> Result<Self, Error> {
        let mut watch = Watch::new(monitor);
        let width = panel(matrix.nrows());
        let mut parts = LuInParts::new(matrix, width);
        while !parts.advance(par, &mut watch)? {}
        Ok(parts.finish())
    }

    /// Sign of the determinant.
    pub fn sign(&self) -> f64 {
        self.sign
    }

    /// Row of the matrix that each row of the factors came from.
    pub fn order(&self) -> &[usize] {
        &self.order
    }

    /// Both factors: `U`, and `L` below its diagonal of ones.
    pub fn factors(&self) -> MatRef<'_, T> {
        self.factors.as_ref()
    }

    /// The solution for the columns of `rhs`.
    ///
    /// # Errors
    /// [`Error::Interrupted`], [`Error::Buffer`].
    pub fn solve(
        &self,
        rhs: MatRef<'_, T>,
        par: Par,
        monitor: Monitor<'_>,
    ) -> Result<Mat<T>, Error> {
        ready_products()?;
        let mut x = self.ordered(rhs);
        in_pieces(x.as_mut(), monitor, |part| self.substitute(part, par))?;
        Ok(x)
    }

    /// The same for few columns, without a look at a monitor.
    pub fn solve_few(&self, rhs: MatRef<'_, T>, par: Par) -> Mat<T> {
        let mut x = self.ordered(rhs);
        self.substitute(x.as_mut(), par);
        x
    }

    fn ordered(&self, rhs: MatRef<'_, T>) -> Mat<T> {
        Mat::from_fn(rhs.nrows(), rhs.ncols(), |i, j| rhs[(self.order[i], j)])
    }

    fn substitute(&self, mut x: MatMut<'_, T>, par: Par) {
        solve_unit_lower_triangular_in_place(self.factors(), x.rb_mut(), par);
        solve_upper_triangular_in_place(self.factors(), x, par);
    }
}

impl Lu {
    /// The solution with the transposed matrix, for few columns.
    pub fn solve_few_transposed(&self, rhs: MatRef<'_, f64>, par: Par) -> Mat<f64> {
        let (n, cases) = (rhs.nrows(), rhs.ncols());
        if cases == 1 {
            let mut x = rhs.to_owned();
            return self.put_back(self.substitute_transposed(x.as_mut().transpose_mut(), par));
        }
        // side by side for each unknown: products from the left with columns of the factors pack neither of them
        let mut x = Mat::zeros(cases, n);
        for j in 0..cases {
            for i in 0..n {
                x[(j, i)] = rhs[(i, j)];
            }
        }
        self.put_back(self.substitute_transposed(x.as_mut(), par))
    }

    /// Overwrites the rows of `x` with solutions for the transposed matrix, in the order of its factors.
    fn substitute_transposed<'x>(&self, mut x: MatMut<'x, f64>, par: Par) -> MatRef<'x, f64> {
        let (n, factors) = (self.factors.nrows(), self.factors());
        for first in (0..n).step_by(NARROW) {
            let width = NARROW.min(n - first);
            let (above, here) = x.rb_mut().split_at_col_mut(first);
            let mut here = here.subcols_mut(0, width);
            if first > 0 {
                let block = factors.submatrix(0, first, first, width);
                matmul(here.rb_mut(), Accum::Add, above, block, -1.0, par);
            }
            let own = factors.submatrix(first, first, width, width);
            solve_lower_triangular_in_place(own.transpose(), here.transpose_mut(), par);
        }
        for first in (0..n).step_by(NARROW).rev() {
            let end = n.min(first + NARROW);
            let (here, below) = x.rb_mut().split_at_col_mut(end);
            let mut here = here.subcols_mut(first, end - first);
            if end < n {
                let block = factors.submatrix(end, first, n - end, end - first);
                matmul(here.rb_mut(), Accum::Add, below, block, -1.0, par);
            }
            let own = factors.submatrix(first, first, end - first, end - first);
            solve_unit_upper_triangular_in_place(own.transpose(), here.transpose_mut(), par);
        }
        x.into_const()
    }

    /// Rows in the order of the factors as columns in that of the matrix.
    fn put_back(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let mut put_back = Mat::zeros(x.ncols(), x.nrows());
        for j in 0..x.nrows() {
            let to = put_back.col_as_slice_mut(j);
            for (i, &row) in self.order.iter().enumerate() {
                to[row] = x[(j, i)];
            }
        }
        put_back
    }
}

/// Puts what stands at `from` to `to`, all at once.
fn exchange<T: Copy>(values: &mut [T], moved: &[(usize, usize)]) {
    let taken: Vec<T> = moved.iter().map(|&(_, from)| values[from]).collect();
    for (&(to, _), value) in moved.iter().zip(taken) {
        values[to] = value;
    }
}

/// Why there is no factor of Cholesky's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unfactored {
    /// The pivot of this column is not positive.
    Pivot(usize),
    /// The monitor asked to stop.
    Interrupted,
}

impl From<Interrupted> for Unfactored {
    fn from(Interrupted: Interrupted) -> Self {
        Unfactored::Interrupted
    }
}

/// Columns of a panel of Cholesky's factor, and of strips of the columns right of it.
const STRIP: usize = 128;

/// Rows below a panel that a thread takes at once, at least.
const ROWS: usize = 64;

/// Rows of a strip that a thread takes at once.
const TILE: usize = 512;

/// Puts the first columns of Cholesky's factor in the place of those of a symmetric positive definite matrix.
///
/// There are as many rows as columns or more. Above the diagonal nothing is read or written. The numbers do not
/// depend on the number of threads.
///
/// # Errors
/// [`Unfactored`]; what then stands in `matrix` is of no use.
pub fn cholesky_columns<T: Real>(
    mut matrix: MatMut<'_, T>,
    par: Par,
    watch: &mut Watch<'_>,
) -> Result<(), Unfactored> {
    let (rows, columns) = (matrix.nrows(), matrix.ncols());
    let width = panel(rows).min(STRIP);
    // as many columns for each panel: a few that are left would take far longer than their share
    let width = columns.div_ceil(columns.div_ceil(width).max(1)).max(1);
    let request = cholesky_in_place_scratch::<T>(width, Par::Seq, Spec::default());
    let mut memory = MemBuffer::new(request);
    for start in (0..columns).step_by(width) {
        let size = width.min(columns - start);
        let below = rows - start - size;
        let (left, right) = matrix.rb_mut().split_at_col_mut(start + size);
        let panel = left.submatrix_mut(start, start, rows - start, size);
        let (mut top, mut lower) = panel.split_at_row_mut(size);
        // of one thread: the work of a panel is below its rows, and too small a square only makes threads wait
        cholesky_in_place(
            top.rb_mut(),
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Spec::default(),
        )
        .map_err(|LltError::NonPositivePivot { index }| Unfactored::Pivot(start + index))?;
        let top = top.rb();
        let solve = |rows: MatMut<'_, T>| {
            solve_lower_triangular_in_place(top, rows.transpose_mut(), Par::Seq);
        };
        let parts = par.degree().min(below.div_ceil(ROWS));
        if parts > 1 {
            lower.rb_mut().par_row_partition_mut(parts).for_each(solve);
        } else {
            solve(lower.rb_mut());
        }
        watch.spend((size * size * (below + size)) as f64)?;
        let lower = lower.rb();
        let mut rest = right.subrows_mut(start + size, below);
        let columns = rest.ncols();
        let step = piece((2 * size * below) as f64, columns);
        for group in (0..columns).step_by(step) {
            let count = step.min(columns - group);
            let strips = rest.rb_mut().subcols_mut(group, count);
            let update = |tile: Tile<'_, T>| tile.subtract(lower);
            let tiles = tiles(strips, group);
            if par.degree() > 1 {
                tiles.into_par_iter().with_max_len(1).for_each(update);
            } else {
                tiles.into_iter().for_each(update);
            }
            watch.spend((2 * size * (below - group) * count) as f64)?;
        }
    }
    Ok(())
}

/// A part of the columns right of a panel, below the diagonal or on it.
struct Tile<'a, T> {
    values: MatMut<'a, T>,
    row: usize,
    column: usize,
}

impl<T: Real> Tile<'_, T> {
    /// Subtracts its part of the product of the rows of a panel with themselves.
    fn subtract(self, rows: MatRef<'_, T>) {
        let (height, width) = (self.values.nrows(), self.values.ncols());
        let (minus, accum) = (T::from(-1), Accum::Add);
        let left = rows.subrows(self.row, height);
        if self.row == self.column {
            lower_product(self.values, accum, left, minus, Par::Seq);
            return;
        }
        let right = rows.subrows(self.column, width).transpose();
        matmul(self.values, accum, left, right, minus, Par::Seq);
    }
}

/// Tiles of columns from `first` on.
fn tiles<T>(mut columns: MatMut<'_, T>, first: usize) -> Vec<Tile<'_, T>> {
    let mut tiles = Vec::new();
    let (rows, end) = (columns.nrows(), first + columns.ncols());
    for column in (first..end).step_by(STRIP) {
        let (strip, right) = columns.split_at_col_mut(STRIP.min(end - column));
        columns = right;
        let mut strip = strip.subrows_mut(column, rows - column);
        for row in (column..rows).step_by(TILE) {
            let (values, below) = strip.split_at_row_mut(TILE.min(rows - row));
            strip = below;
            tiles.push(Tile {
                values,
                row,
                column,
            });
        }
    }
    tiles
}

/// Of `factor rows rows^T` the first columns, as many as `product` has, on and below the diagonal.
pub fn lower_product<T: Real>(
    product: MatMut<'_, T>,
    accum: Accum,
    rows: MatRef<'_, T>,
    factor: T,
    par: Par,
) {
    let columns = product.ncols();
    let (first, others) = rows.split_at_row(columns);
    let (square, below) = product.split_at_row_mut(columns);
    triangular::matmul(
        square,
        BlockStructure::TriangularLower,
        accum,
        first,
        BlockStructure::Rectangular,
        first.transpose(),
        BlockStructure::Rectangular,
        factor,
        par,
    );
    matmul(below, accum, others, first.transpose(), factor, par);
}

/// Cholesky's factor of a symmetric positive definite matrix.
#[derive(Clone, Debug)]
pub struct Cholesky<T = f64>(Mat<T>);

impl<T: Real> Cholesky<T> {
    /// Factorises the lower triangle of `matrix` in its own memory; `None` where it is not positive definite.
    ///
    /// # Errors
    /// [`Error::Interrupted`], [`Error::Buffer`].
    pub fn new(mut matrix: Mat<T>, par: Par, monitor: Monitor<'_>) -> Result<Option<Self>, Error> {
        ready_products()?;
        match cholesky_columns(matrix.as_mut(), par, &mut Watch::new(monitor)) {
            Ok(()) => Ok(Some(Self(matrix))),
            Err(Unfactored::Pivot(_)) => Ok(None),
            Err(Unfactored::Interrupted) => Err(Error::Interrupted),
        }
    }

    /// The factor: a lower triangle, with anything above its diagonal.
    pub fn lower(&self) -> MatRef<'_, T> {
        self.0.as_ref()
    }

    /// The solution for the columns of `rhs`.
    ///
    /// # Errors
    /// [`Error::Interrupted`], [`Error::Buffer`].
    pub fn solve(
        &self,
        rhs: MatRef<'_, T>,
        par: Par,
        monitor: Monitor<'_>,
    ) -> Result<Mat<T>, Error> {
        ready_products()?;
        let mut x = rhs.to_owned();
        in_pieces(x.as_mut(), monitor, |mut part| {
            solve_lower_triangular_in_place(self.lower(), part.rb_mut(), par);
            solve_upper_triangular_in_place(self.lower().transpose(), part, par);
        })?;
        Ok(x)
    }
}

/// Triangular solves of a few columns at a time.
fn in_pieces<T>(
    mut x: MatMut<'_, T>,
    monitor: Monitor<'_>,
    mut solve: impl FnMut(MatMut<'_, T>),
) -> Result<(), Interrupted> {
    let mut watch = Watch::new(monitor);
    let each = 2.0 * (x.nrows() as f64).powi(2);
    let count = x.ncols();
    let step = piece(each, count);
    for first in (0..count).step_by(step) {
        let columns = step.min(count - first);
        solve(x.rb_mut().subcols_mut(first, columns));
        watch.spend(each * columns as f64)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::ops::ControlFlow;
    use std::sync::mpsc::channel;
    use std::sync::{Arc, Mutex};
    use std::time::Duration;

    use super::*;
    use crate::{Progress, unmonitored};

    /// Numbers without structure, the same on every run.
    fn random(n: usize, columns: usize) -> Mat<f64> {
        let mut seed = 0x9E37_79B9_7F4A_7C15_u64;
        Mat::from_fn(n, columns, |_, _| {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            seed as f64 / u64::MAX as f64 - 0.5
        })
    }

    fn definite(n: usize) -> Mat<f64> {
        let a = random(n, n);
        let shift = Mat::<f64>::identity(n, n) * faer::Scale(n as f64 / 12.0);
        &a * a.transpose() + shift
    }

    fn is_solved(a: &Mat<f64>, x: &Mat<f64>, rhs: &Mat<f64>) -> bool {
        (a * x - rhs).norm_max() <= 1e-9 * a.norm_max() * x.norm_max()
    }

    #[test]
    fn small_matrices_wait_for_no_other_thread() {
        let busy = Arc::new(Mutex::new(()));
        let until = busy.lock().unwrap();
        let held = Arc::clone(&busy);
        rayon::spawn_broadcast(move |_| drop(held.lock()));
        let (sender, solved) = channel();
        std::thread::spawn(move || {
            let (a, rhs) = (random(100, 100), random(100, 3));
            let par = threads(100);
            let lu = Lu::new(a.clone(), par, &unmonitored).unwrap();
            let x = lu.solve(rhs.as_ref(), par, &unmonitored).unwrap();
            sender.send(is_solved(&a, &x, &rhs)).unwrap();
        });
        assert_eq!(solved.recv_timeout(Duration::from_secs(60)), Ok(true));
        drop(until);
        assert_ne!(threads(1000), Par::Seq);
    }

    #[test]
    fn factors_of_single_precision_solve_to_their_rounding() {
        let n = PANEL + 17;
        // dominated by its diagonal, so that rounding grows little
        let mut a = random(n, n);
        for i in 0..n {
            a[(i, i)] += n as f64;
        }
        let exact = random(n, 2);
        let single = |m: &Mat<f64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] as f32);
        let lu = Lu::new(single(&a), Par::Seq, &unmonitored).unwrap();
        let x = lu.solve_few(single(&(&a * &exact)).as_ref(), Par::Seq);
        let miss = Mat::from_fn(n, 2, |i, j| f64::from(x[(i, j)]) - exact[(i, j)]).norm_max();
        assert!(miss < 1e-5, "{miss:e}");
        let twice = Lu::new(a, Par::Seq, &unmonitored).unwrap();
        assert_eq!(lu.sign(), twice.sign());
    }

    #[test]
    fn factors_of_many_panels_solve() {
        for n in [1, 3, PANEL, PANEL + 1, 3 * PANEL + 17] {
            let rhs = random(n, 3);
            let a = random(n, n);
            let lu = Lu::new(a.clone(), Par::Seq, &unmonitored).unwrap();
            let x = lu.solve(rhs.as_ref(), Par::Seq, &unmonitored).unwrap();
            assert!(is_solved(&a, &x, &rhs), "LU of {n}");
            let x = lu.solve_few_transposed(rhs.as_ref(), Par::Seq);
            assert!(
                is_solved(&a.transpose().to_owned(), &x, &rhs),
                "transposed LU of {n}"
            );
            assert_eq!(lu.sign(), a.determinant().signum(), "sign of {n}");
            let mut parts = LuInParts::new(a.clone(), 40);
            let mut count = 1;
            while !parts
                .advance(Par::Seq, &mut Watch::new(&unmonitored))
                .unwrap()
            {
                count += 1;
            }
            assert_eq!(count, n.div_ceil(40));
            let lu = parts.finish();
            let x = lu.solve(rhs.as_ref(), Par::Seq, &unmonitored).unwrap();
            assert!(is_solved(&a, &x, &rhs), "LU in parts of {n}");
            assert_eq!(lu.sign(), a.determinant().signum(), "sign in parts of {n}");
            let a = definite(n);
            let llt = Cholesky::new(a.clone(), Par::Seq, &unmonitored)
                .unwrap()
                .expect("positive definite");
            let x = llt.solve(rhs.as_ref(), Par::Seq, &unmonitored).unwrap();
            assert!(is_solved(&a, &x, &rhs), "Cholesky of {n}");
            let shared = Cholesky::new(a, Par::rayon(2), &unmonitored)
                .unwrap()
                .expect("positive definite");
            for j in 0..n {
                let below = |factor: &Cholesky| factor.0.col_as_slice(j)[j..].to_vec();
                assert_eq!(below(&shared), below(&llt), "column {j} of {n}");
            }
        }
    }

    #[test]
    fn what_is_not_definite_has_no_cholesky_factor() {
        for bad in [0, PANEL - 1, PANEL + 40] {
            let mut a = definite(PANEL + 50);
            a[(bad, bad)] = -1.0;
            let found = Cholesky::new(a, Par::Seq, &unmonitored).unwrap();
            assert!(found.is_none(), "row {bad}");
        }
    }

    #[test]
    fn work_between_two_looks_is_bounded_and_a_wish_to_stop_is_heard() {
        let n = 2300;
        let looks = Cell::new(0_u32);
        let count = |_: Progress| {
            looks.set(looks.get() + 1);
            ControlFlow::Continue(())
        };
        let cube = (n as f64).powi(3);
        let made = |least: f64| {
            let work = f64::from(looks.replace(0) + 1) * 2.0 * WORK_UNWATCHED;
            assert!(
                work >= least,
                "{work:e} of {least:e} operations are watched"
            );
        };
        let rhs = random(n, 400);
        let lu = Lu::new(random(n, n), Par::Seq, &count).unwrap();
        made(2.0 / 3.0 * cube);
        lu.solve(rhs.as_ref(), Par::Seq, &count).unwrap();
        made(2.0 * 400.0 * (n as f64).powi(2));
        let mut a = random(n, n);
        for i in 0..n {
            a[(i, i)] += n as f64;
        }
        assert!(Cholesky::new(a, Par::Seq, &count).unwrap().is_some());
        made(1.0 / 3.0 * cube);
        let stop = |_: Progress| ControlFlow::Break(());
        assert_eq!(
            Lu::new(random(n, n), Par::Seq, &stop).err(),
            Some(Error::Interrupted)
        );
    }

    #[test]
    fn no_piece_is_larger_than_what_may_go_unwatched() {
        for n in [100, 3000, 15_000, 60_000] {
            let width = panel(n) as f64;
            assert!(n as f64 * width * width <= WORK_UNWATCHED, "panel of {n}");
            let each = 2.0 * width * n as f64;
            assert!(
                each * piece(each, n) as f64 <= WORK_UNWATCHED.max(each),
                "update of {n}"
            );
        }
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sums of columns of dense matrices, by the widest instructions, and what is made of them.

use std::ops::{Add, DivAssign, Mul, Neg, Range, Sub};

use mtb_operator::dense::{Cholesky, Lu, Real};
use mtb_operator::wide;

/// Columns that pass by at once: what they are added to is then read and written that many times less.
const AT_ONCE: usize = 8;

/// Entries of a product that are summed side by side.
const LANES: usize = 16;

/// The largest magnitude of values, 0 of none.
pub(crate) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0_f64, |most, v| most.max(v.abs()))
}

/// Adds columns, each times its factor, to `sum`.
pub(crate) fn add_columns<T>(columns: &[(&[T], T)], sum: &mut [T])
where
    T: Copy + Add<Output = T> + Mul<Output = T>,
{
    wide(
        #[inline(always)]
        || {
            let eights = columns.chunks_exact(AT_ONCE);
            for (column, factor) in eights.remainder() {
                for (sum, a) in sum.iter_mut().zip(*column) {
                    *sum = *sum + *factor * *a;
                }
            }
            for eight in eights {
                let [a, b, c, d, e, f, g, h] = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| eight[i].0.iter());
                let v: [T; AT_ONCE] = std::array::from_fn(|i| eight[i].1);
                let left = sum.iter_mut().zip(a).zip(b).zip(c).zip(d);
                let right = e.zip(f).zip(g).zip(h);
                for (((((sum, a), b), c), d), (((e, f), g), h)) in left.zip(right) {
                    let left = (v[0] * *a + v[1] * *b) + (v[2] * *c + v[3] * *d);
                    let right = (v[4] * *e + v[5] * *f) + (v[6] * *g + v[7] * *h);
                    *sum = *sum + (left + right);
                }
            }
        },
    );
}

/// Overwrites `x` with the solution by `factors`, on one thread; `work` has the same length.
pub(crate) fn solve<T>(factors: &Lu<T>, x: &mut [T], work: &mut Vec<T>)
where
    T: Real + Add<Output = T> + Sub<Output = T> + Mul<Output = T> + DivAssign + Neg<Output = T>,
{
    work.clear();
    work.extend(factors.order().iter().map(|&i| x[i]));
    let k = x.len();
    let columns = factors.factors();
    let column = |j: usize, rows: Range<usize>| -> &[T] {
        let column = columns.col(j).try_as_col_major();
        column.map_or(&[], |column| &column.as_slice()[rows])
    };
    // takes rows of columns from `first` on, each times its factor, off
    let subtract = |factors: &[T], first: usize, rows: Range<usize>, y: &mut [T]| {
        let mut some: [(&[T], T); AT_ONCE] = [(&[], T::from(0)); AT_ONCE];
        for (j, (one, factor)) in some.iter_mut().zip(factors).enumerate() {
            *one = (column(first + j, rows.clone()), -*factor);
        }
        add_columns(&some[..factors.len()], y);
    };
    for first in (0..k).step_by(AT_ONCE) {
        let end = k.min(first + AT_ONCE);
        let (head, tail) = work.split_at_mut(end);
        for j in first..end {
            let (here, below) = head.split_at_mut(j + 1);
            subtract(&here[j..], j, j + 1..end, below);
        }
        subtract(&head[first..], first, end..k, tail);
    }
    for first in (0..k).step_by(AT_ONCE).rev() {
        let end = k.min(first + AT_ONCE);
        let (above, here) = work.split_at_mut(first);
        for j in (first..end).rev() {
            let (head, tail) = here.split_at_mut(j - first);
            tail[0] /= column(j, j..j + 1)[0];
            subtract(&tail[..1], j, first..j, head);
        }
        subtract(&here[..end - first], first, 0..first, above);
    }
    x.copy_from_slice(work);
}

/// Sums of products of up to [`AT_ONCE`] columns with a vector, zeros beyond.
fn products<T>(columns: &[&[T]; AT_ONCE], vector: &[T]) -> [T; AT_ONCE]
where
    T: Copy + From<i8> + Add<Output = T> + Mul<Output = T>,
{
    let mut found = [T::from(0); AT_ONCE];
    wide(
        #[inline(always)]
        || {
            for (found, columns) in found.chunks_exact_mut(4).zip(columns.chunks_exact(4)) {
                // many sums side by side, so that the products need not wait for each other
                let mut sums = [[T::from(0); LANES]; 4];
                let [a, b, c, d] = [0, 1, 2, 3].map(|i| &columns[i][..vector.len()]);
                let (parts, rest) = vector.as_chunks::<LANES>();
                let first = vector.len() - rest.len();
                let ab = a
                    .as_chunks::<LANES>()
                    .0
                    .iter()
                    .zip(b.as_chunks::<LANES>().0);
                let cd = c
                    .as_chunks::<LANES>()
                    .0
                    .iter()
                    .zip(d.as_chunks::<LANES>().0);
                for (v, ((a, b), (c, d))) in parts.iter().zip(ab.zip(cd)) {
                    for l in 0..LANES {
                        sums[0][l] = sums[0][l] + a[l] * v[l];
                        sums[1][l] = sums[1][l] + b[l] * v[l];
                        sums[2][l] = sums[2][l] + c[l] * v[l];
                        sums[3][l] = sums[3][l] + d[l] * v[l];
                    }
                }
                for (i, v) in rest.iter().enumerate() {
                    for (sums, column) in sums.iter_mut().zip([a, b, c, d]) {
                        sums[i] = sums[i] + column[first + i] * *v;
                    }
                }
                for (found, mut sums) in found.iter_mut().zip(sums) {
                    for half in [LANES / 2, LANES / 4, LANES / 8, LANES / 16] {
                        for l in 0..half {
                            sums[l] = sums[l] + sums[l + half];
                        }
                    }
                    *found = sums[0];
                }
            }
        },
    );
    found
}

/// A square at the diagonal, by its columns.
type Square<T> = [[T; AT_ONCE]; AT_ONCE];

/// Cholesky's factor for many solutions on one thread.
#[derive(Clone, Debug)]
pub(crate) struct Bands<T> {
    factor: Cholesky<T>,
    /// Of the columns that pass by at once, the inverse of the square at the diagonal, and its transpose. What is missing
    /// of the last one is zero.
    inverses: Vec<[Square<T>; 2]>,
}

impl<T> Bands<T>
where
    T: Real + Add<Output = T> + Sub<Output = T> + Mul<Output = T> + DivAssign + Neg<Output = T>,
{
    pub(crate) fn new(factor: Cholesky<T>) -> Self {
        let lower = factor.lower();
        let k = lower.nrows();
        let inverses = (0..k).step_by(AT_ONCE).map(|first| {
            let count = AT_ONCE.min(k - first);
            let mut both = [[[T::from(0); AT_ONCE]; AT_ONCE]; 2];
            for j in 0..count {
                // a column of the unit matrix, solved for
                let mut column = [T::from(0); AT_ONCE];
                column[j] = T::from(1);
                for i in j..count {
                    column[i] /= lower[(first + i, first + i)];
                    for below in i + 1..count {
                        column[below] -= column[i] * lower[(first + below, first + i)];
                    }
                }
                both[0][j] = column;
                for i in j..count {
                    both[1][i][j] = column[i];
                }
            }
            both
        });
        Self {
            inverses: inverses.collect(),
            factor,
        }
    }

    /// Number of unknowns.
    pub(crate) fn size(&self) -> usize {
        self.factor.lower().nrows()
    }

    /// What lies below the squares of the columns that pass by at once. Those missing have no rows either, but products
    /// take as many of each.
    fn below(&self, first: usize, end: usize) -> [&[T]; AT_ONCE] {
        let lower = self.factor.lower();
        std::array::from_fn(|j| -> &[T] {
            let column = lower.col((first + j).min(end - 1)).try_as_col_major();
            column.map_or(&[], |column| &column.as_slice()[end..])
        })
    }

    /// Overwrites `x` with the solution.
    pub(crate) fn solve(&self, x: &mut [T]) {
        let k = x.len();
        for (first, [inverse, _]) in (0..k).step_by(AT_ONCE).zip(&self.inverses) {
            let end = k.min(first + AT_ONCE);
            let (head, tail) = x.split_at_mut(end);
            let here = times(inverse, &head[first..]);
            head[first..].copy_from_slice(&here[..end - first]);
            let columns = self.below(first, end);
            let some: [(&[T], T); AT_ONCE] = std::array::from_fn(|j| (columns[j], -here[j]));
            add_columns(&some, tail);
        }
        for (first, [_, inverse]) in (0..k).step_by(AT_ONCE).zip(&self.inverses).rev() {
            let end = k.min(first + AT_ONCE);
            let (head, tail) = x.split_at_mut(end);
            let known = products(&self.below(first, end), tail);
            for (here, known) in head[first..].iter_mut().zip(known) {
                *here -= known;
            }
            let here = times(inverse, &head[first..]);
            head[first..].copy_from_slice(&here[..end - first]);
        }
    }
}

/// The product of a square with a vector, whose missing last entries are zero.
fn times<T>(square: &Square<T>, vector: &[T]) -> [T; AT_ONCE]
where
    T: Copy + From<i8> + Add<Output = T> + Mul<Output = T>,
{
    wide(
        #[inline(always)]
        || {
            let mut product = [T::from(0); AT_ONCE];
            for (column, v) in square.iter().zip(vector) {
                product = std::array::from_fn(
                    #[inline(always)]
                    |i| product[i] + column[i] * *v,
                );
            }
            product
        },
    )
}

#[cfg(test)]
mod tests {
    use faer::{Mat, Par};
    use mtb_operator::unmonitored;

    use super::*;

    #[test]
    fn solutions_by_factors_meet_the_equations() {
        for n in [1, 7, 8, 9, 40] {
            let entry = |i: usize, j: usize| ((7 * i + 3 * j + i * j) % 13) as f64 - 6.0;
            // rows are exchanged: the largest entries are beside the diagonal
            let matrix = Mat::from_fn(n, n, |i, j| {
                entry(i, j) + if (i + 1) % n == j { 90.0 } else { 0.0 }
            });
            let factors = Lu::new(matrix.clone(), Par::Seq, &unmonitored).unwrap();
            let exact: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
            let mut x: Vec<f64> = (0..n)
                .map(|i| (0..n).map(|j| matrix[(i, j)] * exact[j]).sum())
                .collect();
            solve(&factors, &mut x, &mut Vec::new());
            for (x, exact) in x.iter().zip(&exact) {
                assert!((x - exact).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn solutions_by_cholesky_factors_meet_the_equations() {
        for n in [1, 7, 8, 9, 16, 40, 67] {
            // positive definite, as the diagonal is larger than all else in its row
            let entry = |i: usize, j: usize| ((5 * (i + j) + 3 * i * j) % 11) as f64 - 5.0;
            let matrix = Mat::from_fn(n, n, |i, j| {
                entry(i, j) + if i == j { 6.0 * n as f64 } else { 0.0 }
            });
            let factor = Cholesky::new(matrix.clone(), Par::Seq, &unmonitored);
            let factor = factor.unwrap().unwrap();
            let exact: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
            let mut x: Vec<f64> = (0..n)
                .map(|i| (0..n).map(|j| matrix[(i, j)] * exact[j]).sum())
                .collect();
            Bands::new(factor).solve(&mut x);
            for (x, exact) in x.iter().zip(&exact) {
                assert!((x - exact).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn sums_of_any_number_of_columns_are_those_of_their_entries() {
        let entry = |i: usize, j: usize| ((3 * i + 5 * j) % 11) as f64 - 4.0;
        for count in [0, 1, 7, 8, 9, 16, 21] {
            let columns: Vec<Vec<f64>> = (0..count)
                .map(|j| (0..37).map(|i| entry(i, j)).collect())
                .collect();
            let given: Vec<(&[f64], f64)> = (columns.iter().enumerate())
                .map(|(j, column)| (column.as_slice(), j as f64 - 2.0))
                .collect();
            let mut sum = vec![1.0; 37];
            add_columns(&given, &mut sum);
            for (i, sum) in sum.iter().enumerate() {
                let exact: f64 = (0..count).map(|j| (j as f64 - 2.0) * entry(i, j)).sum();
                // whole numbers: without rounding
                assert_eq!(*sum, 1.0 + exact);
            }
        }
    }
}

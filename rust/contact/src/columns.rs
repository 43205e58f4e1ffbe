// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sums of columns of dense matrices, by the widest instructions.

use std::ops::{Add, Mul};

use mtb_operator::wide;

/// Columns that pass by at once: what they are added to is then read and written that many times less.
pub(crate) const AT_ONCE: usize = 8;

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

#[cfg(test)]
mod tests {
    use super::*;

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

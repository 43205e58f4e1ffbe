// SPDX-License-Identifier: MIT OR Apache-2.0
//! Krylov solvers for closures that know how to multiply.

use crate::wide::wide;

/// Entries of a vector that stay in the cache while those of all others pass by.
const CHUNK: usize = 1024;

/// Share of a vector's length left of it at which what is left may lean on what was taken out.
const CANCELLED: f64 = 0.1;

/// How a Krylov solve went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KrylovReport {
    /// Steps taken: products with the matrix, and applications of the preconditioner.
    pub steps: usize,
    /// Norm of the residual as the recurrence knows it.
    pub residual: f64,
}

/// The vectors of Krylov solves, to be used again: fresh memory costs as much as a step.
#[derive(Default)]
pub struct Krylov {
    basis: Vec<Vec<f64>>,
    work: Vec<f64>,
}

/// [`Krylov::gmres`] with memory of its own.
pub fn gmres(
    apply: impl FnMut(&[f64], &mut [f64]),
    precondition: impl FnMut(&[f64], &mut [f64]),
    x: &mut [f64],
    residual: &mut [f64],
    tolerance: f64,
    max_steps: usize,
) -> KrylovReport {
    Krylov::default().gmres(apply, precondition, x, residual, tolerance, max_steps)
}

/// The entry number `k` of a list of vectors, with `n` entries of any content.
fn vector(vectors: &mut Vec<Vec<f64>>, k: usize, n: usize) -> &mut [f64] {
    if vectors.len() == k {
        vectors.push(vec![0.0; n]);
    }
    vectors[k].resize(n, 0.0);
    &mut vectors[k]
}

impl Krylov {
    /// Right-preconditioned GMRES without restart for `A x = b`.
    ///
    /// `apply(v, out)` overwrites `out` with `A v`, `precondition(v, out)` with `M v`. `x` holds the start on
    /// entry and the solution on return; `residual` holds `b - A x` of the start on entry (so a start
    /// whose product is known costs nothing) and is used as work space. Stops when the residual norm
    /// falls to `tolerance` (absolute), after `max_steps`, or when the Krylov space is exhausted.
    ///
    /// [SaadSchultz1986]
    pub fn gmres(
        &mut self,
        mut apply: impl FnMut(&[f64], &mut [f64]),
        mut precondition: impl FnMut(&[f64], &mut [f64]),
        x: &mut [f64],
        residual: &mut [f64],
        tolerance: f64,
        max_steps: usize,
    ) -> KrylovReport {
        let n = x.len();
        let mut work = std::mem::take(&mut self.work);
        work.resize(n, 0.0);
        let product = |v: &[f64], out: &mut [f64]| {
            precondition(v, &mut work);
            apply(&work, out);
        };
        let (report, weights) = self.weights(product, residual, tolerance, max_steps);
        if report.steps > 0 {
            residual.fill(0.0);
            for (v, w) in self.basis.iter().zip(&weights) {
                add_scaled(residual, *w, v);
            }
            precondition(residual, &mut work);
            add_scaled(x, 1.0, &work);
        }
        self.work = work;
        report
    }

    /// The same for a caller that keeps what the preconditioner makes of each vector, and all that is linear in it: what
    /// belongs to the solution is the sum of what belongs to the vectors, which are given to `product` one after the
    /// other, each times its weight.
    ///
    /// `product(v, out)` overwrites `out` with `A M v`; `residual` is that of the start. No weights where that is small
    /// enough.
    pub fn weights(
        &mut self,
        mut product: impl FnMut(&[f64], &mut [f64]),
        residual: &[f64],
        tolerance: f64,
        max_steps: usize,
    ) -> (KrylovReport, Vec<f64>) {
        let n = residual.len();
        let start = norm(residual);
        if start <= tolerance || start == 0.0 || max_steps == 0 {
            let report = KrylovReport {
                steps: 0,
                residual: start,
            };
            return (report, Vec::new());
        }
        let basis = &mut self.basis;
        let first = vector(basis, 0, n).iter_mut().zip(residual);
        first.for_each(|(v, r)| *v = r / start);
        // columns of the triangular factor, the rotations, and the rotated right-hand side
        let mut columns: Vec<Vec<f64>> = Vec::new();
        let mut rotations: Vec<(f64, f64)> = Vec::new();
        let mut rhs = vec![start];
        loop {
            let k = columns.len();
            vector(basis, k + 1, n);
            let (basis, next) = basis.split_at_mut(k + 1);
            let next = next[0].as_mut_slice();
            product(&basis[k], next);
            let scale = norm(next);
            let mut column = project(basis, next);
            // a second sweep when cancellation has eaten the orthogonality
            let mut length = norm(next);
            if length < CANCELLED * scale {
                let corrections = project(basis, next);
                column
                    .iter_mut()
                    .zip(corrections)
                    .for_each(|(h, c)| *h += c);
                length = norm(next);
            }
            for (i, (c, s)) in rotations.iter().enumerate() {
                let (a, b) = (column[i], column[i + 1]);
                column[i] = c * a + s * b;
                column[i + 1] = c * b - s * a;
            }
            let diagonal = column[k].hypot(length);
            if diagonal <= f64::EPSILON * scale {
                // the preconditioned matrix is singular on this space: the new direction brings nothing
                break;
            }
            let (c, s) = (column[k] / diagonal, length / diagonal);
            column[k] = diagonal;
            columns.push(column);
            rotations.push((c, s));
            let last = rhs[k];
            rhs[k] = c * last;
            rhs.push(-s * last);
            let is_exhausted = length <= f64::EPSILON * scale;
            if rhs[k + 1].abs() <= tolerance || columns.len() == max_steps || is_exhausted {
                break;
            }
            for v in next {
                *v /= length;
            }
        }
        let steps = columns.len();
        let mut weights = rhs[..steps].to_vec();
        for i in (0..steps).rev() {
            weights[i] /= columns[i][i];
            for j in 0..i {
                weights[j] -= columns[i][j] * weights[i];
            }
        }
        let report = KrylovReport {
            steps,
            residual: rhs[steps].abs(),
        };
        (report, weights)
    }
}

/// Takes the parts along the orthonormal `basis` out of `vector`, and returns them.
fn project(basis: &[Vec<f64>], vector: &mut [f64]) -> Vec<f64> {
    let mut parts = vec![0.0; basis.len()];
    wide(
        #[inline(always)]
        || {
            for (k, chunk) in vector.chunks(CHUNK).enumerate() {
                for (part, v) in parts.iter_mut().zip(basis) {
                    *part += plain_dot(&v[k * CHUNK..][..chunk.len()], chunk);
                }
            }
            for (k, chunk) in vector.chunks_mut(CHUNK).enumerate() {
                for (part, v) in parts.iter().zip(basis) {
                    add(chunk, -part, &v[k * CHUNK..][..chunk.len()]);
                }
            }
        },
    );
    parts
}

/// `a . b` of two vectors of the same length.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    wide(
        #[inline(always)]
        || plain_dot(a, b),
    )
}

#[expect(
    clippy::inline_always,
    reason = "what is not inlined keeps its narrow instructions"
)]
#[inline(always)]
fn plain_dot(a: &[f64], b: &[f64]) -> f64 {
    // eight sums, so that the products need not wait for each other
    let mut sums = [0.0; 8];
    let (eights, others) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest = eights.remainder().iter().zip(others.remainder());
    let rest: f64 = rest.map(|(a, b)| a * b).sum();
    for (a, b) in eights.zip(others) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    rest + sums.iter().sum::<f64>()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Adds `scale` times `x` to `y`.
pub fn add_scaled(y: &mut [f64], scale: f64, x: &[f64]) {
    wide(
        #[inline(always)]
        || add(y, scale, x),
    );
}

#[expect(
    clippy::inline_always,
    reason = "what is not inlined keeps its narrow instructions"
)]
#[inline(always)]
fn add(y: &mut [f64], scale: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += scale * x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_nonsymmetric_system_from_any_start() {
        let n = 12;
        let entry = |i: usize, j: usize| {
            if i == j {
                4.0 + i as f64
            } else {
                ((3 * i + 5 * j) % 7) as f64 / 7.0 - 0.4
            }
        };
        let multiply = |v: &[f64], out: &mut [f64]| {
            for i in 0..n {
                out[i] = (0..n).map(|j| entry(i, j) * v[j]).sum();
            }
        };
        let exact: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
        let mut rhs = vec![0.0; n];
        multiply(&exact, &mut rhs);
        for start in [0.0, 3.0] {
            let mut x = vec![start; n];
            let mut residual = vec![0.0; n];
            multiply(&x, &mut residual);
            residual.iter_mut().zip(&rhs).for_each(|(r, b)| *r = b - *r);
            let jacobi = |v: &[f64], out: &mut [f64]| {
                for i in 0..n {
                    out[i] = v[i] / entry(i, i);
                }
            };
            let report = gmres(multiply, jacobi, &mut x, &mut residual, 1e-12, 50);
            assert!(report.steps <= n && report.residual <= 1e-12, "{report:?}");
            for (x, e) in x.iter().zip(&exact) {
                assert!((x - e).abs() < 1e-12);
            }
        }
    }

    /// Numbers of all sizes without an order.
    fn numbers(n: usize, seed: f64) -> Vec<f64> {
        let value = |k: usize| (seed + 1.7 * k as f64).sin() * (1.0 + k as f64).ln();
        (0..n).map(value).collect()
    }

    #[test]
    fn the_widest_instructions_give_what_any_processor_gives() {
        for n in [0, 1, 7, 8, 1023, 1024, 1025, 3000] {
            let (a, b) = (numbers(n, 0.3), numbers(n, 2.0));
            assert_eq!(dot(&a, &b).to_bits(), plain_dot(&a, &b).to_bits());
            let (mut by_wide, mut by_any) = (a.clone(), a);
            add_scaled(&mut by_wide, 0.7, &b);
            add(&mut by_any, 0.7, &b);
            assert_eq!(by_wide, by_any);
        }
    }

    #[test]
    fn memory_of_other_solves_changes_nothing() {
        let mut used = Krylov::default();
        for n in [30, 12, 40] {
            let diagonal: Vec<f64> = (0..n).map(|i| 1.0 + (i % 6) as f64).collect();
            let multiply = |v: &[f64], out: &mut [f64]| {
                for i in 0..n {
                    out[i] = diagonal[i] * v[i] + 0.3 * v[(i + 1) % n];
                }
            };
            let copy = |v: &[f64], out: &mut [f64]| out.copy_from_slice(v);
            let rhs = numbers(n, 1.0);
            let (mut x, mut y) = (vec![0.0; n], vec![0.0; n]);
            let again = used.gmres(multiply, copy, &mut x, &mut rhs.clone(), 1e-12, 50);
            let anew = gmres(multiply, copy, &mut y, &mut rhs.clone(), 1e-12, 50);
            assert_eq!((again, x), (anew, y));
        }
    }

    #[test]
    fn stops_at_the_limit_and_at_a_solved_start() {
        let identity = |v: &[f64], out: &mut [f64]| out.copy_from_slice(v);
        let shift = |v: &[f64], out: &mut [f64]| {
            out.copy_from_slice(v);
            out.rotate_right(1);
        };
        let mut residual = vec![1.0, 0.0, 0.0, 0.0];
        let mut x = vec![0.0; 4];
        let report = gmres(shift, identity, &mut x, &mut residual, 1e-12, 2);
        assert_eq!(report.steps, 2);
        assert!(report.residual > 0.5);
        let report = gmres(shift, identity, &mut x, &mut [0.0; 4], 1e-12, 2);
        assert_eq!(
            report,
            KrylovReport {
                steps: 0,
                residual: 0.0
            }
        );
    }
}

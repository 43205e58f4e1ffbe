// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a solution exist? Cheap answers before and beside the solution.

use faer::{Mat, Side};
use mtb_operator::dense::Cholesky;
use mtb_operator::{Monitor, report, reset_workers};

use super::dense::columns;
use crate::error::{Error, check};

/// Whether some `p >= 0` meets the balance `K^T p = f` (`balance`: m columns of length n, column-major).
///
/// For a force and two moments: whether the resultant lies inside the hull of the contact points.
/// Decided by non-negative least squares [Lawson1974, chapter 23] on the m rows.
pub fn reachable(balance: &[f64], target: &[f64]) -> bool {
    let m = target.len();
    if m == 0 {
        return true;
    }
    let n = balance.len() / m;
    // rows scaled to size 1, so that newtons and newton metres weigh the same
    let row_scale: Vec<f64> = (0..m)
        .map(|i| {
            let row = &balance[i * n..(i + 1) * n];
            row.iter().fold(0.0_f64, |s, k| s.max(k.abs()))
        })
        .collect();
    if (0..m).any(|i| row_scale[i] == 0.0 && target[i] != 0.0) {
        return false;
    }
    let row = |i: usize, j: usize| {
        if row_scale[i] > 0.0 {
            balance[i * n + j] / row_scale[i]
        } else {
            0.0
        }
    };
    let f: Vec<f64> = (0..m)
        .map(|i| {
            if row_scale[i] > 0.0 {
                target[i] / row_scale[i]
            } else {
                0.0
            }
        })
        .collect();
    let size = f.iter().fold(0.0_f64, |s, v| s.max(v.abs()));
    if size == 0.0 {
        return true;
    }
    let f: Vec<f64> = f.iter().map(|v| v / size).collect();
    let mut support: Vec<usize> = Vec::new();
    let mut p = vec![0.0; n];
    let remainder = |p: &[f64], support: &[usize]| -> Vec<f64> {
        (0..m)
            .map(|i| f[i] - support.iter().map(|&j| row(i, j) * p[j]).sum::<f64>())
            .collect()
    };
    for _ in 0..20 * m + n {
        let r = remainder(&p, &support);
        if r.iter().all(|v| v.abs() < 1e-10) {
            return true;
        }
        let gain = |j: usize| (0..m).map(|i| row(i, j) * r[i]).sum::<f64>();
        let best = (0..n)
            .filter(|j| !support.contains(j))
            .map(|j| (j, gain(j)))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((enter, gain)) = best else {
            return false;
        };
        if gain <= 1e-12 {
            return false;
        }
        support.push(enter);
        loop {
            let k = support.len();
            let matrix = Mat::from_fn(m, k, |i, j| row(i, support[j]));
            let rhs = Mat::from_fn(m, 1, |i, _| f[i]);
            let Ok(svd) = matrix.thin_svd() else {
                return false;
            };
            let z = svd.pseudoinverse() * rhs;
            let step = (0..k)
                .filter(|&j| z[(j, 0)] <= 0.0)
                .map(|j| p[support[j]] / (p[support[j]] - z[(j, 0)]))
                .fold(1.0_f64, f64::min);
            for j in 0..k {
                let s = support[j];
                p[s] += step * (z[(j, 0)] - p[s]);
            }
            if step >= 1.0 {
                break;
            }
            let before = support.len();
            support.retain(|&j| p[j] > 1e-14);
            for (j, value) in p.iter_mut().enumerate() {
                if !support.contains(&j) {
                    *value = 0.0;
                }
            }
            if support.is_empty() || support.len() == before {
                break;
            }
        }
    }
    false
}

/// Whether some `0 <= p <= limit` meets the balance, as [`reachable`] tells of `p >= 0`.
///
/// Decided by least squares between bounds [StarkParker1995]: a point that would carry more than its limit is held
/// there, one that would pull is left out, and the others share what remains.
pub fn reachable_within(balance: &[f64], target: &[f64], limit: &[f64]) -> bool {
    let (m, n) = (target.len(), limit.len());
    // rows scaled by what all points together carry, columns by the limits
    let rows: Vec<Vec<f64>> = (0..m)
        .map(|i| {
            let row = balance[i * n..(i + 1) * n].iter().zip(limit);
            row.map(|(k, l)| k * l).collect()
        })
        .collect();
    let scale: Vec<f64> = rows
        .iter()
        .map(|row| row.iter().map(|k| k.abs()).sum())
        .collect();
    if (0..m).any(|i| scale[i] == 0.0 && target[i] != 0.0) {
        return false;
    }
    let kept: Vec<usize> = (0..m).filter(|&i| scale[i] > 0.0).collect();
    let entry = |i: usize, j: usize| rows[kept[i]][j] / scale[kept[i]];
    let f: Vec<f64> = kept.iter().map(|&i| target[i] / scale[i]).collect();
    let size = f.iter().fold(0.0_f64, |s, v| s.max(v.abs()));
    let m = kept.len();
    let mut x = vec![0.0; n];
    let mut free: Vec<usize> = Vec::new();
    for _ in 0..4 * n + 20 * m {
        let rest: Vec<f64> = (0..m)
            .map(|i| f[i] - (0..n).map(|j| entry(i, j) * x[j]).sum::<f64>())
            .collect();
        if rest.iter().all(|v| v.abs() <= 1e-10 * size) {
            return true;
        }
        let gain = |j: usize| (0..m).map(|i| entry(i, j) * rest[i]).sum::<f64>();
        let wanted = |j: usize| if x[j] >= 1.0 { -gain(j) } else { gain(j) };
        let outside = (0..n).filter(|j| !free.contains(j));
        let best = outside
            .map(|j| (j, wanted(j)))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((enter, _)) = best.filter(|(_, gain)| *gain > 1e-14 * size) else {
            return false;
        };
        free.push(enter);
        while !free.is_empty() {
            let k = free.len();
            let matrix = Mat::from_fn(m, k, |i, j| entry(i, free[j]));
            let right = Mat::from_fn(m, 1, |i, _| rest_without(&f, &x, &free, |j| entry(i, j), i));
            let Ok(svd) = matrix.thin_svd() else {
                return false;
            };
            let there = svd.pseudoinverse() * right;
            let step = (0..k)
                .map(|j| {
                    let (now, then) = (x[free[j]], there[(j, 0)]);
                    if then > 1.0 {
                        (1.0 - now) / (then - now)
                    } else if then < 0.0 {
                        now / (now - then)
                    } else {
                        1.0
                    }
                })
                .fold(1.0_f64, f64::min);
            for j in 0..k {
                let now = x[free[j]];
                x[free[j]] = (now + step * (there[(j, 0)] - now)).clamp(0.0, 1.0);
            }
            if step >= 1.0 {
                break;
            }
            // what reached its bound stays there
            for j in 0..k {
                let value = &mut x[free[j]];
                if *value < 1e-13 {
                    *value = 0.0;
                } else if *value > 1.0 - 1e-13 {
                    *value = 1.0;
                }
            }
            let before = free.len();
            free.retain(|&j| x[j] > 0.0 && x[j] < 1.0);
            if free.len() == before {
                break;
            }
        }
    }
    true
}

/// What the points that are not free leave of row `i`.
fn rest_without(
    f: &[f64],
    x: &[f64],
    free: &[usize],
    entry: impl Fn(usize) -> f64,
    i: usize,
) -> f64 {
    let held = (0..x.len()).filter(|j| x[*j] != 0.0 && !free.contains(j));
    f[i] - held.map(|j| entry(j) * x[j]).sum::<f64>()
}

/// Largest `mu` up to which `A_n + mu A_t` stays positive definite: `1 / lambda_max(-A_n^-1 sym(A_t))`.
///
/// Below it the complementarity problem has exactly one solution for every load. `normal` (symmetric
/// positive definite) and `coupling` are n x n, row-major; `weights` (n) make `normal` symmetric:
/// both are understood as `W A`. `fixed` are m columns of length n (column-major) of balances that a change
/// of the pressure must not touch, [`None`] where motions are prescribed. Returns infinity where
/// no `mu` destroys definiteness. By Lanczos steps on the Cholesky factor of `A_n`.
///
/// # Errors
/// Wrong lengths, numbers that are not finite, an interruption by the monitor.
pub fn definiteness_limit(
    normal: &[f64],
    coupling: &[f64],
    weights: &[f64],
    fixed: Option<&[f64]>,
    monitor: Monitor<'_>,
) -> Result<f64, Error> {
    let n = weights.len();
    check("weights", weights, n)?;
    check("normal", normal, n * n)?;
    check("coupling", coupling, n * n)?;
    let a = columns(n, monitor, |j, column| {
        for (i, a) in column.iter_mut().enumerate() {
            *a = 0.5 * (weights[i] * normal[i * n + j] + weights[j] * normal[j * n + i]);
        }
    })?;
    let Some(llt) = Cholesky::new(a, faer::get_global_parallelism(), monitor)? else {
        return Ok(0.0);
    };
    let constraints = orthonormal_constraints(&llt, fixed.unwrap_or(&[]), n);
    reset_workers();
    let project = |v: &mut Mat<f64>| {
        if let Some(q) = &constraints {
            let c = q.transpose() * &*v;
            *v -= q * c;
        }
    };
    let l = llt.lower();
    let apply = |v: &Mat<f64>| -> Mat<f64> {
        let mut x = v.clone();
        faer::linalg::triangular_solve::solve_upper_triangular_in_place(
            l.transpose(),
            x.as_mut(),
            faer::get_global_parallelism(),
        );
        let mut y = Mat::zeros(n, 1);
        for i in 0..n {
            let row = &coupling[i * n..(i + 1) * n];
            let mut sum = 0.0;
            for (j, c) in row.iter().enumerate() {
                sum += c * x[(j, 0)];
                y[(j, 0)] -= 0.5 * weights[i] * c * x[(i, 0)];
            }
            y[(i, 0)] -= 0.5 * weights[i] * sum;
        }
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(
            l,
            y.as_mut(),
            faer::get_global_parallelism(),
        );
        project(&mut y);
        y
    };
    // a start without structure, the same on every run
    let mut seed = 0x9E37_79B9_7F4A_7C15_u64;
    let mut v = Mat::from_fn(n, 1, |_, _| {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        seed as f64 / u64::MAX as f64 - 0.5
    });
    project(&mut v);
    let norm = v.norm_l2();
    if norm == 0.0 {
        return Ok(f64::INFINITY);
    }
    v /= faer::Scale(norm);
    let mut basis = vec![v];
    let (mut alpha, mut beta): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    let mut largest = f64::NEG_INFINITY;
    for step in 0..n.min(80) {
        report(monitor, step, f64::NAN)?;
        let mut w = apply(&basis[step]);
        alpha.push((basis[step].transpose() * &w)[(0, 0)]);
        // full orthogonalisation: the basis is short
        for _ in 0..2 {
            for q in &basis {
                let overlap = (q.transpose() * &w)[(0, 0)];
                w -= q * faer::Scale(overlap);
            }
        }
        let k = alpha.len();
        let tridiagonal = Mat::from_fn(k, k, |i, j| match i.abs_diff(j) {
            0 => alpha[i],
            1 => beta[i.min(j)],
            _ => 0.0,
        });
        let Ok(values) = tridiagonal.self_adjoint_eigenvalues(Side::Lower) else {
            break;
        };
        let now = values.last().copied().unwrap_or(0.0);
        let settled = (now - largest).abs() <= 1e-8 * now.abs();
        largest = now;
        let norm = w.norm_l2();
        if (settled && step > 5) || norm <= 1e-14 * now.abs() {
            break;
        }
        beta.push(norm);
        basis.push(w * faer::Scale(1.0 / norm));
    }
    Ok(if largest > 0.0 {
        1.0 / largest
    } else {
        f64::INFINITY
    })
}

/// Orthonormal basis of the constraints in the coordinates `L^T p`.
fn orthonormal_constraints(llt: &Cholesky, fixed: &[f64], n: usize) -> Option<Mat<f64>> {
    let m = fixed.len() / n.max(1);
    if m == 0 {
        return None;
    }
    let mut k = Mat::from_fn(n, m, |i, j| fixed[j * n + i]);
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(
        llt.lower(),
        k.as_mut(),
        faer::get_global_parallelism(),
    );
    Some(k.qr().compute_thin_Q())
}

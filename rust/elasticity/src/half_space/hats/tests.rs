// SPDX-License-Identifier: MIT OR Apache-2.0
use super::*;
use crate::half_space::influence;
use Component::{Normal, X, Y};

const STEEL: Material = Material {
    shear_modulus: 80e9,
    poisson_ratio: 0.3,
};

fn body(patches: &[(f64, f64, usize, usize)]) -> Result<HatHalfSpace, Error> {
    let patches: Result<Vec<Patch>, Error> = patches
        .iter()
        .map(|&(x0, y0, nx, ny)| {
            Ok(Patch {
                x0,
                y0,
                grid: Grid::new(nx, ny, 3e-3, 2e-3)?,
            })
        })
        .collect();
    HatHalfSpace::new(STEEL, patches?, Neighbours::Interact)
}

/// Every rectangle of every hat on every other one, without any structure.
fn by_force(body: &HatHalfSpace, m: usize, observed: Component, loaded: Component) -> Vec<f64> {
    let mut hats = Vec::new();
    for patch in &body.patches {
        let Grid { nx, ny, dx, dy } = patch.grid;
        for node in 0..nx * ny {
            let (i, j) = ((node % nx) as f64, (node / nx) as f64);
            let mut parts = Vec::new();
            for l in 0..(ny - 1) * m {
                for k in 0..(nx - 1) * m {
                    let (x, y) = ((k as f64 + 0.5) / m as f64, (l as f64 + 0.5) / m as f64);
                    let value = (1.0 - (x - i).abs()).max(0.0) * (1.0 - (y - j).abs()).max(0.0);
                    if value > 0.0 {
                        parts.push((patch.x0 + x * dx, patch.y0 + y * dy, value));
                    }
                }
            }
            hats.push(parts);
        }
    }
    let Grid { dx, dy, .. } = body.patches[0].grid;
    let part = [dx / m as f64, dy / m as f64];
    let mut matrix = Vec::new();
    for (a, w) in hats.iter().zip(body.weights()) {
        for b in &hats {
            let mut sum = 0.0;
            for (x, y, v) in a {
                for (xs, ys, vs) in b {
                    let offset = [x - xs, y - ys];
                    sum += v * vs * influence(&STEEL, observed, loaded, offset, part);
                }
            }
            matrix.push(sum * part[0] * part[1] / w);
        }
    }
    matrix
}

#[test]
fn sums_over_ever_finer_rectangles_tend_to_it() -> Result<(), Error> {
    let body = body(&[(0.0, 0.0, 3, 2), (1.1e-3, 7.3e-3, 2, 3)])?;
    for observed in [X, Y, Normal] {
        for loaded in [X, Y, Normal] {
            let block = body.block(observed, loaded);
            let scale = body.block(Normal, Normal)[0];
            let error = |m: usize| {
                by_force(&body, m, observed, loaded)
                    .iter()
                    .zip(block)
                    .fold(0.0, |s: f64, (a, b)| s.max((a - b).abs()))
                    / scale
            };
            let (coarse, fine) = (error(3), error(9));
            assert!(fine < 1e-2, "{observed:?} {loaded:?}: {fine:e}");
            let rate = (coarse / fine).ln() / 3f64.ln();
            assert!(rate > 1.5, "{observed:?} {loaded:?}: rate {rate}");
        }
    }
    Ok(())
}

#[test]
fn symmetric_in_the_weighted_product() -> Result<(), Error> {
    let body = body(&[(0.0, 0.0, 4, 3), (-2e-3, 11.7e-3, 3, 3)])?;
    let (n, w) = (body.points(), body.weights());
    for a in [X, Y, Normal] {
        for b in [X, Y, Normal] {
            let (there, back) = (body.block(a, b), body.block(b, a));
            let scale = body.block(Normal, Normal)[0] * w[0];
            for i in 0..n {
                for j in 0..n {
                    let error = w[i] * there[i * n + j] - w[j] * back[j * n + i];
                    assert!(
                        error.abs() < 1e-13 * scale,
                        "{a:?} {b:?} {i} {j}: {:e}",
                        error / scale
                    );
                }
            }
        }
    }
    Ok(())
}

#[test]
fn uniform_pressure_is_one_rectangle() -> Result<(), Error> {
    // the hats add up to one; the mean of the closed form over a hat by a fine midpoint rule
    let body = body(&[(0.0, 0.0, 9, 7)])?;
    let whole = [8.0 * 3e-3, 6.0 * 2e-3];
    for (observed, loaded) in [(Normal, Normal), (X, X), (Y, Y), (Normal, Y), (X, Y)] {
        let mut u = vec![0.0; 63];
        body.add_displacement(observed, loaded, 1.0, &[1.0; 63], &mut u);
        let centre = influence(&STEEL, Normal, Normal, [0.0, 0.0], whole);
        for (i, j) in [(4, 3), (2, 4), (6, 1)] {
            let (mut sum, mut area) = (0.0, 0.0);
            for k in -39..40 {
                for l in -39..40 {
                    let (s, t) = (f64::from(k) / 40.0, f64::from(l) / 40.0);
                    let phi = (1.0 - s.abs()) * (1.0 - t.abs());
                    let x = (i as f64 - 4.0 + s) * 3e-3;
                    let y = (j as f64 - 3.0 + t) * 2e-3;
                    sum += phi * influence(&STEEL, observed, loaded, [x, y], whole);
                    area += phi;
                }
            }
            let error = (u[j * 9 + i] - sum / area).abs();
            assert!(
                error < 1e-4 * centre,
                "{observed:?} {loaded:?} {i} {j}: {error:e}"
            );
        }
    }
    Ok(())
}

#[test]
fn quadrature_is_accurate_at_the_singular_point() {
    // moments of order zero are the closed form; also for thin cells and near misses
    for cell in [[1.0, 1.0], [3.0, 2.0], [1.0, 7.0]] {
        for start in [
            [0.0, 0.0],
            [-1.0, -2.0],
            [-0.3, -0.9],
            [1e-7, 0.2],
            [0.0, -0.5],
            [2.0, 3.0],
            [9.0, 1.0],
        ] {
            for (a, b) in [(Normal, Normal), (Normal, X), (X, X), (X, Y), (Y, Y)] {
                let kernel = |x: f64, y: f64| point_load(&STEEL, a, b, [x, y]);
                let value = moments(&kernel, start, cell)[0][0];
                let centre = [start[0] + 0.5 * cell[0], start[1] + 0.5 * cell[1]];
                let exact = influence(&STEEL, a, b, centre, cell);
                let scale = influence(&STEEL, Normal, Normal, centre, cell);
                let error = (value - exact).abs() / scale;
                assert!(error < 2e-8, "{cell:?} {start:?} {a:?} {b:?}: {error:e}");
            }
        }
    }
}

#[test]
fn a_patch_without_cells_is_refused() {
    assert!(matches!(
        body(&[(0.0, 0.0, 1, 3)]),
        Err(Error::NoCell { patch: 0, .. })
    ));
}

/// The basis of a grid of nodes on its cells up to a column and a row, by two Gauss points in each third.
fn sampling(
    nx: usize,
    ny: usize,
    covered: [usize; 2],
    cell: [f64; 2],
) -> Result<crate::tetra::Sampling, Error> {
    let gauss = 0.5 / 3f64.sqrt();
    let places: Vec<f64> = (0..3)
        .flat_map(|k| [0.5 - gauss, 0.5 + gauss].map(|g| (f64::from(k) + g) / 3.0))
        .collect();
    let (mut quadrature, mut basis) = (Vec::new(), Vec::new());
    for corner in (0..nx * ny).filter(|c| c % nx < covered[0] && c / nx < covered[1]) {
        for b in &places {
            for a in &places {
                quadrature.push(crate::tetra::SurfacePoint {
                    face: 0,
                    barycentric: [1.0, 0.0, 0.0],
                    weight: cell[0] * cell[1] / 36.0,
                    frame: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                });
                basis.extend([
                    (corner, (1.0 - a) * (1.0 - b)),
                    (corner + 1, a * (1.0 - b)),
                    (corner + nx, (1.0 - a) * b),
                    (corner + nx + 1, a * b),
                ]);
            }
        }
    }
    let start = (0..=quadrature.len()).map(|q| 4 * q).collect();
    crate::tetra::Sampling::new(nx * ny, quadrature, start, basis)
}

#[test]
fn hats_cut_along_grid_lines_are_those_of_a_smaller_grid() -> Result<(), Error> {
    let (nx, ny, cells) = (14, 5, [11, 3]);
    let exact = body(&[(0.0, 0.0, cells[0] + 1, cells[1] + 1)])?;
    let kept: Vec<usize> = (0..nx * ny)
        .filter(|k| k % nx <= cells[0] && k / nx <= cells[1])
        .collect();
    let basis = sampling(nx, ny, cells, [3e-3, 2e-3])?;
    let cut = CutHats::new(
        body(&[(0.0, 0.0, nx, ny)])?,
        &[&basis],
        &shares(0, &kept),
        kept.len(),
    )?;
    let (n, w) = (cut.points(), exact.weights());
    let scale = exact.block(Normal, Normal)[0];
    let uniform: f64 = exact.block(Normal, Normal)[..n].iter().sum();
    for a in [X, Y, Normal] {
        for b in [X, Y, Normal] {
            let (found, back) = (cut.block(a, b), cut.block(b, a));
            let expected = exact.block(a, b);
            for (i, (row, expected)) in found.chunks(n).zip(expected.chunks(n)).enumerate() {
                let errors = row.iter().zip(expected).map(|(a, b)| a - b);
                let worst = errors.clone().fold(0.0, |s: f64, e| s.max(e.abs()));
                assert!(worst < 1e-2 * scale, "{a:?} {b:?} {i}: {:e}", worst / scale);
                // what a uniform traction moves
                let sum: f64 = errors.sum();
                assert!(
                    sum.abs() < 2e-3 * uniform,
                    "{a:?} {b:?} {i}: {:e}",
                    sum / uniform
                );
            }
            for i in 0..n {
                for j in 0..n {
                    let error = w[i] * found[i * n + j] - w[j] * back[j * n + i];
                    assert!(error.abs() < 1e-12 * scale * w[0], "{a:?} {b:?} {i} {j}");
                }
            }
        }
    }
    Ok(())
}

/// Each of the nodes `kept` a contact point.
fn shares(face: usize, kept: &[usize]) -> Vec<HatShare> {
    let share = |(point, &node)| HatShare {
        face,
        node,
        point,
        factor: 1.0,
    };
    kept.iter().enumerate().map(share).collect()
}

/// A face in two parts whose hats are put together again, and one whose last nodes are given to those before.
#[test]
fn contact_points_of_several_hats_add_them_up() -> Result<(), Error> {
    let (nx, ny) = (6, 3);
    let all: Vec<usize> = (0..nx * ny).collect();
    let whole = sampling(nx, ny, [5, 2], [3e-3, 2e-3])?;
    let grid = || body(&[(0.0, 0.0, nx, ny)]);
    let n = all.len();
    let one = CutHats::new(grid()?, &[&whole], &shares(0, &all), n)?;
    let left = sampling(nx, ny, [2, 2], [3e-3, 2e-3])?;
    let right = {
        let (mut quadrature, mut basis) = (Vec::new(), Vec::new());
        for (q, point) in whole.quadrature().iter().enumerate() {
            if whole.basis(q)[0].0 % nx >= 2 {
                quadrature.push(*point);
                basis.extend_from_slice(whole.basis(q));
            }
        }
        let start = (0..=quadrature.len()).map(|q| 4 * q).collect();
        crate::tetra::Sampling::new(n, quadrature, start, basis)?
    };
    let both = [shares(0, &all), shares(1, &all)].concat();
    let two = CutHats::new(grid()?, &[&left, &right], &both, n)?;
    // the last column belongs to the one before it
    let merged: Vec<HatShare> = all
        .iter()
        .map(|&node| HatShare {
            face: 0,
            node,
            point: node / nx * (nx - 1) + (node % nx).min(nx - 2),
            factor: 1.0,
        })
        .collect();
    let m = (nx - 1) * ny;
    let fewer = CutHats::new(grid()?, &[&whole], &merged, m)?;
    for (a, b) in [(Normal, Normal), (X, Y), (X, Normal)] {
        let (expected, found) = (one.block(a, b), two.block(a, b));
        let scale = one.block(a, a).iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        for (k, (e, f)) in expected.iter().zip(found).enumerate() {
            assert!((e - f).abs() < 1e-2 * scale, "{a:?} {b:?} {k}: {e} {f}");
        }
        // what the same pressure everywhere moves
        let uniform = |body: &CutHats, row: usize| -> f64 {
            body.block(a, b)[row * body.points()..(row + 1) * body.points()]
                .iter()
                .sum()
        };
        for row in 0..ny {
            let (e, f) = (uniform(&one, row * nx), uniform(&fewer, row * (nx - 1)));
            assert!((e - f).abs() < 1e-9 * scale, "{a:?} {b:?} {row}: {e} {f}");
        }
    }
    Ok(())
}

#[test]
fn cut_hats_of_another_grid_are_refused() -> Result<(), Error> {
    let basis = sampling(4, 4, [3, 3], [3e-3, 2e-3])?;
    assert!(matches!(
        CutHats::new(body(&[(0.0, 0.0, 5, 4)])?, &[&basis], &shares(0, &[0]), 1),
        Err(Error::Shape { .. })
    ));
    let grid = || body(&[(0.0, 0.0, 4, 4)]);
    for (share, points) in [
        (shares(0, &[16]), 1),
        (shares(1, &[0]), 1),
        (shares(0, &[0, 1]), 1),
    ] {
        assert!(matches!(
            CutHats::new(grid()?, &[&basis], &share, points),
            Err(Error::Index { .. })
        ));
    }
    Ok(())
}

#[test]
fn products_of_many_points_are_those_of_the_matrix() {
    // the second patch lies beside the first one and has fewer columns
    let body = body(&[(0.0, 0.0, 50, 24), (7e-3, 60e-3, 43, 22)]).expect("valid");
    let n = body.points();
    assert!(n > DENSE_POINTS);
    let traction: Vec<f64> = (0..n)
        .map(|i| ((i * i + 3 * i) % 17) as f64 - 7.0)
        .collect();
    for (observed, loaded) in [(Normal, Normal), (Normal, X), (Y, Normal), (X, Y), (Y, Y)] {
        let mut moved = vec![1.0; n];
        body.add_displacement(observed, loaded, 2.0, &traction, &mut moved);
        let matrix = body.matrix(observed, loaded);
        let mut expected = vec![1.0; n];
        add_product(&matrix, 2.0, &traction, &mut expected);
        let scale = expected.iter().fold(0.0_f64, |m, u| m.max((u - 1.0).abs()));
        for (u, e) in moved.iter().zip(&expected) {
            assert!(
                (u - e).abs() < 1e-11 * scale,
                "{observed:?} {loaded:?}: {u} {e}"
            );
        }
    }
    let incompressible = HatHalfSpace::new(
        Material::new(1e9, 0.5).expect("valid"),
        body.patches.clone(),
        Neighbours::Separate,
    )
    .expect("valid");
    let mut moved = vec![0.0; n];
    incompressible.add_displacement(Normal, X, 1.0, &traction, &mut moved);
    assert!(moved.iter().all(|u| *u == 0.0));
}

/// A wave of pressures `cos qx` moves the surface by `(1 - nu) / (G q) cos qx` [Johnson1985, 13.2], and by more where
/// points give way by themselves besides. The near inverse finds these pressures from the displacements, away from the
/// edges of the patch and with an error of second order in the cells of a wave.
#[test]
fn the_near_inverse_of_a_wave_is_its_pressure() -> Result<(), Error> {
    let (n, step) = (96, 3e-3);
    let body = body(&[(0.0, 0.0, n, n)])?;
    let material = body.material;
    let error = |cells: f64, softer: f64| {
        let q = 2.0 * std::f64::consts::PI / (cells * step);
        let own = (1.0 - material.poisson_ratio) / (material.shear_modulus * q);
        let middle = 0.5 * (n - 1) as f64;
        let wave: Vec<f64> = (0..n * n)
            .map(|k| (q * step * ((k % n) as f64 - middle)).cos())
            .collect();
        let softer = softer * own;
        let invert = body.near_inverse(softer).expect("a regular grid");
        let mut pressure = vec![0.0; n * n];
        invert(&wave, &mut pressure);
        let at = n / 2 * n + n / 2;
        (pressure[at] / wave[at] * (own + softer) - 1.0).abs()
    };
    for softer in [0.0, 3.0] {
        let [coarse, fine] = [16.0, 32.0].map(|cells| error(cells, softer));
        assert!(coarse < 0.03 && 3.0 * fine < coarse, "{coarse} {fine}");
    }
    Ok(())
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use super::*;
use mtb_operator::unmonitored;

/// Points of a unit grid, moved by at most `shake` in each direction, on their cells.
fn grid(nx: usize, ny: usize, s: f64, shake: f64) -> Result<GaussianBasis, Error> {
    let moved = |k: usize| shake * (((37 * k + 11) % 23) as f64 / 11.0 - 1.0);
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for k in 0..nx * ny {
        x.push((k % nx) as f64 + moved(k));
        y.push((k / nx) as f64 + moved(3 * k + 1));
    }
    GaussianBasis::new(&x, &y, s, [-0.5, nx as f64 - 0.5, -0.5, ny as f64 - 0.5])
}

fn closed_form(x: f64, y: f64, domain: [f64; 4]) -> [f64; 5] {
    use crate::{Material, half_space::influence};
    use mtb_operator::Component::{Normal, X, Y};
    let [x0, x1, y0, y1] = domain;
    let offset = [x - 0.5 * (x0 + x1), y - 0.5 * (y0 + y1)];
    let cell = [x1 - x0, y1 - y0];
    let at = |nu: f64, a, b| {
        let material = Material {
            shear_modulus: 0.5 / std::f64::consts::PI,
            poisson_ratio: nu,
        };
        influence(&material, a, b, offset, cell)
    };
    [
        at(0.0, Normal, Normal),
        2.0 * (at(0.5, X, X) - 0.5 * at(0.0, Normal, Normal)),
        2.0 * at(0.5, X, Y),
        2.0 * at(0.0, Normal, X),
        2.0 * at(0.0, Normal, Y),
    ]
}

#[test]
fn functions_are_a_partition_of_unity() -> Result<(), Error> {
    let basis = grid(9, 7, 0.4, 0.2)?;
    let mut values = Vec::new();
    for k in 0..500 {
        let (x, y) = (
            -0.5 + f64::from(k) * 0.018,
            6.5 - f64::from(k * k % 500) * 0.014,
        );
        basis.values(x, y, &mut values);
        let sum: f64 = values.iter().map(|v| v.1).sum();
        assert!((sum - 1.0).abs() < 1e-14 && values.iter().all(|v| v.1 >= 0.0));
    }
    Ok(())
}

#[test]
fn all_functions_together_are_the_uniform_load() -> Result<(), Error> {
    for (s, shake) in [(0.25, 0.0), (0.35, 0.0), (0.5, 0.0), (0.4, 0.2)] {
        let basis = grid(11, 9, s, shake)?;
        let (integrals, total) = basis.integrals(&unmonitored)?;
        let area: f64 = total.iter().sum();
        assert!((area / 99.0 - 1.0).abs() < 1e-12);
        let n = basis.len();
        for i in 0..n {
            let exact = closed_form(basis.x[i], basis.y[i], basis.domain);
            for (matrix, exact_k) in [
                &integrals.inverse,
                &integrals.xx,
                &integrals.xy,
                &integrals.x,
                &integrals.y,
            ]
            .into_iter()
            .zip(exact)
            {
                let sum: f64 = matrix[i * n..(i + 1) * n].iter().sum();
                assert!(
                    (sum - exact_k).abs() < 2e-6 * exact[0],
                    "{s} {shake} {i}: {sum} {exact_k}"
                );
            }
        }
    }
    Ok(())
}

#[test]
fn coefficients_are_accurate_near_and_far() -> Result<(), Error> {
    for (s, shake) in [(0.25, 0.0), (0.35, 0.0), (0.5, 0.0), (0.4, 0.15)] {
        let basis = grid(12, 12, s, shake)?;
        let mut fine = basis.clone();
        fine.panel *= 0.4;
        let moments = basis.moments();
        for i in [0, 5, 66] {
            let row = basis.row(i, &moments);
            let mut exact = vec![[0.0; 5]; basis.len()];
            fine.add_near(i, &vec![true; basis.len()], 20.0, &mut exact);
            for (j, (value, exact)) in row.iter().zip(&exact).enumerate() {
                for k in 0..5 {
                    let error = (value[k] - exact[k]).abs();
                    assert!(
                        error < 1e-5 * exact[0],
                        "{s} {shake} {i} {j} {k}: {error:e}"
                    );
                }
            }
        }
    }
    Ok(())
}

#[test]
fn narrow_functions_are_rectangles() -> Result<(), Error> {
    // the steps between two functions are s^2 / h wide, so the difference falls with the fourth power
    let mut errors = Vec::new();
    for s in [0.3, 0.21] {
        let basis = grid(7, 7, s, 0.0)?;
        let row = basis.row(24, &basis.moments());
        let cell = closed_form(0.0, 0.0, [-0.5, 0.5, -0.5, 0.5]);
        errors.push((row[24][0] / cell[0] - 1.0).abs());
    }
    assert!(
        errors[1] < 0.011 && errors[0] / errors[1] > 3.5,
        "{errors:?}"
    );
    Ok(())
}

#[test]
fn bad_input_is_named() {
    let domain = [-1.0, 2.0, -1.0, 1.0];
    let make = |x: &[f64], s, domain| GaussianBasis::new(x, &vec![0.0; x.len()], s, domain);
    assert!(matches!(
        make(&[0.0, f64::NAN], 0.5, domain),
        Err(Error::NotFinite { index: 1, .. })
    ));
    assert!(matches!(
        make(&[0.0, 1.0], 0.0, domain),
        Err(Error::NotPositive { .. })
    ));
    assert!(matches!(
        make(&[0.0, 1.0], 0.05, domain),
        Err(Error::Uncovered { .. })
    ));
    assert!(matches!(
        make(&[0.0, 5.0], 0.5, domain),
        Err(Error::Outside { index: 1, .. })
    ));
    assert!(matches!(make(&[], 0.5, domain), Err(Error::Shape { .. })));
}

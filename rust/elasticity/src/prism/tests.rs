// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::{Compliance, Component, Grid, unmonitored};

use super::line::{bessel, distances, gauss, hat, pair, strip};
use super::rows::{Basis, edges_between, strip_loads};
use super::{Foot, Prism, PrismCompliance, Section, Strip};
use crate::half_space::{HatHalfSpace, Neighbours, Patch};
use crate::{Error, Material};
use Component::{Normal, X, Y};

const STEEL: Material = Material {
    shear_modulus: 80e9,
    poisson_ratio: 0.3,
};
const ALL: [Component; 3] = [X, Y, Normal];

/// A rectangle cut into triangles between rising lines, and the edges of its top.
fn rectangle(y: &[f64], z: &[f64]) -> (Section, Vec<[usize; 3]>) {
    let fine = |line: &[f64]| -> Vec<f64> {
        let mut out = vec![line[0]];
        for pair in line.windows(2) {
            out.extend([0.5 * (pair[0] + pair[1]), pair[1]]);
        }
        out
    };
    let (ys, zs) = (fine(y), fine(z));
    let nodes = ys.iter().flat_map(|y| zs.iter().map(move |z| [*y, *z]));
    let at = |i: usize, j: usize| i * zs.len() + j;
    let mut triangles = Vec::new();
    for i in (0..ys.len() - 1).step_by(2) {
        for j in (0..zs.len() - 1).step_by(2) {
            let middle = at(i + 1, j + 1);
            let [a, b, c, d] = [at(i, j), at(i + 2, j), at(i + 2, j + 2), at(i, j + 2)];
            triangles.push([a, b, c, at(i + 1, j), at(i + 2, j + 1), middle]);
            triangles.push([a, c, d, middle, at(i + 1, j + 2), at(i, j + 1)]);
        }
    }
    let side = |j: usize| {
        (0..ys.len() - 1)
            .step_by(2)
            .map(move |i| [at(i, j), at(i + 2, j), at(i + 1, j)])
            .collect()
    };
    let section = Section {
        nodes: nodes.collect(),
        triangles,
        base: side(0),
    };
    (section, side(zs.len() - 1))
}

/// Loads on unknowns, number and value, of each row.
type Rows = Vec<Vec<(usize, f64)>>;

fn strips_of(
    prism: &Prism,
    top: &[[usize; 3]],
    lines: &[f64],
    dy: f64,
) -> Result<[Rows; 3], Error> {
    strip_loads(prism, &edges_between(prism, top, lines)?, Basis::Cells, dy)
}

fn spaced(from: f64, to: f64, count: usize) -> Vec<f64> {
    (0..=count)
        .map(|k| from + (to - from) * k as f64 / count as f64)
        .collect()
}

/// Lines from the middle outwards that grow, about a fine strip.
fn graded(half: f64, fine: f64, count: usize, growth: f64) -> Vec<f64> {
    let mut side = spaced(0.0, fine, count);
    let mut step = fine / count as f64;
    while side[side.len() - 1] < half {
        step *= growth;
        let next = side[side.len() - 1] + step;
        side.push(if next > half - 0.5 * step { half } else { next });
    }
    let mut all: Vec<f64> = side[1..].iter().rev().map(|y| -y).collect();
    all.extend(side);
    all
}

#[test]
fn bessel_functions_are_those_of_the_tables() {
    // [AbramowitzStegun1972, table 9.8]
    for (z, k0, k1) in [
        (0.1, 2.427_069_024_702_017, 9.853_844_780_870_606),
        (1.0, 0.421_024_438_240_708_33, 0.601_907_230_197_234_6),
        (2.0, 0.113_893_872_749_533_44, 0.139_865_881_816_522_43),
        (10.0, 1.778_006_231_616_765e-5, 1.864_877_345_382_558_5e-5),
    ] {
        let found = bessel(z);
        assert!((found.0 / k0 - 1.0).abs() < 1e-10, "{z}: {found:?}");
        assert!((found.1 / k1 - 1.0).abs() < 1e-10, "{z}: {found:?}");
    }
    let (below, above) = (bessel(1.0), bessel(1.0 + 1e-12));
    assert!((below.0 - above.0).abs() < 1e-11 && (below.1 - above.1).abs() < 1e-11);
}

/// All waves of a half-space under two rows are the half-space itself, component by component.
#[test]
fn waves_on_a_half_space_add_up_to_its_closed_form() -> Result<(), Error> {
    let h = 2e-3;
    let grid = Grid::new(4, 4, h, h).map_err(Error::from)?;
    let patch = Patch {
        x0: 0.0,
        y0: 0.0,
        grid,
    };
    let body = HatHalfSpace::new(STEEL, vec![patch], Neighbours::Interact)?;
    // seen at point 2 of row 1, loaded at point 1 of row 3, the last one
    let observed = hat(Some(0.0), h, Some(2.0 * h));
    let load = hat(Some(2.0 * h), 3.0 * h, None);
    let points = distances(&observed, &load);
    let along = |i: f64, k: f64| -> [f64; 2] {
        let mut sum = [0.0; 2];
        for (from, to) in [(-1.0, 0.0), (0.0, 1.0)] {
            for (t, w) in gauss(from, to) {
                let (value, x) = (w * h * (1.0 - t.abs()), k * h * (i + t));
                sum = [sum[0] + value * x.cos(), sum[1] + value * x.sin()];
            }
        }
        sum
    };
    let mut sums = [[0.0; 3]; 3];
    let mut edges = vec![0.0, 1e-4, 1e-2, 1.0, 10.0, 100.0];
    edges.extend((1..=40).map(|n| 100.0 + 200.0 * f64::from(n)));
    for pair_of in edges.windows(2) {
        for (k, weight) in gauss(pair_of[0], pair_of[1]) {
            let ([c, s], [d, e]) = (along(2.0, k), along(1.0, k));
            let (even, odd) = (c * d + s * e, s * d - c * e);
            let blocks = pair(&STEEL, k, &points);
            for o in 0..3 {
                for l in 0..3 {
                    let along = match (o == 0, l == 0) {
                        (true, false) => -odd,
                        (false, true) => odd,
                        _ => even,
                    };
                    sums[o][l] += weight / std::f64::consts::PI * along * blocks[o][l];
                }
            }
        }
    }
    let (i, j) = (4 + 2, 12 + 1);
    let area = h * h;
    for (o, observed) in ALL.into_iter().enumerate() {
        for (l, loaded) in ALL.into_iter().enumerate() {
            let mut matrix = vec![0.0; 256];
            body.add_influence(observed, loaded, 1.0, &mut matrix);
            let exact = matrix[i * 16 + j];
            let own = sums[o][l] / area;
            assert!(
                (own - exact).abs() < 2e-4 * exact.abs(),
                "{observed:?} {loaded:?}: {own} {exact}"
            );
        }
    }
    Ok(())
}

#[test]
fn a_strip_and_a_hat_have_their_area() {
    for (shape, area) in [
        (strip(1.0, 3.0), 2.0),
        (hat(Some(0.0), 1.0, Some(2.0)), 1.0),
        (hat(None, 1.0, Some(2.0)), 0.5),
    ] {
        let sum: f64 = distances(&shape, &strip(-1.0, 0.0))
            .iter()
            .map(|(_, w)| w)
            .sum();
        assert!((sum - area).abs() < 1e-9, "{sum} {area}");
    }
}

/// Winkler's beam: `1 / (E I k^4 + c)` for waves that are long against the section, with Timoshenko's shear.
#[test]
fn long_waves_bend_a_beam_on_its_foundation() -> Result<(), Error> {
    let (b, h, c) = (0.04, 0.06, 3e7);
    let (section, top) = rectangle(&spaced(-0.5 * b, 0.5 * b, 4), &spaced(-h, 0.0, 6));
    let prism = Prism::new(
        STEEL,
        &section,
        Foot::Pads {
            vertical: c,
            lateral: 1e5,
        },
    )?;
    let lines = spaced(-0.5 * b, 0.5 * b, 4);
    let mut all = strips_of(&prism, &top, &lines, b / 4.0)?;
    // the whole top as one load
    let whole: Vec<(usize, f64)> = all[2].drain(..).flatten().collect();
    let young = 2.0 * STEEL.shear_modulus * (1.0 + STEEL.poisson_ratio);
    let inertia = b * h.powi(3) / 12.0;
    // [Cowper1966] for a rectangle
    let shear = 10.0 * 1.3 / (12.0 + 11.0 * 0.3) * STEEL.shear_modulus * b * h;
    for (length, tolerance) in [(4.0, 1e-3), (1.5, 3e-3), (0.8, 1e-2)] {
        let k = 2.0 * std::f64::consts::PI / length;
        let seen = prism.compliance(k, std::slice::from_ref(&whole))?[(0, 0)] / (b * b);
        let bending = young * inertia * k.powi(4) / (1.0 + young * inertia * k * k / shear);
        let beam = 1.0 / (bending + c);
        assert!(
            (seen / beam - 1.0).abs() < tolerance,
            "{length}: {seen} {beam}"
        );
    }
    Ok(())
}

/// A rigid motion at k = 0 meets the springs alone; without waves nothing else resists.
#[test]
fn uniform_motions_meet_the_foundation_alone() -> Result<(), Error> {
    let (b, vertical, lateral) = (0.05, 4e7, 2e7);
    let (section, top) = rectangle(&spaced(-0.5 * b, 0.5 * b, 3), &spaced(-0.04, 0.0, 3));
    let prism = Prism::new(STEEL, &section, Foot::Pads { vertical, lateral })?;
    let lines = spaced(-0.5 * b, 0.5 * b, 3);
    let loads = strips_of(&prism, &top, &lines, b / 3.0)?;
    let sums: Vec<Vec<(usize, f64)>> = loads.into_iter().map(|l| l.concat()).collect();
    let moved = prism.compliance(0.0, &sums)?;
    // the base gives way evenly, and the section above it is pressed by p h / stiffness of it besides
    assert!(moved[(2, 2)] / (b * b) > 1.0 / vertical);
    let expected = 1.0 / vertical + 0.04 / (b * 2.0 * 80e9 * 1.3);
    assert!((moved[(2, 2)] / (b * b) / expected - 1.0).abs() < 1e-3);
    let sheared = 1.0 / lateral + 0.04 / (b * 80e9);
    assert!((moved[(0, 0)] / (b * b) / sheared - 1.0).abs() < 1e-9);
    for i in 0..3 {
        for j in 0..3 {
            let scale = (moved[(i, i)] * moved[(j, j)]).sqrt();
            assert!((moved[(i, j)] - moved[(j, i)]).abs() < 1e-10 * scale);
        }
    }
    Ok(())
}

/// Quadratic triangles: the error of the energy falls with the fourth power of their size where nothing is singular.
/// On stiff springs the corners of the base take some of that.
#[test]
fn energy_converges_as_that_of_quadratic_elements() -> Result<(), Error> {
    let b = 0.04;
    let energy = |n: usize| -> Result<f64, Error> {
        let (section, top) = rectangle(&spaced(-0.5 * b, 0.5 * b, 2 * n), &spaced(-b, 0.0, 2 * n));
        let foot = Foot::Pads {
            vertical: 1e10,
            lateral: 1e10,
        };
        let prism = Prism::new(STEEL, &section, foot)?;
        let loads = strips_of(&prism, &top, &[-0.5 * b, 0.5 * b], b)?;
        Ok(prism.compliance(60.0, &loads[2])?[(0, 0)])
    };
    let values = [energy(1)?, energy(2)?, energy(4)?, energy(8)?];
    let steps: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).collect();
    // elements give way less than the body
    assert!(steps.iter().all(|step| *step > 0.0), "{values:?}");
    let order = (steps[1] / steps[2]).log2();
    assert!(order > 2.5, "{values:?} {order}");
    Ok(())
}

/// A block that is wide and deep against its contact is a half-space, whatever the component.
#[test]
fn a_large_block_is_a_half_space() -> Result<(), Error> {
    let h = 1e-3;
    let y = graded(0.2, 4e-3, 8, 1.5);
    let z: Vec<f64> = graded(0.2, 2e-3, 4, 1.5)
        .into_iter()
        .filter(|z| *z <= 0.0)
        .collect();
    let (section, top) = rectangle(&y, &z);
    let prism = Prism::new(STEEL, &section, Foot::Held)?;
    let grid = Grid::new(9, 9, h, h).map_err(Error::from)?;
    let patch = Patch {
        x0: -4.0 * h,
        y0: -4.0 * h,
        grid,
    };
    let strips = [Strip {
        patch,
        lines: spaced(-4.0 * h, 4.0 * h, 8),
    }];
    let body = PrismCompliance::under_hats(&prism, &top, &strips, &unmonitored)?;
    let half_space = HatHalfSpace::new(STEEL, vec![patch], Neighbours::Interact)?;
    let load: Vec<f64> = (0..81)
        .map(|k| {
            let (x, y) = (f64::from(k % 9) - 4.0, f64::from(k / 9) - 4.0);
            (1.0 - (x * x + y * y) / 20.0).max(0.0).sqrt()
        })
        .collect();
    for component in ALL {
        let (mut own, mut exact) = (vec![0.0; 81], vec![0.0; 81]);
        body.add_displacement(component, component, 1.0, &load, &mut own);
        half_space.add_displacement(component, component, 1.0, &load, &mut exact);
        // far sides and base change it by some F / (G d) at a distance d
        let off = own[40] / exact[40] - 1.0;
        assert!(off.abs() < 0.06, "{component:?}: {off}");
        // what differs is about the same everywhere: the shape is that of a half-space
        for k in 0..81 {
            let own = own[k] - own[40];
            let exact_shape = exact[k] - exact[40];
            assert!(
                (own - exact_shape).abs() < 0.005 * exact[40],
                "{component:?} {k}"
            );
        }
    }
    Ok(())
}

#[test]
fn products_equal_the_matrix_and_are_reciprocal() -> Result<(), Error> {
    let (section, top) = rectangle(&spaced(-0.02, 0.02, 8), &spaced(-0.03, 0.0, 5));
    let prism = Prism::new(STEEL, &section, Foot::Held)?;
    let grid = Grid::new(5, 3, 4e-3, 5e-3).map_err(Error::from)?;
    let first = Patch {
        x0: -8e-3,
        y0: -15e-3,
        grid,
    };
    let second = Patch {
        x0: -6e-3,
        y0: 5e-3,
        grid,
    };
    let strips = |count: usize, from: [f64; 2]| {
        [(first, from[0]), (second, from[1])].map(|(patch, from)| Strip {
            patch,
            lines: spaced(from, from + 5e-3 * count as f64, count),
        })
    };
    let hats = PrismCompliance::under_hats(&prism, &top, &strips(2, [-15e-3, 5e-3]), &unmonitored)?;
    let shifted = |from: f64, patch: Patch| Strip {
        patch: Patch {
            y0: from + 2.5e-3,
            ..patch
        },
        lines: spaced(from, from + 15e-3, 3),
    };
    let cells = [shifted(-20e-3, first), shifted(5e-3, second)];
    let cells = PrismCompliance::under_cells(&prism, &top, &cells, &unmonitored)?;
    let load: Vec<f64> = (0..30).map(|k| f64::from((7 * k + 3) % 11) - 4.0).collect();
    for (body, symmetry) in [(&hats, 1e-9), (&cells, 0.05)] {
        let areas = body.reciprocity().unwrap_or_default();
        for observed in ALL {
            for loaded in ALL {
                let (mut matrix, mut turned) = (vec![0.0; 900], vec![0.0; 900]);
                body.add_influence(observed, loaded, 1.0, &mut matrix);
                body.add_influence(loaded, observed, 1.0, &mut turned);
                let mut product = vec![0.0; 30];
                body.add_displacement(observed, loaded, 1.0, &load, &mut product);
                let scale = product.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
                for i in 0..30 {
                    let row = &matrix[30 * i..30 * i + 30];
                    let sum: f64 = row.iter().zip(&load).map(|(a, p)| a * p).sum();
                    assert!(
                        (sum - product[i]).abs() < 1e-10 * scale,
                        "{observed:?} {loaded:?}"
                    );
                    for j in 0..30 {
                        let (a, b) = (areas[i] * matrix[30 * i + j], areas[j] * turned[30 * j + i]);
                        assert!(
                            (a - b).abs() < symmetry * 1e-3 * areas[i] * scale + 1e-9 * a.abs(),
                            "{observed:?} {loaded:?}: {a} {b}"
                        );
                    }
                }
            }
        }
    }
    Ok(())
}

#[test]
fn what_cannot_be_is_refused() -> Result<(), Error> {
    let (section, top) = rectangle(&spaced(-0.02, 0.02, 4), &spaced(-0.03, 0.0, 3));
    let soft = Foot::Pads {
        vertical: 0.0,
        lateral: 1.0,
    };
    assert!(matches!(
        Prism::new(STEEL, &section, soft),
        Err(Error::Section(_))
    ));
    let rubber = Material {
        poisson_ratio: 0.5,
        ..STEEL
    };
    assert!(matches!(
        Prism::new(rubber, &section, Foot::Held),
        Err(Error::Incompressible(_))
    ));
    let bare = Section {
        base: vec![],
        ..section.clone()
    };
    assert!(matches!(
        Prism::new(STEEL, &bare, Foot::Held),
        Err(Error::Section(_))
    ));
    let mut turned = section.clone();
    turned.triangles[0].swap(0, 1);
    assert!(matches!(
        Prism::new(STEEL, &turned, Foot::Held),
        Err(Error::Section(_))
    ));
    let prism = Prism::new(STEEL, &section, Foot::Held)?;
    let grid = Grid::new(3, 3, 1e-2, 1e-2).map_err(Error::from)?;
    let patch = Patch {
        x0: 0.0,
        y0: -1e-2,
        grid,
    };
    let beside = Strip {
        patch,
        lines: vec![-0.011, 0.0, 0.01],
    };
    let found = PrismCompliance::under_hats(&prism, &top, &[beside], &unmonitored);
    assert!(matches!(found, Err(Error::Section(_))));
    Ok(())
}

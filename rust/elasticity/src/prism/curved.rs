// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rows on a curved surface, against rings in plane strain under their Fourier series.

use std::f64::consts::PI;

use faer::Mat;
use faer::linalg::solvers::Solve;
use mtb_operator::{Grid, unmonitored};

use super::rows::{Basis, Intervals, strip_loads};
use super::{Foot, Prism, PrismPair, PrismRows, Section};
use crate::Material;
use std::sync::Arc;

const STEEL: Material = Material {
    shear_modulus: 80e9,
    poisson_ratio: 0.29,
};
/// Rows all round, of which some carry loads.
const ROUND: usize = 48;
const ROWS: usize = 6;
/// Radius [m] of the surface.
const RADIUS: f64 = 10e-3;

/// A ring between the surface and another, free circle, and the edges of each loaded row. Rows lie at the top, in the
/// direction that has the material on its right.
fn ring(other: f64, parts: usize) -> (Section, Intervals) {
    let around = ROUND * parts;
    let first = RADIUS * 2.0 * PI / around as f64;
    let depth = (other - RADIUS).abs();
    let mut layers = vec![0.0];
    while layers[layers.len() - 1] < depth {
        let last = layers[layers.len() - 1];
        layers.push(last + first + 0.3 * last);
    }
    let scale = depth / layers[layers.len() - 1];
    let radius = |k: f64| {
        let (below, part) = (k.floor() as usize, k - k.floor());
        let next = (below + 1).min(layers.len() - 1);
        let at = layers[below] + part * (layers[next] - layers[below]);
        RADIUS + (other - RADIUS).signum() * at * scale
    };
    let (wide, high) = (2 * around, 2 * layers.len() - 1);
    let number = |i: usize, k: usize| (i % wide) * high + k;
    let mut nodes = Vec::new();
    for i in 0..wide {
        let angle = 2.0 * PI * i as f64 / wide as f64;
        for k in 0..high {
            let r = radius(0.5 * k as f64);
            nodes.push([r * angle.cos(), r * angle.sin()]);
        }
    }
    let inward = other < RADIUS;
    let mut triangles = Vec::new();
    for i in (0..wide).step_by(2) {
        for k in (0..high - 1).step_by(2) {
            let at = |a: usize, b: usize| number(i + a, k + b);
            let halves = [
                [at(0, 0), at(2, 0), at(2, 2), at(1, 0), at(2, 1), at(1, 1)],
                [at(0, 0), at(2, 2), at(0, 2), at(1, 1), at(1, 2), at(0, 1)],
            ];
            triangles.extend(halves.map(|[a, b, c, d, e, f]| {
                // layers go inwards from an outer surface, and outwards from that of a hole
                if inward {
                    [a, b, c, d, e, f]
                } else {
                    [a, c, b, f, e, d]
                }
            }));
        }
    }
    let base = (0..wide)
        .step_by(2)
        .map(|i| {
            [
                number(i, high - 1),
                number(i + 2, high - 1),
                number(i + 1, high - 1),
            ]
        })
        .collect();
    // the rows about the top, clockwise round a disc, the other way round a hole
    let top = wide / 4;
    let half = ROWS * parts;
    let edges: Vec<[usize; 3]> = (0..half)
        .map(|e| {
            let i = top + wide - half + 2 * e;
            let pair = [number(i, 0), number(i + 2, 0)];
            if inward {
                [pair[1], pair[0], number(i + 1, 0)]
            } else {
                [pair[0], pair[1], number(i + 1, 0)]
            }
        })
        .collect();
    let mut intervals: Intervals = edges.chunks_exact(parts).map(<[_]>::to_vec).collect();
    if inward {
        intervals.reverse();
        for edges in &mut intervals {
            edges.reverse();
        }
    }
    let section = Section {
        nodes,
        triangles,
        base,
    };
    (section, intervals)
}

/// Loads of the rows, tangential and into the body, whose forces and moment vanish, where a unit of each has these.
fn balanced(resultants: &[[f64; 3]]) -> [[f64; ROWS]; 2] {
    let mut loads: Vec<f64> = (0..2 * ROWS)
        .map(|k| ((7 * k + 3) % 11) as f64 - 4.5)
        .collect();
    // the first and the last tangential one and the pressure in the middle follow the others
    let free = [0, ROWS - 1, ROWS + 3];
    for k in free {
        loads[k] = 0.0;
    }
    let sums = Mat::from_fn(3, 1, |k, _| {
        let all = loads.iter().zip(resultants);
        -all.map(|(load, unit)| load * unit[k]).sum::<f64>()
    });
    let matrix = Mat::from_fn(3, 3, |k, f| resultants[free[f]][k]);
    let found = matrix.partial_piv_lu().solve(&sums);
    for (f, k) in free.into_iter().enumerate() {
        loads[k] = found[(f, 0)];
    }
    std::array::from_fn(|c| std::array::from_fn(|row| loads[c * ROWS + row]))
}

/// Angle of the middle of a row.
fn middle(row: usize, inward: bool) -> f64 {
    let away = (row as f64 - 0.5 * (ROWS - 1) as f64) * 2.0 * PI / ROUND as f64;
    0.5 * PI + if inward { -away } else { away }
}

/// Work per length [N/m times m] of the loads at their own displacements, by Michell's series.
fn series(other: f64, loads: &[[f64; ROWS]; 2]) -> f64 {
    let inward = other < RADIUS;
    let (g, kappa) = (STEEL.shear_modulus, 3.0 - 4.0 * STEEL.poisson_ratio);
    let half = PI / ROUND as f64;
    let ratio = other / RADIUS;
    let out = if inward { 1.0 } else { -1.0 };
    let mut work = 0.0;
    for n in 0..4000 {
        let m = f64::from(n);
        // amplitudes of sigma_rr and sigma_rt, [with cos and sin, with sin and -cos]
        let mut stress = [[0.0; 2]; 2];
        for row in 0..ROWS {
            let angle = m * middle(row, inward);
            let width = if n == 0 {
                half / PI
            } else {
                2.0 * (m * half).sin() / (m * PI)
            };
            let [q, p] = [loads[0][row], loads[1][row]];
            // sigma_rr = -p; the tangent is -theta on a disc and +theta in a hole, whose normal turns round as well
            let shear = -q;
            stress[0][0] -= p * width * angle.cos();
            stress[1][0] -= p * width * angle.sin();
            stress[0][1] += shear * width * angle.sin();
            stress[1][1] -= shear * width * angle.cos();
        }
        // powers of r over the radius, with their stresses and displacements times 2 G over the radius
        let family: Vec<[f64; 5]> = match n {
            0 => vec![
                [0.0, 1.0, 0.0, -1.0, 0.0],
                [2.0, 2.0, 0.0, kappa - 1.0, 0.0],
            ],
            1 => vec![
                [3.0, 2.0, 2.0, kappa - 2.0, kappa + 2.0],
                [-1.0, -2.0, -2.0, 1.0, 1.0],
            ],
            _ => vec![
                [m, m - m * m, m * (m - 1.0), -m, m],
                [-m, -m - m * m, m * (-m - 1.0), m, m],
                [
                    m + 2.0,
                    m + 2.0 - m * m,
                    m * (m + 1.0),
                    kappa - m - 1.0,
                    kappa + m + 1.0,
                ],
                [
                    2.0 - m,
                    2.0 - m - m * m,
                    m * (1.0 - m),
                    kappa + m - 1.0,
                    -(kappa - m + 1.0),
                ],
            ],
        };
        // from 12 waves on nothing comes back from the other circle: what fades away from the surface is left
        let fades = |power: f64| (power > 0.5) == inward;
        let family: Vec<[f64; 5]> = if n < 12 {
            family
        } else {
            family.into_iter().filter(|f| fades(f[0])).collect()
        };
        for [normal, shear] in stress {
            let count = family.len();
            let given: Vec<(usize, f64)> = match n {
                0 | 1 => vec![(1, normal)],
                _ => vec![(1, normal), (2, shear)],
            };
            let matrix = Mat::from_fn(count, count, |r, c| {
                let (column, f) = (given[r % given.len()].0, &family[c]);
                let place: f64 = if r < given.len() { 1.0 } else { ratio };
                f[column] * place.powf(f[0] - 2.0)
            });
            let right = Mat::from_fn(count, 1, |r, _| given.get(r).map_or(0.0, |g| g.1));
            let found = matrix.full_piv_lu().solve(&right);
            let moved = |column: usize| -> f64 {
                let sum: f64 = (0..count).map(|c| family[c][column] * found[(c, 0)]).sum();
                sum * RADIUS / (2.0 * g)
            };
            // on the boundary, whose outward normal is r on a disc
            let whole = if n == 0 { 2.0 * PI } else { PI };
            work += out * whole * RADIUS * (normal * moved(3) + shear * moved(4));
        }
    }
    work
}

/// Loads in balance, and their work by rows of finite elements on springs that hold nothing else.
fn elements(other: f64, parts: usize) -> ([[f64; ROWS]; 2], f64) {
    let (section, intervals) = ring(other, parts);
    let soft = Foot::Pads {
        vertical: 1e4,
        lateral: 1e4,
    };
    let prism = Prism::new(STEEL, &section, soft).unwrap();
    let dy = RADIUS * 2.0 * PI / ROUND as f64;
    let [_, across, into] = strip_loads(&prism, &intervals, Basis::Cells, dy).unwrap();
    let all = [across, into].concat();
    let mut lever = vec![[0.0; 3]; prism.unknowns()];
    for (node, [y, z]) in section.nodes.iter().enumerate() {
        for (component, unit) in [(1, [1.0, 0.0, -z]), (2, [0.0, 1.0, *y])] {
            if let Some(unknown) = prism.unknown(node, component) {
                lever[unknown] = unit;
            }
        }
    }
    let resultants: Vec<[f64; 3]> = all
        .iter()
        .map(|load| [0, 1, 2].map(|k| load.iter().map(|(u, value)| value * lever[*u][k]).sum()))
        .collect();
    let loads = balanced(&resultants);
    let moved = prism.compliance(1e-3, &all).unwrap();
    let flat: Vec<f64> = loads.iter().flatten().copied().collect();
    let mut work = 0.0;
    for (i, a) in flat.iter().enumerate() {
        for (j, b) in flat.iter().enumerate() {
            work += a * moved[(i, j)] * b;
        }
    }
    (loads, work)
}

#[test]
fn rows_round_a_disc_and_in_a_hole_move_as_rings_do() {
    for other in [2e-3, 40e-3] {
        let errors = [1, 2, 4, 8].map(|parts| {
            let (loads, work) = elements(other, parts);
            work / series(other, &loads) - 1.0
        });
        assert!(errors[3].abs() < 5e-3, "{other}: {errors:?}");
        for pair in errors.windows(2) {
            assert!(pair[1].abs() < 0.5 * pair[0].abs(), "{other}: {errors:?}");
        }
    }
}

#[test]
fn rows_are_reciprocal_and_upper_bodies_are_seen_in_a_mirror() {
    let (section, intervals) = ring(2e-3, 2);
    let prism = Prism::new(STEEL, &section, Foot::Held).unwrap();
    let grid = Grid::new(5, ROWS, 1e-3, RADIUS * 2.0 * PI / ROUND as f64).unwrap();
    let rows = Arc::new(PrismRows::new(&prism, &intervals, grid, &unmonitored).unwrap());
    let lower = PrismPair {
        lower: Some(rows.clone()),
        upper: None,
    };
    let offsets = [-2e-3, 0.0, 2e-3];
    let all = lower.influence(&offsets, 0..ROWS);
    let at = |values: &[f64], offset: usize, o: usize, l: usize, i: usize, j: usize| {
        values[((offset * 9 + 3 * o + l) * ROWS + i) * ROWS + j]
    };
    let largest = all.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    for (o, l) in (0..9).map(|k| (k / 3, k % 3)) {
        for (i, j) in (0..ROWS * ROWS).map(|k| (k / ROWS, k % ROWS)) {
            let apart = at(&all, 0, o, l, i, j) - at(&all, 2, l, o, j, i);
            assert!(apart.abs() < 1e-9 * largest);
        }
    }
    // some of the rows are those rows
    let some = lower.influence(&offsets, 2..5);
    assert!((some[(9 + 8) * 9 + 1] - at(&all, 1, 2, 2, 2, 3)).abs() < 1e-12 * largest);
    // two alike: what couples the normal with the tangents cancels, the rest doubles
    let both = PrismPair {
        lower: Some(rows.clone()),
        upper: Some(rows),
    };
    let twice = both.influence(&offsets, 0..ROWS);
    for (o, l) in (0..9).map(|k| (k / 3, k % 3)) {
        let factor = if (o == 2) == (l == 2) { 2.0 } else { 0.0 };
        let apart = at(&twice, 2, o, l, 1, 4) - factor * at(&all, 2, o, l, 1, 4);
        assert!(apart.abs() < 1e-12 * largest);
    }
    assert_eq!(both.rows(), ROWS);
}

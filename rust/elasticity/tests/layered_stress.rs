// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stress inside layered bodies: convolutions against sums over cells, the limit of one material, and what is refused.

use std::sync::Arc;

use mtb_elasticity::half_space::{Bond, Layered, LoadedCell, Medium, StressBelow, stress_at};
use mtb_elasticity::{Error, Material};
use mtb_operator::{Grid, unmonitored};

const SOFT: Material = Material {
    shear_modulus: 1e9,
    poisson_ratio: 0.4,
};
const STEEL: Material = Material {
    shear_modulus: 80e9,
    poisson_ratio: 0.28,
};

fn coated(layer: Material, base: Option<Material>, bond: Bond) -> Medium {
    Medium::Layered(Arc::new(
        Layered::new(layer, 0.6e-3, base, bond).expect("a body"),
    ))
}

const SHAPE: [usize; 2] = [7, 4];
const SIDES: [f64; 2] = [1e-3, 1.4e-3];

fn grid() -> Grid {
    Grid::new(SHAPE[0], SHAPE[1], SIDES[0], SIDES[1]).expect("a grid")
}

fn place(k: usize) -> [f64; 2] {
    [
        (k % SHAPE[0]) as f64 * SIDES[0],
        (k / SHAPE[0]) as f64 * SIDES[1],
    ]
}

fn loads() -> [Vec<f64>; 3] {
    [0.7, 1.3, 2.1].map(|step| {
        (0..SHAPE[0] * SHAPE[1])
            .map(|k| (step * k as f64).sin() + 0.2)
            .collect()
    })
}

fn cells(traction: &[Vec<f64>; 3]) -> Vec<LoadedCell> {
    (0..SHAPE[0] * SHAPE[1])
        .map(|k| LoadedCell {
            centre: place(k),
            sides: SIDES,
            traction: [0, 1, 2].map(|c| traction[c][k]),
        })
        .collect()
}

#[test]
fn convolutions_equal_sums_over_cells() {
    let traction = loads();
    let n = SHAPE[0] * SHAPE[1];
    for medium in [
        coated(SOFT, Some(STEEL), Bond::Bonded),
        coated(SOFT, None, Bond::Bonded),
    ] {
        let depths = match &medium {
            Medium::Layered(body) if body.waves(0.0).normal == 0.0 => vec![0.0, 0.6e-3, 2e-3],
            _ => vec![0.0, 0.2e-3, 0.6e-3],
        };
        let below = StressBelow::new(medium.clone(), grid(), [0, 1, 2].map(|c| &traction[c][..]))
            .expect("tractions");
        let found = below.at(&depths, &unmonitored).expect("a stress");
        for (depth, found) in depths.iter().zip(found.chunks(6 * n)) {
            let points: Vec<[f64; 3]> =
                (0..n).map(|k| [place(k)[0], place(k)[1], *depth]).collect();
            let summed =
                stress_at(medium.clone(), &cells(&traction), &points, &unmonitored).expect("a sum");
            let scale = summed
                .iter()
                .flatten()
                .fold(0.0, |m: f64, v| m.max(v.abs()));
            for (k, stress) in summed.iter().enumerate() {
                for (c, value) in stress.iter().enumerate() {
                    let error = (found[c * n + k] - value).abs() / scale;
                    assert!(error < 1e-11, "{depth} {k} {c}: {error:e}");
                }
            }
        }
    }
}

#[test]
fn one_material_is_its_half_space() {
    let traction = loads();
    let points = [
        [0.3e-3, 2e-3, 0.1e-3],
        [4e-3, 1e-3, 0.6e-3],
        [2e-3, 2e-3, 3e-3],
    ];
    let at = |medium: Medium| {
        stress_at(medium, &cells(&traction), &points, &unmonitored).expect("a sum")
    };
    let (own, plain) = (at(coated(SOFT, Some(SOFT), Bond::Bonded)), at(SOFT.into()));
    for (own, plain) in own.iter().flatten().zip(plain.iter().flatten()) {
        assert!((own - plain).abs() < 1e-11, "{own} {plain}");
    }
}

#[test]
fn what_has_no_stress_is_refused() {
    let traction = loads();
    let sliding = coated(SOFT, Some(STEEL), Bond::Frictionless);
    let below = StressBelow::new(sliding.clone(), grid(), [0, 1, 2].map(|c| &traction[c][..]));
    assert!(matches!(below.map(|_| ()), Err(Error::CarriedAway)));
    let point = [[0.0, 0.0, 1e-3]];
    let sum = stress_at(sliding, &cells(&traction), &point, &unmonitored);
    assert!(matches!(sum, Err(Error::CarriedAway)));
    let stiff = coated(SOFT, None, Bond::Bonded);
    let sum = stress_at(stiff.clone(), &cells(&traction), &point, &unmonitored);
    assert!(matches!(sum, Err(Error::InRigidBase { index: 0, .. })));
    let none = vec![0.0; traction[2].len()];
    let below =
        StressBelow::new(stiff, grid(), [&none[..], &none, &traction[2]]).expect("a pressure");
    let deep = below.at(&[0.1e-3, 0.7e-3], &unmonitored);
    assert!(matches!(deep, Err(Error::InRigidBase { index: 1, .. })));
}

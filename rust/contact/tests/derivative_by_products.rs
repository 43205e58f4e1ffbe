// SPDX-License-Identifier: MIT OR Apache-2.0
//! Derivatives without a matrix against those with one.

use std::sync::Arc;

use mtb_contact::sliding::RigidMotion;
use mtb_contact::stepping::{Found, Given, Influence, Linearised, SlidingState};
use mtb_elasticity::Material;
use mtb_elasticity::half_space::{HalfSpace, Neighbours, Patch};
use mtb_operator::{Compliance, Grid, Relative, unmonitored};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestRng};

/// Half-spaces under two patches, of unlike materials or like ones, with a layer between them.
fn pair(is_alike: bool, layer: f64) -> Relative {
    let patch = |x0, y0, nx, ny, dx| Patch {
        x0,
        y0,
        grid: Grid::new(nx, ny, dx, 1.1e-3).expect("a grid"),
    };
    let patches = vec![
        patch(0.0, 0.0, 7, 6, 1e-3),
        patch(1.3e-3, 17e-3, 5, 4, 1.2e-3),
    ];
    let body = |shear_modulus: f64, ratio: f64| -> Arc<dyn Compliance> {
        let material = Material::new(shear_modulus, ratio).expect("a material");
        let made = HalfSpace::with_patches(material, patches.clone(), Neighbours::Interact);
        Arc::new(made.expect("a half-space"))
    };
    let upper = if is_alike {
        body(30e9, 0.1)
    } else {
        body(80e9, 0.3)
    };
    let bare = Relative::new(Some(body(30e9, 0.1)), Some(upper)).expect("a pair");
    bare.with_layer(vec![layer; 62]).expect("a layer")
}

/// A state of it: pressures, some of them none, friction whose slope is another, two motions, a diagonal.
fn state(random: &mut TestRng) -> SlidingState {
    let mut next = move || 2.0 * random.random::<f64>() - 1.0;
    let n = 62;
    let mut field =
        |middle: f64, by: f64| -> Vec<f64> { (0..n).map(|_| middle + by * next()).collect() };
    let pressure = field(5e7, 1e8).into_iter().map(|p| p.max(0.0)).collect();
    let area: Vec<f64> = (0..n)
        .map(|i| if i < 42 { 1.1e-6 } else { 1.32e-6 })
        .collect();
    let mut motion = |opening: Vec<f64>| RigidMotion {
        tangential_x: field(0.0, 0.2),
        tangential_y: field(0.0, 0.2),
        opening,
        work: 0.0,
    };
    let lift = motion(vec![1.0; n]);
    let tilt = motion((0..n).map(|i| 1e-3 * (i % 7) as f64 - 3e-3).collect());
    SlidingState {
        area,
        pressure,
        friction: field(0.3, 0.1),
        slope: field(0.2, 0.2),
        direction: field(0.0, 0.7).into_iter().chain(field(0.0, 0.7)).collect(),
        motions: vec![lift, tilt],
        diagonal: Some(field(5e-15, 4e-15)),
        limit: None,
        yields: Vec::new(),
    }
}

fn close(name: &str, found: &[f64], expected: &[f64]) -> Result<(), TestCaseError> {
    let size = expected.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    for (a, b) in found.iter().zip(expected) {
        prop_assert!((a - b).abs() <= 1e-8 * size, "{name}: {a} {b} of {size}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn products_and_matrices_have_the_same_derivatives(
        seed in any::<u64>(),
        is_alike in any::<bool>(),
        is_coupled in any::<bool>(),
        is_layered in any::<bool>(),
    ) {
        let mut random = TestRng::from_seed(RngAlgorithm::ChaCha, &{
            let mut bytes = [0; 32];
            bytes[..8].copy_from_slice(&seed.to_le_bytes());
            bytes
        });
        let pair = pair(is_alike, if is_layered { 1e-14 } else { 0.0 });
        let state = state(&mut random);
        let influence = if is_coupled {
            Influence::of(&pair, &unmonitored)
        } else {
            Influence::uncoupled(&pair, &unmonitored)
        };
        let influence = Arc::new(influence.expect("matrices"));
        let mut dense = Linearised::new(influence, state.clone(), &unmonitored).expect("factors");
        let mut light = Linearised::by_products(pair, state, is_coupled).expect("a state");
        let (mut dense, mut light) = (dense.tangent().unwrap(), light.tangent().unwrap());
        let mut field = |size: f64, length: usize| -> Vec<f64> {
            (0..length).map(|_| size * (2.0 * random.random::<f64>() - 1.0)).collect()
        };
        let changes: Vec<Given> = (0..2)
            .map(|_| Given { gap: field(1e-7, 62), work: field(1.0, 2), drag: field(0.1, 124), ..Given::nothing(62, 2) })
            .collect();
        let weights: Vec<Found> = (0..2)
            .map(|_| Found {
                pressure: field(1.0, 62),
                traction: field(1.0, 124),
                gap: field(1e13, 62),
                motion: field(1e13, 2),
                pull: Vec::new(),
            })
            .collect();
        let [a, b] = [&mut light, &mut dense]
            .map(|tangent| tangent.forward(&changes, &unmonitored).expect("a derivative"));
        for (a, b) in a.iter().zip(&b) {
            close("pressure", &a.pressure, &b.pressure)?;
            close("traction", &a.traction, &b.traction)?;
            close("gap", &a.gap, &b.gap)?;
            close("motion", &a.motion, &b.motion)?;
        }
        let [c, d] = [&mut light, &mut dense]
            .map(|tangent| tangent.adjoint(&weights, &unmonitored).expect("a gradient"));
        for (c, d) in c.iter().zip(&d) {
            close("gradient by the gap", &c.gap, &d.gap)?;
            close("gradient by the work", &c.work, &d.work)?;
            close("gradient by the friction", &c.drag, &d.drag)?;
        }
        close("opening", &light.opening(), &dense.opening())?;
        let limit = light.wedging_factor(&unmonitored).unwrap();
        prop_assert_eq!(limit.is_nan(), is_coupled && !is_alike);
        prop_assert!(limit.is_nan() || limit == dense.wedging_factor(&unmonitored).unwrap());
    }
}

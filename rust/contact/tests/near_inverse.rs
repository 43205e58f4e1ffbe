// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts by products: with the near inverse of their bodies they need fewer, and find the same.

use std::sync::Arc;

use mtb_contact::sliding::{RigidMotion, SlidingContact, SlidingMatrix};
use mtb_contact::stepping::{Found, Given, Influence, Linearised, SlidingState};
use mtb_elasticity::Material;
use mtb_elasticity::half_space::{HatHalfSpace, Neighbours, Patch};
use mtb_operator::{Compliance, Component, Grid, Relative, unmonitored};

/// A body that keeps its near inverse to itself.
struct Reserved(Arc<dyn Compliance>);

impl Compliance for Reserved {
    fn points(&self) -> usize {
        self.0.points()
    }

    fn add_displacement(&self, o: Component, l: Component, scale: f64, t: &[f64], u: &mut [f64]) {
        self.0.add_displacement(o, l, scale, t, u);
    }
}

/// A strip with a rounded sole, six times as long as wide, which a force presses and slides along x, on `nx` nodes;
/// each point gives way by `diagonal` times its own share besides.
fn products(nx: usize, softer: Option<fn(usize) -> f64>) -> [usize; 2] {
    let (length, ny) = (30e-3, (nx - 1) / 6 + 1);
    let grid = Grid::new(nx, ny, length / (nx - 1) as f64, 5e-3 / (ny - 1) as f64).expect("cells");
    let patch = Patch {
        x0: 0.0,
        y0: 0.0,
        grid,
    };
    let steel = Material::new(80e9, 0.3).expect("a material");
    let body = HatHalfSpace::new(steel, vec![patch], Neighbours::Interact).expect("nodes");
    let (n, area) = (nx * ny, body.weights());
    let body: Arc<dyn Compliance> = Arc::new(body);
    let x = |i: usize| length * ((i % nx) as f64 / (nx - 1) as f64 - 0.5);
    let gap: Vec<f64> = (0..n).map(|i| 0.5 * x(i).powi(2) / 8.0).collect();
    let diagonal: Option<Vec<f64>> = softer.map(|softer| (0..n).map(softer).collect());
    let motion = RigidMotion {
        tangential_x: vec![0.0; n],
        tangential_y: vec![0.0; n],
        opening: vec![1.0; n],
        work: -2e4,
    };
    let direction: Vec<f64> = (0..2 * n).map(|i| if i < n { 1.0 } else { 0.0 }).collect();
    let contact = SlidingContact {
        gap: &gap,
        area: &area,
        friction: &vec![0.4; n],
        direction: &direction,
        motions: &[motion],
        diagonal: diagonal.as_deref(),
        interface: None,
    };
    let alone = |body| Arc::new(Relative::new(None, Some(body)).expect("one body"));
    let expected = SlidingMatrix::new(&*alone(body.clone()), &direction, true, &unmonitored)
        .and_then(|matrix| matrix.solve(&contact, None, &unmonitored))
        .expect("a pressure")
        .pressure;
    let most = expected.iter().fold(0.0_f64, |m, p| m.max(*p));
    assert!(expected.contains(&0.0) && most > 0.0);
    [alone(body.clone()), alone(Arc::new(Reserved(body)))].map(|pair| {
        let matrix = SlidingMatrix::by_products(pair, &direction, true).expect("products");
        let found = matrix
            .solve(&contact, None, &unmonitored)
            .expect("a pressure");
        for (p, e) in found.pressure.iter().zip(&expected) {
            assert!((p - e).abs() < 1e-6 * most, "{p} {e} of {most}");
        }
        found.iterations
    })
}

#[test]
fn the_near_inverse_saves_half_of_the_products() {
    for nx in [31, 61] {
        let [with, without] = products(nx, None);
        assert!(2 * with < without, "{nx}: {with} {without}");
    }
}

/// Points that give way by themselves count by their mean, and where they are too unlike, the diagonal stays.
#[test]
fn points_that_give_way_by_themselves_are_counted() {
    let [with, without] = products(31, Some(|_| 2e-15));
    assert!(with < without, "{with} {without}");
    let uneven: fn(usize) -> f64 = |i| if i % 2 == 0 { 0.0 } else { 1e-14 };
    let [with, without] = products(31, Some(uneven));
    assert_eq!(with, without);
}

/// Derivatives and gradients take the near inverse too, and are those of the matrix.
#[test]
fn derivatives_with_the_near_inverse_are_those_of_the_matrix() {
    let (nx, ny) = (13, 7);
    let n = nx * ny;
    let patch = Patch {
        x0: 0.0,
        y0: 0.0,
        grid: Grid::new(nx, ny, 1e-3, 0.8e-3).expect("cells"),
    };
    let steel = Material::new(80e9, 0.3).expect("a material");
    let body = HatHalfSpace::new(steel, vec![patch], Neighbours::Interact).expect("nodes");
    let area = body.weights();
    let pair = Relative::new(None, Some(Arc::new(body))).expect("one body");
    let wave = |by: f64, i: usize| (by * i as f64).sin();
    let motion = |by: f64| RigidMotion {
        tangential_x: (0..n).map(|i| 0.1 * wave(by, i)).collect(),
        tangential_y: vec![0.0; n],
        opening: (0..n).map(|i| 1.0 + by * (i % nx) as f64).collect(),
        work: 0.0,
    };
    let state = SlidingState {
        area,
        pressure: (0..n)
            .map(|i| (5e7 + 1e8 * wave(2.3, i)).max(0.0))
            .collect(),
        friction: vec![0.3; n],
        slope: vec![0.25; n],
        direction: (0..2 * n).map(|i| if i < n { 1.0 } else { 0.0 }).collect(),
        motions: vec![motion(0.0), motion(0.3)],
        diagonal: Some(vec![1e-16; n]),
        limit: None,
        yields: Vec::new(),
    };
    let influence = Arc::new(Influence::of(&pair, &unmonitored).expect("matrices"));
    let mut dense = Linearised::new(influence, state.clone(), &unmonitored).expect("factors");
    let mut light = Linearised::by_products(pair, state, true).expect("a state");
    let (mut dense, mut light) = (dense.tangent().unwrap(), light.tangent().unwrap());
    let change = Given {
        gap: (0..n).map(|i| 1e-7 * wave(1.1, i)).collect(),
        work: vec![1.0, -2.0],
        drag: (0..2 * n).map(|i| 0.1 * wave(0.7, i)).collect(),
        ..Given::nothing(n, 2)
    };
    let weight = Found {
        pressure: (0..n).map(|i| wave(1.9, i)).collect(),
        traction: (0..2 * n).map(|i| wave(0.9, i)).collect(),
        gap: (0..n).map(|i| 1e13 * wave(1.3, i)).collect(),
        motion: vec![1e13, 2e12],
        pull: Vec::new(),
    };
    let close = |found: &[f64], expected: &[f64]| {
        let size = expected.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() <= 1e-8 * size, "{a} {b} of {size}");
        }
    };
    let [a, b] = [&mut light, &mut dense].map(|t| {
        t.forward(std::slice::from_ref(&change), &unmonitored)
            .unwrap()
    });
    close(&a[0].pressure, &b[0].pressure);
    close(&a[0].motion, &b[0].motion);
    let [a, b] = [&mut light, &mut dense].map(|t| {
        t.adjoint(std::slice::from_ref(&weight), &unmonitored)
            .unwrap()
    });
    close(&a[0].gap, &b[0].gap);
    close(&a[0].work, &b[0].work);
    close(&a[0].drag, &b[0].drag);
}

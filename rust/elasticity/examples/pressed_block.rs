// SPDX-License-Identifier: MIT OR Apache-2.0
//! How soft is a surface? A square of pressure on a half-space, against Love's closed form, and on a
//! finite-element block of the same steel, condensed onto its contact points.

use std::f64::consts::PI;

use mtb_elasticity::half_space::influence;
use mtb_elasticity::tetra::{ContactGrid, Hold, Limits, Order, Support, TetraBody, TetraMesh};
use mtb_elasticity::{Error, Material};
use mtb_operator::{Compliance, Component, unmonitored};

/// A cube [m] of `n` cells a side, six tetrahedra each: nodes x fastest, then y, then z.
fn cube(side: f64, n: usize) -> Result<TetraMesh, Error> {
    let m = n + 1;
    let place = |i: usize| side * i as f64 / n as f64;
    let nodes = (0..m * m * m)
        .map(|k| {
            [
                place(k % m) - 0.5 * side,
                place(k / m % m) - 0.5 * side,
                place(k / (m * m)),
            ]
        })
        .collect();
    let mut cells = Vec::new();
    for cell in 0..n * n * n {
        let corner = cell % n + m * (cell / n % n + m * (cell / (n * n)));
        let (x, y, z) = (1, m, m * m);
        for (a, b) in [(x, y), (y, z), (z, x)] {
            cells.extend([corner, corner + a, corner + a + b, corner + x + y + z]);
            cells.extend([corner, corner + a + b, corner + b, corner + x + y + z]);
        }
    }
    TetraMesh::new(nodes, cells, Order::Linear)
}

fn main() -> Result<(), Error> {
    let steel = Material::new(80e9, 0.3)?;

    // half-space, centre of a uniformly loaded square of side a: 4 ln(1 + sqrt 2) (1 - nu) a / (2 pi G)
    let a = 20e-3;
    let by_love = influence(
        &steel,
        Component::Normal,
        Component::Normal,
        [0.0, 0.0],
        [a, a],
    );
    let closed = 4.0 * (1.0 + 2f64.sqrt()).ln() * (1.0 - 0.3) * a / (2.0 * PI * 80e9);
    println!("half-space: {by_love:.4e} m/Pa, closed form {closed:.4e}");
    assert!((by_love / closed - 1.0).abs() < 1e-12);

    // the same square pressed onto the lower face of a cube of 40 mm whose top is held
    let mesh = cube(40e-3, 8)?;
    let top = (0..mesh.nodes().len())
        .filter(|&node| mesh.nodes()[node][2] > 40e-3 - 1e-9)
        .collect();
    let support = Support {
        name: "top".into(),
        nodes: top,
        hold: [Hold::Prescribed; 3],
    };
    // a mesh of contact points 5 mm apart under the square, traction bilinear between them
    let places = [-10e-3, -5e-3, 0.0, 5e-3, 10e-3];
    let points: Vec<[f64; 3]> = (0..25)
        .map(|k| [places[k % 5], places[k / 5], 0.0])
        .collect();
    let grid = ContactGrid {
        nx: 5,
        ny: 5,
        spacing: [5e-3; 2],
        frames: vec![[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]; points.len()],
        points,
    };
    let face: Vec<usize> = (0..mesh.n_faces())
        .filter(|&f| {
            mesh.face(f)
                .iter()
                .all(|&node| mesh.nodes()[node][2] < 1e-9)
        })
        .collect();
    let sampling = grid.sampling(&mesh, &face)?;
    let body = TetraBody::new(mesh, steel, vec![support])?;
    let condensed = body.condense(&sampling, Limits::default(), &unmonitored)?;
    let mut indentation = vec![0.0; 25];
    condensed.flexibility.add_displacement(
        Component::Normal,
        Component::Normal,
        1.0,
        &[1.0; 25],
        &mut indentation,
    );
    println!(
        "block on its held top: {:.4e} m/Pa at the centre, {} unknowns",
        indentation[12], condensed.cost.unknowns
    );
    // the top is 40 mm away instead of infinitely far, and holds
    assert!(indentation[12] > 0.5 * by_love && indentation[12] < by_love);
    Ok(())
}

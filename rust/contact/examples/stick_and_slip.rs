// SPDX-License-Identifier: MIT OR Apache-2.0
//! One contact problem, asked three things: a steel ball on a steel plate is pressed, gives way to a tangential
//! displacement, and slides; against Hertz and against Cattaneo and Mindlin [Johnson1985, ch. 4 and 7].

use std::sync::Arc;

use mtb_contact::coupled::PointState;
use mtb_contact::problem::{Body, FreeMotion, Friction, Geometry, Load, Problem};
use mtb_elasticity::{Material, half_space::HalfSpace};
use mtb_operator::{Compliance, Grid, Relative, unmonitored};

const MU: f64 = 0.3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (side, spacing, radius, force) = (22, 1e-4, 50e-3, 1e3);
    let n = side * side;
    let (shear_modulus, poisson_ratio) = (80e9, 0.3);
    let place = |i: usize| (i as f64 - 0.5 * (side - 1) as f64) * spacing;
    let constant = |v: [f64; 3]| -> Vec<f64> { (0..3 * n).map(|k| v[k / n]).collect() };
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let geometry = Geometry {
        points: (0..3 * n)
            .map(|k| [place(k % n % side), place(k % n / side), 0.0][k / n])
            .collect(),
        tangent_x: constant(x),
        tangent_y: constant(y),
        normal: constant(z),
        area: vec![spacing * spacing; n],
        mean_frame: [x, y, z].map(constant),
        means: None,
        windows: Vec::new(),
    };
    let steel = Material::new(shear_modulus, poisson_ratio)?;
    let body: Arc<dyn Compliance> = Arc::new(HalfSpace::new(
        steel,
        Grid::new(side, side, spacing, spacing)?,
    )?);
    // the ball comes down by itself: a unit of its motion along z opens every gap by 1 m
    let up: Vec<f64> = (0..3 * n)
        .map(|k| f64::from(u8::from(k >= 2 * n)))
        .collect();
    let free = FreeMotion::of(&geometry, Body::Upper, &up)?;
    let pair = Relative::new(Some(body.clone()), Some(body))?;
    let problem = Problem::new(pair, Arc::new(geometry), vec![free])?;
    let gap = (0..n)
        .map(|k| (place(k % side).powi(2) + place(k / side).powi(2)) / (2.0 * radius))
        .collect();
    let mut loading = problem.unloaded(gap);
    problem.load(&mut loading, Load::Force(force))?;

    let pressed = problem.press(&loading, &unmonitored)?;
    let modulus = shear_modulus / (1.0 - poisson_ratio);
    let contact_radius = (0.75 * force * radius / modulus).cbrt();
    let (approach, hertz) = (-pressed.solution.motion[0], contact_radius.powi(2) / radius);
    println!(
        "approach {:.3} um, Hertz {:.3}",
        approach * 1e6,
        hertz * 1e6
    );
    assert!((approach / hertz - 1.0).abs() < 1e-2);

    let friction = vec![MU; n];
    let sliding = 3.0 * MU * force * (2.0 - poisson_ratio) / (8.0 * shear_modulus * contact_radius);
    let shares = [0.25, 0.5, 0.75];
    let steps = shares.map(|share| problem.geometry().uniform([share * sliding, 0.0, 0.0]));
    let states = problem.stick_or_slip(&loading, &friction, 0.0, &steps, 1e-9, &unmonitored)?;
    for (share, state) in shares.iter().zip(&states) {
        assert_eq!(state.unsolved(), None);
        let stick = state.points.iter().filter(|p| **p == PointState::Stick);
        let (found, exact) = (state.force[0] / (MU * force), 1.0 - (1.0 - share).powf(1.5));
        println!(
            "pushed by {:.2} of the way to sliding: {:.3} of the friction, Mindlin {exact:.3}; {} points stick",
            share,
            found,
            stick.count()
        );
        assert!((found - exact).abs() < 1e-2);
    }

    let direction = problem.geometry().sliding_direction([1.0, 0.0])?;
    let law = Friction::Field(&friction);
    let slid = problem.slide(&loading, &direction, law, None, &unmonitored)?;
    println!("sliding: {:.2} N of friction", slid.force[0]);
    assert!((slid.force[0] / (MU * force) - 1.0).abs() < 1e-9);
    Ok(())
}

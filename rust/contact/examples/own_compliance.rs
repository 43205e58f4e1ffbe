// SPDX-License-Identifier: MIT OR Apache-2.0
//! A compliance of one's own in the solver: a ball sliding on a lining of independent springs, against
//! the closed form of the elastic foundation [Johnson1985, section 4.3].

use std::f64::consts::PI;

use mtb_complementarity::linear::Status;
use mtb_contact::sliding::{RigidMotion, SlidingContact, SlidingMatrix};
use mtb_operator::{Compliance, Component, unmonitored};

/// Brake lining: gives way to its own pressure only.
struct Lining {
    points: usize,
    /// Indentation by a unit pressure [m/Pa].
    softness: f64,
}

impl Compliance for Lining {
    fn points(&self) -> usize {
        self.points
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        if (observed, loaded) == (Component::Normal, Component::Normal) {
            for (u, p) in displacement.iter_mut().zip(traction) {
                *u += scale * self.softness * p;
            }
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (n, spacing, radius, force) = (41, 0.5e-3, 0.1, 200.0);
    let lining = Lining {
        points: n * n,
        softness: 1e-10,
    };
    let place = |i: usize| (i as f64 - 0.5 * (n - 1) as f64) * spacing;
    let gap: Vec<f64> = (0..n * n)
        .map(|k| (place(k % n).powi(2) + place(k / n).powi(2)) / (2.0 * radius))
        .collect();
    // along +x everywhere
    let direction: Vec<f64> = (0..2 * n * n)
        .map(|k| if k < n * n { 1.0 } else { 0.0 })
        .collect();
    // the ball comes down by itself: a unit of it closes every gap by 1 m against the force
    let descent = RigidMotion {
        tangential_x: vec![0.0; n * n],
        tangential_y: vec![0.0; n * n],
        opening: vec![-1.0; n * n],
        work: force,
    };
    let contact = SlidingContact {
        gap: &gap,
        area: &vec![spacing * spacing; n * n],
        friction: &vec![0.3; n * n],
        direction: &direction,
        motions: &[descent],
    };
    let matrix = SlidingMatrix::new(&lining, &direction, true, &unmonitored)?;
    let solved = matrix.solve(&contact, None, &unmonitored)?;
    assert_eq!(solved.status, Status::Solved);

    // F = pi R delta^2 / softness
    let approach = (force * lining.softness / (PI * radius)).sqrt();
    println!(
        "approach {:.4} um, closed form {:.4}; {} active sets",
        solved.motion[0] * 1e6,
        approach * 1e6,
        solved.iterations
    );
    assert!((solved.motion[0] / approach - 1.0).abs() < 5e-3);
    Ok(())
}

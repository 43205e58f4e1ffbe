// SPDX-License-Identifier: MIT OR Apache-2.0
//! A body of one's own: a ball pressed and slid on a brake lining of independent springs, against the closed
//! form of the elastic foundation [Johnson1985, section 4.3].
//!
//! cargo run --release -p mtb --example own_compliance

use std::f64::consts::PI;
use std::sync::Arc;

use mtb::{Compliance, Component, Contact, Friction, Grid, Load, Relative, descent, unmonitored};

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
    let (radius, force, softness) = (0.1, 200.0, 1e-10);
    let grid = Grid::new(41, 41, 0.5e-3, 0.5e-3)?;
    let points = grid.points();
    let lining: Arc<dyn Compliance> = Arc::new(Lining { points, softness });
    // a rigid ball above
    let pair = Relative::new(Some(lining), None)?;
    let gap = |x: f64, y: f64| (x * x + y * y) / (2.0 * radius);
    let contact = Contact::on_plane(pair, grid, gap, vec![descent(points)])?;

    let pressed = contact.press(&[Load::Force(force)], &unmonitored)?;
    let friction = vec![0.3; points];
    let friction = Friction::Field(&friction);
    let slid = contact.slide(&[Load::Force(force)], [1.0, 0.0], friction, &unmonitored)?;

    // F = pi R delta^2 / softness
    let approach = (force * softness / (PI * radius)).sqrt();
    let found = -pressed.outcome.solution.motion[0];
    println!(
        "approach {:.4} um, closed form {:.4}",
        1e6 * found,
        1e6 * approach
    );
    println!("sliding: Fx = {:.3} N", slid.outcome.force[0]);
    assert!((found / approach - 1.0).abs() < 5e-3);
    assert!((slid.outcome.force[0] / (0.3 * force) - 1.0).abs() < 1e-9);
    Ok(())
}

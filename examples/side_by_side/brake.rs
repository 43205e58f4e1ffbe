// SPDX-License-Identifier: MIT OR Apache-2.0
//! Brake force, normal force and moment of a prepared shoe at three velocities.
//!
//! cargo run --release -p mtb --example brake shoe.mtbc

use std::sync::Arc;

use mtb::contact::prepared::{Prepared, PreparedContact, Pull, Step};
use mtb::unmonitored;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("brake shoe.mtbc")?;
    let prepared = Prepared::from_bytes(&std::fs::read(path)?)?;
    let mut shoe = PreparedContact::new(Arc::new(prepared));
    for speed in [30.0, 20.0, 10.0] {
        let step = Step {
            pose: [f64::NAN; 6],
            velocity: [speed, 0.0],
            shift: None,
            pull: Pull::Scene,
            gap: None,
            friction: None,
            diagonal: None,
        };
        let found = shoe.step(&step, &unmonitored)?;
        println!(
            "{speed} {} {} {}",
            found.force[0], found.force[2], found.moment[1]
        );
    }
    Ok(())
}

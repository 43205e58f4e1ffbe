// SPDX-License-Identifier: MIT OR Apache-2.0
//! How hot is the rail under a shoe of 1 m that brakes from 30 m/s?
//!
//! The rail passes under a pressure of 1 MPa with a friction of 0.1, and takes all the heat.

use mtb_heat::{Conductor, Error, HalfSpace};

fn main() -> Result<(), Error> {
    let steel = Conductor::new(50.0, 7850.0, 450.0)?;
    let (length, width, power) = (1.0, 0.06, 0.1 * 1e6 * 30.0);
    let rail = HalfSpace::new(steel, [30.0, 0.0])?;
    println!("Peclet number {:.0}", rail.peclet(0.5 * length));
    for place in [-0.4, -0.2, 0.0, 0.2, 0.4, 0.5] {
        let found = power * rail.influence([place, 0.0], [length, width])?;
        let quick = 2.0 * power * ((place + 0.5 * length) / 30.0 / std::f64::consts::PI).sqrt();
        println!(
            "x {place:5.1} m: {found:6.2} K, by heat into the depth alone {:6.2} K",
            quick / steel.effusivity()
        );
    }
    Ok(())
}

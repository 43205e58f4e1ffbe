// SPDX-License-Identifier: MIT OR Apache-2.0
//! The elastic pole shoe of a magnetic track brake slides on a 60E1 rail, which is a half-space or elastic too.
//!
//! cargo run --release -p mtb --example pole_shoe [spacing in mm] [elastic]

use mtb::geometry::solid::RailSection;
use mtb::{Body, Friction, Load, PoleShoeOnRail, Rail, STEEL, unmonitored};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let spacing = std::env::args().nth(1).map_or(Ok(6.0), |s| s.parse())?;
    let rail = match std::env::args().nth(2).as_deref() {
        Some("elastic") => Rail::Elastic {
            material: STEEL,
            section: RailSection::default(),
            length: 0.18,
        },
        _ => Rail::HalfSpace(STEEL),
    };
    let scene = PoleShoeOnRail {
        lower: rail,
        spacing: [1e-3 * spacing; 2],
        ..PoleShoeOnRail::default()
    };
    // meshed, held on top, and condensed once ...
    let contact = scene.stand(&unmonitored)?;
    let n = contact.points();
    // ... magnets pull the poles down by 3 MPa where they meet the rail
    let pull = vec![3e6; n];
    println!("{n} contact points\nmu [-]        Fx [N]        Fz [N]   peak pressure [MPa]");
    for coefficient in [0.0, 0.25, 0.5] {
        let friction = vec![coefficient; n];
        let state = contact.slide(
            &[Load::Pull(&pull, Body::Upper)],
            [1.0, 0.0],
            Friction::Field(&friction),
            &unmonitored,
        )?;
        let [fx, _, fz] = state.outcome.force;
        let peak = 1e-6 * state.peak_pressure();
        println!("{coefficient:.2} {fx:18.9} {fz:18.9} {peak:18.12}");
    }
    Ok(())
}

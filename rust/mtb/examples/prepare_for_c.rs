// SPDX-License-Identifier: MIT OR Apache-2.0
//! Prepares a contact with a gap of its own, and a wheelset, and writes them for programs in C and Fortran.
//!
//! cargo run --release -p mtb --example prepare_for_c [folder]
//!
//! `mtb_contact_load` reads plate.mtbc, `mtb_wheels_load` wheelset.mtbw; so do `PreparedContact.load` and
//! `PreparedWheels.load` in Python.

use std::path::PathBuf;

use mtb::contact::prepared::{Prepared, Sliding, Table};
use mtb::elasticity::half_space::Pair;
use mtb::{
    Grid, Load, Profile, STEEL, WheelOnRail, Wheelset, descent, half_spaces, tilts, unmonitored,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args()
        .nth(1)
        .map_or(std::env::temp_dir(), PathBuf::from);

    // a worn plate over a plane, free along z and about x and y
    let grid = Grid::new(30, 24, 2e-3, 2e-3)?;
    let gap = |x: f64, y: f64| 4e-6 * (x / 20e-3).powi(4) + 2e-6 * (y / 12e-3).powi(2);
    let [about_x, about_y] = tilts(grid);
    let motions = vec![descent(grid.points()), about_x, about_y];
    let plate = half_spaces(Some(STEEL), Some(STEEL), grid, gap, motions)?;
    let loads = [Load::Force(1.2e3), Load::Moments([0.0; 2])];
    let friction = |mu: f64| vec![mu; grid.points()];
    let sliding = Sliding {
        // falls from 0.35 to 0.12 between standstill and 40 m/s
        friction: Table::new(vec![0.0, 40.0], vec![friction(0.35), friction(0.12)])?,
        direction: [1.0, 0.0],
        standstill_speed: None,
        velocity: None,
        layer: 0.0,
    };
    let names = [("z", 2), ("roll", 3), ("pitch", 4)];
    let prepared = Prepared::new(
        &plate.problem,
        &plate.loading(&loads)?,
        None,
        names
            .map(|(name, component)| (name.to_owned(), Some(component)))
            .to_vec(),
        sliding,
        [0.0, 0.0, 20e-3], // the point that moments and rotations are about
        &unmonitored,
    )?;
    std::fs::write(folder.join("plate.mtbc"), prepared.to_bytes(&unmonitored)?)?;

    // two wheels of a profile of one's own would be Profile::new(y, z)
    let track = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    let steel = Pair {
        lower: Some(STEEL),
        upper: Some(STEEL),
    };
    let wheels = Wheelset::new(track, steel, 60e3)?; // N on each wheel
    std::fs::write(folder.join("wheelset.mtbw"), wheels.to_bytes())?;
    println!("wrote plate.mtbc and wheelset.mtbw to {}", folder.display());
    Ok(())
}

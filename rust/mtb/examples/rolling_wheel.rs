// SPDX-License-Identifier: MIT OR Apache-2.0
//! A wheelset with S1002 profiles rolls on 60E1 rails, yawed more and more: creep forces and heat.
//!
//! cargo run --release -p mtb --example rolling_wheel

use mtb::elasticity::half_space::Pair;
use mtb::wheelset::{Sides, Velocity};
use mtb::{PreparedWheels, Profile, STEEL, WheelOnRail, Wheelset, unmonitored};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let bodies = Pair {
        lower: Some(STEEL),
        upper: Some(STEEL),
    };
    let track = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    let mut wheels = PreparedWheels::new(Wheelset {
        sides: Sides::Both,
        spacing: [1e-3; 2],
        ..Wheelset::new(track, bodies, 60e3)?
    })?;
    println!("yaw [mrad]   Fx [N]   Fy [N]   Mz [N m]   heat [W]");
    let mut before = 0.0;
    for k in 0..=6 {
        let yaw = 1e-3 * f64::from(k);
        // height and roll from balance
        let pose = [0.0, 0.0, f64::NAN, f64::NAN, 0.0, yaw];
        let step = wheels.step(pose, Velocity::Rolling(30.0), &unmonitored)?;
        println!(
            "{:10.1} {:8.0} {:8.0} {:10.1} {:10.1}",
            1e3 * yaw,
            step.force[0],
            step.force[1],
            step.moment[2],
            step.friction_power
        );
        // yawed to the left it slips to the right, and pushes the rails that way
        assert!(step.force[1] <= before + 1e-9);
        before = step.force[1];
    }
    Ok(())
}

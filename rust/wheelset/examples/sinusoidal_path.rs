// SPDX-License-Identifier: MIT OR Apache-2.0
//! A wheelset runs through one wave of its path: 20 m long, 4 mm to either side, at 30 m/s.
//!
//! cargo run --release -p mtb-wheelset --example sinusoidal_path

use mtb_elasticity::Material;
use mtb_elasticity::half_space::Pair;
use mtb_geometry::{Profile, WheelOnRail};
use mtb_operator::unmonitored;
use mtb_wheelset::{PreparedWheels, Sides, Velocity, Wheelset};

const SPEED: f64 = 30.0;
const LENGTH: f64 = 20.0;
const AMPLITUDE: f64 = 4e-3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let steel = Material::new(80e9, 0.3)?;
    let bodies = Pair {
        lower: Some(steel),
        upper: Some(steel),
    };
    let track = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    let radius = track.wheel_radius;
    let mut wheels = PreparedWheels::new(Wheelset {
        sides: Sides::Both,
        spacing: [1e-3; 2],
        ..Wheelset::new(track, bodies, 60e3)?
    })?;
    println!("  x [m]  y [mm]  yaw [mrad]   roll [mrad]   Fx [N]   Fy [N]  Mz [N m]  heat [W]");
    let wave = std::f64::consts::TAU / LENGTH;
    let spin = SPEED / radius;
    for k in 0..=20 {
        let x = LENGTH * f64::from(k) / 20.0;
        let y = AMPLITUDE * (wave * x).sin();
        let yaw = AMPLITUDE * wave * (wave * x).cos();
        let yaw_rate = -wave * wave * y * SPEED;
        // height and roll from balance; it turns about its axle, which yaws, and rolls by what the first step finds
        let pose = [x, y, f64::NAN, f64::NAN, 0.0, yaw];
        let mut velocity = [SPEED, SPEED * yaw, 0.0, -spin * yaw, spin, yaw_rate];
        velocity[5] += spin
            * wheels
                .step(pose, Velocity::Rigid(velocity), &unmonitored)?
                .pose[3];
        let step = wheels.step(pose, Velocity::Rigid(velocity), &unmonitored)?;
        println!(
            "{x:7.1} {:7.3} {:11.3} {:13.4} {:8.0} {:8.0} {:9.0} {:9.1}",
            1e3 * y,
            1e3 * yaw,
            1e3 * step.pose[3],
            step.force[0],
            step.force[1],
            step.moment[2],
            step.friction_power
        );
    }
    Ok(())
}

use mtb_elasticity::{Material, half_space::Pair};
use mtb_geometry::{Profile, WheelOnRail};
use mtb_operator::unmonitored;
use mtb_wheelset::*;
fn main() {
    let pair = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    let steel = Some(Material::new(82e9, 0.28).unwrap());
    let bodies = Pair {
        lower: steel,
        upper: steel,
    };
    let w = Wheelset {
        spacing: [1e-3; 2],
        ..Wheelset::new(pair.clone(), bodies, 60e3).unwrap()
    };
    let mut wheels = PreparedWheels::new(w).unwrap();
    for y in [6.55, 6.58, 6.59, 6.6, 6.61, 6.62, 6.64, 6.66, 6.7] {
        for kz in 0..30 {
            let z = 0.6e-3 + 0.02e-3 * kz as f64;
            let s = match wheels.step(
                [0.0, y * 1e-3, z, 0.0, 0.0, 3e-3],
                Velocity::Rolling(20.0),
                &unmonitored,
            ) {
                Ok(s) => s,
                Err(e) => {
                    println!("{y} {:.3} {e}", z * 1e3);
                    continue;
                }
            };
            if s.patches.is_empty() {
                continue;
            }
            println!(
                "{y} {:.3} Fz {:.0} Fy {:.0} {:?}",
                z * 1e3,
                -s.force[2],
                s.force[1],
                s.patches
                    .iter()
                    .map(|p| (
                        (p.contact_angle.to_degrees() * 10.0).round() / 10.0,
                        (p.normal_force / 1e3).round(),
                        (p.neglected * 100.0).round(),
                        p.grid.nx,
                        p.grid.ny
                    ))
                    .collect::<Vec<_>>()
            );
        }
    }
}

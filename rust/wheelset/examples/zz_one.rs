use mtb_elasticity::{Material, half_space::Pair};
use mtb_geometry::{Profile, WheelOnRail};
use mtb_operator::unmonitored;
use mtb_wheelset::*;
fn main() {
    let a: Vec<f64> = std::env::args()
        .skip(1)
        .map(|s| s.parse().unwrap())
        .collect();
    let pair = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    let steel = Some(Material::new(82e9, 0.28).unwrap());
    let bodies = Pair {
        lower: steel,
        upper: steel,
    };
    let w = Wheelset {
        spacing: [1e-3; 2],
        ..Wheelset::new(pair.clone(), bodies, a[0]).unwrap()
    };
    let mut wheels = PreparedWheels::new(w).unwrap();
    let mut input = StepInput::new(
        [0.0, f64::NAN, f64::NAN, 0.0, 0.0, a[2]],
        Velocity::Rolling(20.0),
    );
    input.lateral_force = Some(a[1]);
    match wheels.step_of(&input, &unmonitored) {
        Ok(s) => println!("{:?} {:?}", s.pose, s.balance_error),
        Err(e) => println!("{e}"),
    }
    // fine scan over y at the vertical force
    for k in 0..30 {
        let y = a[3] * 1e-3 + 0.2e-6 * k as f64;
        match wheels.step(
            [0.0, y, f64::NAN, 0.0, 0.0, a[2]],
            Velocity::Rolling(20.0),
            &unmonitored,
        ) {
            Ok(s) => println!(
                "{:.5} {:.6} {:.1} {:.1e} {:?} solves {} it {}",
                y * 1e3,
                s.pose[2] * 1e3,
                s.force[1],
                s.balance_error.unwrap(),
                s.patches
                    .iter()
                    .map(|p| (
                        p.contact_angle.to_degrees(),
                        p.neglected,
                        p.grid.nx,
                        p.grid.ny,
                        p.first
                    ))
                    .collect::<Vec<_>>(),
                s.normal_solves,
                s.iterations
            ),
            Err(e) => println!("{:.5} {e}", y * 1e3),
        }
    }
}

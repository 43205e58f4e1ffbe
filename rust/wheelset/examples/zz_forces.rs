use mtb_elasticity::{Material, half_space::Pair};
use mtb_geometry::{Profile, WheelOnRail};
use mtb_operator::unmonitored;
use mtb_wheelset::*;
fn main() {
    let n: usize = std::env::args().nth(1).map_or(40, |s| s.parse().unwrap());
    let both = std::env::args().nth(2).is_some_and(|s| s == "both");
    let pair = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    let steel = Some(Material::new(82e9, 0.28).unwrap());
    let mut seed = 12345u64;
    let mut rnd = || {
        seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (seed >> 33) as f64 / (1u64 << 31) as f64
    };
    let mut ok = 0;
    let t0 = std::time::Instant::now();
    for k in 0..n {
        let q = 20e3 + 80e3 * rnd();
        let y = q * (-0.3 + 1.5 * rnd());
        let yaw = 8e-3 * (rnd() - 0.3);
        let bodies = Pair {
            lower: steel,
            upper: steel,
        };
        let w = Wheelset {
            spacing: [1e-3; 2],
            sides: if both { Sides::Both } else { Sides::Left },
            ..Wheelset::new(pair.clone(), bodies, q).unwrap()
        };
        let mut wheels = PreparedWheels::new(w).unwrap();
        let roll = if both { f64::NAN } else { 0.0 };
        let mut input = StepInput::new(
            [0.0, f64::NAN, f64::NAN, roll, 0.0, yaw],
            Velocity::Rolling(20.0),
        );
        input.lateral_force = Some(y);
        let t = std::time::Instant::now();
        match wheels.step_of(&input, &unmonitored) {
            Ok(s) => {
                ok += 1;
                let ms = t.elapsed().as_secs_f64() * 1e3;
                // a small change next
                input.lateral_force = Some(y + 0.01 * q);
                let t = std::time::Instant::now();
                let again = wheels.step_of(&input, &unmonitored);
                let ms2 = t.elapsed().as_secs_f64() * 1e3;
                println!(
                    "{k} L/V {:.3} q {q:.0} yaw {:.2} -> y {:.4} z {:.4} err {:.1e} solves {} {ms:.0} ms patches {:?} again {} {ms2:.0} ms",
                    y / q,
                    yaw * 1e3,
                    s.pose[1] * 1e3,
                    s.pose[2] * 1e3,
                    s.balance_error.unwrap(),
                    s.normal_solves,
                    s.patches
                        .iter()
                        .map(|p| p.contact_angle.to_degrees().round())
                        .collect::<Vec<_>>(),
                    again.map_or_else(
                        |e| e.to_string(),
                        |s| format!("{:.1e} {}", s.balance_error.unwrap(), s.normal_solves)
                    )
                )
            }
            Err(e) => println!(
                "{k} L/V {:.3} q {q:.0} yaw {:.2} FAIL {e} {:.0} ms",
                y / q,
                yaw * 1e3,
                t.elapsed().as_secs_f64() * 1e3
            ),
        }
    }
    println!("{ok} of {n}, {:.1} s", t0.elapsed().as_secs_f64());
}

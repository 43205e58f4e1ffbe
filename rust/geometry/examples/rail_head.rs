// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a worn wheel would meet a rail: contact points of S1002 on 60E1 as the wheelset moves sideways.

use mtb_geometry::{Profile, WheelOnRail, WheelRailLoad};

fn main() -> Result<(), mtb_geometry::Error> {
    println!("lateral [mm]  contact angle [deg]  least gap [um]");
    for lateral in [-2e-3, 0.0, 2e-3, 4e-3, 6.2e-3] {
        let pair = WheelOnRail {
            lateral,
            ..WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1())
        };
        let load = WheelRailLoad::Force {
            vertical: 36e3,
            contact_modulus: 114e9, // steel on steel
        };
        let contact = pair.contact(load)?;
        let field = pair.gap(&contact, [0.2e-3, 0.2e-3], 1.0, &mtb_geometry::unwatched)?;
        let least = field.gap.iter().copied().fold(f64::INFINITY, f64::min);
        println!(
            "{:12.1}  {:19.2}  {:14.3}",
            lateral * 1e3,
            contact.angle.to_degrees(),
            least * 1e6
        );
    }
    Ok(())
}

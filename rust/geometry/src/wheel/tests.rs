use super::*;
use crate::Interpolation;

const STEEL: f64 = 208e9 / 0.91 / 2.0;

/// A head that is one circular arc, points 10 um apart.
fn round_rail(radius: f64) -> Profile {
    let y: Vec<f64> = (-7000..=7000).map(|i| 1e-5 * f64::from(i)).collect();
    let z: Vec<f64> = y
        .iter()
        .map(|y| (radius * radius - y * y).sqrt() - radius)
        .collect();
    Profile::from_points(&y, &z, Interpolation::Smooth).unwrap()
}

/// A wheel that is a cone of slope `slope` on a round rail of 80 mm radius.
fn cone_on_circle(slope: f64) -> WheelOnRail {
    let cone = Profile::from_points(
        &[-0.1, 0.1],
        &[-0.1 * slope, 0.1 * slope],
        Interpolation::Linear,
    );
    WheelOnRail {
        rail_inclination: 0.0,
        ..WheelOnRail::new(cone.unwrap(), round_rail(0.08))
    }
}

#[test]
fn cylinder_on_round_rail_has_the_closed_gap() {
    let pair = cone_on_circle(0.0);
    let contact = pair.contact(WheelRailLoad::Approach(50e-6)).unwrap();
    assert!(contact.angle.abs() < 1e-9 && contact.origin[1].abs() < 1e-12);
    // gauge face at half the gauge: the circle is 14 mm below its top at sqrt(80^2 - 66^2)
    let half_width = (0.08_f64.powi(2) - 0.066_f64.powi(2)).sqrt();
    assert!((contact.origin[0] - (0.7175 + half_width)).abs() < 1e-9);
    let field = pair.gap(&contact, [5e-4, 2e-4], 1.5).unwrap();
    for row in 0..field.ny {
        for column in 0..field.nx {
            let x = field.start[0] + field.spacing[0] * column as f64;
            let s = field.start[1] + field.spacing[1] * row as f64;
            let exact = (0.46 - (0.46_f64 * 0.46 - x * x).sqrt())
                + (0.08 - (0.08_f64 * 0.08 - s * s).sqrt());
            let found = field.gap[row * field.nx + column];
            assert!((found - exact).abs() < 1e-12, "{x} {s}: {found} {exact}");
        }
    }
}

#[test]
fn force_estimate_is_hertz_on_a_circle() {
    // equal radii: a circular contact
    let mut pair = cone_on_circle(0.0);
    pair.wheel_radius = 0.08;
    let force = 2e3;
    let load = WheelRailLoad::Force {
        vertical: force,
        contact_modulus: STEEL,
    };
    let found = pair.contact(load).unwrap().approach;
    let exact = (0.75 * force / STEEL).powf(2.0 / 3.0) / 0.08_f64.powf(1.0 / 3.0);
    assert!((found / exact - 1.0).abs() < 2e-3, "{found} {exact}");
}

#[test]
fn cone_makes_the_contact_angle() {
    for slope in [0.05, 0.4, -0.2] {
        let pair = cone_on_circle(slope);
        let contact = pair.contact(WheelRailLoad::Approach(20e-6)).unwrap();
        let angle = f64::atan(slope);
        assert!(
            (contact.angle - angle).abs() < 2e-4,
            "{slope}: {}",
            contact.angle
        );
        // seen in its own plane the rail is the same circle, the wheel is straight across
        let field = pair.gap(&contact, [1e-4, 1e-4], 1.0).unwrap();
        let middle = field.nx / 2;
        let row = |row: usize| field.gap[row * field.nx + middle];
        let bend = (row(0) - 2.0 * row(field.ny / 2) + row(2 * (field.ny / 2)))
            / (1e-4 * (field.ny / 2) as f64).powi(2);
        assert!((bend * 0.08 - 1.0).abs() < 2e-3, "{}", bend * 0.08);
    }
}

/// Distance of the surfaces along the normal of the plane by bisection on the implicit surfaces.
fn brute_force(pair: &WheelOnRail, contact: &WheelRailContact, x: f64, s: f64) -> f64 {
    let section = Section::new(pair).unwrap();
    let (sin, cos) = contact.angle.sin_cos();
    let axle = section.height - contact.approach / cos + pair.wheel_radius;
    let point = |h: f64| {
        [
            contact.origin[0] + s * cos - h * sin,
            contact.origin[1] + s * sin + h * cos,
        ]
    };
    let under_wheel = |h: f64| {
        let [y, z] = point(h);
        let radius = pair.wheel_radius - pair.wheel.at(y - section.tape).unwrap().height;
        (axle - z).hypot(x) - radius
    };
    let (rail_sin, rail_cos) = pair.rail_inclination.sin_cos();
    let shift = section.rail.place(0.0, 0.0);
    let above_rail = |h: f64| {
        let p = point(h);
        let d = [p[0] - shift[0], p[1] - shift[1]];
        let (y, z) = (
            rail_cos * d[0] + rail_sin * d[1],
            rail_cos * d[1] - rail_sin * d[0],
        );
        z - pair.rail.at(y).unwrap().height
    };
    let bisect = |f: &dyn Fn(f64) -> f64| {
        let (mut low, mut high) = (-2e-3, 2e-3);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if (f(middle) > 0.0) == (f(high) > 0.0) {
                high = middle;
            } else {
                low = middle;
            }
        }
        low
    };
    bisect(&under_wheel) - bisect(&above_rail)
}

#[test]
fn gap_of_standard_profiles_equals_brute_force() {
    let pair = WheelOnRail {
        lateral: 6.2e-3,
        ..WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1())
    };
    let contact = pair.contact(WheelRailLoad::Approach(70e-6)).unwrap();
    let field = pair.gap(&contact, [1e-3, 4e-4], 1.2).unwrap();
    let exact = |row: usize, column: usize| {
        let x = field.start[0] + field.spacing[0] * column as f64;
        let s = field.start[1] + field.spacing[1] * row as f64;
        brute_force(&pair, &contact, x, s)
    };
    let reference = field.gap[0] - exact(0, 0);
    for row in 0..field.ny {
        for column in 0..field.nx {
            let difference = field.gap[row * field.nx + column] - exact(row, column) - reference;
            assert!(difference.abs() < 1e-13, "{row} {column}: {difference}");
        }
    }
}

#[test]
fn least_gap_is_zero_and_converges_quadratically_on_the_grid() {
    let pair = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    let contact = pair.contact(WheelRailLoad::Approach(40e-6)).unwrap();
    for spacing in [4e-4, 1e-4] {
        let field = pair.gap(&contact, [spacing; 2], 1.0).unwrap();
        let least = field.gap.iter().copied().fold(f64::INFINITY, f64::min);
        // half a spacing off, with the largest curvature at hand (1/13 mm)
        assert!(
            (0.0..(spacing * spacing) / 0.013).contains(&least),
            "{least}"
        );
    }
}

#[test]
fn jagged_profiles_stay_within_their_rounding() {
    let jagged = |profile: &Profile, from: i32, to: i32| {
        let y: Vec<f64> = (from..=to).map(|i| 1e-4 * f64::from(i)).collect();
        let z: Vec<f64> = profile
            .stations(&y)
            .unwrap()
            .iter()
            .map(|s| (s.height * 1e6).round() * 1e-6)
            .collect();
        Profile::from_points(&y, &z, Interpolation::Linear).unwrap()
    };
    let smooth = WheelOnRail {
        lateral: 6.2e-3,
        ..WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1())
    };
    let rough = WheelOnRail {
        wheel: jagged(&smooth.wheel, -690, 590),
        rail: jagged(&smooth.rail, -359, 359),
        ..smooth.clone()
    };
    let load = WheelRailLoad::Approach(70e-6);
    let contact = rough.contact(load).unwrap();
    assert!((contact.angle - smooth.contact(load).unwrap().angle).abs() < 3e-3);
    let [a, b] = [&smooth, &rough].map(|pair| pair.gap(&contact, [2e-4, 1e-4], 1.0).unwrap());
    assert_eq!((a.nx, a.ny), (b.nx, b.ny));
    for (a, b) in a.gap.iter().zip(&b.gap) {
        assert!((a - b).abs() < 4e-6, "{a} {b}");
    }
}

#[test]
fn impossible_pairs_are_named() {
    let pair = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    let load = WheelRailLoad::Approach(50e-6);
    let message = |pair: &WheelOnRail, load| pair.contact(load).unwrap_err().to_string();
    let far = WheelOnRail {
        lateral: 0.3,
        ..pair.clone()
    };
    assert!(message(&far, load).contains("never touch"));
    let deep = WheelOnRail {
        gauge_depth: 0.02,
        ..pair.clone()
    };
    assert!(message(&deep, load).contains("gauge_depth is 0.02"));
    assert!(message(&pair, WheelRailLoad::Approach(f64::NAN)).contains("approach is NaN"));
    assert!(message(&pair, WheelRailLoad::Approach(1.0)).contains("at most"));
    let heavy = WheelRailLoad::Force {
        vertical: 1e12,
        contact_modulus: STEEL,
    };
    assert!(message(&pair, heavy).contains("force is"));
    let narrow = Profile::from_points(&[-0.0005, 0.0, 0.0005], &[0.0; 3], Interpolation::Linear);
    let short = WheelOnRail {
        wheel: narrow.unwrap(),
        ..pair.clone()
    };
    assert!(message(&short, load).contains("end of the wheel profile"));
    let contact = pair.contact(load).unwrap();
    for spacing in [0.0, f64::NAN, 1.0, 1e-9] {
        let error = pair.gap(&contact, [spacing, 1e-4], 1.0).unwrap_err();
        assert!(error.to_string().contains("spacing"), "{error}");
    }
}

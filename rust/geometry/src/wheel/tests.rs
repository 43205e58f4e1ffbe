// SPDX-License-Identifier: MIT OR Apache-2.0
use super::*;
use crate::{Interpolation, root, unwatched};
use nalgebra::Vector3;
use std::sync::Arc;

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
    let field = pair.gap(&contact, [5e-4, 2e-4], 1.5, &unwatched).unwrap();
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
        let field = pair.gap(&contact, [1e-4, 1e-4], 1.0, &unwatched).unwrap();
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
    let field = pair.gap(&contact, [1e-3, 4e-4], 1.2, &unwatched).unwrap();
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
        let field = pair.gap(&contact, [spacing; 2], 1.0, &unwatched).unwrap();
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
    let [a, b] =
        [&smooth, &rough].map(|pair| pair.gap(&contact, [2e-4, 1e-4], 1.0, &unwatched).unwrap());
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
        let error = pair
            .gap(&contact, [spacing, 1e-4], 1.0, &unwatched)
            .unwrap_err();
        assert!(error.to_string().contains("spacing"), "{error}");
    }
}

/// The same pair in a pose: its centre and the direction of the axle, at the height `z` over first contact.
fn posed(pair: &WheelOnRail, over: &WheelOverRail, z: f64, yaw: f64) -> [[f64; 3]; 2] {
    let height = over.first_height() + pair.wheel_radius + z;
    [[0.0, pair.lateral, height], [-yaw.sin(), yaw.cos(), 0.0]]
}

#[test]
fn a_straight_pose_has_the_gap_of_the_pair() {
    for lateral in [0.0, 6.2e-3] {
        let pair = WheelOnRail {
            lateral,
            ..WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1())
        };
        let contact = pair.contact(WheelRailLoad::Approach(60e-6)).unwrap();
        let over = WheelOverRail::new(&pair).unwrap();
        let z = -contact.approach / contact.angle.cos();
        let [centre, axle] = posed(&pair, &over, z, 0.0);
        let overlap = over.overlap(WheelPose::new(centre, axle)).unwrap();
        // the stations miss the deepest place by a little
        assert!((overlap / -z - 1.0).abs() < 1e-3, "{overlap}");
        let planes = over
            .patches(WheelPose::new(centre, axle), [4e-4, 4e-4])
            .unwrap();
        let [plane] = planes.as_slice() else {
            panic!("{} planes", planes.len());
        };
        assert!((plane.angle - contact.angle).abs() < 2e-3);
        // the middles are weighted otherwise, which counts where the overlap is wide
        let near = if lateral > 0.0 { 1e-5 } else { 3e-4 };
        assert!((plane.position[1] - contact.origin[0]).abs() < near);
        assert!((plane.wheel_position - contact.wheel_position).abs() < near);
        // the deepest place is the approach, and the plane of the pair sees the same bodies
        let least = plane.gap.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((least / -contact.approach - 1.0).abs() < 1e-2, "{least}");
        let straight = pair
            .gap(
                &WheelRailContact {
                    angle: plane.angle,
                    origin: [plane.position[1], plane.position[2]],
                    rail_position: plane.rail_position,
                    approach: -z * plane.angle.cos(),
                    ..contact
                },
                [4e-4, 4e-4],
                1.0,
                &unwatched,
            )
            .unwrap();
        let start = straight.start.map(|s| (s / 4e-4).round() as i64);
        let mut shift = Vec::new();
        for row in 0..plane.ny {
            for column in 0..plane.nx {
                let [i, j] = [
                    column as i64 + plane.first[0] - start[0],
                    row as i64 + plane.first[1] - start[1],
                ];
                if (0..straight.nx as i64).contains(&i) && (0..straight.ny as i64).contains(&j) {
                    let there = straight.gap[j as usize * straight.nx + i as usize];
                    shift.push(plane.gap[row * plane.nx + column] - there);
                }
            }
        }
        assert!(shift.len() > 100);
        for s in &shift {
            assert!((s - shift[0]).abs() < 1e-11, "{s} {}", shift[0]);
        }
    }
}

#[test]
fn a_yawed_cylinder_touches_where_its_axle_is() {
    // a cylinder over a round head: the lowest line is yawed, the head decides where on it
    let pair = cone_on_circle(0.0);
    let over = WheelOverRail::new(&pair).unwrap();
    let yaw = 0.02;
    let [centre, axle] = posed(&pair, &over, -40e-6, yaw);
    let [plane] = &over
        .patches(WheelPose::new(centre, axle), [5e-4, 5e-4])
        .unwrap()[..]
    else {
        panic!("one plane");
    };
    let seat = plane.position[1];
    let crown = 0.7175 + (0.08_f64.powi(2) - 0.066_f64.powi(2)).sqrt();
    assert!((plane.position[0] + seat * yaw.tan()).abs() < 1e-6);
    assert!((seat - crown).abs() < 1e-4 && plane.angle.abs() < 1e-3);
    for row in 0..plane.ny {
        for column in 0..plane.nx {
            let x = 5e-4 * (column as i64 + plane.first[0]) as f64;
            let y = 5e-4 * (row as i64 + plane.first[1]) as f64;
            let ahead = (plane.position[0] + x) * yaw.cos() + (seat + y) * yaw.sin();
            let wheel = 0.46 - (0.46_f64 * 0.46 - ahead * ahead).sqrt();
            let aside = seat + y - crown;
            let head = 0.08 - (0.08_f64 * 0.08 - aside * aside).sqrt();
            let gap = plane.gap[row * plane.nx + column];
            assert!((gap - (wheel + head - 40e-6)).abs() < 1e-8, "{x} {y} {gap}");
        }
    }
}

#[test]
fn wheels_off_their_rail_are_named() {
    let pair = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    let over = WheelOverRail::new(&pair).unwrap();
    let [mut centre, axle] = posed(&pair, &over, 0.0, 0.0);
    let message = |result: Result<Vec<PlaneGap>, Error>| result.unwrap_err().to_string();
    let fine = [1e-7, 1e-7];
    centre[2] -= 1e-4;
    let found = message(over.patches(WheelPose::new(centre, axle), fine));
    assert!(found.starts_with("the contact takes "), "{found}");
    let found = message(over.patches(WheelPose::new(centre, axle), [1e-3, f64::NAN]));
    assert!(found.starts_with("spacing across is NaN"), "{found}");
    let found = message(over.patches(WheelPose::new(centre, [1.0, 0.0, 0.0]), [1e-3; 2]));
    assert!(
        found.contains("a unit vector that points to the left"),
        "{found}"
    );
    centre[1] = 0.3;
    let found = message(over.patches(WheelPose::new(centre, axle), [1e-3; 2]));
    assert!(found.contains("nowhere above the head"), "{found}");
    centre[1] = f64::NAN;
    assert!(matches!(
        over.overlap(WheelPose::new(centre, axle)),
        Err(Error::NotFinite { .. })
    ));
    let wide = Profile::from_points(&[-20.0, 20.0], &[0.0, 1.0], Interpolation::Linear).unwrap();
    let pair = WheelOnRail {
        wheel: wide,
        ..pair
    };
    let found = WheelOverRail::new(&pair).unwrap_err().to_string();
    assert!(found.starts_with("wheel profile is 40"), "{found}");
}

#[test]
fn changes_of_a_plane_are_its_differences() {
    for roller_radius in [None, Some(0.2)] {
        let pair = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
        changes_are_differences(&WheelOnRail {
            roller_radius,
            ..pair
        });
    }
}

fn changes_are_differences(pair: &WheelOnRail) {
    let over = WheelOverRail::new(pair).unwrap();
    let spacing = [1e-3, 1e-3];
    let axle_of =
        |yaw: f64, roll: f64| [-yaw.sin() * roll.cos(), yaw.cos() * roll.cos(), roll.sin()];
    let mut planes_seen = 0;
    // tread, near the flange, flange; yawed both ways
    for (y, yaw, roll) in [
        (0.361e-3, 0.002, 0.0),
        (1.3e-3, 0.004, 0.001),
        (4.1e-3, -0.01, -0.002),
        (6.4e-3, 0.02, 0.0005),
        (-3.2e-3, 0.007, 0.0),
    ] {
        let mut centre = [0.01, y, over.first_height() + pair.wheel_radius];
        centre[2] += over
            .overlap(WheelPose::new(centre, axle_of(yaw, roll)))
            .unwrap()
            - 60e-6;
        let planes_at = |moved: [f64; 5]| {
            let centre = [0, 1, 2].map(|c| centre[c] + moved[c]);
            let axle = axle_of(yaw + moved[3], roll + moved[4]);
            over.patches(WheelPose::new(centre, axle), spacing).unwrap()
        };
        let here = planes_at([0.0; 5]);
        for (which, longest) in [1e-7, 1e-7, 1e-7, 1e-6, 1e-7].into_iter().enumerate() {
            // a station passes a sample of the head, or comes to the overlap, within some of these
            let steps = [longest, 0.2 * longest, 0.04 * longest];
            let by_axle = match which {
                3 => [-yaw.cos() * roll.cos(), -yaw.sin() * roll.cos(), 0.0],
                4 => [yaw.sin() * roll.sin(), -yaw.cos() * roll.sin(), roll.cos()],
                _ => [0.0; 3],
            };
            let mut by_centre = [0.0; 3];
            if which < 3 {
                by_centre[which] = 1.0;
            }
            let at = steps.map(|step| {
                [-1.0, -0.5, 0.5, 1.0].map(|share| {
                    let mut moved = [0.0; 5];
                    moved[which] = share * step;
                    planes_at(moved)
                })
            });
            for (k, plane) in here.iter().enumerate() {
                planes_seen += 1;
                let pose = WheelPose::new(centre, axle_of(yaw, roll));
                let by = WheelPose::new(by_centre, by_axle);
                let found = over.change(plane, pose, spacing, by).unwrap();
                // central differences with Richardson's extrapolation
                let check = |name: &str, found: f64, value: &dyn Fn(&PlaneGap) -> f64| {
                    let truths = [0, 1, 2].map(|step: usize| {
                        let [a, b, c, d] = [0, 1, 2, 3].map(|i| value(&at[step][i][k]));
                        (8.0 * (c - b) - (d - a)) / (6.0 * steps[step])
                    });
                    let is_met = |truth: &f64| (found - truth).abs() < 1e-6 * truth.abs().max(1.0);
                    let radius = pair.roller_radius;
                    assert!(
                        truths.iter().any(is_met),
                        "{name} at y = {y} by {which} on {radius:?}: {found} is not {truths:?}"
                    );
                };
                check("roller", found.roller_angle, &|p| p.roller_angle);
                check("z", found.position[2], &|p| p.position[2]);
                for (c, name) in ["x", "y", "z"].into_iter().enumerate() {
                    check(name, found.position[c], &|p| p.position[c]);
                }
                check("angle", found.angle, &|p| p.angle);
                check("rail", found.rail_position, &|p| p.rail_position);
                check("wheel", found.wheel_position, &|p| p.wheel_position);
                for row in (0..plane.ny).step_by(4) {
                    let of =
                        move |p: &PlaneGap| (row as i64 + plane.first[1] - p.first[1]) as usize;
                    check("row", found.rail_positions[row], &|p| {
                        p.rail_positions[of(p)]
                    });
                    for column in (0..plane.nx).step_by(5) {
                        let there = move |p: &PlaneGap| {
                            (column as i64 + plane.first[0] - p.first[0]) as usize
                        };
                        let i = row * plane.nx + column;
                        check("gap", found.gap[i], &|p| p.gap[of(p) * p.nx + there(p)]);
                    }
                }
            }
        }
    }
    assert!(planes_seen >= 25);
}

/// A rail whose head sinks, shifts and widens along the track.
fn varying_rail() -> Arc<Slices> {
    let rail = Profile::rail_60e1();
    let positions: Vec<f64> = (0..=12).map(|k| 0.05 * f64::from(k)).collect();
    let sections: Vec<Profile> = (positions.iter())
        .map(|s| {
            let y: Vec<f64> = (-300..=300).map(|k| 1e-4 * f64::from(k)).collect();
            let lower = 0.2e-3 * (8.0 * s).sin();
            let z: Vec<f64> = (y.iter())
                .map(|y| {
                    rail.at(y + 0.5e-3 * (6.0 * s).cos()).unwrap().height - lower - 0.3 * s * y * y
                })
                .collect();
            Profile::from_points(&y, &z, Interpolation::Smooth).unwrap()
        })
        .collect();
    Arc::new(Slices::new(&rail, &positions, &sections, &[], false).unwrap())
}

/// A wheel of which the radius varies around it.
fn varying_wheel() -> Arc<Slices> {
    let wheel = Profile::wheel_s1002();
    let angles: Vec<f64> = (0..24)
        .map(|k| f64::from(k) * std::f64::consts::TAU / 24.0)
        .collect();
    let heights: Vec<f64> = (angles.iter()).map(|a| 0.3e-3 * (3.0 * a).sin()).collect();
    Arc::new(Slices::raised(&wheel, &angles, &heights, true).unwrap())
}

/// Planes turn by steps where places along the track come to a footprint or leave it: most small differences meet none,
/// and larger ones run over some.
#[test]
fn changes_of_slices_are_differences() {
    let mut missed: [Vec<f64>; 2] = Default::default();
    for (has_wheel, has_rail, roller_radius) in [
        (true, false, None),
        (false, true, None),
        (true, true, None),
        (true, false, Some(0.8)),
    ] {
        let pair = WheelOnRail {
            roller_radius,
            wheel_slices: has_wheel.then(varying_wheel),
            rail_slices: has_rail.then(varying_rail),
            ..WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1())
        };
        let over = WheelOverRail::new(&pair).unwrap();
        for (y, yaw, roll, turn) in [
            (0.4e-3, 0.002, 0.0, 0.3),
            (4.1e-3, -0.01, -0.002, 2.0),
            (-3e-3, 0.007, 0.0, 4.0),
        ] {
            let ahead = if roller_radius.is_some() { 0.01 } else { 0.21 };
            let mut centre = [ahead, y, over.first_height() + pair.wheel_radius];
            let pose_at = |centre: [f64; 3], moved: [f64; 6]| {
                let [yaw, roll] = [yaw + moved[3], roll + moved[4]];
                WheelPose {
                    centre: [0, 1, 2].map(|c| centre[c] + moved[c]),
                    axle: [-yaw.sin() * roll.cos(), yaw.cos() * roll.cos(), roll.sin()],
                    turn: turn + moved[5],
                }
            };
            centre[2] += over.overlap(pose_at(centre, [0.0; 6])).unwrap() - 60e-6;
            let planes_at =
                |moved: [f64; 6]| over.patches(pose_at(centre, moved), [1e-3; 2]).unwrap();
            let here = planes_at([0.0; 6]);
            for (which, step) in [2e-5, 1e-5, 1e-6, 2e-5, 1e-5, 1e-4].into_iter().enumerate() {
                let mut by = WheelPose::new([0.0; 3], [0.0; 3]);
                match which {
                    3 => by.axle = [-yaw.cos() * roll.cos(), -yaw.sin() * roll.cos(), 0.0],
                    4 => by.axle = [yaw.sin() * roll.sin(), -yaw.cos() * roll.sin(), roll.cos()],
                    5 => by.turn = 1.0,
                    _ => by.centre[which] = 1.0,
                }
                for (missed, step) in missed.iter_mut().zip([0.01 * step, step]) {
                    let at = [-step, step].map(|step| {
                        let mut moved = [0.0; 6];
                        moved[which] = step;
                        planes_at(moved)
                    });
                    for (k, plane) in here.iter().enumerate() {
                        let pose = pose_at(centre, [0.0; 6]);
                        let found = over.change(plane, pose, [1e-3; 2], by).unwrap();
                        let mut check = |found: f64, value: &dyn Fn(&PlaneGap) -> f64| {
                            let truth = (value(&at[1][k]) - value(&at[0][k])) / (2.0 * step);
                            missed.push((found - truth).abs() / truth.abs().max(1e-3));
                        };
                        check(found.roller_angle, &|p| p.roller_angle);
                        check(found.position[1], &|p| p.position[1]);
                        check(found.position[2], &|p| p.position[2]);
                        check(found.angle, &|p| p.angle);
                        check(found.rail_position, &|p| p.rail_position);
                        check(found.wheel_position, &|p| p.wheel_position);
                        for (row, column) in [(2, 2), (1, 2), (3, 1)] {
                            let (row, column) = (plane.ny * row / 4, plane.nx * column / 4);
                            check(found.gap[row * plane.nx + column], &|p| {
                                let row = row as i64 + plane.first[1] - p.first[1];
                                let column = column as i64 + plane.first[0] - p.first[0];
                                p.gap[row as usize * p.nx + column as usize]
                            });
                        }
                    }
                }
            }
        }
    }
    let [small, large] = missed.map(|mut missed| {
        missed.sort_by(f64::total_cmp);
        [0.5, 0.9].map(|share| missed[(share * missed.len() as f64) as usize])
    });
    assert!(small[0] < 1e-5, "{small:?}");
    assert!(large[0] < 5e-3 && large[1] < 5e-2, "{large:?}");
}

/// Pairs with slices on either or both, plain ones, and such on a roller.
fn pairs_of_all_kinds() -> Vec<WheelOnRail> {
    [
        (false, false, None),
        (true, false, None),
        (false, true, None),
        (true, true, None),
        (false, false, Some(0.8)),
        (true, false, Some(0.8)),
    ]
    .into_iter()
    .map(|(has_wheel, has_rail, roller_radius)| WheelOnRail {
        roller_radius,
        wheel_slices: has_wheel.then(varying_wheel),
        rail_slices: has_rail.then(varying_rail),
        ..WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1())
    })
    .collect()
}

#[test]
fn changes_of_the_overlap_are_its_differences() {
    for pair in pairs_of_all_kinds() {
        let over = WheelOverRail::new(&pair).unwrap();
        let ahead = if pair.roller_radius.is_some() {
            0.01
        } else {
            0.21
        };
        for (y, yaw, roll, deep) in [
            (0.4e-3, 0.002, 0.0, 60e-6),
            (4.1e-3, -0.01, -0.002, -2e-3),
            (-3e-3, 0.007, 0.0, 0.3e-3),
        ] {
            let axle =
                |yaw: f64, roll: f64| [-yaw.sin() * roll.cos(), yaw.cos() * roll.cos(), roll.sin()];
            let pose_at = |moved: [f64; 6]| WheelPose {
                centre: [ahead + moved[0], y + moved[1], pair.wheel_radius + moved[2]],
                axle: axle(yaw + moved[3], roll + moved[4]),
                turn: 0.3 + moved[5],
            };
            let height = over.overlap(pose_at([0.0; 6])).unwrap() - deep;
            let overlap_at = |mut moved: [f64; 6]| {
                moved[2] += height;
                over.overlap(pose_at(moved)).unwrap()
            };
            let mut pose = pose_at([0.0; 6]);
            pose.centre[2] += height;
            let mut by = [WheelPose::new([0.0; 3], [0.0; 3]); 6];
            for (k, by) in by.iter_mut().enumerate() {
                match k {
                    3 => by.axle = [-yaw.cos() * roll.cos(), -yaw.sin() * roll.cos(), 0.0],
                    4 => by.axle = [yaw.sin() * roll.sin(), -yaw.cos() * roll.sin(), roll.cos()],
                    5 => by.turn = 1.0,
                    _ => by.centre[k] = 1.0,
                }
            }
            let found = over.overlap_change(pose, &by).unwrap();
            for (k, found) in found.into_iter().enumerate() {
                let step = 1e-8;
                let [back, on] = [-step, step].map(|step| {
                    let mut moved = [0.0; 6];
                    moved[k] = step;
                    overlap_at(moved)
                });
                let truth = (on - back) / (2.0 * step);
                assert!(
                    (found - truth).abs() < 1e-4 * truth.abs().max(0.1),
                    "{k}: {found}, differences {truth}"
                );
            }
        }
    }
}

#[test]
fn planes_with_slices_do_not_depend_on_the_heights_asked_before() {
    for pair in pairs_of_all_kinds() {
        let [over, fresh] = [0, 1].map(|_| WheelOverRail::new(&pair).unwrap());
        let ahead = if pair.roller_radius.is_some() {
            0.01
        } else {
            0.21
        };
        let pose = |z: f64| {
            WheelPose::new(
                [ahead, 1e-3, pair.wheel_radius + z],
                [-0.003_f64.sin(), 0.003_f64.cos(), 0.0],
            )
        };
        let touches = over.overlap(pose(0.0)).unwrap();
        for deep in [1e-4, 5e-4, 2e-5, -3e-3, 8e-5] {
            let z = touches - deep;
            let spacing = [1e-3; 2];
            let [found, own] = [&over, &fresh.clone()].map(|over| {
                let overlap = over.overlap(pose(z)).unwrap();
                (overlap, over.patches(pose(z), spacing).unwrap())
            });
            assert!((found.0 - own.0).abs() < 1e-15);
            assert_eq!(found.1.len(), own.1.len());
            for (found, own) in found.1.iter().zip(&own.1) {
                let gaps = found.gap.iter().zip(&own.gap);
                assert!(gaps.clone().count() > 0 && found.gap.len() == own.gap.len());
                assert!(gaps.fold(0.0, |most, (a, b)| f64::max(most, (a - b).abs())) < 1e-12);
                // slopes are those at the last step to the place below
                assert!((found.angle - own.angle).abs() < 1e-8);
            }
        }
    }
}

#[test]
fn a_wheelset_of_cones_has_radii_that_differ_by_twice_the_slope() {
    let slope = 0.05;
    let pairs = [cone_on_circle(slope), cone_on_circle(slope)];
    let shifts = [-4e-3, 0.0, 3e-3];
    let level = StandingWheelset::over_shifts(&pairs, Axle::Level, &shifts, &unwatched).unwrap();
    for (shift, standing) in shifts.iter().zip(&level) {
        let difference = standing.left.rolling_radius - standing.right.rolling_radius;
        assert!((difference - 2.0 * slope * shift).abs() < 1e-9, "{shift}");
        assert!((standing.left.angle.tan() - slope).abs() < 1e-6);
        assert!(standing.roll == 0.0);
    }
    // both wheels touch, the left one higher where it runs on a larger radius
    let free = StandingWheelset::over_shifts(&pairs, Axle::Free, &shifts, &unwatched).unwrap();
    for (shift, standing) in shifts.iter().zip(&free) {
        assert!((standing.left.clearance - standing.right.clearance).abs() < 1e-11);
        assert!(shift * standing.roll >= 0.0 && standing.roll.abs() < 1e-3);
    }
    let far = StandingWheelset::over_shifts(&pairs, Axle::Free, &[0.5], &unwatched);
    assert!(
        far.unwrap_err()
            .to_string()
            .starts_with("at a lateral shift of 0.5 m: ")
    );
}

/// A roller under a wheel at a pose, with surfaces of its own: how deep a place lies in them, along their radii [m].
struct Round<'a> {
    pair: &'a WheelOnRail,
    over: &'a WheelOverRail,
    centre: Vector3<f64>,
    axle: Vector3<f64>,
}

impl Round<'_> {
    /// Of the rail placed by a roller of radius `r`: inclination, then shift.
    fn below(&self, at: Vector3<f64>) -> f64 {
        let radius = self.pair.roller_radius.unwrap();
        let up = (at.x.powi(2) + (at.z + radius).powi(2)).sqrt() - radius;
        let [y0, z0] = self.over.rail_origin();
        let (sin, cos) = self.pair.rail_inclination.sin_cos();
        let (y, z) = (at.y - y0, up - z0);
        let own = [cos * y + sin * z, cos * z - sin * y];
        let Some(rail) = self.pair.rail.at(own[0]) else {
            return f64::NEG_INFINITY;
        };
        // of the turned profile along z, to first order
        (rail.height - own[1]) / (cos - sin * rail.slope)
    }

    fn wheel(&self, at: Vector3<f64>) -> f64 {
        let from = at - self.centre;
        let along = self.axle.dot(&from);
        let radius = (from - self.axle * along).norm();
        self.pair.wheel_radius
            - self.pair.wheel.at(along - self.over.tape()).unwrap().height
            - radius
    }

    /// Where a function of the way along a normal passes zero.
    fn root(of: impl Fn(f64) -> f64) -> f64 {
        let (mut low, mut high) = (-3e-3, 3e-3);
        assert!(of(low) * of(high) < 0.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if of(low) * of(middle) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }
}

#[test]
fn a_wheel_meets_its_roller_where_they_are_nearest() {
    // tread and flange, yawed, rolled, ahead of the axis of the roller
    for [y, yaw, roll, ahead, radius] in [
        [0.0_f64, 0.02, 0.0, 0.0, 0.2],
        [4e-3, -0.01, 2e-3, 5e-3, 0.3],
        [6.6e-3, 0.03, 1e-3, -0.02, 0.15],
    ] {
        let pair = WheelOnRail {
            roller_radius: Some(radius),
            ..WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1())
        };
        let over = WheelOverRail::new(&pair).unwrap();
        let axle = Vector3::new(-yaw.sin() * roll.cos(), yaw.cos() * roll.cos(), roll.sin());
        let mut centre = Vector3::new(ahead, y, over.first_height() + pair.wheel_radius);
        let pose = |centre: Vector3<f64>| WheelPose::new(centre.into(), axle.into());
        for _ in 0..4 {
            centre.z += over.overlap(pose(centre)).unwrap() - 40e-6;
        }
        let round = Round {
            pair: &pair,
            over: &over,
            centre,
            axle,
        };
        // all places of the wheel
        let along = (Vector3::x() - axle * axle.x).normalize();
        let down = axle.cross(&along);
        let deepest = |position: f64| {
            let at = |angle: f64| {
                let radius = pair.wheel_radius - pair.wheel.at(position).unwrap().height;
                centre
                    + axle * (over.tape() + position)
                    + (down * angle.cos() + along * angle.sin()) * radius
            };
            let angle = root::minimum(|angle| -round.below(at(angle)), [-0.3, 0.3]);
            round.below(at(angle))
        };
        let range = (-450..300).map(|k| 1e-4 * f64::from(k));
        let most = range.map(deepest).fold(f64::NEG_INFINITY, f64::max);
        let overlap = over.overlap(pose(centre)).unwrap();
        // the head is a polygon, whose chords lie that far below the arc of a gauge corner
        let sagitta = if y > 5e-3 { 3e-6 } else { 1e-8 };
        assert!((overlap - most).abs() < sagitta, "{y}: {overlap} {most}");

        let spacing = [1e-3, 5e-4];
        let planes = over.patches(pose(centre), spacing).unwrap();
        for plane in &planes {
            let origin = Vector3::from(plane.position);
            assert!(round.below(origin).abs() < 1e-12);
            // the plane contains the direction around the roller, and its normal meets the axis of the roller
            let (sin, cos) = plane.roller_angle.sin_cos();
            let round_it = Vector3::new(cos, 0.0, -sin);
            let out = Vector3::new(sin, 0.0, cos);
            assert!((origin.x * cos - (origin.z + radius) * sin).abs() < 1e-12);
            let normal = out * plane.angle.cos() - Vector3::y() * plane.angle.sin();
            let across = Vector3::y() * plane.angle.cos() + out * plane.angle.sin();
            let mut seen = 0;
            for (k, gap) in plane.gap.iter().enumerate().filter(|(_, g)| **g < 1e-3) {
                let [i, j] = [k % plane.nx, k / plane.nx];
                let foot = origin
                    + round_it * (spacing[0] * (i as i64 + plane.first[0]) as f64)
                    + across * (spacing[1] * (j as i64 + plane.first[1]) as f64);
                let rail = Round::root(|t| round.below(foot + normal * t));
                let wheel = Round::root(|t| round.wheel(foot + normal * t));
                assert!(
                    (gap - (wheel - rail)).abs() < 1e-11,
                    "{gap} {}",
                    wheel - rail
                );
                seen += 1;
            }
            assert!(seen > 20);
        }
        assert!(!planes.is_empty());
    }
}

#[test]
fn a_large_roller_is_a_rail() {
    let pair = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    let planes = |roller_radius: Option<f64>, yaw: f64| {
        let pair = WheelOnRail {
            roller_radius,
            ..pair.clone()
        };
        let over = WheelOverRail::new(&pair).unwrap();
        let mut centre = [0.0, 5e-3, over.first_height() + pair.wheel_radius];
        let axle = [-yaw.sin(), yaw.cos(), 0.0];
        centre[2] -= 1e-4 - over.overlap(WheelPose::new(centre, axle)).unwrap();
        over.patches(WheelPose::new(centre, axle), [1e-3; 2])
            .unwrap()
    };
    let off = |radius: f64| {
        let [found, rail] = [Some(radius), None].map(|radius| planes(radius, 0.02)[0].clone());
        let way = found.position[0] - rail.position[0];
        let [found, rail] = [Some(radius), None].map(|radius| planes(radius, 0.0)[0].clone());
        let gap =
            |p: &PlaneGap, i: i64| p.gap[(-p.first[1] * p.nx as i64 - p.first[0] + i) as usize];
        [way, (gap(&found, 4) - gap(&rail, 4)) / rail.angle.cos()]
    };
    // of the first order in the curvature
    let [near, far] = [off(1e2), off(1e4)];
    for (near, far) in near.into_iter().zip(far) {
        assert!((near / far / 100.0 - 1.0).abs() < 0.03, "{near} {far}");
    }
    // the gap of circles, at 4 mm from their touch
    assert!((far[1] / (16e-6 / 2e4) - 1.0).abs() < 0.1, "{}", far[1]);
}

#[test]
fn cylinders_have_the_gap_of_two_circles() {
    let pair = WheelOnRail {
        roller_radius: Some(0.3),
        ..cone_on_circle(0.0)
    };
    let contact = pair.contact(WheelRailLoad::Approach(50e-6)).unwrap();
    let field = pair.gap(&contact, [5e-4, 2e-4], 1.5, &unwatched).unwrap();
    for (k, found) in field.gap.iter().enumerate() {
        let x = field.start[0] + field.spacing[0] * (k % field.nx) as f64;
        let s = field.start[1] + field.spacing[1] * (k / field.nx) as f64;
        // the head of the roller is a torus
        let head = 0.22 + (0.08_f64 * 0.08 - s * s).sqrt();
        let roller = 0.3 - (head * head - x * x).sqrt();
        let exact = 0.46 - (0.46_f64 * 0.46 - x * x).sqrt() + roller;
        assert!((found - exact).abs() < 1e-12, "{x} {s}: {found} {exact}");
    }
    let uneven = WheelOnRail {
        roller_radius: Some(-0.3),
        ..pair
    };
    let found = WheelOverRail::new(&uneven).unwrap_err().to_string();
    assert!(found.starts_with("roller_radius is -0.3"), "{found}");
}

#[test]
fn the_tape_circle_of_a_worn_wheel_is_smaller() {
    let new = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    assert_eq!(new.tape_radius(), new.wheel_radius);
    let (y, mut z): (Vec<f64>, Vec<f64>) = (-60..=50)
        .map(|k| 1e-3 * f64::from(k))
        .map(|y| (y, new.wheel.at(y).unwrap().height + 1e-3))
        .unzip();
    let worn = |z: &[f64]| WheelOnRail {
        wheel: Profile::from_points(&y, z, crate::Interpolation::Smooth).unwrap(),
        ..new.clone()
    };
    assert!((worn(&z).tape_radius() - (new.wheel_radius - 1e-3)).abs() < 1e-12);
    for z in &mut z {
        *z += 0.3;
    }
    let said = WheelOverRail::new(&worn(&z)).unwrap_err().to_string();
    assert!(
        said.starts_with("z of the wheel profile at y = 0 is 0.301"),
        "{said}"
    );
}

#[test]
fn wheels_much_smaller_than_their_profiles_are_refused() {
    let mut pair = WheelOnRail::new(Profile::wheel_s1002(), Profile::rail_60e1());
    for radius in [1e-300, 1e-9, 1e-3] {
        pair.wheel_radius = radius;
        let said = WheelOverRail::new(&pair).unwrap_err().to_string();
        assert!(said.contains("wheel_radius"), "{said}");
        assert!(said.contains("beside this wheel profile"), "{said}");
    }
}

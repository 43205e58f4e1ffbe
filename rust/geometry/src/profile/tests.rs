// SPDX-License-Identifier: MIT OR Apache-2.0
// reason: values that must be exact are compared exactly
#![allow(clippy::float_cmp)]

use super::*;
use proptest::prelude::*;

#[test]
fn rail_closes_where_the_standard_says() {
    let rail = Profile::rail_60e1();
    let [start, end] = rail.range();
    assert!((end - 36.000e-3).abs() < 5e-7, "half-width {end}");
    assert_eq!(start, -end);
    let flank = rail.at(end).unwrap();
    assert!((flank.height + 14.300e-3).abs() < 5e-7, "{}", flank.height);
    assert!((flank.slope + 20.0).abs() < 1e-6, "{}", flank.slope);
    assert_eq!(rail.at(0.0).unwrap().height, 0.0);
}

#[test]
fn arcs_of_the_rail_join_tangentially() {
    let rail = Profile::rail_60e1();
    for (break_at, radii) in [(10.228e-3, [0.3, 0.08]), (26.027e-3, [0.08, 0.013])] {
        for side in [-1.0, 1.0] {
            let below = rail.at(side * (break_at - 1e-12)).unwrap();
            let above = rail.at(side * (break_at + 1e-12)).unwrap();
            assert!((below.height - above.height).abs() < 1e-11);
            assert!((below.slope - above.slope).abs() < 1e-9);
            assert!((below.curvature() + 1.0 / radii[0]).abs() < 1e-8);
            assert!((above.curvature() + 1.0 / radii[1]).abs() < 1e-6);
        }
    }
}

#[test]
fn wheel_is_continuous_to_the_coefficients_own_jumps() {
    let wheel = Profile::wheel_s1002();
    for y in &wheel.breaks()[1..8] {
        let jump = wheel.at(y - 1e-12).unwrap().height - wheel.at(y + 1e-12).unwrap().height;
        assert!(jump.abs() < 1.3e-7, "jump {jump} at {y}");
    }
    // EN 13715: flange tip 28 mm below the tape circle, tape circle at zero
    assert!((wheel.at(-0.055).unwrap().height + 0.028).abs() < 1e-12);
    assert_eq!(wheel.at(0.0).unwrap().height, 0.0);
}

#[test]
fn derivatives_are_those_of_the_height() {
    let h = 1e-6;
    for profile in [Profile::rail_60e1(), Profile::wheel_s1002()] {
        for y in [-0.0333, -0.0301, -0.018, -0.004, 0.0, 0.013, 0.0299] {
            let [a, b, c] = [y - h, y, y + h].map(|y| profile.at(y).unwrap());
            assert!(
                ((c.height - a.height) / (2.0 * h) - b.slope).abs() < 2e-6 * (1.0 + b.bend.abs())
            );
            assert!(((c.slope - a.slope) / (2.0 * h) - b.bend).abs() < 1e-4 * (1.0 + b.bend.abs()));
        }
    }
}

#[test]
fn arc_length_of_the_crown_is_radius_times_angle() {
    let rail = Profile::rail_60e1();
    let s = rail.arc_length(&[-0.01, 0.0, 0.01]).unwrap();
    let exact = 0.3 * (0.01_f64 / 0.3).asin();
    assert!((s[2] - exact).abs() < 1e-16 && (s[0] + exact).abs() < 1e-16);
    assert_eq!(s[1], 0.0);
}

fn parabola(n: usize, interpolation: Interpolation) -> Profile {
    let y: Vec<f64> = (0..n)
        .map(|i| 0.08 * (i as f64 / (n - 1) as f64 - 0.5))
        .collect();
    let z: Vec<f64> = y.iter().map(|y| (40.0 * y).sin() * 0.01).collect();
    Profile::from_points(&y, &z, interpolation).unwrap()
}

#[test]
fn spline_is_of_fourth_order_and_lines_of_second() {
    for (interpolation, order) in [(Interpolation::Smooth, 4.0), (Interpolation::Linear, 2.0)] {
        let error = |n: usize| {
            let profile = parabola(n, interpolation);
            (0..1000)
                .map(|i| -0.04 + 0.08 * (f64::from(i) + 0.5) / 1000.0)
                .map(|y| (profile.at(y).unwrap().height - 0.01 * (40.0 * y).sin()).abs())
                .fold(0.0, f64::max)
        };
        let rate = (error(41) / error(81)).log2();
        assert!(
            (rate - order).abs() < 0.25,
            "{interpolation:?}: rate {rate}"
        );
    }
}

#[test]
fn cubic_table_is_reproduced_exactly() {
    let y = [-0.03, -0.01, 0.005, 0.006, 0.02];
    let f = |y: f64| 0.3 + y * (2.0 + y * (-70.0 + 900.0 * y));
    let profile = Profile::from_points(&y, &y.map(f), Interpolation::Smooth).unwrap();
    for y in [-0.029, -0.0123, 0.0055, 0.0199] {
        assert!((profile.at(y).unwrap().height - f(y)).abs() < 1e-15);
    }
    let two = Profile::from_points(&[1.0, 0.0], &[5.0, 3.0], Interpolation::Smooth).unwrap();
    assert_eq!(two.at(0.5).unwrap().height, 4.0);
    let three = Profile::from_points(&[0.0, 1.0, 3.0], &[0.0, 1.0, 9.0], Interpolation::Smooth);
    assert!((three.unwrap().at(2.0).unwrap().height - 4.0).abs() < 1e-14);
}

#[test]
fn bad_tables_are_named() {
    let bad = |y: &[f64], z: &[f64]| {
        Profile::from_points(y, z, Interpolation::Smooth)
            .unwrap_err()
            .to_string()
    };
    assert!(bad(&[0.0], &[0.0]).contains("at least 2 points"));
    assert!(bad(&[0.0, 1.0], &[0.0]).contains("one for each y"));
    assert!(bad(&[0.0, f64::NAN], &[0.0, 1.0]).contains("y[1] is NaN"));
    assert!(bad(&[0.0, 1.0, 1.0], &[0.0; 3]).contains("row 3"));
    let rail = Profile::rail_60e1();
    let outside = rail.stations(&[0.0, 0.05]).unwrap_err().to_string();
    assert!(outside.contains("y[1] is 0.05 m"), "{outside}");
    assert!(rail.position(&[f64::INFINITY]).is_err());
}

proptest! {
    #[test]
    fn position_inverts_arc_length(t in 0.0..1.0_f64) {
        for profile in [
            Profile::rail_60e1(),
            Profile::wheel_s1002(),
            parabola(20, Interpolation::Smooth),
            parabola(20, Interpolation::Linear),
        ] {
            let [start, end] = profile.range();
            let y = start + t * (end - start);
            let s = profile.arc_length(&[y]).unwrap();
            let back = profile.position(&s).unwrap()[0];
            // where the flank is vertical, position is ill-conditioned but arc length is not
            let again = profile.arc_length(&[back]).unwrap()[0];
            prop_assert!((again - s[0]).abs() < 1e-13, "{y}: {again} {}", s[0]);
        }
    }
}

/// Numbers of every size, also those that are none.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![-40.0..40.0_f64, prop::num::f64::ANY]
}

/// What a profile that was accepted must hold: finite heights, slopes and arc lengths from end to end.
fn is_sound(profile: &Profile) -> bool {
    let [start, end] = profile.range();
    (0..=8).all(|k| {
        let y = if k == 8 {
            end
        } else {
            start + f64::from(k) / 8.0 * (end - start)
        };
        let finite = profile.at(y).is_some_and(|s| {
            s.height.is_finite() && s.slope.is_finite() && s.curvature().is_finite()
        });
        finite && profile.arc_length(&[y]).is_ok_and(|s| s[0].is_finite())
    })
}

proptest! {
    #![proptest_config(ProptestConfig::default())]

    #[test]
    fn any_points_make_a_sound_profile_or_none(
        mut y in prop::collection::vec(any_number(), 0..8),
        z in prop::collection::vec(any_number(), 0..8),
        ordered in any::<bool>(),
        linear in any::<bool>(),
    ) {
        if ordered {
            y.sort_by(f64::total_cmp);
        }
        let kind = if linear { Interpolation::Linear } else { Interpolation::Smooth };
        if let Ok(profile) = Profile::from_points(&y, &z, kind) {
            prop_assert!(is_sound(&profile), "{y:?} {z:?}");
        }
    }

    #[test]
    fn any_text_makes_a_sound_profile_or_none(
        lines in prop::collection::vec(
            prop_oneof![
                "[ -~]{0,12}",
                "-?[0-9]{1,3}(\\.[0-9])?[ ,;\t]-?[0-9](e[0-9]{1,3})?",
                "(shift|mirror|bound|units|rotate|point|approx)\\.(y|z|y\\.min|len\\.f|ang\\.f|dist\\.min|smooth) = -?[0-9]{1,3}",
                Just("point.begin".to_owned()),
                Just("point.end".to_owned()),
            ],
            0..12,
        ),
        unit in any_number(),
    ) {
        let text = lines.join("\n");
        for unit in [1e-3, unit] {
            if let Ok(profile) = Profile::parse(&text, unit, Vertical::Guess, Interpolation::Smooth) {
                prop_assert!(is_sound(&profile), "{text:?} {unit}");
            }
        }
    }
}

#[test]
fn points_too_close_or_too_far_are_refused() {
    // slopes over steps of 1e-293 m came out as NaN
    for (y, message) in [
        ([0.0, 1.5e-293], "at least 1e-12 m apart"),
        ([0.0, 1e200], "at most"),
    ] {
        let error = Profile::from_points(&y, &[0.0, 0.0], Interpolation::Smooth).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    }
}

#[test]
fn numbers_of_a_profile_give_it_back() {
    let table = Profile::from_points(
        &[-0.03, 0.0, 0.01, 0.04],
        &[-2e-3, 0.0, -1e-4, -3e-3],
        Interpolation::Smooth,
    );
    for profile in [Profile::rail_60e1(), Profile::wheel_s1002(), table.unwrap()] {
        let numbers = profile.to_numbers();
        assert_eq!(Profile::from_numbers(&numbers).unwrap(), profile);
        for cut in 0..numbers.len() {
            // a whole number of pieces is a shorter profile
            if let Ok(shorter) = Profile::from_numbers(&numbers[..cut]) {
                assert!(shorter.breaks().len() < profile.breaks().len());
            }
            for wrong in [f64::NAN, 1e300, -1e300] {
                let mut numbers = numbers.clone();
                numbers[cut] = wrong;
                assert!(Profile::from_numbers(&numbers).is_err(), "{cut}: {wrong}");
            }
        }
    }
}

proptest! {
    #[test]
    fn any_numbers_are_a_profile_or_an_error(numbers in prop::collection::vec(
        prop_oneof![any::<f64>(), -2.0..2.0, Just(0.0), Just(1.0), Just(2.0)], 0..20)
    ) {
        if let Ok(profile) = Profile::from_numbers(&numbers) {
            let [start, end] = profile.range();
            prop_assert!(profile.at(0.5 * (start + end)).unwrap().height.is_finite());
        }
    }
}

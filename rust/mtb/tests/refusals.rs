// SPDX-License-Identifier: MIT OR Apache-2.0
//! What makes no sense is refused in words that name the value and what would be accepted.

use mtb::contact::prepared::{Prepared, PreparedContact, Pull, Sliding, Step, Table};
use mtb::{
    BlockOnPlane, BodyOnPlane, Contact, Error, FreeMotion, Friction, Grid, Held, Load,
    PoleShoeOnRail, Relative, STEEL, descent, half_spaces, tilts, unmonitored,
};

fn grid() -> Grid {
    Grid::new(20, 16, 1e-4, 1e-4).unwrap()
}

/// A ball over a plane on cells of a window of 2.0 x 1.6 mm.
fn ball(motions: Vec<FreeMotion>) -> Contact {
    let gap = |x: f64, y: f64| (x * x + y * y) / 0.1;
    half_spaces(Some(STEEL), Some(STEEL), grid(), gap, motions).unwrap()
}

fn free() -> Vec<FreeMotion> {
    vec![descent(grid().points())]
}

/// That pressing and sliding both fail, with these words.
fn refused(contact: &Contact, loads: &[Load<'_>], words: &str) {
    let friction = vec![0.2; contact.points()];
    let friction = Friction::Field(&friction);
    for result in [
        contact.press(loads, &unmonitored),
        contact.slide(loads, [0.0, -1.0], friction, &unmonitored),
    ] {
        let message = result.expect_err(words).to_string();
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn bodies_that_no_load_brings_together() {
    for loads in [&[][..], &[Load::Force(0.0)], &[Load::Moments([0.0; 2])]] {
        refused(&ball(free()), loads, "the bodies never touch");
    }
    refused(&ball(Vec::new()), &[], "never touch: no load leaves a gap");
    let away = [Load::Approach(-1e-6)];
    refused(
        &ball(Vec::new()),
        &away,
        "an approach of -1e-06 m leaves a gap of 1.05e-06 m",
    );
    let nothing = vec![0.0; grid().points()];
    refused(
        &ball(free()),
        &[
            Load::Force(0.0),
            Load::Pull(&nothing, mtb::Body::Upper),
            Load::Resultant(&nothing, mtb::Body::Lower),
        ],
        "a force of 0 N with a pull of 0 Pa at most with a pull of 0 Pa at most",
    );
    // away, and a force that lifts: no pressure balances it
    let contact = ball(free());
    assert!(contact.press(&[Load::Force(-1.0)], &unmonitored).is_err());
    for held in [Held::DrivenTop, Held::ClampedTop] {
        let block = BlockOnPlane { held, ..block() };
        let contact = block.stand(&unmonitored).unwrap();
        refused(&contact, &[], "no load leaves a gap of");
    }
}

#[test]
fn bodies_that_lie_into_each_other_need_no_load() {
    let gap = |x: f64, y: f64| (x * x + y * y) / 0.1 - 1e-7;
    let contact = half_spaces(Some(STEEL), None, grid(), gap, Vec::new()).unwrap();
    let state = contact.press(&[], &unmonitored).unwrap();
    assert!(state.peak_pressure() > 0.0);
}

#[test]
fn contacts_that_run_over_the_edge() {
    let words = "reaches the edge of the grid of 20 x 16 points";
    refused(&ball(free()), &[Load::Force(1e6)], words);
    refused(&ball(Vec::new()), &[Load::Approach(1.0)], words);
    let [about_x, about_y] = tilts(grid());
    let tilting = vec![descent(grid().points()), about_x, about_y];
    refused(
        &ball(tilting),
        &[Load::Force(5.0), Load::Moments([0.0, 4.7e-3])],
        "at x = 0.00095 m",
    );
    // and so does what is prepared from it, before and after it was a file
    let (loose, n) = (ball(free()), grid().points());
    let sliding = Sliding {
        friction: Table::constant(vec![0.3; n]),
        direction: [1.0, 0.0],
        standstill_speed: None,
        velocity: None,
        layer: 0.0,
    };
    let loading = loose.loading(&[Load::Force(1.0)]).unwrap();
    let named = vec![("z".to_owned(), Some(2))];
    let made = Prepared::new(
        &loose.problem,
        &loading,
        None,
        named,
        sliding,
        [0.0; 3],
        &unmonitored,
    );
    let made = made.unwrap();
    let read = Prepared::from_bytes(&made.to_bytes(&unmonitored).unwrap()).unwrap();
    for prepared in [made, read] {
        let mut contact = PreparedContact::new(std::sync::Arc::new(prepared));
        let mut ask = |z: f64| {
            let pose = [0.0, 0.0, z, 0.0, 0.0, 0.0];
            let step = Step {
                pose,
                velocity: [1.0, 0.0],
                pull: Pull::Scene,
                gap: None,
                friction: None,
                diagonal: None,
                shift: None,
            };
            contact.step(&step, &unmonitored)
        };
        assert!(ask(f64::NAN).is_ok());
        let message = ask(-1e-4).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
        // a pose of a metre is no small displacement, wherever the grid ends
        let message = ask(-1.0).unwrap_err().to_string();
        assert!(message.contains("z of the pose is -1"), "{message}");
    }
    // what ends there is stated so
    let below = mtb::elasticity::half_space::HalfSpace::new(STEEL, grid()).unwrap();
    let pair = Relative::new(Some(std::sync::Arc::new(below)), None).unwrap();
    let punch = Contact::on_plane(pair, grid(), |_, _| 0.0, free()).unwrap();
    let state = punch.press(&[Load::Force(10.0)], &unmonitored).unwrap();
    assert!((state.outcome.force[2] + 10.0).abs() < 1e-9);
    // and a small contact is solved
    assert!(
        ball(free())
            .press(&[Load::Force(1.0)], &unmonitored)
            .is_ok()
    );
}

#[test]
fn velocities_without_a_direction() {
    let contact = ball(free());
    let friction = vec![0.2; contact.points()];
    let slide = |along: [f64; 2]| {
        let friction = Friction::Field(&friction);
        contact.slide(&[Load::Force(1.0)], along, friction, &unmonitored)
    };
    for (along, words) in [
        ([0.0, 0.0], "(0, 0)"),
        ([-0.0, 0.0], "not both zero"),
        ([f64::NAN, 1.0], "(NaN, 1)"),
        ([1.0, f64::INFINITY], "(1, inf)"),
    ] {
        let message = slide(along).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
    let force = |along| slide(along).unwrap().outcome.force;
    let [fx, fy, _] = force([1.0, 1.0]);
    for along in [[1e-320, 1e-320], [1.7e308, 1.7e308]] {
        let [x, y, _] = force(along);
        assert!((x - fx).abs() + (y - fy).abs() < 1e-9);
    }
    assert!((fx.hypot(fy) - 0.2).abs() < 1e-9 && fx > 0.0);
}

#[test]
fn numbers_are_called_by_their_name() {
    let contact = ball(free());
    refused(&contact, &[Load::Force(f64::NAN)], "force is NaN, a finite");
    refused(
        &contact,
        &[Load::Approach(f64::INFINITY)],
        "approach is inf, a finite",
    );
    let moments = [Load::Moments([0.0, f64::NAN])];
    refused(&contact, &moments, "moments[1] is NaN");
    let mut pull = vec![1e6; contact.points()];
    pull[7] = f64::NAN;
    let pulls = [Load::Pull(&pull, mtb::Body::Upper)];
    refused(&contact, &pulls, "pull[7] is NaN");
    refused(
        &contact,
        &[Load::Pull(&[1.0], mtb::Body::Lower)],
        "pull has 1 entries",
    );
    for (mu, words) in [
        (-0.1, "friction[0] is -0.1"),
        (f64::NAN, "friction[0] is NaN"),
    ] {
        let friction = vec![mu; contact.points()];
        let friction = Friction::Field(&friction);
        let slid = contact.slide(&[Load::Force(1.0)], [1.0, 0.0], friction, &unmonitored);
        let message = slid.expect_err(words).to_string();
        assert!(message.contains(words), "{message}");
    }
}

fn block() -> BlockOnPlane {
    BlockOnPlane {
        size: [0.06, 0.04, 0.03],
        spacing: [0.01; 2],
        held: Held::DrivenTop,
        upper: STEEL,
        lower: None,
    }
}

#[test]
fn cells_wider_than_the_contact() {
    let expect = |result: Result<Contact, Error>, words: &str| {
        let message = result.err().expect(words).to_string();
        assert!(message.contains(words), "{message}");
    };
    let shoe = |spacing| {
        let shoe = PoleShoeOnRail {
            spacing,
            ..PoleShoeOnRail::default()
        };
        shoe.stand(&unmonitored)
    };
    expect(
        shoe([9.0; 2]),
        "spacing along x is 9: the contact measures only 0.09 m there",
    );
    expect(
        shoe([0.01, 0.02]),
        "spacing across is 0.02: the contact measures only",
    );
    let on_plane = |spacing| BlockOnPlane { spacing, ..block() }.stand(&unmonitored);
    for (spacing, words) in [
        ([0.07, 0.01], "only 0.06 m there"),
        ([0.01, 0.05], "only 0.04 m there"),
        ([0.01, 0.0], "it must be positive"),
        ([f64::NAN, 0.01], "spacing along x is NaN"),
        ([1e-9, 1e-9], "more than 5e+06 cells"),
    ] {
        expect(
            shoe(spacing.map(|s| if s > 0.02 { 9.0 } else { s })),
            "spacing",
        );
        expect(on_plane(spacing), words);
    }
    for size in [
        [-0.06, 0.04, 0.03],
        [0.06, f64::NAN, 0.03],
        [0.06, 0.04, 0.0],
    ] {
        let block = BlockOnPlane { size, ..block() };
        assert!(block.stand(&unmonitored).is_err(), "{size:?}");
    }
    let even = |extent: f64| [-0.5 * extent, 0.0, 0.5 * extent];
    let mesh =
        mtb::geometry::solid::block(&even(0.06), &even(0.04), 0.03, Held::ClampedTop.filling())
            .unwrap();
    let own = BodyOnPlane {
        mesh,
        material: STEEL,
        supports: Vec::new(),
        face: [0.06, 0.04],
        spacing: [0.03, 0.041],
        lower: None,
    };
    expect(own.stand(&unmonitored), "only 0.04 m there");
}

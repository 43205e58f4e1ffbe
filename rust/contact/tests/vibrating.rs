// SPDX-License-Identifier: MIT OR Apache-2.0
//! A mass on one contact point, against its closed form.

use mtb_contact::coupled::{KeptInverse, PointState};
use mtb_contact::prepared::Table;
use mtb_contact::vibrating::{Movement, Touching, VibratingContact};
use mtb_operator::unmonitored;

const AREA: f64 = 2e-4;
const COMPLIANCE: f64 = 1e-13;
const MASS: f64 = 3.0;
const PRESSURE: f64 = 1e6;

/// A mass that moves along x and z over a point that is pressed by its weight.
fn mass_on_a_point(friction: f64, step: f64) -> VibratingContact {
    let mut compliance = vec![0.0; 9];
    for own in compliance.iter_mut().step_by(4) {
        *own = COMPLIANCE;
    }
    let touching = Touching {
        compliance,
        area: vec![AREA],
        friction: Table::constant(vec![friction]),
        traction: vec![0.0, 0.0, PRESSURE],
        gap: vec![0.0],
    };
    let movement = Movement {
        coordinates: 2,
        mass: vec![MASS, 0.0, 0.0, MASS],
        damping: vec![0.0; 4],
        stiffness: vec![0.0; 4],
        // x takes the upper body along, z opens the gap
        shapes: vec![-1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
    };
    VibratingContact::new(touching, &movement, step, &unmonitored).expect("a contact")
}

#[test]
fn it_swings_on_the_stiffness_of_the_point() {
    let swing = (AREA / COMPLIANCE / MASS).sqrt();
    let deep = COMPLIANCE * PRESSURE;
    let mut errors = Vec::new();
    for steps in [50, 100] {
        let step = 2.0 * std::f64::consts::PI / swing / f64::from(steps);
        let contact = mass_on_a_point(0.0, step);
        let mut state = contact.start().clone();
        state.rate[1] = 0.5 * deep * swing;
        let begun = contact.energy(&state).expect("energy");
        let mut kept = KeptInverse::default();
        let mut work = 0.0;
        for _ in 0..steps {
            let taken = contact
                .step(&state, &[0.0; 2], &[0.0; 2], None, &mut kept, &unmonitored)
                .expect("a step")
                .expect("a state");
            assert_ne!(taken.points, [PointState::Open]);
            work += taken.work.load + taken.work.closing;
            state = taken.state;
        }
        let end = contact.energy(&state).expect("energy");
        let total = |e: mtb_contact::vibrating::Energy| e.kinetic + e.potential + e.contact;
        assert!((total(end) - total(begun) - work).abs() < 1e-12 * total(begun));
        // after a period it is back
        errors.push(state.amplitude[1].abs() / deep);
    }
    assert!(errors[0] < 1e-2);
    assert!((errors[0] / errors[1] - 4.0).abs() < 0.2);
}

#[test]
fn friction_stops_it_as_it_stops_a_block() {
    let (friction, step) = (0.3, 1e-5);
    let contact = mass_on_a_point(friction, step);
    let mut state = contact.start().clone();
    let speed = 0.02;
    state.rate[0] = speed;
    let mut kept = KeptInverse::default();
    let (mut heat, mut count) = (0.0, 0);
    loop {
        let taken = contact
            .step(&state, &[0.0; 2], &[0.0; 2], None, &mut kept, &unmonitored)
            .expect("a step")
            .expect("a state");
        state = taken.state;
        if taken.points == [PointState::Stick] {
            break;
        }
        heat += taken.work.friction;
        count += 1;
    }
    let force = friction * PRESSURE * AREA;
    let expected = MASS * speed / force;
    assert!((f64::from(count) * step / expected - 1.0).abs() < 5e-3);
    let all = 0.5 * MASS * speed * speed;
    assert!((heat / all - 1.0).abs() < 5e-3);
}

#[test]
fn what_does_not_fit_is_refused() {
    let contact = mass_on_a_point(0.3, 1e-5);
    let state = contact.start().clone();
    let mut kept = KeptInverse::default();
    let mut step = |drive: &[f64], load: &[f64]| {
        contact.step(&state, drive, load, None, &mut kept, &unmonitored)
    };
    assert!(step(&[0.0], &[0.0; 2]).is_err());
    assert!(step(&[0.0; 2], &[f64::NAN, 0.0]).is_err());
}

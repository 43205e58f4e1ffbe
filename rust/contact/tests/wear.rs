// SPDX-License-Identifier: MIT OR Apache-2.0
//! Wear against closed forms, and its account of what was worn.

use std::f64::consts::TAU;
use std::sync::Arc;

use mtb_contact::Error;
use mtb_contact::prepared::{Prepared, PreparedContact, Pull, Sliding, Step, Table};
use mtb_contact::problem::{Body, FreeMotion, Friction, Geometry, Load, Loading, Problem};
use mtb_contact::wear::{
    Coefficients, Passage, PreparedStep, Rubbing, SlidingProblem, Wear, WearStep, Wearing, Worn,
};
use mtb_operator::{Compliance, Component, Relative, unmonitored};

const N: usize = 32;
const LENGTH: f64 = 0.05;
const STEP: f64 = LENGTH / N as f64;
/// Of one elastic body against a rigid one [Pa].
const MODULUS: f64 = 2.3e11;
const WEAR: f64 = 1e-14;

/// A half-space under waves along x: a pressure `cos(m x)` moves it by `2 / (E* m)`; the mean by as much as wave 1.
struct Waves;

impl Compliance for Waves {
    fn points(&self) -> usize {
        N
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        if (observed, loaded) != (Component::Normal, Component::Normal) {
            return;
        }
        for (i, u) in displacement.iter_mut().enumerate() {
            for (j, p) in traction.iter().enumerate() {
                let apart = (i as f64 - j as f64) / N as f64;
                for wave in 0..N {
                    let number = wave.min(N - wave).max(1) as f64;
                    let softness = 2.0 / (MODULUS * TAU * number / LENGTH);
                    *u += scale * p * softness * (TAU * wave as f64 * apart).cos() / N as f64;
                }
            }
        }
    }
}

fn geometry() -> Geometry {
    let unit = |axis: usize| -> Vec<f64> {
        (0..3 * N)
            .map(|k| f64::from(u8::from(k / N == axis)))
            .collect()
    };
    let mut points = vec![0.0; 3 * N];
    for (i, x) in points[..N].iter_mut().enumerate() {
        *x = STEP * i as f64;
    }
    Geometry {
        points,
        normal: unit(2),
        tangent_x: unit(0),
        tangent_y: unit(1),
        area: vec![STEP * 1e-2; N],
        mean_frame: [unit(0), unit(1), unit(2)],
        means: None,
        windows: Vec::new(),
    }
}

fn wave(m: usize) -> Vec<f64> {
    (0..N)
        .map(|i| (TAU * (m * i) as f64 / N as f64).cos())
        .collect()
}

/// Share of a wave in a field.
fn share(field: &[f64], m: usize) -> f64 {
    let products = field.iter().zip(wave(m)).map(|(p, c)| p * c);
    2.0 * products.sum::<f64>() / N as f64
}

/// Pressed by 3 MPa, with a gap that is `amplitude` times a wave.
fn pressed(m: usize, amplitude: f64) -> (Problem, Loading) {
    let geometry = geometry();
    let rise: Vec<f64> = (0..3 * N)
        .map(|k| f64::from(u8::from(k >= 2 * N)))
        .collect();
    let descent = FreeMotion::of(&geometry, Body::Upper, &rise).unwrap();
    let force = 3e6 * geometry.area.iter().sum::<f64>();
    let pair = Relative::new(Some(Arc::new(Waves)), None).unwrap();
    let problem = Problem::new(pair, Arc::new(geometry), vec![descent]).unwrap();
    let mut loading = problem.unloaded(wave(m).iter().map(|c| amplitude * c).collect());
    problem.load(&mut loading, Load::Force(force)).unwrap();
    (problem, loading)
}

fn unworn() -> Worn {
    Worn {
        distance: 0.0,
        depth: [vec![0.0; N], vec![0.0; N]],
    }
}

fn steady(upper: f64, lower: f64) -> impl Fn(Rubbing<'_>) -> Result<Coefficients, Error> {
    move |_| Ok([vec![upper; N], vec![lower; N]])
}

/// `count` steps over `distance`, all of one length.
fn even<C: Wearing>(wear: &mut Wear<'_, C>, distance: f64, count: usize) -> WearStep {
    let length = distance / count as f64;
    wear.begin_with(Some(length));
    let mut last = wear.advance(length, &unmonitored).unwrap();
    for _ in 1..count {
        last = wear.advance(length, &unmonitored).unwrap();
        assert_eq!(last.length, length);
    }
    last
}

const STILL: [f64; 2 * N] = [0.0; 2 * N];
const SMOOTH: [f64; N] = [0.0; N];

#[test]
fn a_wave_decays_by_the_closed_form_in_each_step_and_exponentially_in_the_limit() {
    for m in [1, 3] {
        let law = steady(WEAR, 0.0);
        let number = TAU * m as f64 / LENGTH;
        let rate = WEAR * MODULUS * number / 2.0;
        let distance = 1.0 / rate;
        let mut errors = Vec::new();
        for count in [8, 16, 32] {
            let (problem, loading) = pressed(m, 3e-8);
            let contact = SlidingProblem::new(&problem, loading, &STILL, Friction::Field(&SMOOTH));
            // lengths are what is asked for
            let mut wear = Wear::new(contact, &law, None, 1e9, unworn()).unwrap();
            let before = share(&wear.now(&unmonitored).unwrap().solution.pressure, m);
            assert!((before / (-3e-8 * MODULUS * number / 2.0) - 1.0).abs() < 1e-9);
            let last = even(&mut wear, distance, count);
            let found = share(&last.outcome.solution.pressure, m) / before;
            let step = 1.0 / (1.0 + 1.0 / count as f64);
            assert!((found / step.powi(count as i32) - 1.0).abs() < 1e-8);
            errors.push((found - (-1.0_f64).exp()).abs());
        }
        let order = (errors[1] / errors[2]).log2();
        assert!((order - 1.0).abs() < 0.1, "{order}");
    }
}

#[test]
fn steps_chosen_by_their_error_keep_to_the_tolerance_and_need_few_solves() {
    let law = steady(WEAR, 0.0);
    let rate = WEAR * MODULUS * TAU / LENGTH / 2.0;
    for tolerance in [0.05, 0.005] {
        let (problem, loading) = pressed(1, 1e-7);
        let contact = SlidingProblem::new(&problem, loading, &STILL, Friction::Field(&SMOOTH));
        let mut wear = Wear::new(contact, &law, None, tolerance, unworn()).unwrap();
        let distance = 30.0 / rate;
        let (mut solves, mut worst) = (0, 0.0_f64);
        while wear.worn().distance < distance * (1.0 - 1e-12) {
            let step = wear
                .advance(distance - wear.worn().distance, &unmonitored)
                .unwrap();
            solves += step.solves;
            let s = step.worn.distance;
            // worn off the wave of the gap: what its pressure took along
            let exact = -1e-7 * (1.0 - (-rate * s).exp());
            let mean = WEAR * s * 3e6;
            // the root mean square of a wave is less than its height
            let off = (share(&step.worn.depth[0], 1) - exact) / 2.0_f64.sqrt();
            worst = worst.max(off.abs() / mean);
        }
        assert!(worst < tolerance, "{worst} at {tolerance}");
        assert!(
            (solves as f64) < 1.0 / tolerance,
            "{solves} solves at {tolerance}"
        );
    }
}

#[test]
fn a_prepared_step_wears_as_its_problem_does() {
    let law = |rubbing: Rubbing<'_>| -> Result<Coefficients, Error> {
        // faster where it presses more
        let upper = rubbing.pressure.iter().map(|p| WEAR * (1.0 + p / 3e6));
        Ok([upper.collect(), vec![0.3 * WEAR; N]])
    };
    let (problem, loading) = pressed(2, 4e-7);
    let sliding = Sliding {
        friction: Table::constant(vec![0.0; N]),
        direction: [1.0, 0.0],
        standstill_speed: None,
        velocity: None,
        layer: 0.0,
    };
    let named = vec![("z".to_owned(), Some(2))];
    let prepared = Prepared::new(
        &problem,
        &loading,
        None,
        named,
        sliding,
        [0.0; 3],
        &unmonitored,
    );
    let mut contact = PreparedContact::new(Arc::new(prepared.unwrap()));
    let step = Step {
        pose: [f64::NAN; 6],
        velocity: [1.0, 0.0],
        pull: Pull::Scene,
        gap: None,
        friction: None,
        diagonal: None,
        shift: None,
    };
    let by_step = PreparedStep::new(&mut contact, step);
    let by_problem = SlidingProblem::new(&problem, loading, &STILL, Friction::Field(&SMOOTH));
    let mut one = Wear::new(by_step, &law, None, 0.02, unworn()).unwrap();
    let mut other = Wear::new(by_problem, &law, None, 0.02, unworn()).unwrap();
    for _ in 0..10 {
        let (one, other) = (
            one.advance(5.0, &unmonitored).unwrap(),
            other.advance(5.0, &unmonitored).unwrap(),
        );
        assert!((one.length / other.length - 1.0).abs() < 1e-6);
        let deepest = one.worn.depth[0].iter().copied().fold(0.0, f64::max);
        for (a, b) in one.worn.depth[0].iter().zip(&other.worn.depth[0]) {
            assert!((a - b).abs() <= 1e-6 * deepest, "{a} {b}");
        }
    }
}

#[test]
fn passages_wear_lines_evenly_and_leave_the_state_of_what_they_wore() {
    // two lines: the even and the odd points
    let passage = Passage {
        distance: 0.2,
        line: (0..N).map(|i| i % 2).collect(),
        length: vec![2.0 * STEP; N],
    };
    let (upper, lower) = (0.2 * WEAR, WEAR);
    let law = steady(upper, lower);
    let (problem, loading) = pressed(1, 2e-6);
    let gap = loading.gap.clone();
    let contact = SlidingProblem::new(&problem, loading.clone(), &STILL, Friction::Field(&SMOOTH));
    let mut wear = Wear::new(contact, &law, Some(passage.clone()), 1e-3, unworn()).unwrap();
    let mut expected = [0.0; 2];
    for _ in 0..25 {
        let step = wear.advance(40.0, &unmonitored).unwrap();
        let p = &step.outcome.solution.pressure;
        for i in 0..N {
            let line = i % 2;
            expected[line] += step.length / passage.distance * lower * p[i] * passage.length[i];
        }
        for (i, depth) in step.worn.depth[1].iter().enumerate() {
            assert!((depth / expected[i % 2] - 1.0).abs() < 1e-12);
        }
        // the worn gap alone gives the pressure of the step, but for what the rounds may leave
        let [a, b] = &step.worn.depth;
        let worn = Loading {
            gap: (0..N).map(|i| gap[i] + a[i] + b[i]).collect(),
            ..loading.clone()
        };
        let again = problem.press(&worn, &unmonitored).unwrap();
        for (a, b) in again.solution.pressure.iter().zip(p) {
            assert!((a - b).abs() < 0.02 * 3e6, "{a} {b}");
        }
    }
}

#[test]
fn what_cannot_wear_is_refused() {
    let (problem, loading) = pressed(1, 1e-7);
    let contact =
        || SlidingProblem::new(&problem, loading.clone(), &STILL, Friction::Field(&SMOOTH));
    let law = steady(WEAR, -WEAR);
    let mut wear = Wear::new(contact(), &law, None, 0.02, unworn()).unwrap();
    assert!(matches!(
        wear.advance(1.0, &unmonitored),
        Err(Error::Negative { index: 0, .. })
    ));
    let law = steady(WEAR, 0.0);
    assert!(Wear::new(contact(), &law, None, 0.0, unworn()).is_err());
    let mut wear = Wear::new(contact(), &law, None, 0.02, unworn()).unwrap();
    assert!(wear.advance(-1.0, &unmonitored).is_err());
}

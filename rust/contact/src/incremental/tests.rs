// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::unmonitored;

use super::surface::{normals, turn};
use super::*;

/// A bed of springs: each point for itself, and friction lifts a point by a share of its indentation.
struct Springs {
    n: usize,
    normal: f64,
    lift: f64,
}

impl Compliance for Springs {
    fn points(&self) -> usize {
        self.n
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        let factor = match (observed, loaded) {
            (Component::Normal, Component::Normal) => self.normal,
            (Component::Normal, Component::X) => -self.lift * self.normal,
            _ => 0.0,
        };
        for (u, t) in displacement.iter_mut().zip(traction) {
            *u += scale * factor * t;
        }
    }
}

const N: usize = 21;
const STIFFNESS: f64 = 1e12;

fn bowl() -> (Vec<f64>, Vec<f64>) {
    let mut lower = vec![0.0; 3 * N * N];
    let mut upper = vec![0.0; 3 * N * N];
    for k in 0..N * N {
        let (x, y) = ((k % N) as f64 - 10.0, (k / N) as f64 - 10.0);
        let (x, y) = (1e-3 * x, 1e-3 * y);
        for points in [&mut lower, &mut upper] {
            points[k] = x;
            points[N * N + k] = y;
        }
        upper[2 * N * N + k] = 0.5 * (x * x + y * y);
    }
    (lower, upper)
}

fn options() -> IncrementalOptions {
    IncrementalOptions {
        estimated_steps: 7,
        force_tolerance: 1e-3,
        distance_tolerance: Some(1e-9),
        max_resolutions: 20,
        max_releases: 20,
        max_increments: 100,
    }
}

fn press(lift: f64, options: &IncrementalOptions) -> Result<IncrementalSolution, Error> {
    let (lower, upper) = bowl();
    let n = N * N;
    let springs = [lift, 0.0].map(|lift| Springs {
        n,
        normal: 0.5 / STIFFNESS,
        lift,
    });
    let contact = IncrementalContact {
        lower: Some(&springs[0]),
        upper: Some(&springs[1]),
        lower_points: &lower,
        upper_points: &upper,
        grids: &[(N, N)],
        area: &vec![1e-6; n],
        friction: &vec![0.3; n],
        direction: [2.0, 0.0, 0.0],
        force: 1e3,
    };
    incremental(&contact, options, &unmonitored)
}

#[test]
fn a_bed_of_springs_is_met_exactly() -> Result<(), Error> {
    let solution = press(0.0, &options())?;
    assert_eq!(solution.status, IncrementalStatus::Converged);
    let (_, upper) = bowl();
    let n = N * N;
    assert!((solution.force - 1e3).abs() <= 1e-3);
    for i in 0..n {
        // to second order in the slope, 1e-2
        let expected = STIFFNESS * (solution.approach - upper[2 * n + i]).max(0.0);
        assert!((solution.pressure[i] - expected).abs() < 2e-4 * STIFFNESS * solution.approach);
        assert!(
            (solution.traction[i] - 0.3 * solution.pressure[i]).abs() < 1e-6 * expected.max(1.0)
        );
    }
    assert!(solution.residual < 1e-3 && solution.increments >= 7);
    assert_eq!(solution.problems, 2 * solution.resolutions);
    Ok(())
}

#[test]
fn friction_that_moves_the_surface_along_its_normal_is_followed() -> Result<(), Error> {
    // each resolution closes all but mu * lift / 2 of the distance: the fixed point is the coupled solution
    let solution = press(-0.5, &options())?;
    assert_eq!(solution.status, IncrementalStatus::Converged);
    let lifted = press(0.5, &options())?;
    assert_eq!(lifted.status, IncrementalStatus::Converged);
    let centre = N * N / 2;
    // indentation of a point per pressure: (1 -+ 0.3 * 0.5 / 2) / stiffness
    for (solution, factor) in [(&solution, 1.075), (&lifted, 0.925)] {
        let expected = STIFFNESS * solution.approach / factor;
        assert!(
            (solution.pressure[centre] / expected - 1.0).abs() < 2e-3,
            "{} {expected}",
            solution.pressure[centre]
        );
    }
    Ok(())
}

#[test]
fn honest_when_increments_or_resolutions_run_out() -> Result<(), Error> {
    let few = IncrementalOptions {
        max_increments: 3,
        ..options()
    };
    let solution = press(0.0, &few)?;
    assert_eq!(solution.status, IncrementalStatus::IncrementLimit);
    assert!(solution.force < 1e3 - 1.0);
    let hasty = IncrementalOptions {
        max_resolutions: 1,
        ..options()
    };
    assert_ne!(press(0.5, &hasty)?.status, IncrementalStatus::Converged);
    Ok(())
}

#[test]
fn normals_of_a_parabola_and_their_turning() {
    let point = |k: usize, slope: f64| {
        let (x, y) = ((k % 5) as f64, (k / 5) as f64);
        [x, y, 0.01 * x * x - 0.02 * x * y + slope * x]
    };
    let old: Vec<[f64; 3]> = (0..20).map(|k| point(k, 0.0)).collect();
    let new: Vec<[f64; 3]> = (0..20).map(|k| point(k, 1e-4)).collect();
    let exact = |slope: f64| -> Vec<[f64; 3]> {
        (0..20)
            .map(|k| {
                let (x, y) = (f64::from(k % 5), f64::from(k / 5));
                surface::unit([-(0.02 * x - 0.02 * y + slope), 0.02 * x, 1.0])
            })
            .collect()
    };
    let mut normal = normals(&old, &[(5, 4)], 1.0);
    for (a, b) in normal.iter().zip(exact(0.0)) {
        assert!(add(*a, -1.0, b).iter().all(|d| d.abs() < 1e-14));
    }
    turn(&mut normal, &old, &new, &[(5, 4)]);
    for (a, b) in normal.iter().zip(exact(1e-4)) {
        assert!(
            add(*a, -1.0, b).iter().all(|d| d.abs() < 1e-6),
            "{a:?} {b:?}"
        );
    }
}

#[test]
fn bad_input_is_named() {
    let (lower, upper) = bowl();
    let n = N * N;
    let springs = Springs {
        n,
        normal: 1e-12,
        lift: 0.0,
    };
    let contact = IncrementalContact {
        lower: Some(&springs),
        upper: None,
        lower_points: &lower,
        upper_points: &upper,
        grids: &[(N, N)],
        area: &vec![1e-6; n],
        friction: &vec![0.3; n],
        direction: [1.0, 0.0, 0.0],
        force: -1.0,
    };
    let message = |contact: &IncrementalContact<'_>| {
        incremental(contact, &options(), &unmonitored)
            .err()
            .map(|e| e.to_string())
            .unwrap_or_default()
    };
    assert!(message(&contact).contains("force is -1"));
    let rigid = IncrementalContact {
        lower: None,
        force: 1.0,
        ..contact
    };
    assert!(message(&rigid).contains("elastic bodies"));
    let short = IncrementalContact {
        lower: Some(&springs),
        grids: &[(N, 2)],
        ..rigid
    };
    assert!(message(&short).contains("lower_points has"));
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Against closed forms: bands, ellipses, rectangles at rest, bodies of different temperature.

use std::f64::consts::PI;

use mtb_heat::{Conductor, Error, HalfSpace, Passage, Temperatures, Warming, rolling};
use proptest::prelude::*;

fn steel() -> Conductor {
    Conductor::new(50.0, 7850.0, 450.0).unwrap()
}

fn row(
    power: &[f64],
    touches: &[bool],
    dx: f64,
    bodies: [Conductor; 2],
    bulk: [f64; 2],
) -> Temperatures {
    rolling(&Passage {
        shape: [power.len(), 1],
        spacing: [dx, 1e-3],
        angle: PI,
        speed: 30.0,
        power,
        touches,
        bodies,
        bulk,
    })
    .unwrap()
}

/// Largest temperature under a half-ellipse of heat, over `q0 sqrt(a) / ((beta1 + beta2) sqrt(pi V))`.
fn peak_of_half_ellipse(cells: usize) -> (f64, f64) {
    let a = 6e-3;
    let dx = 2.0 * a / cells as f64;
    let x: Vec<f64> = (0..cells).map(|k| (k as f64 + 0.5) * dx - a).collect();
    let power: Vec<f64> = x
        .iter()
        .map(|x| 1e9 * (1.0 - (x / a).powi(2)).sqrt())
        .collect();
    let found = row(&power, &vec![true; cells], dx, [steel(); 2], [0.0; 2]);
    let unit = 1e9 * a.sqrt() / (2.0 * steel().effusivity() * (PI * 30.0).sqrt());
    let (k, most) = found.surface[0]
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(b.1))
        .unwrap();
    (most / unit, x[k] / a)
}

#[test]
fn a_half_ellipse_of_heat_is_hottest_behind_its_middle() {
    // the integral of sqrt(1 - x^2) / sqrt(s) by quadrature with s = u^2, its largest value over the place
    let by_quadrature = |at: f64| -> f64 {
        let n = 200_000;
        let end = (1.0 + at).sqrt();
        (0..n)
            .map(|k| {
                let u = (f64::from(k) + 0.5) * end / f64::from(n);
                2.0 * (1.0 - (at - u * u).powi(2)).max(0.0).sqrt() * end / f64::from(n)
            })
            .sum()
    };
    let exact = (600..700)
        .map(|k| by_quadrature(f64::from(k) * 1e-3))
        .fold(0.0, f64::max);
    assert!((exact - 2.188).abs() < 5e-4);
    let (coarse, _) = peak_of_half_ellipse(50);
    let (fine, place) = peak_of_half_ellipse(400);
    assert!((fine / exact - 1.0).abs() < 1e-4, "{fine}");
    assert!((coarse / exact - 1.0).abs() < 2e-3, "{coarse}");
    assert!((place - 0.65).abs() < 0.01);
}

#[test]
fn unlike_bodies_share_their_temperature_and_cool_by_the_arcsine() {
    let other = Conductor::new(20.0, 7000.0, 500.0).unwrap();
    let (cells, closed) = (400, 100);
    let touches: Vec<bool> = (0..cells).map(|k| k < closed).collect();
    let found = row(
        &vec![0.0; cells],
        &touches,
        1e-4,
        [steel(), other],
        [0.0, 150.0],
    );
    let (b0, b1) = (steel().effusivity(), other.effusivity());
    let common = 150.0 * b1 / (b0 + b1);
    let length = 1e-4 * closed as f64;
    for k in 0..cells {
        let s = 1e-4 * (k as f64 + 0.5);
        let rise = if k < closed {
            1.0
        } else {
            2.0 / PI * (length / s).sqrt().asin()
        };
        assert!(
            (found.surface[0][k] - common * rise).abs() < 1e-10 * 150.0,
            "{k}"
        );
        let upper = 150.0 + (common - 150.0) * rise;
        assert!((found.surface[1][k] - upper).abs() < 1e-10 * 150.0, "{k}");
    }
}

#[test]
fn bodies_that_meet_again_have_one_temperature_again() {
    let other = Conductor::new(20.0, 7000.0, 500.0).unwrap();
    let run = |n: usize| {
        let touches: Vec<bool> = (0..8 * n).map(|k| (k / n).is_multiple_of(2)).collect();
        let found = row(
            &vec![0.0; 8 * n],
            &touches,
            8e-3 / (8 * n) as f64,
            [steel(), other],
            [0.0, 150.0],
        );
        for k in 0..8 * n {
            let [a, b] = [found.surface[0][k], found.surface[1][k]];
            assert!(!touches[k] || (a - b).abs() < 1e-9 * 150.0);
            assert!((0.0..=150.0).contains(&a) && a <= b + 1e-9);
        }
        // the last gap, where all exchanges are remembered
        found.surface[0][8 * n - n / 2 - 1] + found.surface[0][8 * n - n / 2]
    };
    let values: Vec<f64> = [4, 8, 16, 32, 64].into_iter().map(run).collect();
    let changes: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    assert!(changes.windows(2).all(|w| w[1] < 0.7 * w[0]), "{changes:?}");
}

#[test]
fn rolling_aslant_approaches_rolling_along() {
    // a disc of heat is the same from everywhere
    let largest = |angle: f64, n: usize| {
        let dx = 10e-3 / n as f64;
        let at = |k: usize| (k as f64 + 0.5) * dx - 5e-3;
        let radius = |k: usize| at(k % n).hypot(at(k / n)) / 4e-3;
        let touches: Vec<bool> = (0..n * n).map(|k| radius(k) < 1.0).collect();
        let power: Vec<f64> = (0..n * n)
            .map(|k| 1e9 * (1.0 - radius(k).powi(2)).max(0.0).sqrt())
            .collect();
        let found = rolling(&Passage {
            shape: [n, n],
            spacing: [dx; 2],
            angle,
            speed: 30.0,
            power: &power,
            touches: &touches,
            bodies: [steel(); 2],
            bulk: [0.0, 50.0],
        })
        .unwrap();
        found.surface[0].iter().copied().fold(0.0, f64::max)
    };
    for angle in [0.3, PI / 2.0, 2.5, -2.0, -0.5 * PI] {
        let along = largest(0.0, 80);
        assert!((largest(angle, 80) / along - 1.0).abs() < 4e-3, "{angle}");
    }
}

#[test]
fn a_square_at_rest_has_the_closed_form() {
    let rest = HalfSpace::new(steel(), [0.0; 2]).unwrap();
    let side = 2e-3;
    let found = rest.influence([0.0; 2], [side; 2]).unwrap();
    let exact = side * (1.0 + 2f64.sqrt()).ln() * 2.0 / (PI * 50.0);
    assert!((found / exact - 1.0).abs() < 1e-9, "{}", found / exact);
    // far away it is a point
    let far = rest.influence([0.3, -0.4], [side; 2]).unwrap();
    assert!((far * 2.0 * PI * 50.0 * 0.5 / side.powi(2) - 1.0).abs() < 1e-5);
}

/// Modified Bessel function of the second kind, times the exponential of its argument.
fn bessel_k0_scaled(x: f64) -> f64 {
    // the integral of exp(-x (cosh t - 1)) over t
    let n = 4000;
    let end = (1.0 + 45.0 / x).acosh();
    let h = end / f64::from(n);
    (0..n)
        .map(|k| h * (-x * (((f64::from(k) + 0.5) * h).cosh() - 1.0)).exp())
        .sum()
}

#[test]
fn moving_bands_agree_with_jaeger() {
    // a band of the half-length a that is long across: the integral of exp(-p t) K0(p |t|) over it
    let a = 1e-3;
    for peclet in [0.1, 1.0, 10.0, 100.0, 1000.0] {
        let speed = 2.0 * peclet * steel().diffusivity() / a;
        let moving = HalfSpace::new(steel(), [speed, 0.0]).unwrap();
        for place in [-0.5, 0.0, 0.7] {
            // t upstream of the place, split at zero, with t = u^2 against the logarithm
            let part = |length: f64, sign: f64| -> f64 {
                let n = 2000;
                let end = length.sqrt();
                (0..n)
                    .map(|k| {
                        let u = (f64::from(k) + 0.5) * end / f64::from(n);
                        let t = u * u;
                        let x = peclet * t;
                        let decay = if sign > 0.0 { 1.0 } else { (-2.0 * x).exp() };
                        2.0 * u * decay * bessel_k0_scaled(x) * end / f64::from(n)
                    })
                    .sum()
            };
            let exact = a / (PI * 50.0) * (part(1.0 + place, 1.0) + part(1.0 - place, -1.0));
            let found = moving
                .influence([place * a, 0.0], [2.0 * a, 4000.0 * a])
                .unwrap();
            assert!(
                (found / exact - 1.0).abs() < 1e-3,
                "{peclet} {place}: {}",
                found / exact
            );
        }
    }
}

#[test]
fn fast_half_spaces_are_heated_into_the_depth_alone() {
    let moving = HalfSpace::new(steel(), [0.0, -30.0]).unwrap();
    let found = moving.influence([0.0, -20e-3], [60e-3, 40e-3]).unwrap();
    let exact = 2.0 * (40e-3f64 / 30.0 / PI).sqrt() / steel().effusivity();
    assert!((found / exact - 1.0).abs() < 2e-3, "{}", found / exact);
}

#[test]
fn matrices_are_made_of_the_influences_and_swelling_adds_up() {
    let moving = HalfSpace::new(steel(), [2.0, 0.0]).unwrap();
    let points: Vec<[f64; 2]> = (0..12)
        .map(|k| [1e-3 * f64::from(k % 4), 2e-3 * f64::from(k / 4)])
        .collect();
    let sizes = [[1e-3, 2e-3]; 12];
    let found = moving.influences(&points, &sizes).unwrap();
    for (i, p) in points.iter().enumerate() {
        for (j, q) in points.iter().enumerate() {
            let one = moving
                .influence([p[0] - q[0], p[1] - q[1]], sizes[j])
                .unwrap();
            assert!((found[12 * i + j] - one).abs() < 1e-6 * found[0]);
        }
    }
    // a uniform flux: the middle of the last of four cells has passed three and a half of them
    let rise = moving.swelling(&points, &sizes, 12e-6, 0.3).unwrap();
    let heat = 3.5e-3 / 2.0;
    for row in 0..3 {
        let i = 4 * row + 3;
        let total: f64 = rise[12 * i..12 * (i + 1)].iter().sum();
        assert!((total / (2.0 * 1.3 * 12e-6 * heat / steel().capacity()) - 1.0).abs() < 1e-12);
    }
    let still = HalfSpace::new(steel(), [0.0; 2]).unwrap();
    assert!(still.swelling(&points, &sizes, 12e-6, 0.3).is_err());
    assert!(moving.influences(&points, &sizes[1..]).is_err());
}

#[test]
fn a_heated_band_warms_with_the_root_of_the_way_through_it() {
    // three columns of cells across the way, which is so much longer as it is crossed obliquely
    let (shape, spacing, power) = ([41, 31], [1e-3, 1.3e-3], 1e8);
    let other = Conductor::new(20.0, 7000.0, 500.0).unwrap();
    let betas = steel().effusivity() + other.effusivity();
    let heat: Vec<f64> = (0..41 * 31)
        .map(|k| {
            if (20..23).contains(&(k % 41)) {
                power
            } else {
                0.0
            }
        })
        .collect();
    // along the rows, obliquely, and through corners of cells
    for angle in [0.0, 0.2, f64::atan(spacing[1] / spacing[0]), -0.3] {
        let warming = Warming::new(shape, spacing, angle, 25.0, [steel(), other]).unwrap();
        let row = if angle < 0.0 { 29 } else { 2 };
        // the leading column, the last one, and two columns behind
        for (column, far, near) in [(22, 0.5, 0.0), (20, 2.5, 0.0), (18, 4.5, 1.5)] {
            let root = |columns: f64| (columns * spacing[0] / angle.cos()).sqrt();
            let exact = 2.0 * power * (root(far) - root(near)) / (betas * (PI * 25.0).sqrt());
            let at = [row * 41 + column];
            let (found, by) = (
                warming.rise(&heat, &at)[0],
                warming.rise_by_angle(&heat, &at)[0],
            );
            assert!(
                (found / exact - 1.0).abs() < 1e-12,
                "{angle} {found} {exact}"
            );
            // the way goes with 1 / cos, and the rise with its root
            let slope = 0.5 * f64::tan(angle) * exact;
            assert!((by - slope).abs() < 1e-12 * exact, "{angle} {by} {slope}");
        }
    }
}

#[test]
fn heat_that_cells_pass_on_comes_back_transposed() {
    let mut random = 7_u64;
    let mut field = |n: usize| -> Vec<f64> {
        let mut next = || {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (random >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..n).map(|_| next()).collect()
    };
    for angle in [0.0, 0.7, 2.0, -2.4] {
        let warming = Warming::new([7, 5], [1e-3, 0.8e-3], angle, 10.0, [steel(); 2]).unwrap();
        let at = [3, 11, 17, 30];
        let (power, weights) = (field(35), field(4));
        let rise = warming.rise(&power, &at);
        let mut back = vec![0.0; 35];
        warming.weigh(&weights, &at, &mut back);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (there, here) = (dot(&rise, &weights), dot(&power, &back));
        assert!((there - here).abs() < 1e-12 * there.abs().max(here.abs()));
    }
}

#[test]
fn bad_input_is_refused() {
    assert!(matches!(
        Conductor::new(0.0, 1.0, 1.0),
        Err(Error::NotPositive {
            name: "conductivity",
            ..
        })
    ));
    assert!(HalfSpace::new(steel(), [f64::NAN, 0.0]).is_err());
    assert!(
        HalfSpace::new(steel(), [1.0, 0.0])
            .unwrap()
            .influence([0.0; 2], [1.0, -1.0])
            .is_err()
    );
    let bad = Passage {
        shape: [2, 1],
        spacing: [1.0; 2],
        angle: 0.0,
        speed: 1.0,
        power: &[1.0],
        touches: &[true, true],
        bodies: [steel(); 2],
        bulk: [0.0; 2],
    };
    assert!(matches!(
        rolling(&bad),
        Err(Error::Shape { name: "power", .. })
    ));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn rectangles_add_up(
        x in -3.0..3.0f64, y in -3.0..3.0f64, speed in 0.0..1.0f64, turn in 0.0..6.3f64, cut in 0.1..0.9f64,
    ) {
        let moving = HalfSpace::new(steel(), [speed * turn.cos(), speed * turn.sin()]).unwrap();
        let scale = 1e-3;
        let whole = moving.influence([x * scale, y * scale], [2.0 * scale, scale]).unwrap();
        // cut across x: left part of the length 2 cut, right part of the rest
        let parts = [(cut - 1.0, 2.0 * cut), (cut, 2.0 - 2.0 * cut)];
        let sum: f64 = parts
            .iter()
            .map(|(centre, length)| {
                moving.influence([(x - centre) * scale, y * scale], [length * scale, scale]).unwrap()
            })
            .sum();
        let size = moving.influence([0.0, 0.0], [2.0 * scale, scale]).unwrap();
        prop_assert!((whole - sum).abs() < 1e-7 * size, "{} {}", whole, sum);
        prop_assert!(whole > -1e-9 * size);
    }
}

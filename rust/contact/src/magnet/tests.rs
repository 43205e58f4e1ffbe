// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{Circuit, Iron, Limb, PERMEABILITY, Poles};
use crate::error::Error;

/// Iron that saturates at 2 T after a bend at 1.5 T.
fn iron() -> Iron {
    let field = [1e2, 1e4, 1e5];
    let density = [1.5, 1.9, 2.0 + PERMEABILITY * 1e5];
    Iron::new(&field, &density).unwrap()
}

fn poles(areas: &[f64], points: &[usize]) -> Poles {
    Poles {
        area: areas.to_vec(),
        points: points.to_vec(),
        iron_share: 1.5,
        length: 0.1,
        non_magnetic_gap: 5e-4,
    }
}

fn circuit(ampere_turns: f64, limbs: [Option<Limb>; 2], leakage: f64) -> Circuit {
    let poles = poles(&[1e-4, 2e-4, 1.5e-4], &[2, 1]);
    Circuit::new(iron(), ampere_turns, poles, limbs, leakage).unwrap()
}

const GAP: [f64; 3] = [0.0, 2e-4, 1e-4];

#[test]
fn iron_of_no_length_leaves_the_closed_form() {
    let given = Poles {
        length: 0.0,
        ..poles(&[1e-4, 1e-4], &[1, 1])
    };
    let circuit = Circuit::new(iron(), 1000.0, given, [None; 2], 0.0).unwrap();
    let found = circuit.attract(&[1e-4; 2], 0.8).unwrap();
    let density = PERMEABILITY * 500.0 / 6e-4;
    for i in 0..2 {
        assert!((found.flux_density[i] / density - 1.0).abs() < 1e-12);
        let pressure = 0.8 * 1.5 * density * density / (2.0 * PERMEABILITY);
        assert!((found.pressure[i] / pressure - 1.0).abs() < 1e-12);
        assert!((found.slope[i] / (-2.0 * pressure / 6e-4) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn the_flux_is_one_and_the_forces_are_those_of_the_coil() {
    let yoke = Limb {
        length: 0.2,
        area: 3e-4,
    };
    let rail = Limb {
        length: 0.1,
        area: 5e-4,
    };
    for (ampere_turns, leakage) in [(200.0, 0.0), (2000.0, 1e-8), (9000.0, 1e-8), (1e5, 3e-8)] {
        let circuit = circuit(ampere_turns, [Some(yoke), Some(rail)], leakage);
        let found = circuit.attract(&GAP, 1.0).unwrap();
        let density = &found.flux_density;
        let left = 1.5 * (1e-4 * density[0] + 2e-4 * density[1]);
        let right = 1.5 * 1.5e-4 * density[2];
        assert!((left / right - 1.0).abs() < 1e-10);
        assert!((found.flux / right - 1.0).abs() < 1e-10);
        // each point has the force of its pole
        for (i, force) in [0, 0, 1]
            .map(|pole| found.forces[pole])
            .into_iter()
            .enumerate()
        {
            let taken =
                iron().field(density[i]) * 0.1 + density[i] * (GAP[i] + 5e-4) / PERMEABILITY;
            assert!((taken / force - 1.0).abs() < 1e-10);
        }
        let outer = found.forces.iter().sum::<f64>() + iron().field(found.flux / 5e-4) * 0.1;
        let yoke = iron().field((found.flux + leakage * outer) / 3e-4) * 0.2;
        assert!(((outer + yoke) / ampere_turns - 1.0).abs() < 1e-10);
    }
}

#[test]
fn the_slope_is_that_of_differences() {
    // one pole without limbs: its force is that of the coil
    for ampere_turns in [300.0, 900.0, 2000.0, 3000.0] {
        let circuit = Circuit::new(iron(), ampere_turns, poles(&[1e-4], &[1]), [None; 2], 0.0);
        let circuit = circuit.unwrap();
        let pressure = |gap: f64| circuit.attract(&[gap], 1.0).unwrap().pressure[0];
        let slope = circuit.attract(&[2e-4], 1.0).unwrap().slope[0];
        let step = 1e-8;
        let by_differences = (pressure(2e-4 + step) - pressure(2e-4 - step)) / (2.0 * step);
        assert!((slope - by_differences).abs() <= 1e-6 * by_differences.abs());
    }
}

#[test]
fn the_pull_falls_with_the_gap_and_never_exceeds_that_of_saturated_iron() {
    let mut last = f64::INFINITY;
    for k in 0..40 {
        let gap = 1e-5 * f64::from(k * k);
        let pressure = circuit(4000.0, [None; 2], 0.0)
            .attract(&[gap; 3], 1.0)
            .unwrap()
            .pressure;
        assert!(pressure[2] < last);
        last = pressure[2];
    }
    let limit = 1.5 * 2.0_f64.powi(2) / (2.0 * PERMEABILITY);
    for ampere_turns in [1e5, 1e7] {
        let circuit = circuit(ampere_turns, [None; 2], 0.0);
        assert!((circuit.limit() / limit - 1.0).abs() < 1e-12);
        let found = circuit.attract(&GAP, 1.0).unwrap();
        assert!(found.pressure.iter().all(|p| *p <= limit * (1.0 + 1e-12)));
        assert!((found.pressure[2] / limit - 1.0).abs() < 1e-12);
        assert_eq!(found.slope[2], 0.0);
    }
}

#[test]
fn what_is_no_iron_and_no_magnet_is_refused() {
    let told = |iron: Result<Iron, Error>| iron.unwrap_err().to_string();
    assert!(told(Iron::new(&[1.0, 1.0], &[1.0, 2.0])).starts_with("step of field[1] is 0"));
    assert!(told(Iron::new(&[1.0, 1e6], &[1.0, 1.5])).contains("beyond that in vacuum[1]"));
    assert!(told(Iron::new(&[0.0], &[0.0])).starts_with("field has 1 entries"));
    let refused = |ampere_turns: f64, poles: Poles| {
        let made = Circuit::new(iron(), ampere_turns, poles, [None; 2], 0.0);
        made.unwrap_err().to_string()
    };
    assert!(refused(0.0, poles(&[1.0], &[1])).starts_with("ampere_turns is 0"));
    assert!(refused(1.0, poles(&[1.0], &[2])).starts_with("area has 1 entries, expected 2"));
    let open = Poles {
        non_magnetic_gap: 0.0,
        ..poles(&[1.0], &[1])
    };
    assert!(refused(1.0, open).starts_with("non_magnetic_gap is 0"));
}

/// The derivative at 0 by central differences with Richardson's extrapolation.
fn limit(of: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
    let [a, b, c, d] = [1.0, -1.0, 0.5, -0.5].map(of);
    (0..a.len())
        .map(|i| (4.0 * (c[i] - d[i]) - 0.5 * (a[i] - b[i])) / 3.0)
        .collect()
}

fn assert_close(found: &[f64], wanted: &[f64], name: &str) {
    let size = wanted.iter().fold(0.0_f64, |m, w| m.max(w.abs()));
    for (f, w) in found.iter().zip(wanted) {
        assert!((f - w).abs() <= 1e-6 * size, "{name}: {f:e}, {w:e}");
    }
}

#[test]
fn slopes_are_limits_of_differences() {
    let gap = [0.5e-4, 2e-4, 1e-4];
    let limbs = |sizes: [f64; 4]| {
        [0, 2].map(|k| {
            Some(Limb {
                length: sizes[k],
                area: sizes[k + 1],
            })
        })
    };
    // below the bend, beyond it, and saturated
    for ampere_turns in [600.0, 2000.0, 1e5] {
        let given = [
            ampere_turns,
            5e-4,
            1.5,
            0.1,
            1e-8,
            0.2,
            3e-4,
            0.1,
            5e-4,
            0.8,
        ];
        let made = |g: [f64; 10]| {
            let poles = Poles {
                iron_share: g[2],
                length: g[3],
                non_magnetic_gap: g[1],
                ..poles(&[1e-4, 2e-4, 1.5e-4], &[2, 1])
            };
            Circuit::new(iron(), g[0], poles, limbs([g[5], g[6], g[7], g[8]]), g[4]).unwrap()
        };
        let circuit = made(given);
        let slopes = circuit.slopes(&gap, given[9]).unwrap();
        for (k, name) in super::PARAMETERS.iter().enumerate() {
            // the weakest parameter changes the pressure by a ten-thousandth of its own change
            let step = 1e-3 * given[k];
            let wanted = limit(|share| {
                let mut changed = given;
                changed[k] += share * step;
                made(changed).attract(&gap, changed[9]).unwrap().pressure
            });
            let found: Vec<f64> = slopes.of_parameters()[k].iter().map(|p| p * step).collect();
            assert_close(&found, &wanted, name);
        }
        let (change, weights) = ([2e-9, -1e-9, 3e-9], [0.3, -0.7, 1.1]);
        let wanted = limit(|share| {
            let moved: Vec<f64> = gap.iter().zip(change).map(|(g, d)| g + share * d).collect();
            circuit.attract(&moved, given[9]).unwrap().pressure
        });
        let found = slopes.times(&change).unwrap();
        assert_close(&found, &wanted, "gap");
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (one, other) = (
            dot(&weights, &found),
            dot(&slopes.transposed(&weights).unwrap(), &change),
        );
        assert!((one - other).abs() <= 1e-12 * one.abs());
    }
}

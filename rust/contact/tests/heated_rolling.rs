// SPDX-License-Identifier: MIT OR Apache-2.0
//! Friction that follows the temperature: a line in full sliding, of which the coefficient is known in closed form.

use std::f64::consts::PI;

use mtb_contact::Error;
use mtb_contact::friction::Friction;
use mtb_contact::tangential::{
    Bodies, Drive, Motion, PatchOperators, TangentialProblem, TangentialSolution, solve,
};
use mtb_contact::temperature::TemperatureLaw;
use mtb_elasticity::Material;
use mtb_elasticity::half_space::TangentialPair;
use mtb_heat::Conductor;
use mtb_operator::{Grid, unmonitored};

const LENGTH: f64 = 10e-3;
const PRESSURE: f64 = 5e8;
const SPEED: f64 = 25.0;
const CREEPAGE: f64 = 0.04;
const MU: f64 = 0.4;
/// Temperature at which nothing is left of the coefficient [K].
const COLD: f64 = 400.0;

fn steel() -> Conductor {
    Conductor::new(50.0, 7850.0, 490.0).unwrap()
}

fn law() -> TemperatureLaw {
    let table = (vec![0.0, COLD], vec![MU, 0.0]);
    TemperatureLaw::new(table.0, table.1, [steel(), steel()], [0.0; 2], None).unwrap()
}

/// A band of uniform pressure between bodies that hardly give way, `cells` along the rolling direction.
fn rolled(cells: usize, friction: &Friction, motion: &str) -> Result<TangentialSolution, Error> {
    let dx = LENGTH / cells as f64;
    let grid = Grid::new(cells, 1, dx, LENGTH).unwrap();
    let hard = Material::new(1e16, 0.3).unwrap();
    let pair = TangentialPair::new(Some(&hard.into()), Some(&hard.into()));
    let tangential = |cell, offset| pair.tangential(cell, offset);
    let bodies = Bodies {
        tangential: &tangential,
        by_pressure: None,
        layer: 0.0,
        is_mirrored: pair.is_mirrored(),
        inclination: None,
        across: None,
    };
    let step = [dx, 0.0];
    let motion = match motion {
        "steady" => Motion::Steady { step },
        "transient" => Motion::Transient { step },
        _ => Motion::Shift,
    };
    let operators = PatchOperators::new(&bodies, grid, motion)?;
    let pressure = vec![PRESSURE; cells];
    let problem = TangentialProblem {
        around: None,
        pressure: &pressure,
        origin: [0.0; 2],
        drive: [Drive::Slip(CREEPAGE), Drive::Slip(0.0)],
        rigid_slip: None,
        spin: 0.0,
        speed: SPEED,
        friction,
        plasticity: None,
        earlier: None,
        start: None,
        tolerance: 1e-11,
    };
    solve(&operators, &problem, &unmonitored)
}

/// Coefficient at a distance [m] behind the leading edge, over that of cold surfaces.
///
/// With `T = A int mu(s) / sqrt(x - s) ds` and `mu = MU (1 - T / COLD)` it is `exp(z^2) erfc(z)`, `z = MU A / COLD
/// sqrt(pi x)`: the sum of `(-z)^k / Gamma(k / 2 + 1)`.
fn left(x: f64) -> f64 {
    let beta = 2.0 * steel().effusivity();
    let rise = PRESSURE * CREEPAGE * SPEED / (beta * (PI * SPEED).sqrt());
    let z = MU * rise / COLD * (PI * x).sqrt();
    // Gamma(k / 2 + 1) from those of two terms before
    let mut gamma = [1.0, 0.5 * PI.sqrt()];
    let (mut sum, mut power) = (0.0, 1.0);
    for k in 0..120_u32 {
        sum += power / gamma[0];
        power *= -z;
        gamma = [gamma[1], gamma[0] * (0.5 * f64::from(k) + 1.0)];
    }
    sum
}

#[test]
fn a_line_in_full_sliding_loses_friction_as_its_closed_form() {
    let friction = Friction::TemperatureDependent(law());
    let errors: Vec<f64> = [25, 50, 100, 200]
        .into_iter()
        .map(|cells| {
            let solution = rolled(cells, &friction, "steady").unwrap();
            assert!(solution.converged);
            let rounds = solution.rounds.unwrap();
            assert!(rounds.count < 30 && rounds.change < 1e-8, "{rounds:?}");
            let dx = LENGTH / cells as f64;
            let wrong = |k: usize| {
                // rolling along +x, particles come in at the last cell
                let x = LENGTH - (k as f64 + 0.5) * dx;
                solution.coefficient[k] / MU - left(x)
            };
            (0..cells).map(|k| wrong(k).abs()).sum::<f64>() / cells as f64
        })
        .collect();
    assert!(left(LENGTH) < 0.8, "the line hardly heats");
    assert!(errors[3] < 2e-3, "{errors:?}");
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.6 * pair[0], "{errors:?}");
    }
}

#[test]
fn a_law_without_slope_is_coulombs_and_other_motions_refuse_it() {
    let flat = TemperatureLaw::new(
        vec![0.0, 300.0],
        vec![0.3, 0.3],
        [steel(), steel()],
        [20.0, 80.0],
        None,
    );
    let flat = Friction::TemperatureDependent(flat.unwrap());
    let found = rolled(40, &flat, "steady").unwrap();
    let coulomb = rolled(40, &Friction::Coulomb(vec![0.3; 40]), "steady").unwrap();
    assert_eq!(found.traction, coulomb.traction);
    assert_eq!(coulomb.rounds, None);
    for motion in ["transient", "shift"] {
        assert_eq!(rolled(40, &flat, motion).unwrap_err(), Error::NoTemperature);
    }
}

#[test]
fn a_law_meets_its_bodies_at_their_common_temperature() {
    let copper = Conductor::new(390.0, 8900.0, 385.0).unwrap();
    let table = || (vec![0.0, 100.0, 200.0], vec![0.1, 0.3, 0.2]);
    let made = |bulk| TemperatureLaw::new(table().0, table().1, [steel(), copper], bulk, None);
    let law = made([150.0, 150.0]).unwrap();
    assert!((law.at_rest() - 0.25).abs() < 1e-15);
    assert_eq!(
        (law.at(-5.0), law.at(500.0), law.largest()),
        (0.1, 0.2, 0.3)
    );
    // copper outweighs steel
    let [steel, copper] = [steel().effusivity(), copper.effusivity()];
    let common = 80.0 * copper / (steel + copper);
    let expected = 0.1 + 0.2 * common / 100.0;
    assert!((made([0.0, 80.0]).unwrap().at_rest() - expected).abs() < 1e-15);
    assert!(made([f64::NAN, 0.0]).is_err());
    let bodies = law.bodies;
    for (temperature, coefficient) in [
        (vec![0.0, 0.0], vec![0.3, 0.2]),
        (vec![0.0, 1.0], vec![0.3, -0.2]),
        (vec![0.0, 1.0], vec![0.3]),
        (vec![], vec![]),
    ] {
        let made = TemperatureLaw::new(temperature, coefficient, bodies, [0.0; 2], None);
        assert!(made.is_err());
    }
}

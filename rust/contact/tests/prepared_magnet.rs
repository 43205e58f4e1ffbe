// SPDX-License-Identifier: MIT OR Apache-2.0
//! Prepared contacts under a magnet whose pull follows the gap, in memory and out of bytes.

use std::sync::Arc;

use mtb_complementarity::linear::Status;
use mtb_contact::magnet::{Circuit, Iron, Limb, Magnet, Poles};
use mtb_contact::prepared::{
    INPUTS, MagnetOverSpeed, Magnetic, OUTPUTS, Prepared, PreparedContact, Pull, Sliding, Source,
    Step, StuckStep, Table,
};
use mtb_contact::problem::{
    Attracted, Body, FreeMotion, Friction, Geometry, Loading, Outcome, Problem,
};
use mtb_elasticity::Material;
use mtb_elasticity::half_space::HalfSpace;
use mtb_operator::{Grid, Relative, unmonitored};

const SIDE: usize = 6;
const M: usize = SIDE * SIDE;
const FREE: [f64; 6] = [f64::NAN; 6];
const BODIES: [Attracted; 2] = [
    Attracted {
        body: Body::Upper,
        at_face: false,
    },
    Attracted {
        body: Body::Lower,
        at_face: true,
    },
];

fn at(i: usize) -> [f64; 2] {
    [i % SIDE, i / SIDE].map(|k| (k as f64 - 2.5) * 1e-3)
}

/// A crowned body over a plate of half-space cells that is pulled at its face, free to come down.
fn problem() -> (Problem, Loading) {
    let unit = |axis: usize| -> Vec<f64> {
        (0..3 * M)
            .map(|k| f64::from(u8::from(k / M == axis)))
            .collect()
    };
    let frame = [unit(0), unit(1), unit(2)];
    let geometry = Arc::new(Geometry {
        points: (0..3 * M)
            .map(|k| if k < 2 * M { at(k % M)[k / M] } else { 0.0 })
            .collect(),
        tangent_x: frame[0].clone(),
        tangent_y: frame[1].clone(),
        normal: frame[2].clone(),
        area: vec![1e-6; M],
        mean_frame: frame,
        means: None,
        windows: Vec::new(),
    });
    let grid = Grid::new(SIDE, SIDE, 1e-3, 1e-3).unwrap();
    let soft = HalfSpace::new(Material::new(1e9, 0.1).unwrap(), grid).unwrap();
    let hard = HalfSpace::new(Material::new(2e9, 0.3).unwrap(), grid).unwrap();
    let pair = Relative::new(Some(Arc::new(soft)), Some(Arc::new(hard))).unwrap();
    let lift = FreeMotion::of(&geometry, Body::Upper, &unit(2)).unwrap();
    let problem = Problem::new(pair, geometry, vec![lift]).unwrap();
    let gap: Vec<f64> = (0..M)
        .map(|i| at(i).map(|v| v * v / 0.2).iter().sum())
        .collect();
    let mut loading = problem.unloaded(gap);
    loading.work[0] = -5.0;
    (problem, loading)
}

fn circuit(ampere_turns: f64) -> Circuit {
    let iron = Iron::new(&[500.0, 5e4], &[1.4, 2.2]).unwrap();
    let limb = Some(Limb {
        length: 0.1,
        area: 2e-5,
    });
    let poles = Poles {
        area: vec![1e-6; M],
        points: vec![M / 2, M / 2],
        iron_share: 1.2,
        length: 5e-3,
        non_magnetic_gap: 1e-4,
    };
    Circuit::new(iron, ampere_turns, poles, [limb, None], 1e-9).unwrap()
}

fn factor() -> Table {
    Table::new(vec![0.0, 4.0], vec![vec![1.0], vec![0.5]]).unwrap()
}

fn prepared(problem: &Problem, loading: &Loading, source: Source) -> Arc<Prepared> {
    let magnetic = Magnetic {
        bodies: &BODIES,
        source,
    };
    let sliding = Sliding {
        friction: Table::constant(vec![0.3; M]),
        direction: [1.0, 0.0],
        standstill_speed: None,
        velocity: None,
        layer: 0.0,
    };
    let named = vec![("z".to_owned(), Some(2))];
    let made = Prepared::new(
        problem,
        loading,
        Some(&magnetic),
        named,
        sliding,
        [0.0; 3],
        &unmonitored,
    );
    Arc::new(made.unwrap())
}

fn with_magnet() -> Arc<Prepared> {
    let (problem, loading) = problem();
    let source = Source::Magnet(MagnetOverSpeed {
        circuit: circuit(300.0),
        factor: factor(),
    });
    prepared(&problem, &loading, source)
}

fn step(pose: [f64; 6], velocity: [f64; 2], pull: Pull<'_>, shift: Option<[f64; 2]>) -> Step<'_> {
    Step {
        pose,
        velocity,
        pull,
        gap: None,
        friction: None,
        diagonal: None,
        shift,
    }
}

fn lifted(z: f64) -> [f64; 6] {
    let mut pose = FREE;
    pose[2] = z;
    pose
}

fn attraction(out: &Outcome) -> f64 {
    out.settled.as_ref().unwrap().pull.iter().sum::<f64>() * 1e-6
}

/// The problem itself solves the same state by another solver, in which the bodies are products and no matrices.
#[test]
fn steps_are_what_the_problem_solves() {
    let (problem, loading) = problem();
    let mut contact = PreparedContact::new(with_magnet());
    let direction = problem.geometry().sliding_direction([1.0, 0.0]).unwrap();
    let circuit = circuit(300.0);
    let magnet = Magnet {
        circuit: &circuit,
        bodies: &BODIES,
        factor: 0.75,
    };
    let friction = Friction::Field(&[0.3; M]);
    let whole = problem
        .slide_attracted(
            &loading,
            &magnet,
            None,
            &direction,
            friction,
            None,
            false,
            &unmonitored,
        )
        .unwrap();
    assert_eq!(whole.solution.status, Status::Solved);
    let found = contact
        .step(&step(FREE, [2.0, 0.0], Pull::Scene, None), &unmonitored)
        .unwrap();
    let largest = whole.solution.pressure.iter().copied().fold(0.0, f64::max);
    assert!(largest > 0.0);
    for (a, b) in (found.solution.pressure.iter()).zip(&whole.solution.pressure) {
        assert!((a - b).abs() < 1e-8 * largest, "{a} {b}");
    }
    // what pulls the body carries its weight with it
    assert!((found.force[2] + 5.0 + attraction(&found)).abs() < 1e-9 * attraction(&found));
}

/// Bytes hold the magnet: the numbers are the same, bit for bit, in sliding and in sticking.
#[test]
fn bytes_step_as_the_contact_does() {
    let made = with_magnet();
    let sliding = made.to_bytes(&unmonitored).unwrap();
    let sticking = made.to_bytes_for_shifts(&unmonitored).unwrap();
    let read = [&sliding, &sticking].map(|bytes| Arc::new(Prepared::from_bytes(bytes).unwrap()));
    assert_eq!(read[0].magnet, made.magnet);
    assert_eq!(read[0].to_bytes(&unmonitored).unwrap(), sliding);
    assert_eq!(read[1].to_bytes_for_shifts(&unmonitored).unwrap(), sticking);
    for cut in [9, 40, sliding.len() / 2, sliding.len() - 3] {
        assert!(Prepared::from_bytes(&sliding[..cut]).is_err());
    }
    let mut contacts = [&made, &read[0], &read[1]].map(|p| PreparedContact::new(p.clone()));
    let mut pulls = Vec::new();
    for (pose, pull) in [
        (FREE, Pull::Scene),
        (lifted(3e-4), Pull::Scene),
        (lifted(3e-4), Pull::AmpereTurns(150.0)),
        (FREE, Pull::AmpereTurns(0.0)),
        (FREE, Pull::Uniform(1e5)),
        (lifted(1e-5), Pull::Scene),
    ] {
        let [one, two, three] = contacts.each_mut().map(|contact| {
            let step = step(pose, [1.0, 0.5], pull, None);
            contact.step(&step, &unmonitored).unwrap()
        });
        for other in [two, three] {
            assert_eq!(one.force, other.force);
            assert_eq!(one.settled, other.settled);
        }
        pulls.push(one.settled.map_or(f64::NAN, |s| s.pull.iter().sum()));
    }
    assert!(pulls[0] > pulls[1] && pulls[1] > pulls[2] && pulls[3] == 0.0);
    let mut sticks = [&made, &read[1]].map(|p| PreparedContact::new(p.clone()));
    for (k, along) in [0.0, 2e-7, 1e-7, -3e-7, 2e-5].into_iter().enumerate() {
        let shifted = step(FREE, [1.0, 0.0], Pull::Scene, Some([along, 0.5 * along]));
        let [one, other] = sticks
            .each_mut()
            .map(|c| c.step(&shifted, &unmonitored).unwrap());
        assert_eq!(one.force, other.force);
        assert_eq!(one.points, other.points);
        // a memory goes on as the contact does, with the pull in it
        let memory = sticks[0].memory().unwrap();
        assert_eq!(memory.len(), made.memory_size());
        let mut copy = PreparedContact::new(made.clone());
        copy.recall(&memory).unwrap();
        let next = step(FREE, [1.0, 0.0], Pull::Scene, Some([1e-8, 0.0]));
        let mut again = PreparedContact::new(made.clone());
        again.recall(&memory).unwrap();
        let [a, b] = [&mut copy, &mut again].map(|c| c.step(&next, &unmonitored).unwrap());
        assert_eq!(a.force, b.force, "{k}");
    }
}

/// A contact that was prepared without a magnet takes one in a step, but its file does not know what it pulls.
#[test]
fn files_without_a_magnet_refuse_one() {
    let (problem, loading) = problem();
    let made = prepared(&problem, &loading, Source::Steps);
    let own = circuit(300.0);
    let following = mtb_contact::prepared::Following {
        circuit: &own,
        factor: 0.75,
        by_speed: 0.0,
    };
    let given = step(FREE, [2.0, 0.0], Pull::Following(following), None);
    let found = PreparedContact::new(made.clone())
        .step(&given, &unmonitored)
        .unwrap();
    let own = PreparedContact::new(with_magnet())
        .step(&step(FREE, [2.0, 0.0], Pull::Scene, None), &unmonitored)
        .unwrap();
    assert_eq!(found.force, own.force);
    let read = Prepared::from_bytes(&made.to_bytes(&unmonitored).unwrap()).unwrap();
    let mut read = PreparedContact::new(Arc::new(read));
    let refused = read.step(&given, &unmonitored).unwrap_err().to_string();
    assert!(refused.contains("written without one"), "{refused}");
    let driven = step(FREE, [2.0, 0.0], Pull::AmpereTurns(100.0), None);
    let refused = read.step(&driven, &unmonitored).unwrap_err().to_string();
    assert!(
        refused.contains("which alone has ampere_turns"),
        "{refused}"
    );
    let negative = step(FREE, [2.0, 0.0], Pull::AmpereTurns(-1.0), None);
    let refused = PreparedContact::new(with_magnet()).step(&negative, &unmonitored);
    assert!(
        refused
            .unwrap_err()
            .to_string()
            .starts_with("ampere_turns is -1")
    );
}

/// Force, attraction and work of a step, as outputs of its derivatives.
fn told(out: &Outcome, peak: f64) -> [f64; OUTPUTS.len()] {
    let ([fx, fy, fz], [mx, my, mz]) = (out.force, out.moment);
    let power = (out.slipped.as_ref()).map_or(out.friction_power, |slipped| slipped.work);
    [fx, fy, fz, mx, my, mz, power, peak, attraction(out)]
}

/// Derivatives against central differences of steps, of sliding and of sticking.
#[test]
fn derivatives_are_those_of_differences() {
    let made = with_magnet();
    let peak = |out: &Outcome| out.solution.pressure.iter().copied().fold(0.0, f64::max);
    let start = [0.0, 0.0, -2e-6, 1e-4, -2e-4, 0.0, 1.5, 0.4, f64::NAN, 280.0];
    let slide = |given: &[f64; INPUTS.len()]| {
        let mut pose = [0.0; 6];
        pose.copy_from_slice(&given[..6]);
        let step = step(
            pose,
            [given[6], given[7]],
            Pull::AmpereTurns(given[9]),
            None,
        );
        let mut contact = PreparedContact::new(made.clone());
        let out = contact.step(&step, &unmonitored).unwrap();
        (told(&out, peak(&out)), contact)
    };
    let (here, mut contact) = slide(&start);
    let jacobian = contact.jacobian(&unmonitored).unwrap();
    compare(
        &start,
        &[1e-10, 1e-8, 1e-6, 1e-3],
        &here,
        &jacobian,
        |given| slide(given).0,
    );

    let stick = |given: &[f64; StuckStep::INPUTS]| {
        let mut contact = PreparedContact::new(made.clone());
        for shift in [0.0, 3e-7] {
            let before = step(FREE, [1.0, 0.0], Pull::Scene, Some([shift, 0.0]));
            contact.step(&before, &unmonitored).unwrap();
        }
        let mut pose = [0.0; 6];
        pose.copy_from_slice(&given[..6]);
        let step = step(
            pose,
            [given[8], given[9]],
            Pull::AmpereTurns(given[11]),
            Some([given[6], given[7]]),
        );
        let out = contact.step(&step, &unmonitored).unwrap();
        (told(&out, peak(&out)), contact)
    };
    let start = [
        0.0,
        0.0,
        f64::NAN,
        1e-5,
        -2e-5,
        0.0,
        2e-7,
        -1e-7,
        1.5,
        0.4,
        f64::NAN,
        280.0,
    ];
    let (here, contact) = stick(&start);
    let stuck = contact.stuck().unwrap();
    let jacobian = stuck.jacobian().unwrap();
    compare(
        &start,
        &[1e-10, 1e-8, 1e-6, 1e-3],
        &here,
        &jacobian,
        |given| stick(given).0,
    );
}

/// Each column against central differences; `steps` are those of lengths, angles, velocities and ampere-turns.
fn compare<const C: usize>(
    start: &[f64; C],
    steps: &[f64; 4],
    here: &[f64; OUTPUTS.len()],
    jacobian: &[[f64; C]; OUTPUTS.len()],
    told: impl Fn(&[f64; C]) -> [f64; OUTPUTS.len()],
) {
    let step = |c: usize| match c {
        0..3 => steps[0],
        3..6 => steps[1],
        c if c == C - 1 => steps[3],
        c if C == StuckStep::INPUTS && c < 8 => steps[0],
        _ => steps[2],
    };
    let mut moved = 0;
    for c in (0..C).filter(|&c| !start[c].is_nan()) {
        let [more, less] = [1.0, -1.0].map(|sign| {
            let mut given = *start;
            given[c] += sign * step(c);
            told(&given)
        });
        for (k, row) in jacobian.iter().enumerate() {
            let wanted = (more[k] - less[k]) / (2.0 * step(c));
            // changes by rounding, and what the state is found to, over the step
            let noise = 1e-9 * here[k].abs().max(1e-6) / step(c);
            assert!(
                (row[c] - wanted).abs() <= 1e-4 * wanted.abs() + noise,
                "{} by {c}: {} {wanted}",
                OUTPUTS[k],
                row[c]
            );
        }
        moved += usize::from(jacobian[8][c] != 0.0);
    }
    assert!(moved >= 4, "{moved} columns move the attraction");
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies that conduct heat and expand by it, against closed forms.

#[allow(dead_code, reason = "other tests use the rest")]
mod box_mesh;

use std::f64::consts::PI;
use std::sync::Arc;

use box_mesh::{box_mesh, even, faces_where, nodes_where};
use mtb_elasticity::tetra::{
    ConductingBody, ContactGrid, Film, Hold, Limits, Order, Sampling, Support, TetraBody, TetraMesh,
};
use mtb_elasticity::{Error, Material};
use mtb_heat::Conductor;
use mtb_operator::unmonitored;

const ORDERS: [Order; 2] = [Order::Linear, Order::Quadratic];

fn steel() -> Conductor {
    Conductor::new(50.0, 7850.0, 450.0).unwrap()
}

/// A bar along z whose lower end is the contact: its mesh, and one basis function over the whole end.
fn bar(order: Order, length: f64, lines: &[f64]) -> (Arc<TetraMesh>, Sampling) {
    let side = even(0.0, 1e-3, 1);
    let z: Vec<f64> = lines.iter().map(|t| t * length).collect();
    let mesh = box_mesh(&side, &side, &z, order);
    let sampling = face(&mesh, 1, 1e-3);
    (Arc::new(mesh), sampling)
}

/// Hats on the lower face of a square of `size` with `n` cells a side.
fn face(mesh: &TetraMesh, n: usize, size: f64) -> Sampling {
    let faces = faces_where(mesh, |x| x[2].abs() < 1e-12);
    let spacing = size / n as f64;
    let points: Vec<[f64; 3]> = (0..(n + 1) * (n + 1))
        .map(|k| {
            [
                (k % (n + 1)) as f64 * spacing,
                (k / (n + 1)) as f64 * spacing,
                0.0,
            ]
        })
        .collect();
    let frame = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
    let grid = ContactGrid {
        nx: n + 1,
        ny: n + 1,
        spacing: [spacing; 2],
        frames: vec![frame; points.len()],
        points,
    };
    grid.sampling(mesh, &faces).unwrap()
}

/// Lines that are finer towards the contact.
fn graded(n: usize) -> Vec<f64> {
    (0..=n).map(|k| (k as f64 / n as f64).powi(3)).collect()
}

#[test]
fn a_uniform_flux_heats_as_the_root_of_the_time() {
    // so short that the other end stays cold
    let (end, flux) = (0.5, 1e6);
    let exact = 2.0 * flux * (end / PI).sqrt() / steel().effusivity();
    for order in ORDERS {
        let (mesh, sampling) = bar(order, 20e-3, &graded(24));
        let n = mesh.nodes().len();
        let body = Arc::new(ConductingBody::new(mesh, steel(), &[], &unmonitored).unwrap());
        let run = |steps: usize| {
            let step = body
                .step(end / steps as f64, &sampling, &unmonitored)
                .unwrap();
            let mut temperature = vec![0.0; n];
            for _ in 0..steps {
                temperature = step.advance(&temperature, &[flux; 4]).unwrap();
            }
            let area: f64 = step.weights().iter().sum();
            let heat = body.heat(&temperature).unwrap();
            assert!((heat - flux * area * end).abs() < 1e-10 * heat);
            step.observe(&temperature).unwrap()[0]
        };
        let errors = [50, 100, 200].map(|steps| (run(steps) / exact - 1.0).abs());
        assert!(errors[2] < 3e-3, "{order:?} {errors:?}");
        if order == Order::Quadratic {
            // the mesh is fine enough for the order of the steps to show
            assert!(
                errors[0] / errors[1] > 1.7 && errors[1] / errors[2] > 1.7,
                "{errors:?}"
            );
        }
    }
}

#[test]
fn films_cool_a_small_body_exponentially() {
    let (mesh, sampling) = bar(Order::Quadratic, 2e-3, &even(0.0, 1.0, 2));
    let faces: Vec<usize> = (0..mesh.n_faces()).collect();
    let n = mesh.nodes().len();
    let film = Film {
        faces,
        coefficient: 20.0,
        ambient: 15.0,
    };
    let body = Arc::new(ConductingBody::new(mesh, steel(), &[film], &unmonitored).unwrap());
    let (area, volume) = (2.0 * 1e-6 + 4.0 * 2e-6, 2e-9);
    let rate = 20.0 * area / (steel().capacity() * volume);
    let run = |steps: usize| {
        let step = body
            .step(60.0 / steps as f64, &sampling, &unmonitored)
            .unwrap();
        let mut temperature = vec![115.0; n];
        for _ in 0..steps {
            let before = body.heat(&temperature).unwrap();
            temperature = step.advance(&temperature, &[0.0; 4]).unwrap();
            let lost = before - body.heat(&temperature).unwrap();
            let loss = body.loss(&temperature).unwrap() * step.duration();
            assert!((lost - loss).abs() < 1e-10 * before, "{lost} {loss}");
        }
        temperature[0]
    };
    let exact = 15.0 + 100.0 * (-rate * 60.0).exp();
    let errors = [100, 200].map(|steps| (run(steps) - exact).abs());
    assert!(errors[0] / errors[1] > 1.9, "{errors:?}");
    assert!(errors[1] < 0.5);
}

#[test]
fn the_response_is_that_of_the_steps_and_symmetric() {
    let side = even(0.0, 6e-3, 4);
    let mesh = Arc::new(box_mesh(
        &side,
        &side,
        &even(0.0, 5e-3, 3),
        Order::Quadratic,
    ));
    let sampling = face(&mesh, 3, 6e-3);
    let n = mesh.nodes().len();
    let body = Arc::new(ConductingBody::new(mesh, steel(), &[], &unmonitored).unwrap());
    let step = body.step(0.2, &sampling, &unmonitored).unwrap();
    let m = sampling.n_points();
    let (response, weights) = (step.response(), step.weights());
    // what looks at the whole body, and in it at the contact points
    let mut rows: Vec<f64> = (0..3 * n).map(|k| (0.7 * k as f64).sin()).collect();
    rows.extend(vec![1.0; n]);
    let seen = step.seen(&rows, &unmonitored).unwrap();
    let by_one = step.response_of(&seen).unwrap();
    for j in 0..m {
        let mut flux = vec![0.0; m];
        flux[j] = 1e6;
        let warm = step.advance(&vec![0.0; n], &flux).unwrap();
        for (row, by_one) in rows.chunks_exact(n).zip(by_one.chunks_exact(m)) {
            let known: f64 = row.iter().zip(&warm).map(|(r, t)| r * t).sum();
            assert!((known - 1e6 * by_one[j]).abs() < 1e-9 * largest(&warm));
        }
        let found = step.observe(&warm).unwrap();
        for i in 0..m {
            assert!((found[i] - 1e6 * response[i * m + j]).abs() < 1e-9 * found[j]);
            let (a, b) = (
                weights[i] * response[i * m + j],
                weights[j] * response[j * m + i],
            );
            assert!((a - b).abs() < 1e-12 * a.abs().max(b.abs()));
        }
    }
}

/// A block with its contact and a film on the other faces.
fn cooled_block(conductor: Conductor, film: f64) -> (Arc<ConductingBody>, Sampling) {
    let side = even(0.0, 24e-3, 5);
    let mesh = Arc::new(box_mesh(
        &side,
        &side,
        &even(0.0, 16e-3, 4),
        Order::Quadratic,
    ));
    let sampling = face(&mesh, 5, 24e-3);
    let faces = faces_where(&mesh, |x| x[2] > 1e-9);
    let film = Film {
        faces,
        coefficient: film,
        ambient: -7.0,
    };
    let body = ConductingBody::new(mesh, conductor, &[film], &unmonitored).unwrap();
    (Arc::new(body), sampling)
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most: f64, v| most.max(v.abs()))
}

fn apart(found: &[f64], known: &[f64]) -> f64 {
    let apart: Vec<f64> = found.iter().zip(known).map(|(a, b)| a - b).collect();
    largest(&apart) / largest(known)
}

#[test]
fn modes_follow_the_whole_body_through_steps_of_changing_duration() {
    for film in [0.0, 200.0] {
        let (body, sampling) = cooled_block(steel(), film);
        let modes = body.modes(&sampling, &unmonitored).unwrap();
        let n = sampling.n_points();
        assert!(
            modes.count() < body.mesh().nodes().len() / 2,
            "{}",
            modes.count()
        );
        let mut warm = vec![20.0; body.mesh().nodes().len()];
        let mut amplitudes = modes.uniform(20.0);
        assert!(apart(&modes.temperature(&amplitudes).unwrap(), &warm) < 1e-11);
        let durations = [
            1e-3, 4e-3, 4e-3, 0.03, 0.03, 0.03, 0.2, 0.2, 1.7, 1.7, 0.01, 40.0,
        ];
        for (k, duration) in durations.into_iter().enumerate() {
            // uneven over the points, and another at each step
            let flux: Vec<f64> = (0..n)
                .map(|i| 1e6 * (1.0 + (2.3 * i as f64 + 1.1 * k as f64).sin()))
                .collect();
            let step = body.step(duration, &sampling, &unmonitored).unwrap();
            warm = step.advance(&warm, &flux).unwrap();
            let before = modes.heat(&amplitudes).unwrap();
            amplitudes = modes.advance(duration, &amplitudes, &flux).unwrap();
            let seen = modes.observe(&amplitudes).unwrap();
            let error = apart(&seen, &step.observe(&warm).unwrap());
            assert!(error < 1e-6, "{film} {k}: {error:e}");
            let error = apart(&modes.temperature(&amplitudes).unwrap(), &warm);
            assert!(error < 1e-4, "{film} {k}: {error:e}");
            // what a body holds and loses is linear, and heat is not lost between the modes
            let entered: f64 = flux.iter().zip(modes.weights()).map(|(q, w)| q * w).sum();
            let lost = modes.loss(&amplitudes).unwrap();
            let held = modes.heat(&amplitudes).unwrap();
            assert!((held - before - duration * (entered - lost)).abs() < 1e-11 * held.abs());
            assert!((held / body.heat(&warm).unwrap() - 1.0).abs() < 1e-7);
        }
    }
}

#[test]
fn modes_answer_at_any_duration_and_conductivity() {
    let (body, sampling) = cooled_block(steel(), 200.0);
    let modes = body.modes(&sampling, &unmonitored).unwrap();
    let nodes = body.mesh().nodes().len();
    // what looks at the whole body: moments of its temperature
    let rows: Vec<f64> = (0..2)
        .flat_map(|c| body.mesh().nodes().iter().map(move |x| x[2] * x[c]))
        .collect();
    let seen = modes.seen(&rows).unwrap();
    for conductivity in [50.0, 27.0] {
        let conductor = Conductor::new(conductivity, 7850.0, 450.0).unwrap();
        let (whole, _) = cooled_block(conductor, 200.0);
        let modes = modes.with_conductivity(conductivity).unwrap();
        for duration in [1e-6, 1e-3, 7e-3, 0.02, 0.09, 0.5, 3.0, 11.0, 1e2, 1e5] {
            let step = whole.step(duration, &sampling, &unmonitored).unwrap();
            // what films do to heat from the contact is that of the first conductivity
            let is_first = conductivity > 49.0;
            let error = apart(&modes.response(duration).unwrap(), step.response());
            let seen_there = if is_first { 1e-6 } else { 1e-4 };
            assert!(error < seen_there, "{conductivity} {duration}: {error:e}");
            let n = sampling.n_points();
            let by_film = step.advance(&vec![0.0; nodes], &vec![0.0; n]).unwrap();
            let mut known = vec![0.0; 2 * n];
            for j in 0..n {
                let mut flux = vec![0.0; n];
                flux[j] = 1.0;
                let warm = step.advance(&vec![0.0; nodes], &flux).unwrap();
                for (c, row) in rows.chunks(nodes).enumerate() {
                    let warm = warm.iter().zip(&by_film);
                    known[c * n + j] = warm.zip(row).map(|((t, f), r)| (t - f) * r).sum();
                }
            }
            let error = apart(&modes.response_of(duration, &seen).unwrap(), &known);
            // steps that are far shorter than elements resolve add next to nothing
            let is_exact = duration > 5e-3 && is_first;
            let inside = if is_exact { 1e-4 } else { 1e-3 };
            assert!(error < inside, "{conductivity} {duration}: {error:e}");
        }
    }
}

/// A block that rests on its lower face without being hindered in its expansion.
fn block(order: Order, hold: [Hold; 3]) -> (TetraBody, Sampling) {
    let side = even(0.0, 8e-3, 4);
    let mesh = box_mesh(&side, &side, &even(0.0, 6e-3, 4), order);
    let sampling = face(&mesh, 4, 8e-3);
    let top = nodes_where(&mesh, |x| (x[2] - 6e-3).abs() < 1e-12);
    let supports = vec![Support {
        name: "top".into(),
        nodes: top,
        hold,
    }];
    let body = TetraBody::new(mesh, Material::new(80e9, 0.3).unwrap(), supports).unwrap();
    (body, sampling)
}

#[test]
fn a_block_on_a_smooth_support_expands_freely() {
    let alpha = 12e-6;
    for order in ORDERS {
        let (body, sampling) = block(order, [Hold::Free, Hold::Free, Hold::Prescribed]);
        let mesh = body.mesh();
        let n = mesh.nodes().len();
        let found = body
            .expansion(&sampling, alpha, Limits::default(), &unmonitored)
            .unwrap();
        // uniformly warmer by 50 K: the lower face moves down, out of the body
        for row in found.chunks(n) {
            let moved: f64 = row.iter().sum::<f64>() * 50.0;
            assert!(
                (moved + alpha * 50.0 * 6e-3).abs() < 1e-9 * 3.6e-6,
                "{moved}"
            );
        }
        // warmer in proportion to the height: an unloaded body bends, u_z = alpha g (z^2 - x^2 - y^2) / 2
        let gradient: Vec<f64> = found
            .chunks(n)
            .map(|row| {
                row.iter()
                    .zip(mesh.nodes())
                    .map(|(e, x)| e * 1e4 * x[2])
                    .sum()
            })
            .collect();
        if order == Order::Quadratic {
            let centre = gradient[12];
            let corner = gradient[0];
            // which a top that is held flat lessens
            assert!(corner < centre && corner > centre - 0.5 * alpha * 1e4 * 2.0 * 16e-6);
        }
    }
}

#[test]
fn expansion_agrees_with_the_thermal_load_on_a_finer_way() {
    // a row of the expansion is the response to a load; the whole is the solution of the thermal problem, which for
    // a block that is held at its sides and top alone has the displacement of a column: alpha (1 + nu) / (1 - nu)
    let side = even(0.0, 8e-3, 4);
    let mesh = box_mesh(&side, &side, &even(0.0, 6e-3, 6), Order::Quadratic);
    let sampling = face(&mesh, 4, 8e-3);
    let wall = |k: usize| {
        let at = move |x: [f64; 3]| x[k].abs() < 1e-12 || (x[k] - 8e-3).abs() < 1e-12;
        let mut hold = [Hold::Free; 3];
        hold[k] = Hold::Prescribed;
        Support {
            name: format!("wall {k}"),
            nodes: nodes_where(&mesh, at),
            hold,
        }
    };
    let top = Support {
        name: "top".into(),
        nodes: nodes_where(&mesh, |x| (x[2] - 6e-3).abs() < 1e-12),
        hold: [Hold::Free, Hold::Free, Hold::Prescribed],
    };
    let supports = vec![wall(0), wall(1), top];
    let nodes = mesh.nodes().to_vec();
    let body = TetraBody::new(mesh, Material::new(80e9, 0.3).unwrap(), supports).unwrap();
    let found = body
        .expansion(&sampling, 12e-6, Limits::default(), &unmonitored)
        .unwrap();
    // a profile over the height that quadratics hold exactly
    let warmer = |z: f64| 100.0 - 2e6 * z * z;
    let exact = -12e-6 * 1.3 / 0.7 * (100.0 * 6e-3 - 2e6 * 6e-3f64.powi(3) / 3.0);
    for row in found.chunks(nodes.len()) {
        let moved: f64 = row.iter().zip(&nodes).map(|(e, x)| e * warmer(x[2])).sum();
        assert!((moved / exact - 1.0).abs() < 2e-3, "{}", moved / exact);
    }
}

#[test]
fn bad_input_is_refused() {
    let (mesh, sampling) = bar(Order::Linear, 1e-2, &even(0.0, 1.0, 2));
    let film = |coefficient: f64, faces: Vec<usize>| Film {
        faces,
        coefficient,
        ambient: 0.0,
    };
    let made = |film: Film| ConductingBody::new(mesh.clone(), steel(), &[film], &unmonitored).err();
    assert!(matches!(made(film(-1.0, vec![])), Some(Error::Film { .. })));
    assert!(matches!(
        made(film(1.0, vec![10_000])),
        Some(Error::NotOnBoundary(10_000))
    ));
    let body = Arc::new(ConductingBody::new(mesh.clone(), steel(), &[], &unmonitored).unwrap());
    assert!(matches!(
        body.step(0.0, &sampling, &unmonitored).err(),
        Some(Error::Duration(_))
    ));
    let step = body.step(1.0, &sampling, &unmonitored).unwrap();
    assert!(step.advance(&[0.0], &[0.0; 4]).is_err());
    assert!(
        step.advance(&vec![0.0; mesh.nodes().len()], &[0.0, 0.0, f64::NAN, 0.0])
            .is_err()
    );
    let modes = body.modes(&sampling, &unmonitored).unwrap();
    let cold = modes.uniform(0.0);
    assert!(modes.advance(0.0, &cold, &[0.0; 4]).is_err());
    assert!(modes.advance(1.0, &cold, &[0.0; 3]).is_err());
    assert!(modes.advance(1.0, &[], &[0.0; 4]).is_err());
    assert!(modes.response(f64::NAN).is_err());
    assert!(modes.response_of(1.0, &[1.0]).is_err() || modes.count() == 1);
    assert!(matches!(
        modes.with_conductivity(-1.0).err(),
        Some(Error::NotPositive { .. })
    ));
}

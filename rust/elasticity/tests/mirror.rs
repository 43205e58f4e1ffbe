// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies that are their own mirror image are factorised by half. A body of which one node is moved by a hair is
//! not, and must give the same.

#[allow(dead_code, reason = "other tests use the rest")]
mod box_mesh;

use std::collections::HashMap;
use std::sync::Arc;

use box_mesh::{box_arrays, even, faces_where, grid_on_bottom, nodes_where};
use mtb_elasticity::Material;
use mtb_elasticity::tetra::{
    CondensedBody, ConductingBody, Film, Hold, Limits, Order, Sampling, Support, TetraBody,
    TetraMesh,
};
use mtb_heat::Conductor;
use mtb_operator::unmonitored;

/// Half the length of the box along the axis across the mirror, and its other lengths [m].
const HALF: f64 = 0.05;
const SIDES: [f64; 2] = [0.06, 0.04];

/// Shear modulus [Pa].
const SHEAR: f64 = 80e9;

/// By how much one node is moved, as a share of the size: far below the tolerances here, and above those of a mirror.
const HAIR: f64 = 1e-10;

/// A box that is its own image in the plane `x[axis] = 0`, its underside at z = 0; with one node `moved`, it is not.
fn symmetric(axis: usize, order: Order, moved: bool) -> TetraMesh {
    let mut sides = SIDES.iter();
    let places: [Vec<f64>; 3] = std::array::from_fn(|c| {
        if c == axis {
            even(-HALF, 0.0, 4)
        } else {
            even(0.0, *sides.next().unwrap(), 3)
        }
    });
    let (mut nodes, mut cells) = box_arrays(&places[0], &places[1], &places[2], order);
    let half = nodes.len();
    let image: HashMap<usize, usize> = (0..half)
        .map(|node| {
            let mut place = nodes[node];
            if place[axis] > -1e-12 {
                return (node, node);
            }
            place[axis] = -place[axis];
            nodes.push(place);
            (node, nodes.len() - 1)
        })
        .collect();
    let per_cell = if order == Order::Linear { 4 } else { 10 };
    for cell in cells.clone().chunks_exact(per_cell) {
        let mut cell: Vec<usize> = cell.iter().map(|node| image[node]).collect();
        // a mirror turns tetrahedra inside out
        cell.swap(0, 1);
        if per_cell == 10 {
            cell.swap(5, 6);
            cell.swap(7, 8);
        }
        cells.extend(cell);
    }
    if moved {
        nodes[1][axis] += HAIR * HALF;
    }
    TetraMesh::new(nodes, cells, order).unwrap()
}

fn support(name: &str, nodes: Vec<usize>, hold: [Hold; 3]) -> Support {
    Support {
        name: name.into(),
        nodes,
        hold,
    }
}

/// Contact points on the underside, whose grid is its own image or lies aside.
fn contact(mesh: &TetraMesh, axis: usize, aside: f64, count: usize) -> Sampling {
    let [x, y] = [0, 1].map(|c| {
        if c == axis {
            even(-0.8 * HALF + aside, 0.8 * HALF + aside, count)
        } else {
            even(0.0, 0.03, 3)
        }
    });
    grid_on_bottom(mesh, &x, &y)
}

fn close(name: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{name}");
    let size = expected.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    for (k, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!(
            (a - b).abs() <= tolerance * size,
            "{name}[{k}] is {a}, not {b}"
        );
    }
}

fn compare(found: &CondensedBody, expected: &CondensedBody) {
    let parts = |body: &CondensedBody| body.flexibility.clone().into_parts();
    close("weights", &parts(found).0, &parts(expected).0, 1e-9);
    close("flexibility", &parts(found).1, &parts(expected).1, 1e-8);
    let pairs = [
        (
            "cases",
            &found.case_displacement,
            &expected.case_displacement,
        ),
        (
            "spread",
            &found.spread_displacement,
            &expected.spread_displacement,
        ),
    ];
    for (name, a, b) in pairs {
        assert_eq!(a.len(), b.len(), "{name}");
        for (a, b) in a.iter().zip(b.iter()) {
            // some loads move a body as a whole, which is then no displacement
            let elastic = [&a[..], &[1.0 / (SHEAR * HALF)]].concat();
            let expected = [&b[..], &[1.0 / (SHEAR * HALF)]].concat();
            close(name, &elastic, &expected, 1e-8);
        }
    }
    if !found.modes.is_empty() {
        // what supports answer to loads that are out of balance is arbitrary
        return;
    }
    let (a, b) = (&found.balance, &expected.balance);
    for (name, a, b) in [
        ("contact", &a.contact, &b.contact),
        ("reaction", &a.reaction, &b.reaction),
        ("spread_reaction", &a.spread_reaction, &b.spread_reaction),
    ] {
        close(name, a, b, 1e-8);
    }
    // of a unit displacement the forces of a stiff body
    for (k, (a, b)) in a.case_reaction.iter().zip(&b.case_reaction).enumerate() {
        let size = 1e-8 * SHEAR * HALF;
        assert!((a - b).abs() <= size, "case_reaction[{k}] is {a}, not {b}");
    }
}

/// Supports by which the body stays its own image, one set after the other.
fn supports(mesh: &TetraMesh, axis: usize) -> Vec<Vec<Support>> {
    use Hold::{Free, Guided, Prescribed};
    let top = nodes_where(mesh, |x| x[2] > SIDES[1].min(HALF) - 1e-9);
    let ends = nodes_where(mesh, |x| x[axis].abs() > HALF - 1e-9 && x[2] > 0.01);
    let mut across = [Free; 3];
    across[axis] = Guided;
    vec![
        vec![support("top", top.clone(), [Prescribed; 3])],
        vec![support(
            "top",
            top.clone(),
            [Prescribed, Prescribed, Guided],
        )],
        vec![support("top", top.clone(), [Guided; 3])],
        vec![support("top", top, [Free, Free, Guided]), {
            let mut hold = across;
            hold[axis] = if axis == 2 { Free } else { Prescribed };
            support("ends", ends, hold)
        }],
    ]
}

#[test]
fn a_half_gives_what_the_whole_gives() {
    for (axis, order) in [
        (0, Order::Quadratic),
        (1, Order::Linear),
        (0, Order::Linear),
    ] {
        for which in 0..4 {
            for (aside, count) in [(0.0, 6), (0.0, 7), (2e-3, 6)] {
                let [half, whole] = [false, true].map(|moved| {
                    let mesh = symmetric(axis, order, moved);
                    let sampling = contact(&mesh, axis, aside, count);
                    let holds = supports(&mesh, axis).swap_remove(which);
                    let body =
                        TetraBody::new(mesh, Material::new(SHEAR, 0.3).unwrap(), holds).unwrap();
                    let condensed = body.condense(&sampling, Limits::default(), &unmonitored);
                    (condensed, body, sampling)
                });
                let (half, whole) = match (half, whole) {
                    ((Ok(a), b, c), (Ok(d), e, _)) => ((a, b, c), (d, e)),
                    // a flat contact does not hold what supports leave of motions along it
                    ((Err(a), ..), (Err(b), ..)) => {
                        assert_eq!(a.to_string(), b.to_string());
                        continue;
                    }
                    _ => panic!("one is refused, the other is not"),
                };
                assert!(
                    half.0.cost.factor_entries < whole.0.cost.factor_entries,
                    "supports {which}: no half was factorised"
                );
                compare(&half.0, &whole.0);

                // a load of all kinds
                let force: Vec<f64> = (0..3 * half.1.mesh().nodes().len())
                    .map(|k| (k as f64).sin())
                    .collect();
                let cases: Vec<f64> = half.0.cases.iter().map(|c| f64::from(!c.guided)).collect();
                if half.0.modes.is_empty() {
                    let [u, v] = [&half.1, &whole.1].map(|body| {
                        body.solve(&force, &cases, &[], Limits::default(), &unmonitored)
                            .unwrap()
                    });
                    close("displacement", &u, &v, 1e-8);
                    let [u, v] = [&half.1, &whole.1].map(|body| body.observe(&half.2, &u).unwrap());
                    close("observed", &u, &v, 1e-8);
                }
            }
        }
    }
}

#[test]
fn columns_of_a_half_take_half_of_the_work() {
    let costs = [false, true].map(|moved| {
        let mesh = symmetric(0, Order::Quadratic, moved);
        let sampling = contact(&mesh, 0, 0.0, 6);
        let holds = supports(&mesh, 0).swap_remove(0);
        let body = TetraBody::new(mesh, Material::new(SHEAR, 0.3).unwrap(), holds).unwrap();
        body.condense(&sampling, Limits::default(), &unmonitored)
            .unwrap()
            .cost
    });
    assert!(costs[0].forward_flops < 0.7 * costs[1].forward_flops);
    assert!(costs[0].product_flops < 0.7 * costs[1].product_flops);
}

/// A body that conducts, with a film on one end along the y axis, or on the part of it before the plane x = 0.
fn conducting(mesh: TetraMesh, is_film_whole: bool) -> Arc<ConductingBody> {
    let film = Film {
        faces: faces_where(&mesh, |x| {
            x[1] > SIDES[0] - 1e-9 && (is_film_whole || x[0] < 1e-9)
        }),
        coefficient: 300.0,
        ambient: -7.0,
    };
    let steel = Conductor::new(50.0, 7850.0, 450.0).unwrap();
    Arc::new(ConductingBody::new(Arc::new(mesh), steel, &[film], &unmonitored).unwrap())
}

#[test]
fn heat_is_conducted_by_half_as_by_the_whole() {
    for (order, aside) in [(Order::Linear, 0.0), (Order::Quadratic, 0.003)] {
        let [half, whole] = [false, true].map(|moved| {
            let mesh = symmetric(0, order, moved);
            let sampling = contact(&mesh, 0, aside, 5);
            (conducting(mesh, true), sampling)
        });
        let n = half.0.mesh().nodes().len();
        let points = half.1.n_points();
        let mut warm = [vec![20.0; n], vec![20.0; n]];
        for (k, duration) in [0.02, 0.02, 3.0].into_iter().enumerate() {
            let flux: Vec<f64> = (0..points)
                .map(|i| 1e6 * (1.0 + (2.3 * i as f64 + k as f64).sin()))
                .collect();
            let [one, other] = [&half, &whole]
                .map(|(body, sampling)| body.step(duration, sampling, &unmonitored).unwrap());
            assert!(one.has_mirror() && !other.has_mirror());
            close("response", one.response(), other.response(), 1e-9);
            let held = half.0.heat(&warm[0]).unwrap();
            let coasted = [one.coast(&warm[0]).unwrap(), other.coast(&warm[1]).unwrap()];
            let seen = [
                one.observe_coasted(&coasted[0]).unwrap(),
                other.observe_coasted(&coasted[1]).unwrap(),
            ];
            close("coasted", &seen[0], &seen[1], 1e-9);
            let unheated = one.end(&coasted[0], &vec![0.0; points]).unwrap();
            close(
                "unheated",
                &seen[0],
                &one.observe(&unheated).unwrap(),
                1e-12,
            );
            let mut rows: Vec<f64> = (0..3 * n).map(|i| (0.7 * i as f64).sin()).collect();
            // the first of them in the mirror, and a row that is its own image
            let nodes = half.0.mesh().nodes();
            let image = |k: usize| {
                let there = [-nodes[k][0], nodes[k][1], nodes[k][2]];
                let apart = |x: &[f64; 3]| (0..3).all(|c| (x[c] - there[c]).abs() < 1e-9);
                nodes.iter().position(apart).unwrap()
            };
            rows.extend((0..n).map(|k| rows[image(k)]).collect::<Vec<f64>>());
            rows.extend(vec![1.0; n]);
            let by = [
                one.seen(&rows, &unmonitored).unwrap(),
                other.seen(&rows, &unmonitored).unwrap(),
            ];
            let sums = one.seen_coasted(&by[0], &coasted[0]).unwrap();
            let known: Vec<f64> = rows
                .chunks_exact(n)
                .map(|row| row.iter().zip(&unheated).map(|(a, b)| a * b).sum())
                .collect();
            close("seen", &sums, &known, 1e-9);
            let opened = [
                one.response_of(&by[0]).unwrap(),
                other.response_of(&by[1]).unwrap(),
            ];
            close("response of", &opened[0], &opened[1], 1e-8);
            warm = [
                one.end(&coasted[0], &flux).unwrap(),
                other.end(&coasted[1], &flux).unwrap(),
            ];
            close("temperature", &warm[0], &warm[1], 1e-9);
            // what enters is held, but for what the film lets out
            let entered: f64 = flux.iter().zip(one.weights()).map(|(q, w)| q * w).sum();
            let lost = half.0.loss(&warm[0]).unwrap();
            let gained = half.0.heat(&warm[0]).unwrap() - held;
            assert!((gained - duration * (entered - lost)).abs() < 1e-11 * held);
        }
    }
}

#[test]
fn a_film_on_one_side_is_no_mirror_image() {
    let mesh = symmetric(0, Order::Linear, false);
    let sampling = contact(&mesh, 0, 0.0, 5);
    let body = conducting(mesh, false);
    let step = body.step(0.1, &sampling, &unmonitored).unwrap();
    assert!(!step.has_mirror());
}

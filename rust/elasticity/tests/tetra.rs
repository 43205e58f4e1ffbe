// SPDX-License-Identifier: MIT OR Apache-2.0
//! Finite-element bodies: patch test, rigid motions, observed rates, condensation.

mod box_mesh;

use std::cell::Cell;
use std::ops::ControlFlow;

use box_mesh::{box_arrays, box_mesh, even, faces_where, grid_on_bottom, nodes_where};
use mtb_elasticity::tetra::{
    Hold, Limits, Order, RigidMode, Support, SurfacePoint, TetraBody, TetraMesh,
};
use mtb_elasticity::{Error, Material};
use mtb_operator::dense::WORK_UNWATCHED;
use mtb_operator::{Compliance, Component, Progress, unmonitored};

const ORDERS: [Order; 2] = [Order::Linear, Order::Quadratic];

fn steel() -> Material {
    Material::new(80e9, 0.3).unwrap()
}

fn support(name: &str, nodes: Vec<usize>, hold: [Hold; 3]) -> Support {
    Support {
        name: name.into(),
        nodes,
        hold,
    }
}

/// A support for every node of the surface, prescribed in all components.
fn held_surface(mesh: &TetraMesh, inside: impl Fn([f64; 3]) -> bool) -> (Vec<Support>, Vec<usize>) {
    let nodes = nodes_where(mesh, |x| !inside(x));
    let supports = nodes
        .iter()
        .map(|&a| support("node", vec![a], [Hold::Prescribed; 3]))
        .collect();
    (supports, nodes)
}

/// A box whose inner nodes are moved about, so that no two tetrahedra are alike.
fn distorted(order: Order, n: usize) -> TetraMesh {
    let x = even(0.0, 1.0, n);
    let (mut nodes, cells) = box_arrays(&x, &x, &x, Order::Linear);
    let mut state = 1u64;
    for p in &mut nodes {
        if p.iter().all(|&c| c > 1e-9 && c < 1.0 - 1e-9) {
            for c in p {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                *c += 0.15 / n as f64 * ((state >> 33) as f64 / f64::from(1u32 << 31) - 0.5);
            }
        }
    }
    if order == Order::Linear {
        return TetraMesh::new(nodes, cells, order).unwrap();
    }
    let (mut all, quadratic) = box_arrays(&x, &x, &x, order);
    all[..nodes.len()].copy_from_slice(&nodes);
    for (corners, cell) in cells.chunks_exact(4).zip(quadratic.chunks_exact(10)) {
        for (k, [i, j]) in [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]]
            .into_iter()
            .enumerate()
        {
            let (p, q) = (nodes[corners[i]], nodes[corners[j]]);
            all[cell[4 + k]] = [0, 1, 2].map(|c| 0.5 * (p[c] + q[c]));
        }
    }
    TetraMesh::new(all, quadratic, order).unwrap()
}

#[test]
fn linear_fields_are_reproduced_exactly() {
    for order in ORDERS {
        let mesh = distorted(order, 3);
        let field = |x: [f64; 3]| {
            [
                1e-3 * x[0] + 2e-3 * x[1] - 1e-3 * x[2] + 4e-3,
                -2e-3 * x[0] + 1e-3 * x[2],
                3e-3 * x[0] - 1e-3 * x[1] + 2e-3 * x[2],
            ]
        };
        let inner = |x: [f64; 3]| x.iter().all(|&c| c > 1e-9 && c < 1.0 - 1e-9);
        let (supports, nodes) = held_surface(&mesh, inner);
        let values: Vec<f64> = nodes.iter().flat_map(|&a| field(mesh.nodes()[a])).collect();
        let places = mesh.nodes().to_vec();
        let body = TetraBody::new(mesh, steel(), supports).unwrap();
        let n = places.len();
        let u = body
            .solve(
                &vec![0.0; 3 * n],
                &values,
                &[],
                Limits::default(),
                &unmonitored,
            )
            .unwrap();
        for (a, &x) in places.iter().enumerate() {
            for c in 0..3 {
                assert!((u[c * n + a] - field(x)[c]).abs() < 1e-15, "{order:?}");
            }
        }
        // constant stress: sxx = lambda tr + 2 mu exx, sxy = 2 mu exy (= 0 here)
        let (stress, _) = body.stress(&u).unwrap();
        let lambda = 2.0 * 80e9 * 0.3 / 0.4;
        for a in 0..n {
            assert!((stress[a] - (lambda * 3e-3 + 160e9 * 1e-3)).abs() < 1.0);
            assert!(stress[5 * n + a].abs() < 1.0);
        }
    }
}

#[test]
fn rigid_motions_need_no_force() {
    for order in ORDERS {
        let mesh = distorted(order, 2);
        let n = mesh.nodes().len();
        let body = TetraBody::new(mesh, steel(), vec![]).unwrap();
        let modes = body.modes([0.2, 0.3, 0.4]);
        assert_eq!(modes.len(), 6);
        let names: Vec<String> = modes.iter().map(RigidMode::name).collect();
        assert_eq!(
            names,
            [
                "translation along z",
                "rotation about x",
                "rotation about y",
                "translation along x",
                "translation along y",
                "rotation about z"
            ]
        );
        for mode in &modes {
            let u = body.mode_displacement(mode);
            let (_, left_over) = body.reactions(&u, &vec![0.0; 3 * n], [0.0; 3]).unwrap();
            assert!(left_over < 1e-4, "{left_over} N of stiffness 1e11 N/m");
        }
    }
}

/// u = a sin(pi x) sin(pi y) sin(pi z) in each component, on the unit cube held all around; returns
/// the L2 error of the displacement at the nodes, with the consistent body force.
fn manufactured_error(order: Order, n: usize) -> f64 {
    let x = even(0.0, 1.0, n);
    let mesh = box_mesh(&x, &x, &x, order);
    let n_nodes = mesh.nodes().len();
    let material = steel();
    let (mu, lambda) = (80e9, 2.0 * 80e9 * 0.3 / 0.4);
    let pi = std::f64::consts::PI;
    let exact = |x: [f64; 3]| 1e-3 * x.iter().map(|c| (pi * c).sin()).product::<f64>();
    // f = -(lambda + mu) grad div u - mu laplace u
    let load = |x: [f64; 3]| {
        let (s, c) = (x.map(|v| (pi * v).sin()), x.map(|v| (pi * v).cos()));
        let s3 = s[0] * s[1] * s[2];
        let mixed = [
            c[0] * c[1] * s[2] + c[0] * s[1] * c[2] - s3,
            c[0] * c[1] * s[2] + s[0] * c[1] * c[2] - s3,
            c[0] * s[1] * c[2] + s[0] * c[1] * c[2] - s3,
        ];
        mixed.map(|m| 1e-3 * pi * pi * (3.0 * mu * s3 - (lambda + mu) * m))
    };
    let mut force = vec![0.0; 3 * n_nodes];
    let places = mesh.nodes().to_vec();
    let cells: Vec<Vec<usize>> = (0..mesh.n_tets()).map(|t| mesh.cell(t).to_vec()).collect();
    for cell in &cells {
        each_point(cell, &places, |x, shape, weight| {
            let f = load(x);
            for (&a, s) in cell.iter().zip(shape) {
                (0..3).for_each(|c| force[c * n_nodes + a] += weight * s * f[c]);
            }
        });
    }
    let all_around = nodes_where(&mesh, |x| {
        x.iter().any(|&c| !(1e-9..=1.0 - 1e-9).contains(&c))
    });
    let held = support("surface", all_around, [Hold::Prescribed; 3]);
    let body = TetraBody::new(mesh, material, vec![held]).unwrap();
    let u = body
        .solve(&force, &[0.0; 3], &[], Limits::default(), &unmonitored)
        .unwrap();
    let (mut error, mut norm) = (0.0, 0.0);
    for cell in &cells {
        each_point(cell, &places, |x, shape, weight| {
            for c in 0..3 {
                let value: f64 = cell
                    .iter()
                    .zip(shape)
                    .map(|(&a, s)| u[c * n_nodes + a] * s)
                    .sum();
                error += weight * (value - exact(x)).powi(2);
                norm += weight * exact(x).powi(2);
            }
        });
    }
    (error / norm).sqrt()
}

/// Quadrature of degree 3 or more over a straight cell: Gauss-Jacobi by collapsed coordinates.
fn each_point(cell: &[usize], nodes: &[[f64; 3]], mut visit: impl FnMut([f64; 3], &[f64], f64)) {
    let gauss = [
        (0.5 - (3.0_f64 / 20.0).sqrt(), 5.0 / 18.0),
        (0.5, 4.0 / 9.0),
        (0.5 + (3.0_f64 / 20.0).sqrt(), 5.0 / 18.0),
    ];
    let p = [0, 1, 2, 3].map(|i| nodes[cell[i]]);
    let d = [1, 2, 3].map(|i| [0, 1, 2].map(|c| p[i][c] - p[0][c]));
    let volume6 = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1])
        - d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0])
        + d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
    for (r, wr) in gauss {
        for (s, ws) in gauss {
            for (t, wt) in gauss {
                let l1 = r;
                let l2 = s * (1.0 - r);
                let l3 = t * (1.0 - r) * (1.0 - s);
                let l = [1.0 - l1 - l2 - l3, l1, l2, l3];
                let weight = wr * ws * wt * (1.0 - r).powi(2) * (1.0 - s) * volume6;
                let x = [0, 1, 2].map(|c| (0..4).map(|i| l[i] * p[i][c]).sum());
                let mut shape = l.to_vec();
                if cell.len() == 10 {
                    shape = l.iter().map(|l| l * (2.0 * l - 1.0)).collect();
                    shape.extend(
                        [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]]
                            .map(|[i, j]| 4.0 * l[i] * l[j]),
                    );
                }
                visit(x, &shape, weight);
            }
        }
    }
}

#[test]
fn displacements_converge_with_order_two_and_three() {
    for (order, grids, rate) in [
        (Order::Linear, [8, 16], 2.0),
        (Order::Quadratic, [4, 8], 3.0),
    ] {
        let errors = grids.map(|n| manufactured_error(order, n));
        let observed = (errors[0] / errors[1]).log2();
        assert!(
            (observed - rate).abs() < 0.25,
            "{order:?}: errors {errors:?}, rate {observed}"
        );
    }
}

/// A cantilever 10 long and 1 x 1 thick under a parabolic end shear: tip deflection over that of
/// Timoshenko's beam.
fn cantilever(order: Order, n: usize) -> f64 {
    let (long, force) = (10.0, 1e6);
    let mesh = box_mesh(
        &even(0.0, long, 5 * n),
        &even(-0.5, 0.5, n),
        &even(-0.5, 0.5, n),
        order,
    );
    let wall = nodes_where(&mesh, |x| x[0] < 1e-9);
    let tip = nodes_where(&mesh, |x| x[0] > long - 1e-9);
    let n_nodes = mesh.nodes().len();
    let points: Vec<SurfacePoint> = faces_where(&mesh, |x| x[0] > long - 1e-9)
        .into_iter()
        .map(|face| SurfacePoint {
            face,
            barycentric: [1.0 / 3.0; 3],
            weight: 0.5 / (n * n) as f64,
            frame: [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]],
        })
        .collect();
    let body = TetraBody::new(
        mesh,
        Material::new(80e9, 0.0).unwrap(),
        vec![support("wall", wall, [Hold::Prescribed; 3])],
    )
    .unwrap();
    let load = body
        .surface_force(&points, &vec![[0.0, 0.0, force]; points.len()])
        .unwrap();
    let u = body
        .solve(&load, &[0.0; 3], &[], Limits::default(), &unmonitored)
        .unwrap();
    let (reactions, left_over) = body.reactions(&u, &load, [0.0; 3]).unwrap();
    assert!((reactions[0].force[2] + force).abs() < 1e-8 * force);
    // force z at x = long turns about y: moment of the load -long * force, of the wall its opposite
    assert!((reactions[0].moment[1] - long * force).abs() < 1e-8 * long * force);
    assert!(left_over < 1e-8 * force);
    let mean: f64 = tip.iter().map(|&a| u[2 * n_nodes + a]).sum::<f64>() / tip.len() as f64;
    let (e, g, inertia) = (160e9, 80e9, 1.0 / 12.0);
    mean / (force * long.powi(3) / (3.0 * e * inertia) + force * long / (5.0 / 6.0 * g))
}

#[test]
fn a_cantilever_bends_as_a_beam() {
    assert!((cantilever(Order::Quadratic, 2) - 1.0).abs() < 0.01);
    // too stiff by an excess that falls with the square of the size
    let excess = [2, 4].map(|n| 1.0 / cantilever(Order::Linear, n) - 1.0);
    let rate = (excess[0] / excess[1]).log2();
    assert!((rate - 2.0).abs() < 0.2, "excesses {excess:?}");
}

#[test]
fn averages_over_a_plane_face_are_those_of_hats() {
    let mesh = box_mesh(
        &even(0.0, 0.1, 5),
        &even(0.0, 0.06, 3),
        &even(0.0, 0.05, 3),
        Order::Linear,
    );
    let (x, y) = (even(0.0, 0.1, 7), even(0.0, 0.06, 4));
    let sampling = grid_on_bottom(&mesh, &x, &y);
    let means = sampling.averages(&mesh).unwrap();
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} is not {b}");
    for (i, shares) in means.shares.iter().enumerate() {
        close(shares.values().sum(), 1.0);
        // a hat presses at its node but at the edge, where half of it does a third of a cell inside
        let (column, row) = (i % x.len(), i / x.len());
        let inside = |k: usize, line: &[f64]| match k {
            0 => line[0] + (line[1] - line[0]) / 3.0,
            k if k + 1 == line.len() => line[k] - (line[k] - line[k - 1]) / 3.0,
            k => line[k],
        };
        close(means.places[i][0], inside(column, &x));
        close(means.places[i][1], inside(row, &y));
        close(means.frames[i][2][2], 1.0);
    }
    // of a hat in the middle of the grid: 2/3 its own along each axis, 1/6 of each neighbour
    let middle = &means.shares[2 * x.len() + 3];
    close(middle[&(2 * x.len() + 3)], 4.0 / 9.0);
    close(middle[&(2 * x.len() + 4)], 1.0 / 9.0);
    close(middle[&(x.len() + 2)], 1.0 / 36.0);
}

#[test]
fn condensing_agrees_with_solving() {
    for order in ORDERS {
        // the contact grid does not match the mesh
        let mesh = box_mesh(
            &even(0.0, 0.1, 5),
            &even(0.0, 0.06, 3),
            &even(0.0, 0.05, 3),
            order,
        );
        let sampling = grid_on_bottom(&mesh, &even(0.0, 0.1, 7), &even(0.0, 0.06, 4));
        assert!((sampling.weights().iter().sum::<f64>() - 0.006).abs() < 1e-15);
        let top = nodes_where(&mesh, |x| x[2] > 0.05 - 1e-9);
        let side = nodes_where(&mesh, |x| x[0] < 1e-9 && x[2] < 0.04);
        let n_nodes = mesh.nodes().len();
        let supports = vec![
            support("top", top, [Hold::Prescribed, Hold::Free, Hold::Guided]),
            support("side", side, [Hold::Free, Hold::Prescribed, Hold::Free]),
        ];
        let body = TetraBody::new(mesh, steel(), supports).unwrap();
        let condensed = body
            .condense(&sampling, Limits::default(), &unmonitored)
            .unwrap();
        let n = condensed.flexibility.points();
        // left free: the guide along z; the rest is held by the two faces
        assert_eq!(condensed.modes.len(), 1);
        assert_eq!(condensed.modes[0].name(), "translation along z");
        assert!((condensed.case_work[1] - 1.0).abs() < 1e-12);

        // a load in equilibrium: traction, balanced by the force on the guide
        let traction: Vec<f64> = (0..3 * n).map(|k| 1e6 * (1.0 + (k as f64).sin())).collect();
        let work: f64 = (0..n)
            .map(|i| {
                (0..3)
                    .map(|c| {
                        condensed.flexibility.weights()[i]
                            * condensed.mode_displacement[0][c * n + i]
                            * traction[c * n + i]
                    })
                    .sum::<f64>()
            })
            .sum();
        let cases = [3e-6, -work, 5e-6];
        let amplitude = 7e-6;
        let mut expected = vec![0.0; 3 * n];
        let components = [Component::X, Component::Y, Component::Normal];
        for (o, &observed) in components.iter().enumerate() {
            for (l, &loaded) in components.iter().enumerate() {
                condensed.flexibility.add_displacement(
                    observed,
                    loaded,
                    1.0,
                    &traction[l * n..(l + 1) * n],
                    &mut expected[o * n..(o + 1) * n],
                );
            }
        }
        for k in 0..3 * n {
            expected[k] += amplitude * condensed.mode_displacement[0][k];
            for (case, value) in cases.iter().enumerate() {
                expected[k] += value * condensed.case_displacement[case][k];
            }
        }
        let force = body.contact_force(&sampling, &traction).unwrap();
        let u = body
            .solve(
                &force,
                &cases,
                &[(condensed.modes[0], amplitude)],
                Limits::default(),
                &unmonitored,
            )
            .unwrap();
        let observed = body.observe(&sampling, &u).unwrap();
        let scale = observed.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        for (a, b) in observed.iter().zip(&expected) {
            assert!((a - b).abs() < 1e-10 * scale, "{a} {b}");
        }
        let (reactions, left_over) = body.reactions(&u, &force, [0.0; 3]).unwrap();
        let total: f64 = (0..n_nodes).map(|a| force[a]).sum::<f64>() + reactions[0].force[0];
        assert!(total.abs() < 1e-8 * 6e3 && left_over < 1e-8 * 6e3);
        // the guide carries what was put on it
        assert!((reactions[0].force[2] + work).abs() < 1e-8 * work.abs());
    }
}

#[test]
fn a_condensation_that_was_stopped_anywhere_can_be_made_again() {
    let mesh = || {
        box_mesh(
            &even(0.0, 0.1, 14),
            &even(0.0, 0.06, 9),
            &even(0.0, 0.05, 5),
            Order::Quadratic,
        )
    };
    let top = nodes_where(&mesh(), |x| x[2] > 0.05 - 1e-9);
    let body = || {
        let held = support("top", top.clone(), [Hold::Prescribed; 3]);
        TetraBody::new(mesh(), steel(), vec![held]).unwrap()
    };
    let sampling = grid_on_bottom(&mesh(), &even(0.0, 0.1, 7), &even(0.0, 0.06, 4));
    let expected = body()
        .condense(&sampling, Limits::default(), &unmonitored)
        .unwrap();
    let cost = expected.cost;
    let factorisation = (cost.factor_flops / (2.0 * WORK_UNWATCHED)) as u32;
    assert!(factorisation > 0, "{:e} operations", cost.factor_flops);
    let stopped = body();
    let mut last = 0;
    let condensed = loop {
        let asked = Cell::new(0);
        let monitor = |_: Progress| {
            asked.set(asked.get() + 1);
            if asked.get() > last {
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        };
        match stopped.condense(&sampling, Limits::default(), &monitor) {
            Ok(condensed) => break condensed,
            Err(error) => assert_eq!(error, Error::Interrupted),
        }
        last += 1;
    };
    // four stages before the columns, and the looks inside the factorisation
    assert!(last > 4 + factorisation, "{last} stops");
    assert_eq!(condensed.flexibility, expected.flexibility);
}

#[test]
fn compliances_are_symmetric_in_the_weights() {
    let x = even(0.0, 0.1, 6);
    let y = even(0.0, 0.06, 4);
    let mesh = box_mesh(&x, &y, &even(0.0, 0.05, 3), Order::Quadratic);
    let sampling = grid_on_bottom(&mesh, &x, &y);
    let top = nodes_where(&mesh, |x| x[2] > 0.05 - 1e-9);
    let body = TetraBody::new(
        mesh,
        steel(),
        vec![support("top", top, [Hold::Prescribed; 3])],
    )
    .unwrap();
    let condensed = body
        .condense(&sampling, Limits::default(), &unmonitored)
        .unwrap();
    assert!(condensed.modes.is_empty());
    let n = condensed.flexibility.points();
    let influence = |o, l| {
        let mut m = vec![0.0; n * n];
        condensed.flexibility.add_influence(o, l, 1.0, &mut m);
        m
    };
    let (xn, nx) = (
        influence(Component::X, Component::Normal),
        influence(Component::Normal, Component::X),
    );
    let w = condensed.flexibility.weights();
    let most = influence(Component::Normal, Component::Normal)[0] * w[0];
    for i in 0..n {
        for j in 0..n {
            let (a, b) = (w[i] * xn[i * n + j], w[j] * nx[j * n + i]);
            assert!((a - b).abs() < 1e-14 * most);
        }
    }
    // uniform pressure on a matching grid: total indentation work equals that of the nodes
    let mut u = vec![0.0; n];
    condensed.flexibility.add_displacement(
        Component::Normal,
        Component::Normal,
        1.0,
        &vec![1e6; n],
        &mut u,
    );
    let mut all = vec![0.0; 3 * n];
    all[2 * n..].fill(1e6);
    let force = body.contact_force(&sampling, &all).unwrap();
    let field = body
        .solve(&force, &[0.0; 3], &[], Limits::default(), &unmonitored)
        .unwrap();
    let nodes: f64 = force.iter().zip(&field).map(|(f, u)| f * u).sum();
    let points: f64 = (0..n).map(|i| 1e6 * w[i] * u[i]).sum();
    assert!((nodes / points - 1.0).abs() < 1e-12);
}

#[test]
fn bad_bodies_are_named() {
    let x = even(0.0, 1.0, 1);
    let (nodes, mut cells) = box_arrays(&x, &x, &x, Order::Linear);
    cells.swap(8, 9);
    let inverted = TetraMesh::new(nodes.clone(), cells, Order::Linear).unwrap_err();
    assert!(matches!(inverted, Error::Inverted { tet: 2, volume } if volume < 0.0));
    let (mut flat, cells) = box_arrays(&x, &x, &[0.0, 1e-6], Order::Linear);
    let sliver = TetraMesh::new(flat.clone(), cells.clone(), Order::Linear).unwrap_err();
    assert!(matches!(sliver, Error::Sliver { tet: 0, .. }), "{sliver}");
    flat.push([2.0, 2.0, 2.0]);
    for p in &mut flat {
        p[2] *= 1e6;
    }
    let loose = TetraMesh::new(flat, cells, Order::Linear).unwrap_err();
    assert_eq!(loose, Error::LooseNode(8));

    let y = even(0.0, 1.0, 2);
    let mesh = box_mesh(&y, &y, &y, Order::Linear);
    let sampling = grid_on_bottom(&mesh, &y, &y);
    let body = TetraBody::new(mesh.clone(), steel(), vec![]).unwrap();
    let error = body
        .condense(&sampling, Limits::default(), &unmonitored)
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "the supports leave the body free to move, and the contact cannot hold it: translation along x, \
         translation along y, rotation about z"
    );
    let limits = Limits {
        bytes: 1e4,
        ..Limits::default()
    };
    let top = nodes_where(&mesh, |x| x[2] > 1.0 - 1e-9);
    let held = support("top", top.clone(), [Hold::Prescribed; 3]);
    let guided = support("guide", top, [Hold::Guided, Hold::Free, Hold::Free]);
    let body = TetraBody::new(mesh.clone(), steel(), vec![held.clone()]).unwrap();
    let error = body.condense(&sampling, limits, &unmonitored).unwrap_err();
    assert!(
        matches!(error, Error::TooLarge { unknowns: 54, .. }),
        "{error}"
    );
    let error = TetraBody::new(mesh, steel(), vec![held, guided])
        .err()
        .unwrap();
    assert!(matches!(error, Error::Contradiction { component: 'x', .. }));
}

#[test]
fn what_a_condensation_takes_beside_its_factor_is_refused_before_the_factor_is_made() {
    let (x, z) = (even(0.0, 1.0, 12), even(0.0, 1.0, 3));
    let mesh = box_mesh(&x, &x, &z, Order::Linear);
    let sampling = grid_on_bottom(&mesh, &x, &x);
    let top = nodes_where(&mesh, |x| x[2] > 1.0 - 1e-9);
    let supports = vec![support("top", top, [Hold::Prescribed; 3])];
    let body = || TetraBody::new(mesh.clone(), steel(), supports.clone()).unwrap();
    let stage = Cell::new(0);
    let monitor = |progress: Progress| {
        stage.set(stage.get().max(progress.iteration));
        ControlFlow::Continue(())
    };
    let under = |bytes: f64, body: &TetraBody| {
        stage.set(0);
        let limits = Limits {
            bytes,
            ..Limits::default()
        };
        body.condense(&sampling, limits, &monitor)
    };
    let whole = body();
    let held = under(8e9, &whole).unwrap().cost;
    let factor = 8.0 * held.factor_entries as f64;
    let peak = held.peak_bytes as f64;
    assert!(peak > 2.0 * factor, "the factor alone tells little here");
    // what is counted before is what is held, but for products and the sides that are not contact
    assert!(under(1.3 * peak, &body()).is_ok());
    for bytes in [1.5 * factor, 0.999 * peak] {
        let refused = under(bytes, &body()).unwrap_err();
        assert!(
            matches!(
                &refused,
                Error::Operator(mtb_operator::Error::Memory { points: 169, .. })
            ),
            "{refused}"
        );
        assert!(stage.get() < 3, "numbers of the factor were made");
        // the same where the factor is there already
        assert!(under(bytes, &whole).is_err());
    }
}

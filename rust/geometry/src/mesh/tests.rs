// SPDX-License-Identifier: MIT OR Apache-2.0
use super::*;
use crate::{Found, Profile, Surface};
use proptest::prelude::*;

/// Octahedron refined `level` times and blown up to a sphere, vertices moved along it irregularly.
fn sphere(radius: f64, level: usize) -> SurfaceMesh {
    let mut points = vec![
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
    ]
    .into_iter()
    .map(Vector3::from)
    .collect::<Vec<_>>();
    let mut faces: Vec<[usize; 3]> = Vec::new();
    for x in [0, 1] {
        for y in [2, 3] {
            for z in [4, 5] {
                let odd = (x + y + z) % 2 == 1;
                faces.push(if odd { [x, z, y] } else { [x, y, z] });
            }
        }
    }
    for _ in 0..level {
        let mut middles = std::collections::HashMap::new();
        let mut middle = |a: usize, b: usize, points: &mut Vec<Vector3<f64>>| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a] + points[b]).normalize());
                points.len() - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let ab = middle(a, b, &mut points);
                let bc = middle(b, c, &mut points);
                let ca = middle(c, a, &mut points);
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let h = 0.15 / f64::from(1 << level);
    let vertices = points
        .iter()
        .map(|p| {
            let wiggle = Vector3::new((37.0 * p.y).sin(), (29.0 * p.z).sin(), (41.0 * p.x).sin());
            ((p + wiggle * h).normalize() * radius).into()
        })
        .collect();
    SurfaceMesh::new(vertices, faces, Closure::Closed).unwrap()
}

/// Points below a sphere and the exact distance to it along a tilted line.
fn lines(radius: f64, count: u32) -> Vec<([f64; 3], [f64; 3], f64)> {
    (0..count)
        .map(|i| {
            let (a, b) = (
                f64::from(i) * 0.618 % 1.0 - 0.5,
                f64::from(i) * 0.414 % 1.0 - 0.5,
            );
            let p = [radius * a * 0.6, radius * b * 0.6, -1.02 * radius];
            let n = Vector3::new(0.1 * b, -0.1 * a, 1.0).normalize();
            let (q, d) = (Vector3::from(p), n);
            let along = -q.dot(&d);
            let exact = along - (along * along - q.norm_squared() + radius * radius).sqrt();
            (p, n.into(), exact)
        })
        .collect()
}

#[test]
fn curved_facets_converge_faster_than_flat_ones() {
    let radius = 0.08;
    let errors = |level: usize| {
        let mesh = sphere(radius, level);
        let mut largest = [0.0_f64; 3];
        for (p, d, exact) in lines(radius, 300) {
            let hit = mesh.cast(p, d, 0.1).unwrap();
            assert_eq!(hit.found, Found::OnLine);
            let flat = mesh.facets(&p.into(), &d.into(), [-0.1, 0.1]);
            let flat = flat
                .iter()
                .map(|f| f.distance)
                .fold(f64::INFINITY, f64::min);
            largest[0] = largest[0].max((flat - exact).abs());
            largest[1] = largest[1].max((hit.distance - exact).abs());
            largest[2] = largest[2].max(hit.facet_error);
        }
        largest
    };
    let [coarse, fine] = [4, 5].map(errors);
    let rate = |i: usize| (coarse[i] / fine[i]).log2();
    println!("{coarse:?} {fine:?}");
    assert!((rate(0) - 2.0).abs() < 0.3, "flat: rate {}", rate(0));
    assert!(
        rate(1) > 3.6,
        "curved: rate {}, {coarse:?} {fine:?}",
        rate(1)
    );
    // the estimate is an upper bound, and not a wild one
    for level in [coarse, fine] {
        assert!(
            level[2] > level[1] && level[2] < 15.0 * level[1],
            "{level:?}"
        );
    }
    // 4 mm facets on an 80 mm sphere: 50 um off when flat, 0.15 um when curved
    assert!(fine[0] > 4e-5 && fine[1] < 2e-7, "{fine:?}");
}

#[test]
fn nearest_point_where_the_line_misses() {
    let mesh = sphere(0.08, 4);
    // past the equator: no facet faces the line, the sphere is nearer sideways
    let hit = mesh
        .cast([0.0801, 0.0, -0.002], [0.0, 0.0, 1.0], 0.01)
        .unwrap();
    assert_eq!(hit.found, Found::Nearest);
    let exact = 0.0801_f64.hypot(0.002) - 0.08;
    assert!(
        (hit.distance - exact).abs() < 1e-6,
        "{} {exact}",
        hit.distance
    );
    assert!(mesh.cast([0.2, 0.0, 0.0], [0.0, 0.0, 1.0], 0.01).is_none());
}

/// Surface of the upper half of a rail, extruded along x.
fn rail(step: f64) -> SurfaceMesh {
    let profile = Profile::rail_60e1();
    let n = (0.06 / step).round() as usize;
    let nx = (0.03 / step).round() as usize + 1;
    let y: Vec<f64> = (0..=n)
        .map(|i| -0.03 + 0.06 * i as f64 / n as f64)
        .collect();
    let vertices = (0..nx)
        .flat_map(|i| {
            let profile = &profile;
            y.iter().map(move |&y| {
                [
                    0.03 * i as f64 / (nx - 1) as f64,
                    y,
                    profile.at(y).unwrap().height,
                ]
            })
        })
        .collect();
    let mut faces = Vec::new();
    for i in 0..nx - 1 {
        for j in 0..n {
            let a = i * (n + 1) + j;
            faces.extend([[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]]);
        }
    }
    SurfaceMesh::new(vertices, faces, Closure::Open).unwrap()
}

#[test]
fn arcs_of_a_facetted_rail_are_recovered() {
    let profile = Profile::rail_60e1();
    let mesh = rail(2e-3);
    let (mut worst, mut tilted) = (0.0_f64, 0.0_f64);
    for i in 0..200 {
        // inside the 300 and the 80 mm arcs, away from their joints
        let y = f64::from(i) * 0.618 % 1.0;
        let y = if i % 2 == 0 {
            -2e-3 + 4e-3 * y
        } else {
            17e-3 + 2e-3 * y
        };
        let top = mesh.top(0.0123, y).unwrap();
        let exact = profile.at(y).unwrap();
        worst = worst.max((top.distance - exact.height).abs());
        tilted = tilted.max((top.normal[1] - exact.normal()[0]).abs());
    }
    assert!(worst < 5e-9 && tilted < 2e-5, "{worst} {tilted}");
}

#[test]
fn joints_of_a_facetted_rail_show_in_the_estimate() {
    let profile = Profile::rail_60e1();
    for step in [3e-3, 1e-3] {
        let mesh = rail(step);
        for i in 0..400 {
            let y = -28e-3 + 56e-3 * f64::from(i) / 400.0;
            let top = mesh.top(0.0123, y).unwrap();
            let error = (top.distance - profile.at(y).unwrap().height).abs();
            // within a small factor where the curvature jumps, since both polynomials miss the joint
            assert!(
                error < 2.0 * top.facet_error + 1e-9,
                "{step} {y}: {error} {}",
                top.facet_error
            );
        }
    }
}

/// A block of two triangles a face, corners and edges sharp.
fn block() -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let vertices = (0..8)
        .map(|i| [f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)].map(|v| 0.1 * v))
        .collect();
    let faces = vec![
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    (vertices, faces)
}

#[test]
fn flat_faces_stay_flat_up_to_their_edges() {
    let (vertices, faces) = block();
    let mesh = SurfaceMesh::new(vertices, faces, Closure::Closed).unwrap();
    for (x, y) in [
        (0.05, 0.05),
        (1e-6, 0.03),
        (0.0999, 0.0999),
        (0.0, 0.0),
        (0.1, 0.1),
    ] {
        let hit = mesh.cast([x, y, -0.003], [0.0, 0.0, 1.0], 0.01).unwrap();
        assert!((hit.distance - 0.003).abs() < 1e-15, "{hit:?}");
        assert!(hit.facet_error < 1e-15 && hit.normal[2] < -0.999_999);
        // from inside the body the distance is negative
        let hit = mesh.cast([x, y, 0.001], [0.0, 0.0, 1.0], 0.01).unwrap();
        assert!((hit.distance + 0.001).abs() < 1e-15);
        assert!((mesh.top(x, y).unwrap().distance - 0.1).abs() < 1e-15);
    }
}

#[test]
fn bad_meshes_are_named() {
    let (vertices, faces) = block();
    let message = |vertices: Vec<[f64; 3]>, faces: Vec<[usize; 3]>, closure| match SurfaceMesh::new(
        vertices, faces, closure,
    ) {
        Ok(_) => String::from("accepted"),
        Err(error) => error.to_string(),
    };
    let closed = Closure::Closed;
    assert_eq!(message(vertices.clone(), faces.clone(), closed), "accepted");
    let open = message(vertices.clone(), faces[1..].to_vec(), closed);
    assert!(open.contains("not watertight: 3 edges"), "{open}");
    assert_eq!(
        message(vertices.clone(), faces[1..].to_vec(), Closure::Open),
        "accepted"
    );
    let mut turned = faces.clone();
    turned[3].swap(0, 1);
    assert!(message(vertices.clone(), turned, closed).contains("contradict"));
    let inward = faces.iter().map(|&[a, b, c]| [a, c, b]).collect();
    assert!(message(vertices.clone(), inward, closed).contains("inwards"));
    let mut thin = faces.clone();
    thin[5] = [1, 5, 5];
    assert!(message(vertices.clone(), thin, closed).contains("triangle 5 is degenerate"));
    let mut missing = faces.clone();
    missing[2][1] = 8;
    assert!(message(vertices.clone(), missing, closed).contains("vertex 8"));
    let millimetres = vertices.iter().map(|v| v.map(|x| 1e3 * x)).collect();
    assert!(message(millimetres, faces.clone(), closed).contains("unit"));
    let mut infinite = vertices.clone();
    infinite[1][2] = f64::INFINITY;
    assert!(message(infinite, faces, closed).contains("vertices[5] is inf"));
    assert!(message(vertices, Vec::new(), closed).contains("triangles has 0"));
}

proptest! {
    #[test]
    fn tree_finds_what_brute_force_finds(x in -0.09..0.09_f64, y in -0.09..0.09_f64,
                                         z in -0.12..0.12_f64, a in -1.0..1.0_f64, b in -1.0..1.0_f64) {
        let mesh = sphere(0.08, 2);
        let point = Vector3::new(x, y, z);
        let direction = Vector3::new(a, b, 1.0).normalize();
        let mut found: Vec<usize> = mesh
            .facets(&point, &direction, [-0.2, 0.2])
            .iter()
            .map(|f| f.triangle)
            .collect();
        found.sort_unstable();
        let brute: Vec<usize> = (0..mesh.len())
            .filter(|&t| {
                mesh.crossing(t, &point, &direction)
                    .is_some_and(|f| f.distance.abs() <= 0.2)
            })
            .collect();
        prop_assert_eq!(found, brute);
    }

    #[test]
    fn nearest_is_the_brute_force_nearest(x in 0.081..0.12_f64, y in -0.05..0.05_f64, z in -0.05..-0.01_f64) {
        let mesh = sphere(0.08, 3);
        let point = Vector3::new(x, y, z);
        if let Some(hit) = mesh.nearest(&point, 0.2) {
            let exact = point.norm() - 0.08;
            prop_assert!((hit.distance - exact).abs() < 1e-4, "{} {}", hit.distance, exact);
        }
    }
}

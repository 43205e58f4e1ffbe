// SPDX-License-Identifier: MIT OR Apache-2.0
//! Points, normals and tangents of a surface given on a regular grid.

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a + factor * b`
pub(super) fn add(a: [f64; 3], factor: f64, b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|c| a[c] + factor * b[c])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// `v` over its length; zero stays zero.
pub(super) fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = dot(v, v).sqrt();
    if length > 0.0 {
        v.map(|c| c / length)
    } else {
        v
    }
}

/// Part of `v` in the plane across the unit vector `normal`, as a unit vector.
pub(super) fn along(v: [f64; 3], normal: [f64; 3]) -> [f64; 3] {
    unit(add(v, -dot(v, normal), normal))
}

/// Tangents next to x and to y.
pub(super) fn tangents(normal: [f64; 3]) -> [[f64; 3]; 2] {
    let first = along([1.0, 0.0, 0.0], normal);
    let second = add([0.0, 1.0, 0.0], -first[1], first);
    [first, along(second, normal)]
}

/// Neighbours along x and along y on the grids: for each point `[[before, after]; 2]`, itself at an edge.
pub(super) fn neighbours(grids: &[(usize, usize)]) -> Vec<[[usize; 2]; 2]> {
    let mut all = Vec::new();
    for &(nx, ny) in grids {
        let start = all.len();
        for j in 0..ny {
            for i in 0..nx {
                let at = |i: usize, j: usize| start + j * nx + i;
                all.push([
                    [at(i.saturating_sub(1), j), at((i + 1).min(nx - 1), j)],
                    [at(i, j.saturating_sub(1)), at(i, (j + 1).min(ny - 1))],
                ]);
            }
        }
    }
    all
}

/// Unit normals of the surface through the points, up (`sign` 1) or down (-1).
///
/// Tangents are those of the parabola through three neighbouring points, at edges through the three
/// next ones.
pub(super) fn normals(points: &[[f64; 3]], grids: &[(usize, usize)], sign: f64) -> Vec<[f64; 3]> {
    let around = neighbours(grids);
    (0..points.len())
        .map(|i| {
            let [x, y] = [0, 1].map(|axis| {
                let [before, after] = around[i][axis];
                let (ahead, behind) = (around[after][axis][1], around[before][axis][0]);
                if before == i && ahead != after {
                    // -3 a + 4 b - c
                    let slope = add([0.0; 3], 4.0, points[after]);
                    add(add(slope, -3.0, points[i]), -1.0, points[ahead])
                } else if after == i && behind != before {
                    let slope = add([0.0; 3], -4.0, points[before]);
                    add(add(slope, 3.0, points[i]), 1.0, points[behind])
                } else {
                    add(points[after], -1.0, points[before])
                }
            });
            // one row of points has no direction of its own across
            let x = if dot(x, x) > 0.0 { x } else { [1.0, 0.0, 0.0] };
            let y = if dot(y, y) > 0.0 { y } else { [0.0, 1.0, 0.0] };
            unit(cross(x, y).map(|c| sign * c))
        })
        .collect()
}

/// Turns each normal by the mean angle by which the lines to its neighbours turned, along x and along y.
pub(super) fn turn(
    normals: &mut [[f64; 3]],
    old: &[[f64; 3]],
    new: &[[f64; 3]],
    grids: &[(usize, usize)],
) {
    for (i, around) in neighbours(grids).into_iter().enumerate() {
        let normal = normals[i];
        let axes = tangents(normal);
        let mut turned = normal;
        for (tangent, pair) in axes.into_iter().zip(around) {
            let (mut sum, mut count) = (0.0, 0.0);
            for neighbour in pair {
                if neighbour == i {
                    continue;
                }
                let angle = |points: &[[f64; 3]]| {
                    let line = add(points[neighbour], -1.0, points[i]);
                    let forward = dot(line, tangent);
                    (dot(line, normal) * forward.signum()).atan2(forward.abs())
                };
                sum += angle(new) - angle(old);
                count += 1.0;
            }
            if count > 0.0 {
                turned = add(turned, -f64::tan(sum / count), tangent);
            }
        }
        normals[i] = unit(turned);
    }
}

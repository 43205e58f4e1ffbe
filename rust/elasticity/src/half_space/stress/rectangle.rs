// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stress by a uniformly loaded rectangle.

use std::f64::consts::PI;

/// Components of a stress: xx, yy, zz, yz, xz, xy.
pub type Stress = [f64; 6];

/// Stress by unit tractions along x, along y, and by a unit pressure.
pub(super) type Responses = [Stress; 3];

/// Distance, in larger sides of the rectangle, up to which the closed form is taken. Beyond it loses more digits to
/// cancellation (about `r^2` epsilons) than three Gauss points per direction leave (about `0.1 / r^6`).
pub(super) const CLOSED_TO: f64 = 40.0;

/// The same for two Gauss points per direction (about `1 / r^4`).
const TWO_POINTS_FROM: f64 = 600.0;

/// Square of a distance, in larger sides, that counts as none: it keeps logarithms finite where they cancel.
const NONE: f64 = 1e-200;

/// Stress [Pa/Pa] at a point of a half-space by unit tractions on a rectangle of its surface: along x, along y, and
/// a pressure.
///
/// `offset`: field point minus centre of the rectangle [m], the third number being the depth `z >= 0`; `cell`: sides
/// `[dx, dy]` of the rectangle [m]. In the body's own frame (tangential 1, tangential 2, into), tension positive, so
/// that the loaded surface has `zz = -1`, `xz = -1` and `yz = -1`.
///
/// On the surface, a traction along x has an infinite `xx` and `yy` on the sides of the rectangle across x, one along
/// y likewise, both have an infinite `xy` on the other sides, and a pressure has an infinite `xy` at the corners. There
/// a large finite number stands for each.
///
/// Accuracy about 1e-11 of the largest component under any of the tractions, at any distance and depth.
///
/// [Love1929], [Johnson1985, ch. 3], [AhmadiKeerMura1983]
pub fn stress_influence(poisson_ratio: f64, offset: [f64; 3], cell: [f64; 2]) -> [Stress; 3] {
    let unit = cell[0].max(cell[1]);
    let [x, y, z] = offset.map(|v| v / unit);
    let [dx, dy] = cell.map(|v| v / unit);
    if is_near([x, y, z]) {
        let (x, y) = ([x - 0.5 * dx, x + 0.5 * dx], [y - 0.5 * dy, y + 0.5 * dy]);
        let at = |i: usize, j: usize| corner(poisson_ratio, x[i], y[j], z);
        difference([[&at(0, 0), &at(1, 0)], [&at(0, 1), &at(1, 1)]])
    } else {
        far(poisson_ratio, [x, y, z], [dx, dy])
    }
}

/// Whether the closed form is taken at an offset, in larger sides.
pub(super) fn is_near(offset: [f64; 3]) -> bool {
    offset.iter().map(|v| v * v).sum::<f64>() <= CLOSED_TO * CLOSED_TO
}

/// The integral over a rectangle from its antiderivatives at its corners, by `[y][x]`.
pub(super) fn difference(corners: [[&Responses; 2]; 2]) -> Responses {
    let [[a, b], [c, d]] = corners;
    std::array::from_fn(|load| {
        std::array::from_fn(|k| (d[load][k] - c[load][k]) - (b[load][k] - a[load][k]))
    })
}

/// The antiderivative over x and y of the stress by point loads at offsets `x, y`, at the depth `z >= 0`.
///
/// Written so that no difference of almost equal numbers is left: all sums are of numbers of one sign.
pub(super) fn corner(nu: f64, x: f64, y: f64, z: f64) -> Responses {
    let (s, t) = ((x * x + z * z).max(NONE), (y * y + z * z).max(NONE));
    let rho = (x * x + y * y + z * z).max(NONE).sqrt();
    let below = rho + z;
    let xy = x * y;
    // minus V_z, L_xx and L_yy; their limits on the surface are those inside of the rectangle
    let solid = xy.atan2(z * rho);
    let (turn_x, turn_y) = (xy.atan2(s + z * rho), xy.atan2(t + z * rho));
    let log = below.ln();
    // V_x and V_y
    let area_sinh =
        |a: f64, square: f64| (0.5 * ((a.abs() + rho).powi(2) / square).ln()).copysign(a);
    let (log_x, log_y) = (area_sinh(y, s), area_sinh(x, t));
    let (over_s, over_t) = (z * xy / (s * rho), z * xy / (t * rho));
    let (down_x, down_y) = (z * z * y / (s * rho), z * z * x / (t * rho));
    let (level_x, level_y) = (x / below, y / below);
    let over = z / rho;
    let pressure = [
        -2.0 * nu * solid - (1.0 - 2.0 * nu) * turn_x + over_s,
        -2.0 * nu * solid - (1.0 - 2.0 * nu) * turn_y + over_t,
        -solid - over_s - over_t,
        down_y,
        down_x,
        -(1.0 - 2.0 * nu) * log - over,
    ];
    // z L_xxx and z L_yyy
    let bend_x = over * y * (z * rho - x * x) / (s * below);
    let bend_y = over * x * (z * rho - y * y) / (t * below);
    let along_x = [
        2.0 * log_x + 2.0 * nu * level_y - bend_x,
        2.0 * nu * (log_x - level_y) - over * level_y,
        down_x,
        -over,
        over_s - solid,
        log_y - (2.0 * nu + over) * level_x,
    ];
    let along_y = [
        2.0 * nu * (log_y - level_x) - over * level_x,
        2.0 * log_y + 2.0 * nu * level_x - bend_y,
        down_y,
        over_t - solid,
        -over,
        log_x - (2.0 * nu + over) * level_y,
    ];
    [along_x, along_y, pressure].map(|response| response.map(|v| v / (2.0 * PI)))
}

/// The stress by a rectangle far away, offset and sides in units of the larger one.
pub(super) fn far(nu: f64, [x, y, z]: [f64; 3], [dx, dy]: [f64; 2]) -> Responses {
    const TWO: [(f64, f64); 2] = [
        (-0.577_350_269_189_625_8, 0.5),
        (0.577_350_269_189_625_8, 0.5),
    ];
    const THREE: [(f64, f64); 3] = [
        (-0.774_596_669_241_483_4, 5.0 / 18.0),
        (0.0, 8.0 / 18.0),
        (0.774_596_669_241_483_4, 5.0 / 18.0),
    ];
    let is_farther = x * x + y * y + z * z > TWO_POINTS_FROM * TWO_POINTS_FROM;
    let nodes: &[(f64, f64)] = if is_farther { &TWO } else { &THREE };
    let mut sum = [[0.0; 6]; 3];
    for (u, weight_x) in nodes {
        for (v, weight_y) in nodes {
            let found = point_load(nu, x + 0.5 * u * dx, y + 0.5 * v * dy, z);
            let weight = weight_x * weight_y * dx * dy;
            for (sum, found) in sum.iter_mut().flatten().zip(found.iter().flatten()) {
                *sum += weight * found;
            }
        }
    }
    sum
}

/// Stress at an offset by unit forces at a point of the surface: along x, along y, into the body.
pub(super) fn point_load(nu: f64, x: f64, y: f64, z: f64) -> Responses {
    let square = x * x + y * y + z * z;
    let rho = square.sqrt();
    let below = rho + z;
    let (one, two) = (1.0 / rho, 1.0 / below);
    let (cube, fifth) = (one / square, one / (square * square));
    // V and its derivatives
    let (v_x, v_y, v_z) = (-x * cube, -y * cube, -z * cube);
    let (v_xx, v_yy) = (3.0 * x * x * fifth - cube, 3.0 * y * y * fifth - cube);
    let v_zz = 3.0 * z * z * fifth - cube;
    let (v_xy, v_xz, v_yz) = (
        3.0 * x * y * fifth,
        3.0 * x * z * fifth,
        3.0 * y * z * fifth,
    );
    // those of L, all by three functions of the distance and the depth
    let first = one * two;
    let second = first * (one * one + first);
    let third = first * (3.0 * one * one * (one * one + first) + 2.0 * first * first);
    let (l_xx, l_yy) = (first - x * x * second, first - y * y * second);
    let l_xy = -x * y * second;
    let (l_xxx, l_yyy) = (
        x * (x * x * third - 3.0 * second),
        y * (y * y * third - 3.0 * second),
    );
    let (l_xxy, l_xyy) = (y * (x * x * third - second), x * (y * y * third - second));
    // those of M
    let once = first * two;
    let twice = once * (one * one + 2.0 * first);
    let (m_xxx, m_yyy) = (
        x * (3.0 * once - x * x * twice),
        y * (3.0 * once - y * y * twice),
    );
    let (m_xxy, m_xyy) = (y * (once - x * x * twice), x * (once - y * y * twice));
    let free = 1.0 - 2.0 * nu;
    let pressure = [
        2.0 * nu * v_z - free * l_xx - z * v_xx,
        2.0 * nu * v_z - free * l_yy - z * v_yy,
        v_z - z * v_zz,
        -z * v_yz,
        -z * v_xz,
        -free * l_xy - z * v_xy,
    ];
    let along_x = [
        2.0 * (1.0 + nu) * v_x + 2.0 * nu * m_xxx - z * l_xxx,
        2.0 * nu * (v_x + m_xyy) - z * l_xyy,
        -z * v_xz,
        -z * v_xy,
        v_z - z * v_xx,
        v_y + 2.0 * nu * m_xxy - z * l_xxy,
    ];
    let along_y = [
        2.0 * nu * (v_y + m_xxy) - z * l_xxy,
        2.0 * (1.0 + nu) * v_y + 2.0 * nu * m_yyy - z * l_yyy,
        -z * v_yz,
        v_z - z * v_yy,
        -z * v_xy,
        v_x + 2.0 * nu * m_xyy - z * l_xyy,
    ];
    [along_x, along_y, pressure].map(|response| response.map(|v| v / (2.0 * PI)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const NU: f64 = 0.28;

    /// Forces on the body by point loads: the classical solutions of Boussinesq and Cerruti as [Johnson1985, eqs.
    /// 3.19 and 3.75] print them, and not by potentials.
    fn printed(x: f64, y: f64, z: f64) -> [Stress; 2] {
        let rho = (x * x + y * y + z * z).sqrt();
        let r2 = x * x + y * y;
        let free = 1.0 - 2.0 * NU;
        let normal = |x: f64, y: f64| {
            free / r2 * ((1.0 - z / rho) * (x * x - y * y) / r2 + z * y * y / rho.powi(3))
                - 3.0 * z * x * x / rho.powi(5)
        };
        let pressure = [
            normal(x, y),
            normal(y, x),
            -3.0 * z.powi(3) / rho.powi(5),
            -3.0 * y * z * z / rho.powi(5),
            -3.0 * x * z * z / rho.powi(5),
            free / r2 * ((1.0 - z / rho) * 2.0 * x * y / r2 - x * y * z / rho.powi(3))
                - 3.0 * x * y * z / rho.powi(5),
        ];
        let below = rho + z;
        let squares = |a: f64| {
            1.0 / rho.powi(3) - 3.0 / (rho * below * below)
                + a * a / (rho.powi(3) * below * below)
                + 2.0 * a * a / (rho * rho * below.powi(3))
        };
        let along = [
            -3.0 * x.powi(3) / rho.powi(5)
                + free
                    * (x / rho.powi(3) - 3.0 * x / (rho * below * below)
                        + x.powi(3) / (rho.powi(3) * below * below)
                        + 2.0 * x.powi(3) / (rho * rho * below.powi(3))),
            -3.0 * x * y * y / rho.powi(5) + free * x * (squares(y) + 2.0 / (rho * below * below)),
            -3.0 * x * z * z / rho.powi(5),
            -3.0 * x * y * z / rho.powi(5),
            -3.0 * x * x * z / rho.powi(5),
            -3.0 * x * x * y / rho.powi(5)
                + free
                    * y
                    * (-1.0 / (rho * below * below)
                        + x * x / (rho.powi(3) * below * below)
                        + 2.0 * x * x / (rho * rho * below.powi(3))),
        ];
        [along, pressure].map(|response| response.map(|v| v / (2.0 * PI)))
    }

    const PLACES: [[f64; 3]; 5] = [
        [0.7, 0.4, 0.3],
        [-1.3, 2.1, 0.9],
        [0.2, -0.6, 2.5],
        [-3.0, -0.1, 0.01],
        [1.1, 0.8, 7.0],
    ];

    fn largest(stress: &Stress) -> f64 {
        stress.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
    }

    #[test]
    fn point_loads_are_those_in_print() {
        for [x, y, z] in PLACES {
            let found = point_load(NU, x, y, z);
            for (found, printed) in [found[0], found[2]].iter().zip(printed(x, y, z)) {
                for (a, b) in found.iter().zip(printed) {
                    assert!(
                        (a - b).abs() < 1e-13 * largest(&printed),
                        "{x} {y} {z}: {a} {b}"
                    );
                }
            }
        }
    }

    #[test]
    fn rectangles_are_integrals_of_point_loads() {
        let cell = [1.5, 1.0];
        let nodes = [(-0.6f64.sqrt(), 5.0), (0.0, 8.0), (0.6f64.sqrt(), 5.0)];
        let panels = 40;
        for [x, y, z] in [
            [0.3, 0.2, 0.8],
            [1.6, -0.4, 0.5],
            [-2.0, 1.7, 0.2],
            [0.0, 0.0, 3.0],
        ] {
            let found = stress_influence(NU, [x, y, z], cell);
            let mut sum = [[0.0; 6]; 3];
            for i in 0..panels {
                for j in 0..panels {
                    for (u, wu) in nodes {
                        for (v, wv) in nodes {
                            let at = |k: usize, u: f64| {
                                (k as f64 + 0.5 + 0.5 * u) / f64::from(panels as u32) - 0.5
                            };
                            let point =
                                point_load(NU, x - cell[0] * at(i, u), y - cell[1] * at(j, v), z);
                            let weight =
                                wu * wv / 324.0 * cell[0] * cell[1] / (panels * panels) as f64;
                            for (sum, point) in sum.iter_mut().flatten().zip(point.iter().flatten())
                            {
                                *sum += weight * point;
                            }
                        }
                    }
                }
            }
            for (found, sum) in found.iter().zip(&sum) {
                for (a, b) in found.iter().zip(sum) {
                    assert!((a - b).abs() < 1e-9 * largest(sum), "{x} {y} {z}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn closed_form_and_gauss_points_meet() {
        for (distance, tolerance) in [(CLOSED_TO, 3e-11), (TWO_POINTS_FROM, 1e-11)] {
            let mut worst = 0.0_f64;
            for [x, y, z] in [
                [1.0, 0.0, 0.0],
                [0.6, 0.7, 0.1],
                [0.0, 0.3, 0.9],
                [0.01, 0.0, 1.0],
                [0.3, 0.02, 0.01],
                [0.0, 0.0, 1.0],
                [0.03, 0.4, 0.7],
                [0.9, 0.2, 0.0],
            ] {
                let size = f64::sqrt(x * x + y * y + z * z) / distance;
                let offset = [x / size, y / size, z / size];
                for cell in [[1.0, 0.4], [0.7, 1.0], [1.0, 0.1]] {
                    let at = |factor: f64| stress_influence(NU, offset.map(|v| v * factor), cell);
                    let (inside, outside) = (at(1.0 - 1e-13), at(1.0 + 1e-13));
                    // straight above a tangential traction its stress vanishes
                    let size = outside.iter().map(largest).fold(0.0, f64::max);
                    for (a, b) in inside.iter().flatten().zip(outside.iter().flatten()) {
                        worst = worst.max((a - b).abs() / size);
                    }
                }
            }
            assert!(worst < tolerance, "at {distance}: {worst:e}");
        }
    }

    #[test]
    fn the_middle_of_the_loaded_square_has_known_stress() {
        // the surface of a body under uniform pressure [Johnson1985, eq. 3.25]
        let [along, _, pressure] = stress_influence(NU, [0.0; 3], [1.0, 1.0]);
        let side = -0.5 * (1.0 + 2.0 * NU);
        for (found, known) in pressure.iter().zip([side, side, -1.0, 0.0, 0.0, 0.0]) {
            assert!((found - known).abs() < 1e-15);
        }
        for (found, known) in along.iter().zip([0.0, 0.0, 0.0, 0.0, -1.0, 0.0]) {
            assert!((found - known).abs() < 1e-15);
        }
    }

    #[test]
    fn no_place_gives_a_number_that_is_none() {
        for x in [-0.5, 0.0, 0.5, 2.0] {
            for y in [-0.5, 0.0, 0.5, -3.0] {
                for z in [0.0, 1e-300, 1e-12, 1.0, 1e9] {
                    let found = stress_influence(NU, [x, y, z], [1.0, 1.0]);
                    assert!(found.iter().flatten().all(|v| v.is_finite()), "{x} {y} {z}");
                }
            }
        }
    }

    #[test]
    fn beside_an_edge_on_the_surface_logarithms_cancel() {
        // on the line through a side, outside of it: the limit from beside it
        let at = |x: f64, z: f64| stress_influence(NU, [x, 2.0, z], [1.0, 1.0]);
        for (edge, beside) in at(0.5, 0.0).iter().zip(at(0.5 + 1e-9, 1e-9)) {
            for (a, b) in edge.iter().zip(beside) {
                assert!((a - b).abs() < 1e-8, "{a} {b}");
            }
        }
    }
}

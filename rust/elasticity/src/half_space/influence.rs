// SPDX-License-Identifier: MIT OR Apache-2.0
//! Influence coefficients of a uniformly loaded rectangle on the half-space.

use std::f64::consts::PI;

use mtb_operator::Component;

use crate::Material;

/// Distance in cells beyond which the closed form loses more digits to cancellation (about
/// `r^2` epsilons) than three Gauss points per direction leave (about `1e-3 / r^6`).
const THREE_POINTS_FROM: f64 = 30.0;

/// The same for two Gauss points per direction (about `1e-2 / r^4`).
const TWO_POINTS_FROM: f64 = 400.0;

/// Displacement [m/Pa] at a point by a unit traction on a rectangle, any of the nine components.
///
/// `offset`: field point minus centre of the rectangle, any real numbers [m]; `cell`: sides
/// `[dx, dy]` of the rectangle [m]. In the body's own frame (tangential 1, tangential 2, into), with
/// `X, Y` the offset, `r^2 = X^2 + Y^2`, the coefficient is the integral over the rectangle of
///
/// ```text
/// normal by normal        (1 - nu) / (2 pi G r)
/// normal by tangential    (1 - 2 nu) X / (4 pi G r^2)        tangential by normal: its negative
/// xx                      ((1 - nu) / r + nu X^2 / r^3) / (2 pi G)
/// xy, yx                  nu X Y / (2 pi G r^3)
/// ```
///
/// Relative accuracy about 1e-12 of the largest component at the same place, at any distance.
///
/// [Love1929], [Johnson1985, ch. 3], [Kalker1990, app. B]
pub fn influence(
    material: &Material,
    observed: Component,
    loaded: Component,
    offset: [f64; 2],
    cell: [f64; 2],
) -> f64 {
    let (g, nu) = (material.shear_modulus, material.poisson_ratio);
    let (unit, rectangle) = Rectangle::of(offset, cell);
    let same = unit / (2.0 * PI * g);
    let mixed = unit * (1.0 - 2.0 * nu) / (4.0 * PI * g);
    let flipped = rectangle.transposed();
    match (observed, loaded) {
        (Component::Normal, Component::Normal) => same * (1.0 - nu) * rectangle.integral(&INVERSE),
        (Component::X, Component::X) => {
            let [along, _, across] = rectangle.tangential();
            same * ((1.0 - nu) * (along + across) + nu * along)
        }
        (Component::Y, Component::Y) => {
            let [along, _, across] = rectangle.tangential();
            same * ((1.0 - nu) * (along + across) + nu * across)
        }
        (Component::X, Component::Y) | (Component::Y, Component::X) => {
            same * nu * rectangle.integral(&CROSS)
        }
        (Component::Normal, Component::X) => mixed * rectangle.integral(&DIPOLE),
        (Component::X, Component::Normal) => -mixed * rectangle.integral(&DIPOLE),
        (Component::Normal, Component::Y) => mixed * flipped.integral(&DIPOLE),
        (Component::Y, Component::Normal) => -mixed * flipped.integral(&DIPOLE),
    }
}

/// Displacements [m/Pa] xx, xy = yx and yy as of [`influence`], of several bodies together: their integrals are the same.
pub(super) fn tangential<'a>(
    materials: impl Iterator<Item = &'a Material>,
    offset: [f64; 2],
    cell: [f64; 2],
) -> [f64; 3] {
    let (unit, rectangle) = Rectangle::of(offset, cell);
    let [along, cross, across] = rectangle.tangential();
    let mut sum = [0.0; 3];
    for material in materials {
        let nu = material.poisson_ratio;
        let same = unit / (2.0 * PI * material.shear_modulus);
        sum[0] += same * ((1.0 - nu) * (along + across) + nu * along);
        sum[1] += same * nu * cross;
        sum[2] += same * ((1.0 - nu) * (along + across) + nu * across);
    }
    sum
}

/// Displacement [m/N] at `offset` from a unit point load, any of the nine components; see [`influence`].
pub(super) fn point_load(
    material: &Material,
    observed: Component,
    loaded: Component,
    offset: [f64; 2],
) -> f64 {
    let (g, nu) = (material.shear_modulus, material.poisson_ratio);
    let [x, y] = offset;
    let same = 1.0 / (2.0 * PI * g);
    let mixed = (1.0 - 2.0 * nu) / (4.0 * PI * g);
    match (observed, loaded) {
        (Component::Normal, Component::Normal) => same * (1.0 - nu) * (INVERSE.point)(x, y),
        (Component::X, Component::X) => {
            same * ((1.0 - nu) * (INVERSE.point)(x, y) + nu * (ALONG.point)(x, y))
        }
        (Component::Y, Component::Y) => {
            same * ((1.0 - nu) * (INVERSE.point)(x, y) + nu * (ALONG.point)(y, x))
        }
        (Component::X, Component::Y) | (Component::Y, Component::X) => {
            same * nu * (CROSS.point)(x, y)
        }
        (Component::Normal, Component::X) => mixed * (DIPOLE.point)(x, y),
        (Component::X, Component::Normal) => -mixed * (DIPOLE.point)(x, y),
        (Component::Normal, Component::Y) => mixed * (DIPOLE.point)(y, x),
        (Component::Y, Component::Normal) => -mixed * (DIPOLE.point)(y, x),
    }
}

/// A rectangle seen from the field point: offset of its centre and its sides.
struct Rectangle {
    x: f64,
    y: f64,
    dx: f64,
    dy: f64,
}

/// A kernel `k(X, Y)` and its antiderivative in both variables; where known, the integral over a rectangle
/// by the derivatives of the kernel up to the fourth.
struct Integrand {
    point: fn(f64, f64) -> f64,
    corner: fn(f64, f64) -> f64,
    series: Option<fn(&Rectangle) -> f64>,
}

/// 1 / r
const INVERSE: Integrand = Integrand {
    point: |x, y| 1.0 / (x * x + y * y).sqrt(),
    corner: |x, y| along_and_across(x, y).iter().sum(),
    series: Some(|rectangle| {
        let Rectangle { x, y, dx, dy } = *rectangle;
        let (x2, y2, dx2, dy2) = (x * x, y * y, dx * dx, dy * dy);
        let r2 = x2 + y2;
        let inverse = 1.0 / r2;
        let second = dx2 * (3.0 * x2 - r2) + dy2 * (3.0 * y2 - r2);
        let fourth = dx2 * dx2 * (9.0 * r2 * r2 - 90.0 * x2 * r2 + 105.0 * x2 * x2)
            + dy2 * dy2 * (9.0 * r2 * r2 - 90.0 * y2 * r2 + 105.0 * y2 * y2);
        let mixed = dx2 * dy2 * (105.0 * x2 * y2 - 12.0 * r2 * r2);
        let terms = 1.0
            + inverse
                * inverse
                * (second / 24.0 + inverse * inverse * (fourth / 1920.0 + mixed / 576.0));
        dx * dy * inverse.sqrt() * terms
    }),
};

/// X^2 / r^3
const ALONG: Integrand = Integrand {
    point: |x, y| {
        let r2 = x * x + y * y;
        x * x / (r2 * r2.sqrt())
    },
    corner: |x, y| along_and_across(x, y)[0],
    series: None,
};

/// X Y / r^3
const CROSS: Integrand = Integrand {
    point: |x, y| {
        let r2 = x * x + y * y;
        x * y / (r2 * r2.sqrt())
    },
    corner: |x, y| -(x * x + y * y).sqrt(),
    series: None,
};

/// X / r^2
const DIPOLE: Integrand = Integrand {
    point: |x, y| x / (x * x + y * y),
    corner: |x, y| {
        let logarithm = if y == 0.0 {
            0.0
        } else {
            0.5 * y * (x * x + y * y).ln()
        };
        let angle = if x == 0.0 { 0.0 } else { x * (y / x).atan() };
        logarithm + angle
    },
    series: None,
};

/// Antiderivatives of X^2/r^3, `y asinh(x / |y|)`, and of Y^2/r^3, `x asinh(y / |x|)`, with the sums under the logarithms
/// of one sign. Together they are that of 1/r.
fn along_and_across(x: f64, y: f64) -> [f64; 2] {
    let (a, b) = (x.abs(), y.abs());
    let r = (x * x + y * y).sqrt();
    let part = |a: f64, b: f64| {
        if a < 1e-150 {
            0.0
        } else {
            a * ((b + r) / a).ln()
        }
    };
    [part(b, a), part(a, b)].map(|part| part.copysign(x * y))
}

impl Rectangle {
    /// With its unit [m], the larger side: logarithms of lengths cancel without loss.
    fn of(offset: [f64; 2], cell: [f64; 2]) -> (f64, Self) {
        let unit = cell[0].max(cell[1]);
        let rectangle = Self {
            x: offset[0] / unit,
            y: offset[1] / unit,
            dx: cell[0] / unit,
            dy: cell[1] / unit,
        };
        (unit, rectangle)
    }

    /// Integrals of X^2/r^3, XY/r^3 and Y^2/r^3; the first and the last together are that of 1/r.
    fn tangential(&self) -> [f64; 3] {
        if self.distance() > THREE_POINTS_FROM {
            let [along, cross] = [&ALONG, &CROSS].map(|integrand| self.integral(integrand));
            return [along, cross, self.transposed().integral(&ALONG)];
        }
        let corner = |x: f64, y: f64| {
            let [along, across] = along_and_across(x, y);
            [along, (CROSS.corner)(x, y), across]
        };
        let [[a, b], [c, d]] = self.corners(corner);
        std::array::from_fn(|k| (a[k] - b[k]) - (c[k] - d[k]))
    }

    fn distance(&self) -> f64 {
        (self.x * self.x + self.y * self.y).sqrt()
    }

    /// Of the corners at the larger y, that of the larger x first; then of the others.
    fn corners<T>(&self, corner: impl Fn(f64, f64) -> T) -> [[T; 2]; 2] {
        let (x1, x2) = (self.x - 0.5 * self.dx, self.x + 0.5 * self.dx);
        let (y1, y2) = (self.y - 0.5 * self.dy, self.y + 0.5 * self.dy);
        [y2, y1].map(|y| [x2, x1].map(|x| corner(x, y)))
    }

    fn transposed(&self) -> Self {
        Self {
            x: self.y,
            y: self.x,
            dx: self.dy,
            dy: self.dx,
        }
    }

    fn integral(&self, integrand: &Integrand) -> f64 {
        let distance = self.distance();
        if let Some(series) = integrand.series
            && distance > THREE_POINTS_FROM
        {
            return series(self);
        }
        if distance > TWO_POINTS_FROM {
            let (a, b) = (0.5 * self.dx / 3f64.sqrt(), 0.5 * self.dy / 3f64.sqrt());
            let sum: f64 = [-a, a]
                .iter()
                .flat_map(|u| [-b, b].map(|v| (integrand.point)(self.x + u, self.y + v)))
                .sum();
            return 0.25 * self.dx * self.dy * sum;
        }
        if distance > THREE_POINTS_FROM {
            let nodes = [(-0.6f64.sqrt(), 5.0), (0.0, 8.0), (0.6f64.sqrt(), 5.0)];
            let mut sum = 0.0;
            for (u, weight_x) in nodes {
                for (v, weight_y) in nodes {
                    let point =
                        (integrand.point)(self.x + 0.5 * u * self.dx, self.y + 0.5 * v * self.dy);
                    sum += weight_x * weight_y * point;
                }
            }
            return self.dx * self.dy * sum / 324.0;
        }
        let [[a, b], [c, d]] = self.corners(integrand.corner);
        (a - b) - (c - d)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Component::{Normal, X, Y};

    const STEEL: Material = Material {
        shear_modulus: 80e9,
        poisson_ratio: 0.3,
    };
    const COMPONENTS: [Component; 3] = [X, Y, Normal];

    /// Written out once more, for the tests.
    fn point_load(observed: Component, loaded: Component, x: f64, y: f64) -> f64 {
        let (g, nu) = (STEEL.shear_modulus, STEEL.poisson_ratio);
        let r = x.hypot(y);
        let same = 1.0 / (2.0 * PI * g);
        let mixed = (1.0 - 2.0 * nu) / (4.0 * PI * g);
        match (observed, loaded) {
            (Normal, Normal) => same * (1.0 - nu) / r,
            (X, X) => same * ((1.0 - nu) / r + nu * x * x / r.powi(3)),
            (Y, Y) => same * ((1.0 - nu) / r + nu * y * y / r.powi(3)),
            (X, Y) | (Y, X) => same * nu * x * y / r.powi(3),
            (Normal, X) => mixed * x / (r * r),
            (X, Normal) => -mixed * x / (r * r),
            (Normal, Y) => mixed * y / (r * r),
            (Y, Normal) => -mixed * y / (r * r),
        }
    }

    #[test]
    fn love_centre_and_corner_of_the_square() {
        // [Johnson1985, eq. 3.26]: pi E / (1 - nu^2) u / p = 4 ln(1 + sqrt 2) c at a corner, twice that inside
        let side = 2e-3;
        let corner = 2.0 * (1.0 + 2f64.sqrt()).ln() * side * (1.0 - 0.3) / (2.0 * PI * 80e9);
        let at = |x, y| influence(&STEEL, Normal, Normal, [x, y], [side, side]);
        assert!((at(0.5 * side, 0.5 * side) / corner - 1.0).abs() < 1e-14);
        assert!((at(0.0, 0.0) / (2.0 * corner) - 1.0).abs() < 1e-14);
    }

    #[test]
    #[allow(clippy::float_cmp, reason = "the same operations in the same order")]
    fn symmetries() {
        let cell = [3e-3, 1e-3];
        let at = |a, b, x, y| influence(&STEEL, a, b, [x, y], cell);
        for (x, y) in [(2e-3, 1.7e-3), (0.4e-3, 5e-3), (0.2, -0.1), (3.0, 2.0)] {
            assert_eq!(at(X, Y, x, y), at(Y, X, x, y));
            for tangential in [X, Y] {
                assert_eq!(at(Normal, tangential, x, y), -at(tangential, Normal, x, y));
            }
            for a in COMPONENTS {
                for b in COMPONENTS {
                    // reciprocity: swapping points and components changes nothing
                    let (there, back) = (at(a, b, x, y), at(b, a, -x, -y));
                    let scale = at(Normal, Normal, x, y);
                    assert!((there - back).abs() <= 1e-12 * scale, "{a:?} {b:?}");
                }
            }
        }
        // turning the picture by a quarter
        let turned = influence(&STEEL, Y, Y, [1.7e-3, 2e-3], [1e-3, 3e-3]);
        assert_eq!(at(X, X, 2e-3, 1.7e-3), turned);
    }

    #[test]
    fn far_field_is_the_point_load() {
        let cell = [2e-3, 1e-3];
        for a in COMPONENTS {
            for b in COMPONENTS {
                for (x, y) in [(0.7, 0.4), (-3.0, 1.0), (0.0, 5.0)] {
                    let value = influence(&STEEL, a, b, [x, y], cell) / (cell[0] * cell[1]);
                    let scale = point_load(Normal, Normal, x, y);
                    let error = (value - point_load(a, b, x, y)).abs();
                    assert!(error < 2e-5 * scale, "{a:?} {b:?} {x} {y}");
                }
            }
        }
    }

    #[test]
    fn quadrature_agrees_outside_and_at_fractional_offsets() {
        // composite Gauss, fine enough for rounding, outside of the loaded rectangle
        let cell = [1.5e-3, 1e-3];
        let panels = 24;
        let nodes = [
            (-0.6f64.sqrt(), 5.0 / 18.0),
            (0.0, 8.0 / 18.0),
            (0.6f64.sqrt(), 5.0 / 18.0),
        ];
        for (x, y) in [
            (1.9e-3, 0.3e-3),
            (-2.31e-3, 1.47e-3),
            (0.0, 3.3e-3),
            (25e-3, 18e-3),
        ] {
            for a in COMPONENTS {
                for b in COMPONENTS {
                    let mut sum = 0.0;
                    for i in 0..panels {
                        for j in 0..panels {
                            for (u, wu) in nodes {
                                for (v, wv) in nodes {
                                    let at = |k: usize, u: f64| {
                                        (k as f64 + 0.5 + 0.5 * u) / f64::from(panels as u32) - 0.5
                                    };
                                    let (xs, ys) = (at(i, u) * cell[0], at(j, v) * cell[1]);
                                    sum += wu * wv * point_load(a, b, x - xs, y - ys);
                                }
                            }
                        }
                    }
                    sum *= cell[0] * cell[1] / (panels * panels) as f64;
                    let value = influence(&STEEL, a, b, [x, y], cell);
                    let scale = influence(&STEEL, Normal, Normal, [x, y], cell);
                    assert!((value - sum).abs() < 1e-11 * scale, "{a:?} {b:?} {x} {y}");
                }
            }
        }
    }

    #[test]
    fn closed_form_and_gauss_points_meet() {
        for (distance, tolerance) in [(THREE_POINTS_FROM, 1e-11), (TWO_POINTS_FROM, 1e-11)] {
            for direction in [0.0, 0.3, 0.8, 1.2] {
                for a in COMPONENTS {
                    for b in COMPONENTS {
                        let at = |factor: f64| {
                            let r = distance * factor * 1e-3;
                            let offset = [r * f64::cos(direction), r * f64::sin(direction)];
                            influence(&STEEL, a, b, offset, [1e-3, 0.4e-3]) * factor
                        };
                        // all kernels fall with 1 / r up to a correction of second order in the cell
                        let (inside, outside) = (at(1.0 - 1e-9), at(1.0 + 1e-9));
                        let scale = influence(
                            &STEEL,
                            Normal,
                            Normal,
                            [distance * 1e-3, 0.0],
                            [1e-3, 0.4e-3],
                        );
                        assert!((inside - outside).abs() < tolerance * scale, "{a:?} {b:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn stays_finite_on_edges_and_corners() {
        for a in COMPONENTS {
            for b in COMPONENTS {
                for x in [-0.5, 0.0, 0.5] {
                    for y in [-0.5, 0.0, 0.5] {
                        assert!(influence(&STEEL, a, b, [x, y], [1.0, 1.0]).is_finite());
                    }
                }
            }
        }
    }
}

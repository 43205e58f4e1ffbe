// SPDX-License-Identifier: MIT OR Apache-2.0
//! Surfaces of bodies, and what a line meets on them.

use crate::Error;
use crate::error::{all_finite, finite, out_of_range, positive};
use crate::{Interpolation, Profile};

/// How a point of a surface was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    /// On the line itself.
    OnLine,
    /// As the nearest point, where the line misses the surface.
    Nearest,
}

/// A point of a surface, seen from a point and a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the direction, signed [m]; towards the nearest point where the line misses.
    pub distance: f64,
    /// Unit normal of the surface, out of its body.
    pub normal: [f64; 3],
    /// Estimated error of the distance because the surface is known by facets only [m].
    pub facet_error: f64,
    /// How it was found.
    pub found: Found,
}

/// The surface of a body as contact sees it.
pub trait Surface: Send + Sync {
    /// Height z [m] of the highest point above `(x, y)`, as a hit: distance = z.
    fn top(&self, x: f64, y: f64) -> Option<Hit>;

    /// The point of the surface on the line `point + t direction` (unit) that faces the direction, the
    /// one with the smallest `|t| <= reach`.
    fn cast(&self, point: [f64; 3], direction: [f64; 3], reach: f64) -> Option<Hit>;
}

/// A smooth body given by a height z(x, y); below it if it is the lower body, above it if it is the
/// upper one.
#[derive(Clone, Debug)]
pub enum HeightSurface {
    /// z = height everywhere.
    Plane {
        /// z [m].
        height: f64,
    },
    /// z = height over a rectangle about the origin, nothing outside: the face of a block.
    Block {
        /// Extents along x and y [m].
        size: [f64; 2],
        /// z [m].
        height: f64,
    },
    /// `z = (x^2 / radius_x + y^2 / radius_y) / 2`, apex at the origin; negative radii open downwards.
    Paraboloid {
        /// Radii of curvature in the planes y = 0 and x = 0 [m].
        radii: [f64; 2],
    },
    /// A profile z(y), the same for all `|x| <= length / 2`.
    Prism {
        /// Cross-section.
        profile: Profile,
        /// Extent along x [m].
        length: f64,
    },
    /// Heights on a regular grid.
    Field(HeightField),
}

/// Heights on a regular grid, smooth between its points.
#[derive(Clone, Debug)]
pub struct HeightField {
    start: [f64; 2],
    spacing: [f64; 2],
    shape: [usize; 2],
    /// Bicubic Hermite data by point: z, dz/dx, dz/dy, d2z/dxdy.
    data: Vec<[f64; 4]>,
}

impl HeightField {
    /// Through `heights` (ny, nx) [m], x fastest, the first at `start`, by bicubic splines.
    ///
    /// # Errors
    /// Fewer than 2 x 2 heights, a length that is not `nx * ny`, values not finite, spacing not
    /// positive.
    pub fn new(
        heights: &[f64],
        shape: [usize; 2],
        start: [f64; 2],
        spacing: [f64; 2],
    ) -> Result<Self, Error> {
        let [ny, nx] = shape;
        if nx < 2 || ny < 2 || heights.len() != nx * ny {
            return Err(Error::Length {
                name: "heights",
                found: heights.len(),
                accepted: format!("a grid of {ny} x {nx} was announced, at least 2 x 2 is needed"),
            });
        }
        all_finite("heights", heights)?;
        for (name, value) in [("start x", start[0]), ("start y", start[1])] {
            finite(name, value)?;
        }
        positive("spacing along x", spacing[0])?;
        positive("spacing across", spacing[1])?;
        let mut data: Vec<[f64; 4]> = heights.iter().map(|&z| [z, 0.0, 0.0, 0.0]).collect();
        // slopes along x of z, along y of z, along x of the slopes along y
        for (from, to, along_x) in [(0, 1, true), (0, 2, false), (2, 3, true)] {
            let (lines, count) = if along_x { (ny, nx) } else { (nx, ny) };
            let step = spacing[usize::from(!along_x)];
            let stations: Vec<f64> = (0..count).map(|i| step * i as f64).collect();
            for line in 0..lines {
                let at = |i: usize| {
                    if along_x {
                        line * nx + i
                    } else {
                        i * nx + line
                    }
                };
                let values: Vec<f64> = (0..count).map(|i| data[at(i)][from]).collect();
                let spline = Profile::from_points(&stations, &values, Interpolation::Smooth)?;
                for (i, station) in spline.stations(&stations)?.iter().enumerate() {
                    data[at(i)][to] = station.slope;
                }
            }
        }
        Ok(Self {
            start,
            spacing,
            shape,
            data,
        })
    }

    fn height(&self, x: f64, y: f64) -> Option<(f64, [f64; 2])> {
        let [ny, nx] = self.shape;
        let cell = |value: f64, start: f64, step: f64, n: usize| {
            let t = (value - start) / step;
            let last = n as f64 - 1.0;
            // the last grid line belongs to the field, to rounding
            (t >= -1e-9 && t <= last + 1e-9).then(|| {
                let i = (t.max(0.0) as usize).min(n - 2);
                (i, t - i as f64)
            })
        };
        let (i, t) = cell(x, self.start[0], self.spacing[0], nx)?;
        let (j, u) = cell(y, self.start[1], self.spacing[1], ny)?;
        let (bx, dbx) = hermite(t, self.spacing[0]);
        let (by, dby) = hermite(u, self.spacing[1]);
        let (mut z, mut zx, mut zy) = (0.0, 0.0, 0.0);
        for (b, a) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let d = &self.data[(j + b) * nx + i + a];
            for (k, (p, q)) in [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().enumerate() {
                z += d[k] * bx[a][p] * by[b][q];
                zx += d[k] * dbx[a][p] * by[b][q];
                zy += d[k] * bx[a][p] * dby[b][q];
            }
        }
        Some((z, [zx, zy]))
    }
}

/// Cubic Hermite basis `[end][value or slope]` at `t` of an interval of length `h`, and its derivative.
fn hermite(t: f64, h: f64) -> ([[f64; 2]; 2], [[f64; 2]; 2]) {
    let (t2, t3) = (t * t, t * t * t);
    (
        [
            [2.0 * t3 - 3.0 * t2 + 1.0, h * (t3 - 2.0 * t2 + t)],
            [3.0 * t2 - 2.0 * t3, h * (t3 - t2)],
        ],
        [
            [(6.0 * t2 - 6.0 * t) / h, 3.0 * t2 - 4.0 * t + 1.0],
            [(6.0 * t - 6.0 * t2) / h, 3.0 * t2 - 2.0 * t],
        ],
    )
}

impl HeightSurface {
    /// Checks the parameters of the surface.
    ///
    /// # Errors
    /// Sizes, radii or heights that are not finite, sizes not positive, radii zero.
    pub fn checked(self) -> Result<Self, Error> {
        match &self {
            Self::Plane { height } => {
                finite("height", *height)?;
            }
            Self::Block { size, height } => {
                finite("height", *height)?;
                positive("block length", size[0])?;
                positive("block width", size[1])?;
            }
            Self::Paraboloid { radii } => {
                for radius in radii {
                    // an infinite radius is a cylinder
                    if radius.is_nan() || *radius == 0.0 {
                        let accepted = "a radius of curvature must not be zero";
                        return Err(out_of_range("paraboloid radius", *radius, accepted));
                    }
                }
            }
            Self::Prism { length, .. } => {
                positive("length", *length)?;
            }
            Self::Field(_) => {}
        }
        Ok(self)
    }

    /// Height z [m] and its gradient above `(x, y)`, `None` outside the surface.
    pub fn height(&self, x: f64, y: f64) -> Option<(f64, [f64; 2])> {
        match self {
            Self::Plane { height } => Some((*height, [0.0; 2])),
            Self::Block { size, height } => {
                let inside = x.abs() <= 0.5 * size[0] && y.abs() <= 0.5 * size[1];
                inside.then_some((*height, [0.0; 2]))
            }
            Self::Paraboloid { radii } => Some((
                0.5 * (x * x / radii[0] + y * y / radii[1]),
                [x / radii[0], y / radii[1]],
            )),
            Self::Prism { profile, length } => {
                let s = profile.at(y)?;
                (x.abs() <= 0.5 * length).then_some((s.height, [0.0, s.slope]))
            }
            Self::Field(field) => field.height(x, y),
        }
    }
}

/// Unit normal of a height field, up.
fn up(gradient: [f64; 2]) -> [f64; 3] {
    let r = (1.0 + gradient[0] * gradient[0] + gradient[1] * gradient[1]).sqrt();
    [-gradient[0] / r, -gradient[1] / r, 1.0 / r]
}

impl Surface for HeightSurface {
    fn top(&self, x: f64, y: f64) -> Option<Hit> {
        self.height(x, y).map(|(z, gradient)| Hit {
            distance: z,
            normal: up(gradient),
            facet_error: 0.0,
            found: Found::OnLine,
        })
    }

    fn cast(&self, point: [f64; 3], direction: [f64; 3], reach: f64) -> Option<Hit> {
        let mut t = 0.0;
        let mut normal = [0.0; 3];
        for _ in 0..60 {
            let at = |i: usize| point[i] + t * direction[i];
            let (z, gradient) = self.height(at(0), at(1))?;
            normal = up(gradient);
            let closing = direction[2] - gradient[0] * direction[0] - gradient[1] * direction[1];
            let step = (z - at(2)) / closing;
            t += step;
            if t.is_nan() || t.abs() > 2.0 * reach {
                return None;
            }
            if step.abs() <= 1e-15 + 4.0 * f64::EPSILON * t.abs() {
                break;
            }
        }
        let facing: f64 = (0..3).map(|i| normal[i] * direction[i]).sum();
        (t.abs() <= reach).then(|| Hit {
            distance: t,
            normal: normal.map(|n| if facing > 0.0 { -n } else { n }),
            facet_error: 0.0,
            found: Found::OnLine,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn height_field_converges_at_fourth_order() {
        let f = |x: f64, y: f64| 1e-3 * (x.sin() * (1.3 * y).cos());
        let error = |n: usize| {
            let h = 3.0 / (n - 1) as f64;
            let heights: Vec<f64> = (0..n * n)
                .map(|k| f(h * (k % n) as f64 - 1.0, h * (k / n) as f64 - 1.0))
                .collect();
            let field = HeightField::new(&heights, [n, n], [-1.0; 2], [h; 2]).unwrap();
            (0..2500)
                .map(|k| {
                    (
                        f64::from(k % 50) / 25.0 - 0.9,
                        f64::from(k / 50) / 25.0 - 0.9,
                    )
                })
                .map(|(x, y)| (field.height(x, y).unwrap().0 - f(x, y)).abs())
                .fold(0.0, f64::max)
        };
        let rate = (error(21) / error(41)).log2();
        assert!(rate > 3.7, "rate {rate}");
    }

    #[test]
    fn bad_fields_are_named() {
        let bad = |z: &[f64], shape, spacing| {
            HeightField::new(z, shape, [0.0; 2], spacing)
                .unwrap_err()
                .to_string()
        };
        assert!(bad(&[0.0; 3], [2, 2], [1.0; 2]).contains("heights has 3"));
        assert!(bad(&[0.0; 2], [1, 2], [1.0; 2]).contains("at least 2 x 2"));
        assert!(bad(&[0.0, 0.0, f64::NAN, 0.0], [2, 2], [1.0; 2]).contains("heights[2]"));
        assert!(bad(&[0.0; 4], [2, 2], [1.0, -1.0]).contains("spacing across is -1"));
        let paraboloid = HeightSurface::Paraboloid { radii: [0.0, 1.0] };
        assert!(paraboloid.checked().is_err());
    }

    proptest! {
        #[test]
        fn cast_ends_on_the_surface(x in -0.02..0.02_f64, y in -0.02..0.02_f64, z in -0.01..0.0_f64,
                                    tilt in -0.3..0.3_f64) {
            let surface = HeightSurface::Paraboloid { radii: [0.3, 0.08] };
            let direction = [tilt.sin(), 0.0, tilt.cos()];
            let hit = surface.cast([x, y, z], direction, 0.1).unwrap();
            let end = [x + hit.distance * direction[0], y, z + hit.distance * direction[2]];
            let (height, _) = surface.height(end[0], end[1]).unwrap();
            prop_assert!((height - end[2]).abs() < 1e-14);
            prop_assert!(hit.normal[2] < 0.0);
        }
    }
}

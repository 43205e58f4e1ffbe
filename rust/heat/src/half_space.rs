// SPDX-License-Identifier: MIT OR Apache-2.0
//! A half-space that moves under a source of heat at rest.

use std::collections::HashMap;
use std::f64::consts::PI;

use rayon::prelude::*;

use crate::Conductor;
use crate::error::{Error, check, positive};

/// A half-space that moves at a speed in a direction under heat that is at rest, in its steady state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    conductor: Conductor,
    speed: f64,
    direction: [f64; 2],
}

/// Smallest part of a side over which an integral is taken, over the side.
const FINEST: f64 = 1e-9;
/// Relative error of the influence of a rectangle.
const TOLERANCE: f64 = 1e-9;

impl HalfSpace {
    /// Of a `conductor` whose points move with `velocity` [m/s] under the heat; zero is at rest.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn new(conductor: Conductor, velocity: [f64; 2]) -> Result<Self, Error> {
        check("velocity", &velocity, 2)?;
        let speed = velocity[0].hypot(velocity[1]);
        let direction = if speed > 0.0 {
            velocity.map(|v| v / speed)
        } else {
            [1.0, 0.0]
        };
        Ok(Self {
            conductor,
            speed,
            direction,
        })
    }

    /// The material.
    pub fn conductor(&self) -> Conductor {
        self.conductor
    }

    /// Peclet number `V a / (2 kappa)` of a half-length `a` [m].
    pub fn peclet(&self, half_length: f64) -> f64 {
        0.5 * self.speed * half_length / self.conductor.diffusivity()
    }

    /// Temperature [K m2/W] at `point` by a unit flux into the rectangle with sides of the lengths `size` [m] around
    /// (0, 0), along x and y.
    ///
    /// In polar coordinates about the point the integral over the distance is known, and that over the
    /// angle remains: over each side, with the sign by which the side is seen from within or from without.
    ///
    /// # Errors
    /// [`Error::NotPositive`], [`Error::NotFinite`].
    pub fn influence(&self, point: [f64; 2], size: [f64; 2]) -> Result<f64, Error> {
        check("point", &point, 2)?;
        positive("size[0]", size[0])?;
        positive("size[1]", size[1])?;
        let (a, b) = (0.5 * size[0], 0.5 * size[1]);
        let corner = |x: f64, y: f64| [x - point[0], y - point[1]];
        let corners = [corner(-a, -b), corner(a, -b), corner(a, b), corner(-a, b)];
        let total: f64 = (0..4)
            .map(|k| self.side(corners[k], corners[(k + 1) % 4]))
            .sum();
        Ok(total / (2.0 * PI * self.conductor.conductivity()))
    }

    /// Temperatures (n, n) [K m2/W] at `points` (n) by a unit flux into the rectangle of `sizes` (n) around each of
    /// them, row-major: rows of the points that warm.
    ///
    /// # Errors
    /// As [`HalfSpace::influence`].
    pub fn influences(&self, points: &[[f64; 2]], sizes: &[[f64; 2]]) -> Result<Vec<f64>, Error> {
        let pairs = pairs(points, sizes)?;
        // on regular grids most distances come again and again
        let mut places: HashMap<[u64; 4], usize> = HashMap::new();
        let mut unlike: Vec<([f64; 2], [f64; 2])> = Vec::new();
        let numbers: Vec<usize> = pairs
            .map(|(offset, size)| {
                let key = [offset[0], offset[1], size[0], size[1]]
                    .map(|v| (v as f32 + 0.0).to_bits().into());
                *places.entry(key).or_insert_with(|| {
                    unlike.push((offset, size));
                    unlike.len() - 1
                })
            })
            .collect();
        let values: Result<Vec<f64>, Error> = unlike
            .par_iter()
            .map(|&(offset, size)| self.influence(offset, size))
            .collect();
        let values = values?;
        Ok(numbers.into_iter().map(|k| values[k]).collect())
    }

    /// How far `points` (n) rise by a unit flux into the rectangle of `sizes` (n) around each of them (n, n) [m3/W],
    /// row-major, for a coefficient of linear `expansion` [1/K] and Poisson's ratio `poisson_ratio`.
    ///
    /// The heat stays in a thin skin. The expansion of a skin that is hindered along the surface is
    /// `(1 + nu) / (1 - nu)` of the free one, and the forces in the skin raise what is below by `1 - 2 nu` of this:
    /// by `2 (1 + nu) alpha` times heat over capacity together. A point has the heat of all rectangles that it
    /// has passed, so a moving half-space is needed, and heat across the direction of motion is left out.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`], [`Error::NotPositive`] for a speed of zero.
    pub fn swelling(
        &self,
        points: &[[f64; 2]],
        sizes: &[[f64; 2]],
        expansion: f64,
        poisson_ratio: f64,
    ) -> Result<Vec<f64>, Error> {
        positive("speed", self.speed)?;
        check(
            "expansion and Poisson's ratio",
            &[expansion, poisson_ratio],
            2,
        )?;
        let each =
            2.0 * (1.0 + poisson_ratio) * expansion / (self.conductor.capacity() * self.speed);
        let [c, s] = self.direction;
        Ok(pairs(points, sizes)?
            .map(|(offset, size)| {
                let (along, across) =
                    (c * offset[0] + s * offset[1], c * offset[1] - s * offset[0]);
                let length = size[0] * c.abs() + size[1] * s.abs();
                let width = size[0] * s.abs() + size[1] * c.abs();
                let passed = (along + 0.5 * length).clamp(0.0, length);
                if across.abs() < 0.5 * width {
                    each * passed
                } else {
                    0.0
                }
            })
            .collect())
    }

    /// The integral over the triangle between the point and a side, positive if the side is passed to the left.
    fn side(&self, from: [f64; 2], to: [f64; 2]) -> f64 {
        let along = [to[0] - from[0], to[1] - from[1]];
        let length = along[0].hypot(along[1]);
        let along = along.map(|c| c / length);
        // distance of the line, positive if the point is to the left of the side
        let distance = from[0] * along[1] - from[1] * along[0];
        if distance.abs() <= FINEST * length {
            return 0.0;
        }
        let (start, end) = (
            from[0] * along[0] + from[1] * along[1],
            to[0] * along[0] + to[1] * along[1],
        );
        // the side at t is seen in the direction of distance * normal + t * along
        let normal = [along[1], -along[0]];
        let rate = 0.5 * self.speed / self.conductor.diffusivity();
        let integrand = |t: f64| {
            let r2 = distance * distance + t * t;
            let r = r2.sqrt();
            let towards: f64 = (0..2)
                .map(|k| self.direction[k] * (distance * normal[k] + t * along[k]))
                .sum();
            // the source lies at that place, the point at a distance r of it: upstream of the source if it looks
            // downstream
            let decay = rate * (r + towards);
            let reach = if decay < 1e-5 {
                r * (1.0 - 0.5 * decay * (1.0 - decay / 3.0))
            } else {
                r * -(-decay).exp_m1() / decay
            };
            reach * distance / r2
        };
        // places where the integrand changes fastest: nearest to the point, and straight upstream of it
        let upstream = -self.direction[0] * along[0] - self.direction[1] * along[1];
        let facing = -self.direction[0] * normal[0] - self.direction[1] * normal[1];
        let mut cuts = vec![start, end];
        if facing * distance > 0.0 {
            cuts.push(distance * upstream / facing);
        }
        cuts.push(0.0);
        cuts.retain(|t| *t >= start && *t <= end);
        cuts.sort_by(f64::total_cmp);
        cuts.windows(2)
            .filter(|w| w[1] - w[0] > FINEST * length)
            .map(|w| towards_ends(&integrand, w[0], w[1], FINEST * length))
            .sum()
    }
}

/// Offset of each point from each other one, and the size there.
fn pairs<'a>(
    points: &'a [[f64; 2]],
    sizes: &'a [[f64; 2]],
) -> Result<impl Iterator<Item = ([f64; 2], [f64; 2])> + 'a, Error> {
    if sizes.len() != points.len() {
        return Err(Error::Shape {
            name: "sizes",
            found: sizes.len(),
            expected: points.len(),
        });
    }
    for point in points {
        check("point", point, 2)?;
    }
    for size in sizes {
        positive("size[0]", size[0])?;
        positive("size[1]", size[1])?;
    }
    Ok(points.iter().flat_map(move |p| {
        points
            .iter()
            .zip(sizes)
            .map(move |(q, size)| ([p[0] - q[0], p[1] - q[1]], *size))
    }))
}

/// The integral of a function that changes fastest near the ends, by Gauss' rule on parts that grow away from both.
fn towards_ends(f: &impl Fn(f64) -> f64, from: f64, to: f64, finest: f64) -> f64 {
    let middle = 0.5 * (from + to);
    graded(&|t| f(from + t), middle - from, finest) + graded(&|t| f(to - t), to - middle, finest)
}

/// The integral over (0, length) by parts that halve towards zero, until halving tells no more.
fn graded(f: &impl Fn(f64) -> f64, length: f64, finest: f64) -> f64 {
    let (mut total, mut end) = (0.0, length);
    let mut whole = gauss(f, 0.0, end);
    loop {
        let middle = 0.5 * end;
        let (near, far) = (gauss(f, 0.0, middle), gauss(f, middle, end));
        let change = (near + far - whole).abs();
        total += far;
        if change <= TOLERANCE * (total + near).abs() || middle <= finest {
            return total + near;
        }
        (end, whole) = (middle, near);
    }
}

/// Abscissae and weights of Gauss' rule with 8 points on (-1, 1), of which the other half mirrors them.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_2, 0.101_228_536_290_376_26),
];

fn gauss(f: &impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let sum: f64 = GAUSS
        .iter()
        .map(|(x, w)| w * (f(middle - half * x) + f(middle + half * x)))
        .sum();
    half * sum
}

// SPDX-License-Identifier: MIT OR Apache-2.0
use crate::root;

/// Height of a profile and its derivatives at one lateral position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// z [m].
    pub height: f64,
    /// dz/dy [-].
    pub slope: f64,
    /// d2z/dy2 [1/m].
    pub bend: f64,
}

impl Station {
    /// Signed curvature `z'' / (1 + z'^2)^(3/2)` [1/m], negative on a convex rail head.
    pub fn curvature(&self) -> f64 {
        self.bend / (1.0 + self.slope * self.slope).powf(1.5)
    }

    /// Unit normal `(y, z)` pointing up.
    pub fn normal(&self) -> [f64; 2] {
        let r = (1.0 + self.slope * self.slope).sqrt();
        [-self.slope / r, 1.0 / r]
    }
}

/// The curve of one piece of a profile.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Curve {
    /// `z = sum c_k (y - origin)^k`, SI units.
    Polynomial { origin: f64, coefficients: Vec<f64> },
    /// `z = center_z + side * sqrt(radius^2 - (y - center_y)^2)`, side = 1 or -1.
    Arc {
        center: [f64; 2],
        radius: f64,
        side: f64,
    },
}

/// A curve between two lateral positions [m], with the arc length from the start of the profile to
/// its own start.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Piece {
    pub(super) start: f64,
    pub(super) end: f64,
    pub(super) length_before: f64,
    pub(super) curve: Curve,
}

/// Gauss-Legendre rule with 8 points on [-1, 1]: positive abscissae and their weights.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_47),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

impl Piece {
    pub(super) fn new(start: f64, end: f64, curve: Curve) -> Self {
        Self {
            start,
            end,
            length_before: 0.0,
            curve,
        }
    }

    pub(super) fn at(&self, y: f64) -> Station {
        match &self.curve {
            Curve::Polynomial {
                origin,
                coefficients,
            } => {
                let t = y - origin;
                let (mut height, mut slope, mut half_bend) = (0.0, 0.0, 0.0);
                for c in coefficients.iter().rev() {
                    half_bend = half_bend * t + slope;
                    slope = slope * t + height;
                    height = height * t + c;
                }
                Station {
                    height,
                    slope,
                    bend: 2.0 * half_bend,
                }
            }
            Curve::Arc {
                center,
                radius,
                side,
            } => {
                let t = y - center[0];
                let root = ((radius - t) * (radius + t)).max(0.0).sqrt();
                Station {
                    height: center[1] + side * root,
                    slope: -side * t / root,
                    bend: -side * radius * radius / (root * root * root),
                }
            }
        }
    }

    /// Arc length from the start of the piece to `y`.
    pub(super) fn length_to(&self, y: f64) -> f64 {
        match &self.curve {
            Curve::Arc { center, radius, .. } => {
                let angle = |v: f64| ((v - center[0]) / radius).clamp(-1.0, 1.0).asin();
                radius * (angle(y) - angle(self.start))
            }
            Curve::Polynomial { coefficients, .. } => {
                let panels = match coefficients.len() {
                    0..=2 => 1,
                    3..=4 => 4,
                    _ => 64,
                };
                let half = 0.5 * (y - self.start) / f64::from(panels);
                let mut sum = 0.0;
                for panel in 0..panels {
                    let middle = self.start + half * f64::from(2 * panel + 1);
                    for (abscissa, weight) in GAUSS {
                        for sign in [-1.0, 1.0] {
                            let slope = self.at(middle + sign * abscissa * half).slope;
                            sum += weight * slope.hypot(1.0);
                        }
                    }
                }
                sum * half
            }
        }
    }

    /// Lateral position at the arc length `length` from the start of the piece.
    pub(super) fn position_at(&self, length: f64) -> f64 {
        match &self.curve {
            Curve::Arc { center, radius, .. } => {
                let first = ((self.start - center[0]) / radius).clamp(-1.0, 1.0).asin();
                center[0] + radius * (first + length / radius).sin()
            }
            Curve::Polynomial { .. } => {
                let share = (length / self.length_to(self.end)).clamp(0.0, 1.0);
                root::increasing(
                    |y| (self.length_to(y), self.at(y).slope.hypot(1.0)),
                    length,
                    [self.start, self.end],
                    self.start + (self.end - self.start) * share,
                )
            }
        }
    }
}

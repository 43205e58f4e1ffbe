// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rays from a point to the end of what is integrated.

/// Where the rays of an angular interval end.
#[derive(Clone, Copy, Debug)]
pub(super) enum End {
    /// On the circle of that radius.
    Arc(f64),
    /// On the line `x = c`.
    X(f64),
    /// On the line `y = c`.
    Y(f64),
}

/// What ends the ray from the origin along `(cos, sin)`: the circle of radius `outer` or a side of
/// the rectangle `[x_low, x_high, y_low, y_high]` that contains the origin.
pub(super) fn ray_end(sides: [f64; 4], cos: f64, sin: f64, outer: f64) -> End {
    let x = if cos > 0.0 { sides[1] } else { sides[0] };
    let y = if sin > 0.0 { sides[3] } else { sides[2] };
    let (to_x, to_y) = (x / cos, y / sin);
    if to_x.min(to_y) >= outer {
        End::Arc(outer)
    } else if to_x < to_y {
        End::X(x)
    } else {
        End::Y(y)
    }
}

impl End {
    /// The interval of angles as an interval of length along the end; `None` where the rays have none.
    pub(super) fn range(self, start: f64, end: f64) -> Option<(f64, f64)> {
        match self {
            End::Arc(radius) => Some((start * radius, end * radius)),
            End::X(c) | End::Y(c) if c == 0.0 => None,
            End::X(c) => Some((c * start.tan(), c * end.tan())),
            End::Y(c) => Some((c / start.tan(), c / end.tan())),
        }
    }

    /// Direction and length of the ray to the place `s` on the end, and the derivative of its angle.
    pub(super) fn ray(self, s: f64) -> ([f64; 2], f64, f64) {
        let (x, y) = match self {
            End::Arc(radius) => {
                let (sin, cos) = (s / radius).sin_cos();
                return ([cos, sin], radius, 1.0 / radius);
            }
            End::X(c) => (c, s),
            End::Y(c) => (s, c),
        };
        let length = x.hypot(y);
        let derivative = if matches!(self, End::X(_)) { x } else { y } / (length * length);
        ([x / length, y / length], length, derivative)
    }
}

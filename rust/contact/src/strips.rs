// SPDX-License-Identifier: MIT OR Apache-2.0
//! The strips of a patch along the rolling direction: where each cell lies in its own.

/// A grid of cells and a direction across it.
#[derive(Clone, Copy)]
pub(crate) struct Strips<'a> {
    /// Cells along x and y.
    pub shape: [usize; 2],
    /// Cell sizes [m].
    pub cell: [f64; 2],
    /// Centre of the first cell [m].
    pub origin: [f64; 2],
    /// The traction bound, positive in the contact.
    pub bound: &'a [f64],
    /// Cosine and sine of the rolling direction.
    pub direction: [f64; 2],
}

/// A place on a strip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// The cell that it lies in.
    pub cell: usize,
    /// Along the rolling direction and to its left [m].
    pub at: [f64; 2],
    /// The bound there.
    pub bound: f64,
}

/// The strip of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent {
    /// Half of its length [m].
    pub half: f64,
    /// The cell over its middle, towards the leading edge [m].
    pub ahead: f64,
}

impl Strips<'_> {
    /// The direction of the angle `angle` [rad], exact along the axes.
    pub(crate) fn direction_of(angle: f64) -> [f64; 2] {
        let quarters = angle / std::f64::consts::FRAC_PI_2;
        let nearest = quarters.round();
        if (quarters - nearest).abs() > 1e-12 {
            return [angle.cos(), angle.sin()];
        }
        match nearest.rem_euclid(4.0) as usize {
            0 => [1.0, 0.0],
            1 => [0.0, 1.0],
            2 => [-1.0, 0.0],
            _ => [0.0, -1.0],
        }
    }

    /// Distance from one place to the next [m], and it in cells along x and y.
    pub(crate) fn step(&self) -> (f64, [f64; 2]) {
        let [c, s] = self.direction;
        let length = self.cell[0] * c * c + self.cell[1] * s * s;
        (
            length,
            [length * c / self.cell[0], length * s / self.cell[1]],
        )
    }

    /// The vector (x, y) along the rolling direction and to its left.
    pub(crate) fn turned(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [c, s] = self.direction;
        [c * x + s * y, c * y - s * x]
    }

    /// The vector along the rolling direction and to its left as (x, y).
    pub(crate) fn back(&self, [along, left]: [f64; 2]) -> [f64; 2] {
        let [c, s] = self.direction;
        [c * along - s * left, s * along + c * left]
    }

    /// The place `steps` steps ahead of the cell `[i, j]`, where that is in the contact.
    fn place(&self, [i, j]: [usize; 2], steps: f64) -> Option<Place> {
        let (_, step) = self.step();
        let (u, v) = (i as f64 + steps * step[0], j as f64 + steps * step[1]);
        let cell = self.inside(u.round(), v.round())?;
        if self.bound[cell] <= 0.0 {
            return None;
        }
        let x = self.origin[0] + u * self.cell[0];
        let y = self.origin[1] + v * self.cell[1];
        Some(Place {
            cell,
            at: self.turned([x, y]),
            bound: self.bound_at(u, v),
        })
    }

    /// Centre of a cell, along the rolling direction and to its left [m].
    pub(crate) fn centre(&self, cell: usize) -> [f64; 2] {
        let [nx, _] = self.shape;
        let x = self.origin[0] + (cell % nx) as f64 * self.cell[0];
        let y = self.origin[1] + (cell / nx) as f64 * self.cell[1];
        self.turned([x, y])
    }

    fn inside(&self, u: f64, v: f64) -> Option<usize> {
        let [nx, ny] = self.shape;
        let within = u >= 0.0 && v >= 0.0 && u < nx as f64 && v < ny as f64;
        within.then(|| v as usize * nx + u as usize)
    }

    /// The bound between cells: its square, which is smooth in Hertz' contact, is interpolated.
    fn bound_at(&self, u: f64, v: f64) -> f64 {
        let near = |w: f64| {
            let nearest = w.round();
            if (w - nearest).abs() < 1e-9 {
                nearest
            } else {
                w
            }
        };
        let (u, v) = (near(u), near(v));
        let (i, j) = (u.floor(), v.floor());
        let (s, t) = (u - i, v - j);
        if s == 0.0 && t == 0.0 {
            return self.inside(i, j).map_or(0.0, |k| self.bound[k]);
        }
        let corners = [
            (i, j, (1.0 - s) * (1.0 - t)),
            (i + 1.0, j, s * (1.0 - t)),
            (i, j + 1.0, (1.0 - s) * t),
            (i + 1.0, j + 1.0, s * t),
        ];
        let square: f64 = corners
            .into_iter()
            .filter_map(|(u, v, weight)| self.inside(u, v).map(|k| weight * self.bound[k].powi(2)))
            .sum();
        square.sqrt()
    }

    /// The places of the strip from its leading edge down to the cell `[i, j]`, which is the last.
    pub(crate) fn down_to(&self, cell: [usize; 2], places: &mut Vec<Place>) {
        places.clear();
        for steps in 0.. {
            match self.place(cell, f64::from(steps)) {
                Some(place) => places.push(place),
                None => break,
            }
        }
        places.reverse();
    }

    /// The strip of each cell of the contact, and the mean of `coefficient` over it.
    pub(crate) fn extents(&self, coefficient: &[f64]) -> Vec<Option<(Extent, f64)>> {
        let [nx, ny] = self.shape;
        let mut found = vec![None; nx * ny];
        if self.direction == [1.0, 0.0] {
            // all cells of a run share it
            for (row, out) in found.chunks_mut(nx).enumerate() {
                let mut i = 0;
                while i < nx {
                    let first = row * nx;
                    let end = (i..nx).find(|k| self.bound[first + k] <= 0.0).unwrap_or(nx);
                    let count = end - i;
                    if count > 0 {
                        let half = 0.5 * count as f64 * self.cell[0];
                        let mean =
                            coefficient[first + i..first + end].iter().sum::<f64>() / count as f64;
                        for (k, own) in out[i..end].iter_mut().enumerate() {
                            let ahead = (k as f64 + 0.5) * self.cell[0] - half;
                            *own = Some((Extent { half, ahead }, mean));
                        }
                    }
                    i = end + 1;
                }
            }
            return found;
        }
        let (length, _) = self.step();
        for (k, own) in found.iter_mut().enumerate() {
            let cell = [k % nx, k / nx];
            let Some(here) = self.place(cell, 0.0) else {
                continue;
            };
            let mut sum = coefficient[here.cell];
            let mut count = [0_u32; 2];
            for (side, sign) in [(0, 1.0), (1, -1.0)] {
                while let Some(place) = self.place(cell, sign * f64::from(count[side] + 1)) {
                    sum += coefficient[place.cell];
                    count[side] += 1;
                }
            }
            let [up, down] = count.map(f64::from);
            let all = up + down + 1.0;
            let extent = Extent {
                half: 0.5 * all * length,
                ahead: 0.5 * (down - up) * length,
            };
            *own = Some((extent, sum / all));
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_grid_has_turned_strips() {
        // a wedge, whose rows and columns differ
        let bound = [1.0, 2.0, 3.0, 0.0, 4.0, 5.0];
        let strips = |shape, bound, angle| Strips {
            shape,
            cell: [1.0, 1.0],
            origin: [0.0, 0.0],
            bound,
            direction: Strips::direction_of(angle),
        };
        let along_x = strips([3, 2], &bound, 0.0);
        // the same turned by a quarter: x' = -y, y' = x
        let turned = [0.0, 1.0, 4.0, 2.0, 5.0, 3.0];
        let along_y = strips([2, 3], &turned, std::f64::consts::FRAC_PI_2);
        let (of_x, of_y) = (along_x.extents(&[1.0; 6]), along_y.extents(&[1.0; 6]));
        for i in 0..3 {
            for j in 0..2 {
                assert_eq!(of_x[j * 3 + i], of_y[i * 2 + (1 - j)], "{i} {j}");
            }
        }
        let mut places = Vec::new();
        along_y.down_to([1, 0], &mut places);
        let bounds: Vec<f64> = places.iter().map(|p| p.bound).collect();
        assert_eq!(bounds, [3.0, 2.0, 1.0]);
    }
}

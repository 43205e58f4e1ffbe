// SPDX-License-Identifier: MIT OR Apache-2.0
use crate::error::{Error, check};

/// Share of its length that a sliding velocity must have in the tangent plane.
const FLATTEST: f64 = 1e-6;

/// Contact points in the common frame: three components (3n) each, x of all points first.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// Positions [m] at which the loads of the points act.
    pub points: Vec<f64>,
    /// Unit normals of the lower body, pointing to the upper one.
    pub normal: Vec<f64>,
    /// Unit tangents along x.
    pub tangent_x: Vec<f64>,
    /// Unit tangents across, normal x `tangent_x`.
    pub tangent_y: Vec<f64>,
    /// Area of each point (n) [m2].
    pub area: Vec<f64>,
    /// Means of `tangent_x`, `tangent_y` and `normal` over the area of each point: what resultants and poses
    /// see. The same as these for small cells.
    pub mean_frame: [Vec<f64>; 3],
    /// What turns the unknowns into mean tractions, where they are not these themselves.
    pub means: Option<Means>,
    /// Grids of points that end where the bodies do not. None where all bodies end with their points.
    pub windows: Vec<Window>,
}

/// A regular grid of points beyond which the bodies go on, so that no pressure may reach its edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Its first point; the others follow, those of a row one after the other.
    pub start: usize,
    /// Points in a row.
    pub nx: usize,
    /// Rows.
    pub ny: usize,
}

/// Shares of basis functions in the area of each point, row by row; the rows add up to one.
#[derive(Clone, Debug, PartialEq)]
pub struct Means {
    /// First entry of each row, and one past the last (n + 1).
    pub start: Vec<usize>,
    /// Basis function of each entry.
    pub column: Vec<usize>,
    /// Its share.
    pub share: Vec<f64>,
}

impl Geometry {
    /// Number of points.
    pub fn points(&self) -> usize {
        self.area.len()
    }

    /// Checks that all parts belong together.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite.
    pub fn check(&self) -> Result<(), Error> {
        let n = self.points();
        check("area", &self.area, n)?;
        for (name, field) in [
            ("points", &self.points),
            ("normal", &self.normal),
            ("tangent_x", &self.tangent_x),
            ("tangent_y", &self.tangent_y),
            ("mean_frame", &self.mean_frame[0]),
            ("mean_frame", &self.mean_frame[1]),
            ("mean_frame", &self.mean_frame[2]),
        ] {
            check(name, field, 3 * n)?;
        }
        if self.windows.iter().any(|window| !window.is_within(n)) {
            return Err(Error::Stored("a grid has more points than there are"));
        }
        self.means.as_ref().map_or(Ok(()), |means| means.check(n))
    }

    /// Refuses pressures (n) that the edge of a grid cuts off.
    ///
    /// # Errors
    /// [`Error::Edge`].
    pub fn check_edge(&self, pressure: &[f64]) -> Result<(), Error> {
        for window in &self.windows {
            if let Some(point) = window.edge().find(|&point| pressure[point] > 0.0) {
                let [x, y, _] = Self::vector(&self.points, point);
                return Err(Error::Edge {
                    nx: window.nx,
                    ny: window.ny,
                    place: [x, y],
                });
            }
        }
        Ok(())
    }

    /// Vector of a point in a field (3n).
    pub(crate) fn vector(field: &[f64], point: usize) -> [f64; 3] {
        let n = field.len() / 3;
        [0, 1, 2].map(|c| field[c * n + point])
    }

    /// Tangents of sliding: unit vectors (2n) in the tangent plane of each point along the velocity `along`
    /// (x, y) of the upper body over the lower one; zeros where nothing slides.
    ///
    /// # Errors
    /// [`Error::Normal`] where the velocity is normal to the surface.
    pub fn sliding_direction(&self, along: [f64; 2]) -> Result<Vec<f64>, Error> {
        let n = self.points();
        let speed = along[0].hypot(along[1]);
        let mut direction = vec![0.0; 2 * n];
        if speed == 0.0 {
            return Ok(direction);
        }
        for i in 0..n {
            let [x, y] = [&self.tangent_x, &self.tangent_y].map(|field| {
                let t = Self::vector(field, i);
                along[0] * t[0] + along[1] * t[1]
            });
            let length = x.hypot(y);
            if length < FLATTEST * speed {
                return Err(Error::Normal { index: i });
            }
            direction[i] = x / length;
            direction[n + i] = y / length;
        }
        Ok(direction)
    }

    /// Mean tractions over each point from the unknowns of a solution, the pressures (n) last: `traction`
    /// (c n) [Pa] holds any number of components.
    ///
    /// Under overlapping basis functions the unknowns swing about a steep pressure; their means do not. What
    /// a point in contact would give to an open one it keeps, so the force stays and open points carry nothing.
    pub fn mean_tractions(&self, traction: &[f64]) -> Vec<f64> {
        let Some(means) = &self.means else {
            return traction.to_vec();
        };
        let n = self.points();
        let pressure = &traction[traction.len() - n..];
        let mut out = vec![0.0; traction.len()];
        for (out, values) in out.chunks_exact_mut(n).zip(traction.chunks_exact(n)) {
            for i in 0..n {
                for k in means.start[i]..means.start[i + 1] {
                    let j = means.column[k];
                    let part = means.share[k] * values[j];
                    if pressure[i] > 0.0 {
                        out[i] += part;
                    } else {
                        out[j] += part * self.area[i] / self.area[j];
                    }
                }
            }
        }
        out
    }

    /// Weights (n) of the unknown pressures that sum up to that of the mean pressures with `weights` (n), about the
    /// unknown `pressure` (n).
    pub fn weights_of_means(&self, weights: &[f64], pressure: &[f64]) -> Vec<f64> {
        let Some(means) = &self.means else {
            return weights.to_vec();
        };
        let n = self.points();
        let mut out = vec![0.0; n];
        for i in 0..n {
            for k in means.start[i]..means.start[i + 1] {
                let j = means.column[k];
                out[j] += means.share[k]
                    * if pressure[i] > 0.0 {
                        weights[i]
                    } else {
                        weights[j] * self.area[i] / self.area[j]
                    };
            }
        }
        out
    }

    /// Weights (3n) of the tractions along both tangents and of the pressures [Pa] that sum up to each component of
    /// the force [N] on the lower body, then of its moment [N m] about the point `about`.
    pub fn weights_of_resultants(&self, about: [f64; 3]) -> [Vec<f64>; 6] {
        let n = self.points();
        let mut weights: [Vec<f64>; 6] = std::array::from_fn(|_| vec![0.0; 3 * n]);
        for i in 0..n {
            let at = Self::vector(&self.points, i);
            let arm: [f64; 3] = std::array::from_fn(|c| at[c] - about[c]);
            for axis in 0..3 {
                let mut unit = [0.0; 3];
                unit[axis] = 1.0;
                let load = self.load(i, unit);
                for c in 0..3 {
                    let (a, b) = ((c + 1) % 3, (c + 2) % 3);
                    weights[c][axis * n + i] = load[c];
                    weights[3 + c][axis * n + i] = arm[a] * load[b] - arm[b] * load[a];
                }
            }
        }
        weights
    }

    /// Load [N] of a point on the lower body from its tractions along both tangents and its pressure [Pa].
    fn load(&self, point: usize, [qx, qy, p]: [f64; 3]) -> [f64; 3] {
        let [tx, ty, normal] = [0, 1, 2].map(|axis| Self::vector(&self.mean_frame[axis], point));
        std::array::from_fn(|c| self.area[point] * (qx * tx[c] + qy * ty[c] - p * normal[c]))
    }

    /// Loads (3n) [N] of the points on the lower body from the unknowns (3n) [Pa].
    pub fn loads(&self, traction: &[f64]) -> Vec<f64> {
        let n = self.points();
        let mut loads = vec![0.0; 3 * n];
        for i in 0..n {
            let load = self.load(i, Self::vector(traction, i));
            for (c, part) in load.into_iter().enumerate() {
                loads[c * n + i] = part;
            }
        }
        loads
    }

    /// Force [N] on the lower body and its moment [N m] about the point `about` from the tractions along both
    /// tangents (2n) and the pressures (n) [Pa].
    pub fn resultants(
        &self,
        traction: &[f64],
        pressure: &[f64],
        about: [f64; 3],
    ) -> ([f64; 3], [f64; 3]) {
        let n = self.points();
        let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
        for i in 0..n {
            if pressure[i] == 0.0 {
                continue;
            }
            let load = self.load(i, [traction[i], traction[n + i], pressure[i]]);
            let at = Self::vector(&self.points, i);
            let arm: [f64; 3] = std::array::from_fn(|c| at[c] - about[c]);
            for c in 0..3 {
                let (a, b) = ((c + 1) % 3, (c + 2) % 3);
                force[c] += load[c];
                moment[c] += arm[a] * load[b] - arm[b] * load[a];
            }
        }
        (force, moment)
    }
}

impl Window {
    fn is_within(&self, points: usize) -> bool {
        let end = (self.nx.checked_mul(self.ny)).and_then(|size| size.checked_add(self.start));
        end.is_some_and(|end| end <= points)
    }

    /// Its points at the edge.
    fn edge(&self) -> impl Iterator<Item = usize> + '_ {
        let Self { start, nx, ny } = *self;
        (0..nx * ny)
            .filter(move |k| {
                let (i, j) = (k % nx, k / nx);
                i == 0 || j == 0 || i + 1 == nx || j + 1 == ny
            })
            .map(move |k| start + k)
    }
}

impl Means {
    fn check(&self, n: usize) -> Result<(), Error> {
        check("share", &self.share, self.column.len())?;
        let rising = self.start.is_sorted() && self.start.first() == Some(&0);
        if self.start.len() != n + 1 || !rising || self.start[n] != self.column.len() {
            return Err(Error::Stored("its means have no such rows"));
        }
        if self.column.iter().any(|c| *c >= n) {
            return Err(Error::Stored("its means name points that are none"));
        }
        Ok(())
    }
}

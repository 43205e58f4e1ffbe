// SPDX-License-Identifier: MIT OR Apache-2.0
//! The thesis' basis: normalised truncated Gaussians on scattered points.

mod bins;
mod moments;
mod rays;

use mtb_operator::{Monitor, check_dense, report};
use rayon::prelude::*;

use super::integrals::SurfaceIntegrals;
use super::quadrature::GAUSS_6;
use crate::Error;
use bins::Bins;
use moments::Moments;
use rays::ray_end;

/// Where the Gaussians end, in standard deviations: what is cut off is below 2e-8 of the peak.
const TRUNCATION: f64 = 6.0;
/// Distances, in radii of the support, from which a source is near, or far.
const NEAR: f64 = 1.1;
const FAR: f64 = 3.0;
/// Rows of the matrices between two looks at the monitor.
const ROWS: usize = 32;

/// Normalised truncated Gaussians on scattered points of a plane [Steininger2025, eq. 2.5]:
/// `phi_j(x) = w(|x - y_j|) / sum_k w(|x - y_k|)`, `w(r) = exp(-r^2 / (2 s^2))` for `r < 6 s`, on a
/// rectangle outside which nothing is loaded.
///
/// For comparison with the thesis: on a regular grid of spacing `h` and `s` below about 0.35 h they
/// are rectangles in disguise, wider ones are worse and ill-conditioned.
#[derive(Clone, Debug)]
pub struct GaussianBasis {
    x: Vec<f64>,
    y: Vec<f64>,
    standard_deviation: f64,
    domain: [f64; 4],
    bins: Bins,
    /// Length of the panels of the quadrature: a few widths of the steps between two functions.
    panel: f64,
}

impl GaussianBasis {
    /// Basis functions of `standard_deviation` [m] about the points `(x, y)` [m], cut at the
    /// rectangle `domain` = `[x_min, x_max, y_min, y_max]` [m].
    ///
    /// # Errors
    /// [`Error::Shape`] when `x` and `y` differ in length or are empty, [`Error::NotFinite`] and
    /// [`Error::NotPositive`] for impossible numbers, [`Error::Uncovered`] where the functions leave
    /// a hole in the domain.
    pub fn new(
        x: &[f64],
        y: &[f64],
        standard_deviation: f64,
        domain: [f64; 4],
    ) -> Result<Self, Error> {
        if x.is_empty() || x.len() != y.len() {
            return Err(Error::Shape {
                name: "y",
                expected: x.len().max(1),
                found: y.len(),
            });
        }
        for (name, values) in [("x", x), ("y", y), ("domain", &domain[..])] {
            if let Some(index) = values.iter().position(|v| !v.is_finite()) {
                return Err(Error::NotFinite { name, index });
            }
        }
        for (name, value) in [
            ("standard deviation", standard_deviation),
            ("domain length in x", domain[1] - domain[0]),
            ("domain length in y", domain[3] - domain[2]),
        ] {
            if value.is_nan() || value <= 0.0 || value.is_infinite() {
                return Err(Error::NotPositive { name, value });
            }
        }
        let [x0, x1, y0, y1] = domain;
        for index in 0..x.len() {
            let (x, y) = (x[index], y[index]);
            if x < x0 || x > x1 || y < y0 || y > y1 {
                return Err(Error::Outside { index, x, y });
            }
        }
        let spacing = ((domain[1] - domain[0]) * (domain[3] - domain[2]) / x.len() as f64).sqrt();
        let step = standard_deviation * standard_deviation / spacing;
        let basis = Self {
            x: x.to_vec(),
            y: y.to_vec(),
            standard_deviation,
            domain,
            bins: Bins::new(x, y, TRUNCATION * standard_deviation),
            panel: (6.0 * step).min(1.2 * standard_deviation),
        };
        basis.check_coverage(spacing)?;
        Ok(basis)
    }

    /// Number of basis functions.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there is no basis function; never true.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Values of all basis functions that do not vanish at `(x, y)`, with their indices; they add
    /// up to one. Empty outside the domain and in holes.
    pub fn values(&self, x: f64, y: f64, values: &mut Vec<(usize, f64)>) {
        values.clear();
        let [x0, x1, y0, y1] = self.domain;
        if x < x0 || x > x1 || y < y0 || y > y1 {
            return;
        }
        let reach = TRUNCATION * self.standard_deviation;
        let factor = -0.5 / (self.standard_deviation * self.standard_deviation);
        let mut sum = 0.0;
        for &j in self.bins.about(x, y) {
            let (dx, dy) = (x - self.x[j], y - self.y[j]);
            let r2 = dx * dx + dy * dy;
            if r2 < reach * reach {
                let w = (factor * r2).exp();
                sum += w;
                values.push((j, w));
            }
        }
        for (_, w) in values.iter_mut() {
            *w /= sum;
        }
    }

    fn check_coverage(&self, spacing: f64) -> Result<(), Error> {
        let [x0, x1, y0, y1] = self.domain;
        let step = 0.25 * spacing;
        let (nx, ny) = (
            ((x1 - x0) / step).ceil() as usize,
            ((y1 - y0) / step).ceil() as usize,
        );
        let mut values = Vec::new();
        for iy in 0..=ny {
            let y = y0 + (y1 - y0) * iy as f64 / ny as f64;
            for ix in 0..=nx {
                let x = x0 + (x1 - x0) * ix as f64 / nx as f64;
                self.values(x, y, &mut values);
                if values.is_empty() {
                    return Err(Error::Uncovered { x, y });
                }
            }
        }
        Ok(())
    }

    /// Surface integrals of the five kernels over every basis function, seen from every point, and
    /// the integral of every basis function itself [m2].
    ///
    /// Near sources are integrated in polar coordinates about the observed point, where the area
    /// element cancels the singularity; farther ones as the kernel's interpolant on the support.
    /// Relative accuracy 1e-5 or better.
    ///
    /// # Errors
    /// [`Error::Interrupted`] when the monitor asks for it.
    pub fn integrals(&self, monitor: Monitor<'_>) -> Result<(SurfaceIntegrals, Vec<f64>), Error> {
        let n = self.len();
        check_dense(n, 5)?;
        let moments = self.moments();
        let mut integrals = SurfaceIntegrals {
            points: n,
            inverse: vec![0.0; n * n],
            xx: vec![0.0; n * n],
            xy: vec![0.0; n * n],
            x: vec![0.0; n * n],
            y: vec![0.0; n * n],
        };
        let SurfaceIntegrals {
            inverse,
            xx,
            xy,
            x,
            y,
            ..
        } = &mut integrals;
        let size = ROWS * n;
        for (chunk, ((((inverse, xx), xy), x), y)) in inverse
            .chunks_mut(size)
            .zip(xx.chunks_mut(size))
            .zip(xy.chunks_mut(size))
            .zip(x.chunks_mut(size))
            .zip(y.chunks_mut(size))
            .enumerate()
        {
            report(monitor, chunk, 1.0)?;
            let rows: Vec<Vec<[f64; 5]>> = (0..inverse.len() / n)
                .into_par_iter()
                .map(|row| self.row(chunk * ROWS + row, &moments))
                .collect();
            for (k, value) in rows.iter().flatten().enumerate() {
                inverse[k] = value[0];
                xx[k] = value[1];
                xy[k] = value[2];
                x[k] = value[3];
                y[k] = value[4];
            }
        }
        Ok((integrals, moments.total))
    }

    /// One row: all sources seen from point `i`.
    fn row(&self, i: usize, moments: &Moments) -> Vec<[f64; 5]> {
        let reach = TRUNCATION * self.standard_deviation;
        let (xi, yi) = (self.x[i], self.y[i]);
        let mut row = vec![[0.0; 5]; self.len()];
        let mut near = vec![false; self.len()];
        let mut outer = reach;
        for j in 0..self.len() {
            let distance = (xi - self.x[j]).hypot(yi - self.y[j]);
            if distance < NEAR * reach {
                near[j] = true;
                outer = outer.max(distance + reach);
            } else if distance < FAR * reach {
                row[j] = moments.mid.seen_from(xi - self.x[j], yi - self.y[j], j);
            } else {
                row[j] = moments.far.seen_from(xi - self.x[j], yi - self.y[j], j);
            }
        }
        self.add_near(i, &near, outer, &mut row);
        row
    }

    /// Polar quadrature about point `i` over the supports of the sources marked `near`, none of
    /// which reaches farther than `outer`.
    ///
    /// With `x = y_i + rho (cos t, sin t)` all five kernels times the area element are free of
    /// `rho`, so each ray needs only the integral of the basis functions along it.
    fn add_near(&self, i: usize, near: &[bool], outer: f64, row: &mut [[f64; 5]]) {
        let [x0, x1, y0, y1] = self.domain;
        let (xi, yi) = (self.x[i], self.y[i]);
        // the rays must be smooth functions of the angle between the corners of the domain, and
        // between the places where its sides leave the disc
        let mut angles = vec![0.0, std::f64::consts::TAU];
        let mut push =
            |dx: f64, dy: f64| angles.push(dy.atan2(dx).rem_euclid(std::f64::consts::TAU));
        for (cx, cy) in [(x0, y0), (x1, y0), (x0, y1), (x1, y1)] {
            push(cx - xi, cy - yi);
        }
        for side in [x0 - xi, x1 - xi] {
            if side.abs() < outer {
                let chord = (outer * outer - side * side).sqrt();
                push(side, chord);
                push(side, -chord);
            }
        }
        for side in [y0 - yi, y1 - yi] {
            if side.abs() < outer {
                let chord = (outer * outer - side * side).sqrt();
                push(chord, side);
                push(-chord, side);
            }
        }
        angles.sort_by(f64::total_cmp);
        let sides = [x0 - xi, x1 - xi, y0 - yi, y1 - yi];
        let mut values = Vec::new();
        let mut line = vec![0.0; row.len()];
        let mut touched: Vec<usize> = Vec::new();
        for pair in angles.windows(2) {
            let width = pair[1] - pair[0];
            if width < 1e-12 {
                continue;
            }
            let middle = pair[0] + 0.5 * width;
            let side = ray_end(sides, middle.cos(), middle.sin(), outer);
            let Some((start, end)) = side.range(pair[0], pair[1]) else {
                continue;
            };
            let panels = ((end - start).abs() / self.panel).ceil().max(1.0);
            let half = 0.5 * (end - start) / panels;
            for panel in 0..panels as usize {
                let centre = start + (2 * panel + 1) as f64 * half;
                for (node, weight) in GAUSS_6 {
                    let ([cos, sin], length, derivative) = side.ray(centre + half * node);
                    let pieces = (length / self.panel).ceil();
                    let step = 0.5 * length / pieces;
                    for piece in 0..pieces as usize {
                        let middle = (2 * piece + 1) as f64 * step;
                        for (s, w) in GAUSS_6 {
                            let rho = middle + step * s;
                            self.values(xi + rho * cos, yi + rho * sin, &mut values);
                            for &(j, value) in &values {
                                if near[j] {
                                    if line[j] == 0.0 {
                                        touched.push(j);
                                    }
                                    line[j] += w * step * value;
                                }
                            }
                        }
                    }
                    let weight = weight * (half * derivative).abs();
                    for j in touched.drain(..) {
                        let g = weight * std::mem::take(&mut line[j]);
                        let sum = &mut row[j];
                        sum[0] += g;
                        sum[1] += g * cos * cos;
                        sum[2] += g * cos * sin;
                        sum[3] -= g * cos;
                        sum[4] -= g * sin;
                    }
                }
            }
        }
    }

    /// Moments of all basis functions against the interpolation polynomials on their supports.
    fn moments(&self) -> Moments {
        let [x0, x1, y0, y1] = self.domain;
        let n = self.len();
        let reach = TRUNCATION * self.standard_deviation;
        let mut moments = Moments::new(n, reach);
        let panels = |length: f64| (length / self.panel).ceil() as usize;
        let (px, py) = (panels(x1 - x0), panels(y1 - y0));
        let (hx, hy) = (0.5 * (x1 - x0) / px as f64, 0.5 * (y1 - y0) / py as f64);
        let mut values = Vec::new();
        for iy in 0..py {
            for (sy, wy) in GAUSS_6 {
                let y = y0 + hy * ((2 * iy + 1) as f64 + sy);
                for ix in 0..px {
                    for (sx, wx) in GAUSS_6 {
                        let x = x0 + hx * ((2 * ix + 1) as f64 + sx);
                        self.values(x, y, &mut values);
                        for &(j, value) in &values {
                            let mass = value * wx * hx * wy * hy;
                            moments.add(x - self.x[j], y - self.y[j], j, mass);
                        }
                    }
                }
            }
        }
        moments
    }
}

#[cfg(test)]
mod tests;

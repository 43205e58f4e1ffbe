// SPDX-License-Identifier: MIT OR Apache-2.0
use std::collections::BTreeMap;

use nalgebra::Vector3;
use rayon::prelude::*;

use super::locate::{FaceFinder, FaceView, Hit};
use super::mesh::{Order, TetraMesh};
use crate::{Error, Lines};

/// A quadrature point on the surface of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Boundary triangle of the mesh.
    pub face: usize,
    /// Barycentric coordinates on it.
    pub barycentric: [f64; 3],
    /// Area it stands for [m2].
    pub weight: f64,
    /// Unit vectors tangential 1, tangential 2, into the body.
    pub frame: [[f64; 3]; 3],
}

/// Traction basis of a contact, known at quadrature points of the body's surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Sampling {
    n_points: usize,
    quadrature: Vec<SurfacePoint>,
    /// `basis[start[q]..start[q + 1]]`: contact points and the values of their basis functions at `q`.
    start: Vec<usize>,
    basis: Vec<(usize, f64)>,
}

/// What the basis functions of a [`Sampling`] see of the surface, in the mean over each contact point.
#[derive(Clone, Debug, PartialEq)]
pub struct Averages {
    /// Means of tangential 1, tangential 2 and into the body (n): on a curved surface a little shorter than one.
    pub frames: Vec<[[f64; 3]; 3]>,
    /// Mean places on the surface (n) [m]: where a basis function at its edge presses is not its contact point.
    pub places: Vec<[f64; 3]>,
    /// Of each point (n): the share of the basis functions of the points there in its area, by their numbers;
    /// the shares add up to one where those functions do.
    pub shares: Vec<BTreeMap<usize, f64>>,
}

impl Sampling {
    /// Sampling of `n_points` basis functions; `start` (quadrature points + 1) delimits the part of
    /// `basis` that belongs to each quadrature point.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::Index`], [`Error::NotFinite`], [`Error::Frame`] on malformed input.
    pub fn new(
        n_points: usize,
        quadrature: Vec<SurfacePoint>,
        start: Vec<usize>,
        basis: Vec<(usize, f64)>,
    ) -> Result<Self, Error> {
        if start.len() != quadrature.len() + 1 {
            return Err(Error::Shape {
                name: "basis_start",
                found: start.len(),
                expected: quadrature.len() + 1,
            });
        }
        let end = start.last().copied().unwrap_or(0);
        if start[0] != 0 || end != basis.len() || start.windows(2).any(|w| w[0] > w[1]) {
            return Err(Error::Shape {
                name: "basis",
                found: basis.len(),
                expected: end,
            });
        }
        for (index, q) in quadrature.iter().enumerate() {
            let finite = q.barycentric.iter().chain(q.frame.iter().flatten());
            if !q.weight.is_finite() || finite.into_iter().any(|v| !v.is_finite()) {
                return Err(Error::NotFinite {
                    name: "quadrature point",
                    index,
                });
            }
            if !is_orthonormal(&q.frame) {
                return Err(Error::Frame(index));
            }
        }
        for (index, &(point, value)) in basis.iter().enumerate() {
            if point >= n_points {
                return Err(Error::Index {
                    name: "basis entry",
                    index,
                    what: "contact point",
                    value: point,
                    count: n_points,
                });
            }
            if !value.is_finite() {
                return Err(Error::NotFinite {
                    name: "basis entry",
                    index,
                });
            }
        }
        Ok(Sampling {
            n_points,
            quadrature,
            start,
            basis,
        })
    }

    /// Samplings of several grids on one face, their contact points one after the other.
    pub fn joined(parts: &[Sampling]) -> Self {
        let mut whole = Self {
            n_points: 0,
            quadrature: Vec::new(),
            start: vec![0],
            basis: Vec::new(),
        };
        for part in parts {
            let (first, entries) = (whole.n_points, whole.basis.len());
            whole.quadrature.extend_from_slice(&part.quadrature);
            let moved = part
                .basis
                .iter()
                .map(|&(point, value)| (first + point, value));
            whole.basis.extend(moved);
            whole
                .start
                .extend(part.start[1..].iter().map(|s| entries + s));
            whole.n_points += part.n_points;
        }
        whole
    }

    /// The hats between `lines` along x and y of the grids whose hats these are, one grid after the other.
    ///
    /// # Errors
    /// [`Error::Shape`] for lines of other grids.
    pub fn on_lines(&self, lines: &[[Lines; 2]]) -> Result<Self, Error> {
        // of each point: grid, and the number in it
        let mut place = Vec::with_capacity(self.n_points);
        let mut n_points = 0;
        let mut first = Vec::with_capacity(lines.len());
        for (grid, [x, y]) in lines.iter().enumerate() {
            first.push(n_points);
            n_points += x.len() * y.len();
            place.extend((0..x.nodes() * y.nodes()).map(|k| (grid, k)));
        }
        if place.len() != self.n_points {
            return Err(Error::Shape {
                name: "lines of the grids of all contact points",
                found: place.len(),
                expected: self.n_points,
            });
        }
        let mut start = vec![0];
        let mut basis: Vec<(usize, f64)> = Vec::with_capacity(self.basis.len());
        for q in 0..self.quadrature.len() {
            let begun = basis.len();
            for &(point, phi) in self.basis(q) {
                let (grid, k) = place[point];
                let [x, y] = &lines[grid];
                for (j, b) in y.at(k / x.nodes()) {
                    for (i, a) in x.at(k % x.nodes()) {
                        let own = first[grid] + j * x.len() + i;
                        let value = a * b * phi;
                        match basis[begun..].iter_mut().find(|(other, _)| *other == own) {
                            Some((_, sum)) => *sum += value,
                            None => basis.push((own, value)),
                        }
                    }
                }
            }
            start.push(basis.len());
        }
        Ok(Self {
            n_points,
            quadrature: self.quadrature.clone(),
            start,
            basis,
        })
    }

    /// Number of contact points.
    pub fn n_points(&self) -> usize {
        self.n_points
    }

    /// The quadrature points.
    pub fn quadrature(&self) -> &[SurfacePoint] {
        &self.quadrature
    }

    /// Contact points and basis values at quadrature point `q`.
    pub fn basis(&self, q: usize) -> &[(usize, f64)] {
        &self.basis[self.start[q]..self.start[q + 1]]
    }

    /// Start of each quadrature point's part of the basis, one more than there are points.
    pub fn start(&self) -> &[usize] {
        &self.start
    }

    /// Area of each contact point, the integral of its basis function [m2].
    pub fn weights(&self) -> Vec<f64> {
        let mut weights = vec![0.0; self.n_points];
        for (q, point) in self.quadrature.iter().enumerate() {
            for &(i, phi) in self.basis(q) {
                weights[i] += point.weight * phi;
            }
        }
        weights
    }

    /// Means over each contact point, on the body of `mesh`.
    ///
    /// # Errors
    /// [`Error::NotOnBoundary`] on a mesh of other faces.
    pub fn averages(&self, mesh: &TetraMesh) -> Result<Averages, Error> {
        let n = self.n_points;
        let weights = self.weights();
        let mut means = Averages {
            frames: vec![[[0.0; 3]; 3]; n],
            places: vec![[0.0; 3]; n],
            shares: vec![BTreeMap::new(); n],
        };
        for (q, point) in self.quadrature.iter().enumerate() {
            if point.face >= mesh.n_faces() {
                return Err(Error::NotOnBoundary(point.face));
            }
            let corners = mesh.face(point.face);
            let place: [f64; 3] = std::array::from_fn(|c| {
                let parts = corners.iter().zip(point.barycentric);
                parts.map(|(node, b)| b * mesh.nodes()[*node][c]).sum()
            });
            for &(i, phi) in self.basis(q) {
                let part = point.weight * phi / weights[i];
                for c in 0..3 {
                    means.places[i][c] += part * place[c];
                    for axis in 0..3 {
                        means.frames[i][axis][c] += part * point.frame[axis][c];
                    }
                }
                for &(j, other) in self.basis(q) {
                    *means.shares[i].entry(j).or_insert(0.0) += part * other;
                }
            }
        }
        Ok(means)
    }
}

fn is_orthonormal(frame: &[[f64; 3]; 3]) -> bool {
    (0..3).all(|i| {
        (0..=i).all(|j| {
            let dot: f64 = (0..3).map(|c| frame[i][c] * frame[j][c]).sum();
            (dot - f64::from(u8::from(i == j))).abs() < 1e-6
        })
    })
}

/// A regular grid of contact points on a surface `(x, s)` that is bent over the surface of a body;
/// between the points the traction is bilinear.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactGrid {
    /// Points along x.
    pub nx: usize,
    /// Points along s.
    pub ny: usize,
    /// Spacing along x and s, measured along that surface [m].
    pub spacing: [f64; 2],
    /// Positions, x fastest [m].
    pub points: Vec<[f64; 3]>,
    /// Unit vectors tangential 1, tangential 2, into the body, at each point.
    pub frames: Vec<[[f64; 3]; 3]>,
}

/// Parts of a grid cell in each direction, each with two Gauss points: fine enough for a facet edge
/// or the border of the face to run through a cell.
const PARTS: usize = 3;

/// Distance from the face, in spacings, beyond which a quadrature point is not on it: along the
/// normal, and beside the border.
const REACH: f64 = 0.5;
const BESIDE: f64 = 1e-3;

/// Where a point of a grid lies on a face.
enum Face<'a> {
    /// Behind it, along the normal of a flat grid.
    Behind(FaceView<'a>),
    /// Nearest to it, and not farther beside it than this [m].
    Nearest(FaceFinder<'a>, f64),
}

impl Face<'_> {
    fn at(&self, position: [f64; 3], into: [f64; 3]) -> Option<Hit> {
        match self {
            Face::Behind(view) => view.through(position),
            Face::Nearest(finder, tolerance) => {
                let hit = finder.nearest(position)?;
                let offset = Vector3::from(position) - Vector3::from(hit.position);
                let into = Vector3::from(into);
                let beside = (offset - into * into.dot(&offset)).norm();
                (beside <= *tolerance).then_some(hit)
            }
        }
    }
}

impl ContactGrid {
    /// Quadrature of the grid's cells on the triangles `faces` of a body's boundary; what lies beside
    /// the face is left out.
    ///
    /// A bent grid lies on the face. A flat one may lie at any distance before it: its points are
    /// those of the face behind them, its areas those seen along its normal.
    ///
    /// # Errors
    /// [`Error::Shape`] and those of [`Sampling::new`]; [`Error::NotOnBoundary`] on a face out of range.
    pub fn sampling(&self, mesh: &TetraMesh, faces: &[usize]) -> Result<Sampling, Error> {
        let n = self.nx * self.ny;
        for (name, found) in [("points", self.points.len()), ("frames", self.frames.len())] {
            if found != n {
                return Err(Error::Shape {
                    name,
                    found,
                    expected: n,
                });
            }
        }
        let step = self.spacing[0].max(self.spacing[1]);
        let face = match self.frames.first() {
            Some(&axes) if self.frames.iter().all(|frame| *frame == axes) => {
                Face::Behind(FaceView::new(mesh, faces, axes, step)?)
            }
            _ => Face::Nearest(FaceFinder::new(mesh, faces, REACH * step)?, BESIDE * step),
        };
        let gauss = 0.5 / 3f64.sqrt();
        let places: Vec<f64> = (0..PARTS)
            .flat_map(|k| [0.5 - gauss, 0.5 + gauss].map(|g| (k as f64 + g) / PARTS as f64))
            .collect();
        let weight = self.spacing[0] * self.spacing[1] / (places.len() * places.len()) as f64;
        let (columns, rows) = (self.nx.saturating_sub(1), self.ny.saturating_sub(1));
        let cells: Vec<Vec<_>> = (0..columns * rows)
            .into_par_iter()
            .map(|cell| {
                let corner = cell / columns * self.nx + cell % columns;
                let pairs = places
                    .iter()
                    .flat_map(|b| places.iter().map(move |a| (a, b)));
                let points = pairs.filter_map(|(a, b)| {
                    let basis = [
                        (corner, (1.0 - a) * (1.0 - b)),
                        (corner + 1, a * (1.0 - b)),
                        (corner + self.nx, (1.0 - a) * b),
                        (corner + self.nx + 1, a * b),
                    ];
                    let (position, frame) = self.interpolate(&basis);
                    let hit = face.at(position, frame[2])?;
                    let point = SurfacePoint {
                        face: hit.face,
                        barycentric: hit.barycentric,
                        weight,
                        frame,
                    };
                    Some((point, basis))
                });
                points.collect()
            })
            .collect();
        let (quadrature, basis): (Vec<_>, Vec<_>) = cells.into_iter().flatten().unzip();
        let start = (0..=quadrature.len()).map(|q| 4 * q).collect();
        Sampling::new(n, quadrature, start, basis.into_iter().flatten().collect())
    }

    fn interpolate(&self, basis: &[(usize, f64)]) -> ([f64; 3], [[f64; 3]; 3]) {
        let mut position = Vector3::zeros();
        let mut axes = [Vector3::zeros(); 3];
        for &(i, phi) in basis {
            position += Vector3::from(self.points[i]) * phi;
            for c in 0..3 {
                axes[c] += Vector3::from(self.frames[i][c]) * phi;
            }
        }
        let into = axes[2].normalize();
        let first = (axes[0] - into * into.dot(&axes[0])).normalize();
        let mut second = into.cross(&first);
        if second.dot(&axes[1]) < 0.0 {
            second = -second;
        }
        (position.into(), [first.into(), second.into(), into.into()])
    }
}

/// Values of a face's 3 or 6 shape functions at barycentric coordinates.
pub(super) fn face_shape(l: [f64; 3], order: Order) -> [f64; 6] {
    match order {
        Order::Linear => [l[0], l[1], l[2], 0.0, 0.0, 0.0],
        Order::Quadratic => [
            l[0] * (2.0 * l[0] - 1.0),
            l[1] * (2.0 * l[1] - 1.0),
            l[2] * (2.0 * l[2] - 1.0),
            4.0 * l[0] * l[1],
            4.0 * l[1] * l[2],
            4.0 * l[2] * l[0],
        ],
    }
}

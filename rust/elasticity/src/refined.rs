// SPDX-License-Identifier: MIT OR Apache-2.0
//! A body on a finer grid of contact points than it was condensed onto.
//!
//! At distances that are small against a body it gives way as a half-space does; what is left is smooth. So the
//! compliance on the fine grid is that of a half-space there, and the difference of the body to a half-space is
//! known from hats between some of the lines of this grid: `S = S_h + Q (S_c - P^T S_h P) Q^T`, in the product
//! weighted with the areas. `P` are the coarse hats as sums of fine ones, and `Q` takes a displacement between the lines
//! from the natural cubic spline with the same integrals over the coarse hats, so that `Q^T P = 1`: forces, moments,
//! tractions that are linear between the lines pass unchanged. Near a free edge of the body the difference varies over
//! the distance from it; the lines must be as dense there.

use std::sync::Arc;

use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Scale, Side};
use mtb_operator::{Compliance, Component, Map, SymmetricHalf, check_memory};
use nalgebra::DMatrix;

use crate::half_space::{HatHalfSpace, Neighbours, Patch};
use crate::lines::Lines;
use crate::{Error, Material};

/// Share of the energy of coarse tractions on a half-space that finer ones beside them can take away, at most: 0.15 to
/// 0.3 where distances of the lines change by up to half from one to the next.
const LOST: f64 = 0.3;

/// How fields on hats between some lines of patches are carried to all of their hats.
pub struct Carrier {
    patches: Vec<Carried>,
    points: [usize; 2],
}

/// One patch.
struct Carried {
    coarse: [usize; 2],
    fine: [usize; 2],
    start: [usize; 2],
    /// `Q` along x and along y.
    shares: [DMatrix<f64>; 2],
}

impl Carrier {
    /// From the hats between `lines` along x and y to those between all lines, patch by patch.
    pub fn new(lines: &[[Lines; 2]]) -> Self {
        let mut points = [0, 0];
        let mut patches = Vec::with_capacity(lines.len());
        for along in lines {
            let coarse = [along[0].len(), along[1].len()];
            let fine = [along[0].nodes(), along[1].nodes()];
            patches.push(Carried {
                coarse,
                fine,
                start: points,
                shares: [along[0].shares(), along[1].shares()],
            });
            points = [
                points[0] + coarse[0] * coarse[1],
                points[1] + fine[0] * fine[1],
            ];
        }
        Self { patches, points }
    }

    /// Numbers of coarse and of fine points.
    pub fn points(&self) -> [usize; 2] {
        self.points
    }

    /// `Q v`: integrals over the fine hats of the field whose integrals over the coarse hats are `coarse`. Amounts by
    /// a unit traction of each point are carried alike.
    pub fn carry(&self, coarse: &[f64]) -> Vec<f64> {
        let mut fine = vec![0.0; self.points[1]];
        for p in &self.patches {
            let part = &coarse[p.start[0]..p.start[0] + p.coarse[0] * p.coarse[1]];
            let field = DMatrix::from_column_slice(p.coarse[0], p.coarse[1], part);
            let carried = &p.shares[0] * field * p.shares[1].transpose();
            fine[p.start[1]..p.start[1] + carried.len()].copy_from_slice(carried.as_slice());
        }
        fine
    }

    /// `Q^T t`: the coarse tractions next to fine ones.
    pub fn restrict(&self, fine: &[f64]) -> Vec<f64> {
        let mut coarse = vec![0.0; self.points[0]];
        for p in &self.patches {
            let part = &fine[p.start[1]..p.start[1] + p.fine[0] * p.fine[1]];
            let field = DMatrix::from_column_slice(p.fine[0], p.fine[1], part);
            let next = p.shares[0].tr_mul(&field) * &p.shares[1];
            coarse[p.start[0]..p.start[0] + next.len()].copy_from_slice(next.as_slice());
        }
        coarse
    }

    /// `P^T v`: integrals over the hats between `lines` from those over all hats.
    fn sum(&self, fine: &[f64], lines: &[[Lines; 2]]) -> Vec<f64> {
        let mut coarse = vec![0.0; self.points[0]];
        for (p, [x, y]) in self.patches.iter().zip(lines) {
            for (k, value) in fine[p.start[1]..]
                .iter()
                .take(p.fine[0] * p.fine[1])
                .enumerate()
            {
                for (j, b) in y.at(k / p.fine[0]) {
                    for (i, a) in x.at(k % p.fine[0]) {
                        coarse[p.start[0] + j * p.coarse[0] + i] += a * b * value;
                    }
                }
            }
        }
        coarse
    }

    /// `Q` over all points, row by row.
    fn matrix(&self) -> Mat<f64> {
        let mut matrix = Mat::zeros(self.points[1], self.points[0]);
        for p in &self.patches {
            for i in 0..p.fine[0] * p.fine[1] {
                for j in 0..p.coarse[0] * p.coarse[1] {
                    matrix[(p.start[1] + i, p.start[0] + j)] = p.shares[0]
                        [(i % p.fine[0], j % p.coarse[0])]
                        * p.shares[1][(i / p.fine[0], j / p.coarse[0])];
                }
            }
        }
        matrix
    }
}

/// A body that is condensed onto coarse hats, under hats on a finer grid; see the head of this file.
pub struct Refined {
    carrier: Carrier,
    /// On the fine hats; of a half, with the loads of the mirror image as well.
    half_space: Arc<dyn Compliance>,
    /// Of the hats on a plane over those on the body.
    share: Vec<f64>,
    weights: Vec<f64>,
    /// `S_c - S_hc` for the components 11, 22, nn, 12, 1n, 2n, row by row.
    difference: [Vec<f64>; 6],
}

/// A half-space under the hats of some patches, and of their mirror images for a half.
struct Near {
    half_space: HatHalfSpace,
    /// Areas of the hats of the patches [m2].
    weights: Vec<f64>,
    /// Of all patches, images included.
    lines: Vec<[Lines; 2]>,
    /// The mirror image of each fine and of each coarse point, where there are images.
    image: Option<[Vec<usize>; 2]>,
}

impl Near {
    fn new(material: Material, patches: Vec<Patch>, lines: &[[Lines; 2]]) -> Result<Self, Error> {
        let half_space = HatHalfSpace::new(material, patches, Neighbours::Interact)?;
        Ok(Self {
            weights: half_space.weights(),
            half_space,
            lines: lines.to_vec(),
            image: None,
        })
    }

    fn with_image(
        material: Material,
        mut patches: Vec<Patch>,
        lines: &[[Lines; 2]],
    ) -> Result<Self, Error> {
        let counts = |[x, y]: &[Lines; 2]| [[x.nodes(), y.nodes()], [x.len(), y.len()]];
        let image = [0, 1].map(|k| images(lines.iter().map(|l| counts(l)[k])));
        let twins: Vec<Patch> = patches.iter().map(mirrored).collect();
        patches.extend(twins);
        let mut all = lines.to_vec();
        all.extend(lines.iter().map(|[x, y]| [x.clone(), y.reversed()]));
        let mut near = Self::new(material, patches, &all)?;
        near.weights.truncate(image[0].len() / 2);
        near.image = Some(image);
        Ok(near)
    }

    /// As [`HatHalfSpace::on_lines`], under loads that are their own mirror images if it has images.
    fn on_lines(&self, observed: Component, loaded: Component) -> Vec<f64> {
        let whole = self.half_space.on_lines(observed, loaded, &self.lines);
        let Some([_, image]) = &self.image else {
            return whole;
        };
        let (n, sign) = (image.len() / 2, SymmetricHalf::sign(loaded));
        whole
            .chunks_exact(2 * n)
            .take(n)
            .flat_map(|row| (0..n).map(move |j| row[j] + sign * row[image[j]]))
            .collect()
    }

    fn compliance(self) -> Arc<dyn Compliance> {
        let whole = Arc::new(self.half_space);
        let half = self.image.and_then(|[image, _]| {
            SymmetricHalf::new(Arc::clone(&whole) as Arc<dyn Compliance>, &image)
        });
        half.map_or(whole as Arc<dyn Compliance>, |half| Arc::new(half))
    }
}

/// The mirror image about y = 0.
fn mirrored(patch: &Patch) -> Patch {
    let Patch { x0, y0, grid } = *patch;
    Patch {
        x0,
        y0: -(y0 + (grid.ny - 1) as f64 * grid.dy),
        grid,
    }
}

/// The image of each point, where the images of patches of (nx, ny) points follow on the patches.
fn images(counts: impl Iterator<Item = [usize; 2]> + Clone) -> Vec<usize> {
    let n: usize = counts.clone().map(|[nx, ny]| nx * ny).sum();
    let mut image = vec![0; 2 * n];
    let mut start = 0;
    for [nx, ny] in counts {
        for (own, (j, i)) in (0..ny)
            .flat_map(|j| (0..nx).map(move |i| (j, i)))
            .enumerate()
        {
            let twin = n + start + (ny - 1 - j) * nx + i;
            image[start + own] = twin;
            image[twin] = start + own;
        }
        start += nx * ny;
    }
    image
}

const PAIRS: [(Component, Component); 6] = [
    (Component::X, Component::X),
    (Component::Y, Component::Y),
    (Component::Normal, Component::Normal),
    (Component::X, Component::Y),
    (Component::X, Component::Normal),
    (Component::Y, Component::Normal),
];

impl Refined {
    /// The `body`, condensed onto the hats between `lines` along x and y of each of the `patches` with the areas
    /// `weights` [m2], on all nodes of these patches. The body is the `half` of one that is its own mirror image
    /// about y = 0, under loads that are theirs, or the whole. Of both the half-space is that of all patches, so that
    /// the half is the whole under such loads. `motions` are the displacements along x, y and z of the coarse points by
    /// the rigid motions that are left free; what the body gives way along them is no matter, as its loads balance.
    ///
    /// # Errors
    /// Lines of other patches, areas that are not those of hats on a plane within a percent, [`Error::Stiff`] where
    /// the result might not be positive definite, more points than the memory holds.
    pub fn new(
        body: &Arc<dyn Compliance>,
        weights: &[f64],
        motions: &[[Vec<f64>; 3]],
        material: Material,
        lines: &[[Lines; 2]],
        patches: Vec<Patch>,
        half: bool,
    ) -> Result<Self, Error> {
        let nodes = |[x, y]: &[Lines; 2]| [x.nodes(), y.nodes()];
        let own = |p: &Patch| [p.grid.nx, p.grid.ny];
        if !lines.iter().map(nodes).eq(patches.iter().map(own)) {
            return Err(Error::Shape {
                name: "lines of the nodes of each patch",
                found: lines.len(),
                expected: patches.len(),
            });
        }
        let carrier = Carrier::new(lines);
        let [n, _] = carrier.points();
        let moved = motions
            .iter()
            .flatten()
            .map(|field| ("motions", field.len()));
        for (name, found) in [("weights", weights.len()), ("points", body.points())]
            .into_iter()
            .chain(moved)
        {
            if found != n {
                return Err(Error::Shape {
                    name,
                    found,
                    expected: n,
                });
            }
        }
        check_memory(n, 8.0 * 9.0 * (n as f64).powi(2), f64::INFINITY)?;
        let near = if half {
            Near::with_image(material, patches, lines)?
        } else {
            Near::new(material, patches, lines)?
        };
        let on_plane = carrier.sum(&near.weights, lines);
        let mut parts = weights.iter().zip(&on_plane);
        if let Some(point) = parts.position(|(w, flat)| (w - flat).abs() > COVERED * flat) {
            return Err(Error::NoArea(point));
        }
        let smooth = smooth_tractions(lines);
        let mut difference: [Vec<f64>; 6] = Default::default();
        for (difference, (a, b)) in difference.iter_mut().zip(PAIRS) {
            let mut own = vec![0.0; n * n];
            body.add_influence(a, b, 1.0, &mut own);
            for (row, w) in own.chunks_exact_mut(n).zip(weights) {
                for a in row {
                    *a *= w;
                }
            }
            let plane = near.on_lines(a, b);
            if a == b {
                let along = motions.iter().map(|motion| &motion[a as usize][..]);
                soften(&mut own, &plane, weights, along, &smooth)?;
            }
            own.iter_mut().zip(plane).for_each(|(d, h)| *d -= h);
            *difference = own;
        }
        let weights = carrier.carry(weights);
        let share = near.weights.iter().zip(&weights).map(|(h, w)| h / w);
        let share = share.collect();
        Ok(Self {
            carrier,
            half_space: near.compliance(),
            share,
            weights,
            difference,
        })
    }

    /// Area of each point [m2].
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// How fields on the coarse points are carried to the fine ones.
    pub fn carrier(&self) -> &Carrier {
        &self.carrier
    }

    /// The difference of two components, and whether it has to be transposed.
    fn difference(&self, observed: Component, loaded: Component) -> (&[f64], bool) {
        let place = |pair| PAIRS.iter().position(|p| *p == pair);
        match place((observed, loaded)) {
            Some(k) => (&self.difference[k], false),
            None => (
                &self.difference[place((loaded, observed)).unwrap_or(0)],
                true,
            ),
        }
    }
}

/// Relative difference of an area from that of a hat on a plane up to which the body is there.
const COVERED: f64 = 0.01;

/// Change of the displacement by smooth tractions up to which [`soften`] may soften a body.
const UNCHANGED: f64 = 1e-3;

/// Tractions that are constant, linear and quadratic over each of some patches.
fn smooth_tractions(lines: &[[Lines; 2]]) -> Vec<Vec<f64>> {
    let points = lines.iter().map(|[x, y]| x.len() * y.len()).sum();
    let mut found = Vec::new();
    let mut start = 0;
    for [x, y] in lines {
        let at = |along: &Lines, k: usize| {
            2.0 * along.kept()[k] as f64 / (along.nodes() - 1) as f64 - 1.0
        };
        let count = x.len() * y.len();
        for powers in [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]] {
            let mut traction = vec![0.0; points];
            for k in 0..count {
                traction[start + k] =
                    at(x, k % x.len()).powi(powers[0]) * at(y, k / x.len()).powi(powers[1]);
            }
            found.push(traction);
        }
        start += count;
    }
    found
}

/// Softens a body where it is so much stiffer than a half-space that the sum on a fine grid might not be positive
/// definite: tractions of the shortest waves of the coarse grid, which elements of the same size are too stiff for.
/// Along its free `motions`, which loads that balance do not work on, it counts as a half-space.
///
/// # Errors
/// [`Error::Stiff`] where smooth tractions notice: the body itself is so stiff.
fn soften<'a>(
    body: &mut [f64],
    plane: &[f64],
    weights: &[f64],
    motions: impl Iterator<Item = &'a [f64]>,
    smooth: &[Vec<f64>],
) -> Result<(), Error> {
    let n = smooth[0].len();
    let symmetric = |m: &[f64]| Mat::from_fn(n, n, |i, j| 0.5 * (m[i * n + j] + m[j * n + i]));
    let (mut own, half_space) = (symmetric(body), symmetric(plane));
    for motion in motions {
        let motion = Mat::from_fn(n, 1, |i, _| motion[i]);
        let moved = Mat::from_fn(n, 1, |i, _| weights[i] * motion[(i, 0)]);
        let size = (motion.transpose() * &moved)[(0, 0)];
        let missing = (motion.transpose() * (&half_space - &own) * &motion)[(0, 0)];
        if size > 0.0 && missing > 0.0 {
            own += &moved * moved.transpose() * Scale(missing / (size * size));
        }
    }
    let spare = Mat::from_fn(n, n, |i, j| own[(i, j)] - LOST * half_space[(i, j)]);
    if spare.llt(Side::Lower).is_ok() {
        return Ok(());
    }
    let Ok(factor) = half_space.llt(Side::Lower) else {
        return Err(Error::Stiff);
    };
    let lower = factor.L();
    let mut inner = own.clone();
    solve_lower_triangular_in_place(lower, inner.as_mut(), Par::Seq);
    let mut inner = inner.transpose().to_owned();
    solve_lower_triangular_in_place(lower, inner.as_mut(), Par::Seq);
    let Ok(eigen) = inner.self_adjoint_eigen(Side::Lower) else {
        return Err(Error::Stiff);
    };
    let stiff = (0..n).filter(|&k| eigen.S()[k] < LOST).count();
    if stiff == 0 {
        return Ok(());
    }
    // the eigenvalues rise
    let shapes = lower * eigen.U().subcols(0, stiff);
    let weighted = Mat::from_fn(n, stiff, |i, k| shapes[(i, k)] * (LOST - eigen.S()[k]));
    let more = weighted * shapes.transpose();
    for traction in smooth {
        let traction = Mat::from_fn(n, 1, |i, _| traction[i]);
        if (&more * &traction).norm_l2() > UNCHANGED * (&own * &traction).norm_l2() {
            return Err(Error::Stiff);
        }
    }
    for (i, row) in body.chunks_exact_mut(n).enumerate() {
        row.iter_mut()
            .enumerate()
            .for_each(|(j, a)| *a += more[(i, j)]);
    }
    Ok(())
}

impl Compliance for Refined {
    fn points(&self) -> usize {
        self.weights.len()
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        let coarse = self.carrier.restrict(traction);
        let n = coarse.len();
        let (difference, is_transposed) = self.difference(observed, loaded);
        let mut moved = vec![0.0; n];
        for (i, row) in difference.chunks_exact(n).enumerate() {
            if is_transposed {
                moved
                    .iter_mut()
                    .zip(row)
                    .for_each(|(m, d)| *m += coarse[i] * d);
            } else {
                moved[i] = row.iter().zip(&coarse).map(|(d, t)| d * t).sum();
            }
        }
        let moved = self.carrier.carry(&moved);
        let mut near = vec![0.0; self.points()];
        self.half_space
            .add_displacement(observed, loaded, 1.0, traction, &mut near);
        for (i, u) in displacement.iter_mut().enumerate() {
            *u += scale * (self.share[i] * near[i] + moved[i] / self.weights[i]);
        }
    }

    fn reciprocity(&self) -> Option<Vec<f64>> {
        Some(self.weights.clone())
    }

    fn prefers_products(&self) -> bool {
        true
    }

    fn near_inverse(&self, softer: f64) -> Option<Map> {
        // what is smooth takes few steps of a Krylov method
        self.half_space.near_inverse(softer)
    }

    fn influence_memory(&self) -> f64 {
        let [n, fine] = self.carrier.points().map(|n| n as f64);
        8.0 * (2.0 * fine * fine + 2.0 * n * fine) + self.half_space.influence_memory()
    }

    fn add_influence(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        matrix: &mut [f64],
    ) {
        let (n, fine) = (self.carrier.points()[0], self.points());
        let (difference, is_transposed) = self.difference(observed, loaded);
        let d = Mat::from_fn(n, n, |i, j| {
            difference[if is_transposed { j * n + i } else { i * n + j }]
        });
        let q = self.carrier.matrix();
        let far = &q * d * q.transpose();
        let mut near = vec![0.0; fine * fine];
        self.half_space
            .add_influence(observed, loaded, 1.0, &mut near);
        for (i, (row, near)) in matrix
            .chunks_exact_mut(fine)
            .zip(near.chunks_exact(fine))
            .enumerate()
        {
            for (j, (a, near)) in row.iter_mut().zip(near).enumerate() {
                *a += scale * (self.share[i] * near + far[(i, j)] / self.weights[i]);
            }
        }
    }
}

#[cfg(test)]
mod tests;

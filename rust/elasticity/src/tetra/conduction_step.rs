// SPDX-License-Identifier: MIT OR Apache-2.0
//! Implicit steps of a body that conducts, condensed onto contact points.
//!
//! A step is `(K + C / dt) T = r + B q`, with what earlier heat leaves, `r`, and fluxes `q` through the contact points.
//! With Cholesky's factor all that is asked of it stands between its two substitutions: `y = L^-1 r` is found once,
//! the contact points see `(L^-1 B)^T y` of it, fluxes add `(L^-1 B) q`, and one backward substitution ends the step.
//! The nodes below the contact points are eliminated last, so that `L^-1 B` has as many rows as these.

use std::sync::{Arc, PoisonError};

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use mtb_operator::{Monitor, check_memory, ready_products, reset_workers};
use rayon::prelude::*;

use super::assembly::Lower;
use super::columns::par;
use super::conduction::{ConductingBody, check_duration, factor_of_step, pattern, refuse};
use super::factor::{Factor, SparseColumn};
use super::factorised::poll;
use super::layers;
use super::mirror::{Mirror, Side};
use super::ordering::{Graph, postordered};
use super::sampling::Sampling;
use crate::Error;

/// Right-hand sides that one thread takes through the factor at a time.
const GROUP: usize = 16;

/// By how much the films of mirror images may differ, as a share of the largest.
const ALIKE: f64 = 1e-9;

/// By how much sums over mirror images may differ, as a share of the largest of their shares.
const SAME_SUMS: f64 = 1e-11;

/// A body in the parts that its steps solve.
///
/// One that is its own mirror image is solved by half: even and odd temperatures are two right-hand sides of one
/// factor. Any other one is a single part.
pub(super) struct Halved {
    /// Ranks of the body below contact points.
    touched: Vec<usize>,
    /// For each rank of the body its number among those that are solved, and its side of the mirror.
    place: Vec<(usize, Side)>,
    has_mirror: bool,
    /// First number below the contact points, and first one on the plane of the mirror.
    late: usize,
    plane: usize,
    capacity: Lower,
    conduction: Lower,
}

impl Halved {
    fn new(
        body: &ConductingBody,
        touched: Vec<usize>,
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let mesh = body.mesh();
        let ranks = body.ranks();
        let n = ranks.len();
        let mirrors = Mirror::all(mesh, &|_, _| true).into_iter();
        let mirror = mirrors
            .filter(|mirror| has_image(body, mirror))
            .min_by_key(|mirror| mirror.on_plane().count());
        poll(monitor, 0)?;
        let side = |node: usize| mirror.as_ref().map_or(Side::Before, |m| m.side(node));
        let image = |node: usize| mirror.as_ref().map_or(node, |m| m.image(node));
        let mut is_touched = vec![false; n];
        for &rank in &touched {
            is_touched[rank] = true;
        }
        let is_late = |node: usize| is_touched[ranks[node]] || is_touched[ranks[image(node)]];
        let before = |late: bool| {
            (0..n).filter(move |&node| side(node) == Side::Before && is_late(node) == late)
        };
        let mut is_inner = vec![false; n];
        for node in before(false) {
            is_inner[node] = true;
        }
        let graph = Graph::of_groups(n, mesh.cells().chunks_exact(mesh.order().nodes_per_tet()));
        let mut order = Vec::with_capacity(n);
        if is_inner.contains(&true) {
            let dissected = layers::elimination(&graph, &is_inner, mesh.nodes());
            poll(monitor, 0)?;
            order = postordered(&graph, &dissected);
        }
        let late = order.len();
        order.extend(before(true));
        let plane = order.len();
        order.extend((0..n).filter(|&node| side(node) == Side::OnPlane));
        poll(monitor, 0)?;
        let mut number = vec![usize::MAX; n];
        for (k, &node) in order.iter().enumerate() {
            number[node] = k;
        }
        let mut capacity = pattern(&graph, &order, &number);
        let mut conduction = capacity.clone();
        for (column, &node) in order.iter().enumerate() {
            for k in capacity.start[column]..capacity.start[column + 1] {
                let row = capacity.row[k];
                let (i, j) = (ranks[order[row]], ranks[node]);
                // on the plane the other half has its share
                let share = if column >= plane { 0.5 } else { 1.0 };
                capacity.value[k] = share * body.capacity().at(i, j);
                conduction.value[k] = share * body.conduction().at(i, j);
            }
        }
        let mut place = vec![(0, Side::Before); n];
        for node in 0..n {
            let own = if side(node) == Side::Behind {
                image(node)
            } else {
                node
            };
            place[ranks[node]] = (number[own], side(node));
        }
        Ok(Self {
            touched,
            place,
            has_mirror: mirror.is_some(),
            late,
            plane,
            capacity,
            conduction,
        })
    }

    fn size(&self) -> usize {
        self.capacity.start.len() - 1
    }

    fn parts(&self) -> usize {
        1 + usize::from(self.has_mirror)
    }

    /// What the product of two right-hand sides in parts counts for.
    fn scale(&self) -> f64 {
        self.parts() as f64
    }

    /// A right-hand side of the body (ranks) in parts.
    fn load(&self, load: impl Iterator<Item = (usize, f64)>, parts: &mut [f64]) {
        let (even, odd) = parts.split_at_mut(self.size());
        for (rank, value) in load {
            let (k, side) = self.place[rank];
            if !self.has_mirror {
                even[k] += value;
                continue;
            }
            even[k] += 0.5 * value;
            match side {
                Side::Before => odd[k] += 0.5 * value,
                Side::Behind => odd[k] -= 0.5 * value,
                Side::OnPlane => {}
            }
        }
    }

    /// The heat [J] of temperatures of the body (ranks), in parts as a right-hand side.
    fn heat(&self, temperature: &[f64]) -> Vec<f64> {
        let mut parts = vec![0.0; self.parts() * self.size()];
        self.load(temperature.iter().copied().enumerate(), &mut parts);
        let (even, odd) = parts.split_at_mut(self.size());
        if !self.has_mirror {
            return self.capacity.times(even);
        }
        // a temperature on the plane has no other half
        even[self.plane..].iter_mut().for_each(|t| *t *= 2.0);
        self.capacity.times_each([even, odd]).concat()
    }

    /// Temperatures of the body (ranks) by those in parts.
    fn whole(&self, parts: &[f64]) -> Vec<f64> {
        let (even, odd) = parts.split_at(self.size());
        let of = |&(k, side): &(usize, Side)| {
            if !self.has_mirror {
                return even[k];
            }
            match side {
                Side::Before => even[k] + odd[k],
                Side::Behind => even[k] - odd[k],
                Side::OnPlane => even[k],
            }
        };
        self.place.iter().map(of).collect()
    }

    /// Forward substitution in place of right-hand sides in parts, one after the other, that are zero above `from`.
    fn forward(&self, factor: &Factor, sides: &mut [f64], from: usize) {
        factor.forward_in_place(sides, from);
        if self.has_mirror {
            // odd ones have nothing on the plane
            for odd in sides.chunks_exact_mut(self.size()).skip(1).step_by(2) {
                odd[self.plane..].fill(0.0);
            }
        }
    }
}

/// Whether the films of a body are their own image as well.
fn has_image(body: &ConductingBody, mirror: &Mirror) -> bool {
    let (films, ranks) = (body.films(), body.ranks());
    let most = films.value.iter().copied().fold(0.0, f64::max);
    if most == 0.0 {
        return true;
    }
    let mut image = vec![0; ranks.len()];
    for (node, &rank) in ranks.iter().enumerate() {
        image[rank] = ranks[mirror.image(node)];
    }
    (0..ranks.len()).all(|column| {
        (films.start[column]..films.start[column + 1]).all(|k| {
            let other = films.at(image[films.row[k]], image[column]);
            (films.value[k] - other).abs() <= ALIKE * most
        })
    })
}

/// An implicit step of a conducting body over a duration, condensed onto contact points.
///
/// Temperatures of nodes are in the order of the mesh. A flux is a sum of the basis functions of the contact points,
/// as pressures are; the temperature of a contact point is the mean weighted by its basis function. What a step comes
/// to without any flux is described by what it leaves after [`Self::coast`], numbers between its two substitutions.
pub struct ConductionStep {
    body: Arc<ConductingBody>,
    duration: f64,
    halved: Arc<Halved>,
    factor: Factor,
    /// For each contact point the ranks below it, each with the integral of both functions [m2].
    trace: Vec<SparseColumn>,
    weights: Vec<f64>,
    /// The same after forward substitution: rows from [`Halved::late`] on, part after part, by contact points.
    reached: Mat<f64>,
    response: Vec<f64>,
}

impl ConductingBody {
    /// An implicit step over `duration` [s] with heat through the contact points of `sampling`.
    ///
    /// The step is of first order in the duration and stable for any (backward Euler).
    ///
    /// # Errors
    /// [`Error::Duration`]; [`Error::NotOnBoundary`], [`Error::NoArea`]; [`Error::OutOfMemory`];
    /// [`Error::Interrupted`].
    pub fn step(
        self: &Arc<Self>,
        duration: f64,
        sampling: &Sampling,
        monitor: Monitor<'_>,
    ) -> Result<ConductionStep, Error> {
        check_duration(duration)?;
        ready_products()?;
        let (trace, weights) = self.traced(sampling)?;
        let halved = self.halved_for(&trace, monitor)?;
        let factor = factor_of_step(&halved.conduction, &halved.capacity, duration, monitor)?;
        let (n, size, parts) = (trace.len(), halved.size(), halved.parts());
        let (late, rows) = (halved.late, size - halved.late);
        let mut reached = Mat::zeros(parts * rows, n);
        for (first, group) in (0..n).step_by(GROUP).zip(trace.chunks(GROUP)) {
            let mut sides = vec![0.0; group.len() * parts * size];
            for (column, side) in group.iter().zip(sides.chunks_exact_mut(parts * size)) {
                halved.load(column.iter().copied(), side);
            }
            halved.forward(&factor, &mut sides, late);
            for (k, side) in sides.chunks_exact(size).enumerate() {
                let into = reached.col_as_slice_mut(first + k / parts);
                into[(k % parts) * rows..][..rows].copy_from_slice(&side[late..]);
            }
            poll(monitor, 3)?;
        }
        let mut product = Mat::<f64>::zeros(n, n);
        matmul(
            product.as_mut(),
            Accum::Replace,
            reached.transpose(),
            reached.as_ref(),
            halved.scale(),
            par(),
        );
        reset_workers();
        poll(monitor, 4)?;
        let mut response = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                // the same for both, to the last digit
                response[i * n + j] = product[(i.max(j), i.min(j))] / weights[i];
            }
        }
        Ok(ConductionStep {
            body: self.clone(),
            duration,
            halved,
            factor,
            trace,
            weights,
            reached,
            response,
        })
    }

    /// The body in parts for contact points; those of the last step again where they are the same.
    fn halved_for(
        &self,
        trace: &[SparseColumn],
        monitor: Monitor<'_>,
    ) -> Result<Arc<Halved>, Error> {
        let mut touched: Vec<usize> = trace.iter().flatten().map(|&(rank, _)| rank).collect();
        touched.sort_unstable();
        touched.dedup();
        let mut kept = self.halved.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(halved) = &*kept
            && halved.touched == touched
        {
            return Ok(halved.clone());
        }
        let made = Arc::new(Halved::new(self, touched, monitor)?);
        *kept = Some(made.clone());
        Ok(made)
    }
}

impl ConductionStep {
    /// Temperatures (n, n) [K m2/W] of the contact points at the end of the step by a unit flux into each, row-major.
    pub fn response(&self) -> &[f64] {
        &self.response
    }

    /// Areas (n) [m2] of the contact points.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The duration [s].
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// How many numbers [`Self::coast`] leaves.
    pub fn width(&self) -> usize {
        self.halved.parts() * self.halved.size()
    }

    /// Whether the body is its own mirror image, and solved by half.
    pub fn has_mirror(&self) -> bool {
        self.halved.has_mirror
    }

    /// Temperatures of the contact points (n) [K] under those of the nodes.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`].
    pub fn observe(&self, temperature: &[f64]) -> Result<Vec<f64>, Error> {
        let ranked = self.body.ranked(temperature)?;
        let columns = self.trace.iter().zip(&self.weights);
        Ok(columns
            .map(|(column, w)| column.iter().map(|(k, b)| b * ranked[*k]).sum::<f64>() / w)
            .collect())
    }

    /// What a step that begins at `temperature` (nodes) [K] comes to without any flux, between its two substitutions.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`].
    pub fn coast(&self, temperature: &[f64]) -> Result<Vec<f64>, Error> {
        let mut left = self.halved.heat(&self.body.ranked(temperature)?);
        for heat in &mut left {
            *heat /= self.duration;
        }
        let inflow = self.body.inflow_by_rank().iter().copied().enumerate();
        self.halved
            .load(inflow.filter(|(_, flow)| *flow != 0.0), &mut left);
        self.halved.forward(&self.factor, &mut left, 0);
        Ok(left)
    }

    /// Temperatures of the contact points (n) [K] at the end of a step that was `coasted`.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`].
    pub fn observe_coasted(&self, coasted: &[f64]) -> Result<Vec<f64>, Error> {
        refuse("coasted", coasted, self.width())?;
        let rows = self.reached.nrows() / self.halved.parts();
        let late: Vec<f64> = coasted
            .chunks_exact(self.halved.size())
            .flat_map(|part| &part[part.len() - rows..])
            .copied()
            .collect();
        let mut found = Mat::<f64>::zeros(self.weights.len(), 1);
        matmul(
            found.as_mut(),
            Accum::Replace,
            self.reached.transpose(),
            MatRef::from_column_major_slice(&late, late.len(), 1),
            self.halved.scale(),
            Par::Seq,
        );
        let each = found.col_as_slice(0).iter().zip(&self.weights);
        Ok(each.map(|(t, w)| t / w).collect())
    }

    /// Temperatures of the nodes [K] at the end of a step that was `coasted`, with `flux` (n) [W/m2] through the
    /// contact points.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`].
    pub fn end(&self, coasted: &[f64], flux: &[f64]) -> Result<Vec<f64>, Error> {
        refuse("coasted", coasted, self.width())?;
        refuse("flux", flux, self.weights.len())?;
        let (size, parts) = (self.halved.size(), self.halved.parts());
        let rows = self.reached.nrows() / parts;
        let mut entered = Mat::<f64>::zeros(parts * rows, 1);
        matmul(
            entered.as_mut(),
            Accum::Replace,
            self.reached.as_ref(),
            MatRef::from_column_major_slice(flux, flux.len(), 1),
            1.0,
            Par::Seq,
        );
        let mut x = coasted.to_vec();
        let each = entered.col_as_slice(0).chunks_exact(rows);
        for (part, entered) in x.chunks_exact_mut(size).zip(each) {
            for (x, entered) in part[size - rows..].iter_mut().zip(entered) {
                *x += entered;
            }
        }
        self.factor.backward_in_place(&mut x);
        Ok(self.body.by_node(&self.halved.whole(&x)))
    }

    /// Temperatures of the nodes [K] at the end of a step that begins at `temperature` (nodes), with `flux` (n)
    /// [W/m2] through the contact points.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`].
    pub fn advance(&self, temperature: &[f64], flux: &[f64]) -> Result<Vec<f64>, Error> {
        self.end(&self.coast(temperature)?, flux)
    }

    /// What sums over the temperatures of the nodes at the end of a step, `rows` (m, nodes) row-major, are of what it
    /// comes to without any flux.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`]; [`Error::Operator`] for more than the memory holds;
    /// [`Error::Interrupted`].
    pub fn seen(&self, rows: &[f64], monitor: Monitor<'_>) -> Result<Seen, Error> {
        let (nodes, width) = (self.body.ranks().len(), self.width());
        let m = rows.len() / nodes;
        refuse("rows", rows, m * nodes)?;
        ready_products()?;
        check_memory(m, (8 * m * width) as f64, f64::INFINITY)?;
        let mut found = vec![0.0; m * width];
        let groups = rows.chunks(GROUP * nodes);
        let mut groups: Vec<_> = groups.zip(found.chunks_mut(GROUP * width)).collect();
        for round in groups.chunks_mut(rayon::current_num_threads()) {
            round.par_iter_mut().for_each(|(rows, sides)| {
                for (row, side) in rows.chunks_exact(nodes).zip(sides.chunks_exact_mut(width)) {
                    let ranked = self.body.by_rank(row);
                    self.halved.load(ranked.into_iter().enumerate(), side);
                }
                self.halved.forward(&self.factor, sides, 0);
                let scale = self.halved.scale();
                sides.iter_mut().for_each(|value| *value *= scale);
            });
            reset_workers();
            poll(monitor, 4)?;
        }
        Ok(Seen::new(&found, self.halved.size(), self.halved.parts()))
    }

    /// The sums (m) of [`Self::seen`] at the end of a step that was `coasted`, without any flux.
    ///
    /// # Errors
    /// [`Error::Shape`].
    pub fn seen_coasted(&self, seen: &Seen, coasted: &[f64]) -> Result<Vec<f64>, Error> {
        let width = self.width();
        refuse("coasted", coasted, width)?;
        seen.check(width)?;
        let (rows, size) = (seen.rows(), self.halved.size());
        let kept = MatRef::from_row_major_slice(&seen.kept, rows, width);
        let shares: Vec<Vec<f64>> = (coasted.chunks_exact(size).enumerate())
            .map(|(part, coasted)| {
                let mut share = vec![0.0; rows];
                matmul(
                    MatMut::from_column_major_slice_mut(&mut share, rows, 1),
                    Accum::Replace,
                    kept.subcols(part * size, size),
                    MatRef::from_column_major_slice(coasted, size, 1),
                    1.0,
                    Par::Seq,
                );
                share
            })
            .collect();
        let sum = |(row, is_image): &(usize, bool)| -> f64 {
            let each = shares.iter().enumerate();
            each.map(|(part, share)| sign(*is_image, part) * share[*row])
                .sum()
        };
        Ok(seen.sums.iter().map(sum).collect())
    }

    /// The sums of [`Self::seen`] over the temperatures at the end of a step by a unit flux into each contact point:
    /// (m, n), row-major.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::Operator`].
    pub fn response_of(&self, seen: &Seen) -> Result<Vec<f64>, Error> {
        let (n, width) = (self.weights.len(), self.width());
        seen.check(width)?;
        ready_products()?;
        let (size, parts) = (self.halved.size(), self.halved.parts());
        let rows = self.reached.nrows() / parts;
        let kept = MatRef::from_row_major_slice(&seen.kept, seen.rows(), width);
        let mut found = vec![0.0; seen.sums.len() * n];
        for part in 0..parts {
            let mut share = vec![0.0; seen.rows() * n];
            matmul(
                MatMut::from_row_major_slice_mut(&mut share, seen.rows(), n),
                Accum::Replace,
                kept.subcols((part + 1) * size - rows, rows),
                self.reached.as_ref().subrows(part * rows, rows),
                1.0,
                par(),
            );
            for (sum, (row, is_image)) in found.chunks_exact_mut(n.max(1)).zip(&seen.sums) {
                let sign = sign(*is_image, part);
                for (sum, share) in sum.iter_mut().zip(&share[row * n..]) {
                    *sum += sign * share;
                }
            }
        }
        reset_workers();
        Ok(found)
    }
}

/// What sums over the temperatures at the end of a step are of what it comes to: [`ConductionStep::seen`].
///
/// Of a body in halves, sums that are mirror images of each other are kept once.
pub struct Seen {
    /// Those that are kept (rows, width), row-major.
    kept: Vec<f64>,
    width: usize,
    /// For each sum its row there, and whether it is the image of that.
    sums: Vec<(usize, bool)>,
}

/// Of the even (0) and the odd (1) part of what is seen in the mirror.
fn sign(is_image: bool, part: usize) -> f64 {
    if is_image && part == 1 { -1.0 } else { 1.0 }
}

impl Seen {
    /// Of all rows (m, parts * size).
    fn new(all: &[f64], size: usize, parts: usize) -> Self {
        let width = parts * size;
        let mut seen = Self {
            kept: Vec::new(),
            width,
            sums: Vec::new(),
        };
        // a mark that images share, to find them by
        let marks: Vec<f64> = (all.chunks_exact(width))
            .map(|row| (0..size).map(|k| row[k] * (k as f64).cos()).sum())
            .collect();
        // rows without an image so far: their numbers in all and in what is kept
        let mut alone: Vec<(usize, usize)> = Vec::new();
        for (m, row) in all.chunks_exact(width).enumerate() {
            let largest = row.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            let is_image = |other: usize| {
                let near = |a: f64, b: f64| (a - b).abs() <= SAME_SUMS * largest;
                let other = &all[other * width..][..width];
                let (even, odd) = row.split_at(size);
                even.iter().zip(other).all(|(a, b)| near(*a, *b))
                    && odd.iter().zip(&other[size..]).all(|(a, b)| near(*a, -b))
            };
            let close = |other: usize| {
                (marks[m] - marks[other]).abs() <= SAME_SUMS * largest * width as f64
            };
            let image = (alone.iter())
                .position(|(other, _)| parts == 2 && close(*other) && is_image(*other));
            if let Some(at) = image {
                let (_, row) = alone.swap_remove(at);
                seen.sums.push((row, true));
            } else {
                let kept = seen.rows();
                alone.push((m, kept));
                seen.sums.push((kept, false));
                seen.kept.extend_from_slice(row);
            }
        }
        seen
    }

    /// Refuses sums over another body's temperatures.
    fn check(&self, width: usize) -> Result<(), Error> {
        if self.width == width {
            return Ok(());
        }
        Err(Error::Shape {
            name: "seen",
            found: self.width,
            expected: width,
        })
    }

    /// How many are kept.
    fn rows(&self) -> usize {
        self.kept.len() / self.width.max(1)
    }
}

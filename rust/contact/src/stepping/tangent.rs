// SPDX-License-Identifier: MIT OR Apache-2.0
//! A sliding state, linearised: how pressures, gaps and motions follow what is given, and the other way round.

use std::sync::Arc;

use faer::Mat;
use mtb_complementarity::linear::definiteness_limit;
use mtb_operator::Monitor;
use mtb_operator::krylov::dot;

use super::bordered::Bordered;
use super::influence::{Influence, Terms};
use crate::error::{Error, check};
use crate::sliding::{RigidMotion, SlidingContact};

/// Relative size of the last correction at which the linear equations count as solved ...
const SOLVED: f64 = 1e-11;
/// ... and corrections that may reach it before factors of the equations themselves are made.
const CORRECTIONS: usize = 12;

/// What a linearisation takes of a sliding state.
#[derive(Clone, Debug, PartialEq)]
pub struct SlidingState {
    /// Area of each point (n) [m2].
    pub area: Vec<f64>,
    /// Pressure (n) [Pa]; points with none are not in contact.
    pub pressure: Vec<f64>,
    /// Friction coefficient of each point (n).
    pub friction: Vec<f64>,
    /// Derivative of coefficient times pressure by the pressure (n): the coefficient itself, unless it follows the
    /// pressure.
    pub slope: Vec<f64>,
    /// Direction of sliding (2n).
    pub direction: Vec<f64>,
    /// The free motions.
    pub motions: Vec<RigidMotion>,
    /// Diagonal compliance (n) [m/Pa].
    pub diagonal: Option<Vec<f64>>,
}

/// Of what is given to a sliding contact: small changes, or the gradient by it.
#[derive(Clone, Debug, PartialEq)]
pub struct Given {
    /// Gap of the unloaded pair (n) [m].
    pub gap: Vec<f64>,
    /// Work of the loads on each motion (m) [J].
    pub work: Vec<f64>,
    /// Friction coefficient times direction of sliding (2n).
    pub drag: Vec<f64>,
}

/// Of what is found: small changes, or weights of a sum.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Pressure (n) [Pa].
    pub pressure: Vec<f64>,
    /// Traction along both tangents on the lower body (2n) [Pa].
    pub traction: Vec<f64>,
    /// Deformed gap (n) [m]; points in contact have none.
    pub gap: Vec<f64>,
    /// Amplitude of each motion.
    pub motion: Vec<f64>,
}

impl Given {
    /// Nothing, of `points` and `motions`.
    pub fn nothing(points: usize, motions: usize) -> Self {
        Self {
            gap: vec![0.0; points],
            work: vec![0.0; motions],
            drag: vec![0.0; 2 * points],
        }
    }

    /// Sum of the products of a change and a gradient: the change of the number that the gradient is of.
    pub fn dot(&self, gradient: &Self) -> f64 {
        dot(&self.gap, &gradient.gap)
            + dot(&self.work, &gradient.work)
            + dot(&self.drag, &gradient.drag)
    }
}

impl Found {
    /// Nothing, of `points` and `motions`.
    pub fn nothing(points: usize, motions: usize) -> Self {
        Self {
            pressure: vec![0.0; points],
            traction: vec![0.0; 2 * points],
            gap: vec![0.0; points],
            motion: vec![0.0; motions],
        }
    }
}

impl SlidingState {
    fn check(&self, n: usize) -> Result<(), Error> {
        check("pressure", &self.pressure, n)?;
        check("slope", &self.slope, n)?;
        let contact = self.contact(&self.pressure, &self.friction);
        contact.check(n)
    }

    /// The equations of the state with some coefficients.
    fn contact<'a>(&'a self, gap: &'a [f64], friction: &'a [f64]) -> SlidingContact<'a> {
        SlidingContact {
            gap,
            area: &self.area,
            friction,
            direction: &self.direction,
            motions: &self.motions,
            diagonal: self.diagonal.as_deref(),
        }
    }

    /// A coefficient (n) times the direction (2n).
    fn along(&self, coefficient: &[f64]) -> Vec<f64> {
        let n = coefficient.len();
        let along = self.direction.iter().enumerate();
        along.map(|(i, d)| d * coefficient[i % n.max(1)]).collect()
    }

    /// What the influences of its linearised equations are multiplied with.
    fn terms(&self) -> Terms {
        Terms {
            drag: self.along(&self.slope),
            diagonal: self.diagonal.clone().unwrap_or_default(),
        }
    }
}

/// The equations of a sliding state, linearised about it.
///
/// At a state whose points in contact are known, pressure and motions follow gap, loads and friction by linear
/// equations, and so do their small changes. [`Tangent::forward`] solves them for changes of what is given;
/// [`Tangent::adjoint`] solves the transposed ones, once for each number that is asked for, which gives its
/// derivatives by all that is given. Both hold as long as no point comes into contact or leaves it: where a
/// point is about to, the derivatives are those of the side on which the points stay as they are.
///
/// With `A` the influence on the gaps of the points in contact, `O` the opening and `W` the work by motions,
/// the equations are `A dp + O dc = -dg - B p d(mu d)` and `-W dp = df + T p d(mu d)`.
pub struct Tangent<'a> {
    influence: &'a Influence,
    state: &'a SlidingState,
    factors: &'a mut Bordered,
    points: Vec<usize>,
    terms: Terms,
}

impl<'a> Tangent<'a> {
    /// About `state`, with factors of about its equations, which are made new where they do not serve.
    pub(super) fn new(
        influence: &'a Influence,
        state: &'a SlidingState,
        factors: &'a mut Bordered,
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        state.check(influence.points())?;
        let terms = state.terms();
        let points: Vec<usize> = in_contact(&state.pressure);
        let contact = state.contact(&state.pressure, &state.slope);
        let mut tangent = Self {
            influence,
            state,
            factors,
            points,
            terms,
        };
        let active: Vec<bool> = state.pressure.iter().map(|p| *p > 0.0).collect();
        if tangent.factors.is_far_from(&active) {
            tangent.refactorise(monitor)?;
        } else {
            tangent
                .factors
                .turn_to(influence, &contact, &tangent.points, monitor)?;
        }
        Ok(tangent)
    }

    fn refactorise(&mut self, monitor: Monitor<'_>) -> Result<(), Error> {
        *self.factors = Bordered::new(self.influence, &self.terms, &self.points, monitor)?;
        let contact = self.state.contact(&self.state.pressure, &self.state.slope);
        self.factors
            .turn_to(self.influence, &contact, &self.points, monitor)?;
        Ok(())
    }

    /// What follows small changes of what is given, one answer for each.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, an interruption; [`Error::Singular`].
    pub fn forward(
        &mut self,
        changes: &[Given],
        monitor: Monitor<'_>,
    ) -> Result<Vec<Found>, Error> {
        let (n, m, k) = (self.count(), self.state.motions.len(), self.points.len());
        let mut drags = Vec::new();
        for change in changes {
            check("gap", &change.gap, n)?;
            check("work", &change.work, m)?;
            check("drag", &change.drag, 2 * n)?;
            drags.push(
                change
                    .drag
                    .iter()
                    .enumerate()
                    .map(|(i, d)| d * self.state.pressure[i % n])
                    .collect(),
            );
        }
        let drags: Vec<Vec<f64>> = drags;
        // what the gaps do while the pressures stay
        let zero = Mat::zeros(n, changes.len());
        let [x, y] =
            [0, 1].map(|axis| Mat::from_fn(n, changes.len(), |i, j| drags[j][axis * n + i]));
        let mut opened = self.influence.products(&zero, [&x, &y]);
        for (j, change) in changes.iter().enumerate() {
            for (i, gap) in change.gap.iter().enumerate() {
                opened[(i, j)] += gap;
            }
        }
        let mut rhs = Mat::zeros(k + m, changes.len());
        for j in 0..changes.len() {
            for (i, &point) in self.points.iter().enumerate() {
                rhs[(i, j)] = -opened[(point, j)];
            }
            for (l, motion) in self.state.motions.iter().enumerate() {
                rhs[(k + l, j)] = changes[j].work[l] + self.work_of(motion, &drags[j]);
            }
        }
        let found = self.solved(&rhs, false, monitor)?;
        let mut pressure = Mat::zeros(n, changes.len());
        for (i, &point) in self.points.iter().enumerate() {
            pressure.row_mut(point).copy_from(found.row(i));
        }
        let [x, y] = [0, 1].map(|axis| {
            Mat::from_fn(n, changes.len(), |i, j| {
                self.terms.drag[axis * n + i] * pressure[(i, j)]
            })
        });
        opened += self.influence.products(&pressure, [&x, &y]);
        let mut answers = Vec::new();
        for j in 0..changes.len() {
            let mut answer = Found::nothing(n, m);
            for i in 0..n {
                answer.pressure[i] = pressure[(i, j)];
                for axis in [0, n] {
                    answer.traction[axis + i] =
                        self.terms.drag[axis + i] * pressure[(i, j)] + drags[j][axis + i];
                }
            }
            for l in 0..m {
                answer.motion[l] = found[(k + l, j)];
            }
            for i in (0..n).filter(|&i| self.state.pressure[i] <= 0.0) {
                answer.gap[i] = opened[(i, j)];
                for (motion, c) in self.state.motions.iter().zip(&answer.motion) {
                    answer.gap[i] += motion.opening[i] * c;
                }
            }
            answers.push(answer);
        }
        Ok(answers)
    }

    /// The gradients, by all that is given, of sums of what is found with the weights `of`: one for each.
    ///
    /// # Errors
    /// As [`Tangent::forward`].
    pub fn adjoint(&mut self, of: &[Found], monitor: Monitor<'_>) -> Result<Vec<Given>, Error> {
        let (n, m, k) = (self.count(), self.state.motions.len(), self.points.len());
        for weights in of {
            check("pressure", &weights.pressure, n)?;
            check("traction", &weights.traction, 2 * n)?;
            check("gap", &weights.gap, n)?;
            check("motion", &weights.motion, m)?;
        }
        let is_open = |i: usize| self.state.pressure[i] <= 0.0;
        let mut sides = Mat::from_fn(
            n,
            of.len(),
            |i, j| {
                if is_open(i) { of[j].gap[i] } else { 0.0 }
            },
        );
        // what the weights of open gaps are as weights of pressures and motions
        let mut rhs = Mat::zeros(k + m, of.len());
        if of.iter().any(|w| w.gap.iter().any(|g| *g != 0.0)) {
            let pulled = self.pulled_back(&sides);
            for j in 0..of.len() {
                for (i, &point) in self.points.iter().enumerate() {
                    rhs[(i, j)] = pulled[(point, j)];
                }
                for (l, motion) in self.state.motions.iter().enumerate() {
                    rhs[(k + l, j)] = (0..n).map(|i| motion.opening[i] * sides[(i, j)]).sum();
                }
            }
        }
        for (j, weights) in of.iter().enumerate() {
            for (i, &point) in self.points.iter().enumerate() {
                rhs[(i, j)] += weights.pressure[point];
                for axis in [0, n] {
                    rhs[(i, j)] += weights.traction[axis + point] * self.terms.drag[axis + point];
                }
            }
            for (l, weight) in weights.motion.iter().enumerate() {
                rhs[(k + l, j)] += weight;
            }
        }
        let found = self.solved(&rhs, true, monitor)?;
        for j in 0..of.len() {
            for (i, &point) in self.points.iter().enumerate() {
                sides[(point, j)] = -found[(i, j)];
            }
        }
        let by_drag = self.influence.transposed_along(&sides);
        let mut gradients = Vec::new();
        for (j, weights) in of.iter().enumerate() {
            let mut gradient = Given::nothing(n, m);
            for i in 0..n {
                gradient.gap[i] = sides[(i, j)];
            }
            for l in 0..m {
                gradient.work[l] = found[(k + l, j)];
            }
            for &i in &self.points {
                for axis in [0, 1] {
                    let mut sum = weights.traction[axis * n + i];
                    if let Some(product) = &by_drag[axis] {
                        sum += product[(i, j)];
                    }
                    for (motion, work) in self.state.motions.iter().zip(&gradient.work) {
                        let moved = [&motion.tangential_x, &motion.tangential_y][axis];
                        sum += work * self.state.area[i] * moved[i];
                    }
                    gradient.drag[axis * n + i] = self.state.pressure[i] * sum;
                }
            }
            gradients.push(gradient);
        }
        Ok(gradients)
    }

    /// The gradient by the friction coefficients (n), from that by all that is given.
    pub fn by_friction(&self, gradient: &Given) -> Vec<f64> {
        let n = self.count();
        let d = &self.state.direction;
        (0..n)
            .map(|i| d[i] * gradient.drag[i] + d[n + i] * gradient.drag[n + i])
            .collect()
    }

    /// The gradient by the direction of sliding (2n), from that by all that is given.
    pub fn by_direction(&self, gradient: &Given) -> Vec<f64> {
        let n = self.count();
        let along = gradient.drag.iter().enumerate();
        along.map(|(i, g)| g * self.state.friction[i % n]).collect()
    }

    /// What pressures and friction of the state open the gaps by (n) [m], without the diagonal.
    pub fn opening(&self) -> Vec<f64> {
        let n = self.count();
        let (p, mu, d) = (
            &self.state.pressure,
            &self.state.friction,
            &self.state.direction,
        );
        let pressure = Mat::from_fn(n, 1, |i, _| p[i]);
        let [x, y] = [0, 1].map(|axis| Mat::from_fn(n, 1, |i, _| d[axis * n + i] * mu[i] * p[i]));
        self.influence
            .products(&pressure, [&x, &y])
            .col_as_slice(0)
            .to_vec()
    }

    /// The factor on the friction up to which the sliding state exists and is unique for every load; infinite where
    /// friction does not open or close the gap. See [`definiteness_limit`].
    ///
    /// # Errors
    /// An interruption.
    pub fn wedging_factor(&self, monitor: Monitor<'_>) -> Result<f64, Error> {
        let n = self.count();
        let [x, y] = self.influence.along();
        if x.is_none() && y.is_none() {
            return Ok(f64::INFINITY);
        }
        let state = self.state;
        let drag = state.along(&state.friction);
        // columns of the stored blocks are those of the loaded points
        let mut scaled = vec![0.0; n * n];
        for (block, drag) in [x, y].into_iter().zip(drag.chunks_exact(n.max(1))) {
            let Some(block) = block else { continue };
            for (j, drag) in drag.iter().enumerate().filter(|(_, d)| **d != 0.0) {
                for i in 0..n {
                    scaled[i * n + j] += drag * block[j * n + i];
                }
            }
        }
        let held: Vec<f64> = (state.motions.iter())
            .flat_map(|motion| motion.opening.iter().zip(&state.area).map(|(o, a)| o * a))
            .collect();
        let stored = self.influence.normal();
        let mut normal: Vec<f64> = (0..n * n).map(|k| stored[(k % n) * n + k / n]).collect();
        for (i, own) in state.diagonal.iter().flatten().enumerate() {
            normal[i * n + i] += own;
        }
        Ok(definiteness_limit(
            &normal,
            &scaled,
            &state.area,
            Some(&held),
            monitor,
        )?)
    }

    /// The state.
    pub fn state(&self) -> &SlidingState {
        self.state
    }

    fn count(&self) -> usize {
        self.state.pressure.len()
    }

    /// Weights of pressures (n) that weights of gaps (n) amount to, a column each.
    fn pulled_back(&self, gap: &Mat<f64>) -> Mat<f64> {
        let n = self.count();
        let mut sum = self.influence.transposed_normal(gap);
        let along = self.influence.transposed_along(gap);
        for (axis, product) in along.iter().enumerate() {
            if let Some(product) = product {
                for j in 0..gap.ncols() {
                    for i in 0..n {
                        sum[(i, j)] += self.terms.drag[axis * n + i] * product[(i, j)];
                    }
                }
            }
        }
        sum
    }

    /// Work of tractions (2n) on a unit of a motion.
    fn work_of(&self, motion: &RigidMotion, traction: &[f64]) -> f64 {
        let n = self.count();
        (0..n)
            .map(|i| {
                self.state.area[i]
                    * (traction[i] * motion.tangential_x[i]
                        + traction[n + i] * motion.tangential_y[i])
            })
            .sum()
    }

    /// The solution of the equations, or of the transposed ones, for the columns of `rhs`.
    fn solved(
        &mut self,
        rhs: &Mat<f64>,
        transposed: bool,
        monitor: Monitor<'_>,
    ) -> Result<Mat<f64>, Error> {
        if self.points.len() < self.state.motions.len() {
            return Err(Error::Singular);
        }
        let mut x = self.factors.solve_many(rhs, &self.points, transposed);
        if !self.factors.is_exact(&self.terms) && !self.corrected(&mut x, transposed) {
            self.refactorise(monitor)?;
            x = self.factors.solve_many(rhs, &self.points, transposed);
        }
        if (0..x.ncols()).any(|j| x.col(j).iter().any(|v| !v.is_finite())) {
            return Err(Error::Singular);
        }
        Ok(x)
    }

    /// Improves `x` by the factors of a friction and a diagonal nearby; whether the equations hold then.
    fn corrected(&self, x: &mut Mat<f64>, transposed: bool) -> bool {
        let mut before = 1.0;
        let mut change = x.clone();
        for _ in 0..CORRECTIONS {
            let left = self.left_over(&change, transposed);
            change = self.factors.solve_many(&left, &self.points, transposed);
            *x += &change;
            // of each column by its own size, since rows have unlike units
            let worst = (0..x.ncols()).fold(0.0_f64, |worst, j| {
                let (change, size) = (change.col(j).norm_l2(), x.col(j).norm_l2());
                if size > 0.0 {
                    worst.max(change / size)
                } else {
                    worst
                }
            });
            // what the next one would be
            if worst * worst / before <= SOLVED {
                return true;
            }
            // it would take longer than new factors
            if worst.is_nan() || worst > 0.3 * before {
                return false;
            }
            before = worst;
        }
        false
    }

    /// What the factors' own equations leave of the right-hand sides whose solutions they say `x` to be: they differ
    /// from these by the influence of a change of the friction, and of the diagonal.
    fn left_over(&self, x: &Mat<f64>, transposed: bool) -> Mat<f64> {
        let (n, cases) = (self.count(), x.ncols());
        let then = self.factors.terms();
        let change = |axis: usize, point: usize| {
            self.terms.drag[axis * n + point] - then.drag[axis * n + point]
        };
        let mut left = Mat::zeros(x.nrows(), cases);
        for (i, &point) in self.points.iter().enumerate() {
            let own = self.terms.own(point) - then.own(point);
            for j in 0..cases {
                left[(i, j)] = -own * x[(i, j)];
            }
        }
        let mut spread = Mat::zeros(n, cases);
        for (i, &point) in self.points.iter().enumerate() {
            spread.row_mut(point).copy_from(x.row(i));
        }
        if transposed {
            let along = self.influence.transposed_along(&spread);
            for (axis, product) in along.iter().enumerate() {
                let Some(product) = product else { continue };
                for j in 0..cases {
                    for (i, &point) in self.points.iter().enumerate() {
                        left[(i, j)] -= change(axis, point) * product[(point, j)];
                    }
                }
            }
        } else {
            let [along, across] =
                [0, 1].map(|axis| Mat::from_fn(n, cases, |i, j| change(axis, i) * spread[(i, j)]));
            let none = Mat::zeros(n, cases);
            let opened = self.influence.products(&none, [&along, &across]);
            for j in 0..cases {
                for (i, &point) in self.points.iter().enumerate() {
                    left[(i, j)] -= opened[(point, j)];
                }
            }
        }
        left
    }
}

/// A linearised sliding state with factors of its own.
pub struct Linearised {
    influence: Arc<Influence>,
    state: SlidingState,
    factors: Bordered,
}

impl Linearised {
    /// Of the pair with these influence matrices.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, an interruption.
    pub fn new(
        influence: Arc<Influence>,
        state: SlidingState,
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let factors = factors_of(&influence, &state, monitor)?;
        Ok(Self {
            influence,
            state,
            factors,
        })
    }

    /// Its equations.
    ///
    /// # Errors
    /// An interruption.
    pub fn tangent(&mut self, monitor: Monitor<'_>) -> Result<Tangent<'_>, Error> {
        Tangent::new(&self.influence, &self.state, &mut self.factors, monitor)
    }
}

/// Factors of the equations of a state.
pub(super) fn factors_of(
    influence: &Influence,
    state: &SlidingState,
    monitor: Monitor<'_>,
) -> Result<Bordered, Error> {
    state.check(influence.points())?;
    let points = in_contact(&state.pressure);
    Ok(Bordered::new(influence, &state.terms(), &points, monitor)?)
}

fn in_contact(pressure: &[f64]) -> Vec<usize> {
    (0..pressure.len()).filter(|&i| pressure[i] > 0.0).collect()
}

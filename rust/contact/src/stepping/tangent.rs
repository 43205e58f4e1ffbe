// SPDX-License-Identifier: MIT OR Apache-2.0
//! A sliding state, linearised: how pressures, gaps and motions follow what is given, and the other way round.

use std::sync::Arc;

use faer::Mat;
use mtb_complementarity::linear::{Sides, definiteness_limit};
use mtb_operator::krylov::dot;
use mtb_operator::{Monitor, Relative};

use super::bordered::{Bordered, stacked};
use super::factored::Factored;
use super::influence::{Influence, Terms};
use super::products::Products;
use crate::error::{Error, check};
use crate::magnet::Pulling;
use crate::sliding::{RigidMotion, SlidingContact};

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
    /// pressure, and nothing where a layer yields.
    pub slope: Vec<f64>,
    /// Direction of sliding (2n).
    pub direction: Vec<f64>,
    /// The free motions.
    pub motions: Vec<RigidMotion>,
    /// Diagonal compliance (n) [m/Pa], the slope of a rough layer under the pressure included.
    pub diagonal: Option<Vec<f64>>,
    /// Hardness (n) [Pa]: where the pressure is as large, it stays.
    pub limit: Option<Vec<f64>>,
    /// The points (n) whose layer yields, so that neither pressure nor coefficient changes the size of their friction;
    /// empty where there is no such layer.
    pub yields: Vec<bool>,
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
    /// Pull of a magnet that follows the gap (n) [Pa], with all gaps held; empty: nothing.
    pub pull: Vec<f64>,
    /// Hardness (n) [Pa], which counts where the pressure is as large; empty: nothing.
    pub hardness: Vec<f64>,
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
    /// Pull of a magnet that follows the gap (n) [Pa]; empty: nothing, or no such magnet.
    pub pull: Vec<f64>,
}

impl Given {
    /// Nothing, of `points` and `motions`.
    pub fn nothing(points: usize, motions: usize) -> Self {
        Self {
            gap: vec![0.0; points],
            work: vec![0.0; motions],
            drag: vec![0.0; 2 * points],
            pull: Vec::new(),
            hardness: Vec::new(),
        }
    }

    /// Sum of the products of a change and a gradient: the change of the number that the gradient is of.
    pub fn dot(&self, gradient: &Self) -> f64 {
        dot(&self.gap, &gradient.gap)
            + dot(&self.work, &gradient.work)
            + dot(&self.drag, &gradient.drag)
            + dot(&self.pull, &gradient.pull)
            + dot(&self.hardness, &gradient.hardness)
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
            pull: Vec::new(),
        }
    }
}

impl SlidingState {
    fn check(&self, n: usize) -> Result<(), Error> {
        check("pressure", &self.pressure, n)?;
        check("slope", &self.slope, n)?;
        if let Some(limit) = &self.limit {
            check("hardness", limit, n)?;
        }
        let contact = self.contact(&self.pressure, &self.friction);
        contact.check(n)
    }

    /// Which points are closed and which are held at the hardness.
    pub(super) fn sides(&self) -> Sides {
        Sides::of_pressure(&self.pressure, self.limit.as_deref())
    }

    /// Leaves of changes of friction (2n), or of weights of it, what does not change its size where the layer yields.
    pub(super) fn turned(&self, drag: &mut [f64]) {
        let n = self.pressure.len();
        for i in (0..self.yields.len()).filter(|&i| self.yields[i]) {
            let (x, y) = (self.direction[i], self.direction[n + i]);
            let size = x * x + y * y;
            if size > 0.0 {
                let along = (drag[i] * x + drag[n + i] * y) / size;
                drag[i] -= along * x;
                drag[n + i] -= along * y;
            }
        }
    }

    /// The points whose gaps stay closed while their pressures change.
    fn closed(&self) -> Vec<usize> {
        self.sides().points()
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
            interface: None,
        }
    }

    /// A coefficient (n) times the direction (2n).
    fn along(&self, coefficient: &[f64]) -> Vec<f64> {
        let both = coefficient.iter().chain(coefficient);
        self.direction
            .iter()
            .zip(both)
            .map(|(d, c)| d * c)
            .collect()
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
    pub(super) form: Form<'a>,
    pub(super) state: &'a SlidingState,
    pub(super) points: Vec<usize>,
    pub(super) terms: Terms,
    pub(super) pulling: Option<&'a Pulling>,
}

/// What is known of the pair: its matrices, with factors of about the equations, or products alone.
pub(super) enum Form<'a> {
    Matrices(Factored<'a>),
    Products(&'a Products),
}

impl Form<'_> {
    /// Gaps (n) that pressures, and tractions along both tangents, open: a column each.
    fn products(&self, pressure: &Mat<f64>, traction: [&Mat<f64>; 2]) -> Mat<f64> {
        match self {
            Self::Matrices(factored) => factored.influence.products(pressure, traction),
            Self::Products(products) => products.products(pressure, traction),
        }
    }

    /// `C_nn^T gap` for a column each.
    pub(super) fn transposed_normal(&self, gap: &Mat<f64>) -> Mat<f64> {
        match self {
            Self::Matrices(factored) => factored.influence.transposed_normal(gap),
            Self::Products(products) => products.transposed_normal(gap),
        }
    }

    /// The same as [`Form::transposed_along`], which is kept for the next state.
    pub(super) fn kept_along(&mut self, axis: usize, gap: &Mat<f64>) -> Option<Mat<f64>> {
        match self {
            Self::Matrices(factored) => factored.transposed_along(axis, gap),
            Self::Products(products) => products.transposed_along(axis, gap),
        }
    }

    /// `C_nx^T gap` or `C_ny^T gap` for a column each; `None` where it does nothing.
    pub(super) fn transposed_along(&self, axis: usize, gap: &Mat<f64>) -> Option<Mat<f64>> {
        match self {
            Self::Matrices(factored) => factored.influence.transposed_along(axis, gap),
            Self::Products(products) => products.transposed_along(axis, gap),
        }
    }
}

/// The equations to solve: those of the points in contact of a state.
pub(super) struct Linear<'a> {
    pub(super) state: &'a SlidingState,
    pub(super) points: &'a [usize],
    pub(super) terms: &'a Terms,
}

impl Linear<'_> {
    /// The contact whose borders they have.
    pub(super) fn contact(&self) -> SlidingContact<'_> {
        self.state.contact(&self.state.pressure, &self.state.slope)
    }
}

impl<'a> Tangent<'a> {
    /// About `state`, with factors of about its equations, which are made new where they do not serve.
    pub(super) fn new(
        influence: &'a Influence,
        state: &'a SlidingState,
        factors: &'a mut Bordered,
    ) -> Result<Self, Error> {
        state.check(influence.points())?;
        Ok(Self::of(
            Form::Matrices(Factored::new(influence, factors)),
            state,
        ))
    }

    fn of(form: Form<'a>, state: &'a SlidingState) -> Self {
        Self {
            form,
            state,
            points: state.closed(),
            terms: state.terms(),
            pulling: None,
        }
    }

    /// The same under a magnet whose pull follows the gap.
    #[must_use]
    pub fn with_magnet(mut self, pulling: Option<&'a Pulling>) -> Self {
        self.pulling = pulling;
        self
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
        let mut answers = self.forward_held(changes, monitor)?;
        let Some(pulling) = self.pulling else {
            return Ok(answers);
        };
        for (change, answer) in changes.iter().zip(&mut answers) {
            let mut own = pulling.slopes().times(&answer.gap)?;
            if !change.pull.is_empty() {
                check("pull", &change.pull, own.len())?;
                own.iter_mut().zip(&change.pull).for_each(|(o, p)| *o += p);
            }
            let pull = Pulling::returned(
                &own,
                |pull| {
                    let gap = &self.under(pulling, pull, monitor)?.gap;
                    pulling.slopes().times(gap)
                },
                monitor,
            )?;
            let under = self.under(pulling, &pull, monitor)?;
            for (to, from) in [
                (&mut answer.pressure, &under.pressure),
                (&mut answer.traction, &under.traction),
                (&mut answer.gap, &under.gap),
                (&mut answer.motion, &under.motion),
            ] {
                to.iter_mut().zip(from).for_each(|(t, f)| *t += f);
            }
            answer.pull = pull;
        }
        Ok(answers)
    }

    /// What follows a change of the pull (n) that is given.
    fn under(
        &mut self,
        pulling: &Pulling,
        pull: &[f64],
        monitor: Monitor<'_>,
    ) -> Result<Found, Error> {
        let [gap, work] = pulling.loads(pull);
        let change = Given {
            gap,
            work,
            ..Given::nothing(self.count(), self.state.motions.len())
        };
        Ok(self.forward_held(&[change], monitor)?.remove(0))
    }

    /// The same with the pull of a magnet held.
    fn forward_held(
        &mut self,
        changes: &[Given],
        monitor: Monitor<'_>,
    ) -> Result<Vec<Found>, Error> {
        let (n, m, k) = (self.count(), self.state.motions.len(), self.points.len());
        let pressure = &self.state.pressure;
        let flows = self.state.sides().held;
        // pressures at the hardness change with it, and no others by themselves
        let mut held = Mat::zeros(n, changes.len());
        let mut drags = Vec::new();
        for (j, change) in changes.iter().enumerate() {
            check("gap", &change.gap, n)?;
            check("work", &change.work, m)?;
            check("drag", &change.drag, 2 * n)?;
            let along = pressure.iter().chain(pressure).zip(&change.drag);
            let mut drag: Vec<f64> = along.map(|(p, d)| d * p).collect();
            self.state.turned(&mut drag);
            if !change.hardness.is_empty() {
                check("hardness", &change.hardness, n)?;
                for i in (0..flows.len()).filter(|&i| flows[i]) {
                    held[(i, j)] = change.hardness[i];
                    for at in [i, n + i] {
                        drag[at] += self.terms.drag[at] * change.hardness[i];
                    }
                }
            }
            drags.push(drag);
        }
        // what the gaps do while the other pressures stay
        let [x, y] =
            [0, 1].map(|axis| stacked(drags.iter().map(|d| &d[axis * n..(axis + 1) * n]), n));
        let mut opened = self.form.products(&held, [&x, &y]);
        for (i, own) in self.terms.diagonal.iter().enumerate() {
            for j in 0..changes.len() {
                opened[(i, j)] += own * held[(i, j)];
            }
        }
        let mut rhs = Mat::zeros(k + m, changes.len());
        for (j, (change, drag)) in changes.iter().zip(&drags).enumerate() {
            let opened = opened.col_as_slice_mut(j);
            for (opened, gap) in opened.iter_mut().zip(&change.gap) {
                *opened += gap;
            }
            let (gaps, balances) = rhs.col_as_slice_mut(j).split_at_mut(k);
            for (gap, &point) in gaps.iter_mut().zip(&self.points) {
                *gap = -opened[point];
            }
            let given = balances.iter_mut().zip(&change.work);
            for ((balance, work), motion) in given.zip(&self.state.motions) {
                *balance = work
                    + self.work_of(motion, drag)
                    + self.work_of_pressure(motion, held.col_as_slice(j));
            }
        }
        let found = self.solved(&rhs, false, monitor)?;
        let mut pressure = Mat::zeros(n, changes.len());
        for j in 0..changes.len() {
            let to = pressure.col_as_slice_mut(j);
            for (&point, p) in self.points.iter().zip(found.col_as_slice(j)) {
                to[point] = *p;
            }
        }
        let [x, y] = [0, 1].map(|axis| {
            let mut along = pressure.clone();
            for j in 0..changes.len() {
                let drag = &self.terms.drag[axis * n..(axis + 1) * n];
                for (p, drag) in along.col_as_slice_mut(j).iter_mut().zip(drag) {
                    *p *= drag;
                }
            }
            along
        });
        opened += self.form.products(&pressure, [&x, &y]);
        let mut answers = Vec::new();
        for (j, mut traction) in drags.into_iter().enumerate() {
            let moved = x.col_as_slice(j).iter().chain(y.col_as_slice(j));
            for (traction, moved) in traction.iter_mut().zip(moved) {
                *traction += moved;
            }
            let motion = found.col_as_slice(j)[k..].to_vec();
            let mut gap = opened.col_as_slice(j).to_vec();
            for (motion, c) in self.state.motions.iter().zip(&motion) {
                for (gap, opening) in gap.iter_mut().zip(&motion.opening) {
                    *gap += opening * c;
                }
            }
            for &point in &self.points {
                gap[point] = 0.0;
            }
            let moved = pressure.col_as_slice(j).iter().zip(held.col_as_slice(j));
            answers.push(Found {
                pressure: moved.map(|(p, held)| p + held).collect(),
                traction,
                gap,
                motion,
                pull: Vec::new(),
            });
        }
        Ok(answers)
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
        self.form
            .products(&pressure, [&x, &y])
            .col_as_slice(0)
            .to_vec()
    }

    /// The factor on the friction up to which the sliding state exists and is unique for every load; infinite where
    /// friction does not open or close the gap. See [`definiteness_limit`]. Not a number where it is not known: by
    /// products, where friction opens or closes the gap.
    ///
    /// # Errors
    /// An interruption.
    pub fn wedging_factor(&self, monitor: Monitor<'_>) -> Result<f64, Error> {
        let n = self.count();
        let influence = match &self.form {
            Form::Matrices(factored) => factored.influence,
            Form::Products(products) if products.is_coupled() => return Ok(f64::NAN),
            Form::Products(_) => return Ok(f64::INFINITY),
        };
        let [x, y] = influence.along();
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
        let stored = influence.normal();
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

    pub(super) fn count(&self) -> usize {
        self.state.pressure.len()
    }

    /// Work of tractions (2n) on a unit of a motion.
    fn work_of(&self, motion: &RigidMotion, traction: &[f64]) -> f64 {
        let (along, across) = traction.split_at(self.count());
        let moved = motion.tangential_x.iter().zip(&motion.tangential_y);
        let work = along.iter().zip(across).zip(moved).zip(&self.state.area);
        work.map(|(((along, across), (x, y)), area)| area * (along * x + across * y))
            .sum()
    }

    /// Work of pressures (n) on a unit of a motion.
    fn work_of_pressure(&self, motion: &RigidMotion, pressure: &[f64]) -> f64 {
        let opened = motion.opening.iter().zip(&self.state.area);
        let work = pressure.iter().zip(opened);
        work.map(|(p, (opening, area))| area * opening * p).sum()
    }

    /// The solution of the equations, or of the transposed ones, for the columns of `rhs`.
    pub(super) fn solved(
        &mut self,
        rhs: &Mat<f64>,
        transposed: bool,
        monitor: Monitor<'_>,
    ) -> Result<Mat<f64>, Error> {
        if self.points.len() < self.state.motions.len() {
            return Err(Error::Singular);
        }
        let of = Linear {
            state: self.state,
            points: &self.points,
            terms: &self.terms,
        };
        let x = match &mut self.form {
            Form::Matrices(factored) => factored.solved(&of, rhs, transposed, monitor)?,
            Form::Products(products) => products.solved(&of, rhs, transposed, monitor)?,
        };
        if (0..x.ncols()).any(|j| x.col_as_slice(j).iter().any(|v| !v.is_finite())) {
            return Err(Error::Singular);
        }
        Ok(x)
    }
}

/// A linearised sliding state with factors of its own, or without a matrix.
pub struct Linearised {
    known: Known,
    state: SlidingState,
    pulling: Option<Pulling>,
}

enum Known {
    Matrices(Arc<Influence>, Box<Bordered>),
    Products(Products),
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
        let factors = Box::new(factors_of(&influence, &state, monitor)?);
        let known = Known::Matrices(influence, factors);
        Ok(Self {
            known,
            state,
            pulling: None,
        })
    }

    /// Of a pair of which products alone are taken, with the transposed influence too: for many points, and bodies
    /// whose products are fast and that know their [reciprocity](mtb_operator::Compliance::reciprocity). Unless it
    /// `is_coupled`, friction opens and closes no gap.
    ///
    /// The equations are solved by GMRES, of one answer after the other.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite.
    pub fn by_products(
        pair: Relative,
        state: SlidingState,
        is_coupled: bool,
    ) -> Result<Self, Error> {
        let products = Products::new(pair, is_coupled);
        state.check(products.points())?;
        let known = Known::Products(products);
        Ok(Self {
            known,
            state,
            pulling: None,
        })
    }

    /// The same under a magnet whose pull follows the gap.
    #[must_use]
    pub fn with_magnet(mut self, pulling: Option<Pulling>) -> Self {
        self.pulling = pulling;
        self
    }

    /// The magnet, linearised.
    pub fn pulling(&self) -> Option<&Pulling> {
        self.pulling.as_ref()
    }

    /// The state.
    pub fn state(&self) -> &SlidingState {
        &self.state
    }

    /// Its equations.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite.
    pub fn tangent(&mut self) -> Result<Tangent<'_>, Error> {
        let tangent = match &mut self.known {
            Known::Matrices(influence, factors) => Tangent::new(influence, &self.state, factors)?,
            Known::Products(products) => Tangent::of(Form::Products(products), &self.state),
        };
        Ok(tangent.with_magnet(self.pulling.as_ref()))
    }
}

/// Factors of the equations of a state.
pub(super) fn factors_of(
    influence: &Influence,
    state: &SlidingState,
    monitor: Monitor<'_>,
) -> Result<Bordered, Error> {
    state.check(influence.points())?;
    let points = state.closed();
    Ok(Bordered::new(influence, &state.terms(), &points, monitor)?)
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contact problem: two bodies that meet in points, and all that can be asked of them.
//!
//! A [`Problem`] is what stays while loads change: the bodies as compliances, the contact points, the rigid
//! motions that supports leave free. A [`Loading`] is the gap and the work that loads do on these motions;
//! [`Problem::load`] puts a [`Load`] into it. Then the bodies can be pressed without friction
//! ([`Problem::press`]), slide with friction everywhere ([`Problem::slide`]), or give way from rest, with
//! points that stick and points that slip ([`Problem::stick_or_slip`]). Each answers with an [`Outcome`].
//! A simulation asks the same of [`prepared`](crate::prepared).

mod attracted;
mod geometry;
mod heating;
mod loading;
mod outcome;
#[cfg(test)]
mod tests;

use std::sync::{Arc, Mutex, PoisonError};

use mtb_complementarity::linear::Status;
use mtb_operator::{Compliance, Monitor, Relative};

use crate::coupled::{Coupled, CoupledContact, PATH_TOLERANCE};
use crate::error::{Error, check};
use crate::interface::Interface;
use crate::sliding::{PRODUCTS_FROM, SlidingContact, SlidingMatrix};
use crate::stepping::{Influence, Linearised, SlidingState};
pub use geometry::{Geometry, Means, Window};
use heating::LastExchange;
pub use heating::{Heated, Heating};
pub use loading::{Attracted, Body, FreeMotion, Load, Loading};
pub use outcome::{Outcome, Slipped};

/// Relative change of a friction coefficient that follows the pressure which counts as none ...
const FRICTION_TOLERANCE: f64 = 1e-10;
/// ... and solves after which it must have settled.
const FRICTION_ROUNDS: usize = 60;

/// A law of friction by which the coefficient (n) follows the pressure (n) [Pa].
pub type PressureLaw<'a> = &'a (dyn Fn(&[f64]) -> Result<Vec<f64>, Error> + Sync);

/// Friction between the bodies.
#[derive(Clone, Copy)]
pub enum Friction<'a> {
    /// A coefficient at each point (n).
    Field(&'a [f64]),
    /// Coefficients that follow the pressure.
    OfPressure(PressureLaw<'a>),
}

/// Two bodies that meet in contact points.
///
/// The influence matrices of the last direction of sliding are kept, so that further loads cost their solve
/// alone.
pub struct Problem {
    pair: Relative,
    geometry: Arc<Geometry>,
    motions: Vec<FreeMotion>,
    kept: Mutex<Option<Arc<Kept>>>,
    exchange: Mutex<Option<LastExchange>>,
    products_from: usize,
    interface: Interface,
}

/// The matrices of sliding in a direction.
struct Kept {
    direction: Vec<f64>,
    is_frictional: bool,
    matrix: SlidingMatrix,
}

impl Problem {
    /// The bodies, the points in which they meet, and the motions that are free.
    ///
    /// # Errors
    /// Parts that do not belong together, numbers that are not finite.
    pub fn new(
        pair: Relative,
        geometry: Arc<Geometry>,
        motions: Vec<FreeMotion>,
    ) -> Result<Self, Error> {
        let n = pair.points();
        check("area", &geometry.area, n)?;
        geometry.check()?;
        for free in &motions {
            check("opening", &free.motion.opening, n)?;
            check("tangential_x", &free.motion.tangential_x, n)?;
            check("tangential_y", &free.motion.tangential_y, n)?;
        }
        Ok(Self {
            pair,
            geometry,
            motions,
            kept: Mutex::new(None),
            exchange: Mutex::new(None),
            products_from: PRODUCTS_FROM,
            interface: Interface::default(),
        })
    }

    /// The same problem with a hardness, a rough layer, or both.
    ///
    /// # Errors
    /// As [`Interface::check`].
    pub fn with_interface(mut self, interface: Interface) -> Result<Self, Error> {
        interface.check(self.points())?;
        self.interface = interface;
        Ok(self)
    }

    /// What lies between the bodies beyond springs.
    pub fn interface(&self) -> &Interface {
        &self.interface
    }

    /// The same problem, solved by products from so many points on instead of [`PRODUCTS_FROM`].
    #[must_use]
    pub fn by_products_from(mut self, points: usize) -> Self {
        self.products_from = points;
        self
    }

    /// The bodies.
    pub fn pair(&self) -> &Relative {
        &self.pair
    }

    /// The contact points.
    pub fn geometry(&self) -> &Arc<Geometry> {
        &self.geometry
    }

    /// Number of contact points.
    pub fn points(&self) -> usize {
        self.geometry.points()
    }

    /// The motions that are free.
    pub fn motions(&self) -> &[FreeMotion] {
        &self.motions
    }

    fn matrix(
        &self,
        direction: &[f64],
        is_frictional: bool,
        monitor: Monitor<'_>,
    ) -> Result<Arc<Kept>, Error> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(kept) = &*kept
            && kept.direction == direction
            && kept.is_frictional == is_frictional
        {
            return Ok(kept.clone());
        }
        // the old ones go before the new ones come
        *kept = None;
        let made = Arc::new(Kept {
            direction: direction.to_vec(),
            is_frictional,
            matrix: if self.is_by_products() {
                SlidingMatrix::by_products(Arc::new(self.pair.clone()), direction, is_frictional)?
            } else {
                SlidingMatrix::new(&self.pair, direction, is_frictional, monitor)?
            },
        });
        *kept = Some(made.clone());
        Ok(made)
    }

    /// Whether it is solved by products, and no matrix is formed: it has many points, and a body that
    /// [prefers](Compliance::prefers_products) them.
    pub fn is_by_products(&self) -> bool {
        self.points() >= self.products_from && self.pair.prefers_products()
    }

    /// Forms the matrices of sliding in `direction` (2n), with friction or without; whether friction opens or
    /// closes the gap at all.
    ///
    /// # Errors
    /// As [`Problem::slide`].
    pub fn prepare(
        &self,
        direction: &[f64],
        is_frictional: bool,
        monitor: Monitor<'_>,
    ) -> Result<bool, Error> {
        let kept = self.matrix(direction, is_frictional, monitor)?;
        Ok(kept.matrix.is_coupled())
    }

    /// Presses the bodies together without friction.
    ///
    /// # Errors
    /// As [`Problem::slide`].
    pub fn press(&self, loading: &Loading, monitor: Monitor<'_>) -> Result<Outcome, Error> {
        let n = self.points();
        let (still, smooth) = (vec![0.0; 2 * n], vec![0.0; n]);
        self.slide(loading, &still, Friction::Field(&smooth), None, monitor)
    }

    /// Lets the upper body slide in `direction` (2n), with friction at every point in contact.
    ///
    /// `start` are the points believed in contact, for example those of the last load.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, negative friction, more points than the memory holds,
    /// [`Error::Interrupted`]. A state that does not exist is a status.
    pub fn slide(
        &self,
        loading: &Loading,
        direction: &[f64],
        friction: Friction<'_>,
        start: Option<Vec<bool>>,
        monitor: Monitor<'_>,
    ) -> Result<Outcome, Error> {
        let n = self.points();
        self.check(loading)?;
        check("direction", direction, 2 * n)?;
        let at = |pressure: &[f64]| match friction {
            Friction::Field(field) => Ok(field.to_vec()),
            Friction::OfPressure(law) => law(pressure),
        };
        let mut coefficient = at(&vec![0.0; n])?;
        let is_frictional = direction.iter().any(|d| *d != 0.0)
            && match friction {
                Friction::Field(field) => field.iter().any(|mu| *mu != 0.0),
                Friction::OfPressure(_) => true,
            };
        let kept = self.matrix(direction, is_frictional, monitor)?;
        let motions = self.loaded(&loading.work);
        let none = vec![0.0; n];
        let mut active = start;
        let (mut iterations, mut round) = (0, 0);
        loop {
            let contact = SlidingContact {
                gap: &loading.gap,
                area: &self.geometry.area,
                friction: if is_frictional { &coefficient } else { &none },
                direction,
                motions: &motions,
                diagonal: loading.diagonal.as_deref(),
                interface: Some(&self.interface),
            };
            let mut solution = kept.matrix.solve(&contact, active, monitor)?;
            iterations += solution.iterations;
            round += 1;
            let now = at(&solution.pressure)?;
            check("friction", &now, n)?;
            let change = now.iter().zip(&coefficient).map(|(a, b)| (a - b).abs());
            let change = change.fold(0.0, f64::max);
            let size = now.iter().copied().fold(1.0, f64::max);
            let has_settled = change <= FRICTION_TOLERANCE * size;
            coefficient = now;
            if has_settled || round == FRICTION_ROUNDS {
                if !has_settled {
                    solution.status = Status::IterationLimit;
                }
                solution.iterations = iterations;
                let about = [0.0; 3];
                let coefficient = self.interface.coefficients(coefficient, &solution.pressure);
                return Ok(Outcome::sliding(
                    &self.geometry,
                    about,
                    solution,
                    coefficient,
                    direction,
                ));
            }
            active = (solution.status == Status::Solved)
                .then(|| solution.pressure.iter().map(|p| *p > 0.0).collect());
        }
    }

    /// The factor on `friction` (n) up to which the sliding state exists and is unique for every load; see
    /// [`SlidingMatrix::wedging_factor`].
    ///
    /// # Errors
    /// As [`Problem::slide`].
    pub fn wedging_factor(
        &self,
        direction: &[f64],
        friction: &[f64],
        diagonal: Option<&[f64]>,
        monitor: Monitor<'_>,
    ) -> Result<f64, Error> {
        let is_frictional = direction.iter().any(|d| *d != 0.0);
        let kept = self.matrix(direction, is_frictional, monitor)?;
        let motions = self.loaded(&vec![0.0; self.motions.len()]);
        kept.matrix
            .wedging_factor(&self.geometry.area, friction, &motions, diagonal, monitor)
    }

    /// The equations of a sliding state, linearised about it: `pressure` (n) [Pa], `friction` (n) and the `slope` (n)
    /// of friction times pressure over the pressure, which is the friction itself unless it follows the pressure.
    /// Its `diagonal` (n) [m/Pa] is that of the loading; a rough layer adds its slope, and where a layer yields friction has none. Unless it `is_coupled`, friction
    /// opens and closes no gap. No matrix is formed `by_products`, and of a problem that
    /// [is so itself](Problem::is_by_products).
    ///
    /// # Errors
    /// As [`Problem::slide`].
    #[allow(clippy::too_many_arguments, reason = "a state of the contact")]
    pub fn linearised(
        &self,
        pressure: &[f64],
        friction: &[f64],
        slope: &[f64],
        direction: &[f64],
        diagonal: Option<&[f64]>,
        is_coupled: bool,
        by_products: bool,
        monitor: Monitor<'_>,
    ) -> Result<Linearised, Error> {
        let (yields, slope) = self.interface.yields(friction, pressure, slope);
        let state = SlidingState {
            area: self.geometry.area.clone(),
            pressure: pressure.to_vec(),
            friction: friction.to_vec(),
            slope,
            direction: direction.to_vec(),
            motions: self.loaded(&vec![0.0; self.motions.len()]),
            diagonal: self.interface.softened(diagonal, pressure),
            limit: self.interface.limit.clone(),
            yields,
        };
        if by_products || self.is_by_products() {
            return Linearised::by_products(self.pair.clone(), state, is_coupled);
        }
        let influence = if is_coupled {
            Influence::of(&self.pair, monitor)?
        } else {
            Influence::uncoupled(&self.pair, monitor)?
        };
        Linearised::new(Arc::new(influence), state, monitor)
    }

    /// Presses the bodies together without friction, then displaces the points of the upper body in steps to
    /// each of `displacements` (3n) [m], common frame, such as [`Geometry::uniform`]: points stick until friction
    /// `friction` (n) gives way, and the pressure follows.
    ///
    /// A `layer` [m/Pa] between the bodies softens the tangents; a diagonal compliance of the loading, a hardness and a
    /// rough layer are refused.
    /// One outcome a step; the steps end where no state was found. Each step is reached in parts, so many of them that it adds an error of at most
    /// [`PATH_TOLERANCE`]; see [`CoupledContact::follow`].
    ///
    /// # Errors
    /// As [`Problem::slide`] and [`CoupledContact::new`].
    pub fn stick_or_slip(
        &self,
        loading: &Loading,
        friction: &[f64],
        layer: f64,
        displacements: &[Vec<f64>],
        tolerance: f64,
        monitor: Monitor<'_>,
    ) -> Result<Vec<Outcome>, Error> {
        let g = &*self.geometry;
        let n = g.points();
        if loading.diagonal.is_some() {
            return Err(Error::NoDiagonal);
        }
        if !self.interface.is_empty() {
            return Err(Error::NoInterface);
        }
        let pressed = self.press(loading, monitor)?;
        if pressed.solution.status != Status::Solved {
            return Ok(vec![pressed]);
        }
        let motions = self.loaded(&loading.work);
        let contact = CoupledContact::new(
            &Coupled {
                compliance: &self.pair,
                layer,
                area: &g.area,
                friction,
                gap: &loading.gap,
                motions: &motions,
            },
            tolerance,
            monitor,
        )?;
        let rest = contact.at_rest(&pressed.solution.pressure, &pressed.solution.motion)?;
        let mut pushes = Vec::new();
        for displacement in displacements {
            check("displacement", displacement, 3 * n)?;
            // what motions of the bodies see: under hats the means of their frames
            pushes.push(
                g.mean_frame
                    .each_ref()
                    .map(|axes| g.along(axes, displacement, 1.0))
                    .concat(),
            );
        }
        let found = contact.follow(&rest, &pushes, PATH_TOLERANCE, monitor)?;
        let outcome =
            |status, state| Outcome::coupled(g, [0.0; 3], status, &contact, state, friction);
        let mut outcomes: Vec<Outcome> = found.iter().map(|s| outcome(Status::Solved, s)).collect();
        if found.len() < pushes.len() {
            outcomes.push(outcome(
                Status::IterationLimit,
                found.last().unwrap_or(&rest),
            ));
        }
        Ok(outcomes)
    }
}

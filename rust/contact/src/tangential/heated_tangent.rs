// SPDX-License-Identifier: MIT OR Apache-2.0
//! Derivatives of steady rolling whose friction follows the temperature of the surfaces.
//!
//! With the coefficients given, everything follows from what is given as under Coulomb's friction; the coefficients
//! follow the heat and the slip. Both are linear near the state, `c = g + F R(given, c)`, so that one more linear
//! problem, in the coefficients alone, gives their change; its transpose gives the derivatives by everything. A product
//! of either is a linear solve of the tractions.

use mtb_operator::Monitor;
use mtb_operator::krylov::{dot, gmres};

use super::change::{TangentialChange, TangentialResponse};
use super::dissipation::heat_of;
use super::heated::Heated;
use super::tangent::{TangentialTangent, add};
use crate::Error;
use crate::friction::{Friction, Memory, Past};

/// Residual, over that of no step, at which the coefficients count as found, and the one that is needed.
const ENOUGH: f64 = 1e-11;
const NEEDED: f64 = 1e-10;
/// Most linear solves of the tractions.
const SOLVES: usize = 60;
/// Rise, over the largest one, below which a surface has not been heated but for rounding: at a point of the table the
/// slope is that of warmer surfaces.
const COLD: f64 = 1e-9;

/// What the coefficients become by changes of them, with the tangent `T` of given ones.
type Image<'a, T> = dyn FnMut(&mut T, &[f64]) -> Result<Vec<f64>, Error> + 'a;

/// How the coefficients follow heat and slip about a state.
pub(super) struct Following<'a> {
    heated: Heated<'a>,
    points: usize,
    speed: f64,
    /// Rise of each cell in contact [K], and the slope of the law there [1/K].
    rise: Vec<f64>,
    slope: Vec<f64>,
    remembering: Option<Remembering>,
}

/// How particles follow the law at a state.
struct Remembering {
    memory: Memory,
    past: Past,
    /// Slip speed (n) [m/s], and the direction of the slip (2n) where it is above the least one of the memory.
    slip_speed: Vec<f64>,
    direction: Vec<f64>,
    /// How far particles follow in a step (n), how that goes with their slip speed (n) [s/m], and how far the law is
    /// from them (n).
    rate: Vec<f64>,
    by_speed: Vec<f64>,
    lag: Vec<f64>,
}

impl<'a> Following<'a> {
    fn new(tangent: &TangentialTangent<'a>, heated: Heated<'a>) -> Self {
        let (problem, state) = (tangent.problem, tangent.state);
        let n = problem.pressure.len();
        let heat = heat_of(
            tangent.operators,
            problem,
            &state,
            &tangent.slip_at_faces,
            heated.around,
        );
        let mut rise = heated.rise(&heat);
        let steady = heated.steady(&rise);
        let largest = rise.iter().copied().fold(0.0, f64::max);
        for rise in &mut rise {
            if rise.abs() <= COLD * largest {
                *rise = 0.0;
            }
        }
        let (law, cold) = (heated.law, heated.law.cold());
        let remembering = law.memory.map(|memory| {
            let past = Past::Upstream(heated.upstream());
            let size = |k: usize| state.slip[k].hypot(state.slip[n + k]);
            let slip_speed: Vec<f64> = (0..n).map(|k| problem.speed * size(k)).collect();
            let rates: Vec<(f64, f64)> = slip_speed
                .iter()
                .map(|speed| memory.rate(*speed, past.time()))
                .collect();
            let part = |k: usize| {
                let (_, by_speed) = rates[k % n];
                if by_speed > 0.0 {
                    state.slip[k] / size(k % n)
                } else {
                    0.0
                }
            };
            Remembering {
                direction: (0..2 * n).map(part).collect(),
                rate: rates.iter().map(|(rate, _)| *rate).collect(),
                by_speed: rates.iter().map(|(_, by_speed)| *by_speed).collect(),
                lag: (0..n).map(|k| steady[k] - state.coefficient[k]).collect(),
                memory,
                past,
                slip_speed,
            }
        });
        Self {
            points: n,
            speed: problem.speed,
            slope: rise.iter().map(|rise| law.slope(cold + rise)).collect(),
            rise,
            heated,
            remembering,
        }
    }

    /// Changes of the coefficients (n) by those of heat and slip.
    fn follow(&self, found: &TangentialResponse) -> Vec<f64> {
        let n = found.coefficient.len();
        let mut change = vec![0.0; n];
        let warmer = self.heated.rise(&found.dissipation);
        for (place, k) in self.heated.touching.iter().enumerate() {
            change[*k] = self.slope[place] * warmer[place];
        }
        if let Some(own) = &self.remembering {
            for k in 0..n {
                let along =
                    own.direction[k] * found.slip[k] + own.direction[n + k] * found.slip[n + k];
                change[k] =
                    own.rate[k] * change[k] + own.lag[k] * own.by_speed[k] * self.speed * along;
            }
        }
        self.pass_on(&mut change);
        change
    }

    /// The transpose of [`Following::follow`]: adds to the weights of heat and slip.
    fn weigh(&self, weights: &[f64], found: &mut TangentialResponse) {
        let n = weights.len();
        let mut back = self.pass_back(weights);
        if let Some(own) = &self.remembering {
            for k in 0..n {
                let along = own.lag[k] * own.by_speed[k] * self.speed * back[k];
                found.slip[k] += along * own.direction[k];
                found.slip[n + k] += along * own.direction[n + k];
                back[k] *= own.rate[k];
            }
        }
        let touching = self.heated.touching.iter().zip(&self.slope);
        let of_rise: Vec<f64> = touching.map(|(k, slope)| slope * back[*k]).collect();
        self.heated.weigh(&of_rise, &mut found.dissipation);
    }

    /// Changes of the coefficients from those of the right sides of their equations, in place.
    fn pass_on(&self, change: &mut [f64]) {
        if let Some(own) = &self.remembering {
            own.memory.pass_on(&own.past, &own.slip_speed, change);
        }
    }

    /// The transpose of [`Following::pass_on`], in contact.
    fn pass_back(&self, weights: &[f64]) -> Vec<f64> {
        let mut back = vec![0.0; weights.len()];
        for k in &self.heated.touching {
            back[*k] = weights[*k];
        }
        if let Some(own) = &self.remembering {
            own.memory.pass_back(&own.past, &own.slip_speed, &mut back);
        }
        back
    }

    /// What the right sides of the equations of the coefficients gain by each parameter of the law, (n) each.
    fn by_law(&self) -> Vec<Vec<f64>> {
        let law = self.heated.law;
        let rest = law.parameters(0.0);
        let mut columns = vec![vec![0.0; self.points]; rest.len()];
        let mut by_speed = vec![0.0; self.points];
        let mut of_memory = [vec![0.0; self.points], vec![0.0; self.points]];
        for (place, &k) in self.heated.touching.iter().enumerate() {
            let slopes = law.parameters(self.rise[place]);
            // heat goes with the speed, and what it warms with the inverse of its root
            let faster = 0.5 * self.slope[place] * self.rise[place];
            let Some(own) = &self.remembering else {
                for (column, slope) in columns.iter_mut().zip(slopes) {
                    column[k] = slope;
                }
                by_speed[k] = faster;
                continue;
            };
            let (rate, lag) = (own.rate[k], own.lag[k]);
            let outside = own.past.share_of_rest(k);
            for ((column, slope), rest) in columns.iter_mut().zip(slopes).zip(&rest) {
                column[k] = rate * slope + outside * rest;
            }
            by_speed[k] = rate * faster;
            of_memory[0][k] = -lag * rate / own.memory.distance;
            if own.by_speed[k] == 0.0 {
                of_memory[1][k] = lag * rate / own.memory.min_slip;
                // faster, a step takes less time
                by_speed[k] -= lag * rate;
            }
        }
        if self.remembering.is_some() {
            columns.extend(of_memory);
        }
        columns.push(by_speed);
        columns
    }
}

impl<'a> TangentialTangent<'a> {
    /// How the coefficients follow heat and slip; `None` for friction that does not follow the temperature.
    pub(super) fn following(&self) -> Result<Option<Following<'a>>, Error> {
        let Friction::TemperatureDependent(law) = self.problem.friction else {
            return Ok(None);
        };
        let heated = Heated::new(self.operators, self.problem, law, self.around)?;
        Ok(Some(Following::new(self, heated)))
    }

    /// What the coefficients of friction (n) that follow the temperature change by with the direction of rolling, with
    /// the heat held; 0 for other friction.
    ///
    /// # Errors
    /// [`Error::NoTemperature`].
    pub fn coefficient_by_angle(&self) -> Result<Vec<f64>, Error> {
        let mut change = vec![0.0; self.problem.pressure.len()];
        if let Some(following) = self.following()? {
            let heated = &following.heated;
            let heat = heat_of(
                self.operators,
                self.problem,
                &self.state,
                &self.slip_at_faces,
                heated.around,
            );
            let turned = heated.rise_by_angle(&heat);
            for (place, k) in heated.touching.iter().enumerate() {
                change[*k] = following.slope[place] * turned[place];
            }
        }
        Ok(change)
    }

    /// [`TangentialTangent::forward`] where coefficients follow.
    pub(super) fn forward_following(
        &mut self,
        following: &Following<'_>,
        change: &TangentialChange,
        monitor: Monitor<'_>,
    ) -> Result<TangentialResponse, Error> {
        let mut given = change.clone();
        given.coefficient = self.in_contact(&change.coefficient);
        for (column, value) in following.by_law().iter().zip(&change.law) {
            add(&mut given.coefficient, *value, column);
        }
        following.pass_on(&mut given.coefficient);
        let at_first = self.forward_held(&given, monitor)?;
        let right = following.follow(&at_first);
        let none = self.no_change();
        let more = self.settled(right, &mut |tangent, coefficient| {
            let given = TangentialChange {
                coefficient: coefficient.to_vec(),
                ..none.clone()
            };
            Ok(following.follow(&tangent.forward_held(&given, monitor)?))
        })?;
        add(&mut given.coefficient, 1.0, &more);
        self.forward_held(&given, monitor)
    }

    /// [`TangentialTangent::adjoint`] where coefficients follow.
    pub(super) fn adjoint_following(
        &mut self,
        following: &Following<'_>,
        weights: &TangentialResponse,
        monitor: Monitor<'_>,
    ) -> Result<TangentialChange, Error> {
        let n = weights.coefficient.len();
        let none = TangentialResponse {
            traction: vec![0.0; 2 * n],
            slip: vec![0.0; 2 * n],
            coefficient: vec![0.0; n],
            drive: [0.0; 2],
            dissipation: vec![0.0; weights.dissipation.len()],
            plastic_share: Vec::new(),
            accumulated: Vec::new(),
        };
        let mut back = |tangent: &mut Self, coefficient: &[f64]| {
            let mut weights = none.clone();
            following.weigh(coefficient, &mut weights);
            Ok(tangent.adjoint_held(&weights, monitor)?.coefficient)
        };
        let mut of_coefficient = self.adjoint_held(weights, monitor)?.coefficient;
        let right = back(self, &of_coefficient)?;
        let more = self.settled(right, &mut back)?;
        add(&mut of_coefficient, 1.0, &more);
        let mut whole = weights.clone();
        following.weigh(&of_coefficient, &mut whole);
        let mut change = self.adjoint_held(&whole, monitor)?;
        change.coefficient = following.pass_back(&of_coefficient);
        let columns = following.by_law();
        change.law = columns
            .iter()
            .map(|column| dot(column, &change.coefficient))
            .collect();
        Ok(change)
    }

    /// The coefficients `c` with `c = right + map(c)`.
    fn settled(&mut self, right: Vec<f64>, map: &mut Image<'_, Self>) -> Result<Vec<f64>, Error> {
        let start = dot(&right, &right).sqrt();
        let mut found = vec![0.0; right.len()];
        let mut residual = right;
        let mut failed = None;
        let apply = |coefficient: &[f64], image: &mut [f64]| {
            image.copy_from_slice(coefficient);
            if failed.is_some() {
                return;
            }
            match map(self, coefficient) {
                Ok(mapped) => add(image, -1.0, &mapped),
                Err(error) => failed = Some(error),
            }
        };
        let krylov = gmres(
            apply,
            |coefficient, out| out.copy_from_slice(coefficient),
            &mut found,
            &mut residual,
            ENOUGH * start,
            SOLVES,
        );
        match failed {
            Some(error) => Err(error),
            None if krylov.residual <= NEEDED * start => Ok(found),
            None => Err(Error::Singular),
        }
    }
}

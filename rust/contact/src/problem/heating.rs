// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sliding with the heat of friction: one implicit step of the time.

use std::sync::{Arc, PoisonError};

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef};
use mtb_complementarity::linear::Status;
use mtb_operator::dense::{Lu, threads};
use mtb_operator::{Monitor, check_factors};

use super::{Kept, Loading, Outcome, Problem};
use crate::error::{Error, check, check_number};
use crate::sliding::SlidingContact;

/// Sets of points in contact after which points that have opened go on exchanging heat, so that the sets only grow.
pub(super) const ROUNDS: usize = 5;

/// What heat does to both bodies over one step of the time; the lower body first. Matrices are (n, n), row-major.
#[derive(Clone, Copy, Debug)]
pub struct Heating<'a> {
    /// Temperature [K m2/W] of the points at the end of the step by a unit flux into each.
    pub response: [&'a [f64]; 2],
    /// Opening of the gap [m3/W] by a unit flux into each point, thermal expansion; `None`: heat opens no gap. What
    /// earlier heat opens is part of the loading.
    pub opening: Option<[&'a [f64]; 2]>,
    /// Temperature (n) [K] at the end of the step without any flux.
    pub before: [&'a [f64]; 2],
    /// Speed of sliding of each point in its tangent plane (n) [m/s].
    pub speed: &'a [f64],
    /// Thermal resistance [K m2/W] between the surfaces in contact.
    pub resistance: f64,
    /// Share of the heat of friction that arises on the upper side of that resistance.
    pub share: f64,
}

/// A heated sliding state; the lower body first.
#[derive(Clone, Debug)]
pub struct Heated {
    /// The state.
    pub outcome: Outcome,
    /// Heat that enters the bodies (n) [W/m2]; the sum of both is that of friction.
    pub flux: [Vec<f64>; 2],
    /// Temperatures of the points (n) [K] at the end of the step.
    pub temperature: [Vec<f64>; 2],
    /// Points that exchange heat (n): those in contact, and those that are just open.
    pub exchanging: Vec<bool>,
    /// Sets of points that were tried.
    pub rounds: usize,
}

/// How the heat of friction `w` of the points in contact divides between the bodies:
/// `both q_upper = apart + lower w`.
struct Division {
    exchange: Arc<Exchange>,
    /// Temperature [K] by which the lower body would be the warmer one without any flux.
    apart: Mat<f64>,
}

/// What of a division follows from the matrices and the points in contact alone.
pub(super) struct Exchange {
    active: Vec<usize>,
    both: Lu,
    lower: Mat<f64>,
    fed: Option<Fed>,
}

/// How heat in the points in contact opens the gap (n, m).
struct Fed {
    /// By a flux that goes from the lower body to the upper one.
    across: Mat<f64>,
    /// By heat of friction that divides.
    by_heat: Mat<f64>,
}

/// The last exchange, and what it was made of: steps of one length at one speed have it in common.
pub(super) struct LastExchange {
    response: [Vec<f64>; 2],
    opening: Option<[Vec<f64>; 2]>,
    resistance: f64,
    share: f64,
    exchange: Arc<Exchange>,
}

/// Points up to which the last exchange is kept: it takes up to nine matrices of them.
const KEPT: usize = 1000;

impl LastExchange {
    fn is_of(&self, heating: &Heating<'_>) -> bool {
        self.resistance == heating.resistance
            && self.share == heating.share
            && (0..2).all(|k| self.response[k] == heating.response[k])
            && match (&self.opening, heating.opening) {
                (None, None) => true,
                (Some(own), Some(other)) => (0..2).all(|k| own[k] == other[k]),
                _ => false,
            }
    }
}

fn square(values: &[f64], n: usize) -> MatRef<'_, f64> {
    MatRef::from_row_major_slice(values, n, n)
}

impl Heating<'_> {
    /// What belongs to more than one step.
    fn check_matrices(&self, n: usize) -> Result<(), Error> {
        for (k, name) in ["response of the lower body", "response of the upper body"]
            .into_iter()
            .enumerate()
        {
            check(name, self.response[k], n * n)?;
        }
        for opening in self.opening.iter().flatten() {
            check("opening by heat", opening, n * n)?;
        }
        Ok(())
    }

    fn check(&self, n: usize) -> Result<(), Error> {
        for before in self.before {
            check("temperature before", before, n)?;
        }
        check("speed", self.speed, n)?;
        if let Some(speed) = self.speed.iter().find(|v| **v < 0.0) {
            check_number("speed", *speed, false, "a number of at least 0 is needed")?;
        }
        let resistance = self.resistance;
        check_number(
            "resistance",
            resistance,
            resistance >= 0.0,
            "a number of at least 0 is needed",
        )?;
        let is_share = (0.0..=1.0).contains(&self.share);
        check_number(
            "share",
            self.share,
            is_share,
            "a number from 0 to 1 is needed",
        )
    }

    /// Equal temperatures at the points of `active`, but for the resistance: with `q_lower = w - q_upper`,
    /// `T_upper - T_lower = r (share w - q_upper)`.
    fn exchange(
        &self,
        active: Vec<usize>,
        n: usize,
        monitor: Monitor<'_>,
    ) -> Result<Exchange, Error> {
        let [lower, upper] = self.response.map(|r| square(r, n));
        let m = active.len();
        let resistance = |a: usize, b: usize| if a == b { self.resistance } else { 0.0 };
        let both = Mat::from_fn(m, m, |a, b| {
            let (i, j) = (active[a], active[b]);
            lower[(i, j)] + upper[(i, j)] + resistance(a, b)
        });
        let both = Lu::new(both, threads(m), monitor)?;
        let lower = Mat::from_fn(m, m, |a, b| {
            lower[(active[a], active[b])] + self.share * resistance(a, b)
        });
        let fed = self.opening.map(|opening| {
            let [below, above] = opening.map(|o| square(o, n));
            // q_lower = w - q_upper
            let across = Mat::from_fn(n, m, |i, a| above[(i, active[a])] - below[(i, active[a])]);
            let par = threads(m);
            let shares = both.solve_few(lower.as_ref(), par);
            let mut by_heat = Mat::from_fn(n, m, |i, a| below[(i, active[a])]);
            matmul(
                by_heat.as_mut(),
                Accum::Add,
                across.as_ref(),
                shares.as_ref(),
                1.0,
                par,
            );
            Fed { across, by_heat }
        });
        Ok(Exchange {
            active,
            both,
            lower,
            fed,
        })
    }

    /// Temperature [K] of the points of `active` by which the lower body would be the warmer one without any flux.
    fn apart(&self, active: &[usize]) -> Mat<f64> {
        Mat::from_fn(active.len(), 1, |a, _| {
            self.before[0][active[a]] - self.before[1][active[a]]
        })
    }
}

impl Division {
    /// What pressures open by their heat (n, n) [m/Pa], and what the heat that they exchange without friction does
    /// (n) [m]; `power` is the heat of friction by a unit pressure (n).
    fn feedback(&self, power: &[f64], n: usize) -> Option<(Vec<f64>, Vec<f64>)> {
        let exchange = &self.exchange;
        let Fed { across, by_heat } = exchange.fed.as_ref()?;
        let active = &exchange.active;
        let par = threads(active.len());
        let without = exchange.both.solve_few(self.apart.as_ref(), par);
        let mut feedback = vec![0.0; n * n];
        for (i, row) in feedback.chunks_exact_mut(n).enumerate() {
            for (a, &j) in active.iter().enumerate() {
                row[j] = by_heat[(i, a)] * power[j];
            }
        }
        let mut given = vec![0.0; n];
        for a in 0..active.len() {
            let moved = given.iter_mut().zip(across.col_as_slice(a));
            moved.for_each(|(given, across)| *given += across * without[(a, 0)]);
        }
        Some((feedback, given))
    }
}

impl Problem {
    /// The division of heat between the points of `active`; that of the last step is gone on with where matrices and
    /// points are the same.
    fn division(
        &self,
        heating: &Heating<'_>,
        active: Vec<usize>,
        monitor: Monitor<'_>,
    ) -> Result<Division, Error> {
        let n = self.points();
        let mut last = self.exchange.lock().unwrap_or_else(PoisonError::into_inner);
        let apart = heating.apart(&active);
        if let Some(last) = &*last
            && last.exchange.active == active
            && last.is_of(heating)
        {
            let exchange = last.exchange.clone();
            return Ok(Division { exchange, apart });
        }
        *last = None;
        heating.check_matrices(n)?;
        let exchange = Arc::new(heating.exchange(active, n, monitor)?);
        if n <= KEPT {
            *last = Some(LastExchange {
                response: heating.response.map(<[f64]>::to_vec),
                opening: heating.opening.map(|opening| opening.map(<[f64]>::to_vec)),
                resistance: heating.resistance,
                share: heating.share,
                exchange: exchange.clone(),
            });
        }
        Ok(Division { exchange, apart })
    }

    /// Lets the upper body slide at a speed in `direction` (2n) with friction `friction` (n), and heats both bodies
    /// by it over one implicit step of the time: the heat divides between them such that both have one temperature
    /// where they touch, and opens and closes the gap in the same step.
    ///
    /// Where no heat opens a gap, pressures are those of [`Problem::slide`]. Where a point would open by the heat that
    /// it exchanges, and close without it, there is no state with perfect contact [Barber1978]: such points then
    /// exchange heat though they are just open.
    ///
    /// # Errors
    /// As [`Problem::slide`], and numbers of the heating that are none.
    pub fn slide_heated(
        &self,
        loading: &Loading,
        direction: &[f64],
        friction: &[f64],
        heating: &Heating<'_>,
        start: Option<Vec<bool>>,
        monitor: Monitor<'_>,
    ) -> Result<Heated, Error> {
        self.heated_in_rounds(
            loading, direction, friction, heating, start, ROUNDS, monitor,
        )
    }

    /// [`Problem::slide_heated`], where the points that exchange heat are those in contact for less than `free` rounds;
    /// from then on their set, at first that of `start`, only grows.
    #[allow(clippy::too_many_arguments, reason = "a step of the time")]
    pub(super) fn heated_in_rounds(
        &self,
        loading: &Loading,
        direction: &[f64],
        friction: &[f64],
        heating: &Heating<'_>,
        start: Option<Vec<bool>>,
        free: usize,
        monitor: Monitor<'_>,
    ) -> Result<Heated, Error> {
        let n = self.points();
        self.check(loading)?;
        check("direction", direction, 2 * n)?;
        check("friction", friction, n)?;
        heating.check(n)?;
        check_factors(n, 4.0 * (8 * n * n) as f64)?;
        let is_frictional =
            direction.iter().any(|d| *d != 0.0) && friction.iter().any(|mu| *mu != 0.0);
        let kept: Arc<Kept> = self.matrix(direction, is_frictional, monitor)?;
        let motions = self.loaded(&loading.work);
        let power = self.power(direction, friction, heating);
        let mut active: Vec<bool> = match start {
            Some(start) if start.len() == n => start,
            _ => vec![true; n],
        };
        let mut iterations = 0;
        for round in 1.. {
            let points: Vec<usize> = (0..n).filter(|i| active[*i]).collect();
            let division = self.division(heating, points, monitor)?;
            let fed = division.feedback(&power, n);
            let gap: Vec<f64> = match &fed {
                Some((_, given)) => loading.gap.iter().zip(given).map(|(g, o)| g + o).collect(),
                None => loading.gap.clone(),
            };
            let contact = SlidingContact {
                gap: &gap,
                area: &self.geometry.area,
                friction,
                direction,
                motions: &motions,
                diagonal: loading.diagonal.as_deref(),
                interface: Some(self.interface()),
            };
            let feedback = fed.as_ref().map(|(feedback, _)| feedback.as_slice());
            let mut solution =
                kept.matrix
                    .solve_fed_back(&contact, feedback, Some(active.clone()), monitor)?;
            iterations += solution.iterations;
            let found: Vec<bool> = solution.pressure.iter().map(|p| *p > 0.0).collect();
            let is_solved = solution.status == Status::Solved;
            if is_solved && round < free && found != active {
                active = found;
                continue;
            }
            // a point that is warm in contact and cold when it is open may have no state between the two [Barber1978]
            let is_within = found
                .iter()
                .zip(&active)
                .all(|(found, active)| *active || !*found);
            if is_solved && !is_within {
                active
                    .iter_mut()
                    .zip(found)
                    .for_each(|(active, found)| *active |= found);
                continue;
            }
            solution.iterations = iterations;
            let friction = self
                .interface
                .coefficients(friction.to_vec(), &solution.pressure);
            let power = self.power(direction, &friction, heating);
            let (flux, temperature) = heating.shared(&division, &power, &solution.pressure);
            let outcome = Outcome::sliding(&self.geometry, [0.0; 3], solution, friction, direction);
            return Ok(Heated {
                outcome,
                flux,
                temperature,
                exchanging: active,
                rounds: round,
            });
        }
        unreachable!("the rounds end")
    }
}

impl Problem {
    /// The factor on the heat of friction up to which a heated state exists and is unique for every load, where the
    /// points of `active` (n) touch, with a `diagonal` (n) [m/Pa] as that of a loading: the speed of sliding over it is
    /// the thermal limit of this step, if the heat divides in the same way. It is the twin of
    /// [`Problem::wedging_factor`]. Infinite where heat opens no gap.
    ///
    /// # Errors
    /// As [`Problem::slide_heated`].
    #[allow(clippy::too_many_arguments, reason = "a step of the time")]
    pub fn thermal_factor(
        &self,
        direction: &[f64],
        friction: &[f64],
        heating: &Heating<'_>,
        diagonal: Option<&[f64]>,
        active: &[bool],
        monitor: Monitor<'_>,
    ) -> Result<f64, Error> {
        let n = self.points();
        check("direction", direction, 2 * n)?;
        check("friction", friction, n)?;
        heating.check(n)?;
        heating.check_matrices(n)?;
        if active.len() != n {
            return Err(Error::Shape {
                name: "active",
                expected: n,
                found: active.len(),
            });
        }
        let is_frictional =
            direction.iter().any(|d| *d != 0.0) && friction.iter().any(|mu| *mu != 0.0);
        let kept = self.matrix(direction, is_frictional, monitor)?;
        let motions = self.loaded(&vec![0.0; self.motions.len()]);
        let power = self.power(direction, friction, heating);
        let points: Vec<usize> = (0..n).filter(|i| active[*i]).collect();
        let division = Division {
            apart: heating.apart(&points),
            exchange: Arc::new(heating.exchange(points, n, monitor)?),
        };
        let Some((feedback, _)) = division.feedback(&power, n) else {
            return Ok(f64::INFINITY);
        };
        let contact = SlidingContact {
            gap: &vec![0.0; n],
            area: &self.geometry.area,
            friction,
            direction,
            motions: &motions,
            diagonal,
            // a pressure that is held or a layer that gives way takes part in no runaway
            interface: None,
        };
        kept.matrix
            .feedback_factor(&contact, &feedback, active, monitor)
    }

    /// Heat of friction by a unit pressure at each point (n) [W/m2/Pa].
    fn power(&self, direction: &[f64], friction: &[f64], heating: &Heating<'_>) -> Vec<f64> {
        let n = self.points();
        (0..n)
            .map(|i| friction[i] * direction[i].hypot(direction[n + i]) * heating.speed[i])
            .collect()
    }
}

impl Heating<'_> {
    /// Fluxes and temperatures of lower and upper body.
    fn shared(
        &self,
        division: &Division,
        power: &[f64],
        pressure: &[f64],
    ) -> ([Vec<f64>; 2], [Vec<f64>; 2]) {
        let n = pressure.len();
        let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
        let exchange = &division.exchange;
        let active = &exchange.active;
        let heat = Mat::from_fn(active.len(), 1, |a, _| {
            power[active[a]] * pressure[active[a]]
        });
        let mut entered = division.apart.clone();
        let par = threads(active.len());
        matmul(
            entered.as_mut(),
            Accum::Add,
            exchange.lower.as_ref(),
            heat.as_ref(),
            1.0,
            par,
        );
        let entered = exchange.both.solve_few(entered.as_ref(), par);
        for (a, &i) in active.iter().enumerate() {
            upper[i] = entered[(a, 0)];
            lower[i] = heat[(a, 0)] - upper[i];
        }
        let flux = [lower, upper];
        let temperature = std::array::from_fn(|k| {
            let rows = self.response[k].chunks_exact(n.max(1));
            rows.zip(self.before[k])
                .map(|(row, before)| {
                    before + row.iter().zip(&flux[k]).map(|(r, q)| r * q).sum::<f64>()
                })
                .collect()
        });
        (flux, temperature)
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Wear of a sliding contact: a diagonal compliance with memory in the gap.
//!
//! Archard's law `dw/ds = kappa p`, with the depth `w`, the sliding distance `s` and the wear coefficient `kappa`
//! [1/Pa], makes an implicit step of length `ds` the sliding contact itself with `kappa ds` on its diagonal and what
//! was worn before in its gap, `g = g0 + w + (C_nn + mu C_nt d + kappa ds) p + sum c_k o_k`. It is better conditioned
//! than without wear and stable for any length, so that long steps go straight to the worn-in state. Other laws give
//! a coefficient that follows the pressure; it is found in rounds.
//!
//! [`Wear::advance`] takes one step, whose length it chooses by an estimate of its error.
//!
//! **References.** [PodraAndersson1999], [ArgatovChai2020].

use mtb_complementarity::linear::Status;
use mtb_operator::Monitor;

use crate::error::{Error, check, check_positive};
use crate::magnet::Magnet;
use crate::prepared::{PreparedContact, Step};
use crate::problem::{Friction, Loading, Outcome, Problem};
use crate::steps::{Gathered, StepControl};

/// Rounds in which a coefficient that follows the pressure must settle, and the share of the error of a step that is
/// left to it.
const ROUNDS: usize = 12;
const SETTLED: f64 = 0.1;
/// A sliding contact that can be worn.
pub trait Wearing {
    /// Area of each point (n) [m2].
    fn area(&self) -> &[f64];

    /// The sliding state with `worn` (n) [m] added to the gap, and a `diagonal` (n) [m/Pa].
    ///
    /// # Errors
    /// As [`Problem::slide`]. A state that does not exist is a status.
    fn solve(
        &mut self,
        worn: &[f64],
        diagonal: &[f64],
        monitor: Monitor<'_>,
    ) -> Result<Outcome, Error>;
}

/// A [`Problem`] that slides under one load.
pub struct SlidingProblem<'a> {
    problem: &'a Problem,
    loading: Loading,
    direction: &'a [f64],
    friction: Friction<'a>,
    start: Option<Vec<bool>>,
    magnet: Option<(Magnet<'a>, Option<Vec<f64>>)>,
}

impl<'a> SlidingProblem<'a> {
    /// The arguments of [`Problem::slide`].
    pub fn new(
        problem: &'a Problem,
        loading: Loading,
        direction: &'a [f64],
        friction: Friction<'a>,
    ) -> Self {
        Self {
            problem,
            loading,
            direction,
            friction,
            start: None,
            magnet: None,
        }
    }

    /// The same under a magnet besides the load, from a pull (n) [Pa] as [`Problem::slide_attracted`].
    #[must_use]
    pub fn attracted(mut self, magnet: Magnet<'a>, from: Option<Vec<f64>>) -> Self {
        self.magnet = Some((magnet, from));
        self
    }
}

impl Wearing for SlidingProblem<'_> {
    fn area(&self) -> &[f64] {
        &self.problem.geometry().area
    }

    fn solve(
        &mut self,
        worn: &[f64],
        diagonal: &[f64],
        monitor: Monitor<'_>,
    ) -> Result<Outcome, Error> {
        let loading = self.loading.worn(worn, diagonal);
        let (direction, friction, start) = (self.direction, self.friction, self.start.take());
        let outcome = match &mut self.magnet {
            None => self
                .problem
                .slide(&loading, direction, friction, start, monitor)?,
            Some((magnet, from)) => {
                let outcome = self.problem.slide_attracted(
                    &loading,
                    magnet,
                    from.take(),
                    direction,
                    friction,
                    start,
                    false,
                    monitor,
                )?;
                // wear goes on from the state in which it is
                *from = outcome.settled.as_ref().map(|settled| settled.pull.clone());
                outcome
            }
        };
        if outcome.solution.status == Status::Solved {
            (self.problem.geometry()).check_edge(&outcome.solution.pressure)?;
            self.start = Some(outcome.in_contact());
        }
        Ok(outcome)
    }
}

/// A [`PreparedContact`] in one [`Step`].
pub struct PreparedStep<'a> {
    contact: &'a mut PreparedContact,
    area: Vec<f64>,
    step: Step<'a>,
}

impl<'a> PreparedStep<'a> {
    /// The contact, and the step that it takes again and again while it wears.
    pub fn new(contact: &'a mut PreparedContact, step: Step<'a>) -> Self {
        let area = contact.prepared().geometry.area.clone();
        Self {
            contact,
            area,
            step,
        }
    }
}

impl Wearing for PreparedStep<'_> {
    fn area(&self) -> &[f64] {
        &self.area
    }

    fn solve(
        &mut self,
        worn: &[f64],
        diagonal: &[f64],
        monitor: Monitor<'_>,
    ) -> Result<Outcome, Error> {
        let with = |own: Option<&[f64]>, more: &[f64]| match own {
            Some(own) => sum(own, more),
            None => more.to_vec(),
        };
        let (gap, diagonal) = (
            with(self.step.gap, worn),
            with(self.step.diagonal, diagonal),
        );
        let step = Step {
            gap: Some(&gap),
            diagonal: Some(&diagonal),
            ..self.step
        };
        self.contact.step(&step, monitor)
    }
}

fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

/// What rubs at the contact points, as a law of wear is told it.
#[derive(Clone, Copy, Debug)]
pub struct Rubbing<'a> {
    /// Pressure (n) [Pa].
    pub pressure: &'a [f64],
    /// Friction coefficient (n).
    pub friction: &'a [f64],
}

/// Wear coefficients (n) [1/Pa] of the upper and of the lower body: depth over sliding distance and pressure.
pub type Coefficients = [Vec<f64>; 2];

/// A law of wear: the coefficients under what rubs, which may be no pressure at all.
pub type WearLaw<'a> = &'a (dyn Fn(Rubbing<'_>) -> Result<Coefficients, Error> + 'a);

/// How the upper body passes over the lower one.
#[derive(Clone, Debug, PartialEq)]
pub struct Passage {
    /// Sliding distance of one passage [m].
    pub distance: f64,
    /// The line along the sliding direction that each point lies on (n), counted from 0.
    pub line: Vec<usize>,
    /// Length of each point along its line (n) [m].
    pub length: Vec<f64>,
}

/// A contact as worn so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Worn {
    /// Sliding distance [m].
    pub distance: f64,
    /// Depth worn off the upper and off the lower body (n) [m].
    pub depth: [Vec<f64>; 2],
}

/// One step of wear.
#[derive(Clone, Debug)]
pub struct WearStep {
    /// Its length [m].
    pub length: f64,
    /// What is worn after it.
    pub worn: Worn,
    /// The contact then; where its status is not solved, there is none, and nothing was worn.
    pub outcome: Outcome,
    /// Estimated error of its depths in parts of them and a tenth of all depths; root mean squares over the area.
    pub error: f64,
    /// Contacts that were solved for it, lengths tried in vain included.
    pub solves: usize,
}

/// A contact that is worn step by step.
///
/// Without a [`Passage`] the points of both bodies stay together, as in fretting, and each body is worn where the
/// contact is. With one, the upper body stays, and every point of the lower one on a line along the sliding
/// direction is worn alike by each passage.
pub struct Wear<'a, C> {
    contact: C,
    law: WearLaw<'a>,
    passage: Option<Passage>,
    tolerance: f64,
    control: StepControl,
    worn: Worn,
    /// Depth worn over distance now (n), and the pressure; empty before the first step.
    rate: Vec<f64>,
    pressure: Vec<f64>,
    coefficients: Coefficients,
}

impl<'a, C: Wearing> Wear<'a, C> {
    /// A contact that is `worn` already, or not yet. Each step has about an error of `tolerance`, as
    /// [`WearStep::error`] counts it, and so has the sum of all of them: a step of the implicit rule errs by half of
    /// its length times the change of the rate, so that it ends where the pressures have changed by twice as much.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, a tolerance or lengths that are not positive.
    pub fn new(
        contact: C,
        law: WearLaw<'a>,
        passage: Option<Passage>,
        tolerance: f64,
        worn: Worn,
    ) -> Result<Self, Error> {
        let n = contact.area().len();
        check_positive("tolerance", tolerance)?;
        for depth in &worn.depth {
            check("worn", depth, n)?;
        }
        if let Some(passage) = &passage {
            check_positive("distance of a passage", passage.distance)?;
            check("length", &passage.length, n)?;
            if passage.line.len() != n {
                return Err(Error::Shape {
                    name: "line",
                    expected: n,
                    found: passage.line.len(),
                });
            }
        }
        Ok(Self {
            contact,
            law,
            passage,
            tolerance,
            control: StepControl::new(tolerance),
            worn,
            rate: Vec::new(),
            pressure: Vec::new(),
            coefficients: [Vec::new(), Vec::new()],
        })
    }

    /// What is worn so far.
    pub fn worn(&self) -> &Worn {
        &self.worn
    }

    /// The length [m] that the last step promises for the next one.
    pub fn next(&self) -> Option<f64> {
        self.control.next()
    }

    /// Begins with a step of at most this length [m], as one that ended before has promised it.
    pub fn begin_with(&mut self, next: Option<f64>) {
        self.control.begin_with(next);
    }

    /// The contact as it is, without further wear.
    ///
    /// # Errors
    /// As [`Wear::advance`].
    pub fn now(&mut self, monitor: Monitor<'_>) -> Result<Outcome, Error> {
        let n = self.contact.area().len();
        let worn = sum(&self.worn.depth[0], &self.worn.depth[1]);
        let outcome = self.contact.solve(&worn, &vec![0.0; n], monitor)?;
        if outcome.solution.status == Status::Solved {
            self.coefficients = self.coefficients_at(&outcome)?;
            self.pressure.clone_from(&outcome.solution.pressure);
            let [upper, lower] = self.depths(1.0, &self.coefficients, &self.pressure);
            self.rate = sum(&upper, &lower);
        }
        Ok(outcome)
    }

    /// Takes a step of at most `most` [m].
    ///
    /// # Errors
    /// As [`Wearing::solve`]; those of the law, and coefficients that are negative or not finite;
    /// [`Error::WearsTooFast`] where no step is short enough.
    pub fn advance(&mut self, most: f64, monitor: Monitor<'_>) -> Result<WearStep, Error> {
        check_positive("distance", most)?;
        let mut solves = 0;
        if self.rate.is_empty() {
            let outcome = self.now(monitor)?;
            solves += 1;
            if outcome.solution.status != Status::Solved {
                return Ok(self.unsolved(outcome, solves));
            }
        }
        let mut length = self.control.length(most);
        while !self.control.is_stuck() {
            let (step, coefficients) = self.tried(length, monitor)?;
            solves += step.solves;
            if step.outcome.solution.status != Status::Solved {
                return Ok(self.unsolved(step.outcome, solves));
            }
            if let Some(shorter) = self.control.judge(length, most, step.error) {
                length = shorter;
                continue;
            }
            self.pressure.clone_from(&step.outcome.solution.pressure);
            let [upper, lower] = self.depths(1.0, &coefficients, &self.pressure);
            self.rate = sum(&upper, &lower);
            self.coefficients = coefficients;
            self.worn.clone_from(&step.worn);
            return Ok(WearStep { solves, ..step });
        }
        Err(Error::WearsTooFast { length })
    }

    fn unsolved(&self, outcome: Outcome, solves: usize) -> WearStep {
        WearStep {
            length: 0.0,
            worn: self.worn.clone(),
            outcome,
            error: 0.0,
            solves,
        }
    }

    /// A step of a length, and the coefficients at its end.
    fn tried(
        &mut self,
        length: f64,
        monitor: Monitor<'_>,
    ) -> Result<(WearStep, Coefficients), Error> {
        let area = self.contact.area().to_vec();
        let before = sum(&self.worn.depth[0], &self.worn.depth[1]);
        let mut coefficients = self.coefficients.clone();
        let mut guess = self.pressure.clone();
        for round in 1.. {
            // what the lines of a passage wear together stands in the gap, by the pressure of the last round; as much
            // is on the diagonal and off the gap, so that the rounds come to an end for steps of any length
            let mut diagonal: Vec<f64> = coefficients[0].iter().map(|k| k * length).collect();
            let mut worn = before.clone();
            if let Some(passage) = &self.passage {
                let along = passage.worn(length, &coefficients[1], &guess);
                for (i, held) in passage
                    .held(length, &coefficients[1])
                    .into_iter()
                    .enumerate()
                {
                    diagonal[i] += held;
                    worn[i] += along[i] - held * guess[i];
                }
            } else {
                for (d, k) in diagonal.iter_mut().zip(&coefficients[1]) {
                    *d += k * length;
                }
            }
            let outcome = self.contact.solve(&worn, &diagonal, monitor)?;
            let pressure = &outcome.solution.pressure;
            let is_solved = outcome.solution.status == Status::Solved;
            let now = if is_solved {
                self.coefficients_at(&outcome)?
            } else {
                coefficients.clone()
            };
            let depth = self.depths(length, &coefficients, pressure);
            let all = sum(&depth[0], &depth[1]);
            // what the step opened, and what it would by its own pressure
            let opened = |i: usize| worn[i] - before[i] + diagonal[i] * pressure[i];
            let wanted = self.depths(length, &now, pressure);
            let left = |i: usize| wanted[0][i] + wanted[1][i] - opened(i);
            let gathered = Gathered {
                area: &area,
                before: &before,
                step: &all,
            };
            let of_rounds = gathered.relative(left);
            if is_solved && round < ROUNDS && of_rounds > SETTLED * self.tolerance {
                guess.clone_from(pressure);
                coefficients = now;
                continue;
            }
            let by_length = gathered.of_length(length, &self.rate, &sum(&wanted[0], &wanted[1]));
            let worn = Worn {
                distance: self.worn.distance + length,
                depth: [0, 1].map(|body| sum(&self.worn.depth[body], &depth[body])),
            };
            let step = WearStep {
                length,
                worn,
                outcome,
                error: by_length + of_rounds,
                solves: round,
            };
            return Ok((step, now));
        }
        unreachable!("the last round returns")
    }

    fn coefficients_at(&self, outcome: &Outcome) -> Result<Coefficients, Error> {
        let found = (self.law)(Rubbing {
            pressure: &outcome.solution.pressure,
            friction: &outcome.friction,
        })?;
        for coefficient in &found {
            check("wear coefficient", coefficient, outcome.friction.len())?;
            if let Some(index) = coefficient.iter().position(|k| *k < 0.0) {
                return Err(Error::Negative {
                    name: "wear coefficient",
                    index,
                    value: coefficient[index],
                });
            }
        }
        Ok(found)
    }

    /// Depths that are worn off both bodies over a length.
    fn depths(&self, length: f64, coefficients: &Coefficients, pressure: &[f64]) -> [Vec<f64>; 2] {
        let own = |coefficient: &[f64]| -> Vec<f64> {
            let pairs = coefficient.iter().zip(pressure);
            pairs.map(|(k, p)| k * length * p).collect()
        };
        let [upper, lower] = coefficients;
        let lower = match &self.passage {
            Some(passage) => passage.worn(length, lower, pressure),
            None => own(lower),
        };
        [own(upper), lower]
    }
}

impl Passage {
    /// Depth (n) [m] by passages of the whole sliding distance `length`: each wears a line by what presses along it.
    fn worn(&self, length: f64, coefficient: &[f64], pressure: &[f64]) -> Vec<f64> {
        let of_line = self.summed(|i| coefficient[i] * pressure[i] * self.length[i]);
        let share = length / self.distance;
        self.line
            .iter()
            .map(|&line| share * of_line[line])
            .collect()
    }

    /// A diagonal (n) [m/Pa] that is no softer than the lines.
    fn held(&self, length: f64, coefficient: &[f64]) -> Vec<f64> {
        let of_line = self.summed(|i| coefficient[i] * self.length[i]);
        let share = length / self.distance;
        self.line
            .iter()
            .map(|&line| share * of_line[line])
            .collect()
    }

    fn summed(&self, of: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.line.iter().max().map_or(0, |last| last + 1)];
        for (i, &line) in self.line.iter().enumerate() {
            sums[line] += of(i);
        }
        sums
    }
}

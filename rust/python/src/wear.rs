// SPDX-License-Identifier: MIT OR Apache-2.0
//! Wear of sliding contacts.

use std::sync::{Mutex, PoisonError};

use mtb_complementarity::linear::Status;
use mtb_contact::Error;
use mtb_contact::prepared::Step;
use mtb_contact::wear::{
    Passage, PreparedStep, Rubbing, SlidingProblem, Wear, WearStep, Wearing, Worn,
};
use mtb_operator::Monitor;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::contact::flat;
use crate::error::enter;
use crate::magnet::{Given as GivenMagnet, MagnetArgument, pull};
use crate::prepared::{PyPreparedContact, pull_of};
use crate::problem::{FrictionArgument, PyLoading, PyOutcome, PyProblem, rows2, with_friction};

/// A step of wear: the contact after it, and what is worn then.
#[pyclass(frozen, get_all, name = "WearStep", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyWearStep {
    outcome: Py<PyOutcome>,
    /// Of the step, and in all [m]; the length that it promises for the next one.
    length: f64,
    distance: f64,
    next: Option<f64>,
    /// Depth (n,) [m].
    upper: Py<PyArray1<f64>>,
    lower: Py<PyArray1<f64>>,
    error: f64,
    solves: usize,
}

impl PyWearStep {
    fn of(py: Python<'_>, step: WearStep, next: Option<f64>) -> PyResult<Self> {
        let [upper, lower] = step.worn.depth;
        Ok(Self {
            outcome: Py::new(py, PyOutcome::of(py, step.outcome)?)?,
            length: step.length,
            distance: step.worn.distance,
            next,
            upper: upper.into_pyarray(py).unbind(),
            lower: lower.into_pyarray(py).unbind(),
            error: step.error,
            solves: step.solves,
        })
    }
}

/// Distance of a passage, line of each point, length of each point along its line (n,) [m].
type PassageArgument<'py> = (f64, Vec<usize>, PyReadonlyArray1<'py, f64>);
/// Distance so far, depth worn off the upper and the lower body (n,), first step [m] or None.
type WornArgument<'py> = (
    f64,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    Option<f64>,
);

/// What a wear is told beside its contact.
struct Given<'a> {
    law: &'a Py<PyAny>,
    passage: Option<Passage>,
    tolerance: f64,
    worn: Worn,
    next: Option<f64>,
    until: f64,
    told: &'a Py<PyAny>,
}

impl<'a> Given<'a> {
    fn new(
        law: &'a Py<PyAny>,
        passage: Option<PassageArgument<'_>>,
        tolerance: f64,
        worn: &WornArgument<'_>,
        until: f64,
        told: &'a Py<PyAny>,
    ) -> PyResult<Self> {
        let passage = match passage {
            None => None,
            Some((distance, line, length)) => Some(Passage {
                distance,
                line,
                length: flat(&length, "length")?.to_vec(),
            }),
        };
        let (distance, upper, lower, next) = worn;
        let depth = [
            flat(upper, "upper")?.to_vec(),
            flat(lower, "lower")?.to_vec(),
        ];
        Ok(Self {
            law,
            passage,
            tolerance,
            worn: Worn {
                distance: *distance,
                depth,
            },
            next: *next,
            until,
            told,
        })
    }

    /// Wears a contact until the distance is reached or `told` returns true, which hears of every step. What Python
    /// raises goes to `failed`.
    fn run<C: Wearing>(
        self,
        contact: C,
        failed: &Mutex<Option<PyErr>>,
        monitor: Monitor<'_>,
    ) -> Result<(), Error> {
        let broken_off = |error: PyErr| {
            *failed.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            Error::Interrupted
        };
        let law = |rubbing: Rubbing<'_>| {
            Python::attach(|py| {
                let pressure = rubbing.pressure.to_vec().into_pyarray(py);
                let friction = rubbing.friction.to_vec().into_pyarray(py);
                let found = self.law.call1(py, (pressure, friction))?;
                let (upper, lower): (PyReadonlyArray1<'_, f64>, PyReadonlyArray1<'_, f64>) =
                    found.extract(py)?;
                Ok([
                    flat(&upper, "upper")?.to_vec(),
                    flat(&lower, "lower")?.to_vec(),
                ])
            })
            .map_err(broken_off)
        };
        let tell = |step: WearStep, next: Option<f64>| {
            Python::attach(|py| {
                let step = PyWearStep::of(py, step, next)?;
                self.told.call1(py, (step,))?.is_truthy(py)
            })
            .map_err(broken_off)
        };
        let mut wear = Wear::new(contact, &law, self.passage, self.tolerance, self.worn)?;
        wear.begin_with(self.next);
        let outcome = wear.now(monitor)?;
        let is_solved = |step: &WearStep| step.outcome.solution.status == Status::Solved;
        let first = WearStep {
            length: 0.0,
            worn: wear.worn().clone(),
            outcome,
            error: 0.0,
            solves: 1,
        };
        let mut goes_on = is_solved(&first);
        goes_on &= !tell(first, wear.next())?;
        // what is left by rounding is no step
        while goes_on && wear.worn().distance < self.until * (1.0 - 1e-12) {
            let step = wear.advance(self.until - wear.worn().distance, monitor)?;
            goes_on = is_solved(&step);
            goes_on &= !tell(step, wear.next())?;
        }
        Ok(())
    }
}

/// What Python raised, or what the core said.
fn outcome(found: PyResult<()>, failed: Mutex<Option<PyErr>>) -> PyResult<()> {
    match failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
        Some(error) => Err(error),
        None => found,
    }
}

/// Wears the bodies of a problem until a sliding distance, or until `told`, which is given every step, returns true.
/// The `law` gives the coefficients (n,) [1/Pa] of both bodies under pressure and friction (n,); a `magnet` pulls
/// besides the loading, from a pull (n,) [Pa].
#[pyfunction]
#[pyo3(signature = (
    problem, loading, direction, friction, law, passage, tolerance, worn, until, told, magnet=None, from_pull=None
))]
#[allow(clippy::too_many_arguments, reason = "a contact, and how it is worn")]
pub(crate) fn wear_problem(
    py: Python<'_>,
    problem: &Bound<'_, PyProblem>,
    loading: &Bound<'_, PyLoading>,
    direction: PyReadonlyArray2<'_, f64>,
    friction: FrictionArgument<'_>,
    law: Py<PyAny>,
    passage: Option<PassageArgument<'_>>,
    tolerance: f64,
    worn: WornArgument<'_>,
    until: f64,
    told: Py<PyAny>,
    magnet: Option<MagnetArgument<'_>>,
    from_pull: Option<PyReadonlyArray1<'_, f64>>,
) -> PyResult<()> {
    let (magnet, from) = (magnet.map(GivenMagnet::of), pull(from_pull.as_ref())?);
    let given = Given::new(&law, passage, tolerance, &worn, until, &told)?;
    let (problem, loading) = (&problem.get().0, loading.get().0.clone());
    let direction = rows2(&direction, "direction")?;
    let failed: Mutex<Option<PyErr>> = Mutex::new(None);
    let found = with_friction(&friction, &failed, |friction| {
        enter(py, |monitor| {
            let mut contact = SlidingProblem::new(problem, loading, direction, friction);
            if let Some(magnet) = &magnet {
                contact = contact.attracted(magnet.magnet(), from);
            }
            given.run(contact, &failed, monitor)
        })
    });
    outcome(found?, failed)
}

/// Wears a prepared contact in one step, likewise.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "a contact, and how it is worn")]
pub(crate) fn wear_contact(
    py: Python<'_>,
    contact: &Bound<'_, PyPreparedContact>,
    velocity: [f64; 2],
    magnetic_pressure: Option<f64>,
    given: Option<&Bound<'_, PyLoading>>,
    law: Py<PyAny>,
    passage: Option<PassageArgument<'_>>,
    tolerance: f64,
    worn: WornArgument<'_>,
    until: f64,
    told: Py<PyAny>,
) -> PyResult<()> {
    let wear = Given::new(&law, passage, tolerance, &worn, until, &told)?;
    let failed: Mutex<Option<PyErr>> = Mutex::new(None);
    let step = Step {
        pose: [f64::NAN; 6],
        velocity,
        pull: pull_of(given, magnetic_pressure),
        gap: None,
        friction: None,
        diagonal: None,
        shift: None,
    };
    let contact = contact.get();
    let found = enter(py, |monitor| {
        let mut contact = contact.lock();
        wear.run(PreparedStep::new(&mut contact, step), &failed, monitor)
    });
    outcome(found, failed)
}

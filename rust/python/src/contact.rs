// SPDX-License-Identifier: MIT OR Apache-2.0
//! The schemes of the thesis, and what the contacts share.

use mtb_complementarity::linear::Status;
use mtb_contact::incremental::{
    IncrementalContact, IncrementalOptions, IncrementalStatus, incremental,
};
use mtb_contact::staggered::{
    Staggered, StaggeredOptions, StaggeredStatus, best_factor, staggered,
};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::{bad_input, enter};
use crate::in_rows::InRows;
use crate::operator::PyCompliance;

pub(crate) fn flat<'a>(array: &'a PyReadonlyArray1<'_, f64>, name: &str) -> PyResult<&'a [f64]> {
    array
        .in_rows()
        .map_err(|_| PyValueError::new_err(format!("{name} must be contiguous")))
}

pub(crate) fn status_name(status: Status) -> &'static str {
    match status {
        Status::Solved => "solved",
        Status::NoSolution => "no solution",
        Status::Unreachable => "unreachable",
        Status::Overloaded => "overloaded",
        Status::IterationLimit => "iteration limit",
    }
}

/// Where the thesis' staggered scheme ended.
#[pyclass(frozen, get_all, name = "StaggeredOutcome", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyStaggeredOutcome {
    status: &'static str,
    pressure: Py<PyArray1<f64>>,
    gap: Py<PyArray1<f64>>,
    motion: Py<PyArray1<f64>>,
    residual: f64,
    iterations: usize,
    factor: f64,
    /// Factor below which the loop diverges for the points now in contact.
    predicted_limit: f64,
}

/// The thesis' staggered scheme on given influence matrices.
#[pyfunction]
#[pyo3(signature = (half_spaces, structure, gap, area, motion, balance, target, factor, max_iterations, tolerance, anderson_depth))]
#[allow(
    clippy::too_many_arguments,
    reason = "the arrays of one contact problem"
)]
pub(crate) fn solve_staggered<'py>(
    py: Python<'py>,
    half_spaces: PyReadonlyArray2<'py, f64>,
    structure: PyReadonlyArray2<'py, f64>,
    gap: PyReadonlyArray1<'py, f64>,
    area: PyReadonlyArray1<'py, f64>,
    motion: PyReadonlyArray2<'py, f64>,
    balance: PyReadonlyArray2<'py, f64>,
    target: PyReadonlyArray1<'py, f64>,
    factor: Option<f64>,
    max_iterations: usize,
    tolerance: f64,
    anderson_depth: usize,
) -> PyResult<PyStaggeredOutcome> {
    let matrix = |a: &'_ PyReadonlyArray2<'py, f64>| a.in_rows().map(<[f64]>::to_vec);
    let (half_spaces, structure) = (
        matrix(&half_spaces).map_err(|e| bad_input(&e))?,
        matrix(&structure).map_err(|e| bad_input(&e))?,
    );
    let (motion, balance) = (
        matrix(&motion).map_err(|e| bad_input(&e))?,
        matrix(&balance).map_err(|e| bad_input(&e))?,
    );
    let problem = Staggered {
        half_spaces: &half_spaces,
        structure: &structure,
        gap: flat(&gap, "gap")?,
        area: flat(&area, "area")?,
        motion: &motion,
        balance: &balance,
        target: flat(&target, "target")?,
    };
    let options = StaggeredOptions {
        factor,
        max_iterations,
        tolerance,
        anderson_depth,
    };
    let (solution, limit) = enter(py, |monitor| {
        let solution = staggered(&problem, &options, monitor)?;
        let (_, limit) = best_factor(&problem, &solution.contact.pressure, monitor)?;
        Ok::<_, mtb_contact::Error>((solution, limit))
    })?;
    let array = |values: Vec<f64>| values.into_pyarray(py).unbind();
    Ok(PyStaggeredOutcome {
        status: match solution.status {
            StaggeredStatus::Converged => "solved",
            StaggeredStatus::IterationLimit => "iteration limit",
            StaggeredStatus::Diverged => "diverged",
            StaggeredStatus::NoSolution => "no solution",
        },
        pressure: array(solution.contact.pressure),
        gap: array(solution.contact.slack),
        motion: array(solution.contact.motion),
        residual: solution.history.last().copied().unwrap_or(f64::INFINITY),
        iterations: solution.history.len(),
        factor: solution.factor,
        predicted_limit: limit,
    })
}

/// The parameters of the thesis' incremental scheme.
#[pyclass(
    frozen,
    get_all,
    name = "IncrementalOptions",
    module = "mtb_rs._mtb_rs"
)]
#[derive(Clone)]
pub(crate) struct PyIncrementalOptions {
    estimated_steps: usize,
    force_tolerance: f64,
    distance_tolerance: Option<f64>,
    max_resolutions: usize,
    max_releases: usize,
    max_increments: usize,
}

#[pymethods]
impl PyIncrementalOptions {
    #[new]
    #[pyo3(signature = (*, estimated_steps=20, force_tolerance=1.0, distance_tolerance=None, max_resolutions=20, max_releases=20, max_increments=500))]
    fn new(
        estimated_steps: usize,
        force_tolerance: f64,
        distance_tolerance: Option<f64>,
        max_resolutions: usize,
        max_releases: usize,
        max_increments: usize,
    ) -> Self {
        Self {
            estimated_steps,
            force_tolerance,
            distance_tolerance,
            max_resolutions,
            max_releases,
            max_increments,
        }
    }

    fn __repr__(&self) -> String {
        format!(
            "IncrementalOptions(estimated_steps={}, force_tolerance={:e}, distance_tolerance={:?}, \
             max_resolutions={}, max_releases={}, max_increments={})",
            self.estimated_steps,
            self.force_tolerance,
            self.distance_tolerance,
            self.max_resolutions,
            self.max_releases,
            self.max_increments
        )
    }
}

/// Where the thesis' incremental scheme ended, and what it accumulated on its way.
#[pyclass(
    frozen,
    get_all,
    name = "IncrementalOutcome",
    module = "mtb_rs._mtb_rs"
)]
pub(crate) struct PyIncrementalOutcome {
    status: &'static str,
    pressure: Py<PyArray1<f64>>,
    traction: Py<PyArray2<f64>>,
    gap: Py<PyArray1<f64>>,
    lower_displacement: Py<PyArray2<f64>>,
    upper_displacement: Py<PyArray2<f64>>,
    approach: f64,
    force: f64,
    residual: f64,
    imbalance: f64,
    increments: usize,
    resolutions: usize,
    problems: usize,
    active_sets: usize,
    releases: usize,
    history: Vec<(f64, f64)>,
}

/// The thesis' incremental scheme.
///
/// `lower_points`, `upper_points` (3, n): corresponding points of the undeformed surfaces; `grids`: numbers of
/// points along x and y of the grids they form; `force`: pressing the upper body down [N].
#[pyfunction]
#[allow(
    clippy::too_many_arguments,
    reason = "the arrays of one contact problem"
)]
pub(crate) fn solve_incremental<'py>(
    py: Python<'py>,
    lower: Option<&Bound<'py, PyCompliance>>,
    upper: Option<&Bound<'py, PyCompliance>>,
    lower_points: PyReadonlyArray2<'py, f64>,
    upper_points: PyReadonlyArray2<'py, f64>,
    grids: Vec<(usize, usize)>,
    area: PyReadonlyArray1<'py, f64>,
    friction: PyReadonlyArray1<'py, f64>,
    direction: [f64; 3],
    force: f64,
    options: &Bound<'py, PyIncrementalOptions>,
) -> PyResult<PyIncrementalOutcome> {
    let [lower, upper] = [lower, upper].map(|c| c.map(|c| c.get().0.clone()));
    let contact = IncrementalContact {
        lower: lower.as_deref(),
        upper: upper.as_deref(),
        lower_points: lower_points.in_rows().map_err(|e| bad_input(&e))?,
        upper_points: upper_points.in_rows().map_err(|e| bad_input(&e))?,
        grids: &grids,
        area: flat(&area, "area")?,
        friction: flat(&friction, "friction")?,
        direction,
        force,
    };
    let options = options.get();
    let options = IncrementalOptions {
        estimated_steps: options.estimated_steps,
        force_tolerance: options.force_tolerance,
        distance_tolerance: options.distance_tolerance,
        max_resolutions: options.max_resolutions,
        max_releases: options.max_releases,
        max_increments: options.max_increments,
    };
    let solution = enter(py, |monitor| incremental(&contact, &options, monitor))?;
    let n = solution.pressure.len();
    let status = match solution.status {
        IncrementalStatus::Converged => "solved",
        IncrementalStatus::IncrementLimit => "iteration limit",
        IncrementalStatus::Unresolved => "unresolved",
        IncrementalStatus::NoSolution => "no solution",
    };
    let array = |values: Vec<f64>| values.into_pyarray(py).unbind();
    let vectors = |field: Vec<f64>| -> PyResult<Py<PyArray2<f64>>> {
        Ok(field.into_pyarray(py).reshape([3, n])?.unbind())
    };
    Ok(PyIncrementalOutcome {
        status,
        pressure: array(solution.pressure),
        traction: vectors(solution.traction)?,
        gap: array(solution.gap),
        lower_displacement: vectors(solution.lower_displacement)?,
        upper_displacement: vectors(solution.upper_displacement)?,
        approach: solution.approach,
        force: solution.force,
        residual: solution.residual,
        imbalance: solution.imbalance,
        increments: solution.increments,
        resolutions: solution.resolutions,
        problems: solution.problems,
        active_sets: solution.active_sets,
        releases: solution.releases,
        history: solution.history,
    })
}

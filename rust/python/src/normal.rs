// SPDX-License-Identifier: MIT OR Apache-2.0
//! Frictionless contact on regular grids.

use mtb_complementarity::bounded::Status;
use mtb_contact::normal::{
    Load, Method, NormalContact, Options, Surface, memory, solve_normal as solve,
};
use mtb_elasticity::Material;
use mtb_elasticity::half_space::{influence, wave_compliance};
use mtb_operator::{Component, Grid};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::{bad_input, enter};

/// Where a frictionless contact ended; fields (ny, nx).
#[pyclass(frozen, get_all, name = "NormalOutcome", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyNormalOutcome {
    status: &'static str,
    is_dense: bool,
    pressure: Py<PyArray2<f64>>,
    gap: Py<PyArray2<f64>>,
    approach: f64,
    tilts: (f64, f64),
    iterations: usize,
    products: f64,
    preconditionings: f64,
    residual: f64,
    tolerance: f64,
    history: Vec<f64>,
    discretisation_error: Option<f64>,
}

/// Solves the normal contact of half-spaces.
///
/// `gap` (ny, nx) [m]; `bodies`: shear modulus [Pa] and Poisson's ratio of each elastic body; exactly one of
/// `force` [N] and `approach` [m]; `moments`: first moments of the pressure [N m], `None` locks a tilt;
/// `method`: "auto", "dense" or "fft".
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "one contact problem")]
pub(crate) fn solve_normal<'py>(
    py: Python<'py>,
    gap: PyReadonlyArray2<'py, f64>,
    spacing: (f64, f64),
    bodies: Vec<(f64, f64)>,
    force: Option<f64>,
    approach: Option<f64>,
    moments: (Option<f64>, Option<f64>),
    tolerance: Option<f64>,
    is_periodic: bool,
    method: &str,
) -> PyResult<PyNormalOutcome> {
    let (ny, nx) = (gap.shape()[0], gap.shape()[1]);
    let values = gap
        .as_slice()
        .map_err(|_| PyValueError::new_err("gap must be C-contiguous"))?;
    let grid = Grid::new(nx, ny, spacing.0, spacing.1).map_err(|e| bad_input(&e))?;
    let bodies: Vec<Material> = bodies
        .iter()
        .map(|(shear_modulus, poisson_ratio)| Material::new(*shear_modulus, *poisson_ratio))
        .collect::<Result<_, _>>()
        .map_err(|e| bad_input(&e))?;
    let pair = Material::joined(&bodies).map_err(|e| bad_input(&e))?;
    let load = match (force, approach) {
        (Some(force), None) => Load::Force(force),
        (None, Some(approach)) => Load::Approach(approach),
        _ => return Err(PyValueError::new_err("either force or approach is needed")),
    };
    let method = method_named(method)?;
    let solution = enter(py, |monitor| {
        let rectangle = |offset: [f64; 2], cell: [f64; 2]| -> f64 {
            influence(&pair, Component::Normal, Component::Normal, offset, cell)
        };
        let wave = |k: f64| wave_compliance(&pair, k);
        let surface = if is_periodic {
            Surface::Periodic(&wave)
        } else {
            Surface::FreeSpace(&rectangle)
        };
        let contact = NormalContact {
            gap: values,
            grid,
            surface,
            load,
            moments: [moments.0, moments.1],
        };
        solve(&contact, Options { tolerance, method }, monitor)
    })?;
    let field = |values: Vec<f64>| -> PyResult<Py<PyArray2<f64>>> {
        Ok(values.into_pyarray(py).reshape([ny, nx])?.unbind())
    };
    Ok(PyNormalOutcome {
        status: status_name(solution.status),
        is_dense: solution.method == Method::Dense,
        pressure: field(solution.pressure)?,
        gap: field(solution.gap)?,
        approach: solution.approach,
        tilts: (solution.tilts[0], solution.tilts[1]),
        iterations: solution.iterations,
        products: solution.products,
        preconditionings: solution.preconditionings,
        residual: solution.residual,
        tolerance: solution.tolerance,
        history: solution.history,
        discretisation_error: solution.discretisation_error,
    })
}

fn method_named(name: &str) -> PyResult<Method> {
    match name {
        "auto" => Ok(Method::Auto),
        "dense" => Ok(Method::Dense),
        "fft" => Ok(Method::Fourier),
        _ => Err(PyValueError::new_err(format!(
            "method is {name:?}: \"auto\", \"dense\" or \"fft\" is needed"
        ))),
    }
}

/// Memory [bytes] that this process can still have; `None` where the system does not tell.
#[pyfunction]
pub(crate) fn available_memory() -> Option<f64> {
    mtb_operator::available_memory()
}

/// What a limit of the address space leaves [bytes]; None where there is none.
#[pyfunction]
pub(crate) fn available_address_space() -> Option<f64> {
    mtb_operator::available_address_space()
}

/// Memory [bytes] that `solve_normal` takes at most.
#[pyfunction]
pub(crate) fn normal_memory(cells: usize, method: &str) -> PyResult<f64> {
    Ok(memory(cells, method_named(method)?))
}

/// Memory [bytes] that the matrices of a `Problem` and its solves take at most.
#[pyfunction]
pub(crate) fn sliding_memory(points: usize, frictional: bool) -> f64 {
    mtb_contact::sliding::memory(points, frictional)
}

fn status_name(status: Status) -> &'static str {
    match status {
        Status::Solved => "solved",
        Status::Stagnated => "stagnated",
        Status::IterationLimit => "iteration limit",
        Status::Unreachable => "unreachable",
    }
}

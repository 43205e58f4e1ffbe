// SPDX-License-Identifier: MIT OR Apache-2.0
//! Frictionless contact on regular grids.

use mtb_complementarity::bounded::Status;
use mtb_contact::normal::{
    Load, Method, NormalContact, NormalSolution, Options, Surface, memory, solve_normal as solve,
};
use mtb_elasticity::Material;
use mtb_elasticity::half_space::{influence, wave_compliance};
use mtb_operator::{Component, Grid};
use numpy::{IntoPyArray, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{bad_input, enter};

/// Solves the normal contact of half-spaces; returns a dictionary of arrays and counts.
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
) -> PyResult<Bound<'py, PyDict>> {
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
    as_dict(py, solution, [ny, nx])
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

/// Memory [bytes] that `solve_normal` takes at most.
#[pyfunction]
pub(crate) fn normal_memory(cells: usize, method: &str) -> PyResult<f64> {
    Ok(memory(cells, method_named(method)?))
}

/// Memory [bytes] that the matrices of a `SlidingPair` and their solves take at most.
#[pyfunction]
pub(crate) fn sliding_memory(points: usize, frictional: bool) -> f64 {
    mtb_contact::sliding::memory(points, frictional)
}

fn as_dict(
    py: Python<'_>,
    solution: NormalSolution,
    shape: [usize; 2],
) -> PyResult<Bound<'_, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("status", status_name(solution.status))?;
    out.set_item("is_dense", solution.method == Method::Dense)?;
    out.set_item(
        "pressure",
        solution.pressure.into_pyarray(py).reshape(shape)?,
    )?;
    out.set_item("gap", solution.gap.into_pyarray(py).reshape(shape)?)?;
    out.set_item("approach", solution.approach)?;
    out.set_item("tilts", (solution.tilts[0], solution.tilts[1]))?;
    out.set_item("iterations", solution.iterations)?;
    out.set_item("products", solution.products)?;
    out.set_item("preconditionings", solution.preconditionings)?;
    out.set_item("residual", solution.residual)?;
    out.set_item("tolerance", solution.tolerance)?;
    out.set_item("history", solution.history)?;
    out.set_item("discretisation_error", solution.discretisation_error)?;
    Ok(out)
}

fn status_name(status: Status) -> &'static str {
    match status {
        Status::Solved => "solved",
        Status::Stagnated => "stagnated",
        Status::IterationLimit => "iteration limit",
        Status::Unreachable => "unreachable",
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Frictionless contact on regular grids.

use mtb_complementarity::bounded::Status;
use mtb_contact::interface::RoughLaw;
use mtb_contact::normal::{
    Load, Method, NormalChange, NormalContact, NormalResponse, NormalState, Options, Surface,
    adjoint, forward, memory, solve_normal as solve,
};
use mtb_contact::{Across, Pressed};
use mtb_elasticity::half_space::NormalPair;
use mtb_operator::{Grid, Monitor};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::elasticity::MediumArgument;
use crate::error::{bad_input, enter};
use crate::in_rows::InRows;
use crate::prism::PyNormalPrisms;
use crate::problem::{RoughArgument, law_of};
use crate::tangential::along_rows;

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
/// `gap` (ny, nx) [m]; `bodies`: shear modulus [Pa] and Poisson's ratio, a `Layered`, or these, the creep and the way of one that creeps, of each elastic body; exactly one of
/// `force` [N] and `approach` [m]; `moments`: first moments of the pressure [N m], `None` locks a tilt;
/// `method`: "auto", "dense" or "fft"; `layer`: flexibility of a layer between the bodies [m/Pa]; `hardness`: pressure
/// at which a body flows [Pa]; `rough`: law of a rough layer, as of a `Problem`; `inclination`: of each row of
/// cells [rad], of a surface that is not plane; `prisms`: what the bodies do beside half-spaces.
#[pyfunction]
#[pyo3(signature = (
    gap, spacing, bodies, force, approach, moments, tolerance, is_periodic, method, layer=0.0, hardness=None,
    rough=None, inclination=None, prisms=None
))]
#[allow(clippy::too_many_arguments, reason = "one contact problem")]
pub(crate) fn solve_normal<'py>(
    py: Python<'py>,
    gap: PyReadonlyArray2<'py, f64>,
    spacing: (f64, f64),
    bodies: Vec<MediumArgument>,
    force: Option<f64>,
    approach: Option<f64>,
    moments: (Option<f64>, Option<f64>),
    tolerance: Option<f64>,
    is_periodic: bool,
    method: &str,
    layer: f64,
    hardness: Option<f64>,
    rough: Option<RoughArgument>,
    inclination: Option<Vec<f64>>,
    prisms: Option<&PyNormalPrisms>,
) -> PyResult<PyNormalOutcome> {
    let rough = rough.map(law_of).transpose()?;
    let (ny, nx) = (gap.shape()[0], gap.shape()[1]);
    let values = gap
        .in_rows()
        .map_err(|_| PyValueError::new_err("gap must be C-contiguous"))?;
    let grid = Grid::new(nx, ny, spacing.0, spacing.1).map_err(|e| bad_input(&e))?;
    let pair = joined(&bodies)?;
    let load = load_of(force, approach)?;
    let method = method_named(method)?;
    let solution = enter(py, |monitor| {
        posed(
            &pair,
            layer,
            hardness,
            rough.as_ref(),
            is_periodic,
            inclination.as_deref(),
            prisms.map(|prisms| &prisms.across),
            values,
            grid,
            load,
            moments.into(),
            |contact| solve(contact, Options { tolerance, method }, monitor),
        )
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

fn joined(bodies: &[MediumArgument]) -> PyResult<NormalPair> {
    let media: Result<Vec<_>, _> = bodies.iter().map(MediumArgument::medium).collect();
    media
        .and_then(|media| NormalPair::new(&media))
        .map_err(|e| bad_input(&e))
}

fn load_of(force: Option<f64>, approach: Option<f64>) -> PyResult<Load> {
    match (force, approach) {
        (Some(force), None) => Ok(Load::Force(force)),
        (None, Some(approach)) => Ok(Load::Approach(approach)),
        _ => Err(PyValueError::new_err("either force or approach is needed")),
    }
}

/// Runs `work` with the contact of the half-spaces of a `pair`, and of a layer between them.
#[allow(clippy::too_many_arguments, reason = "one contact problem")]
fn posed<T>(
    pair: &NormalPair,
    layer: f64,
    hardness: Option<f64>,
    rough: Option<&RoughLaw>,
    is_periodic: bool,
    inclination: Option<&[f64]>,
    across: Option<&Across>,
    gap: &[f64],
    grid: Grid,
    load: Load,
    moments: [Option<f64>; 2],
    work: impl FnOnce(&NormalContact<'_>) -> T,
) -> T {
    let rectangle = |offset: [f64; 2], cell: [f64; 2]| -> f64 {
        let own = if offset == [0.0; 2] { layer } else { 0.0 };
        own + pair.rectangle(offset, cell)
    };
    let wave = |k: f64| layer + pair.wave(k);
    let middle = -0.5 * (grid.ny - 1) as f64 * grid.dy;
    let angles = inclination.map(|angles| along_rows(angles, middle, grid.dy));
    let pressed = across.map(|across| Pressed::new(grid, rectangle, across));
    let surface = if let Some(bodies) = &pressed {
        Surface::Body(bodies)
    } else if let Some(angle) = &angles {
        Surface::Inclined(&rectangle, angle)
    } else if is_periodic {
        Surface::Periodic(&wave)
    } else if !pair.is_mirrored() {
        Surface::Rolling(&rectangle)
    } else {
        Surface::FreeSpace(&rectangle)
    };
    work(&NormalContact {
        gap,
        grid,
        surface,
        load,
        moments,
        hardness,
        rough,
        start: None,
    })
}

/// Pressure and gap (ny, nx), approach and tilts.
type Found = (Py<PyArray2<f64>>, Py<PyArray2<f64>>, f64, (f64, f64));

/// A solved contact of half-spaces, and its derivatives with the cells in contact held.
#[pyclass(frozen, name = "NormalTangent", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyNormalTangent {
    grid: Grid,
    pair: NormalPair,
    load: Load,
    moments: [Option<f64>; 2],
    is_periodic: bool,
    layer: f64,
    hardness: Option<f64>,
    rough: Option<RoughLaw>,
    inclination: Option<Vec<f64>>,
    prisms: Option<Py<PyNormalPrisms>>,
    initial_gap: Py<PyArray2<f64>>,
    pressure: Py<PyArray2<f64>>,
    gap: Py<PyArray2<f64>>,
    approach: f64,
    tilts: [f64; 2],
}

type Fields<'py> = PyReadonlyArray3<'py, f64>;
type Numbers<'py> = PyReadonlyArray1<'py, f64>;
type Pairs<'py> = PyReadonlyArray2<'py, f64>;

/// Fields (k, ny, nx), numbers (k,), pairs of them (k, 2), numbers (k,), fields (k, ny, nx), numbers (k,), and products
/// with the influence matrix.
type Changes<'py> = (
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray1<f64>>,
    usize,
);

/// Fields (k, ny, nx), twice, numbers (k,), pairs of them (k, 2), and products with the influence matrix.
type Responses<'py> = (
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    usize,
);

#[pymethods]
impl PyNormalTangent {
    /// Arguments of `solve_normal`, and what it found.
    #[new]
    #[allow(
        clippy::too_many_arguments,
        reason = "a contact problem and its solution"
    )]
    fn new(
        initial_gap: Py<PyArray2<f64>>,
        spacing: (f64, f64),
        bodies: Vec<MediumArgument>,
        force: Option<f64>,
        approach: Option<f64>,
        moments: (Option<f64>, Option<f64>),
        is_periodic: bool,
        layer: f64,
        hardness: Option<f64>,
        rough: Option<RoughArgument>,
        inclination: Option<Vec<f64>>,
        prisms: Option<Py<PyNormalPrisms>>,
        found: Found,
        py: Python<'_>,
    ) -> PyResult<Self> {
        let shape = initial_gap.bind(py).shape().to_vec();
        let grid =
            Grid::new(shape[1], shape[0], spacing.0, spacing.1).map_err(|e| bad_input(&e))?;
        Ok(Self {
            grid,
            pair: joined(&bodies)?,
            load: load_of(force, approach)?,
            moments: moments.into(),
            is_periodic,
            layer,
            hardness,
            rough: rough.map(law_of).transpose()?,
            inclination,
            prisms,
            initial_gap,
            pressure: found.0,
            gap: found.1,
            approach: found.2,
            tilts: found.3.into(),
        })
    }

    /// Changes of pressure and gap (k, ny, nx), approach (k,) and tilts (k, 2) by changes of the gap (k, ny, nx), of
    /// the force or the approach (k,), of the first moments (k, 2), of the compliance of bodies and layer over itself
    /// (k,), of the flexibility of each cell (k, ny, nx) and of the hardness (k,).
    #[allow(clippy::too_many_arguments, reason = "all that is given")]
    fn forward<'py>(
        &self,
        py: Python<'py>,
        gap: Fields<'py>,
        load: Numbers<'py>,
        moments: Pairs<'py>,
        compliance: Numbers<'py>,
        flexibility: Fields<'py>,
        hardness: Numbers<'py>,
    ) -> PyResult<Responses<'py>> {
        let (load, compliance) = (load.in_rows()?, compliance.in_rows()?);
        let moments = moments.in_rows()?;
        let n = self.grid.points();
        let fields = gap.in_rows()?.chunks_exact(n);
        let changes: Vec<NormalChange> = fields
            .zip(flexibility.in_rows()?.chunks_exact(n))
            .zip(moments.chunks_exact(2))
            .zip(load.iter().zip(compliance).zip(hardness.in_rows()?))
            .map(
                |(((gap, flexibility), moments), ((load, compliance), hardness))| NormalChange {
                    gap: gap.to_vec(),
                    load: *load,
                    moments: [moments[0], moments[1]],
                    compliance: *compliance,
                    flexibility: flexibility.to_vec(),
                    hardness: *hardness,
                },
            )
            .collect();
        let found = self.with(py, |contact, state, monitor| {
            forward(contact, state, &changes, monitor)
        })?;
        let values = &found.values;
        let pressure = values.iter().flat_map(|v| v.pressure.iter().copied());
        let gap = values.iter().flat_map(|v| v.gap.iter().copied());
        let tilts: Vec<f64> = values.iter().flat_map(|v| v.tilts).collect();
        let approach: Vec<f64> = values.iter().map(|v| v.approach).collect();
        Ok((
            self.fields(py, pressure.collect())?,
            self.fields(py, gap.collect())?,
            approach.into_pyarray(py),
            tilts.into_pyarray(py).reshape([values.len(), 2])?,
            found.products,
        ))
    }

    /// Derivatives of numbers by the gap (k, ny, nx), the force or the approach (k,), the first moments (k, 2) and the
    /// logarithm of the compliance (k,), the flexibility of each cell (k, ny, nx) and the hardness (k,), for their
    /// weights of pressure and gap (k, ny, nx), approach (k,) and tilts (k, 2).
    fn adjoint<'py>(
        &self,
        py: Python<'py>,
        pressure: Fields<'py>,
        gap: Fields<'py>,
        approach: Numbers<'py>,
        tilts: Pairs<'py>,
    ) -> PyResult<Changes<'py>> {
        let n = self.grid.points();
        let (approach, tilts) = (approach.in_rows()?, tilts.in_rows()?);
        let fields = pressure.in_rows()?.chunks_exact(n);
        let weights: Vec<NormalResponse> = fields
            .zip(gap.in_rows()?.chunks_exact(n))
            .zip(approach.iter().zip(tilts.chunks_exact(2)))
            .map(|((pressure, gap), (approach, tilts))| NormalResponse {
                pressure: pressure.to_vec(),
                gap: gap.to_vec(),
                approach: *approach,
                tilts: [tilts[0], tilts[1]],
            })
            .collect();
        let found = self.with(py, |contact, state, monitor| {
            adjoint(contact, state, &weights, monitor)
        })?;
        let values = &found.values;
        let gap = values.iter().flat_map(|v| v.gap.iter().copied());
        let load: Vec<f64> = values.iter().map(|v| v.load).collect();
        let moments: Vec<f64> = values.iter().flat_map(|v| v.moments).collect();
        let compliance: Vec<f64> = values.iter().map(|v| v.compliance).collect();
        let flexibility = values.iter().flat_map(|v| v.flexibility.iter().copied());
        let hardness: Vec<f64> = values.iter().map(|v| v.hardness).collect();
        Ok((
            self.fields(py, gap.collect())?,
            load.into_pyarray(py),
            moments.into_pyarray(py).reshape([values.len(), 2])?,
            compliance.into_pyarray(py),
            self.fields(py, flexibility.collect())?,
            hardness.into_pyarray(py),
            found.products,
        ))
    }
}

impl PyNormalTangent {
    fn fields<'py>(
        &self,
        py: Python<'py>,
        values: Vec<f64>,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let count = values.len() / self.grid.points();
        values
            .into_pyarray(py)
            .reshape([count, self.grid.ny, self.grid.nx])
    }

    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(
            &NormalContact<'_>,
            &NormalState<'_>,
            Monitor<'_>,
        ) -> Result<T, mtb_contact::Error>
        + Send,
    ) -> PyResult<T> {
        let values = |field: &Py<PyArray2<f64>>| -> PyResult<Vec<f64>> {
            Ok(field.bind(py).readonly().in_rows()?.to_vec())
        };
        let initial_gap = values(&self.initial_gap)?;
        let (pressure, gap) = (values(&self.pressure)?, values(&self.gap)?);
        let state = NormalState {
            pressure: &pressure,
            gap: &gap,
            approach: self.approach,
            tilts: self.tilts,
        };
        let (grid, load, moments) = (self.grid, self.load, self.moments);
        enter(py, |monitor| {
            posed(
                &self.pair,
                self.layer,
                self.hardness,
                self.rough.as_ref(),
                self.is_periodic,
                self.inclination.as_deref(),
                self.prisms.as_ref().map(|prisms| &prisms.get().across),
                &initial_gap,
                grid,
                load,
                moments,
                |contact| work(contact, &state, monitor),
            )
        })
    }
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

/// Memory [bytes] that `solve_normal` takes at most on (nx, ny) cells.
#[pyfunction]
pub(crate) fn normal_memory(cells: [usize; 2], method: &str) -> PyResult<f64> {
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

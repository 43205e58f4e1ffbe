// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contact problem.

use std::sync::{Arc, Mutex, PoisonError};

use mtb_contact::Error;
use mtb_contact::coupled::PointState;
use mtb_contact::problem::{
    Body, FreeMotion, Friction, Geometry, Loading, Means, Outcome, Problem,
};
use mtb_operator::Relative;
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::contact::{flat, rigid_motions, status_name};
use crate::error::{bad_input, enter};
use crate::operator::{PyCompliance, rows3};

/// The contact points of a problem in the common frame.
#[pyclass(frozen, name = "ContactGeometry", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyContactGeometry(pub(crate) Arc<Geometry>);

/// Starts of rows, columns, shares.
type MeansRows<'py> = (Vec<usize>, Vec<usize>, PyReadonlyArray1<'py, f64>);

#[pymethods]
impl PyContactGeometry {
    /// `points` (3, n) [m] at which the loads act; `frame`: (tangent x, tangent y, normal, and the means of the
    /// three), each (3, n), or `None` for a level surface; `means`: rows (n + 1), columns and shares of basis
    /// functions.
    #[new]
    #[pyo3(signature = (points, area, frame=None, means=None))]
    fn new(
        points: PyReadonlyArray2<'_, f64>,
        area: PyReadonlyArray1<'_, f64>,
        frame: Option<[PyReadonlyArray2<'_, f64>; 6]>,
        means: Option<MeansRows<'_>>,
    ) -> PyResult<Self> {
        let area = flat(&area, "area")?.to_vec();
        let n = area.len();
        let unit = |axis: usize| -> Vec<f64> {
            (0..3 * n)
                .map(|k| if k / n == axis { 1.0 } else { 0.0 })
                .collect()
        };
        let field = |k: usize| match &frame {
            None => Ok(unit(k % 3)),
            Some(fields) => Ok::<_, PyErr>(rows3(&fields[k], n, "frame")?.concat()),
        };
        let geometry = Geometry {
            points: rows3(&points, n, "points")?.concat(),
            tangent_x: field(0)?,
            tangent_y: field(1)?,
            normal: field(2)?,
            mean_frame: [field(3)?, field(4)?, field(5)?],
            area,
            means: match means {
                None => None,
                Some((start, column, share)) => Some(Means {
                    start,
                    column,
                    share: flat(&share, "share")?.to_vec(),
                }),
            },
        };
        geometry.check().map_err(|e| bad_input(&e))?;
        Ok(Self(Arc::new(geometry)))
    }

    /// Unit vectors (2, n) of sliding in the tangent planes, along (x, y); zeros where nothing slides.
    fn sliding_direction<'py>(
        &self,
        py: Python<'py>,
        along: [f64; 2],
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let direction = self.0.sliding_direction(along);
        let direction = direction.map_err(|e| bad_input(&e))?;
        direction.into_pyarray(py).reshape([2, self.0.points()])
    }

    /// Mean tractions (c, n) [Pa] of the unknowns (c, n) of a solution, the pressure last.
    fn mean_tractions<'py>(
        &self,
        py: Python<'py>,
        traction: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let shape = [traction.shape()[0], traction.shape()[1]];
        if shape[0] == 0 || shape[1] != self.0.points() {
            return Err(PyValueError::new_err(format!(
                "traction has shape {shape:?}, expected (c, {})",
                self.0.points()
            )));
        }
        let values = traction.as_slice().map_err(|e| bad_input(&e))?;
        self.0
            .mean_tractions(values)
            .into_pyarray(py)
            .reshape(shape)
    }

    /// Loads (3, n) [N] of the points on the lower body, from the unknowns (3, n) [Pa].
    fn loads<'py>(
        &self,
        py: Python<'py>,
        traction: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let n = self.0.points();
        let traction = rows3(&traction, n, "traction")?.concat();
        self.0.loads(&traction).into_pyarray(py).reshape([3, n])
    }
}

/// A state of two bodies in contact, and what it took to find it.
#[pyclass(frozen, get_all, name = "Outcome", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyOutcome {
    status: &'static str,
    pressure: Py<PyArray1<f64>>,
    gap: Py<PyArray1<f64>>,
    motion: Py<PyArray1<f64>>,
    friction: Py<PyArray1<f64>>,
    /// Along both tangents on the lower body (2, n) [Pa].
    traction: Py<PyArray2<f64>>,
    /// 0 open, 1 stick, 2 slip (n,).
    points: Py<PyArray1<i8>>,
    /// On the lower body [N].
    force: Py<PyArray1<f64>>,
    moment: Py<PyArray1<f64>>,
    friction_power: f64,
    /// Active sets or Newton steps.
    iterations: usize,
    factorisations: usize,
    products: usize,
    fell_back: bool,
    by_lemke: bool,
    residual: f64,
    unstable: bool,
}

impl PyOutcome {
    pub(crate) fn of(py: Python<'_>, outcome: Outcome) -> PyResult<Self> {
        let n = outcome.points.len();
        let codes: Vec<i8> = outcome.points.iter().copied().map(code).collect();
        let array = |values: Vec<f64>| values.into_pyarray(py).unbind();
        let solution = outcome.solution;
        Ok(Self {
            status: status_name(solution.status),
            pressure: array(solution.pressure),
            gap: array(solution.gap),
            motion: array(solution.motion),
            friction: array(outcome.friction),
            traction: outcome.traction.into_pyarray(py).reshape([2, n])?.unbind(),
            points: codes.into_pyarray(py).unbind(),
            force: array(outcome.force.to_vec()),
            moment: array(outcome.moment.to_vec()),
            friction_power: outcome.friction_power,
            iterations: outcome.effort.sets,
            factorisations: outcome.effort.factorisations,
            products: outcome.effort.products,
            fell_back: outcome.effort.fell_back,
            by_lemke: solution.by_lemke,
            residual: solution.residual,
            unstable: solution.unstable,
        })
    }
}

/// 0 open, 1 stick, 2 slip.
pub(crate) fn code(state: PointState) -> i8 {
    match state {
        PointState::Open => 0,
        PointState::Stick => 1,
        PointState::Slip => 2,
    }
}

/// Two bodies that meet in contact points: what stays while loads change.
#[pyclass(frozen, name = "Problem", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyProblem(Problem);

/// Coefficients (n,), or a function of the pressure (n,).
#[derive(FromPyObject)]
enum FrictionArgument<'py> {
    Field(PyReadonlyArray1<'py, f64>),
    Law(Py<PyAny>),
}

fn loading(gap: &PyReadonlyArray1<'_, f64>, work: &PyReadonlyArray1<'_, f64>) -> PyResult<Loading> {
    Ok(Loading {
        gap: flat(gap, "gap")?.to_vec(),
        work: flat(work, "work")?.to_vec(),
    })
}

fn body(is_upper: bool) -> Body {
    if is_upper { Body::Upper } else { Body::Lower }
}

fn rows2<'a>(array: &'a PyReadonlyArray2<'_, f64>, name: &str) -> PyResult<&'a [f64]> {
    array
        .as_slice()
        .map_err(|_| PyValueError::new_err(format!("{name} must be C-contiguous")))
}

#[pymethods]
impl PyProblem {
    /// `lower`, `upper`: `None` for a rigid body; `motions` (m, 3, n): relative displacement along x and y,
    /// opening; `of_upper`: whether each moves the upper body.
    #[new]
    #[pyo3(signature = (lower, upper, geometry, motions, of_upper))]
    fn new(
        lower: Option<&Bound<'_, PyCompliance>>,
        upper: Option<&Bound<'_, PyCompliance>>,
        geometry: &Bound<'_, PyContactGeometry>,
        motions: PyReadonlyArray3<'_, f64>,
        of_upper: Vec<bool>,
    ) -> PyResult<Self> {
        let [lower, upper] = [lower, upper].map(|c| c.map(|c| c.get().0.clone()));
        let pair = Relative::new(lower, upper).map_err(|e| bad_input(&e))?;
        let geometry = geometry.get().0.clone();
        let motions = rigid_motions(&motions, &[], geometry.points())?;
        if motions.len() != of_upper.len() {
            return Err(PyValueError::new_err(format!(
                "there are {} motions, and of {} it is said whose they are",
                motions.len(),
                of_upper.len()
            )));
        }
        let motions = motions
            .into_iter()
            .zip(of_upper)
            .map(|(motion, is_upper)| FreeMotion {
                body: body(is_upper),
                motion,
            })
            .collect();
        let problem = Problem::new(pair, geometry, motions).map_err(|e| bad_input(&e))?;
        Ok(Self(problem))
    }

    /// The two bodies together, as every way of solving has them.
    #[getter]
    fn pair(&self) -> PyCompliance {
        PyCompliance(Arc::new(self.0.pair().clone()))
    }

    /// The upper body slides in `direction` (2, n), every point in contact with friction; `gap` (n,) [m] before
    /// contact, `work` (m,) [J].
    fn slide(
        &self,
        py: Python<'_>,
        gap: PyReadonlyArray1<'_, f64>,
        work: PyReadonlyArray1<'_, f64>,
        direction: PyReadonlyArray2<'_, f64>,
        friction: FrictionArgument<'_>,
    ) -> PyResult<PyOutcome> {
        let loading = loading(&gap, &work)?;
        let direction = rows2(&direction, "direction")?;
        let failed: Mutex<Option<PyErr>> = Mutex::new(None);
        let outcome = match friction {
            FrictionArgument::Field(field) => {
                let friction = Friction::Field(flat(&field, "friction")?);
                enter(py, |monitor| {
                    self.0.slide(&loading, direction, friction, None, monitor)
                })
            }
            FrictionArgument::Law(function) => {
                let law = |pressure: &[f64]| {
                    Python::attach(|py| {
                        let pressure = pressure.to_vec().into_pyarray(py);
                        let found = function.call1(py, (pressure,))?;
                        let found: PyReadonlyArray1<'_, f64> = found.extract(py)?;
                        Ok(flat(&found, "friction")?.to_vec())
                    })
                    .map_err(|error: PyErr| {
                        *failed.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
                        Error::Interrupted
                    })
                };
                enter(py, |monitor| {
                    let friction = Friction::OfPressure(&law);
                    self.0.slide(&loading, direction, friction, None, monitor)
                })
            }
        };
        // an error of the law itself says more than that it broke the search off
        if let Some(error) = failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
            return Err(error);
        }
        PyOutcome::of(py, outcome?)
    }

    /// Factor on `friction` up to which the sliding state exists and is unique; `inf` where uncoupled.
    fn wedging_factor(
        &self,
        py: Python<'_>,
        direction: PyReadonlyArray2<'_, f64>,
        friction: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<f64> {
        let direction = rows2(&direction, "direction")?;
        let friction = flat(&friction, "friction")?;
        enter(py, |monitor| {
            self.0.wedging_factor(direction, friction, monitor)
        })
    }

    /// Forms the matrices of sliding in `direction` (2, n); whether friction changes the gap at all.
    fn prepare(
        &self,
        py: Python<'_>,
        direction: PyReadonlyArray2<'_, f64>,
        is_frictional: bool,
    ) -> PyResult<bool> {
        let direction = rows2(&direction, "direction")?;
        enter(py, |monitor| {
            self.0.prepare(direction, is_frictional, monitor)
        })
    }
}

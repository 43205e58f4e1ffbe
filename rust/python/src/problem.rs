// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contact problem.

use std::sync::{Arc, Mutex, PoisonError};

use mtb_contact::Error;
use mtb_contact::coupled::{Held, PointState};
use mtb_contact::interface::{Interface, RoughLaw};
use mtb_contact::magnet::Pulling;
use mtb_contact::problem::{
    Attracted, Body, FreeMotion, Friction, Geometry, Heating, Load, Loading, Means, Outcome,
    Problem, Window,
};
use mtb_contact::sliding::PRODUCTS_FROM;
use mtb_operator::Relative;
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::contact::{flat, status_name};
use crate::error::{bad_input, enter};
use crate::in_rows::InRows;
use crate::magnet::{Given, MagnetArgument, PySettled, pull};
use crate::operator::{PyCompliance, rows3};
use crate::tangent::{PyTangent, stacked};

/// The contact points of a problem in the common frame.
#[pyclass(frozen, name = "ContactGeometry", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyContactGeometry(pub(crate) Arc<Geometry>);

/// Starts of rows, columns, shares.
type MeansRows<'py> = (Vec<usize>, Vec<usize>, PyReadonlyArray1<'py, f64>);

#[pymethods]
impl PyContactGeometry {
    /// `points` (3, n) [m] at which the loads act; `frame`: (tangent x, tangent y, normal, and the means of the
    /// three), each (3, n), or `None` for a level surface; `means`: rows (n + 1), columns and shares of basis
    /// functions; `windows`: first point, points in a row and rows of grids beyond which the bodies go on.
    #[new]
    #[pyo3(signature = (points, area, frame=None, means=None, windows=None))]
    fn new(
        points: PyReadonlyArray2<'_, f64>,
        area: PyReadonlyArray1<'_, f64>,
        frame: Option<[PyReadonlyArray2<'_, f64>; 6]>,
        means: Option<MeansRows<'_>>,
        windows: Option<Vec<(usize, usize, usize)>>,
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
            windows: windows
                .unwrap_or_default()
                .into_iter()
                .map(|(start, nx, ny)| Window { start, nx, ny })
                .collect(),
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
        let values = traction.in_rows().map_err(|e| bad_input(&e))?;
        self.0
            .mean_tractions(values)
            .into_pyarray(py)
            .reshape(shape)
    }

    /// Tangents (2, 3, n) of each point: along x, and across.
    #[getter]
    fn tangents<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let both = [&*self.0.tangent_x, &self.0.tangent_y].concat();
        both.into_pyarray(py).reshape([2, 3, self.0.points()])
    }

    /// Weights (6, 3, n) of the unknowns that sum up to the components of the force [N] on the lower body and of its
    /// moment [N m] about a point.
    fn weights_of_resultants<'py>(
        &self,
        py: Python<'py>,
        about: [f64; 3],
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let weights = self.0.weights_of_resultants(about).concat();
        weights.into_pyarray(py).reshape([6, 3, self.0.points()])
    }

    /// Weights (k, n) of the unknowns that sum up to what weights (k, n) of their means do, about a pressure (n,).
    fn weights_of_means<'py>(
        &self,
        py: Python<'py>,
        weights: PyReadonlyArray2<'py, f64>,
        pressure: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (n, k) = (self.0.points(), weights.shape()[0]);
        let pressure = flat(&pressure, "pressure")?;
        if weights.shape() != [k, n] || pressure.len() != n {
            return Err(PyValueError::new_err(format!(
                "weights has shape {:?} and pressure {}, expected (k, {n}) and {n}",
                weights.shape(),
                pressure.len()
            )));
        }
        let weights = weights.in_rows().map_err(|e| bad_input(&e))?;
        let rows: Vec<Vec<f64>> = (0..k)
            .map(|i| {
                self.0
                    .weights_of_means(&weights[i * n..(i + 1) * n], pressure)
            })
            .collect();
        stacked(py, n, rows.iter())
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
    /// Slip along both tangents (2, n) [m] and the work of friction on it [J], of a step with a shift.
    slipped: Option<(Py<PyArray2<f64>>, f64)>,
    /// Tangential displacement by rigid motions and pose (2, n) [m], of a step.
    rigid: Option<Py<PyArray2<f64>>>,
    path_error: f64,
    /// Active sets or Newton steps.
    iterations: usize,
    factorisations: usize,
    products: usize,
    fell_back: bool,
    by_lemke: bool,
    residual: f64,
    unstable: bool,
    settled: Option<Py<PySettled>>,
}

impl PyOutcome {
    pub(crate) fn of(py: Python<'_>, outcome: Outcome) -> PyResult<Self> {
        let n = outcome.points.len();
        let codes: Vec<i8> = outcome.points.iter().copied().map(code).collect();
        let array = |values: Vec<f64>| values.into_pyarray(py).unbind();
        let solution = outcome.solution;
        let rows = |values: Vec<f64>| -> PyResult<Py<PyArray2<f64>>> {
            Ok(values.into_pyarray(py).reshape([2, n])?.unbind())
        };
        let slipped = match outcome.slipped {
            None => None,
            Some(slipped) => Some((rows(slipped.slip)?, slipped.work)),
        };
        Ok(Self {
            slipped,
            rigid: outcome.rigid.map(rows).transpose()?,
            status: status_name(solution.status),
            pressure: array(solution.pressure),
            gap: array(solution.gap),
            motion: array(solution.motion),
            friction: array(outcome.friction),
            traction: rows(outcome.traction)?,
            points: codes.into_pyarray(py).unbind(),
            force: array(outcome.force.to_vec()),
            moment: array(outcome.moment.to_vec()),
            friction_power: outcome.friction_power,
            path_error: outcome.path_error,
            iterations: outcome.effort.sets,
            factorisations: outcome.effort.factorisations,
            products: outcome.effort.products,
            fell_back: outcome.effort.fell_back,
            by_lemke: solution.by_lemke,
            residual: solution.residual,
            unstable: solution.unstable,
            settled: outcome
                .settled
                .map(|settled| PySettled::of(py, settled))
                .transpose()?,
        })
    }
}

/// Temperatures by fluxes, temperatures without them, speeds, resistance and share, openings by fluxes.
type HeatingArgument<'py> = (
    PyReadonlyArray3<'py, f64>,
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    (f64, f64),
    Option<PyReadonlyArray3<'py, f64>>,
);

fn same_lengths(found: &[(&str, usize)], expected: usize) -> PyResult<()> {
    match found.iter().find(|(_, size)| *size != expected) {
        None => Ok(()),
        Some((name, size)) => Err(PyValueError::new_err(format!(
            "{name} has {size} entries, expected {expected}"
        ))),
    }
}

fn heating_of<'a>(given: &'a HeatingArgument<'_>, n: usize) -> PyResult<Heating<'a>> {
    let (response, before, speed, (resistance, share), opening) = given;
    let response = response.in_rows().map_err(|e| bad_input(&e))?;
    let before = rows2(before, "before")?;
    let mut sizes = vec![
        ("response", response.len(), 2 * n * n),
        ("before", before.len(), 2 * n),
    ];
    let opening = match opening {
        None => None,
        Some(opening) => Some(opening.in_rows().map_err(|e| bad_input(&e))?),
    };
    sizes.extend(opening.map(|o| ("opening", o.len(), 2 * n * n)));
    for (name, found, expected) in sizes {
        same_lengths(&[(name, found)], expected)?;
    }
    Ok(Heating {
        response: response.split_at(n * n).into(),
        opening: opening.map(|o| o.split_at(n * n).into()),
        before: before.split_at(n).into(),
        speed: flat(speed, "speed")?,
        resistance: *resistance,
        share: *share,
    })
}

/// Traction (2, n), what each point does (n,), Newton steps, error of the path.
type HeldOutcome<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<i8>>,
    usize,
    f64,
);

/// States under a pressure that is held, after the upper body went along the tangents to each of some places (k, 2)
/// [m]; fewer if no state was found.
#[pyfunction]
#[allow(
    clippy::too_many_arguments,
    reason = "the bodies, their pressure and the way"
)]
pub(crate) fn stick_or_slip_held<'py>(
    py: Python<'py>,
    compliance: &Bound<'py, PyCompliance>,
    pressure: PyReadonlyArray1<'py, f64>,
    area: PyReadonlyArray1<'py, f64>,
    friction: PyReadonlyArray1<'py, f64>,
    layer: f64,
    displacements: Vec<[f64; 2]>,
    tolerance: f64,
) -> PyResult<Vec<HeldOutcome<'py>>> {
    let held = Held {
        compliance: &*compliance.get().0,
        layer,
        area: flat(&area, "area")?,
        friction: flat(&friction, "friction")?,
        pressure: flat(&pressure, "pressure")?,
    };
    let n = held.pressure.len();
    let states = enter(py, |monitor| {
        held.follow(&displacements, tolerance, monitor)
    })?;
    let told = states.into_iter().map(|state| {
        let points: Vec<i8> = state.points.into_iter().map(code).collect();
        Ok((
            state.traction.into_pyarray(py).reshape([2, n])?,
            points.into_pyarray(py),
            state.iterations,
            state.path_error,
        ))
    });
    told.collect()
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
pub(crate) struct PyProblem(pub(crate) Problem);

/// What is given to a problem for one solve: gap before contact, work on the free motions.
#[pyclass(frozen, name = "Loading", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyLoading(pub(crate) Loading);

#[pymethods]
impl PyLoading {
    /// Gap before contact (n,) [m], all displacements included that are known beforehand.
    #[getter]
    fn gap<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.gap.clone().into_pyarray(py)
    }

    /// Work (m,) [J] of all loads but the contact's on a unit of each motion.
    #[getter]
    fn work<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.work.clone().into_pyarray(py)
    }
}

/// Law of a rough layer: a length [m] and a pressure [Pa] of the exponential one, or openings [m] and pressures [Pa].
#[derive(FromPyObject)]
pub(crate) enum RoughArgument {
    Exponential(f64, f64),
    Table(Vec<f64>, Vec<f64>),
}

pub(crate) fn law_of(argument: RoughArgument) -> PyResult<RoughLaw> {
    let law = match argument {
        RoughArgument::Exponential(length, floor) => RoughLaw::exponential(length, floor),
        RoughArgument::Table(opening, pressure) => RoughLaw::table(opening, &pressure),
    };
    law.map_err(|e| bad_input(&e))
}

/// Coefficients (n,), or a function of the pressure (n,).
#[derive(FromPyObject)]
pub(crate) enum FrictionArgument<'py> {
    Field(PyReadonlyArray1<'py, f64>),
    Law(Py<PyAny>),
}

/// Gives `ask` the friction of an argument; what a law raises goes to `failed`.
pub(crate) fn with_friction<T>(
    argument: &FrictionArgument<'_>,
    failed: &Mutex<Option<PyErr>>,
    ask: impl FnOnce(Friction<'_>) -> T,
) -> PyResult<T> {
    let function = match argument {
        FrictionArgument::Field(field) => {
            return Ok(ask(Friction::Field(flat(field, "friction")?)));
        }
        FrictionArgument::Law(function) => function,
    };
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
    Ok(ask(Friction::OfPressure(&law)))
}

pub(crate) fn body(is_upper: bool) -> Body {
    if is_upper { Body::Upper } else { Body::Lower }
}

impl PyProblem {
    fn with(&self, loading: &Bound<'_, PyLoading>, load: Load<'_>) -> PyResult<PyLoading> {
        let mut loading = loading.get().0.clone();
        self.0.load(&mut loading, load).map_err(|e| bad_input(&e))?;
        Ok(PyLoading(loading))
    }
}

pub(crate) fn rows2<'a>(array: &'a PyReadonlyArray2<'_, f64>, name: &str) -> PyResult<&'a [f64]> {
    array
        .in_rows()
        .map_err(|_| PyValueError::new_err(format!("{name} must be C-contiguous")))
}

#[pymethods]
impl PyProblem {
    /// `lower`, `upper`: `None` for a rigid body; `motions` (m, 3, n): displacement of the contact points by a unit
    /// of each free motion, common frame; `of_upper`: whether each moves the upper body; `is_pulled`: whether a
    /// pull on that body works on it, by default so; `products_from`: points from which on bodies that allow it are
    /// solved by products; `layer` (n,): flexibilities of a layer between the bodies [m/Pa]; `hardness` (n,): pressures
    /// at which a body flows [Pa]; `shear` (n,): largest friction that a layer transmits [Pa]; `rough`: see `RoughArgument`.
    #[new]
    #[pyo3(signature = (
        lower, upper, geometry, motions, of_upper, is_pulled=None, products_from=PRODUCTS_FROM, layer=None,
        hardness=None, shear=None, rough=None
    ))]
    #[allow(
        clippy::too_many_arguments,
        reason = "one problem, by all it consists of"
    )]
    fn new(
        lower: Option<&Bound<'_, PyCompliance>>,
        upper: Option<&Bound<'_, PyCompliance>>,
        geometry: &Bound<'_, PyContactGeometry>,
        motions: PyReadonlyArray3<'_, f64>,
        of_upper: Vec<bool>,
        is_pulled: Option<Vec<bool>>,
        products_from: usize,
        layer: Option<PyReadonlyArray1<'_, f64>>,
        hardness: Option<PyReadonlyArray1<'_, f64>>,
        shear: Option<PyReadonlyArray1<'_, f64>>,
        rough: Option<RoughArgument>,
    ) -> PyResult<Self> {
        let [lower, upper] = [lower, upper].map(|c| c.map(|c| c.get().0.clone()));
        let mut pair = Relative::new(lower, upper).map_err(|e| bad_input(&e))?;
        if let Some(layer) = layer {
            let flexibility = flat(&layer, "layer")?.to_vec();
            pair = pair.with_layer(flexibility).map_err(|e| bad_input(&e))?;
        }
        let geometry = geometry.get().0.clone();
        let (n, count) = (geometry.points(), of_upper.len());
        let is_pulled = is_pulled.unwrap_or_else(|| vec![true; count]);
        if motions.shape() != [count, 3, n] || is_pulled.len() != count {
            return Err(PyValueError::new_err(format!(
                "motions has shape {:?}, expected ({count}, 3, {n}), for whose bodies of_upper has {count} \
                 entries and is_pulled {}",
                motions.shape(),
                is_pulled.len()
            )));
        }
        let flat = motions.in_rows().map_err(|e| bad_input(&e))?;
        let motions: Result<Vec<FreeMotion>, Error> = flat
            .chunks_exact((3 * n).max(1))
            .zip(of_upper)
            .zip(is_pulled)
            .map(|((displacement, is_upper), is_pulled)| {
                let free = FreeMotion::of(&geometry, body(is_upper), displacement)?;
                Ok(FreeMotion { is_pulled, ..free })
            })
            .collect();
        let motions = motions.map_err(|e| bad_input(&e))?;
        let problem = Problem::new(pair, geometry, motions).map_err(|e| bad_input(&e))?;
        let of = |given: &Option<PyReadonlyArray1<'_, f64>>, name| {
            let values = given.as_ref().map(|v| crate::contact::flat(v, name));
            Ok::<_, PyErr>(values.transpose()?.map(<[f64]>::to_vec))
        };
        let interface = Interface {
            limit: of(&hardness, "hardness")?,
            shear: of(&shear, "shear")?,
            rough: rough.map(law_of).transpose()?,
        };
        let problem = problem
            .with_interface(interface)
            .map_err(|e| bad_input(&e))?;
        Ok(Self(problem.by_products_from(products_from)))
    }

    /// The two bodies together, as every way of solving has them.
    #[getter]
    fn pair(&self) -> PyCompliance {
        PyCompliance(Arc::new(self.0.pair().clone()))
    }

    /// Whether it is solved by products, without a matrix.
    #[getter]
    fn is_by_products(&self) -> bool {
        self.0.is_by_products()
    }

    /// The free motions (m, 3, n): displacement of the lower body relative to the upper one along both tangents,
    /// and opening of the gap.
    #[getter]
    fn motions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let motions = self.0.motions();
        let all: Vec<f64> = motions
            .iter()
            .flat_map(|free| {
                let motion = &free.motion;
                [&motion.tangential_x, &motion.tangential_y, &motion.opening]
            })
            .flatten()
            .copied()
            .collect();
        let shape = [motions.len(), 3, self.0.points()];
        all.into_pyarray(py).reshape(shape)
    }

    /// Sliding with the heat of friction over one implicit step of the time, lower body first: temperatures by fluxes
    /// (2, n, n), temperatures without fluxes (2, n), speeds of the points (n,), and resistance and share; openings by
    /// fluxes (2, n, n), if any; wear before (n,) [m] and the diagonal (n,) [m/Pa] of the wear of the step, if any.
    /// Returns the state, fluxes (2, n), temperatures (2, n) and sets of points.
    #[allow(
        clippy::too_many_arguments,
        clippy::type_complexity,
        reason = "the fields of one struct"
    )]
    #[pyo3(signature = (loading, direction, friction, heating, worn=None, start=None, magnet=None, from_pull=None))]
    fn slide_heated<'py>(
        &self,
        py: Python<'py>,
        loading: &Bound<'_, PyLoading>,
        direction: PyReadonlyArray2<'_, f64>,
        friction: PyReadonlyArray1<'_, f64>,
        heating: HeatingArgument<'_>,
        worn: Option<(PyReadonlyArray1<'_, f64>, PyReadonlyArray1<'_, f64>)>,
        start: Option<Vec<bool>>,
        magnet: Option<MagnetArgument<'py>>,
        from_pull: Option<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<(
        PyOutcome,
        Bound<'py, PyArray2<f64>>,
        Bound<'py, PyArray2<f64>>,
        usize,
    )> {
        let n = self.0.points();
        let heating = heating_of(&heating, n)?;
        let mut loading = loading.get().0.clone();
        if let Some((worn, diagonal)) = &worn {
            let (worn, diagonal) = (flat(worn, "worn")?, flat(diagonal, "diagonal")?);
            same_lengths(&[("worn", worn.len()), ("diagonal", diagonal.len())], n)?;
            loading = loading.worn(worn, diagonal);
        }
        let direction = rows2(&direction, "direction")?;
        let friction = flat(&friction, "friction")?;
        let (given, from) = (magnet.map(Given::of), pull(from_pull.as_ref())?);
        let found = enter(py, |monitor| match &given {
            None => self
                .0
                .slide_heated(&loading, direction, friction, &heating, start, monitor),
            Some(given) => self.0.slide_heated_attracted(
                &loading,
                &given.magnet(),
                from,
                direction,
                friction,
                &heating,
                start,
                monitor,
            ),
        })?;
        let both = |[lower, upper]: [Vec<f64>; 2]| {
            [lower, upper].concat().into_pyarray(py).reshape([2, n])
        };
        Ok((
            PyOutcome::of(py, found.outcome)?,
            both(found.flux)?,
            both(found.temperature)?,
            found.rounds,
        ))
    }

    /// Factor on the heat of friction up to which the state of such a step exists and is unique where the points
    /// `active` (n,) touch, with a diagonal (n,) [m/Pa]; `inf` where heat opens no gap.
    #[pyo3(signature = (direction, friction, heating, active, diagonal=None))]
    fn thermal_factor(
        &self,
        py: Python<'_>,
        direction: PyReadonlyArray2<'_, f64>,
        friction: PyReadonlyArray1<'_, f64>,
        heating: HeatingArgument<'_>,
        active: Vec<bool>,
        diagonal: Option<PyReadonlyArray1<'_, f64>>,
    ) -> PyResult<f64> {
        let heating = heating_of(&heating, self.0.points())?;
        let direction = rows2(&direction, "direction")?;
        let friction = flat(&friction, "friction")?;
        let diagonal = match &diagonal {
            None => None,
            Some(diagonal) => Some(flat(diagonal, "diagonal")?),
        };
        enter(py, |monitor| {
            (self.0).thermal_factor(direction, friction, &heating, diagonal, &active, monitor)
        })
    }

    /// A loading: undeformed gap (n,) [m], and work (m,) [J] on the free motions.
    fn loading(
        &self,
        gap: PyReadonlyArray1<'_, f64>,
        work: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<PyLoading> {
        let mut loading = self.0.unloaded(flat(&gap, "gap")?.to_vec());
        loading.work = flat(&work, "work")?.to_vec();
        Ok(PyLoading(loading))
    }

    /// The first free motion that lets a body go along z while no load works on it.
    fn unpressed(&self, loading: &Bound<'_, PyLoading>) -> PyResult<Option<usize>> {
        let loading = &loading.get().0;
        self.0.unpressed(loading).map_err(|e| bad_input(&e))
    }

    /// The loading with a displacement (3, n) [m] of the points of one body, common frame.
    fn with_displacement(
        &self,
        loading: &Bound<'_, PyLoading>,
        displacement: PyReadonlyArray2<'_, f64>,
        is_upper: bool,
    ) -> PyResult<PyLoading> {
        let displacement = rows3(&displacement, self.0.points(), "displacement")?.concat();
        self.with(loading, Load::Displacement(&displacement, body(is_upper)))
    }

    /// The loading with a pull (n,) [Pa] on one body, at its face or by its resultant alone.
    fn with_pull(
        &self,
        loading: &Bound<'_, PyLoading>,
        pull: PyReadonlyArray1<'_, f64>,
        is_upper: bool,
        at_face: bool,
    ) -> PyResult<PyLoading> {
        let body = body(is_upper);
        let load = Attracted { body, at_face }.by(flat(&pull, "pull")?);
        self.with(loading, load)
    }

    /// Displacement (3, n) [m] of the points of one body, common frame, by the tractions (3, n) [Pa] of the
    /// contact (on the lower body, and pressure), less a `pull` (n,) [Pa] at its face.
    #[pyo3(signature = (traction, is_upper, pull=None))]
    fn displacement<'py>(
        &self,
        py: Python<'py>,
        traction: PyReadonlyArray2<'py, f64>,
        is_upper: bool,
        pull: Option<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let n = self.0.points();
        let traction = rows3(&traction, n, "traction")?.concat();
        let pull = match &pull {
            None => None,
            Some(pull) => Some(flat(pull, "pull")?),
        };
        let moved = enter(py, |_| self.0.displacement(body(is_upper), &traction, pull))?;
        moved.into_pyarray(py).reshape([3, n])
    }

    /// The upper body slides in `direction` (2, n), every point in contact with friction; under a `magnet` besides the
    /// loading, whose state is looked for from a pull (n,) [Pa], or from that at the gap of the loading. Then also, with
    /// `share`, how much of a change of the pull comes back.
    #[pyo3(signature = (loading, direction, friction, magnet=None, from_pull=None, share=false))]
    #[allow(clippy::too_many_arguments, reason = "a slide, and a magnet")]
    fn slide(
        &self,
        py: Python<'_>,
        loading: &Bound<'_, PyLoading>,
        direction: PyReadonlyArray2<'_, f64>,
        friction: FrictionArgument<'_>,
        magnet: Option<MagnetArgument<'_>>,
        from_pull: Option<PyReadonlyArray1<'_, f64>>,
        share: bool,
    ) -> PyResult<PyOutcome> {
        let loading = &loading.get().0;
        let (given, from) = (magnet.map(Given::of), pull(from_pull.as_ref())?);
        let direction = rows2(&direction, "direction")?;
        let failed: Mutex<Option<PyErr>> = Mutex::new(None);
        let outcome = with_friction(&friction, &failed, |friction| {
            enter(py, |monitor| match &given {
                None => self.0.slide(loading, direction, friction, None, monitor),
                Some(given) => self.0.slide_attracted(
                    loading,
                    &given.magnet(),
                    from,
                    direction,
                    friction,
                    None,
                    share,
                    monitor,
                ),
            })
        })?;
        // an error of the law itself says more than that it broke the search off
        if let Some(error) = failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
            return Err(error);
        }
        PyOutcome::of(py, outcome?)
    }

    /// The bodies are pressed together without friction, then the points of the upper one are displaced to each
    /// of `displacements` (k, 3, n) [m] with friction `friction` (n,), a layer [m/Pa] between them. The outcomes end where no
    /// state was found.
    fn stick_or_slip(
        &self,
        py: Python<'_>,
        loading: &Bound<'_, PyLoading>,
        friction: PyReadonlyArray1<'_, f64>,
        layer: f64,
        displacements: PyReadonlyArray3<'_, f64>,
        tolerance: f64,
    ) -> PyResult<Vec<PyOutcome>> {
        let (loading, friction) = (&loading.get().0, flat(&friction, "friction")?);
        let n = self.0.points();
        if displacements.shape()[1..] != [3, n] {
            return Err(PyValueError::new_err(format!(
                "displacements has shape {:?}, expected (k, 3, {n})",
                displacements.shape()
            )));
        }
        let displacements: Vec<Vec<f64>> = displacements
            .in_rows()
            .map_err(|e| bad_input(&e))?
            .chunks_exact((3 * n).max(1))
            .map(<[f64]>::to_vec)
            .collect();
        let outcomes = enter(py, |monitor| {
            self.0
                .stick_or_slip(loading, friction, layer, &displacements, tolerance, monitor)
        })?;
        outcomes.into_iter().map(|o| PyOutcome::of(py, o)).collect()
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
            self.0.wedging_factor(direction, friction, None, monitor)
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

    /// The equations of a sliding state linearised about it: pressure, friction, slope of friction times pressure over
    /// the pressure (n,) and direction (2, n); unless it `is_coupled`, friction opens and closes no gap; `by_products`
    /// no matrix is formed. A `magnet` follows the `gap` (n,) [m].
    #[pyo3(signature = (pressure, friction, slope, direction, is_coupled, by_products, magnet=None, gap=None))]
    #[allow(clippy::too_many_arguments, reason = "a state of the contact")]
    fn tangent(
        &self,
        py: Python<'_>,
        pressure: PyReadonlyArray1<'_, f64>,
        friction: PyReadonlyArray1<'_, f64>,
        slope: PyReadonlyArray1<'_, f64>,
        direction: PyReadonlyArray2<'_, f64>,
        is_coupled: bool,
        by_products: bool,
        magnet: Option<MagnetArgument<'_>>,
        gap: Option<PyReadonlyArray1<'_, f64>>,
    ) -> PyResult<PyTangent> {
        let free: Vec<usize> = (0..self.0.motions().len()).collect();
        let gap = gap.as_ref().map(|gap| flat(gap, "gap")).transpose()?;
        let pulling = match (magnet.map(Given::of), gap) {
            (Some(given), Some(gap)) => {
                let pulling = Pulling::new(&self.0, &given.magnet(), gap, &free);
                Some(pulling.map_err(|e| bad_input(&e))?)
            }
            _ => None,
        };
        let (pressure, friction) = (flat(&pressure, "pressure")?, flat(&friction, "friction")?);
        let (slope, direction) = (flat(&slope, "slope")?, rows2(&direction, "direction")?);
        let linearised = enter(py, |monitor| {
            self.0.linearised(
                pressure,
                friction,
                slope,
                direction,
                None,
                is_coupled,
                by_products,
                monitor,
            )
        })?;
        let linearised = linearised.with_magnet(pulling);
        Ok(PyTangent::own(linearised, self.0.points(), free.len()))
    }
}

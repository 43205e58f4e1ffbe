// SPDX-License-Identifier: MIT OR Apache-2.0
//! Temperatures of bodies that rub on each other.

use std::sync::Arc;

use mtb_contact::steps::{Gathered, StepControl};
use mtb_elasticity::tetra::{ConductingBody, ConductionModes, ConductionStep, Film, Seen};
use mtb_heat::{Conductor, Error, HalfSpace, Passage, rolling};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;

use crate::error::{bad_input, enter};
use crate::in_rows::InRows;
use crate::tetra::{PySampling, PyTetraMesh, pairs};

/// Conductivity [W/(m K)], density [kg/m3], specific heat [J/(kg K)].
pub(crate) type Constants = (f64, f64, f64);

pub(crate) fn conductor((conductivity, density, specific_heat): Constants) -> PyResult<Conductor> {
    Conductor::new(conductivity, density, specific_heat).map_err(|error| bad_input(&error))
}

/// Surface temperatures (2, ny, nx) [K] and fluxes (2, ny, nx) [W/m2] of lower and upper body in steady rolling,
/// from the heat of friction `power` (ny, nx) [W/m2].
#[pyfunction]
#[allow(
    clippy::too_many_arguments,
    clippy::type_complexity,
    reason = "the fields of one struct"
)]
pub(crate) fn rolling_temperatures<'py>(
    py: Python<'py>,
    power: PyReadonlyArray2<'_, f64>,
    touches: PyReadonlyArray2<'_, bool>,
    spacing: [f64; 2],
    angle: f64,
    speed: f64,
    bodies: [Constants; 2],
    bulk: [f64; 2],
) -> PyResult<(Bound<'py, PyArray3<f64>>, Bound<'py, PyArray3<f64>>)> {
    let (ny, nx) = (power.shape()[0], power.shape()[1]);
    let [lower, upper] = bodies;
    let bodies = [conductor(lower)?, conductor(upper)?];
    let (power, touches) = (power.to_vec()?, touches.to_vec()?);
    let found = enter(py, |_| -> Result<_, Error> {
        rolling(&Passage {
            shape: [nx, ny],
            spacing,
            angle,
            speed,
            power: &power,
            touches: &touches,
            bodies,
            bulk,
        })
    })?;
    let both = |[lower, upper]: [Vec<f64>; 2]| {
        [lower, upper]
            .concat()
            .into_pyarray(py)
            .reshape([2, ny, nx])
    };
    Ok((both(found.surface)?, both(found.flux)?))
}

/// A mesh of tetrahedra that conducts heat.
#[pyclass(frozen, name = "ConductingBody", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyConductingBody(Arc<ConductingBody>);

#[pymethods]
impl PyConductingBody {
    /// `films`: boundary triangles, heat transfer coefficient [W/(m2 K)] and temperature outside [K] of each.
    #[new]
    fn new(
        py: Python<'_>,
        mesh: &Bound<'_, PyTetraMesh>,
        conductor: Constants,
        films: Vec<(Vec<usize>, f64, f64)>,
    ) -> PyResult<Self> {
        let mesh = Arc::new(mesh.get().0.clone());
        let films: Vec<Film> = films
            .into_iter()
            .map(|(faces, coefficient, ambient)| Film {
                faces,
                coefficient,
                ambient,
            })
            .collect();
        let conductor = self::conductor(conductor)?;
        enter(py, |monitor| {
            ConductingBody::new(mesh, conductor, &films, monitor)
        })
        .map(|body| Self(Arc::new(body)))
    }

    /// Heat [J] at temperatures of the nodes (N,) [K], above that at zero.
    fn heat(&self, temperature: PyReadonlyArray1<'_, f64>) -> PyResult<f64> {
        self.0
            .heat(&temperature.to_vec()?)
            .map_err(|error| bad_input(&error))
    }

    /// Heat flow [W] that leaves through films at temperatures of the nodes (N,) [K].
    fn loss(&self, temperature: PyReadonlyArray1<'_, f64>) -> PyResult<f64> {
        self.0
            .loss(&temperature.to_vec()?)
            .map_err(|error| bad_input(&error))
    }

    /// An implicit step over `duration` [s] with heat through contact points.
    fn step(
        &self,
        py: Python<'_>,
        duration: f64,
        sampling: &Bound<'_, PySampling>,
    ) -> PyResult<PyConductionStep> {
        let sampling = &sampling.get().0;
        enter(py, |monitor| self.0.step(duration, sampling, monitor)).map(PyConductionStep)
    }

    /// The body in modes that hold its answers to fluxes through contact points in steps of any duration.
    fn modes(
        &self,
        py: Python<'_>,
        sampling: &Bound<'_, PySampling>,
    ) -> PyResult<PyConductionModes> {
        let sampling = &sampling.get().0;
        enter(py, |monitor| self.0.modes(sampling, monitor)).map(PyConductionModes)
    }
}

/// An implicit step of a conducting body, condensed onto contact points.
#[pyclass(frozen, name = "ConductionStep", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyConductionStep(ConductionStep);

#[pymethods]
impl PyConductionStep {
    /// Temperatures (n, n) [K m2/W] of the contact points by a unit flux into each.
    #[getter]
    fn response<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let n = self.0.weights().len();
        self.0.response().to_vec().into_pyarray(py).reshape([n, n])
    }

    /// Areas (n,) [m2] of the contact points.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.weights().to_vec().into_pyarray(py)
    }

    /// Temperatures of the contact points (n,) [K] under those of the nodes (N,).
    fn observe<'py>(
        &self,
        py: Python<'py>,
        temperature: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let found = self.0.observe(&temperature.to_vec()?);
        Ok(found.map_err(|error| bad_input(&error))?.into_pyarray(py))
    }

    /// What a step from temperatures of the nodes (N,) [K] comes to without any flux, between its two substitutions
    /// (w,).
    fn coast<'py>(
        &self,
        py: Python<'py>,
        temperature: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let temperature = temperature.to_vec()?;
        let found = enter(py, |_| self.0.coast(&temperature))?;
        Ok(found.into_pyarray(py))
    }

    /// Temperatures of the contact points (n,) [K] at the end of a step that was coasted (w,).
    fn observe_coasted<'py>(
        &self,
        py: Python<'py>,
        coasted: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let found = self.0.observe_coasted(&coasted.to_vec()?);
        Ok(found.map_err(|error| bad_input(&error))?.into_pyarray(py))
    }

    /// Temperatures of the nodes (N,) [K] at the end of a step that was coasted (w,), with a flux (n,) [W/m2].
    fn end<'py>(
        &self,
        py: Python<'py>,
        coasted: PyReadonlyArray1<'_, f64>,
        flux: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (coasted, flux) = (coasted.to_vec()?, flux.to_vec()?);
        let found = enter(py, |_| self.0.end(&coasted, &flux))?;
        Ok(found.into_pyarray(py))
    }

    /// What sums over the temperatures of the nodes (m, N) at the end of a step are of what it comes to without any
    /// flux.
    fn seen(&self, py: Python<'_>, rows: PyReadonlyArray2<'_, f64>) -> PyResult<PySeen> {
        let rows = rows.to_vec()?;
        enter(py, |monitor| self.0.seen(&rows, monitor)).map(PySeen)
    }

    /// What they are (m,) at the end of a step that was coasted (w,).
    fn seen_coasted<'py>(
        &self,
        py: Python<'py>,
        seen: &PySeen,
        coasted: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let coasted = coasted.in_rows().map_err(|e| bad_input(&e))?;
        let found = self.0.seen_coasted(&seen.0, coasted);
        Ok(found.map_err(|error| bad_input(&error))?.into_pyarray(py))
    }

    /// What they are of the temperatures at the end of a step by a unit flux into each contact point: (m, n).
    fn response_of<'py>(
        &self,
        py: Python<'py>,
        seen: &PySeen,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let found = enter(py, |_| self.0.response_of(&seen.0))?;
        let n = self.0.weights().len();
        let m = found.len() / n.max(1);
        found.into_pyarray(py).reshape([m, n])
    }
}

/// What sums over the temperatures at the end of a step are of what it comes to.
#[pyclass(frozen, name = "Seen", module = "mtb_rs._mtb_rs")]
pub(crate) struct PySeen(Seen);

/// A conducting body in modes, in which implicit steps of any duration are diagonal.
#[pyclass(frozen, name = "ConductionModes", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyConductionModes(ConductionModes);

#[pymethods]
impl PyConductionModes {
    /// Number of the modes.
    fn __len__(&self) -> usize {
        self.0.count()
    }

    /// Areas (n,) [m2] of the contact points.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.weights().to_vec().into_pyarray(py)
    }

    /// The body with another conductivity [W/(m K)]; amplitudes keep their meaning.
    fn with_conductivity(&self, py: Python<'_>, conductivity: f64) -> PyResult<Self> {
        enter(py, |_| self.0.with_conductivity(conductivity)).map(Self)
    }

    /// Amplitudes (r,) of a uniform temperature [K].
    fn uniform<'py>(&self, py: Python<'py>, temperature: f64) -> Bound<'py, PyArray1<f64>> {
        self.0.uniform(temperature).into_pyarray(py)
    }

    /// Temperatures of the nodes (N,) [K] at amplitudes (r,).
    fn temperature<'py>(
        &self,
        py: Python<'py>,
        amplitudes: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let found = self.0.temperature(&amplitudes.to_vec()?);
        Ok(found.map_err(|error| bad_input(&error))?.into_pyarray(py))
    }

    /// Temperatures of the contact points (n,) [K] at amplitudes (r,).
    fn observe<'py>(
        &self,
        py: Python<'py>,
        amplitudes: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let found = self.0.observe(&amplitudes.to_vec()?);
        Ok(found.map_err(|error| bad_input(&error))?.into_pyarray(py))
    }

    /// Sums over the temperatures of the nodes (m, N) as sums over the amplitudes (m, r).
    fn seen<'py>(
        &self,
        py: Python<'py>,
        rows: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let shape = [rows.shape()[0], self.0.count()];
        let rows = rows.to_vec()?;
        enter(py, |_| self.0.seen(&rows))?
            .into_pyarray(py)
            .reshape(shape)
    }

    /// Heat [J] at amplitudes (r,), above that at zero.
    fn heat(&self, amplitudes: PyReadonlyArray1<'_, f64>) -> PyResult<f64> {
        self.0
            .heat(&amplitudes.to_vec()?)
            .map_err(|error| bad_input(&error))
    }

    /// Heat flow [W] that leaves through films at amplitudes (r,).
    fn loss(&self, amplitudes: PyReadonlyArray1<'_, f64>) -> PyResult<f64> {
        self.0
            .loss(&amplitudes.to_vec()?)
            .map_err(|error| bad_input(&error))
    }

    /// Amplitudes (r,) at the end of a step over a duration [s], with a flux (n,) [W/m2].
    fn advance<'py>(
        &self,
        py: Python<'py>,
        duration: f64,
        amplitudes: PyReadonlyArray1<'_, f64>,
        flux: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (amplitudes, flux) = (amplitudes.to_vec()?, flux.to_vec()?);
        let found = enter(py, |_| self.0.advance(duration, &amplitudes, &flux))?;
        Ok(found.into_pyarray(py))
    }

    /// Temperatures (n, n) [K m2/W] of the contact points at the end of a step by a unit flux into each.
    fn response<'py>(&self, py: Python<'py>, duration: f64) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let n = self.0.weights().len();
        let found = enter(py, |_| self.0.response(duration))?;
        found.into_pyarray(py).reshape([n, n])
    }

    /// The same (m, n) of what `seen` found (m, r).
    fn response_of<'py>(
        &self,
        py: Python<'py>,
        duration: f64,
        seen: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let shape = [seen.shape()[0], self.0.weights().len()];
        let seen = seen.to_vec()?;
        enter(py, |_| self.0.response_of(duration, &seen))?
            .into_pyarray(py)
            .reshape(shape)
    }
}

/// Temperatures (n, n) [K m2/W] of a half-space that moves with a velocity [m/s] at points (n, 2) [m] by a unit flux
/// into rectangles of sizes (n, 2) [m] around them.
#[pyfunction]
pub(crate) fn moving_half_space<'py>(
    py: Python<'py>,
    conductor: Constants,
    velocity: [f64; 2],
    points: PyReadonlyArray2<'_, f64>,
    sizes: PyReadonlyArray2<'_, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let moving = HalfSpace::new(self::conductor(conductor)?, velocity);
    let moving = moving.map_err(|error| bad_input(&error))?;
    let (points, sizes) = (pairs(&points, "points")?, pairs(&sizes, "sizes")?);
    let n = points.len();
    let warm = enter(py, |_| moving.influences(&points, &sizes))?;
    warm.into_pyarray(py).reshape([n, n])
}

/// How far points (n, 2) [m] of a half-space that moves with a velocity [m/s] rise by a unit flux into rectangles of
/// sizes (n, 2) [m] around them (n, n) [m3/W], for a coefficient of linear expansion [1/K] and Poisson's ratio.
#[pyfunction]
pub(crate) fn swelling<'py>(
    py: Python<'py>,
    conductor: Constants,
    velocity: [f64; 2],
    points: PyReadonlyArray2<'_, f64>,
    sizes: PyReadonlyArray2<'_, f64>,
    expansion: f64,
    poisson_ratio: f64,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let moving = HalfSpace::new(self::conductor(conductor)?, velocity);
    let moving = moving.map_err(|error| bad_input(&error))?;
    let (points, sizes) = (pairs(&points, "points")?, pairs(&sizes, "sizes")?);
    let n = points.len();
    let risen = enter(py, |_| {
        moving.swelling(&points, &sizes, expansion, poisson_ratio)
    })?;
    risen.into_pyarray(py).reshape([n, n])
}

/// Chooses the lengths of implicit steps by the estimates of their errors.
#[pyclass(name = "StepControl", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyStepControl(StepControl);

#[pymethods]
impl PyStepControl {
    #[new]
    #[pyo3(signature = (tolerance, next=None))]
    fn new(tolerance: f64, next: Option<f64>) -> Self {
        let mut control = StepControl::new(tolerance);
        control.begin_with(next);
        Self(control)
    }

    /// The length that the last step promises for the next one.
    #[getter]
    fn next(&self) -> Option<f64> {
        self.0.next()
    }

    /// Whether so many lengths were tried in vain that no step is short enough.
    #[getter]
    fn is_stuck(&self) -> bool {
        self.0.is_stuck()
    }

    /// The length to try first, where `most` is left.
    fn length(&self, most: f64) -> f64 {
        self.0.length(most)
    }

    /// None if a step of a length is taken with its error, NaN for one without a state; otherwise the length to try.
    fn judge(&mut self, length: f64, most: f64, error: f64) -> Option<f64> {
        self.0.judge(length, most, error)
    }
}

/// The error of an implicit step of a length, in parts of what it adds and a tenth of all: from what was there before
/// it (n,), the rate before it (n,) and the rate after it (n,), with areas (n,) [m2].
#[pyfunction]
pub(crate) fn step_error(
    area: PyReadonlyArray1<'_, f64>,
    before: PyReadonlyArray1<'_, f64>,
    length: f64,
    rate: PyReadonlyArray1<'_, f64>,
    after: PyReadonlyArray1<'_, f64>,
) -> PyResult<f64> {
    let (area, before) = (area.to_vec()?, before.to_vec()?);
    let (rate, after) = (rate.to_vec()?, after.to_vec()?);
    if [before.len(), rate.len(), after.len()] != [area.len(); 3] {
        return Err(bad_input(&"area, before, rate and after differ in length"));
    }
    let step: Vec<f64> = after.iter().map(|r| length * r).collect();
    let gathered = Gathered {
        area: &area,
        before: &before,
        step: &step,
    };
    Ok(gathered.of_length(length, &rate, &step))
}

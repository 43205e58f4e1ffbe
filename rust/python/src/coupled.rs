// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stick and slip with a pressure that follows.

use mtb_contact::coupled::{Coupled, CoupledContact, CoupledState};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3,
};
use pyo3::prelude::*;

use crate::contact::{flat, rigid_motions};
use crate::error::enter;
use crate::operator::{PyCompliance, rows3};
use crate::problem::code;

/// Normal and tangential contact of two bodies, solved as one.
#[pyclass(frozen, name = "CoupledContact", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyCoupledContact(CoupledContact);

/// A state of such a contact.
#[pyclass(frozen, name = "CoupledState", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyCoupledState(CoupledState);

#[pymethods]
impl PyCoupledContact {
    /// `compliance`: of both bodies together; `layer` [m/Pa]; `gap` (n,) [m] before contact; `motions` (m, 3, n):
    /// relative displacement along x and y, opening; `work` (m,) [J].
    #[new]
    #[allow(
        clippy::too_many_arguments,
        reason = "the arrays of one contact problem"
    )]
    fn new(
        py: Python<'_>,
        compliance: &Bound<'_, PyCompliance>,
        layer: f64,
        area: PyReadonlyArray1<'_, f64>,
        friction: PyReadonlyArray1<'_, f64>,
        gap: PyReadonlyArray1<'_, f64>,
        motions: PyReadonlyArray3<'_, f64>,
        work: PyReadonlyArray1<'_, f64>,
        tolerance: f64,
    ) -> PyResult<Self> {
        let compliance = compliance.get().0.clone();
        let motions = rigid_motions(&motions, flat(&work, "work")?, compliance.points())?;
        let contact = Coupled {
            compliance: &*compliance,
            layer,
            area: flat(&area, "area")?,
            friction: flat(&friction, "friction")?,
            gap: flat(&gap, "gap")?,
            motions: &motions,
        };
        enter(py, |monitor| {
            CoupledContact::new(&contact, tolerance, monitor)
        })
        .map(Self)
    }

    /// The bodies pressed together without friction: their pressure (n,) [Pa] and motions (m,).
    fn at_rest(
        &self,
        py: Python<'_>,
        pressure: PyReadonlyArray1<'_, f64>,
        motion: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<PyCoupledState> {
        let (pressure, motion) = (flat(&pressure, "pressure")?, flat(&motion, "motion")?);
        enter(py, |_| self.0.at_rest(pressure, motion)).map(PyCoupledState)
    }

    /// The state after the upper body was pushed from `state` to `push` (3, n) [m]; `None` if none was found.
    fn advance(
        &self,
        py: Python<'_>,
        state: &Bound<'_, PyCoupledState>,
        push: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Option<PyCoupledState>> {
        let push = rows3(&push, self.0.points(), "push")?.concat();
        let state = state.get();
        let found = enter(py, |monitor| self.0.advance(&state.0, &push, monitor))?;
        Ok(found.map(PyCoupledState))
    }
}

#[pymethods]
impl PyCoupledState {
    /// Tractions (2, n) [Pa] along both tangents on the lower body.
    #[getter]
    fn traction<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let n = self.0.points.len();
        let traction = self.0.traction[..2 * n].to_vec();
        traction.into_pyarray(py).reshape([2, n])
    }

    /// Pressure (n,) [Pa].
    #[getter]
    fn pressure<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.pressure().to_vec().into_pyarray(py)
    }

    /// Displacement (3, n) [m] of the lower body relative to the upper one, along the tangents; opening.
    #[getter]
    fn displacement<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let displacement = self.0.displacement.clone();
        let n = self.0.points.len();
        displacement.into_pyarray(py).reshape([3, n])
    }

    /// 0 open, 1 stick, 2 slip (n,).
    #[getter]
    fn status<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i8>> {
        let codes: Vec<i8> = self.0.points.iter().copied().map(code).collect();
        codes.into_pyarray(py)
    }

    /// Newton steps.
    #[getter]
    fn iterations(&self) -> usize {
        self.0.iterations
    }
}

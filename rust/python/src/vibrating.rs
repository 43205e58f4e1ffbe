// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies that vibrate on their contact.

use std::sync::{Mutex, PoisonError};

use mtb_contact::coupled::{KeptInverse, PointState};
use mtb_contact::prepared::Table;
use mtb_contact::vibrating::{Movement, Touching, VibratingContact, VibratingState};
use numpy::{IntoPyArray, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::contact::flat;
use crate::error::{bad_input, enter};
use crate::in_rows::InRows;

/// Traction (3n,), amplitude, rate and load (k,) of a state.
type StateArgument<'py> = (
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
);

/// Bodies that vibrate on their contact, in steps of one length.
#[pyclass(frozen, name = "VibratingContact", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyVibratingContact {
    contact: VibratingContact,
    kept: Mutex<KeptInverse>,
}

fn rows(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<f64>> {
    array
        .in_rows()
        .map(<[f64]>::to_vec)
        .map_err(|e| bad_input(&e))
}

fn state_of(given: &StateArgument<'_>) -> PyResult<VibratingState> {
    Ok(VibratingState {
        traction: flat(&given.0, "traction")?.to_vec(),
        amplitude: flat(&given.1, "amplitude")?.to_vec(),
        rate: flat(&given.2, "rate")?.to_vec(),
        load: flat(&given.3, "load")?.to_vec(),
    })
}

#[pymethods]
impl PyVibratingContact {
    /// `compliance` (3n, 3n), `shapes` (3n, k) lower less upper along both tangents and opening; `friction` (t, n) over
    /// its speeds; tractions (3n,) and gap (n,) at the beginning.
    #[new]
    #[allow(clippy::too_many_arguments, reason = "what one contact is made of")]
    fn new(
        py: Python<'_>,
        compliance: PyReadonlyArray2<'_, f64>,
        area: PyReadonlyArray1<'_, f64>,
        friction_speed: Vec<f64>,
        friction: PyReadonlyArray2<'_, f64>,
        traction: PyReadonlyArray1<'_, f64>,
        gap: PyReadonlyArray1<'_, f64>,
        mass: PyReadonlyArray2<'_, f64>,
        damping: PyReadonlyArray2<'_, f64>,
        stiffness: PyReadonlyArray2<'_, f64>,
        shapes: PyReadonlyArray2<'_, f64>,
        step: f64,
    ) -> PyResult<Self> {
        let columns = friction.shape()[1].max(1);
        let coefficients = rows(&friction)?;
        let coefficients = coefficients.chunks_exact(columns);
        let coefficients = coefficients.map(<[f64]>::to_vec).collect();
        let touching = Touching {
            compliance: rows(&compliance)?,
            area: flat(&area, "area")?.to_vec(),
            friction: Table::new(friction_speed, coefficients).map_err(|e| bad_input(&e))?,
            traction: flat(&traction, "traction")?.to_vec(),
            gap: flat(&gap, "gap")?.to_vec(),
        };
        let movement = Movement {
            coordinates: mass.shape()[0],
            mass: rows(&mass)?,
            damping: rows(&damping)?,
            stiffness: rows(&stiffness)?,
            shapes: rows(&shapes)?,
        };
        let contact = enter(py, |monitor| {
            VibratingContact::new(touching, &movement, step, monitor)
        })?;
        Ok(Self {
            contact,
            kept: Mutex::new(KeptInverse::default()),
        })
    }

    /// Kinetic energy, that of the stiffness, and that of the contact [J] in a state.
    fn energy(&self, py: Python<'_>, state: StateArgument<'_>) -> PyResult<(f64, f64, f64)> {
        let state = state_of(&state)?;
        let found = enter(py, |_| self.contact.energy(&state))?;
        Ok((found.kinetic, found.potential, found.contact))
    }

    /// The step after a state, as arrays by name; `None` if none was found.
    #[pyo3(signature = (state, drive, load, friction=None))]
    fn step<'py>(
        &self,
        py: Python<'py>,
        state: StateArgument<'py>,
        drive: PyReadonlyArray1<'py, f64>,
        load: PyReadonlyArray1<'py, f64>,
        friction: Option<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let state = state_of(&state)?;
        let (drive, load) = (flat(&drive, "drive")?, flat(&load, "load")?);
        let friction = friction
            .as_ref()
            .map(|mu| flat(mu, "friction"))
            .transpose()?;
        let found = enter(py, |monitor| {
            let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
            self.contact
                .step(&state, drive, load, friction, &mut kept, monitor)
        })?;
        let Some(found) = found else {
            return Ok(None);
        };
        let points: Vec<i8> = found
            .points
            .iter()
            .map(|point| match point {
                PointState::Open => 0,
                PointState::Stick => 1,
                PointState::Slip => 2,
            })
            .collect();
        let out = PyDict::new(py);
        for (name, values) in [
            ("traction", found.state.traction),
            ("amplitude", found.state.amplitude),
            ("rate", found.state.rate),
            ("load", found.state.load),
            ("slip", found.slip),
            ("gap", found.gap),
            ("friction", found.friction),
        ] {
            out.set_item(name, values.into_pyarray(py))?;
        }
        out.set_item("points", points.into_pyarray(py))?;
        let work = found.work;
        for (name, value) in [
            ("friction_work", work.friction),
            ("drive_work", work.drive),
            ("load_work", work.load),
            ("damping_work", work.damping),
            ("closing_work", work.closing),
            ("residual", found.residual),
        ] {
            out.set_item(name, value)?;
        }
        out.set_item("iterations", found.iterations)?;
        Ok(Some(out))
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sliding states, linearised.

use std::sync::{Arc, Mutex, PoisonError};

use mtb_contact::prepared::Taken;
use mtb_contact::stepping::{Found, Given, Linearised, Tangent};
use mtb_operator::Monitor;
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::{Failure, bad_input, enter};
use crate::prepared::PyPreparedContact;

/// Rows of equal length, one a case.
pub(crate) type Rows<'py> = Bound<'py, PyArray2<f64>>;

/// Where the factors are.
enum Source {
    Own(Box<Mutex<Linearised>>),
    Step(Py<PyPreparedContact>, Arc<Taken>),
}

/// The equations of a sliding state, linearised about it: small changes of what is found by those of what is given,
/// and gradients the other way round, any number of cases (k) at once.
#[pyclass(frozen, name = "Tangent", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyTangent {
    source: Source,
    points: usize,
    motions: usize,
}

impl PyTangent {
    pub(crate) fn own(linearised: Linearised, points: usize, motions: usize) -> Self {
        Self {
            source: Source::Own(Box::new(Mutex::new(linearised))),
            points,
            motions,
        }
    }

    pub(crate) fn of_step(contact: Py<PyPreparedContact>, taken: Arc<Taken>) -> Self {
        let state = taken.state();
        let (points, motions) = (state.pressure.len(), state.motions.len());
        Self {
            source: Source::Step(contact, taken),
            points,
            motions,
        }
    }

    fn with<T: Send>(
        &self,
        py: Python<'_>,
        ask: impl FnOnce(&mut Tangent<'_>, Monitor<'_>) -> Result<T, mtb_contact::Error> + Send,
    ) -> PyResult<T> {
        match &self.source {
            Source::Own(linearised) => enter(py, |monitor| -> Result<T, Failure> {
                let mut held = linearised.lock().unwrap_or_else(PoisonError::into_inner);
                Ok(ask(&mut held.tangent()?, monitor)?)
            }),
            Source::Step(contact, taken) => {
                let contact = contact.get();
                enter(py, |monitor| -> Result<T, Failure> {
                    let mut held = contact.lock();
                    Ok(ask(&mut held.tangent(taken, monitor)?, monitor)?)
                })
            }
        }
    }
}

/// Changes of gap (k, n), work (k, m) and friction times direction (k, 2n).
type Changes<'py> = [Rows<'py>; 3];

#[pymethods]
impl PyTangent {
    /// What a unit of each input of a step changes (pose, velocity, magnetic pressure: 9): gap, work, and friction
    /// times direction; `None` of a state that is no step.
    fn inputs<'py>(&self, py: Python<'py>) -> PyResult<Option<Changes<'py>>> {
        let Source::Step(contact, taken) = &self.source else {
            return Ok(None);
        };
        let given = contact.get().prepared().inputs(taken);
        Ok(Some(changes(
            py,
            self.points,
            self.motions,
            &given.map_err(|e| bad_input(&e))?,
        )?))
    }

    /// Which of the free motions of a step were found from balance; `None` of a state that is no step.
    fn balanced(&self) -> Option<Vec<usize>> {
        match &self.source {
            Source::Own(_) => None,
            Source::Step(_, taken) => Some(taken.balanced().to_vec()),
        }
    }

    /// The factor on the friction up to which the sliding state exists and is unique for every load.
    fn wedging_factor(&self, py: Python<'_>) -> PyResult<f64> {
        self.with(py, |tangent, monitor| tangent.wedging_factor(monitor))
    }

    /// What pressures and friction of the state open the gaps by (n,) [m].
    fn opening<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let opening = self.with(py, |tangent, _| Ok(tangent.opening()))?;
        Ok(opening.into_pyarray(py))
    }

    /// Friction coefficient (1, n) of a step, direction of sliding (2, n), and the share (1, 1) of the given
    /// coefficient that acts at its speed; `None` of a state that is no step.
    fn sliding<'py>(&self, py: Python<'py>) -> PyResult<Option<[Rows<'py>; 3]>> {
        let Source::Step(contact, taken) = &self.source else {
            return Ok(None);
        };
        let share = vec![contact.get().prepared().share(taken.velocity())];
        let share = share.into_pyarray(py).reshape([1, 1])?;
        let state = taken.state();
        let friction = state
            .friction
            .clone()
            .into_pyarray(py)
            .reshape([1, self.points])?;
        let direction = state
            .direction
            .clone()
            .into_pyarray(py)
            .reshape([2, self.points])?;
        Ok(Some([friction, direction, share]))
    }

    /// Changes of pressure (k, n) [Pa], traction (k, 2n) [Pa], gap (k, n) [m] and motion (k, m) by those of gap (k, n),
    /// work (k, m) and friction times direction (k, 2n).
    fn forward<'py>(
        &self,
        py: Python<'py>,
        gap: PyReadonlyArray2<'py, f64>,
        work: PyReadonlyArray2<'py, f64>,
        drag: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<[Rows<'py>; 4]> {
        let (n, m, k) = (self.points, self.motions, gap.shape()[0]);
        let (gap, work, drag) = (
            rows("gap", &gap, k, n)?,
            rows("work", &work, k, m)?,
            rows("drag", &drag, k, 2 * n)?,
        );
        let changes: Vec<Given> = (gap.into_iter().zip(work).zip(drag))
            .map(|((gap, work), drag)| Given { gap, work, drag })
            .collect();
        let found = self.with(py, |tangent, monitor| tangent.forward(&changes, monitor))?;
        Ok([
            stacked(py, n, found.iter().map(|f| &f.pressure))?,
            stacked(py, 2 * n, found.iter().map(|f| &f.traction))?,
            stacked(py, n, found.iter().map(|f| &f.gap))?,
            stacked(py, m, found.iter().map(|f| &f.motion))?,
        ])
    }

    /// Gradients by gap (k, n) and work (k, m) of the sums with these weights of pressure (k, n), traction (k, 2n), gap
    /// (k, n) and motion (k, m).
    fn adjoint<'py>(
        &self,
        py: Python<'py>,
        pressure: PyReadonlyArray2<'py, f64>,
        traction: PyReadonlyArray2<'py, f64>,
        gap: PyReadonlyArray2<'py, f64>,
        motion: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<[Rows<'py>; 2]> {
        let (n, m, k) = (self.points, self.motions, gap.shape()[0]);
        let pressure = rows("pressure", &pressure, k, n)?;
        let traction = rows("traction", &traction, k, 2 * n)?;
        let (gap, motion) = (rows("gap", &gap, k, n)?, rows("motion", &motion, k, m)?);
        let weights: Vec<Found> = (pressure.into_iter().zip(traction).zip(gap).zip(motion))
            .map(|(((pressure, traction), gap), motion)| Found {
                pressure,
                traction,
                gap,
                motion,
            })
            .collect();
        let given = self.with(py, |tangent, monitor| {
            tangent.adjoint_of_loads(&weights, monitor)
        })?;
        Ok([
            stacked(py, n, given.iter().map(|g| &g.gap))?,
            stacked(py, m, given.iter().map(|g| &g.work))?,
        ])
    }

    /// Gradients by friction times direction (k, 2n) along the tangents `along`, and zeros across them, of the sums
    /// whose gradients by gap (k, n) and work (k, m) and whose weights of traction (k, 2n) these are.
    fn by_drag<'py>(
        &self,
        py: Python<'py>,
        gap: PyReadonlyArray2<'py, f64>,
        work: PyReadonlyArray2<'py, f64>,
        traction: PyReadonlyArray2<'py, f64>,
        along: [bool; 2],
    ) -> PyResult<Rows<'py>> {
        let (n, m, k) = (self.points, self.motions, gap.shape()[0]);
        let traction = rows("traction", &traction, k, 2 * n)?;
        let (gap, work) = (rows("gap", &gap, k, n)?, rows("work", &work, k, m)?);
        let mut given: Vec<Given> = (gap.into_iter().zip(work))
            .map(|(gap, work)| Given {
                gap,
                work,
                drag: vec![0.0; 2 * n],
            })
            .collect();
        let weights: Vec<&[f64]> = traction.iter().map(Vec::as_slice).collect();
        self.with(py, |tangent, _| {
            tangent.put_drag(&weights, &mut given, along)
        })?;
        stacked(py, 2 * n, given.iter().map(|g| &g.drag))
    }
}

fn changes<'py>(
    py: Python<'py>,
    points: usize,
    motions: usize,
    given: &[Given],
) -> PyResult<Changes<'py>> {
    Ok([
        stacked(py, points, given.iter().map(|g| &g.gap))?,
        stacked(py, motions, given.iter().map(|g| &g.work))?,
        stacked(py, 2 * points, given.iter().map(|g| &g.drag))?,
    ])
}

fn rows(
    name: &str,
    array: &PyReadonlyArray2<'_, f64>,
    cases: usize,
    length: usize,
) -> PyResult<Vec<Vec<f64>>> {
    if array.shape() != [cases, length] {
        return Err(PyValueError::new_err(format!(
            "{name} has shape {:?}, expected ({cases}, {length})",
            array.shape()
        )));
    }
    let flat = array.as_slice().map_err(|e| bad_input(&e))?;
    Ok((0..cases)
        .map(|i| flat[i * length..(i + 1) * length].to_vec())
        .collect())
}

/// Rows of a length as one array.
pub(crate) fn stacked<'py, 'a>(
    py: Python<'py>,
    length: usize,
    rows: impl ExactSizeIterator<Item = &'a Vec<f64>>,
) -> PyResult<Rows<'py>> {
    let count = rows.len();
    let mut flat = Vec::with_capacity(count * length);
    for row in rows {
        flat.extend_from_slice(row);
    }
    flat.into_pyarray(py).reshape([count, length])
}

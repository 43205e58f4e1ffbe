// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sliding states, linearised.

use std::sync::{Arc, Mutex, PoisonError};

use mtb_contact::prepared::Taken;
use mtb_contact::stepping::{ByLoads, Given, Linearised, Tangent, Weights};
use mtb_operator::Monitor;
use numpy::ndarray::Dimension;
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray, PyReadonlyArray2,
    PyReadonlyArray3, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::{Failure, bad_input, enter};
use crate::in_rows::InRows;
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

/// Changes of gap (k, n), work (k, m), friction times direction (k, 2n), and the pull of a magnet (k, n), without one
/// (k, 0).
type Changes<'py> = [Rows<'py>; 4];

#[pymethods]
impl PyTangent {
    /// What a unit of each input of a step changes (pose, velocity, magnetic pressure: 9): gap, work, friction times
    /// direction, and the pull of a magnet; `None` of a state that is no step.
    fn inputs<'py>(&self, py: Python<'py>) -> PyResult<Option<Changes<'py>>> {
        let Source::Step(contact, taken) = &self.source else {
            return Ok(None);
        };
        let given = contact.get().prepared().inputs(taken);
        let given = given.map_err(|e| bad_input(&e))?;
        let (n, m) = (self.points, self.motions);
        let nothing = vec![0.0; if taken.pulling().is_some() { n } else { 0 }];
        let pull = given
            .iter()
            .map(|g| if g.pull.is_empty() { &nothing } else { &g.pull });
        Ok(Some([
            stacked(py, n, given.iter().map(|g| &g.gap))?,
            stacked(py, m, given.iter().map(|g| &g.work))?,
            stacked(py, 2 * n, given.iter().map(|g| &g.drag))?,
            stacked(py, nothing.len(), pull)?,
        ]))
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

    /// Hardness (n,) [Pa]; `None` without one.
    fn limit<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        let limit = match &self.source {
            Source::Own(linearised) => {
                let held = linearised.lock().unwrap_or_else(PoisonError::into_inner);
                held.state().limit.clone()
            }
            Source::Step(_, taken) => taken.state().limit.clone(),
        };
        limit.map(|limit| limit.into_pyarray(py))
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

    /// Pressure (10, n) by each number of a magnet that follows the gap, with all gaps held; `None` without one.
    fn magnet<'py>(&self, py: Python<'py>) -> PyResult<Option<Rows<'py>>> {
        let fields = match &self.source {
            Source::Own(linearised) => {
                let held = linearised.lock().unwrap_or_else(PoisonError::into_inner);
                held.pulling().map(|p| p.slopes().of_parameters().to_vec())
            }
            Source::Step(_, taken) => taken.pulling().map(|p| p.slopes().of_parameters().to_vec()),
        };
        let rows = |fields: Vec<Vec<f64>>| stacked(py, self.points, fields.iter());
        fields.map(rows).transpose()
    }

    /// Changes of pressure (k, n) [Pa], traction (k, 2n) [Pa], gap (k, n) [m], motion (k, m) and the pull of a magnet
    /// (k, n), without one (k, 0), by those of gap (k, n), work (k, m), friction times direction (k, 2n), the pull
    /// with all gaps held (k, n), and the hardness (k, n).
    #[pyo3(signature = (gap, work, drag, pull=None, hardness=None))]
    fn forward<'py>(
        &self,
        py: Python<'py>,
        gap: PyReadonlyArray2<'py, f64>,
        work: PyReadonlyArray2<'py, f64>,
        drag: PyReadonlyArray2<'py, f64>,
        pull: Option<PyReadonlyArray2<'py, f64>>,
        hardness: Option<PyReadonlyArray2<'py, f64>>,
    ) -> PyResult<[Rows<'py>; 5]> {
        let (n, m, k) = (self.points, self.motions, gap.shape()[0]);
        let (gap, work, drag) = (
            rows("gap", &gap, k, n)?,
            rows("work", &work, k, m)?,
            rows("drag", &drag, k, 2 * n)?,
        );
        let optional = |name: &str, given: &Option<PyReadonlyArray2<'py, f64>>| match given {
            Some(given) => rows(name, given, k, n),
            None => Ok(vec![Vec::new(); k]),
        };
        let of_points = optional("pull", &pull)?
            .into_iter()
            .zip(optional("hardness", &hardness)?);
        let changes: Vec<Given> = (gap.into_iter().zip(work).zip(drag).zip(of_points))
            .map(|(((gap, work), drag), (pull, hardness))| Given {
                gap,
                work,
                drag,
                pull,
                hardness,
            })
            .collect();
        let found = self.with(py, |tangent, monitor| tangent.forward(&changes, monitor))?;
        Ok([
            stacked(py, n, found.iter().map(|f| &f.pressure))?,
            stacked(py, 2 * n, found.iter().map(|f| &f.traction))?,
            stacked(py, n, found.iter().map(|f| &f.gap))?,
            stacked(py, m, found.iter().map(|f| &f.motion))?,
            stacked(
                py,
                found.first().map_or(0, |f| f.pull.len()),
                found.iter().map(|f| &f.pull),
            )?,
        ])
    }

    /// Gradients by gap (k, n), work (k, m) and the pull of a magnet with all gaps held (k, n), without one (k, 0), of
    /// the sums with these weights of tractions and pressure (k, 3, n), gap (k, n), motion (k, m) and the pull (k, n);
    /// `None`: none.
    #[pyo3(signature = (unknowns, gap=None, motion=None, pull=None))]
    fn adjoint<'py>(
        &self,
        py: Python<'py>,
        unknowns: PyReadonlyArray3<'py, f64>,
        gap: Option<PyReadonlyArray2<'py, f64>>,
        motion: Option<PyReadonlyArray2<'py, f64>>,
        pull: Option<PyReadonlyArray2<'py, f64>>,
    ) -> PyResult<[Rows<'py>; 3]> {
        let (n, m, k) = (self.points, self.motions, unknowns.shape()[0]);
        let of = Weights {
            count: k,
            unknowns: whole("unknowns", &unknowns, [k, 3, n])?,
            gap: gap
                .as_ref()
                .map_or(Ok(&[][..]), |gap| whole("gap", gap, [k, n]))?,
            motion: (motion.as_ref()).map_or(Ok(&[][..]), |own| whole("motion", own, [k, m]))?,
            pull: (pull.as_ref()).map_or(Ok(&[][..]), |own| whole("pull", own, [k, n]))?,
        };
        let found = self.with(py, |tangent, monitor| tangent.by_loads(&of, monitor))?;
        Ok([
            found.gap.into_pyarray(py).reshape([k, n])?,
            found.work.into_pyarray(py).reshape([k, m])?,
            {
                let length = found.pull.len() / k.max(1);
                found.pull.into_pyarray(py).reshape([k, length])?
            },
        ])
    }

    /// Gradients (k, n) by friction times direction along the tangent `axis`, of the sums whose weights of tractions
    /// and pressure (k, 3, n) and whose gradients by gap (k, n) and work (k, m) these are.
    fn by_drag<'py>(
        &self,
        py: Python<'py>,
        axis: usize,
        unknowns: PyReadonlyArray3<'py, f64>,
        gap: PyReadonlyArray2<'py, f64>,
        work: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Rows<'py>> {
        if axis > 1 {
            return Err(PyValueError::new_err(format!(
                "axis is {axis}: 0 or 1 is needed"
            )));
        }
        self.after_loads(py, &unknowns, [&gap, &work], |tangent, of, found| {
            tangent.by_drag(of, found, axis)
        })
    }

    /// Gradients (k, n) by the hardness, of the same sums about a state that has one.
    fn by_hardness<'py>(
        &self,
        py: Python<'py>,
        unknowns: PyReadonlyArray3<'py, f64>,
        gap: PyReadonlyArray2<'py, f64>,
        work: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Rows<'py>> {
        self.after_loads(py, &unknowns, [&gap, &work], |tangent, of, found| {
            tangent.by_hardness(of, found)
        })
    }
}

impl PyTangent {
    /// Gradients that follow from those by loads.
    fn after_loads<'py>(
        &self,
        py: Python<'py>,
        unknowns: &PyReadonlyArray3<'py, f64>,
        [gap, work]: [&PyReadonlyArray2<'py, f64>; 2],
        by: impl FnOnce(
            &mut Tangent<'_>,
            &Weights<'_>,
            &ByLoads,
        ) -> Result<Vec<f64>, mtb_contact::Error>
        + Send,
    ) -> PyResult<Rows<'py>> {
        let (n, m, k) = (self.points, self.motions, unknowns.shape()[0]);
        let of = Weights {
            count: k,
            unknowns: whole("unknowns", unknowns, [k, 3, n])?,
            gap: &[],
            motion: &[],
            pull: &[],
        };
        let found = ByLoads {
            gap: whole("gap", gap, [k, n])?.to_vec(),
            work: whole("work", work, [k, m])?.to_vec(),
            pull: Vec::new(),
        };
        let by = self.with(py, |tangent, _| by(tangent, &of, &found))?;
        by.into_pyarray(py).reshape([k, n])
    }
}

/// The numbers of an array of a shape, row after row.
fn whole<'a, D: Dimension, const R: usize>(
    name: &str,
    array: &'a PyReadonlyArray<'_, f64, D>,
    shape: [usize; R],
) -> PyResult<&'a [f64]> {
    if array.shape() != shape {
        return Err(PyValueError::new_err(format!(
            "{name} has shape {:?}, expected {shape:?}",
            array.shape()
        )));
    }
    array.in_rows().map_err(|e| bad_input(&e))
}

pub(crate) fn rows(
    name: &str,
    array: &PyReadonlyArray2<'_, f64>,
    cases: usize,
    length: usize,
) -> PyResult<Vec<Vec<f64>>> {
    let flat = whole(name, array, [cases, length])?;
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

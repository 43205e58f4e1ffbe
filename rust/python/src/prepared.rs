// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sliding contacts in a simulation.

use std::sync::{Arc, Mutex, PoisonError};

use mtb_contact::prepared::{FreeMotion, Prepared, PreparedContact, Pull, Step, Table};
use mtb_contact::stepping::Influence;
use mtb_operator::{Compliance, Relative};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::contact::{flat, rigid_motions};
use crate::error::{apart, bad_input, enter};
use crate::operator::PyCompliance;
use crate::problem::{PyContactGeometry, PyOutcome};

/// A prepared sliding contact with the memory of its last step.
#[pyclass(frozen, name = "PreparedContact", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyPreparedContact {
    prepared: Arc<Prepared>,
    contact: Mutex<PreparedContact>,
}

impl PyPreparedContact {
    fn of(prepared: Arc<Prepared>) -> Self {
        let contact = Mutex::new(PreparedContact::new(prepared.clone()));
        Self { prepared, contact }
    }
}

fn matrix(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Vec<f64>>> {
    let columns = array.shape()[1].max(1);
    let flat = array.as_slice().map_err(|e| bad_input(&e))?;
    Ok(flat.chunks_exact(columns).map(<[f64]>::to_vec).collect())
}

#[pymethods]
impl PyPreparedContact {
    /// `motions`: (m, 3, n), relative displacement along x and y, opening; `components`: the pose's component that takes the place of each; `friction` (t, n) and
    /// `loads` (s, n + m) over their speeds; `magnetic` (2, n + m): without, and change by 1 Pa.
    #[new]
    #[allow(
        clippy::too_many_arguments,
        reason = "the arrays of one prepared contact"
    )]
    fn new(
        py: Python<'_>,
        lower: Option<Bound<'_, PyCompliance>>,
        upper: Option<Bound<'_, PyCompliance>>,
        geometry: &Bound<'_, PyContactGeometry>,
        motions: PyReadonlyArray3<'_, f64>,
        motion_names: Vec<String>,
        components: Vec<Option<usize>>,
        friction_speed: Vec<f64>,
        friction: PyReadonlyArray2<'_, f64>,
        load_speed: Vec<f64>,
        loads: PyReadonlyArray2<'_, f64>,
        magnetic: Option<PyReadonlyArray2<'_, f64>>,
        sliding_direction: [f64; 2],
        reference_point: [f64; 3],
        standstill_speed: Option<f64>,
    ) -> PyResult<Self> {
        let geometry = geometry.get().0.clone();
        let n = geometry.points();
        let [lower, upper] = [lower, upper].map(|c| c.map(|c| c.get().0.clone()));
        let pair = Relative::new(lower, upper).map_err(|e| bad_input(&e))?;
        if pair.points() != n {
            return Err(PyValueError::new_err(format!(
                "the bodies have {} contact points, the geometry {n}",
                pair.points()
            )));
        }
        let motions = rigid_motions(&motions, &[], n)?
            .into_iter()
            .zip(motion_names)
            .zip(components)
            .map(|((motion, name), component)| FreeMotion {
                name,
                motion,
                component,
            })
            .collect();
        let (friction, loads) = (matrix(&friction)?, matrix(&loads)?);
        let magnetic = match magnetic {
            None => None,
            Some(parts) => Some(matrix(&parts)?.try_into().map_err(|_| {
                PyValueError::new_err("magnetic has two rows: without, and the change by 1 Pa")
            })?),
        };
        let prepared = enter(py, |monitor| {
            let prepared = Prepared {
                influence: Arc::new(Influence::of(&pair, monitor)?),
                geometry: (*geometry).clone(),
                motions,
                friction: Table::new(friction_speed, friction)?,
                loads: Table::new(load_speed, loads)?,
                magnetic,
                sliding_direction,
                reference_point,
                standstill_speed,
            };
            prepared.check().map(|()| prepared)
        })?;
        Ok(Self::of(Arc::new(prepared)))
    }

    /// The contact that `to_bytes` wrote.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, data: &[u8]) -> PyResult<Self> {
        let prepared = enter(py, |_| Prepared::from_bytes(data))?;
        Ok(Self::of(Arc::new(prepared)))
    }

    /// The contact as bytes, checksum included; without the memory of steps.
    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let bytes = apart(py, || self.prepared.to_bytes());
        PyBytes::new(py, &bytes)
    }

    /// The same contact without memory; the matrices are shared.
    fn copy(&self) -> Self {
        Self::of(self.prepared.clone())
    }

    /// Contact points (3, n) [m].
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let points = self.prepared.geometry.points.clone();
        let n = points.len() / 3;
        points.into_pyarray(py).reshape([3, n])
    }

    /// Unit normals (3, n) of the lower body.
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let normal = self.prepared.geometry.normal.clone();
        let n = normal.len() / 3;
        normal.into_pyarray(py).reshape([3, n])
    }

    /// Area (n,) [m2] of each point.
    #[getter]
    fn area<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.prepared.geometry.area.clone().into_pyarray(py)
    }

    /// Names of the free motions.
    #[getter]
    fn motions(&self) -> Vec<String> {
        self.prepared
            .motions
            .iter()
            .map(|m| m.name.clone())
            .collect()
    }

    /// The point moments and rotations are about [m].
    #[getter]
    fn reference_point(&self) -> [f64; 3] {
        self.prepared.reference_point
    }

    /// The scene's own sliding direction; zeros where nothing slides.
    #[getter]
    fn sliding_direction(&self) -> [f64; 2] {
        self.prepared.sliding_direction
    }

    /// Whether friction or loads depend on the speed.
    #[getter]
    fn is_tabulated(&self) -> bool {
        self.prepared.friction.rows().len() > 1 || self.prepared.loads.rows().len() > 1
    }

    /// Mean pressure (n,) [Pa] of the unknowns of a step.
    fn mean_pressure<'py>(
        &self,
        py: Python<'py>,
        pressure: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let pressure = flat(&pressure, "pressure")?;
        if pressure.len() != self.prepared.geometry.points() {
            return Err(PyValueError::new_err(format!(
                "pressure has {} entries, there are {} points",
                pressure.len(),
                self.prepared.geometry.points()
            )));
        }
        let mean = self.prepared.geometry.mean_tractions(pressure);
        Ok(mean.into_pyarray(py))
    }

    /// Takes the pressures (n,) and motions of a step for the last ones.
    fn resume(
        &self,
        py: Python<'_>,
        pressure: PyReadonlyArray1<'_, f64>,
        motion: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<()> {
        let (pressure, motion) = (flat(&pressure, "pressure")?, flat(&motion, "motion")?);
        enter(py, |_| {
            let mut contact = self.contact.lock().unwrap_or_else(PoisonError::into_inner);
            contact.resume(pressure, motion)
        })
    }

    /// Solves one step; `magnetic_pressure` [Pa] or `given` (gap (n,), work (m,)) in place of the scene's loads.
    #[pyo3(signature = (pose, velocity, magnetic_pressure=None, given=None))]
    fn step<'py>(
        &self,
        py: Python<'py>,
        pose: [f64; 6],
        velocity: [f64; 2],
        magnetic_pressure: Option<f64>,
        given: Option<(PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>)>,
    ) -> PyResult<PyOutcome> {
        let pull = match (&given, magnetic_pressure) {
            (Some((gap, work)), _) => Pull::Given {
                gap: flat(gap, "gap")?,
                work: flat(work, "work")?,
            },
            (None, Some(pressure)) => Pull::Uniform(pressure),
            (None, None) => Pull::Scene,
        };
        let step = Step {
            pose,
            velocity,
            pull,
        };
        let outcome = enter(py, |monitor| {
            let mut contact = self.contact.lock().unwrap_or_else(PoisonError::into_inner);
            contact.step(&step, monitor)
        })?;
        PyOutcome::of(py, outcome)
    }
}

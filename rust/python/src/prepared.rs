// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sliding contacts in a simulation.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use mtb_contact::Error;
use mtb_contact::prepared::{
    Following, MagnetOverSpeed, Magnetic, Prepared, PreparedContact, Pull, Sliding, Source, Step,
    Table,
};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::contact::flat;
use crate::error::{bad_input, enter};
use crate::in_rows::InRows;
use crate::magnet::{PyMagneticCircuit, attracted, pull};
use crate::problem::{PyContactGeometry, PyLoading, PyOutcome, PyProblem};
use crate::stuck::PyStickSlip;
use crate::tangent::{PyTangent, Rows, rows, stacked};

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

    pub(crate) fn lock(&self) -> MutexGuard<'_, PreparedContact> {
        self.contact.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn prepared(&self) -> &Prepared {
        &self.prepared
    }
}

/// What presses in a step: loads given as a whole, a uniform pressure [Pa], or the scene's own.
pub(crate) fn pull_of<'a>(
    given: Option<&'a Bound<'_, PyLoading>>,
    magnetic_pressure: Option<f64>,
) -> Pull<'a> {
    match (given, magnetic_pressure) {
        (Some(given), _) => Pull::Given(&given.get().0),
        (None, Some(pressure)) => Pull::Uniform(pressure),
        (None, None) => Pull::Scene,
    }
}

fn matrix(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Vec<f64>>> {
    let columns = array.shape()[1].max(1);
    let flat = array.in_rows().map_err(|e| bad_input(&e))?;
    Ok(flat.chunks_exact(columns).map(<[f64]>::to_vec).collect())
}

/// Speeds, and pressures over them.
type PressureArgument<'py> = (Vec<f64>, PyReadonlyArray2<'py, f64>);

/// A circuit, and its factor over speeds.
type OverSpeedArgument<'py> = (Bound<'py, PyMagneticCircuit>, Vec<f64>, Vec<f64>);

/// The points of each pole, and the numbers of a magnet: curve of the iron, ampere-turns, gap that is not magnetic, share
/// of iron, length of the poles, yoke, rail, leakage, and its factor over speeds.
type MagnetParts = (
    Vec<usize>,
    [Vec<f64>; 2],
    [f64; 5],
    [Option<(f64, f64)>; 2],
    [Vec<f64>; 2],
);

#[pymethods]
impl PyPreparedContact {
    /// `loading`: what presses the bodies besides a magnetic pressure; `named`: name of each free motion, and the
    /// component of the pose that takes its place; `friction` (t, n) over its speeds; `layer` [m/Pa] along the tangents; `pulled`: of
    /// each body that a magnet pulls whether it is the upper one, and whether at its face; `pressure`: speeds, and that of
    /// the scene (s, n) over them; `magnet`: that of the scene.
    #[new]
    #[allow(
        clippy::too_many_arguments,
        reason = "what one prepared contact is made of"
    )]
    fn new(
        py: Python<'_>,
        problem: &Bound<'_, PyProblem>,
        loading: &Bound<'_, PyLoading>,
        named: Vec<(String, Option<usize>)>,
        friction_speed: Vec<f64>,
        friction: PyReadonlyArray2<'_, f64>,
        pulled: Vec<(bool, bool)>,
        pressure: Option<PressureArgument<'_>>,
        magnet: Option<OverSpeedArgument<'_>>,
        sliding_direction: [f64; 2],
        reference_point: [f64; 3],
        standstill_speed: Option<f64>,
        velocity: Option<f64>,
        layer: f64,
    ) -> PyResult<Self> {
        let friction = matrix(&friction)?;
        let (problem, loading) = (&problem.get().0, &loading.get().0);
        let pressure = match pressure {
            None => None,
            Some((speed, pressure)) => Some((speed, matrix(&pressure)?)),
        };
        let magnet =
            magnet.map(|(circuit, speed, factor)| (circuit.get().circuit().clone(), speed, factor));
        let pulled = attracted(pulled);
        let prepared = enter(py, |monitor| {
            let source = match (pressure, magnet) {
                (Some((speed, pressure)), _) => Source::Pressure(Table::new(speed, pressure)?),
                (None, Some((circuit, speed, factor))) => Source::Magnet(MagnetOverSpeed {
                    circuit,
                    factor: Table::new(speed, factor.into_iter().map(|f| vec![f]).collect())?,
                }),
                (None, None) => Source::Steps,
            };
            let magnetic = Magnetic {
                bodies: &pulled,
                source,
            };
            let sliding = Sliding {
                friction: Table::new(friction_speed, friction)?,
                direction: sliding_direction,
                standstill_speed,
                velocity,
                layer,
            };
            Prepared::new(
                problem,
                loading,
                Some(&magnetic),
                named,
                sliding,
                reference_point,
                monitor,
            )
        })?;
        Ok(Self::of(Arc::new(prepared)))
    }

    /// The contact that `to_bytes` wrote.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, data: &[u8]) -> PyResult<Self> {
        let prepared = enter(py, |_| Prepared::from_bytes(data))?;
        Ok(Self::of(Arc::new(prepared)))
    }

    /// Whether steps with a shift can be taken: both bodies are known.
    #[getter]
    fn takes_shifts(&self) -> bool {
        self.prepared.bodies.is_some()
    }

    /// The contact as bytes, checksum included; without the memory of steps. With `shift` for steps with a shift too.
    fn to_bytes<'py>(&self, py: Python<'py>, shift: bool) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = enter(py, |monitor| {
            if shift {
                self.prepared.to_bytes_for_shifts(monitor)
            } else {
                self.prepared.to_bytes(monitor)
            }
        })?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The same contact without memory; the matrices are shared.
    fn copy(&self) -> Self {
        Self::of(self.prepared.clone())
    }

    /// What the next step with a shift starts from, for `recall`; `None` before a step was solved, and of a contact
    /// that takes no shifts.
    fn memory<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let memory = enter(py, |_| Ok::<_, Error>(self.lock().memory()))?;
        Ok(memory.map(|memory| memory.into_pyarray(py)))
    }

    /// Takes a `memory` for what the last step left behind.
    fn recall(&self, py: Python<'_>, memory: PyReadonlyArray1<'_, f64>) -> PyResult<()> {
        let memory = flat(&memory, "memory")?;
        enter(py, |_| self.lock().recall(memory))
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

    /// What a unit of each free motion does to the contact points, (m, 3, n): displacement of the lower body less the
    /// upper one along both tangents, and opening.
    #[getter]
    fn motion_shapes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let (m, n) = (self.prepared.motions.len(), self.prepared.geometry.points());
        let shapes = self.prepared.motions.iter().flat_map(|m| {
            let motion = &m.motion;
            let parts = [&motion.tangential_x, &motion.tangential_y, &motion.opening];
            parts.into_iter().flatten().copied()
        });
        PyArray1::from_iter(py, shapes).reshape([m, 3, n])
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

    /// The scene's own velocity along its sliding direction [m/s], where it states one.
    #[getter]
    fn velocity(&self) -> Option<f64> {
        self.prepared.velocity
    }

    /// Whether friction, loads or a magnet depend on the speed.
    #[getter]
    fn is_tabulated(&self) -> bool {
        let prepared = &*self.prepared;
        let factor = prepared.magnet.as_ref().map(|magnet| &magnet.factor);
        let mut tables = [&prepared.friction, &prepared.loads]
            .into_iter()
            .chain(factor);
        tables.any(|table| table.rows().len() > 1)
    }

    /// The magnet of the scene whose pull follows the gap; `None` without one.
    #[getter]
    fn magnet(&self) -> Option<MagnetParts> {
        let MagnetOverSpeed { circuit, factor } = self.prepared.magnet.as_ref()?;
        let poles = circuit.poles();
        Some((
            poles.points.clone(),
            circuit.iron().points().map(<[f64]>::to_vec),
            [
                circuit.ampere_turns(),
                poles.non_magnetic_gap,
                poles.iron_share,
                poles.length,
                circuit.leakage(),
            ],
            (circuit.limbs()).map(|limb| limb.map(|limb| (limb.length, limb.area))),
            [factor.speed().to_vec(), factor.rows().concat()],
        ))
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

    /// Displacement (k, 2n) [m] of the lower body less the upper one along both tangents by tractions and pressures
    /// (k, 3n) [Pa], and by the pull (k, n) [Pa] of a magnet that follows the gap.
    #[pyo3(signature = (traction, pull=None))]
    fn slid_by<'py>(
        &self,
        py: Python<'py>,
        traction: PyReadonlyArray2<'py, f64>,
        pull: Option<PyReadonlyArray2<'py, f64>>,
    ) -> PyResult<Rows<'py>> {
        let n = self.prepared.geometry.points();
        let given = rows("traction", &traction, traction.shape()[0], 3 * n)?;
        let pulls = match &pull {
            None => None,
            Some(pull) => Some(rows("pull", pull, given.len(), n)?),
        };
        let moved = enter(py, |monitor| {
            let by = |(k, own): (usize, &Vec<f64>)| {
                let pull = pulls.as_ref().map(|pulls| &*pulls[k]);
                self.prepared.slid_by(own, pull, monitor)
            };
            given
                .iter()
                .enumerate()
                .map(by)
                .collect::<Result<Vec<_>, Error>>()
        })?;
        stacked(py, 2 * n, moved.iter())
    }

    /// Takes the pressures (n,), motions and pull (n,) of a step for the last ones, with tractions (2, n) and rigid
    /// displacements (2, n) for steps with a shift.
    #[pyo3(signature = (pressure, motion, from_pull=None, stuck=None))]
    fn resume(
        &self,
        py: Python<'_>,
        pressure: PyReadonlyArray1<'_, f64>,
        motion: PyReadonlyArray1<'_, f64>,
        from_pull: Option<PyReadonlyArray1<'_, f64>>,
        stuck: Option<(PyReadonlyArray2<'_, f64>, PyReadonlyArray2<'_, f64>)>,
    ) -> PyResult<()> {
        let (pressure, motion) = (flat(&pressure, "pressure")?, flat(&motion, "motion")?);
        let from = pull(from_pull.as_ref())?;
        let stuck = match &stuck {
            None => None,
            Some((traction, rigid)) => {
                let traction = traction.in_rows().map_err(|e| bad_input(&e))?;
                let rigid = rigid.in_rows().map_err(|e| bad_input(&e))?;
                Some(([traction, pressure].concat(), rigid))
            }
        };
        enter(py, |_| {
            let mut contact = self.lock();
            contact.resume(pressure, motion, from.as_deref())?;
            match &stuck {
                None => Ok(()),
                Some((traction, rigid)) => contact.remember(traction, motion, rigid),
            }
        })
    }

    /// The contact points.
    #[getter]
    fn geometry(&self) -> PyContactGeometry {
        PyContactGeometry(Arc::new(self.prepared.geometry.clone()))
    }

    /// Solves one step; `magnetic_pressure` [Pa] or `given` in place of the scene's loads. With the step its
    /// equations linearised about it, if it is solved. A `magnet` in place of that of the scene has a factor, which changes
    /// by so much with the speed [s/m].
    #[pyo3(signature = (pose, velocity, magnetic_pressure=None, given=None, gap=None, friction=None, diagonal=None, magnet=None, shift=None))]
    #[allow(clippy::too_many_arguments, reason = "what one step is given")]
    fn step<'py>(
        slf: &Bound<'py, Self>,
        py: Python<'py>,
        pose: [f64; 6],
        velocity: [f64; 2],
        magnetic_pressure: Option<f64>,
        given: Option<&Bound<'py, PyLoading>>,
        gap: Option<PyReadonlyArray1<'py, f64>>,
        friction: Option<PyReadonlyArray1<'py, f64>>,
        diagonal: Option<PyReadonlyArray1<'py, f64>>,
        magnet: Option<(Bound<'py, PyMagneticCircuit>, f64, f64)>,
        shift: Option<[f64; 2]>,
    ) -> PyResult<(PyOutcome, Option<PyTangent>, Option<PyStickSlip>)> {
        let pull = match &magnet {
            None => pull_of(given, magnetic_pressure),
            Some((circuit, factor, by_speed)) => Pull::Following(Following {
                circuit: circuit.get().circuit(),
                factor: *factor,
                by_speed: *by_speed,
            }),
        };
        let gap = gap.as_ref().map(|gap| flat(gap, "gap")).transpose()?;
        let friction = friction
            .as_ref()
            .map(|mu| flat(mu, "friction"))
            .transpose()?;
        let diagonal = diagonal.as_ref().map(|d| flat(d, "diagonal")).transpose()?;
        let step = Step {
            pose,
            velocity,
            pull,
            gap,
            friction,
            diagonal,
            shift,
        };
        let contact = slf.get();
        let (outcome, taken, stuck) = enter(py, |monitor| {
            let mut contact = contact.lock();
            let outcome = contact.step(&step, monitor)?;
            let found = (contact.taken().cloned(), contact.stuck().cloned());
            Ok::<_, Error>((outcome, found.0, found.1))
        })?;
        let tangent = taken.map(|taken| PyTangent::of_step(slf.clone().unbind(), taken));
        Ok((PyOutcome::of(py, outcome)?, tangent, stuck.map(PyStickSlip)))
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Magnets whose pull follows the gap.

use std::sync::Arc;

use mtb_contact::magnet::{Circuit, Iron, Limb, Magnet, Poles, Settled};
use mtb_contact::problem::Attracted;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::contact::flat;
use crate::error::bad_input;
use crate::problem::body;

/// Coil, poles and iron of a magnet on contact points.
#[pyclass(frozen, name = "MagneticCircuit", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyMagneticCircuit(Arc<Circuit>);

/// A circuit, of each body that it pulls whether it is the upper one and whether at its face, and the factor of the
/// speed.
pub(crate) type MagnetArgument<'py> = (Bound<'py, PyMagneticCircuit>, Vec<(bool, bool)>, f64);

/// Bodies that are pulled: of each whether it is the upper one, and whether at its face.
pub(crate) fn attracted(bodies: Vec<(bool, bool)>) -> Vec<Attracted> {
    let attracted = |(is_upper, at_face)| Attracted {
        body: body(is_upper),
        at_face,
    };
    bodies.into_iter().map(attracted).collect()
}

impl PyMagneticCircuit {
    pub(crate) fn circuit(&self) -> &Circuit {
        &self.0
    }
}

/// A magnet as it was given.
pub(crate) struct Given {
    circuit: Arc<Circuit>,
    bodies: Vec<Attracted>,
    factor: f64,
}

impl Given {
    pub(crate) fn of((circuit, bodies, factor): MagnetArgument<'_>) -> Self {
        Self {
            circuit: circuit.get().0.clone(),
            bodies: attracted(bodies),
            factor,
        }
    }

    pub(crate) fn magnet(&self) -> Magnet<'_> {
        Magnet {
            circuit: &self.circuit,
            bodies: &self.bodies,
            factor: self.factor,
        }
    }
}

/// A pull to start from.
pub(crate) fn pull(argument: Option<&PyReadonlyArray1<'_, f64>>) -> PyResult<Option<Vec<f64>>> {
    let given = argument.map(|pull| flat(pull, "pull")).transpose()?;
    Ok(given.map(<[f64]>::to_vec))
}

/// Pressure (n,) [Pa], its slope (n,) [Pa/m], flux density (n,) [T], flux [Wb], force of each pole [A].
type AttractionOf<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    f64,
    Vec<f64>,
);

#[pymethods]
impl PyMagneticCircuit {
    /// `field` [A/m] and `flux_density` [T] of the iron; `area` (n,) [m2] of the points, those of each pole (`points`)
    /// one after the other; `yoke`, `rail`: length [m] and section [m2].
    #[new]
    #[allow(clippy::too_many_arguments, reason = "all that a magnet is")]
    fn new(
        field: PyReadonlyArray1<'_, f64>,
        flux_density: PyReadonlyArray1<'_, f64>,
        ampere_turns: f64,
        area: PyReadonlyArray1<'_, f64>,
        points: Vec<usize>,
        iron_share: f64,
        pole_length: f64,
        non_magnetic_gap: f64,
        yoke: Option<(f64, f64)>,
        rail: Option<(f64, f64)>,
        leakage: f64,
    ) -> PyResult<Self> {
        let iron = Iron::new(flat(&field, "field")?, flat(&flux_density, "flux_density")?)
            .map_err(|e| bad_input(&e))?;
        let poles = Poles {
            area: flat(&area, "area")?.to_vec(),
            points,
            iron_share,
            length: pole_length,
            non_magnetic_gap,
        };
        let limbs = [yoke, rail].map(|limb| limb.map(|(length, area)| Limb { length, area }));
        let circuit = Circuit::new(iron, ampere_turns, poles, limbs, leakage);
        Ok(Self(Arc::new(circuit.map_err(|e| bad_input(&e))?)))
    }

    /// The largest pressure [Pa] that saturated iron gives.
    #[getter]
    fn limit(&self) -> f64 {
        self.0.limit()
    }

    /// How it pulls over gaps (n,) [m], times a factor of the speed.
    fn attract<'py>(
        &self,
        py: Python<'py>,
        gap: PyReadonlyArray1<'py, f64>,
        factor: f64,
    ) -> PyResult<AttractionOf<'py>> {
        let found = self.0.attract(flat(&gap, "gap")?, factor);
        let found = found.map_err(|e| bad_input(&e))?;
        Ok((
            found.pressure.into_pyarray(py),
            found.slope.into_pyarray(py),
            found.flux_density.into_pyarray(py),
            found.flux,
            found.forces,
        ))
    }
}

/// The pull of a state, and how it was found.
#[pyclass(frozen, get_all, name = "Settled", module = "mtb_rs._mtb_rs")]
pub(crate) struct PySettled {
    pull: Py<PyArray1<f64>>,
    flux: f64,
    forces: Vec<f64>,
    solves: usize,
    residual: f64,
    share: Option<f64>,
}

impl PySettled {
    pub(crate) fn of(py: Python<'_>, settled: Settled) -> PyResult<Py<Self>> {
        let told = Self {
            pull: settled.pull.into_pyarray(py).unbind(),
            flux: settled.flux,
            forces: settled.forces,
            solves: settled.solves,
            residual: settled.residual,
            share: settled.share,
        };
        Py::new(py, told)
    }
}

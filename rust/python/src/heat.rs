// SPDX-License-Identifier: MIT OR Apache-2.0
//! Temperatures of bodies that rub on each other.

use mtb_heat::{Conductor, Error, Passage, rolling};
use numpy::{IntoPyArray, PyArray3, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::error::{bad_input, enter};

/// Conductivity [W/(m K)], density [kg/m3], specific heat [J/(kg K)].
type Constants = (f64, f64, f64);

fn conductor((conductivity, density, specific_heat): Constants) -> PyResult<Conductor> {
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

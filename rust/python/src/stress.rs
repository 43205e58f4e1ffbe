// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stress inside half-spaces.

use mtb_elasticity::Error;
use mtb_elasticity::half_space::{LoadedCell, StressBelow};
use mtb_operator::Grid;
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray4, PyArrayMethods, PyReadonlyArray2, PyReadonlyArray3,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::elasticity::MediumArgument;
use crate::error::enter;
use crate::operator::rows3;

/// Stress (depths, 6, ny, nx) [Pa] at `depths` [m] below the cells of a grid, in the body's own frame, components xx,
/// yy, zz, yz, xz, xy, and the number of convolutions it took.
///
/// `medium`: shear modulus [Pa] and Poisson's ratio, or a layer on a base; `traction` (3, ny, nx) [Pa]: on the body along x and along y, and
/// the pressure; a `periodic` one has the pressure only.
#[pyfunction]
pub(crate) fn stress_below<'py>(
    py: Python<'py>,
    medium: MediumArgument,
    spacing: (f64, f64),
    traction: PyReadonlyArray3<'_, f64>,
    depths: Vec<f64>,
    periodic: bool,
) -> PyResult<(Bound<'py, PyArray4<f64>>, usize)> {
    let &[components, ny, nx] = traction.shape() else {
        unreachable!("three dimensions")
    };
    if components != 3 {
        return Err(PyValueError::new_err(format!(
            "traction has {components} components, expected 3"
        )));
    }
    let traction = traction.to_vec()?;
    let n = nx * ny;
    let (stress, convolutions) = enter(py, |monitor| -> Result<_, Error> {
        let medium = medium.medium()?;
        let grid = Grid::new(nx, ny, spacing.0, spacing.1).map_err(Error::Operator)?;
        let [x, y, pressure] = [0, 1, 2].map(|k| &traction[k * n..(k + 1) * n]);
        let below = if periodic {
            StressBelow::periodic(medium, grid, pressure)?
        } else {
            StressBelow::new(medium, grid, [x, y, pressure])?
        };
        let stress = below.at(&depths, monitor)?;
        Ok((stress, depths.len() * below.convolutions()))
    })?;
    let shape = [stress.len() / (6 * n), 6, ny, nx];
    Ok((stress.into_pyarray(py).reshape(shape)?, convolutions))
}

/// Dang Van's equivalent shear stress (n) [Pa] of paths (n, states, 6) of the stress [Pa].
#[pyfunction]
pub(crate) fn dang_van<'py>(
    py: Python<'py>,
    paths: PyReadonlyArray3<'_, f64>,
    coefficient: f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let &[_, states, components] = paths.shape() else {
        unreachable!("three dimensions")
    };
    if components != 6 || states == 0 {
        return Err(PyValueError::new_err("paths must be (n, states, 6)"));
    }
    let paths = paths.to_vec()?;
    let found = enter(py, |monitor| {
        mtb_elasticity::dang_van(&paths, states, coefficient, monitor)
    })?;
    Ok(found.into_pyarray(py))
}

/// Stress (n, 6) [Pa] at points (n, 3) [m], x, y and the depth, in the body's own frame, components xx, yy, zz, yz, xz,
/// xy, under tractions (3, m) [Pa] on cells (m, 4) [m]: centre x, y and sides.
#[pyfunction]
pub(crate) fn stress_at<'py>(
    py: Python<'py>,
    medium: MediumArgument,
    cells: PyReadonlyArray2<'_, f64>,
    traction: PyReadonlyArray2<'_, f64>,
    points: PyReadonlyArray2<'_, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let m = cells.shape()[0];
    if cells.shape()[1] != 4 || points.shape()[1] != 3 {
        return Err(PyValueError::new_err(
            "cells must be (m, 4), and points (n, 3)",
        ));
    }
    let [x, y, pressure] = rows3(&traction, m, "traction")?;
    let (cells, points) = (cells.to_vec()?, points.to_vec()?);
    let cells: Vec<LoadedCell> = cells
        .as_chunks::<4>()
        .0
        .iter()
        .enumerate()
        .map(|(k, cell)| LoadedCell {
            centre: [cell[0], cell[1]],
            sides: [cell[2], cell[3]],
            traction: [x[k], y[k], pressure[k]],
        })
        .collect();
    let points = points.as_chunks::<3>().0;
    let stress = enter(py, |monitor| -> Result<_, Error> {
        mtb_elasticity::half_space::stress_at(medium.medium()?, &cells, points, monitor)
    })?;
    let n = stress.len();
    stress.concat().into_pyarray(py).reshape([n, 6])
}

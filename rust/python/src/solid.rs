// SPDX-License-Identifier: MIT OR Apache-2.0
//! Solids filled with tetrahedra.

use mtb_geometry::solid::{self, Filling, Hexahedra, RailSection, SolidMesh};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray4, PyUntypedArrayMethods,
};
use pyo3::prelude::*;

use crate::error::{Failure, bad_input, enter};
use crate::geometry::{PyProfile, Shoe, slice};
use crate::in_rows::InRows;
use crate::tetra::triples;

type Line<'py> = PyReadonlyArray1<'py, f64>;

/// Nodes (n, 3) [m], cells (m, 4 or 10) and sets of nodes by name.
type Made<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<i64>>,
    Vec<(String, Bound<'py, PyArray1<i64>>)>,
);

fn numbers(values: &[usize]) -> Vec<i64> {
    values.iter().map(|v| *v as i64).collect()
}

fn made(py: Python<'_>, mesh: SolidMesh) -> PyResult<Made<'_>> {
    let count = mesh.nodes.len();
    let nodes: Vec<f64> = mesh.nodes.into_iter().flatten().collect();
    let shape = [mesh.cells.len() / mesh.nodes_per_cell, mesh.nodes_per_cell];
    let sets = mesh.sets.into_iter();
    Ok((
        nodes.into_pyarray(py).reshape([count, 3])?,
        numbers(&mesh.cells).into_pyarray(py).reshape(shape)?,
        sets.map(|(name, set)| (name, numbers(&set).into_pyarray(py)))
            .collect(),
    ))
}

/// Block standing on the plane z = 0; `filling` is (halved, clamped, thinner, quadratic).
#[pyfunction]
pub(crate) fn block_mesh<'py>(
    py: Python<'py>,
    x: Line<'py>,
    y: Line<'py>,
    height: f64,
    filling: (bool, bool, f64, bool),
) -> PyResult<Made<'py>> {
    let (x, y) = (slice(&x)?, slice(&y)?);
    let mesh = enter(py, |_| solid::block(x, y, height, filled(filling)))?;
    made(py, mesh)
}

fn filled((halved, clamped, thinner, quadratic): (bool, bool, f64, bool)) -> Filling {
    Filling {
        halved,
        clamped,
        thinner,
        quadratic,
    }
}

/// One pole of a shoe; `side` is 1 for the left one and -1 for the right one.
#[pyfunction]
#[allow(
    clippy::too_many_arguments,
    reason = "the parts of a pole and its grid"
)]
pub(crate) fn pole_mesh<'py>(
    py: Python<'py>,
    rail: &PyProfile,
    shoe: Shoe,
    side: f64,
    height: f64,
    x: Line<'py>,
    y: Line<'py>,
    filling: (bool, bool, f64, bool),
) -> PyResult<Made<'py>> {
    let (x, y) = (slice(&x)?, slice(&y)?);
    let shoe = shoe.on(rail);
    let mesh = enter(py, |_| shoe.solid(side, height, x, y, filled(filling)))?;
    made(py, mesh)
}

/// The numbers of the section of a rail, attributes of the section in Python.
#[derive(FromPyObject)]
pub(crate) struct Section {
    web_half_width: f64,
    web_top: f64,
    web_bottom: f64,
    head_edge: [f64; 2],
    foot_half_width: f64,
    foot_toe: f64,
    bottom: f64,
}

/// Rail of finite length; without `right` its half y >= 0.
#[pyfunction]
#[allow(
    clippy::too_many_arguments,
    reason = "the parts of a rail and its grid"
)]
pub(crate) fn rail_mesh<'py>(
    py: Python<'py>,
    profile: &PyProfile,
    section: Section,
    x: Line<'py>,
    left: Line<'py>,
    right: Option<Line<'py>>,
    length: f64,
    quadratic: bool,
) -> PyResult<Made<'py>> {
    let (x, left) = (slice(&x)?, slice(&left)?);
    let right = right.as_ref().map(slice).transpose()?;
    let section = RailSection {
        web_half_width: section.web_half_width,
        web_top: section.web_top,
        web_bottom: section.web_bottom,
        head_edge: section.head_edge,
        foot_half_width: section.foot_half_width,
        foot_toe: section.foot_toe,
        bottom: section.bottom,
    };
    let mesh = enter(py, |_| {
        section.solid(&profile.0, x, left, right, length, quadratic)
    })?;
    made(py, mesh)
}

/// Lines along x [m] for the mesh of a rail below contact grids, from the lines of each of them.
#[pyfunction]
pub(crate) fn rail_lines<'py>(
    py: Python<'py>,
    along: Vec<Line<'py>>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let along = along.iter().map(|line| Ok(slice(line)?.to_vec()));
    let along = along.collect::<PyResult<Vec<_>>>()?;
    Ok(solid::rail_lines(&along).into_pyarray(py))
}

/// Points on top and at the back at which a block or a pole is held.
#[pyfunction]
pub(crate) fn held_points(size: [f64; 2], height: f64) -> ([[f64; 3]; 5], [[f64; 3]; 4]) {
    solid::held_points(size, height)
}

/// Numbers of the `nodes` (n, 3) [m] that are nearest to places.
#[pyfunction]
pub(crate) fn nearest_nodes(
    nodes: PyReadonlyArray2<'_, f64>,
    places: Vec<[f64; 3]>,
) -> PyResult<Vec<usize>> {
    let nodes = triples(&nodes, "nodes")?;
    solid::nearest_nodes(&nodes, &places).map_err(|error| bad_input(&error))
}

/// Linear tetrahedra with nodes in the middle of their edges.
#[pyfunction]
pub(crate) fn quadratic_mesh<'py>(
    py: Python<'py>,
    nodes: PyReadonlyArray2<'py, f64>,
    cells: PyReadonlyArray2<'py, usize>,
    sets: Vec<(String, PyReadonlyArray1<'py, usize>)>,
) -> PyResult<Made<'py>> {
    let flat = |array: &PyReadonlyArray1<'_, usize>| -> PyResult<Vec<usize>> {
        Ok(array.in_rows().map_err(|error| bad_input(&error))?.to_vec())
    };
    let (triples, _) = nodes
        .in_rows()
        .map_err(|error| bad_input(&error))?
        .as_chunks();
    let linear = SolidMesh {
        nodes: triples.to_vec(),
        nodes_per_cell: cells.shape()[1],
        cells: cells.in_rows().map_err(|error| bad_input(&error))?.to_vec(),
        sets: sets
            .iter()
            .map(|(name, set)| Ok((name.clone(), flat(set)?)))
            .collect::<PyResult<_>>()?,
    };
    let mesh = enter(py, |_| linear.quadratic())?;
    made(py, mesh)
}

/// A grid (nx, ny, nz, 3) [m] of hexahedra, each cut into six tetrahedra: the mesh, and the node number at
/// each place of the doubled grid, -1 where there is none.
#[pyfunction]
pub(crate) fn tetrahedra<'py>(
    py: Python<'py>,
    corners: PyReadonlyArray4<'py, f64>,
    columns: Vec<bool>,
    rows: Vec<bool>,
    quadratic: bool,
) -> PyResult<(Made<'py>, Bound<'py, PyArray3<i64>>)> {
    let shape = corners.shape();
    let (triples, _) = corners
        .in_rows()
        .map_err(|error| bad_input(&error))?
        .as_chunks();
    let grid = Hexahedra {
        shape: [shape[0], shape[1], shape[2]],
        corners: triples.to_vec(),
        keep: None,
        flipped: [columns, rows],
        quadratic,
        curved: None,
    };
    let (mesh, places) = enter(py, |_| grid.tetrahedra())?;
    let number: Vec<i64> = places
        .number
        .iter()
        .map(|n| n.map_or(-1, |n| n as i64))
        .collect();
    Ok((
        made(py, mesh)?,
        number.into_pyarray(py).reshape(places.shape)?,
    ))
}

/// Refuses a mesh of about so many tetrahedra before it is made.
#[pyfunction]
pub(crate) fn check_unknowns(tetrahedra: f64, quadratic: bool) -> PyResult<()> {
    solid::check_unknowns(tetrahedra, quadratic).map_err(|error| Failure::from(error).into())
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Prisms.

use std::sync::Arc;

use mtb_contact::Across;
use mtb_elasticity::prism::{Foot, Prism, PrismCompliance, PrismPair, PrismRows, Section, Strip};
use mtb_elasticity::{Error, Material};
use mtb_geometry::solid::{Outline, RailSection, SectionMesh, rectangle_section};
use mtb_operator::{Grid, Monitor};
use numpy::{
    IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;

use crate::elasticity::{Spacing, grids};
use crate::error::{bad_input, enter};
use crate::geometry::{PyProfile, slice};
use crate::in_rows::InRows;
use crate::operator::PyCompliance;

/// Cross-section of a prism, in triangles.
#[pyclass(frozen, name = "Section", module = "mtb_rs._mtb_rs")]
pub(crate) struct PySection(SectionMesh);

type Line<'py> = PyReadonlyArray1<'py, f64>;
type Triangles<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<i64>>);

#[pymethods]
impl PySection {
    /// Nodes (n, 2) [m] and triangles (m, 6).
    fn arrays<'py>(&self, py: Python<'py>) -> PyResult<Triangles<'py>> {
        let (nodes, triangles) = (&self.0.nodes, &self.0.triangles);
        let places: Vec<f64> = nodes.iter().flatten().copied().collect();
        let numbers: Vec<i64> = triangles.iter().flatten().map(|n| *n as i64).collect();
        Ok((
            places.into_pyarray(py).reshape([nodes.len(), 2])?,
            numbers.into_pyarray(py).reshape([triangles.len(), 6])?,
        ))
    }

    /// Ends of the edges of its surface (n + 1, 2) [m], one after the other.
    fn surface<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let edges = &self.0.surface;
        let ends = (edges.iter().map(|e| e[0])).chain(edges.last().map(|e| e[1]));
        let places: Vec<f64> = ends.flat_map(|n| self.0.nodes[n]).collect();
        let count = places.len() / 2;
        places.into_pyarray(py).reshape([count, 2])
    }
}

/// Section of a rail below a profile, or of a rectangle (width, height) [m], with nodes on the `lines` (y) [m] of each
/// strip and `parts` elements between two of them.
#[pyfunction]
pub(crate) fn rail_section(
    py: Python<'_>,
    profile: &PyProfile,
    lines: Vec<Line<'_>>,
    parts: usize,
) -> PyResult<PySection> {
    let lines = lines.iter().map(slice).collect::<PyResult<Vec<_>>>()?;
    let mesh = enter(py, |_| {
        RailSection::default().section(&profile.0, &lines, parts)
    })?;
    Ok(PySection(mesh))
}

/// The same of a rectangle, `size` = (width, height) [m], its top at z = 0.
#[pyfunction]
pub(crate) fn block_section(
    py: Python<'_>,
    size: (f64, f64),
    lines: Vec<Line<'_>>,
    parts: usize,
) -> PyResult<PySection> {
    let lines = lines.iter().map(slice).collect::<PyResult<Vec<_>>>()?;
    let mesh = enter(py, |_| rectangle_section(size.0, size.1, &lines, parts))?;
    Ok(PySection(mesh))
}

/// Outline of a rail below a profile: points (n, 2) [m] of what is free, from one end of its base to the other.
#[pyfunction]
pub(crate) fn rail_outline<'py>(
    py: Python<'py>,
    profile: &PyProfile,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let outline = RailSection::default().outline(&profile.0);
    let outline = outline.map_err(|e| bad_input(&e))?;
    let places: Vec<f64> = outline.free.iter().flatten().copied().collect();
    places.into_pyarray(py).reshape([outline.free.len(), 2])
}

fn points(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<[f64; 2]>> {
    let pairs = array.in_rows()?.chunks_exact(2);
    Ok(pairs.map(|pair| [pair[0], pair[1]]).collect())
}

/// Section within an outline of points (n, 2) [m], what is free and the base, with nodes under rows of
/// cells, their middle `ahead` [m] of the point `origin` of it; `rows`: their number, width [m], and elements under each.
#[pyfunction]
pub(crate) fn outline_section(
    py: Python<'_>,
    free: PyReadonlyArray2<'_, f64>,
    base: PyReadonlyArray2<'_, f64>,
    origin: [f64; 2],
    ahead: f64,
    rows: (usize, f64, usize),
) -> PyResult<PySection> {
    let outline = Outline {
        free: points(&free)?,
        base: points(&base)?,
    };
    let mesh = enter(py, |_| {
        outline.section(origin, ahead, rows.0, rows.1, rows.2)
    })?;
    Ok(PySection(mesh))
}

/// A prism under equal cells in rows along it, beside a half-space of its material.
#[pyclass(frozen, name = "PrismRows", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyPrismRows {
    rows: Arc<PrismRows>,
    #[pyo3(get)]
    /// Number of waves, the largest wave number [1/m], the share of the last ones and the unknowns.
    waves: (usize, f64, f64, usize),
}

#[pymethods]
impl PyPrismRows {
    /// `elastic`: shear modulus [Pa] and Poisson's ratio; an upper prism is seen in the mirror z = 0, its rows as those
    /// of the cells; `shape`: (nx, ny); `spacing`: (dx, dy) [m].
    #[new]
    fn new(
        py: Python<'_>,
        elastic: (f64, f64),
        section: &PySection,
        foundation: Option<(f64, f64)>,
        shape: (usize, usize),
        spacing: (f64, f64),
    ) -> PyResult<Self> {
        let grid = Grid::new(shape.0, shape.1, spacing.0, spacing.1).map_err(|e| bad_input(&e))?;
        let mesh = section.0.clone();
        let (rows, unknowns) = enter(py, |monitor| {
            rows_of(elastic, &mesh, foundation, grid, monitor)
        })?;
        let (count, largest, tail) = rows.waves();
        Ok(Self {
            rows: Arc::new(rows),
            waves: (count, largest, tail, unknowns),
        })
    }
}

/// Bodies under the same cells in rows, one or both of which are prisms.
#[pyclass(frozen, name = "PrismPair", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyPrismPair {
    pub(crate) pair: PrismPair,
}

#[pymethods]
impl PyPrismPair {
    #[new]
    fn new(lower: Option<&PyPrismRows>, upper: Option<&PyPrismRows>) -> Self {
        let [lower, upper] = [lower, upper].map(|body| body.map(|body| body.rows.clone()));
        let pair = PrismPair { lower, upper };
        Self { pair }
    }

    /// Displacements [m/Pa] at `offsets` [m] along x, `[offset, 3 observed + loaded, observed row, loaded row]`, flat.
    fn influence<'py>(
        &self,
        py: Python<'py>,
        offsets: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Bound<'py, numpy::PyArray1<f64>>> {
        let offsets = offsets.in_rows()?;
        let values = enter(py, |_| {
            Ok::<_, Error>(self.pair.influence(offsets, 0..self.pair.rows()))
        })?;
        Ok(values.into_pyarray(py))
    }

    /// What a pressure and tractions do to the gap on the cells of a grid; see [`PyPrismRows::new`].
    fn normal(
        &self,
        py: Python<'_>,
        shape: (usize, usize),
        spacing: (f64, f64),
    ) -> PyResult<PyNormalPrisms> {
        let grid = Grid::new(shape.0, shape.1, spacing.0, spacing.1).map_err(|e| bad_input(&e))?;
        let rows = 0..self.pair.rows();
        let across = enter(py, |_| {
            let influence = |offsets: &[f64]| self.pair.influence(offsets, rows.clone());
            Ok::<_, Error>(Across::new(grid, &influence, &[(1.0, 0.0)], &[2]))
        })?;
        Ok(PyNormalPrisms { across })
    }
}

/// The normal displacement of prisms on the cells of a grid, beside half-spaces of their materials.
#[pyclass(frozen, name = "NormalPrisms", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyNormalPrisms {
    pub(crate) across: Across,
}

#[pymethods]
impl PyNormalPrisms {
    /// Gap (ny, nx) [m] that tractions on the lower body and a pressure (3, ny, nx) [Pa] open.
    fn opening<'py>(
        &self,
        py: Python<'py>,
        traction: PyReadonlyArray3<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let shape = [traction.shape()[1], traction.shape()[2]];
        let values = traction.in_rows()?;
        let n = shape[0] * shape[1];
        let mut opened = vec![0.0; n];
        let loads = [0, 1, 2].map(|c| values.get(c * n..(c + 1) * n));
        self.across.add(1.0, loads, &mut opened);
        opened.into_pyarray(py).reshape(shape)
    }

    /// Weights (2, ny, nx) of tractions that do what weights (ny, nx) of the gap do.
    fn back<'py>(
        &self,
        py: Python<'py>,
        weights: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Bound<'py, numpy::PyArray3<f64>>> {
        let shape = [2, weights.shape()[0], weights.shape()[1]];
        let weights = weights.in_rows()?;
        let mut traction = vec![0.0; 2 * weights.len()];
        let (along, aside) = traction.split_at_mut(weights.len());
        (self.across).add_transposed(1.0, weights, [Some(along), Some(aside), None]);
        traction.into_pyarray(py).reshape(shape)
    }
}

fn prism_of(
    elastic: (f64, f64),
    mesh: &SectionMesh,
    foundation: Option<(f64, f64)>,
) -> Result<Prism, Error> {
    let material = Material::new(elastic.0, elastic.1)?;
    let section = Section {
        nodes: mesh.nodes.clone(),
        triangles: mesh.triangles.clone(),
        base: mesh.base.clone(),
    };
    let foot = foundation.map_or(Foot::Held, |(vertical, lateral)| Foot::Pads {
        vertical,
        lateral,
    });
    Prism::new(material, &section, foot)
}

fn rows_of(
    elastic: (f64, f64),
    mesh: &SectionMesh,
    foundation: Option<(f64, f64)>,
    grid: Grid,
    monitor: Monitor<'_>,
) -> Result<(PrismRows, usize), Error> {
    let prism = prism_of(elastic, mesh, foundation)?;
    let parts = mesh.surface.len() / grid.ny;
    let edges: Vec<Vec<[usize; 3]>> = (mesh.surface.chunks_exact(parts.max(1)))
        .map(<[_]>::to_vec)
        .collect();
    Ok((
        PrismRows::new(&prism, &edges, grid, monitor)?,
        prism.unknowns(),
    ))
}

/// A prism under the hats of the nodes of patches, or under their cells; see `half_space` for the patches.
///
/// `elastic`: shear modulus [Pa] and Poisson's ratio; `foundation`: vertical and lateral stiffness per length [N/m2], or
/// a base that is held; `lines`: y of the rows of nodes of each patch, or of the borders of its rows of cells. Returns
/// the body, the number of waves, the largest wave number [1/m], the share of the last waves [-], and the unknowns.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "one body under its grids")]
pub(crate) fn prism(
    py: Python<'_>,
    elastic: (f64, f64),
    section: &PySection,
    foundation: Option<(f64, f64)>,
    patches: Vec<(f64, f64, usize, usize)>,
    spacing: Spacing,
    lines: Vec<Line<'_>>,
    hats: bool,
) -> PyResult<(PyCompliance, (usize, f64, f64, usize))> {
    let lines = lines
        .iter()
        .map(|line| Ok(slice(line)?.to_vec()))
        .collect::<PyResult<Vec<Vec<f64>>>>()?;
    let mesh = &section.0;
    let (body, unknowns) = enter(py, |monitor| {
        let prism = prism_of(elastic, mesh, foundation)?;
        let strips: Vec<Strip> = grids(&patches, &spacing)?
            .into_iter()
            .zip(lines)
            .map(|(patch, lines)| Strip { patch, lines })
            .collect();
        let body = if hats {
            PrismCompliance::under_hats(&prism, &mesh.surface, &strips, monitor)?
        } else {
            PrismCompliance::under_cells(&prism, &mesh.surface, &strips, monitor)?
        };
        Ok::<_, Error>((body, prism.unknowns()))
    })?;
    let (waves, largest, tail) = body.waves();
    Ok((
        PyCompliance(Arc::new(body)),
        (waves, largest, tail, unknowns),
    ))
}

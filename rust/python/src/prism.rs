// SPDX-License-Identifier: MIT OR Apache-2.0
//! Prisms.

use std::sync::Arc;

use mtb_elasticity::prism::{Foot, Prism, PrismCompliance, Section, Strip};
use mtb_elasticity::{Error, Material};
use mtb_geometry::solid::{RailSection, SectionMesh, rectangle_section};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::elasticity::{Spacing, grids};
use crate::error::enter;
use crate::geometry::{PyProfile, slice};
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
        let prism = Prism::new(material, &section, foot)?;
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

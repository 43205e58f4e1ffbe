// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies.

use std::sync::Arc;

use mtb_elasticity::half_space::{
    Bond, CutHats, GaussianBasis, GaussianHalfSpace, HalfSpace, HatHalfSpace, HatShare, Layered,
    Medium, Neighbours, Patch, Viscoelastic,
};
use mtb_elasticity::refined::{Carrier, Refined};
use mtb_elasticity::tetra::Sampling;
use mtb_elasticity::{Error, Lines, Material};
use mtb_operator::Grid;
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyUntypedArrayMethods,
};
use pyo3::prelude::*;

use crate::error::{bad_input, enter};
use crate::in_rows::InRows;
use crate::operator::PyCompliance;
use crate::tetra::PySampling;

/// An elastic layer on a half-space or on a rigid base, with what is known of it so far.
#[pyclass(frozen, name = "Layered", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyLayered(Arc<Layered>);

#[pymethods]
impl PyLayered {
    /// `layer`, `base`: shear modulus [Pa] and Poisson's ratio, no base for a rigid one; `thickness` [m]; whether the
    /// layer `is_bonded` to its base, or slides on it without friction.
    #[new]
    fn new(
        layer: (f64, f64),
        thickness: f64,
        base: Option<(f64, f64)>,
        is_bonded: bool,
    ) -> PyResult<Self> {
        let bond = if is_bonded {
            Bond::Bonded
        } else {
            Bond::Frictionless
        };
        let material = |(g, nu)| Material::new(g, nu);
        let body = material(layer).and_then(|layer| {
            Layered::new(layer, thickness, base.map(material).transpose()?, bond)
        });
        Ok(Self(Arc::new(body.map_err(|e| bad_input(&e))?)))
    }

    /// Displacements (n,) [m/Pa] by waves of pressure with wave numbers (n,) [1/m].
    fn waves<'py>(
        &self,
        py: Python<'py>,
        wave_numbers: PyReadonlyArray1<'py, f64>,
    ) -> Bound<'py, PyArray1<f64>> {
        let waves = wave_numbers.as_array();
        let moved = waves.iter().map(|k| self.0.waves(*k).normal);
        moved.collect::<Vec<f64>>().into_pyarray(py)
    }
}

/// What a half-space is made of: shear modulus [Pa] and Poisson's ratio; these, the compliance that creep adds over that
/// before, and the way (x, y) [m] of the contact in a creep time; or a layer on a base.
#[derive(FromPyObject)]
pub(crate) enum MediumArgument {
    Uniform((f64, f64)),
    Viscoelastic(((f64, f64), f64, (f64, f64))),
    Layered(Py<PyLayered>),
}

impl MediumArgument {
    pub(crate) fn medium(&self) -> Result<Medium, Error> {
        match self {
            Self::Uniform((g, nu)) => Ok(Material::new(*g, *nu)?.into()),
            Self::Viscoelastic(((g, nu), creep, (x, y))) => {
                let body = Viscoelastic::new(Material::new(*g, *nu)?, *creep, [*x, *y])?;
                Ok(Medium::Viscoelastic(body))
            }
            Self::Layered(body) => Ok(Medium::Layered(Arc::clone(&body.get().0))),
        }
    }
}

/// A half-space under piecewise constant tractions on rectangular patches of about one spacing.
///
/// `medium`: shear modulus [Pa] and Poisson's ratio, or a layer on a base; `patches`: (x0, y0, nx, ny) each, centre of the first cell [m] and numbers of cells; `spacing`:
/// (dx, dy) [m], or one for each patch; `interact`: whether the patches lie on one body.
#[pyfunction]
pub(crate) fn half_space(
    py: Python<'_>,
    medium: MediumArgument,
    patches: Vec<(f64, f64, usize, usize)>,
    spacing: Spacing,
    interact: bool,
) -> PyResult<PyCompliance> {
    let body = enter(py, |_| {
        HalfSpace::with_patches(
            medium.medium()?,
            grids(&patches, &spacing)?,
            neighbours(interact),
        )
    })?;
    Ok(PyCompliance(Arc::new(body)))
}

/// A half-space under tractions bilinear between the nodes of patches of about one spacing.
///
/// Arguments as of `half_space`, but nodes instead of cells. Returns the body, whose displacements are means
/// weighted with the hat of each node, and the integral of each hat (n,) [m2].
#[pyfunction]
pub(crate) fn half_space_hats(
    py: Python<'_>,
    shear_modulus: f64,
    poisson_ratio: f64,
    patches: Vec<(f64, f64, usize, usize)>,
    spacing: Spacing,
    interact: bool,
) -> PyResult<(PyCompliance, Bound<'_, PyArray1<f64>>)> {
    let body = enter(py, |_| {
        let material = Material::new(shear_modulus, poisson_ratio)?;
        HatHalfSpace::new(material, grids(&patches, &spacing)?, neighbours(interact))
    })?;
    let weights = body.weights().into_pyarray(py);
    Ok((PyCompliance(Arc::new(body)), weights))
}

/// (x0, y0, nx, ny) of a patch.
type Place = (f64, f64, usize, usize);

/// A body that is condensed onto the hats between `lines` of `patches`, with their areas `weights` (n,) [m2] and its
/// displacements (k, 3, n) by free motions, on all nodes of these: a half-space there, and the smooth rest from the
/// lines. It is the whole, or the `half` of a body
/// that is its own mirror image about y = 0.
#[pyfunction]
#[allow(
    clippy::too_many_arguments,
    reason = "the body, its motions, the grids"
)]
pub(crate) fn refined(
    py: Python<'_>,
    body: &PyCompliance,
    weights: PyReadonlyArray1<'_, f64>,
    motions: PyReadonlyArray3<'_, f64>,
    elastic: (f64, f64),
    lines: Vec<(Vec<usize>, Vec<usize>)>,
    patches: Vec<(Place, (f64, f64))>,
    half: bool,
) -> PyResult<PyCompliance> {
    let (body, weights) = (body.0.clone(), weights.in_rows()?.to_vec());
    let fields: Vec<Vec<f64>> = motions
        .in_rows()?
        .chunks_exact(weights.len().max(1))
        .map(<[f64]>::to_vec)
        .collect();
    let motions: Vec<[Vec<f64>; 3]> = fields.as_chunks().0.to_vec();
    let refined = enter(py, |_| {
        let material = Material::new(elastic.0, elastic.1)?;
        let (places, spacings): (Vec<_>, Vec<_>) = patches.into_iter().unzip();
        let patches = grids(&places, &Spacing::Each(spacings))?;
        Refined::new(
            &body,
            &weights,
            &motions,
            material,
            &chosen(lines)?,
            patches,
            half,
        )
    })?;
    Ok(PyCompliance(Arc::new(refined)))
}

/// Fields (k, n) of integrals over the hats between `lines` of patches, or of amounts by a unit of each hat, as those
/// over all hats.
#[pyfunction]
pub(crate) fn carried<'py>(
    py: Python<'py>,
    fields: PyReadonlyArray2<'py, f64>,
    lines: Vec<(Vec<usize>, Vec<usize>)>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let carrier = Carrier::new(&chosen(lines).map_err(|e| bad_input(&e))?);
    let ([n, to], count) = (carrier.points(), fields.shape()[0]);
    if fields.shape()[1] != n {
        return Err(pyo3::exceptions::PyValueError::new_err(format!(
            "fields have {} points, the lines have {n}",
            fields.shape()[1]
        )));
    }
    let rows = fields.in_rows()?.chunks_exact(n.max(1));
    let out: Vec<f64> = rows.flat_map(|row| carrier.carry(row)).collect();
    out.into_pyarray(py).reshape([count, to])
}

/// Numbers of the lines along x and y that are kept of each patch; the last ones are those of its last nodes.
pub(crate) fn chosen(lines: Vec<(Vec<usize>, Vec<usize>)>) -> Result<Vec<[Lines; 2]>, Error> {
    let one = |kept: Vec<usize>| {
        let nodes = kept.last().map_or(0, |last| last + 1);
        Lines::new(kept, nodes)
    };
    lines
        .into_iter()
        .map(|(x, y)| Ok([one(x)?, one(y)?]))
        .collect()
}

/// The same under a face that covers a grid of nodes in part.
///
/// `patch`: (x0, y0, nx, ny); `faces`: the basis of all its nodes on each part of the face; `shares`: face,
/// node, contact point and factor of the hats that make the bases of `points` contact points.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "one body under one face")]
pub(crate) fn half_space_cut_hats(
    py: Python<'_>,
    shear_modulus: f64,
    poisson_ratio: f64,
    patch: (f64, f64, usize, usize),
    spacing: (f64, f64),
    faces: Vec<PyRef<'_, PySampling>>,
    shares: Vec<(usize, usize, usize, f64)>,
    points: usize,
) -> PyResult<PyCompliance> {
    let faces: Vec<&Sampling> = faces.iter().map(|face| &face.0).collect();
    let shares: Vec<HatShare> = shares
        .into_iter()
        .map(|(face, node, point, factor)| HatShare {
            face,
            node,
            point,
            factor,
        })
        .collect();
    let body = enter(py, |_| {
        let material = Material::new(shear_modulus, poisson_ratio)?;
        let patches = grids(&[patch], &Spacing::One(spacing))?;
        let whole = HatHalfSpace::new(material, patches, Neighbours::Interact)?;
        CutHats::new(whole, &faces, &shares, points)
    })?;
    Ok(PyCompliance(Arc::new(body)))
}

/// Half-spaces of several materials under the thesis' normalised truncated Gaussians.
///
/// `materials`: (shear modulus [Pa], Poisson's ratio) each; `x`, `y`: points (n,) [m]; `domain`:
/// (x_min, x_max, y_min, y_max) [m]. Returns the bodies and the integral of each function (n,) [m2].
#[pyfunction]
pub(crate) fn half_space_gaussians<'py>(
    py: Python<'py>,
    materials: Vec<(f64, f64)>,
    x: PyReadonlyArray1<'py, f64>,
    y: PyReadonlyArray1<'py, f64>,
    standard_deviation: f64,
    domain: [f64; 4],
) -> PyResult<(Vec<PyCompliance>, Bound<'py, PyArray1<f64>>)> {
    let (x, y) = (x.in_rows()?, y.in_rows()?);
    let (bodies, weights) = enter(py, |monitor| {
        let basis = GaussianBasis::new(x, y, standard_deviation, domain)?;
        let (integrals, weights) = basis.integrals(monitor)?;
        let integrals = Arc::new(integrals);
        let bodies: Result<Vec<GaussianHalfSpace>, Error> = materials
            .iter()
            .map(|&(shear_modulus, poisson_ratio)| {
                let material = Material::new(shear_modulus, poisson_ratio)?;
                GaussianHalfSpace::new(material, Arc::clone(&integrals))
            })
            .collect();
        Ok::<_, Error>((bodies?, weights))
    })?;
    let handles = bodies
        .into_iter()
        .map(|body| PyCompliance(Arc::new(body)))
        .collect();
    Ok((handles, weights.into_pyarray(py)))
}

/// Size (dx, dy) [m] of the cells of all patches, or of each.
#[derive(FromPyObject)]
pub(crate) enum Spacing {
    One((f64, f64)),
    Each(Vec<(f64, f64)>),
}

pub(crate) fn grids(
    patches: &[(f64, f64, usize, usize)],
    spacing: &Spacing,
) -> Result<Vec<Patch>, Error> {
    patches
        .iter()
        .enumerate()
        .map(|(patch, &(x0, y0, nx, ny))| {
            let (dx, dy) = match spacing {
                Spacing::One(spacing) => *spacing,
                // none for a patch is refused as one of no size
                Spacing::Each(spacings) => spacings.get(patch).copied().unwrap_or_default(),
            };
            let grid = Grid::new(nx, ny, dx, dy)?;
            Ok(Patch { x0, y0, grid })
        })
        .collect()
}

fn neighbours(interact: bool) -> Neighbours {
    if interact {
        Neighbours::Interact
    } else {
        Neighbours::Separate
    }
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Finite-element bodies.

use std::sync::Arc;

use mtb_elasticity::tetra::{
    ContactGrid, Cost, Flexibility, Hold, Limits, Order, RigidMode, Sampling, Support,
    SurfacePoint, TetraBody, TetraMesh,
};
use mtb_elasticity::{Error, Material};
use mtb_operator::{MEMORY_LIMIT, check_memory};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::elasticity::chosen;
use crate::error::{bad_input, enter};
use crate::in_rows::InRows;
use crate::operator::PyCompliance;

type Floats<'py> = PyReadonlyArray1<'py, f64>;
type Table<'py> = PyReadonlyArray2<'py, f64>;
type Numbers<'py> = PyReadonlyArray1<'py, usize>;

/// Frames, places, rows of shares.
type Means<'py> = (
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray2<f64>>,
    (
        Bound<'py, PyArray1<usize>>,
        Bound<'py, PyArray1<usize>>,
        Bound<'py, PyArray1<f64>>,
    ),
);

/// A checked mesh of tetrahedra.
#[pyclass(frozen, name = "TetraMesh", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyTetraMesh(pub(crate) TetraMesh);

#[pymethods]
impl PyTetraMesh {
    /// `nodes` (n, 3) [m], `cells` (m, 4) or (m, 10).
    #[new]
    fn new(py: Python<'_>, nodes: Table<'_>, cells: PyReadonlyArray2<'_, usize>) -> PyResult<Self> {
        let order = match cells.shape()[1] {
            4 => Order::Linear,
            10 => Order::Quadratic,
            k => {
                return Err(PyValueError::new_err(format!(
                    "cells have {k} nodes: tetrahedra with 4 or 10 are accepted"
                )));
            }
        };
        let nodes = triples(&nodes, "nodes")?;
        let cells = flat(cells.in_rows())?.to_vec();
        enter(py, |_| TetraMesh::new(nodes, cells, order)).map(Self)
    }

    /// Triangles of the boundary (f, 3) or (f, 6), counter-clockwise seen from outside.
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<usize>>> {
        let shape = [self.0.n_faces(), self.0.order().nodes_per_face()];
        self.0.faces().to_vec().into_pyarray(py).reshape(shape)
    }

    /// Hats of a regular grid of nx by ny points (n, 3), with frames (n, 3, 3) of tangential 1,
    /// tangential 2 and into the body, sampled on some boundary triangles.
    fn sample(
        &self,
        py: Python<'_>,
        shape: (usize, usize),
        spacing: [f64; 2],
        points: Table<'_>,
        frames: PyReadonlyArray3<'_, f64>,
        faces: Numbers<'_>,
    ) -> PyResult<PySampling> {
        let grid = ContactGrid {
            nx: shape.0,
            ny: shape.1,
            spacing,
            points: triples(&points, "points")?,
            frames: bases(&frames)?,
        };
        let faces = flat(faces.in_rows())?;
        enter(py, |_| grid.sampling(&self.0, faces)).map(PySampling)
    }

    /// Fields (k, N) of the nodes at points (n, 3) [m] inside: (k, n).
    fn at_points<'py>(
        &self,
        py: Python<'py>,
        values: Table<'_>,
        points: Table<'_>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let k = values.shape()[0];
        let (values, points) = (values.to_vec()?, triples(&points, "points")?);
        let n = points.len();
        let found = enter(py, |_| self.0.at_points(&values, &points))?;
        found.into_pyarray(py).reshape([k, n])
    }

    /// Means over the contact points of a sampling on this mesh: of tangential 1, tangential 2 and into the body
    /// (3, 3, n: axis, component, point), of the places (3, n) [m]; and the starts (n + 1), columns and values of
    /// the shares of basis functions in the area of each point.
    fn averages<'py>(&self, py: Python<'py>, sampling: &PySampling) -> PyResult<Means<'py>> {
        let means = enter(py, |_| sampling.0.averages(&self.0))?;
        let n = sampling.0.n_points();
        let of = |k: usize, i: usize| means.frames[i][k / 3][k % 3];
        let frames: Vec<f64> = (0..9 * n).map(|k| of(k / n, k % n)).collect();
        let places: Vec<f64> = (0..3 * n).map(|k| means.places[k % n][k / n]).collect();
        let mut start = vec![0];
        for row in &means.shares {
            start.push(start[start.len() - 1] + row.len());
        }
        let shares = || means.shares.iter().flatten();
        let column: Vec<usize> = shares().map(|(j, _)| *j).collect();
        let share: Vec<f64> = shares().map(|(_, share)| *share).collect();
        Ok((
            frames.into_pyarray(py).reshape([3, 3, n])?,
            places.into_pyarray(py).reshape([3, n])?,
            (
                start.into_pyarray(py),
                column.into_pyarray(py),
                share.into_pyarray(py),
            ),
        ))
    }
}

/// Basis functions of a contact at quadrature points of a surface.
#[pyclass(frozen, name = "Sampling", module = "mtb_rs._mtb_rs")]
pub(crate) struct PySampling(pub(crate) Sampling);

#[pymethods]
impl PySampling {
    /// `face` (q,), `barycentric` (q, 3), `weight` (q,) [m2], `frame` (q, 3, 3), `start` (q + 1,),
    /// `point` and `value` (k,) of the basis.
    #[new]
    #[allow(
        clippy::too_many_arguments,
        reason = "the arrays of one sparse structure"
    )]
    fn new(
        n_points: usize,
        face: Numbers<'_>,
        barycentric: Table<'_>,
        weight: Floats<'_>,
        frame: PyReadonlyArray3<'_, f64>,
        start: Numbers<'_>,
        point: Numbers<'_>,
        value: Floats<'_>,
    ) -> PyResult<Self> {
        let quadrature = surface_points(&face, &barycentric, &weight, &bases(&frame)?)?;
        let (point, value) = (flat(point.in_rows())?, flat(value.in_rows())?);
        same_length("value", value.len(), point.len())?;
        let basis = point.iter().copied().zip(value.iter().copied()).collect();
        Sampling::new(n_points, quadrature, flat(start.in_rows())?.to_vec(), basis)
            .map(Self)
            .map_err(|error| bad_input(&error))
    }

    /// Samplings of several grids on one face, their contact points one after the other.
    #[staticmethod]
    fn joined(parts: Vec<PyRef<'_, Self>>) -> Self {
        let parts: Vec<Sampling> = parts.iter().map(|part| part.0.clone()).collect();
        Self(Sampling::joined(&parts))
    }

    /// The hats between some lines along x and y of each grid.
    fn on_lines(&self, lines: Vec<(Vec<usize>, Vec<usize>)>) -> PyResult<Self> {
        let lines = chosen(lines).map_err(|error| bad_input(&error))?;
        self.0
            .on_lines(&lines)
            .map(Self)
            .map_err(|error| bad_input(&error))
    }

    /// Area of each contact point (n,) [m2].
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.weights().into_pyarray(py)
    }

    /// The arrays it is made of, by name.
    fn arrays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let q = self.0.quadrature();
        let basis = || (0..q.len()).flat_map(|i| self.0.basis(i));
        let out = PyDict::new(py);
        let face: Vec<usize> = q.iter().map(|p| p.face).collect();
        let barycentric: Vec<f64> = q.iter().flat_map(|p| p.barycentric).collect();
        let weight: Vec<f64> = q.iter().map(|p| p.weight).collect();
        let frame: Vec<f64> = q.iter().flat_map(|p| p.frame).flatten().collect();
        out.set_item("face", face.into_pyarray(py))?;
        out.set_item("barycentric", rows(py, barycentric, 3)?)?;
        out.set_item("weight", weight.into_pyarray(py))?;
        out.set_item("frame", frame.into_pyarray(py).reshape([q.len(), 3, 3])?)?;
        out.set_item("start", self.0.start().to_vec().into_pyarray(py))?;
        let point: Vec<usize> = basis().map(|b| b.0).collect();
        let value: Vec<f64> = basis().map(|b| b.1).collect();
        out.set_item("point", point.into_pyarray(py))?;
        out.set_item("value", value.into_pyarray(py))?;
        Ok(out)
    }

    #[getter]
    fn n_points(&self) -> usize {
        self.0.n_points()
    }
}

/// An elastic body of tetrahedra on its supports.
#[pyclass(frozen, name = "TetraBody", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyTetraBody(TetraBody);

#[pymethods]
impl PyTetraBody {
    /// `supports`: name, node numbers, and "free", "prescribed" or "guided" for x, y, z.
    #[new]
    fn new(
        py: Python<'_>,
        mesh: &PyTetraMesh,
        shear_modulus: f64,
        poisson_ratio: f64,
        supports: Vec<(String, Vec<usize>, [String; 3])>,
    ) -> PyResult<Self> {
        let supports = supports
            .into_iter()
            .map(|(name, nodes, [x, y, z])| {
                Ok(Support {
                    name,
                    nodes,
                    hold: [hold(&x)?, hold(&y)?, hold(&z)?],
                })
            })
            .collect::<PyResult<Vec<_>>>()?;
        let mesh = mesh.0.clone();
        enter(py, |_| {
            TetraBody::new(mesh, Material::new(shear_modulus, poisson_ratio)?, supports)
        })
        .map(Self)
    }

    /// Support components that take a value: (support, component, guided).
    #[getter]
    fn cases(&self) -> Vec<(usize, usize, bool)> {
        let cases = self.0.cases().into_iter();
        cases.map(|c| (c.support, c.component, c.guided)).collect()
    }

    /// Whether it is its own mirror image, of which one half is factorised.
    #[getter]
    fn has_mirror(&self) -> bool {
        self.0.has_mirror()
    }

    /// Centre of volume [m].
    #[getter]
    fn centre<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.centre().to_vec().into_pyarray(py)
    }

    /// Rigid motions the supports leave free, about `point`: names, and (m, 9) of translation,
    /// rotation and point.
    fn modes<'py>(
        &self,
        py: Python<'py>,
        point: [f64; 3],
    ) -> PyResult<(Vec<String>, Bound<'py, PyArray2<f64>>)> {
        let modes = self.0.modes(point);
        Ok((
            modes.iter().map(RigidMode::name).collect(),
            rows(py, flat_modes(&modes), 9)?,
        ))
    }

    /// The body condensed onto the contact points of a sampling, as arrays by name; frame of the
    /// sampling.
    fn condense<'py>(
        &self,
        py: Python<'py>,
        sampling: &PySampling,
    ) -> PyResult<Bound<'py, PyDict>> {
        let body = enter(py, |monitor| {
            self.0.condense(&sampling.0, Limits::default(), monitor)
        })?;
        let n = sampling.0.n_points();
        let (m, k) = (body.modes.len(), body.cases.len());
        let out = PyDict::new(py);
        let names: Vec<String> = body.modes.iter().map(RigidMode::name).collect();
        let (weights, blocks) = body.flexibility.into_parts();
        out.set_item("weights", weights.into_pyarray(py))?;
        let blocks = blocks.into_pyarray(py);
        out.set_item("flexibility", blocks.reshape([6, n, n])?)?;
        out.set_item("mode_names", names)?;
        out.set_item("modes", rows(py, flat_modes(&body.modes), 9)?)?;
        let fields = |values: Vec<Vec<f64>>, count: usize| -> PyResult<Bound<'py, PyArray3<f64>>> {
            values.concat().into_pyarray(py).reshape([count, 3, n])
        };
        out.set_item("mode_displacement", fields(body.mode_displacement, m)?)?;
        out.set_item("case_displacement", fields(body.case_displacement, k)?)?;
        out.set_item(
            "case_work",
            body.case_work.into_pyarray(py).reshape([k, m])?,
        )?;
        out.set_item("spread_displacement", fields(body.spread_displacement, 6)?)?;
        out.set_item("centre", body.centre.to_vec().into_pyarray(py))?;
        let (balance, s) = (body.balance, self.0.supports().len());
        let contact = balance.contact.into_pyarray(py);
        out.set_item("contact_resultant", contact.reshape([6, 3, n])?)?;
        let reaction = balance.reaction.into_pyarray(py);
        out.set_item("reaction", reaction.reshape([s, 6, 3, n])?)?;
        let reaction = balance.case_reaction.into_pyarray(py);
        out.set_item("case_reaction", reaction.reshape([s, 6, k])?)?;
        let reaction = balance.spread_reaction.into_pyarray(py);
        out.set_item("spread_reaction", reaction.reshape([s, 6, 6])?)?;
        out.set_item("cost", cost(py, &body.cost)?)?;
        Ok(out)
    }

    /// Displacement (3, N) [m] under nodal forces (3, N) [N], case values, and modes (m, 9) with
    /// their amplitudes.
    fn solve<'py>(
        &self,
        py: Python<'py>,
        force: Table<'py>,
        case_value: Floats<'py>,
        modes: Table<'py>,
        amplitude: Floats<'py>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (force, value) = (flat(force.in_rows())?, flat(case_value.in_rows())?);
        let (modes, amplitude) = (flat(modes.in_rows())?, flat(amplitude.in_rows())?);
        same_length("modes", modes.len(), 9 * amplitude.len())?;
        let modes: Vec<(RigidMode, f64)> = modes
            .chunks_exact(9)
            .zip(amplitude)
            .map(|(m, &a)| {
                let mode = RigidMode {
                    translation: [m[0], m[1], m[2]],
                    rotation: [m[3], m[4], m[5]],
                    point: [m[6], m[7], m[8]],
                };
                (mode, a)
            })
            .collect();
        let u = enter(py, |monitor| {
            self.0
                .solve(force, value, &modes, Limits::default(), monitor)
        })?;
        components(py, u, 3)
    }

    /// The lowest vibrations at a density [kg/m3], as arrays by name: `squares` (k,) of the angular frequencies
    /// [1/s2], `shapes` (k, 3, N) and `rigid` (r, 3, N) [kg^-1/2], orthonormal in the product of the mass, mass times
    /// both, `inertia` (r + k, 3, N) [kg^1/2], and the `mass` [kg].
    fn vibration<'py>(
        &self,
        py: Python<'py>,
        density: f64,
        count: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let found = enter(py, |monitor| {
            self.0.vibration(density, count, Limits::default(), monitor)
        })?;
        let n = self.0.mesh().nodes().len();
        let out = PyDict::new(py);
        for (name, values) in [
            ("shapes", found.shapes),
            ("rigid", found.rigid),
            ("inertia", found.inertia),
        ] {
            let count = values.len() / (3 * n);
            out.set_item(name, values.into_pyarray(py).reshape([count, 3, n])?)?;
        }
        out.set_item("squares", found.squares.into_pyarray(py))?;
        out.set_item("mass", found.mass)?;
        out.set_item("solves", found.solves)?;
        Ok(out)
    }

    /// Nodal forces (3, N) [N] of tractions (3, n) [Pa] at contact points, frame of the sampling.
    fn contact_force<'py>(
        &self,
        py: Python<'py>,
        sampling: &PySampling,
        traction: Table<'py>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let traction = flat(traction.in_rows())?;
        let force = enter(py, |_| self.0.contact_force(&sampling.0, traction))?;
        components(py, force, 3)
    }

    /// Nodal forces (3, N) [N] of a force [N] and a moment [N m] about the centre of volume, spread over
    /// the body as weight and inertia are.
    fn spread_force<'py>(
        &self,
        py: Python<'py>,
        wrench: [f64; 6],
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        components(
            py,
            enter(py, |_| Ok::<_, Error>(self.0.spread_force(wrench)))?,
            3,
        )
    }

    /// Mean displacement (3, n) [m] of the contact points, frame of the sampling, under that of the
    /// nodes (3, N).
    fn observe<'py>(
        &self,
        py: Python<'py>,
        sampling: &PySampling,
        displacement: Table<'py>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let u = flat(displacement.in_rows())?;
        let observed = enter(py, |_| self.0.observe(&sampling.0, u))?;
        components(py, observed, 3)
    }

    /// Displacement (3, n) [m] at points (n, 3) [m] within `reach` of some boundary triangles.
    fn displacement_at<'py>(
        &self,
        py: Python<'py>,
        displacement: Table<'py>,
        points: Table<'py>,
        faces: Numbers<'py>,
        reach: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let points = triples(&points, "points")?;
        let (u, faces) = (flat(displacement.in_rows())?, flat(faces.in_rows())?);
        let moved = enter(py, |_| self.0.displacement_at(u, &points, faces, reach))?;
        components(py, moved, 3)
    }

    /// Forces (s, 3) [N] and moments (s, 3) [N m] about `point` of the supports on the body, and the
    /// largest force left over on a free node [N].
    #[allow(clippy::type_complexity, reason = "two arrays and a number")]
    fn reactions<'py>(
        &self,
        py: Python<'py>,
        displacement: Table<'py>,
        force: Table<'py>,
        point: [f64; 3],
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, f64)> {
        let (u, f) = (flat(displacement.in_rows())?, flat(force.in_rows())?);
        let (reactions, left_over) = enter(py, |_| self.0.reactions(u, f, point))?;
        let forces = reactions.iter().flat_map(|r| r.force).collect();
        let moments = reactions.iter().flat_map(|r| r.moment).collect();
        Ok((rows(py, forces, 3)?, rows(py, moments, 3)?, left_over))
    }

    /// Displacement (n, N) [m/K] of the contact points into the body by the temperatures of the nodes, for a
    /// coefficient of linear expansion [1/K].
    fn expansion<'py>(
        &self,
        py: Python<'py>,
        sampling: &PySampling,
        expansion: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let found = enter(py, |monitor| {
            (self.0).expansion(&sampling.0, expansion, Limits::default(), monitor)
        })?;
        rows(py, found, self.0.mesh().nodes().len())
    }

    /// Stress (6, N) [Pa] at the nodes, xx yy zz yz xz xy, and von Mises' equivalent (N,).
    #[allow(clippy::type_complexity, reason = "two arrays")]
    fn stress<'py>(
        &self,
        py: Python<'py>,
        displacement: Table<'py>,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>)> {
        let u = flat(displacement.in_rows())?;
        let (stress, von_mises) = enter(py, |_| self.0.stress(u))?;
        Ok((components(py, stress, 6)?, von_mises.into_pyarray(py)))
    }
}

/// The compliance of a flexibility (6, n, n): blocks 11, 22, nn, 12, 1n, 2n, and weights (n,).
#[pyfunction]
pub(crate) fn flexibility(
    weights: Floats<'_>,
    blocks: PyReadonlyArray3<'_, f64>,
) -> PyResult<PyCompliance> {
    let n = weights.len();
    if blocks.shape() != [6, n, n] {
        return Err(PyValueError::new_err(format!(
            "flexibility has shape {:?}, expected (6, {n}, {n})",
            blocks.shape()
        )));
    }
    check_memory(n, Flexibility::memory(n), MEMORY_LIMIT).map_err(|error| bad_input(&error))?;
    let blocks = flat(blocks.in_rows())?.to_vec();
    let body = Flexibility::new(flat(weights.in_rows())?.to_vec(), blocks);
    Ok(PyCompliance(Arc::new(
        body.map_err(|error: Error| bad_input(&error))?,
    )))
}

fn hold(word: &str) -> PyResult<Hold> {
    match word {
        "free" => Ok(Hold::Free),
        "prescribed" => Ok(Hold::Prescribed),
        "guided" => Ok(Hold::Guided),
        _ => Err(PyValueError::new_err(format!(
            "hold is {word:?}: \"free\", \"prescribed\" or \"guided\" is needed"
        ))),
    }
}

fn cost<'py>(py: Python<'py>, cost: &Cost) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("unknowns", cost.unknowns)?;
    out.set_item("factor_entries", cost.factor_entries)?;
    out.set_item("factor_flops", cost.factor_flops)?;
    out.set_item("forward_flops", cost.forward_flops)?;
    out.set_item("product_flops", cost.product_flops)?;
    out.set_item("peak_bytes", cost.peak_bytes)?;
    out.set_item("ordering_s", cost.ordering_s)?;
    out.set_item("assembly_s", cost.assembly_s)?;
    out.set_item("symbolic_s", cost.symbolic_s)?;
    out.set_item("numeric_s", cost.numeric_s)?;
    out.set_item("forward_s", cost.forward_s)?;
    out.set_item("product_s", cost.product_s)?;
    Ok(out)
}

fn flat_modes(modes: &[RigidMode]) -> Vec<f64> {
    modes
        .iter()
        .flat_map(|m| [m.translation, m.rotation, m.point].concat())
        .collect()
}

fn surface_points(
    face: &Numbers<'_>,
    barycentric: &Table<'_>,
    weight: &Floats<'_>,
    frames: &[[[f64; 3]; 3]],
) -> PyResult<Vec<SurfacePoint>> {
    let (face, weight) = (flat(face.in_rows())?, flat(weight.in_rows())?);
    let barycentric = triples(barycentric, "barycentric")?;
    same_length("barycentric", barycentric.len(), face.len())?;
    same_length("weight", weight.len(), face.len())?;
    same_length("frame", frames.len(), face.len())?;
    Ok((0..face.len())
        .map(|q| SurfacePoint {
            face: face[q],
            barycentric: barycentric[q],
            weight: weight[q],
            frame: frames[q],
        })
        .collect())
}

fn same_length(name: &str, found: usize, expected: usize) -> PyResult<()> {
    if found == expected {
        return Ok(());
    }
    Err(PyValueError::new_err(format!(
        "{name} has {found} entries, {expected} are needed"
    )))
}

fn flat<T>(slice: Result<&[T], impl std::fmt::Display>) -> PyResult<&[T]> {
    slice.map_err(|error| bad_input(&error))
}

pub(crate) fn triples(array: &Table<'_>, name: &str) -> PyResult<Vec<[f64; 3]>> {
    if array.shape()[1] != 3 {
        return Err(PyValueError::new_err(format!(
            "{name} have shape {:?}, expected (n, 3)",
            array.shape()
        )));
    }
    let rows = flat(array.in_rows())?.chunks_exact(3);
    Ok(rows.map(|r| [r[0], r[1], r[2]]).collect())
}

/// Rows of two numbers.
pub(crate) fn pairs(array: &Table<'_>, name: &str) -> PyResult<Vec<[f64; 2]>> {
    if array.shape()[1] != 2 {
        return Err(PyValueError::new_err(format!(
            "{name} have shape {:?}, expected (n, 2)",
            array.shape()
        )));
    }
    let rows = flat(array.in_rows())?.chunks_exact(2);
    Ok(rows.map(|r| [r[0], r[1]]).collect())
}

fn bases(array: &PyReadonlyArray3<'_, f64>) -> PyResult<Vec<[[f64; 3]; 3]>> {
    if array.shape()[1..] != [3, 3] {
        return Err(PyValueError::new_err(format!(
            "frames have shape {:?}, expected (n, 3, 3)",
            array.shape()
        )));
    }
    let rows = flat(array.in_rows())?.chunks_exact(9);
    Ok(rows
        .map(|r| [[r[0], r[1], r[2]], [r[3], r[4], r[5]], [r[6], r[7], r[8]]])
        .collect())
}

/// (n, k) from n rows of k.
fn rows(py: Python<'_>, values: Vec<f64>, k: usize) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let n = values.len() / k;
    values.into_pyarray(py).reshape([n, k])
}

/// (k, n) from k components.
fn components(py: Python<'_>, values: Vec<f64>, k: usize) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let n = values.len() / k;
    values.into_pyarray(py).reshape([k, n])
}

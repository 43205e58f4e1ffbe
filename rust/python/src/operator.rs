// SPDX-License-Identifier: MIT OR Apache-2.0
//! Compliances as Python sees them: opaque handles on contact points.

use std::sync::Arc;

use mtb_contact::sliding::{displacement, transposed};
use mtb_operator::{
    Compliance, Component, MEMORY_LIMIT, Reflected, Relative, Separate, SymmetricHalf,
    SymmetricWhole, check_memory,
};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::{apart, bad_input};
use crate::in_rows::InRows;

/// What a body contributes to a contact: traction in, displacement out, in its own frame
/// (tangential x, tangential y, into the body).
#[pyclass(frozen, name = "Compliance", module = "mtb_rs._mtb_rs")]
#[derive(Clone)]
pub(crate) struct PyCompliance(pub(crate) Arc<dyn Compliance>);

/// The component a letter names.
pub(crate) fn component(name: &str) -> PyResult<Component> {
    match name {
        "x" => Ok(Component::X),
        "y" => Ok(Component::Y),
        "n" => Ok(Component::Normal),
        _ => Err(PyValueError::new_err(format!(
            "component is {name:?}: \"x\", \"y\" or \"n\" is needed"
        ))),
    }
}

#[pymethods]
impl PyCompliance {
    /// Number of contact points.
    #[getter]
    fn points(&self) -> usize {
        self.0.points()
    }

    /// Influence coefficients (n, n) [m/Pa]: displacement `observed` by traction `loaded`, each "x", "y" or "n".
    fn influence<'py>(
        &self,
        py: Python<'py>,
        observed: &str,
        loaded: &str,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (observed, loaded) = (component(observed)?, component(loaded)?);
        let n = self.0.points();
        let needed = 8.0 * (n as f64).powi(2) + self.0.influence_memory();
        check_memory(n, needed, MEMORY_LIMIT).map_err(|error| bad_input(&error))?;
        let matrix = apart(py, || {
            let mut matrix = vec![0.0; n * n];
            self.0.add_influence(observed, loaded, 1.0, &mut matrix);
            matrix
        });
        matrix.into_pyarray(py).reshape([n, n])
    }

    /// Displacement (3, n) [m] under a traction (3, n) [Pa], both in the body's own frame.
    fn displacement<'py>(
        &self,
        py: Python<'py>,
        traction: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let n = self.0.points();
        let rows = rows3(&traction, n, "traction")?;
        let field = apart(py, || displacement(&*self.0, rows));
        field.concat().into_pyarray(py).reshape([3, n])
    }

    /// The transposed map: weights (3, n) of tractions that do what weights (3, n) of displacements do.
    fn transposed<'py>(
        &self,
        py: Python<'py>,
        weights: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let n = self.0.points();
        let rows = rows3(&weights, n, "weights")?;
        let sums = apart(py, || transposed(&*self.0, rows));
        sums.concat().into_pyarray(py).reshape([3, n])
    }

    /// Two bodies together, `None` for a rigid one: displacement of the lower one relative to the upper one by
    /// a traction on the lower one.
    #[staticmethod]
    #[pyo3(signature = (lower, upper))]
    fn relative(
        lower: Option<&Bound<'_, Self>>,
        upper: Option<&Bound<'_, Self>>,
    ) -> PyResult<Self> {
        let [lower, upper] = [lower, upper].map(|c| c.map(|c| c.get().0.clone()));
        let both = Relative::new(lower, upper).map_err(|e| bad_input(&e))?;
        Ok(Self(Arc::new(both)))
    }

    /// Bodies that touch the same lower body but not each other, point sets one after the other.
    #[staticmethod]
    fn separate(bodies: Vec<Bound<'_, Self>>) -> Self {
        Self(Arc::new(Separate(
            bodies.iter().map(|b| b.get().0.clone()).collect(),
        )))
    }

    /// The whole of which this is the half, for loads that are their own mirror images about y = 0.
    fn symmetric_whole(&self, image: Vec<usize>) -> PyResult<Self> {
        SymmetricWhole::new(self.0.clone(), &image)
            .map(|whole| Self(Arc::new(whole)))
            .ok_or_else(|| PyValueError::new_err("image must pair the contact points"))
    }

    /// Its twin in the mirror y = 0, whose point i is the image of the point `original[i]`.
    fn reflected(&self, original: Vec<usize>) -> PyResult<Self> {
        Reflected::new(self.0.clone(), original)
            .map(|twin| Self(Arc::new(twin)))
            .ok_or_else(|| PyValueError::new_err("original must number every contact point once"))
    }

    /// The same body under loads that the mirror about y = 0 turns around, on the points that are not on the plane.
    fn turned_half(&self, image: Vec<usize>) -> PyResult<Self> {
        SymmetricHalf::turned(self.0.clone(), &image)
            .map(|half| Self(Arc::new(half)))
            .ok_or_else(|| PyValueError::new_err("image must pair the contact points"))
    }

    /// The same body under loads that are their own mirror images about y = 0; point i has the image `image[i]`.
    fn symmetric_half(&self, image: Vec<usize>) -> PyResult<Self> {
        SymmetricHalf::new(self.0.clone(), &image)
            .map(|half| Self(Arc::new(half)))
            .ok_or_else(|| PyValueError::new_err("image must pair the contact points"))
    }

    fn __repr__(&self) -> String {
        format!("Compliance(points={})", self.0.points())
    }
}

/// The three rows of a (3, n) array.
pub(crate) fn rows3<'a>(
    array: &'a PyReadonlyArray2<'_, f64>,
    n: usize,
    name: &str,
) -> PyResult<[&'a [f64]; 3]> {
    use numpy::PyUntypedArrayMethods;
    if array.shape() != [3, n] {
        return Err(PyValueError::new_err(format!(
            "{name} has shape {:?}, expected (3, {n})",
            array.shape()
        )));
    }
    let flat = array
        .in_rows()
        .map_err(|_| PyValueError::new_err(format!("{name} must be C-contiguous")))?;
    Ok([&flat[..n], &flat[n..2 * n], &flat[2 * n..]])
}

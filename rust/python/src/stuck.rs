// SPDX-License-Identifier: MIT OR Apache-2.0
//! Steps in which points stick or slip, linearised.

use std::sync::Arc;

use mtb_contact::coupled::{StickFound, StickGiven};
use mtb_contact::prepared::StuckStep;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::contact::flat;
use crate::error::{apart, bad_input};
use crate::tangent::{Rows, rows, stacked};

/// The equations of a step with a shift, linearised about it, any number of cases (k) at once.
#[pyclass(frozen, name = "StickSlip", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyStickSlip(pub(crate) Arc<StuckStep>);

impl PyStickSlip {
    fn given<'py>(&self, py: Python<'py>, given: &[StickGiven]) -> PyResult<[Rows<'py>; 6]> {
        let equations = self.0.equations();
        let (n, m) = (equations.points(), equations.motions());
        Ok([
            stacked(py, n, given.iter().map(|g| &g.gap))?,
            stacked(py, m, given.iter().map(|g| &g.work))?,
            stacked(py, 2 * n, given.iter().map(|g| &g.wanted))?,
            stacked(py, 2 * n, given.iter().map(|g| &g.placed))?,
            stacked(py, n, given.iter().map(|g| &g.friction))?,
            self.pulls(py, given.iter().map(|g| &g.pull))?,
        ])
    }
}

impl PyStickSlip {
    /// Pulls of a magnet (k, n), without one (k, 0).
    fn pulls<'a, 'py>(
        &self,
        py: Python<'py>,
        pulls: impl ExactSizeIterator<Item = &'a Vec<f64>>,
    ) -> PyResult<Rows<'py>> {
        let equations = self.0.equations();
        let n = equations.pulling().map_or(0, |_| equations.points());
        let nothing = vec![0.0; n];
        let given = pulls.map(|pull| if pull.is_empty() { &nothing } else { pull });
        stacked(py, n, given)
    }

    /// Pulls out of an array, where there is a magnet.
    fn pulled(
        &self,
        name: &'static str,
        pull: &PyReadonlyArray2<'_, f64>,
        count: usize,
    ) -> PyResult<Vec<Vec<f64>>> {
        match self.0.equations().pulling() {
            Some(_) => rows(name, pull, count, self.0.equations().points()),
            None => Ok(vec![Vec::new(); count]),
        }
    }
}

/// Rows of one array after the other, as the fields of a struct.
fn zipped<const N: usize>(all: [Vec<Vec<f64>>; N]) -> impl Iterator<Item = [Vec<f64>; N]> {
    let count = all.iter().map(Vec::len).min().unwrap_or(0);
    let mut all = all.map(Vec::into_iter);
    (0..count).map(move |_| std::array::from_fn(|k| all[k].next().unwrap_or_default()))
}

#[pymethods]
impl PyStickSlip {
    /// What a unit of pose (6), shift (2), velocity (2), magnetic pressure (1) and ampere-turns (1) changes: gap, work,
    /// displacement that would let no point slip, that by pose and loads, friction, and the pull of a magnet with all gaps
    /// held, (12, 0) without one.
    fn inputs<'py>(&self, py: Python<'py>) -> PyResult<[Rows<'py>; 6]> {
        self.given(py, &self.0.inputs())
    }

    /// Pressure (10, n) by each number of a magnet that follows the gap, with all gaps held; `None` without one.
    fn magnet<'py>(&self, py: Python<'py>) -> PyResult<Option<Rows<'py>>> {
        let equations = self.0.equations();
        let fields = (equations.pulling()).map(|pulling| pulling.slopes().of_parameters());
        let rows = |fields: &[Vec<f64>]| stacked(py, equations.points(), fields.iter());
        fields.map(rows).transpose()
    }

    /// Which of the free motions were found from balance.
    fn balanced(&self) -> Vec<usize> {
        self.0.balanced().to_vec()
    }

    /// Tractions and pressures (3n,) [Pa] of the step before, and the rigid displacement then (2n,) [m].
    fn before<'py>(&self, py: Python<'py>) -> [Bound<'py, PyArray1<f64>>; 2] {
        (self.0.before().clone()).map(|part| part.into_pyarray(py))
    }

    /// Displacement of the bodies (3n,) [m] by tractions and pressures (3n,) [Pa].
    fn displacement<'py>(
        &self,
        py: Python<'py>,
        traction: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let moved = self.0.equations().left_by(flat(&traction, "traction")?);
        Ok(moved.map_err(|e| bad_input(&e))?.into_pyarray(py))
    }

    /// Weights (3n,) of tractions and pressures that do what weights (2n,) of displacements along the tangents do.
    fn transposed<'py>(
        &self,
        py: Python<'py>,
        weights: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let sums = self.0.equations().leaving(flat(&weights, "weights")?);
        Ok(sums.map_err(|e| bad_input(&e))?.into_pyarray(py))
    }

    /// Changes of tractions and pressures (k, 3n) [Pa], gap (k, n) [m], motion (k, m), slip (k, 2n) [m], rigid displacement
    /// (k, 2n) [m] and the pull of a magnet (k, n) [Pa] by those of what is given, as of `inputs`.
    #[allow(clippy::too_many_arguments, reason = "all that a step is given")]
    fn forward<'py>(
        &self,
        py: Python<'py>,
        gap: PyReadonlyArray2<'py, f64>,
        work: PyReadonlyArray2<'py, f64>,
        wanted: PyReadonlyArray2<'py, f64>,
        placed: PyReadonlyArray2<'py, f64>,
        friction: PyReadonlyArray2<'py, f64>,
        pull: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<[Rows<'py>; 6]> {
        let equations = self.0.equations();
        let (n, m, k) = (equations.points(), equations.motions(), gap.shape()[0]);
        let all = [
            rows("gap", &gap, k, n)?,
            rows("work", &work, k, m)?,
            rows("wanted", &wanted, k, 2 * n)?,
            rows("placed", &placed, k, 2 * n)?,
            rows("friction", &friction, k, n)?,
            self.pulled("pull", &pull, k)?,
        ];
        let changes: Vec<StickGiven> = zipped(all)
            .map(|[gap, work, wanted, placed, friction, pull]| StickGiven {
                gap,
                work,
                wanted,
                placed,
                friction,
                pull,
            })
            .collect();
        let found = apart(py, || equations.forward(&changes)).map_err(|e| bad_input(&e))?;
        Ok([
            stacked(py, 3 * n, found.iter().map(|f| &f.traction))?,
            stacked(py, n, found.iter().map(|f| &f.gap))?,
            stacked(py, m, found.iter().map(|f| &f.motion))?,
            stacked(py, 2 * n, found.iter().map(|f| &f.slip))?,
            stacked(py, 2 * n, found.iter().map(|f| &f.rigid))?,
            self.pulls(py, found.iter().map(|f| &f.pull))?,
        ])
    }

    /// Gradients by what is given, as of `inputs`, of sums with weights as `forward` gives changes.
    #[allow(clippy::too_many_arguments, reason = "all that a step finds")]
    fn adjoint<'py>(
        &self,
        py: Python<'py>,
        traction: PyReadonlyArray2<'py, f64>,
        gap: PyReadonlyArray2<'py, f64>,
        motion: PyReadonlyArray2<'py, f64>,
        slip: PyReadonlyArray2<'py, f64>,
        rigid: PyReadonlyArray2<'py, f64>,
        pull: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<[Rows<'py>; 6]> {
        let equations = self.0.equations();
        let (n, m, k) = (equations.points(), equations.motions(), gap.shape()[0]);
        let all = [
            rows("traction", &traction, k, 3 * n)?,
            rows("gap", &gap, k, n)?,
            rows("motion", &motion, k, m)?,
            rows("slip", &slip, k, 2 * n)?,
            rows("rigid", &rigid, k, 2 * n)?,
            self.pulled("pull", &pull, k)?,
        ];
        let weights: Vec<StickFound> = zipped(all)
            .map(|[traction, gap, motion, slip, rigid, pull]| StickFound {
                traction,
                gap,
                motion,
                slip,
                rigid,
                pull,
            })
            .collect();
        let given = apart(py, || equations.adjoint(&weights)).map_err(|e| bad_input(&e))?;
        self.given(py, &given)
    }
}

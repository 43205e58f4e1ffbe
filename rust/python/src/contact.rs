// SPDX-License-Identifier: MIT OR Apache-2.0
//! Gross sliding.

use std::sync::Arc;

use mtb_complementarity::linear::Status;
use mtb_contact::incremental::{
    IncrementalContact, IncrementalOptions, IncrementalStatus, incremental,
};
use mtb_contact::sliding::{RigidMotion, SlidingContact, SlidingMatrix};
use mtb_contact::staggered::{
    Staggered, StaggeredOptions, StaggeredStatus, best_factor, staggered,
};
use mtb_operator::{Compliance, Mirrored, Sum};
use numpy::{
    IntoPyArray, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{bad_input, enter};
use crate::operator::PyCompliance;

/// The influence matrix of a sliding pair: built once, solved for many loads.
#[pyclass(frozen, name = "SlidingPair", module = "mtb_rs._mtb_rs")]
pub(crate) struct PySlidingPair {
    matrix: SlidingMatrix,
    relative: Arc<dyn Compliance>,
    points: usize,
}

/// The relative compliance of two bodies, owned.
pub(crate) struct Pair {
    pub(crate) lower: Option<Arc<dyn Compliance>>,
    pub(crate) upper: Option<Arc<dyn Compliance>>,
}

impl Compliance for Pair {
    fn points(&self) -> usize {
        self.lower
            .as_ref()
            .or(self.upper.as_ref())
            .map_or(0, |c| c.points())
    }

    fn add_displacement(
        &self,
        observed: mtb_operator::Component,
        loaded: mtb_operator::Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        let mirrored = self.upper.as_deref().map(Mirrored);
        let mut parts: Vec<&dyn Compliance> = Vec::new();
        parts.extend(self.lower.as_deref());
        parts.extend(mirrored.as_ref().map(|m| m as &dyn Compliance));
        Sum(parts).add_displacement(observed, loaded, scale, traction, displacement);
    }

    fn influence_memory(&self) -> f64 {
        let parts = [&self.lower, &self.upper].into_iter().flatten();
        parts.map(|c| c.influence_memory()).sum()
    }

    fn add_influence(
        &self,
        observed: mtb_operator::Component,
        loaded: mtb_operator::Component,
        scale: f64,
        matrix: &mut [f64],
    ) {
        let mirrored = self.upper.as_deref().map(Mirrored);
        let mut parts: Vec<&dyn Compliance> = Vec::new();
        parts.extend(self.lower.as_deref());
        parts.extend(mirrored.as_ref().map(|m| m as &dyn Compliance));
        Sum(parts).add_influence(observed, loaded, scale, matrix);
    }
}

pub(crate) fn flat<'a>(array: &'a PyReadonlyArray1<'_, f64>, name: &str) -> PyResult<&'a [f64]> {
    array
        .as_slice()
        .map_err(|_| PyValueError::new_err(format!("{name} must be contiguous")))
}

#[pymethods]
impl PySlidingPair {
    /// `direction` (2, n): sliding direction of the upper body in the tangent plane; `None` stands for a rigid body.
    #[new]
    #[pyo3(signature = (lower, upper, direction, frictional))]
    fn new(
        py: Python<'_>,
        lower: Option<&Bound<'_, PyCompliance>>,
        upper: Option<&Bound<'_, PyCompliance>>,
        direction: PyReadonlyArray2<'_, f64>,
        frictional: bool,
    ) -> PyResult<Self> {
        let lower = lower.map(|c| c.get().0.clone());
        let upper = upper.map(|c| c.get().0.clone());
        if let (Some(l), Some(u)) = (&lower, &upper)
            && l.points() != u.points()
        {
            return Err(PyValueError::new_err(format!(
                "the lower body has {} contact points, the upper one {}",
                l.points(),
                u.points()
            )));
        }
        let pair: Arc<dyn Compliance> = Arc::new(Pair { lower, upper });
        let direction = direction
            .as_slice()
            .map_err(|_| PyValueError::new_err("direction must be C-contiguous"))?;
        let matrix = enter(py, |monitor| {
            SlidingMatrix::new(&*pair, direction, frictional, monitor)
        })?;
        Ok(Self {
            matrix,
            points: pair.points(),
            relative: pair,
        })
    }

    /// Number of contact points.
    #[getter]
    fn points(&self) -> usize {
        self.points
    }

    /// Whether friction changes the gap at all.
    #[getter]
    fn is_coupled(&self) -> bool {
        self.matrix.is_coupled()
    }

    /// The relative compliance of the pair.
    #[getter]
    fn compliance(&self) -> PyCompliance {
        PyCompliance(self.relative.clone())
    }

    /// Factor on `friction` up to which the sliding state exists and is unique; `inf` where uncoupled.
    fn wedging_factor(
        &self,
        py: Python<'_>,
        area: PyReadonlyArray1<'_, f64>,
        friction: PyReadonlyArray1<'_, f64>,
        motions: PyReadonlyArray3<'_, f64>,
    ) -> PyResult<f64> {
        let (area, friction) = (flat(&area, "area")?, flat(&friction, "friction")?);
        let motions = rigid_motions(&motions, &[], self.points)?;
        enter(py, |monitor| {
            self.matrix
                .wedging_factor(area, friction, &motions, monitor)
        })
    }

    /// Solves for one load; returns a dictionary of arrays and counts.
    #[pyo3(signature = (gap, area, friction, direction, motions, work, start=None))]
    #[allow(
        clippy::too_many_arguments,
        reason = "the arrays of one contact problem"
    )]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        gap: PyReadonlyArray1<'py, f64>,
        area: PyReadonlyArray1<'py, f64>,
        friction: PyReadonlyArray1<'py, f64>,
        direction: PyReadonlyArray2<'py, f64>,
        motions: PyReadonlyArray3<'py, f64>,
        work: PyReadonlyArray1<'py, f64>,
        start: Option<Vec<bool>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (gap, area, friction) = (
            flat(&gap, "gap")?,
            flat(&area, "area")?,
            flat(&friction, "friction")?,
        );
        let direction = direction
            .as_slice()
            .map_err(|_| PyValueError::new_err("direction must be C-contiguous"))?;
        let motions = rigid_motions(&motions, flat(&work, "work")?, self.points)?;
        let solution = enter(py, |monitor| {
            let contact = SlidingContact {
                gap,
                area,
                friction,
                direction,
                motions: &motions,
            };
            self.matrix.solve(&contact, start, monitor)
        })?;
        let out = PyDict::new(py);
        out.set_item("status", status_name(solution.status))?;
        out.set_item("pressure", solution.pressure.into_pyarray(py))?;
        out.set_item("gap", solution.gap.into_pyarray(py))?;
        out.set_item("motion", solution.motion.into_pyarray(py))?;
        out.set_item("iterations", solution.iterations)?;
        out.set_item("residual", solution.residual)?;
        out.set_item("by_lemke", solution.by_lemke)?;
        out.set_item("unstable", solution.unstable)?;
        Ok(out)
    }
}

pub(crate) fn status_name(status: Status) -> &'static str {
    match status {
        Status::Solved => "solved",
        Status::NoSolution => "no solution",
        Status::Unreachable => "unreachable",
        Status::IterationLimit => "iteration limit",
    }
}

/// Motions from (m, 3, n): relative displacement along x and y (lower minus upper), opening.
pub(crate) fn rigid_motions(
    motions: &PyReadonlyArray3<'_, f64>,
    work: &[f64],
    n: usize,
) -> PyResult<Vec<RigidMotion>> {
    let shape = motions.shape();
    if shape[1..] != [3, n] {
        return Err(PyValueError::new_err(format!(
            "motions has shape {shape:?}, expected (m, 3, {n})"
        )));
    }
    let flat = motions.as_slice().map_err(|e| bad_input(&e))?;
    Ok(flat
        .chunks_exact((3 * n).max(1))
        .enumerate()
        .map(|(k, m)| RigidMotion {
            tangential_x: m[..n].to_vec(),
            tangential_y: m[n..2 * n].to_vec(),
            opening: m[2 * n..].to_vec(),
            work: work.get(k).copied().unwrap_or(0.0),
        })
        .collect())
}

/// The thesis' staggered scheme on given influence matrices; returns a dictionary of arrays and counts.
#[pyfunction]
#[pyo3(signature = (half_spaces, structure, gap, area, motion, balance, target, factor, max_iterations, tolerance, anderson_depth))]
#[allow(
    clippy::too_many_arguments,
    reason = "the arrays of one contact problem"
)]
pub(crate) fn solve_staggered<'py>(
    py: Python<'py>,
    half_spaces: PyReadonlyArray2<'py, f64>,
    structure: PyReadonlyArray2<'py, f64>,
    gap: PyReadonlyArray1<'py, f64>,
    area: PyReadonlyArray1<'py, f64>,
    motion: PyReadonlyArray2<'py, f64>,
    balance: PyReadonlyArray2<'py, f64>,
    target: PyReadonlyArray1<'py, f64>,
    factor: Option<f64>,
    max_iterations: usize,
    tolerance: f64,
    anderson_depth: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let matrix = |a: &'_ PyReadonlyArray2<'py, f64>| a.as_slice().map(<[f64]>::to_vec);
    let (half_spaces, structure) = (
        matrix(&half_spaces).map_err(|e| bad_input(&e))?,
        matrix(&structure).map_err(|e| bad_input(&e))?,
    );
    let (motion, balance) = (
        matrix(&motion).map_err(|e| bad_input(&e))?,
        matrix(&balance).map_err(|e| bad_input(&e))?,
    );
    let problem = Staggered {
        half_spaces: &half_spaces,
        structure: &structure,
        gap: flat(&gap, "gap")?,
        area: flat(&area, "area")?,
        motion: &motion,
        balance: &balance,
        target: flat(&target, "target")?,
    };
    let options = StaggeredOptions {
        factor,
        max_iterations,
        tolerance,
        anderson_depth,
    };
    let (solution, limit) = enter(py, |monitor| {
        let solution = staggered(&problem, &options, monitor)?;
        let (_, limit) = best_factor(&problem, &solution.contact.pressure, monitor)?;
        Ok::<_, mtb_contact::Error>((solution, limit))
    })?;
    let out = PyDict::new(py);
    let status = match solution.status {
        StaggeredStatus::Converged => "solved",
        StaggeredStatus::IterationLimit => "iteration limit",
        StaggeredStatus::Diverged => "diverged",
        StaggeredStatus::NoSolution => "no solution",
    };
    out.set_item("status", status)?;
    out.set_item("pressure", solution.contact.pressure.into_pyarray(py))?;
    out.set_item("gap", solution.contact.slack.into_pyarray(py))?;
    out.set_item("motion", solution.contact.motion.into_pyarray(py))?;
    out.set_item("displacement", solution.displacement.into_pyarray(py))?;
    out.set_item(
        "residual",
        solution.history.last().copied().unwrap_or(f64::INFINITY),
    )?;
    out.set_item("iterations", solution.history.len())?;
    out.set_item("history", solution.history)?;
    out.set_item("active_sets", solution.active_sets)?;
    out.set_item("factor", solution.factor)?;
    out.set_item("predicted_limit", limit)?;
    Ok(out)
}

/// The parameters of the thesis' incremental scheme.
#[pyclass(
    frozen,
    get_all,
    name = "IncrementalOptions",
    module = "mtb_rs._mtb_rs"
)]
#[derive(Clone)]
pub(crate) struct PyIncrementalOptions {
    estimated_steps: usize,
    force_tolerance: f64,
    distance_tolerance: Option<f64>,
    max_resolutions: usize,
    max_releases: usize,
    max_increments: usize,
}

#[pymethods]
impl PyIncrementalOptions {
    #[new]
    #[pyo3(signature = (*, estimated_steps=20, force_tolerance=1.0, distance_tolerance=None, max_resolutions=20, max_releases=20, max_increments=500))]
    fn new(
        estimated_steps: usize,
        force_tolerance: f64,
        distance_tolerance: Option<f64>,
        max_resolutions: usize,
        max_releases: usize,
        max_increments: usize,
    ) -> Self {
        Self {
            estimated_steps,
            force_tolerance,
            distance_tolerance,
            max_resolutions,
            max_releases,
            max_increments,
        }
    }

    fn __repr__(&self) -> String {
        format!(
            "IncrementalOptions(estimated_steps={}, force_tolerance={:e}, distance_tolerance={:?}, \
             max_resolutions={}, max_releases={}, max_increments={})",
            self.estimated_steps,
            self.force_tolerance,
            self.distance_tolerance,
            self.max_resolutions,
            self.max_releases,
            self.max_increments
        )
    }
}

/// The thesis' incremental scheme; returns a dictionary of arrays and counts.
///
/// `lower_points`, `upper_points` (3, n): corresponding points of the undeformed surfaces; `grids`: numbers of
/// points along x and y of the grids they form; `force`: pressing the upper body down [N].
#[pyfunction]
#[allow(
    clippy::too_many_arguments,
    reason = "the arrays of one contact problem"
)]
pub(crate) fn solve_incremental<'py>(
    py: Python<'py>,
    lower: Option<&Bound<'py, PyCompliance>>,
    upper: Option<&Bound<'py, PyCompliance>>,
    lower_points: PyReadonlyArray2<'py, f64>,
    upper_points: PyReadonlyArray2<'py, f64>,
    grids: Vec<(usize, usize)>,
    area: PyReadonlyArray1<'py, f64>,
    friction: PyReadonlyArray1<'py, f64>,
    direction: [f64; 3],
    force: f64,
    options: &Bound<'py, PyIncrementalOptions>,
) -> PyResult<Bound<'py, PyDict>> {
    let [lower, upper] = [lower, upper].map(|c| c.map(|c| c.get().0.clone()));
    let contact = IncrementalContact {
        lower: lower.as_deref(),
        upper: upper.as_deref(),
        lower_points: lower_points.as_slice().map_err(|e| bad_input(&e))?,
        upper_points: upper_points.as_slice().map_err(|e| bad_input(&e))?,
        grids: &grids,
        area: flat(&area, "area")?,
        friction: flat(&friction, "friction")?,
        direction,
        force,
    };
    let options = options.get();
    let options = IncrementalOptions {
        estimated_steps: options.estimated_steps,
        force_tolerance: options.force_tolerance,
        distance_tolerance: options.distance_tolerance,
        max_resolutions: options.max_resolutions,
        max_releases: options.max_releases,
        max_increments: options.max_increments,
    };
    let solution = enter(py, |monitor| incremental(&contact, &options, monitor))?;
    let n = solution.pressure.len();
    let status = match solution.status {
        IncrementalStatus::Converged => "solved",
        IncrementalStatus::IncrementLimit => "iteration limit",
        IncrementalStatus::Unresolved => "unresolved",
        IncrementalStatus::NoSolution => "no solution",
    };
    let vectors = |field: Vec<f64>| field.into_pyarray(py).reshape([3, n]);
    let out = PyDict::new(py);
    out.set_item("status", status)?;
    out.set_item("pressure", solution.pressure.into_pyarray(py))?;
    out.set_item("traction", vectors(solution.traction)?)?;
    out.set_item("gap", solution.gap.into_pyarray(py))?;
    out.set_item("lower_displacement", vectors(solution.lower_displacement)?)?;
    out.set_item("upper_displacement", vectors(solution.upper_displacement)?)?;
    out.set_item("normal", vectors(solution.normal)?)?;
    out.set_item("approach", solution.approach)?;
    out.set_item("force", solution.force)?;
    out.set_item("residual", solution.residual)?;
    out.set_item("imbalance", solution.imbalance)?;
    out.set_item("increments", solution.increments)?;
    out.set_item("resolutions", solution.resolutions)?;
    out.set_item("problems", solution.problems)?;
    out.set_item("active_sets", solution.active_sets)?;
    out.set_item("releases", solution.releases)?;
    out.set_item("history", solution.history)?;
    Ok(out)
}

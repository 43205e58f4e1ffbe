// SPDX-License-Identifier: MIT OR Apache-2.0
//! Profiles, surfaces, contact points and gaps.

use std::ops::ControlFlow;
use std::sync::Arc;

use mtb_geometry::{
    Axle, Closure, Column, ContactGrid, ContactPoints, HeightField, HeightSurface, Interpolation,
    PoleShoe, ProfileForm, ProfileTable, StandingWheelset, Station, Surface, SurfaceMesh,
    SurfacePair, Touch, WheelOnRail, WheelRailLoad,
};
use mtb_operator::{Monitor, Progress};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::{apart, bad_input, enter};
use crate::in_rows::InRows;

/// A height z(y) of a cross-section; private, use `mtb_rs.geometry.Profile`.
#[pyclass(frozen, name = "Profile", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyProfile(pub(crate) mtb_geometry::Profile);

type Values<'py> = Bound<'py, PyArray1<f64>>;

pub(crate) fn slice<'a>(array: &'a PyReadonlyArray1<'_, f64>) -> PyResult<&'a [f64]> {
    array.in_rows().map_err(|error| bad_input(&error))
}

/// `(k, n)` from k rows laid one after the other.
fn rows(py: Python<'_>, values: Vec<f64>, k: usize) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let n = values.len() / k;
    values.into_pyarray(py).reshape([k, n])
}

fn interpolation_named(name: &str) -> PyResult<Interpolation> {
    match name {
        "smooth" => Ok(Interpolation::Smooth),
        "linear" => Ok(Interpolation::Linear),
        other => Err(PyValueError::new_err(format!(
            "interpolation is {other:?}: \"smooth\" or \"linear\" is accepted"
        ))),
    }
}

type Columns<'py> = (Bound<'py, PyArray2<f64>>, Vec<usize>, Vec<Option<f64>>);

/// Two or three columns of a text, (k, n) in SI units, by the names, units and factors of each, the last of any
/// name; the line of each row, and the factors that the heading states. Private, use the `from_file` of what
/// they are.
#[pyfunction]
pub(crate) fn read_columns<'py>(
    py: Python<'py>,
    text: &str,
    names: Vec<Vec<String>>,
    units: Vec<Vec<(String, f64)>>,
) -> PyResult<Columns<'py>> {
    match names.len() {
        3 => columns::<3>(py, text, &names, &units),
        _ => columns::<2>(py, text, &names, &units),
    }
}

fn columns<'py, const N: usize>(
    py: Python<'py>,
    text: &str,
    names: &[Vec<String>],
    units: &[Vec<(String, f64)>],
) -> PyResult<Columns<'py>> {
    let names: [Vec<&str>; N] =
        std::array::from_fn(|k| names[k].iter().map(String::as_str).collect());
    let units: [Vec<(&str, f64)>; N] = std::array::from_fn(|k| {
        let named = units[k].iter();
        named
            .map(|(name, factor)| (name.as_str(), *factor))
            .collect()
    });
    let columns: [Column<'_>; N] = std::array::from_fn(|k| Column {
        names: &names[k],
        units: &units[k],
        is_other: k == N - 1,
    });
    let read = mtb_geometry::read_columns(text.lines().enumerate(), &columns)
        .map_err(|error| bad_input(&error))?;
    let values = read.units.iter().enumerate().flat_map(|(k, unit)| {
        let factor = unit.unwrap_or(1.0);
        read.rows.iter().map(move |row| factor * row[k])
    });
    Ok((
        rows(py, values.collect(), N)?,
        read.lines,
        read.units.to_vec(),
    ))
}

type Table<'py> = (Values<'py>, Values<'py>, Option<f64>, &'static str);

/// Points of a profile file in its own unit, this unit [m] where the file states it, and the form of the file.
#[pyfunction]
pub(crate) fn read_profile<'py>(py: Python<'py>, text: &str) -> PyResult<Table<'py>> {
    let table = ProfileTable::read(text).map_err(|error| bad_input(&error))?;
    let form = match table.form {
        ProfileForm::Columns => "columns",
        ProfileForm::Heading => "heading",
        ProfileForm::Framed => "framed",
        ProfileForm::MiniProf => "miniprof",
    };
    let [y, z] = [table.y, table.z].map(|values| values.into_pyarray(py));
    Ok((y, z, table.unit, form))
}

/// Where a rigid wheelset touches both rails at each lateral shift, rows of (14, n): height and roll of the axle,
/// then of the left and of the right wheel, this in a mirror, y and z in the track, y of both profiles, slope angle
/// and radius.
///
/// `pairs`: wheel, rail and radius of the tape circle, left and right.
#[pyfunction]
#[pyo3(signature = (pairs, *, gauge, gauge_depth, rail_inclination, flange_back, tape_circle, level, shifts))]
#[allow(clippy::too_many_arguments, clippy::type_complexity)] // reason: keyword-only
pub(crate) fn standing_wheelsets<'py>(
    py: Python<'py>,
    pairs: [(PyRef<'_, PyProfile>, PyRef<'_, PyProfile>, f64); 2],
    gauge: f64,
    gauge_depth: f64,
    rail_inclination: f64,
    flange_back: f64,
    tape_circle: f64,
    level: bool,
    shifts: PyReadonlyArray1<'_, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let pairs = pairs.map(|(wheel, rail, wheel_radius)| WheelOnRail {
        wheel_radius,
        gauge,
        gauge_depth,
        rail_inclination,
        flange_back,
        tape_circle,
        ..WheelOnRail::new(wheel.0.clone(), rail.0.clone())
    });
    let axle = if level { Axle::Level } else { Axle::Free };
    let shifts = slice(&shifts)?.to_vec();
    let found = enter(py, |monitor| {
        StandingWheelset::over_shifts(&pairs, axle, &shifts, &|| look(monitor))
    })?;
    let row = |value: &dyn Fn(&StandingWheelset) -> f64| -> Vec<f64> {
        found.iter().map(value).collect()
    };
    let mut values = row(&|w| w.height);
    values.extend(row(&|w| w.roll));
    let sides: [fn(&StandingWheelset) -> &Touch; 2] = [|w| &w.left, |w| &w.right];
    for side in sides {
        values.extend(row(&|w| side(w).position[0]));
        values.extend(row(&|w| side(w).position[1]));
        values.extend(row(&|w| side(w).rail_position));
        values.extend(row(&|w| side(w).wheel_position));
        values.extend(row(&|w| side(w).angle));
        values.extend(row(&|w| side(w).rolling_radius));
    }
    rows(py, values, 14)
}

#[pymethods]
impl PyProfile {
    #[staticmethod]
    fn rail_60e1() -> Self {
        Self(mtb_geometry::Profile::rail_60e1())
    }

    #[staticmethod]
    fn wheel_s1002() -> Self {
        Self(mtb_geometry::Profile::wheel_s1002())
    }

    #[staticmethod]
    fn from_points(
        y: PyReadonlyArray1<'_, f64>,
        z: PyReadonlyArray1<'_, f64>,
        interpolation: &str,
    ) -> PyResult<Self> {
        let interpolation = interpolation_named(interpolation)?;
        mtb_geometry::Profile::from_points(slice(&y)?, slice(&z)?, interpolation)
            .map(Self)
            .map_err(|error| bad_input(&error))
    }

    /// From the numbers of pieces: ends, kind 0, origin, count and coefficients of each polynomial.
    #[staticmethod]
    fn from_numbers(numbers: PyReadonlyArray1<'_, f64>) -> PyResult<Self> {
        mtb_geometry::Profile::from_numbers(slice(&numbers)?)
            .map(Self)
            .map_err(|error| bad_input(&error))
    }

    fn range(&self) -> (f64, f64) {
        self.0.range().into()
    }

    fn breaks<'py>(&self, py: Python<'py>) -> Values<'py> {
        self.0.breaks().into_pyarray(py)
    }

    /// Height, slope, curvature and the two components of the normal: (5, n).
    fn stations<'py>(
        &self,
        py: Python<'py>,
        y: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let y = slice(&y)?;
        let stations = enter(py, |_| self.0.stations(y))?;
        let quantities: [fn(&Station) -> f64; 5] = [
            |s| s.height,
            |s| s.slope,
            Station::curvature,
            |s| s.normal()[0],
            |s| s.normal()[1],
        ];
        let values = quantities.iter().flat_map(|f| stations.iter().map(f));
        rows(py, values.collect(), 5)
    }

    fn arc_length<'py>(
        &self,
        py: Python<'py>,
        y: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Values<'py>> {
        let y = slice(&y)?;
        Ok(enter(py, |_| self.0.arc_length(y))?.into_pyarray(py))
    }

    fn position<'py>(
        &self,
        py: Python<'py>,
        s: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Values<'py>> {
        let s = slice(&s)?;
        Ok(enter(py, |_| self.0.position(s))?.into_pyarray(py))
    }
}

/// How a profile varies along the track or around the wheel; private, use `mtb_rs.RailSlices` and
/// `mtb_rs.WheelSlices`.
#[pyclass(frozen, name = "Slices", module = "mtb_rs._mtb_rs")]
pub(crate) struct PySlices {
    pub(crate) slices: Arc<mtb_geometry::Slices>,
    nominal: mtb_geometry::Profile,
}

#[pymethods]
impl PySlices {
    /// Through sections; `features`: y of each, on the nominal profile first.
    #[new]
    fn new(
        py: Python<'_>,
        nominal: &PyProfile,
        positions: PyReadonlyArray1<'_, f64>,
        sections: Vec<PyRef<'_, PyProfile>>,
        features: Vec<Vec<f64>>,
        around: bool,
    ) -> PyResult<Self> {
        let positions = slice(&positions)?;
        let sections: Vec<_> = sections.iter().map(|section| section.0.clone()).collect();
        let nominal = nominal.0.clone();
        let slices = enter(py, |_| {
            mtb_geometry::Slices::new(&nominal, positions, &sections, &features, around)
        })?;
        Ok(Self {
            slices: Arc::new(slices),
            nominal,
        })
    }

    /// The nominal profile raised all across.
    #[staticmethod]
    fn raised(
        nominal: &PyProfile,
        positions: PyReadonlyArray1<'_, f64>,
        heights: PyReadonlyArray1<'_, f64>,
        around: bool,
    ) -> PyResult<Self> {
        let nominal = nominal.0.clone();
        let (positions, heights) = (slice(&positions)?, slice(&heights)?);
        let slices = mtb_geometry::Slices::raised(&nominal, positions, heights, around)
            .map_err(|error| bad_input(&error))?;
        Ok(Self {
            slices: Arc::new(slices),
            nominal,
        })
    }

    /// Ends of what all sections have in common, on the nominal profile.
    fn range(&self) -> (f64, f64) {
        self.slices.range().into()
    }

    /// Height, its changes across and along, and y on the nominal profile, NaN beside the sections: (4, n).
    fn at<'py>(
        &self,
        py: Python<'py>,
        position: PyReadonlyArray1<'py, f64>,
        y: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (position, y) = (slice(&position)?, slice(&y)?);
        let found: Vec<mtb_geometry::Sliced> = apart(py, || {
            let places = position.iter().zip(y);
            places
                .map(|(s, y)| self.slices.at(&self.nominal, *s, *y))
                .collect()
        });
        let quantities: [fn(&mtb_geometry::Sliced) -> f64; 4] =
            [|s| s.height, |s| s.slope, |s| s.rate, |s| s.nominal];
        let values = quantities.iter().flat_map(|f| {
            found
                .iter()
                .map(move |s| if s.is_there { f(s) } else { f64::NAN })
        });
        rows(py, values.collect(), 4)
    }
}

/// Contact points with the gap above them, (3, n) and (n,).
#[pyclass(frozen, get_all, name = "ContactPoints", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyContactPoints {
    points: Py<PyArray2<f64>>,
    normal: Py<PyArray2<f64>>,
    tangent_x: Py<PyArray2<f64>>,
    tangent_y: Py<PyArray2<f64>>,
    arc_length: Py<PyArray1<f64>>,
    gap: Py<PyArray1<f64>>,
}

impl PyContactPoints {
    fn new(py: Python<'_>, points: ContactPoints) -> PyResult<Py<Self>> {
        let made = Self {
            points: rows(py, points.positions, 3)?.unbind(),
            normal: rows(py, points.normals, 3)?.unbind(),
            tangent_x: rows(py, points.tangents_x, 3)?.unbind(),
            tangent_y: rows(py, points.tangents_y, 3)?.unbind(),
            arc_length: points.arc_lengths.into_pyarray(py).unbind(),
            gap: points.gap.into_pyarray(py).unbind(),
        };
        Py::new(py, made)
    }
}

/// The potential contact: cells, their corners and areas, and of each patch its counts (nx, ny) and first cell
/// and node, its spacing, and its origin.
#[pyclass(frozen, get_all, name = "ContactGrid", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyContactGrid {
    cells: Py<PyContactPoints>,
    nodes: Py<PyContactPoints>,
    area: Py<PyArray1<f64>>,
    patches: Vec<([usize; 4], [f64; 2], [f64; 2])>,
}

impl PyContactGrid {
    fn new(py: Python<'_>, grid: ContactGrid) -> PyResult<Self> {
        let patches = grid.patches.iter();
        Ok(Self {
            patches: patches
                .map(|g| ([g.nx, g.ny, g.start, g.node_start], g.spacing, g.origin))
                .collect(),
            cells: PyContactPoints::new(py, grid.cells)?,
            nodes: PyContactPoints::new(py, grid.nodes)?,
            area: grid.areas.into_pyarray(py).unbind(),
        })
    }
}

/// Contact of a wheel on a rail, and the gap (ny, nx) over its plane.
#[pyclass(frozen, get_all, name = "WheelRailGap", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyWheelRailGap {
    gap: Py<PyArray2<f64>>,
    start: [f64; 2],
    contact_angle: f64,
    origin: [f64; 2],
    rail_position: f64,
    wheel_position: f64,
    first_rail_position: f64,
    undeformed_height: f64,
    approach: f64,
    neglected: f64,
}

/// A look at a wish to stop, of work that tells no progress.
fn look(monitor: Monitor<'_>) -> ControlFlow<()> {
    monitor(Progress {
        iteration: 0,
        residual: f64::NAN,
    })
}

/// The numbers of a pole shoe, attributes of the shoe in Python.
#[derive(FromPyObject)]
pub(crate) struct Shoe {
    length: f64,
    inner_edge: f64,
    conforming_to: f64,
    outer_edge: f64,
    relief_slope: f64,
    poles: usize,
    lateral: f64,
    yaw: f64,
}

impl Shoe {
    pub(crate) fn on(&self, rail: &PyProfile) -> PoleShoe {
        PoleShoe {
            rail: rail.0.clone(),
            length: self.length,
            inner_edge: self.inner_edge,
            conforming_to: self.conforming_to,
            outer_edge: self.outer_edge,
            relief_slope: self.relief_slope,
            poles: self.poles,
            lateral: self.lateral,
            yaw: self.yaw,
        }
    }
}

/// The potential contact of a pole shoe on a rail.
#[pyfunction]
pub(crate) fn pole_shoe_grid(
    py: Python<'_>,
    rail: &PyProfile,
    shoe: Shoe,
    spacing: [f64; 2],
) -> PyResult<PyContactGrid> {
    let shoe = shoe.on(rail);
    let laid = enter(py, |_| shoe.grid(spacing))?;
    PyContactGrid::new(py, laid)
}

/// Contact of a wheel on a rail, and the gap over its plane.
#[pyfunction]
#[pyo3(signature = (wheel, rail, *, wheel_radius, roller_radius, gauge, gauge_depth, rail_inclination, flange_back, tape_circle, lateral, force, contact_modulus, approach, spacing, scale))]
#[allow(clippy::too_many_arguments)] // reason: keyword-only, one for each parameter of the pair
pub(crate) fn wheel_on_rail_gap(
    py: Python<'_>,
    wheel: &PyProfile,
    rail: &PyProfile,
    wheel_radius: f64,
    roller_radius: Option<f64>,
    gauge: f64,
    gauge_depth: f64,
    rail_inclination: f64,
    flange_back: f64,
    tape_circle: f64,
    lateral: f64,
    force: f64,
    contact_modulus: f64,
    approach: Option<f64>,
    spacing: [f64; 2],
    scale: f64,
) -> PyResult<PyWheelRailGap> {
    let pair = WheelOnRail {
        wheel: wheel.0.clone(),
        rail: rail.0.clone(),
        wheel_radius,
        roller_radius,
        gauge,
        gauge_depth,
        rail_inclination,
        flange_back,
        tape_circle,
        lateral,
        wheel_slices: None,
        rail_slices: None,
    };
    let load = approach.map_or(
        WheelRailLoad::Force {
            vertical: force,
            contact_modulus,
        },
        WheelRailLoad::Approach,
    );
    let (contact, field) = enter(py, |monitor| {
        let contact = pair.contact(load)?;
        let field = pair.gap(&contact, spacing, scale, &|| look(monitor))?;
        Ok::<_, mtb_geometry::Error>((contact, field))
    })?;
    let shape = [field.ny, field.nx];
    Ok(PyWheelRailGap {
        gap: field.gap.into_pyarray(py).reshape(shape)?.unbind(),
        start: field.start,
        contact_angle: contact.angle,
        origin: contact.origin,
        rail_position: contact.rail_position,
        wheel_position: contact.wheel_position,
        first_rail_position: contact.first_rail_position,
        undeformed_height: contact.undeformed_height,
        approach: contact.approach,
        neglected: contact.neglected,
    })
}

/// The surface of a body; private, use `mtb_rs.surfaces.BodySurface`.
#[pyclass(frozen, name = "BodySurface", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyBodySurface(Arc<dyn Surface>);

/// Rows of an `(n, 3)` array.
fn triples<T: numpy::Element + Copy>(array: &PyReadonlyArray2<'_, T>) -> PyResult<Vec<[T; 3]>> {
    let values = array.in_rows().map_err(|error| bad_input(&error))?;
    let (rows, rest) = values.as_chunks::<3>();
    if array.as_array().shape()[1] != 3 || !rest.is_empty() {
        return Err(PyValueError::new_err("an array (n, 3) is needed"));
    }
    Ok(rows.to_vec())
}

impl PyBodySurface {
    fn smooth(surface: HeightSurface) -> PyResult<Self> {
        let surface = surface.checked().map_err(|error| bad_input(&error))?;
        Ok(Self(Arc::new(surface)))
    }
}

#[pymethods]
impl PyBodySurface {
    #[staticmethod]
    fn plane(height: f64) -> PyResult<Self> {
        Self::smooth(HeightSurface::Plane { height })
    }

    #[staticmethod]
    fn block(size: [f64; 2], height: f64) -> PyResult<Self> {
        Self::smooth(HeightSurface::Block { size, height })
    }

    #[staticmethod]
    fn paraboloid(radii: [f64; 2]) -> PyResult<Self> {
        Self::smooth(HeightSurface::Paraboloid { radii })
    }

    #[staticmethod]
    fn prism(profile: &PyProfile, length: f64) -> PyResult<Self> {
        let profile = profile.0.clone();
        Self::smooth(HeightSurface::Prism { profile, length })
    }

    #[staticmethod]
    fn height_field(
        heights: PyReadonlyArray2<'_, f64>,
        start: [f64; 2],
        spacing: [f64; 2],
    ) -> PyResult<Self> {
        let &[ny, nx] = heights.as_array().shape() else {
            return Err(PyValueError::new_err("heights must be (ny, nx)"));
        };
        let values = heights.in_rows().map_err(|error| bad_input(&error))?;
        let field = HeightField::new(values, [ny, nx], start, spacing);
        Self::smooth(HeightSurface::Field(
            field.map_err(|error| bad_input(&error))?,
        ))
    }

    #[staticmethod]
    fn mesh(
        py: Python<'_>,
        vertices: PyReadonlyArray2<'_, f64>,
        triangles: PyReadonlyArray2<'_, usize>,
        closed: bool,
    ) -> PyResult<Self> {
        let vertices = triples(&vertices)?;
        let triangles = triples(&triangles)?;
        let closure = if closed {
            Closure::Closed
        } else {
            Closure::Open
        };
        let mesh = enter(py, |_| SurfaceMesh::new(vertices, triangles, closure))?;
        Ok(Self(Arc::new(mesh)))
    }

    /// Height of the highest point over each `(x, y)`, NaN beside the body.
    fn top<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray1<'py, f64>,
        y: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Values<'py>> {
        let (x, y) = (slice(&x)?, slice(&y)?);
        let heights: Vec<f64> = apart(py, || {
            let above = x.iter().zip(y).map(|(&x, &y)| self.0.top(x, y));
            above
                .map(|hit| hit.map_or(f64::NAN, |hit| hit.distance))
                .collect()
        });
        Ok(heights.into_pyarray(py))
    }
}

/// The potential contact of two surfaces, the error of their facets [m] at each cell, and
/// whether its gap is the distance of the nearest point.
#[pyfunction]
#[pyo3(signature = (lower, upper, *, x, y, spacing, reach, approach))]
#[allow(clippy::too_many_arguments)] // reason: keyword-only
pub(crate) fn surface_gap<'py>(
    py: Python<'py>,
    lower: &PyBodySurface,
    upper: &PyBodySurface,
    x: [f64; 2],
    y: [f64; 2],
    spacing: [f64; 2],
    reach: f64,
    approach: Option<f64>,
) -> PyResult<(PyContactGrid, Values<'py>, Bound<'py, PyArray1<bool>>)> {
    let pair = SurfacePair {
        lower: lower.0.as_ref(),
        upper: upper.0.as_ref(),
        reach,
    };
    let gap = enter(py, |monitor| {
        pair.grid(x, y, spacing, approach, &|| look(monitor))
    })?;
    Ok((
        PyContactGrid::new(py, gap.grid)?,
        gap.facet_errors.into_pyarray(py),
        gap.nearest.into_pyarray(py),
    ))
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Wheels on rails in a simulation.

use std::slice::from_ref;
use std::sync::{Mutex, PoisonError};

use mtb_contact::friction::{Friction, SlipLaw};
use mtb_elasticity::half_space::Pair;
use mtb_geometry::WheelOnRail;
use mtb_heat::Conductor;
use mtb_wheelset::{
    Accuracy, Alignment, AxleLoad, Found, PatchChange, PatchHistory, PatchRatio, PreparedWheels,
    RailDeviation, RailFriction, RailSprings, Side, Sides, StepInput, Velocity, WheelChange,
    WheelDeviation, WheelFriction, WheelInput, WheelState, WheelStep, WheelTangent, Wheelset,
};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::{bad_input, enter};
use crate::geometry::{PyProfile, PySlices};
use crate::in_rows::InRows;
use crate::tangential::{Elastic, PyFriction, material};

pyo3::create_exception!(
    _mtb_rs,
    NotConverged,
    pyo3::exceptions::PyException,
    "No solution was found."
);

/// Prepared wheels with the memory of their last step.
#[pyclass(frozen, name = "PreparedWheels", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyPreparedWheels {
    wheels: Mutex<PreparedWheels>,
    /// One without memory: what is asked of it waits for no step.
    fresh: PreparedWheels,
}

impl PyPreparedWheels {
    fn of(fresh: PreparedWheels) -> Self {
        Self {
            wheels: Mutex::new(fresh.clone()),
            fresh,
        }
    }
}

/// Position of the frame [m], slope of its plane [rad], pressure and coefficient of friction (ny, nx), creepages.
type History<'py> = (
    [f64; 3],
    f64,
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray2<'py, f64>,
    Option<[f64; 3]>,
);

/// Overlaps; of each patch side, first grid lines and traction over pressure (2, ny, nx); its history; what else was
/// found: y, creepage, displacement (y, z) of the left and of the right rail.
type State<'py> = (
    Vec<f64>,
    Vec<(String, (i64, i64), PyReadonlyArray3<'py, f64>)>,
    Vec<Option<History<'py>>>,
    Option<Vec<f64>>,
);

/// Of friction its name, names and shapes of what it is given by, and what bodies conduct heat.
type FrictionOut = (
    &'static str,
    Vec<(String, Vec<usize>)>,
    Option<[(f64, f64, f64); 2]>,
);

/// The right wheel and its rail, the radius [m], slices of both.
type RightPair<'py> = (
    PyRef<'py, PyProfile>,
    PyRef<'py, PyProfile>,
    f64,
    Option<PyRef<'py, PySlices>>,
    Option<PyRef<'py, PySlices>>,
);

/// Curvature of the track; place and rate of the left and of the right rail, and of the wheels.
type AlignmentIn = (f64, [[[f64; 3]; 2]; 2], [[[f64; 6]; 2]; 2]);

fn alignment((curvature, rails, wheels): AlignmentIn) -> Alignment {
    Alignment {
        curvature,
        rails: rails.map(|[place, rate]| RailDeviation { place, rate }),
        wheels: wheels.map(|[place, rate]| WheelDeviation { place, rate }),
    }
}

/// A law, or coefficients over the rail: places along the track, places across the rail, flat coefficients.
#[derive(FromPyObject)]
enum OnRail<'py> {
    Law(PyRef<'py, PyFriction>),
    Map(Vec<f64>, Vec<f64>, Vec<f64>),
}

impl OnRail<'_> {
    fn law(self) -> Result<WheelFriction, mtb_wheelset::Error> {
        Ok(match self {
            Self::Law(law) => law.0.clone().into(),
            Self::Map(x, position, coefficient) => {
                WheelFriction::OnRail(RailFriction::new(x, position, coefficient)?)
            }
        })
    }
}

fn sides_named(name: &str) -> PyResult<Sides> {
    match name {
        "left" => Ok(Sides::Left),
        "right" => Ok(Sides::Right),
        "both" => Ok(Sides::Both),
        _ => Err(PyValueError::new_err(format!(
            "side is {name:?}: left, right or both is needed"
        ))),
    }
}

fn state_of((depth, patches, histories, found): State<'_>) -> PyResult<WheelState> {
    let mut histories = histories.into_iter();
    let patches: PyResult<Vec<PatchRatio>> = patches
        .into_iter()
        .map(|(side, first, ratio)| {
            let side = match sides_named(&side)? {
                Sides::Left => Side::Left,
                _ => Side::Right,
            };
            Ok(PatchRatio {
                side,
                first: [first.0, first.1],
                ny: ratio.shape()[1],
                nx: ratio.shape()[2],
                ratio: ratio.as_array().iter().copied().collect(),
                history: histories.next().flatten().map(
                    |(position, angle, pressure, coefficient, creepage)| PatchHistory {
                        position,
                        angle,
                        pressure: pressure.as_array().iter().copied().collect(),
                        coefficient: coefficient.as_array().iter().copied().collect(),
                        creepage,
                    },
                ),
            })
        })
        .collect();
    Ok(WheelState {
        depth,
        found: (found
            .map(|numbers| Found::from_numbers(&numbers))
            .transpose())
        .map_err(|e| bad_input(&e))?,
        patches: patches?,
    })
}

#[pymethods]
impl PyPreparedWheels {
    /// `side`: "left", "right" or "both"; `lower`, `upper`: shear modulus [Pa] and Poisson's ratio, None for
    /// rigid; `layer`: thickness over shear modulus [m/Pa]; `approach`: vertical, where a search begins [m];
    /// `reference_point` None: the middle of the axle; `springs`: lateral and vertical stiffness of the rails [N/m], and
    /// the force on them beside that of the wheels, outwards and upwards [N]; `right`: wheel, rail, radius [m] and slices
    /// of both on the right, where they differ, seen in a mirror, and `right_friction` likewise; `conformal`: whether
    /// patches follow the rail; `second_order`: whether slip is of second order.
    #[new]
    #[pyo3(signature = (
        wheel, rail, *, wheel_radius, roller_radius, gauge, gauge_depth, rail_inclination, flange_back, tape_circle, lateral,
        first_height, side, force, approach, spacing, lower, upper, friction, layer, reference_point,
        standstill_speed, springs, wheel_slices, rail_slices, right, right_friction, conformal, second_order
    ))]
    #[allow(clippy::too_many_arguments, reason = "keyword-only")]
    fn new(
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
        first_height: f64,
        side: &str,
        force: f64,
        approach: f64,
        spacing: [f64; 2],
        lower: Elastic,
        upper: Elastic,
        friction: OnRail<'_>,
        layer: f64,
        reference_point: Option<[f64; 3]>,
        standstill_speed: Option<f64>,
        springs: Option<[[f64; 2]; 2]>,
        wheel_slices: Option<PyRef<'_, PySlices>>,
        rail_slices: Option<PyRef<'_, PySlices>>,
        right: Option<RightPair<'_>>,
        right_friction: Option<OnRail<'_>>,
        conformal: bool,
        second_order: bool,
    ) -> PyResult<Self> {
        let slices = |given: Option<PyRef<'_, PySlices>>| given.map(|given| given.slices.clone());
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
            wheel_slices: slices(wheel_slices),
            rail_slices: slices(rail_slices),
        };
        let right = right.map(|told| {
            let (wheel, rail, wheel_radius, wheel_slices, rail_slices) = told;
            WheelOnRail {
                wheel: wheel.0.clone(),
                rail: rail.0.clone(),
                wheel_radius,
                wheel_slices: slices(wheel_slices),
                rail_slices: slices(rail_slices),
                lateral: -lateral,
                ..pair.clone()
            }
        });
        let wheelset = Wheelset {
            pair,
            right,
            sides: sides_named(side)?,
            force,
            approach,
            spacing,
            bodies: Pair {
                lower: material(lower).map_err(|e| bad_input(&e))?,
                upper: material(upper).map_err(|e| bad_input(&e))?,
            },
            friction: friction.law().map_err(|e| bad_input(&e))?,
            right_friction: (right_friction.map(OnRail::law).transpose())
                .map_err(|e| bad_input(&e))?,
            layer,
            reference_point: reference_point.unwrap_or([0.0, lateral, wheel_radius + first_height]),
            standstill_speed,
            springs: springs.map(|[stiffness, force]| RailSprings { stiffness, force }),
            conformal,
            second_order,
        };
        Ok(Self::of(enter(py, |_| PreparedWheels::new(wheelset))?))
    }

    /// The wheels that `to_bytes` wrote.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, data: &[u8]) -> PyResult<Self> {
        let read = |_: mtb_operator::Monitor<'_>| PreparedWheels::new(Wheelset::from_bytes(data)?);
        Ok(Self::of(enter(py, read)?))
    }

    /// The wheels as bytes, checksum included; without the memory of steps.
    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.fresh.wheelset().to_bytes())
    }

    /// The same wheels without memory.
    fn copy(&self) -> Self {
        Self::of(self.fresh.without_memory())
    }

    /// The same wheels without memory; relative residuals of pressures and tractions, and relative error of a
    /// vertical force that the height is found for.
    fn to_accuracy(&self, normal: f64, tangential: f64, force: f64) -> PyResult<Self> {
        let accuracy = Accuracy {
            normal,
            tangential,
            force,
        };
        let fresh = self.fresh.to_accuracy(accuracy);
        Ok(Self::of(fresh.map_err(|e| bad_input(&e))?))
    }

    /// "left", "right", or both.
    #[getter]
    fn sides(&self) -> Vec<String> {
        let each = self.fresh.wheelset().sides.each().iter();
        each.map(Side::to_string).collect()
    }

    /// Distance of the tape circle from the back of the flange [m].
    #[getter]
    fn tape_circle(&self) -> f64 {
        self.fresh.wheelset().pair.tape_circle
    }

    /// Vertical force of each wheel [N].
    #[getter]
    fn force(&self) -> f64 {
        self.fresh.wheelset().force
    }

    /// Young's moduli [Pa] of the bodies that deform.
    #[getter]
    fn young_moduli(&self) -> Vec<f64> {
        let bodies = &self.fresh.wheelset().bodies;
        let elastic = bodies.lower.into_iter().chain(bodies.upper);
        elastic.map(|material| material.young_modulus()).collect()
    }

    /// Whether patches follow the rail.
    #[getter]
    fn conformal(&self) -> bool {
        self.fresh.wheelset().conformal
    }

    /// Whether patches may follow the rail.
    #[getter]
    fn may_be_conformal(&self) -> bool {
        let wheelset = self.fresh.wheelset();
        let mut sides = wheelset.sides.each().iter();
        let has_slices = sides.any(|side| wheelset.pair_of(*side).has_slices());
        !has_slices && wheelset.pair.roller_radius.is_none() && !wheelset.bodies.is_coupled()
    }

    /// Whether the rails stand on springs.
    #[getter]
    fn has_springs(&self) -> bool {
        self.fresh.wheelset().springs.is_some()
    }

    /// Shear modulus [Pa] and Poisson's ratio of rail and wheel; none of a rigid one.
    #[getter]
    fn materials(&self) -> [Option<(f64, f64)>; 2] {
        let bodies = &self.fresh.wheelset().bodies;
        [bodies.lower, bodies.upper]
            .map(|body| body.map(|material| (material.shear_modulus, material.poisson_ratio)))
    }

    /// Friction of these wheels: "friction", and "right_friction" where the right one has its own; names and shapes of what
    /// each is given by; conductivity [W/(m K)], density [kg/m3] and specific heat [J/(kg K)] of rail and wheel where it
    /// follows their temperature.
    #[getter]
    fn frictions(&self) -> Vec<FrictionOut> {
        let wheelset = self.fresh.wheelset();
        let own = wheelset.right_friction.as_ref();
        let laws = [
            ("friction", Some(&wheelset.friction)),
            ("right_friction", own),
        ];
        let is_used = |law: &WheelFriction| {
            let mut sides = wheelset.sides.each().iter();
            sides.any(|side| std::ptr::eq(wheelset.friction_of(*side), law))
        };
        (laws.into_iter())
            .filter_map(|(name, law)| Some((name, law.filter(|law| is_used(law))?)))
            .map(|(name, law)| (name, friction_inputs(law), conductors(law)))
            .collect()
    }

    /// The point poses, velocities and moments are about [m].
    #[getter]
    fn reference_point(&self) -> [f64; 3] {
        self.fresh.wheelset().reference_point
    }

    /// The memory, as `step` takes it.
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let wheels = self.wheels.lock().unwrap_or_else(PoisonError::into_inner);
        let state = wheels.state().clone();
        drop(wheels);
        state_out(py, state)
    }

    /// Takes a state for the memory.
    fn resume(&self, state: State<'_>) -> PyResult<()> {
        let state = state_of(state)?;
        let mut wheels = self.wheels.lock().unwrap_or_else(PoisonError::into_inner);
        wheels.resume(state).map_err(|error| bad_input(&error))
    }

    /// Solves one step; `velocity`: one number for rolling, or six; `state` in place of the memory; `duration` [s] of
    /// transient rolling; `lateral_force` [N] with y NaN; `axle_load`: whether it is a force along x, or a moment about the
    /// axle, and its size. `NotConverged` where no solution was found.
    #[pyo3(signature = (
        pose, velocity, state=None, duration=None, lateral_force=None, axle_load=None, alignment=None
    ))]
    #[allow(
        clippy::too_many_arguments,
        clippy::large_types_passed_by_value,
        reason = "one step, whose arguments PyO3 hands over by value"
    )]
    fn step<'py>(
        &self,
        py: Python<'py>,
        pose: [f64; 6],
        velocity: PyReadonlyArray1<'py, f64>,
        state: Option<State<'py>>,
        duration: Option<f64>,
        lateral_force: Option<f64>,
        axle_load: Option<(bool, f64)>,
        alignment: Option<AlignmentIn>,
    ) -> PyResult<PyWheelOutcome> {
        let state = state.map(state_of).transpose()?;
        let loads = (lateral_force, axle_load);
        let input = StepInput {
            duration,
            alignment: alignment.map(self::alignment).unwrap_or_default(),
            ..step_input(pose, velocity.in_rows()?, loads)?
        };
        let solved = enter(py, |monitor| {
            let mut wheels = self.wheels.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(state) = state {
                wheels.resume(state)?;
            }
            match wheels.step_of(&input, monitor) {
                Err(error) if error.is_not_converged() => Ok(Err(error.to_string())),
                Err(error) => Err(error),
                Ok(step) => Ok(Ok(step)),
            }
        })?;
        match solved {
            Ok(step) => PyWheelOutcome::of(py, step, self.fresh.wheelset().sides),
            Err(failure) => Err(NotConverged::new_err(failure)),
        }
    }

    /// Refuses what `step` refuses by its numbers alone.
    #[expect(
        clippy::large_types_passed_by_value,
        reason = "PyO3 hands arguments over by value"
    )]
    fn check(
        &self,
        pose: [f64; 6],
        velocity: PyReadonlyArray1<'_, f64>,
        lateral_force: Option<f64>,
        axle_load: Option<(bool, f64)>,
        alignment: Option<AlignmentIn>,
    ) -> PyResult<()> {
        let loads = (lateral_force, axle_load);
        let input = StepInput {
            alignment: alignment.map(self::alignment).unwrap_or_default(),
            ..step_input(pose, velocity.in_rows()?, loads)?
        };
        self.fresh.check(&input).map_err(|error| bad_input(&error))
    }
}

fn step_input(
    pose: [f64; 6],
    velocity: &[f64],
    (lateral_force, axle_load): (Option<f64>, Option<(bool, f64)>),
) -> PyResult<StepInput> {
    let velocity = match *velocity {
        [speed] => Velocity::Rolling(speed),
        [vx, vy, vz, wx, wy, wz] => Velocity::Rigid([vx, vy, vz, wx, wy, wz]),
        _ => {
            return Err(PyValueError::new_err(
                "velocity has one number, or six, that are needed",
            ));
        }
    };
    Ok(StepInput {
        lateral_force,
        axle_load: axle_load.map(|(is_force, size)| {
            if is_force {
                AxleLoad::LongitudinalForce(size)
            } else {
                AxleLoad::Moment(size)
            }
        }),
        ..StepInput::new(pose, velocity)
    })
}

/// A step of the wheels.
#[pyclass(frozen, get_all, name = "WheelOutcome", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyWheelOutcome {
    tangent: Py<PyWheelTangent>,
    force: Py<PyArray1<f64>>,
    moment: Py<PyArray1<f64>>,
    reference_point: Py<PyArray1<f64>>,
    pose: Py<PyArray1<f64>>,
    velocity: Py<PyArray1<f64>>,
    /// Side and displacement along y and z [m] of each rail.
    rail_displacement: Vec<(String, Py<PyArray1<f64>>)>,
    /// Side and force [N] of each wheel.
    vertical_force: Vec<(String, f64)>,
    balance_error: Option<f64>,
    friction_power: f64,
    normal_solves: usize,
    iterations: usize,
    /// As `step` takes it.
    state: Py<PyAny>,
    patches: Vec<Py<PyWheelPatch>>,
}

/// The derivatives of a step.
#[pyclass(frozen, name = "WheelTangent", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyWheelTangent {
    tangent: WheelTangent,
    sides: &'static [Side],
}

#[pymethods]
impl PyWheelTangent {
    /// Changes of the step by a unit of each number of an input, by name: "pose",
    /// "velocity", "friction", "right_friction", "force", "lateral_force", "axle_load", "alignment", "springs", "layer",
    /// "moduli" or "duration".
    fn derivatives(&self, py: Python<'_>, by: &str) -> PyResult<Vec<PyWheelChange>> {
        let by = match by {
            "pose" => WheelInput::Pose,
            "velocity" => WheelInput::Velocity,
            "friction" => WheelInput::Friction,
            "right_friction" => WheelInput::RightFriction,
            "force" => WheelInput::Force,
            "lateral_force" => WheelInput::LateralForce,
            "axle_load" => WheelInput::AxleLoad,
            "alignment" => WheelInput::Alignment,
            "springs" => WheelInput::Springs,
            "layer" => WheelInput::Layer,
            "moduli" => WheelInput::Moduli,
            "duration" => WheelInput::Duration,
            _ => {
                return Err(PyValueError::new_err(format!(
                    "by is {by:?}: pose, velocity, friction, right_friction, force, lateral_force, axle_load, \
                     alignment, springs, layer, moduli or duration is needed"
                )));
            }
        };
        let found = enter(py, |monitor| self.tangent.derivatives(by, monitor))?;
        Ok(self.told(found))
    }

    /// Changes of the step by those of the step before it.
    fn after(
        &self,
        py: Python<'_>,
        before: &Self,
        changes: Vec<PyRef<'_, PyWheelChange>>,
    ) -> PyResult<Vec<PyWheelChange>> {
        let changes: Vec<WheelChange> = changes.iter().map(|known| known.change.clone()).collect();
        let found = enter(py, |monitor| {
            self.tangent.after(&before.tangent, &changes, monitor)
        })?;
        Ok(self.told(found))
    }

    /// Whether it has rolled on from the state that another step has left, or is steady.
    fn follows(&self, before: &Self) -> bool {
        self.tangent.follows(&before.tangent)
    }

    /// Of points that are about to part, to touch, to slip and to stick.
    fn margin(&self) -> [f64; 4] {
        let margin = self.tangent.margin();
        [
            margin.parting,
            margin.touching,
            margin.slipping,
            margin.sticking,
        ]
    }
}

impl PyWheelTangent {
    fn told(&self, changes: Vec<WheelChange>) -> Vec<PyWheelChange> {
        let sides = self.sides;
        let told = |change| PyWheelChange { change, sides };
        changes.into_iter().map(told).collect()
    }
}

/// A change of a step.
#[pyclass(frozen, name = "WheelChange", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyWheelChange {
    change: WheelChange,
    sides: &'static [Side],
}

#[pymethods]
impl PyWheelChange {
    /// Change of a number or field, by name. Those of patches are stacked, their fields side by side.
    fn field<'py>(&self, py: Python<'py>, of: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let Self { change, sides } = self;
        let index = |side: &Side| usize::from(*side == Side::Right);
        let values: Vec<f64> = match of {
            "force" => change.force.to_vec(),
            "moment" => change.moment.to_vec(),
            "vertical_force" => (sides.iter())
                .map(|side| change.vertical_force[index(side)])
                .collect(),
            "pose" => change.pose.to_vec(),
            "velocity" => change.velocity.to_vec(),
            "rail_displacement" => (sides.iter())
                .flat_map(|side| change.rail_displacement[index(side)])
                .collect(),
            "friction_power" => vec![change.friction_power],
            "position" => self.stacked(|p| &p.position),
            "contact_angle" => self.stacked(|p| from_ref(&p.contact_angle)),
            "rail_position" => self.stacked(|p| from_ref(&p.rail_position)),
            "wheel_position" => self.stacked(|p| from_ref(&p.wheel_position)),
            "approach" => self.stacked(|p| from_ref(&p.approach)),
            "creepage" => self.stacked(|p| &p.creepage),
            "rolling_speed" => self.stacked(|p| from_ref(&p.rolling_speed)),
            "patch_force" => self.stacked(|p| &p.force),
            "patch_friction_power" => self.stacked(|p| from_ref(&p.friction_power)),
            "pressure" => self.stacked(|p| &p.pressure),
            "traction" => self.vectors(|p| &p.traction),
            "slip_velocity" => self.vectors(|p| &p.slip_velocity),
            _ => {
                return Err(PyValueError::new_err(format!(
                    "of is {of:?}: a number or field of the step is needed"
                )));
            }
        };
        Ok(values.into_pyarray(py))
    }
}

impl PyWheelChange {
    /// Numbers of all patches in a row.
    fn stacked(&self, of: fn(&PatchChange) -> &[f64]) -> Vec<f64> {
        let patches = self.change.patches.iter();
        patches.flat_map(of).copied().collect()
    }

    /// Vectors at the points of all patches in a row, one component after the other.
    fn vectors(&self, of: fn(&PatchChange) -> &[f64]) -> Vec<f64> {
        let half = |patch: &PatchChange, c: usize| {
            let n = patch.pressure.len();
            of(patch)[c * n..(c + 1) * n].to_vec()
        };
        let components = (0..2).flat_map(|c| self.change.patches.iter().map(move |p| (p, c)));
        components.flat_map(|(patch, c)| half(patch, c)).collect()
    }
}

/// Conductivity [W/(m K)], density [kg/m3] and specific heat [J/(kg K)] of rail and wheel whose temperature friction
/// follows.
fn conductors(friction: &WheelFriction) -> Option<[(f64, f64, f64); 2]> {
    match friction {
        WheelFriction::Everywhere(Friction::TemperatureDependent(law)) => {
            let constants =
                |body: Conductor| (body.conductivity(), body.density(), body.specific_heat());
            Some(law.bodies.map(constants))
        }
        _ => None,
    }
}

/// What friction is given by: names (none where it is one field), and shapes. What bodies are made of counts by their effusivities alone.
fn friction_inputs(friction: &WheelFriction) -> Vec<(String, Vec<usize>)> {
    let single = |name: &str| (name.into(), Vec::new());
    match friction {
        WheelFriction::OnRail(map) => {
            let [x, y, _] = map.parts().map(<[f64]>::len);
            let shape = if x == 1 { vec![y] } else { vec![x, y] };
            vec![(String::new(), shape)]
        }
        WheelFriction::Everywhere(Friction::TemperatureDependent(law)) => {
            let points = law.table()[0].len();
            let mut names = vec![
                ("coefficient".into(), vec![points]),
                ("temperature".into(), vec![points]),
                ("bulk".into(), vec![2]),
                ("effusivity".into(), vec![2]),
            ];
            if law.memory.is_some() {
                names.extend(["memory", "memory_min_slip"].map(single));
            }
            names
        }
        WheelFriction::Everywhere(Friction::Coulomb(_)) => vec![(String::new(), Vec::new())],
        WheelFriction::Everywhere(Friction::StaticKinetic { .. }) => {
            ["static", "kinetic"].map(single).into()
        }
        WheelFriction::Everywhere(Friction::SpeedDependent { law, memory }) => {
            let mut names: Vec<(String, Vec<usize>)> = match law {
                SlipLaw::Exponential { .. } => {
                    ["static", "kinetic", "half_slip"].map(single).into()
                }
                SlipLaw::Table { slip_speed, .. } => ["coefficient", "slip_speed"]
                    .map(|name| (name.into(), vec![slip_speed.len()]))
                    .into(),
            };
            if memory.is_some() {
                names.extend(["memory", "memory_min_slip"].map(single));
            }
            names
        }
    }
}

/// A contact patch of a step; fields (ny, nx) and (2, ny, nx) in its own frame.
#[pyclass(frozen, get_all, name = "WheelPatch", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyWheelPatch {
    side: String,
    position: Py<PyArray1<f64>>,
    rotation: Py<PyArray2<f64>>,
    contact_angle: f64,
    rail_position: f64,
    wheel_position: f64,
    x: Py<PyArray1<f64>>,
    y: Py<PyArray1<f64>>,
    /// y and z of each row in the track (2, ny), and its inclination (ny), where the patch follows the rail.
    row_position: Option<Py<PyArray2<f64>>>,
    inclination: Option<Py<PyArray1<f64>>>,
    /// Its creepages (3, ny), likewise.
    row_creepage: Option<Py<PyArray2<f64>>>,
    pressure: Py<PyArray2<f64>>,
    traction: Py<PyArray3<f64>>,
    slip_velocity: Py<PyArray3<f64>>,
    dissipation: Py<PyArray2<f64>>,
    /// 0 open, 1 stick, 2 slip.
    status: Py<PyArray2<i8>>,
    approach: f64,
    creepage: Py<PyArray1<f64>>,
    rolling_speed: f64,
    normal_force: f64,
    neglected: f64,
    friction_power: f64,
}

impl PyWheelOutcome {
    fn of(py: Python<'_>, step: WheelStep, sides: Sides) -> PyResult<Self> {
        let array = |values: &[f64]| values.to_vec().into_pyarray(py).unbind();
        let carried = [Side::Left, Side::Right]
            .into_iter()
            .zip(step.vertical_force);
        let patches = step.patches.into_iter();
        let tangent = PyWheelTangent {
            tangent: step.tangent,
            sides: sides.each(),
        };
        Ok(Self {
            tangent: Py::new(py, tangent)?,
            force: array(&step.force),
            moment: array(&step.moment),
            reference_point: array(&step.reference_point),
            pose: array(&step.pose),
            velocity: array(&step.velocity),
            rail_displacement: [Side::Left, Side::Right]
                .into_iter()
                .zip(&step.rail_displacement)
                .filter(|(side, _)| sides.each().contains(side))
                .map(|(side, moved)| (side.to_string(), array(moved)))
                .collect(),
            vertical_force: carried
                .filter(|(side, _)| sides.each().contains(side))
                .map(|(side, force)| (side.to_string(), force))
                .collect(),
            balance_error: step.balance_error,
            friction_power: step.friction_power,
            normal_solves: step.normal_solves,
            iterations: step.iterations,
            state: state_out(py, step.state)?.unbind(),
            patches: patches
                .map(|patch| Py::new(py, PyWheelPatch::of(py, patch)?))
                .collect::<PyResult<_>>()?,
        })
    }
}

impl PyWheelPatch {
    fn of(py: Python<'_>, patch: mtb_wheelset::WheelPatch) -> PyResult<Self> {
        let (nx, ny) = (patch.grid.nx, patch.grid.ny);
        let column = |k: usize| patch.place(k)[0];
        let row = |k: usize| patch.place(k * nx)[1];
        let x: Vec<f64> = (0..nx).map(column).collect();
        let y: Vec<f64> = (0..ny).map(row).collect();
        let rows = (!patch.rows.is_empty()).then_some(&patch.rows);
        let row_position = rows.map(|rows| {
            let place = |c: usize| rows.iter().map(move |row| row.position[c]);
            let places: Vec<f64> = place(1).chain(place(2)).collect();
            places.into_pyarray(py).reshape([2, ny])
        });
        let row_creepage = rows.map(|rows| {
            let each = (0..3).flat_map(|c| rows.iter().map(move |row| row.creepage[c]));
            each.collect::<Vec<_>>().into_pyarray(py).reshape([3, ny])
        });
        let inclination =
            rows.map(|rows| -> Vec<f64> { rows.iter().map(|row| row.inclination).collect() });
        let field = |values: Vec<f64>| -> PyResult<Py<PyArray2<f64>>> {
            Ok(values.into_pyarray(py).reshape([ny, nx])?.unbind())
        };
        let vector = |values: Vec<f64>| -> PyResult<Py<PyArray3<f64>>> {
            Ok(values.into_pyarray(py).reshape([2, ny, nx])?.unbind())
        };
        let rotation = patch.rotation.concat().into_pyarray(py);
        let status: Vec<i8> = patch.status.iter().map(|s| *s as i8).collect();
        let status = status.into_pyarray(py);
        Ok(Self {
            side: patch.side.to_string(),
            position: patch.position.to_vec().into_pyarray(py).unbind(),
            rotation: rotation.reshape([3, 3])?.unbind(),
            contact_angle: patch.contact_angle,
            rail_position: patch.rail_position,
            wheel_position: patch.wheel_position,
            x: x.into_pyarray(py).unbind(),
            y: y.into_pyarray(py).unbind(),
            row_position: row_position.transpose()?.map(Bound::unbind),
            row_creepage: row_creepage.transpose()?.map(Bound::unbind),
            inclination: inclination.map(|angles| angles.into_pyarray(py).unbind()),
            pressure: field(patch.pressure)?,
            traction: vector(patch.traction)?,
            slip_velocity: vector(patch.slip_velocity)?,
            dissipation: field(patch.dissipation)?,
            status: status.reshape([ny, nx])?.unbind(),
            approach: patch.approach,
            creepage: patch.creepage.to_vec().into_pyarray(py).unbind(),
            rolling_speed: patch.rolling_speed,
            normal_force: patch.normal_force,
            neglected: patch.neglected,
            friction_power: patch.friction_power,
        })
    }
}

fn state_out(py: Python<'_>, state: WheelState) -> PyResult<Bound<'_, PyAny>> {
    let mut histories = Vec::new();
    let ratios: PyResult<Vec<_>> = state
        .patches
        .into_iter()
        .map(|patch| {
            let ratio = patch.ratio.into_pyarray(py);
            let ratio = ratio.reshape([2, patch.ny, patch.nx])?;
            let field = |values: Vec<f64>| values.into_pyarray(py).reshape([patch.ny, patch.nx]);
            let history = match patch.history {
                Some(history) => Some((
                    history.position.to_vec(),
                    history.angle,
                    field(history.pressure)?,
                    field(history.coefficient)?,
                    history.creepage.map(|creepage| creepage.to_vec()),
                )),
                None => None,
            };
            histories.push(history);
            Ok((
                patch.side.to_string(),
                (patch.first[0], patch.first[1]),
                ratio,
            ))
        })
        .collect();
    let found = state.found.map(|found| found.to_numbers());
    (state.depth, ratios?, histories, found)
        .into_pyobject(py)
        .map(Bound::into_any)
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stick and slip, and the fast approximations.

use mtb_complementarity::discs::DiscState;
use mtb_contact::fastrip::{self, StripTheory};
use mtb_contact::fastsim::{
    self, Flexibilities, FoundationProblem, FoundationSolution, Order, SlopeReduction, gradient,
};
use mtb_contact::friction::{Friction, Memory, SlipLaw};
use mtb_contact::kalker::creep_coefficients;
use mtb_contact::polach::{PolachContact, creep_force};
use mtb_contact::tangential::{
    Bodies, Drive, Earlier, Motion, PatchOperators, Plasticity, PlasticityChange, Surroundings,
    TangentialChange, TangentialProblem, TangentialResponse, TangentialSolution, TangentialState,
    TangentialTangent, dissipation, solve,
};
use mtb_contact::temperature::TemperatureLaw;
use mtb_contact::{Error, Inclination, RowInfluence};
use mtb_elasticity::Material;
use mtb_elasticity::half_space::{LinePair, TangentialPair};
use mtb_operator::{Grid, Monitor, report};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::elasticity::MediumArgument;
use crate::error::{bad_input, enter};
use crate::heat::{Constants, conductor};
use crate::in_rows::InRows;
use crate::prism::PyPrismPair;

/// A friction law.
#[pyclass(frozen, name = "Friction", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyFriction(pub(crate) Friction);

#[pymethods]
impl PyFriction {
    /// One fixed coefficient per point, flat.
    #[staticmethod]
    fn coulomb(coefficient: PyReadonlyArray1<'_, f64>) -> PyResult<Self> {
        Ok(Self(Friction::Coulomb(coefficient.to_vec()?)))
    }

    /// One coefficient for points that stick, another for points that slip.
    #[staticmethod]
    fn static_kinetic(at_rest: f64, kinetic: f64) -> Self {
        Self(Friction::StaticKinetic { at_rest, kinetic })
    }

    /// Exponential fall with the slip speed; `memory`: distance [m], slip speed [m/s].
    #[staticmethod]
    fn exponential(at_rest: f64, kinetic: f64, half_slip: f64, memory: Option<(f64, f64)>) -> Self {
        let law = SlipLaw::Exponential {
            at_rest,
            kinetic,
            half_slip,
        };
        Self::speed_dependent(law, memory)
    }

    /// Piecewise linear in the slip speed [m/s]; `memory`: distance [m], slip speed [m/s].
    #[staticmethod]
    fn table(
        slip_speed: PyReadonlyArray1<'_, f64>,
        coefficient: PyReadonlyArray1<'_, f64>,
        memory: Option<(f64, f64)>,
    ) -> PyResult<Self> {
        let law = SlipLaw::Table {
            slip_speed: slip_speed.to_vec()?,
            coefficient: coefficient.to_vec()?,
        };
        Ok(Self::speed_dependent(law, memory))
    }

    /// Piecewise linear in the temperature [K] of the surfaces; `bodies`: conductivity, density and specific heat of
    /// the lower and the upper one, `bulk` [K] of both; `memory`: distance [m], slip speed [m/s].
    #[staticmethod]
    fn of_temperature(
        temperature: PyReadonlyArray1<'_, f64>,
        coefficient: PyReadonlyArray1<'_, f64>,
        bodies: [Constants; 2],
        bulk: [f64; 2],
        memory: Option<(f64, f64)>,
    ) -> PyResult<Self> {
        let [lower, upper] = bodies;
        let law = TemperatureLaw::new(
            temperature.to_vec()?,
            coefficient.to_vec()?,
            [conductor(lower)?, conductor(upper)?],
            bulk,
            memory.map(memory_of),
        );
        let law = law.map_err(|error| bad_input(&error))?;
        Ok(Self(Friction::TemperatureDependent(law)))
    }
}

/// Inclination [rad] at a place y [m] from that of a row at `first` [m], with linear ones between the rows.
pub(crate) fn along_rows(angles: &[f64], first: f64, dy: f64) -> impl Fn(f64) -> f64 + Sync {
    move |y| {
        let last = angles.len() as f64 - 1.0;
        let at = ((y - first) / dy).clamp(0.0, last);
        let (below, part) = (at.floor(), at - at.floor());
        let next = (below + 1.0).min(last);
        angles[below as usize] * (1.0 - part) + angles[next as usize] * part
    }
}

fn memory_of((distance, min_slip): (f64, f64)) -> Memory {
    Memory { distance, min_slip }
}

impl PyFriction {
    fn speed_dependent(law: SlipLaw, memory: Option<(f64, f64)>) -> Self {
        let memory = memory.map(memory_of);
        Self(Friction::SpeedDependent { law, memory })
    }
}

/// The operators of a patch of cells for one kind of motion.
#[pyclass(frozen, name = "PatchOperators", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyPatchOperators(PatchOperators);

/// Shear modulus [Pa] and Poisson's ratio; `None` for rigid.
pub(crate) type Elastic = Option<(f64, f64)>;

pub(crate) fn material(body: Elastic) -> Result<Option<Material>, mtb_elasticity::Error> {
    body.map(|(g, nu)| Material::new(g, nu)).transpose()
}

#[pymethods]
impl PyPatchOperators {
    /// `shape`: (nx, ny); `spacing`: (dx, dy) [m]; `lower`, `upper`: (shear modulus [Pa], Poisson's
    /// ratio), a `Layered` or one that creeps, None for rigid; `layer`: thickness over shear modulus [m/Pa]; `motion`: "shift",
    /// "transient" or "steady"; `step`: (x, y) [m]; `reference`: distance [m] at which the displacement
    /// of a line contact vanishes, None for a patch; `softens`: whether a layer that softens is to be solved with;
    /// `inclination`: of each row of cells [rad], None for a plane surface; `prisms`: prisms and the first of their
    /// rows; `is_second_order`: whether slip is of second order in the cells.
    #[new]
    #[pyo3(signature = (
        shape, spacing, lower, upper, layer, motion, step, reference, softens=false, inclination=None,
        prisms=None, is_second_order=false
    ))]
    #[allow(clippy::too_many_arguments, reason = "one call per set of operators")]
    fn new(
        py: Python<'_>,
        shape: (usize, usize),
        spacing: (f64, f64),
        lower: Option<MediumArgument>,
        upper: Option<MediumArgument>,
        layer: f64,
        motion: &str,
        step: (f64, f64),
        reference: Option<f64>,
        softens: bool,
        inclination: Option<Vec<f64>>,
        prisms: Option<(PyRef<'_, PyPrismPair>, usize)>,
        is_second_order: bool,
    ) -> PyResult<Self> {
        let step = [step.0, step.1];
        let motion = match motion {
            "shift" => Motion::Shift,
            "transient" => Motion::Transient { step },
            "steady" => Motion::Steady { step },
            _ => {
                let message = format!("motion is {motion:?}: shift, transient or steady is needed");
                return Err(PyValueError::new_err(message));
            }
        };
        let medium = |body: Option<MediumArgument>| {
            let medium = body.map(|body| body.medium()).transpose();
            medium.map_err(|e| bad_input(&e))
        };
        let (lower, upper) = (medium(lower)?, medium(upper)?);
        let pair = TangentialPair::new(lower.as_ref(), upper.as_ref());
        let grid = Grid::new(shape.0, shape.1, spacing.0, spacing.1).map_err(|e| bad_input(&e))?;
        let angles = (inclination.as_deref()).map(|angles| along_rows(angles, 0.0, grid.dy));
        let prisms = prisms.map(|(pair, first)| (pair.pair.clone(), first..first + grid.ny));
        let across = prisms
            .as_ref()
            .map(|(pair, rows)| move |offsets: &[f64]| pair.influence(offsets, rows.clone()));
        enter(py, |_| -> Result<Self, Error> {
            let line = reference.map(|reference| LinePair {
                pair: pair.surfaces(),
                reference,
            });
            let of_patch = |cell, offset| pair.tangential(cell, offset);
            let pushed = |cell, offset| pair.by_pressure(cell, offset);
            let of_line = line.map(|line| move |cell, offset| line.tangential(cell, offset));
            let line_pushed = line.map(|line| move |cell, offset| line.by_pressure(cell, offset));
            let bodies = Bodies {
                tangential: match &of_line {
                    Some(line) => line,
                    None => &of_patch,
                },
                by_pressure: pair.is_coupled().then_some(match &line_pushed {
                    Some(line) => line,
                    None => &pushed,
                }),
                layer,
                is_mirrored: pair.is_mirrored(),
                across: across.as_ref().map(|across| -> RowInfluence<'_> { across }),
                inclination: angles.as_ref().map(|angle| -> Inclination<'_> { angle }),
            };
            let operators = match motion {
                Motion::Transient { step } if is_second_order => {
                    PatchOperators::new(&bodies, grid, Motion::Shift)?.rolling_by(&bodies, step)?
                }
                _ => PatchOperators::new(&bodies, grid, motion)?,
            };
            let operators = if is_second_order {
                operators.of_second_order()
            } else {
                operators
            };
            Ok(Self(match motion {
                Motion::Steady { .. } if softens => operators.with_flexibility(&bodies),
                _ => operators,
            }))
        })
    }

    /// Solves for `pressure` (ny, nx); `drive`: (value, is a force) along x and y; `earlier`: traction
    /// (2, ny, nx), pressure and coefficient of friction (ny, nx); `start`: traction (2, ny, nx) to try first;
    /// `around`: shape (nx, ny) of the grid for the dissipation, and column and row of the first cell there;
    /// `plasticity`: yield stress [Pa], hardening [Pa/m] and earlier plastic slip (ny, nx) [m] of a layer that yields;
    /// `rigid_slip`: besides drive and spin (2, ny, nx), in the unit of the slip.
    #[pyo3(signature = (
        pressure, origin, drive, spin, speed, friction, earlier, tolerance, start=None, around=None, plasticity=None,
        rigid_slip=None
    ))]
    #[allow(clippy::too_many_arguments, reason = "one call per solve")]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        pressure: PyReadonlyArray2<'py, f64>,
        origin: (f64, f64),
        drive: [(f64, bool); 2],
        spin: f64,
        speed: f64,
        friction: &PyFriction,
        earlier: Option<Past<'py>>,
        tolerance: f64,
        start: Option<PyReadonlyArray3<'py, f64>>,
        around: Option<([usize; 2], [isize; 2])>,
        plasticity: Option<(f64, f64, Option<PyReadonlyArray2<'py, f64>>)>,
        rigid_slip: Option<PyReadonlyArray3<'py, f64>>,
    ) -> PyResult<PyTangentialOutcome> {
        let shape = [pressure.shape()[0], pressure.shape()[1]];
        let earlier = earlier_of(earlier)?;
        let pressure = pressure.in_rows()?;
        let start = match &start {
            Some(traction) => Some(traction.in_rows()?),
            None => None,
        };
        let rigid_slip = match &rigid_slip {
            Some(slip) => Some(slip.in_rows()?),
            None => None,
        };
        let plasticity = match &plasticity {
            Some((yield_stress, hardening, earlier)) => Some(Plasticity {
                yield_stress: *yield_stress,
                hardening: *hardening,
                earlier: match earlier {
                    Some(slip) => slip.in_rows()?,
                    None => &[],
                },
            }),
            None => None,
        };
        let (solution, heat) = enter(py, |monitor| {
            let problem = TangentialProblem {
                around: around.map(|(shape, first)| Surroundings { shape, first }),
                pressure,
                origin: [origin.0, origin.1],
                drive: drives(drive),
                spin,
                rigid_slip,
                speed,
                friction: &friction.0,
                plasticity,
                earlier: earlier.as_ref(),
                start,
                tolerance,
            };
            let solution = solve(&self.0, &problem, monitor)?;
            let heat = around.map(|(shape, first)| {
                let around = Surroundings { shape, first };
                (shape, dissipation(&self.0, &problem, &solution, around))
            });
            Ok::<_, Error>((solution, heat))
        })?;
        let heat = match heat {
            None => None,
            Some(([nx, ny], heat)) => Some(heat.into_pyarray(py).reshape([ny, nx])?.unbind()),
        };
        PyTangentialOutcome::of(py, solution, shape, heat)
    }
}

type Field<'py> = PyReadonlyArray2<'py, f64>;
type Vectors<'py> = PyReadonlyArray3<'py, f64>;
type Numbers<'py> = PyReadonlyArray1<'py, f64>;
/// Traction, pressure and coefficient of friction of an earlier state.
type Past<'py> = (Vectors<'py>, Field<'py>, Field<'py>);
/// Traction, slip, coefficient of friction and creepage or displacement of a solution.
type Solved<'py> = (Vectors<'py>, Vectors<'py>, Field<'py>, [f64; 2]);
/// Shape of the grid around, and the first cell there.
type Around = ([usize; 2], [isize; 2]);
type OwnPast = (Py<PyArray3<f64>>, Py<PyArray2<f64>>, Py<PyArray2<f64>>);
type OwnField<'py> = Bound<'py, PyArray2<f64>>;
type OwnVectors<'py> = Bound<'py, PyArray3<f64>>;

fn earlier_of(past: Option<Past<'_>>) -> PyResult<Option<Earlier>> {
    let Some((traction, pressure, coefficient)) = past else {
        return Ok(None);
    };
    Ok(Some(Earlier {
        traction: traction.in_rows()?.to_vec(),
        pressure: pressure.in_rows()?.to_vec(),
        coefficient: coefficient.in_rows()?.to_vec(),
    }))
}

fn drives(given: [(f64, bool); 2]) -> [Drive; 2] {
    given.map(|(value, is_force)| {
        if is_force {
            Drive::Force(value)
        } else {
            Drive::Slip(value)
        }
    })
}

/// A solved shift or step of rolling, and its derivatives with the states of the points held.
#[pyclass(frozen, name = "TangentialTangent", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyTangentialTangent {
    operators: Py<PyPatchOperators>,
    friction: Py<PyFriction>,
    shape: [usize; 2],
    pressure: Vec<f64>,
    origin: [f64; 2],
    drive: [Drive; 2],
    spin: f64,
    rigid_slip: Option<Vec<f64>>,
    speed: f64,
    earlier: Option<Earlier>,
    plasticity: Option<(f64, f64, Vec<f64>)>,
    traction: Vec<f64>,
    slip: Vec<f64>,
    coefficient: Vec<f64>,
    found_drive: [f64; 2],
    around: Surroundings,
}

/// Pressure, drive, spin, rigid slip here and one step behind, coefficient of friction, parameters of a law, dissipation
/// besides that by all else, layer, relative stiffness of the ties of slip of second order, an earlier state, yield stress, hardening and earlier plastic slip of a layer that yields, and products with the slip
/// operator.
#[pyclass(frozen, get_all, name = "TangentialChange", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyTangentialChange {
    pressure: Py<PyArray2<f64>>,
    drive: [f64; 2],
    spin: f64,
    rigid_slip: Py<PyArray3<f64>>,
    rigid_slip_behind: Py<PyArray3<f64>>,
    coefficient: Py<PyArray2<f64>>,
    law: Py<PyArray1<f64>>,
    heat: Py<PyArray2<f64>>,
    layer: f64,
    stiffness: f64,
    earlier: OwnPast,
    plasticity: Option<(f64, f64, Py<PyArray2<f64>>)>,
    products: usize,
}

#[pymethods]
impl PyTangentialTangent {
    /// Arguments of `PatchOperators.solve`, and what it found.
    #[new]
    #[pyo3(signature = (
        operators, pressure, origin, drive, spin, speed, friction, earlier, found, around, rigid_slip=None,
        plasticity=None
    ))]
    #[allow(clippy::too_many_arguments, reason = "a problem and its solution")]
    fn new(
        operators: Py<PyPatchOperators>,
        pressure: Field<'_>,
        origin: (f64, f64),
        drive: [(f64, bool); 2],
        spin: f64,
        speed: f64,
        friction: Py<PyFriction>,
        earlier: Option<Past<'_>>,
        found: Solved<'_>,
        around: Around,
        rigid_slip: Option<Vectors<'_>>,
        plasticity: Option<(f64, f64, Option<Field<'_>>)>,
    ) -> PyResult<Self> {
        let (shape, first) = around;
        Ok(Self {
            operators,
            friction,
            shape: [pressure.shape()[0], pressure.shape()[1]],
            pressure: pressure.in_rows()?.to_vec(),
            origin: [origin.0, origin.1],
            drive: drives(drive),
            spin,
            rigid_slip: match rigid_slip {
                Some(slip) => Some(slip.in_rows()?.to_vec()),
                None => None,
            },
            speed,
            earlier: earlier_of(earlier)?,
            plasticity: match plasticity {
                Some((yield_stress, hardening, slip)) => {
                    let slip = match slip {
                        Some(slip) => slip.in_rows()?.to_vec(),
                        None => Vec::new(),
                    };
                    Some((yield_stress, hardening, slip))
                }
                None => None,
            },
            traction: found.0.in_rows()?.to_vec(),
            slip: found.1.in_rows()?.to_vec(),
            coefficient: found.2.in_rows()?.to_vec(),
            found_drive: found.3,
            around: Surroundings { shape, first },
        })
    }

    /// Changes of traction and slip (2, ny, nx), coefficient of friction (ny, nx), drive and dissipation, of the share of
    /// the slip that is plastic and the accumulated plastic slip (ny, nx) of a layer that yields, and products with the
    /// slip operator, by changes of what is given.
    #[pyo3(signature = (
        pressure, drive, spin, rigid_slip, rigid_slip_behind, coefficient, law, heat, layer, earlier, plasticity=None,
        stiffness=0.0
    ))]
    #[allow(clippy::too_many_arguments, reason = "all that is given")]
    #[allow(clippy::type_complexity, reason = "all that is found")]
    fn forward<'py>(
        &self,
        py: Python<'py>,
        pressure: Field<'py>,
        drive: [f64; 2],
        spin: f64,
        rigid_slip: Vectors<'py>,
        rigid_slip_behind: Vectors<'py>,
        coefficient: Field<'py>,
        law: Numbers<'py>,
        heat: Field<'py>,
        layer: f64,
        earlier: Past<'py>,
        plasticity: Option<(f64, f64, Field<'py>)>,
        stiffness: f64,
    ) -> PyResult<(
        OwnVectors<'py>,
        OwnVectors<'py>,
        OwnField<'py>,
        [f64; 2],
        OwnField<'py>,
        Option<(OwnField<'py>, OwnField<'py>)>,
        usize,
    )> {
        let (traction, before, past) = earlier;
        let change = TangentialChange {
            pressure: pressure.in_rows()?.to_vec(),
            drive,
            spin,
            rigid_slip: rigid_slip.in_rows()?.to_vec(),
            rigid_slip_behind: rigid_slip_behind.in_rows()?.to_vec(),
            coefficient: coefficient.in_rows()?.to_vec(),
            law: law.in_rows()?.to_vec(),
            heat: heat.in_rows()?.to_vec(),
            layer,
            stiffness,
            // slip is relative, and ties go with it
            length: 0.0,
            earlier: Earlier {
                traction: traction.in_rows()?.to_vec(),
                pressure: before.in_rows()?.to_vec(),
                coefficient: past.in_rows()?.to_vec(),
            },
            brought: Vec::new(),
            plasticity: match plasticity {
                Some((yield_stress, hardening, slip)) => PlasticityChange {
                    yield_stress,
                    hardening,
                    earlier: slip.in_rows()?.to_vec(),
                },
                None => PlasticityChange::default(),
            },
        };
        let (found, products) =
            self.with(py, |tangent, monitor| tangent.forward(&change, monitor))?;
        let plastic = match self.plasticity {
            Some(_) => Some((
                self.field(py, found.plastic_share)?,
                self.field(py, found.accumulated)?,
            )),
            None => None,
        };
        Ok((
            self.vectors(py, found.traction)?,
            self.vectors(py, found.slip)?,
            self.field(py, found.coefficient)?,
            found.drive,
            self.heat(py, found.dissipation)?,
            plastic,
            products,
        ))
    }

    /// Derivatives of a number by all that is given, from its weights of all that is found; `plastic`: those of the share
    /// of the slip that is plastic and of the accumulated plastic slip, (ny, nx) each.
    #[pyo3(signature = (traction, slip, coefficient, drive, dissipation, plastic=None))]
    #[allow(clippy::too_many_arguments, reason = "all that is found")]
    fn adjoint<'py>(
        &self,
        py: Python<'py>,
        traction: Vectors<'py>,
        slip: Vectors<'py>,
        coefficient: Field<'py>,
        drive: [f64; 2],
        dissipation: Field<'py>,
        plastic: Option<(Field<'py>, Field<'py>)>,
    ) -> PyResult<PyTangentialChange> {
        let (plastic_share, accumulated) = match &plastic {
            Some((share, slip)) => (share.in_rows()?.to_vec(), slip.in_rows()?.to_vec()),
            None => Default::default(),
        };
        let weights = TangentialResponse {
            traction: traction.in_rows()?.to_vec(),
            slip: slip.in_rows()?.to_vec(),
            coefficient: coefficient.in_rows()?.to_vec(),
            drive,
            dissipation: dissipation.in_rows()?.to_vec(),
            plastic_share,
            accumulated,
        };
        let (found, products) =
            self.with(py, |tangent, monitor| tangent.adjoint(&weights, monitor))?;
        Ok(PyTangentialChange {
            pressure: self.field(py, found.pressure)?.unbind(),
            drive: found.drive,
            spin: found.spin,
            rigid_slip: self.vectors(py, found.rigid_slip)?.unbind(),
            rigid_slip_behind: self.vectors(py, found.rigid_slip_behind)?.unbind(),
            coefficient: self.field(py, found.coefficient)?.unbind(),
            law: found.law.into_pyarray(py).unbind(),
            heat: self.heat(py, found.heat)?.unbind(),
            layer: found.layer,
            stiffness: found.stiffness,
            earlier: (
                self.vectors(py, found.earlier.traction)?.unbind(),
                self.field(py, found.earlier.pressure)?.unbind(),
                self.field(py, found.earlier.coefficient)?.unbind(),
            ),
            plasticity: match self.plasticity {
                Some(_) => {
                    let found = found.plasticity;
                    let slip = self.field(py, found.earlier)?.unbind();
                    Some((found.yield_stress, found.hardening, slip))
                }
                None => None,
            },
            products,
        })
    }

    /// The rigid slip here and one step behind, (2, ny, nx) each, that do the same as the bodies of other operators, and the
    /// stiffness of ties by them, over that of these.
    fn slip_by_bodies<'py>(
        &self,
        py: Python<'py>,
        other: &PyPatchOperators,
    ) -> PyResult<(OwnVectors<'py>, OwnVectors<'py>, f64)> {
        let ((here, behind, stiffness), _) = self.with(py, |tangent, _| {
            let here = tangent.slip_by_bodies(&other.0);
            let behind = tangent.slip_behind_by_bodies(&other.0);
            Ok((here, behind, tangent.stiffness_of(&other.0)))
        })?;
        let (here, behind) = (self.vectors(py, here)?, self.vectors(py, behind)?);
        Ok((here, behind, stiffness))
    }

    /// Derivatives of the coefficient at rest by the parameters of a law and the speed; empty for other friction.
    fn rest_by_law<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (slopes, _) = self.with(py, |tangent, _| Ok(tangent.rest_by_law()))?;
        Ok(slopes.into_pyarray(py))
    }

    /// Coefficients of friction (ny, nx) by the direction of rolling, with the heat held.
    fn coefficient_by_angle<'py>(&self, py: Python<'py>) -> PyResult<OwnField<'py>> {
        let (slopes, _) = self.with(py, |tangent, _| tangent.coefficient_by_angle())?;
        self.field(py, slopes)
    }

    /// Slip (2, ny, nx), and heat on the grid of the result, that other operators make of the state.
    fn with_operators<'py>(
        &self,
        py: Python<'py>,
        other: &PyPatchOperators,
    ) -> PyResult<(OwnVectors<'py>, OwnField<'py>)> {
        let ((slip, heat), _) = self.with(py, |tangent, _| Ok(tangent.with_operators(&other.0)))?;
        Ok((self.vectors(py, slip)?, self.heat(py, heat)?))
    }
}

impl PyTangentialTangent {
    /// Runs `work` with the tangent; its result, and the products that it took.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut TangentialTangent<'_>, Monitor<'_>) -> Result<T, Error> + Send,
    ) -> PyResult<(T, usize)> {
        let (operators, friction) = (self.operators.get(), self.friction.get());
        enter(py, |monitor| {
            let problem = TangentialProblem {
                around: None,
                pressure: &self.pressure,
                origin: self.origin,
                drive: self.drive,
                spin: self.spin,
                rigid_slip: self.rigid_slip.as_deref(),
                speed: self.speed,
                friction: &friction.0,
                plasticity: self
                    .plasticity
                    .as_ref()
                    .map(|(yield_stress, hardening, earlier)| Plasticity {
                        yield_stress: *yield_stress,
                        hardening: *hardening,
                        earlier,
                    }),
                earlier: self.earlier.as_ref(),
                start: None,
                tolerance: 0.5,
            };
            let state = TangentialState {
                traction: &self.traction,
                slip: &self.slip,
                coefficient: &self.coefficient,
                drive: self.found_drive,
            };
            let mut tangent =
                TangentialTangent::new(&operators.0, &problem, state, Some(self.around))?;
            let result = work(&mut tangent, monitor)?;
            Ok::<_, Error>((result, tangent.products))
        })
    }

    fn field<'py>(&self, py: Python<'py>, values: Vec<f64>) -> PyResult<OwnField<'py>> {
        values.into_pyarray(py).reshape(self.shape)
    }

    fn vectors<'py>(&self, py: Python<'py>, values: Vec<f64>) -> PyResult<OwnVectors<'py>> {
        let [ny, nx] = self.shape;
        values.into_pyarray(py).reshape([2, ny, nx])
    }

    fn heat<'py>(&self, py: Python<'py>, values: Vec<f64>) -> PyResult<OwnField<'py>> {
        let [nx, ny] = self.around.shape;
        values.into_pyarray(py).reshape([ny, nx])
    }
}

fn rows_of_three(array: &PyReadonlyArray2<'_, f64>, name: &str) -> PyResult<Vec<[f64; 3]>> {
    if array.shape()[1] != 3 {
        return Err(PyValueError::new_err(format!(
            "{name} has shape {:?}, expected (n, 3)",
            array.shape()
        )));
    }
    let flat = array.in_rows()?;
    Ok(flat.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect())
}

fn codes(solution: &TangentialSolution) -> Vec<i8> {
    let yields = |k: usize| solution.plastic.as_ref().is_some_and(|p| p.yields[k]);
    let code = |(k, s): (usize, &DiscState)| match s {
        DiscState::Excluded => 0,
        DiscState::Inside => 1,
        DiscState::Rim if yields(k) => 3,
        DiscState::Rim => 2,
    };
    solution.state.iter().enumerate().map(code).collect()
}

/// Where a shift or rolling ended; fields (ny, nx) and (2, ny, nx).
#[pyclass(frozen, get_all, name = "TangentialOutcome", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyTangentialOutcome {
    traction: Py<PyArray3<f64>>,
    slip: Py<PyArray3<f64>>,
    /// Of a layer that yields: share of the slip that is plastic, and the accumulated plastic slip [m].
    plastic: Option<[Py<PyArray2<f64>>; 2]>,
    /// 0 open, 1 stick, 2 slip, 3 plastic.
    status: Py<PyArray2<i8>>,
    coefficient: Py<PyArray2<f64>>,
    /// On the grid around, if that was asked for.
    dissipation: Option<Py<PyArray2<f64>>>,
    drive: [f64; 2],
    force: [f64; 2],
    spin_moment: f64,
    converged: bool,
    iterations: usize,
    products: f64,
    preconditionings: f64,
    history: Vec<f64>,
    /// Where friction follows the temperature: rounds, and the change of the coefficients in the last one.
    rounds: Option<(usize, f64)>,
}

impl PyTangentialOutcome {
    fn of(
        py: Python<'_>,
        solution: TangentialSolution,
        [ny, nx]: [usize; 2],
        dissipation: Option<Py<PyArray2<f64>>>,
    ) -> PyResult<Self> {
        let vector = |v: Vec<f64>| -> PyResult<Py<PyArray3<f64>>> {
            Ok(v.into_pyarray(py).reshape([2, ny, nx])?.unbind())
        };
        let status = codes(&solution).into_pyarray(py);
        let field = |v: Vec<f64>| -> PyResult<Py<PyArray2<f64>>> {
            Ok(v.into_pyarray(py).reshape([ny, nx])?.unbind())
        };
        let plastic = match solution.plastic {
            Some(plastic) => Some([field(plastic.share)?, field(plastic.accumulated)?]),
            None => None,
        };
        let coefficient = solution.coefficient.into_pyarray(py);
        Ok(Self {
            traction: vector(solution.traction)?,
            slip: vector(solution.slip)?,
            plastic,
            status: status.reshape([ny, nx])?.unbind(),
            coefficient: coefficient.reshape([ny, nx])?.unbind(),
            dissipation,
            drive: solution.drive,
            force: solution.force,
            spin_moment: solution.spin_moment,
            converged: solution.converged,
            iterations: solution.iterations,
            products: solution.products,
            preconditionings: solution.preconditionings,
            history: solution.history,
            rounds: (solution.rounds).map(|rounds| (rounds.count, rounds.change)),
        })
    }
}

/// Forces (m, 3) over creepages, and the fields (2, ny, nx) and (ny, nx) of the last one.
#[pyclass(frozen, get_all, name = "FoundationOutcome", module = "mtb_rs._mtb_rs")]
pub(crate) struct PyFoundationOutcome {
    forces: Py<PyArray2<f64>>,
    traction: Py<PyArray3<f64>>,
    slip: Py<PyArray3<f64>>,
    slipping: Py<PyArray2<bool>>,
}

/// Kalker's C11, C22, C23, C33 for the ratio a / b and Poisson's ratio.
#[pyfunction]
pub(crate) fn kalker_coefficients(
    ratio: f64,
    poisson_ratio: f64,
) -> PyResult<(f64, f64, f64, f64)> {
    let c = creep_coefficients(ratio, poisson_ratio).map_err(|e| bad_input(&e))?;
    Ok((c.c11, c.c22, c.c23, c.c33))
}

/// FASTSIM or FaStrip for creepages (m, 3) on a bound (ny, nx), rolling at `angle` [rad] from +x; `ellipse`: (a, b) [m]
/// along and across the rolling direction, of which the flexibilities are Kalker's; `foundation`: "three" flexibilities,
/// "one", or "blended" from three to one, with the friction force [N] of full sliding; `method`: "fastsim", "fastsim2"
/// (second order), "fastrip" or "fastrip of contact"; `slope`: (k0, alpha, beta) of the reduction of the slope with the
/// peak of the bound [Pa] per unit coefficient of friction and the semi-axis that go with it. Fields of the last creepage.
#[pyfunction]
#[pyo3(signature = (
    bound, spacing, origin, angle, ellipse, shear_modulus, poisson_ratio, creepages, speed, friction, foundation, limit,
    method, slope
))]
#[allow(clippy::too_many_arguments, reason = "one call per curve")]
pub(crate) fn fastsim_curve<'py>(
    py: Python<'py>,
    bound: PyReadonlyArray2<'py, f64>,
    spacing: (f64, f64),
    origin: (f64, f64),
    angle: f64,
    ellipse: (f64, f64),
    shear_modulus: f64,
    poisson_ratio: f64,
    creepages: PyReadonlyArray2<'py, f64>,
    speed: f64,
    friction: &PyFriction,
    foundation: &str,
    limit: f64,
    method: &str,
    slope: Option<((f64, f64, f64), f64, f64)>,
) -> PyResult<PyFoundationOutcome> {
    let rows = rows_of_three(&creepages, "creepages")?;
    let shape = [bound.shape()[0], bound.shape()[1]];
    let bound = bound.in_rows()?;
    let (a, b) = ellipse;
    let (forces, last) = enter(py, |monitor| {
        let coefficients = creep_coefficients(a / b, poisson_ratio)?;
        let three = Flexibilities::of_ellipse(a, b, shear_modulus, &coefficients);
        let theory = StripTheory {
            shear_modulus,
            poisson_ratio,
            ratio: a / b,
            coefficients,
            like_contact: method == "fastrip of contact",
        };
        let reduction = match slope {
            None => None,
            Some(((initial, remaining, rate), peak, axis)) => {
                let reduction = SlopeReduction {
                    initial,
                    remaining,
                    rate,
                };
                Some((reduction.checked()?, peak, axis))
            }
        };
        let mut problem = FoundationProblem {
            shape: [shape[1], shape[0]],
            cell: [spacing.0, spacing.1],
            origin: [origin.0, origin.1],
            bound,
            flexibility: three,
            isotropic: None,
            angle,
            speed,
            friction: &friction.0,
            order: if method == "fastsim2" {
                Order::Second
            } else {
                Order::First
            },
        };
        let (sine, cosine) = angle.sin_cos();
        let whole = three.whole(a, b, limit);
        let mut forces = Vec::with_capacity(3 * rows.len());
        let mut last = None;
        for (k, creepage) in rows.into_iter().enumerate() {
            report(monitor, k, f64::NAN)?;
            let [xi, eta, phi] = creepage;
            // along the rolling direction and to its left
            let local = [cosine * xi + sine * eta, cosine * eta - sine * xi, phi];
            (problem.flexibility, problem.isotropic) = match foundation {
                "one" => (three.merged(local, (a * b).sqrt()), None),
                "blended" => {
                    let (blend, one) = three.blended(local, a, whole);
                    (blend, Some(one))
                }
                _ => (three, None),
            };
            if let Some((reduction, peak, axis)) = &reduction {
                let e = gradient(local, *axis, shear_modulus, coefficients.c11, *peak);
                let k = reduction.slope(e);
                problem.flexibility = problem.flexibility.softened(k);
                problem.isotropic = problem.isotropic.map(|one| one / k);
            }
            let solution: FoundationSolution = if method.starts_with("fastrip") {
                fastrip::solve(&problem, &theory, creepage)?
            } else {
                fastsim::solve(&problem, creepage)?
            };
            forces.extend([solution.force[0], solution.force[1], solution.spin_moment]);
            last = Some(solution);
        }
        Ok::<_, Error>((forces, last))
    })?;
    let (count, [ny, nx]) = (forces.len() / 3, shape);
    let (traction, slip, slipping) = last.map_or_else(
        || {
            (
                vec![0.0; 2 * nx * ny],
                vec![0.0; 2 * nx * ny],
                vec![false; nx * ny],
            )
        },
        |last| (last.traction, last.slip, last.is_slipping),
    );
    let vector = |v: Vec<f64>| -> PyResult<Py<PyArray3<f64>>> {
        Ok(v.into_pyarray(py).reshape([2, ny, nx])?.unbind())
    };
    let slipping = slipping.into_pyarray(py);
    Ok(PyFoundationOutcome {
        forces: forces.into_pyarray(py).reshape([count, 3])?.unbind(),
        traction: vector(traction)?,
        slip: vector(slip)?,
        slipping: slipping.reshape([ny, nx])?.unbind(),
    })
}

/// Polach's forces (Fx, Fy) for creepages (m, 3), each at its coefficient of friction (m,).
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "one call per curve")]
pub(crate) fn polach_curve<'py>(
    py: Python<'py>,
    ellipse: (f64, f64),
    shear_modulus: f64,
    poisson_ratio: f64,
    normal_force: f64,
    creepages: PyReadonlyArray2<'py, f64>,
    friction: PyReadonlyArray1<'py, f64>,
    reduction: (f64, f64),
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows = rows_of_three(&creepages, "creepages")?;
    let friction = friction.in_rows()?;
    let (a, b) = ellipse;
    let forces = enter(py, |_| {
        let contact = PolachContact {
            a,
            b,
            shear_modulus,
            normal_force,
            coefficients: creep_coefficients(a / b, poisson_ratio)?,
            reduction_adhesion: reduction.0,
            reduction_slip: reduction.1,
        };
        let mut forces = Vec::with_capacity(2 * rows.len());
        for (creepage, mu) in rows.iter().zip(friction) {
            forces.extend(creep_force(&contact, *creepage, *mu)?);
        }
        Ok::<_, Error>(forces)
    })?;
    let count = forces.len() / 2;
    forces.into_pyarray(py).reshape([count, 2])
}

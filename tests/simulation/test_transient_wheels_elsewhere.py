# SPDX-License-Identifier: MIT OR Apache-2.0
"""Transient steps of wheels in C, Fortran and units: the numbers of Python."""

from __future__ import annotations

import ctypes
import zipfile
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu

import mtb_rs as mtb

from .test_c_interface import Conditions, by_ctypes, in_fortran, run

pytestmark = [
    pytest.mark.slow,  # compiles programs
    pytest.mark.filterwarnings("ignore:the peak pressure is"),
]

V, RADIUS, FREE = 20.0, 0.46, float("nan")
#: A ride that sways: pose, velocity and time of each step, of parts of a cell and of several.
RIDE: list[tuple[list[float], list[float], float]] = [
    (
        [0.0, 4e-4 * np.sin(0.7 * k), FREE, FREE, 0.0, 2e-3 * np.cos(0.7 * k)],
        [V, 0.01 * k, 0.0, 0.0, 1.0005 * V / RADIUS, 0.02],
        (0.7e-3, 3.3e-3)[k % 2] / V,
    )
    for k in range(6)
]
LOAD = ["force.x", "force.y", "force.z", "moment.x", "moment.y", "moment.z"]


@pytest.fixture(scope="module")
def wheels() -> mtb.PreparedWheels:
    scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=1.5e-3)
    return scene.prepare(side="both", friction=mtb.FallingFriction(0.35, 0.25, 0.5, memory=1e-3))


@pytest.fixture(scope="module")
def file(wheels: mtb.PreparedWheels, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("transient") / "wheels.mtbw"
    wheels.save(path)
    return path


def ridden(contact: mtb.PreparedWheels, **given: Any) -> list[mtb.WheelStep]:
    return [contact.step(pose, velocity, dt=dt, transient=True, **given) for pose, velocity, dt in RIDE]


def near(found: Any, wanted: Any, tolerance: float = 1e-9) -> None:
    np.testing.assert_allclose(found, wanted, rtol=tolerance, atol=tolerance * np.abs(wanted).max())


class C:
    """The library by ctypes."""

    def __init__(self, library: Path, file: Path) -> None:
        self.c = by_ctypes(library)
        self.handle = ctypes.c_uint64()
        assert self.c.mtb_wheels_load(str(file).encode(), ctypes.byref(self.handle)) == 0

    def message(self) -> str:
        return str(self.c.mtb_last_error_message().decode())

    def step(
        self, pose: list[float], velocity: list[float], dt: float, conditions: Conditions | None = None
    ) -> tuple[int, np.ndarray]:
        """Status, then force, moment, vertical force and heat."""
        six, out = ctypes.c_double * 6, (ctypes.c_double * 64)()
        given = None if conditions is None else ctypes.byref(conditions)
        status = self.c.mtb_wheels_step_transient(
            self.handle, six(*pose), six(*velocity), ctypes.c_double(dt), given, out
        )
        return status, np.array([*out[:8], out[18]])

    def state(self) -> ctypes.Array[ctypes.c_double]:
        n = ctypes.c_uint64()
        assert self.c.mtb_wheels_state_size(self.handle, ctypes.byref(n)) == 0
        state = (ctypes.c_double * n.value)()
        assert self.c.mtb_wheels_state(self.handle, n, state) == 0
        return state

    def resume(self, state: ctypes.Array[ctypes.c_double]) -> None:
        assert self.c.mtb_wheels_resume(self.handle, ctypes.c_uint64(len(state)), state) == 0


def load_of(step: mtb.WheelStep) -> list[float]:
    return [*step.force, *step.moment, *step.vertical_force.values(), step.friction_power]


def test_c_rolls_on_as_python_does(library: Path, wheels: mtb.PreparedWheels, file: Path) -> None:
    c = C(library, file)
    own = ridden(wheels.copy())
    loads = np.array([load_of(step) for step in own])
    states = []
    for (pose, velocity, dt), load in zip(RIDE, loads, strict=True):
        status, found = c.step(pose, velocity, dt)
        assert status == 0, c.message()
        near(found, load)
        states.append(c.state())
    # steps taken again, from what one before them has left
    c.resume(states[2])
    for at in (3, 4):
        near(c.step(*RIDE[at])[1], loads[at], 1e-6)
    # what cannot be leaves the memory as it is
    for wrong, said in ((0.0, "duration is 0"), (FREE, "duration is"), (-1.0, "duration is -1")):
        assert c.step(*RIDE[5][:2], wrong)[0] == 1
        assert said in c.message()
    near(c.step(*RIDE[5])[1], loads[5], 1e-6)
    by = (ctypes.c_double * 25)()
    assert c.c.mtb_wheels_duration_derivatives(c.handle, by) == 0
    for rows, of in (
        (slice(3), "force"),
        (slice(3, 6), "moment"),
        (8, "friction_power"),
        (slice(9, 15), "pose"),
    ):
        wanted = np.asarray(own[5].derivative(of, "dt"))
        np.testing.assert_allclose(np.array(by)[rows], wanted, rtol=1e-4, atol=1e-4 * np.abs(wanted).max())
    table = (ctypes.c_double * 108)()
    assert c.c.mtb_wheels_derivatives(c.handle, table) == 0
    wanted = own[5].derivative("force", "velocity")
    near(np.reshape(table, (9, 12))[:3, 6:], wanted, 1e-4)
    # a steady step has no duration, and is rolled on from
    six, out = ctypes.c_double * 6, (ctypes.c_double * 64)()
    assert c.c.mtb_wheels_step(c.handle, six(*RIDE[0][0]), six(*RIDE[0][1]), out) == 0
    assert c.c.mtb_wheels_duration_derivatives(c.handle, by) == 1
    assert "mtb_wheels_step_transient is needed" in c.message()
    again = wheels.copy()
    again.step(*RIDE[0][:2])
    near(c.step(*RIDE[1])[1], load_of(again.step(*RIDE[1][:2], dt=RIDE[1][2], transient=True)), 1e-6)
    assert c.c.mtb_wheels_step_transient(c.handle, None, six(), ctypes.c_double(1.0), None, None) == 1
    assert c.message() == "step is null"
    assert c.c.mtb_wheels_free(c.handle) == 0


def test_c_rolls_on_under_forces(library: Path, wheels: mtb.PreparedWheels, file: Path) -> None:
    c, own = C(library, file), wheels.copy()
    for k in range(3):
        pose = [0.0, FREE, FREE, FREE, 0.0, 1e-3 * k]
        conditions = Conditions(5e3, FREE, 0.0, 1e-3)
        status, found = c.step(pose, RIDE[k][1], RIDE[k][2], conditions)
        assert status == 0, c.message()
        given = {"lateral_force": 5e3, "axle_moment": 0.0, "curvature": 1e-3}
        step = own.step(pose, RIDE[k][1], dt=RIDE[k][2], transient=True, **given)
        near(found, load_of(step), 1e-6)
        assert list(conditions.velocity) == pytest.approx(step.velocity, rel=1e-8, abs=1e-12)
    assert c.c.mtb_wheels_free(c.handle) == 0


#: Two transient steps in Fortran, the first from rest.
ROLLING_ON = """
program rolling_on
  use, intrinsic :: iso_c_binding
  use, intrinsic :: ieee_arithmetic
  use mtb
  implicit none
  character(len=1000) :: path
  integer(c_int64_t) :: wheels
  integer :: k
  real(c_double) :: free, by(25)
  type(mtb_wheel_step) :: step
  type(mtb_wheel_conditions) :: given

  call get_command_argument(1, path)
  free = ieee_value(free, ieee_quiet_nan)
  given%lateral_force = free
  given%longitudinal_force = free
  given%axle_moment = free
  given%curvature = 0
  given%rails = 0
  given%rail_rates = 0
  given%wheels = 0
  given%wheel_rates = 0
  if (mtb_wheels_load(path, wheels) /= mtb_status_ok) stop 1
  do k = 1, 2
    if (mtb_wheels_step_transient(wheels, &
      [0.0_c_double, 1.0e-4_c_double * k, free, free, 0.0_c_double, 0.0_c_double], &
      [20.0_c_double, 0.02_c_double, 0.0_c_double, 0.0_c_double, 43.5_c_double, 0.0_c_double], &
      1.0e-4_c_double, given, step) /= mtb_status_ok) stop 2
  end do
  if (mtb_wheels_duration_derivatives(wheels, by) /= mtb_status_ok) stop 3
  write (*, "(8(es24.16e3, 1x))") step%force, step%moment, step%friction_power, by(2)
  if (mtb_wheels_free(wheels) /= mtb_status_ok) stop 4
end program
"""


def test_fortran_rolls_on(library: Path, wheels: mtb.PreparedWheels, file: Path, tmp_path: Path) -> None:
    done = run(in_fortran("rolling_on", library, tmp_path, ROLLING_ON), library, file)
    assert done.returncode == 0, done.stderr
    own, motion = wheels.copy(), [20.0, 0.02, 0.0, 0.0, 43.5, 0.0]
    for k in (1, 2):
        pose = [0.0, 1e-4 * k, FREE, FREE, 0.0, 0.0]
        step = own.step(pose, motion, dt=1e-4, transient=True)
    told = [float(value) for value in done.stdout.split()]
    near(told[:3], step.force)
    near(told[3:6], step.moment)
    assert told[6] == pytest.approx(step.friction_power, rel=1e-9)
    assert told[7] == pytest.approx(step.derivative("force", "dt")[1], rel=1e-5)


@pytest.fixture(scope="module")
def runtime(library: Path) -> Path:
    names = ("libmtb_fmu.so", "libmtb_fmu.dylib", "mtb_fmu.dll")
    return next(library / name for name in names if (library / name).is_file())


class Unit:
    """A unit in FMPy."""

    def __init__(self, path: Path, folder: Path) -> None:
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder)
        description = fmpy.read_model_description(str(path))
        self.at = {v.name: v.valueReference for v in description.modelVariables}
        self.log: list[str] = []
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=str(folder),
            modelIdentifier="mtb_contact",
            instanceName="wheels",
        )
        calls = fmpy.fmi2.fmi2CallbackFunctions()
        calls.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(lambda *said: self.log.append(said[-1].decode()))
        self.fmu.instantiate(callbacks=calls)
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def get(self, names: list[str]) -> list[float]:
        return list(self.fmu.getReal([self.at[name] for name in names]))

    def step(self, inputs: dict[str, float], dt: float) -> list[float]:
        self.fmu.setReal([self.at[name] for name in inputs], list(inputs.values()))
        self.fmu.doStep(0.0, dt)
        return self.get([*LOAD, "friction_power"])


def unit_load(step: mtb.WheelStep) -> list[float]:
    return [*step.force, *step.moment, step.friction_power]


MOTION = [f"{of}.{axis}" for of in ("velocity", "angular_velocity") for axis in "xyz"]


def test_a_unit_rolls_on_and_goes_back(wheels: mtb.PreparedWheels, runtime: Path, tmp_path: Path) -> None:
    path = tmp_path / "wheels.fmu"
    start = {"y": 0.0, "yaw": 2e-3}
    wheels.save_fmu(path, runtime, start, RIDE[0][1], transient=True)
    assert validate_fmu(str(path)) == []
    unit, own = Unit(path, tmp_path / "unpacked"), wheels.copy()
    # it has rolled steadily before
    steady = own.step([0.0, 0.0, FREE, FREE, 0.0, 2e-3], RIDE[0][1])
    near(unit.get([*LOAD, "friction_power"]), unit_load(steady))
    kept = None
    for k, (pose, velocity, dt) in enumerate(RIDE):
        step = own.step(pose, velocity, dt=dt, transient=True)
        inputs = {"pose.y": pose[1], "pose.yaw": pose[5], **dict(zip(MOTION, velocity, strict=True))}
        near(unit.step(inputs, dt), unit_load(step))
        if k == 3:
            kept = unit.fmu.getFMUstate()
            told = unit.fmu.serializeFMUstate(kept)
    by = unit.fmu.getDirectionalDerivative([unit.at["force.y"]], [unit.at["velocity.y"]], [1.0])
    assert by[0] == pytest.approx(step.derivative("force", "velocity")[1, 1], rel=1e-5)
    # another step from the same place, from the state and from its bytes, ends at the same
    for state in (kept, unit.fmu.deSerializeFMUstate(told)):
        unit.fmu.setFMUstate(state)
        with pytest.raises(FMICallException):
            unit.fmu.getDirectionalDerivative([unit.at["force.y"]], [unit.at["velocity.y"]], [1.0])
        assert "after a step from there" in unit.log.pop()
        for pose, velocity, dt in RIDE[4:]:
            inputs = {"pose.y": pose[1], "pose.yaw": pose[5], **dict(zip(MOTION, velocity, strict=True))}
            last = unit.step(inputs, dt)
        near(last, unit_load(step), 1e-6)
    # a step without time moves nothing, and has no heat
    near(unit.step(inputs, 0.0), [*step.force, *step.moment, 0.0], 1e-6)
    by = unit.fmu.getDirectionalDerivative([unit.at["friction_power"]], [unit.at["velocity.y"]], [1.0])
    assert by == [0.0]
    unit.fmu.terminate()
    unit.fmu.freeInstance()


def test_a_unit_starts_at_rest(wheels: mtb.PreparedWheels, runtime: Path, tmp_path: Path) -> None:
    """Pressed together without friction; a steady unit has no answer there."""
    path = tmp_path / "rest.fmu"
    with pytest.raises(ValueError, match="does not roll"):
        wheels.save_fmu(path, runtime, velocity=[0.0] * 6)
    wheels.save_fmu(path, runtime, velocity=[0.0] * 6, transient=True)
    unit = Unit(path, tmp_path / "unpacked")
    force = unit.get(LOAD)[:3]
    assert np.hypot(*force[:2]) < 1e-6 * abs(force[2])
    own = wheels.copy()
    place = [0.0, 0.0, FREE, FREE, 0.0, 0.0]
    own.step(place, [0.0] * 6, dt=1e-12, transient=True)
    # it is pushed to the side, sticks, and then slips
    for speed in (0.01, 0.02, 0.5):
        motion = [0.0, speed, 0.0, 0.0, 0.0, 0.0]
        step = own.step(place, motion, dt=1e-3, transient=True)
        near(unit.step(dict(zip(MOTION, motion, strict=True)), 1e-3), unit_load(step), 1e-8)
    assert abs(step.force[1]) > 0.1 * abs(step.force[2])
    unit.fmu.terminate()
    unit.fmu.freeInstance()


def test_what_makes_no_transient_unit_is_named(runtime: Path, tmp_path: Path) -> None:
    scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=1.5e-3)
    path = tmp_path / "wheels.fmu"
    with pytest.raises(ValueError, match=r"transient is 1: True or False"):
        scene.prepare().save_fmu(path, runtime, velocity=V, transient=1)  # type: ignore[arg-type]
    warm = scene.prepare(friction=mtb.TemperatureFriction([0.0, 400.0], [0.33, 0.14]))
    warm.save_fmu(path, runtime, velocity=V)
    with pytest.raises(ValueError, match="temperature"):
        warm.save_fmu(tmp_path / "more.fmu", runtime, velocity=V, transient=True)
    assert not (tmp_path / "more.fmu").exists()

# SPDX-License-Identifier: MIT OR Apache-2.0
"""Steps that stick and slip out of files, other processes, C, Fortran and units: the numbers of Python."""

from __future__ import annotations

import ctypes
import pickle
import zipfile
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu

import mtb_rs as mtb

from .test_c_interface import LANGUAGES, by_ctypes, run

pytestmark = [pytest.mark.slow, pytest.mark.coarse]  # compiles programs

PUSHES = [3e-7] * 8 + [-6e-7] * 3 + [0.0]
LOAD = ["force.x", "force.y", "force.z", "moment.x", "moment.y", "moment.z"]


@pytest.fixture(scope="module")
def shoe() -> mtb.PreparedContact:
    scene = mtb.scenes.pole_shoe_on_rail(
        friction=mtb.VelocityTable((0.0, 10.0), (0.3, 0.2)),
        magnetic_pressure=mtb.VelocityTable((0.0, 10.0), (3e6, 2e6)),
        spacing=12e-3,
        attraction="both",
    )
    return scene.prepare("elastic-upper")


@pytest.fixture(scope="module")
def file(shoe: mtb.PreparedContact, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("sticking") / "shoe.mtbc"
    shoe.save(path, shift=True)
    return path


def pushed(contact: mtb.PreparedContact, **given: Any) -> list[mtb.ContactStep]:
    return [contact.step(shift=(push, 0.0), velocity=1.0, **given) for push in PUSHES]


def near(found: Any, wanted: Any, size: float = 0.0) -> None:
    """To 1e-9 of the largest entry, or of a `size` where that may vanish."""
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * max(np.abs(wanted).max(), size))


def test_a_file_and_another_process_take_the_same_steps(shoe: mtb.PreparedContact, file: Path) -> None:
    here = pushed(shoe.copy())
    # some points stick and some slip on the way, and all do either
    counts = [np.count_nonzero(step.status == 1) for step in here]
    assert min(counts) == 0 < max(counts)
    assert any(0 < count < np.count_nonzero(here[0].pressure) for count in counts)
    again = mtb.PreparedContact.load(file)
    for other in (again, pickle.loads(pickle.dumps(shoe)), pickle.loads(pickle.dumps(again))):
        for step, wanted in zip(pushed(other), here, strict=True):
            near(step.force, wanted.force)
            near(step.traction, wanted.traction)
            assert np.array_equal(step.status, wanted.status)


def test_a_file_for_sliding_says_what_it_lacks(shoe: mtb.PreparedContact, tmp_path: Path) -> None:
    shoe.save(tmp_path / "sliding.mtbc")
    sliding = mtb.PreparedContact.load(tmp_path / "sliding.mtbc")
    near(sliding.step(velocity=5.0).force, shoe.copy().step(velocity=5.0).force)
    with pytest.raises(ValueError, match="shift=True"):
        sliding.step(shift=1e-6, velocity=1.0)
    with pytest.raises(ValueError, match="shift=True"):
        sliding.save(tmp_path / "more.mtbc", shift=True)
    assert not (tmp_path / "more.mtbc").exists()
    # what a pickled contact can do, it could do before
    assert pickle.loads(pickle.dumps(sliding)).area.size == shoe.area.size
    with pytest.raises(ValueError, match=r"shift is 1: True or False is needed"):
        shoe.save(tmp_path / "more.mtbc", shift=1)  # type: ignore[arg-type]


@LANGUAGES
def test_a_program_that_breaks_away(
    compiled: Any, library: Path, shoe: mtb.PreparedContact, file: Path, tmp_path: Path
) -> None:
    done = run(compiled("break_away", library, tmp_path), library, file)
    assert done.returncode == 0, done.stderr
    rows = np.array([[float(v) for v in line.split()] for line in done.stdout.splitlines()])
    here = pushed(shoe.copy())
    here.append(here[-1])  # the last one was taken again
    near(rows[:, 0], [*PUSHES, 0.0])
    near(rows[:, 1], [step.force[0] for step in here])
    assert rows[:, 2].tolist() == [np.count_nonzero(step.status == 1) for step in here]
    near(rows[:, 3], [step.friction_work for step in here])


def test_derivatives_in_c_are_differences_of_steps(library: Path, file: Path) -> None:
    c = by_ctypes(library)
    handle, size = ctypes.c_uint64(), ctypes.c_uint64()
    assert c.mtb_contact_load(str(file).encode(), ctypes.byref(handle)) == 0
    assert c.mtb_contact_memory_size(handle, ctypes.byref(size)) == 0
    memory = (ctypes.c_double * size.value)()

    def step(given: np.ndarray) -> np.ndarray:
        pose = (ctypes.c_double * 6)(*[np.nan] * 4, given[4], np.nan)
        shift, velocity = (ctypes.c_double * 2)(*given[6:8]), (ctypes.c_double * 2)(*given[8:10])
        force, moment = (ctypes.c_double * 3)(), (ctypes.c_double * 3)()
        work, peak = ctypes.c_double(), ctypes.c_double()
        pull = ctypes.c_double(given[10])
        assert c.mtb_contact_step_shifted(handle, pose, velocity, shift, pull, force, moment, None) == 0
        assert c.mtb_contact_friction(handle, 0, None, None, None, ctypes.byref(work)) == 0
        assert c.mtb_contact_summary(handle, None, ctypes.byref(peak)) == 0
        return np.array([*force, *moment, work.value, peak.value])

    def message() -> str:
        return str(c.mtb_last_error_message().decode())

    at = np.zeros(11)
    at[6:] = 2.5e-7, 1e-7, 1.0, 0.5, 2.8e6
    at[4] = 1e-6
    step(at)
    found = (ctypes.c_double * 88)()
    assert c.mtb_contact_shift_derivatives(handle, found) == 1
    assert "from another one" in message()
    assert c.mtb_contact_memory(handle, size, memory) == 0
    step(at)
    assert c.mtb_contact_shift_derivatives(handle, found) == 0
    rows = np.array(found).reshape(8, 11)
    for column, reach in ((4, 1e-9), (6, 1e-10), (7, 1e-10), (8, 1e-4), (10, 1e2)):
        sides = []
        for sign in (1.0, -1.0):
            assert c.mtb_contact_remember(handle, size, memory) == 0
            given = at.copy()
            given[column] += sign * reach
            sides.append(step(given))
        slope = (sides[0] - sides[1]) / (2.0 * reach)
        scale = np.abs(slope[:3]).max(), np.abs(slope[3:6]).max(), abs(slope[6]), abs(slope[7])
        for part, most in zip((slice(0, 3), slice(3, 6), 6, 7), scale, strict=True):
            np.testing.assert_allclose(rows[part, column], slope[part], rtol=2e-5, atol=2e-5 * most)
    # components left to balance have no derivatives
    assert not rows[:, [2, 3]].any()
    assert c.mtb_contact_remember(handle, ctypes.c_uint64(3), memory) == 1
    assert "memory has 3 numbers" in message()
    assert c.mtb_contact_free(handle) == 0


@pytest.fixture(scope="module")
def unit(shoe: mtb.PreparedContact, library: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    names = ("libmtb_fmu.so", "libmtb_fmu.dylib", "mtb_fmu.dll")
    own = next(library / name for name in names if (library / name).is_file())
    path = tmp_path_factory.mktemp("sticking unit") / "shoe.fmu"
    shoe.save_fmu(path, own, velocity=0.0, shift=True)
    return path


def test_a_unit_stops_and_holds(unit: Path, shoe: mtb.PreparedContact, tmp_path: Path) -> None:
    """It slides, comes to rest, holds the friction that it then has, and breaks away backwards."""
    assert validate_fmu(str(unit)) == []
    speeds = [0.0, 4e-6, 1e-5, 2e-6, 0.0, 0.0, -6e-6, -1e-5]
    step = 0.05
    folder = tmp_path / "unpacked"
    with zipfile.ZipFile(unit) as archive:
        archive.extractall(folder)
    description = fmpy.read_model_description(str(unit))
    at = {v.name: v.valueReference for v in description.modelVariables}
    slave = FMU2Slave(
        guid=description.guid,
        unzipDirectory=str(folder),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="shoe",
    )
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    # inputs that are tried before the start leave nothing behind
    slave.setReal([at["velocity.x"]], [3.0])
    slave.getReal([at["force.x"]])
    slave.setReal([at["velocity.x"]], [0.0])
    slave.exitInitializationMode()
    outputs = [at[name] for name in [*LOAD, "friction_power", "peak_pressure"]]
    own = shoe.copy()
    first = own.step(shift=(0.0, 0.0), velocity=0.0)
    near(slave.getReal(outputs)[:3], first.force)
    told = []
    for k, speed in enumerate(speeds):
        slave.setReal([at["velocity.x"]], [speed])
        kept = slave.getFMUstate()
        slave.doStep(k * step, step)
        before = slave.getReal(outputs)
        # a step taken again from a state, here or from its bytes, is the same
        stored = slave.serializeFMUstate(kept)
        slave.setFMUstate(slave.deSerializeFMUstate(stored))
        slave.doStep(k * step, step)
        here = own.step(shift=(speed * step, 0.0), velocity=(speed, 0.0), dt=step)
        for values in (before, slave.getReal(outputs)):
            near(values[:3], here.force)
            # at a lever of a centimetre: what is its own mirror image has a moment of rounding alone
            near(values[3:6], here.moment, 1e-2 * float(np.abs(here.force).max()))
            assert values[6] == pytest.approx(here.friction_power, rel=1e-9, abs=1e-12)
        told.append(here.force[0])
        slope = slave.getDirectionalDerivative([at["force.x"]], [at["velocity.x"]], [1.0])
        by_shift, by_velocity = (here.derivative("force", by=by)[0, 0] for by in ("shift", "velocity"))
        near(slope[0], by_shift * step + by_velocity)
    # at rest it holds what it had, before it breaks away backwards
    assert told[5] == pytest.approx(told[4], rel=1e-9)
    assert told[4] > 0.0 > told[-1]
    slave.terminate()
    slave.freeInstance()

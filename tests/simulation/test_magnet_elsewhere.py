# SPDX-License-Identifier: MIT OR Apache-2.0
"""A magnet that follows the gap in files, other processes, C and units: the numbers of Python."""

from __future__ import annotations

import ctypes
import pickle
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

import mtb_rs as mtb

from .test_c_interface import by_ctypes

pytestmark = [pytest.mark.slow, pytest.mark.coarse]  # builds libraries

MAGNET = mtb.Magnet(
    3e3,
    1e-3,
    iron_share=1.9,
    pole_length=30e-3,
    yoke=(0.15, 3e-3),
    leakage=1e-7,
    speed_factor=mtb.VelocityTable((0.0, 50.0), (1.0, 0.6)),
)
#: Heights of the shoe [m], and velocity along the rail [m/s]; NaN: the shoe lies on it.
RIDE = [(np.nan, 10.0), (4e-3, 20.0), (1e-3, 5.0), (np.nan, 30.0)]
LOAD = ["force.x", "force.y", "force.z", "moment.x", "moment.y", "moment.z"]
OUTPUTS = [*LOAD, "friction_power", "peak_pressure", "attraction"]


@pytest.fixture(scope="module")
def shoe() -> mtb.PreparedContact:
    scene = mtb.scenes.pole_shoe_on_rail(
        friction=0.3, magnetic_pressure=MAGNET, spacing=12e-3, attraction="both", velocity=10.0
    )
    return scene.prepare("elastic-both")


@pytest.fixture(scope="module")
def file(shoe: mtb.PreparedContact, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("magnet") / "shoe.mtbc"
    shoe.save(path, shift=True)
    return path


def lifted(z: float) -> list[float]:
    return [np.nan, np.nan, z, np.nan, np.nan, np.nan]


def same(found: mtb.ContactStep, wanted: mtb.ContactStep) -> None:
    np.testing.assert_array_equal(found.force, wanted.force)
    np.testing.assert_array_equal(found.magnetic_pressure, wanted.magnetic_pressure)
    assert found.report.magnet == wanted.report.magnet


def test_files_and_other_processes(shoe: mtb.PreparedContact, file: Path, tmp_path: Path) -> None:
    shoe.save(tmp_path / "sliding.mtbc")
    sliding, again = (mtb.PreparedContact.load(path) for path in (tmp_path / "sliding.mtbc", file))
    pickled = pickle.loads(pickle.dumps(shoe))
    contacts = [shoe.copy(), sliding, again, pickled, pickle.loads(pickle.dumps(again))]
    attractions = []
    for z, speed in RIDE:
        first, *others = (contact.step(lifted(z), speed) for contact in contacts)
        attractions.append(first.report.magnet["attraction"])
        for other in others:
            same(other, first)
    assert attractions[1] < 0.8 * attractions[2] < attractions[0]
    # another magnet, and a number in its place
    weak = replace(MAGNET, ampere_turns=800.0, yoke=None)
    for given in (weak, 1e6):
        first, *others = (contact.step(velocity=10.0, magnetic_pressure=given) for contact in contacts)
        for other in others:
            same(other, first)
    for contact in contacts[1:]:
        assert contact.magnet is not None
        for name in ("ampere_turns", "non_magnetic_gap", "yoke", "armature", "leakage", "pole_length"):
            assert getattr(contact.magnet, name) == getattr(MAGNET, name)
        assert contact.magnet.factor(20.0) == MAGNET.factor(20.0)
    sticking = [contacts[k].copy() for k in (0, 2, 3)]
    for push in (0.0, 3e-7, 3e-7, -4e-7):
        first, *others = (c.step(velocity=1.0, shift=(push, 0.0)) for c in sticking)
        for other in others:
            same(other, first)
            np.testing.assert_array_equal(other.traction, first.traction)
        if push:
            for by in ("magnetic_pressure.ampere_turns", "magnetic_pressure.yoke", "shift"):
                for other in others:
                    np.testing.assert_allclose(
                        other.derivative("force", by), first.derivative("force", by), rtol=1e-12
                    )


def test_what_a_file_does_not_know(shoe: mtb.PreparedContact, tmp_path: Path) -> None:
    scene = mtb.scenes.pole_shoe_on_rail(friction=0.3, magnetic_pressure=2e6, spacing=12e-3)
    contact = scene.prepare("elastic-upper")
    contact.save(tmp_path / "number.mtbc")
    number = mtb.PreparedContact.load(tmp_path / "number.mtbc")
    assert contact.magnet is None
    assert number.magnet is None
    with pytest.raises(ValueError, match="of a file that was written without one"):
        number.step(velocity=1.0, magnetic_pressure=MAGNET)
    with pytest.raises(ValueError, match=r"ampere_turns is 1000 A, but the scene has no Magnet"):
        contact.save_fmu(tmp_path / "no.fmu", ampere_turns=1e3)
    with pytest.raises(ValueError, match="but a magnetic_pressure takes the place of the magnet"):
        shoe.save_fmu(tmp_path / "no.fmu", ampere_turns=1e3, magnetic_pressure=1e6)
    with pytest.raises(ValueError, match="ampere_turns is -1 A: a number from 0 on"):
        shoe.save_fmu(tmp_path / "no.fmu", ampere_turns=-1.0)
    assert not (tmp_path / "no.fmu").exists()


class C:
    """The C interface, with a contact out of a file."""

    def __init__(self, library: Path, file: Path) -> None:
        self.c = by_ctypes(library)
        self.handle = ctypes.c_uint64()
        assert self.c.mtb_contact_load(str(file).encode(), ctypes.byref(self.handle)) == 0

    def message(self) -> str:
        return str(self.c.mtb_last_error_message().decode())

    def set_ampere_turns(self, value: float) -> int:
        return int(self.c.mtb_contact_set_ampere_turns(self.handle, ctypes.c_double(value)))

    def step(self, z: float, speed: float, shift: float | None = None) -> np.ndarray:
        pose, velocity = (ctypes.c_double * 6)(*lifted(z)), (ctypes.c_double * 2)(speed, 0.0)
        force, moment = (ctypes.c_double * 3)(), (ctypes.c_double * 3)()
        scene = ctypes.c_double(np.nan)
        if shift is None:
            status = self.c.mtb_contact_step(self.handle, pose, velocity, scene, force, moment, None)
        else:
            along = (ctypes.c_double * 2)(shift, 0.0)
            status = self.c.mtb_contact_step_shifted(
                self.handle, pose, velocity, along, scene, force, moment, None
            )
        assert status == 0, self.message()
        return np.array([*force, *moment])

    def attraction(self, n: int) -> tuple[np.ndarray, float]:
        pull, sum_ = (ctypes.c_double * n)(), ctypes.c_double()
        status = self.c.mtb_contact_attraction(self.handle, ctypes.c_uint64(n), pull, ctypes.byref(sum_))
        assert status == 0, self.message()
        return np.array(pull), sum_.value

    def derivatives(self, columns: int) -> tuple[np.ndarray, np.ndarray]:
        by, of = (ctypes.c_double * 9)(), (ctypes.c_double * columns)()
        status = self.c.mtb_contact_magnet_derivatives(self.handle, ctypes.c_uint64(columns), by, of)
        assert status == 0, self.message()
        return np.array(by), np.array(of)


def driven(contact: mtb.PreparedContact, ampere_turns: float) -> mtb.Magnet:
    assert contact.magnet is not None
    return replace(contact.magnet, ampere_turns=ampere_turns)


def test_c_takes_the_same_steps(shoe: mtb.PreparedContact, library: Path, file: Path) -> None:
    c, n, own = C(library, file), shoe.area.size, shoe.copy()
    for turns in (None, 2e3):
        if turns is not None:
            assert c.set_ampere_turns(turns) == 0
        for z, speed in RIDE:
            given = None if turns is None else driven(own, turns)
            here = own.step(lifted(z), speed, magnetic_pressure=given)
            np.testing.assert_array_equal(c.step(z, speed), [*here.force, *here.moment])
            pull, attraction = c.attraction(n)
            np.testing.assert_array_equal(pull, here.magnetic_pressure)
            assert attraction == pytest.approx(here.report.magnet["attraction"], rel=1e-14)
            by, of = c.derivatives(9)
            by_turns = here.gradient(["force", "moment", "friction_power", "attraction"])
            wanted = by_turns["magnetic_pressure.ampere_turns"]
            np.testing.assert_allclose(by[[*range(7), 8]], wanted, rtol=1e-9, atol=1e-9 * abs(wanted).max())
            slope = here.gradient("attraction")
            wanted = [*slope["pose"], *slope["velocity"], 0.0]
            np.testing.assert_allclose(of, wanted, rtol=1e-8, atol=1e-9 * np.abs(wanted).max())
    # switched off, and on again
    assert c.set_ampere_turns(0.0) == 0
    c.step(1e-3, 10.0)
    assert c.attraction(n)[1] == 0.0
    assert c.set_ampere_turns(np.nan) == 0
    again, wanted = c.step(1e-3, 10.0)[:3], own.step(lifted(1e-3), 10.0).force
    np.testing.assert_allclose(again, wanted, rtol=1e-9, atol=1e-9 * abs(wanted[2]))
    assert c.set_ampere_turns(-1.0) == 1
    assert "ampere_turns is -1" in c.message()
    # a step taken again from state and pull
    pull, attraction = c.attraction(n)
    state = (ctypes.c_double * n)()
    assert c.c.mtb_contact_state(c.handle, ctypes.c_uint64(n), state) == 0
    c.step(5e-3, 10.0)
    assert c.c.mtb_contact_resume(c.handle, ctypes.c_uint64(n), state) == 0
    kept = (ctypes.c_double * n)(*pull)
    assert c.c.mtb_contact_resume_attraction(c.handle, ctypes.c_uint64(n), kept) == 0
    c.step(1e-3, 10.0)
    assert c.attraction(n)[1] == pytest.approx(attraction, rel=1e-10)
    kept[0] = -1.0
    assert c.c.mtb_contact_resume_attraction(c.handle, ctypes.c_uint64(n), kept) == 1
    assert c.c.mtb_contact_free(c.handle) == 0


def test_c_sticks_and_slips_alike(shoe: mtb.PreparedContact, library: Path, file: Path) -> None:
    c, own, size = C(library, file), shoe.copy(), ctypes.c_uint64()
    assert c.c.mtb_contact_memory_size(c.handle, ctypes.byref(size)) == 0
    memory = (ctypes.c_double * size.value)()
    for k, push in enumerate((0.0, 3e-7, 3e-7, -4e-7)):
        here = own.step(velocity=1.0, shift=(push, 0.0))
        if k:
            assert c.c.mtb_contact_memory(c.handle, size, memory) == 0
        found = c.step(np.nan, 1.0, push)
        np.testing.assert_array_equal(found, [*here.force, *here.moment])
        if not k:
            continue
        by, of = c.derivatives(11)
        wanted = here.derivative(["force", "moment", "friction_work", "attraction"], MAGNET_TURNS)
        np.testing.assert_allclose(by[[*range(7), 8]], wanted, rtol=1e-8, atol=1e-9 * abs(wanted).max())
        assert of.any()
    # from the memory, which holds the pull, the same step again
    assert c.c.mtb_contact_remember(c.handle, size, memory) == 0
    np.testing.assert_allclose(c.step(np.nan, 1.0, push), found, rtol=1e-9, atol=1e-6)


MAGNET_TURNS = "magnetic_pressure.ampere_turns"


@contextmanager
def running(path: Path, folder: Path, fmi: int) -> Iterator[tuple[Any, dict[str, int]]]:
    assert validate_fmu(str(path)) == []
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    description = fmpy.read_model_description(str(path))
    given = {
        "guid": description.guid,
        "unzipDirectory": str(folder),
        "modelIdentifier": description.coSimulation.modelIdentifier,
        "instanceName": "shoe",
    }
    slave = FMU2Slave(**given) if fmi == 2 else FMU3Slave(**given)
    slave.instantiate()
    if fmi == 2:
        slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    yield slave, {v.name: v.valueReference for v in description.modelVariables}
    slave.terminate()
    slave.freeInstance()


@pytest.mark.parametrize(("fmi", "shift"), [(2, False), (3, False), (2, True), (3, True)])
def test_units_take_the_same_steps(
    shoe: mtb.PreparedContact, library: Path, tmp_path: Path, fmi: int, shift: bool
) -> None:
    names = ("libmtb_fmu.so", "libmtb_fmu.dylib", "mtb_fmu.dll")
    runtime = next(library / name for name in names if (library / name).is_file())
    path, own, dt = tmp_path / "shoe.fmu", shoe.copy(), 1e-3
    shoe.save_fmu(path, runtime, velocity=1e-4, ampere_turns=2500.0, fmi=fmi, shift=shift)
    first = driven(own, 2500.0)
    own.step(velocity=1e-4, magnetic_pressure=first, shift=(0.0, 0.0) if shift else None)
    with running(path, tmp_path / "unpacked", fmi) as (slave, at):
        assert {"ampere_turns", "attraction"} <= at.keys()
        assert "magnetic_pressure" not in at

        def put(name: str, value: float) -> None:
            (slave.setReal if fmi == 2 else slave.setFloat64)([at[name]], [value])

        def told() -> np.ndarray:
            if fmi == 2:
                return np.array(slave.getReal([at[name] for name in OUTPUTS]))
            whole = slave.getFloat64([at["force"]], nValues=3) + slave.getFloat64([at["moment"]], nValues=3)
            return np.array([*whole, *slave.getFloat64([at[name] for name in OUTPUTS[6:]])])

        def velocity(speed: float) -> None:
            if fmi == 2:
                put("velocity.x", speed)
            else:
                slave.setFloat64([at["velocity"]], [speed, 0.0])

        for k, (turns, speed) in enumerate([(2500.0, 3e-4), (1500.0, 2e-4), (3000.0, -4e-4), (3000.0, 20.0)]):
            put("ampere_turns", turns)
            velocity(speed)
            kept = slave.getFMUstate() if fmi == 2 else slave.getFMUState()
            slave.doStep(k * dt, dt)
            along = (speed * dt, 0.0) if shift else None
            here = own.step(velocity=speed, magnetic_pressure=driven(own, turns), shift=along, dt=dt)
            wanted = [*here.force, *here.moment, here.friction_power]
            found = told()
            np.testing.assert_array_equal(found[:6], wanted[:6])
            assert found[6] == pytest.approx(wanted[6], rel=1e-12)
            assert found[8] == pytest.approx(here.report.magnet["attraction"], rel=1e-14)
            if fmi == 2:
                for name, of in (("force.z", "force"), ("attraction", "attraction")):
                    slope = slave.getDirectionalDerivative([at[name]], [at["ampere_turns"]], [1.0])
                    by = np.ravel(here.derivative(of, MAGNET_TURNS))[-1]
                    assert slope[0] == pytest.approx(by, rel=1e-8)
        # from a state the same step again, the pull included
        if fmi == 2:
            slave.setFMUstate(slave.deSerializeFMUstate(slave.serializeFMUstate(kept)))
        else:
            slave.setFMUState(kept)
        slave.doStep(3 * dt, dt)
        np.testing.assert_allclose(told(), found, rtol=1e-8, atol=1e-7 * abs(found[2]))

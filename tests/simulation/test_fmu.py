# SPDX-License-Identifier: MIT OR Apache-2.0
"""Functional mock-up units: FMPy, an importer of the standard, gets the numbers of Python."""

import shutil
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave, fmi2Error, fmi2LastSuccessfulTime
from fmpy.validation import validate_fmu

import mtb_rs as mtb
from mtb_rs.simulation import fmu

pytestmark = pytest.mark.slow  # compiles units

ROOT = Path(__file__).parents[2]
LOAD = ["force.x", "force.y", "force.z", "moment.x", "moment.y", "moment.z"]
OUTPUTS = [*LOAD, "friction_power", "peak_pressure"]


@pytest.fixture(scope="session")
def library(library):
    """The one that goes into units."""
    names = ("libmtb_fmu.so", "libmtb_fmu.dylib", "mtb_fmu.dll")
    return next(library / name for name in names if (library / name).is_file())


@pytest.fixture(scope="session")
def contact():
    shoe = mtb.scenes.pole_shoe_on_rail(
        friction=mtb.VelocityTable((0.0, 10.0, 50.0), (0.4, 0.2, 0.1)), magnetic_pressure=3e6, spacing=6e-3
    )
    return shoe.prepare("elastic-upper", reference_point=(0.0, 0.0, 28.2e-3))


@pytest.fixture(scope="session")
def unit(contact, library, tmp_path_factory):
    # a folder whose address needs escapes
    path = tmp_path_factory.mktemp("a unit, 100 %") / "shoe.fmu"
    contact.save_fmu(path, library, pose={"pitch": 0.0}, velocity=20.0, magnetic_pressure=3e6)
    return path


@pytest.fixture
def slave(unit, tmp_path):
    """An instance, the references of its variables and what it logs."""
    folder = tmp_path / "ünpacked 100 %"
    with zipfile.ZipFile(unit) as archive:
        archive.extractall(folder)
    description = fmpy.read_model_description(unit)
    log = []

    def logger(environment, name, status, category, message):
        log.append(message.decode())

    callbacks = fmpy.fmi2.fmi2CallbackFunctions()
    callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(logger)
    made = FMU2Slave(
        guid=description.guid,
        unzipDirectory=str(folder),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="shoe",
    )
    made.instantiate(callbacks=callbacks)
    references = {v.name: v.valueReference for v in description.modelVariables}
    yield made, references, log
    made.terminate()
    made.freeInstance()


def test_the_description_is_valid(unit):
    assert validate_fmu(str(unit)) == []
    description = fmpy.read_model_description(str(unit))
    inputs = [v.name for v in description.modelVariables if v.causality == "input"]
    assert inputs == ["pose.pitch", "velocity.x", "velocity.y", "magnetic_pressure"]
    assert [v.name for v in description.modelVariables if v.causality == "output"] == OUTPUTS
    assert fmpy.supported_platforms(str(unit)) in (["linux64"], ["darwin64"], ["win64"])


def test_a_ride_is_that_of_python(unit, contact):
    time = np.linspace(0.0, 1.0, 21)
    signals = np.zeros(21, [("time", float), ("velocity.x", float), ("pose.pitch", float)])
    signals["time"] = time
    signals["velocity.x"] = 30.0 - 25.0 * time
    signals["pose.pitch"] = 2e-5 * np.sin(9.0 * time)
    out = fmpy.simulate_fmu(
        str(unit), stop_time=1.0, output_interval=0.05, step_size=0.05, input=signals, output=OUTPUTS
    )
    assert len(out) == 21
    own = contact.copy()
    # inputs are those of the start of a step, outputs are told at its end
    for row, speed, pitch in zip(out[1:], signals["velocity.x"], signals["pose.pitch"], strict=False):
        step = own.step([np.nan, np.nan, np.nan, np.nan, pitch, np.nan], speed, magnetic_pressure=3e6)
        told = np.array([row[name] for name in LOAD])
        np.testing.assert_allclose(told[:3], step.force, rtol=1e-9, atol=1e-9 * abs(step.force[2]))
        np.testing.assert_allclose(told[3:], step.moment, rtol=1e-9, atol=1e-9 * np.abs(step.moment).max())
        assert row["friction_power"] == pytest.approx(step.friction_power, rel=1e-9)
        assert row["peak_pressure"] == pytest.approx(step.pressure.max(), rel=1e-9)


def test_a_ride_of_bodies_of_ones_own_is_that_of_python(own_body, library, tmp_path):
    unit = tmp_path / "own.fmu"
    own_body.save_fmu(unit, library, pose={"pitch": 0.0}, velocity=20.0)
    assert validate_fmu(str(unit)) == []
    time = np.linspace(0.0, 1.0, 6)
    signals = np.zeros(
        6, [("time", float), ("velocity.x", float), ("velocity.y", float), ("pose.pitch", float)]
    )
    signals["time"], signals["velocity.x"], signals["velocity.y"] = time, 30.0 - 25.0 * time, 3.0 * time
    signals["pose.pitch"] = 2e-5 * np.sin(9.0 * time)
    out = fmpy.simulate_fmu(
        str(unit), stop_time=1.0, output_interval=0.2, step_size=0.2, input=signals, output=OUTPUTS
    )
    own, forces = own_body.copy(), []
    for row, (_, along, across, pitch) in zip(out[1:], signals, strict=False):
        step = own.step([np.nan, np.nan, np.nan, np.nan, pitch, np.nan], (along, across))
        told = np.array([row[name] for name in LOAD])
        forces.append(step.force)
        np.testing.assert_allclose(told[:3], step.force, rtol=1e-9, atol=1e-9 * abs(step.force[2]))
        np.testing.assert_allclose(told[3:], step.moment, rtol=1e-9, atol=1e-9 * np.abs(step.moment).max())
        assert row["friction_power"] == pytest.approx(step.friction_power, rel=1e-9)
        assert row["peak_pressure"] == pytest.approx(step.pressure.max(), rel=1e-9)
    # the inputs matter
    assert np.ptp(forces, axis=0)[0] > 0.1 * abs(forces[0][0])


def test_outputs_of_the_initialisation_and_states(slave, contact):
    shoe, reference, _ = slave
    own = contact.copy()
    shoe.setupExperiment(startTime=0.0)
    shoe.enterInitializationMode()
    shoe.setReal([reference["velocity.x"]], [10.0])
    before = shoe.getReal([reference[name] for name in OUTPUTS[:3]])
    # pitch stays where the description has it
    level = [np.nan, np.nan, np.nan, np.nan, 0.0, np.nan]
    first = own.step(level, 10.0, magnetic_pressure=3e6).force
    np.testing.assert_allclose(before, first, rtol=1e-9, atol=1e-9 * abs(first[2]))
    shoe.exitInitializationMode()
    state = shoe.getFMUstate()
    shoe.setReal([reference["velocity.x"]], [50.0])
    shoe.doStep(0.0, 0.1)
    later = shoe.getReal([reference[name] for name in OUTPUTS[:3]])
    assert later[0] < 0.6 * before[0]
    shoe.setFMUstate(state)
    assert shoe.getReal([reference[name] for name in OUTPUTS[:3]]) == before
    shoe.doStep(0.0, 0.1)
    again = shoe.getReal([reference[name] for name in OUTPUTS[:3]])
    np.testing.assert_allclose(again, first, rtol=1e-9, atol=1e-9 * abs(first[2]))
    shoe.freeFMUstate(state)


def test_directional_derivatives_are_those_of_python(slave, contact):
    shoe, reference, log = slave
    own = contact.copy()
    knowns = ["velocity.x", "pose.pitch", "magnetic_pressure"]
    columns = [("velocity", 0), ("pose", 4), ("magnetic_pressure", 0)]
    rows = [("force", 0), ("force", 2), ("moment", 1), ("friction_power", 0), ("peak_pressure", 0)]
    unknowns = ["force.x", "force.z", "moment.y", "friction_power", "peak_pressure"]
    shoe.setupExperiment(startTime=0.0)
    shoe.enterInitializationMode()
    shoe.setReal([reference[name] for name in knowns], [10.0, 1e-5, 2.5e6])

    def check(speed):
        step = own.step([np.nan, np.nan, np.nan, np.nan, 1e-5, np.nan], speed, magnetic_pressure=2.5e6)
        sizes = {"peak_pressure": step.pressure} | {of: getattr(step, of) for of, _ in rows[:4]}
        for known, (by, column), change in zip(knowns, columns, (10.0, 1e-5, 2.5e6), strict=True):
            told = shoe.getDirectionalDerivative(
                [reference[name] for name in unknowns], [reference[known]], [change]
            )
            for (of, row), value in zip(rows, told, strict=True):
                wanted = np.reshape(step.derivative(of, by), (np.size(getattr(step, of, 0.0)), -1))
                noise = 1e-9 * np.abs(sizes[of]).max()
                assert value == pytest.approx(change * wanted[row, column], rel=1e-8, abs=noise)

    check(10.0)
    shoe.exitInitializationMode()
    state = shoe.getFMUstate()
    shoe.setReal([reference["velocity.x"]], [30.0])
    shoe.doStep(0.0, 0.1)
    check(30.0)
    shoe.setFMUstate(state)
    check(10.0)
    shoe.freeFMUstate(state)
    for unknown, known in (("velocity.x", "velocity.x"), ("force.x", "force.x")):
        with pytest.raises(fmpy.fmi1.FMICallException):
            shoe.getDirectionalDerivative([reference[unknown]], [reference[known]], [1.0])
        assert "value reference" in log.pop()


def test_inputs_start_as_the_description_says(slave, contact):
    shoe, reference, _ = slave
    load = [reference[name] for name in LOAD]
    inputs = [reference[name] for name in ("velocity.x", "pose.pitch", "magnetic_pressure")]
    level = [np.nan, np.nan, np.nan, np.nan, 0.0, np.nan]
    step = contact.copy().step(level, 20.0, magnetic_pressure=3e6)
    for velocity in (50.0, 10.0):
        shoe.setupExperiment()
        shoe.enterInitializationMode()
        assert shoe.getReal(inputs) == [20.0, 0.0, 3e6]
        shoe.exitInitializationMode()
        told = shoe.getReal(load)
        np.testing.assert_allclose(told[:3], step.force, rtol=1e-9, atol=1e-9 * abs(step.force[2]))
        shoe.setReal(inputs[:1], [velocity])
        shoe.doStep(0.0, 0.1)
        shoe.reset()


def test_a_state_knows_whether_the_unit_is_initialised(slave):
    shoe, reference, _ = slave
    force, velocity = [reference["force.x"]], [reference["velocity.x"]]
    shoe.setupExperiment()
    shoe.enterInitializationMode()
    early = shoe.getFMUstate()
    shoe.exitInitializationMode()
    solved = shoe.getReal(force)
    shoe.setReal(velocity, [50.0])
    late = shoe.getFMUstate()
    shoe.setFMUstate(early)
    shoe.setReal(velocity, [50.0])
    # outputs follow the inputs until the initialisation ends, and steps afterwards
    faster = shoe.getReal(force)
    assert faster[0] < 0.7 * solved[0]
    shoe.setFMUstate(late)
    assert shoe.getReal(force) == solved
    for state in (early, late):
        shoe.freeFMUstate(state)


def test_what_the_description_does_not_have_is_refused(slave):
    shoe, reference, log = slave
    shoe.setupExperiment(startTime=0.0)
    shoe.enterInitializationMode()
    # pose.x, which is left to balance; an output; nothing at all
    for unknown in (0, reference["force.x"], 17, 2**32 - 1):
        with pytest.raises(fmpy.fmi1.FMICallException):
            shoe.setReal([reference["velocity.x"], unknown], [3.0, 1.0])
        assert log.pop().startswith(f"value reference {unknown}")
    with pytest.raises(fmpy.fmi1.FMICallException):
        shoe.getReal([0])
    assert "value reference 0 is no variable of this unit" in log.pop()
    for value in (np.nan, np.inf):
        with pytest.raises(fmpy.fmi1.FMICallException):
            shoe.setReal([reference["velocity.x"], reference["pose.pitch"]], [3.0, value])
        assert "a finite number is needed" in log.pop()
    # nothing of a refused call is taken
    assert shoe.getReal([reference["velocity.x"]]) == [20.0]
    shoe.exitInitializationMode()
    before = shoe.getReal([reference["force.x"]])
    for time, step in ((0.0, -0.1), (0.0, np.nan), (np.nan, 0.1), (0.0, np.inf)):
        with pytest.raises(fmpy.fmi1.FMICallException):
            shoe.doStep(time, step)
        assert "finite numbers are needed, the step not below 0" in log.pop()
    assert shoe.getReal([reference["force.x"]]) == before
    assert shoe.getRealStatus(fmi2LastSuccessfulTime) == 0.0


def test_what_goes_wrong_is_logged(slave):
    shoe, reference, log = slave
    shoe.setupExperiment()
    shoe.enterInitializationMode()
    shoe.setReal([reference["velocity.x"]], [10.0])
    shoe.exitInitializationMode()
    shoe.setReal([reference["velocity.x"]], [70.0])
    with pytest.raises(fmpy.fmi1.FMICallException):
        shoe.doStep(0.0, 0.1)
    assert log.pop() == "velocity is 70 m/s: the table of friction covers 0 to 50 m/s"
    with pytest.raises(fmpy.fmi1.FMICallException):
        shoe.setReal([reference["force.x"]], [1.0])
    assert log.pop() == "value reference 10 is no input"
    with pytest.raises(fmpy.fmi1.FMICallException):
        shoe.setInteger([0], [1])
    assert log.pop() == "fmi2SetInteger: all variables are real"
    shoe.setReal([reference["velocity.x"]], [20.0])
    shoe.doStep(0.0, 0.1)


def test_a_step_without_a_solution_is_an_error_and_not_taken_again(library, tmp_path):
    block = mtb.scenes.block_on_plane(
        width=0.1,
        height=0.5,
        spacing=2e-2,
        friction=mtb.VelocityTable((0.0, 1.0), (0.1, 1.0)),
        velocity=0.1,
    )
    path = tmp_path / "block.fmu"
    block.prepare("elastic-upper").save_fmu(path, library)
    folder = fmpy.extract(str(path), str(tmp_path / "block"))
    description = fmpy.read_model_description(str(path))
    made = FMU2Slave(
        guid=description.guid, unzipDirectory=folder, modelIdentifier="mtb_contact", instanceName="b"
    )
    made.instantiate()
    velocity = [v.valueReference for v in description.modelVariables if v.name == "velocity.x"]
    force = [v.valueReference for v in description.modelVariables if v.name == "force.z"]
    made.setupExperiment(startTime=2.0)
    made.enterInitializationMode()
    made.setReal(velocity, [0.1])
    made.exitInitializationMode()
    before = made.getReal(force)
    made.setReal(velocity, [1.0])
    with pytest.raises(fmpy.fmi1.FMICallException) as caught:
        made.doStep(2.0, 0.1)
    # inputs hold over a step, so that a shorter one, as a discarded step asks for, is no way out
    assert caught.value.status == fmi2Error
    assert made.getRealStatus(fmi2LastSuccessfulTime) == 2.0
    assert made.getReal(force) == before
    made.freeInstance()
    # an importing program comes to an end
    speed = np.array([(0.0, 0.1), (0.2, 1.0)], dtype=[("time", float), ("velocity.x", float)])
    with pytest.raises(fmpy.fmi1.FMICallException):
        fmpy.simulate_fmu(str(path), stop_time=0.4, output_interval=0.1, input=speed)


def test_a_description_of_another_version_is_refused(unit, tmp_path):
    folder = fmpy.extract(str(unit), str(tmp_path / "shoe"))
    made = FMU2Slave(
        guid="mtb-fmu-0.0.0-x", unzipDirectory=folder, modelIdentifier="mtb_contact", instanceName="shoe"
    )
    with pytest.raises(Exception, match="Failed to instantiate"):
        made.instantiate()


def test_what_cannot_be_packed(contact, library, tmp_path):
    path = tmp_path / "shoe.fmu"
    other = tmp_path / "other.so"
    other.write_bytes(b"no library")
    for wrong in (other, tmp_path / "missing.so", tmp_path, library.with_suffix(".txt")):
        with pytest.raises(ValueError, match=r"library is .*: the mtb_fmu library of version"):
            contact.save_fmu(path, wrong, velocity=20.0)
    with pytest.raises(ValueError, match="pose has 'heave': components are x, y, z, roll, pitch, yaw"):
        contact.save_fmu(path, library, pose={"heave": 0.0}, velocity=20.0)
    with pytest.raises(ValueError, match="velocity is missing"):
        contact.save_fmu(path, library)
    with pytest.raises(ValueError, match="table of friction covers 0 to 50"):
        contact.save_fmu(path, library, velocity=70.0)
    with pytest.raises(ValueError, match="it is a directory"):
        contact.save_fmu(tmp_path, library, velocity=20.0)
    assert not path.exists()


def test_without_a_library_the_message_says_where_to_get_one(contact, library, monkeypatch, tmp_path):
    monkeypatch.setattr(fmu, "PLATFORMS", {})
    with pytest.raises(ValueError, match=r"library is missing: .* `cargo build --release -p mtb-fmu`"):
        contact.save_fmu(tmp_path / "shoe.fmu", velocity=20.0)


def test_the_library_of_the_installation_is_taken(contact, library, monkeypatch, tmp_path):
    package = tmp_path / "mtb_rs"
    (package / "runtime").mkdir(parents=True)
    shutil.copy(library, package / "runtime")
    monkeypatch.setattr(fmu, "__file__", str(package / "simulation" / "fmu.py"))
    contact.save_fmu(tmp_path / "own.fmu", velocity=20.0)
    contact.save_fmu(tmp_path / "given.fmu", library, velocity=20.0)
    with zipfile.ZipFile(tmp_path / "own.fmu") as own, zipfile.ZipFile(tmp_path / "given.fmu") as given:
        binary = next(name for name in given.namelist() if name.startswith("binaries/"))
        assert own.read(binary) == given.read(binary)


def test_the_crates_readme_runs(library, tmp_path, monkeypatch):
    code = (ROOT / "rust" / "fmu" / "README.md").read_text(encoding="utf-8").split("```python\n")[1]
    code = code.split("```")[0].replace("target/release/libmtb_fmu.so", library.as_posix())
    monkeypatch.chdir(tmp_path)
    exec(code, {})
    assert validate_fmu("shoe.fmu") == []

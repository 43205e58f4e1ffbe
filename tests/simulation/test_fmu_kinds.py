# SPDX-License-Identifier: MIT OR Apache-2.0
"""Units of shoes and of wheels, by FMI 2 and by FMI 3: FMPy gets the numbers of Python from all of them."""

import ctypes
import re
import shutil
import struct
import zipfile
from dataclasses import dataclass
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy import fmi3
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

import mtb_rs as mtb
from mtb_rs.simulation import fmu

pytestmark = [
    pytest.mark.slow,  # compiles units
    pytest.mark.filterwarnings("ignore:the peak pressure is"),
]

ERROR = 3
V = 20.0
RADIUS = 0.46
POSE = ("x", "y", "z", "roll", "pitch", "yaw")
#: Numbers of a step by the attribute of Python's and their place in it.
LOAD = {
    **{f"force.{axis}": ("force", k) for k, axis in enumerate("xyz")},
    **{f"moment.{axis}": ("moment", k) for k, axis in enumerate("xyz")},
    "friction_power": ("friction_power", 0),
    "peak_pressure": ("pressure", "peak"),
}
FOUND = {"pose.z": ("pose", 2), "pose.roll": ("pose", 3)}
#: Arrays of FMI 3, and the numbers in them.
ARRAYS = {
    "pose.translation": tuple(f"pose.{name}" for name in POSE[:3]),
    "pose.rotation": tuple(f"pose.{name}" for name in POSE[3:]),
    **{
        name: tuple(f"{name}.{axis}" for axis in "xyz")
        for name in ("velocity", "angular_velocity", "force", "moment")
    },
    "vertical_force": ("vertical_force.left", "vertical_force.right"),
    "rotation": tuple(f"rotation.{axis}" for axis in "xyz"),
    **{
        f"{body}.{side}{part}": tuple(f"{body}.{side}.{number}" for number in numbers.split())
        for side in ("left", "right")
        for body, part, numbers in (
            ("rail_displacement", "", "y z"),
            ("rail", ".translation", "y z"),
            ("rail", ".velocity", "vy vz"),
            ("wheel", ".translation", "x y z"),
            ("wheel", ".rotation", "roll pitch yaw"),
            ("wheel", ".velocity", "vx vy vz"),
            ("wheel", ".angular_velocity", "wx wy wz"),
        )
    },
}
VELOCITY = (*ARRAYS["velocity"], *ARRAYS["angular_velocity"])


@dataclass
class Made:
    """A contact, the first inputs of its unit by name, its outputs, and the arrays that FMI 3 has."""

    contact: mtb.PreparedContact | mtb.PreparedWheels
    starts: dict
    outputs: dict
    arrays: dict

    def save(self, path, runtime, version):
        names = [name for name in self.starts if "velocity" in name]
        velocity = [self.starts[name] for name in names]
        pose = {name[5:]: value for name, value in self.starts.items() if name.startswith("pose.")}
        pull = {name: value for name, value in self.starts.items() if name == "magnetic_pressure"}
        speed = velocity if len(velocity) > 1 else velocity[0]
        self.contact.save_fmu(path, runtime, pose=pose, velocity=speed, **pull, fmi=version)

    def step(self, contact, inputs):
        """The step of Python."""
        if isinstance(self.contact, mtb.PreparedContact):
            pose = np.full(6, np.nan)
        else:
            pose = np.array([0.0, 0.0, np.nan, np.nan if "pose.roll" in self.outputs else 0.0, 0.0, 0.0])
        for k, name in enumerate(POSE):
            pose[k] = inputs.get(f"pose.{name}", pose[k])
        velocity = [value for name, value in inputs.items() if "velocity" in name]
        pull = {name: value for name, value in inputs.items() if name == "magnetic_pressure"}
        return contact.step(pose, velocity if len(velocity) > 1 else velocity[0], **pull)

    def numbers(self, step):
        """Its outputs."""
        sources = {"pressure": pressures(step)} | {
            of: numbers_of(step, of) for of, _ in self.outputs.values() if of != "pressure"
        }
        return {
            name: sources[of].max() if place == "peak" else sources[of][place]
            for name, (of, place) in self.outputs.items()
        }

    def derivatives(self, step):
        """Of its outputs by the inputs: {(output, input): number}."""
        peak = int(np.argmax(pressures(step)))
        found = {}
        for known in self.starts:
            by = known.split(".")[0].removeprefix("angular_")
            group = [name for name in self.starts if "velocity" in name] if by == "velocity" else [known]
            column = POSE.index(known[5:]) if by == "pose" else group.index(known)
            count = 6 if by == "pose" else len(group)
            for output, (of, place) in self.outputs.items():
                rows = np.reshape(step.derivative(of, by), (-1, count))
                found[output, known] = rows[peak if place == "peak" else place, column]
        return found


def pressures(step):
    fields = step.patches if isinstance(step, mtb.WheelStep) else [step]
    return np.concatenate([np.ravel(field.pressure) for field in fields])


def numbers_of(step, name):
    value = getattr(step, name)
    return np.ravel(list(value.values()) if isinstance(value, dict) else value)


def flipped(data, place):
    return data[:place] + bytes([data[place] ^ 1]) + data[place + 1 :]


def shoe():
    scene = mtb.scenes.pole_shoe_on_rail(
        friction=mtb.VelocityTable((0.0, 10.0, 50.0), (0.4, 0.2, 0.1)), magnetic_pressure=3e6, spacing=6e-3
    )
    contact = scene.prepare("elastic-upper", reference_point=(0.0, 0.0, 28.2e-3))
    starts = {"pose.pitch": 0.0, "velocity.x": V, "velocity.y": 0.0, "magnetic_pressure": 3e6}
    return Made(contact, starts, LOAD, {"velocity": (2,)})


def turned_shoe():
    """With all rotations as inputs, which FMI 3 joins."""
    starts = {"pose.roll": 1e-5, "pose.pitch": 0.0, "pose.yaw": 0.0, "velocity.x": V, "velocity.y": 1.0}
    return Made(shoe().contact, starts, LOAD, {"pose.rotation": (3,), "velocity": (2,)})


def wheel():
    """One wheel on a roller at a given height, as a force element."""
    scene = mtb.scenes.wheel_on_rail(force=60e3, spacing=1e-3, roller_radius=0.5)
    contact = scene.prepare(standstill_speed=0.1)
    pose = {"pose.x": 0.0, "pose.y": 0.0, "pose.z": -1e-4, "pose.yaw": 1e-3}
    motion = dict(zip(VELOCITY, (V, 0.0, 0.0, 0.0, V / RADIUS, 0.0), strict=True))
    arrays = dict.fromkeys(("pose.translation", "velocity", "angular_velocity"), (3,))
    return Made(contact, pose | motion, LOAD | {"vertical_force.left": ("vertical_force", 0)}, arrays)


def wheelset():
    """Both wheels, whose height and roll are found."""
    contact = mtb.scenes.wheel_on_rail(force=60e3, spacing=1e-3).prepare(side="both")
    sides = {name: ("vertical_force", k) for k, name in enumerate(ARRAYS["vertical_force"])}
    starts = {"pose.y": 1e-3, "pose.yaw": 2e-3, "velocity": V}
    return Made(contact, starts, LOAD | sides | FOUND, {"vertical_force": (2,)})


KINDS = {made.__name__: made for made in (shoe, turned_shoe, wheel, wheelset)}


@pytest.fixture(scope="module")
def runtime(library):
    names = ("libmtb_fmu.so", "libmtb_fmu.dylib", "mtb_fmu.dll")
    return next(library / name for name in names if (library / name).is_file())


@pytest.fixture(scope="module", params=KINDS)
def made(request):
    return KINDS[request.param]()


@pytest.fixture(scope="module", params=[2, 3])
def unit(request, made, runtime, tmp_path_factory):
    path = tmp_path_factory.mktemp("ünits 100 %") / f"fmi{request.param}.fmu"
    made.save(path, runtime, request.param)
    return path


class Slave:
    """A unit in FMPy, by the names of its numbers in both versions."""

    def __init__(self, path, folder, **changes):
        if not folder.exists():
            with zipfile.ZipFile(path) as archive:
                archive.extractall(folder)
        description = fmpy.read_model_description(path)
        self.is_3 = description.fmiVersion == "3.0"
        self.log: list[str] = []
        #: Value reference, place and size of the variable of each number.
        self.places = {}
        for variable in description.modelVariables:
            size = int(np.prod(variable.shape or (1,)))
            names = ARRAYS[variable.name][:size] if variable.shape else (variable.name,)
            for k, name in enumerate(names):
                self.places[name] = (variable.valueReference, k, size)
        guid = description.instantiationToken if self.is_3 else description.guid
        given = {"guid": guid, "unzipDirectory": str(folder), "modelIdentifier": "mtb_contact"} | changes
        if self.is_3:
            self.fmu = FMU3Slave(instanceName="unit", **given)
            self.fmu.instantiate(logMessage=lambda *said: self.log.append(said[-1].decode()))
            self.keep, self.go_back = self.fmu.getFMUState, self.fmu.setFMUState
            self.free, self.to_bytes = self.fmu.freeFMUState, self.fmu.serializeFMUState
            self.of_bytes = self.fmu.deserializeFMUState
        else:
            self.fmu = FMU2Slave(instanceName="unit", **given)
            calls = fmpy.fmi2.fmi2CallbackFunctions()
            calls.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(lambda *said: self.log.append(said[-1].decode()))
            self.fmu.instantiate(callbacks=calls)
            self.keep, self.go_back = self.fmu.getFMUstate, self.fmu.setFMUstate
            self.free, self.to_bytes = self.fmu.freeFMUstate, self.fmu.serializeFMUstate
            self.of_bytes = self.fmu.deSerializeFMUstate

    def read(self, reference, size):
        return self.fmu.getFloat64([reference], size) if self.is_3 else self.fmu.getReal([reference])

    def write(self, references, values):
        (self.fmu.setFloat64 if self.is_3 else self.fmu.setReal)(references, values)

    def get(self, names):
        """Numbers by name."""
        found = {}
        for name in names:
            reference, k, size = self.places[name]
            found[name] = self.read(reference, size)[k]
        return found

    def set(self, inputs):
        """Sets numbers by name, with one call for each variable."""
        for name, value in inputs.items():
            reference, k, size = self.places[name]
            values = self.read(reference, size)
            values[k] = value
            self.write([reference], values)

    def begin(self, start=0.0):
        if self.is_3:
            self.fmu.enterInitializationMode(startTime=start)
        else:
            self.fmu.setupExperiment(startTime=start)
            self.fmu.enterInitializationMode()

    def do(self, inputs, time=0.0):
        self.set(inputs)
        return self.fmu.doStep(time, 0.1)

    def derivatives(self, outputs, inputs):
        """{(output, input): number}, by one call for each input."""
        rows = {self.places[name][0]: self.places[name][2] for name in outputs}
        first = dict(zip(rows, np.cumsum([0, *rows.values()]), strict=False))
        found = {}
        for known in inputs:
            reference, k, size = self.places[known]
            seed = [float(k == j) for j in range(size)]
            count = (sum(rows.values()),) if self.is_3 else ()
            told = self.fmu.getDirectionalDerivative([*rows], [reference], seed, *count)
            for name in outputs:
                row, place, _ = self.places[name]
                found[name, known] = told[first[row] + place]
        return found

    def end(self):
        self.fmu.terminate()
        self.fmu.freeInstance()


@pytest.fixture
def slave(unit, tmp_path):
    made = Slave(unit, tmp_path / "ünpacked 100 %")
    yield made
    made.end()


def ride(made):
    """Inputs of some instants."""
    for k in range(1, 6):
        yield {
            name: value * (1.0 - 0.05 * k) if "velocity" in name else value + 1e-6 * k * ("pose" in name)
            for name, value in made.starts.items()
        }


def close(told, wanted, rtol=1e-12):
    """Relative to the largest number of its kind."""
    assert set(told) == set(wanted)
    for name, value in wanted.items():
        kin = [abs(v) for n, v in wanted.items() if n.split(".")[0] == name.split(".")[0]]
        assert told[name] == pytest.approx(value, rel=rtol, abs=rtol * max(kin)), name


def test_the_description_is_valid(unit, made):
    assert validate_fmu(str(unit)) == []
    description = fmpy.read_model_description(str(unit))
    arrays = {v.name: v.shape for v in description.modelVariables if v.shape}
    if description.fmiVersion == "2.0":
        assert arrays == {}
        numbers = {v.name: v for v in description.modelVariables}
        assert set(numbers) == {*made.starts, *made.outputs}
        assert {name for name, v in numbers.items() if v.causality == "input"} == set(made.starts)
        assert fmpy.supported_platforms(str(unit)) in (["linux64"], ["darwin64"], ["win64"])
    else:
        assert arrays == {"force": (3,), "moment": (3,)} | made.arrays
        with zipfile.ZipFile(unit) as archive:
            assert any(name.startswith(f"binaries/{fmpy.platform_tuple}/") for name in archive.namelist())
        (time,) = (v for v in description.modelVariables if v.causality == "independent")
        assert (time.name, time.unit) == ("time", "s")


def test_a_ride_is_that_of_python(slave, made):
    own = made.contact.copy()
    slave.begin()
    close(slave.get(made.outputs), made.numbers(made.step(own, made.starts)))
    slave.fmu.exitInitializationMode()
    forces = []
    for k, inputs in enumerate(ride(made)):
        slave.do(inputs, 0.1 * k)
        step = made.step(own, inputs)
        close(slave.get(made.outputs), made.numbers(step))
        assert slave.get(inputs) == inputs
        forces.append(step.force)
    # the inputs matter
    assert np.ptp(forces, axis=0).max() > 1e-4 * np.abs(forces).max()


def test_fmpy_simulates_with_arrays(unit, made):
    description = fmpy.read_model_description(str(unit))
    name = "pose.rotation" if "pose.rotation" in made.arrays else "velocity"
    if description.fmiVersion == "2.0":
        pytest.skip("variables of FMI 2 are single numbers, of which test_fmu.py makes a ride")
    shapes = {v.name: v.shape for v in description.modelVariables}
    numbers = ARRAYS[name][: shapes[name][0]] if shapes[name] else (name,)
    first = np.array([made.starts[number] for number in numbers])
    signals = np.zeros(4, [("time", float), (name, float, shapes[name] or ())])
    signals["time"] = [0.0, 0.1, 0.2, 0.3]
    rows = first * np.array([[1.0], [0.9], [0.8], [0.7]])
    signals[name] = rows if shapes[name] else rows[:, 0]
    out = fmpy.simulate_fmu(str(unit), stop_time=0.3, output_interval=0.1, step_size=0.1, input=signals)
    own = made.contact.copy()
    made.step(own, made.starts)  # the initialisation
    for row, values in zip(out[1:], rows, strict=False):
        step = made.step(own, made.starts | dict(zip(numbers, values, strict=True)))
        np.testing.assert_allclose(row["force"], step.force, rtol=1e-12, atol=1e-12 * abs(step.force[2]))
        np.testing.assert_allclose(row["moment"], step.moment, rtol=1e-12, atol=1e-12 * abs(step.force[2]))


def test_derivatives_are_those_of_python(slave, made):
    def check(step, rtol=1e-8):
        told, wanted = slave.derivatives(made.outputs, made.starts), made.derivatives(step)
        numbers = made.numbers(step)
        for (output, known), value in wanted.items():
            # some are zero: against the output, at a change of the input as large as it is, or 0.1 mm
            kind = output.split(".")[0].removeprefix("vertical_")
            size = max(abs(number) for name, number in numbers.items() if kind in name)
            change = 1e-4 if "pose" in known else {"magnetic_pressure": 3e6}.get(known, V)
            noise = 0.1 * rtol * size / change
            assert told[output, known] == pytest.approx(value, rel=rtol, abs=noise), (output, known)

    own = made.contact.copy()
    slave.begin()
    first = made.step(own, made.starts)
    check(first)
    slave.fmu.exitInitializationMode()
    state = slave.keep()
    *_, last = ride(made)
    slave.do(last)
    check(made.step(own, last))
    # after a return the step is taken again from its memory, to its own accuracy; the outputs stay
    slave.go_back(state)
    then = slave.get(made.outputs)
    check(first, rtol=1e-6)
    assert slave.get(made.outputs) == then
    slave.free(state)


def test_adjoint_derivatives_are_the_transpose(slave, made):
    if not slave.is_3:
        pytest.skip("FMI 2 has none")
    slave.begin()
    matrix = slave.derivatives(made.outputs, made.starts)
    outputs = {reference: size for reference, _, size in (slave.places[n] for n in made.outputs)}
    seed = dict(zip(made.outputs, np.random.default_rng(1).normal(size=len(made.outputs)), strict=True))
    flat = [0.0] * sum(outputs.values())
    first = dict(zip(outputs, np.cumsum([0, *outputs.values()]), strict=False))
    for name, weight in seed.items():
        reference, k, _ = slave.places[name]
        flat[first[reference] + k] = weight
    for known in made.starts:
        reference, k, size = slave.places[known]
        told = slave.fmu.getAdjointDerivative([*outputs], [reference], flat, size)[k]
        wanted = [seed[name] * matrix[name, known] for name in made.outputs]
        assert told == pytest.approx(sum(wanted), rel=1e-12, abs=1e-12 * np.abs(wanted).max())


def test_a_state_and_its_bytes_bring_all_back(slave, made, unit, tmp_path):
    first, *_, last = ride(made)
    slave.begin(2.0)
    slave.fmu.exitInitializationMode()
    slave.do(first, 2.0)
    here = slave.get(made.outputs)
    state = slave.keep()
    data = slave.to_bytes(state)
    slave.do(last, 2.1)
    there = slave.get(made.outputs)
    assert there != here
    slave.go_back(state)
    assert slave.get([*made.outputs, *made.starts]) == here | first
    slave.do(last, 2.1)
    close(slave.get(made.outputs), there, rtol=1e-6)
    # in another instance, as in another process
    other = Slave(unit, tmp_path / "other")
    read = other.of_bytes(data)
    other.go_back(read)
    assert other.get([*made.outputs, *made.starts]) == here | first
    other.do(last, 2.1)
    close(other.get(made.outputs), there, rtol=1e-6)
    other.free(read)
    # what is no state of this unit
    for damaged in (data[:-1], data[:30], b"x" * 40, flipped(data, 60)):
        with pytest.raises(FMICallException):
            other.of_bytes(damaged)
        assert "the bytes are no state of a unit" in other.log.pop()
    other.end()
    slave.free(state)


def test_a_ride_goes_on_from_its_memory(unit, made, tmp_path):
    """The next step starts from the last one: it takes the iterations of a warm start, and the same place."""
    slave = Slave(unit, tmp_path / "unit")
    slave.begin()
    slave.fmu.exitInitializationMode()
    warm = made.contact.copy()
    made.step(warm, made.starts)
    *_, last = ride(made)
    slave.do(last)
    step = made.step(warm, last)
    close(slave.get(made.outputs), made.numbers(step))
    # without the memory the last digits are others where the solution is iterated
    cold = made.numbers(made.step(made.contact.copy(), last))
    close(cold, made.numbers(step), rtol=1e-6)
    if isinstance(step, mtb.WheelStep):
        assert cold != made.numbers(step)
    slave.end()


def test_reset_is_as_just_made(slave, made):
    slave.begin()
    first = slave.get(made.outputs)
    slave.fmu.exitInitializationMode()
    *_, last = ride(made)
    slave.do(last)
    slave.fmu.reset()
    slave.begin()
    assert slave.get([*made.outputs, *made.starts]) == first | made.starts


def test_hostile_numbers_are_refused_in_words(slave, made):
    slave.begin()
    known = next(iter(made.starts))
    reference, _, size = slave.places[known]
    output = slave.places["force.x"][0]
    most = slave.places["force.x"][2]
    for references, values, words in (
        ([reference], [np.nan] * size, "a finite number is needed"),
        ([reference], [np.inf] * size, "a finite number is needed"),
        ([output], [1.0] * most, f"value reference {output} is no input"),
        ([2**32 - 1], [1.0], "value reference 4294967295 is no variable of this unit"),
        ([reference, 99], [1.0] * (size + 1), "value reference 99 is no variable of this unit"),
    ):
        with pytest.raises(FMICallException) as caught:
            slave.write(references, values)
        assert caught.value.status == ERROR
        assert words in slave.log.pop()
    with pytest.raises(FMICallException):
        slave.read(99, 1)
    assert "value reference 99 is no variable of this unit" in slave.log.pop()
    assert slave.get(made.starts) == made.starts
    slave.fmu.exitInitializationMode()
    before = slave.get(made.outputs)
    for time, step in ((0.0, -0.1), (0.0, np.nan), (np.nan, 0.1), (0.0, np.inf)):
        with pytest.raises(FMICallException):
            slave.fmu.doStep(time, step)
        assert "finite numbers are needed, the step not below 0" in slave.log.pop()
    for unknowns, knowns in (([reference], [reference]), ([output], [output]), ([99], [reference])):
        with pytest.raises(FMICallException):
            slave.fmu.getDirectionalDerivative(unknowns, knowns, [1.0])
        assert "value reference" in slave.log.pop()
    # a pose beyond all tables, and a speed
    far = {name: 1e3 for name in made.starts if "velocity" in name or "pose" in name}
    with pytest.raises(FMICallException):
        slave.do(far)
    assert slave.log
    assert slave.get(made.outputs) == before
    slave.set(made.starts)
    slave.fmu.doStep(0.0, 0.1)
    close(slave.get(made.outputs), before, rtol=1e-6)


def test_wrong_sizes_are_refused(slave, made):
    if not slave.is_3:
        pytest.skip("in FMI 2 each variable has one number")
    slave.begin()
    force = slave.places["force.x"][0]
    known = next(iter(made.starts))
    reference, _, size = slave.places[known]
    for count in (0, 1, 2, 4):
        with pytest.raises(FMICallException):
            slave.read(force, count)
        assert slave.log.pop() == f"values has room for {count} numbers: these variables have 3"
    with pytest.raises(FMICallException):
        slave.write([reference], [1.0] * (size + 1))
    assert slave.log.pop() == f"values has {size + 1} numbers: these variables have {size}"
    with pytest.raises(FMICallException):
        slave.fmu.getDirectionalDerivative([force], [reference], [1.0] * (size + 1), 3)
    assert slave.log.pop() == f"seed has {size + 1} numbers: these variables have {size}"
    with pytest.raises(FMICallException):
        slave.fmu.getDirectionalDerivative([force], [reference], [1.0] * size, 2)
    assert slave.log.pop() == "sensitivity has room for 2 numbers: these variables have 3"
    with pytest.raises(FMICallException):
        slave.fmu.getAdjointDerivative([force], [reference], [1.0] * 2, size)
    assert slave.log.pop() == "seed has 2 numbers: these variables have 3"


def test_a_wrong_token_and_wrong_files_are_refused(unit, made, tmp_path):
    heard: list[str] = []

    def refused(folder, words, **changes):
        with pytest.raises(Exception, match="Failed to instantiate"):
            Quiet(unit, folder, heard, **changes)
        assert words in heard[-1], heard

    folder = tmp_path / "unit"
    refused(folder, "is needed, as the version of mtb_rs", guid="mtb-fmu-0.0.0-x")
    refused(folder, "is needed, as the version of mtb_rs", guid="")
    (file,) = (path for path in (folder / "resources").iterdir() if path.suffix != ".txt")
    variables = folder / "resources" / "variables.txt"
    data, lines = file.read_bytes(), variables.read_text()
    for damaged in (b"", data[:100], data[:-1], flipped(data, 0), flipped(data, 99)):
        file.write_bytes(damaged)
        refused(folder, file.name)
    file.write_bytes(data)
    for line in ("input 0 nan", "input 99 1.0", "output 0 1", "output 9 99", "else", "input 0"):
        variables.write_text(f"{lines}{line}\n")
        refused(folder, f"variables.txt: {line!r}".replace("'", '"'))
    variables.write_bytes(b"\xff\xfe")
    refused(folder, "variables.txt")
    variables.unlink()
    refused(folder, "variables.txt")
    file.unlink()
    refused(folder, "contact.mtbc or wheels.mtbw or transient_wheels.mtbw is needed")


class Quiet(Slave):
    """A unit that says why it cannot be made to a list of the caller."""

    def __init__(self, path, folder, heard, **changes):
        self.heard = heard
        super().__init__(path, folder, **changes)

    @property
    def log(self):
        return self.heard

    @log.setter
    def log(self, _):
        pass


def test_a_unit_of_arrays_is_none_of_fmi_2(unit, made, tmp_path):
    if fmpy.read_model_description(str(unit)).fmiVersion == "2.0":
        pytest.skip("it is one")
    folder = Path(fmpy.extract(str(unit), str(tmp_path / "unit")))
    (binary,) = (folder / "binaries").glob("*/*")
    heard: list[str] = []
    guid = fmpy.read_model_description(str(unit)).instantiationToken
    shutil.copytree(binary.parent, folder / "binaries" / fmpy.platform)
    old = FMU2Slave(
        guid=guid, unzipDirectory=str(folder), modelIdentifier="mtb_contact", libraryPath=str(binary)
    )
    calls = fmpy.fmi2.fmi2CallbackFunctions()
    calls.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(lambda *said: heard.append(said[-1].decode()))
    with pytest.raises(Exception, match="Failed to instantiate"):
        old.instantiate(callbacks=calls)
    assert heard == ["variables of this unit are arrays: its description is of FMI 3"]


def test_other_ways_to_simulate_are_refused_in_words(runtime, tmp_path):
    made = wheel()
    heard: list[str] = []
    for version in (2, 3):
        path = tmp_path / f"{version}.fmu"
        made.save(path, runtime, version)
        folder = fmpy.extract(str(path), str(tmp_path / f"unit {version}"))
        description = fmpy.read_model_description(str(path))
        guid = description.instantiationToken or description.guid
        given = {"guid": guid, "unzipDirectory": folder, "modelIdentifier": "mtb_contact"}
        log = {"logMessage": lambda *said: heard.append(said[-1].decode())}

        def refused(unit, words, **how):
            with pytest.raises(Exception, match="Failed to instantiate"):
                unit.instantiate(**how)
            assert words in heard.pop()

        if version == 3:
            named = {"instanceName": "unit"} | given
            refused(fmi3.FMU3Model(**named), "asked for model exchange", **log)
            refused(fmi3.FMU3ScheduledExecution(**named), "asked for scheduled execution", **log)
            refused(FMU3Slave(**named), "asked for an event mode", eventModeUsed=True, **log)
            within = {"requiredIntermediateVariables": [0], "intermediateUpdate": lambda *_: None}
            refused(FMU3Slave(**named), "asked for variables within a step", **within, **log)
            continue
        calls = fmpy.fmi2.fmi2CallbackFunctions()
        calls.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(lambda *said: heard.append(said[-1].decode()))
        resources = (Path(folder) / "resources").as_uri().encode()
        asked = (b"unit", fmpy.fmi2.fmi2ModelExchange, guid.encode(), resources, ctypes.byref(calls), 0, 0)
        assert not FMU2Slave(**given).fmi2Instantiate(*asked)
        assert "asked for model exchange" in heard.pop()


def test_a_lifted_wheel_carries_nothing(runtime, tmp_path):
    made = wheel()
    for version in (2, 3):
        path = tmp_path / f"{version}.fmu"
        made.save(path, runtime, version)
        slave = Slave(path, tmp_path / f"unit {version}")
        slave.begin()
        slave.set({"pose.z": 0.01})
        slave.fmu.exitInitializationMode()
        assert set(slave.get(made.outputs).values()) == {0.0}
        assert set(slave.derivatives(made.outputs, made.starts).values()) == {0.0}
        slave.end()


def test_every_function_of_the_standard_answers(slave):
    """Those that make no sense for a contact refuse in words, and no null pointer does harm."""
    source = Path((fmi3 if slave.is_3 else fmpy.fmi2).__file__).read_text(encoding="utf-8")
    names = set(re.findall(r'_call\(\s*"(fmi[23]\w+)"', source))
    names |= {f"fmi{2 + slave.is_3}{name}" for name in ("FreeInstance", "Reset", "Terminate", "DoStep")}
    of_exchange = {
        "GetDerivatives",
        "GetEventIndicators",
        "GetContinuousStates",
        "SetTime",
        "SetContinuousStates",
    }
    of_exchange |= {
        "EnterEventMode",
        "NewDiscreteStates",
        "EnterContinuousTimeMode",
        "CompletedIntegratorStep",
    }
    of_exchange |= {"GetNominalsOfContinuousStates"}
    if not slave.is_3:
        names -= {f"fmi2{name}" for name in of_exchange}
    assert len(names) > (60 if slave.is_3 else 5)
    library = ctypes.CDLL(slave.fmu.dll._name)  # whose functions take what they are given
    for name in sorted(names):
        function = getattr(library, name)
        if any(word in name for word in ("GetVersion", "TypesPlatform", "FreeInstance", "Instantiate")):
            continue
        del slave.log[:]
        # null for all that follows the unit
        nothing = [ctypes.c_void_p()] * 11
        status = function(ctypes.c_void_p(slave.fmu.component), *nothing)
        assert status in (0, ERROR, 2), name
        assert (status == 0) == (slave.log == []), name
        assert function(ctypes.c_void_p(), *nothing) == ERROR, name


def test_a_wheel_beyond_its_profile_is_an_error_and_the_ride_goes_on(runtime, tmp_path):
    made = wheelset()
    for version in (2, 3):
        path = tmp_path / f"{version}.fmu"
        made.save(path, runtime, version)
        slave = Slave(path, tmp_path / f"unit {version}")
        slave.begin()
        slave.fmu.exitInitializationMode()
        before = slave.get(made.outputs)
        with pytest.raises(FMICallException) as caught:
            slave.do({"pose.y": 0.06})
        assert caught.value.status == ERROR
        with pytest.raises(ValueError, match="profile") as own:
            made.step(made.contact.copy(), made.starts | {"pose.y": 0.06})
        assert slave.log.pop() == str(own.value)
        assert slave.get(made.outputs) == before
        slave.do({"pose.y": 1e-3})
        close(slave.get(made.outputs), before, rtol=1e-6)
        # at rest friction has no direction
        with pytest.raises(FMICallException):
            slave.do({"velocity": 0.0})
        assert "standstill_speed" in slave.log.pop()
        slave.end()


def test_what_wheels_find_is_an_output(runtime, tmp_path):
    both = wheelset().contact
    one = wheel().contact
    for contact, pose, found in (
        (both, None, {"pose.z", "pose.roll"}),
        (both, {"roll": 0.0}, {"pose.z"}),
        (both, {"z": -1e-4}, set()),
        (one, None, {"pose.z"}),
        (one, {"z": -1e-4, "roll": 0.0}, set()),
    ):
        path = tmp_path / "wheels.fmu"
        contact.save_fmu(path, runtime, pose=pose, velocity=V)
        description = fmpy.read_model_description(str(path))
        told = {v.name for v in description.modelVariables if v.causality == "output" and "pose" in v.name}
        assert told == found
        sides = {v.name for v in description.modelVariables if v.name.startswith("vertical_force")}
        assert sides == {f"vertical_force.{side}" for side in contact.sides}
        out = fmpy.simulate_fmu(str(path), stop_time=0.1, output_interval=0.1)
        given = {} if pose is None else pose
        place = [0.0, 0.0, np.nan, np.nan if "pose.roll" in found else 0.0, 0.0, 0.0]
        place = [given.get(name, value) for name, value in zip(POSE, place, strict=True)]
        step = contact.copy().step(place, V)
        assert out["force.z"][0] == pytest.approx(step.force[2], rel=1e-12)
        for name in found:
            assert out[name][0] == pytest.approx(step.pose[POSE.index(name[5:])], rel=1e-12, abs=1e-18)


@pytest.mark.parametrize("version", [2, 3])
def test_wheels_under_forces(version, runtime, tmp_path):
    """A wheelset that is pushed and brakes on rails with springs; one that is pushed; with derivatives."""
    scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=1.5e-3)
    soft = scene.prepare(side="both", rail_stiffness=(2e7, 5e7))
    both = {"lateral_force": 5e3, "longitudinal_force": 3e3, "curvature": 1e-3}
    bent = {"left": (0.0, 0.0, 0.0, 0.0, 0.0, 1e-4)}
    moved = {"right": (1e-4, 0.0, 0.0, 0.0, 1e-3, 0.0)}
    path = tmp_path / "pushed.fmu"
    soft.save_fmu(path, runtime, {"yaw": 1e-3}, V, version, **both, rails=moved, wheels=bent)
    assert validate_fmu(str(path)) == []
    slave = Slave(path, tmp_path / "pushed")
    slave.begin()
    slave.fmu.exitInitializationMode()
    own = soft.copy()
    pose = np.array([0.0, np.nan, np.nan, np.nan, 0.0, 1e-3])
    own.step(pose, V, **both, rails=moved, wheels=bent)
    changed = both | {"lateral_force": 7e3, "longitudinal_force": -2e3}
    slave.do({**changed, "rail.right.y": 3e-4, "wheel.left.yaw": -2e-4})
    bent, moved = {"left": (0.0,) * 5 + (-2e-4,)}, {"right": (3e-4, 0.0, 0.0, 0.0, 1e-3, 0.0)}
    step = own.step(pose, V, **changed, rails=moved, wheels=bent)
    told = slave.get(["force.x", "force.y", "pose.y", "pose.z", "pose.roll", "rotation.y"])
    wanted = [*step.force[:2], *step.pose[1:4], step.velocity[4]]
    assert list(told.values()) == pytest.approx(wanted, rel=1e-9)
    assert list(told.values())[:2] == pytest.approx([-2e3, 7e3], abs=1e-2)
    displaced = slave.get([f"rail_displacement.{side}.{c}" for side in ("left", "right") for c in "yz"])
    assert list(displaced.values()) == pytest.approx(
        np.ravel(list(step.rail_displacement.values())), rel=1e-9
    )
    rails = [f"rail_displacement.{side}.{c}" for side in ("left", "right") for c in "yz"]
    turns = [f"rotation.{c}" for c in "xyz"]
    outputs = {"force.x": ("force", 0), "pose.y": ("pose", 1), "pose.roll": ("pose", 3)}
    outputs |= {name: ("velocity", 3 + k) for k, name in enumerate(turns)}
    outputs |= {name: ("rail_displacement", k) for k, name in enumerate(rails)}
    inputs = {name: (name, 0) for name in ("velocity", *both)} | {
        "pose.yaw": ("pose", 5),
        "rail.right.y": ("rails.right", 0),
        "rail.right.wx": ("rails.right", 5),
        "wheel.left.yaw": ("wheels.left", 5),
        "wheel.left.wz": ("wheels.left", 11),
    }
    for (output, known), value in slave.derivatives([*outputs], [*inputs]).items():
        (of, row), (by, column) = outputs[output], inputs[known]
        size = numbers_of(step, of).size
        derivative = np.reshape(step.derivative(of, by), (size, -1))
        wanted = derivative[row, column]
        # of steps of their own, which end where rounding lets them
        assert value == pytest.approx(wanted, rel=1e-4, abs=1e-5 * np.abs(derivative).max()), (output, known)
    slave.end()
    hard = scene.prepare(side="both")
    hard.save_fmu(path, runtime, {"yaw": 1e-3}, V, version, lateral_force=5e3)
    slave = Slave(path, tmp_path / "hard")
    slave.begin()
    slave.fmu.exitInitializationMode()
    step = hard.copy().step(pose, V, lateral_force=5e3)
    told = slave.derivatives(
        ["force.y", "force.x", "pose.y", "friction_power"], ["lateral_force", "pose.yaw"]
    )
    assert told["force.y", "lateral_force"] == pytest.approx(1.0, rel=1e-6)
    for (output, known), value in told.items():
        of, _, part = output.partition(".")
        by, _, component = known.partition(".")
        row = {"": 0, "x": 0, "y": 1}[part]
        rows = np.atleast_1d(step.derivative(of, by))
        wanted = rows[row] if by == "lateral_force" else np.reshape(rows, (-1, 6))[row, POSE.index(component)]
        assert value == pytest.approx(wanted, rel=1e-6, abs=1e-12 if of == "pose" else 1e-6)
    slave.end()


def test_what_cannot_be_packed(runtime, tmp_path):
    contact = wheel().contact
    path = tmp_path / "wheel.fmu"
    for given, words in (
        ({"velocity": V, "fmi": 1}, "fmi is 1: 2 or 3, the version of the standard, is needed"),
        ({"velocity": V, "fmi": True}, "fmi is True: 2 or 3"),
        ({"velocity": V, "fmi": "2"}, "fmi is '2': 2 or 3"),
        ({}, "velocity is missing"),
        ({"velocity": (V, 0.0)}, "a number or .vx, vy, vz, wx, wy, wz. is needed"),
        ({"velocity": V, "pose": {"heave": 0.0}}, "pose has 'heave': components are x, y, z, roll"),
        ({"velocity": V, "pose": {"y": np.nan}}, "a finite number is needed"),
        ({"velocity": V, "pose": (0.0,) * 6}, "a mapping from x, y, z"),
        ({"velocity": V, "pose": {"y": -0.1}}, "the bodies never touch"),
        ({"velocity": V, "lateral_force": 1e3, "pose": {"y": 0.0}}, "lateral_force is given: y and z"),
        ({"velocity": V, "rails": {"right": (0.0, 0.0, 0.0)}}, "rails is"),
    ):
        with pytest.raises(ValueError, match=words):
            contact.save_fmu(path, runtime, **given)
    with pytest.raises(ValueError, match="it is a directory"):
        contact.save_fmu(tmp_path, runtime, velocity=V)
    assert not path.exists()


def packed_3(library):
    return fmu.packed(fmu.SLIDING, b"", library, "unit", np.zeros(3), {"velocity.x": 1.0}, fmi=3)


def test_the_folder_of_a_library_is_that_of_its_processor(tmp_path):
    fitting = f"mtb-fmu-{mtb.__version__}-".encode()
    heads = {
        ".so": (lambda code: b"\x7fELF" + bytes(14) + struct.pack("<H", code), (62, 183), "linux"),
        ".dylib": (lambda code: struct.pack("<II", 0xFEEDFACF, code), (0x01000007, 0x0100000C), "darwin"),
        ".dll": (
            lambda code: b"MZ" + bytes(58) + struct.pack("<I", 64) + b"PE\0\0" + struct.pack("<H", code),
            (0x8664, 0xAA64),
            "windows",
        ),
    }
    for suffix, (head, codes, system) in heads.items():
        library = tmp_path / f"mtb_fmu{suffix}"
        for code, processor in zip(codes, ("x86_64", "aarch64"), strict=True):
            library.write_bytes(head(code) + fitting)
            path = tmp_path / "unit.fmu"
            path.write_bytes(packed_3(library))
            names = zipfile.ZipFile(path).namelist()
            assert f"binaries/{processor}-{system}/mtb_contact{suffix}" in names
        library.write_bytes(head(3) + fitting)
        with pytest.raises(ValueError, match="compiled for x86_64 or aarch64 is needed for FMI 3"):
            packed_3(library)

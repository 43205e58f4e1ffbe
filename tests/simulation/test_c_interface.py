# SPDX-License-Identifier: MIT OR Apache-2.0
"""The C interface: programs in C and Fortran, compiled here, give the numbers of Python."""

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb

pytestmark = pytest.mark.slow  # compiles programs

ROOT = Path(__file__).parents[2]
CAPI = ROOT / "rust" / "capi"
LINK = ["-lmtb_capi", "-lm", "-lpthread", "-ldl"]


@pytest.fixture(scope="session")
def contact(tmp_path_factory):
    """A prepared contact and its file."""
    shoe = mtb.scenes.pole_shoe_on_rail(
        friction=mtb.VelocityTable((0.0, 10.0, 50.0), (0.4, 0.2, 0.1)),
        magnetic_pressure=mtb.VelocityTable((0.0, 60.0), (3e6, 1.5e6)),
        spacing=6e-3,
    )
    prepared = shoe.prepare("elastic-upper", reference_point=(0.0, 0.0, 28.2e-3))
    path = tmp_path_factory.mktemp("capi") / "shoe.mtbc"
    prepared.save(path)
    return prepared, path


@pytest.fixture(scope="session")
def wheels(tmp_path_factory):
    """A prepared wheelset and its file."""
    scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=1e-3)
    prepared = scene.prepare(side="both", friction=mtb.FallingFriction(0.35, 0.25, 0.5))
    path = tmp_path_factory.mktemp("capi") / "wheelset.mtbw"
    prepared.save(path)
    return prepared, path


def compiler(name):
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"{name} is not installed")
    return found


def run(program, library, *arguments):
    environment = {"LD_LIBRARY_PATH": str(library), "PATH": "/usr/bin:/bin"}
    return subprocess.run(
        [program, *map(str, arguments)], env=environment, capture_output=True, text=True, check=False
    )


def check_ride(text, prepared):
    lines = text.splitlines()
    rows = np.array([[float(v) for v in line.split()] for line in lines[:20]])
    own = prepared.copy()
    for speed, pitch, *load in rows:
        step = own.step([np.nan, np.nan, np.nan, np.nan, pitch, np.nan], speed)
        np.testing.assert_allclose(load[:3], step.force, rtol=1e-12, atol=1e-12 * abs(step.force[2]))
        size = np.abs(step.moment).max()
        np.testing.assert_allclose(load[3:], step.moment, rtol=1e-12, atol=1e-12 * size)
    pressure = np.array([float(line) for line in lines[20:]])
    np.testing.assert_allclose(pressure, step.pressure, rtol=1e-12, atol=1e-12 * step.pressure.max())


def in_c(name, library, folder):
    """An example, compiled."""
    program = folder / name
    flags = ["-std=c11", "-Wall", "-Wextra", "-Werror", "-O1", "-D_POSIX_C_SOURCE=200809L"]
    source = [str(CAPI / "examples" / f"{name}.c"), f"-I{CAPI / 'include'}", f"-L{library}"]
    subprocess.run([compiler("gcc"), *flags, *source, *LINK, "-o", str(program)], check=True)
    return program


def in_fortran(name, library, folder, source=None):
    """A program of the examples, or of a `source` that is given as text."""
    program = folder / name
    if source is None:
        written = CAPI / "examples" / f"{name}.f90"
    else:
        written = folder / f"{name}.f90"
        written.write_text(source, encoding="utf-8")
    sources = [str(CAPI / "fortran" / "mtb.f90"), str(written)]
    flags = ["-std=f2008", "-Wall", "-O1", f"-J{folder}", f"-L{library}"]
    subprocess.run([compiler("gfortran"), *flags, *sources, *LINK, "-o", str(program)], check=True)
    return program


def by_ctypes(library):
    """The shared library in its folder."""
    names = ("libmtb_capi.so", "libmtb_capi.dylib", "mtb_capi.dll")
    c = ctypes.CDLL(str(next(library / name for name in names if (library / name).is_file())))
    c.mtb_last_error_message.restype = ctypes.c_char_p
    return c


LANGUAGES = pytest.mark.parametrize("compiled", [in_c, in_fortran], ids=["C", "Fortran"])


@LANGUAGES
def test_a_program_that_brakes(compiled, library, contact, tmp_path):
    prepared, path = contact
    program = compiled("ride", library, tmp_path)
    done = run(program, library, path)
    assert done.returncode == 0, done.stderr
    check_ride(done.stdout, prepared)
    missing = run(program, library, tmp_path / "none.mtbc")
    assert missing.returncode == 2
    assert "none.mtbc: No such file or directory" in missing.stderr


@LANGUAGES
def test_a_program_that_brakes_with_bodies_of_ones_own(compiled, library, own_body, tmp_path):
    path = tmp_path / "own.mtbc"
    own_body.save(path)
    done = run(compiled("ride", library, tmp_path), library, path)
    assert done.returncode == 0, done.stderr
    check_ride(done.stdout, own_body)


@LANGUAGES
@pytest.mark.parametrize("is_mapped", [False, True])
def test_a_program_that_runs_on_wheels(is_mapped, compiled, library, wheels, contact, tmp_path):
    prepared, path = wheels
    if is_mapped:
        along, across = [0.0, 7.0, 20.0], [-20e-3, 0.0, 10e-3]
        mu = [[0.1, 0.4, 0.2], [0.4, 0.1, 0.3], [0.2, 0.3, 0.1]]
        scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=1e-3)
        prepared = scene.prepare(side="both", friction=mtb.RailFriction(across, mu, along))
        path = tmp_path / "mapped.mtbw"
        prepared.save(path)
    program = compiled("wheelset", library, tmp_path)
    done = run(program, library, path)
    assert done.returncode == 0, done.stderr
    lines = [[float(v) for v in line.split()] for line in done.stdout.splitlines()]
    own, speed, wave = prepared.copy(), 30.0, 2.0 * np.pi / 20.0
    spin = speed / prepared.reference_point[2]
    for way, y, yaw, height, roll, *load, power, patches in lines[:20]:
        velocity = [speed, speed * yaw, 0.0, -spin * yaw, spin, -(wave**2) * speed * y]
        pose = [way, y, np.nan, np.nan, 0.0, yaw]
        velocity[5] += spin * own.step(pose, velocity).pose[3]
        step = own.step(pose, velocity)
        assert (height, roll) == pytest.approx(tuple(step.pose[2:4]), rel=1e-9, abs=1e-15)
        size = np.abs(step.force).max()
        np.testing.assert_allclose(load[:3], step.force, rtol=1e-9, atol=1e-9 * size)
        np.testing.assert_allclose(load[3:], step.moment, rtol=1e-9, atol=1e-9 * size)
        assert power == pytest.approx(step.friction_power, rel=1e-9)
        assert patches == len(step.patches)
    rest = lines[20:]
    for patch in step.patches:
        (side, normal, xi, eta, phi, nx, ny), rest = rest[0], rest[1:]
        n = int(nx * ny)
        points, rest = np.array(rest[:n]).T, rest[n:]
        assert side == (1 if patch.side == "left" else -1)
        assert patch.pressure.shape == (ny, nx)
        assert normal == pytest.approx(patch.normal_force, rel=1e-9)
        np.testing.assert_allclose((xi, eta, phi), patch.creepage, rtol=1e-9, atol=1e-12)
        for field, found in (
            (patch.pressure, points[:1]),
            (patch.traction, points[1:3]),
            (patch.slip_velocity, points[3:5]),
        ):
            flat = field.reshape(-1, n)
            np.testing.assert_allclose(found, flat, rtol=1e-8, atol=1e-8 * np.abs(flat).max())
        np.testing.assert_array_equal(points[5], patch.status.ravel())
    assert rest == []
    # a shoe is no wheelset
    wrong = run(program, library, contact[1])
    assert wrong.returncode == 2
    assert "no prepared wheels: it does not begin as one" in wrong.stderr


#: A host that gives its handles back when the locals of the thread are gone: at exit, and when a thread ends.
LATE = """
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>
#include "mtb.h"

static uint64_t contact, wheels;
static pthread_key_t keys[2];
static int freed;

static void check(int good, const char *what) {
    if (good) return;
    fprintf(stderr, "%s: %s\\n", what, mtb_last_error_message());
    _exit(3);
}

/* every call that needs no file, once all locals are gone */
static void use(uint64_t contact, uint64_t wheels) {
    uint64_t n, motions, copy;
    double state[1];
    check(mtb_contact_size(contact, &n, &motions) == MTB_STATUS_OK && n > 0, "size");
    check(mtb_contact_copy(contact, &copy) == MTB_STATUS_OK, "copy");
    check(mtb_contact_free(copy) == MTB_STATUS_OK, "free copy");
    check(mtb_contact_state(contact, 1, state) == MTB_STATUS_BAD_ARGUMENT, "state");
    check(mtb_wheels_state_size(wheels, &n) == MTB_STATUS_OK, "state size");
    check(mtb_contact_free(contact) == MTB_STATUS_OK, "free");
    check(mtb_wheels_free(wheels) == MTB_STATUS_OK, "free wheels");
    check(mtb_contact_free(contact) == MTB_STATUS_BAD_ARGUMENT, "free again");
    check(mtb_last_error_message() != NULL, "message");
}

static void at_exit(void) { use(contact, wheels); }

/* the last rounds of destructors run after the library's own */
static void at_end(void *round) {
    uintptr_t left = (uintptr_t)round;
    if (left > 1) {
        pthread_setspecific(keys[0], (void *)(left - 1));
        return;
    }
    uint64_t own, rolling;
    check(mtb_contact_copy(contact, &own) == MTB_STATUS_OK, "copy");
    check(mtb_wheels_copy(wheels, &rolling) == MTB_STATUS_OK, "copy wheels");
    use(own, rolling);
    freed = 1;
}

static void *thread(void *unused) {
    pthread_setspecific(keys[0], (void *)(uintptr_t)3);
    check(mtb_contact_free(999) == MTB_STATUS_BAD_ARGUMENT, "a message for this thread");
    return unused;
}

int main(int count, char **arguments) {
    (void)count;
    atexit(at_exit);
    pthread_key_create(&keys[0], at_end);
    check(mtb_contact_load(arguments[1], &contact) == MTB_STATUS_OK, "load");
    check(mtb_wheels_load(arguments[2], &wheels) == MTB_STATUS_OK, "load wheels");
    pthread_t worker;
    pthread_create(&worker, NULL, thread, NULL);
    pthread_join(worker, NULL);
    return freed ? 0 : 4;
}
"""


def test_handles_are_freed_after_the_locals_of_the_thread_are_gone(library, contact, wheels, tmp_path):
    source, program = tmp_path / "late.c", tmp_path / "late"
    source.write_text(LATE)
    flags = ["-std=c11", "-Wall", "-Wextra", "-Werror", "-O1", "-D_POSIX_C_SOURCE=200809L"]
    places = [f"-I{CAPI / 'include'}", f"-L{library}"]
    subprocess.run([compiler("gcc"), *flags, str(source), *places, *LINK, "-o", str(program)], check=True)
    done = run(program, library, contact[1], wheels[1])
    assert (done.returncode, done.stderr) == (0, "")


@pytest.fixture(scope="session")
def c(library):
    """The library by ctypes."""
    c = by_ctypes(library)
    c.mtb_version.restype = ctypes.c_char_p
    number = ctypes.POINTER(ctypes.c_double)
    c.mtb_contact_step.argtypes = [
        ctypes.c_uint64,
        number,
        number,
        ctypes.c_double,
        number,
        number,
        ctypes.c_void_p,
    ]
    c.mtb_contact_free.argtypes = [ctypes.c_uint64]
    c.mtb_contact_pressure.argtypes = [ctypes.c_uint64, ctypes.c_uint64, ctypes.c_void_p]
    return c


def test_what_goes_wrong_has_a_status_and_a_message(c, contact, tmp_path):
    _, path = contact

    def message():
        return c.mtb_last_error_message().decode()

    handle = ctypes.c_uint64()
    assert c.mtb_version().decode() == mtb.__version__
    damaged = tmp_path / "damaged.mtbc"
    damaged.write_bytes(path.read_bytes()[:-1])
    assert c.mtb_contact_load(str(damaged).encode(), ctypes.byref(handle)) == 2
    assert message().endswith("not a prepared contact: it is cut short or too long")
    assert c.mtb_contact_load(None, ctypes.byref(handle)) == 1
    assert c.mtb_contact_load(str(path).encode(), None) == 1
    assert message() == "contact is null"
    assert c.mtb_contact_load(str(path).encode(), ctypes.byref(handle)) == 0
    assert message() == ""
    force, moment = (ctypes.c_double * 3)(), (ctypes.c_double * 3)()

    def step(speed, where=handle, out=force):
        velocity = (ctypes.c_double * 2)(speed, 0.0)
        return c.mtb_contact_step(where, None, velocity, float("nan"), out, moment, None)

    field = (ctypes.c_double * 4)()
    assert c.mtb_contact_pressure(handle, 4, ctypes.addressof(field)) == 1
    assert message() == "no step was solved yet"
    assert step(70.0) == 1
    assert message() == "velocity is 70 m/s: the table of friction covers 0 to 50 m/s"
    assert step(0.0) == 1
    assert message().startswith("velocity is 0: at rest friction has no direction")
    assert step(5.0, out=None) == 0
    assert step(5.0) == 0
    assert c.mtb_contact_pressure(handle, 4, ctypes.addressof(field)) == 1
    assert message() == "pressure has room for 4 numbers, there are 128"
    assert step(5.0, where=ctypes.c_uint64(999)) == 1
    assert message() == "handle 999 is no contact, or one that was freed"
    assert c.mtb_contact_free(handle) == 0
    assert c.mtb_contact_free(handle) == 1
    assert step(5.0) == 1


def test_wheels_that_go_wrong_have_a_status_and_a_message(c, wheels, tmp_path):
    def message():
        return c.mtb_last_error_message().decode()

    _, path = wheels
    damaged = tmp_path / "damaged.mtbw"
    handle, n = ctypes.c_uint64(), ctypes.c_uint64()
    damaged.write_bytes(path.read_bytes()[:-1] + b"?")
    assert c.mtb_wheels_load(str(damaged).encode(), ctypes.byref(handle)) == 2
    assert message().endswith("no prepared wheels: its checksum is wrong")
    assert c.mtb_wheels_load(str(path).encode(), None) == 1
    assert c.mtb_wheels_load(str(path).encode(), ctypes.byref(handle)) == 0
    nan = float("nan")
    step = (ctypes.c_double * 64)()
    rolling = (30.0, 0.0, 0.0, 0.0, 30.0 / 0.46, 0.0)

    def solve(pose=(0.0, 0.0, nan, 0.0, 0.0, 0.0), velocity=rolling, out=step):
        pose, velocity = (ctypes.c_double * 6)(*pose), (ctypes.c_double * 6)(*velocity)
        return c.mtb_wheels_step(handle, pose, velocity, out)

    assert c.mtb_wheels_patch(handle, ctypes.c_uint64(0), step) == 1
    assert message() == "no step was solved yet"
    assert solve(pose=(nan, 0.0, nan, 0.0, 0.0, 0.0)) == 1
    assert "z alone, or z and roll of both wheels" in message()
    assert solve(velocity=(nan, *rolling[1:])) == 1
    assert message().startswith("velocity[0] is NaN")
    assert solve(velocity=6 * [0.0]) == 1
    assert message().startswith("the left wheel does not roll")
    assert solve(out=None) == 1
    assert message() == "step is null"
    # with the left flange on the head the right wheel comes to its end before it carries its force
    assert solve(pose=(0.0, 0.0475, nan, nan, 0.0, 0.0)) == 4
    assert message().startswith(
        "no height and roll of the wheelset found at which each wheel carries 60000 N"
    )
    assert "further on, the contact reaches the end of the wheel profile at y = 0.06 m" in message()
    assert solve() == 0
    assert c.mtb_wheels_patch(handle, ctypes.c_uint64(9), step) == 1
    assert message() == "there is no patch 9: the last step has 2"
    assert c.mtb_wheels_fields(handle, ctypes.c_uint64(0), ctypes.c_uint64(3), step, None, None, None) == 1
    assert message().startswith("pressure has room for 3 numbers, there are ")
    assert c.mtb_wheels_rows(handle, ctypes.c_uint64(0), ctypes.c_uint64(3), step, None) == 1
    assert message().startswith("position has room for 9 numbers, there are ")
    assert c.mtb_wheels_derivatives(handle, None) == 1
    assert message() == "derivatives is null"
    assert c.mtb_wheels_state_size(handle, ctypes.byref(n)) == 0
    state = (ctypes.c_double * n.value)()
    assert c.mtb_wheels_state(handle, n, state) == 0
    assert c.mtb_wheels_resume(handle, n, state) == 0
    state[1] = nan
    assert c.mtb_wheels_resume(handle, n, state) == 1
    assert message() == "state, depth: at most two overlaps > 0 [m] are needed"
    # the counts inside would lead far beyond the array
    state[0] = 1e8
    assert c.mtb_wheels_resume(handle, ctypes.c_uint64(2**64 - 1), state) == 1
    assert message() == f"state cannot hold {2**64 - 1} numbers"
    assert c.mtb_contact_size(handle, ctypes.byref(n), ctypes.byref(n)) == 1
    assert message() == f"handle {handle.value} is no contact, or one that was freed"
    assert c.mtb_wheels_free(handle) == 0
    assert solve() == 1
    assert message() == f"handle {handle.value} is no wheels, or one that was freed"


@pytest.mark.parametrize("conformal", [False, True])
def test_rows_of_wheels_lie_as_in_python(c, tmp_path, conformal):
    scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=1e-3)
    prepared = scene.prepare(conformal=conformal)
    prepared.save(tmp_path / "wheels.mtbw")
    handle, number = ctypes.c_uint64(), ctypes.c_uint64
    assert c.mtb_wheels_load(str(tmp_path / "wheels.mtbw").encode(), ctypes.byref(handle)) == 0
    pose, velocity = (0.0, 6.6e-3, float("nan"), 0.0, 0.0, 2e-3), (20.0, 0.0, 0.0, 0.0, 20.0 / 0.46, 0.0)
    step = prepared.step(pose, velocity)
    out = (ctypes.c_double * 64)()
    assert c.mtb_wheels_step(handle, (ctypes.c_double * 6)(*pose), (ctypes.c_double * 6)(*velocity), out) == 0
    for index, patch in enumerate(step.patches):
        rows = patch.y.size
        position, directions = np.empty((rows, 3)), np.empty((rows, 3, 3))
        known = (array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for array in (position, directions))
        assert c.mtb_wheels_rows(handle, number(index), number(rows), *known) == 0
        middle = patch.points - patch.frames[:, 0][..., None] * patch.x
        np.testing.assert_allclose(position.T, middle[..., 0], atol=1e-15)
        np.testing.assert_allclose(np.moveaxis(directions, 0, 2), np.swapaxes(patch.frames, 0, 1), atol=1e-15)
        assert (np.ptp(directions[:, 2, 2]) > 1e-3) == conformal


def test_what_the_grid_cuts_off_is_refused(c, tmp_path):
    """As in Python, in the same words; heat, peak and the motions are Python's as well."""
    x = (np.arange(9) - 4.0) * 0.2e-3
    scene = mtb.Scene(
        upper=mtb.steel,
        lower=mtb.steel,
        gap=x[:, None] ** 2 + x**2,
        spacing=0.2e-3,
        friction=0.2,
        force=10.0,
        moments=(0.0, 0.0),
    )
    contact = scene.prepare()
    contact.save(tmp_path / "ball.mtbc")
    handle, number = ctypes.c_uint64(), ctypes.c_uint64
    assert c.mtb_contact_load(str(tmp_path / "ball.mtbc").encode(), ctypes.byref(handle)) == 0
    velocity, force = (ctypes.c_double * 2)(2.0, 0.0), (ctypes.c_double * 3)(1.0, 2.0, 3.0)
    deep = (ctypes.c_double * 6)(0.0, 0.0, -1e-5, 0.0, 0.0, 0.0)
    assert c.mtb_contact_step(handle, deep, velocity, float("nan"), force, None, None) == 1
    assert list(force) == [1.0, 2.0, 3.0]
    with pytest.raises(ValueError, match="reaches the edge of the grid of 9 x 9 points") as refused:
        contact.step(list(deep), (2.0, 0.0))
    assert c.mtb_last_error_message().decode() == str(refused.value)

    own = contact.step(velocity=(2.0, 0.0))
    assert c.mtb_contact_step(handle, None, velocity, float("nan"), None, None, None) == 0
    power, peak, m = ctypes.c_double(), ctypes.c_double(), ctypes.c_uint64()
    assert c.mtb_contact_summary(handle, ctypes.byref(power), ctypes.byref(peak)) == 0
    assert power.value == pytest.approx(own.friction_power, rel=1e-12)
    assert peak.value == pytest.approx(own.pressure.max(), rel=1e-12)
    assert c.mtb_contact_size(handle, None, ctypes.byref(m)) == 0
    amplitudes = (ctypes.c_double * m.value)()
    assert c.mtb_contact_amplitudes(handle, m, amplitudes) == 0
    np.testing.assert_allclose(list(amplitudes), own.state.motion, rtol=1e-9, atol=1e-15)
    names = []
    for k in range(m.value):
        name = ctypes.create_string_buffer(80)
        assert c.mtb_contact_motion(handle, number(k), number(80), name, None) == 0
        names.append(name.value.decode())
    assert names == contact.motions
    derivatives = (ctypes.c_double * 72)()
    assert c.mtb_contact_derivatives(handle, derivatives) == 0
    told, peak_force = np.reshape(derivatives, (8, 9)), np.abs(own.force).max()
    for rows, of in (
        (slice(0, 3), "force"),
        (slice(3, 6), "moment"),
        (6, "friction_power"),
        (7, "peak_pressure"),
    ):
        for columns, by in (
            (slice(0, 6), "pose"),
            (slice(6, 8), "velocity"),
        ):
            wanted = own.derivative(of, by)
            np.testing.assert_allclose(told[rows, columns], wanted, rtol=1e-8, atol=1e-9 * peak_force)
    assert told.any()
    # it knows of no magnetic pressure
    assert not told[:, 8].any()
    assert c.mtb_contact_free(handle) == 0


def test_wedging_is_a_status(c, tmp_path):
    block = mtb.scenes.block_on_plane(width=0.1, height=0.5, spacing=2e-2, friction=1.0)
    block.prepare("elastic-upper").save(tmp_path / "block.mtbc")
    handle = ctypes.c_uint64()
    assert c.mtb_contact_load(str(tmp_path / "block.mtbc").encode(), ctypes.byref(handle)) == 0
    velocity, force = (ctypes.c_double * 2)(1.0, 0.0), (ctypes.c_double * 3)(1.0, 2.0, 3.0)
    assert c.mtb_contact_step(handle, None, velocity, float("nan"), force, force, None) == 3
    assert c.mtb_last_error_message() == b"no sliding equilibrium: the body wedges"
    assert list(force) == [1.0, 2.0, 3.0]
    assert c.mtb_contact_free(handle) == 0


class Conditions(ctypes.Structure):
    """`mtb_wheel_conditions`, written from the header by hand."""

    _fields_ = (
        *((name, ctypes.c_double) for name in ("lateral_force", "longitudinal_force", "axle_moment")),
        ("curvature", ctypes.c_double),
        *((name, ctypes.c_double * 3 * 2) for name in ("rails", "rail_rates")),
        *((name, ctypes.c_double * 6 * 2) for name in ("wheels", "wheel_rates")),
        ("velocity", ctypes.c_double * 6),
        ("rail_displacement", ctypes.c_double * 2 * 2),
    )


@pytest.mark.filterwarnings("ignore:the rotation of the velocity is about a level axle")
def test_wheels_under_forces_are_those_of_python(c, wheels):
    def message():
        return c.mtb_last_error_message().decode()

    prepared, path = wheels
    nan, six = float("nan"), ctypes.c_double * 6
    handle, out = ctypes.c_uint64(), (ctypes.c_double * 64)()
    velocity = (30.0, 0.0, 0.0, 0.0, 30.0 / 0.46, 0.0)
    pose = (0.0, nan, nan, nan, 0.0, 1e-3)
    assert c.mtb_wheels_load(str(path).encode(), ctypes.byref(handle)) == 0

    def solve(pose=pose, **given):
        conditions = Conditions(nan, nan, nan)
        for name, value in given.items():
            setattr(conditions, name, value)
        place = None if pose is None else six(*pose)
        code = c.mtb_wheels_step_under(handle, place, six(*velocity), ctypes.byref(conditions), out)
        return code, conditions

    rail, wheel = ((1e-4, -2e-5, 1e-3), (1e-3, 0.0, 0.0)), ((0.0, 1e-4, 0.0, 0.0, 0.0, 1e-4), (0.0,) * 6)
    none = ctypes.c_double * 3
    code, found = solve(
        lateral_force=8e3,
        longitudinal_force=4e3,
        curvature=1e-3,
        rails=(none * 2)(none(*rail[0])),
        rail_rates=(none * 2)(none(*rail[1])),
        wheels=(six * 2)(six(), six(*wheel[0])),
    )
    assert code == 0, message()
    own = prepared.copy().step(
        pose,
        velocity,
        lateral_force=8e3,
        longitudinal_force=4e3,
        curvature=1e-3,
        rails={"left": sum(rail, ())},
        wheels={"right": sum(wheel, ())},
    )
    force = np.array(out[:3])
    assert force == pytest.approx([4e3, 8e3, -120e3], abs=1e-2)
    assert out[12:18] == pytest.approx(own.pose, rel=1e-9, abs=1e-15)
    assert list(found.velocity) == pytest.approx(own.velocity, rel=1e-12)
    told = {side: list(found.rail_displacement[k]) for k, side in enumerate(("left", "right"))}
    assert told == {side: pytest.approx(moved) for side, moved in own.rail_displacement.items()}
    flat = (ctypes.c_double * 1300)()
    assert c.mtb_wheels_derivatives_under(handle, flat) == 0
    table = np.reshape(flat, (25, 52))
    inputs = ["lateral_force", "longitudinal_force", "curvature"]
    columns = {"pose": slice(6), "velocity": slice(6, 12), **dict(zip(inputs, (12, 13, 15), strict=True))}
    for k, of_side in enumerate(("left", "right")):
        columns[f"rails.{of_side}"] = [*range(16 + 3 * k, 19 + 3 * k), *range(22 + 3 * k, 25 + 3 * k)]
        columns[f"wheels.{of_side}"] = [*range(28 + 6 * k, 34 + 6 * k), *range(40 + 6 * k, 46 + 6 * k)]
    rows = {
        "force": slice(3),
        "moment": slice(3, 6),
        "vertical_force": slice(6, 8),
        "friction_power": 8,
        "pose": slice(9, 15),
        "velocity": slice(15, 21),
        "rail_displacement": slice(21, 25),
    }
    for of, row in rows.items():
        for by, column in columns.items():
            wanted = np.asarray(own.derivative(of, by))
            here = table[:, column][row].reshape(wanted.shape)
            # forces that are met stay, whatever changes
            size = np.abs(own.derivative("force" if of == "vertical_force" else of, by)).max()
            # of steps of their own, which end where rounding lets them
            np.testing.assert_allclose(
                here, wanted, rtol=1e-4, atol=1e-5 * size + 1e-12, err_msg=f"{of} {by}"
            )
    assert not table[:, 14].any()  # no moment about the axle was given
    assert table[[1, 0], [12, 13]] == pytest.approx([1.0, 1.0], rel=1e-6)
    assert c.mtb_wheels_derivatives_under(handle, None) == 1
    assert message() == "derivatives is null"
    # without a pose y and z are found
    code, _ = solve(pose=None, lateral_force=8e3)
    assert code == 0, message()
    own = prepared.copy().step(velocity=velocity, lateral_force=8e3)
    assert out[12:18] == pytest.approx(own.pose, abs=1e-9)
    assert solve(longitudinal_force=1.0, axle_moment=0.0)[0] == 1
    assert message() == "longitudinal_force and axle_moment are both given: one of them must be NaN"
    assert solve(lateral_force=-1e6)[0] == 4
    assert "gets no nearer than" in message()
    assert c.mtb_wheels_step_under(handle, None, six(*velocity), None, out) == 1
    assert message() == "conditions or step is null"
    assert c.mtb_wheels_free(handle) == 0


#: A wheelset that is pushed to the left and brakes, in Fortran.
PUSHED = """
program pushed
  use, intrinsic :: iso_c_binding
  use, intrinsic :: ieee_arithmetic
  use mtb
  implicit none
  character(len=1000) :: path
  integer(c_int64_t) :: wheels
  real(c_double) :: free
  type(mtb_wheel_step) :: step
  type(mtb_wheel_conditions) :: given
  real(c_double) :: by(52, 25)

  call get_command_argument(1, path)
  free = ieee_value(free, ieee_quiet_nan)
  given%lateral_force = 8.0e3_c_double
  given%longitudinal_force = 4.0e3_c_double
  given%axle_moment = free
  given%curvature = 0
  given%rails = 0
  given%rail_rates = 0
  given%rails(1, 2) = 1.0e-4_c_double
  given%wheels = 0
  given%wheel_rates = 0
  if (mtb_wheels_load(path, wheels) /= mtb_status_ok) stop 1
  if (mtb_wheels_step_under(wheels, [0.0_c_double, free, free, free, 0.0_c_double, 0.0_c_double], &
    [30.0_c_double, 0.0_c_double, 0.0_c_double, 0.0_c_double, 65.0_c_double, 0.0_c_double], given, step) &
    /= mtb_status_ok) stop 2
  write (*, "(14(es24.16e3, 1x))") step%force, step%pose(2:4), given%velocity(4:6), given%rail_displacement
  if (mtb_wheels_derivatives_under(wheels, by) /= mtb_status_ok) stop 3
  write (*, "(2(es24.16e3, 1x))") by(13, 11), by(20, 2)
  if (mtb_wheels_free(wheels) /= mtb_status_ok) stop 4
end program
"""


def test_wheels_under_forces_from_fortran(library, wheels, tmp_path):
    prepared, path = wheels
    done = run(in_fortran("pushed", library, tmp_path, PUSHED), library, path)
    assert done.returncode == 0, done.stderr
    told = [float(value) for value in done.stdout.split()]
    own = prepared.copy().step(
        [0.0, np.nan, np.nan, np.nan, 0.0, 0.0],
        (30.0, 0.0, 0.0, 0.0, 65.0, 0.0),
        lateral_force=8e3,
        longitudinal_force=4e3,
        rails={"right": (1e-4, 0.0, 0.0)},
    )
    assert told[:3] == pytest.approx([4e3, 8e3, -120e3], abs=1e-2)
    assert told[3:6] == pytest.approx(own.pose[1:4], rel=1e-8, abs=1e-13)
    assert told[6:9] == pytest.approx(own.velocity[3:], rel=1e-10, abs=1e-14)
    assert told[9:13] == pytest.approx(np.ravel(list(own.rail_displacement.values())), abs=1e-14)
    # y by the lateral force, and the lateral force, which is met, by y of the right rail
    assert told[13] == pytest.approx(own.derivative("pose", "lateral_force")[1], rel=1e-4)
    assert told[14] == pytest.approx(0.0, abs=1e-6 * abs(own.derivative("moment", "rails.right")).max())


@pytest.mark.filterwarnings("ignore:the rotation of the velocity is about a level axle")
def test_derivatives_of_wheels_are_those_of_python(c, wheels):
    prepared, path = wheels
    handle, pose = ctypes.c_uint64(), (0.0, 2e-3, float("nan"), float("nan"), 0.0, 1e-3)
    velocity = (30.0, 0.0, 0.0, 0.01, 30.0 / 0.46, 0.0)
    assert c.mtb_wheels_load(str(path).encode(), ctypes.byref(handle)) == 0
    told = (ctypes.c_double * 108)()
    assert c.mtb_wheels_derivatives(handle, told) == 1
    out = (ctypes.c_double * 64)()
    six = ctypes.c_double * 6
    assert c.mtb_wheels_step(handle, six(*pose), six(*velocity), out) == 0
    assert c.mtb_wheels_derivatives(handle, told) == 0
    own = prepared.copy().step(pose, velocity)
    table = np.reshape(told, (9, 12))
    for rows, of in (
        (slice(0, 3), "force"),
        (slice(3, 6), "moment"),
        (slice(6, 8), "vertical_force"),
        (8, "friction_power"),
    ):
        for columns, by in ((slice(0, 6), "pose"), (slice(6, 12), "velocity")):
            wanted = own.derivative(of, by)
            # the vertical forces are those asked for, whatever changes
            size = np.abs(own.derivative("force", by) if of == "vertical_force" else wanted).max()
            np.testing.assert_allclose(table[rows, columns], wanted, rtol=1e-7, atol=1e-9 * size)
    assert table[[0, 1, 3, 4, 5, 8]].any(axis=1).all()
    assert c.mtb_wheels_free(handle) == 0

# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of half-spaces that are solved by convolutions take products too, and no matrix."""

import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]

#: Just above the number of points from which on flat half-spaces are solved by convolutions.
N = 46
SOFT, HARD = mtb.Material(80e9, 0.1), mtb.Material(200e9, 0.3)

pytestmark = [
    pytest.mark.filterwarnings("ignore::mtb_rs.ToleranceWarning"),
    pytest.mark.filterwarnings("ignore:.*(deforms|displaces|away from).*:UserWarning"),
]


def ball(**given: Any) -> mtb.Scene:
    x = (np.arange(N) - 0.5 * (N - 1)) * 10e-3 / N
    gap = x[None, :] ** 2 / 0.6 + x[:, None] ** 2 / 0.5 + 2e-7 * np.random.default_rng(1).random((N, N))
    chosen = {"friction": 0.3, "velocity": 4.0, "sliding_direction": (1.0, 0.5)}
    return mtb.Scene(**{"upper": SOFT, "lower": HARD, "gap": gap, "spacing": 10e-3 / N} | chosen | given)


SCENES: dict[str, dict[str, Any]] = {
    "force": {"force": 2e3},
    "moments": {"force": 2e3, "moments": (0.5, -0.3), "friction": mtb.VelocityTable([0.0, 5.0], [0.4, 0.3])},
    "approach": {"approach": 8e-6, "friction": lambda x, y: 0.2 + 10.0 * x},
    "like bodies": {"approach": 8e-6, "lower": SOFT},
    "rigid plane": {"approach": 8e-6, "lower": mtb.Rigid(), "friction": 0.5},
    "pull": {"magnetic_pressure": 2e7, "attraction": "both"},
}


@pytest.mark.parametrize("name", SCENES)
def test_products_give_the_derivatives_of_matrices(name: str) -> None:
    result = ball(**SCENES[name]).solve("half-space")
    assert result.report.solver.startswith("conjugate gradients, FFT")
    dense = replace(result)
    object.__setattr__(dense, "_derived", replace(vars(result)["_derived"], by_products=False))
    weight = np.random.default_rng(2).uniform(0.0, 1.0, (2, N, N))
    of: list[Any] = ["peak_pressure", {"pressure": weight[0]}, {"gap": weight[1]}]
    of.append("normal_force" if "approach" in SCENES[name] else "approach")
    found, expected = result.gradient(of), dense.gradient(of)
    assert list(found) == list(expected)
    for by in expected:
        rows, wanted = (np.reshape(g[by], (len(g[by]), -1)) for g in (found, expected))
        if name == "rigid plane" and by == "upper.young_modulus":
            # one body alone: its modulus changes no gap at a given approach
            rows, wanted = np.delete(rows, 2, 0), np.delete(wanted, 2, 0)
        assert np.all(np.abs(rows - wanted).max(axis=1) <= 1e-8 * np.abs(wanted).max(axis=1)), by
    for by in ("friction", "velocity"):
        if by in found:
            for field in ("pressure", "gap"):
                a, b = (np.asarray(r.derivative(field, by)) for r in (result, dense))
                assert np.abs(a - b).max() <= 1e-8 * np.abs(b).max()


def test_products_give_differences_of_exact_steps() -> None:
    """Steps solve with a matrix, to rounding."""
    scene = ball(force=2e3)
    result, contact = scene.solve("half-space"), scene.prepare("half-space")
    random = np.random.default_rng(3)
    along = {
        "gap": 1e-8 * random.uniform(-1.0, 1.0, N * N),
        "friction": 0.1 * random.uniform(0.0, 1.0, N * N),
    }
    by_name = {"gap": "gap", "friction": "friction_field"}
    gradient = result.gradient(["moment", "peak_pressure"])
    place = int(result.pressure.argmax())

    def at(name: str, share: float) -> Array:
        rest = 0.3 if name == "friction" else 0.0
        step = contact.step(velocity=4.0, **{name: rest + share * along[name]})
        assert np.array_equal(step.status > 0, result.status.ravel() > 0)
        return np.array([*step.moment, step.pressure[place]])

    for name, change in along.items():
        width = 2e-2 if name == "gap" else 1e-2
        far, near = ((at(name, h) - at(name, -h)) / (2.0 * h) for h in (width, 0.5 * width))
        wanted = (4.0 * near - far) / 3.0
        found = gradient[by_name[name]].reshape(4, -1) @ change
        assert found == pytest.approx(wanted, rel=1e-6, abs=1e-6 * np.abs(wanted).max())


MEASURED = """
import numpy as np, warnings
import mtb_rs as mtb

warnings.simplefilter("ignore")

def number(name):
    return 1e-3 * int(next(l for l in open("/proc/self/status") if l.startswith(name)).split()[1])

def most(work):
    before = number("VmRSS")
    open("/proc/self/clear_refs", "w").write("5")
    kept = work()
    return number("VmHWM") - before, kept

def scene(n):
    x = (np.arange(n) - 0.5 * (n - 1)) * 10e-3 / n
    gap = x[None, :] ** 2 / 0.1 + x[:, None] ** 2 / 0.1
    materials = {"upper": mtb.Material(80e9, 0.1), "lower": mtb.Material(200e9, 0.3)}
    return mtb.Scene(**materials, gap=gap, spacing=10e-3 / n, friction=0.3, force=2e4)

def all_of(result):
    gradient = result.gradient(["force", "moment", "peak_pressure"])
    return [gradient[by] for by in gradient], result.derivative("pressure", "friction")

all_of(scene(50).solve("half-space"))  # what is loaded once
of_solve, result = most(lambda: scene(100).solve("half-space"))
of_gradient, _ = most(lambda: all_of(result))
print(of_solve, of_gradient)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="reads the memory of the process from /proc")
def test_the_memory_of_derivatives_is_that_of_the_solve() -> None:
    told = subprocess.run([sys.executable, "-c", MEASURED], capture_output=True, text=True, check=True)
    of_solve, of_gradient = map(float, told.stdout.split())
    # seven numbers by every gap and friction value of 10 000 points; one matrix of them takes 800 MB
    assert of_gradient < max(2.0 * of_solve, 60.0)

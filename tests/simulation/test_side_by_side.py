# SPDX-License-Identifier: MIT OR Apache-2.0
"""One contact in Python, C, Fortran, Rust and FMI: every program prints the numbers of `Scene.solve`."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb

pytestmark = pytest.mark.slow  # compiles programs

ROOT = Path(__file__).parents[2]
SPEEDS = (30.0, 20.0, 10.0)


def solved(speed: float) -> tuple[float, float, float, float]:
    """The same from a solve of the scene, whose friction is read from the table here."""
    friction = float(np.interp(speed, [0.0, 10.0, 50.0], [0.4, 0.2, 0.1]))
    shoe = mtb.scenes.pole_shoe_on_rail(friction=friction, magnetic_pressure=3e6, spacing=6e-3)
    result = shoe.solve("elastic-upper", tolerance=0.9)
    # moments of a result are about the origin, those of the programs about the top of the shoe
    lever = np.array([0.0, 0.0, 28.2e-3]) - result.reference_point
    moment = result.moment - np.cross(lever, result.force)
    return speed, float(result.force[0]), float(result.force[2]), float(moment[1])


@pytest.mark.skipif(sys.platform == "win32", reason="a shell script")
def test_every_language_tells_the_same(tmp_path: Path) -> None:
    if shutil.which("cargo") is None:
        pytest.skip("cargo is not installed: the programs cannot be built")
    script = ROOT / "examples" / "side_by_side" / "run"
    done = subprocess.run(
        ["sh", str(script), str(tmp_path)],
        env=os.environ | {"PYTHON": sys.executable},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    told: dict[str, list[list[float]]] = {}
    for line in done.stdout.splitlines():
        if line[0].isalpha():
            rows = told.setdefault(line, [])
        else:
            rows.append([float(word) for word in line.split()])
    expected = {"Python", "Rust"}
    expected |= {
        name for name, tool in (("C", "gcc"), ("Fortran", "gfortran")) if shutil.which(tool) is not None
    }
    assert set(told) >= expected
    for name, found in told.items():
        for row, speed in zip(found, SPEEDS, strict=True):
            expected_row = solved(speed)
            # the moment is what is left of 30 N m of friction and pressure that hold each other
            size = abs(expected_row[1]) * 28.2e-3
            assert row[:3] == pytest.approx(expected_row[:3], rel=1e-9), name
            assert row[3] == pytest.approx(expected_row[3], abs=1e-9 * size), name

# SPDX-License-Identifier: MIT OR Apache-2.0
"""The spin that notebooks, case files and pages give a wheel is that of its own motion."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.commands.start import CASES

ROOT = Path(__file__).parents[2]


def natural_spin(wheel: mtb.WheelScene) -> float:
    """Spin of a left wheel [1/m] that rolls forwards, by its kinematics."""
    step = wheel.prepare(side="left", friction=mtb.Coulomb(0.0)).step(velocity=20.0)
    return float(step.patches[0].creepage[2])


def of_case(text: str) -> tuple[float, float]:
    case = tomllib.loads(re.sub(r"^:.*$", "", dedent(text), flags=re.M))
    build = getattr(mtb.scenes, case.pop("scene"))
    given = case.pop("rolling")
    # the spin is kinematics, whatever the surfaces suffer
    for name in ("damage", "hardness"):
        case.pop(name, None)
    return given["creepage"][2], natural_spin(build(**case))


def test_first_principles_give_the_sign() -> None:
    # a cone that rolls forwards turns about +y; the normal of its plane leans to the middle of the track
    wheel = mtb.scenes.wheel_on_rail(lateral=5e-3, force=60e3, spacing=0.5e-3)
    angle = wheel.geometry.placement.contact_angle
    turning, normal = np.array([0.0, 1.0 / 0.46, 0.0]), wheel.geometry.placement.rotation[:, 2]
    assert angle > 0.1
    assert natural_spin(wheel) == pytest.approx(float(turning @ normal), rel=0.02)
    assert natural_spin(wheel) < 0.0


def test_the_case_file_to_start_from_has_the_spin_of_its_wheel() -> None:
    given, own = of_case(CASES["rolling"])
    assert given == pytest.approx(own, rel=0.05)


def test_the_page_of_case_files_has_the_spin_of_its_wheel() -> None:
    page = (ROOT / "docs" / "case_files.md").read_text(encoding="utf-8")
    blocks = [b for b in re.findall(r"```[^\n]*toml\n((?:(?!```).)*?)```", page, re.S) if "[rolling]" in b]
    assert blocks
    for block in blocks:
        given, own = of_case(block)
        assert given == pytest.approx(own, rel=0.05)


def test_the_notebook_has_the_spin_of_its_wheel() -> None:
    notebook = json.loads(
        (ROOT / "docs" / "notebooks" / "wheel_rail_study.ipynb").read_text(encoding="utf-8")
    )
    code = "\n".join("".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code")
    (stated,) = re.findall(r"^spin = (.*?)(?:  #.*)?$", code, re.M)
    (made,) = re.findall(r"^wheel = mtb\.scenes\.wheel_on_rail\(.*?\)$", code, re.M)
    wheel = eval(made.partition(" = ")[2], {"mtb": mtb})
    given = eval(stated, {"np": np, "place": wheel.geometry.placement})
    assert given == pytest.approx(natural_spin(wheel), rel=0.05)

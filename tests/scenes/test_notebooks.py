# SPDX-License-Identifier: MIT OR Apache-2.0
"""Scenes, results, steps, sweeps and charts show themselves in a notebook: a table, and a picture."""

from __future__ import annotations

import base64
import io
import re
from typing import Any

import numpy as np
import pytest
from PIL import Image

import mtb_rs as mtb
from mtb_rs.base.told import MOST_ROWS
from mtb_rs.pictures.section import cut
from mtb_rs.results.chart import Chart, ChartPoint
from mtb_rs.results.result import Result

pytestmark = pytest.mark.coarse

SPHERE = mtb.scenes.paraboloid_on_plane(0.4, 1e4, 0.3, 20)
WHEEL = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=0.6e-3)


def picture_in(page: str) -> np.ndarray | None:
    found = re.search(r'src="data:image/png;base64,([^"]+)"', page)
    if found is None:
        return None
    with Image.open(io.BytesIO(base64.b64decode(found[1]))) as image:
        return np.asarray(image.convert("RGB"))


def cells(page: str) -> list[str]:
    return re.findall(r"<td[^>]*>(.*?)</td>", page)


def test_results_and_steps_show_their_figures_and_a_picture(pole_shoe_result: Result) -> None:
    solved = SPHERE.solve()
    gap = np.add.outer(*2 * [np.linspace(-4e-3, 4e-3, 24) ** 2])
    pressed = mtb.solve_normal(gap, 0.35e-3, lower=mtb.steel, upper=mtb.steel, force=1e3)
    rolled = mtb.solve_tangential(solved, mtb.Rolling(creepage=(1e-3, 0.0, 0.0)), mtb.Coulomb(0.3))
    step = mtb.scenes.pole_shoe_on_rail(spacing=8e-3).prepare("half-space").step(velocity=10.0)
    wheels = WHEEL.prepare().step(velocity=20.0)
    for shown in (pole_shoe_result, solved, pressed, rolled, step, wheels):
        page = shown._repr_html_()
        assert page.startswith(f"<div><b>{type(shown).__name__}</b><table>")
        load = shown.normal_force if hasattr(shown, "normal_force") else abs(shown.force[2])
        assert f"{load:.6g}" in page
        drawn = picture_in(page)
        assert drawn is not None
        assert np.ptp(drawn) > 100
        assert dict(shown.told())


def test_wheels_in_the_air_have_no_picture() -> None:
    step = WHEEL.prepare().step(pose=(0.0, 0.0, 5e-3, 0.0, 0.0, 0.0), velocity=20.0)
    assert picture_in(step._repr_html_()) is None


def test_scenes_and_reports_say_their_numbers_with_units() -> None:
    told = dict(SPHERE.told())
    assert told["force"] == "10000 N"
    assert told["radius"] == "0.4 m"
    assert told["friction"] == "0.3"
    block = mtb.scenes.block_on_plane(spacing=(5e-3, 2.5e-3))
    assert dict(block.told())["spacing"] == "0.005, 0.0025 m"
    assert "0.4 m" in cells(SPHERE._repr_html_())
    report = SPHERE.solve().report
    assert dict(report.told())["peak pressure"] == f"{report.peak_pressure:.6g} Pa"
    assert dict(report.told())["converged"] == "yes"
    # numbers of an own scene, and a text with signs of HTML, which stay text
    own = mtb.Scene(
        mtb.Rigid(), mtb.HalfSpace(mtb.steel), gap=np.zeros((4, 4)), spacing=1e-3, force=1e3, name="<b>"
    )
    assert "&lt;b&gt;" in own._repr_html_()
    assert dict(own.told())["upper"] == "Rigid()"
    assert "2.08e+11" in dict(own.told())["lower"]
    assert dict(own.told())["spacing"] == "0.001, 0.001 m"


def test_scenes_show_their_bodies_cut_across() -> None:
    gap = np.add.outer(*2 * [np.linspace(-4e-3, 4e-3, 24) ** 2])
    own = mtb.Scene(mtb.steel, mtb.steel, gap=gap, spacing=0.35e-3, force=1e3)
    for scene in (SPHERE, WHEEL, own, mtb.scenes.pole_shoe_on_rail(lateral=2e-3, yaw=0.01)):
        drawn = picture_in(scene._repr_html_())
        assert drawn is not None
        assert np.ptp(drawn) > 100
    lines = [
        cut(surface)
        for surface in mtb.scenes.block_on_plane(width=0.2, height=0.3, length=0.1).geometry.surfaces()
    ]
    plane, block = (np.concatenate([line.min(axis=(0, 1)), line.max(axis=(0, 1))]) for line in lines)
    assert block == pytest.approx([-0.05, 0.0, 0.05, 0.3], abs=1e-12)
    assert plane[[1, 3]].tolist() == [0.0, 0.0]


def test_sweeps_show_their_rows() -> None:
    table = mtb.sweep(SPHERE, {"force": np.linspace(1e3, 2e3, MOST_ROWS + 3).tolist()})
    page = table._repr_html_()
    assert "force [N]" in page
    assert "peak_pressure [Pa]" in page
    assert "and 3 more" in page
    assert page.count("<tr>") == MOST_ROWS + 2
    assert f"{table['peak_pressure'][0]:.6g}" in cells(page)
    assert picture_in(page) is not None
    # moments of rounding, margins that no case has
    columns = page[: page.index("</tr>")]
    assert not {"moment_x", "status", "wedging_margin"} & set(re.split(r"\W", columns))
    assert "the same in all cases: " in page
    labelled = mtb.sweep(SPHERE, {"upper": {"steel": mtb.steel, "rigid": mtb.Rigid()}})._repr_html_()
    assert picture_in(labelled) is None
    # a case that fails keeps the reason
    assert "status" in mtb.sweep(SPHERE, {"force": [1e3, -1.0]})._repr_html_()


@pytest.mark.parametrize(("errors", "has_picture"), [({"pressure": 0.1}, True), ({}, False)])
def test_charts_show_what_is_efficient(errors: dict[str, float], has_picture: bool) -> None:
    point = ChartPoint("half-space", 1e-3, 100, (0.01,), (0.01,), errors, failure="" if errors else "no")
    page = Chart("a scene", (point,), "a closed form")._repr_html_()
    assert (picture_in(page) is not None) == has_picture
    assert ("100 points: 0.01 s, 10 %" in page) == has_picture
    assert "a closed form" in page


def all_public() -> list[Any]:
    return [getattr(mtb, name) for name in mtb.__all__]


def test_whatever_draws_itself_tells_its_figures() -> None:
    drawing = [kind for kind in all_public() if isinstance(kind, type) and hasattr(kind, "_repr_png_")]
    assert {kind.__name__ for kind in drawing} >= {"Result", "NormalResult", "TangentialResult", "WheelStep"}
    assert all(hasattr(kind, "_repr_html_") for kind in drawing)

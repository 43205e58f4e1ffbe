# SPDX-License-Identifier: MIT OR Apache-2.0
"""Figures are pyplot's own where pyplot is in use, and take what figures take."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest

import mtb_rs as mtb

mpl.use("Agg")
from matplotlib import pyplot as plt


@pytest.fixture
def result() -> Iterator[mtb.Result]:
    yield mtb.scenes.paraboloid_on_plane(points=18).solve("half-space")
    plt.close("all")


def test_figures_are_those_of_pyplot_and_files_leave_none(result: mtb.Result, tmp_path: Path) -> None:
    figure = result.plot("pressure")
    assert plt.get_fignums() == [figure.number]
    assert plt.gcf() is figure
    result.save(tmp_path / "out")
    result._repr_png_()
    assert plt.get_fignums() == [figure.number]
    _, axes = plt.subplots()
    result.plot("gap", ax=axes)
    assert len(plt.get_fignums()) == 2


def test_without_pyplot_figures_belong_to_nobody_and_show_themselves() -> None:
    code = (
        "import sys, warnings, mtb_rs as mtb; "
        "r = mtb.scenes.paraboloid_on_plane(points=18).solve('half-space'); "
        "f = r.plot('pressure'); assert 'matplotlib.pyplot' not in sys.modules; "
        "warnings.simplefilter('ignore'); f.show(); "
        "import matplotlib.pyplot as plt; assert plt.get_fignums() == [1] and plt.gcf() is f"
    )
    subprocess.run([sys.executable, "-c", code], check=True, env={**os.environ, "MPLBACKEND": "Agg"})


def test_title_colours_and_size_are_passed_on(result: mtb.Result) -> None:
    figure = result.plot("pressure", title="Mine", cmap="magma", figsize=(3.0, 2.0))
    assert np.allclose(figure.get_size_inches(), (3.0, 2.0))
    assert figure.axes[0].get_title(loc="left") == "Mine"
    assert any(c.get_array() is not None and c.get_cmap().name == "magma" for c in figure.axes[0].collections)
    lines = result.plot("pressure", "line", title="Cut")
    assert lines.axes[0].get_title(loc="left") == "Cut"
    for options, words in (
        ({"kind": "line", "cmap": "magma"}, "cmap"),
        ({"kind": "3d", "title": "a"}, "3d"),
        ({"ax": lines.axes[0], "figsize": (1.0, 1.0)}, "figsize"),
        ({"cmap": "no such"}, "no such"),
    ):
        with pytest.raises(ValueError, match=words):
            result.plot("pressure", **options)


def test_the_package_lists_what_it_offers() -> None:
    listed = set(dir(mtb))
    assert {"animate", "write_html", "load_case", "Case"} <= listed
    assert not {"Any", "TYPE_CHECKING", "annotations"} & listed
    assert all(hasattr(mtb, name) for name in listed)


def test_tables_over_the_velocity_come_from_files(tmp_path: Path) -> None:
    path = tmp_path / "mu.csv"
    path.write_text("v,mu\n0,0.3\n20,0.1\n", encoding="utf-8")
    assert mtb.VelocityTable.from_file(path) == mtb.VelocityTable([0.0, 20.0], [0.3, 0.1])
    path.write_text("0,0.3\n20,a\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"mu\.csv, line 2"):
        mtb.VelocityTable.from_file(path)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("value,velocity\n0.1,0\n0.2,10\n", (0.1, 0.2)),
        ("velocity [km/h],value\n0,0.1\n36,0.2\n", (0.1, 0.2)),
        ("speed (mm/s);p [MPa]\n0;1\n10000;2\n", (1e6, 2e6)),
        ("# day 3\n\nrun, v [m/s], value\n1, 0, 0.1\n2, 10, 0.2\n", (0.1, 0.2)),
    ],
)
def test_headings_of_velocity_tables_count(tmp_path: Path, text: str, value: tuple[float, float]) -> None:
    (tmp_path / "t.csv").write_text(text, encoding="utf-8")
    table = mtb.VelocityTable.from_file(tmp_path / "t.csv")
    assert table.velocity == pytest.approx((0.0, 10.0))
    assert table.value == pytest.approx(value)
    case = 'scene = "pole_shoe_on_rail"\nvelocity = 5.0\nfriction = {file = "t.csv"}\n'
    (tmp_path / "case.toml").write_text(case, encoding="utf-8")
    assert mtb.load_case(tmp_path / "case.toml").friction == table  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "a,b\n0,1\n1,2\n",
            "line 1 of the file: the heading .* does not name the columns velocity and value",
        ),
        ("velocity [furlong/h],value\n0,1\n", "line 1 of the file: .*known are m/s"),
        ("velocity value\n0 0,3\n10 0,2\n", "line 2 of the file: .*decimal commas: write decimal points"),
        ("velocity,value\n0,1\n1,,2\n", "line 3 of the file: "),
        ("velocity,value\n0,1\n1,nan\n", "line 3 of the file: .*not two finite numbers, velocity and value"),
    ],
)
def test_velocity_tables_that_cannot_be_read_say_why(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "t.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=rf"t\.csv, {message}"):
        mtb.VelocityTable.from_file(path)


@pytest.mark.coarse
def test_what_plot_refuses_is_the_argument_that_is_wrong() -> None:
    result = mtb.scenes.block_on_plane(spacing=25e-3, friction=0.1).solve("elastic-upper")
    with pytest.raises(ValueError, match=r"quantity is 'presure': one of .*von_mises is needed"):
        result.plot("presure")
    flat = mtb.scenes.paraboloid_on_plane(points=12).solve("half-space")
    with pytest.raises(ValueError, match="quantity is 'presure'") as caught:
        flat.plot("presure")
    assert "von_mises" not in str(caught.value)
    for quantity in ("pressure", "von_mises"):
        with pytest.raises(ValueError, match='kind is \'lines\': "map", "line" or "3d" is needed'):
            result.plot(quantity, "lines", cmap="viridis", title="a")
        for option in ({"title": "a"}, {"cmap": "viridis"}, {"figsize": (3.0, 3.0)}):
            with pytest.raises(ValueError, match="title, cmap and figsize are for maps and lines"):
                result.plot(quantity, "3d", **option)
            if quantity == "von_mises":
                with pytest.raises(ValueError, match="title, cmap and figsize are for maps and lines"):
                    result.plot(quantity, **option)


def test_curves_of_area_over_load_draw_themselves() -> None:
    heights = mtb.roughness(32, 1e-6, rms_height=1e-7, seed=1)
    gap = heights.max() - heights
    curve = mtb.area_load_curve(gap, 1e-6, [2e-3, 1e-3], lower=mtb.steel, upper=mtb.Rigid())
    (axes,) = curve.plot().axes
    (line,) = axes.get_lines()
    np.testing.assert_allclose(line.get_xdata(), [1.0, 2.0])
    np.testing.assert_allclose(line.get_ydata(), curve.contact_area[::-1] * 1e12)
    assert axes.get_xlabel() == "normal force [mN]"
    assert axes.get_ylabel() == "contact area [µm²]"


def test_words_in_narrow_axes_stand_apart() -> None:
    patch = mtb.hertz(5e3, 0.4).on_grid((20, 20), 3e-4)
    rolled = mtb.solve_tangential(patch, mtb.Rolling(creepage=(1e-3, 0.0, 0.2)), mtb.Coulomb(0.3))
    for width in (3.0, 7.2):
        figure, panels = plt.subplots(1, 2, figsize=(2 * width, width))
        for axes, quantity in zip(panels, ("traction", "status"), strict=True):
            rolled.plot(quantity, ax=axes)
        figure.canvas.draw()
        for axes in panels:
            (remark,) = (text for text in axes.texts if "friction" in text.get_text())
            box, label = remark.get_window_extent(), axes.xaxis.label.get_window_extent()
            # a label of two lines leaves the second one free
            lines = axes.get_xlabel().count("\n") + 1
            assert box.y1 <= label.y1 - label.height / lines or box.x0 >= label.x1 or box.x1 <= label.x0
        key = panels[1].get_legend().get_window_extent()
        title = panels[1].title.get_window_extent()
        left = panels[1]._left_title.get_window_extent()  # type: ignore[attr-defined]
        assert not any(key.overlaps(said) for said in (title, left) if said.width > 0.0)
        plt.close(figure)


def test_a_picture_is_about_as_wide_as_its_patch_and_cuts_no_title() -> None:
    def patch(semi_axes: tuple[float, float], said: str) -> tuple[float, float]:
        count = [round(2.4 * a / 2e-4) for a in semi_axes]
        x, y = ((np.arange(n) - 0.5 * (n - 1)) * 2e-4 for n in count)
        gap = 2e-5 * ((x / semi_axes[0]) ** 2 + (y[:, None] / semi_axes[1]) ** 2)
        normal = mtb.solve_normal(gap, 2e-4, lower=mtb.steel, upper=mtb.steel, approach=1.2e-5)
        motion = mtb.Rolling(creepage=(1e-3, 0.0, 0.0), velocity=20.0)
        rolled = mtb.solve_tangential(normal, motion, mtb.Coulomb(0.3))
        figures = [rolled.plot(word) for word in ("pressure", "status", "traction")]
        figures += [rolled.temperature().plot("temperature"), rolled.plot("pressure", title=said)]
        figures += [rolled.stress(depths=np.linspace(0.0, 8e-3, 9)).plot()]
        widths = []
        for figure in figures:
            figure.canvas.draw()
            box, axes = figure.bbox, figure.axes[0]
            words = [axes.title, axes._left_title, axes.xaxis.label, *axes.texts]  # type: ignore[attr-defined]
            for word in words:
                if word.get_text() and word.get_visible():
                    assert box.x0 <= word.get_window_extent().x0, word.get_text()
                    assert word.get_window_extent().x1 <= box.x1, word.get_text()
            widths.append(axes.get_window_extent().width / box.width)
            plt.close(figure)
        return min(widths), max(widths)

    said = "what a reader says of the pressure between both bodies"
    # of 3 inches, the words below a narrow map take about two
    assert patch((1e-3, 8e-3), said)[0] > 0.15
    assert patch((4e-3, 4e-3), said)[0] > 0.5
    assert patch((8e-3, 1e-3), said)[0] > 0.7

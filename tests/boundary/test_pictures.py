# SPDX-License-Identifier: MIT OR Apache-2.0
"""Maps, cuts, 3-D views and files of a result; what is missing is said, what is wrong is refused."""

from __future__ import annotations

import dataclasses
import functools
import io
import json
import pickle
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any, get_args

import matplotlib.pyplot
import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

import mtb_rs as mtb
from mtb_rs import PictureWarning
from mtb_rs.base import words
from mtb_rs.base.stored import plain_data
from mtb_rs.half_space import reference
from mtb_rs.pictures import moving_heat
from mtb_rs.pictures import space as view
from mtb_rs.pictures.files import save
from mtb_rs.pictures.moving import animate
from mtb_rs.pictures.quantities import drawable
from mtb_rs.results.fields import FIELDS
from mtb_rs.results.grids import borders, corners, flat, patches, quads
from mtb_rs.results.result import Pictured, Result

ROOT = Path(__file__).parents[2]
PNG = b"\x89PNG\r\n\x1a\n"
PATCH = reference.elliptic_pressure(1e3, (2e-3, 2e-3), (16, 16), mtb.steel, mtb.steel)
ROLL = mtb.Rolling(creepage=(5e-4, 3e-4, 0.6))
needs_gl = pytest.mark.skipif(view.missing_for_view() is not None, reason=str(view.missing_for_view()))


def pixels(figure: Figure) -> np.ndarray:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    assert buffer.getvalue().startswith(PNG)
    buffer.seek(0)
    return matplotlib.pyplot.imread(buffer)


@pytest.mark.parametrize("cells", [1, 2, 3, 5])
def test_steps_are_drawn_to_the_ends_of_their_bodies(cells: int) -> None:
    # their border points are the mean places of half hats, which lie inside of the nodes of the scene
    block = mtb.scenes.block_on_plane(spacing=0.1 / cells, friction=0.2)
    shoe = mtb.scenes.pole_shoe_on_rail(spacing=(0.09 / (cells + 2), 15.6e-3 / cells), friction=0.2)
    for scene, ends in ((block, (-50e-3, 50e-3)), (shoe, (-45e-3, 45e-3))):
        step = scene.prepare("elastic-upper").step(velocity=1.0)
        for patch in patches(step):
            x, y = corners(step, patch, flat(step, step.points)[:2])
            assert (x[:, 0], x[:, -1]) == (pytest.approx(ends[0]), pytest.approx(ends[1]))
            across = (6e-3, 21.6e-3) if scene is shoe else (-50e-3, 50e-3)
            assert sorted(np.abs(y[[0, -1]].mean(axis=1))) == pytest.approx(
                sorted(map(abs, across)), rel=1e-3
            )
            along = np.diff(x[0])
            if along.size > 2:
                assert along[[0, -1]] == pytest.approx([0.5 * along[1]] * 2)


def test_every_quantity_has_a_map_and_lines(pole_shoe_result: Result) -> None:
    known = drawable(pole_shoe_result)
    assert len(known) == 10
    for quantity in known:
        for picture in (
            pole_shoe_result.plot(quantity),
            pole_shoe_result.plot(quantity, y=(6e-3, 12e-3), body="upper"),
        ):
            assert pixels(picture).std() > 0.05
    # pyplot is in use here: the figures are its own
    assert len(matplotlib.pyplot.get_fignums()) == 2 * len(known)


@pytest.mark.slow
def test_results_on_fields_draw_and_save_themselves(tmp_path: Path) -> None:
    hertz = mtb.hertz(20e3, radii=(0.46, 0.3), lower=mtb.steel, upper=mtb.steel)
    normal = hertz.on_grid((24, 20), (0.45e-3, 0.4e-3))
    friction = mtb.Coulomb(0.3)
    rolling = mtb.solve_tangential(normal, mtb.Rolling(creepage=(5e-4, 3e-4, 0.6)), friction)
    shift = mtb.solve_tangential(normal, mtb.Shift(displacement=(3e-6, 0.0)), friction)
    fastsim = mtb.fastsim(normal, (5e-4, 3e-4, 0.6), friction)
    for result, quantities in ((normal, 4), (rolling, 10), (shift, 10), (fastsim, 8)):
        known = drawable(result)
        assert len(known) == quantities
        assert all(pixels(result.plot(quantity)).std() > 0.02 for quantity in known)
        written = result.save(tmp_path / type(result).__name__)
        summary = json.loads(written[-1].read_text(encoding="utf-8"))
        assert summary["normal_force"] == pytest.approx(20e3, rel=1e-6)
        with np.load(written[0].parent / "fields.npz") as fields:
            np.testing.assert_array_equal(fields["pressure"], result.pressure)
    # slip is relative in rolling, a length in a shift; arrows show where tractions turn
    assert [r.plot("slip").axes[1].get_ylabel() for r in (rolling, shift)] == ["|slip| [10⁻³]", "|slip| [µm]"]
    assert len(rolling.plot("traction").axes[0].collections) > len(
        normal.plot("pressure").axes[0].collections
    )
    with Image.open(animate([rolling, shift], tmp_path / "two.gif", "traction")) as moving:
        assert moving.n_frames == 2  # type: ignore[attr-defined]
    with pytest.raises(ValueError, match="quantity is 'slip': one of pressure, gap"):
        normal.plot("slip")
    assert len(repr(rolling)) < 200


def test_line_names_the_row_it_shows(pole_shoe_result: Result) -> None:
    axes = pole_shoe_result.plot("pressure", "line", y=(6e-3, 12e-3)).axes[0]
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["y = 7.5 mm", "y = 10.5 mm"]
    drawn = axes.patches[0].get_data()  # type: ignore[attr-defined]
    row = pole_shoe_result.patches[0].view(pole_shoe_result.pressure)[0]
    np.testing.assert_allclose(drawn.values, row / 1e6, rtol=1e-14)
    np.testing.assert_allclose(drawn.edges, np.linspace(-48, 48, 33), atol=1e-9)


def test_grid_result_and_scattered_result_have_maps(pole_shoe_result: Result) -> None:
    scattered = dataclasses.replace(pole_shoe_result, patches=())
    assert pixels(scattered.plot("pressure")).std() > 0.05
    with pytest.raises(ValueError, match="scattered"):
        scattered.plot("pressure", "line")
    left = pole_shoe_result.patches[0].view
    grid = dataclasses.replace(
        pole_shoe_result,
        patches=(),
        **{
            name: left(getattr(pole_shoe_result, name))
            for name in ("points", "area", "normal", "pressure", "traction", "gap", "initial_gap", "status")
        },
    )
    assert pixels(grid.plot("pressure")).std() > 0.05
    assert grid._repr_png_().startswith(PNG)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"quantity": "presure"}, "quantity is 'presure': one of pressure"),
        ({"kind": "maps"}, "kind is 'maps'"),
        ({"body": "shoe"}, "body is 'shoe'"),
        ({"kind": "map", "y": 0.01}, 'y is for kind="line"'),
        ({"kind": "map", "x": 0.01}, 'x is for kind="line"'),
        ({"x": 0.01, "y": 0.01}, "x and y are both given"),
        ({"x": float("nan")}, "x is nan: finite numbers"),
        ({"kind": "3d", "x": 0.01}, "x, y and ax are for maps and lines"),
        ({"y": float("nan")}, "finite numbers"),
        ({"scale": 2.0}, "unknown options"),
        ({"ax": 3}, "ax is 3: axes of matplotlib"),
        ({"ax": "left", "kind": "line"}, "ax is 'left': axes of matplotlib"),
    ],
)
def test_bad_options_are_named(pole_shoe_result: Result, options: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        pole_shoe_result.plot(**options)


@pytest.mark.parametrize("nodal", [False, True])
def test_cells_tile_the_patch(pole_shoe_result: Result, nodal: bool) -> None:
    patch = pole_shoe_result.patches[0]
    area = patch.view(pole_shoe_result.area).copy()
    if nodal:
        # points on the edge of the body own half a cell
        area[:, [0, -1]] *= 0.5
        area[[0, -1], :] *= 0.5
    flat_area = pole_shoe_result.area.copy()
    flat_area[: patch.nx * patch.ny] = area.ravel()
    result = dataclasses.replace(pole_shoe_result, area=flat_area)
    cells = quads(patch.nx, patch.ny)
    assert cells.shape == (patch.nx * patch.ny, 4)
    cx, cy = (corners(result, patch, result.points[i]).ravel()[cells] for i in (0, 1))
    doubled = (cx * np.roll(cy, -1, axis=1) - np.roll(cx, -1, axis=1) * cy).sum(axis=1)
    np.testing.assert_allclose(0.5 * doubled, area.ravel(), rtol=1e-9)
    np.testing.assert_allclose(borders(np.arange(4) * 2.0), [-1, 1, 3, 5, 7])
    np.testing.assert_allclose(borders(np.arange(4) * 2.0, (True, True)), [0, 1, 3, 5, 6])


@pytest.mark.parametrize("scale", ["a", float("nan"), True])
def test_a_scale_is_a_finite_number(pole_shoe_result: Result, scale: object) -> None:
    with pytest.raises(ValueError, match=f"scale is {scale!r}: a finite number"):
        pole_shoe_result.plot("pressure", "3d", scale=scale)


@needs_gl
def test_the_bar_in_space_says_what_it_leaves_out(pole_shoe_result: Result) -> None:
    largest = pole_shoe_result.pressure.max()
    for limits, wanted in (((0.0, 1e6), f"(largest {largest / 1e6:.3g})"), ((0.0, 2 * largest), "[MPa]")):
        plotter = pole_shoe_result.plot("pressure", "3d", off_screen=True, limits=limits)
        (title,) = plotter.scalar_bars.keys()
        plotter.close()
        assert title.strip().splitlines()[-1] == wanted


@needs_gl
def test_view_shows_bodies_and_pressure(pole_shoe_result: Result) -> None:
    plotter = pole_shoe_result.plot("pressure", "3d", off_screen=True, scale=500.0)
    image = plotter.screenshot(return_img=True)
    plotter.close()
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 500


@pytest.mark.coarse
def test_elastic_bodies_carry_their_displacement() -> None:
    result = mtb.scenes.pole_shoe_on_rail(spacing=6e-3).solve(model="elastic-both")
    drawn = {surface.name: surface for surface in view.bodies(result)}
    assert set(drawn) == {"left pole", "right pole", "rail", "rail mirrored"}
    assert all(surface.displacement is not None for surface in drawn.values())
    np.testing.assert_array_equal(drawn["rail"].vertices[1], -drawn["rail mirrored"].vertices[1])
    # the front of the sole moves most, and it is on the boundary
    inside = result.states()["left pole"].displacement
    np.testing.assert_array_equal(drawn["left pole"].displacement.min(axis=1)[2], inside[2].min())


@needs_gl
def test_html_page_stands_alone_or_names_the_package(pole_shoe_result: Result, tmp_path: Path) -> None:
    pytest.importorskip("trame_pyvista")
    pytest.importorskip("nest_asyncio2")
    ends = signal.getsignal(signal.SIGINT)
    page = view.write_html(pole_shoe_result, tmp_path / "shoe.html").read_text(encoding="utf-8")
    assert "<title>pressure - mtb_rs</title>" in page
    # Ctrl-C still ends what comes after
    assert signal.getsignal(signal.SIGINT) is ends
    assert len(page) > 300_000
    assert "<script" in page
    assert 'src="http' not in page


def screenshot(page: Path) -> np.ndarray:
    """What a browser without a screen makes of a page: (ny, nx, 3)."""
    browser = shutil.which("chromium") or shutil.which("google-chrome")
    if browser is None:
        pytest.skip("no browser: apt-get install chromium")
    picture = page.with_suffix(".png")
    command = [browser, "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader"]
    command += ["--enable-unsafe-swiftshader", "--virtual-time-budget=20000", "--window-size=800,600"]
    command += [f"--user-data-dir={page.parent / 'profile'}", f"--screenshot={picture}", page.as_uri()]
    subprocess.run(command, check=True, capture_output=True, timeout=180)
    with Image.open(picture) as image:
        return np.asarray(image.convert("RGB"), dtype=float) / 255.0


@needs_gl
def test_html_page_shows_the_pressure_in_a_browser(pole_shoe_result: Result, tmp_path: Path) -> None:
    pytest.importorskip("trame_pyvista")
    pytest.importorskip("nest_asyncio2")
    seen = screenshot(view.write_html(pole_shoe_result, tmp_path / "shoe.html"))
    # bodies in grey; the patches in colours beside the bar at the right; the axes alone are a tenth of this
    colourful = np.ptp(seen, axis=2)[:, :700] > 0.3
    assert 0.004 < colourful.mean() < 0.3
    assert 0.1 < (seen.mean(axis=2) < 0.9).mean() < 0.7


BODILESS = ("normal", "rolling", "fastsim", "step", "step from a file")


@functools.cache
def bodiless() -> dict[str, tuple[Pictured, str]]:
    """Results that have no bodies to draw, each with a quantity."""
    x = (np.arange(12) - 5.5) * 1e-4
    gap = (x[None, :] ** 2 + x[:, None] ** 2) / (2 * 0.05)
    normal = mtb.solve_normal(gap, 1e-4, lower=mtb.steel, upper=mtb.steel, force=20.0)
    motion, friction = mtb.Rolling(creepage=(1e-3, 0.0, 0.0)), mtb.Coulomb(0.3)
    contact = mtb.scenes.pole_shoe_on_rail(spacing=1e-2).prepare("half-space")
    step = contact.step(velocity=1.0)
    return {
        "normal": (normal, "gap"),
        "rolling": (mtb.solve_tangential(normal, motion, friction), "slip"),
        "fastsim": (mtb.fastsim(normal, (1e-3, 0.0, 0.0), friction), "traction"),
        "step": (step, "pressure"),
        "step from a file": (pickle.loads(pickle.dumps(contact)).step(velocity=1.0), "status"),
    }


@needs_gl
@pytest.mark.parametrize("kind", BODILESS)
def test_results_without_bodies_are_seen_in_space_and_as_a_page(kind: str, tmp_path: Path) -> None:
    pytest.importorskip("trame_pyvista")
    pytest.importorskip("nest_asyncio2")
    result, quantity = bodiless()[kind]
    plotter = result.plot(quantity, "3d", off_screen=True)
    picture = np.asarray(plotter.screenshot(return_img=True), dtype=float) / 255.0
    plotter.close()
    # the patch, beside the bar at the right
    assert (np.ptp(picture, axis=2)[:, :1100] > 0.2).mean() > (2e-4 if "file" in kind else 2e-3)
    page = view.write_html(result, tmp_path / "page.html", quantity).read_text(encoding="utf-8")
    assert len(page) > 300_000


@pytest.mark.parametrize("kind", BODILESS)
def test_results_without_bodies_are_saved(kind: str, tmp_path: Path) -> None:
    result, _ = bodiless()[kind]
    written = {path.name for path in result.save(tmp_path / "out")}
    assert {"summary.json", "fields.npz", "pressure.png"} <= written
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert summary["points"] == result.pressure.size
    assert summary["files"]
    with np.load(tmp_path / "out" / "fields.npz") as kept:
        np.testing.assert_array_equal(kept["pressure"], result.pressure)


def test_what_is_no_result_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="3 cannot be drawn"):
        animate([3], tmp_path / "a.gif")


def test_chart_page_draws_in_a_browser(tmp_path: Path) -> None:
    page = ROOT / "docs" / "charts" / "scene_paraboloid.html"
    seen = screenshot(Path(shutil.copy(page, tmp_path)))
    blank = tmp_path / "blank.html"
    blank.write_text("<!doctype html><title>nothing</title>")
    assert (np.ptp(seen, axis=2) > 0.3).mean() > 1e-3  # points and lines
    assert screenshot(blank).std() == 0.0


def test_animation_shares_one_scale(pole_shoe_result: Result, tmp_path: Path) -> None:
    half = dataclasses.replace(pole_shoe_result, pressure=0.5 * pole_shoe_result.pressure)
    for options in ({}, {"y": 12e-3}):
        path = animate([pole_shoe_result, half], tmp_path / "history.gif", **options)
        with Image.open(path) as moving:
            assert moving.n_frames == 2  # type: ignore[attr-defined]
    with Image.open(animate((r for r in (half, half)), tmp_path / "same.png")) as still:
        assert still.size == (1080, still.height)
    with pytest.raises(ValueError, match=r"\.gif, \.webp or \.png"):
        animate([half], tmp_path / "history.avi")
    with pytest.raises(ValueError, match="history is empty"):
        animate([], tmp_path / "history.gif")


def test_a_cut_along_y_goes_through_every_patch_there(pole_shoe_result: Result, tmp_path: Path) -> None:
    figure = pole_shoe_result.plot("pressure", x=(0.0, 30e-3))
    axes = figure.axes[0]
    assert axes.get_xlabel() == "y [mm]"
    column = (
        pole_shoe_result.points[0] == pole_shoe_result.points[0][np.abs(pole_shoe_result.points[0]).argmin()]
    )
    drawn = np.concatenate([stairs.get_data().values for stairs in axes.patches[:2]])  # type: ignore[attr-defined]
    np.testing.assert_array_equal(np.sort(drawn), np.sort(pole_shoe_result.pressure[column] / 1e6))
    assert len(axes.patches) == 4
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [
        "x = \N{MINUS SIGN}1.5 mm",
        "x = 28.5 mm",
    ]
    # the steps have the borders of the cells, which are 3 mm wide
    np.testing.assert_allclose(np.diff(axes.patches[0].get_data().edges), 3.0)  # type: ignore[attr-defined]
    names = {path.name for path in pole_shoe_result.save(tmp_path)}
    assert {"pressure_lines_along_y.png", "vertical_displacement_lines_along_y.png"} <= names
    assert pole_shoe_result.save(tmp_path)


@pytest.mark.parametrize("quantity", drawable(mtb.solve_tangential(PATCH, ROLL, mtb.Coulomb(0.3))))
@pytest.mark.parametrize("margin", [0, 2, 24])
def test_a_map_shows_the_contact_and_not_the_grid(quantity: str, margin: int) -> None:
    """The patch takes about half of the frame or more, however large the grid; none of it is cut off."""
    field = reference.elliptic_pressure(1e3, (2e-3, 2e-3), (16, 16), mtb.steel, mtb.steel, margin)
    rolling = mtb.solve_tangential(field, ROLL, mtb.Coulomb(0.3))
    axes = rolling.plot(quantity).axes[0]
    low, high = 1e-3 * np.array([axes.get_xlim(), axes.get_ylim()]).T
    x, y = rolling.points[:2, rolling.status > 0]
    assert low[0] < x.min() < x.max() < high[0]
    assert low[1] < y.min() < y.max() < high[1]
    filled = (rolling.status > 0).sum() * rolling.area[0, 0] / np.prod(high - low)
    assert filled > 0.45


def test_a_map_of_contact_everywhere_shows_the_grid(pole_shoe_result: Result) -> None:
    everywhere = dataclasses.replace(pole_shoe_result, status=np.full_like(pole_shoe_result.status, 2))
    axes = everywhere.plot("pressure").axes[0]
    x, y = pole_shoe_result.points[:2] * 1e3
    assert axes.get_xlim()[0] <= x.min() < x.max() <= axes.get_xlim()[1]
    assert axes.get_ylim()[0] <= y.min() < y.max() <= axes.get_ylim()[1]


def test_every_frame_says_what_it_shows(
    pole_shoe_result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    above = Figure.suptitle
    monkeypatch.setattr(
        Figure,
        "suptitle",
        lambda self, text, **k: said.append(text) or above(self, text, **k),  # type: ignore[func-returns-value]
    )
    more = dataclasses.replace(
        pole_shoe_result,
        summary={**pole_shoe_result.summary, "friction": 0.6, "velocity": 3.0, "length": 0.2},
    )
    less = dataclasses.replace(pole_shoe_result, summary={**pole_shoe_result.summary, "length": 0.09})
    animate([less, more], tmp_path / "a.gif")
    animate([less, less], tmp_path / "a.gif", x=0.0)
    animate([less, less], tmp_path / "a.gif", captions=["t = 0 s", "t = 1 s"])
    assert said[:2] == ["friction 0.5, length 90 mm", "friction 0.6, length 200 mm"]
    assert said[2:] == ["step 1 of 2", "step 2 of 2", "t = 0 s", "t = 1 s"]
    with pytest.raises(ValueError, match="captions has 1 entries: one for each of the 2 results is needed"):
        animate([less, less], tmp_path / "a.gif", captions=["t = 0 s"])


def test_the_words_are_those_that_are_checked() -> None:
    """What a type checker accepts as a field is what can be drawn."""
    assert get_args(words.Field) == tuple(dict.fromkeys(w for field in FIELDS.values() for w in field.words))


def test_limits_set_the_scale(pole_shoe_result: Result) -> None:
    figure = pole_shoe_result.plot("pressure", limits=(0.0, 20e6))
    assert figure.axes[0].collections[1].get_clim() == (0.0, 20.0)
    lines = pole_shoe_result.plot("pressure", "line", limits=(0.0, 20e6))
    assert lines.axes[0].get_ylim() == (0.0, 20.0)
    with pytest.raises(ValueError, match="limits is"):
        pole_shoe_result.plot("pressure", limits=(1.0, 1.0))


def test_save_writes_complete_files(pole_shoe_result: Result, tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    directory = tmp_path / "deep" / "out"
    if view.missing_for_view() is None:
        written = save(pole_shoe_result, directory)
        assert directory / "view.png" in written
    else:
        with pytest.warns(PictureWarning, match="apt-get install"):
            written = save(pole_shoe_result, directory)
    assert all(path.stat().st_size > 0 for path in written)
    assert sorted(written) == sorted(directory.iterdir())
    assert list(directory.parent.iterdir()) == [directory]

    summary = json.loads((directory / "summary.json").read_text(), parse_constant=pytest.fail)
    assert summary["inputs"]["friction"] == 0.5
    assert summary["patches"]["left pole"]["in_contact"] == 150
    with np.load(directory / "fields.npz") as fields:
        np.testing.assert_array_equal(fields["traction"], pole_shoe_result.traction)
    contact = pyvista.read(directory / "contact.vtp")
    np.testing.assert_array_equal(contact.cell_data["pressure"], pole_shoe_result.pressure)
    np.testing.assert_allclose(contact.cell_centers().points.T[:2], pole_shoe_result.points[:2], atol=1e-9)
    assert contact.cell_data["displacement_lower"].shape == (640, 3)


def test_saving_again_leaves_nothing_of_the_old_result(pole_shoe_result: Result, tmp_path: Path) -> None:
    save(pole_shoe_result, tmp_path)
    (tmp_path / "notes.txt").write_text("the user's own")
    renamed = dataclasses.replace(pole_shoe_result, surfaces=pole_shoe_result.surfaces[:1])
    written = save(renamed, tmp_path)
    assert not (tmp_path / "body_left_pole.vtp").exists()
    assert {path.name for path in tmp_path.iterdir()} == {path.name for path in written} | {"notes.txt"}


def ask_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Probes again in this test only: later tests keep the answer and do not depend on another probe."""
    monkeypatch.setattr(view, "_missing_driver", functools.cache(view._missing_driver.__wrapped__))


def test_without_pyvista_the_rest_is_written(
    pole_shoe_result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyvista", None)
    ask_anew(monkeypatch)
    with pytest.warns(PictureWarning, match=r"mtb-rs\[viz\]"):
        written = {path.name for path in save(pole_shoe_result, tmp_path / "out")}
    assert {"summary.json", "fields.npz", "pressure.png", "pressure_lines.png"} <= written
    assert "view.png" not in written
    assert len(json.loads((tmp_path / "out" / "summary.json").read_text())["notices"]) == 2


def test_missing_driver_names_the_packages(monkeypatch: pytest.MonkeyPatch, pole_shoe_result: Result) -> None:
    pytest.importorskip("pyvista")
    crashed = subprocess.CompletedProcess([], -11)  # type: ignore[var-annotated]
    monkeypatch.setattr(view.subprocess, "run", lambda *_, **__: crashed)  # type: ignore[attr-defined]
    ask_anew(monkeypatch)
    with pytest.raises(mtb.ViewError, match="apt-get install libegl1 libgl1-mesa-dri"):
        pole_shoe_result.plot("pressure", "3d")


def test_json_holds_no_nan() -> None:
    value = {
        "a": np.array([1.0, np.nan]),
        "b": (np.float32(2.0), Path("x")),
        3: float("inf"),
        "n": np.int8(1),
    }
    assert plain_data(value) == {"a": [1.0, None], "b": [2.0, "x"], "3": None, "n": 1}


def test_target_that_is_a_file_is_refused(pole_shoe_result: Result, tmp_path: Path) -> None:
    target = tmp_path / "out"
    target.write_text("")
    with pytest.raises(ValueError, match="not a directory"):
        save(pole_shoe_result, target)


def test_two_rows_of_nodes_are_drawn_as_half_cells() -> None:
    """Poles of two rows end where their nodes do, and do not overlap."""
    scene = mtb.scenes.pole_shoe_on_rail(friction=0.12, velocity=20.0, spacing=12e-3)
    result = scene.solve(model="elastic-upper")
    low, high = result.plot("pressure").axes[0].get_ylim()
    reached = 1e3 * float(np.abs(result.points[1]).max())
    assert (-low, high) == pytest.approx((reached, reached), rel=1e-9)


def test_the_status_names_what_yields() -> None:
    hertz = mtb.hertz(80e3, semi_axes=(6e-3, 4e-3)).on_grid((20, 24), (0.58e-3, 0.48e-3))
    layer = mtb.PlasticLayer(20e-6, 8e9, 150e6, 5e12)
    rolled = mtb.solve_tangential(hertz, mtb.Rolling((4e-3, 0.0, 0.0)), mtb.Coulomb(0.4), layer=layer)
    assert (rolled.status == 3).any()
    figure = rolled.plot("status")
    assert isinstance(figure, Figure)
    legend = figure.axes[0].get_legend()
    assert legend is not None
    named = [text.get_text() for text in legend.get_texts()]
    assert named == [
        name
        for code, name in enumerate(("open", "stick", "slip", "plastic"))
        if (rolled.status == code).any()
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("spacing", "width", "length"), [(25e-3, 0.1, 0.1), ((25e-3, 10e-3), 0.2, 0.03)], ids=["beside", "below"]
)
def test_frames_of_a_slide_are_laid_out_as_the_first(
    spacing: Any, width: float, length: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shoe = mtb.scenes.block_on_plane(width, spacing=spacing, friction=0.2, velocity=10.0, length=length)
    heat = shoe.sliding_heat(1.0, 2, wear=1e-11)
    each: list[list[np.ndarray]] = []

    def kept(frames: Any, target: Path, _: float) -> Path:
        each.append(list(frames))
        return target

    monkeypatch.setattr(moving_heat, "moving_picture", kept)
    heat.animate(tmp_path / "a.gif", frames=2)
    monkeypatch.setattr(moving_heat, "_placed", lambda figure, places: None)
    heat.animate(tmp_path / "a.gif", frames=2)
    once, anew = each
    # to the last pixel, and they do change
    assert all(np.array_equal(one, other) for one, other in zip(once, anew, strict=True))
    assert not np.array_equal(once[0], once[1])


@pytest.mark.parametrize(
    ("shape", "spacing"),
    [((1, 15), (1e-3, 20e-3)), ((15, 1), (20e-3, 1e-3)), ((1, 5), (1e-3, 1e-3)), ((1, 1), (2e-3, 2e-3))],
)
def test_a_row_that_touches_everywhere_is_drawn_with_its_cells_and_saved(
    shape: tuple[int, int], spacing: tuple[float, float], tmp_path: Path
) -> None:
    given: dict[str, Any] = {"lower": mtb.steel, "upper": mtb.steel, "force": 100.0, "edge": "sharp"}
    normal = mtb.solve_normal(np.zeros(shape), spacing, **given)
    rolling = mtb.solve_tangential(normal, mtb.Rolling((1e-3, 0.0, 0.0)), mtb.Coulomb(0.3))
    (rows, columns), (dx, dy) = shape, spacing
    for result in (normal, rolling):
        axes = result.plot("pressure").axes[0]
        size = 1e3 * columns * dx, 1e3 * rows * dy
        assert (np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())) == pytest.approx(size, rel=1e-6)
        assert result._repr_png_()
        result.save(tmp_path / type(result).__name__)
    read = mtb.load(tmp_path / "TangentialResult")
    np.testing.assert_array_equal(read.pressure, rolling.pressure)
    # where all slides, what wears off is the law times the work of friction, which is force times creepage
    assert (rolling.status == 2).all()
    work = float(rolling.force[0]) * 1e-3
    assert rolling.wear_depth(1e-13).sum() * dy == pytest.approx(1e-13 * work / 0.3, rel=1e-6)


def test_a_shoe_of_one_row_of_cells_is_drawn_and_saved(tmp_path: Path) -> None:
    shoe = mtb.scenes.pole_shoe_on_rail(poles=1, spacing=12e-3, friction=0.2, velocity=5.0)
    result = shoe.solve(model="half-space")
    assert result.patches[0].ny == 1
    result.save(tmp_path / "result")
    mtb.wear(shoe, 1.0, 1e-13, model="half-space").save(tmp_path / "wear")
    assert (tmp_path / "result" / "pressure.png").exists()
    assert (tmp_path / "wear" / "pressure.png").exists()

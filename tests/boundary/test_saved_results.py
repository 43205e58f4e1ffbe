# SPDX-License-Identifier: MIT OR Apache-2.0
"""Saved results come back as they were: fields, pictures, files; what is no saved result is refused."""

from __future__ import annotations

import functools
import hashlib
import json
import pickle
import re
import shutil
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import jsonschema
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import mtb_rs as mtb
from mtb_rs.base.plain import same
from mtb_rs.base.stored import input_data
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.commands import main
from mtb_rs.commands.exits import BAD_INPUT
from mtb_rs.half_space import reference
from mtb_rs.pictures import space
from mtb_rs.pictures.quantities import drawable
from mtb_rs.results.chart import Figure
from mtb_rs.results.saved import FIELDS, REST, RESULT, SUMMARY

PATCH = reference.elliptic_pressure(1e3, (2e-3, 2e-3), (10, 8), mtb.steel, mtb.steel)
ROLL, COULOMB = mtb.Rolling(creepage=(5e-4, 3e-4, 0.6)), mtb.Coulomb(0.3)


def normal() -> mtb.NormalResult:
    x = (np.arange(10) - 4.5) * 1e-4
    gap = (x[None, :] ** 2 + x[:, None] ** 2) / (2 * 0.05)
    return mtb.solve_normal(gap, 1e-4, lower=mtb.Rigid(), upper=mtb.steel, force=15.0)


def transient() -> mtb.TangentialResult:
    shift = mtb.solve_tangential(PATCH, mtb.Shift(displacement=(3e-6, 0.0)), COULOMB)
    motion = mtb.Rolling(creepage=(5e-4, 0.0, 0.0), transient=True, step=4e-4)
    return mtb.solve_tangential(PATCH, motion, COULOMB, state=shift.state)


@functools.cache
def wheel_step() -> mtb.WheelStep:
    wheels = mtb.scenes.wheel_on_rail(spacing=1e-3).prepare()
    return wheels.step(velocity=20.0)


def sliding(pressure: Any = "follows") -> mtb.StartOfSliding:
    pushes = [[1e-7, 0.0], [1e-6, 1e-7]]
    return mtb.scenes.pole_shoe_on_rail(spacing=1e-2).start_of_sliding(
        pushes, "half-space", pressure=pressure
    )


def bare_sliding() -> mtb.StartOfSliding:
    """Of a compliance alone, which does not know where its points lie."""
    problem = mtb.scenes.block_on_plane(spacing=2e-2).problem("half-space")
    pressure = np.full(problem.n, 1e6)
    return mtb.start_of_sliding(problem.core.pair, pressure, problem.area, 0.3, [[1e-7, 0.0]])


@functools.cache
def two_wheels(height: float = np.nan) -> mtb.WheelStep:
    wheels = mtb.scenes.wheel_on_rail(spacing=1e-3).prepare(side="both")
    return wheels.step(pose=[0.0, 0.0, height, np.nan if np.isnan(height) else 0.0, 0.0, 0.0], velocity=20.0)


#: A result of every kind that can be saved.
MADE: dict[str, Callable[[], Any]] = {
    "incremental": lambda: mtb.scenes.paraboloid_on_plane(points=12).solve(
        "half-space", method="incremental"
    ),
    "own friction": lambda: mtb.scenes.block_on_plane(
        friction=lambda x, y: 0.1 + 0.0 * x, spacing=2e-2
    ).solve("half-space"),
    "elastic": lambda: mtb.scenes.pole_shoe_on_rail(spacing=1e-2).solve("elastic-both"),
    "normal": normal,
    "rolling": lambda: mtb.solve_tangential(PATCH, ROLL, COULOMB),
    "transient": transient,
    "shift": lambda: mtb.solve_tangential(PATCH, mtb.Shift(displacement=(3e-6, 0.0)), COULOMB),
    "fastsim": lambda: mtb.fastsim(PATCH, (5e-4, 3e-4, 0.6), COULOMB),
    "step": lambda: mtb.scenes.pole_shoe_on_rail(spacing=1e-2).prepare("half-space").step(velocity=1.0),
    "wheel patch": lambda: wheel_step().patches[0],
    "wheel step": wheel_step,
    "two wheels": two_wheels,
    "lifted wheels": lambda: two_wheels(5e-2),
    "sliding": sliding,
    "sliding under held pressure": lambda: sliding("held"),
    "sliding of a compliance": bare_sliding,
    "hertz": lambda: mtb.hertz(1e3, (0.5, 0.2), upper=mtb.Rigid()),
}
#: Tables and charts, which have no contact points.
STUDIES: dict[str, Callable[[], Any]] = {
    "chart": lambda: mtb.Chart(
        "a scene",
        (
            mtb.ChartPoint("fast", 1e-3, 100, (0.1, 0.2), (0.1, 0.2), {"pressure": 0.1, "force": 1e-3}),
            mtb.ChartPoint("slow", 5e-4, 400, (1.0,), (1.1,), {"pressure": 0.01}, 7, 2.5, "dense"),
            mtb.ChartPoint("broken", 5e-4, 400, (1.0,), (1.1,), failure="too coarse"),
        ),
        "a closed form",
        0.0,
        figures=(Figure("a paper", 20.0), Figure("another", 30.0, 0.02)),
        remark="Nothing is left out.",
    ),
    "sweep": lambda: mtb.sweep(
        mtb.scenes.block_on_plane(spacing=2e-2),
        {
            "friction": [0.1, 0.3],
            "supports": {"free": "driven-top", "held": "clamped-top"},
            "magnetic_pressure": [1e5, 5e5],
        },
        model="half-space",
    ),
    "area-load curve": lambda: mtb.area_load_curve(
        1e-7 * np.cos(np.arange(16.0))[:, None] * np.cos(np.arange(16.0)) + 1e-7,
        1e-6,
        [2e-3, 1e-3],
        lower=mtb.steel,
        upper=mtb.Rigid(),
    ),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], tuple[Any, Path]]:
    """A result of a kind, and where it was saved."""

    @functools.cache
    def made(kind: str) -> tuple[Any, Path]:
        # whichever test comes first makes it, also one that is not coarse itself
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", mtb.ToleranceWarning)
            result = (MADE | STUDIES)[kind]()
        place = tmp_path_factory.mktemp(kind.replace(" ", "_"))
        result.save(place)
        return result, place

    return made


@pytest.mark.slow
@pytest.mark.coarse
@pytest.mark.parametrize("kind", MADE)
def test_a_saved_result_comes_back_as_it_was(
    kind: str, folder: Callable[[str], tuple[Any, Path]], tmp_path: Path
) -> None:
    result, place = folder(kind)
    loaded: Any = mtb.load(place)
    assert type(loaded) is type(result)
    assert (repr(loaded), str(loaded)) == (repr(result), str(result))
    for mine, theirs in ((result.fields(), loaded.fields()), (result.totals(), loaded.totals())):
        assert list(mine) == list(theirs)
        for name, field in mine.items():
            assert field == theirs[name]
            assert field.values.tobytes() == theirs[name].values.tobytes()
            assert field.values.dtype == theirs[name].values.dtype
    for name in ("report", "state", "motion", "patches", "surfaces", "coefficients", "error_estimate"):
        assert same(getattr(loaded, name, None), getattr(result, name, None)), name
    if loaded.blank:
        with pytest.raises(ValueError, match=re.escape(loaded.blank)):
            loaded.plot("pressure")
    else:
        for word in drawable(loaded._picture()):
            for picture in ("map", "line"):
                assert loaded.plot(word, picture).axes
    for word in loaded.curves:
        assert loaded.plot(word).axes
    # everything again, pictures in space included
    loaded.save(tmp_path / "again")
    written = sorted(path.name for path in place.iterdir())
    assert sorted(path.name for path in (tmp_path / "again").iterdir()) == written
    for name in written:
        assert (place / name).read_bytes() == (tmp_path / "again" / name).read_bytes(), name


#: Kinds that have no picture in space, each with a word of the reason.
FLAT = {
    "two wheels": "too far apart",
    "lifted wheels": "lifted",
    "sliding of a compliance": "the places of its points",
}
needs_gl = pytest.mark.skipif(space.missing_for_view() is not None, reason=str(space.missing_for_view()))


@needs_gl
@pytest.mark.coarse
@pytest.mark.parametrize("kind", MADE | STUDIES)
def test_every_kind_has_the_pictures_of_the_table_in_the_docs(
    kind: str, folder: Callable[[str], tuple[Any, Path]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    result, place = folder(kind)
    page, moving = tmp_path / "page.html", tmp_path / "moving.gif"
    show = ["show", str(place), "-o", str(page), "--quantity", "pressure", "--kind", "3d"]
    if kind in FLAT or kind in STUDIES:
        with pytest.raises(ValueError, match=FLAT.get(kind, "cannot be drawn")):
            mtb.write_html(result, page)
        assert main(show) == BAD_INPUT
        assert not page.exists()
        return
    assert "<html" in mtb.write_html(result, page).read_text(encoding="utf-8")
    assert result.to_pyvista()["contact"].n_cells > 0
    assert mtb.animate([result], moving).stat().st_size > 0
    page.unlink()
    if kind == "hertz":
        assert main(show) == 0
        assert "<html" in page.read_text(encoding="utf-8")
    for curve in result.curves:
        for asked in ([], ["--quantity", curve]):
            assert main([*show[:4], *asked, "--kind", "3d"]) == BAD_INPUT
            said = capsys.readouterr().err
            assert "--quantity pressure" in said
            assert "off_screen" not in said
            assert not page.exists()


@pytest.mark.coarse
@pytest.mark.parametrize("kind", MADE | STUDIES)
def test_every_kind_is_pickled_and_shown(kind: str, folder: Callable[[str], tuple[Any, Path]]) -> None:
    result, place = folder(kind)
    loaded = mtb.load(place)
    assert same(pickle.loads(pickle.dumps(loaded)), loaded)
    assert same(pickle.loads(pickle.dumps(result)), result)
    page = result._repr_html_()
    assert "<table>" in page
    assert result.told()
    picture = place.parent / f"{place.name}.png"
    if kind == "lifted wheels":
        assert main(["show", str(place)]) == 0
        return
    assert "<img" in page
    drawn = ["--quantity", "normal_force"] if kind == "sweep" else []
    assert main(["show", str(place), "-o", str(picture), *drawn]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.coarse
@pytest.mark.parametrize("kind", MADE)
def test_every_field_of_every_kind_goes_to_other_libraries(
    kind: str, folder: Callable[[str], tuple[Any, Path]]
) -> None:
    result, _ = folder(kind)
    if result.blank:
        for door in (result.to_xarray, result.to_pyvista):
            with pytest.raises(ValueError, match=re.escape(result.blank)):
                door()
        return
    labelled, meshes = result.to_xarray(), result.to_pyvista()
    contact = meshes["contact"]
    fields = {name: field for name, field in result.fields().items() if name != "points"}
    assert set(labelled.data_vars) == set(fields)
    for name, field in fields.items():
        there = labelled[name]
        assert there.attrs == {"long_name": field.label} | ({"units": field.unit} if field.unit else {})
        if field.is_vector:
            for axis, values in zip("xyz", field.values, strict=False):
                np.testing.assert_array_equal(there.sel(component=axis).values.ravel(), values.ravel())
            rest = there.values[len(field.values) :]
        else:
            np.testing.assert_array_equal(there.values.ravel(), field.values.ravel())
            rest = np.zeros(0)
        assert not rest.any()
        # points have more than two numbers where pyvista keeps them as vectors
        block = contact[name].T if field.is_vector else contact[name]
        np.testing.assert_array_equal(
            block[: len(field.values)].ravel() if field.is_vector else block, field.values.ravel()
        )
    assert set(labelled.attrs) == set(result.totals())


@pytest.mark.coarse
@pytest.mark.parametrize("kind", STUDIES)
def test_a_study_comes_back_as_it_was(
    kind: str, folder: Callable[[str], tuple[Any, Path]], tmp_path: Path
) -> None:
    study, place = folder(kind)
    loaded: Any = mtb.load(place)
    assert type(loaded) is type(study)
    assert loaded == study
    assert (repr(loaded), str(loaded)) == (repr(study), str(study))
    assert loaded.plot("normal_force").axes if kind == "sweep" else loaded.plot().axes
    time.sleep(1.1)  # files that tell their time tell it in seconds
    loaded.save(tmp_path / "again", name="other")
    stem = study.usual_name
    for path in place.iterdir():
        again = tmp_path / "again" / path.name.replace(stem, "other")
        content = path.read_bytes().replace(f'"{stem}.npz"'.encode(), b'"other.npz"')
        assert again.read_bytes() == content, path.name
    assert mtb.load(tmp_path / "again" / "other.json") == study
    # what an earlier one has left is replaced, and nothing else
    loaded.save(place)
    (place / f"{stem}.json").write_text("{}", encoding="utf-8")
    with pytest.raises(ValueError, match="has written it: it would be overwritten"):
        loaded.save(place)


@pytest.mark.coarse
def test_several_things_in_a_directory_are_told_apart(
    folder: Callable[[str], tuple[Any, Path]], tmp_path: Path
) -> None:
    chart, curve = STUDIES["chart"](), STUDIES["area-load curve"]()
    chart.save(tmp_path)
    assert mtb.load(tmp_path) == chart
    curve.save(tmp_path)
    (tmp_path / "notes.json").write_text('{"mine": 1}', encoding="utf-8")
    with pytest.raises(ValueError, match=r"holds area_load.json, chart.json: the path of one"):
        mtb.load(tmp_path)
    assert mtb.load(tmp_path / "chart.json") == chart
    assert mtb.load(tmp_path / "area_load.json") == curve
    result, _ = folder("normal")
    result.save(tmp_path)
    for path in (tmp_path, tmp_path / SUMMARY, tmp_path / RESULT):
        assert isinstance(mtb.load(path), mtb.NormalResult)
    assert mtb.load(tmp_path / "chart.json") == chart


#: What is done to a saved sweep, and what the refusal says.
STUDY_DAMAGES: dict[str, tuple[Callable[[Path], Any], str]] = {
    "later form": (lambda p: _record(p, schema=99), "was saved in format 99"),
    "no JSON": (lambda p: (p / "sweep.json").write_text("{"), "no result was saved there"),
    "no arrays": (lambda p: (p / "sweep.npz").unlink(), "sweep.npz cannot be read"),
    "other arrays": (lambda p: _other_columns(p), "differs from the one in sweep.json"),
    "no sums": (lambda p: _record(p, sha256={}), "is missing"),
    "another number": (lambda p: _other_number(p), "sweep.json is not the file that was saved"),
    "shapes": (lambda p: _other_columns(p, is_told=True), "has the shape"),
    "no study": (lambda p: _record(p, result={"tuple": []}), "no result was saved there"),
}


def _record(place: Path, **changes: Any) -> None:
    found = json.loads((place / "sweep.json").read_text(encoding="utf-8")) | changes
    (place / "sweep.json").write_text(json.dumps(found), encoding="utf-8")


def _other_number(place: Path) -> None:
    text = (place / "sweep.json").read_text(encoding="utf-8")
    assert '"friction"' in text
    (place / "sweep.json").write_text(text.replace('"friction"', '"frictoin"'), encoding="utf-8")


def _other_columns(place: Path, is_told: bool = False) -> None:
    with np.load(place / "sweep.npz") as arrays:
        kept = {name: array[:1] for name, array in arrays.items()}
    np.savez(place / "sweep.npz", **kept)
    if is_told:
        _record(place, sha256={"sweep.npz": hashlib.sha256((place / "sweep.npz").read_bytes()).hexdigest()})


@pytest.mark.coarse
@pytest.mark.parametrize("damage", STUDY_DAMAGES)
def test_a_damaged_study_is_refused_in_a_sentence(
    damage: str, folder: Callable[[str], tuple[Any, Path]], tmp_path: Path
) -> None:
    STUDIES["sweep"]().save(tmp_path / "out")
    harm, said = STUDY_DAMAGES[damage]
    harm(tmp_path / "out")
    with pytest.raises(ValueError) as caught:  # noqa: PT011 (the message is looked at below)
        mtb.load(tmp_path / "out")
    assert said in str(caught.value)
    assert str(tmp_path) in str(caught.value)


def test_the_fields_of_a_step_are_its_forces() -> None:
    """All patches together, in the track, carry what the step says."""
    for step in (wheel_step(), two_wheels()):
        fields = {name: field.values for name, field in step.fields().items()}
        load = (fields["traction"] - fields["normal"] * fields["pressure"]) * fields["area"]
        assert load.sum(axis=1) == pytest.approx(step.force, rel=1e-9)
        moment = np.cross(fields["points"].T - step.reference_point, load.T).sum(axis=0)
        # forces act on the undeformed surface of the wheel, an approach away
        assert moment == pytest.approx(step.moment, abs=1e-3 * np.abs(step.force).max())


@pytest.mark.coarse
def test_elastic_bodies_come_back_with_their_stresses(folder: Callable[[str], tuple[Any, Path]]) -> None:
    result, place = folder("elastic")
    loaded = mtb.load(place)
    states = result.states()
    assert [solid.name for solid in loaded.solids()] == list(states)
    for solid in loaded.solids():
        state = states[solid.name]
        assert np.array_equal(solid.displacement, state.displacement)
        assert np.array_equal(solid.stress, state.stress)
        assert same(dict(solid.reactions), dict(state.reactions))
    assert [same(a, b) for a, b in zip(space.bodies(loaded), space.bodies(result), strict=True)]
    with pytest.raises(ValueError, match=r"in solids\(\)"):
        loaded.states()


def test_what_is_loaded_can_be_solved_on(folder: Callable[[str], tuple[Any, Path]]) -> None:
    (pressed, place), (shifted, other) = folder("normal"), folder("shift")
    again, state = mtb.load(place), mtb.load(other).state
    rolled = [mtb.solve_tangential(r, ROLL, COULOMB) for r in (pressed, again)]
    assert np.array_equal(rolled[0].traction, rolled[1].traction)
    assert state == shifted.state


def test_units_are_those_of_the_motion(folder: Callable[[str], tuple[Any, Path]]) -> None:
    units = {"rolling": ("1", "Pa"), "shift": ("m", "J/m^2"), "wheel patch": ("m/s", "W/m^2")}
    for kind, wanted in units.items():
        fields = folder(kind)[0].fields()
        assert tuple(fields[name].unit for name in ("slip", "dissipation")) == wanted
    said = json.loads((folder("shift")[1] / SUMMARY).read_text(encoding="utf-8"))["fields"]
    assert said["slip"] == {"label": "slip", "unit": "m"}


def _told(found: dict[str, Any]) -> str:
    """A record as text, with the checksum that its numbers and text have."""
    canonical = json.dumps(found["result"], sort_keys=True, separators=(",", ":")).encode()
    found["sha256"]["result"] = hashlib.sha256(canonical).hexdigest()
    return json.dumps(found)


def _result(place: Path, change: Callable[[dict[str, Any]], Any], is_told: bool = True) -> None:
    found = json.loads((place / RESULT).read_text(encoding="utf-8"))
    change(found["result"]["of"])
    (place / RESULT).write_text(_told(found) if is_told else json.dumps(found), encoding="utf-8")


def _arrays(place: Path, is_told: bool = True, **changes: Any) -> None:
    """Changes arrays; with the sums of the files as well, where that is not left out."""
    with np.load(place / FIELDS) as arrays:
        kept = dict(arrays)
    np.savez(place / FIELDS, **kept | changes)
    if is_told:
        found = json.loads((place / RESULT).read_text(encoding="utf-8"))
        found["sha256"][FIELDS] = hashlib.sha256((place / FIELDS).read_bytes()).hexdigest()
        (place / RESULT).write_text(json.dumps(found), encoding="utf-8")


def _swapped(place: Path) -> None:
    """One value of the pressure is another, of the same size and sign."""
    with np.load(place / FIELDS) as arrays:
        pressure = arrays["pressure"]
    pressure[np.argmax(pressure)] *= 1.0 - 1e-15
    _arrays(place, is_told=False, pressure=pressure)


def _sums(place: Path, sums: Any) -> None:
    found = json.loads((place / RESULT).read_text(encoding="utf-8")) | {"sha256": sums}
    (place / RESULT).write_text(json.dumps(found), encoding="utf-8")


def _summary(place: Path, **changes: Any) -> None:
    found = json.loads((place / SUMMARY).read_text(encoding="utf-8")) | changes
    kept = {key: value for key, value in found.items() if value is not None}
    (place / SUMMARY).write_text(json.dumps(kept), encoding="utf-8")


#: What is done to a saved result, and what the refusal says.
DAMAGES: dict[str, tuple[Callable[[Path], Any], str]] = {
    "no directory": (shutil.rmtree, "is no directory"),
    "no summary": (lambda p: (p / SUMMARY).unlink(), "no result was saved there"),
    "foreign summary": (lambda p: (p / SUMMARY).write_text('{"files": []}'), "no result was saved there"),
    "interrupted": (lambda p: _summary(p, is_complete=False), "saving it was interrupted"),
    "before loading": (lambda p: _summary(p, schema=None), "did not yet keep what loading needs"),
    "later form": (lambda p: _summary(p, schema=99), "in format 99"),
    "no structure": (lambda p: (p / RESULT).unlink(), f"{RESULT} cannot be read: No such file"),
    "no JSON": (lambda p: (p / RESULT).write_text("{"), f"{RESULT} cannot be read: it is no JSON"),
    "deep JSON": (lambda p: (p / RESULT).write_text("[" * 100_000), f"{RESULT} cannot be read"),
    "too much text": (lambda p: (p / RESULT).write_bytes(b" " * 16_000_001), "bytes: at most"),
    "no arrays": (lambda p: (p / FIELDS).unlink(), f"{FIELDS} cannot be read: No such file"),
    "half an archive": (
        lambda p: (p / FIELDS).write_bytes((p / FIELDS).read_bytes()[:500]),
        f"{FIELDS} cannot be read",
    ),
    "objects": (lambda p: _arrays(p, pressure=np.array([{}], dtype=object)), f"{FIELDS} cannot be read"),
    "an array is missing": (lambda p: _without_rest(p), "is missing"),
    "arrays are missing": (lambda p: (p / REST).unlink(), f"{REST} cannot be read: No such file"),
    "another pressure": (_swapped, f"{FIELDS} is not the file that was saved"),
    "another peak pressure": (
        lambda p: _result(p, lambda of: of["report"]["of"].update(peak_pressure=1.0), is_told=False),
        f"{RESULT} is not the file that was saved",
    ),
    "another model": (
        lambda p: _result(p, lambda of: of["report"]["of"].update(model="rigid"), is_told=False),
        f"{RESULT} is not the file that was saved",
    ),
    "arrays of another result": (lambda p: _sums(p, {FIELDS: "0"}), f"{FIELDS} is not the file"),
    "no sums": (lambda p: _sums(p, {}), f"{FIELDS} is not the file"),
    "sums of another kind": (lambda p: _sums(p, [1]), "the checksums of its arrays are damaged"),
    "another class": (lambda p: _kind(p, "Popen"), "is of the kind 'Popen', which is not known"),
    "no result": (lambda p: _kind(p, "Material", young_modulus=1e9, poisson_ratio=0.3), "is no result"),
    "unknown entry": (lambda p: _result(p, lambda of: of.update(shell="ls")), "result.shell is not known"),
    "missing entry": (lambda p: _result(p, lambda of: of.pop("gap")), "result.gap is missing"),
    "wrong type": (lambda p: _result(p, lambda of: of.update(normal_force="1")), "of the wrong type: str"),
    "NaN": (lambda p: _result(p, lambda of: of.update(normal_force={"float": "nan"})), "NaN or infinite"),
    "shapes": (lambda p: _arrays(p, gap=np.zeros(7)), "gap has the shape"),
    "complex": (lambda p: _arrays(p, gap=np.zeros(64) * 1j), "gap is of the wrong type"),
    "codes": (lambda p: _scaled(p, "status", 7), "status holds other numbers"),
    "areas": (lambda p: _scaled(p, "area", -1), "area is negative"),
    "grids": (lambda p: _result(p, _shifted_grid), "does not fit the points"),
    "triangles": (lambda p: _result(p, _one_triangle), "does not fit together"),
}


def _without_rest(place: Path) -> None:
    (place / REST).unlink()
    found = json.loads((place / RESULT).read_text(encoding="utf-8"))
    found["sha256"].pop(REST)
    (place / RESULT).write_text(json.dumps(found), encoding="utf-8")


def _kind(place: Path, name: str, **parts: Any) -> None:
    found = json.loads((place / RESULT).read_text(encoding="utf-8"))
    found["result"] = {"class": name, "of": parts}
    (place / RESULT).write_text(_told(found), encoding="utf-8")


def _scaled(place: Path, name: str, factor: int) -> None:
    with np.load(place / FIELDS) as arrays:
        array = arrays[name]
    _arrays(place, **{name: (array * factor).astype(array.dtype)})


def _shifted_grid(of: dict[str, Any]) -> None:
    of["patches"]["tuple"][0]["of"]["start"] = 3


def _one_triangle(of: dict[str, Any]) -> None:
    surface = of["surfaces"]["tuple"][0]["of"]
    surface["vertices"] = {"array": "points"}


@pytest.mark.coarse
@pytest.mark.parametrize("damage", DAMAGES)
def test_what_is_no_saved_result_is_refused_in_a_sentence(
    damage: str, folder: Callable[[str], tuple[Any, Path]], tmp_path: Path
) -> None:
    place = Path(shutil.copytree(folder("own friction")[1], tmp_path / "out"))
    harm, said = DAMAGES[damage]
    harm(place)
    with pytest.raises(ValueError) as caught:  # noqa: PT011 (the message is looked at below)
        mtb.load(place)
    told = str(caught.value)
    assert said in told
    assert str(place) in told
    assert "\n" not in told


def test_a_result_of_the_first_version_has_no_sums(
    folder: Callable[[str], tuple[Any, Path]], tmp_path: Path
) -> None:
    result, place = folder("own friction")
    copy = Path(shutil.copytree(place, tmp_path / "out"))
    found = json.loads((copy / RESULT).read_text(encoding="utf-8"))
    del found["sha256"]
    (copy / RESULT).write_text(json.dumps(found), encoding="utf-8")
    assert np.array_equal(mtb.load(copy).pressure, result.pressure)


def test_a_record_may_be_laid_out_anew(folder: Callable[[str], tuple[Any, Path]], tmp_path: Path) -> None:
    """Its checksum is that of what it says, whatever the spaces and the order of its keys."""
    result, place = folder("own friction")
    copy = Path(shutil.copytree(place, tmp_path / "out"))
    found = json.loads((copy / RESULT).read_text(encoding="utf-8"))
    (copy / RESULT).write_text(json.dumps(found, indent=4, sort_keys=True), encoding="utf-8")
    assert mtb.load(copy).report.peak_pressure == result.report.peak_pressure


def test_a_small_archive_of_endless_zeros_is_refused(
    folder: Callable[[str], tuple[Any, Path]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = Path(shutil.copytree(folder("own friction")[1], tmp_path / "out"))
    _arrays(place, zeros=np.zeros(200_000))
    from mtb_rs.base import files
    from mtb_rs.results import saved

    monkeypatch.setattr(saved, "read_arrays", functools.partial(files.read_arrays, most=100_000))
    with pytest.raises(ValueError, match=rf"{FIELDS} cannot be read: its arrays take 1\.\d+e\+06 bytes"):
        mtb.load(place)


JUNK = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=5), st.just([]), st.just({})
)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_junk_in_a_saved_result_is_refused_or_loads(
    data: st.DataObject, folder: Callable[[str], tuple[Any, Path]], tmp_path: Path
) -> None:
    kind = data.draw(st.sampled_from(["shift", "step", "wheel patch"]))
    place = Path(shutil.copytree(folder(kind)[1], tmp_path / "out", dirs_exist_ok=True))
    found = json.loads((place / RESULT).read_text(encoding="utf-8"))
    places: list[tuple[Any, Any]] = []

    def walk(node: Any) -> None:
        for key in node if isinstance(node, dict) else range(len(node)) if isinstance(node, list) else ():
            places.append((node, key))
            walk(node[key])

    walk(found["result"])
    node, key = data.draw(st.sampled_from(range(len(places))).map(places.__getitem__))
    node[key] = data.draw(JUNK)
    (place / RESULT).write_text(_told(found), encoding="utf-8")
    refused = ""
    try:
        loaded = mtb.load(place)
    except ValueError as error:
        refused = str(error)
    assert str(place) in refused or loaded.plot("pressure").axes


def test_show_reports_and_draws(
    folder: Callable[[str], tuple[Any, Path]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for kind, words in (("own friction", "peak pressure"), ("fastsim", "1000 N")):
        _, place = folder(kind)
        picture = tmp_path / f"{kind}.png"
        arguments = ["show", str(place), "--quantity", "traction", "--kind", "line", "-o", str(picture)]
        assert main(arguments) == 0
        assert picture.read_bytes().startswith(b"\x89PNG")
        shown = capsys.readouterr().out
        assert words in shown
        assert "longitudinal traction" in shown
    for wrong, said in (
        (["--quantity", "gap"], "-o PICTURE is missing"),
        (["-o", str(tmp_path / "a.gif")], "ending in one of .png, .svg, .pdf"),
        (["-o", str(tmp_path / "a.png"), "--quantity", "gaps"], "quantity is 'gaps': one of pressure"),
    ):
        assert main(["show", str(folder("own friction")[1]), *wrong]) == 2
        assert said in capsys.readouterr().err
    assert main(["show", str(tmp_path / "nothing")]) == 2
    assert "is no directory" in capsys.readouterr().err


BLOCK_LINE = np.linspace(-0.02, 0.02, 4)
BLOCK = block_mesh(BLOCK_LINE, BLOCK_LINE, 0.02, halved=False, clamped=True)


def pad(mesh: mtb.TetraMesh = BLOCK, force: float = -5e3, **changed: Any) -> mtb.Scene:
    """A scene of one's own."""
    body = mtb.ElasticBody(mesh, mtb.steel, supports=[mtb.Support("top", 0, 0, mtb.Guide(force))], name="pad")
    given: dict[str, Any] = {"friction": 0.2, "lower": mtb.HalfSpace(mtb.steel, "60E1"), **changed}
    return mtb.Scene(upper=body, spacing=0.01, **given)


@functools.cache
def schema() -> dict[str, Any]:
    found = subprocess.run(
        [sys.executable, "-m", "mtb_rs", "schema", "summary"], capture_output=True, text=True, check=True
    )
    schema: dict[str, Any] = json.loads(found.stdout)
    jsonschema.Draft202012Validator.check_schema(schema)
    return schema


@pytest.mark.slow
@pytest.mark.coarse
@pytest.mark.parametrize("kind", MADE)
def test_a_summary_keeps_to_its_schema(kind: str, folder: Callable[[str], tuple[Any, Path]]) -> None:
    result, place = folder(kind)
    said = json.loads((place / SUMMARY).read_text(encoding="utf-8"))
    (branch,) = (b for b in schema()["oneOf"] if b["title"] == type(result).__name__)
    jsonschema.validate(said, {**branch, "$defs": schema()["$defs"]})
    jsonschema.validate(said, schema())
    assert set(result.totals()) <= set(said)
    assert set(said["fields"]) == set(result.fields())
    for harm in ({"unheard": 1}, {"points": -1}, {"result": "Nothing"}, {"schema": 99}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(said | harm, schema())
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({name: value for name, value in said.items() if name != "files"}, schema())


def test_inputs_tell_what_was_solved() -> None:
    """The same data give the same inputs, each other one gives others; all of it is JSON of modest size."""
    fine = np.linspace(0.0, 1e-5, 60 * 60).reshape(60, 60)
    slope = 0.2
    scenes = {
        "as it is": pad(),
        "another mesh": pad(BLOCK.moved(shift=(1e-6, 0.0, 0.0))),
        "another load": pad(force=-6e3),
        "another surface": pad(lower=mtb.HalfSpace(mtb.steel, mtb.BodySurface.plane())),
        "rigid": pad(lower=mtb.Rigid("60E1")),
        "a function": pad(friction=lambda x, y: slope + 0.0 * x),
        "another function": pad(friction=lambda x, y: slope + 1.0 * x),
        "a direction": pad(sliding_direction=(0.0, 1.0)),
        "a field": mtb.Scene(upper=mtb.steel, lower=mtb.steel, gap=fine, spacing=1e-4, force=1.0),
        "another field": mtb.Scene(upper=mtb.steel, lower=mtb.steel, gap=fine[::-1], spacing=1e-4, force=1.0),
    }
    told = {name: json.dumps(input_data(scene.statement())) for name, scene in scenes.items()}
    assert len(set(told.values())) == len(told)
    assert max(map(len, told.values())) < 2000
    assert told["as it is"] == json.dumps(input_data(pad().statement()))
    body = json.loads(told["as it is"])["upper"]
    assert (body["mesh"]["nodes"], body["mesh"]["highest"]) == (len(BLOCK.nodes), [0.02, 0.02, 0.02])
    assert body["supports"][0]["z"] == {"force": -5e3}
    assert json.loads(told["as it is"])["lower"]["surface"]["name"] == "60E1"
    # told once is told for ever
    assert all(json.dumps(input_data(json.loads(text))) == text for text in told.values())


OF_ALL_BODIES: dict[str, dict[str, Any]] = {
    "prism": {"lower": mtb.Prism("60E1")},
    "layered": {"lower": mtb.Layered(mtb.Material(5e9, 0.4), 2e-3, mtb.steel)},
    "rigid": {"lower": mtb.Rigid()},
    "rough": {"normal_layer": mtb.RoughLayer([3e-6, 1e-6, 0], [0, 1e6, 3e9], tangential_ratio=0.8)},
}
IN_ALL_WAYS: dict[str, Callable[[mtb.Scene], Any]] = {
    "solve": lambda scene: scene.solve("half-space"),
    "step": lambda scene: scene.prepare("half-space").step(),
    "shift": lambda scene: scene.prepare("half-space").step(shift=1e-6, dt=1e-6),
    "start of sliding": lambda scene: scene.start_of_sliding(
        [[1e-6, 0.0]], model="half-space", pressure="held"
    ),
    "heat": lambda scene: scene.sliding_heat(1.0, steps=2, model="elastic-upper"),
    "wear": lambda scene: mtb.wear(scene, 1e3, 1e-13, model="half-space"),
    "brake": lambda scene: mtb.brake(scene, 10.0, 2e3, model="elastic-upper"),
    "sweep": lambda scene: mtb.sweep(scene, {"friction": [0.1, 0.2]}, model="half-space"),
}


# of a layer under these cells
@pytest.mark.filterwarnings("ignore::mtb_rs.base.errors.ToleranceWarning")
@pytest.mark.parametrize("way", IN_ALL_WAYS)
@pytest.mark.parametrize("body", OF_ALL_BODIES)
def test_all_bodies_come_back_in_all_ways(body: str, way: str, tmp_path: Path) -> None:
    scene = mtb.scenes.pole_shoe_on_rail(
        **{"friction": 0.3, "spacing": 12e-3, "velocity": 10.0, **OF_ALL_BODIES[body]}
    )
    refused = {("rough", "shift"): "layer", ("layered", "heat"): "Layered", ("layered", "brake"): "Layered"}
    if (body, way) in refused:
        with pytest.raises(ValueError, match=refused[body, way]):
            IN_ALL_WAYS[way](scene)
        return
    found = IN_ALL_WAYS[way](scene)
    found.save(tmp_path)
    again = mtb.load(tmp_path)
    assert type(again) is type(found)
    assert {type(again).__name__: again.fields().keys()} == {type(found).__name__: found.fields().keys()}
    for name, field in found.fields().items():
        np.testing.assert_array_equal(again.fields()[name].values, field.values)


@pytest.mark.parametrize("ratio", [None, 0.8])
def test_a_contact_under_a_rough_layer_comes_back(ratio: float | None, tmp_path: Path) -> None:
    x = (np.arange(24) - 11.5) * 1e-4
    layer = mtb.RoughLayer([1e-6, 0.5e-6, 0], [0, 1e6, 3e9], tangential_ratio=ratio)
    found = mtb.solve_normal(
        (x**2 + x[:, None] ** 2) / 0.4,
        1e-4,
        lower=mtb.steel,
        upper=mtb.steel,
        approach=2e-6,
        normal_layer=layer,
    )
    found.save(tmp_path)
    again = mtb.load(tmp_path)
    assert np.array_equal(again.pressure, found.pressure)
    assert again.normal_layer == layer
    rolling = mtb.Rolling((1e-5, 0.0, 0.0))
    friction = mtb.Coulomb(0.3)
    expected = mtb.solve_tangential(found, rolling, friction)
    assert np.array_equal(mtb.solve_tangential(again, rolling, friction).traction, expected.traction)


def test_what_would_not_come_back_is_not_written(tmp_path: Path) -> None:
    x = (np.arange(12) - 5.5) * 1e-4
    gap = (x**2 + x[:, None] ** 2) / 0.4
    found = mtb.solve_normal(gap, 1e-4, lower=mtb.steel, upper=mtb.steel, approach=2e-7)
    strange = replace(found, normal_layer=cast("Any", "soft"))
    with pytest.raises(ValueError, match="normal_layer is of the wrong type"):
        strange.save(tmp_path / "there")
    assert not (tmp_path / "there").exists()

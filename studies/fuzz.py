# SPDX-License-Identifier: MIT OR Apache-2.0
"""Random input at every door: what comes in is solved, or refused by name.

    python studies/fuzz.py COUNT [--seed 0] [--door NAME ...]

Each input is drawn by hypothesis from the strategies of one door: case files, arguments of scenes, fields,
profiles, meshes, height fields, bytes of prepared contacts, sweeps and their checkpoints, forged ones with
right sums too, tables and summaries of elsewhere. Allowed are a
result, which then has no NaN and says that it converged, and a ValueError or ConvergenceError with words. All
else is a finding, and printed with the smallest input that shows it: other exceptions, a panic of the
compiled core, warnings, silent NaN, inputs that take longer than ten seconds. The same seed draws the same
inputs.

The doors of the Rust crates have their own, quicker drivers:

    PROPTEST_CASES=1000000 cargo test --release --workspace any_
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import dataclasses
import json
import math
import signal
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.case import SCENES, case_from_words, load_case
from mtb_rs.pictures.files import check_saveable
from mtb_rs.studies.sweep_checkpoint import _line

#: Seconds after which an input counts as hanging.
PATIENCE = 10.0
#: Inputs drawn at a time; a finding costs only the rest of its batch.
BATCH = 1000
#: Contact points up to which a scene is solved and not only built.
SOLVED_POINTS = 150


class Finding(AssertionError):
    """What no input may do."""


# --- values, most of them near what makes sense --------------------------------------------------------

ODD_NUMBERS = (
    *(0.0, -0.0, 1.0, -1.0, 1e-3, 1e3, 5e-324, 1e-310, 1e-160, 1e-31, 1e-30, 1e-16, 1e16, 1e30, 1e31),
    *(1e160, 1.7e308, -1e300, math.nan, math.inf, -math.inf, 2**63, 10**400, -1, 0, 1, 2, 3),
)
ODD_THINGS = (
    *(None, True, False, "", "a", "3e-3", "nan", b"x", 1j, 1 + 0j, [], (), {}, [1.0], (1.0, 2.0)),
    *((1.0, 2.0, 3.0), [[1.0], [2.0, 3.0]], {"a": 1}, np.float32(0.3), np.int8(2), np.array(0.3)),
    *(np.zeros(0), np.ones((2, 2)), np.array(["a"]), np.array([None]), object, print, math.sqrt, Path("x")),
    *(range(2), np.ma.masked_array([1.0, 2.0], [True, False]), np.bool_(True), np.complex128(1.0)),
)
odd_numbers = st.one_of(st.sampled_from(ODD_NUMBERS), st.floats())
odd = st.one_of(odd_numbers, st.sampled_from(ODD_THINGS))


def near(value: float) -> st.SearchStrategy[Any]:
    """Numbers about `value`, now and then an odd thing."""
    factor = st.one_of(st.just(1.0), st.floats(0.5, 2.0), st.floats(-3.0, 3.0).map(lambda e: 10.0**e))
    usual = st.builds(lambda f, sign: f * sign * value, factor, st.sampled_from((1,) * 19 + (-1,)))
    return rarely(usual, odd)


def rarely(usual: st.SearchStrategy[Any], unusual: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    """`unusual` once in thirty-two."""
    return st.integers(0, 31).flatmap(lambda k: unusual if k == 7 else usual)


def arrays(shape: tuple[int, ...], scale: float) -> st.SearchStrategy[Any]:
    """Arrays of a shape, smooth or rough, now and then with an odd entry or turned into something odd."""

    def build(kind: int, root: int, entry: Any, place: int, turn: int) -> Any:
        rng = np.random.default_rng(root)
        grid = np.meshgrid(*(np.arange(n) - 0.5 * (n - 1) for n in shape), indexing="ij")
        bowl = sum(g * g for g in grid) / max(sum(n * n for n in shape), 1)
        values = scale * np.asarray((bowl, bowl + rng.random(shape), rng.random(shape), 0.0 * bowl)[kind])
        with contextlib.suppress(TypeError, ValueError, OverflowError):
            if entry is not None and values.size:
                values.flat[place % values.size] = entry
        views: tuple[Callable[[], Any], ...] = (
            lambda: values.T,
            lambda: np.clip(values, -1e30, 1e30).astype(np.float32),
            lambda: np.asfortranarray(values),
            lambda: values.astype(int) if np.abs(values).max(initial=0.0) < 1e9 else values,
            lambda: values.tolist(),
            lambda: values.astype(complex),
            lambda: np.ma.masked_array(values, values > values.mean()) if values.size else values,
            lambda: values[::-1, ...],
            lambda: values.astype(str),
            lambda: values > 0.0,
        )
        return views[turn]() if turn < len(views) else values

    with_entry = rarely(st.none(), odd_numbers)
    return st.builds(
        build, st.integers(0, 3), st.integers(0, 999), with_entry, st.integers(0, 99), st.integers(0, 60)
    )


def sometimes(**strategies: st.SearchStrategy[Any]) -> st.SearchStrategy[dict[str, Any]]:
    """Keyword arguments of which each is given or not."""
    return st.fixed_dictionaries({}, optional=strategies)


materials = rarely(
    st.builds(
        lambda e, nu: {"e": e, "nu": nu},
        rarely(st.floats(3.0, 13.0).map(lambda e: 10.0**e), odd),
        rarely(st.floats(-0.99, 0.5), odd),
    ),
    st.sampled_from(("rigid", "rigid", 3, None, "steel")),
)


def body(given: Any) -> Any:
    if isinstance(given, dict):
        return mtb.Material(given["e"], given["nu"])
    return mtb.Rigid() if given == "rigid" else given


def gaussian(words: dict[str, Any]) -> Any:
    return mtb.GaussianPressure(**words)


def fields(value: float) -> st.SearchStrategy[Callable[[], Any]]:
    """Friction or pull in all its forms, made when called: making may be refused as well."""
    plain = near(value)
    hill = st.fixed_dictionaries(
        {
            "peak": plain,
            "center": st.tuples(near(0.01), near(0.01)),
            "sigma": st.tuples(near(0.02), near(0.01)),
        }
    )
    functions = st.sampled_from(
        (
            lambda x, y: value + 0.0 * x,
            lambda x: value,
            lambda x, y: np.ones(3),
            lambda x, y: None,
            lambda x, y: "a",
            lambda x, y: 1 / 0,
            lambda x, y: np.nan * x,
            lambda x, y: [value] * len(x),
            lambda x, y: value * (1 + 1j),
        )
    )
    table = rarely(
        st.tuples(st.just([0.0, 10.0]), st.lists(plain, min_size=2, max_size=2)),
        st.tuples(st.lists(near(1.0), max_size=3), st.lists(plain, max_size=3)),
    )
    return st.one_of(
        plain.map(lambda v: lambda: v),
        st.lists(plain, max_size=3).map(lambda v: lambda: v),
        st.sampled_from(((8,), (2, 4), (4, 2), (2, 2, 2))).flatmap(
            lambda shape: arrays(shape, value).map(lambda v: lambda: v)
        ),
        functions.map(lambda v: lambda: v),
        functions.map(lambda v: lambda: mtb.PressureDependentFriction(v)),
        hill.map(lambda words: lambda: gaussian(words)),
        table.map(lambda words: lambda: mtb.VelocityTable(*words)),
    )


# --- doors: a strategy of inputs, and what is done with one --------------------------------------------


@dataclasses.dataclass(frozen=True)
class Door:
    """Where input comes in."""

    inputs: st.SearchStrategy[Any]
    enter: Callable[[Any], Any]


DOORS: dict[str, Door] = {}


def door(inputs: st.SearchStrategy[Any]) -> Callable[[Callable[[Any], Any]], Callable[[Any], Any]]:
    """Registers a door under the name of its function."""

    def register(enter: Callable[[Any], Any]) -> Callable[[Any], Any]:
        DOORS[enter.__name__] = Door(inputs, enter)
        return enter

    return register


#: Cells of a shoe; fine ones lay out millions of points, which is slow but no fault.
cells = near(15e-3).filter(lambda value: not (isinstance(value, float) and 0.0 < value < 1e-4))
SHOE = {
    "height": near(28.2e-3),
    "length": near(90e-3),
    "inner_edge": near(6e-3),
    "outer_edge": near(36e-3),
    "conforming_to": near(21.6e-3),
    "relief_slope": near(0.02),
    "poles": st.sampled_from((1, 2, 2, 2.0, 3, 0, True, None)),
    "velocity": near(5.0),
    "supports": rarely(st.sampled_from(("driven-top", "clamped-top", "points")), odd),
    "attraction": rarely(st.sampled_from(("upper", "both")), odd),
    "sliding_direction": rarely(st.tuples(near(1.0), near(1.0)), odd),
    "lateral": near(1e-3),
    "yaw": near(1e-2),
    "rail": rarely(st.sampled_from(("60E1", "S1002")), odd),
    "rail_length": near(0.18),
}


def solved_if_small(scene: mtb.Scene) -> Any:
    """The half-space solution, where it takes milliseconds."""
    if scene.geometry.grid(scene.spacing or scene.geometry.start).area.size > SOLVED_POINTS:
        return None
    return scene.solve(model="half-space")


@door(
    st.tuples(
        sometimes(
            **SHOE, upper=materials, lower=materials, friction=fields(0.5), magnetic_pressure=fields(3e6)
        ),
        st.one_of(st.just((22.5e-3, 8e-3)), st.tuples(cells, cells), cells),
    )
)
def shoes(drawn: tuple[dict[str, Any], Any]) -> Any:
    words, spacing = dict(drawn[0]), drawn[1]
    for name in ("friction", "magnetic_pressure"):
        if name in words:
            words[name] = words[name]()
    for name in ("upper", "lower"):
        if name in words:
            words[name] = body(words[name])
    return solved_if_small(mtb.scenes.pole_shoe_on_rail(**words, spacing=spacing))


@door(
    st.tuples(
        st.tuples(st.integers(2, 12), st.integers(2, 12)).flatmap(lambda shape: arrays(shape, 1e-5)),
        sometimes(
            spacing=st.one_of(near(1e-3), st.tuples(near(1e-3), near(1e-3))),
            sliding_direction=rarely(st.tuples(near(1.0), near(1.0)), odd),
            moments=st.one_of(st.none(), st.none(), st.tuples(near(1e-6), near(1e-6)), odd),
            velocity=near(1.0),
            attraction=rarely(st.just("upper"), odd),
            friction=fields(0.3),
        ),
        materials,
        materials,
        st.one_of(
            st.tuples(st.just("force"), near(1.0)),
            st.tuples(st.just("approach"), near(1e-6)),
            st.tuples(st.just("magnetic_pressure"), near(1e4)),
        ),
    )
)
def scenes(drawn: tuple[Any, ...]) -> Any:
    gap, words, upper, lower, (load, value) = drawn
    words = dict(words) | {load: value}
    if "friction" in words:
        words["friction"] = words["friction"]()
    return solved_if_small(mtb.Scene(body(upper), body(lower), gap=gap, **words))


@door(
    st.tuples(
        st.one_of(st.integers(0, 3), st.integers(4, 36), st.integers(4, 36))
        .flatmap(lambda n: st.tuples(st.just(n), st.integers(1, 16)))
        .flatmap(lambda shape: arrays(shape, 1e-5)),
        rarely(st.one_of(near(1e-3), st.tuples(near(1e-3), near(1e-3))), odd),
        materials,
        materials,
        st.one_of(
            st.fixed_dictionaries({"force": near(1.0)}),
            st.fixed_dictionaries({"approach": near(1e-6)}),
            sometimes(force=near(1.0), approach=odd),
        ),
        sometimes(
            moments_about_axes=rarely(st.tuples(near(1e-6), st.none()), odd),
            tolerance=rarely(near(1e-8), odd),
            periodic=rarely(st.booleans(), odd),
            edge=rarely(st.sampled_from(("auto", "error", "sharp", "sharp", "grow")), odd),
            method=rarely(st.sampled_from(("auto", "dense", "fft")), odd),
        ),
    )
)
def height_fields(drawn: tuple[Any, ...]) -> Any:
    gap, spacing, upper, lower, load, options = drawn
    return mtb.solve_normal(gap, spacing, upper=body(upper), lower=body(lower), **load, **options)


@door(
    st.tuples(
        rarely(st.one_of(st.integers(0, 9), st.tuples(st.integers(0, 9), st.integers(0, 9))), odd),
        rarely(st.one_of(near(1e-6), st.tuples(near(1e-6), near(1e-6))), odd),
        sometimes(
            hurst=near(0.8),
            rms_height=near(1e-7),
            rms_slope=near(0.1),
            longest=near(1e-5),
            roll_off=near(5e-6),
            shortest=near(2e-6),
            seed=rarely(st.integers(0, 9), odd),
        ),
    )
)
def rough_surfaces(drawn: tuple[Any, ...]) -> Any:
    shape, spacing, words = drawn
    heights = mtb.roughness(shape, spacing, **words)
    if not np.isfinite(heights).all():
        raise Finding("heights that are not finite")


@door(
    st.tuples(
        near(1e3),
        sometimes(radii=st.one_of(near(0.5), st.tuples(near(0.5), near(0.5)), odd), semi_axes=near(1e-3)),
        materials,
        materials,
    )
)
def ellipses(drawn: tuple[Any, ...]) -> Any:
    force, words, upper, lower = drawn
    exact = mtb.hertz(force, **words, upper=body(upper), lower=body(lower))
    known = (exact.approach, exact.peak_pressure, *exact.semi_axes)
    if not np.isfinite(known).all():
        raise Finding(f"Hertz' contact is {known}")


# --- profiles


def columns(start: float, step: float, count: int, bend: float) -> list[str]:
    y = start + step * np.arange(count)
    return [f"{a:.6g} {b:.6g}" for a, b in zip(y, bend * y * y, strict=True)]


profile_lines = st.one_of(
    st.builds(
        columns, st.floats(-40.0, 40.0), st.floats(-3.0, 3.0), st.integers(0, 9), st.floats(-0.02, 0.02)
    ),
    st.lists(
        st.sampled_from(
            (
                *("header.begin", "header.end", "point.begin", "point.end", "! comment", "# 1 2", "y z", ""),
                *("shift.y = 1", "shift.z = nan", "shift.y = 1e308", "rotate = 0.1", "rotate = 1e300"),
                *(
                    "bound.y.min = -10",
                    "bound.y.max = 10",
                    "bound.y.min = 1e999",
                    "mirror.y = 1",
                    "mirror.z = x",
                ),
                *("units.len.f = 1000", "units.len.f = 1e-320", "units.ang.f = 57.3", "units.ang.f = 0"),
                *("point.dist.min = 0.1", "point.dist.min = inf", "approx.smooth = 0", "approx.smooth = 2"),
                *("1 2", "1 nan", "1e400 1", "1", "1,2", "1;2;3", "\ufeff1 2", "\t1\t2", "0x1 2", "1e-320 2"),
                *("1_0 2", "\u0661 2", "+1 -2", "1 2 // x", "//", "=", "shift.y =", "point.begin ! x"),
            )
        ),
        max_size=6,
    ),
)
reading = sometimes(
    interpolation=rarely(st.sampled_from(("smooth", "linear")), odd),
    unit=rarely(st.sampled_from(("mm", "m", "um", "in")), odd),
    z_axis=rarely(st.sampled_from(("up", "down", "guess")), odd),
)


@cache
def scratch() -> Path:
    """A directory of this process."""
    return Path(tempfile.mkdtemp(prefix="fuzz-"))


def looked_at(profile: mtb.Profile) -> None:
    start, end = profile.range
    y = np.linspace(start, end, 7)
    y[-1] = end
    seen = (profile.height(y), profile.slope(y), profile.curvature(y), profile.arc_length(y))
    if not all(np.isfinite(part).all() for part in seen):
        raise Finding(f"a profile over {start} .. {end} with {seen}")


@door(st.tuples(st.lists(profile_lines, max_size=5), reading, st.sampled_from(("\n", "\r\n", "\r"))))
def profile_files(drawn: tuple[Any, ...]) -> Any:
    parts, options, newline = drawn
    path = scratch() / "profile.prr"
    path.write_bytes(newline.join(line for part in parts for line in part).encode())
    looked_at(mtb.Profile.from_file(path, **options))


@door(
    st.tuples(
        st.integers(0, 9).flatmap(lambda n: st.tuples(arrays((n,), 0.03), arrays((n,), 1e-3))),
        st.booleans(),
        rarely(st.sampled_from(("smooth", "linear")), odd),
    )
)
def profile_points(drawn: tuple[Any, ...]) -> Any:
    (y, z), ordered, interpolation = drawn
    if ordered and isinstance(y, np.ndarray) and y.dtype.kind == "f":
        y = np.sort(y)
    looked_at(mtb.Profile.from_points(y, z, interpolation))


@door(
    st.tuples(
        sometimes(
            wheel_radius=near(0.46),
            gauge=near(1.435),
            rail_inclination=near(0.025),
            lateral=near(6e-3),
            force=near(36e3),
            wheel=rarely(st.sampled_from(("S1002", "60E1")), odd),
            rail=rarely(st.sampled_from(("60E1", "S1002")), odd),
            upper=materials,
        ),
        st.one_of(st.just(1.5e-3), near(1.5e-3), odd),
    )
)
def wheels(drawn: tuple[Any, ...]) -> Any:
    words, spacing = dict(drawn[0]), drawn[1]
    if "upper" in words:
        words["upper"] = body(words["upper"])
    return solved_if_small(mtb.scenes.wheel_on_rail(**words, spacing=spacing))


# --- case files


def toml_value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml_value(part)}" for key, part in value.items()) + "}"
    return f'"{value}"' if isinstance(value, str) else repr(value)


plain_values = st.recursive(
    st.one_of(
        st.floats(0.0, 1.0),
        st.sampled_from((0.0, -1.0, 1e-3, 1e300, 5e-324, math.nan, math.inf, 3, 2**62, True, "a", "rigid")),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(
            st.sampled_from(
                (
                    *("velocity", "value", "file", "peak", "center", "sigma", "floor", "unit", "thickness"),
                    *("shear_modulus", "young_modulus", "poisson_ratio", "model", "method", "tolerance", "x"),
                )
            ),
            inner,
            max_size=4,
        ),
    ),
    max_leaves=5,
)
KEYS = (
    "friction",
    "magnetic_pressure",
    "spacing",
    "upper",
    "lower",
    "solve",
    "layer",
    "rail",
    "wheel",
    "poles",
)
KEYS += (
    "velocity",
    "force",
    "radius",
    "points",
    "width",
    "height",
    "length",
    "supports",
    "sliding_direction",
)
KEYS += ("lateral", "yaw", "gauge", "attraction", "wheel_radius", "rail_length", "relief_slope", "scnee")
DEFAULTS: dict[str, Any] = {
    "friction": 0.3,
    "magnetic_pressure": 2e6,
    "spacing": [22.5e-3, 8e-3],
    "points": 8,
    "force": 1e4,
    "upper": {"young_modulus": 2e11, "poisson_ratio": 0.3},
    "solve": {"model": "half-space"},
    "rail": "60E1",
}


@door(
    st.tuples(
        rarely(st.sampled_from(SCENES), st.sampled_from((None, "x", 3))),
        st.dictionaries(st.sampled_from(KEYS), st.one_of(st.none(), st.none(), plain_values), max_size=5),
    )
)
def cases(drawn: tuple[Any, ...]) -> Any:
    scene, given = drawn
    words: dict[str, Any] = {} if scene is None else {"scene": scene}
    for key, value in given.items():
        words[key] = DEFAULTS.get(key, 0.01) if value is None else value
    case = case_from_words(words, directory=scratch())
    again = case_from_words(words, directory=scratch())
    if case.to_toml() != again.to_toml():
        raise Finding("a case that writes itself differently")
    built = case.scene()
    return solved_if_small(built) if words.get("solve") == DEFAULTS["solve"] else None


@door(
    st.tuples(
        st.sampled_from(SCENES),
        st.dictionaries(st.sampled_from(KEYS), st.one_of(st.none(), plain_values), max_size=4),
        st.lists(
            st.tuples(st.integers(0, 400), st.sampled_from("= []{}\"'#.\n\\x0e-9\u00e9\x00\u2028")),
            max_size=3,
        ),
    )
)
def case_files(drawn: tuple[Any, ...]) -> Any:
    scene, given, changes = drawn
    words = {"scene": scene} | {k: DEFAULTS.get(k, 0.01) if v is None else v for k, v in given.items()}
    text = "\n".join(f"{key} = {toml_value(value)}" for key, value in words.items())
    for place, letter in changes:
        cut = place % (len(text) + 1)
        text = text[:cut] + letter + text[cut + 1 :]
    path = scratch() / "case.toml"
    path.write_text(text, encoding="utf-8")
    try:
        load_case(path).scene()
    except mtb.CaseError as error:
        if str(path) not in str(error):
            raise Finding(f"the message does not name the file: {error}") from error
        raise


# --- meshes

BOX = block_mesh(np.linspace(-0.02, 0.02, 3), np.linspace(-0.01, 0.01, 3), 0.02)
BOX_SURFACE = mtb.BodySurface.block(0.04, 0.02)
CORNERS = np.array([[x, y, z] for x in (-0.02, 0.02) for y in (-0.01, 0.01) for z in (0.0, 0.02)])
SIDES = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
)
#: Places in an array that are overwritten, and by what.
numbers_put = st.lists(st.tuples(st.integers(0, 9999), odd_numbers), max_size=2)
indices_put = st.lists(st.tuples(st.integers(0, 9999), st.integers(-2, 60)), max_size=2)


def spoiled(values: np.ndarray, changes: list[tuple[int, Any]]) -> np.ndarray:
    out = values.copy()
    for place, entry in changes:
        with contextlib.suppress(OverflowError):
            out.flat[place % out.size] = entry
    return out


@door(st.tuples(numbers_put, indices_put, st.booleans(), st.integers(0, 12)))
def surfaces(drawn: tuple[Any, ...]) -> Any:
    put, index, closed, left_out = drawn
    faces = spoiled(SIDES, index)[: len(SIDES) - left_out if left_out < 3 else None]
    surface = mtb.BodySurface.mesh(spoiled(CORNERS, put).T, faces, closed=closed)
    gap = mtb.surface_gap(mtb.BodySurface.plane(), surface, (-0.01, 0.01), (-0.005, 0.005), 5e-3, reach=1e-2)
    if np.isnan(gap.grid.gap).any():
        raise Finding("a gap that is NaN")


@door(
    st.tuples(numbers_put, indices_put, materials, st.sampled_from(("bottom", "top", "left", "x", 3, None)))
)
def tetrahedra(drawn: tuple[Any, ...]) -> Any:
    put, index, material, contact = drawn
    mesh = mtb.TetraMesh(spoiled(BOX.nodes, put), spoiled(BOX.cells, index), {})
    held = [mtb.Support("top", x=0.0, y=0.0, z=0.0)]
    solid = mtb.ElasticBody(mesh, body(material), contact, held)
    if put or index:
        return None  # what is well by chance is solved only as it was made
    return mtb.Scene(solid, mtb.steel, spacing=1e-2, magnetic_pressure=1e6, friction=0.2).solve()


MESH_PARTS = (
    *(b"solid x\n", b"facet", b"OFF\n", b"8 12 0\n", b"v 0 0 0\n", b"f 1 2 3\n", b"ply\n", b"end_header\n"),
    *(b"format ascii 1.0\n", b"element vertex 3\n", b"$MeshFormat\n2.2 0 8\n", b"\xff", b"0 0 0\n", b"nan "),
    *(b"# vtk DataFile Version 4.2\n", b"ASCII\n", b"*NODE\n", b"1, 0, 0, 0\n", b"<VTKFile>", b"\n"),
)


@door(
    st.tuples(
        st.sampled_from(("stl", "ply", "obj", "off", "msh", "vtk", "vtu", "inp")),
        st.lists(
            st.sampled_from(MESH_PARTS),
            max_size=8,
        ),
    )
)
def mesh_files(drawn: tuple[Any, ...]) -> Any:
    suffix, parts = drawn
    path = scratch() / f"mesh.{suffix}"
    path.write_bytes(b"".join(parts))
    try:
        mtb.ElasticBody.from_mesh(path, mtb.steel, contact="bottom", supports=[mtb.Support("top", z=0.0)])
    except ValueError as error:
        if "mesh" not in str(error):
            raise Finding(f"the message does not say which file: {error}") from error
        raise


# --- what was prepared and kept


@cache
def prepared() -> bytes:
    scene = mtb.scenes.block_on_plane(width=0.04, height=0.04, spacing=0.02)
    return bytes(scene.prepare(model="half-space")._core.to_bytes(False))


@door(
    st.tuples(
        st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), max_size=4), st.integers(0, 300)
    )
)
def prepared_bytes(drawn: tuple[Any, ...]) -> Any:
    changes, cut = drawn
    data = bytearray(prepared())
    for place, byte in changes:
        data[place % len(data)] = byte
    path = scratch() / "kept.mtbc"
    path.write_bytes(bytes(data[: len(data) - cut] if cut < 100 else data))
    contact = mtb.PreparedContact.load(path)
    return contact.step((0.0, 0.0, 0.0, 0.0, 0.0, 0.0), (1.0, 0.0))


# --- sweeps

#: What no executor is; numbers of processes would start them.
no_executors = odd.filter(lambda v: not (isinstance(v, (int, np.integer)) and v > 0))
no_paths = odd.filter(lambda v: not isinstance(v, (str, Path)))
labels = st.one_of(
    st.sampled_from(("wet", "a, b", 'say "x"', "\u00e9\u6f22", "=1", "", "\ud800", "a\0b")), odd
)
#: Calling them makes the value.
VARIED: dict[Any, st.SearchStrategy[Callable[[], Any]]] = {
    "friction": fields(0.3),
    **{
        name: values.map(lambda v: lambda: v)
        for name, values in {
            "force": near(5e6),
            "points": rarely(st.integers(3, 7), st.sampled_from((-1, 0, 6.0, "6", True, 10**400))),
            "radius": near(1e3),
            "velocity": near(1.0),
            "sliding_direction": rarely(st.tuples(near(1.0), near(1.0)), odd),
            "moments": rarely(st.tuples(near(1.0), near(1.0)), odd),
        }.items()
    },
    "upper": materials.map(lambda given: lambda: body(given)),
}


def lists_of(values: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    """Values of an argument to vary: a list, or a mapping from labels, now and then neither."""

    def labelled(pairs: list[tuple[Any, Any]]) -> Any:
        with contextlib.suppress(TypeError):  # a label that is no key
            return dict(pairs)
        return [value for _, value in pairs]

    usual = st.one_of(
        st.lists(values, max_size=3), st.lists(st.tuples(labels, values), max_size=3).map(labelled)
    )
    return rarely(usual, odd)


MEASURED = (
    {"wear": 1.0},
    {"wear": math.nan, "a b": 2},
    {"force_x": 1.0},
    {"status": 1.0},
    {"a/b": 1.0},
    {3: 1.0},
    {"a": "x"},
    {"a": np.ones(2)},
    {"a": 1j},
    3,
    None,
)
measures = st.sampled_from(MEASURED).map(lambda returned: lambda result: returned)


def tiny() -> mtb.Scene:
    return mtb.scenes.paraboloid_on_plane(points=5)


def check_table(table: mtb.SweepTable, parameters: dict[Any, Any]) -> None:
    if len(table) != math.prod(len(values) for values in parameters.values()):
        raise Finding(f"{len(table)} cases of {parameters!r}")
    for at in np.ndindex(table.status.shape):
        status = table.status[at]
        if not status.startswith(("solved", "no solution: ", "ValueError: ")):
            raise Finding(f"a case ends with {status}")
        if (status == "solved") != ("force_z" in table.columns and math.isfinite(table["force_z"][at])):
            raise Finding(f"a force {table.columns.get('force_z')} beside {table.status}")
    path = scratch() / "sweep.csv"
    table.to_csv(path)
    with path.open(newline="", encoding="utf-8") as stream:
        heading, *rows = csv.reader(stream)
    if len(rows) != len(table) or {len(row) for row in rows} != {len(heading)}:
        raise Finding(f"a CSV file of {len(rows)} rows for {len(table)} cases")
    table.to_xarray()


@door(
    st.tuples(
        rarely(
            st.dictionaries(st.sampled_from(list(VARIED)), st.none(), min_size=1, max_size=2).flatmap(
                lambda names: st.fixed_dictionaries({name: lists_of(VARIED[name]) for name in names})
            ),
            odd,
        ),
        sometimes(
            model=rarely(st.just("half-space"), odd),
            tolerance=near(0.05),
            measure=rarely(measures, odd.filter(lambda v: v is not print)),
            executor=rarely(st.none(), no_executors),
            checkpoint=rarely(st.none(), no_paths),
        ),
    )
)
def sweeps(drawn: tuple[Any, ...]) -> Any:
    given, options = drawn
    parameters = given
    if isinstance(given, dict):
        parameters = {name: made(values) for name, values in given.items()}
    check_table(mtb.sweep(tiny(), parameters, **{"model": "half-space"} | options), parameters)


def made(values: Any) -> Any:
    if isinstance(values, dict):
        return {label: value() if callable(value) else value for label, value in values.items()}
    return [v() if callable(v) else v for v in values] if isinstance(values, list) else values


FRICTIONS = {"friction": [0.1, 0.2, 0.3]}


@cache
def swept() -> tuple[mtb.SweepTable, bytes]:
    """A sweep, and what its checkpoint holds."""
    path = scratch() / "kept.jsonl"
    path.unlink(missing_ok=True)
    table = mtb.sweep(tiny(), FRICTIONS, model="half-space", checkpoint=path)
    return table, path.read_bytes()


@door(
    st.tuples(
        st.lists(st.sampled_from(range(4)), min_size=1, max_size=6),
        st.lists(st.tuples(st.integers(0, 9999), st.integers(0, 255)), max_size=3),
        st.one_of(st.just(0), st.integers(0, 2000)),
        st.one_of(st.just(b""), st.binary(max_size=40)),
    )
)
def sweep_checkpoints(drawn: tuple[Any, ...]) -> Any:
    order, changes, cut, tail = drawn
    true, good = swept()
    lines = good.splitlines(keepends=True)
    data = bytearray(b"".join(lines[k] for k in order))
    for place, byte in changes:
        data[place % len(data)] = byte
    path = scratch() / "sweep.jsonl"
    path.write_bytes(bytes(data[: max(len(data) - cut, 0)]) + tail)
    try:
        table = mtb.sweep(tiny(), FRICTIONS, model="half-space", checkpoint=path)
    except ValueError as error:
        if str(path) not in str(error):
            raise Finding(f"the message does not name the file: {error}") from error
        raise
    if any(not np.array_equal(table[name], true[name]) for name in ("force_x", "peak_pressure")):
        raise Finding(f"other numbers than without a checkpoint: {table.rows()}")
    return None


#: What a JSON file may hold.
json_values = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-5, 2**70), st.floats(), st.text(max_size=5)),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=5), inner, max_size=4)
    ),
    max_leaves=8,
)


@door(
    st.lists(
        sometimes(
            case=st.one_of(st.integers(-1, 3), json_values),
            status=st.one_of(st.sampled_from(("solved", "no solution: none", "lost")), json_values),
            model=st.one_of(st.just("half-space"), json_values),
            numbers=st.one_of(st.dictionaries(st.just("force_x"), json_values), json_values),
        ),
        max_size=3,
    )
)
def forged_checkpoints(records: list[dict[str, Any]]) -> Any:
    _, good = swept()
    path = scratch() / "forged.jsonl"
    path.write_bytes(good.splitlines(keepends=True)[0] + b"".join(_line(record) for record in records))
    mtb.sweep(tiny(), FRICTIONS, model="half-space", checkpoint=path)


# --- tables and summaries from elsewhere


@cache
def creep_arrays() -> dict[str, Any]:
    scale = np.linspace(0.0, 0.95, 4)
    forces = np.random.default_rng(1).random((1, 4, 7, 4, 3))
    return {"poisson_ratio": 0.28, "ratios": np.ones(1), "scale": scale, "forces": forces, "cells": 8}


creep_values = st.one_of(
    odd.filter(lambda v: not isinstance(v, np.ma.MaskedArray)),
    arrays((1, 4, 7, 4, 3), 1.0),
    arrays((4,), 0.3),
)


@door(
    st.tuples(
        st.dictionaries(st.sampled_from((*creep_arrays(), "further")), creep_values, max_size=2),
        rarely(st.just(()), st.lists(st.tuples(st.integers(0, 9999), st.integers(0, 255)), max_size=9)),
    )
)
def creep_tables(drawn: tuple[Any, ...]) -> Any:
    changed, bytes_changed = drawn
    path = scratch() / "table.npz"
    try:
        np.savez(path, **(creep_arrays() | changed))
    except (TypeError, ValueError, OverflowError) as error:  # what numpy itself does not write
        raise ValueError(f"not written: {error}") from error
    data = bytearray(path.read_bytes())
    for place, byte in bytes_changed:
        data[place % len(data)] = byte
    path.write_bytes(data)
    table = mtb.CreepForceTable.load(path)
    return table.interpolate((1e-3, 1e-3), 1.0, 80e9, 0.3, [[1e-3, 0.0, 0.0]])


names = st.one_of(
    st.sampled_from(("thesis.docx", "../above.txt", "fields.npz", "pressure.png", "body_a.vtp", ".", "")),
    json_values,
)


@door(
    st.tuples(
        st.one_of(
            json_values,
            sometimes(mtb_rs=st.one_of(st.just("1.0"), json_values), files=st.one_of(st.lists(names), names)),
        ),
        st.sets(st.sampled_from(("thesis.docx", "fields.npz", "body_a.vtp")), max_size=2),
    )
)
def summaries(drawn: tuple[Any, ...]) -> Any:
    content, present = drawn
    folder = Path(tempfile.mkdtemp(dir=scratch()))
    (folder / "summary.json").write_text(json.dumps(content))
    for name in present:
        (folder / name).write_text(name)
    # whose files these are is decided before anything is drawn
    check_saveable(folder)
    listed = content["files"]
    foreign = {n for n in present if n not in listed and n != "thesis.docx"}
    if foreign:
        raise Finding(f"would be replaced though not listed: {foreign}")


# --- friction laws and shifts


@cache
def pressed() -> mtb.NormalResult:
    x = (np.arange(8) - 3.5) * 1e-4
    gap = (x[None, :] ** 2 + x[:, None] ** 2) / (2 * 0.05)
    return mtb.solve_normal(gap, 1e-4, lower=mtb.steel, upper=mtb.steel, force=10.0)


laws = st.one_of(
    st.builds(lambda a: (mtb.Coulomb, (a,)), st.one_of(near(0.3), arrays((8, 8), 0.3))),
    st.builds(lambda a, b: (mtb.StaticKinetic, (a, b)), near(0.4), near(0.3)),
    st.builds(lambda a, b, c: (mtb.FallingFriction, (a, b, c)), near(0.4), near(0.3), near(1.0)),
    st.builds(
        lambda a, b: (mtb.TabulatedFriction, ([0.0, *a], b)),
        st.lists(near(1.0), max_size=2),
        st.lists(near(0.3), max_size=3),
    ),
)


@door(
    st.tuples(
        laws,
        rarely(st.tuples(near(1e-7), near(1e-7)), odd),
        near(1e-4),
        st.one_of(st.none(), st.tuples(near(1e-6), near(1e9))),
    )
)
def shifts(drawn: tuple[Any, ...]) -> Any:
    (law, words), displacement, spin, layer = drawn
    return mtb.solve_tangential(
        pressed(),
        mtb.Shift(displacement=displacement, spin=spin),
        law(*words),
        None if layer is None else mtb.InterfaceLayer(*layer),
    )


# --- judging -----------------------------------------------------------------------------------------


def judge(answer: Any) -> None:
    """A result says that it converged, and holds no NaN."""
    report = getattr(answer, "report", None)
    if not getattr(report, "converged", True):
        raise Finding(f"returned without having converged: {report.status}")
    if report is None:
        return
    for part in dataclasses.fields(answer):
        value = getattr(answer, part.name)
        for values in value if part.name == "displacement" else (value,):
            is_number = isinstance(values, (float, np.ndarray)) and np.asarray(values).dtype.kind == "f"
            if is_number and not np.isfinite(values).all():
                raise Finding(f"{part.name} is not finite in a result that says it converged")


@contextlib.contextmanager
def patience(seconds: float) -> Iterator[None]:
    """Ends what takes too long."""

    def ring(*_: Any) -> None:
        raise Finding(f"took longer than {seconds:g} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def attempt(name: str, drawn: Any) -> str:
    """Puts one input through a door: "solved" or "refused".

    Raises
    ------
    Finding
        If it is neither.
    """
    try:
        with patience(PATIENCE), warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", UserWarning)  # words of the library to its user
            judge(DOORS[name].enter(drawn))
    except Finding:
        raise
    except (ValueError, mtb.ConvergenceError) as refusal:
        if len(str(refusal)) < 15:
            raise Finding(f"refused without saying why: {refusal!r}") from refusal
        return "refused"
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        raise Finding(f"{type(error).__name__}: {error}") from error
    return "solved"


def search(name: str, count: int, start: int) -> tuple[dict[str, int], list[str]]:
    """Puts `count` inputs through a door; outcomes, and findings in words."""
    outcomes = {"solved": 0, "refused": 0}
    findings: list[str] = []
    for batch in range(math.ceil(count / BATCH)):
        finding = _batch(name, min(BATCH, count - batch * BATCH), start * 1_000_003 + batch, outcomes)
        if finding is not None:
            findings.append(finding)
    return outcomes, findings


def _batch(name: str, count: int, root: int, outcomes: dict[str, int]) -> str | None:
    last: list[Any] = [None]

    @seed(root)
    @settings(
        max_examples=count,
        deadline=None,
        database=None,
        phases=(Phase.generate, Phase.shrink),
        suppress_health_check=list(HealthCheck),
        report_multiple_bugs=False,
    )
    @given(DOORS[name].inputs)
    def through(drawn: Any) -> None:
        last[0] = drawn
        outcomes[attempt(name, drawn)] += 1

    try:
        through()
    except Finding as finding:
        place = traceback.extract_tb((finding.__cause__ or finding).__traceback__)[-1]
        return f"{name}: {finding} ({Path(place.filename).name}:{place.lineno}) for {last[0]!r}"
    return None


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("count", type=int, help="inputs, shared among the doors")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--door", nargs="+", choices=sorted(DOORS), default=sorted(DOORS))
    options = parser.parse_args()
    started, total, found = time.perf_counter(), 0, []
    share = math.ceil(options.count / len(options.door))
    for name in options.door:
        clock = time.perf_counter()
        outcomes, findings = search(name, share, options.seed)
        seconds = time.perf_counter() - clock
        tried = sum(outcomes.values()) + len(findings)
        total += tried
        said = ", ".join(f"{value} {key}" for key, value in outcomes.items())
        print(f"{name:16s} {said}, {len(findings)} findings, {tried / seconds:.0f} inputs/s", flush=True)
        for finding in dict.fromkeys(findings):
            print(f"  {finding}", flush=True)
        found += findings
    seconds = time.perf_counter() - started
    print(f"{total} inputs in {seconds:.0f} s, {total / seconds:.0f} inputs/s, {len(found)} findings")
    return 1 if found else 0


if __name__ == "__main__":
    raise SystemExit(main())

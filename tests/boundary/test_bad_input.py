# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bad input is a ValueError that names the value, its place and what would do; nothing odd gets through."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs import scenes

STEEL = mtb.steel
TOP = [mtb.Support("top", z=0.0)]
X = np.arange(16) - 7.5
BOWL = (X[:, None] ** 2 + X**2) * 0.5e-6


def shoe(**changes: Any) -> mtb.Result:
    return scenes.pole_shoe_on_rail(**{"spacing": 6e-3, **changes}).solve(model="half-space")


def block(**changes: Any) -> mtb.Result:
    given = {"width": 0.1, "length": 0.05, "spacing": 5e-3, **changes}
    return scenes.block_on_plane(**given).solve(model="half-space")


def scene(**changes: Any) -> mtb.Scene:
    return mtb.Scene(**{"upper": STEEL, "lower": STEEL, "gap": BOWL, "spacing": 1e-3, **changes})


def normal(**changes: Any) -> mtb.NormalResult:
    return mtb.solve_normal(**{"gap": BOWL, "spacing": 1e-3, "lower": STEEL, "upper": STEEL, **changes})


def fails(_x: np.ndarray, _y: np.ndarray) -> float:
    raise ZeroDivisionError("division by zero")


@pytest.mark.parametrize(
    ("build", "changes", "message"),
    [
        # sizes of the grid
        (shoe, {"spacing": 1e300}, "spacing is 1e.300: a number .m. of at most 1e.30"),
        (shoe, {"spacing": 0.5}, "spacing dx is 0.5 m: the contact measures only 0.09 m"),
        (shoe, {"spacing": (6e-3, 0.02)}, "spacing dy is 0.02 m: the contact measures only 0.0156"),
        (shoe, {"spacing": 1e-9}, "spacing is"),
        (shoe, {"spacing": True}, "spacing is True"),
        (shoe, {"spacing": "3e-3"}, "spacing is '3e-3'"),
        (shoe, {"spacing": 3e-3 + 1j}, r"spacing is \(0.003\+1j\)"),
        (block, {"spacing": 0.2}, "spacing dx is 0.2 m: the contact measures only 0.1 m"),
        (block, {"width": 1e29}, "spacing is .* it would take more than"),
        (scenes.paraboloid_on_plane, {"width": 1e-31}, "width is 1e-31"),
        # the shoe
        (shoe, {"relief_slope": -0.02}, "relief_slope is -0.02: at least 0 is needed"),
        (shoe, {"outer_edge": 0.037}, "outer_edge is 0.037: the head of the rail ends at 0.0360"),
        (shoe, {"rail_length": 0.01}, "rail_length is 0.01 m: the shoe presses on 0.09 m"),
        (shoe, {"poles": 2.0}, "poles is 2.0: the whole number 1 or 2"),
        (shoe, {"poles": True}, "poles is True"),
        (shoe, {"rail": 3}, "profile 3 is unknown: 60E1"),
        # friction
        (shoe, {"friction": lambda x: 0.5}, "friction is a function that fails with TypeError"),
        (shoe, {"friction": fails}, "fails with ZeroDivisionError: division by zero; a function of x and y"),
        (shoe, {"friction": lambda x, y: np.ones(3)}, r"for friction gives an array of shape \(3,\)"),
        (shoe, {"friction": lambda x, y: x / 0 * 0}, r"the result of the function for friction\[0\] is nan"),
        (shoe, {"friction": True}, "friction is True"),
        (shoe, {"friction": "0.5"}, "friction is '0.5'"),
        (shoe, {"friction": None}, "friction is None"),
        (shoe, {"friction": 0.5 + 1j}, "friction is .*1j"),
        (shoe, {"friction": np.full(90, 0.5 + 1j)}, "friction is .*: real numbers are needed"),
        (shoe, {"friction": np.full(90, True)}, "friction is .*: real numbers are needed"),
        (shoe, {"friction": 1e300}, "friction is 1e.300"),
        (shoe, {"friction": 1e4}, "friction is 10000 at point 0: numbers from 0 to 1000"),
        (shoe, {"friction": -0.1}, "friction is -0.1 at point 0: numbers from 0"),
        (shoe, {"friction": [0.5, np.nan]}, r"friction\[right\] is nan"),
        (shoe, {"friction": np.where(np.arange(90) == 7, np.nan, 0.5)}, r"friction\[7\] is nan"),
        (block, {"friction": np.full((20, 10), 0.5)}, r"friction has shape \(20, 10\): .* \(10, 20\)"),
        (block, {"magnetic_pressure": np.full((20, 10), 3e6)}, r"magnetic_pressure has shape \(20, 10\)"),
        # the pull
        (shoe, {"magnetic_pressure": True}, "magnetic_pressure is True"),
        (shoe, {"magnetic_pressure": "3e6"}, "magnetic_pressure is '3e6'"),
        (shoe, {"magnetic_pressure": 1e300}, "magnetic_pressure is 1e.300"),
        (shoe, {"magnetic_pressure": 0.0}, "magnetic_pressure loads patch 'left' with 0 N"),
        (shoe, {"magnetic_pressure": 1e-300}, "magnetic_pressure loads patch 'left' with -1.*e-303 N"),
        # how it is held
        (shoe, {"supports": 3}, "supports is 3: one of 'driven-top'"),
        (shoe, {"supports": mtb.Support("top")}, "supports is Support.*a list of mtb_rs.Support"),
        (mtb.Support, {"where": 3}, "where has shape"),
        (mtb.Support, {"where": ((0, 1), (0, "a"), (0, 1))}, "an end of a box is 'a'"),
        (scene, {"force": 1.0, "supports": "points"}, "supports is 'points': it is for"),
        (scene, {"force": 1.0, "element_size": 1e-3}, "element_size is 0.001: it is for"),
        (scene, {"force": 1.0, "layer": 3}, "layer is 3: an InterfaceLayer"),
        # tables and distributions
        (mtb.PressureDependentFriction, {"function": 3}, "function is 3: a function of pressure"),
        (mtb.VelocityTable, {"velocity": [0, np.nan], "value": [1, 2]}, r"velocity of a table\[1\] is nan"),
        (mtb.VelocityTable, {"velocity": 3, "value": [1, 2]}, "has 1 velocities and 2 values"),
        (mtb.VelocityTable, {"velocity": ["a", 1], "value": [1, 2]}, "velocity of a table is .'a'"),
        (mtb.VelocityTable, {"velocity": [0, 1], "value": 3}, "value of a table is 3"),
        (mtb.GaussianPressure, {"peak": 1.0, "center": 0, "sigma": (1, 1)}, "center is 0"),
        (mtb.GaussianPressure, {"peak": 1.0, "center": (0, 0), "sigma": (1, 0)}, r"sigma\[1\] is 0"),
        # forces and approaches
        (scene, {"force": -1.0}, "force is -1"),
        (scene, {"force": 0.0}, "force is 0"),
        (scene, {"force": 1e-300}, "force is 1e-300"),
        (scene, {"force": 10**400}, "force is 1000.*at most"),
        (scene, {"approach": -1e-6}, "approach is -1e-06"),
        (scene, {"force": 1.0, "moments": (np.nan, 0.0)}, r"moments\[0\] is nan"),
        (scene, {"force": 1.0, "sliding_direction": (1e300, 0)}, r"sliding_direction\[0\] is 1e.300"),
        (normal, {"force": -1.0}, "force is -1"),
        (normal, {"force": 0.0}, "force is 0"),
        (normal, {"force": 1e300}, "force is 1e.300"),
        (
            normal,
            {"force": 1.0, "moments_about_axes": (None, 1.0)},
            r"axes\[1\] is 1 N m: .* 1 m from the middle",
        ),
        (normal, {"force": 1.0, "spacing": 1e300}, "spacing is 1e.300"),
        (normal, {"force": 1.0, "spacing": None}, "spacing is None"),
        (normal, {"force": 1.0, "gap": [[1, 2], [3]]}, "gap is .*: real numbers"),
        (normal, {"force": 1.0, "gap": np.ma.masked_array(BOWL, BOWL > 1e-5)}, r"gap\[0, 0\] is masked"),
        (normal, {"force": 1.0, "gap": np.where(BOWL > 1e-5, np.nan, BOWL)}, r"gap\[0, 0\] is nan"),
        (normal, {"force": 1.0, "gap": BOWL * 1e305}, r"gap\[0, 0\] is .*e.300"),
        (scene, {"force": 1.0, "gap": np.where(BOWL > 1e-5, np.inf, BOWL)}, r"gap\[0, 0\] is inf"),
        # roughness
        (
            mtb.roughness,
            {"shape": 2, "spacing": 1e-6, "rms_slope": 0.1, "shortest": 1e-7},
            "rms_slope is 0.1",
        ),
        (
            mtb.roughness,
            {"shape": (1, 1), "spacing": 1e-6, "rms_height": 1e-7},
            "no wave from shortest = .* fits on a surface of 1e-06 x 1e-06 m",
        ),
        (mtb.roughness, {"shape": "a", "spacing": 1e-6, "rms_height": 1e-7}, "shape"),
        (mtb.roughness, {"shape": 16, "spacing": 1e-6, "rms_height": 1e-7, "seed": "a"}, "seed is 'a'"),
        (mtb.roughness, {"shape": 16, "spacing": 1e-6, "rms_height": 1e-7, "seed": 1.5}, "seed is 1.5"),
        (mtb.roughness, {"shape": 16, "spacing": 1e-6, "rms_height": 1e-7, "seed": -1}, "seed is -1"),
    ],
)
@pytest.mark.filterwarnings("ignore:divide by zero", "ignore:invalid value")
@pytest.mark.filterwarnings("ignore:magnetic_pressure (reaches|is)")
@pytest.mark.filterwarnings("ignore:width is .* is usual")
def test_bad_arguments_are_named(build: Callable[..., Any], changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        build(**changes)


def test_wrong_lengths_from_pressure_dependent_friction_are_named() -> None:
    law = mtb.PressureDependentFriction(lambda p: np.ones(3))
    with pytest.raises(ValueError, match=r"the function for friction gives an array of shape \(3,\)"):
        shoe(friction=law)


def test_friction_that_depends_on_pressure_is_one_for_both_poles() -> None:
    law = mtb.PressureDependentFriction(lambda p: 0.3 + 0.0 * p)
    table = mtb.VelocityTable([0.0, 50.0], [0.1, law])
    for friction, place in (([0.3, law], r"friction\[right\]"), (table, "friction")):
        with pytest.raises(
            ValueError, match=f"^{place}.* is PressureDependentFriction.*one for all contact points"
        ):
            shoe(friction=friction, velocity=10.0)


@pytest.mark.parametrize("name", ["relief_slope", "lateral", "yaw", "rail_length", "length"])
@pytest.mark.parametrize("value", ["a", None, True, 1j, np.nan, -np.inf, 1e300])
def test_every_number_of_the_shoe_is_checked(name: str, value: Any) -> None:
    with pytest.raises(ValueError, match=f"{name} is "):
        shoe(**{name: value})


@pytest.mark.parametrize("name", ["lateral", "wheel_radius", "gauge", "rail_inclination", "force"])
@pytest.mark.parametrize("value", ["a", None, True, 1j, np.nan, -np.inf, 1e300])
def test_every_number_of_the_wheel_is_checked(name: str, value: Any) -> None:
    with pytest.raises(ValueError, match=f"{name} is "):
        scenes.wheel_on_rail(**{name: value})


def test_a_force_lost_in_rounding_says_so() -> None:
    with pytest.raises(mtb.ConvergenceError, match="lost in the rounding of a gap that varies by"):
        scene(force=1e-28, friction=0.3).solve()


@pytest.mark.coarse
@pytest.mark.parametrize("force", [1e-7, 1e-8, 1e-9, 1e-10])
def test_a_force_nearly_lost_in_rounding_is_shared_by_the_lowest_points(force: float) -> None:
    # the pivots saw two of them in contact
    pressed = scene(force=force, friction=0.3).solve()
    carrying = pressed.pressure[pressed.pressure > 0.0]
    np.testing.assert_allclose(carrying, np.full(4, force / 4e-6), rtol=1e-6)


def test_bodies_apart_carry_nothing_and_say_so() -> None:
    with pytest.raises(ValueError, match="the bodies never touch: approach is 1e-08 m, the smallest gap is"):
        scene(approach=1e-8).solve()
    apart = normal(approach=-1e-3)
    assert apart.normal_force == 0.0
    assert apart.report.status.startswith("converged: the bodies do not touch, approach is -0.001 m")


def test_a_resultant_outside_the_patch_is_named() -> None:
    with pytest.raises(mtb.ResultantError, match="the resultant of the load lies outside"):
        scene(force=10.0, moments=(10.0, 0.0)).solve()


def test_supports_that_fail_are_named() -> None:
    held = [mtb.Support(lambda nodes: nodes[7] > 0.0, z=0.0)]
    with pytest.raises(ValueError, match=r"fails with IndexError.*a function of points"):
        scenes.block_on_plane(supports=held).solve(model="elastic-upper")


def test_a_plane_of_one_row_is_a_punch() -> None:
    # one row that slopes is as plane as any: contact up to its ends
    for shape in ((1, 20), (20, 1)):
        slope = np.linspace(0.0, 1e-7, 20).reshape(shape)
        found = mtb.solve_normal(slope, 1e-3, lower=STEEL, upper=STEEL, force=1e4)
        assert found.report.contact_area == pytest.approx(20e-6)


@pytest.mark.parametrize("edge", ["auto", "error", "grow"])
def test_a_row_that_bends_is_no_punch_and_says_what_would_do(edge: str) -> None:
    bow = np.linspace(-1.0, 1.0, 20)[None, :] ** 2 * 1e-6
    message = r'20 x 1 cells are too few to continue the gap, .* on a larger grid; edge="sharp" states'
    with pytest.raises(ValueError, match=message):
        mtb.solve_normal(bow, 1e-4, lower=STEEL, upper=STEEL, force=1.0, edge=edge)
    assert mtb.solve_normal(bow, 1e-4, lower=STEEL, upper=STEEL, force=1.0, edge="sharp").report.converged


def test_unreadable_profiles_are_named(tmp_path: Path) -> None:
    path = tmp_path / "profile.prr"
    with pytest.raises(ValueError, match=r"profile file .*profile\.prr cannot be read: No such file"):
        mtb.Profile.from_file(path)
    for text, message in (
        ("", "at least 2 points"),
        ("0 1\n1 nan\n2 3", "line 2 .* is not two finite numbers"),
        ("0 1\n0 1", "at least 2 points"),
        ("shift.y = abc\npoint.begin\n0 1\n1 2\npoint.end", "shift.y = .*abc.* is not a number"),
        ("shift.y = nan\npoint.begin\n0 1\n1 2\npoint.end", "shift.y = nan is not a number"),
        ("mirror.y = yes\npoint.begin\n0 1\n1 2\npoint.end", "mirror.y = .*yes.* is neither 0 nor 1"),
        ("units.len.f = 0\npoint.begin\n0 1\n1 2\npoint.end", "units.len.f = 0 must be positive"),
        ("approx.smooth = 1\npoint.begin\n0 1\n1 2\npoint.end", "set it to 0"),
        ("point.begin\n0 1\n1 2", "point.begin and point.end are needed"),
    ):
        path.write_text(text)
        with pytest.raises(ValueError, match=message):
            mtb.Profile.from_file(path)
    with pytest.raises(ValueError, match="path is None"):
        mtb.Profile.from_file(None)  # type: ignore[arg-type]


SUFFIXES = ["stl", "ply", "obj", "off", "glb", "gltf", "3mf", "msh", "vtu", "vtk", "inp", "bdf", "xyzzy"]


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("content", [b"", b"\x00\xff solid hello\n 3 4 5 nan", b"{}", b"OFF\n1 1 1\n"])
def test_unreadable_meshes_are_named(suffix: str, content: bytes, tmp_path: Path) -> None:
    path = tmp_path / f"body.{suffix}"
    path.write_bytes(content)
    message = "is empty" if not content else "cannot be read|holds|has cells"
    with pytest.raises(ValueError, match=rf"body\.{suffix}.*({message})|the mesh has no cells"):
        mtb.ElasticBody.from_mesh(path, STEEL, contact="bottom", supports=TOP)

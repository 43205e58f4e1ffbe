# SPDX-License-Identifier: MIT OR Apache-2.0
"""Mistakes that a user is likely to make, each refused in a sentence that names what would be accepted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.case import case_from_words

steel = mtb.steel


def ball(**given: Any) -> mtb.Scene:
    return mtb.scenes.paraboloid_on_plane(points=8, **given)


def block(**given: Any) -> mtb.Scene:
    return mtb.scenes.block_on_plane(spacing=2e-2, **given)


def field(**given: Any) -> mtb.Scene:
    x = np.linspace(-1e-2, 1e-2, 7)
    gap = 5.0 * (x**2 + x[:, None] ** 2)
    return mtb.Scene(**{"lower": steel, "upper": steel, "gap": gap, "spacing": 1e-2 / 3.0, **given})


def case(**words: Any) -> mtb.Case:
    return case_from_words({"scene": "block_on_plane", **words})


TABLE = mtb.VelocityTable((0.0, 10.0), (0.4, 0.2))

MISTAKES: dict[str, tuple[Callable[[], object], str]] = {
    "a material that is stiffer sideways": (
        lambda: mtb.Material(young_modulus=210e9, poisson_ratio=0.7),
        r"poisson_ratio is 0.7: it must lie in \(-1, 0.5\]",
    ),
    "nothing that deforms": (
        lambda: field(upper=mtb.Rigid(), lower=mtb.Rigid(), force=1.0),
        "upper and lower are both Rigid: one of them must deform",
    ),
    "no load": (field, "give exactly one of force"),
    "two loads": (lambda: field(force=1.0, approach=1e-6), "give exactly one of force"),
    "moments of an approach": (
        lambda: field(approach=1e-6, moments=(0.1, 0.0)),
        "moments are given beside approach: only a load can have them",
    ),
    "too few points": (
        lambda: mtb.scenes.paraboloid_on_plane(points=2),
        "points is 2: a whole number from 4",
    ),
    "a gap along a line": (lambda: field(gap=np.zeros(7), force=1.0), r"gap has shape \(7,\): \(ny, nx\)"),
    "no direction": (
        lambda: block(sliding_direction=(0.0, 0.0)).solve("half-space"),
        "sliding_direction is .*: two finite numbers, not both zero, are needed",
    ),
    "cells that nobody chooses": (
        lambda: block().with_(spacing=None).prepare("half-space"),
        r"spacing is None: only solve\(\)",
    ),
    "a tolerance above one": (
        lambda: block().solve(tolerance=2.0),
        "tolerance is 2.0: a number between 0 and 1",
    ),
    "increments of an approach": (
        lambda: field(approach=1e-6).solve(method="incremental"),
        'method is "incremental": it presses with a force, an approach is given',
    ),
    "increments of elastic bodies": (
        lambda: block().solve("elastic-upper", method="incremental"),
        'method is "incremental": it takes half-spaces',
    ),
    "a table without a velocity": (
        lambda: block(friction=TABLE).solve("half-space"),
        r"is a table over velocity: give velocity=... \[m/s\]",
    ),
    "a velocity beside its table": (
        lambda: block(friction=TABLE, velocity=20.0).solve("half-space"),
        "velocity is 20 m/s: the table covers 0 to 10 m/s",
    ),
    "a place in the plane": (
        lambda: ball().prepare("half-space", reference_point=(0.0, 0.0)),
        "reference_point is .*: three finite numbers",
    ),
    "a pose of three numbers": (
        lambda: ball().prepare("half-space").step(pose=(0.0, 0.0, -1e-6), velocity=1.0),
        r"pose is .*: six real numbers \(x, y, z, roll, pitch, yaw\) are needed",
    ),
    "a velocity in space": (
        lambda: ball(friction=0.1).prepare("half-space").step(velocity=(1.0, 0.0, 0.0)),
        r"velocity is .*: a number or \(vx, vy\) \[m/s\] is needed",
    ),
    "a velocity of nothing": (
        lambda: ball(friction=0.1).prepare("half-space").step(velocity=0.0),
        "velocity is 0: at rest friction has no direction; prepare with a standstill speed",
    ),
    "a magnet that is not there": (
        lambda: ball().prepare("half-space").step(velocity=1.0, magnetic_pressure=1e6),
        "magnetic_pressure is given, but the scene was prepared without one",
    ),
    "force and approach": (
        lambda: mtb.solve_normal(np.zeros((4, 4)), 1e-3, lower=steel, upper=steel, force=1.0, approach=1e-6),
        "either force or approach is needed",
    ),
    "a table of sweeps in a case": (lambda: case(sweep={"friction": [0.1]}), "mtb-rs sweep CASE.toml --vary"),
    "a number with a unit in a case": (
        lambda: case(spacing="3 mm"),
        'spacing = "3 mm": it is .3 mm.: a finite number in SI units',
    ),
    "a key that is like no other": (
        lambda: case(glue=0.1),
        "glue = 0.1: unknown key; known are scene, width",
    ),
    "a pull that pushes": (
        lambda: mtb.scenes.pole_shoe_on_rail(magnetic_pressure=-3e6, spacing=9e-3).solve("half-space"),
        "magnetic_pressure loads patch 'left' with .* it does not press the bodies together",
    ),
    "a rail that is a path": (
        lambda: mtb.scenes.wheel_on_rail(rail="/nope/rail.csv"),
        "60E1, S1002 are known by name, and Profile.from_file reads a file",
    ),
    "an option that a method has not": (
        lambda: block().solve("half-space", maxiter=3),  # type: ignore[call-overload]
        "unknown option 'maxiter' of the direct method, which has no options of its own",
    ),
    "a moving picture of a number": (lambda: mtb.animate(3, "x.gif"), "history is 3: a list of results"),  # type: ignore[arg-type]
    "a profile by its class": (
        lambda: mtb.Profile([(0.0, 0.0)]),
        "made by Profile.standard, Profile.from_points",
    ),  # type: ignore[arg-type]
    "an option that stresses have not": (
        lambda: ball().solve("half-space").plot("von_mises", deformation=10.0),  # type: ignore[call-overload]
        'deformation: unknown options for quantity="von_mises"; known are limits, scale',
    ),
    "an option that views have not": (
        lambda: ball().solve("half-space").plot("pressure", "3d", deformation=10.0),  # type: ignore[call-overload]
        'deformation: unknown options for kind="3d"; known are body, limits, scale',
    ),
    "a sweep over nothing": (
        lambda: mtb.sweep(block(), {}),
        "parameters is empty: at least one argument with its values is needed",
    ),
    "a sweep that repeats itself": (
        lambda: mtb.sweep(block(), {"friction": [0.1, 0.1]}),
        "has a value twice",
    ),
}


@pytest.mark.coarse
@pytest.mark.parametrize("name", MISTAKES)
def test_a_likely_mistake_is_refused_in_a_sentence(name: str) -> None:
    make, said = MISTAKES[name]
    with pytest.raises(ValueError, match=said):
        make()


def test_arguments_with_slips_of_the_fingers_are_told_the_right_ones() -> None:
    for scene in (block(), field(force=1.0)):
        with pytest.raises(TypeError, match=r"has no frictoin; did you mean friction\?$"):
            scene.with_(frictoin=0.2)
        with pytest.raises(TypeError, match="has no sweep; it has"):
            scene.with_(sweep=0.2)
    with pytest.raises(TypeError, match=r"^block_on_plane has no frictoin; did you mean friction\?$"):
        mtb.scenes.block_on_plane(frictoin=0.2)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=r"^paraboloid_on_plane has no velocity; it has radius, force, "):
        mtb.scenes.paraboloid_on_plane(velocity=1.0)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=r"^paraboloid_on_plane: multiple values for argument 'radius'$"):
        mtb.scenes.paraboloid_on_plane(1.0, radius=2.0)  # type: ignore[misc]
    with pytest.raises(
        TypeError, match=r"Material\.from_shear_modulus takes shear_modulus and poisson_ratio"
    ):
        mtb.Material(210e9, shear_modulus=80e9)  # type: ignore[call-arg]


@pytest.mark.parametrize("moments", [(0.0, 30.0), (-30.0, 0.0), (20.0, 20.0)])
@pytest.mark.parametrize("way", ["solve", "step", "start_of_sliding"])
def test_a_load_that_tips_the_body_over_is_refused_with_its_reason(
    way: str, moments: tuple[float, float]
) -> None:
    """A force of 1 kN on a face of 20 mm carries moments of 10 N m, about an axis along x or y."""
    scene = field(force=1e3, moments=moments)
    ways: dict[str, Callable[[], object]] = {
        "solve": lambda: scene.solve("half-space"),
        "step": lambda: scene.prepare("half-space").step(velocity=1.0),
        "start_of_sliding": lambda: scene.start_of_sliding([[1e-6, 0.0]], "half-space"),
    }
    with pytest.raises(mtb.ResultantError, match="outside"):
        ways[way]()
    with pytest.raises(mtb.ResultantError, match=r"moments \(.*\) N m about x and y"):
        scene.solve("half-space")


def test_a_law_of_friction_where_a_field_is_needed_says_where_laws_are_for() -> None:
    block = mtb.scenes.block_on_plane(friction=mtb.Coulomb(0.3))
    with pytest.raises(ValueError, match=r"friction is Coulomb.*a number, an array.*Laws .* are for wheels"):
        block.solve("half-space")


def test_an_array_for_each_pole_says_that_a_list_is_needed() -> None:
    pull = mtb.VelocityTable([0.0, 20.0], np.array([[3.0e6, 2.4e6], [2.6e6, 2.0e6]]))
    shoe = mtb.scenes.pole_shoe_on_rail(magnetic_pressure=pull, velocity=3.0)
    with pytest.raises(ValueError, match="or a list with 2 entries, one for each pole, is needed"):
        shoe.solve("half-space")


def _heights(cells: int = 40) -> np.ndarray:
    x = (np.arange(cells) - 0.5 * (cells - 1)) * 2e-4
    return (x[None, :] ** 2 + x[:, None] ** 2) / 0.8


def _long() -> np.ndarray:
    x = (np.arange(40) - 19.5) * 2e-4
    return np.stack([np.tile(x, 40), np.repeat(x, 40), _heights().ravel()], axis=1)


def _with_coordinates() -> np.ndarray:
    x = (np.arange(40) - 19.5) * 2e-4
    return np.concatenate([x[:, None], _heights()], axis=1)


#: Gaps that are none, and the question about them.
NO_GAPS = {
    "points one a row": (_long(), r"gap has the shape \(1600, 3\). If these are columns"),
    "an index among the columns": (
        _with_coordinates(),
        "first column of gap goes evenly from -0.0039 to 0.0039 m",
    ),
    "upside down": (-_heights(), "If it is upside down, give its negative"),
    "too small a grid": (_heights()[15:25, 15:25], "would do"),
    "a slope that is too small": (_heights()[15:25, 15:25] + 1e-6 * np.arange(10.0), "would do"),
}


@pytest.mark.parametrize("kind", NO_GAPS)
@pytest.mark.filterwarnings("ignore:the .* body deforms", "ignore:the peak pressure is")
def test_contact_at_the_edge_asks_what_the_gap_is(kind: str) -> None:
    gap, question = NO_GAPS[kind]
    with pytest.raises(ValueError, match=question):
        mtb.solve_normal(gap, 2e-4, lower=steel, upper=steel, force=1e3)
    with pytest.raises(ValueError, match=question):
        mtb.Scene(steel, steel, gap=gap, spacing=2e-4, force=1e3).solve("half-space")


def test_force_and_approach_are_told_apart() -> None:
    def solve(**given: Any) -> object:
        return mtb.solve_normal(_heights(), 2e-4, lower=steel, upper=steel, **given)

    with pytest.raises(ValueError, match=r"force is 1000.0 \[N\], and approach is 1e-06 \[m\]: either"):
        solve(force=1e3, approach=1e-6)
    with pytest.raises(ValueError, match="both are None: either force or approach is needed"):
        solve()


def test_cut_outside_of_the_contact_is_refused() -> None:
    result = mtb.solve_normal(_heights(), 2e-4, lower=steel, upper=steel, force=1e3)
    for cut in ("x", "y"):
        with pytest.raises(ValueError, match=f"{cut} is 3 m: .* between {cut} = -0.004 and 0.004 m"):
            result.plot("pressure", **{cut: 3.0})
        assert result.plot("pressure", **{cut: [-4e-3, 4e-3]}).axes

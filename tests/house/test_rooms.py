# SPDX-License-Identifier: MIT OR Apache-2.0
"""The rooms of the package: old names of modules lead to the new places."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import import_module, util
from pathlib import Path
from types import ModuleType

import pytest

import mtb_rs as mtb
from mtb_rs.moved import CLASSES, PLACES, ROOMS

#: The modules of 0.1.0, and the functions, classes and constants without an underscore that each of them had.
NAMES = json.loads((Path(__file__).parents[1] / "data" / "names_0_1_0.json").read_text(encoding="utf-8"))
#: Helpers of one module for another that are no more: the changelog says so.
GONE: dict[str, set[str]] = {
    "auto": {"LADDER", "rungs"},
    "coupled_start": {"Array", "CoupledContact", "CoupledState", "at_rest", "advance"},
    "elastic": {
        *("can_be_elastic", "upper_side", "lower_side", "overlap"),
        *("half_space_on_nodes", "moved_by", "restricted_sampling"),
    },
    "fmu": {"INPUTS", "OUTPUTS"},
    "friction": {"coulomb_field", "native_law"},
    "grids": {"row_borders"},
    "mesh": {"GROWTH", "MOST_UNKNOWNS", "graded"},
    "mesh_files": {"TRIANGLES_A_TURN", "read_solid"},
    "normal": {"ROUNDING"},
    "plot": {"QUANTITIES"},
    "scene": {"MODELS", "METHODS"},
    "solids": {"BodyContact", "on_grid"},
    "solve": {"FRICTION_TOLERANCE", "FRICTION_ROUNDS", "to_local", "half_space_side", "with_loads"},
    "start_of_sliding": {"coupled_contact", "horizontal"},
    "stepping": {"write_whole", "pull_response"},
    "sweeps": {"varied"},
    "symmetry": {"Array", "Index", "ROUNDING", "Fold", "folded"},
}
MODULES = sorted(NAMES.keys() - {"coupled_start", "symmetry"})


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("old", MODULES)
def test_all_that_a_module_of_the_first_version_had_is_found_under_its_name(old: str) -> None:
    module = import_module(f"mtb_rs.{old}")
    assert {name for name in NAMES[old] if not hasattr(module, name)} == GONE.get(old, set())


def test_what_is_found_under_an_old_name_is_what_that_was() -> None:
    """Of its name, or of the new name of its class, and no module that happens to be imported there."""
    for old in set(MODULES) - {"case"}:
        module = import_module(f"mtb_rs.{old}")
        assert not isinstance(getattr(module, "np", None), ModuleType) or old in ROOMS, old
        new_names = {old: new for place in PLACES[old] for old, new in CLASSES.get(place, {}).items()}
        for name in set(NAMES[old]) - GONE.get(old, set()) - vars(module).keys():
            with pytest.warns(
                DeprecationWarning, match=f"{name} has moved: take {new_names.get(name, name)} "
            ):
                found = getattr(module, name)
            if isinstance(found, type):
                assert found.__name__ == new_names.get(name, name)


@pytest.mark.parametrize("old", sorted(PLACES.keys() - set(ROOMS)))
def test_old_names_of_modules_lead_to_the_new_ones(old: str) -> None:
    module = import_module(f"mtb_rs.{old}")
    assert util.find_spec(f"mtb_rs.{old}") is not None
    for place in PLACES[old]:
        if place in ("base.words", "base.units"):
            continue
        new = import_module(f"mtb_rs.{place}")
        name = next(
            n
            for n, thing in vars(new).items()
            if getattr(thing, "__module__", "") == new.__name__ and not n.startswith("_")
        )
        home = "mtb_rs" if vars(mtb).get(name) is getattr(new, name) else new.__name__
        with pytest.warns(DeprecationWarning, match=rf"take {name} from {home}\.$"):
            assert getattr(module, name) is getattr(new, name)
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        module.nothing  # noqa: B018


def test_a_function_of_the_name_of_an_old_module_stays_a_function() -> None:
    from mtb_rs import roughness

    import_module("mtb_rs.roughness")
    import_module("mtb_rs.start_of_sliding")
    assert mtb.roughness is roughness
    assert callable(mtb.start_of_sliding)
    with pytest.warns(DeprecationWarning, match="take roughness from mtb_rs"):
        assert import_module("mtb_rs.roughness").roughness is roughness


def test_old_modules_are_imported_in_each_way() -> None:
    """By a program of its own, as this one has them already."""
    lines = """
import mtb_rs.stepping, mtb_rs.plot as plot
from mtb_rs import view
from mtb_rs.bodies import HalfSpace, Rigid
from mtb_rs.scene import Scene
from mtb_rs.geometry import ContactSheet
from mtb_rs.friction import Friction
import mtb_rs
assert mtb_rs.stepping.POSE and plot.INK and view.view and mtb_rs.chart_scene.chart
assert (Scene, HalfSpace, Rigid) == (mtb_rs.Scene, mtb_rs.HalfSpace, mtb_rs.Rigid)
"""
    done = subprocess.run(
        [sys.executable, "-W", "default::DeprecationWarning", "-c", lines],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "mtb_rs.bodies.HalfSpace has moved: take HalfSpace from mtb_rs." in done.stderr
    assert "take ContactGrid from mtb_rs.geometry.contact_points" in done.stderr


def test_rooms_that_took_the_name_of_a_module_have_what_it_had() -> None:
    from mtb_rs import friction, geometry

    assert geometry.Profile is mtb.Profile
    assert friction.Coulomb is mtb.Coulomb

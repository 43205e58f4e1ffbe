# SPDX-License-Identifier: MIT OR Apache-2.0
"""Public objects show themselves in one line and are equal where their values are."""

from __future__ import annotations

import copy
import inspect
import pickle
import types
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.elastic_body import ElasticBody
from mtb_rs.bodies.mesh import block_mesh

LONGEST = 320


def patch() -> mtb.PressureField:
    x = np.linspace(-1.0, 1.0, 12)
    inside = np.maximum(0.0, 1.0 - x[None] ** 2 - x[:, None] ** 2)
    return mtb.PressureField(1e8 * np.sqrt(inside), (1e-4, 1e-4), mtb.steel, mtb.steel)


def box() -> mtb.TetraMesh:
    line = np.linspace(0.0, 0.02, 3)
    return block_mesh(line, line, 0.01)


def step() -> mtb.StepResult:
    contact = mtb.scenes.paraboloid_on_plane(points=8).prepare()
    assert isinstance(contact, mtb.PreparedContact)
    return contact.step()


def sliding_block() -> mtb.PreparedContact:
    contact = mtb.scenes.block_on_plane(spacing=20e-3, velocity=5.0).prepare("half-space")
    assert isinstance(contact, mtb.PreparedContact)
    return contact


def wheel_step() -> mtb.WheelStep:
    contact = mtb.scenes.wheel_on_rail(spacing=1e-3).prepare()
    assert isinstance(contact, mtb.PreparedWheels)
    return contact.step(velocity=20.0)


def chart() -> mtb.Chart:
    return mtb.scenes.paraboloid_on_plane(points=8).chart(budget=0.5, repeats=1)


ROUGH = mtb.roughness(8, 1e-6, rms_slope=0.1, seed=1)
ROLL = mtb.Rolling(creepage=(1e-3, 0.0, 0.0))
#: Something of every public class.
MADE: dict[str, Callable[[], Any]] = {
    "Archard": lambda: mtb.Archard(1e-13),
    "AreaLoadCurve": lambda: mtb.area_load_curve(ROUGH, 1e-6, [1e-6], lower=mtb.steel, upper=mtb.Rigid()),
    "BodySurface": lambda: mtb.BodySurface.paraboloid(0.1),
    "Case": lambda: mtb.Case(scene="paraboloid_on_plane"),
    "CaseError": lambda: mtb.CaseError("a"),
    "Chart": chart,
    "ChartPoint": lambda: chart().points[0],
    "Braking": lambda: mtb.brake(mtb.scenes.block_on_plane(spacing=0.025, friction=0.1), 0.2, 1e4),
    "Conductor": lambda: mtb.conducting_steel,
    "ConvergenceError": lambda: mtb.ConvergenceError("a"),
    "Coulomb": lambda: mtb.Coulomb(np.full((12, 12), 0.3)),
    "CreepForceTable": lambda: mtb.CreepForceTable.build((1.0,), nodes=4, cells=6),
    "Displacement": lambda: mtb.Displacement(np.zeros((3, 9)), np.zeros((3, 9))),
    "ElasticBody": lambda: ElasticBody(box(), mtb.steel, contact="top", supports=[mtb.Support("bottom")]),
    "EnergyWear": lambda: mtb.EnergyWear.of_wheel_steel(),
    "FallingFriction": lambda: mtb.FallingFriction(0.4, 0.2, 1.0),
    "Field": lambda: mtb.fastsim(patch(), (1e-3, 0.0, 0.0), mtb.Coulomb(0.3)).fields()["pressure"],
    "FieldTable": lambda: mtb.FieldTable([0.0, 0.1], [0.0, 0.1], np.full((2, 2), 0.3)),
    "FoundationResult": lambda: mtb.fastsim(patch(), (1e-3, 0.0, 0.0), mtb.Coulomb(0.3)),
    "GaussianPressure": lambda: mtb.GaussianPressure(1e6, (0.0, 0.0), (0.1, 0.1)),
    "Gradient": lambda: step().gradient("force"),
    "Magnet": lambda: mtb.Magnet(1e3, 1e-3),
    "Guide": lambda: mtb.Guide(5.0),
    "HalfSpace": lambda: mtb.HalfSpace(mtb.steel),
    "Hertz": lambda: mtb.hertz(1e3, 0.1),
    "InterfaceLayer": lambda: mtb.InterfaceLayer(1e-3, 1e9),
    "KalkerCoefficients": lambda: mtb.kalker_coefficients(1.0, 0.3),
    "Layered": lambda: mtb.Layered(mtb.steel, 1e-3, mtb.Rigid()),
    "Margin": lambda: step().margin(),
    "Material": lambda: mtb.steel,
    "NormalResult": lambda: mtb.solve_normal(
        1e-3 * np.hypot(*np.mgrid[-1:1:9j, -1:1:9j]), 1e-3, lower=mtb.steel, upper=mtb.steel, force=1.0
    ),
    "Passages": lambda: mtb.Passages(30.0, 10, {"velocity": 5.0}),
    "PictureWarning": lambda: mtb.PictureWarning("a"),
    "RoughLayer": lambda: mtb.RoughLayer.exponential(1e9, 1e-6),
    "ThinLayer": lambda: mtb.ThinLayer(1e-3, 1e9, 0.3),
    "PlasticLayer": lambda: mtb.PlasticLayer(1e-3, 1e9, 1e6),
    "PoleShoe": lambda: mtb.PoleShoe(),
    "Viscoelastic": lambda: mtb.Viscoelastic(mtb.steel, 0.5, 1e-3),
    "PreparedContact": lambda: mtb.scenes.paraboloid_on_plane(points=8).prepare(),
    "PreparedWheels": lambda: mtb.scenes.wheel_on_rail(spacing=1e-3).prepare(),
    "PressureDependentFriction": lambda: mtb.PressureDependentFriction(np.cos),
    "PressureField": patch,
    "Prism": lambda: mtb.Prism((0.1, 0.1), foundation=(1e8, 1e8)),
    "Profile": lambda: mtb.Profile.standard("60E1"),
    "RailSlices": lambda: mtb.RailSlices([0.0, 1.0, 2.0], ["60E1"] * 3),
    "WheelSlices": lambda: mtb.WheelSlices.out_of_round("S1002", np.arange(6.0), np.zeros(6)),
    "RailFriction": lambda: mtb.RailFriction(np.linspace(0.0, 0.02, 50), np.full((2, 50), 0.3), [0.0, 1.0]),
    "ReducedBody": lambda: (
        mtb.scenes.block_on_plane(spacing=25e-3).prepare("elastic-upper").reduced(7850.0, 2)
    ),
    "Report": lambda: mtb.scenes.paraboloid_on_plane(points=18).solve().report,
    "Result": lambda: mtb.scenes.paraboloid_on_plane(points=18).solve(),
    "ResultantError": lambda: mtb.ResultantError("a"),
    "Rigid": lambda: mtb.Rigid(),
    "Rolling": lambda: ROLL,
    "RollingTemperature": lambda: mtb.solve_tangential(patch(), ROLL, mtb.Coulomb(0.3)).temperature(),
    "Rubbing": lambda: mtb.Rubbing(np.ones(2), np.ones(2), np.ones(2), 1.0, np.zeros((3, 2))),
    "Scene": lambda: mtb.scenes.block_on_plane(),
    "Shift": lambda: mtb.Shift((1e-6, 0.0)),
    "SlidingHeat": lambda: mtb.scenes.block_on_plane(spacing=0.025, friction=0.1).sliding_heat(1.0, 1, 1.0),
    "Smoothing": lambda: (
        mtb.Profile.from_points(np.linspace(-0.03, 0.03, 99), np.zeros(99)).smoothed().smoothing
    ),
    "Solid": lambda: mtb.scenes.block_on_plane(spacing=2e-2).solve("elastic-upper").solids()[0],
    "StartOfSliding": lambda: mtb.scenes.paraboloid_on_plane(points=8).start_of_sliding([(1e-6, 0.0)]),
    "StaticKinetic": lambda: mtb.StaticKinetic(0.3, 0.2),
    "StepResult": step,
    "StepState": lambda: step().state,
    "Support": lambda: mtb.Support("top"),
    "SweepTable": lambda: mtb.sweep(mtb.scenes.paraboloid_on_plane(points=8), {"friction": [0.1, 0.2]}),
    "StressField": lambda: mtb.hertz(1e3, 0.5, lower=mtb.steel, upper=mtb.steel).stress(),
    "TabulatedFriction": lambda: mtb.TabulatedFriction(np.linspace(0.0, 1.0, 50), np.full(50, 0.3)),
    "TemperatureFriction": lambda: mtb.TemperatureFriction(np.linspace(0.0, 400.0, 50), np.full(50, 0.3)),
    "TangentialResult": lambda: mtb.solve_tangential(patch(), ROLL, mtb.Coulomb(0.3)),
    "TangentialState": lambda: mtb.solve_tangential(patch(), ROLL, mtb.Coulomb(0.3)).state,
    "TetraMesh": box,
    "ToleranceWarning": lambda: mtb.ToleranceWarning("a"),
    "Stability": lambda: sliding_block().stability([1.0], [1e7], free=["x"]),
    "TooLargeError": lambda: mtb.TooLargeError("a"),
    "TouchingWheel": lambda: mtb.wheelset_geometry(shifts=[0.0]).left,
    "VelocityTable": lambda: mtb.VelocityTable([0.0, 1.0], [0.3, 0.2]),
    "VibratingContact": lambda: sliding_block().vibrating(1e-6, [1.0], [1e7], free=["x"]),
    "VibratingState": lambda: sliding_block().vibrating(1e-6, [1.0], [1e7], free=["x"]).state,
    "VibratingStep": lambda: sliding_block().vibrating(1e-6, [1.0], [1e7], free=["x"]).step(),
    "Vibration": lambda: mtb.vibration(ElasticBody(box(), mtb.steel, "bottom"), 7850.0, 2),
    "ViewError": lambda: mtb.ViewError("a"),
    "WearLaw": lambda: mtb.Archard(np.full(3, 1e-13)),
    "WearMap": lambda: mtb.WearMap.of_wheel_steel(3e9),
    "WearResult": lambda: mtb.wear(mtb.scenes.paraboloid_on_plane(points=14), 1e-3, 1e-13),
    "WheelPatch": lambda: wheel_step().patches[0],
    "WheelScene": lambda: mtb.scenes.wheel_on_rail(),
    "WheelState": lambda: wheel_step().state,
    "WheelStep": wheel_step,
    "WheelWear": lambda: mtb.wear_of_wheels(
        mtb.scenes.wheel_on_rail(lateral=0.0, spacing=2e-3),
        1.0,
        1e-13,
        shifts=[0.0],
        friction=mtb.Coulomb(0.3),
    ),
    "WheelsetGeometry": lambda: mtb.wheelset_geometry(shifts=[0.0]),
}


def public() -> list[str]:
    return [name for name in mtb.__all__ if inspect.isclass(getattr(mtb, name))]


def test_something_of_every_public_class_is_looked_at() -> None:
    assert sorted(MADE) == sorted(public())


@pytest.mark.coarse
@pytest.mark.filterwarnings("ignore:StaticKinetic depends on the grid")
@pytest.mark.parametrize("name", sorted(MADE))
def test_public_objects_show_themselves_in_one_line_and_equal_their_copies(name: str) -> None:
    thing = MADE[name]()
    assert isinstance(thing, getattr(mtb, name))
    parts = [
        getattr(thing, key)
        for key in ("geometry", "report", "state", "displacement", "upper")
        if hasattr(thing, key)
    ]
    for shown in (thing, *parts):
        if isinstance(shown, (types.MethodType, np.ndarray)):
            continue
        text = repr(shown)
        assert "\n" not in text
        assert len(text) <= LONGEST, f"{type(shown).__name__}: {len(text)} characters"
    if isinstance(thing, Exception) or name in (
        "PreparedContact",
        "PreparedWheels",
        "VibratingContact",
        "BodySurface",
        "SweepTable",
    ):
        return
    if name != "ElasticBody":
        assert thing == copy.deepcopy(thing)
        again = pickle.loads(pickle.dumps(thing))
        assert thing == again
        assert not thing != again  # noqa: SIM202
    assert thing != "something else"


@pytest.mark.coarse
def test_equal_scenes_and_results_are_equal_and_others_are_not() -> None:
    for make in (mtb.scenes.pole_shoe_on_rail, mtb.scenes.wheel_on_rail, mtb.scenes.block_on_plane):
        assert make() == make()
        assert make() != make(lower=mtb.Material(3e9, 0.4))
    gap = 1e-3 * np.hypot(*np.mgrid[-1:1:9j, -1:1:9j])
    one, other = (mtb.Scene(mtb.steel, mtb.steel, gap=k * gap, force=10.0) for k in (1.0, 1.0))
    assert one == other != replace(one, gap=2.0 * gap)
    assert one.solve() == other.solve() != one.with_(force=20.0).solve()
    assert mtb.Coulomb(np.full((2, 2), np.float64(0.3))) != mtb.Coulomb(np.full((2, 2), 0.2))

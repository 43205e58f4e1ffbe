# SPDX-License-Identifier: MIT OR Apache-2.0
"""Scenes with elastic bodies of one's own through every door: solves, steps, sweeps, starts of sliding."""

from __future__ import annotations

import itertools
import pickle
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import mtb_rs as mtb
from mtb_rs import _mtb_rs
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.contact import symmetry

rubber = mtb.Material(5e9, 0.2)
STEP = (0.08 / 6, 0.01)
FIELD = np.linspace(0.5, 1.0, 35).reshape(5, 7)


def body(*, upper: bool, held: str, shift: float = 0.0) -> mtb.ElasticBody:
    mesh = block_mesh(np.linspace(-0.04, 0.04, 7), np.linspace(-0.02, 0.02, 5), 0.03)
    z = {"driven": None, "clamped": 0.0, "guided": mtb.Guide(-2e3 if upper else 5e3)}[held]
    support = [mtb.Support("top" if upper else "bottom", x=0, y=0, z=z)]
    if upper:
        return mtb.ElasticBody(mesh.moved(shift=(shift, 0, 0)), rubber, "contact", support, "pad")
    turned = mesh.moved(np.diag([1.0, -1.0, -1.0]))
    return mtb.ElasticBody(turned, mtb.steel, "contact", support, "table")


@cache
def bodies() -> tuple[dict[str, Any], dict[str, Any]]:
    upper = {held: body(upper=True, held=held) for held in ("driven", "clamped", "guided")}
    lower = {held: body(upper=False, held=held) for held in ("clamped", "guided")}
    return (
        upper | {"half-space": rubber, "rigid": mtb.Rigid()},
        lower | {"half-space": mtb.steel, "rigid": mtb.Rigid()},
    )


LOADS: dict[str, dict[str, Any]] = {
    "force": {"force": 3e3},
    "moments": {"force": 3e3, "moments": (1.0, 2.0)},
    "approach": {"approach": 2e-6},
    "pull": {"magnetic_pressure": 1e6},
    "pull, moments": {"magnetic_pressure": 1e6, "moments": (1.0, 2.0)},
    "pull as a field": {"magnetic_pressure": 1e6 * FIELD},
    "pull as a function": {"magnetic_pressure": lambda x, y: 1e6 * (1.0 + 3.0 * x)},
    "pull as a table": {
        "magnetic_pressure": mtb.VelocityTable((0.0, 10.0), (1e6, 1e6 * FIELD)),
        "velocity": 4.0,
    },
    "nothing": {},
}
FRICTIONS: dict[str, Any] = {
    "number": 0.2,
    "field": 0.3 * FIELD,
    "function": lambda x, y: 0.2 + x,
    "table": mtb.VelocityTable((0.0, 10.0), (0.3 * FIELD, 0.1)),
    "of pressure": mtb.PressureDependentFriction(lambda p: 0.2 / (1.0 + p / 1e8)),
}
CASES = [
    case
    for case in itertools.product(*bodies(), LOADS, FRICTIONS, ("upper", "both"), ((1.0, 0.0), (0.3, -1.0)))
    if {case[0], case[1]} & {"driven", "clamped", "guided"} and ("pull" in case[2] or case[4] == "upper")
]


def scene_of(case: tuple[Any, ...]) -> mtb.Scene:
    upper, lower, load, friction, attraction, direction = case
    given = {"velocity": 4.0} if friction == "table" else {}
    return mtb.Scene(
        bodies()[0][upper],
        bodies()[1][lower],
        spacing=STEP,
        friction=FRICTIONS[friction],
        attraction=attraction,
        sliding_direction=direction,
        **(LOADS[load] | given),
    )


def attempted(scene: mtb.Scene) -> mtb.Result | str:
    """The result, or why there is none."""
    try:
        return scene.solve()
    except (ValueError, mtb.ConvergenceError) as error:
        return str(error)


@pytest.mark.coarse
@settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(st.sampled_from(CASES))
@pytest.mark.slow
def test_every_way_of_asking_gives_the_same_numbers(case: tuple[Any, ...]) -> None:
    scene = scene_of(case)
    result = attempted(scene)
    if isinstance(result, str):
        words = ("leave pad free along z", "never touch", "leave table free along z", "resultant of the load")
        assert any(w in result for w in words)
        return
    size = abs(result.force[2])
    again = scene.solve(model=result.model, method=result.report.method)
    np.testing.assert_array_equal(again.pressure, result.pressure)
    if case[3] != "of pressure":
        contact = scene.prepare(result.model, reference_point=(0.0, 0.0, 0.05))
        step = contact.step()
        np.testing.assert_allclose(step.force, result.force, rtol=0, atol=1e-9 * size)
        moment = result.moment - np.cross([0.0, 0.0, 0.05], result.force)
        np.testing.assert_allclose(step.moment, moment, rtol=0, atol=1e-9 * 0.05 * size)
        there = result.area > 0.0
        apart = np.abs(step.pressure - result.pressure[there])
        assert apart.max() <= 1e-9 * result.pressure.max()
        copy = pickle.loads(pickle.dumps(contact)).step(velocity=scene.velocity)
        np.testing.assert_allclose(copy.force, step.force, rtol=0, atol=1e-9 * size)
    # at first the pressure is that without friction, and the friction is within its bound
    begun = scene.start_of_sliding([[1e-9 * along for along in case[5]], [3e-7 * along for along in case[5]]])
    smooth = scene.with_(friction=0.0).solve()
    assert begun.normal_force[0] == pytest.approx(smooth.normal_force, rel=1e-2)
    bound = 0.5 * begun.pressure * (1.0 + 1e-6) + 1e-6 * begun.pressure.max()
    assert (np.hypot(*begun.traction) <= bound).all()


@pytest.mark.coarse
@pytest.mark.parametrize(
    ("upper", "lower"), [("driven", "half-space"), ("half-space", "clamped"), ("driven", "clamped")]
)
def test_far_from_rest_a_start_is_the_sliding_state(upper: str, lower: str) -> None:
    scene = scene_of((upper, lower, "force", "number", "upper", (1.0, 0.0)))
    result = scene.solve()
    start = scene.start_of_sliding([[2e-6, 0.0], [1e-4, 0.0], [2e-4, 0.0], [3e-4, 0.0]])
    assert start.slip_share[-1] == 1.0
    there = result.area > 0.0
    np.testing.assert_allclose(
        start.pressure, result.pressure[there], rtol=0, atol=1e-6 * result.pressure.max()
    )
    np.testing.assert_allclose(start.force[-1], result.force[:2], rtol=1e-6, atol=1e-3)


@pytest.mark.coarse
@pytest.mark.filterwarnings("ignore:.*has nothing opposite:UserWarning")
def test_a_sweeps_value_is_the_scene_made_with_it() -> None:
    scene = scene_of(("driven", "half-space", "pull", "number", "upper", (1.0, 0.0)))
    other = body(upper=True, held="driven", shift=0.01)
    parameters: dict[str, Any] = {
        "magnetic_pressure": {"even": 1e6, "field": 1e6 * FIELD},
        "friction": [0.0, 0.3],
        "lower": {"steel": mtb.steel, "table": bodies()[1]["clamped"]},
        "upper": {"pad": scene.upper, "other": other, "half-space": rubber},
    }
    with pytest.raises(ValueError, match="gap is missing"):
        scene.with_(upper=rubber)
    table = mtb.sweep(scene, parameters)
    for names in itertools.product(*parameters.values()):
        case = dict(zip(parameters, names, strict=True))
        values = {k: parameters[k][v] if isinstance(parameters[k], dict) else v for k, v in case.items()}
        at = tuple(list(parameters[k]).index(v) for k, v in case.items())
        if case["upper"] == "half-space" and case["lower"] == "steel":
            assert "gap is missing" in table.status[at]
            continue
        made = mtb.Scene(**{"spacing": STEP, **values})
        alone = attempted(made)
        if isinstance(alone, str):
            assert alone in table.status[at]
            continue
        assert table.status[at] == "solved"
        assert table.columns["normal_force"][at] == pytest.approx(alone.normal_force, rel=1e-12)
        assert table.columns["force_x"][at] == pytest.approx(alone.force[0], rel=1e-12, abs=1e-9)


@pytest.mark.coarse
def test_a_sweep_in_processes_and_with_a_checkpoint(tmp_path: Path) -> None:
    scene = scene_of(("driven", "clamped", "pull", "number", "both", (1.0, 0.0)))
    pulls = [1e6, 2e6, 3e6]
    alone = mtb.sweep(scene, {"magnetic_pressure": pulls}, checkpoint=tmp_path / "kept")
    done: list[int] = []
    again = mtb.sweep(
        scene_of(("driven", "clamped", "pull", "number", "both", (1.0, 0.0))),
        {"magnetic_pressure": pulls},
        checkpoint=tmp_path / "kept",
        progress=lambda count, of: done.append(count),
    )
    assert done == [3]
    shared = mtb.sweep(scene, {"magnetic_pressure": pulls}, executor=2)
    for table in (again, shared):
        np.testing.assert_allclose(table.columns["normal_force"], alone.columns["normal_force"], rtol=1e-12)


def symmetric() -> mtb.ElasticBody:
    """A block with a mesh that is its own mirror image."""
    half = block_mesh(np.linspace(-0.04, 0.04, 7), np.linspace(0.0, 0.02, 3), 0.03)
    image = half.mirrored()
    nodes, place = np.unique(np.concatenate([half.nodes, image.nodes]) + 0.0, axis=0, return_inverse=True)
    cells = place.ravel()[np.concatenate([half.cells, image.cells + len(half.nodes)])]
    held = [mtb.Support("top", x=0, y=0, z=0)]
    return mtb.ElasticBody(mtb.TetraMesh(nodes, cells), rubber, "bottom", held)


def test_a_further_load_makes_nothing_of_the_geometry_again(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = mtb.Scene(symmetric(), mtb.steel, spacing=STEP, friction=0.2, approach=1e-6)
    first = scene.solve()
    assert "mirror half" in first.report.solver

    def never(*_: Any, **__: Any) -> Any:
        raise AssertionError("made again")

    monkeypatch.setattr(mtb.ElasticBody, "sample", never)
    monkeypatch.setattr(mtb.ElasticBody, "condense", never)
    monkeypatch.setattr(symmetry, "_images", never)
    monkeypatch.setattr(symmetry, "_responds_alike", never)
    monkeypatch.setattr(_mtb_rs, "half_space_cut_hats", never)
    monkeypatch.setattr(_mtb_rs, "Problem", never)
    doubled = scene.with_(approach=2e-6).solve()
    np.testing.assert_allclose(doubled.pressure, 2.0 * first.pressure, rtol=1e-9)
    # bodies that are equal, from another process for example, are the same
    twin = pickle.loads(pickle.dumps(scene))
    np.testing.assert_array_equal(twin.solve().pressure, first.pressure)


@pytest.mark.coarse
def test_what_differs_between_bodies_is_not_mixed_up() -> None:
    """Bodies of one mesh that differ in one thing only have solutions of their own."""
    mesh = block_mesh(np.linspace(-0.04, 0.04, 7), np.linspace(-0.02, 0.02, 5), 0.03)
    held = [mtb.Support("top", x=0, y=0, z=mtb.Guide(-2e3))]
    plain = mtb.ElasticBody(mesh, rubber, "contact", held)
    others = [
        mtb.ElasticBody(mesh, mtb.steel, "contact", held),
        mtb.ElasticBody(mesh, rubber, "contact", [mtb.Support("top", x=0, y=0, z=mtb.Guide(-3e3))]),
        mtb.ElasticBody(mesh, rubber, "contact", [mtb.Support("top", x=0, y=1e-6, z=mtb.Guide(-2e3))]),
        mtb.ElasticBody(mesh, rubber, "contact", [mtb.Support("rear", x=0, y=0, z=mtb.Guide(-2e3))]),
        mtb.ElasticBody(mesh, rubber, ((-0.04, 0.04 / 3), (-0.02, 0.02), (0.0, 0.0)), held),
        mtb.ElasticBody(mesh.moved(shift=(0.0, 0.0, 1e-6)), rubber, "contact", held),
    ]

    def solved(pad: mtb.ElasticBody, **more: Any) -> mtb.Result:
        return mtb.Scene(pad, mtb.steel, spacing=STEP, friction=0.2, **more).solve()

    reference = solved(plain)
    for other in others[:-1]:
        moved, before = solved(other).displacement.upper, reference.displacement.upper
        assert moved.shape != before.shape or np.abs(moved - before).max() > 1e-3 * np.abs(before).max()
    np.testing.assert_allclose(solved(others[-1]).pressure, reference.pressure, rtol=1e-6)
    again = solved(plain)
    np.testing.assert_array_equal(again.pressure, reference.pressure)
    assert next(iter(solved(plain.named("other")).states())) == "other"


def test_a_field_in_a_table_and_one_for_each_pole_are_carried_to_other_cells() -> None:
    """The estimate solves on wider cells: it must find the field there too."""
    pull = 3e6 * np.ones((16, 4, 1))[:, :, 0].T
    plain = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, friction=0.2)
    shape = plain.problem("elastic-upper").patches[0]
    pull = np.full((shape.ny, shape.nx), 3e6)
    expected = plain.solve()
    assert expected.report.error_estimates
    for spec in ([pull, pull], mtb.VelocityTable((0.0, 1.0), ([pull, 3e6], [3e6, pull]))):
        result = plain.with_(magnetic_pressure=spec, velocity=0.5).solve()
        assert result.model == expected.model
        assert result.report.error_estimates == pytest.approx(expected.report.error_estimates, rel=1e-6)
        np.testing.assert_allclose(result.force, expected.force, rtol=1e-9, atol=1e-3)


@pytest.mark.coarse
def test_models_are_named_as_results_name_them() -> None:
    scene = scene_of(("half-space", "clamped", "force", "number", "upper", (1.0, 0.0)))
    assert scene.solve("elastic-lower").model == "elastic-lower"
    for ask in (scene.solve, scene.prepare, lambda model: scene.start_of_sliding([[1e-6, 0.0]], model)):
        with pytest.raises(ValueError, match="has its model in its bodies, 'elastic-lower'"):
            ask("elastic-upper")
    ready = mtb.scenes.block_on_plane(spacing=2e-2)
    with pytest.raises(ValueError, match="model is 'elastic-lower': this scene has no geometry"):
        ready.solve("elastic-lower")


@pytest.mark.parametrize(
    ("upper", "lower", "friction"), [("driven", "half-space", "number"), ("half-space", "clamped", "field")]
)
def test_a_chart_has_all_grids_that_the_mesh_is_fine_enough_for(
    upper: str, lower: str, friction: str
) -> None:
    scene = scene_of((upper, lower, "force", friction, "upper", (1.0, 0.0)))
    chart = scene.chart(budget=4.0, repeats=1)
    assert "on the meshes as they are" in chart.reference
    points = [p for p in chart.points if not p.is_reference]
    name = scene.own_model
    assert {f"{name}, direct", f"{name}, further loads"} <= {p.series for p in points}
    # none is finer than the nodes of the mesh allow, and all are of this scene
    nodes = 0.08 / 12, 0.04 / 8
    assert all(p.spacing**2 * 1.5**2 >= nodes[0] * nodes[1] for p in chart.points)
    assert not any(p.failure for p in points)
    own = [p for p in points if p.unknowns == 35 and "frictionless" not in p.series]
    assert own
    assert all(p.errors["pressure"] < 0.1 and p.errors["force"] < 1e-2 for p in own)
    assert not any("half-space" in p.series for p in points)


@pytest.mark.coarse
def test_a_given_gap_is_thinned_on_wider_cells() -> None:
    """Its means over the hats: of a linear one the same line, but for the border."""
    line = np.broadcast_to(1e-6 * np.linspace(0.0, 1.0, 7), (5, 7)).copy()
    scene = scene_of(("clamped", "half-space", "approach", "number", "upper", (1.0, 0.0)))
    tapered = scene.with_(gap=line)
    wide = tapered.with_(spacing=(2 * STEP[0], 2 * STEP[1])).solve()
    np.testing.assert_allclose(wide.initial_gap[:, 1:-1], line[::2, 2:-2:2], rtol=1e-9)
    assert wide.normal_force == pytest.approx(tapered.solve().normal_force, rel=0.05)
    with pytest.raises(ValueError, match=r"the gap is given on 6 x 4 cells"):
        tapered.with_(spacing=(STEP[0] / 2, STEP[1] / 2)).solve()

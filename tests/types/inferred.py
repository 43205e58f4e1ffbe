# SPDX-License-Identifier: MIT OR Apache-2.0
"""What a type checker infers of each kind of scene; mypy reads this file, nobody runs it."""

from pathlib import Path
from typing import Any, assert_type

import pyvista
import xarray
from matplotlib.figure import Figure

import mtb_rs as mtb
from mtb_rs import scenes
from mtb_rs.results.chart import Chart
from mtb_rs.results.fields import Field as ResultField

# ready scenes whose upper body slides, of half-spaces and of elastic bodies
for sliding in (scenes.paraboloid_on_plane(), scenes.block_on_plane(), scenes.pole_shoe_on_rail()):
    assert_type(sliding, mtb.Scene)
    assert_type(sliding.with_(friction=0.3), mtb.Scene)
    assert_type(sliding.solve("elastic-upper", "direct", 0.05, "force"), mtb.Result)
    contact = sliding.prepare("half-space", standstill_speed=0.1)
    assert_type(contact, mtb.PreparedContact)
    step = contact.step(velocity=10.0)
    assert_type(step, mtb.StepResult)
    assert_type(step.plot("gap"), Figure)
    assert_type(sliding.start_of_sliding([[1e-6, 0.0]], pressure="held"), mtb.StartOfSliding)
    assert_type(sliding.chart("force"), Chart)

# a wheel on a rail
wheel = scenes.wheel_on_rail()
assert_type(wheel, mtb.WheelScene)
assert_type(wheel.with_(lateral=0.0), mtb.WheelScene)
assert_type(wheel.solve(), mtb.Result)
wheels = wheel.prepare(friction=mtb.Coulomb(0.3), side="both")
assert_type(wheels, mtb.PreparedWheels)
rolled = wheels.step(velocity=20.0)
assert_type(rolled, mtb.WheelStep)
assert_type(rolled.plot("slip", x=0.0), Figure)
assert_type(rolled.patches[0].plot("slip"), Figure)
assert_type(rolled.patches[0].plot("pressure", "3d"), pyvista.Plotter)

# scenes of one's own: on a field, and with an elastic body
body = mtb.ElasticBody.from_mesh("pad.msh", mtb.steel, contact="bottom")
for own in (
    mtb.Scene(mtb.steel, mtb.Rigid(), gap=[[0.0] * 8] * 8, spacing=1e-3, force=1e3),
    mtb.Scene(body, mtb.steel, spacing=1e-3, force=1e3),
):
    assert_type(own, mtb.Scene)
    assert_type(own.prepare(), mtb.PreparedContact)
    result = own.solve()
    assert_type(result, mtb.Result)
    assert_type(result.plot(), Figure)
    assert_type(result.plot("pressure", "map", cmap="magma"), Figure)
    assert_type(result.plot("gap", x=(0.0, 1e-3)), Figure)
    assert_type(result.plot("status", kind="line", y=0.0), Figure)
    assert_type(result.plot("pressure", "3d"), pyvista.Plotter)
    assert_type(result.plot(kind="3d", off_screen=True), pyvista.Plotter)
    assert_type(result.plot("von_mises", limits=(0.0, 1e8)), pyvista.Plotter)
    assert_type(own.solve(result.model), mtb.Result)
    assert_type(result.to_xarray(), xarray.Dataset)

# height fields and rolling
normal = mtb.solve_normal([[0.0] * 8] * 8, 1e-3, lower=mtb.steel, upper=mtb.Rigid(), force=1e3, edge="sharp")
assert_type(normal.plot("initial_gap"), Figure)
rolling = mtb.solve_tangential(normal, mtb.Rolling(velocity=20.0), mtb.Coulomb(0.3), coupling="full")
assert_type(rolling, mtb.TangentialResult)
assert_type(rolling.plot("traction", x=0.0), Figure)
assert_type(mtb.fastsim(normal, (1e-3, 0.0, 0.0), mtb.Coulomb(0.3), velocity=20.0), mtb.FoundationResult)
assert_type(mtb.animate([rolling, rolling], "rolling.gif", "slip", captions=["a", "b"]), Path)

# what was saved is of one of eighteen kinds, to be told apart before what only some have is asked for
loaded = mtb.load(Path("out"))
assert_type(loaded.fields(), dict[str, ResultField])
if isinstance(loaded, mtb.Result):
    assert_type(loaded, mtb.Result)
    assert_type(loaded.normal_force, float)
    assert_type(loaded.plot("pressure"), Figure)
elif not isinstance(loaded, (mtb.NormalResult, mtb.TangentialResult, mtb.FoundationResult, mtb.StepResult)):
    if isinstance(loaded, (mtb.Hertz, mtb.WheelStep, mtb.WheelPatch, mtb.Chart, mtb.SweepTable)):
        assert_type(loaded.plot("pressure"), Figure)
    elif isinstance(loaded, mtb.Braking):
        assert_type(loaded.shoe, mtb.SlidingHeat)
    elif isinstance(loaded, mtb.Stability):
        assert_type(loaded, mtb.Stability)
    elif isinstance(loaded, mtb.WheelWear):
        assert_type(loaded.wheel(), mtb.Profile)
    elif isinstance(loaded, mtb.Vibration):
        assert_type(loaded, mtb.Vibration)
    elif isinstance(loaded, mtb.WheelsetGeometry):
        assert_type(loaded.wheel_radius, float)
    elif isinstance(loaded, mtb.StressField):
        assert_type(loaded.plot("xz", "depth"), Any)
    elif not isinstance(loaded, (mtb.AreaLoadCurve, mtb.RollingTemperature, mtb.SlidingHeat, mtb.WearResult)):
        assert_type(loaded, mtb.StartOfSliding)
print(loaded.reprot)  # type: ignore[union-attr]

# sweeps
table = mtb.sweep(wheel, {"lateral": [0.0, 1e-3]})
assert_type(table.to_xarray(), xarray.Dataset)
assert_type(table.rows(), list[dict[str, float | str]])
moved = mtb.sweep(wheel, [{"rolling.velocity": 10.0}], motion=mtb.Rolling(creepage=(1e-3, 0.0, 0.0)))
assert_type(moved, mtb.SweepTable)
assert_type(table, mtb.SweepTable)
assert_type(table.plot("normal_force"), Figure)

# words are checked: each ignored error is an error, or mypy says that there is none to ignore
scenes.block_on_plane().solve("elastic-uper")  # type: ignore[arg-type]
scenes.block_on_plane().solve(method="newton")  # type: ignore[arg-type]
scenes.block_on_plane().solve(quantity="presure")  # type: ignore[arg-type]
scenes.block_on_plane(attraction="lower")  # type: ignore[arg-type]
scenes.block_on_plane(supports="glued")  # type: ignore[arg-type]
wheel.prepare(side="right-hand")  # type: ignore[arg-type]
normal.plot("presure")  # type: ignore[call-overload]
normal.plot("pressure", "3d", x=0.0)  # type: ignore[call-overload]

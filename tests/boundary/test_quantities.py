# SPDX-License-Identifier: MIT OR Apache-2.0
"""Quantities with a unit at the door: every argument with a unit takes them, in any unit of its dimension."""

from __future__ import annotations

import inspect
import pickle
import re
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pint
import pytest

import mtb_rs as mtb
from mtb_rs import _mtb_rs
from mtb_rs.base.owning import is_solved
from mtb_rs.base.plain import same
from mtb_rs.base.units import ARGUMENT_UNITS, EXCEPTIONS, LATER
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.results.fields import FIELDS, TOTALS

UNITS: Any = pint.UnitRegistry()
#: Another unit of each dimension.
OTHERS = {
    "m": "mm",
    "m^2": "mm^2",
    "1": "percent",
    "rad": "deg",
    "m/s": "km/h",
    "rad/s": "deg/ms",
    "Pa": "MPa",
    "Pa/m": "MPa/mm",
    "N": "kN",
    "N m": "kN mm",
    "A": "kA",
    "H": "mH",
    "s": "ms",
    "1/s": "1/ms",
    "Hz": "kHz",
    "1/m": "1/mm",
    "N/m": "kN/mm",
    "N/m^2": "kN/mm^2",
    "m/Pa": "mm/MPa",
    "K": "mK",
    "K m^2/W": "K mm^2/W",
    "W/K/m^2": "kW/K/m^2",
    "W/(m K)": "kW/(m K)",
    "kg": "t",
    "W/(m K^2)": "kW/(m K^2)",
    "1/K": "1/mK",
    "1/K^2": "1/mK^2",
    "1/Pa": "1/MPa",
    "kg/m^3": "g/cm^3",
    "J/(kg K)": "kJ/(kg K)",
}
#: Classes that users do not make: their numbers come from the package.
MADE_HERE = {
    "AreaLoadCurve": "by area_load_curve",
    "Chart": "by Scene.chart",
    "ChartPoint": "by Scene.chart",
    "CreepForceTable": "by CreepForceTable.build",
    "Field": "by the results",
    "ReducedBody": "by PreparedContact.reduced",
    "Rubbing": "by wear",
    "Smoothing": "by Profile.smoothed",
    "Stability": "by PreparedContact.stability",
    "Vibration": "by vibration",
    "VibratingContact": "by PreparedContact.vibrating",
    "VibratingState": "by VibratingContact.step",
    "VibratingStep": "by VibratingContact.step",
    "SweepTable": "by sweep",
    "TouchingWheel": "by wheelset_geometry",
    "WheelWear": "by wear_of_wheels",
    "WheelsetGeometry": "by wheelset_geometry",
    "WheelState": "by steps of wheels",
}


def last_point(found: Any) -> Any:
    """Of a picture, what was drawn last; otherwise what was found."""
    return found.axes[0].lines[-1].get_xydata() if hasattr(found, "axes") else found


def public() -> Iterator[tuple[str, Any]]:
    """Public functions, ready scenes, methods of public classes, and the making of those that users make."""
    for name in mtb.__all__:
        entry = getattr(mtb, name)
        if inspect.isfunction(entry):
            yield name, entry
        elif inspect.isclass(entry) and not issubclass(entry, BaseException):
            if not is_solved(entry) and name not in MADE_HERE:
                yield name, entry
            for method, made in inspect.getmembers(entry, callable):
                if not method.startswith("_"):
                    yield f"{name}.{method}", made
    for name in ("block_on_plane", "paraboloid_on_plane", "pole_shoe_on_rail", "wheel_on_rail"):
        yield name, getattr(mtb.scenes, name)


def documented(made: Any) -> Iterator[tuple[str, set[str]]]:
    """Arguments with the units that the docstring gives them."""
    try:
        known = set(inspect.signature(made).parameters)
    except (TypeError, ValueError):
        return
    for line in (inspect.getdoc(made) or "").splitlines():
        found = re.match(r"^([a-z_]\w*(?:, [a-z_]\w*)*) : (.*)$", line)
        if found is None:
            continue
        names = found[1].split(", ")
        # those of several names, in their order, or those of the entries of one
        units = [u.split(", ") for u in re.findall(r"\[([^\]\d\"']*1?[^\]\d\"']*2?)\]", found[2])]
        for k, name in enumerate(names):
            own = units[k : k + 1] if len(units) == len(names) else units
            said = {u.replace("m2", "m^2") if u != "-" else "1" for part in own for u in part}
            if said and name in known:
                yield name, said


def test_the_table_has_every_documented_unit() -> None:
    seen = set()
    for place, made in public():
        for name, said in documented(made):
            wanted = EXCEPTIONS.get(place, {}).get(name, ARGUMENT_UNITS.get(name, ()))
            units = set(wanted.split(" or ") if isinstance(wanted, str) else wanted)
            assert said == units, f"{place}({name}) is documented as {said}, the table has {wanted}"
            seen.add(name)
    assert len(seen) > 40


def written(y: Any) -> str:
    RAIL.to_file("rail.prr", y)
    return Path("rail.prr").read_text()


def field() -> mtb.PressureField:
    x = np.linspace(-1.0, 1.0, 12)
    inside = np.maximum(0.0, 1.0 - x[None] ** 2 - x[:, None] ** 2)
    return mtb.PressureField(1e8 * np.sqrt(inside), (1e-4, 1e-4), mtb.steel, mtb.steel)


LINE = np.linspace(0.0, 0.02, 3)
X = np.arange(-6, 7) * 1e-3
BALL = (X[None, :] ** 2 + X[:, None] ** 2) / 0.2
ROUGH = mtb.roughness(8, 1e-6, rms_slope=0.1, seed=1)
STEELS: dict[str, Any] = {"lower": mtb.steel, "upper": mtb.steel}
BLOCK: dict[str, Any] = {"spacing": 0.025, "friction": 0.1}
ROLLING: dict[str, Any] = {"normal": field(), "friction": mtb.Coulomb(0.3)}
TWO = ((0.0, 0.0, -0.001), (0.02, 0.02, 0.011))
SLOW: dict[str, Any] = {"tolerance": 1e-6}


def scene(**given: Any) -> mtb.Scene:
    return mtb.Scene(**{**STEELS, "gap": BALL, "spacing": 1e-3} | given)


def held() -> mtb.PreparedContact:
    contact = mtb.scenes.block_on_plane(spacing=25e-3).prepare("elastic-upper")
    assert isinstance(contact, mtb.PreparedContact)
    return contact


def prepared() -> mtb.PreparedContact:
    made = mtb.scenes.block_on_plane(**BLOCK).prepare("half-space")
    assert isinstance(made, mtb.PreparedContact)
    return made


def pulled() -> mtb.PreparedContact:
    magnet = mtb.Magnet(1e3, 1e-3)
    made = mtb.scenes.block_on_plane(**BLOCK, magnetic_pressure=magnet).prepare("half-space")
    assert isinstance(made, mtb.PreparedContact)
    return made


def wheels() -> mtb.PreparedWheels:
    made = mtb.scenes.wheel_on_rail(spacing=1e-3).prepare(tolerance=None)
    assert isinstance(made, mtb.PreparedWheels)
    return made


def of_step(made: Any, **given: Any) -> Any:
    step = made.step(**given)
    return step.force, step.friction_power, step.friction_work


def saved(made: Any, **given: Any) -> Any:
    library = Path("libmtb_fmu.so")
    library.write_bytes(f"mtb-fmu-{mtb.__version__}-".encode())
    made.save_fmu("unit.fmu", library, **given)
    with zipfile.ZipFile("unit.fmu") as unit:
        lines = unit.read("resources/variables.txt").decode().splitlines()
    return [float(word) for line in lines for word in line.split()[1:]]


def body(**given: Any) -> Any:
    made = mtb.ElasticBody(block_mesh(LINE, LINE, 0.01), mtb.steel, contact="top", supports=[])
    return made.nodes_at("place", **given)


def points(surface: mtb.BodySurface | mtb.Profile) -> Any:
    if isinstance(surface, mtb.Profile):
        return surface.height([-1e-3, 0.0, 1e-3])
    return surface.top([1e-3, -1e-3], [1e-3, 0.0])


CORNERS = np.array([[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0], [0.0, 0.0, 0.0, 0.0]]) * 5e-3
RAIL = mtb.Profile.standard("60E1")
TREAD = mtb.Viscoelastic(mtb.steel, 0.5, 1e-3)
HERTZ = mtb.hertz(1e3, 0.1)
HALF = _mtb_rs.half_space(mtb.HalfSpace(mtb.steel).elastic, [(0.0, 0.0, 2, 2)], [(1e-3, 1e-3)], True)
PAIR = _mtb_rs.Compliance.relative(HALF, HALF)
#: Points of a profile, to be smoothed.
TABLE = mtb.Profile.from_points(np.linspace(-0.03, 0.03, 300), -(np.linspace(-0.03, 0.03, 300) ** 2))
#: A call of every public function and method that takes numbers with a unit, several where some
#: exclude others.
CALLS: list[tuple[str, Callable[..., Any], dict[str, Any]]] = [
    (
        "BodySurface.block",
        lambda **a: points(mtb.BodySurface.block(**a)),
        dict(length=0.1, width=0.1, height=0.01),
    ),
    (
        "BodySurface.height_field",
        lambda **a: points(mtb.BodySurface.height_field(**a)),
        dict(heights=BALL, spacing=1e-3, start=(-5e-3, -4e-3)),
    ),
    (
        "BodySurface.mesh",
        lambda **a: points(mtb.BodySurface.mesh(triangles=[[0, 1, 2], [0, 2, 3]], closed=False, **a)),
        dict(vertices=CORNERS),
    ),
    (
        "BodySurface.paraboloid",
        lambda **a: points(mtb.BodySurface.paraboloid(**a)),
        dict(radius=0.2, radius_y=0.3),
    ),
    ("BodySurface.plane", lambda **a: points(mtb.BodySurface.plane(**a)), dict(height=0.2)),
    ("BodySurface.rail", lambda **a: points(mtb.BodySurface.rail(**a)), dict(length=0.2)),
    ("BodySurface.top", mtb.BodySurface.paraboloid(0.1).top, dict(x=[0.01, 0.02], y=[0.0, 0.01])),
    ("BodySurface.bottom", mtb.BodySurface.paraboloid(0.1).bottom, dict(x=0.01, y=0.02)),
    ("Archard", mtb.Archard, dict(wear_coefficient=1e-13)),
    (
        "WearMap",
        mtb.WearMap,
        dict(hardness=3e9, k=[[5e-4, 35e-4], [350e-4, 350e-4]], pressure=[2.4e9], speed=[0.2]),
    ),
    ("EnergyWear", mtb.EnergyWear, dict(energy=[0.0, 1e7], rate=[0.0, 0.05], density=7850.0)),
    ("Passages", mtb.Passages, dict(distance=30.0)),
    (
        "wear",
        lambda **given: mtb.wear(mtb.scenes.paraboloid_on_plane(points=14), **given),
        dict(gap=np.zeros((14, 14)), distance=1e-3, law=1e-13, tolerance=0.1, uniformity=0.9, limit=1e-7),
    ),
    (
        "wear_of_wheels",
        lambda **given: (
            mtb.wear_of_wheels(
                mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=2e-3),
                friction=mtb.Coulomb(0.3),
                passages=2.0,
                **given,
            ).wheel_volumes
        ),
        {
            **dict(distance=1e3, law=1e-13, lower_law=1e-13, shifts=[0.0, 1e-3], shares=[1.0, 2.0]),
            **dict(yaw=1e-3, velocity=20.0, depth=1e-4, wavelength=4e-3),
        },
    ),
    (
        "WearResult.life",
        lambda limit: mtb.wear(mtb.scenes.paraboloid_on_plane(points=14), 1e-3, 1e-13).life(limit),
        dict(limit=1e-9),
    ),
    (
        "brake",
        lambda **a: mtb.brake(mtb.scenes.block_on_plane(spacing=0.025, friction=0.1), **a).way,
        dict(speed=0.5, mass=2e4, other_force=100.0, shares=(1.0, 0.5), tolerance=0.5),
    ),
    (
        "wear_of_stops",
        lambda **a: (
            mtb.wear_of_stops(
                mtb.scenes.block_on_plane(spacing=0.025, friction=0.1), count=1, wear=1e-14, **a
            )[0].distance
        ),
        dict(speed=0.5, mass=2e4, other_force=100.0, shares=(1.0, 0.5), tolerance=0.5, stop_tolerance=0.5),
    ),
    (
        "Conductor",
        mtb.Conductor,
        {
            **dict(conductivity=50.0, density=7850.0, specific_heat=450.0, expansion=12e-6),
            **dict(conductivity_slope=-0.03, expansion_slope=1e-9),
        },
    ),
    ("Coulomb", mtb.Coulomb, dict(coefficient=0.3)),
    ("Coulomb", mtb.Coulomb, dict(coefficient=np.full((12, 12), 0.3))),
    (
        "CreepForceTable.build",
        lambda **a: mtb.CreepForceTable.build(nodes=4, cells=6, **a),
        dict(ratios=(1.0,), poisson_ratio=0.25),
    ),
    (
        "CreepForceTable.creep_forces",
        lambda **a: mtb.CreepForceTable.build((1.0,), 0.3, nodes=4, cells=6).creep_forces(**ROLLING, **a),
        dict(creepages=[(1e-3, 0.0, 0.1)], semi_axes=(6e-4, 6e-4)),
    ),
    (
        "CreepForceTable.interpolate",
        mtb.CreepForceTable.build((1.0,), nodes=4, cells=6).interpolate,
        dict(
            semi_axes=(5e-3, 5e-3),
            normal_force=1e4,
            shear_modulus=8e10,
            friction=0.3,
            creepages=(1e-3, 0.0, 0.1),
        ),
    ),
    ("ElasticBody.nodes_at", body, dict(where=TWO)),
    (
        "FallingFriction",
        mtb.FallingFriction,
        dict(static=0.4, kinetic=0.2, half_slip=1.0, memory=1e-3, memory_min_slip=0.1),
    ),
    ("FieldTable", mtb.FieldTable, dict(x=[0.0, 0.1], y=[0.0, 0.2], value=[[1e6, 2e6], [3e6, 4e6]])),
    (
        "GaussianPressure",
        mtb.GaussianPressure,
        dict(peak=1e6, center=(0.01, 0.0), sigma=(0.1, 0.2), floor=0.1),
    ),
    ("Guide", mtb.Guide, dict(force=5.0)),
    (
        "Magnet",
        mtb.Magnet,
        dict(
            ampere_turns=1e3,
            non_magnetic_gap=1e-3,
            iron_share=2.0,
            pole_length=0.03,
            yoke=(0.1, 1e-3),
            armature=(0.1, 1e-3),
            leakage=1e-7,
        ),
    ),
    ("Hertz.gap", HERTZ.gap, dict(x=[0.01], y=[0.02])),
    ("Hertz.on_grid", lambda **a: HERTZ.on_grid((20, 20), **a), dict(spacing=1e-4)),
    ("Hertz.pressure", HERTZ.pressure, dict(x=[1e-5], y=[1e-5])),
    ("Hertz.separation", HERTZ.separation, dict(x=[0.01], y=[0.02])),
    ("Layered", partial(mtb.Layered, mtb.steel, base=mtb.Rigid()), dict(thickness=1e-3)),
    ("Viscoelastic", partial(mtb.Viscoelastic, mtb.steel), dict(creep=0.5, creep_time=1e-3)),
    ("Viscoelastic.deborah_number", TREAD.deborah_number, dict(velocity=2.0, length=1e-2)),
    ("Viscoelastic.elastic_errors", TREAD.elastic_errors, dict(velocity=2.0, length=1e-2)),
    ("InterfaceLayer", mtb.InterfaceLayer, dict(thickness=1e-3, shear_modulus=1e9)),
    (
        "PlasticLayer",
        mtb.PlasticLayer,
        dict(thickness=1e-3, shear_modulus=1e9, yield_stress=1e6, hardening=1e9),
    ),
    ("Material", mtb.Material, dict(young_modulus=210e9, poisson_ratio=0.25)),
    (
        "Material.from_shear_modulus",
        mtb.Material.from_shear_modulus,
        dict(shear_modulus=80e9, poisson_ratio=0.25),
    ),
    (
        "PoleShoe",
        mtb.PoleShoe,
        dict(
            height=0.03,
            length=0.1,
            inner_edge=7e-3,
            outer_edge=0.035,
            conforming_to=0.02,
            relief_slope=0.03,
            lateral=1e-3,
            yaw=1e-3,
        ),
    ),
    ("PoleShoe.grid", lambda **a: mtb.PoleShoe().grid(**a), dict(spacing=5e-3)),
    ("PoleShoe.sole", mtb.PoleShoe().sole, dict(y=[0.01, 0.02])),
    (
        "PreparedContact.save_fmu",
        lambda **a: saved(prepared(), **a),
        dict(pose={"x": 1e-6, "yaw": 1e-6}, velocity=(3.0, 1.0), magnetic_pressure=1e6),
    ),
    ("PreparedContact.save_fmu", lambda **a: saved(pulled(), velocity=3.0, **a), dict(ampere_turns=900.0)),
    (
        "PreparedContact.step",
        lambda **a: of_step(prepared(), **a),
        dict(pose=(1e-6, 0.0, float("nan"), 0.0, 0.0, 1e-6), velocity=3.0, dt=0.1, magnetic_pressure=1e6),
    ),
    ("PreparedContact.step", lambda **a: of_step(prepared(), **a), dict(velocity=(3.0, 1.0))),
    ("PreparedContact.step", lambda **a: of_step(prepared(), **a), dict(dt=0.1, shift=(1e-6, 2e-6))),
    (
        "PreparedContact.step",
        lambda **a: of_step(prepared(), **a),
        dict(gap=1e-7, friction=0.2, diagonal=1e-14),
    ),
    (
        "PreparedContact.stability",
        lambda **a: prepared().stability(stiffness=[1e7], free=["x"], **a).eigenvalues,
        dict(mass=[2.0], pose=(0.0, 0.0, float("nan"), 0.0, 0.0, 1e-6), velocity=3.0),
    ),
    (
        "PreparedContact.stability",
        lambda **a: held().stability([50.0], [1e9], free=["x"], velocity=3.0, modes=2, **a).eigenvalues,
        dict(density=7850.0),
    ),
    (
        "PreparedContact.vibrating",
        lambda **a: (
            held()
            .vibrating(mass=[50.0], stiffness=[1e9], damping=[1e3], free=["x"], modes=2, **a)
            .step(1e-7)
            .energy
        ),
        dict(dt=1e-5, pose=(0.0, 0.0, float("nan"), 0.0, 0.0, 1e-6), velocity=3.0, density=7850.0),
    ),
    (
        "VibratingContact.step",
        lambda **a: held().vibrating(1e-5, density=7850.0, modes=2, velocity=3.0).step(**a).energy,
        dict(shift=(1e-6, 1e-6), friction=0.2),
    ),
    (
        "PreparedContact.reduced",
        lambda **a: held().reduced(modes=2, **a).residual,
        dict(density=7850.0),
    ),
    ("ReducedBody.receptance", lambda **a: held().reduced(7850.0, 2).receptance(**a), dict(frequency=1e3)),
    ("ReducedBody.left_out", lambda **a: held().reduced(7850.0, 2).left_out(**a), dict(frequency=1e3)),
    (
        "vibration",
        lambda **a: (
            mtb.vibration(
                mtb.ElasticBody(block_mesh(LINE, LINE, 0.01), mtb.steel, "bottom"), modes=2, **a
            ).frequency
        ),
        dict(density=7850.0),
    ),
    (
        "PreparedWheels.save_fmu",
        lambda **a: saved(wheels(), **a),
        dict(pose={"y": 1e-4, "yaw": 1e-4}, velocity=(20.0, 0.0, 0.0, 0.0, 20.0 / 0.46, 0.0)),
    ),
    (
        "PreparedWheels.save_fmu",
        lambda **a: saved(wheels(), velocity=20.0, **a),
        dict(lateral_force=3e3, longitudinal_force=1e3, curvature=1e-3),
    ),
    ("PreparedWheels.save_fmu", lambda **a: saved(wheels(), velocity=20.0, **a), dict(axle_moment=10.0)),
    (
        "step_wheels",
        lambda **a: mtb.step_wheels(mtb.scenes.wheel_on_rail(lateral=0.0, spacing=2e-3), **a).force,
        {
            **dict(velocity=(20.0, 0.0, 0.0, 0.0, 20.0 / 0.46, 0.0), x=1e-3, y=1e-3, z=-5e-5, roll=1e-4),
            **dict(pitch=1e-3, yaw=1e-3, curvature=1e-3, rail_stiffness=(2e7, 5e7), rail_force=(0.0, 1e3)),
            **dict(standstill_speed=0.1),
        },
    ),
    (
        "step_wheels",
        lambda **a: mtb.step_wheels(mtb.scenes.wheel_on_rail(lateral=0.0, spacing=2e-3), 20.0, **a).force,
        dict(lateral_force=3e3, longitudinal_force=1e3),
    ),
    (
        "step_wheels",
        lambda **a: mtb.step_wheels(mtb.scenes.wheel_on_rail(lateral=0.0, spacing=2e-3), 20.0, **a).force,
        dict(axle_moment=10.0),
    ),
    (
        "step_wheels",
        lambda **a: (
            mtb.step_wheels(mtb.scenes.wheel_on_rail(lateral=0.0, spacing=2e-3), 20.0, side="both", **a).force
        ),
        dict(right_wheel_radius=0.461),
    ),
    (
        "PreparedWheels.step",
        lambda **a: of_step(wheels(), **a),
        dict(pose=(0.0, 1e-4, float("nan"), 0.0, 0.0, 1e-4), velocity=20.0, dt=0.1),
    ),
    (
        "PreparedWheels.step",
        lambda **a: of_step(wheels(), **a),
        dict(velocity=(20.0, 0.0, 0.0, 0.0, 20.0 / 0.46, 0.0)),
    ),
    (
        "PreparedWheels.step",
        lambda **a: of_step(wheels(), velocity=20.0, **a),
        dict(lateral_force=3e3, curvature=1e-3),
    ),
    (
        "PreparedWheels.step",
        lambda **a: of_step(wheels(), velocity=20.0, **a),
        dict(longitudinal_force=1e3),
    ),
    ("PreparedWheels.step", lambda **a: of_step(wheels(), velocity=20.0, **a), dict(axle_moment=10.0)),
    (
        "Scene.prepare",
        lambda **a: of_step(
            mtb.scenes.wheel_on_rail(spacing=1e-3).prepare(tolerance=None, **a), velocity=20.0
        ),
        dict(rail_stiffness=(2e7, 5e7), rail_force=(0.0, 1e3)),
    ),
    (
        "Scene.prepare",
        lambda **a: of_step(
            mtb.scenes.wheel_on_rail(lateral=0.0, spacing=2e-3).prepare(side="both", **a), velocity=20.0
        ),
        dict(right_wheel_radius=0.461),
    ),
    ("Prism", lambda **a: mtb.Prism(**a).described(), dict(profile=(0.1, 0.05), foundation=(1e8, 5e7))),
    (
        "Prism",
        lambda **a: mtb.Prism(**a).described(),
        dict(
            profile=[(-0.05, -0.1), (-0.05, 0.0), (0.05, 0.0), (0.05, -0.1)],
            base=[(0.0, -0.12)],
            origin=(0.01, 0.0),
        ),
    ),
    (
        "PressureDependentFriction.at",
        mtb.PressureDependentFriction(lambda p: 0.1 + 1e-9 * p).at,
        dict(pressure=np.array([1e6, 2e6])),
    ),
    (
        "PressureField",
        lambda **a: mtb.PressureField(**STEELS, **a),
        dict(
            pressure=BALL, spacing=(1e-4, 1e-4), origin=(1e-3, 0.0), inclination=0.01 * np.arange(len(BALL))
        ),
    ),
    (
        "PressureField",
        lambda **a: mtb.PressureField(BALL[:1], (1e-4, 1e-4), **STEELS, **a),
        dict(reference=1e-3),
    ),
    *(
        (f"Profile.{name}", getattr(RAIL, name), dict(y=[0.01, 0.02]))
        for name in ("height", "slope", "curvature", "normal", "arc_length")
    ),
    (
        "Profile.to_file",
        written,
        dict(y=[0.01, 0.02, 0.03]),
    ),
    ("rail_damage", lambda **a: mtb.rail_damage(**a), dict(t_gamma=[20.0, 60.0])),
    *(
        (
            f"{name}.{method}",
            lambda made=made, method=method, **a: last_point(getattr(made(), method)(**a)),
            dict(shear_yield=3e8),
        )
        for name, made in (
            ("TangentialResult", lambda: rolled()),
            ("FoundationResult", lambda: mtb.fastsim(field(), (1e-3, 0.0, 0.0), mtb.Coulomb(0.3))),
            ("WheelPatch", lambda: wheels().step(velocity=20.0).patches[0]),
        )
        for method in ("surface_fatigue_index", "shakedown", "plot_shakedown")
    ),
    (
        "StressField.dang_van",
        lambda **a: rolled().stress(depths=[1e-3]).dang_van(**a),
        dict(coefficient=0.3, residual_stress=[1e7, 2e7, 0.0, 0.0, 0.0, 0.0]),
    ),
    (
        "TangentialResult.wear_depth",
        lambda wheel_radius: rolled().wear_depth(1e-13, wheel_radius),
        dict(wheel_radius=0.46),
    ),
    (
        "Profile.from_points",
        lambda **a: points(mtb.Profile.from_points(**a)),
        dict(y=np.linspace(-0.01, 0.01, 9), z=np.linspace(-1.0, 1.0, 9) ** 2),
    ),
    ("Profile.position", RAIL.position, dict(s=[0.01])),
    (
        "RailSlices",
        lambda **a: mtb.RailSlices(profiles=["60E1"] * 2, **a).height(0.5, 0.01),
        dict(positions=[0.0, 1.0], features=[[0.0], [0.001]]),
    ),
    (
        "WheelSlices",
        lambda **a: mtb.WheelSlices(profiles=["S1002"] * 4, **a).height(0.5, 0.01),
        dict(angles=[0.0, 1.0, 2.0, 3.0], features=[[0.0], [0.001], [0.002], [0.001]]),
    ),
    (
        "RailFriction",
        mtb.RailFriction,
        dict(rail_position=np.linspace(0.0, 0.02, 5), coefficient=np.full((2, 5), 0.3), x=[0.0, 1.0]),
    ),
    ("Rolling", mtb.Rolling, dict(creepage=(1e-3, 0.0, 0.1), angle=0.2, velocity=20.0, step=1e-3)),
    (
        "Scene.sliding_heat",
        lambda **a: (
            mtb.scenes.block_on_plane(spacing=0.025, friction=0.1).sliding_heat(steps=2, **a).temperatures
        ),
        {
            **dict(duration=2.0, velocity=3.0, bulk=(10.0, 20.0), film=(10.0, 5.0), resistance=1e-4),
            **dict(share=0.4, wear=1e-12, lower_wear=1e-13, fading=([0.0, 10.0], [1.0, 0.5]), tolerance=0.2),
        },
    ),
    (
        "NormalResult.stress",
        lambda **a: [
            mtb.hertz(1e3, 0.5, lower=mtb.steel, upper=mtb.steel)
            .on_grid((32, 32), 1e-4)
            .stress(**{name: value})
            for name, value in a.items()
        ],
        {"depths": [1e-4, 2e-4], "points": [[0.0], [1e-4], [-1e-4]]},
    ),
    (
        "TangentialResult.temperature",
        lambda **a: (
            mtb.solve_tangential(motion=mtb.Rolling((1e-3, 0.0, 0.0)), **ROLLING).temperature(**a).peak
        ),
        dict(bulk=(10.0, 20.0)),
    ),
    (
        "WheelPatch.temperature",
        lambda **a: wheels().step(velocity=20.0).patches[0].temperature(**a).peak,
        dict(bulk=(10.0, 20.0)),
    ),
    ("Rolling", mtb.Rolling, dict(creepage=(0.0, 0.0, 0.1), force=(1.0, None))),
    ("Scene", scene, dict(gap=BALL, spacing=(2e-3, 1e-3), force=100.0, moments=(1e-3, 0.0), friction=0.3)),
    ("Scene", scene, dict(approach=1e-5, velocity=3.0)),
    ("Scene", scene, dict(magnetic_pressure=np.full((13, 13), 1e6))),
    ("Scene", scene, dict(force=100.0, normal_layer=1e-12, hardness=1e9)),
    (
        "RoughLayer.exponential",
        mtb.RoughLayer.exponential,
        dict(contact_pressure=1e9, length=1e-6, height=1e-5, tangential_ratio=0.8),
    ),
    ("RoughLayer", mtb.RoughLayer, dict(gap=[2e-6, 1e-6], pressure=[0.0, 1e6], tangential_ratio=0.8)),
    (
        "RoughLayer.from_surface",
        partial(mtb.RoughLayer.from_surface, lower=mtb.steel, upper=mtb.steel),
        dict(
            heights=1e-6 * np.add.outer(np.cos(np.pi / 4 * np.arange(8)), np.sin(np.pi / 4 * np.arange(8))),
            spacing=1e-5,
            pressures=[1e6, 3e6],
            hardness=5e9,
        ),
    ),
    ("ThinLayer", mtb.ThinLayer, dict(thickness=1e-3, young_modulus=1e9, poisson_ratio=0.3)),
    ("block_on_plane", mtb.scenes.block_on_plane, dict(normal_layer=1e-12, hardness=1e9)),
    ("paraboloid_on_plane", mtb.scenes.paraboloid_on_plane, dict(hardness=1e9)),
    ("wheel_on_rail", mtb.scenes.wheel_on_rail, dict(hardness=1e9)),
    ("pole_shoe_on_rail", mtb.scenes.pole_shoe_on_rail, dict(normal_layer=1e-12, hardness=1e9)),
    ("Scene.with_", scene(force=1.0).with_, dict(force=3.0, friction=0.2)),
    ("Scene.with_", mtb.scenes.block_on_plane(**BLOCK).with_, dict(element_size=0.01, width=0.2)),
    ("Scene.expected_cost", mtb.scenes.paraboloid_on_plane(points=8).expected_cost, dict(tolerance=0.5)),
    (
        "Scene.solve",
        lambda **a: mtb.scenes.paraboloid_on_plane(points=18).solve(**a).pressure,
        dict(tolerance=0.5),
    ),
    (
        "Scene.prepare",
        lambda **a: of_step(
            mtb.scenes.paraboloid_on_plane(points=18).prepare("half-space", **a), velocity=1.0
        ),
        dict(reference_point=(0.0, 0.0, 0.1), standstill_speed=2.0, tolerance=0.9),
    ),
    (
        "Scene.start_of_sliding",
        lambda **a: mtb.scenes.paraboloid_on_plane(points=8).start_of_sliding(**a).force,
        dict(displacements=[(1e-5, 0.0)], tolerance=1e-8),
    ),
    (
        "Scene.chart",
        lambda **a: len(mtb.scenes.paraboloid_on_plane(points=8).chart(repeats=1, **a).points) > 0,
        dict(budget=0.3),
    ),
    ("Shift", mtb.Shift, dict(displacement=(1e-6, 0.0), spin=1e-3, duration=0.1)),
    ("Shift", mtb.Shift, dict(force=(1.0, None), rigid_slip=np.full((2, 3, 3), 1e-6))),
    ("Rolling", mtb.Rolling, dict(rigid_slip=np.full((2, 3, 3), 1e-3))),
    (
        "Rolling.along_arc",
        lambda **a: mtb.Rolling((0.0, 0.0, 0.3)).along_arc(
            mtb.PressureField(BALL, (1e-4, 1e-4), **STEELS), **a
        ),
        dict(roll=2.0, inclination=0.01 * np.arange(len(BALL))),
    ),
    ("StaticKinetic", mtb.StaticKinetic, dict(static=0.3, kinetic=0.3)),
    ("Support", lambda **a: mtb.Support("top", **a), dict(x=1e-3, y=0.0, z=1e-6)),
    ("Support", lambda **a: mtb.Support(name="box", **a), dict(where=((0.0, 0.1), (0.0, None), (0.0, 0.1)))),
    (
        "TabulatedFriction",
        mtb.TabulatedFriction,
        dict(slip_speed=[0.0, 1.0], coefficient=[0.3, 0.2], memory=1e-3, memory_min_slip=0.1),
    ),
    (
        "TemperatureFriction",
        mtb.TemperatureFriction,
        dict(
            temperature=[0.0, 400.0],
            coefficient=[0.3, 0.2],
            bulk=(20.0, 30.0),
            memory=1e-3,
            memory_min_slip=0.1,
        ),
    ),
    (
        "TangentialState",
        mtb.TangentialState,
        dict(
            traction=np.zeros((2, 4, 4)),
            pressure=np.full((4, 4), 1e6),
            coefficient=np.full((4, 4), 0.3),
            origin=(0.0, 1e-3),
            spacing=(1e-4, 1e-4),
            accumulated_plastic_slip=np.full((4, 4), 1e-6),
        ),
    ),
    (
        "TetraMesh",
        lambda nodes: mtb.TetraMesh(nodes, block_mesh(LINE, LINE, 0.01).cells).nodes,
        dict(nodes=block_mesh(LINE, LINE, 0.01).nodes),
    ),
    (
        "ElasticBody.from_mesh",
        lambda **a: mtb.ElasticBody.from_mesh(block_mesh(LINE, LINE, 0.01), mtb.steel, **a).mesh.nodes,
        dict(shift=(1.0, 2.0, 3.0)),
    ),
    (
        "TetraMesh.moved",
        lambda **a: block_mesh(LINE, LINE, 0.01).moved(np.eye(3), **a).nodes,
        dict(shift=(1.0, 2.0, 3.0)),
    ),
    ("VelocityTable", mtb.VelocityTable, dict(velocity=[0.0, 10.0], value=[0.3, 0.2])),
    ("VelocityTable.bracket", mtb.VelocityTable([0.0, 10.0], [0.3, 0.2]).bracket, dict(velocity=5.0)),
    (
        "area_load_curve",
        lambda **a: mtb.area_load_curve(lower=mtb.steel, upper=mtb.Rigid(), **a),
        dict(gap=ROUGH, spacing=1e-6, forces=[1e-6], tolerance=1e-6),
    ),
    (
        "creep_curve",
        lambda **a: mtb.creep_curve(**ROLLING, **a),
        dict(creepages=[(1e-3, 0.0, 0.1)], velocity=20.0, tolerance=1e-6),
    ),
    (
        "fastsim",
        lambda **a: mtb.fastsim(**ROLLING, **a).force,
        dict(
            creepage=(1e-3, 0.0, 0.1),
            velocity=20.0,
            semi_axes=(6e-4, 6e-4),
            slope_reduction=(0.5, 0.8, 0.1),
            angle=0.2,
            force=(2.0, 1.0),
        ),
    ),
    (
        "fastsim_curve",
        lambda **a: mtb.fastsim_curve(**ROLLING, **a),
        dict(
            creepages=[(1e-3, 0.0, 0.1)] * 3,
            velocity=20.0,
            semi_axes=(6e-4, 6e-4),
            slope_reduction=(0.5, 0.8, 0.1),
            angle=0.2,
        ),
    ),
    (
        "fastrip",
        lambda **a: mtb.fastrip(**ROLLING, **a).force,
        dict(
            creepage=(1e-3, 0.0, 0.1),
            semi_axes=(6e-4, 6e-4),
            slope_reduction=(0.5, 0.8, 0.1),
            angle=0.2,
            force=(2.0, 1.0),
        ),
    ),
    (
        "fastrip_curve",
        lambda **a: mtb.fastrip_curve(**ROLLING, **a),
        dict(
            creepages=[(1e-3, 0.0, 0.1)] * 3,
            semi_axes=(6e-4, 6e-4),
            slope_reduction=(0.5, 0.8, 0.1),
            angle=0.2,
        ),
    ),
    ("hertz", mtb.hertz, dict(force=1e3, radii=(0.1, 0.2))),
    ("hertz", lambda **a: mtb.hertz(1e3, **a), dict(semi_axes=(1e-3, 1e-3))),
    ("kalker_coefficients", mtb.kalker_coefficients, dict(ratio=1.5, poisson_ratio=0.25)),
    (
        "polach",
        lambda **a: mtb.polach(**ROLLING, **a),
        dict(creepage=(1e-3, 0.0, 0.1), reduction=(0.8, 0.5), velocity=20.0, semi_axes=(6e-4, 6e-4)),
    ),
    (
        "roughness",
        lambda **a: mtb.roughness(8, **a),
        dict(spacing=1e-6, hurst=0.7, rms_height=1e-7, longest=8e-6, roll_off=6e-6, shortest=3e-6),
    ),
    ("roughness", lambda **a: mtb.roughness(8, 1e-6, **a), dict(rms_slope=0.1)),
    (
        "solve_normal",
        lambda **a: mtb.solve_normal(**STEELS, **a).pressure,
        dict(gap=BALL, spacing=1e-3, force=100.0, tolerance=1e-8, moments_about_axes=(0.01, 0.0)),
    ),
    ("solve_normal", lambda **a: mtb.solve_normal(BALL, 1e-3, **STEELS, **a).pressure, dict(approach=1e-5)),
    (
        "solve_normal",
        lambda **a: mtb.solve_normal(BALL, 1e-3, **STEELS, force=1e3, **a).pressure,
        dict(normal_layer=1e-11, hardness=5e8, inclination=0.01 * np.arange(len(BALL))),
    ),
    (
        "solve_tangential",
        lambda **a: mtb.solve_tangential(motion=mtb.Rolling((1e-3, 0.0, 0.0)), **ROLLING, **a).force,
        SLOW,
    ),
    (
        "start_of_sliding",
        lambda **a: mtb.start_of_sliding(PAIR, **a).force,
        dict(
            pressure=np.full(4, 1e6),
            area=np.full(4, 1e-6),
            friction=0.3,
            displacements=[(1e-5, 0.0)],
            tolerance=1e-8,
        ),
    ),
    (
        "surface_gap",
        lambda **a: (
            mtb.surface_gap(mtb.BodySurface.rail(), mtb.BodySurface.paraboloid(-0.3), **a).facet_error
        ),
        dict(x=(-0.01, 0.01), y=(-0.01, 0.01), spacing=5e-3, reach=4e-3, approach=1e-4),
    ),
    (
        "sweep",
        lambda **a: mtb.sweep(mtb.scenes.paraboloid_on_plane(points=18), **a).parameters,
        dict(parameters={"force": [1e6, 2e6], "friction": [0.1]}),
    ),
    (
        "wheelset_geometry",
        lambda **a: mtb.wheelset_geometry(**a).radius_difference,
        dict(
            wheel_radius=0.47,
            gauge=1.436,
            rail_inclination=0.03,
            shifts=[-1e-3, 0.0, 2e-3],
            gauge_depth=13e-3,
            flange_back=1.361,
            tape_circle=69e-3,
        ),
    ),
    ("klingel_wavelength", mtb.klingel_wavelength, dict(conicity=0.1, wheel_radius=0.47, base=1.6)),
    (
        "equivalent_conicity",
        mtb.equivalent_conicity,
        dict(shift=[-4e-3, 0.0, 5e-3], radius_difference=[-3e-4, 0.0, 5e-4], amplitude=2e-3),
    ),
    (
        "Profile.smoothed",
        lambda **a: TABLE.smoothed(**a).height([0.0, 5e-3]),
        dict(wavelength=3e-3, kinks=[4e-3]),
    ),
    ("Profile.smoothed", lambda **a: TABLE.smoothed(**a).height([0.0, 5e-3]), dict(kink_angle=0.3)),
    (
        "wheel_on_rail_gap",
        lambda **a: mtb.wheel_on_rail_gap("S1002", "60E1", **a).gap,
        dict(
            wheel_radius=0.5,
            gauge=1.434,
            rail_inclination=0.03,
            lateral=5e-3,
            force=3e4,
            contact_modulus=1.1e11,
            spacing=1e-3,
            gauge_depth=0.015,
            flange_back=1.361,
            tape_circle=0.069,
            roller_radius=0.5,
        ),
    ),
    (
        "wheel_on_rail_gap",
        lambda **a: mtb.wheel_on_rail_gap("S1002", "60E1", spacing=1e-3, **a).gap,
        dict(approach=5e-5),
    ),
    (
        "block_on_plane",
        mtb.scenes.block_on_plane,
        dict(
            width=0.2,
            height=0.05,
            friction=0.2,
            magnetic_pressure=1e6,
            spacing=0.02,
            length=0.12,
            velocity=3.0,
        ),
    ),
    (
        "paraboloid_on_plane",
        mtb.scenes.paraboloid_on_plane,
        dict(radius=2.0, force=100.0, friction=0.2, width=0.01),
    ),
    (
        "pole_shoe_on_rail",
        mtb.scenes.pole_shoe_on_rail,
        dict(
            height=0.03,
            length=0.1,
            inner_edge=7e-3,
            outer_edge=0.035,
            conforming_to=0.02,
            relief_slope=0.03,
            friction=0.3,
            magnetic_pressure=(2e6, 3e6),
            velocity=3.0,
            spacing=5e-3,
            lateral=1e-3,
            yaw=1e-3,
            rail_length=0.2,
        ),
    ),
    (
        "wheel_on_rail",
        mtb.scenes.wheel_on_rail,
        dict(
            wheel_radius=0.5,
            gauge=1.434,
            rail_inclination=0.03,
            lateral=5e-3,
            force=3e4,
            spacing=1e-3,
            gauge_depth=0.015,
            flange_back=1.361,
            tape_circle=0.069,
            roller_radius=0.5,
            friction=0.3,
        ),
    ),
]


def quantity(value: Any, unit: Any) -> Any:
    """`value` as quantities in another unit than `unit`, part by part where parts differ."""
    if value is None:
        return None
    if isinstance(value, dict):
        return {k: quantity(v, ARGUMENT_UNITS[k]) for k, v in value.items()}
    if isinstance(unit, tuple):
        if not isinstance(value, (tuple, list)):
            return quantity(value, unit[0])
        is_row = not any(isinstance(part, (tuple, list)) for part in value)
        return [quantity(v, u) for v, u in zip(value, unit if is_row else [unit] * len(value), strict=True)]
    if isinstance(value, (tuple, list)) and any(v is None or isinstance(v, (tuple, list)) for v in value):
        return [quantity(v, unit) for v in value]
    unit = "1" if unit == "1 or Pa" else unit
    there = UNITS.Quantity(np.asarray(value, dtype=float), "" if unit == "1" else unit)
    return there.to(OTHERS[unit]) if there.ndim else UNITS.Quantity(float(value), unit).to(OTHERS[unit])


#: Units along x of what has those of its coordinates.
ALONG_X = {"mass": "kg", "stiffness": "N/m", "damping": "N s/m"}


def rolled() -> mtb.TangentialResult:
    return mtb.solve_tangential(field(), mtb.Rolling(creepage=(1e-3, 0.0, 0.0)), mtb.Coulomb(0.3))


def close(a: Any, b: Any) -> bool:
    """Whether two values are the same but for rounding."""
    if isinstance(a, (float, np.ndarray)):
        return bool(np.allclose(a, b, rtol=1e-6, atol=1e-9 * np.max(np.abs(a), initial=0.0), equal_nan=True))
    if isinstance(a, (tuple, list)):
        return len(a) == len(b) and all(close(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, dict):
        return list(a) == list(b) and all(close(a[k], b[k]) for k in a)
    if hasattr(a, "__dataclass_fields__"):
        names = [field.name for field in fields(a) if field.compare]
        return all(close(getattr(a, name), getattr(b, name)) for name in names)
    return same(a, b) or callable(a)


@pytest.mark.coarse
@pytest.mark.filterwarnings("ignore:StaticKinetic depends on the grid")
@pytest.mark.parametrize(("place", "call", "given"), CALLS, ids=[place for place, _, _ in CALLS])
def test_an_argument_with_a_unit_takes_quantities(
    place: str,
    call: Callable[..., Any],
    given: dict[str, Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    plain = call(**given)
    units = ARGUMENT_UNITS | EXCEPTIONS.get(place, {})
    # what has the units of the coordinates is given along x here
    units |= {name: along for name, along in ALONG_X.items() if units.get(name) == LATER}
    # one argument after the other, so that none hides behind another
    for name, value in given.items():
        assert close(plain, call(**given | {name: quantity(value, units.get(name))})), name
        candela: Any = UNITS.Quantity(1.0, "candela")
        wrong = {next(iter(value)): candela} if isinstance(value, dict) else candela
        with pytest.raises(ValueError, match=rf"^{name}.* is 1.0 candela: a quantity in .* is needed"):
            call(**given | {name: wrong})


#: Documented arguments that the calls leave out, with the reason.
LEFT_OUT = {
    ("Scene", "element_size"): "of ready scenes, and is tried by with_",
    ("ElasticBody.from_mesh", "size"): "needs gmsh, and is tried below",
    ("ElasticBody.recover", "force"): "between a solve and its pictures",
    ("ElasticBody.recover", "traction"): "between a solve and its pictures",
    ("animate", "frames_per_second"): "draws pictures, and is tried below",
    ("Stability.animate", "frames_per_second"): "draws pictures, as the other one does",
    ("Vibration.animate", "frames_per_second"): "as animate",
    ("Braking.animate", "frames_per_second"): "as animate",
    ("SlidingHeat.animate", "frames_per_second"): "as animate",
    ("solve_normal", "moments"): "an old name",
    ("PreparedWheels.step", "rails"): "by sides, and is tried below",
    ("PreparedWheels.step", "wheels"): "by sides, and is tried below",
    ("PreparedWheels.save_fmu", "rails"): "by sides, as of steps",
    ("PreparedWheels.save_fmu", "wheels"): "by sides, as of steps",
    ("step_wheels", "rails"): "by sides, as of steps",
    ("step_wheels", "wheels"): "by sides, as of steps",
}


def test_rails_and_wheels_beside_their_places_take_quantities() -> None:
    plain = [1e-5, 2e-5, 1e-4, 0.0, 1e-3, 1e-3]
    units = ["m", "m", "rad", "m/s", "m/s", "rad/s"]
    places = [(number * UNITS(unit)).to(OTHERS[unit]) for number, unit in zip(plain, units, strict=True)]
    found = of_step(wheels(), velocity=20.0, rails={"left": places})
    wanted = of_step(wheels(), velocity=20.0, rails={"left": plain})
    np.testing.assert_allclose(found[0], wanted[0], rtol=1e-9)
    nothing = of_step(wheels(), velocity=20.0)
    assert not np.allclose(wanted[0], nothing[0], rtol=1e-6)
    with pytest.raises(ValueError, match=r"^rails.* a quantity in rad"):
        wheels().step(velocity=20.0, rails={"left": [*plain[:2], 1.0 * UNITS.candela, *plain[3:]]})


def test_every_documented_argument_is_tried() -> None:
    tried = {(place, name) for place, _, given in CALLS for name in given}
    tried |= {(place.removeprefix("Wheel"), name) for place, name in tried}
    wanted = {(place, name) for place, made in public() for name, _ in documented(made)}
    inherited = {(place, name) for place, name in wanted if place.startswith("WheelScene")}
    # one method of many results
    stresses = {(place, name) for place, name in wanted if place.endswith(".stress")}
    inherited |= {(place, name) for place, name in stresses if place != "NormalResult.stress"}
    assert wanted - inherited - tried == set(LEFT_OUT)


@pytest.mark.parametrize(
    "call",
    [
        lambda wrong: mtb.ElasticBody.from_mesh("part.stl", mtb.steel, unit="m", contact="top", size=wrong),
        lambda wrong: mtb.animate([], "steps.gif", frames_per_second=wrong),
        lambda wrong: mtb.scenes.block_on_plane(0.1, wrong),
        lambda wrong: mtb.scenes.block_on_plane(magnetic_pressure={"left": wrong}),
        lambda wrong: mtb.scenes.pole_shoe_on_rail(magnetic_pressure=[1e6, wrong]),
        lambda wrong: mtb.Rolling((0.0, 0.0, wrong)),
        lambda wrong: prepared().step(pose=[wrong] * 6),
    ],
)
def test_a_quantity_of_another_dimension_is_refused_at_the_door(call: Callable[[Any], Any]) -> None:
    with pytest.raises(ValueError, match=r" is 1 kelvin: a quantity in .* is needed"):
        call(UNITS.Quantity(1, "kelvin"))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: prepared().step(pose=np.zeros(6) * UNITS.mm), "its entries have the units m, m, m, rad"),
        (lambda: mtb.scenes.block_on_plane(attraction=1 * UNITS.mm), "attraction is 1 millimeter: this arg"),
        (lambda: scene(force=1.0).with_(name=1 * UNITS.mm), "name is 1 millimeter: this argument has no"),
    ],
)
def test_a_quantity_in_a_wrong_place_is_refused(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()


class Length:
    """A length as of astropy or unyt, by what it can do."""

    def __init__(self, value: float, unit: str) -> None:
        self.value, self.unit = value, unit

    def to(self, unit: str) -> Length:
        if unit != "m":
            raise TypeError(unit)
        return Length(self.value * {"m": 1.0, "mm": 1e-3}[self.unit], unit)


def test_other_packages_of_units_are_taken_by_what_they_can_do() -> None:
    made = mtb.scenes.block_on_plane(width=Length(200.0, "mm"))
    assert made == mtb.scenes.block_on_plane(width=0.2)
    with pytest.raises(ValueError, match="magnetic_pressure"):
        mtb.scenes.block_on_plane(magnetic_pressure=Length(1.0, "mm"))


def test_the_stored_arguments_are_plain_numbers() -> None:
    given = {"height": 30 * UNITS.mm, "velocity": UNITS.Quantity(120, "km/h"), "yaw": 1 * UNITS.deg}
    made = mtb.scenes.pole_shoe_on_rail(**given)
    assert all(type(value) is float for value in made.recipe[1].values() if isinstance(value, float))
    assert pickle.loads(pickle.dumps(made)) == made
    assert made.inputs["velocity"] == pytest.approx(120 / 3.6)
    assert type(mtb.Material(210 * UNITS.GPa, 0.3).young_modulus) is float


def test_pint_reads_every_unit_of_results() -> None:
    table = mtb.sweep(mtb.scenes.paraboloid_on_plane(points=18), {"friction": [0.1, 0.2]})
    contact = mtb.scenes.wheel_on_rail(spacing=1e-3).prepare()
    assert isinstance(contact, mtb.PreparedWheels)
    patch = contact.step(velocity=(20.0, 0.0, 0.0, 0.0, 20.0 / 0.46, 0.0)).patches[0]
    shifted = mtb.solve_tangential(motion=mtb.Shift((1e-6, 0.0)), **ROLLING)
    known = [*FIELDS.values(), *TOTALS.values(), *patch.fields().values(), *shifted.fields().values()]
    for unit in {*(field.unit for field in known), *table.units.values()}:
        assert UNITS.parse_units(unit) is not None, unit
    assert set(table.columns) <= set(table.units)
    force = table["force_x"] * UNITS(table.units["force_x"])
    assert force.to("kN").magnitude == pytest.approx(table["force_x"] / 1e3)
    assert table["contact_area"][0] * UNITS(table.units["contact_area"]) > 0.0 * UNITS.m**2


def test_limits_of_a_picture_are_in_the_unit_of_what_is_drawn() -> None:
    pint = pytest.importorskip("pint")
    ureg = pint.UnitRegistry()
    found = mtb.hertz(1e3, 0.1).on_grid((12, 12), 2e-4)
    megapascals = (0.0 * ureg.MPa, 600.0 * ureg.MPa)
    drawn = found.plot("pressure", limits=megapascals).axes[0].collections[-1]
    plain = found.plot("pressure", limits=(0.0, 600e6)).axes[0].collections[-1]
    assert drawn.get_clim() == plain.get_clim()
    assert found.plot("gap", "line", limits=(0.0 * ureg.um, 5.0 * ureg.um)).axes[0].get_ylim()[1] == 5.0
    with pytest.raises(ValueError, match=r"limits\[0\] is 0.0 megapascal: a quantity in m"):
        found.plot("gap", limits=megapascals)


def test_an_array_of_a_wrong_dimension_is_refused_by_its_unit() -> None:
    pint = pytest.importorskip("pint")
    ureg = pint.UnitRegistry()
    with pytest.raises(
        ValueError, match=r"gap is an array of shape \(40, 40\) in megapascal: a quantity in m"
    ):
        mtb.solve_normal(np.ones((40, 40)) * ureg.MPa, 1e-3, lower=mtb.steel, upper=mtb.steel, force=1.0)


def test_functions_that_return_quantities_are_refused() -> None:
    """Their numbers would be taken for those of SI units, a millionth or a million times of what is meant."""
    pascal: Any = UNITS.Quantity(1.0, "MPa")
    shoe = mtb.scenes.pole_shoe_on_rail(friction=0.2, spacing=15e-3, poles=1, velocity=5.0)
    with pytest.raises(ValueError, match="without a unit, are needed"):
        mtb.wear(shoe, 0.1, lambda rubbing: 1e-7 / pascal)
    with pytest.raises(ValueError, match="without a unit, are needed"):
        shoe.with_(magnetic_pressure=lambda x, y: 2.0 * pascal).solve("half-space")


def test_vibrations_take_the_units_of_their_coordinates() -> None:
    length, turn = UNITS.Quantity(1.0, "mm"), UNITS.Quantity(1.0, "rad")
    second = UNITS.Quantity(1.0, "s")

    def moving(mass: Any) -> Any:
        block = mtb.scenes.block_on_plane(0.02, 0.02, 0.2, spacing=10e-3, velocity=1.0)
        contact = block.prepare("elastic-upper")
        given = {"stiffness": [1e7, 1e4], "damping": [10.0, 1.0], "free": ("x", "yaw")}
        return contact.vibrating(1e-5, mass=mass, **given)

    plain, other = moving([50.0, 0.05]), moving([50e3 * UNITS.gram, 500.0 * UNITS.gram * UNITS.meter**2 / 10])
    struck = plain.struck([1e-3, 2e-3]), other.struck([length / second, 2e-3 * turn / second])
    assert close(struck[0].rate, struck[1].rate)
    with pytest.raises(ValueError, match="mass"):
        moving([50.0, 0.05 * UNITS.kilogram])

# SPDX-License-Identifier: MIT OR Apache-2.0
"""Contact on a surface that is curved across its rows, against CONTACT and an own dense model."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

DATA = Path(__file__).parents[1] / "data" / "contact"
CASES = {case["name"]: case for case in json.loads((DATA / "conformal.json").read_text())["cases"]}
FIELDS = np.load(DATA / "conformal.npz")
BODY = mtb.Material.from_shear_modulus(82e9, 0.28)
MM, MPA = 1e-3, 1e6
FRICTION = mtb.Coulomb(0.3)


def groove(name: str, **given: Any) -> mtb.NormalResult:
    """A groove of CONTACT's runs: rail radius 10 mm, on which the surface falls to both sides."""
    grid = CASES[name]["grid"]
    rows = (grid["y0"] + grid["dy"] * np.arange(grid["ny"])) * MM
    inclination = None if "half_space" in name else -rows / (10.0 * MM)
    given = given or {"approach": CASES[name]["inputs"]["approach"] * MM}
    return mtb.solve_normal(
        FIELDS[f"{name}/gap"] * MM,
        grid["dx"] * MM,
        lower=BODY,
        upper=BODY,
        edge="sharp",
        tolerance=1e-9,
        inclination=inclination,
        **given,
    )


def lens(
    n: int = 48, radius: float = 0.1, turn: float = 0.0, force: float = 1e4, offset: float = 0.0, **given: Any
) -> mtb.NormalResult:
    """A contact that is nearly round, on rows inclined by up to `turn` to each side, and by `offset`."""
    side = 6e-3 / n
    x = (np.arange(n) - 0.5 * (n - 1)) * side
    gap = x**2 / (2 * radius) + x[:, None] ** 2 / (2 * radius)
    angles = turn * x / 3e-3 + offset if turn or offset else None
    return mtb.solve_normal(gap, side, lower=BODY, upper=BODY, force=force, inclination=angles, **given)


@pytest.mark.parametrize("name", ["groove_half_space", "groove_blanco_v1", "groove_blanco_v1_frictionless"])
def test_fields_of_contact(name: str) -> None:
    normal, case = groove(name), CASES[name]
    pressure = FIELDS[f"{name}/pn"] * MPA
    if case["inputs"]["creepages"] is None:
        assert np.abs(normal.pressure - pressure).max() < 5e-5 * pressure.max()
        assert normal.normal_force == pytest.approx(case["sums"]["pn"], rel=1e-6)
        return
    rolling = mtb.Rolling((0.001, 0.0, 0.0))
    found = mtb.solve_tangential(normal, rolling, FRICTION, coupling="full")
    assert np.abs(found.pressure - pressure).max() < 5e-5 * pressure.max()
    for own, component in zip(found.traction, ("px", "py"), strict=False):
        theirs = FIELDS[f"{name}/{component}"] * MPA
        assert np.abs(own - theirs).max() < 5e-5 * 0.3 * pressure.max()
    assert np.array_equal(found.status, FIELDS[f"{name}/status"])
    assert -found.force[2] == pytest.approx(case["sums"]["pn"], rel=1e-5)
    assert found.force[0] == pytest.approx(case["sums"]["px"], rel=1e-5)


#: CONTACT's conformal example: a wheel's root of 10.2 mm on a gauge corner of 10 mm, at 45 degrees, with the
#: half-space: normal force, creep forces and moment [N, N m] on the wheel, peak. The first has parabolas, the
#: others the gap of two circles that approach each other along the middle normal; the slip of the last one is
#: that of a wheel with a yaw of -14 mrad whose axis of spin leans with the surface.
PRINTED = {
    "parabolas": (100_000, 9144, 25_920, 38.60, 912.8e6),
    "true gap": (91_840, 8959, 24_170, 26.76, 1012e6),
    "true gap, varying slip": (91_840, 10_500, 22_510, 32.27, 1012e6),
}


@pytest.mark.parametrize("name", sorted(PRINTED))
def test_printed_forces_of_a_flange_root(name: str) -> None:
    corner, root, wheel, side, approach = 10e-3, 10.2e-3, 0.46, 0.4e-3, 0.09089e-3
    x, s = ((np.arange(n) - 0.5 * (n - 1)) * side for n in (51, 39))
    angle, offset = s / corner, root - corner
    across = 0.5 * s**2 * (1.0 / corner - 1.0 / root)
    if "true" in name:
        apart = np.sqrt(root**2 - (offset * np.sin(angle)) ** 2) - offset * np.cos(angle) - corner
        across = apart + approach * (1.0 - np.cos(angle))
    gap = across[:, None] + x**2 * np.cos(0.25 * np.pi) / (2.0 * wheel)
    normal = mtb.solve_normal(gap, side, lower=BODY, upper=BODY, approach=approach, tolerance=1e-9)
    motion = mtb.Rolling((-4e-3, -9.8995e-3, -1.5372))
    if "varying" in name:
        # the arc between both circles, which is steeper where s is smaller
        bend = 0.5 * (1.0 / corner + 1.0 / root)
        lean = 0.25 * np.pi - bend * s
        along = -4e-3 + (np.cos(lean) - np.cos(0.25 * np.pi)) / (bend * wheel)
        slip = np.stack(
            [
                np.repeat(along[:, None], 51, axis=1),
                -0.014 * np.cos(lean)[:, None] - np.outer(np.sin(lean), x) / wheel,
            ]
        )
        motion = mtb.Rolling(rigid_slip=slip)
    found = mtb.solve_tangential(normal, motion, FRICTION)
    turning = normal.points[0] * found.traction[1] - normal.points[1] * found.traction[0]
    # CONTACT's tractions are those on the wheel
    on_wheel = -np.array([*found.force[:2], turning.sum() * side**2])
    own = (normal.normal_force, *on_wheel, normal.pressure.max())
    assert own == pytest.approx(PRINTED[name], rel=3e-3)


def dense(nx: int, ny: int, side: float) -> dict[str, np.ndarray]:
    """Influence of squares on the surface of two half-spaces, from its potentials, as full matrices."""
    half = 0.5 * side
    x, y = np.meshgrid(np.arange(1 - nx, nx) * side, np.arange(1 - ny, ny) * side)

    def corners(potential: Any) -> np.ndarray:
        ends = [(a, b, a * b) for a in (1, -1) for b in (1, -1)]
        return np.asarray(sum(s * potential(x + a * half, y + b * half) for a, b, s in ends))

    def first(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        r = np.hypot(x, y)
        return np.asarray(y * np.log(x + r) + x * np.log(y + r))

    inverse = corners(first)
    along = corners(lambda x, y: y * np.log(x + np.hypot(x, y)))
    across = corners(lambda x, y: x * np.log(y + np.hypot(x, y)))
    mixed = -corners(np.hypot)
    k, nu = 1.0 / (np.pi * BODY.shear_modulus), BODY.poisson_ratio
    own = np.arange(nx * ny)
    place = (own // nx)[:, None] - own // nx + ny - 1, (own % nx)[:, None] - own % nx + nx - 1
    return {
        "zz": k * (1 - nu) * inverse[place],
        "xx": k * ((1 - nu) * inverse + nu * along)[place],
        "yy": k * ((1 - nu) * inverse + nu * across)[place],
        "xy": k * nu * mixed[place],
    }


@pytest.mark.parametrize("method", ["dense", "fft"])
def test_gap_of_an_own_dense_model(method: Any) -> None:
    found = lens(17, turn=0.7, method=method, offset=0.2)
    assert found.inclination is not None
    matrix = dense(17, 17, found.spacing[0])["zz"]
    angles = np.repeat(found.inclination, 17)
    moved = (np.cos(angles[:, None] - angles) * matrix) @ found.pressure.ravel()
    gap = found.initial_gap.ravel() - found.approach + moved
    assert np.abs(gap - found.gap.ravel()).max() < 1e-9 * moved.max()
    assert np.abs(gap[found.pressure.ravel() > 0.0]).max() < 1e-6 * moved.max()


@pytest.mark.parametrize("kind", ["steady", "shift", "transient", "backwards"])
def test_slip_of_an_own_dense_model(kind: str) -> None:
    """In contact, displacements by all tractions and pressures and the rigid slip make up the slip."""
    n = 16
    normal = lens(n, turn=0.6, tolerance=1e-10)
    assert normal.inclination is not None
    angles = np.repeat(normal.inclination, n)
    matrix, side = dense(n, n, normal.spacing[0]), normal.spacing[0]
    turn = angles[:, None] - angles
    cosine, sine = np.cos(turn), np.sin(turn)

    def displacement(traction: np.ndarray) -> np.ndarray:
        q, r, p = traction[0].ravel(), traction[1].ravel(), normal.pressure.ravel()
        along = matrix["xx"] @ q + (cosine * matrix["xy"]) @ r - (sine * matrix["xy"]) @ p
        across = matrix["xy"] @ q + (cosine * matrix["yy"]) @ r - (sine * matrix["yy"]) @ p
        return np.stack([along, across]).reshape(2, n, n)

    motions = {
        "steady": mtb.Rolling((8e-4, 3e-4, 0.0)),
        "backwards": mtb.Rolling((8e-4, 3e-4, 0.0), angle=np.pi),
        "shift": mtb.Shift((4e-6, 2e-6)),
        "transient": mtb.Rolling((8e-4, 3e-4, 0.0), transient=True),
    }
    motion = motions[kind]
    found = mtb.solve_tangential(normal, motion, FRICTION, tolerance=1e-10)
    moved = displacement(found.traction)
    given = np.array(motion.rigid[:2])[:, None, None]
    if kind == "shift":
        slip, inside = given - moved, slice(None)
    elif kind == "backwards":
        slip = given[:, :, 1:] if given.shape[2] > 1 else given
        slip, inside = slip - (moved[:, :, 1:] - moved[:, :, :-1]) / side, slice(1, None)
    else:
        before = moved if kind == "steady" else displacement(np.zeros((2, n, n))) * 0.0
        slip = given - (moved[:, :, :-1] - before[:, :, 1:]) / side
        inside = slice(None, -1)
    touches = (normal.pressure > 0.0)[None]
    wrong = np.where(touches, 1.0, 0.0)[..., inside] * (slip - found.slip[..., inside])
    assert np.any(found.status == 1)
    assert np.any(found.status == 2)
    assert np.abs(wrong).max() < 1e-6 * np.abs(found.slip).max()


def test_gap_follows_the_traction() -> None:
    normal = lens(24, turn=0.6, tolerance=1e-9)
    assert normal.inclination is not None
    found = mtb.solve_tangential(normal, mtb.Rolling((0.0, 4e-3, 0.0)), FRICTION, coupling="full")
    turn = np.subtract.outer(*[np.repeat(normal.inclination, 24)] * 2)
    matrix = dense(24, 24, normal.spacing[0])["zz"]
    moved = (np.cos(turn) * matrix) @ found.pressure.ravel() + (np.sin(turn) * matrix) @ found.traction[
        1
    ].ravel()
    gap = normal.initial_gap.ravel() + moved
    touches = found.pressure.ravel() > 0.0
    assert np.ptp(gap[touches]) < 1e-5 * moved.max()
    # what the traction does is no small thing there
    alone = mtb.solve_tangential(normal, mtb.Rolling((0.0, 4e-3, 0.0)), FRICTION)
    assert np.abs(found.pressure - alone.pressure).max() > 0.05 * alone.pressure.max()
    assert alone.report.omitted["gap_change_by_traction_m"] > 0.0


@pytest.mark.parametrize("method", ["dense", "fft"])
def test_rows_of_one_angle_are_a_plane(method: Any) -> None:
    plane, turned = (
        lens(16, method=method, tolerance=1e-10),
        lens(16, method=method, offset=0.7, tolerance=1e-10),
    )
    assert np.abs(plane.pressure - turned.pressure).max() < 1e-8 * plane.pressure.max()
    rolling = mtb.Rolling((5e-4, -4e-4, 0.3))
    found = [mtb.solve_tangential(normal, rolling, FRICTION, coupling="full") for normal in (plane, turned)]
    assert np.abs(found[0].traction - found[1].traction).max() < 1e-6 * plane.pressure.max()
    assert turned.resultant == pytest.approx(1e4 * np.array([0.0, np.sin(0.7), -np.cos(0.7)]), rel=1e-8)


def test_seen_in_a_mirror_it_is_the_same() -> None:
    there = lens(24, turn=0.5, offset=0.1, tolerance=1e-10)
    assert there.inclination is not None
    here = mtb.solve_normal(
        there.initial_gap[::-1],
        there.spacing,
        lower=BODY,
        upper=BODY,
        force=1e4,
        tolerance=1e-10,
        inclination=-there.inclination[::-1],
    )
    assert np.abs(there.pressure[::-1] - here.pressure).max() < 1e-6 * here.pressure.max()
    found = mtb.solve_tangential(there, mtb.Rolling((6e-4, 5e-4, 0.4)), FRICTION, coupling="full")
    mirrored = mtb.solve_tangential(here, mtb.Rolling((6e-4, -5e-4, -0.4)), FRICTION, coupling="full")
    assert np.abs(found.traction[0][::-1] - mirrored.traction[0]).max() < 1e-5 * here.pressure.max()
    assert np.abs(found.traction[1][::-1] + mirrored.traction[1]).max() < 1e-5 * here.pressure.max()
    assert found.friction_power == pytest.approx(mirrored.friction_power, rel=1e-6)


def test_peak_settles_with_the_grid() -> None:
    """Errors of force and peak at a given approach fall with an order of at least one."""
    gap = {}
    for n in (12, 24, 48, 96):
        side = 6e-3 / n
        x = (np.arange(n) - 0.5 * (n - 1)) * side
        heights = x**2 / 0.2 + x[:, None] ** 2 / 0.2
        found = mtb.solve_normal(
            heights, side, lower=BODY, upper=BODY, approach=2e-5, inclination=-x / 4e-3, tolerance=1e-9
        )
        gap[n] = found.normal_force
    errors = [abs(gap[n] / gap[96] - 1.0) for n in (12, 24, 48)]
    assert all(fine < 0.6 * rough for rough, fine in pairwise(errors))


def test_rigid_slip_is_what_spin_is() -> None:
    """Spin and creepage given as a field of slip do what they do as numbers, heat as well."""
    normal = lens(20, turn=0.0)
    x, y = normal.points[:2]
    for kind in ("steady", "transient", "shift"):
        spin, ahead = 0.5, 0.0 if kind == "shift" else normal.spacing[0] / 6.0
        given = np.stack([4e-4 - spin * y, -2e-4 + spin * (x + ahead)])
        if kind == "shift":
            plain: Any = mtb.Shift((4e-6, -2e-6), spin=5e-3)
            field: Any = mtb.Shift(rigid_slip=1e-2 * given)
        else:
            asked = {"transient": kind == "transient"}
            plain = mtb.Rolling((4e-4, -2e-4, spin), **asked)
            field = mtb.Rolling(rigid_slip=given, **asked)
        one, other = (mtb.solve_tangential(normal, motion, FRICTION) for motion in (plain, field))
        assert np.abs(one.traction - other.traction).max() < 1e-7 * normal.pressure.max()
        # the slip one step behind the last row lies beyond the field
        assert one.friction_power == pytest.approx(
            other.friction_power, rel=2e-2 if kind != "shift" else 1e-6
        )


def test_derivatives_beside_a_rigid_slip() -> None:
    normal = lens(16, turn=0.0)
    bent = 2e-4 * np.stack([normal.points[1], normal.points[0]]) / 3e-3

    def solved(xi: float) -> mtb.TangentialResult:
        return mtb.solve_tangential(
            normal, mtb.Rolling((xi, 2e-4, 0.0), rigid_slip=bent), FRICTION, tolerance=1e-11
        )

    slope = solved(5e-4).derivative("force", by="creepage")[0, 0]
    difference = (solved(5e-4 + 1e-8).force[0] - solved(5e-4 - 1e-8).force[0]) / 2e-8
    assert slope == pytest.approx(difference, rel=1e-4)


def test_spin_along_an_arc() -> None:
    """A wheel that rolls freely: its slip is that of a cone whose radius follows the arc."""
    normal = lens(24, turn=0.4)
    assert normal.inclination is not None
    radius, tilt = 0.46, 0.6
    roll, spin = np.cos(tilt) / radius, np.sin(tilt) / radius
    motion = mtb.Rolling((0.0, 0.0, spin)).along_arc(normal, roll)
    assert motion.rigid_slip is not None
    x, y = normal.points[:2]
    whole = -spin * y + motion.rigid_slip[0]
    slope = np.diff(whole, axis=0) / normal.spacing[1]
    middle = 0.5 * (normal.inclination[1:] + normal.inclination[:-1])
    assert slope == pytest.approx(np.repeat(-np.sin(tilt - middle)[:, None] / radius, 24, axis=1), rel=5e-4)
    across = spin * (x + normal.spacing[0] / 6.0) + motion.rigid_slip[1]
    own = np.sin(tilt - normal.inclination)[:, None] / radius
    assert across == pytest.approx(own * (x + normal.spacing[0] / 6.0), rel=1e-9)
    # lateral creepage is seen by its component along the surface
    lateral = mtb.Rolling((0.0, 1e-3, 0.0)).along_arc(normal).rigid_slip
    assert lateral is not None
    assert lateral[1][:, 0] + 1e-3 == pytest.approx(1e-3 * np.cos(normal.inclination))


def test_kept_and_read_again(tmp_path: Path) -> None:
    normal = lens(16, turn=0.3)
    motion = mtb.Rolling((5e-4, 0.0, 0.1)).along_arc(normal, 2.0)
    found = mtb.solve_tangential(normal, motion, FRICTION, coupling="full")
    for result in (normal, found):
        result.save(tmp_path / "kept.npz")
        assert mtb.load(tmp_path / "kept.npz") == result
        out = result.fields()["normal"].values
        pressed = -(out * result.pressure * result.area).sum(axis=(1, 2))
        assert np.allclose(pressed[1:], replace(normal, pressure=result.pressure).resultant[1:], rtol=1e-12)


def curved() -> mtb.NormalResult:
    return lens(16, turn=0.3)


def refusals() -> dict[str, tuple[Any, str]]:
    flat = np.zeros((8, 8)) + (np.arange(8) - 3.5) ** 2 * 1e-7
    angles = np.linspace(-0.2, 0.2, 8)

    def normal(**given: Any) -> Any:
        return mtb.solve_normal(
            flat,
            1e-4,
            **{"lower": BODY, "upper": BODY, "force": 10.0, "edge": "sharp", "inclination": angles} | given,
        )

    other = mtb.Material(70e9, 0.33)
    return {
        "number of rows": (
            lambda: normal(inclination=angles[1:]),
            r"inclination has shape \(7,\): one angle",
        ),
        "nan": (lambda: normal(inclination=angles * np.nan), r"inclination"),
        "a circle": (lambda: normal(inclination=10 * angles), r"from -2 to 2 rad: less than half a turn"),
        "unlike": (lambda: normal(upper=other), r"two half-spaces of the same material"),
        "rigid": (lambda: normal(upper=mtb.Rigid()), r"two half-spaces of the same material"),
        "periodic": (lambda: normal(periodic=True), r"inclination is given, and periodic as well"),
        "growing": (lambda: normal(edge="grow"), r"inclination is given, and edge=\"grow\""),
        "tilting": (lambda: normal(moments_about_axes=(0.0, None)), r"and moments_about_axes as well"),
        "quick": (lambda: normal(method="kpec"), r"and method=\"kpec\" as well"),
        "stress": (lambda: curved().stress(), r"stresses are known below plane surfaces"),
        "across": (
            lambda: mtb.solve_tangential(curved(), mtb.Rolling((1e-3, 0, 0), angle=1.0), FRICTION),
            r"angle is 1 rad: rolling along the rows",
        ),
        "shape of slip": (
            lambda: mtb.solve_tangential(curved(), mtb.Rolling(rigid_slip=np.zeros((2, 3, 3))), FRICTION),
            r"rigid_slip has shape \(2, 3, 3\): \(2, 16, 16\) is needed",
        ),
        "components of slip": (lambda: mtb.Shift(rigid_slip=np.zeros((3, 3))), r"\(2, ny, nx\) is needed"),
        "no arc": (lambda: mtb.Rolling().along_arc(lens(16, turn=0.0).pressure), r"normal is a ndarray"),
        "derivative by the direction": (
            lambda: mtb.solve_tangential(curved(), mtb.Rolling((1e-3, 0, 0)), FRICTION).derivative(
                "force", by="angle"
            ),
            r"by is 'angle': the surface is inclined",
        ),
    }


@pytest.mark.parametrize("what", sorted(refusals()))
def test_refused_by_name(what: str) -> None:
    call, message = refusals()[what]
    with pytest.raises(ValueError, match=message):
        call()


@pytest.mark.filterwarnings("ignore:the surface turns by")
def test_no_stress_is_told_below_rows_that_are_turned() -> None:
    cell = 0.4e-3
    x, s = cell * (np.arange(25) - 12.0), cell * (np.arange(21) - 10.0)
    gap = x**2 / 0.92 + (s**2 / 2.0 * (1.0 / 10e-3 - 1.0 / 10.2e-3))[:, None]
    bodies = {"lower": mtb.steel, "upper": mtb.steel}
    pressed = mtb.solve_normal(gap, cell, **bodies, force=1e3, inclination=-s / 10e-3, edge="sharp")
    shifted = mtb.solve_tangential(pressed, mtb.Shift((1e-6, 0.0)), mtb.Coulomb(0.3))
    quick = mtb.fastsim(pressed, (1e-3, 0.0, 0.0), mtb.Coulomb(0.3))
    for result in (pressed, shifted, quick):
        with pytest.raises(ValueError, match="below plane surfaces only"):
            result.stress()

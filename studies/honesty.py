# SPDX-License-Identifier: MIT OR Apache-2.0
"""Is the error estimate of ``model="auto"`` honest, and its choice thrifty? Over a family of scenes.

Each scene is solved by "auto" and, as the truth, by the fullest model on cells two to four times as fine,
on meshes made by gmsh, which share nothing with those that they judge (`studies/other_meshes.py`). The true
error is that of the pressure, away from border points, as averages over the points of the result. The
estimate is honest where the truth is within twice of it, and where it keeps the tolerance if it says so;
the choice is thrifty where no model that meets the tolerance at this spacing does with less than a third of
its operations. Run from the root of the project: ``python studies/honesty.py``; it takes four minutes of
processor time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from atlas import panels, write
from matplotlib.figure import Figure
from other_meshes import truths

import mtb_rs as mtb
from mtb_rs.geometry.contact_points import spacing_pair
from mtb_rs.studies.chart_scene import fields_of

TOLERANCE = 0.05

steel = mtb.steel
aluminium = mtb.Material(young_modulus=70e9, poisson_ratio=0.33)
polymer = mtb.Material(young_modulus=3e9, poisson_ratio=0.38)
rubber = mtb.Material(young_modulus=5e6, poisson_ratio=0.49)
carbide = mtb.Material(young_modulus=600e9, poisson_ratio=0.2)


@dataclass(frozen=True)
class Member:
    """One scene of the family, at its own spacing and finer.

    Attributes
    ----------
    name : str
    at : callable
        The scene with its spacing divided by a whole number.
    finer : int
        That number for the truth.
    tolerance : float [-]
    """

    name: str
    at: Callable[[int], mtb.Scene]
    finer: int = 2
    tolerance: float = TOLERANCE


@dataclass(frozen=True)
class Finding:
    """What a member of the family showed.

    Attributes
    ----------
    points : int
    model : str
        The chosen one.
    estimate, truth : float [-]
        Relative error of the result.
    cost : float [-]
        Its operations over those of the cheapest model that meets the tolerance; of the fullest one if none
        does.
    overhead : float [-]
        Operations of choice and estimate over those of the fullest model at this spacing.
    """

    member: Member
    points: int
    model: str
    estimate: float
    truth: float
    cost: float
    overhead: float

    @property
    def is_honest(self) -> bool:
        """Whether the truth is within twice the estimate."""
        return self.truth <= 2.0 * self.estimate

    @property
    def keeps_its_word(self) -> bool:
        """Whether the truth is within the tolerance, where the estimate is."""
        return self.estimate > self.member.tolerance or self.truth <= self.member.tolerance

    @property
    def is_thrifty(self) -> bool:
        """Whether no model that meets the tolerance is cheaper by more than a factor 3."""
        return self.cost <= 3.0


def block(finer: int = 3, tolerance: float = TOLERANCE, cells: int = 10, **options: Any) -> Member:
    """A block whose width is cut into `cells`."""
    width = options.get("width", 0.1)

    def at(times: int) -> mtb.Scene:
        return mtb.scenes.block_on_plane(spacing=width / cells / times, **options)

    return Member(f"block, {words(options)}{cells} cells", at, finer, tolerance)


def shoe(finer: int = 3, tolerance: float = TOLERANCE, spacing: float = 6e-3, **options: Any) -> Member:
    """A pole shoe."""

    def at(times: int) -> mtb.Scene:
        return mtb.scenes.pole_shoe_on_rail(spacing=spacing / times, **options)

    return Member(f"shoe, {words(options)}{1e3 * spacing:g} mm", at, finer, tolerance)


def paraboloid(points: int, finer: int = 4, tolerance: float = TOLERANCE, **options: Any) -> Member:
    """A paraboloid on `points` along each side."""

    def at(times: int) -> mtb.Scene:
        return mtb.scenes.paraboloid_on_plane(points=(points - 1) * times + 1, **options)

    return Member(f"paraboloid, {words(options)}{points} points", at, finer, tolerance)


def wheel(spacing: float, finer: int = 4, tolerance: float = TOLERANCE, **options: Any) -> Member:
    """A wheel on a rail."""

    def at(times: int) -> mtb.Scene:
        return mtb.scenes.wheel_on_rail(spacing=spacing / times, **options)

    return Member(f"wheel, {words(options)}{1e3 * spacing:g} mm", at, finer, tolerance)


def field(
    name: str,
    gap: Callable[[np.ndarray, np.ndarray], np.ndarray],
    cells: int,
    finer: int = 4,
    tolerance: float = TOLERANCE,
    **options: Any,
) -> Member:
    """A gap of x and y in -1 .. 1, 10 mm wide."""

    def at(times: int) -> mtb.Scene:
        n = cells * times
        line = (np.arange(n) - 0.5 * (n - 1)) * 2.0 / n
        heights = gap(line[None, :], line[:, None])
        return mtb.Scene(**{"upper": steel, "lower": steel, "gap": heights, "spacing": 10e-3 / n, **options})

    return Member(f"{name}, {words(options)}{cells} cells", at, finer, tolerance)


def words(options: dict[str, Any]) -> str:
    """Arguments in short."""
    names = {
        id(aluminium): "aluminium",
        id(polymer): "polymer",
        id(rubber): "rubber",
        id(carbide): "carbide",
        id(steel): "steel",
    }
    parts = []
    for key, value in options.items():
        short = names.get(id(value)) or ("rigid" if isinstance(value, mtb.Rigid) else None)
        short = "yes" if isinstance(value, mtb.InterfaceLayer) else short
        parts.append(
            f"{key.replace('_', ' ')} {short or (f'{value:g}' if isinstance(value, float) else value)}"
        )
    return "".join(f"{p}, " for p in parts)


layer = mtb.InterfaceLayer(thickness=0.1e-3, shear_modulus=1e9)

FAMILY: tuple[Member, ...] = (
    block(friction=0.0),
    block(friction=0.2),
    block(friction=0.5),
    block(2, friction=0.5, cells=16),
    block(friction=0.8),
    block(friction=0.5, height=0.03),
    block(friction=0.5, height=0.05, cells=8),
    block(friction=0.2, height=0.25, cells=8),
    block(friction=0.3, sliding_direction=(1.0, 0.7)),
    block(friction=0.3, width=0.05, length=0.1, height=0.05, cells=8),
    block(friction=0.4, lower=mtb.Rigid(), cells=8),
    block(friction=0.4, upper=aluminium),
    block(friction=0.4, upper=polymer, height=0.05),
    block(friction=0.3, lower=polymer),
    block(friction=0.2, lower=rubber, supports="driven-top", magnetic_pressure=3e3),
    block(friction=0.0, lower=rubber, supports="driven-top", magnetic_pressure=3e3),
    block(friction=0.2, supports="driven-top"),
    block(friction=0.5, supports="driven-top", height=0.03, attraction="both"),
    block(friction=0.5, upper=mtb.Rigid(), cells=16, finer=4),
    block(friction=0.0, cells=12, tolerance=0.3, supports="driven-top"),
    # tall and narrow: held by a few points of the copies they are judged by
    block(friction=0.3, width=0.05, length=0.08, cells=6),
    block(friction=0.3, width=0.08, length=0.05, cells=9, sliding_direction=(0.0, 1.0)),
    block(friction=0.15, width=0.06, height=0.2, cells=9),
    block(friction=0.5, cells=6, tolerance=0.1),
    shoe(friction=0.5),
    shoe(friction=0.0),
    shoe(friction=0.5, spacing=4e-3, finer=2),
    shoe(friction=0.2, poles=1, tolerance=0.2, spacing=4.5e-3, finer=2),
    shoe(friction=0.3, height=20e-3),
    shoe(friction=0.3, height=45e-3, tolerance=0.1),
    shoe(friction=0.5, lower=carbide, tolerance=0.1),
    shoe(friction=0.5, lower=aluminium, tolerance=0.2),
    shoe(friction=0.3, supports="clamped-top", spacing=4.5e-3),
    shoe(friction=0.3, lateral=0.2e-3, yaw=1e-3, tolerance=0.1),
    shoe(friction=0.3, length=60e-3, outer_edge=30e-3, layer=layer, tolerance=0.1),
    shoe(friction=0.3, relief_slope=0.05, conforming_to=18e-3, tolerance=0.15),
    shoe(friction=0.4, spacing=4.5e-3, attraction="both", tolerance=0.15),
    paraboloid(12, friction=0.0),
    paraboloid(20, friction=0.5),
    paraboloid(34, friction=0.5),
    paraboloid(60, friction=0.5, finer=2),
    paraboloid(20, friction=0.5, lower=carbide, finer=3),
    paraboloid(24, friction=0.8, upper=rubber, lower=mtb.Rigid(), finer=3),
    paraboloid(48, friction=0.3, lower=polymer, finer=2, tolerance=0.02),
    wheel(4e-4),
    wheel(2e-4, lateral=0.0, force=80e3),
    wheel(2e-4, lateral=3e-3),
    wheel(1e-4, tolerance=0.01),
    field("ellipsoid", lambda x, y: 1e-5 * (x**2 + 4.0 * y**2), 20, force=3e3, friction=0.3),
    field("ellipsoid", lambda x, y: 1e-5 * (x**2 + 4.0 * y**2), 40, approach=3e-6, friction=0.3),
    field("slope", lambda x, y: 1e-5 * (np.abs(x) + 0.5 * y**2), 24, force=2e3, friction=0.2),
    field("cone", lambda x, y: 1e-5 * np.hypot(x, y), 24, force=1e3, friction=0.3),
    field("ring", lambda x, y: 3e-5 * (np.hypot(x, y) - 0.6) ** 2, 32, force=1e3, friction=0.5),
    field(
        "ring",
        lambda x, y: 3e-5 * (np.hypot(x, y) - 0.6) ** 2,
        64,
        force=1e3,
        friction=0.5,
        lower=mtb.Rigid(),
    ),
    field("step", lambda x, y: 1e-5 * (x * x + y * y) + 2e-7 * (x > 0.15), 32, force=1e3, friction=0.5),
    field("blunt", lambda x, y: 1e-5 * (x * x + y * y) ** 4, 24, force=2e3, friction=0.2),
    field(
        "bumps",
        lambda x, y: 1e-5 * (x**2 + y**2 + 0.1 * np.cos(9.0 * x) * np.cos(9.0 * y)),
        32,
        force=2e3,
        friction=0.4,
        lower=aluminium,
    ),
)


def examine(member: Member) -> Finding:
    """Solves a member by "auto", by all its models, and finely by the fullest one."""
    scene, fine = member.at(1), member.at(member.finer)
    models = scene.models
    with truths():
        exact = fields_of(fine, fine.solve(models[-1]), spacing_pair(fine.spacing))

    def error(result: mtb.Result) -> float:
        own = fields_of(scene, result, spacing_pair(scene.spacing))
        return own.errors(exact, scene.geometry.is_body_edge)["pressure"]

    def cost(result: mtb.Result) -> float:
        return result.report.operations["condensation"] + result.report.operations["solution"]

    found = scene.solve(tolerance=member.tolerance)
    others = [scene.solve(model) for model in models]
    enough = [cost(r) for r in others if error(r) <= member.tolerance]
    assert found.error_estimate is not None
    return Finding(
        member,
        found.pressure.size,
        found.model,
        found.error_estimate,
        error(found),
        cost(found) / min(enough, default=cost(others[-1])),
        found.report.operations["choice and estimate"] / cost(others[-1]),
    )


def draw(findings: list[Finding]) -> Figure:
    """Estimate against truth."""
    figure, (axes,) = panels(1, height=5.6)
    limits = np.array([2e-3, 5.0])
    axes.fill_between(
        limits, limits[0], 2.0 * limits, color="#DDEEF7", lw=0, label="within twice the estimate"
    )
    axes.plot(limits, limits, color="0.5", lw=1, label="estimate = truth")
    kinds = {"block": "s", "shoe": "^", "paraboloid": "o", "wheel": "D"}
    colours = dict(
        zip(("half-space", "elastic-upper", "elastic-both"), ("#0072B2", "#E69F00", "#009E73"), strict=True)
    )
    seen: set[str] = set()
    for f in findings:
        kind = f.member.name.split(",")[0]
        kind = kind if kind in kinds else "gap field"
        axes.plot(
            f.estimate,
            f.truth,
            kinds.get(kind, "v"),
            color=colours[f.model],
            ms=6,
            mec="black",
            mew=0.4,
            label=None if kind in seen else kind,
        )
        seen.add(kind)
    for model, colour in colours.items():
        axes.plot([], [], "o", color=colour, label=f"chosen: {model}")
    axes.set(xscale="log", yscale="log", xlim=limits, ylim=limits, aspect="equal")
    axes.set(xlabel="estimated error of the pressure", ylabel="true error of the pressure")
    axes.set_title(f'{len(findings)} scenes solved by model="auto"', fontsize=10)
    axes.legend(fontsize=8, frameon=False, loc="upper left")
    return figure


if __name__ == "__main__":
    findings = []
    for member in FAMILY:
        findings.append(examine(member))
        f = findings[-1]
        print(f"{member.name}: estimate {f.estimate:.3f}, truth {f.truth:.3f}, {f.model}", flush=True)
    rows = [
        {
            "scene": f.member.name,
            "points": f.points,
            "tolerance": f.member.tolerance,
            "model": f.model,
            "estimate": f.estimate,
            "truth": f.truth,
            "within_twice": int(f.is_honest),
            "keeps_its_word": int(f.keeps_its_word),
            "operations_over_cheapest": f.cost,
            "estimate_operations_over_solve": f.overhead,
        }
        for f in findings
    ]
    write("honesty", draw(findings), rows)
    for name in ("is_honest", "keeps_its_word", "is_thrifty"):
        print(f"{name}: {sum(getattr(f, name) for f in findings)} of {len(findings)}")

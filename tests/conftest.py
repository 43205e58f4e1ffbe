# SPDX-License-Identifier: MIT OR Apache-2.0
"""A result that needs no solve: two poles of a shoe on a curved rail; a cache of a module's own; environments
with some extras only."""

from __future__ import annotations

import os
import sys
import tomllib
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from importlib.metadata import PackageNotFoundError, packages_distributions, requires
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import mtb_rs
from mtb_rs.geometry.contact_points import Patch
from mtb_rs.geometry.profiles import Profile
from mtb_rs.geometry.triangles import Surface
from mtb_rs.results.report import Report
from mtb_rs.results.result import Displacement, Result


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Only tests that say that they are coarse may miss a tolerance."""
    for item in items:
        if item.get_closest_marker("coarse") is not None:
            item.add_marker(pytest.mark.filterwarnings("ignore::mtb_rs.ToleranceWarning"))


@pytest.fixture(autouse=True)
def _figures_closed() -> Iterator[None]:
    """Where a test has brought pyplot along, figures are its own: no test leaves any to the next."""
    mpl.rcParams["figure.max_open_warning"] = 0
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


RAIL = Profile.standard("60E1")


def rail_height(y: np.ndarray) -> np.ndarray:
    return RAIL.height(np.clip(y, -35.9e-3, 35.9e-3))


def surface_over(name: str, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> Surface:
    """A height field (ny, nx) as a triangulated surface."""
    ny, nx = x.shape
    index = np.arange(ny * nx).reshape(ny, nx)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]))
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Surface(name, np.stack([x.ravel(), y.ravel(), z.ravel()]), triangles)


def box(name: str, x: tuple[float, float], y: tuple[float, float], top: float) -> Surface:
    """A pole: its sole follows the rail, its top is flat."""
    gx, gy = np.meshgrid(np.linspace(*x, 33), np.linspace(*y, 11))
    sole = surface_over(name, gx, gy, rail_height(gy))
    lid = surface_over(name, gx, gy, np.full(gx.shape, top))
    count = gx.size
    ring = np.concatenate(
        [np.arange(33), np.arange(1, 11) * 33 + 32, 10 * 33 + np.arange(31, -1, -1), np.arange(9, 0, -1) * 33]
    )
    after = np.roll(ring, -1)
    side = np.concatenate(
        [np.stack([ring, after, after + count], 1), np.stack([ring, after + count, ring + count], 1)]
    )
    return Surface(
        name,
        np.concatenate([sole.vertices, lid.vertices], axis=1),
        np.concatenate([sole.triangles[:, ::-1], lid.triangles + count, side]),
    )


@pytest.fixture(scope="session")
def pole_shoe_result() -> Result:
    """Two poles on a 3 mm grid; pressure rises to the edges and to the front, the rear lifts off."""
    h, nx, ny = 3e-3, 32, 10
    x = (np.arange(nx) - (nx - 1) / 2) * h
    y = 6e-3 + h / 2 + np.arange(ny) * h
    blocks = [np.meshgrid(x, y), np.meshgrid(x, -y[::-1])]
    px = np.concatenate([block[0].ravel() for block in blocks])
    py = np.concatenate([block[1].ravel() for block in blocks])
    points = np.stack([px, py, rail_height(py)])
    conforming = np.abs(py) < 21.6e-3
    s = px / 48e-3
    t = (np.abs(py) - 13.8e-3) / 7.8e-3
    pressure = np.where(
        conforming & (s > -0.85),
        3e6 * (0.55 + 0.35 * s) / np.sqrt(1.02 - s**2) / np.sqrt(np.maximum(1.1 - t**2, 0.05)),
        0.0,
    )
    normal = np.stack([0 * px, *RAIL.normal(py)])
    traction = np.zeros_like(points)
    traction[0] = 0.5 * pressure
    area = np.full(px.size, h * h)
    gap = np.where(pressure > 0, 0.0, 1e-7 + np.maximum(np.abs(py) - 21.6e-3, 0) * 0.02)
    down = -1e-6 * (1.2 + 0.6 * s - 0.3 * s**2 - 0.2 * t**2)
    lower = np.stack([0.3e-6 * (1 - s**2), 0 * px, down])
    force = np.sum((traction - pressure * normal) * area, axis=1)
    load = float(np.sum(pressure * area))
    report = Report(
        converged=True,
        status="synthetic",
        model="half-space",
        method="direct",
        solver="none",
        iterations=7,
        residual=1e-14,
        contact_area=float(area[pressure > 0].sum()),
        peak_pressure=float(pressure.max()),
        force_balance={"contact": force.tolist(), "relative": 0.0},
        time_s={"influence": 0.02, "solve": 0.1},
    )
    rx, ry = np.meshgrid(np.linspace(-90e-3, 90e-3, 61), np.linspace(-35.9e-3, 35.9e-3, 61))
    return Result(
        points=points,
        area=area,
        normal=normal,
        pressure=pressure,
        traction=traction,
        gap=gap,
        initial_gap=gap + 1e-6,
        status=np.where(pressure > 0, 2, 0).astype(np.int8),
        displacement=Displacement(upper=-lower, lower=lower),
        force=force,
        moment=np.zeros(3),
        reference_point=np.zeros(3),
        normal_force=load,
        approach=np.array([2e-6, 2e-6]),
        model="half-space",
        error_estimate=None,
        report=report,
        patches=(
            Patch("left pole", 0, nx, ny, (3e-3, 3e-3)),
            Patch("right pole", nx * ny, nx, ny, (3e-3, 3e-3)),
        ),
        surfaces=(
            surface_over("rail", rx, ry, rail_height(ry)),
            box("left pole", (-48e-3, 48e-3), (6e-3, 36e-3), 28.2e-3),
            box("right pole", (-48e-3, 48e-3), (-36e-3, -6e-3), 28.2e-3),
        ),
        summary={"scene": "pole_shoe_on_rail", "friction": 0.5, "magnetic_pressure": 3e6, "spacing": (h, h)},
    )


@pytest.fixture(scope="module")
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Condensations start anew and are kept for this module only."""
    patch = pytest.MonkeyPatch()
    patch.setenv("MTB_RS_CACHE", str(tmp_path_factory.mktemp("cache")))
    yield
    patch.undo()


@cache
def brought_by(*extras: str, packages: tuple[str, ...] = ()) -> frozenset[str]:
    """Names of the distributions that `pip install "mtb-rs[EXTRAS]" PACKAGES` brings."""
    root = Path(__file__).parents[1]
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    unknown = set(extras) - set(project["optional-dependencies"])
    assert not unknown, f"there are no such extras: {unknown}"
    found: set[tuple[str, str]] = set()

    def add(line: str, extra: str = "") -> None:
        requirement = Requirement(line)
        if requirement.marker is not None and not requirement.marker.evaluate({"extra": extra}):
            return
        name = canonicalize_name(requirement.name)
        for wanted in ("", *requirement.extras):
            if (name, wanted) in found:
                continue
            found.add((name, wanted))
            if name == project["name"]:
                lines = project["optional-dependencies"][wanted] if wanted else project["dependencies"]
            else:
                try:
                    lines = requires(name) or []
                except PackageNotFoundError:  # of another platform, or not installed here at all
                    lines = []
            for line in lines:
                add(line, wanted)

    for line in (f"{project['name']}[{','.join(extras)}]", *packages):
        add(line)
    return frozenset(name for name, _ in found)


@cache
def modules() -> dict[str, set[str]]:
    """Modules that are installed, and the distributions that have them."""
    names = packages_distributions()
    return {module: {canonicalize_name(name) for name in owners} for module, owners in names.items()}


@pytest.fixture(scope="session")
def with_extras() -> Callable[..., dict[str, str]]:
    """Function of names of extras: variables for a Python that sees what an installation with these has.

    It sees what an installation of further `packages` brings, too.
    """

    def environment(*extras: str, packages: Iterable[str] = ()) -> dict[str, str]:
        seen = brought_by(*sorted(extras), packages=tuple(packages))
        hidden = [module for module, owners in modules().items() if not owners & seen]
        package = Path(mtb_rs.__file__).parents[1]
        before = os.environ.get("PYTHONPATH", "").split(os.pathsep)
        path = [Path(__file__).parent / "install", package, *before]
        return {
            **os.environ,
            "HIDDEN_MODULES": " ".join(sorted(hidden)),
            "PYTHONPATH": os.pathsep.join(map(str, path)),
            "MPLBACKEND": "Agg",
        }

    return environment

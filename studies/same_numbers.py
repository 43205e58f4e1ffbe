# SPDX-License-Identifier: MIT OR Apache-2.0
"""Whether two versions of the package give the same numbers: every field of many results, one by one.

    python studies/same_numbers.py write before.npz      # with the one version
    python studies/same_numbers.py write after.npz       # with the other
    python studies/same_numbers.py compare before.npz after.npz

Fields that are the same bit for bit are only counted. Others are listed with their largest difference over
their largest value, so that what is rounding and what is not can be told.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

import mtb_rs as mtb

#: Relative difference up to which two numbers count as equal but for rounding.
ROUNDING = 1e-9

steel, soft = mtb.steel, mtb.Material(3e9, 0.4)
S = mtb.scenes


def box() -> mtb.ElasticBody:
    """An own body: a block of tetrahedra, held at its top."""
    x, y, z = (np.linspace(0.0, size, n) for size, n in ((0.06, 5), (0.03, 4), (0.02, 3)))
    points = np.array([(a, b, c) for c in z for b in y for a in x])
    nx, ny = x.size, y.size
    cells = []
    for k in range(z.size - 1):
        for j in range(ny - 1):
            for i in range(nx - 1):
                c = [
                    (k + dk) * nx * ny + (j + dj) * nx + i + di
                    for dk in (0, 1)
                    for dj in (0, 1)
                    for di in (0, 1)
                ]
                for a, b in ((1, 3), (3, 2), (2, 6), (6, 4), (4, 5), (5, 1)):
                    cells.append((c[0], c[a], c[b], c[7]))
    mesh = mtb.TetraMesh(points, np.array(cells))
    return mtb.ElasticBody(mesh, steel, "bottom", [mtb.Support("top", x=0, y=0, z=mtb.Guide(-5e3))], "pad")


def scenes() -> dict[str, Callable[[], Any]]:
    """Scenes with all bodies, loads, kinds of friction and models, and what is asked of them."""
    shoe = dict(spacing=6e-3, friction=0.3)
    made: dict[str, Callable[[], Any]] = {}

    def ask(name: str, scene: Callable[[], Any], *models: str, **options: Any) -> None:
        for model in models:
            made[f"{name}, {model}"] = lambda model=model: scene().solve(model, tolerance=0.5, **options)

    full = ("half-space", "elastic-upper", "elastic-both")
    ask("pole shoe", lambda: S.pole_shoe_on_rail(**shoe), *full)
    ask("pole shoe, offset", lambda: S.pole_shoe_on_rail(lateral=1e-3, **shoe), *full)
    ask("pole shoe, turned", lambda: S.pole_shoe_on_rail(yaw=0.02, **shoe), *full[:2])
    ask("pole shoe, one pole", lambda: S.pole_shoe_on_rail(poles=1, **shoe), *full[:2])
    ask("pole shoe, both pulled", lambda: S.pole_shoe_on_rail(attraction="both", **shoe), *full)
    ask("pole shoe, unlike", lambda: S.pole_shoe_on_rail(upper=soft, **shoe), *full[:2])
    ask("pole shoe, sideways", lambda: S.pole_shoe_on_rail(sliding_direction=(0.3, 1.0), **shoe), *full[:2])
    peaked = mtb.GaussianPressure(2e6, (0.0, 0.03), (0.05, 0.02))
    ask(
        "pole shoe, peak of pull",
        lambda: S.pole_shoe_on_rail(magnetic_pressure=peaked, **shoe),
        "elastic-upper",
    )
    ask("block", lambda: S.block_on_plane(spacing=0.0125, friction=0.3), *full[:2])
    ask(
        "block, driven",
        lambda: S.block_on_plane(spacing=0.0125, friction=0.1, supports="driven-top"),
        *full[:2],
    )
    ask(
        "block, oblique",
        lambda: S.block_on_plane(spacing=0.0125, friction=0.2, sliding_direction=(1, 1)),
        *full[:2],
    )
    ask("block, unlike", lambda: S.block_on_plane(spacing=0.0125, friction=0.2, lower=soft), *full[:2])
    ask("paraboloid", lambda: S.paraboloid_on_plane(points=24), "half-space")
    ask(
        "paraboloid, unlike", lambda: S.paraboloid_on_plane(points=24, friction=0.3, lower=soft), "half-space"
    )
    ask("paraboloid, rigid", lambda: S.paraboloid_on_plane(points=24, upper=mtb.Rigid()), "half-space")
    ask("paraboloid, fine", lambda: S.paraboloid_on_plane(points=64), "half-space")
    ask("paraboloid, free", lambda: S.paraboloid_on_plane(points=None), "auto")
    ask("wheel", lambda: S.wheel_on_rail(spacing=8e-4), "half-space")
    ask("wheel, free", lambda: S.wheel_on_rail(spacing=None), "auto")
    ask("pole shoe, auto", lambda: S.pole_shoe_on_rail(**shoe), "auto")
    made["pole shoe, incremental"] = lambda: S.pole_shoe_on_rail(**shoe).solve(method="incremental")
    made["pole shoe, staggered"] = lambda: S.pole_shoe_on_rail(**shoe).solve(method="staggered")
    x = np.linspace(-1e-3, 1e-3, 31)
    bowl = (x[None] ** 2 + x[:, None] ** 2) / 0.2

    def field(**load: Any) -> mtb.Scene:
        return mtb.Scene(steel, soft, bowl, x[1] - x[0], friction=0.2, **load)

    ask("field, force", lambda: field(force=20.0), "half-space")
    ask("field, approach", lambda: field(approach=1e-6), "half-space")
    ask("field, moments", lambda: field(force=20.0, moments=(1e-3, 2e-3)), "half-space")
    own = box()
    ask("own body on steel", lambda: mtb.Scene(own, steel, spacing=5e-3, friction=0.2), "auto")
    ask("own body, gap", lambda: mtb.Scene(own, steel, lambda x, y: y**2 / 2.0, 5e-3, friction=0.2), "auto")
    ask("own body on rigid", lambda: mtb.Scene(own, mtb.Rigid(), spacing=5e-3, friction=0.2), "auto")
    pushes = [(k * 2e-6, 0.0) for k in (1, 2, 3)]
    made["start of sliding"] = lambda: S.pole_shoe_on_rail(**shoe).start_of_sliding(pushes)
    made["start of sliding, block"] = lambda: S.block_on_plane(spacing=0.02).start_of_sliding(
        pushes, "half-space"
    )
    made["start of sliding, own"] = lambda: mtb.Scene(
        own, steel, spacing=5e-3, friction=0.2
    ).start_of_sliding(pushes)
    for model in full[:2]:
        made[f"step, {model}"] = lambda model=model: S.pole_shoe_on_rail(**shoe).prepare(model).step()
    made["step, own body"] = lambda: mtb.Scene(own, steel, spacing=5e-3, friction=0.2).prepare().step()
    made["step, wheel"] = lambda: S.wheel_on_rail(spacing=8e-4).prepare().step(velocity=20.0)
    made["normal"] = lambda: mtb.solve_normal(bowl, x[1] - x[0], lower=steel, upper=steel, force=20.0)
    made["sweep"] = lambda: mtb.sweep(S.pole_shoe_on_rail(**shoe), {"friction": [0.1, 0.3]}).columns
    inside = np.sqrt(np.maximum(0.0, 1.0 - (x[None] ** 2 + x[:, None] ** 2) / 8e-4**2))
    patch = mtb.PressureField(5e8 * inside, (x[1] - x[0], x[1] - x[0]), steel, steel)
    made["rolling"] = lambda: mtb.solve_tangential(patch, mtb.Rolling((1e-3, 5e-4, 0.3)), mtb.Coulomb(0.3))
    made["shift"] = lambda: mtb.solve_tangential(patch, mtb.Shift((1e-6, 0.0)), mtb.Coulomb(0.3))
    return made


def arrays(name: str, value: Any) -> Iterator[tuple[str, np.ndarray[Any, Any]]]:
    """All numbers in a result, each under the way to it; times are none."""
    if name.endswith(
        ("time_s", "time", "surfaces", "patches", "parts", "summary", "lower", "upper")
    ) and not name.endswith(("displacement.lower", "displacement.upper")):
        return
    if isinstance(value, (bool, int, float, np.number, np.ndarray)):
        yield name, np.asarray(value, dtype=float)
    elif is_dataclass(value):
        for entry in fields(value):
            if not entry.name.startswith("_"):
                yield from arrays(f"{name}.{entry.name}", getattr(value, entry.name))
    elif isinstance(value, tuple) and hasattr(value, "_fields"):
        for key in value._fields:
            yield from arrays(f"{name}.{key}", getattr(value, key))
    elif hasattr(value, "items"):
        for key, part in value.items():
            yield from arrays(f"{name}.{key}", part)
    elif isinstance(value, (list, tuple)):
        for k, part in enumerate(value):
            yield from arrays(f"{name}.{k}", part)


def write(path: Path) -> None:
    """Solves everything and keeps all numbers."""
    kept: dict[str, Any] = {}
    made = scenes()
    for k, (name, solve) in enumerate(made.items()):
        print(f"{k + 1} of {len(made)}: {name}", file=sys.stderr)
        try:
            kept |= dict(arrays(name, solve()))
        except Exception as error:  # a refusal is a result as well
            kept[f"{name}: {type(error).__name__}"] = np.zeros(0)
            print(f"    {type(error).__name__}: {error}", file=sys.stderr)
    np.savez_compressed(path, allow_pickle=False, **{k.replace("/", "|"): v for k, v in kept.items()})


def compare(before: Path, after: Path) -> int:
    """Prints what differs; the number of fields that differ by more than rounding."""
    old, new = (dict(np.load(path)) for path in (before, after))
    same = rounded = 0
    worse: list[str] = [f"only before: {k}" for k in old if k not in new]
    worse += [f"only after: {k}" for k in new if k not in old]
    for name in sorted(old.keys() & new.keys()):
        a, b = old[name], new[name]
        if a.shape != b.shape:
            worse.append(f"{name}: shape {a.shape}, then {b.shape}")
        elif np.array_equal(a, b, equal_nan=True):
            same += 1
        else:
            size = float(np.nanmax(np.abs(a), initial=0.0)) or 1.0
            apart = float(np.nanmax(np.abs(a - b))) / size
            if apart <= ROUNDING:
                rounded += 1
            else:
                worse.append(f"{name}: {apart:.1e}")
    print(f"{same} fields are the same bit for bit, {rounded} to {ROUNDING:g}, {len(worse)} are others")
    print("\n".join(worse))
    return len(worse)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    ways = parser.add_subparsers(dest="way", required=True)
    ways.add_parser("write").add_argument("file", type=Path)
    two = ways.add_parser("compare")
    two.add_argument("before", type=Path)
    two.add_argument("after", type=Path)
    chosen = parser.parse_args()
    warnings.simplefilter("ignore")
    if chosen.way == "write":
        write(chosen.file)
    else:
        sys.exit(compare(chosen.before, chosen.after) > 0)

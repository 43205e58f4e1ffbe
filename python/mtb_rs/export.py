# SPDX-License-Identifier: MIT OR Apache-2.0
"""A result as files: summary.json, the fields (NPZ, VTK) and pictures."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import re
import shutil
import tempfile
import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .check import path_of
from .errors import PictureWarning
from .grids import flat, patches
from .plot import drawable
from .result import Pictured, Result

#: Where a pole shoe is cut for line plots [m]: its inner edge and inside the conforming strip, as in
#: [Steininger2025, Figs. 3.6, 3.8].
POLE_SHOE_CUTS = (6e-3, 12e-3)


#: What a result may hold, of what goes into `fields.npz`; the last ones are totals, not fields.
FIELDS = (
    "points",
    "area",
    "normal",
    "pressure",
    "traction",
    "slip",
    "friction_coefficient",
    "gap",
    "initial_gap",
    "status",
)
TOTALS = (
    "force",
    "moment",
    "spin_moment",
    "reference_point",
    "normal_force",
    "approach",
    "tilts",
    "creepage",
)


def save(result: Pictured, directory: str | Path) -> list[Path]:
    """Writes a result into a directory, which is made if need be.

    ========================== =====================================================================
    summary.json               inputs, forces, report, per-patch figures; no NaN
    fields.npz                 every array of the result, under its own name
    contact.vtp                the patches with all fields, for ParaView (needs pyvista)
    body_<name>.vtp            surfaces of the bodies without finite elements (needs pyvista)
    body_<name>.vtu            elastic bodies with displacement, stress (xx, yy, zz, xy, yz, xz) and
                               von Mises' stress at all nodes (needs pyvista)
    pressure.png ...           maps: pressure, traction, slip, vertical displacement, status, as there are
    pressure_lines.png ...     cuts along x: pressure, vertical displacement
    view.png, von_mises.png    three-dimensional views of a scene, the second one of the deformed elastic
                               bodies (need pyvista and a GL driver)
    ========================== =====================================================================

    Everything is written beside the directory first and then moved in: what stands in the directory
    is complete. Files of an earlier result, as its summary lists them, are replaced or removed.

    Returns
    -------
    list of Path

    Warns
    -----
    PictureWarning
        For what is left out because a package or a GL driver is missing; also in the summary, under
        "notices".
    """
    target = path_of("directory", directory)
    if target.exists() and not target.is_dir():
        raise ValueError(f"cannot save into {target}: it is not a directory")
    target.parent.mkdir(parents=True, exist_ok=True)
    draft = Path(tempfile.mkdtemp(prefix=f".{target.name}-", dir=target.parent))
    try:
        notices = _write_fields(result, draft) + _write_pictures(result, draft)
        names = sorted(path.name for path in draft.iterdir())
        text = json.dumps(summary(result, names, notices), indent=2, allow_nan=False)
        (draft / "summary.json").write_text(text + "\n", encoding="utf-8")
        target.mkdir(exist_ok=True)
        for name in _files_of_earlier_result(target) - set(names):
            (target / name).unlink(missing_ok=True)
        # the summary goes first and comes last: where there is one, all it lists is there
        (target / "summary.json").unlink(missing_ok=True)
        for name in [*names, "summary.json"]:
            os.replace(draft / name, target / name)
    finally:
        shutil.rmtree(draft, ignore_errors=True)
    for notice in notices:
        warnings.warn(notice, PictureWarning, stacklevel=2)
    return [target / name for name in [*names, "summary.json"]]


def summary(result: Pictured, files: list[str], notices: list[str]) -> dict[str, Any]:
    """What `summary.json` holds: plain data, None for what is not finite."""
    from . import __version__

    pressure, area, status = (flat(result, v) for v in (result.pressure, result.area, result.status))
    by_patch = {
        patch.name: {
            "points": patch.nx * patch.ny,
            "in_contact": int(np.count_nonzero(patch.view(status))),
            "contact_area": float(np.sum(patch.view(area)[patch.view(status) > 0])),
            "normal_force": float(np.sum(patch.view(pressure) * patch.view(area))),
            "peak_pressure": float(patch.view(pressure).max()),
        }
        for patch in patches(result)
    }
    content: dict[str, Any] = {"mtb_rs": __version__, "result": type(result).__name__}
    if isinstance(result, Result):
        content["inputs"] = result.summary
    for name in ("motion", "model", "error_estimate", *TOTALS):
        if hasattr(result, name) and not (name == "motion" and isinstance(result, Result)):
            content[name] = getattr(result, name)
    content |= {"points": int(pressure.size), "patches": by_patch}
    if hasattr(result, "report"):
        content["report"] = result.report.as_dict()
    content |= {"files": files, "notices": notices}
    return {key: plain(value) for key, value in content.items()}


def plain(value: Any) -> Any:
    """`value` as JSON can hold it: lists and numbers; None for NaN and infinity."""
    if value is None or isinstance(value, (bool, str, int)):
        return value
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value) if f.repr}
    return str(value)


def _write_fields(result: Pictured, draft: Path) -> list[str]:
    fields = {name: getattr(result, name) for name in FIELDS if hasattr(result, name)}
    if isinstance(result, Result):
        fields["displacement_upper"] = result.displacement.upper
        fields["displacement_lower"] = result.displacement.lower
    totals = {name: getattr(result, name) for name in TOTALS if hasattr(result, name)}
    np.savez_compressed(draft / "fields.npz", **fields, **totals)
    try:
        from .view import bodies, body_mesh, contact_mesh, solid_meshes

        contact = contact_mesh(result)
    except ImportError:
        return ["no VTK files: they need pyvista, pip install 'mtb-rs[viz]'"]
    data = contact.cell_data if patches(result) else contact.point_data
    for name, values in fields.items():
        if name != "points":
            data[name] = np.ascontiguousarray(flat(result, values).T)
    contact.save(draft / "contact.vtp")
    if not isinstance(result, Result):
        return []
    plain = [surface for surface in bodies(result) if surface.von_mises is None]
    for stem, surface in zip(_plain_names(s.name for s in plain), plain, strict=True):
        body_mesh(surface).save(draft / f"body_{stem}.vtp")
    solids = solid_meshes(result)
    for stem, solid in zip(_plain_names(solids), solids.values(), strict=True):
        solid.save(draft / f"body_{stem}.vtu")
    return []


def _plain_names(names: Iterable[str]) -> list[str]:
    """Names for files, no two alike: those that differ in other signs only are numbered."""
    found: list[str] = []
    for name in names:
        stem = plain = re.sub(r"[^0-9A-Za-z]+", "_", name)
        k = 1
        # some file systems do not tell a from A
        while stem.lower() in (s.lower() for s in found):
            k += 1
            stem = f"{plain}_{k}"
        found.append(stem)
    return found


def _write_pictures(result: Pictured, draft: Path) -> list[str]:
    known = drawable(result)
    maps = ["pressure", "vertical_displacement", "status"]
    if "slip" in known:
        maps += ["traction", "slip"]
    for quantity in maps:
        if quantity in known:
            result.plot(quantity).savefig(draft / f"{quantity}.png")
    if patches(result):
        shoe = isinstance(result, Result) and result.summary.get("scene") == "pole_shoe_on_rail"
        for quantity in ("pressure", "vertical_displacement"):
            if quantity in known:
                picture = result.plot(quantity, "line", y=POLE_SHOE_CUTS if shoe else None)
                picture.savefig(draft / f"{quantity}_lines.png")
    if not isinstance(result, Result):
        return []
    from .view import missing_for_view

    missing = missing_for_view()
    if missing is None:
        views = {"view": "pressure"} | ({"von_mises": "von_mises"} if result.parts else {})
        for name, quantity in views.items():
            plotter = result.plot(quantity, "3d", off_screen=True)
            plotter.screenshot(draft / f"{name}.png")
            plotter.close()
        return []
    return [f"no view.png: {missing}"]


def _files_of_earlier_result(directory: Path) -> set[str]:
    """Names that the summary of an earlier result lists; only plain names inside the directory."""
    try:
        listed = json.loads((directory / "summary.json").read_text(encoding="utf-8"))["files"]
        return {name for name in listed if Path(name).name == name}
    except (OSError, ValueError, KeyError, TypeError):
        return set()

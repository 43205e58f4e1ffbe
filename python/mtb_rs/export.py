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
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .grids import flat, patches
from .result import Result

#: Where a pole shoe is cut for line plots [m]: its inner edge and inside the conforming strip, as in
#: [Steininger2025, Figs. 3.6, 3.8].
POLE_SHOE_CUTS = (6e-3, 12e-3)


class PictureWarning(UserWarning):
    """A file that was left out, and what to install to have it."""


def save(result: Result, directory: str | Path) -> list[Path]:
    """Writes a result into a directory, which is made if need be.

    ========================== =====================================================================
    summary.json               inputs, forces, report, per-patch figures; no NaN
    fields.npz                 every array of the result, under its own name
    contact.vtp                the patches with all fields, for ParaView (needs pyvista)
    body_<name>.vtp            the bodies with their displacement (needs pyvista)
    pressure.png ...           maps: pressure, vertical displacement, status
    pressure_lines.png ...     cuts along x: pressure, vertical displacement
    view.png                   the three-dimensional view (needs pyvista and a GL driver)
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
    target = Path(directory)
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


def summary(result: Result, files: list[str], notices: list[str]) -> dict[str, Any]:
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
    content = {
        "mtb_rs": __version__,
        "inputs": result.summary,
        "model": result.model,
        "error_estimate": result.error_estimate,
        "normal_force": result.normal_force,
        "force": result.force,
        "moment": result.moment,
        "reference_point": result.reference_point,
        "approach": result.approach,
        "points": int(pressure.size),
        "patches": by_patch,
        "report": result.report.as_dict(),
        "files": files,
        "notices": notices,
    }
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


def _write_fields(result: Result, draft: Path) -> list[str]:
    fields: dict[str, Any] = {
        name: getattr(result, name)
        for name in (
            "points",
            "area",
            "normal",
            "pressure",
            "traction",
            "gap",
            "initial_gap",
            "status",
            "force",
            "moment",
            "reference_point",
            "approach",
        )
    }
    fields["displacement_upper"] = result.displacement.upper
    fields["displacement_lower"] = result.displacement.lower
    np.savez_compressed(draft / "fields.npz", **fields)
    try:
        from .view import bodies, body_mesh, contact_mesh

        contact = contact_mesh(result)
    except ImportError:
        return ["no VTK files: they need pyvista, pip install 'mtb-rs[viz]'"]
    data = contact.cell_data if patches(result) else contact.point_data
    for name, values in fields.items():
        # all but the points themselves and the totals belong to the cells
        if name not in ("points", "force", "moment", "reference_point", "approach"):
            data[name] = np.ascontiguousarray(flat(result, values).T)
    contact.save(draft / "contact.vtp")
    for surface in bodies(result):
        mesh = body_mesh(surface)
        if surface.displacement is not None:
            mesh.point_data["displacement"] = np.ascontiguousarray(surface.displacement.T)
        mesh.save(draft / f"body_{re.sub(r'[^0-9A-Za-z]+', '_', surface.name)}.vtp")
    return []


def _write_pictures(result: Result, draft: Path) -> list[str]:
    for quantity in ("pressure", "vertical_displacement", "status"):
        result.plot(quantity).savefig(draft / f"{quantity}.png")
    if patches(result):
        shoe = result.summary.get("scene") == "pole_shoe_on_rail"
        for quantity in ("pressure", "vertical_displacement"):
            picture = result.plot(quantity, "line", y=POLE_SHOE_CUTS if shoe else None)
            picture.savefig(draft / f"{quantity}_lines.png")
    from .view import missing_for_view

    missing = missing_for_view()
    if missing is None:
        plotter = result.plot("pressure", "3d", off_screen=True)
        plotter.screenshot(draft / "view.png")
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

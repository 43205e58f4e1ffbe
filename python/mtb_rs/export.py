# SPDX-License-Identifier: MIT OR Apache-2.0
"""A result as files: summary.json, the fields (NPZ, VTK) and pictures."""

from __future__ import annotations

import dataclasses
import io
import json
import math
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from .check import warn
from .errors import PictureWarning
from .files import check_folder, drafted, read_text
from .grids import flat, patches
from .plot import drawable, own_figures
from .result import Pictured, Result, png

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
    "dissipation",
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


#: Quantities drawn as maps and as cuts; the pictures bear their names.
MAPS = ("pressure", "vertical_displacement", "status", "traction", "slip")
LINES = ("pressure", "vertical_displacement")
#: What lists the files of a result.
SUMMARY = "summary.json"
#: Names of files of a result: no others are ever removed or replaced.
_OWN = re.compile(
    rf"fields\.npz|contact\.vtp|body_[0-9A-Za-z_]*\.vt[pu]|({'|'.join(MAPS)}|view|von_mises)\.png|"
    rf"({'|'.join(LINES)})_lines(_along_y)?\.png"
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
    pressure_lines.png ...     cuts along x: pressure, vertical displacement; and along y, through the peak of
                               the pressure: pressure_lines_along_y.png ...
    view.png, von_mises.png    three-dimensional views of a scene, the second one of the deformed elastic
                               bodies (need pyvista and a GL driver)
    ========================== =====================================================================

    Everything is made beside its place first and then moved in: what stands in the directory is complete.
    Files of an earlier result, as its summary lists them, are replaced or removed; no others are.

    Returns
    -------
    list of Path

    Raises
    ------
    ValueError
        If the directory is a file, or holds a file of one of these names that no earlier result lists.
    OSError
        If nothing can be written there.

    Warns
    -----
    PictureWarning
        For what is left out because a package or a GL driver is missing; also in the summary, under
        "notices".
    """
    target = check_saveable(directory)
    files: dict[str, bytes] = {}
    with own_figures():
        notices = _fields(result, files) + _pictures(result, files)
    names = sorted(files)
    text = json.dumps(summary(result, names, notices), indent=2, allow_nan=False)
    earlier = _files_of_earlier_result(target)
    with drafted(target) as draft:
        for name, content in [*files.items(), (SUMMARY, text.encode() + b"\n")]:
            draft.write(name, content)
        # until the last file is in its place the summary tells whose files these are
        listed = {**_mark(), "is_complete": False, "files": sorted({*names, *earlier})}
        draft.write("listed", json.dumps(listed).encode() + b"\n")
        draft.move("listed", SUMMARY)
        for name in names:
            draft.move(name)
        for name in earlier - set(names):
            (target / name).unlink(missing_ok=True)
        draft.move(SUMMARY)
    for notice in notices:
        warn(notice, PictureWarning)
    return [target / name for name in [*names, SUMMARY]]


def check_saveable(directory: str | Path) -> Path:
    """The directory that a result is to be saved into; nothing is left there.

    Raises
    ------
    ValueError, OSError
        As :func:`save`.
    """
    target = check_folder(directory)
    own = _files_of_earlier_result(target)
    present = sorted(path.name for path in target.iterdir()) if target.exists() else []
    for name in present:
        if (_OWN.fullmatch(name) and name not in own) or (name == SUMMARY and _listing(target) is None):
            raise ValueError(
                f"{target / name} is there, and no earlier result of mtb_rs lists it: it would be lost; move "
                "it, or save into another directory"
            )
    return target


def summary(result: Pictured, files: list[str], notices: list[str]) -> dict[str, Any]:
    """What `summary.json` holds: plain data, None for what is not finite."""
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
    content: dict[str, Any] = {**_mark(), "result": type(result).__name__}
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


def _mark() -> dict[str, Any]:
    """What a summary is known by."""
    from . import __version__

    return {"mtb_rs": __version__}


def _fields(result: Pictured, files: dict[str, bytes]) -> list[str]:
    fields = {name: getattr(result, name) for name in FIELDS if hasattr(result, name)}
    if isinstance(result, Result):
        fields["displacement_upper"] = result.displacement.upper
        fields["displacement_lower"] = result.displacement.lower
    totals = {name: getattr(result, name) for name in TOTALS if hasattr(result, name)}
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **fields, **totals)
    files["fields.npz"] = buffer.getvalue()
    try:
        from .view import bodies, body_mesh, contact_mesh, solid_meshes, vtk_bytes

        contact = contact_mesh(result)
    except ImportError:
        return ["no VTK files: they need pyvista, pip install 'mtb-rs[viz]'"]
    data = contact.cell_data if patches(result) else contact.point_data
    for name, values in fields.items():
        if name != "points":
            data[name] = np.ascontiguousarray(flat(result, values).T)
    files["contact.vtp"] = vtk_bytes(contact)
    if not isinstance(result, Result):
        return []
    plain = [surface for surface in bodies(result) if surface.von_mises is None]
    for stem, surface in zip(_plain_names(s.name for s in plain), plain, strict=True):
        files[f"body_{stem}.vtp"] = vtk_bytes(body_mesh(surface))
    solids = solid_meshes(result)
    for stem, solid in zip(_plain_names(solids), solids.values(), strict=True):
        files[f"body_{stem}.vtu"] = vtk_bytes(solid)
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


def _pictures(result: Pictured, files: dict[str, bytes]) -> list[str]:
    known = drawable(result)
    for quantity in MAPS:
        if quantity in known and (quantity not in ("traction", "slip") or "slip" in known):
            files[f"{quantity}.png"] = png(result.plot(quantity))
    if patches(result):
        shoe = isinstance(result, Result) and result.summary.get("scene") == "pole_shoe_on_rail"
        for quantity in LINES:
            if quantity in known:
                picture = result.plot(quantity, "line", y=POLE_SHOE_CUTS if shoe else None)
                files[f"{quantity}_lines.png"] = png(picture)
                if any(patch.ny > 1 for patch in patches(result)):
                    peak = flat(result, result.points)[0, flat(result, result.pressure).argmax()]
                    picture = result.plot(quantity, "line", x=float(peak))
                    files[f"{quantity}_lines_along_y.png"] = png(picture)
    if not isinstance(result, Result):
        return []
    from .view import missing_for_view

    missing = missing_for_view()
    if missing is None:
        views = {"view": result.plot("pressure", "3d", off_screen=True)}
        if result.parts:
            views["von_mises"] = result.plot("von_mises", "3d", off_screen=True)
        for name, plotter in views.items():
            buffer = io.BytesIO()
            Image.fromarray(plotter.screenshot(return_img=True)).save(buffer, "PNG")
            files[f"{name}.png"] = buffer.getvalue()
            plotter.close()
        return []
    return [f"no view.png: {missing}"]


def _listing(directory: Path) -> list[Any] | None:
    """The files that the summary of an earlier result lists; None without such a summary."""
    try:
        found = json.loads(read_text(directory / SUMMARY))
    except (ValueError, RecursionError):
        return None
    if not isinstance(found, dict) or not isinstance(found.get("mtb_rs"), str):
        return None
    listed = found.get("files")
    return listed if isinstance(listed, list) else None


def _files_of_earlier_result(directory: Path) -> set[str]:
    """What an earlier result wrote: names that its summary lists and that a result can have."""
    return {name for name in _listing(directory) or () if isinstance(name, str) and _OWN.fullmatch(name)}

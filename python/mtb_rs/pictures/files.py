# SPDX-License-Identifier: MIT OR Apache-2.0
"""A result as files: summary.json, the fields (NPZ, VTK) and pictures."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any, get_args

import numpy as np
from PIL import Image

from ..base.check import warn
from ..base.errors import PictureWarning
from ..base.files import check_folder, check_target, drafted, write_bytes
from ..base.stored import plain_data
from ..base.words import Field as Word
from ..base.words import Stress
from ..results.doors import png
from ..results.grids import flat, patches
from ..results.result import Drawn, Pictured
from ..results.saved import SUMMARY, data_files, mark, summary_in
from ..results.study import Study
from . import space
from .figures import own_figures
from .quantities import drawable

#: Where a pole shoe is cut for line plots [m]: its inner edge and inside the conforming strip, as in
#: [Steininger2025, Figs. 3.6, 3.8].
POLE_SHOE_CUTS = (6e-3, 12e-3)


#: Quantities drawn as maps and as cuts; the pictures bear their names.
MAPS: tuple[Word, ...] = ("temperature", "pressure", "vertical_displacement", "status", "traction", "slip")
LINES: tuple[Word, ...] = ("pressure", "vertical_displacement")
#: Names of files of a result: no others are ever removed or replaced.
_OWN = re.compile(
    rf"fields\.npz|result\.(npz|json)|contact\.vtp|body_[0-9A-Za-z_]*\.vt[pu]|({'|'.join(MAPS)}|view|von_mises)\.png|"
    rf"({'|'.join(LINES)})_lines(_along_y)?\.png|wear\.png|"
    r"(force|slip_share|depth|worn_volume|uniformity|peak_pressure|speed|forces|peaks|means|friction_powers|"
    r"heats_upper|heats_lower|losses|stored|volumes_upper|volumes_lower|errors)\.png"
)


def save(result: Drawn, directory: str | Path) -> list[Path]:
    """Writes a result into a directory, which is made if need be.

    ========================== =====================================================================
    summary.json               inputs, forces, report, per-patch figures, units of the fields; no NaN
    fields.npz                 every field and total of the result, under its own name
    result.json, result.npz    what :func:`mtb_rs.load` needs besides
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
        kept = result._kept()
        files |= data_files(kept)
        for quantity in kept.curves:
            files[f"{quantity}.png"] = png(kept.plot(quantity))
        missing: list[str] = []
        if not kept.blank:
            picture = kept._picture()
            missing = _vtk(picture, files) + _pictures(picture, files)
    names = sorted(files)
    notices = [f"no maps and no VTK files: {kept.blank}"] if kept.blank else missing
    told = summary(kept, names, notices)
    text = json.dumps(told, indent=2, allow_nan=False)
    earlier = _files_of_earlier_result(target)
    with drafted(target) as draft:
        for name, content in [*files.items(), (SUMMARY, text.encode() + b"\n")]:
            draft.write(name, content)
        # until the last file is in its place the summary tells whose files these are
        listed = {**mark(), "is_complete": False, "files": sorted({*names, *earlier})}
        draft.write("listed", json.dumps(listed).encode() + b"\n")
        draft.move("listed", SUMMARY)
        for name in names:
            draft.move(name)
        for name in earlier - set(names):
            (target / name).unlink(missing_ok=True)
        draft.move(SUMMARY)
    for notice in missing:
        warn(notice, PictureWarning)
    return [target / name for name in [*names, SUMMARY]]


def draw_into(
    path: str | Path, result: Drawn | Study, quantity: str | None = None, kind: str | None = None
) -> None:
    """Draws one quantity of a result into a file, whose ending tells the format; None: its usual one.

    Raises
    ------
    ValueError
        If the result has no such quantity or kind of picture, or nothing draws into such a file.
    ViewError
        Of pictures in space, as :func:`mtb_rs.pictures.view`.
    OSError
        If nothing can be written there.
    """
    target = check_target(path)
    ending = target.suffix.lower()
    is_space = kind == "3d" or (kind is None and quantity in get_args(Stress))
    endings = (".png", ".html") if is_space else (".png", ".svg", ".pdf")
    if ending not in endings:
        raise ValueError(f"path is {str(path)!r}: a name ending in one of {', '.join(endings)} is needed")
    drawn: Any = result
    asked = () if quantity is None else (quantity,)
    named = {} if kind is None else {"kind": kind}
    if named and result.is_one_picture:
        raise ValueError(f"kind is {kind!r}: what was saved is a table or a chart, which is drawn in one way")
    buffer = io.BytesIO()
    with own_figures():
        if not is_space:
            drawn.plot(*asked, **named).savefig(buffer, format=ending[1:])
        else:
            plotter = drawn.plot(*asked, kind="3d", off_screen=True)
            if ending == ".html":
                buffer.write(space.page_of(plotter, quantity or "pressure").encode())
            else:
                Image.fromarray(plotter.screenshot(return_img=True)).save(buffer, "PNG")
                plotter.close()
    write_bytes(target, buffer.getbuffer())


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
        if (_OWN.fullmatch(name) and name not in own) or (name == SUMMARY and summary_in(target) is None):
            raise ValueError(
                f"{target / name} is there already and was not written by mtb_rs as part of a result: "
                "saving would overwrite it; move it, or save into another directory"
            )
    return target


def summary(result: Drawn, files: list[str], notices: list[str]) -> dict[str, Any]:
    """What `summary.json` holds of a result: plain data, None for what is not finite."""
    facts = result.facts()
    report = {"report": facts.pop("report")} if "report" in facts else {}
    content: dict[str, Any] = {**mark(), "result": type(result).__name__, **facts}
    content |= {name: total.values for name, total in result.totals().items()}
    content |= {"points": 0, "patches": {}} if result.blank else _by_patch(result._picture())
    content |= {"fields": {n: {"label": f.label, "unit": f.unit} for n, f in result.fields().items()}}
    content |= {**report, "files": files, "notices": notices}
    return {key: plain_data(value) for key, value in content.items()}


def _by_patch(result: Pictured) -> dict[str, Any]:
    """The number of points, and figures of each patch."""
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
    return {"points": int(pressure.size), "patches": by_patch}


def _vtk(result: Pictured, files: dict[str, bytes]) -> list[str]:
    try:
        contact = space.contact_dataset(result)
    except ImportError:
        return ["no VTK files: they need pyvista, pip install 'mtb-rs[viz]'"]
    files["contact.vtp"] = space.vtk_bytes(contact)
    plain = [surface for surface in space.bodies(result) if surface.von_mises is None]
    for stem, surface in zip(_plain_names(s.name for s in plain), plain, strict=True):
        files[f"body_{stem}.vtp"] = space.vtk_bytes(space.body_mesh(surface))
    solids = space.solid_meshes(result)
    for stem, solid in zip(_plain_names(solids), solids.values(), strict=True):
        files[f"body_{stem}.vtu"] = space.vtk_bytes(solid)
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
        # in gross sliding the traction is friction times pressure
        is_told = quantity not in ("traction", "slip") or "slip" in known or result.curves
        if quantity in known and is_told:
            files[f"{quantity}.png"] = png(result.plot(quantity))
    if "wear_upper" in result.fields():
        files["wear.png"] = png(result.plot("wear", body="upper"))
    if patches(result):
        shoe = result.facts().get("inputs", {}).get("scene") == "pole_shoe_on_rail"
        for quantity in LINES:
            if quantity in known:
                picture = result.plot(quantity, "line", y=POLE_SHOE_CUTS if shoe else None)
                files[f"{quantity}_lines.png"] = png(picture)
                peak = result.peak_x()
                if peak is not None and any(patch.ny > 1 for patch in patches(result)):
                    picture = result.plot(quantity, "line", x=peak)
                    files[f"{quantity}_lines_along_y.png"] = png(picture)
    if not result.surfaces and not result.solids():
        return []
    missing = space.missing_for_view()
    if missing is None:
        views = {"view": result.plot("pressure", "3d", off_screen=True)}
        if result.solids():
            views["von_mises"] = result.plot("von_mises", "3d", off_screen=True)
        for name, plotter in views.items():
            buffer = io.BytesIO()
            Image.fromarray(plotter.screenshot(return_img=True)).save(buffer, "PNG")
            files[f"{name}.png"] = buffer.getvalue()
            plotter.close()
        return []
    return [f"no view.png: {missing}"]


def _files_of_earlier_result(directory: Path) -> set[str]:
    """What an earlier result wrote: names that its summary lists and that a result can have."""
    listed = (summary_in(directory) or {}).get("files", ())
    return {name for name in listed if isinstance(name, str) and _OWN.fullmatch(name)}

# SPDX-License-Identifier: MIT OR Apache-2.0
"""The three-dimensional view of a result (pyvista): bodies, the quantity on the contact patch, deformation.

VTK ends the process when it finds no GL driver, so a first picture is tried in another process, once.
"""

from __future__ import annotations

import html
import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.check import number
from ..base.errors import ViewError
from ..base.files import check_target, write_bytes
from ..base.memory import amount
from ..base.words import Body, Limits, Stress
from ..base.words import Field as Word
from ..geometry.triangles import Surface
from ..results.fields import Field
from ..results.grids import corners, flat, patches, quads
from ..results.result import Drawn, Pictured
from ..results.solid import Solid
from .quantities import (
    STATUS_COLOURS,
    STATUS_NAMES,
    as_drawn,
    bar_title,
    colour_scale,
    quantity_of,
    states_of,
)

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]


#: What Debian and Ubuntu need for pictures without a display.
GL_PACKAGES = "libegl1 libgl1-mesa-dri"
_WINDOW = "VTK_DEFAULT_OPENGL_WINDOW"
_PROBE = (
    "from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow;"
    "import vtkmodules.vtkRenderingOpenGL2;"
    "w = vtkRenderWindow(); w.SetOffScreenRendering(1); w.AddRenderer(vtkRenderer()); w.Render()"
)

#: Share of the height of a body that is its end at the contact.
_CONTACT_END = 0.1

_BODY_COLOUR, _EDGE_COLOUR, _INK = "#CDD2DA", "#4A5560", "#333333"


#: Address space [bytes] that a 3-D picture may take: VTK and its driver end the process where they get less.
_ROOM = 3.5e9


def missing_for_view() -> str | None:
    """Why no 3-D picture can be made here and now, with what would help; None when one can."""
    left = _mtb_rs.available_address_space()
    if left is not None and left < _ROOM:
        return (
            f"the 3-D view takes up to {amount(_ROOM)} of the address space, and its limit leaves "
            f"{amount(left)}: raise the limit (ulimit -v)"
        )
    return _missing_driver()


@cache
def _missing_driver() -> str | None:
    """Why no 3-D picture can be made on this machine, with what to install; None when one can.

    Renders an empty picture in another process the first time, and remembers the answer. Without a
    display, the kind of window that worked is left in the environment for VTK to find.
    """
    try:
        import pyvista  # noqa: F401
    except ImportError:
        return "the 3-D view needs pyvista: pip install 'mtb-rs[viz]'"
    headless = sys.platform == "linux" and not os.environ.get("DISPLAY")
    windows = [os.environ.get(_WINDOW)]
    if headless and windows == [None]:
        windows = ["vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow"]
    for window in windows:
        environment = os.environ | ({_WINDOW: window} if window else {})
        try:
            probe = subprocess.run(
                [sys.executable, "-c", _PROBE], env=environment, capture_output=True, timeout=180, check=False
            )
        except subprocess.TimeoutExpired:
            continue
        if probe.returncode == 0:
            if window:
                os.environ[_WINDOW] = window
            return None
    return (
        f"the 3-D view needs a GL driver, and none works here: apt-get install {GL_PACKAGES} "
        "(Debian, Ubuntu), or the driver of this machine's graphics"
    )


def view(
    result: Pictured,
    quantity: Word = "pressure",
    *,
    body: Body = "lower",
    limits: Limits | None = None,
    scale: float | None = None,
    off_screen: bool | None = None,
    size: tuple[int, int] = (1400, 950),
) -> pyvista.Plotter:
    """The bodies in space, with the quantity on the contact patch of the lower one.

    Of a result that has no bodies (a height field, a step) it is the patch alone.

    Parameters
    ----------
    quantity : str
        As in :func:`mtb_rs.pictures.plot`.
    body : "lower" or "upper"
        Whose displacement is drawn.
    limits : (low, high) [SI unit of the quantity]
        Ends of the colour scale. By default those of the values, or less where single peaks would
        flatten the rest: the largest value then stands over the bar.
    scale : float
        Factor on the displacements, of which that of a body as a whole along z, towards the other one, counts
        once. By default 0 where the bodies carry none (half-spaces), otherwise
        such that the largest one is seen as a twentieth of the patch.
    off_screen : bool
        By default True where there is no display.
    size : (int, int)
        Pixels.

    Returns
    -------
    pyvista.Plotter
        ``.show()`` opens a window or a notebook cell, ``.screenshot(path)`` writes a picture.

    Raises
    ------
    ViewError
        Without pyvista or a GL driver; names what to install.
    ValueError
        If the scale is no finite number.
    """
    if scale is not None:
        scale = number("scale", scale)
    plotter = _plotter(off_screen, size)

    asked = quantity_of(result, quantity, body)
    contact = _places(result)
    surfaces = tuple(_closed(surface, contact) for surface in bodies(result))
    if scale is None:
        scale = _default_scale(surfaces, result)

    span = float(np.ptp(contact, axis=1).max())
    drawn = [(surface, _add_body(plotter, surface, contact, scale)) for surface in surfaces]

    values = flat(result, asked.values).astype(float)
    closed = flat(result, result.status) > 0
    shown = closed if asked.extent == "contact" else np.ones_like(closed)
    style: dict[str, Any]
    if quantity == "status":
        factor = 1.0
        count = states_of(result.status)
        style = {
            "cmap": list(STATUS_COLOURS[:count]),
            "clim": (-0.5, count - 0.5),
            "n_colors": count,
            "annotations": {float(code): name for code, name in enumerate(STATUS_NAMES[:count])},
            "scalar_bar_args": _bar("status") | {"n_labels": 0},
        }
    else:
        shades = colour_scale(values[shown], asked, limits)
        factor = shades.factor
        style = {
            "cmap": shades.colours,
            "clim": (shades.norm.vmin, shades.norm.vmax),
            "scalar_bar_args": _bar(
                bar_title(asked.label.replace(" displacement", "\ndisplacement"), values[shown], shades)
            ),
        }
    patch = contact_mesh(result)
    for surface, mesh in drawn:
        if not _is_upper(surface, contact):
            _lay_on(patch, mesh)
    patch.points = patch.points + np.array([0.0, 0.0, 2e-3 * span])
    patch.cell_data["drawn"] = np.where(shown, values / factor, np.nan)
    if not patches(result):
        style |= {"point_size": 12.0}  # scattered points
    plotter.add_mesh(patch, scalars="drawn", nan_color="#EDEDED", lighting=False, copy_mesh=True, **style)
    border = patch.extract_feature_edges(feature_edges=False, manifold_edges=False, non_manifold_edges=False)
    if border.n_points:
        plotter.add_mesh(border, color="#333333", line_width=2, lighting=False)
    direction = np.array([1.3, -1.5, 1.25])
    return _framed(plotter, result, scale, direction, is_open=not shown.all())


def view_von_mises(
    result: Pictured,
    *,
    limits: tuple[float, float] | None = None,
    scale: float | None = None,
    off_screen: bool | None = None,
    size: tuple[int, int] = (1400, 950),
) -> pyvista.Plotter:
    """The deformed elastic bodies in the colours of von Mises' equivalent stress.

    Where the lower body has no elements it is looked through, from below onto the face that presses.
    Arguments and errors are those of :func:`view`.

    Raises
    ------
    ValueError
        If no body has finite elements.
    """
    solids = result.solids()
    if not solids:
        model = result.facts().get("model")
        if model is None:
            raise ValueError("quantity is 'von_mises': only scenes have bodies with stresses")
        raise ValueError(
            f"quantity is 'von_mises', but in the model {model!r} no body has finite elements: "
            "solve with model='elastic-upper' or 'elastic-both'"
        )
    if scale is not None:
        scale = number("scale", scale)
    plotter = _plotter(off_screen, size)

    surfaces = tuple(_closed(surface, _places(result)) for surface in _bodies(result, solids))
    if scale is None:
        scale = _default_scale(surfaces, result)
    stress = {id(s): s.von_mises for s in surfaces if s.von_mises is not None}
    label = "von Mises stress"
    everything = np.concatenate(list(stress.values()))
    asked = Field("von_mises", label, "Pa", everything)
    shades = colour_scale(everything, asked, limits)
    for surface in surfaces:
        if id(surface) not in stress:
            _add_outline(plotter, _around(body_mesh(surface), _places(result)))
            continue
        mesh = body_mesh(surface, scale)
        mesh.point_data["drawn"] = stress[id(surface)] / shades.factor
        plotter.add_mesh(
            mesh,
            scalars="drawn",
            cmap=shades.colours,
            clim=(shades.norm.vmin, shades.norm.vmax),
            # colours are those of the bar; edges tell the shape
            lighting=False,
            scalar_bar_args=_bar(bar_title(label, everything, shades)),
            copy_mesh=True,
        )
        _add_outline(plotter, mesh)
    below = all(solid.upper for solid in solids)
    return _framed(plotter, result, scale, np.array([1.3, -1.5, -1.1 if below else 1.25]))


def _plotter(off_screen: bool | None, size: tuple[int, int]) -> pyvista.Plotter:
    missing = missing_for_view()
    if missing:
        raise ViewError(missing)
    import pyvista

    if off_screen is None:
        off_screen = sys.platform == "linux" and not os.environ.get("DISPLAY")
    plotter = pyvista.Plotter(off_screen=off_screen, window_size=list(size), border=False)
    plotter.set_background("white")
    return plotter


def _framed(
    plotter: pyvista.Plotter, result: Pictured, scale: float, direction: Array, *, is_open: bool = False
) -> pyvista.Plotter:
    """The picture seen from a direction, with axes, the scale of displacements, and what pale cells are."""
    points = _places(result)
    centre, span = points.mean(axis=1), float(np.ptp(points, axis=1).max())
    notes = [f"displacement x {scale:g}"] if scale else []
    if is_open:
        notes.append("pale cells do not touch")
    plotter.add_text("\n".join(notes), position="lower_right", font_size=11, color="#333333")
    plotter.add_axes(color="#333333", line_width=3)
    plotter.enable_depth_peeling()
    plotter.enable_anti_aliasing("ssaa")
    plotter.camera_position = [tuple(centre + span * direction), tuple(centre), (0, 0, 1)]
    plotter.reset_camera()
    plotter.camera.zoom(1.18)
    # the bodies to the left, the colour bar beside them
    plotter.camera.SetWindowCenter(0.14, -0.06)
    return plotter


def contact_mesh(result: Pictured) -> pyvista.PolyData:
    """The contact patches as cells of the lower surface: quadrilaterals, or vertices where scattered.

    Cells are in the order of the result's points. Results on a height field are drawn in the plane z = 0.
    """
    import pyvista

    points = _places(result)
    grids = patches(result)
    if not grids:
        return pyvista.PolyData(points.T)
    nodes, cells = [], []
    first = 0
    for patch in grids:
        corner = corners(result, patch, points)
        nodes.append(corner.reshape(3, -1).T)
        cells.append(quads(patch.nx, patch.ny) + first)
        first += nodes[-1].shape[0]
    return pyvista.PolyData.from_regular_faces(np.concatenate(nodes), np.concatenate(cells))


def contact_dataset(result: Pictured) -> pyvista.PolyData:
    """:func:`contact_mesh` with all fields; their units are its ``user_dict["units"]``."""
    contact = contact_mesh(result)
    data = contact.cell_data if patches(result) else contact.point_data
    fields = {name: field for name, field in result.fields().items() if name != "points"}
    for name, field in fields.items():
        data[name] = np.ascontiguousarray(flat(result, field.values).T)
    contact.user_dict = {"units": {name: field.unit for name, field in fields.items() if field.unit}}
    contact.set_active_scalars("pressure")
    return contact


def datasets(result: Pictured) -> pyvista.MultiBlock:
    """A result as a dataset of pyvista; see :meth:`mtb_rs.Result.to_pyvista`."""
    try:
        import pyvista
    except ImportError as error:
        raise ImportError("pyvista is missing: pip install 'mtb-rs[viz]'") from error
    found = pyvista.MultiBlock({"contact": contact_dataset(result)})
    for surface in bodies(result):
        if surface.von_mises is None:
            found[surface.name] = body_mesh(surface)
    for name, solid in solid_meshes(result).items():
        solid.user_dict = {"units": {"displacement": "m", "stress": "Pa", "von_mises": "Pa"}}
        solid.set_active_scalars("von_mises")
        found[name] = solid
    return found


def _places(result: Pictured) -> Array:
    """The contact points (3, n) [m]; those of a height field in the plane z = 0."""
    points = flat(result, result.points)
    return points if len(points) == 3 else np.concatenate([points, np.zeros((1, points.shape[1]))])


def bodies(result: Pictured) -> tuple[Surface, ...]:
    """The bodies for pictures: finite elements with their displacement, half-spaces without.

    Costs one back-substitution for each elastic body. A body known by its half is shown whole.
    """
    return _bodies(result, result.solids())


def _bodies(result: Pictured, solids: Sequence[Solid]) -> tuple[Surface, ...]:
    elastic: dict[str, list[Surface]] = {"upper": [], "lower": []}
    for solid in solids:
        side = elastic["upper" if solid.upper else "lower"]
        side.append(solid.surface)
        if solid.is_half:
            side.append(_mirrored(solid.surface))
    rest = [s for s in result.surfaces if not any(elastic[k] and s.name.startswith(k) for k in elastic)]
    return (*rest, *elastic["lower"], *elastic["upper"])


def _mirrored(surface: Surface) -> Surface:
    flip = np.array([[1.0], [-1.0], [1.0]])
    moved = None if surface.displacement is None else flip * surface.displacement
    name, vertices = f"{surface.name} mirrored", flip * surface.vertices
    return Surface(name, vertices, surface.triangles[:, ::-1], moved, surface.von_mises)


def solid_meshes(result: Pictured) -> dict[str, pyvista.UnstructuredGrid]:
    """The elastic bodies by name, with displacement [m], stress and von Mises' stress [Pa] at their nodes.

    Stress in VTK's order: xx, yy, zz, xy, yz, xz. A body known by its half comes as two halves.
    """
    import pyvista

    solids = {}
    for solid in result.solids():
        mesh, u, stress = solid.mesh, solid.displacement, solid.stress[[0, 1, 2, 5, 3, 4]]
        halves = [(solid.name, mesh, u, stress)]
        if solid.is_half:
            flip = np.array([[1.0], [-1.0], [1.0]])
            # the mirror turns round the shear stresses on planes normal to y
            turned = np.array([1.0, 1.0, 1.0, -1.0, -1.0, 1.0])[:, None]
            halves.append((f"{solid.name} mirrored", mesh.mirrored(), flip * u, turned * stress))
        kind = pyvista.CellType.QUADRATIC_TETRA if mesh.is_quadratic else pyvista.CellType.TETRA
        for name, half, moved, stressed in halves:
            solids[name] = pyvista.UnstructuredGrid({kind: half.cells}, half.nodes)
            for field, values in (("displacement", moved), ("stress", stressed)):
                solids[name].point_data[field] = np.ascontiguousarray(values.T)
            solids[name].point_data["von_mises"] = solid.von_mises
    return solids


def body_mesh(surface: Surface, scale: float = 0.0) -> pyvista.PolyData:
    """A body's surface as triangles, moved by `scale` times its displacement where it has one."""
    import pyvista

    vertices = surface.vertices
    if surface.displacement is not None:
        vertices = vertices + scale * surface.displacement
    return pyvista.PolyData.from_regular_faces(vertices.T, surface.triangles)


def _closed(surface: Surface, contact: Array) -> Surface:
    """A body for a picture: where it has come to along z, with the displacement from there.

    Bodies that were modelled apart close by more than they deform, and what is exaggerated is the
    deformation. A body has come as far as the mean of its end at the contact.
    """
    if surface.displacement is None:
        return surface
    z = surface.vertices[2] if _is_upper(surface, contact) else -surface.vertices[2]
    come = np.zeros((3, 1))
    come[2] = surface.displacement[2, z <= z.min() + _CONTACT_END * np.ptp(z)].mean()
    return replace(surface, vertices=surface.vertices + come, displacement=surface.displacement - come)


def _lay_on(patch: pyvista.PolyData, body: pyvista.PolyData) -> None:
    """Lays the points of a patch along z on a body that is drawn; where it is not, they stay."""
    from vtkmodules.vtkCommonCore import mutable
    from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator

    locator = vtkStaticCellLocator()
    locator.SetDataSet(body)
    locator.BuildLocator()
    low, high = min(body.bounds[4], patch.bounds[4]), max(body.bounds[5], patch.bounds[5])
    room = 0.01 * (high - low) + 1e-9
    points = np.array(patch.points)
    # mutable numbers of VTK, whose stubs ask for plain ones
    share: Any = mutable(0.0)
    cell: Any = mutable(0)
    at, local = [0.0] * 3, [0.0] * 3
    for point in points:
        above, beneath = (*point[:2], high + room), (*point[:2], low - room)
        if locator.IntersectWithLine(above, beneath, 0.0, share, at, local, cell):
            point[2] = at[2]
    patch.points = points


def vtk_bytes(mesh: pyvista.DataSet) -> bytes:
    """A mesh as VTK's XML files hold it, made in memory: VTK itself ends the process on a full disk."""
    import pyvista
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

    is_surface = isinstance(mesh, pyvista.PolyData)
    writer = vtkXMLPolyDataWriter() if is_surface else vtkXMLUnstructuredGridWriter()
    writer.SetInputData(mesh)
    writer.SetDataModeToBinary()
    writer.WriteToOutputStringOn()
    if not writer.Write():
        raise MemoryError(f"VTK cannot make a file of {mesh.n_points} points in memory")
    text: str = writer.GetOutputString()
    return text.encode()


def write_html(result: Drawn, path: str | Path, quantity: Word | Stress = "pressure", **options: Any) -> Path:
    """The 3-D view as one page with everything in it: it opens in a browser, without a server.

    Parameters
    ----------
    result
        Whatever ``result.plot(quantity, "3d")`` draws.
    quantity, **options
        As of this picture.
    path : str or Path
        Of the page.

    Raises
    ------
    ValueError
        If the result has no such picture, with the reason.
    ViewError
        Without the packages trame-pyvista and nest-asyncio2, pyvista or a GL driver; names what to install.
    OSError
        If nothing can be written there.
    """
    target = check_target(path)
    drawn: Any = as_drawn(result)
    page = page_of(drawn.plot(quantity, "3d", off_screen=True, **options), quantity)
    write_bytes(target, page.encode())
    return target


def page_of(plotter: pyvista.Plotter, quantity: str) -> str:
    """A view of a quantity as one page; the view is closed."""
    try:
        with _signals_as_they_were(), _without_download():
            page: str = plotter.trame.export_html(None).getvalue()
    except (ImportError, AttributeError) as error:
        raise ViewError(
            "the HTML page needs trame-pyvista and nest-asyncio2: pip install 'mtb-rs[html]'"
        ) from error
    finally:
        plotter.close()
    # the viewer's own title says nothing of what is seen
    title = f"<title>{html.escape(quantity.replace('_', ' '))} - mtb_rs</title>"
    return re.sub("<title>.*?</title>", lambda _: title, page, count=1)


@contextmanager
def _without_download() -> Iterator[None]:
    """Hides the viewer that the server fetches from the network when it begins: a page has no use for it."""
    hidden = "trame.widgets.vtklocal"
    if hidden in sys.modules:
        yield
        return
    sys.modules[hidden] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        del sys.modules[hidden]


@contextmanager
def _signals_as_they_were() -> Iterator[None]:
    """The server that writes a page takes Ctrl-C for itself and keeps it: give it back."""
    if threading.current_thread() is not threading.main_thread():
        yield  # handlers can be set in the main thread only
        return
    kept = {which: signal.getsignal(which) for which in (signal.SIGINT, signal.SIGTERM)}
    wakes = signal.set_wakeup_fd(-1)
    try:
        yield
    finally:
        for which, handler in kept.items():
            if handler is not None:
                signal.signal(which, handler)
        signal.set_wakeup_fd(wakes)


def _bar(title: str) -> dict[str, Any]:
    return {
        "title": title + "\n",
        "color": "#333333",
        "vertical": True,
        "position_x": 0.89,
        "position_y": 0.25,
        "width": 0.05,
        "height": 0.5,
        "title_font_size": 21,
        "label_font_size": 20,
        "fmt": "%.3g",
    }


def _add_body(plotter: pyvista.Plotter, surface: Surface, contact: Array, scale: float) -> pyvista.PolyData:
    """Lower bodies solid, upper ones as their edges: nothing lies over the colours of the patch between."""
    mesh = body_mesh(surface, scale)
    upper = _is_upper(surface, contact)
    if not upper:
        mesh = _around(mesh, contact)
        plotter.add_mesh(
            mesh,
            color=_BODY_COLOUR,
            smooth_shading=True,
            split_sharp_edges=True,
            feature_angle=35.0,
            specular=0.2,
        )
    _add_outline(plotter, mesh)
    _add_label(plotter, surface, mesh, upper=upper)
    return mesh


def _is_upper(surface: Surface, contact: Array) -> bool:
    for side in ("upper", "lower"):
        if surface.name.startswith(side):
            return side == "upper"
    z = surface.vertices[2]
    return bool(z.max() - contact[2].max() > contact[2].min() - z.min())


def _add_outline(plotter: pyvista.Plotter, mesh: pyvista.PolyData) -> None:
    """The edges of a body; of a smooth one a few of its lines."""
    edges = mesh.extract_feature_edges(feature_angle=35.0, manifold_edges=False, non_manifold_edges=False)
    if edges.n_points:
        plotter.add_mesh(edges, color=_EDGE_COLOUR, line_width=1.5, lighting=False)
    else:
        plotter.add_mesh(mesh, style="wireframe", color=_EDGE_COLOUR, opacity=0.15, lighting=False)


def _add_label(plotter: pyvista.Plotter, surface: Surface, mesh: pyvista.PolyData, *, upper: bool) -> None:
    """The name of a body: at the back of its top, or under the front of a lower one."""
    if surface.name.endswith(" mirrored"):
        return
    (back, front), (near, far), (bottom, top) = np.array(mesh.bounds).reshape(3, 2)
    place = (back, far, top) if upper else (front, near, bottom)
    plotter.add_point_labels(
        np.array([place]),
        [surface.label],
        show_points=False,
        shape="rounded_rect",
        shape_color="white",
        shape_opacity=0.75,
        margin=4,
        always_visible=True,
        font_size=26,
        text_color=_INK,
        bold=False,
    )


def _around(mesh: pyvista.PolyData, contact: Array) -> pyvista.PolyData:
    """What of a long or deep body lies around the contact: the rest would only take room."""
    low, high = contact.min(axis=1), contact.max(axis=1)
    room = 0.35 * float((high - low).max())
    for axis, (first, last) in enumerate(zip(low - room, high + room, strict=True)):
        for value, sign in ((first, 1.0), (last, -1.0)):
            if not mesh.bounds[2 * axis] < value < mesh.bounds[2 * axis + 1]:
                continue
            origin, normal = np.zeros(3), np.zeros(3)
            origin[axis], normal[axis] = value, sign
            # a closed body stays closed
            closed = mesh.is_manifold
            cut = mesh.clip_closed_surface if closed else partial(mesh.clip, invert=False)
            mesh = cut(normal=normal, origin=origin)
            mesh = mesh.extract_surface(algorithm=None).triangulate() if not closed else mesh
    return mesh


def _default_scale(surfaces: tuple[Surface, ...], result: Pictured) -> float:
    largest = max(
        (float(np.abs(s.displacement).max()) for s in surfaces if s.displacement is not None), default=0.0
    )
    if largest <= 0.0:
        return 0.0
    span = float(np.ptp(_places(result), axis=1).max())
    wanted = 0.05 * span / largest
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(power * max(step for step in (1, 2, 5) if step * power <= wanted * (1 + 1e-12)))

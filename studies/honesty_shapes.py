# SPDX-License-Identifier: MIT OR Apache-2.0
"""Is the error estimate of scenes with an ``ElasticBody`` honest beyond blocks? Over bodies of other shapes.

Cylinders, spheres, wedges, leaning and sloping blocks, round pins: as grids, STEP solids and closed
surfaces, on half-spaces, rigid planes, other elastic bodies and given gaps, above and below. The truth is
the same scene on cells half as wide, on a finer mesh made in another way: by gmsh's HXT in place of a grid,
by a grid of even layers in place of gmsh. Nothing of the estimate was fitted to these scenes. Run from the
root of the project: ``python studies/honesty_shapes.py``.
"""

from __future__ import annotations

import sys
import tempfile
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from other_meshes import box, filled

import mtb_rs as mtb
from mtb_rs.chart_scene import fields_of
from mtb_rs.mesh import TetraMesh, quadratic, tetrahedra
from mtb_rs.mesher import gmsh_beside

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Shape:
    """A body over a rectangle of `width` by `length` (a disk for a pin), from its foot to its top [m].

    Attributes
    ----------
    kind : "flat", "cylinder", "sphere", "wedge" or "pin"
        Of the foot: of `radius` [m], or rising with `slope` to both sides.
    lean : float
        Shift along x over the height.
    fall : float
        Slope of the top along x.
    """

    kind: str = "flat"
    width: float = 0.04
    length: float = 0.04
    height: float = 0.03
    radius: float = 4.0
    slope: float = 5e-4
    lean: float = 0.0
    fall: float = 0.0

    def foot(self, x: Array, y: Array) -> Array:
        """Height of the foot at x, y."""
        if self.kind in ("flat", "pin"):
            return 0.0 * x
        if self.kind == "wedge":
            return np.asarray(self.slope * np.abs(x))
        square = x**2 + (y**2 if self.kind == "sphere" else 0.0)
        return np.asarray(self.radius - np.sqrt(self.radius**2 - square))

    def placed(self, nodes: Array) -> Array:
        """Points (n, 3) of the box over the rectangle, one metre high, in the body."""
        x, y, share = nodes.T
        low = self.foot(x, y)
        z = low + share * (self.height + self.fall * x - low)
        return np.stack([x + self.lean * z, y, z], axis=1)

    def solid(self, occ: Any) -> None:
        """The same in gmsh's OpenCASCADE [mm]."""
        w, long, h, r = (1e3 * v for v in (self.width, self.length, self.height, self.radius))
        if self.kind == "pin":
            occ.addCylinder(0.0, 0.0, 0.0, 0.0, 0.0, h, 0.5 * w)
            return
        top = [(s * 0.5 * w + self.lean * z, z) for s in (1, -1) for z in [h + s * 0.5 * w * self.fall]]
        rise = 0.5 * w * self.slope if self.kind == "wedge" else 0.0
        foot = [(-0.5 * w, rise), (0.0, 0.0), (0.5 * w, rise)] if rise else [(-0.5 * w, 0.0), (0.5 * w, 0.0)]
        points = [occ.addPoint(x, -0.5 * long, z) for x, z in foot + top]
        lines = [occ.addLine(a, b) for a, b in zip(points, [*points[1:], points[0]], strict=True)]
        made = occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))], 0.0, long, 0.0)
        body = next(part for part in made if part[0] == 3)
        if self.kind == "cylinder":
            occ.intersect([body], [(3, occ.addCylinder(0.0, -long, r, 0.0, 2.0 * long, 0.0, r))])
        elif self.kind == "sphere":
            occ.intersect([body], [(3, occ.addSphere(0.0, 0.0, r, r))])

    def grid(self, elements: int, layers: int, *, power: float = 1.0, curved: bool = True) -> TetraMesh:
        """A grid of hexahedra cut up, its layers growing with a `power`."""
        x = np.linspace(-0.5, 0.5, elements + 1) * self.width
        count = 2 * max(1, round(0.5 * elements * self.length / self.width))
        y = np.linspace(-0.5, 0.5, count + 1) * self.length
        corners = np.stack(np.meshgrid(x, y, np.linspace(0, 1, layers + 1) ** power, indexing="ij"), axis=-1)
        nodes, cells, _ = tetrahedra(corners, flipped=(x[1:] > 1e-12, y[1:] > 1e-12), quadratic=curved)
        return TetraMesh(self.placed(nodes), cells)

    def by_gmsh(self, size: float) -> TetraMesh:
        """Unstructured tetrahedra of `size` [m] at the foot."""
        if self.kind == "pin":
            return filled(self.solid, f"{1e3 * size} + 0.15 * z")
        half = np.array([0.5 * self.width, 0.5 * self.length])
        # a cut where a wedge has its kink
        cut = None
        if self.kind == "wedge":
            flat = box(
                np.array([-half[1], -half[0], 0.0]), np.array([half[1], half[0], self.height]), size, 0.0
            )
            nodes = flat.nodes[:, [1, 0, 2]] * [-1.0, 1.0, 1.0 / self.height]
        else:
            flat = box(np.array([*-half, 0.0]), np.array([*half, self.height]), size, cut)
            nodes = flat.nodes * [1.0, 1.0, 1.0 / self.height]
        return TetraMesh(self.placed(nodes), flat.cells)


@dataclass(frozen=True)
class Case:
    """A scene of the family.

    Attributes
    ----------
    made : "grid", "step" or "surface"
        How the body comes to be.
    elements, cells : int
        Over the width, of the mesh and of the contact.
    top : "pressed", "clamped" or "driven"
        A guide that presses; clamped or free to rise and tilt under a pull.
    pressure : float [Pa]
        What presses it, over its width and length.
    other : "steel", "rigid" or "body"
        On the other side; a body is a block twice as wide, held at its end.
    below : bool
        Whether the body is the lower one.
    gap : float or None [m]
        Radius of a given gap along x.
    """

    shape: Shape
    made: str = "grid"
    elements: int = 6
    cells: int = 10
    top: str = "pressed"
    pressure: float = 20e6
    friction: float = 0.2
    ratio: float = 0.3
    other: str = "steel"
    below: bool = False
    gap: float | None = None

    def scene(self, *, fine: bool = False) -> mtb.Scene:
        """The scene as it is, or as its truth is found."""
        shape = self.shape
        body = self._body(shape, self.made, self._supports(), "shape", fine=fine)
        other: Any = {"steel": mtb.steel, "rigid": mtb.Rigid()}.get(self.other)
        if other is None:
            block = Shape(width=2.0 * shape.width, length=2.0 * shape.length, height=shape.height)
            held = [mtb.Support(_top(block, turned=True), x=0, y=0, z=0)]
            other = self._body(
                block, "step" if self.made == "grid" else "grid", held, "base", fine=fine, turned=True
            )
        bodies: tuple[Any, Any] = (other, body) if self.below else (body, other)
        gap = None if self.gap is None else lambda x, y: x**2 / (2.0 * self.gap)
        load = {"magnetic_pressure": self.pressure} if self.top != "pressed" else {}
        spacing = shape.width / self.cells / (2 if fine else 1)
        return mtb.Scene(bodies[0], bodies[1], gap=gap, spacing=spacing, friction=self.friction, **load)

    def _supports(self) -> list[mtb.Support]:
        top = _top(self.shape, turned=self.below)
        force = self.pressure * self.shape.width * self.shape.length * (-1.0 if not self.below else 1.0)
        z: Any = {"pressed": mtb.Guide(force), "clamped": 0.0, "driven": None}[self.top]
        return [mtb.Support(top, x=0, y=0, z=z)]

    def _body(
        self,
        shape: Shape,
        made: str,
        held: list[mtb.Support],
        name: str,
        *,
        fine: bool,
        turned: bool | None = None,
    ) -> mtb.ElasticBody:
        turned = self.below if turned is None else turned
        material = mtb.Material(208e9, self.ratio)
        face = _foot(shape, turned=turned)
        count = self.elements
        cell = self.shape.width / self.cells
        if fine:
            layers = max(6, round(1.5 * self.cells * shape.height / shape.width))
            mesh = shape.by_gmsh(0.7 * cell) if made == "grid" else shape.grid(self.cells + 4, layers)
            if shape.kind == "pin":
                mesh = shape.by_gmsh(0.5 * cell)
        elif made == "grid":
            layers = max(3, round(0.8 * count * shape.height / shape.width))
            mesh = shape.grid(count, layers, power=1.4)
        else:
            return self._from_cad(shape, made, held, name, turned=turned)
        return mtb.ElasticBody(_turned(mesh, turned), material, face, held, name)

    def _from_cad(
        self, shape: Shape, made: str, held: list[mtb.Support], name: str, *, turned: bool
    ) -> mtb.ElasticBody:
        size = self.shape.width / self.elements
        material, face = mtb.Material(208e9, self.ratio), _foot(shape, turned=turned)
        if made == "surface":
            whole = _turned(shape.grid(2, 1, curved=False), turned)
            surface = mtb.ElasticBody(quadratic(whole), material, face, [], name).surface()
            source: Any = trimesh.Trimesh(surface.vertices.T, surface.triangles)
            return mtb.ElasticBody.from_mesh(
                source, material, contact=face, supports=held, size=size, name=name
            )
        with tempfile.TemporaryDirectory() as folder, gmsh_beside() as gmsh:
            path = Path(folder) / "body.step"
            shape.solid(gmsh.model.occ)
            if turned:
                gmsh.model.occ.rotate(gmsh.model.occ.getEntities(3), 0, 0, 0, 1, 0, 0, np.pi)
            gmsh.model.occ.synchronize()
            gmsh.write(str(path))
            return mtb.ElasticBody.from_mesh(
                path, material, contact=face, supports=held, size=size, name=name
            )


def _turned(mesh: TetraMesh, turned: bool) -> TetraMesh:
    """Upside down, about the x axis."""
    return mesh.moved(np.diag([1.0, -1.0, -1.0])) if turned else mesh


def _foot(shape: Shape, *, turned: bool) -> Callable[[Array], Array]:
    sign = -1.0 if turned else 1.0

    def on(points: Array) -> Array:
        z = sign * points[2]
        return np.asarray(z < shape.foot(points[0] - shape.lean * z, points[1]) + 1e-7)

    return on


def _top(shape: Shape, *, turned: bool) -> Callable[[Array], Array]:
    sign = -1.0 if turned else 1.0

    def on(points: Array) -> Array:
        z = sign * points[2]
        return np.asarray(z > shape.height + shape.fall * (points[0] - shape.lean * z) - 1e-6)

    return on


CYLINDER, SPHERE = Shape("cylinder"), Shape("sphere")
CASES = (
    Case(CYLINDER, cells=16, elements=10, pressure=60e6),
    Case(CYLINDER, "step", elements=8, cells=16, pressure=60e6, other="rigid"),
    Case(CYLINDER, elements=8, cells=12, pressure=40e6, below=True),
    Case(CYLINDER, "step", other="body", elements=8, pressure=60e6, friction=0.3),
    Case(Shape("cylinder", radius=2.0, length=0.06), elements=10, cells=14, pressure=50e6),
    Case(SPHERE, elements=12, cells=20, pressure=50e6),
    Case(SPHERE, "step", elements=10, cells=20, pressure=50e6, other="rigid", friction=0.4),
    Case(
        Shape("sphere", radius=20.0),
        other="body",
        elements=8,
        cells=14,
        top="driven",
        pressure=10e6,
        friction=0.05,
    ),
    Case(SPHERE, "step", elements=8, cells=16, pressure=50e6, below=True, ratio=0.45),
    Case(Shape("wedge"), elements=6, cells=12),
    Case(Shape("wedge"), "step", elements=8, cells=12, other="rigid"),
    Case(Shape("wedge", slope=4e-4), other="body", elements=6, friction=0.1),
    Case(Shape(lean=0.3), top="clamped", pressure=3e6, friction=0.3),
    Case(Shape(lean=0.3), "step", elements=5, top="clamped", pressure=3e6, other="rigid"),
    Case(Shape(lean=-0.2, height=0.06), "surface", elements=5, cells=8, top="clamped", pressure=3e6),
    Case(Shape(fall=0.3), "surface", elements=5, friction=0.4),
    Case(Shape(fall=0.3), elements=6, other="body", top="clamped", pressure=3e6),
    Case(Shape(), gap=8.0, pressure=40e6, friction=0.3),
    Case(Shape(), "step", elements=5, gap=10.0, pressure=30e6, other="rigid"),
    Case(Shape(), "surface", elements=8, gap=6.0, pressure=40e6, below=True),
    Case(Shape("pin"), "step", elements=8, cells=12),
    Case(Shape("pin", height=0.06), "step", other="rigid", friction=0.3, top="clamped", pressure=3e6),
    Case(Shape("pin"), "step", gap=10.0, pressure=40e6, below=True),
    Case(Shape(height=0.015, length=0.06), "step", elements=8, top="driven", pressure=3e6, friction=0.1),
    Case(Shape(width=0.02, height=0.05), "step", 4, 8, top="clamped", pressure=3e6, friction=0.15, ratio=0.4),
)


def examine(case: Case) -> dict[str, tuple[float, float]]:
    """Estimate and truth of each quantity."""
    with warnings.catch_warnings():
        # meshes coarser than the grid are meant here
        warnings.simplefilter("ignore", UserWarning)
        scene, fine = case.scene(), case.scene(fine=True)
        found, true = scene.solve(), fine.solve()
    own, exact = (fields_of(s, r, s.spacing) for s, r in ((scene, found), (fine, true)))
    errors = own.errors(exact, skip_border=True)
    return {name: (found.report.error_estimates[name], errors[name]) for name in errors}


def is_honest(said: dict[str, tuple[float, float]]) -> bool:
    """Whether each truth is within twice the estimate; what is given has no error but rounding."""
    return all(truth <= max(2.0 * estimate, 1e-6) for estimate, truth in said.values())


if __name__ == "__main__":
    chosen = [int(word) for word in sys.argv[1:]] or range(len(CASES))
    honest = 0
    for number in chosen:
        said = examine(CASES[number])
        honest += is_honest(said)
        words = ", ".join(f"{name}: estimate {e:.4f}, truth {t:.4f}" for name, (e, t) in said.items())
        print(f"{number} {'honest' if is_honest(said) else 'NOT'} {CASES[number]}: {words}", flush=True)
    print(f"within twice the estimate: {honest} of {len(chosen)}")

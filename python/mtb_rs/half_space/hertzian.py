# SPDX-License-Identifier: MIT OR Apache-2.0
"""Contact of smooth bodies in closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import positive, whole
from ..base.owning import solved
from ..base.plain import plain
from ..base.questions import ask
from ..base.stored import stored
from ..base.told import Row, in_words, length
from ..base.units import taking_quantities
from ..bodies.material import Material, of_material, steel
from ..bodies.simple import Simple, as_body, without_layers
from ..results.plausible import of_dent
from ..results.report import Report
from ..results.result import Drawn
from ..results.stressed import Loads, Stressed
from .ellipse import axis_ratio, curvatures, elliptic_integrals
from .normal import NormalResult, centres

Array = NDArray[np.float64]

#: Short semi-axis over the relative radius up to which half-spaces stand for curved bodies.
WIDEST = 0.2
#: Cells along each axis of the grid on which it is drawn; an odd number has one in the middle.
CELLS = 81


@stored
@solved
@dataclass(frozen=True)
@plain
class Hertz(Stressed, Drawn):
    """Contact of two smooth bodies with curvatures along x and y [Hertz1882].

    Pictures, fields and files show it :meth:`on_grid`, 81 x 81 cells over the contact ellipse and a tenth
    around it, and its :meth:`stress` is that of the pressure on these.

    Attributes
    ----------
    force : float [N]
    semi_axes : (float, float) [m]
        Of the contact ellipse, along x and along y.
    peak_pressure : float [Pa]
    approach : float [m]
    curvatures : (float, float) [1/m]
        Relative: the undeformed gap is x^2 / 2 times the first plus y^2 / 2 times the second.
    lower, upper : HalfSpace or Rigid
    """

    force: float
    semi_axes: tuple[float, float]
    peak_pressure: float
    approach: float
    curvatures: tuple[float, float]
    lower: Simple
    upper: Simple

    def _picture(self) -> NormalResult:
        a, b = self.semi_axes
        return self.on_grid((CELLS, CELLS), (2.2 * a / CELLS, 2.2 * b / CELLS))

    def _loads(self) -> Loads:
        return self._picture()._loads()

    def _kept(self) -> Hertz:
        return replace(self, lower=self.lower.kept(), upper=self.upper.kept())

    def facts(self) -> dict[str, Any]:
        """What else its `summary.json` holds: the closed form."""
        return {
            "semi_axes": self.semi_axes,
            "peak_pressure": self.peak_pressure,
            "curvatures": self.curvatures,
            "lower": self.lower,
            "upper": self.upper,
            **self._picture().facts(),
        }

    def told(self) -> list[Row]:
        """The closed form in words."""
        a, b = self.semi_axes
        return [
            ("normal force", in_words(self.force, "N")),
            ("semi-axes", f"{length(a)} along x, {length(b)} along y"),
            ("peak pressure", f"{self.peak_pressure / 1e6:.5g} MPa"),
            ("approach", length(self.approach)),
        ]

    @property
    def contact_area(self) -> float:
        """Area of the contact ellipse [m2]."""
        return math.pi * self.semi_axes[0] * self.semi_axes[1]

    def pressure(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Pressure [Pa] at the points `x`, `y` [m] from the centre."""
        a, b = self.semi_axes
        u, v = np.asarray(x, dtype=float) / a, np.asarray(y, dtype=float) / b
        return np.asarray(self.peak_pressure * np.sqrt(np.maximum(1.0 - u * u - v * v, 0.0)))

    def gap(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Undeformed gap [m] at the points `x`, `y` [m] from the centre."""
        x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        return np.asarray(0.5 * (self.curvatures[0] * x * x + self.curvatures[1] * y * y))

    def on_grid(self, shape: tuple[int, int], spacing: float | tuple[float, float]) -> NormalResult:
        """The contact on a grid of `shape` (ny, nx), centred, with `spacing` [m], as from a solver.

        Pressures are values at the cell centres, scaled to carry the force exactly.

        Raises
        ------
        ValueError
            Where the contact ellipse reaches beyond the grid by more than half a cell, and where no cell is
            in contact.
        """
        ny, nx = whole("shape[0]", shape[0]), whole("shape[1]", shape[1])
        dx, dy = _two("spacing", spacing)
        for axis, cells, side, semi in (("x", nx, dx, self.semi_axes[0]), ("y", ny, dy, self.semi_axes[1])):
            # cells whose centres are outside are open
            if 0.5 * (cells + 1) * side < semi:
                raise ValueError(
                    f"the contact ellipse reaches beyond the grid along {axis}: its semi-axis is {semi:g} m, "
                    f"and half of {cells} cells of {side:g} m are {0.5 * cells * side:g} m; shape is (ny, nx)"
                )
        points = centres((ny, nx), (dx, dy))
        x, y = points[0], points[1]
        pressure = self.pressure(x, y)
        carried = float(pressure.sum()) * dx * dy
        if carried <= 0.0:
            raise ValueError(f"no cell centre of a {nx} x {ny} grid, {dx:g} x {dy:g} m each, is in contact")
        pressure *= self.force / carried
        gap = np.where(pressure > 0.0, 0.0, self.separation(x, y))
        report = Report(
            converged=True,
            status="closed form",
            model="half-space",
            method="direct",
            solver="closed form of Hertz",
            iterations=0,
            residual=0.0,
            contact_area=self.contact_area,
            peak_pressure=self.peak_pressure,
        )
        return NormalResult(
            points=points,
            area=np.full((ny, nx), dx * dy),
            spacing=(dx, dy),
            pressure=pressure,
            gap=gap,
            initial_gap=self.gap(x, y),
            status=(pressure > 0.0).astype(np.int8),
            approach=self.approach,
            tilts=(0.0, 0.0),
            normal_force=self.force,
            contact_area=self.contact_area,
            lower=self.lower,
            upper=self.upper,
            periodic=False,
            error_estimate=None,
            report=report,
        )

    def separation(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Deformed gap [m] outside of the contact, zero inside.

        The potential of the elliptic pressure is an integral over the confocal ellipses outside of the
        point [Johnson1985, eq. 3.33], taken by Gauss' rule.
        """
        x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        a2, b2 = (s * s for s in self.semi_axes)
        # the confocal ellipse through the point: x^2 / (a^2 + w) + y^2 / (b^2 + w) = 1
        half = 0.5 * (x * x + y * y - a2 - b2)
        rest = x * x * b2 + y * y * a2 - a2 * b2
        through = np.maximum(half + np.sqrt(np.maximum(half * half + rest, 0.0)), 0.0)
        through = np.where(rest > 0.0, through, 0.0)
        # w = through + c^2 tan^2(t): a smooth integrand on a finite range
        nodes, weights = np.polynomial.legendre.leggauss(40)
        t = 0.25 * math.pi * (nodes + 1.0)
        scale = np.sqrt(a2 + b2 + through)[..., None]
        tangent = np.tan(t)
        w = through[..., None] + (scale * tangent) ** 2
        step = 2.0 * scale**2 * tangent * (1.0 + tangent**2) * (0.25 * math.pi * weights)
        shape = 1.0 - x[..., None] ** 2 / (a2 + w) - y[..., None] ** 2 / (b2 + w)
        integral = np.sum(shape * step / np.sqrt((a2 + w) * (b2 + w) * w), axis=-1)
        stiffness = modulus(self.lower, self.upper)
        displacement = 3.0 * self.force / (4.0 * math.pi * stiffness) * integral
        outside = np.where(rest > 0.0, self.gap(x, y) + displacement - self.approach, 0.0)
        return np.asarray(np.maximum(outside, 0.0))


def modulus(lower: Simple, upper: Simple) -> float:
    """Contact modulus E* [Pa] of two bodies: 1 / E* is the sum of (1 - nu^2) / E."""
    compliance = lower.plane_strain_compliance + upper.plane_strain_compliance
    if compliance == 0.0:
        raise ValueError("both bodies are rigid: one of them must be elastic")
    return 1.0 / compliance


@taking_quantities
def hertz(
    force: float,
    radii: float | tuple[float, float] | None = None,
    lower: Material | Simple = steel,
    upper: Material | Simple = steel,
    *,
    semi_axes: tuple[float, float] | None = None,
) -> Hertz:
    """Hertz' contact, circular or elliptic, from the radii of curvature or from the contact ellipse.

    Parameters
    ----------
    force : float [N]
    radii : float or (float, float) [m]
        Relative radii of curvature of the gap, along x and along y: 1 / R = 1 / R_lower + 1 / R_upper.
    semi_axes : (float, float) [m]
        Instead of `radii`: the semi-axes of the contact, along x and along y.
    lower, upper : Material, HalfSpace or Rigid

    Moduli that no material has, and contacts that are not small against the radius, give a warning.

    References
    ----------
    [Hertz1882], [Johnson1985, ch. 4]

    Examples
    --------
    >>> import mtb_rs as mtb
    >>> contact = mtb.hertz(1e3, 0.5, lower=mtb.steel, upper=mtb.steel)
    >>> round(contact.peak_pressure / 1e6)
    216
    """
    force = positive("force", force, "N")
    below, above = without_layers([as_body("lower", lower), as_body("upper", upper)], "Hertz' contact")
    bodies = below, above
    stiffness = modulus(*bodies)
    if (radii is None) == (semi_axes is None):
        raise ValueError("either radii or semi_axes is needed")
    if semi_axes is not None:
        axes = _two("semi_axes", semi_axes)
        slim = min(axes) / max(axes)
    else:
        assert radii is not None
        radius = _two("radii", radii)
        slim = axis_ratio(max(radius) / min(radius))
        # curvature across the short axis, the larger one, fixes the size
        larger = 1.0 / min(radius)
        long = math.cbrt(3.0 * force * curvatures(slim)[1] / (math.pi * stiffness * larger))
        axes = (slim * long, long) if radius[0] < radius[1] else (long, slim * long)
    long = max(axes)
    peak = 1.5 * force / (math.pi * axes[0] * axes[1])
    materials = [body.material for body in bodies]
    load = 3.0 * force / (math.pi * stiffness * long**3)
    along, across = (load * k for k in curvatures(slim))
    approach = 0.5 * load * long**2 * elliptic_integrals(slim)[0]
    ask([*_questions(bodies, 1.0 / max(across, along), min(axes), approach), *of_dent(peak, materials)])
    return Hertz(
        force=force,
        semi_axes=axes,
        peak_pressure=peak,
        approach=approach,
        curvatures=(across, along) if axes[0] < axes[1] else (along, across),
        lower=bodies[0],
        upper=bodies[1],
    )


def _questions(bodies: tuple[Simple, Simple], radius: float, short: float, approach: float) -> list[str]:
    """Questions about moduli, and about a contact that is not small against the radius of the bodies [m]."""
    materials = {"lower": bodies[0].material, "upper": bodies[1].material}
    asked = [words for side, of in materials.items() if of is not None for words in of_material(side, of)]
    if short > WIDEST * radius:
        asked.append(
            f"the semi-axis of the contact is {short:.3g} m and the approach {approach:.3g} m, where the "
            f"relative radius of curvature is {radius:.3g} m: Hertz' theory holds for contacts that "
            f"are small against that radius (below about {WIDEST:g} of it), and moduli are in pascals, "
            "lengths in metres"
        )
    return asked


def _two(name: str, value: float | tuple[float, float]) -> tuple[float, float]:
    """One positive number for both directions, or two."""
    if np.ndim(value) == 0:
        number = positive(name, value, "m")
        return number, number
    try:
        first, second = value  # type: ignore[misc]
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {value!r}: one or two positive numbers [m] are needed") from None
    return positive(f"{name}[0]", first, "m"), positive(f"{name}[1]", second, "m")

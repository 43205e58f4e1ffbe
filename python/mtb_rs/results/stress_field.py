# SPDX-License-Identifier: MIT OR Apache-2.0
"""Stress inside a body: plain arrays, what follows from them, pictures and files."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import choice, number, reals
from ..base.owning import solved
from ..base.plain import plain
from ..base.stored import stored
from ..base.told import Row, length
from ..base.words import Along, Body, StressPart
from .doors import pictures, png
from .study import Study

if TYPE_CHECKING:
    import pyvista  # noqa: TID251 (only for type checkers)
    import xarray

Array = NDArray[np.float64]

#: Components of a stress, in the order of :attr:`StressField.stress`.
COMPONENTS = ("xx", "yy", "zz", "yz", "xz", "xy")
#: What there is to draw of a stress, in words.
LABELS: dict[str, str] = {
    **{name: f"stress {name}" for name in COMPONENTS},
    "von_mises": "von Mises stress",
    "tresca": "Tresca stress",
    "largest_shear": "largest shear stress",
    "largest_principal": "largest principal stress",
    "hydrostatic": "hydrostatic stress",
}


@stored
@solved
@dataclass(frozen=True, repr=False)
@plain
class StressField(Study):
    """Stress inside a body, of ``stress()`` of a result.

    Tension is positive. Axes are those of the result: x and y along the surface, z from the lower to the
    upper body, so that the inside of the lower body has z < 0 and that of the upper body has z > 0. On the
    loaded surface of both bodies zz is minus the pressure, and xz and yz are the traction on the lower body.

    Attributes
    ----------
    body : "lower" or "upper"
    points : (3, ...) [m]
    stress : (6, ...) [Pa]
        Components xx, yy, zz, yz, xz, xy.
    half_width : float [m]
        Of the contact across its narrow side: the short semi-axis of the ellipse, or half of the strip, whose
        pressure after Hertz has the same second moments. 0 without a load.
    peak_pressure : float [Pa]
        Largest pressure on the surface.
    depths : (m,) or None [m]
        Depths of points (3, m, ny, nx) below the contact points; None for points that were asked for.
    pressure : (ny, nx) or None [Pa]
        On the surface above these.
    convolutions : int
        Convolutions that it took: one for each component and depth.
    way : float or None [rad]
        Direction in which the contact passes over the bodies, from +x towards +y, of results that roll; None
        of others, and of fields that were stored by an earlier version.
    """

    body: Body
    points: Array
    stress: Array
    half_width: float
    peak_pressure: float
    depths: Array | None = None
    pressure: Array | None = None
    convolutions: int = 0
    way: float | None = None
    usual_name: ClassVar[str] = "stress"
    called: ClassVar[str] = "stress field"
    endings: ClassVar[tuple[str, ...]] = ("png",)

    @property
    def xx(self) -> Array:
        """Normal stress (...) [Pa] along x."""
        return np.asarray(self.stress[0])

    @property
    def yy(self) -> Array:
        """Normal stress (...) [Pa] along y."""
        return np.asarray(self.stress[1])

    @property
    def zz(self) -> Array:
        """Normal stress (...) [Pa] along z."""
        return np.asarray(self.stress[2])

    @property
    def yz(self) -> Array:
        """Shear stress (...) [Pa]."""
        return np.asarray(self.stress[3])

    @property
    def xz(self) -> Array:
        """Shear stress (...) [Pa]."""
        return np.asarray(self.stress[4])

    @property
    def xy(self) -> Array:
        """Shear stress (...) [Pa]."""
        return np.asarray(self.stress[5])

    def tensor(self) -> Array:
        """The stress as matrices (..., 3, 3) [Pa]."""
        rows = [[0, 5, 4], [5, 1, 3], [4, 3, 2]]
        return np.moveaxis(self.stress[rows], (0, 1), (-2, -1))

    def principal(self) -> Array:
        """Principal stresses (3, ...) [Pa], the largest first."""
        return np.asarray(np.moveaxis(np.linalg.eigvalsh(self.tensor())[..., ::-1], -1, 0))

    @property
    def von_mises(self) -> Array:
        """Equivalent stress (...) [Pa] after von Mises."""
        xx, yy, zz, yz, xz, xy = self.stress
        squares = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
        return np.asarray(np.sqrt(0.5 * squares + 3.0 * (yz**2 + xz**2 + xy**2)))

    @property
    def tresca(self) -> Array:
        """Equivalent stress (...) [Pa] after Tresca: the largest less the least principal stress."""
        first, _, last = self.principal()
        return np.asarray(first - last)

    @property
    def largest_shear(self) -> Array:
        """Largest shear stress (...) [Pa] on any plane: half of Tresca's."""
        return 0.5 * self.tresca

    @property
    def largest_principal(self) -> Array:
        """Largest principal stress (...) [Pa]: what opens cracks where it is positive."""
        return np.asarray(self.principal()[0])

    @property
    def hydrostatic(self) -> Array:
        """Mean of the normal stresses (...) [Pa]."""
        return np.asarray(self.stress[:3].mean(axis=0))

    def _passage(self, along: Along | None) -> Along:
        """The way of a passage, where it is not given that of the rolling."""
        if along is not None:
            named: Along = choice("along", along, Along)
            return named
        if self.way is None or abs(np.sin(self.way)) < 1e-9:
            return "x"
        if abs(np.cos(self.way)) < 1e-9:
            return "y"
        raise ValueError(
            f"along is None, and the contact rolls at {np.degrees(self.way):.4g}\N{DEGREE SIGN} to x: "
            "passages are known along 'x' and along 'y'"
        )

    def dang_van(
        self, coefficient: float, residual_stress: ArrayLike | None = None, along: Along | None = None
    ) -> Array:
        """Equivalent shear stress (m, n) [Pa] of a passage, by Dang Van's criterion of fatigue.

        Of a material that passes through the contact and shakes down: the largest sum, over the passage, of
        the shear stress that is left about the middle of the smallest ball that holds the deviators, and of
        `coefficient` times the hydrostatic stress [DangVanGriveauMessage1989]. Above the fatigue limit in
        alternating torsion cracks begin inside. The state without a load, far from the contact, is part of
        the passage.

        Parameters
        ----------
        coefficient : float [-]
            Weight of the hydrostatic stress, ``3 (t / s - 1/2)`` of the fatigue limits in alternating
            torsion t and bending s; about 0.3 to 0.4 for steels of wheels and rails.
        residual_stress : (6,) or (6, m) or None [Pa]
            Residual stress xx, yy, zz, yz, xz, xy, the same at all depths or of each. Only its hydrostatic
            part counts: a constant deviator moves the ball as a whole.
        along : "x", "y" or None
            Way of the passage. None: that of the rolling, and x where the contact does not roll.

        Returns
        -------
        (m, ny) or (m, nx) [Pa]
            At the depths, and over the lines along the way.

        Raises
        ------
        ValueError
            For a stress of points that were asked for, where points do not lie on lines along the way, and
            for None where the contact rolls at an angle to x and y.

        Examples
        --------
        >>> import mtb_rs as mtb
        >>> ball = mtb.hertz(1e3, 0.02, lower=mtb.steel, upper=mtb.steel).on_grid((31, 31), 4e-5)
        >>> equivalent = ball.stress().dang_van(coefficient=0.3)
        >>> bool(equivalent.max() < 0.31 * ball.peak_pressure)
        True
        """
        weight = number("coefficient", coefficient)
        if weight < 0.0:
            raise ValueError(f"coefficient is {weight:g}: a number of at least 0 is needed")
        if self.depths is None:
            raise ValueError(
                "this stress is of points that were asked for: a passage needs one at depths, of "
                "stress(depths=...)"
            )
        along = self._passage(along)
        way = {"x": 0, "y": 1}[along]
        points = np.moveaxis(self.points, 3 - way, -1)
        across = np.delete(points, way, axis=0)
        # rounding of turned planes
        if np.ptp(across, axis=-1).max(initial=0.0) > 1e-9 * np.ptp(self.points):
            raise ValueError(f"the points do not lie on straight lines along {along}, which a passage needs")
        paths = np.moveaxis(self.stress, (0, 3 - way), (-1, -2))
        shape = paths.shape[:2]
        paths = np.concatenate([paths, np.zeros((*shape, 1, 6))], axis=2).reshape(shape[0] * shape[1], -1, 6)
        found = np.asarray(_mtb_rs.dang_van(np.ascontiguousarray(paths), weight)).reshape(shape)
        if residual_stress is None:
            return found
        own = reals("residual_stress", residual_stress, "Pa")
        if own.shape not in ((6,), (6, self.depths.size)):
            raise ValueError(
                f"residual_stress has shape {own.shape}: (6,) or (6, {self.depths.size}) is needed"
            )
        return found + np.reshape(weight * own[:3].mean(axis=0), (-1, 1))

    def maximum(self, quantity: StressPart = "von_mises") -> tuple[float, Array]:
        """Largest value [Pa] of a component or of a number that follows from them, and its place (3,) [m]."""
        values = self._values(quantity)
        flat = int(values.argmax())
        return float(values.ravel()[flat]), self.points.reshape(3, -1)[:, flat].copy()

    def _values(self, quantity: StressPart) -> Array:
        return np.asarray(getattr(self, choice("quantity", quantity, StressPart)))

    def told(self) -> list[Row]:
        """The largest stresses and where they are: what a notebook and the command line show."""
        rows = [("body", self.body), ("peak pressure", f"{self.peak_pressure / 1e6:.5g} MPa")]
        if self.half_width > 0.0:
            rows.append(("half width of the contact", length(self.half_width)))
        for name in ("von_mises", "largest_shear", "largest_principal"):
            value, place = self.maximum(name)
            at = ", ".join(f"{axis} {length(part)}" for axis, part in zip("xyz", place, strict=True))
            rows.append(
                (f"largest {LABELS[name].removeprefix('largest ')}", f"{value / 1e6:.5g} MPa at {at}")
            )
        return rows

    def plot(
        self,
        quantity: StressPart | Literal["dang_van"] = "von_mises",
        kind: str | None = None,
        **options: Any,
    ) -> Any:
        """Picture of one quantity.

        Parameters
        ----------
        quantity : str
            "xx", "yy", "zz", "yz", "xz", "xy", "von_mises", "tresca", "largest_shear", "largest_principal" or
            "hydrostatic"; for "depth" also a sequence of these. "dang_van" is a section across the way of a
            passage.
        kind : "section", "depth", "3d" or None
            A plane through the body, a line into its depth, or a view in space with a quarter cut away. None
            is a section. All of them need a stress at depths.
        x, y : float or None [m]
            Of a section one of them: where the plane x or y is. Of a depth both: where the line is. By
            default they go through the largest von Mises stress.
        dimensionless : bool
            Whether stresses are shares of the peak pressure and depths shares of the half width (depth only).
        limits : (low, high) or None [Pa]
            Ends of the colours (section and 3d).
        coefficient, residual_stress, along
            Of :meth:`dang_van`.
        ax : matplotlib.axes.Axes or None
        off_screen, size
            Of the view in space, as :func:`mtb_rs.pictures.view`.

        Returns
        -------
        matplotlib.figure.Figure or pyvista.Plotter
        """
        return pictures().draw_stress(self, quantity, kind, **options)

    def _repr_png_(self) -> bytes | None:
        """Its section, for notebooks: of a single column of cells its line into the depth; None at a single
        depth, and of points that were asked for.
        """
        if self.depths is None or self.depths.size < 2:
            return None
        kind = "section" if max(self.points.shape[2:]) > 1 else "depth"
        with pictures().own_figures():
            return png(self.plot(kind=kind))

    def exports(self) -> tuple[dict[str, bytes], list[str]]:
        """A picture of the section, where it has several depths."""
        picture = self._repr_png_()
        return ({} if picture is None else {"png": picture}), []

    def to_xarray(self) -> xarray.Dataset:
        """The components and von Mises' stress as an :class:`xarray.Dataset` (extra ``sweep``), with units.

        At depths the dimensions are (depth, y, x), otherwise "point"; the places are coordinates [m].
        """
        try:
            import xarray
        except ImportError as error:
            raise ImportError("xarray is missing: pip install 'mtb-rs[sweep]'") from error
        is_grid = self.depths is not None
        dims = ("depth", "y", "x") if is_grid else ("point",)
        shape = self.stress.shape[1:] if is_grid else (-1,)
        named = {name: self._values(name) for name in (*COMPONENTS, "von_mises")}  # type: ignore[arg-type]
        data = {
            name: xarray.Variable(dims, values.reshape(shape), {"units": "Pa", "long_name": LABELS[name]})
            for name, values in named.items()
        }
        x, y, z = self.points
        places: dict[str, Any] = {"x": x.reshape(-1), "y": y.reshape(-1), "z": z.reshape(-1)}
        if is_grid:
            places = {"x": x[0, 0], "y": y[0, :, 0], "depth": self.depths}
        coordinates = {
            name: xarray.Variable(name if is_grid else "point", values, {"units": "m"})
            for name, values in places.items()
        }
        told = {"body": self.body, "peak_pressure": self.peak_pressure, "half_width": self.half_width}
        return xarray.Dataset(data, coordinates, told)

    def to_pyvista(self) -> pyvista.StructuredGrid:
        """The stress at depths as a grid of pyvista (extra ``viz``), by the names of its quantities.

        Raises
        ------
        ImportError
            Without pyvista.
        ValueError
            For points that were asked for.
        """
        return pictures().stress_grid(self)

    def check(self) -> None:
        """Checks that what was read from files fits together; ValueError if it does not."""
        shape = self.points.shape[1:]
        if self.points.shape[:1] != (3,) or self.stress.shape != (6, *shape):
            raise ValueError(f"points are {self.points.shape} beside a stress of {self.stress.shape}")
        if self.depths is not None and (
            self.pressure is None or shape != (self.depths.size, *self.pressure.shape)
        ):
            raise ValueError(f"depths are {self.depths.shape} beside points of {self.points.shape}")

    def __repr__(self) -> str:
        value, place = self.maximum()
        shape = " x ".join(str(n) for n in self.stress.shape[1:]) or "1"
        return (
            f"StressField({self.body} body, {shape} points, von Mises stress up to {value:.4g} Pa "
            f"at a depth of {abs(place[2]):.4g} m)"
        )

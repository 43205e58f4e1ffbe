# SPDX-License-Identifier: MIT OR Apache-2.0
"""Rough surfaces: a self-affine generator, and how the contact area grows with the load."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import number, positive, whole
from ..base.owning import owned
from ..base.plain import plain
from ..base.questions import ask, gathered
from ..base.stored import stored
from ..base.told import Row
from ..base.units import taking_quantities
from ..bodies.material import Material, of_material
from ..bodies.simple import Simple
from ..geometry.contact_points import spacing_pair
from ..results.doors import pictures, png
from ..results.study import Study
from .normal import solve_normal

Array = NDArray[np.float64]

#: Points that are transformed at once: some hundredths of a second.
PART = 1_000_000


@taking_quantities
def roughness(
    shape: int | tuple[int, int],
    spacing: float | tuple[float, float],
    *,
    hurst: float = 0.8,
    rms_height: float | None = None,
    rms_slope: float | None = None,
    longest: float | None = None,
    roll_off: float | None = None,
    shortest: float | None = None,
    seed: int = 0,
) -> Array:
    """Heights of a periodic, isotropic, Gaussian, self-affine rough surface.

    Parameters
    ----------
    shape : int or (int, int)
        Cells (ny, nx).
    spacing : float or (float, float) [m]
    hurst : float [-]
        In (0, 1]: the power spectrum falls with the wave number to the power -2 (1 + hurst).
    rms_height : float [m]
        Root mean square of the heights. Give either this or `rms_slope`.
    rms_slope : float [-]
        Root mean square of the slope (of the trigonometric interpolant).
    longest, roll_off, shortest : float [m]
        Wavelengths. There are no waves longer than `longest` (default: the whole surface) or shorter than
        `shortest` (default: two cells). The spectrum is flat from `longest` to `roll_off` (default: no flat
        part).
    seed : int
        From 0 on; the same seed gives the same surface.

    Returns
    -------
    (ny, nx) float [m]
        Heights with zero mean; as a gap against a plane take ``heights.max() - heights``.

    Examples
    --------
    >>> import mtb_rs as mtb
    >>> heights = mtb.roughness(64, 1e-6, rms_height=1e-7, seed=1)
    >>> round(float(heights.std()) / 1e-7, 9)
    1.0
    """
    ny, nx = _shape(shape)
    dx, dy = spacing_pair(spacing)
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
        raise ValueError(f"seed is {seed!r}: a whole number from 0 on is needed")
    if not 0.0 < number("hurst", hurst) <= 1.0:
        raise ValueError(f"hurst is {hurst:g}: a number in (0, 1] is needed")
    if (rms_height is None) == (rms_slope is None):
        raise ValueError("either rms_height or rms_slope is needed")
    longest = math.inf if longest is None else positive("longest", longest, "m")
    roll_off = longest if roll_off is None else positive("roll_off", roll_off, "m")
    shortest = 2.0 * max(dx, dy) if shortest is None else positive("shortest", shortest, "m")
    if not shortest < roll_off <= longest:
        raise ValueError(
            f"wavelengths are {longest:g}, {roll_off:g}, {shortest:g} m: "
            "longest >= roll_off > shortest is needed"
        )
    kx = 2.0 * math.pi * np.fft.rfftfreq(nx, dx)[None, :]
    ky = 2.0 * math.pi * np.fft.fftfreq(ny, dy)[:, None]
    k = np.hypot(kx, ky)
    allowed = (k > 0.0) & (k >= 2.0 * math.pi / longest) & (k <= 2.0 * math.pi / shortest)
    if not allowed.any():
        raise ValueError(
            f"no wave from shortest = {shortest:g} m to longest = {longest:g} m long fits on a surface of "
            f"{nx * dx:g} x {ny * dy:g} m: a larger surface, or a wider range of waves, is needed"
        )
    # relative to the smallest wave number, so that powers neither overflow nor vanish
    knee = max(2.0 * math.pi / roll_off, float(k[allowed].min()))
    amplitude = np.where(allowed, (np.maximum(k, knee) / knee) ** (-1.0 - hurst), 0.0)
    spectrum = _waves(np.random.default_rng(seed), ny, nx)
    spectrum *= amplitude
    heights = _heights(spectrum, nx)
    if rms_height is not None:
        return np.asarray(heights * (positive("rms_height", rms_height, "m") / heights.std()))
    slopes = (_heights(1j * c * spectrum, nx) for c in (kx, ky))
    now = math.sqrt(sum(float(np.mean(slope**2)) for slope in slopes))
    if now == 0.0:
        raise ValueError(
            f"rms_slope is {rms_slope!r}: the only waves on {nx} x {ny} cells are two cells long, "
            "whose slope is zero at every cell; more cells or rms_height are needed"
        )
    return np.asarray(heights * (positive("rms_slope", rms_slope) / now))


def _parts(n: int, other: int) -> Iterator[slice]:
    """Rows or columns of a field `n` by `other`, so few that Ctrl-C is answered between them."""
    step = max(1, PART // other)
    return (slice(first, first + step) for first in range(0, n, step))


def _waves(random: np.random.Generator, ny: int, nx: int) -> NDArray[np.complex128]:
    """Spectrum (ny, nx // 2 + 1) of white noise."""
    waves = np.empty((ny, nx // 2 + 1), dtype=complex)
    for rows in _parts(ny, nx):
        count = len(range(*rows.indices(ny)))
        waves[rows] = np.fft.rfft(random.standard_normal((count, nx)))
    for columns in _parts(waves.shape[1], ny):
        waves[:, columns] = np.fft.fft(waves[:, columns], axis=0)
    return waves


def _heights(waves: NDArray[np.complex128], nx: int) -> Array:
    """The field (ny, nx) of a spectrum."""
    ny = len(waves)
    half = np.empty_like(waves)
    for columns in _parts(waves.shape[1], ny):
        half[:, columns] = np.fft.ifft(waves[:, columns], axis=0)
    heights = np.empty((ny, nx))
    for rows in _parts(ny, nx):
        heights[rows] = np.fft.irfft(half[rows], n=nx)
    return heights


def _shape(shape: int | tuple[int, int]) -> tuple[int, int]:
    try:
        ny, nx = shape  # type: ignore[misc]
    except TypeError:
        n = whole("shape", shape)
        return n, n
    except ValueError:
        raise ValueError(f"shape is {shape!r}: a whole number or (ny, nx) is needed") from None
    return whole("shape[0]", ny), whole("shape[1]", nx)


class _Columns(NamedTuple):
    force: Array
    contact_area: Array
    approach: Array
    mean_gap: Array


_UNITS = {"force": "N", "contact_area": "m^2", "approach": "m", "mean_gap": "m"}
#: Units in which they are told, the largest first, as pictures have them.
_SHOWN = {
    "N": (("kN", 1e3), ("N", 1.0), ("mN", 1e-3), ("\N{MICRO SIGN}N", 1e-6)),
    "m^2": (
        ("m\N{SUPERSCRIPT TWO}", 1.0),
        ("mm\N{SUPERSCRIPT TWO}", 1e-6),
        ("\N{MICRO SIGN}m\N{SUPERSCRIPT TWO}", 1e-12),
    ),
    "m": (("mm", 1e-3), ("\N{MICRO SIGN}m", 1e-6), ("nm", 1e-9)),
}


@stored
@plain
class AreaLoadCurve(_Columns, Study):
    """Contact area over load.

    Attributes
    ----------
    force : (k,) [N]
        Normal force.
    contact_area : (k,) [m2]
        Real area of contact.
    approach : (k,) [m]
    mean_gap : (k,) [m]
        Mean of the deformed gap.
    """

    usual_name: ClassVar[str] = "area_load"
    called: ClassVar[str] = "area-load curve"
    endings: ClassVar[tuple[str, ...]] = ("png", "csv")

    def plot(self, ax: Any = None) -> Any:
        """Draws the contact area over the force, into matplotlib's axes `ax` if given; returns the figure."""
        return pictures().draw_area_load(self, ax)

    def told(self) -> list[Row]:
        """Its ends in words: what a notebook shows beside the picture."""
        rows = []
        for (name, unit), values in zip(_UNITS.items(), self, strict=True):
            if values.size:
                largest = float(np.abs(values).max())
                # the largest of the units in which its numbers are at least one
                shown, size = next((s for s in _SHOWN[unit] if largest >= s[1]), _SHOWN[unit][-1])
                ends = f"{values.min() / size:.6g} to {values.max() / size:.6g} {shown}"
                rows.append((name.replace("_", " "), ends))
        return rows

    def to_pandas(self) -> Any:
        """The columns as a :class:`pandas.DataFrame` (extra ``sweep``); units are its ``attrs["units"]``."""
        try:
            import pandas
        except ImportError as error:
            raise ImportError("pandas is missing: pip install 'mtb-rs[sweep]'") from error
        frame = pandas.DataFrame(self._asdict())
        frame.attrs = {"units": dict(_UNITS)}
        return frame

    def to_xarray(self) -> Any:
        """The columns over the force as an :class:`xarray.Dataset` (extra ``sweep``), with units."""
        try:
            import xarray
        except ImportError as error:
            raise ImportError("xarray is missing: pip install 'mtb-rs[sweep]'") from error
        columns = {
            name: xarray.Variable("force", values, {"units": _UNITS[name]})
            for name, values in self._asdict().items()
        }
        return xarray.Dataset(columns, {"force": columns.pop("force")})

    def exports(self) -> tuple[dict[str, bytes], list[str]]:
        """A picture, and the columns as CSV."""
        rows = [",".join(f"{value!r}" for value in row) for row in np.array(self).T.tolist()]
        lines = [",".join(f"{name} [{unit}]" for name, unit in _UNITS.items()), *rows]
        with pictures().own_figures():
            return {"png": png(self.plot()), "csv": "".join(f"{line}\n" for line in lines).encode()}, []

    def check(self) -> None:
        """Checks that what was read from files fits together; ValueError if it does not."""
        if self.force.ndim != 1 or any(column.shape != self.force.shape for column in self):
            raise ValueError(f"its columns have the shapes {[column.shape for column in self]}")

    def _repr_png_(self) -> bytes | None:
        """Its picture, for notebooks; none without a load."""
        with pictures().own_figures():
            return png(self.plot()) if self.force.size else None


@taking_quantities
def area_load_curve(
    gap: ArrayLike,
    spacing: float | tuple[float, float],
    forces: Iterable[float],
    *,
    lower: Material | Simple,
    upper: Material | Simple,
    periodic: bool = True,
    tolerance: float | None = None,
    hardness: float | None = None,
) -> AreaLoadCurve:
    """Contact area, approach and mean gap of a rough contact over the normal force.

    Parameters are those of :func:`mtb_rs.solve_normal`; `forces` [N] are solved one by one. A cell counts as
    in contact as a whole, so the area is too large by about half a cell along its border. With a `hardness`
    [Pa] tips flow, and the area comes to the force over the hardness.
    """
    loads = [positive(f"forces[{k}]", force, "N") for k, force in enumerate(forces)]
    # contacts of a few cells are expected between rough surfaces, as are pressures at which their tips flow
    with gathered():
        results = [
            solve_normal(
                gap,
                spacing,
                lower=lower,
                upper=upper,
                force=force,
                periodic=periodic,
                tolerance=tolerance,
                edge="auto" if periodic else "sharp",
                hardness=hardness,
            )
            for force in loads
        ]
    materials = {side: getattr(results[0], side).material for side in ("lower", "upper")} if results else {}
    ask(words for side, of in materials.items() if of is not None for words in of_material(side, of))
    columns = AreaLoadCurve(
        np.array(loads),
        np.array([result.contact_area for result in results]),
        np.array([result.approach for result in results]),
        np.array([float(result.gap.mean()) for result in results]),
    )
    curve: AreaLoadCurve = owned(columns)
    return curve

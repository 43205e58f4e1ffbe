# SPDX-License-Identifier: MIT OR Apache-2.0
"""Closed forms of contact, to judge solutions by."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.plain import plain
from ..bodies.material import Material
from .pressure_field import PressureField

Array = NDArray[np.float64]
Bodies = tuple[Material, Material]


def _flexibility(bodies: Bodies) -> float:
    """Sum of (1 - nu) / G [1/Pa]."""
    return sum((1.0 - m.poisson_ratio) / m.shear_modulus for m in bodies)


def _contact_modulus(bodies: Bodies) -> float:
    """E* = 1 / sum of (1 - nu^2) / E [Pa]."""
    return 2.0 / _flexibility(bodies)


def elliptic_pressure(
    normal_force: float,
    semi_axes: tuple[float, float],
    cells: tuple[int, int],
    lower: Material,
    upper: Material,
    margin: int = 0,
) -> PressureField:
    """Hertz's pressure on `cells` (nx, ny) over the axes of its ellipse, scaled to carry the force exactly.

    Parameters
    ----------
    normal_force : float [N]
    semi_axes : (a, b) [m]
        Along x and along y.
    cells : (nx, ny)
        Over 2a and over 2b.
    lower, upper : Material
    margin : int
        Cells added around.
    """
    (a, b), (nx, ny) = semi_axes, cells
    dx, dy = 2.0 * a / nx, 2.0 * b / ny
    x = (np.arange(nx + 2 * margin) - margin - 0.5 * (nx - 1)) * dx
    y = (np.arange(ny + 2 * margin) - margin - 0.5 * (ny - 1)) * dy
    shape = np.sqrt(np.maximum(1.0 - (x / a) ** 2 - (y[:, None] / b) ** 2, 0.0))
    return PressureField(normal_force / (shape.sum() * dx * dy) * shape, (dx, dy), lower, upper)


def line_pressure(
    force_per_length: float, half_width: float, cells: int, lower: Material, upper: Material
) -> PressureField:
    """Hertz's pressure of a line contact, exact mean by cell [Johnson1985, ch. 4.2]; forces per metre."""
    edges = np.linspace(-1.0, 1.0, cells + 1)
    share = np.diff(0.5 * (edges * np.sqrt(1.0 - edges**2) + np.arcsin(edges))) / (0.5 * math.pi)
    dx = 2.0 * half_width / cells
    return PressureField((force_per_length * share / dx)[None, :], (dx, 1.0), lower, upper, reference=1.0)


def cattaneo_stick_radius(share: float) -> float:
    """Stick over contact radius at the force `share` times mu F_n [Johnson1985, eq. 7.46]."""
    return float((1.0 - share) ** (1.0 / 3.0))


def cattaneo_traction(
    radius: ArrayLike, contact_radius: float, peak_pressure: float, friction: float, share: float
) -> Array:
    """Traction [Pa] of a sphere pushed sideways, at the distances `radius` [m] from the centre.

    Exact for bodies without Poisson's ratio; with it, lateral tractions of a few per cent are left out.
    [Johnson1985, ch. 7.2]
    """
    r = np.asarray(radius, dtype=float) / contact_radius
    stick = cattaneo_stick_radius(share)
    outer = np.sqrt(np.maximum(1.0 - r**2, 0.0))
    inner = np.sqrt(np.maximum(stick**2 - r**2, 0.0))
    return np.asarray(friction * peak_pressure * (outer - inner))


def cattaneo_displacement(
    normal_force: float, contact_radius: float, friction: float, share: float, bodies: Bodies
) -> float:
    """Shift [m] of a sphere at the tangential force `share` times mu F_n [Johnson1985, eq. 7.48]."""
    compliance = sum((2.0 - m.poisson_ratio) / m.shear_modulus for m in bodies)
    fall = 1.0 - (1.0 - share) ** (2.0 / 3.0)
    return float(3.0 * friction * normal_force / (16.0 * contact_radius) * compliance * fall)


def carter_stick_share(share: float) -> float:
    """Stick over contact width at the force `share` times mu F_n [Johnson1985, ch. 8.3]."""
    return math.sqrt(1.0 - share)


def carter_traction(
    x: ArrayLike, half_width: float, peak_pressure: float, friction: float, share: float
) -> Array:
    """Traction [Pa] of a rolling cylinder, leading edge at +x, stick next to it [Johnson1985, ch. 8.3]."""
    s = np.asarray(x, dtype=float) / half_width
    stick = carter_stick_share(share)
    outer = np.sqrt(np.maximum(1.0 - s**2, 0.0))
    inner = np.sqrt(np.maximum(stick**2 - (s - (1.0 - stick)) ** 2, 0.0))
    return np.asarray(friction * peak_pressure * (outer - inner))


def carter_creepage(
    half_width: float, peak_pressure: float, friction: float, share: float, bodies: Bodies
) -> float:
    """Creepage [-] of a rolling cylinder at `share` times mu F_n [Johnson1985, ch. 8.3]."""
    # full-contact stick traction mu p0 (c/a) over its half-width c, times the sum of (1 - nu) / G
    return 2.0 * friction * peak_pressure / _contact_modulus(bodies) * (1.0 - carter_stick_share(share))


@dataclass(frozen=True)
@plain
class SlidingParaboloid:
    """A paraboloid sliding over a plane along +x, both half-spaces: thesis 3.1.1 [Johnson1985, 3.4, 3.7].

    The pressure is Hertz's, exact where friction does not change it, that is for like materials. The
    displacements are the closed forms of Boussinesq's and Cerruti's integrals over it.

    Parameters
    ----------
    radius : float [m]
        Of curvature at the apex; relative, if both bodies are curved.
    force : float [N]
    friction : float [-]
    lower, upper : Material
    """

    radius: float
    force: float
    friction: float
    lower: Material
    upper: Material

    @property
    def contact_radius(self) -> float:
        """Radius of the contact patch [m]."""
        return math.cbrt(0.75 * self.force * self.radius / _contact_modulus((self.lower, self.upper)))

    @property
    def approach(self) -> float:
        """How far distant points come together [m]."""
        return self.contact_radius**2 / self.radius

    @property
    def peak_pressure(self) -> float:
        """Pressure at the apex [Pa]."""
        return 1.5 * self.force / (math.pi * self.contact_radius**2)

    def pressure(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Pressure [Pa]; friction along +x on the lower body is `friction` times it."""
        r2 = (np.asarray(x, dtype=float) ** 2 + np.asarray(y, dtype=float) ** 2) / self.contact_radius**2
        return np.asarray(self.peak_pressure * np.sqrt(np.maximum(1.0 - r2, 0.0)))

    def displacement(self, x: ArrayLike, y: ArrayLike, body: str = "lower") -> Array:
        """Elastic displacement (3, ...) [m] of the surface of one body, z up.

        Parameters
        ----------
        x, y : [m]
            From the apex.
        body : "lower" or "upper"
        """
        if body not in ("lower", "upper"):
            raise ValueError(f'body is {body!r}: "lower" or "upper" is needed')
        material = self.lower if body == "lower" else self.upper
        pull = self.friction if body == "lower" else -self.friction
        a = self.contact_radius
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float) / a, np.asarray(y, dtype=float) / a)
        r2 = x**2 + y**2
        safe = np.where(r2 > 0.0, r2, 1.0)
        outside = np.sqrt(np.maximum(r2 - 1.0, 0.0))
        angle = np.arcsin(1.0 / np.sqrt(np.maximum(r2, 1.0)))
        # over the unit disc, q = sqrt(1 - r^2): V = int q / R, and psi = int q R with Laplacian V
        potential = 0.5 * math.pi * ((2.0 - r2) * angle + outside)
        slope = np.where(
            r2 > 0.0,
            0.5 * math.pi * ((r2 - 0.25 * r2**2) * angle + 0.25 * outside * (3.0 + outside**2)) / safe,
            0.25 * math.pi**2,
        )  # psi' / r
        bend = potential - 2.0 * slope  # psi'' - psi' / r
        along = np.where(r2 > 0.0, x**2 / safe, 0.5)
        across = np.where(r2 > 0.0, x * y / safe, 0.0)
        inverse_xx = potential - slope - bend * along  # int q X^2 / R^3
        inverse_xy = -bend * across
        # int q X / R^2: the load within r acts as if at the centre
        inside = 1.0 - np.maximum(1.0 - r2, 0.0) ** 1.5
        share = np.where(r2 > 0.0, 2.0 * math.pi / 3.0 * inside / safe, math.pi)
        nu = material.poisson_ratio
        unit = self.peak_pressure * a / (2.0 * math.pi * material.shear_modulus)
        mixed = 0.5 * (1.0 - 2.0 * nu)
        u_x = pull * ((1.0 - nu) * potential + nu * inverse_xx) - mixed * share * x
        u_y = pull * nu * inverse_xy - mixed * share * y
        into = (1.0 - nu) * potential + pull * mixed * share * x
        return np.asarray(unit * np.stack([u_x, u_y, -into if body == "lower" else into]))


@dataclass(frozen=True)
@plain
class FlatPunch:
    """A rigid or elastic circular flat pressed on a half-space without friction [Johnson1985, ch. 3.4].

    Parameters
    ----------
    radius : float [m]
    force : float [N]
    lower, upper : Material
        Exact with the punch treated as a half-space; a rigid one has a modulus far above the other.
    """

    radius: float
    force: float
    lower: Material
    upper: Material

    @property
    def approach(self) -> float:
        """How far the punch sinks in [m]."""
        return self.force / (2.0 * self.radius * _contact_modulus((self.lower, self.upper)))

    def pressure(self, r: ArrayLike) -> Array:
        """Pressure [Pa] at the distances `r` [m] from the centre; infinite at the edge."""
        s = np.asarray(r, dtype=float) / self.radius
        with np.errstate(divide="ignore"):
            inside = 1.0 / np.sqrt(np.maximum(1.0 - s**2, 0.0))
        return np.asarray(self.force / (2.0 * math.pi * self.radius**2) * np.where(s <= 1.0, inside, 0.0))


def dundurs_beta(lower: Material, upper: Material) -> float:
    """Dundurs' second constant: how much friction opens or closes the gap; zero for like materials.

    Positive if the lower body is the softer or the more compressible one.
    """
    bodies = (lower, upper)
    mixed = [(1.0 - 2.0 * m.poisson_ratio) / m.shear_modulus for m in bodies]
    return 0.5 * (mixed[0] - mixed[1]) / _flexibility(bodies)


@dataclass(frozen=True)
@plain
class SlidingFlatPunch:
    """A long flat sliding across its edges over a plane, plane strain [Johnson1985, ch. 2.8].

    The pressure is ``p = F cos(pi g) / (pi sqrt(a^2 - x^2)) ((a + x) / (a - x))^g`` with
    ``tan(pi g) = -friction dundurs_beta``: in the sliding direction +x the lower surface sinks ahead of
    friction and the upper one follows it down; the rear edge carries more where the lower gives way more.

    Parameters
    ----------
    half_width : float [m]
    force_per_length : float [N/m]
    friction : float [-]
    lower, upper : Material
        Both as half-spaces.
    """

    half_width: float
    force_per_length: float
    friction: float
    lower: Material
    upper: Material

    @property
    def exponent(self) -> float:
        """The shift `g` of the two edge exponents -1/2 +- g."""
        return -math.atan(self.friction * dundurs_beta(self.lower, self.upper)) / math.pi

    def pressure(self, x: ArrayLike) -> Array:
        """Pressure [Pa] at `x` [m] from the middle, in the sliding direction."""
        s = np.asarray(x, dtype=float) / self.half_width
        g = self.exponent
        inside = np.abs(s) < 1.0
        t = np.where(inside, s, 0.0)
        shape = (1.0 + t) ** (g - 0.5) * (1.0 - t) ** (-g - 0.5)
        scale = self.force_per_length * math.cos(math.pi * g) / (math.pi * self.half_width)
        return np.asarray(np.where(inside, scale * shape, 0.0))

    def load_share(self, x: float, points: int = 400) -> float:
        """Share of the force carried between the rear edge and `x` [m], by Gauss-Legendre quadrature."""
        # a power of the distance from the nearer edge takes the singularity away
        g = self.exponent
        nodes, weights = np.polynomial.legendre.leggauss(points)
        t = 0.5 * (nodes + 1.0)

        def part(length: float, near: float, far: float) -> float:
            # int over the distance d from one edge, 0 .. length, of d^near (2 - d)^far
            power = 1.0 / (1.0 + near)
            d = length * t**power
            return float(0.5 * weights @ (2.0 - d) ** far * length ** (1.0 + near) * power)

        s = min(max(x / self.half_width, -1.0), 1.0)
        rear, front = g - 0.5, -g - 0.5
        total = part(1.0, rear, front) + part(1.0, front, rear)
        if s <= 0.0:
            return part(1.0 + s, rear, front) / total
        return 1.0 - part(1.0 - s, front, rear) / total


@dataclass(frozen=True)
@plain
class WavyContact:
    """A plane against a sine wave of one direction [Johnson1985, ch. 13.2, after Westergaard].

    The undeformed gap is ``amplitude (1 - cos(2 pi x / wavelength))``.

    Parameters
    ----------
    amplitude, wavelength : float [m]
    mean_pressure : float [Pa]
    lower, upper : Material
    """

    amplitude: float
    wavelength: float
    mean_pressure: float
    lower: Material
    upper: Material

    @property
    def full_contact_pressure(self) -> float:
        """Mean pressure that closes the gap everywhere [Pa]."""
        modulus = _contact_modulus((self.lower, self.upper))
        return math.pi * modulus * self.amplitude / self.wavelength

    @property
    def half_width(self) -> float:
        """Half-width of each strip of contact [m]; half the wavelength in full contact."""
        share = min(self.mean_pressure / self.full_contact_pressure, 1.0)
        return self.wavelength / math.pi * math.asin(math.sqrt(share))

    def pressure(self, x: ArrayLike) -> Array:
        """Pressure [Pa] at `x` [m] from a crest."""
        phase = math.pi * np.asarray(x, dtype=float) / self.wavelength
        if self.mean_pressure >= self.full_contact_pressure:
            return np.asarray(self.mean_pressure + self.full_contact_pressure * np.cos(2.0 * phase))
        square = self.mean_pressure / self.full_contact_pressure
        root = np.sqrt(np.maximum(square - np.sin(phase) ** 2, 0.0))
        return np.asarray(2.0 * self.full_contact_pressure * np.abs(np.cos(phase)) * root)


@dataclass(frozen=True)
@plain
class CreepingCylinder:
    """A rigid cylinder that rolls along +x, steadily and without friction, on a half-space that creeps.

    The half-space is a standard linear solid in plane strain [Hunter1961]. With the elastic slope ``w(x)`` of
    its surface under the pressure, the contact asks that ``w`` and `creep` times its mean over the way ahead,
    with the weight ``exp(-s / way) / way``, are the slope of the cylinder. There ``1 - way d/dx`` makes of
    this ``(1 + creep) w - way w' = (way - x) / radius``, so that ``w`` is linear but for a multiple of
    ``exp((1 + creep) x / way)``, whose Chebyshev coefficients are Bessel functions. The pressure follows from
    these term by term. Place and width of the contact, and the multiple, follow from the load, from a
    pressure that vanishes at both ends, and from the first equation at the leading one.

    Parameters
    ----------
    radius : float [m]
    load : float [N/m]
        For each metre of the cylinder.
    material : Material
        Before it creeps.
    creep : float [-]
        Compliance that creep adds in the long run, over that before.
    way : float [m]
        Rolled in the time of creep: velocity times this time; > 0.
    """

    radius: float
    load: float
    material: Material
    creep: float
    way: float

    def extent_of(self, material: Material) -> float:
        """Half-width [m] of the contact with an elastic half-space, Hertz' line contact."""
        return math.sqrt(4.0 * self.load * self.radius / (math.pi * material.plane_strain_modulus))

    @property
    def relaxed(self) -> Material:
        """After all creep."""
        return Material(self.material.young_modulus / (1.0 + self.creep), self.material.poisson_ratio)

    @property
    def half_width(self) -> float:
        """Of the contact [m]."""
        return self._found[0]

    @property
    def middle(self) -> float:
        """Place of the middle of the contact [m], ahead of the lowest point of the cylinder."""
        return self._found[1]

    @property
    def offset(self) -> float:
        """Place of the resultant of the pressure [m], likewise."""
        return self.middle + 0.25 * math.pi * self.half_width**2 * float(self._waves[1]) / self.load

    @property
    def resistance(self) -> float:
        """Force against the rolling [N/m]."""
        return self.load * self.offset / self.radius

    def pressure(self, x: ArrayLike) -> Array:
        """Pressure [Pa] at `x` [m] ahead of the lowest point of the cylinder."""
        place = (np.asarray(x, dtype=float) - self.middle) / self.half_width
        angle = np.arccos(np.clip(place, -1.0, 1.0))
        return np.asarray(sum(b * np.sin((n + 1) * angle) for n, b in enumerate(self._waves)))

    @property
    def peak_pressure(self) -> float:
        """The largest pressure [Pa]."""
        x = self.middle + self.half_width * np.linspace(-1.0, 1.0, 20001)
        return float(self.pressure(x).max())

    @cached_property
    def _waves(self) -> Array:
        """The pressure [Pa] over sines of 1, 2, ... times the angle whose cosine is the place."""
        return -0.5 * self.material.plane_strain_modulus * self._found[2][1:]

    @cached_property
    def _found(self) -> tuple[float, float, Array]:
        """Half-width and middle [m], and the Chebyshev coefficients of the elastic slope."""
        low, high = 0.98 * self.extent_of(self.material), 1.02 * self.extent_of(self.relaxed)
        start = self._state(low)[0]
        while high - low > 1e-15 * high:
            middle = 0.5 * (low + high)
            if middle in (low, high):
                break
            if (self._state(middle)[0] > 0.0) == (start > 0.0):
                low = middle
            else:
                high = middle
        return low, *self._state(low)[1:]

    def _state(self, half_width: float) -> tuple[float, float, Array]:
        """What the first equation lacks at the leading end, the middle, and the coefficients."""
        soft = 1.0 + self.creep
        steep = soft * half_width / self.way
        terms = 40 + round(9.0 * math.sqrt(steep))
        # modified Bessel functions over exp(steep), by the trapezoidal rule on a circle
        circle = np.exp(steep * (np.cos(2.0 * math.pi * np.arange(8 * terms) / (8 * terms)) - 1.0))
        bessel = np.fft.rfft(circle).real[:terms] / (8 * terms)
        linear = -half_width / (self.radius * soft)
        of_load = -4.0 * self.load / (math.pi * self.material.plane_strain_modulus * half_width)
        slope = (of_load - linear) / bessel[1] * bessel
        # a pressure that vanishes at both ends has no constant part
        middle = self.way * self.creep / soft + 0.5 * slope[0] * self.radius * soft
        slope[0] = 0.0
        slope[1] = of_load
        # ahead of the contact each term falls as exp(-n v) where the place is cosh v
        nodes, shares = np.polynomial.legendre.leggauss(40)
        ends = np.linspace(0.0, math.acosh(1.0 + 45.0 * self.way / half_width), 17)
        size = 0.5 * (ends[1:] - ends[:-1])[:, None]
        v = ends[:-1, None] + size * (1.0 + nodes)
        ahead = np.polynomial.polynomial.polyval(np.exp(-v), slope)
        fading = np.exp(-(np.cosh(v) - 1.0) * half_width / self.way) * np.sinh(v) * half_width / self.way
        mean = float((size * shares * fading * ahead).sum())
        lacks = float(slope.sum()) + self.creep * mean + (middle + half_width) / self.radius
        return lacks, middle, slope


def uniform_rectangle_displacement(
    x: ArrayLike, y: ArrayLike, half_sides: tuple[float, float], pressure: float, material: Material
) -> Array:
    """Displacement (3, ...) [m] of a half-space's surface by uniform pressure on a rectangle [Love1929].

    Parameters
    ----------
    x, y : [m]
        From the centre of the rectangle.
    half_sides : (a, b) [m]
        Along x and y.
    pressure : float [Pa]
    material : Material

    Returns
    -------
    (3, ...) [m]
        x, y, and into the body.
    """
    x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
    a, b = half_sides
    total = np.zeros((3, *x.shape))
    for sign_x in (1.0, -1.0):
        for sign_y in (1.0, -1.0):
            s, t = x + sign_x * a, y + sign_y * b
            r = np.hypot(s, t)
            sign = sign_x * sign_y
            with np.errstate(divide="ignore", invalid="ignore"):
                total[0] -= sign * (
                    np.where(t == 0.0, 0.0, t * np.log(r)) + s * np.arctan2(t * np.sign(s), abs(s))
                )
                total[1] -= sign * (
                    np.where(s == 0.0, 0.0, s * np.log(r)) + t * np.arctan2(s * np.sign(t), abs(t))
                )
                total[2] += sign * np.where(s == 0.0, 0.0, s * np.arcsinh(t / np.abs(s)))
                total[2] += sign * np.where(t == 0.0, 0.0, t * np.arcsinh(s / np.abs(t)))
    nu = material.poisson_ratio
    unit = pressure / (2.0 * math.pi * material.shear_modulus)
    factors = np.array([0.5 * (1.0 - 2.0 * nu), 0.5 * (1.0 - 2.0 * nu), 1.0 - nu])
    return np.asarray(unit * factors.reshape(3, *(1,) * x.ndim) * total)

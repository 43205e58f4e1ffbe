# SPDX-License-Identifier: MIT OR Apache-2.0
"""Heat of friction in bodies that slide: implicit steps over the time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.owning import solved
from ..base.plain import plain
from ..base.progress import shares_shown
from ..base.stored import input_data, stored
from ..base.told import Row, along, in_words
from ..base.units import taking_quantities
from ..bodies.simple import FieldBody
from ..geometry.contact_points import Patch
from ..results.doors import pictures
from ..results.fields import Field, fields_of
from ..results.result import Curved, Pictured
from ..results.stressed import Loads, Stressed, loaded_patches
from .heated_steps import HeatedSliding, Trial

Array = NDArray[np.float64]
T = TypeVar("T")

#: What it has at each contact point.
OVER_CONTACT = (
    *("pressure", "traction", "status", "temperature_upper", "temperature_lower"),
    *("heat_flux_upper", "heat_flux_lower", "depth", "pressures", "temperatures", "depths"),
    "openings",
)


@stored
@solved
@dataclass(frozen=True, repr=False)
@plain
class SlidingHeat(Curved, Stressed, Pictured):
    """Temperatures and pressure over the time of bodies that slide; see :meth:`Scene.sliding_heat`.

    The fields are those of the last step, and :meth:`stress` is that by its pressure and friction, without
    that by heat. Arrays with k entries have one for each step.

    Attributes
    ----------
    points : (3, n) [m]
        Contact points.
    area : (n,) [m2]
    pressure : (n,) [Pa]
    traction : (2, n) [Pa]
        On the lower body, along x of the track as seen from above, and across, in its surface.
    status : (n,) int
        0 open, 1 stick (without friction), 2 slip.
    temperature_upper, temperature_lower : (n,) [K]
        Of the surfaces, above the level from which the bulk temperatures count: means over
        the contact points.
    heat_flux_upper, heat_flux_lower : (n,) [W/m2]
        Heat that enters each body; their sum is the power of friction.
    time : (k,) [s]
        At the end of each step.
    velocity : (k,) [m/s]
    forces : (k, 3) [N]
        On the lower body.
    friction_powers, heats_upper, heats_lower : (k,) [W]
        Heat of friction, and heat that enters the upper and the lower body.
    losses : (k,) [W]
        Heat that leaves the upper body through its film.
    stored : (k,) [J]
        Heat in the upper body since the beginning.
    peaks : (k,) [K]
        Highest temperature of a contact point.
    means : (k,) [K]
        Mean temperature of the contact face of the upper body.
    pressures : (k, n) [Pa]
    temperatures : (k, n) [K]
        Of the contact points of the upper body.
    bodies : tuple of (N,) [K]
        Temperatures of the nodes of each upper body after the last step.
    depth : (n,) [m]
        Worn off the upper body.
    depths : (k, n) [m]
    openings : (k, n) [m]
        What the expansion of both bodies adds to the gap since the beginning, below zero where it closes.
        With ``gap=depths[i] + openings[i]`` a step of the prepared contact has the pressures of a step.
    volumes_upper, volumes_lower : (k,) [m3]
        Worn off both bodies since the beginning.
    errors : (k,) [-]
        Estimated error of each step by its length: of the heat in the upper body and of the depth worn off
        it, in parts of what the step adds and a tenth of all (root mean squares over the area; the larger
        one). That of the first step is counted from no heat at all.
    thermal_margin : float or None
        Heat of friction over the bound below which a single step as long as `duration` at the speed of the
        beginning has one state for any load: above it uneven pressure grows by its own heat. None where
        nothing expands. A `hardness` and a rough layer do not count, because the limit is for any load: a
        rough layer gives way ever less under more pressure. They slow the growth down under usual loads, and
        so does a linear `normal_layer`, which counts.
    patches : tuple of Patch
    summary : Mapping
        Inputs of the scene, and of the heat.
    lower, upper : HalfSpace, Layered, Prism, Rigid or None
        The bodies; None of finite elements, and of results that were stored by an earlier version.
    elastic : tuple of str
        Which bodies, "lower" or "upper", have finite elements.
    """

    # what the user has said
    _unbounded = ("summary", "thermal_margin")

    points: Array
    area: Array
    pressure: Array
    traction: Array
    status: NDArray[np.int8]
    temperature_upper: Array
    temperature_lower: Array
    heat_flux_upper: Array
    heat_flux_lower: Array
    time: Array
    velocity: Array
    forces: Array
    friction_powers: Array
    heats_upper: Array
    heats_lower: Array
    losses: Array
    stored: Array
    peaks: Array
    means: Array
    pressures: Array
    temperatures: Array
    bodies: tuple[Array, ...]
    depth: Array = field(default_factory=lambda: np.zeros(0))
    depths: Array = field(default_factory=lambda: np.zeros((0, 0)))
    openings: Array = field(default_factory=lambda: np.zeros((0, 0)))
    volumes_upper: Array = field(default_factory=lambda: np.zeros(0))
    volumes_lower: Array = field(default_factory=lambda: np.zeros(0))
    errors: Array = field(default_factory=lambda: np.zeros(0))
    thermal_margin: float | None = None
    patches: tuple[Patch, ...] = ()
    summary: Mapping[str, Any] = field(default_factory=dict, compare=False)
    lower: FieldBody | None = None
    upper: FieldBody | None = None
    elastic: tuple[str, ...] = ()
    _drawn: ClassVar[tuple[str, ...]] = (
        "points", "area", "pressure", "traction", "temperature_upper", "temperature_lower",
        "heat_flux_upper", "heat_flux_lower", "status",
    )  # fmt: skip
    curves: ClassVar[tuple[str, ...]] = (
        "peaks", "means", "friction_powers", "heats_upper", "heats_lower", "losses", "stored",
        "volumes_upper", "volumes_lower", "errors",
    )  # fmt: skip
    over: ClassVar[str] = "the time"
    _summed: ClassVar[tuple[str, ...]] = ("force", "friction_power", "heat_lower", "heat_upper")

    @property
    def force(self) -> Array:
        """Force on the lower body (3,) [N] in the last step."""
        return np.asarray(self.forces[-1])

    @property
    def friction_power(self) -> float:
        """Heat of friction [W] in the last step."""
        return float(self.friction_powers[-1])

    @property
    def heat_upper(self) -> float:
        """Heat that enters the upper body [W] in the last step."""
        return float(self.heats_upper[-1])

    @property
    def heat_lower(self) -> float:
        """Heat that enters the lower body [W] in the last step."""
        return float(self.heats_lower[-1])

    def _line(self, quantity: str, ax: Any) -> Any:
        return pictures().draw_heat(self, quantity, ax)

    @taking_quantities
    def animate(self, path: str | Path, *, frames: int = 60, frames_per_second: float = 10.0) -> Path:
        """A moving picture of pressure, temperature of the upper surface and, if it wears, the sole.

        Above them stand speed and heat of friction over the time. The frames are at equal distances of time;
        between the steps the fields are linear.

        Parameters
        ----------
        path : str or Path
            A name ending in .gif, .webp or .png.
        frames : int
        frames_per_second : float [1/s]

        Returns
        -------
        Path
        """
        lines = [
            pictures().Line(self.time, self.velocity, "speed [m/s]"),
            pictures().Line(self.time, 1e-3 * self.friction_powers, "heat of friction [kW]"),
        ]
        made: Path = pictures().animate_sliding(self, lines, path, frames, frames_per_second)
        return made

    def fields(self) -> dict[str, Field]:
        """Its fields over the contact points, by name: values with unit and label."""
        worn = fields_of(wear_upper=self.depth) if self.depth.any() else {}
        return super().fields() | worn

    def _loads(self) -> Loads:
        grids = loaded_patches(self.patches, self.points, self.area, self.pressure, self.traction)
        return Loads(grids, self.lower, self.upper, elastic=self.elastic)

    def _kept(self) -> SlidingHeat:
        return replace(self, summary=input_data(self.summary))

    def ends(self) -> dict[str, float]:
        """Numbers that it has come to at its end, by name [SI]: the columns of a sweep."""
        dt = np.diff(self.time, prepend=0.0)
        return {
            "duration": self.time[-1],
            "peak_temperature": self.peaks.max(),
            "mean_temperature": self.means[-1],
            "friction_energy": dt @ self.friction_powers,
            "heat_energy_upper": dt @ self.heats_upper,
            "peak_pressure": self.pressure.max(),
            **dict(zip(("force_x", "force_y", "force_z"), self.forces[-1], strict=True)),
            "steps": self.time.size,
        }

    def facts(self) -> dict[str, Any]:
        """What else its `summary.json` holds: inputs, and the highest temperatures."""
        return {
            "inputs": self.summary,
            "time": self.time,
            "peaks": self.peaks,
            "errors": self.errors,
            "thermal_margin": self.thermal_margin,
        }

    def told(self) -> list[Row]:
        """What happened, in words: what a notebook and the command line show."""
        rows = [
            ("time", f"{in_words(float(self.time[-1]), 's')} in {self.time.size} steps"),
            ("force on the lower body", along(self.force, "N")),
            ("highest temperature", in_words(float(self.peaks.max()), "K")),
            ("heat in the upper body", in_words(float(self.stored[-1]), "J")),
            ("peak pressure", f"{self.pressure.max() / 1e6:.5g} MPa"),
        ]
        if self.thermal_margin is not None:
            rows.append(("heat over its thermal limit", f"{self.thermal_margin:.4g}"))
        if self.volumes_upper.any() or self.volumes_lower.any():
            worn = [1e9 * float(volumes[-1]) for volumes in (self.volumes_upper, self.volumes_lower)]
            rows.append(("worn off", f"{worn[0]:.4g} mm3 above, {worn[1]:.4g} mm3 below"))
        return [*rows, ("error of a step", f"{100.0 * float(np.median(self.errors)):.2g} % (median)")]

    def __repr__(self) -> str:
        return (
            f"{type(self).__name__}({self.time.size} steps to {self.time[-1]:.4g} s, "
            f"{self.area.size} points, highest {self.peaks.max():.4g} K)"
        )


class Steps:
    """Times of steps: of equal length, or as a tolerance has them, in halves of the longest one.

    Parameters
    ----------
    longest : float [s]
    tolerance : float or None
        Of each step; None: all are the longest.
    next : float or None [s]
        The length that steps before these have promised.
    """

    #: Halves of the longest step at most.
    HALVES: ClassVar[int] = 24

    def __init__(self, longest: float, tolerance: float | None, next: float | None = None) -> None:
        self.longest = longest
        self.control = None if tolerance is None else _mtb_rs.StepControl(tolerance, next)

    def taken(
        self,
        most: int,
        tried: Callable[[int], tuple[T, float, float]],
        failed: Callable[[T, float | None], Exception],
    ) -> tuple[T, int]:
        """The next step that is taken, and its number of shortest steps.

        Parameters
        ----------
        most : int
            Shortest steps that are left.
        tried : function
            A step of so many shortest ones, its length [s], which may be less, and its error, NaN for one
            without a state.
        failed : function
            The error for a step that has no state; with its length, for steps that do not converge.
        """
        control, left = self.control, self.seconds(most)
        units = self._halved(left if control is None else control.length(left), most)
        while True:
            found, length, error = tried(units)
            if control is None:
                if np.isnan(error):
                    raise failed(found, None)
                return found, units
            # the first step has no rate before it, and is short
            judged = 0.0 if control.next is None and not np.isnan(error) else error
            shorter = control.judge(length, left, judged)
            if shorter is None:
                return found, units
            if control.is_stuck or units == 1:
                raise failed(found, length)
            units = self._halved(shorter, units // 2)

    def _halved(self, length: float, left: int) -> int:
        """Number of shortest steps in the longest step that is no longer than a length [s]."""
        most = min(left, max(1, int(length / self.longest * 2**self.HALVES * (1.0 + 1e-12))))
        return int(2 ** min(most.bit_length() - 1, self.HALVES))

    def seconds(self, units: int) -> float:
        return float(self.longest * units / 2**self.HALVES)


class Histories:
    """What steps have added, one after the other."""

    def __init__(self) -> None:
        self._rows: dict[str, list[Any]] = {}
        self._gained = 0.0
        self._fields: dict[str, Array] = {}

    def add(self, row: dict[str, Any], velocity: float) -> None:
        """A row of :meth:`HeatedSliding.take`, with the speed [m/s] at its end."""
        self._gained += row.pop("gained")
        self._fields = row.pop("fields")
        for name, value in {**row, "velocity": velocity, "stored": self._gained}.items():
            self._rows.setdefault(name, []).append(value)

    def found(self, sliding: HeatedSliding, margin: float | None) -> dict[str, Any]:
        """All of them, and the state after the last one."""
        return {
            **{name: np.array(values) for name, values in self._rows.items()},
            **self._fields,
            "bodies": tuple(body.nodes() for body in sliding.bodies),
            "thermal_margin": margin,
        }


def stuck(time: float, duration: float, margin: float | None) -> str:
    """What there is to say where no step is short enough."""
    heat = ""
    if margin is not None and margin > 1.0:
        heat = (
            f" Friction makes {margin:.3g} times the heat up to which uneven pressure does not grow by "
            "its own heat: wear, a resistance of the contact or a lower speed bound this growth."
        )
    return (
        f"the steps do not converge: at {time:.4g} s one of {duration:.3g} s still has no single state, or "
        f"an error above the tolerance.{heat}"
    )


def slide_and_heat(
    sliding: HeatedSliding,
    duration: float,
    steps: int,
    velocity: Callable[[float], float],
    tolerance: float | None,
    failed: Callable[[Trial, str | None], Exception],
    progress: Callable[[float], Any] | Literal[True] | None = None,
) -> dict[str, Any]:
    """Histories and last fields of bodies that slide and heat each other over a duration [s].

    Parameters
    ----------
    sliding : HeatedSliding
    duration, steps : float [s], int
        Steps are as long as their quotient, or shorter.
    velocity : function
        Speed [m/s] at a time [s].
    tolerance : float or None
        Of each step.
    failed : function
        The error for a state that was not found, with words for steps that do not converge.
    """
    plan = Steps(duration / steps, tolerance)
    speed = velocity(0.0)
    margin = sliding.thermal_margin(duration, speed)
    left = steps * 2**plan.HALVES
    histories = Histories()

    def tried(units: int) -> tuple[tuple[Trial, float], float, float]:
        length = plan.seconds(units)
        after = velocity(duration - plan.seconds(left - units))
        trial = sliding.tried(length, after, 0.5 * (speed + after))
        return (trial, after), length, trial.error

    def refused(found: tuple[Trial, float], length: float | None) -> Exception:
        return failed(found[0], None if length is None else stuck(sliding.time, length, margin))

    with shares_shown(progress, "heat") as told:
        while left:
            (trial, speed), units = plan.taken(left, tried, refused)
            histories.add(sliding.take(trial), speed)
            left -= units
            told(1.0 - plan.seconds(left) / duration)
    return histories.found(sliding, margin)

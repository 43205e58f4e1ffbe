# SPDX-License-Identifier: MIT OR Apache-2.0
"""A vehicle that brakes: its way, and its shoes over the time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..base.owning import solved
from ..base.plain import plain
from ..base.stored import input_data, stored
from ..base.told import Row, in_words
from ..base.units import taking_quantities
from ..contact.sliding_heat import SlidingHeat
from ..results.doors import pictures
from ..results.fields import Field, totals_of
from ..results.result import Curved

Array = NDArray[np.float64]


@stored
@solved
@dataclass(frozen=True, repr=False)
@plain
class Braking(Curved):
    """A vehicle that brakes by shoes and by other brakes; see :func:`mtb_rs.brake`.

    ``plot()`` draws the speed over the time, ``plot("forces")``, ``plot("peaks")``, ``plot("means")``,
    ``plot("volumes_upper")`` and ``plot("errors")`` these; ``plot("pressure")``,
    ``plot("wear", body="upper")`` and the like draw the last state of the shoe that is pulled most,
    :attr:`shoe`.

    Arrays with k + 1 entries begin with the beginning; those with k entries have one for each step.

    Attributes
    ----------
    time : (k + 1,) [s]
    speed : (k + 1,) [m/s]
    way : (k + 1,) [m]
    forces : (k, m) [N]
        Brake force of each shoe, at the mean speed of each step.
    other_force : (k,) [N]
        Of the other brakes, likewise.
    errors : (k,) [-]
        Estimated error of each step: the largest of those of the shoes (:attr:`SlidingHeat.errors`) and that
        of the speed.
    mass : float [kg]
    shoes : tuple of SlidingHeat
        Each shoe over the steps; those with the same pull are the same.
    summary : Mapping
        What was asked for.
    """

    # what the user has said
    _unbounded = ("summary",)
    curves: ClassVar[tuple[str, ...]] = ("speed", "forces", "peaks", "means", "volumes_upper", "errors")
    over: ClassVar[str] = "the time"

    time: Array
    speed: Array
    way: Array
    forces: Array
    other_force: Array
    errors: Array
    mass: float
    shoes: tuple[SlidingHeat, ...]
    summary: Mapping[str, Any] = field(default_factory=dict, compare=False)

    @property
    def shoe(self) -> SlidingHeat:
        """The shoe that brakes most at the beginning, the first of such: pictures show it."""
        return self.shoes[int(np.argmax(self.forces[0]))]

    @property
    def friction_energy(self) -> float:
        """Heat of friction of all shoes [J]."""
        steps = np.diff(self.time)
        return float(sum(shoe.friction_powers @ steps for shoe in self.shoes))

    @property
    def open_energy(self) -> float:
        """What is left of the kinetic energy that was lost, less the work of the brakes, in parts of it."""
        lost = 0.5 * self.mass * (self.speed[0] ** 2 - self.speed[-1] ** 2)
        work = float(self.other_force @ np.diff(self.way))
        return float((lost - work - self.friction_energy) / lost)

    @property
    def worn_volume(self) -> tuple[float, float]:
        """Volume worn off all shoes and off the rails [m3]."""
        upper = sum(float(shoe.volumes_upper[-1]) for shoe in self.shoes)
        return upper, sum(float(shoe.volumes_lower[-1]) for shoe in self.shoes)

    def _picture(self) -> SlidingHeat:
        return self.shoe

    def _line(self, quantity: str, ax: Any) -> Any:
        return pictures().draw_braking(self, quantity, ax)

    @taking_quantities
    def animate(self, path: str | Path, *, frames: int = 60, frames_per_second: float = 10.0) -> Path:
        """A moving picture of the stop: pressure, temperature and, if it wears, the sole of :attr:`shoe`.

        Above them stand the speed and the brake force of all shoes over the time. The frames are at equal
        distances of time; between the steps the fields are linear. `shoes[k].animate` shows another shoe.

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
            pictures().Line(self.time, 3.6 * self.speed, "speed [km/h]"),
            pictures().Line(self.time[1:], 1e-3 * self.forces.sum(axis=1), "brake force [kN]"),
        ]
        made: Path = pictures().animate_sliding(self.shoe, lines, path, frames, frames_per_second)
        return made

    def _kept(self) -> Braking:
        # those that are the same stay so, and are kept once
        kept = {id(shoe): shoe._kept() for shoe in self.shoes}
        shoes = tuple(kept[id(shoe)] for shoe in self.shoes)
        return replace(self, shoes=shoes, summary=input_data(self.summary))

    def totals(self) -> dict[str, Field]:
        """The stop over the time, by name: values with unit and label."""
        return totals_of(
            time=self.time,
            speed=self.speed,
            way=self.way,
            brake_forces=self.forces,
            other_force=self.other_force,
        )

    def ends(self) -> dict[str, float]:
        """Numbers that it has come to at its end, by name [SI]: the columns of a sweep."""
        upper, lower = self.worn_volume
        return {
            "duration": self.time[-1],
            "way": self.way[-1],
            "end_speed": self.speed[-1],
            "friction_energy": self.friction_energy,
            "peak_temperature": max(float(shoe.peaks.max()) for shoe in self.shoes),
            "peak_pressure": max(float(shoe.pressures.max()) for shoe in self.shoes),
            "volume_upper": upper,
            "volume_lower": lower,
            "error_of_steps": float(np.median(self.errors)),
            "steps": self.time.size - 1,
        }

    def facts(self) -> dict[str, Any]:
        """What else its `summary.json` holds: what was asked for, energies, wear, and how good it is."""
        return {
            "inputs": self.summary,
            "friction_energy": self.friction_energy,
            "open_energy": self.open_energy,
            "worn_volume": self.worn_volume,
            "errors": self.errors,
        }

    def check(self) -> None:
        """Checks that what was read from files fits together; ValueError if it does not."""
        k, m = self.forces.shape if self.forces.ndim == 2 else (0, 0)
        if not k or not m or len(self.shoes) != m:
            raise ValueError(f"forces has the shape {self.forces.shape} beside {len(self.shoes)} shoes")
        wanted = dict.fromkeys(("time", "speed", "way"), (k + 1,))
        for name, shape in (wanted | dict.fromkeys(("other_force", "errors"), (k,))).items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} has the shape {getattr(self, name).shape}: {shape} is needed")
        for shoe in self.shoes:
            shoe.check()
            if shoe.time.shape != (k,):
                raise ValueError(f"a shoe has {shoe.time.size} steps beside {k} of the stop")

    def told(self) -> list[Row]:
        """What happened, in words."""
        upper, lower = (1e9 * volume for volume in self.worn_volume)
        return [
            ("from", f"{in_words(float(self.speed[0]), 'm/s')} to {in_words(float(self.speed[-1]), 'm/s')}"),
            ("duration", f"{in_words(float(self.time[-1]), 's')} in {self.time.size - 1} steps"),
            ("way", in_words(float(self.way[-1]), "m")),
            ("heat of the shoes", in_words(self.friction_energy, "J")),
            ("hottest contact", in_words(max(float(shoe.peaks.max()) for shoe in self.shoes), "K")),
            ("worn off", f"{upper:.4g} mm3 of the shoes, {lower:.4g} mm3 of the rails"),
            ("error of a step", f"{100.0 * float(np.median(self.errors)):.2g} % (median)"),
        ]

    def __repr__(self) -> str:
        return (
            f"Braking({self.speed[0]:.4g} to {self.speed[-1]:.3g} m/s in {self.time[-1]:.4g} s, "
            f"{self.way[-1]:.5g} m, {len(self.shoes)} shoes)"
        )

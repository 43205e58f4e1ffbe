# SPDX-License-Identifier: MIT OR Apache-2.0
"""What a contact was worn by sliding: depths, pressures and profiles over the distance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..base.check import choice, positive
from ..base.owning import solved
from ..base.plain import plain
from ..base.stored import input_data, stored
from ..base.told import Row, along, in_words
from ..base.words import Body, Interpolation
from ..geometry.contact_points import SAME_LINE, Patch
from ..geometry.profiles import Profile
from .doors import pictures
from .fields import Field, fields_of, totals_of
from .result import Curved, Pictured, Result
from .stressed import Loads, Stressed

Array = NDArray[np.float64]

#: What is drawn over the distance.
CURVES = ("depth", "worn_volume", "uniformity", "peak_pressure")


@stored
@solved
@dataclass(frozen=True, repr=False)
@plain
class WearResult(Curved, Stressed, Pictured):
    """A contact and its wear over a sliding distance, as :func:`mtb_rs.wear` finds them.

    ``plot()`` draws the greatest depth over the distance, ``plot("uniformity")``, ``plot("worn_volume")`` and
    ``plot("peak_pressure")`` these; ``plot("wear", body="upper")``, ``plot("pressure")`` and the like draw
    the last state as maps, lines or in space. ``mtb.animate(result.history(), ...)`` shows them in turn.

    The first entry (of k) is the contact before, each further one that after a step. :meth:`stress` is that
    of `final`.

    Attributes
    ----------
    distance : (k,) [m]
        Distance slid by the upper body.
    depths : (2, k, n) [m]
        Worn off the upper and off the lower body, along the normal of the lower one.
    pressures : (k, n) [Pa]
        Mean pressure at each point.
    unknowns : (k, n) [Pa]
        Pressures by which the laws wear: the unknowns of the contact. Under finite elements `pressures` are
        means of them, elsewhere the same.
    forces : (k, 3) [N]
        Load of the contact on the lower body.
    steps : (k,) [m]
        Length of each step.
    errors : (k,) [-]
        Estimated error of the depths of each step, in parts of them and a tenth of all depths (root mean
        squares over the area).
    solves : (k,) int
        Contacts that were solved for each step.
    points : (3, n) [m]
    normal : (3, n) [-]
    area : (n,) [m2]
    initial_gap : (n,) [m]
        Before any wear.
    patches : tuple of Patch
    rail : (4, m) [m], [-]
        y and z of the profile of the lower body and the components of its normals; (4, 0) where it has none.
    final : Result or None
        The worn contact, solved; None for a prepared contact.
    summary : Mapping
        What was asked for.
    """

    # what the user has said
    _unbounded = ("summary",)
    curves: ClassVar[tuple[str, ...]] = CURVES
    over: ClassVar[str] = "the distance"

    distance: Array
    depths: Array
    pressures: Array
    unknowns: Array
    forces: Array
    steps: Array
    errors: Array
    solves: NDArray[np.int64]
    points: Array
    normal: Array
    area: Array
    initial_gap: Array
    patches: tuple[Patch, ...] = ()
    rail: Array = field(default_factory=lambda: np.empty((4, 0)))
    final: Result | None = field(default=None, repr=False)
    summary: Mapping[str, Any] = field(default_factory=dict, compare=False)

    def plot(self, quantity: Any = None, kind: Any = None, **options: Any) -> Any:
        """As :meth:`Result.plot`; "wear" is that of the upper body, where no `body` is given and that alone
        wears.
        """
        if quantity == "wear" and not self.depths[1].any():
            options.setdefault("body", "upper")
        return super().plot(quantity, kind, **options)

    @property
    def pressure(self) -> Array:  # type: ignore[override]
        """Mean pressure (n,) [Pa] at the end."""
        return np.asarray(self.pressures[-1])

    @property
    def status(self) -> NDArray[np.int8]:  # type: ignore[override]
        """0 open, 2 slip (n,) at the end."""
        return np.where(self.pressures[-1] > 0.0, 2, 0).astype(np.int8)

    def _loads(self) -> Loads:
        if self.final is None:
            raise ValueError(
                "this wear is that of a prepared contact, which keeps no friction of the worn contact: wear "
                "of the scene has its stress"
            )
        return self.final._loads()

    @property
    def worn_volume(self) -> Array:
        """Volume (2, k) [m3] worn off the upper and off the lower body."""
        return np.asarray(self.depths @ self.area)

    @property
    def depth(self) -> Array:
        """Greatest depth (2, k) [m] worn off the upper and off the lower body."""
        return np.asarray(self.depths.max(axis=2))

    @property
    def peak_pressure(self) -> Array:
        """Largest mean pressure (k,) [Pa]."""
        return np.asarray(self.pressures.max(axis=1))

    @property
    def uniformity(self) -> Array:
        """Share (k,) of the load below the mean pressure over all contact points; 1 for an even pressure.

        It is the sum of ``min(p, mean) area`` over the force. A body that friction tilts wears in to a
        pressure that rises along it, and its uniformity to less than 1.
        """
        force = self.pressures @ self.area
        mean = force / self.area.sum()
        below = np.minimum(self.pressures, mean[:, None]) @ self.area
        return np.where(force > 0.0, below / np.where(force > 0.0, force, 1.0), 0.0)

    def life(self, limit: float, body: Body = "upper") -> float:
        """Distance [m] at which the deepest point of a body is worn by `limit` [m].

        Between steps the depth is linear. Beyond the last one it goes on as in the last step, which is
        right once the contact is worn in; `inf` where nothing was worn then.
        """
        positive("limit", limit, "m")
        depth, s = self.depth[self._side(body)], self.distance
        if depth[-1] >= limit:
            k = int(np.argmax(depth >= limit))
            if k == 0:
                return float(s[0])
            share = (limit - depth[k - 1]) / (depth[k] - depth[k - 1])
            return float(s[k - 1] + share * (s[k] - s[k - 1]))
        if len(s) < 2 or depth[-1] <= depth[-2]:
            return float("inf")
        rate = (depth[-1] - depth[-2]) / (s[-1] - s[-2])
        return float(s[-1] + (limit - depth[-1]) / rate)

    @property
    def has_profiles(self) -> bool:
        """Whether the contact is on a rail, with rows of contact points along it: see :meth:`profile`."""
        along = [grid.is_along_x(self.points) for grid in self.patches]
        return bool(self.rail.size) and bool(along) and all(along)

    def profile(
        self, body: Body = "lower", interpolation: Interpolation = "smooth", patch: str | None = None
    ) -> Profile:
        """The worn cross-section of a body, the mean along x, as a profile in the frame of the rail.

        The depth is taken off along the normals of the old profile, which are those of the contact. The
        profile of the lower body is the whole rail, that of the upper one the sole over one grid of points.
        Beside the sole the rail is as it was: from the edge of the contact outwards the depth goes to zero
        within 50 um, or twice the depth if that is more, and half of this ditch is lost beyond what the law
        takes.
        `Profile.to_file` writes it, and :meth:`mtb_rs.Profile.from_file` and every scene take it again.

        Parameters
        ----------
        body : "lower" or "upper"
        interpolation : "smooth" or "linear"
            Between the points of the profile.
        patch : str or None
            Grid of the upper body, for example "left"; None: the first one.

        Raises
        ------
        ValueError
            If the lower body has no profile, or the contact points are on no grid along it, as below a turned
            shoe.
        """
        side = self._side(body)
        if not self.rail.size or not self.patches:
            raise ValueError("the contact has no rail: only a contact on a rail has worn profiles")
        if not self.has_profiles:
            raise ValueError(
                "worn profiles are means along x, which need rows of contact points along x: the upper body "
                "must not be turned"
            )
        if side == 0:
            names = [grid.name for grid in self.patches]
            if patch is not None and patch not in names:
                raise ValueError(f"patch is {patch!r}: one of {', '.join(names)} is needed")
            grid = self.patches[0 if patch is None else names.index(patch)]
            if grid.ny < 2:
                sole = f"sole {grid.name}".strip()
                raise ValueError(
                    f"the {sole} is one row of contact points wide, spacing {grid.spacing[1]:g} m: a profile "
                    "needs two rows or more, of a smaller spacing across"
                )
            lift = self.initial_gap + self.depths[0, -1]
            y, z = (grid.view(self.points[c] + lift * self.normal[c]).mean(axis=1) for c in (1, 2))
            return _through(y, z, interpolation, f"worn sole {grid.name}".strip())
        y, z = self.rail[:2]
        old = _through(y, z, interpolation, "rail")
        start, end = old.range
        edges = []
        for grid in self.patches:
            place = grid.view(self.points[1]).mean(axis=1)
            area = grid.view(self.area)
            # nodes at the ends of a row stand for half of what the others do
            worn = (grid.view(self.depths[1, -1]) * area).sum(axis=1) / area.sum(axis=1)
            order = np.argsort(place)
            place, worn = place[order], worn[order]
            # cells reach beyond their middles, along the surface; the outermost nodes are the ends
            half = 0.5 * grid.spacing[1] if grid.holds_cells(self.area) else 0.0
            reach = half * grid.view(self.normal[2]).mean(axis=1)[order[[0, -1]]]
            ends = place[[0, -1]] + np.array([-1.0, 1.0]) * reach
            edges.append((place, worn, ends))
            for edge, deep, out in zip(ends, worn[[0, -1]], (-1.0, 1.0), strict=True):
                if deep > 0.0:
                    wall = np.sort(edge + out * _wall(deep) * WALL)
                    apart = (y < wall[0] - SAME_LINE) | (y > wall[-1] + SAME_LINE)
                    y = np.concatenate([y[apart], wall[(wall >= start) & (wall <= end)]])
        y = np.sort(y)
        depth = sum((_depth(y, *edge) for edge in edges), np.zeros(y.size))
        normal = old.normal(y)
        z = old.height(y) - depth * normal[1]
        return _through(y - depth * normal[0], z, interpolation, "worn rail")

    def history(self) -> list[WearResult]:
        """The result as it was before, and after each step: for moving pictures."""
        names = ("distance", "pressures", "unknowns", "forces", "steps", "errors", "solves")
        return [
            replace(
                self,
                **{name: getattr(self, name)[: k + 1] for name in names},
                depths=self.depths[:, : k + 1],
                final=None,
                summary={**self.summary, "distance": float(self.distance[k])},
            )
            for k in range(len(self.distance))
        ]

    @staticmethod
    def _side(body: Any) -> int:
        return 0 if choice("body", body, Body) == "upper" else 1

    def fields(self) -> dict[str, Field]:
        """The last state over the contact points, by name: values with unit and label."""
        return fields_of(
            points=self.points,
            area=self.area,
            normal=self.normal,
            pressure=self.pressure,
            wear_upper=self.depths[0, -1],
            wear_lower=self.depths[1, -1],
            initial_gap=self.initial_gap,
            status=self.status,
        )

    def totals(self) -> dict[str, Field]:
        """What it has after each step, by name: values with unit and label."""
        return totals_of(
            distance=self.distance,
            depth=self.depth,
            worn_volume=self.worn_volume,
            uniformity=self.uniformity,
            peak_pressure=self.peak_pressure,
            force=self.forces,
        )

    def ends(self) -> dict[str, float]:
        """Numbers that it has come to at its end, by name [SI]: the columns of a sweep."""
        upper, lower = self.worn_volume[:, -1]
        deepest, lowest = self.depth[:, -1]
        return {
            "distance": self.distance[-1],
            "depth_upper": deepest,
            "depth_lower": lowest,
            "volume_upper": upper,
            "volume_lower": lower,
            "peak_pressure": self.peak_pressure[-1],
            "uniformity": self.uniformity[-1],
            **dict(zip(("force_x", "force_y", "force_z"), self.forces[-1], strict=True)),
            "steps": self.distance.size - 1,
        }

    def facts(self) -> dict[str, Any]:
        """What else its `summary.json` holds: what was asked for, the steps and how good they are."""
        return {"inputs": self.summary, "errors": self.errors, "solves": self.solves, "steps": self.steps}

    def told(self) -> list[Row]:
        """What was worn, in words: what a notebook and the command line show."""
        upper, lower = self.worn_volume[:, -1]
        deepest = self.depth[:, -1]
        rows = [
            ("sliding distance", in_words(self.distance[-1], "m")),
            ("worn off the upper body", f"{1e6 * deepest[0]:.4g} µm at most, {1e9 * upper:.4g} mm3"),
        ]
        if lower > 0.0:
            rows.append(
                ("worn off the lower body", f"{1e6 * deepest[1]:.4g} µm at most, {1e9 * lower:.4g} mm3")
            )
        first, last = self.peak_pressure[[0, -1]]
        even = 100.0 * self.uniformity[[0, -1]]
        return [
            *rows,
            ("peak pressure", f"{first / 1e6:.5g} MPa new, {last / 1e6:.5g} MPa worn"),
            ("uniformity", f"{even[0]:.4g} % new, {even[1]:.4g} % worn"),
            ("force on the lower body", along(self.forces[-1], "N")),
            ("steps", f"{len(self.distance) - 1}, {int(self.solves.sum())} contacts solved"),
        ]

    def check(self) -> None:
        """Checks that what was read from files fits together; ValueError if it does not."""
        super().check()
        k, n = len(self.distance), self.points.shape[1]
        wanted = {"depths": (2, k, n), "pressures": (k, n), "unknowns": (k, n), "forces": (k, 3)}
        for name, shape in (wanted | dict.fromkeys(("steps", "errors", "solves"), (k,))).items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} has the shape {getattr(self, name).shape}: {shape} is needed")

    def _kept(self) -> WearResult:
        final = None if self.final is None else self.final._kept()
        return replace(self, final=final, summary=input_data(self.summary))

    def _line(self, quantity: str, ax: Any) -> Any:
        return pictures().draw_wear(self, quantity, ax)

    def __repr__(self) -> str:
        upper, lower = 1e6 * self.depth[:, -1]
        return (
            f"WearResult({self.distance[-1]:.6g} m in {len(self.distance) - 1} steps, {self.area.size} "
            f"points, worn by {upper:.4g} and {lower:.4g} um, uniformity {self.uniformity[-1]:.3f})"
        )


#: Points of a wall beside the worn contact, from its edge on, over its width. Points that lie closer to each
#: other there, step by step, keep a smooth line from swinging beside it.
WALL = np.concatenate([[-1.0, -0.5, -0.25], np.linspace(-0.125, 1.125, 11), [1.25, 1.5, 2.0]])


def _wall(depth: float) -> float:
    """Width [m] over which a depth goes to zero beside the contact.

    It is so steep that little is lost there, and so that points moved along normals keep their order.
    """
    return float(max(50e-6, 2.0 * depth))


def _depth(y: Array, place: Array, worn: Array, ends: Array) -> Array:
    """Depth [m] at `y` of what is worn at the rows `place` of a grid between its `ends`.

    It is constant over the outermost half cells and smooth in the walls beside them.
    """
    below, above = (ends[0] - y) / _wall(worn[0]), (y - ends[1]) / _wall(worn[-1])
    beyond = np.clip(np.maximum(below, above), 0.0, 1.0)
    # neither slope nor curvature where the wall begins and ends
    left = 1.0 - beyond**3 * (10.0 - 15.0 * beyond + 6.0 * beyond**2)
    return np.asarray(np.interp(y, place, worn) * left)


def _through(y: Array, z: Array, interpolation: Interpolation, name: str) -> Profile:
    order = np.argsort(y)
    return Profile.from_points(y[order], z[order], interpolation, name)

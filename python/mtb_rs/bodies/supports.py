# SPDX-License-Identifier: MIT OR Apache-2.0
"""Places on a body, and the supports that hold it there."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeGuard, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import choice, number, reals, warn
from ..base.owning import owning
from ..base.plain import plain
from ..base.questions import ask
from ..base.words import Held

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Where on a body: the name of a node set or of a side of its bounding box; a function of points (3, n) [m],
#: all x first, that says (n,) which belong; a box ((x0, x1), (y0, y1), (z0, z1)) [m] with None for an
#: open end; points (k, 3) [m], each the node nearest to it: a body on points becomes softer as its elements
#: shrink, without limit.
Where = str | Callable[[Array], NDArray[np.bool_]] | Sequence[Any] | Array

#: Ready ways to hold the top of a block or a pole.
SUPPORTS: tuple[Held, ...] = get_args(Held)

#: Sides of the bounding box: axis, and whether the upper end.
SIDES = {
    "bottom": (2, False),
    "top": (2, True),
    "rear": (0, False),
    "front": (0, True),
    "right": (1, False),
    "left": (1, True),
}


@dataclass(frozen=True)
@plain
class Guide:
    """All nodes of a support share one unknown displacement, under a given total force.

    Parameters
    ----------
    force : float [N]
        Applied to the guide, along the component.
    """

    force: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "force", number("force of a guide", self.force, "N"))


@owning
@dataclass(frozen=True)
@plain
class Support:
    """A support: nodes of a body that are held.

    Parameters
    ----------
    where
        Place on the body, in one of these forms:

        - a name: of a set of nodes of the mesh, or of a side of the box around the body, "bottom" (least z),
          "top", "rear" (least x), "front", "right" (least y) or "left";
        - a box ((x0, x1), (y0, y1), (z0, z1)) [m]: the two ends along each axis, with None for an open end.
          Two corners ((x, y, z), (x, y, z)) are no box but two points;
        - a function of points (3, n) [m] that says (n,) which belong: ``lambda p: p[2] < 1e-6``, or a ``def``
          with ``x, y, z = points``;
        - points (k, 3) [m]: of each the nearest node. A body that is held at points becomes softer as its
          elements shrink, without limit.
    x, y, z : float [m], Guide or None
        Each component is prescribed (a displacement), guided (one common unknown displacement), or free
        (None).
    name : str
        For reports; without one that of the place, or "box", "function" or "points".
    """

    where: Where
    x: float | Guide | None = None
    y: float | Guide | None = None
    z: float | Guide | None = None
    name: str = ""

    def __post_init__(self) -> None:
        if is_at_points(self.where):
            ask(of_corners(f"where of {self.name or 'a support'}", _places(self.where)))
        for component in "xyz":
            value = getattr(self, component)
            if value is not None and not isinstance(value, Guide):
                object.__setattr__(self, component, number(f"{component} of a support", value, "m"))
        if not isinstance(self.name, str):
            raise ValueError(f"name of a support is {self.name!r}: a word is needed")
        if not self.name:
            object.__setattr__(self, "name", _named(self.where))

    @property
    def values(self) -> tuple[float | Guide | None, ...]:
        """What x, y and z are given."""
        return self.x, self.y, self.z

    @property
    def guides(self) -> dict[int, Guide]:
        """The guides, by component."""
        return {k: value for k, value in enumerate(self.values) if isinstance(value, Guide)}

    @property
    def prescribed(self) -> dict[int, float]:
        """The displacements [m], by component."""
        given = {k: value for k, value in enumerate(self.values) if value is not None}
        return {k: value for k, value in given.items() if not isinstance(value, Guide)}

    @property
    def given(self) -> dict[int, float]:
        """What each component that is not free is given: displacement [m], or force on its guide [N]."""
        return self.prescribed | {k: guide.force for k, guide in self.guides.items()}

    @property
    def words(self) -> tuple[str, ...]:
        """How x, y and z are held, as the core names it."""
        return tuple(
            "guided" if k in self.guides else "prescribed" if k in self.prescribed else "free"
            for k in range(3)
        )


def held_by(supports: Any) -> str | tuple[Support, ...]:
    """What a ready scene is given for its supports, checked."""
    if isinstance(supports, str):
        return str(choice("supports", supports, Held))
    if isinstance(supports, (list, tuple)) and all(isinstance(s, Support) for s in supports):
        return tuple(supports)
    known = ", ".join(map(repr, SUPPORTS))
    raise ValueError(f"supports is {supports!r}: one of {known} or a list of mtb_rs.Support is needed")


def select(
    nodes: Array, node_sets: Mapping[str, Index], where: Where, whole: Array | None = None
) -> NDArray[np.bool_]:
    """Which nodes (n, 3) are at a place; sides are those of the bounding box of `whole` (the nodes).

    Raises
    ------
    ValueError
        If the place is none of the forms of :data:`Where`.
    """
    found = np.zeros(len(nodes), dtype=bool)
    if isinstance(where, str):
        if where in node_sets:
            found[node_sets[where]] = True
            return found
        if where not in SIDES:
            known = ", ".join(repr(k) for k in dict.fromkeys([*node_sets, *SIDES]))
            raise ValueError(f"{where!r} is unknown: {known} are known")
        axis, upper = SIDES[where]
        whole = nodes if whole is None else whole
        low, high = whole[:, axis].min(), whole[:, axis].max()
        near = 1e-6 * np.ptp(whole, axis=0).max()
        return np.asarray(nodes[:, axis] >= high - near if upper else nodes[:, axis] <= low + near)
    if callable(where):
        return _told(where, nodes)
    if is_box(where):
        found[:] = True
        for axis, (low, high) in enumerate(where):
            found &= nodes[:, axis] >= (-np.inf if low is None else low - 1e-9)
            found &= nodes[:, axis] <= (np.inf if high is None else high + 1e-9)
        return found
    found[_mtb_rs.nearest_nodes(nodes, _places(where).tolist())] = True
    return found


def _told(where: Callable[[Array], Any], nodes: Array) -> NDArray[np.bool_]:
    """Which nodes (n, 3) a function says belong. It takes points (3, n); those of (n, 3) are still taken."""
    asked = _asked(where, np.ascontiguousarray(nodes.T), len(nodes))
    if isinstance(asked, str):
        as_before = _asked(where, np.array(nodes), len(nodes))
        if isinstance(as_before, str):
            raise ValueError(f"the function {asked}: a function of points (3, n) [m] to bool (n,) is needed")
        warn(
            f"The function {getattr(where, '__name__', repr(where))}, which selects a place on a body, takes "
            "points of shape (n, 3). That is deprecated: points are now given as (3, n), so that "
            "x, y, z = points.",
            DeprecationWarning,
        )
        asked = as_before
    return asked


def _asked(where: Callable[[Array], Any], points: Array, count: int) -> NDArray[np.bool_] | str:
    """What a function says of points, or why that is no answer."""
    try:
        told = np.asarray(where(points))
    except Exception as error:  # functions of users fail as they like
        return f"fails with {type(error).__name__}: {error}"
    if told.shape != (count,) or told.dtype != bool:
        return f"returns {told.dtype} of shape {told.shape}, not bool of shape {(count,)}"
    return told


def _named(where: Where) -> str:
    """What a support without a name is called."""
    if isinstance(where, str):
        return where
    if callable(where):
        return "function"
    return "box" if is_box(where) else "points"


def is_box(where: Any) -> bool:
    """Whether this is ((x0, x1), (y0, y1), (z0, z1)), with None for an open end."""
    try:
        ends = [end for low, high in where for end in (low, high)]
    except (TypeError, ValueError):
        return False
    if len(ends) != 6:
        return False
    for end in ends:
        if end is not None:
            number("an end of a box", end, "m")
    for axis, (low, high) in zip("xyz", where, strict=True):
        if low is not None and high is not None and low > high:
            raise ValueError(f"a box runs from {axis} = {low:g} to {high:g} m: the lower end comes first")
    return True


def is_at_points(where: Any) -> TypeGuard[Sequence[Any] | Array]:
    """Whether this is points (k, 3), each of which is the node nearest to it."""
    return not isinstance(where, str) and not callable(where) and not is_box(where)


def are_at_points(supports: Sequence[Support]) -> bool:
    """Whether any of these holds single nodes, which give way more the narrower the elements are."""
    return any(is_at_points(support.where) for support in supports)


def of_corners(what: str, points: Array) -> list[str]:
    """Questions about points (k, 3) [m] that may be meant as the two corners of a box."""
    if len(points) != 2 or (points[0] == points[1]).any():
        return []
    box = ", ".join(f"({low:g}, {high:g})" for low, high in np.sort(points, axis=0).T)
    return [
        f"{what} is two points, of which each stands for the node nearest to it: are they meant as the "
        f"corners of a box? A box gives the two ends along each axis, ({box})"
    ]


def place_in_words(where: Where) -> str:
    """A place for a message."""
    if isinstance(where, str):
        return repr(where)
    if callable(where):
        return "given as a function"
    if is_box(where):
        return "given as a box"
    points = _places(where)
    if len(points) == 1:
        return "given as a point"
    box = " (a box is ((x0, x1), (y0, y1), (z0, z1)), not two corners)" if len(points) == 2 else ""
    return f"given as {len(points)} points{box}"


def _places(points: ArrayLike) -> Array:
    """Points (k, 3) [m], checked."""
    try:
        places = np.atleast_2d(reals("where", points, "m"))
    except ValueError as error:
        places, reason = np.empty((0, 0)), f"{error}; "
    else:
        reason = f"where has shape {places.shape}; "
    if places.ndim != 2 or places.shape[1] != 3 or not places.size:
        raise ValueError(
            f"{reason}a name, a function, a box ((x0, x1), (y0, y1), (z0, z1)) or points (k, 3) "
            "in metres are needed"
        )
    return places

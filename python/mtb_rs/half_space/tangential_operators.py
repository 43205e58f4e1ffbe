# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the core takes for a tangential problem: operators around the contact, earlier states there."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base import memory
from ..bodies.simple import Core, Medium, do_creep, medium_of
from ..friction.laws import Friction, InterfaceLayer, PlasticLayer
from ..geometry.contact_points import window
from .motions import Motion, Rolling, Shift
from .pressure_field import PressureField
from .tangential_state import TangentialState

Array = NDArray[np.float64]
Pair = tuple[float, float]


class Key(NamedTuple):
    """All that the operators depend on."""

    shape: tuple[int, int]
    spacing: Pair
    lower: Core | None
    upper: Core | None
    layer: float
    motion: str
    step: Pair
    reference: float | None
    softens: bool
    inclination: tuple[float, ...] | None = None
    prisms: tuple[_mtb_rs.PrismPair, int] | None = None
    is_second_order: bool = False

    def of(self, bodies: Mapping[str, Core]) -> Key:
        """The same with other bodies, by their sides."""
        return self._replace(lower=bodies.get("lower", self.lower), upper=bodies.get("upper", self.upper))


@lru_cache(maxsize=4)
def operators_of(key: Key) -> _mtb_rs.PatchOperators:
    return _mtb_rs.PatchOperators(*key)


def velocity_of(field: PressureField, motion: Motion) -> Pair | None:
    """Velocity (x, y) [m/s] at which the contact moves over bodies that creep; None where none does.

    Raises
    ------
    ValueError
        For a motion that has a past.
    """
    if not do_creep(field.lower, field.upper):
        return None
    return motion.steady_velocity


def _constants(body: Medium | None, velocity: Pair | None) -> Core | None:
    return None if body is None else medium_of(body, velocity)


def key_of(
    field: PressureField,
    motion: Rolling | Shift,
    layer: InterfaceLayer | PlasticLayer | None,
    cut: tuple[slice, slice],
) -> Key:
    """What the operators on a rectangle of cells depend on."""
    plasticity = None if layer is None else layer.plasticity
    velocity = velocity_of(field, motion)
    softens = plasticity is not None and plasticity[1] < 0.0
    inclination = None
    if field.inclination is not None:
        _check_along(motion, softens, "the surface is inclined across the rows of cells")
        rows = np.clip(np.arange(cut[0].start, cut[0].stop), 0, field.inclination.size - 1)
        inclination = tuple(field.inclination[rows].tolist())
    prisms = None
    if (under := field.prisms()) is not None:
        _check_along(motion, softens, "a body is a Prism along the rows of cells")
        rows = field.pressure.shape[0]
        if cut[0].start < 0 or cut[0].stop > rows:
            raise ValueError(
                f"the state was in contact beyond the {rows} rows of cells, and a body is a Prism, which is "
                "known under these alone: a field of more rows is needed"
            )
        prisms = under.core, cut[0].start
    return Key(
        shape=(cut[1].stop - cut[1].start, cut[0].stop - cut[0].start),
        spacing=field.spacing,
        lower=_constants(field.lower, velocity),
        upper=_constants(field.upper, velocity),
        layer=0.0 if layer is None else layer.flexibility,
        motion=motion.kind,
        step=motion.step_on(field),
        reference=field.reference,
        softens=softens,
        inclination=inclination,
        prisms=prisms,
        is_second_order=motion.order == 2,
    )


def _check_along(motion: Rolling | Shift, softens: bool, cause: str) -> None:
    """Whether a motion and a layer are known where rows are not alike."""
    if abs(math.sin(motion.direction)) > 1e-9:
        raise ValueError(
            f"{cause}, and angle is {motion.direction:g} rad: rolling along the rows, 0 or pi, is needed"
        )
    if softens:
        raise ValueError(f"{cause}, and the layer softens: one that does not soften is needed")


def plasticity_of(
    layer: InterfaceLayer | PlasticLayer | None,
    state: TangentialState | None,
    there: tuple[slice, slice] | None,
) -> tuple[float, float, Array | None] | None:
    """The yield of a layer, with the plastic slip of an earlier state on a rectangle of its cells."""
    if layer is None or layer.plasticity is None:
        return None
    earlier = None
    if state is not None and there is not None:
        before = state.accumulated_plastic_slip
        earlier = window(np.zeros(state.pressure.shape) if before is None else before, there)
    return (*layer.plasticity, earlier)


def cut_before(state: TangentialState, field: PressureField, cut: tuple[slice, slice]) -> tuple[slice, slice]:
    """A rectangle of cells of the field, in those of an earlier state."""
    rows, columns = state.cells_before(field)
    return (
        slice(cut[0].start - rows, cut[0].stop - rows),
        slice(cut[1].start - columns, cut[1].stop - columns),
    )


def earlier(
    state: TangentialState | None, friction: Friction, there: tuple[slice, slice] | None
) -> tuple[Array, Array, Array] | None:
    """An earlier state on a rectangle of its cells, as the core takes it."""
    if state is None or there is None:
        return None
    return (
        window(state.traction, there),
        window(state.pressure, there),
        window(state.coefficient, there, fill=friction.at_rest()),
    )


def operators_around(
    field: PressureField,
    motion: Rolling | Shift,
    layer: InterfaceLayer | PlasticLayer | None,
    state: TangentialState | None,
) -> tuple[_mtb_rs.PatchOperators, tuple[slice, slice], Pair]:
    """Operators on the smallest rectangle that holds the contact, that rectangle, and its first cell.

    The rectangle is in cells of the field, and goes beyond them where the state does.
    """
    loaded = np.argwhere(field.pressure > 0.0)
    if not loaded.size:
        raise ValueError("the pressure is zero everywhere: there is no contact to roll or to slide")
    if state is not None:
        carried = np.any(state.traction != 0.0, axis=0) | (state.pressure > 0.0)
        if state.accumulated_plastic_slip is not None and motion.kind == "shift":
            # in rolling, what has left the contact does not come back
            carried |= state.accumulated_plastic_slip > 0.0
        loaded = np.concatenate([loaded, np.argwhere(carried) + state.cells_before(field)])
    first, last = loaded.min(axis=0).tolist(), loaded.max(axis=0).tolist()
    cut = (slice(first[0], last[0] + 1), slice(first[1], last[1] + 1))
    key = key_of(field, motion, layer, cut)
    origin = (
        field.start[0] + cut[1].start * field.spacing[0],
        field.start[1] + cut[0].start * field.spacing[1],
    )
    nx, ny = key.shape
    needed, what = memory.ROLLING_CELL[key.motion] * nx * ny, f"the tangential contact of {nx} x {ny} cells"
    memory.refuse(needed, what, "take fewer, larger cells")
    memory.say(needed, what)
    return operators_of(key), cut, origin

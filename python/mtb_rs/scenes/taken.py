# SPDX-License-Identifier: MIT OR Apache-2.0
"""Which fields of a scene each way takes that goes round the contact problem.

A :class:`mtb_rs.contact.problem.ContactProblem` holds all that a scene states. Other ways read bodies, gap
and load off the scene, or the two bodies off the problem, and know of nothing else. Here each of them names
the fields that it takes, and those that are certain to change nothing in it. A scene that states more does
not go that way, or is refused there. So a field that is new is on no list, and none of these ways passes it
by.
"""

from __future__ import annotations

import reprlib
from dataclasses import fields

from ..base.plain import same
from .posed import PosedScene

_BODIES = {"upper", "lower", "geometry", "spacing"}
#: Everything sliding takes, and what is idle in it: a layer that shears and does not yield.
_SLIDING = {"friction", "sliding_direction", "velocity", "layer"}
#: Of the finite elements, which half-spaces do without.
_ELEMENTS = {"supports", "element_size"}
_PROBLEM = _BODIES | _SLIDING | _ELEMENTS | {"gap", "force", "approach", "moments"}

#: Fields by the way that takes them.
TAKEN = {
    "convolutions": _PROBLEM | {"magnetic_pressure", "attraction"},
    "load increments": _PROBLEM | {"magnetic_pressure", "attraction"},
    "the staggered loop": _PROBLEM | {"magnetic_pressure", "attraction"},
    "convolutions of a chart": (_PROBLEM | {"magnetic_pressure"}) - {"moments"},
    "Hertz' closed form": _BODIES | _SLIDING | {"force"},
    "wheels in steps": _BODIES | {"friction", "layer", "force", "sliding_direction"},
}


def beyond(scene: PosedScene, way: str) -> list[str]:
    """Fields that are not at their default in the scene, and that a way does not take."""
    taken = TAKEN[way] | {"name"}
    slides = scene.sliding_direction is not None or way == "wheels in steps"
    if slides and scene.layer is not None and scene.layer.plasticity is not None:
        # it bounds the friction, which none of these ways asks for
        taken = taken - {"layer"}
    return [
        f.name
        for f in fields(scene)
        # `compare` tells what a scene is made of from what it was made by
        if f.compare and f.name not in taken and not same(getattr(scene, f.name), f.default)
    ]


def refuse_beyond(scene: PosedScene, way: str) -> None:
    """ValueError, naming the first field that the scene states and that a way does not take."""
    for name in beyond(scene, way):
        default = next(f.default for f in fields(scene) if f.name == name)
        raise ValueError(
            f"{name} is {reprlib.repr(getattr(scene, name))}: {way} cannot take it, only {default!r}"
        )

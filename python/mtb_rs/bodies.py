# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies, as the contact sees them."""

from __future__ import annotations

from dataclasses import dataclass

from .material import Material
from .plain import plain


@dataclass(frozen=True)
@plain
class HalfSpace:
    """A body so large that its contact cannot tell it from an elastic half-space."""

    material: Material


@dataclass(frozen=True)
@plain
class Rigid:
    """A body that does not deform."""


Simple = HalfSpace | Rigid


def as_body(name: str, body: object) -> Simple:
    """A body, or the half-space of a material."""
    if isinstance(body, Material):
        return HalfSpace(body)
    if isinstance(body, (HalfSpace, Rigid)):
        return body
    raise ValueError(f"{name} is {body!r}: a Material, HalfSpace, Rigid or ElasticBody is needed")

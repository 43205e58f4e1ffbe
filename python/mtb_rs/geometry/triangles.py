# SPDX-License-Identifier: MIT OR Apache-2.0
"""Triangulated bodies, for pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..base.owning import owning
from ..base.plain import plain
from ..base.stored import stored

Array = NDArray[np.float64]


@stored
@owning
@dataclass(frozen=True)
@plain
class Surface:
    """A triangulated body for pictures: vertices (3, n) [m], triangles (m, 3), displacement (3, n) [m].

    Elastic bodies of finite elements also have von Mises' equivalent stress (n,) [Pa].
    """

    name: str
    vertices: Array
    triangles: NDArray[np.int64]
    displacement: Array | None = None
    von_mises: Array | None = None

    @property
    def label(self) -> str:
        """Its name in a picture: without its side, if anything is left."""
        side, _, own = self.name.partition(" ")
        if side not in ("upper", "lower"):
            return self.name
        return own or f"{side} body"


def height_surface(name: str, x: Array, y: Array, z: Array) -> Surface:
    """Triangles over the grid of `x` and `y` with heights `z` (ny, nx)."""
    grid_x, grid_y = np.meshgrid(x, y)
    ny, nx = z.shape
    corner = (np.arange(ny - 1)[:, None] * nx + np.arange(nx - 1)[None, :]).ravel()
    triangles = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + nx + 1], axis=1),
            np.stack([corner, corner + nx + 1, corner + nx], axis=1),
        ]
    )
    return Surface(name, np.stack([grid_x.ravel(), grid_y.ravel(), z.ravel()]), triangles)


def prism_surface(name: str, section: Array, x: Array) -> Surface:
    """Closed surface of a `section` (2, k) in y and z (a ring around its interior), drawn out over `x`."""
    k, nx = section.shape[1], x.size
    vertices = np.stack([np.repeat(x, k), np.tile(section[0], nx), np.tile(section[1], nx)])
    i, j = np.meshgrid(np.arange(nx - 1), np.arange(k), indexing="ij")
    a = (i * k + j).ravel()
    b = (i * k + (j + 1) % k).ravel()
    sides = np.concatenate([np.stack([a, b, b + k], axis=1), np.stack([a, b + k, a + k], axis=1)])
    # ends as strips between the sole and the top: sections are worn soles under flat tops
    caps = []
    for start in (0, (nx - 1) * k):
        for low in range(k // 2):
            high = k - 1 - low
            if low + 1 < high:
                caps.append([start + low, start + low + 1, start + high])
            if low + 1 < high - 1:
                caps.append([start + low + 1, start + high - 1, start + high])
    return Surface(name, vertices, np.concatenate([sides, np.array(caps, dtype=np.int64).reshape(-1, 3)]))

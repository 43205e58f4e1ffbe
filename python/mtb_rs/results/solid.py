# SPDX-License-Identifier: MIT OR Apache-2.0
"""The inside of a loaded elastic body, as pictures and files need it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..base.owning import solved
from ..base.plain import plain
from ..base.stored import stored
from ..bodies.mesh import TetraMesh
from ..geometry.triangles import Surface

if TYPE_CHECKING:
    from ..bodies.elastic_body import BodyState
    from ..bodies.sides import ElasticPart

Array = NDArray[np.float64]


@stored
@solved
@dataclass(frozen=True)
@plain
class Solid:
    """A loaded elastic body as plain data: the same in a result that was solved and in one that was loaded.

    Attributes
    ----------
    name : str
    upper : bool
    is_half : bool
        Whether it is the half y >= 0 of a body, the other half being its mirror image.
    mesh : TetraMesh
    displacement : (3, N) [m]
        Of the nodes.
    stress : (6, N) [Pa]
        At the nodes: xx, yy, zz, yz, xz, xy.
    von_mises : (N,) [Pa]
    reactions, moments : Mapping of names to (3,) [N], [N m]
        Of each support on the body, about the origin.
    surface : Surface
        Its boundary.
    """

    name: str
    upper: bool
    is_half: bool
    mesh: TetraMesh
    displacement: Array
    stress: Array
    von_mises: Array
    reactions: Mapping[str, Array]
    moments: Mapping[str, Array]
    surface: Surface

    def __post_init__(self) -> None:
        nodes, cells = np.asarray(self.mesh.nodes), np.asarray(self.mesh.cells)
        n = len(nodes)
        shapes = (self.displacement.shape, self.stress.shape, self.von_mises.shape)
        if shapes != ((3, n), (6, n), (n,)) or nodes.shape != (n, 3) or not n:
            raise ValueError(
                f"the body {self.name!r} has {nodes.shape} nodes, but displacement, stress and von Mises' "
                f"stress of {shapes}"
            )
        if cells.ndim != 2 or cells.shape[1] not in (4, 10) or not cells.size:
            raise ValueError(f"the body {self.name!r} has cells of shape {cells.shape}: (m, 4) or (m, 10)")
        if cells.min() < 0 or cells.max() >= n:
            raise ValueError(f"the body {self.name!r} has {n} nodes, its cells name others")


def solid_of(part: ElasticPart, state: BodyState) -> Solid:
    """An elastic body of a result from what was solved."""
    # the names of sets of nodes are the user's business: nothing is drawn of them
    mesh = TetraMesh(state.body.mesh.nodes, state.body.mesh.cells)
    return Solid(
        name=state.body.name,
        upper=part.upper,
        is_half=part.is_half,
        mesh=mesh,
        displacement=state.displacement,
        stress=state.stress,
        von_mises=state.von_mises,
        reactions=state.reactions,
        moments=state.moments,
        surface=state.surface,
    )

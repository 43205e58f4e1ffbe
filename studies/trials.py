# SPDX-License-Identifier: MIT OR Apache-2.0
"""What is tried of derivatives: a solved scene, what it was given, and how it is solved with other inputs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: What is derived, by name: how it is asked for, its value in a result, its size.
Numbers = dict[str, tuple[Any, Callable[[Any], Array], float]]


@dataclass(frozen=True)
class Input:
    """What is given: its shape, its size, the result after a change of it, and where it may change."""

    shape: tuple[int, ...]
    size: Any
    solve: Callable[[Array], Any]
    where: Any = True


def flowing(result: Any) -> bytes:
    """The state of every point, and which are at the hardness."""
    hardness = getattr(result, "hardness", None)
    flows = b"" if hardness is None else (result.pressure >= hardness).tobytes()
    return bytes(np.asarray(result.status).tobytes() + flows)


@dataclass(frozen=True)
class Trial:
    """A solved scene, how it is solved with other inputs, and the steps of differences over their sizes.

    What is condensed, and steps that take the factors of another step, have fewer digits than other solves.
    `state` tells what has to stay the same; `numbers` what is derived, where it is not what other results
    have; `has_kinks` that differences of what is given have kinks of their own, as profiles have at stations.
    """

    result: Any
    inputs: dict[str, Input]
    width: float = 1e-4
    state: Callable[[Any], bytes] = flowing
    numbers: Numbers | None = None
    has_kinks: bool = False

# SPDX-License-Identifier: MIT OR Apache-2.0
"""How a solve went."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass(frozen=True)
class Report:
    """How a solve went, in counts, residuals and seconds.

    Attributes
    ----------
    converged : bool
        Whether the conditions of contact hold to the tolerance asked for.
    status : str
        Why the solver stopped, in words.
    model : str
        What was modelled: "half-space", "elastic-upper", "elastic-both", ...
    method : str
        The algorithm: "direct", "incremental", "staggered", ...
    solver : str
        What solved the equations, for example "active set, dense LU" or "conjugate gradients, FFT".
    iterations : int
    convolutions, preconditionings : float
        Products with the influence matrix and applications of the preconditioner, in equivalents of
        one on the finest grid.
    residual : float [-]
        Relative complementarity residual.
    contact_area : float [m2]
    peak_pressure : float [Pa]
    force_balance : Mapping[str, Any]
        Forces [N] that must cancel: contact, magnetic, support reactions, and their relative sum.
    omitted : Mapping[str, Any]
        What the model leaves out, with the estimated size of each omission where it was measured.
    wedging_margin : float [-] or None
        mu / mu_sym: below 1 the sliding equilibrium exists and is unique.
    time_s : Mapping[str, float] [s]
        Wall time by stage.
    history : tuple of float
        Residual by iteration, where the solver keeps it.
    """

    converged: bool
    status: str
    model: str
    method: str
    solver: str
    iterations: int
    residual: float
    contact_area: float
    peak_pressure: float
    convolutions: float = 0.0
    preconditionings: float = 0.0
    force_balance: Mapping[str, Any] = field(default_factory=dict)
    omitted: Mapping[str, Any] = field(default_factory=dict)
    wedging_margin: float | None = None
    time_s: Mapping[str, float] = field(default_factory=dict)
    history: tuple[float, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The report as plain Python data, ready for JSON."""
        return asdict(self)

# SPDX-License-Identifier: MIT OR Apache-2.0
"""How a solve went."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any, get_args

from ..base.owning import solved
from ..base.plain import plain
from ..base.stored import stored
from ..base.told import Row, Told, stated
from ..base.words import Quantity


@stored
@solved
@dataclass(frozen=True)
@plain
class Report(Told):
    """How a solve went, in counts, residuals and seconds.

    Attributes
    ----------
    converged : bool
        Whether the conditions of contact hold to the tolerance asked for.
    status : str
        Why the solver stopped, in words.
    model : str
        The model: "half-space", "elastic-upper", "elastic-both", ...
    method : str
        The algorithm: "direct", "incremental", "staggered", ...
    solver : str
        The solver of the equations, for example "active set, dense LU" or "conjugate gradients, FFT".
    iterations : int
    convolutions, preconditionings : float
        Products with the influence matrix and applications of the preconditioner, in equivalents of
        one on the finest grid.
    residual : float [-]
        Relative complementarity residual. After `solve_normal` it is the largest gap where there is pressure
        or penetration where there is none, over the root mean square of the elastic displacement where there
        is pressure, which contains the compression of a layer.
    contact_area : float [m2]
    peak_pressure : float [Pa]
    force_balance : Mapping[str, Any]
        Forces (3,) [N] that must cancel: "contact" (on the lower body), "magnetic" (on the upper one), "pull"
        (a prescribed force), "supports of the upper body", "supports of the lower body". Reactions of elastic
        bodies are those of their finite elements, stiffness times displacement minus load. "relative_error"
        is the largest sum of all forces and moments on a body or along a free motion, relative to the sum of
        their sizes (a moment counts as the force that makes it on the length of the body).
    reactions : Mapping[str, (3,) array] [N]
        Force of each support on its elastic body, under "body: support".
    omitted : Mapping[str, Any]
        The effects that the model leaves out, with the estimated size of each one that was measured.
    error_estimates : Mapping of "pressure", "force", "displacement" to numbers [-]
        Estimated relative errors by the discretisation and by the effects that are left out. The displacement
        is the normal one of the lower body; if that is rigid, the error is that of the pressure. Empty if the
        errors are not known.
    aim : (quantity, tolerance) or None
        The quantity and the tolerance that were asked for.
    missed : str
        The accuracy that was reached and the cells that would meet the tolerance, if the estimate exceeds it,
        or why no error can be estimated; otherwise empty.
    spacing : (dx, dy) [m] or None
        Spacing of the contact points, if they lie on grids.
    operations : Mapping[str, float]
        Floating-point operations by stage. They are counted also if the work was found in the cache.
        "condensation" and "solution" belong to the returned result, "choice and estimate" to all other
        solves.
    wedging_margin : float [-] or None
        The larger of mu / mu_sym and of `tipping_margin`. mu_sym is the friction coefficient below which,
        with all tilts held, exactly one sliding equilibrium exists for every load [Cottle2009, ch. 3]. With
        free tilts on whose balance friction acts, nothing is proved, and a body can tip over. Above 1 an
        equilibrium may or may not exist.
    tipping_margin : float [-] or None
        Distance of the resultant of the loads from the middle of the contact points, divided by the distance
        at which a body tips over. Friction on a tall body shifts the resultant. 0 means the middle, and above
        1 no pressure balances the load. None if no load determines the force.
    magnet : Mapping[str, Any]
        Of a :class:`mtb_rs.Magnet`, otherwise empty: "attraction" [N] (sum of its pressure times area),
        "flux" [Wb] through the poles, "ampere_turns_of_poles" [A], "solves" (states of the contact until gaps
        and pull fitted each other), "residual" [-] (what they still differ by, relative to the largest pull)
        and
        "snap_share" [-] where a scene was solved: the stiffness of the magnet in parts of that of what holds
        the bodies. From 1 on the state does not stay.
    time_s : Mapping[str, float] [s]
        Wall time by stage.
    notes : tuple of str
        What was done otherwise than usual, or not at all, in sentences.
    history : tuple of float
        Residual by iteration, where the solver keeps it.
    """

    # of states that are no solution, and where any friction at all wedges
    _unbounded = ("residual", "wedging_margin")

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
    reactions: Mapping[str, Any] = field(default_factory=dict)
    omitted: Mapping[str, Any] = field(default_factory=dict)
    error_estimates: Mapping[str, float] = field(default_factory=dict)
    aim: tuple[str, float] | None = None
    missed: str = ""
    spacing: tuple[float, float] | None = None
    operations: Mapping[str, float] = field(default_factory=dict)
    wedging_margin: float | None = None
    tipping_margin: float | None = None
    magnet: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    time_s: Mapping[str, float] = field(default_factory=dict, compare=False)
    history: tuple[float, ...] = ()

    def told(self) -> list[Row]:
        """Its figures in words: what a notebook shows."""
        default = {f.name: f.default for f in fields(self)}
        said = {name: value for name, value in self.as_dict().items() if name not in ("time_s", "history")}
        shown = {name: v for name, v in said.items() if v not in (None, "", {}) and v != default[name]}
        return stated(shown, {"contact_area": "m^2", "peak_pressure": "Pa"})

    def as_dict(self) -> dict[str, Any]:
        """The report as plain Python data, ready for JSON."""
        return asdict(self)


#: What an error can be measured in.
QUANTITIES: tuple[Quantity, ...] = get_args(Quantity)

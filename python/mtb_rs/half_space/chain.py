# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives through steps that follow each other."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ..base.check import in_a_row, shortened
from ..results.derivatives import Chained, Gradient


def gradient_of_steps(results: Iterable[Chained], of: Iterable[Any]) -> list[Gradient]:
    """Exact derivatives of a sum over a chain of steps by all that was given in each of them.

    Each step starts from the state of the one before, so that what was given in one acts on all later ones.
    The derivatives by the state of a step go back to the step that left it: one transposed solve a step.
    Those of wheels go forward instead, from an input that is asked for to the steps after it: one linear
    solve of the tractions for each of its numbers, each patch and each later step.

    Parameters
    ----------
    results : sequence of TangentialResult, StepResult or WheelStep
        Shifts or transient steps, steps of a prepared contact with a shift, or steps of prepared wheels, the
        first one first, each from the ``state`` of the one before. Those of wheels are transient; a steady
        one does not follow from what was before it, and begins a chain.
    of : sequence of str, Mapping or callable
        What each step adds to the sum, as of :meth:`TangentialResult.derivative`: a number such as
        ``"spin_moment"``, or weights of fields; ``{}`` for nothing.

    Returns
    -------
    list of Gradient
        For each step the derivatives of the sum by its inputs. What was given in all steps at once, such as
        the friction, has the sum of the derivatives of all of them.

    Raises
    ------
    ValueError
        If there are not as many numbers as steps, for a number that is not a single one, and for results that
        have no derivatives.

    Examples
    --------
    >>> import numpy as np
    >>> import mtb_rs as mtb
    >>> x = (np.arange(24) - 11.5) * 0.3e-3
    >>> gap = (x[None, :] ** 2 + x[:, None] ** 2) / (2 * 0.3)
    >>> pressed = mtb.solve_normal(gap, 0.3e-3, lower=mtb.steel, upper=mtb.steel, force=2e3)
    >>> first = mtb.solve_tangential(pressed, mtb.Shift((1e-6, 0.0)), mtb.Coulomb(0.3))
    >>> second = mtb.solve_tangential(pressed, mtb.Shift((0.0, 1e-6)), mtb.Coulomb(0.3), state=first.state)
    >>> by_first, by_second = mtb.gradient_of_steps([first, second], [{}, {"traction": second.area}])
    >>> bool(by_first["displacement"][0] < by_second["displacement"][0])
    True
    """
    results = in_a_row(
        "results", results, "results of solve_tangential, steps of a contact or of wheels, one a step"
    )
    of = in_a_row("of", of, "names or weights of fields, one entry a step")
    for k, result in enumerate(results):
        if not isinstance(result, Chained):
            raise ValueError(
                f"results[{k}] is {shortened(result)}: results of solve_tangential, steps of a prepared "
                "contact with a shift, or steps of prepared wheels are needed"
            )
        if k and not result.follows(results[k - 1]):
            raise ValueError(
                f"results[{k}] does not start from the state of results[{k - 1}]: all steps of a chain are "
                "needed, in their order, those that add nothing to the sum as well"
            )
    if len(of) != len(results):
        raise ValueError(
            f"of has {len(of)} entries, and there are {len(results)} steps: one for each is needed"
        )
    functionals = []
    for result, own in zip(results, of, strict=True):
        functional = result._functional(own, result._tangent())
        if functional.shape:
            raise ValueError(f"of has {own!r}, which is not a single number: weights of its field are needed")
        functionals.append(functional)
    return results[0]._through(results, functionals) if results else []

# SPDX-License-Identifier: MIT OR Apache-2.0
"""What friction laws report, and steps that follow a contact over moving grids."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

import mtb_rs as mtb

BODY = mtb.Material.from_shear_modulus(82e9, 0.28)
HERTZ = mtb.hertz(10e3, semi_axes=(3.2e-3, 3.2e-3), lower=BODY, upper=BODY)
MU = mtb.Coulomb(0.3)


def patch(n: int = 16) -> mtb.PressureField:
    normal = HERTZ.on_grid((n, n), (6.72e-3 / n, 6.72e-3 / n))
    return mtb.PressureField(normal.pressure, (6.72e-3 / n, 6.72e-3 / n), BODY, BODY)


def moved(field: mtb.PressureField, rows: int, columns: int) -> mtb.PressureField:
    """The same pressure at the same place on a grid that begins elsewhere, with room around."""
    wide = np.pad(field.pressure, ((rows, 3), (columns, 2)))
    dx, dy = field.spacing
    x, y = field.start
    return replace(field, pressure=wide, origin=(x - columns * dx, y - rows * dy))


@pytest.mark.parametrize(
    "motion", [mtb.Rolling((1e-3, 2e-4, 0.3), transient=True), mtb.Shift((1e-6, 2e-6), spin=1e-4)]
)
def test_a_state_is_followed_on_another_grid(motion: mtb.Rolling | mtb.Shift) -> None:
    here = patch()
    law = mtb.FallingFriction(0.4, 0.2, 2.0, memory=1e-5)
    first = mtb.solve_tangential(here, motion, law)
    stay = mtb.solve_tangential(here, motion, law, state=first.state)
    for rows, columns in ((2, 1), (0, 4)):
        there = moved(here, rows, columns)
        again = mtb.solve_tangential(there, motion, law, state=first.state)
        part = (slice(None), slice(rows, rows + 16), slice(columns, columns + 16))
        assert np.abs(again.traction[part] - stay.traction).max() < 1e-7 * np.abs(stay.traction).max()
        assert again.dissipation.sum() == pytest.approx(stay.dissipation.sum(), rel=1e-9)
        # and back again, through a file
        back = mtb.solve_tangential(here, motion, law, state=pickle.loads(pickle.dumps(again.state)))
        third = mtb.solve_tangential(here, motion, law, state=stay.state)
        assert np.abs(back.traction - third.traction).max() < 1e-7 * np.abs(third.traction).max()


def test_what_the_next_grid_does_not_hold_still_acts() -> None:
    """A contact that moves off its grid: the tractions left behind count, as on one grid for both."""
    wide = moved(patch(), 0, 0)
    shifted = replace(wide, pressure=np.roll(wide.pressure, 2, axis=1))
    motion = mtb.Shift((2e-6, 0.0))
    whole = mtb.solve_tangential(shifted, motion, MU, state=mtb.solve_tangential(wide, motion, MU).state)
    # a grid that begins behind the first loaded cells of the contact before
    cut = 2
    x, y = shifted.start
    narrow = replace(shifted, pressure=shifted.pressure[:, cut:], origin=(x + cut * shifted.spacing[0], y))
    assert (shifted.pressure[:, :cut] == 0.0).all()
    assert (wide.pressure[:, :cut] > 0.0).any()
    parted = mtb.solve_tangential(narrow, motion, MU, state=mtb.solve_tangential(wide, motion, MU).state)
    assert np.abs(parted.traction - whole.traction[:, :, cut:]).max() < 1e-7 * np.abs(whole.traction).max()


def test_states_of_other_cells_are_refused_and_older_ones_are_taken() -> None:
    here = patch()
    state = mtb.solve_tangential(here, mtb.Shift((1e-6, 0.0)), MU).state
    for other, words in (
        (replace(state, origin=(1e-5, 0.0)), "whole numbers of cells"),
        (replace(state, spacing=(1e-4, 1e-4)), "must be the same"),
        (
            replace(
                state,
                origin=None,
                traction=state.traction[:, 1:],
                pressure=state.pressure[1:],
                coefficient=state.coefficient[1:],
            ),
            "state has shape",
        ),
    ):
        with pytest.raises(ValueError, match=words):
            mtb.solve_tangential(here, mtb.Shift((1e-6, 0.0)), MU, state=other)
    older = mtb.TangentialState(state.traction, state.pressure, state.coefficient)
    del older.__dict__["origin"], older.__dict__["spacing"]  # as pickled before there were any
    one, two = (mtb.solve_tangential(here, mtb.Shift((0.0, 1e-6)), MU, state=s) for s in (state, older))
    assert np.array_equal(one.traction, two.traction)


@pytest.mark.filterwarnings("ignore:StaticKinetic depends on the grid")
def test_cells_that_stick_report_friction_at_rest() -> None:
    law = mtb.StaticKinetic(0.5, 0.1)
    rng = np.random.default_rng(3)
    for creepage in rng.uniform(-1.0, 1.0, (12, 3)) * [2e-3, 2e-3, 1.0]:
        roll = mtb.solve_tangential(patch(), mtb.Rolling(tuple(creepage)), law)
        assert (roll.friction_coefficient[roll.status == 1] == 0.5).all()
        assert (roll.friction_coefficient[roll.status == 2] == 0.1).all()


@pytest.mark.parametrize("shape", [(2, 1, 3), (3,), (1, 16, 16)])
def test_friction_fields_of_wrong_shape_are_refused_by_it(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"has shape \(.*\): one number or \(ny, nx\)"):
        mtb.Coulomb(np.full(shape, 0.3))
    gap = 1e-3 * np.hypot(*np.mgrid[-1:1:9j, -1:1:9j])
    with pytest.raises(ValueError, match="friction"):
        mtb.Scene(mtb.steel, mtb.steel, gap=gap, force=10.0, friction=np.full(shape, 0.3)).solve()


def test_falling_friction_without_memory_says_what_helps_and_that_helps() -> None:
    here = patch(30)

    def roll(memory: float | None) -> None:
        law = mtb.FallingFriction(0.35, 0.1, 1e-2, memory=memory)
        state = None
        for _ in range(8):
            state = mtb.solve_tangential(
                here, mtb.Rolling((3e-3, 0.0, 0.0), transient=True), law, state=state
            ).state

    with pytest.raises(mtb.ConvergenceError, match="memory: give it one, or roll over a longer step"):
        roll(None)
    roll(1e-5)

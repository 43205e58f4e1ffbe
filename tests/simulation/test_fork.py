# SPDX-License-Identifier: MIT OR Apache-2.0
"""Processes made by fork after the library was used: they have none of their parent's threads."""

import multiprocessing
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.base import cache

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="fork after threads is Linux' affair")


def dense():
    return mtb.scenes.block_on_plane(spacing=12.5e-3).solve().normal_force


def by_fourier():
    x = np.linspace(-4e-3, 4e-3, 128)
    gap = (x[None, :] ** 2 + x[:, None] ** 2) / 0.2
    return mtb.solve_normal(
        gap, (x[1] - x[0],) * 2, lower=mtb.steel, upper=mtb.steel, force=500.0
    ).pressure.max()


def many_cells_densely():
    x = np.linspace(-4e-3, 4e-3, 24)
    gap = (x[None, :] ** 2 + x[:, None] ** 2) / 0.2
    return mtb.solve_normal(
        gap, (x[1] - x[0],) * 2, lower=mtb.steel, upper=mtb.steel, force=500.0, method="dense"
    ).pressure.max()


def condensed():
    shoe = mtb.scenes.pole_shoe_on_rail(spacing=9e-3)
    with cache.memory_only():
        cache.forget()
        return shoe.solve("elastic-upper").normal_force


def stressed():
    shoe = mtb.scenes.pole_shoe_on_rail(spacing=9e-3)
    states = shoe.solve("elastic-upper").states()
    return np.abs(next(iter(states.values())).displacement).max()


def stepped():
    contact = mtb.scenes.pole_shoe_on_rail(spacing=9e-3).prepare("half-space")
    return contact.step(velocity=3.0).force[2]


def rolled():
    return mtb.scenes.wheel_on_rail(spacing=1.5e-3).solve().normal_force


def wheels():
    prepared = mtb.scenes.wheel_on_rail(spacing=1.5e-3, lateral=0.0).prepare(friction=mtb.Coulomb(0.05))
    return prepared.step([0.0, 0.0, np.nan, 0.0, 0.0, 0.0], 20.0).force[2]


WORK = [dense, by_fourier, many_cells_densely, condensed, stressed, stepped, rolled, wheels]


def in_two_threads():
    """Threads that the child starts have no workers either."""
    with ThreadPoolExecutor(2) as threads:
        return sum(threads.map(lambda work: work(), (by_fourier, many_cells_densely)))


def compare():
    """The same work here and in forked processes."""
    here = [np.asarray(work()) for work in WORK] + [in_two_threads()]
    with multiprocessing.get_context("fork").Pool(2) as pool:
        waiting = [pool.apply_async(work) for work in [*WORK, in_two_threads]]
        # one that hangs never answers: the longest takes a few seconds
        there = [answer.get(timeout=120) for answer in waiting]
    np.testing.assert_allclose(there, here, rtol=1e-6)


def test_a_forked_process_solves_as_its_parent():
    # in a process of its own: one that has run many tests may be too large to be forked
    command = [sys.executable, "-W", "ignore", __file__]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr


if __name__ == "__main__":
    compare()

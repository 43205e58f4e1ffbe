# SPDX-License-Identifier: MIT OR Apache-2.0
"""A block like a pole shoe that slides, heats, expands and wears, against an own program on scikit-fem.

The program shares nothing with the library: hexahedra with 27 nodes in place of tetrahedra, constant
pressures of cells in place of hats, the heat of the rail by paths along x, an active set by NumPy, and steps
of its own.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementHex2, ElementVector, FacetBasis, LinearForm, MeshHex
from skfem.helpers import ddot, div, dot, eye, grad, sym_grad, trace

import mtb_rs as mtb

Array = NDArray[np.float64]

LENGTH, WIDTH, HEIGHT = 0.09, 0.03, 0.03
MU, PULL, SPEED = 0.1, 3e6, 30.0
YOUNG, NU, ALPHA = 208e9, 0.3, 12e-6
K, CAPACITY = 50.0, 7850.0 * 450.0
WEAR, RESISTANCE = 1e-13, 2e-5
LAME = YOUNG * NU / ((1.0 + NU) * (1.0 - 2.0 * NU))
SHEAR = YOUNG / (2.0 * (1.0 + NU))


class Program:
    """Half of the block, y >= 0, above a rigid rail that conducts."""

    def __init__(self, nx: int, ny: int, nz: int) -> None:
        x = np.linspace(-0.5 * LENGTH, 0.5 * LENGTH, nx + 1)
        y = np.linspace(0.0, 0.5 * WIDTH, ny + 1)
        z = HEIGHT * np.linspace(0.0, 1.0, nz + 1) ** 1.7
        mesh = MeshHex.init_tensor(x, y, z).with_boundaries(
            {
                "face": lambda p: p[2] < 1e-12,
                "top": lambda p: p[2] > HEIGHT - 1e-12,
                "middle": lambda p: p[1] < 1e-12,
            }
        )
        elastic = Basis(mesh, ElementVector(ElementHex2()))
        thermal = elastic.with_element(ElementHex2())

        @BilinearForm  # type: ignore[untyped-decorator]
        def stiffness(u: Any, v: Any, w: Any) -> Any:
            strain = sym_grad(u)
            return ddot(2.0 * SHEAR * strain + LAME * eye(trace(strain), 3), sym_grad(v))

        @BilinearForm  # type: ignore[untyped-decorator]
        def conduction(u: Any, v: Any, w: Any) -> Any:
            return K * dot(grad(u), grad(v))

        @BilinearForm  # type: ignore[untyped-decorator]
        def capacity(u: Any, v: Any, w: Any) -> Any:
            return CAPACITY * u * v

        @BilinearForm  # type: ignore[untyped-decorator]
        def expansion(t: Any, v: Any, w: Any) -> Any:
            return (3.0 * LAME + 2.0 * SHEAR) * ALPHA * t * div(v)

        self.capacity, self.conduction = capacity.assemble(thermal), conduction.assemble(thermal)
        warm = expansion.assemble(thermal, elastic)
        # free along z and against pitch: three points hold them, which balanced loads leave without a force
        top = elastic.get_dofs("top").all(["u^1", "u^2"])
        middle = elastic.get_dofs("middle").all("u^2")
        places = elastic.doflocs
        ends = [
            np.flatnonzero(
                (np.abs(places[0] - s * 0.5 * LENGTH) < 1e-9)
                & (np.abs(places[1]) < 1e-9)
                & (np.abs(places[2] - HEIGHT) < 1e-9)
            )
            for s in (-1.0, 1.0)
        ]
        along_z = set(elastic.get_dofs().all("u^3").tolist())
        pinned = [d for found in ends for d in found.tolist() if d in along_z]
        assert len(pinned) == 2
        free = np.setdiff1d(np.arange(elastic.N), np.concatenate([top, middle, pinned]))
        solver = splu(stiffness.assemble(elastic)[free][:, free].tocsc())
        n = nx * ny
        self.area = LENGTH / nx * 0.5 * WIDTH / ny
        self.x = np.repeat(0.5 * (x[1:] + x[:-1]), ny)
        self.y = np.tile(0.5 * (y[1:] + y[:-1]), nx)
        normal = np.zeros((elastic.N, n))
        tangential, self.heated = np.zeros((elastic.N, n)), np.zeros((thermal.N, n))
        facets = mesh.boundaries["face"]
        centres = mesh.p[:2, mesh.facets[:, facets]].mean(axis=1)
        for i in range(n):
            own = facets[np.hypot(centres[0] - self.x[i], centres[1] - self.y[i]) < 1e-9]
            on = FacetBasis(mesh, elastic.elem, facets=own)
            normal[:, i] = LinearForm(lambda v, w: v[2]).assemble(on)
            tangential[:, i] = LinearForm(lambda v, w: -v[0]).assemble(on)
            on = FacetBasis(mesh, thermal.elem, facets=own)
            self.heated[:, i] = LinearForm(lambda v, w: v).assemble(on)
        moved = solver.solve(normal[free])
        # what opens: the face moves up, into the body
        self.by_pressure = normal[free].T @ moved / self.area
        self.by_friction = normal[free].T @ solver.solve(tangential[free]) / self.area
        self.by_pull = -self.by_pressure.sum(axis=1)
        self.by_temperature = moved.T @ warm[free] / self.area
        # rise and pitch: openings, and the work of pressure with friction and of the pull
        self.motions = np.stack([np.ones(n), -self.x])
        drag = np.stack([np.zeros(n), np.full(n, HEIGHT)])
        self.balance = self.area * (self.motions + MU * drag)
        self.target = PULL * self.area * self.motions.sum(axis=1)
        # the rail comes from the front, at +x: heat of what lies upstream in the same row
        h = LENGTH / nx
        upstream = self.x[None, :] - self.x[:, None]
        same = np.abs(self.y[None, :] - self.y[:, None]) < 1e-12

        def root(s: Array) -> Array:
            return np.asarray(np.sqrt(np.maximum(s, 0.0)))

        steady = 2.0 * (root(upstream + 0.5 * h) - root(upstream - 0.5 * h))
        self.rail = np.where(same, steady, 0.0) / np.sqrt(np.pi * SPEED * K * CAPACITY)
        self.temperature = np.zeros(thermal.N)
        self.worn = np.zeros(n)
        self.active = np.ones(n, dtype=bool)

    def advance(self, duration: float, steps: int) -> None:
        dt = duration / steps
        matrix = splu((self.capacity / dt + self.conduction).tocsc())
        nodes = matrix.solve(self.heated)
        warmed = self.heated.T @ nodes / self.area
        for _ in range(steps):
            self._step(dt, matrix, nodes, warmed)

    def _step(self, dt: float, matrix: Any, nodes: Array, warmed: Array) -> None:
        n = self.x.size
        cooled = matrix.solve(self.capacity @ self.temperature / dt)
        face = self.heated.T @ cooled / self.area
        power = MU * SPEED
        gap = self.by_temperature @ cooled + self.worn + PULL * self.by_pull
        for _ in range(50):
            on = np.flatnonzero(self.active)
            both = (warmed + self.rail)[np.ix_(on, on)] + RESISTANCE * np.eye(on.size)
            # all heat arises below the resistance
            upper = np.zeros((n, n))
            upper[np.ix_(on, on)] = power * np.linalg.solve(both, self.rail[np.ix_(on, on)])
            given = np.zeros(n)
            given[on] = -np.linalg.solve(both, face[on])
            opened = self.by_temperature @ nodes
            total = self.by_pressure + MU * self.by_friction + opened @ upper
            total += WEAR * SPEED * dt * np.eye(n)
            system = np.block(
                [[total[np.ix_(on, on)], self.motions[:, on].T], [self.balance[:, on], np.zeros((2, 2))]]
            )
            start = gap + opened @ given
            solved = np.linalg.solve(system, np.concatenate([-start[on], self.target]))
            pressure = np.zeros(n)
            pressure[on] = solved[: on.size]
            left = start + total @ pressure + solved[on.size :] @ self.motions
            now = np.where(self.active, pressure > 0.0, left < 0.0)
            if (now == self.active).all():
                break
            self.active = now
        else:
            raise AssertionError("no active set")
        flux = given + upper @ pressure
        self.temperature = cooled + nodes @ flux
        self.worn = self.worn + WEAR * SPEED * dt * pressure
        self.pressure, self.surface = pressure, face + warmed @ flux


def pressure_without(scene: mtb.Scene, steel: mtb.Conductor, time: float, at_cells: Any) -> Array:
    """Pressure of cells without expansion."""
    cold = scene.sliding_heat(
        time, 2, SPEED, upper=steel, lower=steel, wear=WEAR, tolerance=0.02, resistance=RESISTANCE,
        share=0.0, model="elastic-upper",
    )  # fmt: skip
    return np.asarray(at_cells(cold.pressure))


@pytest.mark.slow
def test_temperature_and_pressure_are_those_of_another_program() -> None:
    scene = mtb.scenes.block_on_plane(
        LENGTH, HEIGHT, MU, PULL, (5e-3, 5e-3), length=WIDTH, supports="driven-top", lower=mtb.Rigid()
    )
    steel = mtb.Conductor(K, 7850.0, 450.0, ALPHA)
    other = Program(18, 3, 6)
    times, steps = (0.2, 1.0, 5.0, 30.0), (80, 80, 60, 100)
    before = 0.0
    for time, count in zip(times, steps, strict=True):
        other.advance(time - before, count)
        before = time
        found = scene.sliding_heat(
            time, 2, SPEED, upper=steel, lower=steel, expansion=True, wear=WEAR, tolerance=0.02,
            resistance=RESISTANCE, share=0.0, model="elastic-upper",
        )  # fmt: skip
        grid = found.patches[0]
        x, y = grid.view(found.points[0])[0], grid.view(found.points[1])[:, 0]

        def at_cells(field: Array, grid: Any = grid, x: Array = x, y: Array = y) -> Array:
            rows = np.array([np.interp(other.x, x, row) for row in grid.view(field)])
            return np.array([np.interp(b, y, rows[:, i]) for i, b in enumerate(other.y)])

        # away from the edges, where pressures are singular
        inner = (np.abs(other.x) < 0.42 * LENGTH) & (other.y < 0.35 * WIDTH)
        pressure, surface = at_cells(found.pressure)[inner], at_cells(found.temperature_upper)[inner]
        apart = np.linalg.norm(pressure - other.pressure[inner]) / np.linalg.norm(other.pressure[inner])
        warmer = np.linalg.norm(surface - other.surface[inner]) / np.linalg.norm(other.surface[inner])
        assert apart < 0.05
        assert warmer < 0.03
        if before == times[0]:
            # and what expansion does to the pressure is a multiple of that
            rigid = np.linalg.norm(pressure - pressure_without(scene, steel, time, at_cells)[inner])
            assert rigid > 0.15 * np.linalg.norm(pressure)

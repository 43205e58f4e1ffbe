# SPDX-License-Identifier: MIT OR Apache-2.0
"""Is the error estimate of scenes with an ``ElasticBody`` honest? Over blocks meshed by the caller.

The truth is the same scene on cells half as wide and a mesh with evenly thick layers, made without the
package's grading. Errors of the pressure are those of the means over the inner points. Run from the root of
the project: ``python studies/honesty_bodies.py``.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

import mtb_rs as mtb
from mtb_rs.bodies.mesh import TetraMesh, block_mesh, tetrahedra


@dataclass(frozen=True)
class Case:
    """A block `width` x `width` x `height` [m] with `elements` across, on `cells` x `cells`."""

    elements: int
    cells: int
    height: float = 0.1
    friction: float = 0.3
    ratio: float = 0.3
    top: str = "clamped"
    lower: str = "steel"
    width: float = 0.1

    def solve(self, *, fine: bool = False) -> mtb.Result:
        """The scene as it is, or the truth."""
        cells = self.cells * (2 if fine else 1)
        line = np.linspace(-0.5, 0.5, (max(self.cells, 8) if fine else self.elements) + 1) * self.width
        mesh = even(line, self.height) if fine else block_mesh(line, line, self.height)
        if self.top == "clamped":
            held = mtb.Support("top", x=0, y=0, z=0)
        else:
            held = mtb.Support("top", x=0, y=0, z=mtb.Guide(-3e6 * self.width**2))
        load = {"magnetic_pressure": 3e6} if self.top == "clamped" else {}
        body = mtb.ElasticBody(mesh, mtb.Material(208e9, self.ratio), "contact", [held], "block")
        lower = mtb.steel if self.lower == "steel" else mtb.Rigid()
        spacing = self.width / cells
        with warnings.catch_warnings():
            # a mesh coarser than the grid is meant here
            warnings.simplefilter("ignore", UserWarning)
            return mtb.Scene(body, lower, spacing=spacing, friction=self.friction, **load).solve()


def even(line: np.ndarray, height: float) -> TetraMesh:
    """A block of evenly thick layers, about as thick as its elements are wide."""
    z = np.linspace(0.0, height, max(4, round(1.5 * height / (line[1] - line[0]))) + 1)
    corners = np.stack(np.meshgrid(line, line, z, indexing="ij"), axis=-1)
    beyond = line[1:] > 1e-12
    nodes, cells, number = tetrahedra(corners, flipped=(beyond, beyond))
    sets = {"contact": np.unique(number[:, :, 0]), "top": np.unique(number[:, :, -1])}
    return TetraMesh(nodes, cells, sets)


CASES = (
    Case(4, 8),
    Case(8, 8),
    Case(4, 6, friction=0.0),
    Case(4, 10, friction=0.5),
    Case(6, 12, height=0.05, friction=0.5),
    Case(4, 6, height=0.2, friction=0.2),
    Case(6, 8, height=0.2, friction=0.1),
    Case(4, 8, height=0.05, friction=0.2),
    Case(8, 8, height=0.03, friction=0.4),
    Case(4, 8, ratio=0.0),
    Case(4, 8, ratio=0.45),
    Case(6, 8, ratio=0.45, friction=0.0),
    Case(4, 8, height=0.05, friction=0.2, top="guided"),
    Case(8, 8, height=0.05, friction=0.2, top="guided"),
    Case(4, 8, height=0.1, friction=0.1, top="guided"),
    Case(6, 12, height=0.03, friction=0.3, top="guided"),
    Case(4, 8, lower="rigid"),
    Case(8, 8, lower="rigid", height=0.05),
    Case(4, 8, lower="rigid", ratio=0.45, top="guided", height=0.05),
    Case(6, 8, width=0.02, height=0.02, friction=0.5),
)


def examine(case: Case) -> dict[str, tuple[float, float]]:
    """Estimate and truth of pressure and force."""
    found, true = case.solve(), case.solve(fine=True)
    # means over the hats of the wide cells, of the pressures on the narrow ones
    weight = np.array([0.25, 0.5, 0.25])
    fine = true.pressure
    rows = sum(w * fine[1 + k : fine.shape[0] - 2 + k : 2] for k, w in enumerate(weight))
    mean = sum(w * rows[:, 1 + k : fine.shape[1] - 2 + k : 2] for k, w in enumerate(weight))
    off = np.linalg.norm(found.pressure[1:-1, 1:-1] - mean) / np.linalg.norm(mean)
    estimates = found.report.error_estimates
    return {
        "pressure": (estimates["pressure"], float(off)),
        "force": (estimates["force"], abs(found.normal_force / true.normal_force - 1.0)),
    }


if __name__ == "__main__":
    honest = 0
    for case in CASES:
        said = examine(case)
        honest += all(truth <= 2.0 * estimate for estimate, truth in said.values())
        words = ", ".join(f"{name}: estimate {e:.4f}, truth {t:.4f}" for name, (e, t) in said.items())
        print(f"{case}: {words}", flush=True)
    print(f"within twice the estimate: {honest} of {len(CASES)}")

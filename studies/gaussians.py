# SPDX-License-Identifier: MIT OR Apache-2.0
"""The thesis' Gaussian functions over width and grid: error of Hertz' pressure, and condition of the
matrix.

Frictionless sphere, force prescribed. Narrow Gaussians are rectangles in disguise; from about 0.4 spacings
on they are worse, and at 1 the matrix is singular to working precision. Drawn: the error of the
coefficients, which the thesis plots as pressure.
"""

import numpy as np
from atlas import draw_verdicts, panels, write

import mtb_rs as mtb
from mtb_rs import _mtb_rs
from mtb_rs.half_space.reference import SlidingParaboloid

names = ("within 1.5 of rectangles", "worse", "condition beyond 1e6")
colours = ("#56B4E9", "#E69F00", "#BBBBBB")
widths = [0.15, 0.25, 0.35, 0.4, 0.5, 0.7, 1.0]
sides = [8, 12, 16]
steel = mtb.Material.from_shear_modulus(80e9, 0.3)
hertz = SlidingParaboloid(1000.0, 5e6, 0.0, steel, steel)


def solved(matrix: np.ndarray, gap: np.ndarray, weight: np.ndarray, force: float) -> np.ndarray:
    """Pressures of prescribed force, by active sets."""
    active = gap < np.median(gap)
    for _ in range(60):
        k = int(active.sum())
        system = np.zeros((k + 1, k + 1))
        system[:k, :k] = matrix[np.ix_(active, active)]
        system[:k, k], system[k, :k] = -1.0, weight[active]
        found = np.linalg.lstsq(
            system / np.abs(system).max(axis=1, keepdims=True),
            np.append(-gap[active], force) / np.abs(system).max(axis=1),
            rcond=1e-15,
        )[0]
        pressure = np.zeros(gap.size)
        pressure[active] = found[:k]
        slack = gap + matrix @ pressure - found[k]
        new = np.where(active, pressure > 0.0, slack < -1e-12 * np.ptp(gap))
        if (new == active).all():
            break
        active = new
    return pressure


codes = np.zeros((len(sides), len(widths)), dtype=int)
texts = np.full(codes.shape, "", dtype=object)
rows = []
for j, n in enumerate(sides):
    line = np.linspace(-0.5, 0.5, n)
    step = line[1] - line[0]
    x, y = (c.ravel() for c in np.meshgrid(line, line))
    gap = (x**2 + y**2) / 2000.0
    exact = hertz.pressure(x, y)
    inner = np.hypot(x, y) < 0.9 * hertz.contact_radius
    plain = mtb.scenes.paraboloid_on_plane(points=n, friction=0.0).solve("half-space").pressure.ravel()

    def error(p: np.ndarray, exact: np.ndarray = exact, inner: np.ndarray = inner) -> float:
        return float(np.linalg.norm((p - exact)[inner]) / np.linalg.norm(exact[inner]))

    for i, width in enumerate(widths):
        domain = (-0.5 - 0.5 * step, 0.5 + 0.5 * step) * 2
        (compliance,), weight = _mtb_rs.half_space_gaussians(
            [(0.5 * steel.shear_modulus, 0.3)], x, y, width * step, domain
        )
        matrix = compliance.influence("n", "n")
        condition = float(np.linalg.cond(matrix))
        found = solved(matrix, gap, weight, 5e6)
        codes[j, i] = 2 if condition > 1e6 else int(error(found) > 1.5 * error(plain))
        texts[j, i] = f"{100 * error(found):.2g} %\n{condition:.0e}"
        rows.append(
            {
                "points_a_side": n,
                "width_over_spacing": width,
                "error": error(found),
                "error_of_rectangles": error(plain),
                "condition": condition,
                "verdict": names[codes[j, i]],
            }
        )
figure, (ax,) = panels(1, height=4.0)
draw_verdicts(ax, widths, sides, codes, names=names, colours=colours, texts=texts)
ax.set(
    title="pressure error inside 0.9 a, and condition number",
    xlabel="standard deviation / spacing",
    ylabel="points a side",
)
write("gaussians", figure, rows)

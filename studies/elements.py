# SPDX-License-Identifier: MIT OR Apache-2.0
"""Finite elements: mesh against contact spacing (ripples, thesis Fig. C.3), nu towards 0.5, and slivers.

Left: the foot of a pressed block under hats of spacing h, meshed coarser and coarser: roughness of the
pressure (its second differences over those of the matching mesh). Middle: mean compliance of a block held
at its sides over that of the finest quadratic mesh, linear and quadratic elements. Right: a block whose
first layer is squashed: error of its compliance against the ordinary mesh; flat cells are refused.
"""

import numpy as np
from atlas import panels, write

import mtb_rs as mtb
from mtb_rs import _mtb_rs
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.bodies.mesh import tetrahedra as tetrahedra_of
from mtb_rs.contact.solve import sided_influence

SIDE = 0.1


def body(mesh: mtb.TetraMesh, ratio: float, held: tuple[str, ...] = ("top",)) -> mtb.ElasticBody:
    supports = [mtb.Support(name, x=0.0, y=0.0, z=0.0) for name in held]
    linear = not mesh.is_quadratic
    return mtb.ElasticBody(mesh, mtb.Material(208e9, ratio), "contact", supports, "block", linear)


def compliance(solid: mtb.ElasticBody, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Normal compliance (n, n) and weights on a contact grid of `cells` a side."""
    scene = mtb.scenes.block_on_plane(spacing=SIDE / cells)
    grid = scene.geometry.grid((SIDE / cells,) * 2)
    sampling = solid.sample(grid.nodes, grid.node_patches, upper=True)
    condensed = solid.condense(sampling, keep=False)
    return condensed.compliance.influence("n", "n"), condensed.weights


def mesh_against_contact(cells: int, elements: int) -> tuple[float, float]:
    """Force under 3 MPa and roughness of the pressure, contact on `cells`, mesh of `elements` a side."""
    line = np.linspace(-0.5 * SIDE, 0.5 * SIDE, elements + 1)
    own, weight = compliance(body(block_mesh(line, line, 0.5 * SIDE), 0.3), cells)
    scene = mtb.scenes.block_on_plane(height=0.5 * SIDE, spacing=SIDE / cells, friction=0.0)
    problem = scene.problem("elastic-upper")
    plane = sided_influence(problem.lower.compliance, problem.direction, np.zeros(problem.n), upper=False)
    pressure = np.linalg.solve(own + plane, own @ np.full(problem.n, 3e6))
    field = pressure.reshape(cells + 1, cells + 1)[2:-2, 2:-2]
    return float(weight @ pressure), float(np.abs(np.diff(field, 2, axis=1)).mean() / field.mean())


def squashed(thickness: float) -> float:
    """Compliance of a block whose lowest layer is `thickness` times as thick as wide."""
    line = np.linspace(-0.5 * SIDE, 0.5 * SIDE, 7)
    z = np.concatenate([[0.0], np.linspace(SIDE / 6 * thickness, SIDE, 6)])
    corners = np.stack(np.meshgrid(line, line, z, indexing="ij"), axis=-1)
    nodes, cells, number = tetrahedra_of(corners)
    sets = {"contact": np.unique(number[:, :, 0]), "top": np.unique(number[:, :, -1])}
    own, weight = compliance(body(mtb.TetraMesh(nodes, cells, sets), 0.3), 6)
    return float(weight @ own @ np.ones(weight.size))


if __name__ == "__main__":
    assert _mtb_rs.__version__
    rows = []
    figure, axes = panels(3)
    for cells in (8, 12):
        force, matching = mesh_against_contact(cells, cells)
        ratios, ripples = [], []
        for elements in (cells, cells // 2, cells // 4):
            found, rough = mesh_against_contact(cells, elements)
            ratios.append(cells / elements)
            ripples.append(rough / matching)
            rows.append(
                {
                    "study": f"mesh, {cells} contact cells",
                    "at": ratios[-1],
                    "value": ripples[-1],
                    "second": found / force - 1.0,
                    "said": "",
                }
            )
        axes[0].semilogy(ratios, ripples, "o-", label=f"{cells} contact cells a side")
    axes[0].set(
        title="a mesh coarser than the contact grid ripples",
        xlabel="element size / contact spacing",
        ylabel="ripples / those of a matching mesh",
    )
    line = np.linspace(-0.5 * SIDE, 0.5 * SIDE, 7)
    fine = np.linspace(-0.5 * SIDE, 0.5 * SIDE, 13)
    held = ("top", "rear", "front", "left", "right")
    ratios = [0.0, 0.3, 0.45, 0.49, 0.499, 0.4999, 0.49999, 0.5]
    for quadratic, style in ((False, "s-"), (True, "o-")):
        drawn = []
        for ratio in ratios:
            said, value = "", np.nan
            try:
                best, weight = compliance(body(block_mesh(fine, fine, SIDE), ratio, held), 6)
                own, _ = compliance(body(block_mesh(line, line, SIDE, quadratic=quadratic), ratio, held), 6)
                # under a load that changes sign, so that nothing but shear is asked for
                load = np.sign(np.arange(weight.size) % 7 - 3.0)
                value = float((weight * load) @ own @ load / ((weight * load) @ best @ load))
            except ValueError as refusal:
                said = str(refusal)
            drawn.append(value)
            rows.append(
                {
                    "study": "quadratic" if quadratic else "linear",
                    "at": ratio,
                    "value": value,
                    "second": np.nan,
                    "said": said,
                }
            )
        axes[1].semilogx(
            np.maximum(0.5 - np.array(ratios), 1e-6),
            drawn,
            style,
            label="quadratic" if quadratic else "linear",
        )
    axes[1].invert_xaxis()
    axes[1].set(
        title="linear elements lock towards nu = 0.5",
        xlabel="0.5 - nu",
        ylabel="compliance / that of a fine mesh",
    )
    thicknesses = [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-13]
    base = squashed(1.0)
    drawn = []
    for thickness in thicknesses:
        said, value = "", np.nan
        try:
            value = abs(squashed(thickness) / base - 1.0)
        except ValueError as refusal:
            said = str(refusal)
        drawn.append(value)
        rows.append({"study": "slivers", "at": thickness, "value": value, "second": np.nan, "said": said})
    axes[2].loglog(thicknesses, drawn, "o-", label="solved")
    refused = [t for t, value in zip(thicknesses, drawn, strict=True) if np.isnan(value)]
    axes[2].plot(
        refused, [np.nanmax(drawn)] * len(refused), "x", ms=7, mew=2, label="refused, with its cell named"
    )
    axes[2].set_ylim(1e-4, 1e-3)
    axes[2].invert_xaxis()
    axes[2].set(
        title="slivers do no harm until they are refused",
        xlabel="thickness / width of the first layer",
        ylabel="relative change of the compliance",
    )
    for ax in axes:
        ax.legend()
    write("elements", figure, rows)

# SPDX-License-Identifier: MIT OR Apache-2.0
"""Questions about what is allowed but looks like a slip of the unit, and about results that linear elasticity
does not carry. They are warnings; nothing is refused."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bodies.material import NORMALISED, RUBBERY, of_material
from ..bodies.simple import are_layered
from ..friction.fields import as_form
from ..geometry.contact_points import Patch
from .grids import flat, patches
from .result import Pictured, Result

Array = NDArray[np.float64]

#: Magnetic pressures [Pa] that are a slip of the unit: flux densities below 0.05 T and above 5 T, where
#: iron saturates at 2.2 T.
WEAK_PULL, STRONG_PULL = 1e3, 1e7
#: Force [N] beyond which it is a slip of the unit: the largest presses reach half of it.
STRONG_FORCE = 2e9
#: Magnetic constant [N/A2].
VACUUM_PERMEABILITY = 4e-7 * np.pi
#: Elastic displacement over size above which deformations are not small.
SMALL = 0.05
#: Young's moduli [Pa] of steels, and the peak pressure [Pa] at which balls and rings of hardened bearing
#: steel keep a dent of 1e-4 of their diameter: the static rating of ISO 76.
STEELS, DENT = (180e9, 230e9), 4.2e9
#: Points over the width of a contact up to which its pressure is not resolved.
NARROW = 2
#: Share of the length of a contact, and cells, up to which a step of transient rolling is short.
SHORT_WAY, SHORT_CELLS = 0.2, 1.5


def of_scene(upper: Any, lower: Any, magnetic_pressure: Any, force: float | None = None) -> list[str]:
    """Questions about materials and loads of a scene whose lengths are metres."""
    questions = []
    normalised = False
    for side, body in (("upper", upper), ("lower", lower)):
        material = body.material
        if material is not None:
            questions += of_material(side, material)
            normalised |= material.young_modulus <= NORMALISED
    if magnetic_pressure is not None and not normalised:
        questions += _of_pull(magnetic_pressure)
    if force is not None and force > STRONG_FORCE and not normalised:
        questions.append(
            f"force is {force:g} N: no machine presses so hard, and forces are in newtons (36 kN is 36e3)"
        )
    return questions


def _of_pull(spec: Any) -> list[str]:
    form = as_form(spec)
    sizes = [abs(value) for value in form.numbers() if value]
    weakest, peak = min(sizes, default=0.0), max(sizes, default=0.0)
    # a field may well fall to nothing at its rim; of numbers given one by one each is meant
    least = weakest if form.is_list or form.number is not None else peak
    if 0.0 < least < WEAK_PULL:
        tesla = float(np.sqrt(2.0 * VACUUM_PERMEABILITY * least))
        return [
            f"magnetic_pressure is {least:g} Pa, that of a flux density of {1e3 * tesla:.2g} mT: "
            "pressures are in pascals (3 MPa is 3e6)"
        ]
    tesla = float(np.sqrt(2.0 * VACUUM_PERMEABILITY * peak))
    if peak > STRONG_PULL:
        return [
            f"magnetic_pressure reaches {peak:g} Pa, that of a flux density of {tesla:.2g} T: iron "
            "saturates at about 2.2 T, which gives 2e6 Pa, and pressures are in pascals"
        ]
    return []


def of_deformation(side: str, moved: Array, parts: Sequence[Any], width: float) -> list[str]:
    """A question where a body deforms by more than a small share of its size.

    Parameters
    ----------
    moved : (1 to 3, n) [m]
        Displacement of points of the body without its rigid motion, in the directions in which it has any.
    parts : sequence
        Of an elastic body: its size is the least extent along z, the way of the load.
    width : float [m]
        Of the contact, which is the size of a half-space.
    """
    height = height_of(parts)
    size, what = (width, "contact's size") if height is None else (height, "height")
    most = float(np.sqrt(np.einsum("ij,ij->j", moved, moved).max(initial=0.0)))
    if most <= SMALL * size:
        return []
    return [
        f"the {side} body deforms by {most:.3g} m, {100.0 * most / size:.0f} % of its {what} of "
        f"{size:.3g} m: the calculation is one of small deformations (below about 5 %), and "
        "moduli and pressures are in pascals, lengths in metres"
    ]


def height_of(parts: Sequence[Any]) -> float | None:
    """Least extent [m] along z of the parts of an elastic body; None of a half-space."""
    return min((float(np.ptp(part.body.mesh.nodes[:, 2])) for part in parts), default=None)


def width_of(points: Array, area: float, touching: NDArray[np.bool_], patches: Sequence[Patch]) -> float:
    """Of the largest patch in contact [m]: of the rectangle around it, the geometric mean of the sides.

    Parameters
    ----------
    points : (3, n) [m]
    area : float [m2]
        Of a cell.
    touching : (n,) bool
    patches : sequence of Patch
        Grids of the points, if they lie on any.
    """
    cell = float(np.sqrt(area))
    widths = [cell]
    for patch in patches or (None,):
        here = touching.copy()
        if patch is not None:
            here[: patch.start] = False
            here[patch.start + patch.nx * patch.ny :] = False
        if here.any():
            # a single point is as wide as its cell
            widths.append(float(np.sqrt(np.prod([np.ptp(axis[here]) + cell for axis in points[:2]]))))
    return max(widths)


def of_result(
    result: Pictured, deformation: Mapping[str, Array], elastic_parts: Sequence[Any] = ()
) -> list[str]:
    """Questions about a result that a linear calculation gives and no body bears.

    Parameters
    ----------
    result : Result or NormalResult
    deformation : Mapping of "upper" and "lower" to (1 to 3, n) [m]
        Displacement of the contact points without rigid motion.
    elastic_parts : sequence of ElasticPart
    """
    questions: list[str] = []
    if not (result.status > 0).any():
        return questions
    bodies = {side: getattr(result, side) for side in ("upper", "lower")}
    touching = flat(result, result.status) > 0
    width = width_of(flat(result, result.points), result.area.max(), touching, patches(result))
    for side, moved in deformation.items():
        if bodies[side].material is None:
            continue
        parts = [part for part in elastic_parts if part.upper == (side == "upper")]
        questions += of_deformation(side, moved, parts, width)
    materials = [bodies[side].material for side in deformation]
    return questions + of_dent(float(result.pressure.max()), materials)


def of_layers(bodies: Sequence[Any], spacing: tuple[float, float]) -> list[str]:
    """Questions about layers that hardly change their volume and are thinner than the cells are wide."""
    widest = max(spacing)
    return [
        f"a layer with a Poisson's ratio of {body.material.poisson_ratio:g} is {body.thickness:g} m thick, "
        f"and cells are {widest:g} m wide: the flow of such a layer is known on cells no wider than it is "
        "thick (at half of that the force is some 4 to 14 % too small)"
        for body in bodies
        if are_layered(body) and body.material.poisson_ratio >= RUBBERY and body.thickness < widest
    ]


def of_dent(peak: float, materials: Sequence[Any]) -> list[str]:
    """A question where the peak pressure [Pa] is beyond what steel bears; None is a rigid body."""
    if not peak > DENT or not _is_steel([m.young_modulus for m in materials if m is not None]):
        return []
    return [
        f"the peak pressure is {1e-9 * peak:.3g} GPa, beyond what steel bears elastically: even "
        f"hardened bearing steel keeps a dent from {1e-9 * DENT:g} GPa on (ISO 76)"
    ]


def of_way(way: float, length: float, cell: float) -> list[str]:
    """A question about a step of transient rolling whose `way` [m] is long for a contact of `length` [m]."""
    if way <= max(SHORT_WAY * length, SHORT_CELLS * cell):
        return []
    return [
        f"the contact rolls {1e3 * way:.3g} mm in one transient step, {100.0 * way / length:.0f} % of its "
        f"length ({1e3 * length:.3g} mm): where points stick, forces are off by up to half of that "
        "share. Shorter steps follow what happens; steady rolling is right where nothing changes that fast"
    ]


def of_width(closed: NDArray[np.bool_]) -> list[str]:
    """A question where a contact (ny, nx) of cells is too narrow for its pressure to be known."""
    inside = np.ones_like(closed)
    across, along = min((width(closed, inside), "x"), (width(np.ascontiguousarray(closed.T), inside.T), "y"))
    if across > NARROW:
        return []
    return [
        f"the contact is only {across:.0f} point{'s' if across > 1 else ''} wide along {along}, too few for "
        "its pressure to be known: narrower cells are needed (lengths are in metres, forces in newtons)"
    ]


def width(closed: NDArray[np.bool_], on_face: NDArray[np.bool_]) -> float:
    """Width [points] along x of a contact (ny, nx), the median of its points; infinite where a face ends it.

    A contact as narrow as a point or two is a force and no pressure: its neighbours tell nothing of it.
    """
    padded, face = (np.pad(field, ((0, 0), (1, 1))) for field in (closed, on_face))
    change = np.diff(padded.astype(np.int8), axis=1)
    row, first = np.nonzero(change == 1)
    _, last = np.nonzero(change == -1)
    if not row.size:
        return float("inf")
    length = (last - first).astype(float)
    # the columns before and behind each run, in the padded field
    wide = np.where(face[row, first] & face[row, last + 1], length, np.inf)
    order = np.argsort(wide)
    above_half = 2.0 * length[order].cumsum() > length.sum()
    return float(wide[order][int(above_half.argmax())])


def of_peak(result: Result, hardness: float | None) -> list[str]:
    """A question where the peak pressure is above the hardness [Pa] of what such bodies are made of.

    Beyond what any steel bears :func:`of_result` has asked.
    """
    materials = [body.material for body in (result.upper, result.lower) if body.material is not None]
    return of_hardness(result.report.peak_pressure, hardness, [m.young_modulus for m in materials])


def of_hardness(
    peak: float, hardness: float | None, moduli: Sequence[float], most: float = DENT
) -> list[str]:
    """A question where a peak pressure [Pa] is from the hardness to `most`; `moduli`: Young's [Pa]."""
    if hardness is None or not hardness < peak <= most or not _is_steel(moduli):
        return []
    return [
        f"the peak pressure is {1e-9 * peak:.3g} GPa, more than the hardness of rail steel (R260: up to "
        f"{1e-9 * hardness:.2g} GPa): wheel and rail flow there, and the true pressure is lower and wider"
    ]


def _is_steel(moduli: Sequence[float]) -> bool:
    return bool(moduli) and all(STEELS[0] <= modulus <= STEELS[1] for modulus in moduli)

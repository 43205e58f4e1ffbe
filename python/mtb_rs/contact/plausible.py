# SPDX-License-Identifier: MIT OR Apache-2.0
"""Questions about what is allowed but looks like a slip of the unit, and about results that linear elasticity
does not carry. They are warnings; nothing is refused."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bodies.material import Material
from ..results.result import Result

Array = NDArray[np.float64]

#: Young's moduli [Pa]: up to the first, units are normalised ones; between it and the second only foams,
#: cork and what hardly changes its volume (rubber, gels) are so soft; diamond has half of the third.
NORMALISED, SOFT, STIFF = 10.0, 1e6, 2e12
#: Poisson's ratio from which a material counts as hardly changing its volume.
RUBBERY = 0.45
#: Magnetic pressures [Pa] that are a slip of the unit: flux densities below 0.05 T and above 5 T, where
#: iron saturates at 2.2 T.
WEAK_PULL, STRONG_PULL = 1e3, 1e7
#: Magnetic constant [N/A2].
VACUUM_PERMEABILITY = 4e-7 * np.pi
#: Elastic displacement over size above which deformations are not small.
SMALL = 0.05
#: Young's moduli [Pa] of steels, and the peak pressure [Pa] at which balls and rings of hardened bearing
#: steel keep a dent of 1e-4 of their diameter: the static rating of ISO 76.
STEELS, DENT = (180e9, 230e9), 4.2e9


def of_scene(upper: Any, lower: Any, magnetic_pressure: Any) -> list[str]:
    """Questions about materials and loads of a scene whose lengths are metres."""
    questions = []
    normalised = False
    for side, body in (("upper", upper), ("lower", lower)):
        material = _material(body)
        if material is not None:
            questions += _of_material(side, material)
            normalised |= material.young_modulus <= NORMALISED
    if magnetic_pressure is not None and not normalised:
        questions += _of_pull(magnetic_pressure)
    return questions


def _material(body: Any) -> Material | None:
    """The material of a body that deforms."""
    return getattr(body, "material", None)


def _of_material(side: str, material: Material) -> list[str]:
    modulus, ratio = material.young_modulus, material.poisson_ratio
    if NORMALISED < modulus < SOFT and ratio < RUBBERY:
        return [
            f"young_modulus of the {side} body is {modulus:g} Pa beside a Poisson's ratio of {ratio:g}: "
            "only foam is so soft, and moduli are in pascals (steel has 208e9)"
        ]
    if modulus > STIFF:
        return [
            f"young_modulus of the {side} body is {modulus:g} Pa: nothing is so stiff, and moduli are in "
            "pascals (steel has 208e9; a half-space that does not deform is Rigid())"
        ]
    return []


def _of_pull(spec: Any) -> list[str]:
    peak = max((abs(value) for value in _numbers(spec)), default=0.0)
    tesla = float(np.sqrt(2.0 * VACUUM_PERMEABILITY * peak))
    if 0.0 < peak < WEAK_PULL:
        return [
            f"magnetic_pressure is at most {peak:g} Pa, that of a flux density of {1e3 * tesla:.2g} mT: "
            "pressures are in pascals (3 MPa is 3e6)"
        ]
    if peak > STRONG_PULL:
        return [
            f"magnetic_pressure reaches {peak:g} Pa, that of a flux density of {tesla:.2g} T: iron "
            "saturates at about 2.2 T, which gives 2e6 Pa, and pressures are in pascals"
        ]
    return []


def _numbers(spec: Any) -> Iterator[float]:
    """Numbers in a load as users state it: alone, in arrays and lists, as peaks and in tables."""
    if isinstance(spec, (list, tuple)):
        for part in spec:
            yield from _numbers(part)
    elif hasattr(spec, "value"):
        yield from _numbers(spec.value)
    elif hasattr(spec, "peak"):
        yield from _numbers(spec.peak)
    elif isinstance(spec, (int, float, np.ndarray, np.number)):
        values = np.asarray(spec)
        if values.size and values.dtype.kind in "fiu":
            yield float(np.nanmax(np.abs(values)))


def of_result(result: Result, deformation: Mapping[str, Array]) -> list[str]:
    """Questions about a result that a linear calculation gives and no body bears.

    Parameters
    ----------
    deformation : Mapping of "upper" and "lower" to (3, n) [m]
        Displacement of the contact points without rigid motion.
    """
    questions: list[str] = []
    touching = result.status > 0
    if not touching.any():
        return questions
    contact = float(np.ptp(result.points[:, touching], axis=1).max(initial=0.0))
    # a single point is as wide as its cell
    contact = max(contact, float(np.sqrt(result.area[touching].max(initial=0.0))))
    materials = []
    for side, moved in deformation.items():
        body = getattr(result, side)
        material = _material(body)
        if material is None:
            continue
        materials.append(material)
        extents = [
            np.ptp(part.body.mesh.nodes, axis=0).max()
            for part in result.parts
            if part.upper == (side == "upper")
        ]
        size, what = (float(max(extents)), "size") if extents else (contact, "contact's size")
        most = float(np.sqrt((moved**2).sum(axis=0)).max(initial=0.0))
        if most > SMALL * size:
            questions.append(
                f"the {side} body deforms by {most:.3g} m, {100.0 * most / size:.0f} % of its {what} of "
                f"{size:.3g} m: the calculation is one of small deformations (below about 5 %), and "
                "moduli and pressures are in pascals, lengths in metres"
            )
    peak = result.report.peak_pressure
    if peak > DENT and materials and all(STEELS[0] <= m.young_modulus <= STEELS[1] for m in materials):
        questions.append(
            f"the peak pressure is {1e-9 * peak:.3g} GPa, beyond what steel bears elastically: even "
            f"hardened bearing steel keeps a dent from {1e-9 * DENT:g} GPa on (ISO 76)"
        )
    return questions

# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of shifts and of rolling."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..bodies.material import Material
from ..geometry.contact_points import window
from ..results.derivatives import Gradient, Margin

Array = NDArray[np.float64]
Shape = tuple[int, ...]
Cut = tuple[slice, slice]


@dataclass(frozen=True)
class Moving:
    """What moves, in the words of its motion.

    Attributes
    ----------
    rigid : dict of str to tuple of int
        Which of x, y and the rotation about z an input holds.
    speed : str
        The velocity of rolling, or the duration of a shift.
    speed_slope : float
        Derivative of the logarithm of the slip speed by it.
    found : (bool, bool)
        Whether x and y were found for a force.
    """

    rigid: Mapping[str, tuple[int, ...]]
    speed: str
    speed_slope: float
    found: tuple[bool, bool]


#: Operators for another value of something, and their weight in the derivative by it.
Weighted = tuple[float, _mtb_rs.PatchOperators]
#: What operators are made for without being linear in it: those that make the derivative by it.
Course = Callable[[], Iterable[Weighted]]
#: Rigid slip (2, ny, nx), heat (ny, nx) and coefficients (ny, nx) that do the same as a unit of something.
Made = tuple[Array, Array, Array]


@dataclass(frozen=True)
class Grids:
    """Where the cells of the core lie: on a grid of `shape` (ny, nx), and on that of the earlier state.

    `is_open` (ny, nx) tells the cells out of contact.
    """

    shape: tuple[int, int]
    cut: Cut
    before: tuple[int, int] | None
    cut_before: Cut | None
    is_open: NDArray[np.bool_]

    def cells(self, field: Array, fill: float = 0.0) -> Array:
        """The cells of the core of a field of the result."""
        return np.ascontiguousarray(window(np.asarray(field, dtype=float), self.cut, fill))

    def whole(self, part: Array) -> Array:
        """A field of the result from that of the core."""
        return _back(part, self.cut, self.shape)


def _back(part: Array, cut: Cut, shape: tuple[int, int]) -> Array:
    seen = tuple(slice(-c.start, n - c.start) for c, n in zip(cut, shape, strict=True))
    return window(part, seen)


class _BySides(NamedTuple):
    """Rigid slip (2, 2, ny, nx), here and one step behind, that bodies stand for, and stiffness of ties."""

    slips: Array
    stiffness: float

    @staticmethod
    def sum(a: float, first: _BySides, b: float = 0.0, second: _BySides | None = None) -> _BySides:
        """Of one, or of two, with factors."""
        if second is None:
            return _BySides(a * first.slips, a * first.stiffness)
        return _BySides(a * first.slips + b * second.slips, a * first.stiffness + b * second.stiffness)


@dataclass(frozen=True)
class Yielded:
    """What a layer that yields has done in a result.

    Attributes
    ----------
    share : (ny, nx) [-]
        Of the slip that is plastic.
    slip : (2, ny, nx)
        The whole of it, that of the surfaces and the plastic one.
    dissipation : (ny, nx)
        The whole of it.
    """

    share: Array
    slip: Array
    dissipation: Array


class TangentialTangent:
    """What changes of a shift or of rolling follow from changes of what was given.

    Cells out of contact, in stick and in slip stay so. `forward` and `adjoint` take one linear solve for each
    change or functional; nothing but the problem is kept between them.

    Attributes
    ----------
    fields : dict of str to shape
        What is found: ``traction`` (3, ny, nx), of which the third component is none; ``slip`` (2, ny, nx);
        ``friction_coefficient`` and ``dissipation`` (ny, nx); ``creepage`` (3,), given or found. And
        ``pressure`` (ny, nx), which is given. With a layer that yields, ``plastic_slip`` (2, ny, nx),
        ``accumulated_plastic_slip`` and ``plastic_dissipation`` (ny, nx).
    inputs : dict of str to shape
        What is given: ``pressure`` (ny, nx); ``creepage`` (3,) of rolling, ``displacement`` (2,) and ``spin``
        of a shift; ``force`` (2,) if one was given; the parameters of friction;
        ``velocity`` or ``duration``, by which fields change if friction follows the slip; ``step`` and
        ``angle`` of rolling; ``layer.thickness`` and ``layer.shear_modulus``, with a layer that yields
        ``layer.yield_stress`` and ``layer.hardening``;
        ``lower.young_modulus``, ``lower.poisson_ratio`` and those of the upper body;
        ``state.traction``, ``state.pressure`` and ``state.coefficient`` of the earlier state, and
        ``state.accumulated_plastic_slip``.
    refused : dict of str to str
        What else could be asked for, and why there is no derivative by it.
    margin : Margin
    """

    def __init__(
        self,
        core: _mtb_rs.TangentialTangent,
        grids: Grids,
        moving: Moving,
        slopes: Mapping[str, Array | None],
        followed: Mapping[str, Array],
        layer: tuple[float, float] | None,
        bodies: Mapping[str, Material],
        other_bodies: Callable[[Any, Any], _mtb_rs.PatchOperators],
        courses: Mapping[str, Course],
        refused: Mapping[str, str],
        margin: Margin,
        yielded: Yielded | None = None,
        *,
        made: dict[str, Made],
        is_inclined: bool = False,
    ) -> None:
        shape = grids.shape
        self._core, self._grids, self._moving = core, grids, moving
        self._slopes, self._followed = slopes, followed
        self._layer, self._bodies, self._other_bodies = layer, bodies, other_bodies
        self._courses, self._made = courses, made
        self.refused = refused
        self.margin = margin
        self._yielded, self._is_inclined = yielded, is_inclined
        self.fields: dict[str, Shape] = {
            "traction": (3, *shape),
            "slip": (2, *shape),
            "friction_coefficient": shape,
            "dissipation": shape,
            "creepage": (3,),
            "pressure": shape,
        }
        if yielded is not None:
            self.fields |= {
                "plastic_slip": (2, *shape),
                "accumulated_plastic_slip": shape,
                "plastic_dissipation": shape,
            }
        self.inputs: dict[str, Shape] = {"pressure": shape}
        self.inputs |= {n: (len(parts),) if len(parts) > 1 else () for n, parts in moving.rigid.items()}
        if any(moving.found):
            self.inputs["force"] = (2,)
        self.inputs |= {name: shape if slope is None else () for name, slope in slopes.items()}
        self.inputs |= {name: slopes.shape[1:] for name, slopes in followed.items()}
        self.inputs[moving.speed] = ()
        self.inputs |= dict.fromkeys(courses, ())
        if layer is not None:
            self.inputs |= {"layer.thickness": (), "layer.shear_modulus": ()}
        if yielded is not None:
            self.inputs |= {"layer.yield_stress": (), "layer.hardening": ()}
        for side in bodies:
            self.inputs |= {f"{side}.young_modulus": (), f"{side}.poisson_ratio": ()}
        if grids.before is not None:
            before = grids.before
            self.inputs |= {"state.traction": (2, *before), "state.pressure": before}
            self.inputs["state.coefficient"] = before
            if yielded is not None:
                self.inputs["state.accumulated_plastic_slip"] = before
        #: Products with the slip operator so far.
        self.products = 0

    def forward(self, changes: Mapping[str, Array]) -> dict[str, Array]:
        """Changes (k, *shape) of all fields by k changes (k, *shape) of inputs."""
        count = max(len(change) for change in changes.values())
        rows = [self._forward({name: c[k] for name, c in changes.items()}) for k in range(count)]
        return {name: np.stack([row[name] for row in rows]) for name in self.fields}

    def adjoint(self, weights: Mapping[str, Array]) -> Mapping[str, Array]:
        """Derivatives (k, *shape) of k functionals by each input, from their weights (k, *shape).

        They are 0 by creepages and displacements that were found, and by forces that were not given.
        """
        count = max(len(weight) for weight in weights.values())
        found = [self._adjoint({name: w[k] for name, w in weights.items()}) for k in range(count)]
        explicit = [{name: w[k] for name, w in weights.items()} for k in range(count)]

        def entry(name: str) -> Array:
            pairs = zip(found, explicit, strict=True)
            return np.stack([self._by(name, of_core, direct) for of_core, direct in pairs])

        return Gradient(self.inputs, entry)

    # forward

    def _forward(self, change: Mapping[str, Array]) -> dict[str, Array]:
        grids, moving = self._grids, self._moving
        given = {n: np.asarray(change.get(n, np.zeros(s)), dtype=float) for n, s in self.inputs.items()}
        rigid = np.zeros(3)
        for name, parts in moving.rigid.items():
            rigid[list(parts)] = given[name]
        drive = [float(given["force"][c] if moving.found[c] else rigid[c]) for c in (0, 1)]
        coefficient = np.zeros(grids.shape)
        for name, slope in self._slopes.items():
            coefficient += given[name] if slope is None else slope * given[name]
        law = np.zeros(self._rest_by_law.size)
        if self._followed:
            law[-1] = moving.speed_slope * float(given[moving.speed])
        for name, slopes in self._followed.items():
            law[:-1] += np.tensordot(slopes, given[name], given[name].ndim)
        layer = 0.0
        if self._layer is not None:
            thickness, modulus = self._layer
            layer = float(
                given["layer.thickness"] / modulus - thickness / modulus**2 * given["layer.shear_modulus"]
            )
        slips, stiffness = np.zeros((2, 2, *self._cells)), 0.0
        for side in self._bodies:
            for constant in ("young_modulus", "poisson_ratio"):
                if (by := float(given[f"{side}.{constant}"])) != 0.0:
                    bodies = self._by_constant(side, constant)
                    slips, stiffness = slips + by * bodies.slips, stiffness + by * bodies.stiffness
        here, behind = slips
        warmed = np.zeros(grids.shape)
        for name in self._courses:
            if (by := float(given[name])) != 0.0:
                slip, own, turned = self._by_course(name)
                here, warmed = here + by * slip, warmed + by * own
                coefficient = coefficient + by * turned
        past = [np.zeros((2, *self._cells)), np.zeros(self._cells), np.zeros(self._cells)]
        if grids.cut_before is not None:
            names = ("state.traction", "state.pressure", "state.coefficient")
            past = [np.ascontiguousarray(window(given[name], grids.cut_before)) for name in names]
        of_layer = None
        if self._yielded is not None:
            particles = np.zeros(self._cells)
            if grids.cut_before is not None:
                before = window(given["state.accumulated_plastic_slip"], grids.cut_before)
                particles = np.ascontiguousarray(before)
            of_layer = (float(given["layer.yield_stress"]), float(given["layer.hardening"]), particles)
        traction, slip, coefficient_found, found, heat, plastic, products = self._core.forward(
            grids.cells(given["pressure"]),
            drive,
            float(rigid[2]),
            np.ascontiguousarray(here),
            np.ascontiguousarray(behind),
            grids.cells(coefficient),
            law,
            warmed,
            layer,
            (past[0], past[1], past[2]),
            of_layer,
            stiffness,
        )
        self.products += products
        tangential, coefficients = grids.whole(traction), grids.whole(coefficient_found)
        # out of contact the coefficient is what was given, of a law that at rest
        if self._followed:
            coefficient = np.full(grids.shape, self._rest_by_law @ law)
        coefficients[grids.is_open] = coefficient[grids.is_open]
        changed = {
            "traction": np.concatenate([tangential, np.zeros((1, *grids.shape))]),
            # nothing slips out of contact
            "slip": np.where(grids.is_open, 0.0, grids.whole(slip)),
            "friction_coefficient": coefficients,
            "dissipation": heat,
            "creepage": np.array([*found, rigid[2]]),
            "pressure": given["pressure"],
        }
        if self._yielded is not None:
            assert plastic is not None
            yielded, share = self._yielded, grids.whole(plastic[0])
            slipped = yielded.share * changed["slip"] + share * yielded.slip
            changed |= {
                "slip": changed["slip"] - slipped,
                "plastic_slip": slipped,
                "accumulated_plastic_slip": grids.whole(plastic[1]),
                "plastic_dissipation": yielded.share * changed["dissipation"] + share * yielded.dissipation,
            }
        return changed

    # adjoint

    def _adjoint(self, weights: Mapping[str, Array]) -> _mtb_rs.TangentialChange:
        grids = self._grids
        given = {n: np.asarray(weights.get(n, np.zeros(s)), dtype=float) for n, s in self.fields.items()}
        slip, heat, plastic = given["slip"], given["dissipation"], None
        if self._yielded is not None:
            here, of_plastic = self._yielded, given["plastic_slip"] - slip
            of_share = (here.slip * of_plastic).sum(axis=0) + here.dissipation * given["plastic_dissipation"]
            slip = slip + here.share * of_plastic
            heat = heat + here.share * given["plastic_dissipation"]
            plastic = grids.cells(of_share), grids.cells(given["accumulated_plastic_slip"])
        found = self._core.adjoint(
            grids.cells(given["traction"][:2]),
            grids.cells(np.where(grids.is_open, 0.0, slip)),
            grids.cells(given["friction_coefficient"]),
            given["creepage"][:2].tolist(),
            np.ascontiguousarray(heat),
            plastic,
        )
        self.products += found.products
        return found

    def _by(self, name: str, found: _mtb_rs.TangentialChange, weights: Mapping[str, Array]) -> Array:
        """Derivative by an input, from those by what the core was given."""
        grids, moving = self._grids, self._moving
        if name in self._courses:
            by = self._along_course(name, found)
            return by + self._by_speed(found, weights) if name == moving.speed else by
        if name == moving.speed:
            return self._by_speed(found, weights)
        if name == "pressure":
            return grids.whole(found.pressure) + weights.get("pressure", 0.0)
        if name in moving.rigid:
            spin = found.spin + np.asarray(weights.get("creepage", np.zeros(3)))[2]
            drive = [0.0 if is_found else d for d, is_found in zip(found.drive, moving.found, strict=True)]
            return np.array([*drive, spin])[list(moving.rigid[name])].reshape(self.inputs[name])
        if name == "force":
            return np.where(moving.found, found.drive, 0.0)
        if name in self._slopes:
            slope, by_field = self._slopes[name], grids.whole(found.coefficient)
            of_coefficient = np.asarray(weights.get("friction_coefficient", np.zeros(grids.shape)))
            by_field = np.where(grids.is_open, of_coefficient, by_field)
            return by_field if slope is None else np.asarray((slope * by_field).sum())
        if name in self._followed:
            by_law = self._by_law(found, weights)
            return np.asarray(np.tensordot(by_law[:-1], self._followed[name], 1))
        if name in ("layer.yield_stress", "layer.hardening"):
            assert found.plasticity is not None
            return np.asarray(found.plasticity[name == "layer.hardening"])
        if name == "state.accumulated_plastic_slip":
            assert found.plasticity is not None
            assert grids.before is not None
            assert grids.cut_before is not None
            return _back(found.plasticity[2], grids.cut_before, grids.before)
        if name.startswith("layer."):
            assert self._layer is not None
            thickness, modulus = self._layer
            slope_of = {"layer.thickness": 1.0 / modulus, "layer.shear_modulus": -thickness / modulus**2}
            return np.asarray(slope_of[name] * found.layer)
        if name.startswith("state."):
            names = ("state.traction", "state.pressure", "state.coefficient")
            assert grids.before is not None
            assert grids.cut_before is not None
            return _back(found.earlier[names.index(name)], grids.cut_before, grids.before)
        side, constant = name.split(".")
        bodies = self._by_constant(side, constant)
        here, behind = bodies.slips
        by_slip = (here * found.rigid_slip).sum() + (behind * found.rigid_slip_behind).sum()
        return np.asarray(by_slip + bodies.stiffness * found.stiffness)

    def _along_course(self, name: str, found: _mtb_rs.TangentialChange) -> Array:
        slip, heat, turned = self._by_course(name)
        direct = (heat * found.heat).sum() + (turned * self._grids.whole(found.coefficient)).sum()
        return np.asarray((slip * found.rigid_slip).sum() + direct)

    def _by_law(self, found: _mtb_rs.TangentialChange, weights: Mapping[str, Array]) -> Array:
        """Derivatives by the parameters of the core and the speed, of a law."""
        of_coefficient = np.asarray(weights.get("friction_coefficient", np.zeros(self._grids.shape)))
        # out of contact the coefficient is that at rest
        return np.asarray(found.law + of_coefficient[self._grids.is_open].sum() * self._rest_by_law)

    def _by_speed(self, found: _mtb_rs.TangentialChange, weights: Mapping[str, Array]) -> Array:
        """Derivative by the speed, as friction knows it."""
        if not self._followed:
            # the slip is that of a unit of time or length: no field follows the speed
            return np.zeros(())
        return np.asarray(self._moving.speed_slope * self._by_law(found, weights)[-1])

    @cached_property
    def _rest_by_law(self) -> Array:
        """Derivatives of the coefficient at rest by the parameters of the core and the speed, of a law."""
        return self._core.rest_by_law()

    # step and direction, and moduli of prisms

    def _by_course(self, name: str) -> Made:
        """Rigid slip (2, ny, nx) that does the same as a unit of one of these, and heat and coefficients.

        What is carried along by a step is interpolated between cells, with a kink at whole ones: on the side
        of a longer step and a larger angle.
        """
        if name not in self._made:
            slip, heat = np.zeros((2, *self._cells)), np.zeros(self._grids.shape)
            for weight, operators in self._courses[name]():
                moved = self._core.with_operators(operators)
                slip += weight * moved[0]
                heat += weight * moved[1]
            turned = np.zeros(self._grids.shape)
            if name == "angle":
                # friction that follows the temperature: heat goes other ways
                turned = self._grids.whole(self._core.coefficient_by_angle())
            self._made[name] = slip, heat, turned
        return self._made[name]

    # materials

    @property
    def _cells(self) -> tuple[int, int]:
        rows, columns = self._grids.cut
        return rows.stop - rows.start, columns.stop - columns.start

    @cached_property
    def _of_unit(self) -> dict[str, tuple[_BySides, _BySides]]:
        """What a half-space of G = 1 Pa stands for.

        One of each side at a Poisson's ratio of 0, and at 0.5: between, it is linear in the ratio.
        """

        def of(lower: tuple[float, float] | None, upper: tuple[float, float] | None) -> _BySides:
            here, behind, stiffness = self._core.slip_by_bodies(self._other_bodies(lower, upper))
            return _BySides(np.array([here, behind]), stiffness)

        if self._is_inclined:
            # it is known of like bodies only: half of what both do
            loose, firm = (_BySides.sum(0.5, of(both, both)) for both in ((1.0, 0.0), (1.0, 0.5)))
            return dict.fromkeys(self._bodies, (loose, firm))
        firm = of((1.0, 0.5), None)
        sides = {"lower": ((1.0, 0.0), None), "upper": (None, (1.0, 0.0))}
        return {side: (of(*sides[side]), firm) for side in self._bodies}

    def _by_constant(self, side: str, constant: str) -> _BySides:
        """What does the same as a unit of a constant of a body."""
        material = self._bodies[side]
        modulus, ratio = material.shear_modulus, material.poisson_ratio
        loose, firm = self._of_unit[side]
        own = _BySides.sum((1.0 - 2.0 * ratio) / modulus, loose, 2.0 * ratio / modulus, firm)
        if constant == "young_modulus":
            return _BySides.sum(-1.0 / material.young_modulus, own)
        # at a given Young's modulus the shear modulus falls with the ratio
        twice = _BySides.sum(2.0 / modulus, firm, -2.0 / modulus, loose)
        return _BySides.sum(1.0, twice, 1.0 / (1.0 + ratio), own)

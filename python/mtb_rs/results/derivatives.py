# SPDX-License-Identifier: MIT OR Apache-2.0
"""Exact derivatives of results: of any number in them, by all that was given."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import is_quantity, meant, shortened
from ..base.plain import plain, same

Array = NDArray[np.float64]

#: Why there is no derivative by what a magnet pulls.
PULLS = (
    "a Magnet gives it, whose pull follows the gap: derivatives are by the numbers of the magnet, such as "
    "'magnetic_pressure.ampere_turns'"
)
#: Why there is no derivative by the flexibility of a rough layer.
ROUGH = (
    "it was given as a RoughLayer, a law and no flexibility: derivatives are by the numbers of its law, "
    "'normal_layer.gap' and 'normal_layer.pressure'"
)
Shape = tuple[int, ...]

#: Most numbers of a derivative of a field by a field.
_MOST = 50_000_000
#: Largest weight: sums of squares of larger ones are beyond the numbers.
_LARGEST = 1e100


@dataclass(frozen=True)
@plain
class Margin:
    """How far a state is from those whose derivatives have two sides.

    Derivatives hold as long as no point comes into contact or leaves it, begins to slip or to stick, begins
    or ceases to flow. The margin says by how much the nearest point would have to change; at 0 the
    derivatives are those of one side.

    Attributes
    ----------
    parting : float
        Smallest pressure of a point in contact, over the largest one.
    touching : float
        Smallest gap of a point beside the contact, over the largest elastic displacement; where nothing
        touches yet, over the range of the gaps.
    slipping : float or None
        Smallest distance of the traction from its bound where points stick, over the largest bound.
    sticking : float or None
        Smallest slip where points slip, over the largest one.
    yielding : float or None
        Smallest distance of the pressure from the hardness where it is below it, over the hardness, or of
        sliding friction from the stress at which a layer yields, over that.
    unloading : float or None
        Smallest plastic indentation where the pressure is the hardness, over the largest elastic
        displacement.
    peak : float or None
        Difference of the two largest pressures, over the largest: at 0 two points share the peak, as those
        of the two poles of a shoe do, and the derivative of the peak pressure is that of one of them. It does
        not concern other numbers and is not in `smallest`.
    wedging : float or None
        `wedging_margin` of the report; of a step without that of tipping over. Near 1 the derivatives grow
        without limit.
    """

    parting: float
    touching: float
    slipping: float | None = None
    sticking: float | None = None
    wedging: float | None = None
    yielding: float | None = None
    unloading: float | None = None
    peak: float | None = None

    @staticmethod
    def of_first_touch(gap: Array) -> float:
        """How far bodies that do not touch are from it: their smallest gap (n,) over the range of all."""
        nearest = max(float(gap.min(initial=np.inf)), 0.0)
        return nearest and nearest / max(float(np.ptp(gap)), np.finfo(float).tiny)

    @property
    def smallest(self) -> float:
        """The smallest of the distances of points."""
        in_contact = (self.parting, self.touching, self.yielding, self.unloading)
        of_points = (*in_contact, self.slipping, self.sticking)
        return min(v for v in of_points if v is not None)


class Tangent(Protocol):
    """The equations of a solved state, linearised about it.

    Attributes
    ----------
    fields : Mapping of name to shape
        What is found, of which sums can be derived.
    inputs : Mapping of name to shape
        What is given, by which they can be derived.
    refused : Mapping of name to str
        What else could be asked for, and why there is no derivative by it.
    margin : Margin
    """

    @property
    def fields(self) -> Mapping[str, Shape]: ...

    @property
    def inputs(self) -> Mapping[str, Shape]: ...

    @property
    def refused(self) -> Mapping[str, str]: ...

    @property
    def margin(self) -> Margin: ...

    def forward(self, changes: Mapping[str, Array]) -> Mapping[str, Array]:
        """Changes (k, ...) of all fields by k small changes (k, ...) of what is given."""

    def adjoint(self, weights: Mapping[str, Array]) -> Mapping[str, Array]:
        """Gradients (k, ...) by all inputs of k sums of fields with the `weights` (k, ...)."""


@dataclass(frozen=True)
class Functional:
    """Numbers of a result as sums of its fields, near its state.

    Attributes
    ----------
    shape : tuple of int
        Of the numbers; () for a single one.
    weights : Mapping of field to (k, ...)
    explicit : Mapping of input to (k, ...)
        Derivatives by what is given while all fields stay as they are.
    refused : Mapping of input to str
        By what the numbers have no derivatives, and why.
    """

    shape: Shape
    weights: Mapping[str, Array]
    explicit: Mapping[str, Array] = field(default_factory=dict)
    refused: Mapping[str, str] = field(default_factory=dict)

    @property
    def size(self) -> int:
        return math.prod(self.shape)

    @classmethod
    def of_one(cls, **weights: Array) -> Functional:
        """Of a single number."""
        return cls((), {name: np.asarray(w)[None] for name, w in weights.items()})

    @classmethod
    def in_a_row(cls, parts: Sequence[Functional]) -> Functional:
        """The numbers of several functionals, one after the other."""
        size = sum(part.size for part in parts)

        def stacked(of: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
            rows: dict[str, Array] = {}
            first = 0
            for part, own in zip(parts, of, strict=True):
                for name, values in own.items():
                    if name not in rows:
                        rows[name] = np.zeros((size, *values.shape[1:]))
                    rows[name][first : first + part.size] = values
                first += part.size
            return rows

        refused = {by: why for part in parts for by, why in part.refused.items()}
        return cls(
            (size,), stacked([p.weights for p in parts]), stacked([p.explicit for p in parts]), refused
        )

    @classmethod
    def of_pressure(
        cls, pressure: Callable[[], Array], area: Array, closed: NDArray[np.bool_]
    ) -> dict[str, Callable[[], Functional]]:
        """What every contact says of its pressure: force, peak, mean over the points that are `closed`.

        The peak is that at the point where it is now; only there `pressure` is asked for.
        """

        def peak() -> Functional:
            weight = np.zeros(area.shape)
            weight.flat[pressure().argmax()] = 1.0
            return cls.of_one(pressure=weight)

        def mean() -> Functional:
            whole = max(float(area[closed].sum()), np.finfo(float).tiny)
            return cls.of_one(pressure=area / whole)

        return {
            "normal_force": lambda: cls.of_one(pressure=area),
            "peak_pressure": peak,
            "mean_pressure": mean,
        }


class Gradient(Mapping[str, Any]):
    """Derivatives of numbers by all that was given: one entry for each input, computed when it is asked for.

    The entry of an input has the shape of the numbers, followed by that of the input.
    """

    def __init__(
        self,
        inputs: Mapping[str, Shape],
        entry: Callable[[str], Any],
        refused: Mapping[str, str] | None = None,
    ) -> None:
        #: Shape of each input.
        self.inputs = dict(inputs)
        self._entry = entry
        self._refused = dict(refused or {})
        self._known: dict[str, Any] = {}

    def __getitem__(self, by: str) -> Any:
        if by in self._refused:
            raise KeyError(f"{by!r} has no entry: {self._refused[by]}")
        if by not in self.inputs:
            raise KeyError(f"{by!r} is no input: {', '.join(self.inputs)} are")
        if by not in self._known:
            self._known[by] = self._entry(by)
        return self._known[by]

    def __iter__(self) -> Iterator[str]:
        return iter(self.inputs)

    def __len__(self) -> int:
        return len(self.inputs)

    def __repr__(self) -> str:
        return f"<Gradient by {', '.join(self.inputs)}>"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Gradient) and same(dict(self), dict(other))

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        # all of it: what computes it stays behind
        return Gradient, (self.inputs, dict(self).__getitem__, self._refused)


class Differentiable(ABC):
    """A result that has derivatives."""

    pressure: Any
    area: Any

    @abstractmethod
    def _tangent(self) -> Tangent:
        """Its linearised equations; ValueError if there are none, with the reason."""

    @abstractmethod
    def _functionals(self) -> Mapping[str, Callable[[], Functional]]:
        """Its numbers that have derivatives, by name, besides its fields."""

    def _pressures(self) -> Array:
        """Of all points (n,) [Pa]."""
        return np.ravel(self.pressure)

    def derivative(self, of: Any, by: str) -> Any:
        """Exact derivative of a number or a field of the result by something that was given.

        The points in contact stay the same, and so do those that slip: see :meth:`margin`. One linear solve
        with the matrix of the solution gives a derivative by a number; one with the transposed matrix gives
        those of a number by everything.

        Parameters
        ----------
        of : str, Mapping, callable or list of these
            What is derived:

            - the name of a number, such as "force", "moment", "approach", "peak_pressure" or "mean_pressure",
              or of a field, such as "pressure";
            - weights of fields, ``{"pressure": w}`` with `w` of the shape of the field: the derivative is
              that of the sum of `w` times the field. The load on a region is ``{"pressure": area * region}``;
            - a function of the result that returns a number and its own gradient by fields, ``(value,
              {"pressure": gradient})``;
            - a list of these: their numbers in a row, from one solve for all of them.
        by : str
            What was given, such as "gap", "friction", "force", "magnetic_pressure"; an error lists all.

        Returns
        -------
        float or array
            The shape of the number or field, followed by that of what was given. SI units.

        Raises
        ------
        ValueError
            If the result has no such number, field or input, or no derivatives.
        """
        tangent = self._tangent()
        inputs = tangent.inputs
        if isinstance(by, str) and by in tangent.refused:
            raise ValueError(f"by is {by!r}: {tangent.refused[by]}")
        _known("by", by, inputs)
        if isinstance(of, str) and of in tangent.fields:
            found, given = tangent.fields[of], inputs[by]
            if math.prod(given) < math.prod(found):
                _refuse_large(of, by, math.prod(found) * math.prod(given))
                changes = _units(given)
                rows = np.asarray(tangent.forward({by: changes})[of])
                return _number(np.moveaxis(rows, 0, -1).reshape((*found, *given)))
        functional = self._functional(of, tangent, by, math.prod(inputs[by]))
        return entry_of(functional, tangent.adjoint(functional.weights), by, inputs[by])

    def gradient(self, of: Any) -> Gradient:
        """Exact derivatives of a number of the result by all that was given, from one transposed solve.

        Parameters
        ----------
        of : str, Mapping, callable or list of these
            As of :meth:`derivative`.

        Returns
        -------
        Gradient
            A mapping of each input to the derivative by it.

        Raises
        ------
        ValueError
            If the result has no such number or field, or no derivatives.
        """
        tangent = self._tangent()
        inputs = tangent.inputs
        functional = self._functional(of, tangent, "all that was given", max(map(math.prod, inputs.values())))
        return gradient_of(functional, tangent.adjoint(functional.weights), tangent)

    def margin(self) -> Margin:
        """How far the state is from one whose derivatives differ on the two sides of it.

        Raises
        ------
        ValueError
            If the result has no derivatives.
        """
        margin = self._tangent().margin
        pressure = self._pressures()
        if pressure.size < 2 or pressure.max() <= 0.0:
            return margin
        second, largest = np.partition(pressure, -2)[-2:]
        return replace(margin, peak=float((largest - second) / largest))

    def _functional(self, of: Any, tangent: Tangent, by: str = "", size: int = 1) -> Functional:
        """Numbers `of`, to be derived by `size` numbers that are called `by`."""
        if isinstance(of, str) and of in tangent.fields:
            shape = tangent.fields[of]
            _refuse_large(of, by, math.prod(shape) * size)
            return Functional(shape, {of: _units(shape)})
        if isinstance(of, (list, tuple)):
            if not of:
                raise ValueError("of is empty: a name, weights of fields, or a function is needed at least")
            return Functional.in_a_row([self._functional(part, tangent, by, size) for part in of])
        if isinstance(of, str):
            known = self._functionals()
            if of not in known:
                _known("of", of, {**known, **tangent.fields})
            return known[of]()
        weights = of
        if not isinstance(of, Mapping):
            if not callable(of):
                raise ValueError(
                    f"of is {shortened(of)}: a name, weights of fields, or a function of the result is "
                    "needed, or a list of these"
                )
            told = of(self)
            if not (isinstance(told, tuple) and len(told) == 2 and isinstance(told[1], Mapping)):
                raise ValueError(
                    f"of is a function that returns {shortened(told)}: a pair (value, {{field: gradient}}) "
                    "is needed"
                )
            weights = told[1]
            # numbers of JAX and others are arrays without axes
            value = np.asarray(None if is_quantity(told[0]) else told[0])
            if value.ndim or value.dtype.kind not in "fiu" or not np.isfinite(value):
                raise ValueError(f"of is a function whose value is {told[0]!r}: a finite number is needed")
        if not weights:
            # of nothing
            name, shape = next(iter(tangent.fields.items()))
            return Functional.of_one(**{name: np.zeros(shape)})
        return Functional((), {name: _weight(name, w, tangent)[None] for name, w in weights.items()})


class Chained(Differentiable):
    """A result of a step that starts from the state of another one."""

    @abstractmethod
    def follows(self, earlier: Any) -> bool:
        """Whether it started from the state of another result."""

    @abstractmethod
    def _through(self, results: Sequence[Any], functionals: Sequence[Functional]) -> list[Gradient]:
        """Gradients of the sum of single numbers of `results` in a row, of which it is the first, by the
        inputs of each."""


class ChainedBack(Chained):
    """A step whose gradients by the state go back to the step that left it: one transposed solve a step."""

    @abstractmethod
    def _carried(self, by: Mapping[str, Array]) -> dict[str, Array]:
        """Weights of the fields of the step before that do what gradients `by` inputs of this one do."""

    def _through(self, results: Sequence[Any], functionals: Sequence[Functional]) -> list[Gradient]:
        found: list[Gradient] = []
        carried: dict[str, Array] = {}
        for result, functional in zip(reversed(results), reversed(functionals), strict=True):
            tangent = result._tangent()
            if beyond := [name for name in carried if name not in tangent.fields]:
                raise ValueError(
                    f"a step has no derivatives of {', '.join(beyond)}, from which the next one starts: all "
                    "steps of a chain are shifts"
                )
            summed = dict(carried)
            for name, w in functional.weights.items():
                summed[name] = summed.get(name, 0.0) + np.asarray(w)
            by = tangent.adjoint(summed)
            found.append(gradient_of(functional, by, tangent))
            carried = result._carried(by) if "state.traction" in tangent.inputs else {}
        return found[::-1]


def gradient_of(functional: Functional, by: Mapping[str, Array], tangent: Tangent) -> Gradient:
    """Derivatives by all inputs, from what they are by the fields."""

    def entry(name: str) -> Any:
        return entry_of(functional, by, name, tangent.inputs[name])

    return Gradient(tangent.inputs, entry, tangent.refused)


def _weight(name: str, given: ArrayLike, tangent: Tangent) -> Array:
    _known("a weight in of", name, tangent.fields)
    shape = tangent.fields[name]
    if is_quantity(given):
        raise ValueError(
            f"of[{name!r}] has a unit: plain numbers, weights of a field in SI units, are needed"
        )
    if np.ma.is_masked(given):
        raise ValueError(
            f"of[{name!r}] has masked entries: a weight for each of {shape} is needed; 0 leaves out"
        )
    try:
        values = np.asarray(given)
        if values.dtype.kind not in "fiub":
            raise TypeError
        values = values.astype(float)
    except (TypeError, ValueError):
        raise ValueError(f"of[{name!r}] is no array of real numbers: {shape} of them are needed") from None
    if values.shape != shape:
        try:
            values = np.broadcast_to(values, shape)
        except ValueError:
            raise ValueError(f"of[{name!r}] has shape {values.shape}: {shape} is needed") from None
    if not (np.abs(values) <= _LARGEST).all():
        place = tuple(int(k) for k in np.argwhere(~(np.abs(values) <= _LARGEST))[0])
        at = f"[{', '.join(map(str, place))}]" if place else ""
        raise ValueError(f"of[{name!r}]{at} is {values[place]:g}: weights up to {_LARGEST:g} are needed")
    # a number alone has no axis
    return np.ascontiguousarray(values).reshape(shape)


def _known(what: str, name: Any, names: Mapping[str, Any]) -> None:
    if isinstance(name, str) and name in names:
        return
    near = meant(name, list(names)) if isinstance(name, str) else ""
    hint = f"did you mean {near}?" if near else f"this result has {', '.join(names)}"
    raise ValueError(f"{what} is {shortened(name)}: {hint}")


def _refuse_large(of: str, by: str, size: int) -> None:
    if size > _MOST:
        raise ValueError(
            f"the derivative of {of} by {by} has {size} numbers: derive a sum of {of}, or fewer points"
        )


def _units(shape: Shape) -> Array:
    """Each entry of an array of a shape alone (size, *shape)."""
    size = math.prod(shape)
    return np.eye(size).reshape(size, *shape)


def entry_of(functional: Functional, found: Mapping[str, Array], by: str, shape: Shape) -> Any:
    """The derivative of numbers by an input of a shape, from what `adjoint` found for their weights."""
    if by in functional.refused:
        raise ValueError(f"by is {by!r}: {functional.refused[by]}")
    values = np.asarray(found[by])
    if by in functional.explicit:
        values = values + functional.explicit[by]
    return _number(values.reshape((*functional.shape, *shape)))


def _number(values: Array) -> Any:
    return float(values) if values.ndim == 0 else values

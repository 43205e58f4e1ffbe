# SPDX-License-Identifier: MIT OR Apache-2.0
"""The cases of a sweep: all combinations of values, or a list."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.units import in_si, unit_of_argument
from ..results.sweep_table import argument_units

#: Cases of one sweep: all of them are held in memory.
MOST_CASES = 1_000_000


@dataclass(frozen=True)
class Cases:
    """What a sweep solves.

    Attributes
    ----------
    grid : dict of names to labels to values
        The axes of the table.
    listed : tuple of dicts or None
        The cases along the only axis, where they are no combinations.
    own : Mapping
        The scene's arguments, which stand for those that a listed case leaves out.
    """

    grid: dict[str, dict[Any, Any]]
    listed: tuple[dict[str, Any], ...] | None = None
    own: Mapping[str, Any] = field(default_factory=dict)

    @property
    def names(self) -> dict[str, None]:
        """The arguments that vary."""
        return dict.fromkeys(self.grid if self.listed is None else (n for case in self.listed for n in case))

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the table."""
        return tuple(len(values) for values in self.grid.values())

    def __len__(self) -> int:
        return math.prod(self.shape)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        if self.listed is not None:
            yield from self.listed
            return
        for chosen in product(*(values.values() for values in self.grid.values())):
            yield dict(zip(self.grid, chosen, strict=True))

    def columns(self) -> dict[str, NDArray[np.float64]]:
        """Arguments of listed cases that are numbers; NaN stands for one that has no value."""
        listed = self.listed or ()
        table = {name: [case.get(name, self.own.get(name)) for case in listed] for name in self.names}
        return {
            name: np.array([math.nan if value is None else float(value) for value in values])
            for name, values in table.items()
            if values and all(value is None or _is_number(value) for value in values)
        }

    def units(self) -> dict[str, str]:
        """Units of the arguments that are numbers."""
        listed = {name: unit_of_argument(name) for name in self.columns()}
        return {**argument_units(self.grid), **{name: unit for name, unit in listed.items() if unit}}


def cases_of(parameters: Any, own: Mapping[str, Any]) -> Cases:
    """The cases that the `parameters` of a sweep of a scene with the arguments `own` ask for.

    Raises
    ------
    ValueError
        If they make none, or too many.
    """
    if isinstance(parameters, Mapping):
        cases = Cases({name: _labelled(name, values) for name, values in parameters.items()})
        if not cases.grid:
            raise ValueError("parameters is empty: at least one argument with its values is needed")
    elif callable(getattr(parameters, "to_dict", None)) and hasattr(parameters, "columns"):
        cases = _of_rows(_rows(parameters), list(parameters.index), own)
    elif isinstance(parameters, Sequence) and not isinstance(parameters, (str, bytes)):
        cases = _of_rows(list(parameters), None, own)
    else:
        raise ValueError(
            f"parameters is {parameters!r}: a mapping from arguments to their values, or a list of cases, is "
            "needed"
        )
    if len(cases) > MOST_CASES:
        raise ValueError(f"parameters make {len(cases):.3g} cases: at most {MOST_CASES} are solved at once")
    return cases


def _rows(frame: Any) -> list[dict[str, Any]]:
    """The rows of a table of pandas, in SI units."""
    said = frame.attrs.get("units", {})
    for name in frame.columns:
        unit = unit_of_argument(name) if isinstance(name, str) else ""
        if unit and said and said.get(name, unit) != unit:
            raise ValueError(
                f"column {name!r} is in {said[name]!r}, as the table says: numbers in {unit} are needed"
            )
    rows: list[dict[str, Any]] = frame.to_dict("records")
    return [in_si(f"row {index!r}", row, None) for index, row in zip(frame.index, rows, strict=True)]


def _of_rows(rows: list[Any], index: list[Any] | None, own: Mapping[str, Any]) -> Cases:
    """Cases one after another; they are known by `index`, where it tells them apart."""
    for place, row in enumerate(rows, 1):
        if not isinstance(row, Mapping) or not all(isinstance(name, str) for name in row):
            raise ValueError(
                f"case {place} of parameters is {row!r}: a mapping from arguments to their values is needed"
            )
    if not rows or not any(rows):
        raise ValueError("parameters has no cases: at least one, with one argument, is needed")
    labels = list(range(1, len(rows) + 1))
    named = labels if index is None else index
    is_telling = len(set(named)) == len(rows) and all(_is_label(label) for label in named)
    return Cases({"case": _labelled("case", named if is_telling else labels)}, tuple(map(dict, rows)), own)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.number)) and not isinstance(value, (bool, np.bool_))


def _is_label(label: Any) -> bool:
    return isinstance(label, (int, float, str, np.number))


def _labelled(name: str, values: Any) -> dict[Any, Any]:
    """Values by their labels: numbers and text are their own."""
    if isinstance(values, Mapping):
        labelled = dict(values)
        if not all(_is_label(label) for label in labelled):
            raise ValueError(f"{name} has labels {list(labelled)!r}: numbers or text are needed")
    else:
        try:
            listed = None if isinstance(values, (str, bytes, Set)) else list(values)
        except TypeError:
            listed = None
        if listed is None:
            raise ValueError(f"{name} is {values!r}: a list of values is needed")
        labelled = {_label(value, place): value for place, value in enumerate(listed, 1)}
        if len(labelled) != len(listed):
            raise ValueError(f"{name} has a value twice: {values!r}")
    if not labelled:
        raise ValueError(f"{name} has no values")
    for label in labelled:
        if isinstance(label, str) and ("\0" in label or not _is_unicode(label)):
            raise ValueError(f"{name} has the label {label!r}: text that can be written is needed")
    return {k.item() if isinstance(k, np.number) else k: value for k, value in labelled.items()}


def _label(value: Any, place: int) -> Any:
    """What a value is known by; the same in any process."""
    if _is_label(value):
        return value
    text = str(value)
    # an address, or not all of it
    if " at 0x" in text or "..." in text or "\n" in text:
        return f"{getattr(value, '__name__', type(value).__name__)} {place}"
    return text


def _is_unicode(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True

# SPDX-License-Identifier: MIT OR Apache-2.0
"""Results as labelled arrays of xarray."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..results.grids import flat, patches
from ..results.result import Pictured

_COMPONENTS = ("x", "y", "z")


def dataset_of(result: Pictured) -> Any:
    """The fields of a result; see :meth:`mtb_rs.Result.to_xarray`."""
    try:
        import xarray
    except ImportError as error:
        raise ImportError("xarray is missing: pip install 'mtb-rs[sweep]'") from error
    grids = patches(result)
    is_grid = len(grids) == 1
    dims = ("y", "x") if is_grid else ("point",)

    def shaped(values: NDArray[Any]) -> NDArray[Any]:
        row = flat(result, values)
        return grids[0].view(row) if is_grid else row

    fields = result.fields()
    vectors = [len(field.values) for name, field in fields.items() if field.is_vector and name != "points"]
    most = max(vectors, default=0)

    def variable(values: NDArray[Any], **attributes: str) -> Any:
        own = shaped(values)
        lead = ("component",) if own.ndim > len(dims) else ()
        if lead and len(own) < most:
            # slip lies in the plane of contact, beside tractions in space: nothing slips along z
            own = np.concatenate([own, np.zeros((most - len(own), *own.shape[1:]))])
        return xarray.Variable((*lead, *dims), own, {k: v for k, v in attributes.items() if v})

    data = {
        name: variable(field.values, units=field.unit, long_name=field.label)
        for name, field in fields.items()
        if name != "points"
    }
    places = {axis: shaped(row) for axis, row in zip(_COMPONENTS, fields["points"].values, strict=False)}
    coordinates: dict[str, Any] = {}
    for axis, place in places.items():
        along, own = (dims, place) if not is_grid else _axis(axis, place)
        # a coordinate that is no axis cannot have the name of one
        name = axis if along in ((axis,), ("point",)) or axis not in dims else f"{axis}_place"
        coordinates[name] = xarray.Variable(along, own, {"units": "m"})
    if most:
        coordinates["component"] = list(_COMPONENTS[:most])
    if grids and not is_grid:
        coordinates["patch"] = ("point", np.concatenate([[p.name] * (p.nx * p.ny) for p in grids]))
    totals = {name: np.asarray(total.values).tolist() for name, total in result.totals().items()}
    return xarray.Dataset(data, coordinates, totals)


def _axis(axis: str, place: NDArray[Any]) -> tuple[tuple[str, ...], NDArray[Any]]:
    """Places (ny, nx) along an axis of the grid, where they are the same across it."""
    across = {"x": 0, "y": 1}.get(axis)
    if across is not None:
        line = place.mean(axis=across, keepdims=True)
        if np.allclose(place, line, rtol=0.0, atol=1e-9 * np.ptp(place)):
            return (axis,), line.ravel()
    return ("y", "x"), place

# SPDX-License-Identifier: MIT OR Apache-2.0
"""Tables and fields of pandas and xarray: taken as arguments, given by sweeps and results."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

pandas = pytest.importorskip("pandas", reason="pandas (extra sweep) is not installed")
xarray = pytest.importorskip("xarray", reason="xarray (extra sweep) is not installed")

X = np.arange(-6, 7) * 1e-3
Y = np.arange(-4, 5) * 1e-3
GAP = (X[None, :] ** 2 + 2.0 * Y[:, None] ** 2 + 1e-3 * X[None, :]) / 0.2
FRAME = pandas.DataFrame({"velocity": [0.0, 10.0], "value": [0.3, 0.2]}, index=[7, 9])


def field(**attributes: Any) -> Any:
    return xarray.DataArray(GAP, {"y": Y, "x": X}, ("y", "x"), attrs=attributes)


def scene(**given: Any) -> mtb.Scene:
    return mtb.Scene(
        **{"upper": mtb.steel, "lower": mtb.steel, "gap": GAP, "spacing": 1e-3, "force": 10.0} | given
    )


def test_columns_are_taken_as_the_numbers_in_them() -> None:
    speed, value = FRAME["velocity"], FRAME["value"]
    for made, plain in (
        (mtb.VelocityTable(speed, value), mtb.VelocityTable([0.0, 10.0], [0.3, 0.2])),
        (mtb.TabulatedFriction(speed, value), mtb.TabulatedFriction(*FRAME.to_numpy().T)),
        (mtb.Coulomb(FRAME / 10.0), mtb.Coulomb(FRAME.to_numpy() / 10.0)),
    ):
        assert made == plain
        assert pickle.loads(pickle.dumps(made)) == plain
    profile = mtb.Profile.from_points(pandas.Series(X), pandas.Series(X**2))
    np.testing.assert_array_equal(profile.height(Y), mtb.Profile.from_points(X, X**2).height(Y))
    table = mtb.sweep(mtb.scenes.paraboloid_on_plane(points=18), {"friction": pandas.Series([0.1, 0.2])})
    assert table.parameters == {"friction": (0.1, 0.2)}


@pytest.mark.parametrize(
    "given",
    [
        *(field(), field().T, field()[::-1], field()[:, ::-1].T, field(units="m"), xarray.DataArray(GAP)),
        field().rename(x="X", y="Y").T,
        *(
            pandas.DataFrame(GAP),
            pandas.DataFrame(GAP, Y, X)[::-1],
            pandas.DataFrame(GAP, Y, X).iloc[:, ::-1],
        ),
    ],
)
def test_a_field_on_a_grid_is_turned_as_ours(given: Any) -> None:
    assert scene(gap=given) == scene()
    np.testing.assert_array_equal(scene(gap=given).gap, GAP)


def test_a_field_in_another_unit_is_refused() -> None:
    with pytest.raises(ValueError, match="gap is in 'mm', as its attribute says: numbers in m are needed"):
        scene(gap=field(units="mm"))


@pytest.mark.parametrize(
    ("places", "said"),
    [
        (
            {"x": 1e3 * X, "y": Y},
            "13 points from x = -6 to 6 m: with a spacing of 0.001 m they must be even",
        ),
        ({"x": X + 6e-3, "y": Y}, "from x = 0 to 0.012 m: .* from -0.006 to 0.006 m"),
        ({"x": X, "y": 2.0 * Y}, "9 points from y = -0.008 to 0.008 m"),
        ({"x": X, "y": Y + 3e-5 * (np.arange(9) == 4)}, "evenly spaced"),
        ({"x": xarray.Variable("x", 1e3 * X, {"units": "mm"})}, "gap has x in 'mm', as its attribute says"),
    ],
)
def test_places_are_those_of_the_grid(places: Any, said: str) -> None:
    gap = xarray.DataArray(GAP, places, ("y", "x"))
    asked = (
        lambda: scene(gap=gap),
        lambda: scene().with_(gap=gap),
        lambda: mtb.solve_normal(gap, 1e-3, mtb.steel, mtb.steel, force=10.0),
    )
    for ask in asked:
        with pytest.raises(ValueError, match=said):
            ask()
    if "y" in places and not hasattr(places["x"], "attrs"):
        with pytest.raises(ValueError, match=said):
            scene(gap=pandas.DataFrame(GAP, places["y"], places["x"]))
    friction = xarray.DataArray(np.full(GAP.shape, 0.2), places, ("y", "x"))
    with pytest.raises(ValueError, match=said.replace("gap", "friction")):
        scene().with_(friction=friction)
    # rounded as files are
    near = {"x": X.astype(np.float32), "y": Y.round(6)}
    assert scene(gap=xarray.DataArray(GAP, near, ("y", "x"))) == scene()


def test_a_table_is_a_list_of_cases() -> None:
    ball = mtb.scenes.paraboloid_on_plane(points=18)
    cases = pandas.DataFrame({"friction": [0.1, 0.3], "force": [1e6, 3e6]}, index=["low", "high"])
    table = mtb.sweep(ball, cases)
    assert table.parameters == {"case": ("low", "high")}
    np.testing.assert_allclose(table["force_x"], table["friction"] * table["force"], rtol=1e-12)
    assert table.units["force"] == "N"
    back = mtb.sweep(ball, table.to_pandas().set_index("case")[["friction", "force"]])
    np.testing.assert_array_equal(back["approach"], table["approach"])
    # an index that does not tell the rows apart
    assert mtb.sweep(ball, pandas.concat([cases, cases])).parameters == {"case": (1, 2, 3, 4)}
    milli = cases.copy()
    milli.attrs["units"] = {"force": "kN"}
    with pytest.raises(ValueError, match="column 'force' is in 'kN', as the table says: numbers in N"):
        mtb.sweep(ball, milli)


def test_a_sweep_is_a_table() -> None:
    table = mtb.sweep(
        mtb.scenes.paraboloid_on_plane(points=18), {"friction": [0.1, 0.2], "force": [1e6, 2e6]}
    )
    frame = table.to_pandas()
    assert frame.attrs["units"]["peak_pressure"] == "Pa"
    grid = frame.set_index(["friction", "force"])["force_x"].to_xarray()
    np.testing.assert_array_equal(grid, table["force_x"])
    assert list(frame["status"]) == ["solved"] * 4


@pytest.mark.coarse
def test_results_are_datasets() -> None:
    whole = mtb.scenes.paraboloid_on_plane(points=18).solve("half-space")
    found = whole.to_xarray()
    assert found["pressure"].dims == ("y", "x")
    assert found["pressure"].attrs == {"units": "Pa", "long_name": "pressure"}
    np.testing.assert_array_equal(found["pressure"], whole.pressure.reshape(18, 18))
    peak = found["pressure"].where(found["pressure"] == found["pressure"].max(), drop=True)
    k = int(whole.pressure.argmax())
    assert (float(peak["x"][0]), float(peak["y"][0])) == pytest.approx(
        tuple(whole.points.reshape(3, -1)[:2, k])
    )
    friction = found["traction"].sel(component="x") * found["area"]
    assert float(friction.sum()) == pytest.approx(whole.force[0])
    assert found.attrs["normal_force"] == pytest.approx(whole.normal_force)
    # back in as a field of another scene
    kept = mtb.PressureField(found["pressure"], (1 / 17, 1 / 17), mtb.steel, mtb.steel)
    np.testing.assert_array_equal(kept.pressure, found["pressure"])

    poles = mtb.scenes.pole_shoe_on_rail(spacing=6e-3).solve("half-space")
    found = poles.to_xarray()
    left = found.isel(point=found["patch"] == poles.patches[0].name)
    assert float((left["pressure"] * left["area"]).sum()) == pytest.approx(
        float((poles.pressure * poles.area)[poles.patches[0].cut].sum())
    )
    assert (left["y"] > 0.0).all()


def test_every_kind_of_result_is_a_dataset() -> None:
    start = mtb.scenes.paraboloid_on_plane(points=8).start_of_sliding([(1e-6, 0.0)])
    wheels = mtb.scenes.wheel_on_rail(spacing=1e-3).prepare()
    assert isinstance(wheels, mtb.PreparedWheels)
    step = wheels.step(velocity=(20.0, 0.0, 0.0, 0.0, 20.0 / 0.46, 0.0))
    for result in (start, step, step.patches[0], mtb.hertz(1e3, 0.1)):
        found = result.to_xarray()
        assert set(found.data_vars) == set(result.fields()) - {"points"}
    lifted = wheels.step(pose=(0.0, 0.0, 1e-3, 0.0, 0.0, 0.0), velocity=20.0)
    for door in (lifted.to_xarray, lifted.to_pyvista):
        with pytest.raises(ValueError, match="lifted"):
            door()


def test_quantities_within_arrays_and_tables_keep_their_unit() -> None:
    pint = pytest.importorskip("pint", reason="pint is not installed")
    ureg = pint.UnitRegistry()
    milli = ureg.Quantity(1e3 * GAP, "mm")
    mixed = np.array(
        [[ureg.Quantity(1e3 * v, "mm") if v > 1e-4 else v for v in row] for row in GAP], dtype=object
    )
    for given in (
        xarray.DataArray(milli, dims=("y", "x")),
        xarray.DataArray(milli.T, {"x": X, "y": Y}, ("x", "y")),
        mixed,
        pandas.DataFrame(mixed),
    ):
        np.testing.assert_allclose(scene(gap=given).gap, GAP, rtol=1e-15)
    speeds = [ureg.Quantity(36.0, "km/h"), ureg.Quantity(20.0, "m/s")]
    for column in (pandas.Series(speeds), np.array(speeds, dtype=object)):
        assert mtb.VelocityTable(column, [0.3, 0.2]).velocity == pytest.approx((10.0, 20.0))
    with pytest.raises(ValueError, match=r"velocity\[1\] is 20.0 kilogram: a quantity in m/s"):
        mtb.VelocityTable(pandas.Series([*speeds[:1], ureg.Quantity(20.0, "kg")]), [0.3, 0.2])
    with pytest.raises(ValueError, match=r"gap is .*: a quantity in m"):
        scene(gap=xarray.DataArray(ureg.Quantity(GAP, "kg"), dims=("y", "x")))


def test_places_that_are_no_numbers_are_refused() -> None:
    with pytest.raises(ValueError, match="gap has x = nan: finite coordinates in m are needed"):
        scene(gap=xarray.DataArray(GAP, {"x": np.where(X == 0.0, np.nan, X), "y": Y}, ("y", "x")))


def test_columns_of_creepages_count_by_their_names() -> None:
    patch, law = mtb.hertz(5e3, 0.4).on_grid((14, 14), 4e-4), mtb.Coulomb(0.3)
    rows = np.array([[1e-4, 2e-4, 0.2], [3e-4, 0.0, -0.1]])
    named = pandas.DataFrame(rows, columns=["xi", "eta", "phi"])
    expected = mtb.creep_curve(patch, rows, law)
    for given in (named, named[["phi", "xi", "eta"]], pandas.DataFrame(rows)):
        np.testing.assert_array_equal(mtb.creep_curve(patch, given, law), expected)
        np.testing.assert_array_equal(
            mtb.fastsim_curve(patch, given, law), mtb.fastsim_curve(patch, rows, law)
        )
    assert mtb.Rolling(creepage=named[["phi", "xi", "eta"]].iloc[0]).creepage == tuple(rows[0])
    for wrong in (named.rename(columns={"phi": "spin"}), named[["xi", "eta"]], named.assign(case=1)):
        with pytest.raises(
            ValueError, match=r"creepages has the columns .*: xi, eta, phi are needed, in any order"
        ):
            mtb.creep_curve(patch, wrong, law)


def test_an_area_load_curve_is_a_table() -> None:
    heights = 1e-7 * np.cos(np.arange(16.0))[:, None] * np.cos(np.arange(16.0)) + 1e-7
    curve = mtb.area_load_curve(heights, 1e-6, [2e-3, 1e-3], lower=mtb.steel, upper=mtb.Rigid())
    frame, labelled = curve.to_pandas(), curve.to_xarray()
    assert frame.attrs["units"] == {"force": "N", "contact_area": "m^2", "approach": "m", "mean_gap": "m"}
    for name, values in curve._asdict().items():
        np.testing.assert_array_equal(frame[name], values)
        np.testing.assert_array_equal(labelled[name], values)
        assert labelled[name].attrs == {"units": frame.attrs["units"][name]}
    exported = curve.exports()[0]["csv"].decode().splitlines()[0]
    assert exported == ",".join(f"{name} [{unit}]" for name, unit in frame.attrs["units"].items())
    told = dict(curve.told())
    assert told["force"] == "1 to 2 mN"
    assert told["approach"].endswith((" nm", " \N{MICRO SIGN}m"))

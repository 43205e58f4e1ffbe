# SPDX-License-Identifier: MIT OR Apache-2.0
"""Friction and magnetic pressure tabulated over x and y: read, interpolated, refused beyond their reach."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

X = np.array([-0.1, -0.04, 0.01, 0.05, 0.12])
Y = np.array([-0.05, 0.0, 0.02, 0.06])


def bilinear(x: Any, y: Any) -> Any:
    """Friction that a bilinear interpolation gives back."""
    return 0.3 + x + 2.0 * y + 5.0 * x * y


def pull(x: Any, y: Any) -> Any:
    """The same of a magnetic pressure [Pa]."""
    return 1e7 * bilinear(x, y)


def table(function: Callable[..., Any] = bilinear) -> mtb.FieldTable:
    return mtb.FieldTable(X, Y, function(X[None, :], Y[:, None]))


def block(**given: Any) -> mtb.Scene:
    return mtb.scenes.block_on_plane(**{"spacing": 12e-3} | given)


def shoe(**given: Any) -> mtb.Scene:
    return mtb.scenes.pole_shoe_on_rail(**{"spacing": 9e-3, "friction": 0.1} | given)


def own(**given: Any) -> mtb.Scene:
    base = block().solve("elastic-upper").parts[0].body
    return mtb.Scene(upper=base, lower=mtb.steel, **{"spacing": 12e-3, "force": 1e3, "friction": 0.1} | given)


def written(
    path: Path, rows: list[tuple[float, float, float]], heading: str = "x [mm],y [mm],p [MPa]"
) -> Path:
    lines = [",".join(map(str, row)) for row in rows]
    path.write_text("\n".join([heading, *lines]) + "\n", encoding="utf-8")
    return path


def rows() -> list[tuple[float, float, float]]:
    return [(1e3 * x, 1e3 * y, 1e-6 * pull(x, y)) for y in Y for x in X]


@pytest.mark.coarse
@pytest.mark.parametrize("make", [block, shoe, own])
@pytest.mark.parametrize("name", ["friction", "magnetic_pressure"])
def test_a_bilinear_field_is_the_function_it_tabulates(make: Callable[..., mtb.Scene], name: str) -> None:
    function = bilinear if name == "friction" else pull
    given: dict[str, Any] = {"friction": 0.1}
    if make is own and name == "magnetic_pressure":
        given["force"] = None
    model = "auto" if make is own else "elastic-upper"
    forms = (table(function), function, float(function(0.0, 0.0)))
    results = [make(**given | {name: form}).solve(model, tolerance=0.99) for form in forms]
    found, expected, flat = ([r.pressure, r.traction] for r in results)
    for k in (0, 1):
        np.testing.assert_allclose(found[k], expected[k], rtol=1e-8, atol=1e-8 * expected[k].max())
    assert abs(found[1] - flat[1]).max() > 0.01 * flat[1].max()


def test_fields_stand_wherever_fields_do(tmp_path: Path) -> None:
    hill = table(pull)
    alone = shoe(magnetic_pressure=hill).solve("half-space").force
    for form in (
        [hill, hill],
        mtb.VelocityTable([0.0, 10.0], [hill, 0.0]),
        mtb.VelocityTable([0.0, 10.0], [[hill, hill], 1e6]),
        pickle.loads(pickle.dumps(hill)),
    ):
        found = shoe(magnetic_pressure=form, velocity=0.0).solve("half-space").force
        np.testing.assert_allclose(found, alone, rtol=1e-12)
    result = shoe(magnetic_pressure=hill).solve("half-space")
    result.save(tmp_path / "saved")
    np.testing.assert_array_equal(mtb.load(tmp_path / "saved").force, result.force)
    contact = shoe(magnetic_pressure=hill, velocity=1.0).prepare("half-space")
    given = contact.copy().step(velocity=1.0, magnetic_pressure=hill).force
    np.testing.assert_allclose(contact.step(velocity=1.0).force, given, rtol=1e-9)
    # narrower cells read the table anew
    fine = shoe(magnetic_pressure=hill).on_cells((5e-3, 5e-3)).solve("half-space").force
    np.testing.assert_array_equal(fine, shoe(magnetic_pressure=hill, spacing=5e-3).solve("half-space").force)


def test_files_are_read_in_any_order_of_rows_and_columns(tmp_path: Path) -> None:
    expected = table(pull)
    mixed = [rows()[k] for k in np.random.default_rng(3).permutation(len(rows()))]
    for path in (
        written(tmp_path / "a.csv", rows()),
        written(tmp_path / "b.csv", mixed),
        written(tmp_path / "c.csv", [(p, y, x) for x, y, p in mixed], "pressure (MPa),y (mm),x (mm)"),
        written(tmp_path / "d.csv", [(x / 1e3, y / 1e3, p * 1e6) for x, y, p in mixed], "x,y,p"),
    ):
        found = mtb.FieldTable.from_file(path)
        for axis in ("x", "y", "value"):
            np.testing.assert_allclose(getattr(found, axis), getattr(expected, axis), rtol=1e-12, atol=1e-15)


def test_case_files_take_fields(tmp_path: Path) -> None:
    written(tmp_path / "pull.csv", rows())
    found = mtb.FieldTable.from_file(tmp_path / "pull.csv")
    inline = f"{{x = {found.x.tolist()}, y = {found.y.tolist()}, value = {found.value.tolist()}}}"
    for given in ('{file = "pull.csv"}', inline):
        text = f'scene = "pole_shoe_on_rail"\nmagnetic_pressure = {given}\n'
        (tmp_path / "case.toml").write_text(text, encoding="utf-8")
        case = mtb.load_case(tmp_path / "case.toml")
        assert case.magnetic_pressure == found  # type: ignore[attr-defined]
        assert case.expected_cost().costs


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda r: r[:7] + r[8:], r"has no row for x = 10 mm, y = 0 mm: a row for each of the 5 x 4 places"),
        (lambda r: [*r, r[2]], r"line 22 of the file: x = 10 mm, y = -50 mm stands in line 4 too"),
        (lambda r: r[:5], "has 5 places along x and 1 along y: at least two"),
        (lambda r: [], "has 0 places along x"),
        (lambda r: [*r, ("a", 1, 2)], "line 22 of the file: .*not three finite numbers, x, y and value"),
    ],
)
def test_files_that_are_no_grid_name_the_place(tmp_path: Path, change: Any, message: str) -> None:
    path = written(tmp_path / "p.csv", change(rows()))
    with pytest.raises(ValueError, match=rf"p\.csv.* ?{message}"):
        mtb.FieldTable.from_file(path)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"x": X[::-1]}, r"x\[1\] of a field is 0.05 m after 0.12 m: places that rise"),
        ({"y": [0.0, 0.0, 0.1, 0.2]}, r"y\[1\] of a field is 0 m after 0 m"),
        ({"x": [0.0]}, r"x of a field has shape \(1,\)"),
        ({"value": np.ones((5, 4))}, r"shape \(5, 4\): \(ny, nx\) = \(4, 5\)"),
        ({"value": np.full((4, 5), np.nan)}, "is nan"),
    ],
)
def test_tables_that_are_no_field_are_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        mtb.FieldTable(**{"x": X, "y": Y, "value": np.ones((4, 5))} | given)


def test_a_table_that_ends_before_the_sole_names_the_point_and_the_range(tmp_path: Path) -> None:
    path = written(tmp_path / "p.csv", [row for row in rows() if row[0] > -50.0])
    short = mtb.FieldTable.from_file(path)
    message = (
        r"magnetic_pressure\[?.* is needed at x = -0.0\d+ m, y = .* m, outside of table .*p\.csv, which "
        r"covers x from -0.04 to 0.12 m and y from -0.05 to 0.06 m: the contact points reach x from -0.0\d+ "
        r"to 0.0\d+ m"
    )
    for model in ("half-space", "elastic-upper"):
        with pytest.raises(ValueError, match=message):
            shoe(magnetic_pressure=short).solve(model)
    with pytest.raises(ValueError, match=message):
        shoe(magnetic_pressure=short).expected_cost("half-space")


def test_friction_out_of_range_is_named_with_its_line(tmp_path: Path) -> None:
    places = [(x, y, -0.2 if (x, y) == (10.0, 20.0) else 0.3) for x, y, _ in rows()]
    path = written(tmp_path / "mu.csv", places, "x [mm],y [mm],mu [-]")
    message = (
        r"friction at x = 0.01 m, y = 0.02 m \(table .*mu\.csv, line 14 of the file\) is -0.2: numbers from 0"
    )
    with pytest.raises(ValueError, match=message):
        block(friction=mtb.FieldTable.from_file(path)).solve("half-space")
    (tmp_path / "case.toml").write_text('scene = "block_on_plane"\nfriction = {file = "mu.csv"}\n')
    with pytest.raises(mtb.CaseError, match=message):
        mtb.load_case(tmp_path / "case.toml").expected_cost()
    (tmp_path / "mu.csv").write_text("v,mu\n0,0.3\n20,-0.1\n", encoding="utf-8")
    message = r"friction at 20 m/s \(table .*mu\.csv, line 3 of the file\) is -0.1"
    with pytest.raises(ValueError, match=message):
        block(friction=mtb.VelocityTable.from_file(tmp_path / "mu.csv"), velocity=15.0).solve("half-space")
    with pytest.raises(mtb.CaseError, match=message):
        mtb.load_case(tmp_path / "case.toml").expected_cost()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("v [km/h],mu\n20,0.3\n10,0.35\n", r"line 3 of the file: the velocity is 10 km/h after 20 km/h"),
        ("v,mu\n# wet\n1,0.3\n1,0.35\n", r"line 4 of the file: the velocity is 1 m/s after 1 m/s"),
        ("v,mu\n1,0.3\n", r"has one row of numbers"),
        ("", r"has no row of numbers"),
        ("v,mu\n0,30%\n", r"line 2 of the file: .*belongs to the heading"),
    ],
)
def test_velocity_tables_name_file_line_and_own_units(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "t.csv").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=rf"t\.csv,? {message}"):
        mtb.VelocityTable.from_file(tmp_path / "t.csv")


@pytest.mark.parametrize(
    ("unit", "factor"),
    [("%", 1e-2), ("percent", 1e-2), ("‰", 1e-3), ("-", 1.0), ("N/mm^2", 1e6), ("kPa", 1e3)],
)
def test_units_of_tables_count(tmp_path: Path, unit: str, factor: float) -> None:
    (tmp_path / "v.csv").write_text(f"velocity [km/h],value [{unit}]\n0,35\n36,10\n", encoding="utf-8")
    assert mtb.VelocityTable.from_file(tmp_path / "v.csv").value == pytest.approx((35 * factor, 10 * factor))
    path = written(tmp_path / "f.csv", rows(), f"x [mm],y [mm],value [{unit}]")
    expected = [[factor * row[2] for row in rows()]]
    np.testing.assert_allclose(mtb.FieldTable.from_file(path).value.reshape(1, -1), expected)


def test_functions_that_fail_somewhere_name_the_point() -> None:
    reach = r"x from -0.0\d+ to 0.0\d+ m and y from -0.0\d+ to 0.0\d+ m"

    def raising(x: Any, y: Any) -> Any:
        if (x > 0.02).any():
            raise ValueError("out of bounds in dimension 1")
        return 1e6 + 0.0 * x

    with pytest.raises(
        ValueError, match=rf"ValueError at x = 0.0[234].* m, y = .*dimension 1; .*{reach}"
    ) as caught:
        block(magnetic_pressure=raising).solve("half-space")
    assert str(caught.value.__cause__) == "out of bounds in dimension 1"
    with pytest.raises(ValueError, match=rf"is nan: finite .* at x = 0.0[234].* m, y = .*{reach}"):
        block(magnetic_pressure=lambda x, y: np.where(x > 0.02, np.nan, 1e6)).solve("half-space")
    with pytest.raises(ValueError, match=r"friction is -0.0\d+ at x = 0.0\d+ m, y = "):
        block(friction=lambda x, y: -x).solve("half-space")
    # a function that fails everywhere is not about a place
    with pytest.raises(ValueError, match=r"fails with TypeError: .* given; a"):
        block(friction=lambda x: 0.3).solve("half-space")


@pytest.mark.parametrize(
    "far",
    [
        mtb.GaussianPressure(3e6, (20.0, 13.8), (40e-3, 8e-3)),
        mtb.GaussianPressure(3e6, (20.0, 13.8), (40.0, 8.0)),
        mtb.GaussianPressure(3e6, (20e-3, 0.1), (40e-3, 8e-3)),
    ],
)
def test_a_hill_beside_the_contact_is_asked_for(far: mtb.GaussianPressure) -> None:
    for form in (far, mtb.VelocityTable([0.0, 1.0], [far, far]), [far, 1e6]):
        scene = shoe(magnetic_pressure=form, velocity=0.5)
        with pytest.warns(UserWarning, match="far outside of the contact"):
            scene.solve("half-space")
        with pytest.warns(UserWarning, match="far outside of the contact"):
            scene.expected_cost("half-space")
        with pytest.warns(UserWarning, match="far outside of the contact"):
            scene.prepare("half-space")


def test_a_table_in_millimetres_is_asked_for() -> None:
    wide = mtb.FieldTable(1e3 * X, 1e3 * Y, np.full((4, 5), 1e6))
    with pytest.warns(UserWarning, match=r"tabulated from [xy] = .* lengths are in metres"):
        shoe(magnetic_pressure=wide).solve("half-space")


def test_arrays_of_xarray_are_fields_by_their_coordinates() -> None:
    xarray = pytest.importorskip("xarray", reason="xarray (extra sweep) is not installed")
    given = xarray.DataArray(bilinear(X[None, :], Y[:, None]), {"y": Y, "x": X}, ("y", "x"))
    for array in (given, given.T):
        assert mtb.FieldTable(array.x, array.y, array) == table()
        assert mtb.FieldTable(x=array.x, y=array.y, value=array) == table()
    with pytest.raises(ValueError, match="coordinates x that are not the x given"):
        mtb.FieldTable(X + 0.01, Y, given)
    falling = given[:, ::-1]
    with pytest.raises(ValueError, match="coordinates x that are not the x given, rising"):
        mtb.FieldTable(falling.x, falling.y, falling)
    ordered = falling.sortby("x")
    assert mtb.FieldTable(ordered.x, ordered.y, ordered) == table()

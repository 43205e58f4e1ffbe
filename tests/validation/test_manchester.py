# SPDX-License-Identifier: MIT OR Apache-2.0
"""The Manchester benchmark A-2.2 (benches/manchester.py): what follows from each shift, beside CONTACT."""

import csv
import sys
from functools import cache
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
# the flange is pressed harder than rail steel bears
pytestmark = pytest.mark.filterwarnings("ignore:the peak pressure is")


@pytest.fixture
def bench(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "benches"))
    module = import_module("manchester")
    for name in ("manchester", "records"):
        monkeypatch.delitem(sys.modules, name)
    return module


@cache
def table():
    with (ROOT / "docs" / "charts" / "manchester.csv").open(encoding="utf-8") as file:
        text = list(csv.DictReader(file))
    return [{k: v if k == "side" else float(v) for k, v in row.items()} for row in text]


def test_the_page_has_all_positions(bench):
    found = [(row["side"], row["y_mm"]) for row in table()]
    assert found == [(side, shift) for shift in bench.SHIFTS for side in ("left", "right")]
    assert all(row["Fz_N"] == pytest.approx(10e3, rel=1e-8) for row in table())


def test_positions_are_those_of_contact(bench):
    """Roll and rotation, which CONTACT was given, follow from balance here."""
    known = bench.printed()
    assert len(known) == 7
    rows = {(row["side"], row["y_mm"]): row for row in table()}
    for (side, shift), there in known.items():
        row = rows[side, shift]
        assert row["roll_mrad"] == pytest.approx(there["roll_mrad"], rel=1.5e-3, abs=1e-9)
        assert row["omega_rad_s"] == pytest.approx(there["omega_rad_s"], rel=5e-6)
        assert row["Fn_N"] == pytest.approx(there["Fn_N"], rel=5e-3)
        assert row["pmax_MPa"] == pytest.approx(there["pmax_MPa"], rel=5e-3)
        assert row["y_contact_mm"] == pytest.approx(there["y_contact_mm"], abs=0.1)
        assert row["angle_rad"] == pytest.approx(there["angle_rad"], abs=1e-3)
        assert row["cksi"] == pytest.approx(there["cksi"], rel=2e-3, abs=5e-6)
        assert row["ceta"] == pytest.approx(there["ceta"], rel=2e-3)
        assert row["cphi_1_m"] == pytest.approx(there["cphi_1_m"], rel=2e-3, abs=5e-5)
        # the centred wheels are driven by nothing but what the rotation, given to eight digits, leaves over
        for name in ("Fx_N", "Fy_N"):
            assert row[name] == pytest.approx(there[name], rel=5e-3, abs=0.05)


@pytest.mark.parametrize("shift", [0.5, 6.5])
def test_the_table_is_what_the_wheels_do(bench, shift):
    step, omega = bench.rolling(bench.prepared(), shift)
    for patch in step.patches:
        (row,) = [r for r in table() if (r["side"], r["y_mm"]) == (patch.side, shift)]
        assert -omega == pytest.approx(row["omega_rad_s"], rel=1e-8)
        assert abs(patch.position[1]) / bench.MM == pytest.approx(row["y_contact_mm"], abs=1e-3)
        assert patch.normal_force == pytest.approx(row["Fn_N"], rel=1e-6)
        assert patch.force[0] == pytest.approx(row["Fx_N"], abs=0.05)
        assert step.vertical_force[patch.side] == pytest.approx(bench.FORCE, rel=1e-8)
    # free: the creep forces do not drive the wheelset
    roll, yaw = step.pose[3], step.pose[5]
    axle = np.array([-np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll)])
    assert abs(step.moment @ axle) < 1e-5 * bench.FORCE * bench.RADIUS

# SPDX-License-Identifier: MIT OR Apache-2.0
"""Whole wheels, yawed, rolled and given their total force, against CONTACT (tests/data/contact).

CONTACT's track has y to the right and z down, so y, z and yaw change sign; its creepage cksi is of the rail
over the wheel.
"""

from __future__ import annotations

import csv
from functools import lru_cache
from itertools import groupby
from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb

DATA = Path(__file__).parents[1] / "data" / "contact"
# the flange of one case is pressed harder than rail steel bears
pytestmark = pytest.mark.filterwarnings("ignore:the peak pressure is")

MM = 1e-3
SPEED, FRICTION = 2.0, 0.3
#: CONTACT's height of the wheelset where the centred wheel just touches [mm], down
TOUCHING = 0.1821


def table():
    with (DATA / "whole_wheels.csv").open() as file:
        rows = list(csv.DictReader(file))
    return {name: list(group) for name, group in groupby(rows, key=lambda row: row["case"])}


CASES = table()


def profile(name, sign):
    y, z = np.loadtxt(DATA / name, delimiter=",", unpack=True)
    y = sign * y
    # the foot of the rail's face stands upright: a place that comes twice counts once
    forward = np.concatenate([[True], np.diff(np.maximum.accumulate(y)) > 0.0])
    return mtb.Profile.from_points(y[forward] * MM, -z[forward] * MM)


@lru_cache
def wheels(force, spacing, cant, side):
    material = mtb.Material(2 * 82e9 * 1.28, 0.28)
    scene = mtb.scenes.wheel_on_rail(
        wheel=profile("manchester_s1002.csv.gz", -1.0),
        rail=profile("manchester_uic60.csv.gz", 1.0),
        rail_inclination=cant,
        lateral=0.0,
        force=force,
        spacing=spacing,
        upper=material,
        lower=material,
    )
    return scene.prepare(side=side, friction=mtb.Coulomb(FRICTION))


def of(row, *names):
    return [float(row[name]) for name in names]


@lru_cache
def solved(name):
    """The step at the height that CONTACT was given, or that carries its force, friction included."""
    row = CASES[name][0]
    wanted = float(row["FZ_N"] or 10e3)
    contact = wheels(wanted, float(row["dx_mm"]) * MM, float(row["cant_rad"]), row["side"])
    y, yaw, roll, omega = of(row, "y_mm", "yaw_rad", "roll_rad", "omega_rad_s")
    yaw, omega = -yaw, -omega
    axle = np.array([-np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll)])
    velocity = [SPEED, 0.0, 0.0, *(omega * axle)]

    z = (TOUCHING - float(row["z_mm"])) * MM if row["z_mm"] else np.nan
    step = contact.step([0.0, -y * MM, z, roll, 0.0, yaw], velocity)
    if not row["z_mm"]:
        assert step.vertical_force[row["side"]] == pytest.approx(wanted, rel=1e-8)
    return step


def pairs(name):
    """Patches with the rows they belong to, from the tread to the flange."""
    patches = sorted(solved(name).patches, key=lambda patch: patch.contact_angle)
    assert len(patches) == len(CASES[name])
    return list(zip(patches, CASES[name], strict=True))


@pytest.mark.parametrize("name", CASES)
def test_contacts_lie_where_contact_has_them(name):
    """Also where an overlap is 20 mm wide or double: its middle is weighted as CONTACT's is."""
    for patch, row in pairs(name):
        y, angle = of(row, "y_contact_mm", "angle_rad")
        assert patch.position[1] / MM == pytest.approx(-y, abs=0.01)
        assert patch.contact_angle == pytest.approx(angle, abs=2e-4)


@pytest.mark.parametrize("name", CASES)
def test_creepages_are_those_of_contact(name):
    for patch, row in pairs(name):
        xi, eta, phi = patch.creepage
        assert xi == pytest.approx(-float(row["cksi"]), rel=2e-3, abs=6e-6)
        assert eta == pytest.approx(float(row["ceta"]), rel=2e-3, abs=1e-6)
        assert phi == pytest.approx(float(row["cphi_1_m"]), rel=2e-3, abs=2e-4)


def test_the_rotation_of_a_given_force_is_that_of_contact():
    """CONTACT was given the force along the track, and printed the rotation."""
    row = CASES["given_FX"][0]
    contact = wheels(float(row["FZ_N"]), float(row["dx_mm"]) * MM, 0.0, "right")
    y, yaw, roll, omega = of(row, "y_mm", "yaw_rad", "roll_rad", "omega_rad_s")
    pose = [0.0, -y * MM, np.nan, roll, 0.0, -yaw]
    step = contact.step(pose, SPEED, longitudinal_force=2000.0)
    assert step.force[0] == pytest.approx(2000.0, abs=1e-8 * float(row["FZ_N"]))
    # 0.35 % of the coefficient of friction times the load in the force is 1.4e-5 in the creepage
    assert step.velocity[4] == pytest.approx(-omega, rel=1.5e-5)
    assert step.patches[0].creepage[0] == pytest.approx(-float(row["cksi"]), abs=1.5e-5)


@pytest.mark.parametrize("name", CASES)
def test_forces_are_those_of_contact(name):
    step = solved(name)
    total = sum(float(row["FN_N"]) for row in CASES[name])
    # CONTACT lets two patches that are solved together press each other apart
    normal, tangential = (2.5e-2, 1.5e-2) if len(CASES[name]) > 1 else (2e-3, 7e-3)
    for patch, row in pairs(name):
        force, peak = of(row, "FN_N", "pmax_MPa")
        assert patch.normal_force == pytest.approx(force, rel=normal)
        assert patch.pressure.max() / 1e6 == pytest.approx(peak, rel=1e-2)
        if row["approach_mm"]:
            assert patch.approach / MM == pytest.approx(float(row["approach_mm"]), rel=1e-2, abs=1e-4)
    first = CASES[name][0]
    assert step.force[0] == pytest.approx(float(first["FX_track_N"]), abs=tangential * FRICTION * total)
    assert -step.force[1] == pytest.approx(
        float(first["FY_track_N"]), rel=2e-3, abs=tangential * FRICTION * total
    )

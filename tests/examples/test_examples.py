# SPDX-License-Identifier: MIT OR Apache-2.0
"""Every example runs, and a number of each is what it must be."""

from __future__ import annotations

import os
import pickle
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

pytestmark = pytest.mark.slow  # runs every example in a process of its own

EXAMPLES = Path(__file__).parents[2] / "examples"


def hertz(names: dict[str, Any]) -> None:
    coarse, _, fine = names["errors"]
    assert fine < 0.01
    assert coarse / fine > 3.0  # first order at least, over two halvings


def brake_force_over_velocity(names: dict[str, Any]) -> None:
    assert names["right"] == pytest.approx(0.8 * names["left"], rel=1e-12)
    # the loads are as the magnetic pressures at 2.5 and 40 m/s, the friction as its table says
    slow, fast = names["brake_force"][2.5], names["brake_force"][40.0]
    assert slow / fast == pytest.approx(0.275 / 0.1125 * 2.95 / 2.12, rel=1e-3)
    # pressure stands aslant on a rail whose sides slope by up to a quarter
    for velocity, product in names["product"].items():
        assert 1.003 < names["brake_force"][velocity] / product < 1.008


def heat_of_a_stop(names: dict[str, Any]) -> None:
    heat = names["heat"]
    assert names["balance"] == pytest.approx(1.0, abs=1e-10)
    # the hottest point has more than the mean pressure
    assert 1.0 < heat.peaks[0] / names["closed_form"] < 1.4
    assert heat.heats_upper[20] < 0.02 * heat.friction_powers[20]


def a_stop_with_heat_and_wear(names: dict[str, Any]) -> None:
    stop = names["stop"]
    assert abs(stop.open_energy) < 1e-7
    assert stop.way[-1] == pytest.approx(names["cold"].way[-1], rel=0.02)
    # worn as Archard has it: the coefficient times the load times the way
    one = stop.shoes[1]
    ways = stop.way[1:] - stop.way[:-1]
    assert one.volumes_upper[-1] == pytest.approx(1e-13 * (abs(one.forces[:, 2]) * ways).sum(), rel=0.03)


def a_year_of_stops(names: dict[str, Any]) -> None:
    inner, outer = names["inner"], names["outer"]
    assert inner.solves.sum() < 10
    assert inner.errors.max() < 0.05
    # on a curved rail the load along the normals is a little more than the vertical one
    assert names["volume"] == pytest.approx(1e-15 * names["load"], rel=0.01)
    # an outer shoe lasts as much longer as it is pulled less
    assert names["life"][1] / names["life"][0] == pytest.approx(0.85, rel=0.01)
    assert outer.worn_volume[0, -1] == pytest.approx(0.85 * inner.worn_volume[0, -1], rel=0.01)


def braking_manoeuvre(names: dict[str, Any]) -> None:
    *rides, table = names["comparison"]
    # where the kinetic energy went: friction, other brakes, dampers, springs
    assert max(abs(row["open_energy"]) for row in rides) < 2e-4
    for error in ("way_error", "brake_force_error", "peak_pressure_error"):
        coarse, fine, _ = (abs(row[error]) for row in rides)
        assert fine < 0.6 * coarse
        assert fine < 1e-4
    # a table has the force; its shoe is driven at the top, so it pitches, and presses, otherwise
    assert table["brake_force_error"] < 2e-3
    assert table["peak_pressure_error"] > 1e-2


def carter_rolling(names: dict[str, Any]) -> None:
    for errors in names["errors"].values():
        assert errors[-1] < 1e-3
        assert errors[0] / errors[-1] > 25.0  # first order over five halvings


def cattaneo_mindlin(names: dict[str, Any]) -> None:
    assert max(names["error"]) < 0.02
    assert max(names["shift_error"]) < 1e-3


def magnet_snapping_on(names: dict[str, Any]) -> None:
    """Iron takes so little at the distance of snapping on that the closed form without it is near."""
    assert names["snap"] == pytest.approx(names["plain"], rel=0.02)
    assert names["plain"] == pytest.approx(9.90e-3, abs=1e-4)


def worn_soles(names: dict[str, Any]) -> None:
    peaks = names["peaks"]
    # worn in on its own rail a sole presses about as evenly as the assumed one
    assert peaks["worn in on the new rail"] < 1.1 * peaks["assumed"]
    assert peaks["worn in on the worn rail"] > 1.3 * peaks["worn in on the new rail"]


def cattaneo_to_carter(names: dict[str, Any]) -> None:
    creepage = names["creepage"]
    assert creepage[-1] == pytest.approx(names["steady"].creepage[0], rel=1e-3)
    assert creepage[0] < 0.6 * creepage[-1]


def europrinter_traction_curve(names: dict[str, Any]) -> None:
    # CONTACT gives 1.036 and 3.76 for the two readings of the layer
    assert names["reduction"]["as printed"] == pytest.approx(1.036, abs=0.002)
    assert names["reduction"]["100 times softer"] == pytest.approx(3.76, abs=0.02)
    for share in (0.3, 0.6, 0.85):
        assert names["slip_share"]["with the soft layer", share] < names["slip_share"]["original", share]


def creep_forces_with_spin(names: dict[str, Any]) -> None:
    # the layer takes most of the lateral force of spin away
    assert names["lateral"]["layer, falling friction"] < 0.4 * names["lateral"]["original, Coulomb"]


def start_of_sliding(names: dict[str, Any]) -> None:
    assert names["gross"]["with a soft layer"] == names["gross"]["steel on steel"]
    for name, force in names["last"].items():
        assert force == pytest.approx(names["gross"][name], rel=1e-3)
    slides, jams = names["friction_force"][0.2], names["friction_force"][0.5]
    assert slides[-1] == pytest.approx(0.2 * names["normal_force"][0.2][-1], rel=1e-6)
    assert slides[-1] == pytest.approx(slides[-8], rel=1e-3)
    assert jams[-1] > 1.3 * jams[-10]


def break_away_of_a_pole_shoe(names: dict[str, Any]) -> None:
    # all of it slides at last, the loop is closed, and its area is heat
    assert names["forward"][-1, 1] == pytest.approx(names["gross"], rel=1e-3)
    again = np.array(names["history"]["forward again"])
    assert again[-1, 1] == pytest.approx(names["forward"][-1, 1], rel=1e-3)
    assert list(names["share"]) == sorted(names["share"], reverse=True)
    assert 0.0 < names["area"] < names["heat"]


def stick_slip_of_a_shoe_on_its_links(names: dict[str, Any]) -> None:
    # the cycle of the closed form, and growth by the eigenvalue before
    assert names["periods"][0] == pytest.approx(names["periods"][1], rel=5e-3)
    assert names["sizes"][0] == pytest.approx(names["sizes"][1], rel=1e-2)
    assert names["found"].critical_friction == pytest.approx(0.3, rel=0.05)
    slowest = names["way"][-15 * names["STEPS"] :, 2].min() / names["SPEED"]
    # it rings on the contact while it sticks
    assert slowest == pytest.approx(-1.0, abs=0.1)


def braking_to_rest(names: dict[str, Any]) -> None:
    assert names["stop"] == pytest.approx(names["MASS"] * names["SPEED"] / names["friction"], rel=0.02)
    assert names["balance"] < 1e-8
    # it stands: it swings about rest, and no more than sliding friction can drive it
    late = names["time"] > names["stop"] + 5e-3
    assert abs(names["velocity"][late].mean()) < 0.02 * names["SPEED"]
    assert np.abs(names["force"]).max() < 1.01 * names["friction"]


def falling_friction_instability(names: dict[str, Any]) -> None:
    assert names["collapse"]["coarse grid, fast fall, no memory"] > 0.02
    assert names["collapse"]["fine grid, fast fall, memory 100 µm"] < 1e-3
    assert names["collapse"]["coarse grid, slow fall, no memory"] < 1e-3
    assert names["not_found"]["half-space"] == 0
    assert names["not_found"]["layer"] > 0


def pictures_of_a_result(names: dict[str, Any]) -> None:
    # the rear comes free as friction grows
    shares = names["open_share"]
    assert shares[0] == 0.0
    assert shares == sorted(shares)
    assert shares[-1] > 0.1
    drawn = {path.suffix for path in Path.cwd().iterdir()}
    assert drawn == {".png", ".gif"}


def pole_shoe_design(names: dict[str, Any]) -> None:
    # the balance of moments about y, where friction has a lever
    assert names["worst"] < 5e-3
    assert names["brake_force"] == pytest.approx(names["needed"], rel=8e-3)
    best, aside, heights = names["best"], names["aside"], names["heights"]
    for height, (pressure, friction) in names["best_rigid"].items():
        # edges make up a third of the most loaded tenth of an elastic shoe, and its front gives way
        found, chosen = best[aside[0], height]
        assert 1.0 < found / pressure < 1.5
        assert friction - 0.05 < chosen < 1.35 * friction
        # a gap costs pressure, the more the wider it is
        by_gap = [best[shift, height][0] for shift in aside]
        assert by_gap == sorted(by_gap)
        assert by_gap[-1] > 1.2 * by_gap[0]
    # a taller shoe presses more and wants less friction, whatever its gap
    for shift in aside:
        by_height = [best[shift, height] for height in heights]
        assert by_height == sorted(by_height)
        frictions = [friction for _, friction in by_height]
        assert frictions == sorted(frictions, reverse=True)
        assert frictions[0] > frictions[-1]
    # inside of what was tried, and surer than the step to its neighbours of other heights and gaps
    shift, height, friction = names["every"][names["chosen"]]
    assert names["frictions"][0] < friction < names["frictions"][-1]
    assert all(names["every"][k][:2] == (shift, height) for k in names["even"])
    assert len(names["even"]) < len(names["near"]) - 1


def flutter_of_a_pole_shoe(names: dict[str, Any]) -> None:
    border = np.array([one.critical_friction for one in names["found"]])
    least = int(border.argmin())
    assert np.all(np.diff(border[: least + 1]) < 0.0)
    assert np.all(np.diff(border[least:]) > 0.0)
    # least where two vibrations have the same frequency without friction
    apart = [np.diff(np.unique(one.frequencies[0].clip(0.0)))[-1] for one in names["found"]]
    assert abs(int(np.argmin(apart)) - least) <= 1
    assert border[least] < 0.15 < 0.5 < border[0]
    assert names["worst"].kind == "flutter"


def measured_wheelset(names: dict[str, Any]) -> None:
    conicity, peak = names["conicity"], names["peak"]
    assert conicity["exact"] == pytest.approx(0.174, abs=1e-3)
    # noise moves the contact, and hardly the radii
    assert conicity["smoothed"] == pytest.approx(conicity["exact"], rel=0.02)
    assert peak["measured"] > 1.5 * peak["exact"]
    assert peak["smoothed"] == pytest.approx(peak["exact"], rel=0.05)


def lateral_jolt_of_a_wheelset(names: dict[str, Any]) -> None:
    transient, steady, x = *(np.array(names["lateral"][k]) for k in ("transient", "steady")), names["x"]
    # before the jolt both roll straight; no force is asked for beyond friction
    assert np.abs(transient[x < 0.0]).max() < 1.0
    assert max(transient.max(), steady.max()) < 2 * 0.3 * 60e3
    # the steady force ends with the push, what is left of the transient one fades over each patch
    after = x > names["jolt"] + 0.5e-3
    assert np.abs(steady[after]).max() < 50.0
    assert transient[after][0] > 0.2 * transient.max()
    falls = np.log(transient[after][10] / transient[after][30]) / 10e-3
    assert 1.0 / falls == pytest.approx(names["length"], rel=0.6)
    assert names["later"] > 0.0


def bogie_on_a_track(names: dict[str, Any]) -> None:
    # rolling contacts of real wheels, with spin and weight on inclined planes, run nearly as cones do
    assert names["length"] == pytest.approx(names["klingel"], rel=0.03)
    assert 40.0 < names["critical"] < 80.0
    # the derivatives against the motion in time
    assert names["measured"] == pytest.approx(names["foretold"], rel=0.03)
    assert (names["measured"] > 0.0).all()


def worn_profiles_over_100_000_km(names: dict[str, Any]) -> None:
    worn = names["worn"]
    assert worn.distances[-1] == pytest.approx(1e8)
    assert worn.left_out.max() < 0.1
    # at a constant law and load the volume grows with the distance and the mean slip, which changes little
    rates = np.diff(worn.wheel_volumes) / np.diff(worn.distances)
    assert rates.min() / rates.max() > 0.3
    assert 0.3e-3 < worn.wheel_depths[-1].max() < 1e-3
    new, old = (
        mtb.wheelset_geometry(wheel, "60E1", shifts=np.linspace(-6e-3, 6e-3, 49)).equivalent_conicity(3e-3)
        for wheel in (worn.wheel(0), worn.wheel())
    )
    # wheels wear where radii that differ make them slip, until they differ little
    assert 0.0 < old < 0.5 * new
    assert 1.1 < worn.peak_pressures[-1, 16] / worn.peak_pressures[0, 16] < 1.5


def wheel_flat(names: dict[str, Any]) -> None:
    peak, sunk, depth = names["peak"], names["sunk"], names["depth"]
    # round before and behind it, and symmetrical
    assert peak[0] == pytest.approx(peak[-1], rel=0.01)
    np.testing.assert_allclose(peak, peak[::-1], rtol=0.02)
    # the bottom is hollow, so that the wheel stands on both sides of it
    middle = peak.size // 2
    first, deepest = (names["steps"][k].patches[0].approach for k in (0, middle))
    angle = np.linspace(-names["half"], names["half"], 10001)
    below = depth * np.cos(0.5 * np.pi * angle / names["half"]) ** 2
    lowest = float((below + names["radius"] * (1.0 - np.cos(angle))).min())
    assert sunk[0] - sunk[middle] == pytest.approx(lowest - first + deepest, rel=0.005)
    assert peak[middle] < peak[0] < peak.max()


def stress_below_a_wheel(names: dict[str, Any]) -> None:
    # with a friction of 0.5 the surface bears most, and more than half of it by friction alone
    assert names["deep"] < 0.1
    assert names["share"] == pytest.approx(0.5, abs=0.06)


def worn_wheel_over_lateral_shift(names: dict[str, Any]) -> None:
    assert names["cone_error"] < 1e-9
    assert names["angle_error"] < 2e-4
    # Hertz, with the rail falling away on one side of the patch
    assert 0.0 < names["peak_error"] < 0.02
    assert -0.06 < names["area_error"] < 0.0
    # CONTACT, with another table of the rail's head
    for place, angle in names["benchmark"].values():
        assert abs(place) < 0.8e-3
        assert abs(angle) < 6e-3
    middle = len(names["shifts"]) // 2
    conicity = {
        name: of["difference"][middle + 6] / (2.0 * names["shifts"][middle + 6])
        for name, of in names["found"].items()
    }
    assert conicity["cone 1:20"] == pytest.approx(0.05, rel=1e-9)
    assert 0.12 < conicity["new wheel"] < 0.2
    assert conicity["hollow wheel"] > 1.2 * conicity["new wheel"]


def elastomer_pad_on_steel(names: dict[str, Any]) -> None:
    modulus = names["modulus"]
    flat, tall = names["heights"][-1], names["heights"][0]
    assert abs(names["difference"][flat]) < 0.02
    assert 0.0 < names["difference"][tall] < 0.12
    for height in names["heights"]:
        # elements only make it stiffer, linear ones by far
        assert names["found"][height] <= 1.001 * names["coarse"][height]
        assert names["locked"][height] > 1.08 * names["found"][height]
        assert names["found"][height] > modulus


def rough_contact_area(names: dict[str, Any]) -> None:
    light = names["loads"] < 0.1
    assert (names["kappa"][light] > 1.9).all()
    assert (names["kappa"][light] < 2.4).all()
    assert (names["limit"] > names["persson"]).all()
    assert (names["limit"] < names["bgt"]).all()
    # refining takes from the border of the contact
    assert (names["share"][2] < names["share"][1]).all()


def shakedown_of_roughness(names: dict[str, Any]) -> None:
    # what has borne the load bears it again
    assert names["again"] < 1e-6 * names["volumes"][-1]
    assert np.mean(names["volumes"][-20:]) < 0.5 * np.mean(names["volumes"][:5])
    assert np.mean(names["shares"][-20:]) < np.mean(names["shares"][:5])
    # nothing piles up, and no valley is deeper than what has flowed
    assert (names["dented"] <= names["rail"]).all()
    assert names["dented"].std() < 0.9 * names["rail"].std()


def rolling_on_rubber(names: dict[str, Any]) -> None:
    resistance, way = names["resistance"], names["way"]
    # where the rubber creeps while the roller passes
    assert 0.5e-3 < way < 3e-3
    assert resistance[0] < 0.1 * max(resistance)
    assert resistance[-1] < 0.1 * max(resistance)
    # half of the modulus: twice the compliance on a contact 1.4 times as wide
    assert names["slip"][0] / names["slip"][-1] == pytest.approx(2.0**0.5, rel=2e-2)


def friction_and_pull_from_forces(names: dict[str, Any]) -> None:
    assert names["clean_error"] < 1e-6
    assert names["evaluations"] < 15
    # 95 % of 23, and by chance a few less
    assert names["inside"] >= 19


def sole_of_least_peak_pressure(names: dict[str, Any]) -> None:
    assert names["count"] > 400
    # the vertical load is the same; on a curved rail the pressures stand aslant
    assert names["carried"]["best"] == pytest.approx(names["carried"]["flat"], rel=1e-3)
    assert names["peak"]["best"] < 0.3 * names["peak"]["flat"]
    assert names["peak"]["best"] > names["mean"]["best"]


def stopping_distance_and_its_deviation(names: dict[str, Any]) -> None:
    assert names["along"] == pytest.approx(names["check"] / 2e-3, rel=1e-4)
    # sixty rides know their deviation to about 9 %
    assert names["deviation"] == pytest.approx(names["distances"].std(ddof=1), rel=0.3)


CHECKS = {
    check.__name__: check
    for check in (
        brake_force_over_velocity,
        braking_manoeuvre,
        carter_rolling,
        cattaneo_mindlin,
        cattaneo_to_carter,
        magnet_snapping_on,
        worn_soles,
        creep_forces_with_spin,
        elastomer_pad_on_steel,
        europrinter_traction_curve,
        falling_friction_instability,
        friction_and_pull_from_forces,
        heat_of_a_stop,
        a_stop_with_heat_and_wear,
        a_year_of_stops,
        braking_to_rest,
        break_away_of_a_pole_shoe,
        stick_slip_of_a_shoe_on_its_links,
        flutter_of_a_pole_shoe,
        hertz,
        measured_wheelset,
        pictures_of_a_result,
        pole_shoe_design,
        lateral_jolt_of_a_wheelset,
        bogie_on_a_track,
        worn_profiles_over_100_000_km,
        rough_contact_area,
        shakedown_of_roughness,
        rolling_on_rubber,
        sole_of_least_peak_pressure,
        start_of_sliding,
        stopping_distance_and_its_deviation,
        stress_below_a_wheel,
        wheel_flat,
        worn_wheel_over_lateral_shift,
    )
}

#: What an example is started with, and what it needs beyond the package.
ARGUMENTS = {
    "bogie_on_a_track": ["--short"],
    "braking_manoeuvre": ["--short"],
    "stopping_distance_and_its_deviation": ["--rides", "60"],
}
NEEDS = {
    "bogie_on_a_track": "exudyn",
    "braking_manoeuvre": "exudyn",
    "friction_and_pull_from_forces": "scipy",
    "measured_wheelset": "scipy",
    "sole_of_least_peak_pressure": "scipy",
}

#: Runs a script up to its first call of the core, which it tells.
UNTIL_THE_CORE = """
import runpy, sys
import mtb_rs
script, *sys.argv[1:] = sys.argv[1:]
sys.argv[0] = script
def look(frame, event, called):
    kind = called if isinstance(called, type) else type(getattr(called, "__self__", None))
    if event == "c_call" and "mtb_rs._mtb_rs" in (getattr(called, "__module__", ""), kind.__module__):
        sys.setprofile(None)
        sys.exit(f"the core is asked for {called}")
sys.setprofile(look)
runpy.run_path(script, run_name="__main__")
"""


@pytest.mark.parametrize(
    "script",
    [
        path
        for path in sorted(
            [*EXAMPLES.glob("*.py"), *EXAMPLES.glob("thesis/*.py"), EXAMPLES / "side_by_side" / "prepare.py"]
        )
        if "output" in path.read_text(encoding="utf-8") and path.name != "drawing.py"
    ],
    ids=lambda path: path.stem,
)
def test_where_to_write_is_looked_at_first(script: Path, tmp_path: Path) -> None:
    """A folder that cannot be is told in one sentence, and nothing has been solved for it."""
    (tmp_path / "a file").write_text("here")
    command = [sys.executable, "-c", UNTIL_THE_CORE, str(script), "-o", str(tmp_path / "a file" / "out")]
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join([str(script.parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    }
    done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert re.search(r"argument -o/--output: .*a file.*: Not a directory$", done.stderr.strip())
    assert not done.stdout


#: Runs a script, and keeps of its names what can be kept.
RUN = """
import pickle, runpy, sys
script, kept, *sys.argv[1:] = sys.argv[1:]
sys.argv[0] = script
found = {}
for name, value in runpy.run_path(script, run_name="__main__").items():
    try:
        found[name] = pickle.dumps(value)
    except Exception:
        pass
with open(kept, "wb") as file:
    pickle.dump(found, file)
"""


class Names(dict[str, Any]):
    """Names of a script that ran elsewhere."""

    def __getitem__(self, name: str) -> Any:
        return pickle.loads(super().__getitem__(name))


@pytest.mark.parametrize("script", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_script(
    script: Path,
    tmp_path: Path,
    tmp_path_factory: pytest.TempPathFactory,
    monkeypatch: pytest.MonkeyPatch,
    with_extras: Callable[..., dict[str, str]],
) -> None:
    """It runs with the extras that it names, and no others."""
    if script.stem in NEEDS:
        pytest.importorskip(NEEDS[script.stem], reason="the extra mbs is missing", exc_type=ImportError)
    named = re.findall(r"extra `(\w+)`", script.read_text(encoding="utf-8"))
    kept = tmp_path_factory.mktemp("names") / "names.pickle"
    command = [sys.executable, "-W", "error", "-c", RUN, str(script), str(kept)]
    command += ARGUMENTS.get(script.stem, [])
    environment = with_extras(*named)
    done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    monkeypatch.chdir(tmp_path)
    CHECKS[script.stem](Names(pickle.loads(kept.read_bytes())))


@pytest.mark.parametrize("case", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_case(case: Path) -> None:
    result = mtb.load_case(case).solve()
    if isinstance(result, mtb.Braking):
        assert abs(result.open_energy) < 1e-8
        friction = -result.shoe.forces[:, 0] / result.shoe.forces[:, 2]
        assert 0.12 < friction.min() < 0.14
        assert 0.3 < friction.max() < 0.36
        return
    assert result.report.converged
    assert result.force[0] == pytest.approx(0.5 * result.normal_force, rel=1e-12)

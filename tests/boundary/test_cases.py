# SPDX-License-Identifier: MIT OR Apache-2.0
"""Case files and the command line: the same words as in Python, every error at once, no traceback."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.case import SCENES, case_from_words
from mtb_rs.case.schema import schema
from mtb_rs.commands import main

EXAMPLE = Path(__file__).parents[2] / "examples" / "pole_shoe_on_rail.toml"


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("scene", SCENES)
def test_a_case_with_nothing_but_its_scene_has_the_defaults_of_python(scene: str) -> None:
    from_case = case_from_words({"scene": scene}).scene()
    from_python = getattr(mtb.scenes, scene)()
    assert from_case.inputs == from_python.inputs


def test_case_and_python_give_the_same_bits() -> None:
    from_case = mtb.load_case(EXAMPLE).solve()
    from_python = mtb.scenes.pole_shoe_on_rail().solve(model="half-space")
    np.testing.assert_array_equal(from_case.pressure, from_python.pressure)


def test_case_writes_itself_back() -> None:
    case = mtb.load_case(EXAMPLE)
    again = case_from_words(tomllib.loads(case.to_toml()))
    assert again.to_toml() == case.to_toml()
    assert again.scene().inputs == case.scene().inputs


def test_fields_of_a_case(tmp_path: Path) -> None:
    write(tmp_path / "mu.csv", "velocity,value\n0,0.4\n10,0.2\n")
    path = write(
        tmp_path / "case.toml",
        """
        scene = "pole_shoe_on_rail"
        velocity = 5
        spacing = [6e-3, 3e-3]
        lower = "rigid"
        friction = { file = "mu.csv" }
        [magnetic_pressure]
        velocity = [0, 10]
        value = [[3e6, 2e6], [2e6, 1e6]]
        [solve]
        model = "half-space"
        """,
    )
    result = mtb.load_case(path).solve()
    load = result.pressure * result.area * result.normal[2]
    left, right = (float(patch.view(load).sum()) for patch in result.patches)
    assert left / right == pytest.approx(2.5 / 1.5, rel=1e-9)
    assert result.force[0] == pytest.approx(0.3 * result.normal_force, rel=1e-12)
    half_space = {"solve": {"model": "half-space"}}
    hill = {"peak": 4e6, "center": [0.0, 12e-3], "sigma": [0.02, 0.01]}
    assert (
        case_from_words({"scene": "pole_shoe_on_rail", "magnetic_pressure": hill, **half_space})
        .solve()
        .report.converged
    )


def test_profiles_of_a_case_come_from_files_beside_it(tmp_path: Path) -> None:
    y = np.linspace(-36e-3, 36e-3, 721)
    z = mtb.Profile.standard("60E1").height(y)
    np.savetxt(tmp_path / "measured.prr", np.stack([1e3 * y, 1e3 * z], axis=1))
    np.savetxt(tmp_path / "metres.txt", np.stack([y, -z], axis=1))
    text = """
        scene = "pole_shoe_on_rail"
        spacing = 6e-3
        outer_edge = 35e-3
        rail = {}
        [solve]
        model = "half-space"
        """
    known = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, outer_edge=35e-3).solve(model="half-space")
    for rail in (
        '"measured.prr"',
        '{ file = "metres.txt", unit = "m", z_axis = "down", interpolation = "linear" }',
    ):
        case = mtb.load_case(write(tmp_path / "case.toml", text.format(rail)))
        assert tomllib.loads(case.to_toml())["rail"] == tomllib.loads(f"rail = {rail}")["rail"]
        result = case.solve()
        assert result.normal_force == pytest.approx(known.normal_force, rel=1e-4)
        json.dumps(result.save(tmp_path / "out") and json.loads((tmp_path / "out/summary.json").read_text()))
    for rail, message in (
        ('"none.prr"', r"rail = .*there is no file .*none\.prr: one of 60E1, S1002, the path of"),
        ("3", "rail = 3: one of 60E1, S1002, the path of a profile file, or a table of file, unit"),
        (
            '{ unit = "m" }',
            "rail = .*or a table of file, unit, interpolation, z_axis, mirror, wavelength is needed",
        ),
        ('{ file = "metres.txt", unit = "furlong" }', "rail = .*unit is 'furlong': one of 'm', 'mm'"),
        ("{ file = 3 }", "rail = .*file is 3: a path is needed"),
        ('"case.toml"', "rail = .*profile file .*line 2 of the file"),
    ):
        path = write(tmp_path / "case.toml", text.format(rail))
        with pytest.raises(mtb.CaseError, match=message):
            mtb.load_case(path)


def test_every_error_at_once(tmp_path: Path) -> None:
    path = write(
        tmp_path / "bad.toml",
        """
        scene = "pole_shoe_on_rail"
        frictoin = 0.5
        friction = "high"
        poles = 2.5
        length = true
        spacing = [1, 2, 3]
        velocity = nan
        magnetic_pressure = { velocity = [0, 1], values = [1, 2] }
        [upper]
        shear_modulus = -80e9
        poisson_ratio = 0.3
        [lower]
        shear_modulus = 80e9
        young = 3
        [solve]
        tolerance = "x"
        """,
    )
    with pytest.raises(mtb.CaseError) as caught:
        mtb.load_case(path)
    lines = str(caught.value).splitlines()
    assert all(line.startswith(f"{path}: ") for line in lines)
    text = "\n".join(lines)
    for part in (
        "frictoin = 0.5: unknown key; did you mean 'friction'?",
        'friction = "high": a number',
        "poles = 2.5: a valid integer",
        "length = true: a valid number",
        "spacing = [1, 2, 3]: two numbers",
        "velocity = NaN: a finite number",
        "magnetic_pressure = ",
        "shear_modulus is -80000000000.0",
        "lower.poisson_ratio: is missing",
        "lower.young = 3: unknown key; known are poisson_ratio, young_modulus, shear_modulus",
        'solve.tolerance = "x"',
    ):
        assert part in text
    assert len(lines) == 11


def test_a_key_of_another_body_is_not_suggested_for_itself(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text('scene = "pole_shoe_on_rail"\n[lower]\nprism = "60E1"\nyoung_modulus = 2e11\n')
    with pytest.raises(
        mtb.CaseError, match=r"lower\.young_modulus = 2.*: unknown key; known are [^']*material"
    ):
        mtb.load_case(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "scene is missing: one of 'block_on_plane'"),
        ('scene = "pole_shoe"', "scene is 'pole_shoe': one of"),
        ("scene = ", "is not TOML: Invalid value"),
        ('scene = "pole_shoe_on_rail"\nlength = -1.0', "length is -1"),
        ('scene = "pole_shoe_on_rail"\nfriction = { file = "no.csv" }', "no.csv cannot be read"),
        ('scene = "pole_shoe_on_rail"\n[solve]\nmethod = "guess"', "method is 'guess'"),
    ],
)
def test_bad_cases_are_one_line(
    tmp_path: Path, text: str, message: str, capsys: pytest.CaptureFixture
) -> None:
    path = write(tmp_path / "case.toml", text)
    with pytest.raises(mtb.CaseError, match=message):
        mtb.load_case(path).solve()
    assert main(["run", str(path), "-o", str(tmp_path / "out")]) == 2
    errors = capsys.readouterr().err
    assert errors.startswith(f"mtb-rs: {path}: ")
    assert errors.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_unreadable_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(mtb.CaseError, match=r"none.toml: cannot be read: No such file"):
        mtb.load_case(tmp_path / "none.toml")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(mtb.CaseError, match=r"binary.toml: is not UTF-8 text"):
        mtb.load_case(tmp_path / "binary.toml")


def test_run_from_the_command_line(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "mtb_rs", "run", str(EXAMPLE), "-o", str(tmp_path / "out")]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    for word in ("normal force", "force balance", "contact area", "peak pressure", "iterations", "time"):
        assert word in run.stdout
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["report"]["converged"]
    for name in (
        "fields.npz",
        "contact.vtp",
        "pressure.png",
        "pressure_lines.png",
        "status.png",
        "vertical_displacement.png",
        "vertical_displacement_lines.png",
    ):
        assert (tmp_path / "out" / name).stat().st_size > 0


def test_unwritable_place_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    target = write(tmp_path / "file", "")
    assert main(["run", str(EXAMPLE), "-o", str(target)]) == 2
    assert "is not a directory" in capsys.readouterr().err


def test_help_and_version(capsys: pytest.CaptureFixture) -> None:
    for option, expected in (("--help", "run"), ("--version", mtb.__version__)):
        with pytest.raises(SystemExit) as stop:
            main([option])
        assert stop.value.code == 0
        assert expected in capsys.readouterr().out


def test_wrong_values_are_told_all_at_once(tmp_path: Path) -> None:
    path = write(
        tmp_path / "case.toml", 'scene = "pole_shoe_on_rail"\nfriction = -0.3\nspacing = 0\npoles = 3\n'
    )
    case = mtb.load_case(path)
    with pytest.raises(mtb.CaseError) as caught:
        case.scene()
    for words in ("friction is -0.3: numbers from 0", "spacing is 0", "poles is 3: a shoe has 1 or 2 poles"):
        assert words in str(caught.value)
    assert len(str(caught.value).splitlines()) == 3


def test_wrong_values_are_told_with_wrong_keys(tmp_path: Path) -> None:
    path = write(
        tmp_path / "case.toml",
        'scene = "block_on_plane"\nfrction = 0.3\nheight = -1\nmagnetic_pressure = "a"\nspacing = 0\n',
    )
    with pytest.raises(mtb.CaseError) as caught:
        mtb.load_case(path)
    lines = str(caught.value).splitlines()
    assert len(lines) == 4
    for words in ("did you mean 'friction'?", "height is -1", "magnetic_pressure = ", "spacing is 0"):
        assert any(words in line for line in lines)


def test_what_suits_no_default_is_not_blamed(tmp_path: Path) -> None:
    # a length that the default rail is too short for, but not the rail of the case
    text = 'scene = "pole_shoe_on_rail"\nlength = 0.5\nrail_length = 1.0\npoles = 3\nspacing = 0.01\n'
    path = write(tmp_path / "case.toml", text)
    with pytest.raises(mtb.CaseError) as caught:
        mtb.load_case(path).scene()
    assert len(str(caught.value).splitlines()) == 1


def test_many_wrong_keys_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    keys = "".join(f"qqq{k} = 1\n" for k in range(3000))
    for head, more in (("", 2980), ("friction = -1\n", 2980), ("[solve]\n", 2980), ("[upper]\n", 2981)):
        text = "scene = 'pole_shoe_on_rail'\n" + head + keys
        path.write_text(text)
        with pytest.raises(mtb.CaseError, match="unknown") as caught:
            mtb.load_case(path)
        lines = str(caught.value).splitlines()
        assert len(lines) == 21
        assert lines[-1] == f"{path}: and {more} more"


def test_text_files_of_windows_are_read_or_their_encoding_is_named(tmp_path: Path) -> None:
    case = 'scene = "wheel_on_rail"\nrail = "rail.prr"\n[friction]\nfile = "friction.csv"\n'
    points = "".join(f"{k:.1f} {8e-3 * k**2:.6f}\n" for k in range(-35, 36))
    texts = {"case.toml": case, "friction.csv": "velocity,value\n0,0.3\n9,0.2\n", "rail.prr": points}
    for name, text in texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    plain = mtb.load_case(tmp_path / "case.toml")
    for name, text in texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8-sig")
    marked = mtb.load_case(tmp_path / "case.toml")
    assert marked.argument("rail", "rail.prr") == plain.argument("rail", "rail.prr")
    assert mtb.VelocityTable.from_file(tmp_path / "friction.csv").value == (0.3, 0.2)
    for name, text in texts.items():
        for encoding in ("utf-16", "utf-16-be"):
            mark = b"\xfe\xff" if encoding == "utf-16-be" else b""
            (tmp_path / name).write_bytes(mark + text.encode(encoding))
            with pytest.raises(mtb.CaseError, match=r"UTF-16.*save it again in UTF-8") as refused:
                mtb.load_case(tmp_path / "case.toml")
            # the program writes no tables and profiles
            assert ("-o case.toml" in str(refused.value)) == (name == "case.toml")
        (tmp_path / name).write_text(text, encoding="utf-8")


STRESSED = """
scene = "paraboloid_on_plane"
points = 32
friction = 0.3
[stress]
"""


@pytest.mark.parametrize(
    "motion",
    ["", "[shift]\ndisplacement = [1e-6, 0.0]\n", "[wear]\ndistance = 1e-3\nlaw = 1e-13\n"],
    ids=["solved", "shifted", "worn"],
)
def test_stress_of_a_case(tmp_path: Path, motion: str) -> None:
    words = STRESSED + 'body = "upper"\ndepths = [0.0, 1e-3]\n' + motion
    case = mtb.load_case(write(tmp_path / "case.toml", words))
    found = case.stressed(case.solve())
    assert found == case.solve().stress("upper", depths=[0.0, 1e-3])
    assert main(["run", str(tmp_path / "case.toml"), "-o", str(tmp_path / "out")]) == 0
    assert mtb.load(tmp_path / "out" / "stress.json") == found
    assert (tmp_path / "out" / "stress.png").is_file()
    again = case_from_words(tomllib.loads(case.to_toml()))
    assert again.stress is not None
    assert again.stress["body"] == "upper"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("depth = 1", "depth: unknown key; did you mean 'depths'?"),
        ("depths = [2e-3, 1e-3]", "rising depths are needed"),
        ("depths = []", "at least one depth is needed"),
        ("depths = 'a'", "depths"),
        ('body = "middle"', "body is 'middle'"),
        ("patch = 1", "patch is 1: the name of a grid is needed"),
        ("[brake]\nspeed = 20.0\nmass = 1e4", "stress and brake are given"),
    ],
)
def test_bad_stress_of_a_case(words: str, message: str) -> None:
    with pytest.raises(mtb.CaseError, match=re.escape(message)):
        case_from_words(tomllib.loads(STRESSED + words))


@pytest.mark.parametrize("words", [["chart"], ["sweep", "--vary", "friction=0.1,0.2"]])
def test_charts_and_sweeps_have_no_stress(
    tmp_path: Path, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path / "case.toml", STRESSED)
    assert main([words[0], str(path), *words[1:], "-o", str(tmp_path / "out")]) == 2
    assert "[stress] is given, and a" in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "out" / "chart.png").exists()


DAMAGED = """
scene = "paraboloid_on_plane"
radius = 0.46
force = 36e3
points = 20
friction = 0.3
hardness = 4e8
[damage]
shear_yield = 2e8
bulk = [0.0, 20.0]
lower = { conductivity = 40.0, density = 7800.0, specific_heat = 460.0 }
[rolling]
creepage = [2e-3, 0.0, 0.0]
velocity = 30.0
"""


@pytest.mark.slow
@pytest.mark.coarse
def test_damage_of_a_case(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = mtb.load_case(write(tmp_path / "case.toml", DAMAGED))
    rolled = case.solve()
    assert isinstance(rolled, mtb.TangentialResult)
    # the hardness is the peak pressure: load 2, and the index by its definition
    assert rolled.pressure.max() == 4e8
    share = float(np.hypot(*rolled.force[:2])) / -float(rolled.force[2])
    warm = rolled.temperature(mtb.Conductor(40.0, 7800.0, 460.0), bulk=(0.0, 20.0))
    known = {
        "t_gamma": 2e-3 * float(rolled.force[0]),
        "t_gamma_with_spin": 2e-3 * float(rolled.force[0]),
        "surface_fatigue_index": share - 0.5,
        "traction_coefficient": share,
        "load_factor": 2.0,
        "peak_temperature": warm.peak,
    }
    numbers, temperature = case.damaged(rolled)
    assert numbers == pytest.approx(known, rel=1e-12)
    assert temperature == warm
    out = tmp_path / "out"
    assert main(["run", str(tmp_path / "case.toml"), "-o", str(out)]) == 0
    assert "surface fatigue index" in capsys.readouterr().out
    assert json.loads((out / "damage.json").read_text()) == pytest.approx(known, rel=1e-12)
    assert mtb.load(out / "temperature") == warm
    path = str(tmp_path / "case.toml")
    assert main(["sweep", path, "--vary", "rolling.velocity=10,30", "-o", str(out)]) == 0
    table = mtb.load(out / "sweep.json")
    assert isinstance(table, mtb.SweepTable)
    assert table["t_gamma"] == pytest.approx(known["t_gamma"])
    assert table["peak_temperature"][1] == pytest.approx(warm.peak)
    assert table["peak_temperature"][0] < warm.peak
    assert case_from_words(tomllib.loads(case.to_toml())).damage == case.damage


@pytest.mark.filterwarnings("ignore:The estimated error of the pressure")
def test_damage_takes_the_surfaces_of_a_friction_that_follows_the_temperature() -> None:
    words = tomllib.loads(DAMAGED)
    law = {"temperature": [0.0, 400.0], "coefficient": [0.3, 0.1], "bulk": [100.0, 200.0]}
    words["friction"] = law
    words["damage"] = {}
    case = case_from_words(words)
    rolled = case.solve()
    assert isinstance(rolled, mtb.TangentialResult)
    friction = mtb.TemperatureFriction([0.0, 400.0], [0.3, 0.1], bulk=(100.0, 200.0))
    warm = rolled.temperature(**friction.surfaces)
    numbers, temperature = case.damaged(rolled)
    assert temperature == warm
    assert numbers["peak_temperature"] == warm.peak > 100.0
    touching = rolled.pressure > 0.0
    known = friction.at(warm.temperature_lower[touching])
    assert rolled.friction_coefficient[touching] == pytest.approx(known, abs=1e-6)


@pytest.mark.coarse
def test_transient_rolling_has_no_temperature_among_its_damage() -> None:
    words = tomllib.loads(DAMAGED.replace("velocity = 30.0", "velocity = 30.0\ntransient = true"))
    with pytest.raises(mtb.CaseError, match=r"damage\.lower is given, and the rolling is transient"):
        case_from_words(words)
    words["damage"] = {}
    case = case_from_words(words)
    rolled = case.solve()
    assert isinstance(rolled, mtb.TangentialResult)
    numbers, temperature = case.damaged(rolled)
    assert set(numbers) == {"t_gamma", "t_gamma_with_spin"}
    assert temperature is None


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"damage": {"shear_yeld": 1e8}}, "shear_yeld: unknown key; did you mean 'shear_yield'?"),
        ({"damage": {"shear_yield": -1.0}}, "shear_yield is -1"),
        ({"damage": {"shear_yield": "300 MPa"}}, "shear_yield"),
        ({"damage": {"bulk": [1.0]}}, "bulk"),
        ({"damage": {"lower": {"conductivity": 50.0}}}, "lower: density is missing"),
        ({"damage": 3}, "a table, maybe with shear_yield"),
        ({"rolling": None}, "damage is given without [rolling]"),
        ({"rolling": None, "shift": {"displacement": [1e-6, 0.0]}}, "damage is given without [rolling]"),
        ({"hardness": -4e8}, "hardness"),
        ({"hardness": "hard"}, "hardness"),
    ],
)
def test_bad_damage_of_a_case(words: dict[str, Any], message: str) -> None:
    given = {k: v for k, v in (tomllib.loads(DAMAGED) | words).items() if v is not None}
    with pytest.raises(mtb.CaseError, match=re.escape(message)):
        case_from_words(given).scene()


def test_prepared_wheels_refuse_a_hardness() -> None:
    scene = mtb.scenes.wheel_on_rail(hardness=1e9)
    with pytest.raises(ValueError, match="hardness is given, and prepared wheels have none"):
        scene.prepare()


def test_stress_that_a_body_has_not_is_refused_before_the_solve(tmp_path: Path) -> None:
    path = write(tmp_path / "case.toml", STRESSED.replace("[stress]", 'lower = "rigid"\n[stress]'))
    case = mtb.load_case(path)
    for asked in (case.solve, case.expected_cost):
        with pytest.raises(mtb.CaseError, match="stress: the lower body is Rigid"):
            asked()


@pytest.mark.coarse
def test_stress_in_a_layer_of_a_case(tmp_path: Path) -> None:
    soft = "{ young_modulus = 2e9, poisson_ratio = 0.4 }"
    lower = f'lower = {{ layer = {soft}, thickness = 2e-3, base = "rigid" }}\n[stress]\ndepths = '
    path = tmp_path / "case.toml"
    case = mtb.load_case(write(path, STRESSED.replace("[stress]\n", f"{lower}[0.0, 2e-3]\n")))
    assert case.stressed(case.solve()).depths.tolist() == [0.0, 2e-3]
    deep = mtb.load_case(write(path, STRESSED.replace("[stress]\n", f"{lower}[0.0, 3e-3]\n")))
    for asked in (deep.solve, deep.expected_cost):
        with pytest.raises(mtb.CaseError, match=r"place 1 is 0\.003 m deep in the lower body"):
            asked()


SHOE = """
scene = "pole_shoe_on_rail"
spacing = 0.012
friction = 0.3
[stress]
"""


@pytest.mark.parametrize(
    ("words", "patch", "known"),
    [
        (STRESSED, "left", "'contact'"),
        (STRESSED + "[wear]\ndistance = 1e-3\nlaw = 1e-13\n[stress]\n", "left", "'contact'"),
        (STRESSED + "[shift]\ndisplacement = [1e-6, 0.0]\n[stress]\n", "left", "'contact'"),
        (SHOE, "contact", "'left', 'right'"),
    ],
)
def test_a_patch_that_is_not_there_is_refused_before_the_solve(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: str, patch: str, known: str
) -> None:
    head, _, tail = words.rpartition("[stress]")
    path = write(tmp_path / "case.toml", f"{head.replace('[stress]', '')}[stress]\npatch = '{patch}'\n{tail}")
    case = mtb.load_case(path)
    told = re.escape(f"stress: patch is '{patch}': one of {known} is needed")
    with pytest.raises(mtb.CaseError, match=told):
        case.solve()
    assert main(["check", str(path)]) == 2
    said = " ".join(capsys.readouterr().err.split())
    if "[wear]" not in words:  # whose cost is not known
        assert re.search(told, said)


def test_a_patch_that_is_there_is_taken() -> None:
    case = case_from_words(tomllib.loads(SHOE + 'patch = "right"\ndepths = [1e-3]'))
    case.expected_cost()
    moved = case_from_words(
        tomllib.loads(STRESSED + 'patch = "contact"\n[shift]\ndisplacement = [1e-6, 0.0]')
    )
    moved.expected_cost()


def test_a_case_with_a_stress_at_one_depth_runs_to_its_end(tmp_path: Path) -> None:
    words = STRESSED + "depths = [1e-3]\n[shift]\ndisplacement = [1e-6, 0.0]\n"
    path = write(tmp_path / "case.toml", words)
    assert main(["run", str(path), "-o", str(tmp_path / "out")]) == 0
    found = mtb.load(tmp_path / "out" / "stress.json")
    assert isinstance(found, mtb.StressField)
    assert np.asarray(found.depths).tolist() == [1e-3]
    assert (tmp_path / "out" / "stress.npz").is_file()
    assert not (tmp_path / "out" / "stress.png").exists()


@pytest.mark.parametrize(
    "keys", [{"contact_pressure": 1e6}, {"length": 1e-6}, {"gap": [1e-6, 0.0], "height": 1e-5}]
)
def test_a_rough_layer_tells_the_keys_that_it_lacks(keys: dict[str, Any]) -> None:
    message = "do not go together: a rough layer has contact_pressure, length and, .*, or gap and pressure"
    with pytest.raises(mtb.CaseError, match=message):
        case_from_words({"scene": "block_on_plane", "normal_layer": keys})


@pytest.mark.parametrize(
    ("words", "name"),
    [
        ({"scene": "pole_shoe_on_rail"}, "spacing"),
        ({"scene": "block_on_plane"}, "spacing"),
        ({"scene": "wheel_on_rail"}, "spacing"),
        ({"scene": "paraboloid_on_plane"}, "points"),
    ],
)
def test_cells_that_the_solve_finds(words: dict[str, Any], name: str) -> None:
    made = getattr(mtb.scenes, words["scene"])(**{name: None})
    for given in ("auto", None):
        case = case_from_words(words | {name: given})
        assert case.scene().inputs == made.inputs
        assert case.scene().spacing is None
        jsonschema.validate(words | {name: "auto"}, schema())
    for wrong in ("fine", [1e-3, "auto"], True):
        with pytest.raises(mtb.CaseError, match=rf"case: {name} = "):
            case_from_words(words | {name: wrong})
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(words | {name: "fine"}, schema())

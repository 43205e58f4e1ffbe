# SPDX-License-Identifier: MIT OR Apache-2.0
"""Sweeps: any executor, one table, interruptions and dead workers lose nothing."""

import csv
import functools
import itertools
import json
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.base.questions import ask
from mtb_rs.commands import main
from mtb_rs.commands.exits import BAD_INPUT, NO_SOLUTION

rubber = mtb.Material(young_modulus=5e9, poisson_ratio=0.2)
GRID = {"friction": [0.1, 0.3, 0.5], "force": [1e6, 5e6]}


def paraboloid():
    return mtb.scenes.paraboloid_on_plane(points=10, upper=rubber)


def peak_place(result):
    """A measure that processes can import."""
    at = np.unravel_index(np.argmax(result.pressure), result.pressure.shape)
    return {"peak_x": result.points[0][at]}


def deadly(result):
    """Ends its process for two cases, unless told that it is healed."""
    if "MTB_TEST_HEALED" in os.environ:
        return {"pid": 0}
    if result.force[0] > 0.25 * -result.force[2] and result.normal_force > 4e6:
        os.kill(os.getpid(), signal.SIGKILL)
    return {"pid": os.getpid()}


def killed_once(result):
    """Ends its process the first time only."""
    mark = os.environ["MTB_TEST_MARK"]
    if not os.path.exists(mark):
        with open(mark, "w", encoding="utf-8"):
            pass
        os.kill(os.getpid(), signal.SIGKILL)
    return {"pid": os.getpid()}


@pytest.mark.coarse
def test_a_bar_says_how_many_cases_are_solved(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("tqdm", reason="pip install 'mtb-rs[notebook]'")
    table = mtb.sweep(paraboloid(), GRID, progress=True)
    said = capsys.readouterr().err
    assert f"{len(table)}/{len(table)}" in said
    assert "solving" in said
    paraboloid().chart(budget=0.5, repeats=1, progress=True)
    assert "done: 100%" in capsys.readouterr().err


@pytest.mark.coarse
def test_a_sweep_is_its_scenes_in_a_table(tmp_path):
    seen = []
    table = mtb.sweep(
        paraboloid(), GRID, measure=peak_place, progress=lambda done, of: seen.append((done, of))
    )
    assert table["force_x"].shape == (3, 2)
    assert seen == [(k, 6) for k in range(7)]
    for i, friction in enumerate(GRID["friction"]):
        for j, force in enumerate(GRID["force"]):
            result = paraboloid().with_(friction=friction, force=force).solve()
            assert table["force_x"][i, j] == result.force[0]
            assert table["peak_pressure"][i, j] == result.report.peak_pressure
            assert table["peak_x"][i, j] == peak_place(result)["peak_x"]
    assert table.failures == []
    assert table.attributes == {"scene": "paraboloid_on_plane", "model": "half-space"}
    table.to_csv(tmp_path / "table.csv")
    with open(tmp_path / "table.csv", newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [float(r["friction"]) for r in rows] == [0.1, 0.1, 0.3, 0.3, 0.5, 0.5]
    assert float(rows[3]["force_x [N]"]) == table["force_x"][1, 1]


def test_labels_and_a_failing_case(tmp_path):
    pulls = {"even": (3e6, 3e6), "left only": (3e6, 0.0), "left": (3e6, 1e6)}
    shoe = mtb.scenes.pole_shoe_on_rail(spacing=1e-2)
    table = mtb.sweep(shoe, {"magnetic_pressure": pulls, "length": [0.06, 0.09]}, model="half-space")
    assert table.parameters["magnetic_pressure"] == ("even", "left only", "left")
    assert np.isnan(table["force_z"][1]).all()
    assert not np.isnan(table["force_z"][[0, 2]]).any()
    assert [case["magnetic_pressure"] for case, _ in table.failures] == ["left only"] * 2
    assert "does not press the bodies together" in table.failures[0][1]
    assert "length" in repr(table)
    assert "4 of 6 solved" in repr(table)
    # the length of a shoe changes its geometry
    ratio = table["force_z"][0, 1] / table["force_z"][0, 0]
    assert ratio == pytest.approx(1.5, rel=1e-9)


def test_arguments_changed_by_hand_stay_when_the_geometry_is_varied():
    shoe = mtb.scenes.pole_shoe_on_rail(spacing=1e-2).with_(friction=0.25)
    table = mtb.sweep(shoe, {"length": [0.06]}, model="half-space")
    assert table["force_x"][0] == pytest.approx(-0.25 * table["force_z"][0], rel=1e-2)


@pytest.mark.coarse
def test_the_geometry_is_varied_beside_what_any_scene_has():
    falling = paraboloid().with_(friction=mtb.VelocityTable([0.0, 10.0], [0.4, 0.2]))
    table = mtb.sweep(falling, {"points": [8, 10], "velocity": [0.0, 10.0]})
    assert table.failures == []
    ratio = table["force_x"] / -table["force_z"]
    np.testing.assert_allclose(ratio, [[0.4, 0.2], [0.4, 0.2]], rtol=1e-9)


@pytest.mark.coarse
@pytest.mark.parametrize("kind", ["threads", "processes"])
def test_any_executor_gives_the_same(kind):
    want = mtb.sweep(paraboloid(), GRID)
    if kind == "threads":
        with ThreadPoolExecutor(2) as pool:
            got = mtb.sweep(paraboloid(), GRID, executor=pool)
    else:
        with ProcessPoolExecutor(1) as pool:
            got = mtb.sweep(paraboloid(), GRID, executor=pool, measure=peak_place)
    for name in ("force_x", "force_z", "approach"):
        np.testing.assert_allclose(got[name], want[name], rtol=1e-12)


@pytest.mark.coarse
def test_an_interrupted_sweep_goes_on(tmp_path):
    path = tmp_path / "sweep.jsonl"

    def stop_at_three(done, total):
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        mtb.sweep(paraboloid(), GRID, checkpoint=path, progress=stop_at_three)
    lines = path.read_text(encoding="utf-8").splitlines()
    assert len(lines) == 4
    with path.open("a", encoding="utf-8") as stream:
        stream.write(lines[-1][:20])  # cut short in the middle of a line
    seen = []
    table = mtb.sweep(paraboloid(), GRID, checkpoint=path, progress=lambda done, of: seen.append(done))
    assert seen == [3, 4, 5, 6]
    want = mtb.sweep(paraboloid(), GRID)
    np.testing.assert_array_equal(table["force_x"], want["force_x"])
    assert len(path.read_text(encoding="utf-8").splitlines()) == 7
    with pytest.raises(ValueError, match="is the checkpoint of another sweep"):
        mtb.sweep(paraboloid(), {"friction": [0.2]}, checkpoint=path)


class Mu:
    """Friction over the place, as an object that holds its value."""

    def __init__(self, value):
        self.value = value

    def __call__(self, x, y):
        return self.value + 0 * x


def mu(value, x, y):
    return value + 0 * x


LEVEL = 0.1


def of_level(x, y):
    return LEVEL + 0 * x


FRICTIONS = {
    "object": Mu,
    "partial": lambda value: functools.partial(mu, value),
    "closure": lambda value: lambda x, y: value + 0 * x,
    "default": lambda value: lambda x, y, value=value: value + 0 * x,
    "method": lambda value: Mu(value).__call__,
    "code": lambda value: eval(f"lambda x, y: {value} + 0 * x"),
}


@pytest.mark.coarse
@pytest.mark.parametrize("kind", FRICTIONS)
@pytest.mark.parametrize("where", ["grid", "scene"])
def test_a_checkpoint_tells_callables_apart(kind, where, tmp_path):
    def swept(value):
        friction = FRICTIONS[kind](value)
        if where == "grid":
            return mtb.sweep(paraboloid(), {"friction": {"f": friction}}, checkpoint=tmp_path / "c")
        return mtb.sweep(paraboloid().with_(friction=friction), {"force": [1e6]}, checkpoint=tmp_path / "c")

    kept = swept(0.1)["force_x"]
    assert swept(0.1)["force_x"] == kept
    with pytest.raises(ValueError, match="is the checkpoint of another sweep"):
        swept(0.5)


@pytest.mark.coarse
def test_a_checkpoint_knows_its_measure_and_the_globals_of_functions(tmp_path, monkeypatch):
    def swept(measure=None):
        return mtb.sweep(
            paraboloid().with_(friction=of_level),
            {"force": [1e6]},
            checkpoint=tmp_path / "c",
            measure=measure,
        )

    swept(peak_place)
    assert "peak_x" in swept(peak_place).columns
    with pytest.raises(ValueError, match="another sweep"):
        swept()
    monkeypatch.setattr(sys.modules[__name__], "LEVEL", 0.2)
    with pytest.raises(ValueError, match="another sweep"):
        swept(peak_place)


def test_a_key_is_the_same_in_another_process():
    code = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "import test_sweeps as t; from mtb_rs.base.fingerprint import fingerprint\n"
        "print(fingerprint([t.paraboloid(), t.Mu(0.1), t.of_level, t.peak_place, {'b', 'a', 'c'}]))"
    )
    command = [sys.executable, "-c", code, str(Path(__file__).parent)]
    keys = {
        subprocess.run(
            command, env=os.environ | {"PYTHONHASHSEED": seed}, capture_output=True, text=True, check=True
        ).stdout
        for seed in ("1", "2")
    }
    assert len(keys) == 1


@pytest.mark.coarse
def test_what_hides_its_content_has_no_checkpoint(tmp_path):
    lock = threading.Lock()
    friction = {"f": lambda x, y: 0.1 + 0 * x * lock.locked()}
    assert mtb.sweep(paraboloid(), {"friction": friction}).failures == []
    with pytest.raises(ValueError, match=r"no checkpoint is possible: <unlocked _thread\.lock"):
        mtb.sweep(paraboloid(), {"friction": friction}, checkpoint=tmp_path / "c")


DAMAGE = [
    (1, b"[]"),
    (1, b'{"swe'),
    (1, b'{"status": "solved"}'),
    (1, b"\xff"),
    (1, b""),
    (2, b'{"case": 0, "status": "solved"}'),
    (2, b"[" * 100_000),
    (2, b'{"case": 0, "sta'),
    (2, b""),
]


@pytest.mark.coarse
@pytest.mark.parametrize(("number", "line"), DAMAGE, ids=[str(line[:30]) for _, line in DAMAGE])
def test_a_damaged_checkpoint_is_named_with_its_line(number, line, tmp_path):
    path = tmp_path / "sweep.jsonl"
    mtb.sweep(paraboloid(), {"friction": [0.2]}, checkpoint=path)
    lines = path.read_bytes().splitlines()
    lines[number - 1] = line
    path.write_bytes(b"\n".join(lines) + b"\n")
    with pytest.raises(ValueError, match=rf"sweep\.jsonl, line {number}: "):
        mtb.sweep(paraboloid(), {"friction": [0.2]}, checkpoint=path)


@pytest.mark.coarse
def test_no_digit_of_a_checkpoint_changes_unseen(tmp_path):
    path = tmp_path / "sweep.jsonl"
    mtb.sweep(paraboloid(), {"friction": [0.2]}, checkpoint=path)
    data = bytearray(path.read_bytes())
    data[data.index(b'"peak_pressure": ') + 18] ^= 1
    path.write_bytes(data)
    with pytest.raises(ValueError, match=r"sweep\.jsonl, line 2: no line of a checkpoint, or a damaged one"):
        mtb.sweep(paraboloid(), {"friction": [0.2]}, checkpoint=path)


@pytest.mark.coarse
def test_a_checkpoint_stays_the_file_it_is(tmp_path):
    """Its link, its mode, its lines: only new ones are added."""
    path, link = tmp_path / "sweep.jsonl", tmp_path / "link"
    mtb.sweep(paraboloid(), {"friction": [0.1]}, checkpoint=path)
    path.chmod(0o600)
    link.symlink_to(path)
    before = path.read_bytes()
    assert mtb.sweep(paraboloid(), {"friction": [0.1]}, checkpoint=link).failures == []
    assert link.is_symlink()
    assert path.stat().st_mode & 0o777 == 0o600
    assert path.read_bytes() == before
    # cut short in its first line, nothing is lost; another file is not overwritten
    path.write_bytes(before[:30])
    assert mtb.sweep(paraboloid(), {"friction": [0.1]}, checkpoint=path).failures == []
    path.write_bytes(b'{"precious": 1}')
    with pytest.raises(ValueError, match="line 1: no line of a checkpoint"):
        mtb.sweep(paraboloid(), {"friction": [0.1]}, checkpoint=path)
    assert path.read_bytes() == b'{"precious": 1}'


@pytest.mark.coarse
def test_two_sweeps_with_one_checkpoint_lose_nothing(tmp_path):
    path = tmp_path / "sweep.jsonl"
    inner = []  # type: ignore[var-annotated]

    def once(done, total):
        if done == 2 and not inner:
            inner.append(mtb.sweep(paraboloid(), GRID, checkpoint=path))

    outer = mtb.sweep(paraboloid(), GRID, checkpoint=path, progress=once)
    np.testing.assert_array_equal(outer["force_x"], inner[0]["force_x"])
    seen = []
    mtb.sweep(paraboloid(), GRID, checkpoint=path, progress=lambda done, of: seen.append(done))
    assert seen == [6]


@pytest.mark.coarse
def test_a_checkpoint_is_of_one_version(tmp_path, monkeypatch):
    mtb.sweep(paraboloid(), {"friction": [0.1]}, checkpoint=tmp_path / "c")
    monkeypatch.setattr("mtb_rs.studies.sweeps.__version__", "0.0.1")
    with pytest.raises(ValueError, match=r"another sweep .* version of mtb_rs"):
        mtb.sweep(paraboloid(), {"friction": [0.1]}, checkpoint=tmp_path / "c")


def failing_once(result):
    """Fails as a machine does, unless told that it is healed."""
    if "MTB_TEST_HEALED" not in os.environ:
        raise MemoryError("no memory")
    return {}


@pytest.mark.coarse
def test_what_the_machine_failed_in_is_tried_again(tmp_path, monkeypatch):
    swept = functools.partial(
        mtb.sweep, paraboloid(), {"friction": [0.1]}, checkpoint=tmp_path / "c", measure=failing_once
    )
    assert swept().status[0] == "MemoryError: no memory"
    monkeypatch.setenv("MTB_TEST_HEALED", "1")
    assert swept().failures == []
    assert swept().failures == []


def test_values_without_text_of_their_own_are_known_in_another_process(tmp_path):
    code = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "import numpy as np, test_sweeps as t, mtb_rs as mtb\n"
        "rough = np.full((40, 40), 0.1); rough[20, 20] = 0.2\n"
        "values = [t.Mu(0.1), t.of_level, lambda x, y: 0.2 + 0 * x, rough, 2 * rough]\n"
        "scene = mtb.scenes.paraboloid_on_plane(points=40)\n"
        "table = mtb.sweep(scene, {'friction': values}, checkpoint=sys.argv[2])\n"
        "print(table.parameters['friction'])"
    )
    command = [sys.executable, "-c", code, str(Path(__file__).parent), str(tmp_path / "c")]
    first, again = (subprocess.run(command, capture_output=True, text=True, check=True).stdout for _ in "12")
    assert first == again
    assert "('Mu 1', 'of_level 2', '<lambda> 3', 'ndarray 4', 'ndarray 5')" in first


def slow(result):
    """Takes longer than anybody waits; says that it began."""
    with open(os.environ["MTB_TEST_MARK"], "a", encoding="utf-8") as stream:
        stream.write(f"{os.getpid()}\n")
    time.sleep(600)
    return {}


SLOW = """
import sys; sys.path.insert(0, sys.argv[1])
import test_sweeps as t, mtb_rs as mtb
if __name__ == "__main__":
    mtb.sweep(t.paraboloid(), t.GRID, executor=2, measure=t.slow)
"""


@pytest.fixture
def slow_sweep(tmp_path, monkeypatch):
    """A process that sweeps, and its two workers at work."""
    mark = tmp_path / "mark"
    mark.touch()
    monkeypatch.setenv("MTB_TEST_MARK", str(mark))
    script = tmp_path / "script.py"
    script.write_text(SLOW, encoding="utf-8")
    process = subprocess.Popen(
        [sys.executable, str(script), str(Path(__file__).parent)],
        stderr=subprocess.PIPE,
        start_new_session=True,
        # the tests may run where Ctrl-C is ignored
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL) and None,
    )
    try:
        assert soon(lambda: len(mark.read_text(encoding="utf-8").splitlines()) == 2)
        yield process, [int(line) for line in mark.read_text(encoding="utf-8").splitlines()]
    finally:
        process.kill()
        process.communicate()


def soon(is_so):
    """Whether it is so within a minute."""
    until = time.monotonic() + 60.0
    while time.monotonic() < until:
        if is_so():
            return True
        time.sleep(0.05)
    return False


def is_gone(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    # one that nobody has waited for yet
    return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] == "Z"


@pytest.mark.skipif(sys.platform != "linux", reason="signals and /proc")
@pytest.mark.parametrize("times", [1, 2])
def test_control_c_ends_a_sweep_and_its_workers_at_once(slow_sweep, times):
    process, workers = slow_sweep
    for _ in range(times):
        os.killpg(process.pid, signal.SIGINT)
        time.sleep(0.05)
    _, err = process.communicate(timeout=60)
    assert b"KeyboardInterrupt" in err
    assert soon(lambda: all(map(is_gone, workers)))


@pytest.mark.skipif(sys.platform != "linux", reason="signals and /proc")
def test_workers_do_not_outlive_their_sweep(slow_sweep):
    process, workers = slow_sweep
    process.kill()
    assert soon(lambda: all(map(is_gone, workers)))


@pytest.mark.coarse
def test_a_killed_worker_loses_nothing(tmp_path, monkeypatch):
    monkeypatch.setenv("MTB_TEST_MARK", str(tmp_path / "killed"))
    path = tmp_path / "sweep.jsonl"
    table = mtb.sweep(paraboloid(), GRID, executor=1, checkpoint=path, measure=killed_once)
    assert (tmp_path / "killed").exists()
    assert table.failures == []
    np.testing.assert_allclose(table["force_x"], mtb.sweep(paraboloid(), GRID)["force_x"], rtol=1e-12)
    assert len(set(table["pid"].ravel())) == 1


@pytest.mark.coarse
def test_a_case_that_kills_its_worker_is_recorded_and_stops_nobody(tmp_path, monkeypatch):
    path = tmp_path / "sweep.jsonl"
    table = mtb.sweep(paraboloid(), GRID, executor=2, checkpoint=path, measure=deadly)
    assert [case for case, _ in table.failures] == [
        {"friction": 0.3, "force": 5e6},
        {"friction": 0.5, "force": 5e6},
    ]
    assert all("its process ended twice" in reason for _, reason in table.failures)
    # what was lost is tried again when the sweep goes on
    monkeypatch.setenv("MTB_TEST_HEALED", "1")
    healed = mtb.sweep(paraboloid(), GRID, checkpoint=path, measure=deadly)
    assert healed.failures == []
    assert np.count_nonzero(healed["pid"] == 0) == 2


def test_the_command_line(tmp_path, capsys):
    case = tmp_path / "case.toml"
    case.write_text('scene = "paraboloid_on_plane"\npoints = 8\n', encoding="utf-8")
    command = [
        "sweep",
        str(case),
        "--vary",
        "friction=0.1:0.3:3",
        "--vary",
        "force=1e6,-1",
        "-o",
        str(tmp_path),
    ]
    assert main(command) == 0
    out = capsys.readouterr().out
    assert "3 of 6 cases solved" in out
    assert "friction = 0.1, force = -1: ValueError: force is -1.0" in out
    records = (tmp_path / "sweep.jsonl").read_text(encoding="utf-8").splitlines()
    assert sum(json.loads(line).get("status") == "solved" for line in records) == 3
    assert (tmp_path / "sweep.csv").exists()
    with pytest.raises(SystemExit):
        main(["sweep", str(case), "--vary", "friction"])
    assert main(["sweep", str(case), "--vary", "frction=1", "-o", str(tmp_path)]) == 2


USAGE = [
    (["--vary", "friction=0.1:0.2:0"], "a whole number from 1 on"),
    (["--vary", "friction=0.1:0.2:2.5"], "a whole number from 1 on"),
    (["--vary", "friction=0.1:0.2"], "a whole number from 1 on"),
    (["--vary", "friction=0.1:nan:3"], "two finite numbers"),
    (["--vary", "friction=0.1:0.5:1000000000000"], "to 1000000"),
    (["--vary", "friction=x,1e6"], "or all of them words"),
    (["--vary", "friction=0.1,"], "or all of them words"),
    (["--vary", "friction=0.1", "-j", "0"], "'0': a whole number from 1 on is needed"),
]


@pytest.mark.parametrize(("words", "message"), USAGE, ids=[" ".join(words) for words, _ in USAGE])
def test_usage_errors(words, message, tmp_path, capsys):
    with pytest.raises(SystemExit):
        main(["sweep", str(tmp_path / "case.toml"), *words])
    assert message in capsys.readouterr().err


def test_words_of_the_command_line(tmp_path, capsys):
    case = tmp_path / "case.toml"
    case.write_text('scene = "paraboloid_on_plane"\npoints = 6\n', encoding="utf-8")
    command = ["sweep", str(case), "-o", str(tmp_path), "--vary"]
    assert main([*command, "friction=a:b:c"]) == BAD_INPUT
    assert 'friction = "a:b:c": a number, a list' in capsys.readouterr().err
    assert main([*command, "friction=-0.1"]) == NO_SOLUTION
    assert "friction = -0.1: ValueError" in capsys.readouterr().out
    (tmp_path / "sweep.jsonl").unlink()
    assert main([*command, "friction=0.1"]) == 0
    assert main([*command, "friction=0.1", "--vary", "friction=0.2"]) == BAD_INPUT
    assert "--vary friction= is there twice" in capsys.readouterr().err
    assert main([*command, "friction=0.3"]) == BAD_INPUT
    assert "on the command line -o" in capsys.readouterr().err
    shoe = tmp_path / "shoe.toml"
    shoe.write_text('scene = "pole_shoe_on_rail"\nspacing = 1e-2\n[solve]\nmodel = "half-space"\n')
    assert main(["sweep", str(shoe), "-o", str(tmp_path / "shoe"), "--vary", "rail=60E1"]) == 0


def swept_by_command(tmp_path, text, *vary):
    """Rows of sweep.csv."""
    case, out = tmp_path / "case.toml", tmp_path / "out"
    case.write_text(text, encoding="utf-8")
    assert main(["sweep", str(case), "-o", str(out), *(w for v in vary for w in ("--vary", v))]) == 0
    with (out / "sweep.csv").open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def test_the_command_line_takes_values_as_case_files_do(tmp_path):
    paraboloid_of = 'scene = "paraboloid_on_plane"\n'
    rows = swept_by_command(tmp_path, paraboloid_of, "points=6:8:2", "lower=rigid")
    assert [(r["points"], r["lower"], r["status"]) for r in rows] == [
        ("6", "rigid", "solved"),
        ("8", "rigid", "solved"),
    ]
    shoe = 'scene = "pole_shoe_on_rail"\nspacing = 1e-2\n[solve]\nmodel = "half-space"\n'
    (tmp_path / "poles").mkdir()
    rows = swept_by_command(tmp_path / "poles", shoe, "poles=1,2", " magnetic_pressure = 1e6, 2e6")
    force = [float(r["normal_force [N]"]) for r in rows]
    assert force[2] == pytest.approx(2.0 * force[0], rel=1e-3)


def test_a_path_on_the_command_line_is_beside_the_case(tmp_path, capsys):
    y = np.linspace(-0.04, 0.04, 81)
    (tmp_path / "worn.csv").write_text("\n".join(f"{a},{-a * a / 0.6}" for a in y.tolist()) + "\n")
    shoe = 'scene = "pole_shoe_on_rail"\nspacing = 1e-2\n[solve]\nmodel = "half-space"\n'
    rows = swept_by_command(tmp_path, shoe, "rail=60E1,worn.csv")
    assert [r["rail"] for r in rows] == ["60E1", "worn.csv"]
    command = ["sweep", str(tmp_path / "case.toml"), "-o", str(tmp_path / "no"), "--vary"]
    assert main([*command, "rail=60E1,none.csv"]) == BAD_INPUT
    assert 'rail = "none.csv": there is no file' in capsys.readouterr().err
    assert main([*command, "poles=1.5"]) == BAD_INPUT
    assert "poles = 1.5: a valid integer is needed" in capsys.readouterr().err
    assert not (tmp_path / "no").exists()


@pytest.mark.coarse
def test_a_table_draws_its_lines():
    table = mtb.sweep(paraboloid(), {"friction": [0.3, 0.1], "force": [1e6, 5e6, -1.0]})
    axes = table.plot("peak_pressure").axes[0]
    assert axes.get_ylabel() == "peak pressure [MPa]"
    assert [t.get_text() for t in axes.get_legend().get_texts()] == [
        "force = 1e+06 N",
        "force = 5e+06 N",
        "force = -1 N",
    ]
    assert axes.lines[0].get_xdata().tolist() == [0.1, 0.3]
    np.testing.assert_allclose(axes.lines[1].get_ydata(), table["peak_pressure"][::-1, 1] / 1e6)
    assert np.isnan(axes.lines[2].get_ydata()).all()
    with pytest.raises(ValueError, match="quantity is 'pressure': one of force_x"):
        table.plot("pressure")
    with pytest.raises(ValueError, match="no case of the sweep is solved"):
        mtb.sweep(paraboloid(), {"friction": [-1.0]}).plot()
    labelled = mtb.sweep(paraboloid(), {"friction": {"wet": 0.1, "dry": 0.3}}).plot("force_x").axes[0]
    assert [t.get_text() for t in labelled.get_xticklabels()] == ["wet", "dry"]


@pytest.mark.coarse
def test_names_of_bodies_are_read_beside_their_pictures():
    rails = [mtb.Material(k * 1e10, 0.3) for k in (10, 15, 20)]
    for grid in ({"lower": rails}, {"friction": [0.1, 0.2], "lower": rails}):
        figure = mtb.sweep(paraboloid(), grid).plot("peak_pressure")
        figure.draw_without_rendering()
        (ax,) = figure.axes
        ticks = [t.get_window_extent() for t in ax.get_xticklabels() if t.get_text()]
        assert not any(a.overlaps(b) for a, b in itertools.pairwise(ticks))
        named = (
            [t.get_text() for t in ax.get_legend().get_texts()] if "friction" in grid else [ax.get_xlabel()]
        )
        for rail in rails:
            assert any(str(rail) in text for text in named)
        # all of it is in the picture, which keeps most of the place
        assert figure.bbox.containsx(figure.get_tightbbox().x1 * figure.dpi)
        assert ax.get_position().width > 0.6
        assert ax.get_position().height > 0.4


@pytest.mark.coarse
def test_netcdf_names_the_extra(monkeypatch, tmp_path):
    table = mtb.sweep(paraboloid(), {"friction": [0.1]})
    for package in ("h5netcdf", "xarray"):
        monkeypatch.setitem(sys.modules, package, None)
        with pytest.raises(ImportError, match=rf"{package} is missing: pip install 'mtb-rs\[sweep\]'"):
            table.to_netcdf(tmp_path / "sweep.nc")


@pytest.mark.coarse
def test_netcdf_keeps_labels_and_units(tmp_path):
    xarray = pytest.importorskip("xarray", reason="xarray (extra sweep) is not installed")
    pytest.importorskip("h5netcdf", reason="h5netcdf (extra sweep) is not installed")
    table = mtb.sweep(paraboloid(), {"friction": {"wet": 0.1, "dry": 0.4}, "force": [1e6, -1.0]})
    table.to_netcdf(tmp_path / "sweep.nc")
    with xarray.open_dataset(tmp_path / "sweep.nc", engine="h5netcdf") as data:
        assert data["force_x"].attrs["units"] == "N"
        assert float(data["force_x"].sel(friction="dry", force=1e6)) == table["force_x"][1, 0]
        assert str(data["status"].sel(friction="wet", force=-1.0).values).startswith("ValueError")
        assert data.attrs["model"] == "half-space"
        assert data["force"].attrs["units"] == "N"
        assert "units" not in data["friction"].attrs


def test_pictures_name_the_units_of_the_arguments():
    scene = mtb.scenes.block_on_plane(spacing=0.025, friction=0.1)
    loads = {"magnetic_pressure": [1e6, 3e6], "height": [0.05, 0.1], "friction": [0.1, 0.2]}
    ax = mtb.sweep(scene, loads, model="half-space").plot().axes[0]
    assert ax.get_xlabel() == "magnetic pressure [MPa]"
    np.testing.assert_allclose(ax.lines[0].get_xdata(), [1.0, 3.0])
    assert ax.lines[1].get_label() == "height = 50 mm, friction = 0.2"
    # numbers that stand for other values have no unit
    fields = mtb.sweep(scene, {"magnetic_pressure": {1.0: 1e6, 2.0: 3e6}}, model="half-space")
    assert "magnetic_pressure" not in fields.units
    assert fields.plot().axes[0].get_xlabel() == "magnetic pressure"


@pytest.mark.coarse
def test_netcdf_takes_all_labels_and_messages(tmp_path):
    xarray = pytest.importorskip("xarray", reason="xarray (extra sweep) is not installed")
    pytest.importorskip("h5netcdf", reason="h5netcdf (extra sweep) is not installed")

    def failing(result):
        raise OSError("no file \udcff\0 there")

    for values, labels in (
        ({"points": [8, 2**70]}, ["8", str(2**70)]),
        ({"friction": {"a": 0.1, 2: 0.2}}, ["a", "2"]),
        ({"approach": [1e-4, 2e-4]}, [1e-4, 2e-4]),
    ):
        scene = paraboloid() if "approach" not in values else paraboloid().with_(force=None, approach=1e-4)
        table = mtb.sweep(scene, values)
        table.to_csv(tmp_path / "sweep.csv")
        table.to_netcdf(tmp_path / "sweep.nc")
        with xarray.open_dataset(tmp_path / "sweep.nc", engine="h5netcdf") as data:
            assert data[next(iter(values))].values.tolist() == labels
            assert "force_x" in data
    table = mtb.sweep(paraboloid(), {"friction": [0.1]}, measure=failing)
    table.to_csv(tmp_path / "sweep.csv")
    table.to_netcdf(tmp_path / "sweep.nc")
    with xarray.open_dataset(tmp_path / "sweep.nc", engine="h5netcdf") as data:
        assert data["status"].values.tolist() == [r"OSError: no file \udcff\0 there"]


@pytest.mark.coarse
def test_dask_with_processes():
    distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed")
    options = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": None, "processes": True}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        table = mtb.sweep(paraboloid(), GRID, executor=client.get_executor())
    np.testing.assert_allclose(table["force_x"], mtb.sweep(paraboloid(), GRID)["force_x"], rtol=1e-12)


@pytest.mark.coarse
def test_joblib_with_processes():
    pytest.importorskip("joblib", reason="joblib is not installed")
    from joblib.externals.loky import get_reusable_executor

    with get_reusable_executor(max_workers=1) as executor:
        table = mtb.sweep(paraboloid(), GRID, executor=executor)
    np.testing.assert_allclose(table["force_x"], mtb.sweep(paraboloid(), GRID)["force_x"], rtol=1e-12)


BAD = [
    ({}, "parameters is empty"),
    ({"frction": [1]}, "'frction' is no argument of the scene"),
    ({"friction": []}, "friction has no values"),
    ({"friction": 0.1}, "friction is 0.1: a list of values is needed"),
    ({"friction": "0.1"}, "friction is '0.1': a list of values is needed"),
    ({"friction": {0.1, 0.2}}, "a list of values is needed"),
    ({"friction": [0.1, 0.1]}, "friction has a value twice"),
    ({"friction": {(1, 2): 0.1}}, r"friction has labels \[\(1, 2\)\]: numbers or text are needed"),
    ({"friction": {"a\0b": 0.1}}, r"friction has the label 'a\\x00b': text that can be written"),
    ({"friction": {"\ud800": 0.1}}, "text that can be written is needed"),
    ({"friction": range(1001), "force": range(1000)}, "at most 1000000 are solved at once"),
    (["friction"], "a mapping from arguments to their values is needed"),
]


@pytest.mark.parametrize(("parameters", "message"), BAD, ids=[message for _, message in BAD])
def test_bad_input_is_named(parameters, message):
    with pytest.raises(ValueError, match=message):
        mtb.sweep(paraboloid(), parameters)


@pytest.mark.parametrize("scene", [None, mtb.steel, "paraboloid_on_plane"])
def test_what_is_no_scene_is_named(scene):
    with pytest.raises(ValueError, match="a Scene is needed"):
        mtb.sweep(scene, {"friction": [0.1]})


OPTIONS = [
    ({"model": "half"}, "model is 'half': one of"),
    ({"modle": "auto"}, "unknown option 'modle' of the direct method"),
    ({"method": "staggered", "steps": 3}, "unknown option 'steps' of the staggered method: it has"),
    ({"tolerance": 2.0}, "a number between 0 and 1"),
    ({"measure": 3}, "measure is 3: a function is needed"),
    ({"progress": 3}, "progress is 3: a function is needed"),
]


@pytest.mark.parametrize(("options", "message"), OPTIONS, ids=[message for _, message in OPTIONS])
def test_an_option_that_no_case_takes_is_refused_at_once(options, message):
    with pytest.raises(ValueError, match=message):
        mtb.sweep(paraboloid(), {"friction": [0.1]}, **options)


MEASURES = [
    (3, "measure returned 3: a mapping"),
    ({"status": 1.0}, "'status': the sweep has such a column already"),
    ({"friction": 1.0}, "'friction': the sweep has such a column"),
    ({"force_x": 1.0}, "'force_x': the sweep has such a column"),
    ({"a/b": 1.0}, "'a/b' is no name of a column"),
    ({"": 1.0}, "'' is no name of a column"),
    ({3: 1.0}, "3 is no name of a column"),
    ({"a": "1"}, "measure returned a = '1': a number is needed"),
    ({"a": [1.0]}, r"measure returned a = \[1.0\]: a number is needed"),
]


@pytest.mark.parametrize(("returned", "message"), MEASURES, ids=[message for _, message in MEASURES])
def test_a_measure_returns_new_columns(returned, message):
    table = mtb.sweep(paraboloid(), {"friction": [0.1]}, measure=lambda _: returned)
    with pytest.raises(AssertionError, match=message):
        raise AssertionError(table.status[0])
    assert table.columns == {}


@pytest.mark.parametrize("executor", ["x", 0, -1, 1.5, True])
def test_an_executor_that_is_none_is_named(executor):
    with pytest.raises(ValueError, match=f"executor is {executor!r}: "):
        mtb.sweep(paraboloid(), {"friction": [0.1]}, executor=executor)


def test_a_checkpoint_is_a_file(tmp_path):
    with pytest.raises(ValueError, match="it is a directory, a file is needed"):
        mtb.sweep(paraboloid(), {"friction": [0.1]}, checkpoint=tmp_path)


@pytest.mark.coarse
def test_cases_of_a_list_are_solved_one_by_one(tmp_path):
    scene = paraboloid().with_(force=2e6)
    cases = [{"friction": 0.1}, {"friction": 0.3, "force": 1e6}, {"force": None, "approach": 1e-4}]
    table = mtb.sweep(scene, cases, checkpoint=tmp_path / "kept.jsonl")
    assert table.parameters == {"case": (1, 2, 3)}
    for k, case in enumerate(cases):
        alone = scene.with_(**case).solve()
        assert table["force_x"][k] == alone.force[0]
        assert table["approach"][k] == pytest.approx(np.mean(alone.approach))
    # what a case leaves out is the scene's own
    np.testing.assert_array_equal(table["force"][:2], [2e6, 1e6])
    np.testing.assert_array_equal(table["friction"], [0.1, 0.3, scene.inputs["friction"]])
    table.save(tmp_path / "out")
    assert mtb.load(tmp_path / "out") == table
    solved = len((tmp_path / "kept.jsonl").read_text().splitlines())
    mtb.sweep(scene, cases, checkpoint=tmp_path / "kept.jsonl")
    assert len((tmp_path / "kept.jsonl").read_text().splitlines()) == solved
    with pytest.raises(ValueError, match="checkpoint"):
        mtb.sweep(scene, cases[::-1], checkpoint=tmp_path / "kept.jsonl")


@pytest.mark.parametrize(
    ("cases", "said"),
    [
        ([], "parameters has no cases"),
        ([{}], "parameters has no cases"),
        ([{"friction": 0.1}, 3], "case 2 of parameters is 3: a mapping"),
        ([{"friction": 0.1}, {"frictoin": 0.1}], "'frictoin' is no argument of the scene: did you mean"),
        (7, "parameters is 7: a mapping from arguments to their values, or a list of cases, is needed"),
    ],
)
def test_lists_that_make_no_cases_are_refused(cases, said):
    with pytest.raises(ValueError, match=said):
        mtb.sweep(paraboloid(), cases)


def asking(result: mtb.Result) -> dict[str, float]:
    """Warns as cases do, with other numbers in each."""
    ask([f"the force is {result.normal_force:.3g} N", "always the same"])
    return {}


@pytest.mark.parametrize("executor", [None, 1])
def test_what_cases_are_asked_is_told_once(executor: int | None, tmp_path: Path) -> None:
    scene, forces = paraboloid(), [1.0, 2.0, 3.0]
    for _ in range(2):  # from the checkpoint, too
        with pytest.warns(UserWarning, match="always|force") as told:
            mtb.sweep(
                scene,
                {"force": forces},
                executor=executor,
                measure=asking,
                checkpoint=tmp_path / "c.jsonl",
                tolerance=0.9,
            )
        texts = sorted(str(w.message) for w in told)
        assert len(texts) == 2
        assert texts[0] == "always the same"
        assert texts[1].startswith("the force is 1 N (3 of 3 cases, with other numbers in each")


def test_a_sweep_tells_the_range_of_every_column() -> None:
    table = mtb.sweep(paraboloid(), {"force": [1.0, 2.0, -1.0]}, tolerance=0.9)
    told = table.told()
    rows = dict(told)
    assert rows["force"] == "3 values, -1 to 2 N"
    assert rows["normal force"] == "1 to 2 N"
    assert rows["contact area"].endswith(" m^2")
    assert rows["solved"] == "2 of 3 cases"
    assert rows["not solved"].startswith("force = -1.0: ValueError: force is -1")
    labels = mtb.sweep(paraboloid(), {"friction": {"dry": 0.1, "wet": 0.05}}, tolerance=0.9).told()
    assert dict(labels)["friction"] == "2 values: dry, wet"

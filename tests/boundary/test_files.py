# SPDX-License-Identifier: MIT OR Apache-2.0
"""The one way in and out of files: full disks, killed writers, foreign files, pipes and devices."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.base import cache, files
from mtb_rs.base.files import DRAFT, check_folder, read_arrays, read_bytes, write_bytes
from mtb_rs.commands import main

resource = pytest.importorskip(
    "resource", reason="file sizes are limited and processes signalled as on POSIX"
)

CASE = """
scene = "block_on_plane"
spacing = 2e-2
friction = 0.1
[solve]
model = "half-space"
"""


@pytest.fixture(scope="module")
def result() -> mtb.Result:
    return mtb.scenes.block_on_plane(friction=0.1, spacing=2e-2).solve("half-space")


def python(program: str, *arguments: object, **options: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", program, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=300, **options)


def command_line(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "mtb_rs", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)


#: Each thing that is written, on a disk that takes no file above 2 kB. HDF5 and VTK end a process that
#: writes there by a signal.
FULL = """
import resource, sys, warnings
from pathlib import Path
import numpy as np
import mtb_rs as mtb
from mtb_rs.results.chart import Chart, ChartPoint
from mtb_rs.pictures.space import missing_for_view
warnings.simplefilter("ignore")
place = Path(sys.argv[1])
scene = mtb.scenes.block_on_plane(friction=0.1, spacing=2e-2)
result = scene.solve("half-space")
contact = scene.prepare("half-space")
table = mtb.sweep(scene, {"friction": np.linspace(0.05, 0.1, 40)}, model="half-space")
scale = np.linspace(0.0, 0.95, 4)
creep = mtb.CreepForceTable(0.28, np.ones(1), scale, np.random.default_rng(1).random((1, 4, 7, 4, 3)), 8)
writers = {
    "result": lambda path: result.save(path),
    "a.csv": table.to_csv,
    "a.mtbc": contact.save,
    "a.npz": creep.save,
    "a.gif": lambda path: mtb.animate([result, result], path),
}
try:
    import h5netcdf
    writers["a.nc"] = table.to_netcdf
except ImportError:
    pass
try:
    import trame_pyvista, nest_asyncio2
    if missing_for_view() is None:
        writers["a.html"] = lambda path: mtb.write_html(result, path)
except ImportError:
    pass
whole = place / "whole"
for name, write in writers.items():
    write(whole / name)
earlier = {p: p.read_bytes() for p in whole.rglob("*") if p.is_file()}
resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
for name, write in writers.items():
    for folder in (place / "new", whole):
        try:
            write(folder / name)
        except OSError as error:
            print(name, "|", error)
        else:
            print(name, "was written")
assert earlier == {p: p.read_bytes() for p in whole.rglob("*") if p.is_file()}
try:
    values = {"friction": np.linspace(0.05, 0.1, 40)}
    mtb.sweep(scene, values, checkpoint=place / "a.jsonl", model="half-space")
except OSError as error:
    print("checkpoint", "|", error)
"""


@pytest.mark.slow
def test_a_full_disk_ends_in_a_sentence_and_leaves_nothing(tmp_path: Path) -> None:
    done = python(FULL, tmp_path)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) >= 11
    for line in lines:
        name, _, sentence = line.partition(" | ")
        assert sentence.startswith(f"nothing can be written to {tmp_path}"), line
        assert sentence.endswith(("File too large", "No space left on device")), name
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.jsonl", "whole"]
    # nothing but whole lines: the next sweep goes on from them
    kept = (tmp_path / "a.jsonl").read_bytes()
    assert 1 < kept.count(b"\n") < 41
    assert kept.endswith(b"\n")


KILLED = """
import os, signal, sys
from mtb_rs.base.files import write_bytes
os.fsync = lambda _: os.kill(os.getpid(), signal.SIGKILL)
write_bytes(sys.argv[1], b"x" * 1000)
"""
WAITING = """
import sys
from pathlib import Path
from mtb_rs.base.files import drafted
with drafted(Path(sys.argv[1])) as draft:
    draft.write("a", b"a")
    print("written", flush=True)
    sys.stdin.read()
    draft.move("a")
"""


def test_drafts_of_killed_writers_are_cleared_by_the_next(tmp_path: Path) -> None:
    assert python(KILLED, tmp_path / "a").returncode == -signal.SIGKILL
    left = [p.name for p in tmp_path.iterdir()]
    assert len(left) == 1
    assert left[0].startswith(DRAFT)
    (tmp_path / ".mtb-rs-drafts").mkdir()
    (tmp_path / f"{DRAFT}notes").write_text("no draft: a file")
    write_bytes(tmp_path / "b", b"b")
    assert {p.name for p in tmp_path.iterdir()} == {"b", ".mtb-rs-drafts", f"{DRAFT}notes"}


def test_drafts_of_living_writers_stay(tmp_path: Path) -> None:
    command = [sys.executable, "-c", WAITING, str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "written\n"
        write_bytes(tmp_path / "b", b"b")
        other.communicate("")
    assert other.returncode == 0
    assert {p.name for p in tmp_path.iterdir()} == {"a", "b"}


def test_links_and_what_is_no_file_stay(tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    (tmp_path / "far" / "a").write_bytes(b"old")
    (tmp_path / "link").symlink_to(tmp_path / "far" / "a")
    write_bytes(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "far" / "a").read_bytes() == b"new"
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ValueError, match="pipe: it is a pipe or a device, a regular file is needed"):
        write_bytes(tmp_path / "pipe", b"new")
    with pytest.raises(ValueError, match="far: it is a directory, a file is needed"):
        write_bytes(tmp_path / "far", b"new")


# --- whose files these are -------------------------------------------------------------------------------

FOREIGN = (
    {"files": ["thesis.docx"]},
    {"files": ["thesis.docx", "fields.npz"], "mtb_rs": 1},
    ["thesis.docx"],
    "thesis.docx",
    {"mtb_rs": "1.0"},
)


@pytest.mark.parametrize("summary", FOREIGN)
def test_a_summary_of_another_program_is_not_replaced(
    summary: object, result: mtb.Result, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "thesis.docx").write_text("years of work")
    (out / "summary.json").write_text(json.dumps(summary))
    with pytest.raises(ValueError, match=r"summary\.json is there already and was not written by mtb_rs"):
        result.save(out)
    (tmp_path / "case.toml").write_text(CASE)
    assert main(["run", str(tmp_path / "case.toml"), "-o", str(out)]) == 2
    captured = capsys.readouterr()
    assert captured.err.count("\n") == 1
    # told before it was solved
    assert captured.out == ""
    assert (out / "thesis.docx").read_text() == "years of work"
    assert json.loads((out / "summary.json").read_text()) == summary
    assert len(list(out.iterdir())) == 2


def test_only_names_of_results_are_removed_or_replaced(result: mtb.Result, tmp_path: Path) -> None:
    kept = tmp_path / "thesis.docx"
    kept.write_text("years of work")
    listed = [
        "thesis.docx",
        "../above.txt",
        str(kept),
        "body_../x.vtp",
        ["fields.npz"],
        None,
        ".",
        "body_old.vtp",
    ]
    (tmp_path / "summary.json").write_text(json.dumps({"mtb_rs": "0.1.0", "files": listed}))
    (tmp_path / "body_old.vtp").write_text("of an earlier result")
    (tmp_path.parent / "above.txt").write_text("above")
    result.save(tmp_path)
    assert kept.read_text() == "years of work"
    assert (tmp_path.parent / "above.txt").exists()
    assert not (tmp_path / "body_old.vtp").exists()


def test_a_file_that_no_result_lists_is_not_replaced(result: mtb.Result, tmp_path: Path) -> None:
    (tmp_path / "pressure.png").write_text("a picture of my own")
    with pytest.raises(ValueError, match=r"pressure\.png is there already and was not written"):
        result.save(tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["pressure.png"]


def test_a_save_that_was_stopped_can_be_repeated(
    result: mtb.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result.save(tmp_path)
    moved = []

    def stop(draft: files.Draft, name: str, new: str | None = None) -> None:
        moved.append(name)
        if len(moved) > 4:
            raise KeyboardInterrupt
        os.replace(draft._place / name, draft._target / (new or name))

    with monkeypatch.context() as patched:
        patched.setattr(files.Draft, "move", stop)
        with pytest.raises(KeyboardInterrupt):
            result.save(tmp_path)
    assert json.loads((tmp_path / "summary.json").read_text())["is_complete"] is False
    result.save(tmp_path)
    assert json.loads((tmp_path / "summary.json").read_text())["result"] == "Result"


@pytest.mark.parametrize("name", ["...toml", "..toml"])
def test_a_case_file_of_dots_does_not_name_the_folder_above(name: str, tmp_path: Path) -> None:
    inner = tmp_path / "inner"
    inner.mkdir()
    (inner / name).write_text(CASE)
    for command in (["run"], ["chart", "--budget", "1"], ["sweep", "--vary", "friction=0.1"]):
        done = subprocess.run(
            [sys.executable, "-m", "mtb_rs", *command, name],
            cwd=inner, capture_output=True, text=True, check=False, timeout=300,
        )  # fmt: skip
        assert done.returncode == 2
        assert "-o DIR" in done.stderr
        assert done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == [inner]
    assert [p.name for p in inner.iterdir()] == [name]


# --- what is read -------------------------------------------------------------------------------------


def readers(tmp_path: Path) -> dict[str, object]:
    """Everything that reads a file, as a function of its path."""

    def case_with(line: str) -> object:
        def read(path: Path) -> None:
            case = tmp_path / "naming.toml"
            case.write_text(CASE.replace("friction = 0.1\n", line.format(json.dumps(str(path)))))
            mtb.load_case(case)

        return read

    scene = mtb.scenes.block_on_plane(friction=0.1, spacing=2e-2)
    return {
        "case": mtb.load_case,
        "friction": case_with("friction = {{ file = {} }}\n"),
        "profile": mtb.Profile.from_file,
        "rail": lambda path: mtb.scenes.pole_shoe_on_rail(rail=mtb.Profile.from_file(path)),
        "contact": mtb.PreparedContact.load,
        "wheels": mtb.PreparedWheels.load,
        "creep forces": mtb.CreepForceTable.load,
        "checkpoint": lambda path: mtb.sweep(scene, {"friction": [0.1]}, checkpoint=path, model="half-space"),
        "STL": lambda path: mtb.ElasticBody.from_mesh(path, mtb.steel, size=0.01, supports="bottom"),
        "STEP": lambda path: mtb.ElasticBody.from_mesh(path, mtb.steel, size=0.01, supports="bottom"),
        "mesh": lambda path: mtb.ElasticBody.from_mesh(path, mtb.steel, supports="bottom"),
    }


ENDINGS = {"creep forces": ".npz", "STL": ".stl", "STEP": ".step", "mesh": ".vtu"}


@pytest.mark.parametrize("kind", ["pipe", "zeros", "huge", "directory"])
def test_only_regular_files_of_sane_size_are_read(kind: str, tmp_path: Path) -> None:
    signal.alarm(120)  # a pipe would be waited for, for ever
    try:
        for name, read in readers(tmp_path).items():
            path = tmp_path / (name.replace(" ", "_") + ENDINGS.get(name, ""))
            if kind == "pipe":
                os.mkfifo(path)
            elif kind == "zeros":
                path.symlink_to("/dev/zero")
            elif kind == "directory":
                path.mkdir()
            else:
                with path.open("wb") as stream:
                    stream.truncate(10**12)
            with pytest.raises(ValueError, match=path.name):
                read(path)
    finally:
        signal.alarm(0)


def test_bytes_are_read_up_to_a_bound(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"12345")
    assert read_bytes(path, most=5) == b"12345"
    with pytest.raises(ValueError, match=r"file .*a cannot be read: it has 5 bytes: at most 4 are read"):
        read_bytes(path, most=4)
    with pytest.raises(FileNotFoundError, match="No such file"):
        read_bytes(tmp_path / "b")


def test_arrays_that_unpack_to_more_than_is_read_are_refused(tmp_path: Path) -> None:
    np.savez_compressed(tmp_path / "a.npz", zeros=np.zeros(10**6))
    content = (tmp_path / "a.npz").read_bytes()
    assert len(content) < 10_000
    with pytest.raises(ValueError, match=r"its arrays take 8e\+06 bytes: at most 1e\+06 are read"):
        read_arrays(content, most=10**6)
    for damaged in (b"", b"PK", content[:-9], content[:200] + b"\xff" * 50 + content[250:]):
        with pytest.raises(ValueError):  # noqa: PT011 (any sentence)
            read_arrays(damaged)


# --- caches, which are trusted, but not blindly -------------------------------------------------------------


@pytest.fixture
def cached(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, float]:
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path / "cache"))
    cache.forget()
    force = mtb.scenes.block_on_plane(friction=0.1, spacing=2e-2).solve("elastic-upper").normal_force
    return tmp_path / "cache", force


def forged(path: Path, changed: dict[str, object]) -> None:
    """Puts other arrays into a file of the cache, with the right sum."""
    content = path.read_bytes()
    arrays = read_arrays(content[len(cache._HEADER) + 65 :])
    del arrays["key"]
    for name, value in changed.items():
        if value is None:
            del arrays[name]
        else:
            arrays[name] = value  # type: ignore[assignment]
    cache._write(path.parent, path.stem, arrays)


@pytest.mark.parametrize(
    "changed",
    [
        {"flexibility": None},
        {"weights": np.zeros(3)},
        {"weights": np.array(["a"])},
        {"further": np.zeros(3)},
        {"mode_names": np.array(3)},
        {"cost": np.zeros(2)},
        {"case_work": np.full((1, 2), np.nan)},
    ],
)
def test_crafted_files_of_the_cache_are_rebuilt(
    changed: dict[str, object], cached: tuple[Path, float]
) -> None:
    folder, force = cached
    for path in folder.iterdir():
        forged(path, changed)
    cache.forget()
    assert mtb.scenes.block_on_plane(friction=0.1, spacing=2e-2).solve("elastic-upper").normal_force == force


def test_pipes_in_the_cache_are_not_waited_for(cached: tuple[Path, float]) -> None:
    folder, force = cached
    for path in list(folder.iterdir()):
        path.unlink()
        os.mkfifo(path)
    cache.forget()
    assert mtb.scenes.block_on_plane(friction=0.1, spacing=2e-2).solve("elastic-upper").normal_force == force


def test_a_user_without_a_home_keeps_results_in_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in (cache.VARIABLE, "HOME", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    import pwd

    def unknown(_: object) -> object:
        raise KeyError("no such user")

    monkeypatch.setattr(pwd, "getpwuid", unknown)
    monkeypatch.setattr(pwd, "getpwnam", unknown)
    assert cache.folder() is None
    monkeypatch.setenv("XDG_CACHE_HOME", "/somewhere")
    assert cache.folder() == Path("/somewhere/mtb_rs")
    monkeypatch.setenv(cache.VARIABLE, "~nobody12/cache")
    with pytest.raises(
        ValueError, match="MTB_RS_CACHE is '~nobody12/cache': there is no such home directory"
    ):
        cache.folder()


def test_places_that_cannot_be_written_are_known_at_once(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert check_folder(tmp_path / "new" / "deep") == tmp_path / "new" / "deep"
    assert [p.name for p in tmp_path.iterdir()] == ["file"]
    with pytest.raises(OSError, match=r"nothing can be written to .*: Not a directory"):
        check_folder(tmp_path / "file" / "out")
    if Path("/proc/self").exists():
        with pytest.raises(OSError, match="nothing can be written to /proc/out"):
            check_folder("/proc/out")

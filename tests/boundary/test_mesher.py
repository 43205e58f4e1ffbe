# SPDX-License-Identifier: MIT OR Apache-2.0
"""gmsh beside the process: what ends it, ends nothing else."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesher import GmshError, gmsh_beside

pytest.importorskip("gmsh")


def block_step(path: Path) -> Path:
    with gmsh_beside() as gmsh:
        gmsh.option.setString("Geometry.OCCTargetUnit", "M")
        gmsh.model.occ.addBox(-0.02, -0.01, 0.0, 0.04, 0.02, 0.02)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    return path


def test_answers_and_errors_come_back() -> None:
    with gmsh_beside() as gmsh:
        tag = gmsh.model.addDiscreteEntity(2)
        gmsh.model.mesh.addNodes(2, tag, np.arange(1, 4), np.eye(3).ravel())
        gmsh.model.mesh.addElementsByType(tag, 2, [], np.arange(1, 4))
        tags, places, _ = gmsh.model.mesh.getNodes()
        np.testing.assert_array_equal(places.reshape(-1, 3)[np.argsort(tags)], np.eye(3))
        with pytest.raises(GmshError, match="NoSuchOption"):
            gmsh.option.setNumber("Mesh.NoSuchOption", 1)
        with pytest.raises(GmshError, match="no attribute"):
            gmsh.no_such_function()
    assert "gmsh" not in sys.modules or not sys.modules["gmsh"].isInitialized()


@pytest.mark.skipif(os.name != "posix", reason="signals are those of POSIX")
def test_a_file_that_ends_gmsh_by_a_signal_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = block_step(tmp_path / "block.step")
    body = mtb.ElasticBody.from_mesh(path, mtb.steel, size=0.01)
    assert len(body.mesh.cells)
    # a module in gmsh's place whose reader ends the process, as OpenCASCADE can on a damaged file
    (tmp_path / "gmsh.py").write_text(
        "import os, signal\n"
        "class Any:\n"
        "    def __getattr__(self, name): return Any()\n"
        "    def __call__(self, *_, **__): pass\n"
        "class Occ(Any):\n"
        "    def importShapes(self, path): os.kill(os.getpid(), signal.SIGSEGV)\n"
        "initialize = option = Any()\n"
        "model = Any()\n"
        "model.occ = Occ()\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(
        ValueError, match=r"block\.step cannot be read: .*gmsh ended by signal 11 \(SIGSEGV\)"
    ):
        mtb.ElasticBody.from_mesh(path, mtb.steel, size=0.01)


def test_many_changed_files_are_read_or_refused(tmp_path: Path) -> None:
    content = block_step(tmp_path / "block.step").read_bytes()
    rng = np.random.default_rng(1)
    for _ in range(8):
        changed = np.frombuffer(content, dtype=np.uint8).copy()
        at = rng.integers(len(changed), size=rng.integers(1, 20))
        changed[at] = rng.integers(256, size=at.size)
        path = tmp_path / "changed.step"
        path.write_bytes(changed.tobytes())
        said = "changed.step"
        try:
            mtb.ElasticBody.from_mesh(path, mtb.steel, size=0.01)
        except ValueError as error:
            said = str(error)
        assert "changed.step" in said


HANGING = """
import sys
from mtb_rs.bodies.mesher import gmsh_beside
with gmsh_beside() as gmsh:
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.003)
    print("meshing", flush=True)
    gmsh.model.mesh.generate(3)
"""


def children(pid: int) -> list[int]:
    return [int(p) for p in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def lives(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="processes are listed as on Linux")
@pytest.mark.parametrize("which", [signal.SIGINT, signal.SIGKILL])
def test_the_process_ends_with_the_one_that_asks(which: signal.Signals) -> None:
    command = [sys.executable, "-c", HANGING]
    # a shell that starts tests in the background leaves SIGINT ignored
    restored = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    command[2] = restored + HANGING
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as asking:
        assert asking.stdout is not None
        assert asking.stdout.readline() == "meshing\n"
        (mesher,) = children(asking.pid)
        timer = threading.Timer(60.0, asking.kill)
        timer.start()
        asking.send_signal(which)
        asking.wait()
        timer.cancel()
    assert asking.returncode == -which
    until = time.monotonic() + 30.0
    while lives(mesher) and time.monotonic() < until:
        time.sleep(0.05)
    assert not lives(mesher)

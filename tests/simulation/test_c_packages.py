# SPDX-License-Identifier: MIT OR Apache-2.0
"""The C library installs itself for CMake and pkg-config, and its header is for old compilers as well."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import mtb_rs as mtb

pytestmark = pytest.mark.slow  # builds the library and programs

ROOT = Path(__file__).parents[2]
CAPI = ROOT / "rust" / "capi"
CONSUMER = """
cmake_minimum_required(VERSION 3.20)
project(ride LANGUAGES C)
find_package(mtb REQUIRED)
foreach(kind IN ITEMS mtb static)
    add_executable(ride_${kind} "%s")
    target_link_libraries(ride_${kind} PRIVATE mtb::${kind} m)
endforeach()
"""


def program(name: str) -> str:
    beside = Path(sys.executable).parent / name
    found = str(beside) if beside.exists() else shutil.which(name)
    if found is None:
        pytest.skip(f"{name} is not installed")
    return found


def run(*command: str | Path, **environment: str) -> str:
    done = subprocess.run(
        [str(word) for word in command],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize(("compiler", "standard"), [("gcc", "c90"), ("gcc", "c17"), ("g++", "c++98")])
def test_the_header_is_taken_by_old_and_new_compilers(compiler: str, standard: str, tmp_path: Path) -> None:
    source = tmp_path / ("one.c" if compiler == "gcc" else "one.cpp")
    source.write_text(
        '#include "mtb.h"\nmtb_status ended(void);\nmtb_status ended(void) { return MTB_STATUS_OK; }\n'
    )
    flags = [f"-std={standard}", "-pedantic-errors", "-Wall", "-Wextra", "-Werror", f"-I{CAPI / 'include'}"]
    run(program(compiler), *flags, "-c", source, "-o", tmp_path / "one.o")


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The library, installed by CMake."""
    cmake, _ = program("cmake"), program("cargo")
    build, prefix = tmp_path_factory.mktemp("build"), tmp_path_factory.mktemp("installed")
    target = os.environ.get("CARGO_TARGET_DIR", str(ROOT / "target"))
    run(cmake, "-S", CAPI, "-B", build, f"-DCARGO_TARGET_DIR={target}", "-DCMAKE_INSTALL_LIBDIR=lib")
    run(cmake, "--build", build)
    run(cmake, "--install", build, "--prefix", prefix)
    return prefix


@pytest.fixture(scope="module")
def shoe(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("contact") / "shoe.mtbc"
    scene = mtb.scenes.pole_shoe_on_rail(friction=0.3, spacing=8e-3)
    scene.prepare("half-space", reference_point=(0.0, 0.0, 28.2e-3)).save(path)
    return path


def test_find_package_links_shared_and_static(installed: Path, shoe: Path, tmp_path: Path) -> None:
    (tmp_path / "CMakeLists.txt").write_text(CONSUMER % (CAPI / "examples" / "ride.c").as_posix())
    run(program("cmake"), "-S", tmp_path, "-B", tmp_path / "build", f"-DCMAKE_PREFIX_PATH={installed}")
    run(program("cmake"), "--build", tmp_path / "build")
    rides = [run(tmp_path / "build" / f"ride_{kind}", shoe) for kind in ("mtb", "static")]
    assert rides[0] == rides[1]
    assert len(rides[0].splitlines()) > 20


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads a program of ELF")
def test_pkg_config_knows_it_and_programs_find_it(installed: Path, shoe: Path, tmp_path: Path) -> None:
    where = {"PKG_CONFIG_PATH": str(installed / "lib" / "pkgconfig")}
    assert run(program("pkg-config"), "--modversion", "mtb", **where).strip() == mtb.__version__
    flags = run(program("pkg-config"), "--cflags", "--libs", "mtb", **where).split()
    ride = tmp_path / "ride"
    posix = "-D_POSIX_C_SOURCE=200809L"
    run(program("gcc"), posix, CAPI / "examples" / "ride.c", *flags, "-lm", "-o", ride)
    major, minor, _ = mtb.__version__.split(".")
    name = f"libmtb_capi.so.{major}" if major != "0" else f"libmtb_capi.so.0.{minor}"
    needed = re.findall(r"\[(libmtb_capi[^\]]*)\]", run(program("readelf"), "-d", ride))
    assert needed == [name]
    chain = [installed / "lib" / f"libmtb_capi.so{end}" for end in ("", name[14:], f".{mtb.__version__}")]
    assert [link.is_symlink() for link in chain] == [True, True, False]
    assert len({link.resolve() for link in chain}) == 1
    rides = [run(ride, shoe, LD_LIBRARY_PATH=str(installed / "lib"))]
    # what cargo built serves the same program
    built = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
    rides.append(run(ride, shoe, LD_LIBRARY_PATH=str(built)))

    flags = run(program("pkg-config"), "--cflags", "--libs", "mtb-static", **where).split()
    run(program("gcc"), posix, CAPI / "examples" / "ride.c", *flags, "-o", ride)
    assert "libmtb_capi" not in run(program("readelf"), "-d", ride)
    rides.append(run(ride, shoe))
    assert len(rides[0].splitlines()) > 20
    assert rides == 3 * rides[:1]


def test_what_a_program_in_fortran_needs_is_installed(installed: Path, shoe: Path, tmp_path: Path) -> None:
    """By the standard of 2008 alone, from the installed files alone."""
    where = {"PKG_CONFIG_PATH": str(installed / "lib" / "pkgconfig")}
    flags = run(program("pkg-config"), "--libs", "mtb-static", **where).split()
    share, documents = installed / "share" / "mtb", installed / "share" / "doc" / "mtb"
    standard = ["-std=f2008", "-Wall", "-pedantic", f"-J{tmp_path}"]
    for name in ("ride", "wheelset"):
        sources = [share / "mtb.f90", share / "examples" / f"{name}.f90"]
        run(program("gfortran"), *standard, *sources, *flags, "-o", tmp_path / name)
        assert (share / "examples" / f"{name}.c").exists()
    assert len(run(tmp_path / "ride", shoe).splitlines()) > 20
    assert {path.name for path in documents.iterdir()} >= {"LICENSE-MIT", "LICENSE-APACHE", "README.md"}

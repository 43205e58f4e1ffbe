# SPDX-License-Identifier: MIT OR Apache-2.0
"""``mtb-rs demo``, ``init``, ``schema``: a first result, a case file to start from, help for editors."""

from __future__ import annotations

import argparse
import json
import os
import shlex
import sys
import textwrap
import time
import webbrowser
from pathlib import Path

from ..base.files import check_folder
from .console import console_on, print_report

#: The schema of case files, beside a case file: editors that know TOML complete and check its words by it.
SCHEMA = "case.schema.json"
#: The case files that ``mtb-rs init`` writes, by their words on the command line.
CASES = {
    "shoe": """
        # A pole shoe of a magnetic track brake slides over a rail.
        # SI units: m, Pa, N, rad. A # before a key: this is its default.

        scene = "pole_shoe_on_rail"
        magnetic_pressure = 3e6        # [Pa] of the nominal area; [3e6, 2e6] for the left and the right pole
        friction = 0.3                 # [-] a number, or a table: see `mtb-rs init braking`
        spacing = 3e-3                 # [m] size of the contact cells; leave it out for 3 mm
        # sliding_direction = [1, 0]   # of the shoe over the rail
        # lateral = 0.0                # [m] offset of the shoe to the left
        # yaw = 0.0                    # [rad]

        # the shoe
        # height = 28.2e-3             # [m] of its flat top above the crown of the rail
        # length = 90e-3               # [m] along the rail
        # inner_edge = 6e-3            # [m] |y| of the edges of each pole
        # outer_edge = 36e-3           # [m]
        # conforming_to = 21.6e-3      # [m] the sole follows the rail up to this |y| ...
        # relief_slope = 0.02          # [-] ... and rises from there with this slope
        # poles = 2
        # supports = "driven-top"      # or "clamped-top", "points", "fixed-points"

        # the rail
        # rail = "60E1"                # or the path of a measured profile
        # rail_length = 0.18           # [m]
        # attraction = "upper"         # "both": the rail is attracted as well

        [upper]                        # material of the shoe
        young_modulus = 208e9          # [Pa]; or shear_modulus
        poisson_ratio = 0.3

        [lower]                        # material of the rail; or lower = "rigid", above the tables
        young_modulus = 208e9
        poisson_ratio = 0.3

        [solve]
        # model = "auto"               # or "half-space", "elastic-upper", "elastic-both"
        # tolerance = 0.05             # what "auto" aims at: relative error ...
        # quantity = "pressure"        # ... of "pressure", "force" or "displacement"
        """,
    "wheel": """
        # A wheel is pressed on a rail.
        # SI units: m, Pa, N, rad. A # before a key: this is its default.

        scene = "wheel_on_rail"
        force = 60e3                   # [N] vertical
        lateral = 0.0                  # [m] shift of the wheelset towards flange contact
        spacing = 0.4e-3               # [m] size of the contact cells

        # wheel = "S1002"              # or the path of a measured profile
        # rail = "60E1"
        # wheel_radius = 0.46          # [m] at the tape circle
        # gauge = 1.435                # [m]
        # rail_inclination = 0.025     # [rad]; 0 for profiles that have it in

        [upper]                        # material of the wheel
        young_modulus = 208e9          # [Pa]
        poisson_ratio = 0.3

        [lower]                        # material of the rail
        young_modulus = 208e9
        poisson_ratio = 0.3

        [solve]
        # tolerance = 0.05             # relative error aimed at
        """,
    "rolling": """
        # A wheel rolls over a rail with creepage and spin: steady rolling, with stick and slip.
        # SI units: m, Pa, N, rad. A # before a key: this is its default.

        scene = "wheel_on_rail"
        force = 60e3                   # [N] vertical
        lateral = 0.0                  # [m] shift of the wheelset towards flange contact
        spacing = 0.4e-3               # [m] size of the contact cells
        friction = 0.3                 # [-]

        [rolling]
        # spin: -sin(contact angle) / wheel_radius of a wheel that rolls forwards, here under 2.0 degrees
        creepage = [1e-3, 0.0, -0.076] # longitudinal and lateral [-], spin [1/m]
        # force = [5e3, "free"]        # [N] to be reached along x and y; "free": the creepage is as given
        # velocity = 10.0              # [m/s]; matters for friction that depends on the slip velocity
        """,
    "braking": """
        # A pole shoe brakes: friction falls with the velocity, and so does the magnet's attraction.
        # Solve it over the velocity: mtb-rs sweep CASE.toml --vary velocity=2:40:8

        scene = "pole_shoe_on_rail"
        velocity = 25.0                # [m/s] the tables below are read at it
        spacing = 4e-3                 # [m] size of the contact cells

        [friction]                     # a table over the velocity [m/s]; or file = "friction.csv"
        velocity = [0.0, 10.0, 20.0, 40.0]
        value = [0.35, 0.22, 0.16, 0.12]

        [magnetic_pressure]            # [Pa]
        velocity = [0.0, 10.0, 20.0, 40.0]
        value = [3.0e6, 2.8e6, 2.6e6, 2.3e6]

        [solve]
        model = "elastic-upper"
        """,
}


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """The commands among the others."""
    demo = commands.add_parser(
        "demo",
        help="solve a pole shoe on a rail, and show its picture",
        description="Solves the ready pole shoe on a 60E1 rail, writes its results and pictures, and opens "
        "the picture of the pressure where there is a screen. It needs no file.",
    )
    demo.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("mtb-demo"),
        metavar="DIR",
        help="where to write (default: %(default)s, here)",
    )
    demo.set_defaults(command=_demo)
    init = commands.add_parser(
        "init",
        help="write a commented case file to start from",
        description="Writes a case file with comments to the standard output, or with -o into a file, and "
        f"beside it {SCHEMA}, by which editors complete and check its words.",
    )
    init.add_argument(
        "kind",
        choices=CASES,
        metavar="|".join(CASES),
        help="a sliding pole shoe, a wheel at rest, a rolling wheel, or a shoe over the velocity",
    )
    init.add_argument("-o", "--output", type=Path, metavar="CASE.toml", help="a file that is not there yet")
    init.set_defaults(command=_init)
    schema = commands.add_parser(
        "schema",
        help="write the JSON schema of case files, for editors, or of summaries",
        description="Writes the JSON schema of case files to the standard output. Editors that know TOML "
        f"complete and check the words of a case file that begins with `#:schema ./{SCHEMA}`. With the word "
        "summary it writes that of summary.json, which is saved with each result.",
    )
    schema.add_argument("what", nargs="?", choices=("case", "summary"), default="case", help="default: case")
    schema.set_defaults(command=_schema)


def case_file(kind: str) -> str:
    """The commented case file of a kind."""
    return f"#:schema ./{SCHEMA}\n{textwrap.dedent(CASES[kind]).lstrip()}"


def schema_text() -> str:
    """The JSON schema of case files."""
    from ..case.schema import schema

    return json.dumps(schema(), indent=1) + "\n"


def _schema(options: argparse.Namespace) -> int:
    if options.what == "summary":
        from ..case.summary_schema import summary_schema

        sys.stdout.write(json.dumps(summary_schema(), indent=1) + "\n")
    else:
        sys.stdout.write(schema_text())
    return 0


def _init(options: argparse.Namespace) -> int:
    text = case_file(options.kind)
    if options.output is None:
        sys.stdout.write(text)
        return 0
    path: Path = options.output
    check_folder(path.parent)
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise ValueError(f"{path} is there already, and is left as it is: name another file") from None
    beside = path.parent / SCHEMA
    if not os.path.lexists(beside):
        beside.write_text(schema_text(), encoding="utf-8")
    console = console_on(sys.stdout)
    name = shlex.quote(str(path))
    console.print(
        f"{path} is written; next: mtb-rs check {name}, then mtb-rs run {name}", markup=False, soft_wrap=True
    )
    return 0


def _demo(options: argparse.Namespace) -> int:
    from ..pictures.files import check_saveable
    from ..scenes import ready

    console = console_on(sys.stdout)
    directory = check_saveable(options.output)
    console.print("A pole shoe is attracted by a 60E1 rail with 3 MPa and slides with friction 0.3.")
    console.print("In Python:\n", style="bold")
    console.print(
        "    import mtb_rs as mtb\n"
        "    scene = mtb.scenes.pole_shoe_on_rail(friction=0.3)\n"
        "    result = scene.solve()\n"
        '    result.plot("pressure").savefig("pressure.png")\n',
        markup=False,
    )
    with console.status("solving ..."):
        clock = time.perf_counter()
        result = ready.pole_shoe_on_rail(friction=0.3).solve()
        elapsed = time.perf_counter() - clock
    with console.status("drawing ..."):
        result.save(directory)
    print_report(result, console, elapsed)
    picture = (directory / "pressure.png").resolve()
    if _has_screen() and webbrowser.open(picture.as_uri()):
        console.print(f"\n{picture} is opened.", markup=False, soft_wrap=True)
    else:
        console.print(f"\nThe pressure is drawn in {picture}", markup=False, soft_wrap=True)
    console.print("Next: mtb-rs init shoe -o case.toml && mtb-rs run case.toml", markup=False)
    return 0


def _has_screen() -> bool:
    """Whether a picture that is opened would be seen: a person at a terminal, with a display."""
    if not sys.stdout.isatty():
        return False
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))

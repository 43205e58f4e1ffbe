# SPDX-License-Identifier: MIT OR Apache-2.0
"""The command line: ``mtb-rs`` with a command, of which each has a module here."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence

from .. import __version__
from ..base.errors import CaseError, ConvergenceError
from . import brake, chart, check, completion, run, show, start, sweep, wear
from .console import console_on, leave_standard_output, one_line, warnings_on
from .exits import BAD_INPUT, NO_SOLUTION, STOPPED


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line and returns its exit code."""
    parser = _parser()
    if "_ARGCOMPLETE" in os.environ:  # a shell asks what may follow
        import argcomplete

        argcomplete.autocomplete(parser)
    errors = console_on(sys.stderr, markup=False, soft_wrap=True)
    try:
        options = parser.parse_args(arguments)
        with warnings_on(errors):
            command: Callable[[argparse.Namespace], int] = options.command
            code = command(options)
        sys.stdout.flush()
        return code
    except ConvergenceError as error:
        errors.print(f"mtb-rs: no solution: {one_line(error)}", style="red")
        return NO_SOLUTION
    except CaseError as error:
        errors.print("\n".join(f"mtb-rs: {line}" for line in str(error).splitlines()), style="red")
        return BAD_INPUT
    except MemoryError as error:
        errors.print(f"mtb-rs: the memory does not suffice: {one_line(error)}", style="red")
        return BAD_INPUT
    except (ValueError, OSError) as error:
        errors.print(f"mtb-rs: {one_line(error)}", style="red")
        return BAD_INPUT
    except KeyboardInterrupt:
        errors.print("mtb-rs: stopped", style="red")
        return STOPPED
    finally:
        leave_standard_output()


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="mtb-rs", description="Frictional elastic contact: magnetic track brakes, wheels on rails."
    )
    parser.add_argument("--version", action="version", version=f"mtb-rs {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for module in (start, check, run, show, chart, sweep, wear, brake, completion):
        module.add(commands)
    return parser

# SPDX-License-Identifier: MIT OR Apache-2.0
"""``mtb-rs completion``: what a shell needs to complete commands, options and files."""

from __future__ import annotations

import argparse
import sys

#: Shells that can be served, each with the place of its start-up file and the line to put there.
SHELLS = {
    "bash": 'eval "$(mtb-rs completion bash)", in ~/.bashrc',
    "zsh": 'eval "$(mtb-rs completion zsh)", in ~/.zshrc after compinit',
    "fish": "mtb-rs completion fish | source, in ~/.config/fish/config.fish",
    "powershell": "mtb-rs completion powershell | Out-String | Invoke-Expression, in $PROFILE",
}


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """The command among the others."""
    completion = commands.add_parser(
        "completion",
        help="print what a shell needs to complete this command",
        description="Prints a script by which a shell completes commands, options and files of mtb-rs. "
        + "; ".join(f"{shell}: {line}" for shell, line in SHELLS.items())
        + ".",
    )
    completion.add_argument("shell", choices=SHELLS)
    completion.set_defaults(command=_completion)


def _completion(options: argparse.Namespace) -> int:
    from argcomplete.shell_integration import shellcode

    sys.stdout.write(shellcode(["mtb-rs"], shell=options.shell) + "\n")
    return 0

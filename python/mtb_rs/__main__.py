# SPDX-License-Identifier: MIT OR Apache-2.0
"""``python -m mtb_rs`` is ``mtb-rs``."""

from __future__ import annotations

import sys

from .commands import main

if __name__ == "__main__":
    sys.exit(main())

# SPDX-License-Identifier: MIT OR Apache-2.0
"""Exit codes, beside 0."""

from __future__ import annotations

#: Bad input or an unwritable directory; no solution; stopped by the user.
BAD_INPUT, NO_SOLUTION, STOPPED = 2, 3, 130

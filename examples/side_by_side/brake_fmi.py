# SPDX-License-Identifier: MIT OR Apache-2.0
"""The same by a mock-up unit, here imported by FMPy: ``brake_fmi.py shoe.fmu``."""

import sys

from fmpy import simulate_fmu

for speed in (30.0, 20.0, 10.0):
    history = simulate_fmu(
        sys.argv[1],
        start_values={"velocity.x": speed},
        stop_time=1e-3,
        output_interval=1e-3,
        output=["force.x", "force.z", "moment.y"],
    )
    print(speed, *list(history[-1])[1:])

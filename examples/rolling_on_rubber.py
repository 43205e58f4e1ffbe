# SPDX-License-Identifier: MIT OR Apache-2.0
"""A steel roller on rubber: how the pressure leans ahead, and the force that it takes to roll [Hunter1961].

What to see: on the left, at a speed at which the rubber creeps while the roller passes, the pressure leans
ahead of the roller's axis (x = 0, rolling to the right); much slower or much faster rolling has the symmetric
pressure of a soft or of a hard elastic body. On the right, the resistance to rolling is largest in between,
and the creepage of a driven roller falls from that on the soft body to that on the hard one.
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import mtb_rs as mtb
from mtb_rs.base.files import output_folder

plt.style.use("mtb_rs.pictures")
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the picture")
output = parser.parse_args().output

radius, load, long = 50e-3, 100.0, 0.2  # m, N, m
tread = mtb.Viscoelastic(mtb.Material(20e6, 0.49), creep=1.0, creep_time=5e-3)
cell = 0.02e-3
x = (np.arange(200) - 99.5) * cell
gap = (x**2 / (2.0 * radius))[None]
law = mtb.Coulomb(0.8)


def rolled(speed: float) -> tuple[mtb.NormalResult, mtb.TangentialResult]:
    """The roller at a speed [m/s], driven by a tenth of its load."""
    motion = mtb.Rolling(force=(0.1 * load, None), velocity=speed)
    normal = mtb.solve_normal(
        gap, (cell, long), lower=tread, upper=mtb.Rigid(), force=load, edge="sharp", rolling=motion
    )
    return normal, mtb.solve_tangential(normal, motion, law)


figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 3.4), layout="constrained")
for speed in (0.01, 0.5, 50.0):
    left.plot(1e3 * x, 1e-3 * rolled(speed)[0].pressure[0], label=f"{speed:g} m/s")
left.axvline(0.0, color="0.6", lw=0.8)
left.set(xlabel="x [mm], rolling to the right", ylabel="pressure [kPa]")
left.legend(frameon=False)

speeds = np.geomspace(0.005, 100.0, 25)
resistance, slip = [], []
for speed in speeds:
    normal, friction = rolled(speed)
    resistance.append(normal.rolling_resistance / load)
    slip.append(float(friction.creepage[0]))
largest = int(np.argmax(resistance))
way = speeds[largest] * tread.creep_time
print(f"largest resistance: {resistance[largest]:.3f} of the load, at {speeds[largest]:.2g} m/s")
print(f"way in a creep time there: {1e3 * way:.2g} mm")
print(f"creepage, slow and fast: {1e3 * slip[0]:.2f} and {1e3 * slip[-1]:.2f} per mille")
right.semilogx(speeds, resistance, label="resistance to rolling over the load")
right.semilogx(speeds, slip, label="creepage for a tenth of the load")
right.set(xlabel="speed [m/s]", ylim=(0.0, 0.0085))
right.legend(frameon=False, loc="upper right")
figure.savefig(output / "rolling_on_rubber.png")

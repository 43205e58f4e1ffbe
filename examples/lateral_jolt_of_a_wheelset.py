# SPDX-License-Identifier: MIT OR Apache-2.0
"""How far behind steady rolling are the forces of a wheelset that is pushed sideways? A jolt, over the way.

A wheelset on S1002 profiles and 60E1 rails carries 60 kN a wheel and rolls straight at 20 m/s. On a way of
30 mm it is pushed to the left, by 45 micrometres, with a velocity that rises to 60 mm/s and falls again. Each
step of one cell, 0.5 mm, is solved twice: transient, where each patch remembers its tractions, and steady, as
if the wheelset had rolled so for long. Height and roll are found in each of them.

Numbers to compare with: the creepage across is the lateral velocity over the speed, at most 0.003. A patch is
some 8 mm long, and forgets what was before while it rolls over its own length, to some tenths.

What to see: the lateral force of steady rolling rises and falls with the velocity. The transient one comes
later by a part of the patch, and is still there when the wheelset no longer moves sideways. Below, the
traction across along the middle of the left patch while the push ends (dots in the upper picture): near the
leading edge, on the right, particles have come in since, and the rest still bears what the push has left.
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

speed, radius, way, jolt, most = 20.0, 0.46, 0.5e-3, 30e-3, 3e-3
scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, wheel_radius=radius, spacing=5e-4)
transient, steady = (scene.prepare(side="both", friction=mtb.Coulomb(0.3)) for _ in range(2))


def posed(x):
    """Pose and velocity after a way."""
    turn = np.pi * np.clip(x / jolt, 0.0, 1.0)
    y = most * jolt / (2.0 * np.pi) * (turn - 0.5 * np.sin(2.0 * turn))
    pose = (x, y, np.nan, np.nan, 0.0, 0.0)
    return pose, (speed, most * np.sin(turn) ** 2 * speed, 0.0, 0.0, speed / radius, 0.0)


places = np.arange(-5e-3, 60e-3, way)
pose, velocity = posed(places[0])
transient.step(pose, velocity)  # from steady rolling
rolled, held = [], []
for place in places[1:]:
    pose, velocity = posed(place)
    rolled.append(transient.step(pose, velocity, dt=way / speed, transient=True))
    held.append(steady.step(pose, velocity))
x = places[1:]
lateral = {"transient": [step.force[1] for step in rolled], "steady": [step.force[1] for step in held]}
left = held[0].patches[0]
length = np.ptp(left.x[(left.pressure > 0.0).any(axis=0)])

print("way [mm]  lateral velocity [mm/s] transient [kN]    steady [kN]")
for k in range(0, x.size, 12):
    across = 1e3 * posed(x[k])[1][1]
    both = " ".join(f"{1e-3 * force[k]:14.2f}" for force in lateral.values())
    print(f"{1e3 * x[k]:8.1f} {across:24.1f} {both}")
peak = {name: int(np.argmax(force)) for name, force in lateral.items()}
later, lower = (x[peak["transient"]] - x[peak["steady"]]), max(lateral["transient"]) / max(lateral["steady"])
print(f"the peak comes {1e3 * later:.1f} mm later, at {lower:.2f} of the steady one")
print(f"a patch is {1e3 * length:.0f} mm long")

figure, (over, along) = plt.subplots(2, 1, figsize=(7.2, 7.0))
for (name, force), line in zip(lateral.items(), ("-", "--"), strict=True):
    over.plot(1e3 * x, 1e-3 * np.array(force), line, label=name)
over.axvspan(0.0, 1e3 * jolt, color="#EEEEEE", zorder=0, label="pushed")
over.set_xlabel("way of the wheelset [mm]")
over.set_ylabel("lateral force on the rails [kN]")
over.set_title("A wheelset is pushed to the left on a way of 30 mm")
at = int(np.argmin(np.abs(x - 0.9 * jolt)))
over.plot(1e3 * x[[at, at]], [1e-3 * force[at] for force in lateral.values()], "o", color="#333333", ms=4)
over.legend()
for step, line, name in ((rolled[at], "-", "transient"), (held[at], "--", "steady")):
    patch = step.patches[0]
    row = int(np.argmin(np.abs(patch.y)))
    along.plot(1e3 * patch.x, 1e-6 * patch.traction[1, row], line, label=name)
    if name == "steady":
        along.plot(1e3 * patch.x, 0.3e-6 * patch.pressure[row], color="#888888", lw=1.0, label="bound")
along.set_xlabel("place along the rail in the left patch [mm], rolling to the right")
along.set_ylabel("traction across [MPa]")
along.set_title(f"In the left patch at {1e3 * x[at]:.0f} mm")
along.legend()
figure.savefig(output / "lateral_jolt_of_a_wheelset.png")

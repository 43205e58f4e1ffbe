# SPDX-License-Identifier: MIT OR Apache-2.0
"""Does a pole shoe squeal? Mode coupling over friction and pitch stiffness.

An elastic pole shoe slides at 5 m/s on a steel rail. One stiff link holds it, inclined by 10 degrees and two
centimetres above the rail, and springs hold its pitch. The friction does not fall with the velocity. Mass,
inertia and springs are assumed.

Numbers to compare with: without friction nothing grows, and frequencies are those of the link (2.0 kHz), of
the shoe in pitch on its contact (5.5 kHz without a spring) and of the contact in z (7.2 kHz).

What to see in flutter_of_a_pole_shoe.png: above some coefficient the vibrations in pitch and in z meet, and
one of them grows, by thousands of times a second. A stiffer pitch spring brings their frequencies together:
the border falls from 0.60 to nothing, where they are the same, and rises again beyond.

What to see in flutter_of_a_pole_shoe.gif: the vibration that grows most at a coefficient of 0.5. The shoe
pitches and bounces in turn, so that friction turns it while the pressure is high.
"""

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import mtb_rs as mtb
from mtb_rs.base.files import output_folder

plt.style.use("mtb_rs.pictures")
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the pictures")
output = Path(parser.parse_args().output)

MASS, INERTIA, CENTRE = 6.0, 0.01, 0.02  # kg, kg m2 about the centre of mass, m above the rail
LINK, ANGLE, HEIGHT = 1e9, np.radians(10.0), 0.02  # N/m, rad, m above the rail
PITCH = np.geomspace(1e5, 2e7, 31)  # N m
DECAY = 0.5  # 1/s, of all vibrations alike: friction alone would feed some of them, a thousand times slower

shoe = mtb.scenes.pole_shoe_on_rail(friction=0.2, velocity=5.0, spacing=8e-3)
contact = shoe.prepare("elastic-upper")
# over x, z and pitch about the reference point, on the rail
mass = np.array(
    [[MASS, 0.0, MASS * CENTRE], [0.0, MASS, 0.0], [MASS * CENTRE, 0.0, INERTIA + MASS * CENTRE**2]]
)
along = np.array([np.cos(ANGLE), np.sin(ANGLE), HEIGHT * np.cos(ANGLE)])


def stability(contact: mtb.PreparedContact, pitch: float) -> mtb.Stability:
    stiffness = LINK * np.outer(along, along) + np.diag([0.0, 1e5, pitch])
    return contact.stability(mass, stiffness, 2.0 * DECAY * mass, free=("x", "z", "pitch"))


found = [stability(contact, pitch) for pitch in PITCH]
print("pitch stiffness [N m]  smallest unstable friction  at [Hz]")
for pitch, one in list(zip(PITCH, found, strict=True))[::6]:
    print(f"{pitch:21.3g}  {one.critical_friction:26.3f}  {one.critical_frequency:7.0f}")

figure, ax = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
growth = np.array([np.maximum(np.nanmax(one.growths, axis=1), 0.0) for one in found])
shaded = ax.pcolormesh(
    found[0].frictions,
    PITCH,
    np.where(growth > 1.0, growth, np.nan),
    cmap="YlOrRd",
    vmin=0.0,
    shading="nearest",
)
ax.plot([one.critical_friction for one in found], PITCH, color="#333333", linewidth=1.4)
ax.set_yscale("log")
ax.set_xlabel("coefficient of friction [-]")
ax.set_ylabel("pitch stiffness [N m/rad]")
ax.set_title("Where a vibration of the shoe grows", loc="left")
ax.text(0.03, 0.5, "stable", transform=ax.transAxes)
figure.colorbar(shaded, ax=ax, label="growth [1/s]")
figure.savefig(output / "flutter_of_a_pole_shoe.png")

worst = stability(shoe.with_(friction=0.5).prepare("elastic-upper"), 5e6)
worst.animate(output / "flutter_of_a_pole_shoe.gif")
print(f"at a friction of {worst.friction:g}: {worst.kind}, {worst.growth.max():.0f} 1/s")

# SPDX-License-Identifier: MIT OR Apache-2.0
"""What does the rail bear when a wheel flat passes over it? Peak pressure over the angle of the wheel.

An S1002 wheel has a flat with rounded ends, 0.5 mm deep and 63 mm long, at the angle 30 degrees on it. It
carries 80 kN (slowly: without the impact of a flat at speed) and rolls forwards over it in steps of half a
degree. The height is found at each angle.

Numbers to compare with: away from the flat the pressure of the round wheel. The curvature pi^2 depth / (2
(half R)^2) of the cosine is taken off that of the wheel, 1/R, at the bottom of the flat, which is a little
hollow by it, and added at its ends: the pressure falls at the bottom, where the wheel stands on both sides,
and rises at the ends.

What to see: the axle sinks by the depth of the flat, and comes up again. The pressure has two peaks, one at
either end of the flat, and a hollow between them. The contact runs behind the axle before the middle of the
flat, and ahead of it after.
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

radius, depth, half, at = 0.46, 0.5e-3, np.radians(3.9), np.radians(30.0)
angle = np.radians(np.arange(-180.0, 180.01, 0.25))
off = angle - at
hollow = np.where(np.abs(off) < half, depth * np.cos(0.5 * np.pi * off / half) ** 2, 0.0)
wheel = mtb.WheelSlices.out_of_round("S1002", angle, -hollow, name="wheel with a flat")

scene = mtb.scenes.wheel_on_rail(wheel, "60E1", radius, lateral=0.0, force=80e3, spacing=4e-4)
wheels = scene.prepare()
pitch = np.radians(np.arange(22.0, 38.01, 0.5))
speed = 1.0
steps = [wheels.step((0.0, 0.0, np.nan, 0.0, turn, 0.0), speed) for turn in pitch]
peak = np.array([max(patch.pressure.max() for patch in step.patches) for step in steps])
sunk = np.array([step.pose[2] for step in steps])
ahead = np.array([step.patches[0].position[0] for step in steps])

print("angle [deg]  height [mm]  contact ahead by [mm]  peak pressure [MPa]")
for k in range(0, pitch.size, 4):
    print(f"{np.degrees(pitch[k]):11.1f} {1e3 * sunk[k]:12.3f} {1e3 * ahead[k]:22.2f} {1e-6 * peak[k]:20.0f}")
print(f"largest peak over that of the round wheel: {peak.max() / peak[0]:.2f}")

figure, axes = plt.subplots(3, 1, figsize=(7.2, 7.0), sharex=True)
for ax, values, label in zip(
    axes,
    (1e-6 * peak, 1e3 * sunk, 1e3 * ahead),
    ("peak pressure [MPa]", "height of the axle [mm]", "contact ahead by [mm]"),
    strict=True,
):
    ax.plot(np.degrees(pitch), values, marker="o", markersize=3)
    ax.set_ylabel(label)
    ax.grid(True, color="#DDDDDD", linewidth=0.6)
axes[0].set_title("A wheel flat rolls over the rail")
axes[-1].set_xlabel("angle that the wheel has rolled [°]")
figure.savefig(output / "wheel_flat.png")

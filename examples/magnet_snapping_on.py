# SPDX-License-Identifier: MIT OR Apache-2.0
"""From which height does a magnetic track brake snap onto the rail, and what does it lose at a rail joint?

A pole shoe hangs in springs above the rail. Its magnet pulls the more the nearer the rail is, so that below a
certain height the springs cannot hold it. The magnet is an `mtb.Magnet`: 3000 ampere-turns, a wear plate of
1 mm that is not magnetic, iron that saturates at 2.16 T. The pull at each point follows the gap there.

The shoe is lowered in steps of a prepared contact, and the pull at each height is compared with springs. The
number to compare with is the closed form of a plate magnet without iron in its way, which snaps on when a
third of the distance (the gap and the wear plate) is closed.

What to see: on the left, the pull over the height of the shoe. It falls by a factor of nearly thirty within
5 mm. Springs of 40 N/mm that hold the shoe 12 mm above the rail (dashed) are stronger than the pull from
where the lines cross, and the shoe rests there; those that hold it at 8 mm (dotted) are weaker everywhere,
and the shoe snaps on. In the middle, the height from which a shoe snaps on over the stiffness of its springs,
and the height to which their other end must be lifted to tear it off: between the two lines both states
exist. The dotted line is the closed form without iron. On the right, a joint of 18 mm passes below the shoe:
the rail is missing there, and the shoe loses its pull on those points. A fixed pull (dashed) presses all of
its load onto the rest of the shoe.

Usage: magnet_snapping_on.py [-o DIRECTORY].
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

AMPERE_TURNS, LAYER, IRON, SPRING = 3e3, 1e-3, 30.0 / 15.6, 4e4
#: The poles are 30 mm wide, of which the contact is 15.6 mm.
magnet = mtb.Magnet(
    AMPERE_TURNS, LAYER, iron_share=IRON, pole_length=30e-3, yoke=(0.15, 3e-3), armature=(60e-3, 3e-3)
)
scene = mtb.scenes.pole_shoe_on_rail(friction=0.2, magnetic_pressure=magnet, spacing=6e-3)
contact = scene.prepare(model="elastic-upper")

# lowered: the pull at each height
heights = np.linspace(0.0, 12e-3, 61)
pulls = np.array([contact.step(pose=[0, 0, z, 0, 0, 0]).report.magnet["attraction"] for z in heights[::-1]])[
    ::-1
]


def snaps_from(stiffness: float, pull: np.ndarray, z: np.ndarray) -> float:
    """Height [m] up to which springs of a stiffness [N/m] cannot hold a shoe: the line touches the pull."""
    return float((z + pull / stiffness)[1:].min())


# the same without iron, on its own: a plate magnet, whose field is that of two gaps in series
area = float(contact.area.sum())
constant = 0.5 * 4e-7 * np.pi * (0.5 * AMPERE_TURNS) ** 2 * IRON * area
stiffnesses = np.geomspace(1e4, 4e5, 40)
on = np.array([snaps_from(k, pulls, heights) for k in stiffnesses])
off = pulls[0] / stiffnesses
closed = np.cbrt(27.0 * constant / (4.0 * stiffnesses)) - LAYER
snap = snaps_from(SPRING, pulls, heights)
plain = float(np.cbrt(27.0 * constant / (4.0 * SPRING)) - LAYER)

# a joint passes below the shoe, from its front to its rear; from column to column of points, it takes three
x, width = contact.points[0], 18e-3
places = np.arange(-69e-3, 70e-3, 6e-3)
fixed = scene.with_(magnetic_pressure=pulls[0] / area).prepare(model="elastic-upper")


def over_the_joint(moved: mtb.PreparedContact) -> tuple[np.ndarray, np.ndarray]:
    """Contact force [N] and peak pressure [Pa] while the joint is at each of the places."""
    steps = [moved.step(gap=np.where(np.abs(x - place) < 0.5 * width, 20e-3, 0.0)) for place in places]
    return np.array([-s.force[2] for s in steps]), np.array([s.pressure.max() for s in steps])


force, peak = over_the_joint(contact)
force_fixed, peak_fixed = over_the_joint(fixed)

print(f"pull on the rail {pulls[0] / 1e3:.2f} kN, at 5 mm {np.interp(5e-3, heights, pulls):.0f} N")
print(f"springs of {SPRING / 1e3:.0f} N/mm cannot hold the shoe below {1e3 * snap:.2f} mm")
print(f"closed form without iron: {1e3 * plain:.2f} mm")
middle = np.abs(places).argmin()
print(f"with the joint below its middle {force[middle] / force.max():.0%} of the force is left")

figure, (left, middle, right) = plt.subplots(1, 3, figsize=(12.0, 4.0))
left.semilogy(1e3 * heights, pulls, label="pull of the magnet")
for height, style in ((12e-3, "--"), (8e-3, ":")):
    z = np.linspace(0.0, height - 1e-4, 200)
    left.semilogy(
        1e3 * z, SPRING * (height - z), "C1" + style, label=f"springs, free at {1e3 * height:.0f} mm"
    )
left.set(xlabel="height of the shoe [mm]", ylabel="force [N]", ylim=(20.0, 2.0 * pulls[0]))
left.legend()
middle.loglog(stiffnesses / 1e3, 1e3 * on, label="snaps on below")
middle.loglog(stiffnesses / 1e3, 1e3 * off, label="comes off above")
middle.loglog(stiffnesses / 1e3, 1e3 * closed, "C0:", label="snaps on, without iron")
middle.set(xlabel="stiffness of the springs [N/mm]", ylabel="height of the springs [mm]")
middle.legend()
right.plot(1e3 * places, force / 1e3, label="pull follows the gap")
right.plot(1e3 * places, force_fixed / 1e3, "C0--", label="fixed pull")
right.set(
    xlabel="place of the joint [mm]", ylabel="contact force [kN]", ylim=(0.0, 1.15 * force_fixed.max() / 1e3)
)
right.legend(loc="lower left")
figure.savefig(output / "magnet_snapping_on.png")

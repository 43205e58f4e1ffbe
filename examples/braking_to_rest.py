# SPDX-License-Identifier: MIT OR Apache-2.0
"""What happens in the last hundredths of a second of a stop?

Half a tonne of a vehicle rides on an elastic pole shoe, which is clamped in it and slides on the rail. The
last 20 mm/s are braked away. Steps in time of the contact know sliding, partial slip and sticking, so
that no speed has to be named below which friction fades out: the shoe stops, and the vehicle swings on it.

Numbers to compare with: until it sticks, the velocity falls by the friction force over the mass; the energy
of the vehicle is the heat of friction and what swings on.

What to see: top, the velocity falls evenly to zero, and then swings. The force of the contact, level while
the shoe slides, swings with it. Bottom, where the energy is: most of it is heat. What is left swings between
the vehicle and the shoe, and the micro-slip at the edges of the sole takes a little of it in each swing.
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import mtb_rs as mtb
from mtb_rs.base.files import output_folder
from mtb_rs.pictures.quantities import LINE_COLOURS

plt.style.use("mtb_rs.pictures")
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the picture")
output = parser.parse_args().output

MASS, SPEED, DENSITY = 500.0, 0.02, 7850.0  # kg, m/s, kg/m3
DT, STEPS = 5e-5, 900  # s

shoe = mtb.scenes.pole_shoe_on_rail(
    friction=0.3, magnetic_pressure=3e6, spacing=12e-3, poles=1, supports="clamped-top", velocity=SPEED
)
contact = shoe.prepare("elastic-upper")
friction = float(contact.step(velocity=SPEED).force[0])
moving = contact.vibrating(DT, [MASS], free=["x"], density=DENSITY, modes=6)

# the vehicle has the velocity, the rail rests, and what has pushed the vehicle on is gone
left = np.zeros(len(moving.coordinates))
left[0] = SPEED
gone = np.zeros(len(moving.coordinates))
gone[0] = -friction
state = moving.struck(left)
heat = pushed = 0.0
rows = []
begun = sum(moving.energy(state))
for k in range(STEPS):
    step = moving.step(0.0, gone, state=state)
    state = step.state
    heat += step.friction_work
    pushed += step.load_work + step.closing_work
    rows.append([DT * (k + 1), state.rate[0], step.force[0], step.kinetic_energy, heat, step.energy])
time, velocity, force, kinetic, heats, energy = np.array(rows).T
stop = time[np.argmax(velocity < 0.0)]
after = time > stop
balance = abs(begun + pushed - heat - energy[-1]) / (0.5 * MASS * SPEED**2)
print(
    f"it slides for {1e3 * stop:.2f} ms; {1e3 * MASS * SPEED / friction:.2f} ms by the friction force alone"
)
ups = np.flatnonzero((velocity[:-1] < 0.0) & (velocity[1:] >= 0.0))
swing = 1.0 / float(np.diff(time[ups]).mean())
print(f"then it swings at {swing:.0f} Hz, first to {force[after].min() / friction:.2f} of the friction force")
print(f"heat: {heat:.4f} J, of {0.5 * MASS * SPEED**2:.4f} J of the vehicle and some strain of the shoe")
print(f"the balance of energy holds to {balance:.0e} of them")

figure, (upper, lower) = plt.subplots(2, 1, figsize=(7.2, 5.6), layout="constrained", sharex=True)
upper.plot(1e3 * time, velocity / SPEED, color=LINE_COLOURS[0], label="velocity of the vehicle / first")
upper.plot(1e3 * time, force / friction, color=LINE_COLOURS[1], label="force of the contact / sliding")
upper.axvline(1e3 * stop, color="#888888", linewidth=0.8, linestyle="--")
upper.legend(loc="lower left", fontsize=8)
lower.plot(1e3 * time, kinetic, color=LINE_COLOURS[0], label="of the motion")
lower.plot(1e3 * time, heats, color=LINE_COLOURS[1], label="heat of friction")
lower.axvline(1e3 * stop, color="#888888", linewidth=0.8, linestyle="--")
lower.set(xlabel="time [ms]")
lower.set_title("energy [J]", loc="left")
lower.legend(loc="center right", fontsize=8)
figure.savefig(output / "braking_to_rest.png")

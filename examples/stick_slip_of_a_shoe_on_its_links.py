# SPDX-License-Identifier: MIT OR Apache-2.0
"""How does a shoe swing that its links make unstable? Until it sticks: a limit cycle.

A rigid shoe of 6 kg is pressed on a rail by 50 kN, through a layer that gives way. Inclined links hold it
along and across the rail, with a damper across it. It slides slowly, with a coefficient of friction of 0.5
that depends on nothing. Above 0.3 its two vibrations join and grow (mode coupling); they grow until the shoe
moves as fast as the rail and sticks for a part of each period. Steps in time follow that without being told
when it sticks.

Numbers to compare with: between the events, sticking and letting go, both degrees of freedom move in closed
form. Their cycle has the same period and the same size.

What to see: left, the velocity of the shoe grows as the eigenvalue tells (dashed), and then stops at that of
the rail. Right, the last cycles as displacement and velocity, with the closed form (dashed): the flat side
below is where the shoe sticks, and rings on the tangential stiffness of the contact, which the closed form
leaves out.
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

MASS, SPEED, FRICTION = 6.0, 0.02, 0.5  # kg, m/s
LAYER, LENGTH, WIDTH = 5e-10, 0.1, 0.05  # m/Pa, m
FORCE, DAMPER = 5e4, 600.0  # N, N s/m across the rail
LINKS = np.array([[1.5e7, 3e6], [3e6, 5e6]])  # N/m, over x and z

scene = mtb.scenes.block_on_plane(
    LENGTH,
    friction=FRICTION,
    magnetic_pressure=FORCE / (LENGTH * WIDTH),
    spacing=0.025,
    length=WIDTH,
    upper=mtb.Rigid(),
    velocity=SPEED,
    normal_layer=LAYER,
)
contact = scene.prepare("half-space")
found = contact.stability([MASS, MASS], LINKS, [0.0, DAMPER], free=("x", "z"))
worst = int(found.growth.argmax())
period = 1.0 / found.frequency[worst]
print(f"stable up to {found.critical_friction:.3f}; it grows by {found.growth[worst]:.0f} 1/s ", end="")
print(f"at {1.0 / period:.0f} Hz")

STEPS = 200  # in a period, so that they resolve how the shoe rings on the contact
dt = period / STEPS
moving = contact.vibrating(dt, [MASS, MASS], LINKS, [0.0, DAMPER], free=("x", "z"))
state, ways = moving.struck([0.02 * SPEED, 0.0]), []
heat = 0.0
for _ in range(36 * STEPS):
    step = moving.step(state=state)
    state, heat = step.state, heat + step.friction_work
    ways.append([*state.amplitude, *state.rate])
way = np.array(ways)


def closed_form(stiffness: float, start: np.ndarray, steps: int) -> np.ndarray:
    """Displacements and rates (steps, 4) of x and z, by the exact solution between the events.

    `stiffness` is that of the contact along the normal. Friction is `FRICTION` times the load and points
    against the slip; the shoe sticks while less than that holds it.
    """
    whole = LINKS + np.diag([0.0, stiffness])
    slides = whole - np.array([[0.0, FRICTION * stiffness], [0.0, 0.0]])
    damper = np.diag([0.0, DAMPER / MASS])
    values, vectors = np.linalg.eig(np.block([[np.zeros((2, 2)), np.eye(2)], [-slides / MASS, -damper]]))
    inverse = np.linalg.inv(vectors)
    decay = 0.5 * DAMPER / MASS
    swing = np.sqrt(whole[1, 1] / MASS - decay**2)

    def slid(at: np.ndarray, time: float) -> np.ndarray:
        return np.asarray((vectors @ (np.exp(values * time) * (inverse @ at))).real)

    def stuck(at: np.ndarray, time: float) -> np.ndarray:
        # the shoe goes back with the rail, and x bends the links along z
        drift = whole[1, 0] * SPEED / whole[1, 1]
        rest = -(whole[1, 0] * at[0] + DAMPER * drift) / whole[1, 1]
        z, v = at[1] - rest, at[3] - drift
        c, s, left = np.cos(swing * time), np.sin(swing * time) / swing, np.exp(-decay * time)
        moved = rest + drift * time + left * (c * z + s * (v + decay * z))
        speed = drift + left * (c * v - s * (decay * v + (decay**2 + swing**2) * z))
        return np.array([at[0] - SPEED * time, moved, -SPEED, speed])

    def holds(at: np.ndarray) -> float:
        """Friction that is left [N]: what it bears less what it has to."""
        bears = FRICTION * (FORCE - stiffness * at[1])
        return float(bears + LINKS[0] @ at[:2] - FRICTION * FORCE)

    at, sticks, out = start, False, []
    for _ in range(steps):
        left = dt
        while left > 0.0:
            move, event = (stuck, holds) if sticks else (slid, lambda a: a[2] + SPEED)
            if event(move(at, left)) >= 0.0:
                at, left = move(at, left), 0.0
                continue
            low, high = 0.0, left
            while low < (middle := 0.5 * (low + high)) < high:
                low, high = (middle, high) if event(move(at, middle)) >= 0.0 else (low, middle)
            at, left = move(at, high), left - high
            sticks = not sticks
            at[2] = -SPEED * (1.0 if sticks else 1.0 - 1e-12)
        out.append(at)
    return np.array(out)


stiffness = found.stiffness[1, 1] - LINKS[1, 1]
exact = closed_form(stiffness, np.array([0.0, 0.0, 0.02 * SPEED, 0.0]), len(way))


def cycle(of: np.ndarray) -> tuple[float, float]:
    """Period [s] of the last cycles, and how far x swings in them [m]."""
    x = of[-15 * STEPS :, 0] - of[-15 * STEPS :, 0].mean()
    up = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
    at = up + x[up] / (x[up] - x[up + 1])
    return dt * float(np.diff(at).mean()), float(np.ptp(x))


periods, sizes = zip(*(cycle(each) for each in (way, exact)), strict=True)
print(
    f"cycle: {1e3 * periods[0]:.4f} ms, {1e6 * sizes[0]:.2f} um; closed form {1e3 * periods[1]:.4f} ms, ",
    end="",
)
print(f"{1e6 * sizes[1]:.2f} um")

figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.8), layout="constrained")
time = dt * np.arange(1, len(way) + 1)
left.plot(1e3 * time, 1e3 * way[:, 2], color=LINE_COLOURS[0], linewidth=0.7, label="steps in time")
fifth = slice(4 * STEPS, 5 * STEPS)
grown = way[fifth, 2].max() * np.exp(found.growth[worst] * (time - time[4 * STEPS + way[fifth, 2].argmax()]))
left.plot(1e3 * time[grown < SPEED], 1e3 * grown[grown < SPEED], "k--", linewidth=1.0, label="eigenvalue")
left.axhline(-1e3 * SPEED, color=LINE_COLOURS[1], linewidth=1.0, label="as fast as the rail")
left.set(xlabel="time [ms]", ylim=(-25.0, 45.0))
left.set_title("velocity of the shoe [mm/s]", loc="left")
left.legend(loc="upper left", fontsize=8)
right.plot(
    1e6 * way[-3 * STEPS :, 0], 1e3 * way[-3 * STEPS :, 2], color=LINE_COLOURS[0], label="steps in time"
)
right.plot(
    1e6 * exact[-3 * STEPS :, 0], 1e3 * exact[-3 * STEPS :, 2], "k--", linewidth=1.0, label="closed form"
)
right.set(xlabel="displacement [µm]")
right.set_title("velocity of the shoe [mm/s]", loc="left")
right.legend(loc="upper left", fontsize=8)
figure.savefig(output / "stick_slip_of_a_shoe_on_its_links.png")

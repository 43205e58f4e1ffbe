# SPDX-License-Identifier: MIT OR Apache-2.0
"""How sure is a stopping distance? Its deviation by one adjoint run, against 200 rides by chance.

A vehicle brakes with its track brakes from 160 km/h. Friction, magnetic pull and the gaps of the shoe are
known with deviations only. One ride, and one backward run through its steps with the gradients that each step
gives, has the derivatives of the stopping distance by all of them; their deviations then add up. The Monte
Carlo rides draw all of them by chance and brake 200 times.

The number to compare with is the mean and the deviation of these rides. 200 rides know their deviation to
5 % only, so that is how well the two agree.

What to see: above, the distances of the rides (bars) and the normal distribution from the adjoint run (line);
below, what each of the uncertain numbers adds to the variance. A sole that is turned adds nothing: the shoe
turns with it.

Usage: stopping_distance_and_its_deviation.py [-o DIRECTORY] [--rides N].
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
parser.add_argument("--rides", type=int, default=200, help="rides by chance")
arguments = parser.parse_args()

MASS, OTHER, START, DT = 12e3, 9e3, 160.0 / 3.6, 0.25  # kg and N a shoe, m/s, s
FRICTION = mtb.VelocityTable((0.0, 5.0, 15.0, 30.0, 50.0), (0.30, 0.22, 0.16, 0.12, 0.10))
PULL = mtb.VelocityTable((0.0, 20.0, 50.0), (3.0e6, 2.6e6, 2.0e6))
scene = mtb.scenes.pole_shoe_on_rail(friction=FRICTION, magnetic_pressure=PULL, spacing=6e-3)
contact = scene.prepare("elastic-upper")
x, y, _ = contact.points
#: Uncertain shapes of the sole, a micrometre each: bent along x, turned along x, skew.
SHAPES = 1e-6 * np.array([(x / 45e-3) ** 2, x / 45e-3, x * y / (45e-3 * 20e-3)])
#: Both ends of a sole are dirty and rub less than its middle: only therefore do the gaps count at all.
#: Balance fixes the force and its place, whatever the gaps are.
CLEAN = 1.0 - 0.5 * (x / 45e-3) ** 2
NAMES = ["friction", "pull", "sole bent", "sole turned", "sole skew"]
#: Means and deviations: factors on friction and pull, then micrometres.
MEANS, DEVIATIONS = np.array([1.0, 1.0, 0.0, 0.0, 0.0]), np.array([0.08, 0.03, 0.5, 0.5, 0.5])


def ride(values: np.ndarray, *, with_gradients: bool = False) -> tuple[float, np.ndarray]:
    """Stopping distance [m], and its derivatives by the uncertain numbers."""
    speed, distance, steps = START, 0.0, []
    gap = values[2:] @ SHAPES
    while speed > 0.0:
        mu, pull = (float(np.interp(speed, table.velocity, table.value)) for table in (FRICTION, PULL))
        step = contact.step(
            velocity=speed, friction=values[0] * mu * CLEAN, magnetic_pressure=values[1] * pull, gap=gap
        )
        slower = speed - (step.force[0] + OTHER) * DT / MASS
        if with_gradients:
            by = step.gradient("force")
            slopes = [
                mu * by["friction_field"][0] @ CLEAN,
                pull * by["magnetic_pressure"][0],
                *(by["gap"][0] * SHAPES).sum(axis=-1),
            ]
            low, high = (np.interp(speed + e, FRICTION.velocity, FRICTION.value) for e in (-1e-6, 1e-6))
            weak, strong = (np.interp(speed + e, PULL.velocity, PULL.value) for e in (-1e-6, 1e-6))
            by_speed = (
                values[0] * by["friction_field"][0] @ CLEAN * (high - low) / 2e-6
                + values[1] * by["magnetic_pressure"][0] * (strong - weak) / 2e-6
            )
            steps.append((speed, step.force[0] + OTHER, np.array(slopes), by_speed))
        # the last step ends where the vehicle stands
        share = min(1.0, speed / (speed - slower)) if slower < 0.0 else 1.0
        distance += 0.5 * (speed + max(slower, 0.0)) * share * DT
        speed = slower
    gradient = np.zeros(values.size)
    for k in reversed(range(len(steps))):
        speed, force, slopes, by_speed = steps[k]
        if k == len(steps) - 1:
            # distance m v^2 / 2 F of the last step
            by_force, adjoint = -0.5 * MASS * speed**2 / force**2, MASS * speed / force
        else:
            # distance (v + v') dt / 2, with v' = v - F dt / m
            change = (0.5 * DT + adjoint) * -DT / MASS
            by_force, adjoint = change, 0.5 * DT + (0.5 * DT + adjoint)
        gradient += by_force * slopes
        adjoint += by_force * by_speed
    return distance, gradient


mean, gradient = ride(MEANS, with_gradients=True)
parts = (gradient * DEVIATIONS) ** 2
deviation = float(np.sqrt(parts.sum()))
print(f"adjoint: {mean:.1f} m, deviation {deviation:.1f} m, from one ride and its gradients")
check = ride(MEANS + 1e-3 * DEVIATIONS)[0] - ride(MEANS - 1e-3 * DEVIATIONS)[0]
along = float(gradient @ DEVIATIONS)
print(f"along all deviations at once: {along:.4f} m, by a difference of two rides {check / 2e-3:.4f} m")
random = np.random.default_rng(5)
drawn = MEANS + DEVIATIONS * random.standard_normal((arguments.rides, MEANS.size))
distances = np.array([ride(values)[0] for values in drawn])
print(f"{arguments.rides} rides by chance: {distances.mean():.1f} m, deviation {distances.std(ddof=1):.1f} m")
for name, part in zip(NAMES, parts / parts.sum(), strict=True):
    print(f"{name:12} {100.0 * part:6.2f} % of the variance")

figure, (above, below) = plt.subplots(
    2, 1, figsize=(7.4, 5.6), height_ratios=(1.6, 1.0), layout="constrained"
)
above.hist(distances, bins=24, density=True, alpha=0.5, label=f"{arguments.rides} rides by chance")
place = np.linspace(mean - 4.0 * deviation, mean + 4.0 * deviation, 200)
bell = np.exp(-0.5 * ((place - mean) / deviation) ** 2) / (deviation * np.sqrt(2.0 * np.pi))
above.plot(place, bell, label="one ride and its gradients")
above.set(xlabel="stopping distance [m]", ylabel="density [1/m]")
above.legend()
below.barh(NAMES[::-1], 100.0 * (parts / parts.sum())[::-1])
below.set_xlabel("share of the variance [%]")
figure.savefig(f"{arguments.output}/stopping_distance_and_its_deviation.png")

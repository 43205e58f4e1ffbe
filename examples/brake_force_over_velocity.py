# SPDX-License-Identifier: MIT OR Apache-2.0
"""How does the brake force change with velocity? Friction and pull from tables, unequal poles.

The right pole is pulled with 80 % of the left one's magnetic pressure, and both pulls fall with the
velocity.

The number to compare with is friction times pull times the area of both soles seen from above, all three
from the tables and the drawing. The solved force is 0.4 to 0.6 % larger: on a curved rail pressure stands
aslant, so that more of it is needed to carry the same vertical load, and friction grows with the pressure.

What to see: below 5 m/s the force falls with the friction, above that with both, and at 45 m/s a fifth of
it is left. Each pole carries its own pull.
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

# the right pole has 80 % of the left one's magnetic pressure
pulled_at, left_pull = [0.0, 20.0, 45.0], [3.0e6, 2.6e6, 2.0e6]  # m/s, Pa
rubbed_at, coefficients = [0.0, 5.0, 45.0], [0.35, 0.2, 0.1]
pull = mtb.VelocityTable(pulled_at, [[p, 0.8 * p] for p in left_pull])
friction = mtb.VelocityTable(rubbed_at, coefficients)

#: Area [m2] of the sole of one pole, seen from above.
SOLE = 90e-3 * (21.6e-3 - 6e-3)

print("v [m/s]  V left [N]  V right [N]  brake force [N]  friction x pull x area [N]")
velocities = (0.0, 1.0, 2.5, 5.0, 10.0, 20.0, 30.0, 40.0, 45.0)
brake_force, product, normal_force = {}, {}, {"left": [], "right": []}
for velocity in velocities:
    scene = mtb.scenes.pole_shoe_on_rail(friction=friction, magnetic_pressure=pull, velocity=velocity)
    result = scene.solve(model="half-space")
    load = result.pressure * result.area * result.normal[2]
    left, right = (float(patch.view(load).sum()) for patch in result.patches)
    brake_force[velocity] = float(result.force[0])
    normal_force["left"].append(left)
    normal_force["right"].append(right)
    carried = 1.8 * np.interp(velocity, pulled_at, left_pull) * SOLE
    product[velocity] = float(np.interp(velocity, rubbed_at, coefficients) * carried)
    row = (left, right, brake_force[velocity], product[velocity])
    print(f"{velocity:7.1f}  {row[0]:10.1f}  {row[1]:11.1f}  {row[2]:15.1f}  {row[3]:26.1f}")

figure, (below, above) = plt.subplots(2, 1, figsize=(7.4, 5.4), sharex=True, height_ratios=(1.3, 1))
below.plot(velocities, [1e-3 * force for force in brake_force.values()], "o-", label="solved")
below.plot(
    velocities, [1e-3 * force for force in product.values()], "k+", ms=8, label="friction x pull x area"
)
below.legend()
below.set(title="brake force of both poles [kN]", ylim=(0.0, None))
for name, forces in normal_force.items():
    above.plot(velocities, [1e-3 * force for force in forces], "o-", label=f"{name} pole")
above.set(title="normal force [kN]", xlabel="velocity [m/s]", ylim=(0.0, None))
above.legend()
figure.savefig(output / "brake_force_over_velocity.png")

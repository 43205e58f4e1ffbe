# SPDX-License-Identifier: MIT OR Apache-2.0
"""How does the brake force change with velocity? Friction and pull from tables, unequal poles."""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import mtb_rs as mtb
from mtb_rs.base.files import output_folder

plt.style.use("mtb_rs.pictures")
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the picture")
output = parser.parse_args().output

# the right pole has 80 % of the left one's magnetic pressure
pull = mtb.VelocityTable([0.0, 20.0, 45.0], [[3.0e6, 2.40e6], [2.6e6, 2.08e6], [2.0e6, 1.60e6]])
friction = mtb.VelocityTable([0.0, 5.0, 45.0], [0.35, 0.2, 0.1])

print("v [m/s]  V left [N]  V right [N]  brake force [N]")
velocities = (0.0, 1.0, 2.5, 5.0, 10.0, 20.0, 30.0, 40.0, 45.0)
brake_force, normal_force = {}, {"left": [], "right": []}
for velocity in velocities:
    scene = mtb.scenes.pole_shoe_on_rail(friction=friction, magnetic_pressure=pull, velocity=velocity)
    result = scene.solve(model="half-space")
    load = result.pressure * result.area * result.normal[2]
    left, right = (float(patch.view(load).sum()) for patch in result.patches)
    brake_force[velocity] = float(result.force[0])
    normal_force["left"].append(left)
    normal_force["right"].append(right)
    print(f"{velocity:7.1f}  {left:10.1f}  {right:11.1f}  {brake_force[velocity]:15.1f}")

figure, (below, above) = plt.subplots(2, 1, figsize=(7.4, 5.4), sharex=True, height_ratios=(1.3, 1))
below.plot(velocities, [1e-3 * force for force in brake_force.values()], "o-")
below.set(title="brake force of both poles [kN]", ylim=(0.0, None))
for name, forces in normal_force.items():
    above.plot(velocities, [1e-3 * force for force in forces], "o-", label=f"{name} pole")
above.set(title="normal force [kN]", xlabel="velocity [m/s]", ylim=(0.0, None))
above.legend()
figure.savefig(output / "brake_force_over_velocity.png")

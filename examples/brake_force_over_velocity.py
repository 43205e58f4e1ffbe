# SPDX-License-Identifier: MIT OR Apache-2.0
"""How does the brake force change with velocity? Friction and pull from tables, unequal poles."""

import mtb_rs as mtb

# the right pole has 80 % of the left one's magnetic pressure
pull = mtb.VelocityTable([0.0, 20.0, 45.0], [[3.0e6, 2.40e6], [2.6e6, 2.08e6], [2.0e6, 1.60e6]])
friction = mtb.VelocityTable([0.0, 5.0, 45.0], [0.35, 0.2, 0.1])

print("v [m/s]  V left [N]  V right [N]  brake force [N]")
brake_force = {}
for velocity in (2.5, 20.0, 40.0):
    scene = mtb.scenes.pole_shoe_on_rail(friction=friction, magnetic_pressure=pull, velocity=velocity)
    result = scene.solve(model="half-space")
    load = result.pressure * result.area * result.normal[2]
    left, right = (float(patch.view(load).sum()) for patch in result.patches)
    brake_force[velocity] = float(result.force[0])
    print(f"{velocity:7.1f}  {left:10.1f}  {right:11.1f}  {brake_force[velocity]:15.1f}")

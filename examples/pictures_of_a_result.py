# SPDX-License-Identifier: MIT OR Apache-2.0
"""What can a result show? Maps, cuts, bodies in space, and a moving picture of a friction sweep.

The elastic pole shoe tilts to its front as friction grows, and its rear comes free.

What to see in 1_pressure.png: both poles from above. The front (right) carries most, and the grey cells at
the rear have lifted off.

What to see in 2_cuts.png: the pressure along three lines of the left pole. The outermost line is zero over
the first quarter, where the pole has lifted off.

What to see in 3_vertical_displacement.png: the underside of the shoe sinks from the rear to the front
(yellow), so the shoe leans forward. The outlined corners are those that have lifted off.

What to see in 4_status.png: every point that touches slips, because the shoe slides as a whole.

What to see in 5_bodies.png: the same pressure on the rail, below the outlines of the two poles.

What to see in 6_friction_from_0_to_0.6.gif: as friction grows, pressure moves from the rear (left) to the
front.
"""

import argparse

import mtb_rs as mtb
from mtb_rs.base.files import output_folder
from mtb_rs.pictures.space import missing_for_view

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the pictures")
output = parser.parse_args().output

shoe = mtb.scenes.pole_shoe_on_rail(height=28.2e-3, friction=0.5, spacing=4.5e-3)
result = shoe.solve(model="elastic-upper")
result.plot("pressure").savefig(output / "1_pressure.png")
result.plot("pressure", y=(7.5e-3, 13.8e-3, 20e-3)).savefig(output / "2_cuts.png")
result.plot("vertical_displacement", body="upper").savefig(output / "3_vertical_displacement.png")
result.plot("status").savefig(output / "4_status.png")
missing = missing_for_view()  # the 3-D view needs pyvista (extra `viz`) and a GL driver
if missing is None:
    result.plot("pressure", "3d").screenshot(output / "5_bodies.png")

history = [shoe.with_(friction=0.1 * k).solve(model="elastic-upper") for k in range(7)]
mtb.animate(history, output / "6_friction_from_0_to_0.6.gif", y=7.5e-3, frames_per_second=2.0)
open_share = [float((step.pressure == 0.0).mean()) for step in history]
print("friction  open points [%]")
for k, share in enumerate(open_share):
    print(f"{0.1 * k:8.1f}  {100.0 * share:15.1f}")

# SPDX-License-Identifier: MIT OR Apache-2.0
"""What do 100 000 km make of a wheel? The profile of an S1002 wheel on 60E1 rails, worn by Archard's law.

A wheelset with 60 kN on each wheel runs at 20 m/s, at lateral positions that are spread normally about the
middle of the track with a standard deviation of 2.5 mm, and turned by 0.3 mrad to either side in turn. The
number of Archard's law is 1e-4 and the hardness 2.7 GPa, mild wear of dry steel. The rails do not wear, as
other trains and grinding shape them.

Numbers to compare with: Archard's number scatters by half, and depths go with it. Wheels are turned anew
after some millimetres of wear, or some 100 000 km.

What to see: the wheel wears fastest where its contacts lie, in two hollows that are 0.5 and 0.4 mm deep after
100 000 km. It slips where the radii of the two wheels differ, and wears until they differ little: the
equivalent conicity at 3 mm falls from 0.17 to 0.04. The hollows fit the rail worse: the peak pressure in the
middle of the track grows from 0.7 to 0.9 GPa.
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

shifts = 1e-3 * np.linspace(-4.0, 4.0, 33)
shares = np.exp(-0.5 * (shifts / 2.5e-3) ** 2)
yaw = 3e-4 * (-1.0) ** np.arange(shifts.size)
scene = mtb.scenes.wheel_on_rail("S1002", "60E1", lateral=0.0, force=60e3, spacing=1e-3)
worn = mtb.wear_of_wheels(
    scene,
    1e8,
    mtb.Archard.of_hardness(1e-4, 2.7e9),
    shifts=shifts,
    shares=shares,
    yaw=yaw,
    depth=5e-5,
    wavelength=8e-3,
    friction=mtb.Coulomb(0.3),
)
print("distance [km]  largest depth [mm]  worn off [cm3]  peak pressure in the middle [MPa]  left out [%]")
for k in range(0, worn.distances.size - 1, 3):
    print(
        f"{worn.distances[k] / 1e3:13.0f} {1e3 * worn.wheel_depths[k].max():19.2f} "
        f"{1e6 * worn.wheel_volumes[k]:15.1f} {1e-6 * worn.peak_pressures[k, 16]:34.0f} "
        f"{100 * worn.left_out[k]:13.1f}"
    )
for name, wheel in (("new", worn.wheel(0)), ("worn", worn.wheel())):
    geometry = mtb.wheelset_geometry(wheel, "60E1", shifts=np.linspace(-6e-3, 6e-3, 49))
    print(f"equivalent conicity of the {name} wheel at 3 mm: {geometry.equivalent_conicity(3e-3):.3f}")
figure = worn.plot()
figure.savefig(output / "worn_profiles_over_100_000_km.png")

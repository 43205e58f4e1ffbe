# SPDX-License-Identifier: MIT OR Apache-2.0
"""How is a ground rail rolled smooth? Plastic flow of its roughness over passages of rough wheels.

The pressure of the contact is capped at the hardness of the rail. What flows is a dent that stays: the next
passage begins on the dented rail, with `plastic_indentation` added to the gap. The wheel is harder, and each
passage brings another part of its rough surface over the same place.

The number to compare with: the same part of the wheel once more dents nothing, as what has borne the load
bears it again elastically.

What to see: the first passages dent most. Later ones meet fewer tips, so that less flows and a larger share
of the load is carried elastically: the roughness shakes down, though not to nothing, because each part of the
wheel has other tips. The rail is smoother and lower in the end; what flows does not pile up in this model.
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

cells, size, hardness = 128, 4e-6, 2.5e9  # along each side, m, Pa
side = cells * size
force = 0.6e9 * side**2  # the mean pressure of a wheel, 0.6 GPa


def ground(seed: int) -> np.ndarray:
    """Heights of a rough surface [m]."""
    return mtb.roughness(
        cells, size, rms_slope=0.02, hurst=0.8, roll_off=32 * size, shortest=8 * size, seed=seed
    )


def passage(gap: np.ndarray) -> mtb.NormalResult:
    """Of one part of a wheel over the rail."""
    return mtb.solve_normal(
        gap - gap.min(),
        size,
        lower=mtb.steel,
        upper=mtb.steel,
        force=force,
        hardness=hardness,
        periodic=True,
        tolerance=1e-8,
    )


rail, wheel = ground(1), ground(2)
dented = rail.copy()
rng = np.random.default_rng(0)
volumes, shares = [], []
print("passage  mean dent [nm]  share of the load at the hardness")
for number in range(1, 101):
    above = np.roll(wheel, rng.integers(cells, size=2), axis=(0, 1))
    result = passage(above - dented)
    dent = result.plastic_indentation
    dented -= dent
    volumes.append(dent.mean())
    shares.append(float((result.pressure * size**2)[dent > 0.0].sum()) / force)
    if number in (1, 2, 5, 10, 20, 50, 100):
        print(f"{number:7d}  {1e9 * volumes[-1]:14.2f}  {shares[-1]:34.1%}")
again = passage(above - dented).plastic_indentation.mean()
print(f"the last part once more: {again / volumes[-1]:.1e} of its dent")

figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 3.4), layout="constrained")
numbers = np.arange(1, len(volumes) + 1)
left.loglog(numbers, np.array(volumes) / volumes[0], ".", label="dent over that of the first passage")
left.loglog(numbers, shares, ".", label="share of the load at the hardness")
left.set(xlabel="passage", xticks=[1, 10, 100], xticklabels=[1, 10, 100])
left.set(ylim=(0.15, 1.2), yticks=[0.2, 0.5, 1.0], yticklabels=[0.2, 0.5, 1.0])
left.minorticks_off()
left.legend(frameon=False)
row = int(np.argmax((rail - dented).sum(axis=1)))
x = 1e3 * size * np.arange(cells)
right.plot(x, 1e6 * rail[row], label="ground")
right.plot(x, 1e6 * dented[row], label="after 100 passages")
right.set(xlabel="x [mm]", ylabel="height of the rail [um]")
right.legend(frameon=False)
figure.savefig(output / "shakedown_of_roughness.png")

# SPDX-License-Identifier: MIT OR Apache-2.0
"""Scales from micrometres to kilometres, from rubber to diamond: results must scale exactly.

A sliding paraboloid and an elastic block, solved at scaled lengths and moduli; drawn is the
largest deviation of the scaled-back pressure, relative to its largest value.
"""

import numpy as np
from atlas import panels, write

import mtb_rs as mtb

lengths = [1e-6, 1e-4, 1e-2, 1.0, 1e2, 1e3]
moduli = [1e5, 1e8, 1e11, 2e11, 1e12]


def paraboloid(length: float, modulus: float) -> np.ndarray:
    body = mtb.Material(modulus, 0.3)
    hard = mtb.Material(3.0 * modulus, 0.2)
    scene = mtb.scenes.paraboloid_on_plane(
        radius=10.0 * length,
        force=1e-5 * modulus * length**2,
        points=14,
        friction=0.5,
        upper=body,
        lower=hard,
    )
    return scene.solve("half-space").pressure / modulus


def block(length: float, modulus: float) -> np.ndarray:
    body = mtb.Material(modulus, 0.3)
    scene = mtb.scenes.block_on_plane(
        width=length,
        height=length,
        spacing=length / 8,
        magnetic_pressure=1e-5 * modulus,
        upper=body,
        lower=body,
    )
    return scene.solve("elastic-upper").pressure / modulus


if __name__ == "__main__":
    import warnings

    warnings.simplefilter("ignore")  # bodies of kilometres are suspected to be in millimetres
    rows = []
    figure, axes = panels(2, height=3.6)
    for ax, scene in zip(axes, (paraboloid, block), strict=True):
        base = scene(0.1, 2e11)
        digits = np.zeros((len(moduli), len(lengths)))
        for (j, i), _ in np.ndenumerate(digits):
            found = scene(lengths[i], moduli[j])
            apart = float(np.abs(found - base).max() / base.max())
            digits[j, i] = np.log10(max(apart, 1e-17))
            rows.append(
                {
                    "scene": scene.__name__,
                    "length_m": lengths[i],
                    "young_modulus_pa": moduli[j],
                    "deviation": apart,
                }
            )
        picture = ax.imshow(digits, origin="lower", cmap="Blues", vmin=-17, vmax=-5, aspect="auto")
        for (j, i), value in np.ndenumerate(digits):
            ax.text(i, j, f"{10.0**value:.0e}", ha="center", va="center", fontsize=8.5, color="black")
        ax.set_xticks(range(len(lengths)), [f"{v:g}" for v in lengths])
        ax.set_yticks(range(len(moduli)), [f"{v:.0e}" for v in moduli])
        ax.set(title=scene.__name__, xlabel="length [m]", ylabel="Young's modulus [Pa]")
        ax.grid(visible=False)
    bar = figure.colorbar(picture, ax=axes, location="bottom", shrink=0.7, aspect=40)
    bar.set_label("numbers and colours: largest deviation of the pressure from its scaled value [-]")
    ticks = range(-17, -4, 2)
    bar.set_ticks(ticks, labels=[f"1e{k}" for k in ticks])
    write("scales", figure, rows)

# SPDX-License-Identifier: MIT OR Apache-2.0
"""How stiff is an elastomer pad on steel? Pads of four heights against the formula of their shape factor.

A square pad hangs under a plate that it is bonded to, and is pressed 1 % down on lubricated steel. By
mirror symmetry it is one half of a pad of twice its height t between two bonded plates, whose apparent
modulus Gent and Lindley [GentLindley1959] give by its shape factor S = side / (4 t), loaded over free area:
1 / E_a = 1 / (E (1 + 2 S²)) + 1 / K, with the bulk modulus K. "Pressure" solves what stands behind that
formula, ∇²p - 12 G p / (K t²) = -12 G ε / t² over the square, as a series, beside E for the mean stretch.

What to see: the nearer Poisson's ratio is to 0.5 and the flatter the pad, the more of the load is carried
by pressure in its middle, which cannot leave. Quadratic tetrahedra follow the series within 4 % from S = 1
on. Both formulas are made for flat pads: a tall one is up to 9 % stiffer than the series, on finer meshes
as well. Linear tetrahedra lock: on the same mesh they are 10 to 37 % too stiff, and the package warns of
them. From 6 to 10 cells a side the modulus falls by a further 1 %.
"""

import argparse
import warnings

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import mtb_rs as mtb
from mtb_rs.base.files import output_folder
from mtb_rs.bodies.mesh import block_mesh

plt.style.use("mtb_rs.pictures")
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the pictures")
output = parser.parse_args().output

side, strain = 40e-3, 0.01  # m, of the pad
rubber = mtb.Material(3e6, 0.49)  # Pa
modulus, ratio = rubber.young_modulus, rubber.poisson_ratio
shear, bulk = modulus / (2.0 * (1.0 + ratio)), modulus / (3.0 * (1.0 - 2.0 * ratio))


def gent_lindley(shape: float) -> float:
    """Apparent modulus [Pa] of a bonded pad of shape factor `shape`."""
    return 1.0 / (1.0 / (modulus * (1.0 + 2.0 * shape**2)) + 1.0 / bulk)


def by_pressure(shape: float) -> float:
    """The same from the pressure of a thin bonded square between rigid plates, as a double sine series."""
    odd = np.arange(1, 400, 2, dtype=float)
    m, n = odd[:, None], odd[None, :]
    # lengths in sides: t = 1 / (4 S)
    squeeze = 12.0 * (4.0 * shape) ** 2
    mean = 64.0 / (np.pi**4 * m**2 * n**2) / (np.pi**2 * (m**2 + n**2) + squeeze * shear / bulk)
    return modulus + shear * squeeze * float(mean.sum())


def pad(height: float, cells: int, linear: bool = False) -> mtb.ElasticBody:
    """Half of the pad, its plate moved down by the strain."""
    line = np.linspace(-0.5 * side, 0.5 * side, cells + 1)
    mesh = block_mesh(line, line, height, clamped=True, quadratic=not linear)
    plate = mtb.Support("top", x=0.0, y=0.0, z=-strain * height, name="plate")
    return mtb.ElasticBody(mesh, rubber, "contact", [plate], "pad", linear=linear)


def pressed(body: mtb.ElasticBody, cells: int) -> mtb.Result:
    scene = mtb.Scene(upper=body, lower=mtb.HalfSpace(mtb.steel), spacing=side / cells, friction=0.0)
    # the force is asked for; the pressure is infinite at the edges of a pad that does not bulge there
    return scene.solve("elastic-upper", tolerance=0.5)


def apparent(result: mtb.Result) -> float:
    """Mean pressure over strain [Pa]."""
    return result.normal_force / side**2 / strain


heights = 1e-3 * np.array([20.0, 10.0, 5.0, 2.5])
factors = side / (8.0 * heights)
results, coarse, locked = {}, {}, {}
for height in heights:
    results[height] = pressed(pad(height, 10), 10)
    coarse[height] = apparent(pressed(pad(height, 6), 6))
    with warnings.catch_warnings():
        # linear tetrahedra warn that they lock
        warnings.simplefilter("ignore")
        locked[height] = apparent(pressed(pad(height, 10, linear=True), 10))
found = {height: apparent(result) for height, result in results.items()}
print(f"E = {modulus / 1e6:g} MPa, Poisson's ratio {ratio:g}; apparent modulus over E")
print("height [mm]     S  Gent-Lindley  pressure  6 cells  10 cells  difference  linear tetrahedra")
difference = {}
for height, shape in zip(heights, factors, strict=True):
    difference[height] = found[height] / by_pressure(shape) - 1.0
    print(
        f"{1e3 * height:11.1f} {shape:5.2f} {gent_lindley(shape) / modulus:13.3f}"
        f" {by_pressure(shape) / modulus:9.3f} {coarse[height] / modulus:8.3f} {found[height] / modulus:9.3f}"
        f" {100.0 * difference[height]:9.1f} % {locked[height] / modulus:18.3f}"
    )

figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.6))
shapes = np.linspace(0.0, factors.max(), 60)
left.plot(shapes, [gent_lindley(s) / modulus for s in shapes], "--", label="Gent and Lindley")
left.plot(shapes, [by_pressure(s) / modulus for s in shapes], label="pressure series")
left.plot(factors, [found[h] / modulus for h in heights], "o", label="quadratic tetrahedra")
left.plot(factors, [locked[h] / modulus for h in heights], "x", ms=7, label="linear tetrahedra")
left.set(xlabel="shape factor S", title="apparent modulus over E", ylim=(0.0, None))
left.legend()
for height, result in results.items():
    # the row of points along x through the middle
    row = np.abs(result.points[1]) < 1e-6
    right.plot(
        1e3 * result.points[0, row], 1e-6 * result.pressure[row], ".-", label=f"{1e3 * height:g} mm high"
    )
right.set(xlabel="x [mm]", title="pressure on the steel, middle row [MPa]", ylim=(0.0, 0.42))
right.legend(ncols=2)
figure.savefig(output / "elastomer_pad_on_steel.png")

# SPDX-License-Identifier: MIT OR Apache-2.0
"""Prepares a pole shoe on its rail for the programs beside this one, and draws its pressure at 30 m/s."""

import argparse

import matplotlib

matplotlib.use("Agg")

import mtb_rs as mtb
from mtb_rs.base.files import output_folder

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the files")
parser.add_argument("--library", help="runtime of mock-up units, which released wheels bring")
given = parser.parse_args()

scene = mtb.scenes.pole_shoe_on_rail(
    friction=mtb.VelocityTable([0.0, 10.0, 50.0], [0.4, 0.2, 0.1]), magnetic_pressure=3e6, spacing=6e-3
)
contact = scene.prepare("elastic-upper", reference_point=(0.0, 0.0, 28.2e-3))
contact.save(given.output / "shoe.mtbc")
contact.save_fmu(given.output / "shoe.fmu", given.library, velocity=30.0)
contact.step(velocity=30.0).plot("pressure").savefig(given.output / "shoe.png")

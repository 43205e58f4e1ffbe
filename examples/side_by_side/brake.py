# SPDX-License-Identifier: MIT OR Apache-2.0
"""Brake force, normal force and moment of a prepared shoe at three velocities: ``brake.py shoe.mtbc``."""

import sys

import mtb_rs as mtb

shoe = mtb.PreparedContact.load(sys.argv[1])
for speed in (30.0, 20.0, 10.0):
    step = shoe.step(velocity=speed)
    print(speed, step.force[0], step.force[2], step.moment[1])

# SPDX-License-Identifier: MIT OR Apache-2.0
"""How good is a grid? A paraboloid on a plane against the closed form [Hertz1882; Johnson1985, ch. 4]."""

import numpy as np

import mtb_rs as mtb

radius, force = 1.0, 1e3  # m, N
modulus = 0.5 * mtb.steel.plane_strain_modulus
contact_radius = np.cbrt(0.75 * force * radius / modulus)
peak = 1.5 * force / (np.pi * contact_radius**2)

print("points  peak pressure / Hertz  approach / Hertz")
errors = []
for points in (18, 34, 66):
    result = mtb.scenes.paraboloid_on_plane(radius, force, friction=0.0, points=points).solve()
    r = np.hypot(*result.points[:2])
    exact = peak * np.sqrt(np.maximum(1.0 - (r / contact_radius) ** 2, 0.0))
    errors.append(float(np.linalg.norm(result.pressure - exact) / np.linalg.norm(exact)))
    approach = float(result.approach) / (contact_radius**2 / radius)
    print(f"{points:6d}  {result.pressure.max() / peak:21.5f}  {approach:16.5f}")
print(f"relative L2 error of the pressure: {', '.join(f'{100 * e:.2f} %' for e in errors)}")

# SPDX-License-Identifier: MIT OR Apache-2.0
"""Friction that falls with slip: slope x memory x grid, transient and steady, with and without a layer,
FASTSIM.

Transient: a cylinder starts to roll at a creepage beyond saturation; shown is the largest fall of the force
within one step, over the bound, once rolling has begun. Steady: the largest relative jump between forces of
neighbouring creepages (a sphere). "none" marks where the solver found no state, and said so.
"""

import numpy as np
from atlas import draw_verdicts, panels, write

import mtb_rs as mtb
from mtb_rs import reference

names = ("smooth", "no state found (said)", "jumps: the law itself is unstable")
colours = ("#56B4E9", "#E69F00", "#CC79A7")
half_slips = [0.01, 0.02, 0.05, 0.2, 1.0]
memories = [None, 1e-6, 1e-5, 1e-4]
body = mtb.Material.from_shear_modulus(82e9, 0.28)
a, peak, speed = 3e-3, 0.6e9, 10.0
load = 0.5 * np.pi * a * peak
layer = mtb.InterfaceLayer(thickness=0.125e-3, shear_modulus=0.82e9)


def transient(n: int, law: mtb.FallingFriction, between: mtb.InterfaceLayer | None) -> float:
    patch = reference.line_pressure(load, a, n, body, body)
    motion = mtb.Rolling(
        creepage=(2.5e-3 if between is None else 8e-3, 0.0, 0.0), transient=True, velocity=speed
    )
    state, forces = None, []
    for _ in range(round(1.5 * n)):
        found = mtb.solve_tangential(patch, motion, law, layer=between, state=state)
        state = found.state
        forces.append(found.force[0] / (law.static * load))
    return float(max(0.0, -np.diff(forces).min()))


creepages = np.array([(xi, 0.0, 0.0) for xi in np.linspace(1e-3, 8e-3, 8)])


def steady(n: int, law: mtb.FallingFriction, between: mtb.InterfaceLayer | None) -> float:
    patch = reference.elliptic_pressure(1e4, (3.2e-3, 3.2e-3), (n, n), body, body)
    forces = mtb.creep_curve(patch, creepages, law, layer=between, velocity=speed)[:, 0]
    return float(np.abs(np.diff(forces, 2)).max() / np.abs(forces).max())


def fastsim(n: int, law: mtb.FallingFriction, between: None) -> float:
    patch = reference.elliptic_pressure(1e4, (3.2e-3, 3.2e-3), (n, n), body, body)
    forces = mtb.fastsim_curve(patch, creepages, law, velocity=speed)[:, 0]
    return float(np.abs(np.diff(forces, 2)).max() / np.abs(forces).max())


cases = (
    ("transient, n = 20", transient, 20, None, 0.02),
    ("transient, n = 40", transient, 40, None, 0.02),
    ("transient, layer, n = 20", transient, 20, layer, 0.02),
    ("steady, n = 20", steady, 20, None, 0.35),
    ("steady, layer, n = 20", steady, 20, layer, 0.35),
    ("FASTSIM, n = 40", fastsim, 40, None, 0.35),
)
figure, axes = panels(len(cases), height=2.7)
rows = []
for ax, (title, run, n, between, limit) in zip(axes, cases, strict=True):
    kept = memories if run is not fastsim else [None]
    codes = np.zeros((len(kept), len(half_slips)), dtype=int)
    texts = np.full(codes.shape, "", dtype=object)
    for j, memory in enumerate(kept):
        for i, half in enumerate(half_slips):
            law = mtb.FallingFriction(static=0.33, kinetic=0.14, half_slip=half, memory=memory)
            try:
                jump, said = run(n, law, between), ""
                codes[j, i] = 0 if jump < limit else 2
                texts[j, i] = f"{100 * jump:.1f}"
            except mtb.ConvergenceError as refusal:
                codes[j, i], jump, said, texts[j, i] = 1, np.nan, str(refusal)[:200], ""
            rows.append(
                {
                    "case": title,
                    "half_slip_m_s": half,
                    "memory_m": memory or "none",
                    "verdict": names[codes[j, i]],
                    "jump": jump,
                    "said": said,
                }
            )
    draw_verdicts(ax, half_slips, range(len(kept)), codes, names=names, colours=colours, texts=texts)
    ax.set_yticks(range(len(kept)), ["none" if m is None else f"{1e6 * m:g} µm" for m in kept])
    ax.set(title=title, xlabel="half slip [m/s]", ylabel="memory")
write("falling_friction", figure, rows)

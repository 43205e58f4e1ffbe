# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the thesis leaves open: unequal loads, a shoe off its symmetry plane, an elastic rail: chapter 5."""

from __future__ import annotations

import numpy as np
from comparison import of_result, write_table
from drawing import MEGA, MICRO, PRESSURE, canvas, caption, draw_map, edge_of_contact, output, save

import mtb_rs as mtb
from mtb_rs.pictures.quantities import INK

SHOE = {"height": 28.2e-3, "length": 96e-3, "friction": 0.5}


def main() -> None:
    folder = output(__doc__)
    shoe = mtb.scenes.pole_shoe_on_rail
    cases = {
        "as it is, rail a half-space": (shoe(**SHOE), "elastic-upper"),
        "right pole pulled by 60 %": (shoe(**SHOE, magnetic_pressure=(3e6, 1.8e6)), "elastic-upper"),
        "0.2 mm to the left, turned by 0.02°": (shoe(**SHOE, lateral=0.2e-3, yaw=3.5e-4), "elastic-upper"),
        "rail elastic, 180 mm long": (shoe(**SHOE, rail_length=0.18), "elastic-both"),
        "rail elastic, 600 mm long": (shoe(**SHOE, rail_length=0.6), "elastic-both"),
        "rail elastic, right pole pulled by 60 %": (
            shoe(**SHOE, rail_length=0.6, magnetic_pressure=(3e6, 1.8e6)),
            "elastic-both",
        ),
    }
    figure, axes = canvas(3, 2, (7.4, 6.2), sharex=True, sharey=True)
    rows = []
    found = {title: scene.solve(model=model) for title, (scene, model) in cases.items()}
    for ax, (title, (_, model)) in zip(axes.flat, cases.items(), strict=True):
        result = found[title]
        # a scale each: the shoe off its place has peaks that would flatten all others
        high = float(np.percentile(result.pressure, 97)) / MEGA
        poles = [of_result(result, patch.name, k) for k, patch in enumerate(result.patches)]
        for pole in poles:
            shown = draw_map(ax, pole, pole.pressure / MEGA, vmin=0.0, vmax=high)
            edge_of_contact(ax, pole, colors="white", linewidths=1.0)
        caption(ax, title, grid=False)
        figure.colorbar(shown, ax=ax, extend="max", aspect=12, pad=0.02).ax.tick_params(labelsize=8)
        share = result.report.contact_area / float(result.area.sum())
        drop = [float(p.displacement[:, -1].mean() - p.displacement[:, 0].mean()) / MICRO for p in poles]
        load = result.pressure * result.area * result.normal[2]
        forces = [float(patch.view(load).sum()) for patch in result.patches]
        rows.append(
            [title, model, *(f"{f:.0f}" for f in forces), f"{result.force[0]:.0f}", f"{result.force[1]:.0f}"]
        )
        rows[-1] += [f"{m:.1f}" for m in result.moment] + [f"{100 * share:.0f}", *(f"{d:.2f}" for d in drop)]
        print(*rows[-1])
    for ax in axes[:, 0]:
        ax.set_ylabel("y [mm]", fontsize=9, color=INK)
    for ax in axes[-1]:
        ax.set_xlabel("x [mm], sliding to the right", fontsize=9, color=INK)
    figure.suptitle(PRESSURE[1], x=0.01, ha="left", fontsize=10, color=INK)
    save(figure, folder, "left_open")
    header = ["scene", "model", "left_force_N", "right_force_N", "friction_force_N", "lateral_force_N"]
    header += ["moment_x_Nm", "moment_y_Nm", "moment_z_Nm", "area_in_contact_percent"]
    write_table(
        folder / "left_open.csv", [*header, "left_front_minus_rear_um", "right_front_minus_rear_um"], rows
    )


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: MIT OR Apache-2.0
"""Where does a worn wheel touch its rail? Contact point, angle, rolling radii and patch over the shift.

A cone of 1:20, a new S1002 and a hollow one roll on a 60E1 rail inclined 1:40, the hollow one also on a
worn head. Wear is stated here: cosines of 0.3 mm depth over 60 mm of the tread and 0.1 mm over 40 mm of the
head; a measured profile comes in by ``mtb.Profile.from_file``. The wheelset neither rolls nor yaws.

Three numbers to compare with. A cone touches one place of the rail, and its rolling radii differ by y / 10.
Its patch is nearly that of Hertz on the crown's radius of 300 mm: where it reaches the arc of 80 mm, 10 mm
from the middle, the rail falls away, so that its peak is 1 % larger and its area smaller. And the new wheel
stands beside CONTACT in the Manchester benchmark, whose wheelset rolls by 0.2 to 0.3 mrad and whose rail is
another table of UIC60, which looks 3 mrad less inclined on the gauge side: it is 0.1 and 0.6 mm and 0.5 and
5 mrad off. On that table, still without roll, it is 0.1 and 0.2 mm and 0.5 and 2 mrad off; rolled as there,
both programs agree (tests/validation/test_whole_wheels.py).

What to see: the new wheel wanders over the head, and its radii differ three times as much as those of the
cone. The hollow wheel leaves out the middle of the head: within 1 mm it goes from the field side to the
gauge side, where its radii differ twice as much as those of the new one, so that a wheelset on it runs on a
short wave. At 5 mm its root touches, at two and a half times the pressure of the cone.
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import mtb_rs as mtb
from mtb_rs.base.files import output_folder
from mtb_rs.pictures.quantities import LINE_COLOURS

plt.style.use("mtb_rs.pictures")
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the picture")
output = parser.parse_args().output


def worn(profile: mtb.Profile, depth: float, width: float) -> mtb.Profile:
    """The profile with a cosine of `depth` [m] over `width` [m] taken off (a wheel's material lies above)."""
    y = np.linspace(*profile.range, 521)
    taken = np.where(2.0 * np.abs(y) < width, 0.5 * (1.0 + np.cos(2.0 * np.pi * y / width)), 0.0)
    return mtb.Profile.from_points(y, profile.height(y) + depth * taken)


y = np.linspace(-60e-3, 60e-3, 241)
cone = mtb.Profile.from_points(y, y / 20.0)
wheel, rail = mtb.Profile.standard("S1002"), mtb.Profile.standard("60E1")
hollow, flat = worn(wheel, 0.3e-3, 60e-3), worn(rail, -0.1e-3, 40e-3)
pairs = {
    "cone 1:20": (cone, rail),
    "new wheel": (wheel, rail),
    "hollow wheel": (hollow, rail),
    "hollow wheel, worn rail": (hollow, flat),
}
force, radius = 60e3, 0.46  # N, m
shifts = 0.5e-3 * np.arange(-10, 11)
found: dict[str, dict[str, np.ndarray]] = {}
for name, (upper, lower) in pairs.items():
    rows = []
    for shift in shifts:
        scene = mtb.scenes.wheel_on_rail(upper, lower, lateral=shift, force=force, spacing=0.5e-3)
        # the patch and its peak to some per cent
        result = scene.solve(tolerance=0.25)
        place = scene.geometry.placement
        rows.append(
            {
                "rail": place.rail_position,
                "angle": place.contact_angle,
                "radius": radius - float(upper.height(place.wheel_position)),
                "area": result.report.contact_area,
                "peak": result.report.peak_pressure,
            }
        )
    found[name] = {key: np.array([row[key] for row in rows]) for key in rows[0]}
    # the other wheel is shifted by as much to its field side
    found[name]["difference"] = found[name]["radius"] - found[name]["radius"][::-1]

print("wheel and rail            shift   rail y   angle   area   peak  radii differ")
print("                           [mm]     [mm]   [deg]  [mm2]  [MPa]          [mm]")
for name, of in found.items():
    for k in range(10, 21, 2):
        print(
            f"{name:24s} {1e3 * shifts[k]:6.1f} {1e3 * of['rail'][k]:8.2f} {np.degrees(of['angle'][k]):7.2f}"
            f" {1e6 * of['area'][k]:6.0f} {1e-6 * of['peak'][k]:6.0f} {1e3 * of['difference'][k]:13.4f}"
        )
exact = shifts / 10.0
cone_error = float(np.abs(found["cone 1:20"]["difference"] - exact).max() / exact.max())
angle_error = float(np.abs(np.tan(found["cone 1:20"]["angle"]) * 20.0 - 1.0).max())
print(f"cone: radii within {cone_error:.1e} of y / 10, slope of the contact within {angle_error:.1e} of 1/20")
slant = np.arctan(1 / 20)
hertz = mtb.hertz(force / np.cos(slant), (radius / np.cos(slant), 0.3))
peak_error = float(found["cone 1:20"]["peak"][0] / hertz.peak_pressure - 1.0)
area_error = float(found["cone 1:20"]["area"][0] / (np.pi * np.prod(hertz.semi_axes)) - 1.0)
print(f"cone: largest pressure {100 * peak_error:+.1f} %, area {100 * area_error:+.1f} % from Hertz")

#: CONTACT in the Manchester benchmark, case A-2.2: shift to the flange, y and angle of the contact of the
#: wheel on that side [m, m, rad]
CONTACT = ((-3e-3, 757.24e-3, 0.0110), (4e-3, 738.74e-3, 0.1078))
print("new wheel at 10 kN: y in the track [mm] and angle [mrad]")
benchmark = {}
for shift, position, angle in CONTACT:
    place = mtb.wheel_on_rail_gap(wheel, rail, lateral=shift, force=10e3, spacing=0.5e-3)
    benchmark[shift] = (float(place.position[1] - position), place.contact_angle - angle)
    print(
        f"shift {1e3 * shift:4.1f} mm: {1e3 * place.position[1]:.2f} and {1e3 * place.contact_angle:.1f},"
        f" CONTACT {1e3 * position:.2f} and {1e3 * angle:.1f}"
    )

figure, axes = plt.subplots(2, 2, figsize=(7.4, 6.0), sharex=True)
shown = {
    "rail": (1e3, "contact on the rail, y from its middle [mm]"),
    "difference": (1e3, "difference of the rolling radii [mm]"),
    "area": (1e6, "contact area [mm²]"),
    "peak": (1e-6, "largest pressure [MPa]"),
}
for ax, (key, (scale, title)) in zip(axes.flat, shown.items(), strict=True):
    for (name, of), style in zip(found.items(), ("-", "-", "-", "--"), strict=True):
        ax.plot(1e3 * shifts, scale * of[key], style, marker=".", label=name)
    ax.set(title=title)
axes[0, 1].plot(1e3 * shifts, 1e3 * exact, "+", color=LINE_COLOURS[-1], ms=8, label="y / 10")
for ax in axes[1]:
    ax.set(xlabel="lateral shift towards the flange [mm]", ylim=(0.0, None))
figure.legend(*axes[0, 1].get_legend_handles_labels(), loc="outside lower center", ncols=3)
figure.savefig(output / "worn_wheel_over_lateral_shift.png")

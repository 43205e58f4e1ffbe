# SPDX-License-Identifier: MIT OR Apache-2.0
"""From which speed does a bogie hunt? Two wheelsets on measured profiles run down a track.

A wheel is measured with noise, after it has worn by a millimetre, and smoothed; the rails are 60E1 inclined
1:40. exudyn (extra `mbs`) integrates a bogie of two wheelsets: each moves sideways, yaws and turns about its
axle, the frame moves sideways and yaws, and the vehicle goes on straight. Before each step of time the
contacts of both wheelsets are solved (`wheels.step`), with height and roll such that each wheel carries
60 kN. Forces enter with their exact derivatives by place and velocity, which makes the step linearly
implicit. Smoothing takes SciPy (extra `smooth`). Masses and springs are assumed, of plausible size.

Numbers to compare with: a free wheelset that rolls slowly runs on a sine of the wavelength by Klingel. The
eigenvalues of the straight run, from the same derivatives, say at which speed it becomes unstable, and how
fast a small disturbance grows or fades in a run.

What to see in bogie_on_a_track.png: above, the path of a free wheelset and the sine of Klingel's wavelength.
In the middle, the growth rates by eigenvalues over the speed (line) and of runs with small disturbances
(dots); where the line crosses zero is the critical speed. Below, a run above this speed that starts slightly
off the middle: the oscillation grows until the flanges touch and limit it.

What to see in bogie_on_a_track.gif: that run from above, sideways motion and yaw enlarged 30 times, and the
lateral shifts of both wheelsets so far.

Usage: bogie_on_a_track.py [-o DIRECTORY] [--short]. The measured wheel is written beside the pictures as
worn_wheel.whl. `--short` takes coarse contacts and leaves out the run above the critical speed: the lowest
panel and the animation.
"""

from __future__ import annotations

import argparse
import contextlib
from pathlib import Path
from typing import Any

import exudyn as exu
import exudyn.itemInterface as item
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from scipy.linalg import eigvals
from scipy.optimize import brentq

import mtb_rs as mtb
from mtb_rs.base.files import output_folder
from mtb_rs.pictures.quantities import LINE_COLOURS

plt.style.use("mtb_rs.pictures")

RADIUS, FORCE, FRICTION = 0.46, 60e3, 0.3
#: Masses [kg] and moments of inertia about z [kg m2] of wheelset and frame, and of a wheelset about its axle.
WHEELSET, FRAME = (1500.0, 900.0, 110.0), (2600.0, 3000.0)
#: Half of the distance of the wheelsets, and of the axle boxes across [m].
AXLES, BOXES = 1.25, 1.0
#: Springs of an axle box along and across [N/m], and from the frame to the vehicle across [N/m], [N s/m] and
#: against yawing [N m], [N m s].
BOX = (6e6, 5e6)
VEHICLE = ((4e5, 3e4), (3e5, 1e5))


def measured_wheel(folder: Path) -> mtb.Profile:
    """S1002, worn by a millimetre about the tape circle, measured with noise and read from a file."""
    new = mtb.Profile.standard("S1002")
    first, last = new.arc_length([-0.06, 0.058])
    s = np.arange(float(first), float(last), 1e-4)
    y = new.position(s)
    worn = new.height(y) + 1e-3 * np.exp(-0.5 * ((y - 5e-3) / 15e-3) ** 2)
    noise = 2e-6 * np.random.default_rng(4).standard_normal((2, y.size))
    points = 1e3 * (np.array([y, worn]) + noise)
    file = folder / "worn_wheel.whl"
    header = f"ProgramName=MiniProf Windows\nXYPoints={y.size}\nColumnDef=X,Y\n\n"
    file.write_text(header + "".join(f"{a:.5f}\t{b:.5f}\n" for a, b in points.T), encoding="utf-8")
    return mtb.Profile.from_file(file).smoothed(wavelength=8e-3)


class Wheelset:
    """Contacts of a wheelset at a speed; its coordinates are y, yaw and turn about the axle, without
    that of rolling on the tape circles."""

    def __init__(self, wheels: mtb.PreparedWheels, speed: float) -> None:
        self.wheels, self.speed = wheels.copy(), speed
        # the roll that was found, where, and its change with coordinates and their rates
        self.roll: float | None = None
        self.at, self.tilt = np.zeros(6), np.zeros(6)
        self.change = np.zeros((3, 6))

    def step(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Force (y, yaw, about the axle) on the wheelset, and minus its derivatives by q and by v (3, 3)."""
        turning = self.speed / RADIUS + v[2]
        place = [0.0, q[0], np.nan, np.nan, 0.0, q[1]]
        # the axle rolls as the contacts let it; the last step foretells how far
        if self.roll is None:
            self.roll, self.at = float(self.wheels.step(place, self.speed).pose[3]), np.append(q, v)
        roll = self.roll + float(self.tilt @ (np.append(q, v) - self.at))
        motion = [self.speed, v[0], 0.0, -turning * q[1], turning, turning * roll + v[1]]
        out = self.wheels.step(place, motion)
        # where the plane of a contact turns and the force jumps, the derivatives of the last step serve
        with contextlib.suppress(ValueError):
            self._derive(out, np.append(q, v), turning, roll)
        self.roll, self.at = float(out.pose[3]), np.append(q, v)
        force = -np.array([out.force[1], out.moment[2], out.moment[1]])
        return force, self.change[:, :3], self.change[:, 3:]

    def _derive(self, out: mtb.WheelStep, at: np.ndarray, turning: float, roll: float) -> None:
        # pose and velocity by the coordinates and their rates, and by the roll
        pose, velocity, by_roll = np.zeros((6, 6)), np.zeros((6, 6)), np.zeros(6)
        pose[1, 0] = pose[5, 1] = velocity[1, 3] = velocity[5, 4] = velocity[4, 5] = 1.0
        velocity[3, [1, 5]] = -turning, -at[1]
        velocity[5, 5], by_roll[5] = roll, turning
        by_pose, by_velocity = (out.derivative("pose", by)[3] for by in ("pose", "velocity"))
        self.tilt = (by_pose @ pose + by_velocity @ velocity) / (1.0 - by_velocity @ by_roll)
        velocity += np.outer(by_roll, self.tilt)
        self.change = self._of(out, "pose") @ pose + self._of(out, "velocity") @ velocity

    @staticmethod
    def _of(out: mtb.WheelStep, by: str) -> np.ndarray:
        """Derivatives of the forces on the rails (3, 6)."""
        force, moment = out.derivative("force", by), out.derivative("moment", by)
        return np.stack([force[1], moment[2], moment[1]])


def suspension() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass, damping and stiffness of front wheelset, rear one (y, yaw, turn) and frame (y, yaw), (8, 8)."""
    mass = np.diag([*WHEELSET, *WHEELSET, *FRAME])
    damping, stiffness = np.zeros((8, 8)), np.zeros((8, 8))

    def spring(of: dict[int, float], k: float, c: float = 0.0) -> None:
        row = np.zeros(8)
        row[list(of)] = list(of.values())
        stiffness[:] += k * np.outer(row, row)
        damping[:] += c * np.outer(row, row)

    for first, arm in ((0, AXLES), (3, -AXLES)):
        spring({first: -1.0, 6: 1.0, 7: arm}, 2.0 * BOX[1])
        spring({first + 1: -1.0, 7: 1.0}, 2.0 * BOX[0] * BOXES**2)
    spring({6: 1.0}, *VEHICLE[0])
    spring({7: 1.0}, *VEHICLE[1])
    return mass, damping, stiffness


def growth(wheels: mtb.PreparedWheels, speed: float) -> float:
    """Largest growth rate of the straight run at a speed [1/s]."""
    mass, damping, stiffness = suspension()
    straight, rate = Wheelset(wheels, speed), np.zeros(3)
    for _ in range(4):
        # the wheels roll on other circles than the tape circles, without a moment about the axle
        force, by_place, by_rate = straight.step(np.zeros(3), rate)
        rate[2] += force[2] / by_rate[2, 2]
    for first in (0, 3):
        one = slice(first, first + 3)
        stiffness[one, one] += by_place
        damping[one, one] += by_rate
    inverse = np.linalg.inv(mass)
    first_order = np.block([[np.zeros((8, 8)), np.eye(8)], [-inverse @ stiffness, -inverse @ damping]])
    found = eigvals(first_order)
    return float(found[np.abs(found.imag) > 1.0].real.max())


class Run:
    """A bogie, or a wheelset alone, that runs down the track; `q` (steps, coordinates) and `time`."""

    def __init__(
        self, wheels: mtb.PreparedWheels, speed: float, start: float, dt: float, is_alone: bool = False
    ) -> None:
        self.dt, self.speed = dt, speed
        self.sets = [Wheelset(wheels, speed) for _ in range(1 if is_alone else 2)]
        mass, damping, stiffness = suspension()
        if is_alone:
            mass, damping, stiffness = mass[:3, :3], np.zeros((3, 3)), np.zeros((3, 3))
        container = exu.SystemContainer()
        self.mbs = container.AddSystem()
        self.container = container
        nodes = [self._node([start, 0.0, 0.0]) for _ in self.sets]
        every = nodes if is_alone else [*nodes, self._node([start, 0.0])]
        self.mbs.AddObject(
            item.ObjectGenericODE2(
                nodeNumbers=every, massMatrix=mass, dampingMatrix=damping, stiffnessMatrix=stiffness
            )
        )
        self.contacts = [
            self.mbs.AddObject(
                item.ObjectGenericODE2(
                    nodeNumbers=[node],
                    stiffnessMatrix=np.zeros((3, 3)),
                    dampingMatrix=np.zeros((3, 3)),
                    forceVector=np.zeros(3),
                )
            )
            for node in nodes
        ]
        self.mbs.Assemble()
        self.found: list[np.ndarray] = []

    def _node(self, at: list[float]) -> Any:
        node: Any = item.NodeGenericODE2
        return self.mbs.AddNode(
            node(
                referenceCoordinates=[0.0] * len(at),
                initialCoordinates=at,
                initialCoordinates_t=[0.0] * len(at),
                numberOfODE2Coordinates=len(at),
            )
        )

    def _before_step(self, mbs: Any, _time: float) -> bool:
        q, v = mbs.systemData.GetODE2Coordinates(), mbs.systemData.GetODE2Coordinates_t()
        self.found.append(q.copy())
        for k, (one, contact) in enumerate(zip(self.sets, self.contacts, strict=True)):
            at, rate = q[3 * k : 3 * k + 3], v[3 * k : 3 * k + 3]
            force, by_place, by_rate = one.step(at, rate)
            mbs.SetObjectParameter(contact, "stiffnessMatrix", by_place)
            mbs.SetObjectParameter(contact, "dampingMatrix", by_rate)
            mbs.SetObjectParameter(contact, "forceVector", force + by_place @ at + by_rate @ rate)
        return True

    def go(self, way: float) -> Run:
        """Runs down a way [m]."""
        settings = exu.SimulationSettings()
        settings.timeIntegration.numberOfSteps = round(way / self.speed / self.dt)
        settings.timeIntegration.endTime = settings.timeIntegration.numberOfSteps * self.dt
        settings.solution.file.write = False
        settings.timeIntegration.verboseMode = 0
        self.mbs.SetPreStepUserFunction(self._before_step)
        self.mbs.SolveDynamic(settings)
        self.q = np.array(self.found)
        self.time = self.dt * np.arange(len(self.q))
        return self

    def growth(self) -> float:
        """Growth rate [1/s], from the largest shifts of all half waves but the first ones."""
        y = self.q[:, 0]
        turn = np.flatnonzero((np.abs(y[1:-1]) >= np.abs(y[:-2])) & (np.abs(y[1:-1]) > np.abs(y[2:]))) + 1
        turn = turn[2:]
        return float(np.polyfit(self.time[turn], np.log(np.abs(y[turn])), 1)[0])


def wavelength(run: Run) -> float:
    """Of the path of a wheelset [m], between its first and its last crossing of the middle."""
    y, x = run.q[:, 0], run.speed * run.time
    at = np.flatnonzero(y[:-1] * y[1:] < 0.0)
    cross = x[at] - y[at] * (x[at + 1] - x[at]) / (y[at + 1] - y[at])
    return 2.0 * float(cross[-1] - cross[0]) / (len(cross) - 1)


def animate(run: Run, path: Path) -> None:
    """The bogie from above, and the shifts of its wheelsets."""
    figure, (above, below) = plt.subplots(2, 1, figsize=(7.2, 5.6), height_ratios=(1.4, 1.0))
    above.set_xlim(-2.6, 2.6)
    above.set_ylim(-1.3, 1.3)
    above.set_aspect("equal")
    above.set_xlabel("along the bogie [m]")
    above.set_ylabel("across [m]")
    above.set_title(f"Bogie at {3.6 * run.speed:.0f} km/h, motion enlarged 30 times")
    for y in (-0.75, 0.75):
        above.axhline(y, color="#999999", lw=5.0, zorder=0)
    bars = [above.plot([], [], color=c, lw=3.0)[0] for c in LINE_COLOURS[:2]]
    wheels = [above.plot([], [], color="#333333", lw=6.0, solid_capstyle="butt")[0] for _ in range(4)]
    (frame,) = above.plot([], [], color="#555555", lw=1.5)
    shifts = 1e3 * run.q[:, [0, 3]]
    lines = [
        below.plot([], [], color=c, label=name)[0]
        for c, name in zip(LINE_COLOURS, ("front wheelset", "rear wheelset"), strict=False)
    ]
    below.set_xlim(0.0, run.time[-1])
    below.set_ylim(1.1 * shifts.min(), 1.7 * shifts.max())
    below.set_xlabel("time [s]")
    below.set_ylabel("lateral shift [mm]")
    below.legend(loc="upper center", ncols=2)
    every = max(1, len(run.q) // 150)

    def draw(k: int) -> None:
        q = run.q[k * every]
        for j, arm in enumerate((AXLES, -AXLES)):
            y, yaw = 30.0 * q[3 * j], 30.0 * q[3 * j + 1]
            across = np.array([-0.95, 0.95])
            bars[j].set_data(arm - yaw * across, y + across)
            for side, at in enumerate((-0.75, 0.75)):
                along = np.array([-RADIUS, RADIUS])
                wheels[2 * j + side].set_data(arm - yaw * at + along, y + at + yaw * along)
        corners = np.array([[-1.7, -0.55], [1.7, -0.55], [1.7, 0.55], [-1.7, 0.55], [-1.7, -0.55]])
        y, yaw = 30.0 * q[6], 30.0 * q[7]
        frame.set_data(corners[:, 0] - yaw * corners[:, 1], y + corners[:, 1] + yaw * corners[:, 0])
        for line, shift in zip(lines, shifts.T, strict=True):
            line.set_data(run.time[: k * every + 1], shift[: k * every + 1])

    FuncAnimation(figure, draw, frames=(len(run.q) - 1) // every).save(path, PillowWriter(fps=15), dpi=80)
    plt.close(figure)


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the pictures")
parser.add_argument("--short", action="store_true", help="coarse contacts, short runs, no animation")
arguments = parser.parse_args()
folder = Path(arguments.output)

wheel = measured_wheel(folder)
running = mtb.wheelset_geometry(wheel, "60E1", axle="free")
amplitude = 1e-3
klingel = float(mtb.klingel_wavelength(running.equivalent_conicity(amplitude)))
coarse, fine = (
    mtb.scenes.wheel_on_rail(
        wheel, "60E1", lateral=0.0, force=FORCE, wheel_radius=RADIUS, spacing=spacing
    ).prepare(side="both", friction=mtb.Coulomb(FRICTION))
    for spacing in (2e-3, 1e-3)
)
contacts = coarse if arguments.short else fine

dt, waves, seconds = (4e-3, 1.1, 0.8) if arguments.short else (2e-3, 3.1, 1.0)
free = Run(contacts, 5.0, amplitude, dt, is_alone=True).go(waves * klingel)
length = wavelength(free)
print(f"conicity at {1e3 * amplitude:.0f} mm: {float(running.equivalent_conicity(amplitude)):.3f}")
print(f"path of a free wheelset: wavelength {length:.2f} m, by Klingel {klingel:.2f} m")

speeds = np.arange(20.0, 101.0, 40.0 if arguments.short else 8.0)
rates = np.array([growth(contacts, speed) for speed in speeds])
critical = float(brentq(lambda speed: growth(contacts, speed), 20.0, 100.0, xtol=0.02))
print(f"critical speed by eigenvalues: {critical:.1f} m/s ({3.6 * critical:.0f} km/h)")

tried = critical * np.array([1.1] if arguments.short else [0.85, 1.0, 1.15])
small = [Run(contacts, speed, 1e-5, 2e-3).go(seconds * speed) for speed in tried]
foretold, measured = np.array([(growth(contacts, run.speed), run.growth()) for run in small]).T
print("speed [m/s]  growth by eigenvalues [1/s]  in a run [1/s]")
for row in zip(tried, foretold, measured, strict=True):
    print("{:11.1f} {:28.3f} {:15.3f}".format(*row))

figure, panels = plt.subplots(2 if arguments.short else 3, 1, figsize=(7.2, 6.0 if arguments.short else 9.0))
path, over = panels[:2]
x = free.speed * free.time
path.plot(x, 1e3 * free.q[:, 0], label="wheelset")
path.plot(x, 1e3 * amplitude * np.cos(2.0 * np.pi * x / klingel), "--", label="Klingel's wavelength")
path.set_xlabel("way [m]")
path.set_ylabel("lateral shift [mm]")
path.set_title("A free wheelset that rolls at 5 m/s")
path.set_ylim(-1.1, 1.6)
path.legend(loc="upper center", ncols=2)
over.axhline(0.0, color="#888888", lw=1.0)
over.plot(3.6 * speeds, rates, label="eigenvalues")
over.plot(3.6 * tried, measured, "o", label="runs")
over.set_xlabel("speed [km/h]")
over.set_ylabel("growth rate [1/s]")
over.set_title("The straight run of the bogie")
over.legend()

if not arguments.short:
    hunting = Run(coarse, 1.1 * critical, 2e-3, 1e-3).go(2.5 * 1.1 * critical)
    last = 1e3 * np.abs(hunting.q[-500:, 0]).max()
    print(f"above it, at {hunting.speed:.0f} m/s, the oscillation ends at {last:.1f} mm")

    shift = panels[2]
    for column, name in ((0, "front wheelset"), (3, "rear wheelset")):
        shift.plot(hunting.time, 1e3 * hunting.q[:, column], label=name)
    shift.set_xlabel("time [s]")
    shift.set_ylabel("lateral shift [mm]")
    shift.set_title(f"Hunting at {3.6 * hunting.speed:.0f} km/h")
    shift.set_ylim(-8.0, 11.0)
    shift.legend(loc="upper center", ncols=2)
    animate(hunting, folder / "bogie_on_a_track.gif")
figure.savefig(folder / "bogie_on_a_track.png")

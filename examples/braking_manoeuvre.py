# SPDX-License-Identifier: MIT OR Apache-2.0
"""What does a magnet with several pole shoes do while a vehicle brakes from 160 km/h to rest?

exudyn (extra `mbs`) integrates the vehicle's share, the magnet frame and the pole shoes in the vertical
plane; each shoe moves along the rail, up and down and pitches, between drivers with stops and under lifting
springs. The contact of each shoe is solved once per time step, before it (``PreStepUserFunction``): explicit
coupling. Each load enters with its tangent from the start of the ride, which makes the step linearly implicit
in the stiff contact; without it steps had to resolve the shoe on its contact, at several kilohertz. What the
size of the step costs is measured.

Heat and wear are slow beside the vibrations: ``mtb.brake`` computes them over the whole stop, in steps of up
to a second, of shoes that are driven by their tops. The multibody ride takes from it what wear and expansion
add to the gaps, in each of its steps.

Programs that import functional mock-up units take the contacts by ``PreparedContact.save_fmu``.

Masses, dimensions, springs and tables are assumed, of plausible size; they are not those of a vehicle.

What to see in braking.gif: the six shoes over the rail, their pitch enlarged 2000 times, and the pressure
below each of them (red). Every shoe leans on its front. The curve is the brake force, the dot the present
moment.

What to see in braking_heat_and_wear.gif: one of the shoes that are pulled in full. The new sole bears on its
edges, heat bows it within a tenth of a second, and wear makes its pressure a straight rise to the front. The
rear is hotter than the front, below which the cold rail enters.

What to see in braking_heat_and_wear.png: above, the hottest point of the outer and of an inner shoe; in the
middle, the pressure along the inner one; below, both soles before and after the stop.

What to see in braking.png: relative errors over the length of the step and over the processor time. All fall
with the step; the table (squares) is good for way and force, but not for the peak pressure.

What to see in braking_histories.png: the brake force grows as the vehicle slows down, because friction does.
The table gives the same force within half a per cent; pitch and peak pressure differ between the shoes. The
pale lines are of the same ride on soles that do not wear: a worn sole presses evenly, without the jumps of
the highest point, and the shoe pitches forward as its front wears.

Usage: braking_manoeuvre.py [-o DIRECTORY] [--short]. Writes histories, the comparison with a table (CSV and
PNG) and animations (GIF); `--short` brakes a magnet of two shoes from 10 km/h and draws nothing.
"""

from __future__ import annotations

import argparse
import csv
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import exudyn as exu
import exudyn.itemInterface as item
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter

import mtb_rs as mtb
from mtb_rs.base.files import output_folder
from mtb_rs.pictures.quantities import LINE_COLOURS

plt.style.use("mtb_rs.pictures")

FRICTION = mtb.VelocityTable((0.0, 5.0, 15.0, 30.0, 50.0), (0.35, 0.24, 0.16, 0.12, 0.10))
MAGNET = mtb.VelocityTable((0.0, 20.0, 50.0), (3.0e6, 2.6e6, 2.0e6))
#: Below this speed [m/s] friction and the disc brake fall to zero; a real brake sticks.
STANDSTILL = 0.25
#: Wear coefficients of shoe and rail [1/Pa], and resistance of the contact to heat [K m2/W].
WEAR, RAIL_WEAR, RESISTANCE = 1e-13, 1e-15, 1e-5
#: Height of the shoes' centre of mass over the rail, where the drivers push [m].
CENTRE = 0.020
#: Between two pressure fields that are kept [s].
MAP_INTERVAL = 0.02
#: Sizes of the step that are compared at the end of the ride [s].
STEPS = (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4)


@dataclass(frozen=True)
class Brake:
    """Assumed data of the vehicle's share on one magnet; pairs: along x and z, or stiffness and damping."""

    speed: float = 160.0 / 3.6
    vehicle_mass: float = 10e3
    disc_brake: float = 7e3  # what the other brakes give this share [N]
    frame_mass: float = 90.0
    frame_inertia: float = 12.0
    frame_spring: tuple[float, float] = (6e6, 4e5)  # to the bogie [N/m]
    frame_damper: tuple[float, float] = (6e4, 8e3)  # [N s/m]
    pull: tuple[float, ...] = (0.85, 1.0, 1.0, 1.0, 1.0, 0.85)  # share of the magnetic pressure by shoe
    distance: float = 0.11  # of the shoes
    shoe_mass: float = 6.0
    shoe_inertia: float = 0.01
    clearance: float = 1e-3  # of a shoe between its drivers, to each side
    stop: tuple[float, float] = (5e7, 8e3)  # of the drivers
    guide: tuple[float, float] = (1e5, 5e2)  # along x within the clearance
    lift: tuple[float, float] = (2e4, 4e2)  # each of the two vertical springs of a shoe
    lift_base: float = 0.06  # their distance
    contact_damping: float = 0.05  # of the shoe on the rail, share of the critical one
    lift_force: float = 300.0  # both of them on a lowered shoe, less its weight [N]
    wave: tuple[float, float] = (2e-4, 3.0)  # amplitude and length of the rail's irregularity [m]

    @property
    def seats(self) -> np.ndarray:
        """x of each shoe in the frame [m]."""
        n = len(self.pull)
        return self.distance * (0.5 * (n - 1) - np.arange(n))

    @property
    def frame_turn(self) -> tuple[float, float]:
        """Stiffness and damping of the frame against pitching: its springs stand at both ends."""
        arm = 0.5 * self.distance * len(self.pull)
        return self.frame_spring[1] * arm**2, self.frame_damper[1] * arm**2

    def rail(self, x: Any) -> np.ndarray:
        """Height [m] and slope [-] of the rail, (2, ...)."""
        height, length = self.wave
        k = 2.0 * np.pi / length
        return height * np.array([np.sin(k * x), k * np.cos(k * x)])

    def rail_rate(self, x: float) -> np.ndarray:
        """Their change along the rail, (2,) [-], [1/m]."""
        height, length = self.wave
        k = 2.0 * np.pi / length
        return height * k * np.array([np.cos(k * x), -k * np.sin(k * x)])


class Shoe:
    """Contact of a shoe: both poles, of which the left one is solved and the right one its mirror image."""

    def __init__(self, contact: mtb.PreparedContact, share: float) -> None:
        self.contact, self.share = contact.copy(), share
        # left alone, the contact carries what the magnet pulls
        free = self.contact.step([0.0, 0.0, np.nan, 0.0, np.nan, 0.0], 10.0, magnetic_pressure=1e6)
        self.pulled_area = -2.0 * float(free.force[2]) / 1e6

    def pressure(self, speed: float) -> float:
        """Magnetic pressure [Pa]."""
        return self.share * float(np.interp(abs(speed), MAGNET.velocity, MAGNET.value))

    def step(
        self, place: np.ndarray, speed: float, dt: float | None = None, opened: np.ndarray | None = None
    ) -> tuple[np.ndarray, Any]:
        """Load (x, z, pitch nose up) of contact and magnet on a shoe at a place (z, pitch) over the rail,
        with a gap that heat and wear have `opened` (n,) [m]."""
        pressure = self.pressure(speed)
        pose = [0.0, 0.0, place[0], 0.0, -place[1], 0.0]
        out = self.contact.step(pose, speed, dt, magnetic_pressure=pressure, gap=opened)
        load = -2.0 * np.array([out.force[0], out.force[2], -out.moment[1]])
        load[1] -= pressure * self.pulled_area
        return load, out

    @staticmethod
    def stiffness(out: mtb.StepResult) -> np.ndarray:
        """Minus the change of the load (x, z, pitch) with the place, (3, 2), from the factors of a step."""
        force, moment = (out.derivative(of, "pose")[:, [2, 4]] * [1.0, -1.0] for of in ("force", "moment"))
        return 2.0 * np.stack([force[0], force[2], -moment[1]])

    def balance(self, load: np.ndarray, speed: float) -> np.ndarray:
        """The place where the contact carries `load` (z, pitch)."""
        place = np.zeros(2)
        for _ in range(30):
            carried, out = self.step(place, speed)
            change = np.linalg.solve(self.stiffness(out)[1:], carried[1:] + load)
            place += change
            if np.abs(change).max() < 1e-13:
                return place
        raise RuntimeError("the shoe finds no balance on the rail")


def drag(force: float, speed: float) -> tuple[float, float]:
    """A brake's force over a step, and the damping that takes its place close to standstill."""
    slow = 0.0 < abs(speed) < STANDSTILL
    return (0.0, float(-force / speed)) if slow else (float(force), 0.0)


class Ride:
    """The multibody system, loaded by the contacts, and its history: (steps, ...) or (steps, shoes)."""

    def __init__(
        self, brake: Brake, contact: mtb.PreparedContact, dt: float, stop: mtb.Braking | None = None
    ) -> None:
        self.brake, self.dt, self.stop = brake, dt, stop
        self.shoes = [Shoe(contact, share) for share in brake.pull]
        self.inner = inner(contact.points)
        self.records: list[tuple[Any, ...]] = []
        self.maps: list[np.ndarray] = []
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self._build()

    def _build(self) -> None:
        b, mbs = self.brake, self.mbs
        nothing = mbs.AddNode(item.NodePointGround())
        self.ground = mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=nothing, coordinate=0))
        vehicle = mbs.AddNode(item.Node1D(referenceCoordinates=[0.0], initialVelocities=[b.speed]))
        mbs.AddObject(item.Mass1D(mass=b.vehicle_mass, nodeNumber=vehicle))
        share = self._coordinate(vehicle, 0)
        frame_node, frame = self._body(0.0, b.frame_mass, b.frame_inertia, np.zeros(3), np.zeros(2))
        along, up, turn = (self._coordinate(frame_node, c) for c in range(3))
        self._spring(share, along, b.frame_spring[0], b.frame_damper[0])
        self._spring(self.ground, up, 2.0 * b.frame_spring[1], 2.0 * b.frame_damper[1])
        self._spring(self.ground, turn, 2.0 * b.frame_turn[0], 2.0 * b.frame_turn[1])
        self.disc = (
            mbs.AddLoad(item.LoadCoordinate(markerNumber=share, load=0.0)),
            self._spring(self.ground, share, 0.0, 0.0),
        )
        self.contacts = []
        self.acting: list[np.ndarray | None] = [None] * len(self.shoes)
        for shoe, seat in zip(self.shoes, b.seats, strict=True):
            place = shoe.balance(np.array([b.lift_force, 0.0]), b.speed)
            (drag, *_), out = shoe.step(place, b.speed)
            tangent = np.pad(shoe.stiffness(out), ((0, 0), (1, 0)))
            # the shoe starts leaning on its driver
            lean = drag / b.stop[0] - b.clearance
            start = np.array([lean, *(b.rail(seat + lean) + place)])
            rate = b.speed * b.rail_rate(seat + lean)
            node, body = self._body(seat, b.shoe_mass, b.shoe_inertia, start, rate)
            x, z = (self._coordinate(node, c) for c in range(2))
            inertia = [0.0, b.shoe_mass, b.shoe_inertia]
            damping = 2.0 * b.contact_damping * np.sqrt(np.diag(tangent) * inertia)
            on_rail = mbs.AddObject(
                item.ObjectGenericODE2(
                    nodeNumbers=[node],
                    stiffnessMatrix=tangent,
                    dampingMatrix=np.diag(damping),
                    forceVector=np.zeros(3),
                )
            )
            self.contacts.append((on_rail, tangent, damping))
            mbs.AddLoad(item.LoadCoordinate(markerNumber=z, load=b.lift_force))
            # where the shoe leans: gap, sticking, side of the stop
            leaning = mbs.AddNode(
                item.NodeGenericData(initialCoordinates=[0.0, 0.0, 0.0], numberOfDataCoordinates=3)
            )
            mbs.AddObject(
                item.CoordinateSpringDamperExt(
                    markerNumbers=[along, x],
                    nodeNumber=leaning,
                    stiffness=b.guide[0],
                    damping=b.guide[1],
                    useLimitStops=True,
                    limitStopsLower=-b.clearance,
                    limitStopsUpper=b.clearance,
                    limitStopsStiffness=b.stop[0],
                    limitStopsDamping=b.stop[1],
                )
            )
            for arm in (-0.5 * b.lift_base, 0.5 * b.lift_base):
                places = [(frame, seat + arm), (body, arm)]
                ends = [
                    mbs.AddMarker(item.MarkerBodyPosition(bodyNumber=of, localPosition=[at, 0.0, 0.0]))
                    for of, at in places
                ]
                k, c = ([0.0, value, 0.0] for value in b.lift)
                mbs.AddObject(item.CartesianSpringDamper(markerNumbers=ends, stiffness=k, damping=c))
        mbs.Assemble()
        # the first accelerations come before the first step
        self._load(0.0)

    def _body(
        self, x: float, mass: float, inertia: float, start: np.ndarray, rate: np.ndarray
    ) -> tuple[Any, Any]:
        node = self.mbs.AddNode(
            item.NodeRigidBody2D(
                referenceCoordinates=[x, 0.0, 0.0],
                initialCoordinates=start.tolist(),
                initialVelocities=[self.brake.speed, *rate],
            )
        )
        return node, self.mbs.AddObject(item.RigidBody2D(mass=mass, inertia=inertia, nodeNumber=node))

    def _coordinate(self, node: Any, coordinate: int) -> Any:
        return self.mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))

    def _spring(self, first: Any, second: Any, stiffness: float, damping: float) -> Any:
        return self.mbs.AddObject(
            item.CoordinateSpringDamperExt(
                markerNumbers=[first, second], stiffness=float(stiffness), damping=float(damping)
            )
        )

    def _load(self, ahead: float) -> tuple[Any, ...]:
        """Solves the contacts where the shoes are and loads them for a step that ends `ahead` [s]."""
        b, mbs = self.brake, self.mbs
        q, v = mbs.systemData.GetODE2Coordinates(), mbs.systemData.GetODE2Coordinates_t()
        disc = -b.disc_brake * np.clip(v[0] / STANDSTILL, -1.0, 1.0)
        force, damping = drag(disc, v[0])
        mbs.SetLoadParameter(self.disc[0], "load", force)
        mbs.SetObjectParameter(self.disc[1], "damping", damping)
        shoes, rates = q[4:].reshape(-1, 3), v[4:].reshape(-1, 3)
        at = b.seats + shoes[:, 0]
        places = shoes[:, 1:] - b.rail(at).T
        carried = b.rail_rate(at).T * rates[:, :1]
        loads, normal, heat, pressures = [], [], [], []
        for k, shoe in enumerate(self.shoes):
            load, out = shoe.step(places[k], float(rates[k, 0]), self.dt, self._opened(k, v[0]))
            on_rail, tangent, damping = self.contacts[k]
            # what acted at the end of the last step: the gap has opened since, the shoe has not come down
            acted = load if self.acting[k] is None else self.acting[k] - tangent @ shoes[k]
            along, slowed = drag(load[0], rates[k, 0])
            # at the end of the step the rail stands elsewhere under the shoe
            there = np.append(0.0, places[k] + b.rail(at[k] + ahead * rates[k, 0]))
            with_rail = damping * np.append(0.0, carried[k])
            force = np.array([along, *load[1:]]) + tangent @ there + with_rail
            self.acting[k] = load + tangent @ there
            mbs.SetObjectParameter(on_rail, "forceVector", force)
            if slowed != damping[0]:
                damping[0] = slowed
                mbs.SetObjectParameter(on_rail, "dampingMatrix", np.diag(damping))
            loads.append(acted)
            normal.append(-2.0 * out.force[2] + acted[1] - load[1])
            more = normal[-1] / (-2.0 * out.force[2])
            heat.append(2.0 * out.friction_power * acted[0] / load[0] if load[0] else 0.0)
            pressures.append(more * out.pressure)
        return q, v, disc, loads, places, carried, normal, heat, pressures

    def _opened(self, shoe: int, speed: float) -> np.ndarray | None:
        """What heat and wear add to the gap (n,) [m] at a speed [m/s] of the vehicle."""
        if self.stop is None:
            return None
        gone, one = self.stop.speed[0] - self.stop.speed, self.stop.shoes[shoe]
        now = self.stop.speed[0] - speed
        after = int(np.searchsorted(gone, now).clip(1, len(gone) - 1))
        share = np.clip((now - gone[after - 1]) / (gone[after] - gone[after - 1]), 0.0, 1.0)
        last = one.depths[after - 1] + one.openings[after - 1]
        if after == 1:
            return share * last
        return share * last + (1.0 - share) * (one.depths[after - 2] + one.openings[after - 2])

    def _before_step(self, _mbs: Any, _time: float) -> bool:
        *found, pressures = self._load(self.dt)
        if len(self.records) % round(MAP_INTERVAL / self.dt) == 0:
            self.maps.append(np.array(pressures))
        self.records.append((*found, [p[self.inner].max() for p in pressures]))
        return True

    def solve(self, duration: float) -> Ride:
        """Rides for a while [s]."""
        self.mbs.SetPreStepUserFunction(self._before_step)
        settings = exu.SimulationSettings()
        settings.timeIntegration.numberOfSteps = round(duration / self.dt)
        settings.timeIntegration.endTime = duration
        settings.timeIntegration.generalizedAlpha.spectralRadius = 0.7
        settings.solution.file.write = False
        settings.timeIntegration.verboseMode = 0
        clock = time.process_time()
        self.mbs.SolveDynamic(settings)
        self.seconds = time.process_time() - clock
        names = ("q", "v", "disc", "loads", "place", "carried", "normal", "heat", "peak")
        for name, column in zip(names, zip(*self.records, strict=True), strict=True):
            setattr(self, name, np.array(column))
        self.records = []
        self.time = self.dt * np.arange(len(self.q))
        return self

    def energy(self) -> dict[str, float]:
        """Kinetic energy lost and where it went [J], from the histories by the trapezoidal rule."""
        b = self.brake
        inertia = np.array([b.vehicle_mass, b.frame_mass, b.frame_mass, b.frame_inertia])
        inertia = np.append(inertia, np.tile([b.shoe_mass, b.shoe_mass, b.shoe_inertia], len(self.shoes)))
        kinetic = 0.5 * (inertia * self.v**2).sum(axis=1)

        def relative(state: np.ndarray) -> list[tuple[np.ndarray, float, float]]:
            """What each spring is stretched by, its stiffness and damping."""
            x, (fx, fz, turn) = state[:, 0], state[:, 1:4].T
            sx, sz, pitch = state[:, 4:].reshape(len(state), -1, 3).transpose(2, 1, 0)
            found = [
                (fx - x, b.frame_spring[0], b.frame_damper[0]),
                (fz, 2.0 * b.frame_spring[1], 2.0 * b.frame_damper[1]),
                (turn, 2.0 * b.frame_turn[0], 2.0 * b.frame_turn[1]),
            ]
            for k, seat in enumerate(b.seats):
                found.append((sx[k] - fx, *b.guide))
                for arm in (-0.5 * b.lift_base, 0.5 * b.lift_base):
                    found.append((sz[k] + arm * pitch[k] - fz - (seat + arm) * turn, *b.lift))
            return found

        stretch, rate = relative(self.q), relative(self.v)
        springs = sum(0.5 * k * s**2 for s, k, _ in stretch)
        damped = sum(c * s**2 for s, _, c in rate)
        behind = self.q[:, 4::3] - self.q[:, 1:2]
        over = np.sign(behind) * np.maximum(np.abs(behind) - b.clearance, 0.0)
        springs = springs + (0.5 * b.stop[0] * over**2).sum(axis=1)
        damped = damped + (b.stop[1] * (over != 0.0) * (self.v[:, 4::3] - self.v[:, 1:2]) ** 2).sum(axis=1)

        # contact, magnet and lifting springs carry the shoe over the irregular rail
        up = self.v[:, 4:].reshape(len(self.v), -1, 3)[:, :, 1:]
        damping = np.array([c[1:] for _, _, c in self.contacts])
        upwards = self.loads[:, :, 1:] - damping * (up - self.carried)
        lifted = (upwards * up).sum(axis=(1, 2)) + b.lift_force * up[:, :, 0].sum(axis=1)

        def integral(power: np.ndarray) -> float:
            return float(np.trapezoid(power, dx=self.dt))

        return {
            "kinetic energy lost": float(kinetic[0] - kinetic[-1]),
            "friction": integral(self.heat.sum(axis=1)),
            "disc brake": integral(-self.disc * self.v[:, 0]),
            "dampers": integral(damped),
            "springs": float(springs[-1] - springs[0]),
            "vertical work of contact and magnet": -integral(lifted),
        }

    def open_energy(self) -> float:
        """Share of the kinetic energy lost that the balance does not explain."""
        energy = self.energy()
        lost = energy.pop("kinetic energy lost")
        return (lost - sum(energy.values())) / lost

    def brake_force(self) -> np.ndarray:
        """Of all shoes (steps,) [N]."""
        return -self.loads[:, :, 0].sum(axis=1)


class Table:
    """The same brake as a table over the velocity; vehicle and brake are one mass on a smooth rail."""

    def __init__(self, brake: Brake) -> None:
        self.brake = brake
        clock = time.process_time()
        self.velocity = np.array([0.25, 1.0, 2.5, 5.0, 7.5, 10.0, 12.5, 15.0, 20.0, 25.0, 30.0, 40.0, 45.0])
        rows = []
        for v in self.velocity:
            result = SCENE.with_(velocity=float(v)).solve(model="elastic-upper")
            peak = result.pressure.ravel()[inner(result.points.reshape(3, -1))].max()
            rows.append((2.0 * result.force[0], -2.0 * result.force[2], peak))
        self.force, self.normal, self.peak = np.array(rows).T
        self.sweep_seconds = time.process_time() - clock

    def carried(self, v: Any, share: float) -> Any:
        """Normal force of a shoe [N]: what the magnet pulls, less what the springs lift."""
        return share * np.interp(v, self.velocity, self.normal) - self.brake.lift_force

    def brake_force(self, v: Any) -> Any:
        """Of all shoes [N]."""
        friction = np.interp(v, self.velocity, self.force) / np.interp(v, self.velocity, self.normal)
        carried = sum(self.carried(v, share) for share in self.brake.pull)
        return friction * carried * np.minimum(1.0, v / STANDSTILL)

    def peaks(self, v: np.ndarray) -> np.ndarray:
        """Peak pressure of each shoe (steps, shoes) [Pa], in proportion to its load."""
        each = [self.carried(v, share) for share in self.brake.pull]
        peak = np.interp(v, self.velocity, self.peak) / np.interp(v, self.velocity, self.normal)
        return np.stack([peak * normal for normal in each], axis=1)

    def ride(self, dt: float, duration: float) -> None:
        """The midpoint rule."""
        b, clock = self.brake, time.process_time()
        mass = b.vehicle_mass + b.frame_mass + b.shoe_mass * len(b.pull)

        def slow_down(v: float) -> float:
            return -float(self.brake_force(v) + b.disc_brake * min(1.0, v / STANDSTILL)) / mass

        v, x = b.speed, 0.0
        states = []
        for _ in range(round(duration / dt)):
            states.append((v, x))
            middle = v + 0.5 * dt * slow_down(v)
            v, x = v + dt * slow_down(middle), x + dt * middle
        self.speed, self.way = np.array(states).T
        self.time = dt * np.arange(len(states))
        self.seconds = time.process_time() - clock


def heated_and_worn(brake: Brake, table: Table) -> mtb.Braking:
    """The stop with heat and wear of one side, poles of six shoes: half of the masses and forces.

    What the springs lift is taken off the shares of the pull.
    """
    lifted = brake.lift_force / table.normal.mean()
    mass = brake.vehicle_mass + brake.frame_mass + brake.shoe_mass * len(brake.pull)
    return mtb.brake(
        SCENE, brake.speed, 0.5 * mass, 0.5 * brake.disc_brake, shares=np.array(brake.pull) - lifted,
        tolerance=0.2, expansion=True, wear=WEAR, lower_wear=RAIL_WEAR, resistance=RESISTANCE, share=0.0,
    )  # fmt: skip


def inner(points: np.ndarray) -> np.ndarray:
    """Points away from the edges, where pressures are singular."""
    x, y = points[:2]
    return (np.abs(x) < x.max() - 1e-6) & (y > y.min() + 1e-6) & (y < y.max() - 1e-6)


def stopping_time(table: Table) -> float:
    """Time to rest by the table, and a little more [s]."""
    table.ride(1e-2, 120.0)
    return 1e-2 * float(np.argmax(table.speed < 0.02)) + 0.5


def differences(ride: Ride | Table, truth: Ride) -> dict[str, float]:
    """Relative errors: way to rest, brake force and peak pressures (root mean square) against `truth`."""
    at = np.arange(0.1, truth.time[-1] - 1.0, 0.01)
    moments = np.interp(at, truth.time, np.arange(len(truth.time))).round().astype(int)
    force, peaks = truth.brake_force()[moments], truth.peak[moments]
    if isinstance(ride, Table):
        speed = np.interp(at, ride.time, ride.speed)
        found, found_peaks, way = ride.brake_force(speed), ride.peaks(speed), ride.way[-1]
    else:
        found = np.interp(at, ride.time, ride.brake_force())
        found_peaks = np.stack([np.interp(at, ride.time, p) for p in ride.peak.T], axis=1)
        way = ride.q[-1, 0]
    return {
        "way_error": float(way / truth.q[-1, 0] - 1.0),
        "brake_force_error": float(np.sqrt(np.mean((found / force - 1.0) ** 2))),
        "peak_pressure_error": float(np.sqrt(np.mean((found_peaks / peaks - 1.0) ** 2))),
    }


def compared(brake: Brake, contact: mtb.PreparedContact, steps: tuple[float, ...]) -> list[dict[str, Any]]:
    """Rides with all steps, and the table's, against the ride with the smallest step."""
    table = Table(brake)
    duration = stopping_time(table)
    table.ride(1e-3, duration)
    *rides, truth = (Ride(brake, contact, dt).solve(duration) for dt in steps)
    rows = []
    for ride in (*rides, truth):
        open_energy = {"open_energy": ride.open_energy()}
        row = {"model": "contact every step", "dt_s": ride.dt, "seconds": ride.seconds, "beforehand_s": 0.0}
        rows.append(row | differences(ride, truth) | open_energy)
    row = {"model": "table", "dt_s": 1e-3, "seconds": table.seconds, "beforehand_s": table.sweep_seconds}
    rows.append(row | differences(table, truth) | {"open_energy": float("nan")})
    return rows


def write(rows: list[dict[str, Any]], path: Path) -> None:
    """Rows as CSV, numbers to six digits."""
    with path.open("w", newline="") as stream:
        table = csv.DictWriter(stream, rows[0])
        table.writeheader()
        for row in rows:
            table.writerow({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in row.items()})


def write_histories(ride: Ride, path: Path) -> None:
    """Every tenth of a second."""
    every = round(0.1 / ride.dt)
    force = ride.brake_force()
    rows = []
    for k in range(0, len(ride.time), every):
        row = {
            "time_s": float(ride.time[k]),
            "speed_m_s": float(ride.v[k, 0]),
            "way_m": float(ride.q[k, 0]),
            "brake_force_N": float(force[k]),
        }
        for shoe in range(len(ride.shoes)):
            row[f"normal_force_{shoe + 1}_N"] = float(ride.normal[k, shoe])
            row[f"pitch_{shoe + 1}_rad"] = float(ride.place[k, shoe, 1])
            row[f"peak_pressure_{shoe + 1}_Pa"] = float(ride.peak[k, shoe])
        rows.append(row)
    write(rows, path)


def draw_heat_and_wear(stop: mtb.Braking, path: Path) -> None:
    """Temperature over the time, pressure and sole along the shoe."""
    figure, (hot, press, sole) = plt.subplots(3, 1, figsize=(7.4, 7.4))
    shown = {"shoe 1": stop.shoes[0], "shoe 4": stop.shoes[len(stop.shoes) // 2]}
    for name, shoe in shown.items():
        (line,) = hot.plot(shoe.time, shoe.peaks, label=f"{name}, hottest point")
        hot.plot(shoe.time, shoe.means, "--", color=line.get_color(), label=f"{name}, mean of its sole")
    hot.set(title="temperature above that of the surroundings [K]", xlabel="time [s]", xlim=(0.0, None))
    hot.legend(ncols=2, loc="lower right")
    one = shown["shoe 4"]
    grid = one.patches[0]
    x = 1e3 * grid.view(one.points[0])[0]
    for k in np.unique(np.searchsorted(one.time, (0.0, 0.1, 2.0, 30.0))):
        row = grid.view(one.pressures[k]).mean(axis=0)
        press.plot(x, 1e-6 * row, label=f"{one.time[k]:.2g} s")
    press.set(title="pressure along shoe 4, mean over its width [MPa]", ylim=(0.0, None))
    press.legend(ncols=4, loc="lower right")
    sole.axhline(0.0, color="#777777", ls="--", label="before")
    for name, shoe in shown.items():
        sole.plot(x, -1e6 * grid.view(shoe.depth).mean(axis=0), label=f"{name}, after")
    sole.set(title="sole, mean over its width [µm]", xlabel="x [mm], sliding to the right")
    sole.legend(ncols=3, loc="lower left")
    figure.savefig(path)
    plt.close(figure)


def draw_histories(ride: Ride, table: Table, new: Ride, path: Path) -> None:
    """Brake force, pitch and pressure away from the edges over the time; dashed on `new` soles."""
    figure, (speed, force, off, pitch, peak) = plt.subplots(
        5, 1, figsize=(7.4, 10.0), sharex=True, height_ratios=(1, 1.5, 1, 1.5, 1.5)
    )
    speed.plot(ride.time, 3.6 * ride.v[:, 0], color="black")
    speed.set_title("A magnet of six pole shoes brakes from 160 km/h to rest: speed [km/h]")
    force.plot(ride.time, 1e-3 * ride.brake_force())
    force.set_title("brake force [kN]")
    moving = ride.v[:, 0] > 10.0 * STANDSTILL
    tabled = np.asarray(table.brake_force(np.interp(ride.time, table.time, table.speed)))
    off.plot(ride.time[moving], 100.0 * (tabled / ride.brake_force() - 1.0)[moving], lw=0.6)
    off.set_title("brake force by a table over the velocity, off by [%]")
    # the others lie on these
    for shoe in (0, len(ride.shoes) // 2):
        pitch.plot(ride.time, 1e6 * ride.place[:, shoe, 1], linewidth=0.5)
        peak.plot(ride.time, 1e-6 * ride.peak[:, shoe], linewidth=0.5)
        colour = peak.lines[-1].get_color()
        peak.plot([], [], color=colour, label=f"shoe {shoe + 1}")
        paler = {"color": colour, "linewidth": 0.5, "alpha": 0.35}
        pitch.plot(new.time, 1e6 * new.place[:, shoe, 1], **paler)
        peak.plot(new.time, 1e-6 * new.peak[:, shoe], **paler)
        peak.plot([], [], **{**paler, "linewidth": 1.6}, label=f"shoe {shoe + 1}, sole stays new")
    pitch.set_title("pitch over the rail, nose up [µrad]")
    peak.set(title="peak pressure away from the edges [MPa]", xlabel="time [s]")
    figure.legend(*peak.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    figure.savefig(path)
    plt.close(figure)


def draw_comparison(rows: list[dict[str, Any]], path: Path) -> None:
    """What accuracy costs."""
    figure, axes = plt.subplots(1, 2, figsize=(7.4, 4.4), sharey=True)
    *rides, _truth, table = rows
    names = {
        "way_error": "way to rest",
        "brake_force_error": "brake force",
        "peak_pressure_error": "peak pressure",
    }
    for key, name in names.items():
        errors = [abs(row[key]) for row in rides]
        (line,) = axes[0].loglog([1e3 * row["dt_s"] for row in rides], errors, "o-", label=name)
        axes[1].loglog([row["seconds"] for row in rides], errors, "o-", color=line.get_color(), label=name)
        axes[1].plot(table["seconds"], abs(table[key]), "s", color=line.get_color())
    axes[1].plot(
        [], [], "s", color="#777777", label=f"table, after {table['beforehand_s']:.2g} s for its sweep"
    )
    axes[0].set(xlabel="time step [ms]", title="relative error against a step of 0.25 ms")
    axes[1].set(xlabel="processor time for a ride from 10 km/h to rest [s]")
    steps = [1e3 * row["dt_s"] for row in rides]
    axes[0].set_xticks(steps, [f"{step:g}" for step in steps])
    axes[1].set_xticks([0.1, 1.0, 10.0], ["0.1", "1", "10"])
    for axis in axes:
        axis.minorticks_off()
    figure.legend(*axes[1].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    figure.savefig(path)
    plt.close(figure)


def animate(ride: Ride, path: Path, frames: int = 60) -> None:
    """The shoes on the rail and the pressure under them."""
    b = ride.brake
    x = ride.shoes[0].contact.points[0].round(9)
    lines, of = np.unique(x, return_inverse=True)
    count = np.bincount(of)
    maps = [np.bincount(of, weights=p) / count for m in ride.maps for p in m]
    pressure = 1e-6 * np.array(maps).reshape(len(ride.maps), len(ride.shoes), -1)
    exaggerated = 2000.0
    figure, (side, history) = plt.subplots(2, 1, figsize=(7.4, 5.4), height_ratios=(3, 2))
    corners = np.array([(-0.045, 0.0), (0.045, 0.0), (0.045, 0.05), (-0.045, 0.05)])
    scale = 0.06 / pressure.max()
    side.axhline(0.0, color="0.3")
    shapes = [side.fill([], [], facecolor="#CCCCCC", edgecolor="#333333")[0] for _ in b.seats]
    fields = [side.fill([], [], color=LINE_COLOURS[1])[0] for _ in b.seats]
    side.set(
        xlim=(-0.37, 0.37),
        ylim=(-0.075, 0.075),
        xlabel="along the rail [m], moving to the right",
        ylabel="pressure [MPa]",
    )
    marks = np.arange(0.0, pressure.max(), 2.0)
    side.set_yticks(-scale * marks, [f"{mark:g}" for mark in marks])
    side.grid(visible=False)
    history.plot(ride.time, 1e-3 * ride.brake_force(), linewidth=0.8)
    (mark,) = history.plot([], [], "o", ms=7, color=LINE_COLOURS[1])
    history.set(xlabel="time [s]", ylabel="brake force [kN]")

    def show(frame: int) -> None:
        k = round(frame * (len(ride.maps) - 1) / (frames - 1))
        step = k * round(MAP_INTERVAL / ride.dt)
        for shoe, seat in enumerate(b.seats):
            turn = exaggerated * ride.place[step, shoe, 1]
            rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
            shapes[shoe].set_xy(corners @ rotation.T + (seat, 0.004))
            under = np.stack([seat + lines, -scale * pressure[k, shoe]], axis=1)
            fields[shoe].set_xy(np.vstack([(seat + lines[0], 0.0), under, (seat + lines[-1], 0.0)]))
        mark.set_data([ride.time[step]], [1e-3 * ride.brake_force()[step]])
        now = f"{3.6 * abs(ride.v[step, 0]):.0f} km/h, {ride.time[step]:.1f} s"
        side.set_title(f"{now} (pitch {exaggerated:.0f} times enlarged)")

    FuncAnimation(figure, show, frames=frames).save(path, PillowWriter(fps=8), dpi=100)
    plt.close(figure)


parser = argparse.ArgumentParser(description="A magnetic track brake from 160 km/h to rest.")
parser.add_argument("-o", "--output", type=output_folder, default=".")
parser.add_argument("--short", action="store_true", help="two shoes from 10 km/h, nothing drawn")
arguments = parser.parse_args()
#: The left pole of a shoe; finite elements on a half-space.
SCENE = mtb.scenes.pole_shoe_on_rail(
    friction=FRICTION, magnetic_pressure=MAGNET, poles=1, spacing=(6e-3, 5.2e-3)
)
contact = SCENE.prepare("elastic-upper", reference_point=(0.0, 0.0, CENTRE), standstill_speed=STANDSTILL)

slow = replace(Brake(), speed=10.0 / 3.6)
if arguments.short:
    slow = replace(slow, pull=(0.85, 1.0), vehicle_mass=3e3, disc_brake=2e3)
comparison = compared(slow, contact, STEPS[-3:] if arguments.short else STEPS)
print("model               step [ms]   errors: way  brake force  peak pressure   energy left open")
for row in comparison:
    errors = f"{row['way_error']:11.1e} {row['brake_force_error']:12.1e} {row['peak_pressure_error']:14.1e}"
    print(f"{row['model']:19} {1e3 * row['dt_s']:9.2f} {errors} {row['open_energy']:18.1e}")
write(comparison, arguments.output / "braking.csv")

if not arguments.short:
    table = Table(Brake())
    duration = stopping_time(table)
    table.ride(1e-3, duration)
    stop = heated_and_worn(Brake(), table)
    print(f"with heat and wear: {stop.way[-1]:.1f} m, hottest {stop.shoe.peaks.max():.0f} K, ", end="")
    print(f"{1e6 * stop.shoe.depth.max():.0f} um worn off")
    new, ride = (Ride(Brake(), contact, 1e-3, soles).solve(duration) for soles in (None, stop))
    print(f"{ride.q[-1, 0]:.1f} m, by the table {table.way[-1]:.1f} m; {ride.seconds:.1f} s of the processor")
    missed = differences(table, new)
    print(f"the table errs by {missed['brake_force_error']:.2%} in brake force, ", end="")
    print(f"{missed['peak_pressure_error']:.1%} in peak pressure")
    for where, joule in ride.energy().items():
        print(f"{where}: {1e-3 * joule:.2f} kJ")
    print(f"energy left open: {ride.open_energy():.1e}")
    draw_comparison(comparison, arguments.output / "braking.png")
    write_histories(ride, arguments.output / "braking_histories.csv")
    draw_histories(ride, table, new, arguments.output / "braking_histories.png")
    draw_heat_and_wear(stop, arguments.output / "braking_heat_and_wear.png")
    stop.animate(arguments.output / "braking_heat_and_wear.gif")
    animate(ride, arguments.output / "braking.gif")

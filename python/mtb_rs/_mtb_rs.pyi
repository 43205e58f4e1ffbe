# SPDX-License-Identifier: MIT OR Apache-2.0
from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

__version__: str
CONDENSATION_DIGEST: str
PATH_TOLERANCE: float
PRODUCTS_FROM: int

_Array = NDArray[np.float64]

@final
class Compliance:
    @property
    def points(self) -> int: ...
    def influence(self, observed: str, loaded: str) -> _Array: ...
    def displacement(self, traction: _Array) -> _Array: ...
    def symmetric_half(self, image: list[int]) -> Compliance: ...
    def symmetric_whole(self, image: list[int]) -> Compliance: ...
    def reflected(self, original: list[int]) -> Compliance: ...
    def transposed(self, weights: _Array) -> _Array: ...
    @staticmethod
    def relative(lower: Compliance | None, upper: Compliance | None) -> Compliance: ...
    @staticmethod
    def separate(bodies: list[Compliance]) -> Compliance: ...

@final
class ContactGeometry:
    def __new__(
        cls,
        points: _Array,
        area: _Array,
        frame: list[_Array] | None = None,
        means: tuple[list[int], list[int], _Array] | None = None,
        windows: list[tuple[int, int, int]] | None = None,
    ) -> ContactGeometry: ...
    def sliding_direction(self, along: tuple[float, float]) -> _Array: ...
    def mean_tractions(self, traction: _Array) -> _Array: ...
    def loads(self, traction: _Array) -> _Array: ...
    @property
    def tangents(self) -> _Array: ...
    def weights_of_resultants(self, about: tuple[float, float, float]) -> _Array: ...
    def weights_of_means(self, weights: _Array, pressure: _Array) -> _Array: ...

@final
class Problem:
    def __new__(
        cls,
        lower: Compliance | None,
        upper: Compliance | None,
        geometry: ContactGeometry,
        motions: _Array,
        of_upper: list[bool],
        is_pulled: list[bool] | None = None,
        products_from: int = ...,
        layer: _Array | None = None,
        hardness: _Array | None = None,
        shear: _Array | None = None,
        rough: tuple[float, float] | tuple[list[float], list[float]] | None = None,
    ) -> Problem: ...
    @property
    def pair(self) -> Compliance: ...
    @property
    def is_by_products(self) -> bool: ...
    @property
    def motions(self) -> _Array: ...
    def slide_heated(
        self,
        loading: Loading,
        direction: _Array,
        friction: _Array,
        heating: tuple[_Array, _Array, _Array, tuple[float, float], _Array | None],
        worn: tuple[_Array, _Array] | None = None,
        start: list[bool] | None = None,
        magnet: _Magnet | None = None,
        from_pull: _Array | None = None,
    ) -> tuple[Outcome, _Array, _Array, int]: ...
    def thermal_factor(
        self,
        direction: _Array,
        friction: _Array,
        heating: tuple[_Array, _Array, _Array, tuple[float, float], _Array | None],
        active: list[bool],
        diagonal: _Array | None = None,
    ) -> float: ...
    def loading(self, gap: _Array, work: _Array) -> Loading: ...
    def unpressed(self, loading: Loading) -> int | None: ...
    def with_displacement(self, loading: Loading, displacement: _Array, is_upper: bool) -> Loading: ...
    def with_pull(self, loading: Loading, pull: _Array, is_upper: bool, at_face: bool) -> Loading: ...
    def displacement(self, traction: _Array, is_upper: bool, pull: _Array | None = None) -> _Array: ...
    def prepare(self, direction: _Array, is_frictional: bool) -> bool: ...
    def slide(
        self,
        loading: Loading,
        direction: _Array,
        friction: _Array | Callable[[_Array], _Array],
        magnet: _Magnet | None = None,
        from_pull: _Array | None = None,
        share: bool = False,
    ) -> Outcome: ...
    def stick_or_slip(
        self,
        loading: Loading,
        friction: _Array,
        layer: float,
        displacements: _Array,
        tolerance: float,
    ) -> list[Outcome]: ...
    def wedging_factor(self, direction: _Array, friction: _Array) -> float: ...
    def tangent(
        self,
        pressure: _Array,
        friction: _Array,
        slope: _Array,
        direction: _Array,
        is_coupled: bool,
        by_products: bool,
        magnet: _Magnet | None = None,
        gap: _Array | None = None,
    ) -> Tangent: ...

@final
class Tangent:
    def balanced(self) -> list[int] | None: ...
    def wedging_factor(self) -> float: ...
    def opening(self) -> _Array: ...
    def inputs(self) -> list[_Array] | None: ...
    def sliding(self) -> list[_Array] | None: ...
    def magnet(self) -> _Array | None: ...
    def forward(
        self, gap: _Array, work: _Array, drag: _Array, pull: _Array | None = None
    ) -> list[_Array]: ...
    def adjoint(
        self,
        unknowns: _Array,
        gap: _Array | None = None,
        motion: _Array | None = None,
        pull: _Array | None = None,
    ) -> list[_Array]: ...
    def by_drag(self, axis: int, unknowns: _Array, gap: _Array, work: _Array) -> _Array: ...

@final
class StickSlip:
    def inputs(self) -> list[_Array]: ...
    def magnet(self) -> _Array | None: ...
    def balanced(self) -> list[int]: ...
    def before(self) -> list[_Array]: ...
    def displacement(self, traction: _Array) -> _Array: ...
    def transposed(self, weights: _Array) -> _Array: ...
    def forward(
        self, gap: _Array, work: _Array, wanted: _Array, placed: _Array, friction: _Array, pull: _Array
    ) -> list[_Array]: ...
    def adjoint(
        self, traction: _Array, gap: _Array, motion: _Array, slip: _Array, rigid: _Array, pull: _Array
    ) -> list[_Array]: ...

def stick_or_slip_held(
    compliance: Compliance,
    pressure: _Array,
    area: _Array,
    friction: _Array,
    layer: float,
    displacements: list[list[float]],
    tolerance: float,
) -> list[tuple[_Array, NDArray[np.int8], int, float]]: ...

@final
class WearStep:
    @property
    def outcome(self) -> Outcome: ...
    @property
    def length(self) -> float: ...
    @property
    def distance(self) -> float: ...
    @property
    def next(self) -> float | None: ...
    @property
    def upper(self) -> _Array: ...
    @property
    def lower(self) -> _Array: ...
    @property
    def error(self) -> float: ...
    @property
    def solves(self) -> int: ...

def wear_problem(
    problem: Problem,
    loading: Loading,
    direction: _Array,
    friction: _Array | Callable[[_Array], _Array],
    law: Callable[[_Array, _Array], tuple[_Array, _Array]],
    passage: tuple[float, list[int], _Array] | None,
    tolerance: float,
    worn: tuple[float, _Array, _Array, float | None],
    until: float,
    told: Callable[[WearStep], bool],
    magnet: _Magnet | None = None,
    from_pull: _Array | None = None,
) -> None: ...
def wear_contact(
    contact: PreparedContact,
    velocity: tuple[float, float],
    magnetic_pressure: float | None,
    given: Loading | None,
    law: Callable[[_Array, _Array], tuple[_Array, _Array]],
    passage: tuple[float, list[int], _Array] | None,
    tolerance: float,
    worn: tuple[float, _Array, _Array, float | None],
    until: float,
    told: Callable[[WearStep], bool],
) -> None: ...

@final
class Loading:
    @property
    def gap(self) -> _Array: ...
    @property
    def work(self) -> _Array: ...

@final
class Outcome:
    @property
    def status(self) -> str: ...
    @property
    def pressure(self) -> _Array: ...
    @property
    def gap(self) -> _Array: ...
    @property
    def motion(self) -> _Array: ...
    @property
    def friction(self) -> _Array: ...
    @property
    def traction(self) -> _Array: ...
    @property
    def points(self) -> NDArray[np.int8]: ...
    @property
    def force(self) -> _Array: ...
    @property
    def moment(self) -> _Array: ...
    @property
    def friction_power(self) -> float: ...
    @property
    def slipped(self) -> tuple[_Array, float] | None: ...
    @property
    def rigid(self) -> _Array | None: ...
    @property
    def path_error(self) -> float: ...
    @property
    def iterations(self) -> int: ...
    @property
    def factorisations(self) -> int: ...
    @property
    def products(self) -> int: ...
    @property
    def fell_back(self) -> bool: ...
    @property
    def by_lemke(self) -> bool: ...
    @property
    def residual(self) -> float: ...
    @property
    def unstable(self) -> bool: ...
    @property
    def settled(self) -> Settled | None: ...

@final
class MagneticCircuit:
    def __new__(
        cls,
        field: _Array,
        flux_density: _Array,
        ampere_turns: float,
        area: _Array,
        points: list[int],
        iron_share: float,
        pole_length: float,
        non_magnetic_gap: float,
        yoke: tuple[float, float] | None,
        rail: tuple[float, float] | None,
        leakage: float,
    ) -> MagneticCircuit: ...
    @property
    def limit(self) -> float: ...
    def attract(self, gap: _Array, factor: float) -> tuple[_Array, _Array, _Array, float, list[float]]: ...

_Magnet = tuple[MagneticCircuit, list[tuple[bool, bool]], float]

@final
class Settled:
    @property
    def pull(self) -> _Array: ...
    @property
    def flux(self) -> float: ...
    @property
    def forces(self) -> list[float]: ...
    @property
    def solves(self) -> int: ...
    @property
    def residual(self) -> float: ...
    @property
    def share(self) -> float | None: ...

@final
class PreparedContact:
    def __new__(
        cls,
        problem: Problem,
        loading: Loading,
        named: list[tuple[str, int | None]],
        friction_speed: list[float],
        friction: _Array,
        pulled: list[tuple[bool, bool]],
        pressure: tuple[list[float], _Array] | None,
        magnet: tuple[MagneticCircuit, list[float], list[float]] | None,
        sliding_direction: tuple[float, float],
        reference_point: tuple[float, float, float],
        standstill_speed: float | None,
        layer: float,
    ) -> PreparedContact: ...
    @staticmethod
    def from_bytes(data: bytes) -> PreparedContact: ...
    @property
    def takes_shifts(self) -> bool: ...
    def to_bytes(self, shift: bool) -> bytes: ...
    def copy(self) -> PreparedContact: ...
    @property
    def points(self) -> _Array: ...
    @property
    def normal(self) -> _Array: ...
    @property
    def area(self) -> _Array: ...
    @property
    def motions(self) -> list[str]: ...
    @property
    def motion_shapes(self) -> _Array: ...
    @property
    def sliding_direction(self) -> list[float]: ...
    @property
    def reference_point(self) -> list[float]: ...
    @property
    def is_tabulated(self) -> bool: ...
    @property
    def magnet(
        self,
    ) -> (
        tuple[list[int], list[list[float]], list[float], list[tuple[float, float] | None], list[list[float]]]
        | None
    ): ...
    def mean_pressure(self, pressure: _Array) -> _Array: ...
    def resume(
        self,
        pressure: _Array,
        motion: _Array,
        from_pull: _Array | None = None,
        stuck: tuple[_Array, _Array] | None = None,
    ) -> None: ...
    def step(
        self,
        pose: list[float],
        velocity: tuple[float, float],
        magnetic_pressure: float | None = None,
        given: Loading | None = None,
        gap: _Array | None = None,
        friction: _Array | None = None,
        diagonal: _Array | None = None,
        magnet: tuple[MagneticCircuit, float, float] | None = None,
        shift: tuple[float, float] | None = None,
    ) -> tuple[Outcome, Tangent | None, StickSlip | None]: ...
    @property
    def geometry(self) -> ContactGeometry: ...

_VibratingState = tuple[_Array, _Array, _Array, _Array]

@final
class VibratingContact:
    def __new__(
        cls,
        compliance: _Array,
        area: _Array,
        friction_speed: list[float],
        friction: _Array,
        traction: _Array,
        gap: _Array,
        mass: _Array,
        damping: _Array,
        stiffness: _Array,
        shapes: _Array,
        step: float,
    ) -> VibratingContact: ...
    def energy(self, state: _VibratingState) -> tuple[float, float, float]: ...
    def step(
        self, state: _VibratingState, drive: _Array, load: _Array, friction: _Array | None = None
    ) -> dict[str, Any] | None: ...

_WheelHistory = tuple[list[float], float, _Array, _Array]
_WheelState = tuple[
    list[float],
    list[tuple[str, tuple[int, int], _Array]],
    list[_WheelHistory | None],
    list[float] | None,
]
_Alignment = tuple[float, list[list[list[float]]], list[list[list[float]]]]

@final
class PreparedWheels:
    def __new__(
        cls,
        wheel: Profile,
        rail: Profile,
        *,
        wheel_radius: float,
        roller_radius: float | None,
        gauge: float,
        gauge_depth: float,
        rail_inclination: float,
        flange_back: float,
        tape_circle: float,
        lateral: float,
        first_height: float,
        side: str,
        force: float,
        approach: float,
        spacing: tuple[float, float],
        lower: tuple[float, float] | None,
        upper: tuple[float, float] | None,
        friction: Friction | tuple[list[float], list[float], list[float]],
        layer: float,
        reference_point: tuple[float, ...] | None,
        standstill_speed: float | None,
        springs: list[list[float]] | None,
        wheel_slices: Slices | None,
        rail_slices: Slices | None,
    ) -> PreparedWheels: ...
    @staticmethod
    def from_bytes(data: bytes) -> PreparedWheels: ...
    def to_bytes(self) -> bytes: ...
    def copy(self) -> PreparedWheels: ...
    def to_accuracy(self, normal: float, tangential: float, force: float) -> PreparedWheels: ...
    @property
    def sides(self) -> list[str]: ...
    @property
    def force(self) -> float: ...
    @property
    def has_springs(self) -> bool: ...
    @property
    def young_moduli(self) -> list[float]: ...
    @property
    def materials(self) -> list[tuple[float, float] | None]: ...
    @property
    def friction_inputs(self) -> list[tuple[str, list[int]]]: ...
    @property
    def reference_point(self) -> list[float]: ...
    @property
    def state(self) -> _WheelState: ...
    def resume(self, state: _WheelState) -> None: ...
    def step(
        self,
        pose: list[float],
        velocity: _Array,
        state: _WheelState | None = None,
        duration: float | None = None,
        lateral_force: float | None = None,
        axle_load: tuple[bool, float] | None = None,
        alignment: _Alignment | None = None,
    ) -> WheelOutcome: ...

class NotConverged(Exception): ...

@final
class WheelTangent:
    def derivatives(self, by: str) -> list[dict[str, _Array]]: ...
    def margin(self) -> list[float]: ...

@final
class WheelOutcome:
    @property
    def tangent(self) -> WheelTangent: ...
    @property
    def force(self) -> _Array: ...
    @property
    def moment(self) -> _Array: ...
    @property
    def reference_point(self) -> _Array: ...
    @property
    def pose(self) -> _Array: ...
    @property
    def velocity(self) -> _Array: ...
    @property
    def rail_displacement(self) -> list[tuple[str, _Array]]: ...
    @property
    def vertical_force(self) -> list[tuple[str, float]]: ...
    @property
    def balance_error(self) -> float | None: ...
    @property
    def friction_power(self) -> float: ...
    @property
    def normal_solves(self) -> int: ...
    @property
    def iterations(self) -> int: ...
    @property
    def state(self) -> _WheelState: ...
    @property
    def patches(self) -> list[WheelPatch]: ...

@final
class WheelPatch:
    @property
    def side(self) -> str: ...
    @property
    def position(self) -> _Array: ...
    @property
    def rotation(self) -> _Array: ...
    @property
    def contact_angle(self) -> float: ...
    @property
    def rail_position(self) -> float: ...
    @property
    def wheel_position(self) -> float: ...
    @property
    def x(self) -> _Array: ...
    @property
    def y(self) -> _Array: ...
    @property
    def pressure(self) -> _Array: ...
    @property
    def traction(self) -> _Array: ...
    @property
    def slip_velocity(self) -> _Array: ...
    @property
    def dissipation(self) -> _Array: ...
    @property
    def status(self) -> NDArray[np.int8]: ...
    @property
    def approach(self) -> float: ...
    @property
    def creepage(self) -> _Array: ...
    @property
    def rolling_speed(self) -> float: ...
    @property
    def normal_force(self) -> float: ...
    @property
    def neglected(self) -> float: ...
    @property
    def friction_power(self) -> float: ...

@final
class StaggeredOutcome:
    @property
    def status(self) -> str: ...
    @property
    def pressure(self) -> _Array: ...
    @property
    def gap(self) -> _Array: ...
    @property
    def motion(self) -> _Array: ...
    @property
    def residual(self) -> float: ...
    @property
    def iterations(self) -> int: ...
    @property
    def factor(self) -> float: ...
    @property
    def predicted_limit(self) -> float: ...

def solve_staggered(
    half_spaces: _Array,
    structure: _Array,
    gap: _Array,
    area: _Array,
    motion: _Array,
    balance: _Array,
    target: _Array,
    factor: float | None,
    max_iterations: int,
    tolerance: float,
    anderson_depth: int,
) -> StaggeredOutcome: ...

@final
class IncrementalOptions:
    def __new__(
        cls,
        *,
        estimated_steps: int = 20,
        force_tolerance: float = 1.0,
        distance_tolerance: float | None = None,
        max_resolutions: int = 20,
        max_releases: int = 20,
        max_increments: int = 500,
    ) -> IncrementalOptions: ...
    @property
    def estimated_steps(self) -> int: ...
    @property
    def force_tolerance(self) -> float: ...
    @property
    def distance_tolerance(self) -> float | None: ...
    @property
    def max_resolutions(self) -> int: ...
    @property
    def max_releases(self) -> int: ...
    @property
    def max_increments(self) -> int: ...

@final
class IncrementalOutcome:
    @property
    def status(self) -> str: ...
    @property
    def pressure(self) -> _Array: ...
    @property
    def traction(self) -> _Array: ...
    @property
    def gap(self) -> _Array: ...
    @property
    def lower_displacement(self) -> _Array: ...
    @property
    def upper_displacement(self) -> _Array: ...
    @property
    def approach(self) -> float: ...
    @property
    def force(self) -> float: ...
    @property
    def residual(self) -> float: ...
    @property
    def imbalance(self) -> float: ...
    @property
    def increments(self) -> int: ...
    @property
    def resolutions(self) -> int: ...
    @property
    def problems(self) -> int: ...
    @property
    def active_sets(self) -> int: ...
    @property
    def releases(self) -> int: ...
    @property
    def history(self) -> list[tuple[float, float]]: ...

def solve_incremental(
    lower: Compliance | None,
    upper: Compliance | None,
    lower_points: _Array,
    upper_points: _Array,
    grids: list[tuple[int, int]],
    area: _Array,
    friction: _Array,
    direction: tuple[float, float, float],
    force: float,
    options: IncrementalOptions,
) -> IncrementalOutcome: ...

# geometry
@final
class Profile:
    @staticmethod
    def rail_60e1() -> Profile: ...
    @staticmethod
    def wheel_s1002() -> Profile: ...
    @staticmethod
    def from_points(y: _Array, z: _Array, interpolation: str) -> Profile: ...
    @staticmethod
    def from_numbers(numbers: _Array) -> Profile: ...
    def range(self) -> tuple[float, float]: ...
    def breaks(self) -> _Array: ...
    def stations(self, y: _Array) -> _Array: ...
    def arc_length(self, y: _Array) -> _Array: ...
    def position(self, s: _Array) -> _Array: ...

@final
class Slices:
    def __new__(
        cls,
        nominal: Profile,
        positions: _Array,
        sections: list[Profile],
        features: list[list[float]],
        around: bool,
    ) -> Slices: ...
    @staticmethod
    def raised(nominal: Profile, positions: _Array, heights: _Array, around: bool) -> Slices: ...
    def range(self) -> tuple[float, float]: ...
    def at(self, position: _Array, y: _Array) -> _Array: ...

class _Shoe(Protocol):
    @property
    def length(self) -> float: ...
    @property
    def inner_edge(self) -> float: ...
    @property
    def conforming_to(self) -> float: ...
    @property
    def outer_edge(self) -> float: ...
    @property
    def relief_slope(self) -> float: ...
    @property
    def poles(self) -> int: ...
    @property
    def lateral(self) -> float: ...
    @property
    def yaw(self) -> float: ...

class _RailSection(Protocol):
    @property
    def web_half_width(self) -> float: ...
    @property
    def web_top(self) -> float: ...
    @property
    def web_bottom(self) -> float: ...
    @property
    def head_edge(self) -> tuple[float, float]: ...
    @property
    def foot_half_width(self) -> float: ...
    @property
    def foot_toe(self) -> float: ...
    @property
    def bottom(self) -> float: ...

# nodes (n, 3) [m], cells (m, 4 or 10), sets of nodes
_Made = tuple[_Array, NDArray[np.int64], list[tuple[str, NDArray[np.int64]]]]
# halved, clamped, thinner, quadratic
_Filling = tuple[bool, bool, float, bool]

@final
class ContactPoints:
    @property
    def points(self) -> _Array: ...
    @property
    def normal(self) -> _Array: ...
    @property
    def tangent_x(self) -> _Array: ...
    @property
    def tangent_y(self) -> _Array: ...
    @property
    def arc_length(self) -> _Array: ...
    @property
    def gap(self) -> _Array: ...

@final
class ContactGrid:
    @property
    def cells(self) -> ContactPoints: ...
    @property
    def nodes(self) -> ContactPoints: ...
    @property
    def area(self) -> _Array: ...
    @property
    def patches(self) -> list[tuple[list[int], list[float], list[float]]]: ...

@final
class WheelRailGap:
    @property
    def gap(self) -> _Array: ...
    @property
    def start(self) -> list[float]: ...
    @property
    def contact_angle(self) -> float: ...
    @property
    def origin(self) -> list[float]: ...
    @property
    def rail_position(self) -> float: ...
    @property
    def wheel_position(self) -> float: ...
    @property
    def first_rail_position(self) -> float: ...
    @property
    def undeformed_height(self) -> float: ...
    @property
    def approach(self) -> float: ...
    @property
    def neglected(self) -> float: ...

def pole_shoe_grid(rail: Profile, shoe: _Shoe, spacing: tuple[float, float]) -> ContactGrid: ...
def block_mesh(x: _Array, y: _Array, height: float, filling: _Filling) -> _Made: ...
def pole_mesh(
    rail: Profile, shoe: _Shoe, side: float, height: float, x: _Array, y: _Array, filling: _Filling
) -> _Made: ...
def rail_mesh(
    profile: Profile,
    section: _RailSection,
    x: _Array,
    left: _Array,
    right: _Array | None,
    length: float,
    quadratic: bool,
) -> _Made: ...
def rail_lines(along: list[_Array]) -> _Array: ...
def held_points(size: tuple[float, float], height: float) -> tuple[list[list[float]], list[list[float]]]: ...
def nearest_nodes(nodes: _Array, places: list[list[float]]) -> list[int]: ...
def quadratic_mesh(
    nodes: _Array, cells: NDArray[np.uintp], sets: list[tuple[str, NDArray[np.uintp]]]
) -> _Made: ...
def tetrahedra(
    corners: _Array, columns: list[bool], rows: list[bool], quadratic: bool
) -> tuple[_Made, NDArray[np.int64]]: ...
def check_unknowns(tetrahedra: float, quadratic: bool) -> None: ...
def read_columns(
    text: str,
    names: list[list[str]],
    units: list[list[tuple[str, float]]],
) -> tuple[_Array, list[int], list[float | None]]: ...
def read_profile(text: str) -> tuple[_Array, _Array, float | None, str]: ...
def standing_wheelsets(
    pairs: list[tuple[Profile, Profile, float]],
    *,
    gauge: float,
    gauge_depth: float,
    rail_inclination: float,
    flange_back: float,
    tape_circle: float,
    level: bool,
    shifts: _Array,
) -> _Array: ...
def wheel_on_rail_gap(
    wheel: Profile,
    rail: Profile,
    *,
    wheel_radius: float,
    roller_radius: float | None,
    gauge: float,
    gauge_depth: float,
    rail_inclination: float,
    flange_back: float,
    tape_circle: float,
    lateral: float,
    force: float,
    contact_modulus: float,
    approach: float | None,
    spacing: tuple[float, float],
    scale: float,
) -> WheelRailGap: ...

@final
class BodySurface:
    @staticmethod
    def plane(height: float) -> BodySurface: ...
    @staticmethod
    def block(size: tuple[float, float], height: float) -> BodySurface: ...
    @staticmethod
    def paraboloid(radii: tuple[float, float]) -> BodySurface: ...
    @staticmethod
    def prism(profile: Profile, length: float) -> BodySurface: ...
    @staticmethod
    def height_field(
        heights: _Array, start: tuple[float, float], spacing: tuple[float, float]
    ) -> BodySurface: ...
    @staticmethod
    def mesh(vertices: _Array, triangles: NDArray[np.uintp], closed: bool) -> BodySurface: ...
    def top(self, x: _Array, y: _Array) -> _Array: ...

def surface_gap(
    lower: BodySurface,
    upper: BodySurface,
    *,
    x: tuple[float, float],
    y: tuple[float, float],
    spacing: tuple[float, float],
    reach: float,
    approach: float | None,
) -> tuple[ContactGrid, _Array, NDArray[np.bool_]]: ...

#: Shear modulus [Pa] and Poisson's ratio; a layer on a base; constants, creep and the way in a creep time.
_Medium: TypeAlias = tuple[float, float] | Layered | tuple[tuple[float, float], float, tuple[float, float]]

@final
class Layered:
    def __new__(
        cls,
        layer: tuple[float, float],
        thickness: float,
        base: tuple[float, float] | None,
        is_bonded: bool,
    ) -> Layered: ...
    def wave(self, wave_number: float) -> float: ...

def half_space(
    medium: _Medium,
    patches: list[tuple[float, float, int, int]],
    spacing: tuple[float, float] | list[tuple[float, float]],
    interact: bool,
) -> Compliance: ...

# half-spaces in other bases
def half_space_hats(
    shear_modulus: float,
    poisson_ratio: float,
    patches: list[tuple[float, float, int, int]],
    spacing: tuple[float, float] | list[tuple[float, float]],
    interact: bool,
) -> tuple[Compliance, _Array]: ...

@final
class Section:
    def arrays(self) -> tuple[_Array, NDArray[np.int64]]: ...

def rail_section(profile: Profile, lines: list[_Array], parts: int) -> Section: ...
def block_section(size: tuple[float, float], lines: list[_Array], parts: int) -> Section: ...
def prism(
    elastic: tuple[float, float],
    section: Section,
    foundation: tuple[float, float] | None,
    patches: list[tuple[float, float, int, int]],
    spacing: tuple[float, float] | list[tuple[float, float]],
    lines: list[_Array],
    hats: bool,
) -> tuple[Compliance, tuple[int, float, float, int]]: ...
def refined(
    body: Compliance,
    weights: _Array,
    elastic: tuple[float, float],
    lines: list[tuple[list[int], list[int]]],
    patches: list[tuple[tuple[float, float, int, int], tuple[float, float]]],
    half: bool,
) -> Compliance: ...
def carried(fields: _Array, lines: list[tuple[list[int], list[int]]]) -> _Array: ...
def half_space_cut_hats(
    shear_modulus: float,
    poisson_ratio: float,
    patch: tuple[float, float, int, int],
    spacing: tuple[float, float],
    faces: list[Sampling],
    shares: list[tuple[int, int, int, float]],
    points: int,
) -> Compliance: ...
def half_space_gaussians(
    materials: list[tuple[float, float]],
    x: _Array,
    y: _Array,
    standard_deviation: float,
    domain: tuple[float, float, float, float],
) -> tuple[list[Compliance], _Array]: ...

# stick and slip
@final
class Friction:
    @staticmethod
    def coulomb(coefficient: _Array) -> Friction: ...
    @staticmethod
    def static_kinetic(at_rest: float, kinetic: float) -> Friction: ...
    @staticmethod
    def exponential(
        at_rest: float, kinetic: float, half_slip: float, memory: tuple[float, float] | None
    ) -> Friction: ...
    @staticmethod
    def table(slip_speed: _Array, coefficient: _Array, memory: tuple[float, float] | None) -> Friction: ...
    @staticmethod
    def of_temperature(
        temperature: _Array,
        coefficient: _Array,
        bodies: tuple[tuple[float, float, float], tuple[float, float, float]],
        bulk: tuple[float, float],
        memory: tuple[float, float] | None,
    ) -> Friction: ...

@final
class PatchOperators:
    def __new__(
        cls,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        lower: _Medium | None,
        upper: _Medium | None,
        layer: float,
        motion: str,
        step: tuple[float, float],
        reference: float | None,
        softens: bool = False,
        inclination: Sequence[float] | None = None,
    ) -> PatchOperators: ...
    def solve(
        self,
        pressure: _Array,
        origin: tuple[float, float],
        drive: list[tuple[float, bool]],
        spin: float,
        speed: float,
        friction: Friction,
        earlier: tuple[_Array, _Array, _Array] | None,
        tolerance: float,
        start: _Array | None = None,
        around: tuple[tuple[int, int], tuple[int, int]] | None = None,
        plasticity: tuple[float, float, _Array | None] | None = None,
        rigid_slip: _Array | None = None,
    ) -> TangentialOutcome: ...

@final
class TangentialTangent:
    def __new__(
        cls,
        operators: PatchOperators,
        pressure: _Array,
        origin: tuple[float, float],
        drive: list[tuple[float, bool]],
        spin: float,
        speed: float,
        friction: Friction,
        earlier: tuple[_Array, _Array, _Array] | None,
        found: tuple[_Array, _Array, _Array, list[float]],
        around: tuple[tuple[int, int], tuple[int, int]],
        rigid_slip: _Array | None = None,
        plasticity: tuple[float, float, _Array | None] | None = None,
    ) -> TangentialTangent: ...
    def forward(
        self,
        pressure: _Array,
        drive: list[float],
        spin: float,
        rigid_slip: _Array,
        rigid_slip_behind: _Array,
        coefficient: _Array,
        law: _Array,
        layer: float,
        earlier: tuple[_Array, _Array, _Array],
        plasticity: tuple[float, float, _Array] | None = None,
    ) -> tuple[_Array, _Array, _Array, list[float], _Array, tuple[_Array, _Array] | None, int]: ...
    def adjoint(
        self,
        traction: _Array,
        slip: _Array,
        coefficient: _Array,
        drive: list[float],
        dissipation: _Array,
        plastic: tuple[_Array, _Array] | None = None,
    ) -> TangentialChange: ...
    def slip_by_bodies(self, other: PatchOperators) -> tuple[_Array, _Array]: ...
    def with_operators(self, other: PatchOperators) -> tuple[_Array, _Array]: ...

@final
class TangentialChange:
    @property
    def pressure(self) -> _Array: ...
    @property
    def drive(self) -> list[float]: ...
    @property
    def spin(self) -> float: ...
    @property
    def rigid_slip(self) -> _Array: ...
    @property
    def rigid_slip_behind(self) -> _Array: ...
    @property
    def coefficient(self) -> _Array: ...
    @property
    def law(self) -> _Array: ...
    @property
    def layer(self) -> float: ...
    @property
    def earlier(self) -> tuple[_Array, _Array, _Array]: ...
    @property
    def plasticity(self) -> tuple[float, float, _Array] | None: ...
    @property
    def products(self) -> int: ...

@final
class TangentialOutcome:
    @property
    def traction(self) -> _Array: ...
    @property
    def slip(self) -> _Array: ...
    @property
    def plastic(self) -> list[_Array] | None: ...
    @property
    def status(self) -> NDArray[np.int8]: ...
    @property
    def coefficient(self) -> _Array: ...
    @property
    def dissipation(self) -> _Array | None: ...
    @property
    def drive(self) -> list[float]: ...
    @property
    def force(self) -> list[float]: ...
    @property
    def spin_moment(self) -> float: ...
    @property
    def converged(self) -> bool: ...
    @property
    def iterations(self) -> int: ...
    @property
    def products(self) -> float: ...
    @property
    def preconditionings(self) -> float: ...
    @property
    def history(self) -> list[float]: ...
    @property
    def rounds(self) -> tuple[int, float] | None: ...

@final
class FoundationOutcome:
    @property
    def forces(self) -> _Array: ...
    @property
    def traction(self) -> _Array: ...
    @property
    def slip(self) -> _Array: ...
    @property
    def slipping(self) -> NDArray[np.bool_]: ...

def kalker_coefficients(ratio: float, poisson_ratio: float) -> tuple[float, float, float, float]: ...
def fastsim_curve(
    bound: _Array,
    spacing: tuple[float, float],
    origin: tuple[float, float],
    angle: float,
    ellipse: tuple[float, float],
    shear_modulus: float,
    poisson_ratio: float,
    creepages: _Array,
    speed: float,
    friction: Friction,
    foundation: str,
    limit: float,
    method: str,
    slope: tuple[tuple[float, float, float], float, float] | None,
) -> FoundationOutcome: ...
def polach_curve(
    ellipse: tuple[float, float],
    shear_modulus: float,
    poisson_ratio: float,
    normal_force: float,
    creepages: _Array,
    friction: _Array,
    reduction: tuple[float, float],
) -> _Array: ...

# finite-element bodies
_Numbers = NDArray[np.uintp]

@final
class TetraMesh:
    def __new__(cls, nodes: _Array, cells: _Numbers) -> TetraMesh: ...
    def faces(self) -> _Numbers: ...
    def sample(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        points: _Array,
        frames: _Array,
        faces: _Numbers,
    ) -> Sampling: ...
    def at_points(self, values: _Array, points: _Array) -> _Array: ...
    def averages(self, sampling: Sampling) -> tuple[_Array, _Array, tuple[_Numbers, _Numbers, _Array]]: ...

@final
class Sampling:
    def __new__(
        cls,
        n_points: int,
        face: _Numbers,
        barycentric: _Array,
        weight: _Array,
        frame: _Array,
        start: _Numbers,
        point: _Numbers,
        value: _Array,
    ) -> Sampling: ...
    @staticmethod
    def joined(parts: list[Sampling]) -> Sampling: ...
    def on_lines(self, lines: list[tuple[list[int], list[int]]]) -> Sampling: ...
    @property
    def weights(self) -> _Array: ...
    @property
    def n_points(self) -> int: ...
    def arrays(self) -> dict[str, NDArray[Any]]: ...

@final
class TetraBody:
    def __new__(
        cls,
        mesh: TetraMesh,
        shear_modulus: float,
        poisson_ratio: float,
        supports: list[tuple[str, list[int], tuple[str, str, str]]],
    ) -> TetraBody: ...
    @property
    def cases(self) -> list[tuple[int, int, bool]]: ...
    @property
    def has_mirror(self) -> bool: ...
    @property
    def centre(self) -> _Array: ...
    def modes(self, point: tuple[float, float, float]) -> tuple[list[str], _Array]: ...
    def condense(self, sampling: Sampling) -> dict[str, Any]: ...
    def solve(self, force: _Array, case_value: _Array, modes: _Array, amplitude: _Array) -> _Array: ...
    def vibration(self, density: float, count: int) -> dict[str, Any]: ...
    def contact_force(self, sampling: Sampling, traction: _Array) -> _Array: ...
    def spread_force(self, wrench: tuple[float, float, float, float, float, float]) -> _Array: ...
    def observe(self, sampling: Sampling, displacement: _Array) -> _Array: ...
    def displacement_at(
        self, displacement: _Array, points: _Array, faces: _Numbers, reach: float
    ) -> _Array: ...
    def expansion(self, sampling: Sampling, expansion: float) -> _Array: ...
    def reactions(
        self, displacement: _Array, force: _Array, point: tuple[float, float, float]
    ) -> tuple[_Array, _Array, float]: ...
    def stress(self, displacement: _Array) -> tuple[_Array, _Array]: ...

def stress_below(
    medium: tuple[float, float] | Layered,
    spacing: tuple[float, float],
    traction: _Array,
    depths: list[float],
    periodic: bool,
) -> tuple[_Array, int]: ...
def dang_van(paths: _Array, coefficient: float) -> _Array: ...
def stress_at(
    medium: tuple[float, float] | Layered,
    cells: _Array,
    traction: _Array,
    points: _Array,
) -> _Array: ...
def rolling_temperatures(
    power: _Array,
    touches: NDArray[np.bool_],
    spacing: tuple[float, float],
    angle: float,
    speed: float,
    bodies: tuple[tuple[float, float, float], tuple[float, float, float]],
    bulk: tuple[float, float],
) -> tuple[_Array, _Array]: ...
def moving_half_space(
    conductor: tuple[float, float, float],
    velocity: tuple[float, float],
    points: _Array,
    sizes: _Array,
) -> _Array: ...
def swelling(
    conductor: tuple[float, float, float],
    velocity: tuple[float, float],
    points: _Array,
    sizes: _Array,
    expansion: float,
    poisson_ratio: float,
) -> _Array: ...
def step_error(area: _Array, before: _Array, length: float, rate: _Array, after: _Array) -> float: ...

@final
class StepControl:
    def __new__(cls, tolerance: float, next: float | None = None) -> StepControl: ...
    @property
    def next(self) -> float | None: ...
    @property
    def is_stuck(self) -> bool: ...
    def length(self, most: float) -> float: ...
    def judge(self, length: float, most: float, error: float) -> float | None: ...

@final
class ConductingBody:
    def __new__(
        cls,
        mesh: TetraMesh,
        conductor: tuple[float, float, float],
        films: list[tuple[list[int], float, float]],
    ) -> ConductingBody: ...
    def heat(self, temperature: _Array) -> float: ...
    def loss(self, temperature: _Array) -> float: ...
    def step(self, duration: float, sampling: Sampling) -> ConductionStep: ...
    def modes(self, sampling: Sampling) -> ConductionModes: ...

@final
class ConductionStep:
    @property
    def response(self) -> _Array: ...
    @property
    def weights(self) -> _Array: ...
    def observe(self, temperature: _Array) -> _Array: ...
    def coast(self, temperature: _Array) -> _Array: ...
    def observe_coasted(self, coasted: _Array) -> _Array: ...
    def end(self, coasted: _Array, flux: _Array) -> _Array: ...
    def seen(self, rows: _Array) -> _Array: ...
    def seen_coasted(self, seen: _Array, coasted: _Array) -> _Array: ...
    def response_of(self, seen: _Array) -> _Array: ...

@final
class ConductionModes:
    def __len__(self) -> int: ...
    @property
    def weights(self) -> _Array: ...
    def with_conductivity(self, conductivity: float) -> ConductionModes: ...
    def uniform(self, temperature: float) -> _Array: ...
    def temperature(self, amplitudes: _Array) -> _Array: ...
    def observe(self, amplitudes: _Array) -> _Array: ...
    def seen(self, rows: _Array) -> _Array: ...
    def heat(self, amplitudes: _Array) -> float: ...
    def loss(self, amplitudes: _Array) -> float: ...
    def advance(self, duration: float, amplitudes: _Array, flux: _Array) -> _Array: ...
    def response(self, duration: float) -> _Array: ...
    def response_of(self, duration: float, seen: _Array) -> _Array: ...

def flexibility(weights: _Array, blocks: _Array) -> Compliance: ...
def available_memory() -> float | None: ...
def available_address_space() -> float | None: ...
def normal_memory(cells: int, method: str) -> float: ...
def sliding_memory(points: int, frictional: bool) -> float: ...

@final
class NormalTangent:
    def __new__(
        cls,
        initial_gap: _Array,
        spacing: tuple[float, float],
        bodies: Sequence[_Medium],
        force: float | None,
        approach: float | None,
        moments: tuple[float | None, float | None],
        is_periodic: bool,
        layer: float,
        hardness: float | None,
        rough: tuple[float, float] | tuple[list[float], list[float]] | None,
        inclination: list[float] | None,
        found: tuple[_Array, _Array, float, tuple[float, float]],
    ) -> NormalTangent: ...
    def forward(
        self,
        gap: _Array,
        load: _Array,
        moments: _Array,
        compliance: _Array,
        flexibility: _Array,
        hardness: _Array,
    ) -> tuple[_Array, _Array, _Array, _Array, int]: ...
    def adjoint(
        self, pressure: _Array, gap: _Array, approach: _Array, tilts: _Array
    ) -> tuple[_Array, _Array, _Array, _Array, _Array, _Array, int]: ...

@final
class NormalOutcome:
    @property
    def status(self) -> str: ...
    @property
    def is_dense(self) -> bool: ...
    @property
    def pressure(self) -> _Array: ...
    @property
    def gap(self) -> _Array: ...
    @property
    def approach(self) -> float: ...
    @property
    def tilts(self) -> tuple[float, float]: ...
    @property
    def iterations(self) -> int: ...
    @property
    def products(self) -> float: ...
    @property
    def preconditionings(self) -> float: ...
    @property
    def residual(self) -> float: ...
    @property
    def tolerance(self) -> float: ...
    @property
    def history(self) -> list[float]: ...
    @property
    def discretisation_error(self) -> float | None: ...

def solve_normal(
    gap: _Array,
    spacing: tuple[float, float],
    bodies: Sequence[_Medium],
    force: float | None,
    approach: float | None,
    moments: tuple[float | None, float | None],
    tolerance: float | None,
    is_periodic: bool,
    method: str,
    layer: float = 0.0,
    hardness: float | None = None,
    rough: tuple[float, float] | tuple[list[float], list[float]] | None = None,
    inclination: Sequence[float] | None = None,
) -> NormalOutcome: ...

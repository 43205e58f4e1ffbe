# SPDX-License-Identifier: MIT OR Apache-2.0
from collections.abc import Callable
from typing import Any, Protocol, final

import numpy as np
from numpy.typing import NDArray

__version__: str
CONDENSATION_DIGEST: str

_Array = NDArray[np.float64]

@final
class Compliance:
    @property
    def points(self) -> int: ...
    def influence(self, observed: str, loaded: str) -> _Array: ...
    def displacement(self, traction: _Array) -> _Array: ...
    def folded(self, image: list[int]) -> Compliance: ...
    def unfolded(self, image: list[int]) -> Compliance: ...
    def reflected(self, original: list[int]) -> Compliance: ...
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
    ) -> ContactGeometry: ...
    def sliding_direction(self, along: tuple[float, float]) -> _Array: ...
    def mean_tractions(self, traction: _Array) -> _Array: ...
    def loads(self, traction: _Array) -> _Array: ...

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
    ) -> Problem: ...
    @property
    def pair(self) -> Compliance: ...
    @property
    def motions(self) -> _Array: ...
    def loading(self, gap: _Array, work: _Array) -> Loading: ...
    def with_displacement(self, loading: Loading, displacement: _Array, is_upper: bool) -> Loading: ...
    def with_pull(self, loading: Loading, pull: _Array, is_upper: bool, at_face: bool) -> Loading: ...
    def displacement(self, traction: _Array, is_upper: bool, pull: _Array | None = None) -> _Array: ...
    def prepare(self, direction: _Array, is_frictional: bool) -> bool: ...
    def slide(
        self,
        loading: Loading,
        direction: _Array,
        friction: _Array | Callable[[_Array], _Array],
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

@final
class PreparedContact:
    def __new__(
        cls,
        problem: Problem,
        loading: Loading,
        named: list[tuple[str, int | None]],
        friction_speed: list[float],
        friction: _Array,
        magnetic: tuple[list[float], _Array, list[tuple[bool, bool]]] | None,
        sliding_direction: tuple[float, float],
        reference_point: tuple[float, float, float],
        standstill_speed: float | None,
    ) -> PreparedContact: ...
    @staticmethod
    def from_bytes(data: bytes) -> PreparedContact: ...
    def to_bytes(self) -> bytes: ...
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
    def sliding_direction(self) -> list[float]: ...
    @property
    def reference_point(self) -> list[float]: ...
    @property
    def is_tabulated(self) -> bool: ...
    def mean_pressure(self, pressure: _Array) -> _Array: ...
    def resume(self, pressure: _Array, motion: _Array) -> None: ...
    def step(
        self,
        pose: list[float],
        velocity: tuple[float, float],
        magnetic_pressure: float | None = None,
        given: Loading | None = None,
    ) -> Outcome: ...

_WheelState = tuple[list[float], list[tuple[str, tuple[int, int], _Array]]]

@final
class PreparedWheels:
    def __new__(
        cls,
        wheel: Profile,
        rail: Profile,
        *,
        wheel_radius: float,
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
    ) -> PreparedWheels: ...
    @staticmethod
    def from_bytes(data: bytes) -> PreparedWheels: ...
    def to_bytes(self) -> bytes: ...
    def copy(self) -> PreparedWheels: ...
    @property
    def sides(self) -> list[str]: ...
    @property
    def force(self) -> float: ...
    @property
    def reference_point(self) -> list[float]: ...
    @property
    def state(self) -> _WheelState: ...
    def resume(self, state: _WheelState) -> None: ...
    def step(
        self, pose: list[float], velocity: _Array, state: _WheelState | None = None
    ) -> dict[str, Any]: ...

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
    def parse(text: str, unit: float, z_axis: str, interpolation: str) -> Profile: ...
    def range(self) -> tuple[float, float]: ...
    def breaks(self) -> _Array: ...
    def stations(self, y: _Array) -> _Array: ...
    def arc_length(self, y: _Array) -> _Array: ...
    def position(self, s: _Array) -> _Array: ...

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

def pole_shoe_sheet(rail: Profile, shoe: _Shoe, spacing: tuple[float, float]) -> dict[str, Any]: ...
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
def quadratic_mesh(
    nodes: _Array, cells: NDArray[np.uintp], sets: list[tuple[str, NDArray[np.uintp]]]
) -> _Made: ...
def tetrahedra(
    corners: _Array, columns: list[bool], rows: list[bool], quadratic: bool
) -> tuple[_Made, NDArray[np.int64]]: ...
def check_unknowns(tetrahedra: float, quadratic: bool) -> None: ...
def read_columns(
    text: str,
    names: tuple[list[str], list[str]],
    units: tuple[list[tuple[str, float]], list[tuple[str, float]]],
) -> _Array: ...
def wheel_on_rail_gap(
    wheel: Profile,
    rail: Profile,
    *,
    wheel_radius: float,
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
) -> dict[str, Any]: ...

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
) -> dict[str, Any]: ...
def half_space(
    shear_modulus: float,
    poisson_ratio: float,
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

@final
class PatchOperators:
    def __new__(
        cls,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        lower: tuple[float, float] | None,
        upper: tuple[float, float] | None,
        layer: float,
        motion: str,
        step: tuple[float, float],
        reference: float | None,
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
    ) -> dict[str, Any]: ...

def solve_discs_dense(
    matrix: _Array,
    offset: _Array,
    radius: _Array,
    resultants: list[tuple[list[float], list[float], float]],
    tolerance: float,
) -> dict[str, Any]: ...
def kalker_coefficients(ratio: float, poisson_ratio: float) -> tuple[float, float, float, float]: ...
def fastsim_curve(
    bound: _Array,
    spacing: tuple[float, float],
    origin: tuple[float, float],
    ellipse: tuple[float, float],
    shear_modulus: float,
    poisson_ratio: float,
    creepages: _Array,
    speed: float,
    friction: Friction,
    merged: bool,
    second_order: bool,
) -> dict[str, Any]: ...
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
    def centre(self) -> _Array: ...
    def modes(self, point: tuple[float, float, float]) -> tuple[list[str], _Array]: ...
    def condense(self, sampling: Sampling) -> dict[str, Any]: ...
    def solve(self, force: _Array, case_value: _Array, modes: _Array, amplitude: _Array) -> _Array: ...
    def contact_force(self, sampling: Sampling, traction: _Array) -> _Array: ...
    def spread_force(self, wrench: tuple[float, float, float, float, float, float]) -> _Array: ...
    def observe(self, sampling: Sampling, displacement: _Array) -> _Array: ...
    def displacement_at(
        self, displacement: _Array, points: _Array, faces: _Numbers, reach: float
    ) -> _Array: ...
    def reactions(
        self, displacement: _Array, force: _Array, point: tuple[float, float, float]
    ) -> tuple[_Array, _Array, float]: ...
    def stress(self, displacement: _Array) -> tuple[_Array, _Array]: ...

def flexibility(weights: _Array, blocks: _Array) -> Compliance: ...
def available_memory() -> float | None: ...
def normal_memory(cells: int, method: str) -> float: ...
def sliding_memory(points: int, frictional: bool) -> float: ...

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
    bodies: list[tuple[float, float]],
    force: float | None,
    approach: float | None,
    moments: tuple[float | None, float | None],
    tolerance: float | None,
    is_periodic: bool,
    method: str,
) -> NormalOutcome: ...

"""The verdict of a run as frozen dataclasses: the keys of ``verdict.json``, with units in the names.

``None`` means not checked; the gate that needs the value gives the reason.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass

__all__ = [
    "Axis",
    "Clearance",
    "Deviation",
    "Finding",
    "Gate",
    "Inspected",
    "Path",
    "Profile",
    "Removal",
    "State",
    "Surface",
    "Texture",
    "Time",
    "ToolUse",
]


class State(enum.StrEnum):
    """Judgment of a gate or of a whole run. ``UNCHECKED`` never counts as ``PASS``."""

    PASS = "pass"
    """Checked, and nothing was found."""
    FAIL = "fail"
    """Checked, and at least one error was found."""
    UNCHECKED = "unchecked"
    """Not checked, or not completely; the reason says what is missing."""
    NOT_ASKED = "not_asked"
    """A gate that the scene does not use, such as roughness without a tolerance; it does not count in the verdict."""


@dataclass(frozen=True, slots=True)
class Gate:
    """One check that a program must pass before it goes to the machine."""

    name: str
    state: State
    reason: str


@dataclass(frozen=True, slots=True)
class Finding:
    """One finding of the run, with its place in the program and on the machine."""

    code: str
    family: str
    severity: str
    """``info``, ``warning`` or ``error``."""
    message: str
    file: str | None
    line: int | None
    block: int | None
    time_s: float | None
    axes: Mapping[str, float]
    """Joint positions at that time; mm or degrees."""
    bodies: tuple[str, ...]
    point_mm: tuple[float, float, float] | None
    """Position in the workpiece frame."""
    penetration_mm: float | None
    clearance_mm: float | None
    value: float | None
    limit: float | None
    unit: str | None
    repeats: int
    """Further blocks with the same finding after this one."""


@dataclass(frozen=True, slots=True)
class Time:
    """Cycle time."""

    total_s: float
    cutting_s: float
    rapid_s: float
    dwell_s: float
    tool_change_s: float
    lower_bound_s: float | None
    """Lower bound for any control, within the tolerances."""
    path_bound_s: float | None = None
    """Lower bound for any control, on the path as run."""


@dataclass(frozen=True, slots=True)
class Axis:
    """Extremes of one joint; mm or degrees, seconds."""

    unit: str
    min: float
    max: float
    max_velocity: float
    max_acceleration: float
    max_jerk: float
    velocity_utilisation: float | None
    acceleration_utilisation: float | None
    jerk_utilisation: float | None
    reversals: int
    max_following_error: float | None


@dataclass(frozen=True, slots=True)
class Path:
    """Path figures."""

    blocks: int
    length_mm: float
    max_chord_error_mm: float | None
    max_contour_error_mm: float | None
    max_axis_error_deg: float | None
    min_feed_ratio: float | None


@dataclass(frozen=True, slots=True)
class Removal:
    """Material removal."""

    moves: int
    volume_mm3: float
    stock_left_mm3: float
    sweep_bound_mm: float
    """Bound on the distance between the surface and the exact swept surface."""
    cell_mm: float
    """Distance between neighboring rays."""


@dataclass(frozen=True, slots=True)
class Deviation:
    """Deviation of the cut part from the design. Positive: material left; negative: gouge."""

    against: str | None
    tolerance_floor_mm: float | None
    """Deviations below this may be due to errors of design or sweep."""
    gouge_max_mm: float | None
    """Deepest gouge, as a positive number."""
    excess_max_mm: float | None
    mean_mm: float | None
    rms_mm: float | None
    gouge_area_mm2: float | None
    samples: int | None
    worst_point: tuple[float, float, float] | None
    """In the workpiece frame, mm."""


@dataclass(frozen=True, slots=True)
class Profile:
    """A profile of a texture; smallest and largest value over the spindle phases."""

    direction: str
    ra_um: tuple[float, float] | None
    rz_um: tuple[float, float] | None


@dataclass(frozen=True, slots=True)
class Texture:
    """The texture of one patch or profile of the surface."""

    name: str
    at_mm: tuple[float, float, float]
    model: str
    sa_um: float | None
    sq_um: float | None
    sz_um: float | None
    nodes: int
    uncut: int
    profiles: tuple[Profile, ...]
    unchecked: tuple[str, ...]
    """What could not be evaluated, and why."""


@dataclass(frozen=True, slots=True)
class Surface:
    """Texture of the surface."""

    scallop_max_um: float | None
    scallop_mean_um: float | None
    scallop_p95_um: float | None
    textures: tuple[Texture, ...] = ()


@dataclass(frozen=True, slots=True)
class Clearance:
    """Least clearance of all checked pairs of bodies."""

    min_mm: float | None
    error_mm: float | None
    """The true clearance may be smaller by this much."""
    pair: tuple[str, str] | None
    time_s: float | None


@dataclass(frozen=True, slots=True)
class ToolUse:
    """Use of one tool."""

    number: int
    name: str
    time_s: float
    cut_time_s: float
    length_mm: float
    volume_mm3: float


@dataclass(frozen=True, slots=True)
class Inspected:
    """One feature of the inspection plan, measured on the cut part."""

    name: str
    nominal_mm: float
    measured_mm: float | None
    tolerance_mm: float

"""Programs of a scene side by side, as frozen dataclasses: the keys of ``compare.json``."""

from __future__ import annotations

import functools
import json
import os
import pathlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ._build import build
from .errors import InputError
from .run import Run
from .verdict import Axis, Deviation, Gate, State, Surface, Time

__all__ = ["Comparison", "Expectation", "Gain", "ProgramFigures", "Published", "Stretch", "TimeGain"]


@dataclass(frozen=True, slots=True)
class TimeGain:
    """Time saved compared with the baseline, percent of the baseline, with its error."""

    percent: float | None
    error_percent: float | None
    smallest_percent: float | None
    """Over all variations of the twin."""
    largest_percent: float | None
    sign_holds: bool
    """Whether the gain keeps its sign in every variation."""


@dataclass(frozen=True, slots=True)
class Gain:
    """Gain of a program over the baseline. Positive numbers mean less time."""

    cycle_time_percent: float | None
    error_percent: float | None
    cycle_time: TimeGain
    cutting_time: TimeGain
    stretch_time: TimeGain
    scallop_max_change_percent: float | None
    scallop_mean_change_percent: float | None


@dataclass(frozen=True, slots=True)
class Stretch:
    """The part of a program that cuts, without approach, run-up and retract."""

    blocks: int
    time_s: float
    programmed_s: float


@dataclass(frozen=True, slots=True)
class ProgramFigures:
    """One program of a comparison."""

    folder: str
    verdict: State
    gates: tuple[Gate, ...]
    errors: int
    time: Time
    axes: Mapping[str, Axis]
    stretch: Stretch | None
    deviation: Deviation
    surface: Surface


@dataclass(frozen=True, slots=True)
class Published:
    """A published value and ours."""

    name: str
    measured: str
    """What was measured here, in words."""
    published: float
    value: float | None
    unit: str
    state: State
    source: str


@dataclass(frozen=True, slots=True)
class Expectation:
    """A criterion of the scene."""

    name: str
    measured: str
    state: State
    value: float | None
    unit: str
    at_least: float | None
    at_most: float | None
    reason: str
    source: str


class Comparison:
    """Results in the folder of a comparison."""

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = pathlib.Path(folder)
        """``compare.json``, ``compare.html`` and the run folder of each program."""
        try:
            self.document: dict[str, Any] = json.loads((self.folder / "compare.json").read_bytes())
        except (OSError, ValueError) as error:
            raise InputError(f"{self.folder} contains no comparison: {error}", file=str(self.folder)) from error

    @property
    def verdict(self) -> State:
        """Over all programs and all criteria."""
        return State(self.document["verdict"])

    @property
    def baseline(self) -> str:
        """Program that the others are compared with."""
        return str(self.document["baseline"])

    @property
    def order(self) -> tuple[str, ...]:
        """Programs in the order of the scene."""
        return tuple(self.document["order"])

    @functools.cached_property
    def programs(self) -> dict[str, ProgramFigures]:
        """Figures by program."""
        return {name: build(ProgramFigures, self.document["programs"][name]) for name in self.order}

    @functools.cached_property
    def gains(self) -> dict[str, Gain]:
        """Gain of each program over the baseline; the baseline itself is not included."""
        gains = self.document["gains"]
        return {name: build(Gain, gains[name]) for name in self.order if name in gains}

    @functools.cached_property
    def published(self) -> tuple[Published, ...]:
        """Published values and ours."""
        return tuple(build(Published, value) for value in self.document["published"])

    @functools.cached_property
    def expectations(self) -> tuple[Expectation, ...]:
        """Criteria of the scene."""
        return tuple(build(Expectation, value) for value in self.document["expectations"])

    def run(self, program: str) -> Run:
        """The run of one program."""
        if program not in self.programs:
            raise InputError(f"no program {program!r} in the comparison", remedy=f"programs: {', '.join(self.order)}")
        return Run.open(self.folder / self.programs[program].folder)

    def __repr__(self) -> str:
        return f"Comparison({self.document['scene']!r}: {self.verdict}, programs {', '.join(self.order)})"

    def _repr_html_(self) -> str:
        from ._html import comparison

        return comparison(self)

"""A run: its verdict, its tables, the cut part."""

from __future__ import annotations

import functools
import json
import os
import pathlib
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _proveout
from ._build import build
from ._proveout import Part, Table
from .errors import InputError
from .verdict import (
    Axis,
    Clearance,
    Deviation,
    Finding,
    Gate,
    Inspected,
    Path,
    Removal,
    State,
    Surface,
    Time,
    ToolUse,
)

__all__ = ["HeightMap", "Run"]


@dataclass(frozen=True, slots=True, eq=False)
class HeightMap:
    """A roughness map: heights above the design over a patch. The arrays are read-only."""

    name: str
    heights_mm: npt.NDArray[np.float64]
    """(rows, columns), along the normals of the design; nan where nothing cuts."""
    points_mm: npt.NDArray[np.float64]
    """(rows, columns, 3), nodes on the design, workpiece frame."""
    step_mm: tuple[float, float]
    """Distance of the nodes along columns and rows."""


class Run:
    """Results of a run: ``folder``, the contents of ``verdict.json``, tables as Arrow, the cut part.

    Part and height maps exist only for a run just made; a run opened from its folder has only its files.
    """

    def __init__(
        self,
        folder: str | os.PathLike[str],
        part: Part | None = None,
        height_maps: Mapping[str, HeightMap] | None = None,
    ) -> None:
        self.folder = pathlib.Path(folder)
        """The run folder."""
        try:
            self.document: dict[str, Any] = json.loads((self.folder / "verdict.json").read_bytes())
        except (OSError, ValueError) as error:
            raise InputError(f"{self.folder} contains no run: {error}", file=str(self.folder)) from error
        self._part = part
        self._height_maps = height_maps

    @classmethod
    def open(cls, folder: str | os.PathLike[str]) -> Run:
        """Opens an earlier run, made by this package or the command line."""
        return cls(folder)

    @property
    def scene(self) -> str:
        """Name of the scene."""
        return str(self.document["scene"])

    @property
    def program(self) -> str:
        """Name of the program."""
        return str(self.document["program"])

    @property
    def verdict(self) -> State:
        """Pass if all gates pass, fail if one fails, else unchecked."""
        return State(self.document["verdict"])

    @property
    def not_asked(self) -> tuple[str, ...]:
        """Names of the gates that the scene does not use; they do not count in the verdict."""
        return tuple(name for name, gate in self.gates.items() if gate.state == State.NOT_ASKED)

    @functools.cached_property
    def gates(self) -> Mapping[str, Gate]:
        """The gates by name, in their order."""
        return MappingProxyType({gate["name"]: build(Gate, gate) for gate in self.document["gates"]})

    @functools.cached_property
    def findings(self) -> tuple[Finding, ...]:
        """Findings in order of time."""
        return tuple(build(Finding, finding) for finding in self.document["findings"])

    @functools.cached_property
    def time(self) -> Time:
        """Cycle time."""
        return build(Time, self.document["time"])

    @functools.cached_property
    def axes(self) -> Mapping[str, Axis]:
        """Extremes of every joint, by name."""
        return MappingProxyType({name: build(Axis, axis) for name, axis in self.document["axes"].items()})

    @functools.cached_property
    def path(self) -> Path:
        """Path figures."""
        return build(Path, self.document["path"])

    @functools.cached_property
    def removal(self) -> Removal:
        """Material removal."""
        return build(Removal, self.document["removal"])

    @functools.cached_property
    def deviation(self) -> Deviation:
        """Deviation of the cut part from the design."""
        return build(Deviation, self.document["deviation"])

    @functools.cached_property
    def texture(self) -> Surface:
        """Ridges and roughness."""
        return build(Surface, self.document["surface"])

    @functools.cached_property
    def clearance(self) -> Clearance:
        """Least clearance."""
        return build(Clearance, self.document["clearance"])

    @functools.cached_property
    def tools(self) -> tuple[ToolUse, ...]:
        """Use of each tool, in order of first use."""
        return tuple(build(ToolUse, tool) for tool in self.document["tools"])

    @functools.cached_property
    def inspection(self) -> tuple[Inspected, ...]:
        """Features measured on the cut part."""
        return tuple(build(Inspected, feature) for feature in self.document["inspection"])

    @functools.cached_property
    def signals(self) -> Table:
        """One row per control sample: joints, tip and axis in the workpiece frame, feed, removal rate."""
        return _proveout.read_parquet(self.folder / "signals.parquet")

    @functools.cached_property
    def blocks(self) -> Table:
        """One row per block: time, length, feed, volume."""
        return _proveout.read_parquet(self.folder / "blocks.parquet")

    @functools.cached_property
    def surface(self) -> Table:
        """One row per exact point of the cut surface: position, normal, deviation, scallop; workpiece frame."""
        return _proveout.read_parquet(self.folder / "surface.parquet")

    @property
    def part(self) -> Part:
        """The surface of the cut part, workpiece frame."""
        if self._part is None:
            raise InputError(
                "the surface of the part is not in memory",
                remedy="run the scene with keep_surface=True; the folder contains it as part.glb and surface.parquet",
            )
        return self._part

    @property
    def height_maps(self) -> Mapping[str, HeightMap]:
        """Roughness maps by the name of their patch; empty where the scene has none."""
        if self._height_maps is None:
            raise InputError(
                "the height maps are not in memory",
                remedy="run the scene with keep_surface=True; the folder contains them in maps/",
            )
        return self._height_maps

    def __repr__(self) -> str:
        return f"Run({self.scene!r}, program {self.program!r}: {self.verdict}, {self.time.total_s:.1f} s)"

    def _repr_html_(self) -> str:
        from ._html import run

        return run(self)

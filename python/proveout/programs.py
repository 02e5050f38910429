"""Programs as text and as data."""

from __future__ import annotations

import json
import os
import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from . import _proveout
from ._build import build
from ._proveout import Table
from .errors import InputError
from .scene import Scene

__all__ = ["Channel", "PlannedProgram", "RescheduledProgram", "ScheduledRun", "plan", "read_nc", "reschedule"]

StrPath = str | os.PathLike[str]


@dataclass(frozen=True, slots=True)
class PlannedProgram:
    """A program for the blade of a scene."""

    text: str
    report: Mapping[str, Any] | None
    """Demands of the path on the machine, before any run; ``None`` for a helix."""

    def save(self, file: StrPath) -> pathlib.Path:
        """Writes the text."""
        return _save(self.text, file)


@dataclass(frozen=True, slots=True)
class ScheduledRun:
    """A section of a rescheduled program."""

    lines: tuple[int, int]
    time_s: float
    original_time_s: float
    bound_s: float
    """Lower bound: no schedule in the channel is faster."""
    gain_percent: float
    gap_percent: float | None
    """Largest gain that remains possible."""


@dataclass(frozen=True, slots=True)
class Channel:
    """Tool axes that a method may choose from."""

    name: str
    narrowest_deg: float
    least_velocity_deg_s: float | None


@dataclass(frozen=True, slots=True)
class RescheduledProgram:
    """A program with new tool axes; contact points, feeds and structure are kept."""

    text: str
    method: str
    source: str
    """Name of the original program."""
    options: Mapping[str, str]
    """Options given by the scene or the call."""
    runs: tuple[ScheduledRun, ...]
    channels: tuple[Channel, ...]
    uncertified: tuple[str, ...]
    """Why a section has no bound."""
    certificate: Mapping[str, Any]
    """The proof of the bounds, as ``cargo xtask verify-schedule`` reads it."""

    def save(self, file: StrPath) -> pathlib.Path:
        """Writes the text."""
        return _save(self.text, file)


def _save(text: str, file: StrPath) -> pathlib.Path:
    path = pathlib.Path(file)
    path.write_text(text, encoding="utf-8", newline="")
    return path


def _path(scene: Scene | StrPath) -> StrPath:
    return scene.path if isinstance(scene, Scene) else scene


def plan(scene: Scene | StrPath, strategy: str = "helix", *, dialect: str = "siemens-840d") -> PlannedProgram:
    """Generates a program for the blade of a scene, by a strategy of its ``[plan]``.

    Args:
        strategy: ``helix``, ``transverse``, ``iso-parametric``, ...
        dialect: language of the text.
    """
    text, report = _proveout.plan(_path(scene), strategy, dialect)
    return PlannedProgram(text, json.loads(report))


def reschedule(
    scene: Scene | StrPath,
    program: str,
    *,
    method: str,
    options: Mapping[str, object] | None = None,
    dialect: str = "siemens-840d",
) -> RescheduledProgram:
    """A program of a scene with new tool axes.

    Args:
        method: ``s-theta``, ``quaternion``, ``smooth``, ...
        options: options of the method, such as ``{"keys": 9}``; they override those of the scene.
        dialect: language of the text.
    """
    words = [(str(key), _word(value)) for key, value in (options or {}).items()]
    text, info = _proveout.reschedule(_path(scene), program, method, words, dialect)
    return build(RescheduledProgram, {"text": text, **json.loads(info)})


def _word(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def read_nc(
    program: StrPath,
    *,
    machine: StrPath | None = None,
    tools: StrPath | None = None,
    dialect: str | None = None,
    control: str | None = None,
    variables: Mapping[str, float] | None = None,
    offsets: Mapping[str, Sequence[float]] | None = None,
    feed_mm_min: float | None = None,
    subprograms: Sequence[StrPath] = (),
) -> Table:
    """The canonical commands of an NC program, one row per command, in the order of execution.

    The columns are those of ``proveout nc``: place, ``op``, end points as programmed (``X_mm``) and in base coordinates (``X_base_mm``), feed,
    speed; ``json`` holds the whole line.

    Args:
        machine: machine whose control, axes and reference points apply.
        tools: tool library with the radii for cutter compensation; the commands then move the tool center.
        dialect: default: detected from file extension and text.
        control: a built-in name (``fanuc-0i``, ...) or a control file.
        variables: values that the program reads but does not set, ``{"#500": 1.5}``.
        offsets: work offsets, ``{"G54": (x, y, z)}`` or with ``a, b, c``; mm and degrees.
        feed_mm_min: feed of motions before the first F.
        subprograms: folders searched after the folder of the program.

    Raises:
        ProgramError: the control would reject the text.
    """
    if isinstance(subprograms, str | os.PathLike):
        raise InputError("subprograms is a single path", remedy="give a list of folders")
    return _proveout.read_nc(
        program,
        machine=machine,
        tools=tools,
        dialect=dialect,
        control=control,
        variables=[f"{name}={float(value)!r}" for name, value in (variables or {}).items()],
        offsets=[f"{word}={','.join(repr(float(v)) for v in values)}" for word, values in (offsets or {}).items()],
        feed_mm_min=feed_mm_min,
        subprograms=list(subprograms),
    )

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
    """What it asks of the machine before it runs; ``None`` for a helix."""

    def save(self, file: StrPath) -> pathlib.Path:
        """Writes the text."""
        return _save(self.text, file)


@dataclass(frozen=True, slots=True)
class ScheduledRun:
    """A stretch of a re-scheduled program."""

    lines: tuple[int, int]
    time_s: float
    original_time_s: float
    bound_s: float
    """No schedule in the channel is below."""
    gain_percent: float
    gap_percent: float | None
    """What is left to gain at most."""


@dataclass(frozen=True, slots=True)
class Channel:
    """Tool axes that a method may choose from."""

    name: str
    narrowest_deg: float
    least_velocity_deg_s: float | None


@dataclass(frozen=True, slots=True)
class RescheduledProgram:
    """A program with new tool axes: contacts, feeds and structure stay."""

    text: str
    method: str
    source: str
    """Program that it was made from."""
    options: Mapping[str, str]
    """That were given, by scene or call."""
    runs: tuple[ScheduledRun, ...]
    channels: tuple[Channel, ...]
    uncertified: tuple[str, ...]
    """Why there is no bound of a stretch."""
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
    """Writes a program for the blade of a scene, by a strategy of its ``[plan]``.

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
        options: of the method, such as ``{"keys": 9}``, before those of the scene.
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
    """The canonical commands of an NC program, a row a command in the order in which the control executes them.

    The columns are those of ``proveout nc``: place, ``op``, ends as programmed (``X_mm``) and in base coordinates (``X_base_mm``), feed,
    speed; ``json`` holds the whole line.

    Args:
        machine: whose control, axes and reference points count.
        tools: tool library whose radii cutter compensation takes; the commands then move the tool center.
        dialect: found from ending and text where none is given.
        control: a built-in one (``fanuc-0i``, ...) or a control file.
        variables: values that the program reads and does not set, ``{"#500": 1.5}``.
        offsets: work offsets, ``{"G54": (x, y, z)}`` or with ``a, b, c``; mm and degrees.
        feed_mm_min: of motions before the first F.
        subprograms: folders that are searched after that of the program.

    Raises:
        ProgramError: text that the control would not run.
    """
    if isinstance(subprograms, str | os.PathLike):
        raise InputError("subprograms is one path", remedy="give a list of folders")
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

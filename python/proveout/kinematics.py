"""Joints and tool poses of a machine, as numpy arrays; mm and degrees.

Joint positions are in the order of ``Kinematics.joints``: the order of the machine, not of the alphabet.

A pose is a row ``x_mm, y_mm, z_mm, i, j, k``: tip, and unit axis from the tip to the holder, in the table frame.
"""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _proveout
from .errors import InputError

__all__ = ["Branches", "Kinematics", "Path", "kinematics"]

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Branches:
    """All joint positions that give each of n tool poses, on a machine of m joints. The arrays are read-only."""

    joints: Floats
    """(n, 2, m); nan where a pose has fewer branches. Travel limits are ignored."""
    count: npt.NDArray[np.uint32]
    """(n,), 0 where the machine cannot point the tool there."""
    singular: npt.NDArray[np.bool_]
    """(n, 2), true where the pose does not determine a rotary joint, or two branches coincide."""
    axis_error_deg: Floats
    """(n,), angle between the requested tool axis and the nearest one that the machine can reach."""


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """Joint positions along n tool poses, each continuous with the one before."""

    joints: Floats
    """(n, m); nan where the pose is not reached."""
    branch: npt.NDArray[np.int32]
    """(n,); -1 where the pose is not reached."""
    notes: tuple[str, ...]
    """One note per pose, empty if none: a joint beyond its travel, a singular pose, a pose that is not reached."""


def _rows(values: npt.ArrayLike, what: str) -> tuple[Floats, bool]:
    """As rows of doubles, and whether it was a single row."""
    try:
        array = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"the {what} are not numbers: {error}", remedy="give an array of shape (n, columns)") from None
    given = np.ndim(values)
    if given not in (1, 2):
        raise InputError(f"the {what} have {given} dimensions", remedy="give an array of shape (n, columns), or one row")
    return array.reshape(1, -1) if given == 1 else array, given == 1


class Kinematics:
    """The kinematics of a machine."""

    def __init__(self, machine: str | os.PathLike[str]) -> None:
        self._native = _proveout.Kinematics(machine)

    @property
    def name(self) -> str:
        """Name of the machine."""
        return self._native.name

    @property
    def joints(self) -> tuple[str, ...]:
        """Joints with their units, ``X_mm``, ``A_deg``: the columns of joint positions."""
        return tuple(self._native.joints)

    @property
    def home(self) -> Floats:
        """Joint positions at home, (m,)."""
        return self._native.home

    def forward(self, joints: npt.ArrayLike, *, tool_length_mm: float = 0.0) -> Floats:
        """Tool poses (n, 6) of joint positions (n, m); (6,) of one row.

        Args:
            joints: mm and degrees, in the order of ``joints``.
            tool_length_mm: from the tip to the gauge line.
        """
        rows, one = _rows(joints, "joint positions")
        poses = self._native.forward(rows, tool_length_mm)
        return poses[0] if one else poses

    def inverse(self, poses: npt.ArrayLike, *, tool_length_mm: float = 0.0) -> Branches:
        """All joint positions of tool poses (n, 6), ignoring limits; a single row counts as n = 1."""
        rows, _ = _rows(poses, "poses")
        return Branches(*self._native.inverse(rows, tool_length_mm))

    def follow(
        self, poses: npt.ArrayLike, *, tool_length_mm: float = 0.0, start: npt.ArrayLike | None = None
    ) -> Path:
        """Joint positions along tool poses (n, 6), within travel and without jumps.

        Args:
            start: joint positions before the first pose, (m,); default: home.
        """
        rows, _ = _rows(poses, "poses")
        before = None if start is None else _rows(start, "joint positions")[0]
        joints, branch, notes = self._native.follow(rows, tool_length_mm, before)
        return Path(joints, branch, tuple(notes))

    def __repr__(self) -> str:
        return repr(self._native)


def kinematics(machine: str | os.PathLike[str]) -> Kinematics:
    """The kinematics of a machine: its folder, or its ``machine.toml``."""
    return Kinematics(machine)

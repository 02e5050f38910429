"""A scene: machine, tools, stock, design and programs, and what can be done with it."""

from __future__ import annotations

import os
import pathlib
import tempfile
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Literal

from . import _proveout
from ._progress import Progress, printer
from ._values import Value, document, split
from .compare import Comparison
from .run import HeightMap, Run

__all__ = ["Dynamics", "Scene"]

StrPath = str | os.PathLike[str]
Dynamics = Literal["ideal", "planned", "servo"]


class Scene:
    """A scene as its ``scene.toml`` says it."""

    def __init__(self, path: StrPath) -> None:
        facts = _proveout.scene_facts(path)
        self.name: str = facts["name"]
        self.description: str = facts["description"]
        self.programs: tuple[str, ...] = tuple(facts["programs"])
        """Names of the programs."""
        self.machine: pathlib.Path = facts["machine"]
        """Folder of the machine."""
        self.path: pathlib.Path = facts["path"]
        """The file."""
        self._temporary: tempfile.TemporaryDirectory[str] | None = None

    @classmethod
    def load(cls, path: StrPath) -> Scene:
        """Reads a scene: its folder, or its ``scene.toml``."""
        return cls(path)

    def with_values(self, values: Mapping[str, Value], folder: StrPath | None = None) -> Scene:
        """A copy with other values, by the path of their key; ``None`` takes a key out.

        ``{"control.joint_limits.A.max_velocity_deg_s": 50}`` reaches into tables, ``{"program.original.file": "other.mpf"}`` into lists by
        the ``name`` of their tables, ``{"fixture.0.source": ""}`` by their number. A path that is
        given as text is that of a file beside the scene, as those that stand there; a path object is one of the current folder. The copy is ``scene.toml`` in ``folder``, or in a temporary folder that
        lives as long as the scene.

        Raises:
            InputError: a key or a value that scenes do not have.
        """
        return self._copy(values, None, folder)

    def _copy(
        self, values: Mapping[str, Value], programs: Sequence[str] | None, folder: StrPath | None = None
    ) -> Scene:
        documents = [(key, document(key, value)) for key, value in values.items()]
        temporary = None
        if folder is None:
            temporary = tempfile.TemporaryDirectory(prefix="proveout-scene-")
            folder = temporary.name
        else:
            os.makedirs(folder, exist_ok=True)
        to = pathlib.Path(folder) / "scene.toml"
        _proveout.scene_copy(self.path, to, documents, None if programs is None else list(programs))
        copy = Scene(to)
        copy._temporary = temporary
        return copy

    def run(
        self,
        program: str | None = None,
        *,
        nc: StrPath | None = None,
        resolution_mm: float | None = None,
        threads: int | None = None,
        dynamics: Dynamics | None = None,
        plant: Literal["newton-euler", "rapier"] | None = None,
        out: StrPath | None = None,
        preview: bool = False,
        stop_at: str | None = None,
        set: Mapping[str, Value] | None = None,
        rerun: bool = False,
        keep_surface: bool = True,
        progress: bool | Progress = False,
    ) -> Run:
        """Proves a program out: runs it on the twin, cuts the stock, writes the run folder.

        Args:
            program: name in the scene; the first one where none is given.
            nc: program text to run instead of the one that the scene names.
            resolution_mm: distance of the stock's rays instead of that of the scene.
            threads: worker threads, one a processor where none are given; the verdict does not depend on them.
            dynamics: which motion cuts, instead of that of the scene.
            plant: what moves under the forces of the drives, with ``dynamics="servo"``.
            out: run folder; ``out/SCENE-PROGRAM`` where none is given. An older run there is replaced when the new one is complete.
            preview: a quick look with coarse cells, which proves nothing that it does not find.
            stop_at: ends the run early: ``any``, the code of a finding, a line as ``120``, a time as ``12.5s``.
            set: other values of scene, machine and tools by their keys, as ``--set`` of the program takes them; the verdict names them. Lists and
                tables make a scene of their own, as ``with_values`` does.
            rerun: writes a recording too, where the wheel was built for it.
            keep_surface: keeps the surface of the part and its height maps in memory.
            progress: prints how far the run is, or is called about ten times a second with a share from 0 to 1 and a text. What it raises
                ends the run.

        Raises:
            ProveoutError: there is no verdict; nothing is written. A program that fails has a verdict and raises nothing.
            KeyboardInterrupt: at Ctrl-C, when what was half written is removed.
        """
        plain, rest = split(set or {})
        scene = self.with_values(rest) if rest else self
        folder, part, maps = _proveout.run(
            scene.path,
            program=program,
            nc=nc,
            resolution_mm=resolution_mm,
            threads=threads,
            dynamics=dynamics,
            plant=plant,
            out=out,
            preview=preview,
            stop_at=stop_at,
            set=plain,
            rerun=rerun,
            keep_surface=keep_surface,
            progress=printer(progress),
        )
        if part is None:
            return Run(folder)
        kept = {name: HeightMap(name, heights, points, (step[0], step[1])) for name, heights, points, step in maps}
        return Run(folder, part, MappingProxyType(kept))

    def compare(
        self,
        programs: Sequence[str] | None = None,
        *,
        baseline: str | None = None,
        resolution_mm: float | None = None,
        threads: int | None = None,
        dynamics: Dynamics | None = None,
        out: StrPath | None = None,
        set: Mapping[str, Value] | None = None,
        rerun: bool = False,
        progress: bool | Progress = False,
    ) -> Comparison:
        """Runs programs on the same twin and compares them: times with their error, joints, cut parts.

        Args:
            programs: names in the scene; all where none are given. One that is made from another brings that one with it.
            baseline: program that the others are compared with, instead of that of the scene.
            out: folder; ``out/SCENE-compare`` where none is given.

        The other arguments and the errors are those of ``run``.
        """
        changed = bool(set) or programs is not None
        scene = self._copy(set or {}, programs) if changed else self
        folder = _proveout.compare(
            scene.path,
            baseline=baseline,
            resolution_mm=resolution_mm,
            threads=threads,
            dynamics=dynamics,
            out=out,
            rerun=rerun,
            progress=printer(progress),
        )
        return Comparison(folder)

    def __repr__(self) -> str:
        return f"Scene({self.name!r}, programs {', '.join(self.programs)})"

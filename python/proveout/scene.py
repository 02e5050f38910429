"""A scene: machine, tools, stock, design and programs, and the operations on it."""

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
    """A scene as defined by its ``scene.toml``."""

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
        """A copy with changed values, by dotted key; ``None`` removes a key.

        ``{"control.joint_limits.A.max_velocity_deg_s": 50}`` addresses a table, ``{"program.original.file": "other.mpf"}``
        an entry of a list by the ``name`` of its table, ``{"fixture.0.source": ""}`` by its number. A path given as text
        is relative to the scene, as in the file itself; a path object is relative to the current folder. The copy is
        ``scene.toml`` in ``folder``, or in a temporary folder that lives as long as the scene.

        Raises:
            InputError: an unknown key or an invalid value.
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
        output: StrPath | None = None,
        preview: bool = False,
        stop_at: str | None = None,
        set: Mapping[str, Value] | None = None,
        rerun: bool = False,
        keep_surface: bool = True,
        progress: bool | Progress = False,
    ) -> Run:
        """Proves out a program: simulates it on the twin, cuts the stock, writes the run folder.

        Args:
            program: name in the scene; default: the first one.
            nc: NC program to run instead of the one named in the scene.
            resolution_mm: cell size of the stock (distance between its rays); default: that of the scene.
            threads: worker threads; default: one per processor. The verdict does not depend on their number.
            dynamics: motion model that cuts the stock; default: that of the scene.
            plant: mechanical model driven by the drive forces, with ``dynamics="servo"``.
            output: run folder; default: ``out/SCENE-PROGRAM``. An older run there is replaced once the new one is
                complete.
            preview: quick run with coarse cells. Its findings are real; their absence proves nothing.
            stop_at: stops the run early: ``any`` (first finding that fails a gate), a finding code, a line (``120``),
                a time (``12.5s``).
            set: values of scene, machine and tools by dotted key, as for ``--set`` on the command line; the verdict
                lists them. Lists and tables are written to a copy of the scene, as by ``with_values``.
            rerun: also writes a recording, if the wheel was built with that feature.
            keep_surface: keeps the surface of the part and its height maps in memory.
            progress: ``True`` prints the progress; a function is called about ten times a second with a share from
                0 to 1 and a text. An exception in it ends the run.

        Raises:
            ProveoutError: there is no verdict, and nothing is written. A failing program has a verdict and raises no
                exception.
            KeyboardInterrupt: at Ctrl-C; incomplete output is removed.
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
            output=output,
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
        output: StrPath | None = None,
        set: Mapping[str, Value] | None = None,
        rerun: bool = False,
        progress: bool | Progress = False,
    ) -> Comparison:
        """Runs programs on the same twin and compares cycle times (with error), joints and cut parts.

        Args:
            programs: names in the scene; default: all. A program derived from another one includes that one.
            baseline: program to compare the others with; default: that of the scene.
            output: folder; default: ``out/SCENE-compare``.

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
            output=output,
            rerun=rerun,
            progress=printer(progress),
        )
        return Comparison(folder)

    def __repr__(self) -> str:
        return f"Scene({self.name!r}, programs {', '.join(self.programs)})"

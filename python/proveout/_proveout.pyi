"""The native module; use the names of the package instead."""

import os
import pathlib
from collections.abc import Callable, Sequence
from typing import Any, TypedDict

import numpy as np
import numpy.typing as npt

__version__: str
records_rerun: bool

_StrPath = str | os.PathLike[str]
_Progress = Callable[[float, str], object]
_Floats = npt.NDArray[np.float64]

class Table:
    """A table in memory; null where a value is unknown.

    Any reader of the Arrow C stream interface uses it without a copy: ``pyarrow.table(t)``, ``polars.DataFrame(t)``.
    """

    @property
    def column_names(self) -> list[str]: ...
    @property
    def units(self) -> dict[str, str]: ...
    @property
    def num_rows(self) -> int: ...
    @property
    def num_columns(self) -> int: ...
    def __len__(self) -> int: ...
    def __getitem__(self, name: str) -> Any: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...
    def __arrow_c_schema__(self) -> object: ...

class Part:
    """The surface of a cut part, workpiece frame; the arrays are read-only."""

    @property
    def vertices(self) -> _Floats: ...
    @property
    def triangles(self) -> npt.NDArray[np.uint32]: ...
    @property
    def normals(self) -> _Floats: ...
    @property
    def deviation(self) -> _Floats: ...
    def mesh(self) -> tuple[_Floats, npt.NDArray[np.uint32]]: ...

class Kinematics:
    def __init__(self, machine: _StrPath) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def joints(self) -> list[str]: ...
    @property
    def home(self) -> _Floats: ...
    def forward(self, joints: _Floats, tool_length_mm: float) -> _Floats: ...
    def inverse(
        self, poses: _Floats, tool_length_mm: float
    ) -> tuple[_Floats, npt.NDArray[np.uint32], npt.NDArray[np.bool_], _Floats]: ...
    def follow(
        self, poses: _Floats, tool_length_mm: float, start: _Floats | None
    ) -> tuple[_Floats, npt.NDArray[np.int32], list[str]]: ...

class _SceneFacts(TypedDict):
    name: str
    description: str
    programs: list[str]
    machine: pathlib.Path
    path: pathlib.Path
    folder: pathlib.Path

def call(words: list[str]) -> int: ...
def scene_facts(scene: _StrPath) -> _SceneFacts: ...
def scene_copy(scene: _StrPath, to: _StrPath, values: list[tuple[str, str]], programs: list[str] | None) -> None: ...
def read_parquet(file: _StrPath) -> Table: ...
def run(
    scene: _StrPath,
    *,
    program: str | None,
    nc: _StrPath | None,
    resolution_mm: float | None,
    threads: int | None,
    dynamics: str | None,
    plant: str | None,
    output: _StrPath | None,
    preview: bool,
    stop_at: str | None,
    set: Sequence[str],
    rerun: bool,
    keep_surface: bool,
    progress: _Progress | None,
) -> tuple[pathlib.Path, Part | None, list[tuple[str, _Floats, _Floats, list[float]]]]: ...
def compare(
    scene: _StrPath,
    *,
    baseline: str | None,
    resolution_mm: float | None,
    threads: int | None,
    dynamics: str | None,
    output: _StrPath | None,
    rerun: bool,
    progress: _Progress | None,
) -> pathlib.Path: ...
def plan(scene: _StrPath, strategy: str, dialect: str | None) -> tuple[str, str]: ...
def reschedule(
    scene: _StrPath, program: str, method: str, options: list[tuple[str, str]], dialect: str | None
) -> tuple[str, str]: ...
def read_nc(
    program: _StrPath,
    *,
    machine: _StrPath | None,
    tools: _StrPath | None,
    dialect: str | None,
    control: str | None,
    variables: list[str],
    offsets: list[str],
    feed_mm_min: float | None,
    subprograms: list[_StrPath],
) -> Table: ...

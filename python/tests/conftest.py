"""What the tests share. They look at the wheel that is installed, from outside of the sources."""

from __future__ import annotations

import pathlib
import subprocess
import sys

import pytest

import proveout as pv

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Cells so coarse that a run takes a second; what is tested does not depend on them.
COARSE_MM = 2.0


@pytest.fixture(scope="session", autouse=True)
def _installed() -> None:
    assert ROOT / "python" not in pathlib.Path(pv.__file__).parents, "the sources are tested, not the wheel"


@pytest.fixture(scope="session")
def root() -> pathlib.Path:
    return ROOT


@pytest.fixture(scope="session")
def scenes() -> pathlib.Path:
    return ROOT / "scenes"


@pytest.fixture(scope="session")
def machines() -> pathlib.Path:
    return ROOT / "machines"


@pytest.fixture
def program(root):
    """Calls the program that the wheel brings."""

    def call(*words: object, code: int | None = None) -> subprocess.CompletedProcess[str]:
        command = [str(pathlib.Path(sys.executable).with_name("proveout")), *map(str, words)]
        done = subprocess.run(command, capture_output=True, text=True, cwd=root, check=False)
        assert code is None or done.returncode == code, done.stderr
        return done

    return call


@pytest.fixture(scope="session")
def cone(scenes):
    return pv.Scene.load(scenes / "cone-frustum")


@pytest.fixture(scope="session")
def cone_run(cone, tmp_path_factory):
    return cone.run("bc", resolution_mm=COARSE_MM, threads=1, output=tmp_path_factory.mktemp("cone") / "run")


@pytest.fixture(scope="session")
def face_run(scenes, tmp_path_factory):
    """A run with roughness maps."""
    scene = pv.Scene.load(scenes / "face-mill-marks")
    coarse = {"surface.step_um": 100}
    return scene.run(resolution_mm=1, set=coarse, output=tmp_path_factory.mktemp("face") / "run")

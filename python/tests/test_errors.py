"""Input that is wrong: an error with its place, never a panic."""

from __future__ import annotations

import math
import os
import pathlib
import signal
import subprocess
import sys
import time

import pytest

import proveout as pv

NAN = math.nan


def test_errors_carry_place_and_remedy(cone, tmp_path):
    text = cone.path.read_text().replace("resolution_mm", "resolutoin_mm")
    (tmp_path / "scene.toml").write_text(text)
    with pytest.raises(pv.InputError) as raised:
        pv.Scene.load(tmp_path)
    error = raised.value
    assert isinstance(error, ValueError)
    assert error.file == str(tmp_path / "scene.toml")
    assert error.line == 1 + text[: text.index("resolutoin_mm")].count("\n")
    assert error.column == 1
    assert error.place == f"{error.file}:{error.line}:1"
    assert "resolution_mm" in error.remedy
    assert "resolutoin_mm" in error.message
    assert error.place in str(error)


def test_faults_of_programs_are_told_with_their_line(cone, tmp_path):
    file = tmp_path / "wrong.mpf"
    file.write_text("G90 G0 X0 Y0 Z100\nG1 X10 FRED=3\nM30\n")
    with pytest.raises(pv.ProgramError) as raised:
        cone.run(nc=file, resolution_mm=4, output=tmp_path / "run")
    assert raised.value.line == 2
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"resolution_mm": -1}, "resolution_mm = -1"),
        ({"resolution_mm": 0}, "resolution_mm = 0"),
        ({"resolution_mm": NAN}, "resolution_mm = NaN"),
        ({"resolution_mm": math.inf}, "resolution_mm = inf"),
        ({"resolution_mm": 1e-9}, "stock|memory|cells"),
        ({"threads": 0}, "threads = 0"),
        ({"threads": -3}, "threads = -3"),
        ({"threads": 10**6}, "threads = 1000000"),
        ({"dynamics": "fast"}, "dynamics"),
        ({"plant": "clay"}, "plant"),
        ({"stop_at": "never"}, "stop_at"),
        ({"program": "nothing"}, "nothing"),
        ({"nc": "/nowhere/x.mpf"}, "nowhere"),
        ({"preview": True, "resolution_mm": 1}, "preview"),
        ({"set": {"control.nothing": 1}}, "nothing"),
        ({"set": {"resolution_mm": NAN}}, "not a finite number"),
        ({"set": {"": 1}}, "is no key"),
        ({"set": {"name.x": 1}}, "leads nowhere"),
        ({"set": {"program.nothing.file": "x"}}, "leads nowhere"),
        ({"set": {"name": object()}}, "not a valid value of a scene"),
        ({"set": {"stock": []}}, "stock"),
    ],
)
def test_wrong_arguments_are_refused(cone, tmp_path, words, message):
    with pytest.raises(pv.ProveoutError, match=message):
        cone.run(**{"program": "bc", "output": tmp_path / "run"} | words)
    assert not (tmp_path / "run").exists()


def test_arguments_of_another_type_are_refused(cone, tmp_path):
    for words in ({"resolution_mm": "1"}, {"threads": 1.5}, {"program": 3}, {"output": 5}):
        with pytest.raises(TypeError):
            cone.run(**{"output": tmp_path / "run"} | words)


def test_folders_of_others_stay(cone, tmp_path):
    place = tmp_path / "mine"
    place.mkdir()
    (place / "letter.txt").write_text("mine")
    with pytest.raises(pv.FolderError) as raised:
        cone.run("bc", resolution_mm=4, output=place)
    assert isinstance(raised.value, OSError)
    assert (place / "letter.txt").read_text() == "mine"


def test_paths_that_are_not_there(tmp_path):
    for path in (tmp_path, tmp_path / "nothing", str(tmp_path / "nothing"), b"nothing".decode()):
        with pytest.raises(pv.InputError):
            pv.Scene.load(path)
        with pytest.raises(pv.InputError):
            pv.kinematics(path)
    with pytest.raises(pv.ProveoutError):
        pv.read_nc(tmp_path / "nothing.mpf")


INTERRUPTED = """
import pathlib, sys
import proveout as pv

scene = pv.Scene.load(sys.argv[1])
try:
    scene.run("bc", resolution_mm=0.3, threads=1, output=sys.argv[2], progress=lambda *_: print("told", flush=True))
except KeyboardInterrupt:
    print("interrupted", flush=True)
    raise SystemExit(7)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals of another kind")
def test_ctrl_c_ends_a_run_and_leaves_nothing(cone, tmp_path):
    place = tmp_path / "out" / "run"
    command = [sys.executable, "-c", INTERRUPTED, str(cone.path), str(place)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "told\n"
    time.sleep(0.3)
    began = time.monotonic()
    process.send_signal(signal.SIGINT)
    rest, _ = process.communicate(timeout=60)
    print(f"ended {time.monotonic() - began:.2f} s after the signal")
    assert process.returncode == 7
    assert rest.endswith("interrupted\n")
    assert list(pathlib.Path(place.parent).iterdir()) == []


def test_the_program_of_the_wheel(program, scenes, tmp_path):
    assert program("--version", code=0).stdout.strip() == f"proveout {pv.__version__}"
    assert program("run", scenes / "nothing", code=2).stderr.startswith("error:")
    done = program("run", scenes / "cone-frustum", "--resolution-mm", 4, "--output", tmp_path / "run")
    assert done.returncode in (0, 1, 3)
    assert f"{tmp_path / 'run'}" in done.stdout
    command = (tmp_path / "run" / "run.json").read_text()
    assert '"proveout",\n    "run"' in command

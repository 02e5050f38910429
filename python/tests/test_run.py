"""Runs: what they say, that they are those of the command line, how they are ended."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import pathlib
import threading
import tomllib

import numpy as np
import pytest

import proveout as pv

COARSE_MM = 2.0


def test_a_scene_tells_what_it_holds(cone, scenes):
    assert cone.name == "cone-frustum"
    assert cone.programs == ("bc", "bc-ideal", "ac", "ac-ideal")
    assert cone.machine.resolve().name == "spinner-u5-620"
    assert pv.Scene.load(str(scenes / "cone-frustum" / "scene.toml")).path == cone.path
    assert repr(cone) == "Scene('cone-frustum', programs bc, bc-ideal, ac, ac-ideal)"


def test_the_judgment_is_that_of_the_file(cone_run):
    said = json.loads((cone_run.folder / "verdict.json").read_text())
    assert cone_run.verdict == said["verdict"]
    assert isinstance(cone_run.verdict, pv.State)
    assert [g.name for g in cone_run.gates.values()] == [g["name"] for g in said["gates"]]
    assert [g.state for g in cone_run.gates.values()] == [g["state"] for g in said["gates"]]
    assert cone_run.time.total_s == said["time"]["total_s"] > 10
    assert cone_run.deviation.gouge_max_mm == said["deviation"]["gouge_max_mm"]
    assert cone_run.deviation.worst_point == tuple(said["deviation"]["worst_point"])
    assert set(cone_run.axes) == set(said["axes"])
    assert cone_run.axes["B"].unit == "deg"
    assert [t.name for t in cone_run.tools] == [t["name"] for t in said["tools"]]
    assert len(cone_run.findings) == len(said["findings"])
    with pytest.raises(dataclasses.FrozenInstanceError):
        cone_run.time.total_s = 0.0


def test_the_verdict_has_the_bytes_of_the_command_line(cone, cone_run, program, tmp_path):
    program("run", cone.path, "--program", "bc", "--resolution-mm", COARSE_MM, "--output", tmp_path / "cli")
    names = {p.name for p in (tmp_path / "cli").iterdir()}
    assert {p.name for p in cone_run.folder.iterdir()} == names - {"recording.rrd"}
    for name in names - {"run.json", "manifest.json", "recording.rrd"}:
        ours, theirs = ((f / name).read_bytes() for f in (cone_run.folder, tmp_path / "cli"))
        assert hashlib.sha256(ours).digest() == hashlib.sha256(theirs).digest(), name
    assert program("verify", cone_run.folder).returncode == 0


def test_two_threads_of_python_run_side_by_side(cone, cone_run, tmp_path):
    runs = {}

    def run(name):
        runs[name] = cone.run("bc", resolution_mm=COARSE_MM, threads=1, output=tmp_path / name)

    threads = [threading.Thread(target=run, args=(name,)) for name in ("a", "b")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    want = (cone_run.folder / "verdict.json").read_bytes()
    assert [(runs[n].folder / "verdict.json").read_bytes() == want for n in ("a", "b")] == [True, True]


def test_one_place_is_not_written_by_two_runs_at_once(cone, tmp_path):
    seen = []

    def progress(share, text):
        if not seen:
            seen.append(text)
            with pytest.raises(pv.InputError, match="another run of this process"):
                cone.run("bc", resolution_mm=COARSE_MM, output=tmp_path / "run")

    cone.run("bc", resolution_mm=0.7, output=tmp_path / "run", progress=progress)
    assert seen, "the run was over before it told anything"


def test_arguments_reach_the_run(cone, cone_run, tmp_path):
    ideal = cone.run("bc", resolution_mm=4, dynamics="ideal", output=tmp_path / "ideal")
    assert ideal.removal.cell_mm == 4
    assert ideal.path.max_contour_error_mm < 1e-6 < cone_run.path.max_contour_error_mm
    stopped = cone.run("bc", resolution_mm=4, stop_at="5s", output=tmp_path / "stopped", keep_surface=False)
    assert stopped.verdict != "pass"
    assert stopped.time.total_s < 10
    preview = cone.run("bc", preview=True, output=tmp_path / "preview")
    assert preview.document["partial"]["preview"]["cells_mm"] == [2.0, 2.0, 2.0]


def test_values_of_the_scene_can_be_set(cone, cone_run, tmp_path):
    limit = {"max_velocity_deg_s": 5, "source": "test"}
    slow = cone.run("bc", resolution_mm=4, set={"control.joint_limits.C": limit}, output=tmp_path / "a")
    assert slow.time.total_s > cone_run.time.total_s
    assert slow.axes["C"].max_velocity <= 5.01


def test_a_scene_with_other_values_means_the_same_files(cone, root, tmp_path, monkeypatch):
    monkeypatch.chdir(root)
    values = {
        "description": "another",
        "program.0.name": "first",
        "program.ac.file": "bc.mpf",
        "program.ac.machine": pathlib.Path("machines/bc-trunnion"),
        "tolerances.near_miss_mm": None,
    }
    copy = cone.with_values(values, tmp_path / "copy")
    assert copy.path == tmp_path / "copy" / "scene.toml"
    assert (copy.description, copy.programs[0]) == ("another", "first")
    assert copy.machine.resolve() == cone.machine.resolve()
    written = tomllib.loads(copy.path.read_text())
    program = next(p for p in written["program"] if p["name"] == "ac")
    assert program["file"] == str(cone.path.parent / "bc.mpf")
    assert program["machine"] == str(root / "machines" / "bc-trunnion")
    assert "near_miss_mm" not in written["tolerances"]
    run = copy.run("ac", resolution_mm=4, output=tmp_path / "run")
    assert run.document["machine"]["name"] == "BC trunnion"


def test_progress_is_told_and_may_end_the_run(cone, tmp_path):
    told = []
    cone.run("bc", resolution_mm=1, output=tmp_path / "a", progress=lambda share, text: told.append((share, text)))
    shares = [share for share, _ in told]
    assert shares == sorted(shares)
    assert shares[-1] == 1
    assert "bc" in told[-1][1]

    class Enough(Exception):
        pass

    def enough(share, text):
        raise Enough(text)

    with pytest.raises(Enough):
        cone.run("bc", resolution_mm=0.6, output=tmp_path / "b", progress=enough)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a"]


def test_progress_is_printed(cone, tmp_path, capfd):
    cone.run("bc", resolution_mm=4, output=tmp_path / "a", progress=True)
    cone.run("bc", resolution_mm=4, output=tmp_path / "b")
    assert capfd.readouterr().out == ""


def test_a_run_is_opened_again(cone_run):
    again = pv.Run.open(cone_run.folder)
    assert again.verdict == cone_run.verdict
    assert again.signals.num_rows == cone_run.signals.num_rows
    with pytest.raises(pv.InputError, match="not in memory"):
        _ = again.part
    with pytest.raises(pv.InputError, match="contains no run"):
        pv.Run.open(cone_run.folder.parent)


def test_the_part_is_a_closed_mesh_of_the_cone(cone_run):
    vertices, triangles = cone_run.part.mesh()
    assert vertices.dtype == np.float64
    assert triangles.dtype == np.uint32
    assert triangles.max() == len(vertices) - 1
    assert cone_run.part.normals.shape == vertices.shape
    assert np.allclose(np.linalg.norm(cone_run.part.normals, axis=1), 1, atol=1e-6)
    corners = vertices[triangles]
    volume = np.einsum("ni,ni->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume == pytest.approx(cone_run.removal.stock_left_mm3, rel=0.02)
    deviation = cone_run.part.deviation
    assert deviation.shape == (len(vertices),)
    assert np.nanmin(deviation) < 0.01


def test_roughness_maps(face_run):
    assert list(face_run.height_maps) == ["middle", "side"]
    middle = face_run.height_maps["middle"]
    assert middle.heights_mm.shape == middle.points_mm.shape[:2]
    assert middle.step_mm == pytest.approx((0.1, 0.1), rel=0.05)
    assert np.allclose(middle.points_mm[..., 2], 0, atol=1e-6)
    height = middle.heights_mm - middle.heights_mm.mean()
    texture = {t.name: t for t in face_run.texture.textures}["middle"]
    assert 1e3 * np.abs(height).mean() == pytest.approx(texture.sa_um, rel=0.2)


def test_notebooks_show_a_run_without_loading_anything(cone_run):
    page = cone_run._repr_html_()
    assert "<svg" in page
    assert "collision" in page
    assert "http" not in page
    assert "script" not in page

"""Planned, re-scheduled and read programs, against the command line."""

from __future__ import annotations

import json

import numpy as np
import pyarrow as pa
import pytest

import proveout as pv


def test_a_plan_is_that_of_the_command_line(scenes, program, tmp_path):
    scene = pv.Scene.load(scenes / "li-2022-s-theta")
    made = pv.plan(scene, "helix")
    file = tmp_path / "helix.mpf"
    program("plan", scene.path, "--strategy", "helix", "--output", file, code=0)
    assert made.text.encode() == file.read_bytes()
    assert made.report is None
    assert made.save(tmp_path / "again.mpf").read_bytes() == file.read_bytes()


def test_a_new_schedule_is_that_of_the_command_line(scenes, program, tmp_path):
    scene = pv.Scene.load(scenes / "li-2022-s-theta")
    made = pv.reschedule(scene, "original", method="quaternion", options={"keys": 9})
    file = tmp_path / "new.mpf"
    words = ("--program", "original", "--method", "quaternion", "--set", "keys=9", "--output", file)
    program("reschedule", scene.path, *words, code=0)
    assert made.text.encode() == file.read_bytes()
    assert made.options["keys"] == "9"
    assert made.source == "original"
    assert len(made.runs) + len(made.uncertified) == 1
    for run in made.runs:
        assert run.bound_s <= run.time_s
    with pytest.raises(pv.InputError, match="no option"):
        pv.reschedule(scene, "original", method="quaternion", options={"max_key_lean_deg": 9})
    with pytest.raises(pv.InputError, match="unknown method") as refused:
        pv.reschedule(scene, "original", method="magic")
    assert "s-theta" in refused.value.remedy


def test_commands_are_those_of_the_command_line(scenes, program):
    file = scenes / "cone-frustum" / "bc.mpf"
    table = pv.read_nc(file)
    lines = [json.loads(line) for line in program("nc", file, code=0).stdout.splitlines()]
    assert len(table) == len(lines) > 100
    assert [json.loads(line) for line in table["json"]] == lines
    assert table["op"] == [line["op"] for line in lines]
    x = table["X_mm"]
    want = [line.get("end", {}).get("X", np.nan) for line in lines]
    assert np.array_equal(x, np.array(want, dtype=float), equal_nan=True)
    assert table.units["B_deg"] == "deg"
    assert pa.table(table).num_rows == len(lines)


def test_how_a_program_is_read_can_be_said(tmp_path):
    file = tmp_path / "part.nc"
    file.write_text("G90 G54 G0 X#500 Y0 Z0\nG1 X5 F100\nM30\n")
    table = pv.read_nc(file, dialect="fanuc", variables={"#500": 1.5}, offsets={"G54": (10, 0, 0)})
    ends = [x for x in table["X_mm"] if not np.isnan(x)]
    assert ends == [1.5, 5]
    assert [x for x in table["X_base_mm"] if not np.isnan(x)] == [11.5, 15]
    with pytest.raises(pv.InputError, match="dialect 'x'|dialect \"x\""):
        pv.read_nc(file, dialect="x")
    with pytest.raises(pv.ProveoutError):
        pv.read_nc(file, dialect="fanuc", feed_mm_min=float("nan"))
    with pytest.raises(pv.InputError, match="single path"):
        pv.read_nc(file, subprograms="folder")


def test_a_comparison_can_be_ended(scenes, tmp_path):
    scene = pv.Scene.load(scenes / "ma-2020-sine")

    class Enough(Exception):
        pass

    def enough(share, text):
        raise Enough(text)

    with pytest.raises(Enough, match="motions"):
        scene.compare(resolution_mm=3, output=tmp_path / "ended", progress=enough)
    assert list(tmp_path.iterdir()) == []


def test_a_comparison_is_that_of_the_command_line(scenes, program, tmp_path):
    scene = pv.Scene.load(scenes / "ma-2020-sine")
    names = scene.programs[:2]
    cmp = scene.compare(names, resolution_mm=3, output=tmp_path / "ours", threads=1)
    assert cmp.order[: len(names)] == names
    assert cmp.baseline in names
    other = next(n for n in cmp.order if n != cmp.baseline)
    gain = cmp.gains[other]
    times = [cmp.programs[n].stretch.time_s for n in (cmp.baseline, other)]
    assert gain.stretch_time.percent == pytest.approx(100 * (1 - times[1] / times[0]), abs=1e-6)
    assert cmp.baseline in cmp._repr_html_()
    copy = scene._copy({}, names, tmp_path / "copy")
    program("compare", copy.path, "--resolution-mm", 3, "--output", tmp_path / "cli")
    assert (tmp_path / "cli" / "compare.json").read_bytes() == (cmp.folder / "compare.json").read_bytes()
    with pytest.raises(pv.InputError, match="no program 'nothing'"):
        cmp.run("nothing")
    with pytest.raises(pv.InputError, match="no program"):
        scene.compare(["nothing"])

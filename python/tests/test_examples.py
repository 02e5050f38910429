"""The notebooks run, and say what they claim."""

from __future__ import annotations

import json
import time

import pytest


def run_cells(root, name, monkeypatch):
    """Executes the code cells in a namespace of their own, in the folder where a notebook stands."""
    monkeypatch.chdir(root / "examples")
    cells = json.loads((root / "examples" / f"{name}.ipynb").read_text(encoding="utf-8"))["cells"]
    names: dict[str, object] = {"__name__": "__main__"}
    began = time.monotonic()
    for number, cell in enumerate(cells):
        if cell["cell_type"] == "code":
            assert cell["outputs"] == [], "outputs are not kept"
            assert cell["execution_count"] is None
            exec(compile("".join(cell["source"]), f"{name}, cell {number}", "exec"), names)
    print(f"{name}: {time.monotonic() - began:.1f} s")
    return names


def test_every_notebook_is_run_here(root):
    names = sorted(path.stem for path in (root / "examples").glob("*.ipynb"))
    assert names == ["fastest_machine", "gain_over_joint_limit", "roughness_over_lead_and_tilt"]


def test_gain_over_a_joint_limit(root, monkeypatch):
    names = run_cells(root, "gain_over_joint_limit", monkeypatch)
    curve = dict(sorted(names["curve"].items()))
    limits = [limit for limit in curve if limit >= 40]
    assert all(curve[a] >= curve[b] for a, b in zip(limits, limits[1:], strict=False)), "a slower axis gains more"
    assert curve[max(curve)] == pytest.approx(0, abs=0.5)
    assert names["gain"] == pytest.approx(17.8, abs=1.5), "the figure of the page of experiments"
    assert names["runs"]["s-theta"].axes["A"].reversals < names["runs"]["original"].axes["A"].reversals


def test_roughness_over_lead_and_tilt(root, monkeypatch):
    names = run_cells(root, "roughness_over_lead_and_tilt", monkeypatch)
    planned, measured = names["planned"], names["measured"]
    assert planned[5, 0] < planned[10, 0] < planned[20, 0] < planned[35, 0]
    for axis, ridge in measured.items():
        assert 0.6 * planned[axis] < ridge <= planned[axis], axis
    assert "<svg" in names["run"]._repr_html_()


def test_fastest_machine(root, monkeypatch):
    runs = run_cells(root, "fastest_machine", monkeypatch)["runs"]
    times = {machine: run.time.total_s for machine, run in runs.items()}
    assert max(times, key=times.get) == "fork-head-gantry"
    assert all(run.time.lower_bound_s < run.time.total_s for run in runs.values())

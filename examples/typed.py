"""A whole use of the package, as `mypy --strict` reads it: `python examples/typed.py`."""

from __future__ import annotations

import pathlib
import tempfile

import numpy as np
import numpy.typing as npt

import proveout as pv

ROOT = pathlib.Path(__file__).resolve().parents[1]


def share_below_feed(table: pv.Table, part: float) -> float:
    """Share of the time in feed in which the tool runs below a part of the programmed feed."""
    programmed: npt.NDArray[np.float64] = table["feed_programmed_mm_min"]
    feed: npt.NDArray[np.float64] = table["feed_mm_min"]
    in_feed = programmed > 0
    return float((feed[in_feed] < part * programmed[in_feed]).mean())


def first_error(run: pv.Run) -> pv.Finding | None:
    """The first fault that closes a gate."""
    return next((finding for finding in run.findings if finding.severity == "error"), None)


def main() -> None:
    """Proves a program out and prints what it says."""
    scene = pv.Scene.load(ROOT / "scenes" / "cone-frustum")
    with tempfile.TemporaryDirectory() as folder:
        try:
            run = scene.run("bc", resolution_mm=2.0, threads=1, output=pathlib.Path(folder) / "run", progress=True)
        except pv.InputError as error:
            print(error.place, error.message, error.remedy)
            return
        state: pv.State = run.verdict
        print(state, {gate.name: gate.state.value for gate in run.gates.values()})
        vertices, triangles = run.part.mesh()
        print(f"{len(triangles)} triangles, z from {vertices[:, 2].min():.2f} to {vertices[:, 2].max():.2f} mm")
        print(f"{run.time.total_s:.1f} s, {100 * share_below_feed(run.signals, 0.9):.0f} % of the feed below nine tenths of it")
        error_found = first_error(run)
        if error_found is not None:
            print(error_found.code, error_found.line)
    machine = pv.kinematics(scene.machine)
    branches = machine.inverse([[0.0, 0.0, 100.0, 0.0, 0.0, 1.0]])
    print(machine.joints, branches.joints[0, 0].tolist())


if __name__ == "__main__":
    main()

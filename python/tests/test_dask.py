"""Sweeps on Dask workers: same bytes for 1, 2 and 4, a worker that is killed, a second run, a job that cannot be run."""

from __future__ import annotations

import os
import pathlib
import shutil
import signal
import threading
import time

import pytest

distributed = pytest.importorskip("dask.distributed")
FILES = ("sweep.parquet", "sweep.csv", "sweep.json", "sweep.html")
SWEEP = """name = "dask"
scene = "{scene}"
method = "latin-hypercube"
draws = 12
[[vary]]
key = "machine.X.max_acceleration_mm_s2"
range = [200, 4000]
"""


@pytest.fixture
def planned(tmp_path, root, program):
    """Plans the sweep of twelve jobs into a folder."""

    def plan(name: str) -> pathlib.Path:
        source = tmp_path / "source"
        source.mkdir(exist_ok=True)
        (source / "sweep.toml").write_text(SWEEP.format(scene=root / "tests" / "job" / "op10"))
        program("sweep", "plan", source, "--output", tmp_path / name, code=0)
        return tmp_path / name

    return plan


def cluster(workers: int):
    return distributed.LocalCluster(
        n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    )


def run(folder, workers: int):
    from proveout.dask import run_sweep

    with cluster(workers) as workers_here, distributed.Client(workers_here) as client:
        return run_sweep(folder, client)


def merged(folder: pathlib.Path) -> list[bytes]:
    return [(folder / name).read_bytes() for name in FILES]


def test_one_two_and_four_workers_give_the_same_bytes(planned):
    found = []
    for workers in (1, 2, 4):
        folder = planned(f"of-{workers}")
        report = run(folder, workers)
        assert (report.jobs, report.started, report.failed) == (12, 12, {})
        found.append(merged(folder))
    assert found[0] == found[1] == found[2]
    again = run(folder, 2)
    assert again.started == 0, "a second run starts no job"
    assert merged(folder) == found[0]


def test_a_run_in_shards_is_that_of_one_process(tmp_path, root, program):
    folders = {}
    for shards in (1, 3):
        (tmp_path / "sweep.toml").write_text(f'name = "split"\nscene = "{root}/tests/job/op10"\nshards = {shards}\n')
        folders[shards] = tmp_path / f"out{shards}"
        program("sweep", "plan", tmp_path, "--output", folders[shards], code=0)
        assert run(folders[shards], 2).failed == {}
    names = sorted(path.name for path in (folders[1] / "run").iterdir())
    assert "verdict.json" in names
    for name in names:
        if name != "run.json":
            assert (folders[1] / "run" / name).read_bytes() == (folders[3] / "run" / name).read_bytes(), name


def test_a_worker_that_is_killed_costs_no_more_than_its_job(planned):
    whole, killed = planned("whole"), planned("killed")
    run(whole, 1)
    from proveout.dask import run_sweep

    with cluster(2) as here, distributed.Client(here) as client:
        pids = list(client.run(os.getpid).values())
        victim = pids[0]

        def kill() -> None:
            while not any(killed.glob("jobs/*/result.json")):
                time.sleep(0.002)
            os.kill(victim, signal.SIGKILL)

        killer = threading.Thread(target=kill)
        killer.start()
        report = run_sweep(killed, client)
        killer.join()
    assert report.failed == {}
    assert merged(killed) == merged(whole)


def test_a_job_that_cannot_be_run_is_named_and_nothing_is_merged(planned):
    folder = planned("blocked")
    (folder / "jobs" / "00007" / "run").write_text("in the way")
    report = run(folder, 2)
    assert list(report.failed) == [7]
    assert "job 7" in report.failed[7]
    assert not (folder / "sweep.parquet").exists()
    assert len(list(folder.glob("jobs/*/result.json"))) == 11
    (folder / "jobs" / "00007" / "run").unlink()
    report = run(folder, 2)
    assert (report.started, report.failed) == (1, {})


def test_a_full_disk_on_one_worker_is_named(planned, tmp_path):
    """A worker whose files may not grow stands for one whose disk is full."""
    if shutil.which("sh") is None:
        pytest.skip("no shell")
    from proveout.dask import PROGRAM, pending, run_sweep

    folder = planned("full")
    # The shell of this program allows files of one block (512 bytes) for job 3 alone.
    script = tmp_path / "limited.sh"
    script.write_text('case " $* " in *" --job 3 "*) trap "" XFSZ; ulimit -f 1;; esac\nexec "$@"\n')
    with cluster(2) as here, distributed.Client(here) as client:
        report = run_sweep(folder, client, program=("sh", str(script), *PROGRAM), retries=0)
    assert list(report.failed) == [3], report.failed
    assert "job 3" in report.failed[3] and "too large" in report.failed[3], report.failed[3]
    assert pending(folder) == [3]

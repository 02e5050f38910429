"""Sweeps on Dask workers: one task per job, one process per task.

A sweep written by ``proveout sweep plan`` runs on any workers of a Dask client: threads and processes of this computer,
SSH, a batch system (dask-jobqueue), Kubernetes. Workers must reach the folder of the sweep and its inputs by the same
relative paths, and have the same version of this package.

If a worker dies, Dask gives its job to another worker. Jobs that have a result are not sent out. The merged result
depends only on the results of the jobs, not on the workers.

``python -m proveout.dask FOLDER --workers 4`` runs a sweep on workers of this computer, one process each.
"""

from __future__ import annotations

import argparse
import importlib
import json
import pathlib
import subprocess
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import os

__all__ = ["JobFailed", "SweepReport", "pending", "run_sweep"]

#: The program of this package, as a worker calls it.
PROGRAM = (sys.executable, "-c", "from proveout._program import main; main()")
#: Workers that may die under a job before the job is given up; Dask's own limit of 3 is low where machines are taken away.
ALLOWED_FAILURES = 10


class JobFailed(RuntimeError):
    """A job that could not be run; the message names the job and the host of the worker, and quotes the program's output."""


@dataclass(frozen=True)
class SweepReport:
    """Result of a call."""

    #: Jobs of the plan.
    jobs: int
    #: Jobs that were sent out; the others had their result.
    started: int
    #: Jobs without a result, with the reason.
    failed: dict[int, str] = field(default_factory=dict)


def _distributed() -> Any:
    """Dask's module, which is needed only here."""
    return importlib.import_module("dask.distributed")


def _plan(folder: pathlib.Path) -> list[str]:
    jobs = json.loads((folder / "plan.json").read_text(encoding="utf-8"))["jobs"]
    return [str(digest) for digest in jobs]


def pending(folder: str | os.PathLike[str]) -> list[int]:
    """Jobs of a plan that have no result under their digest."""
    place = pathlib.Path(folder)

    def has_result(job: int, digest: str) -> bool:
        try:
            text = (place / "jobs" / f"{job:05}" / "result.json").read_text(encoding="utf-8")
            return bool(json.loads(text).get("digest") == digest)
        except (OSError, ValueError):
            return False

    return [job for job, digest in enumerate(_plan(place)) if not has_result(job, digest)]


def _run_job(program: Sequence[str], folder: str, job: int, threads: int) -> int:
    import socket

    words = [*program, "sweep", "run", folder, "--job", str(job), "--threads", str(threads)]
    done = subprocess.run(words, capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL)
    if done.returncode != 0:
        said = done.stderr.strip()[-2000:]
        raise JobFailed(f"job {job} on {socket.gethostname()}: exit code {done.returncode}: {said}")
    return job


def run_sweep(
    folder: str | os.PathLike[str],
    client: Any,
    *,
    threads: int = 1,
    retries: int = 2,
    program: Iterable[str] = PROGRAM,
    merge: bool = True,
) -> SweepReport:
    """Runs the jobs of a sweep that have no result on the workers of a Dask client, and merges the results.

    ``threads``: threads of one job; with one thread per job, use as many workers as the computer has processors.
    ``retries``: further tries of a job that fails, on any worker.
    ``program``: how a worker starts Proveout.

    The report names jobs that failed; the others have their results. A sweep is merged only if all results exist.
    """
    distributed = _distributed()
    place = pathlib.Path(folder).resolve()
    digests = _plan(place)
    waiting = pending(place)
    client.run_on_scheduler(_allow_failures)
    tasks = {
        client.submit(
            _run_job, tuple(program), str(place), job, threads, key=f"proveout-{digests[job]}-{job}", retries=retries, pure=False
        ): job
        for job in waiting
    }
    failed: dict[int, str] = {}
    for task in distributed.as_completed(list(tasks)):
        if task.status != "finished":
            failed[tasks[task]] = str(task.exception()) if task.status == "error" else task.status
        task.release()
    if merge and not failed:
        done = subprocess.run([*program, "sweep", "merge", str(place)], capture_output=True, text=True, check=False)
        # Of a run in shards the exit code is that of its verdict: fail and unchecked are results.
        if done.returncode not in (0, 1, 3):
            raise JobFailed(done.stderr.strip())
    return SweepReport(jobs=len(digests), started=len(waiting), failed=dict(sorted(failed.items())))


def _allow_failures(dask_scheduler: Any) -> None:
    dask_scheduler.allowed_failures = max(dask_scheduler.allowed_failures, ALLOWED_FAILURES)


def main(words: Sequence[str] | None = None) -> int:
    """The command line; its exit code."""
    parser = argparse.ArgumentParser(prog="python -m proveout.dask", description="Runs a sweep on Dask workers.")
    parser.add_argument("folder", help="folder written by `proveout sweep plan`")
    parser.add_argument("--workers", type=int, default=None, help="workers on this computer (default: one per processor)")
    parser.add_argument("--scheduler", default=None, help="address of a Dask scheduler; use its workers instead")
    parser.add_argument("--threads", type=int, default=1, help="threads of one job (default: 1)")
    call = parser.parse_args(words)
    distributed = _distributed()
    if call.scheduler is not None:
        with distributed.Client(call.scheduler) as client:
            report = run_sweep(call.folder, client, threads=call.threads)
    else:
        cluster = distributed.LocalCluster(n_workers=call.workers, threads_per_worker=1, processes=True, dashboard_address=None)
        with cluster, distributed.Client(cluster) as client:
            report = run_sweep(call.folder, client, threads=call.threads)
    print(f"{report.jobs} jobs, {report.started} started, {len(report.failed)} without a result")
    for why in report.failed.values():
        print(why, file=sys.stderr)
    return 2 if report.failed else 0


if __name__ == "__main__":
    sys.exit(main())

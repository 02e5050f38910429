"""The templates of other engines: read as those engines read them, as far as that goes without them."""

from __future__ import annotations

import os
import pathlib
import shutil
import subprocess
import sys

import pytest


def test_the_shell_reads_the_slurm_script(root):
    script = root / "examples" / "sweep" / "slurm.sh"
    subprocess.run(["sh", "-n", script], check=True)
    lines = script.read_text().splitlines()
    options = [line.removeprefix("#SBATCH ") for line in lines if line.startswith("#SBATCH ")]
    assert all(option.startswith("--") for option in options)
    # Options behind the first command are none to Slurm.
    first = next(k for k, line in enumerate(lines) if line and not line.startswith("#"))
    assert max(k for k, line in enumerate(lines) if line.startswith("#SBATCH")) < first


def test_the_slurm_script_runs_its_part(root, tmp_path, program):
    program("sweep", "plan", root / "tests" / "sweep", "--output", tmp_path / "out", code=0)
    path = f"{pathlib.Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path, "SLURM_ARRAY_TASK_ID": "2", "SLURM_CPUS_PER_TASK": "1"}
    script = root / "examples" / "sweep" / "slurm.sh"
    subprocess.run(["sh", script, tmp_path / "out", "3"], check=True, env=environment, capture_output=True)
    done = sorted(p.parent.name for p in (tmp_path / "out").glob("jobs/*/result.json"))
    assert done == ["00001", "00004"]


def test_kubernetes_gets_an_indexed_job(root):
    yaml = pytest.importorskip("yaml")
    job = yaml.safe_load((root / "examples" / "sweep" / "kubernetes.yaml").read_text())
    assert (job["apiVersion"], job["kind"], job["spec"]["completionMode"]) == ("batch/v1", "Job", "Indexed")
    container = job["spec"]["template"]["spec"]["containers"][0]
    assert f"/{job['spec']['completions']} " in container["args"][0]
    mounts = {m["name"] for m in container["volumeMounts"]}
    assert mounts == {v["name"] for v in job["spec"]["template"]["spec"]["volumes"]}
    words = container["args"][0].replace("$((JOB_COMPLETION_INDEX + 1))", "1")
    subprocess.run(["sh", "-n", "-c", words], check=True)


def test_snakemake_runs_what_is_missing(root, tmp_path, program):
    folder = pathlib.Path(sys.executable).parent
    snakemake = shutil.which("snakemake", path=f"{folder}{os.pathsep}{os.environ['PATH']}")
    if snakemake is None:
        pytest.skip("snakemake is not installed")
    program("sweep", "plan", root / "tests" / "sweep", "--output", tmp_path / "out", code=0)
    call = [snakemake, "--snakefile", root / "examples" / "sweep" / "Snakefile", "--config", f"sweep={tmp_path / 'out'}", "--cores", "1"]
    environment = {**os.environ, "PATH": f"{folder}{os.pathsep}{os.environ['PATH']}"}
    subprocess.run(call, check=True, cwd=tmp_path, capture_output=True, env=environment)
    assert (tmp_path / "out" / "sweep.parquet").is_file()
    again = subprocess.run(call, check=True, cwd=tmp_path, capture_output=True, text=True, env=environment)
    assert "Nothing to be done" in again.stderr

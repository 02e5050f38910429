"""Tables and arrays: what they hold, and that handing them out copies nothing."""

from __future__ import annotations

import gc
import pathlib

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet
import pytest

import proveout as pv


def test_tables_are_those_of_the_files(cone_run):
    for name in ("signals", "blocks", "surface"):
        table = getattr(cone_run, name)
        read = pyarrow.parquet.read_table(cone_run.folder / f"{name}.parquet").combine_chunks()
        ours = pa.table(table)
        assert ours.column_names == read.column_names == table.column_names
        assert ours.equals(read), name
        assert len(table) == table.num_rows == read.num_rows > 10
        assert ours.schema.field("time_s" if name != "surface" else "x_mm").metadata[b"unit"] in (b"s", b"mm")


def test_pandas_takes_a_table(cone_run):
    frame = pd.DataFrame.from_arrow(cone_run.blocks)
    assert list(frame.columns) == cone_run.blocks.column_names
    assert frame["time_s"].sum() == pytest.approx(np.nansum(cone_run.blocks["time_s"]))
    assert (frame["time_s"] >= 0).all()


def test_columns_are_views_of_the_table(cone_run):
    signals = cone_run.signals
    time = signals["time_s"]
    assert not time.flags.writeable
    assert not time.flags.owndata
    assert np.shares_memory(time, signals["time_s"])
    with pytest.raises(ValueError, match="read-only"):
        time[0] = 1
    with pytest.raises(ValueError):
        time.flags.writeable = True
    assert (np.diff(time) >= 0).all()
    assert len(signals["kind"]) == len(time)
    assert set(signals["kind"]) <= {"rapid", "feed", "handling"}
    feed = signals["feed_programmed_mm_min"]
    assert np.isnan(feed).any(), "rapids have no programmed feed"
    with pytest.raises(KeyError, match='did you mean "time_s"'):
        signals["times_s"]


def test_two_exports_share_their_memory(cone_run):
    first, second = (pa.table(cone_run.signals)["time_s"].chunk(0) for _ in range(2))
    address = first.buffers()[1].address
    assert address == second.buffers()[1].address
    assert address == cone_run.signals["time_s"].__array_interface__["data"][0]


def resident_mib() -> float:
    pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 2**20


@pytest.mark.skipif(not pathlib.Path("/proc/self/statm").exists(), reason="the system does not tell the memory of a process")
def test_a_large_table_is_handed_out_without_memory(tmp_path):
    rows = 13_000_000
    file = tmp_path / "large.parquet"
    pyarrow.parquet.write_table(pa.table({"x_mm": np.zeros(rows)}), file, compression="none")
    table = pv._proveout.read_parquet(file)
    assert table["x_mm"].nbytes > 100e6
    gc.collect()
    before = resident_mib()
    held = [pa.table(table) for _ in range(5)] + [table["x_mm"] for _ in range(5)]
    assert resident_mib() - before < 5, f"{len(held)} tables"


def test_a_table_outlives_its_run(cone, tmp_path):
    run = cone.run("bc", resolution_mm=4, output=tmp_path / "run")
    vertices, _ = run.part.mesh()
    time, arrow = run.signals["time_s"], pa.table(run.signals)
    del run
    gc.collect()
    assert np.isfinite(vertices).all()
    assert arrow["time_s"].to_numpy().sum() == pytest.approx(time.sum())


def test_the_mesh_is_handed_out_without_a_copy(cone_run, face_run):
    part = cone_run.part
    for array in (*part.mesh(), part.normals, part.deviation):
        assert not array.flags.writeable
        assert not array.flags.owndata
        assert array.base is not None
        with pytest.raises(ValueError):
            array.flags.writeable = True
    assert np.shares_memory(part.mesh()[0], part.mesh()[0])
    assert np.shares_memory(part.mesh()[1], part.triangles)
    heights = face_run.height_maps["middle"].heights_mm
    assert not heights.flags.writeable
    assert np.shares_memory(heights, face_run.height_maps["middle"].heights_mm)


def test_a_file_that_is_no_table_is_refused(tmp_path):
    file = tmp_path / "x.parquet"
    file.write_bytes(b"PAR1 nothing PAR1")
    with pytest.raises(pv.InputError, match="cannot be read"):
        pv._proveout.read_parquet(file)

"""Series of steps, read again by pyarrow and mcap."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from fake_simulation import record

import stark


def test_parquet_has_a_column_a_series_with_its_unit(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="needs the extra 'export'")
    run = record(tmp_path / "run", 4)
    (file,) = stark.exports.export_recording(run, tmp_path / "out", "parquet")
    table = parquet.read_table(file)
    assert table.column_names == run.telemetry.names
    for name in table.column_names:
        assert np.array_equal(table[name].to_numpy(), run.telemetry[name], equal_nan=True)
    assert table.schema.field("time").metadata == {b"unit": b"s"}


def test_mcap_has_a_message_a_step_at_its_time(tmp_path: Path) -> None:
    reader = pytest.importorskip("mcap.reader", reason="needs the extra 'export'")
    run = record(tmp_path / "run", 4)
    (file,) = stark.exports.export_recording(run, tmp_path / "out", "mcap")
    with open(file, "rb") as stream:
        found = [(m.log_time, json.loads(m.data)) for _, _, m in reader.make_reader(stream).iter_messages()]
    times = run.telemetry["time"]
    assert [at for at, _ in found] == [round(1e9 * float(time)) for time in times]
    assert [row["newton_iterations"] for _, row in found] == list(run.telemetry["newton_iterations"])


def test_other_suffixes_are_refused(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 2)
    with pytest.raises(stark.InvalidArgument, match=r"must be \.parquet or \.mcap"):
        stark.exports.write_series(run.telemetry, tmp_path / "a.xls")

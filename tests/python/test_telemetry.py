"""Telemetry: columns, units, gaps, damaged lines, CSV."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from fake_simulation import record, report

from stark.telemetry import Telemetry, TelemetryError, TelemetryWriter


def test_telemetry_columns_units_and_gaps(tmp_path: Path) -> None:
    telemetry = record(tmp_path / "run", 10).telemetry
    assert len(telemetry) == 10
    assert np.allclose(telemetry["time"], np.arange(1, 11) / 30.0)
    assert np.isnan(telemetry["min_distance"][:4]).all()  # infinite: no contact
    assert np.isfinite(telemetry["min_distance"][-1])
    assert np.allclose(telemetry["energy.kinetic"], telemetry["time"] ** 2)
    assert telemetry.unit("energy.kinetic") == "J"
    assert telemetry.unit("phases.solve") == "s"
    with pytest.raises(KeyError, match="no series 'energi'"):
        telemetry["energi"]


def test_telemetry_is_a_dictionary_of_copies(tmp_path: Path) -> None:
    telemetry = record(tmp_path / "run", 10).telemetry
    table = dict(telemetry)
    assert list(table) == list(telemetry) == telemetry.names and "time" in telemetry and 0 not in telemetry
    time = telemetry["time"]
    time *= 1000.0
    assert np.array_equal(telemetry["time"], table["time"]) and table["time"][0] == pytest.approx(1.0 / 30.0)
    for wrong in (0, ["time", "step"], slice(3)):
        with pytest.raises(
            TelemetryError, match=r"must be the name of a series, such as telemetry\['time'\]"
        ):
            telemetry[wrong]  # type: ignore[index]


def test_all_series_are_read_in_one_pass_each() -> None:
    class Rows(list[dict[str, object]]):
        passes = 0

        def __iter__(self) -> Iterator[dict[str, object]]:
            self.passes += 1
            return super().__iter__()

    rows = Rows({"time": 0.1 * k, "energy": {"kinetic": k, "elastic": 1.0}} for k in range(5))
    telemetry = Telemetry(rows)
    assert len(dict(telemetry)) == 3 and rows.passes <= 4  # one for the names
    rows.append({"time": 0.5, "wall": 1.0})
    assert "wall" in telemetry and np.isnan(Telemetry(rows)["wall"][:5]).all()


def test_telemetry_lines_are_standard_json(tmp_path: Path) -> None:
    with TelemetryWriter(tmp_path / "t.jsonl") as writer:
        writer.write(report(0.1, residual=math.nan, message='a "quoted"\nline'))
        assert (tmp_path / "t.jsonl").read_text().endswith("\n")  # on disk before close()

    def refuse(name: str) -> float:
        raise AssertionError(name)

    row = json.loads((tmp_path / "t.jsonl").read_text(), parse_constant=refuse)
    assert row["residual"] is None
    assert row["message"] == 'a "quoted"\nline'


def test_rows_share_their_keys(tmp_path: Path) -> None:
    rows = record(tmp_path / "run", 3).telemetry.rows
    assert len(rows[0]) > 10 and "chain" not in rows[0]
    for first, second in ((rows[0], rows[2]), (rows[0]["energy"], rows[2]["energy"])):
        assert len({*map(id, first), *map(id, second)}) == len({*first, *second})


def test_damaged_telemetry(tmp_path: Path) -> None:
    path = tmp_path / "t.jsonl"
    path.write_text('{"time":1}\n{"time":2')
    with pytest.raises(TelemetryError, match="line 2 is cut off"):
        Telemetry.read(path)
    assert len(Telemetry.read(path, tolerate_cut_line=True)) == 1
    path.write_text('{"time":1}\nnonsense\n')
    with pytest.raises(TelemetryError, match="line 2 is not JSON"):
        Telemetry.read(path, tolerate_cut_line=True)


def test_csv_has_units(tmp_path: Path) -> None:
    telemetry = record(tmp_path / "run", 3).telemetry
    telemetry.to_csv(tmp_path / "t.csv")
    lines = (tmp_path / "t.csv").read_text().splitlines()
    assert "residual [N]" in lines[0] and len(lines) == 4
    assert len(lines[1].split(",")) == len(lines[0].split(","))
    numbers = [float(cell) for line in lines[1:] for cell in line.split(",") if cell]  # plain ones
    assert len(numbers) > 40


def test_units_in_names_of_the_user_are_theirs(tmp_path: Path) -> None:
    """A header says a unit once: that of the name, if it has one."""
    telemetry = Telemetry([{"time": 0.1, "measured": {"grip [N]": 5.0, "grip": 5.0, "rate [m/s]": 1.0}}])
    assert telemetry.unit("measured.grip [N]") == "N" and telemetry.unit("measured.rate [m/s]") == "m/s"
    telemetry.to_csv(tmp_path / "t.csv")
    header = (tmp_path / "t.csv").read_text().splitlines()[0]
    assert header == "time [s],measured.grip [N],measured.grip [SI],measured.rate [m/s]"

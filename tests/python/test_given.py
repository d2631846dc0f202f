"""What users give to be recorded: numbers, NaN where there is none, nothing else."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_simulation import FakeSimulation, report

import stark
from stark.cli import main
from stark.recording import Recorder, Recording
from stark.telemetry import Telemetry, TelemetryWriter
from stark.telemetry.given import given_number

BAD: list[Any] = [
    [1.0, 2.0],
    np.zeros(3),
    np.array([1.0]),
    "x",
    "1.5",
    b"1",
    None,
    1j,
    math.inf,
    -math.inf,
    10**400,
    {"a": 1.0},
    np.ma.masked,
]


@pytest.mark.parametrize("value", BAD, ids=repr)
def test_what_is_no_number_is_refused(tmp_path: Path, value: Any) -> None:
    with pytest.raises(ValueError, match=r"(?s).*"):
        given_number(value)
    sim = FakeSimulation()
    with Recorder(tmp_path / "run", sim) as recorder:
        recorder.record(sim)
        step = sim.step()
        with pytest.raises(stark.InvalidArgument, match=r"measured\['a'\] = .*: must be a finite number"):
            recorder.report(step, measured={"a": value})
        recorder.report(step, measured={"a": 1.0})  # nothing was written
    assert Recording(tmp_path / "run").telemetry["measured.a"].tolist() == [1.0]


def test_numbers_of_all_kinds_come_back_and_nan_is_no_value(tmp_path: Path) -> None:
    values = {"f": 0.1, "i": 3, "b": True, "n": np.float32(1.5), "z": np.array(2.0), "none": math.nan}
    with TelemetryWriter(tmp_path / "t.jsonl") as writer:
        writer.write(report(0.1), measured=values, wall=np.float64(0.5))
    read = Telemetry.read(tmp_path / "t.jsonl")
    assert [float(read[f"measured.{name}"][0]) for name in "fibnz"] == [0.1, 3.0, 1.0, 1.5, 2.0]
    assert math.isnan(read["measured.none"][0]) and read["wall"][0] == 0.5
    assert json.loads((tmp_path / "t.jsonl").read_text())["measured"]["none"] is None


@pytest.mark.parametrize("name", ["time", "step", "energy", "chain"])
def test_series_of_the_step_are_not_replaced(tmp_path: Path, name: str) -> None:
    with TelemetryWriter(tmp_path / "t.jsonl") as writer:
        with pytest.raises(stark.InvalidArgument, match=f"'{name}' is a series of the step itself"):
            writer.write(report(0.1), **{name: 1.0})
        assert writer.line_count == 0


SCENE = """
import math
import stark

until = 0.02
options = {"what": "measure", "value": 1.0}


def build():
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, name="box")
    return scene, {"time_step": 0.01}


def measure(sim):
    return {"x": options["value"] if options["what"] == "measure" else 0.0}


def observables(sim):
    return {"x": options["value"] if options["what"] == "observables" else 0.0}
"""


@pytest.mark.parametrize("function", ["measure", "observables"])
def test_runs_refuse_infinite_numbers_and_keep_nan(tmp_path: Path, capsys: Any, function: str) -> None:
    (tmp_path / "s.py").write_text(SCENE)
    given = ["--option", f"what={function}", "--out", str(tmp_path / "out"), "--quiet"]
    assert main(["run", str(tmp_path / "s.py"), "--option", "value=inf", *given]) == 2
    assert f"{function}() returned 'x' = inf; must be a finite number" in capsys.readouterr().err
    assert main(["run", str(tmp_path / "s.py"), "--option", "value=nan", *given]) == 0
    run = Recording(tmp_path / "out")
    found = run.manifest["summary"]["observables"]["x"], run.telemetry["measured.x"][-1]
    assert found[0] is None if function == "observables" else math.isnan(found[1])

"""Recordings that cannot be read, or end early."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _recorded_runs import edit_states, record, sheet_on_box

import stark
from stark.cli import main
from stark.verify import UnreadableRecording, verify


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sheet") / "run"
    return record(folder, sheet_on_box(), 6, time_step=0.01, contact_distance=0.001)


def _truncate(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def _edit_mesh(name: str, change: Callable[[Any], Any]) -> Callable[[Path], None]:
    def edit(run: Path) -> None:
        with np.load(run / "states/mesh.npz") as file:
            arrays = dict(file)
        np.savez(run / "states/mesh.npz", **{**arrays, name: change(arrays[name])})

    return edit


def _edit_json(name: str, change: Callable[[Any], None]) -> Callable[[Path], None]:
    def edit(run: Path) -> None:
        value = json.loads((run / name).read_text())
        change(value)
        (run / name).write_text(json.dumps(value))

    return edit


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda run: _truncate(run / "states/chunk_000000.npz"), "chunk_000000.npz' is damaged or cut off"),
        (lambda run: _truncate(run / "states/mesh.npz"), "mesh.npz' is damaged"),
        (lambda run: _truncate(run / "states/scene.json"), "scene.json' is damaged"),
        (lambda run: _truncate(run / "manifest.json"), "manifest.json' is damaged"),
        (lambda run: _truncate(run / "telemetry.jsonl"), "is cut off"),
        (lambda run: (run / "states/chunk_000000.npz").unlink(), "chunk_000000.npz' is missing"),
        (lambda run: (run / "frames/topology.npz").unlink(), "topology.npz' cannot be read"),
        (lambda run: (run / "telemetry.jsonl").unlink(), "telemetry.jsonl' cannot be read"),
        (_edit_json("manifest.json", lambda m: m["states"].update(count=9)), "its manifest says 9"),
        (_edit_json("manifest.json", lambda m: m["states"].update(count="x")), "states.count is not a count"),
        (_edit_mesh("triangles_0001", lambda a: a + 0.25), "topology of the type float64 and the shape"),
        (
            _edit_mesh("edges_0001", lambda a: np.zeros((1, 3), dtype=np.int32)),
            r"int32 and the shape \(1, 3\)",
        ),
        (_edit_mesh("masses_0001", lambda a: a[1:]), "masses of the wrong shape"),
        (_edit_json("manifest.json", lambda m: m.update(version=9)), "not the manifest of a Stark recording"),
        (_edit_json("manifest.json", lambda m: m.pop("settings")), "has no settings"),
        (_edit_json("states/scene.json", lambda s: s.update(version=9)), "has version 9, not 2"),
        (_edit_json("states/scene.json", lambda s: s.pop("joints")), "lacks or breaks an entry"),
        (_edit_json("states/scene.json", lambda s: s["bodies"].pop()), "a pair of bodies"),
        (_edit_json("states/scene.json", lambda s: s["bodies"][3].update(inertia=None)), "breaks an entry"),
        (
            _edit_json("states/scene.json", lambda s: s["attachments"].append({})),
            "breaks an entry",
        ),
        (_edit_json("manifest.json", lambda m: m["settings"].update(gravity="down")), "breaks an entry"),
        (
            _edit_json("states/scene.json", lambda s: s["bodies"][1].update(vertex_count=5)),
            "names a vertex that it does not have",
        ),
        (
            lambda run: edit_states(run, "times", lambda array, times: array.fill(np.inf)),
            "has no valid times",
        ),
    ],
)
def test_damaged_recordings(
    run: Path, damage: Callable[[Path], None], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    damage(run)
    with pytest.raises(UnreadableRecording, match=message):
        verify(run)
    assert main(["verify", str(run)]) == 2
    error = capsys.readouterr().err
    assert error.startswith("stark: ")
    assert error.count("\n") == 1
    assert not (run / "certificate.json").exists()


def test_a_folder_that_is_no_recording(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", str(tmp_path)]) == 2
    assert main(["verify", str(tmp_path / "nothing")]) == 2
    assert "no such folder" in capsys.readouterr().err


def test_an_interrupted_run_is_certified_up_to_its_end(tmp_path: Path) -> None:
    sim = stark.Simulation(sheet_on_box(), time_step=0.01, contact_distance=0.001)
    recorder = stark.recording.Recorder(
        tmp_path / "run", sim, settings=sim.settings.to_dict(), certify=True, chunk_frames=4
    )
    recorder.record_state(sim)
    for _ in range(6):
        recorder.report(sim.step())
        recorder.record_state(sim)
    # Killed here: three states are lost with their chunk, their lines of telemetry are not.
    certificate = verify(tmp_path / "run")
    assert certificate["steps"].status == "verified"
    assert "ended as 'running'" in certificate["steps"].detail
    assert certificate.recording["states"] == 4
    recorder.close("interrupted", "")
    assert verify(tmp_path / "run").verdict == "certified"


def test_an_old_certificate_goes_with_its_recording(run: Path) -> None:
    verify(run).write(run / "certificate.json")
    sim = stark.Simulation(sheet_on_box())
    stark.recording.Recorder(run, sim).close()
    assert not (run / "certificate.json").exists()
    assert not (run / "states").exists()


def test_a_recording_without_states_says_what_makes_them(tmp_path: Path) -> None:
    sim = stark.Simulation(sheet_on_box())
    with stark.recording.Recorder(tmp_path / "run", sim, certify=True) as recorder:
        recorder.record(sim)
    with pytest.raises(UnreadableRecording, match=r"has no states: call recorder\.record_state\(sim\)"):
        verify(tmp_path / "run")

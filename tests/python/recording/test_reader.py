"""Recordings as they are read: what was written comes back, damage is reported."""

from __future__ import annotations

import json
import math
import warnings
from pathlib import Path

import numpy as np
import pytest
from fake_simulation import FakeSimulation, record

from stark.errors import StarkWarning
from stark.recording import Recording, RecordingError


@pytest.mark.parametrize("steps", [0, 1, 31, 32, 70])
def test_frames_come_back_as_float32(tmp_path: Path, steps: int) -> None:
    run = record(tmp_path / "run", steps)
    assert len(run) == steps + 1
    assert run.status == "complete"
    sim = FakeSimulation()
    for index in range(len(run)):
        frame = run.frame(index)
        assert frame.time == sim.time
        for body, expected in zip(frame.bodies, sim.bodies, strict=True):
            assert np.array_equal(body.positions, expected.positions.astype(np.float32))
            assert np.array_equal(body.triangles, expected.triangles)
        sim.step()
    assert run.positions("cloth").shape == (steps + 1, 49, 3)
    assert np.array_equal(run.positions(0, -1), run.frame(-1).bodies[0].positions)


def test_frames_and_bodies_by_numbers_of_numpy(tmp_path: Path) -> None:
    """As argmax gives them: an AttributeError, and no body '0'."""
    run = record(tmp_path / "run", 5)
    last = run.times.argmax()
    assert np.array_equal(run.positions("cloth", last), run.positions("cloth", 5))
    assert np.array_equal(run.positions(np.int64(0), np.int32(-1)), run.positions(0, -1))
    assert run.frame(last).index == 5 and type(run.frame(last).index) is int
    for wrong in (0.5, "a", None, [0, 1]):
        with pytest.raises(RecordingError, match=r"frame = .*: must be a whole number or a slice"):
            run.positions("cloth", wrong)  # type: ignore[arg-type]
        with pytest.raises(RecordingError, match=r"frame = .*: must be a whole number"):
            run.frame(wrong)  # type: ignore[arg-type]


def test_what_is_read_is_not_changed_by_what_is_done_with_it(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 5)
    for read in (
        lambda: run.positions("cloth", 2),
        lambda: run.positions("floor", 2),  # stored once for all frames
        lambda: run.positions("cloth"),
        lambda: run.triangles("cloth"),
    ):
        before, given = read(), read()
        given += 1
        assert np.array_equal(read(), before)
    for shared in (run.times, run.frame(2).bodies[0].positions, run.frame(2).bodies[0].triangles):
        with pytest.raises(ValueError, match="read-only"):
            shared += 1


def test_telemetry_is_read_once_until_it_grows(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 5)
    assert run.telemetry is run.telemetry and len(run.telemetry) == 5
    file = tmp_path / "run/telemetry.jsonl"
    file.write_text(file.read_text() + file.read_text().splitlines()[-1] + "\n")
    assert len(run.telemetry) == 6
    file.unlink()
    with pytest.raises(RecordingError, match="cannot be read"):
        _ = run.telemetry


def test_bodies_keep_name_kind_motion_and_colour(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 1)
    assert [b.name for b in run.bodies] == ["cloth", "</script>box & 'Ω'", "floor"]
    assert [b.kind for b in run.bodies] == ["cloth", "rigid", "rigid"]
    assert [b.motion for b in run.bodies] == ["dynamic", "scripted", "fixed"]
    assert [b.color for b in run.bodies] == [(0.8, 0.3, 0.2), None, None]
    assert run.manifest["units"]["residual"] == "N"


def test_a_recording_says_what_it_is(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 3)
    assert repr(run).startswith(f"<stark.recording.Recording of {run.scene!r} in '{tmp_path}")
    assert repr(run).endswith("4 frames, until 0.1 s, complete>")


def test_nearest_frame(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 10)
    assert run.nearest(0.1) == 3
    assert run.nearest(-1.0) == 0
    assert run.nearest(math.inf) == 10


def _cut(path: Path, share: float) -> None:
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])


def _edit_manifest(folder: Path, **changes: object) -> None:
    path = folder / "manifest.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), **changes}))


def _flip_a_byte(path: Path) -> None:
    data = bytearray(path.read_bytes())
    data[len(data) // 3] ^= 0xFF
    path.write_bytes(bytes(data))


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda f: _cut(f / "frames/chunk_000000.npz", 0.6), "chunk_000000.npz' is damaged or cut off"),
        (lambda f: _cut(f / "frames/chunk_000001.npz", 0.0), "chunk_000001.npz' is damaged or cut off"),
        (lambda f: _flip_a_byte(f / "frames/chunk_000000.npz"), "chunk_000000.npz' is damaged or cut off"),
        (lambda f: (f / "frames/chunk_000001.npz").unlink(), "chunk_000001.npz' is missing"),
        (lambda f: _cut(f / "frames/topology.npz", 0.5), "topology.npz' is damaged or cut off"),
        (lambda f: (f / "manifest.json").unlink(), "is not a run folder"),
        (lambda f: _cut(f / "manifest.json", 0.5), "manifest.json' is damaged"),
        (lambda f: _edit_manifest(f, format="zip"), "not the manifest of a Stark recording"),
        (lambda f: _edit_manifest(f, version=99), "format version 99; this Stark reads 1"),
        (lambda f: _edit_manifest(f, frame_count=7), "its manifest says 7"),
        (lambda f: _edit_manifest(f, bodies=[{"name": "x"}]), "lacks or breaks an entry"),
        (
            lambda f: _edit_manifest(f, settings={"gravity": ["down", 0, 0]}),
            "gravity must be a list of three",
        ),
        (lambda f: _edit_manifest(f, settings={"gravity": [0, 0, None]}), "gravity must be a list of three"),
        (lambda f: _edit_manifest(f, bodies=[]), "manifest"),
    ],
)
def test_damage_is_reported(tmp_path: Path, damage, message: str) -> None:
    folder = tmp_path / "run"
    record(folder, 40)
    damage(folder)
    if message == "manifest":  # fewer bodies than arrays is harmless for reading, but there is nothing in it
        assert Recording(folder).bodies == []
        return
    with pytest.raises(RecordingError, match=message) as caught:
        Recording(folder)
    assert str(folder) in str(caught.value)


def test_unknown_bodies_and_frames(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 2)
    with pytest.raises(RecordingError, match="no body 'clot'; it has: cloth"):
        run.positions("clot")
    with pytest.raises(RecordingError, match="has 3 frames, no frame 3"):
        run.frame(3)


def test_a_still_says_where_the_recording_does_not_have_its_time(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 3)
    for time in (99.0, -1.0):
        with pytest.warns(StarkWarning, match=r"frames from 0 s to 0\.1 s, the nearest .* for (99|-1) s"):
            run.still(time, width=32, height=24)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for time in (0.0, 0.05, 0.1, math.inf):
            run.still(time, width=32, height=24)
    for call in (run.nearest, run.still):
        with pytest.raises(RecordingError, match=r"time = nan: must be a time \[s\]; it has frames from 0 s"):
            call(math.nan)

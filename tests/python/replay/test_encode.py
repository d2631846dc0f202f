"""The encoding of replay pages: errors within half a step of the grid, modes, sizes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from fake_simulation import FakeSimulation, record

from stark.recording import Recorder, Recording, RecordingError
from stark.replay import decode, encode
from stark.replay.encode import _decode_range, _encode_range


@pytest.mark.parametrize("steps", [0, 1, 2, 63, 64, 130])
def test_decoded_positions_are_within_half_a_grid_step(tmp_path: Path, steps: int) -> None:
    run = record(tmp_path / "run", steps)
    page = encode(run)
    for body, entry in enumerate(page.header["bodies"]):
        for frame in range(0, steps + 1, max(1, steps // 7)):
            error = np.abs(decode(page, body, frame) - run.positions(body, frame)).max()
            # 1e-7 m: float32 of coordinates below 2 m, once in the recording and once in a pose.
            half = max((0.5 * r["step"] for r in entry.get("ranges", [])), default=0.0) + 2.5e-7
            assert error <= half, (entry["name"], frame, error)


def test_modes_follow_the_motion(tmp_path: Path) -> None:
    page = encode(record(tmp_path / "run", 10))
    assert [entry["mode"] for entry in page.header["bodies"]] == ["mesh", "rigid", "fixed"]


def test_a_rigid_body_that_deforms_is_kept_as_a_mesh(tmp_path: Path) -> None:
    sim = FakeSimulation()
    with Recorder(tmp_path / "run", sim) as recorder:
        for k in range(3):
            sim.bodies[1].positions = sim.bodies[1].positions * (1.0 + 0.1 * k)
            recorder.record(sim, time=0.1 * k)
    page = encode(Recording(tmp_path / "run"))
    assert page.header["bodies"][1]["mode"] == "mesh"


def test_rotations_of_any_angle_survive(tmp_path: Path) -> None:
    """Half turns about every axis are where quaternions from matrices go wrong."""
    generator = np.random.default_rng(7)
    axes = [*np.eye(3), *generator.normal(size=(20, 3))]
    angles = [np.pi, np.pi, np.pi, *generator.uniform(-np.pi, np.pi, 20)]
    sim = FakeSimulation()
    rest = sim.bodies[1].positions.copy()
    with Recorder(tmp_path / "run", sim) as recorder:
        recorder.record(sim, time=0.0)
        for k, (axis, angle) in enumerate(zip(axes, angles, strict=True)):
            u = axis / np.linalg.norm(axis)
            cross = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
            turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
            sim.bodies[1].positions = rest @ turn.T + generator.uniform(-1, 1, 3)
            recorder.record(sim, time=k + 1.0)
    run = Recording(tmp_path / "run")
    page = encode(run)
    assert page.header["bodies"][1]["mode"] == "rigid"
    for frame in range(len(run)):
        assert np.abs(decode(page, 1, frame) - run.positions(1, frame)).max() < 5e-7


def test_random_motion_survives_the_modular_differences() -> None:
    """Jumps over the whole box make every difference wrap around."""
    positions = np.random.default_rng(3).uniform(-1.0, 1.0, (9, 17, 3))
    low, step, data = _encode_range(positions)
    q = _decode_range(data, 9, 17)
    assert np.abs(np.array(low) + step * q - positions).max() <= 0.5 * step * (1 + 1e-9)


def test_a_body_without_extent() -> None:
    low, step, data = _encode_range(np.full((3, 1, 3), 0.25))
    assert np.array_equal(np.array(low) + step * _decode_range(data, 3, 1), np.full((3, 1, 3), 0.25))


def test_smooth_motion_compresses(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 120, cells=32)
    raw = 121 * 33 * 33 * 12  # float32
    assert encode(run).size < 0.33 * raw


def test_stride_keeps_first_and_last_frame(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 10)
    page = encode(run, stride=4)
    assert page.header["times"] == pytest.approx([0.0, 4 / 30, 8 / 30, 10 / 30])
    assert np.abs(decode(page, 0, 3) - run.positions(0, 10)).max() < 1e-5
    assert encode(run, max_megabytes=0.002).header["stride"] > 1
    assert json.loads(json.dumps(encode(run, stride=np.int64(4)).header))["stride"] == 4
    with pytest.raises(RecordingError, match="frame stride = 0; must be at least 1"):
        encode(run, stride=0)

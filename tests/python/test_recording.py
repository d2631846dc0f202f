"""Recordings: what is written comes back, a killed run stays readable, damage is reported, exports are
exact."""

from __future__ import annotations

import base64
import json
import math
import os
import signal
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from fake_simulation import FakeSimulation, record, report

from stark.recording import Recorder, Recording, RecordingError, export
from stark.telemetry import Telemetry, TelemetryError, TelemetryWriter


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


def test_bodies_keep_name_kind_motion_and_colour(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 1)
    assert [b.name for b in run.bodies] == ["cloth", "</script>box & 'Ω'", "floor"]
    assert [b.kind for b in run.bodies] == ["cloth", "rigid", "rigid"]
    assert [b.motion for b in run.bodies] == ["dynamic", "scripted", "fixed"]
    assert [b.color for b in run.bodies] == [(0.8, 0.3, 0.2), None, None]
    assert run.manifest["units"]["residual"] == "N"


def test_still_bodies_are_stored_once_a_chunk(tmp_path: Path) -> None:
    record(tmp_path / "run", 20)
    with np.load(tmp_path / "run/frames/chunk_000000.npz") as chunk:
        assert chunk["positions_0000"].shape[0] == 21
        assert chunk["positions_0002"].shape[0] == 1


def test_nearest_frame(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 10)
    assert run.nearest(0.1) == 3
    assert run.nearest(-1.0) == 0
    assert run.nearest(math.inf) == 10


def test_a_recording_is_replaced_but_other_folders_are_refused(tmp_path: Path) -> None:
    record(tmp_path / "run", 40)
    assert len(record(tmp_path / "run", 3)) == 4
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/thesis.txt").write_text("precious")
    with pytest.raises(RecordingError, match="not empty and holds no recording; choose another"):
        record(tmp_path / "mine", 1)
    assert (tmp_path / "mine/thesis.txt").read_text() == "precious"
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match="is a file"):
        record(tmp_path / "file", 1)


_KILLED = """
import sys
sys.path.insert(0, {tests!r})
from fake_simulation import FakeSimulation
from stark.recording import Recorder
sim = FakeSimulation(20)
recorder = Recorder({folder!r}, sim, chunk_frames=8)
print("go", flush=True)
while True:
    recorder.record(sim)
    recorder.report(sim.step())
"""


def test_a_killed_run_is_readable(tmp_path: Path) -> None:
    folder = str(tmp_path / "run")
    code = _KILLED.format(tests=str(Path(__file__).parent), folder=folder)
    for wait in (0.05, 0.11, 0.23):
        process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE)
        assert process.stdout is not None
        process.stdout.readline()
        try:
            process.wait(wait)
        except subprocess.TimeoutExpired:
            os.kill(process.pid, signal.SIGKILL)
        process.wait()
        process.stdout.close()
        run = Recording(folder)
        assert run.status == "running"
        assert len(run) % 8 == 0
        assert len(run.telemetry) >= len(run) - 1
        for frame in run.frames():
            assert np.isfinite(frame.bodies[0].positions).all()


def test_an_exception_closes_the_recording_as_failed(tmp_path: Path) -> None:
    sim = FakeSimulation()
    with pytest.raises(ZeroDivisionError), Recorder(tmp_path / "run", sim) as recorder:
        recorder.record(sim)
        raise ZeroDivisionError("oh")
    run = Recording(tmp_path / "run")
    assert (run.status, len(run)) == ("failed", 1)
    assert "ZeroDivisionError: oh" in run.manifest["message"]


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


def test_telemetry_lines_are_standard_json(tmp_path: Path) -> None:
    with TelemetryWriter(tmp_path / "t.jsonl") as writer:
        writer.write(report(0.1, residual=math.nan, message='a "quoted"\nline'))
        assert (tmp_path / "t.jsonl").read_text().endswith("\n")  # on disk before close()

    def refuse(name: str) -> float:
        raise AssertionError(name)

    row = json.loads((tmp_path / "t.jsonl").read_text(), parse_constant=refuse)
    assert row["residual"] is None
    assert row["message"] == 'a "quoted"\nline'


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


def _read_ply(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    header, body = data.split(b"end_header\n", 1)
    counts = [int(line.split()[-1]) for line in header.decode().splitlines() if line.startswith("element")]
    points = np.frombuffer(body, dtype="<f4", count=3 * counts[0]).reshape(-1, 3)
    faces = np.frombuffer(
        body[12 * counts[0] :], dtype=[("n", "u1"), ("i", "<i4", 3), ("body", "<i4")], count=counts[1]
    )
    assert len(body) == 12 * counts[0] + 17 * counts[1]
    assert (faces["n"] == 3).all()
    return points, faces["i"]


def _read_obj(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    lines = [line.split() for line in data.decode().splitlines()]
    points = np.array([line[1:] for line in lines if line[0] == "v"], dtype=np.float32)
    return points, np.array([line[1:] for line in lines if line[0] == "f"], dtype=np.int32) - 1


def _read_vtu(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    piece = ElementTree.fromstring(data).find("UnstructuredGrid/Piece")
    assert piece is not None
    kinds = {"Float32": "<f4", "Int32": "<i4", "UInt8": "u1"}

    def array(name: str) -> np.ndarray:
        element = next(e for e in piece.iter("DataArray") if e.get("Name") == name)
        raw = base64.b64decode(element.text or "")
        assert np.frombuffer(raw[:4], dtype="<u4")[0] == len(raw) - 4
        return np.frombuffer(raw[4:], dtype=kinds[element.get("type", "")])

    assert (array("types") == 5).all()
    assert np.array_equal(array("offsets"), 3 * np.arange(1, int(piece.get("NumberOfCells", "0")) + 1))
    return array("Points").reshape(-1, 3), array("connectivity").reshape(-1, 3)


@pytest.mark.parametrize(("format", "read"), [("ply", _read_ply), ("obj", _read_obj), ("vtu", _read_vtu)])
def test_exports_hold_all_bodies_exactly(tmp_path: Path, format: str, read) -> None:
    run = record(tmp_path / "run", 4)
    files = export(run, tmp_path / "out", format)
    assert len(files) == (6 if format == "vtu" else 5)
    for index in (0, 4):
        points, triangles = read(files[index].read_bytes())
        frame = run.frame(index)
        assert np.array_equal(points, np.concatenate([b.positions for b in frame.bodies]))
        starts = np.cumsum([0] + [len(b.positions) for b in frame.bodies])
        expected = [b.triangles + s for b, s in zip(frame.bodies, starts[:-1], strict=True)]
        assert np.array_equal(triangles, np.concatenate(expected))


def test_pvd_lists_the_files_with_their_times(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 4)
    index = export(run, tmp_path / "out", "vtu", frames=[1, 3])[-1]
    sets = ElementTree.parse(index).getroot().findall("Collection/DataSet")
    assert [float(s.get("timestep", "nan")) for s in sets] == pytest.approx([1 / 30, 3 / 30])
    assert all((tmp_path / "out" / s.get("file", "")).is_file() for s in sets)


def test_unknown_export_format(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="format 'stl' is unknown; choose one of vtu, ply, obj"):
        export(record(tmp_path / "run", 1), tmp_path / "out", "stl")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"positions": np.zeros((4, 2))}, r"shape \(4, 2\); must be \(n, 3\)"),
        ({"triangles": np.array([[0, 1, 99]])}, "names vertex 99; it has 49"),
        ({"triangles": np.array([0, 1, 2])}, r"must be \(m, 3\)"),
    ],
)
def test_bodies_that_cannot_be_recorded(tmp_path: Path, change, message: str) -> None:
    sim = FakeSimulation()
    sim.bodies[0].__dict__.update(change)
    with pytest.raises(RecordingError, match=message):
        Recorder(tmp_path / "run", sim)

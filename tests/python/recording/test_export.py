"""Exports, read by parsers of their formats."""

from __future__ import annotations

import base64
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from fake_simulation import record

from stark.exports import export_recording
from stark.recording import RecordingError, export
from stark.replay import write_page


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


def test_the_path_of_a_recording_is_none(tmp_path: Path) -> None:
    """It was an AttributeError of Python, after the folder was made."""
    record(tmp_path / "run", 1)
    with pytest.raises(
        RecordingError, match=r"export: recording = .*: must be a stark\.recording\.Recording"
    ):
        export(tmp_path / "run", tmp_path / "out")  # type: ignore[arg-type]
    with pytest.raises(RecordingError, match=r"write_page: recording = .*: must be a stark\.recording"):
        write_page(tmp_path / "run")  # type: ignore[arg-type]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("format", ["ply", "obj", "vtu"])
def test_an_export_of_all_frames_removes_those_of_an_earlier_one(tmp_path: Path, format: str) -> None:
    """Frames 3 to 5 of the longer run were left, the end of the series to any program."""
    out = tmp_path / "out"
    longer = export(record(tmp_path / "long", 5), out, format)
    others = [out / f"fake_000009.{format}x", out / f"other_000009.{format}", out / f"fake_9.{format}"]
    for path in others:
        path.write_text("kept")
    stem = longer[0].name.rsplit("_", 1)[0]
    (out / f"{stem}_000010.{format}").symlink_to(others[0])
    (out / f"{stem}_000011.{format}").mkdir()
    run = record(tmp_path / "short", 2)
    export(run, out, format, frames=[0])
    assert all(path.exists() for path in longer)  # stills are added
    shorter = export(run, out, format)
    assert {path for path in longer if path.exists()} == set(shorter)
    assert all(path.read_text() == "kept" for path in [*others, out / f"{stem}_000010.{format}"])


@pytest.mark.parametrize("format", ["ply", "vtu"])
def test_frames_are_in_order_and_each_once(tmp_path: Path, format: str) -> None:
    run = record(tmp_path / "run", 4)
    for export_to in (export, export_recording):
        for frames, rule in (
            ([0, 0], "frame 0 comes after frame 0: frames must be in the order of time, each once"),
            ([-1, 4], "frame 4 comes after frame 4"),
            ([2, 1], "frame 1 comes after frame 2"),
            (3, "frames = 3: must be numbers of frames"),
            ("01", "frames = '01': must be numbers of frames"),
            ([None], "frame = None: must be a whole number"),
            ([9], "has 5 frames, no frame 9"),
        ):
            with pytest.raises(RecordingError, match=rule):
                export_to(run, tmp_path / "out", format, frames=frames)
    assert not (tmp_path / "out").exists()

"""VTU with fields, read by the XML parser of the standard library."""

from __future__ import annotations

import base64
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
from _falls import falling
from fake_simulation import record

import stark


def numbers(file: Path, name: str) -> np.ndarray:
    array = next(e for e in ElementTree.parse(file).iter("DataArray") if e.get("Name") == name)
    raw = base64.b64decode(array.text or "")[4:]
    assert array.get("type") == "Float32"
    return np.frombuffer(raw, dtype="<f4").reshape(-1, int(array.get("NumberOfComponents", "1"))).squeeze()


def test_fields_are_those_of_pictures(tmp_path: Path) -> None:
    sim = falling()
    sim.run_until(0.1)
    with stark.exports.Exporter(tmp_path / "fall.pvd", sim, fields=("stress", "speed")) as out:
        out.record(sim)
    index = ElementTree.parse(tmp_path / "fall.pvd").getroot().findall("Collection/DataSet")
    assert [e.get("file") for e in index] == ["fall_000000.vtu"]
    values = numbers(tmp_path / "fall_000000.vtu", "stress")
    expected = stark.render.field_values(sim, "stress")["soft/jelly"]
    surface = np.unique(sim["soft/jelly"].triangles)
    assert np.array_equal(values[np.isfinite(values)], expected[surface].astype(np.float32))
    speeds = numbers(tmp_path / "fall_000000.vtu", "speed")
    box = stark.render.field_values(sim, "speed")["box"].astype(np.float32)
    assert np.array_equal(speeds[-len(box) :], box)


def test_recordings_have_displacements(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 3)
    files = stark.exports.export_recording(run, tmp_path / "out", "vtu")
    assert [f.suffix for f in files] == [".vtu"] * 4 + [".pvd"]
    first, last = numbers(files[0], "Points"), numbers(files[3], "Points")
    np.testing.assert_allclose(numbers(files[3], "displacement"), last - first, atol=1e-7)


def test_frames_of_an_earlier_export_are_removed(tmp_path: Path) -> None:
    sim = falling()
    for count in (3, 2):
        with stark.exports.Exporter(tmp_path / "fall.pvd", sim) as out:
            for _ in range(count):
                sim.step()
                out.record(sim)
    assert sorted(path.name for path in tmp_path.glob("*.vtu")) == ["fall_000000.vtu", "fall_000001.vtu"]
    run = record(tmp_path / "run", 3)
    longer = stark.exports.export_recording(run, tmp_path / "out", "vtu")
    shorter = stark.exports.export_recording(record(tmp_path / "next", 1), tmp_path / "out", "vtu")
    assert {path for path in longer if path.exists()} == set(shorter)

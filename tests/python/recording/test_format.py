"""What writer and reader of recordings share: names of files, entries of bodies, what is drawn."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from fake_simulation import FakeSimulation, record

import stark
from stark.body_kinds import KINDS
from stark.recording import Recording, RecordingError
from stark.recording.format import (
    CHUNK_FRAMES,
    FORMAT_NAME,
    FORMAT_VERSION,
    MANIFEST,
    BodyEntry,
    chunk_path,
    drawn,
    surface,
)


def test_the_manifest_names_format_version_and_bodies(tmp_path: Path) -> None:
    folder = record(tmp_path / "run", 3).folder
    manifest = json.loads((folder / MANIFEST).read_text())
    assert (manifest["format"], manifest["version"]) == (FORMAT_NAME, FORMAT_VERSION)
    bodies = [
        BodyEntry(**{**entry, "color": entry["color"] and tuple(entry["color"])})
        for entry in manifest["bodies"]
    ]
    assert bodies == list(Recording(folder).bodies)
    assert {body.kind for body in bodies} <= set(KINDS)


@pytest.mark.parametrize(
    ("key", "value", "said"), [("format", "other", FORMAT_NAME), ("version", 9, "format version 9")]
)
def test_recordings_of_another_format_or_version_are_refused(
    tmp_path: Path, key: str, value: object, said: str
) -> None:
    folder = record(tmp_path / "run", 3).folder
    manifest = json.loads((folder / MANIFEST).read_text())
    (folder / MANIFEST).write_text(json.dumps(manifest | {key: value}))
    with pytest.raises(RecordingError, match=said):
        Recording(folder)


def test_frames_are_in_chunks_of_their_number(tmp_path: Path) -> None:
    folder = record(tmp_path / "run", CHUNK_FRAMES).folder
    assert [path.name for path in sorted((folder / "frames").glob("chunk_*"))] == [
        Path(chunk_path(k)).name for k in (0, 1)
    ]
    assert len(Recording(folder)) == CHUNK_FRAMES + 1


def test_a_solid_is_drawn_without_its_inner_vertices() -> None:
    solid = stark.Scene().add_solid(stark.mesh.tet_box(1.0, 3))
    positions, triangles = surface(solid)
    assert len(positions) == 4**3 - 2**3 and triangles.max() == len(positions) - 1
    volume = (
        np.einsum(
            "ni,ni->", positions[triangles[:, 0]], np.cross(*positions[triangles[:, 1:]].swapaxes(0, 1))
        )
        / 6
    )
    assert volume == pytest.approx(1.0, rel=1e-12)
    cloth = stark.Scene().add_cloth(stark.mesh.grid(1, 1, 2))
    assert all(
        np.array_equal(*both) for both in zip(surface(cloth), (cloth.positions, cloth.triangles), strict=True)
    )


def test_layers_are_drawn_when_they_are_to_be_seen() -> None:
    seen, unseen = SimpleNamespace(_is_drawn=lambda: True), SimpleNamespace(_is_drawn=lambda: False)
    body = object()
    assert drawn(SimpleNamespace(bodies=[body], layers=[seen, unseen])) == [body, seen]
    assert len(drawn(FakeSimulation())) == len(FakeSimulation().bodies)


def test_errors_of_recordings_are_bad_input() -> None:
    assert issubclass(RecordingError, stark.InvalidArgument) and issubclass(RecordingError, ValueError)

"""Formats by name and by suffix; the command."""

from __future__ import annotations

from pathlib import Path

import pytest
from _falls import falling
from fake_simulation import record

import stark
from stark.cli import main
from stark.exports.exporter import FORMATS, Exporter

NEEDS = {"usd": "pxr", "vtkhdf": "h5py", "glb": "trimesh", "parquet": "pyarrow", "mcap": "mcap"}


@pytest.mark.parametrize("format", FORMATS)
def test_the_command_writes_every_format(tmp_path: Path, format: str) -> None:
    if format in NEEDS:
        pytest.importorskip(NEEDS[format], reason="needs the extra 'export'")
    record(tmp_path / "run", 2)
    assert main(["export", str(tmp_path / "run"), "--format", format]) == 0
    files = sorted((tmp_path / "run" / format).iterdir())
    assert files and all(not file.name.startswith(".") and file.stat().st_size > 50 for file in files)
    before = [file.name for file in files]
    assert main(["export", str(tmp_path / "run"), "--format", format]) == 0, "written anew"
    assert [file.name for file in sorted((tmp_path / "run" / format).iterdir())] == before


def test_a_folder_in_the_place_of_the_file_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("pxr", reason="needs the extra 'usd'")
    (tmp_path / "fall.usd").mkdir()
    with pytest.raises(stark.Error, match="it is a folder, not a file"):
        Exporter(tmp_path / "fall.usd", falling())


def test_nothing_recorded_is_an_error(tmp_path: Path) -> None:
    export = Exporter(tmp_path / "fall.pvd", falling())
    with pytest.raises(stark.InvalidArgument, match=r"nothing was recorded: call record\(sim\)"):
        export.close()
    assert list(tmp_path.iterdir()) == []


def test_unknown_formats_name_the_known_ones(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 2)
    with pytest.raises(stark.recording.RecordingError, match="choose one of vtu, ply, obj, vtkhdf, usd"):
        stark.exports.export_recording(run, tmp_path / "out", "stl")
    with pytest.raises(stark.recording.RecordingError, match="mcap; the folder comes first"):
        stark.exports.export_recording(run, "vtu", "out")

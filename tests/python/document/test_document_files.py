"""Files of documents: what leads out of the folder is not opened, what never ends is not waited for."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

import stark
from stark.document import DocumentError
from stark.document.files import inside


@pytest.fixture
def path(tmp_path: Path) -> Path:
    folder = tmp_path / "here"
    folder.mkdir()
    scene = stark.Scene()
    scene.add_sphere(0.1, mass=1.0)
    return scene.save(folder / "scene.json")


def point_to(path: Path, file: str, sha256: str | None = None) -> None:
    given = json.loads(path.read_text())
    path.write_text(json.dumps({**given, "arrays": {"file": file, "sha256": sha256}}))


@pytest.mark.parametrize(
    "name",
    ["../outside.npz", "/etc/hostname", "sub/../../outside.npz", "C:\\x.npz", "a\\b", "a\0b", "", ".."],
)
def test_names_that_lead_out_are_refused(path: Path, name: str) -> None:
    (path.parent.parent / "outside.npz").write_bytes((path.parent / "scene.npz").read_bytes())
    point_to(path, name)
    with pytest.raises(DocumentError, match="must be a name in the folder of the document"):
        stark.load_scene(path)


def test_links_that_lead_out_are_refused(path: Path, tmp_path: Path) -> None:
    (path.parent / "scene.npz").rename(tmp_path / "outside.npz")
    (path.parent / "link.npz").symlink_to(tmp_path / "outside.npz")
    (path.parent / "way").symlink_to(tmp_path)
    for name in ("link.npz", "way/outside.npz"):
        point_to(path, name)
        with pytest.raises(DocumentError, match="link that leads out"):
            stark.load_scene(path)


def test_folders_below_and_links_that_stay_are_taken(path: Path) -> None:
    (path.parent / "arrays").mkdir()
    (path.parent / "scene.npz").rename(path.parent / "arrays" / "a.npz")
    (path.parent / "link.npz").symlink_to("arrays/a.npz")
    for name in ("arrays/a.npz", "link.npz"):
        point_to(path, name)
        assert len(stark.load_scene(path)) == 1
    assert inside(path.parent, "link.npz", "x").name == "a.npz"


def test_pipes_and_folders_are_refused(path: Path) -> None:
    os.mkfifo(path.parent / "pipe")
    point_to(path, "pipe")
    with pytest.raises(DocumentError, match="device, pipe or socket"):
        stark.load_scene(path)
    with pytest.raises(DocumentError, match="device, pipe or socket"):
        stark.load_scene(path.parent / "pipe")
    with pytest.raises(DocumentError, match="folder"):
        stark.load_scene(path.parent)
    with pytest.raises(DocumentError, match="no such file"):
        stark.load_scene(path.parent / "none.json")


def test_arrays_of_another_document_are_refused(path: Path) -> None:
    scene = stark.Scene()
    scene.add_sphere(0.2, mass=1.0)
    scene.save(path.parent / "other.json")
    (path.parent / "other.npz").rename(path.parent / "scene.npz")
    with pytest.raises(DocumentError, match="not what the document was written with"):
        stark.load_scene(path)
    (path.parent / "scene.npz").unlink()
    with pytest.raises(DocumentError, match=r"'scene\.npz' is missing"):
        stark.load_scene(path)

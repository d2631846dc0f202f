"""Named parts of mesh files: readers by suffix, files that cannot be read."""

from __future__ import annotations

from pathlib import Path

import pytest

import stark
from stark import mesh


def test_the_suffix_chooses_the_reader(tmp_path: Path) -> None:
    triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\no hem\nf 1 2 3\n"
    for name in ("a.obj", "b.OBJ"):
        (tmp_path / name).write_text(triangle)
        (hem,) = mesh.load_groups(tmp_path / name).values()
        assert isinstance(hem, mesh.MeshGroup) and hem.elements.tolist() == [0]


def test_damaged_obj_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(stark.InvalidMesh, match=r"none\.obj': No such file"):
        mesh.load_groups(tmp_path / "none.obj")
    for text, message in (
        ("v 0 0 0\nf 1 2 x\n", "line 2: invalid literal"),
        ("v 0 0 0\nf 1 2\n", "line 2: a face needs three vertices"),
    ):
        (tmp_path / "bad.obj").write_text(text)
        with pytest.raises(stark.InvalidMesh, match=message):
            mesh.load_groups(tmp_path / "bad.obj")

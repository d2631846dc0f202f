"""Named parts of OBJ files: pieces of a garment, their materials."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stark import mesh

GARMENT = """# two panels; the back has a vertex twice, for its normals
o front
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
g panels left
usemtl cotton twill
f 1 2 3 4
o back
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
v 1 1 1
g panels
f -5/1 -4/2 -3/3
usemtl lace
f -5 -1 -2
f -1 -3 -2
"""


def test_objects_groups_and_materials_are_groups(tmp_path: Path) -> None:
    file = tmp_path / "garment.obj"
    file.write_text(GARMENT)
    garment, groups = mesh.load(file), mesh.load_groups(file)
    assert len(garment.vertices) == 8 and len(garment.triangles) == 4  # one collapsed
    triangles = {name: group.elements.tolist() for name, group in groups.items()}
    assert triangles == {
        "front": [0, 1], "back": [2, 3], "panels": [0, 1, 2, 3], "left": [0, 1],
        "cotton twill": [0, 1, 2], "lace": [3],
    }  # fmt: skip
    for group in groups.values():
        assert group.vertices.tolist() == np.unique(garment.triangles[group.elements]).tolist()
    assert np.ptp(garment.vertices[groups["back"].vertices, 2]) == 0.0
    front = mesh.compact(mesh.TriangleMesh(garment.vertices, garment.triangles[groups["front"].elements]))
    assert len(front.vertices) == 4 and front.area == pytest.approx(1.0)


def test_a_file_without_doubles_is_numbered_as_written(tmp_path: Path) -> None:
    ball = mesh.sphere(0.1, 2)
    ball.save(tmp_path / "ball.obj")
    assert mesh.load_groups(tmp_path / "ball.obj") == {}
    text = (tmp_path / "ball.obj").read_text().replace("\nf ", "\no upper\nf ", 1)
    (tmp_path / "ball.obj").write_text(text)
    groups = mesh.load_groups(tmp_path / "ball.obj")
    assert groups["upper"].elements.tolist() == list(range(len(ball.triangles)))
    assert groups["upper"].vertices.tolist() == list(range(len(ball.vertices)))

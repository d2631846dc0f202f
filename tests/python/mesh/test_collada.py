"""Collada files: polygons become triangles that cover them, with the corners of the file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stark import InvalidMesh, mesh
from stark.mesh.collada import with_triangles

ANGLE = [(0.1, 0.0), (0.1, 0.02), (0.02, 0.02), (0.02, 0.1), (0.0, 0.1), (0.0, 0.0)]
HEAD = (
    '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="1"/>'
    "</asset><library_geometries><geometry id='g'><mesh><source id='places'>"
    "<float_array id='a' count='{}'>{}</float_array>"
    "<technique_common><accessor source='#a' count='{}' stride='3'><param name='X' type='float'/>"
    "<param name='Y' type='float'/><param name='Z' type='float'/></accessor></technique_common></source>"
    "<vertices id='v'><input semantic='POSITION' source='#places'/></vertices>"
)
TAIL = (
    "</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id='s'><node>"
    "<instance_geometry url='#g'/></node></visual_scene></library_visual_scenes><scene>"
    "<instance_visual_scene url='#s'/></scene></COLLADA>"
)


def column(kind: str, outline: list[tuple[float, float]]) -> str:
    """A column of height 0.02 m; each corner has two numbers, the second for nothing."""
    n = len(outline)
    vertices = [(x, y, z) for z in (0.0, 0.02) for x, y in outline]
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    faces = [list(range(n))[::-1], list(range(n, 2 * n)), *sides]
    numbers = " ".join(f"{x}" for row in vertices for x in row)
    rows = [" ".join(f"{i} {i}" for i in face) for face in faces]
    inputs = "<input semantic='VERTEX' source='#v' offset='0'/>"
    inputs += "<input semantic='COLOR' source='#places' offset='1'/>"
    more = f"count='{len(faces)}'>{inputs}"
    if kind == "polylist":
        counts = " ".join(str(len(face)) for face in faces)
        body = f"<polylist {more}<vcount>{counts}</vcount><p>{' '.join(rows)}</p></polylist>"
    else:
        body = f"<polygons {more}{''.join(f'<p>{row}</p>' for row in rows)}</polygons>"
    return HEAD.format(6 * n, numbers, 2 * n) + body + TAIL


@pytest.mark.parametrize("kind", ["polylist", "polygons"])
def test_polygons_are_covered(kind: str, tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    pytest.importorskip("collada")
    (tmp_path / "angle.dae").write_text(column(kind, ANGLE))
    found = mesh.load(tmp_path / "angle.dae")
    assert isinstance(found, mesh.TriangleMesh) and found.is_closed
    assert found.volume == pytest.approx(0.0036 * 0.02, rel=1e-6)
    assert found.area == pytest.approx(2 * 0.0036 + 0.4 * 0.02, rel=1e-6)


def test_convex_polygons_keep_the_triangles_of_pycollada(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("collada")
    angles = np.linspace(0.0, 2.0 * np.pi, 7, endpoint=False)
    (tmp_path / "a.dae").write_text(
        column("polylist", list(zip(np.cos(angles), np.sin(angles), strict=True)))
    )
    found, theirs = mesh.load(tmp_path / "a.dae"), trimesh.load(tmp_path / "a.dae", force="mesh")
    assert isinstance(found, mesh.TriangleMesh)
    assert np.array_equal(found.vertices[found.triangles], np.asarray(theirs.vertices)[theirs.faces])


@pytest.mark.parametrize(
    "text",
    ["", "<COLLADA", "<a><mesh><polylist/></mesh></a>", column("polylist", ANGLE).replace("#places", "#no")],
)
def test_other_files_stay_as_they_are(text: str) -> None:
    assert with_triangles(text.encode(), Path("a.dae")) == text.encode()


@pytest.mark.parametrize("stray", [-1, 4])
@pytest.mark.parametrize("kind", ["triangles", "polygons"])
def test_vertices_that_are_not_there(stray: int, kind: str, tmp_path: Path) -> None:
    """Neither the last vertex nor a mesh that is left out."""
    pytest.importorskip("trimesh")
    pytest.importorskip("collada")
    faces = f"<{kind} count='2'><input semantic='VERTEX' source='#v' offset='0'/>"
    corners = ["0 1 2", f"1 3 {stray}"]
    rows = f"<p>{' '.join(corners)}</p>" if kind == "triangles" else "".join(f"<p>{c}</p>" for c in corners)
    numbers = "0 0 0 1 0 0 0 1 0 1 1 0"
    (tmp_path / "a.dae").write_text(HEAD.format(12, numbers, 4) + faces + rows + f"</{kind}>" + TAIL)
    with pytest.raises(InvalidMesh, match=rf"a face has vertex {stray}: must be in \[0, 4\)"):
        mesh.load(tmp_path / "a.dae")

"""Files with coordinates that are no numbers, or too large for one: refused by their line or number."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from stark import InvalidMesh, mesh

SOLID = "solid a\nfacet normal 0 0 1\nouter loop\n{}\nendloop\nendfacet\nendsolid a\n"
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\nnan 1 0\n3 0 1 2\n"
)
MSH = (
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 {}\n5 nan 0 0\n"
    "$EndNodes\n$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n"
)
VTU = (
    '<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">'
    '<UnstructuredGrid><Piece NumberOfPoints="4" NumberOfCells="1"><Points><DataArray type="Float64" '
    'NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 inf 1</DataArray></Points><Cells>'
    '<DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 3</DataArray>'
    '<DataArray type="Int32" Name="offsets" format="ascii">4</DataArray>'
    '<DataArray type="UInt8" Name="types" format="ascii">10</DataArray></Cells></Piece></UnstructuredGrid>'
    "</VTKFile>"
)


def refusal(file: Path, content: str | bytes) -> str:
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InvalidMesh) as refused:
        mesh.load(file)
    assert str(refused.value).count(str(file)) == 1 and "must be finite" in str(refused.value)
    return str(refused.value)


def test_text_names_the_line(tmp_path: Path) -> None:
    corners = "vertex 0 0 0\nvertex 1 0 0\nvertex nan 1 0"
    assert "line 3: 'v 0 1e400 0'" in refusal(tmp_path / "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1e400 0\nf 1 2 3\n")
    assert "line 6: 'vertex nan 1 0'" in refusal(tmp_path / "a.stl", SOLID.format(corners))


def test_other_files_name_the_vertex(tmp_path: Path) -> None:
    corners = (0, 0, 0, 1, 0, 0, float("nan"), 1, 0)
    binary = b"\0" * 80 + struct.pack("<I12fH", 1, 0, 0, 1, *corners, 0)
    assert "corner 2 (from 0) is at (nan, 1, 0)" in refusal(tmp_path / "b.stl", binary)
    assert "vertex 2 (from 0) is at (nan, 1, 0)" in refusal(tmp_path / "a.ply", PLY)


def test_volumes_name_the_point(tmp_path: Path) -> None:
    pytest.importorskip("meshio")
    assert "point 3 (from 0) is at (0, 0, nan)" in refusal(tmp_path / "a.msh", MSH.format("nan"))
    assert "point 3 (from 0) is at (0, inf, 1)" in refusal(tmp_path / "a.vtu", VTU)


def test_no_vertex_of_a_surface_is_dropped(tmp_path: Path) -> None:
    """trimesh would go on without the vertex and its triangle."""
    pytest.importorskip("trimesh")
    off = "OFF\n4 2 0\n0 0 0\n1 0 {}\n0 1 0\n1 1 0\n3 0 1 2\n3 0 2 3\n"
    assert "vertex 1 (from 0) is at (1, 0, nan)" in refusal(tmp_path / "a.off", off.format("nan"))
    assert "vertex 1 (from 0) is at (1, 0, inf)" in refusal(tmp_path / "b.off", off.format("inf"))


def test_points_of_no_cell_may_be_anything(tmp_path: Path) -> None:
    pytest.importorskip("meshio")
    file = tmp_path / "a.msh"
    file.write_text(MSH.format("1"))
    assert len(mesh.load(file).vertices) == 4

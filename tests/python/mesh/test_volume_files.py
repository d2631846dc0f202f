"""Files of finite element programs: groups by name, cells of several types, vertices that no cell uses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import InvalidMesh, mesh

GMSH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
3
2 1 "inlet"
3 1 "steel"
3 2 "lead"
$EndPhysicalNames
$Nodes
7
1 9 9 9
2 0 0 0
3 1 0 0
4 0 1 0
5 0 0 1
6 1 1 1
7 0 0 -1
$EndNodes
$Elements
6
1 15 2 0 1 1
2 2 2 1 1 2 3 4
3 2 2 4 2 3 4 6
4 4 2 1 1 2 3 4 5
5 4 2 2 2 3 4 5 6
6 4 2 1 3 2 3 4 7
$EndElements
"""


@pytest.fixture
def gmsh(tmp_path: Path) -> Path:
    pytest.importorskip("meshio")
    path = tmp_path / "part.msh"
    path.write_text(GMSH)
    return path


def test_physical_groups_of_gmsh(gmsh: Path) -> None:
    """Written by hand: three tetrahedra, the second and the third turned inside out, an unused point, a
    boundary with a name and one without."""
    part = mesh.load(gmsh)
    assert isinstance(part, mesh.TetMesh)
    assert len(part.vertices) == 6 and (part.volumes > 0.0).all()
    groups = mesh.load_groups(gmsh)
    assert set(groups) == {"inlet", "steel", "lead", "4"}
    assert groups["inlet"].vertices.tolist() == [0, 1, 2] and groups["inlet"].elements.tolist() == []
    assert groups["4"].vertices.tolist() == [1, 2, 4]
    assert groups["steel"].elements.tolist() == [0, 2] and groups["lead"].elements.tolist() == [1]
    assert groups["steel"].vertices.tolist() == [0, 1, 2, 3, 5]
    np.testing.assert_array_equal(part.vertices[groups["4"].vertices], [(1, 0, 0), (0, 1, 0), (1, 1, 1)])
    modulus = np.full(3, 1e6)
    modulus[groups["lead"].elements] = 1e5
    scene = stark.Scene()
    body = scene.add_solid(
        part,
        stark.SolidMaterial(density=1000.0, youngs_modulus=modulus, poissons_ratio=0.3),
        pins=groups["inlet"].vertices,
    )
    assert not stark.Simulation(scene).step().failed
    assert len(body.pins) == 3


def test_cells_of_two_physical_groups_are_there_once(gmsh: Path) -> None:
    """MSH 2 has them once for each group: their mass and stiffness counted twice."""
    gmsh.write_text(
        GMSH.replace("$Elements\n6\n", "$Elements\n8\n").replace(
            "6 4 2 1 3 2 3 4 7", "6 4 2 1 3 2 3 4 7\n7 4 2 2 3 2 3 4 7\n8 2 2 7 1 2 3 4"
        )
    )
    part, groups = mesh.load(gmsh), mesh.load_groups(gmsh)
    assert isinstance(part, mesh.TetMesh) and len(part.tets) == 3
    assert groups["steel"].elements.tolist() == [0, 2] and groups["lead"].elements.tolist() == [1, 2]
    sides = "$Elements\n3\n2 2 2 1 1 2 3 4\n3 2 2 4 2 3 4 6\n8 2 2 7 1 2 3 4\n$EndElements\n"
    gmsh.write_text(GMSH[: GMSH.index("$Elements")] + sides)
    surface, groups = mesh.load(gmsh), mesh.load_groups(gmsh)
    assert isinstance(surface, mesh.TriangleMesh) and len(surface.triangles) == 2
    assert groups["inlet"].elements.tolist() == groups["7"].elements.tolist() == [0]


def test_sets_of_other_programs(tmp_path: Path) -> None:
    """Abaqus: sets of nodes and of elements."""
    meshio = pytest.importorskip("meshio")
    box = mesh.tet_box(0.1, 2)
    bottom, few = np.flatnonzero(box.vertices[:, 2] < -0.049), np.array([3, 5, 8])
    written = meshio.Mesh(
        box.vertices, [("tetra", box.tets)], point_sets={"bottom": bottom}, cell_sets={"few": [few]}
    )
    meshio.write(tmp_path / "box.inp", written)
    groups = mesh.load_groups(tmp_path / "box.inp")
    assert {name.lower() for name in groups} == {"bottom", "few"}
    by_name = {name.lower(): group for name, group in groups.items()}
    assert np.array_equal(by_name["bottom"].vertices, bottom)
    assert np.array_equal(by_name["few"].elements, few)
    assert np.array_equal(by_name["few"].vertices, np.unique(box.tets[few]))


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        ([("hexahedron", [range(8)]), ("wedge", [(1, 8, 2, 5, 9, 6)])], "must have cells of one type"),
        ([("tetra", [(0, 1, 2, 5)]), ("hexahedron", [range(8)])], "must have cells of one type"),
        ([("wedge", [(1, 8, 2, 5, 9, 6)])], "cells of type wedge: must have cells of type hexahedron27"),
        ([("triangle", [(0, 1, 2)]), ("triangle6", [range(6)])], "cells of type triangle, triangle6: must"),
    ],
)
def test_no_cell_is_left_out(cells: Any, message: str, tmp_path: Path) -> None:
    """A hexahedron beside a wedge came without the wedge, and nothing said so."""
    meshio = pytest.importorskip("meshio")
    points = np.vstack([mesh.box_hexahedra(1.0, 1).vertices, [(1.0, 0.0, -0.5), (1.0, 0.0, 0.5)]])
    meshio.write(
        tmp_path / "mixed.vtu", meshio.Mesh(points, [(k, np.array([*map(list, c)])) for k, c in cells])
    )
    for read in (mesh.load, mesh.load_groups):
        with pytest.raises(InvalidMesh, match=message):
            read(tmp_path / "mixed.vtu")


def test_quadrangles_of_a_surface_become_triangles(tmp_path: Path) -> None:
    """Those beside triangles were left out: holes. Groups count the triangles of both."""
    meshio = pytest.importorskip("meshio")
    points = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0.5, 0), (7, 7, 7)], dtype=float)
    written = meshio.Mesh(
        points,
        [("triangle", np.array([(1, 4, 2)])), ("quad", np.array([(0, 1, 2, 3)]))],
        cell_data={"gmsh:physical": [np.array([5]), np.array([6])], "gmsh:geometrical": [np.array([1])] * 2},
    )
    meshio.write(tmp_path / "sheet.msh", written, "gmsh22", binary=False)
    sheet = mesh.load(tmp_path / "sheet.msh")
    assert isinstance(sheet, mesh.TriangleMesh)
    assert len(sheet.vertices) == 5 and sheet.area == pytest.approx(1.5)
    groups = mesh.load_groups(tmp_path / "sheet.msh")
    assert groups["5"].elements.tolist() == [0] and groups["6"].elements.tolist() == [1, 2]


def test_hexahedra_of_20_nodes_get_those_of_faces_and_middles(tmp_path: Path) -> None:
    """Of a bent block whose edges are curved as its elements can be: with nodes of 27-node elements left out
    and found again. Boundaries get the nodes of their faces."""
    meshio = pytest.importorskip("meshio")
    full = mesh.to_quadratic(mesh.box_hexahedra((0.3, 0.2, 0.2), (3, 2, 2)))
    x = full.vertices
    bent = x + 0.5 * np.column_stack((x[:, 1] * x[:, 2], x[:, 0] ** 2, x[:, 0] * x[:, 1]))
    cells = full.elements[:, :20]
    left = np.flatnonzero((x[:, 0] < -0.1499) & np.isin(np.arange(len(x)), cells))
    written = meshio.Mesh(
        bent,
        [("hexahedron20", cells)],
        cell_sets={"half": [np.arange(6)]},
        point_sets={"left": left},
    )
    meshio.write(tmp_path / "block.inp", written)
    found = mesh.load(tmp_path / "block.inp")
    assert isinstance(found, mesh.SolidMesh) and found.elements.shape == (12, 27)
    assert len(found.vertices) == len(x)
    # All terms of the map that 20 nodes can follow: each element is the one of 27 nodes.
    np.testing.assert_allclose(found.vertices[found.elements], bent[full.elements], atol=1e-12)
    groups = {n.lower(): g for n, g in mesh.load_groups(tmp_path / "block.inp").items()}
    left = groups["left"].vertices
    assert len(left) == 25  # 5 x 5 nodes of a side of 2 x 2 faces
    assert groups["half"].elements.tolist() == list(range(6))
    assert set(groups["half"].vertices.tolist()) == set(found.elements[:6].ravel().tolist())
    scene = stark.Scene()
    block = scene.add_solid(found, stark.materials.soft_rubber, pins=left)
    mask = np.isin(np.arange(len(found.vertices)), left)
    scene.add_traction(block.faces[mask[block.triangles].all(axis=1)], (0.0, 0.0, 1.0))
    assert not stark.Simulation(scene).step().failed


def test_files_without_groups_have_none(tmp_path: Path) -> None:
    meshio = pytest.importorskip("meshio")
    box = mesh.tet_box(0.1, 1)
    meshio.write(tmp_path / "box.vtu", meshio.Mesh(box.vertices, [("tetra", box.tets)]))
    assert mesh.load_groups(tmp_path / "box.vtu") == {}
    with pytest.raises(InvalidMesh, match=r"none.msh' cannot be read"):
        mesh.load_groups(tmp_path / "none.msh")


VTK = (
    "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n"
    "0 0 0 1 0 0 0 1 0 0 0 1 0 0 2\nCELLS 1 5\n4 0 1 2 {}\nCELL_TYPES 1\n10\n"
)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        (
            "a.msh",  # node 4 is not there, but 5 and 6 are
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n5 0 0 1\n6 0 0 2\n"
            "$EndNodes\n$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n",
        ),
        (
            "b.msh",
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 5 1 6\n3 1 0 5\n1\n2\n3\n5\n6\n0 0 0\n1 0 0\n"
            "0 1 0\n0 0 1\n0 0 2\n$EndNodes\n$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n",
        ),
        ("a.vtk", VTK.format(-1)),
        ("b.vtk", VTK.format(7)),
        (
            "a.mesh",
            "MeshVersionFormatted 2\nDimension 3\nVertices\n5\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 2 0\n"
            "Tetrahedra\n1\n1 2 3 9 0\nEnd\n",
        ),
    ],
)
def test_nodes_that_are_not_there(name: str, content: str, tmp_path: Path) -> None:
    """None is taken for the last one of the file."""
    pytest.importorskip("meshio")
    (tmp_path / name).write_text(content)
    with pytest.raises(InvalidMesh, match=r"tetra 0 .*: its node 3 .* is none of the 5 in the file: .*must"):
        mesh.load(tmp_path / name)


def test_nodes_beyond_all_others(tmp_path: Path) -> None:
    pytest.importorskip("meshio")
    file = tmp_path / "a.inp"
    file.write_text("*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4\n1,1,2,3,9\n")
    with pytest.raises(InvalidMesh, match="an element names a node that is not there"):
        mesh.load(file)


def test_nodes_of_groups_that_are_not_there(tmp_path: Path) -> None:
    pytest.importorskip("meshio")
    file = tmp_path / "a.msh"
    file.write_text(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n5 0 0 1\n6 0 0 2\n"
        "$EndNodes\n$Elements\n2\n1 4 2 1 1 1 2 3 5\n2 2 2 7 1 1 2 4\n$EndElements\n"
    )
    with pytest.raises(InvalidMesh, match=r"group '7': triangle 0 .*: its node 2 .* is none of the 5"):
        mesh.load_groups(file)

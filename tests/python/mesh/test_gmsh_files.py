"""Numbers of nodes in files of Gmsh: those from 0 on became elements with other nodes."""

from __future__ import annotations

from pathlib import Path

import pytest

import stark
from stark import InvalidMesh, mesh

HEAD = '$MeshFormat\n{} 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 "rubber"\n$EndPhysicalNames\n'
OLD = (
    HEAD.format(2.2) + "$Nodes\n4\n{} 0 0 0\n{} 1 0 0\n{} 0 1 0\n{} 0 0 1\n$EndNodes\n"
    "$Elements\n2\n1 15 2 0 1 {}\n2 4 3 1 0 0 {} {} {} {}\n$EndElements\n"
)
NEW = (
    HEAD.format(4.1) + "$Nodes\n2 4 1 4\n0 1 0 1\n{}\n0 0 0\n3 1 0 3\n{}\n{}\n{}\n1 0 0\n0 1 0\n0 0 1\n"
    "$EndNodes\n$Elements\n2 2 1 2\n0 1 15 1\n1 {}\n3 1 4 1\n2 {} {} {} {}\n$EndElements\n"
)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    pytest.importorskip("meshio")
    return tmp_path / "part.msh"


@pytest.mark.parametrize("text", [OLD, NEW])
@pytest.mark.parametrize("numbers", [(1, 2, 3, 4), (40, 7, 12, 9)])
def test_numbers_of_any_order(file: Path, text: str, numbers: tuple[int, ...]) -> None:
    file.write_text(text.format(*numbers, numbers[0], *numbers))
    part = mesh.load(file)
    assert isinstance(part, mesh.TetMesh) and part.elements.tolist() == [[0, 1, 2, 3]]
    assert part.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]


@pytest.mark.parametrize(
    ("text", "nodes", "elements", "message"),
    [
        (OLD, (0, 1, 2, 3), (0, 1, 2, 3), "line 10: a node has the number 0: Gmsh numbers nodes from 1"),
        (OLD, (1, 2, 3, 4), (0, 1, 2, 3), "line 18: an element names node 0: Gmsh numbers nodes from 1"),
        (OLD, (1, 2, 3, 3), (1, 2, 3, 3), "line 13: a node has the number 3, as that of line 12: each must"),
        (NEW, (0, 1, 2, 3), (0, 1, 2, 3), "line 11: a node has the number 0: Gmsh numbers nodes from 1"),
        (NEW, (1, 2, 3, 4), (0, 1, 2, 3), "line 26: an element names node 0: Gmsh numbers nodes from 1"),
        (NEW, (1, 2, 2, 4), (1, 2, 2, 4), "line 15: a node has the number 2, as that of line 14: each must"),
    ],
)
def test_numbers_that_no_node_can_have(
    file: Path, text: str, nodes: tuple[int, ...], elements: tuple[int, ...], message: str
) -> None:
    """The number 0 was taken for the largest, and the last node for all of one number."""
    file.write_text(text.format(*nodes, nodes[1], *elements))
    for read in (mesh.load, mesh.load_groups):
        with pytest.raises(InvalidMesh, match=message):
            read(file)


@pytest.mark.parametrize("binary", [True, False])
@pytest.mark.parametrize("version", ["gmsh22", "gmsh"])
def test_files_that_are_written_by_programs(file: Path, version: str, binary: bool) -> None:
    meshio = pytest.importorskip("meshio")
    box = stark.mesh.tet_box(0.1, 2)
    meshio.write(file, meshio.Mesh(box.vertices, [("tetra", box.tets)]), file_format=version, binary=binary)
    part = mesh.load(file)
    assert isinstance(part, mesh.TetMesh) and (part.tets == box.tets).all()


def test_damaged_files_are_told_by_what_reads_them(file: Path) -> None:
    whole = OLD.format(1, 2, 3, 4, 1, 1, 2, 3, 4)
    for end in range(0, len(whole) - 1):
        file.write_text(whole[:end])
        with pytest.raises(InvalidMesh, match=r"part\.msh'"):
            mesh.load(file)

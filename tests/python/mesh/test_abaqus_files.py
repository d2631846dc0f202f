"""Input files of Abaqus: sets of several blocks, surfaces by faces of elements, what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import mesh

pytest.importorskip("meshio")

#: Nodes of the faces of a cube S1 to S6, by axis and side, as the manual of Abaqus draws them.
SIDES = [(2, -1), (2, 1), (1, -1), (0, 1), (1, 1), (0, -1)]


def nodes_text(vertices: Any, first: int = 1) -> str:
    rows = [f"{first + k}, {x!r}, {y!r}, {z!r}" for k, (x, y, z) in enumerate(np.asarray(vertices).tolist())]
    return "*Node\n" + "\n".join(rows)


def elements_text(kind: str, elements: Any, first: int = 1, offset: int = 1, options: str = "") -> str:
    rows = [
        ", ".join(map(str, (first + k, *(np.asarray(row) + offset).tolist())))
        for k, row in enumerate(elements)
    ]
    return f"*Element, type={kind}{options}\n" + "\n".join(rows)


def written(tmp_path: Path, *texts: str) -> Path:
    file = tmp_path / "part.inp"
    file.write_text("*Heading\n** a comment\n" + "\n".join(texts) + "\n*Step\n*End Step\n")
    return file


def groups_of(file: Path) -> tuple[Any, dict[str, mesh.MeshGroup]]:
    return mesh.load(file), mesh.load_groups(file)


def test_faces_of_hexahedra_are_those_of_the_manual(tmp_path: Path) -> None:
    cube = mesh.box_hexahedra(2.0, 1)
    surfaces = [f"*Surface, type=ELEMENT, name=Side{k + 1}\n7, S{k + 1}" for k in range(6)]
    file = written(
        tmp_path, nodes_text(cube.vertices, 11), elements_text("C3D8R", cube.elements, 7, 11), *surfaces
    )
    loaded, groups = groups_of(file)
    for k, (axis, side) in enumerate(SIDES):
        expected = np.flatnonzero(loaded.vertices[:, axis] * side > 0)
        np.testing.assert_array_equal(groups[f"Side{k + 1}"].vertices, expected)
        assert len(expected) == 4 and len(groups[f"Side{k + 1}"].elements) == 0


def test_surfaces_of_quadratic_elements_have_the_nodes_of_their_edges(tmp_path: Path) -> None:
    """By faces of sets: all faces in a plane, found by hand, are all nodes in that plane."""
    lump = mesh.to_quadratic(mesh.tet_box(0.2, 2))
    faces = [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)]
    sets, lines = [], []
    for k, corners in enumerate(faces):
        below = (lump.vertices[lump.elements[:, corners]][:, :, 2] < -0.0999).all(axis=1)
        rows = np.flatnonzero(below) + 1
        if rows.size:
            sets.append(f"*Elset, elset=_S{k + 1}, internal\n" + ",\n".join(map(str, rows)))
            lines.append(f"_S{k + 1}, S{k + 1}")
    file = written(
        tmp_path,
        nodes_text(lump.vertices),
        elements_text("C3D10", lump.elements, options=", elset=All"),
        *sets,
        "*Surface, type=ELEMENT, name=Bottom\n" + "\n".join(lines),
        "*Surface, name=Skin\nAll,",
    )
    loaded, groups = groups_of(file)
    bottom = np.flatnonzero(loaded.vertices[:, 2] < -0.0999)
    np.testing.assert_array_equal(groups["Bottom"].vertices, bottom)
    skin = np.unique(loaded.surface_triangles())
    np.testing.assert_array_equal(groups["Skin"].vertices, skin)


def test_hexahedra_of_20_nodes_get_the_nodes_in_the_middle_of_faces(tmp_path: Path) -> None:
    whole = mesh.to_quadratic(mesh.box_hexahedra(2.0, 1))
    file = written(
        tmp_path,
        nodes_text(whole.vertices[whole.elements[0, :20]]),
        elements_text("C3D20", [range(20)]),
        "*Surface, name=Top\n1, S2",
    )
    loaded, groups = groups_of(file)
    np.testing.assert_array_equal(groups["Top"].vertices, np.flatnonzero(loaded.vertices[:, 2] > 0.99))
    assert len(groups["Top"].vertices) == 9


def test_sets_of_several_blocks_are_their_own(tmp_path: Path) -> None:
    """meshio counts named blocks from the first one, and keeps the last of those that are called the same."""
    lump = mesh.tet_box(0.1, 1)
    third = len(lump.tets) // 3
    file = written(
        tmp_path,
        nodes_text(lump.vertices),
        elements_text("C3D4", lump.tets[:third]),
        elements_text("C3D4", lump.tets[third : 2 * third], 1 + third, options=", elset=Late"),
        elements_text("C3D4", lump.tets[2 * third :], 1 + 2 * third, options=", ELSET=late"),
        "*Elset, elset=Some\n1, 3, Late\n*Elset, elset=Some\n2",
        "*Nset, nset=Corner, elset=Late",
        "*Nset, nset=Every, generate\n1, 5, 2",
        '*Nset, nset=Two, instance="Part-1-1"\n1, Part-1-1.Every',
        "*Surface, type=NODE, name=Two\nTwo, 1.0",
    )
    loaded, groups = groups_of(file)
    np.testing.assert_array_equal(loaded.tets, lump.tets)
    late = np.arange(third, len(lump.tets))
    np.testing.assert_array_equal(groups["Late"].elements, late)
    np.testing.assert_array_equal(groups["Some"].elements, np.union1d(late, [0, 1, 2]))
    np.testing.assert_array_equal(groups["Corner"].vertices, np.unique(lump.tets[late]))
    for name in ("Every", "Two", "Two surface"):
        np.testing.assert_array_equal(groups[name].vertices, [0, 2, 4])
    assert set(groups) == {"Late", "Some", "Corner", "Every", "Two", "Two surface"}


def test_surfaces_of_shells_are_their_nodes(tmp_path: Path) -> None:
    sheet = mesh.grid(0.1, 0.1, 2)
    file = written(
        tmp_path,
        nodes_text(sheet.vertices),
        elements_text("S3", sheet.triangles),
        "*Surface, name=Front\n1, SPOS\n3, SNEG",
    )
    _, groups = groups_of(file)
    np.testing.assert_array_equal(groups["Front"].vertices, np.unique(sheet.triangles[[0, 2]]))


def test_what_would_be_read_wrongly_is_refused(tmp_path: Path) -> None:
    """meshio keeps the nodes of the last part, and takes the elements of all of them for elements of it."""
    lump = mesh.tet_box(0.1, 1)
    part = nodes_text(lump.vertices), elements_text("C3D4", lump.tets)
    two = written(tmp_path, "*Part, name=A", *part, "*End Part", "*Part, name=B", *part, "*End Part")
    for read in (mesh.load, mesh.load_groups):
        with pytest.raises(
            stark.InvalidMesh, match=r"part\.inp' has 2 blocks of nodes .* write each part to"
        ):
            read(two)
    twice = written(
        tmp_path, *part, "*Instance, name=A", "*End Instance", "*Instance, name=B", "*End Instance"
    )
    with pytest.raises(stark.InvalidMesh, match=r"2 instances of parts \(\*INSTANCE\): must have one"):
        mesh.load(twice)
    for wrong, message in (
        ("*ElGen\n1, 5", r"part\.inp' has \*ELGEN, which is not read"),
        ("*System\n1, 0, 0, 0, 1, 0", r"\*SYSTEM, which is not read: must have nodes .* Cartesian"),
        ("*Surface, name=Top\n1, S9", r"\*SURFACE: face 'S9' of a tetra: must be S1, S2"),
        ("*Nset, nset=Top, generate\n1", r"sets cannot be read .*: must be numbers and names"),
        ("*Elset, elset=Top\nNone", r"refers to the set 'None': must be one of the file, before it"),
    ):
        with pytest.raises(stark.InvalidMesh, match=message):
            mesh.load_groups(written(tmp_path, *part, wrong))
    round_nodes = part[0].replace("*Node", "*Node, system=C")
    with pytest.raises(stark.InvalidMesh, match=r"\*NODE, SYSTEM=C: must be Cartesian, R"):
        mesh.load(written(tmp_path, round_nodes, part[1]))


def test_files_that_include_others_are_those_in_one_piece(tmp_path: Path) -> None:
    """By *INCLUDE, also in the middle of data and within what is included, and by INPUT= of a keyword."""
    cube = mesh.box_hexahedra(1.0, 2)
    nodes, elements = nodes_text(cube.vertices), elements_text("C3D8", cube.elements)
    sets = "*Nset, nset=ends\n1, 2\n*Elset, elset=one\n3"
    whole, groups = groups_of(written(tmp_path, nodes, elements, sets))
    (tmp_path / "parts").mkdir()
    rows = nodes.splitlines()
    (tmp_path / "parts" / "rest.inc").write_text("\n".join(rows[5:]))
    (tmp_path / "parts" / "nodes.inc").write_text("\n".join([*rows[:5], "*INCLUDE, INPUT=rest.inc"]))
    (tmp_path / "elements.inc").write_text("\n".join(elements.splitlines()[1:]))
    pieces = (
        "*Include,\n input=parts/nodes.inc",
        "*Element, type=C3D8, input=elements.inc",
        sets,
    )
    split, of_split = groups_of(written(tmp_path, *pieces))
    np.testing.assert_array_equal(split.vertices, whole.vertices)
    np.testing.assert_array_equal(split.elements, whole.elements)
    assert set(of_split) == set(groups)
    for name, group in groups.items():
        np.testing.assert_array_equal(of_split[name].vertices, group.vertices)
        np.testing.assert_array_equal(of_split[name].elements, group.elements)


def test_included_files_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    with pytest.raises(stark.InvalidMesh, match=r"nowhere.inc', which '.*part.inp' includes: No such file"):
        mesh.load(written(tmp_path, "*Include, input=nowhere.inc"))
    with pytest.raises(stark.InvalidMesh, match=r"must not go in circles"):
        mesh.load(written(tmp_path, "*Include, input=part.inp"))

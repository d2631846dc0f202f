"""Formats that trimesh and meshio read: what they write comes back, and damaged files are errors."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

from stark import InvalidMesh, mesh

BOX = mesh.box((0.2, 0.3, 0.4))
TETRAHEDRA = mesh.tet_box((0.2, 0.3, 0.4), cells=2)
HEXAHEDRA = mesh.box_hexahedra((0.2, 0.3, 0.4), cells=2)
VOLUMES = {
    "tetra": TETRAHEDRA,
    "tetra10": mesh.to_quadratic(TETRAHEDRA),
    "hexahedron": HEXAHEDRA,
    "hexahedron27": mesh.to_quadratic(HEXAHEDRA),
}


@pytest.mark.parametrize("suffix", ["off", "glb", "gltf", "dae", "stl", "ply", "obj"])
def test_surfaces_that_trimesh_writes(suffix: str, tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    if suffix == "dae":
        pytest.importorskip("collada")
    path = tmp_path / f"box.{suffix}"
    trimesh.Trimesh(BOX.vertices, BOX.triangles, process=False).export(path)
    found = mesh.load(path)
    assert isinstance(found, mesh.TriangleMesh) and found.is_closed
    assert found.bounds == pytest.approx(BOX.bounds, abs=1e-7)  # single precision
    assert found.volume == pytest.approx(0.024, rel=1e-6)


@pytest.mark.parametrize("kind", VOLUMES)
@pytest.mark.parametrize("suffix", ["vtu", "vtk", "msh"])
def test_volumes_that_meshio_writes(kind: str, suffix: str, tmp_path: Path) -> None:
    """Bit by bit, nodes in the same order; MSH files are those of Gmsh 2.2 and, of linear cells, 4.1."""
    meshio = pytest.importorskip("meshio")
    solid, path = VOLUMES[kind], tmp_path / f"box.{suffix}"
    cells = solid.tets if isinstance(solid, mesh.TetMesh) else solid.elements
    written = meshio.Mesh(solid.vertices, [(kind, np.asarray(cells))])
    for file_format in ("gmsh22", "gmsh") if suffix == "msh" else (None,):
        meshio.write(path, written, file_format)
        found = mesh.load(path)
        assert type(found) is type(solid)
        assert np.array_equal(found.vertices, solid.vertices)
        assert np.array_equal(found.tets if isinstance(found, mesh.TetMesh) else found.elements, cells)


@pytest.mark.parametrize("suffix", ["msh", "vtu", "vtk", "mesh", "off", "glb", "gltf", "dae"])
@pytest.mark.parametrize("data", [b"", b"nonsense\n1 2 3\n", b"<VTKFile></VTKFile>", b"OFF\n3 1 0\n0 0 0\n"])
def test_damaged_files_are_errors_without_a_word(
    suffix: str, data: bytes, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("trimesh")
    pytest.importorskip("meshio")
    pytest.importorskip("collada")
    path = tmp_path / f"part.{suffix}"
    path.write_bytes(data)
    with pytest.raises(InvalidMesh, match=f"part.{suffix}' "):
        mesh.load(path)
    assert capfd.readouterr() == ("", "")


OFF = "# a\nOFF # b\n4 2 0\n0 0 0\n1 0 0\n\n0 1 0\n1 1 0 0.5 # c\n3 0 1 2 255 0 0\n3 1 3 2\n"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("3 1 3 2\n", "", "declares 4 vertices and 2 faces, but 5 lines follow: must be one for each"),
        ("3 1 3 2\n", "3 1 3 2\n3 0 1 3\n", "declares 4 vertices and 2 faces, but 7 lines follow"),
        ("1 0 0\n", "", "declares 4 vertices and 2 faces, but 5 lines follow"),
        ("3 1 3 2\n", "3 1 3", r"face 1 \(from 0\) is '3 1 3': must be a count and as many vertices"),
    ],
)
def test_lines_of_off_files_that_do_not_agree_with_their_counts(
    old: str, new: str, message: str, tmp_path: Path
) -> None:
    """Faces were left out in silence, or became vertices."""
    pytest.importorskip("trimesh")
    path = tmp_path / "part.off"
    path.write_text(OFF)
    assert len(mesh.load(path).vertices) == 4
    path.write_text(OFF.replace("OFF # b\n4", "OFF 4"))
    assert len(mesh.load(path).vertices) == 4
    path.write_text(OFF.replace(old, new))
    with pytest.raises(InvalidMesh, match=rf"part\.off' {message}|part\.off': {message}"):
        mesh.load(path)


def test_files_that_are_no_meshes_are_one_error(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """XML is a format of meshio, which warns of each element that it does not know."""
    pytest.importorskip("trimesh")
    pytest.importorskip("meshio")
    (tmp_path / "robot.xml").write_text("<mujoco><worldbody><body/></worldbody></mujoco>")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InvalidMesh, match=r"robot.xml' cannot be read: meshio finds no mesh in it"):
            mesh.load(tmp_path / "robot.xml")
        (tmp_path / "notes.txt").write_text("none")
        with pytest.raises(
            InvalidMesh, match=r"'.txt' is the suffix of no format of meshes: must be one of .obj"
        ):
            mesh.load(tmp_path / "notes.txt")
    assert capfd.readouterr() == ("", "")

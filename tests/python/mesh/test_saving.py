"""Surfaces as OBJ, PLY and STL: they come back, the library trimesh reads the same, and what cannot be
written is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stark
from stark import mesh
from stark.mesh.saving import WRITERS


@pytest.mark.parametrize(
    "original", [mesh.sphere(0.1, 2), mesh.grid(0.3, 1.0 / 3.0, 3)], ids=["closed", "open"]
)
@pytest.mark.parametrize("ending", [*WRITERS, ".STL"])
def test_surfaces_come_back(ending: str, original: mesh.TriangleMesh, tmp_path: Path) -> None:
    file = tmp_path / f"surface{ending}"
    original.save(file)
    loaded = mesh.load(file)
    assert isinstance(loaded, mesh.TriangleMesh)
    if ending.lower() == ".stl":  # in single precision, numbered as triangles come
        corners = original.vertices[original.triangles].astype(np.float32)
        np.testing.assert_array_equal(loaded.vertices[loaded.triangles], corners)
        assert len(loaded.vertices) == len(original.vertices)
        assert loaded.is_closed == original.is_closed
    else:
        np.testing.assert_array_equal(loaded.vertices, original.vertices)
        np.testing.assert_array_equal(loaded.triangles, original.triangles)


@pytest.mark.parametrize("ending", WRITERS)
def test_another_library_reads_the_same(ending: str, tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    original = mesh.sphere(0.1, 2)
    original.save(tmp_path / f"ball{ending}")
    read = trimesh.load(tmp_path / f"ball{ending}", process=False)
    corners = np.asarray(read.vertices)[np.asarray(read.faces)]
    np.testing.assert_allclose(corners, original.vertices[original.triangles], rtol=1e-7, atol=1e-9)
    if ending == ".stl":
        centers = corners.mean(axis=1)
        outwards = np.einsum("ij,ij->i", np.asarray(read.face_normals), centers)
        assert (outwards > 0.0).all()


def test_what_cannot_be_written_is_refused(tmp_path: Path) -> None:
    surface = mesh.sphere(0.1, 1)
    with pytest.raises(stark.InvalidArgument, match=r"must end in \.npz, \.obj, \.ply, \.stl"):
        surface.save(tmp_path / "ball.vtk")
    with pytest.raises(stark.InvalidArgument, match=r"1e\+39 m: must be below 3\.4e38 in STL"):
        surface.scaled(1e40).save(tmp_path / "ball.stl")
    for wrong in (-1, 3):  # which readers would refuse, or take for the last vertex
        for ending in (*WRITERS, ".npz"):
            with pytest.raises(
                stark.InvalidMesh, match=rf"TriangleMesh: triangles: .* vertex {wrong}: must be"
            ):
                mesh.TriangleMesh(np.eye(3), [[0, 1, wrong]]).save(tmp_path / f"wrong{ending}")
    with pytest.raises(stark.InvalidMesh, match=r"SolidMesh: elements: .* vertex 8: must be in \[0, 8\)"):
        cube = mesh.box_hexahedra(1.0, 1)
        mesh.SolidMesh(cube.vertices, np.where(cube.elements == 7, 8, cube.elements)).save(tmp_path / "a.npz")
    with pytest.raises(OSError, match="nowhere"):
        surface.save(tmp_path / "nowhere" / "ball.obj")
    assert not list(tmp_path.iterdir())

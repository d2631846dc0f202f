"""Mesh files: formats against hand-written content, damaged files, volume meshing."""

from __future__ import annotations

import os
import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import InvalidMesh, mesh

OBJ = """# a box side and a quad, with all forms of indices
v 0 0 0
v 1 0 0 0.5 0.5 0.5
v 1 1 0
v 0 1 0
vt 0 0
vn 0 0 1
f 1/1/1 2/1/1 3/1/1 4/1/1
v 0 0 1
f -1 1//1 2/1
"""


def test_obj(tmp_path: Path) -> None:
    (tmp_path / "a.OBJ").write_text(OBJ)
    loaded = mesh.load(tmp_path / "a.OBJ")
    assert loaded.triangles.tolist() == [[0, 1, 2], [0, 2, 3], [4, 0, 1]]
    assert loaded.vertices[1].tolist() == [1, 0, 0] and len(loaded.vertices) == 5


def test_lines_of_obj_files_that_go_on_in_the_next_one(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text(
        "v 0 0 \\\n 0\nv 1 0 0\nv 0 1 0\n# a comment\nf 1 2 \\\n3\nf 3 2 \\\n\\\n1"
    )
    assert mesh.load(tmp_path / "a.obj").triangles.tolist() == [[0, 1, 2], [2, 1, 0]]


@pytest.mark.parametrize("binary", [True, False])
def test_stl(tmp_path: Path, binary: bool) -> None:
    box = mesh.box(1.0)
    corners = box.vertices[box.triangles]
    if binary:
        data = b"\0" * 80 + struct.pack("<I", 12)
        data += b"".join(struct.pack("<12fH", 0, 0, 0, *t.ravel(), 0) for t in corners)
    else:
        facets = "".join(
            "facet normal 0 0 0\nouter loop\n"
            + "".join(f"vertex {x} {y} {z}\n" for x, y, z in t)
            + "endloop\nendfacet\n"
            for t in corners.tolist()
        )
        data = f"solid box\n{facets}endsolid box\n".encode()
    (tmp_path / "a.stl").write_bytes(data)
    loaded = mesh.load(tmp_path / "a.stl")
    assert len(loaded.vertices) == 8 and loaded.is_closed and loaded.volume == pytest.approx(1.0)


@pytest.mark.parametrize("original", [mesh.sphere(0.1, 1), mesh.tet_box(0.3, 2)], ids=["surface", "volume"])
def test_saved_meshes_come_back_bit_by_bit(tmp_path: Path, original: mesh.Mesh) -> None:
    original.save(tmp_path / "a.npz")
    loaded = mesh.load(tmp_path / "a.npz")
    assert type(loaded) is type(original)
    assert all(np.array_equal(getattr(loaded, name), array) for name, array in vars(original).items())
    with pytest.raises(stark.InvalidArgument, match=r"must end in \.npz"):
        original.save(tmp_path / "a.vtk")


@pytest.mark.parametrize(
    ("name", "data", "part"),
    [
        ("a.obj", b"v 0 0\n", "line 1: a vertex needs three numbers"),
        ("a.obj", b"v 0 0 zero\n", "not a valid OBJ file"),
        ("a.obj", b"v 0 0 0\nf 1 1\n", "line 2: a face needs three vertices"),
        ("a.obj", b"v 0 0 0\nf 0 1 2\n", "numbered from 1"),
        ("a.obj", b"", "0 triangles"),
        ("a.obj", b"v 0 1,5 0\n", "line 1: .*'1,5'; decimals need a point, not a comma"),
        ("a.npz", b"PK", "not a valid NPZ file"),
        ("a.stl", b"\0" * 90, "not a valid STL file|0 triangles"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nf 1 \\\n2\nf 1 2 x\n", "line 3: a face needs three"),
        ("a.obj", b"v 0 0 0\nf 1 1 x\n", "not a valid OBJ file: line 2: invalid literal"),
        (
            "a.stl",
            b"\0" * 80 + b"\x64\0\0\0" + b"\0" * 503,
            "declares 100 triangles, but it holds 10 and 3 bytes",
        ),
        ("a.stl", b"\0" * 80 + b"\2\0\0\0" + b"\0" * 150, "declares 2 triangles, but it holds 3: must agree"),
        (
            "a.stl",
            b"solid" + b"\0" * 75 + b"\2\0\0\0" + b"\0" * 9,
            "declares 2 triangles, but it holds 0 and 9",
        ),
        ("a.stl", b"\0" * 84, "0 triangles: must have at least one"),
        ("a.stl", b"\xe7", "1 bytes: must be text that starts with 'solid', or the 84 bytes"),
        (
            "a.stl",
            b"solid \xe4\nfacet\n vertex 0 0\n",
            "line 3: a vertex needs three numbers, got 'vertex 0 0'",
        ),
        (
            "a.obj",
            b"v 0 0 0\n" * 3 + b"f 1 2 3\nf 1 2 4\n",
            r"line 5: a face has the vertex 4: must be in \[1, 3\]",
        ),
        ("a.obj", b"v 0 0 0\n" * 3 + b"f -1 -2 -4\n", "line 4: a face has the vertex -1: must be in"),
        (
            "a.stl",
            b"solid\nfacet\n" + b"vertex 0 0 0\n" * 3 + b"endfacet\n",
            "1 facets, of which 1 end, with 3 corners, and no 'endsolid' .* was cut off",
        ),
        (
            "a.stl",
            b"solid\nfacet\n" + b"vertex 0 0 0\n" * 3 + b"endfacet\nfacet\nendsolid\n",
            "2 facets, of which 1 end, with 3 corners, and an 'endsolid'",
        ),
        ("a.stl", b"solid\n vertex 0 0 0\n", "1 corners do not make whole triangles: the file was cut off"),
    ],
)
def test_broken_files_are_refused_by_name(tmp_path: Path, name: str, data: bytes, part: str) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InvalidMesh, match=part) as caught:
        mesh.load(tmp_path / name)
    assert name in str(caught.value)


def test_formats_of_other_libraries_name_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "trimesh", None)
    monkeypatch.setitem(__import__("sys").modules, "meshio", None)
    (tmp_path / "a.glb").write_bytes(b"glTF")
    (tmp_path / "a.msh").write_bytes(b"$MeshFormat")
    with pytest.raises(ImportError, match=r"stark-sim\[mesh\]"):
        mesh.load(tmp_path / "a.glb")
    with pytest.raises(ImportError, match="needs meshio: pip install"):
        mesh.load(tmp_path / "a.msh")


@pytest.mark.parametrize("code", ["utf-8-sig", "utf-16"])
def test_text_with_a_mark_of_its_code(tmp_path: Path, code: str) -> None:
    """The mark is before the first statement, and no part of it."""
    (tmp_path / "a.obj").write_bytes("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 4\n".encode(code))
    loaded = mesh.load(tmp_path / "a.obj")
    assert loaded.vertices[loaded.triangles[0]].tolist() == [[0, 0, 0], [1, 0, 0], [0, 0, 1]]
    (tmp_path / "a.stl").write_bytes(TEXT_STL.encode(code))
    assert mesh.load(tmp_path / "a.stl").vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


TEXT_STL = """solid a
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid a
"""


def test_stl_in_capitals(tmp_path: Path) -> None:
    (tmp_path / "a.stl").write_text(TEXT_STL.upper().replace("ENDSOLID", "END SOLID"))
    assert mesh.load(tmp_path / "a.stl").triangles.tolist() == [[0, 1, 2]]


def test_triangles_that_have_a_vertex_twice_go(tmp_path: Path) -> None:
    """As in files that write triangles as quadrangles; vertices keep their numbers."""
    (tmp_path / "a.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\no flat\nf 1 2 3 3\no back\nf 2 4 3\n"
    )
    loaded, groups = mesh.load(tmp_path / "a.obj"), mesh.load_groups(tmp_path / "a.obj")
    assert loaded.triangles.tolist() == [[0, 1, 2], [1, 3, 2]]
    assert groups["flat"].elements.tolist() == [0] and groups["back"].elements.tolist() == [1]
    assert len(mesh.load(tmp_path / "a.obj", merge=False).triangles) == 3


def test_pipes_are_not_waited_for(tmp_path: Path) -> None:
    for suffix in (".obj", ".ply", ".stl", ".npz", ".msh", ".glb"):
        os.mkfifo(tmp_path / f"pipe{suffix}")
        with pytest.raises(InvalidMesh, match="it is a device, pipe or socket, not a file"):
            mesh.load(tmp_path / f"pipe{suffix}")


def test_arrays_that_claim_to_be_larger_than_they_are(tmp_path: Path) -> None:
    mesh.grid(1.0, 1.0, 1).save(tmp_path / "a.npz")
    with zipfile.ZipFile(tmp_path / "a.npz") as archive:
        items = {name: archive.read(name) for name in archive.namelist()}
    head = b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000, 3), }".ljust(117) + b"\n"
    lying = b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        for name, data in items.items():
            archive.writestr(name, lying + data[128:] if name == "vertices.npy" else data)
    with pytest.raises(InvalidMesh, match="claims the shape"):
        mesh.load(tmp_path / "a.npz")


def split(surface: mesh.TriangleMesh) -> tuple[np.ndarray, np.ndarray]:
    """A vertex of its own for each corner of each triangle, as files with normals have them."""
    corners = surface.vertices[surface.triangles].reshape(-1, 3)
    return corners, np.arange(len(corners)).reshape(-1, 3)


def write_obj(path: Path, vertices: np.ndarray, triangles: np.ndarray) -> None:
    rows = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    path.write_text("\n".join(rows + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles.tolist()]))


def write_ply(path: Path, vertices: np.ndarray, triangles: np.ndarray) -> None:
    head = f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\nproperty double x\nproperty double y\n"
    head += f"property double z\nelement face {len(triangles)}\nproperty list uchar int vertex_indices\n"
    rows = [f"{x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    path.write_text("\n".join([head + "end_header", *rows, *(f"3 {a} {b} {c}" for a, b, c in triangles)]))


def write_by_trimesh(path: Path, vertices: np.ndarray, triangles: np.ndarray) -> None:
    trimesh = pytest.importorskip("trimesh")
    normals = np.repeat(trimesh.Trimesh(vertices, triangles, process=False).face_normals, 3, axis=0)
    trimesh.Trimesh(vertices, triangles, vertex_normals=normals, process=False).export(path)


@pytest.mark.parametrize(
    ("name", "write"), [("a.obj", write_obj), ("a.ply", write_ply), ("a.glb", write_by_trimesh)]
)
def test_vertices_that_are_split_by_face_are_one(name: str, write: Any, tmp_path: Path) -> None:
    """The mass of a closed surface fills it; that of an open one is spread over it."""
    box = mesh.box((0.1, 0.06, 0.04))
    write(tmp_path / name, *split(box))
    found = mesh.load(tmp_path / name)
    assert isinstance(found, mesh.TriangleMesh) and found.is_closed and len(found.vertices) == 8
    body = stark.Scene().add_rigid(found, mass=1.0)
    assert np.diag(body.inertia) == pytest.approx(
        [(0.06**2 + 0.04**2) / 12, (0.1**2 + 0.04**2) / 12, (0.1**2 + 0.06**2) / 12], rel=1e-5
    )


def test_vertices_at_the_same_place_that_are_kept(tmp_path: Path) -> None:
    """Of a slit, if the caller says so; of closed surfaces that touch, and of NPZ files, always."""
    vertices, triangles = split(mesh.grid(1.0, 1.0, 1))
    write_obj(tmp_path / "slit.obj", vertices, triangles)
    kept = mesh.load(tmp_path / "slit.obj", merge=False)
    assert np.array_equal(kept.vertices, vertices) and len(mesh.load(tmp_path / "slit.obj").vertices) == 4
    mesh.TriangleMesh(vertices, triangles).save(tmp_path / "slit.npz")
    assert len(mesh.load(tmp_path / "slit.npz").vertices) == 6
    touching = mesh.joined([mesh.box(0.1), mesh.box(0.1).translated((0.1, 0.1, 0.0))])
    write_obj(tmp_path / "two.obj", touching.vertices, touching.triangles)
    assert np.array_equal(mesh.load(tmp_path / "two.obj").vertices, touching.vertices)
    lone = mesh.TriangleMesh([*mesh.grid(1.0, 1.0, 1).vertices, (9.0, 9.0, 9.0)], [(0, 1, 2)])
    write_obj(tmp_path / "open.obj", lone.vertices, lone.triangles)  # no two at the same place: none goes
    assert len(mesh.load(tmp_path / "open.obj").vertices) == 5
    with pytest.raises(stark.InvalidArgument, match="merge"):
        mesh.load(tmp_path / "open.obj", merge="no")  # type: ignore[arg-type]

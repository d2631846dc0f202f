"""PLY surfaces against hand-written content, and files that are none."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from stark import InvalidMesh, mesh
from stark.mesh import ply_files


def ply(layout: str) -> bytes:
    header = (
        f"ply\nformat {layout} 1.0\ncomment x\nelement vertex 4\nproperty double x\n"
        "property float y\nproperty float z\n"
        "property uchar red\nelement edge 1\nproperty int a\nproperty int b\n"
        "element face 1\nproperty uchar group\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()
    corners = [(0, 0, 0), (1, 0, 0), (1, 0.5, 0), (0, 0.5, 0.25)]
    if layout == "ascii":
        lines = [f"{x} {y} {z} 255" for x, y, z in corners] + ["0 1", "7 4 0 1 2 3"]
        return header + "\n".join(lines).encode() + b"\n"
    order = "<" if "little" in layout else ">"
    body = b"".join(struct.pack(order + "dffB", *corner, 255) for corner in corners)
    return header + body + struct.pack(order + "ii", 0, 1) + struct.pack(order + "BBiiii", 7, 4, 0, 1, 2, 3)


def test_ply_faces_before_their_vertices(tmp_path: Path) -> None:
    (tmp_path / "a.ply").write_text(
        "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
        "element vertex 3\nproperty double x\nproperty double y\nproperty double z\nend_header\n"
        "3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n"
    )
    loaded = mesh.load(tmp_path / "a.ply")
    assert loaded.triangles.tolist() == [[0, 1, 2]] and loaded.area == pytest.approx(0.5)


@pytest.mark.parametrize("layout", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply(tmp_path: Path, layout: str) -> None:
    (tmp_path / "a.ply").write_bytes(ply(layout))
    loaded = mesh.load(tmp_path / "a.ply")
    assert loaded.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert loaded.vertices[3].tolist() == [0, 0.5, 0.25]


@pytest.mark.parametrize(
    ("data", "part"),
    [
        (b"solid", "does not start with a PLY header"),
        (ply("ascii").replace(b"7 4 0", b"7 -4 0"), "a list of -4 entries: must have at least none"),
        (ply("ascii").replace(b"element face ", b"element face -"), "elements 'face': must be at"),
        (ply("binary_little_endian")[:-9], "ends too early"),
        (ply("ascii")[:-9], "ends too early"),
        (ply("binary_middle_endian"), "format is 'binary_middle_endian': must be one of ascii, "),
        (ply("ascii").replace(b"format ascii 1.0\n", b""), "format is '': must be one of"),
        (
            ply("ascii").replace(b"0 1 2 3", b"0 1 2 4"),
            r"face 0 has the vertex 4: must be in \[0, 3\]",
        ),
        (ply("ascii").replace(b"0 1 2 3", b"0 1 2 -1"), "face 0 has the vertex -1: must be in"),
        (ply("ascii") + b"8 3 0 1 2\n", "more behind the elements that its header declares"),
        (ply("binary_big_endian") + b"\1\2", "more behind the elements that its header declares"),
    ],
)
def test_files_that_are_no_ply_are_refused_by_name(tmp_path: Path, data: bytes, part: str) -> None:
    path = tmp_path / "a.ply"
    path.write_bytes(data)
    with pytest.raises(InvalidMesh, match=part) as refused:
        mesh.load(path)
    assert str(path) in str(refused.value)


def faces(order: str, rows: list[tuple[int, ...]]) -> bytes:
    """A plane of 5 x 5 vertices with faces."""
    layout = "little" if order == "<" else "big"
    header = (
        f"ply\nformat binary_{layout}_endian 1.0\nelement vertex 25\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {len(rows)}\nproperty uchar flags\n"
        "property list uchar ushort vertex_index\nend_header\n"
    ).encode()
    body = b"".join(struct.pack(order + "fff", k % 5, k // 5, 0) for k in range(25))
    return header + body + b"".join(struct.pack(f"{order}BB{len(r)}H", 1, len(r), *r) for r in rows)


@pytest.mark.parametrize("order", "<>")
def test_rows_of_the_same_length_are_read_in_one_piece(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, order: str
) -> None:
    reads: list[int] = []
    read = ply_files._Binary._take
    monkeypatch.setattr(
        ply_files._Binary, "_take", lambda self, kind, count: reads.append(count) or read(self, kind, count)
    )
    rows = [(k, k + 1, k + 6, k + 5) for k in range(19) if k % 5 < 4]
    (tmp_path / "even.ply").write_bytes(faces(order, rows))
    even = mesh.load(tmp_path / "even.ply")
    assert len(even.triangles) == 2 * len(rows) and len(reads) < 8
    (tmp_path / "mixed.ply").write_bytes(faces(order, [*rows[:-1], rows[-1][:3]]))
    mixed = mesh.load(tmp_path / "mixed.ply")
    assert mixed.triangles.tolist() == even.triangles.tolist()[:-1] and len(reads) > 2 * len(rows)


def test_a_file_that_ends_within_rows_of_the_same_length(tmp_path: Path) -> None:
    (tmp_path / "a.ply").write_bytes(faces("<", [(0, 1, 6), (0, 6, 5)])[:-1])
    with pytest.raises(InvalidMesh, match="ends too early"):
        mesh.load(tmp_path / "a.ply")

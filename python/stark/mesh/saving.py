"""Surfaces as files of other programs: OBJ and PLY with all digits, STL as its format has them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from stark._core import InvalidArgument
from stark.mesh.arguments import Indices, Points


def obj(vertices: Points, triangles: Indices, file: Path) -> bytes:
    """Text, each vertex once; numbers are the shortest that are read back in every bit."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (triangles + 1).tolist()]
    return ("\n".join(lines) + "\n").encode()


def ply(vertices: Points, triangles: Indices, file: Path) -> bytes:
    """Binary, in double precision."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, triangles
    return header.encode() + vertices.astype("<f8").tobytes() + faces.tobytes()


def stl(vertices: Points, triangles: Indices, file: Path) -> bytes:
    """Binary: single precision, three vertices for each triangle."""
    largest = np.abs(vertices).max(initial=0.0)
    if largest > np.finfo(np.float32).max:
        raise InvalidArgument(f"save: '{file}': a coordinate of {largest:g} m: must be below 3.4e38 in STL")
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    rows = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    rows["normal"] = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    rows["corners"] = corners
    return b"Stark, coordinates in m".ljust(80) + np.uint32(len(triangles)).tobytes() + rows.tobytes()


#: By ending of the file.
WRITERS: dict[str, Callable[[Points, Indices, Path], bytes]] = {".obj": obj, ".ply": ply, ".stl": stl}

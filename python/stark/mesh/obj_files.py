"""OBJ files: their surface, and the parts of it that have names."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from stark._core import InvalidMesh
from stark.mesh.arguments import Indices
from stark.mesh.polygons import triangulated
from stark.mesh.types import TriangleMesh

#: Statements that name the faces after them: an object, groups, a material.
_NAMES = ("o", "g", "usemtl")


class ObjSurface(NamedTuple):
    """What a file has, as it is written."""

    surface: TriangleMesh
    parts: dict[str, Indices]
    """Triangles of each object, group and material, by its name."""


def read_obj(data: bytes, file: Path) -> ObjSurface:
    vertices: list[list[float]] = []
    corners: list[int] = []
    counts: list[int] = []
    lines: list[int] = []  # of the faces
    current: dict[str, list[str]] = {}  # names in force, by statement
    members: dict[str, list[int]] = {}  # faces of each name
    for number, line in _lines(data):
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append(vertex_of(words, number, line))
        elif words[:1] == ["f"]:
            polygon = _polygon(words, len(vertices), number, line)
            for name in {name for names in current.values() for name in names}:
                members.setdefault(name, []).append(len(counts))
            corners.extend(polygon)
            counts.append(len(polygon))
            lines.append(number)
        elif words[:1] and words[0] in _NAMES:  # groups are several words, other names one text
            current[words[0]] = words[1:] if words[0] == "g" else [" ".join(words[1:])]
    points = np.array(vertices).reshape(-1, 3)
    triangles = triangulated(points, counts, corners, lambda k: f"'{file}': line {lines[k]}: face {k}")
    many = np.maximum(np.array(counts, dtype=np.int64) - 2, 0)
    face = np.repeat(np.arange(len(counts)), many)
    parts = {
        name: np.flatnonzero(np.isin(face, faces)).astype(np.int32) for name, faces in members.items() if name
    }
    return ObjSurface(TriangleMesh(points, triangles), parts)


def vertex_of(words: list[str], number: int, line: str) -> list[float]:
    """Coordinates of a line of text."""
    try:
        vertex = [float(word) for word in words[1:4]]
    except ValueError as error:
        raise ValueError(f"line {number}: {error}") from None
    if len(vertex) < 3:
        raise InvalidMesh(f"line {number}: a vertex needs three numbers, got '{line.strip()}'")
    return vertex


def _lines(data: bytes) -> Iterator[tuple[int, str]]:
    """Lines with their numbers; those that end in a backslash go on in the next one."""
    start, text = 0, ""
    for number, line in enumerate(data.decode("utf-8", errors="replace").splitlines(), start=1):
        start, text = start or number, text + line
        if text.endswith("\\"):
            text = text[:-1] + " "
            continue
        yield start, text
        start, text = 0, ""
    if text:
        yield start, text


def _polygon(words: list[str], vertex_count: int, number: int, line: str) -> list[int]:
    """Vertices of a face: v, v/vt, v//vn or v/vt/vn; negative numbers count back from the last vertex."""
    try:
        indices = [int(word.partition("/")[0]) for word in words[1:]]
    except ValueError as error:
        raise ValueError(f"line {number}: {error}") from None
    if len(indices) < 3 or 0 in indices:
        raise InvalidMesh(
            f"line {number}: a face needs three vertices, numbered from 1, got '{line.strip()}'"
        )
    return [i - 1 if i > 0 else vertex_count + i for i in indices]

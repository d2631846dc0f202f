"""OBJ files: their surface, and the parts of it that have names."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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


class ObjTexture(NamedTuple):
    """A surface with its texture coordinates, corner by corner."""

    positions: NDArray[np.float64]
    """(m, 3, 3), of the corners of the triangles."""
    coordinates: NDArray[np.float64]
    """(m, 3, 2)."""


def read_obj(data: bytes, file: Path) -> ObjSurface:
    read = _Read(data)
    points = np.array(read.vertices).reshape(-1, 3)
    read.require_vertices()
    triangles = triangulated(points, read.counts, read.corners, read.title(file))
    many = np.maximum(np.array(read.counts, dtype=np.int64) - 2, 0)
    face = np.repeat(np.arange(len(read.counts)), many)
    parts = {
        name: np.flatnonzero(np.isin(face, faces)).astype(np.int32)
        for name, faces in read.members.items()
        if name
    }
    return ObjSurface(TriangleMesh(points, triangles), parts)


def read_texture(data: bytes, file: Path) -> ObjTexture:
    """Raises InvalidMesh where a corner has no texture coordinates."""
    read = _Read(data)
    points, places = np.array(read.vertices).reshape(-1, 3), np.array(read.places).reshape(-1, 2)
    corners, textures = np.array(read.corners, dtype=np.int64), np.array(read.textures, dtype=np.int64)
    if not len(corners):
        raise InvalidMesh("has 0 faces: must have at least one")
    missing = np.flatnonzero((textures < 0) | (textures >= len(places)))
    if len(missing):
        face = int(np.searchsorted(np.cumsum(read.counts), missing[0], side="right"))
        raise InvalidMesh(
            f"line {read.lines[face]}: a corner of the face has no texture coordinates (vt): must be the "
            f"place on the flat pattern; unwrap the mesh in a modelling program"
        )
    read.require_vertices()
    rows = triangulated(points[corners], read.counts, np.arange(len(corners)), read.title(file))
    return ObjTexture(points[corners[rows]], places[textures[rows]])


class _Read:
    """Statements of a file."""

    def __init__(self, data: bytes) -> None:
        self.vertices: list[list[float]] = []
        self.places: list[list[float]] = []  # texture coordinates
        self.corners: list[int] = []
        self.textures: list[int] = []  # of the corners; -1: none
        self.counts: list[int] = []
        self.lines: list[int] = []  # of the faces
        self.members: dict[str, list[int]] = {}  # faces of each name
        current: dict[str, list[str]] = {}  # names in force, by statement
        for number, line in _lines(data):
            words = line.split()
            if words[:1] == ["v"]:
                self.vertices.append(vertex_of(words, number, line))
            elif words[:1] == ["vt"]:
                self.places.append(_place_of(words, number))
            elif words[:1] == ["f"]:
                for name in {name for names in current.values() for name in names}:
                    self.members.setdefault(name, []).append(len(self.counts))
                self._add_face(words, number, line)
            elif words[:1] and words[0] in _NAMES:  # groups are several words, other names one text
                current[words[0]] = words[1:] if words[0] == "g" else [" ".join(words[1:])]

    def title(self, file: Path) -> Callable[[int], str]:
        """Names a face."""
        return lambda k: f"'{file}': line {self.lines[k]}: face {k}"

    def require_vertices(self) -> None:
        """Of faces, which may come before the vertices that they name."""
        corners, count = np.array(self.corners, dtype=np.int64), len(self.vertices)
        wrong = np.flatnonzero((corners < 0) | (corners >= count))
        if len(wrong):
            face = int(np.searchsorted(np.cumsum(self.counts), wrong[0], side="right"))
            given = int(corners[wrong[0]])
            given += given >= 0
            raise InvalidMesh(
                f"line {self.lines[face]}: a face has the vertex {given}: must be in [1, {count}], or count "
                f"back by negative numbers to the first one"
            )

    def _add_face(self, words: list[str], number: int, line: str) -> None:
        polygon = _polygon(words, len(self.vertices), number, line)
        self.corners.extend(polygon)
        self.textures.extend(_texture(word, len(self.places)) for word in words[1:])
        self.counts.append(len(polygon))
        self.lines.append(number)


def text_of(data: bytes) -> str:
    """Of a file in UTF-8, or in UTF-16 with the mark of that; the mark is no text."""
    wide = data[:2] in (b"\xff\xfe", b"\xfe\xff")
    return data.decode("utf-16" if wide else "utf-8-sig", errors="replace")


def vertex_of(words: list[str], number: int, line: str) -> list[float]:
    """Coordinates of a line of text."""
    try:
        vertex = [float(word) for word in words[1:4]]
    except ValueError as error:
        comma = "; decimals need a point, not a comma" if any("," in word for word in words) else ""
        raise ValueError(f"line {number}: {error}{comma}") from None
    if len(vertex) < 3:
        raise InvalidMesh(f"line {number}: a vertex needs three numbers, got '{line.strip()}'")
    if not all(map(math.isfinite, vertex)):
        raise InvalidMesh(f"line {number}: '{line.strip()}': coordinates must be finite")
    return vertex


def _place_of(words: list[str], number: int) -> list[float]:
    """u and v of a line of text; files with one coordinate, or three, are of textures of other kinds."""
    try:
        place = [float(word) for word in words[1:3]]
    except ValueError as error:
        raise ValueError(f"line {number}: {error}") from None
    return place if len(place) == 2 else [math.nan, math.nan]


def _texture(corner: str, count: int) -> int:
    """Number of the texture coordinates of v/vt or v/vt/vn, -1 where there are none."""
    try:
        number = int(corner.split("/")[1])
    except (IndexError, ValueError):
        return -1
    return number - 1 if number > 0 else count + number if number < 0 else -1


def _lines(data: bytes) -> Iterator[tuple[int, str]]:
    """Lines with their numbers; those that end in a backslash go on in the next one."""
    start, text = 0, ""
    for number, line in enumerate(text_of(data).splitlines(), start=1):
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

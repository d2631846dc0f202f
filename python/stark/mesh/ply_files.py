"""PLY surfaces, text and binary: a header that declares elements and their properties, then their values."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from stark._core import InvalidMesh
from stark.mesh.polygons import triangulated
from stark.mesh.types import TriangleMesh

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
#: Orders of bytes; none in text.
_LAYOUTS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True)
class _Property:
    name: str
    kind: str  # of NumPy
    length: str = ""  # the kind of the length of lists; empty for single values


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)

    @property
    def has_lists(self) -> bool:
        return any(p.length for p in self.properties)


def read_ply(data: bytes, file: Path) -> TriangleMesh:
    """The vertices and faces, polygons cut into triangles; ``file`` is for messages."""
    end = data.find(b"end_header")
    if not data.startswith(b"ply") or end < 0:
        raise InvalidMesh("the file does not start with a PLY header")
    order, elements = _header(data[:end].decode("ascii"))
    body = data[data.index(b"\n", end) + 1 :]
    reader = _Binary(body, order) if order else _Text(body)
    vertices: Any = np.empty((0, 3))
    corners: list[int] = []
    counts: list[int] = []
    for element in elements:
        if element.has_lists:
            _read_lists(reader, element, corners, counts)
            continue
        table = reader.table(element.count, element.properties)
        if element.name == "vertex":
            vertices = np.stack([np.asarray(table[axis], dtype=np.float64) for axis in "xyz"], axis=1)
    if reader.rest():
        raise InvalidMesh(
            "there is more behind the elements that its header declares: their counts and properties must "
            "be those of the file; write it again"
        )
    _require_corners(corners, counts, len(vertices))
    return TriangleMesh(vertices, triangulated(vertices, counts, corners, lambda k: f"'{file}': face {k}"))


def _header(text: str) -> tuple[str, list[_Element]]:
    """The order of bytes and the elements that a header declares."""
    layout = ""
    elements: list[_Element] = []
    for line in text.splitlines():
        words = line.split()
        if words[:1] == ["format"]:
            layout = words[1]
        elif words[:1] == ["element"]:
            elements.append(_Element(words[1], int(words[2])))
            if elements[-1].count < 0:
                raise InvalidMesh(f"{words[2]} elements '{words[1]}': must be at least none")
        elif words[:2] == ["property", "list"]:
            elements[-1].properties.append(_Property(words[4], _TYPES[words[3]], _TYPES[words[2]]))
        elif words[:1] == ["property"]:
            elements[-1].properties.append(_Property(words[2], _TYPES[words[1]]))
    if layout not in _LAYOUTS:
        raise InvalidMesh(f"its format is '{layout}': must be one of {', '.join(_LAYOUTS)}; write it as such")
    return _LAYOUTS[layout], elements


def _read_lists(reader: _Text | _Binary, element: _Element, corners: list[int], counts: list[int]) -> None:
    """Reads elements with lists; the corners of faces, and their counts, are appended."""
    even = reader.even_table(element) if isinstance(reader, _Binary) else None
    if even is not None:
        for k, p in enumerate(element.properties):
            if element.name == "face" and p.name in ("vertex_indices", "vertex_index"):
                values = even[f"values_{k}"].reshape(element.count, -1)
                corners.extend(values.ravel().astype(np.int64).tolist())
                counts.extend([values.shape[1]] * element.count)
        return
    for _ in range(element.count):
        for p in element.properties:
            entries = int(reader.values(p.length, 1)[0]) if p.length else 1
            if entries < 0:
                raise InvalidMesh(f"a list of {entries} entries: must have at least none")
            values = reader.values(p.kind, entries)
            if element.name == "face" and p.name in ("vertex_indices", "vertex_index"):
                corners.extend(int(v) for v in values)
                counts.append(entries)


def _require_corners(corners: list[int], counts: list[int], count: int) -> None:
    """That faces with so many corners each name vertices that are there."""
    given = np.asarray(corners, dtype=np.int64)
    wrong = np.flatnonzero((given < 0) | (given >= count))
    if len(wrong):
        face = int(np.searchsorted(np.cumsum(counts), wrong[0], side="right"))
        raise InvalidMesh(
            f"face {face} has the vertex {given[wrong[0]]}: must be in [0, {count - 1}], from 0 on"
        )


class _Text:
    def __init__(self, body: bytes) -> None:
        self._words = body.split()
        self._at = 0

    def values(self, kind: str, count: int) -> list[float]:
        words = self._words[self._at : self._at + count]
        if len(words) < count:
            raise InvalidMesh("the file ends too early")
        self._at += count
        return [float(w) if kind[0] == "f" else int(w) for w in words]

    def table(self, count: int, properties: list[_Property]) -> dict[str, Any]:
        rows = np.array(self.values("f8", count * len(properties))).reshape(count, len(properties))
        return {p.name: rows[:, i] for i, p in enumerate(properties)}

    def rest(self) -> list[bytes]:
        return self._words[self._at :]


class _Binary:
    def __init__(self, body: bytes, order: str) -> None:
        self._body, self._order, self._at = body, order, 0

    def values(self, kind: str, count: int) -> Any:
        return self._take(np.dtype(self._order + kind), count)

    def table(self, count: int, properties: list[_Property]) -> Any:
        return self._take(np.dtype([(p.name, self._order + p.kind) for p in properties]), count)

    def even_table(self, element: _Element) -> Any:
        """Rows of an element whose lists all have the lengths of those in its first row, as of triangles: in
        one piece, many times as fast as one by one. None, and nothing is taken, where there are others."""
        begin = self._at
        fields: list[Any] = []
        try:
            for k, p in enumerate(element.properties if element.count else ()):
                entries = int(self.values(p.length, 1)[0]) if p.length else 1
                if entries < 0 or (p.length and p.kind[0] == "f"):
                    raise InvalidMesh("to be read one by one")
                self.values(p.kind, entries)
                fields += [(f"length_{k}", self._order + p.length)] if p.length else []
                fields.append((f"values_{k}", self._order + p.kind, (entries,)))
            self._at = begin
            table = self._take(np.dtype(fields), element.count)
        except (InvalidMesh, ValueError):  # the file ends too early for such rows, or there are none
            table = None
        lengths = [name for name, *_ in fields if name.startswith("length")]
        if table is None or not all((table[name] == table[name][0]).all() for name in lengths):
            self._at = begin
            return None
        return table

    def _take(self, kind: np.dtype[Any], count: int) -> Any:
        size = kind.itemsize * count
        if self._at + size > len(self._body):
            raise InvalidMesh("the file ends too early")
        result = np.frombuffer(self._body, dtype=kind, count=count, offset=self._at)
        self._at += size
        return result

    def rest(self) -> bytes:
        return self._body[self._at :].strip()

"""Polygons of Collada files as triangles: trimesh and pycollada would cut all into fans. [Collada 1.4.1,
polylist and polygons]"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidMesh
from stark.mesh.polygons import triangulated


def with_triangles(data: bytes, file: Path) -> bytes:
    """The file with ``<triangles>`` in place of polygons, which keep their corners, normals and all. As it is
    where it has none, or is no Collada file: what reads it says so."""
    try:
        tree = ElementTree.parse(io.BytesIO(data))
        changed = [_replace(geometry, f"'{file}'") for geometry in _found(tree.getroot(), "mesh")]
    except InvalidMesh:
        raise
    except (ElementTree.ParseError, ValueError, LookupError, TypeError, OverflowError):
        return data
    if not any(changed):
        return data
    written = io.BytesIO()
    tree.write(written)
    return written.getvalue()


def _found(element: Any, *names: str) -> list[Any]:
    """Elements below one, whatever the namespace of the file."""
    return [part for part in element.iter() if str(part.tag).rpartition("}")[2] in names]


def _require_corners(mesh: Any, source: str) -> None:
    """That faces have vertices which are there: pycollada takes -1 for the last one, and trimesh
    goes on without the meshes that name others."""
    for part in _found(mesh, "triangles", "polylist", "polygons"):
        for vertex in _found(part, "input"):
            if vertex.get("semantic") != "VERTEX":
                continue
            named = _corners(part)[1][int(vertex.get("offset")) :: _width(part)]
            count = len(_positions(mesh, vertex.get("source")))
            if len(strays := named[(named < 0) | (named >= count)]):
                raise InvalidMesh(
                    f"{source}: a face has vertex {strays[0]}: must be in [0, {count}); write the file anew"
                )


def _replace(mesh: Any, source: str) -> bool:
    _require_corners(mesh, source)
    changed = False
    for number, part in enumerate(_found(mesh, "polylist", "polygons")):
        counts, corners = _corners(part)
        if len(counts) == 0 or counts.max() < 4:
            continue
        inputs = _found(part, "input")
        table = corners.reshape(-1, _width(part))
        if counts.sum() != len(table) or _found(part, "ph"):
            continue  # holes are left to pycollada
        vertex = next(row for row in inputs if row.get("semantic") == "VERTEX")
        points = _positions(mesh, vertex.get("source"))[table[:, int(vertex.get("offset"))]]
        title = f"{source}: polygons {number} of a mesh"
        triangles = triangulated(points, counts, np.arange(len(table)), lambda k, t=title: f"{t}: face {k}")  # type: ignore[misc]
        _write(part, triangles, table)
        changed = True
    return changed


def _width(part: Any) -> int:
    """How many numbers a corner has: its vertex, its normal and more."""
    return 1 + max(int(row.get("offset")) for row in _found(part, "input"))


def _corners(part: Any) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """How many corners each polygon has, and the numbers of all."""
    rows = [np.array((row.text or "").split(), dtype=np.int64) for row in _found(part, "p")]
    every = np.concatenate(rows) if rows else np.zeros(0, dtype=np.int64)
    for row in _found(part, "vcount"):
        return np.array((row.text or "").split(), dtype=np.int64), every
    width = _width(part)
    return np.array([len(row) // width for row in rows], dtype=np.int64), every


def _positions(mesh: Any, source: str) -> NDArray[np.float64]:
    named = {part.get("id"): part for part in mesh.iter()}
    vertices = named[source.removeprefix("#")]
    positions = next(row for row in _found(vertices, "input") if row.get("semantic") == "POSITION")
    array = named[positions.get("source").removeprefix("#")]
    numbers = np.array(_found(array, "float_array")[0].text.split(), dtype=np.float64)
    stride = int(_found(array, "accessor")[0].get("stride", "1"))
    return numbers.reshape(-1, stride)[:, :3]


def _write(part: Any, triangles: NDArray[np.int64], table: NDArray[np.int64]) -> None:
    space = str(part.tag).rpartition("}")[0]
    space = space + "}" if space else ""
    for row in _found(part, "vcount", "p"):
        part.remove(row)
    part.tag = f"{space}triangles"
    part.set("count", str(len(triangles)))
    ElementTree.SubElement(part, f"{space}p").text = " ".join(map(str, table[triangles].ravel().tolist()))

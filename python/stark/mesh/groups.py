"""Named parts of mesh files."""

from __future__ import annotations

import os
from typing import Any, NamedTuple

import numpy as np

from stark._core import InvalidMesh
from stark.arguments import given_path
from stark.files import read_bytes
from stark.mesh.arguments import Indices
from stark.mesh.obj_files import read_obj
from stark.mesh.repair import whole
from stark.mesh.types import TriangleMesh
from stark.mesh.usd_files import SUFFIXES, read_usd


class MeshGroup(NamedTuple):
    """A named part of a mesh file: a material, a boundary, a piece of a garment."""

    vertices: Indices
    """(n,), those of its cells, numbered as in the mesh that ``load`` makes of the file."""
    elements: Indices
    """(m,), which elements of that mesh, triangles of a surface, are in it; of a boundary of a solid none."""


def load_groups(path: str | os.PathLike[str]) -> dict[str, MeshGroup]:
    """Groups of a file by name: objects, groups and materials of OBJ; meshes of USD; of what ``load`` reads
    by ``meshio`` physical groups of Gmsh, those without a name by their number, and sets of other programs.
    ``groups["inlet"].vertices`` are for pins, rollers and masks of faces, ``groups["steel"].elements`` for
    values by element."""
    file = given_path(path, "mesh.load_groups: path")
    if file.suffix.lower() in SUFFIXES:
        found = _as_loaded(*read_usd(file).surface_and_parts)
    elif file.suffix.lower() == ".obj":
        try:
            found = _as_loaded(*read_obj(read_bytes(file), file))
        except OSError as error:
            raise InvalidMesh(f"'{file}': {error.strerror or error}: must be a readable mesh file") from None
        except (InvalidMesh, ValueError) as error:
            raise InvalidMesh(f"'{file}': {error}") from None
    else:
        from stark.mesh.volume_files import groups_by_meshio

        found = groups_by_meshio(file)
    return {name: MeshGroup(*rows) for name, rows in found.items()}


def _as_loaded(surface: TriangleMesh, parts: dict[str, Indices]) -> dict[str, tuple[Indices, Indices]]:
    """Vertices and triangles of each part, numbered as in the mesh that ``load`` makes of a surface."""
    united = whole(surface)
    rows = np.arange(len(surface.triangles))
    if len(united.triangles) != len(rows):  # triangles that collapsed are gone
        corners: Any = surface.triangles
        if len(united.vertices) != len(surface.vertices):
            corners = surface.vertices[corners]
        a, b, c = corners.reshape(len(rows), 3, -1).transpose(1, 0, 2)
        kept = ~((a == b).all(axis=1) | (b == c).all(axis=1) | (c == a).all(axis=1))
        rows = np.where(kept, np.cumsum(kept) - 1, -1)
    found = {}
    for name, faces in parts.items():
        chosen = rows[faces][rows[faces] >= 0].astype(np.int32)
        found[name] = (np.unique(united.triangles[chosen]).astype(np.int32), chosen)
    return found

"""Named parts of mesh files."""

from __future__ import annotations

import os
from typing import NamedTuple

from stark._core import InvalidMesh
from stark.arguments import given_path
from stark.files import read_bytes
from stark.mesh.arguments import Indices


class MeshGroup(NamedTuple):
    """A named part of a mesh file: a material, a boundary, a piece of a garment."""

    vertices: Indices
    """(n,), those of its cells, numbered as in the mesh that ``load`` makes of the file."""
    elements: Indices
    """(m,), which elements of that mesh, triangles of a surface, are in it; of a boundary of a solid none."""


def load_groups(path: str | os.PathLike[str]) -> dict[str, MeshGroup]:
    """Groups of a file by name: objects, groups and materials of OBJ; of what ``load`` reads by ``meshio``
    physical groups of Gmsh, those without a name by their number, and sets of other programs.
    ``groups["inlet"].vertices`` are for pins, rollers and masks of faces, ``groups["steel"].elements`` for
    values by element."""
    file = given_path(path, "mesh.load_groups: path")
    if file.suffix.lower() == ".obj":
        from stark.mesh.obj_files import parts_of_obj

        try:
            found = parts_of_obj(read_bytes(file), file)
        except OSError as error:
            raise InvalidMesh(f"'{file}': {error.strerror or error}: must be a readable mesh file") from None
        except (InvalidMesh, ValueError) as error:
            raise InvalidMesh(f"'{file}': {error}") from None
    else:
        from stark.mesh.volume_files import groups_by_meshio

        found = groups_by_meshio(file)
    return {name: MeshGroup(*rows) for name, rows in found.items()}

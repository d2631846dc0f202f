"""Garments with the flat pattern that they are cut from: the texture coordinates of modelling programs."""

from __future__ import annotations

import os
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidMesh
from stark.arguments import given_path
from stark.files import read_bytes
from stark.mesh.arguments import Indices, Points, positive
from stark.mesh.obj_files import read_texture
from stark.mesh.types import TriangleMesh


class Pattern(NamedTuple):
    """A garment, flat and as it is worn."""

    mesh: TriangleMesh
    """Flat, in the plane z = 0: what the cloth is at rest."""
    positions: Points
    """(n, 3), of the same vertices, as it is worn: its ``initial_positions`` [m]."""
    seams: Indices
    """(k, 2), pairs of vertices that lie apart on the pattern and at one place on the garment."""
    scale: float
    """Metres of a unit of texture coordinates."""


def load_pattern(path: str | os.PathLike[str], *, scale: float | None = None) -> Pattern:
    """Reads a garment from an OBJ file with texture coordinates, which are places on the flat pattern. Add it
    as ``scene.add_cloth(garment.mesh, initial_positions=garment.positions)``, and sew it by
    ``scene.attach(cloth, cloth, pairs=garment.seams)``.

    ``scale`` is the length of a unit of texture coordinates [m]; if left out, the pattern gets the area of
    the garment. Triangles are those of ``load`` and ``load_groups``. Raises InvalidMesh for files that cannot
    be read, faces without texture coordinates, and pieces without area on the pattern."""
    file = given_path(path, "mesh.load_pattern: path")
    if file.suffix.lower() != ".obj":
        raise InvalidMesh(
            f"load_pattern: path = '{file}': must be an OBJ file, with texture coordinates (vt)"
        )
    try:
        worn, flat = read_texture(read_bytes(file), file)
    except OSError as error:
        raise InvalidMesh(f"'{file}': {error.strerror or error}: must be a readable mesh file") from None
    except (InvalidMesh, ValueError) as error:
        raise InvalidMesh(f"'{file}': {error}") from None
    if not np.isfinite(flat).all():
        raise InvalidMesh(f"'{file}': texture coordinates are not finite: must be two numbers each")
    u, v = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    areas = 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    if not (areas > 0.0).all():
        raise InvalidMesh(
            f"'{file}': triangle {int(areas.argmin())} has no area in texture coordinates: must have the "
            f"shape on the pattern; unwrap the mesh without folds"
        )
    area = 0.5 * np.linalg.norm(np.cross(worn[:, 1] - worn[:, 0], worn[:, 2] - worn[:, 0]), axis=1).sum()
    unit = float(np.sqrt(area / areas.sum())) if scale is None else positive(scale, "load_pattern: scale")
    return _sewn(worn, unit * flat, unit)


def _sewn(worn: NDArray[np.float64], flat: NDArray[np.float64], unit: float) -> Pattern:
    """One vertex for each place on pattern and garment; seams join those of one place on the garment."""
    both = np.concatenate([worn, flat], axis=2).reshape(-1, 5)
    _, first, corner = np.unique(both, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)  # keeps the order of the file
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    rows = both[first[order]]
    _, of = np.unique(rows[:, :3], axis=0, return_inverse=True)
    together = np.argsort(of.reshape(-1), kind="stable")
    groups = np.split(together, np.flatnonzero(np.diff(of.reshape(-1)[together])) + 1)
    seams = [(other, group[0]) for group in groups for other in group[1:]]
    flat_rows = np.column_stack([rows[:, 3:], np.zeros(len(rows))])
    mesh = TriangleMesh(flat_rows, rank[corner.reshape(-1)].reshape(-1, 3))
    return Pattern(
        mesh, np.ascontiguousarray(rows[:, :3]), np.array(seams, dtype=np.int32).reshape(-1, 2), unit
    )

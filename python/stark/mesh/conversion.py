"""Meshes of what users give: our own, pairs of arrays, those of other libraries."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeVar

from numpy.typing import ArrayLike

from stark import _core
from stark._core import InvalidMesh
from stark.mesh.arguments import columns_of
from stark.mesh.types import EmbeddedMesh, Polyline, SolidMesh, TetMesh, TriangleMesh

_Mesh = TypeVar("_Mesh", bound=TriangleMesh | TetMesh | SolidMesh)


def as_triangle_mesh(mesh: Any, name: str) -> TriangleMesh:
    """A TriangleMesh, a ``(vertices, triangles)`` pair or anything with ``vertices`` and ``faces``
    (trimesh)."""
    if isinstance(mesh, TriangleMesh):
        return mesh
    if isinstance(mesh, (TetMesh, SolidMesh)):
        kind = "lattice (EmbeddedMesh)" if isinstance(mesh, EmbeddedMesh) else type(mesh).__name__
        raise InvalidMesh(f"{name}: got a {kind}: must be a TriangleMesh; use add_solid, or mesh.surface()")
    # trimesh has the corners of its triangles as `triangles`, and their indices as `faces`.
    for attribute in ("faces", "triangles"):
        if hasattr(mesh, "vertices") and hasattr(mesh, attribute):
            return _named(name, TriangleMesh, mesh.vertices, getattr(mesh, attribute))
    if isinstance(mesh, Sequence) and not isinstance(mesh, str) and len(mesh) == 2:
        return _named(name, TriangleMesh, mesh[0], mesh[1])
    raise InvalidMesh(
        f"{name}: got {type(mesh).__name__}: must be a stark.TriangleMesh or a (vertices, triangles) pair; "
        f"files are read by stark.mesh.load(path)"
    )


def as_tet_mesh(mesh: Any, name: str) -> TetMesh:
    """A TetMesh, a ``(vertices, tets)`` pair or anything with ``vertices`` and ``tets``."""
    if isinstance(mesh, TetMesh):
        return mesh
    if isinstance(mesh, TriangleMesh):
        raise InvalidMesh(
            f"{name}: got a TriangleMesh: must be a TetMesh; use stark.mesh.tetrahedralise(mesh) or add_cloth"
        )
    if hasattr(mesh, "vertices") and hasattr(mesh, "tets"):
        return _named(name, TetMesh, mesh.vertices, mesh.tets)
    if isinstance(mesh, Sequence) and not isinstance(mesh, str) and len(mesh) == 2:
        return _named(name, TetMesh, mesh[0], mesh[1])
    raise InvalidMesh(
        f"{name}: got {type(mesh).__name__}: must be a stark.TetMesh or a (vertices, tets) pair"
    )


def as_solid_mesh(mesh: Any, name: str) -> TetMesh | SolidMesh:
    """A SolidMesh, whatever ``as_tet_mesh`` takes, or a ``(vertices, elements)`` pair with 4, 8, 10 or 27
    nodes an element."""
    if isinstance(mesh, SolidMesh):
        return mesh
    is_pair = isinstance(mesh, Sequence) and not isinstance(mesh, str) and len(mesh) == 2
    if is_pair and columns_of(mesh[1]) in (8, 10, 27):
        return _named(name, SolidMesh, mesh[0], mesh[1])
    return as_tet_mesh(mesh, name)


def as_polyline(mesh: Any, name: str) -> Polyline:
    """A Polyline, or an array of points (n, 3)."""
    if isinstance(mesh, Polyline):
        return mesh
    if isinstance(mesh, (TriangleMesh, TetMesh, SolidMesh)):
        raise InvalidMesh(
            f"{name}: got a {type(mesh).__name__}: must be a stark.mesh.Polyline or points (n, 3); use "
            f"stark.mesh.polyline(start, end, segments)"
        )
    try:
        return Polyline(mesh)
    except InvalidMesh as error:
        raise InvalidMesh(f"{name}: {error}") from None


def _named(name: str, kind: type[_Mesh], vertices: ArrayLike, elements: ArrayLike) -> _Mesh:
    try:
        return kind(vertices, elements)
    except InvalidMesh as error:
        raise InvalidMesh(f"{name}: {error}") from None


def to_quadratic(mesh: Any) -> SolidMesh:
    """Same elements with nodes between the corners: 10-node tetrahedra of a TetMesh, 27-node hexahedra of
    hexahedra. Nodes of a curved boundary may be moved onto it afterwards, ``SolidMesh(vertices,
    mesh.elements)``."""
    solid = as_solid_mesh(mesh, "to_quadratic")
    if isinstance(solid, EmbeddedMesh):
        raise InvalidMesh("to_quadratic: got an EmbeddedMesh: must have its order from lattice(order=2)")
    elements = solid.tets if isinstance(solid, TetMesh) else solid.elements
    return SolidMesh(*_core.to_quadratic({"vertices": solid.vertices, "elements": elements}))

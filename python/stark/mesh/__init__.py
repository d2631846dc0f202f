"""Meshes: triangle surfaces and tetrahedral volumes as NumPy arrays, generators, files.

Lengths in metres. Triangles are counter-clockwise seen from outside, tetrahedra have positive volume;
``oriented`` repairs both."""

from stark.mesh.arguments import Indices, Points
from stark.mesh.cleaning import cleaned, joined
from stark.mesh.conversion import as_polyline, as_solid_mesh, as_tet_mesh, as_triangle_mesh, to_quadratic
from stark.mesh.files import load, tetrahedralise
from stark.mesh.reduction import convex_hull, convex_parts, simplified
from stark.mesh.repair import merged, oriented
from stark.mesh.report import MeshChange, MeshReport
from stark.mesh.scans import SolidFromScan, edge_lengths, solid_from_scan
from stark.mesh.shapes import (
    box,
    box_hexahedra,
    capsule,
    cylinder,
    grid,
    helix,
    polyline,
    sphere,
    tet_box,
    torus,
)
from stark.mesh.types import Mesh, Polyline, SolidMesh, TetMesh, TriangleMesh, compact

__all__ = [
    "Indices",
    "Mesh",
    "MeshChange",
    "MeshReport",
    "Points",
    "Polyline",
    "SolidFromScan",
    "SolidMesh",
    "TetMesh",
    "TriangleMesh",
    "as_polyline",
    "as_solid_mesh",
    "as_tet_mesh",
    "as_triangle_mesh",
    "box",
    "box_hexahedra",
    "capsule",
    "cleaned",
    "compact",
    "convex_hull",
    "convex_parts",
    "cylinder",
    "edge_lengths",
    "grid",
    "helix",
    "joined",
    "load",
    "merged",
    "oriented",
    "polyline",
    "simplified",
    "solid_from_scan",
    "sphere",
    "tet_box",
    "tetrahedralise",
    "to_quadratic",
    "torus",
]

# Messages and pickles name the public place.
for _type in (MeshChange, MeshReport, Polyline, SolidFromScan, SolidMesh, TetMesh, TriangleMesh):
    _type.__module__ = "stark.mesh"

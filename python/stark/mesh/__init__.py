"""Meshes: triangle surfaces and tetrahedral volumes as NumPy arrays, generators, files.

Lengths in metres. Triangles are counter-clockwise seen from outside, tetrahedra have positive volume;
``oriented`` repairs both."""

from typing import TYPE_CHECKING

from stark.mesh.arguments import Indices, Points
from stark.mesh.conversion import as_polyline, as_solid_mesh, as_tet_mesh, as_triangle_mesh, to_quadratic
from stark.mesh.files import load
from stark.mesh.repair import merged, oriented
from stark.mesh.shapes import (
    box,
    box_hexahedra,
    capsule,
    cylinder,
    grid,
    helix,
    polyline,
    sphere,
    tet_ball,
    tet_box,
    torus,
)
from stark.mesh.types import EmbeddedMesh, Mesh, Polyline, SolidMesh, TetMesh, TriangleMesh, compact

if TYPE_CHECKING:
    from stark.mesh.cleaning import cleaned, joined
    from stark.mesh.groups import MeshGroup, load_groups
    from stark.mesh.lattices import lattice
    from stark.mesh.patterns import Pattern, load_pattern
    from stark.mesh.reduction import convex_hull, convex_parts, simplified
    from stark.mesh.report import MeshChange, MeshReport
    from stark.mesh.scans import LatticeFromScan, SolidFromScan, lattice_from_scan, solid_from_scan
    from stark.mesh.tetrahedra import edge_lengths, tetrahedralise
else:
    from stark.on_demand import attach

    # Imported when first used, to keep `import stark` fast.
    __getattr__, __dir__ = attach(
        __name__,
        {
            "stark.mesh.cleaning": "cleaned joined",
            "stark.mesh.groups": "MeshGroup load_groups",
            "stark.mesh.lattices": "lattice",
            "stark.mesh.patterns": "Pattern load_pattern",
            "stark.mesh.reduction": "convex_hull convex_parts simplified",
            "stark.mesh.report": "MeshChange MeshReport",
            "stark.mesh.scans": "LatticeFromScan SolidFromScan lattice_from_scan solid_from_scan",
            "stark.mesh.tetrahedra": "edge_lengths tetrahedralise",
        },
    )

__all__ = [
    "EmbeddedMesh",
    "Indices",
    "LatticeFromScan",
    "Mesh",
    "MeshChange",
    "MeshGroup",
    "MeshReport",
    "Pattern",
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
    "lattice",
    "lattice_from_scan",
    "load",
    "load_groups",
    "load_pattern",
    "merged",
    "oriented",
    "polyline",
    "simplified",
    "solid_from_scan",
    "sphere",
    "tet_ball",
    "tet_box",
    "tetrahedralise",
    "to_quadratic",
    "torus",
]

# Messages and pickles name the public place.
for _type in (EmbeddedMesh, Polyline, SolidMesh, TetMesh, TriangleMesh):
    _type.__module__ = "stark.mesh"

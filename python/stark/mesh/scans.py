"""From a dirty scan to a soft body: cleaned, simplified to the wanted edge length, filled with tetrahedra or
put in a lattice."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

from stark._core import InvalidMesh
from stark.arguments import given_task
from stark.mesh.arguments import positive
from stark.mesh.cleaning import cleaned
from stark.mesh.conversion import as_triangle_mesh
from stark.mesh.files import load
from stark.mesh.lattices import lattice
from stark.mesh.reduction import simplified
from stark.mesh.report import MeshReport
from stark.mesh.tetrahedra import edge_lengths, tetrahedralise
from stark.mesh.types import EmbeddedMesh, TetMesh, TriangleMesh

Progress: TypeAlias = Callable[[str, float], object]
"""Called with what is done now and the share of all that is done before it, in [0, 1]."""

#: Triangles of the simplified surface for each of those that edges of the wanted length would make.
_FINER = 2.0


class SolidFromScan(NamedTuple):
    """What became of a scan."""

    mesh: TetMesh
    surface: TriangleMesh  #: closed, as it was given to the mesher
    report: MeshReport


def solid_from_scan(
    scan: Any,
    *,
    edge_length: float,
    smallest_piece: float = 0.01,
    progress: Progress | None = None,
) -> SolidFromScan:
    """Tetrahedra of ``edge_length`` [m] that fill a dirty surface: a file, a TriangleMesh, a pair of arrays,
    a mesh of trimesh. It is ``cleaned``, which fills its holes, ``simplified`` to what that edge length can
    show, and ``tetrahedralised`` within a tenth of it; ``smallest_piece`` as in ``cleaned``. ``progress(what,
    share)`` is called before each part. Needs ``pip install 'stark-sim[mesh]'``. The same scan gives
    the same mesh on this machine; ``tetrahedralise`` says why.

    Raises InvalidMesh, InvalidArgument and ImportError as these do."""
    length = positive(edge_length, "solid_from_scan: edge_length")
    given_task(progress, "solid_from_scan: progress", "a function of what is done and its share")
    report, tell = MeshReport(), progress or (lambda what, share: None)
    surface = _prepared(scan, length, smallest_piece, report, tell, "solid_from_scan")
    tell(f"filling {len(surface.triangles)} triangles with tetrahedra", 0.15)
    solid = tetrahedralise(surface, edge_length=length)
    lengths = edge_lengths(solid)
    report.add(
        "filled with tetrahedra",
        len(solid.tets),
        f"{len(solid.tets)} tetrahedra, mean edge {lengths.mean():.3g} m of {length:g} m asked for, volume "
        f"{solid.volume:.4g} m^3 of {surface.volume:.4g} m^3 inside of the surface",
    )
    tell("done", 1.0)
    return SolidFromScan(solid, surface, report)


class LatticeFromScan(NamedTuple):
    """What became of a scan."""

    mesh: EmbeddedMesh
    surface: TriangleMesh  #: closed, as it was put in the lattice
    report: MeshReport


def lattice_from_scan(
    scan: Any,
    *,
    cell_size: float,
    edge_length: float | None = None,
    order: int = 1,
    smallest_piece: float = 0.01,
    progress: Progress | None = None,
) -> LatticeFromScan:
    """As ``solid_from_scan``, but in a ``lattice`` of cubes of ``cell_size`` [m], with a surface of triangles
    of ``edge_length`` [m], half a cell where it is left out. The same scan gives the same mesh.

    Raises InvalidMesh, InvalidArgument and ImportError as these do."""
    size = positive(cell_size, "lattice_from_scan: cell_size")
    given_task(progress, "lattice_from_scan: progress", "a function of what is done and its share")
    length = 0.5 * size if edge_length is None else positive(edge_length, "lattice_from_scan: edge_length")
    report, tell = MeshReport(), progress or (lambda what, share: None)
    surface = _prepared(scan, length, smallest_piece, report, tell, "lattice_from_scan")
    tell(f"putting {len(surface.triangles)} triangles in a lattice", 0.6)
    mesh = lattice(surface, cell_size=size, order=order, report=report)
    tell("done", 1.0)
    return LatticeFromScan(mesh, surface, report)


def _prepared(
    scan: Any, length: float, smallest_piece: float, report: MeshReport, tell: Progress, caller: str
) -> TriangleMesh:
    """Read, cleaned, and simplified to triangles of a length [m]."""
    tell("reading", 0.0)
    surface = _surface(scan, caller)
    tell(f"cleaning {len(surface.triangles)} triangles", 0.02)
    surface = cleaned(surface, smallest_piece=smallest_piece, report=report)
    tell(f"simplifying {len(surface.triangles)} triangles", 0.12)
    return _simplified(surface, length, report)


def _surface(scan: Any, caller: str) -> TriangleMesh:
    if isinstance(scan, (str, os.PathLike)):
        loaded = load(scan)
        if not isinstance(loaded, TriangleMesh):
            raise InvalidMesh(f"{caller}: '{scan}' has {type(loaded).__name__}: must be a surface")
        return loaded
    return as_triangle_mesh(scan, caller)


def _simplified(surface: TriangleMesh, length: float, report: MeshReport) -> TriangleMesh:
    wanted = math.ceil(_FINER * surface.area / (math.sqrt(3.0) / 4.0 * length**2))
    before = len(surface.triangles)
    if before <= max(wanted, 100):
        return surface
    found = cleaned(simplified(surface, max(wanted, 100)), smallest_piece=0.0, report=report)
    report.add("simplified", before - len(found.triangles), f"{len(found.triangles)} triangles of {before}")
    return found

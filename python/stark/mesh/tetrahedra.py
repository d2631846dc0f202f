"""Closed surfaces filled with tetrahedra, by fTetWild."""

from __future__ import annotations

import contextlib
import math
import tempfile
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark import _core
from stark._core import InvalidArgument, InvalidMesh
from stark.arguments import given_flag
from stark.mesh.arguments import positive
from stark.mesh.conversion import as_triangle_mesh
from stark.mesh.kept import kept
from stark.mesh.repair import oriented
from stark.mesh.types import TetMesh, TriangleMesh, compact

#: A mesh whose mean edge is this far off the wanted length, relative, is made once more,
_OFF = 0.1
#: up to so many times in all.
_TRIES = 4
#: Of the diagonal: from there on fTetWild takes seconds, and must gain this factor in each try.
_COARSE, _GROWS = 0.25, 1.05


def tetrahedralise(
    mesh: Any, *, edge_length: float | None = None, tolerance: float | None = None, keep: bool = True
) -> TetMesh:
    """Volume mesh of a closed surface, by fTetWild (``pip install stark-sim[mesh]``).

    ``edge_length`` [m]: wanted edge length, at most the diagonal of the bounds; a twentieth of it if left
    out.
    ``tolerance``: largest distance between the given surface and the result, over that diagonal; if left out
    a tenth of the edge length, with which the mean edge comes out within 15 % of the wanted one where the
    shape is wider than eight of them (up to four meshes are made for that), or 10^-3 where no edge length is
    given. Smaller ones need shorter edges on curved surfaces.

    fTetWild is randomised: it makes another mesh in each call. ``keep`` takes the mesh that an earlier call
    with the same surface and arguments made on this machine, in the user's folder for caches, so that
    simulations repeat bit by bit; on other machines they do with ``mesh.save("cup.npz")``."""
    surface = _closed_surface(mesh)
    if not given_flag(keep, "tetrahedralise: keep"):
        return _made(surface, edge_length, tolerance)
    arguments = f"{_mesher()} {edge_length!r} {tolerance!r}"
    return kept(surface, arguments, lambda: _made(surface, edge_length, tolerance))


def _made(surface: TriangleMesh, edge_length: float | None, tolerance: float | None) -> TetMesh:
    diagonal = _diagonal(surface)
    if tolerance is not None:
        positive(tolerance, "tetrahedralise: tolerance", "")
    if edge_length is None:
        return _filled(surface, 0.05, 1e-3 if tolerance is None else tolerance)
    fraction = positive(edge_length, "tetrahedralise: edge_length") / diagonal
    if fraction > 1.0:
        raise InvalidArgument(
            f"tetrahedralise: edge_length = {float(edge_length):.6g} m: must be at most the diagonal of "
            f"the bounds of the mesh, {diagonal:.4g} m; give a shorter one, or scale the mesh if "
            f"it is not in metres"
        )
    if tolerance is None:
        # A chord of length l of a surface of radius r is l^2 / 8r off: less tolerance makes shorter edges.
        tolerance = 0.1 * fraction
    return _with_mean_edge(surface, edge_length, fraction, tolerance)


def edge_lengths(mesh: TetMesh | TriangleMesh) -> NDArray[np.float64]:
    """Length of each edge of a mesh [m], each edge once (n,)."""
    if isinstance(mesh, TetMesh):
        pairs = mesh.tets[:, [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]]
    elif isinstance(mesh, TriangleMesh):
        pairs = mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]]
    else:
        raise InvalidMesh(f"edge_lengths: got {type(mesh).__name__}: must be a TetMesh or a TriangleMesh")
    edges = np.unique(np.sort(pairs.reshape(-1, 2), axis=1), axis=0)
    ends = mesh.vertices[edges]
    return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))


def _with_mean_edge(surface: TriangleMesh, wanted: float, fraction: float, tolerance: float) -> TetMesh:
    """The mesh with the best mean edge of up to _TRIES. fTetWild takes what it is asked for as a hint."""
    found: list[tuple[float, TetMesh]] = []  # ratio of the mean edge to the wanted one, mesh
    below, above = 0.0, math.inf  # fractions that gave too short and too long edges
    longest = max(fraction, 2.0 * _COARSE)  # 1 takes a minute, and is the largest that there is
    while len(found) < _TRIES:
        mesh = _filled(surface, fraction, tolerance)
        ratio = _mean_edge(mesh) / wanted
        found.append((ratio, mesh))
        if abs(ratio - 1.0) < _OFF:
            break
        if fraction > _COARSE and len(found) > 1 and ratio < min(1.0, _GROWS * found[-2][0]):
            break  # it is the tolerance that keeps edges short
        below, above = (max(below, fraction), above) if ratio < 1.0 else (below, min(above, fraction))
        fraction /= ratio
        if not below < fraction < above:
            fraction = math.sqrt(below * above)
        fraction = min(fraction, longest)
        if fraction <= below:
            break
    return min(found, key=lambda each: abs(each[0] - 1.0))[1]


def _mean_edge(mesh: TetMesh) -> float:
    return float(edge_lengths(mesh).mean())


def _closed_surface(mesh: Any) -> TriangleMesh:
    surface = as_triangle_mesh(mesh, "tetrahedralise")
    if len(surface.triangles) == 0:
        raise InvalidMesh("tetrahedralise: the mesh has 0 triangles: must be a closed surface")
    if not _core.is_closed(surface.triangles):
        edge = _core.find_boundary_edges(surface.triangles)
        where = f", the first ones {edge[:3].tolist()}" if len(edge) else ""
        raise InvalidMesh(
            f"tetrahedralise: the mesh is open at {len(edge)} edges{where}: must be a closed surface, which "
            f"encloses a volume; close it first"
        )
    return surface


def _mesher() -> str:
    """Name and version of the mesher; the name alone where it is not installed."""
    try:
        return f"pytetwild {version('pytetwild')}"
    except PackageNotFoundError:
        return "pytetwild"


def _filled(surface: TriangleMesh, fraction: float, tolerance: float) -> TetMesh:
    """By fTetWild. ``fraction``: wanted edge length over the diagonal of the bounds."""
    thickness, moves = _mean_thickness(surface), tolerance * _diagonal(surface)
    if moves > 2.0 * thickness:  # of a rod twice its mean thickness across
        raise _too_thin(thickness, moves, fraction)
    try:
        import pytetwild
    except ImportError as error:
        raise ImportError(
            "stark.mesh.tetrahedralise needs pytetwild: pip install 'stark-sim[mesh]'"
        ) from error
    # fTetWild leaves a file in the current folder.
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        try:
            vertices, tets = pytetwild.tetrahedralize(
                surface.vertices, surface.triangles, edge_length_fac=fraction, epsilon=tolerance, quiet=True
            )
        except (ValueError, RuntimeError) as error:
            raise InvalidMesh(
                f"tetrahedralise: fTetWild refuses the surface with edges of {fraction:.3g} and a tolerance "
                f"of {tolerance:.3g} of its diagonal: {error}"
            ) from None
    if len(tets) == 0:
        raise _too_thin(thickness, moves, fraction)
    return compact(oriented(TetMesh(vertices, np.asarray(tets, dtype=np.int32))))


def _diagonal(surface: TriangleMesh) -> float:
    return float(np.linalg.norm(surface.bounds[1] - surface.bounds[0]))


def _mean_thickness(surface: TriangleMesh) -> float:
    """Twice the volume over the area [m]: that of a plate."""
    a, b, c = surface.vertices[surface.triangles].transpose(1, 0, 2)
    area = 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
    return 2.0 * abs(surface.volume) / max(area, np.finfo(float).tiny)


def _too_thin(thickness: float, moves: float, fraction: float) -> InvalidMesh:
    return InvalidMesh(
        f"tetrahedralise: nothing is left of the surface, which may move by {moves:.3g} m and is "
        f"{thickness:.3g} m thick in the mean: must be thicker than twice that; pass a smaller tolerance=, "
        f"which is a tenth of the edge length where you give one (now {fraction:.3g} of the diagonal), or "
        f"make a thin sheet a cloth with flexural_rigidity"
    )

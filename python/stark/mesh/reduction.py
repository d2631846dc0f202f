"""Simpler surfaces of fine ones: fewer triangles, the convex hull, convex parts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stark import _core
from stark._core import InvalidArgument, InvalidMesh
from stark.arguments import real_number
from stark.mesh.arguments import count_of
from stark.mesh.conversion import as_triangle_mesh
from stark.mesh.repair import merged, oriented
from stark.mesh.types import TriangleMesh

#: Diagonal of the bounds that fast-simplification is given: it takes edges in the order of their errors where
#: these are above its thresholds, which are lengths. Of a cylinder of 0.1 m a third of the volume was lost.
_SIZE = 100.0


def simplified(mesh: Any, triangles: int) -> TriangleMesh:
    """About ``triangles`` triangles of a surface, placed by quadric error metrics (Garland and Heckbert
    1997), by fast-simplification (``pip install 'stark-sim[mesh]'``). A surface that has no more is given
    back. Flat triangles and edges of three may come of it: ``cleaned`` repairs them.

    Raises InvalidArgument for counts below 4, ImportError without the package."""
    surface = as_triangle_mesh(mesh, "simplified")
    count = count_of(triangles, "simplified: triangles", 4)
    if len(surface.triangles) <= count:
        return surface
    try:
        import fast_simplification
    except ImportError as error:
        raise ImportError(
            "stark.mesh.simplified needs fast-simplification: pip install 'stark-sim[mesh]'"
        ) from error
    low, high = surface.bounds
    middle, size = (low + high) / 2.0, float(np.linalg.norm(high - low))
    scale = _SIZE / size if size > 0.0 else 1.0
    vertices, faces = fast_simplification.simplify(
        np.ascontiguousarray((surface.vertices - middle) * scale), surface.triangles, target_count=count
    )
    return TriangleMesh(
        np.asarray(vertices, dtype=np.float64) / scale + middle, np.asarray(faces, dtype=np.int32)
    )


def convex_hull(mesh: Any) -> TriangleMesh:
    """The convex hull of the vertices of a mesh, or of points (n, 3) [m], by manifold3d
    (``pip install 'stark-sim[mesh]'``).

    Raises InvalidMesh for points that lie in a plane, ImportError without the package."""
    points = mesh if isinstance(mesh, np.ndarray) else mesh.vertices if hasattr(mesh, "vertices") else mesh
    try:
        import manifold3d
    except ImportError as error:
        raise ImportError("stark.mesh.convex_hull needs manifold3d: pip install 'stark-sim[mesh]'") from error
    try:
        given = np.asarray(points, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InvalidMesh(
            f"convex_hull: got {type(mesh).__name__}: must be a mesh or points (n, 3) [m]; files are read by "
            f"stark.mesh.load(path)"
        ) from None
    if given.ndim != 2 or given.shape[1] != 3 or not np.isfinite(given).all():
        raise InvalidMesh(f"convex_hull: got the shape {given.shape}: must be finite points (n, 3) [m]")
    # About their middle: manifold3d drops what is small beside the distance from the origin.
    middle = (given.min(axis=0) + given.max(axis=0)) / 2.0 if len(given) else np.zeros(3)
    hull = manifold3d.Manifold.hull_points(given - middle).to_mesh64()
    spread = np.linalg.svd(given - given.mean(axis=0), compute_uv=False)
    if len(hull.tri_verts) == 0 or spread[-1] <= 1e-12 * spread[0]:
        raise InvalidMesh(f"convex_hull: the {len(given)} points enclose no volume: must not lie in a plane")
    return TriangleMesh(
        np.asarray(hull.vert_properties)[:, :3] + middle, np.asarray(hull.tri_verts).astype(np.int32)
    )


def convex_parts(
    mesh: Any, *, concavity: float = 0.05, largest_count: int | None = None
) -> list[TriangleMesh]:
    """Convex parts that together are about a closed surface, by CoACD (Wei et al. 2022; ``pip install
    'stark-sim[mesh]'``), the same at every call. ``concavity`` is how far parts may be from convex, over the
    size of the surface, in [0.01, 1]; ``largest_count`` bounds their number. Parts overlap a little or touch:
    as one rigid body they are ``joined``.

    Raises InvalidMesh for open surfaces, InvalidArgument for values out of range, ImportError without the
    package."""
    surface = merged(as_triangle_mesh(mesh, "convex_parts"))
    threshold = real_number(concavity, "convex_parts: concavity")
    if not 0.01 <= threshold <= 1.0 or not math.isfinite(threshold):
        raise InvalidArgument(f"convex_parts: concavity = {concavity!r}: must be in [0.01, 1]")
    most = -1 if largest_count is None else count_of(largest_count, "convex_parts: largest_count")
    if len(surface.triangles) == 0 or not _core.is_closed(surface.triangles):
        raise InvalidMesh(
            "convex_parts: the mesh is open or empty: must be a closed surface; cleaned() closes it"
        )
    try:
        import coacd
    except ImportError as error:
        raise ImportError("stark.mesh.convex_parts needs coacd: pip install 'stark-sim[mesh]'") from error
    coacd.set_log_level("error")
    found = coacd.run_coacd(
        coacd.Mesh(surface.vertices, surface.triangles), threshold=threshold, max_convex_hull=most, seed=1
    )
    return [
        oriented(TriangleMesh(np.asarray(vertices, dtype=np.float64), np.asarray(faces, dtype=np.int32)))
        for vertices, faces in found
    ]

"""Meshes of a randomised mesher, kept on disk: the same surface and arguments give the same mesh, in later
processes as well, so that simulations repeat and resume bit by bit."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Callable
from pathlib import Path

from stark._core import InvalidMesh
from stark.mesh.files import load
from stark.mesh.types import TetMesh, TriangleMesh

#: Files that are kept; the ones longest unused go first.
_MOST = 64


def kept(surface: TriangleMesh, arguments: str, make: Callable[[], TetMesh]) -> TetMesh:
    """The mesh that was kept for ``surface`` and ``arguments``, else that of ``make()``, which is kept from
    now on. Where no file can be written, nothing is kept."""
    path = _file(surface, arguments)
    if path is None:
        return make()
    with contextlib.suppress(InvalidMesh, OSError):
        if path.is_file():
            mesh = load(path)
            path.touch()
            if isinstance(mesh, TetMesh):
                return mesh
    mesh = make()
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        mesh.save(path)
        _forget_old(path.parent)
    return mesh


def folder() -> Path | None:
    """Where meshes are kept: ``stark/meshes`` in the user's folder for caches, as platformdirs finds it."""
    try:
        from platformdirs import user_cache_path
    except ImportError:
        return None
    caches: Path = user_cache_path("stark")
    return caches / "meshes"


def _file(surface: TriangleMesh, arguments: str) -> Path | None:
    place = folder()
    if place is None:
        return None
    digest = hashlib.sha256(arguments.encode())
    for array in (surface.vertices, surface.triangles):
        digest.update(f"{array.dtype.str}{array.shape}".encode())
        digest.update(array.tobytes())
    return place / f"{digest.hexdigest()}.npz"


def _forget_old(place: Path) -> None:
    by_age = sorted(place.glob("*.npz"), key=lambda path: path.stat().st_mtime, reverse=True)
    for path in by_age[_MOST:]:
        path.unlink(missing_ok=True)

"""Surfaces of USD files, at rest or as they move: characters, obstacles, what was exported. In metres, z up.
[openusd.org: UsdGeom, UsdSkel]"""

from __future__ import annotations

import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidMesh
from stark.mesh.arguments import Indices
from stark.mesh.polygons import triangulated
from stark.mesh.types import TriangleMesh

Floats = NDArray[np.float64]

SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")
#: Turns points as rows from stages with that axis up.
_UP = {
    "Z": np.eye(3),
    "Y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
}


class UsdSurface(NamedTuple):
    """The meshes of a file as one surface, vertices of one after those of the other."""

    times: Floats
    """(k,), from 0 on [s]; one for what does not move."""
    frames: Floats
    """(k, n, 3), in the world [m]."""
    triangles: Indices
    parts: dict[str, Indices]
    """Triangles of each mesh, by the name of its prim."""

    @property
    def mesh(self) -> TriangleMesh:
        """As it starts."""
        return TriangleMesh(self.frames[0], self.triangles)

    @property
    def surface_and_parts(self) -> tuple[TriangleMesh, dict[str, Indices]]:
        """As of other files."""
        return self.mesh, self.parts


def read_usd(file: Path, below: str | None = None, *, moving: bool = False) -> UsdSurface:
    """All meshes of a file, or those at and below the prim with this path; ``moving``: with all frames.
    Raises InvalidMesh for files and prims that cannot be read, ImportError without usd-core."""
    reader = _Reader(file)
    meshes = reader.meshes(below)
    codes: list[Any] = (reader.codes(meshes) if moving else []) or [reader.start]
    triangles, parts, first = [np.empty((0, 3), np.int64)], {}, 0
    frames = np.concatenate([reader.points(mesh, codes) for mesh in meshes], axis=1)
    for mesh in meshes:
        own = reader.triangles(mesh)
        before = sum(map(len, triangles))
        parts[reader.name(mesh, meshes)] = np.arange(before, before + len(own), dtype=np.int32)
        triangles.append(own + first)
        first += reader.point_count(mesh)
    times = np.zeros(1) if len(codes) == 1 else (np.array(codes) - codes[0]) / reader.rate
    return UsdSurface(times, frames, np.concatenate(triangles).astype(np.int32), parts)


def without_unused(surface: UsdSurface) -> UsdSurface:
    """Vertices that are at the same place in all frames as one, and none that no triangle uses: what a cloth
    is made of. Closed surfaces keep all that they use."""
    keys = np.ascontiguousarray(surface.frames.transpose(1, 0, 2)).reshape(surface.frames.shape[1], -1)
    if surface.mesh.is_closed:
        keys = np.arange(len(keys), dtype=np.float64)[:, None]
    _, first, same = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    triangles = first[same.reshape(-1)][surface.triangles]
    a, b, c = triangles.T
    kept = (a != b) & (b != c) & (c != a)
    used, rows = np.unique(triangles[kept], return_inverse=True)
    numbers = np.cumsum(kept) - 1
    parts = {name: numbers[own[kept[own]]].astype(np.int32) for name, own in surface.parts.items()}
    corners = rows.reshape(-1, 3).astype(np.int32)
    return UsdSurface(surface.times, surface.frames[:, used], corners, parts)


class _Reader:
    def __init__(self, file: Path) -> None:
        self.source = f"'{file}'"
        self.pxr = _pxr(self.source)
        try:
            self.stage: Any = self.pxr.Usd.Stage.Open(os.fspath(file))
        except self.pxr.Tf.ErrorException as error:
            first = str(error).strip().splitlines()[-1].rpartition(" : ")[2]
            raise InvalidMesh(f"{self.source}: USD cannot read it: {first}") from None
        geometry = self.pxr.UsdGeom
        self.rate = float(self.stage.GetTimeCodesPerSecond())
        self._turn = _UP[str(geometry.GetStageUpAxis(self.stage))] * float(
            geometry.GetStageMetersPerUnit(self.stage)
        )
        self.start = self.pxr.Usd.TimeCode.EarliestTime()
        self._bake()

    def _bake(self) -> None:
        """Skins of skeletons get the points that they have, in a layer that is not saved."""
        stage = self.stage
        prims = self.pxr.Usd.PrimRange(stage.GetPseudoRoot())
        if any(prim.IsA(self.pxr.UsdSkel.Root) for prim in prims):
            stage.SetEditTarget(self.pxr.Usd.EditTarget(stage.GetSessionLayer()))
            self.pxr.UsdSkel.BakeSkinning(stage.Traverse())

    def meshes(self, below: str | None) -> list[Any]:
        """Those that are to be seen and have faces."""
        root = self.stage.GetPseudoRoot()
        if below is not None:
            is_path = self.pxr.Sdf.Path.IsValidPathString(below)
            root = self.stage.GetPrimAtPath(below) if is_path and below.startswith("/") else None
            if not root:
                raise InvalidMesh(
                    f"{self.source}: has no prim '{below}': must be a path, such as one of "
                    f"{', '.join(self._paths()[:5]) or 'those of its meshes, of which it has none'}"
                )
        geometry, proxies = self.pxr.UsdGeom, self.pxr.Usd.TraverseInstanceProxies()
        found = [
            geometry.Mesh(prim) for prim in self.pxr.Usd.PrimRange(root, proxies) if prim.IsA(geometry.Mesh)
        ]
        shown = [
            mesh
            for mesh in found
            if mesh.ComputeVisibility(self.start) != geometry.Tokens.invisible
            and mesh.ComputePurpose() != geometry.Tokens.guide
            and len(self._value(mesh.GetFaceVertexCountsAttr()))
        ]
        if not shown:
            where = "" if below is None else f" at or below '{below}'"
            raise InvalidMesh(
                f"{self.source}: no mesh{where} has faces and is visible: must have at least one"
            )
        return shown

    def _paths(self) -> list[str]:
        prims = self.pxr.Usd.PrimRange(self.stage.GetPseudoRoot(), self.pxr.Usd.TraverseInstanceProxies())
        return [str(prim.GetPath()) for prim in prims if prim.IsA(self.pxr.UsdGeom.Mesh)]

    def name(self, mesh: Any, others: list[Any]) -> str:
        """Of its prim, or its path where several have that name."""
        own = str(mesh.GetPrim().GetName())
        alone = [other.GetPrim().GetName() for other in others].count(own) == 1
        return own if alone else str(mesh.GetPath())

    def codes(self, meshes: list[Any]) -> list[float]:
        """Times at which points or frames of any of them are given."""
        found: set[float] = set()
        for mesh in meshes:
            found.update(mesh.GetPointsAttr().GetTimeSamples())
            prim = mesh.GetPrim()
            while prim and not prim.IsPseudoRoot():
                placed = self.pxr.UsdGeom.Xformable(prim)
                if placed:
                    found.update(placed.GetTimeSamples())
                prim = prim.GetParent()
        return sorted(found)

    def point_count(self, mesh: Any) -> int:
        return len(self._value(mesh.GetPointsAttr()))

    def points(self, mesh: Any, codes: list[Any]) -> Floats:
        """(k, n, 3), in the world [m]."""
        count, frames = self.point_count(mesh), []
        for code in codes:
            time = self.pxr.Usd.TimeCode(code)
            points = np.array(mesh.GetPointsAttr().Get(time), dtype=np.float64).reshape(-1, 3)
            if len(points) != count or not np.isfinite(points).all():
                raise InvalidMesh(
                    f"{self.source}: {mesh.GetPath()} has {len(points)} points at the time code {code}: "
                    f"must be {count} finite ones, as at the start"
                )
            matrix = np.array(self.pxr.UsdGeom.XformCache(time).GetLocalToWorldTransform(mesh.GetPrim()))
            frames.append((points @ matrix[:3, :3] + matrix[3, :3]) @ self._turn)
        return np.array(frames)

    def triangles(self, mesh: Any) -> NDArray[np.int64]:
        """Counter-clockwise seen from outside."""
        points = np.array(self._value(mesh.GetPointsAttr()), dtype=np.float64).reshape(-1, 3)
        counts = np.array(self._value(mesh.GetFaceVertexCountsAttr()), dtype=np.int64)
        corners = np.array(self._value(mesh.GetFaceVertexIndicesAttr()), dtype=np.int64)
        fits = counts.sum() == len(corners) and counts.min() >= 3
        if not fits or not 0 <= corners.min() <= corners.max() < len(points):
            raise InvalidMesh(
                f"{self.source}: {mesh.GetPath()}: faceVertexIndices do not fit faceVertexCounts and points"
            )
        found = triangulated(points, counts, corners, lambda k: f"{self.source}: {mesh.GetPath()}: face {k}")
        matrix = np.array(self.pxr.UsdGeom.XformCache(self.start).GetLocalToWorldTransform(mesh.GetPrim()))
        is_left = str(self._value(mesh.GetOrientationAttr())) == "leftHanded"
        return found[:, ::-1] if is_left != (np.linalg.det(matrix[:3, :3]) < 0.0) else found

    def _value(self, attribute: Any) -> Any:
        """At the start; nothing where it is not given."""
        found = attribute.Get(self.start)
        return () if found is None else found


def _pxr(source: str) -> Any:
    """The modules of USD."""
    try:
        from pxr import Sdf, Tf, Usd, UsdGeom, UsdSkel
    except ImportError as error:
        raise ImportError(f"{source}: USD files need usd-core: pip install 'stark-sim[usd]'") from error
    return SimpleNamespace(Sdf=Sdf, Tf=Tf, Usd=Usd, UsdGeom=UsdGeom, UsdSkel=UsdSkel)

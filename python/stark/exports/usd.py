"""Universal Scene Description: one mesh a body, moving points of what deforms, moving frames of rigid bodies.
[https://openusd.org, UsdGeom]"""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import numpy as np

from stark.array_file import naming, refuse_special
from stark.body_kinds import has_pose
from stark.files import printable
from stark.render.colormaps import linear
from stark.rotations import to_quaternion

from .shots import Array, Shot, pose_between

_MISSING = "USD needs the package usd-core of the extra 'usd': pip install 'stark-sim[usd]'"


class UsdWriter:
    """Writes a stage of shots: Z up, or Y where gravity says so, metres, time codes of ``fps`` a second."""

    def __init__(self, path: Path, fps: float) -> None:
        try:
            from pxr import Gf, Sdf, Tf, Usd, UsdGeom, Vt
        except ImportError as error:
            raise ImportError(_MISSING) from error
        self._gf, self._sdf, self._tf, self._geom, self._vt = Gf, Sdf, Tf, UsdGeom, Vt
        self._path, self._fps = path, fps
        with naming(path):
            refuse_special(path)
        self._temporary = path.with_name(f".{path.stem}.{os.getpid()}.tmp{path.suffix}")
        self._temporary.unlink(missing_ok=True)
        self._stage: Any = Usd.Stage.CreateInMemory()
        UsdGeom.SetStageMetersPerUnit(self._stage, 1.0)
        self._stage.SetTimeCodesPerSecond(fps)
        self._stage.SetFramesPerSecond(fps)
        self._stage.SetDefaultPrim(UsdGeom.Xform.Define(self._stage, "/World").GetPrim())
        self._meshes: list[Any] = []
        self._starts: list[Array] = []
        self._last: list[Array] = []
        self._ops: dict[int, tuple[Any, Any]] = {}

    def add(self, shot: Shot) -> None:
        """Adds time samples."""
        code = shot.time * self._fps
        if not self._meshes:
            self._stage.SetStartTimeCode(code)
            tokens = self._geom.Tokens
            self._geom.SetStageUpAxis(self._stage, tokens.y if shot.up == (0.0, 1.0, 0.0) else tokens.z)
            self._define(shot)
        self._stage.SetEndTimeCode(code)
        for k, body in enumerate(shot.bodies):
            if k in self._ops:
                self._place(k, body.positions, code)
            elif not np.array_equal(self._last[k], body.positions) or code == self._stage.GetStartTimeCode():
                self._set_points(k, body.positions, None if body.motion == "fixed" else code)
            self._last[k] = body.positions
        for name, values in shot.fields.items():
            self._set_field(name, values, shot, code)

    def finish(self) -> list[Path]:
        """Moves the file into place."""
        with naming(self._path):
            try:
                self._export()
                os.replace(self._temporary, self._path)
            finally:
                self._temporary.unlink(missing_ok=True)
        return [self._path]

    def abandon(self) -> None:
        """Leaves nothing behind."""
        self._temporary.unlink(missing_ok=True)

    # --- details ---

    def _export(self) -> None:
        """Raises OSError where the file cannot be written; USD keeps the reason for itself."""
        try:
            done = self._stage.GetRootLayer().Export(str(self._temporary))
        except self._tf.ErrorException:
            done = False
        if not done:
            raise OSError(errno.EIO, "USD gives up, as it does where a disk is full")

    def _define(self, shot: Shot) -> None:
        taken: set[str] = set()
        for k, (body, color) in enumerate(zip(shot.bodies, shot.colors, strict=True)):
            name = base = self._tf.MakeValidIdentifier(body.name)
            count = 1
            while name in taken:
                count += 1
                name = f"{base}_{count}"
            taken.add(name)
            mesh = self._geom.Mesh.Define(self._stage, f"/World/{name}")
            mesh.GetPrim().SetDisplayName(printable(body.name))
            mesh.GetPrim().SetCustomDataByKey("stark:kind", body.kind)
            mesh.CreateSubdivisionSchemeAttr(self._geom.Tokens.none)
            mesh.CreateDoubleSidedAttr(True)
            counts = np.full(len(body.triangles), 3, dtype=np.int32)
            mesh.CreateFaceVertexCountsAttr(self._vt.IntArray.FromNumpy(counts))
            mesh.CreateFaceVertexIndicesAttr(self._vt.IntArray.FromNumpy(body.triangles.ravel()))
            shade = np.asarray(linear(color), dtype=np.float32).reshape(1, 3)  # colours of USD are linear
            mesh.CreateDisplayColorAttr(self._vt.Vec3fArray.FromNumpy(shade))
            self._meshes.append(mesh)
            self._starts.append(body.positions)
            self._last.append(body.positions)
            if has_pose(body) and body.motion != "fixed":
                # About its middle: what players show between two samples then turns in place.
                self._starts[k] = body.positions - np.mean(body.positions, axis=0, dtype=np.float64)
                self._set_points(k, self._starts[k], None)
                self._ops[k] = (
                    mesh.AddTranslateOp(self._geom.XformOp.PrecisionDouble),
                    mesh.AddOrientOp(self._geom.XformOp.PrecisionDouble),
                )

    def _place(self, k: int, positions: Array, code: float) -> None:
        """Points of rigid bodies are those of the first shot about their middle; this is where it is."""
        position, rotation = pose_between(self._starts[k], positions)
        w, x, y, z = map(float, to_quaternion(rotation))
        translate, orient = self._ops[k]
        translate.Set(self._gf.Vec3d(*map(float, position)), code)
        orient.Set(self._gf.Quatd(w, x, y, z), code)

    def _set_points(self, k: int, positions: Array, code: float | None) -> None:
        points = self._vt.Vec3fArray.FromNumpy(np.ascontiguousarray(positions, dtype=np.float32))
        extent = np.array([positions.min(axis=0), positions.max(axis=0)], dtype=np.float32)
        box, mesh = self._vt.Vec3fArray.FromNumpy(extent), self._meshes[k]
        at = () if code is None else (code,)
        mesh.CreatePointsAttr().Set(points, *at)
        mesh.CreateExtentAttr().Set(box, *at)

    def _set_field(self, name: str, values: Any, shot: Shot, code: float) -> None:
        for mesh, body in zip(self._meshes, shot.bodies, strict=True):
            if body.name not in values:
                continue
            numbers = np.ascontiguousarray(values[body.name], dtype=np.float32)
            kinds = self._sdf.ValueTypeNames
            kind = kinds.FloatArray if numbers.ndim == 1 else kinds.Vector3fArray
            variable = self._geom.PrimvarsAPI(mesh).CreatePrimvar(name, kind, self._geom.Tokens.vertex)
            array = self._vt.FloatArray if numbers.ndim == 1 else self._vt.Vec3fArray
            variable.Set(array.FromNumpy(numbers), code)
            if name == "velocity" and not has_pose(body):  # what renderers blur moving points by
                mesh.CreateVelocitiesAttr().Set(array.FromNumpy(numbers), code)

"""Stages of USD in metres and kilograms, z up: frames, bodies and shapes of prims. [openusd.org: UsdGeom,
UsdPhysics]"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark import mesh as meshes
from stark._core import InvalidArgument, InvalidMesh
from stark.mesh.polygons import triangulated
from stark.robots.description import Geometry
from stark.robots.report import Report

Floats = NDArray[np.float64]

_MISSING = "USD files need usd-core: pip install 'stark-sim[usd]'"
#: Turns stages with that axis up.
_UP = {
    "Z": np.eye(3),
    "Y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
}
#: Turns z to the axis of a cylinder or capsule.
_TURNS = {
    "X": np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]),
    "Y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
    "Z": np.eye(3),
}
_CONE_SIDES = 32
#: Relative difference up to which numbers of a file are the same, which has single precision.
SAME = 1e-4
_EQUAL = 1e-5  # scales that differ by less are one; USD has them in single precision


def load_pxr(file: Path) -> Any:
    """The modules of USD that readers use."""
    try:
        from pxr import Gf, Tf, Usd, UsdGeom, UsdPhysics, UsdShade
    except ImportError as error:
        raise ImportError(f"'{file}': {_MISSING}") from error
    return SimpleNamespace(Gf=Gf, Tf=Tf, Usd=Usd, UsdGeom=UsdGeom, UsdPhysics=UsdPhysics, UsdShade=UsdShade)


def unique_names(prims: list[Any]) -> list[str]:
    """Names of prims, or paths where two have the same."""
    names = [str(prim.GetName()) for prim in prims]
    return [
        name if names.count(name) == 1 else str(prim.GetPath())[1:].replace("/", "_")
        for prim, name in zip(prims, names, strict=True)
    ]


def applied(prim: Any) -> list[str]:
    """Names of the schemas of a prim, those that USD does not know included."""
    return [str(name) for name in prim.GetPrimTypeInfo().GetAppliedAPISchemas()]


def value_of(prim: Any, name: str, otherwise: Any = None) -> Any:
    """Of an attribute, which the prim need not have."""
    attribute = prim.GetAttribute(name)
    found = attribute.Get() if attribute else None
    return otherwise if found is None else found


@dataclass(frozen=True, eq=False)
class Frame:
    """Where a prim stands: ``position`` [m], ``rotation``, and ``scale`` (3, 3), which takes coordinates of
    the prim, in units of the stage, to metres along the axes of the frame."""

    position: Floats
    rotation: Floats
    scale: Floats

    def of_point(self, point: Any) -> Floats:
        """A point of the prim, in the world [m]."""
        return np.asarray(self.position + self.rotation @ self.scale @ np.array(point, dtype=np.float64))


def turn(quaternion: Any) -> Floats:
    """Rotation matrix of a quaternion of USD, which need not have length 1."""
    w, x, y, z = np.array([quaternion.GetReal(), *quaternion.GetImaginary()], dtype=np.float64)
    n = w * w + x * x + y * y + z * z
    if not n > 0.0:
        return np.eye(3)
    rows = [
        [n - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), n - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), n - 2 * (x * x + y * y)],
    ]
    rotation: Floats = np.array(rows) / n
    return rotation


class Stage:
    """A stage with its units. Errors name the file and the prim."""

    def __init__(self, file: Path) -> None:
        self.pxr: Any = load_pxr(file)
        self.report: Report = Report(f"'{file}'")
        try:
            self.usd: Any = self.pxr.Usd.Stage.Open(os.fspath(file))
        except self.pxr.Tf.ErrorException as error:
            first = str(error).strip().splitlines()[-1].strip()
            raise InvalidArgument(f"'{file}': USD cannot read it: {first}; correct it") from None
        geom, physics = self.pxr.UsdGeom, self.pxr.UsdPhysics
        self.metre: float = float(geom.GetStageMetersPerUnit(self.usd))
        self.kilogram: float = float(physics.GetStageKilogramsPerUnit(self.usd))
        self.up: Floats = _UP[str(geom.GetStageUpAxis(self.usd))]
        #: What is animated starts as its first frame has it.
        self._start: Any = self.pxr.Usd.TimeCode.EarliestTime()
        self._cache = geom.XformCache(self._start)

    def prims(self) -> list[Any]:
        """All prims that are there, those of instances included, in the order of the file."""
        return list(self.pxr.Usd.PrimRange(self.usd.GetPseudoRoot(), self.pxr.Usd.TraverseInstanceProxies()))

    def frame(self, prim: Any, *, of_body: bool = False) -> Frame:
        """Of a prim in the world. Bodies must have no shear and no mirror."""
        matrix = np.array(self._cache.GetLocalToWorldTransform(prim), dtype=np.float64)
        axes = self.up @ matrix[:3, :3].T
        lengths = np.linalg.norm(axes, axis=0)
        if not (lengths > 0.0).all():
            raise InvalidArgument(
                f"{self.report.source}: {prim.GetPath()}: has a scale of 0: must be positive"
            )
        rotation = axes / lengths
        if np.linalg.det(rotation) < 0.0 and not of_body:
            rotation[:, 0] *= -1.0  # of a mirrored shape; the scale mirrors
        sheared = not np.allclose(rotation.T @ rotation, np.eye(3), atol=1e-4)
        if of_body and (sheared or np.linalg.det(rotation) < 0.0):
            raise InvalidArgument(
                f"{self.report.source}: body {prim.GetPath()}: is sheared or mirrored: must have "
                f"translation, rotation and positive scales only; apply the rest to its meshes"
            )
        left, _, right = np.linalg.svd(rotation)
        rotation = left @ right  # what single precision left of it
        scale = rotation.T @ axes * self.metre
        return Frame(self.metre * (self.up @ matrix[3, :3]), rotation, scale)

    def shape(self, prim: Any, body: Frame, title: str) -> Geometry | None:
        """That of a prim, in the frame of its body; None for what has none, which the report says."""
        kind, geom = str(prim.GetTypeName()), self.pxr.UsdGeom
        if kind == "Plane":
            self.report.add("dropped", title, "a plane: add a floor or a mesh to the scene")
        if kind not in ("Cube", "Sphere", "Cylinder", "Capsule", "Cone", "Mesh"):
            return None
        frame = self.frame(prim)
        place: dict[str, Any] = {
            "position": body.rotation.T @ (frame.position - body.position),
            "rotation": body.rotation.T @ frame.rotation,
            "color": self.color(prim),
        }
        if kind == "Mesh":
            return self._mesh(geom.Mesh(prim), frame, place, title)
        return self._primitive(kind, prim, frame, place)

    def _primitive(self, kind: str, prim: Any, frame: Frame, place: dict[str, Any]) -> Geometry:
        scales = np.abs(np.diag(frame.scale))
        is_even = np.abs(frame.scale - np.diag(np.diag(frame.scale))).max() < _EQUAL * scales.max()

        def value(name: str) -> float:
            return float(prim.GetAttribute(name).Get(self._start))

        if kind == "Cube":
            edge = value("size")
            if is_even:
                return Geometry("box", tuple(float(edge * s) for s in scales), **place)
            return _of_mesh(meshes.box(edge), frame.scale, place)
        if kind == "Sphere":
            if is_even and np.ptp(scales) < _EQUAL * scales.max():
                return Geometry("sphere", (value("radius") * float(scales.mean()),), **place)
            return _of_mesh(meshes.sphere(value("radius")), frame.scale, place)
        axis, radius, height = str(prim.GetAttribute("axis").Get()), value("radius"), value("height")
        turned = _TURNS[axis]
        along = np.abs(turned.T @ scales)  # about x, y and z of the shape
        if kind != "Cone" and is_even and abs(along[0] - along[1]) < _EQUAL * along.max():
            even = kind == "Cylinder" or abs(along[2] - along[0]) < _EQUAL * along.max()
            if even:
                size = (radius * float(along[:2].mean()), height * float(along[2]))
                return Geometry(kind.lower(), size, **place | {"rotation": place["rotation"] @ turned})
        made = {"Cylinder": meshes.cylinder, "Capsule": meshes.capsule, "Cone": _cone}[kind](radius, height)
        return _of_mesh(made, frame.scale @ turned, place)

    def _mesh(self, mesh: Any, frame: Frame, place: dict[str, Any], title: str) -> Geometry | None:
        points = np.array(mesh.GetPointsAttr().Get(self._start) or [], dtype=np.float64).reshape(-1, 3)
        counts = np.array(mesh.GetFaceVertexCountsAttr().Get(self._start) or [], dtype=np.int64)
        corners = np.array(mesh.GetFaceVertexIndicesAttr().Get(self._start) or [], dtype=np.int64)
        owner = f"{self.report.source}: {title}: mesh {mesh.GetPath()}"
        if counts.sum() != len(corners) or (
            len(corners) and not 0 <= corners.min() <= corners.max() < len(points)
        ):
            raise InvalidMesh(
                f"{owner}: faceVertexIndices do not fit faceVertexCounts and points; correct it"
            )
        if len(corners) == 0:
            self.report.add("dropped", title, f"mesh {mesh.GetPath()}, which has no faces")
            return None
        triangles = triangulated(points, counts, corners, lambda k: f"{owner}: face {k}")
        is_left = str(mesh.GetOrientationAttr().Get()) == "leftHanded"
        surface = meshes.TriangleMesh(points, triangles[:, ::-1] if is_left else triangles)
        return _of_mesh(surface, frame.scale, place)

    def color(self, prim: Any) -> tuple[float, float, float] | None:
        """That of a prim, red, green and blue from 0 to 1."""
        colors = self.pxr.UsdGeom.Gprim(prim).GetDisplayColorAttr().Get(self._start)
        if not colors:
            return None
        r, g, b = (min(1.0, max(0.0, float(value))) for value in colors[0])
        return r, g, b


def _of_mesh(surface: meshes.TriangleMesh, scale: Floats, place: dict[str, Any]) -> Geometry:
    triangles = surface.triangles if np.linalg.det(scale) > 0.0 else surface.triangles[:, ::-1]
    return Geometry("mesh", vertices=surface.vertices @ scale.T, triangles=triangles, **place)


def _cone(radius: float, height: float) -> meshes.TriangleMesh:
    """About z, its tip at half of the height."""
    angles = np.linspace(0.0, 2.0 * np.pi, _CONE_SIDES, endpoint=False)
    rim = np.stack(
        [radius * np.cos(angles), radius * np.sin(angles), np.full(_CONE_SIDES, -height / 2)], axis=1
    )
    vertices = np.vstack([rim, [[0.0, 0.0, -height / 2], [0.0, 0.0, height / 2]]])
    here, after = np.arange(_CONE_SIDES), np.roll(np.arange(_CONE_SIDES), -1)
    base = np.stack([after, here, np.full(_CONE_SIDES, _CONE_SIDES)], axis=1)
    side = np.stack([here, after, np.full(_CONE_SIDES, _CONE_SIDES + 1)], axis=1)
    return meshes.TriangleMesh(vertices, np.vstack([base, side]).astype(np.int32))

"""Deformable bodies of USD files, by the names of a proposal that no release of USD has yet."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.mesh import Polyline, TetMesh, TriangleMesh, oriented
from stark.robots.description import Flex
from stark.robots.usd_curves import Curves
from stark.robots.usd_stage import SAME, Frame, Stage, applied, unique_names, value_of

Floats = NDArray[np.float64]
Cells = NDArray[np.int32]

#: The version of the proposal whose names are read: pull request 111 of
#: github.com/PixarAnimationStudios/OpenUSD-proposals, at this commit.
PROPOSAL = "OpenUSD-proposals 111 at 584939b"

#: Schema of deformable bodies.
DEFORMABLE = "PhysicsDeformableBodyAPI"
_GEOMETRIES = {
    "TetMesh": "PhysicsVolumeDeformableSimAPI",
    "Mesh": "PhysicsSurfaceDeformableSimAPI",
    "BasisCurves": "PhysicsCurvesDeformableSimAPI",
}
#: What the proposal assumes where a file says nothing.
_MODULUS, _RATIO, _DENSITY, _THICKNESS = 1e6, 0.3, 1000.0, 1e-3  # [Pa], [1], [kg/m^3], [m]
_ONE_LINK = "only points that hang at one link; use scene.attach"


@dataclass(frozen=True, eq=False)
class Owner:
    """A link of the robot and where the file places it."""

    link: str
    position: Floats
    rotation: Floats

    def local(self, points: Floats) -> Floats:
        found: Floats = (points - self.position) @ self.rotation
        return found


def read_deformables(
    stage: Stage, prims: list[Any], base: Owner, owner_of: Callable[[Any], Owner | None]
) -> list[Flex]:
    """All of a stage: cloth, solids and rods. ``owner_of``: the link that a prim is part of, that of the
    world included; None where the robot has none there."""
    roots = [prim for prim in prims if DEFORMABLE in applied(prim)]
    names = unique_names(roots)
    reader = _Reader(stage, base, owner_of, _attachments(prims), set(names))
    return [flex for prim, name in zip(roots, names, strict=True) for flex in reader.read(prim, name)]


def _attachments(prims: list[Any]) -> list[Any]:
    return [
        prim
        for prim in prims
        if str(prim.GetTypeName()) == "PhysicsAttachment"
        and value_of(prim, "physics:attachmentEnabled", True) is not False
    ]


class _Reader:
    def __init__(
        self,
        stage: Stage,
        base: Owner,
        owner_of: Callable[[Any], Owner | None],
        attachments: list[Any],
        taken: set[str],
    ) -> None:
        self.stage, self.report, self.pxr = stage, stage.report, stage.pxr
        self.base, self.owner_of, self.attachments, self.taken = base, owner_of, attachments, taken

    def read(self, prim: Any, name: str) -> list[Flex]:
        """A cloth or a solid, or a rod for each curve; nothing where the body is off."""
        title = f"deformable '{name}'"
        geometry = self._geometry(prim, title)
        kind = str(geometry.GetTypeName())
        if value_of(prim, "physics:bodyEnabled", True) is False:
            self.report.add("dropped", title, "bodyEnabled is false")
            return []
        if kind == "BasisCurves" and str(value_of(geometry, "wrap", "")) == "periodic":
            self._refuse(
                title,
                "wrap is periodic: must be nonperiodic, as rods have two ends; make it so, or leave "
                "the curve out by physics:bodyEnabled = false",
            )
        if value_of(prim, "physics:kinematicEnabled", False):
            self.report.add("dropped", title, "kinematicEnabled: it moves as the others do")
        self.report.add("kept", title, f"as of {PROPOSAL}")
        if kind == "BasisCurves":
            return self._rods(prim, geometry, name, title)
        return [self._sheet_or_solid(prim, geometry, name, title)]

    def _sheet_or_solid(self, prim: Any, geometry: Any, name: str, title: str) -> Flex:
        kind = str(geometry.GetTypeName())
        start = self._points(geometry, "points", title)
        cells = self._cells(geometry, kind, len(start), title)
        rest, is_moved = self._rest(geometry, start, title)
        owner, held = self._held(self._holds(geometry, len(start), title), slice(0, len(start)), title)
        thickness = self._thickness(geometry, title) if kind == "Mesh" else 0.0
        material = self._material(geometry, title)
        young, rigidity = self._stiffness(material, kind, thickness, title)
        return Flex(
            name,
            owner.link,
            owner.local(rest),
            cells,
            mass=self._mass(prim, geometry, material, _volume(rest, cells, thickness), title),
            held=held,
            youngs_modulus=young,
            poissons_ratio=self._number(material, "physics:poissonsRatio", _RATIO, -1.0, 0.5, title),
            thickness=thickness,
            flexural_rigidity=rigidity,
            start=owner.local(start) if is_moved else None,
            folds_at_rest=str(value_of(geometry, "physics:restBendAnglesDefault", "flat")) == "restShape",
            velocity=self._velocity(geometry, owner, title),
            touches=self._touches(prim, geometry, title),
            color=self.stage.color(geometry),
        )

    def _rods(self, prim: Any, geometry: Any, name: str, title: str) -> list[Flex]:
        start = self._points(geometry, "points", title)
        curves = Curves(self.stage, geometry, len(start), title)
        curves.lengths(start)  # refuses points that coincide
        rest, is_moved = self._rest(geometry, start, title)
        diameters, material = curves.diameters(), self._material(geometry, title)
        volumes = 0.25 * np.pi * diameters**2 * curves.lengths(rest)
        total = self._mass(prim, geometry, material, float(volumes.sum()), title, len(volumes))
        masses = curves.masses(total, volumes)
        stiffnesses = curves.stiffnesses(material)
        young, ratio = self._moduli(material, stiffnesses, float(diameters.mean()), title)
        holds = self._holds(geometry, len(start), title)
        touches, color = self._touches(prim, geometry, title), self.stage.color(geometry)
        found = []
        for k, own in enumerate(curves.names(name, self.taken)):
            points = curves.points[k]
            owner, held = self._held(holds, points, title)
            flex = Flex(
                own,
                owner.link,
                owner.local(rest[points]),
                Polyline(rest[points]).edges,
                mass=masses[k],
                held=held,
                youngs_modulus=young,
                poissons_ratio=ratio,
                thickness=float(diameters[k]),
                rod_stiffnesses=stiffnesses,
                start=owner.local(start[points]) if is_moved else None,
                velocity=self._velocity(geometry, owner, title, points),
                touches=touches,
                color=color,
            )
            found.append(flex)
        return found

    # --- geometry ---

    def _geometry(self, prim: Any, title: str) -> Any:
        """The prim whose points move: the body itself or a child of it."""
        places = [prim, *prim.GetFilteredChildren(self.pxr.Usd.TraverseInstanceProxies())]
        found = [place for place in places if _GEOMETRIES.get(str(place.GetTypeName())) in applied(place)]
        if len(found) != 1:
            self._refuse(
                title,
                f"has {len(found)} simulation geometries: must have one, itself or a child: a TetMesh with "
                f"PhysicsVolumeDeformableSimAPI, a Mesh with PhysicsSurfaceDeformableSimAPI or BasisCurves "
                f"with PhysicsCurvesDeformableSimAPI",
            )
        return found[0]

    def _points(self, geometry: Any, name: str, title: str) -> Floats:
        """In the world [m]."""
        attribute = geometry.GetAttribute(name)
        values = attribute.Get()
        if values is None:
            values = attribute.Get(self.pxr.Usd.TimeCode.EarliestTime())
        points = np.array([] if values is None else values, dtype=np.float64).reshape(-1, 3)
        if len(points) == 0 or not np.isfinite(points).all():
            self._refuse(title, f"{name}: must be finite coordinates of at least one point; correct them")
        frame: Frame = self.stage.frame(geometry)
        return np.asarray(frame.position + (points @ frame.scale.T) @ frame.rotation.T)

    def _cells(self, geometry: Any, kind: str, count: int, title: str) -> Cells:
        if kind == "TetMesh":
            name, size = "tetVertexIndices", 4
        else:
            name, size = "faceVertexIndices", 3
            corners = np.array(value_of(geometry, "faceVertexCounts", []), dtype=np.int64)
            if (corners != 3).any():
                self._refuse(title, "faceVertexCounts: must all be 3, triangles; triangulate the mesh")
        flat = np.array(value_of(geometry, name, []), dtype=np.int64).reshape(-1)
        if len(flat) == 0 or len(flat) % size or not 0 <= flat.min() <= flat.max() < count:
            self._refuse(title, f"{name}: must be {size} numbers of points an element; correct them")
        cells = flat.reshape(-1, size).astype(np.int32)
        is_left = str(value_of(geometry, "orientation", "rightHanded")) == "leftHanded"
        return np.ascontiguousarray(cells[:, ::-1]) if is_left and size == 3 else cells

    def _rest(self, geometry: Any, start: Floats, title: str) -> tuple[Floats, bool]:
        """Shape at rest, and whether it starts in another one."""
        for name in ("restTetVertexIndices", "restTriVertexIndices", "restBendAngles"):
            if len(value_of(geometry, f"physics:{name}", [])) > 0:
                self.report.add("dropped", title, f"{name}: where it starts, it is at rest")
                return start, False
        if len(value_of(geometry, "physics:restNormals", [])) > 0:
            self.report.add("dropped", title, "restNormals: it has no twist at rest")
        if value_of(geometry, "physics:restShapePoints") is None:
            return start, False
        rest = self._points(geometry, "physics:restShapePoints", title)
        if len(rest) != len(start):
            self._refuse(title, f"restShapePoints: {len(rest)} points: must be {len(start)}, as in points")
        return rest, not np.array_equal(rest, start)

    def _thickness(self, geometry: Any, title: str) -> float:
        """[m], one for all."""
        values = np.array(value_of(geometry, "physics:thicknesses", []), dtype=np.float64) * self.stage.metre
        if len(values) == 0:
            self.report.add("assumed", title, f"thickness {_THICKNESS:g} m")
            return _THICKNESS
        if not (values > 0.0).all():
            self._refuse(title, f"thicknesses: {values.min():g} m: must be positive; correct it")
        if np.ptp(values) > SAME * values.max():
            self.report.add(
                "assumed", title, f"one thickness, the mean of {values.min():g} to {values.max():g} m"
            )
        return float(values.mean())

    def _velocity(
        self, geometry: Any, owner: Owner, title: str, points: slice = slice(None)
    ) -> tuple[float, float, float]:
        values = np.array(value_of(geometry, "velocities", []), dtype=np.float64).reshape(-1, 3)[points]
        if len(values) == 0:
            return (0.0, 0.0, 0.0)
        frame: Frame = self.stage.frame(geometry)
        velocities = values @ frame.scale.T @ frame.rotation.T @ owner.rotation
        if np.ptp(velocities, axis=0).max() > SAME * max(1e-9, float(np.abs(velocities).max())):
            self.report.add("assumed", title, "starts with the mean of its velocities")
        x, y, z = (float(value) for value in velocities.mean(axis=0))
        return x, y, z

    # --- contact and attachments ---

    def _touches(self, prim: Any, geometry: Any, title: str) -> bool:
        api = self.pxr.UsdPhysics.CollisionAPI
        inside = self.pxr.Usd.PrimRange(prim, self.pxr.Usd.TraverseInstanceProxies())
        colliders = [
            place
            for place in inside
            if place.HasAPI(api) and api(place).GetCollisionEnabledAttr().Get() is not False
        ]
        if colliders and geometry not in colliders:
            self.report.add(
                "assumed", title, f"touches by {geometry.GetPath()}, not {colliders[0].GetPath()}"
            )
        return bool(colliders)

    def _holds(self, geometry: Any, count: int, title: str) -> list[tuple[str, Owner, NDArray[np.int64]]]:
        """The attachments of points to links: path, link and points."""
        found = []
        for prim in self.attachments:
            sources = [list(prim.GetRelationship(f"physics:src{k}").GetTargets()) for k in (0, 1)]
            if geometry.GetPath() not in [path for source in sources for path in source]:
                continue
            path, owner = str(prim.GetPath()), self._other(prim, geometry, sources)
            if owner is None:
                self.report.add("dropped", title, f"{path}: {_ONE_LINK}")
                continue
            indices = np.array(value_of(prim, "physics:indices0", []), dtype=np.int64)
            if len(indices) == 0 or not 0 <= indices.min() <= indices.max() < count:
                self._refuse(title, f"{path}: indices0: must be numbers of its points; correct them")
            if np.isfinite(value_of(prim, "physics:stiffness", np.inf)):
                self.report.add("dropped", title, f"{path}: stiffness: it is as stiff as joints are")
            found.append((path, owner, indices))
        return found

    def _held(
        self, holds: list[tuple[str, Owner, NDArray[np.int64]]], points: slice, title: str
    ) -> tuple[Owner, tuple[int, ...]]:
        """The link at which a part with these points hangs, and by which of them."""
        owner, held = self.base, set[int]()
        for path, other, indices in holds:
            own = indices[(indices >= points.start) & (indices < points.stop)] - points.start
            if len(own) == 0:
                continue
            if held and other.link != owner.link:
                self.report.add("dropped", title, f"{path}: {_ONE_LINK}")
                continue
            owner = other
            held.update(int(k) for k in own)
        return owner, tuple(sorted(held))

    def _other(self, prim: Any, geometry: Any, sources: list[list[Any]]) -> Owner | None:
        """The link at which an attachment holds points; None where it is of another kind."""
        kinds = [str(value_of(prim, f"physics:type{k}", "")) for k in (0, 1)]
        if kinds != ["point", "xform"] or sources[0] != [geometry.GetPath()]:
            return None
        target = self.stage.usd.GetPrimAtPath(sources[1][0]) if sources[1] else None
        return self.owner_of(target)

    # --- material ---

    def _material(self, geometry: Any, title: str) -> Any:
        """The prim of its material, or that of the geometry, which says nothing."""
        for child in geometry.GetFilteredChildren(self.pxr.Usd.TraverseInstanceProxies()):
            if str(child.GetTypeName()) == "GeomSubset" and child.HasAPI(
                self.pxr.UsdShade.MaterialBindingAPI
            ):
                self.report.add("dropped", title, f"material of {child.GetPath()}: one holds for all")
        bound = self.pxr.UsdShade.MaterialBindingAPI(geometry).ComputeBoundMaterial("physics")[0]
        return bound.GetPrim() if bound else geometry

    def _number(
        self, prim: Any, name: str, otherwise: float, least: float, most: float, title: str, unit: float = 1.0
    ) -> float:
        """What is infinite is not given."""
        value = float(value_of(prim, name, -np.inf))
        if not np.isfinite(value):
            self.report.add("assumed", title, f"{name.removeprefix('physics:')} {otherwise:g}")
            return otherwise
        if not least <= value <= most:
            self._refuse(title, f"{name} = {value:g}: must be {least:g} to {most:g}; correct it")
        return value * unit

    def _stiffness(
        self, material: Any, kind: str, thickness: float, title: str
    ) -> tuple[float, float | None]:
        """Young's modulus [Pa], and flexural rigidity [N m] if the file has one of its own."""
        pascal = self.stage.kilogram / self.stage.metre
        stretch = float(value_of(material, "physics:surfaceStretchStiffness", -np.inf)) * self.stage.kilogram
        bend = float(value_of(material, "physics:surfaceBendStiffness", -np.inf))
        rigidity = bend * self.stage.kilogram * self.stage.metre**2 if np.isfinite(bend) else None
        if kind != "Mesh" or not np.isfinite(stretch):
            young = self._number(material, "physics:youngsModulus", _MODULUS, 0.0, np.inf, title, pascal)
        else:
            ratio = float(value_of(material, "physics:poissonsRatio", _RATIO))
            young = stretch * (1.0 - ratio**2) / thickness
        if kind != "Mesh":
            return young, None
        if np.isfinite(float(value_of(material, "physics:surfaceShearStiffness", -np.inf))):
            self.report.add("dropped", title, "surfaceShearStiffness: it follows from that of stretch")
        return young, rigidity

    def _moduli(
        self, material: Any, stiffnesses: dict[str, float], diameter: float, title: str
    ) -> tuple[float, float]:
        """Young's modulus [Pa] and Poisson's ratio of curves, for the stiffnesses that are not given."""
        if len(stiffnesses) == 4:
            return stiffnesses["axial_stiffness"] / (0.25 * np.pi * diameter**2), _RATIO
        pascal = self.stage.kilogram / self.stage.metre
        young = self._number(material, "physics:youngsModulus", _MODULUS, 0.0, np.inf, title, pascal)
        return young, self._number(material, "physics:poissonsRatio", _RATIO, -1.0, 0.5, title)

    def _mass(
        self, prim: Any, geometry: Any, material: Any, volume: float, title: str, parts: int = 1
    ) -> float:
        """[kg] of the whole, from the first of the sources that the proposal lists."""
        masses = np.array(value_of(geometry, "physics:masses", []), dtype=np.float64) * self.stage.kilogram
        if len(masses) > 0:
            if len(masses) > parts:
                self.report.add("dropped", title, "how its mass is spread: by its volume")
            return self._positive(float(masses.sum()), "masses", title)
        if mass := float(value_of(prim, "physics:mass", 0.0)):
            return self._positive(mass * self.stage.kilogram, "mass", title)
        unit = self.stage.kilogram / self.stage.metre**3
        for place in (prim, material):
            if density := float(value_of(place, "physics:density", 0.0)):
                return self._positive(density * unit, "density", title) * volume
        self.report.add("assumed", title, f"density {_DENSITY:g} kg/m^3")
        return _DENSITY * volume

    def _positive(self, value: float, name: str, title: str) -> float:
        if not (value > 0.0 and np.isfinite(value)):
            self._refuse(title, f"{name} = {value:g}: must be positive and finite; correct it")
        return value

    def _refuse(self, title: str, text: str) -> NoReturn:
        raise InvalidArgument(f"{self.report.source}: {title}: {text}")


def _volume(x: Floats, cells: Cells, thickness: float) -> float:
    """[m^3]"""
    if cells.shape[1] == 3:
        return thickness * TriangleMesh(x, cells).area
    return oriented(TetMesh(x, cells)).volume

"""Robots of USD files, by usd-core: bodies, joints and shapes of UsdPhysics. [openusd.org: UsdPhysics]"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.robots.checks import check_inertias
from stark.robots.description import Flex, Geometry, Inertia, Link, RobotDescription, RobotJoint
from stark.robots.inertias import inertia_of
from stark.robots.usd_deformables import DEFORMABLE, Owner, read_deformables
from stark.robots.usd_joints import Side, UsdJoint, joints_of
from stark.robots.usd_stage import Frame, Stage, applied, turn, unique_names
from stark.robots.usd_unread import report_gravity, report_unread

Floats = NDArray[np.float64]

_WATER = 1000.0  # [kg/m^3], what UsdPhysics assumes where no density is given
_SINGLE = 1e-6  # relative, of numbers in single precision
#: How far bodies of a file may be from where joints at 0 place them [m, and sine of the angle].
_ELSEWHERE = 1e-3


def read_usd(file: Path) -> RobotDescription:
    """Reads a USD file (.usd, .usda, .usdc, .usdz); errors as in ``stark.robots.read``."""
    return _Reader(Stage(file)).read(file.stem)


@dataclass(eq=False)
class _Body:
    name: str
    prim: Any
    frame: Frame
    shapes: list[tuple[Any, Geometry]]


class _Reader:
    def __init__(self, stage: Stage) -> None:
        self.stage, self.report, self.pxr = stage, stage.report, stage.pxr
        self.prims = stage.prims()
        self.bodies = self._bodies()
        self.deformables = [str(prim.GetPath()) for prim in self.prims if DEFORMABLE in applied(prim)]
        if not self.bodies and not self.deformables:
            self._refuse(
                "stage", "has no prim with PhysicsRigidBodyAPI: must have a body; add the schema to it"
            )
        self._add_shapes()
        self.joints = joints_of(stage, self.prims, self._owner)

    def read(self, name: str) -> RobotDescription:
        prim = self.stage.usd.GetDefaultPrim()
        name = prim.GetName() if prim else name
        return self._robot_of(name) if self.bodies else self._soft(name)

    def _soft(self, name: str) -> RobotDescription:
        """Of a file with nothing but deformable bodies: they stand in the world."""
        world = Owner("world", np.zeros(3), np.eye(3))
        flexes = read_deformables(self.stage, self.prims, world, lambda prim: world)
        return RobotDescription(name, [Link("world")], [], report=self.report, flexes=flexes)

    def _robot_of(self, name: str) -> RobotDescription:
        used = self._robot()
        inside = [joint for joint in self.joints if used.intersection(joint.bodies)]
        grounded = [joint for joint in inside if len(joint.bodies) == 1]
        root = self._root(used, inside, grounded)
        base = self.bodies[root].frame
        placement = base.position, base.rotation
        joints: list[RobotJoint] = []
        links = [self._link(body) for key, body in self.bodies.items() if key in used]
        rest = sorted(inside, key=lambda joint: joint.is_outside)  # the others make the tree, if they can
        reached = {root}
        held = [joint for joint in grounded if joint.is_fixed and joint.bodies[0] == root]
        if held:
            rest.remove(held[0])
            placement = self._held(held[0])
        elif grounded:
            links.insert(0, Link("world"))
            placement = np.zeros(3), np.eye(3)
            reached = {""}
        while joint := next((row for row in rest if len(reached.intersection(row.ends)) == 1), None):
            rest.remove(joint)
            parent, child = joint.ends if joint.ends[0] in reached else joint.ends[::-1]
            reached.add(child)
            made, between = joint.to_tree(parent, self._name(parent), self._name(child), self.report)
            joints += made
            links += [Link(link, between=self._name(child)) for link in between]
            self._compare(joint, parent, child)
        self._close(rest)
        self._report_dropped()
        check_inertias([link for link in links if link.name != "world"], self.report)
        return RobotDescription(
            name,
            links,
            joints,
            excluded=self._excluded(used),
            base="fixed" if grounded else "floating",
            placement=placement,
            report=self.report,
            flexes=self._flexes(used, root if held else "" if grounded else None, root),
        )

    def _flexes(self, used: set[str], ground: str | None, root: str) -> list[Flex]:
        """``ground``: body that stands for the world, "" for a link of that name, None if there is none."""

        def owner(path: str) -> Owner:
            if not path:
                return Owner("world", np.zeros(3), np.eye(3))
            body = self.bodies[path]
            return Owner(body.name, body.frame.position, body.frame.rotation)

        def owner_of(prim: Any) -> Owner | None:
            path = self._owner(prim) or ground
            return owner(path) if path == "" or path in used else None

        return read_deformables(self.stage, self.prims, owner(root if ground is None else ground), owner_of)

    # --- bodies ---

    def _bodies(self) -> dict[str, _Body]:
        """By path. Names are those of the prims, or paths where two have the same."""
        api = self.pxr.UsdPhysics.RigidBodyAPI
        found = [prim for prim in self.prims if prim.HasAPI(api)]
        off = [prim for prim in found if api(prim).GetRigidBodyEnabledAttr().Get() is False]
        for prim in off:
            self.report.add("dropped", f"body '{prim.GetPath()}'", "rigidBodyEnabled is false")
        rows = [prim for prim in found if prim not in off]
        bodies = {}
        for prim, name in zip(rows, unique_names(rows), strict=True):
            if api(prim).GetKinematicEnabledAttr().Get():
                self.report.add("dropped", f"body '{name}'", "kinematicEnabled: it moves as the others do")
            path = str(prim.GetPath())
            bodies[path] = _Body(name, prim, self.stage.frame(prim, of_body=True), [])
        return bodies

    def _name(self, path: str) -> str:
        return self.bodies[path].name if path else "world"

    def _owner(self, prim: Any) -> str:
        """Path of the body that a prim is part of, "" for the world."""
        while prim and not prim.IsPseudoRoot():
            if str(prim.GetPath()) in self.bodies:
                return str(prim.GetPath())
            prim = prim.GetParent()
        return ""

    def _add_shapes(self) -> None:
        for prim in self.prims:
            if not prim.IsA(self.pxr.UsdGeom.Gprim) or self._deforms(prim):
                continue
            owner = self._owner(prim)
            purpose = self.pxr.UsdGeom.Imageable(prim).ComputePurpose()
            collides = self._collides(prim)
            if owner and not collides and (above := self._collider_above(prim)) is not None:
                self.report.add(
                    "suspicious",
                    f"body '{self._name(owner)}'",
                    f"{prim.GetPath()} does not touch: PhysicsCollisionAPI is on {above.GetPath()}, which is "
                    f"no shape; apply it to the shapes",
                    warn=True,
                )
            if not owner:
                if collides:
                    self.report.add("dropped", f"shape '{prim.GetPath()}'", "is part of no body")
                continue
            if not collides and (purpose not in ("default", "render") or self._is_hidden(prim)):
                continue
            body = self.bodies[owner]
            shape = self.stage.shape(prim, body.frame, f"body '{body.name}'")
            if shape is not None:
                body.shapes.append((prim, shape))

    def _deforms(self, prim: Any) -> bool:
        path = str(prim.GetPath()) + "/"
        return any(path.startswith(root + "/") for root in self.deformables)

    def _is_soft(self, prim: Any) -> bool:
        """Whether a prim is read as, or for, a deformable body: it, an attachment, a material."""
        names = [*applied(prim), str(prim.GetTypeName())]
        return self._deforms(prim) or any("Deformable" in name or "Attachment" in name for name in names)

    def _collides(self, prim: Any) -> bool:
        api = self.pxr.UsdPhysics.CollisionAPI
        return bool(prim.HasAPI(api)) and api(prim).GetCollisionEnabledAttr().Get() is not False

    def _is_hidden(self, prim: Any) -> bool:
        geom = self.pxr.UsdGeom
        return bool(geom.Imageable(prim).ComputeVisibility() == geom.Tokens.invisible)

    def _collider_above(self, prim: Any) -> Any | None:
        """The prim of the same body above a shape that would let it touch, if it were a shape itself."""
        above = prim
        while str(above.GetPath()) not in self.bodies:
            above = above.GetParent()
            if self._collides(above) and not above.IsA(self.pxr.UsdGeom.Gprim):
                return above
        return None

    def _link(self, body: _Body) -> Link:
        touching = [shape for prim, shape in body.shapes if self._collides(prim)]
        shown = [shape for prim, shape in body.shapes if not self._collides(prim)]
        return Link(body.name, self._inertia(body), tuple(shown or touching), tuple(touching))

    # --- inertias ---

    def _inertia(self, body: _Body) -> Inertia | None:
        """As UsdPhysics has it: what MassAPI says, else that of the shapes that collide."""
        api = self.pxr.UsdPhysics.MassAPI
        data = api(body.prim)
        mass = float(data.GetMassAttr().Get() or 0.0) * self.stage.kilogram
        title = f"body '{body.name}'"
        unit = self.stage.kilogram * self.stage.metre**2
        diagonal = np.array(data.GetDiagonalInertiaAttr().Get() or (0.0, 0.0, 0.0), dtype=np.float64) * unit
        given = np.array(data.GetCenterOfMassAttr().Get() or (-np.inf,) * 3, dtype=np.float64)
        # Infinite is the fallback of USD: not given.
        center = body.frame.scale @ given if np.isfinite(given).all() else None
        if mass > 0.0 and diagonal.any():
            axes = turn(data.GetPrincipalAxesAttr().Get())
            if center is None:
                center = np.zeros(3) if (solid := self._solid(body)) is None else solid.center
            return Inertia(mass, center, axes @ np.diag(_possible(diagonal)) @ axes.T)
        solid = self._solid(body)
        if solid is None:
            if mass > 0.0:
                self._refuse(
                    title,
                    f"has the mass {mass:g} kg, but neither diagonalInertia nor closed shapes that collide",
                )
            return None
        if mass > 0.0:
            solid = Inertia(mass, solid.center, solid.tensor * (mass / solid.mass))
            self.report.add("assumed", title, "inertia: that of its shapes, with the mass of the file")
        else:
            self.report.add("assumed", title, f"mass {solid.mass:.6g} kg and inertia: those of its shapes")
        if center is None:
            return solid
        away = center - solid.center
        shift = solid.mass * (away @ away * np.eye(3) - np.outer(away, away))
        return Inertia(solid.mass, center, solid.tensor + shift)

    def _solid(self, body: _Body) -> Inertia | None:
        parts = []
        for prim, shape in body.shapes:
            if self._collides(prim):
                part = inertia_of(shape, self._density(prim, body), self.report.source, f"body '{body.name}'")
                mass = self.pxr.UsdPhysics.MassAPI(prim).GetMassAttr().Get() if prim != body.prim else None
                if part is None:
                    self.report.add(
                        "dropped", f"body '{body.name}'", f"mass of {prim.GetPath()}, which is open"
                    )
                    continue
                if mass:
                    scale = float(mass) * self.stage.kilogram / part.mass
                    part = Inertia(part.mass * scale, part.center, part.tensor * scale)
                parts.append(part)
        return Inertia.sum(parts) if parts else None

    def _density(self, prim: Any, body: _Body) -> float:
        """Of a shape [kg/m^3]: its own, that of its body, that of its material."""
        unit = self.stage.kilogram / self.stage.metre**3
        for owner in (prim, body.prim):
            if value := self.pxr.UsdPhysics.MassAPI(owner).GetDensityAttr().Get():
                return float(value) * unit
        bound = self.pxr.UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")[0]
        if bound and (value := self.pxr.UsdPhysics.MaterialAPI(bound.GetPrim()).GetDensityAttr().Get()):
            return float(value) * unit
        return _WATER

    # --- the tree ---

    def _robot(self) -> set[str]:
        """Paths of the bodies of the robot: those that joints connect; of several such groups that with an
        articulation."""
        groups = _groups(self.bodies, self.joints)
        roots = [p for p in self.prims if p.HasAPI(self.pxr.UsdPhysics.ArticulationRootAPI)]
        marked = [group for group in groups if any(self._is_of(root, group) for root in roots)]
        found = marked or [group for group in groups if len(group) > 1] or groups
        if len(found) > 1:
            first = ", ".join(f"'{sorted(group)[0]}'" for group in found[:4])
            what, remedy = (
                ("articulations", "save each in a file of its own")
                if marked
                else ("parts that no joint connects", "mark the robot by PhysicsArticulationRootAPI")
            )
            self._refuse("stage", f"has {len(found)} {what}, with {first}: must have one robot; {remedy}")
        for group in groups:
            if group is not found[0]:
                for path in sorted(group):
                    self.report.add("dropped", f"body '{self._name(path)}'", "is no part of the robot")
        return found[0]

    def _is_of(self, root: Any, group: set[str]) -> bool:
        """Whether an articulation is that of these bodies: on one of them, on a joint of theirs, or above."""
        path = str(root.GetPath())
        joints = [joint for joint in self.joints if group.intersection(joint.bodies)]
        return (
            path in group
            or any(joint.path == path for joint in joints)
            or any(body.startswith(path.rstrip("/") + "/") for body in group)
        )

    def _root(self, used: set[str], joints: list[UsdJoint], grounded: list[UsdJoint]) -> str:
        """The body that is fixed to the world, or has a joint to it, or is second in no joint."""
        for joint in sorted(grounded, key=lambda row: not row.is_fixed):
            return joint.bodies[0]
        children = {joint.sides[1].body for joint in joints}
        order = [path for path in self.bodies if path in used]
        roots = [p for p in order if self.bodies[p].prim.HasAPI(self.pxr.UsdPhysics.ArticulationRootAPI)]
        return next(iter(roots or [path for path in order if path not in children] or order))

    def _held(self, joint: UsdJoint) -> tuple[Floats, Floats]:
        """Where a fixed joint to the world holds its body."""
        world, body = sorted(joint.sides, key=lambda side: side.body != "")
        rotation = world.rotation @ body.rotation.T
        return world.position - rotation @ body.position, rotation

    def _compare(self, joint: UsdJoint, parent: str, child: str) -> None:
        """Says where the file places bodies elsewhere than joints at 0 do."""
        a, b = (self._in_world(side) for side in joint.sides)
        axis = "" if joint.is_fixed else ", at another value of the joint: give q"
        away = float(np.linalg.norm(a[0] - b[0]))
        angle = float(np.linalg.norm(a[1] - b[1]))
        if max(away, angle) > _ELSEWHERE:
            self.report.add(
                "assumed",
                f"joint '{joint.name}'",
                f"starts at 0; the file places '{self._name(child)}' elsewhere beside "
                f"'{self._name(parent)}'{axis}",
            )

    def _in_world(self, side: Side) -> tuple[Floats, Floats]:
        if not side.body:
            return side.position, side.rotation
        frame = self.bodies[side.body].frame
        return frame.position + frame.rotation @ side.position, frame.rotation @ side.rotation

    def _close(self, rest: Iterable[UsdJoint]) -> None:
        """Joints that close loops."""
        for joint in rest:
            if not joint.is_outside:
                self._refuse(
                    f"joint '{joint.name}'",
                    "closes a loop: joints must make a tree; set excludeFromArticulation and close it with "
                    "scene.add_joint after the robot is added",
                )
            self.report.add(
                "dropped",
                f"joint '{joint.name}'",
                "closes a loop, excludeFromArticulation is set; close it with scene.add_joint",
                warn=True,
            )

    def _excluded(self, used: set[str]) -> list[tuple[str, str]]:
        pairs = []
        for prim in self.prims:
            if prim.HasAPI(self.pxr.UsdPhysics.FilteredPairsAPI):
                a = self._owner(prim)
                for target in self.pxr.UsdPhysics.FilteredPairsAPI(prim).GetFilteredPairsRel().GetTargets():
                    b = self._owner(self.stage.usd.GetPrimAtPath(target))
                    if a in used and b in used and a != b:
                        pairs.append((self._name(a), self._name(b)))
        return pairs

    def _report_dropped(self) -> None:
        physics = self.pxr.UsdPhysics
        self.report.add("dropped", "file", "friction and softness of contact: those of the scene hold")
        self.report.add("kept", "file", "meshes touch as they are, not by their convex hulls")
        if any(prim.IsA(physics.CollisionGroup) for prim in self.prims):
            self.report.add("dropped", "file", "collision groups: give exclude")
        report_unread(self.stage, [prim for prim in self.prims if not self._is_soft(prim)])
        for prim in self.prims:
            if prim.IsA(physics.Scene):
                report_gravity(self.stage, physics.Scene(prim))
                size = physics.Scene(prim).GetGravityMagnitudeAttr().Get()
                if (
                    size is not None
                    and math.isfinite(size)
                    and not math.isclose(size * self.stage.metre, 9.81, abs_tol=0.02)
                ):
                    self.report.add(
                        "dropped",
                        "file",
                        f"gravity of {size * self.stage.metre:g} m/s^2: that of the simulation holds",
                    )

    def _refuse(self, part: str, text: str) -> NoReturn:
        raise InvalidArgument(f"{self.report.source}: {part}: {text}")


def _possible(moments: Floats) -> Floats:
    """Principal moments of flat bodies, of which one is the sum of the others but for single precision."""
    k = int(np.argmax(moments))
    others = float(moments.sum() - moments[k])
    if others < moments[k] < others * (1.0 + _SINGLE):
        moments[k] = others
    return moments


def _groups(bodies: Iterable[str], joints: Iterable[UsdJoint]) -> list[set[str]]:
    """Bodies that joints connect with each other."""
    groups = [{body} for body in bodies]
    for joint in joints:
        touched = [group for group in groups if group.intersection(joint.bodies)]
        if len(touched) > 1:
            groups = [group for group in groups if group not in touched] + [set().union(*touched)]
    return groups

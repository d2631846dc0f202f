"""``scene.add_robot``: bodies, joints, stops, gears and exclusions of a description."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark import mesh as meshes
from stark._core import InvalidArgument
from stark.bodies import Cloth, RigidBody, Rod, Solid
from stark.joints.adding import frame_with_z
from stark.joints.handle import Joint
from stark.mesh import TriangleMesh, joined
from stark.robots import kinematics
from stark.robots.checks import check_reach, check_touching, is_nothing, refuse_impossible, shapes_of
from stark.robots.closing import Posture, close, free_places
from stark.robots.description import Closure, Flex, Geometry, Inertia, RobotDescription, RobotJoint
from stark.robots.flexes import Carrier, add_flex
from stark.robots.handle import Robot
from stark.robots.kinematics import WORLD, Placement, limits_of
from stark.robots.link import RobotLink
from stark.robots.meshes import mesh_of
from stark.robots.report import Report
from stark.selections import FrameHandle, rigid_frame, world_frame

Floats = NDArray[np.float64]

#: Joints of the scene by those of a description; others are hinges.
_KINDS = {"fixed": "fixed", "prismatic": "slider", "ball": "ball"}
BASES = ("fixed", "floating", "scripted")
_TURN = 2.0 * math.pi
#: Of the mass and largest moment of a link with several joints, for the links between these.
_SMALL = 1e-4


@dataclass(frozen=True)
class Options:
    """Arguments of ``scene.add_robot`` that say how a robot is built."""

    name: str
    base: str
    placement: Placement
    q: kinematics.Values | None
    contact: bool
    self_contact: bool
    exclude: tuple[tuple[str, str], ...]
    shapes: str
    shown: str | None
    merge_fixed: bool
    inertias: Mapping[str, Inertia]
    body: Mapping[str, Any]  # options of add_rigid for all links


@dataclass
class Group:
    """Links that are one body: frames of all in that of the first one."""

    root: str
    frames: dict[str, Placement] = field(default_factory=dict)


def build(scene: Any, description: RobotDescription, options: Options) -> Robot:
    """Adds a robot to a scene; InvalidArgument says what is wrong with it."""
    return _Builder(scene, description, options).build()


class _Builder:
    def __init__(self, scene: Any, description: RobotDescription, options: Options) -> None:
        self.scene, self.robot, self.options = scene, description, options
        self.report: Report = description.report.copy()
        self.q, free = self._closed(self._start(), {} if options.q is None else options.q)
        self.frames = kinematics.placements(description, self.q, options.placement, free)
        self.groups = self._groups()
        self.group_of = {link: group for group in self.groups for link in group.frames}
        self.body_of: dict[str, RigidBody | None] = {}  # by root of the group
        self.joints: dict[str, Joint] = {}
        self.shifts: dict[str, float] = {}
        self.vertices: dict[str, tuple[int, int]] = {}  # of links in the meshes of their bodies
        self.surfaces: dict[tuple[str, str], dict[str, list[TriangleMesh]]] = {}  # read, by root and shapes

    def build(self) -> Robot:
        for group in self.groups:
            self.body_of[group.root] = self._add_body(group)
        for joint in self.robot.joints.values():
            self._add_joint(joint)
        closures = {closure.name: self._add_closure(closure) for closure in self.robot.closures.values()}
        for joint in self.robot.joints.values():
            if joint.is_moving:
                self._add_effects(joint)
        self._exclude()
        if self.options.contact:
            check_touching(self.robot.links.values(), self.options.shapes, self.options.base, self.report)
        flexes = {flex.name: self._add_flex(flex) for flex in self.robot.flexes.values()}
        links = {name: self._link(name) for name in self.robot.links}
        self.report.add(
            "kept",
            "robot",
            f"{len(self.body_of)} bodies of {len(links)} links, {len(self.robot.coordinates)} coordinates",
        )
        return Robot(
            self.scene,
            self.options.name,
            self._with_inertias(),
            self.report,
            links,
            self.joints,
            self.shifts,
            self.q,
            flexes,
            closures,
        )

    # --- start ---

    def _start(self) -> Floats:
        names = self.robot.coordinates
        given = {} if self.options.q is None else self.options.q
        q = kinematics.numbers_of(self.robot, given)
        if isinstance(given, Mapping):
            drawn = [self.robot.joints[name].reference for name in names]
            q = np.array([q[k] if name in given else drawn[k] for k, name in enumerate(names)])
        lower, upper = limits_of(self.robot, self.report)
        for k, name in enumerate(names):
            unit = self.robot.joints[name].unit
            is_given = not isinstance(given, Mapping) or name in given
            if lower[k] <= q[k] <= upper[k]:
                continue
            if is_given:
                raise InvalidArgument(
                    f"{self.robot.source}: joint '{name}': starts at q = {q[k]:g} {unit}: must be in "
                    f"its limits, [{lower[k]:g}, {upper[k]:g}] {unit}; give another q"
                )
            q[k] = lower[k] if q[k] < lower[k] else upper[k]
            self.report.add(
                "assumed",
                f"joint '{name}'",
                f"starts at its limit {q[k]:g} {unit}, as {self.robot.joints[name].reference:g} is beyond",
            )
        return q

    def _closed(self, q: Floats, given: kinematics.Values) -> tuple[Floats, Mapping[str, Placement] | None]:
        """With loops closed by the coordinates that were not given and by what floating and ball joints let
        go, in the world; the file has them closed at its own."""
        if not self.robot.closures:
            return q, None

        def frames(posture: Posture) -> Mapping[str, Placement]:
            return kinematics.placements(self.robot, posture.q, WORLD, posture.free)

        names = self.robot.coordinates
        held = [k for k, name in enumerate(names) if not isinstance(given, Mapping) or name in given]
        start = np.clip([self.robot.joints[name].reference for name in names], *limits_of(self.robot))
        drawn = free_places(self.robot, kinematics.placements(self.robot, start).__getitem__)
        q, free = close(self.robot, Posture(start, drawn), q, held, frames, f"{self.robot.source}: q")
        kind, base = {name: self.robot.joints[name].kind for name in free}, self.options.placement
        return q, {name: place if kind[name] == "ball" else base.at(*place) for name, place in free.items()}

    def _groups(self) -> list[Group]:
        """From the base outwards."""
        groups = {self.robot.root: Group(self.robot.root, {self.robot.root: WORLD})}
        member = {self.robot.root: groups[self.robot.root]}
        for joint in self.robot.outwards:
            parent = member[joint.parent]
            if joint.kind == "fixed" and self._is_merged(joint):
                frame = parent.frames[joint.parent].at(joint.position, joint.rotation)
                parent.frames[joint.child] = frame
                member[joint.child] = parent
            else:
                member[joint.child] = groups[joint.child] = Group(joint.child, {joint.child: WORLD})
        return list(groups.values())

    def _is_merged(self, joint: RobotJoint) -> bool:
        if self.options.merge_fixed:
            return True
        # What has no mass cannot be a body of its own.
        return any(self._inertia_of(name) is None for name in (joint.parent, joint.child))

    def _inertia_of(self, link: str) -> Inertia | None:
        """None for links without mass."""
        inertia = self.options.inertias.get(link, self.robot.links[link].inertia)
        return None if inertia is None or is_nothing(inertia) else inertia

    # --- bodies ---

    def _add_body(self, group: Group) -> RigidBody | None:
        is_base = group.root == self.robot.root
        motion = {"fixed": "fixed", "floating": "dynamic", "scripted": "scripted"}[self.options.base]
        motion = motion if is_base else "dynamic"
        inertia = self._inertia(group, motion == "dynamic")
        mesh, touches = self._mesh(group, inertia)
        if mesh is None:
            if motion == "fixed":
                self.report.add("kept", f"link '{group.root}'", "has no shape: is a part of the world")
                return None
            raise InvalidArgument(
                f"{self.robot.source}: link '{group.root}': has no shape: the base must have one with "
                f"base='{self.options.base}'; add a <visual>"
            )
        placement = self.frames[group.root]
        given = dict(self.options.body)
        links = [self.robot.links[name] for name in group.frames]
        shapes = [s for link in links for s in link.visuals] + [s for link in links for s in link.collisions]
        color = next((s.color for s in shapes if s.color), None)
        if color is not None:
            given.setdefault("color", color)
        if motion == "dynamic":
            assert inertia is not None
            given["inertia"] = (inertia.mass, inertia.center, inertia.tensor)
        body: RigidBody = self.scene.add_rigid(
            mesh,
            name=f"{self.options.name}.{group.root}",
            motion=motion,
            position=placement.position,
            rotation=placement.rotation,
            shown=self._shown(group, mesh),
            **given,
        )
        if not touches:
            self.scene._touches_nothing(body)
        return body

    def _inertia(self, group: Group, needed: bool) -> Inertia | None:
        parts = []
        for name, frame in group.frames.items():
            inertia = self._inertia_of(name)
            if inertia is not None:
                parts.append(inertia.moved(*frame))
        if len(group.frames) > 1:
            self.report.add(
                "kept", f"link '{group.root}'", f"is one body with {_listed(group.frames, group.root)}"
            )
        if not needed:
            return None
        if not parts and (between := self.robot.links[group.root].between) is not None:
            return self._small_inertia(group.root, between)
        if not parts:
            raise InvalidArgument(
                f"{self.robot.source}: link {_listed(group.frames)}: has no mass: a link that moves must "
                f"have an <inertial>; add it, fix the link to another one, or give "
                f"inertias={{'{group.root}': (mass, centre of mass, tensor about it)}}"
            )
        for name in group.frames:
            part = self._inertia_of(name)
            if part is not None and part.mass < 0.0:
                refuse_impossible(self.robot.source, [name], part)
        # Two identical tensors are not summed: the bits of the file stay.
        total = Inertia.sum(parts) if len(parts) > 1 else parts[0]
        refuse_impossible(self.robot.source, group.frames, total)
        return total

    def _small_inertia(self, name: str, between: str) -> Inertia:
        """Of a link between joints of another one: a body must have some. It is where the next joint is."""
        other = self._inertia_of(between)
        if other is None:
            raise InvalidArgument(
                f"{self.robot.source}: link '{between}': has no mass, but several joints: must have an "
                f"<inertial>; add it, or give inertias={{'{name}': ..., '{between}': ...}}"
            )
        anchor = next(joint.anchor for joint in self.robot.outwards if joint.parent == name)
        moment = _SMALL * float(np.linalg.eigvalsh(other.tensor)[-1])
        self.report.add(
            "assumed",
            f"link '{name}'",
            f"has {_SMALL:g} of the mass and of the largest moment of '{between}'",
        )
        return Inertia(_SMALL * other.mass, anchor, moment * np.eye(3))

    def _mesh(self, group: Group, inertia: Inertia | None) -> tuple[TriangleMesh | None, bool]:
        """The surface of a body, and whether it touches others."""
        options = self.options
        other = "collision" if options.shapes == "visual" else "visual"
        for shapes, touches in ((options.shapes, options.contact), (other, False)):
            try:
                surfaces = self._surfaces(group, shapes)
            except InvalidArgument as error:
                if options.contact or shapes == "visual":
                    raise
                # What touches nothing needs no collision shapes: they are only cheaper.
                self.report.add("dropped", f"link '{group.root}'", f"collision shapes: {error}")
                continue
            parts: list[TriangleMesh] = []
            for name, of_link in surfaces.items():
                start = sum(len(part.vertices) for part in parts)
                parts += of_link
                self.vertices[name] = start, sum(len(part.vertices) for part in parts)
            if parts:
                if options.contact and not touches:
                    self.report.add(
                        "assumed", f"link '{group.root}'", f"no {options.shapes} shape: touches nothing"
                    )
                return joined(parts), touches
        if inertia is None:
            return None, False
        if self.robot.links[group.root].between is not None:
            return meshes.box(2e-3).translated(inertia.center), False  # hidden in what the joints connect
        self.report.add(
            "assumed", f"link '{group.root}'", "no shape: drawn as a box of its inertia, touches nothing"
        )
        return _box_of(inertia), False

    def _surfaces(self, group: Group, shapes: str) -> dict[str, list[TriangleMesh]]:
        """Those of the links of a body, in its frame; read, and reported, once."""
        if (group.root, shapes) in self.surfaces:
            return self.surfaces[group.root, shapes]
        found = {}
        for name, frame in group.frames.items():
            given = shapes_of(self.robot.links[name], shapes)
            found[name] = self._parts(given, name, frame, needed=shapes == self.options.shapes)
            inertia = self._inertia_of(name)
            if inertia is not None and found[name] and any(shape.kind == "mesh" for shape in given):
                vertices = np.concatenate([part.vertices for part in found[name]])
                check_reach(name, vertices, inertia.moved(*frame), self.report)
        self.surfaces[group.root, shapes] = found
        return found

    def _shown(self, group: Group, mesh: TriangleMesh) -> TriangleMesh | None:
        """What pictures show instead of the surface of a body, where that is another one."""
        which = self.options.shown or (None if self.options.contact else "visual")
        parts = [] if which is None else list(itertools.chain(*self._surfaces(group, which).values()))
        shown = joined(parts) if parts else None
        return None if shown is None or np.array_equal(shown.vertices, mesh.vertices) else shown

    def _parts(
        self, shapes: Iterable[Geometry], link: str, frame: Placement, *, needed: bool
    ) -> list[TriangleMesh]:
        """Surfaces in the frame of the body. What is only shown, and cannot be read, is left out."""
        parts, title = [], f"link '{link}'"
        remedy = "correct it, or leave it out with contact=False"
        if not needed or not self.options.contact:
            remedy = "correct the file"
        for shape in shapes:
            try:
                surface = mesh_of(shape, self.robot.source, title, self.report, remedy)
            except InvalidArgument as error:
                if needed:
                    raise
                text = str(error).removeprefix(f"{self.robot.source}: {title}: ")
                self.report.add("dropped", title, f"what is only shown of it: {text}")
                continue
            parts.append(
                TriangleMesh(surface.vertices @ frame.rotation.T + frame.position, surface.triangles)
            )
        return parts

    # --- joints ---

    def _add_joint(self, joint: RobotJoint) -> None:
        parent, child = self.group_of[joint.parent], self.group_of[joint.child]
        if parent is child or joint.kind == "floating":
            return
        turned = frame_with_z(joint.axis, f"joint '{joint.name}'") if joint.is_moving else np.eye(3)
        at_parent = parent.frames[joint.parent].at(joint.position, joint.rotation).at(joint.anchor, turned)
        at_child = child.frames[joint.child].at(joint.anchor, turned)
        kind = _KINDS.get(joint.kind, "hinge")
        self.joints[joint.name] = self.scene.add_joint(
            kind,
            self._frame(parent, at_parent),
            self._frame(child, at_child),
            name=f"{self.options.name}.{joint.name}",
        )
        if joint.is_moving:
            value = kinematics.joint_values(self.robot, self.q)[joint.name] - joint.reference
            turns = 0 if joint.kind == "prismatic" else round((value - _wrapped(value)) / _TURN)
            self.shifts[joint.name] = joint.reference + turns * _TURN

    def _add_closure(self, closure: Closure) -> Joint:
        groups = [self.group_of[link] for link in closure.links]
        if groups[0] is groups[1]:
            raise InvalidArgument(
                f"{self.robot.source}: closure '{closure.name}': holds '{closure.links[0]}' and "
                f"'{closure.links[1]}', which are fixed to each other: must hold what moves; leave it out"
            )
        a, b = (
            self._frame(group, group.frames[link].at(*frame))
            for group, link, frame in zip(groups, closure.links, closure.frames, strict=True)
        )
        joint: Joint = self.scene.add_joint(closure.kind, a, b, name=f"{self.options.name}.{closure.name}")
        return joint

    def _frame(self, group: Group, frame: Placement) -> FrameHandle:
        body = self.body_of[group.root]
        if body is None:
            return world_frame(*self.frames[group.root].at(*frame))
        return rigid_frame(body, frame.position, frame.rotation)

    def _add_effects(self, joint: RobotJoint) -> None:
        """Stops, gear, damping, friction, armature, spring."""
        handle, shift, title = self.joints[joint.name], self.shifts[joint.name], f"joint '{joint.name}'"
        name = f"{self.options.name}.{joint.name}"
        if joint.mimic is not None:
            driver, ratio, offset = self.robot.drive_of(joint)
            offset += ratio * self.shifts[driver] - shift
            handle.add_gear(self.joints[driver], ratio, offset=offset, name=f"{name}.gear")
            self.report.add("kept", title, f"mimics '{driver}' by a gear, ratio {ratio:g}")
        else:
            row = self.robot.coordinates.index(joint.name)
            bounds = [float(limit[row]) for limit in limits_of(self.robot)]
            given = {
                key: bound - shift
                for key, bound in zip(("lower", "upper"), bounds, strict=True)
                if np.isfinite(bound)
            }
            if given:
                handle.add_limit(**given, name=f"{name}.limit")
                unit = joint.unit
                self.report.add("kept", title, f"limits [{bounds[0]:g}, {bounds[1]:g}] {unit}")
            if joint.effort is not None:
                self.report.add("kept", title, f"limit of effort {joint.effort:g}, the cap of its drives")
        if joint.velocity is not None:
            self.report.add(
                "dropped",
                title,
                f"limit of velocity {joint.velocity:g} {joint.unit}/s: only in the description",
            )
        if joint.damping > 0.0 or joint.friction > 0.0:
            handle.add_friction(joint.friction, viscous=joint.damping, name=f"{name}.friction")
            self.report.add("kept", title, f"damping {joint.damping:g}, dry friction {joint.friction:g}")
        if joint.armature > 0.0:
            handle.add_armature(joint.armature, name=f"{name}.armature")
            self.report.add("kept", title, f"armature {joint.armature:g}")
        if joint.stiffness > 0.0:
            handle.add_spring(joint.stiffness, rest=joint.rest - shift, name=f"{name}.spring")
            self.report.add("kept", title, f"spring {joint.stiffness:g}, at rest at {joint.rest:g}")

    # --- the rest ---

    def _exclude(self) -> None:
        core = self.scene._core
        bodies = [body._index for body in self.body_of.values() if body is not None]
        if not self.options.self_contact:
            core.disable_contacts(bodies, bodies)
            self.report.add("kept", "contact", "links do not touch each other (self_contact=False)")
            return
        for a, b in (*self.robot.excluded, *self.options.exclude):
            for link in (a, b):
                if link not in self.group_of:
                    raise InvalidArgument(
                        f"{self.robot.source}: exclude: link '{link}': must be one of "
                        f"{', '.join(self.robot.links)}"
                    )
            pair = [self.body_of[self.group_of[link].root] for link in (a, b)]
            if pair[0] is not None and pair[1] is not None and pair[0] is not pair[1]:
                core.disable_contact(pair[0]._index, pair[1]._index)
                self.report.add("kept", "contact", f"'{a}' and '{b}' do not touch")

    def _add_flex(self, flex: Flex) -> Cloth | Rod | Solid:
        group = self.group_of[flex.link]
        frame = group.frames[flex.link]
        carrier = Carrier(self.body_of[group.root], frame, self.frames[flex.link])
        options, name = self.options, f"{self.options.name}.{flex.name}"
        return add_flex(self.scene, flex, carrier, name, options.body, options.contact, self.report)

    def _link(self, name: str) -> RobotLink:
        group = self.group_of[name]
        body, frame = self.body_of[group.root], group.frames[name]
        offset = frame if body is not None else self.frames[group.root].at(*frame)
        return RobotLink(
            name, self.robot.links[name], body, offset, self.robot.source, self.vertices.get(name, (0, 0))
        )

    def _with_inertias(self) -> RobotDescription:
        """The description with the inertias that the bodies have."""
        if not self.options.inertias:
            return self.robot
        links = [replace(link, inertia=self._inertia_of(link.name)) for link in self.robot.links.values()]
        return RobotDescription(
            self.robot.name,
            links,
            self.robot.joints.values(),
            excluded=self.robot.excluded,
            base=self.robot.base,
            placement=self.robot.placement,
            report=self.robot.report,
            flexes=self.robot.flexes.values(),
        )


def _box_of(inertia: Inertia) -> TriangleMesh:
    """A box with the principal moments of an inertia, where it has them."""
    moments, axes = np.linalg.eigh(inertia.tensor)
    squares = 6.0 * (moments.sum() - 2.0 * moments) / inertia.mass
    edges = np.sqrt(np.maximum(squares, 1e-6))
    axes = axes if np.linalg.det(axes) > 0.0 else -axes
    return meshes.box(edges).rotated(axes).translated(inertia.center)


def _wrapped(angle: float) -> float:
    """In (-pi, pi], as a joint reads it at time 0."""
    return math.atan2(math.sin(angle), math.cos(angle))


def _listed(names: Iterable[str], without: str = "") -> str:
    return ", ".join(f"'{name}'" for name in names if name != without)

"""MJCF files, compiled by mujoco, which applies defaults, units and orientations; read from its model."""

from __future__ import annotations

import os
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from stark import mesh as meshes
from stark._core import InvalidArgument
from stark.robots.checks import check_inertias
from stark.robots.description import Geometry, Inertia, Link, RobotDescription, RobotJoint
from stark.robots.kinematics import WORLD, Placement
from stark.robots.mjcf_actuators import read_actuators
from stark.robots.mjcf_contacts import touching_geoms, untouching
from stark.robots.mjcf_dropped import report_dropped
from stark.robots.mjcf_equalities import closes_to_world, read_closures, read_mimics
from stark.robots.mjcf_flexes import flex_bodies, read_flexes
from stark.robots.mjcf_tendons import Transmissions
from stark.robots.report import Report
from stark.rotations import as_matrix

Floats = NDArray[np.float64]

# Numbers of mujoco's enumerations, which are part of its interface.
_FREE, _BALL, _SLIDE, _HINGE = 0, 1, 2, 3
_GREY = np.array([0.5, 0.5, 0.5, 1.0], dtype=np.float32)  # of geoms that say nothing
_PLANE, _HFIELD, _SPHERE, _CAPSULE, _ELLIPSOID, _CYLINDER, _BOX, _MESH = range(8)

_READING = threading.Lock()  # handlers of warnings are those of the process


def read_mjcf(file: Path) -> RobotDescription:
    """Reads an MJCF file; errors as in ``stark.robots.read``."""
    try:
        import mujoco
    except ImportError as error:
        raise ImportError(f"'{file}': MJCF files need mujoco: pip install 'stark-sim[robots]'") from error
    report = Report(f"'{file}'")
    with _collected_warnings(mujoco) as warned:
        try:
            spec = mujoco.MjSpec.from_file(os.fspath(file))
            model = spec.compile()
        except Exception as error:  # of the parser, the compiler, the files of meshes
            why = ", ".join(str(error).split("\n")).rstrip(", ")
            raise InvalidArgument(f"{report.source}: mujoco cannot read it: {why}; correct it") from None
    for warning in warned:
        report.add("suspicious", "file", f"mujoco warns: {warning}")
    return _Reader(spec, model, report).read(str(spec.modelname) or file.stem)


@contextmanager
def _collected_warnings(mujoco: Any) -> Iterator[list[str]]:
    """What it warns of, which would otherwise be printed and written to a log in the working directory."""
    collected: list[str] = []
    with _READING, warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        before = mujoco.get_mju_user_warning()
        mujoco.set_mju_user_warning(collected.append)
        try:
            yield collected
        finally:
            mujoco.set_mju_user_warning(before)
            collected.extend(str(warning.message) for warning in warned)


class _Reader:
    def __init__(self, spec: Any, model: Any, report: Report) -> None:
        self.spec, self.model, self.report = spec, model, report
        self.of_flexes = flex_bodies(model)
        self.touches = touching_geoms(model)
        self.bodies = [
            "" if k in self.of_flexes else self._name("body", model.body(k).name, k)
            for k in range(model.nbody)
        ]
        self.joint_names = [
            "" if int(model.jnt_bodyid[k]) in self.of_flexes else self._name("joint", model.joint(k).name, k)
            for k in range(model.njnt)
        ]
        self.mimics = read_mimics(model, self.joint_names, report)
        along = Transmissions(model, self._name, self.joint_names, self.mimics)
        along.report(report)
        self.drives = read_actuators(model, self._name, self.joint_names, along, report)

    def read(self, name: str) -> RobotDescription:
        model = self.model
        if model.nbody < 2:
            self._refuse("<worldbody>", "has no body: must have one; add it")
        children = [k for k in range(1, model.nbody) if model.body_parentid[k] == 0]
        root, base, placement = 0, "fixed", WORLD
        is_one = len(children) == 1 and self._kind_of_root(children[0]) in ("none", "free")
        if is_one and not closes_to_world(model):
            root = children[0]
            base = "floating" if self._kind_of_root(root) == "free" else "fixed"
            placement = Placement(np.array(model.body_pos[root]), as_matrix(model.body_quat[root], "quat"))
        used = [k for k in range(model.nbody) if (k != 0 or root == 0) and k not in self.of_flexes]
        links = [link for k in used for link in self._links(k)]
        joints = [joint for k in used if k != root for joint in self._joints(k)]
        report_dropped(model, self.bodies, self.joint_names, self.report)
        self._report_outside(set(used))
        check_inertias([link for link in links if link.name != self.bodies[0]], self.report)
        excluded = [*untouching(model, used, self.report), *self._apart()]
        return RobotDescription(
            name,
            links,
            joints,
            excluded=[(self.bodies[a], self.bodies[b]) for a, b in excluded if a in used and b in used],
            base=base,
            placement=placement,
            report=self.report,
            flexes=read_flexes(self.spec, model, self.bodies.__getitem__, self.report),
            closures=read_closures(model, self.bodies, used, self.report),
        )

    # --- links ---

    def _links(self, body: int) -> list[Link]:
        """Of a body, and those between its joints, from the parent outwards."""
        name = self.bodies[body]
        return [*(Link(between, between=name) for between in self._between(body)), self._link(body)]

    def _between(self, body: int) -> list[str]:
        """Names of links between several joints of a body."""
        first, count = int(self.model.body_jntadr[body]), int(self.model.body_jntnum[body])
        return [f"{self.bodies[body]}_after_{self.joint_names[first + k]}" for k in range(count - 1)]

    def _apart(self) -> list[tuple[int, int]]:
        """Bodies and their parents that several joints connect: they do not touch, as those of one."""
        return [
            (int(self.model.body_parentid[k]), k)
            for k in range(self.model.nbody)
            if k not in self.of_flexes and len(self._between(k)) > 0
        ]

    def _link(self, body: int) -> Link:
        model, name = self.model, self.bodies[body]
        inertia = None
        if body > 0 and model.body_mass[body] > 0.0:
            axes = as_matrix(model.body_iquat[body], name)
            tensor = axes @ np.diag(model.body_inertia[body]) @ axes.T
            center = np.array(model.body_ipos[body])
            inertia = Inertia(float(model.body_mass[body]), center, 0.5 * (tensor + tensor.T))
        if body > 0 and np.any(getattr(model, "body_gravcomp", np.zeros(model.nbody))[body]):
            self.report.add("dropped", f"body '{name}'", "gravcomp")
        shown: list[Geometry] = []
        touching: list[Geometry] = []
        first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
        for geom in range(first, first + count):
            shape = self._geometry(geom, name)
            if shape is not None:
                (touching if self.touches[geom] else shown).append(shape)
        return Link(name, inertia, tuple(shown or touching), tuple(touching))

    def _geometry(self, geom: int, body: str) -> Geometry | None:
        model, kind = self.model, int(self.model.geom_type[geom])
        size = [float(value) for value in model.geom_size[geom]]
        r, g, b = self._color(geom)
        placed: dict[str, Any] = {
            "position": np.array(model.geom_pos[geom]),
            "rotation": as_matrix(model.geom_quat[geom], body),
            "color": (r, g, b),
        }
        if kind == _BOX:
            return Geometry("box", tuple(2.0 * edge for edge in size), **placed)
        if kind == _SPHERE:
            return Geometry("sphere", (size[0],), **placed)
        if kind in (_CYLINDER, _CAPSULE):
            shape = "cylinder" if kind == _CYLINDER else "capsule"
            return Geometry(shape, (size[0], 2.0 * size[1]), **placed)
        if kind == _ELLIPSOID:
            ball = meshes.sphere(1.0)
            scaled = ball.vertices * np.array(size)
            return Geometry("mesh", vertices=scaled, triangles=ball.triangles, **placed)
        if kind == _MESH:
            mesh = int(model.geom_dataid[geom])
            vertices, faces = int(model.mesh_vertadr[mesh]), int(model.mesh_faceadr[mesh])
            return Geometry(
                "mesh",
                vertices=np.array(
                    model.mesh_vert[vertices : vertices + model.mesh_vertnum[mesh]], dtype=np.float64
                ),
                triangles=np.array(model.mesh_face[faces : faces + model.mesh_facenum[mesh]], dtype=np.int32),
                **placed,
            )
        what = {_PLANE: "plane", _HFIELD: "height field"}.get(kind, f"geom of type {kind}")
        self.report.add("dropped", f"body '{body}'", f"a {what}: add a floor or a mesh to the scene")
        return None

    def _color(self, geom: int) -> list[float]:
        """Red, green, blue: its own, else that of its material."""
        model, own = self.model, self.model.geom_rgba[geom]
        material = int(model.geom_matid[geom])
        is_own = material < 0 or not np.array_equal(own, _GREY)
        return [float(value) for value in (own if is_own else model.mat_rgba[material])[:3]]

    # --- joints ---

    def _kind_of_root(self, body: int) -> str:
        count, first = int(self.model.body_jntnum[body]), int(self.model.body_jntadr[body])
        if count == 0:
            return "none"
        return "free" if count == 1 and self.model.jnt_type[first] == _FREE else "other"

    def _joints(self, body: int) -> list[RobotJoint]:
        """That of a body, or several in a row."""
        model, child = self.model, self.bodies[body]
        parent = self.bodies[int(model.body_parentid[body])]
        place = np.array(model.body_pos[body]), as_matrix(model.body_quat[body], child)
        count, first = int(model.body_jntnum[body]), int(model.body_jntadr[body])
        if count == 0:
            return [RobotJoint(f"{child}_fixed", "fixed", parent, child, *place)]
        if count > 1:
            names = ", ".join(f"'{name}'" for name in self.joint_names[first : first + count])
            self.report.add(
                "kept", f"body '{child}'", f"{names} in a row, with links without mass between them"
            )
        chain = [parent, *self._between(body), child]
        return [self._joint(first + k, chain[k], chain[k + 1], WORLD if k else place) for k in range(count)]

    def _joint(self, joint: int, parent: str, child: str, place: tuple[Floats, Floats]) -> RobotJoint:
        kind, name = int(self.model.jnt_type[joint]), self.joint_names[joint]
        if kind == _BALL:
            return self._ball(joint, parent, child, place)
        if kind == _FREE:
            return RobotJoint(name, "floating", parent, child, *place)
        return self._moving(joint, parent, child, place)

    def _ball(self, joint: int, parent: str, child: str, place: tuple[Floats, Floats]) -> RobotJoint:
        model, name, dof = self.model, self.joint_names[joint], int(self.model.jnt_dofadr[joint])
        self.report.add("kept", f"joint '{name}'", "a ball joint: no coordinate of q")
        given = {
            "its limit": bool(model.jnt_limited[joint]),
            "its spring": model.jnt_stiffness[joint] != 0.0,
            "damping": model.dof_damping[dof] != 0.0,
            "friction": model.dof_frictionloss[dof] != 0.0,
            "armature": model.dof_armature[dof] != 0.0,
        }
        if lost := ", ".join(what for what, is_given in given.items() if is_given):
            self.report.add("dropped", f"joint '{name}'", f"{lost}: of ball joints they are not kept")
        anchor = np.array(model.jnt_pos[joint])
        return RobotJoint(name, "ball", parent, child, *place, anchor=anchor)

    def _moving(self, joint: int, parent: str, child: str, place: tuple[Floats, Floats]) -> RobotJoint:
        model, name = self.model, self.joint_names[joint]
        dof, row = int(model.jnt_dofadr[joint]), int(model.jnt_qposadr[joint])
        limited = bool(model.jnt_limited[joint])
        lower, upper = (float(bound) for bound in model.jnt_range[joint])
        slides = int(model.jnt_type[joint]) == _SLIDE
        effort = self.drives.efforts.get(joint)
        if effort is None:
            self.report.add("assumed", f"joint '{name}'", "no limit of effort: none")
        for what in ("jnt_stiffnesspoly", "dof_dampingpoly"):
            values = getattr(model, what, None)
            if values is not None and np.any(np.asarray(values)[joint if "jnt" in what else dof]):
                self.report.add("dropped", f"joint '{name}'", f"{what[4:]}: only linear ones are kept")
        return RobotJoint(
            name,
            "prismatic" if slides else ("revolute" if limited else "continuous"),
            parent,
            child,
            *place,
            axis=np.array(model.jnt_axis[joint]),
            anchor=np.array(model.jnt_pos[joint]),
            reference=float(model.qpos0[row]),
            lower=lower if limited else None,
            upper=upper if limited else None,
            effort=effort,
            damping=float(model.dof_damping[dof]) + self.drives.damping.get(joint, 0.0),
            friction=float(model.dof_frictionloss[dof]),
            armature=float(model.dof_armature[dof]) + self.drives.armature.get(joint, 0.0),
            stiffness=float(model.jnt_stiffness[joint]),
            rest=float(model.qpos_spring[row]),
            mimic=self.mimics.get(joint),
            servo=self.drives.gains.get(joint),
        )

    # --- the rest ---

    def _report_outside(self, used: set[int]) -> None:
        """Shapes of the world, where it is no link: the robot is what hangs on its only body."""
        outside = [] if 0 in used else np.flatnonzero(self.model.geom_bodyid == 0).tolist()
        for geom in outside:
            name = self._name("geom", self.model.geom(geom).name, geom)
            text = f"geom '{name}': not of the robot; add what stands around it to the scene"
            self.report.add("dropped", "body 'world'", text)

    def _name(self, what: str, name: str, number: int) -> str:
        if name:
            return str(name)
        self.report.add("assumed", what, f"number {number} has no name: '{what}_{number}'")
        return f"{what}_{number}"

    def _refuse(self, part: str, text: str) -> NoReturn:
        raise InvalidArgument(f"{self.report.source}: {part}: {text}")

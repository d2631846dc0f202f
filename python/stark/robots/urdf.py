"""URDF files, read by yourdfpy. What it would guess or pass over is looked for in the XML first."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NoReturn
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.robots.checks import check_inertias
from stark.robots.description import KINDS, Geometry, Inertia, Link, Mimic, RobotDescription, RobotJoint
from stark.robots.report import Report
from stark.robots.urdf_contents import report_unread, take_quaternions
from stark.robots.xml import parsed

Floats = NDArray[np.float64]
Element = ElementTree.Element

#: Attributes that are numbers, and how many.
_NUMBERS: dict[str, dict[str, int | tuple[int, ...]]] = {
    "origin": {"xyz": 3, "rpy": 3, "quat_xyzw": 4},
    "axis": {"xyz": 3},
    "mass": {"value": 1},
    "inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1),
    "limit": dict.fromkeys(("lower", "upper", "effort", "velocity"), 1),
    "dynamics": {"damping": 1, "friction": 1},
    "mimic": {"multiplier": 1, "offset": 1},
    "box": {"size": 3},
    "sphere": {"radius": 1},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "color": {"rgba": 4},
    "mesh": {"scale": (3, 1)},
}
_REQUIRED = {
    "mass": ("value",),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "mesh": ("filename",),
    "mimic": ("joint",),
    "parent": ("link",),
    "child": ("link",),
}
_DROPPED = ("calibration", "safety_controller")
_KNOWN = {"link", "joint", "material"}
_XACRO = "/xacro}"  # ends the namespace of its elements


def read_urdf(file: Path, packages: Mapping[str, Path]) -> RobotDescription:
    """Reads a URDF file; errors as in ``stark.robots.read``. ``packages``: folders by name."""
    try:
        from yourdfpy import URDF
    except ImportError as error:
        raise ImportError(f"'{file}': URDF files need yourdfpy: pip install 'stark-sim[robots]'") from error
    report = Report(f"'{file}'")
    tree = parsed(file)
    _check_elements(tree, report)
    if not tree.get("name"):
        tree.set("name", file.stem)
        report.add("assumed", "<robot>", f"no name, which URDF demands: '{file.stem}', that of the file")
    try:
        robot = URDF.load(
            io.BytesIO(ElementTree.tostring(tree)),
            build_scene_graph=False,
            load_meshes=False,
            load_collision_meshes=False,
        ).robot
    except Exception as error:  # whatever lies beyond the checks
        raise InvalidArgument(f"{report.source}: yourdfpy cannot read it: {error}") from None
    find = _Files(file, packages, report)
    colors = {m.name: m.color.rgba[:3] for m in robot.materials if m.color is not None}
    links = [_link(link, find, colors) for link in robot.links]
    joints = [_joint(joint, report) for joint in robot.joints]
    check_inertias(links, report)
    return RobotDescription(robot.name, links, joints, report=report)


# --- the XML ---


def _check_elements(tree: Element, report: Report) -> None:
    """That names and numbers are there, and are numbers; reports what is not read."""
    macros = next((element.tag for element in tree.iter() if _XACRO in str(element.tag)), None)
    if macros is not None:
        name = str(macros).rpartition("}")[2]
        _refuse(
            report,
            f"<xacro:{name}>",
            "is a macro: must be expanded first; write the file by `xacro robot.xacro > robot.urdf`",
        )
    for element in tree:
        title = _title(element)
        if element.tag not in _KNOWN:
            report.add("dropped", title, "is not read")
            continue
        if not element.get("name"):
            _refuse(report, f"<{element.tag}>", "name: must be given; add name='...'")
        if element.tag == "joint":
            _check_joint(element, title, report)
        for part in element.iter():
            _check_numbers(part, title, report)
        if element.tag == "link":
            _check_link(element, title, report)
        if element.tag in ("link", "joint"):
            take_quaternions(element, title, report)
            report_unread(element, title, report)


def _check_numbers(part: Element, title: str, report: Report) -> None:
    for attribute, count in _NUMBERS.get(part.tag, {}).items():
        text = part.get(attribute)
        if text is None:
            continue
        try:
            values = [float(word) for word in text.split()]
        except ValueError:
            values = []
        counts = count if isinstance(count, tuple) else (count,)
        if len(values) not in counts or not all(map(math.isfinite, values)):
            wanted = "a finite number" if counts == (1,) else f"{counts[0]} finite numbers"
            _refuse(report, title, f"<{part.tag} {attribute}='{text}'>: must be {wanted}; correct it")
    for attribute in _REQUIRED.get(part.tag, ()):
        if part.get(attribute) is None:
            _refuse(report, title, f"<{part.tag}>: {attribute} is missing: must be given; add it")


def _check_joint(element: Element, title: str, report: Report) -> None:
    kind = element.get("type")
    if kind not in KINDS:
        _refuse(
            report,
            title,
            f"type = {kind!r}: must be one of {', '.join(KINDS)}; model a planar joint by two prismatic "
            f"and a continuous one",
        )
    for tag in ("parent", "child"):
        if element.find(tag) is None:
            _refuse(report, title, f"<{tag}> is missing: must be given; add <{tag} link='...'/>")
    for tag in _DROPPED:
        if element.find(tag) is not None:
            report.add("dropped", title, f"<{tag}> is not read")
    if kind in ("revolute", "continuous", "prismatic") and element.find("axis") is None:
        report.add("assumed", title, "no <axis>: x, as URDF has it")
    mimic = element.find("mimic")
    if mimic is not None and kind == "fixed":
        report.add("dropped", title, "<mimic>: fixed joints follow nothing")
    elif mimic is not None:
        for attribute, value in (("multiplier", 1), ("offset", 0)):
            if mimic.get(attribute) is None:
                report.add("assumed", title, f"<mimic> without {attribute}: {value}, as URDF has it")


def _check_link(element: Element, title: str, report: Report) -> None:
    inertial = element.find("inertial")
    if inertial is not None:
        for tag in ("mass", "inertia"):
            if inertial.find(tag) is None:
                _refuse(report, title, f"<inertial> has no <{tag}>: must have one; add it")
    for shape in (*element.findall("visual"), *element.findall("collision")):
        geometry = shape.find("geometry")
        kinds = [] if geometry is None else [part.tag for part in geometry]
        if "material" in kinds[1:]:
            kinds.remove("material")
            report.add("dropped", title, f"<material> inside of the <geometry> of <{shape.tag}>")
        if len(kinds) != 1 or kinds[0] not in ("box", "sphere", "cylinder", "mesh"):
            _refuse(
                report,
                title,
                f"<{shape.tag}> with the geometry {', '.join(kinds) or 'none'}: must be one of box, "
                f"sphere, cylinder, mesh; replace it",
            )


def _title(element: Element) -> str:
    name = element.get("name")
    return f"<{element.tag}>" if name is None else f"{element.tag} '{name}'"


# --- from yourdfpy ---


class _Files:
    """Finds mesh files."""

    def __init__(self, file: Path, packages: Mapping[str, Path], report: Report) -> None:
        self._folder, self._packages, self._report = file.resolve().parent, packages, report

    def __call__(self, name: str, title: str) -> Path:
        for candidate in self._candidates(name):
            if candidate.is_file():
                return candidate
        hint = "; give packages={'name': folder}" if name.startswith("package://") else ""
        _refuse(self._report, title, f"mesh '{name}': must be a file; looked beside the URDF file{hint}")

    def _candidates(self, name: str) -> Iterator[Path]:
        if not name.startswith(("package://", "model://")):
            path = name.removeprefix("file://")
            yield self._folder / path
            return
        package, _, inner = name.partition("://")[2].partition("/")
        if package in self._packages:
            yield self._packages[package] / inner
            return
        for folder in (self._folder, *self._folder.parents):
            yield folder / package / inner
            if folder.name == package:
                yield folder / inner


def _link(link: Any, find: _Files, colors: Mapping[str, Floats]) -> Link:
    title = f"link '{link.name}'"
    inertia = None
    if link.inertial is not None:
        position, rotation = _placed(link.inertial.origin)
        tensor = rotation @ np.asarray(link.inertial.inertia, dtype=np.float64) @ rotation.T
        inertia = Inertia(float(link.inertial.mass), position, 0.5 * (tensor + tensor.T))
    visuals = [_geometry(shape, find, title, _color(shape.material, colors)) for shape in link.visuals]
    collisions = [_geometry(shape, find, title, None) for shape in link.collisions]
    return Link(link.name, inertia, tuple(visuals), tuple(collisions))


def _color(material: Any, colors: Mapping[str, Floats]) -> tuple[float, float, float] | None:
    if material is None:
        return None
    rgb = material.color.rgba[:3] if material.color is not None else colors.get(material.name)
    return None if rgb is None else (float(rgb[0]), float(rgb[1]), float(rgb[2]))


def _geometry(shape: Any, find: _Files, title: str, color: tuple[float, float, float] | None) -> Geometry:
    position, rotation = _placed(shape.origin)
    geometry = shape.geometry
    if geometry.mesh is not None:
        scale = np.ones(3) if geometry.mesh.scale is None else geometry.mesh.scale * np.ones(3)
        file = find(geometry.mesh.filename, title)
        return Geometry("mesh", (), position, rotation, file, scale, color=color)
    if geometry.box is not None:
        kind, size = "box", tuple(float(edge) for edge in geometry.box.size)
    elif geometry.sphere is not None:
        kind, size = "sphere", (float(geometry.sphere.radius),)
    else:
        kind, size = "cylinder", (float(geometry.cylinder.radius), float(geometry.cylinder.length))
    return Geometry(kind, size, position, rotation, color=color)


def _joint(joint: Any, report: Report) -> RobotJoint:
    title = f"joint '{joint.name}'"
    position, rotation = _placed(joint.origin)
    moving = joint.type in ("revolute", "continuous", "prismatic")
    axis = np.asarray(joint.axis, dtype=np.float64)
    length = float(np.linalg.norm(axis))
    if moving and not length > 0.0:
        _refuse(report, title, f"<axis xyz='{axis.tolist()}'>: must not be zero; give a direction")
    limits = _limits(joint, title, report) if moving else {}
    if moving and joint.dynamics is not None:
        # yourdfpy leaves texts here.
        limits |= {
            "damping": float(joint.dynamics.damping or 0.0),
            "friction": float(joint.dynamics.friction or 0.0),
        }
    elif joint.dynamics is not None and (joint.dynamics.damping or joint.dynamics.friction):
        report.add("dropped", title, f"<dynamics>: {joint.type} joints have no damping and no friction")
    mimic = None
    if joint.mimic is not None and joint.type != "fixed":
        mimic = Mimic(joint.mimic.joint, float(joint.mimic.multiplier), float(joint.mimic.offset))
    return RobotJoint(
        joint.name,
        joint.type,
        joint.parent,
        joint.child,
        position,
        rotation,
        axis / length if moving else np.array([1.0, 0.0, 0.0]),
        mimic=mimic,
        **limits,
    )


def _limits(joint: Any, title: str, report: Report) -> dict[str, Any]:
    """Those of a joint that moves; 0 stands for no limit of effort and velocity in many files, for nothing
    in those that mean it."""
    limit, found = joint.limit, {}
    if limit is None:
        if joint.type != "continuous":
            _refuse(report, title, "<limit> is missing: revolute and prismatic joints must have one; add it, "
                    "or make the joint continuous")  # fmt: skip
        report.add("assumed", title, "no <limit>: no limit of effort and velocity")
        return {}
    for what in ("effort", "velocity"):
        value = getattr(limit, what)
        if value is None:
            report.add("assumed", title, f"no limit of {what}, which URDF demands: none")
        elif value == 0.0:
            report.add("suspicious", title, f"limit of {what} 0: taken as none; drives need a cap")
        elif value < 0.0:
            _refuse(report, title, f"<limit {what}='{value:g}'>: must be >= 0; correct it")
        else:
            found[what] = float(value)
    if joint.type == "continuous":
        if limit.lower or limit.upper:
            report.add("dropped", title, "lower and upper limits: continuous joints have none")
        return found
    if not limit.lower and not limit.upper:
        # URDF takes 0 where they are missing. Nobody means a joint that cannot move.
        report.add("suspicious", title, "lower and upper limits 0, or none: taken as without limits")
        return found
    for what in ("lower", "upper"):
        value = getattr(limit, what)
        if value is None:
            report.add("assumed", title, f"<limit> without {what}: 0, as URDF has it")
        found[what] = float(value or 0.0)
    return found


def _placed(origin: Any) -> tuple[Floats, Floats]:
    if origin is None:
        return np.zeros(3), np.eye(3)
    matrix = np.asarray(origin, dtype=np.float64)
    return matrix[:3, 3].copy(), matrix[:3, :3].copy()


def _refuse(report: Report, title: str, text: str) -> NoReturn:
    raise InvalidArgument(f"{report.source}: {title}: {text}")

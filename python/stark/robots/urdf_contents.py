"""What of URDF files nothing reads, and quaternions of URDF 1.2 as the angles of earlier versions."""

from __future__ import annotations

import math
from collections.abc import Iterator
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.robots.report import Report
from stark.rotations import as_matrix

Element = ElementTree.Element

_SHAPES = ("box", "sphere", "cylinder", "mesh")
#: What is read, by element: the elements inside of it, and its attributes. <calibration>,
#: <safety_controller> and <material> in a <geometry> are reported elsewhere.
_READ: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "link": (("inertial", "visual", "collision"), ("name",)),
    "joint": (
        (
            "origin",
            "parent",
            "child",
            "axis",
            "limit",
            "dynamics",
            "mimic",
            "calibration",
            "safety_controller",
        ),
        ("name", "type"),
    ),
    "inertial": (("origin", "mass", "inertia"), ()),
    "visual": (("origin", "geometry", "material"), ("name",)),
    "collision": (("origin", "geometry"), ("name",)),
    "geometry": ((*_SHAPES, "material"), ()),
    "material": (("color",), ("name",)),
    "origin": ((), ("xyz", "rpy")),
    "axis": ((), ("xyz",)),
    "mass": ((), ("value",)),
    "inertia": ((), ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")),
    "limit": ((), ("lower", "upper", "effort", "velocity")),
    "dynamics": ((), ("damping", "friction")),
    "mimic": ((), ("joint", "multiplier", "offset")),
    "parent": ((), ("link",)),
    "child": ((), ("link",)),
    "box": ((), ("size",)),
    "sphere": ((), ("radius",)),
    "cylinder": ((), ("radius", "length")),
    "mesh": ((), ("filename", "scale")),
    "color": ((), ("rgba",)),
}
#: Elements of which there may be several.
_SEVERAL = {"visual", "collision"}


def report_unread(element: Element, title: str, report: Report) -> None:
    """Names each element and attribute of a link or joint that nothing reads, and those there twice."""
    for part, inside in _parts(element):
        tags = [str(child.tag) for child in part]
        for tag in dict.fromkeys(tags):
            if tag not in inside:
                report.add("dropped", title, f"<{tag}> in <{part.tag}> is not read")
            elif tags.count(tag) > 1 and tag not in _SEVERAL and part.tag != "geometry":
                report.add(
                    "suspicious", title, f"<{tag}> is there {tags.count(tag)} times: the first is taken"
                )
        for attribute, value in part.items():
            if attribute in _READ[str(part.tag)][1]:
                continue
            report.add("dropped", title, f"<{part.tag} {attribute}='{value}'> is not read")


def _parts(element: Element) -> Iterator[tuple[Element, tuple[str, ...]]]:
    """An element and those in it that are read, with the names of those that these may have in them."""
    inside = _READ[str(element.tag)][0]
    yield element, inside
    for part in element:
        if part.tag in inside and part.tag in _READ:
            yield from _parts(part)


def take_quaternions(element: Element, title: str, report: Report) -> None:
    """Replaces ``quat_xyzw`` of the origins in a link or joint by ``rpy``."""
    for origin in element.iter("origin"):
        text = origin.attrib.pop("quat_xyzw", None)
        if text is None:
            continue
        written = f"{report.source}: {title}: <origin quat_xyzw='{text}'>"
        if origin.get("rpy") is not None:
            raise InvalidArgument(f"{written}: must not stand beside rpy; remove one of them")
        x, y, z, w = (float(word) for word in text.split())
        if not math.hypot(x, y, z, w) > 0.0:
            raise InvalidArgument(f"{written}: must not be zero; correct it")
        turned = as_matrix(np.array([w, x, y, z]) / math.hypot(x, y, z, w), title)
        origin.set("rpy", " ".join(repr(angle) for angle in _roll_pitch_yaw(turned)))


def _roll_pitch_yaw(turned: NDArray[np.float64]) -> tuple[float, float, float]:
    """Angles [rad] about the fixed axes x, y, z, one after the other."""
    level = math.hypot(turned[0, 0], turned[1, 0])
    pitch = math.atan2(-turned[2, 0], level)
    if level < 1e-9:  # x points up or down: roll and yaw turn about the same axis
        return math.atan2(-turned[1, 2], turned[1, 1]), pitch, 0.0
    roll = math.atan2(turned[2, 1], turned[2, 2])
    return roll, pitch, math.atan2(turned[1, 0], turned[0, 0])

"""What a robot is, whatever file it comes from: links with inertia and shapes, joints in a tree."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn, TypeVar

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.arguments import given_choice, given_word, is_iterable, real_array, real_number, shown_value
from stark.robots.report import Report
from stark.rotations import as_matrix, vector

Floats = NDArray[np.float64]

#: Kinds of joints; those of MOVING have one coordinate.
KINDS = ("fixed", "revolute", "continuous", "prismatic", "ball", "floating")
CLOSING = ("ball", "fixed")
MOVING = ("revolute", "continuous", "prismatic")
SHAPES = ("box", "sphere", "cylinder", "capsule", "mesh")


def _origin() -> Floats:
    return np.zeros(3)


def _unturned() -> Floats:
    return np.eye(3)


def _take(part: object, owner: str, vectors: tuple[str, ...], rotations: tuple[str, ...] = ()) -> None:
    """Makes arrays of the vectors and rotations of a frozen part; InvalidArgument for what is none."""
    for name in vectors:
        object.__setattr__(part, name, vector(getattr(part, name), f"{owner}: {name}"))
    for name in rotations:
        object.__setattr__(part, name, as_matrix(getattr(part, name), f"{owner}: {name}"))


@dataclass(frozen=True, eq=False)
class Geometry:
    """A shape of a link. ``size`` [m]: edges of a box, radius of a sphere, (radius, length) of a cylinder or
    of a capsule (between the centres of its half spheres), both about z. A mesh has a ``file`` and a
    ``scale`` (3,), or ``vertices`` (n, 3) [m] and ``triangles`` (m, 3)."""

    kind: str
    size: tuple[float, ...] = ()
    position: Floats = field(default_factory=_origin)  # [m] in the frame of the link
    rotation: Floats = field(default_factory=_unturned)
    file: Path | None = None
    scale: Floats = field(default_factory=lambda: np.ones(3))
    vertices: Floats | None = None
    triangles: NDArray[np.int32] | None = None
    color: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.kind, str) or self.kind not in SHAPES:
            raise InvalidArgument(f"shape: kind = {self.kind!r}: must be one of {', '.join(SHAPES)}")
        owner = f"shape {self.kind}"
        numbers = {"box": 3, "sphere": 1, "cylinder": 2, "capsule": 2}.get(self.kind, 0)
        size = real_array(self.size, f"{owner}: size")
        if numbers and size.shape != (numbers,):
            raise InvalidArgument(f"{owner}: size = {self.size!r}: must have {numbers} numbers [m]")
        _take(self, owner, ("position", "scale"), ("rotation",))


@dataclass(frozen=True, eq=False)
class Inertia:
    """``mass`` [kg], ``center`` of mass (3,) [m] in the frame of the link, ``tensor`` (3, 3) [kg m^2] about
    the centre of mass in the axes of the link."""

    mass: float
    center: Floats
    tensor: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", real_number(self.mass, "inertia: mass"))
        _take(self, "inertia", ("center",))
        tensor = real_array(self.tensor, "inertia: tensor")
        if tensor.shape != (3, 3) or not np.isfinite(tensor).all():
            raise InvalidArgument(f"inertia: tensor = {self.tensor!r}: must be a 3x3 matrix, finite")
        object.__setattr__(self, "tensor", tensor)

    def moved(self, position: Floats, rotation: Floats) -> Inertia:
        """The same in a frame in which the link stands at ``position`` (3,) [m] with ``rotation``."""
        return Inertia(self.mass, position + rotation @ self.center, rotation @ self.tensor @ rotation.T)

    @staticmethod
    def sum(parts: Iterable[Inertia]) -> Inertia:
        """Of several parts in one frame that move as one."""
        rows = list(parts)
        mass = sum(row.mass for row in rows)
        center = sum((row.mass * row.center for row in rows), np.zeros(3)) / mass
        tensor = np.zeros((3, 3))
        for row in rows:
            d = row.center - center
            tensor += row.tensor + row.mass * (d @ d * np.eye(3) - np.outer(d, d))
        return Inertia(mass, center, 0.5 * (tensor + tensor.T))


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid part. Links without ``inertia`` have no mass. One ``between`` several joints of another link,
    which is named there, needs none: a scene gives it 10^-4 of that of the other link."""

    name: str
    inertia: Inertia | None = None
    visuals: tuple[Geometry, ...] = ()
    collisions: tuple[Geometry, ...] = ()
    between: str | None = None

    def __post_init__(self) -> None:
        owner = f"link {self.name!r}"
        if self.inertia is not None and not isinstance(self.inertia, Inertia):
            raise InvalidArgument(f"{owner}: inertia = {self.inertia!r}: must be a stark.robots.Inertia")
        for name in ("visuals", "collisions"):
            shapes = getattr(self, name)
            if not is_iterable(shapes) or not all(isinstance(one, Geometry) for one in shapes):
                raise InvalidArgument(
                    f"{owner}: {name} = {shapes!r}: must be a tuple of stark.robots.Geometry"
                )
            object.__setattr__(self, name, tuple(shapes))


@dataclass(frozen=True)
class Mimic:
    """A joint follows another one: q = ``ratio`` times that of ``joint`` + ``offset`` [rad, m]."""

    joint: str
    ratio: float = 1.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        for name in ("ratio", "offset"):
            value = real_number(getattr(self, name), f"mimic of {self.joint!r}: {name}")
            if not np.isfinite(value):
                raise InvalidArgument(f"mimic of {self.joint!r}: {name} = {value}: must be finite")
            object.__setattr__(self, name, value)


@dataclass(frozen=True)
class Gains:
    """Of the servo that a file has on a joint: ``stiffness`` [N m/rad, N/m], ``damping`` [N m s/rad,
    N s/m]."""

    stiffness: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        for name in ("stiffness", "damping"):
            object.__setattr__(self, name, real_number(getattr(self, name), f"gains: {name}"))


@dataclass(frozen=True, eq=False)
class RobotJoint:
    """A joint of a description. ``position`` (3,) [m] and ``rotation`` (3, 3) place the frame of the child in
    that of the parent at q = ``reference``; the ``axis`` goes through ``anchor`` [m], both in the frame of
    the child. Limits in rad and m, ``effort`` in N m and N, rates per second; None where there is none."""

    name: str
    kind: str
    parent: str
    child: str
    position: Floats = field(default_factory=_origin)
    rotation: Floats = field(default_factory=_unturned)
    axis: Floats = field(default_factory=lambda: np.array([1.0, 0.0, 0.0]))
    anchor: Floats = field(default_factory=_origin)
    reference: float = 0.0
    lower: float | None = None
    upper: float | None = None
    effort: float | None = None
    velocity: float | None = None
    damping: float = 0.0
    friction: float = 0.0
    armature: float = 0.0
    stiffness: float = 0.0  # of a spring
    rest: float = 0.0  # of that spring
    mimic: Mimic | None = None
    servo: Gains | None = None

    def __post_init__(self) -> None:
        owner = f"joint {self.name!r}"
        for name in ("kind", "parent", "child"):
            given_word(getattr(self, name), f"{owner}: {name}")
        for name, kind in (("mimic", Mimic), ("servo", Gains)):
            if (value := getattr(self, name)) is not None and not isinstance(value, kind):
                raise InvalidArgument(f"{owner}: {name} = {value!r}: must be a stark.robots.{kind.__name__}")
        _take(self, owner, ("position", "axis", "anchor"), ("rotation",))
        for name in ("lower", "upper", "effort", "velocity"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, real_number(getattr(self, name), f"{owner}: {name}"))
        for name, never in (("lower", np.inf), ("upper", -np.inf)):
            if (value := getattr(self, name)) is not None and (value == never or np.isnan(value)):
                raise InvalidArgument(f"{owner}: {name} = {value}: must be a number, or None for no limit")
        for name in ("reference", "damping", "friction", "armature", "stiffness", "rest"):
            object.__setattr__(self, name, real_number(getattr(self, name), f"{owner}: {name}"))

    @property
    def is_moving(self) -> bool:
        """Whether it has a coordinate."""
        return self.kind in MOVING

    @property
    def unit(self) -> str:
        """Of its coordinate."""
        return "m" if self.kind == "prismatic" else "rad"


@dataclass(frozen=True, eq=False)
class Closure:
    """What closes a loop: a joint of a ``kind``, "ball" or "fixed", between two ``links`` of the tree.
    ``frames``: origin (3,) [m] and axes (3, 3) of the joint in each of them."""

    name: str
    kind: str
    links: tuple[str, str]
    frames: tuple[tuple[Floats, Floats], tuple[Floats, Floats]]


@dataclass(frozen=True, eq=False)
class Flex:
    """A deformable part: a cloth (triangles), a solid (tetrahedra) or a rod (edges, each vertex joined to the
    next) whose ``vertices`` (n, 3) [m] are those of rest, in the frame of a link."""

    name: str
    link: str
    vertices: Floats
    cells: NDArray[np.int32]
    mass: float
    """[kg] of the whole."""
    held: tuple[int, ...] = ()
    """Vertices that are fixed to the link."""
    youngs_modulus: float = 0.0
    """[Pa], 0 where the file says nothing."""
    poissons_ratio: float = 0.0
    thickness: float = 0.0
    """[m], of a cloth; diameter of a rod."""
    bends: bool = True
    """Whether a cloth resists bending."""
    flexural_rigidity: float | None = None
    """Of a cloth [N m]; None: that of a plate of its modulus and thickness."""
    rod_stiffnesses: Mapping[str, float] = field(default_factory=dict)
    """Of a rod, where it is not its section that has them: ``axial_stiffness`` and ``shear_stiffness`` [N],
    ``bending_stiffness`` and ``torsional_stiffness`` [N m^2]."""
    start: Floats | None = None
    """Where it starts (n, 3) [m], if not at rest."""
    folds_at_rest: bool = False
    """Whether a cloth keeps the folds of its shape at rest; it is flat otherwise."""
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """At the start [m/s], in the frame of the link."""
    damping: float = 0.0
    """Of strain, over the modulus [s]."""
    radius: float = 0.0
    """How far the file has its surface before its vertices [m]."""
    touches: bool = True
    touches_itself: bool = True
    color: tuple[float, float, float] | None = None

    @property
    def is_solid(self) -> bool:
        """Whether it becomes a solid (three dimensions), not a cloth (two) or a rod (one)."""
        is_solid: bool = self.cells.shape[1] == 4
        return is_solid

    @property
    def is_rod(self) -> bool:
        """Whether it becomes a rod (one dimension)."""
        is_rod: bool = self.cells.shape[1] == 2
        return is_rod


_Part = TypeVar("_Part", Link, RobotJoint, Closure, Flex)


class RobotDescription:
    """Links and joints of a robot, checked: names are unique, joints make one tree.

    Raises InvalidArgument, which names the source, the part, the rule and the remedy."""

    def __init__(
        self,
        name: str,
        links: Iterable[Link],
        joints: Iterable[RobotJoint],
        *,
        excluded: Iterable[tuple[str, str]] = (),
        base: str = "fixed",
        placement: tuple[Floats, Floats] | None = None,
        report: Report | None = None,
        flexes: Iterable[Flex] = (),
        closures: Iterable[Closure] = (),
    ) -> None:
        self.name: str = given_word(name, "description: name")
        if report is not None and not isinstance(report, Report):
            raise InvalidArgument(
                f"description '{name}': report = {shown_value(report)}: must be a stark.robots.Report"
            )
        self.report: Report = Report(f"description '{name}'") if report is None else report
        self.base: str = given_choice(base, ("fixed", "floating"), f"{self.report.source}: base")
        """What the file says of its base: "fixed" or "floating"."""
        self.placement: tuple[Floats, Floats] = _placed(placement, f"{self.report.source}: placement")
        """Where the file places the base: position (3,) [m] and rotation (3, 3)."""
        self.links: dict[str, Link] = _by_name("link", links, self.report.source)
        by_name = _by_name("joint", joints, self.report.source)
        self.root: str = self._root(by_name)
        self.joints: dict[str, RobotJoint] = self._sorted(by_name)
        """By name, each after the one that carries its parent."""
        self.outwards: tuple[RobotJoint, ...] = tuple(self.joints.values())
        """The same, from the root to the tips."""
        self._coordinates = tuple(j.name for j in self.outwards if j.is_moving and j.mimic is None)
        self.excluded: tuple[tuple[str, str], ...] = _pairs(excluded, f"{self.report.source}: excluded")
        """Pairs of links that do not touch, beside those that a joint connects."""
        self.flexes: dict[str, Flex] = _by_name("flex", flexes, self.report.source)
        """Deformable parts by name."""
        self.closures: dict[str, Closure] = _by_name("closure", closures, self.report.source)
        """What closes loops, by name."""
        self._check()

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the joints that have a coordinate and mimic no other one: the order of q (n,)."""
        return self._coordinates

    @property
    def source(self) -> str:
        """The file, as messages call it."""
        return self.report.source

    def drive_of(self, joint: RobotJoint) -> tuple[str, float, float]:
        """The joint whose coordinate moves this one, with ratio and offset; through several mimics."""
        ratio, offset = 1.0, 0.0
        while joint.mimic is not None:
            offset += ratio * joint.mimic.offset
            ratio *= joint.mimic.ratio
            joint = self.joints[joint.mimic.joint]
        return joint.name, ratio, offset

    def __repr__(self) -> str:
        return (
            f"<RobotDescription '{self.name}': {len(self.links)} links, {len(self.coordinates)} coordinates>"
        )

    # --- checks ---

    def _root(self, joints: dict[str, RobotJoint]) -> str:
        parents: dict[str, str] = {}
        for joint in joints.values():
            for what, link in (("parent", joint.parent), ("child", joint.child)):
                if link not in self.links:
                    self._refuse(
                        f"joint '{joint.name}'",
                        f"{what} = '{link}': must be one of the links; add the link or correct the name",
                    )
            if joint.child in parents:
                self._refuse(
                    f"link '{joint.child}'",
                    f"is the child of the joints '{parents[joint.child]}' and '{joint.name}': must be that "
                    f"of one; close loops with scene.add_joint after the robot is added",
                )
            parents[joint.child] = joint.name
        roots = [name for name in self.links if name not in parents]
        if len(roots) != 1:
            found = ", ".join(f"'{name}'" for name in roots[:4]) or "none"
            self._refuse(
                "links", f"without a parent: {found}: must be exactly one, the base; join them by joints"
            )
        return roots[0]

    def _sorted(self, joints: dict[str, RobotJoint]) -> dict[str, RobotJoint]:
        found: dict[str, RobotJoint] = {}
        stack = [self.root]
        while stack:
            link = stack.pop()
            outwards = [joint for joint in joints.values() if joint.parent == link]
            found |= {joint.name: joint for joint in outwards}
            stack += [joint.child for joint in reversed(outwards)]
        if len(found) < len(joints):
            inside = ", ".join(f"'{name}'" for name in joints if name not in found)
            self._refuse("joints", f"{inside} make a circle: must make a tree from '{self.root}' outwards")
        order = {name: k for k, name in enumerate(joints)}
        parent_of = {joint.child: joint.name for joint in joints.values()}
        # As in the file where it goes from the root outwards, so that q is in the order of the file.
        if all(order.get(parent_of.get(j.parent, ""), -1) < order[j.name] for j in joints.values()):
            return joints
        return found

    def _check(self) -> None:
        for joint in self.joints.values():
            part = f"joint '{joint.name}'"
            if joint.kind not in KINDS:
                self._refuse(part, f"kind = '{joint.kind}': must be one of {', '.join(KINDS)}")
            length = float(np.linalg.norm(joint.axis))
            if joint.is_moving and not abs(length - 1.0) < 1e-6:
                self._refuse(part, f"axis has the length {length:.6g}: must be 1; normalise it")
            if joint.lower is not None and joint.upper is not None and not joint.lower < joint.upper:
                self._refuse(
                    part,
                    f"lower = {joint.lower:g}, upper = {joint.upper:g} {joint.unit}: lower must be below "
                    f"upper; make a joint that does not move a fixed one",
                )
            for what in ("effort", "velocity", "damping", "friction", "armature", "stiffness"):
                value = getattr(joint, what)
                if value is not None and not value >= 0.0:
                    self._refuse(part, f"{what} = {value:g}: must be >= 0")
            for what in () if joint.servo is None else ("stiffness", "damping"):
                if not (value := getattr(joint.servo, what)) >= 0.0:
                    self._refuse(part, f"{what} of its servo = {value:g}: must be >= 0")
            self._check_mimic(part, joint)
        for a, b in self.excluded:
            for link in (a, b):
                if link not in self.links:
                    self._refuse("excluded pair", f"'{link}': must be the name of a link")
        for flex in self.flexes.values():
            if flex.link not in self.links:
                self._refuse(f"flex '{flex.name}'", f"link '{flex.link}': must be the name of a link")
        for closure in self.closures.values():
            self._check_closure(f"closure '{closure.name}'", closure)

    def _check_closure(self, part: str, closure: Closure) -> None:
        if closure.kind not in CLOSING:
            self._refuse(part, f"kind = '{closure.kind}': must be one of {', '.join(CLOSING)}")
        for link in closure.links:
            if link not in self.links:
                self._refuse(part, f"link '{link}': must be the name of a link")
        if closure.links[0] == closure.links[1]:
            self._refuse(part, f"links = {closure.links}: must be two; correct it")
        if closure.name in self.joints:
            self._refuse(part, "has the name of a joint: must have its own; rename one")

    def _check_mimic(self, part: str, joint: RobotJoint) -> None:
        seen = [joint.name]
        while joint.mimic is not None:
            other = self.joints.get(joint.mimic.joint)
            if other is None or not other.is_moving or not joint.is_moving:
                self._refuse(
                    part, f"mimics '{joint.mimic.joint}': both must be joints that turn or slide; correct it"
                )
            if other.name in seen:
                self._refuse(part, f"mimics itself, by way of {', '.join(seen)}: one of them must not mimic")
            seen.append(other.name)
            joint = other

    def _refuse(self, part: str, text: str) -> NoReturn:
        raise InvalidArgument(f"{self.source}: {part}: {text}")


def _listed(what: str, rows: Iterable[_Part], source: str) -> list[_Part]:
    kind = {"link": Link, "joint": RobotJoint, "closure": Closure, "flex": Flex}[what]
    if not is_iterable(rows):
        raise InvalidArgument(f"{source}: {what}s = {rows!r}: must be a list of stark.robots.{kind.__name__}")
    found = list(rows)
    for row in found:
        if not isinstance(row, kind):
            raise InvalidArgument(f"{source}: {what} {row!r}: must be a stark.robots.{kind.__name__}")
    return found


def _by_name(what: str, rows: Iterable[_Part], source: str) -> dict[str, _Part]:
    found: dict[str, _Part] = {}
    for row in _listed(what, rows, source):
        if not isinstance(row.name, str) or not row.name:
            raise InvalidArgument(f"{source}: a {what} has no name: must have one; name it")
        if row.name in found:
            raise InvalidArgument(
                f"{source}: {what} '{row.name}': is there twice: names must be unique; rename one"
            )
        found[row.name] = row
    return found


def _placed(placement: Any, what: str) -> tuple[Floats, Floats]:
    if placement is None:
        return _origin(), _unturned()
    if not isinstance(placement, (tuple, list)) or len(placement) != 2:
        raise InvalidArgument(f"{what} = {placement!r}: must be (position (3,) [m], rotation (3, 3))")
    return vector(placement[0], f"{what}: position"), as_matrix(placement[1], f"{what}: rotation")


def _pairs(excluded: Any, what: str) -> tuple[tuple[str, str], ...]:
    pairs = tuple(excluded) if is_iterable(excluded) and not isinstance(excluded, str) else (excluded,)
    for pair in pairs:
        if not isinstance(pair, (tuple, list)) or len(pair) != 2 or not all(isinstance(x, str) for x in pair):
            raise InvalidArgument(
                f"{what} = {excluded!r}: must be pairs of names of links, as [('wrist', 'base')]"
            )
    return tuple((a, b) for a, b in pairs)

"""The joint methods of a scene."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from stark._core import InvalidArgument
from stark.arguments import real_number, refuse_masked, shown_value
from stark.bodies import Body
from stark.handle import SceneLink
from stark.named import NamedTuple
from stark.rotations import Vec3Like, direction, vector
from stark.selections import FrameHandle

if TYPE_CHECKING:
    from stark.joints.definition import JointFormula
    from stark.joints.handle import Actuator, Joint

Side: TypeAlias = Body | FrameHandle | str | None


class SceneJoints(SceneLink):
    """What ``stark.Scene`` knows about joints.

    The sides ``a`` and ``b`` of a joint are rigid bodies, None for the world, or frames: ``box.frame(...)``,
    ``cloth.frame((i, j, k))`` (a patch of three vertices), ``stark.world_frame(...)``. Bodies get frames at
    ``anchor`` [m], in the world at time 0. Coordinates are those of b against a. Two bodies that a joint
    connects do
    not touch each other unless ``contact=True``."""

    _joints: list[Joint]

    def add_joint(
        self,
        kind: str | JointFormula,
        a: Side,
        b: Side,
        *,
        anchor: Vec3Like | None = None,
        axis: str | Vec3Like | None = None,
        rotation: ArrayLike | None = None,
        name: str | None = None,
        contact: bool = False,
        enabled: bool = True,
        break_force: float | None = None,
        break_torque: float | None = None,
        **values: Any,
    ) -> Joint:
        """Adds a joint of any kind: the name of a built-in one or a function with ``@stark.joint``.

        ``axis`` ("x", "y", "z" or three numbers) is the z axis of both frames, or ``rotation`` (matrix or
        quaternion) gives all axes, in the world at time 0; without them, a body gets the frame of the other
        side. ``values``: constants that the kind has. A joint whose reaction exceeds ``break_force`` [N] or
        ``break_torque`` [N m], about the origin of frame b, in a step is released at its end for good.
        Joints are held within ``joints.length_tolerance`` and ``joints.angle_tolerance`` of the settings."""
        from stark.joints.adding import add_joint

        joint = add_joint(
            self,
            kind,
            a,
            b,
            anchor=anchor,
            axis=axis,
            rotation=rotation,
            name=name,
            contact=contact,
            enabled=enabled,
            break_force=break_force,
            break_torque=break_torque,
            values=values,
        )
        self._joints.append(joint)
        self._warn_of_late(f"joint '{joint.name}'")
        return joint

    def add_fixed(self, a: Side, b: Side, anchor: Vec3Like | None = None, **options: Any) -> Joint:
        """Welds b to a as they are at time 0. The reaction is given about ``anchor`` [m], the origin if left
        out."""
        _refuse_axes(
            "fixed", options, "holds both sides as they are; give rotation= to the bodies when they are added"
        )
        return self.add_joint("fixed", a, b, **_anchored(a, b, anchor), **options)

    def add_ball(self, a: Side, b: Side, anchor: Vec3Like | None = None, **options: Any) -> Joint:
        """Ball joint at ``anchor`` [m]."""
        _refuse_axes("ball", options, "turns about any axis; add_hinge and add_universal have axes")
        return self.add_joint("ball", a, b, anchor=anchor, **options)

    def add_hinge(
        self,
        a: Side,
        b: Side,
        anchor: Vec3Like | None = None,
        axis: str | Vec3Like | None = None,
        *,
        limits: tuple[float, float] | None = None,
        **options: Any,
    ) -> Joint:
        """Hinge (revolute joint) at ``anchor`` [m] about ``axis``; coordinate ``angle`` [rad],
        kept within ``limits``. Without an ``axis`` it is z."""
        with self._all_or_nothing():
            joint = self.add_joint("hinge", a, b, anchor=anchor, axis=axis, **options)
            if limits is not None:
                joint.add_limit(*_bounds("hinge", limits))
        return joint

    def add_slider(
        self,
        a: Side,
        b: Side,
        anchor: Vec3Like | None = None,
        axis: str | Vec3Like | None = None,
        *,
        limits: tuple[float, float] | None = None,
        **options: Any,
    ) -> Joint:
        """Slider (prismatic joint) along ``axis`` of a; coordinate ``displacement`` [m],
        kept within ``limits``. Without an ``axis`` it is z."""
        with self._all_or_nothing():
            joint = self.add_joint("slider", a, b, anchor=anchor, axis=axis, **options)
            if limits is not None:
                joint.add_limit(*_bounds("slider", limits))
        return joint

    def add_cylindrical(
        self,
        a: Side,
        b: Side,
        anchor: Vec3Like | None = None,
        axis: str | Vec3Like | None = None,
        **options: Any,
    ) -> Joint:
        """Cylindrical joint along and about ``axis``; coordinates ``displacement`` [m] and ``angle``
        [rad]."""
        return self.add_joint("cylindrical", a, b, anchor=anchor, axis=axis, **options)

    def add_planar(
        self,
        a: Side,
        b: Side,
        anchor: Vec3Like | None = None,
        normal: str | Vec3Like | None = None,
        **options: Any,
    ) -> Joint:
        """Planar joint in the plane through ``anchor`` [m] with this ``normal``; coordinates
        ``displacement_x`` along the x axis of the world at time 0, laid into the plane (y if the normal is
        along x), ``displacement_y`` across it, counterclockwise about the normal [m], ``angle`` [rad].
        ``rotation`` in place of ``normal`` gives all three axes, the normal last."""
        if options.pop("axis", None) is not None:
            raise InvalidArgument(
                "joint 'planar': axis is not known here: give the normal of the plane instead"
            )
        if normal is None or options.get("rotation") is not None:
            return self.add_joint("planar", a, b, anchor=anchor, axis=normal, **options)
        options["rotation"] = _plane_axes(normal)
        return self.add_joint("planar", a, b, anchor=anchor, **options)

    def add_point_on_axis(
        self,
        a: Side,
        b: Side,
        anchor: Vec3Like | None = None,
        axis: str | Vec3Like | None = None,
        **options: Any,
    ) -> Joint:
        """The point of b at ``anchor`` [m] stays on the axis of a; coordinate ``displacement`` [m]."""
        return self.add_joint("point_on_axis", a, b, anchor=anchor, axis=axis, **options)

    def add_universal(
        self,
        a: Side,
        b: Side,
        anchor: Vec3Like | None = None,
        axis_a: str | Vec3Like | None = None,
        axis_b: str | Vec3Like | None = None,
        **options: Any,
    ) -> Joint:
        """Universal (Cardan) joint: a turns about ``axis_a``, b about ``axis_b``, which are perpendicular,
        or those of ``rotation`` at time 0, x and y; coordinates ``angle_a`` and ``angle_b`` [rad]."""
        if axis_a is not None or axis_b is not None:
            if options.get("rotation") is not None:
                raise InvalidArgument("joint 'universal': axes and rotation are both given: give one of them")
            options["rotation"] = _cross_axes(axis_a, axis_b)
        return self.add_joint("universal", a, b, anchor=anchor, **options)

    def add_distance(
        self,
        a: Side,
        b: Side,
        anchor_a: Vec3Like,
        anchor_b: Vec3Like,
        length: float | None = None,
        **options: Any,
    ) -> Joint:
        """Keeps the points at ``anchor_a`` of a and ``anchor_b`` of b [m, in the world at time 0] at a
        distance, as a
        rod without mass does; ``length`` [m] is that at time 0 if left out."""
        frames = _points(self, "distance", a, b, anchor_a, anchor_b)
        length = _length("distance", anchor_a, anchor_b) if length is None else length
        return self.add_joint("distance", *frames, length=length, **options)

    def add_span(
        self,
        a: Side,
        b: Side,
        anchor_a: Vec3Like,
        anchor_b: Vec3Like,
        *,
        contact: bool = True,
        **options: Any,
    ) -> Joint:
        """Holds nothing and measures the ``distance`` [m] of two points (arguments as in ``add_distance``):
        what springs, ropes (``add_limit(upper=...)``) and linear drives act along."""
        return self.add_joint(
            "span", *_points(self, "span", a, b, anchor_a, anchor_b), contact=contact, **options
        )

    def add_spring(
        self,
        a: Side,
        b: Side,
        anchor_a: Vec3Like,
        anchor_b: Vec3Like,
        *,
        stiffness: float,
        damping: float = 0.0,
        rest_length: float | None = None,
        name: str | None = None,
        contact: bool = True,
    ) -> Actuator:
        """Spring and damper between two points (arguments as in ``add_distance``): ``stiffness`` [N/m],
        ``damping`` [N s/m], ``rest_length`` [m], that at time 0 if left out. Its ``joint`` is a span."""
        length = _length("spring", anchor_a, anchor_b) if rest_length is None else rest_length
        if real_number(length, "spring: rest_length") < 0.0:
            raise InvalidArgument(
                f"spring: rest_length = {length:g} m: must be >= 0; 0 pulls both points together"
            )
        with self._all_or_nothing():
            span = self.add_span(a, b, anchor_a, anchor_b, contact=contact)
            return span.add_spring(stiffness, damping=damping, rest=length, name=name)

    def add_tilt(
        self,
        a: Side,
        b: Side,
        anchor: Vec3Like | None = None,
        axis: str | Vec3Like | None = None,
        *,
        limit: float | None = None,
        contact: bool = True,
        **options: Any,
    ) -> Joint:
        """Holds nothing and measures the ``angle`` [rad] between ``axis`` of a and of b; ``limit`` keeps it
        in a cone, next to a ball joint for instance."""
        with self._all_or_nothing():
            joint = self.add_joint("tilt", a, b, anchor=anchor, axis=axis, contact=contact, **options)
            if limit is not None:
                if isinstance(limit, (int, float)) and limit < 0.0:
                    raise InvalidArgument(f"add_tilt: limit = {limit} rad: must be >= 0, as a tilt is")
                joint.add_limit(upper=limit)
        return joint

    @contextlib.contextmanager
    def _all_or_nothing(self) -> Iterator[None]:
        """What is added in several calls is not there at all if one of them is refused."""
        before, counts = self._core.snapshot(), (len(self._joints), len(self._actuators))
        try:
            yield
        except BaseException:
            self._core.restore(before)
            del self._joints[counts[0] :], self._actuators[counts[1] :]
            raise

    @property
    def joints(self) -> NamedTuple[Joint]:
        """Joints in the order of adding."""
        return NamedTuple("joint", self._joints, self)


def _refuse_axes(kind: str, options: dict[str, Any], why: str) -> None:
    """Of joints to which directions make no difference."""
    for name in ("axis", "rotation"):
        if options.get(name) is not None:
            raise InvalidArgument(
                f"joint '{options.get('name') or kind}': {name} = {shown_value(options[name])}: must be left "
                f"out, as a {kind} joint {why}"
            )


def _points(
    scene: Any, kind: str, a: Side, b: Side, anchor_a: Vec3Like, anchor_b: Vec3Like
) -> list[FrameHandle]:
    """Frames of two sides at points of the world."""
    from stark.joints.adding import place_side

    return [
        place_side(scene, kind, label, side, vector(point, f"{kind}: anchor_{label}"))
        for label, side, point in (("a", a, anchor_a), ("b", b, anchor_b))
    ]


def _length(kind: str, anchor_a: Vec3Like, anchor_b: Vec3Like) -> float:
    """Distance of the anchors [m]."""
    return float(
        np.linalg.norm(vector(anchor_b, f"{kind}: anchor_b") - vector(anchor_a, f"{kind}: anchor_a"))
    )


def _bounds(kind: str, limits: tuple[float, float]) -> tuple[float, float]:
    refuse_masked(limits, f"{kind}: limits")
    try:
        pair = np.asarray(limits)
    except ValueError:
        pair = np.empty(0)
    if pair.shape != (2,) or pair.dtype.kind not in "iuf" or not pair[0] < pair[1]:
        raise InvalidArgument(
            f"{kind}: limits = {limits!r}: must be two numbers (lower, upper), lower < upper"
        )
    return float(pair[0]), float(pair[1])


def _anchored(a: Side, b: Side, anchor: Vec3Like | None) -> dict[str, Any]:
    """Bodies get frames at the anchor; frames have places of their own."""
    if anchor is None and (isinstance(a, FrameHandle) or isinstance(b, FrameHandle)):
        return {}
    return {"anchor": (0.0, 0.0, 0.0) if anchor is None else anchor}


def _plane_axes(normal: str | Vec3Like) -> Any:
    """x of the world laid into the plane, or y where the normal is within 1e-6 of x; across; the normal."""
    z = direction(normal, "planar: normal")
    z = z / np.linalg.norm(z)
    along = np.eye(3)[0 if abs(z[0]) < 1.0 - 5e-13 else 1]
    x = along - (along @ z) * z
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def _cross_axes(axis_a: str | Vec3Like | None, axis_b: str | Vec3Like | None) -> Any:
    if axis_a is None or axis_b is None:
        raise InvalidArgument("universal: only one of axis_a and axis_b is given: give both")
    x, y = direction(axis_a, "universal: axis_a"), direction(axis_b, "universal: axis_b")
    if abs(x @ y) > 1e-9 * np.linalg.norm(x) * np.linalg.norm(y):
        raise InvalidArgument(
            f"universal: axis_a = {x.tolist()} and axis_b = {y.tolist()}: must be perpendicular"
        )
    x, y = x / np.linalg.norm(x), y / np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])

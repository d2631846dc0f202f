"""Frames inside a formula: origin and axes of a rigid body, of the world, or of a patch of cloth or solid. A
frame of a body is four points (origin and axes) that move with it; a patch frame is computed from the three
vertices of a triangle."""

from __future__ import annotations

from collections.abc import Iterable

from stark.formulas.kinematics import Inputs
from stark.formulas.parameters import UNBOUNDED
from stark.symbolic.linear_algebra import cross, dot, normalized
from stark.symbolic.tensor import Mat, Scalar, Vec, columns

_AXES = ("x", "y", "z")
_TERMS = 10  # of the series of angle / sin(angle)


class Frame:
    """A frame that moves: right-handed orthonormal axes ``x``, ``y``, ``z`` and an ``origin``."""

    def __init__(self, inputs: Inputs, first: int, label: str) -> None:
        self._inputs, self._first, self._label = inputs, first, label

    @property
    def origin(self) -> Vec:
        """Position at the end of the time step [m]."""
        return self._origin("x")

    @property
    def x(self) -> Vec:
        """First axis at the end of the time step."""
        return self._axis(0, "x")

    @property
    def y(self) -> Vec:
        """Second axis at the end of the time step."""
        return self._axis(1, "x")

    @property
    def z(self) -> Vec:
        """Third axis at the end of the time step."""
        return self._axis(2, "x")

    @property
    def axes(self) -> Mat:
        """Rotation to the world: the axes as columns."""
        return columns(self.x, self.y, self.z)

    @property
    def origin_prev(self) -> Vec:
        """Position at the start of the time step [m]."""
        return self._origin("x_prev")

    @property
    def axes_prev(self) -> Mat:
        """Axes at the start of the time step, as columns."""
        return columns(*(self._axis(i, "x_prev") for i in range(3)))

    @property
    def origin0(self) -> Vec:
        """Position at time 0 [m]."""
        return self._origin("x_initial")

    @property
    def axes0(self) -> Mat:
        """Axes at time 0, as columns."""
        return columns(*(self._axis(i, "x_initial") for i in range(3)))

    @property
    def velocity(self) -> Vec:
        """Velocity of the origin in the time step [m/s]."""
        return (self.origin - self.origin_prev) / self._inputs.time_step

    @property
    def angular_velocity(self) -> Vec:
        """sin(angle of rotation in the time step) / h about its axis [rad/s]: the angular velocity up to
        second order in the step. ``turn / h`` is closer."""
        return self._twice_sine() / (2.0 * self._inputs.time_step)

    @property
    def turn(self) -> Vec:
        """Rotation vector of the time step [rad]: angle times axis, exact to 10⁻⁹ up to 0.6 rad and to 10⁻⁶
        up to 1 rad, smooth and too short beyond."""
        now, before = self.axes, self.axes_prev
        cosine = 0.5 * (sum(dot(before.column(i), now.column(i)) for i in range(3)) - 1.0)
        square = 0.5 * (1.0 - cosine)  # sin(angle / 2)^2
        # angle / sin(angle) = 1 + 2/3 square (1 + 4/5 square (1 + 6/7 square (...)))
        ratio: Scalar | float = 1.0
        for n in range(_TERMS, 0, -1):
            ratio = 1.0 + (2 * n) / (2 * n + 1) * square * ratio
        return 0.5 * ratio * self._twice_sine()

    def _twice_sine(self) -> Vec:
        """2 sin(angle of rotation in the time step) about its axis."""
        now, before = self.axes, self.axes_prev
        total: Vec = cross(before.column(0), now.column(0))
        for i in (1, 2):
            total = total + cross(before.column(i), now.column(i))
        return total

    def point(self, local: Iterable[object]) -> Vec:
        """Position of the point with these coordinates in the frame [m]."""
        return self.origin + self.axes @ Vec(list(local))

    def _origin(self, kind: str) -> Vec:
        raise NotImplementedError

    def _axis(self, i: int, kind: str) -> Vec:
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<stark.Frame {self._label}>"


class SiteFrame(Frame):
    """Frame whose origin and axes are points of their own."""

    point_count = 4

    def _origin(self, kind: str) -> Vec:
        return self._inputs.position(self._first, kind, f"{self._label}.origin")

    def _axis(self, i: int, kind: str) -> Vec:
        return self._inputs.position(self._first + 1 + i, kind, f"{self._label}.{_AXES[i]}")


class PatchFrame(Frame):
    """Frame of a triangle of three vertices. With the axes T = (t, n x t, n) of the triangle, t along its
    first edge and n its normal, the origin is sum_i w_i x_i + d n and the axes are T R."""

    point_count = 3

    def _constant(self, name: str, width: int, unit: str, doc: str) -> list[Scalar]:
        label = f"{self._label}.{name}"
        entries = self._inputs.builder.parameter(label, width, unit, doc, UNBOUNDED)
        self._inputs.note(entries, label)
        return entries

    def _vertices(self, kind: str) -> list[Vec]:
        return [self._inputs.position(self._first + i, kind, f"{self._label}[{i}]") for i in range(3)]

    def _triangle_axes(self, kind: str) -> tuple[Vec, Vec, Vec]:
        a, b, c = self._vertices(kind)
        tangent = normalized(b - a)
        normal = normalized(cross(b - a, c - a))
        return tangent, cross(normal, tangent), normal

    def _origin(self, kind: str) -> Vec:
        weights = self._constant("weights", 3, "1", "barycentric coordinates of the origin")
        offset = self._constant("offset", 1, "m", "height of the origin above the triangle")[0]
        a, b, c = self._vertices(kind)
        # The first vertex plus edges: a translation of the patch is exact.
        return a + weights[1] * (b - a) + weights[2] * (c - a) + offset * self._triangle_axes(kind)[2]

    def _axis(self, i: int, kind: str) -> Vec:
        rotation = self._constant("rotation", 9, "1", "axes of the frame in those of the triangle")
        t, s, n = self._triangle_axes(kind)
        return rotation[i] * t + rotation[3 + i] * s + rotation[6 + i] * n


KINDS: dict[str, type[SiteFrame] | type[PatchFrame]] = {"sites": SiteFrame, "patch": PatchFrame}

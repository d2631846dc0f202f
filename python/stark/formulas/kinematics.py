"""What the arguments of an energy are inside its formula: points and stencils with their kinematics. The
order of operations is that of src/stark/models, so that a formula written here gives the same bits there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import ClassVar

from stark._core import FormulaBuilder, TraceError
from stark.formulas.parameters import UNBOUNDED
from stark.symbolic.errors import TraceIndexError
from stark.symbolic.functions import atan2, sqrt
from stark.symbolic.linear_algebra import cross, determinant, dot, inverse, norm, normalized
from stark.symbolic.tensor import Mat, Scalar, Vec, columns


class Inputs:
    """Inputs of a formula that is being recorded, made and named when they are first asked for."""

    def __init__(self, kept: Sequence[int]) -> None:
        """`kept`: points of the arguments that the formula has, in order."""
        self.builder: FormulaBuilder = FormulaBuilder(len(kept))
        self.point_of: dict[int, int] = {}  # node -> point it is a coordinate of
        self.unknowns: dict[int, int] = {}  # node of an unknown -> its coordinate 0, 1, 2
        self.clocks: dict[str, int] = {}  # argument -> node
        self._labels: dict[str, list[int]] = {}  # argument -> nodes of its columns
        self.sources: dict[int, tuple[str, int, int]] = {}  # input -> quantity, point, component
        self.local_axes: set[str] = set()  # triangles whose strain was taken along their own first edge
        self._place = {point: place for place, point in enumerate(kept)}

    def position(self, point: int, kind: str, label: str) -> Vec:
        """kind: "x", "X", "x_prev" or "x_initial"."""
        if point not in self._place:  # computed, but known not to occur in the result
            return Vec(self.builder.parameter(f"unused {label}.{kind}", 3, "1", "occurs nowhere", UNBOUNDED))
        value = Vec(getattr(self.builder, kind)(self._place[point]))
        self.note(value.entries, kind, self._place[point])
        shown = {"x_initial": "x0"}.get(kind, kind)
        for c, entry in enumerate(value.entries):
            self.builder.set_name(entry, f"{label}.{shown}[{c}]")
            self.point_of[entry.id] = point
            if kind == "x":
                self.unknowns[entry.id] = c
        return value

    def note(self, entries: Sequence[Scalar], source: str, point: int = 0) -> None:
        """Remembers what inputs stand for: the name of a parameter, "time", "x", "X", ..."""
        self.sources |= {entry.id: (source, point, k) for k, entry in enumerate(entries)}

    def column(self, j: int, kind: str, label: str) -> Vec:
        """Column of a strain F as the point j, named F[i,j]."""
        value = Vec(getattr(self.builder, kind)(j))
        for i, entry in enumerate(value.entries):
            self.strain(entry, (kind, j, i), label, f"{label}[{i},{j}]")
        return value

    def strain(self, entry: Scalar, source: tuple[str, int, int], label: str, name: str) -> None:
        """Names a coordinate of a point that is part of a strain, the argument ``label``. ``source``: "x" or
        "x_prev", the point, the coordinate."""
        self.builder.set_name(entry, name)
        self._labels.setdefault(label, []).append(entry.id)
        self.sources[entry.id] = source
        if source[0] == "x":
            self.unknowns[entry.id] = source[2]

    @property
    def time_step(self) -> Scalar:
        """Length of the time step [s]."""
        value = self.builder.time_step()
        self.note([value], "time_step")
        return value

    def nodes_of(self, argument: str) -> list[int]:
        """Inputs that belong to a clock or a strain."""
        return self._labels.get(argument, []) + [self.clocks[a] for a in (argument,) if a in self.clocks]


class Point:
    """A point that an energy acts on: a vertex, a point of a rigid body, of an element or of the world."""

    point_count: ClassVar[int] = 1

    def __init__(self, inputs: Inputs, first: int, label: str) -> None:
        self._inputs, self._index, self._label = inputs, first, label

    @property
    def x(self) -> Vec:
        """Position at the end of the time step [m]; what is solved for."""
        return self._inputs.position(self._index, "x", self._label)

    @property
    def x_prev(self) -> Vec:
        """Position at the start of the time step [m]."""
        return self._inputs.position(self._index, "x_prev", self._label)

    @property
    def X(self) -> Vec:
        """Rest position, in the frame of its body's mesh [m]."""
        return self._inputs.position(self._index, "X", self._label)

    @property
    def x0(self) -> Vec:
        """Position in the world at time 0 [m]."""
        return self._inputs.position(self._index, "x_initial", self._label)

    @property
    def v(self) -> Vec:
        """Velocity of the time step, (x - x_prev) / h [m/s]."""
        return (self.x - self.x_prev) / self._inputs.time_step

    def __repr__(self) -> str:
        return f"<stark.{type(self).__name__} {self._label}>"


class Stencil:
    """``Stencil[k]``: k points, s[0] ... s[k-1]."""

    point_count: ClassVar[int] = 0

    def __init__(self, inputs: Inputs, first: int, label: str) -> None:
        self._label = label
        self._rest = "X"
        self.points: tuple[Point, ...] = tuple(
            Point(inputs, first + i, f"{label}[{i}]") for i in range(self.point_count)
        )

    def __class_getitem__(cls, count: int) -> type[Stencil]:
        if cls is not Stencil or not isinstance(count, int) or count < 1:
            raise TraceError(f"{cls.__name__}[{count!r}]: must be Stencil[k] with a number of points k >= 1")
        return type(f"Stencil[{count}]", (Stencil,), {"point_count": count, "__module__": __name__})

    def __getitem__(self, index: int) -> Point:
        try:
            return self.points[index]
        except IndexError:
            raise TraceIndexError(
                f"index {index} of {self!r}: it has {self.point_count} points, 0 to {self.point_count - 1}"
            ) from None

    def __iter__(self) -> Iterator[Point]:
        return iter(self.points)

    def __len__(self) -> int:
        return self.point_count

    def rest_as_at_start(self) -> None:
        """Takes for the rest shape the one at time 0: rest positions of several bodies are in the frames of
        their meshes, which have nothing to do with each other."""
        self._rest = "x0"

    def _positions(self, kind: str) -> list[Vec]:
        return [getattr(point, kind) for point in self.points]

    def _rest_positions(self) -> list[Vec]:
        return self._positions(self._rest)

    def __repr__(self) -> str:
        return f"<stark.{type(self).__name__} {self._label}>"


class Edge(Stencil):
    """Two points and the segment between them."""

    point_count = 2

    @property
    def length(self) -> Scalar:
        """Distance of the two ends [m]."""
        return _length(*self._positions("x"))

    @property
    def rest_length(self) -> Scalar:
        """Length at rest [m]; at time 0 if the ends belong to different bodies."""
        return _length(*self._rest_positions())

    @property
    def length_prev(self) -> Scalar:
        """At the start of the time step [m]."""
        return _length(*self._positions("x_prev"))

    @property
    def vector(self) -> Vec:
        """From the first point to the second [m]."""
        a, b = self._positions("x")
        return b - a

    @property
    def direction(self) -> Vec:
        """Unit vector from the first point to the second."""
        return normalized(self.vector)


class Triangle(Stencil):
    """Three points and the triangle between them."""

    point_count = 3

    @property
    def edges(self) -> Mat:
        """Edges from the first point as columns, 3x2 [m]."""
        return _edges(self._positions("x"))

    @property
    def F(self) -> Mat:
        """Deformation gradient 3x2. The first material axis is along the first edge of each rest triangle, so
        it is for measures that are the same in all directions; for others see ``F_along``."""
        return self._gradient("x")

    @property
    def F_prev(self) -> Mat:
        """Deformation gradient at the start of the time step."""
        return self._gradient("x_prev")

    def F_along(self, direction: Vec) -> Mat:
        """Deformation gradient 3x2 whose first material axis is along a direction, as far as it lies in the
        triangle: a Vec3 in the frame of the rest mesh, which must not be normal to the triangle."""
        return self._gradient("x", direction)

    def F_prev_along(self, direction: Vec) -> Mat:
        """The same at the start of the time step."""
        return self._gradient("x_prev", direction)

    @property
    def metric(self) -> Mat:
        """Products of the edges e1 = x1 - x0, e2 = x2 - x0: [[e1.e1, e1.e2], [e1.e2, e2.e2]] [m^2]."""
        return _metric(self._positions("x"))

    @property
    def metric_prev(self) -> Mat:
        """The same at the start of the time step [m^2]."""
        return _metric(self._positions("x_prev"))

    @property
    def rest_metric(self) -> Mat:
        """The same of the rest triangle [m^2]."""
        return _metric(self._rest_positions())

    @property
    def area(self) -> Scalar:
        """Area [m^2]."""
        return 0.5 * norm(self._normal("x"))

    @property
    def rest_area(self) -> Scalar:
        """Area at rest [m^2]."""
        return 0.5 * sqrt(determinant(self.rest_metric))

    @property
    def normal(self) -> Vec:
        """Unit normal, counter-clockwise seen from its tip."""
        return normalized(self._normal("x"))

    @property
    def area_vector(self) -> Vec:
        """Normal with the area as its length [m^2]."""
        return 0.5 * self._normal("x")

    @property
    def center(self) -> Vec:
        """Mean of the vertices, a Vec3 [m]."""
        return _mean(self._positions("x"))

    def _normal(self, kind: str) -> Vec:
        a, b, c = self._positions(kind)
        normal: Vec = cross(b - a, c - a)
        return normal

    def _gradient(self, kind: str, direction: Vec | None = None) -> Mat:
        rest = _edges(self._rest_positions())
        first, second = rest.column(0), rest.column(1)
        normal = normalized(cross(first, second))
        if direction is None:
            self.points[0]._inputs.local_axes.add(self._label)
            direction = first
        warp = normalized(direction - dot(direction, normal) * normal)
        weft = cross(normal, warp)
        frame = Mat([[dot(warp, first), dot(warp, second)], [dot(weft, first), dot(weft, second)]])
        return _edges(self._positions(kind)) @ inverse(frame)


class Tetrahedron(Stencil):
    """Four points and the tetrahedron between them."""

    point_count = 4

    @property
    def edges(self) -> Mat:
        """Edges from the first point as columns, 3x3 [m]."""
        return _edges(self._positions("x"))

    @property
    def rest_edges(self) -> Mat:
        """The same of the rest tetrahedron [m]."""
        return _edges(self._rest_positions())

    @property
    def F(self) -> Mat:
        """Deformation gradient 3x3."""
        return self.edges @ inverse(self.rest_edges)

    @property
    def F_prev(self) -> Mat:
        """Deformation gradient at the start of the time step."""
        return _edges(self._positions("x_prev")) @ inverse(self.rest_edges)

    @property
    def volume(self) -> Scalar:
        """Volume [m^3], negative if inverted."""
        return determinant(self.edges) / 6.0

    @property
    def rest_volume(self) -> Scalar:
        """Volume at rest [m^3]."""
        return determinant(self.rest_edges) / 6.0

    @property
    def center(self) -> Vec:
        """Mean of the vertices, a Vec3 [m]."""
        return _mean(self._positions("x"))


class Hinge(Stencil):
    """Two triangles at a shared edge: points 0 and 1 of the edge, 2 and 3 opposite to it."""

    point_count = 4

    @property
    def angle(self) -> Scalar:
        """Signed angle between the normals [rad], zero when flat."""
        return _fold_angle(*self._positions("x"))

    @property
    def rest_angle(self) -> Scalar:
        """Signed angle between the normals at rest [rad], zero when flat."""
        return _fold_angle(*self._rest_positions())

    @property
    def angle_prev(self) -> Scalar:
        """At the start of the time step [rad]."""
        return _fold_angle(*self._positions("x_prev"))

    @property
    def edge(self) -> Vec:
        """Shared edge, from point 0 to point 1 [m]."""
        a, b, *_ = self._positions("x")
        return b - a

    @property
    def rest_edge(self) -> Vec:
        """Vector along the shared edge at rest, a Vec3 [m]."""
        a, b, *_ = self._rest_positions()
        return b - a

    @property
    def rest_weight(self) -> Scalar:
        """3 / (sum of the two rest areas) [1/m^2]; times the squared rest edge, the weight of discrete
        shells."""
        _, normal_a, normal_b = _hinge(*self._rest_positions())
        return 6.0 / (norm(normal_a) + norm(normal_b))


def _length(a: Vec, b: Vec) -> Scalar:
    return norm(b - a)


def _edges(points: Sequence[Vec]) -> Mat:
    return columns([p - points[0] for p in points[1:]])


def _mean(points: Sequence[Vec]) -> Vec:
    total = points[0]
    for p in points[1:]:
        total = total + p
    return total / float(len(points))


def _metric(points: Sequence[Vec]) -> Mat:
    e1, e2 = points[1] - points[0], points[2] - points[0]
    mixed = dot(e1, e2)
    return Mat([[dot(e1, e1), mixed], [mixed, dot(e2, e2)]])


def _hinge(p0: Vec, p1: Vec, p2: Vec, p3: Vec) -> tuple[Vec, Vec, Vec]:
    edge = p1 - p0
    return edge, cross(edge, p2 - p0), cross(p3 - p0, edge)


def _fold_angle(p0: Vec, p1: Vec, p2: Vec, p3: Vec) -> Scalar:
    edge, normal_a, normal_b = _hinge(p0, p1, p2, p3)
    sine = dot(cross(normal_a, normal_b), edge) / norm(edge)
    return atan2(sine, dot(normal_a, normal_b))

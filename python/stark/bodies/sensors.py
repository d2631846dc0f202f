"""What a simulation measures: contacts with their forces, pressures on surfaces, inertial measurement units.

Everything here is of the last step, and empty before the first one and after ``simulation.state`` was set."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark import _core
from stark._core import InvalidArgument
from stark.arguments import shown_value
from stark.bodies.contact_pressures import areas_of, pressure_on, touched
from stark.handle import BodyHandle, SceneLink, SimulationLink, names_of
from stark.readings import reading
from stark.rotations import as_matrix, vector

Array = NDArray[np.float64]
Ints = NDArray[np.int32]
_MOST = 2**31 - 1  # vertices


@dataclass(frozen=True, eq=False)
class Contacts:
    """Pairs of points in contact, one row each. Forces act on the first body of the pair; the second one gets
    the opposite. Bodies touch within the sum of their contact distances."""

    names: tuple[str, ...]  #: of all bodies of the scene
    bodies: Ints  #: (n, 2) indices of the bodies
    vertices: Ints  #: (n, 4) vertices that carry the pair, first body first; -1: unused
    weights: Array  #: (n, 4) shares of the vertices in the closest points, negative on the second body
    first_counts: Ints  #: (n,) how many of the vertices belong to the first body
    distances: Array  #: (n,) [m]
    points_a: Array  #: (n, 3) closest points on the first body [m]
    points_b: Array  #: (n, 3) closest points on the second body [m]
    normal_forces: Array  #: (n, 3) [N]
    frictions: Array  #: (n, 3) [N]
    slips: Array  #: (n, 3) tangential velocity of the first material against the second [m/s]
    friction_points: Array  #: (n, 3) where friction acts on the first body, inside flat faces [m]
    friction_points_b: Array  #: (n, 3) on the second: others for edges of rods and soft bodies [m]
    scene: SceneLink | None = None  #: whose bodies these are

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "scene": None}  # pickles of contacts hold the numbers alone

    def __len__(self) -> int:
        return len(self.distances)

    def __repr__(self) -> str:
        """How many there are between which bodies; the arrays are attributes."""
        pairs, counts = np.unique(np.sort(self.bodies, axis=1), axis=0, return_counts=True)
        order = np.argsort(-counts, kind="stable")
        listed = [
            f"{counts[k]} of {self.names[pairs[k][0]]} with {self.names[pairs[k][1]]}" for k in order[:4]
        ]
        more = f", {len(order) - 4} pairs of bodies more" if len(order) > 4 else ""
        return f"<stark.Contacts: {', '.join(listed) or 'none'}{more}>"

    @property
    def forces(self) -> Array:
        """Normal force and friction together (n, 3) [N]."""
        return self.normal_forces + self.frictions

    @property
    def normals(self) -> Array:
        """Unit vectors from the second to the first body (n, 3)."""
        return (self.points_a - self.points_b) / self.distances[:, None]

    def of(self, body: BodyHandle | str, other: BodyHandle | str | None = None) -> Contacts:
        """The contacts of a body, or of two with each other, turned so that ``body`` is the first of each
        pair. Self-contact counts from both sides."""
        a = self._index(body)
        straight, turned = self.bodies[:, 0] == a, self.bodies[:, 1] == a
        if other is not None:
            b = self._index(other)
            straight, turned = straight & (self.bodies[:, 1] == b), turned & (self.bodies[:, 0] == b)
        if not turned.any():
            return self._take(straight)
        if not straight.any():
            return self._take(turned)._turned()
        kept, flipped = self._take(straight), self._take(turned)._turned()
        rows = {c: np.concatenate([getattr(kept, c), getattr(flipped, c)]) for c in _COLUMNS}
        return Contacts(names=self.names, scene=self.scene, **rows)

    def _both_sides(self) -> Contacts:
        """Each pair twice, with either body as the first, sorted by these: what ``of()`` has of each body is
        one piece."""
        turned = self._turned()
        order = np.argsort(np.concatenate([self.bodies[:, 0], turned.bodies[:, 0]]), kind="stable")
        rows = {c: np.concatenate([getattr(self, c), getattr(turned, c)])[order] for c in _COLUMNS}
        return Contacts(names=self.names, scene=self.scene, **rows)

    def torque_about(self, point: ArrayLike) -> Array:
        """Sum of the torques on the first bodies about a point of the world [m], friction included (3,) [N
        m]."""
        center = vector(point, "contacts: torque_about: point")
        torques = np.cross(self.points_a - center, self.normal_forces) + np.cross(
            self.friction_points - center, self.frictions
        )
        found: Array = torques.sum(axis=0)
        return found

    def vertex_forces(self, count: int) -> Array:
        """Forces on the ``count`` vertices of the first body (count, 3) [N]; use after ``of()``."""
        own = np.arange(self.vertices.shape[1]) < self.first_counts[:, None]
        least = int(self.vertices[own].max(initial=-1)) + 1
        if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or not least <= count <= _MOST:
            raise InvalidArgument(
                f"contacts: vertex_forces: count = {shown_value(count)}: must be the number of vertices of "
                f"the first body, at least {least} here"
            )
        return self._spread(self.forces, count)

    def _spread(self, forces: Array, count: int) -> Array:
        result = np.zeros((count, 3))
        for k in range(4):
            mine = self.first_counts > k
            np.add.at(result, self.vertices[mine, k], self.weights[mine, k, None] * forces[mine])
        return result

    def _index(self, body: BodyHandle | str) -> int:
        name = getattr(body, "name", body)
        if isinstance(body, BodyHandle) and self.scene is not None and body._scene is not self.scene:
            raise InvalidArgument(
                f"contacts: '{name}' belongs to another scene: must be a body of this one; take it from there"
            )
        if not isinstance(name, str) or name not in self.names:
            raise InvalidArgument(f"contacts: no body is named {name!r}; there are {', '.join(self.names)}")
        return self.names.index(name)

    def _take(self, rows: NDArray[np.bool_] | slice) -> Contacts:
        return replace(self, **{c: getattr(self, c)[rows] for c in _COLUMNS})

    def _turned(self) -> Contacts:
        used = (self.vertices >= 0).sum(axis=1)
        # Columns in the order: points of the second side, points of the first, unused ones.
        place = (np.arange(4)[None, :] + self.first_counts[:, None]) % np.maximum(used, 1)[:, None]
        order = np.where(np.arange(4)[None, :] < used[:, None], place, np.arange(4)[None, :])
        return replace(
            self,
            bodies=self.bodies[:, ::-1],
            vertices=np.take_along_axis(self.vertices, order, axis=1),
            weights=-np.take_along_axis(self.weights, order, axis=1),
            first_counts=(used - self.first_counts).astype(np.int32),
            distances=self.distances,
            points_a=self.points_b,
            points_b=self.points_a,
            normal_forces=-self.normal_forces,
            frictions=-self.frictions,
            slips=-self.slips,
            friction_points=self.friction_points_b,
            friction_points_b=self.friction_points,
        )


_COLUMNS = [field.name for field in fields(Contacts) if field.name not in ("names", "scene")]


def contacts_of(simulation: SimulationLink) -> Contacts:
    """All contacts of the last step of a simulation."""
    return Contacts(names=names_of(simulation), scene=simulation._scene, **_core.contacts(simulation._core))


class ClosestPoints(NamedTuple):
    """Where two bodies are nearest to each other."""

    distance: float  #: [m]
    point_a: Array  #: on the first body (3,) [m]
    point_b: Array  #: on the second body (3,) [m]


class FreePath(NamedTuple):
    """How far a body can go before it meets another one."""

    fraction: float  #: of the displacement, in [0, 1]; 1 where nothing is in the way
    blocking: str | None  #: name of the body that it meets, or None


def free_path_of(simulation: SimulationLink, body: int, displacement: Array) -> FreePath:
    """Of a body by its index, by continuous collision detection of all surfaces as they are now."""
    surface = simulation._core.surface()
    groups, start = surface["vertex_groups"], surface["positions"]
    world = _core.CollisionScene(groups, surface["edges"], surface["triangles"])
    none = np.zeros(int(groups.max()) + 1)
    moved = (groups == body)[:, None]
    end = np.where(moved, start + displacement, start)
    reached = 0.0
    while True:  # one pass leaves a tenth of the gap
        fraction, kind, *parts = world.max_safe_step(
            np.where(moved, start + reached * displacement, start), end, none
        )
        if not kind:
            return FreePath(1.0, None)
        gain = fraction * (1.0 - reached)
        reached += gain
        if gain < _FREE_PATH_GAIN:
            break
    first_vertex = {
        "point": np.arange(len(groups)),
        "edge": surface["edges"],
        "triangle": surface["triangles"],
    }
    bodies = [
        int(groups[np.ravel(first_vertex[what][part])[0]])
        for what, part in zip(kind.split("_"), parts, strict=True)
    ]
    return FreePath(reached, names_of(simulation)[bodies[0] if bodies[1] == body else bodies[1]])


class Imu(NamedTuple):
    """Reading of an inertial measurement unit, in the axes of the sensor."""

    specific_force: Array  #: acceleration minus gravity (3,) [m/s^2]; at rest it points up with 9.81
    angular_velocity: Array  #: (3,) [rad/s]


_OWN_FORCE = "a force of your own is scene.add_force(body, ...), before the simulation"
_OWN_TORQUE = "a torque of your own is scene.add_torque(body, ...), before the simulation"
_FREE_PATH_GAIN = 1e-6  # of the displacement; a pass that gains less ends the search
_FLAT = 1e-8  # distance from the plane of a face over the size of the body
_ALONG = 0.999  # cosine between the normals of a face and of a contact with it


def _surrounded(points: Array, by: Array, normal: Array) -> NDArray[np.bool_]:
    """Which of the points of a plane lie in the convex hull of others: seen from there, the directions of
    those leave no half circle empty."""
    if len(by) < 3:
        return np.zeros(len(points), dtype=bool)
    first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    axes = np.stack([first, np.cross(normal, first)]) / np.linalg.norm(first)
    seen = (by[None, :, :] - points[:, None, :]) @ axes.T
    angles = np.sort(np.arctan2(seen[..., 1], seen[..., 0]), axis=1)
    gaps = np.diff(angles, axis=1, append=angles[:, :1] + 2.0 * np.pi)
    surrounded: NDArray[np.bool_] = gaps.max(axis=1) <= np.pi * (1.0 + 1e-9)
    return surrounded


class ContactSensors(BodyHandle):
    """What contact does to a body; a part of ``Body``."""

    @property
    def positions(self) -> Array:
        raise NotImplementedError

    @property
    def triangles(self) -> Ints:
        raise NotImplementedError

    def contacts(self, other: BodyHandle | str | None = None) -> Contacts:
        """Contacts with everything, or with another body; this body is the first of each pair."""
        return contacts_of(self._require_simulation("contacts")).of(self, other)

    @property
    def contact_force(self) -> Array:
        """Sum of all contact forces on the body, friction included (3,) [N]."""
        found = _core.contact_force(self._require_simulation("contact_force")._core, self._index)
        return reading(found, self, "contact_force", assign=_OWN_FORCE)

    @property
    def contact_forces(self) -> Array:
        """Contact forces on each vertex, friction included (n, 3) [N]."""
        found = _core.vertex_contact_forces(self._require_simulation("contact_forces")._core, self._index)
        return reading(found, self, "contact_forces")

    def contact_area(self, other: BodyHandle | str | None = None) -> float:
        """Area of the triangles all of whose vertices touch something, or another body [m^2]. The resolution
        is that of the mesh: of two bodies, ask the finer one. Raises InvalidArgument for rods, which have no
        triangles."""
        self._require_triangles("contact_area")
        contacts = self.contacts(other)
        touching = touched(contacts, self._flat_patches(contacts), self.triangles, len(self.positions))
        return float(areas_of(self.positions, self.triangles)[touching].sum())

    def contact_pressure(self, other: BodyHandle | str | None = None) -> Array:
        """Normal contact force over the area that belongs to each vertex (n,) [Pa]: a third of its triangles,
        or of those that touch where there are any; of hexahedra and quadratic tetrahedra what their shape
        functions have of their faces. With 27 nodes, pressures are bilinear in each face, and nodes show the
        mean of their faces. Flat faces of rigid bodies that have vertices inside them show their mean: how a
        rigid face shares its load is not determined. Raises InvalidArgument for rods, which have no
        triangles."""
        self._require_triangles("contact_pressure")
        return self._pressure_of(self.contacts(other))

    def _pressure_of(self, contacts: Contacts) -> Array:
        """That of contacts with this body as the first of each pair."""
        patches = self._flat_patches(contacts)
        return pressure_on(self.positions, self.triangles, contacts, patches, self.mesh)

    def _require_triangles(self, what: str) -> None:
        if len(self.triangles) == 0:
            raise InvalidArgument(
                f"'{self.name}': {what}: a {self.kind} has no triangles: must be a body with a surface; ask "
                f"the other body, or read contact_forces, those on its nodes [N]"
            )

    def _inner_vertices(self) -> Ints:
        """Vertices inside flat faces of a rigid body, which have no contacts."""
        return _core.inner_vertices(self._require_simulation("contacts")._core, self._index)

    def _flat_patches(self, contacts: Contacts) -> list[Ints]:
        """Vertices of each flat face of a rigid body that lie within the points where it touches. Its inner
        vertices have no contacts: they touch where contacts surround them."""
        inner = self._inner_vertices()
        patches = []
        while len(inner) > 0 and len(contacts) > 0:
            normal = self._normal_at(inner[0])
            height = (self.positions - self.positions[inner[0]]) @ normal
            tolerance = _FLAT * np.ptp(self.positions, axis=0).max()
            face = inner[np.abs(height[inner]) <= tolerance]
            inner = np.setdiff1d(inner, face)
            level = (contacts.points_a - self.positions[face[0]]) @ normal
            here = (np.abs(level) <= tolerance) & (np.abs(contacts.normals @ normal) > _ALONG)
            surrounded = _surrounded(self.positions[face], contacts.points_a[here], normal)
            if surrounded.any():
                corners = contacts.vertices[here][contacts.weights[here] > 1.0 - 1e-9]
                patches.append(np.union1d(face[surrounded], corners))
        return patches

    def _normal_at(self, vertex: int) -> Array:
        a, b, c = self.positions[self.triangles[(self.triangles == vertex).any(axis=1)][0]]
        normal = np.cross(b - a, c - a)
        unit: Array = normal / np.linalg.norm(normal)
        return unit


class InertialSensors(BodyHandle):
    """What a rigid body feels; a part of ``RigidBody``."""

    @property
    def contact_torque(self) -> Array:
        """Sum of the torques of all contact forces on the body about its centre of mass, friction included
        (3,) [N m]; of fixed and scripted bodies about the origin of their mesh."""
        position, rotation = self._require_simulation("contact_torque")._core.pose(self._index)
        center = position + rotation @ np.array(self._scene._core.inertia(self._index)["center_of_mass"])
        return reading(self.contact_torque_about(center), self, "contact_torque", assign=_OWN_TORQUE)

    def contact_torque_about(self, point: ArrayLike) -> Array:
        """The same about a point of the world [m]."""
        core = self._require_simulation("contact_torque_about")._core
        arms = core.positions(self._index) - vector(point, f"'{self.name}': contact_torque_about: point")
        found: Array = np.cross(arms, _core.vertex_contact_forces(core, self._index)).sum(axis=0)
        return found

    @property
    def holding_force(self) -> Array:
        """Force that holds a fixed body or drives a scripted one in the last step, against contact, joints,
        attachments and energies (3,) [N]; zero of bodies that move freely. Fixed and scripted bodies have no
        mass, so their own weight is not in it."""
        core = self._require_simulation("holding_force")._core
        return reading(core.holding_wrench(self._index)[0], self, "holding_force")

    @property
    def holding_torque(self) -> Array:
        """Torque that does so, about the origin of the mesh (3,) [N m], world axes."""
        core = self._require_simulation("holding_torque")._core
        return reading(core.holding_wrench(self._index)[1], self, "holding_torque")

    def acceleration(self, point: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
        """Acceleration of a point, given in the frame of the mesh [m]: change of its velocity over the last
        step (3,) [m/s^2], world axes."""
        core = self._require_simulation("acceleration")._core
        return core.acceleration(self._index, vector(point, "acceleration: point"))

    def imu(self, point: ArrayLike = (0.0, 0.0, 0.0), *, rotation: ArrayLike | None = None) -> Imu:
        """Reading of an inertial measurement unit at ``point`` [m] of the frame of the mesh, whose axes are
        those of the mesh turned by ``rotation``."""
        core = self._require_simulation("imu")._core
        axes = core.pose(self._index)[1]
        if rotation is not None:
            axes = axes @ as_matrix(rotation, "imu: rotation")
        felt = self.acceleration(point) - core.gravity
        return Imu(axes.T @ felt, axes.T @ core.twist(self._index)[1])
